//! The light through a pixel as the reference has it: a plain mean over rays.

use dsm_core::{Filter, PixelSampling, Ray, RayHits, TileSamples, Transmittance, ViewRaster};
use dsm_scene::TracedScene;

/// What is left in each channel; a mono value fills all three.
pub(crate) type Channels = [f64; 3];

/// The rays through a pixel's filter, with weights that sum to 1.
pub(crate) struct PixelRays {
    pub(crate) rays: Vec<(f64, Ray)>,
}

impl PixelRays {
    pub(crate) fn new(
        raster: &ViewRaster,
        sampling: &PixelSampling,
        filter: Filter,
        [x, y]: [u32; 2],
    ) -> Self {
        let border = (0.5 * f64::from(filter.width()) - 0.5).ceil() as u32;
        let min = [x, y].map(|first| first as i32 - border as i32);
        let samples = TileSamples::new(sampling, min, [2 * border + 1; 2], None).unwrap();
        let centre = [x, y].map(|first| f64::from(first) + 0.5);
        let offsets: Vec<_> =
            samples.points().map(|point| (point.x - centre[0], point.y - centre[1])).collect();
        let weights = filter.normalized_weights(&offsets);
        let rays = samples.points().map(|p| raster.ray(p.x, p.y, f64::from(p.time)));
        Self { rays: weights.into_iter().zip(rays).filter(|(weight, _)| *weight > 0.0).collect() }
    }

    /// 1/N for N rays that weigh the same and are as noisy.
    pub(crate) fn noise(&self) -> f64 {
        self.rays.iter().map(|(weight, _)| weight * weight).sum()
    }

    /// The mean of what [`dsm_scene::detail::Tracer::transmittance`] says of each ray
    /// up to t = `far`.
    pub(crate) fn traced<T: Transmittance>(&self, scene: &TracedScene, far: f64) -> Channels {
        let mut tracer = scene.tracer();
        let mut mean = [0.0; 3];
        for (weight, ray) in &self.rays {
            let left: T = tracer.transmittance(&ray.within(0.0, far));
            add(&mut mean, *weight, channels(left));
        }
        mean
    }

    /// All that each ray meets, so that many depths can be asked for.
    pub(crate) fn hits<T: Transmittance>(&self, scene: &TracedScene) -> PixelHits<T> {
        let mut tracer = scene.tracer();
        let hits = self.rays.iter().map(|(weight, ray)| {
            let mut hits = RayHits::default();
            tracer.hits(ray, &mut hits).unwrap();
            (*weight, hits)
        });
        PixelHits { hits: hits.collect() }
    }
}

/// What the rays through a pixel meet.
pub(crate) struct PixelHits<T: Transmittance> {
    pub(crate) hits: Vec<(f64, RayHits<T>)>,
}

impl<T: Transmittance> PixelHits<T> {
    /// The depths of surfaces and of the ends of media, ascending.
    pub(crate) fn depths(&self) -> Vec<f32> {
        let mut depths: Vec<f32> = Vec::new();
        for (_, hits) in &self.hits {
            depths.extend(hits.surfaces().iter().map(|hit| hit.depth));
            depths.extend(hits.segments().iter().flat_map(|segment| [segment.near, segment.far]));
        }
        depths.sort_by(f32::total_cmp);
        depths.dedup();
        depths
    }

    /// The mean of what is left behind everything at depth ≤ `z`: the product
    /// of surfaces, times the exponential of the optical depth.
    pub(crate) fn at(&self, z: f32) -> Channels {
        let mut mean = [0.0; 3];
        for (weight, hits) in &self.hits {
            add(&mut mean, *weight, left_at(hits, z));
        }
        mean
    }
}

fn left_at<T: Transmittance>(hits: &RayHits<T>, z: f32) -> Channels {
    let mut left = [1.0; 3];
    for hit in hits.surfaces().iter().filter(|hit| hit.depth <= z) {
        let opacity = channels(hit.opacity);
        (0..3).for_each(|channel| left[channel] *= 1.0 - opacity[channel]);
    }
    for segment in hits.segments().iter().filter(|segment| segment.near < z) {
        let length = f64::from(segment.far) - f64::from(segment.near);
        let share = ((f64::from(z) - f64::from(segment.near)) / length).min(1.0);
        let (near, far) = (segment.near_extinction, segment.far_extinction);
        for (channel, left) in left.iter_mut().enumerate() {
            let channel = channel.min(T::CHANNELS - 1);
            let (near, far) = (near.as_ref()[channel], far.as_ref()[channel]);
            let optical = length * share * (near + 0.5 * share * (far - near));
            *left *= (-optical).exp();
        }
    }
    left
}

pub(crate) fn channels<T: Transmittance>(value: T) -> Channels {
    [0, 1, 2].map(|channel: usize| f64::from(value.channel(channel.min(T::CHANNELS - 1))))
}

fn add(mean: &mut Channels, weight: f64, value: Channels) {
    mean.iter_mut().zip(value).for_each(|(mean, value)| *mean += weight * value);
}
