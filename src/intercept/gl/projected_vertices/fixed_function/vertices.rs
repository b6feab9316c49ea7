//! Vertices of the fixed-function pipeline as numbers, from which new vertices can be computed.

use crate::backend::gl::driver::api::{self, Gl};
use crate::correct::single;
use crate::intercept::gl::state::compat::vertex_recorder::{Recorded, Recorder, Sets};
use crate::intercept::scene::obstacle::Obstacle;

/// An attribute that the pipeline reads.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Attribute {
    /// The colour.
    Color,
    /// The secondary colour.
    SecondaryColor,
    /// The normal.
    Normal,
    /// The fog coordinate.
    Fog,
    /// The texture coordinates of a unit.
    Texture(u32),
    /// Flag: the edge to the next vertex is part of the outline.
    EdgeFlag,
}

impl Attribute {
    /// Returns the current value. Missing components have OpenGL's default values.
    pub fn current(self, gl: &Gl) -> [f32; 4] {
        let mut value = [0.0, 0.0, 0.0, 1.0];
        let name = match self {
            Self::Color => api::GL_CURRENT_COLOR,
            Self::SecondaryColor => api::GL_CURRENT_SECONDARY_COLOR,
            Self::Normal => api::GL_CURRENT_NORMAL,
            Self::Fog => api::GL_CURRENT_FOG_COORD,
            Self::Texture(_) => api::GL_CURRENT_TEXTURE_COORDS,
            Self::EdgeFlag => api::GL_EDGE_FLAG,
        };
        // SAFETY: writes four numbers at most; the active unit is put back.
        unsafe {
            let mut active = 0;
            if let Self::Texture(unit) = self {
                gl.get_integerv(api::GL_ACTIVE_TEXTURE, &mut active);
                gl.active_texture(api::GL_TEXTURE0 + unit);
            }
            gl.get_floatv(name, value.as_mut_ptr());
            if active != 0 {
                gl.active_texture(active as u32);
            }
        }
        value
    }

    /// Sets the value for the next vertex.
    ///
    /// # Safety
    /// The context of `gl` must be current and have a fixed-function pipeline.
    pub unsafe fn set(self, gl: &Gl, value: &[f32; 4]) {
        let start = value.as_ptr();
        // SAFETY: as promised; each reads four numbers at most.
        unsafe {
            match self {
                Self::Color => gl.color4fv(start),
                Self::SecondaryColor => gl.secondary_color3fv(start),
                Self::Normal => gl.normal3fv(start),
                Self::Fog => gl.fog_coordfv(start),
                Self::Texture(0) => gl.tex_coord4fv(start),
                Self::Texture(unit) => gl.multi_tex_coord4fv(api::GL_TEXTURE0 + unit, start),
                Self::EdgeFlag => gl.edge_flag(u8::from(value[0] != 0.0)),
            }
        }
    }
}

/// Vertices of one draw, with the attributes that differ between them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Vertices {
    /// `GL_TRIANGLES` and so on.
    pub mode: u32,
    /// Attributes of each vertex, in addition to its position.
    pub attributes: Vec<Attribute>,
    /// For each vertex its position, then its attributes.
    pub values: Vec<[f32; 4]>,
}

impl Vertices {
    /// Returns the number of vertices.
    pub fn count(&self) -> usize {
        self.values.len() / self.stride()
    }

    /// Returns the number of values per vertex.
    pub fn stride(&self) -> usize {
        1 + self.attributes.len()
    }

    /// Returns position and attributes of the vertex with this number.
    pub fn vertex(&self, number: usize) -> &[[f32; 4]] {
        let start = number * self.stride();
        self.values.get(start..start + self.stride()).unwrap_or_default()
    }

    /// Reads the vertices that were recorded between Begin and End.
    ///
    /// # Errors
    /// The part that cannot be read, for the log.
    pub fn of_recorded(gl: &Gl, mode: u32, recorder: &Recorder) -> Result<Self, Obstacle> {
        let mut vertices = Self { mode, ..Self::default() };
        let mut now = Vec::new();
        for command in recorder.commands().filter(|command| !command.is_vertex()) {
            if let Some(attribute) = of_command(&command)
                && !vertices.attributes.contains(&attribute)
            {
                vertices.attributes.push(attribute);
                now.push(attribute.current(gl));
            }
        }
        for command in recorder.commands() {
            if command.is_vertex() {
                let plain = command.plain && matches!(command.sets, Sets::Position | Sets::Generic);
                let value = numbers(&command, false).filter(|_| plain);
                vertices.values.push(value.ok_or("a program uses packed vertices or evaluators")?);
                vertices.values.extend_from_slice(&now);
            } else if command.sets == Sets::Material && !vertices.values.is_empty() {
                return Err("a program changes materials between vertices".into());
            } else if let Some(attribute) = of_command(&command) {
                let normalised = matches!(attribute, Attribute::Color | Attribute::SecondaryColor | Attribute::Normal);
                let value = numbers(&command, normalised).filter(|_| command.plain);
                let place = vertices.attributes.iter().position(|known| *known == attribute);
                if let Some(place) = place.and_then(|place| now.get_mut(place)) {
                    *place = value.ok_or("a program uses packed vertex attributes")?;
                }
            }
        }
        Ok(vertices)
    }
}

fn of_command(command: &Recorded) -> Option<Attribute> {
    match command.sets {
        Sets::Color => Some(Attribute::Color),
        Sets::SecondaryColor => Some(Attribute::SecondaryColor),
        Sets::Normal => Some(Attribute::Normal),
        Sets::Fog => Some(Attribute::Fog),
        Sets::EdgeFlag => Some(Attribute::EdgeFlag),
        Sets::Texture => Some(Attribute::Texture(0)),
        Sets::TextureUnit => {
            let unit = command.prefix.checked_sub(api::GL_TEXTURE0.into())?;
            Some(Attribute::Texture(u32::try_from(unit).ok()?))
        }
        // The pipeline does not read other attributes. Materials and indices that change between
        // vertices are not supported.
        _ => None,
    }
}

/// Returns up to four numbers of a command. The others have OpenGL's default values. `normalised`:
/// integers are fractions of 1.
fn numbers(command: &Recorded, normalised: bool) -> Option<[f32; 4]> {
    let mut value = [0.0, 0.0, 0.0, 1.0];
    for (index, number) in value.iter_mut().enumerate().take(command.count) {
        *number = command.number(index, normalised)?;
    }
    Some(single::values(value))
}
