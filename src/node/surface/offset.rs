//! A shape grown by a distance.

use crate::field::Interval;
use crate::node::spec::Spec;
use crate::text::key::{Absent, Key, Kind};
use crate::text::number::NumberValue;

/// Grown on all sides.
pub const NODE: Spec = Spec {
    key: Key::new(
        "offset",
        Kind::Number,
        Absent::Number(0.0),
        "Grows the shape by this distance on all sides: its edges become round. A negative number shrinks it: its hollows do.",
    )
    .unit("units"),
    formula: "f + d, f the signed distance",
    example: "box = 1\noffset = 0.2",
    measures: |arguments| {
        let shrinks = |value: &NumberValue| matches!(value, NumberValue::Constant(by) if *by <= 0.0);
        arguments.number("offset").is_some_and(|offset| !shrinks(&offset.value))
    },
    build: |build| {
        let whole = build.inner()?;
        let (now, ever) = (build.number("offset")?, build.ever("offset")?);
        let distance = build.distance(whole, Interval::new(-ever.hi, -ever.lo), "offset")?;
        if now == 0.0 {
            return Ok(whole);
        }
        let grown = build.graph().offset(distance, now);
        Ok(build.held(grown, whole, now))
    },
    ..Spec::PLAIN
};
