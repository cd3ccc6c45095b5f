//! Letters of the plane.

use crate::field::{Fill, outline};
use crate::lettering::{Align, Error, Font, Setting, SizeOf};
use crate::node::profile::flat_import;
use crate::node::spec::{Import, Imported, Plane, Spec};
use crate::text::key::Absent::{Number, Required, Text, Words};
use crate::text::key::{Key, Kind, Limit};
use crate::text::problem::Problem;

/// Letters of the plane.
pub const NODE: Spec = Spec {
    key: Key::new(
        "text",
        Kind::Text,
        Required,
        "Letters: a text, of several lines where it has line breaks (`\\n`). They are kerned and joined as the font says. From the top of the first line's capitals to the last baseline it is as far up as down. Extruded it lies: `rotate = [90, 0, 0]` stands it up.",
    ),
    parameters: &[
        Key::new(
            "font",
            Kind::Path,
            Words("Noto Sans SemiBold, inside the program: Latin, Greek and Cyrillic letters"),
            "A font: TrueType or OpenType. Of a collection its first font, of a variable font its default style.",
        ),
        Key::new("size", Kind::Constant, Number(1.0), "The height of its letters.")
            .limit(Limit::Positive)
            .unit("units"),
        Key::new(
            "size_of",
            Kind::Choice(&["capitals", "em"]),
            Text("capitals"),
            "What `size` is the height of: a capital letter, or the em, as in typesetting.",
        ),
        Key::new(
            "align",
            Kind::Choice(&["left", "center", "right"]),
            Text("center"),
            "Where lines stand: they begin at x = 0, each is around it, or they end there.",
        ),
        Key::new(
            "line_spacing",
            Kind::Constant,
            Number(1.0),
            "From one baseline to the next, of the font's own distance.",
        )
        .limit(Limit::Positive),
        Key::new(
            "letter_spacing",
            Kind::Constant,
            Number(0.0),
            "What is added between letters; letters that the font would join stay apart.",
        )
        .unit("units"),
    ],
    formula: "the signed distance to its outlines, which are filled where they wind around a point, curves of straight pieces within 2e-5 of the em",
    source: "OpenType; Noto Sans under the SIL Open Font License",
    example: "text = \"So8\"\nsize = 0.9",
    plane: Plane::Flat,
    import: Some(import),
    build: |build| build.imported_field(),
    ..Spec::PLAIN
};

/// Fonts of all the world's letters have some 30 MiB.
const MOST_BYTES: u64 = 256 << 20;

fn import(import: &Import<'_>) -> Result<Imported, Problem> {
    let arguments = import.arguments;
    let (text, span) = arguments.text("text").expect("it must be there");
    let file = arguments.file("font");
    let font = match file {
        Some(file) => Font::new(file.read_at_most(MOST_BYTES)?).ok_or_else(|| {
            file.problem("it is no font that can be read")
                .help("a TrueType or OpenType font: .ttf, .otf, .ttc; unpack a .woff2 first")
        })?,
        None => Font::built_in(),
    };
    let constant = |key: &str| *arguments.constant(key).expect("it has a default");
    let setting = Setting {
        size: constant("size"),
        size_of: if arguments.choice("size_of") == Some(&"em") { SizeOf::Em } else { SizeOf::Capitals },
        align: match arguments.choice("align") {
            Some(&"left") => Align::Left,
            Some(&"right") => Align::Right,
            _ => Align::Center,
        },
        line_spacing: constant("line_spacing"),
        letter_spacing: constant("letter_spacing"),
    };
    let named = file.map_or_else(|| "the built-in font".to_owned(), |file| file.name());
    let drawing = font.set(text, &setting).map_err(|error| match error {
        Error::NoGlyph(letter) => {
            let number = u32::from(letter);
            Problem::new(span, format!("{named} has no glyph for {letter:?} (U+{number:04X})"))
                .help("leave it out, or name a font that has it: font = \"file.ttf\"")
        }
        Error::BrokenGlyph(letter) => {
            Problem::new(span, format!("the glyph of {letter:?} is broken in {named}")).help("another font")
        }
        Error::NoShape => Problem::new(span, format!("{named} cannot set this text")).help("another font"),
        Error::TooLong => Problem::new(span, "there are too many letters").help("a shorter text, or several shapes"),
    })?;
    let outline = outline(&drawing.filled(Fill::NonZero));
    let outline = outline.ok_or_else(|| {
        Problem::new(span, "`text` draws nothing").help("give it letters, digits or signs, such as text = \"Ag8\"")
    })?;
    Ok(flat_import(outline))
}
