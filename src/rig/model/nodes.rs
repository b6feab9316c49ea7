//! Several machines that share the outputs of a rig.

use crate::error::{Error, ErrorKind, Result};
use crate::rig::Rig;

/// The machine that shows an output.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Node {
    /// Number of the machine, from 0.
    Number(u32),
    /// Host name of the machine.
    Host(String),
}

/// Position of a machine among those that share a rig.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Place {
    /// Number of the machine, below `count`.
    pub number: u32,
    /// Number of machines, at least 1.
    pub count: u32,
    /// Host name of the machine.
    pub host: String,
}

impl Place {
    /// Reads `NUMBER/COUNT`, as in `CUPOLA_NODE`.
    pub fn parse(text: &str, host: String) -> Option<Self> {
        let (number, count) = text.split_once('/')?;
        let (number, count) = (number.parse().ok()?, count.parse().ok()?);
        (number < count).then_some(Self { number, count, host })
    }

    /// Tests whether this machine shows an output of `node`. The first machine shows the outputs
    /// that name no node.
    fn shows(&self, node: Option<&Node>) -> bool {
        match node {
            Some(Node::Number(number)) => *number == self.number,
            Some(Node::Host(host)) => {
                let short = |name: &str| name.split('.').next().unwrap_or_default().to_lowercase();
                *host == self.host || short(host) == short(&self.host)
            }
            None => self.number == 0,
        }
    }
}

impl Rig {
    /// Rig on one of several machines: outputs of other machines are not `here`. If no output names
    /// its `node`, the machines share the outputs evenly, in their order.
    ///
    /// # Errors
    /// [`ErrorKind::InvalidRig`] if an output names a node that does not exist.
    pub fn on_node(mut self, place: &Place) -> Result<Self> {
        let count = self.outputs.len() as u64;
        let is_named = self.outputs.iter().chain(&self.beside).any(|output| output.node.is_some());
        let evenly = |index: u64| u32::try_from(index * u64::from(place.count) / count.max(1)).unwrap_or(u32::MAX);
        for (index, output) in (0..).zip(&mut self.outputs) {
            if let Some(Node::Number(number)) = output.node
                && number >= place.count
            {
                return Err(Error::new(
                    ErrorKind::InvalidRig,
                    format!(
                        "output {:?} has node = {number}, but there are {} nodes, with the numbers 0 to {}",
                        output.name,
                        place.count,
                        place.count - 1
                    ),
                ));
            }
            output.here = if is_named { place.shows(output.node.as_ref()) } else { evenly(index) == place.number };
        }
        for output in &mut self.beside {
            output.here = place.shows(output.node.as_ref());
        }
        Ok(self)
    }

    /// Rig on a machine that also draws the outputs of all other machines. Those outputs are beside
    /// the window, and published.
    ///
    /// # Errors
    /// [`ErrorKind::InvalidRig`] if an output names a node that does not exist, if the size of
    /// another machine's output is unknown, or if no output remains for the window.
    pub fn with_mirrors(self, place: &Place) -> Result<Self> {
        let failed = |text: String| Err(Error::new(ErrorKind::InvalidRig, text));
        let mut rig = self.on_node(place)?;
        let mut others;
        (rig.outputs, others) = rig.outputs.into_iter().partition(|output| output.here);
        for output in &mut others {
            output.size = output.size.or(output.window.map(|window| (window.width, window.height)));
            if output.size.is_none() {
                let name = &output.name;
                return failed(format!(
                    "output {name:?} needs a size = [width, height]: another node shows it as a mirror"
                ));
            }
            (output.shown, output.window) = (false, None);
        }
        if rig.outputs.is_empty() && !rig.passthrough {
            let number = place.number;
            return failed(format!(
                "node {number} shows no output: its program needs one in its window (node = {number})"
            ));
        }
        others.append(&mut rig.beside);
        others.iter_mut().for_each(|output| output.here = true);
        rig.beside = others;
        Ok(rig)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn here(text: &str, number: u32, count: u32) -> Result<Vec<String>> {
        let rig = crate::rig::parse(text, "test", "".as_ref())?;
        let rig = rig.on_node(&Place { number, count, host: "left.dome.example".into() })?;
        Ok(rig.outputs.into_iter().filter(|output| output.here).map(|output| output.name).collect())
    }

    fn rig(nodes: &[&str]) -> String {
        let output = |node: &&str| format!("[[output]]\nkind = \"domemaster\"\nsize = [9, 9]\n{node}\n");
        nodes.iter().map(output).collect()
    }

    #[test]
    fn outputs_belong_to_one_machine() {
        let named = rig(&["node = 1", "", "node = \"LEFT\"", "node = \"right\""]);
        assert_eq!(here(&named, 0, 2).expect("a rig"), ["output-2", "output-3"]);
        assert_eq!(here(&named, 1, 2).expect("a rig"), ["output-1", "output-3"]);
        let error = here(&named, 0, 1).expect_err("there is no node 1").to_string();
        assert!(error.contains("node = 1") && error.contains("1 nodes"), "{error}");
        for wrong in ["node = -1", "node = 1.5", "node = \"\"", "node = true"] {
            assert!(
                here(&rig(&[wrong]), 0, 2).expect_err(wrong).to_string().contains("is neither a whole number nor text")
            );
        }
    }

    #[test]
    fn the_first_machine_draws_what_others_mirror() {
        let mirrored = |text: &str| {
            let rig = crate::rig::parse(text, "test", "".as_ref())?;
            let rig = rig.with_mirrors(&Place { number: 0, count: 3, host: "dome".into() })?;
            assert!(rig.outputs.iter().chain(&rig.beside).all(|output| output.here));
            let names = |outputs: &[crate::rig::Output]| outputs.iter().map(|o| o.name.clone()).collect::<Vec<_>>();
            Ok::<_, Error>((names(&rig.outputs), names(&rig.beside)))
        };
        let (own, others) = mirrored(&rig(&["node = 2", "", "node = 1\nshown = false", "node = 1"])).expect("a rig");
        assert_eq!(own, ["output-2"]);
        assert_eq!(others, ["output-1", "output-4", "output-3"]);
        let (own, others) = mirrored(&rig(&[""; 6])).expect("a rig");
        assert_eq!((own, others.len()), (vec!["output-1".to_owned(), "output-2".to_owned()], 4));
        for (text, words) in [
            (rig(&["node = 1"]), "node 0 shows no output"),
            (rig(&["", "node = 1"]).replace("size = [9, 9]", ""), "needs a size"),
        ] {
            let error = mirrored(&text).expect_err(words).to_string();
            assert!(error.contains(words), "{error}");
        }
    }

    #[test]
    fn without_names_the_outputs_are_shared_evenly() {
        for count in 1..9 {
            let of_all: Vec<_> =
                (0..count).flat_map(|node| here(&rig(&[""; 6]), node, count).expect("a rig")).collect();
            assert_eq!(of_all, (1..=6).map(|number| format!("output-{number}")).collect::<Vec<_>>());
        }
        assert_eq!(here(&rig(&[""; 6]), 1, 4).expect("a rig"), ["output-3"]);
    }
}
