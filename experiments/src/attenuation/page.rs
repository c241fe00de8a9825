//! The page of attenuation maps and of traced views.

use std::fmt::Write as _;
use std::io::Write as _;
use std::time::Instant;

use anyhow::Result;

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
            samples: vec![1, 4, 16, 64, 256],
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
    let (mut precomputation, mut accelerated) = (String::new(), String::new());
    let (mut curves, mut times, mut causes) = (Vec::new(), Vec::new(), String::new());
    for (name, scene) in scenes()? {
        let stage = Stage::new(name, scene, effort.image)?;
        let [every, sparse] = effort.every;
        let traced = reference(&stage, every)?;
        let found = Precomputation::measure(&stage, effort.map, &effort.samples, (&traced, every))?;
        writeln!(
            precomputation,
            "### {name}: {} primitives, {} points\n\n{}",
            stage.primitives(),
            stage.points.len(),
            found.table()
        )?;
        tell(&format!("{name}, maps"))?;
        curves.push((found.scene, found.complexities()));
        times.push((found.scene, found.seconds()));
        let few = reference(&stage, sparse)?;
        let points: Vec<_> = stage.points.iter().step_by(sparse).copied().collect();
        let views = peers::tracer(&stage.scene, effort.view, 4)?;
        let light = stage.scene.light.area()?;
        let table = accelerations::compare(&views, &points, &light, effort.rays, &few.values);
        writeln!(accelerated, "### {name}\n\n{table}")?;
        tell(&format!("{name}, views"))?;
        if name == "foliage" {
            causes = cause::compare(&stage, effort.map, (&traced, every))?;
            tell("causes")?;
        }
    }
    let plot = svg(&[
        Panel { title: "depth complexity", x: "light samples", y: "layers a texel", curves },
        Panel { title: "precomputation", x: "light samples", y: "seconds", curves: times },
    ])?;
    let mut others = String::new();
    for compared in compared {
        let of = (effort.view, 256);
        let embree =
            compared.embree.map_or(String::new(), |told| format!(", Embree {told:.1} µs a point"));
        writeln!(
            others,
            "### {}{embree}\n\n{}",
            compared.peer.name,
            peers::compare(compared, of)?
        )?;
        let each = peers::each_acceleration(&compared.peer, of, 16)?;
        writeln!(others, "Four views, of every 16th point:\n\n{each}")?;
        tell(&compared.peer.name)?;
    }
    let text = format!(
        include_str!("page.md"),
        machine = machine(),
        precomputation = precomputation.trim_end(),
        accelerated = accelerated.trim_end(),
        causes = causes.trim_end(),
        lookups = lookups::compare(compared, &[512, 1024])?.trim_end(),
        others = others.trim_end(),
        rays = effort.rays,
        view = effort.view,
        map = effort.map,
    );
    let sides = [effort.map, effort.view];
    let methods = strips::methods(effort.scale, sides, effort.rays)?;
    let artefacts = strips::artefacts(effort.scale, sides.map(|side| side / 2), effort.rays)?;
    let pictures = vec![
        ("results/attenuation.svg".to_owned(), plot.into_bytes()),
        ("images/attenuation.png".to_owned(), methods.to_png()?),
        ("images/attenuation-artefacts.png".to_owned(), artefacts.to_png()?),
    ];
    Ok(Page { name: "attenuation", text, pictures })
}
