//! A picture in layers, as compositing takes it, and its EXR.

use super::error::PictureError;
use super::exr_file::{Values, encode};

/// The depth where the object is not, as Blender has it.
pub(super) const FAR: f32 = 1e10;

/// What is seen of an object, one value a pixel, the top row first. Everything but the depth is filtered: at an edge
/// it is the mean over the pixel's samples.
#[derive(Clone, Debug, PartialEq)]
pub struct Layers {
    width: usize,
    height: usize,
    /// Light, scene-linear Rec.709, premultiplied by the mask: of the object alone, neither bent nor clipped.
    pub beauty: [Vec<f32>; 3],
    /// The share of the pixel that the object covers.
    pub mask: Vec<f32>,
    /// The object's own colour without light, scene-linear Rec.709, premultiplied by the mask.
    pub colour: [Vec<f32>; 3],
    /// The outward unit normal, world space; 0 where the object is not.
    pub normal: [Vec<f32>; 3],
    /// The distance of the pixel's nearest sample from the camera's plane, world units; 1e10 where the object is not.
    pub depth: Vec<f32>,
}

impl Layers {
    /// Layers in which nothing is seen.
    pub(super) fn new(width: usize, height: usize) -> Self {
        let plane = || vec![0.0; width * height];
        let planes = || [plane(), plane(), plane()];
        let (beauty, colour, normal) = (planes(), planes(), planes());
        Self { width, height, beauty, mask: plane(), colour, normal, depth: vec![FAR; width * height] }
    }

    /// The bytes of an EXR file of one part: the beauty as `R`, `G`, `B`, `A`, the others as `depth.Z`,
    /// `normal.X`, `normal.Y`, `normal.Z`, `colour.R`, `colour.G`, `colour.B` and `mask.A`. Depth has 32 bits, all
    /// others 16.
    ///
    /// # Errors
    /// [`PictureError::Size`] and [`PictureError::Exr`].
    pub fn encode_exr(&self) -> Result<Vec<u8>, PictureError> {
        let mut channels = Vec::new();
        for (layer, axes, planes) in [
            ("", ["R", "G", "B"], &self.beauty),
            ("colour.", ["R", "G", "B"], &self.colour),
            ("normal.", ["X", "Y", "Z"], &self.normal),
        ] {
            for (axis, plane) in axes.iter().zip(planes) {
                channels.push((format!("{layer}{axis}"), Values::Half(plane)));
            }
        }
        channels.push(("A".into(), Values::Half(&self.mask)));
        channels.push(("mask.A".into(), Values::Half(&self.mask)));
        channels.push(("depth.Z".into(), Values::Full(&self.depth)));
        encode([self.width, self.height], channels, None)
    }
}

#[cfg(test)]
mod tests {
    use std::io::Cursor;

    use exr::prelude::{ReadChannels, ReadLayers, read};

    use super::{FAR, Layers, PictureError};

    #[test]
    fn an_exr_reads_back_as_it_was() {
        let mut layers = Layers::new(3, 2);
        layers.beauty[1][4] = 0.5;
        layers.normal[2][0] = -1.0;
        layers.depth[5] = 1234.567;
        let bytes = layers.encode_exr().unwrap();
        let image = read().no_deep_data().largest_resolution_level().all_channels().all_layers().all_attributes();
        let image = image.from_buffered(Cursor::new(bytes)).unwrap();
        let channels = &image.layer_data[0].channel_data.list;
        let names: Vec<String> = channels.iter().map(|channel| channel.name.to_string()).collect();
        let expected = ["A", "B", "G", "R", "colour.B", "colour.G", "colour.R", "depth.Z", "mask.A"];
        assert_eq!(names, [&expected[..], &["normal.X", "normal.Y", "normal.Z"]].concat());
        let value = |name: &str, at: usize| {
            let channel = channels.iter().find(|channel| channel.name.to_string() == name).unwrap();
            channel.sample_data.value_by_flat_index(at).to_f32()
        };
        assert_eq!((value("G", 4), value("G", 3), value("normal.Z", 0)), (0.5, 0.0, -1.0));
        assert_eq!((value("depth.Z", 5), value("depth.Z", 0)), (1234.567, FAR));
        assert!(matches!(Layers::new(0, 3).encode_exr(), Err(PictureError::Size { .. })));
    }
}
