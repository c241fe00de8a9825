//! Rays that meet random things, hashed from where and when they are.

use dsm_core::{
    Error, HitSource, RayHits, SamplePoint, SurfaceHit, TileHits, TileSamples, Transmittance,
    VolumeSample,
};
use dsm_testkit::Random;

/// What is in the way of rays.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct RandomScene {
    pub(crate) seed: u64,
    /// Depths and opacities from few values, so that they meet their like.
    pub(crate) on_grid: bool,
    /// One ray in how many meets a medium; 0: none.
    pub(crate) media: u64,
    /// Appends hits from the last sample to the first, as no ray tracer would.
    pub(crate) backwards: bool,
}

impl RandomScene {
    /// What the ray through `point` meets.
    pub(crate) fn ray<T: Transmittance>(
        &self,
        point: SamplePoint,
        ray: &mut RayHits<T>,
    ) -> Result<(), Error> {
        let bits = point.x.to_bits() ^ point.y.to_bits().rotate_left(21);
        let time = u64::from(point.time.to_bits());
        let mut numbers = Random::new(bits ^ time.rotate_left(43) ^ self.seed.rotate_left(11));
        // Some pixels are empty, some rays too.
        let pixel = (point.x.floor() as i64 * 7 + point.y.floor() as i64 * 3) as u64;
        if (pixel ^ self.seed).is_multiple_of(4) {
            return Ok(());
        }
        for _ in 0..numbers.below(5) {
            let depth = self.depth(&mut numbers);
            let opacity = self.opacity(&mut numbers);
            ray.push_surface(SurfaceHit { depth, opacity })?;
        }
        if self.media > 0 && numbers.below(self.media) == 0 {
            let near = self.depth(&mut numbers);
            let samples: Vec<_> = (0..3_u8)
                .map(|index| VolumeSample {
                    depth: near + f32::from(index) * 0.75,
                    extinction: T::from_channels(|_| 1.5 * numbers.unit() as f32),
                })
                .collect();
            ray.push_volume(&samples, point.distance_per_depth)?;
            ray.push_slab(near, near + 0.5, self.opacity(&mut numbers))?;
        }
        Ok(())
    }

    fn depth(&self, numbers: &mut Random) -> f32 {
        if self.on_grid {
            let whole = numbers.below(6) as f32;
            match numbers.below(4) {
                0 => whole.next_up(),
                1 => whole + 0.5,
                _ => whole,
            }
        } else {
            8.0 * numbers.unit() as f32
        }
    }

    fn opacity<T: Transmittance>(&self, numbers: &mut Random) -> T {
        let grey = numbers.below(2) == 0;
        let first = self.one_opacity(numbers);
        T::from_channels(|_| if grey { first } else { self.one_opacity(numbers) })
    }

    fn one_opacity(&self, numbers: &mut Random) -> f32 {
        if self.on_grid {
            let faint = 2.0_f32.powi(-24);
            [0.0, faint, 0.5, 0.5, 1.0 - faint, 1.0][numbers.below(6) as usize]
        } else {
            numbers.unit() as f32
        }
    }
}

impl<T: Transmittance> HitSource<T> for RandomScene {
    type Error = Error;

    fn hits(&self, samples: &TileSamples, hits: &mut TileHits<T>) -> Result<(), Error> {
        let mut ray = RayHits::default();
        for step in 0..samples.len() {
            let index = if self.backwards { samples.len() - 1 - step } else { step };
            ray.clear();
            self.ray(samples.point(index), &mut ray)?;
            hits.push_ray(index, &ray)?;
        }
        Ok(())
    }
}
