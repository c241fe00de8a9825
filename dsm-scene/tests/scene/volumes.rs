//! Volumes that OpenVDB wrote, against what its own accessors read in them.

use std::path::{Path, PathBuf};

use dsm_scene::detail::{GridChoice, SceneOptions, load_volume, open_scene_with};
use dsm_scene::{Volume, open_scene};
use glam::DVec3;

fn path(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/volumes").join(name)
}

fn load(name: &str, choice: &str) -> Result<Volume, String> {
    let choice: Option<GridChoice> = (!choice.is_empty()).then(|| choice.parse().unwrap());
    load_volume(&path(name), choice.as_ref()).map_err(|error| error.to_string())
}

#[test]
fn every_point_has_the_density_that_openvdb_reads() {
    let table = std::fs::read_to_string(path("values.csv")).unwrap();
    let mut volumes = std::collections::HashMap::new();
    let mut points = 0;
    for line in table.lines() {
        let [name, choice, x, y, z, value] = line.split(',').collect::<Vec<_>>()[..] else {
            panic!("{line}")
        };
        let number = |text: &str| text.parse::<f64>().unwrap();
        let volume = volumes
            .entry((name.to_owned(), choice.to_owned()))
            .or_insert_with(|| load(name, choice).unwrap_or_else(|error| panic!("{error}")));
        let found = f64::from(volume.density(DVec3::new(number(x), number(y), number(z))));
        let expected = number(value).max(0.0);
        assert!((found - expected).abs() < 1e-5, "{name} {choice}: {found} for {line}");
        points += 1;
    }
    assert!(points > 500 && volumes.len() > 20);
}

#[test]
fn grids_are_chosen_by_name_and_number() {
    let refused = |choice: &str| load("several.vdb", choice).unwrap_err();
    let names = "density:0, flame, density:1, again, surface, velocity";
    for choice in ["", "density", "smoke", "density:2"] {
        assert!(refused(choice).contains(names), "{}", refused(choice));
    }
    assert!(refused("surface").contains("level set"));
    assert!(refused("velocity").contains("Tree_vec3s_5_4_3"));
    // An instance lies elsewhere with the same values.
    let [flame, again] = ["flame", "again"].map(|name| load("several.vdb", name).unwrap());
    assert_eq!(flame.voxel_count(), again.voxel_count());
    assert_eq!(again.voxel_size(), DVec3::splat(2.0));
}

#[test]
fn what_cannot_be_a_density_is_refused_by_name() {
    assert!(load("frustum.vdb", "").unwrap_err().contains("NonlinearFrustumMap"));
}

#[test]
fn a_negative_background_is_no_density() {
    let volume = load("negative_background.vdb", "").unwrap();
    // Selected and unselected inactive values: +0.5 and the background.
    assert_eq!(volume.voxel([2, 33, -8].into()), 0.5);
    assert_eq!(volume.voxel([40, 33, -8].into()), 0.0);
}

#[test]
fn a_background_reaches_one_voxel_beyond_the_active() {
    let volume = load("background.vdb", "").unwrap();
    let bounds = volume.bounds();
    assert_eq!(bounds.min, DVec3::new(-4.0, 29.0, -10.0));
    assert_eq!(volume.density(DVec3::new(-3.5, 29.0, -9.5)), 0.125);
}

/// A volume from beside the project, or `None` and a message.
fn given(name: &str) -> Option<PathBuf> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/cases/volume").join(name);
    if !path.exists() {
        println!("skipped: {} is not there", path.display());
        return None;
    }
    Some(path)
}

#[test]
fn half_floats_as_openvdb_saves_them_by_default_are_read() {
    let Some(path) = given("half_compressed.vdb") else { return };
    let volume = load_volume(&path, None).unwrap();
    assert_eq!(volume.voxel_size(), DVec3::splat(0.5));
    let mut held = 0;
    for index in 0..10 * 10 * 10 {
        let [x, y, z] = [index % 10 - 1, index / 10 % 10 + 31, index / 100 - 1];
        let is_inside = (0..8).contains(&x) && (32..40).contains(&y) && (0..8).contains(&z);
        let found = volume.voxel([x, y, z].into());
        assert_eq!(found, if is_inside { 1.5 } else { 0.0 }, "{x} {y} {z}");
        held += usize::from(found > 0.0);
    }
    assert_eq!(held, 512);
}

#[test]
fn a_switch_and_a_key_choose_the_same_grid() {
    let Some(two) = given("two_same.vdb") else { return };
    let Some(capital) = given("density_capital.vdb") else { return };
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.toml");
    let by_key = |file: &Path, grid: &str| {
        let text = format!("[[object]]\nvolume = '{}'\ngrid = '{grid}'\n", file.display());
        std::fs::write(&path, text).unwrap();
        open_scene(&path)
    };
    let volume = |scene: Result<dsm_scene::Scene, dsm_scene::Error>| {
        let scene = scene.unwrap();
        let dsm_scene::Shape::Volume(volume) = &*scene.objects[0].shape else { panic!("a volume") };
        volume.clone()
    };
    let by_switch = |file: &Path, grid: &str| {
        open_scene_with(file, &SceneOptions::default().grid(grid.parse().unwrap()))
    };
    let mut means = Vec::new();
    for (file, grid) in
        [(&two, "density:0"), (&two, "density:1"), (&capital, "Density"), (&capital, "flame")]
    {
        let [key, switch] = [volume(by_key(file, grid)), volume(by_switch(file, grid))];
        let middle = |volume: &Volume| volume.density(volume.bounds().centre());
        assert_eq!(middle(&key).to_bits(), middle(&switch).to_bits(), "{grid}");
        assert_eq!(key.voxel_count(), switch.voxel_count());
        means.push((middle(&key), key.bounds().min.to_array().map(f64::to_bits)));
    }
    assert!(means[0] != means[1] && means[2] != means[3], "{means:?}");
    for refused in [by_key(&two, "density"), by_switch(&two, "density"), open_scene(&two)] {
        let error = refused.unwrap_err().to_string();
        assert!(error.contains("density:0, density:1"), "{error}");
    }
    // In whatever case, where there is one.
    assert!(open_scene(&capital).is_ok());
    let error = by_switch(&path, "density").unwrap_err().to_string();
    assert!(error.contains("only a volume's file"), "{error}");
}
