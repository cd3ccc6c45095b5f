//! The expression graph: every distinct operation once, with what is known of it.
//!
//! A [`Graph`] is where expressions are built, bottom up; [`super::Expression::new`] takes one node out of it as
//! a field. Building simplifies as far as that keeps values: affine forms stay affine under `+`, `−` and
//! constant factors, sums of up to three squares become one leaf, constants are folded.

use std::collections::HashMap;
use std::sync::Arc;

use super::facts::Facts;
use super::leaf::{Affine, Quadric};
use super::op::{Binary, Op, Unary};
use super::{Aabb, Field, Slope};
use glam::DVec3;

/// A node of a [`Graph`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Node(pub(super) u32);

/// An expression graph under construction. Equal sub-expressions are one node.
#[derive(Clone, Default)]
pub struct Graph {
    pub(super) ops: Vec<Op>,
    pub(super) facts: Vec<Facts>,
    pub(super) affines: Vec<Affine>,
    pub(super) quadrics: Vec<Quadric>,
    pub(super) externals: Vec<Arc<dyn Field>>,
    known: HashMap<[u64; 4], Node>,
    known_affines: HashMap<[u64; 4], u32>,
    known_quadrics: HashMap<[u64; 16], u32>,
}

impl Graph {
    /// An empty graph.
    pub fn new() -> Self {
        Self::default()
    }

    pub(super) fn op(&self, node: Node) -> Op {
        self.ops[node.0 as usize]
    }

    pub(super) fn facts(&self, node: Node) -> Facts {
        self.facts[node.0 as usize]
    }

    /// The box outside of which a node is negative, as far as its construction tells.
    pub fn known_box(&self, node: Node) -> Option<Aabb> {
        self.facts(node).bounds
    }

    /// What a node's value says about distance.
    pub fn slope(&self, node: Node) -> Slope {
        self.facts(node).slope
    }

    /// Adds a truth about a node that its construction does not show.
    pub(super) fn declare(&mut self, node: Node, facts: Facts) -> Node {
        let known = &mut self.facts[node.0 as usize];
        *known = known.and(facts);
        node
    }

    /// The node of an operation, new or known.
    pub(super) fn intern(&mut self, op: Op, facts: Facts) -> Node {
        let next = Node(self.ops.len() as u32);
        let node = *self.known.entry(op.key()).or_insert(next);
        if node == next {
            self.ops.push(op);
            self.facts.push(Facts::NONE);
        }
        self.declare(node, facts)
    }

    pub(super) fn affine_leaf(&mut self, form: Affine) -> Node {
        let form = form.tidy();
        let key = [form.slope.x, form.slope.y, form.slope.z, form.constant].map(f64::to_bits);
        let index = *self.known_affines.entry(key).or_insert(self.affines.len() as u32);
        if index as usize == self.affines.len() {
            self.affines.push(form);
        }
        self.intern(Op::Affine(index), Facts::affine(form.slope))
    }

    pub(super) fn quadric_leaf(&mut self, mut quadric: Quadric) -> Node {
        // Constant terms belong to the constant.
        for (weight, form) in &mut quadric.terms {
            if form.is_constant() {
                quadric.constant += *weight * form.constant * form.constant;
                (*weight, *form) = (0.0, Affine::ZERO);
            }
        }
        // Used terms first, along x, y, z in this order: equal sums are one leaf, however they were written.
        quadric.terms.sort_by_key(|(weight, form)| {
            let axis = form.slope.to_array().iter().position(|slope| *slope != 0.0);
            (*weight == 0.0, axis)
        });
        if quadric.terms[0].0 == 0.0 {
            return self.constant(quadric.constant);
        }
        let mut key = [0; 16];
        key[0] = (quadric.constant + 0.0).to_bits();
        for (words, (weight, form)) in key[1..].chunks_exact_mut(5).zip(&quadric.terms) {
            let numbers = [*weight, form.slope.x, form.slope.y, form.slope.z, form.constant];
            words.copy_from_slice(&numbers.map(|number| (number + 0.0).to_bits()));
        }
        let index = *self.known_quadrics.entry(key).or_insert(self.quadrics.len() as u32);
        if index as usize == self.quadrics.len() {
            self.quadrics.push(quadric);
        }
        self.intern(Op::Quadric(index), Facts::NONE)
    }

    pub(super) fn as_affine(&self, node: Node) -> Option<Affine> {
        match self.op(node) {
            Op::Affine(index) => Some(self.affines[index as usize]),
            _ => None,
        }
    }

    /// The value of a constant node.
    pub fn as_constant(&self, node: Node) -> Option<f64> {
        self.as_affine(node).filter(Affine::is_constant).map(|form| form.constant)
    }

    fn as_quadric(&self, node: Node) -> Option<Quadric> {
        match self.op(node) {
            Op::Quadric(index) => Some(self.quadrics[index as usize]),
            _ => self.as_constant(node).map(Quadric::constant),
        }
    }

    /// A number, the same everywhere.
    pub fn constant(&mut self, value: f64) -> Node {
        self.affine_leaf(Affine::constant(value))
    }

    /// The affine form `slope · p + constant`.
    pub fn affine(&mut self, slope: DVec3, constant: f64) -> Node {
        self.affine_leaf(Affine::new(slope, constant))
    }

    /// The coordinate x.
    pub fn x(&mut self) -> Node {
        self.affine(DVec3::X, 0.0)
    }

    /// The coordinate y.
    pub fn y(&mut self) -> Node {
        self.affine(DVec3::Y, 0.0)
    }

    /// The coordinate z.
    pub fn z(&mut self) -> Node {
        self.affine(DVec3::Z, 0.0)
    }

    /// Another field as an operand: a mesh, a distance object, an expression of another graph.
    pub fn field(&mut self, field: Arc<dyn Field>) -> Node {
        let facts = Facts::new(field.bounding_box(), field.slope());
        let same = |known: &Arc<dyn Field>| std::ptr::addr_eq(Arc::as_ptr(known), Arc::as_ptr(&field));
        let leaf = self.externals.iter().position(same).unwrap_or_else(|| {
            self.externals.push(field);
            self.externals.len() - 1
        }) as u32;
        let at = [self.x(), self.y(), self.z()];
        let node = self.external(leaf, at);
        self.declare(node, facts)
    }

    /// A field read at other coordinates; of constants, its value.
    pub fn field_at(&mut self, field: Arc<dyn Field>, at: [Node; 3]) -> Node {
        if let [Some(x), Some(y), Some(z)] = at.map(|node| self.as_constant(node)) {
            return self.constant(field.reference(DVec3::new(x, y, z)));
        }
        let own = Facts::new(None, field.slope()).steepness();
        let read = at.iter().try_fold(0.0, |sum, node| Some(sum + self.facts(*node).steepness()?.powi(2)));
        let here = self.field(field);
        let Op::External { leaf, .. } = self.op(here) else { return here };
        let node = self.external(leaf, at);
        self.declare(node, Facts::steep(own.zip(read).map(|(own, read): (f64, f64)| own * read.sqrt())))
    }

    pub(super) fn external(&mut self, leaf: u32, at: [Node; 3]) -> Node {
        self.intern(Op::External { leaf, at: at.map(|node| node.0) }, Facts::NONE)
    }

    pub(super) fn unary(&mut self, operation: Unary, a: Node) -> Node {
        let facts = operation.facts([self.facts(a)]);
        let node = match self.as_constant(a) {
            Some(value) => self.constant(operation.value([value])),
            None => match operation.simplified(self, [a]) {
                Some(node) => node,
                None => self.intern(Op::Unary(operation, a.0), Facts::NONE),
            },
        };
        self.declare(node, facts)
    }

    pub(super) fn binary(&mut self, operation: Binary, a: Node, b: Node) -> Node {
        let facts = operation.facts([self.facts(a), self.facts(b)]);
        let node = match (self.as_constant(a), self.as_constant(b)) {
            (Some(first), Some(second)) => self.constant(operation.value([first, second])),
            _ => match operation.simplified(self, [a, b]) {
                Some(node) => node,
                None => self.intern(Op::Binary(operation, a.0, b.0), Facts::NONE),
            },
        };
        self.declare(node, facts)
    }

    /// The second where the first is not 0, else the third.
    pub(super) fn choose(&mut self, condition: Node, then: Node, other: Node) -> Node {
        if let Some(value) = self.as_constant(condition).filter(|value| !value.is_nan()) {
            return if value == 0.0 { other } else { then };
        }
        if then == other {
            return then;
        }
        let facts = Facts::union(self.facts(then), self.facts(other), Slope::Unknown, 1.0);
        self.intern(Op::Choose([condition, then, other].map(|node| node.0)), facts)
    }

    /// `a + sign · b` as one leaf, where it is one.
    pub(super) fn sum_of_leaves(&mut self, a: Node, b: Node, sign: f64) -> Option<Node> {
        if let (Some(first), Some(second)) = (self.as_affine(a), self.as_affine(b)) {
            return Some(self.affine_leaf(first.plus(&second.linear(sign, 0.0))));
        }
        let sum = self.as_quadric(a)?.plus(&self.as_quadric(b)?.linear(sign, 0.0))?;
        Some(self.quadric_leaf(sum))
    }
}
