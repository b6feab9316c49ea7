//! Decision how the shaders of a device process vertices, when the device is made.

use crate::intercept::scene::obstacle::Obstacle;
use crate::intercept::vk::state::views::vertices::{VertexDecision, VertexProcessing};
use crate::rig::{Method, Rig};

const LATER: &str = "primitives are divided after a new start";
/// Reason: the device cannot divide.
pub const NO_STAGE: &str = "the device has no geometry shaders, primitives are not divided";
/// Reason: the geometry stage cannot be enabled beside the features of the program.
pub const NO_WAY: &str = "the program enables device features in an unknown way, so primitives are not divided";

/// Decides how shaders process vertices. `offered` returns whether the device's geometry shaders
/// can count, or the reason why there are none. `rig`: the rig at the start. Shaders are made for
/// it, even if its file changes later.
pub fn decide(rig: Option<&Rig>, offered: impl FnOnce() -> Result<bool, Obstacle>) -> VertexDecision {
    let asks = |wanted: &dyn Fn(&Method) -> bool| {
        rig.is_some_and(|rig| rig.outputs.iter().any(|output| wanted(&output.method)))
    };
    let projects = asks(&|method| method.projects_vertices() && !method.divides());
    let without = if projects { VertexProcessing::Projected } else { VertexProcessing::Views };
    if !asks(&Method::divides) {
        return VertexDecision { vertices: without, undivided: Some(LATER.into()), counts: false };
    }
    match offered() {
        Ok(counts) => VertexDecision { vertices: VertexProcessing::Divided, undivided: None, counts },
        Err(why) => VertexDecision { vertices: without, undivided: Some(why), counts: false },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rig(methods: &[&str]) -> Rig {
        let mut rig = crate::rig::load("planetarium-6").expect("a preset");
        for (output, method) in rig.outputs.iter_mut().zip(methods) {
            output.method = Method::parse(method).expect("a method");
        }
        rig
    }

    #[test]
    fn a_device_without_the_stage_draws_views() {
        let decided = |methods: &[&str], offered| decide(Some(&rig(methods)), || offered);
        let refused = || Err(NO_STAGE.into());
        let undivided = Some(NO_STAGE.into());
        let without = VertexDecision { vertices: VertexProcessing::Views, undivided, counts: false };
        assert_eq!(decided(&["primitive"], refused()), without);
        assert_eq!(decided(&["primitive", "vertex"], refused()).vertices, VertexProcessing::Projected);
        assert_eq!(decided(&["primitive", "vertex"], Ok(true)).vertices, VertexProcessing::Divided);
        for counts in [true, false] {
            let divided = VertexDecision { vertices: VertexProcessing::Divided, undivided: None, counts };
            assert_eq!(decided(&["primitive-tessellation"], Ok(counts)), divided);
        }
    }

    #[test]
    fn nothing_is_asked_of_a_device_where_the_rig_asks_for_nothing() {
        let decided = |rig: Option<&Rig>| decide(rig, || panic!("the device is not asked"));
        assert_eq!(
            decided(None),
            VertexDecision { vertices: VertexProcessing::Views, undivided: Some(LATER.into()), counts: false }
        );
        assert_eq!(decided(Some(&rig(&["fragment"]))).vertices, VertexProcessing::Views);
        assert_eq!(decided(Some(&rig(&["vertex"]))).vertices, VertexProcessing::Projected);
    }
}
