//! Bounds over boxes: each node keeps those of its cells, from Bernstein coefficients; a box that meets few leaves
//! gets the coefficients of just the parts it meets.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use glam::{DVec3, IVec3};
use rayon::prelude::*;

use super::evaluate::Place;
use super::patch::{self, PatchBounds};
use super::steepest::Steepest;
use super::{DistanceObject, LEAF};
use crate::field::{Aabb, Interval};

/// Leaves cut to the box they are asked for, at most: a cut costs some microseconds. Where more are met, their whole
/// bounds are taken.
const CUT: usize = 8;

/// Leaves bounded by one thread before it looks for others: steep ones among them are looked at together.
const LEAVES_AT_ONCE: usize = 1024;

/// Cuts spent on the declared slope: some ten milliseconds.
const STEEPEST_CUTS: usize = 1000;

/// A node's bounds of F, ∂x, ∂y, ∂z, rounded outward.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stored([[f32; 2]; 4]);

fn down(x: f64) -> f32 {
    let y = x as f32;
    if f64::from(y) > x { y.next_down() } else { y }
}

fn up(x: f64) -> f32 {
    -down(-x)
}

impl Stored {
    const NONE: Self = Self([[f32::INFINITY, f32::NEG_INFINITY]; 4]);

    fn new(bounds: &PatchBounds) -> Self {
        let [x, y, z] = bounds.gradient;
        Self([bounds.value, x, y, z].map(|i| [down(i.lo), up(i.hi)]))
    }

    fn union(self, other: Self) -> Self {
        let range = |i: usize| {
            let ([lo, hi], [other_lo, other_hi]) = (self.0[i], other.0[i]);
            [lo.min(other_lo), hi.max(other_hi)]
        };
        Self(std::array::from_fn(range))
    }

    fn interval(&self, i: usize) -> Interval {
        Interval::new(f64::from(self.0[i][0]), f64::from(self.0[i][1]))
    }

    pub(super) fn value(&self) -> Interval {
        self.interval(0)
    }
}

/// Bounds of F and ∇F over a box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounded {
    /// Of F.
    pub value: Interval,
    /// Of ∂F/∂x, ∂F/∂y, ∂F/∂z.
    pub gradient: [Interval; 3],
    /// The most that |∇F| may be.
    pub steepest: f64,
}

impl Bounded {
    const EMPTY: Self = {
        let none = Interval::new(f64::INFINITY, f64::NEG_INFINITY);
        Self { value: none, gradient: [none; 3], steepest: 0.0 }
    };

    fn add(&mut self, value: Interval, gradient: [Interval; 3], steepest: f64) {
        self.value = self.value.union(value);
        self.gradient = std::array::from_fn(|axis| self.gradient[axis].union(gradient[axis]));
        self.steepest = self.steepest.max(steepest);
    }

    /// Whether bounds lie within these.
    fn holds(&self, stored: &Stored, steepest: f32) -> bool {
        let mut mine = [self.value, self.gradient[0], self.gradient[1], self.gradient[2]].into_iter().zip(stored.0);
        f64::from(steepest) <= self.steepest
            && mine.all(|(mine, other)| mine.lo <= f64::from(other[0]) && f64::from(other[1]) <= mine.hi)
    }

    fn add_stored(&mut self, stored: &Stored, steepest: f32) {
        let gradient = [stored.interval(1), stored.interval(2), stored.interval(3)];
        self.add(stored.interval(0), gradient, f64::from(steepest));
    }
}

/// Whether a box, in smallest cells, holds the whole of a node; `None` where they do not even touch.
fn met(place: Place, lo: [f64; 3], hi: [f64; 3]) -> Option<bool> {
    let (mut whole, mut met) = (true, true);
    for axis in 0..3 {
        let (from, to) = (f64::from(place.origin[axis]), f64::from(place.origin[axis] + place.size));
        whole &= lo[axis] <= from && to <= hi[axis];
        met &= lo[axis] <= to && from <= hi[axis];
    }
    met.then_some(whole)
}

/// A walk over the cells that a box meets.
struct Walk<'a> {
    object: &'a DistanceObject,
    /// The box, in smallest cells.
    lo: [f64; 3],
    hi: [f64; 3],
    found: Bounded,
    /// Leaves met in part, and whether there were more.
    partly: [Place; CUT],
    count: usize,
}

impl Walk<'_> {
    fn visit(&mut self, place: Place) {
        let Some(whole) = met(place, self.lo, self.hi) else { return };
        let node = self.object.nodes[place.node as usize];
        let (bounds, steepest) = self.object.stored(place);
        if whole {
            self.found.add_stored(bounds, steepest);
        } else if self.found.holds(bounds, steepest) {
            // Whatever is met in it adds nothing.
        } else if node & LEAF == 0 {
            for child in 0..8 {
                self.visit(place.nth_child(node, child));
            }
        } else {
            if self.count < CUT {
                self.partly[self.count] = place;
            } else {
                self.found.add_stored(bounds, steepest);
            }
            self.count += 1;
        }
    }

    fn finish(mut self) -> Bounded {
        for i in 0..self.count.min(CUT) {
            let place = self.partly[i];
            let (stored, steepest) = self.object.stored(place);
            if self.count > CUT {
                self.found.add_stored(stored, steepest);
                continue;
            }
            let cut = self.object.cut(place, self.lo, self.hi);
            self.found.add(cut.value, cut.gradient, f64::from(steepest));
        }
        self.found
    }
}

/// A part of a leaf, in its own \[0, 1\]³, and the bound of |∇F| there; the steepest first.
struct Steep {
    slope: f64,
    place: Place,
    min: [f64; 3],
    edge: f64,
}

impl Ord for Steep {
    fn cmp(&self, other: &Self) -> Ordering {
        self.slope.total_cmp(&other.slope)
    }
}

impl PartialOrd for Steep {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Steep {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for Steep {}

impl DistanceObject {
    /// A node's bounds, and the most that |∇F| may be in it.
    fn stored(&self, place: Place) -> (&Stored, f32) {
        (&self.bounds[place.node as usize], self.slopes[place.node as usize])
    }

    /// Bounds over the part of a leaf that lies in a box given in smallest cells.
    fn cut(&self, place: Place, lo: [f64; 3], hi: [f64; 3]) -> PatchBounds {
        let size = f64::from(place.size);
        // A thin box's slopes are differences over its edge; below this they would be rounding only.
        let thinnest = 1.0 / 256.0;
        let (mut from, mut to) = ([0.0; 3], [1.0; 3]);
        for axis in 0..3 {
            let origin = f64::from(place.origin[axis]);
            from[axis] = ((lo[axis] - origin) / size).clamp(0.0, 1.0 - thinnest);
            to[axis] = ((hi[axis] - origin) / size).clamp(from[axis] + thinnest, 1.0);
        }
        let patch = self.patch(place);
        let tensor = patch::restrict(&patch.bernstein(), from, to);
        let slopes = patch::slopes(&tensor, std::array::from_fn(|axis| (to[axis] - from[axis]) * patch.edge));
        patch::bounds(&tensor, &slopes, patch.edge)
    }

    /// The part of the root that is nearest to a box, in smallest cells.
    fn in_root(&self, region: &Aabb) -> [[f64; 3]; 2] {
        let top = f64::from(self.root_size());
        let lattice = |corner: DVec3| ((corner - self.origin) * self.inverse_step).to_array();
        // A hair more, for the rounding of positions.
        [
            lattice(region.min).map(|x| (x - 1e-6).clamp(0.0, top)),
            lattice(region.max).map(|x| (x + 1e-6).clamp(0.0, top)),
        ]
    }

    /// The least and the greatest smallest cell of the part of the root nearest to a box.
    pub(super) fn cells_of(&self, region: &Aabb) -> ([i32; 3], [i32; 3]) {
        let [lo, hi] = self.in_root(region).map(|corner| corner.map(|x| (x as i32).min(self.root_size() as i32 - 1)));
        (lo, hi)
    }

    /// The innermost node under `from` that holds the part of the root nearest to a box.
    pub(super) fn node_around(&self, region: &Aabb, from: Place) -> Place {
        let [lo, hi] = self.in_root(region);
        let inside = |place: &Place| {
            (0..3).all(|axis| {
                let low = f64::from(place.origin[axis]);
                low <= lo[axis] && hi[axis] <= low + f64::from(place.size)
            })
        };
        let mut place = if inside(&from) { from } else { self.root() };
        'down: while self.nodes[place.node as usize] & LEAF == 0 {
            for child in 0..8 {
                let next = place.nth_child(self.nodes[place.node as usize], child);
                if inside(&next) {
                    place = next;
                    continue 'down;
                }
            }
            break;
        }
        place
    }

    /// Bounds over the part of the root that is nearest to a box: the hull of the cells met, and the mean value
    /// theorem from the box's middle: F(c) + ∇F·(p − c) with ∇F somewhere in its bounds. `place` is a node that holds it.
    pub(super) fn bounds_in_root(&self, region: &Aabb, place: Place) -> Bounded {
        let [lo, hi] = self.in_root(region);
        let mut walk = Walk { object: self, lo, hi, found: Bounded::EMPTY, partly: [place; CUT], count: 0 };
        walk.visit(place);
        let mut bounded = walk.finish();
        let middle = DVec3::from(std::array::from_fn(|axis| (lo[axis] + hi[axis]) / 2.0));
        let value = self.jet(self.origin + middle * self.step)[0];
        let spread: f64 = (0..3)
            .map(|axis| {
                let steep = bounded.gradient[axis].lo.abs().max(bounded.gradient[axis].hi.abs());
                steep * (hi[axis] - lo[axis]) / 2.0 * self.step
            })
            .sum();
        let half = DVec3::from(lo).distance(DVec3::from(hi)) / 2.0 * self.step;
        let spread = spread.min(bounded.steepest * half);
        let mean = patch::padded(Interval::new(value - spread, value + spread), value.abs() + spread);
        bounded.value = Interval::new(bounded.value.lo.max(mean.lo), bounded.value.hi.min(mean.hi));
        bounded
    }

    /// The most that |∇F| may be in the part of the root that is nearest to a box; `place` is a node that holds it.
    pub(super) fn steepest_in_root(&self, region: &Aabb, place: Place) -> f64 {
        if self.nodes[place.node as usize] & LEAF != 0 {
            return f64::from(self.slopes[place.node as usize]);
        }
        let mut found = 0.0;
        self.visit_steepest(self.in_root(region), place, &mut found);
        f64::from(found)
    }

    /// Looks below a node, split, for slopes above what was found.
    fn visit_steepest(&self, region: [[f64; 3]; 2], place: Place, found: &mut f32) {
        let first = self.nodes[place.node as usize];
        let [lo, hi] = region;
        for (child, &steepest) in self.slopes[first as usize..][..8].iter().enumerate() {
            if steepest <= *found {
                continue;
            }
            let child = place.nth_child(first, child);
            let Some(whole) = met(child, lo, hi) else { continue };
            if whole || self.nodes[child.node as usize] & LEAF != 0 {
                *found = steepest;
            } else {
                self.visit_steepest(region, child, found);
            }
        }
    }

    /// Bounds of F and of its gradient over a box, which may reach beyond the root.
    pub fn bounds(&self, region: &Aabb) -> Bounded {
        self.bounds_from(region, self.root())
    }

    /// Works out every node's bounds, the slope, and the box of what may be inside. `places` are those of the leaves.
    pub(super) fn bound(&mut self, places: &[Place]) {
        let none = PatchBounds { value: Interval::ZERO, gradient: [Interval::ZERO; 3] };
        let (mut leaf_bounds, mut slopes) = (vec![none; places.len()], vec![0.0; places.len()]);
        let found = leaf_bounds.par_chunks_mut(LEAVES_AT_ONCE).zip(slopes.par_chunks_mut(LEAVES_AT_ONCE));
        places.par_chunks(LEAVES_AT_ONCE).zip(found).for_each(|(places, (bounds, longest))| {
            let mut steepest = Steepest::new();
            for (&place, bounds) in places.iter().zip(bounds) {
                let patch = self.patch(place);
                let tensor = patch.bernstein();
                let slopes = patch::slopes(&tensor, [patch.edge; 3]);
                *bounds = patch::bounds(&tensor, &slopes, patch.edge);
                steepest.add(&tensor, &slopes, patch.edge);
            }
            longest.iter_mut().zip(steepest.take()).for_each(|(longest, steepest)| *longest = steepest);
        });
        self.bounds = vec![Stored::NONE; self.nodes.len()];
        self.slopes = vec![0.0; self.nodes.len()];
        // Children stand after their parents.
        for node in (0..self.nodes.len()).rev() {
            let what = self.nodes[node];
            (self.bounds[node], self.slopes[node]) = if what & LEAF != 0 {
                let leaf = (what & !LEAF) as usize;
                (Stored::new(&leaf_bounds[leaf]), up(slopes[leaf]))
            } else {
                let children = what as usize..what as usize + 8;
                let bounds = self.bounds[children.clone()].iter().fold(Stored::NONE, |all, &child| all.union(child));
                (bounds, self.slopes[children].iter().copied().fold(0.0, f32::max))
            };
        }
        self.border = self.measure_border(places, &leaf_bounds, &slopes);
        self.slope = self.steepest(places, &slopes).max(self.border.slope());
        self.bounding_box = self.box_of_inside(places, &leaf_bounds);
    }

    /// A bound of |∇F| in the root, a tenth above the truth or less: the steepest cells are cut until their bounds
    /// come near a slope that was met.
    fn steepest(&self, places: &[Place], slopes: &[f64]) -> f64 {
        let mut leaves: Vec<usize> = (0..slopes.len()).collect();
        if leaves.len() > STEEPEST_CUTS {
            // Each cut takes one of them, and one is left to answer.
            leaves.select_nth_unstable_by(STEEPEST_CUTS, |&a, &b| slopes[b].total_cmp(&slopes[a]).then(a.cmp(&b)));
            leaves.truncate(STEEPEST_CUTS + 1);
        }
        let mut open: BinaryHeap<Steep> = (leaves.into_iter())
            .map(|leaf| Steep { slope: slopes[leaf], place: places[leaf], min: [0.0; 3], edge: 1.0 })
            .collect();
        let (mut met, mut parts) = (0.0_f64, Steepest::new());
        for _ in 0..STEEPEST_CUTS {
            let Some(steep) = open.pop() else { break };
            if steep.slope <= 1.1 * met {
                return steep.slope;
            }
            let patch = self.patch(steep.place);
            let tensor = patch.bernstein();
            let half = steep.edge / 2.0;
            let mins: [[f64; 3]; 8] = std::array::from_fn(|child| {
                std::array::from_fn(|axis| steep.min[axis] + if child & (4 >> axis) != 0 { half } else { 0.0 })
            });
            for min in mins {
                let jet = patch.jet(min.map(|x| x + half / 2.0));
                met = met.max((jet[4] * jet[4] + jet[2] * jet[2] + jet[1] * jet[1]).sqrt());
                let part = patch::restrict(&tensor, min, min.map(|x| x + half));
                parts.add(&part, &patch::slopes(&part, [half * patch.edge; 3]), patch.edge);
            }
            let halves = mins.into_iter().zip(parts.take());
            open.extend(halves.map(|(min, slope)| Steep { slope, place: steep.place, min, edge: half }));
        }
        open.pop().map_or(met, |steep| steep.slope)
    }

    /// Where the leaves are, in their order.
    pub(super) fn leaf_places(&self) -> Vec<Place> {
        let mut places = Vec::with_capacity(self.leaves.len());
        let mut open = vec![self.root()];
        while let Some(place) = open.pop() {
            let node = self.nodes[place.node as usize];
            if node & LEAF != 0 {
                places.push(place);
            } else {
                open.extend((0..8).rev().map(|child| place.nth_child(node, child)));
            }
        }
        places
    }

    /// The box around the leaves in which F may be positive, if F is negative all around the root.
    fn box_of_inside(&self, places: &[Place], bounds: &[PatchBounds]) -> Option<Aabb> {
        if self.border.greatest() >= 0.0 {
            return None;
        }
        let mut around: Option<Aabb> = None;
        for (place, _) in places.iter().zip(bounds).filter(|(_, bounds)| bounds.value.hi >= 0.0) {
            let min = self.origin + IVec3::from(place.origin).as_dvec3() * self.step;
            let cell = Aabb::new(min, min + f64::from(place.size) * self.step);
            around = Some(around.map_or(cell, |all| all.union(cell)));
        }
        around
    }
}
