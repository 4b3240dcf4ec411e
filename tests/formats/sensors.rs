//! Sensors and films from the file to the camera rays, and back into a file.

use std::path::Path;

use bevy::prelude::*;
use glam::Vec2;
use sunroom::app::headless::headless;
use sunroom::document::{self, Severity};
use sunroom::engine::{Limits, PackedScene, load_to_completion};
use sunroom::files::ExrCompression;
use sunroom::render::view::View;
use sunroom::scene::read::read;
use sunroom::scene::write::to_document;
use sunroom::scene::*;

const POSE: &str = "<lookat origin='1, 2, 5' target='0.5, 0.3, 0' up='0, 1, 0.1'/></transform>";
const CLIP: &str = "<float name='near_clip' value='0.5'/><float name='far_clip' value='20'/>";
const CROP: &str = "<integer name='crop_offset_x' value='10'/><integer name='crop_offset_y' value='3'/>
    <integer name='crop_width' value='12'/><integer name='crop_height' value='20'/>";

fn film(content: &str) -> String {
    format!(
        "<film type='hdrfilm'><integer name='width' value='40'/><integer name='height' value='24'/>{content}</film>"
    )
}

fn describe(body: &str) -> (SceneDescription, Vec<String>) {
    let text = format!("<scene version='3.0.0'>{body}</scene>");
    let mut document = document::parse_str(&*text, Path::new("/there/scene.xml"), &[]);
    let scene = read(&mut document);
    let complaints = document.diagnostics.list.iter();
    let complaints = complaints.map(|one| {
        format!(
            "{}{}",
            if one.severity == Severity::Error { "error: " } else { "" },
            one.message
        )
    });
    (scene, complaints.collect())
}

fn clean(body: &str) -> SceneDescription {
    let (scene, complaints) = describe(body);
    assert!(complaints.is_empty(), "{complaints:?}");
    scene
}

fn app(body: &str) -> App {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("scene.xml");
    std::fs::write(&path, format!("<scene version='3.0.0'>{body}</scene>")).expect("writable");
    let mut app = headless(
        OpenScene {
            path,
            defines: Vec::new(),
            ..OpenScene::default()
        },
        Some(1),
    );
    assert!(load_to_completion(&mut app, &Limits::default()).expect("loads"));
    app
}

fn view_of(body: &str) -> View {
    let app = app(body);
    let packed = app.world().resource::<PackedScene>();
    packed.view.clone().expect("a camera")
}

/// Film and lens coordinates, and the ray's origin, direction and length that Mitsuba 3.9.1's `sample_ray` gives there.
type KnownRay = ([f32; 2], [f32; 2], [f32; 3], [f32; 3], f32);

#[test]
fn rays_are_those_of_mitsuba() {
    let sensor = |plugin: &str, content: &str, scale: &str, crop: &str| {
        let film = film(crop);
        format!("<sensor type='{plugin}'>{content}{CLIP}<transform name='to_world'>{scale}{POSE}{film}</sensor>")
    };
    let shift = "<string name='focal_length' value='35mm'/><float name='principal_point_offset_x' value='0.2'/>
        <float name='principal_point_offset_y' value='-0.1'/>";
    let lens = "<float name='fov' value='30'/><float name='aperture_radius' value='0.4'/>
        <float name='focus_distance' value='6'/><float name='shutter_close' value='1'/>";
    let smaller = "<float name='fov' value='50'/><string name='fov_axis' value='smaller'/>";
    let cases: [(String, [KnownRay; 2]); 5] = [
        (
            sensor("orthographic", "", "<scale x='3' y='2' z='1.5'/>", ""),
            [
                (
                    [0.1, 0.8],
                    [0.3, 0.9],
                    [-1.42706, 1.05295, 4.769],
                    [-0.0942558, -0.32047, -0.942558],
                    19.5,
                ),
                (
                    [0.75, 0.3],
                    [0.6, 0.2],
                    [2.40076, 2.22975, 3.9861],
                    [-0.0942558, -0.32047, -0.942558],
                    19.5,
                ),
            ],
        ),
        (
            sensor("orthographic", "", "<scale value='2.5'/>", CROP),
            [
                (
                    [0.1, 0.8],
                    [0.3, 0.9],
                    [-0.174551, 0.759284, 4.21312],
                    [-0.0942558, -0.32047, -0.942558],
                    19.5,
                ),
                (
                    [0.75, 0.3],
                    [0.6, 0.2],
                    [0.741838, 1.95333, 3.71551],
                    [-0.0942558, -0.32047, -0.942558],
                    19.5,
                ),
            ],
        ),
        (
            sensor("perspective", smaller, "", CROP),
            [
                (
                    [0.1, 0.8],
                    [0.3, 0.9],
                    [0.788618, 1.70918, 4.58955],
                    [-0.387396, -0.532983, -0.752233],
                    21.2803,
                ),
                (
                    [0.75, 0.3],
                    [0.6, 0.2],
                    [0.931058, 1.89478, 4.5122],
                    [-0.136855, -0.208877, -0.968319],
                    19.6467,
                ),
            ],
        ),
        (
            sensor("perspective", shift, "", CROP),
            [
                (
                    [0.1, 0.8],
                    [0.3, 0.9],
                    [0.944932, 1.78192, 4.54918],
                    [-0.109303, -0.432854, -0.894813],
                    19.6487,
                ),
                (
                    [0.75, 0.3],
                    [0.6, 0.2],
                    [1.04207, 1.90849, 4.49643],
                    [0.0819233, -0.178187, -0.98058],
                    20.028,
                ),
            ],
        ),
        (
            sensor("thinlens", lens, "", CROP),
            [
                (
                    [0.1, 0.8],
                    [0.3, 0.9],
                    [0.996321, 2.0526, 4.45201],
                    [-0.221372, -0.448602, -0.865882],
                    19.8823,
                ),
                (
                    [0.75, 0.3],
                    [0.6, 0.2],
                    [0.897791, 1.65686, 4.59642],
                    [-0.100339, -0.245072, -0.964299],
                    19.5606,
                ),
            ],
        ),
    ];
    for (text, rays) in cases {
        let view = view_of(&text);
        let size = if text.contains("crop_width") {
            (12, 20)
        } else {
            (40, 24)
        };
        assert_eq!((view.width, view.height), size);
        for (place, aperture, origin, dir, length) in rays {
            let ray = view.camera.ray(Vec2::from(place), Vec2::from(aperture));
            // Six digits, and single precision on both sides.
            let start = ray.at(ray.t_min);
            assert!(start.abs_diff_eq(origin.into(), 2e-5), "{text} {place:?}: {ray:?}");
            assert!(ray.dir.abs_diff_eq(dir.into(), 2e-6), "{text} {place:?}: {ray:?}");
            assert!(
                (ray.t_max - ray.t_min - length).abs() < 2e-4,
                "{text} {place:?}: {ray:?}"
            );
        }
    }
}

#[test]
fn what_is_written_is_read_again() {
    let thin = "<float name='aperture_radius' value='0.25'/><integer name='blades' value='6'/>
        <float name='blade_rotation' value='15'/><float name='focus_distance' value='3'/>";
    let filters = [
        "<rfilter type='box'/>",
        "<rfilter type='tent'><float name='radius' value='1.5'/></rfilter>",
        "<rfilter type='gaussian'><float name='stddev' value='0.75'/></rfilter>",
        "<rfilter type='mitchell'><float name='B' value='0.5'/><float name='C' value='0.25'/></rfilter>",
        "<rfilter type='catmullrom'/>",
        "<rfilter type='lanczos'><integer name='lobes' value='2'/></rfilter>",
    ];
    let lenses = [("perspective", ""), ("thinlens", thin), ("orthographic", "")];
    for (plugin, content) in lenses {
        for filter in filters {
            let film = film(&format!("{CROP}{filter}"));
            let scene = clean(&format!(
                "<sensor type='{plugin}'>{content}<float name='principal_point_offset_x' value='0.125'/>
                 <transform name='to_world'><scale x='2' y='3'/>{POSE}{film}</sensor>"
            ));
            let mut made = scene.clone();
            // As if it had been made in the editor: nothing of the file is left to copy.
            made.sensors[0].identity = Default::default();
            let text = document::to_xml(&to_document(&made, Path::new("/there/scene.xml"))).expect("can be written");
            let body = text
                .split_once("3.0.0\">")
                .and_then(|(_, body)| body.split_once("</scene>"));
            let again = clean(body.expect("a scene").0);
            let (one, other) = (&scene.sensors[0], &again.sensors[0]);
            assert_eq!((one.film, one.sensor.lens), (other.film, other.sensor.lens), "{text}");
            assert_eq!(one.sensor.principal_point_offset, other.sensor.principal_point_offset);
            assert!(one.to_world.abs_diff_eq(other.to_world, 1e-5), "{text}");
        }
    }
    assert_eq!(
        clean(&format!("<sensor type='perspective'>{}</sensor>", film(filters[3]))).sensors[0]
            .film
            .filter,
        ReconstructionFilter::Mitchell { b: 0.5, c: 0.25 }
    );
}

#[test]
fn films_say_in_which_kind_of_file_they_are_stored() {
    for (name, format) in PictureFormat::NAMES {
        let content = film(&format!("<string name='file_format' value='{name}'/>"));
        let mut scene = clean(&format!("<sensor type='perspective'>{content}</sensor>"));
        assert_eq!(scene.sensors[0].film.storage.file, Some(format));
        scene.sensors[0].identity = Default::default();
        let text = document::to_xml(&to_document(&scene, Path::new("/there/scene.xml"))).expect("can be written");
        assert!(
            text.contains(&format!(r#""file_format" value="{}""#, format.name())),
            "{text}"
        );
    }
    let unknown = film("<string name='file_format' value='png'/>");
    let (_, complaints) = describe(&format!("<sensor type='perspective'>{unknown}</sensor>"));
    assert!(
        complaints.len() == 1 && complaints[0].contains("`png` is not supported"),
        "{complaints:?}"
    );
}

#[test]
fn films_say_how_their_files_are_made_smaller() {
    for compression in ExrCompression::ALL {
        let name = compression.name();
        let content = film(&format!("<string name='compression' value='{name}'/>"));
        let mut scene = clean(&format!("<sensor type='perspective'>{content}</sensor>"));
        assert_eq!(scene.sensors[0].film.storage.compression, Some(compression));
        scene.sensors[0].identity = Default::default();
        let text = document::to_xml(&to_document(&scene, Path::new("/there/scene.xml"))).expect("can be written");
        assert!(text.contains(&format!(r#""compression" value="{name}""#)), "{text}");
    }
    let unknown = film("<string name='compression' value='lzw'/>");
    let (scene, complaints) = describe(&format!("<sensor type='perspective'>{unknown}</sensor>"));
    assert_eq!(scene.sensors[0].film.storage.compression, None);
    assert!(
        complaints.len() == 1 && complaints[0].contains("`lzw` is not supported"),
        "{complaints:?}"
    );
}

#[test]
fn complaints_about_films_are_at_the_parameter_and_say_where_it_belongs() {
    let complaint = |content: &str| {
        let film = format!("<film type='hdrfilm'>\n{content}</film>");
        let text = format!("<scene version='3.0.0'><sensor type='perspective'>{film}</sensor></scene>");
        let mut document = document::parse_str(&*text, Path::new("/there/scene.xml"), &[]);
        read(&mut document);
        let [one] = &document.diagnostics.list[..] else {
            panic!("{content}: {:?}", document.diagnostics.list);
        };
        let (_, line, _) = document.diagnostics.locate(one.span.expect("a place")).expect("a file");
        (line, one.message.clone(), one.help.clone().unwrap_or_default())
    };
    for (name, value) in [
        ("pixel_format", "cmyk"),
        ("compression", "lzw"),
        ("file_format", "png"),
        ("component_format", "uint32"),
    ] {
        let (line, message, _) = complaint(&format!("<string name='{name}' value='{value}'/>"));
        assert!(message.contains(&format!("`{value}` is not supported")), "{message}");
        assert_eq!(line, 2, "{message}");
    }
    for parameter in ["noise_target", "sample_count"] {
        let (line, message, help) = complaint(&format!("<float name='{parameter}' value='1'/>"));
        let expected = format!("`{parameter}` is not a parameter of film `hdrfilm`");
        assert_eq!(
            (line, message, help.as_str()),
            (2, expected, "it is a parameter of the sampler")
        );
    }
}

#[test]
fn films_say_how_they_are_stored() {
    for pixels in PixelFormat::ALL {
        for components in ComponentFormat::ALL {
            let content = format!(
                "<string name='pixel_format' value='{}'/><string name='component_format' value='{}'/>",
                pixels.name(),
                components.name()
            );
            let mut scene = clean(&format!("<sensor type='perspective'>{}</sensor>", film(&content)));
            let storage = FilmStorage {
                pixels: Some(pixels),
                components: Some(components),
                file: None,
                compression: None,
            };
            assert_eq!(scene.sensors[0].film.storage, storage);
            // Written as if it had been made in the editor.
            scene.sensors[0].identity = Default::default();
            let text = document::to_xml(&to_document(&scene, Path::new("/there/scene.xml"))).expect("can be written");
            assert!(
                text.contains(pixels.name()) && text.contains(components.name()),
                "{text}"
            );
        }
    }
    let unknown = film("<string name='component_format' value='uint32'/>");
    let (scene, complaints) = describe(&format!("<sensor type='perspective'>{unknown}</sensor>"));
    assert_eq!(scene.sensors[0].film.storage, FilmStorage::default());
    assert!(
        complaints.len() == 1
            && complaints[0].contains("`uint32` is not supported")
            && complaints[0].contains("`float16`"),
        "{complaints:?}"
    );
}

#[test]
fn what_cannot_be_is_an_error() {
    let table = [
        ("<integer name='crop_width' value='41'/>", "reaches out of the film"),
        ("<integer name='crop_offset_y' value='24'/>", "reaches out of the film"),
        ("<integer name='crop_height' value='0'/>", "crop_height"),
        ("<integer name='crop_offset_x' value='-1'/>", "crop_offset_x"),
        (
            "<rfilter type='lanczos'><integer name='lobes' value='0'/></rfilter>",
            "lobes",
        ),
        (
            "<rfilter type='tent'><float name='radius' value='0'/></rfilter>",
            "radius",
        ),
    ];
    for (content, part) in table {
        let (_, complaints) = describe(&format!("<sensor type='perspective'>{}</sensor>", film(content)));
        assert!(
            complaints.len() == 1 && complaints[0].starts_with("error: "),
            "{complaints:?}"
        );
        assert!(complaints[0].contains(part), "{complaints:?}");
    }
    let (_, complaints) = describe("<sensor type='orthographic'><float name='fov' value='30'/></sensor>");
    assert!(complaints.len() == 1 && complaints[0].contains("fov"), "{complaints:?}");
}

#[test]
fn cameras_have_names_and_indices() {
    let mut app = app(
        "<sensor type='perspective' id='front'/><sensor type='orthographic' id='1'/><sensor type='thinlens' id='top'>
        <float name='aperture_radius' value='0.1'/></sensor>",
    );
    let world = app.world_mut();
    let all = cameras(world);
    assert_eq!(
        all.iter().map(|(_, name)| name.as_str()).collect::<Vec<_>>(),
        ["front", "1", "top"]
    );
    for (wanted, place) in [("front", 0), ("top", 2), ("0", 0), ("2", 2), ("1", 1)] {
        assert_eq!(find_camera(world, wanted), Ok(all[place].0), "{wanted}");
    }
    let message = find_camera(world, "back").expect_err("there is none").to_string();
    assert!(
        message.contains("`back`") && message.contains("there are 0: front, 1: 1, 2: top"),
        "{message}"
    );
    assert_eq!(world.resource::<ActiveSensor>().0, Some(all[0].0));
}
