//! An expression as a field, and its evaluator: a stack of regions with a pruned program each.

use std::cell::RefCell;
use std::sync::Arc;

use glam::DVec3;

use super::branch::{Branches, Part};
use super::graph::{Graph, Node};
use super::interval::Intervals;
use super::op::{Op, mark_needed};
use super::program::Program;
use super::prune::{Asked, Pruner, has_choices};
use super::tape::Tape;
use super::width::VectorWidth;
use super::{Aabb, BATCH, Evaluator, Field, Gradients, Hint, Hints, Interval, Points, Slope, extent, machine::Machine};

/// So many operations are many parts: bounding all of them for each small region takes longer than entering a wide one
/// before.
const MANY: usize = 64;

/// A node of a [`Graph`] as a field of its own. Cheap to clone.
#[derive(Clone)]
pub struct Expression {
    program: Arc<Program>,
    bounds: Option<Aabb>,
    slope: Slope,
    asked: Asked,
}

impl Expression {
    /// The field of a node. Its box is what construction told, narrowed by interval bounds.
    pub fn new(graph: &Graph, node: Node) -> Self {
        let program = Program::new(graph, node);
        let facts = graph.facts(node);
        let bounds = extent::narrowed(&program, facts.bounds);
        Self { program: Arc::new(program), bounds, slope: facts.slope, asked: Asked::Sign }
    }

    /// The same field, pruned only as far as every value stays what it is: for fields whose values matter away
    /// from their zero set (distances in a morph, colours, weights).
    pub fn keeping_values(self) -> Self {
        Self { asked: Asked::Value, ..self }
    }

    /// The same field, known to be negative outside of a box: for what construction cannot tell.
    pub fn known_within(self, aabb: Aabb) -> Self {
        Self { bounds: Some(aabb), ..self }
    }

    /// How many operations it has.
    pub fn operations(&self) -> usize {
        self.program.ops.len()
    }

    /// An evaluator with given vector instructions instead of [`VectorWidth::chosen`]: for tests and benches.
    /// A width that the processor lacks falls back to a narrower one.
    pub fn evaluator_of_width(&self, width: VectorWidth) -> ExpressionEvaluator<'_> {
        let program = &*self.program;
        let mut whole = Level { ops: program.ops.clone(), ..Level::default() };
        whole.tell_choices();
        ExpressionEvaluator {
            program,
            asked: self.asked,
            externals: program.externals.iter().map(|field| field.evaluator()).collect(),
            levels: vec![whole],
            depth: 0,
            bounds: Intervals::default(),
            pruner: Pruner::default(),
            machine: Machine::new(width, program.externals.len()),
            resolved: Vec::new(),
        }
    }
}

impl Field for Expression {
    fn bounding_box(&self) -> Option<Aabb> {
        self.bounds
    }

    fn slope(&self) -> Slope {
        self.slope
    }

    fn jumps(&self) -> bool {
        self.program.jumps()
    }

    fn reference(&self, position: DVec3) -> f64 {
        self.program.reference(position)
    }

    fn evaluator(&self) -> Box<dyn Evaluator + '_> {
        Box::new(self.evaluator_of_width(VectorWidth::chosen()))
    }
}

/// What a region left of the program. Its memory is kept for the next region at this depth.
#[derive(Default)]
struct Level {
    /// The level whose program this is: itself, or an outer one where nothing could be pruned.
    owner: usize,
    /// None for the whole program.
    region: Option<Aabb>,
    /// Of F over the region, where they are known.
    bounds: Option<Interval>,
    ops: Vec<Op>,
    /// Whether some region may leave something out of `ops`: else bounds are found when somebody asks for them.
    chooses: bool,
    /// Whether none does, and no external field needs to be told of regions.
    irreducible: bool,
    tape: Tape,
    compiled: bool,
    /// The external fields that entered the region.
    entered: Vec<u32>,
    branches: RefCell<Branches>,
    branches_known: std::cell::Cell<bool>,
    branch_tapes: Vec<BranchTape>,
}

/// One smooth branch, made when it is first asked for.
#[derive(Default)]
struct BranchTape {
    compiled: bool,
    tape: Tape,
    /// The external fields that it depends on, as operations, in their order.
    externals: Vec<u32>,
    needed: Vec<bool>,
}

impl BranchTape {
    fn compile(&mut self, ops: &[Op], root: u32) {
        self.tape.compile(ops, &[root]);
        mark_needed(ops, root, &mut self.needed);
        self.externals.clear();
        let needed = &self.needed;
        let is_external = |index: &u32| needed[*index as usize] && matches!(ops[*index as usize], Op::External { .. });
        self.externals.extend((0..=root).filter(is_external));
        self.compiled = true;
    }
}

/// The evaluator of an [`Expression`].
pub struct ExpressionEvaluator<'a> {
    program: &'a Program,
    asked: Asked,
    externals: Vec<Box<dyn Evaluator + 'a>>,
    levels: Vec<Level>,
    depth: usize,
    bounds: Intervals,
    pruner: Pruner,
    machine: Machine,
    resolved: Vec<Op>,
}

impl ExpressionEvaluator<'_> {
    fn owner(&self) -> usize {
        self.levels[self.depth].owner
    }

    /// How many operations remain in the innermost region.
    pub fn operations(&self) -> usize {
        self.levels[self.owner()].ops.len()
    }

    /// Compiles the program of the innermost region if it is not yet.
    fn compile(&mut self) -> usize {
        let owner = self.owner();
        let level = &mut self.levels[owner];
        if !level.compiled {
            level.tape.compile(&level.ops, &[level.ops.len() as u32 - 1]);
            level.compiled = true;
        }
        owner
    }

    fn find_branches(&self) {
        let level = &self.levels[self.depth];
        if !level.branches_known.replace(true) {
            let ops = &self.levels[level.owner].ops;
            // A field read at bent coordinates is taken as one branch.
            let inner = |leaf: u32, at: [u32; 3]| {
                let straight = at.iter().all(|&argument| matches!(ops[argument as usize], Op::Affine(_)));
                if straight { self.externals[leaf as usize].branches() } else { 1 }
            };
            level.branches.borrow_mut().find(ops, inner, zero_leaf(self.program));
        }
    }
}

impl Level {
    fn tell_choices(&mut self) {
        self.chooses = has_choices(&self.ops);
        self.irreducible = !self.chooses && externals_of(&self.ops).next().is_none();
    }
}

/// The external fields of a program.
fn externals_of(ops: &[Op]) -> impl Iterator<Item = u32> {
    ops.iter().filter_map(|op| if let Op::External { leaf, .. } = *op { Some(leaf) } else { None })
}

fn zero_leaf(program: &Program) -> impl Fn(u32) -> bool {
    |leaf| program.affines[leaf as usize] == super::leaf::Affine::ZERO
}

impl Evaluator for ExpressionEvaluator<'_> {
    fn enter(&mut self, region: &Aabb) {
        self.machine.forget_answers();
        let owner = self.owner();
        self.depth += 1;
        if self.levels.len() == self.depth {
            self.levels.push(Level::default());
        }
        let (outer, inner) = self.levels.split_at_mut(self.depth);
        let (Level { ops, irreducible, chooses, .. }, level) = (&outer[owner], &mut inner[0]);
        level.owner = owner;
        level.region = Some(*region);
        level.bounds = None;
        level.entered.clear();
        level.branches_known.set(false);
        level.branch_tapes.iter_mut().for_each(|known| known.compiled = false);
        if *irreducible {
            return;
        }

        // Where nothing is chosen externals' bounds are of no use yet, and may take long.
        let chooses = *chooses;
        self.program.bound(ops, region, chooses, &mut self.externals, &mut self.bounds);
        level.bounds = self.bounds.last().filter(|_| chooses);
        let shorter = self.pruner.plan(ops, &self.bounds, self.asked);
        if !self.externals.is_empty() {
            for (op, asked) in ops.iter().zip(&self.pruner.asked) {
                let Op::External { leaf, .. } = *op else { continue };
                // A field prunes by sign: where its values are needed it is read unpruned.
                let external = &mut self.externals[leaf as usize];
                if *asked == Asked::Sign || *asked == Asked::Value && external.hints(Hint::KeepsValues).keeps_values {
                    level.entered.push(leaf);
                } else {
                    external.leave();
                }
            }
        }
        if shorter {
            self.pruner.shorten(ops, &mut level.ops);
            level.tell_choices();
            level.owner = self.depth;
            level.compiled = false;
        }
    }

    fn hints(&mut self, _: Hint) -> Hints {
        Hints { has_many_parts: self.levels[0].ops.len() >= MANY, ..Hints::NONE }
    }

    fn bounds(&mut self) -> Interval {
        let Level { owner, region, bounds, .. } = self.levels[self.depth];
        let Some(region) = region else { return Interval::ALL };
        bounds.unwrap_or_else(|| {
            let ops = &self.levels[owner].ops;
            self.program.bound(ops, &region, true, &mut self.externals, &mut self.bounds);
            externals_of(ops).for_each(|leaf| self.externals[leaf as usize].leave());
            let found = self.bounds.last();
            self.levels[self.depth].bounds = found;
            found.unwrap_or(Interval::ALL)
        })
    }

    fn leave(&mut self) {
        debug_assert!(self.depth > 0, "every leave matches an enter");
        self.machine.forget_answers();
        for &leaf in &self.levels[self.depth].entered {
            self.externals[leaf as usize].leave();
        }
        self.depth = self.depth.saturating_sub(1);
    }

    fn values(&mut self, points: &Points, out: &mut [f32; BATCH]) {
        let owner = self.compile();
        let Level { ops, tape, .. } = &mut self.levels[owner];
        tape.settle(self.program, points.origin);
        self.machine.read_externals(self.program, &mut self.externals, ops, points, false);
        self.machine.values(tape, points, out);
    }

    fn gradients(&mut self, points: &Points, out: &mut Gradients) {
        let owner = self.compile();
        let Level { ops, tape, .. } = &mut self.levels[owner];
        tape.settle(self.program, points.origin);
        self.machine.read_externals(self.program, &mut self.externals, ops, points, true);
        self.machine.gradients(tape, points, out);
    }

    fn branches(&self) -> usize {
        if self.levels[self.owner()].irreducible {
            return 1;
        }
        self.find_branches();
        self.levels[self.depth].branches.borrow().list.len()
    }

    fn branch(&mut self, branch: usize, points: &Points, out: &mut Gradients) {
        self.find_branches();
        let owner = self.owner();
        let Self { program, externals, levels, machine, resolved, .. } = self;
        let (outer, inner) = levels.split_at_mut(self.depth);
        let Level { ops: own, branches, branch_tapes, .. } = &mut inner[0];
        let ops = if owner == self.depth { own } else { &outer[owner].ops };
        let branches = branches.get_mut();
        let chosen = branches.list[branch];
        match chosen.part {
            Part::External(inner) => {
                let op = ops[chosen.op as usize];
                machine.read_branch(program, externals, ops, op, inner as usize, points, out);
            }
            Part::Whole | Part::Sides(_) => {
                if branch_tapes.len() <= branch {
                    branch_tapes.resize_with(branch + 1, Default::default);
                }
                let known = &mut branch_tapes[branch];
                if !known.compiled {
                    branches.resolve(ops, chosen, zero_leaf(program), resolved);
                    known.compile(resolved, chosen.op);
                }
                known.tape.settle(program, points.origin);
                if !known.externals.is_empty() {
                    // Other branches' fields may be the dearest part of F.
                    let some = known.externals.iter().map(|index| ops[*index as usize]);
                    machine.read_some(program, externals, ops, some, points, true);
                }
                machine.gradients(&known.tape, points, out);
            }
        }
        if chosen.factor != 1.0 {
            let factor = chosen.factor as f32;
            for array in [&mut out.value, &mut out.dx, &mut out.dy, &mut out.dz] {
                array[..points.len].iter_mut().for_each(|value| *value *= factor);
            }
        }
    }
}
