//! Pictures from all around one frame.

use super::picture::Painter;
use super::source::Source;
use super::target::Writer;
use super::{Arguments, Target};
use crate::bake::Interrupt;
use crate::cli::failure::Failure;
use crate::cli::options::Global;
use crate::cli::signals;
use crate::grid::measure;
use crate::render::{ContactSheet, SheetFrame};

/// Makes the pictures, and writes what is made of them.
pub fn show(
    arguments: &Arguments,
    target: &Target,
    source: &Source<'_>,
    pictures: u32,
    interrupt: &Interrupt,
    global: &Global,
) -> Result<(), Failure> {
    if source.numbers.len() > 1 {
        let problem = format!("--turntable goes around one frame, and {} has {}", source.name, source.numbers.len());
        return Err(Failure::usage(format!("{problem}: name one with --frames")));
    }
    let shown = (source.compute)(0)?;
    if !measure::has_inside(&shown.band) && !arguments.allow_empty {
        return Err(Failure::work(format!("{}: nothing is inside, so there is nothing to show", source.name)));
    }
    let count = pictures as usize;
    let numbers: Vec<i64> = (1..=i64::from(pictures)).collect();
    let size = arguments.size(target, count);
    let mut writer = Writer::new(target, &numbers, count, size)?;
    let mut painter = Painter::new(arguments, source, size, arguments.quality(target))?;
    let (volume, pieces) = (measure::volume(&shown.band), measure::pieces(&shown.band).len());
    let mut frames = Vec::with_capacity(count);
    for (place, number) in numbers.iter().enumerate() {
        if interrupt.is_raised() {
            return Err(signals::interrupted());
        }
        let degrees = 360.0 * place as f64 / f64::from(pictures);
        painter.around = Some(degrees);
        let label = format!("{:.0} deg", arguments.turn + degrees);
        let image = writer.take(&mut painter, &shown, *number)?;
        frames.push(SheetFrame {
            frame: *number,
            label: Some(label),
            image,
            volume,
            change: None,
            change_of_shape: None,
            pieces,
        });
    }
    let columns = arguments.columns.map(|columns| columns as usize);
    let sheet = ContactSheet { title: source.name.clone(), frames, columns };
    let paths = writer.finish(&sheet)?;
    super::report(&paths, &sheet, global)
}
