//! Deep maps that were written once stay readable.

use dsm_core::{Rgb, Transmittance};
use dsm_io::detail::AnyDeepMap;
use dsm_io::{Limits, MapReader, Packing};
use dsm_tests::golden;

use crate::damage::defects;
use crate::examples::{Example, coloured, document, mono};
use crate::round_trip::bits;

fn check<T: Transmittance>(name: &str, example: &Example<T>) -> Vec<u8> {
    let bytes = golden::file(name, || example.bytes());
    let reader = MapReader::from_bytes(bytes.clone(), &Limits::default()).unwrap();
    assert!(reader.verify().is_empty(), "{name}: {:?}", reader.verify());
    assert_eq!(reader.metadata(), &example.metadata, "{name}");
    assert_eq!(reader.container().version(), [1, 0], "{name}");
    assert_eq!(reader.levels()[0].error.max, example.error.max);
    let map = reader.read_map::<T>(0).unwrap();
    assert_eq!(bits(map.pixels().view()), bits(example.pixels.view()), "{name}");
    bytes
}

#[test]
fn files_of_version_1_0() {
    let plain = [
        (check("document.dsm", &document()), document().bytes()),
        (check("mono_plain.dsm", &mono(Packing::Plain)), mono(Packing::Plain).bytes()),
        (check("rgb_plain.dsm", &coloured(Packing::Plain)), coloured(Packing::Plain).bytes()),
    ];
    for (golden, now) in plain {
        assert!(golden == now, "the writer writes other bytes than before");
    }
    // Another version of zstd may pack otherwise.
    check("mono_zstd.dsm", &mono(Packing::Zstd));
    check("rgb_zstd.dsm", &coloured(Packing::Zstd));
}

#[test]
fn packed_golden_files_are_packed() {
    for name in ["mono_zstd.dsm", "rgb_zstd.dsm"] {
        let reader = MapReader::open(golden::folder().join(name), &Limits::default()).unwrap();
        let entries: Vec<_> =
            reader.directory(0).unwrap().iter().map(|(_, entry)| *entry).collect();
        assert!(entries.iter().filter(|entry| !entry.is_empty()).count() > 3);
        assert!(entries.iter().any(|entry| entry.block == 1));
        // Steps store the depths as differences.
        assert!(entries.iter().any(|entry| entry.differences & 0b01000 != 0));
    }
}

#[test]
fn damaged_files_are_what_their_names_say() {
    for defect in defects() {
        let bytes = golden::file(&format!("damaged/{}.dsm", defect.name), || defect.bytes.clone());
        assert!(bytes == defect.bytes, "{}", defect.name);
    }
}

#[test]
fn any_deep_map_knows_its_channels() {
    let read = |name| {
        let reader = MapReader::open(golden::folder().join(name), &Limits::default()).unwrap();
        AnyDeepMap::read(&reader, 0).unwrap()
    };
    assert!(matches!(read("mono_plain.dsm"), AnyDeepMap::Mono(_)));
    let AnyDeepMap::Rgb(map) = read("rgb_zstd.dsm") else { panic!("not coloured") };
    assert_eq!(map.pixel(1, 1).last(), Rgb::from_channels(|c| (0.75 - 0.125 * c as f32).powi(2)));
}
