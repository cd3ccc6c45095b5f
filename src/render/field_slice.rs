//! A slice through a field itself, as far as the picture goes: lines of equal F, or how steep it is, and marks where F is
//! no number or steeper than it declares. What [`Slice::draw`] shows of a band ends where the band does.

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::image::{Image, decode_srgb};
use super::plot::rounded_up;
use super::slice::{CLAY, LEAST_CAPTIONED, PAPER, SAMPLES, Slice, sign};
use crate::field::{BATCH, Field, Gradients, Points, Slope};

/// What of a field is shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shows {
    /// F, by its lines.
    Values,
    /// The length of its gradient, by colours: white where that is 1, red where it is more, blue where it is less.
    Gradient,
}

/// Where F is no number, or steeper than declared.
const WRONG: [f32; 3] = [0.9, 0.0, 0.6];
/// Steeper than 1, and less steep.
const STEEP: [f32; 3] = [0.62, 0.02, 0.02];
const FLAT: [f32; 3] = [0.02, 0.08, 0.45];
/// So many doublings from 1 have the full colour.
const DOUBLINGS: f64 = 2.0;
/// Rounding of gradients in 32 bits.
const SLACK: f64 = 1e-3;

impl Slice {
    /// The same with lines that suit the values of a field over the whole picture.
    pub fn for_field(mut self, field: &dyn Field) -> Self {
        /// Places looked at each way.
        const PLACES: usize = 24;
        /// Lines of one sign, about.
        const LINES: f64 = 12.0;
        let step = self.size.max(1) as f64 / PLACES as f64;
        let place = |i: usize| DVec2::new((i % PLACES) as f64 + 0.5, (i / PLACES) as f64 + 0.5) * step;
        let sizes = (0..PLACES * PLACES).map(|i| field.reference(self.world(place(i))).abs());
        let greatest = sizes.filter(|size| size.is_finite()).fold(0.0, f64::max);
        if greatest > 0.0 {
            self.spacing = rounded_up(greatest / LINES, false);
        }
        self
    }

    /// What the picture of a field means, in words.
    pub fn caption_of_field(&self, shows: Shows) -> String {
        match shows {
            Shows::Values => format!("{}, F, a line every {}", self.plane, self.spacing as f32),
            Shows::Gradient => {
                format!("{}, |grad F|, white 1; lines every {}", self.plane, self.spacing as f32)
            }
        }
    }

    /// Draws a field.
    pub fn draw_field(&self, field: &dyn Field, shows: Shows) -> Image {
        let [red, green, blue] = PAPER;
        let mut image = Image::new(self.size, self.size, [red, green, blue, 255]);
        let rows = image.pixels_mut().par_chunks_mut(self.size.max(1)).enumerate();
        rows.for_each(|(row, pixels)| {
            for (pixel, colour) in pixels.iter_mut().zip(self.field_row(field, shows, row)) {
                *pixel = colour;
            }
        });
        if self.size >= LEAST_CAPTIONED {
            sign(&mut image, &self.caption_of_field(shows));
        }
        image
    }

    fn field_row(&self, field: &dyn Field, shows: Shows, row: usize) -> Vec<[u8; 4]> {
        let positions: Vec<DVec3> = self.places(row).map(|place| self.world(place)).collect();
        let bound = match field.slope() {
            Slope::Exact { .. } => 1.0,
            Slope::Lipschitz(bound) => bound,
            Slope::Unknown => f64::INFINITY,
        };
        let mut evaluator = field.evaluator();
        let mut gradients = Gradients::new();
        let mut read: Vec<(f64, f64)> = Vec::with_capacity(positions.len());
        for chunk in positions.chunks(BATCH) {
            let points = Points::of_positions(chunk);
            evaluator.gradients(&points, &mut gradients);
            read.extend(
                (0..chunk.len()).map(|i| (f64::from(gradients.value[i]), f64::from(gradients.gradient(i).length()))),
            );
        }
        let paper = PAPER.map(decode_srgb);
        let colour = |(value, steepness): &(f64, f64)| match shows {
            _ if value.is_nan() || steepness.is_nan() || *steepness > bound * (1.0 + SLACK) => WRONG,
            Shows::Values if *value >= 0.0 => CLAY,
            Shows::Values => paper,
            Shows::Gradient => {
                let share = (steepness.log2() / DOUBLINGS).clamp(-1.0, 1.0) as f32;
                let full = if share > 0.0 { STEEP } else { FLAT };
                std::array::from_fn(|i| 1.0 + (full[i] - 1.0) * share.abs())
            }
        };
        let pixel = |samples: &[(f64, f64)]| {
            let mut sum = [0.0; 3];
            for sample in samples {
                for (sum, channel) in sum.iter_mut().zip(colour(sample)) {
                    *sum += channel / samples.len() as f32;
                }
            }
            let values: [f64; SAMPLES * SAMPLES] = std::array::from_fn(|i| samples[i].0);
            self.with_lines(sum, &values, f64::INFINITY)
        };
        read.chunks_exact(SAMPLES * SAMPLES).map(pixel).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::{Aabb, Expression, Graph};
    use crate::render::image::encode_srgb;

    fn slice() -> Slice {
        Slice::new("z=0".parse().unwrap(), Aabb::new(DVec3::NEG_ONE, DVec3::ONE), 200, 1.0)
    }

    fn at(image: &Image, x: f64, y: f64) -> [u8; 3] {
        let pixel = |along: f64| (100.0 + along * 200.0 / (2.0 * 1.24)) as usize;
        let [red, green, blue, _] = image.pixel(pixel(x), pixel(-y));
        [red, green, blue]
    }

    #[test]
    fn lines_go_as_far_as_the_picture() {
        let mut graph = Graph::new();
        let ball = graph.sphere(0.5);
        let field = Expression::new(&graph, ball);
        let mut slice = slice().for_field(&field);
        slice.spacing = 0.2;
        let image = slice.draw_field(&field, Shows::Values);
        // 0.4 away from the surface, where no band reaches, there is a line; halfway to the next there is none.
        assert!(at(&image, 0.9, 0.0)[0] + 20 < at(&image, 1.0, 0.0)[0]);
        assert_eq!(at(&image, 1.0, 0.0), PAPER);
    }

    #[test]
    fn steepness_and_what_is_wrong() {
        let mut graph = Graph::new();
        let x = graph.x();
        let steep = graph.linear(x, 4.0, 0.0);
        let steeper = graph.linear(x, 5.0, 0.0);
        let wrong = graph.no_steeper(steeper, 2.0);
        let root = graph.sqrt(x);
        let full = |colour: [f32; 3]| colour.map(encode_srgb);
        let draw = |node, shows| {
            let field = Expression::new(&graph, node);
            let mut slice = slice();
            slice.spacing = 1e6;
            at(&slice.draw_field(&field, shows), -0.5, 0.3)
        };
        assert_eq!(draw(steep, Shows::Gradient), full(STEEP));
        assert_eq!(draw(wrong, Shows::Gradient), full(WRONG));
        assert_eq!(draw(root, Shows::Values), full(WRONG));
    }
}
