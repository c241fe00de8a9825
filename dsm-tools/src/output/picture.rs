//! Pictures: 8-bit PNG with the sRGB curve, and linear OpenEXR.

use std::io::Cursor;
use std::path::Path;

use anyhow::{Context, Result, anyhow, bail, ensure};
use deepshadow::scene::detail::Image;
use exr::image::read::read;
use exr::meta::MetaData;
use exr::prelude::{
    AnyChannel, AnyChannels, Encoding, FlatSamples, Image as ExrImage, Layer, LayerAttributes,
    ReadChannels, ReadLayers, Vec2, WritableImage,
};

use crate::args::{ImageFile, ImageFormat};

/// Writes the picture, all of it or nothing. Values outside [0, 1] are cut off
/// in a PNG.
pub(crate) fn write_picture(image: &Image, file: &ImageFile) -> Result<()> {
    let encoded = match file.format {
        ImageFormat::Exr => exr(image),
        _ => image.to_png().map_err(anyhow::Error::from),
    };
    let encoded = encoded.with_context(|| format!("encoding {}", file.path.display()))?;
    Ok(deepshadow::files::detail::replace_file(&file.path, &encoded)?)
}

fn exr(image: &Image) -> Result<Vec<u8>> {
    let names: &[&str] = if image.is_grey() { &["Y"] } else { &["R", "G", "B"] };
    let channels = names.iter().enumerate().map(|(channel, &name)| {
        let column = image.pixels().iter().map(|pixel| pixel[channel]).collect();
        AnyChannel::new(name, FlatSamples::F32(column))
    });
    let [width, height] = image.size().map(|side| side as usize);
    let layer = Layer::new(
        Vec2(width, height),
        LayerAttributes::default(),
        Encoding::SMALL_LOSSLESS,
        AnyChannels::sort(channels.collect()),
    );
    let mut file = Cursor::new(Vec::new());
    ExrImage::from_layer(layer).write().to_buffered(&mut file)?;
    Ok(file.into_inner())
}

/// Reads a picture of this size: channel Y, or R, G and B of the first layer.
pub(crate) fn read_exr(path: &Path, size: [u32; 2]) -> Result<Image> {
    read_exr_pixels(path, size).with_context(|| format!("{}", path.display()))
}

fn read_exr_pixels(path: &Path, size: [u32; 2]) -> Result<Image> {
    // Nothing is held before its size is known.
    let meta = MetaData::read_from_file(path, false)?;
    let [width, height] = size;
    for header in &meta.headers {
        let Vec2(w, h) = header.layer_size;
        ensure!(!header.deep, "a deep image is no picture");
        ensure!(
            [w as u64, h as u64] == [u64::from(width), u64::from(height)],
            "{w} × {h} pixels, but the picture has {width} × {height}"
        );
    }
    let image = read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .first_valid_layer()
        .all_attributes()
        .from_file(path)?;
    let channels = &image.layer_data.channel_data.list;
    let column = |name: &str| -> Option<Vec<f32>> {
        let channel = channels.iter().find(|channel| channel.name.eq(name))?;
        Some(channel.sample_data.values_as_f32().collect())
    };
    let columns = match (column("R"), column("G"), column("B")) {
        (Some(red), Some(green), Some(blue)) => [red, green, blue],
        _ => {
            let grey =
                column("Y").ok_or_else(|| anyhow!("there is no channel Y, nor R, G and B"))?;
            [grey.clone(), grey.clone(), grey]
        }
    };
    let pixels = (0..columns[0].len()).map(|at| {
        [0, 1, 2].map(|channel: usize| columns[channel].get(at).copied().unwrap_or(f32::NAN))
    });
    match Image::new(size, pixels.collect()) {
        Some(image) => Ok(image),
        None => bail!("its channels have not one sample a pixel"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_come_back_as_they_were() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("picture.exr");
        let file = ImageFile { path: path.clone(), format: ImageFormat::Exr };
        let colours = Image::new([2, 1], vec![[0.1, 1.5, 0.0], [0.2, 0.3, 0.4]]).unwrap();
        let grey = Image::new([1, 2], vec![[0.25; 3], [0.75; 3]]).unwrap();
        for image in [colours, grey] {
            write_picture(&image, &file).unwrap();
            assert_eq!(read_exr(&path, image.size()).unwrap(), image);
            let refused = format!("{:#}", read_exr(&path, [3, 3]).unwrap_err());
            assert!(refused.contains("but the picture has 3 × 3"), "{refused}");
        }
    }
}
