//! Scene files.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use dsm_core::{LightExtent, Projection, Rgb, View};
use glam::DVec3;
use serde::Deserialize;

use crate::builtin::builtin_scene;
use crate::error::{Error, Place, Result};
use crate::frame::{frame_path, has_frame};
use crate::load::library::Library;
use crate::load::read_stage;
use crate::load::warnings::Warnings;
use crate::load::{
    AnimationTime, extension, is_stage, read_curves, read_file, read_mesh, read_shape, read_volume,
};
use crate::scene::{Object, Scene, Shape};
use crate::scene_options::SceneOptions;
use crate::transform::{Motion, Transform};
use crate::view::{Camera, Light};

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct SceneFile {
    camera: Option<CameraTable>,
    light: Option<LightTable>,
    #[serde(default)]
    shutter: ShutterTable,
    #[serde(default)]
    object: Vec<ObjectTable>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct CameraTable {
    eye: [f64; 3],
    target: [f64; 3],
    #[serde(default = "upwards")]
    up: [f64; 3],
    #[serde(default = "usual_angle")]
    fov: f64,
    #[serde(default = "usual_resolution")]
    resolution: [u32; 2],
}

#[derive(Clone, Copy, Default, Deserialize)]
#[serde(rename_all = "lowercase")]
enum ProjectionName {
    #[default]
    Perspective,
    Orthographic,
}

#[derive(Clone, Copy, Default, Deserialize)]
#[serde(rename_all = "lowercase")]
enum ShapeName {
    #[default]
    Point,
    Rectangle,
    Disk,
    Sphere,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct LightTable {
    eye: [f64; 3],
    target: [f64; 3],
    #[serde(default = "upwards")]
    up: [f64; 3],
    #[serde(default)]
    projection: ProjectionName,
    fov: Option<f64>,
    extent: Option<f64>,
    #[serde(default)]
    shape: ShapeName,
    size: Option<[f64; 2]>,
    radius: Option<f64>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ShutterTable {
    #[serde(default)]
    open: f64,
    #[serde(default = "one")]
    close: f64,
}

impl Default for ShutterTable {
    fn default() -> Self {
        Self { open: 0.0, close: 1.0 }
    }
}

#[derive(Clone, Copy, Deserialize)]
#[serde(untagged, expecting = "opacity must be a number or [red, green, blue]")]
enum Opacity {
    Mono(f32),
    Coloured([f32; 3]),
}

#[derive(Clone, Copy, Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct TransformTable {
    translate: Option<[f64; 3]>,
    rotate: Option<[f64; 3]>,
    scale: Option<f64>,
}

impl TransformTable {
    fn over(self, base: Transform) -> Transform {
        Transform {
            translate: self.translate.map_or(base.translate, DVec3::from),
            rotate: self.rotate.map_or(base.rotate, DVec3::from),
            scale: self.scale.unwrap_or(base.scale),
        }
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ObjectTable {
    curves: Option<PathBuf>,
    mesh: Option<PathBuf>,
    volume: Option<PathBuf>,
    builtin: Option<String>,
    usd: Option<PathBuf>,
    time: Option<f64>,
    animation: Option<String>,
    opacity: Option<Opacity>,
    thickness: Option<f32>,
    density: Option<f32>,
    grid: Option<String>,
    #[serde(default)]
    transform: TransformTable,
    #[serde(default)]
    transform_end: TransformTable,
}

impl ObjectTable {
    /// Whether a path has a place for a frame's number.
    fn has_frame(&self) -> bool {
        let paths = [&self.curves, &self.mesh, &self.volume, &self.usd];
        paths.into_iter().flatten().any(|path| has_frame(path))
    }
}

const fn upwards() -> [f64; 3] {
    [0.0, 1.0, 0.0]
}

const fn usual_angle() -> f64 {
    45.0
}

const fn usual_resolution() -> [u32; 2] {
    [640, 360]
}

const fn one() -> f64 {
    1.0
}

/// Opens a scene: a scene file (`.toml`), a model file, or `builtin:NAME`.
///
/// A model file, and a scene file without a light or a camera, gets those of
/// [`Scene::of_objects`]. Paths in a scene file are relative to it. The tables
/// and keys are `[camera]` (`eye`, `target`, `up`, `fov`, `resolution`),
/// `[light]` (`eye`, `target`, `up`, `projection`, `fov`, `extent`, `shape`,
/// `size`, `radius`), `[shutter]` (`open`, `close`) and any number of
/// `[[object]]` (one of `curves`, `mesh`, `volume`, `usd` and `builtin`; `opacity`,
/// `thickness`, `density`, `grid`, `time`, `animation`, `transform`, `transform_end`).
/// Other keys are errors, and so are `thickness` without `curves`, `density` and `grid`
/// without `volume`, `time` without `usd` or a `mesh` in glTF, `animation` without both
/// `mesh` and `time`, `extent` of a perspective light and `fov` of an orthographic one,
/// `size` of what is no rectangle and `radius` of what is no disk or sphere. A USD stage
/// is as many objects as it needs.
///
/// [`Scene::warnings`] holds what models hold that was not understood.
///
/// # Errors
///
/// [`Error::File`] with the cause: the line of what is not TOML or not known,
/// the object and key whose value no scene can have, or what the loader of a
/// model says; [`Error::UnknownBuiltin`].
///
/// ```
/// let folder = tempfile::tempdir()?;
/// let path = folder.path().join("scene.toml");
/// std::fs::write(&path, "[light]\neye = [0, 5, 0]\ntarget = [0, 0, 0]\nwatts = 3\n")?;
/// let error = dsm_scene::open_scene(&path).unwrap_err();
/// assert!(error.to_string().contains("line 4: unknown field `watts`"));
/// assert!(dsm_scene::open_scene("builtin:spinning-sphere".as_ref())?.is_moving());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn open_scene(path: &Path) -> Result<Scene> {
    open_scene_with(path, &SceneOptions::default())
}

/// Opens a scene as [`open_scene`], with choices of what is read of it.
///
/// # Errors
///
/// Those of [`open_scene`]; [`Error::Malformed`] for a grid of a file that is no
/// volume, or a frame of a scene whose name and paths have no `#`; [`Error::Memory`],
/// before the memory is taken, for a scene that needs more than it may take.
pub fn open_scene_with(path: &Path, options: &SceneOptions) -> Result<Scene> {
    let library = Library::new(options.memory.unwrap_or(u64::MAX));
    let scene = match options.frame {
        None => open_named(path, options, false, &library)?,
        Some(frame) => {
            let is_sequence = has_frame(path);
            let path = frame_path(path, frame);
            if !is_sequence && extension(&path).as_deref() != Some("toml") {
                return Err(Error::malformed(Place::Named("frame".into()), NO_FRAMES));
            }
            open_named(&path, options, !is_sequence, &library)?
        }
    };
    let (files, limit) = library.into_memory();
    let scene = Scene { files, ..scene };
    scene.memory().check("", 0, limit)?;
    Ok(scene)
}

/// Opens a scene under its own name. `needs_frames` says that its paths have to have numbers.
fn open_named(
    path: &Path,
    options: &SceneOptions,
    needs_frames: bool,
    library: &Library,
) -> Result<Scene> {
    if let Some(grid) = &options.grid {
        if extension(path).as_deref() != Some("vdb") {
            let reason = "only a volume's file (.vdb) has grids; a scene file has a key for it";
            return Err(Error::malformed(Place::Named("grid".into()), reason));
        }
        let volume = read_volume(path, Some(grid), library)?;
        return Ok(Scene::of_objects(vec![Object::new(Shape::Volume(volume))]));
    }
    if let Some(name) = path.to_str().and_then(|name| name.strip_prefix("builtin:")) {
        return builtin_scene(name);
    }
    if extension(path).as_deref() == Some("toml") {
        let scene = read_scene(path, options.frame, needs_frames, library);
        return scene.map_err(|error| error.in_file(path));
    }
    let mut warnings = Warnings::default();
    let objects = if is_stage(path) {
        read_stage(path, None, library, &mut warnings)?
    } else {
        vec![Object::new(read_shape(path, library, &mut warnings)?)]
    };
    Ok(Scene { warnings: warnings.into_lines(), ..Scene::of_objects(objects) })
}

/// What a scene lacks that is told a frame.
const NO_FRAMES: &str = "neither the scene's name nor a path in it has a # for the number";

fn read_scene(
    path: &Path,
    frame: Option<u32>,
    needs_frames: bool,
    library: &Library,
) -> Result<Scene> {
    let bytes = read_file(path)?;
    let text = String::from_utf8(bytes).map_err(|error| {
        let place = Place::Byte(error.utf8_error().valid_up_to() as u64);
        Error::malformed(place, "not a text in UTF-8")
    })?;
    let folder = path.parent().unwrap_or(Path::new(""));
    parse_scene(&text, folder, frame, needs_frames, library)
}

fn parse_scene(
    text: &str,
    folder: &Path,
    frame: Option<u32>,
    needs_frames: bool,
    library: &Library,
) -> Result<Scene> {
    let file: SceneFile = toml::from_str(text).map_err(|error| {
        let start = error.span().map_or(0, |span| span.start.min(text.len()));
        let line = 1 + text.as_bytes()[..start].iter().filter(|&&byte| byte == b'\n').count();
        let message: Vec<&str> = error.message().split_whitespace().collect();
        Error::malformed(Place::Line(line as u64), message.join(" "))
    })?;
    if needs_frames && !file.object.iter().any(ObjectTable::has_frame) {
        return Err(Error::malformed(Place::Named("frame".into()), NO_FRAMES));
    }
    let mut shapes = Shapes {
        folder,
        frame,
        library,
        loaded: HashMap::new(),
        stages: HashMap::new(),
        builtins: HashMap::new(),
        warnings: Warnings::default(),
    };
    let mut objects = Vec::new();
    for (index, table) in file.object.iter().enumerate() {
        let made = make_object(table, &mut shapes)
            .map_err(|error| within(error, &format!("object {}", index + 1)))?;
        objects.extend(made);
    }
    let mut scene = Scene::of_objects(objects);
    scene.warnings = shapes.warnings.into_lines();
    if let Some(table) = &file.light {
        scene.light = make_light(table).map_err(|error| within(error, "light"))?;
    }
    if let Some(table) = &file.camera {
        scene.camera = make_camera(table).map_err(|error| within(error, "camera"))?;
    }
    let ShutterTable { open, close } = file.shutter;
    if !(open.is_finite() && close.is_finite() && open <= close) {
        let place = Place::Named("shutter".into());
        return Err(Error::malformed(place, "it has to open, and then to close"));
    }
    scene.shutter = [open, close];
    Ok(scene)
}

/// The error with the table that it is in.
fn within(error: Error, table: &str) -> Error {
    match error {
        Error::Malformed { place, reason } => {
            Error::Malformed { place: Place::Named(format!("{table}, {place}")), reason }
        }
        Error::Core(dsm_core::Error::Setting { setting, reason }) => {
            Error::malformed(Place::Named(format!("{table}, {setting}")), reason)
        }
        error => error,
    }
}

/// Shapes from files, each read once.
struct Shapes<'a> {
    folder: &'a Path,
    /// The number in paths.
    frame: Option<u32>,
    library: &'a Library,
    /// By path and by what they are made with.
    loaded: HashMap<(PathBuf, Option<String>), Arc<Shape>>,
    /// By path and the bits of the time.
    stages: HashMap<(PathBuf, Option<u64>), Vec<Object>>,
    /// By name.
    builtins: HashMap<String, Vec<Object>>,
    warnings: Warnings,
}

impl Shapes<'_> {
    /// Where a file is.
    fn place(&self, path: &Path) -> PathBuf {
        match self.frame {
            Some(frame) => self.folder.join(frame_path(path, frame)),
            None => self.folder.join(path),
        }
    }

    fn get(
        &mut self,
        path: &Path,
        made_with: Option<String>,
        load: impl FnOnce(&Path, &Library, &mut Warnings) -> Result<Shape>,
    ) -> Result<Arc<Shape>> {
        let path = self.place(path);
        let key = (path.clone(), made_with);
        if let Some(shape) = self.loaded.get(&key) {
            return Ok(Arc::clone(shape));
        }
        let shape = Arc::new(load(&path, self.library, &mut self.warnings)?);
        self.loaded.insert(key, Arc::clone(&shape));
        Ok(shape)
    }

    fn stage(&mut self, path: &Path, time: Option<f64>) -> Result<Vec<Object>> {
        let key = (self.place(path), time.map(f64::to_bits));
        if let Some(objects) = self.stages.get(&key) {
            return Ok(objects.clone());
        }
        let objects = read_stage(&key.0, time, self.library, &mut self.warnings)?;
        self.stages.insert(key, objects.clone());
        Ok(objects)
    }

    fn builtin(&mut self, name: &str) -> Result<Vec<Object>> {
        if let Some(objects) = self.builtins.get(name) {
            return Ok(objects.clone());
        }
        let objects = builtin_scene(name)?.objects;
        let bytes = objects.iter().map(|object| object.shape.memory()).sum();
        self.library.add_file(Path::new(&format!("builtin:{name}")), bytes)?;
        self.builtins.insert(name.to_owned(), objects.clone());
        Ok(objects)
    }
}

fn make_object(table: &ObjectTable, shapes: &mut Shapes<'_>) -> Result<Vec<Object>> {
    let refuse = |key: &str, reason| Err(Error::malformed(Place::Named(key.into()), reason));
    if table.thickness.is_some() && table.curves.is_none() {
        return refuse("thickness", "only curves have one");
    }
    if table.density.is_some() && table.volume.is_none() {
        return refuse("density", "only volumes have one");
    }
    if table.grid.is_some() && table.volume.is_none() {
        return refuse("grid", "only volumes have one");
    }
    if table.time.is_some() && table.usd.is_none() && table.mesh.is_none() {
        return refuse("time", "only usd and mesh have one");
    }
    if table.time.is_some_and(|time| !time.is_finite()) {
        return refuse("time", "must be finite");
    }
    if table.animation.is_some() && (table.mesh.is_none() || table.time.is_none()) {
        return refuse("animation", "only a mesh at a time has one");
    }
    let ObjectTable { curves, mesh, volume, usd, builtin, .. } = table;
    let mut objects = match (curves, mesh, volume, usd, builtin) {
        (None, None, None, Some(path), None) => shapes.stage(path, table.time)?,
        (Some(path), None, None, None, None) => {
            let load = |path: &Path, library: &Library, _: &mut Warnings| {
                let curves = read_curves(path, library)?;
                Ok(Shape::Curves(match table.thickness {
                    Some(diameter) => curves.with_thickness(diameter).map_err(|_| {
                        let reason = "must lie between 0 and 2e18";
                        Error::malformed(Place::Named("thickness".into()), reason)
                    })?,
                    None => curves,
                }))
            };
            vec![of_shape(shapes.get(path, table.thickness.map(|size| size.to_string()), load)?)]
        }
        (None, Some(path), None, None, None) => {
            let time =
                table.time.map(|time| AnimationTime { time, animation: table.animation.clone() });
            let load = |path: &Path, library: &Library, warnings: &mut Warnings| {
                read_mesh(path, time.as_ref(), library, warnings).map(Shape::Mesh)
            };
            vec![of_shape(shapes.get(path, time.as_ref().map(|time| format!("{time:?}")), load)?)]
        }
        (None, None, Some(path), None, None) => {
            let choice = table.grid.as_deref().map(str::parse).transpose()?;
            let load = |path: &Path, library: &Library, _: &mut Warnings| {
                read_volume(path, choice.as_ref(), library).map(Shape::Volume)
            };
            vec![of_shape(shapes.get(path, table.grid.clone(), load)?)]
        }
        (None, None, None, None, Some(name)) => shapes.builtin(name)?,
        _ => return refuse("shape", "it has one of curves, mesh, volume, usd and builtin"),
    };
    let opacity = match table.opacity {
        None => [1.0; 3],
        Some(Opacity::Mono(value)) => [value; 3],
        Some(Opacity::Coloured(parts)) => parts,
    };
    if !opacity.iter().all(|part| (0.0..=1.0).contains(part)) {
        return refuse("opacity", "must lie in [0, 1]");
    }
    let open = table.transform.over(Transform::default()).check()?;
    let close = table.transform_end.over(open).check()?;
    for object in &mut objects {
        let Rgb { red, green, blue } = object.opacity;
        object.opacity = Rgb::new(red * opacity[0], green * opacity[1], blue * opacity[2]);
        object.density = table.density.unwrap_or(object.density);
        object.motion.push(Motion { open, close });
    }
    objects.into_iter().map(Object::check).collect()
}

fn of_shape(shape: Arc<Shape>) -> Object {
    Object { shape, opacity: Rgb::new(1.0, 1.0, 1.0), density: 1.0, motion: Vec::new() }
}

/// Refuses a key that the light's projection or shape does not have, so that no
/// light is of another size than its file seems to say.
fn check_light_keys(table: &LightTable) -> Result<()> {
    use ShapeName::{Disk, Point, Rectangle, Sphere};
    let point = "a point has none: shape says what else the light is";
    let key = match (table.projection, table.shape) {
        (ProjectionName::Perspective, _) if table.extent.is_some() => {
            ("extent", "a perspective light has a fov instead")
        }
        (ProjectionName::Orthographic, _) if table.fov.is_some() => {
            ("fov", "an orthographic light has an extent instead")
        }
        (_, Point) if table.size.is_some() => ("size", point),
        (_, Point) if table.radius.is_some() => ("radius", point),
        (_, Disk | Sphere) if table.size.is_some() => {
            ("size", "a disk or a sphere has a radius instead")
        }
        (_, Rectangle) if table.radius.is_some() => ("radius", "a rectangle has a size instead"),
        _ => return Ok(()),
    };
    Err(Error::malformed(Place::Named(key.0.into()), key.1))
}

fn make_light(table: &LightTable) -> Result<Light> {
    check_light_keys(table)?;
    let view = View { eye: table.eye.into(), target: table.target.into(), up: table.up.into() };
    let projection = match (table.projection, table.extent) {
        (ProjectionName::Perspective, _) => {
            Projection::Perspective { fov: table.fov.unwrap_or_else(usual_angle) }
        }
        (ProjectionName::Orthographic, Some(extent)) => Projection::Orthographic { extent },
        (ProjectionName::Orthographic, None) => {
            let place = Place::Named("extent".into());
            return Err(Error::malformed(place, "an orthographic light needs one"));
        }
    };
    let radius = table.radius.unwrap_or(0.5);
    let extent = match table.shape {
        ShapeName::Point => LightExtent::POINT,
        ShapeName::Rectangle => LightExtent::rectangle(table.size.unwrap_or([1.0; 2])),
        ShapeName::Disk => LightExtent::disk(radius),
        ShapeName::Sphere => LightExtent::sphere(radius),
    };
    let light = Light { view, projection, extent };
    light.area()?;
    light.raster([1, 1])?;
    Ok(light)
}

fn make_camera(table: &CameraTable) -> Result<Camera> {
    let view = View { eye: table.eye.into(), target: table.target.into(), up: table.up.into() };
    let camera = Camera { view, fov: table.fov, resolution: table.resolution };
    camera.raster(table.resolution)?;
    Ok(camera)
}
