//! The page of coherent sampling.

use std::fmt::Write as _;
use std::io::Write as _;
use std::time::Instant;

use anyhow::{Context, Result};
use dsm_core::{AreaLight, ShadedPoint};
use dsm_scene::detail::SceneReference;
use dsm_trace::detail::CoherenceSettings;

use super::measured::Measured;
use super::{errors, strips};
use crate::attenuation::peers::tracer as views;
use crate::attenuation::scenes::scenes;
use crate::attenuation::strips::Drawn;
use crate::figures::{machine, table};
use crate::prefilter::page::Compared;
use crate::soft_shadows::{Map, Method, Page, Stage};

/// Points of a picture that are asked together, in pixels a side: what `render` takes.
const BLOCK: usize = 16;

/// How much is measured.
pub struct Effort {
    /// Width and height of pictures.
    pub image: [u32; 2],
    /// Pixels along a side of maps.
    pub map: u32,
    /// Cells along a side of the light.
    pub sides: Vec<u32>,
    /// Of so many blocks of a picture one is taken.
    pub every: usize,
    /// Receivers along a side of the ground of figure 9.
    pub receivers: Vec<u32>,
    /// Pictures are so many times as large as the smallest.
    pub scale: u32,
}

impl Effort {
    /// As in the paper.
    #[must_use]
    pub fn full() -> Self {
        let (sides, receivers) = (vec![8, 16, 32], vec![16, 32, 64, 128]);
        Self { image: [512; 2], map: 1024, sides, every: 32, receivers, scale: 10 }
    }

    /// As little as still shows the same.
    #[must_use]
    pub fn small() -> Self {
        let (sides, receivers) = (vec![4, 8], vec![8, 16]);
        Self { image: [64; 2], map: 64, sides, every: 4, receivers, scale: 1 }
    }
}

/// Measures everything, on the scenes that are made here and on those of `compared`.
///
/// # Errors
///
/// What a scene is not.
pub fn page(effort: &Effort, compared: &[Compared]) -> Result<Page> {
    let start = Instant::now();
    let tell = |what: &str| {
        writeln!(std::io::stderr(), "{what}: {:.0} s in", start.elapsed().as_secs_f64())
    };
    let (mut pictures, mut others) = (Vec::new(), String::new());
    for (name, scene) in scenes()? {
        let stage = Stage::new(name, scene, effort.image)?;
        let groups = stage.blocks(BLOCK, effort.every);
        let light = stage.scene.light.area()?;
        pictures.extend(tracers(name, &stage.scene, &groups, &light, effort)?);
        tell(name)?;
    }
    for Compared { peer, .. } in compared {
        let light = peer.light()?;
        let groups: Vec<_> = peer.points.chunks(1 << 10).map(<[ShadedPoint]>::to_vec).collect();
        let short = Effort { sides: vec![16], ..Effort::full() };
        let rows = tracers(&peer.name, &peer.scene, &groups, &light, &short)?;
        writeln!(others, "{}", rows_table(rows))?;
        tell(&peer.name)?;
    }
    let errors = errors::compare(&effort.receivers, &effort.sides)?;
    tell("what is missed")?;
    let [.., (_, knot)] = scenes()?;
    let drawn = Drawn::of(knot, effort.scale)?;
    let strip = strips::equal_time(&drawn, 9)?;
    let text = format!(
        include_str!("page.md"),
        machine = machine(),
        pictures = rows_table(pictures).trim_end(),
        others = others.trim_end(),
        errors = errors.trim_end(),
        every = effort.every,
        map = effort.map,
    );
    let images = vec![("images/coherence.png".to_owned(), strip.to_png()?)];
    Ok(Page { name: "coherence", text, pictures: images })
}

fn rows_table(rows: Vec<Vec<String>>) -> String {
    let columns: Vec<&str> =
        ["scene", "tracer", "cells"].into_iter().chain(Measured::COLUMNS).collect();
    table(&columns, rows)
}

/// Rows of each tracer and number of cells.
fn tracers(
    name: &str,
    scene: &dsm_scene::Scene,
    groups: &[Vec<ShadedPoint>],
    light: &AreaLight,
    effort: &Effort,
) -> Result<Vec<Vec<String>>> {
    let mut rows = Vec::new();
    let through_scene = SceneReference::<f32>::new(dsm_scene::TracedScene::new(scene)?);
    let through_views = views(scene, effort.map, 4)?.with_blockers();
    let map = Map::new(scene, &scene.light, Method::Ratio, effort.map)?;
    let through_layers = map.layers_tracer()?.context("a map of layers")?;
    for &side in &effort.sides {
        let settings = CoherenceSettings::new(side);
        let found = [
            ("the scene", Measured::new(&through_scene, groups, light, settings)),
            ("4 views", Measured::new(&through_views, groups, light, settings)),
            ("MTSM", Measured::new(&through_layers, groups, light, settings)),
        ];
        for (tracer, found) in found {
            let start = [name.to_owned(), tracer.to_owned(), (side * side).to_string()];
            rows.push(start.into_iter().chain(found.cells()).collect());
        }
    }
    Ok(rows)
}
