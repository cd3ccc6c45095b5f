//! The balls of *two_hundred* for fidget's JIT, with its own trees.

use fidget::context::Tree;
use fidget::jit::JitShape;

use super::scenes::{Ball, Balls};

/// Two operands joined.
pub type Join = fn(Tree, Tree) -> Tree;

/// The greater one.
pub fn greater(a: Tree, b: Tree) -> Tree {
    a.max(b)
}

/// a + b + √(a² + b²).
pub fn r0_union(a: Tree, b: Tree) -> Tree {
    a.clone() + b.clone() + (a.square() + b.square()).sqrt()
}

/// The whole with this union; a difference is a − b = −(−a ∪ b).
pub fn shape(balls: &Balls, union: Join) -> JitShape {
    let mut row: Vec<Tree> = balls.solid.iter().map(ball).collect();
    while row.len() > 1 {
        row = row.chunks(2).map(|pair| pair.iter().cloned().reduce(union).expect("one or two")).collect();
    }
    let whole = row.remove(0);
    JitShape::from(balls.holes.iter().fold(whole, |whole, hole| -union(-whole, ball(hole))))
}

fn ball(one: &Ball) -> Tree {
    let [x, y, z] = one.centre.as_vec3().to_array();
    let [x, y, z] = [Tree::x() - x, Tree::y() - y, Tree::z() - z];
    Tree::constant((one.radius * one.radius) as f32) - (x.square() + y.square() + z.square())
}
