//! A slice through an object: the colour of its inside in a plane across one axis, under the lines of equal distance.

use std::{fmt, str::FromStr};

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::{
    image::{Image, decode_srgb, encode_srgb},
    plot::rounded_up,
    text::{self, Align, LINE, Style},
    volume::Volume,
};
use crate::{
    attribute::{Colour, LUMINANCE},
    field::{Aabb, BATCH, Points},
    grid::Band,
};

pub(super) const PAPER: [u8; 3] = [206, 209, 214];
const INK: [u8; 3] = [26, 30, 38];
const CHALK: [u8; 3] = [255; 3];
/// Colours darker than this (linear luminance) have light lines.
const DARK: f32 = 0.18;
/// The inside's colour where nothing is known of it: that of sRGB `#cccccc`, lighter than the paper is dark.
pub(super) const CLAY: [f32; 3] = [0.604; 3];
/// Room around the object's box, as a share of its larger side: outside, too, there are lines to see.
const MARGIN: f64 = 0.12;
/// Samples of a pixel each way.
pub(super) const SAMPLES: usize = 2;
/// Half the thickness of the surface's line and of the others, in pixels.
const HALF_LINES: [f64; 2] = [1.1, 0.5];
/// How strongly lines are drawn, other than the surface's.
const FAINT: f32 = 0.45;
/// The least room between two lines, in pixels, and the most lines on one side of the surface.
const LEAST_APART: f64 = 7.0;
const MOST_LINES: f64 = 10.0;
/// Pictures smaller than this have no caption.
pub(super) const LEAST_CAPTIONED: usize = 320;

/// A plane across one axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plane {
    /// 0, 1, 2 for x, y, z.
    axis: usize,
    /// Where it stands on that axis, world units.
    at: f64,
}

impl Plane {
    /// Whether it goes through a box.
    pub fn meets(&self, bounds: &Aabb) -> bool {
        (bounds.min[self.axis]..=bounds.max[self.axis]).contains(&self.at)
    }

    /// Its axis: `x`, `y` or `z`.
    pub fn axis(&self) -> char {
        ['x', 'y', 'z'][self.axis]
    }

    /// The part of its axis that a box takes.
    pub fn span(&self, bounds: &Aabb) -> [f64; 2] {
        [bounds.min[self.axis], bounds.max[self.axis]]
    }

    /// The axes to the picture's right and to its top: x and y seen from above, x and z from the front, y and z from
    /// the right.
    fn axes(self) -> (usize, usize) {
        [(1, 2), (0, 2), (0, 1)][self.axis]
    }
}

impl FromStr for Plane {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let wrong = || format!("\"{text}\" is no plane: write one such as z=0 or x=-1.5");
        let (axis, at) = text.split_once('=').ok_or_else(wrong)?;
        let axis = ["x", "y", "z"].iter().position(|name| *name == axis.trim()).ok_or_else(wrong)?;
        let at = at.trim().parse::<f64>().ok().filter(|at| at.is_finite()).ok_or_else(wrong)?;
        Ok(Self { axis, at })
    }
}

impl fmt::Display for Plane {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} = {}", self.axis(), self.at)
    }
}

/// Where the inside's colour comes from. Scene-linear Rec.709.
#[derive(Clone, Copy)]
pub enum Fill<'a> {
    /// There is none.
    None,
    /// It is known everywhere.
    Everywhere(&'a Colour),
    /// It is known at some world positions.
    Somewhere(&'a (dyn Fn(DVec3) -> Option<[f32; 3]> + Sync)),
}

/// What a slice shows, and how. One frame of a sequence after the other with the same slice gives pictures of one scale.
#[derive(Clone, Copy, Debug)]
pub struct Slice {
    /// The plane.
    pub plane: Plane,
    /// The box that the picture shows; nothing is drawn to its edge.
    pub bounds: Aabb,
    /// Pixels of the picture, each way.
    pub size: usize,
    /// The distance, world units, from one line to the next.
    pub spacing: f64,
}

impl Slice {
    /// A slice whose lines are as far apart as can be told apart, by a round distance; `reach` is how far from the
    /// surface distances are known, world units.
    pub fn new(plane: Plane, bounds: Aabb, size: usize, reach: f64) -> Self {
        let mut slice = Self { plane, bounds, size, spacing: 1.0 };
        slice.spacing = rounded_up((reach / MOST_LINES).max(LEAST_APART * slice.pixel()), false);
        slice
    }

    /// The edge of a pixel, world units.
    fn pixel(&self) -> f64 {
        let (right, up) = self.plane.axes();
        let size = self.bounds.size();
        let longest = size[right].max(size[up]);
        let longest = if longest.is_finite() && longest > 0.0 { longest } else { 1.0 };
        longest * (1.0 + 2.0 * MARGIN) / self.size.max(1) as f64
    }

    /// The world position of a place in the picture, in pixels from its top left.
    pub(super) fn world(&self, place: DVec2) -> DVec3 {
        let (right, up) = self.plane.axes();
        let mut position = (self.bounds.min + self.bounds.max) * 0.5;
        position[self.plane.axis] = self.plane.at;
        position[right] += (place.x - self.size as f64 * 0.5) * self.pixel();
        position[up] -= (place.y - self.size as f64 * 0.5) * self.pixel();
        position
    }

    /// What the lines mean, in words.
    pub fn caption(&self) -> String {
        format!("{}, a line every {}", self.plane, self.spacing as f32)
    }

    /// Draws it. Lines are drawn where distances are known: nearer to the surface than the band's end, less 1.8 voxels.
    pub fn draw(&self, band: &Band, fill: Fill<'_>) -> Image {
        let volume = Volume::new(band);
        let [red, green, blue] = PAPER;
        let mut image = Image::new(self.size, self.size, [red, green, blue, 255]);
        // Interpolation near the band's end reads distances that are cut there: as far as a cell's diagonal.
        let known = f64::from(band.background()) - 3f64.sqrt() * volume.voxel_size();
        let rows = image.pixels_mut().par_chunks_mut(self.size.max(1)).enumerate();
        rows.for_each(|(row, pixels)| {
            let cells = self.row(&volume, known, fill, row);
            for (pixel, cell) in pixels.iter_mut().zip(cells) {
                *pixel = cell;
            }
        });
        if self.size >= LEAST_CAPTIONED {
            sign(&mut image, &self.caption());
        }
        image
    }

    /// The places of the samples of a row, pixel by pixel.
    pub(super) fn places(&self, row: usize) -> impl Iterator<Item = DVec2> {
        let within = |sample: usize| (sample as f64 + 0.5) / SAMPLES as f64;
        (0..self.size).flat_map(move |column| {
            let place = move |sample: usize| {
                DVec2::new(column as f64 + within(sample % SAMPLES), row as f64 + within(sample / SAMPLES))
            };
            (0..SAMPLES * SAMPLES).map(place)
        })
    }

    /// One row of pixels.
    fn row(&self, volume: &Volume<'_>, known: f64, fill: Fill<'_>, row: usize) -> Vec<[u8; 4]> {
        let positions: Vec<DVec3> = self.places(row).map(|place| self.world(place)).collect();
        let distances: Vec<f64> =
            positions.iter().map(|&position| volume.distance(position / volume.voxel_size())).collect();
        let inside: Vec<DVec3> =
            positions.iter().zip(&distances).filter(|(_, distance)| **distance >= 0.0).map(|(at, _)| *at).collect();
        let mut colours = colours(fill, &inside).into_iter();
        let paper = PAPER.map(decode_srgb);
        let pixel = |samples: &[f64]| {
            let mut sum = [0.0; 3];
            for distance in samples {
                let colour = if *distance >= 0.0 { colours.next().unwrap_or(CLAY) } else { paper };
                for (sum, channel) in sum.iter_mut().zip(colour) {
                    *sum += channel / samples.len() as f32;
                }
            }
            self.with_lines(sum, samples, known)
        };
        distances.chunks_exact(SAMPLES * SAMPLES).map(pixel).collect()
    }

    /// A pixel of a linear colour, with what lines there are in it; `known` is the greatest distance that has one.
    pub(super) fn with_lines(&self, colour: [f32; 3], samples: &[f64], known: f64) -> [u8; 4] {
        let distance = samples.iter().sum::<f64>() / samples.len() as f64;
        let mut pixel = colour.map(encode_srgb);
        // How much the distance changes across a pixel; where it hardly does, a line would be a stain.
        let [a, b, c, d] = [samples[0], samples[1], samples[2], samples[3]];
        let rise = DVec2::new(b + d - a - c, c + d - a - b).length();
        let (slope, is_level) = (rise.max(0.1 * self.pixel()), rise < 0.01 * self.pixel());
        let nearest = (distance / self.spacing).round();
        let known = samples.iter().all(|sample| sample.abs() < known);
        let off = (distance - nearest * self.spacing).abs() / slope;
        let weight = |half: f64| (half + 0.5 - off).clamp(0.0, 1.0) as f32;
        let [red, green, blue] = LUMINANCE.map(|share| share as f32);
        let luminance = red * colour[0] + green * colour[1] + blue * colour[2];
        let (line, weight) = match (known, nearest == 0.0) {
            (false, _) => (INK, 0.0),
            (true, false) if is_level => (INK, 0.0),
            (true, true) => (INK, weight(HALF_LINES[0])),
            (true, false) if luminance < DARK => (CHALK, weight(HALF_LINES[1]) * FAINT),
            (true, false) => (INK, weight(HALF_LINES[1]) * FAINT),
        };
        for (below, above) in pixel.iter_mut().zip(line) {
            *below = (f32::from(*below) + (f32::from(above) - f32::from(*below)) * weight + 0.5) as u8;
        }
        [pixel[0], pixel[1], pixel[2], 255]
    }
}

/// Writes a caption at a picture's lower edge.
pub(super) fn sign(image: &mut Image, caption: &str) {
    let row = image.height() - LINE - 8;
    text::draw(image, 8, row as i64, caption, Style::Plain, Align::Left, INK);
}

/// The colours at some world positions.
pub(super) fn colours(fill: Fill<'_>, positions: &[DVec3]) -> Vec<[f32; 3]> {
    match fill {
        Fill::None => vec![CLAY; positions.len()],
        Fill::Somewhere(known) => positions.iter().map(|&position| known(position).unwrap_or(CLAY)).collect(),
        Fill::Everywhere(colour) => {
            let mut sampler = colour.sampler();
            let mut out = [[0.0; 3]; BATCH];
            let mut all = Vec::with_capacity(positions.len());
            for chunk in positions.chunks(BATCH) {
                let points = Points::of_positions(chunk);
                sampler.sample(&points, &mut out);
                all.extend_from_slice(&out[..chunk.len()]);
            }
            all
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{attribute::Constant, grid::testing::sphere};

    const RED: [f32; 3] = [0.6, 0.05, 0.1];

    fn plane(text: &str) -> Plane {
        text.parse().unwrap()
    }

    fn slice(plane: Plane, size: usize) -> Slice {
        Slice::new(plane, Aabb::new(DVec3::NEG_ONE, DVec3::ONE), size, 0.5)
    }

    #[test]
    fn planes_are_read() {
        assert_eq!(plane("z=0"), Plane { axis: 2, at: 0.0 });
        assert_eq!(plane(" x = -1.5"), Plane { axis: 0, at: -1.5 });
        for wrong in ["z", "w=1", "z=", "z=inf", "z=nan", "0=z", "z=1=2"] {
            assert!(wrong.parse::<Plane>().unwrap_err().contains("such as z=0"), "{wrong}");
        }
        let bounds = Aabb::new(DVec3::NEG_ONE, DVec3::ONE);
        assert!(plane("y=1").meets(&bounds) && !plane("y=1.01").meets(&bounds));
    }

    /// The inside of a ball of radius 1 in a plane at 0.6 is a disc of radius 0.8, in its colour.
    #[test]
    fn the_inside_has_its_area_and_its_colour() {
        let band = sphere(DVec3::ZERO, 1.0, 0.05);
        let red = Constant::new(RED);
        for text in ["x=0.6", "y=-0.6", "z=0.6"] {
            let slice = slice(plane(text), 200);
            let image = slice.draw(&band, Fill::Everywhere(&red));
            let [r, g, b] = PAPER;
            let is_paper = |pixel: &&[u8; 4]| pixel[0].abs_diff(r) + pixel[1].abs_diff(g) + pixel[2].abs_diff(b) < 3;
            assert_eq!(image.pixel(100, 100)[..3], RED.map(encode_srgb), "{text}");
            // Beyond the band there are no lines, and the corners are paper.
            assert!(is_paper(&&image.pixel(1, 1)));
            let inked = |pixel: &&[u8; 4]| pixel[0] < 120 && pixel[1] < 120;
            let line = image.pixels().iter().filter(inked).count() as f64;
            // Its line is as long as the disc's edge, and 2.2 pixels thick where the slope in the plane is 1; it is
            // 0.8 there.
            let exact = std::f64::consts::TAU * 0.8 / slice.pixel() * 2.0 * HALF_LINES[0];
            assert!((line / exact - 1.0).abs() < 0.35, "{text}: {line} pixels for {exact}");
        }
    }

    /// Along the middle row every line is where its distance says.
    #[test]
    fn lines_are_at_their_distances() {
        let band = sphere(DVec3::ZERO, 1.0, 0.02);
        let mut slice = slice(plane("z=0"), 1000);
        slice.spacing = 0.01;
        let image = slice.draw(&band, Fill::None);
        let at = |x: f64| {
            let column = 500.0 + x / slice.pixel();
            image.pixel(column as usize, 500)[0]
        };
        for step in -2..=2 {
            let x = 1.0 + f64::from(step) * 0.01;
            let between = at(x + 0.005);
            assert!(at(x) + 20 < between, "no line at {x}: {} and {between}", at(x));
        }
        assert_eq!(at(0.5), encode_srgb(CLAY[0]), "no lines beyond the band");
    }

    /// In the middle of a plate the distance is half its height wherever its rim is farther away.
    #[test]
    fn what_is_level_on_a_line_is_not_painted_with_it() {
        let slice = Slice { spacing: 0.1, ..slice(plane("z=0"), 200) };
        let drawn = |samples: [f64; 4]| slice.with_lines(CLAY, &samples, 1.0)[..3] != CLAY.map(encode_srgb);
        let step = 0.5 * slice.pixel();
        assert!(drawn([0.1, 0.1 + step, 0.1, 0.1 + step]) && drawn([0.0; 4]));
        assert!(!drawn([0.1, 0.1 + 1e-8, 0.1, 0.1 - 1e-8]));
    }

    #[test]
    fn spacing_is_round_and_wide_enough() {
        for reach in [1e-9, 0.037, 5.0, 1e6] {
            let slice = Slice::new(plane("z=0"), Aabb::new(DVec3::NEG_ONE, DVec3::ONE), 400, reach);
            assert!(slice.spacing >= LEAST_APART * slice.pixel() && slice.spacing >= reach / MOST_LINES);
        }
        let empty = Aabb::new(DVec3::ONE, DVec3::ONE);
        assert!(Slice::new(plane("z=0"), empty, 0, f64::NAN).pixel().is_finite());
    }
}
