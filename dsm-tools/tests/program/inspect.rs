//! `inspect`.

use std::io::Cursor;

use dsm_core::{MapInfo, Transmittance};
use serde_json::{Value, json};

use crate::maps::{Folder, full_info, mono, rgb};
use crate::run;

fn keys(value: &Value) -> Vec<&str> {
    value.as_object().unwrap().keys().map(String::as_str).collect()
}

#[test]
fn json_says_everything() {
    let folder = Folder::new();
    let path = folder.map("map.dsm", &rgb(full_info()));
    let told = run!("inspect", path, "--json").json();
    assert_eq!(
        keys(&told),
        [
            "attributes",
            "block",
            "camera",
            "channels",
            "codec",
            "contents",
            "data_window",
            "depth",
            "display_window",
            "filter",
            "height",
            "kind",
            "levels",
            "light",
            "samples",
            "software",
            "tile",
            "tolerance",
            "width",
        ]
    );
    for (name, value) in [
        ("kind", json!("deep")),
        ("width", json!(7)),
        ("height", json!(5)),
        ("channels", json!(3)),
        ("codec", json!("exact")),
        ("block", json!("zstd")),
        ("tile", json!(4)),
        ("tolerance", json!(0.02)),
        ("samples", json!(16)),
        ("filter", json!({"shape": "tent", "width": 2.0})),
        ("depth", json!({"kind": "planar", "min": 1.0, "max": 14.0})),
        ("light", json!(null)),
        ("attributes", json!({"owner": {"type": "string", "value": "lighting"}})),
    ] {
        assert_eq!(told[name], value, "{name}");
    }
    assert_eq!(keys(&told["camera"]), ["world_to_camera", "world_to_ndc"]);
    let [level] = &told["levels"].as_array().unwrap()[..] else { panic!("{told}") };
    assert_eq!(
        keys(level),
        [
            "bytes",
            "depth_error",
            "error_at_depth",
            "height",
            "max_error",
            "mean_error",
            "tolerance",
            "vertices",
            "width"
        ]
    );
    for (name, value) in [
        ("width", json!(7)),
        ("height", json!(5)),
        ("max_error", json!(0.01)),
        ("vertices", json!(90)),
    ] {
        assert_eq!(level[name], value, "{name}");
    }
    assert!(level["bytes"].as_u64().unwrap() > 0);
}

#[test]
fn what_is_unknown_is_null() {
    let folder = Folder::new();
    let clear = dsm_core::DeepMap::new(
        MapInfo::default(),
        dsm_core::detail::PixelLists::<f32>::clear(crate::maps::SIZE[0], crate::maps::SIZE[1]),
    );
    let path = folder.map("map.dsm", &clear);
    let told = run!("inspect", path, "--json").json();
    for name in ["samples", "filter", "camera", "light", "data_window", "display_window"] {
        assert_eq!(told[name], Value::Null, "{name}");
    }
    assert_eq!(told["depth"], json!({"kind": "planar", "min": null, "max": null}));
    assert_eq!(told["levels"][0]["vertices"], 0);
}

#[test]
fn a_pixel_is_a_list_of_vertices() {
    let folder = Folder::new();
    let path = folder.map("map.dsm", &mono(MapInfo::default()));
    let told = run!("inspect", path, "--json", "--pixel", "6,4").json();
    assert_eq!((&told["x"], &told["y"], &told["level"]), (&json!(6), &json!(4), &json!(0)));
    assert_eq!(told["vertices"], json!([[7.0, 1.0, 0.7], [14.0, 0.100000024, 0.100000024]]));
    let clear = run!("inspect", path, "--json", "--pixel", "4,4").json();
    assert_eq!(clear["vertices"], json!([]));
    let path = folder.map("map.dsm", &rgb(MapInfo::default()));
    let told = run!("inspect", path, "--json", "--pixel", "1,0").json();
    assert_eq!(told["vertices"][0], json!([2.0, [1.0, 1.0, 1.0], [0.7, 0.85, 0.97]]));
}

#[test]
fn text_is_for_people() {
    let folder = Folder::new();
    let path = folder.map("map.dsm", &mono(full_info()));
    let told = run!("inspect", path, "--pixel", "6,4").stdout();
    for text in [
        "7 × 5 pixels, 1 channel\n",
        "0.02",
        "16 a pixel",
        "tent",
        "1 to 14",
        "lighting",
        "pixel (6, 4)",
    ] {
        assert!(told.contains(text), "{text} in {told}");
    }
}

#[test]
fn plots_are_what_their_names_say() {
    let folder = Folder::new();
    let path = folder.map("map.dsm", &mono(MapInfo::default()));
    let [svg, png] = ["plot.svg", "plot.PNG"].map(|name| folder.path(name));
    run!("inspect", path, "--pixel", "6,4", "--plot", svg).stdout();
    let drawn = std::fs::read_to_string(svg).unwrap();
    assert!(drawn.starts_with("<svg") && drawn.contains("map.dsm, pixel (6, 4), 3 vertices"));
    run!("inspect", path, "--pixel", "6,4", "--plot", png).stdout();
    let file = std::fs::read(png).unwrap();
    let image = png::Decoder::new(Cursor::new(file)).read_info().unwrap();
    assert!(image.info().width > image.info().height);
    run!("inspect", path, "--plot", "a.svg").is_wrong_usage("--pixel");
    run!("inspect", path, "--pixel", "1,1", "--plot", "a.jpg").is_wrong_usage(".svg or .png");
}

/// The pixels of a PNG.
fn pixels(file: &std::path::Path) -> (png::ColorType, Vec<u8>) {
    let file = Cursor::new(std::fs::read(file).unwrap());
    let mut reader = png::Decoder::new(file).read_info().unwrap();
    let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
    let frame = reader.next_frame(&mut pixels).unwrap();
    (frame.color_type, pixels)
}

fn slices<T: Transmittance>(map: &dsm_core::DeepMap<T>, colour: png::ColorType, last: &[u8]) {
    let folder = Folder::new();
    let path = folder.map("map.dsm", map);
    let image = folder.path("slice.png");
    run!("inspect", path, "--slice", "inf", "--image", image).stdout();
    let (found, found_pixels) = pixels(&image);
    assert_eq!((found, found_pixels.len()), (colour, 35 * last.len()));
    // Pixel (0, 0) is clear, the last one has 0.1 of the light at least.
    assert!(found_pixels.starts_with(&[255]) && found_pixels.ends_with(last), "{found_pixels:?}");
    run!("inspect", path, "--slice", "0.5", "--image", image).stdout();
    assert!(pixels(&image).1.iter().all(|&code| code == 255));
    let image = folder.path("slice.exr");
    run!("inspect", path, "--slice", "inf", "--image", image).stdout();
    assert!(std::fs::read(image).unwrap().starts_with(&[0x76, 0x2f, 0x31, 0x01]));
}

#[test]
fn slices_show_the_light_at_a_depth() {
    slices(&mono(full_info()), png::ColorType::Grayscale, &[89]);
    slices(&rgb(full_info()), png::ColorType::Rgb, &[89, 196, 245]);
}

#[test]
fn slices_need_a_depth_and_an_image() {
    run!("inspect", "a.dsm", "--slice", "1").is_wrong_usage("--image");
    run!("inspect", "a.dsm", "--image", "a.png").is_wrong_usage("--slice");
    run!("inspect", "a.dsm", "--slice", "nan", "--image", "a.png").is_wrong_usage("number");
    run!("inspect", "a.dsm", "--slice", "1", "--image", "a.svg").is_wrong_usage(".png or .exr");
}

#[test]
fn refusals_say_why() {
    let folder = Folder::new();
    let path = folder.map("map.dsm", &mono(MapInfo::default()));
    let outside = run!("inspect", path, "--json", "--pixel", "7,0");
    assert!(outside.refusal().contains("pixel (7, 0) lies outside"), "{outside:?}");
    assert_eq!(outside.stdout, "");
    let nowhere = folder.path("no/slice.png");
    let unwritable = run!("inspect", path, "--slice", "1", "--image", nowhere);
    assert!(
        unwritable.refusal().contains("slice.png: cannot create a file beside it"),
        "{unwritable:?}"
    );
    let missing = run!("inspect", folder.path("no.dsm"));
    assert!(missing.refusal().contains("no.dsm: cannot open: No such file"), "{missing:?}");
    assert_eq!(missing.refusal().matches("No such file").count(), 1, "{missing:?}");
    run!("inspect", path, "--pixel", "1").is_wrong_usage("X,Y");
}
