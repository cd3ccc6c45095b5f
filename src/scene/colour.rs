//! Colours as a scene writes them, turned into scene-linear Rec.709.

use crate::attribute::LinearRgb;

use super::diagnostic::{Diagnostic, clip, nearest};
use super::reader::Reader;
use super::value::{Data, Value};

/// The colour of a shape without one beside coloured ones: sRGB `#cccccc`.
pub const GREY: &str = "#cccccc";

/// Decodes one sRGB component from 0 to 1 (IEC 61966-2-1). With the `libm` crate, so that every machine gets the
/// same bits.
pub fn linear_of_srgb(encoded: f64) -> f32 {
    let linear = if encoded <= 0.04045 { encoded / 12.92 } else { libm::pow((encoded + 0.055) / 1.055, 2.4) };
    linear as f32
}

/// `#rgb`, `#rrggbb`, a CSS name or a CSS function such as `rgb(…)`; `None` where it is none of them.
pub fn css(text: &str) -> Option<LinearRgb> {
    let is_hex = text.starts_with('#');
    let is_name = csscolorparser::NAMED_COLORS.entries().any(|(name, _)| name.as_str().eq_ignore_ascii_case(text));
    if !(is_hex || is_name || text.contains('(')) {
        return None;
    }
    let colour = csscolorparser::parse(text).ok()?;
    // Hex digits are exact eighths of a byte; the parser holds them in `f32`.
    let component = |value: f32| {
        let byte = f64::from(value) * 255.0;
        linear_of_srgb(if (byte - byte.round()).abs() < 1e-4 { byte.round() / 255.0 } else { f64::from(value) })
    };
    (colour.a == 1.0).then(|| [component(colour.r), component(colour.g), component(colour.b)])
}

/// The error about a text that is no colour, with the nearest of the scene's names and CSS's.
pub fn not_a_colour(text: &str, value: &Value, names: &[String]) -> Diagnostic {
    let diagnostic = Diagnostic::error(value.span, format!("`{}` is not a colour", clip(text)));
    let css = csscolorparser::NAMED_COLORS.entries().map(|(name, _)| name.as_str());
    match nearest(text, names.iter().map(String::as_str).chain(css)) {
        Some(name) => diagnostic.help(format!("did you mean `{name}`?")),
        None => {
            diagnostic.help("a colour is \"#rrggbb\", a CSS name, [r, g, b] from 0 to 1, or { linear = [r, g, b] }")
        }
    }
}

/// `[r, g, b]` from 0 to 1, sRGB.
pub fn srgb_list(reader: &Reader<'_>, name: &str, value: &Value) -> Option<LinearRgb> {
    let three = reader.three(name, value)?;
    let component = |part: &Value| match part.number() {
        Some(encoded) if (0.0..=1.0).contains(&encoded) => Some(linear_of_srgb(encoded)),
        Some(_) => {
            reader.say(
                Diagnostic::error(part.span, format!("`{}` must be from 0 to 1", clip(name)))
                    .help("brighter colours are written { linear = [r, g, b] }"),
            );
            None
        }
        None => {
            reader.wrong_kind(name, "three numbers", part);
            None
        }
    };
    let parts = [component(&three[0]), component(&three[1]), component(&three[2])];
    Some([parts[0]?, parts[1]?, parts[2]?])
}

/// The numbers of `{ linear = [r, g, b] }`, each 0 or greater.
pub fn linear_list(reader: &Reader<'_>, name: &str, value: &Value) -> Option<LinearRgb> {
    let three = reader.three(name, value)?;
    let mut colour = [0.0; 3];
    for (component, part) in colour.iter_mut().zip(three) {
        *component = match part.data {
            Data::Integer(_) | Data::Float(_) => {
                reader.constant(name, super::keys::Limit::Within(0.0, f64::from(u16::MAX)), part) as f32
            }
            _ => {
                reader.wrong_kind(name, "three numbers", part);
                return None;
            }
        };
    }
    Some(colour)
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
        // The worked values of IEC 61966-2-1 for bytes 0xbc and 0x0a.
        let [r, g, _] = css("#bc0a00").unwrap();
        assert!((r - 0.502_886_5).abs() < 1e-6, "{r}");
        assert!((g - 0.003_035_27).abs() < 1e-7, "{g}");
        assert_eq!(css("rgb(188, 10, 0)"), css("#bc0a00"));
    }

    #[test]
    fn what_is_no_colour() {
        for bad in ["", "reddish", "ff0000", "#ff00", "#gg0000", "#ff000080", "rgb(", "transparent"] {
            assert_eq!(css(bad), None, "{bad}");
        }
    }
}
