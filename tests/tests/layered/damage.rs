//! Whatever is damaged is found, behind right checksums too.

use dsm_core::Rgb;
use dsm_io::Packing;
use dsm_io::detail::MapKind;
use dsm_tests::forge::Forge;
use dsm_tests::golden;
use dsm_tests::whole_message;
use mtsm::MultilayerMap;
use mtsm::detail::{Layers, Mtsm, MultilayerDepthMap};
use shadow_maps::detail::{
    Attenuation, AttenuationMap, FragmentMap, Fragments, Prefiltered, PrefilteredMap, Views,
    ViewsTracer,
};

use crate::examples::{FOGGY, KINDS, file, open};

fn problems(bytes: Vec<u8>) -> Vec<String> {
    match open(bytes) {
        Ok(reader) => reader.verify().into_iter().map(whole_message).collect(),
        Err(error) => vec![whole_message(error)],
    }
}

fn every_kind() -> Vec<Vec<u8>> {
    let mut files = Vec::new();
    for kind in KINDS {
        for packing in [Packing::Plain, Packing::Zstd] {
            files.push(file::<f32>(kind, packing));
            files.push(file::<Rgb>(kind, packing));
        }
    }
    files
}

#[test]
fn every_changed_byte_is_found() {
    for bytes in every_kind() {
        assert_eq!(problems(bytes.clone()), [""; 0]);
        for position in 0..bytes.len() {
            for flip in [0xff, 1 << (position % 8)] {
                let mut damaged = bytes.clone();
                damaged[position] ^= flip;
                assert!(!problems(damaged).is_empty(), "byte {position} ^ {flip:#x}");
            }
        }
    }
}

#[test]
fn every_truncation_is_refused() {
    for bytes in every_kind() {
        for length in 0..bytes.len() {
            assert!(open(bytes[..length].to_vec()).is_err(), "{length} bytes");
        }
        assert_eq!(problems([bytes, vec![0]].concat()), ["1 bytes follow the end of the map"]);
    }
}

/// Changes words of tile 0's payload behind right checksums: none may panic, and
/// what is taken is what the rules allow.
#[test]
fn any_word_of_a_payload_may_be_anything() {
    for bytes in every_kind() {
        let forge = Forge(bytes);
        let start = forge.payload(0);
        let length = forge.u64(forge.tile_entry(0) + 8) as usize;
        for at in (start..start + length / 4 * 4).step_by(4) {
            for word in [0, 1, 2, 7, 0x7fff_ffff, 0x3f80_0000, 0x7fc0_0000, u32::MAX] {
                let mut changed = forge.clone();
                changed.put(at, word.to_le_bytes());
                if let Ok(map) = open(changed.sign()) {
                    drop(map.verify());
                    drop(map.summary());
                    drop(map.contents(0, [0, 0]));
                    if let Some(reader) = map.downcast_ref::<Mtsm>() {
                        drop(MultilayerMap::<Rgb>::read(reader));
                    }
                    if let Some(reader) = map.downcast_ref::<Layers>() {
                        drop(MultilayerDepthMap::<f32>::read(reader));
                    }
                    if let Some(reader) = map.downcast_ref::<Fragments>() {
                        drop(FragmentMap::<f32>::read(reader));
                    }
                    if let Some(reader) = map.downcast_ref::<Attenuation>() {
                        drop(AttenuationMap::<f32>::read(reader));
                    }
                    if let Some(reader) = map.downcast_ref::<Views>() {
                        drop(ViewsTracer::read(reader));
                    }
                    if let Some(reader) = map.downcast_ref::<Prefiltered>() {
                        drop(PrefilteredMap::<f32>::read(reader));
                    }
                }
            }
        }
    }
}

/// A defect in a signed file, and a part of the error that names it.
fn signed(file: &[u8], says: &str, change: impl FnOnce(&mut Forge)) {
    let mut forge = Forge(file.to_vec());
    change(&mut forge);
    let found = problems(forge.sign());
    assert!(found.iter().any(|problem| problem.contains(says)), "{says}: {found:?}");
}

#[test]
fn what_breaks_a_rule_is_named() {
    let mtsm = file::<f32>(Mtsm::NAME, Packing::Plain);
    let layers = file::<f32>(Layers::NAME, Packing::Plain);
    let count = |f: &Forge| f.u64(f.tile_entry(0) + 24) as usize;
    let last = move |f: &Forge| f.payload(0) + f.u64(f.tile_entry(0) + 8) as usize - 4;
    let negative = (-1.0_f32).to_le_bytes();
    signed(&mtsm, "more runs than layers", |f| f.put(f.payload(0), [0xff; 4]));
    signed(&mtsm, "the run table does not cover", |f| {
        // Where the last of 16 pixels ends.
        f.put(f.payload(0) + 4 * 17, [0; 4]);
    });
    signed(&mtsm, "the first layer of a run counts no samples", |f| {
        let first = last(f) - 4 * (count(f) - 1);
        f.put(first, [1, 0, 0, 0]);
    });
    signed(&mtsm, "values must not be negative", |f| {
        let at = last(f) - 4 * count(f);
        f.put(at, negative);
    });
    signed(&mtsm, "does not fit its number of vertices", |f| {
        let fewer = count(f) as u64 - 1;
        f.put(f.tile_entry(0) + 24, fewer.to_le_bytes());
    });
    signed(&mtsm, "not the range", |f| f.put(f.tile_entry(0) + 32, 0.5_f32.to_le_bytes()));
    signed(&mtsm, "exact depths", |f| f.put(f.tile_entry(0) + 48, 0.5_f32.to_le_bytes()));
    signed(&mtsm, "more runs than the map allows", |f| {
        f.replace("\"resets\":4", "\"resets\":0");
    });
    signed(&mtsm, "more layers than the map allows", |f| {
        f.replace("\"max_layers\":32", "\"max_layers\": 1");
    });
    signed(&mtsm, "metadata", |f| f.replace("\"max_layers\":32", "\"max_layers\": 0"));
    signed(&mtsm, "metadata", |f| f.replace("\"light_depth\":0.25", "\"light_depth\":-0.5"));
    signed(&mtsm, "metadata", |f| f.replace("\"layering\"", "\"larering\""));
    signed(&mtsm, "not one that this program reads", |f| f.replace("\"mtsm\"", "\"mtms\""));
    signed(&mtsm, "version 7 of kind \"mtsm\"; this program reads up to 1", |f| {
        f.replace("\"width\":6,\"height\":5", "\"kind_version\":7    ");
    });
    signed(&mtsm, "not those of a map of the size", |f| {
        f.put(f.section(b"LEVL") + 16, [4, 0, 0, 0]);
    });
    // What would be a crop of another kind.
    let golden = golden::folder().join("golden/prefiltered_plain_mono.dsm");
    let golden = std::fs::read(golden).unwrap();
    signed(&golden, "not those of a prefiltered map of its size", |f| {
        f.put(f.section(b"LEVL") + 16, [8, 0, 0, 0]);
    });
    signed(&layers, "opacities must lie in [0, 1]", |f| {
        let at = last(f);
        f.put(at, negative);
    });
    signed(&layers, "depths must be finite", |f| {
        let at = last(f) - 4 * count(f);
        f.put(at, f32::NAN.to_le_bytes());
    });
    signed(&layers, "the pixel table does not cover", |f| f.put(f.payload(0), [1, 0, 0, 0]));
    signed(&layers, "no room for its columns", |f| {
        f.put(f.tile_entry(0) + 24, [0xff, 0xff, 0, 0]);
    });
    signed(&layers, "more than its columns have", |f| {
        for at in [f.tile_entry(0) + 8, f.tile_entry(0) + 16] {
            let longer = f.u64(at) + 4;
            f.put(at, longer.to_le_bytes());
        }
    });
    let fragments = file::<f32>(Fragments::NAME, Packing::Plain);
    signed(&fragments, "takes nothing away", |f| {
        let [low, high] = [last(f) - 4 * count(f), last(f)];
        f.put(low, [0; 4]);
        f.put(high, [0; 4]);
    });
    signed(&fragments, "plane is not finite", |f| {
        // Before opacities, two halves of masks and flags.
        let at = last(f) - 4 * (3 * count(f) + count(f).div_ceil(32));
        f.put(at, f32::NAN.to_le_bytes());
    });
    // It may be wider, and not narrower.
    signed(&fragments, "not the range", |f| {
        f.put(f.tile_entry(0) + 36, f.u32(f.tile_entry(0) + 32).to_le_bytes())
    });
    for file in [&fragments, &layers] {
        signed(file, "a tile without layers is empty", |f| {
            f.put(f.tile_entry(0) + 24, [0; 8]);
            // The table of 16 pixels.
            f.put(f.payload(0), [0; 4 * 17]);
        });
    }
    let flags = move |f: &Forge| last(f) + 4 - 4 * (3 * count(f) + count(f).div_ceil(32));
    signed(&fragments, "a fragment without a plane has a gradient", |f| {
        // What is no strand has one.
        let (first, gradients) = (flags(f), flags(f) - 4 * 2 * count(f));
        f.put(gradients, 0.5_f32.to_le_bytes());
        f.put(first, [0xff; 4]);
    });
    signed(&fragments, "flags of no fragment", |f| {
        let after = count(f) % 32;
        assert!(after > 0);
        let at = flags(f) + 4 * (count(f) / 32);
        f.put(at, (f.u32(at) | 1 << after).to_le_bytes());
    });
    signed(&fragments, "must be 1, 2, 4 or 8", |f| f.replace("\"coverage\":2", "\"coverage\":3"));
    signed(&fragments, "must be 1, 2, 4 or 8", |f| f.replace("\"coverage\"", "\"cover_ge\""));
    // Fragments under the name of another kind, which readers would misread.
    for name in ["\"layers\"   ", "\"mtsm\"     "] {
        signed(&fragments, "has no key \"coverage\"", |f| f.replace("\"fragments\"", name));
    }
    signed(&fragments, "more layers than the map allows", |f| {
        f.replace("\"max_layers\":32", "\"max_layers\": 1");
    });
    signed(&layers, "more layers than the map allows", |f| {
        f.replace("\"max_layers\":32", "\"max_layers\": 1");
    });
    let prefiltered = file::<f32>(Prefiltered::NAME, Packing::Plain);
    signed(&prefiltered, "opacities must lie in [0, 1]", |f| {
        let at = last(f);
        f.put(at, negative);
    });
    signed(&prefiltered, "a fragment takes nothing away", |f| {
        let at = last(f);
        f.put(at, [0; 4]);
    });
    for bad in [f32::NAN, f32::INFINITY, 0.0, -1.0] {
        signed(&prefiltered, "must be finite, above 0 and not rise", |f| {
            let at = last(f) - 4 * count(f);
            f.put(at, bad.to_le_bytes());
        });
    }
    signed(&prefiltered, "the pixel table does not cover", |f| f.put(f.payload(0), [1, 0, 0, 0]));
    signed(&prefiltered, "not the range", |f| f.put(f.tile_entry(0) + 32, 0.5_f32.to_le_bytes()));
    signed(&prefiltered, "the levels are not those", |f| {
        f.replace("\"stack_from\":1", "\"stack_from\":2");
    });
    signed(&prefiltered, "metadata", |f| f.replace("\"filtering\"", "\"filterinj\""));
    signed(&prefiltered, "metadata", |f| f.replace("\"multiply\"", "\"multiplz\""));
    let attenuation = file::<f32>(Attenuation::NAME, Packing::Plain);
    signed(&attenuation, "attenuations must lie in [0, 1]", |f| {
        let at = last(f);
        f.put(at, negative);
    });
    signed(&attenuation, "a layer that sees no light is none", |f| {
        let at = last(f);
        f.put(at, [0; 4]);
    });
    for bad in [f32::NAN, f32::INFINITY, 0.0, -1.0] {
        signed(&attenuation, "must be finite, above 0 and not rise", |f| {
            let at = last(f) - 4 * count(f);
            f.put(at, bad.to_le_bytes());
        });
    }
    signed(&attenuation, "one point of its light", |f| {
        f.replace("\"light_samples\":2", "\"light_samples\":0");
    });
    signed(&attenuation, "metadata", |f| {
        f.replace("\"light_samples\":2", "\"light_samplez\":2");
    });
    signed(&attenuation, "not negative", |f| {
        f.replace("\"depth_tolerance\":1.0", "\"depth_tolerance\":-10");
    });
    let views = file::<f32>(Views::NAME, Packing::Plain);
    for bad in [f32::NAN, f32::INFINITY, -1.0] {
        signed(&views, "must be finite and not negative", |f| {
            f.put(f.payload(0), bad.to_le_bytes());
        });
    }
    signed(&views, "not see as many surfaces", |f| {
        let fewer = count(f) as u64 - 1;
        f.put(f.tile_entry(0) + 24, fewer.to_le_bytes());
    });
    signed(&views, "not the range", |f| f.put(f.tile_entry(0) + 32, 0.5_f32.to_le_bytes()));
    signed(&views, "one level a view", |f| {
        f.replace("[[-0.25,0.0,0.0],[0.5,0.0,0.0]]", "[[-0.25,0.0,0.0]              ]");
    });
    signed(&views, "metadata", |f| f.replace("\"eyes\"", "\"eyez\""));
    signed(&views, "gap bias", |f| f.replace("\"gap\":4.0", "\"gap\":-40"));
}

#[test]
fn what_breaks_a_rule_of_media_is_named() {
    let foggy = file::<f32>(FOGGY, Packing::Plain);
    // Behind all else: depths of borders, and as many thicknesses.
    let borders = |f: &Forge| f.u32(f.payload(0) + 4 * 33) as usize;
    let last = |f: &Forge| f.payload(0) + f.u64(f.tile_entry(0) + 8) as usize - 4;
    let first = |f: &Forge| last(f) - 4 * (borders(f) - 1);
    assert!(borders(&Forge(foggy.clone())) > 8);
    signed(&foggy, "begin at the first border and end at the last", |f| f.put(last(f), [0; 4]));
    signed(&foggy, "begin at the first border", |f| f.put(first(f), 0.5_f32.to_le_bytes()));
    signed(&foggy, "thickness of media must be", |f| {
        f.put(last(f), (-1.0_f32).to_le_bytes());
    });
    signed(&foggy, "borders of media must rise", |f| {
        f.put(last(f) - 4 * borders(f), 0.25_f32.to_le_bytes());
    });
    signed(&foggy, "depth of a border must be finite", |f| {
        f.put(last(f) - 4 * borders(f), f32::NAN.to_le_bytes());
    });
    signed(&foggy, "more borders of media than it states", |f| {
        f.put(f.payload(0) + 4 * 33, u32::MAX.to_le_bytes());
    });
    signed(&foggy, "before they begin, or beyond the columns", |f| {
        f.put(f.payload(0) + 4 * 17, [0; 4]);
        f.put(f.payload(0) + 4 * 18, u32::MAX.to_le_bytes());
    });
    // It may be wider, and not narrower.
    signed(&foggy, "not the range", |f| f.put(f.tile_entry(0) + 36, 2.0_f32.to_le_bytes()));
    signed(&foggy, "bound of slabs", |f| f.replace("\"max_slabs\":256", "\"max_slabs\":  0"));
    signed(&foggy, "more slabs of media than the map allows", |f| {
        f.replace("\"max_slabs\":256", "\"max_slabs\":  1");
    });
    // A header that says less, or more, than it needs.
    signed(&foggy, "version 1 of kind \"fragments\", whose keys are those of version 2", |f| {
        f.replace("\"kind_version\":2", "\"kind_version\":1");
    });
    signed(&foggy, "version 2 of kind \"fragments\", whose keys are those of version 1", |f| {
        f.replace("\"media\":", "\"medea\":");
    });
    signed(&foggy, "version 3 of kind \"fragments\"; this program reads up to 2", |f| {
        f.replace("\"kind_version\":2", "\"kind_version\":3");
    });
}
