//! A contact sheet: the frames of a sequence in rows, each with its number, over the curves that tell whether a morph
//! is sound: its volume (does it swell or shrink?), the change from frame to frame (does it pop?) and its pieces
//! (does it shed crumbs?).

use crate::grid::measure::median_of_moving;

use super::{
    image::Image,
    plot::{Curve, Field, frame_axis},
    text::{self, Align, LINE, Style},
};

const PAPER: [u8; 4] = [206, 209, 214, 255];
const PANEL: [u8; 4] = [236, 238, 241, 255];
const INK: [u8; 3] = [52, 58, 70];
/// Room around pictures, panel and border, in pixels.
const GAP: usize = 12;
/// Room for a heading above a plot's field.
const HEADING: usize = LINE + 14;
/// The height of a plot's field.
const PLOT: usize = 84;
/// Room to the left of a field for the values of its axis.
const AXIS: usize = 80;
/// A frame that changes more than this many times the median is a pop.
const POP: f64 = 2.0;
/// The least width of a sheet with curves: less, and frames of the curves merge.
const LEAST_WIDTH: usize = 640;

/// One frame of a sequence.
#[derive(Clone, Debug)]
pub struct SheetFrame {
    /// Its number.
    pub frame: i64,
    /// What stands under its picture, where it is not the number: the frame is then none of a sequence.
    pub label: Option<String>,
    /// Its picture; a frame without one is in the curves only.
    pub image: Option<Image>,
    /// The solid's volume.
    pub volume: f64,
    /// The volume that changed since the frame before; none for the first.
    pub change: Option<f64>,
    /// That of a morph that moves, seen from a frame that moves with it.
    pub change_of_shape: Option<f64>,
    /// The number of connected pieces.
    pub pieces: usize,
}

/// The frames of a sequence, in their order.
#[derive(Clone, Debug, Default)]
pub struct ContactSheet {
    /// What the sheet shows, above everything; no line where it is empty.
    pub title: String,
    /// The frames.
    pub frames: Vec<SheetFrame>,
    /// How many pictures stand in a row; as many as make a wide sheet where it is not given.
    pub columns: Option<usize>,
}

impl ContactSheet {
    /// Puts the sheet together. There are curves only of a sequence, of two frames or more.
    pub fn compose(&self) -> Image {
        let pictures: Vec<(&SheetFrame, &Image)> =
            self.frames.iter().filter_map(|frame| frame.image.as_ref().map(|image| (frame, image))).collect();
        let cell_width = pictures.iter().map(|(_, image)| image.width()).max().unwrap_or(0);
        let cell_height = pictures.iter().map(|(_, image)| image.height()).max().unwrap_or(0);
        let columns = self.columns(pictures.len());
        let rows = pictures.len().div_ceil(columns);
        let row_height = cell_height + LINE + GAP;
        let is_sequence = self.frames.len() > 1 && self.frames.iter().all(|frame| frame.label.is_none());
        let curves = if is_sequence { self.curves() } else { Vec::new() };
        let least = if curves.is_empty() { 1 } else { LEAST_WIDTH };
        let width = (columns.min(pictures.len()) * (cell_width + GAP) + GAP).max(least);
        let heading = if self.title.is_empty() { 0 } else { LINE + GAP };
        let panel_top = GAP + heading + rows * row_height;
        let panel_height = if curves.is_empty() { 0 } else { curves.len() * (HEADING + PLOT) + LINE + GAP };
        let height = panel_top + if curves.is_empty() { 0 } else { panel_height + GAP };

        let mut sheet = Image::new(width, height, PAPER);
        text::draw(&mut sheet, GAP as i64, GAP as i64, &self.title, Style::Bold, Align::Left, INK);
        let indent = (width - (columns.min(pictures.len()) * (cell_width + GAP)).saturating_sub(GAP)) / 2;
        for (index, (frame, image)) in pictures.into_iter().enumerate() {
            let left = indent + index % columns * (cell_width + GAP);
            let top = GAP + heading + index / columns * row_height;
            sheet.paste(image, left + (cell_width - image.width()) / 2, top);
            let middle = (left + cell_width / 2) as i64;
            let under = (top + cell_height) as i64;
            let label = frame.label.clone().unwrap_or_else(|| frame.frame.to_string());
            text::draw(&mut sheet, middle, under, &label, Style::Plain, Align::Centre, INK);
        }
        if !curves.is_empty() {
            let panel = Image::new(width - 2 * GAP, panel_height, PANEL);
            sheet.paste(&panel, GAP, panel_top);
            self.draw_curves(&mut sheet, &curves, panel_top);
        }
        sheet
    }

    /// How many pictures stand in a row: about twice as many as there are rows, and no row nearly empty.
    fn columns(&self, pictures: usize) -> usize {
        if let Some(columns) = self.columns {
            return columns.max(1);
        }
        let about = (2.0 * pictures as f64).sqrt().ceil() as usize;
        let empty = |columns: usize| columns * pictures.div_ceil(columns) - pictures;
        (about.max(1)..=about + about / 2 + 1).min_by_key(|&columns| empty(columns)).unwrap_or(1)
    }

    fn curves(&self) -> Vec<Curve<'static>> {
        let changes: Vec<Option<f64>> = self.frames.iter().map(|frame| frame.change).collect();
        let volumes: Vec<Option<f64>> = self.frames.iter().map(|frame| Some(frame.volume)).collect();
        let pieces = self.frames.iter().map(|frame| Some(frame.pieces as f64)).collect();
        let of_shape: Vec<Option<f64>> = self.frames.iter().map(|frame| frame.change_of_shape).collect();
        let most = self.frames.iter().map(|frame| frame.volume).fold(0.0, f64::max);
        let limit = |values: &[Option<f64>]| {
            let known: Vec<f64> = values.iter().flatten().copied().collect();
            median_of_moving(&known, most).map(|median| POP * median)
        };
        let mut curves = vec![Curve { title: "volume", values: volumes, limit: None, whole: false }];
        if of_shape.iter().any(Option::is_some) {
            // Where the whole moves, a pop is one of its shape.
            let title = "change of shape, seen from a frame that moves with it (dashes: twice the median)";
            curves.push(Curve { title, limit: limit(&of_shape), values: of_shape, whole: false });
            let title = "change from the frame before, its way included";
            curves.push(Curve { title, values: changes, limit: None, whole: false });
        } else {
            let title = "change from the frame before (dashes: twice the median of frames that move)";
            curves.push(Curve { title, limit: limit(&changes), values: changes, whole: false });
        }
        curves.push(Curve { title: "pieces", values: pieces, limit: None, whole: true });
        curves
    }

    fn draw_curves(&self, sheet: &mut Image, curves: &[Curve<'_>], top: usize) {
        let numbers: Vec<i64> = self.frames.iter().map(|frame| frame.frame).collect();
        let left = GAP + AXIS;
        let width = sheet.width().saturating_sub(left + 3 * GAP);
        for (index, curve) in curves.iter().enumerate() {
            let field = Field { left, top: top + index * (HEADING + PLOT) + HEADING, width, height: PLOT };
            curve.draw(sheet, field);
            if index + 1 == curves.len() {
                frame_axis(sheet, field, &numbers);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn frame(number: i64, pixels: usize) -> SheetFrame {
        let image = Some(Image::new(pixels, pixels, [number as u8, 0, 0, 255]));
        let change = (number > 1).then_some(0.1);
        SheetFrame { frame: number, label: None, image, volume: 1.0, change, change_of_shape: None, pieces: 1 }
    }

    #[test]
    fn every_picture_is_on_the_sheet_once() {
        let frames: Vec<SheetFrame> = (1..=13).map(|number| frame(number, 40)).collect();
        for columns in [None, Some(1), Some(5), Some(0)] {
            let sheet = ContactSheet { title: "test".into(), frames: frames.clone(), columns }.compose();
            for number in 1..=13 {
                let count = sheet.pixels().iter().filter(|&&pixel| pixel == [number, 0, 0, 255]).count();
                assert_eq!(count, 1600, "frame {number} in {columns:?} columns");
            }
        }
    }

    #[test]
    fn sheets_of_little_are_still_sheets() {
        assert!(ContactSheet::default().compose().encode_png().is_ok());
        let one = ContactSheet { frames: vec![frame(7, 30)], ..Default::default() }.compose();
        assert!(one.height() < 100, "one frame has no curves");
        let named = SheetFrame { label: Some("a".into()), ..frame(7, 30) };
        let named = ContactSheet { frames: vec![named.clone(), named], ..Default::default() }.compose();
        assert!(named.height() < 100, "what is no sequence has no curves");
        let blind = SheetFrame { image: None, ..frame(2, 1) };
        let curves_only = ContactSheet { frames: vec![blind.clone(), blind], ..Default::default() }.compose();
        assert_eq!(curves_only.width(), LEAST_WIDTH);
    }

    #[test]
    fn rows_are_even() {
        let columns = |pictures| ContactSheet::default().columns(pictures);
        assert_eq!([1, 2, 8, 9, 12, 24, 48].map(columns), [2, 2, 4, 5, 6, 8, 12]);
    }

    #[test]
    fn frames_that_rest_make_no_pops_of_those_that_move() {
        let limit = |changes: &[f64]| {
            let first = SheetFrame { change: None, ..frame(1, 1) };
            let frames = changes.iter().map(|&change| SheetFrame { change: Some(change), ..frame(2, 1) });
            let sheet = ContactSheet { frames: [first].into_iter().chain(frames).collect(), ..Default::default() };
            sheet.curves()[1].limit
        };
        // Held for most of the shot, by rounding only nearly so.
        assert_eq!(limit(&[0.0, 0.0, 1e-9, 0.0, 0.25, 0.5, 0.25, 0.0, 0.0]), Some(0.5));
        assert_eq!(limit(&[3.0, f64::NAN, 1.0, 2.0]), Some(4.0));
        assert_eq!(limit(&[0.0, 0.0]), None);
    }
}
