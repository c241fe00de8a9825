//! Cameras of images: what a map answers at points of the world is what the image
//! holds where they are seen, by whichever convention its matrices follow.

use std::fs::File;
use std::path::{Path, PathBuf};

use deepshadow::{Query, ShadowMap};
use dsm_core::detail::PixelLists;
use dsm_core::{DeepMap, MapInfo, Progress, Projection, View};
use dsm_io::deep_exr::{
    self, Attribute, DeepExrReader, DeepExrWriter, DeepSample, Header, WriteOptions,
};
use dsm_io::detail::{CameraConventions, NdcRange, ViewAxis};
use dsm_io::{
    AchievedError, ConvertOptions, ExportOptions, ImportReport, Metadata, convert, export_deep_exr,
    write_map,
};
use glam::{DMat4, DVec2, DVec3};

use super::{converted, open, options};

const SIZE: [u32; 2] = [12, 12];
const WALL: f64 = 5.0;

/// Images from beside the project, or `None` and a message.
fn given(name: &str) -> Option<PathBuf> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared").join(name);
    if !path.exists() {
        println!("skipped: {} is not there", path.display());
        return None;
    }
    Some(path)
}

fn header(path: &Path) -> Header {
    DeepExrReader::open(path, None, &deep_exr::Limits::default()).unwrap().header().clone()
}

fn answers(map: &Path, points: &[DVec3]) -> Vec<f64> {
    let values = ShadowMap::open(map).unwrap().query(points, &Query::new()).unwrap();
    (0..values.len()).map(|point| f64::from(values.rgb(point)[0])).collect()
}

#[test]
fn points_of_the_world_see_what_renderers_wrote() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["standard", "arnold_screen"] {
        let Some(image) = given(&format!("cases/deep/{name}.exr")) else { return };
        let table = std::fs::read_to_string(image.with_extension("csv")).unwrap();
        let rows = table.lines().skip(1).map(|line| {
            let numbers: Vec<f64> = line.split(',').map(|text| text.parse().unwrap()).collect();
            (DVec3::from_slice(&numbers), numbers[3])
        });
        let (points, wanted): (Vec<_>, Vec<_>) = rows.unzip();
        let map = converted(&image, folder.path(), &options(0.0, 64));
        for ((point, want), found) in points.iter().zip(&wanted).zip(answers(&map, &points)) {
            assert!((found - want).abs() < 1e-5, "{name} at {point}: {found}, not {want}");
        }
        assert!(wanted.iter().any(|&want| want < 0.5) && points.len() > 100);
    }
}

/// The row-vector matrix of an image times a point.
fn times(point: DVec3, matrix: [f32; 16]) -> [f64; 4] {
    let point = [point.x, point.y, point.z, 1.0];
    [0, 1, 2, 3].map(|out| (0..4).map(|i| point[i] * f64::from(matrix[4 * i + out])).sum())
}

#[test]
fn the_world_and_the_raster_of_a_real_image_agree() {
    let Some(image) = given("data/deep/oiio_deepalpha.exr") else { return };
    let folder = tempfile::tempdir().unwrap();
    let told = header(&image);
    let [camera, ndc] = [told.world_to_camera, told.world_to_ndc].map(Option::unwrap);
    let map = converted(&image, folder.path(), &options(0.0, 64));
    let mut rows = DeepExrReader::open(&image, None, &deep_exr::Limits::default()).unwrap();
    let rows = rows.read_rows(0..told.height).unwrap();
    let deepest = rows.z().iter().copied().filter(|z| z.is_finite()).fold(0.0, f32::max);
    let nearest = rows.z().iter().copied().fold(f32::INFINITY, f32::min);
    let [width, height] = told.display_window.size().map(|length| length as f64);
    let to_world = DMat4::from_cols_array(&camera.map(f64::from)).inverse();
    let (mut points, mut raster) = (Vec::new(), Vec::new());
    for index in 0..4000_u32 {
        // A low-discrepancy set of places in the frustum, which a test may look at.
        let place = [0.754_877_67, 0.569_840_3, 0.437_016_02]
            .map(|step: f64| (step * f64::from(index)).fract());
        let depth =
            f64::from(nearest) * 0.9 + place[2] * f64::from(deepest.min(nearest * 4.0)) * 1.1;
        let side = depth * (place[0] - 0.5);
        let point = to_world.transform_point3(DVec3::new(side, depth * (place[1] - 0.5), depth));
        let [x, y, _, w] = times(point, ndc);
        // This renderer's NDC is [−1, 1] with y up, its camera looks along +z.
        let seen = DVec2::new((x / w + 1.0) * 0.5 * width, (1.0 - y / w) * 0.5 * height);
        let seen = seen - DVec2::from(told.data_window.min.map(f64::from));
        let z = times(point, camera)[2];
        if w > 0.0 && seen.cmpge(DVec2::ZERO).all() && seen.x < width && seen.y < height {
            points.push(point);
            raster.push([seen.x, seen.y, z]);
        }
    }
    let opened = ShadowMap::open(&map).unwrap();
    let shadow = opened.shadow(&Query::new()).unwrap();
    let (in_world, in_raster) =
        (shadow.query_from(&points, 0).unwrap(), shadow.query_raster(&raster, 0).unwrap());
    let mut dark = 0;
    for (index, place) in raster.iter().enumerate() {
        let [world, raster_value] = [&in_world, &in_raster].map(|values| values.rgb(index)[0]);
        assert!((world - raster_value).abs() < 1e-6, "{place:?}: {world} {raster_value}");
        dark += usize::from(world < 1.0);
    }
    assert!(points.len() > 1000 && dark > 0, "{} points, {dark} dark", points.len());
}

/// A camera by its axes; `reach` is the tangent of half its angle of view, or half
/// of the width of its window.
#[derive(Clone, Copy, Debug)]
struct Seen {
    eye: DVec3,
    right: DVec3,
    up: DVec3,
    forward: DVec3,
    reach: f64,
    is_perspective: bool,
}

impl Seen {
    fn all() -> [Self; 4] {
        let (right, up) = (DVec3::new(0.6, 0.0, 0.8), DVec3::Y);
        // Right × up points against the view in a right-handed world.
        let level = Self {
            eye: DVec3::new(1.0, -2.0, 3.0),
            right,
            up,
            forward: up.cross(right),
            reach: 0.5,
            is_perspective: true,
        };
        let up = DVec3::new(0.48, 0.8, -0.36);
        let tilted =
            Self { up, forward: up.cross(right), eye: DVec3::new(-40.0, 7.0, 0.5), ..level };
        let flat = |seen: Self| Self { reach: 3.0, is_perspective: false, ..seen };
        [level, tilted, flat(level), flat(tilted)]
    }

    /// The point at this depth that is seen at a place of [−1, 1]², y up.
    fn point(&self, [x, y]: [f64; 2], depth: f64) -> DVec3 {
        let reach = if self.is_perspective { self.reach * depth } else { self.reach };
        self.eye + self.right * (x * reach) + self.up * (y * reach) + self.forward * depth
    }

    /// `worldToCamera` and `worldToNDC` as a file has them by these conventions.
    fn matrices(&self, axis: ViewAxis, range: NdcRange, y_is_up: bool) -> [[f32; 16]; 2] {
        let along = |axis: DVec3| [axis.x, axis.y, axis.z, -axis.dot(self.eye)];
        let [right, up, forward] = [self.right, self.up, self.forward].map(along);
        let one = [0.0, 0.0, 0.0, 1.0];
        let mix =
            |a: [f64; 4], s: f64, b: [f64; 4], t: f64| [0, 1, 2, 3].map(|i| a[i] * s + b[i] * t);
        let w = if self.is_perspective { forward } else { one };
        let [x, mut y] = [right, up].map(|row| mix(row, 1.0 / self.reach, one, 0.0));
        if !y_is_up {
            y = mix(y, -1.0, one, 0.0);
        }
        let [x, y] = match range {
            NdcRange::Screen => [x, y],
            NdcRange::Unit => [x, y].map(|row| mix(row, 0.5, w, 0.5)),
        };
        let z = match axis {
            ViewAxis::PlusZ => forward,
            ViewAxis::MinusZ => mix(forward, -1.0, one, 0.0),
        };
        let in_file = |rows: [[f64; 4]; 4]| {
            let mut numbers = [0.0; 16];
            for (out, row) in rows.iter().enumerate() {
                (0..4).for_each(|i| numbers[4 * i + out] = row[i] as f32);
            }
            numbers
        };
        [in_file([right, up, z, one]), in_file([x, y, forward, w])]
    }
}

fn opacity(x: u32, y: u32) -> f32 {
    (1 + x + SIZE[0] * y) as f32 / 256.0
}

/// Writes an image of a wall, each of whose pixels has an opacity of its own.
fn write_wall(path: &Path, [camera, ndc]: [[f32; 16]; 2]) {
    let mut image = WriteOptions::new(SIZE[0], SIZE[1]);
    image.set(Attribute::floats("worldToCamera", "m44f", &camera)).unwrap();
    image.set(Attribute::floats("worldToNDC", "m44f", &ndc)).unwrap();
    let mut rows = image.rows(SIZE[0]);
    for (y, x) in (0..SIZE[1]).flat_map(|y| (0..SIZE[0]).map(move |x| (y, x))) {
        let z = WALL as f32;
        rows.push(DeepSample { z, z_back: z, alpha: [opacity(x, y); 3] });
        rows.finish_pixel().unwrap();
    }
    let mut writer = DeepExrWriter::new(File::create(path).unwrap(), &image).unwrap();
    writer.write_rows(&rows).unwrap();
    writer.finish().unwrap();
}

/// Converts the wall, and holds every pixel's centre to what is before and behind it.
fn check_wall(
    image: &Path,
    seen: &Seen,
    cameras: CameraConventions,
    folder: &Path,
) -> ImportReport {
    let map = folder.join("wall.dsm");
    let options = ConvertOptions { cameras, ..options(0.0, 64) };
    let report = convert(&mut open(image), &map, &options, Progress::ignore).unwrap();
    let (mut points, mut wanted) = (Vec::new(), Vec::new());
    for (y, x) in (0..SIZE[1]).flat_map(|y| (0..SIZE[0]).map(move |x| (y, x))) {
        let place = [x, y].map(|index| (f64::from(index) + 0.5) / 6.0 - 1.0);
        for (depth, want) in [(0.99, 1.0), (1.01, 1.0 - f64::from(opacity(x, y)))] {
            points.push(seen.point([place[0], -place[1]], WALL * depth));
            wanted.push(want);
        }
    }
    for ((point, want), found) in points.iter().zip(&wanted).zip(answers(&map, &points)) {
        assert!((found - want).abs() < 1e-6, "{seen:?} at {point}: {found}, not {want}");
    }
    report
}

#[test]
fn every_convention_is_recognised() {
    let folder = tempfile::tempdir().unwrap();
    let image = folder.path().join("wall.exr");
    for seen in Seen::all() {
        // The standard; that of clip space; and −z, as this program once wrote.
        for axis in [ViewAxis::PlusZ, ViewAxis::MinusZ] {
            for (range, y_is_up) in [
                (NdcRange::Unit, false),
                (NdcRange::Screen, true),
                (NdcRange::Unit, true),
                (NdcRange::Screen, false),
            ] {
                write_wall(&image, seen.matrices(axis, range, y_is_up));
                let report = check_wall(&image, &seen, CameraConventions::default(), folder.path());
                let read = report.camera.unwrap();
                let told = (read.view_axis, read.ndc_range, read.y_is_up);
                assert_eq!(told, (axis, range, y_is_up), "{seen:?}");
                let line = read.line();
                assert!(line.contains(axis.name()) && line.contains(range.name()), "{line}");
            }
        }
    }
}

#[test]
fn switches_win_over_what_the_matrices_show() {
    let folder = tempfile::tempdir().unwrap();
    let image = folder.path().join("wall.exr");
    let seen = Seen::all()[0];
    let [camera, ndc] = seen.matrices(ViewAxis::PlusZ, NdcRange::Unit, false);
    // z turned the other way only here: the two matrices contradict each other.
    let [turned, _] = seen.matrices(ViewAxis::MinusZ, NdcRange::Unit, false);
    write_wall(&image, [camera, ndc]);
    let cameras =
        CameraConventions { view_axis: Some(ViewAxis::PlusZ), ndc_range: Some(NdcRange::Unit) };
    check_wall(&image, &seen, cameras, folder.path());
    write_wall(&image, [turned, ndc]);
    let cameras = CameraConventions { view_axis: Some(ViewAxis::MinusZ), ..cameras };
    check_wall(&image, &seen, cameras, folder.path());
}

#[test]
fn exports_look_along_plus_z_of_a_left_handed_camera_space() {
    let folder = tempfile::tempdir().unwrap();
    let (map, image) = (folder.path().join("map.dsm"), folder.path().join("map.exr"));
    let view = View { eye: DVec3::new(0.0, 0.0, 5.0), target: DVec3::ZERO, up: DVec3::Y };
    for projection in
        [Projection::Perspective { fov: 90.0 }, Projection::Orthographic { extent: 10.0 }]
    {
        let camera = view.raster(projection, SIZE).unwrap().shadow_camera();
        let info = MapInfo::new().with_camera(camera);
        let pixels = DeepMap::new(info, PixelLists::<f32>::clear(SIZE[0], SIZE[1]));
        let metadata = Metadata::new(SIZE[0], SIZE[1], 1, info);
        write_map(&map, metadata, &pixels, AchievedError::NONE, Default::default()).unwrap();
        export_deep_exr(&mut open(&map), &image, &ExportOptions::default(), Progress::ignore)
            .unwrap();
        let told = header(&image);
        let [camera, ndc] = [told.world_to_camera, told.world_to_ndc].map(Option::unwrap);
        // From (0, 0, 5) to the origin: x is to the right, y up, and z ahead.
        for (point, want) in [
            (DVec3::ZERO, [0.0, 0.0, 5.0]),
            (DVec3::new(1.0, 2.0, 3.0), [1.0, 2.0, 2.0]),
            (DVec3::new(0.0, 0.0, 6.0), [0.0, 0.0, -1.0]),
        ] {
            let [x, y, z, w] = times(point, camera);
            assert!((DVec3::new(x, y, z) - DVec3::from(want)).length() < 1e-6 && w == 1.0);
        }
        // A quarter of the window to the right of its middle, and one above it.
        let [x, y, _, w] = times(DVec3::new(2.5, 2.5, 0.0), ndc);
        assert!((DVec2::new(x, y) / w - DVec2::new(0.75, 0.25)).length() < 1e-6);
        let determinant = DMat4::from_cols_array(&camera.map(f64::from)).determinant();
        assert!((determinant + 1.0).abs() < 1e-6, "{determinant}");
    }
}
