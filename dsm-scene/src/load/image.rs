//! Opacity out of images.

use std::io::Cursor;

use image::{DynamicImage, ImageDecoder, ImageFormat, ImageReader, Limits};

use super::warnings::one_line;
use crate::alpha::AlphaTexture;
use crate::error::{Error, Place, Result};

/// An image may unpack to this many bytes.
const MAX_BYTES: u64 = 1 << 30;
/// Nor to more than this for each byte of its file, on top of [`FREE_BYTES`]: masks that
/// are nearly empty are packed that well, and no small file fills the memory.
const BYTES_PER_BYTE: u64 = 1 << 15;
const FREE_BYTES: u64 = 1 << 26;

/// The channel of an image that holds opacity.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Channel {
    /// Alpha; images without it are opaque.
    Alpha,
    /// Alpha where there is one that is not opaque everywhere, brightness otherwise.
    AlphaOrBrightness,
    /// The mean of red, green and blue.
    Brightness,
    /// Red, or the only channel.
    Red,
    /// Green, or the only channel.
    Green,
    /// Blue, or the only channel.
    Blue,
}

/// The opacity of an image, BMP, JPEG, PNG, TGA or WebP; `None` if it is opaque
/// everywhere. A TGA is told by its `extension`: it has no mark of its own. `check` is
/// asked before that many bytes are unpacked.
pub(super) fn decode(
    bytes: &[u8],
    extension: Option<&str>,
    channel: Channel,
    check: impl FnOnce(u64) -> Result<()>,
) -> Result<Option<AlphaTexture>> {
    let broken =
        |error: image::ImageError| Error::malformed(Place::Whole, one_line(&error.to_string()));
    let format = match image::guess_format(bytes) {
        Ok(format) => format,
        Err(_) if extension == Some("tga") => ImageFormat::Tga,
        Err(_) => return Err(unknown()),
    };
    if format == ImageFormat::Jpeg && channel == Channel::Alpha {
        return Ok(None);
    }
    let mut reader = ImageReader::with_format(Cursor::new(bytes), format);
    let most = BYTES_PER_BYTE.saturating_mul(bytes.len() as u64).saturating_add(FREE_BYTES);
    let most = most.min(MAX_BYTES);
    let mut limits = Limits::default();
    limits.max_alloc = Some(most);
    reader.limits(limits);
    let decoder = reader.into_decoder().map_err(|error| match error {
        image::ImageError::Unsupported(_) => unknown(),
        error => broken(error),
    })?;
    if decoder.total_bytes() > most {
        return Err(Error::malformed(Place::Header, "the image is too large"));
    }
    check(decoder.total_bytes())?;
    let image = DynamicImage::from_decoder(decoder).map_err(broken)?;
    let (width, height) = (image.width(), image.height());
    let alphas = opacities(image, channel);
    if alphas.iter().all(|&alpha| alpha == 255) {
        return Ok(None);
    }
    AlphaTexture::new(width, height, alphas).map(Some)
}

fn unknown() -> Error {
    Error::malformed(Place::Header, "an opacity image must be a PNG, JPEG, TGA, WebP or BMP")
}

/// One opacity a pixel, 255 opaque.
fn opacities(image: DynamicImage, channel: Channel) -> Vec<u8> {
    let has_alpha = image.color().has_alpha();
    if !has_alpha && channel == Channel::Alpha {
        return Vec::new();
    }
    let (parts, count) = parts(image);
    let pixels = || parts.chunks_exact(count);
    let of = |at: usize| pixels().map(|pixel| pixel[at]).collect::<Vec<u8>>();
    // Grey is red, green and blue.
    let colour = |at: usize| if count < 3 { 0 } else { at };
    match channel {
        Channel::Red => return of(0),
        Channel::Green => return of(colour(1)),
        Channel::Blue => return of(colour(2)),
        Channel::Alpha => return of(count - 1),
        Channel::AlphaOrBrightness if has_alpha => {
            let alphas = of(count - 1);
            if alphas.iter().any(|&alpha| alpha != 255) {
                return alphas;
            }
        }
        Channel::AlphaOrBrightness | Channel::Brightness => {}
    }
    if count < 3 { of(0) } else { pixels().map(|pixel| brightness(&pixel[..3])).collect() }
}

/// The bytes of all pixels, and how many a pixel has: grey, grey and alpha, RGB or
/// RGBA.
fn parts(image: DynamicImage) -> (Vec<u8>, usize) {
    match image {
        DynamicImage::ImageLuma8(image) => (image.into_raw(), 1),
        DynamicImage::ImageLumaA8(image) => (image.into_raw(), 2),
        DynamicImage::ImageRgb8(image) => (image.into_raw(), 3),
        image if image.color().has_color() || image.color().has_alpha() => {
            (image.into_rgba8().into_raw(), 4)
        }
        image => (image.into_luma8().into_raw(), 1),
    }
}

fn brightness(pixel: &[u8]) -> u8 {
    let sum: u32 = pixel.iter().map(|&part| u32::from(part)).sum();
    (sum / 3) as u8
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec2;
    use image::ExtendedColorType;

    fn encoded(format: ImageFormat, colour: ExtendedColorType, pixels: &[u8]) -> Vec<u8> {
        let mut bytes = Cursor::new(Vec::new());
        image::write_buffer_with_format(&mut bytes, pixels, 2, 1, colour, format).unwrap();
        bytes.into_inner()
    }

    fn left(bytes: &[u8], channel: Channel) -> Option<f32> {
        let texture = decode(bytes, Some("tga"), channel, |_| Ok(())).unwrap()?;
        Some(texture.sample(Vec2::new(0.25, 0.5)))
    }

    #[test]
    fn opacity_is_of_the_channel() {
        let rgba = [102, 51, 0, 51, 0, 0, 0, 255];
        for format in [ImageFormat::Png, ImageFormat::Tga, ImageFormat::Bmp, ImageFormat::WebP] {
            let bytes = encoded(format, ExtendedColorType::Rgba8, &rgba);
            for (channel, want) in [
                (Channel::Alpha, 0.2),
                (Channel::AlphaOrBrightness, 0.2),
                (Channel::Brightness, 0.2),
                (Channel::Red, 0.4),
                (Channel::Green, 0.2),
                (Channel::Blue, 0.0),
            ] {
                assert_eq!(left(&bytes, channel), Some(want), "{format:?} {channel:?}");
            }
        }
        let rgb = encoded(ImageFormat::Png, ExtendedColorType::Rgb8, &[0, 51, 102, 255, 255, 255]);
        assert_eq!(left(&rgb, Channel::Alpha), None);
        assert_eq!(left(&rgb, Channel::AlphaOrBrightness), Some(0.2));
        // An alpha that says nothing leaves the word to the colours.
        let mask =
            encoded(ImageFormat::Tga, ExtendedColorType::Rgba8, &[51, 51, 51, 255, 0, 0, 0, 255]);
        assert_eq!(left(&mask, Channel::AlphaOrBrightness), Some(0.2));
        let opaque = encoded(ImageFormat::Png, ExtendedColorType::Rgba8, &[255; 8]);
        assert_eq!(left(&opaque, Channel::Alpha), None);
        let grey = encoded(ImageFormat::Png, ExtendedColorType::L16, &[51, 51, 255, 255]);
        assert_eq!(left(&grey, Channel::AlphaOrBrightness), Some(0.2));
        let jpeg = encoded(ImageFormat::Jpeg, ExtendedColorType::L8, &[51, 51]);
        let found = left(&jpeg, Channel::AlphaOrBrightness).unwrap();
        assert!((found - 0.2).abs() < 0.01, "{found}");
        assert_eq!(left(&jpeg, Channel::Alpha), None);
    }

    #[test]
    fn grey_counts_as_every_colour() {
        let png = |colour, pixels: &[u8]| encoded(ImageFormat::Png, colour, pixels);
        let grey = png(ExtendedColorType::L8, &[102, 51]);
        let grey_16 = png(ExtendedColorType::L16, &[102, 102, 51, 51]);
        let veil = png(ExtendedColorType::La8, &[102, 51, 0, 255]);
        let veil_16 = png(ExtendedColorType::La16, &[102, 102, 51, 51, 0, 0, 255, 255]);
        let solid = png(ExtendedColorType::La8, &[102, 255, 0, 255]);
        for channel in [Channel::Red, Channel::Green, Channel::Blue, Channel::Brightness] {
            for bytes in [&grey, &grey_16, &veil, &veil_16, &solid] {
                assert_eq!(left(bytes, channel), Some(0.4), "{channel:?}");
            }
        }
        for bytes in [&veil, &veil_16] {
            assert_eq!(left(bytes, Channel::Alpha), Some(0.2));
            assert_eq!(left(bytes, Channel::AlphaOrBrightness), Some(0.2));
        }
        assert_eq!(left(&grey, Channel::Alpha), None);
        assert_eq!(left(&solid, Channel::AlphaOrBrightness), Some(0.4));
        let rgb = [102_u8, 51, 0, 255, 255, 255];
        let rgb_16: Vec<u8> = rgb.iter().flat_map(|&part| [part; 2]).collect();
        let rgb = png(ExtendedColorType::Rgb8, &rgb);
        let rgb_16 = png(ExtendedColorType::Rgb16, &rgb_16);
        for bytes in [&rgb, &rgb_16] {
            for (channel, want) in [
                (Channel::Red, 0.4),
                (Channel::Green, 0.2),
                (Channel::Blue, 0.0),
                (Channel::Brightness, 0.2),
                (Channel::AlphaOrBrightness, 0.2),
            ] {
                assert_eq!(left(bytes, channel), Some(want), "{channel:?}");
            }
        }
    }

    #[test]
    fn broken_images_are_refused() {
        let formats = [ImageFormat::Png, ImageFormat::Tga, ImageFormat::Bmp, ImageFormat::WebP];
        for format in formats {
            let whole = encoded(format, ExtendedColorType::Rgba8, &[7; 8]);
            for length in 0..whole.len() {
                // A checksum or a footer at the end may be missed or not.
                let _ = decode(&whole[..length], Some("tga"), Channel::Alpha, |_| Ok(()));
            }
            assert!(
                decode(&whole[..whole.len() / 2], Some("tga"), Channel::Alpha, |_| Ok(())).is_err()
            );
        }
        let error = decode(b"GIF89a", Some("gif"), Channel::Alpha, |_| Ok(())).unwrap_err();
        assert!(error.to_string().contains("must be a PNG, JPEG"), "{error}");
        assert!(decode(b"no image", None, Channel::Alpha, |_| Ok(())).is_err());
        // 15,000 × 15,000 pixels, of which 16 are there.
        let mut sparse = encoded(ImageFormat::Tga, ExtendedColorType::Rgba8, &[7; 8]);
        sparse[12..16].copy_from_slice(&[0x98, 0x3a, 0x98, 0x3a]);
        let error = decode(&sparse, Some("tga"), Channel::Alpha, |_| Ok(())).unwrap_err();
        assert!(error.to_string().contains("too large"), "{error}");
        // 2³¹ × 2³¹ pixels in 33 bytes.
        let mut huge = encoded(ImageFormat::Png, ExtendedColorType::Rgba8, &[7; 8]);
        huge[16..24].copy_from_slice(&[0x7f, 0xff, 0xff, 0xff, 0x7f, 0xff, 0xff, 0xff]);
        assert!(decode(&huge, None, Channel::Alpha, |_| Ok(())).is_err());
    }
}
