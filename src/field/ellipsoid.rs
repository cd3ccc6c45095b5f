//! Ellipsoid and ellipse: the signed distance, by the nearest point.
//!
//! Of a point y the nearest one is x_i = e_i²·y_i/(t + e_i²), for half axes e and the greatest root t of |v(t)| = 1 with
//! v_i = e_i·y_i/(t + e_i²) (Eberly, Distance from a Point to an Ellipse, an Ellipsoid, or a Hyperellipsoid, eq. 24 and
//! after). The distance is |t|·|m|, m_i = y_i/(t + e_i²), which points outward, and t is negative inside. The root is that
//! of 1/|v(t)| = 1 too, a concave function that is nearly a line: Newton's steps rise to it from the left and do not pass
//! it (Moré & Sorensen 1983, section 3, of the same equation), where Eberly halves an interval.
//!
//! Right to some units in the last place of the greatest half axis, for half axes of any ratio, at the centre, and on the
//! planes of symmetry, where several points are nearest: then the gradient is that towards one of them.

use glam::DVec3;

use super::{Aabb, BATCH, Evaluator, Field, Gradients, Hint, Hints, Interval, Points, Slope};

/// Points that are worked on side by side.
const LANES: usize = 8;

/// Most roots are found in six steps; those nearest to where two nearest points become one in about thirty.
const STEPS: usize = 64;

/// Added to the coordinate along the least half axis, in its units: it decides on a side where both are as near. As small
/// as its square allows.
const ASIDE: f64 = 1e-150;

/// An ellipsoid around the origin; of two half axes an ellipse in the xy plane, whatever z.
pub struct Ellipsoid<const N: usize> {
    half: [f64; N],
    /// The axis of the least half axis, whose length is the unit within.
    least: usize,
    /// The squares of the half axes over that of the least one, minus 1.
    beyond: [f64; N],
}

/// An ellipse in the xy plane, whatever z.
pub type Ellipse = Ellipsoid<2>;

impl<const N: usize> Ellipsoid<N> {
    /// By its half axes, greater than 0.
    pub fn new(half: [f64; N]) -> Self {
        let least = (1..N).fold(0, |least, axis| if half[axis] < half[least] { axis } else { least });
        let beyond = half.map(|half_axis| {
            let ratio = half_axis / half[least];
            (ratio - 1.0) * (ratio + 1.0)
        });
        Self { half, least, beyond }
    }

    /// The distances and the directions outward at some points, by their coordinates.
    #[inline(always)]
    fn outward(&self, points: &[[f64; LANES]; N]) -> ([f64; LANES], [[f64; LANES]; N]) {
        let unit = self.half[self.least];
        let (mut y, mut c) = ([[0.0; LANES]; N], [[0.0; LANES]; N]);
        let mut s = [0.0_f64; LANES];
        for axis in 0..N {
            let ratio = self.half[axis] / unit;
            let aside = if axis == self.least { ASIDE } else { 0.0 };
            for i in 0..LANES {
                y[axis][i] = points[axis][i].abs() / unit + aside;
                c[axis][i] = ratio * y[axis][i];
                // One term of |v|² alone is no more than all: s, which is t + 1, is at least this.
                let alone = c[axis][i] - self.beyond[axis];
                s[i] = if alone > s[i] { alone } else { s[i] };
            }
        }
        for _ in 0..STEPS {
            let mut moved = false;
            let (mut square, mut slope) = ([0.0; LANES], [0.0; LANES]);
            for axis in 0..N {
                for i in 0..LANES {
                    let over = 1.0 / (s[i] + self.beyond[axis]);
                    let v = c[axis][i] * over;
                    square[i] += v * v;
                    slope[i] += v * v * over;
                }
            }
            for i in 0..LANES {
                // Of 1/|v|: the value less 1 over the derivative, which is the slope over |v|³.
                let next = s[i] + (square[i].sqrt() - 1.0) * square[i] / slope[i];
                let rises = next > s[i] && next < f64::INFINITY;
                s[i] = if rises { next } else { s[i] };
                moved |= rises;
            }
            if !moved {
                break;
            }
        }
        let (mut square, mut away) = ([0.0; LANES], [[0.0; LANES]; N]);
        for axis in 0..N {
            for i in 0..LANES {
                away[axis][i] = y[axis][i] / (s[i] + self.beyond[axis]);
                square[i] += away[axis][i] * away[axis][i];
            }
        }
        let mut distance = [0.0; LANES];
        for i in 0..LANES {
            let length = square[i].sqrt();
            distance[i] = (s[i] - 1.0) * length * unit;
            for axis in 0..N {
                let part = away[axis][i] / length;
                away[axis][i] = if points[axis][i] < 0.0 { -part } else { part };
            }
        }
        (distance, away)
    }

    fn value(&self, position: DVec3) -> f64 {
        let at = position.to_array();
        let (distance, _) = self.outward(&std::array::from_fn(|axis| [at[axis]; LANES]));
        -distance[0]
    }
}

/// Some points at a time; `take` gets the first one's index, their F and, by axis, the parts of their gradients.
#[multiversion::multiversion(targets = "simd")]
fn each<const N: usize>(
    of: &Ellipsoid<N>,
    points: &Points,
    mut take: impl FnMut(usize, &[f64; LANES], &[[f64; LANES]; N]),
) {
    let (offsets, origin) = ([&points.x, &points.y, &points.z], points.origin.to_array());
    for first in (0..points.len).step_by(LANES) {
        let at: [[f64; LANES]; N] =
            std::array::from_fn(|axis| std::array::from_fn(|i| origin[axis] + f64::from(offsets[axis][first + i])));
        let (distance, away) = of.outward(&at);
        take(first, &distance.map(|distance| -distance), &away.map(|part| part.map(|part| -part)));
    }
}

impl<const N: usize> Field for Ellipsoid<N> {
    fn bounding_box(&self) -> Option<Aabb> {
        let half = DVec3::from([0, 1, 2].map(|axis| self.half.get(axis).copied().unwrap_or(0.0)));
        let around = Aabb::new(-half, half);
        Some(if N < 3 { around.without_z() } else { around })
    }

    fn slope(&self) -> Slope {
        Slope::Exact { outside: true, inside: true }
    }

    fn reference(&self, position: DVec3) -> f64 {
        self.value(position)
    }

    fn evaluator(&self) -> Box<dyn Evaluator + '_> {
        Box::new(EllipsoidEvaluator { ellipsoid: self, regions: Vec::new() })
    }
}

struct EllipsoidEvaluator<'f, const N: usize> {
    ellipsoid: &'f Ellipsoid<N>,
    regions: Vec<Aabb>,
}

impl<const N: usize> Evaluator for EllipsoidEvaluator<'_, N> {
    fn enter(&mut self, region: &Aabb) {
        self.regions.push(*region);
    }

    /// A distance is no steeper than 1.
    fn bounds(&mut self) -> Interval {
        let Some(region) = self.regions.last() else { return Interval::ALL };
        let value = self.ellipsoid.value(region.centre());
        let reach = region.size().to_array()[..N].iter().map(|size| size * size).sum::<f64>().sqrt() / 2.0;
        let by = reach + 1e-9 * (value.abs() + reach);
        if value.is_nan() || by.is_nan() { Interval::ALL } else { Interval::new(value - by, value + by) }
    }

    fn hints(&mut self, _: Hint) -> Hints {
        Hints { keeps_values: true, ..Hints::NONE }
    }

    fn leave(&mut self) {
        self.regions.pop();
    }

    fn values(&mut self, points: &Points, out: &mut [f32; BATCH]) {
        each(self.ellipsoid, points, |first, value, _| {
            for i in 0..LANES {
                out[first + i] = value[i] as f32;
            }
        });
    }

    fn gradients(&mut self, points: &Points, out: &mut Gradients) {
        each(self.ellipsoid, points, |first, value, parts| {
            for i in 0..LANES {
                out.value[first + i] = value[i] as f32;
            }
            for (out, part) in [&mut out.dx, &mut out.dy, &mut out.dz].into_iter().zip(parts) {
                for i in 0..LANES {
                    out[first + i] = part[i] as f32;
                }
            }
        });
        if N < 3 {
            out.dz[..points.len].fill(0.0);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::tests::Samples;

    const EXTENTS: [[f64; 3]; 8] = [
        [1.0, 0.7, 0.5],
        [0.4, 1.5, 0.4],
        [1.0, 1.0, 0.2],
        [0.8, 0.8, 0.8],
        [0.02, 1.6, 0.3],
        [0.3, 0.31, 0.299],
        [1e-9, 1.0, 1.0],
        [1.0, 1e3, 1e-3],
    ];

    /// The nearest of points all over it, and of ever closer ones around that: knows nothing of roots.
    fn searched(half: DVec3, p: DVec3) -> f64 {
        let at = |direction: DVec3| half * direction.normalize();
        let nearer = |a: DVec3, b: DVec3| if at(b).distance(p) < at(a).distance(p) { b } else { a };
        let side = |i: i32| f64::from(i - 12) / 12.0;
        let cube = (0..25 * 25 * 25).map(|i| DVec3::new(side(i % 25), side(i / 25 % 25), side(i / 625)));
        let mut best = cube.filter(|at| at.abs().max_element() == 1.0).reduce(nearer).expect("some").normalize();
        let mut reach = 0.1;
        while reach > 1e-9 {
            let (u, v) = best.any_orthonormal_pair();
            let around = (0..49).map(|i| best + reach / 3.0 * (f64::from(i % 7 - 3) * u + f64::from(i / 7 - 3) * v));
            let next = around.fold(best, nearer).normalize();
            reach *= if next == best { 0.5 } else { 0.9 };
            best = next;
        }
        at(best).distance(p)
    }

    #[test]
    fn distances_are_those_of_a_search_on_both_sides() {
        let mut samples = Samples::new(31);
        for extents in EXTENTS {
            let half = DVec3::from(extents);
            // What a lattice of angles finds: needles are compared with other things below.
            if half.max_element() > 100.0 * half.min_element() {
                continue;
            }
            let ellipsoid = Ellipsoid::new(extents);
            let mut inside = 0;
            for i in 0..60 {
                let reach = half * if i % 2 == 0 { 1.0 } else { 2.0 } + 0.1;
                let mut p = samples.within(&Aabb::new(-reach, reach));
                match i % 12 {
                    0 => p.x = 0.0,
                    1 => p.z = 0.0,
                    2 => (p.y, p.z) = (0.0, 0.0),
                    _ => {}
                }
                let value = ellipsoid.reference(p);
                inside += usize::from(value > 0.0);
                assert_eq!(value > 0.0, (p / half).length() < 1.0, "{extents:?} at {p}");
                let wanted = searched(half, p);
                assert!((value.abs() - wanted).abs() < 1e-9, "{extents:?} at {p}: {value}, {wanted}");
            }
            assert!(inside > 5, "{extents:?}: {inside}");
        }
    }

    /// Where the nearest point is known: of a ball, at the centre, on the axis of spheroids, beyond the tips.
    #[test]
    fn distances_have_their_closed_forms() {
        let ball = Ellipsoid::new([0.8; 3]);
        let mut samples = Samples::new(37);
        for _ in 0..100 {
            let p = samples.within(&Aabb::new(DVec3::splat(-2.0), DVec3::splat(2.0)));
            assert!((ball.reference(p) - (0.8 - p.length())).abs() < 1e-15);
        }
        for extents in EXTENTS {
            let (ellipsoid, half) = (Ellipsoid::new(extents), DVec3::from(extents));
            let rounding = 4.0 * f64::EPSILON * half.max_element();
            assert!((ellipsoid.reference(DVec3::ZERO) - half.min_element()).abs() <= rounding, "{extents:?}");
            for axis in 0..3 {
                for share in [1.0, 1.5, 1e3] {
                    let p = DVec3::AXES[axis] * half[axis] * share;
                    let wanted = -half[axis] * (share - 1.0);
                    let found = ellipsoid.reference(p);
                    assert!((found - wanted).abs() <= rounding * share, "{extents:?} at {p}: {found}, {wanted}");
                }
            }
        }
        for (across, along) in [(0.5, 2.0), (1e-6, 1.0), (1.0, 1e9)] {
            let spheroid = Ellipsoid::new([across, across, along]);
            let spread = along * along - across * across;
            for share in [0.0, 0.1, 0.5, 0.9, 0.999] {
                let z = share * along;
                let wanted = if z * along < spread { across * (1.0 - z * z / spread).sqrt() } else { along - z };
                let found = spheroid.reference(DVec3::Z * z);
                assert!((found - wanted).abs() < 1e-12 * along, "{across}, {along} at {z}: {found}, {wanted}");
            }
        }
    }

    /// The ellipse is the section of a long cylinder; every number is finite for half axes of any ratio.
    #[test]
    fn every_ratio_gives_numbers() {
        let mut samples = Samples::new(41);
        for half in [[1e-15, 1e15, 1.0], [1e15; 3], [1e-15; 3], [1e15, 1e-15, 1e-15], [1.0, 1.0, 1e-15]] {
            let solid = Ellipsoid::new(half);
            let flat = Ellipse::new([half[0], half[1]]);
            for size in [0.0, 1e-15, 1e-3, 1.0, 1e15] {
                let p = samples.within(&Aabb::new(DVec3::splat(-1.0), DVec3::splat(1.0))) * size;
                let mut points = Points::new(p);
                points.push(glam::Vec3::ZERO);
                for field in [&solid as &dyn Field, &flat] {
                    let mut found = Gradients::new();
                    field.evaluator().gradients(&points, &mut found);
                    let length = found.gradient(0).length();
                    assert!((length - 1.0).abs() < 1e-5, "{half:?} at {p}: {length}");
                    let value = field.reference(p);
                    assert!(found.value[0] == value as f32 && value.is_finite(), "{half:?} at {p}: {value}");
                    assert!(value.abs() <= 2.0 * (p.length() + 1e15));
                }
            }
        }
    }
}
