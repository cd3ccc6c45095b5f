//! Who is made from whom, and whether somebody is made from themselves.

use super::super::diagnostic::{Diagnostic, clip};
use super::super::model::{CellsId, ShapeId};
use super::super::source::Span;
use super::{Building, family};

/// Something that names others, or is named.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Node {
    /// A shape.
    Shape(ShapeId),
    /// Cells.
    Cells(CellsId),
    /// `[morph]` or `[output]`.
    Output,
}

/// One names the other.
#[derive(Clone, Copy, Debug)]
pub struct Link {
    /// Who names.
    pub from: Node,
    /// Who is named.
    pub to: Node,
    /// Where.
    pub span: Span,
}

impl Building<'_, '_> {
    /// Says each cycle once, with its way.
    pub(super) fn report_cycles(&self) {
        let nodes: Vec<Node> = (0..self.shapes.len())
            .map(|i| Node::Shape(ShapeId(i)))
            .chain((0..self.cells.len()).map(|i| Node::Cells(CellsId(i))))
            .collect();
        let mut done: Vec<Node> = Vec::new();
        for &start in &nodes {
            let mut way: Vec<Link> = Vec::new();
            self.follow(start, &mut way, &mut done);
        }
    }

    /// Depth first, without recursion: a scene's depth is the user's.
    fn follow(&self, start: Node, way: &mut Vec<Link>, done: &mut Vec<Node>) {
        let links_of = |node: Node| self.links.iter().filter(move |link| link.from == node).copied();
        let mut open = vec![links_of(start).collect::<Vec<_>>()];
        while let Some(next) = open.last_mut() {
            let Some(link) = (!next.is_empty()).then(|| next.remove(0)) else {
                open.pop();
                done.push(way.pop().map_or(start, |link| link.to));
                continue;
            };
            if done.contains(&link.to) {
                continue;
            }
            way.push(link);
            let begin = way.iter().position(|earlier| earlier.from == link.to);
            if let Some(begin) = begin {
                self.say_cycle(&way[begin..]);
                way.pop();
                continue;
            }
            open.push(links_of(link.to).collect());
        }
    }

    fn say_cycle(&self, way: &[Link]) {
        let mut names: Vec<String> = way.iter().map(|link| self.node_name(link.from)).collect();
        names.push(self.node_name(way[0].from));
        let problem = format!("`{}` is made from itself", clip(&names[0]));
        let shown =
            if names.len() > 8 { [&names[..4], &["…".into()], &names[names.len() - 3..]].concat() } else { names };
        let span = way[0].span;
        self.reader.say(Diagnostic::error(span, problem).help(format!("the way is {}", shown.join(" → "))));
    }

    fn node_name(&self, node: Node) -> String {
        let named = |name: &str, i: usize| {
            family(self.root, name).nth(i).map_or_else(|| "in place".into(), |entry| clip(&entry.key).into_owned())
        };
        match node {
            Node::Shape(id) => named("shape", id.0),
            Node::Cells(id) => named("cells", id.0),
            Node::Output => "output".into(),
        }
    }
}
