//! Scenes whose answers have a formula.

use dsm_core::{
    Compression, CompressionMethod, LightExtent, PixelSampling, Projection, Rgb, Tolerance, View,
    VisibilityField,
};
use dsm_scene::{Light, Object, Scene, Shape, Volume};
use glam::{DVec3, UVec3};

use crate::support::{Stage, scene_file};

/// Where the homogeneous box begins and ends below the light, and how far
/// density ramps up before and down behind: the distance of two voxels.
const BOX: [f64; 2] = [4.0, 8.0];
const RAMP: f64 = 0.5;
const EXTINCTION: f32 = 0.16;

/// The distance along the axis through the box up to depth `z`, where the
/// ramps count half.
fn way(z: f64) -> f64 {
    let into = (z - BOX[0] + RAMP).clamp(0.0, RAMP);
    let inside = (z - BOX[0]).clamp(0.0, BOX[1] - BOX[0]);
    let out = (z - BOX[1]).clamp(0.0, RAMP);
    (into * into - out * out) / (2.0 * RAMP) + inside + out
}

/// A box of 70 × 4 × 70 units around the axis of a light that looks down.
fn homogeneous(projection: Projection) -> Stage {
    let voxels = UVec3::new(8, 9, 8);
    let apart = DVec3::new(10.0, RAMP, 10.0);
    let lowest = DVec3::new(-35.0, -BOX[1], -35.0);
    let volume = Volume::from_fn(voxels, apart, lowest, |_| 1.0).unwrap();
    let object = Object { density: EXTINCTION, ..Object::new(Shape::Volume(volume)) };
    let view = View { eye: DVec3::ZERO, target: DVec3::NEG_Y, up: DVec3::Z };
    let light = Light { view, projection, extent: LightExtent::POINT };
    Stage::new(Scene::of_objects(vec![object]).with_light(light))
}

/// The largest error of the optical depth, and of V at `tolerance`.
fn check_homogeneous(projection: Projection, slope: f64) {
    let stage = homogeneous(projection);
    let size = [17, 11];
    let centre = stage.settings(size).with_sampling(PixelSampling::centre());
    let exact = centre.clone().with_tolerance(Tolerance::EXACT);
    let loose = centre.with_tolerance(Tolerance::new(0.02).unwrap());
    let maps = [&exact, &loose].map(|settings| stage.bake::<f32>(settings));
    let (mut worst_depth, mut worst_value) = (0.0_f64, 0.0_f64);
    for (y, x) in (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| (y, x))) {
        // Pixels are square, and the wider side has the angle.
        let lean = |at: u32, end: u32| {
            slope * (2.0 * f64::from(at) + 1.0 - f64::from(end)) / f64::from(size[0])
        };
        let longer = (1.0 + lean(x, size[0]).powi(2) + lean(y, size[1]).powi(2)).sqrt();
        for step in 0..100 {
            let z = (3.0 + 0.06 * f64::from(step)) as f32;
            let expected = f64::from(EXTINCTION) * way(f64::from(z)) * longer;
            let [exact, loose] = maps.each_ref().map(|map| map.evaluate([x, y], z).unwrap());
            worst_depth = worst_depth.max((-f64::from(exact).ln() - expected).abs());
            worst_value = worst_value.max((f64::from(loose) - (-expected).exp()).abs());
        }
    }
    println!("homogeneous box, slope {slope:.2}: {worst_depth:.1e}, {worst_value:.4} of 0.02");
    assert!(worst_depth <= 1e-4, "{worst_depth}");
    assert!(worst_value <= 0.02 + 1e-6 && worst_value > 0.001, "{worst_value}");
}

#[test]
fn a_homogeneous_box_has_its_optical_depth() {
    check_homogeneous(Projection::Orthographic { extent: 10.0 }, 0.0);
}

#[test]
fn a_wide_perspective_lengthens_the_way() {
    let fov = 120.0_f64;
    check_homogeneous(Projection::Perspective { fov }, (fov / 2.0).to_radians().tan());
}

/// A light 5 above the floor that sees the square from −2 to 2.
const FROM_ABOVE: &str = "[light]\neye = [0, 5, 0]\ntarget = [0, 0, 0]\nup = [0, 0, -1]\n\
                          projection = 'orthographic'\nextent = 4\n";

#[test]
fn red_glass_passes_red_only() {
    let folder = tempfile::tempdir().unwrap();
    let quad = "v -3 0 -3\nv 3 0 -3\nv 3 0 3\nv -3 0 3\nf 1 2 3 4\n";
    std::fs::write(folder.path().join("pane.obj"), quad).unwrap();
    // Red everywhere; then half of it blue glass on the right.
    let text = format!(
        "{FROM_ABOVE}\
         [[object]]\nmesh = 'pane.obj'\nopacity = [0, 1, 1]\ntransform = {{ translate = [0, 2, 0] }}\n\
         [[object]]\nmesh = 'pane.obj'\nopacity = [1, 1, 0.5]\ntransform = {{ translate = [3, 1, 0] }}\n"
    );
    let stage = scene_file(folder.path(), &text);
    assert!(stage.scene.is_coloured());
    let settings = stage.settings([8, 8]).with_tile_size(4);
    let coloured = stage.bake::<Rgb>(&settings);
    // With its steps as they are: shorter functions come near them.
    let greedy = Compression::new(CompressionMethod::Greedy);
    let grey = stage.bake::<f32>(&settings.clone().with_compression(greedy));
    for (y, x) in (0..8).flat_map(|y| (0..8).map(move |x| (y, x))) {
        let at = |z| coloured.evaluate([x, y], z).unwrap();
        assert_eq!(at(3.0_f32.next_down()), Rgb::new(1.0, 1.0, 1.0));
        assert_eq!(at(3.0), Rgb::new(1.0, 0.0, 0.0));
        let both = if x < 4 { Rgb::new(1.0, 0.0, 0.0) } else { Rgb::new(0.0, 0.0, 0.0) };
        assert_eq!(at(4.0), both);
        let third = grey.evaluate([x, y], 3.0).unwrap();
        assert!((third - 1.0 / 3.0).abs() < 1e-6, "the mean of the channels, not {third}");
    }
}

/// A sphere of radius 1 in `rows` of quads, as OBJ.
fn sphere(rows: u32) -> String {
    let mut text = String::new();
    let columns = 2 * rows;
    for row in 0..=rows {
        let polar = std::f64::consts::PI * f64::from(row) / f64::from(rows);
        for column in 0..columns {
            let turn = std::f64::consts::TAU * f64::from(column) / f64::from(columns);
            let (x, z) = (polar.sin() * turn.cos(), polar.sin() * turn.sin());
            text += &format!("v {x} {} {z}\n", polar.cos());
        }
    }
    for row in 0..rows {
        for column in 0..columns {
            let next = (column + 1) % columns;
            let [a, b] = [column, next].map(|column| 1 + row * columns + column);
            text += &format!("f {a} {b} {} {}\n", b + columns, a + columns);
        }
    }
    text
}

/// The radius of the sphere, and where its centre goes along x.
const RADIUS: f64 = 0.6;
const PATH: [f64; 2] = [-0.8, 0.8];

/// How long the moving sphere covers a point.
fn covered(x: f64, z: f64) -> f64 {
    let half = RADIUS * RADIUS - z * z;
    if half <= 0.0 {
        return 0.0;
    }
    let half = half.sqrt();
    let time = |x: f64| ((x - PATH[0]) / (PATH[1] - PATH[0])).clamp(0.0, 1.0);
    time(x + half) - time(x - half)
}

#[test]
fn a_moving_sphere_sweeps_its_coverage() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("sphere.obj"), sphere(96)).unwrap();
    let text = format!(
        "{FROM_ABOVE}[[object]]\nmesh = 'sphere.obj'\n\
         transform = {{ translate = [{}, 1, 0], scale = {RADIUS} }}\n\
         transform_end = {{ translate = [{}, 1, 0], rotate = [0, 70, 0] }}\n",
        PATH[0], PATH[1]
    );
    let stage = scene_file(folder.path(), &text);
    assert!(stage.traced.is_moving());
    let (side, samples) = (32, 256);
    let sampling = PixelSampling::new(samples, 0).unwrap();
    let tolerance = Some(Tolerance::EXACT);
    let settings = stage.settings([side; 2]).with_sampling(sampling).with_tolerance(tolerance);
    let map = stage.bake::<f32>(&settings);

    let sigma = 0.5 / f64::from(samples).sqrt();
    // The sphere has flat sides: chords are that much shorter at most.
    let flat = 2.0 * RADIUS * (1.0 - (std::f64::consts::PI / 192.0).cos()) / (PATH[1] - PATH[0]);
    let steps = 40;
    let pixel = 4.0 / f64::from(side);
    let (mut beyond, mut worst, mut sum, mut partly) = (0, 0.0_f64, 0.0, 0);
    for (row, column) in (0..side).flat_map(|y| (0..side).map(move |x| (y, x))) {
        let mut expected = 0.0;
        for (v, u) in (0..steps).flat_map(|v| (0..steps).map(move |u| (v, u))) {
            let place = |at: u32, sub: i32| {
                (f64::from(at) + (f64::from(sub) + 0.5) / f64::from(steps)) * pixel - 2.0
            };
            expected += covered(place(column, u), place(row, v)) / f64::from(steps * steps);
        }
        let blocked = 1.0 - f64::from(map.evaluate([column, row], 100.0).unwrap());
        if expected == 0.0 {
            assert_eq!(blocked, 0.0, "{column} {row}");
            continue;
        }
        partly += 1;
        let off = blocked - expected;
        sum += off;
        worst = worst.max(off.abs());
        beyond += usize::from(off.abs() > 4.0 * sigma + flat);
        assert!(
            off.abs() <= 6.0 * sigma + 1.0 / f64::from(samples) + flat,
            "{column} {row}: {off}"
        );
    }
    let mean = sum / f64::from(partly);
    println!("swept sphere: worst {:.3} of 4σ, mean {mean:+.1e}", worst / (4.0 * sigma));
    assert!(partly > 200 && beyond * 1000 <= partly as usize, "{beyond} of {partly}");
    assert!(mean.abs() <= 4.0 * sigma / f64::from(partly).sqrt() + flat, "{mean}");
}
