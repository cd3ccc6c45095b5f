//! Numbers out of a file's buffers: nothing that they say of themselves is believed.

use super::super::Problem;
use super::super::read::shown;
use super::document::Sparse;
use super::{File, missing, unread_extension};

/// Values that an accessor without a buffer may announce, all of which are 0.
const MOST_ZEROS: usize = 1 << 22;

impl File<'_> {
    /// The values of an accessor of `N` numbers each.
    pub fn numbers<const N: usize>(&self, accessor: usize) -> Result<Vec<[f64; N]>, Problem> {
        let found = self.root.accessors.get(accessor).ok_or_else(|| missing("accessor", accessor))?;
        let kind = ["SCALAR", "VEC2", "VEC3", "VEC4"][N - 1];
        if found.kind != kind {
            return Err(Problem::malformed(format!("accessor {accessor} is `{}`, not {kind}", shown(&found.kind))));
        }
        let size = size_of(found.component_type)?;
        let number = |bytes: &[u8]| component(bytes, found.component_type, found.normalized);
        let mut values = match found.buffer_view {
            Some(view) => {
                let items = self.items(view, found.byte_offset, found.count, N * size)?;
                items.map(|item| std::array::from_fn(|i| number(&item[i * size..]))).collect()
            }
            None if found.count <= MOST_ZEROS => vec![[0.0; N]; found.count],
            None => return Err(Problem::malformed(format!("accessor {accessor} announces {} zeros", found.count))),
        };
        if let Some(Sparse { count, indices, values: changed }) = &found.sparse {
            let wide = size_of(indices.component_type)?;
            let places = self.items(indices.buffer_view, indices.byte_offset, *count, wide)?;
            let changes = self.items(changed.buffer_view, changed.byte_offset, *count, N * size)?;
            for (place, item) in places.zip(changes) {
                let at = component(place, indices.component_type, false) as usize;
                let value = values.get_mut(at).ok_or_else(|| missing("value", at))?;
                *value = std::array::from_fn(|i| number(&item[i * size..]));
            }
        }
        Ok(values)
    }

    pub fn indices(&self, accessor: usize) -> Result<Vec<u32>, Problem> {
        let kind = self.root.accessors.get(accessor).map_or(0, |accessor| accessor.component_type);
        if ![5121, 5123, 5125].contains(&kind) {
            return Err(Problem::malformed(format!("accessor {accessor} has indices that are no whole numbers")));
        }
        Ok(self.numbers::<1>(accessor)?.into_iter().map(|[number]| number as u32).collect())
    }

    /// So many items of a view, of some bytes each.
    fn items(
        &self,
        view: usize,
        offset: usize,
        count: usize,
        size: usize,
    ) -> Result<impl Iterator<Item = &[u8]>, Problem> {
        let bytes = self.view(view)?;
        let stride = match self.root.buffer_views[view].byte_stride {
            0 => size,
            stride => stride,
        };
        let end = count
            .checked_sub(1)
            .map(|last| last.checked_mul(stride).and_then(|last| last.checked_add(offset)?.checked_add(size)));
        let short = || Problem::CutShort(format!("view {view} is shorter than what is read from it"));
        match end {
            Some(end) if end.is_none_or(|end| end > bytes.len()) => Err(short()),
            _ => Ok((0..count).map(move |i| &bytes[offset + i * stride..offset + i * stride + size])),
        }
    }

    pub fn view(&self, number: usize) -> Result<&[u8], Problem> {
        let view = self.root.buffer_views.get(number).ok_or_else(|| missing("view", number))?;
        if view.extensions.get("EXT_meshopt_compression").is_some() {
            return Err(unread_extension("EXT_meshopt_compression"));
        }
        let buffer = self.buffers.get(view.buffer).ok_or_else(|| missing("buffer", view.buffer))?;
        let end = view.byte_offset.checked_add(view.byte_length);
        let bytes = end.and_then(|end| buffer.get(view.byte_offset..end));
        bytes.ok_or_else(|| Problem::CutShort(format!("view {number} reaches beyond its buffer")))
    }
}

/// Bytes of a component.
fn size_of(kind: u32) -> Result<usize, Problem> {
    match kind {
        5120 | 5121 => Ok(1),
        5122 | 5123 => Ok(2),
        5125 | 5126 => Ok(4),
        _ => Err(Problem::malformed(format!("has numbers of kind {kind}, which there is not"))),
    }
}

/// A number of `bytes`, which are enough of them.
fn component(bytes: &[u8], kind: u32, normalized: bool) -> f64 {
    let share = |value: f64, most: f64| if normalized { (value / most).max(-1.0) } else { value };
    match kind {
        5120 => share(f64::from(bytes[0] as i8), 127.0),
        5121 => share(f64::from(bytes[0]), 255.0),
        5122 => share(f64::from(i16::from_le_bytes([bytes[0], bytes[1]])), 32767.0),
        5123 => share(f64::from(u16::from_le_bytes([bytes[0], bytes[1]])), 65535.0),
        5125 => f64::from(u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]])),
        _ => f64::from(f32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]])),
    }
}
