//! One curve over the frames of a sequence, with its axes.

use super::{
    image::Image,
    text::{self, Align, LINE, Style},
};

const INK: [u8; 3] = [52, 58, 70];
const FAINT: [u8; 3] = [150, 155, 164];
const LINE_COLOUR: [u8; 3] = [38, 98, 160];
const ALARM: [u8; 3] = [200, 44, 52];
/// Half the thickness of a curve, in pixels.
const HALF_LINE: f32 = 1.1;
/// The greatest spacing of frames, in pixels, at which a curve is drawn without dots.
const DOT_SPACING: f32 = 7.0;

/// The pixels of a plot's field, without labels.
#[derive(Clone, Copy, Debug)]
pub(super) struct Field {
    pub left: usize,
    pub top: usize,
    pub width: usize,
    pub height: usize,
}

/// A measure of each frame.
pub(super) struct Curve<'a> {
    /// What is shown, above the field.
    pub title: &'a str,
    /// One value a frame; a gap where there is none, or none that is finite.
    pub values: Vec<Option<f64>>,
    /// A bound: drawn as a dashed line, and what exceeds it as red dots.
    pub limit: Option<f64>,
    /// Whether values are counts.
    pub whole: bool,
}

impl Curve<'_> {
    /// Draws the curve, its heading above the field and the values of its axis to the left of it.
    pub(super) fn draw(&self, image: &mut Image, field: Field) {
        let known = || self.values.iter().flatten().copied().filter(|value| value.is_finite());
        let top = rounded_up(known().fold(0.0, f64::max), self.whole);
        let (left, right) = (field.left as f32, (field.left + field.width) as f32);
        let height_of = |value: f64| {
            let part = (value / top).clamp(0.0, 1.0) as f32;
            field.top as f32 + field.height as f32 * (1.0 - part)
        };
        self.labels(image, field, top);
        for value in [0.0, 0.5 * top, top] {
            let row = height_of(value);
            let weight = if value == 0.0 { 1.0 } else { 0.35 };
            stroke(image, &[(left, row), (right, row)], 0.5, FAINT, weight);
        }
        if let Some(limit) = self.limit.filter(|&limit| limit < top) {
            let row = height_of(limit);
            let dashes = (0..).map(|dash| left + dash as f32 * 10.0).take_while(|&start| start + 5.0 < right);
            dashes.for_each(|start| stroke(image, &[(start, row), (start + 5.0, row)], 0.5, ALARM, 0.8));
        }
        let place = |index: usize| left + (right - left) * place_of(index, self.values.len());
        let point = |(index, value): (usize, &Option<f64>)| {
            value.filter(|value| value.is_finite()).map(|value| (place(index), height_of(value)))
        };
        let points: Vec<Option<(f32, f32)>> = self.values.iter().enumerate().map(point).collect();
        for run in points.split(Option::is_none) {
            let run: Vec<(f32, f32)> = run.iter().copied().flatten().collect();
            shade(image, &run, field);
            stroke(image, &run, HALF_LINE, LINE_COLOUR, 1.0);
        }
        let dotted = (right - left) > DOT_SPACING * self.values.len() as f32;
        for (point, value) in points.iter().zip(&self.values) {
            let Some(place) = *point else { continue };
            let alarm = self.limit.is_some_and(|limit| value.is_some_and(|value| value > limit));
            if alarm || dotted {
                let (radius, colour) = if alarm { (3.2, ALARM) } else { (2.4, LINE_COLOUR) };
                stroke(image, &[place, place], radius, colour, 1.0);
            }
        }
    }

    fn labels(&self, image: &mut Image, field: Field, top: f64) {
        let above = field.top as i64 - LINE as i64 - 5;
        text::draw(image, field.left as i64, above, self.title, Style::Bold, Align::Left, INK);
        let values = if self.whole { vec![0.0, top] } else { vec![0.0, 0.5 * top, top] };
        for value in values {
            let row = field.top as f64 + field.height as f64 * (1.0 - value / top) - LINE as f64 * 0.5;
            let label = if self.whole { format!("{value:.0}") } else { short(value) };
            text::draw(image, field.left as i64 - 8, row as i64, &label, Style::Plain, Align::Right, INK);
        }
    }
}

/// Draws the numbers of frames under a field.
pub(super) fn frame_axis(image: &mut Image, field: Field, frames: &[i64]) {
    let widest = frames.iter().map(|frame| text::width(&frame.to_string(), Style::Plain)).max().unwrap_or(0);
    let room = (field.width / (widest + 24)).max(1);
    let every = frames.len().div_ceil(room).max(1);
    for (index, frame) in frames.iter().enumerate() {
        let last = index + 1 == frames.len();
        // The last frame is always named, and takes the room of one that stands too near.
        let crowded = !last && index + every > frames.len() - 1 && index + 1 + every / 2 > frames.len() - 1;
        if last || (index % every == 0 && !crowded) {
            let column = field.left as f32 + field.width as f32 * place_of(index, frames.len());
            let row = (field.top + field.height + 5) as i64;
            text::draw(image, column as i64, row, &frame.to_string(), Style::Plain, Align::Centre, INK);
        }
    }
}

/// Where a frame stands along the axis, 0 to 1.
fn place_of(index: usize, count: usize) -> f32 {
    if count < 2 { 0.5 } else { index as f32 / (count - 1) as f32 }
}

/// The least 1, 2, 2.5 or 5 times a power of ten that is not less than a value (for counts: an even number); 1
/// (for counts: 2) where the value is 0.
pub(super) fn rounded_up(value: f64, whole: bool) -> f64 {
    if whole {
        return if value <= 2.0 { 2.0 } else { (value * 0.5).ceil() * 2.0 };
    }
    if value <= 0.0 {
        return 1.0;
    }
    let power = libm::exp10(libm::log10(value).floor());
    // A value a rounding above a step belongs to that step.
    let step = [1.0, 2.0, 2.5, 5.0].into_iter().map(|step| step * power).find(|step| step * (1.0 + 1e-9) >= value);
    step.unwrap_or(10.0 * power)
}

/// A number in at most seven letters, with three digits that count.
fn short(value: f64) -> String {
    if value == 0.0 {
        return "0".to_owned();
    }
    let magnitude = libm::log10(value.abs()).floor() as i32;
    if !(-3..5).contains(&magnitude) {
        return format!("{value:.1e}");
    }
    let text = format!("{value:.*}", (2 - magnitude).max(0) as usize);
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

/// Draws a line through points, as thick as twice `half`; a dot where both ends are one.
fn stroke(image: &mut Image, points: &[(f32, f32)], half: f32, colour: [u8; 3], weight: f32) {
    let Some(&first) = points.first() else { return };
    let ends = points.iter().copied().chain((points.len() == 1).then_some(first));
    let (mut low, mut high) = (first, first);
    for &(x, y) in points {
        (low, high) = ((low.0.min(x), low.1.min(y)), (high.0.max(x), high.1.max(y)));
    }
    let reach = half + 1.0;
    let ends: Vec<(f32, f32)> = ends.collect();
    for row in (low.1 - reach).floor() as i64..=(high.1 + reach).ceil() as i64 {
        for column in (low.0 - reach).floor() as i64..=(high.0 + reach).ceil() as i64 {
            let centre = (column as f32 + 0.5, row as f32 + 0.5);
            // Points are in order along x, so that only the segments above a pixel are looked at.
            let from = ends.partition_point(|end| end.0 < centre.0 - reach).saturating_sub(1);
            let until = (ends.partition_point(|end| end.0 <= centre.0 + reach) + 1).min(ends.len());
            let near = ends[from..until].windows(2).map(|pair| distance(centre, pair[0], pair[1]));
            let coverage = near.fold(0.0, |most: f32, distance| most.max((half + 0.5 - distance).clamp(0.0, 1.0)));
            if coverage > 0.0 {
                image.cover(column, row, colour, coverage * weight);
            }
        }
    }
}

/// Tints what lies under a line.
fn shade(image: &mut Image, points: &[(f32, f32)], field: Field) {
    for pair in points.windows(2) {
        let ((x0, y0), (x1, y1)) = (pair[0], pair[1]);
        for column in x0.round() as i64..x1.round() as i64 {
            let along = (column as f32 + 0.5 - x0) / (x1 - x0);
            let top = (y0 + (y1 - y0) * along).round() as i64;
            for row in top..(field.top + field.height) as i64 {
                image.cover(column, row, LINE_COLOUR, 0.13);
            }
        }
    }
}

fn distance(point: (f32, f32), from: (f32, f32), to: (f32, f32)) -> f32 {
    let (dx, dy) = (to.0 - from.0, to.1 - from.1);
    let length = dx * dx + dy * dy;
    let along = if length > 0.0 { ((point.0 - from.0) * dx + (point.1 - from.1) * dy) / length } else { 0.0 };
    let along = along.clamp(0.0, 1.0);
    let (x, y) = (point.0 - from.0 - along * dx, point.1 - from.1 - along * dy);
    (x * x + y * y).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    const FIELD: Field = Field { left: 60, top: 30, width: 200, height: 80 };

    fn drawn(values: Vec<Option<f64>>, limit: Option<f64>) -> Image {
        let mut image = Image::new(300, 140, [255; 4]);
        Curve { title: "volume", values, limit, whole: false }.draw(&mut image, FIELD);
        image
    }

    #[test]
    fn a_curve_passes_through_its_values() {
        let image = drawn(vec![Some(0.0), Some(1.0), Some(0.5)], None);
        for (column, row) in [(60, 110), (160, 30), (260, 70)] {
            assert_eq!(image.pixel(column, row)[..3], LINE_COLOUR, "at {column}, {row}");
        }
        assert_ne!(image.pixel(110, 90)[..3], [255; 3], "the field under the curve is tinted");
        assert_eq!(image.pixel(70, 60)[..3], [255; 3], "the field above it is not");
    }

    #[test]
    fn what_exceeds_the_limit_is_red() {
        let red = |image: &Image, row: usize| image.pixel(160, row)[..3] == ALARM;
        assert!(red(&drawn(vec![Some(1.0), Some(5.0), Some(1.0)], Some(2.0)), 30));
        assert!(!red(&drawn(vec![Some(1.0), Some(5.0), Some(1.0)], Some(5.0)), 30));
    }

    #[test]
    fn odd_values_are_gaps() {
        drawn(vec![None, Some(f64::NAN), Some(f64::INFINITY), Some(-3.0)], Some(f64::NAN));
        drawn(Vec::new(), None);
        drawn(vec![Some(2.0)], None);
    }

    #[test]
    fn axes_end_on_round_numbers() {
        for (value, top) in [(0.0, 1.0), (0.3, 0.5), (1.0, 1.0), (1.7, 2.0), (2.2, 2.5), (3.0, 5.0), (812.0, 1000.0)] {
            assert!((rounded_up(value, false) / top - 1.0).abs() < 1e-12, "{value}");
        }
        assert_eq!([0.0, 1.0, 3.0, 17.0].map(|value| rounded_up(value, true)), [2.0, 2.0, 4.0, 18.0]);
        let labels = [0.0, 1.0, 2.5, 1234.0, 0.0125, 3.2e7, 1e-9].map(short);
        assert_eq!(labels, ["0", "1", "2.5", "1234", "0.0125", "3.2e7", "1.0e-9"]);
    }
}
