//! Recording of display lists: commands that Cupola stores beside the lists of the driver.

use crate::backend::gl::driver::api::{self, Gl};
use crate::correct::LowerLeftRect;
use crate::intercept::gl::context::gl_context::Context;
use crate::intercept::gl::context::gl_context::ShareGroup;
use crate::intercept::gl::context::list_names::ListNames;
use crate::intercept::gl::state::draw::bounds::Bounds;
use crate::intercept::gl::state::driver::Driver;
use crate::lock::Lock;
use glam::{DMat4, DVec3, DVec4};
use std::collections::HashMap;
use std::sync::Arc;

/// A command that runs once, not once per view.
#[derive(Clone, Debug, PartialEq)]
#[allow(missing_docs)] // Each is the OpenGL command of its name.
pub enum Command {
    MatrixMode(u32),
    LoadIdentity,
    LoadMatrix(DMat4),
    MultMatrix(DMat4),
    Frustum([f64; 6]),
    Ortho([f64; 6]),
    Rotate([f64; 4]),
    Scale([f64; 3]),
    Translate([f64; 3]),
    PushMatrix,
    PopMatrix,
    Viewport(LowerLeftRect),
    Scissor(LowerLeftRect),
    ScissorTest(bool),
    PushAttributes(u32),
    PopAttributes,
    UseProgram(u32),
    Clear(u32),
    DrawBuffer(u32),
    ReadBuffer(u32),
    RasterPosition(DVec4),
    WindowPosition(DVec3),
    CallList(u32),
    /// Offsets to be added to `glListBase` when the list runs.
    CallLists(Vec<u32>),
    ListBase(u32),
    Later(Later),
}

/// Any other command, as a function that is called when the list runs.
#[derive(Clone)]
pub struct Later(pub(in crate::intercept::gl) Arc<dyn Fn(&mut Context) + Send + Sync>);

impl std::fmt::Debug for Later {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("Later")
    }
}

impl PartialEq for Later {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }
}

/// Runs a command of the program: now or, while a list is being compiled, each time that list runs.
pub fn now_or_later(ctx: &mut Context, run: impl Fn(&mut Context) + Send + Sync + 'static) {
    if ctx.compiling() {
        record(&ctx.share, &ctx.driver, &mut ctx.lists, Command::Later(Later(Arc::new(run))))
    } else {
        run(ctx)
    }
}

/// Relation of a part of a list to the primitives of `glBegin` and `glEnd`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(in crate::intercept::gl) struct Primitive {
    /// True if the part ends a primitive that began in an earlier part.
    pub(in crate::intercept::gl) ends: bool,
    /// Mode of the primitive that is still open at the end of the part.
    pub(in crate::intercept::gl) within: Option<u32>,
    /// True if the open primitive began in this part.
    began: bool,
}

impl Primitive {
    /// `glBegin`. It is an error inside another Begin/End.
    pub(in crate::intercept::gl) fn begin(&mut self, mode: u32) {
        if self.within.is_none() {
            self.within = Some(mode);
            self.began = true;
        }
    }

    /// `glEnd`.
    pub(in crate::intercept::gl) fn end(&mut self) {
        self.ends |= !self.began;
        self.within = None;
        self.began = false;
    }

    /// Returns the state in which the next part begins.
    fn next(self) -> Self {
        Self { ends: false, began: false, ..self }
    }
}

/// A part of a list.
#[derive(Clone, Debug)]
pub(in crate::intercept::gl) enum Item {
    /// A list of the driver.
    Real { list: u32, draws: bool, raster: bool, sets_state: bool, bounds: Bounds, primitive: Primitive },
    /// A command of Cupola.
    Command(Command),
}

/// Display lists of the program.
#[derive(Default)]
pub struct Lists {
    /// Those that consist of more than one list of the driver.
    pub(in crate::intercept::gl) items: HashMap<u32, Arc<Vec<Item>>>,
    pub(in crate::intercept::gl) names: ListNames,
}

/// Returns a name for a list of Cupola. It is so high that programs do not use it by chance.
pub fn own_name(share: &ShareGroup, driver: &Driver) -> u32 {
    share.lists.locked().names.own(driver.gl)
}

/// Display lists of a context.
#[derive(Default)]
pub struct ListState {
    /// The display list that is being compiled.
    pub(in crate::intercept::gl) recording: Option<Recording>,
    /// `glListBase`.
    base: u32,
}

impl ListState {
    /// The display list that is being compiled.
    pub fn recording(&self) -> Option<&Recording> {
        self.recording.as_ref()
    }

    /// Notes that the list that is being compiled draws vertices within `bounds`.
    pub fn note_bounds(&mut self, bounds: &Bounds) {
        if let Some(recording) = &mut self.recording {
            recording.bounds.join(bounds);
        }
    }

    /// Notes that the list that is being compiled sets state that Cupola follows.
    pub fn note_state(&mut self) {
        if let Some(recording) = &mut self.recording {
            recording.sets_state = true;
        }
    }

    /// `glListBase`, to be added to the offsets of `glCallLists`.
    pub fn base(&self) -> u32 {
        self.base
    }

    /// `glListBase`.
    pub fn set_base(&mut self, base: u32) {
        self.base = base;
    }
}

/// The list that is being compiled.
pub struct Recording {
    pub(in crate::intercept::gl) list: u32,
    /// True if there was no list of this name.
    pub(in crate::intercept::gl) is_new: bool,
    pub(in crate::intercept::gl) execute: bool,
    pub(in crate::intercept::gl) items: Vec<Item>,
    pub(in crate::intercept::gl) real: u32,
    /// True if the current list of the driver draws something.
    pub(in crate::intercept::gl) draws: bool,
    /// True if it draws at the raster position.
    pub(in crate::intercept::gl) raster: bool,
    /// True if the current list of the driver sets state that Cupola follows.
    pub sets_state: bool,
    /// Box around the vertices of the current list of the driver.
    pub bounds: Bounds,
    /// Begins and ends of primitives in the current list of the driver.
    pub(in crate::intercept::gl) primitive: Primitive,
}

/// Prepares for a draw in the list that is being compiled; `raster`: it draws at the raster
/// position. Draws at the raster position and other draws go into separate lists of the driver, as
/// Cupola issues them in different ways. Must not be called between `glBegin` and `glEnd`.
pub fn will_draw(share: &ShareGroup, driver: &Driver, lists: &mut ListState, raster: bool) {
    if lists.recording.as_ref().is_some_and(|recording| recording.draws && recording.raster != raster) {
        next_part(share, driver, lists, None);
    }
    if let Some(recording) = &mut lists.recording {
        recording.draws = true;
        recording.raster = raster;
    }
}

/// Ends the current list of the driver, stores `command`, and begins another list.
pub fn record(share: &ShareGroup, driver: &Driver, lists: &mut ListState, command: Command) {
    next_part(share, driver, lists, Some(command));
}

pub(in crate::intercept::gl) fn next_part(
    share: &ShareGroup,
    driver: &Driver,
    lists: &mut ListState,
    command: Option<Command>,
) {
    pause(share, driver, lists);
    go_on(share, driver, lists, command);
}

/// Ends the current list of the driver, so that the driver compiles nothing until [`go_on`].
/// Returns false if no list is being compiled.
pub fn pause(share: &ShareGroup, driver: &Driver, lists: &mut ListState) -> bool {
    let gl = driver.gl;
    let Some(recording) = &mut lists.recording else { return false };
    // Before the end: the driver's next names must not depend on the name of this list, which does
    // not exist yet.
    share.lists.locked().names.reserve(gl);
    recording.end_part(gl);
    true
}

/// Stores `command` and begins another list of the driver.
pub fn go_on(share: &ShareGroup, driver: &Driver, lists: &mut ListState, command: Option<Command>) {
    let gl = driver.gl;
    let real = own_name(share, driver);
    let Some(recording) = &mut lists.recording else { return };
    recording.items.extend(command.map(Item::Command));
    recording.real = real;
    // SAFETY: a list of Cupola; the program is compiling, and the list that was open has just
    // ended.
    unsafe { gl.new_list(real, api::GL_COMPILE) };
}

impl Recording {
    /// The program's name of the list.
    pub fn list(&self) -> u32 {
        self.list
    }

    /// True if the commands are also executed (`GL_COMPILE_AND_EXECUTE`).
    pub fn executes(&self) -> bool {
        self.execute
    }

    pub(in crate::intercept::gl) fn end_part(&mut self, gl: &Gl) {
        // SAFETY: ends the list that Cupola or the program began.
        unsafe { gl.end_list() };
        let Self { real: list, draws, raster, sets_state, bounds, primitive, .. } = *self;
        self.items.push(Item::Real { list, draws, raster, sets_state, bounds, primitive });
        self.primitive = primitive.next();
        self.draws = false;
        self.sets_state = false;
        self.raster = false;
        self.bounds = Bounds::EMPTY;
    }
}

impl Lists {
    pub(in crate::intercept::gl) fn forget(&mut self, ctx: &Context, list: u32) {
        let Some(items) = self.items.remove(&list) else { return };
        for item in items.iter() {
            if let Item::Real { list: part, .. } = item
                && *part != list
            {
                // Cupola keeps the name. Otherwise the driver might give it to the program.
                self.names.give_back(*part);
                if !ctx.compiling() {
                    // SAFETY: a list of Cupola that nothing else names; an empty list replaces it.
                    unsafe {
                        ctx.driver.gl.new_list(*part, api::GL_COMPILE);
                        ctx.driver.gl.end_list();
                    }
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Primitive;

    #[test]
    fn parts_of_lists_know_what_goes_on_in_others() {
        let mut part = Primitive::default();
        part.begin(5);
        part.end();
        assert_eq!((part.ends, part.within), (false, None));
        part.begin(6);
        assert_eq!((part.ends, part.within), (false, Some(6)));
        let mut next = part.next();
        assert_eq!((next.ends, next.within), (false, Some(6)), "vertices only");
        next.end();
        assert_eq!((next.ends, next.within), (true, None));
        next.begin(7);
        assert_eq!((next.ends, next.within), (true, Some(7)));
        let mut alone = Primitive::default();
        alone.end();
        assert_eq!((alone.ends, alone.within), (true, None));
    }
}
