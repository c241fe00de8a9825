//! Takes out what lies behind a depth, volumes that reach over it included:
//! `cargo run --example cut_behind -- IN.exr DEPTH OUT.exr`.

use std::error::Error;
use std::fs::File;
use std::io::BufWriter;

use deep_exr::{DeepExrReader, DeepExrWriter, Limits, WriteOptions};

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [input, depth, output] = &arguments[..] else {
        return Err("usage: cut_behind IN.exr DEPTH OUT.exr".into());
    };
    let depth: f32 = depth.parse()?;
    let mut reader = DeepExrReader::open(input.as_ref(), None, &Limits::default())?;
    let options = WriteOptions::like(reader.header());
    let mut writer = DeepExrWriter::new(BufWriter::new(File::create(output)?), &options)?;
    for y in 0..reader.header().height {
        let row = reader.read_rows(y..y + 1)?;
        let mut kept = options.rows(row.width());
        for pixel in 0..row.pixel_count() {
            for sample in row.pixel(pixel).map(|index| row.sample(index)) {
                if sample.z_back.max(sample.z) <= depth {
                    kept.push(sample);
                }
            }
            kept.finish_pixel()?;
        }
        writer.write_rows(&kept)?;
    }
    writer.finish()?;
    Ok(())
}
