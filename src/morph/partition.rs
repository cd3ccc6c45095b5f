//! The morph of one pair of corresponding partitions (STTI, section 4.2.2).

use super::error::Side;
use super::object::MorphObject;
use super::plan::{Morph, on_way};

impl Morph {
    /// The morph of a part of the first object into a part of the second: with the settings, the unit D and the t of the
    /// whole at every time. Its volume and the way round between hues are its own.
    pub fn of_parts(&self, from: MorphObject, to: MorphObject) -> Self {
        let objects = match &self.way {
            Some(way) => [on_way(way, Side::From, from), on_way(way, Side::To, to)],
            None => [from, to],
        };
        let (way, common) = (self.way.clone(), self.common.clone());
        let mut pair = Self::planned(objects, self.settings.clone(), self.plan.clone(), way, common);
        pair.measure_still();
        pair.delay.clone_from(&self.delay);
        pair.plan.turn = match &pair.still {
            Some(measured) => pair.turn(&measured.first, &measured.second),
            None => {
                let [start, end] = pair.settings.over.map(|time| pair.measure(time));
                pair.turn(&start.first, &end.second)
            }
        };
        pair
    }
}
