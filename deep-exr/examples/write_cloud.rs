//! Writes a deep image of a ball of smoke before a wall, in tiles:
//! `cargo run --example write_cloud -- cloud.exr`.

use std::error::Error;
use std::fs::File;
use std::io::BufWriter;

use deep_exr::{
    AlphaChannels, Attribute, DeepExrWriter, DeepSample, Layout, SampleType, WriteOptions,
};

const SIZE: u32 = 256;
const SLABS: u32 = 12;

/// Front and back of the ball along the ray through a pixel.
fn ball(x: u32, y: u32) -> Option<(f32, f32)> {
    let [x, y] = [x, y].map(|n| (n as f32 + 0.5) / SIZE as f32 * 2.0 - 1.0);
    let half = (0.64 - x * x - y * y).max(0.0).sqrt();
    (half > 0.0).then_some((5.0 - half, 5.0 + half))
}

fn main() -> Result<(), Box<dyn Error>> {
    let path = std::env::args().nth(1).ok_or("usage: write_cloud OUT.exr")?;
    let mut options = WriteOptions::new(SIZE, SIZE)
        .alpha(AlphaChannels::Mono, SampleType::Half)
        .layout(Layout::Tiles { width: 64, height: 64 });
    options.set(Attribute::string("comments", "smoke before a wall"))?;
    let mut writer = DeepExrWriter::new(BufWriter::new(File::create(path)?), &options)?;
    for y in 0..SIZE {
        let mut rows = options.rows(SIZE);
        for x in 0..SIZE {
            if let Some((front, back)) = ball(x, y) {
                let step = (back - front) / SLABS as f32;
                for slab in 0..SLABS {
                    let z = front + slab as f32 * step;
                    let alpha = [1.0 - (-1.5 * step).exp(); 3];
                    rows.push(DeepSample { z, z_back: z + step, alpha });
                }
            }
            rows.push(DeepSample { z: 8.0, z_back: 8.0, alpha: [1.0; 3] });
            rows.finish_pixel()?;
        }
        writer.write_rows(&rows)?;
    }
    writer.finish()?;
    Ok(())
}
