//! Fetches and sizes of images, in handmade modules.

use super::module;
use crate::intercept::vk::spirv::module::instructions;
use crate::intercept::vk::spirv::texels;
use crate::testing::random::Random;
use spirv::{BuiltIn, Decoration, Dim, ExecutionModel, ImageOperands, Op, StorageClass};

/// A fragment stage whose function does `body`. Ids: FragCoord 5; an image in set 1 at binding 6:
/// 16; type of two integers 13, of two unsigned ones 18; a constant pair 14.
fn stage(body: &[(u32, &[u32])], fetched_from: Dim) -> Vec<u32> {
    let (input, constant) = (StorageClass::Input as u32, StorageClass::UniformConstant as u32);
    let builtin = [5, Decoration::BuiltIn as u32, BuiltIn::FragCoord as u32];
    let point = [ExecutionModel::Fragment as u32, 7, u32::from_le_bytes(*b"go\0\0"), 5];
    let image = [15, 2, fetched_from as u32, 0, 0, 0, 1, 0];
    let mut all: Vec<(u32, &[u32])> = vec![
        (Op::Capability as u32, &[1]),
        (Op::MemoryModel as u32, &[0, 1]),
        (Op::EntryPoint as u32, &point),
        (Op::ExecutionMode as u32, &[7, 7]),
        (Op::Decorate as u32, &builtin),
        (Op::Decorate as u32, &[16, Decoration::DescriptorSet as u32, 1]),
        (Op::Decorate as u32, &[16, Decoration::Binding as u32, 6]),
        (Op::TypeVoid as u32, &[1]),
        (Op::TypeFloat as u32, &[2, 32]),
        (Op::TypeVector as u32, &[3, 2, 4]),
        (Op::TypeInt as u32, &[11, 32, 1]),
        (Op::TypeInt as u32, &[19, 32, 0]),
        (Op::TypeVector as u32, &[13, 11, 2]),
        (Op::TypeVector as u32, &[18, 19, 2]),
        (Op::Constant as u32, &[11, 12, 3]),
        (Op::ConstantComposite as u32, &[13, 14, 12, 12]),
        (Op::TypeImage as u32, &image),
    ];
    let (of_input, of_image) = ([4, input, 3], [17, constant, 15]);
    let (variable, picture) = ([4, 5, input], [17, 16, constant]);
    all.extend([(Op::TypePointer as u32, &of_input[..]), (Op::TypePointer as u32, &of_image)]);
    all.extend([(Op::Variable as u32, &variable[..]), (Op::Variable as u32, &picture)]);
    all.extend([
        (Op::TypeFunction as u32, &[6, 1][..]),
        (Op::Function as u32, &[1, 7, 0, 6]),
        (Op::Label as u32, &[8]),
    ]);
    all.extend(body);
    all.extend([(Op::Return as u32, &[][..]), (Op::FunctionEnd as u32, &[])]);
    module(60, &all)
}

const LOAD: (u32, &[u32]) = (Op::Load as u32, &[15, 20, 16]);
const FETCH: (u32, &[u32]) = (Op::ImageFetch as u32, &[3, 21, 20, 14]);
const SIZE: (u32, &[u32]) = (Op::ImageQuerySizeLod as u32, &[18, 22, 20, 12]);

#[test]
fn coordinates_and_sizes_go_through_functions_of_ours() {
    let followed =
        texels(&stage(&[LOAD, FETCH, SIZE], Dim::Dim2D), "go", 3, 64).expect("followed").expect("it fetches");
    assert_eq!(followed.pictures, [(1, 6)]);
    let all = instructions(&followed.words).expect("a module");
    let fetch = all.iter().find(|i| i.is(Op::ImageFetch)).expect("it stays");
    let call = all.iter().find(|i| i.is(Op::FunctionCall) && i.operand(1) == fetch.operand(3)).expect("a call");
    assert_eq!((call.operand(0), call.operand(3)), (13, 14), "of the program's coordinates");
    // The program uses the result of Cupola, in the program's type.
    let cast = all.iter().find(|i| i.is(Op::Bitcast) && i.operand(1) == 22).expect("the size");
    assert!(all.iter().any(|i| i.is(Op::FunctionCall) && i.operand(1) == cast.operand(2)));
    let queries: Vec<_> = all.iter().filter(|i| i.is(Op::ImageQuerySizeLod)).map(|i| i.operand(1)).collect();
    assert!(queries.len() == 2 && !queries.contains(&22), "{queries:?}");
    assert!(all.iter().any(|i| i.is(Op::MemberDecorate) && i.rest(1) == [1, Decoration::Offset as u32, 80]));
}

#[test]
fn what_reads_by_texture_coordinates_is_left() {
    for (body, kind) in [(&[LOAD][..], Dim::Dim2D), (&[LOAD, FETCH], Dim::DimCube), (&[], Dim::Dim2D)] {
        assert!(matches!(texels(&stage(body, kind), "go", 3, 64), Ok(None)));
    }
}

/// Returns the operands of the fetch, and those of the addition that computes its coordinates.
fn fetched_at(fetch: &[u32]) -> (Vec<u32>, Vec<u32>) {
    let words = stage(&[LOAD, (Op::ImageFetch as u32, fetch)], Dim::Dim2D);
    let followed = texels(&words, "go", 3, 64).expect("followed").expect("it fetches");
    let all = instructions(&followed.words).expect("a module");
    let fetch = all.iter().find(|i| i.is(Op::ImageFetch)).expect("it stays");
    let call = all.iter().find(|i| i.is(Op::FunctionCall) && i.operand(1) == fetch.operand(3)).expect("a call");
    let sum = all.iter().find(|i| i.is(Op::IAdd) && i.operand(1) == call.operand(3)).expect("a sum");
    (fetch.rest(4).to_vec(), sum.rest(2).to_vec())
}

/// An offset is in texels of the program.
#[test]
fn offsets_are_added_to_the_coordinates_before() {
    let (level, gradients) = (ImageOperands::LOD.bits(), ImageOperands::GRAD.bits());
    let (constant, variable) = (ImageOperands::CONST_OFFSET.bits(), ImageOperands::OFFSET.bits());
    assert_eq!(fetched_at(&[3, 21, 20, 14, level | constant, 12, 14]), (vec![level, 12], vec![14, 14]));
    assert_eq!(fetched_at(&[3, 21, 20, 14, variable, 14]), (vec![0], vec![14, 14]));
    assert_eq!(fetched_at(&[3, 21, 20, 14, gradients | constant, 8, 9, 14]), (vec![gradients, 8, 9], vec![14, 14]));
    for unknown in [&[3, 21, 20, 14, constant, 40][..], &[3, 21, 20, 14, constant]] {
        assert!(texels(&stage(&[LOAD, (Op::ImageFetch as u32, unknown)], Dim::Dim2D), "go", 3, 64).is_err());
    }
}

#[test]
fn images_that_are_not_known_are_refused() {
    let unknown: (u32, &[u32]) = (Op::ImageFetch as u32, &[3, 23, 30, 14]);
    assert!(texels(&stage(&[LOAD, FETCH, unknown], Dim::Dim2D), "go", 3, 64).is_err());
    assert!(texels(&stage(&[unknown], Dim::Dim2D), "go", 3, 64).is_err(), "no other is known");
}

/// A damaged module does no harm.
#[test]
fn damaged_modules_do_no_harm() {
    let words = stage(&[LOAD, FETCH, SIZE], Dim::Dim2D);
    let mut random = Random::new(5);
    for _ in 0..3000 {
        let mut damaged = words.clone();
        for _ in 0..2 {
            let at = random.below(damaged.len());
            damaged[at] ^= 1 << random.below(32);
        }
        let _ = texels(&damaged, "go", 3, 64);
    }
}
