//! The bytes of an EXR file.

use std::io::Cursor;

use exr::prelude::*;

use super::error::PictureError;

/// A channel: one value a pixel, the top row first.
pub(super) enum Values<'a> {
    /// Kept in 16 bits.
    Half(&'a [f32]),
    /// Kept in 32 bits.
    Full(&'a [f32]),
}

/// One part of channels by their names.
///
/// # Errors
/// [`PictureError::Size`] and [`PictureError::Exr`].
pub(super) fn encode(
    [width, height]: [usize; 2],
    channels: Vec<(String, Values<'_>)>,
    comments: Option<&str>,
) -> std::result::Result<Vec<u8>, PictureError> {
    if width.min(height) == 0 {
        return Err(PictureError::Size { width, height });
    }
    let channels = channels.into_iter().map(|(name, values)| {
        let samples = match values {
            Values::Half(values) => FlatSamples::F16(values.iter().copied().map(f16::from_f32).collect()),
            Values::Full(values) => FlatSamples::F32(values.to_vec()),
        };
        AnyChannel::new(name.as_str(), samples)
    });
    let encoding =
        Encoding { compression: Compression::ZIP16, blocks: Blocks::ScanLines, line_order: LineOrder::Increasing };
    let attributes = LayerAttributes { comments: comments.map(Text::from), ..LayerAttributes::default() };
    let layer = Layer::new((width, height), attributes, encoding, AnyChannels::sort(channels.collect()));
    let mut bytes = Cursor::new(Vec::new());
    Image::from_layer(layer).write().non_parallel().to_buffered(&mut bytes).map_err(PictureError::Exr)?;
    Ok(bytes.into_inner())
}
