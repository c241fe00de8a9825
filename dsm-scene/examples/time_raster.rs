//! How much processor time the rasteriser takes for a ball of hair, best of
//! several runs.

#![expect(clippy::expect_used, reason = "an example may panic")]
#![expect(clippy::print_stdout, reason = "it prints what it measured")]

#[path = "../benches/raster/hair.rs"]
mod hair;

use dsm_core::{HitSource, TileHits};

/// Seconds that this thread has run.
fn seconds() -> f64 {
    let stat = std::fs::read_to_string("/proc/thread-self/schedstat").expect("a Linux kernel");
    let first = stat.split(' ').next().and_then(|first| first.parse::<f64>().ok());
    first.expect("nanoseconds") / 1e9
}

fn best<T>(runs: u32, mut run: impl FnMut() -> T) -> (f64, T) {
    let mut result = None;
    let mut least = f64::INFINITY;
    for _ in 0..runs {
        let start = seconds();
        result = Some(run());
        least = least.min(seconds() - start);
    }
    (least, result.expect("at least one run"))
}

fn main() {
    hair::segments();
    let (binning, rasterizer) = best(5, hair::build);
    let blocks = hair::blocks();
    let mut hits = TileHits::new(0);
    let (raster, count) = best(7, || {
        let mut count = 0;
        for samples in &blocks {
            hits.reset(samples.len());
            rasterizer.hits(samples, &mut hits).expect("hits");
            count += hits.surface_count();
        }
        count
    });
    let rays = f64::from(hair::SIZE).powi(2) * f64::from(hair::SAMPLES);
    let per = |items: f64| raster * 1e9 / items;
    println!("binning {binning:.3} s");
    println!(
        "{count} hits {raster:.3} s, {:.2} ns a hit, {:.1} ns a ray",
        per(count as f64),
        per(rays)
    );
}
