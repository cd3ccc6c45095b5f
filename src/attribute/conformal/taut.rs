//! Ways drawn taut: the bends of a wavefront's ways are moved from the nodes where they were found to where the ways are
//! shortest. (CONFORMAL leaves them at nodes, which makes a way a part of a cell longer at each bend.)

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicBool, Ordering};

use glam::Vec3;

use super::Error;
use super::feature::FEATURE;
use super::spread::{Spread, State};

/// How far from the surface a bend is kept, in cells. Less: ways from it begin in the tolerance of sight; more: as much
/// longer ways.
const KEPT: f32 = 0.01;
/// How often a bend is moved to where something passes the surface.
const ROUNDS: usize = 4;
/// The first step, in cells.
const FIRST: f32 = 0.5;
/// The last step, in cells: a way is off by the square of that.
const LAST: f32 = 0.02;
/// Steps at most: a bend is found within about two cells of where it should be.
const STEPS: usize = 48;
/// Bends that fewer ways go over are left where they are: most bends are of one way, along the borders of what the next one
/// sees, and hardly longer than straight.
const WAYS: usize = 32;
/// So many of the nodes whose ways bend there are asked, evenly.
const USERS: usize = 4;
/// A way that bends less than this is straight.
const STRAIGHT: f32 = 1e-3;

/// Where ways bend, and how long they are from there on, in cells.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Bend {
    pub place: Vec3,
    pub value: f32,
}

impl Bend {
    /// The length of the way from a place that sees it.
    #[inline(always)]
    pub fn from(&self, place: Vec3) -> f32 {
        self.value + place.distance(self.place)
    }
}

/// A bend that is being moved: the way onward is straight to `next`, and there are straight ways from `users`.
struct Pull<'s, 'b> {
    spread: &'s mut Spread<'b>,
    /// The next bend; none where that is the feature.
    next: Option<Bend>,
    users: Vec<Vec3>,
    start: Vec3,
}

impl Pull<'_, '_> {
    fn onward(&mut self, place: Vec3) -> Bend {
        self.next.unwrap_or_else(|| Bend { place: self.spread.compass.nearest(place), value: 0.0 })
    }

    /// How long ways over a place are in the mean, and the way in which they become shorter.
    fn cost(&mut self, place: Vec3) -> (f32, Vec3) {
        let onward = self.onward(place);
        let of_one = (self.users.len() as f32).recip();
        let ways = || self.users.iter().map(|user| *user - place);
        let pull: Vec3 = ways().map(|way| way.normalize_or_zero()).sum();
        let lengths: f32 = ways().map(|way| way.length()).sum();
        (onward.from(place) + lengths * of_one, (onward.place - place).normalize_or_zero() + pull * of_one)
    }

    /// Whether the ways over a place are inside.
    fn sees(&mut self, place: Vec3) -> bool {
        let onward = self.onward(place).place;
        let sight = &mut self.spread.sight;
        sight.is_clear(place, onward) && self.users.iter().all(|user| sight.is_clear(*user, place))
    }

    /// Where ways are shortest.
    fn best(mut self) -> Bend {
        let mut best = self.start;
        for _ in 0..ROUNDS {
            best = self.along_surface(best);
            let Some(nearer) = self.at_narrows(best) else { break };
            best = nearer;
        }
        let onward = self.onward(best);
        Bend { place: best, value: onward.from(best) }
    }

    /// Goes the way in which ways become shorter, as far as they are inside.
    fn along_surface(&mut self, start: Vec3) -> Vec3 {
        let mut place = start;
        let (mut cost, mut pull) = self.cost(place);
        let mut step = FIRST;
        let (mut free, mut inward) = self.spread.sight.clearance(place);
        for _ in 0..STEPS {
            if step < LAST {
                break;
            }
            let mut way = pull;
            if free < 2.0 * KEPT {
                way -= inward * way.dot(inward).min(0.0);
            }
            if way.length() < STRAIGHT {
                break;
            }
            let (to, there, normal) = self.inside(place + way.normalize() * step);
            let (shorter, on) = self.cost(to);
            if there >= 0.0 && shorter < cost && self.sees(to) {
                (place, cost, pull, free, inward) = (to, shorter, on, there, normal);
            } else {
                step *= 0.5;
            }
        }
        place
    }

    /// A place, moved inside where it is not, with how far it is from the surface, and the direction away from that.
    fn inside(&mut self, place: Vec3) -> (Vec3, f32, Vec3) {
        let (free, inward) = self.spread.sight.clearance(place);
        if free >= KEPT {
            return (place, free, inward);
        }
        let moved = place + inward * (KEPT - free);
        let (free, inward) = self.spread.sight.clearance(moved);
        (moved, free, inward)
    }

    /// Where one of the ways over a place just passes the surface, if ways over that are shorter: what a way is drawn taut
    /// against may lie beside the bend.
    fn at_narrows(&mut self, place: Vec3) -> Option<Vec3> {
        let (cost, _) = self.cost(place);
        let ends = std::iter::once(self.onward(place).place).chain(self.users.clone());
        let narrows: Vec<Vec3> = ends.filter_map(|end| self.spread.sight.narrows(place, end)).collect();
        narrows.into_iter().find_map(|narrow| {
            let (to, there, _) = self.inside(narrow);
            let is_better = there >= 0.0 && self.cost(to).0 < cost - LAST;
            (is_better && self.sees(to)).then_some(to)
        })
    }
}

/// Moves the bends, those nearest to the feature first, and gives all nodes the values of their ways over them; the bends by
/// their nodes. A bend whose next is hidden from it stays, and its ways go over where that was, if they were not shorter before.
///
/// # Errors
/// [`Error::Cancelled`].
pub(super) fn tighten(spread: &mut Spread<'_>, cancel: &AtomicBool) -> Result<BTreeMap<u32, Bend>, Error> {
    let settled = |spread: &Spread<'_>, node: usize| {
        let known = spread.nodes[node];
        (known.state == State::Settled && known.root < FEATURE).then_some(known.root)
    };
    let mut users: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
    for node in 0..spread.nodes.len() {
        if let Some(root) = settled(spread, node) {
            users.entry(root).or_default().push(node as u32);
        }
    }
    let mut order: Vec<u32> = users.keys().copied().collect();
    order.sort_by_key(|root| (spread.nodes[*root as usize].value.to_bits(), *root));
    let at_node = |root: &u32| {
        let bend = Bend { place: spread.body.place(*root), value: spread.nodes[*root as usize].value };
        (*root, bend)
    };
    let mut bends: BTreeMap<u32, Bend> = order.iter().map(at_node).collect();
    // How many ways go over each bend, those over other bends too.
    let mut ways: BTreeMap<u32, usize> = users.iter().map(|(root, users)| (*root, users.len())).collect();
    for node in order.iter().rev() {
        let (root, count) = (spread.nodes[*node as usize].root, ways[node]);
        if let Some(ways) = ways.get_mut(&root).filter(|_| root != *node) {
            *ways += count;
        }
    }
    for node in &order {
        if cancel.load(Ordering::Relaxed) {
            return Err(Error::Cancelled);
        }
        let root = spread.nodes[*node as usize].root;
        // At the surface, with the way through the air from there, it is its own.
        if root == *node {
            continue;
        }
        let (unmoved, next) = (bends[node], bends.get(&root).copied());
        let best = if ways[node] < WAYS {
            unmoved
        } else {
            // Those that are bends themselves must see it: many ways go over them.
            let (bends_of, others): (Vec<u32>, Vec<u32>) =
                users[node].iter().partition(|user| users.contains_key(user));
            let some = |all: Vec<u32>| {
                let step = all.len().div_ceil(USERS).max(1);
                all.into_iter().step_by(step)
            };
            let asked = some(bends_of).chain(some(others)).map(|user| spread.body.place(user)).collect();
            Pull { spread, next, users: asked, start: unmoved.place }.best()
        };
        let Some(next) = next else {
            bends.insert(*node, best);
            continue;
        };
        let seen = [best.place, unmoved.place].into_iter().find(|place| spread.sight.is_clear(*place, next.place));
        let bend = match seen {
            Some(place) => Bend { place, value: next.from(place) },
            None => {
                let was = spread.body.place(root);
                let over = next.from(was) + was.distance(unmoved.place);
                Bend { place: unmoved.place, value: unmoved.value.min(over) }
            }
        };
        bends.insert(*node, bend);
    }
    for node in 0..spread.nodes.len() {
        if let Some(root) = settled(spread, node) {
            spread.nodes[node].value = bends[&root].from(spread.body.place(node as u32));
        }
    }
    Ok(bends)
}
