//! Crops of every kind that has them, put together: the bytes of the whole.

use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

use deepshadow::scene::{Scene, builtin_scene};
use deepshadow::{Bake, Kind, Query, ShadowMap, bake, merge};

/// Kinds with scenes that show what they are made for, and limits that cut some pixels.
fn bakes() -> Vec<(&'static str, Bake)> {
    let size = [200, 120];
    let of = |kind| {
        let mut settings = Bake::new(size).unwrap().with_kind(kind);
        // No multiple of the blocks that sources are asked for.
        settings.tile_size = 24;
        settings
    };
    let fragments = of(Kind::FRAGMENTS).with_coverage(2);
    vec![
        ("foliage", of(Kind::DEEP).with_samples(4)),
        ("hairball", fragments.clone()),
        ("hairball", fragments.clone().with_max_layers(3)),
        ("stained-glass", fragments.clone()),
        ("smoke", fragments),
        ("hairball", of(Kind::LAYERS).with_max_layers(4)),
        ("stained-glass", of(Kind::LAYERS)),
        ("hairball", of(Kind::MTSM).with_max_layers(4)),
        ("smoke", of(Kind::MTSM).with_samples(4)),
        ("stained-glass", of(Kind::MTSM)),
        ("hairball", of(Kind::VIEWS).with_views(4)),
    ]
}

fn write(scene: &Scene, settings: &Bake, path: &Path) {
    bake(scene, &scene.light, settings, path, |_| ControlFlow::Continue(())).unwrap();
}

fn merged(crops: &[PathBuf], output: &Path) -> Result<(), String> {
    let done = merge(crops, output, None, |_| ControlFlow::Continue(()));
    done.map(drop).map_err(|error| error.to_string())
}

#[test]
fn crops_of_any_kind_make_the_whole() {
    let folder = tempfile::tempdir().unwrap();
    let [whole, made] = ["whole.dsm", "made.dsm"].map(|name| folder.path().join(name));
    for (name, settings) in bakes() {
        let scene = builtin_scene(name).unwrap();
        write(&scene, &settings, &whole);
        let case = format!("{name}, {:?}", settings.kind);
        let map = ShadowMap::open(&whole).unwrap();
        assert!(map.verify().is_empty(), "{case}");
        if settings.max_layers.is_some() {
            let keys = map.kind_metadata().unwrap();
            let cut = keys.get("folded").or(keys.get("left_out")).unwrap();
            assert!(cut["pixels"].as_u64() > Some(0) && cut.get("sum").is_none(), "{case}");
        }
        let mut crops = Vec::new();
        for (index, crop) in settings.parts(5).unwrap().into_iter().enumerate() {
            let path = folder.path().join(format!("{index}.dsm"));
            write(&scene, &settings.clone().with_crop(crop), &path);
            let part = ShadowMap::open(&path).unwrap();
            assert!(part.verify().is_empty(), "{case}");
            assert_eq!(part.size(), [crop[2] - crop[0], crop[3] - crop[1]]);
            if settings.kind != Kind::DEEP {
                let refused = part.shadow(&Query::new()).err().unwrap().to_string();
                assert!(refused.contains("`merge` puts the map together"), "{refused}");
            }
            crops.push(path);
        }
        // In any order.
        crops.rotate_left(2);
        merged(&crops, &made).unwrap();
        assert!(std::fs::read(&made).unwrap() == std::fs::read(&whole).unwrap(), "{case}");
        let missing = merged(&crops[1..], &made).unwrap_err();
        assert!(missing.contains("no crop holds the pixels from"), "{missing}");
        let doubled = [&crops[..], &crops[..1]].concat();
        assert!(merged(&doubled, &made).unwrap_err().contains("another crop holds as well"));
        let alone = merged(&crops[..1], &made).unwrap_err();
        assert!(alone.contains("one crop alone"), "{alone}");
        assert!(std::fs::read(&made).unwrap() == std::fs::read(&whole).unwrap(), "{case}");
    }
}

#[test]
fn what_is_no_crop_of_the_map_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let scene = builtin_scene("hairball").unwrap();
    let settings = Bake::new([128, 64]).unwrap().with_kind(Kind::LAYERS);
    let [left, right] = settings.parts(2).unwrap()[..] else { panic!() };
    let path = |name: &str| folder.path().join(name);
    let [first, other, kind, out] = ["first.dsm", "other.dsm", "kind.dsm", "out.dsm"].map(path);
    write(&scene, &settings.clone().with_crop(left), &first);
    write(&scene, &settings.clone().with_max_layers(9).with_crop(right), &other);
    write(&scene, &settings.with_kind(Kind::MTSM).with_crop(right), &kind);
    let refused = merged(&[first.clone(), other], &out).unwrap_err();
    assert!(refused.contains("no crops of one map"), "{refused}");
    let refused = merged(&[first, kind], &out).unwrap_err();
    assert!(refused.contains("kind.dsm is a map of kind mtsm"), "{refused}");
    assert!(!out.exists());
}

#[test]
fn kinds_without_crops_say_what_to_do() {
    let crop = [0, 0, 64, 64];
    for (kind, advice) in
        [(Kind::PREFILTERED, "bake crops of kind fragments"), (Kind::ATTENUATION, "bake it whole")]
    {
        let settings = Bake::new([128, 64]).unwrap().with_kind(kind).with_crop(crop);
        let refused = settings.check().unwrap_err().to_string();
        assert!(refused.contains(advice), "{refused}");
    }
}
