//! A renderer's own hits become a shadow map, and a point of the world is queried.
//!
//! `cargo run -p deepshadow --example own_hit_source`

#![expect(clippy::print_stdout, reason = "an example prints")]

use std::error::Error;
use std::ops::ControlFlow;

use deepshadow::glam::DVec3;
use deepshadow::scene::Light;
use deepshadow::visibility::{
    LightExtent, Projection, RayHits, RaySource, SamplePoint, SurfaceHit, View, ViewRaster,
};
use deepshadow::{Bake, Query, ShadowMap, ThroughView, bake};

fn main() -> Result<(), Box<dyn Error>> {
    // The shadow camera sits in the light and looks at the origin.
    let view = View { eye: DVec3::new(0.0, 4.0, 0.0), target: DVec3::ZERO, up: DVec3::Z };
    let light = Light {
        view,
        projection: Projection::Perspective { fov: 60.0 },
        extent: LightExtent::POINT,
    };

    // A renderer answers what each ray meets: here a pane of smoked glass one unit
    // above the ground, over x < 0, that lets 40 % of the light through.
    let glass = ThroughView(|view: &ViewRaster| {
        let view = *view;
        Ok(RaySource(move |sample: SamplePoint, hits: &mut RayHits<f32>| {
            // The ray's parameter is the depth that maps keep.
            let ray = view.ray(sample.x, sample.y, sample.time.into());
            let depth = (1.0 - ray.origin().y) / ray.direction().y;
            if depth > 0.0 && ray.at(depth).x < 0.0 {
                hits.push_surface(SurfaceHit { depth: depth as f32, opacity: 0.6 })?;
            }
            Ok::<(), deepshadow::visibility::Error>(())
        }))
    });

    let folder = tempfile::tempdir()?;
    let path = folder.path().join("glass.dsm");
    let settings = Bake::new([128, 128])?.with_samples(4);
    let report = bake(&glass, &light, &settings, &path, |_| ControlFlow::Continue(()))?;
    println!("{} samples met {} surfaces, {} bytes", report.samples, report.hits, report.bytes);

    let map = ShadowMap::open(&path)?;
    let points =
        [DVec3::new(-0.5, 0.0, 0.2), DVec3::new(0.5, 0.0, 0.2), DVec3::new(-0.5, 2.0, 0.2)];
    let factors = map.query(&points, &Query::new())?;
    for (point, what) in ["below the glass", "beside it", "above it"].into_iter().enumerate() {
        println!("{what}: {:.3}", factors.rgb(point)[0]);
    }
    let bound = report.tolerance;
    assert!((factors.rgb(0)[0] - 0.4).abs() <= bound, "the glass lets 40 % through");
    assert_eq!([factors.rgb(1)[0], factors.rgb(2)[0]], [1.0, 1.0]);
    Ok(())
}
