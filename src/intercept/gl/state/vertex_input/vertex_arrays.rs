//! Vertex arrays of a context.

use crate::backend::gl::driver::api;
use std::collections::HashMap;

/// Format of the numbers of an array.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Format {
    /// Number of components as in OpenGL: 1 to 4, or `GL_BGRA`.
    pub components: usize,
    /// Type of a component: `GL_FLOAT` and so on.
    pub kind: u32,
    /// True if integers stand for −1…1 or 0…1.
    pub normalised: bool,
    /// True if the shader gets integers.
    pub integer: bool,
    /// Number of the binding from which the attribute reads. Without bindings, it is the
    /// attribute's own number.
    pub(in crate::intercept::gl) binding: u32,
    /// Bytes from the beginning of the binding's element.
    pub(in crate::intercept::gl) offset: usize,
}

/// Place of an array.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Source {
    /// Name of the buffer; 0 = the program's memory.
    pub buffer: u32,
    /// Address in the program's memory, or offset in the buffer.
    pub start: usize,
    /// Bytes from one element to the next.
    pub stride: usize,
}

/// The array of `glVertexPointer`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Pointer {
    /// Number of components: 2 to 4.
    pub components: usize,
    /// Type of a component: `GL_FLOAT` and so on.
    pub kind: u32,
    /// Buffer and position of the array.
    pub source: Source,
}

/// Record of a generic attribute.
pub(in crate::intercept::gl) struct GenericAttribute {
    pub(in crate::intercept::gl) location: u32,
    pub(in crate::intercept::gl) on: Option<bool>,
    pub(in crate::intercept::gl) format: Option<Format>,
}

pub(in crate::intercept::gl) struct Binding {
    pub(in crate::intercept::gl) number: u32,
    pub(in crate::intercept::gl) source: Option<Source>,
    pub(in crate::intercept::gl) divisor: Option<i32>,
}

/// Record of a vertex array object.
#[derive(Default)]
pub(in crate::intercept::gl) struct Object {
    pub(in crate::intercept::gl) name: u32,
    pub(in crate::intercept::gl) attributes: Vec<GenericAttribute>,
    pub(in crate::intercept::gl) bindings: Vec<Binding>,
    /// True if `GL_VERTEX_ARRAY` is on; `None` = not known.
    pub(in crate::intercept::gl) conventional_on: Option<bool>,
    pub(in crate::intercept::gl) conventional: Option<Pointer>,
    /// The buffer of indices.
    pub(in crate::intercept::gl) elements: Option<u32>,
}

/// Records of a context's vertex arrays.
#[derive(Default)]
pub struct VertexArrays {
    /// Records of the objects; empty while it is not known which object is in use.
    pub(in crate::intercept::gl) objects: Vec<Object>,
    /// Indices in the list, by name.
    pub(in crate::intercept::gl) places: HashMap<u32, usize>,
    /// Index of the object in use.
    pub(in crate::intercept::gl) current: Option<usize>,
    /// True if the program uses such objects.
    pub(in crate::intercept::gl) used: bool,
}

/// Greatest number of objects that are recorded.
pub(in crate::intercept::gl) const MOST_OBJECTS: usize = 1 << 12;

impl VertexArrays {
    /// Forgets everything, as anything may have changed.
    pub fn forget(&mut self) {
        self.objects.clear();
        self.places.clear();
        self.current = None;
    }

    /// Forgets the record of an object that may have changed.
    pub(in crate::intercept::gl) fn forget_object(&mut self, name: u32) {
        if let Some(object) = self.places.get(&name).and_then(|place| self.objects.get_mut(*place)) {
            *object = Object { name, ..Object::default() };
        }
    }

    /// Notes that the object of this name is in use.
    pub(in crate::intercept::gl) fn select(&mut self, name: u32) {
        if self.objects.len() >= MOST_OBJECTS && !self.places.contains_key(&name) {
            self.forget();
        }
        let next = self.objects.len();
        let place = *self.places.entry(name).or_insert(next);
        if place == next {
            self.objects.push(Object { name, ..Object::default() });
        }
        self.current = Some(place);
    }

    pub(in crate::intercept::gl) fn current(&mut self) -> Option<&mut Object> {
        self.current.and_then(|place| self.objects.get_mut(place))
    }
}

impl Object {
    pub(in crate::intercept::gl) fn attribute(&mut self, location: u32) -> Option<&mut GenericAttribute> {
        self.attributes.iter_mut().find(|attribute| attribute.location == location)
    }

    pub(in crate::intercept::gl) fn binding(&mut self, number: u32) -> Option<&mut Binding> {
        self.bindings.iter_mut().find(|binding| binding.number == number)
    }

    pub(in crate::intercept::gl) fn asked_attribute(&mut self, location: u32) -> &mut GenericAttribute {
        let place = self.attributes.iter().position(|attribute| attribute.location == location);
        let place = place.unwrap_or_else(|| {
            self.attributes.push(GenericAttribute { location, on: None, format: None });
            self.attributes.len() - 1
        });
        &mut self.attributes[place]
    }

    pub(in crate::intercept::gl) fn asked_binding(&mut self, number: u32) -> &mut Binding {
        let place = self.bindings.iter().position(|binding| binding.number == number);
        let place = place.unwrap_or_else(|| {
            self.bindings.push(Binding { number, source: None, divisor: None });
            self.bindings.len() - 1
        });
        &mut self.bindings[place]
    }
}

/// Returns the real distance between elements. A stride of 0 stands for elements without gaps.
pub(in crate::intercept::gl) fn packed(stride: usize, components: usize, kind: u32) -> usize {
    if stride == 0 { components * width(kind).unwrap_or_default() } else { stride }
}

/// Returns the bytes of a number of an array; `None` for types that Cupola does not read.
pub fn width(kind: u32) -> Option<usize> {
    match kind {
        api::GL_BYTE | api::GL_UNSIGNED_BYTE => Some(1),
        api::GL_SHORT | api::GL_UNSIGNED_SHORT | api::GL_HALF_FLOAT => Some(2),
        api::GL_INT | api::GL_UNSIGNED_INT | api::GL_FLOAT => Some(4),
        api::GL_DOUBLE => Some(8),
        _ => None,
    }
}
