//! A scene of the peers, with points and their shadow factors by Embree.

use std::path::Path;

use anyhow::{Context, Result, ensure};
use dsm_core::{AreaLight, Facing, LightVisibility, ShadedPoint};
use dsm_scene::detail::SceneReference;
use dsm_scene::{Scene, Shape, TracedScene, open_scene};
use glam::{DVec3, Vec3};
use rayon::prelude::*;

/// From where the points of objects were looked at, and how far they were moved towards
/// there at most.
const SEEN_FROM: DVec3 = DVec3::new(0.75, 0.45, 0.5);
const MOVED: f64 = 0.0015;

/// A scene with the points that shadow factors are compared at: the first half lies on the
/// ground, the second on the object.
pub struct PeerScene {
    /// The scene's folder has this name.
    pub name: String,
    /// The scene.
    pub scene: Scene,
    /// The same, for rays.
    pub traced: std::sync::Arc<TracedScene>,
    /// Points, without what they lie on.
    pub points: Vec<ShadedPoint>,
    /// The same with the normals of surfaces.
    pub on_surfaces: Vec<ShadedPoint>,
    /// Their shadow factors.
    pub reference: Vec<f64>,
}

fn columns(path: &Path) -> Result<Vec<Vec<f64>>> {
    let text = std::fs::read_to_string(path).with_context(|| format!("{}", path.display()))?;
    let line = |line: &str| line.split(',').map(|cell| Ok(cell.trim().parse()?)).collect();
    text.lines().skip(1).map(line).collect()
}

impl PeerScene {
    /// Reads `scene.toml`, `points.csv` and the shadow factors in `reference` of a folder;
    /// takes every so manieth point.
    ///
    /// # Errors
    ///
    /// What a file is not.
    pub fn open(folder: &Path, reference: &str, every: usize) -> Result<Self> {
        let scene = open_scene(&folder.join("scene.toml"))?;
        let name = folder.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let points = columns(&folder.join("points.csv"))?;
        let reference = columns(&folder.join(reference))?;
        ensure!(points.len() == reference.len(), "{name}: a shadow factor a point");
        let reference: Vec<f64> = reference.iter().step_by(every).map(|line| line[0]).collect();
        let point = |(index, at): (u64, &Vec<f64>)| ShadedPoint {
            position: DVec3::new(at[0], at[1], at[2]),
            facing: Facing::Light,
            seed: index,
        };
        let points: Vec<_> = (0..).zip(&points).step_by(every).map(point).collect();
        let on_surfaces = on_surfaces(&scene, &points);
        let traced = TracedScene::new(&scene)?.into();
        Ok(Self { name, scene, traced, points, on_surfaces, reference })
    }

    /// The same with a light `scale` times as wide, whose shadow factors `rays` rays
    /// through the scene tell.
    ///
    /// # Errors
    ///
    /// What the light is not.
    pub fn with_light(&self, scale: f64, rays: u32) -> Result<Self> {
        let mut scene = self.scene.clone();
        let size = scene.light.extent.size().map(|side| side * scale);
        scene.light = scene.light.with_size(size)?;
        let light = scene.light.area()?;
        // The points stand off their surfaces by far more than this.
        let truth = SceneReference::<f32>::new(std::sync::Arc::clone(&self.traced))
            .with_rays(rays)
            .with_start(1e-4);
        let factor = |point: &ShadedPoint| {
            let Ok(left) = truth.visibility(point.position, &light, point.seed);
            f64::from(left)
        };
        let reference = self.points.par_iter().map(factor).collect();
        let (name, traced) = (format!("{}, light × {scale}", self.name), self.traced.clone());
        let (points, on_surfaces) = (self.points.clone(), self.on_surfaces.clone());
        Ok(Self { name, scene, traced, points, on_surfaces, reference })
    }

    /// The light.
    ///
    /// # Errors
    ///
    /// What it is not.
    pub fn light(&self) -> Result<AreaLight> {
        Ok(self.scene.light.area()?)
    }
}

/// The points with the normals of the triangles that they were moved off.
fn on_surfaces(scene: &Scene, points: &[ShadedPoint]) -> Vec<ShadedPoint> {
    let meshes: Vec<_> = scene
        .objects
        .iter()
        .filter_map(|object| match &*object.shape {
            Shape::Mesh(mesh) => Some(mesh),
            _ => None,
        })
        .collect();
    let triangles: Vec<[Vec3; 3]> = meshes
        .iter()
        .flat_map(|mesh| (0..mesh.triangles().len()).map(|index| mesh.corners(index)))
        .collect();
    let towards = SEEN_FROM.normalize();
    let place = |point: &ShadedPoint| {
        // Of the ground the height tells.
        if point.position.y.abs() < 0.01 {
            return ShadedPoint { facing: Facing::Surface(DVec3::Y), ..*point };
        }
        let near = triangles.iter().filter(|corners| {
            (corners[0].as_dvec3() - point.position).length_squared() < 0.25 * 0.25
        });
        let met = near.filter_map(|corners| crossed(corners, point.position, -towards));
        let met = met.filter(|(t, _)| (-1e-5..MOVED).contains(t));
        let first = met.min_by(|a, b| a.0.total_cmp(&b.0));
        match first {
            Some((_, normal)) => {
                let normal = if normal.dot(towards) < 0.0 { -normal } else { normal };
                ShadedPoint { facing: Facing::Surface(normal), ..*point }
            }
            None => *point,
        }
    };
    points.par_iter().map(place).collect()
}

/// Where a ray crosses a triangle, and its normal.
fn crossed(corners: &[Vec3; 3], from: DVec3, along: DVec3) -> Option<(f64, DVec3)> {
    let [a, b, c] = corners.map(|corner| corner.as_dvec3());
    let (u, v) = (b - a, c - a);
    let p = along.cross(v);
    let det = u.dot(p);
    if det == 0.0 {
        return None;
    }
    let off = from - a;
    let s = off.dot(p) / det;
    let q = off.cross(u);
    let t = along.dot(q) / det;
    let is_inside = s >= -1e-6 && t >= -1e-6 && s + t <= 1.0 + 1e-6;
    is_inside.then(|| (v.dot(q) / det, u.cross(v).normalize()))
}
