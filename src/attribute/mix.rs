//! Two values mixed by weight; colours in a chosen space.

use std::hint::select_unpredictable;

use super::colour_space::{HueAxis, LANES, Lanes};
use super::conversion::ab_of;
use super::{ColourSpace, LinearRgb};
use crate::field::lane_math::{clamp01, smooth};
use crate::field::{BATCH, Interval};

/// Hues further apart than this have no short way that a small change could not turn round: they go the decided way.
const NEARLY_OPPOSITE: f32 = 150.0;
/// The same where the way may be decided by what lies on it.
const NEARLY_OPPOSITE_AUTO: f32 = 130.0;
/// How much of [`ColourSpace::Auto`]'s way between opposite hues is the arc, the rest being the line. Less is grey on the
/// way, more goes through hues that neither has.
const ARC_OF_OPPOSITES: f32 = 0.45;
/// Hues of Oklab, in degrees, that are brown and olive where they are neither light nor strong: opposite colours do not go
/// through them.
const MUD: std::ops::Range<f32> = 30.0..150.0;
/// Over these degrees before that, both ways are mixed, so that no two neighbours go different ways.
const MIXED_WAYS: f32 = 15.0;

/// How two values of an attribute become one.
pub trait Mix<const N: usize>: Copy + Send + Sync {
    /// Mixes a batch into `from`, which is kept at weight 0 and becomes `to` at weight 1; entries past `len` are
    /// unspecified.
    fn mix_batch(&self, from: &mut [[f32; N]; BATCH], to: &[[f32; N]; BATCH], weights: &[f32; BATCH], len: usize);

    /// `from` at weight 0, `to` at weight 1.
    fn mix(&self, from: [f32; N], to: [f32; N], weight: f32) -> [f32; N];

    /// Whether each number is (1 − w)·from + w·to.
    fn is_straight(&self) -> bool {
        false
    }

    /// Bounds of what is mixed from values and weights within bounds; [`Interval::ALL`] where they are not known.
    fn bounds(&self, _from: [Interval; N], _to: [Interval; N], _weight: Interval) -> [Interval; N] {
        [Interval::ALL; N]
    }
}

/// Each number for itself: (1 − w)·from + w·to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Straight;

impl<const N: usize> Mix<N> for Straight {
    fn is_straight(&self) -> bool {
        true
    }

    fn mix_batch(&self, from: &mut [[f32; N]; BATCH], to: &[[f32; N]; BATCH], weights: &[f32; BATCH], len: usize) {
        for ((from, to), weight) in from.iter_mut().zip(to).zip(weights).take(len) {
            *from = self.mix(*from, *to, *weight);
        }
    }

    #[inline(always)]
    fn mix(&self, from: [f32; N], to: [f32; N], weight: f32) -> [f32; N] {
        let mixed = |i: usize| if weight >= 1.0 { to[i] } else { from[i] + (to[i] - from[i]) * weight };
        std::array::from_fn(mixed)
    }

    /// Linear in each of the three, so that the extremes are at ends.
    fn bounds(&self, from: [Interval; N], to: [Interval; N], weight: Interval) -> [Interval; N] {
        let end =
            |a: f64, b: f64, w: f64| if w == 0.0 || w == 1.0 { [a, b][w as usize] } else { a * (1.0 - w) + b * w };
        let at = |i: usize, w: f64| Interval::new(end(from[i].lo, to[i].lo, w), end(from[i].hi, to[i].hi, w));
        std::array::from_fn(|i| at(i, weight.lo).union(at(i, weight.hi)))
    }
}

/// Mixes colours of one object with colours of another. What lies between two colours that can be shown can be shown too:
/// where a space's way leads past 1, the channel stays there (or at the greatest of both, where that is more).
///
/// In spaces with a hue the hue goes the short way round and a grey takes the other's. Where two hues are nearly
/// opposite, the way is that of the objects' mean colours, decided once, so that the body does not go through green
/// on one side and through violet on the other.
///
/// [`ColourSpace::Auto`] goes between the line of Oklab, which is grey in the middle of opposite hues, and the arc of Oklch,
/// which goes through all hues between them.
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
        let (start, end) = (space.encode(from)[axis.hue], space.encode(to)[axis.hue]);
        let apart = half_turn(end - start);
        if space == ColourSpace::Auto {
            let middle_up = start + (end - start).rem_euclid(360.0) / 2.0;
            let is_mud = |hue: f32| MUD.contains(&hue.rem_euclid(360.0));
            match [middle_up, middle_up + 180.0].map(is_mud) {
                [true, false] => return Self::Down,
                [false, true] => return Self::Up,
                _ => {}
            }
        }
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

    /// Mixes in `space`, nearly opposite hues the way of two colours.
    pub fn between(space: ColourSpace, from: LinearRgb, to: LinearRgb) -> Self {
        Self::new(space, Turn::between(space, from, to))
    }

    #[inline(always)]
    fn mix_lanes<const N: usize>(&self, from: &mut [LinearRgb; N], to: &[LinearRgb; N], weights: &[f32; N]) {
        let (starts, ends) = (lanes_of(from), lanes_of(to));
        let mut mixing = false;
        for i in 0..N {
            mixing |= !((weights[i] <= 0.0) | (weights[i] >= 1.0) | same(&starts, i, &ends, i));
        }
        let mut mixed = [[0.0; N]; 3];
        if mixing {
            self.mix_encoded(&self.encoded(&starts), &self.encoded(&ends), weights, &mut mixed);
            // The way between two colours may lead out of what can be shown: below 0, where decoding stops it, or above 1.
            for i in 0..N {
                let mut most: f32 = 1.0;
                for channel in 0..3 {
                    most = most.max(starts[channel][i]).max(ends[channel][i]);
                }
                for mixed in &mut mixed {
                    mixed[i] = mixed[i].min(most);
                }
            }
        }
        // Not into `mixed`, which may be kept: see `lane_math`.
        let mut out = [[0.0; N]; 3];
        for i in 0..N {
            let (stays, goes) = ((weights[i] <= 0.0) | same(&starts, i, &ends, i), weights[i] >= 1.0);
            for channel in 0..3 {
                let moved = select_unpredictable(goes, ends[channel][i], mixed[channel][i]);
                out[channel][i] = select_unpredictable(stays, starts[channel][i], moved);
            }
        }
        for i in 0..N {
            from[i] = [out[0][i], out[1][i], out[2][i]];
        }
    }

    /// Colours in the mixer's space; neighbours often share theirs, which is then encoded once.
    #[inline(always)]
    fn encoded<const N: usize>(&self, colours: &Lanes<N>) -> Lanes<N> {
        let mut one = true;
        for i in 0..N {
            one &= same(colours, i, colours, 0);
        }
        let mut lanes = *colours;
        if one {
            let numbers = self.space.encode([colours[0][0], colours[1][0], colours[2][0]]);
            for part in 0..3 {
                for lane in &mut lanes[part] {
                    *lane = numbers[part];
                }
            }
        } else {
            self.space.encode_lanes(&mut lanes);
        }
        lanes
    }

    #[inline(always)]
    fn mix_encoded<const N: usize>(&self, from: &Lanes<N>, to: &Lanes<N>, weights: &[f32; N], mixed: &mut Lanes<N>) {
        for part in 0..3 {
            for i in 0..N {
                mixed[part][i] = from[part][i] + (to[part][i] - from[part][i]) * weights[i];
            }
        }
        let Some(axis) = self.space.hue_axis() else { return self.space.decode_lanes(mixed) };
        let is_auto = self.space == ColourSpace::Auto;
        let opposite = if is_auto { NEARLY_OPPOSITE_AUTO } else { NEARLY_OPPOSITE };
        let decode = |lanes: &mut Lanes<N>| {
            if is_auto {
                towards_line(from, to, weights, lanes);
                return ColourSpace::Oklab.decode_lanes(lanes);
            }
            self.space.decode_lanes(lanes);
        };
        let mut round = *mixed;
        let mut long = [0.0; N];
        let mut both = false;
        for i in 0..N {
            let apart = half_turn(to[axis.hue][i] - from[axis.hue][i]);
            let ends = [(from[axis.hue][i], from[axis.strength][i]), (to[axis.hue][i], to[axis.strength][i])];
            // Degrees by which the short way goes against the decided one.
            let against = -apart * self.turn.degrees().signum();
            long[i] = clamp01((against - (opposite - MIXED_WAYS)) / MIXED_WAYS);
            let decided = hue_between(axis, ends, apart + self.turn.degrees(), weights[i]);
            let short = hue_between(axis, ends, apart, weights[i]);
            mixed[axis.hue][i] = select_unpredictable(long[i] >= 1.0, decided, short);
            round[axis.hue][i] = decided;
            both |= (long[i] > 0.0) & (long[i] < 1.0);
        }
        decode(mixed);
        if both {
            decode(&mut round);
            let short = *mixed;
            for part in 0..3 {
                for i in 0..N {
                    let between = short[part][i] + (round[part][i] - short[part][i]) * long[i];
                    let is_between = (long[i] > 0.0) & (long[i] < 1.0);
                    mixed[part][i] = select_unpredictable(is_between, between, short[part][i]);
                }
            }
        }
    }
}

/// From lightness, chroma and hue on the arc between two colours to Oklab between that and the straight line.
#[inline(always)]
fn towards_line<const N: usize>(from: &Lanes<N>, to: &Lanes<N>, weights: &[f32; N], mixed: &mut Lanes<N>) {
    for i in 0..N {
        let (start, end) = (ab_of(from[1][i], from[2][i]), ab_of(to[1][i], to[2][i]));
        let arc = ab_of(mixed[1][i], mixed[2][i]);
        let lengths = from[1][i] * to[1][i];
        let cosine = (start[0] * end[0] + start[1] * end[1]) / select_unpredictable(lengths > 0.0, lengths, 1.0);
        let share = 1.0 - (1.0 - ARC_OF_OPPOSITES) * smooth(clamp01(0.5 - 0.5 * cosine));
        for part in 0..2 {
            let line = start[part] + (end[part] - start[part]) * weights[i];
            mixed[1 + part][i] = line + (arc[part] - line) * share;
        }
    }
}

impl Mix<3> for Mixer {
    fn mix_batch(&self, from: &mut [LinearRgb; BATCH], to: &[LinearRgb; BATCH], weights: &[f32; BATCH], len: usize) {
        mix_chunks(self, from, to, weights, len);
    }

    fn mix(&self, from: LinearRgb, to: LinearRgb, weight: f32) -> LinearRgb {
        let mut mixed = [from];
        self.mix_lanes(&mut mixed, &[to], &[weight]);
        mixed[0]
    }
}

#[multiversion::multiversion(targets = "simd")]
fn mix_chunks(
    mixer: &Mixer,
    from: &mut [LinearRgb; BATCH],
    to: &[LinearRgb; BATCH],
    weights: &[f32; BATCH],
    len: usize,
) {
    let from = from.as_chunks_mut::<LANES>().0.iter_mut();
    let (to, weights) = (to.as_chunks::<LANES>().0, weights.as_chunks::<LANES>().0);
    for ((from, to), weights) in from.zip(to).zip(weights).take(len.div_ceil(LANES)) {
        mixer.mix_lanes(from, to, weights);
    }
}

#[inline(always)]
fn lanes_of<const N: usize>(colours: &[LinearRgb; N]) -> Lanes<N> {
    let mut lanes = [[0.0; N]; 3];
    for i in 0..N {
        [lanes[0][i], lanes[1][i], lanes[2][i]] = colours[i];
    }
    lanes
}

/// Whether two lanes hold the same colour.
#[inline(always)]
fn same<const N: usize>(one: &Lanes<N>, i: usize, two: &Lanes<N>, j: usize) -> bool {
    (one[0][i] == two[0][j]) & (one[1][i] == two[1][j]) & (one[2][i] == two[2][j])
}

/// The hue at a weight, `apart` degrees being the way to go, between two hues with their strengths; a colour with
/// little hue of its own takes the other's.
#[inline(always)]
fn hue_between(axis: HueAxis, [from, to]: [(f32, f32); 2], apart: f32, weight: f32) -> f32 {
    let (from_grey, to_grey) = (1.0 - smooth(from.1 / axis.full), 1.0 - smooth(to.1 / axis.full));
    from.0 + apart * (from_grey + weight * (1.0 - from_grey) * (1.0 - to_grey))
}

/// A difference of two hues, less than a whole turn, as the same angle in (−180, 180].
#[inline(always)]
fn half_turn(degrees: f32) -> f32 {
    let down = select_unpredictable(degrees > 180.0, degrees - 360.0, degrees);
    select_unpredictable(down <= -180.0, down + 360.0, down)
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

    /// Near hues go along the arc; opposite ones neither through grey, nor through brown, nor by a full circle of hues.
    #[test]
    fn the_way_of_auto() {
        let css = |text: &str| {
            from_srgb([1, 3, 5].map(|at| f32::from(u8::from_str_radix(&text[at..at + 2], 16).unwrap()) / 255.0))
        };
        let chroma_and_hue = |colour: LinearRgb| {
            let [_, chroma, hue] = ColourSpace::Oklch.encode(colour);
            (chroma, hue.rem_euclid(360.0))
        };
        for (from, to) in
            [("#d7263d", "#1b998b"), ("#f4a259", "#3d348b"), ("#2e7d32", "#c2185b"), ("#00bcd4", "#ff5722")]
        {
            for (from, to) in [(css(from), css(to)), (css(to), css(from))] {
                let mixer = Mixer::between(ColourSpace::Auto, from, to);
                let ends = [from, to].map(|colour| chroma_and_hue(colour).0);
                let (middle, hue) = chroma_and_hue(mixer.mix(from, to, 0.5));
                let mean = (ends[0] + ends[1]) / 2.0;
                assert!(middle > 0.3 * mean && middle < 0.9 * mean, "{middle} of {mean}");
                assert!(!MUD.contains(&hue) || middle > 0.1, "{hue}");
                // Without jumps.
                let mut last = from;
                for step in 1..=200 {
                    let now = mixer.mix(from, to, step as f32 / 200.0);
                    let way = |colour: LinearRgb| ColourSpace::Oklab.encode(colour);
                    let far = way(now).iter().zip(way(last)).map(|(a, b)| (a - b).powi(2)).sum::<f32>().sqrt();
                    assert!(far < 0.01, "{far} at {step}");
                    last = now;
                }
            }
        }
        let (red, orange) = (css("#d7263d"), css("#f4a259"));
        let [auto, arc] =
            [ColourSpace::Auto, ColourSpace::Oklch].map(|space| Mixer::new(space, Turn::Up).mix(red, orange, 0.5));
        assert!(auto.iter().zip(arc).all(|(a, b)| (a - b).abs() < 0.01), "{auto:?} {arc:?}");
    }

    #[test]
    fn linear_light_mixes_by_weight() {
        let mixed = Mixer::new(ColourSpace::Rgb, Turn::Up).mix([1.0, 0.0, 0.5], [0.0, 1.0, 0.5], 0.25);
        assert_eq!(mixed, [0.75, 0.25, 0.5]);
    }

    /// Also where the plain way through the space leads beyond what can be shown, as between some colours it does.
    #[test]
    fn between_colours_that_can_be_shown_all_can() {
        let corner = |bits: usize| -> LinearRgb { [0, 1, 2].map(|channel| (bits >> channel & 1) as f32) };
        let mut beyond = 0;
        for (_, space) in ColourSpace::NAMES {
            let mixer = Mixer::new(space, Turn::Up);
            for pair in 0..64 {
                let (from, to) = (corner(pair >> 3), corner(pair & 7));
                for weight in [0.1, 0.25, 0.5, 0.75, 0.9] {
                    let mixed = mixer.mix(from, to, weight);
                    assert!(mixed.iter().all(|part| (0.0..=1.0).contains(part)), "{space:?} {from:?} {to:?} {mixed:?}");
                    let bright = mixer.mix(from.map(|part| 3.0 * part), to, weight);
                    assert!(
                        bright.iter().all(|part| (0.0..=3.0).contains(part)),
                        "{space:?} {from:?} {to:?} {bright:?}"
                    );
                    let (one, two) = (space.encode(from), space.encode(to));
                    let plain = space.decode(std::array::from_fn(|i| one[i] + (two[i] - one[i]) * weight));
                    beyond += usize::from(space == ColourSpace::Oklab && plain.iter().any(|part| *part > 1.01));
                }
            }
        }
        assert!(beyond > 0, "nothing was held back");
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
