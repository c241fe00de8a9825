//! Lookups in a deep map against traced shadows.

use std::fmt::Write;

use anyhow::{Context, Result};
use dsm_core::{Filter, FilterShape, Footprint};
use dsm_scene::builtin_scene;
use dsm_scene::detail::{BUILTIN_SCENES, Image, ImageDifference, RenderSettings};

use super::stage::{Stage, map_settings};

/// One scene: how far its shadow factors are from traced ones.
pub struct ComparisonRow {
    /// The scene's name.
    pub scene: &'static str,
    /// With the pixel that contains each point, and with a tent of two pixels.
    pub differences: [ImageDifference; 2],
    /// The share of all squares that lies in pixels that are off by more than
    /// 0.1, with the tent, and the share of such pixels.
    pub concentration: [f64; 2],
    /// Where they are off: the absolute difference with the tent, and the
    /// traced picture.
    pub pictures: [Image; 2],
}

/// How all built-in scenes are compared.
pub struct Comparison {
    /// Pixels along a side of the map.
    pub map_side: u32,
    /// Samples of a pixel of the map.
    pub map_samples: u32,
    /// Width and height of the pictures.
    pub resolution: [u32; 2],
    /// Camera rays a pixel.
    pub camera_rays: u32,
    /// Shadow rays a camera ray where something moves.
    pub moving_rays: u32,
}

impl Comparison {
    /// Maps of 512² pixels with 64 samples, and as many camera rays.
    #[must_use]
    pub const fn full() -> Self {
        Self {
            map_side: 512,
            map_samples: 64,
            resolution: [320, 180],
            camera_rays: 64,
            moving_rays: 16,
        }
    }

    /// Draws one scene both ways: the same camera rays end at the same points.
    ///
    /// # Errors
    ///
    /// If the scene is none, or its map cannot be baked.
    pub fn measure(&self, scene: &'static str) -> Result<ComparisonRow> {
        let stage = Stage::new(builtin_scene(scene)?, self.resolution)?;
        let mut settings = RenderSettings::new(self.camera_rays, 0)?;
        settings.factor = true;
        let tent = Footprint::Isotropic(Filter::new(FilterShape::Tent, 2.0)?);
        let map = map_settings(self.map_side, self.map_samples)?;
        let images = stage.draw_filtered(&map, &[Footprint::Point, tent], &settings)?;
        let [point, tent]: [Image; 2] = images.try_into().ok().context("two were drawn")?;
        let traced = stage.draw_traced(self.moving_rays, &settings)?;
        let difference = |image: &Image| image.difference(&traced).context("both are of one size");
        let off = tent.pixels().iter().zip(traced.pixels()).map(|(tent, traced)| {
            [0, 1, 2].map(|channel: usize| (tent[channel] - traced[channel]).abs())
        });
        let off = Image::new(traced.size(), off.collect()).context("as many pixels")?;
        let part = |pixel: &[f32; 3]| pixel.iter().map(|&d| f64::from(d * d)).sum::<f64>();
        let far = |pixel: &&[f32; 3]| pixel.iter().any(|&d| d > 0.1);
        // Nothing adds up to −0.
        let sum = |squares: f64, pixel: &[f32; 3]| squares + part(pixel);
        let all = off.pixels().iter().fold(0.0, sum);
        let there = off.pixels().iter().filter(far).fold(0.0, sum);
        let pixels = off.pixels().iter().filter(far).count() as f64 / off.pixels().len() as f64;
        Ok(ComparisonRow {
            scene,
            differences: [difference(&point)?, difference(&tent)?],
            concentration: [if all > 0.0 { there / all } else { 0.0 }, pixels],
            pictures: [off, traced],
        })
    }

    /// Compares all built-in scenes: a page, and a picture of where the scenes
    /// with the largest differences are off.
    ///
    /// # Errors
    ///
    /// As [`Self::measure`].
    pub fn page(&self) -> Result<(String, Image)> {
        let rows = BUILTIN_SCENES.iter().map(|scene| self.measure(scene));
        let rows = rows.collect::<Result<Vec<_>>>()?;
        let Self { map_side, map_samples, resolution: [width, height], camera_rays, .. } = self;
        let mut page = format!(
            "# Rendered shadows against traced ones\n\n\
             Shadow factors at the points where the camera rays of a picture end ({width} × \
             {height} pixels, {camera_rays} rays each), from deep maps of {map_side} × {map_side} \
             pixels with {map_samples} samples each (tolerance 0.25/√N), and traced to a point \
             light. The difference of the two pictures' pixels; bias `auto`.\n\n\
             Made by `cargo run --release -p dsm-experiments --bin pictures -- comparison`.\n\n\
             | scene | RMSE, tent of 2 | mean | standard deviation | max | RMSE, one pixel | \
             off by > 0.1 | their share of the squares |\n\
             | --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: |\n"
        );
        for ComparisonRow { scene, differences: [point, tent], concentration, .. } in &rows {
            let [share, pixels] = concentration.map(|part| 100.0 * part);
            writeln!(
                page,
                "| `{scene}` | {:.4} | {:+.4} | {:.4} | {:.3} | {:.4} | {pixels:.2} % | {share:.0} % |",
                tent.rmse, tent.mean, tent.standard_deviation, tent.max, point.rmse
            )?;
        }
        page.push('\n');
        let mut worst: Vec<&ComparisonRow> = rows.iter().collect();
        worst.sort_by(|a, b| b.differences[1].rmse.total_cmp(&a.differences[1].rmse));
        let worst: Vec<&ComparisonRow> = worst.into_iter().take(3).collect();
        let names: Vec<_> = worst.iter().map(|row| format!("`{}`", row.scene)).collect();
        write!(
            page,
            "Where the three with the largest RMSE are off, {} from left to right (white: by a \
             quarter or more):\n\n![Differences](../images/render-differences.png)\n",
            names.join(", ")
        )?;
        page.push('\n');
        page.push_str(include_str!("comparison.md"));
        let images: Vec<Image> =
            worst.iter().filter_map(|row| brighter(&row.pictures[0])).collect();
        Ok((page, Image::beside(&images).context("all are as high")?))
    }
}

/// Four times as bright.
fn brighter(image: &Image) -> Option<Image> {
    let pixels = image.pixels().iter().map(|pixel| pixel.map(|value| (4.0 * value).min(1.0)));
    Image::new(image.size(), pixels.collect())
}
