//! Choices before roots: √a ∨ √b is √(a ∨ b), and r − √a ∨ r − √b is r − √(a ∧ b).
//!
//! The distance of a union of balls takes one root so, and each ball half of the operations to bound and to evaluate. Each
//! step keeps order as it is rounded too, so every value stays what it is to the last bit.

use super::op::{Binary, Op, Unary, mark_needed};
use super::program::Program;

/// The program with its choices among values that one operation was made of taken before that.
pub(super) fn chosen_first(program: &Program) -> Program {
    let mut rewritten = Rewritten::default();
    let mut places: Vec<u32> = Vec::with_capacity(program.ops.len());
    for op in &program.ops {
        let place = match op.renamed(|argument| places[argument as usize]) {
            Op::Binary(side @ (Binary::Min | Binary::Max), a, b) => rewritten.choose(program, side, a, b),
            op => rewritten.push(program, op),
        };
        places.push(place);
    }
    Program {
        ops: places.last().map(|root| needed_for(&rewritten.ops, *root)).unwrap_or_default(),
        affines: program.affines.clone(),
        quadrics: program.quadrics.clone(),
        externals: program.externals.clone(),
    }
}

#[derive(Default)]
struct Rewritten {
    ops: Vec<Op>,
    /// Which of them are sums of squares, roots of such, or chosen from them: never negative.
    is_root_of_squares: Vec<bool>,
}

impl Rewritten {
    fn push(&mut self, program: &Program, op: Op) -> u32 {
        let is = |argument: u32| self.is_root_of_squares[argument as usize];
        self.is_root_of_squares.push(match op {
            Op::Quadric(leaf) => program.quadrics[leaf as usize].root_slope().is_some(),
            Op::Unary(Unary::Sqrt, a) => is(a),
            Op::Binary(Binary::Min | Binary::Max, a, b) => is(a) && is(b),
            _ => false,
        });
        self.ops.push(op);
        self.ops.len() as u32 - 1
    }

    fn choose(&mut self, program: &Program, side: Binary, a: u32, b: u32) -> u32 {
        match (self.ops[a as usize], self.ops[b as usize]) {
            (Op::Unary(operation, a), Op::Unary(other, b))
                if operation == other && self.keeps_order(operation, a, b) =>
            {
                let falls = matches!(operation, Unary::Linear { scale, .. } if scale < 0.0);
                let chosen = self.choose(program, if falls { side.turned() } else { side }, a, b);
                self.push(program, Op::Unary(operation, chosen))
            }
            _ => self.push(program, Op::Binary(side, a, b)),
        }
    }

    /// Whether an operation rises, or falls, with its argument between two. The root of what may be negative does not: it
    /// may be no number.
    fn keeps_order(&self, operation: Unary, a: u32, b: u32) -> bool {
        match operation {
            Unary::Linear { .. } => true,
            Unary::Sqrt => [a, b].iter().all(|argument| self.is_root_of_squares[*argument as usize]),
            _ => false,
        }
    }
}

/// The operations that one depends on, which comes last.
fn needed_for(ops: &[Op], root: u32) -> Vec<Op> {
    let mut needed = Vec::new();
    mark_needed(ops, root, &mut needed);
    let (mut kept, mut places) = (Vec::new(), vec![u32::MAX; ops.len()]);
    for (index, op) in ops.iter().enumerate().filter(|(index, _)| needed[*index]) {
        places[index] = kept.len() as u32;
        kept.push(op.renamed(|argument| places[argument as usize]));
    }
    kept
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::field::{BATCH, Expression, Field, Formula, Graph, Names, Points};

    fn rewritten(text: &str) -> (Expression, Program) {
        let mut graph = Graph::new();
        let names = Names::space(&mut graph);
        let root = Formula::parse(text).compile(&mut graph, &names).expect(text);
        (Expression::new(&graph, root), chosen_first(&Program::new(&graph, root)))
    }

    #[test]
    fn one_root_for_a_union_of_balls_and_the_same_values() {
        let ball = |x: f64, radius: f64| format!("{radius} - sqrt((x - {x})^2 + y^2 + z^2)");
        let balls = |radius: f64| {
            (1..6).fold(ball(0.0, radius), |union, n| format!("max({union}, {})", ball(f64::from(n) * 0.4, radius)))
        };
        let cases = [
            (balls(0.3), 1),
            (format!("min({}, x)", balls(0.3)), 1),
            (format!("-2*({})", balls(0.3)), 1),
            // Radii of their own, roots of what may be negative, and what neither rises nor falls.
            (format!("max({}, {})", ball(0.0, 0.3), ball(1.0, 0.2)), 2),
            ("max(sqrt(x), sqrt(y))".into(), 2),
            ("max(sqrt(x^2 + y^2 + z), sqrt(y^2 + z^2))".into(), 2),
            ("max(abs(x), abs(y))".into(), 0),
        ];
        for (text, roots) in cases {
            let (field, program) = rewritten(&text);
            let is_root = |op: &&Op| matches!(op, Op::Unary(Unary::Sqrt, _));
            assert_eq!(program.ops.iter().filter(is_root).count(), roots, "{text}");
            let mut points = Points::new(DVec3::ZERO);
            let at = |n: usize| ((n * 37 % 101) as f32 / 50.0 - 1.0, (n * 53 % 97) as f32 / 48.0 - 1.0);
            (0..BATCH).for_each(|n| points.push(glam::Vec3::new(at(n).0, at(n).1, at(n + 7).0)));
            let (mut own, mut alone) = ([0.0; BATCH], [0.0; BATCH]);
            field.evaluator().values(&points, &mut own);
            field.for_values_alone().evaluator().values(&points, &mut alone);
            assert_eq!(own.map(f32::to_bits), alone.map(f32::to_bits), "{text}");
        }
    }
}
