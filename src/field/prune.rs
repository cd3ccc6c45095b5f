//! Shorter programs for a region, from bounds of every operation over it.
//!
//! Two things may be asked of an operation. *Value*: it is needed exactly. *Sign*: only its sign, and its value
//! and gradient where it is zero. The root is asked for its sign unless a field keeps values; set operations,
//! negation and constant factors pass the question on, everything else needs values. Where signs suffice, an
//! argument of a union that is negative throughout is dropped (of an intersection: positive), and a union with
//! an argument that is positive throughout is that argument. Where values are needed, only choices that are the
//! same to the last bit are made: the greater of two that do not overlap, the absolute value of a number of
//! known sign, a sum with an exact zero.

use super::Interval;
use super::op::{Binary, Op, Unary};

/// What is asked of an operation.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Asked {
    Nothing,
    Sign,
    Value,
}

#[derive(Clone, Copy)]
enum Choice {
    Keep,
    /// The operation is one of its arguments here.
    Is(u32),
    /// The operation is its argument negated.
    Negated(u32),
}

/// Scratch memory of pruning.
#[derive(Default)]
pub(super) struct Pruner {
    pub asked: Vec<Asked>,
    choices: Vec<Choice>,
    places: Vec<u32>,
}

fn choose(op: Op, asked: Asked, bounds: &[Interval]) -> Choice {
    match op {
        Op::Unary(Unary::Abs, a) => match bounds[a as usize] {
            bound if bound.lo >= 0.0 => Choice::Is(a),
            bound if bound.hi <= 0.0 => Choice::Negated(a),
            _ => Choice::Keep,
        },
        Op::Binary(operation, a, b) => {
            let (first, second) = (bounds[a as usize], bounds[b as usize]);
            match operation {
                Binary::Add if first == Interval::ZERO => Choice::Is(b),
                Binary::Add | Binary::Sub if second == Interval::ZERO => Choice::Is(a),
                _ if !operation.is_set_operation() => Choice::Keep,
                _ => same_value(operation, (a, first), (b, second))
                    .or_else(|| (asked == Asked::Sign).then(|| same_sign(operation, (a, first), (b, second)))?)
                    .map_or(Choice::Keep, Choice::Is),
            }
        }
        _ => Choice::Keep,
    }
}

/// The argument that the operation equals throughout.
fn same_value(operation: Binary, a: (u32, Interval), b: (u32, Interval)) -> Option<u32> {
    let below = |x: (u32, Interval), y: (u32, Interval)| (x.1.hi <= y.1.lo).then_some(x.0);
    match operation {
        Binary::Max => below(b, a).map(|_| a.0).or(below(a, b).map(|_| b.0)),
        Binary::Min => below(a, b).or(below(b, a)),
        // Beside an argument that is inside throughout, the other one's value is the distance.
        Binary::Corner if b.1.lo >= 0.0 => below(a, b),
        Binary::Corner if a.1.lo >= 0.0 => below(b, a),
        _ => None,
    }
}

/// The argument that has the operation's sign and zero set throughout.
fn same_sign(operation: Binary, a: (u32, Interval), b: (u32, Interval)) -> Option<u32> {
    let (negative, positive) = (|x: Interval| x.hi < 0.0, |x: Interval| x.lo > 0.0);
    // Neutral: drop the argument. Decided: it settles the sign.
    let union = operation.is_union();
    let neutral = |x| if union { negative(x) } else { positive(x) };
    let decided = |x| if union { positive(x) } else { negative(x) };
    if neutral(a.1) || decided(b.1) {
        Some(b.0)
    } else if neutral(b.1) || decided(a.1) {
        Some(a.0)
    } else {
        None
    }
}

/// Asks the arguments of a kept operation what it needs.
fn ask_arguments(op: Op, asked: Asked, mut ask: impl FnMut(u32, Asked)) {
    match op {
        Op::Unary(Unary::Linear { offset: 0.0, .. }, a) => ask(a, asked),
        Op::Binary(operation, a, b) if operation.is_set_operation() => {
            ask(a, asked);
            ask(b, asked);
        }
        _ => op.arguments(|argument| ask(argument, Asked::Value)),
    }
}

/// Whether something may be left out of a program in some region that is not flat: where an operation has a choice, or is
/// zero throughout, so that a sum is its other argument. (External fields that are zero throughout are read.)
pub(super) fn has_choices(ops: &[Op]) -> bool {
    ops.iter().any(|op| match op {
        Op::Affine(_) | Op::Quadric(_) | Op::External { .. } => false,
        Op::Unary(operation, _) => matches!(operation, Unary::Abs | Unary::Floor | Unary::Sign | Unary::Smooth),
        Op::Binary(operation, ..) => {
            operation.is_set_operation() || matches!(operation, Binary::Displacement | Binary::Atan2)
        }
    })
}

impl Pruner {
    /// Finds out what is asked of each operation, and how it can be met. Returns whether anything can be left
    /// out.
    pub fn plan(&mut self, ops: &[Op], bounds: &[Interval], root: Asked) -> bool {
        self.asked.clear();
        self.asked.resize(ops.len(), Asked::Nothing);
        self.choices.clear();
        self.choices.resize(ops.len(), Choice::Keep);
        if let Some(last) = self.asked.last_mut() {
            *last = root;
        }
        let mut shorter = false;
        for (index, &op) in ops.iter().enumerate().rev() {
            let asked = self.asked[index];
            if asked == Asked::Nothing {
                shorter = true;
                continue;
            }
            let choice = choose(op, asked, bounds);
            self.choices[index] = choice;
            let all = &mut self.asked;
            let mut ask = |argument: u32, asked: Asked| {
                let slot = &mut all[argument as usize];
                *slot = (*slot).max(asked);
            };
            match choice {
                Choice::Keep => ask_arguments(op, asked, ask),
                Choice::Is(a) => {
                    ask(a, asked);
                    shorter = true;
                }
                Choice::Negated(a) => {
                    ask(a, asked);
                    shorter = true;
                }
            }
        }
        shorter
    }

    /// Writes the planned program.
    pub fn shorten(&mut self, ops: &[Op], out: &mut Vec<Op>) {
        out.clear();
        self.places.clear();
        for (index, &op) in ops.iter().enumerate() {
            let places = &self.places;
            let place = match self.choices[index] {
                _ if self.asked[index] == Asked::Nothing => u32::MAX,
                Choice::Is(a) => places[a as usize],
                choice => {
                    out.push(match choice {
                        Choice::Negated(a) => Op::Unary(Unary::Linear { scale: -1.0, offset: 0.0 }, places[a as usize]),
                        _ => op.renamed(|argument| places[argument as usize]),
                    });
                    out.len() as u32 - 1
                }
            };
            self.places.push(place);
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::field::{Aabb, Formula, Graph, Names, program::Program};

    #[test]
    fn nothing_is_left_out_of_a_program_without_choices() {
        let cases = [
            ("0.25^2 - (sqrt(x^2 + y^2) - 0.65)^2 - z^2", false),
            ("x*y - z^3 + exp(x - y)", false),
            ("sin(x)*cos(y) + 1 / (z + 9) - log(z^2 + 1)", false),
            ("max(x, y)", true),
            ("x + abs(y)", true),
            ("x + smoothstep(0, 1, y)", true),
            ("y + floor(x)", true),
            ("y + sign(x)", true),
            ("y - atan2(z, x)", true),
        ];
        for (text, chooses) in cases {
            let mut graph = Graph::new();
            let names = Names::space(&mut graph);
            let root = Formula::parse(text).and_then(|formula| formula.compile(&mut graph, &names)).expect(text);
            let program = Program::new(&graph, root);
            assert_eq!(has_choices(&program.ops), chooses, "{text}");
            // Among them such that begin or end where coordinates are zero.
            let shortened = (0..2000).any(|i: i32| {
                let corner =
                    DVec3::new(f64::from(i % 9 - 4), f64::from(i / 9 % 9 - 4), f64::from(i / 81 % 9 - 4)) * 0.5;
                let region = Aabb::new(corner, corner + 0.5 * f64::from(1 + i / 729));
                let mut bounds = Vec::new();
                program.bound(&program.ops, &region, true, &mut [], &mut bounds);
                Pruner::default().plan(&program.ops, &bounds, Asked::Sign)
            });
            assert!(chooses || !shortened, "{text}");
            assert!(shortened || !text.contains("max") && !text.contains("abs"), "{text}");
        }
    }
}
