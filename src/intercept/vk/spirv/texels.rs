//! Fragment shaders that read images by texel coordinates or query their sizes. In each view they
//! get the texels and sizes of the program's images.
//!
//! In a view, an image of the scene has the size of the view, not the size that the program chose.
//! Coordinates of fetches are scaled to the size of the view, and sizes are scaled back. The
//! fragment's offset from the corner of its texel is added to the coordinates. So a shader that
//! fetches at its own position gets its own texel, whichever image is larger.

mod additions;
mod reads;

pub use additions::MOST_PICTURES;
pub use reads::DescriptorPlace;

use crate::intercept::scene::obstacle::Obstacle;
use crate::intercept::vk::spirv::functions::{Additions, push, push_code};
use crate::intercept::vk::spirv::module::{BOUND, Declarations, Instruction, instructions, string};
use crate::intercept::vk::spirv::splice::{Entry, MOST_IDS, entry_point, put_into};
use crate::intercept::vk::spirv::texels::additions::Ours;
use crate::intercept::vk::spirv::texels::reads::{OFFSETS, Read, Reads};
use spirv::{BuiltIn, Decoration, ExecutionModel, Op};

/// A shader in which fetches and sizes are changed.
pub struct Followed {
    /// Its words.
    pub words: Vec<u32>,
    /// Descriptors of the images that it fetches from or whose size it queries, in the order of
    /// their factors.
    pub pictures: Vec<DescriptorPlace>,
}

/// Returns `words` with fetches at the program's texels; `None` if the shader reads only by texture
/// coordinates. The uniform block at binding 0 of `set` has four floats at `offset`, those of
/// [`frag_coord`](super::frag_coord). Four more floats follow for each image: the factors from its
/// texels to those of a view, and from pixels of the program to its texels.
///
/// # Errors
/// What the shader does that cannot be followed, for the log.
pub fn texels(words: &[u32], entry: &str, set: u32, offset: u32) -> Result<Option<Followed>, Obstacle> {
    let all = instructions(words).ok_or("a shader that is not SPIR-V")?;
    let declared = Declarations::new(&all);
    let reads = Reads::of(&all, &declared);
    if reads.places.is_empty() && !reads.unknown {
        return Ok(None);
    }
    let (point, main) = entry_point(&all, ExecutionModel::Fragment, entry)?;
    let interface = point.rest(2 + string(point.rest(2)).1);
    let asks = |id: &u32| declared.number(*id, None, Decoration::BuiltIn) == Some(BuiltIn::FragCoord as u32);
    let given = interface.iter().copied().find(asks);
    let fetches = reads.unknown_fetch || reads.places.values().any(|place| place.is_fetch);
    if given.is_none() && !fetches {
        return Ok(None);
    }
    if all.iter().filter(|i| i.is(Op::EntryPoint)).count() > 1 {
        return Err("several entry points in a module that reads images by texel coordinates".into());
    }
    if reads.unknown || reads.pictures.len() > MOST_PICTURES {
        return Err("a shader that reads images by texel coordinates in a way that cannot be followed".into());
    }
    if words[BOUND] > MOST_IDS {
        return Err("a shader with too many ids".into());
    }
    let mut additions = Additions::new(words[BOUND], &declared);
    let ours = Ours::new(&mut additions, (set, offset), given);
    let numbers: Vec<u32> = (0..reads.pictures.len() as u32)
        .map(|number| {
            let id = additions.id();
            push(&mut additions.globals, Op::Constant, &[ours.int, id, number]);
            id
        })
        .collect();
    let scaling =
        Scaling { numbers, pair: ours.int_pair, texel: ours.texel(&mut additions), size: ours.size(&mut additions) };
    let inputs = given.is_none().then_some(ours.place).into_iter().collect();
    let entry = Entry { point, main, wrapper: None, variables: vec![ours.block], inputs };
    let change = |to: &mut Additions<'_>, i: &Instruction<'_>, out: &mut Vec<u32>| match reads.places.get(&i.offset) {
        None => i.operands.to_vec(),
        Some(read) if read.is_fetch => scaling.of_fetch(to, i, read, out),
        Some(read) => scaling.of_size(to, i, read, out),
    };
    let words = put_into(additions, words, &all, &entry, change);
    Ok(Some(Followed { words, pictures: reads.pictures }))
}

/// Ids for the changes of reads.
struct Scaling {
    /// Constants with the indices of the images.
    numbers: Vec<u32>,
    /// The type of two signed integers.
    pair: u32,
    /// The function from a texel of the program to a texel of a view.
    texel: u32,
    /// The function from the size of a view's image to the size of the program's.
    size: u32,
}

impl Scaling {
    /// Returns the operands of a fetch at the program's texel. The instructions that compute them
    /// go to `out`.
    fn of_fetch(&self, to: &mut Additions<'_>, i: &Instruction<'_>, read: &Read, out: &mut Vec<u32>) -> Vec<u32> {
        let mut operands = i.operands.to_vec();
        let given = match read.offset {
            // The offset is in texels of the program, too.
            Some(index) => {
                let sum = to.id();
                push(out, Op::IAdd, &[self.pair, sum, operands[3], operands.remove(index)]);
                operands[4] &= !OFFSETS.bits();
                sum
            }
            None => self.signed(to, read, operands[3], out),
        };
        let made = to.id();
        self.call(to, read, (self.texel, given, made), out);
        operands[3] = made;
        operands
    }

    /// As [`of_fetch`](Self::of_fetch), for a query of the size. The result is computed before the
    /// program's own query, whose result is not used.
    fn of_size(&self, to: &mut Additions<'_>, i: &Instruction<'_>, read: &Read, out: &mut Vec<u32>) -> Vec<u32> {
        let mut operands = i.operands.to_vec();
        let (asked, unused) = (to.id(), to.id());
        let mut query = operands.clone();
        query[1] = asked;
        push_code(out, i.opcode, &query);
        let given = self.signed(to, read, asked, out);
        self.call(to, read, (self.size, given, operands[1]), out);
        operands[1] = unused;
        operands
    }

    /// Converts the two integers of a read to signed ones.
    fn signed(&self, to: &mut Additions<'_>, read: &Read, id: u32, out: &mut Vec<u32>) -> u32 {
        if read.kind == self.pair {
            return id;
        }
        let cast = to.id();
        push(out, Op::Bitcast, &[self.pair, cast, id]);
        cast
    }

    /// Computes `result`, of the read's type, with a function of two signed integers.
    fn call(
        &self,
        to: &mut Additions<'_>,
        read: &Read,
        (function, given, result): (u32, u32, u32),
        out: &mut Vec<u32>,
    ) {
        let called = if read.kind == self.pair { result } else { to.id() };
        push(out, Op::FunctionCall, &[self.pair, called, function, given, self.numbers[read.picture]]);
        if called != result {
            push(out, Op::Bitcast, &[read.kind, result, called]);
        }
    }
}
