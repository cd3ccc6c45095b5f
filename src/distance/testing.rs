//! Small hand-written fields with known answers, for this room's tests.

use glam::DVec3;

use crate::field::{Aabb, BATCH, Evaluator, Field, Gradients, Hint, Hints, Interval, Points};

/// One smooth operand.
#[derive(Clone, Copy, Debug)]
pub enum Leaf {
    /// r² − |p − c|².
    Sphere(DVec3, f64),
    /// n·p ≤ offset; n of any length.
    HalfSpace(DVec3, f64),
    /// Around z through the origin, major and minor radius: m² − (√(x²+y²) − M)² − z².
    Torus(f64, f64),
    /// 1 − Σ (p/a)².
    Ellipsoid(DVec3),
}

impl Leaf {
    pub fn eval(self, p: DVec3) -> (f64, DVec3) {
        match self {
            Leaf::Sphere(c, r) => (r * r - (p - c).length_squared(), (p - c) * -2.0),
            Leaf::HalfSpace(n, offset) => (offset - n.dot(p), -n),
            Leaf::Torus(major, minor) => {
                let s = p.x.hypot(p.y);
                let w = s - major;
                let slope = -2.0 * w / s;
                (minor * minor - w * w - p.z * p.z, DVec3::new(slope * p.x, slope * p.y, -2.0 * p.z))
            }
            Leaf::Ellipsoid(a) => (1.0 - (p / a).length_squared(), p / (a * a) * -2.0),
        }
    }

    fn bounds(self, b: &Aabb) -> Interval {
        let square = |lo: f64, hi: f64| {
            let least = if lo <= 0.0 && hi >= 0.0 { 0.0 } else { lo.abs().min(hi.abs()) };
            (least * least, (lo * lo).max(hi * hi))
        };
        match self {
            Leaf::Sphere(c, r) => {
                let (x, y, z) = axes(b, |axis| square(b.min[axis] - c[axis], b.max[axis] - c[axis]));
                Interval::new(r * r - (x.1 + y.1 + z.1), r * r - (x.0 + y.0 + z.0))
            }
            Leaf::HalfSpace(n, offset) => {
                let reach = (n * b.size() * 0.5).abs().element_sum();
                let middle = offset - n.dot(b.centre());
                Interval::new(middle - reach, middle + reach)
            }
            Leaf::Torus(major, minor) => {
                let (x, y, z) = axes(b, |axis| square(b.min[axis], b.max[axis]));
                let w = square((x.0 + y.0).sqrt() - major, (x.1 + y.1).sqrt() - major);
                Interval::new(minor * minor - w.1 - z.1, minor * minor - w.0 - z.0)
            }
            Leaf::Ellipsoid(a) => {
                let (x, y, z) = axes(b, |axis| square(b.min[axis] / a[axis], b.max[axis] / a[axis]));
                Interval::new(1.0 - (x.1 + y.1 + z.1), 1.0 - (x.0 + y.0 + z.0))
            }
        }
    }

    fn bounding_box(self) -> Option<Aabb> {
        match self {
            Leaf::Sphere(c, r) => Some(Aabb::new(c - r, c + r)),
            Leaf::HalfSpace(..) => None,
            Leaf::Torus(major, minor) => {
                let reach = DVec3::new(major + minor, major + minor, minor);
                Some(Aabb::new(-reach, reach))
            }
            Leaf::Ellipsoid(a) => Some(Aabb::new(-a, a)),
        }
    }
}

fn axes<T>(_: &Aabb, f: impl Fn(usize) -> T) -> (T, T, T) {
    (f(0), f(1), f(2))
}

/// Leaves joined by R₀, times `scale` (to have slopes far from 1).
#[derive(Clone, Debug)]
pub struct Joined {
    pub leaves: Vec<Leaf>,
    pub union: bool,
    pub bounds: Aabb,
}

impl Joined {
    pub fn one(leaf: Leaf) -> Self {
        Self { leaves: vec![leaf], union: true, bounds: leaf.bounding_box().unwrap() }
    }

    pub fn union(leaves: Vec<Leaf>) -> Self {
        let bounds = leaves.iter().map(|leaf| leaf.bounding_box().unwrap()).reduce(Aabb::union).unwrap();
        Self { leaves, union: true, bounds }
    }

    /// A box of half edges `half` whose axes are the columns of `axes`, made of six half-spaces.
    pub fn oriented_box(axes: glam::DMat3, half: DVec3) -> Self {
        let leaves = (0..6)
            .map(|i| Leaf::HalfSpace(axes.col(i / 2) * if i % 2 == 0 { 1.0 } else { -1.0 }, half[i / 2]))
            .collect();
        Self { leaves, union: false, bounds: Aabb::new(DVec3::splat(-half.length()), DVec3::splat(half.length())) }
    }

    fn join(&self, a: (f64, DVec3), b: (f64, DVec3)) -> (f64, DVec3) {
        let sign = if self.union { 1.0 } else { -1.0 };
        let root = a.0.hypot(b.0);
        let (ka, kb) = if root > 0.0 { (a.0 / root, b.0 / root) } else { (0.0, 0.0) };
        // a + b ± √(a² + b²) without cancellation: the two have a product.
        let (sum, product) = (a.0 + b.0, 2.0 * a.0 * b.0);
        let value = if sum * sign >= 0.0 { sum + sign * root } else { product / (sum - sign * root) };
        (value, a.1 * (1.0 + sign * ka) + b.1 * (1.0 + sign * kb))
    }

    fn eval(&self, kept: &[usize], p: DVec3) -> (f64, DVec3) {
        kept.iter().map(|&leaf| self.leaves[leaf].eval(p)).reduce(|a, b| self.join(a, b)).unwrap()
    }
}

impl Field for Joined {
    fn bounding_box(&self) -> Option<Aabb> {
        Some(self.bounds)
    }

    fn reference(&self, position: DVec3) -> f64 {
        let all: Vec<usize> = (0..self.leaves.len()).collect();
        self.eval(&all, position).0
    }

    fn evaluator(&self) -> Box<dyn Evaluator + '_> {
        Box::new(JoinedEvaluator { field: self, kept: vec![(0..self.leaves.len()).collect()], bounds: Vec::new() })
    }
}

struct JoinedEvaluator<'a> {
    field: &'a Joined,
    kept: Vec<Vec<usize>>,
    bounds: Vec<Interval>,
}

fn joined_bounds(field: &Joined, bounds: &[Interval]) -> Interval {
    let low = bounds.iter().map(|bound| (bound.lo, DVec3::ZERO)).reduce(|a, b| field.join(a, b)).unwrap().0;
    let high = bounds.iter().map(|bound| (bound.hi, DVec3::ZERO)).reduce(|a, b| field.join(a, b)).unwrap().0;
    Interval::new(low, high)
}

impl Evaluator for JoinedEvaluator<'_> {
    fn enter(&mut self, region: &Aabb) {
        let field = self.field;
        let parent = self.kept.last().unwrap();
        let bounds: Vec<Interval> = parent.iter().map(|&leaf| field.leaves[leaf].bounds(region)).collect();
        let matters = |bound: &Interval| if field.union { bound.hi >= 0.0 } else { bound.lo <= 0.0 };
        let mut kept: Vec<usize> =
            parent.iter().zip(&bounds).filter(|(_, bound)| matters(bound)).map(|(&leaf, _)| leaf).collect();
        if kept.is_empty() {
            kept.push(parent[0]);
        }
        self.kept.push(kept);
        self.bounds.push(joined_bounds(field, &bounds));
    }

    fn bounds(&mut self) -> Interval {
        self.bounds.last().copied().unwrap_or(Interval::ALL)
    }

    fn hints(&mut self, _: Hint) -> Hints {
        Hints::NONE
    }

    fn leave(&mut self) {
        self.kept.pop();
        self.bounds.pop();
    }

    fn values(&mut self, points: &Points, out: &mut [f32; BATCH]) {
        for i in 0..points.len {
            out[i] = self.field.eval(self.kept.last().unwrap(), points.position(i)).0 as f32;
        }
    }

    fn gradients(&mut self, points: &Points, out: &mut Gradients) {
        for i in 0..points.len {
            out.set(i, self.field.eval(self.kept.last().unwrap(), points.position(i)));
        }
    }

    fn branches(&self) -> usize {
        self.kept.last().unwrap().len()
    }

    fn branch(&mut self, branch: usize, points: &Points, out: &mut Gradients) {
        let leaf = self.field.leaves[self.kept.last().unwrap()[branch]];
        for i in 0..points.len {
            out.set(i, leaf.eval(points.position(i)));
        }
    }
}

/// Another field seen through s ↦ tanh(s/width): the same surface, hardly a slope a few widths away.
pub struct Saturated {
    pub inner: Joined,
    pub width: f64,
}

impl Field for Saturated {
    fn bounding_box(&self) -> Option<Aabb> {
        self.inner.bounding_box()
    }

    fn reference(&self, position: DVec3) -> f64 {
        (self.inner.reference(position) / self.width).tanh()
    }

    fn evaluator(&self) -> Box<dyn Evaluator + '_> {
        Box::new(SaturatedEvaluator { inner: self.inner.evaluator(), width: self.width as f32 })
    }
}

struct SaturatedEvaluator<'a> {
    inner: Box<dyn Evaluator + 'a>,
    width: f32,
}

impl Evaluator for SaturatedEvaluator<'_> {
    fn enter(&mut self, region: &Aabb) {
        self.inner.enter(region);
    }

    fn bounds(&mut self) -> Interval {
        self.inner.bounds()
    }

    fn hints(&mut self, asked: Hint) -> Hints {
        Hints { steepest: None, ..self.inner.hints(asked) }
    }

    fn leave(&mut self) {
        self.inner.leave();
    }

    fn values(&mut self, points: &Points, out: &mut [f32; BATCH]) {
        self.inner.values(points, out);
        out[..points.len].iter_mut().for_each(|value| *value = (*value / self.width).tanh());
    }

    fn gradients(&mut self, points: &Points, out: &mut Gradients) {
        self.inner.gradients(points, out);
        for i in 0..points.len {
            let value = (out.value[i] / self.width).tanh();
            let factor = (1.0 - value * value) / self.width;
            out.value[i] = value;
            out.dx[i] *= factor;
            out.dy[i] *= factor;
            out.dz[i] *= factor;
        }
    }
}
