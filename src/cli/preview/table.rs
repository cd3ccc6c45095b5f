//! What is counted of frames, as a table for other programs.

use std::fmt::Write;
use std::path::Path;

use crate::cli::failure::Failure;
use crate::disk;
use crate::render::SheetFrame;

/// A CSV file in the making.
pub struct Table(String);

impl Table {
    /// Nothing but its first line.
    pub fn new() -> Self {
        Self("frame,volume,area,pieces,change,change_of_shape\n".into())
    }

    /// A line.
    pub fn add(&mut self, frame: &SheetFrame, area: f64) {
        let name = frame.label.as_ref().map_or_else(|| frame.frame.to_string(), |label| quoted(label));
        let [change, of_shape] = [frame.change, frame.change_of_shape]
            .map(|change| change.map_or_else(String::new, |change| change.to_string()));
        // Writing to a string cannot fail.
        let _ = writeln!(self.0, "{name},{},{area},{},{change},{of_shape}", frame.volume, frame.pieces);
    }

    /// Writes the file; one that is there is replaced.
    pub fn write(&self, file: &Path) -> Result<(), Failure> {
        disk::write_whole(file, self.0.as_bytes()).map_err(|error| Failure::work(error.to_string()))
    }
}

/// A text as one field.
fn quoted(text: &str) -> String {
    if text.contains([',', '"', '\n']) { format!("\"{}\"", text.replace('"', "\"\"")) } else { text.into() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_each() {
        let mut table = Table::new();
        let frame = |label: Option<&str>, change| SheetFrame {
            frame: 7,
            label: label.map(String::from),
            image: None,
            volume: 1.5,
            change,
            change_of_shape: change.map(|change| 0.5 * change),
            pieces: 2,
        };
        table.add(&frame(None, Some(0.25)), 6.0);
        table.add(&frame(Some("c=[1, 2]"), None), 6.5);
        assert_eq!(
            table.0,
            "frame,volume,area,pieces,change,change_of_shape\n7,1.5,6,2,0.25,0.125\n\"c=[1, 2]\",1.5,6.5,2,,\n"
        );
    }
}
