//! The soft shadow of an area light, traced through a map of fragments, beside rays
//! through the scene itself.
//!
//! `cargo run --release -p deepshadow --example area_light`

#![expect(clippy::print_stdout, reason = "an example prints")]

use std::error::Error;
use std::ops::ControlFlow;
use std::sync::Arc;

use deepshadow::glam::DVec3;
use deepshadow::scene::{TracedScene, builtin_scene};
use deepshadow::visibility::LightExtent;
use deepshadow::{Bake, Kind, Query, Shadow, ShadowMap, TraceMethod, bake};

/// Shadow rays of a point.
const RAYS: u32 = 256;

fn main() -> Result<(), Box<dyn Error>> {
    let mut scene = builtin_scene("pipes")?;
    scene.light.extent = LightExtent::rectangle([1.5, 1.5]);

    let folder = tempfile::tempdir()?;
    let path = folder.path().join("pipes.dsm");
    let fragments = Kind::FRAGMENTS;
    let settings = Bake::new([256, 256])?.with_kind(fragments);
    let report = bake(&scene, &scene.light, &settings, &path, |_| ControlFlow::Continue(()))?;
    println!("{} hits in {} bytes", report.hits, report.bytes);

    // The map knows its light; the query only says how many rays.
    let query = Query::new().with_method(TraceMethod::new(RAYS));
    let shadow = ShadowMap::open(&path)?.shadow(&query)?;
    let reference = Shadow::reference(Arc::new(TracedScene::new(&scene)?), &scene, RAYS)?;

    // A row of points on the ground, through a penumbra.
    let points: Vec<DVec3> =
        (0..60).map(|step| DVec3::new(0.1 * f64::from(step) - 3.0, 0.0, -0.7)).collect();
    let (traced, truth) = (shadow.query(&points)?, reference.query(&points)?);
    let mut squares = 0.0;
    for (index, point) in points.iter().enumerate() {
        let (have, want) = (traced.rgb(index)[0], truth.rgb(index)[0]);
        if index % 6 == 0 {
            println!("x {:+.1}: {have:.3}, rays through the scene {want:.3}", point.x);
        }
        squares += f64::from(have - want).powi(2);
    }
    let rmse = (squares / points.len() as f64).sqrt();
    println!("RMSE {rmse:.4}");
    assert!(rmse < 0.03, "the map stands for the scene");
    Ok(())
}
