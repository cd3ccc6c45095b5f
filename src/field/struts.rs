//! Round struts: all near a line whose radius goes evenly from one end to the other, and unions of many.
//!
//! A strut is the union of the balls of centre a + t·(b − a) and radius (1 − t)·r + t·s. At a point F is the greatest of
//! what these balls give, which is concave in t: its one maximum, held to 0 … 1, is in closed form.

use glam::DVec3;

use super::parts::{Parts, Sample};
use super::{Aabb, Slope};

/// All near a line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Strut {
    from: DVec3,
    along: DVec3,
    length: f64,
    radii: [f64; 2],
    /// Of the angle between the side and the axis.
    tangent: f64,
}

impl Strut {
    /// The strut between two points, with the radius at each.
    pub fn new(from: DVec3, to: DVec3, radii: [f64; 2]) -> Self {
        let length = from.distance(to);
        let change = radii[0] - radii[1];
        if length <= change.abs() {
            // The larger ball holds the other one.
            let from = if change >= 0.0 { from } else { to };
            return Self { from, along: DVec3::X, length: 0.0, radii: [radii[0].max(radii[1]); 2], tangent: 0.0 };
        }
        let sine = change / length;
        let tangent = sine / (1.0 - sine * sine).sqrt();
        Self { from, along: (to - from) / length, length, radii, tangent }
    }

    fn to(&self) -> DVec3 {
        self.from + self.along * self.length
    }

    /// The signed distance, positive inside, and its gradient.
    fn at(&self, position: DVec3) -> Sample {
        let way = position - self.from;
        let along = way.dot(self.along);
        let across = (way - self.along * along).length();
        let place = (along - across * self.tangent).clamp(0.0, self.length);
        let share = if self.length > 0.0 { place / self.length } else { 0.0 };
        let radius = self.radii[0] + (self.radii[1] - self.radii[0]) * share;
        let from_axis = way - self.along * place;
        let distance = from_axis.length();
        let direction = if distance > 0.0 { from_axis / distance } else { self.along.any_orthonormal_vector() };
        (radius - distance, -direction)
    }

    fn bounding_box(&self) -> Aabb {
        let ball = |at: DVec3, radius: f64| Aabb::new(at, at).grown(radius);
        ball(self.from, self.radii[0]).union(ball(self.to(), self.radii[1]))
    }
}

/// The union of struts.
pub struct Struts {
    all: Vec<Strut>,
    period: Option<f64>,
    is_flat: bool,
}

impl Struts {
    /// Some of them, at least one.
    pub fn new(all: Vec<Strut>) -> Self {
        Self { all, period: None, is_flat: false }
    }

    /// A curve by straight pieces, places and radii given by the share of the way.
    pub fn along(at: impl Fn(f64) -> DVec3, radius: impl Fn(f64) -> f64, pieces: usize) -> Self {
        let share = |i: usize| i as f64 / pieces as f64;
        let piece = |i: usize| {
            let (from, to) = (share(i), share(i + 1));
            Strut::new(at(from), at(to), [radius(from), radius(to)])
        };
        Self::new((0..pieces).map(piece).collect())
    }

    /// The same struts, which lie in the xy plane, whatever z.
    pub fn flattened(self) -> Self {
        Self { is_flat: true, ..self }
    }

    /// The struts of a cube with one corner at the origin, in all cubes of that edge.
    pub fn periodic(cube: &[Strut], edge: f64) -> Self {
        let mut all: Vec<Strut> = Vec::with_capacity(27 * cube.len());
        for cell in 0..27 {
            let cell = glam::IVec3::new(cell / 9, cell / 3 % 3, cell % 3) - 1;
            for strut in cube {
                let moved = Strut { from: strut.from + cell.as_dvec3() * edge, ..*strut };
                // Those on a wall of the cube are also its neighbour's.
                let same = |other: &Strut| {
                    let (a, b) = (other.from - moved.from, other.to() - moved.to());
                    let (c, d) = (other.from - moved.to(), other.to() - moved.from);
                    a.length().max(b.length()).min(c.length().max(d.length())) < 1e-9 * edge
                };
                if !all.iter().any(same) {
                    all.push(moved);
                }
            }
        }
        Self { all, period: Some(edge), is_flat: false }
    }
}

impl Parts for Struts {
    fn count(&self) -> usize {
        self.all.len()
    }

    fn part(&self, index: usize, position: DVec3) -> Sample {
        self.all[index].at(position)
    }

    fn bounding_box(&self) -> Option<Aabb> {
        if self.period.is_some() {
            return None;
        }
        let bounds = self.all.iter().map(Strut::bounding_box).reduce(Aabb::union)?;
        Some(if self.is_flat { bounds.without_z() } else { bounds })
    }

    /// Outside of a union the nearest strut is as far; inside of one a wall that another one covers does not count.
    fn slope(&self) -> Slope {
        Slope::Exact { outside: true, inside: self.all.len() == 1 }
    }

    fn is_flat(&self) -> bool {
        self.is_flat
    }

    fn period(&self) -> Option<f64> {
        self.period
    }
}
