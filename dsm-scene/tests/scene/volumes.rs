//! Volumes that OpenVDB wrote, against what its own accessors read in them.

use std::path::{Path, PathBuf};

use dsm_scene::Volume;
use dsm_scene::detail::{GridChoice, load_volume};
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
