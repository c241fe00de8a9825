//! Files that other programs wrote.

use dsm_scene::Curves;
use dsm_scene::detail::{Bounds, load_curves, load_mesh, load_volume};
use glam::{DVec3, IVec3};

use crate::support::real_file;

fn assert_bounds(bounds: &Bounds, min: [f64; 3], max: [f64; 3], tolerance: f64) {
    let near = |a: DVec3, b: [f64; 3]| (a - DVec3::from(b)).abs().max_element() <= tolerance;
    assert!(near(bounds.min, min) && near(bounds.max, max), "{bounds:?}");
}

/// The box around the points alone.
fn point_bounds(curves: &Curves) -> Bounds {
    let points = curves.points().iter().map(|point| point.as_dvec3());
    points.fold(Bounds::default(), |b, p| b.union(Bounds { min: p, max: p }))
}

#[test]
fn hair() {
    let Some(path) = real_file("hair/ponytail.hair") else { return };
    let ponytail = load_curves(&path).unwrap();
    assert_eq!(ponytail.strand_count(), 4933);
    assert_eq!(ponytail.points().len(), 4933 * 16);
    assert_eq!(ponytail.segments().len(), 4933 * 15);
    assert_bounds(&point_bounds(&ponytail), [-32.0, -3.0, -36.0], [33.0, 124.0, 78.0], 0.51);
    let Some(path) = real_file("hair/sintel.hair") else { return };
    let sintel = load_curves(&path).unwrap();
    assert_eq!((sintel.strand_count(), sintel.points().len()), (11_400, 11_400 * 16));
    assert_bounds(&point_bounds(&sintel), [-0.12, 1.40, -0.13], [0.10, 1.67, 0.13], 0.006);
    assert!(sintel.radii().iter().all(|&radius| radius > 0.0));
}

#[test]
fn obj_heads() {
    for (name, triangles) in [("hair/ponytail_head.obj", 17_894), ("hair/sintel_head.obj", 5952)] {
        let Some(path) = real_file(name) else { return };
        assert_eq!(load_mesh(&path).unwrap().triangles().len(), triangles, "{name}");
    }
}

#[test]
fn glb_tree_and_fox() {
    let Some(path) = real_file("mesh/eztree_oak_medium.glb") else { return };
    let oak = load_mesh(&path).unwrap();
    assert_eq!(oak.triangles().len(), 13_806);
    // Leaves are cut out of squares, branches are whole.
    let mut kinds = [0, 0, 0];
    for triangle in 0..oak.triangles().len() {
        let opacities = [(0.1, 0.1), (0.3, 0.3), (0.45, 0.45), (0.8, 0.1), (0.1, 0.8)]
            .map(|(u, v)| oak.opacity(triangle, u, v));
        assert!(opacities.iter().all(|&opacity| opacity == 0.0 || opacity == 1.0));
        let sum: f32 = opacities.iter().sum();
        kinds[usize::from(sum > 0.0) + usize::from(sum == 5.0)] += 1;
    }
    assert!(kinds[2] > 1000 && kinds[1] > 1000, "{kinds:?}");
    let Some(path) = real_file("mesh/Fox.glb") else { return };
    let fox = load_mesh(&path).unwrap();
    assert_eq!(fox.triangles().len(), 576);
    assert!(fox.alphas().is_empty());
}

#[test]
fn vdb_smoke() {
    let Some(path) = real_file("volume/smoke.vdb") else { return };
    let smoke = load_volume(&path, None).unwrap();
    assert_eq!(smoke.voxel_count(), 1_049_275);
    let [low, high] = smoke.extent().unwrap();
    assert_eq!(high - low + 1, IVec3::new(111, 222, 112));
    assert!((smoke.largest() - 5.715).abs() < 1e-3, "{}", smoke.largest());
    assert!((smoke.voxel_size() - 0.476).abs().max_element() < 1e-3, "{}", smoke.voxel_size());
}
