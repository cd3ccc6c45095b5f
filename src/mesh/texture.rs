//! Pictures on meshes: decoded once, made smaller by halves, and sampled in scene-linear light.

use std::io::Cursor;
use std::sync::LazyLock;

use image::{ColorType, DynamicImage, ImageFormat, ImageReader, Limits};

use super::read::Encoding;

/// The longest side of a picture that is read, in pixels.
const LONGEST_SIDE: u32 = 32_768;
/// Memory that decoding a picture may take, in bytes.
const MOST_BYTES: u64 = 2 << 30;

/// A picture. Its rows go from the top; places in it from 0 to 1, to the right and down.
#[derive(Debug)]
pub struct Texture {
    width: usize,
    height: usize,
    texels: Texels,
    /// Each half as wide and as high as the one before, rounded up; the first half of the picture itself.
    smaller: Vec<Smaller>,
}

#[derive(Debug)]
enum Texels {
    /// sRGB, eight bits a channel.
    Bytes(Vec<[u8; 3]>),
    /// Numbers from 0 to 1, eight bits each.
    Plain(Vec<[u8; 3]>),
    /// Scene-linear, or numbers.
    Floats(Vec<[f32; 3]>),
}

#[derive(Debug)]
struct Smaller {
    width: usize,
    height: usize,
    texels: Vec<[f32; 3]>,
}

/// What a picture shows beyond its borders, along one side.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Wrap {
    /// Itself again.
    #[default]
    Repeat,
    /// Itself mirrored, in turns.
    Mirror,
    /// Its border.
    Clamp,
}

/// How a picture is looked up.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Lookup {
    /// Averaged over as much of it as a voxel covers.
    #[default]
    Filtered,
    /// The one pixel there.
    Nearest,
    /// The colour that most pixels have of those that a voxel covers.
    Majority,
}

/// What the channels of a picture are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Meaning {
    /// Colours: sRGB, of EXR scene-linear.
    Colours,
    /// Numbers, as they stand.
    Numbers,
}

/// sRGB bytes as scene-linear numbers.
static LINEAR: LazyLock<[f32; 256]> = LazyLock::new(|| {
    let of = |byte: usize| Encoding::Srgb.decode([byte as f64 / 255.0; 3]).map_or(0.0, |colour| colour[0]);
    std::array::from_fn(of)
});

impl Texture {
    /// Decodes a PNG, JPEG or EXR. Of 16 bits a channel all count; alpha does not.
    ///
    /// # Errors
    /// What is wrong with it, in words.
    pub fn decode(bytes: &[u8], meaning: Meaning) -> Result<Self, String> {
        if super::exr_picture::is_one(bytes) {
            let (width, height, texels) = super::exr_picture::decode(bytes, LONGEST_SIDE as usize, MOST_BYTES)?;
            return Ok(Self::new(width, height, Texels::Floats(texels)));
        }
        let mut reader =
            ImageReader::new(Cursor::new(bytes)).with_guessed_format().map_err(|error| error.to_string())?;
        match reader.format() {
            Some(ImageFormat::Png | ImageFormat::Jpeg) => {}
            Some(other) => return Err(format!("it is {}, and PNG, JPEG and EXR are read", words(other))),
            None => return Err("it is neither a PNG nor a JPEG nor an EXR".into()),
        }
        let mut limits = Limits::default();
        (limits.max_image_width, limits.max_image_height) = (Some(LONGEST_SIDE), Some(LONGEST_SIDE));
        limits.max_alloc = Some(MOST_BYTES);
        reader.limits(limits);
        let picture = reader.decode().map_err(|error| error.to_string())?;
        let (width, height) = (picture.width() as usize, picture.height() as usize);
        if width == 0 || height == 0 {
            return Err("it has no pixels".into());
        }
        Ok(Self::new(width, height, texels(picture, meaning)))
    }

    fn new(width: usize, height: usize, texels: Texels) -> Self {
        let mut texture = Self { width, height, texels, smaller: Vec::new() };
        loop {
            let (width, height) = texture.size(texture.smaller.len());
            if width == 1 && height == 1 {
                return texture;
            }
            let half = texture.halved(texture.smaller.len());
            texture.smaller.push(half);
        }
    }

    /// Width and height, in pixels.
    pub fn pixels(&self) -> [usize; 2] {
        [self.width, self.height]
    }

    /// Memory that it takes, in bytes.
    pub fn bytes(&self) -> u64 {
        let own = match &self.texels {
            Texels::Bytes(texels) | Texels::Plain(texels) => texels.len() * 3,
            Texels::Floats(texels) => texels.len() * 12,
        };
        (own + self.smaller.iter().map(|smaller| smaller.texels.len() * 12).sum::<usize>()) as u64
    }

    fn size(&self, level: usize) -> (usize, usize) {
        match level {
            0 => (self.width, self.height),
            _ => (self.smaller[level - 1].width, self.smaller[level - 1].height),
        }
    }

    fn texel(&self, level: usize, x: usize, y: usize) -> [f32; 3] {
        match (level, &self.texels) {
            (0, Texels::Bytes(texels)) => texels[y * self.width + x].map(|byte| LINEAR[usize::from(byte)]),
            (0, Texels::Plain(texels)) => texels[y * self.width + x].map(|byte| f32::from(byte) / 255.0),
            (0, Texels::Floats(texels)) => texels[y * self.width + x],
            _ => {
                let smaller = &self.smaller[level - 1];
                smaller.texels[y * smaller.width + x]
            }
        }
    }

    /// The next level: means of two by two, at an odd border of what is there.
    fn halved(&self, level: usize) -> Smaller {
        let (wide, high) = self.size(level);
        let (width, height) = (wide.div_ceil(2), high.div_ceil(2));
        let mut texels = Vec::with_capacity(width * height);
        for y in 0..height {
            for x in 0..width {
                let (right, below) = ((2 * x + 1).min(wide - 1), (2 * y + 1).min(high - 1));
                let four = [(2 * x, 2 * y), (right, 2 * y), (2 * x, below), (right, below)];
                let four = four.map(|(x, y)| self.texel(level, x, y));
                texels.push(std::array::from_fn(|i| four.iter().map(|texel| texel[i]).sum::<f32>() / 4.0));
            }
        }
        Smaller { width, height, texels }
    }

    /// The scene-linear colour at a place, averaged over about so many pixels across.
    pub fn sample(&self, place: [f32; 2], wrap: [Wrap; 2], lookup: Lookup, across: f32) -> [f32; 3] {
        /// From here on places have no fraction that could tell pixels apart, and files that have them are damaged.
        const FARTHEST: f32 = 1e7;
        let [u, v] = place.map(|along| if along.abs() < FARTHEST { along } else { 0.0 });
        if lookup == Lookup::Nearest {
            let x = wrapped((f64::from(u) * self.width as f64).floor() as i64, self.width, wrap[0]);
            let y = wrapped((f64::from(v) * self.height as f64).floor() as i64, self.height, wrap[1]);
            return self.texel(0, x, y);
        }
        if lookup == Lookup::Majority {
            return self.majority([u, v], wrap, across);
        }
        let level = across.max(1.0).log2().min(self.smaller.len() as f32);
        let (fine, share) = (level as usize, level.fract());
        let one = self.between(fine, [u, v], wrap);
        if share == 0.0 {
            return one;
        }
        let other = self.between(fine + 1, [u, v], wrap);
        std::array::from_fn(|i| one[i] + share * (other[i] - one[i]))
    }

    /// The colour of most pixels in a square so many pixels wide; of several that are as many, that of the pixel nearest to
    /// the middle.
    fn majority(&self, [u, v]: [f32; 2], wrap: [Wrap; 2], across: f32) -> [f32; 3] {
        /// Pixels looked at along a side; of more, so many evenly. Fewer: thin lines win or lose by chance; more: time.
        const MOST: usize = 16;
        let (x, y) = (f64::from(u) * self.width as f64, f64::from(v) * self.height as f64);
        let across = f64::from(across).clamp(1.0, self.width.max(self.height) as f64);
        let count = (across.round() as usize).clamp(1, MOST);
        let offset = |i: usize| ((i as f64 + 0.5) / count as f64 - 0.5) * across;
        let mut found: Vec<([u32; 3], f64)> = Vec::with_capacity(count * count);
        for (i, j) in (0..count).flat_map(|i| (0..count).map(move |j| (i, j))) {
            let (left, top) = ((x + offset(i)).floor(), (y + offset(j)).floor());
            let (dx, dy) = (left + 0.5 - x, top + 0.5 - y);
            let at = [(left as i64, self.width, wrap[0]), (top as i64, self.height, wrap[1])];
            let [column, row] = at.map(|(at, count, wrap)| wrapped(at, count, wrap));
            found.push((self.texel(0, column, row).map(f32::to_bits), dx * dx + dy * dy));
        }
        // Those of one colour together, the nearest first.
        found.sort_unstable_by(|(a, near), (b, far)| a.cmp(b).then_with(|| near.total_cmp(far)));
        let best = found.chunk_by(|(a, _), (b, _)| a == b).max_by(|one, other| {
            one.len()
                .cmp(&other.len())
                .then_with(|| other[0].1.total_cmp(&one[0].1))
                .then_with(|| other[0].0.cmp(&one[0].0))
        });
        best.map_or([0.0; 3], |same| same[0].0.map(f32::from_bits))
    }

    /// Between the four nearest pixels of a level.
    fn between(&self, level: usize, [u, v]: [f32; 2], wrap: [Wrap; 2]) -> [f32; 3] {
        let (width, height) = self.size(level);
        let (x, y) = (f64::from(u) * width as f64 - 0.5, f64::from(v) * height as f64 - 0.5);
        let (left, top) = (x.floor(), y.floor());
        let (a, b) = ((x - left) as f32, (y - top) as f32);
        let at = |i: i64, j: i64| {
            let (x, y) = (left as i64 + i, top as i64 + j);
            self.texel(level, wrapped(x, width, wrap[0]), wrapped(y, height, wrap[1]))
        };
        let (one, two, three, four) = (at(0, 0), at(1, 0), at(0, 1), at(1, 1));
        std::array::from_fn(|i| {
            let upper = one[i] + a * (two[i] - one[i]);
            let lower = three[i] + a * (four[i] - three[i]);
            upper + b * (lower - upper)
        })
    }
}

/// The pixel that stands for one beyond the border.
fn wrapped(at: i64, count: usize, wrap: Wrap) -> usize {
    let count = count as i64;
    let found = match wrap {
        Wrap::Repeat => at.rem_euclid(count),
        Wrap::Clamp => at.clamp(0, count - 1),
        Wrap::Mirror => {
            let at = at.rem_euclid(2 * count);
            if at < count { at } else { 2 * count - 1 - at }
        }
    };
    found as usize
}

fn texels(picture: DynamicImage, meaning: Meaning) -> Texels {
    let deep = matches!(picture.color(), ColorType::L16 | ColorType::La16 | ColorType::Rgb16 | ColorType::Rgba16);
    if deep {
        let all = picture.into_rgb16();
        let linear = |pixel: &image::Rgb<u16>| {
            let encoded = pixel.0.map(|channel| f64::from(channel) / 65535.0);
            match meaning {
                Meaning::Colours => Encoding::Srgb.decode(encoded).unwrap_or_default(),
                Meaning::Numbers => encoded.map(|channel| channel as f32),
            }
        };
        return Texels::Floats(all.pixels().map(linear).collect());
    }
    let bytes = picture.into_rgb8().into_raw().as_chunks().0.to_vec();
    match meaning {
        Meaning::Colours => Texels::Bytes(bytes),
        Meaning::Numbers => Texels::Plain(bytes),
    }
}

fn words(format: ImageFormat) -> &'static str {
    match format {
        ImageFormat::WebP => "a WebP",
        ImageFormat::Tiff => "a TIFF",
        ImageFormat::Tga => "a TGA",
        ImageFormat::Bmp => "a BMP",
        ImageFormat::Gif => "a GIF",
        ImageFormat::Hdr => "an HDR",
        _ => "a picture of another kind",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Bytes of a PNG of grey values.
    fn png(width: u32, height: u32, grey: impl Fn(u32, u32) -> u8) -> Vec<u8> {
        let picture = image::GrayImage::from_fn(width, height, |x, y| image::Luma([grey(x, y)]));
        let mut out = Cursor::new(Vec::new());
        picture.write_to(&mut out, ImageFormat::Png).unwrap();
        out.into_inner()
    }

    #[test]
    fn pixels_come_back_linear_and_wrapped() {
        let texture = Texture::decode(&png(4, 2, |x, y| (x * 60 + y * 15) as u8), Meaning::Colours).unwrap();
        assert_eq!(texture.pixels(), [4, 2]);
        let linear = |byte: f64| Encoding::Srgb.decode([byte / 255.0; 3]).unwrap()[0];
        let middle = |x: i32, y: i32| [(x as f32 + 0.5) / 4.0, (y as f32 + 0.5) / 2.0];
        for (wrap, at, byte) in [
            (Wrap::Repeat, [-1, 2], 180.0),
            (Wrap::Clamp, [-1, 2], 15.0),
            (Wrap::Mirror, [-2, 2], 75.0),
            (Wrap::Repeat, [3, 1], 195.0),
        ] {
            for lookup in [Lookup::Nearest, Lookup::Filtered] {
                let found = texture.sample(middle(at[0], at[1]), [wrap; 2], lookup, 1.0);
                assert!((found[0] - linear(byte)).abs() < 1e-6, "{wrap:?} {lookup:?}: {found:?}");
            }
        }
    }

    /// Light is averaged, not its encoding: black and white in turns are half as bright, which is 188 of 255.
    #[test]
    fn what_a_voxel_covers_is_averaged() {
        let texture =
            Texture::decode(&png(64, 64, |x, y| if (x + y) % 2 == 0 { 255 } else { 0 }), Meaning::Colours).unwrap();
        for across in [2.0, 3.7, 16.0, 1000.0] {
            let found = texture.sample([0.3, 0.6], [Wrap::Repeat; 2], Lookup::Filtered, across);
            assert!((found[1] - 0.5).abs() < 1e-6, "{across}: {found:?}");
        }
        assert_eq!(texture.sample([0.0; 2], [Wrap::Repeat; 2], Lookup::Nearest, 16.0), [1.0; 3]);
    }

    /// Three of four pixels are white: a mean is no colour of the picture, the majority is.
    #[test]
    fn most_of_what_a_voxel_covers() {
        let texture =
            Texture::decode(&png(64, 64, |x, y| if x % 2 == 1 && y % 2 == 1 { 0 } else { 255 }), Meaning::Colours)
                .unwrap();
        let at = |place: [f32; 2], across: f32| texture.sample(place, [Wrap::Repeat; 2], Lookup::Majority, across)[0];
        for across in [3.0, 4.0, 9.0, 16.0, 100.0] {
            assert_eq!(at([0.3, 0.6], across), 1.0, "{across}");
        }
        // No wider than a pixel: the one that is there.
        assert_eq!((at([1.5 / 64.0; 2], 0.5), at([0.5 / 64.0; 2], 1.0)), (0.0, 1.0));
        // As many of either: the one in the middle.
        let halves = Texture::decode(&png(4, 4, |x, _| if x < 2 { 0 } else { 255 }), Meaning::Colours).unwrap();
        let at = |u: f32| halves.sample([u, 0.5], [Wrap::Clamp; 2], Lookup::Majority, 2.0)[0];
        assert_eq!((at(0.49), at(0.51)), (0.0, 1.0));
    }

    /// Roughness of 128 is a half, whatever sRGB makes of it.
    #[test]
    fn numbers_stand_as_they_are() {
        let texture = Texture::decode(&png(2, 2, |x, _| if x == 0 { 128 } else { 0 }), Meaning::Numbers).unwrap();
        let at = |u: f32, across: f32| texture.sample([u, 0.5], [Wrap::Clamp; 2], Lookup::Filtered, across)[1];
        assert_eq!((at(0.25, 1.0), at(0.5, 2.0)), (128.0 / 255.0, 64.0 / 255.0));
    }

    #[test]
    fn what_is_no_picture_is_refused() {
        assert!(Texture::decode(b"RIFF\x10\0\0\0WEBPVP8 ", Meaning::Colours).unwrap_err().contains("a WebP"));
        assert!(Texture::decode(b"nothing", Meaning::Colours).unwrap_err().contains("neither"));
        let whole = png(32, 32, |x, y| (x * y) as u8);
        for end in [9, whole.len() / 2, whole.len() - 13] {
            assert!(Texture::decode(&whole[..end], Meaning::Colours).is_err(), "{end}");
        }
    }
}
