//! A slice through a field itself, as far as the picture goes: lines of equal F, of equal distance, or how steep F is, and marks
//! where it is no number or steeper than it declares. And one through a scalar, whose lines end where the inside does. What
//! [`Slice::draw`] shows of a band ends where the band does.

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::image::{Image, decode_srgb};
use super::plot::rounded_up;
use super::slice::{CLAY, LEAST_CAPTIONED, PAPER, SAMPLES, Slice, sign};
use super::slice_values::{f_at, scalar_at};
use crate::attribute::Scalar;
use crate::field::{BATCH, Field, Gradients, Points, Slope};

/// What of a field is shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shows {
    /// F, by its lines.
    Values,
    /// The same of a field that is a distance.
    Distance,
    /// The length of its gradient, by colours: white where that is 1, red where it is more, blue where it is less.
    Gradient,
}

/// One sample of a pixel.
struct Shade {
    /// What lines are of.
    value: f64,
    colour: [f32; 3],
    /// Whether there are lines.
    lined: bool,
    /// F, where the surface's line is not among those.
    f: Option<f64>,
}

/// Where F is no number, or steeper than declared.
const WRONG: [f32; 3] = [0.9, 0.0, 0.6];
/// Steeper than 1, and less steep.
const STEEP: [f32; 3] = [0.62, 0.02, 0.02];
const FLAT: [f32; 3] = [0.02, 0.08, 0.45];
/// So many doublings from 1 have the full colour.
const DOUBLINGS: f64 = 2.0;
/// Lines of one sign, about.
const LINES: f64 = 12.0;
/// Rounding of gradients in 32 bits.
const SLACK: f64 = 1e-3;

impl Slice {
    /// The same with lines that suit the values of a field over the whole picture.
    pub fn for_field(self, field: &dyn Field, shows: Shows) -> Self {
        // A distance is greatest far outside: half the way from line to line leaves some for the inside.
        let lines = if shows == Shows::Distance { 2.0 * LINES } else { LINES };
        self.for_numbers(self.looked_at().map(|position| field.reference(position)), lines)
    }

    /// The same with lines that suit a scalar where a field is inside.
    pub fn for_scalar(self, scalar: &Scalar, field: &dyn Field) -> Self {
        let inside: Vec<DVec3> = self.looked_at().filter(|position| field.reference(*position) >= 0.0).collect();
        self.for_numbers(scalar_at(scalar, &inside).into_iter().map(f64::from), LINES)
    }

    /// Places all over the picture.
    fn looked_at(&self) -> impl Iterator<Item = DVec3> {
        /// Places each way.
        const PLACES: usize = 24;
        let step = self.size.max(1) as f64 / PLACES as f64;
        let place = move |i: usize| DVec2::new((i % PLACES) as f64 + 0.5, (i / PLACES) as f64 + 0.5) * step;
        (0..PLACES * PLACES).map(move |i| self.world(place(i)))
    }

    fn for_numbers(mut self, numbers: impl Iterator<Item = f64>, lines: f64) -> Self {
        let greatest = numbers.map(f64::abs).filter(|size| size.is_finite()).fold(0.0, f64::max);
        if greatest > 0.0 {
            self.spacing = rounded_up(greatest / lines, false);
        }
        self
    }

    /// What the picture of a field means, in words.
    pub fn caption_of_field(&self, shows: Shows) -> String {
        match shows {
            Shows::Values => self.caption_of("F"),
            Shows::Distance => self.caption_of("distance"),
            Shows::Gradient => {
                format!("{}, |grad F|, white 1; lines every {}", self.plane, self.spacing as f32)
            }
        }
    }

    /// What lines of something mean, in words.
    pub fn caption_of(&self, what: &str) -> String {
        format!("{}, {what}, a line every {}", self.plane, self.spacing as f32)
    }

    /// Draws a field.
    pub fn draw_field(&self, field: &dyn Field, shows: Shows) -> Image {
        self.drawn(&self.caption_of_field(shows), |positions| shades_of_field(field, shows, positions))
    }

    /// Draws a scalar by its name where a field is inside, by its lines.
    pub fn draw_scalar(&self, name: &str, scalar: &Scalar, field: &dyn Field) -> Image {
        let paper = PAPER.map(decode_srgb);
        let shade = |(value, f): (f32, f32)| match f >= 0.0 {
            true => Shade {
                value: value.into(),
                colour: if value.is_finite() { CLAY } else { WRONG },
                lined: value.is_finite(),
                f: Some(f.into()),
            },
            false => Shade { value: 0.0, colour: paper, lined: false, f: Some(f.into()) },
        };
        self.drawn(&self.caption_of(name), |positions| {
            scalar_at(scalar, positions).into_iter().zip(f_at(field, positions)).map(shade).collect()
        })
    }

    /// Draws what the samples of a row show.
    fn drawn(&self, caption: &str, row: impl Fn(&[DVec3]) -> Vec<Shade> + Sync) -> Image {
        let [red, green, blue] = PAPER;
        let mut image = Image::new(self.size, self.size, [red, green, blue, 255]);
        let pixel = |samples: &[Shade]| {
            let mut sum = [0.0; 3];
            for sample in samples {
                for (sum, channel) in sum.iter_mut().zip(sample.colour) {
                    *sum += channel / samples.len() as f32;
                }
            }
            let values: [f64; SAMPLES * SAMPLES] = std::array::from_fn(|i| samples[i].value);
            let known = if samples.iter().all(|sample| sample.lined) { f64::INFINITY } else { 0.0 };
            let pixel = self.with_lines(sum, &values, known);
            if samples[0].f.is_none() {
                return pixel;
            }
            let values: [f64; SAMPLES * SAMPLES] = std::array::from_fn(|i| samples[i].f.unwrap_or(f64::NAN));
            let [red, green, blue, _] = pixel;
            let surface = Self { spacing: f64::MAX, ..*self };
            surface.with_lines([red, green, blue].map(decode_srgb), &values, f64::INFINITY)
        };
        let rows = image.pixels_mut().par_chunks_mut(self.size.max(1)).enumerate();
        rows.for_each(|(number, pixels)| {
            let positions: Vec<DVec3> = self.places(number).map(|place| self.world(place)).collect();
            for (out, samples) in pixels.iter_mut().zip(row(&positions).chunks_exact(SAMPLES * SAMPLES)) {
                *out = pixel(samples);
            }
        });
        if self.size >= LEAST_CAPTIONED {
            sign(&mut image, caption);
        }
        image
    }
}

fn shades_of_field(field: &dyn Field, shows: Shows, positions: &[DVec3]) -> Vec<Shade> {
    let bound = match field.slope() {
        Slope::Exact { .. } => 1.0,
        Slope::Lipschitz(bound) => bound,
        Slope::Unknown => f64::INFINITY,
    };
    let paper = PAPER.map(decode_srgb);
    let colour = |value: f64, steepness: f64| match shows {
        _ if value.is_nan() || steepness.is_nan() || steepness > bound * (1.0 + SLACK) => WRONG,
        Shows::Values | Shows::Distance if value >= 0.0 => CLAY,
        Shows::Values | Shows::Distance => paper,
        Shows::Gradient => {
            let share = (steepness.log2() / DOUBLINGS).clamp(-1.0, 1.0) as f32;
            let full = if share > 0.0 { STEEP } else { FLAT };
            std::array::from_fn(|i| 1.0 + (full[i] - 1.0) * share.abs())
        }
    };
    let mut evaluator = field.evaluator();
    let mut gradients = Gradients::new();
    let mut shades = Vec::with_capacity(positions.len());
    for chunk in positions.chunks(BATCH) {
        let points = Points::of_positions(chunk);
        evaluator.gradients(&points, &mut gradients);
        shades.extend((0..chunk.len()).map(|i| {
            let (value, steepness) = (f64::from(gradients.value[i]), f64::from(gradients.gradient(i).length()));
            Shade { value, colour: colour(value, steepness), lined: true, f: None }
        }));
    }
    shades
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
        let mut slice = slice().for_field(&field, Shows::Values);
        slice.spacing = 0.2;
        let image = slice.draw_field(&field, Shows::Values);
        // 0.4 away from the surface, where no band reaches, there is a line; halfway to the next there is none.
        assert!(at(&image, 0.9, 0.0)[0] + 20 < at(&image, 1.0, 0.0)[0]);
        assert_eq!(at(&image, 1.0, 0.0), PAPER);
    }

    /// Inside, x by its lines; outside there is none, and where it is no number it is marked.
    #[test]
    fn a_scalar_is_drawn_inside() {
        let mut graph = Graph::new();
        let ball = graph.sphere(0.9);
        let field = Expression::new(&graph, ball);
        let number = crate::attribute::FieldValue(std::sync::Arc::new({
            let mut graph = Graph::new();
            let x = graph.x();
            let root = graph.sqrt(x);
            Expression::new(&graph, root)
        }));
        let mut slice = slice().for_scalar(&number, &field);
        assert!(slice.spacing > 0.05 && slice.spacing < 0.2, "{}", slice.spacing);
        slice.spacing = 0.5;
        let image = slice.draw_scalar("root", &number, &field);
        assert!(at(&image, 0.25, 0.1)[0] + 20 < at(&image, 0.4, 0.1)[0], "the line of a half");
        assert_eq!(at(&image, 0.4, 0.1), CLAY.map(encode_srgb));
        assert_eq!(at(&image, -0.4, 0.1), WRONG.map(encode_srgb));
        assert_eq!(at(&image, 0.4, 0.95), PAPER);
        assert_eq!(slice.caption_of("root"), "z = 0, root, a line every 0.5");
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
