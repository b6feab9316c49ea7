//! Names in a program's shaders that may flow into the position.

use crate::intercept::scene::lens::{self, Order};
use std::collections::{BTreeMap, HashMap, HashSet};

/// Names in shaders that may flow into a position.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct PositionNames {
    names: HashSet<String>,
    /// For uniforms that are arrays: the elements that may flow into a position.
    elements: HashMap<String, Elements>,
}

/// Elements of an array that may flow into a position.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Elements {
    /// Elements that the text names by their number.
    pub numbers: BTreeMap<u32, Uses>,
    /// Choice of elements that the text does not name by number, and its uses of them.
    pub others: Option<(Choice, Uses)>,
}

/// Choice of an element that the text does not name by its number.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Choice {
    /// By the uniform of this name.
    ByUniform(String),
    /// In a way that the program does not show.
    Unknown,
}

/// Uses of an array's elements in a shader.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Uses {
    /// True if the elements go into scalar products, as rows of a matrix do.
    pub products: bool,
    /// True if the elements are multiplied, as columns of a matrix are.
    pub factors: bool,
}

impl Uses {
    /// Returns these uses together with others.
    pub fn and(self, other: Self) -> Self {
        Self { products: self.products || other.products, factors: self.factors || other.factors }
    }

    /// Returns the order of four elements in a matrix.
    pub fn order(self) -> Order {
        match (self.products, self.factors) {
            (true, false) => Order::Rows,
            (false, true) => Order::Columns,
            _ => Order::Either,
        }
    }
}

impl Elements {
    /// Returns the groups of four consecutive elements that are named by their numbers: the number
    /// of the first element, and the order.
    pub fn fours(&self) -> impl Iterator<Item = (u32, Order)> + '_ {
        let numbers: Vec<u32> = self.numbers.keys().copied().collect();
        let uses =
            |first: u32| self.numbers.range(first..=first + 3).fold(Uses::default(), |all, (_, uses)| all.and(*uses));
        lens::fours(&numbers).into_iter().map(move |first| (first, uses(first).order()))
    }
}

impl PositionNames {
    /// Returns these names, with these elements of arrays.
    pub fn new(names: HashSet<String>, elements: HashMap<String, Elements>) -> Self {
        Self { names, elements }
    }

    /// Adds more names, and all elements of their arrays.
    pub fn add<'a>(&mut self, names: impl Iterator<Item = &'a str>) {
        for name in names {
            self.elements.remove(name);
            self.names.insert(name.to_owned());
        }
    }

    /// True if the uniform that OpenGL calls `name` (`block.member`, `array[0]`, `array[2].member`)
    /// may flow into the position.
    pub fn contain(&self, name: &str) -> bool {
        let (before, member) = name.rsplit_once('.').unwrap_or(("", name));
        let part = |part: &str| match part.split_once('[') {
            Some((array, rest)) => self.elements.get(array).is_none_or(|elements| {
                let number = rest.strip_suffix(']').and_then(|number| number.parse().ok());
                elements.others.is_some() || number.is_none_or(|number| elements.numbers.contains_key(&number))
            }),
            None => true,
        };
        self.names.contains(member.split('[').next().unwrap_or(member)) && before.split('.').all(part)
    }

    /// Returns the known elements of the array that OpenGL calls `name`; `None`: any element may
    /// flow into the position.
    pub fn elements(&self, name: &str) -> Option<&Elements> {
        let member = name.rsplit('.').next().unwrap_or(name);
        self.elements.get(member.split('[').next().unwrap_or(member))
    }
}
