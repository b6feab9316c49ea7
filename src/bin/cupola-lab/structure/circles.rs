//! Circles of uses: files that use each other in a loop (strongly connected components).
//!
//! `tests/architecture.rs` uses this file too.

use super::uses::Uses;

/// The circles of two files or more, the largest first, each sorted by path. Tarjan's algorithm.
pub fn circles(uses: &Uses) -> Vec<Vec<&str>> {
    let count = uses.files.len();
    let mut search = Search {
        uses,
        next: 0,
        number: vec![usize::MAX; count],
        low: vec![0; count],
        open: vec![false; count],
        stack: Vec::new(),
        found: Vec::new(),
    };
    for file in 0..count {
        if search.number[file] == usize::MAX {
            search.visit(file);
        }
    }
    let mut circles: Vec<Vec<&str>> = search
        .found
        .iter()
        .filter(|circle| circle.len() > 1)
        .map(|circle| circle.iter().map(|file| &*uses.files[*file]).collect())
        .collect();
    circles.iter_mut().for_each(|circle| circle.sort_unstable());
    circles.sort_by(|one, other| other.len().cmp(&one.len()).then(one.cmp(other)));
    circles
}

struct Search<'a> {
    uses: &'a Uses,
    next: usize,
    number: Vec<usize>,
    low: Vec<usize>,
    open: Vec<bool>,
    stack: Vec<usize>,
    found: Vec<Vec<usize>>,
}

impl Search<'_> {
    fn visit(&mut self, file: usize) {
        (self.number[file], self.low[file]) = (self.next, self.next);
        self.next += 1;
        self.stack.push(file);
        self.open[file] = true;
        for target in &self.uses.of[file] {
            if self.number[*target] == usize::MAX {
                self.visit(*target);
                self.low[file] = self.low[file].min(self.low[*target]);
            } else if self.open[*target] {
                self.low[file] = self.low[file].min(self.number[*target]);
            }
        }
        if self.low[file] == self.number[file] {
            let start = self.stack.iter().rposition(|other| *other == file).unwrap_or(0);
            let circle = self.stack.split_off(start);
            circle.iter().for_each(|member| self.open[*member] = false);
            self.found.push(circle);
        }
    }
}
