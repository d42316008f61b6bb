//! Which line of a script each node of a graph belongs to.
//!
//! 1. A node belongs to the line that wrote it *first*: expressions are hash-consed, so what several lines write is one
//!    node, and is computed once.
//! 2. What the standard library made on the way belongs to the line of the user's own script that first used it; so does
//!    what the renderer adds, such as the size of a pixel.
//! 3. If there is no such line, a line of the standard library has to do.

use crate::diag::{Place, Sources};
use crate::expr::{Graph, NodeId};
use serde::Serialize;
use std::collections::HashMap;

/// A line of a script.
#[derive(Clone, PartialEq, Eq, PartialOrd, Ord, Debug, Default, Serialize)]
pub struct Line {
    /// Its file; empty if it is not known.
    pub file: String,
    /// Its number, from 1; 0 if it is not known.
    pub line: u32,
    /// What it says, without the space around it.
    pub text: String,
}

/// The lines of nodes.
#[derive(Clone, Debug)]
pub struct Ledger {
    lines: Vec<Line>,
    of: HashMap<NodeId, usize>,
}

impl Ledger {
    /// Of the nodes that expressions are made of.
    pub fn new(graph: &Graph, roots: &[NodeId], sources: &Sources) -> Ledger {
        let mut lines = Lines { sources, lines: Vec::new(), index: HashMap::new() };
        let mut of = HashMap::new();
        let mut users: HashMap<NodeId, usize> = HashMap::new();
        // Users before what they use, and late users before early ones.
        for id in graph.reachable(roots).into_iter().rev() {
            let own = graph.place(id);
            let by_user = own.filter(|place| !place.is_embedded()).map(|place| lines.number(Some(place)));
            let by_user = by_user.or_else(|| users.get(&id).copied());
            of.insert(id, by_user.unwrap_or_else(|| lines.number(own)));
            if let Some(line) = by_user {
                users.extend(graph.node(id).args().into_iter().map(|arg| (arg, line)));
            }
        }
        Ledger { lines: lines.lines, of }
    }

    /// The line of a node.
    pub fn line(&self, id: NodeId) -> Line {
        self.of.get(&id).map(|i| self.lines[*i].clone()).unwrap_or_default()
    }
}

/// Lines by their numbers in a list.
struct Lines<'a> {
    sources: &'a Sources,
    lines: Vec<Line>,
    index: HashMap<(String, u32), usize>,
}

impl Lines<'_> {
    fn number(&mut self, place: Option<&Place>) -> usize {
        let key = place.map_or_else(Default::default, |place| (place.file.to_string(), place.line));
        let Lines { sources, lines, index } = self;
        *index.entry(key.clone()).or_insert_with(|| {
            let (file, line) = key;
            let text = place.and_then(|place| {
                let row = (place.line as usize).checked_sub(1)?;
                sources.get(&place.file)?.lines().nth(row)
            });
            lines.push(Line { file, line, text: text.unwrap_or_default().trim().to_owned() });
            lines.len() - 1
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::expr::Node;
    use crate::script::{Request, compile};

    /// The numbers of the lines that the nodes of a kind belong to.
    fn lines(text: &str, is_meant: impl Fn(&Node) -> bool) -> Vec<u32> {
        let compiled = compile(&Request::text(text));
        let scene = compiled.scene.unwrap();
        let (graph, root) = (&scene.graph, scene.surface.field);
        let ledger = Ledger::new(graph, &[root], &compiled.sources);
        let nodes = graph.reachable(&[root]).into_iter().filter(|id| is_meant(graph.node(*id)));
        nodes.map(|id| ledger.line(id).line).collect()
    }

    fn is_op(node: &Node, name: &str) -> bool {
        matches!(node, Node::Op(op, _) if op.name() == name)
    }

    #[test]
    fn nodes_belong_to_the_line_that_wrote_them() {
        let text = "let a = sin(x);\nlet b = cos(y);\na + b\n + sin(x)";
        assert_eq!(lines(text, |node| is_op(node, "sin")), [1]);
        assert_eq!(lines(text, |node| is_op(node, "cos")), [2]);
    }

    #[test]
    fn a_noise_belongs_to_the_line_that_chose_it() {
        let text = "import \"std/fractal\" as f;\nlet n = f::fbm(gradient(7));\n\nsphere(1.0) - 0.1 * n";
        assert_eq!(lines(text, |node| matches!(node, Node::Fractal(..))), [2]);
    }

    #[test]
    fn what_the_library_made_belongs_to_whom_it_was_made_for() {
        let text = "let s = sphere(1.0);\nlet t = torus(1.0, 0.2);\ns.translated([0, 1, 0]) +\n t.translated([1, 0, 0])";
        let lengths = lines(text, |node| is_op(node, "length"));
        assert!(lengths.iter().all(|line| (1..=4).contains(line)), "{lengths:?}");
        assert!(lines(text, |_| true).iter().all(|line| *line > 0));
    }

    #[test]
    fn lines_are_quoted() {
        let compiled = compile(&Request::text("\n  length(p) - 1.0  // a ball"));
        let scene = compiled.scene.unwrap();
        let root = scene.surface.field;
        let line = Ledger::new(&scene.graph, &[root], &compiled.sources).line(root);
        assert_eq!((line.line, line.text.as_str()), (2, "length(p) - 1.0  // a ball"));
    }
}
