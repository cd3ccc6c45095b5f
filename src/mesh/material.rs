//! What a mesh's faces are painted with: a colour, and a picture for places of the surface.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::texture::{Lookup, Meaning, Texture, Wrap};
use crate::disk;

/// A material: its base colour, and numbers.
#[derive(Clone, Debug, Default)]
pub struct Material {
    /// Scene-linear Rec.709; where there is a picture it multiplies that.
    pub factor: [f32; 3],
    /// Its picture.
    pub picture: Option<Picture>,
    /// Beyond the picture's borders, to the right and down.
    pub wrap: [Wrap; 2],
    /// Roughness and metalness, where the file says them.
    pub numbers: [Option<MaterialNumber>; 2],
}

/// A number of a material, such as its roughness.
#[derive(Clone, Debug)]
pub struct MaterialNumber {
    /// Its value; where there is a picture it multiplies that.
    pub factor: f32,
    /// Its picture, with the channel that has it: 0, 1 or 2.
    pub picture: Option<(Picture, usize)>,
    /// Beyond the picture's borders, to the right and down.
    pub wrap: [Wrap; 2],
}

/// Which number of a material.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NumberOf {
    /// From 0, a mirror, to 1.
    Roughness,
    /// From 0 to 1, a metal.
    Metallic,
}

/// A picture, or one for each unit square of places.
#[derive(Clone, Debug)]
pub enum Picture {
    /// One.
    Single(Arc<Texture>),
    /// By UDIM numbers: 1001 and more, ten to a row, rows upward.
    Tiles(BTreeMap<u32, Arc<Texture>>),
}

/// A place in a material's picture: to the right and down, from 0 to 1 where it is in the picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PicturePlace {
    /// To the right, and down.
    pub place: [f32; 2],
    /// Which material.
    pub material: u32,
}

impl PicturePlace {
    /// Within a triangle, by the weights of its second and third corner.
    pub(super) fn between([a, b, c]: [Self; 3], [v, w]: [f64; 2]) -> Self {
        let at = |i: usize| {
            let [a, b, c] = [a, b, c].map(|corner| f64::from(corner.place[i]));
            (a * (1.0 - v - w) + b * v + c * w) as f32
        };
        Self { place: [at(0), at(1)], material: a.material }
    }
}

impl Material {
    /// The scene-linear colour at a place, averaged over a voxel that is so many times as wide as the whole picture.
    pub fn colour(&self, place: [f32; 2], lookup: Lookup, across: f32) -> [f32; 3] {
        let found = self.picture.as_ref().and_then(|picture| picture.sample(place, self.wrap, lookup, across));
        found.map_or(self.factor, |found| std::array::from_fn(|i| self.factor[i] * found[i]))
    }

    /// A number at a place, looked up as colours are; `None` where the file says none.
    pub fn number(&self, which: NumberOf, place: [f32; 2], lookup: Lookup, across: f32) -> Option<f32> {
        let MaterialNumber { factor, picture, wrap } = self.numbers[which as usize].as_ref()?;
        let of = |(picture, channel): &(Picture, usize)| Some(picture.sample(place, *wrap, lookup, across)?[*channel]);
        Some(picture.as_ref().and_then(of).map_or(*factor, |found| factor * found))
    }

    /// Whether it has a picture at all.
    pub(super) fn has_picture(&self) -> bool {
        self.picture.is_some() || self.numbers.iter().flatten().any(|number| number.picture.is_some())
    }

    /// Memory that its pictures take, in bytes.
    pub fn bytes(&self) -> u64 {
        let numbers = self.numbers.iter().flatten().filter_map(|number| number.picture.as_ref());
        self.picture.iter().chain(numbers.map(|(picture, _)| picture)).map(Picture::bytes).sum()
    }
}

impl Picture {
    /// What is at a place; `None` where there is no tile.
    fn sample(&self, place: [f32; 2], wrap: [Wrap; 2], lookup: Lookup, across: f32) -> Option<[f32; 3]> {
        let (texture, place, wrap) = match self {
            Self::Single(texture) => (texture, place, wrap),
            Self::Tiles(tiles) => {
                // Rows go upward; a border belongs to the square that ends there, so that 1 is in the first.
                let [column, row] = [place[0], 1.0 - place[1]].map(|along| (along.ceil() - 1.0).max(0.0));
                let number = 1001.0 + column.min(9.0) + 10.0 * row;
                let texture = tiles.get(&(number as u32))?;
                (texture, [place[0] - column, place[1] + row], [Wrap::Clamp; 2])
            }
        };
        let pixels = across * texture.pixels().into_iter().max().unwrap_or(1) as f32;
        Some(texture.sample(place, wrap, lookup, pixels))
    }

    fn bytes(&self) -> u64 {
        match self {
            Self::Single(texture) => texture.bytes(),
            Self::Tiles(tiles) => tiles.values().map(|texture| texture.bytes()).sum(),
        }
    }
}

/// What stands for the number of a tile in a name.
const UDIM: &str = "<UDIM>";

/// The picture of a name as files have it: relative to a folder, or by another machine's path, whose last part is then
/// sought in that folder.
///
/// # Errors
/// What is wrong, in words.
pub(super) fn picture(name: &str, folder: &Path, meaning: Meaning) -> Result<Picture, String> {
    if name.to_ascii_uppercase().contains(UDIM) {
        let tiles = tiles(name, folder, meaning)?;
        return Ok(Picture::Tiles(tiles));
    }
    let path = find(name, folder).ok_or_else(|| "it is not there".to_owned())?;
    Ok(Picture::Single(Arc::new(load(&path, meaning)?)))
}

fn load(path: &Path, meaning: Meaning) -> Result<Texture, String> {
    let bytes = disk::read(path).map_err(|error| error.to_string())?;
    Texture::decode(&bytes, meaning)
}

fn tiles(name: &str, folder: &Path, meaning: Meaning) -> Result<BTreeMap<u32, Arc<Texture>>, String> {
    let mut tiles = BTreeMap::new();
    for (number, path) in tile_paths(name, folder) {
        let texture = load(&path, meaning).map_err(|problem| format!("tile {number}: {problem}"))?;
        tiles.insert(number, Arc::new(texture));
    }
    if tiles.is_empty() { Err("there is no tile of it".into()) } else { Ok(tiles) }
}

fn tile_paths(name: &str, folder: &Path) -> Vec<(u32, PathBuf)> {
    let start = name.to_ascii_uppercase().find(UDIM).unwrap_or(0);
    let (before, after) = (&name[..start], &name[start + UDIM.len()..]);
    let numbered = |number: u32| Some((number, find(&format!("{before}{number}{after}"), folder)?));
    (1001..=1100).filter_map(numbered).collect()
}

/// The files that a picture's name stands for and that are there.
pub(super) fn files(name: &str, folder: &Path) -> Vec<PathBuf> {
    if name.to_ascii_uppercase().contains(UDIM) {
        return tile_paths(name, folder).into_iter().map(|(_, path)| path).collect();
    }
    find(name, folder).into_iter().collect()
}

/// The file of a name in or below a folder, or beside it.
pub(super) fn find(name: &str, folder: &Path) -> Option<PathBuf> {
    let name = name.trim().replace('\\', "/");
    if name.is_empty() || name.contains('\0') {
        return None;
    }
    let there = folder.join(&name);
    if there.is_file() {
        return Some(there);
    }
    let last = name.rsplit('/').next().filter(|last| !last.is_empty() && *last != "..")?;
    let beside = folder.join(last);
    beside.is_file().then_some(beside)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn squares_have_pictures_of_their_own() {
        let one = |grey: u8| {
            let mut out = std::io::Cursor::new(Vec::new());
            image::GrayImage::from_pixel(2, 2, image::Luma([grey]))
                .write_to(&mut out, image::ImageFormat::Png)
                .unwrap();
            out.into_inner()
        };
        let folder = tempfile::tempdir().unwrap();
        for (number, grey) in [(1001, 255), (1002, 0), (1011, 0)] {
            std::fs::write(folder.path().join(format!("skin.{number}.png")), one(grey)).unwrap();
        }
        let picture = picture("C:\\work\\skin.<UDIM>.png", folder.path(), Meaning::Colours).unwrap();
        let material = Material { factor: [0.5; 3], picture: Some(picture), ..Material::default() };
        // u to the right and v upward, as modellers have them.
        let at = |u: f32, v: f32| material.colour([u, 1.0 - v], Lookup::Filtered, 0.0);
        assert_eq!((at(0.3, 0.3), at(1.3, 0.3), at(0.3, 1.3)), ([0.5; 3], [0.0; 3], [0.0; 3]));
        // Where there is no tile.
        assert_eq!(at(4.5, 0.5), [0.5; 3]);
        assert_eq!(files("skin.<UDIM>.png", folder.path()).len(), 3);
        assert!(super::picture("other.png", folder.path(), Meaning::Colours).is_err());
    }
}
