//! Walls that are so thin beside a cell that ways may lead through them.
//!
//! F's zero set is sought in each cell that may hold some, and what is behind it is looked at.
//!
//! **Guaranteed:** what is told is a wall: between two places inside F is negative. **Not guaranteed:** that each is
//! found; Newton's method goes to what is nearest.

use glam::{DVec3, Vec3};
use rayon::prelude::*;

use super::nodes::Body;
use crate::field::{Aabb, Evaluator, Gradients, Points};

/// How far around a cell's middle its walls are sought, in cells.
const AROUND: f32 = 0.75;
/// Where the search begins, in cells from the middle along each axis.
const START: f32 = 0.25;
/// Steps of Newton's method.
const STEPS: usize = 6;
/// How near to the zero set a place is on it, in cells.
const ON_SURFACE: f32 = 1e-3;
/// The thinnest wall that is told from none, in cells, and how much thicker the next is that is tried.
const THINNEST: f32 = 1e-4;
const GROWTH: f32 = 1.25;
/// The least wall that [`Sight`](super::sight::Sight) sees whatever its place on the lattice, in cells.
const SEEN: f32 = 0.04;
/// A wall is thin so many cells beside a place too, along its two tangents there and back, at least that often: it may end
/// on one side. What is thin in a corner is so along it only.
const BESIDE: f32 = 0.25;
const ALIKE: usize = 3;
/// Walls up to that are tried.
const TRIED: usize = 27;

/// A wall that ways go through.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Leak {
    /// A place on it, units.
    pub at: DVec3,
    /// How thick it is there, units.
    pub wall: f64,
}

impl Leak {
    /// The edge of cells, units, that see such a wall.
    pub fn closing_edge(&self) -> f64 {
        self.wall / f64::from(SEEN)
    }
}

impl Body {
    /// The thinnest wall found that is too thin to be seen.
    pub fn leak(&self) -> Option<Leak> {
        let nodes = (0..self.len() as u32).into_par_iter();
        let found = nodes.map_init(|| Seeker::new(self), |seeker, node| seeker.thinnest(self.place(node)));
        // Of several as thin the first node's.
        found.collect::<Vec<_>>().into_iter().flatten().reduce(|a, b| if b.wall < a.wall { b } else { a })
    }
}

/// Seeks walls on one thread.
struct Seeker<'b> {
    body: &'b Body,
    solid: Box<dyn Evaluator + 'b>,
    points: Points,
    gradients: Box<Gradients>,
}

impl<'b> Seeker<'b> {
    fn new(body: &'b Body) -> Self {
        Self { body, solid: body.solid().evaluator(), points: Points::new(DVec3::ZERO), gradients: Box::default() }
    }

    fn thinnest(&mut self, middle: Vec3) -> Option<Leak> {
        let (edge, at) = (self.body.edge(), self.body.to_units(middle));
        let half = DVec3::splat(f64::from(AROUND) * edge);
        self.solid.enter(&Aabb::new(at - half, at + half));
        let bounds = self.solid.bounds();
        let found = (bounds.lo <= 0.0 && bounds.hi >= 0.0).then(|| self.around(at, edge as f32)).flatten();
        self.solid.leave();
        found
    }

    /// The thinnest wall around a place.
    fn around(&mut self, at: DVec3, edge: f32) -> Option<Leak> {
        let starts: [Vec3; 8] = std::array::from_fn(|corner| {
            let signs = Vec3::new((corner & 4) as f32 / 2.0, (corner & 2) as f32, (corner & 1) as f32 * 2.0) - 1.0;
            signs * START * edge
        });
        let thin = self.thin(at, starts, edge);
        let walls = thin.into_iter().flatten().filter_map(|(place, out)| {
            let (one, two) = out.any_orthonormal_pair();
            let beside = [one, -one, two, -two].map(|way| place + way * BESIDE * edge);
            let goes_on = self.thin(at, beside, edge).iter().flatten().count() >= ALIKE;
            if goes_on { self.wall(at, place, out, edge) } else { None }
        });
        walls.reduce(|a, b| if b.wall < a.wall { b } else { a })
    }

    /// Where F's zero set is near some places and what is behind it is thin, and the way there.
    fn thin<const N: usize>(&mut self, at: DVec3, mut places: [Vec3; N], edge: f32) -> [Option<(Vec3, Vec3)>; N] {
        let half = Vec3::splat(AROUND * edge);
        let mut landed = [false; N];
        for _ in 0..STEPS {
            self.evaluate(at, &places);
            for (i, place) in places.iter_mut().enumerate() {
                let (value, slope) = (self.gradients.value[i], self.gradients.gradient(i));
                let step = -value * slope / slope.length_squared();
                landed[i] = step.length() < ON_SURFACE * edge;
                if step.is_finite() {
                    *place = (*place + step).clamp(-half, half);
                }
            }
        }
        self.evaluate(at, &places);
        let out: [Vec3; N] = std::array::from_fn(|i| -self.gradients.gradient(i).normalize_or_zero());
        self.evaluate(at, &std::array::from_fn::<Vec3, N, _>(|i| places[i] + out[i] * SEEN * edge));
        std::array::from_fn(|i| (landed[i] && self.gradients.value[i] > 0.0).then_some((places[i], out[i])))
    }

    fn evaluate(&mut self, at: DVec3, places: &[Vec3]) {
        self.points.origin = at;
        self.points.len = 0;
        places.iter().for_each(|place| self.points.push(*place));
        self.solid.gradients(&self.points, &mut self.gradients);
    }

    /// The wall at a place on F's zero set, where F is negative on a short way on, and positive behind.
    fn wall(&mut self, at: DVec3, place: Vec3, out: Vec3, edge: f32) -> Option<Leak> {
        let far = |i: usize| THINNEST * GROWTH.powi(i as i32) * edge;
        self.evaluate(at, &std::array::from_fn::<Vec3, TRIED, _>(|i| place + out * far(i)));
        let values = &self.gradients.value[..TRIED];
        let entered = values.iter().position(|value| *value < 0.0)?;
        let left = entered + values[entered..].iter().position(|value| *value > 0.0)?;
        Some(Leak { at: at + place.as_dvec3(), wall: f64::from(far(left)) })
    }
}
