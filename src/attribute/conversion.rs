//! Conversions between colour spaces, one lane at a time: `+ − × ÷`, comparisons and the functions of `lane_math`, so
//! that loops over them become vector code, the same bits at every width.
//!
//! Against the same formulas in `f64`, colours of 0…1 come back within 2·10⁻⁶ (sRGB, HSV) and 10⁻⁵ (the CIE's spaces
//! and Oklab): far below the 1/255 that a picture can tell.

use std::hint::select_unpredictable;

use super::LinearRgb;
use crate::field::lane_math::{atan2, cbrt, clamp01, cos, short_pow, sin};

type Rows = [[f32; 3]; 3];

/// Rec.709 to CIE XYZ under D65 (Lindbloom), each row by the white's component.
const TO_XYZ: Rows = [
    [0.4124564 / 0.95047, 0.3575761 / 0.95047, 0.1804375 / 0.95047],
    [0.2126729, 0.7151522, 0.0721750],
    [0.0193339 / 1.08883, 0.119_192 / 1.08883, 0.9503041 / 1.08883],
];
/// Its inverse.
const OF_XYZ: Rows = [
    [3.2404542 * 0.95047, -1.5371385, -0.4985314 * 1.08883],
    [-0.969_266 * 0.95047, 1.8760108, 0.041_556 * 1.08883],
    [0.0556434 * 0.95047, -0.2040259, 1.0572252 * 1.08883],
];

// Ottosson, "A perceptual color space for image processing" (2020), the matrices of 2021.
const TO_CONES: Rows = [
    [0.412_221_47, 0.536_332_55, 0.051_445_995],
    [0.211_903_5, 0.680_699_5, 0.107_396_96],
    [0.088_302_46, 0.281_718_85, 0.629_978_7],
];
const OF_CONES: Rows = [
    [4.076_741_7, -3.307_711_6, 0.230_969_94],
    [-1.268_438, 2.609_757_4, -0.341_319_38],
    [-0.004_196_086_3, -0.703_418_6, 1.707_614_7],
];
const TO_OKLAB: Rows = [
    [0.210_454_26, 0.793_617_8, -0.004_072_047],
    [1.977_998_5, -2.428_592_2, 0.450_593_7],
    [0.025_904_037, 0.782_771_77, -0.808_675_77],
];
const OF_OKLAB: Rows =
    [[1.0, 0.396_337_78, 0.215_803_76], [1.0, -0.105_561_346, -0.063_854_17], [1.0, -0.089_484_18, -1.291_485_5]];

#[inline(always)]
fn times([top, middle, bottom]: &Rows, [x, y, z]: [f32; 3]) -> [f32; 3] {
    let row = |[a, b, c]: &[f32; 3]| a * x + b * y + c * z;
    [row(top), row(middle), row(bottom)]
}

/// The linear value of an sRGB-encoded one (IEC 61966-2-1), above 1 too.
#[inline(always)]
fn of_srgb(value: f32) -> f32 {
    let power = short_pow((value + 0.055) * (1.0 / 1.055), 2.4);
    select_unpredictable(value <= 0.04045, value * (1.0 / 12.92), power)
}

/// [`of_srgb`] of values in 0…1, without a logarithm. ((v + 0.055)/1.055)^2.4 is s^4.8 of the root s, which is near to a
/// polynomial: relative errors below 1.3·10⁻⁷ (weighted least squares after Lawson, 1 kept), 8·10⁻⁷ with those of `f32`.
#[inline(always)]
fn of_srgb_up_to_1(value: f32) -> f32 {
    let s = (value * (1.0 / 1.055) + 0.055 / 1.055).sqrt();
    let mut power = 0.012_032_255;
    for coefficient in
        [-0.089_516_826, 0.909_841_95, 0.208_441_54, -0.049_601_868, 0.009_979_424, -0.001_246_405_3, 6.994_924e-5]
    {
        power = power * s + coefficient;
    }
    select_unpredictable(value <= 0.04045, value * (1.0 / 12.92), power)
}

/// The sRGB-encoded value of a linear one.
#[inline(always)]
fn to_srgb(value: f32) -> f32 {
    let power = 1.055 * short_pow(value, 1.0 / 2.4) - 0.055;
    select_unpredictable(value <= 0.003_130_8, value * 12.92, power)
}

/// The colour of sRGB-encoded red, green and blue, each 0…1.
#[inline(always)]
pub fn linear_of_srgb([red, green, blue]: [f32; 3]) -> LinearRgb {
    [of_srgb_up_to_1(red), of_srgb_up_to_1(green), of_srgb_up_to_1(blue)]
}

/// Hue in degrees, −60…300 and 0 for greys; saturation and value of the sRGB-encoded colour.
#[inline(always)]
pub fn hsv_of_linear([red, green, blue]: LinearRgb) -> [f32; 3] {
    let (red, green, blue) = (to_srgb(red), to_srgb(green), to_srgb(blue));
    let least = select_unpredictable(red < green, red, green);
    let most = select_unpredictable(red < green, green, red);
    let least = select_unpredictable(blue < least, blue, least);
    let most = select_unpredictable(blue > most, blue, most);
    let chroma = most - least;
    let offset = select_unpredictable(most == red, 0.0, select_unpredictable(most == green, 2.0, 4.0));
    let of_others = select_unpredictable(most == green, blue - red, red - green);
    let sixth = select_unpredictable(most == red, green - blue, of_others);
    let hue = 60.0 * (offset + sixth / chroma);
    let saturation = chroma / most;
    [select_unpredictable(chroma > 0.0, hue, 0.0), select_unpredictable(most > 0.0, saturation, 0.0), most]
}

/// The colour of a hue of any number of degrees, saturation and value, above 1 too.
#[inline(always)]
pub fn linear_of_hsv(numbers: [f32; 3]) -> LinearRgb {
    let [red, green, blue] = srgb_of_hsv(numbers);
    [of_srgb(red), of_srgb(green), of_srgb(blue)]
}

/// The same of a saturation and a value in 0…1.
#[inline(always)]
pub fn linear_of_hsv_up_to_1(numbers: [f32; 3]) -> LinearRgb {
    linear_of_srgb(srgb_of_hsv(numbers))
}

#[inline(always)]
fn srgb_of_hsv([hue, saturation, value]: [f32; 3]) -> [f32; 3] {
    let sixths = (hue - 360.0 * (hue / 360.0).floor()) / 60.0;
    let (by_red, by_green, by_blue) = ((sixths - 3.0).abs() - 1.0, (sixths - 2.0).abs(), (sixths - 4.0).abs());
    let chroma = value * saturation;
    [
        value - chroma * (1.0 - clamp01(by_red)),
        value - chroma * (1.0 - clamp01(2.0 - by_green)),
        value - chroma * (1.0 - clamp01(2.0 - by_blue)),
    ]
}

/// The root of which the lightness of L*a*b* is made: a straight line for the darkest.
#[inline(always)]
fn lab_root(part: f32) -> f32 {
    let root = cbrt(part);
    select_unpredictable(part > 216.0 / 24_389.0, root, part * (841.0 / 108.0) + 4.0 / 29.0)
}

/// What [`lab_root`] is of.
#[inline(always)]
fn of_lab_root(root: f32) -> f32 {
    select_unpredictable(root > 6.0 / 29.0, root * root * root, (root - 4.0 / 29.0) * (108.0 / 841.0))
}

/// CIE L*a*b* under D65.
#[inline(always)]
pub fn lab_of_linear(colour: LinearRgb) -> [f32; 3] {
    let [x, y, z] = times(&TO_XYZ, colour);
    let (x, y, z) = (lab_root(x), lab_root(y), lab_root(z));
    [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
}

/// The colour of L*a*b*, below 0 where it lies outside Rec.709.
#[inline(always)]
pub fn linear_of_lab([lightness, a, b]: [f32; 3]) -> LinearRgb {
    let y = (lightness + 16.0) * (1.0 / 116.0);
    let (x, z) = (y + a * (1.0 / 500.0), y - b * (1.0 / 200.0));
    times(&OF_XYZ, [of_lab_root(x), of_lab_root(y), of_lab_root(z)])
}

/// Lightness, chroma and hue in degrees, −180…180, of L*a*b*.
#[inline(always)]
pub fn lch_of_linear(colour: LinearRgb) -> [f32; 3] {
    let [lightness, a, b] = lab_of_linear(colour);
    [lightness, (a * a + b * b).sqrt(), atan2(b, a).to_degrees()]
}

/// The colour of lightness, chroma and hue, below 0 where it lies outside Rec.709.
#[inline(always)]
pub fn linear_of_lch([lightness, chroma, hue]: [f32; 3]) -> LinearRgb {
    let angle = hue.to_radians();
    linear_of_lab([lightness, chroma * cos(angle), chroma * sin(angle)])
}

/// Oklab.
#[inline(always)]
pub fn oklab_of_linear(colour: LinearRgb) -> [f32; 3] {
    let [long, medium, short] = times(&TO_CONES, colour);
    times(&TO_OKLAB, [cbrt(long), cbrt(medium), cbrt(short)])
}

/// The colour of Oklab, below 0 where it lies outside Rec.709.
#[inline(always)]
pub fn linear_of_oklab(numbers: [f32; 3]) -> LinearRgb {
    let [long, medium, short] = times(&OF_OKLAB, numbers);
    times(&OF_CONES, [long * long * long, medium * medium * medium, short * short * short])
}

/// Lightness, chroma and hue in degrees, −180…180, of Oklab.
#[inline(always)]
pub fn oklch_of_linear(colour: LinearRgb) -> [f32; 3] {
    let [lightness, a, b] = oklab_of_linear(colour);
    [lightness, (a * a + b * b).sqrt(), atan2(b, a).to_degrees()]
}

/// The part of Oklab of a chroma and a hue in degrees.
#[inline(always)]
pub fn ab_of(chroma: f32, hue: f32) -> [f32; 2] {
    let angle = hue.to_radians();
    [chroma * cos(angle), chroma * sin(angle)]
}

/// The colour of lightness, chroma and hue of Oklab, below 0 where it lies outside Rec.709.
#[inline(always)]
pub fn linear_of_oklch([lightness, chroma, hue]: [f32; 3]) -> LinearRgb {
    let [a, b] = ab_of(chroma, hue);
    linear_of_oklab([lightness, a, b])
}

#[cfg(test)]
mod tests {
    use palette::{FromColor, Hsv, Lab, Lch, LinSrgb, Oklab, Srgb, white_point::D65};

    use super::*;

    /// Colours all over 0…1, dark ones more often, with greys and pure ones.
    fn colours() -> impl Iterator<Item = LinearRgb> {
        let level = |i: usize| (i as f32 / 20.0).powi(3);
        (0..21 * 21 * 21).map(move |i| [level(i % 21), level(i / 21 % 21), level(i / 441)])
    }

    fn exact(colour: LinearRgb) -> LinSrgb<f64> {
        let [red, green, blue] = colour.map(f64::from);
        LinSrgb::new(red, green, blue)
    }

    fn off(ours: [f32; 3], exact: impl Into<[f64; 3]>) -> f64 {
        ours.into_iter().zip(exact.into()).map(|(ours, exact)| (f64::from(ours) - exact).abs()).fold(0.0, f64::max)
    }

    fn turned(degrees: f64) -> f64 {
        (degrees + 180.0).rem_euclid(360.0) - 180.0
    }

    #[test]
    fn srgb_and_hsv_are_near_to_palette_in_f64() {
        let mut worst = [0.0f64; 4];
        for colour in colours() {
            let encoded = Srgb::<f64>::from_linear(exact(colour));
            worst[0] = worst[0].max(off(colour.map(to_srgb), encoded));
            let levels = <[f64; 3]>::from(encoded).map(|level| level as f32);
            let linear = Srgb::from(levels.map(f64::from)).into_linear();
            worst[1] = worst[1].max(off(linear_of_srgb(levels), linear)).max(off(levels.map(of_srgb), linear));
            let hsv = Hsv::from_color(encoded);
            let [hue, saturation, value] = hsv_of_linear(colour);
            // A hue by what it moves the colour.
            let hue_off = turned(f64::from(hue) - hsv.hue.into_degrees()).abs() / 60.0 * hsv.value * hsv.saturation;
            worst[2] = worst[2].max(hue_off).max((f64::from(value) - hsv.value).abs());
            worst[2] = worst[2].max((f64::from(saturation) - hsv.saturation).abs() * hsv.value);
            for numbers in [[hue, saturation, value], [hue + 360.0, saturation, value], [-hue, saturation, value]] {
                let [h, s, v] = numbers.map(f64::from);
                let linear = Srgb::from_color(Hsv::<palette::encoding::Srgb, f64>::new(h, s, v)).into_linear();
                worst[3] = worst[3].max(off(linear_of_hsv(numbers), linear));
                worst[3] = worst[3].max(off(linear_of_hsv_up_to_1(numbers), linear));
            }
        }
        assert!(worst.into_iter().all(|off| off < 2e-6), "{worst:?}");
    }

    /// Also next to nothing, where an error is a large share: by `palette` in `f64`.
    #[test]
    fn srgb_is_right_in_the_dark_and_white_is_white() {
        for i in 0..=100_000u32 {
            let level = i as f32 / 100_000.0;
            let exact = Srgb::new(f64::from(level), 0.0, 0.0).into_linear().red;
            let found = f64::from(of_srgb_up_to_1(level));
            assert!((found - exact).abs() <= 1e-6 * exact, "{level}: {found} {exact}");
        }
        assert_eq!(linear_of_srgb([0.0, 0.0, 1.0]), [0.0, 0.0, 1.0]);
    }

    #[test]
    fn lab_lch_and_oklab_are_near_to_palette_in_f64() {
        let mut there = [0.0f64; 3];
        let mut back = [0.0f64; 3];
        for colour in colours() {
            let linear = exact(colour);
            let lab = Lab::<D65, f64>::from_color(linear);
            let lch = Lch::<D65, f64>::from_color(linear);
            let ours = lch_of_linear(colour);
            there[0] = there[0].max(off(lab_of_linear(colour), lab) / 100.0);
            let hue_off = turned(f64::from(ours[2]) - lch.hue.into_degrees()).to_radians().abs() * lch.chroma;
            there[1] = there[1].max(hue_off / 100.0).max((f64::from(ours[1]) - lch.chroma).abs() / 100.0);
            there[2] = there[2].max(off(oklab_of_linear(colour), Oklab::from_color(linear)));
            back[0] = back[0].max(off(linear_of_lab(lab_of_linear(colour)), linear));
            back[1] = back[1].max(off(linear_of_lch(ours), linear));
            back[2] = back[2].max(off(linear_of_oklab(oklab_of_linear(colour)), linear));
        }
        assert!(there.into_iter().chain(back).all(|off| off < 1e-5), "{there:?} {back:?}");
    }
}
