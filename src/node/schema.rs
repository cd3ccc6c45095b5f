//! JSON Schema of the scene format, for editors that complete and check TOML or JSON: made from the tables that scenes are
//! checked by. What hangs on several keys at once is left to `hfvdb check`.

use serde_json::{Map, Value, json};

use super::keys;
use super::list::{COLOURS, MAKERS, MODIFIERS, PLACERS, SCALARS};
use super::source::Source;
use super::spec::Spec;
use crate::text::key::{Absent, Key, Kind, Limit};

/// The schema, Draft 2020-12.
pub fn schema() -> Value {
    let named = |of: Value| json!({ "type": "object", "additionalProperties": of });
    let mut top = properties(keys::SCENE.iter());
    for (name, of) in [
        ("shape", named(reference("shape"))),
        ("cells", named(reference("cells"))),
        ("operation", named(closed(properties(keys::OPERATION.iter())))),
        ("import", named(json!({ "type": "string" }))),
        ("param", named(json!({}))),
        ("palette", named(json!({ "type": "array", "items": reference("color") }))),
        ("color", named(reference("color"))),
        ("morph", closed(properties(keys::morph_keys()))),
        ("output", closed(properties(keys::OUTPUT.iter()))),
        ("variant", named(json!({ "type": "object" }))),
    ] {
        if let Some(property) = top.get_mut(name).and_then(Value::as_object_mut) {
            property.extend(of.as_object().cloned().unwrap_or_default());
        }
    }
    let mut scene = closed(top);
    scene["$schema"] = json!("https://json-schema.org/draft/2020-12/schema");
    scene["title"] = json!("hfvdb scene");
    scene["$defs"] = json!({
        "color": source(COLOURS, &json!([{ "type": "string" }, { "type": "array", "minItems": 3, "maxItems": 3 }])),
        "scalar": source(SCALARS, &json!([number()])),
        "cells": closed(properties(keys::CELLS.iter())),
        "shape": shape(),
        "step": step(),
    });
    scene
}

/// A number, a formula, or keys.
fn number() -> Value {
    json!({ "type": ["number", "string", "object"] })
}

fn reference(name: &str) -> Value {
    json!({ "$ref": format!("#/$defs/{name}") })
}

fn closed(properties: Map<String, Value>) -> Value {
    json!({ "type": "object", "properties": properties, "additionalProperties": false })
}

/// One thing that is done to a shape.
fn step() -> Value {
    let rows = MODIFIERS.iter().chain(PLACERS);
    let mut step = closed(properties(rows.clone().flat_map(Spec::keys)));
    step["oneOf"] = rows.map(|spec| json!({ "required": [spec.key.name] })).collect();
    step
}

fn shape() -> Value {
    let nodes = MAKERS.iter().chain(MODIFIERS).flat_map(Spec::keys);
    let mut shape = closed(properties(nodes.chain(keys::SHAPE)));
    shape["properties"]["attribute"]["additionalProperties"] = reference("scalar");
    // A shape is one thing: one of the nodes, or what an operation of the scene's own makes, whose keys only the scene knows.
    let is = |spec: &Spec| json!({ "required": [spec.key.name] });
    let nodes: Vec<Value> = MAKERS.iter().map(is).collect();
    shape["oneOf"] = nodes.iter().cloned().chain([json!({ "not": { "anyOf": nodes } })]).collect();
    shape["additionalProperties"] = json!({ "type": ["number", "string", "object", "array"] });
    shape
}

/// An attribute: written without a table, or a table of one of these rows.
fn source<const N: usize>(rows: &'static [Source<N>], plain: &Value) -> Value {
    let mut any = plain.as_array().cloned().unwrap_or_default();
    any.extend(rows.iter().map(|row| {
        let mut table = closed(properties(row.keys()));
        table["required"] = json!([row.key.name]);
        table["description"] = json!(row.key.text);
        table
    }));
    json!({ "anyOf": any })
}

fn properties<'k>(keys: impl Iterator<Item = &'k Key>) -> Map<String, Value> {
    let mut properties = Map::new();
    for key in keys {
        let known = property(key);
        for name in std::iter::once(&key.name).chain(key.also) {
            properties.entry(*name).or_insert_with(|| known.clone());
        }
    }
    properties
}

fn property(key: &Key) -> Value {
    let mut property = of_kind(key.kind);
    property["description"] = json!(key.text);
    match key.default {
        Absent::Number(value) => property["default"] = json!(value),
        Absent::Vector(value) => property["default"] = json!(value),
        Absent::Text(value) if key.kind == Kind::Flag => property["default"] = json!(value == "true"),
        Absent::Text(value) => property["default"] = json!(value),
        Absent::Required | Absent::Nothing | Absent::Of(..) | Absent::Words(_) => {}
    }
    // Limits of numbers as they are; formulas and keys are no numbers, which `minimum` leaves alone.
    match key.limit {
        Limit::Positive => property["exclusiveMinimum"] = json!(0),
        Limit::NotNegative => property["minimum"] = json!(0),
        Limit::Within(least, most) => {
            property["minimum"] = json!(least);
            property["maximum"] = json!(most);
        }
        Limit::Any | Limit::NotZero => {}
    }
    property
}

fn of_kind(kind: Kind) -> Value {
    let list = |least: usize, items: Value| json!({ "type": "array", "minItems": least, "items": items });
    match kind {
        Kind::Number | Kind::Progress | Kind::Delay => number(),
        Kind::Constant => json!({ "type": "number" }),
        Kind::Whole | Kind::Seed => json!({ "type": "integer" }),
        Kind::Vector | Kind::Components(_) | Kind::Formulas => {
            json!({ "type": "array", "minItems": 3, "maxItems": 3, "items": number() })
        }
        Kind::Pair => json!({ "type": ["number", "string", "object", "array"] }),
        Kind::Rows(least, _) => list(least, list(1, json!({ "type": "number" }))),
        Kind::Lengths => json!({ "type": ["number", "string", "object", "array"] }),
        Kind::Flag => json!({ "type": "boolean" }),
        Kind::Text | Kind::Path | Kind::Paths | Kind::Formula | Kind::Scalar => json!({ "type": "string" }),
        Kind::Choice(names) => json!({ "enum": names }),
        Kind::Distance(names) => json!({ "anyOf": [{ "enum": names }, closed(properties(keys::ADF.iter()))] }),
        Kind::Span | Kind::TwoNumbers | Kind::TwoColours => json!({ "type": "array", "minItems": 2, "maxItems": 2 }),
        Kind::Grids | Kind::Names => list(0, json!({ "type": "string" })),
        Kind::KeyFrames => list(2, json!({ "type": "integer" })),
        Kind::Frames => json!({ "type": ["integer", "string"] }),
        Kind::Depth => json!({ "type": ["integer", "array"] }),
        Kind::Shape | Kind::Cells => json!({ "type": ["string", "object"] }),
        Kind::ShapesOr(word) => json!({ "anyOf": [{ "const": word }, of_kind(Kind::Shapes(1))] }),
        Kind::OfSpace => number(),
        Kind::Shapes(least) => list(least, json!({ "type": ["string", "object"] })),
        Kind::TwoShapes => {
            json!({ "type": "array", "minItems": 2, "maxItems": 2, "items": { "type": ["string", "object"] } })
        }
        Kind::Goals => list(1, json!({ "type": ["string", "object"] })),
        Kind::ShapePairs => json!({ "anyOf": [{ "const": "auto" }, list(1, list(2, json!({ "type": "string" })))] }),
        Kind::PlacePairs => list(1, list(2, list(3, json!({ "type": "number" })))),
        Kind::Colour => reference("color"),
        Kind::Palette => json!({ "type": ["string", "array"] }),
        Kind::Counts => json!({ "type": ["integer", "array"] }),
        Kind::Places => json!({ "type": ["string", "array"] }),
        Kind::Direction => json!({ "anyOf": [{ "enum": ["x", "y", "z"] }, of_kind(Kind::Vector)] }),
        Kind::Steps => list(0, reference("step")),
        Kind::Bands | Kind::NumberBands | Kind::Stops | Kind::NumberStops => {
            list(1, json!({ "type": "array", "minItems": 2, "maxItems": 2 }))
        }
        Kind::Numbers => list(1, json!({ "type": "number" })),
        Kind::Box => json!({ "type": ["number", "array", "object"] }),
        Kind::Copies | Kind::Fill | Kind::Round | Kind::Table => json!({ "type": "object" }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_key_of_a_shape_is_in_the_schema() {
        let schema = schema();
        let shape = &schema["$defs"]["shape"]["properties"];
        for key in MAKERS.iter().chain(MODIFIERS).flat_map(Spec::keys) {
            assert!(shape[key.name]["description"].is_string(), "{}", key.name);
        }
        for name in ["shape", "morph", "output", "hfvdb"] {
            assert!(schema["properties"][name].is_object(), "{name}");
        }
        let text = schema.to_string();
        for name in schema["$defs"].as_object().unwrap().keys() {
            assert!(text.contains(&format!("#/$defs/{name}")), "nothing refers to `{name}`");
        }
        assert_eq!(schema["properties"]["morph"]["properties"]["octopus"]["default"], false);
        assert_eq!(schema["properties"]["morph"]["properties"]["mode"]["default"], "volume");
    }
}
