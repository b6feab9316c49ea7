//! Correction methods: what each of them draws, and its map.

use super::peers;
use super::processor::Processor;
use super::quality;
use super::scenes::Scene;
use crate::failure::Failure;
use crate::planning::request;
use crate::trial;
use crate::trial::gl::{Sampling, Trial, TrialMesh};
use cupola::backend::gl;
use cupola::correct::{self, Plan, Source};
use cupola::correct::{Table, TablePixel};
use cupola::formats::{Grid, Mesh, Node};
use cupola::rig::{Filter, OutputKind, Rig};
use cupola::views::ViewPlan;
use cupola::warp::TracedMap;
use glam::{DVec2, DVec3};
use std::sync::Arc;

/// Direction in the viewer's axes of each pixel, row by row from the top; `None` where nothing is
/// shown.
pub type Directions = Vec<Option<DVec3>>;

/// Clock that measures the time of a method.
pub enum Clock {
    /// By the trial on OpenGL, under this number.
    OpenGl(usize),
    /// By the trial on Vulkan, under this number.
    Vulkan(usize),
    /// By running it on the processor.
    Processor(Box<Processor>),
}

/// A correction method that takes part in the measurement.
pub struct Method {
    /// Name of the method.
    pub name: String,
    /// True if this is Cupola's default.
    pub is_default: bool,
    /// Clock that measures its time.
    pub clock: Clock,
    /// Number of texels of the views that it needs, divided by the number of output pixels.
    pub texels: Option<f64>,
    /// Its map; `None` for methods that correct nothing.
    pub map: Option<Directions>,
}

impl Method {
    /// Its grey picture of the scene; `None` for methods that correct nothing, and on Vulkan, whose
    /// shaders are the same as on OpenGL.
    pub fn picture(&self, trial: &Trial) -> Result<Option<Vec<u8>>, Failure> {
        Ok(match &self.clock {
            _ if self.map.is_none() => None,
            Clock::OpenGl(number) => Some(trial.picture(*number)?.into_iter().map(|pixel| pixel[0]).collect()),
            Clock::Vulkan(_) => None,
            Clock::Processor(processor) => Some(processor.picture()),
        })
    }
}

/// All methods that are measured on one scene.
pub struct Entrants {
    /// Methods on OpenGL.
    pub trial: Trial,
    /// Methods on Vulkan, if there is a device.
    pub vulkan: Option<trial::vk::Trial>,
    /// The methods. The first is the plain picture whose time is the unit of time.
    pub methods: Vec<Method>,
    /// Atlases that are drawn, with their views: several methods have the same.
    atlases: Vec<(ViewPlan, Vec<Vec<u32>>)>,
    /// Pictures of the methods of other programs that are drawn.
    pictures: Vec<(Sampling, Vec<Vec<u32>>)>,
}

/// Bounds on the error of tables and meshes in pixels.
const BOUNDS: [f64; 3] = [0.5, 0.1, 0.02];
/// Numbers of cells along an edge of the cube in meshes of the dome.
const DENSITIES: [u32; 4] = [16, 32, 64, 128];
/// Filters other than the default.
const FILTERS: [(&str, Filter); 3] = [
    ("fragment, Catmull-Rom", Filter::CatmullRom),
    ("fragment, four places", Filter::Bilinear4),
    ("fragment, Catmull-Rom at four places", Filter::CatmullRom4),
];
/// Numbers of columns of uniform meshes.
const COLUMNS: [u32; 3] = [16, 64, 256];

impl Entrants {
    /// All methods for `scene`.
    pub fn new(scene: &Scene, exact: &TracedMap) -> Result<Self, Failure> {
        let vulkan = trial::vk::Trial::new(scene.size).ok();
        let trial = Trial::new(scene.size)?;
        let mut this = Self { trial, vulkan, methods: Vec::new(), atlases: Vec::new(), pictures: Vec::new() };
        let (width, height) = scene.size;
        let number = this.trial.add_mesh(&TrialMesh::quad(), &Sampling::Picture(width, height))?;
        this.add("one bilinear picture", Clock::OpenGl(number), None, None);
        let plan = plan(&scene.rig, scene)?;
        this.add_plan("fragment (default)", &plan)?;
        this.methods.iter_mut().skip(1).for_each(|method| method.is_default = true);
        this.add_vulkan("fragment, Vulkan", &plan)?;
        this.add_half(scene)?;
        for method in ["table", "mesh"] {
            for bound in BOUNDS {
                let name = format!("{method}, at most {bound} px");
                let plan = self::plan(&scene.rig.with_method_override(&format!("{method},max_error={bound}"))?, scene)?;
                this.add_plan(&name, &plan)?;
                if bound == BOUNDS[1] {
                    this.add_vulkan(&format!("{name}, Vulkan"), &plan)?;
                }
            }
        }
        for density in DENSITIES {
            let rig = scene.rig.with_method_override(&format!("cube-mesh,density={density}"))?;
            this.add_plan(&format!("cube-mesh, {density} cells"), &self::plan(&rig, scene)?)?;
        }
        if scene.rig.outputs.len() == 1 {
            this.add_plan("table, every pixel", &tabulated(&plan, scene, exact))?;
            for (name, filter) in FILTERS {
                let mut rig = scene.rig.clone();
                rig.views.filter = filter;
                this.add_plan(name, &self::plan(&rig, scene)?)?;
            }
            let processor = Processor::new(&plan, &quality::atlas(&plan));
            let map = processor.directions();
            this.add("fragment, processor alone", Clock::Processor(Box::new(processor)), texels(&plan), Some(map));
            this.add_others(scene, exact, &plan)?;
        }
        Ok(this)
    }

    fn add(&mut self, name: &str, clock: Clock, texels: Option<f64>, map: Option<Directions>) {
        self.methods.push(Method { name: name.into(), is_default: false, clock, texels, map });
    }

    /// Adds Cupola's correction with `plan`.
    fn add_plan(&mut self, name: &str, plan: &Plan) -> Result<(), Failure> {
        let (number, _) = self.trial.add_plan(plan)?;
        let drawn = drawn_once(&mut self.atlases, &plan.views, || Ok(vec![quality::atlas(plan)]))?;
        self.trial.fill(number, drawn)?;
        let context = self.trial.context();
        let map = gl::gpu_map(&context.gl, context.is_gles, plan, 0)?;
        self.add(name, Clock::OpenGl(number), texels(plan), Some(directions(&map)));
        Ok(())
    }

    /// Adds Cupola's correction with a mask that blacks out the left half. Only its time is
    /// measured.
    fn add_half(&mut self, scene: &Scene) -> Result<(), Failure> {
        let mask = std::env::temp_dir().join(format!("cupola-bench-{}.png", std::process::id()));
        let (width, height) = scene.size;
        let picture =
            image::GrayImage::from_fn(width, height, |x, _| image::Luma([if 2 * x < width { 0 } else { 255 }]));
        let failed = |error: image::ImageError| Failure::new(format!("{} cannot be written: {error}", mask.display()));
        picture.save(&mask).map_err(failed)?;
        let mut rig = scene.rig.clone();
        rig.outputs[0].mask = Some(mask.clone());
        let plan = plan(&rig, scene);
        // A file that cannot be removed does no harm.
        let _ = std::fs::remove_file(&mask);
        let plan = plan?;
        let (number, _) = self.trial.add_plan(&plan)?;
        self.add("fragment, half of it masked", Clock::OpenGl(number), texels(&plan), None);
        Ok(())
    }

    /// Adds Cupola's correction with `plan` on Vulkan, if there is a device.
    fn add_vulkan(&mut self, name: &str, plan: &Plan) -> Result<(), Failure> {
        let Some(vulkan) = &mut self.vulkan else { return Ok(()) };
        let number = vulkan.add_plan(plan)?;
        let map = vulkan.map(plan)?;
        self.add(name, Clock::Vulkan(number), texels(plan), Some(directions(&map)));
        Ok(())
    }

    /// Adds the methods of other programs.
    fn add_others(&mut self, scene: &Scene, exact: &TracedMap, plan: &Plan) -> Result<(), Failure> {
        let (width, height) = scene.size;
        // Resolution of cube faces that the centre of a domemaster or projector needs.
        let side = plan.views.views.iter().map(|view| view.tile.width.max(view.tile.height)).max().unwrap_or(1);
        for columns in COLUMNS {
            let rows = (columns * height).div_ceil(width);
            let name = format!("even mesh of directions {columns}×{rows}, cube map");
            let mesh = direction_mesh(scene, exact, columns, rows);
            self.add_peer(scene, exact, peers::Peer { name, mesh, sampling: Sampling::Cube(side), texels: None })?;
        }
        for mesh in peers::meshes(scene, exact.exact(), side) {
            self.add_peer(scene, exact, mesh)?;
        }
        for formula in peers::formulas(scene, side) {
            self.add_formula(scene, exact, formula)?;
        }
        Ok(())
    }

    /// Adds a mesh. Its map is the linear interpolation of the values at its nodes.
    fn add_peer(&mut self, scene: &Scene, exact: &TracedMap, peer: peers::Peer) -> Result<(), Failure> {
        let mut drawn = TrialMesh { corners: Vec::new(), triangles: peer.mesh.triangles().to_vec() };
        for node in peer.mesh.nodes() {
            let [x, y] = node.position.as_vec2().to_array();
            let [u, v, w] = node.value.as_vec3().to_array();
            drawn.corners.push([x, y, u, v, w]);
        }
        let number = self.trial.add_mesh(&drawn, &peer.sampling)?;
        self.fill(number, scene, &peer.sampling)?;
        let direction = meaning(scene, &peer.sampling)?;
        let grid = Grid::Stretched(peer.mesh);
        let map = each_pixel(exact, |pixel| direction(grid.sample(pixel, scene.size)?.value));
        self.add(&peer.name, Clock::OpenGl(number), peer.texels, Some(map));
        Ok(())
    }

    /// Adds a formula. Its map is what the driver computes.
    fn add_formula(&mut self, scene: &Scene, exact: &TracedMap, formula: peers::Formula) -> Result<(), Failure> {
        let number = self.trial.add_mesh(&TrialMesh::quad(), &formula.sampling)?;
        self.fill(number, scene, &formula.sampling)?;
        let places = self.trial.coordinates(&TrialMesh::quad(), &formula.sampling)?;
        let direction = meaning(scene, &formula.sampling)?;
        let map = each_pixel(exact, |pixel| {
            let [x, y, z, _] = places[pixel.y as usize * scene.size.0 as usize + pixel.x as usize].map(f64::from);
            let value = DVec3::new(x, y, z);
            // Values that are not finite are kept, to be counted.
            if value.is_finite() { direction(value) } else { Some(value) }
        });
        self.add(&formula.name, Clock::OpenGl(number), formula.texels, Some(map));
        Ok(())
    }

    /// Draws the scene into the textures that a method samples.
    fn fill(&mut self, number: usize, scene: &Scene, sampling: &Sampling) -> Result<(), Failure> {
        let sampled = sampling.picture();
        let drawn = drawn_once(&mut self.pictures, sampled, || {
            Ok(match *sampled {
                Sampling::Cube(side) => quality::cube(side),
                Sampling::Picture(width, height) => {
                    vec![quality::domemaster((width, height), &peers::domemaster(scene)?)]
                }
                Sampling::Formula(..) => Vec::new(),
            })
        })?;
        Ok(self.trial.fill(number, drawn)?)
    }
}

/// The pictures under a key; `draw` draws those that are missing.
fn drawn_once<'a, K: Clone + PartialEq>(
    drawn: &'a mut Vec<(K, Vec<Vec<u32>>)>,
    key: &K,
    draw: impl FnOnce() -> Result<Vec<Vec<u32>>, Failure>,
) -> Result<&'a [Vec<u32>], Failure> {
    let index = match drawn.iter().position(|(of, _)| of == key) {
        Some(index) => index,
        None => {
            drawn.push((key.clone(), draw()?));
            drawn.len() - 1
        }
    };
    Ok(&drawn[index].1)
}

/// A plan for the outputs of a rig, all of the scene's size.
fn plan(rig: &Rig, scene: &Scene) -> Result<Plan, Failure> {
    let request = request(vec![scene.size; rig.outputs.len()], scene.size);
    Ok(correct::build(rig, &request)?)
}

/// Number of texels of the views that the first output of a plan samples, divided by its number of
/// pixels.
fn texels(plan: &Plan) -> Option<f64> {
    let pass = &plan.passes[0];
    let views: std::collections::BTreeSet<usize> =
        pass.batches.iter().flat_map(|batch| &batch.views).copied().collect();
    let texels = views.into_iter().map(|view| {
        let tile = &plan.views.views[view].tile;
        f64::from(tile.width) * f64::from(tile.height)
    });
    Some(texels.sum::<f64>() / f64::from(pass.size.0) / f64::from(pass.size.1))
}

/// The directions of a map.
fn directions(map: &[gl::MapPixel]) -> Directions {
    let direction = |pixel: &gl::MapPixel| pixel.view.map(|_| DVec3::from_array(pixel.direction.map(f64::from)));
    map.iter().map(direction).collect()
}

/// `plan` with a table of the exact map instead of the formula.
fn tabulated(plan: &Plan, scene: &Scene, exact: &TracedMap) -> Plan {
    let mut plan = plan.clone();
    let table = Table::new(scene.size, |column, row| {
        exact.direction(column, row).map(|direction| TablePixel { direction, weight: 1.0, dark: 0.0 })
    });
    plan.passes[0].source = Source::Table(Arc::new(table));
    plan
}

/// The function from a coordinate to a direction. A coordinate is a direction or a position in a
/// domemaster.
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

/// Values of a function at the centres of all pixels that show something in the exact map. Drawing
/// of other programs outside of a fisheye's circle is not an error.
fn each_pixel(exact: &TracedMap, at: impl Fn(DVec2) -> Option<DVec3>) -> Directions {
    let (width, height) = exact.exact().size();
    let at = &at;
    let row = move |y: u32| {
        let pixel = move |x: u32| DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
        (0..width).map(move |x| exact.direction(x, y).and_then(|_| at(pixel(x))))
    };
    (0..height).flat_map(row).collect()
}

/// A mesh with the exact directions at the nodes of a grid over the output. Outside of a fisheye's
/// circle the angle grows further.
fn direction_mesh(scene: &Scene, exact: &TracedMap, columns: u32, rows: u32) -> Mesh {
    peers::grid_mesh(columns, rows, |part| {
        let at = 2.0 * part - 1.0;
        let value = match &scene.rig.outputs[0].kind {
            OutputKind::Domemaster { aperture, .. } => {
                let (sine, cosine) = (0.5 * aperture * at.length()).sin_cos();
                (at.normalize_or_zero() * sine).extend(-cosine)
            }
            _ => {
                let exact = exact.exact();
                let size = DVec2::new(f64::from(exact.size().0), f64::from(exact.size().1));
                exact.direction(DVec2::new(part.x, 1.0 - part.y) * size)?
            }
        };
        Some(Node { position: at, value, intensity: 1.0 })
    })
}
