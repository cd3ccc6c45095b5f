//! Colours as a scene writes them, turned into scene-linear Rec.709.

use crate::attribute::{Components, LinearRgb, from_srgb};

use crate::text::diagnostic::{Diagnostic, clip, nearest};
use crate::text::key::Limit;
use crate::text::reader::Reader;
use crate::text::source::Span;
use crate::text::value::{Data, Value};

/// The colour of a shape without one beside coloured ones: sRGB `#cccccc`.
pub const GREY: &str = "#cccccc";

/// `#rgb`, `#rrggbb`, a CSS name or a CSS function such as `rgb(…)`; `None` where it is none of them.
pub fn css(text: &str) -> Option<LinearRgb> {
    let is_hex = text.starts_with('#');
    let is_name = csscolorparser::NAMED_COLORS.entries().any(|(name, _)| name.as_str().eq_ignore_ascii_case(text));
    if !(is_hex || is_name || text.contains('(')) {
        return None;
    }
    let colour = csscolorparser::parse(text).ok()?;
    (colour.a == 1.0).then(|| from_srgb([colour.r, colour.g, colour.b]))
}

/// The error about a text that is no colour, with the nearest of the scene's names and CSS's.
pub fn not_a_colour(text: &str, value: &Value, names: &[String]) -> Diagnostic {
    let diagnostic = Diagnostic::error(value.span, format!("`{}` is not a colour", clip(text)));
    if css(&format!("#{text}")).is_some() {
        return diagnostic.help(format!("did you mean \"#{text}\"?"));
    }
    let css = csscolorparser::NAMED_COLORS.entries().map(|(name, _)| name.as_str());
    match nearest(text, names.iter().map(String::as_str).chain(css)) {
        Some(name) => diagnostic.help(format!("did you mean `{name}`?")),
        None => {
            diagnostic.help("a colour is \"#rrggbb\", a CSS name, [r, g, b] from 0 to 1, or { linear = [r, g, b] }")
        }
    }
}

/// What each of a colour's three numbers may be.
pub fn limits(meaning: Components) -> [Limit; 3] {
    const SHARE: Limit = Limit::Within(0.0, 1.0);
    match meaning {
        Components::Srgb => [SHARE; 3],
        Components::Linear => [Limit::Within(0.0, f64::from(u16::MAX)); 3],
        Components::Hsv => [Limit::Any, SHARE, SHARE],
    }
}

/// A colour of three numbers that stand still.
pub fn constant(reader: &Reader<'_>, name: &str, value: &Value, meaning: Components) -> Option<LinearRgb> {
    let three = reader.three(name, value)?;
    if let Some(problem) = of_bytes(name, three, value.span).filter(|_| meaning == Components::Srgb) {
        reader.say(problem);
        return None;
    }
    let mut numbers = [0.0; 3];
    let mut sound = true;
    for ((number, part), limit) in numbers.iter_mut().zip(three).zip(limits(meaning)) {
        match part.number() {
            Some(given) => match limit.out_of_range(given) {
                None => *number = given as f32,
                Some(wanted) => {
                    sound = false;
                    let problem = Diagnostic::error(part.span, format!("`{}` must be {wanted}", clip(name)));
                    let brighter = "brighter colours are written { linear = [r, g, b] }";
                    reader.say(if meaning == Components::Srgb { problem.help(brighter) } else { problem });
                }
            },
            None => {
                sound = false;
                reader.wrong_kind(name, "three numbers", part);
            }
        }
    }
    sound.then(|| meaning.colour(numbers))
}

/// The error about three whole numbers up to 255 that are hardly meant as shares.
fn of_bytes(name: &str, three: &[Value; 3], span: Span) -> Option<Diagnostic> {
    let mut bytes = [0; 3];
    for (byte, part) in bytes.iter_mut().zip(three) {
        let Data::Integer(whole) = part.data else { return None };
        *byte = u8::try_from(whole).ok()?;
    }
    let [red, green, blue] = bytes;
    (bytes.iter().filter(|byte| **byte > 1).count() > 1).then(|| {
        Diagnostic::error(span, format!("`{}` must be from 0 to 1, not to 255", clip(name)))
            .help(format!("write \"#{red:02x}{green:02x}{blue:02x}\""))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_become_linear() {
        assert_eq!(css("#ffffff"), Some([1.0, 1.0, 1.0]));
        assert_eq!(css("#fff"), Some([1.0, 1.0, 1.0]));
        assert_eq!(css("White"), Some([1.0, 1.0, 1.0]));
        assert_eq!(css("#000"), Some([0.0, 0.0, 0.0]));
        assert_eq!(css("#bc0a00"), Some(from_srgb([188.0 / 255.0, 10.0 / 255.0, 0.0])));
        assert_eq!(css("rgb(188, 10, 0)"), css("#bc0a00"));
    }

    #[test]
    fn what_is_no_colour() {
        for bad in ["", "reddish", "ff0000", "#ff00", "#gg0000", "#ff000080", "rgb(", "transparent"] {
            assert_eq!(css(bad), None, "{bad}");
        }
    }
}
