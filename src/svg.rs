//! What an SVG drawing fills: its paths and basic shapes, and its strokes as the areas that they cover.
//!
//! Styles, transforms, `use`, units and the page are resolved by usvg. Colours do not count: what is painted in any of them
//! is filled. Not read: text (turn it into paths), pictures, and what clips, masks, filters and patterns do.

use glam::DVec2;
use usvg::tiny_skia_path::{Path, PathSegment, Point};
use usvg::{FillRule, Group, ImageHrefResolver, Node, Options, Tree};

use crate::field::{Drawing, Fill};

/// How far curves may be off, of the longer side of the page.
const TOLERANCE: f64 = 1e-5;

/// Corners of all paths together.
const MOST_CORNERS: usize = 2_000_000;

/// What a drawing fills.
#[derive(Clone, Debug)]
pub struct Svg {
    /// Loops around it with the inside on the left, y up, the page's middle at the origin, in pixels.
    pub loops: Vec<Vec<[f64; 2]>>,
    /// The page's width and height.
    pub page: DVec2,
    /// Whether something of it is not read.
    pub leaves_out: Option<&'static str>,
}

/// Reads a drawing.
///
/// # Errors
/// What is wrong with it, in words.
pub fn read(content: &[u8]) -> Result<Svg, String> {
    if content.starts_with(&[0x1f, 0x8b]) {
        return Err("it is compressed: unpack it with gunzip first".into());
    }
    let options = Options {
        // A drawing names no further files.
        image_href_resolver: ImageHrefResolver {
            resolve_data: Box::new(|_, _, _| None),
            resolve_string: Box::new(|_, _| None),
        },
        ..Options::default()
    };
    let tree = Tree::from_data(content, &options).map_err(|error| match error {
        usvg::Error::NotAnUtf8Str => "it is not UTF-8 text: save it as plain SVG".into(),
        usvg::Error::ElementsLimitReached => "it has more than a million elements: simplify it".into(),
        usvg::Error::InvalidSize => {
            "it has no size: give its `svg` element a `width` and `height`, or a `viewBox`".into()
        }
        error => format!("it is no SVG drawing: {error}"),
    })?;
    let page = DVec2::new(tree.size().width().into(), tree.size().height().into());
    let mut reader = Reader { page, drawing: Drawing::new(0.0), leaves_out: None };
    reader.group(tree.root())?;
    // What overlaps of two paths is filled once.
    Ok(Svg { loops: reader.drawing.filled(Fill::NonZero), page, leaves_out: reader.leaves_out })
}

struct Reader {
    page: DVec2,
    drawing: Drawing,
    leaves_out: Option<&'static str>,
}

impl Reader {
    fn group(&mut self, group: &Group) -> Result<(), String> {
        if group.clip_path().is_some() || group.mask().is_some() {
            self.leaves_out = Some("clips and masks are");
        }
        for node in group.children() {
            match node {
                Node::Group(group) => self.group(group)?,
                Node::Path(path) if path.is_visible() => self.path(path)?,
                Node::Path(_) => {}
                Node::Image(_) => self.leaves_out = Some("pictures are"),
                Node::Text(_) => self.leaves_out = Some("text is"),
            }
        }
        Ok(())
    }

    fn path(&mut self, path: &usvg::Path) -> Result<(), String> {
        let map = path.abs_transform();
        if let Some(fill) = path.fill() {
            let rule = match fill.rule() {
                FillRule::NonZero => Fill::NonZero,
                FillRule::EvenOdd => Fill::EvenOdd,
            };
            self.fill(path.data().clone().transform(map), rule)?;
        }
        if let Some(stroke) = path.stroke() {
            let stroke = stroke.to_tiny_skia();
            // So much finer than a pixel its curves are: as they are flattened here.
            let fine = (0.25 / (TOLERANCE * self.page.max_element())) as f32;
            let dashed = stroke.dash.as_ref().map(|dash| path.data().dash(dash, fine));
            let line = match dashed {
                Some(dashed) => dashed,
                None => Some(path.data().clone()),
            };
            let covered = line.and_then(|line| line.stroke(&stroke, fine)).and_then(|area| area.transform(map));
            self.fill(covered, Fill::NonZero)?;
        }
        Ok(())
    }

    fn fill(&mut self, path: Option<Path>, rule: Fill) -> Result<(), String> {
        let Some(path) = path else { return Ok(()) };
        let at =
            |point: Point| DVec2::new(f64::from(point.x) - self.page.x / 2.0, self.page.y / 2.0 - f64::from(point.y));
        let mut drawing = Drawing::new(TOLERANCE * self.page.max_element());
        for segment in path.segments() {
            match segment {
                PathSegment::MoveTo(to) => drawing.begin(at(to)),
                PathSegment::LineTo(to) => drawing.line(at(to)),
                PathSegment::QuadTo(control, to) => drawing.quadratic(at(control), at(to)),
                PathSegment::CubicTo(first, second, to) => drawing.cubic(at(first), at(second), at(to)),
                PathSegment::Close => {}
            }
            if drawing.corners() + self.drawing.corners() > MOST_CORNERS {
                return Err(format!("its curves have more than {MOST_CORNERS} corners: simplify it"));
            }
        }
        self.drawing.add(drawing.filled(rule));
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::{Field, Joined, outline};

    fn page(content: &str) -> String {
        format!("<svg xmlns='http://www.w3.org/2000/svg' width='10' height='10'>{content}</svg>")
    }

    fn value(content: &str, x: f64, y: f64) -> f64 {
        let svg = read(page(content).as_bytes()).unwrap();
        Joined::new(outline(&svg.loops).unwrap()).reference(glam::DVec3::new(x, y, 0.0))
    }

    /// The pixel's y goes down, the scene's up; 5, 5 is the middle of the page.
    #[test]
    fn shapes_strokes_rules_and_transforms() {
        assert!((value("<rect x='1' y='2' width='3' height='1'/>", -2.5, 2.5) - 0.5).abs() < 1e-6);
        assert!((value("<circle cx='5' cy='5' r='2'/>", 0.0, 0.0) - 2.0).abs() < 2e-4);
        let line = "<path d='M2 5 L8 5' stroke='red' stroke-width='2'/>";
        assert!((value(line, 0.0, 0.0) - 1.0).abs() < 1e-6 && (value(line, 0.0, 1.5) + 0.5).abs() < 1e-6);
        let nested = |rule: &str| format!("<path fill-rule='{rule}' d='M1 1H9V9H1z M3 3H7V7H3z'/>");
        assert!(value(&nested("nonzero"), 0.0, 0.0) > 3.9 && value(&nested("evenodd"), 0.0, 0.0) < -1.9);
        let moved = "<g transform='translate(2 0) scale(2)'><rect x='1' y='1' width='1' height='1'/></g>";
        assert!((value(moved, 0.0, 2.0) - 1.0).abs() < 1e-6);
        // Two shapes that overlap are one; what is not seen is none.
        let both = "<rect x='1' y='1' width='5' height='8'/><rect x='4' y='1' width='5' height='8' fill='white'/>";
        assert!((value(both, 0.0, 0.0) - 4.0).abs() < 1e-6);
        assert!(read(page("<rect width='5' height='5' fill='none'/>").as_bytes()).unwrap().loops.is_empty());
    }

    #[test]
    fn broken_drawings_are_told() {
        for content in ["", "<svg", "hello", "<html/>", "\u{1f}\u{8b}"] {
            assert!(read(content.as_bytes()).is_err(), "{content}");
        }
        assert!(read(&[0x1f, 0x8b, 8, 0]).unwrap_err().contains("gunzip"));
        let whole = page("<path d='M1 1C2 3 4 5 6 7S9 9 1 9z'/><use href='#a'/><image href='/etc/passwd'/>");
        for end in 0..whole.len() {
            let _ = read(&whole.as_bytes()[..end]);
        }
        assert!(read(page("<path d='M1e30 1e30 L-1e30 1e38 L1e-30 0z'/>").as_bytes()).is_ok());
    }
}
