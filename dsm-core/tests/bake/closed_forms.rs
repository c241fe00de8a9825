//! Maps whose functions are known: media, edges, movement.

use dsm_core::{
    BakeSettings, Baker, Error, PixelSampling, RayHits, RaySource, SamplePoint, ShadowCamera,
    SurfaceHit, Tolerance, VolumeSample,
};
use glam::{DMat4, DVec3, DVec4};

const EXTINCTION: f32 = 0.7;

/// A homogeneous box between depths 2 and 4, wider than the view.
fn fog(point: SamplePoint, ray: &mut RayHits<f32>) -> Result<(), Error> {
    let fog = [2.0, 4.0].map(|depth| VolumeSample { depth, extinction: EXTINCTION });
    ray.push_volume(&fog, point.distance_per_depth)
}

/// A camera somewhere that looks sideways; perspective with this tangent of
/// half its field of view, or orthographic.
fn camera(tangent: Option<f64>) -> ShadowCamera {
    let sideways = DMat4::from_rotation_y(std::f64::consts::FRAC_PI_2);
    let view = sideways * DMat4::from_translation(DVec3::new(-1.0, -2.0, -3.0));
    let projection = match tangent {
        Some(tangent) => DMat4::from_rows(
            DVec4::new(0.5 / tangent, 0.0, -0.5, 0.0),
            DVec4::new(0.0, -0.5 / tangent, -0.5, 0.0),
            DVec4::Z,
            DVec4::new(0.0, 0.0, -1.0, 0.0),
        ),
        None => DMat4::from_rows(
            DVec4::new(0.1, 0.0, 0.0, 0.5),
            DVec4::new(0.0, -0.1, 0.0, 0.5),
            DVec4::Z,
            DVec4::W,
        ),
    };
    ShadowCamera { world_to_camera: Some(view), world_to_ndc: Some(projection * view) }
}

#[test]
fn a_homogeneous_box_has_its_optical_depth() {
    let size = 512;
    let tangent = 60.0_f64.to_radians().tan();
    for view in [None, Some(tangent)] {
        let mut settings = BakeSettings::new([size, size]).unwrap();
        settings.tile_size = 8;
        settings.camera = Some(camera(view));
        settings.tolerance = Some(Tolerance::new(1e-5).unwrap());
        for [left, top] in [[0, 0], [504, 248], [256, 256], [64, 400]] {
            settings.crop = Some([left, top, left + 8, top + 8]);
            let map = Baker::new(RaySource(fog), settings.clone()).unwrap().map().unwrap();
            for pixel in 0..64 {
                let (x, y) = (pixel % 8, pixel / 8);
                // Distance per depth at a point of the pixel, from the angle.
                let slope = |pixel: u32, step: u32| {
                    let raster = f64::from(pixel) + (f64::from(step) + 0.5) / 32.0;
                    let across = view.unwrap_or(0.0);
                    across * (2.0 * raster / f64::from(size) - 1.0)
                };
                for z in [1.5, 2.0, 2.7, 3.9, 4.0, 9.0_f32] {
                    let inside = f64::from(z).clamp(2.0, 4.0) - 2.0;
                    let exact: f64 = (0..1024)
                        .map(|step| {
                            let (x, y) = (slope(left + x, step % 32), slope(top + y, step / 32));
                            let distance = inside * (1.0 + x * x + y * y).sqrt();
                            (-f64::from(EXTINCTION) * distance).exp() / 1024.0
                        })
                        .sum();
                    let found = f64::from(map.pixel(x, y).at(z));
                    let error = (found - exact).abs();
                    assert!(error < 1e-4, "{view:?} {left} {top} at {z}: {error:e}");
                }
            }
        }
    }
}

#[test]
fn a_swept_slab_leaves_its_integral() {
    // A slab a pixel and a half wide that blocks 0.8 of the light and moves by
    // 6 pixels while the shutter is open.
    let (width, path, opacity) = (1.5, 6.0, 0.8_f32);
    let slab = |point: SamplePoint, ray: &mut RayHits<f32>| -> Result<(), Error> {
        let left = 1.0 + path * f64::from(point.time);
        if (left..left + width).contains(&point.x) {
            ray.push_surface(SurfaceHit { depth: 2.0, opacity })?;
        }
        Ok(())
    };
    let samples = 1024;
    let mut settings = BakeSettings::new([10, 4]).unwrap();
    settings.tile_size = 3;
    settings.sampling = PixelSampling::new(samples, 11).unwrap();
    settings.tolerance = Some(Tolerance::EXACT);
    let map = Baker::new(RaySource(slab), settings).unwrap().map().unwrap();
    let mut squares = 0.0;
    for pixel in 0..40_u32 {
        let (x, y) = (pixel % 10, pixel / 10);
        let steps = 400;
        let covered: f64 = (0..steps)
            .map(|step| {
                let left = 1.0 + path * (f64::from(step) + 0.5) / f64::from(steps);
                let (near, far) = (f64::from(x).max(left), f64::from(x + 1).min(left + width));
                (far - near).max(0.0) / f64::from(steps)
            })
            .sum();
        assert_eq!(map.pixel(x, y).before(2.0), 1.0);
        let found = f64::from(map.pixel(x, y).at(2.0));
        let error = found - (1.0 - f64::from(opacity) * covered);
        squares += error * error;
        // Paper 1, §2: noise of up to 0.5/√N, here four times that at most.
        assert!(error.abs() < 2.0 / f64::from(samples).sqrt(), "{x}, {y}: {error}");
        if covered == 0.0 {
            assert_eq!(found, 1.0);
        }
    }
    let deviation = (squares / 40.0).sqrt();
    assert!(deviation < 0.5 / f64::from(samples).sqrt(), "{deviation}");
}
