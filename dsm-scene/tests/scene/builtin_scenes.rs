//! The scenes that are made here.

use dsm_core::RayHits;
use dsm_scene::detail::BUILTIN_SCENES;
use dsm_scene::{Scene, Shape, TracedScene, builtin_scene, open_scene};

/// A number that changes with any bit of any coordinate.
fn fingerprint(scene: &Scene) -> u64 {
    let mut hash = 0xcbf2_9ce4_8422_2325_u64;
    let mut add = |bits: u32| hash = (hash ^ u64::from(bits)).wrapping_mul(0x100_0000_01b3);
    for object in &scene.objects {
        match &*object.shape {
            Shape::Mesh(mesh) => {
                mesh.positions().iter().flat_map(|p| p.to_array()).for_each(|x| add(x.to_bits()));
                mesh.triangles().iter().flatten().for_each(|&corner| add(corner));
            }
            Shape::Curves(curves) => {
                curves.points().iter().flat_map(|p| p.to_array()).for_each(|x| add(x.to_bits()));
                curves.radii().iter().for_each(|radius| add(radius.to_bits()));
            }
            Shape::Volume(volume) => {
                let [low, high] = volume.extent().unwrap();
                for z in low.z..=high.z {
                    for y in low.y..=high.y {
                        (low.x..=high.x)
                            .for_each(|x| add(volume.voxel((x, y, z).into()).to_bits()));
                    }
                }
            }
        }
    }
    hash
}

#[test]
fn they_are_the_same_everywhere() {
    let fingerprints: Vec<_> = BUILTIN_SCENES
        .iter()
        .map(|name| (*name, format!("{:016x}", fingerprint(&builtin_scene(name).unwrap()))))
        .collect();
    let expected = [
        ("hairball", "677e719a91bda257"),
        ("fur-plane", "e1c98d5e9a1b7389"),
        ("foliage", "5e5d12f98d3ede9d"),
        ("smoke", "4fa17640889ab7f9"),
        ("pipes", "00120ba6d35dd479"),
        ("spinning-sphere", "1fb11f31fb3ab23f"),
        ("stained-glass", "803bd4cbfafa4520"),
    ];
    assert_eq!(fingerprints, expected.map(|(name, hash)| (name, hash.to_owned())));
}

#[test]
fn they_hold_what_they_promise() {
    let count = |name: &str| {
        let scene = open_scene(format!("builtin:{name}").as_ref()).unwrap();
        scene.objects.iter().fold([0, 0, 0], |[triangles, segments, voxels], object| match &*object
            .shape
        {
            Shape::Mesh(mesh) => [triangles + mesh.triangles().len(), segments, voxels],
            Shape::Curves(curves) => [triangles, segments + curves.segments().len(), voxels],
            Shape::Volume(volume) => [triangles, segments, voxels + volume.voxel_count() as usize],
        })
    };
    assert_eq!(count("hairball")[1], 800_000);
    assert_eq!(count("fur-plane")[1], 200_000);
    assert_eq!(count("foliage")[0], 300_002);
    assert!(count("smoke")[2] > 20_000);
    assert!(count("pipes")[2] > 50_000 && count("pipes")[0] == 3 * 96 + 2);
    assert!(builtin_scene("spinning-sphere").unwrap().is_moving());
    assert!(builtin_scene("stained-glass").unwrap().is_coloured());
    let error = builtin_scene("moss").unwrap_err().to_string();
    assert!(error.contains("moss") && error.contains("hairball, fur-plane"), "{error}");
}

#[test]
fn their_lights_and_cameras_see_them() {
    for name in BUILTIN_SCENES {
        let scene = builtin_scene(name).unwrap();
        let traced = TracedScene::new(&scene).unwrap();
        let mut tracer = traced.tracer();
        let rasters = [scene.light.raster([24, 24]), scene.camera.raster([24, 24])];
        for raster in rasters.map(Result::unwrap) {
            // How many rays meet something before the floor.
            let mut met = 0;
            for pixel in 0..24 * 24 {
                let (x, y) = (f64::from(pixel % 24) + 0.5, f64::from(pixel / 24) + 0.5);
                let mut hits = RayHits::<f32>::default();
                tracer.hits(&raster.ray(x, y, 0.5), &mut hits).unwrap();
                met += u32::from(hits.surfaces().len() > 1 || !hits.segments().is_empty());
            }
            assert!((30..500).contains(&met), "{name}: {met} of 576");
        }
    }
}
