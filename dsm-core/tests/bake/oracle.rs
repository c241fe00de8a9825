//! Visibility as equation 1 has it: all hits of all samples under the filter,
//! at one depth, in f64.

use dsm_core::{BakeSettings, Error, RayHits, SamplePoint, TileSamples, Transmittance};

/// One pixel's samples under the filter: their weights and what they meet.
pub(crate) struct Oracle<T: Transmittance> {
    rays: Vec<(f64, RayHits<T>)>,
}

impl<T: Transmittance> Oracle<T> {
    pub(crate) fn new(
        settings: &BakeSettings,
        [x, y]: [u32; 2],
        ray: impl Fn(SamplePoint, &mut RayHits<T>) -> Result<(), Error>,
    ) -> Self {
        // More than any filter of the tests reaches.
        let reach = 4;
        let min = [x as i32 - reach, y as i32 - reach];
        let camera = settings.camera.as_ref().map(|camera| (camera, settings.size));
        let samples = TileSamples::new(&settings.sampling, min, [9, 9], camera).unwrap();
        let centre = [f64::from(x) + 0.5, f64::from(y) + 0.5];
        let mut rays: Vec<_> = samples
            .points()
            .map(|point| {
                let mut hits = RayHits::default();
                ray(point, &mut hits).unwrap();
                (settings.filter.weight(point.x - centre[0], point.y - centre[1]), hits)
            })
            .filter(|&(weight, _)| weight > 0.0)
            .collect();
        let sum: f64 = rays.iter().map(|(weight, _)| weight).sum();
        rays.iter_mut().for_each(|(weight, _)| *weight /= sum);
        Self { rays }
    }

    /// V(z), or its limit from the light's side.
    pub(crate) fn visibility(&self, channel: usize, z: f32, inclusive: bool) -> f64 {
        self.rays.iter().map(|(weight, hits)| weight * left(hits, channel, z, inclusive)).sum()
    }

    /// Depths that tell: where something happens, beside it and in between.
    pub(crate) fn depths(&self) -> Vec<f32> {
        let ends = |hits: &RayHits<T>| -> Vec<f32> {
            let surfaces = hits.surfaces().iter().map(|surface| surface.depth);
            let segments = hits.segments().iter().flat_map(|segment| [segment.near, segment.far]);
            surfaces.chain(segments).collect()
        };
        let mut depths: Vec<f32> = self.rays.iter().flat_map(|(_, hits)| ends(hits)).collect();
        depths.extend([0.0, 20.0]);
        depths.sort_by(f32::total_cmp);
        depths.dedup();
        let middles: Vec<f32> =
            depths.windows(2).map(|pair| 0.5 * pair[0] + 0.5 * pair[1]).collect();
        let neighbours: Vec<f32> =
            depths.iter().flat_map(|z| [z.next_up(), z.next_down()]).collect();
        depths.extend(middles);
        depths.extend(neighbours);
        depths.retain(|z| *z >= 0.0);
        let stride = depths.len() / 60 + 1;
        depths.into_iter().step_by(stride).collect()
    }

    pub(crate) fn meets_media(&self) -> bool {
        self.rays.iter().any(|(_, hits)| !hits.segments().is_empty())
    }
}

/// τ(z) from its definition.
fn left<T: Transmittance>(hits: &RayHits<T>, channel: usize, z: f32, inclusive: bool) -> f64 {
    let surfaces: f64 = hits
        .surfaces()
        .iter()
        .filter(|surface| surface.depth < z || (inclusive && surface.depth == z))
        .map(|surface| 1.0 - f64::from(surface.opacity.channel(channel)))
        .product();
    let optical_depth: f64 = hits
        .segments()
        .iter()
        .map(|segment| {
            let (near, far) = (f64::from(segment.near), f64::from(segment.far));
            let length = (f64::from(z).clamp(near, far)) - near;
            let (from, to) = (
                segment.near_extinction.as_ref()[channel],
                segment.far_extinction.as_ref()[channel],
            );
            length * (from + (to - from) * 0.5 * length / (far - near))
        })
        .sum();
    surfaces * (-optical_depth).exp()
}
