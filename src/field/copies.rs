//! Many copies of one solid: F is the greatest value of all, found by a tree of their boxes, so that 100,000 copies cost
//! little more than one.
//!
//! A copy's value is `s·f(S⁻¹·p)` for the similarity S that places it, of scale s. Outside of its box it is no more than minus
//! the distance to that (the lesser of both, which has the same zero set), so that a copy whose box is farther away than the
//! greatest value found so far need not be looked at. The result is the union by maximum: exact outside where f is.

use std::cell::RefCell;

use glam::{DMat3, DVec3, Vec3};

use super::{Aabb, BATCH, Evaluator, Expression, Field, Gradients, Hint, Hints, Interval, Points, Side, Slope};

/// Copies whose boxes a leaf of the tree holds. Fewer makes the tree deeper, more makes leaves slow.
const LEAF: usize = 4;

/// More copies than these are not bounded one by one: the region is opened first.
const MOST_BOUNDED: usize = 24;

/// More copies than these near a batch: it is split in two.
const MOST_IN_BATCH: usize = 24;

/// Where a copy stands: scaled, then turned, then moved.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CopyPlace {
    /// How many times as large.
    pub scale: f64,
    /// How it is turned: a rotation.
    pub turn: DMat3,
    /// Where its origin is.
    pub at: DVec3,
}

impl CopyPlace {
    /// Moved alone.
    pub fn moved(at: DVec3) -> Self {
        Self { scale: 1.0, turn: DMat3::IDENTITY, at }
    }

    /// Where a position of the copy comes from.
    pub fn back(&self, position: DVec3) -> DVec3 {
        self.turn.transpose() * (position - self.at) / self.scale
    }

    /// Where a place of what is copied goes.
    pub fn forth(&self, own: DVec3) -> DVec3 {
        self.turn * (own * self.scale) + self.at
    }

    /// A vector of what is copied.
    pub fn carried(&self, vector: DVec3) -> DVec3 {
        self.turn * (vector * self.scale)
    }

    /// A box that holds all that a box comes from.
    pub fn region_back(&self, region: &Aabb) -> Aabb {
        let turn = self.turn.transpose();
        around(self.back(region.centre()), absolute(turn) * (region.size() * 0.5) / self.scale)
    }

    /// A box that holds all where a box goes.
    pub fn region_forth(&self, own: &Aabb) -> Aabb {
        around(self.forth(own.centre()), absolute(self.turn) * (own.size() * 0.5) * self.scale)
    }

    /// A batch of the copy, in the space of what is copied.
    fn points_back(&self, points: &Points, out: &mut Points) {
        (out.origin, out.len) = (self.back(points.origin), points.len);
        if self.turn == DMat3::IDENTITY && self.scale == 1.0 {
            (out.x, out.y, out.z) = (points.x, points.y, points.z);
            return;
        }
        turned(&(self.turn.transpose() * (1.0 / self.scale)), points, out);
    }
}

/// The offsets turned and stretched, in `f64`.
#[multiversion::multiversion(targets = "simd")]
fn turned(matrix: &DMat3, points: &Points, out: &mut Points) {
    let [a, b, c] = matrix.to_cols_array_2d();
    for i in 0..points.len {
        let (x, y, z) = (f64::from(points.x[i]), f64::from(points.y[i]), f64::from(points.z[i]));
        out.x[i] = (a[0] * x + b[0] * y + c[0] * z) as f32;
        out.y[i] = (a[1] * x + b[1] * y + c[1] * z) as f32;
        out.z[i] = (a[2] * x + b[2] * y + c[2] * z) as f32;
    }
}

/// The box around a centre, a few rounding errors larger than asked.
fn around(centre: DVec3, half: DVec3) -> Aabb {
    let half = half + (centre.abs() + half) * (8.0 * f64::EPSILON);
    Aabb::new(centre - half, centre + half)
}

fn absolute(matrix: DMat3) -> DMat3 {
    DMat3::from_cols(matrix.x_axis.abs(), matrix.y_axis.abs(), matrix.z_axis.abs())
}

pub(super) fn distance_to(aabb: &Aabb, position: DVec3) -> f64 {
    (aabb.min - position).max(position - aabb.max).max(DVec3::ZERO).length()
}

pub(super) fn distance_between(a: &Aabb, b: &Aabb) -> f64 {
    (a.min - b.max).max(b.min - a.max).max(DVec3::ZERO).length()
}

/// The greatest distance of a position of `region` from `aabb`.
pub(super) fn farthest(aabb: &Aabb, region: &Aabb) -> f64 {
    (aabb.min - region.min).max(region.max - aabb.max).max(DVec3::ZERO).length()
}

/// A node of the tree, in depth-first order: the lower half's nodes start right after a node.
#[derive(Clone, Copy)]
struct Branch {
    aabb: Aabb,
    /// Where the upper half's nodes start; 0 for a leaf.
    upper: u32,
    /// Its first copy, in the order of the tree.
    first: u32,
    count: u32,
}

/// Copies of a solid.
pub struct Copies {
    inner: Expression,
    /// The box of the solid.
    own: Aabb,
    places: Vec<CopyPlace>,
    boxes: Vec<Aabb>,
    order: Vec<u32>,
    tree: Vec<Branch>,
    /// Whether values are held below the distance to the box: where f does not fall as fast by itself.
    is_held: bool,
    /// No value is greater.
    most: f64,
}

impl Copies {
    /// Copies of a solid in a box, in some places. Where there are none nothing is inside.
    pub fn new(inner: Expression, own: Aabb, places: Vec<CopyPlace>) -> Self {
        let inner = inner.keeping_values();
        let slack = 1e-9 * own.longest_side();
        let own = own.grown(slack);
        let boxes: Vec<Aabb> = places.iter().map(|place| place.region_forth(&own)).collect();
        let mut order: Vec<u32> = (0..places.len() as u32).collect();
        let mut tree = Vec::new();
        if !order.is_empty() {
            grow(&boxes, &mut order, 0, &mut tree);
        }
        let is_held = !inner.slope().is_exact(Side::Outside);
        let most = {
            let mut evaluator = inner.evaluator();
            evaluator.enter(&own);
            let most = evaluator.bounds().hi;
            evaluator.leave();
            most * places.iter().map(|place| place.scale).fold(0.0, f64::max)
        };
        Self { inner, own, places, boxes, order, tree, is_held, most: most.max(0.0) }
    }

    /// Where they stand.
    pub fn places(&self) -> &[CopyPlace] {
        &self.places
    }

    /// The copy whose value is the greatest at a position, the first of several; `None` where there are none.
    pub fn copy_at(&self, position: DVec3) -> Option<usize> {
        self.greatest(position).map(|(copy, _)| copy as usize)
    }

    /// A box, in the space of what is copied, that holds all that a box comes from.
    pub fn region_back(&self, region: &Aabb) -> Aabb {
        let evaluator = self.new_evaluator();
        let (near, reach) = evaluator.near(region);
        match near {
            Some(near) => near
                .iter()
                .map(|&copy| self.places[copy as usize].region_back(region))
                .reduce(Aabb::union)
                .unwrap_or(self.own),
            None => {
                let least = self.places.iter().map(|place| place.scale).fold(f64::INFINITY, f64::min);
                self.own.grown((region.size().length() + reach) / least)
            }
        }
    }

    /// The value of a copy.
    fn value_of(&self, copy: u32, position: DVec3) -> f64 {
        let place = &self.places[copy as usize];
        let own = place.back(position);
        let value = place.scale * self.inner.reference(own);
        if self.is_held { held(value, place.scale * distance_to(&self.own, own)) } else { value }
    }

    /// The copy of the greatest value, and that.
    fn greatest(&self, position: DVec3) -> Option<(u32, f64)> {
        let mut best: Option<(u32, f64)> = None;
        let mut open = Vec::with_capacity(32);
        open.extend(self.tree.first().map(|root| (distance_to(&root.aabb, position), 0)));
        while let Some((distance, index)) = open.pop() {
            if best.is_some_and(|(_, value)| -distance < value) {
                continue;
            }
            let Branch { upper, first, count, .. } = self.tree[index as usize];
            if upper == 0 {
                for &copy in &self.order[first as usize..][..count as usize] {
                    if best.is_some_and(|(_, value)| -distance_to(&self.boxes[copy as usize], position) < value) {
                        continue;
                    }
                    let value = self.value_of(copy, position);
                    let better =
                        |(other, greatest): (u32, f64)| value > greatest || (value == greatest && copy < other);
                    if best.is_none_or(better) {
                        best = Some((copy, value));
                    }
                }
                continue;
            }
            let side = |child: u32| (distance_to(&self.tree[child as usize].aabb, position), child);
            let (a, b) = (side(index + 1), side(upper));
            // The nearer one is looked at first.
            let (near, far) = if b.0 < a.0 { (b, a) } else { (a, b) };
            open.extend([far, near]);
        }
        best
    }

    /// The copy whose box is the nearest to a position, and how far that is.
    fn nearest_box(&self, position: DVec3) -> Option<(u32, f64)> {
        let mut best: Option<(u32, f64)> = None;
        let mut open = Vec::with_capacity(32);
        open.extend(self.tree.first().map(|root| (distance_to(&root.aabb, position), 0)));
        while let Some((distance, index)) = open.pop() {
            if best.is_some_and(|(_, nearest)| distance >= nearest) {
                continue;
            }
            let Branch { upper, first, count, .. } = self.tree[index as usize];
            if upper == 0 {
                for &copy in &self.order[first as usize..][..count as usize] {
                    let distance = distance_to(&self.boxes[copy as usize], position);
                    if best.is_none_or(|(_, nearest)| distance < nearest) {
                        best = Some((copy, distance));
                    }
                }
                continue;
            }
            let side = |child: u32| (distance_to(&self.tree[child as usize].aabb, position), child);
            let (a, b) = (side(index + 1), side(upper));
            let (near, far) = if b.0 < a.0 { (b, a) } else { (a, b) };
            open.extend([far, near]);
        }
        best
    }

    /// The copies whose boxes are within a distance of a region, sorted; `None` where they are more than `most`.
    fn within(&self, region: &Aabb, reach: f64, most: usize) -> Option<Vec<u32>> {
        let reach = reach * (1.0 + 1e-9) + 1e-12 * region.size().max_element();
        let mut found = Vec::new();
        let mut open = Vec::with_capacity(32);
        open.extend(self.tree.first().map(|_| 0));
        while let Some(index) = open.pop() {
            let Branch { aabb, upper, first, count } = self.tree[index as usize];
            if distance_between(&aabb, region) > reach {
                continue;
            }
            if upper == 0 {
                let copies = &self.order[first as usize..][..count as usize];
                found.extend(
                    copies.iter().filter(|copy| distance_between(&self.boxes[**copy as usize], region) <= reach),
                );
                if found.len() > most {
                    return None;
                }
                continue;
            }
            open.extend([upper, index + 1]);
        }
        found.sort_unstable();
        Some(found)
    }

    fn new_evaluator(&self) -> CopiesEvaluator<'_> {
        CopiesEvaluator {
            copies: self,
            inner: RefCell::new(self.inner.evaluator()),
            regions: Vec::new(),
            there: Box::new(Points::new(DVec3::ZERO)),
            some: Box::default(),
            found: Box::default(),
            few: Vec::new(),
        }
    }
}

/// A value outside of a box is no more than minus the distance to it.
fn held(value: f64, outside: f64) -> f64 {
    if outside > 0.0 { value.min(-outside) } else { value }
}

/// Splits copies in halves along the longest side of their middles' box.
fn grow(boxes: &[Aabb], order: &mut [u32], first: u32, tree: &mut Vec<Branch>) {
    let of = |copy: &u32| boxes[*copy as usize];
    let whole = order.iter().map(of).reduce(Aabb::union).unwrap_or(Aabb::new(DVec3::ZERO, DVec3::ZERO));
    let place = tree.len();
    tree.push(Branch { aabb: whole, upper: 0, first, count: order.len() as u32 });
    if order.len() <= LEAF {
        return;
    }
    let middles = order.iter().map(|copy| of(copy).centre());
    let spread = middles.map(|middle| Aabb::new(middle, middle)).reduce(Aabb::union).map_or(DVec3::ZERO, Aabb::size);
    let axis = (0..3).fold(0, |longest, axis| if spread[axis] > spread[longest] { axis } else { longest });
    let half = order.len() / 2;
    // By number where the places are the same: the tree is the same on any machine.
    order.select_nth_unstable_by(half, |a, b| {
        let key = |copy: &u32| of(copy).centre()[axis];
        key(a).total_cmp(&key(b)).then(a.cmp(b))
    });
    let (lower, upper) = order.split_at_mut(half);
    grow(boxes, lower, first, tree);
    tree[place].upper = tree.len() as u32;
    grow(boxes, upper, first + half as u32, tree);
}

impl Field for Copies {
    fn bounding_box(&self) -> Option<Aabb> {
        // None at all is no solid: a box of a single point.
        Some(self.tree.first().map_or(Aabb::new(DVec3::ZERO, DVec3::ZERO), |root| root.aabb))
    }

    fn slope(&self) -> Slope {
        match self.inner.slope() {
            Slope::Exact { outside: true, .. } => Slope::Exact { outside: true, inside: false },
            Slope::Exact { .. } => Slope::Lipschitz(1.0),
            Slope::Lipschitz(bound) => Slope::Lipschitz(bound.max(1.0)),
            Slope::Unknown => Slope::Unknown,
        }
    }

    fn jumps(&self) -> bool {
        self.inner.jumps()
    }

    fn reference(&self, position: DVec3) -> f64 {
        self.greatest(position).map_or(-1.0, |(_, value)| value)
    }

    fn evaluator(&self) -> Box<dyn Evaluator + '_> {
        Box::new(self.new_evaluator())
    }
}

/// A region entered, and what was found of it.
struct Region {
    aabb: Aabb,
    bounds: Option<Interval>,
    /// The copies and their smooth branches that F consists of near its zero set.
    branches: RefCell<Option<Vec<(u32, u32)>>>,
}

struct CopiesEvaluator<'a> {
    copies: &'a Copies,
    inner: RefCell<Box<dyn Evaluator + 'a>>,
    regions: Vec<Region>,
    there: Box<Points>,
    some: Box<Gradients>,
    found: Box<Gradients>,
    /// Batches for points that lie far apart.
    few: Vec<Box<Points>>,
}

impl CopiesEvaluator<'_> {
    /// Bounds of one copy's value over a region.
    fn bounds_of(&self, copy: u32, region: &Aabb) -> Interval {
        let place = &self.copies.places[copy as usize];
        let own = place.region_back(region);
        let mut inner = self.inner.borrow_mut();
        inner.enter(&own);
        let Interval { lo, hi } = inner.bounds();
        inner.leave();
        let (lo, hi) = (place.scale * lo, place.scale * hi);
        if !self.copies.is_held {
            return Interval::new(lo.next_down(), hi.next_up());
        }
        let (far, near) = (farthest(&self.copies.own, &own), distance_between(&self.copies.own, &own));
        let slack = 1e-12 * place.scale * (far + self.copies.own.longest_side());
        let least = lo.min(if far > 0.0 { -place.scale * far - slack } else { f64::INFINITY });
        Interval::new(least.next_down(), held(hi, (place.scale * near - slack).max(0.0)).next_up())
    }

    /// The copies that may be the greatest somewhere in a region, and how far away their boxes may be; `None` where they are
    /// many.
    fn near(&self, region: &Aabb) -> (Option<Vec<u32>>, f64) {
        let Some((nearest, _)) = self.copies.nearest_box(region.centre()) else { return (Some(Vec::new()), 0.0) };
        let reach = (-self.bounds_of(nearest, region).lo).max(0.0);
        (self.copies.within(region, reach, MOST_BOUNDED), reach)
    }

    fn bounds_over(&self, region: &Aabb) -> Interval {
        let Some((nearest, _)) = self.copies.nearest_box(region.centre()) else { return Interval::new(-1.0, -1.0) };
        let first = self.bounds_of(nearest, region);
        match self.copies.within(region, (-first.lo).max(0.0), MOST_BOUNDED) {
            Some(near) => near.into_iter().fold(first, |all, copy| {
                let Interval { lo, hi } = self.bounds_of(copy, region);
                Interval::new(all.lo.max(lo), all.hi.max(hi))
            }),
            None => {
                let inside = self.copies.within(region, 0.0, 0).is_none_or(|touched| !touched.is_empty());
                Interval::new(first.lo, if inside { self.copies.most.max(first.hi) } else { -f64::MIN_POSITIVE })
            }
        }
    }

    /// One copy's values, with gradients where asked.
    fn read(&mut self, copy: u32, points: &Points, gradients: bool) {
        let Self { copies, inner, there, some, .. } = self;
        let place = &copies.places[copy as usize];
        place.points_back(points, there);
        let inner = inner.get_mut();
        if gradients {
            inner.gradients(there, some)
        } else {
            inner.values(there, &mut some.value)
        }
        finish(copies, place, there, some, gradients);
    }

    /// The greatest values at points that lie near one another; `None` where many copies are near them.
    fn near_values(&mut self, points: &Points, gradients: bool, out: &mut Gradients) -> Option<()> {
        let region = points.bounding_box()?;
        let Some((nearest, _)) = self.copies.nearest_box(region.centre()) else {
            out.value[..points.len].fill(-1.0);
            [&mut out.dx, &mut out.dy, &mut out.dz].into_iter().for_each(|part| part[..points.len].fill(0.0));
            return Some(());
        };
        self.read(nearest, points, gradients);
        let least = self.some.value[..points.len].iter().fold(f32::INFINITY, |least, value| least.min(*value));
        // Values are rounded; what is not a number is for whoever asked.
        let reach = if least.is_nan() { 0.0 } else { (-f64::from(least)).max(0.0) * (1.0 + 1e-5) };
        let near = self.copies.within(&region, reach, if points.len > 1 { MOST_IN_BATCH } else { usize::MAX })?;
        if near.len() <= 1 {
            std::mem::swap(out, &mut *self.some);
            return Some(());
        }
        for (place, copy) in near.into_iter().enumerate() {
            self.read(copy, points, gradients);
            if place == 0 {
                std::mem::swap(out, &mut *self.some);
            } else {
                greater(points.len, gradients, &self.some, out);
            }
        }
        Some(())
    }

    fn evaluate(&mut self, points: &Points, gradients: bool, out: &mut Gradients) {
        if points.len == 0 || self.near_values(points, gradients, out).is_some() {
            return;
        }
        // Halves along the longest side, until few copies are near each.
        let mut all: Vec<u16> = (0..points.len as u16).collect();
        let mut open = vec![(0, points.len)];
        let mut batch = self.few.pop().unwrap_or_else(|| Box::new(Points::new(DVec3::ZERO)));
        let mut found = std::mem::take(&mut self.found);
        while let Some((from, to)) = open.pop() {
            (batch.origin, batch.len) = (points.origin, 0);
            all[from..to].iter().for_each(|i| batch.push(points.offset(*i as usize)));
            if to - from < points.len && self.near_values(&batch, gradients, &mut found).is_some() {
                for (i, &place) in all[from..to].iter().enumerate() {
                    let place = place as usize;
                    out.value[place] = found.value[i];
                    (out.dx[place], out.dy[place], out.dz[place]) = (found.dx[i], found.dy[i], found.dz[i]);
                }
                continue;
            }
            let size = batch.bounding_box().map_or(DVec3::ZERO, Aabb::size);
            let axis = (0..3).fold(0, |longest, axis| if size[axis] > size[longest] { axis } else { longest });
            let along = |i: &u16| points.offset(*i as usize)[axis];
            let middle = (to - from) / 2;
            all[from..to].select_nth_unstable_by(middle, |a, b| along(a).total_cmp(&along(b)).then(a.cmp(b)));
            open.extend([(from, from + middle), (from + middle, to)]);
        }
        self.few.push(batch);
        self.found = found;
    }

    fn find_branches(&self, region: &Region) {
        let mut known = region.branches.borrow_mut();
        if known.is_some() {
            return;
        }
        let mut list = Vec::new();
        for copy in self.near(&region.aabb).0.unwrap_or_default() {
            if !self.bounds_of(copy, &region.aabb).contains(0.0) {
                continue;
            }
            let mut inner = self.inner.borrow_mut();
            inner.enter(&self.copies.places[copy as usize].region_back(&region.aabb));
            let count = inner.branches();
            inner.leave();
            list.extend((0..count as u32).map(|branch| (copy, branch)));
        }
        *known = Some(list);
    }
}

/// The values of a copy from those of what is copied.
fn finish(copies: &Copies, place: &CopyPlace, there: &Points, some: &mut Gradients, gradients: bool) {
    if place.scale != 1.0 {
        let scale = place.scale as f32;
        some.value[..there.len].iter_mut().for_each(|value| *value *= scale);
    }
    // ∇(s·f(Rᵀ(p − a)/s)) = R·∇f: the scale cancels.
    if copies.is_held {
        for i in 0..there.len {
            let own = there.position(i);
            let outside = (copies.own.min - own).max(own - copies.own.max).max(DVec3::ZERO);
            let limit = -(place.scale * outside.length()) as f32;
            if limit < 0.0 && limit < some.value[i] {
                some.value[i] = limit;
                if gradients {
                    let sign = DVec3::select(own.cmplt(copies.own.min), DVec3::NEG_ONE, DVec3::ONE);
                    let slope = -(outside * sign).normalize_or_zero().as_vec3();
                    (some.dx[i], some.dy[i], some.dz[i]) = (slope.x, slope.y, slope.z);
                }
            }
        }
    }
    if gradients && place.turn != DMat3::IDENTITY {
        let turn = place.turn.as_mat3();
        for i in 0..there.len {
            let slope = turn * Vec3::new(some.dx[i], some.dy[i], some.dz[i]);
            (some.dx[i], some.dy[i], some.dz[i]) = (slope.x, slope.y, slope.z);
        }
    }
}

fn greater(len: usize, gradients: bool, some: &Gradients, out: &mut Gradients) {
    for i in 0..len {
        if some.value[i] > out.value[i] {
            out.value[i] = some.value[i];
            if gradients {
                (out.dx[i], out.dy[i], out.dz[i]) = (some.dx[i], some.dy[i], some.dz[i]);
            }
        }
    }
}

impl Evaluator for CopiesEvaluator<'_> {
    fn enter(&mut self, region: &Aabb) {
        self.regions.push(Region { aabb: *region, bounds: None, branches: RefCell::default() });
    }

    fn bounds(&mut self) -> Interval {
        let Some(Region { aabb, bounds, .. }) = self.regions.last() else { return Interval::ALL };
        let found = bounds.unwrap_or_else(|| self.bounds_over(aabb));
        if let Some(region) = self.regions.last_mut() {
            region.bounds = Some(found);
        }
        found
    }

    fn leave(&mut self) {
        debug_assert!(!self.regions.is_empty(), "every leave matches an enter");
        self.regions.pop();
    }

    fn values(&mut self, points: &Points, out: &mut [f32; BATCH]) {
        let mut all = std::mem::take(&mut self.found);
        // `evaluate` takes `found` for its own parts.
        self.evaluate(points, false, &mut all);
        out[..points.len].copy_from_slice(&all.value[..points.len]);
        self.found = all;
    }

    fn gradients(&mut self, points: &Points, out: &mut Gradients) {
        self.evaluate(points, true, out);
    }

    fn hints(&mut self, _: Hint) -> Hints {
        Hints { keeps_values: true, ..Hints::NONE }
    }

    fn branches(&self) -> usize {
        let Some(region) = self.regions.last() else { return 1 };
        self.find_branches(region);
        region.branches.borrow().as_ref().map_or(1, |list| list.len().max(1))
    }

    fn branch(&mut self, branch: usize, points: &Points, out: &mut Gradients) {
        let known = self.regions.last().map(|region| {
            self.find_branches(region);
            (region.aabb, region.branches.borrow().as_ref().and_then(|list| list.get(branch).copied()))
        });
        let Some((region, Some((copy, branch)))) = known else { return self.gradients(points, out) };
        let place = self.copies.places[copy as usize];
        place.points_back(points, &mut self.there);
        let inner = self.inner.get_mut();
        inner.enter(&place.region_back(&region));
        inner.branch(branch as usize, &self.there, out);
        inner.leave();
        // A branch goes on where the solid is held.
        let (scale, turn) = (place.scale as f32, place.turn.as_mat3());
        for i in 0..points.len {
            out.value[i] *= scale;
            let slope = turn * Vec3::new(out.dx[i], out.dy[i], out.dz[i]);
            (out.dx[i], out.dy[i], out.dz[i]) = (slope.x, slope.y, slope.z);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::tests::Samples;
    use crate::field::{Graph, Node, SetSystem, rotation};

    const WORLD: Aabb = Aabb::new(DVec3::splat(-3.0), DVec3::splat(3.0));

    fn places(count: usize) -> Vec<CopyPlace> {
        let mut samples = Samples::new(5);
        (0..count)
            .map(|_| CopyPlace {
                scale: 0.5 + samples.next(),
                turn: rotation(samples.within(&Aabb::new(DVec3::ZERO, DVec3::splat(360.0)))),
                at: samples.within(&WORLD),
            })
            .collect()
    }

    fn solid(graph: &mut Graph, which: usize) -> (Node, Aabb) {
        let half = DVec3::new(0.25, 0.15, 0.1);
        let cuboid = graph.cuboid(half * 2.0);
        let node = match which {
            0 => cuboid,
            1 => graph.ellipsoid(half),
            _ => {
                let ball = graph.sphere(0.2);
                graph.union(SetSystem::R0, &[cuboid, ball])
            }
        };
        (node, graph.known_box(node).expect("it ends"))
    }

    /// The union of all copies, one by one, each held below the distance to its box.
    fn slow(which: usize, places: &[CopyPlace], p: DVec3) -> f64 {
        let mut graph = Graph::new();
        let (node, own) = solid(&mut graph, which);
        let field = Expression::new(&graph, node);
        let value = |place: &CopyPlace| {
            // Not by `back`, which is tested here.
            let forth = glam::DAffine3 { matrix3: place.turn * place.scale, translation: place.at };
            let q = forth.inverse().transform_point3(p);
            held(place.scale * field.reference(q), place.scale * distance_to(&own, q))
        };
        places.iter().map(value).fold(f64::NEG_INFINITY, f64::max)
    }

    #[test]
    fn it_is_the_greatest_of_all() {
        for (which, count) in [(0, 200), (1, 60), (2, 60), (0, 1)] {
            let places = places(count);
            let mut graph = Graph::new();
            let (node, own) = solid(&mut graph, which);
            let copies = Copies::new(Expression::new(&graph, node), own, places.clone());
            let mut evaluator = copies.evaluator();
            let mut samples = Samples::new(1);
            for size in [6.0, 0.5] {
                let min = samples.within(&Aabb::new(WORLD.min, WORLD.max - size));
                let points = samples.batch(&Aabb::new(min, min + size), 300);
                let (mut values, mut gradients) = ([0.0; BATCH], Gradients::new());
                evaluator.values(&points, &mut values);
                evaluator.gradients(&points, &mut gradients);
                for i in 0..points.len {
                    let p = points.position(i);
                    let exact = slow(which, &places, p);
                    assert!((copies.reference(p) - exact).abs() < 1e-8, "{} {exact}", copies.reference(p));
                    assert!((f64::from(values[i]) - exact).abs() < 1e-5, "{} {exact}", values[i]);
                    assert_eq!(values[i], gradients.value[i]);
                    let step = 1e-5;
                    let slope = DVec3::from_array(DVec3::AXES.map(|axis| {
                        (copies.reference(p + axis * step) - copies.reference(p - axis * step)) / (2.0 * step)
                    }));
                    let second = DVec3::from_array(DVec3::AXES.map(|axis| {
                        (copies.reference(p + axis * 9.0 * step) - copies.reference(p - axis * 9.0 * step))
                            / (18.0 * step)
                    }));
                    if (slope - second).length() < 1e-4 {
                        let found = gradients.gradient(i).as_dvec3();
                        assert!((found - slope).length() < 1e-3, "{which} at {p}: {found}, {slope}");
                    }
                }
            }
        }
    }

    #[test]
    fn bounds_hold_all_values_and_branches_all_of_the_surface() {
        let places = places(120);
        for which in 0..3 {
            let mut graph = Graph::new();
            let (node, own) = solid(&mut graph, which);
            let copies = Copies::new(Expression::new(&graph, node), own, places.clone());
            let (mut evaluator, mut samples) = (copies.evaluator(), Samples::new(8));
            let mut told = 0;
            for _ in 0..200 {
                let size = 6.0 * 0.5_f64.powf(7.0 * samples.next());
                let min = samples.within(&Aabb::new(WORLD.min, WORLD.max - size));
                let region = Aabb::new(min, min + size);
                evaluator.enter(&region);
                let bounds = evaluator.bounds();
                told += usize::from(!bounds.contains(0.0));
                for _ in 0..30 {
                    let value = copies.reference(samples.within(&region));
                    assert!(bounds.contains(value), "{which}: {value} is not in {bounds:?}");
                }
                // On the surface some branch is zero.
                if size < 0.2 && bounds.contains(0.0) {
                    let points = samples.batch(&region, 100);
                    let (mut all, mut one) = (Gradients::new(), Gradients::new());
                    evaluator.gradients(&points, &mut all);
                    let mut nearest = [f32::INFINITY; BATCH];
                    for branch in 0..evaluator.branches() {
                        evaluator.branch(branch, &points, &mut one);
                        (0..points.len).for_each(|i| nearest[i] = nearest[i].min((one.value[i] - all.value[i]).abs()));
                    }
                    for i in (0..points.len).filter(|i| all.value[*i].abs() < 1e-3) {
                        assert!(nearest[i] < 2e-3, "{which}: {} is {} from all branches", all.value[i], nearest[i]);
                    }
                }
                evaluator.leave();
            }
            assert!(told > 20, "bounds tell nothing: {told}");
        }
    }

    #[test]
    fn many_are_as_fast_as_few() {
        let mut graph = Graph::new();
        let ball = graph.sphere(0.01);
        let at =
            |i: usize| CopyPlace::moved(DVec3::new((i % 50) as f64, (i / 50 % 50) as f64, (i / 2500) as f64) * 0.1);
        let own = Aabb::new(DVec3::splat(-0.01), DVec3::splat(0.01));
        let copies = Copies::new(Expression::new(&graph, ball), own, (0..100_000).map(at).collect());
        for copy in [0, 777, 99_999] {
            let p = at(copy).at + DVec3::new(0.02, 0.01, 0.0);
            assert_eq!(copies.copy_at(p), Some(copy));
            assert!((copies.reference(p) - (0.01 - 0.0005_f64.sqrt())).abs() < 1e-12);
            let looked = copies.within(&Aabb::new(p - 0.01, p + 0.01), 0.02, usize::MAX).expect("any number");
            assert_eq!(looked, [copy as u32]);
        }
    }

    #[test]
    fn none_at_all_is_nothing() {
        let mut graph = Graph::new();
        let ball = graph.sphere(1.0);
        let own = Aabb::new(DVec3::splat(-1.0), DVec3::splat(1.0));
        let copies = Copies::new(Expression::new(&graph, ball), own, Vec::new());
        assert_eq!((copies.reference(DVec3::ZERO), copies.copy_at(DVec3::ZERO)), (-1.0, None));
        let mut values = [0.0; BATCH];
        copies.evaluator().values(&Samples::new(1).batch(&WORLD, 5), &mut values);
        assert_eq!(values[..5], [-1.0; 5]);
    }
}
