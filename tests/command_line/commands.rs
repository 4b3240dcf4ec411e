//! The program as a user of the command line meets it: exit codes, files, figures.

use std::path::Path;
use std::process::Output;

use sunroom::layer::Layer;
use sunroom::render::image_io::ImageRgb;
use sunroom::render::image_io::exr::decode_exr;
use sunroom::render::layered_image::Attribute;
use sunroom::texture::load_image;

use crate::workshop::{Workshop, sunroom};

/// A floor under a square lamp, 40 x 30 pixels.
const SCENE: &str = r#"<scene version="3.0.0">
  <default name="spp" value="4"/>
  <integrator type="path"><integer name="max_depth" value="4"/></integrator>
  <sensor type="perspective">
    <transform name="to_world"><lookat origin="0, 2, 5" target="0, 0.5, 0" up="0, 1, 0"/></transform>
    <film type="hdrfilm"><integer name="width" value="40"/><integer name="height" value="30"/></film>
    <sampler type="independent"><integer name="sample_count" value="$spp"/></sampler>
  </sensor>
  <shape type="rectangle">
    <transform name="to_world"><scale value="4"/><rotate x="1" angle="-90"/></transform>
    <bsdf type="diffuse"><rgb name="reflectance" value="0.8, 0.4, 0.2"/></bsdf>
  </shape>
  <shape type="rectangle">
    <transform name="to_world"><rotate x="1" angle="90"/><translate y="2.5"/></transform>
    <emitter type="area"><rgb name="radiance" value="5, 5, 5"/></emitter>
  </shape>
</scene>
"#;

/// The end of a scene with a mirror, which makes photons.
const MIRROR: &str = r#"<shape type="sphere">
    <point name="center" x="0" y="0.6" z="0"/><float name="radius" value="0.6"/>
    <bsdf type="conductor"/>
  </shape>
</scene>"#;

fn render(scene: &Path, output: &Path, more: &[&str]) -> Output {
    let mut command = sunroom();
    command.arg("render").arg(scene).arg("-o").arg(output).args(more);
    command.output().expect("the program starts")
}

fn stderr(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

#[track_caller]
fn assert_code(output: &Output, code: i32) {
    assert_eq!(output.status.code(), Some(code), "{}", stderr(output));
}

fn image(path: &Path) -> ImageRgb {
    let bytes = std::fs::read(path).expect("the image is there");
    let image = load_image(&bytes).expect("the image can be read");
    let (width, height) = (image.width(), image.height());
    let row = |y| (0..width).map(move |x| (x, y));
    let pixels = (0..height).flat_map(row).map(|(x, y)| image.pixel(x, y)).collect();
    ImageRgb { width, height, pixels }
}

/// The figures of a render with these options.
fn figures(scene: &Path, output: &Path, more: &[&str]) -> serde_json::Value {
    let output = render(scene, output, &[&["--stats=json", "-q"], more].concat());
    assert_code(&output, 0);
    serde_json::from_slice(&output.stdout).expect("the figures")
}

#[test]
fn a_limit_of_noise_ends_a_render() {
    let shop = Workshop::new();
    let scene = shop.scene(SCENE);
    let picture = shop.path("a.exr");
    let run = |more: &[&str]| {
        let found = figures(&scene, &picture, more);
        let number = |name: &str| found[name].as_f64().expect(name);
        (number("spp"), number("noise"))
    };
    let (samples, noise) = run(&["--noise", "0.5%"]);
    assert!(samples > 20.0 && noise <= 0.005 && noise > 0.0035, "{samples} {noise}");
    // Whichever comes first.
    let (fewer, louder) = run(&["--noise", "0.005", "--spp", "20"]);
    assert!(fewer == 20.0 && louder > 0.005, "{fewer} {louder}");
    let said = |more: &[&str]| String::from_utf8_lossy(&render(&scene, &picture, more).stderr).into_owned();
    let text = said(&["--noise", "0.005", "--spp", "20"]);
    assert!(
        text.contains("the limit of noise 0.005 was not reached: the noise is 0.0"),
        "{text}"
    );
    let text = said(&["--noise", "0.5%"]);
    assert!(!text.contains("not reached"), "{text}");
    let (some, _) = run(&["--noise", "1e-6", "--time", "300ms"]);
    assert!(some > 0.0);
    // The file may say it; what is asked for takes its place.
    let text = SCENE.replace("</sampler>", "<float name='noise_target' value='0.1'/></sampler>");
    let limited = shop.scene(&text.replace("$spp", "100000"));
    let spp = |more: &[&str]| figures(&limited, &picture, more)["spp"].as_f64().expect("samples");
    assert!((16.0..samples).contains(&spp(&[])));
    assert_eq!(spp(&["--spp", "3"]), 3.0);
}

#[test]
fn renders_every_format() {
    let shop = Workshop::new();
    let scene = shop.scene(SCENE);
    for name in ["a.exr", "a.hdr", "a.png"] {
        let output = shop.path(name);
        assert_code(&render(&scene, &output, &["-q"]), 0);
        let image = image(&output);
        assert_eq!((image.width, image.height), (40, 30));
        let mean = image.pixels.iter().sum::<glam::Vec3>() / 1200.0;
        assert!(
            mean.x > 1.5 * mean.y && mean.y > 1.2 * mean.z && mean.z > 0.01,
            "{name}: {mean}"
        );
    }
}

#[test]
fn a_picture_on_standard_output_is_a_png() {
    let shop = Workshop::new();
    let output = render(&shop.scene(SCENE), Path::new("-"), &[]);
    assert_code(&output, 0);
    assert!(output.stdout.starts_with(b"\x89PNG\r\n"));
}

#[test]
fn figures_for_machines() {
    let shop = Workshop::new();
    let args = ["--stats=json", "--spp", "6", "-t", "2", "--seed", "9", "--denoise"];
    let output = render(&shop.scene(SCENE), &shop.path("a.exr"), &args);
    if !cfg!(feature = "denoise") {
        assert_code(&output, 1);
        assert!(stderr(&output).contains("denoise"));
        return;
    }
    assert_code(&output, 0);
    let stats: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON alone on standard output");
    assert_eq!(stats["width"], 40);
    assert_eq!(stats["spp"], 6);
    assert_eq!(stats["threads"], 2);
    assert_eq!(stats["seed"], 9);
    assert_eq!(stats["denoised"], true);
    for figure in [
        "load_ms",
        "render_ms",
        "denoise_ms",
        "rays",
        "mrays_per_s",
        "msamples_per_s",
    ] {
        assert!(stats[figure].as_f64() > Some(0.0), "{figure} in {stats}");
    }
    for figure in ["build_ms", "nodes", "leaves", "max_depth", "sah", "bytes"] {
        assert!(stats["bvh"][figure].as_f64() >= Some(0.0), "{figure} in {stats}");
    }
    let rays = stats["rays"].as_u64().expect("a count");
    assert!(rays >= 40 * 30 * 6, "at least the camera's: {rays}");
    // For people.
    for (spp, noise) in [("6", "noise 0."), ("1", "noise unknown")] {
        let args = ["--stats", "--spp", spp, "--seed", "9"];
        let output = render(&shop.scene(SCENE), &shop.path("b.exr"), &args);
        let text = String::from_utf8_lossy(&output.stdout);
        for words in ["seed 9", noise, "0 samples that were not finite"] {
            assert!(text.contains(words), "{words}: {text}");
        }
    }
}

#[test]
fn the_same_seed_gives_the_same_bits_on_any_number_of_threads() {
    let shop = Workshop::new();
    let bytes_of = |text: &str, name: &str, args: &[&str]| {
        let (scene, output) = (shop.scene(text), shop.path(name));
        assert_code(&render(&scene, &output, args), 0);
        std::fs::read(output).expect("written")
    };
    let bytes = |name: &str, args: &[&str]| bytes_of(SCENE, name, args);
    let one = bytes("1.exr", &["-t", "1", "--seed", "5", "--spp", "20"]);
    assert!(one == bytes("2.exr", &["-t", "4", "--seed", "5", "--spp", "20"]));
    assert!(one != bytes("3.exr", &["-t", "1", "--seed", "6", "--spp", "20"]));
    let mirrored = SCENE.replace("</scene>", MIRROR);
    for integrator in ["bdpt", "vcm", "ptracer"] {
        let args = |threads| ["-t", threads, "--spp", "20", "--integrator", integrator];
        let bytes = |name: &str, args: &[&str]| bytes_of(&mirrored, name, args);
        let one = bytes("1.exr", &args("1"));
        assert!(one == bytes("2.exr", &args("4")), "{integrator}");
        let until_noise = |threads| [&args(threads)[..], &["--noise", "0.1", "--adaptive"]].concat();
        assert!(
            bytes("1.exr", &until_noise("1")) == bytes("2.exr", &until_noise("3")),
            "{integrator}"
        );
    }
}

#[test]
fn layers_are_saved_in_exr_files() {
    let shop = Workshop::new();
    let scene = shop.scene(&SCENE.replace("y=\"2.5\"", "y=\"1\""));
    let read = |name: &str, args: &[&str]| {
        let output = shop.path(name);
        assert_code(&render(&scene, &output, args), 0);
        let bytes = std::fs::read(output).expect("written");
        (decode_exr(&bytes).expect("an EXR file"), bytes)
    };
    let (plain, _) = read("plain.exr", &["--spp", "8"]);
    assert_eq!(plain.layers(), [""]);
    let all: Vec<&str> = Layer::ALL
        .into_iter()
        .map(Layer::name)
        .filter(|name| *name != "denoised")
        .collect();
    let args = |threads| ["--spp", "8", "--aov", "depth", "-t", threads].map(str::to_owned);
    let list = all.join(",");
    let with_all = |threads| -> Vec<String> {
        args(threads)
            .into_iter()
            .chain(["--aov".to_owned(), list.clone()])
            .collect()
    };
    let [one, four] = ["1", "4"].map(|threads| {
        let args = with_all(threads);
        read(
            &format!("{threads}.exr"),
            &args.iter().map(String::as_str).collect::<Vec<_>>(),
        )
    });
    assert!(one.1 == four.1, "the number of threads does not matter");
    let image = one.0;
    assert_eq!(
        image.layer(""),
        plain.layer(""),
        "the same bits with and without layers"
    );
    let layers = image.layers();
    for name in [
        "Albedo",
        "Normal",
        "Depth",
        "Position",
        "UV",
        "Samples",
        "Direct",
        "CryptoObject00",
        "CryptoMaterial02",
    ] {
        assert!(layers.contains(&name), "{name} of {layers:?}");
    }
    assert!(layers.iter().any(|name| name.starts_with("LightGroup.")), "{layers:?}");
    assert!(image.alpha().is_some() && layers.contains(&""));
    assert!(
        image
            .layer("Samples")
            .expect("one channel")
            .pixels
            .iter()
            .all(|samples| samples.x == 8.0)
    );
    let light = ["Direct", "Indirect", "Emitted"].map(|name| image.layer(name).expect("a colour").pixels);
    for (place, whole) in plain.layer("").expect("the picture").pixels.iter().enumerate() {
        let sum = light[0][place] + light[1][place] + light[2][place];
        assert!(
            sum.abs_diff_eq(*whole, 1e-4 * (whole.max_element() + 0.1)),
            "{sum} {whole}"
        );
    }
    assert_eq!(image.attribute("sunroom:spp"), Some(&Attribute::Int(8)));
    let manifests = image.attributes.iter().filter(|(name, _)| name.ends_with("/manifest"));
    // The two rectangles have no id, and each has a material of its own.
    let counts = manifests.map(|(_, manifest)| match manifest {
        Attribute::Text(manifest) => manifest.matches("\":\"").count(),
        _ => 0,
    });
    assert_eq!(counts.collect::<Vec<_>>(), [2, 2]);
    // The camera looks at (0, 0.5, 0), which is in the middle of the picture, with x to the right.
    let row_times = |name: &str, point: [f32; 4]| -> [f32; 4] {
        let Some(Attribute::Matrix(matrix)) = image.attribute(name) else {
            panic!("no {name}")
        };
        std::array::from_fn(|column| (0..4).map(|row| point[row] * matrix[4 * row + column]).sum())
    };
    let [x, y, _, w] = row_times("worldToNDC", [0.0, 0.5, 0.0, 1.0]);
    assert!((x / w - 0.5).abs() < 1e-5 && (y / w - 0.5).abs() < 1e-5, "{x} {y} {w}");
    let [x, y, z, w] = row_times("worldToCamera", [1.0, 0.5, 0.0, 1.0]);
    let distance = (1.5f32 * 1.5 + 25.0).sqrt();
    assert!((x - 1.0).abs() < 1e-5 && y.abs() < 1e-5 && (z - distance).abs() < 1e-5 && w == 1.0);
}

#[test]
fn a_compression_that_would_damage_a_layer_is_refused_at_once() {
    let shop = Workshop::new();
    let scene = shop.scene(SCENE);
    for (layer, compression) in [("crypto-material", "pxr24"), ("normal", "dwaa"), ("samples", "dwab")] {
        let options = ["--aov", layer, "--compression", compression];
        // It would take for ever.
        let long = [&options[..], &["--spp", "1000000000"]].concat();
        let output = render(&scene, &shop.path("a.exr"), &long);
        assert_code(&output, 2);
        let text = String::from_utf8_lossy(&output.stderr);
        let expected = format!("`{layer}` would be damaged by the compression `{compression}`");
        assert!(text.contains(&expected), "{text}");
        assert!(!shop.path("a.exr").exists());
        // Other files have no layers to damage.
        assert_code(&render(&scene, &shop.path("a.png"), &options), 0);
    }
    let kept = ["--aov", "albedo,depth,uv,object-id", "--compression", "dwaa"];
    assert_code(&render(&scene, &shop.path("a.exr"), &kept), 0);
}

#[test]
fn layers_need_exr_files_and_known_names() {
    let shop = Workshop::new();
    let scene = shop.scene(SCENE);
    let output = render(&scene, &shop.path("a.png"), &["--aov", "depth"]);
    assert_code(&output, 0);
    let text = String::from_utf8_lossy(&output.stderr);
    assert!(text.contains("a.png has no layers: only EXR files have"), "{text}");
    // One message names all of them.
    let second = shop.path("b.hdr").display().to_string();
    let output = render(&scene, &shop.path("a.png"), &["-o", &second, "--aov", "depth"]);
    assert_code(&output, 0);
    let text = String::from_utf8_lossy(&output.stderr);
    assert_eq!(text.matches("only EXR files have").count(), 1, "{text}");
    assert!(text.contains("b.hdr have no layers"), "{text}");
    let output = render(&scene, &shop.path("a.exr"), &["--aov", "dept"]);
    assert_code(&output, 2);
    let text = String::from_utf8_lossy(&output.stderr);
    assert!(
        text.contains("there is no layer `dept`; the layers are alpha, albedo"),
        "{text}"
    );
    for empty in ["", "normal,,depth"] {
        let output = render(&scene, &shop.path("a.exr"), &["--aov", empty]);
        assert_code(&output, 2);
        let text = stderr(&output);
        assert!(text.contains("the name of a layer is empty; the layers are"), "{text}");
    }
}

#[test]
fn the_command_line_beats_the_file() {
    let shop = Workshop::new();
    let scene = shop.scene(SCENE);
    let output = render(
        &scene,
        &shop.path("a.exr"),
        &["-D", "spp=3", "--width", "20", "--stats=json"],
    );
    assert_code(&output, 0);
    let stats: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
    assert_eq!(
        (&stats["spp"], &stats["width"], &stats["height"]),
        (&3.into(), &20.into(), &15.into())
    );

    // Depth 1 shows emitters only, and the lamp faces away.
    assert_code(&render(&scene, &shop.path("b.exr"), &["--max-depth", "1"]), 0);
    assert!(
        image(&shop.path("b.exr"))
            .pixels
            .iter()
            .all(|&pixel| pixel == glam::Vec3::ZERO)
    );
}

#[test]
fn the_strategies_and_structures_give_one_picture() {
    let shop = Workshop::new();
    let scene = shop.scene(SCENE);
    let mean = |args: &[&str]| {
        let output = shop.path("a.exr");
        let args = [&["--spp", "256", "--sampler", "independent"], args].concat();
        assert_code(&render(&scene, &output, &args), 0);
        image(&output).pixels.iter().sum::<glam::Vec3>().element_sum()
    };
    let reference = mean(&[]);
    for strategy in ["bsdf", "light", "mis"] {
        let ratio = mean(&["--strategy", strategy]) / reference;
        assert!((ratio - 1.0).abs() < 0.02, "{strategy}: {ratio}");
    }
    for accel in ["linear", "median"] {
        let ratio = mean(&["--accel", accel]) / reference;
        // The same rays meet the same surfaces; only ties between equal distances may go another way.
        assert!((ratio - 1.0).abs() < 1e-4, "{accel}: {ratio}");
    }
}

#[test]
fn wrong_usage_is_2_and_wrong_files_are_1() {
    let shop = Workshop::new();
    let scene = shop.scene(SCENE);
    let missing_scene = sunroom().arg("render").output().expect("starts");
    assert_code(&missing_scene, 2);
    assert_code(&render(&scene, &shop.path("a.png"), &["--spp", "0"]), 2);
    assert_code(&render(&scene, &shop.path("a.png"), &["--time", "yesterday"]), 2);
    for noise in ["0", "-0.1", "quiet", "inf"] {
        assert_code(&render(&scene, &shop.path("a.png"), &["--noise", noise]), 2);
    }
    // What a negative number cannot be is said by the option itself.
    for (option, value, words) in [
        ("--noise", "-1%", "expected a noise above 0"),
        ("--time", "-5s", "expected a time above zero"),
        ("--frames", "-3", "expected a frame such as 17"),
        ("-s", "-4", "-4 is not in 1.."),
        ("--exposure", "-100.5", "expected a number of stops from -100 to 100"),
        ("--exposure", "5000", "expected a number of stops from -100 to 100"),
        ("--exposure", "nan", "expected a number of stops from -100 to 100"),
        ("--exposure", "inf", "expected a number of stops from -100 to 100"),
    ] {
        let refused = render(&scene, &shop.path("a.png"), &[option, value]);
        assert_code(&refused, 2);
        let said = stderr(&refused);
        assert!(
            said.contains(words) && !said.contains("tip:"),
            "{option} {value}: {said}"
        );
    }
    let options = ["--exposure", "-1", "--max-depth", "-1", "-t", "-1", "--spp", "1"];
    assert_code(&render(&scene, &shop.path("dark.png"), &options), 0);

    let no_format = render(&scene, &shop.path("a.docx"), &[]);
    assert_code(&no_format, 2);
    assert!(
        stderr(&no_format).contains("exr"),
        "names the formats: {}",
        stderr(&no_format)
    );
    let no_folder = render(&scene, &shop.path("nowhere/a.png"), &[]);
    assert_code(&no_folder, 1);
    assert!(stderr(&no_folder).contains("nowhere"));
    let no_scene = render(&shop.path("absent.xml"), &shop.path("a.png"), &[]);
    assert_code(&no_scene, 1);
    let expected = "absent.xml: no such file";
    assert!(stderr(&no_scene).contains(expected), "{}", stderr(&no_scene));
}

#[test]
fn what_cannot_be_is_refused_before_it_takes_all_memory() {
    let shop = Workshop::new();
    let (scene, out) = (shop.scene(SCENE), shop.path("out.png"));
    let output = render(&scene, &out, &["--size", "65536x65536"]);
    assert_code(&output, 2);
    assert!(
        stderr(&output).contains("65536 x 65536 pixels is too large"),
        "{}",
        stderr(&output)
    );
    let output = render(shop.folder(), &out, &[]);
    assert_code(&output, 1);
    assert!(stderr(&output).contains("is a folder"), "{}", stderr(&output));
    if cfg!(unix) {
        let output = render(Path::new("/dev/zero"), &out, &[]);
        assert_code(&output, 1);
        assert!(stderr(&output).contains("is a device"), "{}", stderr(&output));
    }
    assert!(!out.exists());
}

#[test]
fn a_broken_scene_is_reported_where_it_is_broken() {
    let shop = Workshop::new();
    let broken = SCENE.replace("value=\"0.8, 0.4, 0.2\"", "value=\"0.8, red, 0.2\"");
    let scene = shop.scene(&broken);
    for output in [
        render(&scene, &shop.path("a.png"), &[]),
        sunroom().arg("check").arg(&scene).output().expect("starts"),
    ] {
        assert_code(&output, 1);
        let text = stderr(&output);
        assert!(text.contains("scene.xml:11:") && text.contains("red"), "{text}");
    }
    assert!(!shop.path("a.png").exists());
}

#[test]
fn warnings_are_errors_when_strict() {
    let shop = Workshop::new();
    let scene = shop.scene(&SCENE.replace("<integer name=\"max_depth\"", "<integer name=\"max_dept\""));
    let check = |more: &[&str]| sunroom().arg("check").arg(&scene).args(more).output().expect("starts");
    let lenient = check(&[]);
    assert_code(&lenient, 0);
    let text = stderr(&lenient);
    assert!(text.contains("max_dept") && text.contains("max_depth"), "{text}");
    let strict = check(&["--strict"]);
    assert_code(&strict, 1);
    assert!(
        stderr(&strict).contains("scene.xml: refused for its warnings"),
        "{}",
        stderr(&strict)
    );
    let rendered = render(&scene, &shop.path("a.png"), &["--strict"]);
    let mut command = sunroom();
    command
        .arg("convert")
        .arg("--strict")
        .arg(&scene)
        .arg(shop.path("copy.xml"));
    for output in [rendered, command.output().expect("starts")] {
        assert_code(&output, 1);
        let said = stderr(&output);
        assert!(said.ends_with("scene.xml: refused for its warnings\n"), "{said}");
    }
    assert_code(&render(&scene, &shop.path("a.png"), &[]), 0);
}

#[test]
fn several_scenes_are_checked_and_each_has_its_line() {
    let shop = Workshop::new();
    let good = shop.scene(SCENE);
    let broken = shop.path("broken.xml");
    std::fs::write(&broken, SCENE.replace("value=\"4\"", "value=\"four\"")).expect("can be written");
    let check = |scenes: &[&Path]| sunroom().arg("check").args(scenes).output().expect("starts");
    let line = format!("{}: no errors, 2 shapes, 1 light\n", good.display());
    let output = check(&[&good, &good]);
    assert_code(&output, 0);
    assert_eq!(stderr(&output), line.repeat(2));
    let output = check(&[&broken, &good]);
    assert_code(&output, 1);
    let text = stderr(&output);
    assert!(text.contains("broken.xml:") && text.ends_with(&line), "{text}");
    assert_code(&check(&[]), 2);
}

#[test]
fn check_says_what_could_not_be_shown() {
    let shop = Workshop::new();
    let nothing = r#"<shape type="cylinder"><point name="p0" value="0, 1, 0"/><point name="p1" value="0, 1, 0"/></shape></scene>"#;
    let scene = shop.scene(&SCENE.replace("</scene>", nothing));
    for (more, code) in [(&[][..], 0), (&["--strict"], 1)] {
        let output = sunroom().arg("check").arg(&scene).args(more).output().expect("starts");
        assert_code(&output, code);
        let text = stderr(&output);
        assert!(text.contains("warning") && text.contains("left out"), "{text}");
        assert_eq!(
            text.contains("no errors, 1 warning, 3 shapes, 1 light"),
            code == 0,
            "{text}"
        );
    }
}

#[test]
fn a_far_clip_plane_before_the_scene_is_a_warning() {
    let shop = Workshop::new();
    let sensor = "<sensor type=\"perspective\">";
    let scene = shop.scene(&SCENE.replace(sensor, &format!("{sensor}<float name=\"far_clip\" value=\"0.2\"/>")));
    let checked = sunroom().arg("check").arg(&scene).output().expect("the program starts");
    let rendered = render(&scene, &shop.path("a.png"), &[]);
    for output in [checked, rendered] {
        assert_code(&output, 0);
        let said = stderr(&output);
        assert_eq!(
            said.matches("the far clip plane leaves the whole scene out").count(),
            1,
            "{said}"
        );
    }
}

/// `check` and `render` agree on what `--strict` refuses, also where only the engine sees it.
#[test]
fn what_the_engine_leaves_out_is_a_fault_where_warnings_are() {
    let shop = Workshop::new();
    let sensor = "<sensor type=\"perspective\">";
    let clipped = SCENE.replace(sensor, &format!("{sensor}<float name=\"far_clip\" value=\"0.2\"/>"));
    let two_sensors = clipped.replace(
        "</scene>",
        "<sensor type=\"perspective\" id=\"other\"><transform name=\"to_world\">
        <lookat origin=\"0, 2, 0\" target=\"0, 0, 0\" up=\"0, 0, 1\"/></transform></sensor></scene>",
    );
    let flat = with(
        "<shape type=\"cylinder\"><point name=\"p0\" value=\"1 1 1\"/><point name=\"p1\" value=\"1 1 1\"/></shape>",
    );
    let (scene, picture) = (shop.path("scene.xml"), shop.path("a.png"));
    for (text, more, is_refused) in [
        (&clipped, &[][..], true),
        (&flat, &[], true),
        (&two_sensors, &["--camera", "0"], true),
        (&two_sensors, &["--camera", "other"], false),
    ] {
        shop.scene(text);
        let arguments = [&["--spp", "1", "--size", "8x8", "-q"], more].concat();
        let lenient = render(&scene, &picture, &arguments);
        assert_code(&lenient, 0);
        std::fs::remove_file(&picture).expect("it was written");
        let strict = render(&scene, &picture, &[&arguments[..], &["--strict"]].concat());
        assert_code(&strict, i32::from(is_refused));
        let last = match is_refused {
            true => format!("{}: refused for its warnings\n", scene.display()),
            false => String::new(),
        };
        assert_eq!(stderr(&strict), stderr(&lenient) + &last, "{text}");
        assert_eq!(
            stderr(&strict).matches("warning: ").count(),
            usize::from(is_refused),
            "{}",
            stderr(&strict)
        );
        assert_eq!(picture.exists(), !is_refused, "nothing is rendered");
        if more.is_empty() {
            let checked = sunroom()
                .args(["check", "--strict"])
                .arg(&scene)
                .output()
                .expect("starts");
            assert_code(&checked, 1);
            assert!(stderr(&checked).starts_with(&stderr(&strict)), "{}", stderr(&checked));
        }
    }
}

#[test]
fn a_misspelt_command_gets_a_suggestion() {
    let more = "did you mean `render`?";
    for (arguments, help) in [
        (&["rendr", "scene.xml"][..], more),
        (&["rendr", "scene.xml", "-o", "a.png"], more),
        (&["rendr"], more),
        (
            &["frobnicate"],
            "the commands are edit, render, merge, submit, bake, measure, check, convert, diff, why, bench, completions, man",
        ),
    ] {
        let output = sunroom().args(arguments).output().expect("starts");
        assert_code(&output, 2);
        let word = arguments[0];
        let expected = format!("error: there is no command `{word}`, and no file of that name ({help})\n");
        assert_eq!(stderr(&output), expected);
    }
}

#[test]
fn cameras_are_listed_and_chosen() {
    let shop = Workshop::new();
    let second = r#"<sensor type="orthographic" id="above">
        <transform name="to_world"><lookat origin="0, 2, 0" target="0, 0, 0" up="0, 0, 1"/></transform>
        <film type="hdrfilm"><integer name="width" value="20"/><integer name="height" value="20"/>
            <integer name="crop_width" value="12"/></film></sensor></scene>"#;
    let scene = shop.scene(&SCENE.replace("</scene>", second));
    let checked = sunroom().arg("check").arg(&scene).output().expect("starts");
    assert_code(&checked, 0);
    assert!(stderr(&checked).contains("camera 1: above"), "{}", stderr(&checked));
    for camera in ["above", "1"] {
        let path = shop.path("a.exr");
        assert_code(&render(&scene, &path, &["--camera", camera]), 0);
        let image = image(&path);
        assert_eq!((image.width, image.height), (12, 20));
    }
    let output = render(&scene, &shop.path("b.exr"), &["--camera", "below"]);
    assert_code(&output, 2);
    let expected = "there is no camera `below`; there are 0: perspective, 1: above";
    assert!(stderr(&output).contains(expected), "{}", stderr(&output));
}

#[test]
fn a_missing_mesh_is_named_with_its_place() {
    let shop = Workshop::new();
    let mesh = r#"<shape type="ply"><string name="filename" value="ghost.ply"/></shape></scene>"#;
    let scene = shop.scene(&SCENE.replace("</scene>", mesh));
    let output = render(&scene, &shop.path("a.png"), &[]);
    assert_code(&output, 1);
    let text = stderr(&output);
    assert!(text.contains("ghost.ply") && text.contains("scene.xml:17:"), "{text}");
}

#[test]
fn a_broken_mesh_is_one_message_also_where_backtraces_are_wanted() {
    let shop = Workshop::new();
    let mesh = r#"<shape type="ply"><string name="filename" value="broken.ply"/></shape></scene>"#;
    let scene = shop.scene(&SCENE.replace("</scene>", mesh));
    std::fs::write(shop.path("broken.ply"), "ply\ngarbage\n").expect("can be written");
    let output = sunroom()
        .args(["check".as_ref(), scene.as_os_str()])
        .env("RUST_BACKTRACE", "1")
        .output()
        .expect("starts");
    assert_code(&output, 1);
    let text = stderr(&output);
    // The message, the line of the file in a frame, and the count of errors.
    let lines: Vec<&str> = text.lines().collect();
    assert!(
        lines.len() == 6 && lines[0].contains("broken.ply: line 2: expected"),
        "{text}"
    );
    assert!(lines[5].ends_with("scene.xml: 1 error"), "{text}");
}

#[test]
fn a_converted_scene_gives_the_same_picture() {
    let shop = Workshop::new();
    let scene = shop.scene(SCENE);
    let converted = shop.path("converted.xml");
    let output = sunroom()
        .arg("convert")
        .arg(&scene)
        .arg(&converted)
        .output()
        .expect("starts");
    assert_code(&output, 0);
    assert_code(&render(&scene, &shop.path("a.exr"), &[]), 0);
    assert_code(&render(&converted, &shop.path("b.exr"), &[]), 0);
    let before = std::fs::read(&scene).unwrap();
    let onto_itself = sunroom().arg("convert").args([&scene, &scene]).output().unwrap();
    assert_code(&onto_itself, 1);
    assert_eq!(std::fs::read(&scene).unwrap(), before);
    assert_eq!(image(&shop.path("a.exr")), image(&shop.path("b.exr")));
}

#[test]
fn the_end_names_the_written_files_and_the_final_samples() {
    let shop = Workshop::new();
    let scene = shop.scene(SCENE);
    let (exr, png) = (shop.path("a.exr"), shop.path("a.png"));
    let also = png.to_str().expect("text");
    let output = render(&scene, &exr, &["-o", also, "--spp", "7"]);
    assert_code(&output, 0);
    let said = stderr(&output);
    let last: Vec<&str> = said.lines().rev().take(2).collect();
    let expected = format!("the picture is in {}, {}", exr.display(), png.display());
    assert_eq!(last[0], expected);
    assert!(last[1].starts_with("100 %  7/7 spp"), "{said}");
    let timed = stderr(&render(&scene, &exr, &["--time", "2s"]));
    assert_eq!(timed.matches("100 %").count(), 1, "{timed}");
    let limited = stderr(&render(&scene, &exr, &["--spp", "1", "--threads", "5000"]));
    assert!(limited.contains("1024 threads trace rays"), "{limited}");
    assert_eq!(stderr(&render(&scene, &exr, &["-q", "--spp", "1"])), "");
}

#[test]
fn a_time_limit_ends_the_render() {
    let shop = Workshop::new();
    let output = shop.path("a.exr");
    let args = ["--time", "500ms", "--stats=json"];
    let result = render(&shop.scene(SCENE), &output, &args);
    assert_code(&result, 0);
    let stats: serde_json::Value = serde_json::from_slice(&result.stdout).expect("JSON");
    let spp = stats["spp"].as_u64().expect("a count");
    assert!(spp > 4, "the file's four samples are no limit: {spp}");
    assert!(image(&output).pixels.iter().any(|&pixel| pixel != glam::Vec3::ZERO));
}

#[test]
fn a_missing_file_opens_no_window() {
    let output = sunroom().arg("absent.xml").output().expect("starts");
    assert_code(&output, 1);
    assert!(
        stderr(&output).contains("absent.xml: there is no such file"),
        "{}",
        stderr(&output)
    );
}

#[test]
fn a_window_without_a_display_says_what_works_instead() {
    let shop = Workshop::new();
    let output = sunroom().arg("edit").arg(shop.scene(SCENE)).output().expect("starts");
    assert_code(&output, 1);
    assert!(stderr(&output).contains("sunroom render"), "{}", stderr(&output));
}

/// Every scene that comes with the program, very small; those whose mesh is not there have to say where to get it.
#[test]
fn the_scenes_of_the_project_render() {
    let shop = Workshop::new();
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let folders = ["scenes", "scenes/hard"].map(|folder| std::fs::read_dir(root.join(folder)).expect("a folder"));
    let entries = folders
        .into_iter()
        .flatten()
        .map(|entry| entry.expect("an entry").path());
    let mut seen = 0;
    for scene in entries.filter(|path| path.is_file()) {
        let output = shop.path("a.exr");
        let mut arguments = vec!["--strict", "--width", "64", "--spp", "2", "-q"];
        let mut least = 64 * 48 / 2;
        if scene.parent().is_some_and(|folder| folder.ends_with("hard")) {
            // Two samples by `path` find nothing at all in some of them, and by `bdpt` little behind the door.
            arguments.extend(["--integrator", "bdpt"]);
            least = 64 * 48 / 64;
        }
        let result = render(&scene, &output, &arguments);
        seen += 1;
        if result.status.code() == Some(1) && stderr(&result).contains("Stanford") {
            assert!(stderr(&result).contains("SUNROOM_ASSETS"), "{}", stderr(&result));
            println!("{}: its mesh is not here, only the message was tested", scene.display());
            continue;
        }
        assert_code(&result, 0);
        let lit = image(&output)
            .pixels
            .iter()
            .filter(|pixel| pixel.max_element() > 0.0)
            .count();
        assert!(lit > least, "{}: {lit} pixels are lit", scene.display());
    }
    assert!(seen >= 15, "{seen} scenes");
}

#[test]
fn converted_scenes_name_files_where_every_program_looks() {
    let shop = Workshop::new();
    let mesh =
        r#"<scene version="3.0.0"><shape type="obj"><string name="filename" value="../assets/a.obj"/></shape></scene>"#;
    std::fs::create_dir_all(shop.path("assets/models")).expect("can be made");
    std::fs::write(shop.path("assets/models/a.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").expect("can be written");
    let mut command = sunroom();
    command
        .args(["convert"])
        .arg(shop.scene(mesh))
        .arg(shop.path("new.xml"));
    // The file is there only by the variable.
    command.env("SUNROOM_ASSETS", shop.path("assets/models"));
    assert_code(&command.output().expect("the program starts"), 0);
    let written = std::fs::read_to_string(shop.path("new.xml")).expect("is there");
    assert!(written.contains(r#"value="assets/models/a.obj""#), "{written}");
}

/// A scene with something more in it.
fn with(more: &str) -> String {
    SCENE.replace("</scene>", &format!("{more}</scene>"))
}

#[test]
fn a_broken_mesh_is_an_error_wherever_the_scene_is_read() {
    let shop = Workshop::new();
    let scene = shop.scene(&with(
        "<shape type=\"ply\">\n<string name=\"filename\" value=\"cut.ply\"/></shape>",
    ));
    let header = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n";
    std::fs::write(shop.path("cut.ply"), format!("{header}0 0 0\n1 0 0\n")).expect("can be written");
    let copy = shop.path("copy.xml");
    let picture = shop.path("a.png");
    for args in [
        vec!["check", "scene.xml"],
        vec!["convert", "scene.xml", "copy.xml"],
        vec!["render", "scene.xml", "-o", "a.png"],
    ] {
        let output = sunroom()
            .current_dir(shop.folder())
            .args(&args)
            .output()
            .expect("starts");
        assert_code(&output, 1);
        let said = stderr(&output);
        assert!(said.contains("cut.ply") && said.contains(":18:"), "{args:?}: {said}");
    }
    assert!(!copy.exists() && !picture.exists());
    // Mended, it converts; what the reader mends is a warning.
    let whole = format!("{header}0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n");
    std::fs::write(shop.path("cut.ply"), whole).expect("can be written");
    let output = sunroom()
        .arg("convert")
        .arg(&scene)
        .arg(&copy)
        .output()
        .expect("starts");
    assert_code(&output, 0);
    let index = "<shape type=\"serialized\"><string name=\"filename\" value=\"cut.ply\"/><integer name=\"shape_index\" value=\"3\"/></shape>";
    let scene = shop.scene(&with(index));
    let output = sunroom()
        .arg("convert")
        .arg(&scene)
        .arg(&copy)
        .output()
        .expect("starts");
    assert_code(&output, 1);
    assert!(stderr(&output).contains("there is no shape 3"), "{}", stderr(&output));
}

#[test]
fn a_damaged_picture_is_an_error_and_a_missing_one_a_warning() {
    let shop = Workshop::new();
    let scene = shop.scene(&with(
        "<shape type=\"sphere\"><bsdf type=\"diffuse\"><texture type=\"bitmap\" name=\"reflectance\"><string name=\"filename\" value=\"p.png\"/></texture></bsdf></shape>",
    ));
    let (floor, picture) = (shop.path("p.png"), shop.path("a.exr"));
    assert_code(&render(&scene, &picture, &["-q", "--spp", "1"]), 0);
    let check = |arguments: &[&str]| {
        sunroom()
            .arg("check")
            .arg(&scene)
            .args(arguments)
            .output()
            .expect("starts")
    };
    assert_code(&check(&[]), 0);
    assert_code(&check(&["--strict"]), 1);
    let mut bytes = std::io::Cursor::new(Vec::new());
    image::RgbImage::new(8, 8)
        .write_to(&mut bytes, image::ImageFormat::Png)
        .expect("can be written");
    let bytes = bytes.into_inner();
    std::fs::write(&floor, &bytes).expect("can be written");
    assert_code(&check(&["--strict"]), 0);
    std::fs::write(&floor, &bytes[..bytes.len() / 2]).expect("can be written");
    for output in [check(&[]), render(&scene, &picture, &["-q", "--spp", "1"])] {
        assert_code(&output, 1);
        let said = stderr(&output);
        let line = said.lines().find(|line| line.contains("p.png: the picture is damaged"));
        assert!(line.is_some_and(|line| line.contains('×')), "{said}");
        assert!(said.contains("scene.xml:17:"), "{said}");
    }
    let converted = sunroom()
        .arg("convert")
        .arg(&scene)
        .arg(shop.path("b.xml"))
        .output()
        .expect("starts");
    // One style, but that convert goes on.
    let warning = stderr(&check(&[])).replace('×', "⚠");
    assert_code(&converted, 0);
    assert!(warning.contains(stderr(&converted).trim()), "{warning}");
    // It is named also where there are more warnings than are kept.
    let odd = "<bsdf type=\"odd\"/>\n".repeat(1100);
    let text = std::fs::read_to_string(&scene).expect("can be read");
    std::fs::write(&scene, text.replace("</scene>", &format!("{odd}</scene>"))).expect("can be written");
    for output in [check(&[]), render(&scene, &picture, &["-q", "--spp", "1"])] {
        assert_code(&output, 1);
        let said = stderr(&output);
        assert!(said.contains("p.png: the picture is damaged"), "{said}");
        assert!(said.contains("1 error, 1100 warnings"), "{said}");
    }
}

/// The decoder of JPEG files makes a picture of what there is.
#[test]
fn a_truncated_jpeg_is_an_error() {
    let shop = Workshop::new();
    let texture = "<texture type=\"bitmap\" name=\"reflectance\"><string name=\"filename\" value=\"p.jpg\"/></texture>";
    let scene = shop.scene(&with(&format!(
        "<shape type=\"sphere\"><bsdf type=\"diffuse\">{texture}</bsdf></shape>"
    )));
    let mut bytes = std::io::Cursor::new(Vec::new());
    image::RgbImage::from_fn(64, 64, |x, y| image::Rgb([4 * x as u8, 4 * y as u8, (x * y) as u8]))
        .write_to(&mut bytes, image::ImageFormat::Jpeg)
        .expect("can be written");
    let bytes = bytes.into_inner();
    let check = || {
        sunroom()
            .args(["check", "--strict"])
            .arg(&scene)
            .output()
            .expect("starts")
    };
    for percent in [90, 50, 20] {
        std::fs::write(shop.path("p.jpg"), &bytes[..bytes.len() * percent / 100]).expect("can be written");
        let output = check();
        assert_code(&output, 1);
        assert!(
            stderr(&output).contains("p.jpg: the picture is damaged"),
            "{}",
            stderr(&output)
        );
    }
    for rest in ["", "trailing bytes"] {
        std::fs::write(shop.path("p.jpg"), [&bytes, rest.as_bytes()].concat()).expect("can be written");
        assert_code(&check(), 0);
    }
}

#[test]
fn convert_warns_of_pictures_that_cannot_be_read() {
    let shop = Workshop::new();
    let texture = |name: &str| {
        format!("<texture type=\"bitmap\" name=\"radiance\"><string name=\"filename\" value=\"{name}\"/></texture>")
    };
    let light = |name: &str| {
        let texture = texture(name);
        format!("<shape type=\"sphere\"><emitter type=\"area\">{texture}</emitter></shape>\n")
    };
    let names = ["missing.png", "cut.png", "dark.pfm", "good.pfm"];
    let lights: String = names.map(light).concat();
    let mesh = "<shape type=\"obj\"><string name=\"filename\" value=\"a.obj\"/></shape>";
    let scene = shop.scene(&with(&format!("{lights}{mesh}")));
    shop.write("cut.png", b"\x89PNG\r\n\x1a\n");
    let pfm = |red: f32| [&b"PF\n1 1\n-1.0\n"[..], &red.to_le_bytes(), &[0; 8]].concat();
    shop.write("dark.pfm", pfm(-1.0));
    shop.write("good.pfm", pfm(1.0));
    shop.write("a.obj", "mtllib a.mtl\nusemtl a\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    shop.write("a.mtl", "newmtl a\nmap_Kd lost.png\n");
    let copy = shop.path("copy.xml");
    let convert = |more: &[&str]| {
        let mut command = sunroom();
        command.arg("convert").arg(&scene).arg(&copy).args(more);
        command.output().expect("starts")
    };
    let strict = convert(&["--strict"]);
    assert_code(&strict, 1);
    assert!(!copy.exists());
    let lenient = convert(&[]);
    assert_code(&lenient, 0);
    assert!(copy.exists());
    for output in [strict, lenient] {
        let said = stderr(&output);
        for expected in [
            "missing.png: no such file",
            "cut.png: the picture is damaged",
            "dark.pfm: 1 pixel has a negative value",
            "lost.png: no such file",
            "scene.xml:17:",
        ] {
            assert!(said.contains(expected), "{expected}: {said}");
        }
        assert!(!said.contains("good.pfm"), "{said}");
    }
}

#[test]
fn negative_pixels_of_lights_are_counted_and_black() {
    let shop = Workshop::new();
    // 2 x 1 pixels, the left one with a negative green.
    let mut picture = b"PF\n2 1\n-1.0\n".to_vec();
    for sample in [1.0f32, -3.0, 0.5, 1.0, 2.0, 0.5] {
        picture.extend(sample.to_le_bytes());
    }
    std::fs::write(shop.path("light.pfm"), picture).expect("can be written");
    let bitmap = "<texture type=\"bitmap\" name=\"radiance\"><string name=\"filename\" value=\"light.pfm\"/><string name=\"filter_type\" value=\"nearest\"/></texture>";
    let lamp = "<emitter type=\"area\"><rgb name=\"radiance\" value=\"5, 5, 5\"/></emitter>";
    let lit = [
        SCENE.replace(lamp, &format!("<emitter type=\"area\">{bitmap}</emitter>")),
        with("<emitter type=\"envmap\"><string name=\"filename\" value=\"light.pfm\"/></emitter>"),
    ];
    for text in lit {
        assert!(text.contains("light.pfm"));
        let scene = shop.scene(&text);
        let output = render(&scene, &shop.path("a.exr"), &["-q", "--spp", "4"]);
        assert_code(&output, 0);
        let said = stderr(&output);
        assert!(said.contains("light.pfm: 1 pixel has a negative value"), "{said}");
        let least = image(&shop.path("a.exr"))
            .pixels
            .iter()
            .map(|pixel| pixel.min_element())
            .fold(0.0, f32::min);
        assert_eq!(least, 0.0);
        assert_code(&render(&scene, &shop.path("a.exr"), &["-q", "--strict"]), 1);
    }
    // A height or a normal may be negative without a word.
    let height = "<shape type=\"sphere\"><bsdf type=\"bumpmap\"><texture type=\"bitmap\"><string name=\"filename\" value=\"light.pfm\"/><boolean name=\"raw\" value=\"true\"/></texture><bsdf type=\"diffuse\"/></bsdf></shape>";
    let scene = shop.scene(&with(height));
    assert_code(
        &render(&scene, &shop.path("a.exr"), &["-q", "--spp", "1", "--strict"]),
        0,
    );
}

/// The long options that stand in a text.
fn options(text: &str) -> std::collections::BTreeSet<&str> {
    let words = text.split(|c: char| !c.is_ascii_alphanumeric() && c != '-');
    words
        .filter(|word| {
            word.strip_prefix("--")
                .is_some_and(|name| name.starts_with(char::is_alphabetic))
        })
        .collect()
}

/// What `--help` prints of a command.
fn help(command: &str) -> String {
    let output = sunroom().args(command.split_whitespace()).arg("--help").output();
    let output = output.expect("the program starts");
    assert_code(&output, 0);
    String::from_utf8_lossy(&output.stdout).into_owned()
}

const COMMANDS: [&str; 15] = [
    "",
    "edit",
    "render",
    "merge",
    "submit",
    "bake",
    "measure",
    "check",
    "convert",
    "diff",
    "why",
    "bench",
    "bench rays",
    "completions",
    "man",
];

#[test]
fn the_page_about_the_command_line_has_the_options_of_the_program() {
    let page = include_str!("../../docs/command-line.md");
    let help = COMMANDS.map(help).concat();
    // It is an option of cargo, which starts the program.
    let mut described = options(page);
    assert!(described.remove("--release"), "{described:?}");
    assert_eq!(described, options(&help));
}

#[test]
fn completions_have_the_options_of_the_program() {
    for shell in ["bash", "zsh", "fish"] {
        let output = sunroom().args(["completions", shell]).output().expect("starts");
        assert_code(&output, 0);
        let script = String::from_utf8_lossy(&output.stdout).replace("-l ", "--");
        for option in options(&COMMANDS.map(help).concat()) {
            assert!(options(&script).contains(option), "{option} for {shell}");
        }
    }
    let output = sunroom().args(["completions", "cmd"]).output().expect("starts");
    assert_code(&output, 2);
}

#[test]
fn every_command_has_a_manual_page_with_its_options() {
    let shop = Workshop::new();
    let output = sunroom().arg("man").arg(shop.path("man1")).output().expect("starts");
    assert_code(&output, 0);
    for command in COMMANDS {
        let name = format!("man1/sunroom {command}").trim_end().replace(' ', "-") + ".1";
        let page = std::fs::read_to_string(shop.path(&name)).expect("one page for each command");
        // In bold, and with escaped hyphens.
        let page = page.replace("\\fB", "").replace("\\-", "-");
        assert_eq!(options(&page), options(&help(command)), "{name}");
    }
    let output = sunroom().arg("man").arg(shop.scene(SCENE)).output().expect("starts");
    assert_code(&output, 1);
}

#[test]
fn the_page_about_the_format_has_every_bsdf_and_light_with_their_parameters() {
    use sunroom::scene::encode::{lights, objects};
    use sunroom::scene::{Emitter, Material};

    let page = include_str!("../../docs/scene-format.md");
    let here = Path::new("/");
    let materials = Material::PLUGINS.into_iter().filter_map(Material::of_plugin);
    let materials = materials.map(|material| objects::material(&material, here));
    let emitters = Emitter::PLUGINS.into_iter().filter_map(Emitter::of_plugin);
    let emitters = emitters.map(|emitter| lights::emitter(&emitter, &glam::Affine3A::IDENTITY, None, here));
    let mut count = 0;
    for object in materials.chain(emitters) {
        let parameters = object.properties.iter().map(|property| property.name.as_str());
        for name in parameters.chain([object.plugin.as_str()]) {
            assert!(page.contains(&format!("`{name}`")), "{}: {name}", object.title());
            count += 1;
        }
    }
    // Were nothing written, nothing would be looked for.
    assert!(count > 80, "only {count} names");
}

#[test]
fn without_an_output_the_film_names_the_kind_of_file() {
    let shop = Workshop::new();
    let run = |scene: &Path, more: &[&str]| {
        let mut command = sunroom();
        command.arg("render").arg(scene).args(["-q", "--spp", "1"]).args(more);
        command.output().expect("the program starts")
    };
    for (format, file) in [("", "exr"), ("exr", "exr"), ("rgbe", "hdr"), ("pfm", "pfm")] {
        let name = format!("room-{format}");
        let given = format!("<film type=\"hdrfilm\"><string name=\"file_format\" value=\"{format}\"/>");
        let text = match format {
            "" => SCENE.to_owned(),
            _ => SCENE.replace("<film type=\"hdrfilm\">", &given),
        };
        let scene = shop.write(&format!("{name}.xml"), text);
        assert_code(&run(&scene, &[]), 0);
        let picture = std::fs::read(shop.path(&format!("{name}.{file}"))).expect("written");
        assert_eq!(load_image(&picture).expect("a picture").width(), 40);
        // It is not replaced, and its frames have names of their own.
        let again = run(&scene, &[]);
        assert_code(&again, 2);
        assert!(String::from_utf8_lossy(&again.stderr).contains("is there already: name a file with `-o`"));
        assert_code(&run(&scene, &["--frames", "3"]), 0);
        assert!(shop.path(&format!("{name}-0003.{file}")).exists());
    }
}
