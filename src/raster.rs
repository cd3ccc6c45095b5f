//! Pictures as numbers: PNG files, the lines where a number passes a level, and heights between pixels.

use std::io::Cursor;

use png::{BitDepth, ColorType, Decoder, Limits, Transformations};

/// Pixels of a picture: more take more than half a gigabyte.
const MOST_PIXELS: u64 = 1 << 26;

/// Edges of a level: a picture with more is noise.
const MOST_EDGES: usize = 4_000_000;

/// What of a picture's pixels counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Channel {
    /// How bright they are, as they are written: 0.2126 red, 0.7152 green, 0.0722 blue.
    Luminance,
    /// How opaque they are.
    Alpha,
    /// Red.
    Red,
    /// Green.
    Green,
    /// Blue.
    Blue,
}

/// A number from 0 to 1 for each pixel.
#[derive(Clone, Debug)]
pub struct Raster {
    width: usize,
    height: usize,
    /// Rows from the bottom to the top.
    values: Vec<f32>,
}

impl Raster {
    /// Rows of numbers from the bottom to the top, all of one length.
    pub fn new(width: usize, values: Vec<f32>) -> Self {
        Self { width, height: values.len() / width, values }
    }

    /// Reads a PNG file.
    ///
    /// # Errors
    /// What is wrong with it, in words.
    pub fn read(content: &[u8], channel: Channel) -> Result<Self, String> {
        let limits = Limits { bytes: 1 << 30 };
        let mut decoder = Decoder::new_with_limits(Cursor::new(content), limits);
        decoder.set_transformations(Transformations::EXPAND);
        let broken = |error: png::DecodingError| format!("it is no PNG picture that can be read: {error}");
        let mut reader = decoder.read_info().map_err(broken)?;
        let (width, height) = (reader.info().width, reader.info().height);
        if u64::from(width) * u64::from(height) > MOST_PIXELS {
            return Err(format!("it has {width} × {height} pixels, and at most {MOST_PIXELS} are read: scale it down"));
        }
        let size = reader.output_buffer_size().ok_or("it is too large")?;
        let mut bytes = vec![0; size];
        let frame = reader.next_frame(&mut bytes).map_err(broken)?;
        let (channels, alpha, has_colour) = match frame.color_type {
            ColorType::Grayscale => (1, None, false),
            ColorType::GrayscaleAlpha => (2, Some(1), false),
            ColorType::Rgb => (3, None, true),
            ColorType::Rgba => (4, Some(3), true),
            ColorType::Indexed => return Err("its palette is missing".into()),
        };
        let wide = frame.bit_depth == BitDepth::Sixteen;
        let number = |row: usize, column: usize, channel: usize| {
            let at = (column * channels + channel) * if wide { 2 } else { 1 } + row * frame.line_size;
            if wide {
                f32::from(u16::from_be_bytes([bytes[at], bytes[at + 1]])) / 65535.0
            } else {
                f32::from(bytes[at]) / 255.0
            }
        };
        if channel == Channel::Alpha && alpha.is_none() {
            return Err("it has no alpha channel".into());
        }
        let (width, height) = (width as usize, height as usize);
        let mut values = Vec::with_capacity(width * height);
        for row in (0..height).rev() {
            for column in 0..width {
                let at = |channel: usize| number(row, column, if has_colour { channel } else { 0 });
                values.push(match channel {
                    Channel::Alpha => number(row, column, alpha.unwrap_or(0)),
                    Channel::Luminance if has_colour => 0.2126 * at(0) + 0.7152 * at(1) + 0.0722 * at(2),
                    Channel::Luminance | Channel::Red => at(0),
                    Channel::Green => at(1),
                    Channel::Blue => at(2),
                });
            }
        }
        Ok(Self { width, height, values })
    }

    /// Pixels from left to right.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Pixels from bottom to top.
    pub fn height(&self) -> usize {
        self.height
    }

    /// The number of a pixel.
    pub fn pixel(&self, x: usize, y: usize) -> f32 {
        self.values[y * self.width + x]
    }

    /// The number of a pixel, of the nearest one where there is none.
    fn at(&self, x: isize, y: isize) -> f64 {
        let x = x.clamp(0, self.width as isize - 1) as usize;
        let y = y.clamp(0, self.height as isize - 1) as usize;
        self.values[y * self.width + x].into()
    }

    /// The closed lines around what is above a level (`above`), or below it, with that on the left of each; in pixels, the
    /// picture's lower left corner at the origin. Between the middles of two pixels a number goes evenly from one to the
    /// other; at the picture's edge all ends.
    ///
    /// # Errors
    /// Where they have too many edges.
    pub fn level(&self, level: f64, above: bool) -> Result<Vec<Vec<[f64; 2]>>, String> {
        let (columns, rows) = (self.width as isize + 2, self.height as isize + 2);
        // How far inside the middle of a pixel is. One ring more around the picture is as far outside as its edge is inside.
        let depth = |x: isize, y: isize| {
            let value = self.at(x - 1, y - 1) - level;
            let value = if above { value } else { -value };
            let is_around = x == 0 || y == 0 || x == columns - 1 || y == rows - 1;
            if is_around { -value.abs() } else { value }
        };
        // A side between two neighbours: its lower left end, twice, and one more where it goes up.
        let side = |x: isize, y: isize, up: bool| 2 * (y * columns + x) as u64 + u64::from(up);
        let mut steps: Vec<(u64, u64)> = Vec::new();
        for y in 0..rows - 1 {
            for x in 0..columns - 1 {
                // Counterclockwise.
                let corners = [depth(x, y), depth(x + 1, y), depth(x + 1, y + 1), depth(x, y + 1)];
                let inside = corners.map(|depth| depth > 0.0);
                if inside == [inside[0]; 4] {
                    continue;
                }
                let sides = [side(x, y, false), side(x + 1, y, true), side(x, y + 1, false), side(x, y, true)];
                let joins = corners.iter().sum::<f64>() > 0.0;
                for from in 0..4 {
                    let leaves = |side: usize| inside[side] && !inside[(side + 1) % 4];
                    let enters = |side: usize| !inside[side] && inside[(side + 1) % 4];
                    if !leaves(from) {
                        continue;
                    }
                    // Of two that cross in the cell, its middle decides which corners are one.
                    let next = (1..4).map(|step| (from + if joins { step } else { 4 - step }) % 4);
                    let to = next.into_iter().find(|side| enters(*side)).unwrap_or(from);
                    steps.push((sides[from], sides[to]));
                }
            }
            if steps.len() > MOST_EDGES {
                return Err(format!("its edge has more than {MOST_EDGES} pieces: smooth it, or scale it down"));
            }
        }
        steps.sort_unstable();
        let place = |side: u64| {
            let (at, up) = ((side / 2) as isize, side % 2 == 1);
            let (x, y) = (at % columns, at / columns);
            let (a, b) = if up { (depth(x, y), depth(x, y + 1)) } else { (depth(x, y), depth(x + 1, y)) };
            let share = a / (a - b);
            // The middle of the first pixel is at ½, and is the second of its row here.
            let (x, y) = (x as f64 - 0.5, y as f64 - 0.5);
            if up { [x, y + share] } else { [x + share, y] }
        };
        let mut used = vec![false; steps.len()];
        let mut loops = Vec::new();
        for first in 0..steps.len() {
            let mut corners: Vec<[f64; 2]> = Vec::new();
            let mut step = first;
            while !used[step] {
                used[step] = true;
                let (from, to) = steps[step];
                corners.push(place(from));
                let Ok(next) = steps.binary_search_by_key(&to, |step| step.0) else { break };
                step = next;
            }
            if corners.len() > 2 {
                loops.push(straightened(corners));
            }
        }
        loops.retain(|corners| corners.len() > 2);
        Ok(loops)
    }

    /// Between the middles of four pixels: the number, and by how much it changes a pixel to the right and upward. The
    /// picture's lower left corner is at the origin; beyond the outermost middles all stays as it is there.
    pub fn between(&self, x: f64, y: f64) -> (f64, [f64; 2]) {
        let cell = |at: f64, count: usize| {
            let at = (at - 0.5).clamp(0.0, count as f64 - 1.0);
            let low = (at as isize).min(count as isize - 2).max(0);
            (low, at - low as f64)
        };
        let ((i, u), (j, v)) = (cell(x, self.width), cell(y, self.height));
        let [a, b, c, d] = [self.at(i, j), self.at(i + 1, j), self.at(i, j + 1), self.at(i + 1, j + 1)];
        let (low, high) = (a + (b - a) * u, c + (d - c) * u);
        let is_within = |at: f64, count: usize| at > 0.5 && at < count as f64 - 0.5;
        let right = if is_within(x, self.width) { (b - a) + ((d - c) - (b - a)) * v } else { 0.0 };
        let up = if is_within(y, self.height) { high - low } else { 0.0 };
        (low + (high - low) * v, [right, up])
    }

    /// The greatest change between pixels next to one another, along x and along y, put together: a bound of the slope of
    /// [`Self::between`].
    pub fn steepest(&self) -> f64 {
        let mut most = [0.0_f64; 2];
        for y in 0..self.height as isize {
            for x in 0..self.width as isize {
                let here = self.at(x, y);
                most[0] = most[0].max((self.at(x + 1, y) - here).abs());
                most[1] = most[1].max((self.at(x, y + 1) - here).abs());
            }
        }
        most[0].hypot(most[1])
    }
}

/// A loop without the corners that lie on straight ways.
fn straightened(corners: Vec<[f64; 2]>) -> Vec<[f64; 2]> {
    /// Of a pixel.
    const SLACK: f64 = 1e-9;
    let count = corners.len();
    let mut kept: Vec<[f64; 2]> = Vec::new();
    for i in 0..count {
        let before = *kept.last().unwrap_or(&corners[count - 1]);
        let (here, after) = (corners[i], corners[(i + 1) % count]);
        let (a, b) = ([here[0] - before[0], here[1] - before[1]], [after[0] - here[0], after[1] - here[1]]);
        let turn = a[0] * b[1] - a[1] * b[0];
        let onward = a[0] * b[0] + a[1] * b[1];
        if turn.abs() > SLACK * (a[0].hypot(a[1]) * b[0].hypot(b[1])) || onward < 0.0 {
            kept.push(here);
        }
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;

    fn area(loops: &[Vec<[f64; 2]>]) -> f64 {
        let of = |corners: &Vec<[f64; 2]>| {
            let pairs = corners.iter().zip(corners.iter().cycle().skip(1));
            pairs.map(|(a, b)| a[0] * b[1] - a[1] * b[0]).sum::<f64>() / 2.0
        };
        loops.iter().map(of).sum()
    }

    fn png(width: u32, pixels: &[u8], kind: ColorType) -> Vec<u8> {
        let channels = kind.samples();
        let mut out = Vec::new();
        let mut encoder = png::Encoder::new(&mut out, width, (pixels.len() / channels) as u32 / width);
        encoder.set_color(kind);
        encoder.write_header().unwrap().write_image_data(pixels).unwrap();
        out
    }

    #[test]
    fn levels_are_between_pixels() {
        // A disc whose edge goes over three pixels.
        let size = 60;
        let disc: Vec<f32> = (0..size * size)
            .map(|i| {
                let (x, y) = ((i % size) as f32 + 0.5 - 30.0, (i / size) as f32 + 0.5 - 30.0);
                (0.5 + (20.0 - x.hypot(y)) / 3.0).clamp(0.0, 1.0)
            })
            .collect();
        let raster = Raster::new(size, disc);
        let loops = raster.level(0.5, true).unwrap();
        assert_eq!(loops.len(), 1);
        for [x, y] in &loops[0] {
            assert!(((x - 30.0).hypot(y - 30.0) - 20.0).abs() < 0.02, "{x} {y}");
        }
        // What is below it has the same edge, and the picture's.
        let outside = raster.level(0.5, false).unwrap();
        assert!((area(&outside) + area(&loops) - 3600.0).abs() < 2.0, "{} {}", area(&outside), area(&loops));
        // All of it ends at the picture's edge, half a pixel beyond the outermost middles.
        let all = raster.level(-1.0, true).unwrap();
        assert!((area(&all) - 3600.0).abs() < 1.0);
        assert!(all[0].len() < 10, "{}", all[0].len());
        assert!(raster.level(2.0, true).unwrap().is_empty());
    }

    /// Every other pixel: corners that touch are never lost, and no line is left open.
    #[test]
    fn a_board_of_pixels() {
        for (bright, joined) in [(0.9, true), (0.6, false)] {
            let board = (0..64).map(|i| if (i % 8 + i / 8) % 2 == 0 { bright } else { 0.0 }).collect();
            let loops = Raster::new(8, board).level(0.4, true).unwrap();
            assert_eq!(loops.len() == 32, !joined, "{} loops of {bright}", loops.len());
        }
    }

    #[test]
    fn pixels_are_read_as_they_are_written() {
        let grey = Raster::read(&png(2, &[0, 255, 51, 102], ColorType::Grayscale), Channel::Luminance).unwrap();
        assert_eq!(grey.values, [0.2, 0.4, 0.0, 1.0]);
        let file = png(1, &[255, 0, 0, 51], ColorType::Rgba);
        assert_eq!(Raster::read(&file, Channel::Alpha).unwrap().values, [0.2]);
        assert_eq!(Raster::read(&file, Channel::Red).unwrap().values, [1.0]);
        assert_eq!(Raster::read(&file, Channel::Luminance).unwrap().values, [0.2126]);
        assert!(Raster::read(&png(1, &[1], ColorType::Grayscale), Channel::Alpha).unwrap_err().contains("no alpha"));
    }

    #[test]
    fn broken_pictures_are_told() {
        let file = png(40, &[7; 1600 * 3], ColorType::Rgb);
        assert!(Raster::read(&[], Channel::Red).is_err() && Raster::read(b"no picture", Channel::Red).is_err());
        for end in 0..file.len() - 12 {
            assert!(Raster::read(&file[..end], Channel::Red).is_err(), "{end}");
        }
        for at in 8..file.len() {
            let mut garbled = file.clone();
            garbled[at] ^= 0x5a;
            let _ = Raster::read(&garbled, Channel::Red);
        }
        // A header of more pixels than there can be.
        let mut huge = file;
        huge[16..24].copy_from_slice(&[0x7f, 0xff, 0xff, 0xff, 0x7f, 0xff, 0xff, 0xff]);
        assert!(Raster::read(&huge, Channel::Red).is_err());
    }

    #[test]
    fn heights_go_evenly_between_pixels() {
        let raster = Raster::new(2, vec![0.0, 1.0, 0.5, 0.5]);
        assert_eq!(raster.between(0.5, 0.5).0, 0.0);
        assert_eq!(raster.between(1.0, 0.5), (0.5, [1.0, 0.0]));
        assert_eq!(raster.between(1.0, 1.0), (0.5, [0.5, 0.0]));
        assert_eq!(raster.between(-7.0, 9.0), (0.5, [0.0, 0.0]));
        assert!(raster.steepest() >= 1.0);
    }
}
