//! Pictures of EXR files: scene-linear Rec.709, the first layer with colours.

use std::io::Cursor;

use exr::meta::MetaData;
use exr::meta::attribute::Chromaticities;
use exr::prelude::{ReadChannels, ReadLayers, read};

/// What EXR files begin with.
const MAGIC: [u8; 4] = [0x76, 0x2f, 0x31, 0x01];
/// Rec.709's red, green, blue and white, and how far files write them by rounding.
const REC709: [[f32; 2]; 4] = [[0.64, 0.33], [0.3, 0.6], [0.15, 0.06], [0.3127, 0.329]];
const ROUNDING: f32 = 2e-3;
/// As bright as 16 bits hold: sums of four brighter ones may be without end.
const BRIGHTEST: f32 = 65504.0;

/// Whether bytes are those of an EXR.
pub(super) fn is_one(bytes: &[u8]) -> bool {
    bytes.starts_with(&MAGIC)
}

/// Its width and height, and its pixels from the top row. A number below 0, or that is none, counts as 0, one beyond 16
/// bits as the greatest of these.
///
/// # Errors
/// What is wrong with it, in words.
pub(super) fn decode(bytes: &[u8], longest: usize, most: u64) -> Result<(usize, usize, Vec<[f32; 3]>), String> {
    let words = |error: exr::error::Error| error.to_string();
    let head = MetaData::read_from_buffered(Cursor::new(bytes), true).map_err(words)?;
    for header in &head.headers {
        let size = header.layer_size;
        // Decoded pixels, and the channels that they are decoded from.
        let needed = (size.area() as u64).saturating_mul(12 + header.channels.bytes_per_pixel as u64);
        if size.width().max(size.height()) > longest || needed > most {
            return Err(format!("it has {} by {} pixels, which are too many", size.width(), size.height()));
        }
        if header.deep {
            return Err("it has deep pixels, which are not read; flatten it".into());
        }
        if header.shared_attributes.chromaticities.is_some_and(|found| !is_rec709(&found)) {
            return Err("its colours are not of Rec.709; write it as scene-linear Rec.709".into());
        }
    }
    let pixels = |size: exr::math::Vec2<usize>, _: &_| (size, vec![[0.0; 3]; size.area()]);
    let set = |(size, pixels): &mut (exr::math::Vec2<usize>, Vec<[f32; 3]>), at: exr::math::Vec2<usize>, (r, g, b)| {
        let sound = |part: f32| if part.is_finite() { part.clamp(0.0, BRIGHTEST) } else { 0.0 };
        if let Some(pixel) = pixels.get_mut(at.y() * size.width() + at.x()) {
            *pixel = [r, g, b].map(sound);
        }
    };
    let picture = read()
        .no_deep_data()
        .largest_resolution_level()
        .rgb_channels(pixels, set)
        .first_valid_layer()
        .all_attributes()
        .non_parallel()
        .from_buffered(Cursor::new(bytes))
        .map_err(|error| format!("no layer of it has channels R, G and B that can be read: {error}"))?;
    let (size, pixels) = picture.layer_data.channel_data.pixels;
    if pixels.is_empty() {
        return Err("it has no pixels".into());
    }
    Ok((size.width(), size.height(), pixels))
}

fn is_rec709(found: &Chromaticities) -> bool {
    let found = [found.red, found.green, found.blue, found.white];
    let near = |(found, exact): (exr::math::Vec2<f32>, [f32; 2])| {
        (found.x() - exact[0]).abs() < ROUNDING && (found.y() - exact[1]).abs() < ROUNDING
    };
    found.into_iter().zip(REC709).all(near)
}

#[cfg(test)]
mod tests {
    use exr::prelude::{Image, SpecificChannels, WritableImage};

    use super::*;
    use crate::mesh::texture::{Lookup, Meaning, Texture, Wrap};

    fn written(primaries: Option<Chromaticities>) -> Vec<u8> {
        let colour = |at: exr::math::Vec2<usize>| {
            (at.x() as f32, 0.25 * at.y() as f32, if at.x() == 0 { f32::NAN } else { -1.0 })
        };
        let mut image = Image::from_channels((4, 3), SpecificChannels::rgb(colour));
        image.attributes.chromaticities = primaries;
        let mut out = Cursor::new(Vec::new());
        image.write().to_buffered(&mut out).unwrap();
        out.into_inner()
    }

    #[test]
    fn light_comes_as_it_is() {
        let bytes = written(None);
        let texture = Texture::decode(&bytes, Meaning::Colours).unwrap();
        assert_eq!(texture.pixels(), [4, 3]);
        let at =
            |x: f32, y: f32| texture.sample([(x + 0.5) / 4.0, (y + 0.5) / 3.0], [Wrap::Clamp; 2], Lookup::Nearest, 1.0);
        assert_eq!((at(0.0, 0.0), at(3.0, 2.0)), ([0.0; 3], [3.0, 0.5, 0.0]));
        for end in [3, 20, bytes.len() / 2, bytes.len() - 1] {
            assert!(Texture::decode(&bytes[..end], Meaning::Colours).is_err(), "{end}");
        }
        let ap1 = [[0.713, 0.293], [0.165, 0.83], [0.128, 0.044], [0.32168, 0.33767]];
        let [red, green, blue, white] = ap1.map(|[x, y]| exr::math::Vec2(x, y));
        let wide = written(Some(Chromaticities { red, green, blue, white }));
        assert!(Texture::decode(&wide, Meaning::Colours).unwrap_err().contains("not of Rec.709"));
    }
}
