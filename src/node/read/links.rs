//! Who is made from whom, and whether somebody is made from themselves.

use std::collections::{BTreeMap, BTreeSet};

use super::{Building, family};
use crate::node::model::{CellsId, ShapeId};
use crate::text::diagnostic::{Diagnostic, clip};
use crate::text::source::Span;

/// Something that names others, or is named.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
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

/// How deep shapes may be made of shapes: each level takes a piece of the stack while a shape is built and sampled.
const DEEPEST: usize = 200;

/// The most shapes that one is made of, each counted as often as it is used: so many places may have to be looked at for
/// one voxel.
const MOST: u64 = 1_000_000;

/// What is below a node.
#[derive(Clone, Copy)]
struct Below {
    levels: usize,
    shapes: u64,
}

impl Below {
    fn add(&mut self, part: Self) {
        self.levels = self.levels.max(part.levels);
        self.shapes = self.shapes.saturating_add(part.shapes);
    }
}

/// Where a walk along the links stands: a node, and which of its links comes next.
struct Stop {
    node: Node,
    next: usize,
    /// What is below it, as far as was seen.
    below: Below,
}

impl Stop {
    fn at(node: Node) -> Self {
        Self { node, next: 0, below: Below { levels: 0, shapes: 0 } }
    }
}

impl Building<'_, '_> {
    /// Says each cycle once, with its way; without cycles, which shape is made of too many levels of others.
    pub(super) fn report_cycles(&self) {
        let mut links: BTreeMap<Node, Vec<Link>> = BTreeMap::new();
        let mut known = BTreeSet::new();
        for link in self.links.iter().filter(|link| known.insert((link.from, link.to))) {
            links.entry(link.from).or_default().push(*link);
        }
        let nodes = (0..self.shapes.len())
            .map(|i| Node::Shape(ShapeId(i)))
            .chain((0..self.cells.len()).map(|i| Node::Cells(CellsId(i))));
        let mut known: BTreeMap<Node, Below> = BTreeMap::new();
        let mut sound = true;
        for start in nodes {
            sound &= self.follow(start, &links, &mut known);
        }
        if sound {
            self.report_sizes(&links, &known);
        }
    }

    /// Says which shape is the first of a chain to be made of too much.
    fn report_sizes(&self, links: &BTreeMap<Node, Vec<Link>>, known: &BTreeMap<Node, Below>) {
        let is_much = |below: &&Below| below.levels > DEEPEST || below.shapes > MOST;
        let first = known.iter().filter(|(_, below)| is_much(below)).min_by_key(|(_, below)| below.levels);
        let Some((node, below)) = first else { return };
        let Some(link) = links.get(node).and_then(|links| links.first()) else { return };
        let name = self.node_name(*node);
        let (problem, help) = if below.levels > DEEPEST {
            let help = "`union`, `blend` and their kin take a list of many shapes at once";
            (format!("`{name}` is made of shapes more than {DEEPEST} levels deep"), help)
        } else {
            let help = "each counts as often as it is used: make it of fewer copies, as with `at`";
            (format!("`{name}` is made of more than {MOST} shapes"), help)
        };
        self.reader.say(Diagnostic::error(link.span, problem).help(help));
    }

    /// Depth first, without recursion: a scene's depth is the user's. False where a cycle was found.
    fn follow(&self, start: Node, links: &BTreeMap<Node, Vec<Link>>, known: &mut BTreeMap<Node, Below>) -> bool {
        if known.contains_key(&start) {
            return true;
        }
        let mut sound = true;
        let mut way = vec![Stop::at(start)];
        let mut on_way = BTreeMap::from([(start, 0)]);
        while let Some(here) = way.last_mut() {
            let Some(link) = links.get(&here.node).and_then(|links| links.get(here.next)) else {
                let (node, Below { levels, shapes }) = (here.node, here.below);
                let whole = Below { levels: levels + 1, shapes: shapes.saturating_add(1) };
                known.insert(node, whole);
                on_way.remove(&node);
                way.pop();
                if let Some(above) = way.last_mut() {
                    above.below.add(whole);
                }
                continue;
            };
            here.next += 1;
            if let Some(part) = known.get(&link.to) {
                here.below.add(*part);
            } else if let Some(&begin) = on_way.get(&link.to) {
                sound = false;
                let taken: Vec<Link> = way[begin..].iter().map(|stop| links[&stop.node][stop.next - 1]).collect();
                self.say_cycle(&taken);
            } else {
                on_way.insert(link.to, way.len());
                way.push(Stop::at(link.to));
            }
        }
        sound
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
        // What stands in place is called by its place, if it could be read.
        let called = |key: Option<&str>, place: Option<&str>| clip(key.or(place).unwrap_or("in place")).into_owned();
        let key = |name: &str, i: usize| family(self.root, name).nth(i).map(|entry| entry.key.as_str());
        match node {
            Node::Shape(id) => called(key("shape", id.0), self.shapes[id.0].as_ref().map(|shape| shape.name.as_str())),
            Node::Cells(id) => called(key("cells", id.0), self.cells[id.0].as_ref().map(|cells| cells.name.as_str())),
            Node::Output => "output".into(),
        }
    }
}
