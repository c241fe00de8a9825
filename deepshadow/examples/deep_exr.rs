//! Deep OpenEXR in and out: a deep image becomes a shadow map that is queried, and
//! the map a deep image again.
//!
//! `cargo run -p deepshadow --example deep_exr`

#![expect(clippy::print_stdout, reason = "an example prints")]

use std::error::Error;
use std::path::Path;

use deepshadow::files::{
    ConvertOptions, ExportOptions, Limits, MapSource, convert, export_deep_exr,
};
use deepshadow::visibility::Progress;
use deepshadow::{Query, ShadowMap};

fn main() -> Result<(), Box<dyn Error>> {
    let image = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/sample/tuft.exr");
    let folder = tempfile::tempdir()?;
    let (map, again) = (folder.path().join("tuft.dsm"), folder.path().join("tuft.exr"));
    let limits = Limits::default();

    // Samples become visibility functions, kept exactly.
    let mut source = MapSource::open(&image, None, &limits)?;
    let report = convert(&mut source, &map, &ConvertOptions::default(), Progress::ignore)?;
    report.lines().iter().for_each(|line| println!("{line}"));

    // A raster position in pixels, and a depth.
    let shadow = ShadowMap::open(&map)?.shadow(&Query::new())?;
    let factors = shadow.query_raster(&[[14.5, 11.5, 0.1], [14.5, 11.5, 1e6]], 0)?;
    println!("before everything {:?}, behind it {:?}", factors.rgb(0), factors.rgb(1));
    assert_eq!(factors.rgb(0), [1.0; 3]);

    // And back: within 1e-4 of the map, which is measured.
    let mut source = MapSource::open(&map, None, &limits)?;
    let report = export_deep_exr(&mut source, &again, &ExportOptions::default(), Progress::ignore)?;
    println!("the {} samples written are off by {:.1e} at most", report.samples, report.achieved);
    assert!(report.achieved < 1e-4);
    Ok(())
}
