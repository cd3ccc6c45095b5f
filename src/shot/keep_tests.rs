//! Which pieces of a frame stay.

use std::sync::atomic::AtomicBool;

use crate::distance::band::{Feet, MeasuredBlock, Settings};
use crate::distance::without::measure_kept;
use crate::grid::measure::pieces;
use crate::shot::frame_tests::prepared_with;
use crate::text::builtin_text;

/// A mixture of two structures, of which nearly every frame has crumbs that touch others along edges.
#[test]
fn one_piece_is_kept_of_what_falls_apart() {
    let text = builtin_text("microstructure").expect("a scene");
    let scene = prepared_with(text, Some(48)).unwrap_or_else(|error| panic!("{error}"));
    for frame in [14, 17, 21] {
        let content = scene.frame(frame).expect("a frame");
        let settings = Settings {
            lattice: scene.lattice,
            half_width: scene.half_width,
            region: content.region,
            feet: Feet::Nearest,
            cancel: &AtomicBool::new(false),
            progress: &|_| {},
        };
        let measured = measure_kept(&*content.field, &settings, content.keep, || |_: &MeasuredBlock| ());
        let measured = measured.unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(pieces(&measured.band).len(), 1, "frame {frame}");
        assert!(measured.report.dropped.pieces > 1);
    }
}
