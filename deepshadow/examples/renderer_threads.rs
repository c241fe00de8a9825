//! A renderer's shadow calls: four threads share one map and one tile cache.
//!
//! `cargo run -p deepshadow --example renderer_threads`

#![expect(clippy::print_stdout, reason = "an example prints")]

use std::error::Error;
use std::ops::ControlFlow;
use std::thread;

use deepshadow::glam::DVec3;
use deepshadow::scene::builtin_scene;
use deepshadow::visibility::{Bias, Facing, Filter, FilterShape, Footprint, ShadedPoint};
use deepshadow::{Bake, FilterMethod, OpenOptions, Query, bake};

/// Threads of the renderer, and the shading points of each.
const THREADS: u32 = 4;
const POINTS: u32 = 5_000;

fn main() -> Result<(), Box<dyn Error>> {
    let scene = builtin_scene("spinning-sphere")?;
    let folder = tempfile::tempdir()?;
    let path = folder.path().join("key.dsm");
    let settings = Bake::new([256, 256])?;
    bake(&scene, &scene.light, &settings, &path, |_| ControlFlow::Continue(()))?;

    // Once, when the renderer starts: a cache of 1 MiB for all lights' maps, a tent
    // filter 3 pixels wide, and a depth bias that follows what a point lies on.
    let options = OpenOptions::new().with_cache_bytes(1 << 20);
    let tent = Footprint::Isotropic(Filter::new(FilterShape::Tent, 3.0)?);
    let method = FilterMethod { footprint: tent, bias: Bias::Auto, ..FilterMethod::POINT };
    let shadow = options.open(&path)?.shadow(&Query::new().with_method(method))?;

    // On every thread, for every bucket of shading points.
    let means = thread::scope(|scope| {
        let threads: Vec<_> = (0..THREADS)
            .map(|number| {
                let shadow = shadow.clone();
                scope.spawn(move || shadow.query_shaded(&bucket(number)))
            })
            .collect();
        threads.into_iter().map(|thread| thread.join()).collect::<Vec<_>>()
    });
    for (number, values) in (0..).zip(means) {
        let values = values.map_err(|_| "a thread panicked")??;
        let sum: f64 = (0..values.len()).map(|point| f64::from(values.rgb(point)[0])).sum();
        println!("thread {number}: mean shadow factor {:.4}", sum / values.len() as f64);
        // Another thread, or all points in one call, answer the same.
        let points: Vec<DVec3> = bucket(number).iter().map(|point| point.position).collect();
        assert_eq!(points.len(), values.len());
        assert_eq!(shadow.query_shaded(&bucket(number))?, values);
    }
    let statistics = options.cache().statistics();
    println!("{statistics:?}");
    assert!(statistics.bytes <= 1 << 20, "the cache keeps its budget");
    Ok(())
}

/// Points on the ground around the sphere.
fn bucket(thread: u32) -> Vec<ShadedPoint> {
    let point = |index: u32| {
        let share = |ratio: f64| (f64::from(thread * POINTS + index) * ratio).fract() - 0.5;
        let position = DVec3::new(8.0 * share(0.754_877_67), 0.0, 8.0 * share(0.569_840_29));
        ShadedPoint { position, facing: Facing::Surface(DVec3::Y), seed: index.into() }
    };
    (0..POINTS).map(point).collect()
}
