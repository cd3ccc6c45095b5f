//! Two colours mixed by weight, in a chosen space.

use super::colour_space::HueAxis;
use super::{ColourSpace, LinearRgb};
use crate::field::BATCH;

/// Hues further apart than this have no short way that a small change could not turn round: they go the decided way.
const NEARLY_OPPOSITE: f32 = 150.0;
/// Over these degrees before that, both ways are mixed, so that no two neighbours go different ways.
const MIXED_WAYS: f32 = 15.0;

/// Mixes colours of one object with colours of another.
///
/// In spaces with a hue the hue goes the short way round and a grey takes the other's. Where two hues are nearly
/// opposite, the way is that of the objects' mean colours, decided once, so that the body does not go through green
/// on one side and through violet on the other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mixer {
    space: ColourSpace,
    turn: Turn,
}

/// The way round from one hue to a nearly opposite one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub enum Turn {
    /// Through rising hues: red, yellow, green, blue.
    Up,
    /// Through falling hues.
    Down,
}

impl Turn {
    /// The short way between two colours' hues where they are far apart; up where they are exactly opposite, or nearer
    /// than a quarter turn: then they say nothing of the way between opposite hues, and which of them is the greater
    /// hangs on where they were sampled.
    pub fn between(space: ColourSpace, from: LinearRgb, to: LinearRgb) -> Self {
        let Some(axis) = space.hue_axis() else { return Self::Up };
        let apart = half_turn(space.encode(to)[axis.hue] - space.encode(from)[axis.hue]);
        // Exactly opposite colours come out a rounding error to either side.
        if apart < -90.0 && apart > -180.0 + 0.01 { Self::Down } else { Self::Up }
    }

    fn degrees(self) -> f32 {
        match self {
            Self::Up => 360.0,
            Self::Down => -360.0,
        }
    }
}

impl Mixer {
    /// Mixes in `space`, nearly opposite hues by way of `turn`.
    pub const fn new(space: ColourSpace, turn: Turn) -> Self {
        Self { space, turn }
    }

    /// `from` at weight 0, `to` at weight 1.
    pub fn mix(&self, from: LinearRgb, to: LinearRgb, weight: f32) -> LinearRgb {
        if weight <= 0.0 || from == to {
            return from;
        }
        if weight >= 1.0 {
            return to;
        }
        self.mix_encoded(self.space.encode(from), self.space.encode(to), weight)
    }

    /// Mixes a batch into `from`.
    pub fn mix_batch(
        &self,
        from: &mut [LinearRgb; BATCH],
        to: &[LinearRgb; BATCH],
        weights: &[f32; BATCH],
        len: usize,
    ) {
        // Neighbours mostly share their colour: what was encoded last serves again.
        let mut last = [([f32::NAN; 3], [0.0; 3]); 2];
        let space = self.space;
        let mut encode = |side: usize, colour: LinearRgb| {
            if last[side].0 != colour {
                last[side] = (colour, space.encode(colour));
            }
            last[side].1
        };
        for i in 0..len {
            let (one, two, weight) = (from[i], to[i], weights[i]);
            if weight <= 0.0 || one == two {
                continue;
            }
            from[i] = if weight >= 1.0 { two } else { self.mix_encoded(encode(0, one), encode(1, two), weight) };
        }
    }

    fn mix_encoded(&self, from: [f32; 3], to: [f32; 3], weight: f32) -> LinearRgb {
        let straight: [f32; 3] = std::array::from_fn(|i| from[i] + (to[i] - from[i]) * weight);
        let Some(axis) = self.space.hue_axis() else { return self.space.decode(straight) };
        let apart = half_turn(to[axis.hue] - from[axis.hue]);
        let by = |apart: f32| {
            let mut mixed = straight;
            mixed[axis.hue] = hue_between(axis, from, to, apart, weight);
            self.space.decode(mixed)
        };
        // Degrees by which the short way goes against the decided one.
        let against = -apart * self.turn.degrees().signum();
        let long = ((against - (NEARLY_OPPOSITE - MIXED_WAYS)) / MIXED_WAYS).clamp(0.0, 1.0);
        if long <= 0.0 {
            return by(apart);
        }
        let round = by(apart + self.turn.degrees());
        if long >= 1.0 {
            return round;
        }
        let short = by(apart);
        std::array::from_fn(|i| short[i] + (round[i] - short[i]) * long)
    }
}

/// The hue at a weight, `apart` degrees being the way to go; a colour with little hue of its own takes the other's.
fn hue_between(axis: HueAxis, from: [f32; 3], to: [f32; 3], apart: f32, weight: f32) -> f32 {
    let grey = |colour: [f32; 3]| 1.0 - smooth(colour[axis.strength] / axis.full);
    let (from_grey, to_grey) = (grey(from), grey(to));
    from[axis.hue] + apart * (from_grey + weight * (1.0 - from_grey) * (1.0 - to_grey))
}

fn smooth(share: f32) -> f32 {
    let share = share.clamp(0.0, 1.0);
    share * share * (3.0 - 2.0 * share)
}

/// The same angle in (−180, 180].
fn half_turn(degrees: f32) -> f32 {
    let turned = degrees % 360.0;
    if turned > 180.0 {
        turned - 360.0
    } else if turned <= -180.0 {
        turned + 360.0
    } else {
        turned
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::attribute::colour_space::from_srgb;

    fn hue_of(colour: LinearRgb) -> f32 {
        ColourSpace::Hsv.encode(colour)[0].rem_euclid(360.0)
    }

    fn hsv(hue: f32, saturation: f32, value: f32) -> LinearRgb {
        ColourSpace::Hsv.decode([hue, saturation, value])
    }

    #[test]
    fn ends_are_the_colours_themselves() {
        let (from, to) = ([0.9, 0.1, 0.2], [0.0, 0.3, 1.7]);
        for (_, space) in ColourSpace::NAMES {
            let mixer = Mixer::new(space, Turn::Up);
            assert_eq!(mixer.mix(from, to, 0.0), from);
            assert_eq!(mixer.mix(from, to, 1.0), to);
            assert_eq!(mixer.mix(from, from, 0.4), from);
        }
    }

    #[test]
    fn linear_light_mixes_by_weight() {
        let mixed = Mixer::new(ColourSpace::Rgb, Turn::Up).mix([1.0, 0.0, 0.5], [0.0, 1.0, 0.5], 0.25);
        assert_eq!(mixed, [0.75, 0.25, 0.5]);
    }

    #[test]
    fn hue_goes_the_short_way_and_evenly() {
        let mixer = Mixer::new(ColourSpace::Hsv, Turn::Down);
        for (from, to, middle) in [(350.0, 30.0, 10.0), (10.0, 100.0, 55.0), (100.0, 10.0, 55.0)] {
            let mixed = hue_of(mixer.mix(hsv(from, 1.0, 1.0), hsv(to, 1.0, 1.0), 0.5));
            assert!((mixed - middle).abs() < 0.1, "{from} to {to} came through {mixed}");
        }
    }

    #[test]
    fn a_grey_takes_the_others_hue() {
        let mixer = Mixer::new(ColourSpace::Hsv, Turn::Up);
        let red = hsv(0.0, 1.0, 1.0);
        for grey in [hsv(0.0, 0.0, 0.5), hsv(200.0, 0.001, 0.5)] {
            for mixed in [mixer.mix(grey, red, 0.5), mixer.mix(red, grey, 0.5)] {
                let hue = hue_of(mixed);
                assert!(hue.min(360.0 - hue) < 0.5, "{hue}");
            }
        }
    }

    #[test]
    fn opposite_hues_go_the_decided_way_on_both_sides_of_180() {
        let from = hsv(20.0, 1.0, 1.0);
        for turn in [Turn::Up, Turn::Down] {
            let middle = if turn == Turn::Up { 110.0 } else { 290.0 };
            for apart in [178.0, 180.0, 182.0] {
                let mixed = hue_of(Mixer::new(ColourSpace::Hsv, turn).mix(from, hsv(20.0 + apart, 1.0, 1.0), 0.5));
                assert!((mixed - middle).abs() < 1.5, "{apart}: {mixed}");
            }
        }
        let (red, cyan) = (from_srgb([1.0, 0.0, 0.0]), from_srgb([0.0, 1.0, 1.0]));
        assert_eq!(Turn::between(ColourSpace::Hsv, red, cyan), Turn::Up);
        assert_eq!(Turn::between(ColourSpace::Hsv, cyan, red), Turn::Up);
        for (to, turn) in [(25.0, Turn::Up), (15.0, Turn::Up), (-100.0, Turn::Down), (120.0, Turn::Up)] {
            assert_eq!(Turn::between(ColourSpace::Hsv, hsv(20.0, 1.0, 1.0), hsv(to, 1.0, 1.0)), turn, "{to}");
        }
    }

    /// No pair of nearly equal hues is mixed to very different colours.
    #[test]
    fn mixing_has_no_jumps() {
        let from = hsv(20.0, 1.0, 1.0);
        for turn in [Turn::Up, Turn::Down] {
            let at = |hue: f32| Mixer::new(ColourSpace::Hsv, turn).mix(from, hsv(hue, 1.0, 1.0), 0.5);
            for tenth in 0..3600 {
                let hue = tenth as f32 / 10.0;
                let (one, two) = (at(hue), at(hue + 0.1));
                let jump = one.iter().zip(two).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
                assert!(jump < 0.03, "{jump} at {hue}");
            }
        }
    }

    #[test]
    fn a_batch_is_mixed_as_its_points() {
        for (_, space) in ColourSpace::NAMES {
            let mixer = Mixer::new(space, Turn::Up);
            let colour = |i: usize, by: usize| [i % by, i / 7 % by, i % 3].map(|part| part as f32 / by as f32);
            let from: [LinearRgb; BATCH] = std::array::from_fn(|i| colour(i / 5, 11));
            let to: [LinearRgb; BATCH] = std::array::from_fn(|i| colour(i / 3, 13));
            let weights = std::array::from_fn(|i| i as f32 / 500.0 - 0.01);
            let mut mixed = from;
            mixer.mix_batch(&mut mixed, &to, &weights, BATCH);
            for i in 0..BATCH {
                assert_eq!(mixed[i], mixer.mix(from[i], to[i], weights[i]));
            }
        }
    }
}
