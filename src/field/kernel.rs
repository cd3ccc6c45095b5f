//! The batch loops for values: each instruction over [`LANES`] points, compiled for several vector widths.

use multiversion::multiversion;
use multiversion::target::match_target;

use super::op::{Operation, Visitor, choose};
use super::tape::{Code, Instruction, LaneQuadric, QuadricShape, Tape};
use super::width::VectorWidth;
use super::{BATCH, Gradients, Points};

/// Points in one pass over a tape. Fewer: more time goes to fetching instructions; more: the registers of a large
/// tape no longer stay in the nearest cache.
pub(super) const LANES: usize = 256;

/// Up to this many points take one short pass: a search for feet asks for a handful at a time.
const FEW: usize = 64;

/// One register: a value for each lane.
#[derive(Clone)]
#[repr(align(64))]
pub(super) struct Lanes(pub [f32; LANES]);

impl Lanes {
    /// The lanes of a pass.
    #[inline(always)]
    fn get<const N: usize>(&self) -> &[f32; N] {
        self.0.first_chunk().expect("no pass is longer than a register")
    }

    #[inline(always)]
    fn get_mut<const N: usize>(&mut self) -> &mut [f32; N] {
        self.0.first_chunk_mut().expect("no pass is longer than a register")
    }
}

/// A tape with what it reads, for one batch.
pub(super) struct Run<'a> {
    pub tape: &'a Tape,
    pub points: &'a Points,
    /// What other fields answered at these points.
    pub inputs: &'a [Box<Gradients>],
}

/// Writes each output of the tape at the points, a batch for each.
pub(super) fn run(width: VectorWidth, run: &Run, registers: &mut Vec<Lanes>, outs: &mut [&mut [f32; BATCH]]) {
    if registers.len() < run.tape.registers {
        registers.resize(run.tape.registers, Lanes([0.0; LANES]));
    }
    match width {
        VectorWidth::Sse2 => run_sse2(run, registers, outs),
        VectorWidth::Avx2 => run_avx2(run, registers, outs),
        VectorWidth::Avx512 => run_avx512(run, registers, outs),
    }
}

/// In passes of all lanes, or of few where there are few points.
#[inline(always)]
fn either(run: &Run, registers: &mut [Lanes], outs: &mut [&mut [f32; BATCH]]) {
    if run.points.len <= FEW { body::<FEW>(run, registers, outs) } else { body::<LANES>(run, registers, outs) }
}

/// Short of what it is compiled for each of these hands on to the next narrower one, so that none is compiled twice.
#[multiversion(targets("x86_64+avx+avx2+avx512f+avx512bw+avx512dq+avx512vl"))]
fn run_avx512(run: &Run, registers: &mut [Lanes], outs: &mut [&mut [f32; BATCH]]) {
    match_target! {
        "x86_64+avx+avx2+avx512f+avx512bw+avx512dq+avx512vl" => either(run, registers, outs),
        _ => run_avx2(run, registers, outs),
    }
}

#[multiversion(targets("x86_64+avx+avx2"))]
fn run_avx2(run: &Run, registers: &mut [Lanes], outs: &mut [&mut [f32; BATCH]]) {
    match_target! {
        "x86_64+avx+avx2" => either(run, registers, outs),
        _ => run_sse2(run, registers, outs),
    }
}

#[inline(never)]
fn run_sse2(run: &Run, registers: &mut [Lanes], outs: &mut [&mut [f32; BATCH]]) {
    either(run, registers, outs);
}

/// The lanes of a batch that one pass covers.
#[inline(always)]
pub(super) fn pass<const N: usize>(batch: &[f32; BATCH], first: usize) -> &[f32; N] {
    batch[first..].first_chunk().expect("a pass begins a whole number of passes before the batch's end")
}

/// An instruction on every lane of the registers.
struct OnLanes<'a, const N: usize> {
    registers: &'a mut [Lanes],
    at: &'a Instruction,
}

impl<const N: usize> Visitor<1> for OnLanes<'_, N> {
    #[inline(always)]
    fn visit(self, operation: impl Operation<1>) {
        let Self { registers, at } = self;
        let [out, a] = registers
            .get_disjoint_mut([at.out as usize, at.a as usize])
            .expect("an output never shares its argument's register");
        for (out, &a) in out.get_mut::<N>().iter_mut().zip(a.get::<N>()) {
            (*out, _) = operation.slopes([a]);
        }
    }
}

/// The arguments may be one register.
impl<const N: usize> Visitor<2> for OnLanes<'_, N> {
    #[inline(always)]
    fn visit(self, operation: impl Operation<2>) {
        let Self { registers, at } = self;
        if at.a == at.b {
            let [out, a] = registers
                .get_disjoint_mut([at.out as usize, at.a as usize])
                .expect("an output never shares its argument's register");
            for (out, &a) in out.get_mut::<N>().iter_mut().zip(a.get::<N>()) {
                (*out, _) = operation.slopes([a, a]);
            }
            return;
        }
        let [out, a, b] = registers
            .get_disjoint_mut([at.out as usize, at.a as usize, at.b as usize])
            .expect("an output never shares its argument's register");
        for ((out, &a), &b) in out.get_mut::<N>().iter_mut().zip(a.get::<N>()).zip(b.get::<N>()) {
            (*out, _) = operation.slopes([a, b]);
        }
    }
}

#[inline(always)]
fn body<const N: usize>(run: &Run, registers: &mut [Lanes], outs: &mut [&mut [f32; BATCH]]) {
    for first in (0..run.points.len).step_by(N) {
        let (x, y, z) = (pass(&run.points.x, first), pass(&run.points.y, first), pass(&run.points.z, first));
        for at in &run.tape.code {
            match at.code {
                Code::Affine(row) => {
                    affine::<N>(run.tape.rows[row as usize], [x, y, z], registers[at.out as usize].get_mut())
                }
                Code::Quadric(index) => {
                    quadric::<N>(&run.tape.quadrics[index as usize], [x, y, z], registers[at.out as usize].get_mut());
                }
                Code::Input(leaf) => {
                    *registers[at.out as usize].get_mut::<N>() = *pass(&run.inputs[leaf as usize].value, first);
                }
                Code::Unary(operation) => operation.visit(OnLanes::<N> { registers, at }),
                Code::Binary(operation) => operation.visit(OnLanes::<N> { registers, at }),
                Code::Choose => chosen::<N>(registers, at),
            }
        }
        for (out, &register) in outs.iter_mut().zip(&run.tape.outputs) {
            out[first..first + N].copy_from_slice(registers[register as usize].get::<N>());
        }
    }
}

/// Arguments may share a register: they are taken out first.
#[inline(always)]
fn chosen<const N: usize>(registers: &mut [Lanes], at: &Instruction) {
    let [condition, then, other] = [at.a, at.b, at.c].map(|place| *registers[place as usize].get::<N>());
    let out = registers[at.out as usize].get_mut::<N>();
    for i in 0..N {
        out[i] = choose::lane([condition[i], then[i], other[i]]);
    }
}

/// An affine form; loops for a single axis are bit for bit the general one with zeros left out.
#[inline(always)]
fn affine<const N: usize>(row: [f32; 4], [x, y, z]: [&[f32; N]; 3], out: &mut [f32; N]) {
    let [a, b, c, d] = row;
    let mut along = |axis: &[f32; N], slope: f32| {
        for (out, value) in out.iter_mut().zip(axis) {
            *out = slope * value + d;
        }
    };
    match row.map(|slope| slope != 0.0) {
        [true, false, false, _] => along(x, a),
        [false, true, false, _] => along(y, b),
        [false, false, true, _] => along(z, c),
        [false, false, false, _] => *out = [d; N],
        _ => {
            for i in 0..N {
                out[i] = a * x[i] + b * y[i] + c * z[i] + d;
            }
        }
    }
}

#[inline(always)]
fn quadric<const N: usize>(quadric: &LaneQuadric, [x, y, z]: [&[f32; N]; 3], out: &mut [f32; N]) {
    let ([p, q, r], constant) = (quadric.rows, quadric.constant);
    match quadric.shape {
        // Bit for bit the next one with factors of 1 left out.
        QuadricShape::Ball => {
            let square = |i: usize| {
                let (u, v, w) = (x[i] + p[3], y[i] + q[3], z[i] + r[3]);
                u * u + v * v + w * w
            };
            if quadric.signs[0] < 0.0 {
                for i in 0..N {
                    out[i] = constant - square(i);
                }
            } else {
                for i in 0..N {
                    out[i] = constant + square(i);
                }
            }
        }
        QuadricShape::Aligned => {
            let sign = quadric.signs[0];
            for i in 0..N {
                let (u, v, w) = (p[0] * x[i] + p[3], q[1] * y[i] + q[3], r[2] * z[i] + r[3]);
                out[i] = constant + sign * (u * u + v * v + w * w);
            }
        }
        QuadricShape::General => {
            let [s, t, m] = quadric.signs;
            for i in 0..N {
                let u = p[0] * x[i] + p[1] * y[i] + p[2] * z[i] + p[3];
                let v = q[0] * x[i] + q[1] * y[i] + q[2] * z[i] + q[3];
                let w = r[0] * x[i] + r[1] * y[i] + r[2] * z[i] + r[3];
                out[i] = constant + (s * (u * u) + t * (v * v) + m * (w * w));
            }
        }
    }
}
