//! Tests of recording between Begin and End.

use crate::intercept::gl::state::compat::vertex_commands::VertexCommand;
use crate::intercept::gl::state::compat::vertex_recorder::{Recorder, Sets};

#[test]
fn what_comes_only_after_a_vertex_is_late() {
    let mut recorder = Recorder::default();
    recorder.push(VertexCommand::color3fv, Sets::Color, &[], &[1.0f32; 3]);
    recorder.push(VertexCommand::vertex3fv, Sets::Position, &[], &[1.0f32; 3]);
    recorder.push(VertexCommand::color3fv, Sets::Color, &[], &[0.0f32; 3]);
    assert_eq!((recorder.sets_late(), recorder.sets_others_late()), ([false; 3], false));
    recorder.push(VertexCommand::normal3fv, Sets::Normal, &[], &[0.0f32; 3]);
    recorder.push(VertexCommand::multi_tex_coord2fv, Sets::TextureUnit, &[0x84C0], &[0.0f32; 2]);
    assert_eq!((recorder.sets_late(), recorder.sets_others_late()), ([false, true, true], false));
    recorder.push(VertexCommand::vertex_attrib1fv, Sets::Generic, &[3], &[0.0f32]);
    assert!(recorder.sets_others_late());
    recorder.clear();
    assert!(!recorder.sets_anything() && !recorder.sets_others_late());
}

#[test]
fn materials_and_high_numbers_are_always_late() {
    for (sets, prefix) in [(Sets::Material, [0x408, 0x1600]), (Sets::Generic, [999, 0])] {
        let mut recorder = Recorder::default();
        recorder.push(VertexCommand::vertex_attrib4fv, sets, &prefix, &[0.0f32; 4]);
        assert!(recorder.sets_others_late(), "{sets:?}");
    }
}

/// Numbers of all types are read back unchanged, and integers as parts of 1 if they are
/// normalised.
#[test]
fn commands_can_be_read() {
    let mut recorder = Recorder::default();
    recorder.push(VertexCommand::color4ubv, Sets::Color, &[], &[255u8, 0, 51, 255]);
    recorder.push(VertexCommand::multi_tex_coord2dv, Sets::TextureUnit, &[0x84C1], &[0.25f64, -3.0]);
    recorder.push(VertexCommand::normal3sv, Sets::Normal, &[], &[i16::MAX, i16::MIN, 0]);
    recorder.push(VertexCommand::vertex2iv, Sets::Position, &[], &[7i32, -9]);
    recorder.push(VertexCommand::color_p3uiv, Sets::Color, &[], &[7u32]);
    let read: Vec<_> = recorder
        .commands()
        .map(|command| {
            let numbers = |parts| (0..5).map_while(|i| command.number(i, parts)).collect::<Vec<_>>();
            (command.sets, command.prefix, command.is_vertex(), command.plain, numbers(false), numbers(true))
        })
        .collect();
    assert_eq!(read[0].5, [1.0, 0.0, 0.2, 1.0]);
    assert_eq!((read[1].0, read[1].1, &read[1].4), (Sets::TextureUnit, 0x84C1, &vec![0.25, -3.0]));
    assert_eq!((read[2].5[0], read[2].5[1], read[2].4[1]), (1.0, -1.0, f64::from(i16::MIN)));
    assert_eq!((read[3].2, read[3].3, &read[3].4), (true, true, &vec![7.0, -9.0]));
    assert!(!read[4].3 && read.len() == 5, "packed numbers are not plain");
}

/// `Sets::ALL` is in the order of the numbers.
#[test]
fn what_is_set_is_found_by_its_number() {
    for (number, sets) in Sets::ALL.into_iter().enumerate() {
        assert_eq!(sets as usize, number, "{sets:?}");
    }
}

#[test]
fn a_list_may_set_anything() {
    let mut recorder = Recorder::default();
    recorder.push_list(0xFFFF_FFFE);
    assert!(recorder.has_lists() && recorder.sets_others_late() && recorder.sets_late() == [true; 3]);
    assert!(recorder.commands().all(|command| command.is_vertex() && command.number(0, false).is_none()));
    recorder.clear();
    assert!(!recorder.has_lists() && !recorder.sets_anything());
}

#[test]
fn generic_attribute_0_is_a_vertex() {
    assert!(Sets::Generic.is_vertex(&[0]) && !Sets::Generic.is_vertex(&[1]));
    assert!(!Sets::Color.is_vertex(&[]));
}

/// The next Begin/End uses the memory of the one before.
#[test]
fn nothing_is_allocated_again() {
    let mut recorder = Recorder::default();
    let fill = |recorder: &mut Recorder| {
        for _ in 0..100 {
            recorder.push(VertexCommand::vertex_attrib4_nubv, Sets::ConvertedGeneric, &[0], &[1u8, 2, 3, 4]);
        }
    };
    fill(&mut recorder);
    let (length, memory) = (recorder.place(), recorder.words.as_ptr());
    assert_eq!(length, 300);
    recorder.clear();
    fill(&mut recorder);
    assert_eq!((recorder.place(), recorder.words.as_ptr()), (length, memory));
}
