//! A slice as numbers: distance, F, colour and attributes at the middle of every pixel, and its EXR.

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::error::PictureError;
use super::exr_file::{Values, encode};
use super::slice::{Fill, Slice, colours};
use super::volume::Volume;
use crate::attribute::Scalar;
use crate::field::{BATCH, Field, Points};
use crate::grid::Band;

/// Where numbers of a slice come from.
#[derive(Clone, Copy)]
pub enum Numbers<'a> {
    /// A scalar of a scene.
    Scalar(&'a Scalar),
    /// What is known at each place.
    At(&'a (dyn Fn(DVec3) -> f32 + Sync)),
}

/// One value a pixel, the top row first.
#[derive(Clone, Debug, PartialEq)]
pub struct SliceValues {
    size: usize,
    /// The signed distance, world units, positive inside; that of a band as far as it reaches, and that beyond.
    pub distance: Vec<f32>,
    /// F, where it is known.
    pub f: Option<Vec<f32>>,
    /// Colours inside, scene-linear Rec.709; 0 outside.
    pub colour: [Vec<f32>; 3],
    /// 1 inside, 0 outside.
    pub inside: Vec<f32>,
    /// Scalars by their names, inside and outside.
    pub scalars: Vec<(String, Vec<f32>)>,
    /// Where the picture stands in the world, in words.
    pub place: String,
}

impl Slice {
    /// The numbers that [`Self::draw`] and [`Self::draw_field`] draw. `distance` answers in the place of the band where it is
    /// known everywhere.
    pub fn values(
        &self,
        band: &Band,
        distance: Option<&dyn Field>,
        field: Option<&dyn Field>,
        fill: Fill<'_>,
        numbers: &[(String, Numbers<'_>)],
    ) -> SliceValues {
        let size = self.size;
        let volume = Volume::new(band);
        let middle = |i: usize| self.world(DVec2::new((i % size) as f64 + 0.5, (i / size) as f64 + 0.5));
        let positions: Vec<DVec3> = (0..size * size).into_par_iter().map(middle).collect();
        let of_band = |position: &DVec3| volume.distance(*position / volume.voxel_size()) as f32;
        let distance: Vec<f32> = match distance {
            Some(distance) => f_at(distance, &positions),
            None => positions.par_iter().map(of_band).collect(),
        };
        let is_inside: Vec<bool> = distance.iter().map(|distance| *distance >= 0.0).collect();
        let within: Vec<DVec3> =
            positions.iter().zip(&is_inside).filter(|(_, inside)| **inside).map(|(position, _)| *position).collect();
        let mut found = colours(fill, &within).into_iter();
        let mut colour = [const { Vec::new() }; 3];
        for inside in &is_inside {
            let value = if *inside { found.next().unwrap_or_default() } else { [0.0; 3] };
            for (channel, value) in colour.iter_mut().zip(value) {
                channel.push(value);
            }
        }
        let (corner, pixel) = (self.world(DVec2::splat(0.5)), self.world(DVec2::new(1.5, 0.5)));
        SliceValues {
            size,
            f: field.map(|field| f_at(field, &positions)),
            scalars: numbers.iter().map(|(name, numbers)| (name.clone(), numbers.at(&positions))).collect(),
            inside: is_inside.into_iter().map(f32::from).collect(),
            distance,
            colour,
            place: format!(
                "{}; the middle of the first pixel is at ({}, {}, {}), a pixel is {} wide; world units",
                self.plane,
                corner.x,
                corner.y,
                corner.z,
                corner.distance(pixel)
            ),
        }
    }
}

impl Numbers<'_> {
    fn at(&self, positions: &[DVec3]) -> Vec<f32> {
        match self {
            Self::Scalar(scalar) => scalar_at(*scalar, positions),
            Self::At(number) => positions.par_iter().map(|position| number(*position)).collect(),
        }
    }
}

/// Calls with batches of positions; what comes back are their values.
fn by_batches<'p, E>(
    positions: &'p [DVec3],
    evaluator: impl Fn() -> E + Sync + Send + 'p,
    read: impl Fn(&mut E, &Points, &mut [f32]) + Sync + Send + 'p,
) -> Vec<f32> {
    let mut values = vec![0.0; positions.len()];
    values.par_chunks_mut(BATCH).zip(positions.par_chunks(BATCH)).for_each_init(
        evaluator,
        |evaluator, (out, chunk)| {
            let points = Points::of_positions(chunk);
            read(evaluator, &points, out);
        },
    );
    values
}

pub(super) fn f_at(field: &dyn Field, positions: &[DVec3]) -> Vec<f32> {
    by_batches(
        positions,
        || field.evaluator(),
        |evaluator, points, out| {
            let mut values = [0.0; BATCH];
            evaluator.values(points, &mut values);
            out.copy_from_slice(&values[..out.len()]);
        },
    )
}

pub(super) fn scalar_at(scalar: &Scalar, positions: &[DVec3]) -> Vec<f32> {
    by_batches(
        positions,
        || scalar.sampler(),
        |sampler, points, out| {
            let mut values = [[0.0]; BATCH];
            sampler.sample(points, &mut values);
            out.copy_from_slice(values[..out.len()].as_flattened());
        },
    )
}

impl SliceValues {
    /// The bytes of an EXR file of one part: `R`, `G`, `B` and `A` of the inside in 16 bits; `distance.V`, `F.V` and the scalars
    /// by their names in 32, each a layer of its own, as compositors list them. Where the picture stands in the world is the
    /// comment.
    ///
    /// # Errors
    /// [`PictureError::Size`] and [`PictureError::Exr`].
    pub fn encode_exr(&self) -> Result<Vec<u8>, PictureError> {
        let [red, green, blue] = &self.colour;
        let mut channels: Vec<(String, Values<'_>)> = Vec::new();
        for (name, values) in [("R", red), ("G", green), ("B", blue), ("A", &self.inside)] {
            channels.push((name.into(), Values::Half(values)));
        }
        channels.push(("distance.V".into(), Values::Full(&self.distance)));
        channels.extend(self.f.as_ref().map(|values| ("F.V".into(), Values::Full(values))));
        for (name, values) in &self.scalars {
            // Parts of vectors have names of theirs.
            let name = if name.contains('.') { name.clone() } else { format!("{name}.V") };
            let is_taken = channels.iter().any(|(taken, _)| *taken == name);
            let name = if is_taken { format!("attribute.{name}") } else { name };
            channels.push((name, Values::Full(values)));
        }
        encode([self.size, self.size], channels, Some(&self.place))
    }
}

#[cfg(test)]
mod tests {
    use exr::prelude::{ReadChannels, ReadLayers, read};

    use super::*;
    use crate::attribute::Constant;
    use crate::field::{Aabb, Expression, Graph};
    use crate::grid::testing::sphere;

    #[test]
    fn numbers_are_those_of_a_ball() {
        let band = sphere(DVec3::ZERO, 1.0, 0.05);
        let mut graph = Graph::new();
        let node = graph.sphere(1.0);
        let field = Expression::new(&graph, node);
        let bounds = Aabb::new(DVec3::NEG_ONE, DVec3::ONE);
        let slice = Slice::new("z=0.6".parse().unwrap(), bounds, 40, 0.5);
        let red = Constant::new([0.5, 0.25, 0.125]);
        let heat = Constant::new([7.0]);
        let scalars = [("heat".to_owned(), Numbers::Scalar(&heat)), ("z".to_owned(), Numbers::At(&|at| at.z as f32))];
        let values = slice.values(&band, None, Some(&field), Fill::Everywhere(&red), &scalars);
        let f = values.f.as_ref().unwrap();
        for i in 0..40 * 40 {
            let place = DVec2::new((i % 40) as f64 + 0.5, (i / 40) as f64 + 0.5);
            let exact = field.reference(slice.world(place));
            assert!((f64::from(f[i]) - exact).abs() < 1e-6);
            let distance = f64::from(values.distance[i]);
            let known = exact.abs() < f64::from(band.background()) - 0.1;
            assert!(!known || (distance - (1.0 - slice.world(place).length())).abs() < 2e-3, "{distance} {exact}");
            assert_eq!(values.inside[i] == 1.0, distance >= 0.0);
            assert_eq!(values.colour[1][i], if distance >= 0.0 { 0.25 } else { 0.0 });
            assert_eq!((values.scalars[0].1[i], values.scalars[1].1[i]), (7.0, 0.6));
        }
        let everywhere = slice.values(&band, Some(&field), Some(&field), Fill::None, &[]);
        assert_eq!(Some(everywhere.distance), everywhere.f);
        let image = read().no_deep_data().largest_resolution_level().all_channels().all_layers();
        let image = image.all_attributes().from_buffered(std::io::Cursor::new(values.encode_exr().unwrap())).unwrap();
        let layer = &image.layer_data[0];
        let names: Vec<String> = layer.channel_data.list.iter().map(|channel| channel.name.to_string()).collect();
        assert_eq!(names, ["A", "B", "F.V", "G", "R", "distance.V", "heat.V", "z.V"]);
        let comment = layer.attributes.comments.as_ref().unwrap().to_string();
        assert!(comment.starts_with("z = 0.6; the middle of the first pixel is at ("), "{comment}");
    }
}
