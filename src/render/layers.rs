//! A picture in layers, as compositing takes it, and its EXR.

use std::io::Cursor;

use exr::prelude::*;

use super::error::PictureError;

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
    pub fn encode_exr(&self) -> std::result::Result<Vec<u8>, PictureError> {
        if self.width.min(self.height) == 0 {
            return Err(PictureError::Size { width: self.width, height: self.height });
        }
        let half = |name: &str, values: &[f32]| {
            AnyChannel::new(name, FlatSamples::F16(values.iter().copied().map(f16::from_f32).collect()))
        };
        let mut channels = SmallVec::new();
        for (layer, axes, planes) in [
            ("", ["R", "G", "B"], &self.beauty),
            ("colour.", ["R", "G", "B"], &self.colour),
            ("normal.", ["X", "Y", "Z"], &self.normal),
        ] {
            for (axis, plane) in axes.iter().zip(planes) {
                channels.push(half(&format!("{layer}{axis}"), plane));
            }
        }
        channels.push(half("A", &self.mask));
        channels.push(half("mask.A", &self.mask));
        channels.push(AnyChannel::new("depth.Z", FlatSamples::F32(self.depth.clone())));
        let encoding =
            Encoding { compression: Compression::ZIP16, blocks: Blocks::ScanLines, line_order: LineOrder::Increasing };
        let attributes = LayerAttributes::default();
        let layer = Layer::new((self.width, self.height), attributes, encoding, AnyChannels::sort(channels));
        let mut bytes = Cursor::new(Vec::new());
        Image::from_layer(layer).write().non_parallel().to_buffered(&mut bytes).map_err(PictureError::Exr)?;
        Ok(bytes.into_inner())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
