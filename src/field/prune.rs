//! Shorter programs for a region, from bounds of every operation over it.
//!
//! Two things may be asked of an operation. *Value*: it is needed exactly. *Sign*: only its sign, and its value
//! and gradient where it is zero. The root is asked for its sign unless a field keeps values; set operations,
//! negation and constant factors pass the question on, everything else needs values. Where signs suffice, an
//! argument of a union that is negative throughout is dropped (of an intersection: positive), and a union with
//! an argument that is positive throughout is that argument; a power, which is level where surfaces meet, is the maximum or
//! minimum, which is not. Where values are needed, only choices that are the
//! same to the last bit are made: the greater of two that do not overlap, the absolute value of a number of
//! known sign, a sum with an exact zero.
//!
//! Of a minimum and a maximum among many, what each operand may be without deciding is known from all the others, as in
//! a game tree (alpha-beta pruning): an operand of a minimum that is above the bound of the whole minimum is dropped,
//! however far up the tree that bound comes from. [`Pruner::windows`] holds, of each operation, the values that matter:
//! above them it may be anything that is not below them, and the other way round.

use super::Interval;
use super::interval::Intervals;
use super::op::{Binary, Op, Same, Set, Unary, choose};

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
    /// This other one of the same arguments has its sign, and better slopes.
    Sided(Binary),
}

/// The window of an operation that nothing asked for.
const NO_VALUE: Interval = Interval::new(f64::INFINITY, f64::NEG_INFINITY);

/// Scratch memory of pruning.
#[derive(Default)]
pub(super) struct Pruner {
    pub asked: Vec<Asked>,
    /// Where values are asked for: those that matter.
    windows: Vec<Interval>,
    choices: Vec<Choice>,
    places: Vec<u32>,
}

/// What an operation is throughout its arguments' bounds, or, of a union or an intersection, within a window.
fn choose(op: Op, window: Interval, bounds: &Intervals) -> Choice {
    let chosen = |same: Same, arguments: &[u32]| match same {
        Same::Itself => Choice::Keep,
        Same::Argument(at) => Choice::Is(arguments[at]),
        Same::Negated(at) => Choice::Negated(arguments[at]),
    };
    match op {
        Op::Unary(operation, a) => chosen(operation.same([bounds.at(a)]), &[a]),
        Op::Binary(operation, a, b) => {
            let (first, second) = (bounds.at(a), bounds.at(b));
            match (chosen(operation.same([first, second]), &[a, b]), operation.nature().set) {
                (Choice::Keep, Some(set)) => {
                    same_in(window, set, (a, first), (b, second)).map_or(Choice::Keep, Choice::Is)
                }
                (choice, _) => choice,
            }
        }
        Op::Choose([condition, then, other]) => match choose::side(bounds.at(condition)) {
            Some(first) => Choice::Is(if first { then } else { other }),
            None => Choice::Keep,
        },
        _ => Choice::Keep,
    }
}

/// The argument that a union or an intersection may be replaced by: where the operation's value lies in a window it
/// is that argument's, elsewhere both lie on the same side. Over the window of zero alone, the one that has the
/// operation's sign and zero set; this holds for any set operation, other windows for minima and maxima. Strictly, since
/// an argument that is a constant may be the end of the window itself.
fn same_in(window: Interval, set: Set, a: (u32, Interval), b: (u32, Interval)) -> Option<u32> {
    let (below, above) = (|x: Interval| x.hi < window.lo, |x: Interval| x.lo > window.hi);
    // Neutral: drop the argument. Decided: it settles the side.
    let union = set == Set::Union;
    let neutral = |x| if union { below(x) } else { above(x) };
    let decided = |x| if union { above(x) } else { below(x) };
    if neutral(a.1) || decided(b.1) {
        Some(b.0)
    } else if neutral(b.1) || decided(a.1) {
        Some(a.0)
    } else {
        None
    }
}

/// Asks the arguments of a kept operation what it needs.
fn ask_arguments(op: Op, asked: Asked, window: Interval, mut ask: impl FnMut(u32, Asked, Interval)) {
    match op {
        Op::Unary(Unary::Linear { offset: 0.0, .. }, a) => ask(a, asked, Interval::ALL),
        Op::Binary(operation, a, b) if operation.nature().set.is_some() => {
            ask(a, asked, window);
            ask(b, asked, window);
        }
        Op::Choose([condition, then, other]) => {
            ask(condition, Asked::Value, Interval::ALL);
            ask(then, asked, window);
            ask(other, asked, window);
        }
        _ => op.arguments(|argument| ask(argument, Asked::Value, Interval::ALL)),
    }
}

/// Whether something may be left out of a program in some region that is not flat: where an operation has a choice, or is
/// zero throughout, so that a sum is its other argument. (External fields that are zero throughout are read.)
pub(super) fn has_choices(ops: &[Op]) -> bool {
    ops.iter().any(|op| op.nature().shortens)
}

impl Pruner {
    /// Finds out what is asked of each operation, and how it can be met. Returns whether anything can be left
    /// out.
    pub fn plan(&mut self, ops: &[Op], bounds: &Intervals, root: Asked) -> bool {
        self.asked.clear();
        self.asked.resize(ops.len(), Asked::Nothing);
        self.windows.clear();
        self.windows.resize(ops.len(), NO_VALUE);
        self.choices.clear();
        self.choices.resize(ops.len(), Choice::Keep);
        if let (Some(asked), Some(window)) = (self.asked.last_mut(), self.windows.last_mut()) {
            (*asked, *window) = (root, Interval::ALL);
        }
        let mut shorter = false;
        for (index, &op) in ops.iter().enumerate().rev() {
            let asked = self.asked[index];
            if asked == Asked::Nothing {
                shorter = true;
                continue;
            }
            let window = self.windows[index];
            let matters = match op {
                _ if asked == Asked::Sign => Interval::ALL,
                Op::Binary(Binary::Min, ..) => Interval::new(window.lo, window.hi.min(bounds.at(index as u32).hi)),
                Op::Binary(Binary::Max, ..) => Interval::new(window.lo.max(bounds.at(index as u32).lo), window.hi),
                _ => Interval::ALL,
            };
            let choice = choose(op, if asked == Asked::Sign { Interval::ZERO } else { matters }, bounds);
            let choice = match (choice, op) {
                (Choice::Keep, Op::Binary(operation, ..)) if asked == Asked::Sign => {
                    operation.sided().map_or(Choice::Keep, Choice::Sided)
                }
                _ => choice,
            };
            self.choices[index] = choice;
            let (all, windows) = (&mut self.asked, &mut self.windows);
            let mut ask = |argument: u32, asked: Asked, window: Interval| {
                let argument = argument as usize;
                all[argument] = all[argument].max(asked);
                windows[argument] = windows[argument].union(window);
            };
            match choice {
                Choice::Keep => ask_arguments(op, asked, matters, ask),
                Choice::Sided(_) => {
                    ask_arguments(op, asked, matters, ask);
                    shorter = true;
                }
                Choice::Is(a) => {
                    ask(a, asked, window);
                    shorter = true;
                }
                Choice::Negated(a) => {
                    ask(a, asked, Interval::ALL);
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
                        Choice::Sided(other) => op.with(other).renamed(|argument| places[argument as usize]),
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
            let root = Formula::parse(text).compile(&mut graph, &names).expect(text);
            let program = Program::new(&graph, root);
            assert_eq!(has_choices(&program.ops), chooses, "{text}");
            // Among them such that begin or end where coordinates are zero.
            let shortened = (0..2000).any(|i: i32| {
                let corner =
                    DVec3::new(f64::from(i % 9 - 4), f64::from(i / 9 % 9 - 4), f64::from(i / 81 % 9 - 4)) * 0.5;
                let region = Aabb::new(corner, corner + 0.5 * f64::from(1 + i / 729));
                let mut bounds = Intervals::default();
                program.bound(&program.ops, &region, true, &mut [], &mut bounds);
                Pruner::default().plan(&program.ops, &bounds, Asked::Sign)
            });
            assert!(chooses || !shortened, "{text}");
            assert!(shortened || !text.contains("max") && !text.contains("abs"), "{text}");
        }
    }

    /// Trees of minima and maxima over slanted half-spaces, some of them used twice, and constants.
    fn random_tree(seed: u64) -> Program {
        let mut random = crate::field::cells::Random::new(seed, 0, crate::field::cells::Purpose::Split);
        let mut graph = Graph::new();
        let mut nodes: Vec<_> = (0..24)
            .map(|i| match i % 8 {
                0 => graph.constant(random.range(-0.5, 0.5)),
                _ => {
                    let direction = random.direction();
                    graph.half_space(direction, random.range(-0.5, 1.0))
                }
            })
            .collect();
        while nodes.len() > 1 {
            let a = nodes.swap_remove(random.index(nodes.len()));
            let b = nodes[random.index(nodes.len())];
            if random.unit() < 0.8 {
                nodes.retain(|node| *node != b);
            }
            nodes.push(if random.unit() < 0.5 { graph.min(a, b) } else { graph.max(a, b) });
        }
        Program::new(&graph, nodes[0])
    }

    #[test]
    fn what_cannot_decide_a_minimum_or_maximum_is_left_out_and_the_value_stays() {
        let (mut before, mut after) = (0, 0);
        for seed in 0..200 {
            let whole = random_tree(seed);
            let mut random = crate::field::cells::Random::new(seed, 1, crate::field::cells::Purpose::Split);
            for _ in 0..20 {
                let mut within = || DVec3::new(random.unit(), random.unit(), random.unit());
                let corner = within() * 4.0 - 2.0;
                let region = Aabb::new(corner, corner + within() * 0.5);
                let mut bounds = Intervals::default();
                whole.bound(&whole.ops, &region, true, &mut [], &mut bounds);
                let (mut pruner, mut ops) = (Pruner::default(), whole.ops.clone());
                if pruner.plan(&whole.ops, &bounds, Asked::Value) {
                    pruner.shorten(&whole.ops, &mut ops);
                }
                (before, after) = (before + whole.ops.len(), after + ops.len());
                let (affines, quadrics) = (whole.affines.clone(), whole.quadrics.clone());
                let pruned = Program { ops, affines, quadrics, externals: Vec::new() };
                for _ in 0..50 {
                    let position = region.min + within() * region.size();
                    assert_eq!(pruned.reference(position), whole.reference(position), "seed {seed} at {position}");
                }
            }
        }
        assert!(after * 5 < before, "{after} of {before}");
    }

    /// A power is level where surfaces meet, and closest points are not found there.
    #[test]
    fn where_signs_suffice_a_power_is_none() {
        let mut graph = Graph::new();
        let planes = [DVec3::X, DVec3::Y].map(|normal| graph.half_space(normal, 0.0));
        let system = crate::field::SetSystem::Rm { order: 2 };
        let corner = graph.intersection(system, &planes);
        let root = graph.difference(system, corner, &[planes[0]]);
        let program = Program::new(&graph, root);
        let region = Aabb::new(DVec3::splat(-0.1), DVec3::splat(0.1));
        let mut bounds = Intervals::default();
        program.bound(&program.ops, &region, true, &mut [], &mut bounds);
        let (mut pruner, mut ops) = (Pruner::default(), Vec::new());
        for (asked, wanted) in [(Asked::Sign, 0), (Asked::Value, 2)] {
            pruner.plan(&program.ops, &bounds, asked);
            pruner.shorten(&program.ops, &mut ops);
            let powers = ops.iter().filter(|op| matches!(op, Op::Binary(Binary::RmIntersection { .. }, ..))).count();
            assert_eq!(powers, wanted, "{ops:?}");
        }
    }

    #[test]
    fn of_many_balls_those_remain_that_may_be_nearest() {
        // Pairs of neighbours in the tree are far apart: neither of two decides alone.
        let text =
            (0..64).map(|i| format!("(x - {})^2 + y^2 + z^2", i * 37 % 64)).reduce(|a, b| format!("min({a}, {b})"));
        let mut graph = Graph::new();
        let names = Names::space(&mut graph);
        let root = Formula::parse(&text.expect("balls")).compile(&mut graph, &names);
        let program = Program::new(&graph, root.expect("a sound formula"));
        let region = Aabb::new(DVec3::new(20.1, 5.0, 5.0), DVec3::new(20.3, 5.1, 5.1));
        let mut bounds = Intervals::default();
        program.bound(&program.ops, &region, true, &mut [], &mut bounds);
        let (mut pruner, mut ops) = (Pruner::default(), Vec::new());
        assert!(pruner.plan(&program.ops, &bounds, Asked::Value));
        pruner.shorten(&program.ops, &mut ops);
        let balls = ops.iter().filter(|op| matches!(op, Op::Quadric(_))).count();
        assert!(balls <= 3, "{balls}");
    }
}
