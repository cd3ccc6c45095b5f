//! Closed curves of the plane as fonts and drawings give them, which may overlap and cross one another, and the outline of
//! what they fill.
//!
//! Curves become straight pieces that are nowhere farther off than a tolerance. Where curves overlap, what lies inside of
//! what they fill is no boundary: a union takes it out, so that the outline's distance is that to the visible edge.

use glam::DVec2;
use i_overlay::core::fill_rule::FillRule;
use i_overlay::float::simplify::SimplifyShape;

use super::Outline;

/// What of some curves is filled.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fill {
    /// What they wind around, however often.
    NonZero,
    /// What they wind around an odd number of times.
    EvenOdd,
}

/// Closed curves.
#[derive(Clone, Debug)]
pub struct Drawing {
    loops: Vec<Vec<[f64; 2]>>,
    tolerance: f64,
}

impl Drawing {
    /// Nothing drawn yet; curves are to be off by at most the tolerance.
    pub fn new(tolerance: f64) -> Self {
        Self { loops: Vec::new(), tolerance }
    }

    /// Begins a curve. One that is still open is closed by a straight edge.
    pub fn begin(&mut self, at: DVec2) {
        self.loops.push(vec![at.to_array()]);
    }

    /// Where the pen is.
    fn pen(&mut self) -> Option<(DVec2, &mut Vec<[f64; 2]>)> {
        let current = self.loops.last_mut()?;
        let last = *current.last()?;
        Some((last.into(), current))
    }

    /// A straight edge.
    pub fn line(&mut self, to: DVec2) {
        if let Some((_, current)) = self.pen() {
            current.push(to.to_array());
        }
    }

    /// A quadratic Bézier curve.
    pub fn quadratic(&mut self, control: DVec2, to: DVec2) {
        let tolerance = self.tolerance;
        let Some((from, current)) = self.pen() else { return };
        // n even pieces are off by |a − 2b + c|/(4n²) at most.
        let count = pieces((from - 2.0 * control + to).length() / 4.0, tolerance);
        for i in 1..=count {
            let (t, s) = shares(i, count);
            current.push((from * (s * s) + control * (2.0 * s * t) + to * (t * t)).to_array());
        }
    }

    /// A cubic Bézier curve.
    pub fn cubic(&mut self, first: DVec2, second: DVec2, to: DVec2) {
        let tolerance = self.tolerance;
        let Some((from, current)) = self.pen() else { return };
        // Its second derivative is at most six times the greater of these; n even pieces are off by an eighth of it over n².
        let bent = (from - 2.0 * first + second).length().max((first - 2.0 * second + to).length());
        let count = pieces(0.75 * bent, tolerance);
        for i in 1..=count {
            let (t, s) = shares(i, count);
            let [a, b, c, d] = [s * s * s, 3.0 * s * s * t, 3.0 * s * t * t, t * t * t];
            current.push((from * a + first * b + second * c + to * d).to_array());
        }
    }

    /// Closed loops as [`Self::filled`] gives them.
    pub fn add(&mut self, loops: Vec<Vec<[f64; 2]>>) {
        self.loops.extend(loops);
    }

    /// How many corners there are.
    pub fn corners(&self) -> usize {
        self.loops.iter().map(Vec::len).sum()
    }

    /// The closed loops around what the curves fill, the inside on the left of each; they touch but never cross.
    pub fn filled(self, fill: Fill) -> Vec<Vec<[f64; 2]>> {
        let rule = match fill {
            Fill::NonZero => FillRule::NonZero,
            Fill::EvenOdd => FillRule::EvenOdd,
        };
        let loops: Vec<Vec<[f64; 2]>> = self.loops.into_iter().filter(|corners| corners.len() > 2).collect();
        // Whole numbers of 64 bits, in which all intersections are exact to 1e-9 of the size.
        loops.simplify_shape_as::<i64>(rule).into_iter().flatten().collect()
    }
}

/// The region within loops that do not cross; `None` where there is none.
pub fn outline(loops: &[Vec<[f64; 2]>]) -> Option<Outline> {
    let mut outline = Outline::new();
    for corners in loops {
        outline.draw_loop(corners.iter().map(|corner| DVec2::from(*corner)));
    }
    (!loops.is_empty()).then_some(outline)
}

/// Even pieces of a curve of which one alone is off by so much.
fn pieces(off: f64, tolerance: f64) -> usize {
    /// Of a curve whose numbers are out of all proportion.
    const MOST: f64 = 1000.0;
    (off / tolerance).sqrt().ceil().clamp(1.0, MOST) as usize
}

fn shares(i: usize, count: usize) -> (f64, f64) {
    let t = i as f64 / count as f64;
    (t, 1.0 - t)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::{Field, Joined};
    use glam::DVec3;

    fn square(drawing: &mut Drawing, middle: f64, half: f64, clockwise: bool) {
        let mut corners = [[-half, -half], [half, -half], [half, half], [-half, half]];
        if clockwise {
            corners.reverse();
        }
        for (i, corner) in corners.into_iter().enumerate() {
            let at = DVec2::from(corner) + DVec2::X * middle;
            if i == 0 { drawing.begin(at) } else { drawing.line(at) }
        }
    }

    fn value(drawing: Drawing, fill: Fill, x: f64) -> f64 {
        let loops = drawing.filled(fill);
        Joined::new(outline(&loops).unwrap()).reference(DVec3::new(x, 0.0, 0.0))
    }

    /// Two squares that overlap: what is left of their edges inside is no boundary.
    #[test]
    fn edges_inside_do_not_count() {
        let mut both = Drawing::new(1e-4);
        square(&mut both, -0.5, 1.0, false);
        square(&mut both, 0.5, 1.0, false);
        assert!((value(both.clone(), Fill::NonZero, 0.5) - 1.0).abs() < 1e-9);
        assert!(value(both, Fill::EvenOdd, 0.0) < -0.49);
        // A loop the other way round is a hole, and so is any under the rule of odd numbers.
        for (clockwise, fill, inside) in
            [(true, Fill::NonZero, false), (false, Fill::NonZero, true), (false, Fill::EvenOdd, false)]
        {
            let mut hole = Drawing::new(1e-4);
            square(&mut hole, 0.0, 1.0, false);
            square(&mut hole, 0.0, 0.5, clockwise);
            assert_eq!(value(hole, fill, 0.0) > 0.0, inside, "{clockwise} {fill:?}");
        }
    }

    #[test]
    fn curves_keep_to_the_tolerance() {
        for tolerance in [1e-2, 1e-4, 1e-6] {
            let mut drawing = Drawing::new(tolerance);
            drawing.begin(DVec2::ZERO);
            drawing.quadratic(DVec2::new(1.0, 2.0), DVec2::new(2.0, 0.0));
            drawing.cubic(DVec2::new(3.0, -2.0), DVec2::new(-1.0, -2.0), DVec2::ZERO);
            let corners: Vec<DVec2> = drawing.loops[0].iter().map(|corner| DVec2::from(*corner)).collect();
            let away = |p: DVec2| {
                let edge = |[a, b]: &[DVec2; 2]| {
                    let along = *b - *a;
                    let share = ((p - *a).dot(along) / along.length_squared()).clamp(0.0, 1.0);
                    p.distance(*a + along * share)
                };
                corners.array_windows().map(edge).fold(f64::INFINITY, f64::min)
            };
            for i in 0..=1000 {
                let (t, s) = shares(i, 1000);
                let quadratic = DVec2::new(1.0, 2.0) * (2.0 * s * t) + DVec2::new(2.0, 0.0) * (t * t);
                let cubic = DVec2::new(2.0, 0.0) * (s * s * s)
                    + DVec2::new(3.0, -2.0) * (3.0 * s * s * t)
                    + DVec2::new(-1.0, -2.0) * (3.0 * s * t * t);
                assert!(away(quadratic).max(away(cubic)) <= tolerance * 1.001, "{tolerance} at {t}");
            }
        }
    }
}
