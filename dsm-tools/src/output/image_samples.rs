//! The samples of an OpenEXR's part, counted.

use anyhow::{Result, ensure};
use deepshadow::files::deep_exr::{AlphaChannels, DeepExrReader};
use serde::Serialize;

use super::printable;

/// What the samples of a part are.
#[derive(Serialize)]
pub(super) struct Samples {
    total: u64,
    max_per_pixel: u64,
    empty_pixels: u64,
    /// Samples that reach from a depth to another.
    volumes: u64,
    /// The channels that depth and opacity are read from.
    read: Vec<String>,
    alpha: &'static str,
    /// Least and largest of what is finite.
    depth: Option<[f32; 2]>,
    opacity: Option<[f32; 2]>,
    /// Samples of which a number is not finite.
    not_finite: u64,
}

/// The samples of a pixel as the file has them.
#[derive(Serialize)]
pub(super) struct PixelSamples {
    pub(super) x: u32,
    pub(super) y: u32,
    /// Front, back and opacity of each channel.
    pub(super) samples: Vec<(f32, f32, [f32; 3])>,
}

impl Samples {
    pub(super) fn count(reader: &mut DeepExrReader) -> Result<Self> {
        let header = reader.header().clone();
        let mut counted = Self {
            total: 0,
            max_per_pixel: 0,
            empty_pixels: 0,
            volumes: 0,
            read: header
                .channels
                .iter()
                .filter(|channel| header.read.contains(&channel.name))
                .map(|channel| printable(&channel.name))
                .collect(),
            alpha: match header.alpha {
                AlphaChannels::None => "none: opaque",
                AlphaChannels::Mono => "one",
                AlphaChannels::Colour => "one a colour",
            },
            depth: None,
            opacity: None,
            not_finite: 0,
        };
        for y in 0..header.height {
            let rows = reader.read_rows(y..y + 1)?;
            for pixel in 0..rows.pixel_count() {
                let samples = rows.pixel(pixel);
                counted.total += samples.len() as u64;
                counted.max_per_pixel = counted.max_per_pixel.max(samples.len() as u64);
                counted.empty_pixels += u64::from(samples.is_empty());
            }
            for index in 0..rows.sample_count() {
                let sample = rows.sample(index);
                counted.volumes += u64::from(sample.z_back > sample.z);
                widen(&mut counted.depth, &[sample.z, sample.z_back]);
                widen(&mut counted.opacity, &sample.alpha);
                let all = sample.alpha.iter().chain([&sample.z, &sample.z_back]);
                counted.not_finite += u64::from(!all.copied().all(f32::is_finite));
            }
        }
        Ok(counted)
    }

    pub(super) fn lines(&self) -> Vec<(&'static str, String)> {
        let range = |range: Option<[f32; 2]>| {
            range.map_or_else(|| "none".to_owned(), |[least, most]| format!("{least} to {most}"))
        };
        let Self { total, max_per_pixel, empty_pixels, volumes, .. } = self;
        let mut lines = vec![
            (
                "samples",
                format!(
                    "{total}, at most {max_per_pixel} a pixel, {volumes} of them volumes; \
                     {empty_pixels} empty pixels"
                ),
            ),
            ("read", format!("{} (alpha: {})", self.read.join(", "), self.alpha)),
            ("depth", range(self.depth)),
            ("opacity", range(self.opacity)),
        ];
        if self.not_finite > 0 {
            lines.push(("not finite", format!("{} samples", self.not_finite)));
        }
        lines
    }
}

fn widen(range: &mut Option<[f32; 2]>, values: &[f32]) {
    for &value in values.iter().filter(|value| value.is_finite()) {
        let [least, most] = range.unwrap_or([value; 2]);
        *range = Some([least.min(value), most.max(value)]);
    }
}

impl PixelSamples {
    pub(super) fn read(reader: &mut DeepExrReader, [x, y]: [u32; 2]) -> Result<Self> {
        let [width, height] = [reader.header().width, reader.header().height];
        ensure!(
            x < width && y < height,
            "pixel ({x}, {y}) lies outside the image of {width} × {height} pixels"
        );
        let rows = reader.read_rows(y..y + 1)?;
        let samples = rows.pixel(x as usize).map(|index| rows.sample(index));
        let samples = samples.map(|sample| (sample.z, sample.z_back, sample.alpha)).collect();
        Ok(Self { x, y, samples })
    }
}
