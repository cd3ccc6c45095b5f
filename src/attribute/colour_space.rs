//! Colour spaces, and how sRGB-encoded colours become scene-linear Rec.709.
//!
//! `palette` is built without the standard library's roots and powers, so that every machine gives the same bits.

use palette::{LinSrgb, Srgb};

use super::{LinearRgb, conversion};

/// Several colours, or their numbers in a space: each component on its own, as vector loops want them.
pub(super) type Lanes<const N: usize> = [[f32; N]; 3];

/// The share of each of scene-linear Rec.709's red, green and blue in the luminance.
pub const LUMINANCE: [f64; 3] = [0.2126, 0.7152, 0.0722];

/// How many colours a vector loop takes at a time; a batch is a whole number of times as many.
pub(super) const LANES: usize = 64;

/// Converts every lane of the first into the second, or of one in its place. A macro, because a function that is handed
/// over is not always inlined, and then no vector code.
macro_rules! each {
    ($from:expr => $to:expr, $convert:path) => {
        for i in 0..$from[0].len() {
            let [a, b, c] = $convert([$from[0][i], $from[1][i], $from[2][i]]);
            ($to[0][i], $to[1][i], $to[2][i]) = (a, b, c);
        }
    };
}
pub(super) use each;

/// A space in which colours are mixed, three numbers a colour.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ColourSpace {
    /// Scene-linear red, green, blue.
    Rgb,
    /// Hue in degrees, saturation and value of the sRGB-encoded colour.
    Hsv,
    /// CIE L*a*b* under D65.
    Lab,
    /// CIE lightness, chroma, hue in degrees.
    Lch,
    /// Björn Ottosson's Oklab.
    Oklab,
    /// Its lightness, chroma, hue in degrees.
    Oklch,
    /// The same numbers; on the way between the straight line of Oklab and the arc of Oklch: along the arc between hues
    /// that are near, and nearer to the line the further they are apart. See [`super::Mixer`].
    Auto,
}

/// Where a space keeps its hue and what tells a grey.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct HueAxis {
    /// The component that is an angle in degrees.
    pub hue: usize,
    /// The component that is 0 for greys.
    pub strength: usize,
    /// The strength at which a hue counts in full. At 0 alone, a picture's noise would turn greys into rainbows.
    pub full: f32,
}

impl ColourSpace {
    /// All spaces, by their name in a scene.
    pub const NAMES: [(&'static str, Self); 7] = [
        ("auto", Self::Auto),
        ("rgb", Self::Rgb),
        ("hsv", Self::Hsv),
        ("lab", Self::Lab),
        ("lch", Self::Lch),
        ("oklab", Self::Oklab),
        ("oklch", Self::Oklch),
    ];

    /// The space of this name in a scene.
    pub fn named(name: &str) -> Option<Self> {
        Self::NAMES.iter().find(|(known, _)| *known == name).map(|(_, space)| *space)
    }

    /// A colour in this space.
    pub fn encode(self, colour: LinearRgb) -> [f32; 3] {
        let mut lanes = colour.map(|component| [component]);
        self.encode_lanes(&mut lanes);
        lanes.map(|[number]| number)
    }

    /// The colour that this space's numbers stand for; what lies outside Rec.709 is clamped to its border at 0.
    pub fn decode(self, numbers: [f32; 3]) -> LinearRgb {
        let mut lanes = numbers.map(|number| [number]);
        self.decode_lanes(&mut lanes);
        lanes.map(|[component]| component)
    }

    /// As [`Self::encode`]. Inlined, so that it is compiled for its caller's vector width.
    #[inline(always)]
    pub(super) fn encode_lanes<const N: usize>(self, lanes: &mut Lanes<N>) {
        match self {
            Self::Rgb => {}
            Self::Hsv => each!(lanes => lanes, conversion::hsv_of_linear),
            Self::Lab => each!(lanes => lanes, conversion::lab_of_linear),
            Self::Lch => each!(lanes => lanes, conversion::lch_of_linear),
            Self::Oklab => each!(lanes => lanes, conversion::oklab_of_linear),
            Self::Oklch | Self::Auto => each!(lanes => lanes, conversion::oklch_of_linear),
        }
    }

    /// As [`Self::decode`]. Inlined, so that it is compiled for its caller's vector width.
    #[inline(always)]
    pub(super) fn decode_lanes<const N: usize>(self, lanes: &mut Lanes<N>) {
        match self {
            Self::Rgb => return,
            Self::Hsv => each!(lanes => lanes, conversion::linear_of_hsv),
            Self::Lab => each!(lanes => lanes, conversion::linear_of_lab),
            Self::Lch => each!(lanes => lanes, conversion::linear_of_lch),
            Self::Oklab => each!(lanes => lanes, conversion::linear_of_oklab),
            Self::Oklch | Self::Auto => each!(lanes => lanes, conversion::linear_of_oklch),
        }
        // What is below 0 less itself: a choice between 0 and what is there becomes a masked store (see `lane_math`).
        for value in lanes.as_flattened_mut() {
            *value -= if *value < 0.0 { *value } else { 0.0 };
        }
    }

    pub(super) fn hue_axis(self) -> Option<HueAxis> {
        match self {
            Self::Rgb | Self::Lab | Self::Oklab => None,
            Self::Hsv => Some(HueAxis { hue: 0, strength: 1, full: 0.04 }),
            Self::Lch => Some(HueAxis { hue: 2, strength: 1, full: 2.0 }),
            Self::Oklch | Self::Auto => Some(HueAxis { hue: 2, strength: 1, full: 0.02 }),
        }
    }
}

/// The colour of sRGB-encoded components, each 0…1.
pub fn from_srgb(components: [f32; 3]) -> LinearRgb {
    Srgb::from(components).into_linear().into()
}

/// The sRGB-encoded components of a colour.
pub fn to_srgb(colour: LinearRgb) -> [f32; 3] {
    Srgb::<f32>::from_linear(LinSrgb::from(colour)).into()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn close(a: [f32; 3], b: [f32; 3], within: f32) -> bool {
        a.iter().zip(b).all(|(a, b)| (a - b).abs() <= within)
    }

    /// Published values of pure red: CSS Color 4's samples for Lab (D65) and Oklab.
    #[test]
    fn red_in_every_space() {
        let red = [1.0, 0.0, 0.0];
        assert!(close(ColourSpace::Hsv.encode(red), [0.0, 1.0, 1.0], 1e-5));
        assert!(close(ColourSpace::Lab.encode(red), [53.24, 80.09, 67.20], 0.02));
        assert!(close(ColourSpace::Lch.encode(red), [53.24, 104.55, 40.0], 0.02));
        assert!(close(ColourSpace::Oklab.encode(red), [0.62796, 0.22486, 0.12585], 1e-3));
    }

    #[test]
    fn decoding_undoes_encoding() {
        for colour in [[0.2, 0.5, 0.9], [1.0, 0.0, 0.0], [0.0, 0.0, 0.0], [1.0, 1.0, 1.0], [0.3, 0.3, 0.3]] {
            for (name, space) in ColourSpace::NAMES {
                let back = space.decode(space.encode(colour));
                assert!(close(back, colour, 2e-4), "{name}: {colour:?} became {back:?}");
            }
        }
    }

    /// The worked values of IEC 61966-2-1 for 0x80, 0xbc and 0x0a.
    #[test]
    fn srgb_is_decoded_and_encoded() {
        let [r, g, b] = from_srgb([128.0 / 255.0, 188.0 / 255.0, 10.0 / 255.0]);
        assert!(close([r, g, b], [0.215_860_5, 0.502_886_5, 0.003_035_27], 1e-7), "{r} {g} {b}");
        assert_eq!((from_srgb([1.0; 3]), from_srgb([0.0; 3])), ([1.0; 3], [0.0; 3]));
        assert!(close(to_srgb(from_srgb([0.1, 0.5, 0.7])), [0.1, 0.5, 0.7], 1e-6));
    }
}
