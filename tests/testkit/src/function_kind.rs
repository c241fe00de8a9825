//! Visibility functions of pixels of seven kinds, for tests and measurements of
//! compressors.

use dsm_core::detail::{SumVertex, TransmittanceBuilder, TransmittanceFunction, VisibilitySweep};
use dsm_core::{RayHits, SurfaceHit, Tolerance, Transmittance, VolumeSample};

use crate::random::Random;

/// What a shadow camera's pixel looks at.
///
/// ```
/// use dsm_testkit::FunctionKind;
///
/// let vertices = FunctionKind::Hair.function::<f32>(16, 7);
/// assert_eq!(vertices[0].value, [1.0]);
/// assert!(vertices.len() > 100 && vertices[vertices.len() - 1].value < [0.6]);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FunctionKind {
    /// Forty translucent strands a ray.
    Hair,
    /// Strands that stop all light, with gaps.
    OpaqueHair,
    /// The silhouette of something round and opaque over a slanted ground.
    Edge,
    /// Slanted opaque leaves, with gaps.
    Foliage,
    /// A medium that varies along and across the rays.
    Smoke,
    /// Translucent strands over a slanted ground.
    HairAndGround,
    /// A pipe that stops half of the rays amid smoke.
    SmokeAndPipe,
}

/// Strands, leaves and densities of one pixel.
struct Pixel {
    random: Random,
    samples: u32,
}

impl FunctionKind {
    /// All kinds.
    pub const ALL: [Self; 7] = [
        Self::Hair,
        Self::OpaqueHair,
        Self::Edge,
        Self::Foliage,
        Self::Smoke,
        Self::HairAndGround,
        Self::SmokeAndPipe,
    ];

    /// The kind in words.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Hair => "hair",
            Self::OpaqueHair => "opaque hair",
            Self::Edge => "one edge",
            Self::Foliage => "foliage",
            Self::Smoke => "smoke",
            Self::HairAndGround => "hair + ground",
            Self::SmokeAndPipe => "smoke + pipe",
        }
    }

    /// The uncompressed function of the mean of `samples` rays, with the chords of a
    /// bake at the default tolerance; `seed` tells pixels of a kind apart.
    #[must_use]
    pub fn function<T: Transmittance>(self, samples: u32, seed: u64) -> Vec<SumVertex<T>> {
        let mut pixel = Pixel { random: Random::new(seed.wrapping_mul(0x9E37_79B9) + 1), samples };
        let rays = self.rays::<T>(&mut pixel);
        let mut builder = TransmittanceBuilder::new(Tolerance::for_samples(samples).chord());
        let functions: Vec<TransmittanceFunction<T>> = rays
            .iter()
            .map(|hits| {
                let mut function = TransmittanceFunction::default();
                builder.build(hits, &mut function);
                function
            })
            .collect();
        let weight = f64::from(samples).recip();
        let weighted: Vec<_> = functions.iter().map(|function| (weight, function)).collect();
        let mut vertices = Vec::new();
        VisibilitySweep::<T>::default().over(&weighted).run(|vertex| vertices.push(vertex));
        vertices
    }

    fn rays<T: Transmittance>(self, pixel: &mut Pixel) -> Vec<RayHits<T>> {
        let mut rays = vec![RayHits::default(); pixel.samples as usize];
        match self {
            Self::Hair => pixel.hair(&mut rays),
            Self::OpaqueHair => pixel.leaves(&mut rays, 300, 0.005, 0.0),
            Self::Edge => {
                pixel.edge(&mut rays);
                pixel.ground(&mut rays);
            }
            Self::Foliage => pixel.leaves(&mut rays, 24, 0.1, 0.5),
            Self::Smoke => pixel.smoke(&mut rays),
            Self::HairAndGround => {
                pixel.hair(&mut rays);
                pixel.ground(&mut rays);
            }
            Self::SmokeAndPipe => {
                pixel.smoke(&mut rays);
                pixel.pipe(&mut rays);
            }
        }
        rays
    }
}

/// A hit whose colours differ where there is more than one.
fn hit<T: Transmittance>(depth: f64, opacity: f64) -> SurfaceHit<T> {
    let opacity = T::from_channels(|channel| (opacity / (1.0 + 0.3 * channel as f64)) as f32);
    SurfaceHit { depth: depth as f32, opacity }
}

impl Pixel {
    /// Where a ray passes the pixel, across it.
    fn place(&mut self, ray: usize) -> f64 {
        (ray as f64 + self.random.unit()) / f64::from(self.samples)
    }

    fn add<T: Transmittance>(rays: &mut RayHits<T>, hit: SurfaceHit<T>) {
        let added = rays.push_surface(hit);
        debug_assert!(added.is_ok(), "depths and opacities are in range");
    }

    /// Five locks of strands, which each ray meets anew.
    fn hair<T: Transmittance>(&mut self, rays: &mut [RayHits<T>]) {
        let locks: Vec<[f64; 2]> =
            (0..5).map(|_| [1.5 + self.random.unit(), 0.05 + 0.2 * self.random.unit()]).collect();
        let opacity = 0.02 + 0.08 * self.random.unit();
        for ray in rays {
            for [depth, radius] in &locks {
                for _ in 0..4 + self.random.below(9) {
                    let within = self.random.unit() + self.random.unit() - 1.0;
                    let opacity = opacity * (0.5 + self.random.unit());
                    Self::add(ray, hit(depth + radius * within, opacity));
                }
            }
        }
    }

    /// The silhouette of something round, over half of the pixel.
    fn edge<T: Transmittance>(&mut self, rays: &mut [RayHits<T>]) {
        let [depth, edge] = [1.5 + 0.5 * self.random.unit(), 0.3 + 0.4 * self.random.unit()];
        for (index, ray) in rays.iter_mut().enumerate() {
            let inside = self.place(index) / edge;
            if inside < 1.0 {
                let depth = depth - 0.2 * (1.0 - inside * inside).sqrt();
                Self::add(ray, SurfaceHit { depth: depth as f32, opacity: T::splat(1.0) });
            }
        }
    }

    /// Opaque leaves that cover this share of the pixel each, and how much their
    /// depth changes across it.
    fn leaves<T: Transmittance>(
        &mut self,
        rays: &mut [RayHits<T>],
        count: u32,
        width: f64,
        slant: f64,
    ) {
        let leaves: Vec<[f64; 3]> = (0..count)
            .map(|_| {
                let depth = 1.5 + self.random.unit();
                let middle = self.random.unit() * (1.0 + width) - 0.5 * width;
                [depth, middle, slant * (2.0 * self.random.unit() - 1.0)]
            })
            .collect();
        for (index, ray) in rays.iter_mut().enumerate() {
            let place = self.place(index);
            for [depth, middle, slant] in &leaves {
                if (place - middle).abs() < 0.5 * width {
                    let opacity = T::splat(1.0);
                    let depth = (depth + slant * (place - middle)) as f32;
                    Self::add(ray, SurfaceHit { depth, opacity });
                }
            }
        }
    }

    fn ground<T: Transmittance>(&mut self, rays: &mut [RayHits<T>]) {
        let [depth, slant] = [3.0 + self.random.unit(), 0.01 + 0.05 * self.random.unit()];
        for (index, ray) in rays.iter_mut().enumerate() {
            let depth = (depth + slant * self.place(index)) as f32;
            Self::add(ray, SurfaceHit { depth, opacity: T::splat(1.0) });
        }
    }

    /// Sixty-four samples of a density along each ray.
    fn smoke<T: Transmittance>(&mut self, rays: &mut [RayHits<T>]) {
        let waves: Vec<[f64; 3]> = (1..6)
            .map(|wave| {
                let [phase, across] = [self.random.unit(), self.random.unit()];
                [f64::from(wave) * (1.0 + self.random.unit()), phase, 2.0 * across - 1.0]
            })
            .collect();
        for (index, ray) in rays.iter_mut().enumerate() {
            let place = self.place(index);
            let samples: Vec<VolumeSample<T>> = (0..64_u8)
                .map(|sample| {
                    let along = f64::from(sample) / 63.0;
                    let density = waves.iter().fold(0.6, |density, [wave, phase, across]| {
                        let turn = wave * along + phase + across * place;
                        density + 0.6 * (std::f64::consts::TAU * turn).sin() / wave
                    });
                    let extinction = T::from_channels(|channel| {
                        (density.max(0.0) / (1.0 + 0.3 * channel as f64)) as f32
                    });
                    VolumeSample { depth: (1.0 + 2.0 * along) as f32, extinction }
                })
                .collect();
            let added = ray.push_volume(&samples, 1.0);
            debug_assert!(added.is_ok(), "depths ascend and extinctions are in range");
        }
    }

    fn pipe<T: Transmittance>(&mut self, rays: &mut [RayHits<T>]) {
        let [depth, edge] = [1.7 + 0.6 * self.random.unit(), 0.3 + 0.4 * self.random.unit()];
        for (index, ray) in rays.iter_mut().enumerate() {
            let place = self.place(index);
            if place < edge {
                // Round, of the pixel's width.
                let depth = depth - 0.02 * (1.0 - place * place).sqrt();
                Self::add(ray, SurfaceHit { depth: depth as f32, opacity: T::splat(1.0) });
            }
        }
    }
}
