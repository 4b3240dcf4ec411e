//! Files of curves, from the scene's file to pictures, messages, saved scenes and glTF.

use sunroom::geometry::mesh::MeshData;
use sunroom::scene::assets::triangle_mesh::load_mesh;

use crate::workshop::Workshop;

/// A straight spline along x from -2 to 2, and one of a single segment beside it.
const SPLINES: &str = "-3 0 0 .1\n-2 0 0 .1\n-1 0 0 .1\n0 0 0 .1\n1 0 0 .1\n2 0 0 .1\n3 0 0 .1\n\n\
                       -1 2 0 .1\n0 2 0 .1\n1 2 0 .1\n2 2 0 .1\n";

/// A view along -z, eight units wide and high, of black shapes before a white sky.
fn scene(shapes: &str) -> String {
    format!(
        "<scene version='3.0.0'><integrator type='path'/>
        <sensor type='orthographic'><transform name='to_world'><scale x='4' y='4'/><lookat origin='0,0,9' target='0,0,0' up='0,1,0'/></transform>
          <film type='hdrfilm'><integer name='width' value='64'/><integer name='height' value='64'/><rfilter type='box'/></film></sensor>
        <emitter type='constant'/>{shapes}</scene>"
    )
}

fn curves(plugin: &str, inside: &str) -> String {
    format!(
        "<shape type='{plugin}'><string name='filename' value='curves.txt'/>{inside}
        <bsdf type='diffuse'><rgb name='reflectance' value='0'/></bsdf></shape>"
    )
}

impl Workshop {
    /// The area that shapes cover in the view, in square units.
    #[track_caller]
    fn covered(&self, shapes: &str) -> f32 {
        self.put("scene.xml", scene(shapes));
        self.covered_in("scene.xml")
    }

    /// The area that shapes cover in the view of a file's scene, in square units.
    #[track_caller]
    fn covered_in(&self, file: &str) -> f32 {
        self.done(&[
            "render",
            file,
            "-o",
            "picture.exr",
            "-q",
            "--spp",
            "64",
            "--size",
            "64x64",
        ]);
        let image = sunroom::texture::load_image(&self.read("picture.exr")).expect("a picture");
        let sky = image.pixel(0, 0).x;
        let pixels = (0..64).flat_map(|y| (0..64).map(move |x| (x, y)));
        pixels.map(|(x, y)| 1.0 - image.pixel(x, y).x / sky).sum::<f32>() / 64.0
    }

    /// What the program says of the scene.
    fn said(&self, shapes: &str) -> String {
        self.put("scene.xml", scene(shapes));
        String::from_utf8_lossy(&self.sunroom(&["check", "scene.xml"]).stderr).into_owned()
    }

    fn with_curves(text: &str) -> Self {
        let workshop = Self::new();
        workshop.put("curves.txt", text);
        workshop
    }
}

#[test]
fn transforms_move_control_points_and_leave_radii() {
    let workshop = Workshop::with_curves(SPLINES);
    let cases = [
        ("bsplinecurve", "", 0.2 * (4.0 + 1.0)),
        // Lines end with half a sphere.
        ("linearcurve", "", 0.2 * (6.0 + 3.0) + 2.0 * std::f32::consts::PI * 0.01),
        ("bsplinecurve", "<scale value='0.5'/>", 0.2 * (2.0 + 0.5)),
        ("bsplinecurve", "<scale x='0.5' y='-0.2' z='7'/>", 0.2 * (2.0 + 0.5)),
        ("bsplinecurve", "<rotate z='1' angle='90'/>", 0.2 * (4.0 + 1.0)),
    ];
    for (plugin, transform, expected) in cases {
        let transform = format!("<transform name='to_world'>{transform}</transform>");
        let found = workshop.covered(&curves(plugin, &transform));
        assert!(
            (found - expected).abs() < 0.02 * expected,
            "{plugin} {transform}: {found}, not {expected}"
        );
    }
    // An instance scales the cross-sections of its group as well.
    let group = format!("<shape type='shapegroup' id='g'>{}</shape>", curves("bsplinecurve", ""));
    let instance =
        "<shape type='instance'><ref id='g'/><transform name='to_world'><scale x='0.5' y='1.5'/></transform></shape>";
    let found = workshop.covered(&[group.as_str(), instance].concat());
    let expected = 0.2 * 1.5 * (2.0 + 0.5);
    assert!((found - expected).abs() < 0.02 * expected, "{found}, not {expected}");
}

#[test]
fn what_is_wrong_with_a_file_is_told_with_its_line() {
    for (text, plugin, expected) in [
        (
            "0 0 0 1\n1 0 0 x\n",
            "linearcurve",
            "line 2: expected a control point `x y z radius`, found `1 0 0 x`",
        ),
        (
            "0 0 0 1\n1 0 0 1\n",
            "bsplinecurve",
            "line 1: expected a curve of 4 control points or more, found one of 2",
        ),
        (
            "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n",
            "linearcurve",
            "the file holds no curves",
        ),
        (SPLINES, "obj", "the file holds curves, not triangles"),
    ] {
        let said = Workshop::with_curves(text).said(&curves(plugin, ""));
        assert!(said.contains(expected) && said.contains("error"), "{said}");
    }
    let said = Workshop::new().said(&curves("linearcurve", ""));
    assert!(said.contains("curves.txt"), "{said}");
    let workshop = Workshop::with_curves(SPLINES);
    let said = workshop.said(&curves("linearcurve", "<emitter type='area'/>"));
    assert!(said.contains("cannot be an emitter"), "{said}");
    let said = workshop.said(&curves("linearcurve", ""));
    assert!(said.contains("no errors") && !said.contains("warning"), "{said}");
}

#[test]
fn curves_are_saved_as_they_were_read() {
    let workshop = Workshop::with_curves(SPLINES);
    workshop.put("scene.xml", scene(&curves("bsplinecurve", "")));
    workshop.done(&["convert", "scene.xml", "--portable", "written.xml"]);
    let text = String::from_utf8(workshop.read("written.xml")).expect("text");
    assert!(
        text.contains("type=\"bsplinecurve\"") && text.contains("curves.txt"),
        "{text}"
    );
    assert!(
        !text.contains("face_normals") && !text.contains("flip_tex_coords"),
        "{text}"
    );
}

#[test]
fn gltf_has_tubes_in_place_of_curves() {
    let workshop = Workshop::with_curves(SPLINES);
    let scaled = "<transform name='to_world'><scale value='0.5'/></transform>";
    workshop.put("scene.xml", scene(&curves("bsplinecurve", scaled)));
    let output = workshop.sunroom(&["convert", "scene.xml", "scene.glb"]);
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success() && said.contains("tubes of triangles"), "{said}");
    let found = workshop.covered_in("scene.glb");
    let expected = 0.2 * (2.0 + 0.5);
    // A polygon of eight corners is from 92 % to 100 % as wide as its circle.
    assert!(
        (0.9 * expected..1.02 * expected).contains(&found),
        "{found}, not {expected}"
    );
}

#[test]
fn a_file_of_curves_is_a_mesh_without_triangles() {
    let workshop = Workshop::with_curves(SPLINES);
    let mesh = load_mesh(&workshop.path("curves.txt"), &sunroom::files::Access::everywhere()).expect("it is good");
    let data: &MeshData = mesh.data(0).expect("one shape");
    assert_eq!(
        (
            data.triangles.len(),
            data.strands.firsts.len(),
            data.strands.points.len()
        ),
        (0, 2, 11)
    );
}
