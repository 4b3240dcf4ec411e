//! Pictures that `render` writes: formats, what is in them, and a viewer that follows the render.

use std::collections::HashMap;
use std::io::Read;
use std::net::TcpListener;
use std::path::{Path, PathBuf};
use std::process::Output;

use sunroom::render::image_io::exr::decode_exr;
use sunroom::render::image_io::load_picture;
use sunroom::render::layered_image::{Attribute, LayeredImage, Samples};
use sunroom::render::tonemap::{Display, ToneMap};
use sunroom::render::white_balance::WhiteBalance;

use crate::workshop::{Workshop, sunroom};

/// A lamp over a red floor, 48 x 40 pixels.
pub const SCENE: &str = r#"<scene version="3.0.0">
  <integrator type="path"><integer name="max_depth" value="3"/></integrator>
  <sensor type="perspective" id="front">
    <transform name="to_world"><lookat origin="0, 2, 5" target="0, 0.5, 0" up="0, 1, 0"/></transform>
    <film type="hdrfilm"><integer name="width" value="48"/><integer name="height" value="40"/></film>
    <sampler type="independent"><integer name="sample_count" value="4"/></sampler>
  </sensor>
  <shape type="rectangle">
    <transform name="to_world"><scale value="4"/><rotate x="1" angle="-90"/></transform>
    <bsdf type="diffuse"><rgb name="reflectance" value="0.8, 0.2, 0.1"/></bsdf>
  </shape>
  <shape type="rectangle">
    <transform name="to_world"><rotate x="1" angle="90"/><translate y="2.5"/></transform>
    <emitter type="area"><rgb name="radiance" value="6, 5, 4"/></emitter>
  </shape>
</scene>
"#;

fn render(scene: &Path, outputs: &[PathBuf], more: &[&str]) -> Output {
    let mut command = sunroom();
    command.arg("render").arg(scene).args(["-q", "--seed", "5"]);
    for output in outputs {
        command.arg("-o").arg(output);
    }
    command.args(more).output().expect("the program starts")
}

#[track_caller]
fn assert_success(output: &Output) {
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{said}");
}

fn exr(path: &Path) -> LayeredImage {
    decode_exr(&std::fs::read(path).expect("the file is there")).expect("an EXR file")
}

#[test]
fn options_decide_how_files_hold_the_picture() {
    let shop = Workshop::new();
    let scene = shop.scene(SCENE);
    let names = ["a.exr", "a.hdr", "a.pfm", "a.png", "a.jpg"];
    assert_success(&render(&scene, &names.map(|name| shop.path(name)), &[]));
    let plain = exr(&shop.path("a.exr"));
    assert!(
        plain
            .channels
            .iter()
            .all(|channel| matches!(channel.samples, Samples::Float(_)))
    );
    let attribute = |name: &str| plain.attribute(name).cloned().unwrap_or_else(|| panic!("{name}"));
    assert_eq!(attribute("sunroom:spp"), Attribute::Int(4));
    assert_eq!(attribute("sunroom:seed"), Attribute::Int(5));
    assert_eq!(attribute("sunroom:camera"), Attribute::Text("front".to_owned()));
    assert_eq!(attribute("sunroom:scene"), Attribute::Text(scene.display().to_string()));
    assert!(matches!(attribute("software"), Attribute::Text(name) if name.starts_with("Sunroom ")));
    // The same numbers without loss.
    let radiance = plain.layer("").expect("colours");
    let map = load_picture(&std::fs::read(shop.path("a.pfm")).expect("written")).expect("a float map");
    assert_eq!(map.image.layer(""), Some(radiance.clone()));

    let half = shop.path("half.exr");
    let deep = shop.path("deep.png");
    let poor = shop.path("poor.jpg");
    let options = [
        "--exr-type",
        "half",
        "--compression",
        "piz",
        "--png-bits",
        "16",
        "--jpeg-quality",
        "20",
    ];
    assert_success(&render(&scene, &[half.clone(), deep.clone(), poor.clone()], &options));
    let half = exr(&half).layer("").expect("colours");
    for (half, whole) in half.pixels.iter().zip(&radiance.pixels) {
        assert!(
            (*half - *whole).abs().max_element() <= whole.max_element() / 1024.0,
            "{half} {whole}"
        );
    }
    // The header: depth of 16 bits.
    assert_eq!(std::fs::read(&deep).expect("written")[24], 16);
    let length = |path: &Path| std::fs::metadata(path).expect("written").len();
    assert!(length(&poor) < length(&shop.path("a.jpg")));
    let refused = render(&scene, &[shop.path("b.exr")], &["--compression", "lzw"]);
    assert_eq!(refused.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&refused.stderr).contains("piz"));
}

#[test]
fn the_scene_says_how_its_film_is_stored() {
    let shop = Workshop::new();
    let storage = |pixels: &str, components: &str| {
        let film = format!(
            "<film type=\"hdrfilm\"><string name=\"pixel_format\" value=\"{pixels}\"/><string name=\"component_format\" value=\"{components}\"/>"
        );
        shop.scene(&SCENE.replace("<film type=\"hdrfilm\">", &film))
    };
    let outputs = ["a.exr", "a.pfm", "a.png"].map(|name| shop.path(name));
    assert_success(&render(&storage("luminance", "float16"), &outputs, &[]));
    let grey = exr(&outputs[0]);
    let [channel] = &grey.channels[..] else {
        panic!("{:?}", grey.layers())
    };
    assert!(channel.name == "Y" && matches!(channel.samples, Samples::Half(_)));
    assert!(std::fs::read(&outputs[1]).expect("written").starts_with(b"Pf\n"));
    // A picture of the display has its colours.
    let png = image::open(&outputs[2]).expect("a PNG").to_rgb8();
    assert!(png.pixels().any(|pixel| pixel.0[0] > pixel.0[2]));

    assert_success(&render(&storage("xyz", "float16"), &outputs, &["--exr-type", "float"]));
    let xyz = exr(&outputs[0]);
    let mut names: Vec<&str> = xyz.channels.iter().map(|channel| channel.name.as_str()).collect();
    names.sort_unstable();
    assert_eq!(names, ["X", "Y", "Z"]);
    assert!(
        xyz.channels
            .iter()
            .all(|channel| matches!(channel.samples, Samples::Float(_)))
    );

    let film = "<film type=\"hdrfilm\"><string name=\"compression\" value=\"none\"/>";
    let scene = shop.scene(&SCENE.replace("<film type=\"hdrfilm\">", film));
    let length = |options: &[&str]| {
        assert_success(&render(&scene, &outputs[..1], options));
        std::fs::metadata(&outputs[0]).expect("written").len()
    };
    let (of_scene, of_argument) = (length(&[]), length(&["--compression", "zip"]));
    assert_eq!(of_scene, length(&["--compression", "none"]));
    assert!(of_argument < of_scene, "{of_argument} {of_scene}");
}

/// The painter of the viewport encodes with the same [`Display`] (`picture/painter.rs`).
#[test]
fn png_has_the_bytes_that_the_viewport_shows() {
    let shop = Workshop::new();
    let scene = shop.scene(SCENE);
    for tone_map in ToneMap::ALL {
        let outputs = [shop.path("a.exr"), shop.path("a.png")];
        let options = ["--exposure", "-0.5", "--tonemap", tone_map.name(), "--white", "4500,10"];
        assert_success(&render(&scene, &outputs, &options));
        let display = Display {
            exposure_ev: -0.5,
            white_balance: WhiteBalance {
                temperature: 4500.0,
                tint: 10.0,
            },
            tone_map,
        };
        let radiance = exr(&outputs[0]).layer("").expect("colours").pixels;
        let mut shown = vec![0; 4 * radiance.len()];
        display.encode_rgba(&radiance, &mut shown);
        let png = image::open(&outputs[1]).expect("a PNG").to_rgba8().into_raw();
        assert!(png == shown, "{tone_map:?}");
        assert!(png.iter().any(|&byte| byte > 100 && byte < 255), "{tone_map:?}");
    }
}

/// One message of the viewer's protocol, without its length.
fn message(stream: &mut impl Read) -> Option<Vec<u8>> {
    let mut length = [0; 4];
    stream.read_exact(&mut length).ok()?;
    let mut rest = vec![0; u32::from_le_bytes(length) as usize - 4];
    stream.read_exact(&mut rest).expect("a whole message");
    Some(rest)
}

struct Reader<'a>(&'a [u8]);

impl Reader<'_> {
    fn take<const N: usize>(&mut self) -> [u8; N] {
        let (head, rest) = self.0.split_first_chunk::<N>().expect("long enough");
        self.0 = rest;
        *head
    }

    fn int(&mut self) -> usize {
        i32::from_le_bytes(self.take()) as usize
    }

    fn long(&mut self) -> usize {
        i64::from_le_bytes(self.take()) as usize
    }

    fn text(&mut self) -> String {
        let end = self.0.iter().position(|&byte| byte == 0).expect("an end");
        let text = String::from_utf8(self.0[..end].to_vec()).expect("text");
        self.0 = &self.0[end + 1..];
        text
    }
}

/// The pictures that a viewer has once the stream ends: sizes and channels by name. It reads as tev does (`Ipc.cpp`).
fn viewed(stream: &mut impl Read) -> (HashMap<String, ([usize; 2], HashMap<String, Vec<f32>>)>, usize) {
    let mut pictures = HashMap::new();
    let mut updates = 0;
    while let Some(message) = message(stream) {
        let mut reader = Reader(&message);
        let [operation, _focus] = reader.take();
        let name = reader.text();
        match operation {
            4 => {
                let size = [reader.int(), reader.int()];
                let count = reader.int();
                let channels = (0..count).map(|_| (reader.text(), vec![0.0; size[0] * size[1]]));
                pictures.insert(name, (size, channels.collect()));
            }
            6 => {
                updates += 1;
                let count = reader.int();
                let names: Vec<String> = (0..count).map(|_| reader.text()).collect();
                let [x, y, width, height] = [(); 4].map(|()| reader.int());
                let offsets: Vec<usize> = (0..count).map(|_| reader.long()).collect();
                let strides: Vec<usize> = (0..count).map(|_| reader.long()).collect();
                let floats: Vec<f32> = reader
                    .0
                    .chunks_exact(4)
                    .map(|four| f32::from_le_bytes(four.try_into().unwrap()))
                    .collect();
                let ([whole, _], channels): &mut ([usize; 2], HashMap<String, Vec<f32>>) =
                    pictures.get_mut(&name).expect("made before it is filled");
                for ((name, offset), stride) in names.iter().zip(offsets).zip(strides) {
                    let channel = channels.get_mut(name).expect("a known channel");
                    for pixel in 0..width * height {
                        let place = (y + pixel / width) * *whole + x + pixel % width;
                        channel[place] = floats[offset + pixel * stride];
                    }
                }
            }
            other => panic!("operation {other}"),
        }
    }
    (pictures, updates)
}

#[test]
fn a_viewer_gets_the_picture() {
    let shop = Workshop::new();
    let scene = shop.scene(SCENE);
    let listener = TcpListener::bind("127.0.0.1:0").expect("a free port");
    let address = listener.local_addr().expect("bound").to_string();
    let viewer = std::thread::spawn(move || {
        let (mut stream, _) = listener.accept().expect("the program connects");
        viewed(&mut stream)
    });
    let output = shop.path("a.exr");
    // Long enough for updates before the end.
    let options = ["--display-server", &address, "--spp", "2000", "--size", "64x48"];
    assert_success(&render(&scene, std::slice::from_ref(&output), &options));
    let (pictures, updates) = viewer.join().expect("the viewer understands");
    let [(name, (size, channels))] = &pictures.into_iter().collect::<Vec<_>>()[..] else {
        panic!("one picture")
    };
    assert!(name.contains("scene.xml"), "{name}");
    assert_eq!(*size, [64, 48]);
    assert!(updates > 1, "only the end was sent");
    let file = exr(&output);
    for name in ["R", "G", "B"] {
        let Samples::Float(samples) = &file.channel(name).expect("a colour").samples else {
            panic!("floats")
        };
        assert!(&channels[name] == samples, "{name}");
    }
}

#[test]
fn a_viewer_that_takes_nothing_is_told() {
    let shop = Workshop::new();
    let scene = shop.scene(SCENE);
    let listener = TcpListener::bind("127.0.0.1:0").expect("a free port");
    let address = listener.local_addr().expect("bound").to_string();
    // More than the system keeps for a reader: 14 MB.
    let options = ["--display-server", &address, "--spp", "1", "--size", "1200x1000"];
    let done = render(&scene, &[shop.path("a.exr")], &options);
    assert_success(&done);
    let said = String::from_utf8_lossy(&done.stderr);
    let words = format!("warning: the display server {address} gets nothing more: it took nothing for 2 seconds");
    assert!(said.contains(&words), "{said}");
    drop(listener);
}

#[test]
fn a_viewer_that_is_not_there_does_not_stop_the_render() {
    let shop = Workshop::new();
    let scene = shop.scene(SCENE);
    let free = TcpListener::bind("127.0.0.1:0").expect("a free port");
    let address = free.local_addr().expect("bound").to_string();
    drop(free);
    for address in [address.as_str(), "no-such-host.invalid:1"] {
        let output = shop.path("a.png");
        let done = render(&scene, std::slice::from_ref(&output), &["--display-server", address]);
        assert_success(&done);
        let said = String::from_utf8_lossy(&done.stderr);
        assert!(
            said.contains(&format!("warning: the display server {address} cannot be reached")),
            "{said}"
        );
        std::fs::remove_file(output).expect("the picture is there");
    }
    let nonsense = render(&scene, &[shop.path("a.png")], &["--display-server", "nonsense"]);
    assert_eq!(nonsense.status.code(), Some(2));
    // One that goes away at once.
    let listener = TcpListener::bind("127.0.0.1:0").expect("a free port");
    let address = listener.local_addr().expect("bound").to_string();
    let viewer = std::thread::spawn(move || drop(listener.accept().expect("the program connects")));
    let options = ["--display-server", &address, "--spp", "2000"];
    assert_success(&render(&scene, &[shop.path("b.exr")], &options));
    viewer.join().expect("it only closes");
}
