//! Times reading all samples of a deep OpenEXR file, one thread, opening
//! included: `cargo run --release -p deep-exr --example time_read --
//! FILE [RUNS]` prints `{"seconds": median, "samples": n, "sum_z": …}`.

use std::path::Path;
use std::time::Instant;

use deep_exr::{DeepExrReader, DeepRows, Limits};

fn read(path: &Path) -> Result<DeepRows, deep_exr::Error> {
    let mut reader = DeepExrReader::open(path, None, &Limits::default())?;
    let height = reader.header().height;
    reader.read_rows(0..height)
}

#[expect(clippy::print_stdout, reason = "the answer")]
fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args().skip(1);
    let path = arguments.next().ok_or("usage: time_read FILE [RUNS]")?;
    let runs: usize = arguments.next().map_or(Ok(15), |runs| runs.parse())?;
    let rows = read(path.as_ref())?;
    let mut seconds: Vec<f64> = (0..runs.max(1))
        .map(|_| {
            let start = Instant::now();
            let rows = read(path.as_ref());
            let elapsed = start.elapsed().as_secs_f64();
            std::hint::black_box(rows).map(|_| elapsed)
        })
        .collect::<Result<_, _>>()?;
    seconds.sort_by(f64::total_cmp);
    let answer = serde_json::json!({
        "seconds": seconds[seconds.len() / 2],
        "samples": rows.sample_count(),
        "sum_z": rows.z().iter().copied().map(f64::from).sum::<f64>(),
    });
    println!("{answer}");
    Ok(())
}
