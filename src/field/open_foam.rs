//! Open foam: round struts along the edges where the cells of three points or more meet.
//!
//! Of points one in each cube of a lattice, which go on for ever, cells are cut out where space is asked for; those of given
//! points all at once. F is the radius minus the distance to the nearest edge, exact outside of the struts.

use std::cell::OnceCell;

use glam::{DVec3, I64Vec3};
use rayon::prelude::*;
use rustc_hash::FxHashMap;

use super::copies::distance_to;
use super::noise::hash::cells_around;
use super::part::{Parts, Sample};
use super::part_tree::PartTree;
use super::struts::{Strut, Struts};
use super::voronoi::Cell;
use super::walls::Centres;
use super::{Aabb, BATCH, Evaluator, Field, Gradients, Hint, Hints, Interval, Points, Seeds, Slope};

/// The edges of the cells of given points, each once. No cell is longer than `far` to any side; what has no end within has no
/// edges there.
pub fn edges_of(points: Vec<DVec3>, far: f64) -> Vec<[DVec3; 2]> {
    let centres = Centres(points);
    let Some(tree) = PartTree::new(&centres) else { return Vec::new() };
    let of = |own: usize| {
        let mut cell = Cell::within(centres.0[own], far);
        tree.visit(centres.0[own], f64::NEG_INFINITY, |other| {
            if other as usize != own {
                cell.cut(centres.0[other as usize], other as usize);
            }
            -2.0 * cell.reach()
        });
        first_of(own, &cell)
    };
    (0..centres.0.len()).into_par_iter().flat_map_iter(of).collect()
}

/// The edges of a cell that are no earlier one's.
fn first_of<K: Copy + Ord>(own: K, cell: &Cell<K>) -> Vec<[DVec3; 2]> {
    cell.edges().filter(|(_, beyond)| beyond.iter().all(|other| own < *other)).map(|(ends, _)| ends).collect()
}

/// In edges of a cube: nothing in the cell of a point is farther from it, since in the cube around each place there is one.
const FAR: f64 = 1.733;

/// The most cells that are kept, about 16 MB. Fewer: they are cut out anew as a job goes back and forth.
const KEPT: usize = 1 << 14;

/// A region of more edges of a cube is not narrowed: it would have hundreds of struts.
const NARROW: f64 = 1.0;

/// Struts around points one in each cube of a lattice.
pub struct OpenFoam {
    /// The points.
    pub seeds: Seeds,
    /// The radius of the struts.
    pub radius: f64,
}

/// The struts of a cell.
struct Cut {
    /// Of their axes.
    core: Option<Aabb>,
    struts: Vec<Strut>,
}

impl OpenFoam {
    /// What the cell of a cube's point has that is no earlier one's.
    fn cut(&self, cube: I64Vec3) -> Cut {
        let point = self.seeds.point(cube);
        let mut cell = Cell::within(point, FAR);
        let mut ring = 1;
        let mut around: Vec<(f64, DVec3, I64Vec3)> = Vec::new();
        // What is in the cubes of a ring is farther away than there are whole cubes between.
        while ((ring - 1) as f64) < 2.0 * cell.reach() {
            cells_around(ring, |by| {
                let other = self.seeds.point(cube + by);
                around.push((other.distance_squared(point), other, cube + by));
            });
            // The nearer ones leave less for others to cut off.
            around.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
            around.drain(..).for_each(|(_, other, cube)| cell.cut(other, cube.to_array()));
            ring += 1;
        }
        let strut = |[from, to]: [DVec3; 2]| Strut::new(from * self.seeds.edge, to * self.seeds.edge, [self.radius; 2]);
        let struts: Vec<Strut> = first_of(cube.to_array(), &cell).into_iter().map(strut).collect();
        Cut { core: struts.iter().map(|strut| strut.core().0).reduce(Aabb::union), struts }
    }
}

impl Field for OpenFoam {
    fn bounding_box(&self) -> Option<Aabb> {
        None
    }

    /// Inside of a strut a wall that another one covers does not count.
    fn slope(&self) -> Slope {
        Slope::Exact { outside: true, inside: false }
    }

    fn reference(&self, position: DVec3) -> f64 {
        OpenFoamEvaluator::new(self).at(position).0
    }

    fn evaluator(&self) -> Box<dyn Evaluator + '_> {
        Box::new(OpenFoamEvaluator::new(self))
    }
}

struct Region {
    centre: DVec3,
    reach: f64,
    /// F at the centre.
    value: f64,
    /// The struts that may be the nearest of a position in it; none are listed of a large one.
    few: Option<Few>,
    /// Those of them whose surface may pass through it.
    carriers: OnceCell<Vec<Strut>>,
}

/// Struts that are asked one by one, or by a tree where they are many.
struct Few {
    struts: Struts,
    tree: Option<PartTree>,
}

impl Few {
    fn new(struts: Vec<Strut>) -> Self {
        /// More of them are more work at each point than a look into the tree.
        const MOST: usize = 6;
        let struts = Struts::loose(struts);
        let tree = if struts.count() > MOST { PartTree::new(&struts) } else { None };
        Self { struts, tree }
    }

    fn best(&self, position: DVec3) -> Sample {
        match &self.tree {
            Some(tree) => tree.best(&self.struts, position).1,
            None => {
                self.struts.all().iter().map(|strut| strut.at(position)).fold((f64::NEG_INFINITY, DVec3::ZERO), better)
            }
        }
    }
}

struct OpenFoamEvaluator<'f> {
    foam: &'f OpenFoam,
    cuts: FxHashMap<I64Vec3, Cut>,
    regions: Vec<Region>,
}

impl<'f> OpenFoamEvaluator<'f> {
    fn new(foam: &'f OpenFoam) -> Self {
        Self { foam, cuts: FxHashMap::default(), regions: Vec::new() }
    }

    fn cut(&mut self, cube: I64Vec3) -> &Cut {
        if self.cuts.len() >= KEPT && !self.cuts.contains_key(&cube) {
            self.cuts.clear();
        }
        self.cuts.entry(cube).or_insert_with(|| self.foam.cut(cube))
    }

    /// All struts whose value at a position may be `least` or more. Each gives what that is from there on.
    fn visit(&mut self, position: DVec3, mut least: f64, mut each: impl FnMut(&Strut) -> f64) {
        let OpenFoam { seeds, radius } = *self.foam;
        let Some(cube) = seeds.cube(position) else { return };
        let (at, nearest) = (position / seeds.edge, -seeds.to_nearest(position).0 / seeds.edge);
        // The points around an edge are nearer to its places than all others: no farther from here than to such a place, and from
        // there the way back to here and to the point that is nearest here.
        let reach = |least: f64| (nearest + 2.0 * (radius - least) / seeds.edge) * (1.0 + 1e-9);
        let mut ring = 0;
        let mut around: Vec<(f64, I64Vec3)> = Vec::new();
        while (ring - 1) as f64 <= reach(least) {
            cells_around(ring, |by| around.push((seeds.point(cube + by).distance(at), cube + by)));
            ring += 1;
            if ring == 1 {
                continue;
            }
            around.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
            for (far, cube) in around.drain(..) {
                if far > reach(least) {
                    continue;
                }
                let cut = self.cut(cube);
                if cut.core.is_some_and(|core| radius - distance_to(&core, position) >= least) {
                    cut.struts.iter().for_each(|strut| least = each(strut));
                }
            }
        }
    }

    /// Of all struts.
    fn best(&mut self, position: DVec3) -> Sample {
        let mut best = (f64::NEG_INFINITY, DVec3::ZERO);
        self.visit(position, best.0, |strut| {
            best = better(best, strut.at(position));
            best.0
        });
        if best.0 == f64::NEG_INFINITY { (f64::NAN, DVec3::NAN) } else { best }
    }

    fn at(&mut self, position: DVec3) -> Sample {
        match self.regions.last().and_then(|region| region.few.as_ref()) {
            Some(few) => few.best(position),
            None => self.best(position),
        }
    }

    /// The carriers that may be zero in the region; none where they are too many to be told apart.
    fn carriers(&self) -> &[Strut] {
        const MOST: usize = 12;
        let Some(Region { centre, reach, few: Some(few), carriers, .. }) = self.regions.last() else { return &[] };
        carriers.get_or_init(|| {
            let found: Vec<Strut> =
                few.struts.all().iter().filter(|strut| strut.at(*centre).0.abs() <= *reach).copied().collect();
            if found.len() > MOST { Vec::new() } else { found }
        })
    }
}

fn better(one: Sample, other: Sample) -> Sample {
    if other.0 > one.0 { other } else { one }
}

impl Evaluator for OpenFoamEvaluator<'_> {
    fn enter(&mut self, region: &Aabb) {
        let centre = region.centre();
        let reach = region.size().length() * 0.5 * (1.0 + 1e-9);
        let value = self.at(centre).0;
        // Slopes are 1 at most: what is farther below the best than twice the way to a corner is nowhere the best.
        let least = value - 2.0 * reach - 1e-9 * (value.abs() + reach);
        let outer = self.regions.last().and_then(|outer| outer.few.as_ref());
        let near = |strut: &Strut| strut.at(centre).0 >= least;
        let narrowed: Option<Vec<Strut>> =
            outer.map(|outer| outer.struts.all().iter().filter(|strut| near(strut)).copied().collect());
        let few = match narrowed {
            None if reach <= NARROW * self.foam.seeds.edge && value.is_finite() => {
                let mut few = Vec::new();
                self.visit(centre, least, |strut| {
                    if near(strut) {
                        few.push(*strut);
                    }
                    least
                });
                Some(few)
            }
            narrowed => narrowed,
        };
        let few = few.map(Few::new);
        self.regions.push(Region { centre, reach, value, few, carriers: OnceCell::new() });
    }

    fn bounds(&mut self) -> Interval {
        let Some(region) = self.regions.last() else { return Interval::ALL };
        let by = region.reach + 1e-9 * (region.value.abs() + region.reach);
        let (lo, hi) = (region.value - by, region.value + by);
        if lo.is_nan() || hi.is_nan() { Interval::ALL } else { Interval::new(lo, hi) }
    }

    fn leave(&mut self) {
        self.regions.pop();
    }

    fn values(&mut self, points: &Points, out: &mut [f32; BATCH]) {
        for (i, value) in out.iter_mut().enumerate().take(points.len) {
            *value = self.at(points.position(i)).0 as f32;
        }
    }

    fn gradients(&mut self, points: &Points, out: &mut Gradients) {
        for i in 0..points.len {
            out.set(i, self.at(points.position(i)));
        }
    }

    fn hints(&mut self, _: Hint) -> Hints {
        Hints { has_many_parts: true, ..Hints::NONE }
    }

    fn branches(&self) -> usize {
        self.carriers().len().max(1)
    }

    fn branch(&mut self, branch: usize, points: &Points, out: &mut Gradients) {
        let Some(strut) = self.carriers().get(branch).copied() else { return self.gradients(points, out) };
        for i in 0..points.len {
            out.set(i, strut.at(points.position(i)));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::tests::Samples;

    /// The distance to the nearest of all edges around, found by the three nearest points of places along them: the judge knows
    /// nothing of cells that are cut out.
    #[test]
    fn the_nearest_edge_is_that_of_all_points() {
        for jitter in [0.3, 1.0] {
            let foam = OpenFoam { seeds: Seeds { edge: 0.5, jitter, seed: 3 }, radius: 0.05 };
            let around = Aabb::new(DVec3::ZERO, DVec3::ZERO).grown(3.0);
            let all = edges_of(foam.seeds.within(&around, 10_000).expect("few"), 2.0);
            let mut samples = Samples::new(2);
            let (mut evaluator, mut points) = (foam.evaluator(), Points::new(DVec3::ZERO));
            let near = Aabb::new(DVec3::splat(0.3), DVec3::splat(0.6));
            let mut expected = Vec::new();
            for _ in 0..BATCH {
                let at = samples.within(&near);
                points.push((at - points.origin).as_vec3());
                let at = points.position(points.len - 1);
                let to = |[from, to]: &[DVec3; 2]| {
                    let share = ((at - *from).dot(*to - *from) / from.distance_squared(*to)).clamp(0.0, 1.0);
                    at.distance(from.lerp(*to, share))
                };
                expected.push(0.05 - all.iter().map(to).fold(f64::INFINITY, f64::min));
            }
            let mut out = [0.0; BATCH];
            for narrowed in [false, true] {
                if narrowed {
                    evaluator.enter(&near.grown(1.0));
                    evaluator.enter(&near);
                    assert!(evaluator.branches() >= 1);
                }
                evaluator.values(&points, &mut out);
                for (i, wanted) in expected.iter().enumerate() {
                    assert!(
                        (f64::from(out[i]) - wanted).abs() < 1e-6,
                        "{}: {} for {wanted}",
                        points.position(i),
                        out[i]
                    );
                }
                let bounds = evaluator.bounds();
                assert!(
                    !narrowed
                        || out.iter().all(|value| bounds.lo <= f64::from(*value) && f64::from(*value) <= bounds.hi)
                );
            }
        }
    }

    /// In any place on an edge three points are as near as any.
    #[test]
    fn edges_lie_between_three_points() {
        let seeds = Seeds { edge: 1.0, jitter: 1.0, seed: 9 };
        let foam = OpenFoam { seeds, radius: 0.0 };
        let points = seeds.within(&Aabb::new(DVec3::splat(-4.0), DVec3::splat(5.0)), 10_000).expect("few");
        let cut = foam.cut(I64Vec3::ZERO);
        assert!(cut.struts.len() > 3);
        for strut in &cut.struts {
            let (core, _) = strut.core();
            let at = core.centre();
            let mut far: Vec<f64> = points.iter().map(|point| point.distance(at)).collect();
            far.sort_by(f64::total_cmp);
            assert!(far[2] - far[0] < 1e-9, "{at}: {:?}", &far[..4]);
        }
    }

    #[test]
    fn nowhere_is_no_number() {
        let foam = OpenFoam { seeds: Seeds { edge: 1.0, jitter: 1.0, seed: 9 }, radius: 0.1 };
        assert!(foam.reference(DVec3::NAN).is_nan() && foam.reference(DVec3::splat(1e300)).is_nan());
        let mut evaluator = foam.evaluator();
        evaluator.enter(&Aabb::new(DVec3::splat(-1e300), DVec3::splat(1e300)));
        assert!(evaluator.bounds().hi > 0.0);
    }
}
