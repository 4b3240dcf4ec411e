//! Frames of an animation from the command line.

use std::path::Path;
use std::process::Output;

use glam::Vec3;
use sunroom::render::image_io::exr::decode_exr;
use sunroom::render::layered_image::LayeredImage;
use sunroom::texture::load_image;

use crate::workshop::{Workshop, sunroom};

/// A view of two units along each axis, down -z, onto what `shapes` says before a white sky.
fn scene(shapes: &str) -> String {
    format!(
        r#"<scene version="3.0.0">
  <integrator type="path"><integer name="max_depth" value="3"/></integrator>
  <sensor type="orthographic">
    <transform name="to_world"><lookat origin="0, 0, 5" target="0, 0, 0" up="0, 1, 0"/></transform>
    <film type="hdrfilm"><integer name="width" value="32"/><integer name="height" value="32"/><rfilter type="box"/></film>
    <sampler type="independent"><integer name="sample_count" value="64"/></sampler>
  </sensor>
  <emitter type="constant"><rgb name="radiance" value="1, 1, 1"/></emitter>
  {shapes}
</scene>
"#
    )
}

fn render(scene: &Path, output: &Path, more: &[&str]) -> Output {
    let mut command = sunroom();
    command
        .arg("render")
        .arg(scene)
        .arg("-o")
        .arg(output)
        .arg("-q")
        .args(more);
    command.output().expect("the program starts")
}

#[track_caller]
fn assert_code(output: &Output, code: i32) {
    let messages = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(code), "{messages}");
}

/// The bits of all colours. Files of different scenes differ in the scene's name.
fn bits(path: &Path) -> Vec<[u32; 3]> {
    let bytes = std::fs::read(path).expect("the image is there");
    let image = load_image(&bytes).expect("the image can be read");
    let row = |y| (0..image.width()).map(move |x| (x, y));
    let places = (0..image.height()).flat_map(row);
    places
        .map(|(x, y)| image.pixel(x, y).to_array().map(f32::to_bits))
        .collect()
}

fn pixel(path: &Path, x: u32, y: u32) -> Vec3 {
    let bytes = std::fs::read(path).expect("the image is there");
    load_image(&bytes).expect("the image can be read").pixel(x, y)
}

const MOVING: &str = r#"<bsdf type="diffuse" id="red"><rgb name="reflectance" value="0.8, 0.1, 0.1"/></bsdf>
  <shape type="sphere"><float name="radius" value="0.3"/><ref id="red"/>
    <animation name="to_world" interpolation="ease">
      <transform time="0"><translate x="-0.5"/></transform>
      <transform time="0.125"><translate x="0.5"/></transform>
    </animation>
  </shape>
  <shape type="sphere"><point name="center" x="0" y="0.5" z="0"/>
    <animation name="radius"><float time="0" value="0.1"/><float time="0.125" value="0.4"/></animation>
    <bsdf type="diffuse">
      <animation name="reflectance"><rgb time="0" value="0.9, 0.9, 0.1"/><rgb time="0.125" value="0.1, 0.1, 0.9"/></animation>
    </bsdf>
  </shape>
  <shape type="rectangle"><transform name="to_world"><scale value="3"/><translate z="-1"/></transform></shape>"#;

#[test]
fn files_without_layers_are_told_of_once() {
    let shop = Workshop::new();
    let scene = shop.scene(&scene(MOVING));
    let options = ["--frames", "1..3", "--spp", "1", "--aov", "depth"];
    let output = render(&scene, &shop.path("a-##.png"), &options);
    assert_code(&output, 0);
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(said.matches("has no layers").count(), 1, "{said}");
    assert!(said.contains("a-##.png has no layers"), "{said}");
    assert!(shop.path("a-03.png").exists());
}

#[test]
fn a_frame_alone_has_the_bits_that_it_has_in_the_sequence() {
    let shop = Workshop::new();
    let path = shop.scene(&scene(MOVING));
    let options = ["--spp", "8", "--shutter", "0.5"];
    let all = render(
        &path,
        &shop.path("all-##.exr"),
        &[&options[..], &["--frames", "0..3"]].concat(),
    );
    assert_code(&all, 0);
    let names = ["all-00.exr", "all-01.exr", "all-02.exr", "all-03.exr"];
    let pictures = names.map(|name| std::fs::read(shop.path(name)).expect(name));
    assert!(pictures[0] != pictures[1] && pictures[1] != pictures[2]);
    let more = ["--frames", "2", "--threads", "1"];
    assert_code(
        &render(&path, &shop.path("alone.exr"), &[&options[..], &more].concat()),
        0,
    );
    assert!(std::fs::read(shop.path("alone-0002.exr")).expect("the frame") == pictures[2]);
    // A scene that says the moment itself gives the same picture.
    let at_rest = render(&path, &shop.path("still.exr"), &["--spp", "8", "--frames", "0"]);
    assert_code(&at_rest, 0);
    let first_moment = shop.write("first.xml", scene(&MOVING.replace("time=\"0.125\"", "time=\"1000\"")));
    assert_code(&render(&first_moment, &shop.path("first.exr"), &["--spp", "8"]), 0);
    assert!(bits(&shop.path("still-0000.exr")) == bits(&shop.path("first.exr")));
}

/// A black square of half the view's width goes through the view in the time of frame 0 at one frame a second, at two
/// units a second.
const BLACK_BAND: &str = r#"<shape type="rectangle"><bsdf type="diffuse"><rgb name="reflectance" value="0"/></bsdf>
    <animation name="to_world">
      <transform time="0"><scale x="0.25" y="2"/><translate x="-1"/></transform>
      <transform time="1"><scale x="0.25" y="2"/><translate x="1"/></transform>
    </animation>
  </shape>"#;

#[test]
fn frames_say_how_far_things_have_moved_since_the_frame_before() {
    let shop = Workshop::new();
    // Two units a second are half a unit, or eight pixels, from frame to frame.
    let path = shop.scene(&scene(BLACK_BAND));
    let read = |name: &str, more: &[&str]| {
        assert_code(&render(&path, &shop.path(name), &[&["--spp", "8"], more].concat()), 0);
        let name = if more.contains(&"--frames") {
            "motion-0002.exr"
        } else {
            name
        };
        decode_exr(&std::fs::read(shop.path(name)).expect(name)).expect("an EXR file")
    };
    let frame = ["--frames", "2", "--fps", "4"];
    let value = |image: &LayeredImage, channel: &str, x: usize| {
        let channel = image.channel(channel).expect("a channel");
        channel.samples.value(16 * 32 + x)
    };
    for shutter in ["0", "0.25"] {
        let options = [&frame[..], &["--shutter", shutter]].concat();
        let plain = read("motion.exr", &options);
        let image = read("motion.exr", &[&options[..], &["--aov", "motion"]].concat());
        assert_eq!(image.layer(""), plain.layer(""), "the same bits with and without it");
        // The band is four pixels wide to either side of its middle, and moves by two while the shutter is open.
        for (x, expected) in [(4, 0.0), (16, 8.0), (17, 8.0), (28, 0.0)] {
            let found = value(&image, "Motion.X", x);
            assert!((found - expected).abs() < 1e-3, "{shutter}: {found} at {x}");
            assert!(value(&image, "Motion.Y", x).abs() < 1e-3);
        }
    }
    let still = read("still.exr", &["--aov", "motion"]);
    assert!((0..32).all(|x| value(&still, "Motion.X", x) == 0.0));
}

#[test]
fn a_shutter_shows_each_place_for_the_time_in_which_it_is_free() {
    let shop = Workshop::new();
    let path = shop.scene(&scene(BLACK_BAND));
    let blurred = ["--frames", "0", "--fps", "1", "--shutter", "1"];
    assert_code(&render(&path, &shop.path("blurred.exr"), &blurred), 0);
    // The band covers a place in the middle for a quarter of a second. The middle of the first column, 1/32 from the
    // edge of the view, is free once the band's end has come from -1.25 to -31/32.
    let blurred = shop.path("blurred-0000.exr");
    for (x, expected) in [(10, 0.75), (16, 0.75), (22, 0.75), (0, 1.0 - 9.0 / 64.0)] {
        let found = (0..32).map(|y| pixel(&blurred, x, y).x).sum::<f32>() / 32.0;
        // Each row is off by a sample of the 64 where one of the band's ends is within the pixel, to either side.
        assert!((found - expected).abs() <= 0.5 / 64.0, "{x}: {found}");
    }
    // The same from the camera's own times, and a closed shutter sees one moment.
    let with_times = scene(BLACK_BAND).replace(
        "<film ",
        "<float name=\"shutter_open\" value=\"0\"/><float name=\"shutter_close\" value=\"1\"/><film ",
    );
    let own = shop.write("own.xml", with_times);
    assert_code(
        &render(&own, &shop.path("own.exr"), &["--frames", "0", "--fps", "1"]),
        0,
    );
    assert!(bits(&shop.path("own-0000.exr")) == bits(&blurred));
    assert_code(
        &render(
            &own,
            &shop.path("sharp.exr"),
            &["--frames", "0", "--fps", "1", "--shutter", "0"],
        ),
        0,
    );
    assert_eq!(pixel(&shop.path("sharp-0000.exr"), 0, 16), Vec3::ZERO);
    assert_eq!(pixel(&shop.path("sharp-0000.exr"), 16, 16), Vec3::ONE);
}

#[test]
fn a_turntable_goes_once_around_what_the_camera_looks_at() {
    let shop = Workshop::new();
    let square = |color: &str, turn: &str| {
        format!(
            "<shape type=\"rectangle\"><transform name=\"to_world\"><translate z=\"0.1\"/>{turn}</transform>\
             <emitter type=\"area\"><rgb name=\"radiance\" value=\"{color}\"/></emitter></shape>"
        )
    };
    let back = "<rotate y=\"1\" angle=\"180\"/>";
    let path = shop.scene(&scene(&(square("1, 0, 0", "") + &square("0, 0, 1", back))));
    let output = render(
        &path,
        &shop.path("turn.exr"),
        &["--spp", "4", "--frames", "10..13", "--turntable"],
    );
    assert_code(&output, 0);
    let middle = |frame: u32| pixel(&shop.path(&format!("turn-00{frame}.exr")), 16, 16);
    assert_eq!((middle(10), middle(12)), (Vec3::X, Vec3::Z));
    // From the side the squares are lines, with the sky between.
    assert_eq!((middle(11), middle(13)), (Vec3::ONE, Vec3::ONE));
    // One of four frames alone.
    let output = render(
        &path,
        &shop.path("turn.exr"),
        &["--spp", "4", "--frames", "2", "--turntable=4"],
    );
    assert_code(&output, 0);
    assert_eq!(pixel(&shop.path("turn-0002.exr"), 16, 16), Vec3::Z);
}

#[test]
fn wrong_frames_are_wrong_usage() {
    let shop = Workshop::new();
    let path = shop.scene(&scene(""));
    for options in [
        &["--frames", "3..1"][..],
        &["--frames", "a"],
        &["--frames", "1", "--fps", "0"],
        &["--frames", "1", "--shutter", "2"],
        &["--turntable"],
        &["--frames", "1", "--turntable=0"],
        &["--frames", "1", "--turntable"],
        &["--shutter", "0.5"],
    ] {
        assert_code(&render(&path, &shop.path("a.exr"), options), 2);
    }
    assert_code(&render(&path, Path::new("-"), &["--frames", "0..1"]), 2);
}
