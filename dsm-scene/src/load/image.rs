//! Alpha channels of images.

use std::io::Cursor;

use png::{ColorType, Decoder, Limits, Transformations};

use crate::alpha::AlphaTexture;
use crate::error::{Error, Place, Result};

/// An image may unpack to this many bytes.
const MAX_BYTES: usize = 1 << 30;

/// The channel of an image that holds opacity.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Channel {
    /// Alpha; images without it are opaque.
    Alpha,
    /// Alpha if there is one, brightness otherwise.
    AlphaOrBrightness,
}

/// The opacity of a PNG or, where only alpha counts, a JPEG, which has none;
/// `None` if it is opaque everywhere.
pub(super) fn decode(bytes: &[u8], channel: Channel) -> Result<Option<AlphaTexture>> {
    let broken = |error: png::DecodingError| Error::malformed(Place::Whole, error.to_string());
    if bytes.starts_with(&[0xff, 0xd8, 0xff]) && channel == Channel::Alpha {
        return Ok(None);
    }
    if !bytes.starts_with(b"\x89PNG\r\n\x1a\n") {
        let reason = "an opacity image must be a PNG";
        return Err(Error::malformed(Place::Header, reason));
    }
    let mut decoder = Decoder::new_with_limits(Cursor::new(bytes), Limits { bytes: MAX_BYTES });
    decoder.set_transformations(Transformations::EXPAND | Transformations::STRIP_16);
    let mut reader = decoder.read_info().map_err(broken)?;
    let size = reader.output_buffer_size().filter(|&size| size <= MAX_BYTES);
    let Some(size) = size else {
        return Err(Error::malformed(Place::Header, "the image is too large"));
    };
    let mut pixels = vec![0; size];
    let info = reader.next_frame(&mut pixels).map_err(broken)?;
    pixels.truncate(info.buffer_size());
    let alphas: Vec<u8> = match (info.color_type, channel) {
        (ColorType::GrayscaleAlpha, _) => pixels.chunks_exact(2).map(|pixel| pixel[1]).collect(),
        (ColorType::Rgba, _) => pixels.chunks_exact(4).map(|pixel| pixel[3]).collect(),
        (_, Channel::Alpha) => return Ok(None),
        (ColorType::Rgb, _) => pixels.chunks_exact(3).map(brightness).collect(),
        _ => pixels,
    };
    if alphas.iter().all(|&alpha| alpha == 255) {
        return Ok(None);
    }
    AlphaTexture::new(info.width, info.height, alphas).map(Some)
}

fn brightness(pixel: &[u8]) -> u8 {
    let sum: u32 = pixel.iter().map(|&part| u32::from(part)).sum();
    (sum / 3) as u8
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec2;

    fn image(colour: ColorType, pixels: &[u8]) -> Vec<u8> {
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, 2, 1);
        encoder.set_color(colour);
        let mut writer = encoder.write_header().unwrap();
        writer.write_image_data(pixels).unwrap();
        writer.finish().unwrap();
        bytes
    }

    #[test]
    fn opacity_is_alpha_or_brightness() {
        let left = |texture: Option<AlphaTexture>| texture.unwrap().sample(Vec2::new(0.25, 0.5));
        let rgba = image(ColorType::Rgba, &[0, 0, 0, 51, 0, 0, 0, 255]);
        assert_eq!(left(decode(&rgba, Channel::Alpha).unwrap()), 0.2);
        assert_eq!(left(decode(&rgba, Channel::AlphaOrBrightness).unwrap()), 0.2);
        let rgb = image(ColorType::Rgb, &[0, 51, 102, 255, 255, 255]);
        assert_eq!(decode(&rgb, Channel::Alpha).unwrap(), None);
        assert_eq!(left(decode(&rgb, Channel::AlphaOrBrightness).unwrap()), 0.2);
        let opaque = image(ColorType::Rgba, &[255; 8]);
        assert_eq!(decode(&opaque, Channel::Alpha).unwrap(), None);
        assert_eq!(decode(&[0xff, 0xd8, 0xff, 0xe0], Channel::Alpha).unwrap(), None);
    }

    #[test]
    fn broken_images_are_refused() {
        let whole = image(ColorType::Rgba, &[7; 8]);
        for length in 0..whole.len() - 12 {
            assert!(decode(&whole[..length], Channel::Alpha).is_err(), "{length} bytes");
        }
        assert!(decode(b"GIF89a", Channel::Alpha).is_err());
        // 2³¹ × 2³¹ pixels in 33 bytes.
        let mut huge = whole;
        huge[16..24].copy_from_slice(&[0x7f, 0xff, 0xff, 0xff, 0x7f, 0xff, 0xff, 0xff]);
        assert!(decode(&huge, Channel::Alpha).is_err());
    }
}
