//! Expression graphs as text: a tree, but for what is shared.
//!
//! What is used in several places is one node of the graph and evaluated once. Where it is met first it gets a
//! number and is drawn; elsewhere the number stands for it. What is short is written as an expression.

use super::show::{expression, head};
use crate::expr::{Graph, Node, NodeId};
use std::collections::{HashMap, HashSet};
use std::fmt::Write;

/// An expression of so many characters is short.
const SHORT: usize = 40;
/// Lines of a tree, and how deep it goes.
const LINES: usize = 400;
const DEEP: usize = 48;

/// The expression graph of a node.
pub fn tree(graph: &Graph, root: NodeId) -> String {
    let shared = shared(graph, root);
    let holders = holders(graph, root, &shared);
    let mut drawing =
        Drawing { graph, shared, holders, numbers: HashMap::new(), out: String::new(), lines: 0 };
    drawing.draw(root, "", "", 0);
    if drawing.lines > LINES {
        let _ = writeln!(drawing.out, "... {} lines more", drawing.lines - LINES);
    }
    drawing.out
}

/// What stands in several places, and is more than a name or a number.
fn shared(graph: &Graph, root: NodeId) -> HashSet<NodeId> {
    let mut uses: HashMap<NodeId, usize> = HashMap::new();
    for id in graph.reachable(&[root]) {
        parts(graph, id).into_iter().for_each(|part| *uses.entry(part).or_default() += 1);
    }
    let counts = |id: &NodeId| match graph.node(*id) {
        Node::Const(_) | Node::Input(_) => false,
        Node::Op(..) => parts(graph, *id).iter().any(|part| !parts(graph, *part).is_empty()),
        _ => true,
    };
    uses.into_iter().filter(|(id, n)| *n > 1 && counts(id)).map(|(id, _)| id).collect()
}

/// What has shared nodes in it, or is one.
fn holders(graph: &Graph, root: NodeId, shared: &HashSet<NodeId>) -> HashSet<NodeId> {
    let mut found = HashSet::new();
    // Parts come before what is made of them.
    for id in graph.reachable(&[root]) {
        if shared.contains(&id) || graph.node(id).args().iter().any(|part| found.contains(part)) {
            found.insert(id);
        }
    }
    found
}

/// What a node is made of, but for a footprint that is nothing.
fn parts(graph: &Graph, id: NodeId) -> Vec<NodeId> {
    match graph.node(id) {
        Node::Fractal(_, p, footprint, hurst) => {
            let detail = Some(*footprint).filter(|f| graph.as_const(*f) != Some(0.0));
            p.iter().copied().chain(detail).chain(*hurst).collect()
        }
        node => node.args(),
    }
}

struct Drawing<'a> {
    graph: &'a Graph,
    shared: HashSet<NodeId>,
    holders: HashSet<NodeId>,
    /// The numbers of shared nodes that are drawn.
    numbers: HashMap<NodeId, usize>,
    out: String,
    lines: usize,
}

impl Drawing<'_> {
    fn draw(&mut self, id: NodeId, first: &str, rest: &str, depth: usize) {
        if let Some(number) = self.numbers.get(&id) {
            let line = format!("{first}#{number}");
            return self.line(&line);
        }
        let mut label = String::new();
        if self.shared.contains(&id) {
            let number = self.numbers.len() + 1;
            self.numbers.insert(id, number);
            label = format!("#{number} = ");
        }
        let parts = parts(self.graph, id);
        let holds = parts.iter().any(|part| self.holders.contains(part));
        let short = Some(expression(self.graph, id)).filter(|text| !holds && text.chars().count() <= SHORT);
        if let Some(text) = short {
            let line = format!("{first}{label}{text}");
            return self.line(&line);
        }
        let cut = if depth >= DEEP { " ..." } else { "" };
        let line = format!("{first}{label}{}{cut}", head(self.graph, id));
        self.line(&line);
        // Beyond the last line only numbers would be found out.
        if depth >= DEEP || self.lines > 4 * LINES {
            return;
        }
        for (i, part) in parts.iter().enumerate() {
            let (branch, trunk) = if i + 1 < parts.len() { ("├─ ", "│  ") } else { ("└─ ", "   ") };
            self.draw(*part, &format!("{rest}{branch}"), &format!("{rest}{trunk}"), depth + 1);
        }
    }

    fn line(&mut self, line: &str) {
        self.lines += 1;
        if self.lines <= LINES {
            // Writing to a text cannot fail.
            let _ = writeln!(self.out, "{line}");
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::script::{Request, compile};

    fn of(script: &str) -> String {
        let scene = compile(&Request::text(script)).scene.unwrap();
        tree(&scene.graph, scene.surface.field)
    }

    #[test]
    fn short_expressions_are_one_line() {
        assert_eq!(of("x + y * 2.0"), "x + y * 2\n");
    }

    #[test]
    fn what_is_shared_is_drawn_once() {
        let text =
            of("let r = length(p - vec3(1, 2, 3)) * 2.0; min(r, r ** 3 + gradient(7).scaled(4.0) * 0.25)");
        assert!(text.starts_with("min\n├─ #1 = "), "{text}");
        assert_eq!(text.matches("#1 = ").count(), 1, "{text}");
        assert!(text.matches("#1").count() > 1 && text.contains("gradient(7, 4)"), "{text}");
    }

    #[test]
    fn large_graphs_are_cut() {
        let text = of("let f = x; for i in 0..300 { f = sin(f * 1.1) + cos(f * 0.9 + y); } f");
        assert!(text.lines().count() <= LINES + 1, "{}", text.lines().count());
        let wide = of("let f = x; for i in 0..500 { f = min(f, length(p - vec3(i, 2 * i, -i)) - 0.5); } f");
        assert!(wide.contains("..."), "{wide}");
    }
}
