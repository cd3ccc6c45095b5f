//! The working memory of an evaluator, and the reading of external fields at mapped positions.

use glam::{DMat3, DVec3};

use super::kernel::{self, Lanes, Run};
use super::kernel_gradient::{self, Dual};
use super::leaf::Affine;
use super::op::Op;
use super::program::Program;
use super::tape::Tape;
use super::width::VectorWidth;
use super::{BATCH, Evaluator, Gradients, Points};

/// Registers and buffers, made once for each evaluator.
pub(super) struct Machine {
    width: VectorWidth,
    registers: Vec<Lanes>,
    duals: Vec<Dual>,
    /// What each external field answered for the batch.
    inputs: Vec<Box<Gradients>>,
    spare: Option<Box<Gradients>>,
    /// The batch that it was asked at.
    asked_at: Box<Points>,
    /// Which fields answered at that batch, and whether with gradients: several branches may depend on one.
    answered: Vec<Option<bool>>,
    /// Positions in an external field's own space.
    local: Box<Points>,
    /// Those positions' own gradients, where they are not affine.
    moved: Box<[Gradients; 3]>,
    arguments: Tape,
}

/// Where an external field is read.
enum Place {
    /// At the position itself.
    Here,
    /// At an affine map of it.
    Mapped([Affine; 3]),
    /// At values that are computed.
    Computed,
}

fn place(program: &Program, ops: &[Op], at: [u32; 3]) -> Place {
    let form = |argument: u32| match ops[argument as usize] {
        Op::Affine(leaf) => Some(program.affines[leaf as usize]),
        _ => None,
    };
    match at.map(form) {
        [Some(x), Some(y), Some(z)] => {
            let axes = [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| Affine::new(axis, 0.0));
            if [x, y, z] == axes { Place::Here } else { Place::Mapped([x, y, z]) }
        }
        _ => Place::Computed,
    }
}

impl Machine {
    pub fn new(width: VectorWidth, externals: usize) -> Self {
        Self {
            width,
            registers: Vec::new(),
            duals: Vec::new(),
            inputs: (0..externals).map(|_| Box::default()).collect(),
            spare: None,
            asked_at: Box::new(Points::new(DVec3::ZERO)),
            answered: vec![None; externals],
            local: Box::new(Points::new(DVec3::ZERO)),
            moved: Box::new(std::array::from_fn(|_| Gradients::new())),
            arguments: Tape::default(),
        }
    }

    /// Fields may answer otherwise from now on: another region was entered.
    pub fn forget_answers(&mut self) {
        self.answered.fill(None);
    }

    /// The tape's first output at the points.
    pub fn values(&mut self, tape: &Tape, points: &Points, out: &mut [f32; BATCH]) {
        let run = Run { tape, points, inputs: &self.inputs };
        kernel::run(self.width, &run, &mut self.registers, &mut [out]);
    }

    /// The tape's first output with its gradient at the points.
    pub fn gradients(&mut self, tape: &Tape, points: &Points, out: &mut Gradients) {
        let run = Run { tape, points, inputs: &self.inputs };
        kernel_gradient::run(self.width, &run, &mut self.duals, &mut [out]);
    }

    /// Asks every external field of a program, in order, so that one may be read where another says.
    pub fn read_externals(
        &mut self,
        program: &Program,
        externals: &mut [Box<dyn Evaluator + '_>],
        ops: &[Op],
        points: &Points,
        gradients: bool,
    ) {
        if !externals.is_empty() {
            self.read_some(program, externals, ops, ops.iter().copied(), points, gradients);
        }
    }

    /// The same of some of the program's operations, in their order.
    pub fn read_some(
        &mut self,
        program: &Program,
        externals: &mut [Box<dyn Evaluator + '_>],
        ops: &[Op],
        some: impl Iterator<Item = Op>,
        points: &Points,
        gradients: bool,
    ) {
        if !same_points(points, &self.asked_at) {
            self.forget_answers();
            copy_points(points, &mut self.asked_at);
        }
        for op in some {
            let Op::External { leaf, at } = op else { continue };
            let answered = &mut self.answered[leaf as usize];
            if answered.is_some_and(|with_gradients| with_gradients || !gradients) {
                continue;
            }
            *answered = Some(gradients);
            // What earlier fields answered must stay readable while this one is asked.
            let mut answer = self.spare.take().unwrap_or_default();
            let external = &mut externals[leaf as usize];
            let read = |points: &Points, answer: &mut Gradients| {
                if gradients { external.gradients(points, answer) } else { external.values(points, &mut answer.value) }
            };
            self.read_at(program, ops, at, points, gradients, &mut answer, read);
            self.spare = Some(std::mem::replace(&mut self.inputs[leaf as usize], answer));
        }
    }

    /// One smooth branch of an external field, with its gradient.
    #[expect(clippy::too_many_arguments, reason = "the pieces of one evaluator, borrowed apart")]
    pub fn read_branch(
        &mut self,
        program: &Program,
        externals: &mut [Box<dyn Evaluator + '_>],
        ops: &[Op],
        op: Op,
        branch: usize,
        points: &Points,
        out: &mut Gradients,
    ) {
        let Op::External { leaf, at } = op else { return };
        if matches!(place(program, ops, at), Place::Computed) {
            self.read_externals(program, externals, ops, points, true);
            out.clone_from(&self.inputs[leaf as usize]);
            return;
        }
        let external = &mut externals[leaf as usize];
        let read = |points: &Points, answer: &mut Gradients| external.branch(branch, points, answer);
        self.read_at(program, ops, at, points, true, out, read);
    }

    /// Calls `read` with the positions mapped, and maps the gradients back.
    #[expect(clippy::too_many_arguments, reason = "the pieces of one evaluator, borrowed apart")]
    fn read_at(
        &mut self,
        program: &Program,
        ops: &[Op],
        at: [u32; 3],
        points: &Points,
        gradients: bool,
        answer: &mut Gradients,
        read: impl FnOnce(&Points, &mut Gradients),
    ) {
        match place(program, ops, at) {
            Place::Here => read(points, answer),
            Place::Mapped(forms) => {
                map_points(forms, points, &mut self.local);
                read(&self.local, answer);
                if gradients {
                    map_gradients(forms, points.len, answer);
                }
            }
            Place::Computed => {
                self.compute_points(program, ops, at, points, gradients);
                read(&self.local, answer);
                if gradients {
                    self.chain_gradients(points.len, answer);
                }
            }
        }
    }

    /// Evaluates the three values where a field is read, with gradients where asked.
    fn compute_points(&mut self, program: &Program, ops: &[Op], at: [u32; 3], points: &Points, gradients: bool) {
        self.arguments.compile(ops, &at);
        self.arguments.settle(program, points.origin);
        let run = Run { tape: &self.arguments, points, inputs: &self.inputs };
        let local = &mut *self.local;
        (local.origin, local.len) = (DVec3::ZERO, points.len);
        if gradients {
            let [x, y, z] = &mut *self.moved;
            kernel_gradient::run(self.width, &run, &mut self.duals, &mut [x, y, z]);
            (local.x, local.y, local.z) = (x.value, y.value, z.value);
        } else {
            kernel::run(self.width, &run, &mut self.registers, &mut [&mut local.x, &mut local.y, &mut local.z]);
        }
    }

    /// ∇(F∘g) = Σ ∂F/∂gᵢ · ∇gᵢ.
    fn chain_gradients(&self, len: usize, answer: &mut Gradients) {
        let [x, y, z] = &*self.moved;
        for i in 0..len {
            let along = answer.gradient(i);
            let total = x.gradient(i) * along.x + y.gradient(i) * along.y + z.gradient(i) * along.z;
            (answer.dx[i], answer.dy[i], answer.dz[i]) = (total.x, total.y, total.z);
        }
    }
}

fn same_points(a: &Points, b: &Points) -> bool {
    let same = |a: &[f32; BATCH], b: &[f32; BATCH], len: usize| a[..len] == b[..len];
    let len = a.len;
    len == b.len && a.origin == b.origin && same(&a.x, &b.x, len) && same(&a.y, &b.y, len) && same(&a.z, &b.z, len)
}

fn copy_points(from: &Points, to: &mut Points) {
    (to.origin, to.len) = (from.origin, from.len);
    for (to, all) in [(&mut to.x, &from.x), (&mut to.y, &from.y), (&mut to.z, &from.z)] {
        to[..from.len].copy_from_slice(&all[..from.len]);
    }
}

/// Positions under an affine map: the origin in `f64`, offsets in `f32`.
fn map_points([fx, fy, fz]: [Affine; 3], points: &Points, local: &mut Points) {
    local.origin = DVec3::new(fx.at(points.origin), fy.at(points.origin), fz.at(points.origin));
    local.len = points.len;
    let [rx, ry, rz] = [fx, fy, fz].map(|form| form.slope.as_vec3());
    for i in 0..points.len {
        let (x, y, z) = (points.x[i], points.y[i], points.z[i]);
        local.x[i] = rx.x * x + rx.y * y + rx.z * z;
        local.y[i] = ry.x * x + ry.y * y + ry.z * z;
        local.z[i] = rz.x * x + rz.y * y + rz.z * z;
    }
}

/// Gradients in a mapped space back to the world's: times the transposed map.
fn map_gradients(forms: [Affine; 3], len: usize, answer: &mut Gradients) {
    let [x, y, z] = forms.map(|form| form.slope);
    // The rows of the map are the columns of its transpose.
    let transposed = DMat3::from_cols(x, y, z).as_mat3();
    for i in 0..len {
        let total = transposed * answer.gradient(i);
        (answer.dx[i], answer.dy[i], answer.dz[i]) = (total.x, total.y, total.z);
    }
}
