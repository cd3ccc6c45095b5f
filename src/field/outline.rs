//! Regions of the plane bounded by straight edges and arcs of circles: the exact signed distance, whatever their form.
//!
//! The distance is that to the nearest piece; inside is where a ray towards +x crosses the outline an odd number of times.
//! Solids of revolution are outlines over the distance from the axis; an edge on the axis then bounds nothing.

use std::sync::OnceLock;

use glam::{DVec2, DVec3};

use super::part::{Parts, Sample};
use super::rows::Rows;
use super::{Aabb, Slope};

/// A piece of an outline, with the inside on its left.
#[derive(Clone, Copy, Debug)]
enum Piece {
    Edge {
        from: DVec2,
        to: DVec2,
    },
    Arc {
        from: DVec2,
        to: DVec2,
        centre: DVec2,
        radius: f64,
        /// The direction of its middle, and the cosine of half its angle.
        middle: DVec2,
        half: f64,
        counterclockwise: bool,
    },
}

/// A piece that runs up or down throughout: a ray towards +x crosses it once at most.
#[derive(Clone, Copy, Debug)]
struct Crossing {
    from: DVec2,
    to: DVec2,
    /// Of an arc: its centre, its radius and the side of the centre that it is on, ±1.
    arc: Option<(DVec2, f64, f64)>,
}

/// A region of the plane, or several.
#[derive(Clone, Debug, Default)]
pub struct Outline {
    pieces: Vec<Piece>,
    crossings: Vec<Crossing>,
    /// Where the loop that is being drawn began, and where its pen is.
    pen: Option<(DVec2, DVec2)>,
    loop_begins: usize,
    min: DVec2,
    max: DVec2,
    /// Twice the area of the loop that is drawn.
    area: f64,
    /// Where the crossings are, once asked for.
    rows: OnceLock<Rows>,
}

impl Outline {
    /// Nothing drawn yet.
    pub fn new() -> Self {
        Self { min: DVec2::INFINITY, max: DVec2::NEG_INFINITY, ..Self::default() }
    }

    /// A loop of straight edges.
    pub fn polygon(corners: &[DVec2]) -> Self {
        let mut outline = Self::new();
        outline.draw_polygon(corners);
        outline
    }

    /// One more loop of straight edges.
    pub fn draw_polygon(&mut self, corners: &[DVec2]) {
        for corner in corners {
            self.line(*corner);
        }
        self.close();
    }

    /// One more loop of straight edges that has the inside of the region on its left: clockwise around a hole.
    pub fn draw_loop(&mut self, corners: impl IntoIterator<Item = DVec2>) {
        for corner in corners {
            self.line(corner);
        }
        self.end();
    }

    /// One more loop: a circle.
    pub fn draw_circle(&mut self, centre: DVec2, radius: f64) {
        self.line(centre + DVec2::X * radius);
        self.arc(centre - DVec2::X * radius, centre, true);
        self.arc(centre + DVec2::X * radius, centre, true);
        self.close();
    }

    fn reached(&mut self, point: DVec2) {
        (self.min, self.max) = (self.min.min(point), self.max.max(point));
    }

    /// An edge to a point; where a loop has not begun, that begins there.
    pub fn line(&mut self, to: DVec2) -> &mut Self {
        self.reached(to);
        self.rows.take();
        let Some((start, from)) = self.pen else {
            self.pen = Some((to, to));
            self.loop_begins = self.pieces.len();
            self.area = 0.0;
            return self;
        };
        self.pen = Some((start, to));
        if from != to {
            self.pieces.push(Piece::Edge { from, to });
            self.crossings.push(Crossing { from, to, arc: None });
            self.area += from.perp_dot(to);
        }
        self
    }

    /// An arc to a point around a centre as far from both.
    pub fn arc(&mut self, to: DVec2, centre: DVec2, counterclockwise: bool) -> &mut Self {
        use std::f64::consts::{FRAC_PI_2, TAU};
        let Some((start, from)) = self.pen else { return self.line(to) };
        self.pen = Some((start, to));
        let radius = (from.distance(centre) + to.distance(centre)) / 2.0;
        let angle = |point: DVec2| libm::atan2(point.y - centre.y, point.x - centre.x);
        let (first, last) = (angle(from), angle(to));
        let way = if counterclockwise { last - first } else { first - last };
        let way = if way <= 1e-12 { way + TAU } else { way };
        if radius <= 0.0 || from == to {
            return self.line(to);
        }
        let signed = if counterclockwise { way } else { -way };
        let at = |angle: f64| centre + DVec2::new(libm::cos(angle), libm::sin(angle)) * radius;
        let middle = (at(first + signed / 2.0) - centre) / radius;
        let half = libm::cos(way / 2.0);
        self.pieces.push(Piece::Arc { from, to, centre, radius, middle, half, counterclockwise });
        // Cut where it turns from up to down: at ±90 degrees.
        let mut cuts = vec![(0.0, from)];
        for quarter in -8..=8 {
            let turn = FRAC_PI_2 + std::f64::consts::PI * f64::from(quarter);
            let along = (turn - first) * signed.signum();
            if along > 1e-9 && along < way - 1e-9 {
                let up = if quarter % 2 == 0 { 1.0 } else { -1.0 };
                cuts.push((along, centre + DVec2::Y * (radius * up)));
            }
        }
        cuts.push((way, to));
        cuts.sort_by(|a, b| a.0.total_cmp(&b.0));
        for pair in cuts.array_windows::<2>() {
            let &[(begin, from), (end, to)] = pair;
            let between = at(first + signed.signum() * (begin + end) / 2.0);
            self.reached(from);
            self.reached(to);
            self.reached(between);
            let side = if between.x >= centre.x { 1.0 } else { -1.0 };
            self.crossings.push(Crossing { from, to, arc: Some((centre, radius, side)) });
            self.area += from.perp_dot(between) + between.perp_dot(to);
        }
        for axis in [0.0, 1.0, 2.0, 3.0] {
            let along = (axis * FRAC_PI_2 - first) * signed.signum();
            if along.rem_euclid(TAU) < way {
                self.reached(at(axis * FRAC_PI_2));
            }
        }
        self
    }

    /// Ends the loop, with an edge where its ends do not meet. Its inside becomes that of its pieces.
    pub fn close(&mut self) -> &mut Self {
        self.end();
        if self.area < 0.0 {
            for piece in &mut self.pieces[self.loop_begins..] {
                *piece = piece.reversed();
            }
            self.area = -self.area;
        }
        self
    }

    fn end(&mut self) {
        let Some((start, from)) = self.pen.take() else { return };
        if from.distance(start) > 1e-12 * (self.max - self.min).length() {
            self.pen = Some((start, from));
            self.line(start);
            self.pen = None;
        } else if from != start {
            // Rounding left a gap, through which a ray must not slip.
            self.crossings.push(Crossing { from, to: start, arc: None });
        }
    }

    /// The region as one over the distance from an axis at x = 0: edges on it bound nothing.
    pub fn around_axis(mut self) -> Self {
        let size = (self.max - self.min).max_element();
        let on_axis = |point: DVec2| point.x.abs() < 1e-12 * size;
        self.pieces.retain(|piece| !matches!(piece, Piece::Edge { from, to } if on_axis(*from) && on_axis(*to)));
        self
    }

    /// The least and greatest corner of its box.
    pub fn corners(&self) -> [DVec2; 2] {
        [self.min, self.max]
    }

    /// Whether a point is inside.
    pub fn contains(&self, point: DVec2) -> bool {
        /// Fewer are faster looked at one by one.
        const MANY: usize = 32;
        let crossed = if self.crossings.len() < MANY {
            self.crossings.iter().filter(|crossing| crossing.is_right_of(point)).count()
        } else {
            let span = |crossing: &Crossing| (crossing.from.y.min(crossing.to.y), crossing.from.y.max(crossing.to.y));
            let rows = self.rows.get_or_init(|| Rows::new(&self.crossings.iter().map(span).collect::<Vec<_>>()));
            rows.at(point.y).iter().filter(|index| self.crossings[**index as usize].is_right_of(point)).count()
        };
        crossed % 2 == 1
    }
}

impl Crossing {
    fn is_right_of(&self, point: DVec2) -> bool {
        let (from, to) = (self.from, self.to);
        if (from.y > point.y) == (to.y > point.y) {
            return false;
        }
        match self.arc {
            None => point.x < from.x + (point.y - from.y) / (to.y - from.y) * (to.x - from.x),
            Some((centre, radius, side)) => {
                let up = point.y - centre.y;
                let aside = (radius * radius - up * up).max(0.0).sqrt();
                point.x < centre.x + side * aside
            }
        }
    }
}

impl Piece {
    /// The same with the inside on the other hand; its ends are exchanged.
    fn reversed(self) -> Self {
        match self {
            Self::Edge { from, to } => Self::Edge { from: to, to: from },
            Self::Arc { from, to, centre, radius, middle, half, counterclockwise } => {
                Self::Arc { from: to, to: from, centre, radius, middle, half, counterclockwise: !counterclockwise }
            }
        }
    }

    /// The nearest point of it.
    fn nearest(&self, point: DVec2) -> DVec2 {
        match *self {
            Self::Edge { from, to } => {
                let along = to - from;
                let share = ((point - from).dot(along) / along.length_squared()).clamp(0.0, 1.0);
                from + along * share
            }
            Self::Arc { from, to, centre, radius, middle, half, .. } => {
                let away = point - centre;
                let length = away.length();
                if length > 0.0 && away.dot(middle) >= half * length {
                    return centre + away * (radius / length);
                }
                if length == 0.0 {
                    return centre + middle * radius;
                }
                if point.distance_squared(from) <= point.distance_squared(to) { from } else { to }
            }
        }
    }

    /// The signed distance to the line or circle that it is a piece of.
    fn carrier(&self, point: DVec2) -> (f64, DVec2) {
        match *self {
            Self::Edge { from, to } => {
                let normal = (to - from).normalize_or_zero().perp();
                (normal.dot(point - from), normal)
            }
            Self::Arc { centre, radius, counterclockwise, middle, .. } => {
                let away = point - centre;
                let length = away.length();
                let out = if length > 0.0 { away / length } else { middle };
                if counterclockwise { (radius - length, -out) } else { (length - radius, out) }
            }
        }
    }
}

impl Parts for Outline {
    fn count(&self) -> usize {
        self.pieces.len()
    }

    fn part(&self, index: usize, position: DVec3) -> Sample {
        let point = position.truncate();
        let piece = &self.pieces[index];
        let away = point - piece.nearest(point);
        let distance = away.length();
        let gradient = if distance > 0.0 {
            -away / distance
        } else {
            // On the outline itself: outside is taken, where the value rises inward.
            piece.carrier(point).1
        };
        (-distance, gradient.extend(0.0))
    }

    fn inside(&self, position: DVec3) -> Option<bool> {
        Some(self.contains(position.truncate()))
    }

    fn carrier(&self, index: usize, position: DVec3) -> Sample {
        let (value, gradient) = self.pieces[index].carrier(position.truncate());
        (value, gradient.extend(0.0))
    }

    fn core(&self, index: usize) -> Option<(Aabb, f64)> {
        Some(match self.pieces[index] {
            Piece::Edge { from, to } => (Aabb::new(from.min(to).extend(0.0), from.max(to).extend(0.0)), 0.0),
            Piece::Arc { centre, radius, .. } => (Aabb::new(centre.extend(0.0), centre.extend(0.0)), radius),
        })
    }

    fn bounding_box(&self) -> Option<Aabb> {
        Some(Aabb::new(self.min.extend(0.0), self.max.extend(0.0)).without_z())
    }

    fn slope(&self) -> Slope {
        Slope::Exact { outside: true, inside: true }
    }

    fn is_flat(&self) -> bool {
        true
    }
}
