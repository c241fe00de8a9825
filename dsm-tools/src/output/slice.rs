//! A slice through a map: the image of V(z) at one depth.

use std::io::{Cursor, Write};

use anyhow::{Context, Result};
use deepshadow::files::detail::{AnyDeepMap, TileRect};
use deepshadow::scene::detail::{Image, srgb_code};
use deepshadow::visibility::detail::PixelWindow;
use deepshadow::visibility::{DeepMap, MapInfo, Transmittance};
use exr::prelude::{
    AnyChannel, AnyChannels, Encoding, FlatSamples, Image as ExrImage, IntegerBounds, Layer,
    LayerAttributes, Vec2, WritableImage,
};

/// V(z) of every pixel at one depth, a strip of rows at a time.
pub(crate) struct Slice<R> {
    size: [u32; 2],
    channels: usize,
    /// Rows of a strip.
    rows: u32,
    depth: f32,
    read: R,
}

impl<R: Fn(TileRect) -> Result<AnyDeepMap>> Slice<R> {
    /// The slice of a map of `size` pixels at `depth`, whose functions `read` reads `rows`
    /// rows at a time.
    pub(crate) fn new(size: [u32; 2], channels: usize, rows: u32, depth: f32, read: R) -> Self {
        Self { size, channels, rows, depth, read }
    }

    /// Hands over the values of each strip, pixel by pixel. O(pixels · log vertices).
    fn for_each_strip(&self, mut take: impl FnMut(&[f32]) -> Result<()>) -> Result<()> {
        let [width, height] = self.size;
        let mut values = Vec::new();
        for y in (0..height).step_by(self.rows as usize) {
            values.clear();
            let rect = TileRect { x: 0, y, width, height: self.rows.min(height - y) };
            match (self.read)(rect)? {
                AnyDeepMap::Mono(strip) => push_values(&strip, self.depth, &mut values),
                AnyDeepMap::Rgb(strip) => push_values(&strip, self.depth, &mut values),
            }
            take(&values)?;
        }
        Ok(())
    }

    /// The slice as a picture.
    pub(crate) fn image(&self) -> Result<Option<Image>> {
        let mut pixels = Vec::new();
        self.for_each_strip(|values| {
            let of_strip = values.chunks_exact(self.channels);
            pixels.extend(
                of_strip.map(|value| [0, 1, 2].map(|at: usize| value[at.min(self.channels - 1)])),
            );
            Ok(())
        })?;
        Ok(Image::new(self.size, pixels))
    }

    /// The slice as an 8-bit PNG file, grey or RGB, with the sRGB curve. Holds one strip.
    pub(crate) fn png(&self) -> Result<Vec<u8>> {
        let mut file = Vec::new();
        let mut encoder = png::Encoder::new(&mut file, self.size[0], self.size[1]);
        encoder.set_color(if self.channels == 1 {
            png::ColorType::Grayscale
        } else {
            png::ColorType::Rgb
        });
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
        let mut writer = encoder.write_header().context("encoding the slice")?;
        let mut stream = writer.stream_writer().context("encoding the slice")?;
        let mut codes = Vec::new();
        self.for_each_strip(|values| {
            codes.clear();
            codes.extend(values.iter().map(|&value| srgb_code(value)));
            stream.write_all(&codes).context("encoding the slice")
        })?;
        stream.finish().context("encoding the slice")?;
        writer.finish().context("encoding the slice")?;
        Ok(file)
    }

    /// The slice as an OpenEXR file of linear floats: channel Y, or R, G and
    /// B. The windows, if known, are the ones of the image the map came from.
    pub(crate) fn exr(&self, info: &MapInfo) -> Result<Vec<u8>> {
        let names: &[&str] = if self.channels == 1 { &["Y"] } else { &["R", "G", "B"] };
        let mut columns = vec![Vec::new(); self.channels];
        self.for_each_strip(|values| {
            for (channel, column) in columns.iter_mut().enumerate() {
                column.extend(values.iter().skip(channel).step_by(self.channels));
            }
            Ok(())
        })?;
        let channels = names
            .iter()
            .zip(columns)
            .map(|(&name, column)| AnyChannel::new(name, FlatSamples::F32(column)));
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

fn push_values<T: Transmittance>(strip: &DeepMap<T>, depth: f32, values: &mut Vec<f32>) {
    for function in strip.pixels().view().functions() {
        let value = function.at(depth);
        values.extend((0..T::CHANNELS).map(|channel| value.channel(channel)));
    }
}

fn bounds(window: PixelWindow) -> IntegerBounds {
    let [width, height] = window.size().map(|side| side as usize);
    IntegerBounds::new((window.min[0], window.min[1]), (width, height))
}

#[cfg(test)]
mod tests {
    use super::*;
    use deepshadow::visibility::{PixelListsBuilder, Rgb, Vertex};
    use exr::prelude::{ReadChannels, ReadLayers};

    /// Rows of a clear pixel beside one that falls to `value` at depth 1.
    fn strip<T: Transmittance>(value: T, rows: u32) -> DeepMap<T> {
        let mut pixels = PixelListsBuilder::new(2, rows);
        for _ in 0..rows {
            pixels.finish_pixel().unwrap();
            pixels.push(Vertex::new(1.0, T::CLEAR));
            pixels.push(Vertex::new(1.0, value));
            pixels.finish_pixel().unwrap();
        }
        DeepMap::new(MapInfo::default(), pixels.finish().unwrap())
    }

    /// A slice of three rows in strips of two and one.
    fn slice(
        value: impl Into<Value>,
        depth: f32,
    ) -> Slice<impl Fn(TileRect) -> Result<AnyDeepMap>> {
        let value = value.into();
        let channels = if matches!(value, Value::Mono(_)) { 1 } else { 3 };
        Slice::new([2, 3], channels, 2, depth, move |rect| {
            assert_eq!((rect.x, rect.width), (0, 2));
            assert!(rect.y + rect.height <= 3 && rect.y.is_multiple_of(2));
            Ok(match value {
                Value::Mono(value) => AnyDeepMap::Mono(strip(value, rect.height)),
                Value::Rgb(value) => AnyDeepMap::Rgb(strip(value, rect.height)),
            })
        })
    }

    #[derive(Clone, Copy)]
    enum Value {
        Mono(f32),
        Rgb(Rgb),
    }

    impl From<f32> for Value {
        fn from(value: f32) -> Self {
            Self::Mono(value)
        }
    }

    impl From<Rgb> for Value {
        fn from(value: Rgb) -> Self {
            Self::Rgb(value)
        }
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
        assert_eq!(decode(&grey), (png::ColorType::Grayscale, [255, 188].repeat(3)));
        let lit = slice(0.5_f32, 0.5).png().unwrap();
        assert_eq!(decode(&lit).1, [255; 6]);
        let coloured = slice(Rgb::new(1.0, 0.25, 0.0), 2.0).png().unwrap();
        assert_eq!(
            decode(&coloured),
            (png::ColorType::Rgb, [255, 255, 255, 255, 137, 0].repeat(3))
        );
    }

    #[test]
    fn exr_slices_are_linear_and_keep_the_windows() {
        let data = PixelWindow { min: [-3, 7], max: [-2, 9] };
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
        assert_eq!(channels[2].sample_data, FlatSamples::F32([1.0, 0.1].repeat(3)));
        assert_eq!(image.layer_data.attributes.layer_position, Vec2(-3, 7));
        assert_eq!(image.attributes.display_window, bounds(display));
    }
}
