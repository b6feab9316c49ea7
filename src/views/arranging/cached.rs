//! Arrangements of views as bytes: choosing them is most of what a start computes, and depends on the rig and on the outputs' sizes
//! alone.

use crate::cache::{Cache, Reader, Writer};
use crate::error::Result;
use crate::geom::{Frustum, PictureLens, PictureMap};
use crate::rig::Rig;
use crate::views::arranging::choose;
use crate::views::arranging::planned_view::{Arrangement, Wanted};
use crate::views::fitting::fit::Fit;
use crate::views::sampling::output_map::Sight;
use glam::{DMat3, DVec2, DVec3};

/// [`choose::arrange`], or what `cache` kept of it.
pub(in crate::views) fn arrange(rig: &Rig, sights: &[Sight], cache: &Cache) -> Result<Arrangement> {
    let sizes: Vec<_> = sights.iter().map(|sight| sight.size).collect();
    cache.kept(
        "views",
        |key| key.debug(rig).debug(&sizes),
        |reader| read(reader, sights.len()),
        write,
        || choose::arrange(rig, sights),
    )
}

fn write(arrangement: &Arrangement, to: &mut Writer) -> bool {
    to.length(arrangement.views.len());
    for view in &arrangement.views {
        to.text(&view.name);
        view.rotation.to_cols_array().iter().for_each(|entry| to.f64(*entry));
        write_frustum(&view.fit.extent, to);
        write_pair(view.fit.density, to);
        to.bool(view.exact.is_some());
        if let Some((width, height)) = view.exact {
            to.u32(width);
            to.u32(height);
        }
        to.bool(view.program_lens);
        to.bool(view.curved.is_some());
        if let Some(map) = &view.curved {
            write_map(map, to);
        }
        to.f64(view.eye);
        to.length(view.outputs.len());
        view.outputs.iter().for_each(|output| to.u32(*output as u32));
    }
    to.length(arrangement.notes.len());
    arrangement.notes.iter().for_each(|note| to.text(note));
    true
}

fn write_frustum(frustum: &Frustum, to: &mut Writer) {
    [frustum.left, frustum.right, frustum.bottom, frustum.top].iter().for_each(|side| to.f64(*side));
}

fn write_pair(pair: DVec2, to: &mut Writer) {
    pair.to_array().iter().for_each(|value| to.f64(*value));
}

fn write_map(map: &PictureMap, to: &mut Writer) {
    [map.viewer, map.position].iter().flat_map(DVec3::to_array).for_each(|value| to.f64(value));
    to.bool(matches!(map.lens, PictureLens::Pinhole(_)));
    match &map.lens {
        PictureLens::Pinhole(frustum) => write_frustum(frustum, to),
        PictureLens::Fisheye { aperture, circle, pixels } => {
            to.f64(*aperture);
            write_pair(*circle, to);
            write_pair(*pixels, to);
        }
    }
}

/// An arrangement for so many outputs.
fn read(from: &mut Reader<'_>, outputs: usize) -> Option<Arrangement> {
    let views = from.length(1)?;
    let views = (0..views).map(|_| read_view(from, outputs)).collect::<Option<_>>()?;
    let notes = from.length(1)?;
    let notes = (0..notes).map(|_| from.text()).collect::<Option<_>>()?;
    Some(Arrangement { views, notes })
}

fn read_view(from: &mut Reader<'_>, outputs: usize) -> Option<Wanted> {
    Some(Wanted {
        name: from.text()?,
        rotation: DMat3::from_cols_array(&from.finites()?),
        fit: Fit { extent: read_frustum(from)?, density: DVec2::from_array(from.finites()?) },
        exact: if from.bool()? { Some((from.u32()?, from.u32()?)) } else { None },
        program_lens: from.bool()?,
        curved: if from.bool()? { Some(read_map(from)?) } else { None },
        eye: from.finite()?,
        outputs: {
            let count = from.length(size_of::<u32>())?;
            let output = |_| from.u32().map(|output| output as usize).filter(|output| *output < outputs);
            (0..count).map(output).collect::<Option<_>>()?
        },
    })
}

fn read_frustum(from: &mut Reader<'_>) -> Option<Frustum> {
    let [left, right, bottom, top] = from.finites()?;
    Some(Frustum { left, right, bottom, top })
}

fn read_map(from: &mut Reader<'_>) -> Option<PictureMap> {
    let (viewer, position) = (DVec3::from_array(from.finites()?), DVec3::from_array(from.finites()?));
    let lens = if from.bool()? {
        PictureLens::Pinhole(read_frustum(from)?)
    } else {
        let aperture = from.finite()?;
        let (circle, pixels) = (DVec2::from_array(from.finites()?), DVec2::from_array(from.finites()?));
        PictureLens::Fisheye { aperture, circle, pixels }
    };
    Some(PictureMap { viewer, position, lens })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rig::Method;
    use crate::testing::random::Random;
    use crate::views::tests::{fisheye, lens, projector, rig};
    use std::cell::Cell;

    fn sights(rig: &Rig, size: (u32, u32)) -> Vec<Sight> {
        (0..rig.outputs.len()).map(|index| Sight::new(rig, index, size).expect("a map")).collect()
    }

    #[test]
    fn what_is_kept_is_what_was_planned_to_the_bit() {
        let mut random = Random::new(5);
        let mut curved = 0;
        for round in 0..16 {
            let mut outputs = vec![fisheye(random.range(90.0, 240.0), random.range(0.0, 90.0))];
            if round % 2 == 0 {
                let at = random.vector(-0.5, 0.5);
                outputs.push(projector("p", at, [random.range(-180.0, 180.0), 20.0, 0.0], lens(50.0, 40.0)));
            }
            if round % 4 < 2 {
                outputs.iter_mut().for_each(|output| output.method = Method::Vertex);
            }
            outputs[0].eye = if round % 3 == 0 { 0.03 } else { 0.0 };
            let rig = rig(outputs);
            let sights = sights(&rig, (64, 48));
            let planned = choose::arrange(&rig, &sights).expect("a plan");
            curved += planned.views.iter().filter(|view| view.curved.is_some()).count();
            let mut writer = Writer::default();
            assert!(write(&planned, &mut writer));
            let bytes = writer.finish();
            let kept = read(&mut Reader::new(&bytes), sights.len()).expect("an arrangement");
            assert_eq!(format!("{planned:?}"), format!("{kept:?}"));

            // Whatever is cut off or changed is refused or read as something, and never the end of the program.
            for length in 0..bytes.len() {
                assert!(read(&mut Reader::new(&bytes[..length]), sights.len()).is_none(), "{length}");
            }
            for at in 0..bytes.len() {
                let mut other = bytes.clone();
                other[at] ^= 0xFF;
                read(&mut Reader::new(&other), sights.len());
            }
        }
        assert!(curved > 4, "{curved}");
    }

    #[test]
    fn another_rig_or_size_is_planned_anew() {
        let cache = Cache::in_memory();
        let planned = Cell::new(0);
        let plan = |rig: &Rig, size| {
            let before = cache.counts().missing;
            let sights = sights(rig, size);
            let kept = arrange(rig, &sights, &cache).expect("a plan");
            let fresh = choose::arrange(rig, &sights).expect("a plan");
            assert_eq!(format!("{kept:?}"), format!("{fresh:?}"));
            planned.set(planned.get() + cache.counts().missing - before);
        };
        let one = rig(vec![fisheye(180.0, 90.0)]);
        let mut other = one.clone();
        other.viewer.position.x = f64::MIN_POSITIVE;
        for _ in 0..2 {
            plan(&one, (64, 64));
            plan(&other, (64, 64));
            plan(&one, (64, 65));
        }
        assert_eq!(planned.get(), 3);
    }
}
