//! Shares of a picture and their merging, checkpoints, and what a render tells while it works.

use std::collections::BTreeSet;
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant, SystemTime};

use sunroom::render::image_io::exr::decode_exr;
use sunroom::render::layered_image::{Channel, LayeredImage};

use crate::workshop::{Workshop, sunroom};

/// Two lamps over a floor, and a ball of rough metal: 80 x 70 pixels are three by three tiles, of which those at the
/// edge are small.
const SCENE: &str = r#"<scene version="3.0.0">
  <integrator type="path"><integer name="max_depth" value="5"/></integrator>
  <sensor type="perspective">
    <transform name="to_world"><lookat origin="0, 2, 5" target="0, 0.5, 0" up="0, 1, 0"/></transform>
    <film type="hdrfilm"><integer name="width" value="80"/><integer name="height" value="70"/></film>
    <sampler type="independent"><integer name="sample_count" value="64"/></sampler>
  </sensor>
  <shape type="rectangle" id="floor">
    <transform name="to_world"><scale value="4"/><rotate x="1" angle="-90"/></transform>
    <bsdf type="diffuse"><rgb name="reflectance" value="0.8, 0.4, 0.2"/></bsdf>
  </shape>
  <shape type="sphere" id="ball">
    <point name="center" x="0" y="0.6" z="0"/><float name="radius" value="0.6"/>
    <bsdf type="roughconductor"><float name="alpha" value="0.2"/></bsdf>
  </shape>
  <shape type="rectangle" id="key">
    <transform name="to_world"><rotate x="1" angle="90"/><translate y="2.5"/></transform>
    <emitter type="area"><rgb name="radiance" value="5, 5, 5"/></emitter>
  </shape>
  <emitter type="constant" id="sky"><rgb name="radiance" value="0.1, 0.2, 0.3"/></emitter>
</scene>
"#;

const EVERYTHING: &str = "alpha,albedo,normal,camera-normal,depth,position,uv,object-id,samples,variance,direct,indirect,light-groups,denoiser-albedo,\
    cryptomatte";

/// The program in the folder of a workshop that has the scene.
fn command(shop: &Workshop, arguments: &[&str]) -> Command {
    let mut command = sunroom();
    command.current_dir(shop.folder()).args(arguments);
    command
}

fn run(shop: &Workshop, arguments: &[&str]) -> Output {
    command(shop, arguments).output().expect("the program starts")
}

#[track_caller]
fn succeeds(shop: &Workshop, arguments: &[&str]) {
    let output = run(shop, arguments);
    assert!(
        output.status.success(),
        "{arguments:?}: {}",
        String::from_utf8_lossy(&output.stderr)
    );
}

/// The message of a command that fails with this code.
#[track_caller]
fn fails(shop: &Workshop, code: i32, arguments: &[&str]) -> String {
    let output = run(shop, arguments);
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(code), "{arguments:?}: {message}");
    message
}

#[track_caller]
fn same(shop: &Workshop, a: &str, b: &str) {
    same_after(shop, a, b, "");
}

/// Asserts that two files have the same bytes; if not, the message says what was done before, and what differs.
#[track_caller]
fn same_after(shop: &Workshop, a: &str, b: &str, before: &str) {
    let bytes = [a, b].map(|name| std::fs::read(shop.path(name)).expect(name));
    let [of_a, of_b] = &bytes;
    if of_a != of_b {
        panic!("{before}: {a} and {b} differ: {}", difference(of_a, of_b));
    }
}

/// What differs in two files: attributes and channels if both are EXR files.
fn difference(a: &[u8], b: &[u8]) -> String {
    let mut found = Vec::new();
    if let (Ok(a), Ok(b)) = (decode_exr(a), decode_exr(b)) {
        let names: BTreeSet<&String> = a.attributes.iter().chain(&b.attributes).map(|(name, _)| name).collect();
        for name in names {
            let [of_a, of_b] = [&a, &b].map(|image| image.attributes.iter().find(|(own, _)| own == name));
            if of_a != of_b {
                found.push(format!("the attribute {name} is {of_a:?} and {of_b:?}"));
            }
        }
        let names = |image: &LayeredImage| {
            image
                .channels
                .iter()
                .map(|channel| channel.name.clone())
                .collect::<Vec<_>>()
        };
        if names(&a) != names(&b) || [a.width, a.height] != [b.width, b.height] {
            found.push("the channels or the sizes are not the same".to_owned());
        } else {
            for (of_a, of_b) in a.channels.iter().zip(&b.channels) {
                let value = |channel: &Channel, pixel: usize| channel.samples.value(pixel);
                let mut others = (0..of_a.samples.len())
                    .filter(|&pixel| value(of_a, pixel).to_bits() != value(of_b, pixel).to_bits());
                if let Some(first) = others.next() {
                    let [x, y] = [first % a.width as usize, first / a.width as usize];
                    let (count, name) = (1 + others.count(), &of_a.name);
                    let values = [of_a, of_b].map(|channel| value(channel, first));
                    found.push(format!(
                        "{name} differs in {count} pixels, first at {x},{y}: {values:?}"
                    ));
                }
            }
        }
    }
    if found.is_empty() {
        let place = a.iter().zip(b).take_while(|(a, b)| a == b).count();
        let lengths = [a.len(), b.len()];
        return format!("the first other byte is number {place}, the files have {lengths:?}");
    }
    found.join("; ")
}

fn shop() -> Workshop {
    let shop = Workshop::new();
    shop.scene(SCENE);
    shop
}

/// Renders the parts of these samples and crops, and returns their names in no order.
fn parts(shop: &Workshop, ends: &[u32], crops: &[&str], more: &[&str]) -> Vec<String> {
    let mut names = Vec::new();
    for (place, range) in ends.windows(2).enumerate() {
        for (half, crop) in crops.iter().enumerate() {
            let name = format!("part{place}-{half}.exr");
            let (samples, threads) = (
                format!("{}..{}", range[0], range[1]),
                format!("{}", 1 + (place + half) % 3),
            );
            let share = [
                "render",
                "scene.xml",
                "-q",
                "-o",
                &name,
                "--samples",
                &samples,
                "--crop",
                crop,
                "-t",
                &threads,
            ];
            succeeds(shop, &[&share[..], more].concat());
            names.push(name);
        }
    }
    // An order that is neither that of the samples nor of the pixels.
    let count = names.len();
    (0..count).map(|place| names[place * 7 % count].clone()).collect()
}

fn merge(shop: &Workshop, parts: &[String], output: &str, more: &[&str]) {
    let parts: Vec<&str> = parts.iter().map(String::as_str).collect();
    succeeds(shop, &[&["merge", "-q", "-o", output][..], &parts, more].concat());
}

#[test]
fn parts_in_any_order_have_the_bits_of_the_whole() {
    let shop = shop();
    let layers = ["--aov", EVERYTHING];
    succeeds(
        &shop,
        &[
            &["render", "scene.xml", "-q", "-o", "whole.exr", "--spp", "64"][..],
            &layers,
        ]
        .concat(),
    );
    let crops = ["0,0,32,70", "32,0,48,70"];
    let parts = parts(&shop, &[0, 8, 16, 32, 48, 64], &crops, &layers);
    merge(&shop, &parts, "merged.exr", &[]);
    same(&shop, "whole.exr", "merged.exr");
}

/// Paths from the lights bring light to any pixel of the picture, also to those of other shares.
#[test]
fn parts_with_light_for_other_parts_have_the_bits_of_the_whole() {
    let shop = shop();
    let rough = r#"<bsdf type="roughconductor"><float name="alpha" value="0.2"/></bsdf>"#;
    shop.write("scene.xml", SCENE.replace(rough, r#"<bsdf type="conductor"/>"#));
    let whole = |name: &str, more: &[&str]| {
        let command = ["render", "scene.xml", "-q", "-o", name, "--spp", "32"];
        succeeds(&shop, &[&command, more].concat());
        std::fs::read(shop.path(name)).expect(name)
    };
    let path = whole("path.exr", &[]);
    let both = [["--integrator", "bdpt"], ["--integrator", "vcm"]].map(|how| {
        let whole = whole("whole.exr", &how);
        let parts = parts(&shop, &[0, 8, 16, 32], &["0,0,32,70", "32,0,48,70"], &how);
        merge(&shop, &parts, "merged.exr", &[]);
        same(&shop, "whole.exr", "merged.exr");
        assert!(whole != path);
        (whole, parts)
    });
    let [(one, parts), (other, _)] = both;
    assert!(one != other);
    // Other ways of finding light do not make one picture.
    let other = ["render", "scene.xml", "-q", "-o", "other.exr", "--samples", "32..64"];
    succeeds(&shop, &other);
    let command = ["merge", "-q", "-o", "both.exr", "other.exr"];
    let parts: Vec<&str> = parts.iter().map(String::as_str).collect();
    let message = fails(&shop, 1, &[&command, &parts[..]].concat());
    assert!(message.contains("integrator"), "{message}");
}

/// From 256 samples on, chunks are longer than passes.
#[test]
fn long_pictures_are_cut_into_shares_as_well() {
    let shop = shop();
    let size = ["--size", "33x20"];
    succeeds(
        &shop,
        &[
            &["render", "scene.xml", "-q", "-o", "whole.exr", "--spp", "700"][..],
            &size,
        ]
        .concat(),
    );
    let parts = parts(&shop, &[0, 288, 512, 640, 700], &["0,0,33,20"], &size);
    merge(&shop, &parts, "merged.exr", &[]);
    same(&shop, "whole.exr", "merged.exr");
    let message = fails(
        &shop,
        2,
        &["render", "scene.xml", "-o", "a.exr", "--samples", "300..400"],
    );
    assert!(
        message.contains("a range cannot begin at 300: 288 and 320 are the nearest"),
        "{message}"
    );
}

#[test]
fn a_merged_picture_is_written_as_a_rendered_one() {
    let shop = shop();
    let how = [
        "-o",
        "whole.png",
        "-o",
        "whole-half.exr",
        "--exr-type",
        "half",
        "--exposure",
        "1",
        "--tonemap",
        "aces",
    ];
    succeeds(
        &shop,
        &[&["render", "scene.xml", "-q", "--spp", "16"][..], &how].concat(),
    );
    let parts = parts(&shop, &[0, 8, 16], &["0,0,80,70"], &[]);
    merge(
        &shop,
        &parts,
        "merged.png",
        &[
            "-o",
            "merged-half.exr",
            "--exr-type",
            "half",
            "--exposure",
            "1",
            "--tonemap",
            "aces",
        ],
    );
    same(&shop, "whole.png", "merged.png");
    same(&shop, "whole-half.exr", "merged-half.exr");
    if cfg!(feature = "denoise") {
        succeeds(
            &shop,
            &[
                "render",
                "scene.xml",
                "-q",
                "--spp",
                "16",
                "--denoise",
                "-o",
                "whole.exr",
                "-t",
                "1",
            ],
        );
        merge(&shop, &parts, "merged.exr", &["--denoise", "-t", "1"]);
        same(&shop, "whole.exr", "merged.exr");
    }
}

#[test]
fn missing_last_shares_are_told() {
    let shop = shop();
    let merged = |samples: &[&str], more: &[&str]| {
        let mut merge = vec!["merge".to_owned(), "-o".to_owned(), "all.exr".to_owned()];
        for range in samples {
            let name = format!("{range}.exr");
            let render = ["render", "scene.xml", "-q", "-o", &name, "--samples", range];
            succeeds(&shop, &[&render[..], more].concat());
            merge.push(name);
        }
        let merge: Vec<&str> = merge.iter().map(String::as_str).collect();
        let output = run(&shop, &merge);
        assert!(output.status.success());
        assert!(shop.path("all.exr").exists());
        String::from_utf8_lossy(&output.stderr).into_owned()
    };
    let said = merged(&["0..1", "1..2"], &["--spp", "8"]);
    let words = "warning: the parts have 2 of 8 samples per pixel: those of samples 2..8 are missing";
    assert!(said.contains(words), "{said}");
    // The scene asks for 64.
    let said = merged(&["0..4"], &[]);
    assert!(said.contains("4 of 64 samples per pixel"), "{said}");
    for (samples, more) in [
        (&["0..2", "2..4"][..], &["--spp", "4"][..]),
        // How far shares go beyond the scene's number is not known.
        (&["0..65"], &[]),
    ] {
        let said = merged(samples, more);
        assert!(!said.contains("warning"), "{said}");
    }
}

#[test]
fn a_merged_picture_never_replaces_a_part() {
    let shop = shop();
    let parts = parts(&shop, &[0, 1, 2], &["0,0,80,70"], &[]);
    let before: Vec<_> = parts.iter().map(|name| std::fs::read(shop.path(name)).ok()).collect();
    let other = format!("./{}", parts[1]);
    for output in [&parts[0], &other] {
        let message = fails(
            &shop,
            2,
            &["merge", &parts[0], &parts[1], "-o", "all.png", "-o", output],
        );
        let words = format!("{output}: this output is one of the parts, which is not replaced");
        assert!(message.contains(&words), "{message}");
    }
    for (name, before) in parts.iter().zip(before) {
        assert!(
            before.is_some() && std::fs::read(shop.path(name)).ok() == before,
            "{name}"
        );
    }
    assert!(!shop.path("all.png").exists());
}

#[test]
fn what_is_no_whole_picture_is_refused_by_name() {
    let shop = shop();
    let parts = parts(&shop, &[0, 8, 16], &["0,0,32,70", "32,0,48,70"], &[]);
    let merged = |names: &[&str]| fails(&shop, 1, &[&["merge", "-o", "all.exr"][..], names].concat());
    let all = ["part0-0.exr", "part0-1.exr", "part1-0.exr", "part1-1.exr"];
    assert_eq!(parts.len(), 4);
    let message = merged(&all[..3]);
    assert!(
        message.contains("no part has samples 8..16 of the 48 x 70 pixels at 32,0"),
        "{message}"
    );
    succeeds(
        &shop,
        &["render", "scene.xml", "-q", "-o", "again.exr", "--samples", "8..16"],
    );
    let message = merged(&[&all[..], &["again.exr"]].concat());
    assert!(
        message.contains("both have samples 8..16") && message.contains("again.exr"),
        "{message}"
    );
    succeeds(
        &shop,
        &[
            "render",
            "scene.xml",
            "-q",
            "-o",
            "seed.exr",
            "--samples",
            "8..16",
            "--seed",
            "7",
        ],
    );
    let message = merged(&["part0-0.exr", "part0-1.exr", "seed.exr"]);
    assert!(
        message.contains("seed.exr is a part of another picture than part0-0.exr: the seed is 7"),
        "{message}"
    );
    shop.scene(&SCENE.replace("0.8, 0.4", "0.8, 0.5"));
    succeeds(
        &shop,
        &["render", "scene.xml", "-q", "-o", "other.exr", "--samples", "8..16"],
    );
    let message = merged(&["part0-0.exr", "part0-1.exr", "other.exr"]);
    assert!(
        message.contains("other.exr is a part of another picture") && message.contains("scene.xml has another content"),
        "{message}"
    );
    succeeds(&shop, &["render", "scene.xml", "-q", "-o", "plain.exr", "--spp", "1"]);
    let message = merged(&["plain.exr"]);
    assert!(
        message.contains("plain.exr: has a picture, but not the exact sums"),
        "{message}"
    );
    // Damage is noticed.
    let mut bytes = std::fs::read(shop.path("again.exr")).expect("it is there");
    let place = bytes.len() - 1000;
    bytes[place] ^= 4;
    shop.write("damaged.exr", bytes);
    let message = merged(&["part0-0.exr", "part0-1.exr", "damaged.exr", "--force"]);
    assert!(
        message.contains("damaged.exr: the state of the picture in it is damaged"),
        "{message}"
    );
    assert!(!shop.path("all.exr").exists());
}

#[test]
fn shares_refuse_what_cannot_be_divided() {
    let shop = shop();
    let usage = |more: &[&str]| fails(&shop, 2, &[&["render", "scene.xml", "-o", "a.exr"][..], more].concat());
    for more in [["--noise", "1%"], ["--time", "1s"]] {
        assert!(usage(&[&["--samples", "0..8"][..], &more].concat()).contains("cannot be used with"));
    }
    let message = usage(&["--crop", "5,0,32,32"]);
    assert!(message.contains("not at X = 5: 0 and 32 are the nearest"), "{message}");
    assert!(usage(&["--crop", "32,0,96,32"]).contains("does not lie in the picture"));
    let message = fails(&shop, 2, &["render", "scene.xml", "-o", "a.png", "--samples", "0..8"]);
    assert!(message.contains("a part of a picture is an EXR file"), "{message}");
    let message = fails(
        &shop,
        2,
        &["render", "scene.xml", "-o", "-", "-o", "a.exr", "--partial", "1s"],
    );
    assert!(message.contains("--partial writes several pictures"), "{message}");
    for more in [["--samples", "0..8"], ["--crop", "0,0,32,32"]] {
        let message = fails(&shop, 2, &[&["render", "scene.xml"][..], &more].concat());
        assert!(message.contains("a part of a picture needs a name"), "{message}");
    }
    for more in [["--checkpoint", "c.exr"], ["--resume", "c.exr"]] {
        let message = fails(&shop, 2, &[&["render", "scene.xml"][..], &more].concat());
        assert!(
            message.contains("a picture with a checkpoint needs a name"),
            "{message}"
        );
    }
    assert!(!shop.path("scene.exr").exists() && !shop.path("c.exr").exists());
    shop.scene(&SCENE.replace("</sampler>", "<boolean name='adaptive' value='true'/></sampler>"));
    let message = usage(&["--samples", "0..8"]);
    assert!(message.contains("adaptive sampling"), "{message}");
}

#[test]
fn frames_at_other_times_are_other_pictures() {
    let shop = shop();
    for (name, samples, fps) in [
        ("a.exr", "0..4", "24"),
        ("b.exr", "4..8", "24"),
        ("c.exr", "4..8", "25"),
    ] {
        let share = ["--samples", samples, "--spp", "8", "--frames", "3", "--fps", fps];
        succeeds(
            &shop,
            &[
                &["render", "scene.xml", "-q", "-o", &name.replace(".exr", "-#.exr")][..],
                &share,
            ]
            .concat(),
        );
    }
    succeeds(&shop, &["merge", "-q", "-o", "all.exr", "a-3.exr", "b-3.exr"]);
    let message = fails(&shop, 1, &["merge", "-o", "all.exr", "a-3.exr", "c-3.exr"]);
    assert!(
        message.contains("the list of moments in seconds is 0.12, and was 0.125"),
        "{message}"
    );
}

/// The pictures in a glTF file are taken apart into a folder of the user's caches, which lies elsewhere on another
/// machine.
#[cfg(target_os = "linux")]
#[test]
fn shares_of_gltf_files_agree_between_machines() {
    let shop = shop();
    let glb = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/corpus/gltf/small.glb");
    shop.write("small.glb", std::fs::read(glb).expect("it is in the repository"));
    for (name, samples, cache) in [("a.exr", "0..4", "cache-a"), ("b.exr", "4..8", "cache-b")] {
        let share = [
            "render",
            "small.glb",
            "-q",
            "-o",
            name,
            "--size",
            "32x32",
            "--samples",
            samples,
        ];
        let mut command = command(&shop, &share);
        let output = command.env("XDG_CACHE_HOME", shop.path(cache)).output();
        assert!(output.expect("the program starts").status.success());
        assert!(shop.path(cache).join("sunroom/gltf").exists());
    }
    succeeds(&shop, &["merge", "-q", "-o", "all.exr", "a.exr", "b.exr"]);
}

#[test]
fn figures_of_a_share_count_its_own_samples() {
    let shop = shop();
    let output = run(
        &shop,
        &[
            "render",
            "scene.xml",
            "-q",
            "-o",
            "a.exr",
            "--samples",
            "16..48",
            "--stats=json",
        ],
    );
    let stats: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
    assert_eq!(stats["spp"], 32);
}

#[test]
fn the_progress_of_a_share_counts_its_own_samples() {
    let shop = shop();
    let output = run(&shop, &["render", "scene.xml", "-o", "a.exr", "--samples", "16..48"]);
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(said.contains("32/32 spp"), "{said}");
    assert!(!said.contains("/48 spp"), "{said}");
}

/// 15 groups of samples are kept, each as large as the sums of the picture.
#[test]
fn the_groups_of_a_share_count_in_the_memory_budget() {
    let shop = shop();
    let render = [
        "render",
        "scene.xml",
        "-q",
        "-o",
        "a.exr",
        "--size",
        "512x512",
        "--memory",
        "128M",
    ];
    let message = fails(&shop, 1, &[&render[..], &["--samples", "16..256"]].concat());
    assert!(message.contains("a film of 512 x 512 pixels needs"), "{message}");
    let crop = ["--crop", "0,0,32,32", "--samples", "16..256"];
    succeeds(&shop, &[&render[..], &crop].concat());
}

/// Starts a render with checkpoints, and waits until it has written one itself.
fn start_with_checkpoint(shop: &Workshop, arguments: &[&str]) -> Child {
    let path = shop.path("c.exr");
    let before = written(&path);
    let mut command = command(shop, arguments);
    let child = command
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .expect("the program starts");
    let begin = Instant::now();
    while written(&path) == before {
        let is_late = begin.elapsed() > Duration::from_secs(600);
        assert!(!is_late, "there is no new {}", path.display());
        std::thread::sleep(Duration::from_millis(5));
    }
    child
}

/// The time at which a file was written, if it is there.
fn written(path: &Path) -> Option<SystemTime> {
    std::fs::metadata(path).and_then(|about| about.modified()).ok()
}

fn wait_for(path: &Path) {
    let begin = Instant::now();
    while !path.exists() {
        assert!(
            begin.elapsed() < Duration::from_secs(600),
            "there is no {}",
            path.display()
        );
        std::thread::sleep(Duration::from_millis(5));
    }
}

fn checkpoints<'a>(samples: &[&'a str]) -> Vec<&'a str> {
    let options = [
        "render",
        "scene.xml",
        "-q",
        "-o",
        "a.exr",
        "--checkpoint",
        "c.exr",
        "--every",
        "20ms",
        "--resume",
        "c.exr",
    ];
    [&options[..], samples].concat()
}

#[test]
fn killed_renders_go_on_to_the_same_bits() {
    let shop = shop();
    let cases: [&[&str]; 4] = [
        &["--spp", "600"],
        &["--spp", "400", "--adaptive", "--aov", "samples,variance"],
        &["--noise", "0.9%"],
        &["--samples", "256..640", "--aov", "normal,cryptomatte"],
    ];
    for (case, samples) in cases.into_iter().enumerate() {
        succeeds(
            &shop,
            &[&["render", "scene.xml", "-q", "-o", "whole.exr"][..], samples].concat(),
        );
        for round in 0..3 {
            let mut child = start_with_checkpoint(&shop, &checkpoints(samples));
            std::thread::sleep(Duration::from_millis(40 + 70 * round + 13 * case as u64));
            // It may have come to its end.
            child.kill().and_then(|()| child.wait()).expect("it was started");
        }
        succeeds(&shop, &checkpoints(samples));
        match samples[0] {
            // The picture of a part is the same, and what follows it says how long it took.
            "--samples" => {
                merge_after(&shop, samples);
            }
            _ => same_after(&shop, "whole.exr", "a.exr", &format!("{samples:?}")),
        }
        std::fs::remove_file(shop.path("c.exr")).expect("it is there");
    }
}

/// Merges the interrupted part and the other one with the same rest of the picture.
fn merge_after(shop: &Workshop, samples: &[&str]) {
    succeeds(
        shop,
        &[
            &["render", "scene.xml", "-q", "-o", "first.exr", "--samples", "0..256"][..],
            &samples[2..],
        ]
        .concat(),
    );
    for (part, output) in [("whole.exr", "one.exr"), ("a.exr", "other.exr")] {
        succeeds(shop, &["merge", "-q", part, "first.exr", "-o", output]);
    }
    same(shop, "one.exr", "other.exr");
}

#[test]
fn a_checkpoint_of_another_picture_is_refused_unless_forced() {
    let shop = shop();
    succeeds(
        &shop,
        &[
            "render",
            "scene.xml",
            "-q",
            "-o",
            "a.exr",
            "--spp",
            "8",
            "--checkpoint",
            "c.exr",
        ],
    );
    let resume = [
        "render",
        "scene.xml",
        "-q",
        "-o",
        "a.exr",
        "--spp",
        "16",
        "--resume",
        "c.exr",
    ];
    succeeds(&shop, &resume);
    succeeds(&shop, &["render", "scene.xml", "-q", "-o", "whole.exr", "--spp", "16"]);
    same(&shop, "a.exr", "whole.exr");
    // Samples that are there are not thrown away, which is said.
    let fewer = [
        "render",
        "scene.xml",
        "-q",
        "-o",
        "b.exr",
        "--spp",
        "3",
        "--resume",
        "c.exr",
    ];
    let output = run(&shop, &fewer);
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    let words = "c.exr has 8 samples per pixel already, and 3 are asked for: the picture keeps all of them";
    assert!(output.status.success() && said.contains(words), "{said}");
    succeeds(&shop, &["render", "scene.xml", "-q", "-o", "eight.exr", "--spp", "8"]);
    same(&shop, "b.exr", "eight.exr");
    let message = fails(&shop, 1, &[&resume[..], &["--seed", "3", "--max-depth", "2"]].concat());
    assert!(
        message.contains("c.exr is a checkpoint of another picture: the seed is 3, and was 0; the integrator"),
        "{message}"
    );
    shop.scene(&SCENE.replace("0.8, 0.4", "0.8, 0.5"));
    let message = fails(&shop, 1, &resume);
    assert!(
        message.contains("scene.xml has another content (--force goes on with it)"),
        "{message}"
    );
    succeeds(&shop, &[&resume[..], &["--force"]].concat());
    let message = fails(&shop, 1, &[&resume[..], &["--force", "--size", "40x30"]].concat());
    assert!(message.contains("has another size or other layers"), "{message}");
    assert!(
        fails(
            &shop,
            1,
            &["render", "scene.xml", "-o", "a.exr", "--resume", "none.exr"]
        )
        .contains("none.exr")
    );
}

#[cfg(unix)]
#[test]
fn signals_ask_for_a_checkpoint_and_for_the_picture_so_far() {
    let shop = shop();
    let mut arguments = checkpoints(&["--spp", "1000000000", "--stats=json-lines"]);
    // The first checkpoint comes early, the next ones are left to the signal.
    arguments[8] = "50ms";
    let mut child = command(&shop, &arguments)
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .expect("the program starts");
    let signal = |name: &str, child: &Child| {
        let sent = Command::new("kill").arg(name).arg(child.id().to_string()).status();
        assert!(sent.expect("kill is there").success());
    };
    wait_for(&shop.path("c.exr"));
    assert!(!shop.path("a.exr").exists());
    signal("-USR1", &child);
    wait_for(&shop.path("a.exr"));
    signal("-TERM", &child);
    assert_eq!(child.wait().expect("it ends").code(), Some(143));
    let mut text = String::new();
    std::io::Read::read_to_string(&mut child.stdout.take().expect("a pipe"), &mut text).expect("UTF-8");
    let events: Vec<serde_json::Value> = text
        .lines()
        .map(|line| serde_json::from_str(line).expect(line))
        .collect();
    let is = |name: &str| events.iter().filter(|event| event["event"] == name).count();
    assert_eq!(events[0]["event"], "begin");
    assert!(is("picture") == 1 && is("checkpoint") >= 2, "{text}");
    assert!(
        events
            .iter()
            .all(|event| event["event"] != "checkpoint" || event["samples"].is_u64())
    );
}

#[cfg(unix)]
#[test]
fn pictures_so_far_and_events_come_by_themselves() {
    let shop = shop();
    let arguments = [
        "render",
        "scene.xml",
        "-q",
        "-o",
        "a.png",
        "--time",
        // An interrupt ends it much earlier.
        "600s",
        "--partial",
        "100ms",
        "--stats=json-lines",
    ];
    let mut child = command(&shop, &arguments)
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .expect("the program starts");
    let (mut text, mut events, mut is_interrupted) = (String::new(), Vec::<serde_json::Value>::new(), false);
    for line in BufReader::new(child.stdout.take().expect("a pipe")).lines() {
        let line = line.expect("UTF-8");
        events.push(serde_json::from_str(&line).expect(&line));
        text += &format!("{line}\n");
        let count = |name: &str| events.iter().filter(|event| event["event"] == name).count();
        if count("picture") > 2 && count("progress") > 0 && !is_interrupted {
            assert!(shop.path("a.png").exists());
            let sent = Command::new("kill").arg("-INT").arg(child.id().to_string()).status();
            is_interrupted = sent.expect("kill is there").success();
        }
    }
    assert_eq!(child.wait().expect("it ends").code(), Some(130), "{text}");
    let of = |name: &str| events.iter().filter(|event| event["event"] == name).collect::<Vec<_>>();
    assert!(
        of("begin").len() == 1 && of("end").len() == 1 && of("picture").len() > 2,
        "{text}"
    );
    let progress = of("progress");
    assert!(
        !progress.is_empty()
            && progress
                .iter()
                .all(|event| event["done"].is_number() && event["samples"].is_u64()),
        "{text}"
    );
    assert_eq!(events.last().expect("the end")["outputs"][0], "a.png");
}

/// The disk becomes full while a checkpoint is written: the old one stays, and rendering goes on.
#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_leaves_the_old_checkpoint() {
    let shop = shop();
    std::fs::create_dir(shop.path("full")).expect("a temporary folder");
    let run = |script: &str| {
        let output = Command::new("unshare")
            .args(["-m", "sh", "-c", script])
            .current_dir(shop.folder())
            .output()
            .expect("unshare is there");
        let message = String::from_utf8_lossy(&output.stderr).into_owned();
        (output.status.success(), message)
    };
    // 700 kB are enough for one checkpoint of the small picture, but not for another one beside it.
    let script = format!(
        "mount -t tmpfs -o size=700k none full && \
         '{0}' render scene.xml -q -o a.exr --spp 16 --checkpoint full/c.exr && cp full/c.exr first.exr && \
         '{0}' render scene.xml -q -o b.exr --spp 64 --checkpoint full/c.exr --resume full/c.exr && cmp full/c.exr first.exr && ls -A full > left",
        env!("CARGO_BIN_EXE_sunroom")
    );
    let (succeeded, message) = run(&script);
    if message.contains("unshare failed") || message.contains("permission denied") {
        eprintln!("skipped: the system permits no mount namespace");
        return;
    }
    assert!(succeeded, "{message}");
    assert!(
        message.contains("warning: cannot write full/c.exr") && message.contains("the checkpoint before it stays"),
        "{message}"
    );
    assert_eq!(
        std::fs::read_to_string(shop.path("left")).expect("it was listed"),
        "c.exr\n"
    );
    succeeds(&shop, &["render", "scene.xml", "-q", "-o", "whole.exr", "--spp", "64"]);
    same(&shop, "b.exr", "whole.exr");
    // Nothing is said to stay where there is no earlier one.
    let script = format!(
        "mount -t tmpfs -o size=64k none full && '{}' render scene.xml -q -o c.exr --spp 16 --checkpoint full/c.exr --every 1ms",
        env!("CARGO_BIN_EXE_sunroom")
    );
    let (_, message) = run(&script);
    assert!(
        message.contains("warning: cannot write full/c.exr") && !message.contains("before it"),
        "{message}"
    );
}
