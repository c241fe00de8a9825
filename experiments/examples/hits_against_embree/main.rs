//! All hits of a shadow camera's rays: the rasteriser beside Embree, in one run.
//!
//! ```text
//! cargo run --release -p dsm-experiments --example hits_against_embree -- SCENE [RUNS]
//! ```
//!
//! needs a C++ compiler and Embree 3 with its headers. The map has 512 × 512
//! pixels of 16 samples, from the light's centre under 30 degrees, and one
//! thread works. Both sides are given the same rays; the numbers of hits of every
//! ray are compared. Times are CPU times of the thread, the median of the runs.

#![expect(clippy::expect_used, clippy::print_stdout, reason = "a measurement, which prints")]

use std::error::Error;
use std::fs;
use std::path::Path;
use std::process::Command;

use dsm_core::{
    BakeSettings, Baker, HitSource, PixelSampling, Projection, TileHits, TileSamples, ViewRaster,
};
use dsm_io::detail::{BakeOptions, bake};
use dsm_scene::{Scene, SceneRasterizer, Shape, open_scene};

const SIZE: u32 = 512;
const TILE: u32 = 64;
const SAMPLES: u32 = 16;

type Outcome<T> = Result<T, Box<dyn Error + Send + Sync>>;

fn main() -> Outcome<()> {
    let mut arguments = std::env::args().skip(1);
    let scene = arguments.next().ok_or("which scene file?")?;
    let runs: usize = arguments.next().map_or(Ok(3), |runs| runs.parse())?;
    let mut scene = open_scene(Path::new(&scene))?;
    scene.light.projection = Projection::Perspective { fov: 30.0 };
    let raster = scene.light.raster([SIZE; 2])?;
    let folder = tempfile::tempdir()?;
    let peer = folder.path().join("hits");
    let compiled = Command::new("g++")
        .args(["-std=c++17", "-O3", "-march=native", "-o"])
        .arg(&peer)
        .arg(Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/hits_against_embree/hits.cpp"))
        .arg("-lembree3")
        .status()?;
    if !compiled.success() {
        return Err("the peer did not compile".into());
    }
    let (input, output) = (folder.path().join("input"), folder.path().join("output"));
    let blocks = blocks()?;
    fs::write(&input, peer_input(&scene, &raster, &blocks)?)?;
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
    let mut rows = vec![Vec::new(); 6];
    for _ in 0..runs {
        let printed = Command::new(&peer).args([&input, &output]).output()?;
        let printed = String::from_utf8(printed.stdout)?;
        let seconds: Vec<f64> =
            printed.split_whitespace().map(str::parse).collect::<Result<_, _>>()?;
        let own = pool.install(|| stages(&scene, &raster, &blocks, folder.path()))?;
        for (row, value) in rows.iter_mut().zip(seconds.iter().chain(&own.seconds)) {
            row.push(*value);
        }
        compare(&own.counts, &fs::read(&output)?)?;
    }
    let medians: Vec<f64> = rows
        .iter_mut()
        .map(|row| {
            row.sort_by(f64::total_cmp);
            row[row.len() / 2]
        })
        .collect();
    let peer = medians[1];
    println!("Embree: build {:.3} s, hits sorted {peer:.3} s", medians[0]);
    let names = ["hits", "hits, sorted and summed", "and compressed", "whole bake to a file"];
    for (name, seconds) in names.iter().zip(&medians[2..]) {
        println!("{name}: {seconds:.3} s, {:.1} times as fast", peer / seconds);
    }
    let whole = medians[5];
    let parts = [
        ("rasterising", medians[2]),
        ("grouping, sorting and summing", medians[3] - medians[2]),
        ("compressing and measuring", medians[4] - medians[3]),
        ("encoding and writing", medians[5] - medians[4]),
    ];
    for (name, seconds) in parts {
        println!("{name}: {:.0} % of the bake", 100.0 * seconds / whole);
    }
    Ok(())
}

/// What one thread took, in CPU seconds, and every ray's hits.
struct Stages {
    seconds: [f64; 4],
    counts: Vec<u32>,
}

fn stages(
    scene: &Scene,
    raster: &ViewRaster,
    blocks: &[TileSamples],
    folder: &Path,
) -> Outcome<Stages> {
    let mut hits = TileHits::<f32>::new(0);
    let start = cpu_seconds()?;
    let source = SceneRasterizer::<f32>::new(scene, *raster)?;
    let mut total = 0;
    for samples in blocks {
        hits.reset(samples.len());
        source.hits(samples, &mut hits)?;
        total += hits.surface_count();
    }
    let rasterised = cpu_seconds()? - start;
    let mut counts = Vec::new();
    for samples in blocks {
        hits.reset(samples.len());
        source.hits(samples, &mut hits)?;
        let first = counts.len();
        counts.resize(first + samples.len() as usize, 0);
        hits.surfaces().for_each(|(sample, _)| counts[first + sample as usize] += 1);
    }
    assert_eq!(counts.iter().map(|&count| count as usize).sum::<usize>(), total);

    let mut settings = BakeSettings::new([SIZE; 2])?;
    settings.sampling = PixelSampling::new(SAMPLES, 0)?;
    settings.tile_size = TILE;
    settings.camera = Some(raster.shadow_camera());
    let tiles: Vec<_> = settings.tiles().collect();

    let start = cpu_seconds()?;
    let source = SceneRasterizer::<f32>::new(scene, *raster)?;
    let baker = Baker::<f32, _>::new(source, settings.clone())?;
    for &tile in &tiles {
        baker.exact_tile(tile, |pixel| {
            std::hint::black_box(pixel);
        })?;
    }
    let summed = cpu_seconds()? - start;

    let start = cpu_seconds()?;
    let source = SceneRasterizer::<f32>::new(scene, *raster)?;
    let baker = Baker::<f32, _>::new(source, settings.clone())?;
    for &tile in &tiles {
        std::hint::black_box(baker.tile(tile)?);
    }
    let compressed = cpu_seconds()? - start;

    let start = cpu_seconds()?;
    let source = SceneRasterizer::<f32>::new(scene, *raster)?;
    let baker = Baker::<f32, _>::new(source, settings)?;
    let options = BakeOptions::default();
    let watch = |_| std::ops::ControlFlow::Continue(());
    bake(&baker, &folder.join("map.dsm"), &options, |_| (), watch)?;
    let written = cpu_seconds()? - start;
    Ok(Stages { seconds: [rasterised, summed, compressed, written], counts })
}

/// The samples of the map's tiles.
fn blocks() -> Outcome<Vec<TileSamples>> {
    let sampling = PixelSampling::new(SAMPLES, 0)?;
    let origins = (0..SIZE / TILE).flat_map(|y| (0..SIZE / TILE).map(move |x| [x, y]));
    origins
        .map(|origin| {
            let min = origin.map(|at| (at * TILE) as i32);
            Ok(TileSamples::new(&sampling, min, [TILE; 2], None)?)
        })
        .collect()
}

/// The scene and the rays, as the peer reads them.
fn peer_input(scene: &Scene, raster: &ViewRaster, blocks: &[TileSamples]) -> Outcome<Vec<u8>> {
    let (mut segments, mut corners, mut triangles) = (Vec::new(), Vec::new(), Vec::new());
    for object in &scene.objects {
        let to_world = object.to_world(0.0);
        let world = |point: glam::Vec3| to_world.transform_point3(point.as_dvec3()).as_vec3();
        match &*object.shape {
            Shape::Curves(curves) => {
                for index in 0..curves.segments().len() {
                    for (point, radius) in curves.segment(index) {
                        segments.extend(world(point).extend(radius).to_array());
                    }
                }
            }
            Shape::Mesh(mesh) => {
                let first = (corners.len() / 3) as u32;
                corners.extend(mesh.positions().iter().flat_map(|&point| world(point).to_array()));
                let all = mesh.triangles().iter().flatten();
                triangles.extend(all.map(|corner| first + corner));
            }
            _ => return Err("only strands and meshes are compared".into()),
        }
    }
    let rays: usize = blocks.iter().map(|block| block.len() as usize).sum();
    let sizes = [segments.len() / 8, corners.len() / 3, triangles.len() / 3, rays];
    let mut bytes = Vec::new();
    let mut number = |bits: u32| bytes.extend(bits.to_le_bytes());
    sizes.iter().for_each(|&size| number(size as u32));
    let eye = raster.eye().as_vec3().to_array();
    eye.iter().chain(&segments).chain(&corners).for_each(|value| number(value.to_bits()));
    triangles.iter().for_each(|&corner| number(corner));
    for point in blocks.iter().flat_map(TileSamples::points) {
        let direction = raster.ray(point.x, point.y, 0.0).direction().as_vec3();
        direction.to_array().iter().for_each(|value| number(value.to_bits()));
    }
    Ok(bytes)
}

/// Compares the numbers of hits of every ray.
fn compare(own: &[u32], peer: &[u8]) -> Outcome<()> {
    let words = peer.chunks_exact(4).map(|word| u32::from_le_bytes(word.try_into().expect("4")));
    let peer: Vec<u32> = words.take(own.len()).collect();
    let differ = own.iter().zip(&peer).filter(|(own, peer)| own != peer).count();
    let total = |counts: &[u32]| counts.iter().map(|&count| u64::from(count)).sum::<u64>();
    println!(
        "{} rays, {} hits here and {} there; {differ} rays differ",
        own.len(),
        total(own),
        total(&peer)
    );
    // Strands and rays that graze each other are decided by rounding.
    if peer.len() == own.len() && differ * 100 <= own.len() {
        Ok(())
    } else {
        Err("the hits differ".into())
    }
}

/// The CPU time of this thread so far, in seconds.
fn cpu_seconds() -> Outcome<f64> {
    let status = fs::read_to_string("/proc/thread-self/schedstat")?;
    let first = status.split_whitespace().next().ok_or("no times")?;
    Ok(first.parse::<f64>()? * 1e-9)
}
