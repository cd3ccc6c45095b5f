//! A solid whose z axis lies along a curve: F is that of the solid, read where a position stands in the frame of the nearest
//! place of the curve. Where the curve comes near itself the greatest value of its turns counts, a union.

use glam::{DVec2, DVec3, Vec3};

use super::copies::{distance_between, distance_to, farthest};
use super::silhouette::Silhouette;
use super::spine::{Spine, Station};
use super::{Aabb, BATCH, Evaluator, Expression, Field, Gradients, Hint, Hints, Interval, Points};

/// More pieces than these are looked through for those near a batch before its points are.
const FEW_PIECES: usize = 16;

/// How much farther out than the solid, as a share of its reach, places are still read by the curve.
const BEYOND: f64 = 0.25;

/// A solid along a curve.
pub struct Bent {
    inner: Expression,
    own: Aabb,
    spine: Spine,
    /// Own z at the beginning of the curve, and how much of it a unit of the curve takes.
    start: f64,
    stretch: f64,
    /// How far from the curve the solid reaches, and how far places are read by it.
    reach: f64,
    wide: f64,
    pieces: Vec<Piece>,
    /// The numbers of all pieces.
    all: Vec<u32>,
    solid: Aabb,
}

/// A part of the curve, or a straight end.
struct Piece {
    /// Whether it is a straight end.
    is_end: bool,
    ways: [f64; 2],
    from: DVec3,
    to: DVec3,
    /// A box around it, as far as it strays from its chord.
    aabb: Aabb,
    sag: f64,
    middle: Station,
    /// The greatest angle of its frame, and of its neighbours', against that of the middle.
    angle: f64,
}

/// Where a solid is bent too much.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Folded {
    /// The place of the curve.
    pub at: DVec3,
    /// The radius of its circle there.
    pub radius: f64,
    /// How far the solid reaches to the middle of that.
    pub reach: f64,
}

/// A place of the solid's own space that a position stands for.
struct Image {
    own: DVec3,
    station: Station,
    off: DVec3,
}

impl Bent {
    /// A solid in a box, whose z from `start` on lies along the curve, `stretch` of it a unit.
    ///
    /// # Errors
    /// Where the curve turns so sharply that the solid would fold.
    pub fn new(inner: Expression, own: Aabb, spine: Spine, start: f64, stretch: f64) -> Result<Self, Folded> {
        let outline = Silhouette::new(&inner, &own);
        let reach = outline.reach() * (1.0 + 1e-6);
        let [first, last] = [own.min.z, own.max.z].map(|z| (z - start) / stretch);
        let length = spine.length();
        if let Some((at, radius)) = spine.cusp().filter(|(_, radius)| *radius < reach) {
            return Err(Folded { at, radius, reach });
        }
        let steps = 4 * spine.pieces();
        for i in 0..=steps {
            let way = length * i as f64 / steps as f64;
            if way < first || way > last {
                continue;
            }
            let Station { at, curvature, axes, slope } = spine.at(way);
            let turning = curvature / slope.length_squared();
            let middle = DVec2::new(turning.dot(axes[0]), turning.dot(axes[1]));
            let at_height = outline.at(start + stretch * way);
            let share = at_height.iter().map(|corner| middle.dot(*corner)).fold(0.0, f64::max);
            if share >= 0.999 {
                let radius = 1.0 / turning.length();
                return Err(Folded { at, radius, reach: share * radius });
            }
        }
        let wide = reach * (1.0 + BEYOND);
        let [before, after] = [(-first).max(0.0), (last - length).max(0.0)].map(|beyond| beyond + wide);
        let mut bent = Self {
            inner: inner.keeping_values(),
            own,
            spine,
            start,
            stretch,
            reach,
            wide,
            pieces: Vec::new(),
            all: Vec::new(),
            solid: own,
        };
        let has_ends = !bent.spine.is_closed();
        let [first_end, last_end] = [[-before, 0.0], [length, length + after]].map(|end| has_ends.then_some(end));
        let between = (0..bent.spine.pieces()).map(|piece| bent.spine.piece(piece));
        let ways: Vec<[f64; 2]> = first_end.into_iter().chain(between).chain(last_end).collect();
        bent.pieces = (0..ways.len()).map(|at| bent.piece(&ways, at)).collect();
        bent.all = (0..bent.pieces.len() as u32).collect();
        bent.solid = bent.solid_box(first, last, &outline);
        Ok(bent)
    }

    fn piece(&self, ways: &[[f64; 2]], at: usize) -> Piece {
        let [from, to] = ways[at];
        let is_end = !self.spine.is_closed() && (at == 0 || at + 1 == ways.len());
        let step = to - from;
        let middle = self.spine.at((from + to) / 2.0);
        // Feet are found up to a piece farther on.
        let margin = if is_end { ways[1.min(ways.len() - 1)] } else { ways[at] };
        let margin = margin[1] - margin[0];
        let samples = (0..=8).map(|i| self.spine.at(from - margin + (step + 2.0 * margin) * f64::from(i) / 8.0));
        let apart = |station: Station| {
            let angle = |axis: usize| station.axes[axis].dot(middle.axes[axis]).clamp(-1.0, 1.0).acos();
            angle(0).max(angle(1)).max(angle(2))
        };
        // Between samples it is a little more.
        let angle = 1.2 * samples.map(apart).fold(0.0, f64::max);
        let [start, end] = [from, to].map(|way| self.spine.at(way).at);
        let sag = if is_end { 0.0 } else { 1.5 * middle.at.distance((start + end) / 2.0) + 1e-9 * step };
        let aabb = Aabb::new(start.min(end), start.max(end)).grown(sag);
        Piece { is_end, ways: [from, to], from: start, to: end, aabb, sag, middle, angle }
    }

    /// The box around all that the solid has.
    fn solid_box(&self, first: f64, last: f64, outline: &Silhouette) -> Aabb {
        let mut around: Option<Aabb> = None;
        for piece in &self.pieces {
            let [from, to] = [piece.ways[0].max(first), piece.ways[1].min(last)];
            if from > to {
                continue;
            }
            // Corners between two samples stray by as much as an arc does from its chord.
            let stray = piece.sag + self.reach * piece.angle * piece.angle;
            let [low, high] = [from, to].map(|way| self.start + self.stretch * way);
            for i in 0..=2 {
                let way = from + (to - from) * f64::from(i) / 2.0;
                let Station { at, axes, .. } = self.spine.at(way);
                for corner in outline.between(low, high) {
                    let place = at + corner.x * axes[0] + corner.y * axes[1];
                    let here = Aabb::new(place, place).grown(stray);
                    around = Some(around.map_or(here, |known| known.union(here)));
                }
            }
        }
        around.unwrap_or(self.own)
    }

    /// Where a place of the solid goes.
    pub fn forth(&self, own: DVec3) -> DVec3 {
        let Station { at, axes, .. } = self.spine.at((own.z - self.start) / self.stretch);
        at + own.x * axes[0] + own.y * axes[1]
    }

    /// Where a position comes from: of several turns, the one whose value counts.
    pub fn back(&self, position: DVec3) -> DVec3 {
        let mut best: Option<(f64, DVec3)> = None;
        self.images(position, &self.all, |_, image| {
            let value = self.near_value(&image);
            if best.is_none_or(|(greatest, _)| value > greatest) {
                best = Some((value, image.own));
            }
        });
        match best {
            Some((_, own)) => own,
            // Far from all of it by the nearest chord.
            None => {
                let chords = self.pieces.iter().enumerate().map(|(index, piece)| (index, chord(piece, position)));
                let nearest = chords.reduce(|best, other| if other.1.0 < best.1.0 { other } else { best });
                let (index, (_, share)) = nearest.unwrap_or_default();
                let [from, to] = self.pieces[index].ways;
                self.image(position, self.spine.foot(position, from + share * (to - from))).own
            }
        }
    }

    /// A vector of the solid's own space at the place that a position comes from, as it is at the position.
    pub fn carried(&self, position: DVec3, vector: DVec3) -> DVec3 {
        let own = self.back(position);
        let Station { at, slope, curvature, axes } = self.spine.at((own.z - self.start) / self.stretch);
        let forward = slope * (1.0 - (position - at).dot(curvature) / slope.length_squared()) / self.stretch;
        vector.x * axes[0] + vector.y * axes[1] + vector.z * forward
    }

    /// A box of the solid's own space that holds all that a box comes from.
    pub fn region_back(&self, region: &Aabb) -> Aabb {
        let pieces = self.near(region, &self.all);
        let to_centre = |index: &u32| chord(&self.pieces[*index as usize], region.centre()).0;
        let nearest = pieces.iter().map(to_centre).fold(f64::INFINITY, f64::min);
        match self.own_region(region, &pieces) {
            Some(own) if nearest + region.size().length() / 2.0 <= self.wide => own,
            // Some of it is far from the curve: no farther than all of it is from all of that.
            _ => {
                let curve = self.pieces.iter().map(|piece| piece.aabb).fold(*region, Aabb::union);
                let far = curve.size().length();
                let way = |way: f64| self.start + self.stretch * way;
                let [first, last] = [self.pieces[0].ways[0] - far, self.pieces[self.pieces.len() - 1].ways[1] + far];
                Aabb::new(DVec3::new(-far, -far, way(first)), DVec3::new(far, far, way(last)))
            }
        }
    }

    fn image(&self, position: DVec3, way: f64) -> Image {
        let station = self.spine.at(way);
        let off = position - station.at;
        let [x, y, z] = station.axes.map(|axis| off.dot(axis));
        // What is left along the curve, beyond an end.
        let way = way + z / station.slope.length();
        Image { own: DVec3::new(x, y, self.start + self.stretch * way), station, off }
    }

    /// Calls with the images of a position by the pieces of some that are near, one for each turn of the curve, with its
    /// number.
    fn images(&self, position: DVec3, pieces: &[u32], mut each: impl FnMut(usize, Image)) {
        let mut turn = 0;
        let mut call = |(index, _, share): (u32, f64, f64)| {
            each(turn, self.image(position, self.foot(index as usize, position, share)));
            turn += 1;
        };
        // The nearest piece of the turn that is looked through, and the last piece of it that is near.
        let (mut best, mut last): (Option<(u32, f64, f64)>, u32) = (None, 0);
        // The turn over the seam of a closed curve, as far as it was met at the beginning.
        let (mut begins, mut seam) = (false, None);
        for &index in pieces {
            let piece = &self.pieces[index as usize];
            let (distance, share) = chord(piece, position);
            // Nor does a position that is no number have an image.
            if distance.is_nan() || distance > self.wide + piece.sag {
                continue;
            }
            let found = (index, distance, share);
            best = match best {
                Some(known) if last + 1 == index => Some(if distance < known.1 { found } else { known }),
                Some(known) => {
                    if std::mem::take(&mut begins) {
                        seam = Some(known)
                    } else {
                        call(known)
                    }
                    Some(found)
                }
                None => {
                    begins = index == 0 && self.spine.is_closed();
                    Some(found)
                }
            };
            last = index;
        }
        if let (Some(first), Some(known)) = (seam, best) {
            if last as usize + 1 == self.pieces.len() {
                best = Some(if first.1 < known.1 { first } else { known });
            } else {
                call(first);
            }
        }
        best.into_iter().for_each(call);
    }

    /// The way of the foot of a position, near a share of a piece's chord.
    fn foot(&self, index: usize, position: DVec3, share: f64) -> f64 {
        let Piece { is_end, ways: [from, to], .. } = self.pieces[index];
        let near = from + share * (to - from);
        if is_end {
            return near;
        }
        self.spine.foot(position, near).clamp(near - (to - from), near + (to - from))
    }

    /// What the solid is held below at an image: outside of its reach, minus the way to that.
    fn held(&self, image: &Image, value: f64) -> f64 {
        value.min(self.reach - image.own.x.hypot(image.own.y))
    }

    fn near_value(&self, image: &Image) -> f64 {
        self.held(image, self.inner.reference(image.own))
    }

    /// The most that F is at a position: outside of the solid's box, minus the distance to that.
    fn limit(&self, position: DVec3) -> f64 {
        let outside = distance_to(&self.solid, position);
        if outside > 0.0 { -outside } else { f64::INFINITY }
    }

    /// F where no piece is near.
    fn far_value(&self, position: DVec3) -> f64 {
        self.limit(position).min(self.reach - self.wide)
    }

    /// Those of some pieces that are near a box.
    fn near(&self, region: &Aabb, pieces: &[u32]) -> Vec<u32> {
        let is_near =
            |index: &u32| distance_between(&self.pieces[*index as usize].aabb, region) <= self.wide * (1.0 + 1e-9);
        pieces.iter().copied().filter(is_near).collect()
    }

    /// A box that holds the images of all positions of a box by some pieces; `None` where there are none.
    fn own_region(&self, region: &Aabb, pieces: &[u32]) -> Option<Aabb> {
        let (centre, half) = (region.centre(), region.size() / 2.0);
        let of_piece = |&index: &u32| {
            let piece = &self.pieces[index as usize];
            let Piece { is_end, ways: [from, to], .. } = *piece;
            let step = to - from;
            let (low, high) = if is_end { (from, to) } else { (from - step, to + step) };
            let off = centre - piece.middle.at;
            let stray = if is_end { 0.0 } else { (self.wide + piece.sag + 3.0 * step) * piece.angle };
            let across = |axis: usize| {
                let direction = piece.middle.axes[axis];
                let (middle, spread) = (off.dot(direction), half.dot(direction.abs()) + stray);
                // None is farther than what is read.
                let most = self.wide + piece.sag + 1e-9;
                let [low, high] = [middle - spread, middle + spread].map(|end| end.clamp(-most, most));
                (low, high)
            };
            let ([x0, x1], [y0, y1]) = (<[f64; 2]>::from(across(0)), <[f64; 2]>::from(across(1)));
            // What is left along the curve at the foot: all of it beyond an end.
            let rest = if is_end { self.wide + half.length() } else { 0.01 * step };
            let way = |way: f64| self.start + self.stretch * way;
            Aabb::new(DVec3::new(x0, y0, way(low - rest)), DVec3::new(x1, y1, way(high + rest)))
        };
        let all = pieces.iter().map(of_piece).reduce(Aabb::union)?;
        Some(all.grown(1e-6 * (self.own.longest_side() + all.longest_side())))
    }
}

/// The distance of a position from a piece's chord, and the share of that where it is nearest.
fn chord(piece: &Piece, position: DVec3) -> (f64, f64) {
    let along = piece.to - piece.from;
    let share = ((position - piece.from).dot(along) / along.length_squared()).clamp(0.0, 1.0);
    (position.distance(piece.from + share * along), share)
}

impl Field for Bent {
    fn bounding_box(&self) -> Option<Aabb> {
        Some(self.solid)
    }

    fn jumps(&self) -> bool {
        self.inner.jumps()
    }

    fn reference(&self, position: DVec3) -> f64 {
        let mut greatest: Option<f64> = None;
        self.images(position, &self.all, |_, image| {
            let value = self.near_value(&image);
            greatest = Some(greatest.map_or(value, |known| known.max(value)));
        });
        greatest.map_or_else(|| self.far_value(position), |value| value.min(self.limit(position)))
    }

    fn evaluator(&self) -> Box<dyn Evaluator + '_> {
        Box::new(BentEvaluator {
            bent: self,
            inner: self.inner.evaluator(),
            regions: Vec::new(),
            images: Vec::new(),
            there: Box::new(Points::new(DVec3::ZERO)),
            some: Box::default(),
            found: Box::default(),
        })
    }
}

/// A region entered, and the pieces near it.
struct Region {
    aabb: Aabb,
    pieces: Vec<u32>,
}

struct BentEvaluator<'a> {
    bent: &'a Bent,
    inner: Box<dyn Evaluator + 'a>,
    regions: Vec<Region>,
    images: Vec<Vec<(usize, Image)>>,
    there: Box<Points>,
    some: Box<Gradients>,
    found: Box<Gradients>,
}

impl BentEvaluator<'_> {
    fn pieces(&self) -> &[u32] {
        self.regions.last().map_or(&self.bent.all, |region| &region.pieces)
    }

    /// The images of all points, with their points' numbers, turn by turn.
    fn images(&mut self, points: &Points) {
        self.images.iter_mut().for_each(Vec::clear);
        let Some(region) = points.bounding_box() else { return };
        let near = (self.pieces().len() > FEW_PIECES).then(|| self.bent.near(&region, self.pieces()));
        let mut images = std::mem::take(&mut self.images);
        let pieces = near.as_deref().unwrap_or(self.pieces());
        for i in 0..points.len {
            self.bent.images(points.position(i), pieces, |turn, image| {
                if images.len() == turn {
                    images.push(Vec::new());
                }
                images[turn].push((i, image));
            });
        }
        self.images = images;
    }

    /// Values at one image of each of some points: of the whole solid, or of one of its branches.
    fn read(&mut self, images: &[(usize, Image)], branch: Option<usize>, gradients: bool) {
        let Self { inner, there, some, .. } = self;
        (there.origin, there.len) = (images.first().map_or(DVec3::ZERO, |(_, image)| image.own), 0);
        for (_, image) in images {
            there.push((image.own - there.origin).as_vec3());
        }
        match branch {
            Some(branch) => inner.branch(branch, there, some),
            None if gradients => inner.gradients(there, some),
            None => inner.values(there, &mut some.value),
        }
    }

    fn evaluate(&mut self, points: &Points, branch: Option<usize>, gradients: bool, out: &mut Gradients) {
        self.images(points);
        let all = std::mem::take(&mut self.images);
        out.value[..points.len].fill(f32::INFINITY);
        for (i, _) in all.first().into_iter().flatten() {
            out.value[*i] = f32::NEG_INFINITY;
        }
        for images in all.iter().filter(|images| !images.is_empty()) {
            self.read(images, branch, gradients);
            for (at, (i, image)) in images.iter().enumerate() {
                let (own, value) = (image.own, self.some.value[at]);
                let far = own.x.hypot(own.y);
                let limit = (self.bent.reach - far) as f32;
                let is_held = branch.is_none() && limit < value;
                let value = if is_held { limit } else { value };
                if value <= out.value[*i] {
                    continue;
                }
                out.value[*i] = value;
                if !gradients {
                    continue;
                }
                let [first, second, _] = image.station.axes;
                let slope = if is_held {
                    -(own.x * first + own.y * second) / far
                } else {
                    let Station { slope, curvature, .. } = image.station;
                    let steep = slope.length_squared() - image.off.dot(curvature);
                    let [x, y, z] = [self.some.dx[at], self.some.dy[at], self.some.dz[at]].map(f64::from);
                    let along = z * self.bent.stretch + self.bent.spine.twist() * (x * own.y - y * own.x);
                    x * first + y * second + along / steep.max(1e-3) * slope
                };
                set_slope(out, *i, slope);
            }
        }
        self.images = all;
        for i in 0..points.len {
            let position = points.position(i);
            let limit = self.bent.limit(position);
            let is_far = out.value[i] == f32::INFINITY;
            let limit = if is_far { self.bent.far_value(position) } else { limit } as f32;
            // A branch goes on beyond the box.
            if !is_far && (branch.is_some() || limit >= 0.0 || out.value[i] <= limit) {
                continue;
            }
            out.value[i] = limit;
            if gradients {
                let Aabb { min, max } = self.bent.solid;
                let outside = (position - max).max(DVec3::ZERO) - (min - position).max(DVec3::ZERO);
                let is_level = is_far && outside.length() < self.bent.wide - self.bent.reach;
                set_slope(out, i, if is_level { DVec3::ZERO } else { -outside.normalize_or_zero() });
            }
        }
    }

    /// Whether all pieces near are one turn of the curve.
    fn is_one_turn(&self) -> bool {
        let pieces = self.pieces();
        let gaps = pieces.array_windows().filter(|[a, b]| a + 1 != *b).count();
        let last = self.bent.pieces.len() as u32 - 1;
        let over_seam = self.bent.spine.is_closed() && pieces.first() == Some(&0) && pieces.last() == Some(&last);
        gaps <= usize::from(over_seam)
    }
}

fn set_slope(out: &mut Gradients, i: usize, slope: DVec3) {
    let Vec3 { x, y, z } = slope.as_vec3();
    (out.dx[i], out.dy[i], out.dz[i]) = (x, y, z);
}

impl Evaluator for BentEvaluator<'_> {
    fn enter(&mut self, region: &Aabb) {
        let pieces = self.bent.near(region, self.pieces());
        let own = self.bent.own_region(region, &pieces).unwrap_or(self.bent.own);
        self.inner.enter(&own);
        self.regions.push(Region { aabb: *region, pieces });
    }

    fn bounds(&mut self) -> Interval {
        let Some(Region { aabb, pieces }) = self.regions.last() else { return Interval::ALL };
        let bent = self.bent;
        let beyond = bent.wide - bent.reach;
        let most = -distance_between(&bent.solid, aabb);
        let least = -farthest(&bent.solid, aabb).max(beyond);
        // Pieces are found by their chords.
        let sag = pieces.iter().map(|piece| bent.pieces[*piece as usize].sag).fold(0.0, f64::max);
        let slack = 1e-9 * (bent.solid.longest_side() + least.abs()) + sag;
        if pieces.is_empty() {
            return Interval::new(least - slack, most.min(-beyond) + slack);
        }
        let Interval { lo, hi } = self.inner.bounds();
        let hi = hi.max(-beyond);
        let hi = if most < 0.0 { hi.min(most + slack) } else { hi };
        Interval::new(lo.min(least) - slack, hi)
    }

    fn leave(&mut self) {
        debug_assert!(!self.regions.is_empty(), "every leave matches an enter");
        self.regions.pop();
        self.inner.leave();
    }

    fn values(&mut self, points: &Points, out: &mut [f32; BATCH]) {
        let mut found = std::mem::take(&mut self.found);
        self.evaluate(points, None, false, &mut found);
        out[..points.len].copy_from_slice(&found.value[..points.len]);
        self.found = found;
    }

    fn gradients(&mut self, points: &Points, out: &mut Gradients) {
        self.evaluate(points, None, true, out);
    }

    fn hints(&mut self, _: Hint) -> Hints {
        Hints { keeps_values: true, ..Hints::NONE }
    }

    fn branches(&self) -> usize {
        if self.regions.is_empty() || self.pieces().is_empty() || !self.is_one_turn() {
            1
        } else {
            self.inner.branches()
        }
    }

    fn branch(&mut self, branch: usize, points: &Points, out: &mut Gradients) {
        let is_whole = self.branches() == 1;
        self.evaluate(points, (!is_whole).then_some(branch), true, out);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::tests::Samples;
    use crate::field::{Graph, Node};

    /// A curve that turns to every side and comes near itself.
    fn spine() -> Spine {
        let at = |i: usize| {
            let angle = i as f64 * 0.02;
            DVec3::new(2.0 * libm::cos(angle), 1.5 * libm::sin(angle), 0.5 * libm::sin(2.0 * angle) + 0.1 * angle)
        };
        Spine::new(&(0..400).map(at).collect::<Vec<_>>(), DVec3::Z)
    }

    fn solid(graph: &mut Graph, is_round: bool) -> (Node, Aabb) {
        let node = if is_round { graph.sphere(0.3) } else { graph.cuboid(DVec3::new(0.5, 0.2, 2.0)) };
        (node, graph.known_box(node).expect("it ends"))
    }

    fn bent(is_round: bool) -> (Bent, Expression) {
        let mut graph = Graph::new();
        let (node, own) = solid(&mut graph, is_round);
        let inner = Expression::new(&graph, node);
        let spine = spine();
        let stretch = own.size().z / spine.length();
        let bent = Bent::new(inner.clone(), own, spine, own.min.z, stretch);
        (bent.unwrap_or_else(|folded| panic!("{folded:?}")), inner)
    }

    #[test]
    fn places_go_forth_and_come_back() {
        let (bent, inner) = bent(false);
        let mut samples = Samples::new(4);
        for _ in 0..500 {
            let own = samples.within(&bent.own);
            let there = bent.forth(own);
            let back = bent.back(there);
            assert!((back - own).length() < 1e-6, "{own} comes back as {back}");
            assert!(bent.solid.contains(there), "{there} is outside of the box");
            assert!((bent.reference(there) - inner.reference(own)).abs() < 1e-6);
            let step = DVec3::new(1e-5, -2e-5, 1e-5);
            let moved = (bent.forth(own + step) - bent.forth(own - step)) / 2.0;
            assert!((bent.carried(there, step) - moved).length() < 1e-7, "{moved}");
        }
    }

    #[test]
    fn a_ring_of_a_disc_is_a_torus() {
        let mut graph = Graph::new();
        let (x, y) = (graph.x(), graph.y());
        let far = graph.length(&[x, y]);
        let node = graph.linear(far, -1.0, 0.3);
        let own = Aabb::new(DVec3::new(-0.3, -0.3, 0.0), DVec3::new(0.3, 0.3, 1.0));
        let at = |i: usize| DVec3::new(libm::cos(i as f64 * 0.01), libm::sin(i as f64 * 0.01), 0.0);
        let spine = Spine::new(&(0..600).map(at).collect::<Vec<_>>(), DVec3::Z);
        let stretch = 1.0 / spine.length();
        let bent = Bent::new(Expression::new(&graph, node), own, spine, 0.0, stretch).expect("it is thin");
        let mut samples = Samples::new(9);
        for _ in 0..300 {
            let angle = 1.0 + 4.0 * samples.next();
            let (off, up) = (0.6 * samples.next() - 0.3, 0.6 * samples.next() - 0.3);
            let p = DVec3::new((1.0 + off) * libm::cos(angle), (1.0 + off) * libm::sin(angle), up);
            let exact = 0.3 - off.hypot(up);
            assert!((bent.reference(p) - exact).abs() < 1e-6, "{} {exact} at {p}", bent.reference(p));
        }
    }

    /// A bar along a closed curve that comes near itself, turned once on its way.
    fn ring() -> Bent {
        let mut graph = Graph::new();
        let node = graph.cuboid(DVec3::new(0.5, 0.2, 1e6));
        let at = |i: usize| {
            let angle = std::f64::consts::TAU * i as f64 / 400.0;
            let across = 1.6 + 0.5 * libm::cos(3.0 * angle);
            DVec3::new(across * libm::cos(2.0 * angle), across * libm::sin(2.0 * angle), 0.5 * libm::sin(3.0 * angle))
        };
        let spine = Spine::closed(&(0..400).map(at).collect::<Vec<_>>(), DVec3::Z, std::f64::consts::TAU);
        let own = Aabb::new(DVec3::new(-0.25, -0.1, 0.0), DVec3::new(0.25, 0.1, 1.0));
        let stretch = 1.0 / spine.length();
        let bent = Bent::new(Expression::new(&graph, node), own, spine, 0.0, stretch);
        bent.unwrap_or_else(|folded| panic!("{folded:?}"))
    }

    #[test]
    fn batches_gradients_and_bounds_agree() {
        for bent in [bent(false).0, bent(true).0, ring()] {
            let world = bent.solid.grown(0.6);
            let (mut evaluator, mut samples) = (bent.evaluator(), Samples::new(2));
            let mut told = 0;
            for _ in 0..150 {
                let size = 3.0 * 0.5_f64.powf(6.0 * samples.next());
                let min = samples.within(&Aabb::new(world.min, world.max - size));
                let region = Aabb::new(min, min + size);
                evaluator.enter(&region);
                let bounds = evaluator.bounds();
                told += usize::from(!bounds.contains(0.0));
                let points = samples.batch(&region, 40);
                let (mut values, mut gradients) = ([0.0; BATCH], Gradients::new());
                evaluator.values(&points, &mut values);
                evaluator.gradients(&points, &mut gradients);
                for i in 0..points.len {
                    let p = points.position(i);
                    let exact = bent.reference(p);
                    assert!(bounds.contains(exact), "{exact} is not in {bounds:?} of {region:?}");
                    assert!((f64::from(values[i]) - exact).abs() < 1e-5, "{} {exact} at {p}", values[i]);
                    assert_eq!(values[i], gradients.value[i]);
                    let slope = |step: f64| {
                        DVec3::from_array(DVec3::AXES.map(|axis| {
                            (bent.reference(p + axis * step) - bent.reference(p - axis * step)) / (2.0 * step)
                        }))
                    };
                    let (fine, coarse) = (slope(1e-5), slope(9e-5));
                    if (fine - coarse).length() < 1e-4 {
                        let found = gradients.gradient(i).as_dvec3();
                        assert!((found - fine).length() < 2e-3, "{found}, {fine} at {p}");
                    }
                }
                evaluator.leave();
            }
            assert!(told > 20, "bounds tell nothing: {told}");
        }
    }

    #[test]
    fn what_is_too_thick_folds() {
        let mut graph = Graph::new();
        let node = graph.cuboid(DVec3::new(2.0, 0.1, 1.0));
        let own = graph.known_box(node).expect("it ends");
        let at = |i: usize| DVec3::new(0.8 * libm::cos(i as f64 * 0.02), 0.8 * libm::sin(i as f64 * 0.02), 0.0);
        let spine = Spine::new(&(0..200).map(at).collect::<Vec<_>>(), DVec3::Z);
        let stretch = 1.0 / spine.length();
        let folded = Bent::new(Expression::new(&graph, node), own, spine, -0.5, stretch).err().expect("it folds");
        assert!((folded.radius - 0.8).abs() < 1e-2 && (folded.reach - 1.0).abs() < 2e-2, "{folded:?}");
    }
}
