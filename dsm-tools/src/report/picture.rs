//! Pictures as text within a page.

use anyhow::Result;
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use deepshadow::scene::detail::Image;

/// What differences are multiplied by, so that small ones are seen.
pub(super) const GAIN: f32 = 4.0;

/// The address of a PNG that stands in the page.
pub(super) fn address(png: &[u8]) -> String {
    format!("data:image/png;base64,{}", STANDARD.encode(png))
}

/// A picture with the sRGB curve.
pub(super) fn shown(image: &Image) -> Result<String> {
    Ok(address(&image.to_png()?))
}

/// `image` less `reference`, [`GAIN`] times: grey is none, darker and bluer is less light,
/// brighter and more orange is more.
pub(super) fn difference(image: &Image, reference: &Image) -> Result<String> {
    let [width, height] = image.size();
    let mut bytes = Vec::with_capacity(image.pixels().len() * 3);
    for (own, other) in image.pixels().iter().zip(reference.pixels()) {
        let apart = own.iter().zip(other).map(|(a, b)| a - b).sum::<f32>() / 3.0;
        let share = (apart * GAIN).clamp(-1.0, 1.0);
        let end: [f32; 3] = if share < 0.0 { [5.0, 48.0, 97.0] } else { [255.0, 215.0, 130.0] };
        bytes.extend(end.map(|end| (128.0 + share.abs() * (end - 128.0)).round() as u8));
    }
    let mut file = Vec::new();
    let mut encoder = png::Encoder::new(&mut file, width, height);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    let mut writer = encoder.write_header()?;
    writer.write_image_data(&bytes)?;
    writer.finish()?;
    Ok(address(&file))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn differences_have_a_sign() {
        let image = |value: f32| Image::new([1, 1], vec![[value; 3]]).unwrap();
        let code = |own: f32, other: f32| {
            let text = difference(&image(own), &image(other)).unwrap();
            let (_, png) = text.split_once(',').unwrap();
            let png = STANDARD.decode(png).unwrap();
            let mut reader = png::Decoder::new(std::io::Cursor::new(png)).read_info().unwrap();
            let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
            reader.next_frame(&mut pixels).unwrap();
            pixels
        };
        assert_eq!(code(0.5, 0.5), [128; 3]);
        assert_eq!(code(0.0, 1.0), [5, 48, 97]);
        assert_eq!(code(1.0, 0.0), [255, 215, 130]);
        let little = code(0.5, 0.475);
        assert!(little[0] > 135 && little[0] < 145, "{little:?}");
    }
}
