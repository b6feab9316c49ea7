//! Ways of correcting: what each draws, and the map that it makes.

use super::peers;
use super::scenes::Scene;
use crate::Failure;
use cupola::backend::gl;
use cupola::backend::gl::trial::{Sampling, Trial, TrialMesh};
use cupola::correct::table::{Table, TablePixel};
use cupola::correct::{self, Plan, Source};
use cupola::formats::{Grid, Mesh, Node};
use cupola::rig::OutputKind;
use cupola::views::Request;
use cupola::warp::WarpMap;
use glam::{DVec2, DVec3};
use std::sync::Arc;

/// Direction in viewer axes of each pixel, row by row from the top; `None` where nothing is shown.
pub type Directions = Vec<Option<DVec3>>;

/// A way of correcting that has been added to a trial.
pub struct Method {
    /// In words.
    pub name: String,
    /// Ours, as it is without being asked for anything.
    pub is_default: bool,
    /// Its number in the trial.
    pub number: usize,
    /// Texels of the views that are drawn for it, over the output's pixels.
    pub texels: Option<f64>,
    /// Its map; `None` for what corrects nothing.
    pub map: Option<Directions>,
}

/// Adds all methods for `scene`. The first is the picture that the others' times are measured in.
pub fn add_all(trial: &mut Trial, scene: &Scene, exact: &WarpMap) -> Result<Vec<Method>, Failure> {
    let mut methods = Vec::new();
    let (width, height) = scene.size;
    let pixels = f64::from(width) * f64::from(height);
    let number = trial.add_mesh(&TrialMesh::quad(), &Sampling::Picture(width, height))?;
    methods.push(Method { name: "one bilinear picture".into(), is_default: false, number, texels: None, map: None });
    let plan = plan(scene)?;
    methods.push(ours(trial, "fragment (default)", true, &plan, pixels)?);
    let blended = scene.rig.outputs.len() > 1;
    if !blended {
        methods.push(ours(trial, "table, every pixel", false, &tabulated(&plan, scene, exact), pixels)?);
        // Faces as fine as a domemaster's or a projector's middle needs.
        let side = plan.views.views.iter().map(|view| view.tile.width.max(view.tile.height)).max().unwrap_or(1);
        for columns in [16, 32, 64, 128, 256] {
            let rows = (columns * height).div_ceil(width);
            let name = format!("mesh of directions {columns}×{rows}");
            let mesh = peers::Peer {
                name,
                mesh: direction_mesh(scene, exact, columns, rows),
                sampling: Sampling::Cube(side),
                texels: None,
            };
            methods.push(peer(trial, scene, exact, mesh)?);
        }
        for mesh in peers::meshes(scene, exact, side) {
            methods.push(peer(trial, scene, exact, mesh)?);
        }
        for formula in peers::formulas(scene, side) {
            methods.push(shader(trial, scene, exact, formula)?);
        }
    }
    Ok(methods)
}

/// The plan of a scene's first output.
fn plan(scene: &Scene) -> Result<Plan, Failure> {
    let request = Request {
        output_sizes: vec![scene.size; scene.rig.outputs.len()],
        window: scene.size,
        panel: false,
        primary: false,
        max_atlas: crate::check::LARGEST_ATLAS,
    };
    Ok(correct::build(&scene.rig, &request)?)
}

/// `plan` with a table of the exact map in the place of the formula.
fn tabulated(plan: &Plan, scene: &Scene, exact: &WarpMap) -> Plan {
    let mut plan = plan.clone();
    let table = Table::new(scene.size, |column, row| {
        let pixel = DVec2::new(f64::from(column) + 0.5, f64::from(row) + 0.5);
        exact.direction(pixel).map(|direction| TablePixel { direction, weight: 1.0, dark: 0.0 })
    });
    plan.passes[0].source = Source::Table(Arc::new(table));
    plan
}

/// Our correction by `plan`.
fn ours(trial: &mut Trial, name: &str, is_default: bool, plan: &Plan, pixels: f64) -> Result<Method, Failure> {
    let (number, _) = trial.add_plan(plan)?;
    let context = trial.context();
    let map = gl::gpu_map(&context.gl, context.is_gles, plan, 0)?;
    let direction = |pixel: &gl::MapPixel| pixel.view.map(|_| DVec3::from_array(pixel.direction.map(f64::from)));
    let views = plan.passes[0].batches.iter().flat_map(|batch| &batch.views).copied();
    let views: std::collections::BTreeSet<usize> = views.collect();
    let tile = |view: usize| &plan.views.views[view].tile;
    let texels: f64 = views.into_iter().map(|view| f64::from(tile(view).width) * f64::from(tile(view).height)).sum();
    let map = Some(map.iter().map(direction).collect());
    Ok(Method { name: name.into(), is_default, number, texels: Some(texels / pixels), map })
}

/// A mesh that is drawn, and its map: what linear interpolation makes of its corners.
fn peer(trial: &mut Trial, scene: &Scene, exact: &WarpMap, peer: peers::Peer) -> Result<Method, Failure> {
    let mut drawn = TrialMesh { corners: Vec::new(), triangles: peer.mesh.triangles().to_vec() };
    for node in peer.mesh.nodes() {
        let [x, y] = node.position.as_vec2().to_array();
        let [u, v, w] = node.value.as_vec3().to_array();
        drawn.corners.push([x, y, u, v, w]);
    }
    let number = trial.add_mesh(&drawn, &peer.sampling)?;
    let direction = meaning(scene, &peer.sampling)?;
    let grid = Grid::Stretched(peer.mesh);
    let map = each_pixel(exact, |pixel| direction(grid.sample(pixel, scene.size)?.value));
    Ok(Method { name: peer.name, is_default: false, number, texels: peer.texels, map: Some(map) })
}

/// A formula, and its map: what the driver computes.
fn shader(trial: &mut Trial, scene: &Scene, exact: &WarpMap, formula: peers::Formula) -> Result<Method, Failure> {
    let number = trial.add_mesh(&TrialMesh::quad(), &formula.sampling)?;
    let places = trial.coordinates(&TrialMesh::quad(), &formula.sampling)?;
    let direction = meaning(scene, &formula.sampling)?;
    let map = each_pixel(exact, |pixel| {
        let [x, y, z, _] = places[pixel.y as usize * scene.size.0 as usize + pixel.x as usize].map(f64::from);
        let value = DVec3::new(x, y, z);
        // What is not finite is kept, to be counted.
        if value.is_finite() { direction(value) } else { Some(value) }
    });
    Ok(Method { name: formula.name, is_default: false, number, texels: formula.texels, map: Some(map) })
}

/// The direction of a coordinate: it is one, or a place in a domemaster.
fn meaning(scene: &Scene, sampling: &Sampling) -> Result<impl Fn(DVec3) -> Option<DVec3> + use<>, Failure> {
    let content = match sampling.picture() {
        Sampling::Picture(..) => Some(peers::domemaster(scene)?),
        _ => None,
    };
    Ok(move |value: DVec3| match &content {
        Some(content) => content.direction(DVec2::new(value.x, 1.0 - value.y)),
        None => Some(value),
    })
}

/// A function of pixel positions at the centres of all pixels that show something: what other programs draw outside of
/// a fisheye's circle is no error.
fn each_pixel(exact: &WarpMap, at: impl Fn(DVec2) -> Option<DVec3>) -> Directions {
    let (width, height) = exact.size();
    let at = &at;
    let row = move |y: u32| {
        let pixel = move |x: u32| DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
        (0..width).map(move |x| exact.direction(pixel(x)).and_then(|_| at(pixel(x))))
    };
    (0..height).flat_map(row).collect()
}

/// The exact directions at the nodes of a grid over the output; beyond a fisheye's circle its angle goes on growing.
fn direction_mesh(scene: &Scene, exact: &WarpMap, columns: u32, rows: u32) -> Mesh {
    peers::grid_mesh(columns, rows, |part| {
        let at = 2.0 * part - 1.0;
        let value = match &scene.rig.outputs[0].kind {
            OutputKind::Domemaster { aperture, .. } => {
                let (sine, cosine) = (0.5 * aperture * at.length()).sin_cos();
                (at.normalize_or_zero() * sine).extend(-cosine)
            }
            _ => exact.direction(
                DVec2::new(part.x, 1.0 - part.y) * DVec2::new(f64::from(exact.size().0), f64::from(exact.size().1)),
            )?,
        };
        Some(Node { position: at, value, intensity: 1.0 })
    })
}
