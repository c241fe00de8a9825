//! Soft shadows of layered maps, by `lookup` and `render`.

use std::fmt::Write;
use std::fs;
use std::path::Path;
use std::sync::Arc;

use dsm_core::{Facing, LightVisibility, Rgb, ShadedPoint, Transmittance};
use dsm_io::Limits;
use dsm_io::detail::KindReader;
use dsm_scene::detail::SceneReference;
use dsm_scene::{TracedScene, open_scene};
use glam::DVec3;
use serde_json::Value;
use shadow_maps::detail::{FragmentMap, FragmentTracer, Fragments};

use crate::layers::{lights, points, scene};
use crate::maps::Folder;
use crate::run;

/// Points of a grid of 8 × 8 around `centre`, as CSV too.
fn grid(centre: DVec3, spread: f64) -> (String, Vec<DVec3>) {
    let at = |index: u32| (f64::from(index) / 3.5 - 1.0) * spread;
    let points: Vec<_> =
        (0..64).map(|index| centre + DVec3::new(at(index % 8), 0.0, at(index / 8))).collect();
    let mut text = "x,y,z\n".to_owned();
    points.iter().for_each(|point| writeln!(text, "{},{},{}", point.x, point.y, point.z).unwrap());
    (text, points)
}

fn statistics(answer: &run::Answer) -> Value {
    serde_json::from_str(&answer.stderr).unwrap()
}

#[test]
fn leaves_are_traced_with_the_far_table_that_their_map_and_light_allow() {
    let folder = Folder::new();
    let map = folder.path("map.dsm");
    run!(
        "bake",
        "builtin:foliage",
        "-o",
        map,
        "--kind",
        "fragments",
        "--resolution",
        "128",
        "--quiet"
    )
    .stdout();
    let (text, points) = grid(DVec3::ZERO, 1.0);
    let file = folder.write("p.csv", &text);
    let answer = run!("lookup", map, "--points", file, "--stats");
    assert_eq!(statistics(&answer)["far_table"], true);
    let answer = lights(&answer.stdout);
    let reader = KindReader::<Fragments>::open(&map, &Limits::default()).unwrap();
    let fragments = FragmentMap::<f32>::read(&reader).unwrap();
    let light = fragments.frame().area_light(reader.metadata().info.light.unwrap());
    let shaded = |(seed, &position)| ShadedPoint { position, facing: Facing::Light, seed };
    let shaded: Vec<_> = (0..).zip(&points).map(shaded).collect();
    let exact = FragmentTracer::new(fragments.clone()).unwrap();
    let far = FragmentTracer::new(fragments.clone()).unwrap().for_light(&light);
    let [exact, far] = [exact, far].map(|tracer| {
        let mut values = Vec::new();
        let Ok(()) = tracer.visibilities(&shaded, &light, &mut values);
        values
    });
    let close = |a: &[f64], b: &[f32]| a.iter().zip(b).all(|(a, b)| (*a as f32 - b).abs() < 1e-6);
    assert!(close(&answer, &far) && !close(&answer, &exact));
    // Neither the number of points nor that of rays has a say in it.
    let first: String = text.lines().take(2).map(|line| format!("{line}\n")).collect();
    let one = run!("lookup", map, "--points", folder.write("one.csv", first)).stdout();
    assert_eq!(lights(&one), answer[..1]);
    let few = run!("lookup", map, "--points", file, "--rays", "8", "--stats");
    assert_eq!(statistics(&few)["far_table"], true);
    // Pictures are drawn by the same rays.
    let image = folder.path("image.png");
    let base = ["render", "builtin:foliage", "-o", image.to_str().unwrap(), "--factor", "--quiet"];
    let more = ["--method", "trace", "--samples", "1", "--resolution", "24"];
    let given = ["--map", map.to_str().unwrap()];
    run::run(base.iter().chain(&more).chain(&given)).stdout();
    let tracer = || FragmentTracer::new(fragments.clone()).unwrap();
    let exact = draw(&tracer().with_rays(16));
    let far = draw(&tracer().for_light(&light).with_rays(16));
    let drawn = fs::read(image).unwrap();
    assert!(drawn == far && drawn != exact);
}

/// The foliage with these shadows, as `render` writes it.
fn draw(shadow: &FragmentTracer<f32>) -> Vec<u8> {
    let scene = open_scene(Path::new("builtin:foliage")).unwrap();
    let traced = Arc::new(TracedScene::new(&scene).unwrap());
    let mut settings = dsm_scene::detail::RenderSettings::new(1, 0).unwrap();
    settings.factor = true;
    let camera = scene.camera.raster([24; 2]).unwrap();
    let light = scene.light.area().unwrap();
    let renderer = dsm_scene::detail::Renderer::new(Arc::clone(&traced), camera, light, settings);
    let go_on = |_| std::ops::ControlFlow::Continue(());
    let Ok(Some(image)) = renderer.render(shadow, go_on) else { panic!("it was not interrupted") };
    image.to_png().unwrap()
}

#[test]
fn what_is_baked_for_a_picture_is_what_comes_closest() {
    let folder = Folder::new();
    let scene = scene(&folder, "0.75");
    let image = folder.path("image.exr");
    let draw = |what: &str, more: &[&str]| {
        let base = ["render", what, "-o", image.to_str().unwrap(), "--quiet", "--factor"];
        let few = ["--method", "trace", "--samples", "2", "--resolution", "24"];
        run::run(base.iter().chain(&few).chain(more)).stdout();
        fs::read(&image).unwrap()
    };
    let bake = |what: &str, kind: &str| {
        let map = folder.path(&format!("{kind}.dsm"));
        run!("bake", what, "-o", map, "--kind", kind, "--quiet").stdout();
        map.to_str().unwrap().to_owned()
    };
    let panes = scene.to_str().unwrap();
    let (fragments, runs) = (bake(panes, "fragments"), bake(panes, "mtsm"));
    let [of_fragments, of_runs] = [fragments, runs].map(|map| draw(panes, &["--map", &map]));
    assert_ne!(of_fragments, of_runs);
    assert_eq!(draw(panes, &[]), of_fragments);
    assert_eq!(draw(panes, &["--rule", "ratio"]), of_runs);
    // With media beside them.
    let smoke = bake("builtin:smoke", "fragments");
    assert_eq!(draw("builtin:smoke", &[]), draw("builtin:smoke", &["--map", &smoke]));
}

#[test]
fn smoke_is_traced_as_rays_through_the_scene_find_it() {
    let folder = Folder::new();
    let (map, truth, image) = (folder.path("m.dsm"), folder.path("t.exr"), folder.path("i.exr"));
    let smoke = "builtin:smoke";
    let told =
        run!("bake", smoke, "-o", map, "--kind", "fragments", "--resolution", "256").stdout();
    assert!(told.contains("mono, tolerance 0.005, "), "{told}");
    run!("verify", map).stdout();
    let told = run!("inspect", map, "--json", "--pixel", "128,128").json();
    assert_eq!(told["media"]["max_slabs"], 256);
    let slabs = |name: &str| told["contents"][name].as_u64().unwrap();
    assert!(slabs("slabs") > 4 * slabs("pixels_with_media"), "{}", told["contents"]);
    let stated = told["levels"][0]["max_error"].as_f64().unwrap();
    assert!(stated > 0.002 && stated <= 0.005, "{stated}");
    assert!(told["fragments"].as_array().unwrap().iter().any(|row| row[0] != row[1]), "{told}");
    let draw = |image: &Path, more: &[&str]| {
        let base = ["render", smoke, "-o", image.to_str().unwrap(), "--factor", "--resolution"];
        let few = ["48", "--samples", "4", "--rays", "64", "--method"];
        run::run(base.iter().chain(&few).chain(more))
    };
    draw(&truth, &["reference"]).stdout();
    let rmse = |kind: &str| {
        let of_kind = folder.path("k.dsm");
        run!("bake", smoke, "-o", of_kind, "--kind", kind, "--resolution", "256").stdout();
        let (map, truth) = (of_kind.to_str().unwrap(), truth.to_str().unwrap());
        let told = draw(&image, &["trace", "--map", map, "--compare", truth, "--json"]).json();
        told["compare"]["rmse"].as_f64().unwrap()
    };
    // The rays of both go to the same points of the light.
    let [fragments, runs] = ["fragments", "mtsm"].map(rmse);
    assert!(fragments < 0.004 && fragments < runs, "{fragments} {runs}");
    // A larger tolerance is kept, too, in less room.
    let coarse = folder.path("c.dsm");
    run!(
        "bake",
        smoke,
        "-o",
        coarse,
        "--kind",
        "fragments",
        "--resolution",
        "256",
        "--tolerance",
        "0.1"
    )
    .stdout();
    let told = run!("inspect", coarse, "--json").json();
    assert!(2 * told["contents"]["slabs"].as_u64().unwrap() < slabs("slabs"));
    let stated = told["levels"][0]["max_error"].as_f64().unwrap();
    assert!(stated > 0.02 && stated <= 0.1, "{stated}");
}

#[test]
fn the_rules_of_the_paper_have_switches() {
    let folder = Folder::new();
    let half = scene(&folder, "0.5");
    // A second pane of a half, below the first, and a floor farther down.
    let text = fs::read_to_string(&half).unwrap();
    let text = text.replace(
        "transform = { scale = 5.0 }",
        "opacity = 0.5\ntransform = { translate = [0, 1, 0], scale = 5.0 }\n\n\
         [[object]]\nmesh = \"pane.obj\"\ntransform = { translate = [0, -1, 0], scale = 9.0 }",
    );
    let scene = folder.write("panes.toml", text);
    // The pixel where its ray to the light meets the lower pane does not show
    // the upper one; the first pane's does. Then one between both, and one
    // right above the upper.
    let points = folder.write("p.csv", "x,y,z\n0.81,0,0\n0,0,0\n0,1.5,0\n0,2.05,0\n");
    for kind in ["mtsm", "layers"] {
        let map = folder.path("map.dsm");
        let base = ["bake", scene.to_str().unwrap(), "-o", map.to_str().unwrap(), "--quiet"];
        run::run(base.iter().chain(&["--kind", kind])).stdout();
        let ask = |more: &[&str]| {
            let base = ["lookup", map.to_str().unwrap(), "--points", points.to_str().unwrap()];
            let point = ["--light-size", "0", "--rays", "1"];
            lights(&run::run(base.iter().chain(&point).chain(more)).stdout())
        };
        assert_eq!(ask(&[]), [0.25, 0.25, 0.5, 1.0], "{kind}");
        assert_eq!(ask(&["--rule", "ratio", "--z-threshold", "0"]), ask(&[]), "{kind}");
        // Equation 3: a half and a half.
        assert_eq!(ask(&["--rule", "subtract"]), [0.0, 0.25, 0.5, 1.0], "{kind}");
        // §6.1: the upper pane reaches up to the point above it, which then has
        // to start farther away.
        let thick = ["--z-threshold", "0.1"];
        let near = ask(&[thick[0], thick[1], "--bias", "0"]);
        assert_eq!(near[1..], [0.25, 0.5, 0.5], "{kind}");
        assert_eq!(ask(&thick)[1..], [0.25, 0.5, 1.0], "{kind}");
        // A layer that reaches far is met in more than one pixel.
        assert!(near[0] < 0.25, "{kind:?} {near:?}");
        let image = folder.path("i.exr");
        let draw = |rule: &str| {
            run!(
                "render",
                scene,
                "-o",
                image,
                "--map",
                map,
                "--method",
                "trace",
                "--rule",
                rule,
                "--samples",
                "2",
                "--quiet"
            )
            .stdout();
            fs::read(&image).unwrap()
        };
        assert!(draw("ratio") != draw("subtract"));
    }
}

#[test]
fn rules_go_with_traced_layers_alone() {
    let folder = Folder::new();
    let (scene, points, map) = (scene(&folder, "0.75"), points(&folder), folder.path("f.dsm"));
    let image = folder.path("i.exr");
    run!("bake", scene, "-o", map, "--kind", "fragments", "--resolution", "16", "--quiet").stdout();
    for switch in [["--rule", "ratio"], ["--z-threshold", "0"]] {
        let [name, value] = switch;
        let refused = run!("lookup", map, "--points", points, name, value);
        assert!(refused.refusal().contains("f.dsm: fragments have planes"), "{refused:?}");
        let refused =
            run!("render", scene, "-o", image, "--method", "trace", "--map", map, name, value);
        assert!(refused.refusal().contains("f.dsm: fragments have planes"), "{refused:?}");
        for method in ["pcf", "filter"] {
            run!("lookup", map, "--points", points, "--method", method, name, value)
                .is_wrong_usage("for --method trace");
            run!("render", scene, "-o", image, "--method", method, name, value)
                .is_wrong_usage("for --method trace");
        }
    }
    let refused = run!("lookup", map, "--points", points, "--bias", "-1");
    assert!(refused.refusal().contains("a ray offset is not negative"), "{refused:?}");
    run!("lookup", map, "--points", points, "--z-threshold", "-1").is_wrong_usage("negative");
    run!("lookup", map, "--points", points, "--rule", "add").is_wrong_usage("--rule");
    let deep = folder.path("deep.dsm");
    run!("bake", scene, "-o", deep, "--resolution", "16", "--quiet").stdout();
    let refused = run!("lookup", deep, "--points", points, "--rule", "ratio");
    assert!(refused.refusal().contains("--rule and --z-threshold are for --method trace"));
}

#[test]
fn single_layers_are_traced_and_filtered() {
    let folder = Folder::new();
    let scene = scene(&folder, "0.75");
    // In the pane's shadow and below the floor; below the floor beside it.
    let points = folder.write("p.csv", "x,y,z\n0,0.5,0\n0,-0.5,0\n2,-0.5,0\n");
    for kind in ["mtsm", "layers", "fragments"] {
        let map = folder.path("map.dsm");
        let base = ["bake", scene.to_str().unwrap(), "-o", map.to_str().unwrap(), "--kind", kind];
        let few = ["--resolution", "96", "--layers", "1"];
        let told = run::run(base.iter().chain(&few)).stdout();
        assert!(told.contains("pixels have more layers than --layers keeps"), "{told}");
        let methods: &[&str] = if kind == "fragments" { &["trace"] } else { &["trace", "pcf"] };
        for method in methods {
            let answer = run!("lookup", map, "--points", points, "--method", method).stdout();
            // The pane hides the floor behind it; of fragments one stands for both,
            // where the farther is.
            let expected = if kind == "fragments" { [1.0, 0.0, 0.0] } else { [0.25, 0.25, 0.0] };
            assert_eq!(lights(&answer), expected, "{kind} {method}");
        }
    }
}

#[test]
fn odd_points_and_lights_have_answers() {
    let folder = Folder::new();
    let small = scene(&folder, "0.75");
    let text = fs::read_to_string(&small).unwrap();
    let large = folder.write("large.toml", text.replace("[1.0, 0.5]", "[100.0, 100.0]"));
    // At the light, beside it, behind it, nowhere; then in the shadow.
    let points = folder.write(
        "p.csv",
        "x,y,z\n0,5,0\n0.3,5,0.1\n0,4.9999999,0\n0,9,0\n0,100,0\nnan,0,0\n0,nan,nan\ninf,0,0\n\
         1e300,0,0\n0,-1e300,0\n0.01,0.5,0.01\n0.01,-0.5,0.01\n",
    );
    for kind in ["mtsm", "layers", "fragments"] {
        let methods: &[&str] = if kind == "fragments" { &["trace"] } else { &["trace", "pcf"] };
        for (scene, method) in
            [&small, &large].into_iter().flat_map(|scene| methods.iter().map(move |of| (scene, of)))
        {
            let map = folder.path("map.dsm");
            let base =
                ["bake", scene.to_str().unwrap(), "-o", map.to_str().unwrap(), "--kind", kind];
            let few = ["--resolution", "32", "--quiet"];
            run::run(base.iter().chain(&few)).stdout();
            for light in [None, Some("0"), Some("1000"), Some("1e30"), Some("3.4e38")] {
                let size = light.map(|size| ["--light-size", size]);
                let base = ["lookup", map.to_str().unwrap(), "--points", points.to_str().unwrap()];
                let few = ["--rays", "16", "--method", method];
                let arguments = base.iter().chain(&few).chain(size.iter().flatten());
                let answer = lights(&run::run(arguments).warned("(NaN)"));
                let name = format!("{kind} {method} {light:?}: {answer:?}");
                assert_eq!(answer.len(), 12, "{name}");
                assert!(answer.iter().all(|light| (0.0..=1.0).contains(light)), "{name}");
                assert!(answer[..9].iter().all(|&light| light == 1.0), "{name}");
                if scene == &small && light.is_none_or(|size| size == "0") {
                    assert_eq!(answer[10..], [0.25, 0.0], "{name}");
                }
            }
        }
    }
}

#[test]
fn panes_of_glass_colour_the_light_of_every_kind_of_map() {
    let folder = Folder::new();
    let map = folder.path("map.dsm");
    let scene = open_scene(Path::new("builtin:stained-glass")).unwrap();
    let (text, points) = grid(DVec3::new(0.0, 0.02, 1.3), 1.2);
    let file = folder.write("p.csv", text);
    let traced = Arc::new(TracedScene::new(&scene).unwrap());
    let reference = SceneReference::<Rgb>::new(Arc::clone(&traced)).with_rays(256);
    let light = scene.light.area().unwrap();
    let truth: Vec<Rgb> = (0..)
        .zip(&points)
        .map(|(seed, &point)| {
            let Ok(light) = reference.visibility(point, &light, seed);
            light
        })
        .collect();
    let is_coloured = |light: &&Rgb| !Transmittance::is_mono(**light);
    let coloured = truth.iter().filter(is_coloured).count();
    assert!(coloured > 16, "{coloured} {truth:?}");
    for (kind, most) in [("fragments", 0.01), ("layers", 0.08), ("mtsm", 0.08)] {
        let base = ["bake", "builtin:stained-glass", "-o", map.to_str().unwrap(), "--kind", kind];
        let few = ["--resolution", "256", "--quiet"];
        run::run(base.iter().chain(&few)).stdout();
        run!("verify", map).stdout();
        assert_eq!(run!("inspect", map, "--json").json()["channels"], 3);
        let answer = run!("lookup", map, "--points", file).stdout();
        let mut lines = answer.lines();
        assert_eq!(lines.next(), Some("r,g,b"));
        let mut squares = [0.0; 3];
        for (line, truth) in lines.zip(&truth) {
            for (channel, number) in line.split(',').enumerate() {
                let off = number.parse::<f64>().unwrap() - f64::from(truth.channel(channel));
                squares[channel] += off * off / points.len() as f64;
            }
        }
        let errors = squares.map(f64::sqrt);
        assert!(errors.iter().all(|&error| error < most), "{kind}: {errors:?}");
    }
}
