//! Traces a fragment map of a scene, compares the shadow factors with a
//! reference, and tells how fast it was.
//!
//! ```text
//! cargo run --release -p dsm-experiments --example trace_peers -- FOLDER REFERENCE
//!     [--opaque] [--resolution N] [--coverage N] [--layers N] [--fov DEGREES]
//!     [--start PLANE FACING]… [--far CELLS]… [--exact] [--runs N] [--threads N] [--every N]
//! ```
//!
//! FOLDER holds `scene.toml`, `points.csv` (half of the points on the ground,
//! half on the object) and REFERENCE, a CSV file of shadow factors by 256 rays a
//! point to 16 × 16 strata of the light, whose jitter is hashed from point and
//! ray: the same rays are traced here. Threads: as many as `--threads` says, 1
//! if it does not; rates are those of the time that a thread ran.

#![expect(clippy::print_stdout, reason = "it prints what it measured")]

use std::path::Path;
use std::time::Instant;

use dsm_core::{Projection, Rgb};
use dsm_scene::{SceneRasterizer, open_scene};
use glam::DVec3;
use rayon::prelude::*;
use shadow_maps::detail::{FragmentBuilder, FragmentTracer, TraceScratch};

const RAYS: u32 = 256;

type Failure = Box<dyn std::error::Error>;

struct Options {
    folder: String,
    reference: String,
    opaque: bool,
    resolution: u32,
    coverage: u32,
    layers: u32,
    fov: Option<f64>,
    runs: u32,
    starts: Vec<(f64, f64)>,
    threads: usize,
    every: usize,
    far: Vec<f32>,
    exact: bool,
}

fn options() -> Result<Options, Failure> {
    let mut options = Options {
        folder: String::new(),
        reference: String::new(),
        opaque: false,
        resolution: 1024,
        coverage: 8,
        layers: u32::MAX,
        fov: None,
        runs: 3,
        starts: Vec::new(),
        threads: 1,
        every: 1,
        far: Vec::new(),
        exact: false,
    };
    let mut names = Vec::new();
    let mut arguments = std::env::args().skip(1);
    while let Some(argument) = arguments.next() {
        let mut number = || -> Result<f64, Failure> {
            Ok(arguments.next().ok_or("a number is missing")?.parse()?)
        };
        match argument.as_str() {
            "--opaque" => options.opaque = true,
            "--resolution" => options.resolution = number()? as u32,
            "--coverage" => options.coverage = number()? as u32,
            "--layers" => options.layers = number()? as u32,
            "--fov" => options.fov = Some(number()?),
            "--runs" => options.runs = number()? as u32,
            "--threads" => options.threads = number()? as usize,
            "--every" => options.every = number()? as usize,
            "--exact" => options.exact = true,
            "--far" => options.far.push(number()? as f32),
            "--start" => options.starts.push((number()?, number()?)),
            _ => names.push(argument),
        }
    }
    let [folder, reference] = names.try_into().map_err(|_| "FOLDER REFERENCE")?;
    Ok(Options { folder, reference, ..options })
}

/// A hash of 32 bits (the permutation of PCG).
fn hash(value: u32) -> u32 {
    let state = value.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
    let word = ((state >> ((state >> 28) + 4)) ^ state).wrapping_mul(277_803_737);
    (word >> 22) ^ word
}

fn unit(bits: u32) -> f64 {
    f64::from(bits >> 8) / 16_777_216.0
}

/// Columns of a CSV file with one line of headers.
fn read(path: &Path) -> Result<Vec<Vec<f64>>, Failure> {
    let text = std::fs::read_to_string(path)?;
    let line = |line: &str| line.split(',').map(|cell| Ok(cell.parse()?)).collect();
    text.lines().skip(1).map(line).collect()
}

fn report(name: &str, ours: &[f32], reference: &[f64]) {
    let count = ours.len() as f64;
    let differences = ours.iter().zip(reference).map(|(&a, b)| f64::from(a) - b);
    let mean = differences.clone().sum::<f64>() / count;
    let square = differences.map(|d| d * d).sum::<f64>() / count;
    println!("  {name}: RMSE {:.4}, mean difference {mean:+.4}", square.sqrt());
}

/// Seconds that this thread has run.
fn processor_time() -> f64 {
    let schedule = std::fs::read_to_string("/proc/thread-self/schedstat").unwrap_or_default();
    let nanoseconds = schedule.split(' ').next().and_then(|first| first.parse::<f64>().ok());
    nanoseconds.unwrap_or(0.0) / 1e9
}

fn main() -> Result<(), Failure> {
    let options = options()?;
    rayon::ThreadPoolBuilder::new().num_threads(options.threads).build_global()?;
    let folder = Path::new(&options.folder);
    let mut scene = open_scene(&folder.join("scene.toml"))?;
    if options.opaque {
        scene.objects.iter_mut().for_each(|object| object.opacity = Rgb::new(1.0, 1.0, 1.0));
    }
    if let Some(fov) = options.fov {
        scene.light.projection = Projection::Perspective { fov };
    }
    let points = read(&folder.join("points.csv"))?;
    let every = options.every;
    let points: Vec<(u32, DVec3)> =
        (0..).zip(&points).map(|(index, p)| (index, DVec3::new(p[0], p[1], p[2]))).collect();
    let points: Vec<_> = points.into_iter().step_by(every).collect();
    let reference = read(&folder.join(&options.reference))?;
    let reference: Vec<f64> = reference.iter().step_by(every).map(|line| line[0]).collect();

    let view = scene.light.raster([options.resolution; 2])?;
    let begin = Instant::now();
    let source = SceneRasterizer::<f32>::new(&scene, view)?;
    let builder = FragmentBuilder::new(view.shadow_camera(), view.resolution(), 0.0)?
        .with_coverage(options.coverage)?
        .with_layers(options.layers)?;
    let map = builder.build(&source)?;
    let built = begin.elapsed().as_secs_f64();
    println!(
        "{} {}²/{} fragments {} built in {built:.2} s",
        options.folder,
        options.resolution,
        options.coverage,
        map.len()
    );
    let light = scene.light.area()?;
    // The reference's axes: the first points left.
    let [right, up] = light.half_axes();
    let sample = |point: u32, ray: u32| {
        let (block, within) = (ray >> 4, ray & 15);
        let (x, y) = ((block & 3) * 4 + (within & 3), (block >> 2) * 4 + (within >> 2));
        let first = hash(point.wrapping_mul(RAYS).wrapping_add(ray));
        let along = |stratum: u32, bits| (f64::from(stratum) + unit(bits)) / 8.0 - 1.0;
        light.centre() - right * along(x, first) + up * along(y, hash(first))
    };
    let starts: Vec<_> = match &*options.starts {
        [] => vec![None],
        some => some.iter().copied().map(Some).collect(),
    };
    let tables: Vec<_> = match &*options.far {
        [] => vec![None],
        some => some.iter().copied().map(Some).collect(),
    };
    for (start, far) in
        starts.into_iter().flat_map(|start| tables.iter().map(move |&far| (start, far)))
    {
        let begin = Instant::now();
        let mut tracer = FragmentTracer::new(map.clone())?;
        if let Some((plane, facing)) = start {
            tracer = tracer.with_start(plane, facing);
        }
        tracer = match far {
            Some(cells) => tracer.with_far_table(cells),
            None if options.exact => tracer,
            None => tracer.for_light(&light),
        };
        let table = tracer.has_far_table();
        println!(
            "start {start:?} far {far:?} table {table} ready in {:.2} s",
            begin.elapsed().as_secs_f64()
        );
        let mut best = f64::INFINITY;
        let mut ours = vec![0.0_f32; points.len()];
        for _ in 0..options.runs {
            let begin = rayon::broadcast(|_| processor_time()).into_iter().fold(0.0, f64::max);
            let chunks = ours.par_chunks_mut(100).zip(points.par_chunks(100));
            chunks.for_each_init(
                || (TraceScratch::default(), Vec::new()),
                |(scratch, lights), (values, points)| {
                    for (value, &(index, point)) in values.iter_mut().zip(points) {
                        lights.clear();
                        lights.extend((0..RAYS).map(|ray| sample(index, ray)));
                        *value = tracer.mean(point, lights, scratch);
                    }
                },
            );
            let end = rayon::broadcast(|_| processor_time()).into_iter().fold(0.0, f64::max);
            best = best.min(end - begin);
        }
        let rays = points.len() as f64 * f64::from(RAYS);
        println!("  {:.2} Mray/s ({:?})", rays / best / 1e6, tracer.statistics());
        let half = points.len() / 2;
        report("ground", &ours[..half], &reference[..half]);
        report("object", &ours[half..], &reference[half..]);
        report("all", &ours, &reference);
    }
    Ok(())
}
