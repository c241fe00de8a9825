//! Interactions of camera rays with surfaces, strands and media.

use dsm_core::{Ray, Rgb, Transmittance};
use glam::DVec3;

use crate::trace::traced_scene::{TracedScene, Tracer};
use crate::trace::{DensitySample, HitGeometry, scaled};

/// The interaction that a camera ray ends with: one of all those whose light it
/// carries, each sampled as often as its share of that light.
#[derive(Clone, Copy, Debug)]
pub(super) struct Interaction {
    pub(super) position: DVec3,
    pub(super) material: Material,
    /// The weight of each channel's light, for having been sampled as often as
    /// the mean of the channels: 1 where nothing has a colour.
    pub(super) weight: [f64; 3],
}

/// The material of an interaction.
#[derive(Clone, Copy, Debug)]
pub(super) enum Material {
    /// A surface; the unit normal is on the side that is seen.
    Surface { normal: DVec3 },
    /// A strand: the unit vector along it, and its radius. The position is in
    /// its middle.
    Strand { along: DVec3, radius: f64 },
    /// A medium.
    Medium,
}

/// A tracer of camera rays.
pub(super) struct PathTracer<'a> {
    tracer: Tracer<'a>,
    is_coloured: bool,
}

impl<'a> PathTracer<'a> {
    pub(super) fn new(scene: &'a TracedScene) -> Self {
        Self { tracer: scene.tracer(), is_coloured: scene.is_coloured() }
    }

    /// The interaction that the ray ends with; `None`: none.
    ///
    /// `surface` in [0, 1) tells how much of the surfaces' light it passes,
    /// `medium` gives such a number for every medium: evenly spread numbers
    /// take each place as often as its share.
    ///
    /// Coloured material scatters the part of the light that it blocks in all
    /// channels, and swallows the rest: a red pane is not cyan from the front.
    pub(super) fn interaction(
        &mut self,
        ray: &Ray,
        surface: f64,
        medium: impl FnMut() -> f64,
    ) -> Option<Interaction> {
        let hit = self.tracer.first_below(ray, 1.0 - surface);
        let [near, far] = ray.range();
        let before = ray.within(near, hit.map_or(far, |hit| hit.t));
        let (t, opacity, material, position) = match self.first_in_media(&before, medium) {
            Some((t, opacity)) => (t, opacity, Material::Medium, ray.at(t)),
            None => {
                let hit = hit?;
                let (material, position) = match hit.geometry {
                    HitGeometry::Surface { normal } => {
                        let normal = normal.unwrap_or(-ray.direction().normalize());
                        let seen = if normal.dot(ray.direction()) > 0.0 { -normal } else { normal };
                        (Material::Surface { normal: seen }, ray.at(hit.t))
                    }
                    HitGeometry::Strand { middle, along, radius } => {
                        (Material::Strand { along, radius }, middle)
                    }
                };
                (hit.t, hit.opacity, material, position)
            }
        };
        let weight = self.weight(&ray.within(near, t), opacity);
        Some(Interaction { position, material, weight })
    }

    /// The parameter at which the ray ends in a medium, and that medium's colour.
    fn first_in_media(&mut self, ray: &Ray, mut medium: impl FnMut() -> f64) -> Option<(f64, Rgb)> {
        let length = ray.direction().length();
        let mut first: Option<(f64, Rgb)> = None;
        // The medium that is being gone through, and the optical depth to go.
        let mut current = (usize::MAX, 0.0);
        self.tracer.densities(ray, |index, object, samples| {
            if current.0 != index {
                current = (index, -(1.0 - medium()).ln());
            }
            let opacity = f64::from(scaled::<f32>(object.opacity, 1.0));
            let scale = f64::from(object.density) * opacity * length;
            if current.1 < 0.0 {
                return;
            }
            if let Some(t) = depth_within(samples, scale, &mut current.1) {
                current.1 = -1.0;
                if first.is_none_or(|(before, _)| t < before) {
                    first = Some((t, object.opacity));
                }
            }
        });
        first
    }

    /// The weight of an interaction of this opacity at the end of the ray.
    fn weight(&mut self, ray: &Ray, opacity: Rgb) -> [f64; 3] {
        if !self.is_coloured {
            return [1.0; 3];
        }
        let left: Rgb = self.tracer.transmittance(ray);
        let mean: f32 = self.tracer.transmittance(ray);
        let blocked: f32 = scaled(opacity, 1.0);
        let scattered = opacity.red.min(opacity.green).min(opacity.blue);
        left.to_sum().map(|left| {
            let weight = left * f64::from(scattered) / (f64::from(mean) * f64::from(blocked));
            if weight.is_finite() { weight } else { 0.0 }
        })
    }
}

/// The t along the samples where the optical depth `left` is used up; else takes
/// theirs off it. `scale` is optical depth per density and unit of t.
fn depth_within(samples: &[DensitySample], scale: f64, left: &mut f64) -> Option<f64> {
    for pair in samples.windows(2) {
        let [from, to] = [pair[0].density, pair[1].density].map(|d| f64::from(d) * scale);
        let length = pair[1].t - pair[0].t;
        let whole = 0.5 * (from + to) * length;
        if whole > *left {
            // from·s + (to − from)/(2 length)·s² = left, in the form that does
            // not divide by a difference.
            let slope = (to - from) / length;
            let root = (from * from + 2.0 * slope * *left).max(0.0).sqrt();
            let step = 2.0 * *left / (from + root);
            return Some(pair[0].t + step.clamp(0.0, length));
        }
        *left -= whole;
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn optical_depth_is_used_up_where_its_integral_says() {
        let sample = |t, density| DensitySample { t, density };
        let samples = [sample(1.0, 0.0), sample(3.0, 2.0), sample(4.0, 2.0), sample(6.0, 0.0)];
        // 2, 2 and 2 of optical depth at scale 1.
        for (depth, expected) in [(0.5, 2.0), (2.0 + 1.0, 3.5), (4.0 + 1.5, 5.0)] {
            let mut left = depth;
            let t = depth_within(&samples, 1.0, &mut left).unwrap();
            assert!((t - expected).abs() < 1e-12, "{depth}: {t}");
        }
        let mut left = 13.0;
        assert_eq!(depth_within(&samples, 2.0, &mut left), None);
        assert!((left - 1.0).abs() < 1e-12);
        let mut left = 0.0;
        assert_eq!(depth_within(&samples[1..], 1.0, &mut left), Some(3.0));
    }
}
