//! Round struts: all near a line whose radius goes evenly from one end to the other, and unions of many.
//!
//! A strut is the union of the balls of centre a + t·(b − a) and radius (1 − t)·r + t·s. At a point F is the greatest of
//! what these balls give, which is concave in t: its one maximum, held to 0 … 1, is in closed form.

use glam::DVec3;
use multiversion::multiversion;

use super::part::{LANES, Parts, Sample};
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
    pub(super) fn at(&self, position: DVec3) -> Sample {
        let way = position - self.from;
        let mut along = way.dot(self.along);
        if self.tangent != 0.0 {
            along -= (way - self.along * along).length() * self.tangent;
        }
        let place = along.clamp(0.0, self.length);
        let share = if self.length > 0.0 { place / self.length } else { 0.0 };
        let radius = self.radii[0] + (self.radii[1] - self.radii[0]) * share;
        let from_axis = way - self.along * place;
        let distance = from_axis.length();
        let direction = if distance > 0.0 { from_axis / distance } else { self.along.any_orthonormal_vector() };
        (radius - distance, -direction)
    }

    /// The box of the axis, and how far it reaches beyond: the ball of any place is no larger than the larger one.
    pub(super) fn core(&self) -> (Aabb, f64) {
        let (from, to) = (self.from, self.to());
        (Aabb::new(from.min(to), from.max(to)), self.radii[0].max(self.radii[1]))
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
    /// Whether the value is the distance inside, too.
    inside: bool,
}

impl Struts {
    /// Some of them, at least one.
    pub fn new(all: Vec<Strut>) -> Self {
        let inside = all.len() == 1 || is_tube(&all);
        Self { all, period: None, is_flat: false, inside }
    }

    /// Some of many that go on beyond them, or none.
    pub(super) fn loose(all: Vec<Strut>) -> Self {
        Self { all, period: None, is_flat: false, inside: false }
    }

    /// All of them.
    pub(super) fn all(&self) -> &[Strut] {
        &self.all
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
        Self { all, period: Some(edge), is_flat: false, inside: false }
    }
}

impl Parts for Struts {
    fn count(&self) -> usize {
        self.all.len()
    }

    fn part(&self, index: usize, position: DVec3) -> Sample {
        self.all[index].at(position)
    }

    fn best(&self, among: &[u32], at: &[DVec3; LANES]) -> [(f64, u32); LANES] {
        let (mut values, mut chosen) = ([f64::NEG_INFINITY; LANES], [u32::MAX; LANES]);
        let at = [at.map(|at| at.x), at.map(|at| at.y), at.map(|at| at.z)];
        best_of(&self.all, among, &at, &mut values, &mut chosen);
        std::array::from_fn(|lane| (values[lane], chosen[lane]))
    }

    /// Eight positions take as long as one and a half.
    fn most_listed(&self) -> usize {
        24
    }

    fn core(&self, index: usize) -> Option<(Aabb, f64)> {
        Some(self.all[index].core())
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
        Slope::Exact { outside: true, inside: self.inside }
    }

    fn is_flat(&self) -> bool {
        self.is_flat
    }

    fn period(&self) -> Option<f64> {
        self.period
    }
}

/// [`Strut::at`] without the gradients, operation by operation.
#[multiversion(targets = "simd")]
fn best_of(
    all: &[Strut],
    among: &[u32],
    [x, y, z]: &[[f64; LANES]; 3],
    values: &mut [f64; LANES],
    chosen: &mut [u32; LANES],
) {
    for index in among {
        let Strut { from, along: axis, length, radii, tangent } = all[*index as usize];
        let mut found = [0.0; LANES];
        if tangent == 0.0 {
            for i in 0..LANES {
                let way = [x[i] - from.x, y[i] - from.y, z[i] - from.z];
                let along = way[0] * axis.x + way[1] * axis.y + way[2] * axis.z;
                let place = along.max(0.0).min(length);
                let off = [way[0] - axis.x * place, way[1] - axis.y * place, way[2] - axis.z * place];
                found[i] = radii[0] - (off[0] * off[0] + off[1] * off[1] + off[2] * off[2]).sqrt();
            }
        } else {
            found = std::array::from_fn(|i| all[*index as usize].at(DVec3::new(x[i], y[i], z[i])).0);
        }
        for i in 0..LANES {
            let is_better = found[i] > values[i];
            values[i] = if is_better { found[i] } else { values[i] };
            chosen[i] = if is_better { *index } else { chosen[i] };
        }
    }
}

/// Whether struts are the pieces of one smooth curve, all of one radius, whose tube does not meet itself: then the nearest
/// wall is straight out from the curve. So it is where the radius is less than the curve's reach: nowhere is the curve
/// more strongly bent, and points farther apart along it than half a turn of that radius are two radii apart.
fn is_tube(all: &[Strut]) -> bool {
    /// Pairs of all pieces are looked at.
    const MOST: usize = 4000;
    /// How far the corners between straight pieces put the wall off, of the curve's size.
    const TOLERANCE: f64 = 1e-5;
    let (radius, count) = (all[0].radii[0], all.len());
    if count > MOST || all.iter().any(|strut| strut.radii != [radius; 2] || strut.length == 0.0) {
        return false;
    }
    let bounds = all.iter().map(Strut::bounding_box).reduce(Aabb::union);
    let size = bounds.map_or(0.0, |bounds| bounds.size().max_element());
    let meets = |a: &Strut, b: &Strut| a.to().distance(b.from) <= 1e-9 * size;
    let bend = |a: &Strut, b: &Strut| {
        // Its sine, which is the angle where that is small.
        let turn = a.along.cross(b.along).length();
        let is_smooth = a.along.dot(b.along) > 0.0 && radius * turn * turn / 8.0 <= TOLERANCE * size;
        is_smooth && turn * radius <= (a.length + b.length) / 2.0
    };
    if !all.array_windows().all(|[a, b]| meets(a, b) && bend(a, b)) {
        return false;
    }
    let is_closed = meets(&all[count - 1], &all[0]);
    if is_closed && !bend(&all[count - 1], &all[0]) {
        return false;
    }
    let mut along = 0.0;
    let places: Vec<(f64, DVec3)> = all
        .iter()
        .map(|strut| {
            along += strut.length;
            (along - strut.length, strut.from)
        })
        .collect();
    let whole = along;
    let longest = all.iter().fold(0.0_f64, |longest, strut| longest.max(strut.length));
    // Between two corners the curve may be nearer by as much as the pieces are long.
    let least = 2.0 * radius + longest;
    (0..places.len()).all(|i| {
        let (from, a) = places[i];
        (i + 1..places.len()).all(|j| {
            let (to, b) = places[j];
            let way = if is_closed { (to - from).min(whole - to + from) } else { to - from };
            way <= std::f64::consts::PI * radius + longest || a.distance(b) >= least
        })
    })
}
