//! Metadata of files and grids: named values, sorted by name.

use std::collections::BTreeMap;
use std::fmt;

use serde::Serialize;

use super::bridge::ffi;

/// A metadata value.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum MetadataValue {
    /// Text.
    Text(String),
    /// True or false.
    Bool(bool),
    /// A 32-bit integer.
    Int32(i32),
    /// A 64-bit integer.
    Int64(i64),
    /// A 32-bit number.
    Float(f32),
    /// A 64-bit number.
    Double(f64),
}

/// Named values. For Houdini's sake keep to lower-case identifiers, and leave `is_…` to truth values.
pub type Metadata = BTreeMap<String, MetadataValue>;

/// A text of metadata.
pub fn metadata_text<'m>(metadata: &'m Metadata, name: &str) -> Option<&'m str> {
    match metadata.get(name) {
        Some(MetadataValue::Text(text)) => Some(text),
        _ => None,
    }
}

/// The key of a grid's metadata that names the space of its colours, as OpenColorIO, OpenEXR and USD have it.
pub const INTEROP_ID: &str = "colorInteropID";

macro_rules! from {
    ($($from:ty => $variant:ident),*) => {
        $(impl From<$from> for MetadataValue {
            fn from(value: $from) -> Self {
                Self::$variant(value.into())
            }
        })*
    };
}
from!(String => Text, &str => Text, bool => Bool, i32 => Int32, i64 => Int64, f32 => Float, f64 => Double);

/// The items as the bridge takes them.
pub(super) fn to_bridge(metadata: &Metadata) -> Vec<ffi::Meta> {
    metadata
        .iter()
        .map(|(key, value)| {
            let mut item =
                ffi::Meta { key: key.clone(), kind: ffi::MetaKind::Text, text: String::new(), integer: 0, real: 0.0 };
            match value {
                MetadataValue::Text(text) => item.text.clone_from(text),
                MetadataValue::Bool(value) => (item.kind, item.integer) = (ffi::MetaKind::Bool, i64::from(*value)),
                MetadataValue::Int32(value) => (item.kind, item.integer) = (ffi::MetaKind::Int32, i64::from(*value)),
                MetadataValue::Int64(value) => (item.kind, item.integer) = (ffi::MetaKind::Int64, *value),
                MetadataValue::Float(value) => (item.kind, item.real) = (ffi::MetaKind::Float, f64::from(*value)),
                MetadataValue::Double(value) => (item.kind, item.real) = (ffi::MetaKind::Double, *value),
            }
            item
        })
        .collect()
}

impl fmt::Display for MetadataValue {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Text(value) => value.fmt(f),
            Self::Bool(value) => value.fmt(f),
            Self::Int32(value) => value.fmt(f),
            Self::Int64(value) => value.fmt(f),
            Self::Float(value) => value.fmt(f),
            Self::Double(value) => value.fmt(f),
        }
    }
}
