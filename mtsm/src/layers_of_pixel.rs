//! The layers of a pixel as shadow rays meet them, of a map or of a tile.

use dsm_core::Transmittance;

use crate::depth_layers::DepthLayers;
use crate::layered_pixels::LayeredPixels;
use crate::leaf_rule::{Interval, RayLight};

/// Pixels whose layers shadow rays meet, each by its row-major index.
pub trait PixelLayers<T: Transmittance> {
    /// The smallest and the largest depth of a pixel's layers.
    fn depth_range(&self, pixel: usize) -> Option<[f32; 2]>;

    /// What the first layer leaves at `depth`.
    fn behind_first(&self, pixel: usize, depth: f32) -> T;

    /// What all layers leave at `depth`, in the first run.
    fn behind_all(&self, pixel: usize, depth: f32) -> T;

    /// Takes what the layers in an interval take from a ray's light.
    #[expect(private_interfaces, reason = "nobody else can name this trait")]
    fn pass(&self, pixel: usize, interval: &Interval, light: &mut RayLight<T>);

    /// Does so without shortcuts.
    #[expect(private_interfaces, reason = "nobody else can name this trait")]
    fn pass_naively(&self, pixel: usize, interval: &Interval, light: &mut RayLight<T>);
}

impl<T: Transmittance> PixelLayers<T> for LayeredPixels<T> {
    fn depth_range(&self, pixel: usize) -> Option<[f32; 2]> {
        self.depth_range(pixel)
    }

    fn behind_first(&self, pixel: usize, depth: f32) -> T {
        let first = self.first_run(pixel).and_then(|run| {
            let mut layers = run.layers().skip(1).filter(|layer| layer.visibility != T::CLEAR);
            layers.next()
        });
        let before = first.filter(|layer| layer.depth <= depth);
        before.map_or(T::CLEAR, |layer| layer.visibility)
    }

    fn behind_all(&self, pixel: usize, depth: f32) -> T {
        self.first_run(pixel).map_or(T::CLEAR, |run| run.function().at(depth))
    }

    #[expect(private_interfaces, reason = "nobody else can name this trait")]
    fn pass(&self, pixel: usize, interval: &Interval, light: &mut RayLight<T>) {
        self.runs(pixel).rev().for_each(|run| light.pass_run(run, interval));
    }

    #[expect(private_interfaces, reason = "nobody else can name this trait")]
    fn pass_naively(&self, pixel: usize, interval: &Interval, light: &mut RayLight<T>) {
        self.runs(pixel).rev().for_each(|run| light.pass_run_naively(run, interval));
    }
}

impl<T: Transmittance> PixelLayers<T> for DepthLayers<T> {
    fn depth_range(&self, pixel: usize) -> Option<[f32; 2]> {
        self.depth_range(pixel)
    }

    fn behind_first(&self, pixel: usize, depth: f32) -> T {
        let first = self.layers(pixel).next().filter(|layer| layer.depth <= depth);
        first.map_or(T::CLEAR, |layer| layer.transmittance())
    }

    fn behind_all(&self, pixel: usize, depth: f32) -> T {
        self.transmittance(pixel, depth)
    }

    #[expect(private_interfaces, reason = "nobody else can name this trait")]
    fn pass(&self, pixel: usize, interval: &Interval, light: &mut RayLight<T>) {
        light.pass_layers(self.layers(pixel), interval);
    }

    #[expect(private_interfaces, reason = "nobody else can name this trait")]
    fn pass_naively(&self, pixel: usize, interval: &Interval, light: &mut RayLight<T>) {
        light.pass_layers(self.layers(pixel), interval);
    }
}
