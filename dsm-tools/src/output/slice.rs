//! A slice through a map: the image of V(z) at one depth.

use std::io::Cursor;

use anyhow::{Context, Result};
use deepshadow::scene::detail::{Image, srgb_code};
use deepshadow::visibility::detail::PixelWindow;
use deepshadow::visibility::{MapInfo, Transmittance, VisibilityField};
use exr::prelude::{
    AnyChannel, AnyChannels, Encoding, FlatSamples, Image as ExrImage, IntegerBounds, Layer,
    LayerAttributes, Vec2, WritableImage,
};

/// V(z) of every pixel, row by row.
pub(crate) struct Slice<T> {
    size: [u32; 2],
    values: Vec<T>,
}

impl<T: Transmittance> Slice<T> {
    /// V(`depth`) over all pixels of `field`. O(pixels · log vertices).
    pub(crate) fn new<F: VisibilityField<Value = T>>(
        field: &F,
        depth: f32,
    ) -> Result<Self, F::Error> {
        let size @ [width, height] = field.size();
        let pixels = (0..height).flat_map(|y| (0..width).map(move |x| [x, y]));
        let values = pixels.map(|pixel| field.evaluate(pixel, depth)).collect::<Result<_, _>>()?;
        Ok(Self { size, values })
    }

    /// The slice as a picture.
    pub(crate) fn image(&self) -> Option<Image> {
        let pixel =
            |value: &T| [0, 1, 2].map(|channel: usize| value.channel(channel.min(T::CHANNELS - 1)));
        Image::new(self.size, self.values.iter().map(pixel).collect())
    }

    /// The slice as an 8-bit PNG file, grey or RGB, with the sRGB curve.
    pub(crate) fn png(&self) -> Result<Vec<u8>> {
        let mut file = Vec::new();
        let mut encoder = png::Encoder::new(&mut file, self.size[0], self.size[1]);
        encoder.set_color(if T::CHANNELS == 1 {
            png::ColorType::Grayscale
        } else {
            png::ColorType::Rgb
        });
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
        let bytes: Vec<u8> = self
            .values
            .iter()
            .flat_map(|value| (0..T::CHANNELS).map(|channel| srgb_code(value.channel(channel))))
            .collect();
        let mut writer = encoder.write_header().context("encoding the slice")?;
        writer.write_image_data(&bytes).context("encoding the slice")?;
        writer.finish().context("encoding the slice")?;
        Ok(file)
    }

    /// The slice as an OpenEXR file of linear floats: channel Y, or R, G and
    /// B. The windows, if known, are the ones of the image the map came from.
    pub(crate) fn exr(&self, info: &MapInfo) -> Result<Vec<u8>> {
        let names: &[&str] = if T::CHANNELS == 1 { &["Y"] } else { &["R", "G", "B"] };
        let channels = names.iter().enumerate().map(|(channel, &name)| {
            let column = self.values.iter().map(|value| value.channel(channel)).collect();
            AnyChannel::new(name, FlatSamples::F32(column))
        });
        let corner = info.data_window.map_or([0, 0], |window| window.min);
        let layer = Layer::new(
            Vec2(self.size[0] as usize, self.size[1] as usize),
            LayerAttributes {
                layer_position: Vec2(corner[0], corner[1]),
                ..LayerAttributes::default()
            },
            Encoding::SMALL_LOSSLESS,
            AnyChannels::sort(channels.collect()),
        );
        let mut image = ExrImage::from_layer(layer);
        // Nobody could show an empty display window.
        if let Some(display) = info.display_window.filter(|window| !window.size().contains(&0)) {
            image.attributes.display_window = bounds(display);
        }
        let mut file = Cursor::new(Vec::new());
        image.write().to_buffered(&mut file).context("encoding the slice")?;
        Ok(file.into_inner())
    }
}

fn bounds(window: PixelWindow) -> IntegerBounds {
    let [width, height] = window.size().map(|side| side as usize);
    IntegerBounds::new((window.min[0], window.min[1]), (width, height))
}

#[cfg(test)]
mod tests {
    use super::*;
    use deepshadow::visibility::{DeepMap, PixelListsBuilder, Rgb, Vertex};
    use exr::prelude::{ReadChannels, ReadLayers};

    /// A clear pixel beside one that falls to `value` at depth 1.
    fn map<T: Transmittance>(value: T) -> DeepMap<T> {
        let mut pixels = PixelListsBuilder::new(2, 1);
        pixels.finish_pixel().unwrap();
        pixels.push(Vertex::new(1.0, T::CLEAR));
        pixels.push(Vertex::new(1.0, value));
        pixels.finish_pixel().unwrap();
        DeepMap::new(MapInfo::default(), pixels.finish().unwrap())
    }

    fn slice<T: Transmittance>(value: T, depth: f32) -> Slice<T> {
        Slice::new(&map(value), depth).unwrap()
    }

    fn decode(file: &[u8]) -> (png::ColorType, Vec<u8>) {
        let mut reader = png::Decoder::new(Cursor::new(file)).read_info().unwrap();
        let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
        let frame = reader.next_frame(&mut pixels).unwrap();
        (frame.color_type, pixels)
    }

    #[test]
    fn png_slices_have_the_srgb_curve() {
        let grey = slice(0.5_f32, 2.0).png().unwrap();
        assert_eq!(decode(&grey), (png::ColorType::Grayscale, vec![255, 188]));
        let lit = slice(0.5_f32, 0.5).png().unwrap();
        assert_eq!(decode(&lit).1, [255, 255]);
        let coloured = slice(Rgb::new(1.0, 0.25, 0.0), 2.0).png().unwrap();
        assert_eq!(decode(&coloured), (png::ColorType::Rgb, vec![255, 255, 255, 255, 137, 0]));
    }

    #[test]
    fn exr_slices_are_linear_and_keep_the_windows() {
        let data = PixelWindow { min: [-3, 7], max: [-2, 7] };
        let display = PixelWindow { min: [0, 0], max: [9, 9] };
        let info = MapInfo::new().with_data_window(data).with_display_window(display);
        let file = slice(Rgb::new(0.1, 0.25, 0.7), 2.0).exr(&info).unwrap();
        let image = exr::prelude::read()
            .no_deep_data()
            .largest_resolution_level()
            .all_channels()
            .first_valid_layer()
            .all_attributes()
            .from_buffered(Cursor::new(file))
            .unwrap();
        let channels: Vec<_> = image.layer_data.channel_data.list.iter().collect();
        let names: Vec<_> = channels.iter().map(|channel| channel.name.to_string()).collect();
        assert_eq!(names, ["B", "G", "R"]);
        assert_eq!(channels[2].sample_data, FlatSamples::F32(vec![1.0, 0.1]));
        assert_eq!(image.layer_data.attributes.layer_position, Vec2(-3, 7));
        assert_eq!(image.attributes.display_window, bounds(display));
    }
}
