//! Maps of several pixels, seen from a light.

use dsm_core::{
    Error, HitSource, PixelSampling, ShadowCamera, SurfaceHit, TileHits, TileSamples, Tolerance,
    Transmittance,
};
use glam::{DMat4, DVec4};
use mtsm::{MultilayerBaker, MultilayerSettings};
use proptest::prelude::*;

pub(crate) const SIZE: [u32; 2] = [7, 5];

/// At the origin, looking down −z, 90 degrees wide.
pub(crate) fn camera() -> ShadowCamera {
    let to_ndc = DMat4::from_cols(
        DVec4::new(0.5, 0.0, 0.0, 0.0),
        DVec4::new(0.0, -0.5, 0.0, 0.0),
        DVec4::new(-0.5, -0.5, -1.0, -1.0),
        DVec4::ZERO,
    );
    ShadowCamera { world_to_camera: Some(DMat4::IDENTITY), world_to_ndc: Some(to_ndc) }
}

/// What the samples of each pixel meet: depths and opacities.
#[derive(Clone, Debug)]
pub(crate) struct Sheets {
    pub(crate) samples: u32,
    pub(crate) pixels: Vec<Vec<(f32, f32)>>,
}

impl<T: Transmittance> HitSource<T> for Sheets {
    type Error = Error;

    fn hits(&self, samples: &TileSamples, hits: &mut TileHits<T>) -> Result<(), Error> {
        for (sample, point) in (0..).zip(samples.points()) {
            let pixel = point.y as usize * SIZE[0] as usize + point.x as usize;
            for (number, &(depth, shade)) in (0..).zip(&self.pixels[pixel]) {
                // Samples meet different sheets, where there are several.
                if self.samples > 1 && (sample + number) % 3 == 0 {
                    continue;
                }
                let opacity =
                    T::from_channels(
                        |channel| {
                            if shade < 1.0 { shade / (channel + 1) as f32 } else { 1.0 }
                        },
                    );
                hits.push_surface(sample, SurfaceHit { depth, opacity })?;
            }
        }
        Ok(())
    }
}

impl Sheets {
    pub(crate) fn baker<T: Transmittance>(
        &self,
        tolerance: f32,
        light_depth: f32,
    ) -> MultilayerBaker<T, Self> {
        let mut settings = MultilayerSettings::new(SIZE).unwrap();
        if self.samples > 1 {
            settings.bake.sampling = PixelSampling::new(self.samples, 1).unwrap();
        }
        settings.bake.camera = Some(camera());
        settings.bake.tolerance = Some(Tolerance::new(tolerance).unwrap());
        (settings.resets, settings.max_layers) = (100, 1000);
        settings.light_depth = light_depth;
        MultilayerBaker::new(self.clone(), settings).unwrap()
    }
}

fn sheet() -> impl Strategy<Value = (f32, f32)> {
    let shade =
        prop_oneof![2 => Just(1.0_f32), 2 => Just(0.5), 2 => Just(0.25), 1 => 0.05_f32..0.9];
    ((2_u8..24).prop_map(|depth| f32::from(depth) / 4.0), shade)
}

pub(crate) fn sheets(samples: u32, most: usize) -> impl Strategy<Value = Sheets> {
    let pixel = proptest::collection::vec(sheet(), 0..most);
    proptest::collection::vec(pixel, (SIZE[0] * SIZE[1]) as usize)
        .prop_map(move |pixels| Sheets { samples, pixels })
}
