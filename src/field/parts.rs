//! Solids of many simple parts, found by a procedure: outlines, struts, curves. What an expression would have to compute in
//! full at every point, an evaluator here narrows to the few parts that can be nearest in a region.
//!
//! Every part's value has slope 1 at most. A part is therefore out of question throughout a ball of radius r where its
//! value at the centre is more than 2r below that of the best part there. What is left gives the same bits as all parts.

use std::cell::OnceCell;
use std::sync::Arc;

use glam::DVec3;

use super::candidates::Candidates;
use super::part::{LANES, Parts, Sample, WITHIN};
use super::part_tree::PartTree;
use super::{Aabb, BATCH, Evaluator, Field, Gradients, Hint, Hints, Interval, Points, Slope};

/// More parts than this are found by a tree of boxes, where they have any.
const MANY: usize = 64;

/// So many parts of a region are listed where there is a tree; of more, the tree is asked at each point.
const MOST_OF_TREE: usize = 16;

/// The field of some parts.
pub struct Joined<P> {
    parts: P,
    /// Of many parts, where they have boxes.
    tree: Option<PartTree>,
    /// Of others.
    candidates: Option<Candidates>,
}

impl<P: Parts + 'static> Joined<P> {
    /// As an operand of an expression.
    pub fn shared(parts: P) -> Arc<dyn Field> {
        Arc::new(Self::new(parts))
    }
}

impl<P: Parts> Joined<P> {
    /// The field of parts.
    pub fn new(parts: P) -> Self {
        let has_many = parts.count() > MANY && parts.period().is_none();
        let tree = has_many.then(|| PartTree::new(&parts)).flatten();
        let candidates = if tree.is_some() { None } else { Candidates::new(&parts) };
        Self { parts, tree, candidates }
    }

    /// Which part is the best at a position, the first where several are.
    pub fn best_part(&self, position: DVec3) -> usize {
        let own = self.own(position);
        if let Some(tree) = &self.tree {
            // Of what is no number the first stands for all.
            return (tree.best(&self.parts, own).0 as usize).min(self.parts.count() - 1);
        }
        let mut best = (f64::NEG_INFINITY, 0);
        for index in 0..self.parts.count() {
            let value = self.parts.part(index, own).0;
            best = if value > best.0 { (value, index) } else { best };
        }
        best.1
    }

    /// Those that may be the best in a region, as the parts see it.
    fn candidates<'s>(&'s self, region: &Aabb, all: &'s [u32]) -> &'s [u32] {
        self.candidates.as_ref().map_or(all, |candidates| candidates.of(region))
    }

    /// The best of some parts, the first where several are; as it is in the solid.
    fn best(&self, candidates: &[u32], position: DVec3) -> Sample {
        let mut best = (f64::NEG_INFINITY, DVec3::ZERO);
        for index in candidates {
            let sample = self.parts.part(*index as usize, position);
            if sample.0 > best.0 {
                best = sample;
            }
        }
        best
    }

    /// A position as the parts see it.
    fn own(&self, position: DVec3) -> DVec3 {
        match self.parts.period() {
            Some(period) => position - (position / period).floor() * period,
            None if self.parts.is_flat() => position.with_z(0.0),
            None => position,
        }
    }

    fn signed(&self, (value, gradient): Sample, inside: Option<bool>) -> Sample {
        if inside == Some(true) { (-value, -gradient) } else { (value, gradient) }
    }
}

impl<P: Parts> Field for Joined<P> {
    fn bounding_box(&self) -> Option<Aabb> {
        self.parts.bounding_box()
    }

    fn slope(&self) -> Slope {
        self.parts.slope()
    }

    fn reference(&self, position: DVec3) -> f64 {
        /// So many that one by one they would take milliseconds.
        const VERY_MANY: usize = 50_000;
        let position = self.own(position);
        if let Some(tree) = self.tree.as_ref().filter(|_| self.parts.count() > VERY_MANY) {
            return self.signed(tree.best(&self.parts, position).1, self.parts.inside(position)).0;
        }
        // All of them, one by one: the judge of what is left out.
        let mut best = (f64::NEG_INFINITY, DVec3::ZERO);
        for index in 0..self.parts.count() {
            let sample = self.parts.part(index, position);
            best = if sample.0 > best.0 { sample } else { best };
        }
        self.signed(best, self.parts.inside(position)).0
    }

    fn evaluator(&self) -> Box<dyn Evaluator + '_> {
        let all = (0..self.parts.count() as u32).collect();
        Box::new(JoinedEvaluator { joined: self, all, regions: Vec::new(), spare: Vec::new() })
    }
}

/// What is known of a region.
struct Region {
    centre: DVec3,
    reach: f64,
    /// What is taken from positions; `None` where they are folded one by one.
    shift: Option<DVec3>,
    few: Vec<u32>,
    /// Whether these are all that can be the best; of more the tree knows them.
    is_whole: bool,
    /// F at the centre.
    value: f64,
    inside: Option<bool>,
    carriers: OnceCell<Vec<u32>>,
}

struct JoinedEvaluator<'f, P> {
    joined: &'f Joined<P>,
    all: Vec<u32>,
    regions: Vec<Region>,
    spare: Vec<Vec<u32>>,
}

impl<P: Parts> JoinedEvaluator<'_, P> {
    fn sample(&self, position: DVec3) -> Sample {
        let joined = self.joined;
        let (own, few, inside) = match self.regions.last() {
            Some(Region { shift: Some(shift), few, is_whole, inside, .. }) => {
                let own = self.flat(position - *shift);
                if let Some(tree) = joined.tree.as_ref().filter(|_| !is_whole) {
                    let (_, best) = tree.best(&joined.parts, own);
                    return joined.signed(best, inside.or_else(|| joined.parts.inside(own)));
                }
                // Of many the cubes know the few of the point.
                let cubes = joined.candidates.as_ref().filter(|_| few.len() > joined.parts.most_listed());
                (own, cubes.map_or(&few[..], |cubes| cubes.at(own)), *inside)
            }
            // In a region where no single cube repeats each point has parts of its own.
            _ => {
                let own = joined.own(position);
                if let Some(tree) = &joined.tree {
                    return joined.signed(tree.best(&joined.parts, own).1, joined.parts.inside(own));
                }
                let few = joined.candidates.as_ref().map_or(&self.all[..], |candidates| candidates.at(own));
                (own, few, None)
            }
        };
        joined.signed(joined.best(few, own), inside.or_else(|| joined.parts.inside(own)))
    }

    /// The region whose parts are listed, and what is taken from positions in it.
    fn listed(&self) -> Option<(&Region, DVec3)> {
        let region = self.regions.last().filter(|region| region.is_whole)?;
        let has_cubes = self.joined.candidates.is_some();
        let is_short = !has_cubes || region.few.len() <= self.joined.parts.most_listed();
        region.shift.filter(|_| is_short).map(|shift| (region, shift))
    }

    /// Tells each point of a batch, as the parts see it, its greatest value and which part has it.
    fn at_once(&self, points: &Points, region: &Region, shift: DVec3, mut each: impl FnMut(usize, DVec3, (f64, u32))) {
        for first in (0..points.len).step_by(LANES) {
            let last = points.len - 1;
            let own = std::array::from_fn(|lane| self.flat(points.position((first + lane).min(last)) - shift));
            let best = self.joined.parts.best(&region.few, &own);
            for lane in 0..LANES.min(points.len - first) {
                each(first + lane, own[lane], best[lane]);
            }
        }
    }

    fn side(&self, region: &Region, own: DVec3, sample: Sample) -> Sample {
        self.joined.signed(sample, region.inside.or_else(|| self.joined.parts.inside(own)))
    }

    fn flat(&self, position: DVec3) -> DVec3 {
        if self.joined.parts.is_flat() { position.with_z(0.0) } else { position }
    }

    /// The carriers that may be zero in the region; none where they are too many.
    fn carriers(&self) -> &[u32] {
        /// More are not told apart: each is evaluated by itself.
        const MOST: usize = 12;
        let Some(region) = self.regions.last() else { return &[] };
        region.carriers.get_or_init(|| {
            let Some(shift) = region.shift.filter(|_| region.is_whole) else { return Vec::new() };
            let centre = self.flat(region.centre - shift);
            let near = |index: &&u32| {
                let (value, _) = self.joined.parts.part(**index as usize, centre);
                value.abs() <= region.reach
            };
            let found: Vec<u32> = region.few.iter().filter(near).copied().collect();
            if found.len() > MOST { Vec::new() } else { found }
        })
    }
}

impl<P: Parts> Evaluator for JoinedEvaluator<'_, P> {
    fn enter(&mut self, region: &Aabb) {
        let parts = &self.joined.parts;
        let (centre, size) = (region.centre(), region.size());
        let reach = if parts.is_flat() { size.truncate().length() } else { size.length() } * 0.5 * (1.0 + 1e-9);
        // Of what repeats, a region that leaves the cubes around is folded point by point.
        let shift = match parts.period() {
            Some(period) if reach <= WITHIN * period => Some((centre / period).floor() * period),
            Some(_) => None,
            None => Some(DVec3::ZERO),
        };
        let shift = shift.filter(|_| reach.is_finite());
        let mut few = self.spare.pop().unwrap_or_default();
        few.clear();
        // Parts are counted in the cube of the outermost region that has one.
        let outer = self.regions.last().filter(|outer| outer.shift.is_some() && shift.is_some());
        let shift = outer.map_or(shift, |outer| outer.shift);
        let own = shift.map_or_else(|| self.joined.own(centre), |shift| self.flat(centre - shift));
        let known = outer.and_then(|outer| outer.inside);
        let (mut value, mut inside, mut is_whole) = (f64::NAN, None, self.joined.tree.is_none());
        if own.is_finite() {
            let around = Aabb::new(own, own);
            let tree = self.joined.tree.as_ref().filter(|_| outer.is_none_or(|outer| !outer.is_whole));
            let candidates = match (outer, shift) {
                _ if tree.is_some() => &[],
                (Some(outer), _) => &outer.few[..],
                (None, Some(_)) => self.joined.candidates(&around.grown(reach), &self.all),
                (None, None) => self.joined.candidates(&around, &self.all),
            };
            let best = match tree {
                Some(tree) => tree.best(parts, own).1,
                None => self.joined.best(candidates, own),
            };
            let here = known.or_else(|| parts.inside(own));
            value = self.joined.signed(best, here).0;
            // Pieces of a boundary that is farther away leave the side as it is.
            inside = known.or_else(|| here.filter(|_| value.abs() > reach));
            if shift.is_some() {
                let least = best.0 - 2.0 * reach - 1e-9 * (best.0.abs() + reach);
                match tree {
                    Some(tree) => is_whole = tree.at_least(parts, own, least, MOST_OF_TREE, &mut few),
                    None => {
                        few.extend(candidates.iter().filter(|index| parts.part(**index as usize, own).0 >= least));
                        is_whole = true;
                    }
                }
            }
        }
        self.regions.push(Region { centre, reach, shift, few, is_whole, value, inside, carriers: OnceCell::new() });
    }

    fn bounds(&mut self) -> Interval {
        let Some(region) = self.regions.last() else { return Interval::ALL };
        let by = region.reach + 1e-9 * (region.value.abs() + region.reach);
        let (lo, hi) = (region.value - by, region.value + by);
        match region.inside {
            _ if lo.is_nan() || hi.is_nan() => Interval::ALL,
            Some(true) => Interval::new(lo.max(0.0), hi),
            Some(false) => Interval::new(lo, hi.min(0.0)),
            None => Interval::new(lo, hi),
        }
    }

    fn hints(&mut self, _: Hint) -> Hints {
        /// As many parts as are better narrowed on the way to small regions.
        const MANY: usize = 8;
        Hints { has_many_parts: self.joined.parts.count() > MANY, ..Hints::NONE }
    }

    fn leave(&mut self) {
        self.spare.extend(self.regions.pop().map(|region| region.few));
    }

    fn values(&mut self, points: &Points, out: &mut [f32; BATCH]) {
        let Some((region, shift)) = self.listed() else {
            for (i, value) in out.iter_mut().enumerate().take(points.len) {
                *value = self.sample(points.position(i)).0 as f32;
            }
            return;
        };
        self.at_once(points, region, shift, |i, own, (value, _)| {
            out[i] = self.side(region, own, (value, DVec3::ZERO)).0 as f32;
        });
    }

    fn gradients(&mut self, points: &Points, out: &mut Gradients) {
        let Some((region, shift)) = self.listed() else {
            for i in 0..points.len {
                out.set(i, self.sample(points.position(i)));
            }
            return;
        };
        self.at_once(points, region, shift, |i, own, (value, part)| {
            let has_none = part == u32::MAX;
            let sample = if has_none { (value, DVec3::ZERO) } else { self.joined.parts.part(part as usize, own) };
            out.set(i, self.side(region, own, sample));
        });
    }

    fn branches(&self) -> usize {
        self.carriers().len().max(1)
    }

    fn branch(&mut self, branch: usize, points: &Points, out: &mut Gradients) {
        let Some(index) = self.carriers().get(branch).copied() else { return self.gradients(points, out) };
        let shift = self.regions.last().and_then(|region| region.shift).unwrap_or(DVec3::ZERO);
        for i in 0..points.len {
            out.set(i, self.joined.parts.carrier(index as usize, self.flat(points.position(i) - shift)));
        }
    }
}

/// A single part by a function.
pub struct Procedure<F> {
    /// The value and its gradient.
    pub at: F,
    /// A box that holds the solid, where there is one.
    pub bounds: Option<Aabb>,
    /// What the value says about distance; the slope must be 1 at most.
    pub slope: Slope,
    /// Whether z plays no role.
    pub is_flat: bool,
}

impl<F: Fn(DVec3) -> Sample + Send + Sync> Parts for Procedure<F> {
    fn count(&self) -> usize {
        1
    }

    fn part(&self, _: usize, position: DVec3) -> Sample {
        (self.at)(position)
    }

    fn bounding_box(&self) -> Option<Aabb> {
        self.bounds
    }

    fn slope(&self) -> Slope {
        self.slope
    }

    fn is_flat(&self) -> bool {
        self.is_flat
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::outline::Outline;
    use crate::field::struts::{Strut, Struts};

    /// What a region leaves out never changes a bit, also where all repeats.
    #[test]
    fn regions_leave_every_bit_as_it_is() {
        let bars: Vec<Strut> = DVec3::AXES.map(|axis| Strut::new(DVec3::ZERO, axis, [0.1; 2])).to_vec();
        let lattice = Joined::new(Struts::periodic(&bars, 1.0));
        let many: Vec<Strut> = (0..200)
            .map(|i| {
                let at =
                    |i: i32| DVec3::new(libm::sin(f64::from(i)), libm::cos(1.7 * f64::from(i)), 0.01 * f64::from(i));
                Strut::new(at(i), at(i + 1), [0.02, 0.03])
            })
            .collect();
        let line = Joined::new(Struts::new(many));
        let corner = |i: i32| {
            let far = if i % 2 == 0 { 1.0 } else { 0.6 };
            glam::DVec2::new(libm::cos(f64::from(i) * 0.2), libm::sin(f64::from(i) * 0.2)) * far
        };
        let mut outline = Outline::polygon(&(0..31).map(corner).collect::<Vec<_>>());
        outline.draw_circle(glam::DVec2::ZERO, 0.3);
        let outline = Joined::new(outline);
        let mut fine =
            Outline::polygon(&(0..400).map(|i| corner(i) * (1.0 + 0.001 * f64::from(i))).collect::<Vec<_>>());
        fine.draw_circle(glam::DVec2::ZERO, 0.3);
        let fine = Joined::new(fine);
        assert!(fine.tree.is_some() && outline.tree.is_none());
        for field in [&lattice as &dyn Field, &line as &dyn Field, &outline as &dyn Field, &fine as &dyn Field] {
            let mut evaluator = field.evaluator();
            for step in 0..60 {
                let centre = DVec3::new(0.03, -0.041, 0.027) * f64::from(step);
                let outer = Aabb::new(centre, centre).grown(0.25);
                let inner = Aabb::new(centre, centre).grown(0.02);
                let mut points = Points::new(centre);
                for i in 0..8 {
                    points.push((inner.corners()[i] - centre).as_vec3());
                }
                // Without a region, in one that repeats or not, and in a small one within.
                for (depth, region) in [None, Some(outer), Some(inner)].into_iter().enumerate() {
                    if let Some(region) = region {
                        evaluator.enter(&region);
                    }
                    let mut values = [0.0; BATCH];
                    evaluator.values(&points, &mut values);
                    for i in 0..8 {
                        let wanted = field.reference(points.position(i));
                        assert_eq!(values[i], wanted as f32, "{centre}, {depth}");
                        assert!(depth == 0 || evaluator.bounds().contains(wanted), "{centre}, {depth}");
                    }
                }
                evaluator.leave();
                evaluator.leave();
            }
        }
    }
}
