//! The page of attenuation maps and of traced views.

use std::thread::ScopedJoinHandle;

use anyhow::{Result, anyhow};
use dsm_scene::{Scene, builtin_scene};
use rayon::ThreadPoolBuilder;

use super::precompute::{Precomputation, reference};
use super::scenes::scenes;
use super::{accelerations, cause, lookups, peers, strips};
use crate::figures::{Panel, machine, svg};
use crate::prefilter::page::Compared;
use crate::soft_shadows::{Page, Stage};

/// How much is measured.
pub struct Effort {
    /// Width and height of pictures.
    pub image: [u32; 2],
    /// Texels along a side of attenuation maps.
    pub map: u32,
    /// Numbers of points of the light, ascending.
    pub samples: Vec<u32>,
    /// Pixels along a side of views.
    pub view: u32,
    /// Rays of a point where views are traced.
    pub rays: u32,
    /// Of how many points one is compared with rays, and is traced through views.
    pub every: [usize; 2],
    /// Pictures are so many times as large as the smallest.
    pub scale: u32,
}

impl Effort {
    /// Pictures, maps and views as large as the paper's.
    #[must_use]
    pub fn full() -> Self {
        Self {
            image: [512; 2],
            map: 512,
            samples: vec![1, 4, 16, 64, 128],
            view: 1024,
            rays: 64,
            every: [8, 64],
            scale: 10,
        }
    }

    /// As little as still shows the same.
    #[must_use]
    pub fn small() -> Self {
        Self {
            image: [64; 2],
            map: 64,
            samples: vec![1, 4],
            view: 64,
            rays: 16,
            every: [2, 16],
            scale: 1,
        }
    }
}

/// What one of the scenes showed.
struct Found {
    name: &'static str,
    precomputation: String,
    accelerated: String,
    /// Layers a texel, and seconds, by number of light samples.
    curves: [Vec<(f64, f64)>; 2],
}

impl Effort {
    fn measure(&self, name: &'static str, scene: Scene) -> Result<Found> {
        let stage = Stage::new(name, scene, self.image)?;
        let [every, sparse] = self.every;
        let traced = reference(&stage, every)?;
        let maps = Precomputation::measure(&stage, self.map, &self.samples, (&traced, every))?;
        let (primitives, points) = (stage.primitives(), stage.points.len());
        let table = maps.table();
        let precomputation =
            format!("### {name}: {primitives} primitives, {points} points\n\n{table}\n");
        let few = reference(&stage, sparse)?;
        let points: Vec<_> = stage.points.iter().step_by(sparse).copied().collect();
        let views = peers::tracer(&stage.scene, self.view, 4)?;
        let light = stage.scene.light.area()?;
        let table = accelerations::compare(&views, &points, &light, self.rays, &few.values);
        let accelerated = format!("### {name}\n\n{table}\n");
        let curves = [maps.complexities(), maps.seconds()];
        Ok(Found { name, precomputation, accelerated, curves })
    }

    /// What the error of maps of leaves comes from.
    fn causes(&self) -> Result<String> {
        let stage = Stage::new("foliage", builtin_scene("foliage")?, self.image)?;
        let [every, _] = self.every;
        let most = self.samples.last().copied().unwrap_or(1);
        let traced = reference(&stage, every)?;
        cause::compare(&stage, (self.map, most), (&traced, every))
    }

    /// Tables of a scene of another program: rays through views.
    fn beside(&self, scene: &Compared) -> Result<String> {
        let of = (self.view, 256);
        let told = scene.embree.map(|told| format!(", Embree {told:.1} µs a point"));
        let (name, told) = (&scene.peer.name, told.unwrap_or_default());
        let (all, each) =
            (peers::compare(scene, of)?, peers::each_acceleration(&scene.peer, of, 16)?);
        Ok(format!("### {name}{told}\n\n{all}\nFour views, of every 16th point:\n\n{each}\n"))
    }
}

/// On a thread of its own, whose time is all that the work takes.
fn alone<R: Send>(work: impl FnOnce() -> Result<R> + Send) -> Result<R> {
    ThreadPoolBuilder::new().num_threads(1).build()?.install(work)
}

/// The work of another thread, at its end.
fn joined<R>(work: ScopedJoinHandle<'_, Result<R>>) -> Result<R> {
    work.join().map_err(|_| anyhow!("a thread broke off"))?
}

/// Measures everything, on the scenes that are made here and on those of `compared`, on
/// a thread for each part, whose own time is measured.
///
/// # Errors
///
/// What a scene is not.
pub fn page(effort: &Effort, compared: &[Compared]) -> Result<Page> {
    let scenes = scenes()?;
    let sides = [effort.map, effort.view];
    let halves = sides.map(|side| side / 2);
    let (found, causes, lookups, others, strips) = std::thread::scope(|scope| {
        let measure = |(name, scene)| scope.spawn(move || alone(|| effort.measure(name, scene)));
        let measured = scenes.map(measure);
        let causes = scope.spawn(|| alone(|| effort.causes()));
        let lookups = scope.spawn(|| alone(|| lookups::compare(compared, &[512, 1024])));
        let others = compared.iter().map(|scene| scope.spawn(|| alone(|| effort.beside(scene))));
        let others: Vec<_> = others.collect();
        let methods = scope
            .spawn(|| alone(|| Ok(strips::methods(effort.scale, sides, effort.rays)?.to_png()?)));
        let artefacts = scope.spawn(|| {
            alone(|| Ok(strips::artefacts(effort.scale, halves, effort.rays)?.to_png()?))
        });
        let found = measured.into_iter().map(joined).collect::<Result<Vec<_>>>();
        let others = others.into_iter().map(joined).collect::<Result<Vec<_>>>();
        (found, joined(causes), joined(lookups), others, [joined(methods), joined(artefacts)])
    });
    let (found, [methods, artefacts]) = (found?, strips);
    let curves = |which: usize| {
        found.iter().map(|found| (found.name, found.curves[which].clone())).collect()
    };
    let (x, layers) = ("light samples", "layers a texel");
    let plot = svg(&[
        Panel { title: "depth complexity", x, y: layers, curves: curves(0) },
        Panel { title: "precomputation", x, y: "seconds", curves: curves(1) },
    ])?;
    let all = |part: fn(&Found) -> &str| found.iter().map(part).collect::<Vec<_>>().join("\n");
    let text = format!(
        include_str!("page.md"),
        machine = machine(),
        precomputation = all(|found| &found.precomputation).trim_end(),
        accelerated = all(|found| &found.accelerated).trim_end(),
        causes = causes?.trim_end(),
        lookups = lookups?.trim_end(),
        others = others?.join("\n").trim_end(),
        rays = effort.rays,
        view = effort.view,
        map = effort.map,
    );
    let pictures = vec![
        ("results/attenuation.svg".to_owned(), plot.into_bytes()),
        ("images/attenuation.png".to_owned(), methods?),
        ("images/attenuation-artefacts.png".to_owned(), artefacts?),
    ];
    Ok(Page { name: "attenuation", text, pictures })
}
