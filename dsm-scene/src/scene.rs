//! Scenes: their objects, lights and camera.

use std::sync::Arc;

use dsm_core::{LightExtent, Projection, Rgb, View};
use glam::{DAffine3, DVec3};

use crate::bounds::Bounds;
use crate::curves::Curves;
use crate::error::{Error, Place, Result};
use crate::mesh::TriangleMesh;
use crate::scene_memory::SceneMemory;
use crate::transform::Motion;
use crate::view::{Camera, Light};
use crate::volume::Volume;

/// The geometry of an object, in its own space.
///
/// ```
/// use dsm_scene::{Curves, Shape};
/// use glam::{DVec3, Vec3};
///
/// let strand = Curves::new(vec![Vec3::ZERO, Vec3::Y], vec![0.5; 2], [2])?;
/// assert!(Shape::Curves(strand).bounds().max.y >= 1.0);
/// # Ok::<(), dsm_scene::Error>(())
/// ```
#[derive(Clone, Debug)]
pub enum Shape {
    /// A mesh of surfaces.
    Mesh(TriangleMesh),
    /// Strands.
    Curves(Curves),
    /// A medium.
    Volume(Volume),
}

impl Shape {
    /// The box around it in its own space.
    #[must_use]
    pub fn bounds(&self) -> Bounds {
        match self {
            Self::Mesh(mesh) => mesh.bounds(),
            Self::Curves(curves) => curves.bounds(),
            Self::Volume(volume) => volume.bounds(),
        }
    }

    /// Bytes that it takes.
    pub(crate) fn memory(&self) -> u64 {
        match self {
            Self::Mesh(mesh) => mesh.bytes(),
            Self::Curves(curves) => curves.bytes(),
            Self::Volume(volume) => volume.bytes(),
        }
    }
}

/// An object: a shape with its opacity and motion.
///
/// ```
/// use dsm_core::Rgb;
/// use dsm_scene::{Object, Shape, TriangleMesh};
/// use glam::Vec3;
///
/// let mesh = TriangleMesh::new(vec![Vec3::ZERO, Vec3::X, Vec3::Y], vec![[0, 1, 2]])?;
/// let pane = Object::new(Shape::Mesh(mesh)).with_opacity(Rgb::new(0.0, 0.5, 0.5));
/// assert!(!pane.is_moving());
/// # Ok::<(), dsm_scene::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct Object {
    /// The geometry; objects may share it.
    pub shape: Arc<Shape>,
    /// The fraction of light that each of its surfaces and strands blocks, in
    /// [0, 1], times what the shape says itself. Scales a medium's extinction.
    pub opacity: Rgb,
    /// A medium's extinction per unit of the world at density 1, ≥ 0.
    pub density: f32,
    /// Its motions, the innermost first.
    pub motion: Vec<Motion>,
}

impl Object {
    /// An opaque object that stands where its shape does.
    #[must_use]
    pub fn new(shape: Shape) -> Self {
        let opacity = Rgb::new(1.0, 1.0, 1.0);
        Self { shape: Arc::new(shape), opacity, density: 1.0, motion: Vec::new() }
    }

    /// Sets the opacity.
    #[must_use]
    pub fn with_opacity(self, opacity: Rgb) -> Self {
        Self { opacity, ..self }
    }

    /// True if it moves while the shutter is open.
    #[must_use]
    pub fn is_moving(&self) -> bool {
        self.motion.iter().any(Motion::is_moving)
    }

    /// Object to world at `time` of the shutter, in [0, 1]. A similarity.
    #[must_use]
    pub fn to_world(&self, time: f64) -> DAffine3 {
        self.motion.iter().fold(DAffine3::IDENTITY, |inner, motion| motion.at(time) * inner)
    }

    /// The box around it in the world, wherever it goes: exact where
    /// it stands still, the boxes of 17 moments where it moves.
    #[must_use]
    pub fn bounds(&self) -> Bounds {
        let own = self.shape.bounds();
        if own.is_empty() || !self.is_moving() {
            return own.transformed(&self.to_world(0.0));
        }
        let moments =
            (0..=16).map(|moment| own.transformed(&self.to_world(f64::from(moment) / 16.0)));
        moments.fold(Bounds::default(), Bounds::union)
    }

    /// The largest length that places on it are computed from, wherever it goes: of
    /// coordinates in its own space, in units of the world, and in the world.
    pub(crate) fn reach(&self) -> f64 {
        let farthest = |bounds: Bounds| {
            let corner = bounds.min.abs().max(bounds.max.abs()).max_element();
            if bounds.is_empty() { 0.0 } else { corner }
        };
        let moments = if self.is_moving() { 16 } else { 0 };
        let scales = (0..=moments).map(|moment| {
            let to_world = self.to_world(f64::from(moment) / f64::from(moments.max(1)));
            to_world.matrix3.x_axis.length()
        });
        let scale = scales.fold(0.0, f64::max);
        farthest(self.bounds()).max(farthest(self.shape.bounds()) * scale)
    }

    /// The numbers as they are, once they are in range.
    ///
    /// # Errors
    ///
    /// [`Error::Malformed`] for an opacity outside [0, 1], a density that is
    /// negative or not finite, or a transform that is none.
    pub fn check(self) -> Result<Self> {
        let refuse = |key: &str, reason| Err(Error::malformed(Place::Named(key.into()), reason));
        let Rgb { red, green, blue } = self.opacity;
        if ![red, green, blue].iter().all(|part| (0.0..=1.0).contains(part)) {
            return refuse("opacity", "must lie in [0, 1]");
        }
        if !(0.0..=1e18).contains(&self.density) {
            return refuse("density", "must lie between 0 and 1e18");
        }
        for motion in &self.motion {
            motion.open.check()?;
            motion.close.check()?;
        }
        Ok(self)
    }
}

/// A scene: objects, a light with its shadow camera, a camera that renders.
///
/// ```
/// use dsm_core::Rgb;
/// use dsm_scene::{Object, Scene, Shape, TriangleMesh};
/// use glam::Vec3;
///
/// let mesh = TriangleMesh::new(vec![Vec3::ZERO, Vec3::X, Vec3::Y], vec![[0, 1, 2]])?;
/// let pane = Object::new(Shape::Mesh(mesh)).with_opacity(Rgb::new(0.0, 0.5, 0.5));
/// let scene = Scene::of_objects(vec![pane]);
/// assert!(scene.is_coloured() && !scene.has_media());
/// assert_eq!(scene.finest_strand(), None);
/// # Ok::<(), dsm_scene::Error>(())
/// ```
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Scene {
    /// The objects.
    pub objects: Vec<Object>,
    /// The light.
    pub light: Light,
    /// The camera of `render`.
    pub camera: Camera,
    /// The times when the shutter opens and closes. Rays count time from 0 to 1
    /// between.
    pub shutter: [f64; 2],
    /// See [`Self::warnings`].
    pub(crate) warnings: Vec<String>,
    /// Of what was read of files; see [`Self::memory`].
    pub(crate) files: SceneMemory,
}

impl Scene {
    /// A scene lit and seen from standard positions: with the sphere of centre
    /// c and radius R around the objects' box, a point light at
    /// c + 3R·norm(1, 2, 1) and a camera at c + 3R·norm(−1, 1, 2), both 45
    /// degrees wide. Objects without extent count as R = 1.
    #[must_use]
    pub fn of_objects(objects: Vec<Object>) -> Self {
        let bounds = objects.iter().map(Object::bounds).fold(Bounds::default(), Bounds::union);
        let (centre, radius) = bounding_sphere(&bounds);
        let up = DVec3::Y;
        let from = |direction: DVec3| View {
            eye: centre + direction.normalize() * (3.0 * radius),
            target: centre,
            up,
        };
        let light = Light {
            view: from(DVec3::new(1.0, 2.0, 1.0)),
            projection: Projection::Perspective { fov: 45.0 },
            extent: LightExtent::POINT,
        };
        let view = from(DVec3::new(-1.0, 1.0, 2.0));
        let camera = Camera { view, fov: 45.0, resolution: [640, 360] };
        Self {
            objects,
            light,
            camera,
            shutter: [0.0, 1.0],
            warnings: Vec::new(),
            files: SceneMemory::default(),
        }
    }

    /// What its files hold that was not understood, or was taken in one of several ways,
    /// and changes light: a sentence each, without a full stop, with the file's name.
    #[must_use]
    pub fn warnings(&self) -> &[String] {
        &self.warnings
    }

    /// The memory that it takes: its files, and what has to be built of its objects to
    /// bake or trace them.
    #[must_use]
    pub fn memory(&self) -> SceneMemory {
        let mut memory = self.files.clone();
        memory.add_structures(&self.objects);
        memory
    }

    /// Sets the objects.
    #[must_use]
    pub fn with_objects(self, objects: Vec<Object>) -> Self {
        Self { objects, ..self }
    }

    /// Sets the light.
    #[must_use]
    pub fn with_light(self, light: Light) -> Self {
        Self { light, ..self }
    }

    /// Sets the camera of `render`.
    #[must_use]
    pub fn with_camera(self, camera: Camera) -> Self {
        Self { camera, ..self }
    }

    /// Sets the times when the shutter opens and closes.
    #[must_use]
    pub fn with_shutter(self, shutter: [f64; 2]) -> Self {
        Self { shutter, ..self }
    }

    /// True if any opacity has a colour, so that a map of one channel would lose
    /// something.
    #[must_use]
    pub fn is_coloured(&self) -> bool {
        self.objects.iter().any(|object| !dsm_core::Transmittance::is_mono(object.opacity))
    }

    /// True if there are volumes in it.
    #[must_use]
    pub fn has_media(&self) -> bool {
        self.objects.iter().any(|object| matches!(&*object.shape, Shape::Volume(_)))
    }

    /// True if anything moves while the shutter is open.
    #[must_use]
    pub fn is_moving(&self) -> bool {
        self.objects.iter().any(Object::is_moving)
    }

    /// The side of a pixel of the light's view in scene units, with so many of them, where
    /// the scene is nearest to the light's eye; `None` for an empty scene or no such view.
    #[must_use]
    pub fn pixel_size(&self, resolution: [u32; 2]) -> Option<f64> {
        let (view, bounds) = (self.light.raster(resolution).ok()?, self.bounds());
        if bounds.is_empty() {
            return None;
        }
        let nearest = (view.eye() - view.eye().clamp(bounds.min, bounds.max)).length();
        let pixels = resolution[0].max(resolution[1]);
        let pixel = 2.0 * view.half_size().max_element() / f64::from(pixels);
        Some(if view.is_perspective() { pixel * nearest } else { pixel })
    }

    /// The width of the thinnest strand in the world, at its thickest place; `None`
    /// without strands. O(points).
    #[must_use]
    pub fn finest_strand(&self) -> Option<f64> {
        let widths = self.objects.iter().filter_map(|object| {
            let Shape::Curves(curves) = &*object.shape else { return None };
            let axes = [0.0, 1.0].map(|time| object.to_world(time).matrix3);
            let scales = axes.iter().flat_map(|axes| axes.to_cols_array_2d());
            let scale = scales.map(|axis| DVec3::from(axis).length()).reduce(f64::min)?;
            Some(f64::from(curves.finest_width()?) * scale)
        });
        widths.reduce(f64::min)
    }

    /// The box around everything in the world.
    #[must_use]
    pub fn bounds(&self) -> Bounds {
        self.objects.iter().map(Object::bounds).fold(Bounds::default(), Bounds::union)
    }
}

fn bounding_sphere(bounds: &Bounds) -> (DVec3, f64) {
    if bounds.is_empty() {
        return (DVec3::ZERO, 1.0);
    }
    let radius = (bounds.max - bounds.min).length() / 2.0;
    (bounds.centre(), if radius > 0.0 { radius } else { 1.0 })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::transform::Transform;
    use glam::Vec3;

    fn triangle() -> Object {
        let corners = vec![Vec3::ZERO, Vec3::X * 2.0, Vec3::Y];
        Object::new(Shape::Mesh(TriangleMesh::new(corners, vec![[0, 1, 2]]).unwrap()))
    }

    #[test]
    fn standard_positions_look_at_the_bounding_sphere() {
        let scene = Scene::of_objects(vec![triangle()]);
        let radius = 5.0_f64.sqrt() / 2.0;
        assert_eq!(scene.light.view.target, DVec3::new(1.0, 0.5, 0.0));
        let distance = (scene.light.view.eye - scene.light.view.target).length();
        assert!((distance - 3.0 * radius).abs() < 1e-12);
        let empty = Scene::of_objects(Vec::new());
        assert!((empty.light.view.eye.length() - 3.0).abs() < 1e-12);
        assert!(empty.light.raster([8, 8]).is_ok() && empty.camera.raster([8, 8]).is_ok());
    }

    #[test]
    fn motions_apply_from_the_inside() {
        let shift = Transform { translate: DVec3::X, ..Transform::default() };
        let turn = Transform { rotate: DVec3::new(0.0, 0.0, 90.0), ..Transform::default() };
        let motion = vec![Motion { open: Transform::default(), close: shift }, Motion::still(turn)];
        let object = Object { motion, ..triangle() };
        assert!(object.is_moving());
        let moved = object.to_world(1.0).transform_point3(DVec3::ZERO);
        assert!((moved - DVec3::Y).length() < 1e-15);
        let bounds = object.bounds();
        assert!((bounds.min - DVec3::new(-1.0, 0.0, 0.0)).length() < 1e-12);
        assert!((bounds.max - DVec3::new(0.0, 3.0, 0.0)).length() < 1e-12);
    }

    #[test]
    fn the_finest_strand_is_the_thinnest_where_it_is_thickest() {
        let points = vec![Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z, Vec3::ONE, Vec3::X];
        // One that tapers, one thinner one, one without a width, and a lone point.
        let radii = vec![0.5, 0.0, 0.25, 0.25, 0.0, 0.125];
        let curves = Curves::new(points, radii, [2, 2, 1, 1]).unwrap();
        assert_eq!(curves.finest_width(), Some(0.5));
        let scale = |scale| Transform { scale, ..Transform::default() };
        let motion = vec![Motion { open: scale(3.0), close: scale(2.0) }];
        let hair = Object { motion, ..Object::new(Shape::Curves(curves)) };
        let finest = Scene::of_objects(vec![triangle(), hair]).finest_strand().unwrap();
        assert!((finest - 1.0).abs() < 1e-12, "{finest}");
        assert_eq!(Scene::of_objects(vec![triangle()]).finest_strand(), None);
    }

    #[test]
    fn odd_objects_are_refused() {
        let odd = [f32::NAN, -0.1, 1.1];
        for value in odd {
            let opacity = Rgb::new(0.5, value, 0.5);
            let error = triangle().with_opacity(opacity).check().unwrap_err();
            assert!(error.to_string().starts_with("opacity: "), "{error}");
        }
        assert!(Object { density: -1.0, ..triangle() }.check().is_err());
        let flat = Transform { scale: 0.0, ..Transform::default() };
        assert!(Object { motion: vec![Motion::still(flat)], ..triangle() }.check().is_err());
        assert!(triangle().check().is_ok());
    }
}
