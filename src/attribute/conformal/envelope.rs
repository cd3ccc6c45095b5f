//! The nearest of places that each have a start: the least of start + distance.

use std::cmp::Ordering;

use glam::Vec3;

/// So many places are looked at one by one.
const LEAF: usize = 8;

/// A place, its start, and its number.
pub(super) type Item = (Vec3, f32, u32);

/// Some places in a tree of boxes.
pub(super) struct Envelope {
    items: Vec<Item>,
    branches: Vec<Branch>,
}

struct Branch {
    min: Vec3,
    max: Vec3,
    /// The least start below.
    least: f32,
    /// Which places are below.
    items: std::ops::Range<usize>,
    /// The second of the two branches below, the first of which is the next one; 0 of a leaf.
    second: usize,
}

impl Envelope {
    pub fn new(items: Vec<Item>) -> Self {
        let mut tree = Self { items, branches: Vec::new() };
        tree.grow(0..tree.items.len());
        tree
    }

    fn grow(&mut self, range: std::ops::Range<usize>) {
        let items = &mut self.items[range.clone()];
        let min = items.iter().fold(Vec3::INFINITY, |min, (place, ..)| min.min(*place));
        let max = items.iter().fold(Vec3::NEG_INFINITY, |max, (place, ..)| max.max(*place));
        let least = items.iter().fold(f32::INFINITY, |least, (_, start, _)| least.min(*start));
        let number = self.branches.len();
        self.branches.push(Branch { min, max, least, items: range.clone(), second: 0 });
        if range.len() <= LEAF {
            return;
        }
        let (axis, middle) = ((max - min).max_position(), range.len() / 2);
        let along = |a: &Item, b: &Item| a.0[axis].total_cmp(&b.0[axis]).then(a.2.cmp(&b.2));
        items.select_nth_unstable_by(middle, along);
        self.grow(range.start..range.start + middle);
        self.branches[number].second = self.branches.len();
        self.grow(range.start + middle..range.end);
    }

    /// The least of start + distance at a place, and whose it is: of several the first's. `None` where there are no places.
    pub fn at(&self, place: Vec3) -> Option<(f32, u32)> {
        let mut best = None;
        if !self.items.is_empty() {
            self.look(0, place, &mut best);
        }
        best
    }

    fn look(&self, number: usize, place: Vec3, best: &mut Option<(f32, u32)>) {
        let branch = &self.branches[number];
        // Rounding may not leave out what comes first by its number.
        if best.is_some_and(|(known, _)| branch.at_least(place) * (1.0 - 1e-6) > known) {
            return;
        }
        if branch.second == 0 {
            for (there, start, item) in &self.items[branch.items.clone()] {
                let found = (start + there.distance(place), *item);
                if best.is_none_or(|known| order(found, known) == Ordering::Less) {
                    *best = Some(found);
                }
            }
            return;
        }
        let (first, second) = (number + 1, branch.second);
        let near = self.branches[first].at_least(place) <= self.branches[second].at_least(place);
        for next in if near { [first, second] } else { [second, first] } {
            self.look(next, place, best);
        }
    }
}

fn order(a: (f32, u32), b: (f32, u32)) -> Ordering {
    a.0.total_cmp(&b.0).then(a.1.cmp(&b.1))
}

impl Branch {
    fn at_least(&self, place: Vec3) -> f32 {
        self.least + place.distance(place.clamp(self.min, self.max))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::tests::Samples;

    #[test]
    fn the_least_is_that_of_all() {
        let mut samples = Samples::new(5);
        let mut place = |size: f64| {
            let [x, y, z] = [0; 3].map(|_: i32| (samples.next() * size).floor() as f32);
            Vec3::new(x, y, z)
        };
        for count in [1, 7, 300] {
            let items: Vec<Item> = (0..count).map(|i| (place(9.0), (i * 7 % 5) as f32, i)).collect();
            let tree = Envelope::new(items.clone());
            for _ in 0..200 {
                let at = place(15.0);
                let all = items.iter().map(|(there, start, item)| (start + there.distance(at), *item));
                assert_eq!(tree.at(at), all.min_by(|a, b| order(*a, *b)));
            }
        }
        assert_eq!(Envelope::new(Vec::new()).at(Vec3::ZERO), None);
    }
}
