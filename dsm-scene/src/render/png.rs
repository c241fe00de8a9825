//! Pictures as PNG files.

use super::image::Image;
use crate::error::{Error, Result};

impl Image {
    /// The picture as an 8-bit PNG file with the sRGB curve: grey where all
    /// pixels are, else RGB. Values outside [0, 1] are cut off, and a NaN is
    /// black.
    ///
    /// # Errors
    ///
    /// [`Error::Io`] for a picture that no PNG can hold: one without pixels, or
    /// too large.
    pub fn to_png(&self) -> Result<Vec<u8>> {
        let [width, height] = self.size();
        let channels = if self.is_grey() { 1 } else { 3 };
        let codes: Vec<u8> = self
            .pixels()
            .iter()
            .flat_map(|pixel| &pixel[..channels])
            .map(|&value| srgb_code(value))
            .collect();
        let mut file = Vec::new();
        let mut encoder = png::Encoder::new(&mut file, width, height);
        encoder.set_color(if channels == 1 {
            png::ColorType::Grayscale
        } else {
            png::ColorType::Rgb
        });
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_compression(png::Compression::High);
        encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
        let written = encoder.write_header().and_then(|mut writer| {
            writer.write_image_data(&codes)?;
            writer.finish()
        });
        match written {
            Ok(()) => Ok(file),
            Err(error) => Err(Error::Io { action: "encode the picture", error: error.into() }),
        }
    }
}

/// The 8-bit code of a linear value under the sRGB curve (IEC 61966-2-1): 0
/// below 0 and for NaN, 255 above 1.
#[must_use]
pub fn srgb_code(linear: f32) -> u8 {
    let encoded =
        if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 };
    (255.0 * encoded).round() as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn codes_follow_the_srgb_curve() {
        assert_eq!([0.0, 0.002, 0.25, 0.5, 1.0].map(srgb_code), [0, 7, 137, 188, 255]);
        assert_eq!([-1.0, 2.0, f32::NAN].map(srgb_code), [0, 255, 0]);
    }

    #[test]
    fn pictures_are_grey_where_all_pixels_are() {
        let colours = Image::new([2, 1], vec![[0.25, 1.0, 0.0], [0.5; 3]]).unwrap();
        let grey = Image::new([1, 2], vec![[0.25; 3], [1.0; 3]]).unwrap();
        let rgb = png::ColorType::Rgb;
        for (image, colour, bytes) in [
            (colours, rgb, vec![137, 255, 0, 188, 188, 188]),
            (grey, png::ColorType::Grayscale, vec![137, 255]),
        ] {
            let file = std::io::Cursor::new(image.to_png().unwrap());
            let mut reader = png::Decoder::new(file).read_info().unwrap();
            let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
            assert_eq!(reader.next_frame(&mut pixels).unwrap().color_type, colour);
            assert_eq!(pixels, bytes);
        }
        assert!(Image::new([0, 3], Vec::new()).unwrap().to_png().is_err());
    }
}
