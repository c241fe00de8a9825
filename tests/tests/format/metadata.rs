//! Metadata come back bit for bit.

use dsm_core::detail::PixelWindow;
use dsm_core::{Filter, FilterShape, LightExtent, MapInfo, ShadowCamera, Tolerance};
use dsm_io::{Attribute, Error, Metadata};
use dsm_testkit::config;
use glam::DMat4;
use proptest::collection::{btree_map, vec};
use proptest::prelude::*;

fn matrix() -> impl Strategy<Value = Option<DMat4>> {
    let numbers = any::<u64>().prop_map(f64::from_bits);
    let numbers = numbers.prop_filter("finite", |value| value.is_finite());
    prop::option::of(prop::array::uniform16(numbers).prop_map(|m| DMat4::from_cols_array(&m)))
}

fn window() -> impl Strategy<Value = Option<PixelWindow>> {
    let corners = any::<([i32; 2], [i32; 2])>();
    prop::option::of(corners.prop_map(|(a, b)| PixelWindow {
        min: [0, 1].map(|axis| a[axis].min(b[axis])),
        max: [0, 1].map(|axis| a[axis].max(b[axis])),
    }))
}

fn info() -> impl Strategy<Value = MapInfo> {
    let camera = prop::option::of((matrix(), matrix()));
    let tolerance = (0..1_f32.to_bits()).prop_map(f32::from_bits);
    let filter = prop::option::of(
        (2_f32.to_bits()..f32::INFINITY.to_bits())
            .prop_map(|width| Filter::new(FilterShape::Tent, f32::from_bits(width)).unwrap()),
    );
    // Headers keep a light's size in `f32`.
    let side = || (0..f32::INFINITY.to_bits()).prop_map(|bits| f64::from(f32::from_bits(bits)));
    let light = prop::option::of((side(), side()).prop_map(|(width, height)| {
        if width < height {
            LightExtent::sphere(width / 2.0)
        } else {
            LightExtent::rectangle([width, height])
        }
    }));
    (camera, tolerance, any::<Option<u32>>(), filter, window(), window(), light).prop_map(
        |(camera, tolerance, samples, filter, data_window, display_window, light)| {
            let mut info = MapInfo::new().with_tolerance(Tolerance::new(tolerance).unwrap());
            info.camera = camera.map(|(world_to_camera, world_to_ndc)| ShadowCamera {
                world_to_camera,
                world_to_ndc,
            });
            (info.samples, info.filter) = (samples, filter);
            (info.data_window, info.display_window) = (data_window, display_window);
            info.light = light;
            info
        },
    )
}

fn attribute() -> impl Strategy<Value = Attribute> {
    let known = [
        ("string", 3),
        ("int", 4),
        ("float", 4),
        ("double", 8),
        ("v2i", 8),
        ("v3f", 12),
        ("box2i", 16),
        ("m33f", 36),
        ("m44f", 64),
        ("m44d", 128),
        ("chromaticities", 32),
        ("preview", 5),
    ];
    let fitting = prop::sample::select(known.to_vec())
        .prop_flat_map(|(name, length)| (Just(name), vec(any::<u8>(), length)));
    let text = any::<String>().prop_map(|text| ("string", text.into_bytes()));
    let other = ("[a-z2-4]{1,8}", vec(any::<u8>(), 0..20));
    prop_oneof![
        fitting.prop_map(|(name, bytes)| Attribute::new(name, bytes)),
        text.prop_map(|(name, bytes)| Attribute::new(name, bytes)),
        other.prop_map(|(name, bytes)| Attribute::new(name, bytes)),
    ]
}

fn matrix_bits(info: &MapInfo) -> Vec<[u64; 16]> {
    let camera = info.camera.unwrap_or_default();
    [camera.world_to_camera, camera.world_to_ndc]
        .into_iter()
        .flatten()
        .map(|matrix| matrix.to_cols_array().map(f64::to_bits))
        .collect()
}

proptest! {
    #![proptest_config(config(0x0d5_f11e))]

    #[test]
    fn everything_comes_back(
        (width, height) in (1..=i32::MAX as u32, 1..=i32::MAX as u32),
        info in info(),
        software in any::<String>(),
        attributes in btree_map(any::<String>(), attribute(), 0..5),
    ) {
        let mut metadata = Metadata::new(width, height, 3, info);
        metadata.software = software;
        metadata.attributes = attributes;
        let json = metadata.to_json().unwrap();
        let read = Metadata::from_json(&json).unwrap();
        prop_assert_eq!(matrix_bits(&read.info), matrix_bits(&metadata.info));
        prop_assert_eq!(
            read.info.tolerance.epsilon().to_bits(),
            metadata.info.tolerance.epsilon().to_bits()
        );
        prop_assert_eq!(&read, &metadata);
        prop_assert_eq!(read.to_json().unwrap(), json);
    }
}

fn json_of(attribute: Attribute) -> String {
    let mut metadata = Metadata::new(1, 1, 1, MapInfo::default());
    metadata.attributes.insert("a".to_owned(), attribute);
    let json = String::from_utf8(metadata.to_json().unwrap()).unwrap();
    let start = json.find("{\"a\":").unwrap() + 5;
    json[start..].trim_end_matches('}').to_owned() + "}"
}

#[test]
fn simple_attributes_are_readable() {
    for (attribute, json) in [
        (Attribute::string("rim\n"), r#"{"type":"string","value":"rim\n"}"#),
        (Attribute::new("int", (-7_i32).to_le_bytes()), r#"{"type":"int","value":-7}"#),
        (Attribute::new("float", 0.1_f32.to_le_bytes()), r#"{"type":"float","value":0.1}"#),
        (Attribute::new("float", (-0.0_f32).to_le_bytes()), r#"{"type":"float","value":-0.0}"#),
        (Attribute::new("v2i", [1, 0, 0, 0, 2, 0, 0, 0]), r#"{"type":"v2i","value":[1,2]}"#),
        (Attribute::new("float", f32::NAN.to_le_bytes()), r#"{"type":"float","hex":"0000c07f"}"#),
        (Attribute::new("string", [0xff]), r#"{"type":"string","hex":"ff"}"#),
        (Attribute::new("int", [1]), r#"{"type":"int","hex":"01"}"#),
        (Attribute::new("preview", [0, 0xab]), r#"{"type":"preview","hex":"00ab"}"#),
    ] {
        assert_eq!(json_of(attribute), json);
    }
}

#[test]
fn wrong_attributes_are_refused() {
    let metadata = |attribute: &str| {
        format!(
            r#"{{"kind":"deep","width":1,"height":1,"channels":1,"depth_kind":"planar",
            "tolerance":0.0,"attributes":{{"a":{attribute}}}}}"#
        )
    };
    assert!(Metadata::from_json(metadata(r#"{"type":"int","value":7}"#).as_bytes()).is_ok());
    for wrong in [
        r#"{"type":"int","value":7.5}"#,
        r#"{"type":"int","value":3000000000}"#,
        r#"{"type":"int"}"#,
        r#"{"type":"int","value":7,"hex":"07000000"}"#,
        r#"{"type":"v2i","value":[1]}"#,
        r#"{"type":"v2i","value":1}"#,
        r#"{"type":"string","value":1}"#,
        r#"{"type":"preview","value":1}"#,
        r#"{"type":"preview","hex":"0"}"#,
        r#"{"type":"preview","hex":"0g"}"#,
        r#"{"type":"preview","hex":"+1"}"#,
    ] {
        let read = Metadata::from_json(metadata(wrong).as_bytes());
        assert!(matches!(read, Err(Error::Metadata(_) | Error::Json(_))), "{wrong}");
    }
}

#[test]
fn unknown_keys_are_skipped() {
    let json = r#"{"new":{"x":[1]},"kind":"deep","width":2,"height":1,"channels":1,
        "depth_kind":"planar","tolerance":0.5}"#;
    let metadata = Metadata::from_json(json.as_bytes()).unwrap();
    assert_eq!((metadata.width, metadata.info.tolerance.epsilon()), (2, 0.5));
}

#[test]
fn what_json_cannot_say_is_refused() {
    let camera = ShadowCamera { world_to_camera: Some(DMat4::NAN), world_to_ndc: None };
    let info = MapInfo::new().with_camera(camera);
    assert!(Metadata::new(1, 1, 1, info).to_json().is_err());
    assert!(Metadata::new(1, 1, 2, MapInfo::default()).to_json().is_err());
    assert!(Metadata::new(0, 1, 1, MapInfo::default()).to_json().is_err());
    let narrow = r#"{"kind":"deep","width":1,"height":1,"channels":1,"depth_kind":"planar",
        "tolerance":0.5,"filter":{"shape":"box","width":0.5}}"#;
    assert!(Metadata::from_json(narrow.as_bytes()).is_err());
}
