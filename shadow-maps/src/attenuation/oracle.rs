//! Attenuation maps as naively as can be: every texel asks every pixel of every view.

use dsm_core::ViewRaster;
use glam::DVec3;

/// A layer: its w, what views pass to it together, and those that do.
pub(super) type Layer = (f64, f64, u32);

/// The hits of a pixel: depth and opacity, the nearest first.
pub(super) type Pixel = Vec<(f32, f32)>;

/// The place of a hit in the world.
pub(super) fn world(view: &ViewRaster, pixel: [u32; 2], depth: f32) -> DVec3 {
    view.ray(f64::from(pixel[0]) + 0.5, f64::from(pixel[1]) + 0.5, 0.0).at(depth.into())
}

/// The layers of one texel, in the order they came.
pub(super) fn layers(
    centre: &ViewRaster,
    views: &[(ViewRaster, Vec<Pixel>)],
    texel: [u32; 2],
    reach: f64,
) -> Vec<Layer> {
    let [width, height] = centre.resolution();
    // Of each layer: what each view passes to it.
    let mut found: Vec<(f64, Vec<f64>)> = Vec::new();
    for (number, (view, pixels)) in views.iter().enumerate() {
        for (y, x) in (0..height).flat_map(|y| (0..width).map(move |x| (y, x))) {
            let mut left = 1.0;
            for &(depth, opacity) in &pixels[(y * width + x) as usize] {
                let place = centre.project(world(view, [x, y], depth));
                let around = place.filter(|place| {
                    let off = [0, 1]
                        .map(|axis| (f64::from(texel[axis]) + 0.5 - place[axis]).abs().min(1.0));
                    (1.0 - off[0]) * (1.0 - off[1]) > 1e-6
                });
                if let Some(place) = around.filter(|_| left > 0.0) {
                    let w = place.z.recip();
                    let near = found
                        .iter()
                        .enumerate()
                        .filter(|(_, (own, _))| (own - w).abs() <= reach * w)
                        .min_by(|(_, (a, _)), (_, (b, _))| (a - w).abs().total_cmp(&(b - w).abs()))
                        .map(|(index, _)| index);
                    let index = near.unwrap_or_else(|| {
                        found.push((w, vec![0.0; views.len()]));
                        found.len() - 1
                    });
                    let passed = &mut found[index].1[number];
                    *passed = f64::max(*passed, left);
                }
                left = f64::from(left as f32 * (1.0 - opacity));
            }
        }
    }
    let layer = |(w, passed): (f64, Vec<f64>)| {
        let views = passed.iter().filter(|&&passed| passed > 0.0).count();
        (w, passed.iter().sum(), views as u32)
    };
    found.into_iter().map(layer).collect()
}

/// Views whose raster holds the middle of a texel at this w.
pub(super) fn holding(
    centre: &ViewRaster,
    views: &[(ViewRaster, Vec<Pixel>)],
    texel: [u32; 2],
    w: f64,
) -> u32 {
    let place = world(centre, texel, 1.0) - centre.eye();
    let place = centre.eye() + place / w;
    let size = centre.resolution().map(f64::from);
    let holds = |view: &ViewRaster| {
        view.project(place)
            .is_some_and(|at| (0.0..size[0]).contains(&at.x) && (0.0..size[1]).contains(&at.y))
    };
    views.iter().filter(|(view, _)| holds(view)).count() as u32
}
