//! What mesh files bring besides their triangles: the materials of an OBJ's library, and attributes.

use std::path::Path;

use bevy::prelude::*;
use sunroom::app::headless::render_only;
use sunroom::color::Rgb;
use sunroom::engine::{Limits, RenderFilm, RenderStatus, render_to_completion};
use sunroom::scene::OpenScene;

/// A square in the middle of the picture, one unit of it on either side.
const SQUARE: &str = "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nvn 0 0 1\n";

/// The colour in the middle of a shape's picture before a white sky, and the engine's messages.
fn seen(folder: &Path, shapes: &str) -> (Rgb, Vec<String>) {
    let text = format!(
        "<scene version='3.0.0'><integrator type='path'/>
        <sensor type='orthographic'><transform name='to_world'><scale value='0.5,0.5,1'/><lookat origin='0,0,4' target='0,0,0' up='0,1,0'/></transform>
          <film type='hdrfilm'><rfilter type='box'/></film></sensor>
        <emitter type='constant'/>{shapes}</scene>"
    );
    let path = folder.join("scene.xml");
    std::fs::write(&path, text).expect("writable");
    let open = OpenScene {
        path,
        ..OpenScene::default()
    };
    let mut app = render_only(open, Some(1));
    app.world_mut()
        .resource_mut::<sunroom::engine::RenderControl>()
        .film_size_override = Some(UVec2::new(16, 16));
    let limits = Limits {
        samples: Some(64),
        ..Limits::default()
    };
    render_to_completion(&mut app, &limits, |_| {}).expect("a picture");
    let film = &app.world().resource::<RenderFilm>().film;
    let pixels = film.radiance();
    let mean = pixels.iter().sum::<Rgb>() / pixels.len() as f32;
    (mean, app.world().resource::<RenderStatus>().errors.clone())
}

/// A square of an OBJ file with a library that has this.
fn with_library(library: &str) -> Rgb {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let at = |name: &str| folder.path().join(name);
    let face = "mtllib a.mtl\nusemtl m\nf 1/1/1 2/2/1 3/3/1 4/4/1\n";
    std::fs::write(at("a.obj"), [SQUARE, face].concat()).expect("writable");
    std::fs::write(at("a.mtl"), format!("newmtl m\n{library}")).expect("writable");
    // A lamp, and heights that rise along u by one in all, each of 16 x 1 texels.
    let lamp = [0.25f32, 2.0, 0.5].repeat(16);
    let heights = (0..16).flat_map(|x| [x as f32 / 16.0; 3]).collect::<Vec<_>>();
    // Normals that lean along u.
    let normals = [0.64f32, 0.5, 0.98].repeat(16);
    for (name, values) in [("lamp.pfm", lamp), ("heights.pfm", heights), ("normals.pfm", normals)] {
        let mut bytes = b"PF\n16 1\n-1.0\n".to_vec();
        bytes.extend(values.iter().flat_map(|value| value.to_le_bytes()));
        std::fs::write(at(name), bytes).expect("writable");
    }
    let shape = "<shape type='obj'><string name='filename' value='a.obj'/></shape>";
    let (color, errors) = seen(folder.path(), shape);
    assert_eq!(errors, [""; 0], "{library}");
    color
}

#[test]
fn d_and_tr_of_a_library_are_its_opacity() {
    for (library, expected) in [
        ("Kd 0 0 0\n", 0.0),
        ("Kd 0 0 0\nd 0.25\n", 0.75),
        ("Kd 0 0 0\nd 0.25\nillum 2\nNi 1.0\n", 0.75),
        ("Kd 0 0 0\nd 0.25\nillum 2\nNi 1.5\n", 0.75),
        ("Kd 0 0 0\nTr 0.75\n", 0.75),
        ("Kd 0 0 0\nd 0.25\nTr 0.1\n", 0.75),
        ("Kd 0 0 0\nd 0\n", 1.0),
        // Half of the light passes, and half of the rest is reflected.
        ("Kd 0.5 0.5 0.5\nd 0.5\n", 0.75),
    ] {
        let found = with_library(library);
        assert!((found - expected).abs().max_element() < 0.02, "{library}: {found}");
    }
}

#[test]
fn pictures_of_a_library_shine_and_bump() {
    let shining = with_library("Kd 0 0 0\nmap_Ke lamp.pfm\n");
    assert!(shining.abs_diff_eq(Rgb::new(0.25, 2.0, 0.5), 1e-3), "{shining}");
    // A white surface under an even sky loses what its normals send below it and into its shadow.
    let [flat, bumped, stronger] = ["", "bump -bm 2 heights.pfm\n", "map_Bump -bm 8 heights.pfm\n"]
        .map(|bump| with_library(&format!("Kd 1 1 1\n{bump}")).x);
    assert!((flat - 1.0).abs() < 1e-3, "{flat}");
    assert!(bumped < 0.9 && stronger < bumped - 0.1, "{bumped} {stronger}");
    // Some libraries name normals so.
    let [norm, bump] =
        ["norm", "map_Bump"].map(|keyword| with_library(&format!("Kd 1 1 1\n{keyword} normals.pfm\n")).x);
    assert!(norm < 0.99 && (norm - bump).abs() < 1e-6, "{norm} {bump}");
}

#[test]
fn an_attribute_that_a_mesh_does_not_have_is_a_warning() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    std::fs::write(folder.path().join("plain.obj"), [SQUARE, "f 1 2 3 4\n"].concat()).expect("writable");
    let coloured = SQUARE.replacen(" 0\n", " 0 0.5 0.25 1\n", 4);
    std::fs::write(folder.path().join("coloured.obj"), [&*coloured, "f 1 2 3 4\n"].concat()).expect("writable");
    let material = "<bsdf type='twosided'><bsdf type='diffuse'><texture type='mesh_attribute' name='reflectance'>
        <string name='name' value='vertex_color'/></texture></bsdf></bsdf>";
    let shape = |id: &str, file: &str, what: &str| {
        format!("<shape type='obj' id='{id}'><string name='filename' value='{file}'/>{what}</shape>")
    };
    let (color, errors) = seen(folder.path(), &shape("a", "coloured.obj", material));
    assert_eq!(errors, [""; 0]);
    assert!(color.abs_diff_eq(Rgb::new(0.5, 0.25, 1.0), 0.01), "{color}");

    let both = [shape("a", "plain.obj", material), shape("b", "plain.obj", material)].concat();
    let (color, errors) = seen(folder.path(), &both);
    assert_eq!(color, Rgb::ZERO);
    let [error] = &errors[..] else { panic!("{errors:?}") };
    assert!(
        error.starts_with("shape \"a\": its mesh ")
            && error.ends_with("plain.obj has no attribute `vertex_color`; 0 is taken for it, which is black"),
        "{error}"
    );
    // A lamp, and what is no mesh.
    let lamp = "<emitter type='area'><texture type='mesh_attribute' name='radiance'><string name='name' value='face_glow'/></texture></emitter>";
    let (_, errors) = seen(folder.path(), &shape("l", "plain.obj", lamp));
    assert!(errors.iter().any(|error| error.contains("`face_glow`")), "{errors:?}");
    // One inside of another.
    let inner = "<string name='name' value='vertex_color'/><texture type='mesh_attribute' name='times'><string name='name' value='face_glow'/></texture>";
    let within = material.replace("<string name='name' value='vertex_color'/>", inner);
    let (_, errors) = seen(folder.path(), &shape("a", "coloured.obj", &within));
    assert!(errors.iter().any(|error| error.contains("`face_glow`")), "{errors:?}");
    let (_, errors) = seen(
        folder.path(),
        &format!("<shape type='rectangle' id='r'>{material}</shape>"),
    );
    assert!(errors[0].starts_with("shape \"r\": it is no mesh"), "{errors:?}");
}
