//! Colour spaces, and how sRGB-encoded colours become scene-linear Rec.709.
//!
//! `palette` is built without the standard library's roots and powers, so that every machine gives the same bits.

use palette::{FromColor, Hsv, Lab, Lch, LinSrgb, Oklab, Srgb};

use super::LinearRgb;

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
    pub const NAMES: [(&'static str, Self); 5] =
        [("rgb", Self::Rgb), ("hsv", Self::Hsv), ("lab", Self::Lab), ("lch", Self::Lch), ("oklab", Self::Oklab)];

    /// The space of this name in a scene.
    pub fn named(name: &str) -> Option<Self> {
        Self::NAMES.iter().find(|(known, _)| *known == name).map(|(_, space)| *space)
    }

    /// A colour in this space.
    pub fn encode(self, colour: LinearRgb) -> [f32; 3] {
        let linear = LinSrgb::from(colour);
        match self {
            Self::Rgb => colour,
            Self::Hsv => {
                let hsv = Hsv::from_color(Srgb::<f32>::from_linear(linear));
                [hsv.hue.into_degrees(), hsv.saturation, hsv.value]
            }
            Self::Lab => Lab::from_color(linear).into(),
            Self::Lch => {
                let lch = Lch::from_color(linear);
                [lch.l, lch.chroma, lch.hue.into_degrees()]
            }
            Self::Oklab => Oklab::from_color(linear).into(),
        }
    }

    /// The colour that this space's numbers stand for; what lies outside Rec.709 is clamped to its border at 0.
    pub fn decode(self, numbers: [f32; 3]) -> LinearRgb {
        let [a, b, c] = numbers;
        let linear: LinSrgb<f32> = match self {
            Self::Rgb => return numbers,
            Self::Hsv => Srgb::from_color(Hsv::<palette::encoding::Srgb, f32>::new(a, b, c)).into_linear(),
            Self::Lab => LinSrgb::from_color(Lab::<palette::white_point::D65, f32>::new(a, b, c)),
            Self::Lch => LinSrgb::from_color(Lch::<palette::white_point::D65, f32>::new(a, b, c)),
            Self::Oklab => LinSrgb::from_color(Oklab::new(a, b, c)),
        };
        <[f32; 3]>::from(linear).map(|component| component.max(0.0))
    }

    pub(super) fn hue_axis(self) -> Option<HueAxis> {
        match self {
            Self::Rgb | Self::Lab | Self::Oklab => None,
            Self::Hsv => Some(HueAxis { hue: 0, strength: 1, full: 0.04 }),
            Self::Lch => Some(HueAxis { hue: 2, strength: 1, full: 2.0 }),
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
