//! The page of prefiltered maps.

use std::fmt::Write as _;
use std::path::Path;

use anyhow::{Context, Result};
use dsm_io::{Packing, WriteOptions};
use shadow_maps::detail::{Accumulate, Epsilon, ListBuilder, PrefilterSettings, bake_prefiltered};

use super::peer::PeerScene;
use super::run::{Outcome, Setup, run};
use crate::figures::machine;
use crate::soft_shadows::Page;

/// Rays of a receiver that lights of other sizes are compared with.
const RAYS: u32 = 1024;

/// A scene, and what Embree takes for a point of it.
pub struct Compared {
    /// The scene.
    pub peer: PeerScene,
    /// Microseconds a point on one thread, 256 rays each.
    pub embree: Option<f64>,
}

impl Compared {
    /// Opens a folder whose `reference.csv` has shadow factors by 256 rays, and whose
    /// `embree.txt`, if there is one, the microseconds that Embree took for a point.
    ///
    /// # Errors
    ///
    /// What a file is not.
    pub fn open(folder: &Path, every: usize) -> Result<Self> {
        let peer = PeerScene::open(folder, "reference.csv", every)?;
        let told = std::fs::read_to_string(folder.join("embree.txt")).ok();
        let embree = told.map(|text| text.trim().parse()).transpose();
        Ok(Self { peer, embree: embree.context("embree.txt holds no number")? })
    }
}

/// How maps are made and asked, by name.
fn variants() -> Vec<(&'static str, Setup)> {
    let default = Setup::default;
    let filtering = |change: fn(PrefilterSettings) -> PrefilterSettings| Setup {
        filtering: change(PrefilterSettings::default()),
        ..default()
    };
    let widths = |widths: f32| Setup {
        filtering: PrefilterSettings::default().with_epsilon(Epsilon::Widths(widths)),
        ..default()
    };
    let accumulate = |accumulate| Setup {
        filtering: PrefilterSettings::default().with_accumulate(accumulate),
        accumulate,
        ..default()
    };
    vec![
        ("defaults", default()),
        ("with normals", Setup { normals: true, ..default() }),
        ("with normals, light in 2 × 2", Setup { normals: true, splits: 2, ..default() }),
        ("hybrid, 16 rays", Setup { hybrid: Some((16, 8.0)), ..default() }),
        (
            "hybrid, 64 rays, light in 2 × 2",
            Setup { hybrid: Some((64, 8.0)), splits: 2, ..default() },
        ),
        (
            "as published",
            Setup {
                filtering: PrefilterSettings::paper(),
                accumulate: Accumulate::Add,
                ..default()
            },
        ),
        ("1 layer", Setup { layers: Some(1), ..default() }),
        ("2 layers", Setup { layers: Some(2), ..default() }),
        ("ε 2w", widths(2.0)),
        ("ε 10w", widths(10.0)),
        ("ε 130w", widths(130.0)),
        ("5 levels", filtering(|it| it.with_max_level(Some(4)))),
        ("MIP-map", filtering(|it| it.with_stack_size(None))),
        ("additive", accumulate(Accumulate::Add)),
        ("maximum", accumulate(Accumulate::Max)),
        ("base 512", Setup { resolution: 512, ..default() }),
        ("base 2048", Setup { resolution: 2048, ..default() }),
    ]
}

fn row(name: &str, found: &Outcome, embree: Option<f64>) -> String {
    let [ground, object, all] = found.differences;
    let micros = (found.micros[0] + found.micros[1]) / 2.0;
    let times = embree.map_or("–".to_owned(), |embree| format!("{:.1}", embree / micros));
    let [collect, sort, filter] = found.seconds;
    let base = found.fragments.first().copied().unwrap_or(0).max(1) as f64;
    let others: usize = found.fragments.iter().skip(1).sum();
    format!(
        "| {name} | {:.4} | {:.4} | {:.4} | {:+.4} | {micros:.2} | {times} | {collect:.2} | {sort:.2} \
         | {filter:.2} | {:.0} | {:.2} |\n",
        all.rmse,
        ground.rmse,
        object.rmse,
        all.mean,
        filter * 1e9 / base,
        others as f64 / base,
    )
}

const HEADER: &str = "| | RMSE | ground | object | mean | µs a point | times Embree | collect, s | sort, s | \
                      filter, s | ns a base fragment | fragments above the base |\n\
                      | --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: |\n";

/// Measures everything and writes the page.
///
/// # Errors
///
/// What a scene is not.
pub fn page(scenes: &[Compared], times: u32) -> Result<Page> {
    let mut text = include_str!("page.md").replace("MACHINE", &machine());
    for Compared { peer, embree } in scenes {
        let told = embree.map_or(String::new(), |told| format!(", Embree {told:.1} µs a point"));
        writeln!(text, "\n## {}{told}\n\n{}", peer.name, HEADER.trim_end())?;
        for (name, setup) in variants() {
            text += &row(name, &run(peer, &setup, times)?, *embree);
        }
        for scale in [0.1, 0.3, 2.0] {
            let other = peer.with_light(scale, RAYS)?;
            let plain = run(&other, &Setup::default(), times)?;
            text += &row(&format!("light × {scale}"), &plain, None);
            let hybrid = Setup { hybrid: Some((16, 8.0)), ..Setup::default() };
            text += &row(&format!("light × {scale}, hybrid"), &run(&other, &hybrid, times)?, None);
        }
        writeln!(text, "\nOn disk, packed: {}.", sizes(peer)?)?;
    }
    Ok(Page { name: "prefilter", text, pictures: Vec::new() })
}

/// Lengths of files of all levels, and of level 0 alone.
fn sizes(peer: &PeerScene) -> Result<String> {
    let folder = tempfile::tempdir()?;
    let path = folder.path().join("map.dsm");
    let view = peer.scene.light.raster([1024; 2])?;
    let builder = ListBuilder::new(view.shadow_camera(), view.resolution(), 0.0)?;
    let source = dsm_scene::SceneRasterizer::<f32>::new(&peer.scene, view)?;
    let bytes = |settings: PrefilterSettings| -> Result<f64> {
        let options = WriteOptions::default().with_packing(Packing::Zstd);
        let describe = |metadata: &mut dsm_io::Metadata| {
            metadata.info.light = Some(peer.scene.light.extent);
        };
        let watch = dsm_core::Progress::ignore;
        let baked = bake_prefiltered::<f32, _>(
            &builder, &settings, &source, &path, options, describe, watch,
        )?;
        Ok(baked.bytes as f64 / 1e6)
    };
    let all = bytes(PrefilterSettings::default())?;
    let base = bytes(PrefilterSettings::default().with_max_level(Some(0)))?;
    Ok(format!("{all:.1} MB, of which level 0 is {base:.1} MB"))
}
