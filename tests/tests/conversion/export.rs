//! What an exported image keeps of its map, and what happens when it fails.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use dsm_core::detail::{PixelLists, PixelWindow};
use dsm_core::{DeepMap, MapInfo, Progress, Rgb, Tolerance};
use dsm_io::deep_exr::{
    self, AlphaChannels, ChannelType, Compression, DeepExrReader, Header, Layout, SampleType,
    Window,
};
use dsm_io::detail::compare;
use dsm_io::{
    AchievedError, Attribute, Error, ExportOptions, Limits, MapReader, MapSource, Metadata,
    WriteOptions, convert, export_deep_exr, write_map,
};

use super::{IMAGES, converted, image, open, options, z_turned};

/// The image that the documentation uses, seen from beside the others.
const WITH_CAMERA: &str = "../../../docs/sample/tuft.exr";

fn header(path: &Path) -> Header {
    DeepExrReader::open(path, None, &deep_exr::Limits::default()).unwrap().header().clone()
}

fn sorted(attributes: &[deep_exr::Attribute]) -> Vec<deep_exr::Attribute> {
    let mut attributes = attributes.to_vec();
    attributes.sort_by(|a, b| a.name.cmp(&b.name));
    attributes
}

/// Converts an image to a map, and that back.
fn there_and_back(name: &str, folder: &Path, export: &ExportOptions) -> PathBuf {
    let map = converted(&image(name), folder, &options(0.0, 4));
    let output = folder.join("back.exr");
    export_deep_exr(&mut open(&map), &output, export, Progress::ignore).unwrap();
    output
}

#[test]
fn windows_cameras_and_attributes_go_back_bit_for_bit() {
    let folder = tempfile::tempdir().unwrap();
    for name in IMAGES.into_iter().chain([WITH_CAMERA]) {
        let output = there_and_back(name, folder.path(), &ExportOptions::default());
        let (was, is) = (header(&image(name)), header(&output));
        assert_eq!(is.data_window, was.data_window, "{name}");
        assert_eq!(is.display_window, was.display_window, "{name}");
        let bits = |matrix: Option<[f32; 16]>| matrix.map(|numbers| numbers.map(f32::to_bits));
        // That image looks along −z, as this program once wrote.
        let is_older = name == WITH_CAMERA;
        let camera = was.world_to_camera.map(|m| if is_older { z_turned(m) } else { m });
        assert_eq!(bits(is.world_to_camera), bits(camera), "{name}");
        assert_eq!(bits(is.world_to_ndc), bits(was.world_to_ndc), "{name}");
        assert_eq!(is.pixel_aspect.to_bits(), was.pixel_aspect.to_bits());
        assert_eq!(is.screen_window_center, was.screen_window_center);
        assert_eq!(is.screen_window_width, was.screen_window_width);
        assert_eq!(is.part_name, Some(was.part_name.unwrap_or_else(|| "deep".to_owned())));
        let kept: Vec<_> = sorted(&was.attributes);
        let kept: Vec<_> = kept.into_iter().filter(|a| a.name != b"deepImageState").collect();
        assert_eq!(sorted(&is.attributes), kept, "{name}");
    }
    let compared = header(&image(WITH_CAMERA));
    assert!(compared.world_to_ndc.is_some() && compared.world_to_camera.is_some());
    assert!(!compared.attributes.is_empty());
}

#[test]
fn light_goes_there_and_back_in_every_form() {
    let folder = tempfile::tempdir().unwrap();
    for name in IMAGES {
        for layout in [Layout::ScanLines, Layout::Tiles { width: 4, height: 4 }] {
            for compression in [Compression::Zips, Compression::Rle, Compression::None] {
                let export = ExportOptions { layout, compression, ..ExportOptions::default() };
                let output = there_and_back(name, folder.path(), &export);
                let again = folder.path().join("again.dsm");
                convert(&mut open(&output), &again, &options(0.0, 5), Progress::ignore).unwrap();
                let map = folder.path().join("map.dsm");
                let difference =
                    compare(&mut open(&map), &mut open(&again), Progress::ignore).unwrap();
                assert!(difference.max() < 2e-6, "{name}: {difference:?}");
            }
        }
    }
}

#[test]
fn the_header_says_what_was_asked_for() {
    let folder = tempfile::tempdir().unwrap();
    for (compression, name) in
        [(Compression::Zips, "ZIPS"), (Compression::Rle, "RLE"), (Compression::None, "NONE")]
    {
        let layout = Layout::Tiles { width: 3, height: 3 };
        let export = ExportOptions {
            layout,
            compression,
            sample_type: SampleType::Half,
            ..ExportOptions::default()
        };
        let told = header(&there_and_back("scan_zips_half.exr", folder.path(), &export));
        assert_eq!(told.compression, name);
        assert_eq!(told.layout, Layout::Tiles { width: 3, height: 3 });
        let kinds = |kind| told.channels.iter().filter(|c| c.channel_type == kind).count();
        let halves = if told.alpha == AlphaChannels::Mono { 1 } else { 4 };
        assert_eq!((kinds(ChannelType::Half), kinds(ChannelType::Float)), (halves, 2));
        let names: Vec<_> = told.channels.iter().map(|channel| channel.name.as_str()).collect();
        assert!(names.contains(&"A") && names.contains(&"ZBack"), "{names:?}");
    }
}

/// Writes an empty map with these metadata, and exports it.
fn exported(metadata: Metadata, export: &ExportOptions, folder: &Path) -> (Header, Vec<String>) {
    let (input, output) = (folder.join("empty.dsm"), folder.join("empty.exr"));
    let pixels = PixelLists::<Rgb>::clear(metadata.width, metadata.height);
    let map = DeepMap::new(metadata.info, pixels);
    write_map(&input, metadata, &map, AchievedError::NONE, WriteOptions::default()).unwrap();
    let report = export_deep_exr(&mut open(&input), &output, export, Progress::ignore).unwrap();
    assert_eq!((report.samples, report.max_samples, report.achieved), (0, 0, 0.0));
    (header(&output), report.left_out)
}

#[test]
fn attributes_that_say_how_an_image_is_built_are_left_out() {
    let folder = tempfile::tempdir().unwrap();
    let mut metadata = Metadata::new(3, 2, 3, MapInfo::default());
    let long = "a name of more than thirty-one letters";
    metadata.attributes = BTreeMap::from(
        [
            ("channels", Attribute::string("nonsense")),
            ("deepImageState", Attribute::new("deepImageState", [0])),
            ("int of one byte", Attribute::new("int", [1])),
            ("kept", Attribute::new("preview", [1, 2, 3])),
            (long, Attribute::string("kept")),
            ("name", Attribute::string("shadow")),
            ("no\0name", Attribute::string("")),
            ("pixelAspectRatio", Attribute::new("float", 2_f32.to_le_bytes())),
            ("screenWindowWidth", Attribute::string("wide")),
            ("tiles", Attribute::new("tiledesc", [0; 9])),
            ("", Attribute::string("nameless")),
        ]
        .map(|(name, attribute)| (name.to_owned(), attribute)),
    );
    let (told, left_out) = exported(metadata.clone(), &ExportOptions::default(), folder.path());
    let expected = [
        "",
        "channels",
        "deepImageState",
        "int of one byte",
        "no\0name",
        "screenWindowWidth",
        "tiles",
    ];
    assert_eq!(left_out, expected);
    let names: Vec<_> = told.attributes.iter().map(deep_exr::Attribute::name_text).collect();
    assert_eq!(names, [long, "kept"]);
    assert_eq!((told.part_name.as_deref(), told.pixel_aspect), (Some("shadow"), 2.0));
    assert_eq!(told.layout, Layout::ScanLines);
    // On request the state is that of the samples, which are tidy.
    let tidy = ExportOptions { deep_image_state: true, ..ExportOptions::default() };
    let (told, _) = exported(metadata, &tidy, folder.path());
    let state = told.attributes.iter().find(|a| a.name == b"deepImageState").unwrap();
    assert_eq!(
        (state.type_name.as_slice(), state.value.as_slice()),
        (&b"deepImageState"[..], &[3][..])
    );
}

#[test]
fn windows_begin_at_0_where_the_map_knows_none() {
    let folder = tempfile::tempdir().unwrap();
    let window = Window { min: [0, 0], max: [2, 1] };
    let metadata = Metadata::new(3, 2, 3, MapInfo::new());
    let (told, _) = exported(metadata, &ExportOptions::default(), folder.path());
    assert_eq!((told.data_window, told.display_window), (window, window));
    // One that holds nothing is none of a map.
    let upside_down = PixelWindow { min: [4, 4], max: [2, 2] };
    let metadata = Metadata::new(3, 2, 3, MapInfo::new().with_display_window(upside_down));
    let map = DeepMap::new(metadata.info, PixelLists::<Rgb>::clear(3, 2));
    let path = folder.path().join("none.dsm");
    let refused = write_map(&path, metadata, &map, AchievedError::NONE, WriteOptions::default());
    assert!(refused.unwrap_err().to_string().contains("display window holds no pixel"));
}

#[test]
fn the_number_of_threads_changes_no_byte() {
    let folder = tempfile::tempdir().unwrap();
    let bytes = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let export = ExportOptions::default();
        fs::read(pool.install(|| there_and_back("scan_zips_half.exr", folder.path(), &export)))
            .unwrap()
    };
    assert_eq!(bytes(1), bytes(5));
}

#[test]
fn what_cannot_be_written_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let name = "scan_zips_half.exr";
    let map = converted(&image(name), folder.path(), &options(0.0, 4));
    let output = folder.path().join("out.exr");
    let refused = |input: &Path, options: &ExportOptions| {
        let error =
            export_deep_exr(&mut open(input), &output, options, Progress::ignore).unwrap_err();
        assert!(!output.exists());
        error.to_string()
    };
    let error = refused(&image(name), &ExportOptions::default());
    assert!(error.contains("make a .dsm of it first"), "{error}");
    let error = Tolerance::new(0.9e-6).unwrap();
    let error = refused(&map, &ExportOptions { error, ..ExportOptions::default() });
    assert!(error.contains("at least 1e-6"), "{error}");
    for size in [0, 4097] {
        let layout = Layout::Tiles { width: size, height: size };
        let error = refused(&map, &ExportOptions { layout, ..ExportOptions::default() });
        assert!(error.contains("1 to 4096"), "{error}");
    }
    let far = PixelWindow { min: [i32::MAX - 1, 0], max: [i32::MAX, 0] };
    let info = MapInfo::new().with_data_window(far);
    let pixels = DeepMap::new(info, PixelLists::<f32>::clear(2, 1));
    let metadata = Metadata::new(2, 1, 1, info);
    write_map(&map, metadata, &pixels, AchievedError::NONE, WriteOptions::default()).unwrap();
    let error = refused(&map, &ExportOptions::default());
    assert!(error.contains("2^30"), "{error}");
}

#[test]
fn a_map_that_breaks_off_leaves_the_old_image() {
    let folder = tempfile::tempdir().unwrap();
    let map = converted(&image("scan_zips_half.exr"), folder.path(), &options(0.0, 2));
    let mut bytes = fs::read(&map).unwrap();
    let reader = MapReader::open(&map, &Limits::default()).unwrap();
    let directory = reader.directory(0).unwrap();
    let last = directory.iter().filter(|(_, entry)| !entry.is_empty()).last().unwrap().1;
    bytes[last.offset as usize] ^= 1;
    fs::write(&map, bytes).unwrap();
    let output = folder.path().join("image.exr");
    fs::write(&output, b"the old one").unwrap();
    let mut done = 0;
    let failed = MapSource::open(&map, None, &Limits::default()).and_then(|mut source| {
        export_deep_exr(&mut source, &output, &ExportOptions::default(), |rows| {
            done = rows.done;
            Progress::ignore(rows)
        })
    });
    assert!(matches!(failed, Err(Error::File { .. })), "{failed:?}");
    assert!(done > 0, "it failed on the way");
    assert_eq!(fs::read(&output).unwrap(), b"the old one");
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 2, "no other file is left");
}
