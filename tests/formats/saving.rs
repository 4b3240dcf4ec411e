//! Scenes written over the text they were read from: what nobody touched stays to the byte.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use bevy::math::{Affine3A, Vec3};
use bevy::prelude::{Entity, With, World};
use sunroom::document;
use sunroom::layer::{Layer, Layers};
use sunroom::scene::description::{DeclarationPlace, Identity, MaterialDescription, ShapeDescription};
use sunroom::scene::read::read;
use sunroom::scene::spawn;
use sunroom::scene::write::{Extensions, files, save, save_description, write_anew};
use sunroom::scene::{
    DocumentOrder, EmitterKind, LengthUnit, LightUnits, Material, Roughness, SceneDescription, SceneId, Shape,
    ShapeKind, UsesMaterial,
};
use tempfile::TempDir;

/// A folder with scene files in it.
struct Folder(TempDir);

impl Folder {
    fn with(files: &[(&str, &str)]) -> Self {
        let folder = Self(tempfile::tempdir().unwrap());
        for (name, text) in files {
            let path = folder.path(name);
            std::fs::create_dir_all(path.parent().unwrap()).unwrap();
            std::fs::write(path, text).unwrap();
        }
        folder
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn text(&self, name: &str) -> String {
        std::fs::read_to_string(self.path(name)).unwrap()
    }

    fn read(&self, name: &str) -> SceneDescription {
        describe(&self.path(name))
    }

    /// The text of `main.xml` after an edit is saved over it.
    fn edited(&self, edit: impl FnOnce(&mut SceneDescription)) -> String {
        let mut scene = self.read("main.xml");
        edit(&mut scene);
        save_description(&scene, &self.path("main.xml")).unwrap();
        self.read("main.xml");
        self.text("main.xml")
    }
}

/// Fails if there is an error in it.
fn describe(path: &Path) -> SceneDescription {
    let mut document = document::load(path, &[]).unwrap();
    let scene = read(&mut document);
    assert!(!document.diagnostics.has_errors(), "{}", document.diagnostics);
    scene
}

/// A scene of `body`, edited and saved in place: the lines that are gone and those that came.
fn changes(body: &str, edit: impl FnOnce(&mut SceneDescription)) -> (Vec<String>, Vec<String>) {
    let text = format!("<scene version=\"3.0.0\">\n  <sensor type=\"perspective\"/>\n{body}\n</scene>\n");
    let folder = Folder::with(&[("main.xml", &text)]);
    difference(&text, &folder.edited(edit))
}

/// Lines in the one and not in the other, in order, each as often as it is missing there.
fn difference(old: &str, new: &str) -> (Vec<String>, Vec<String>) {
    let lacking = |some: &str, others: &str| {
        let mut others: Vec<&str> = others.split('\n').collect();
        let lines = some.split('\n').filter(|line| {
            let known = others.iter().position(|other| other == line);
            known.map(|place| others.remove(place)).is_none()
        });
        lines.map(str::to_owned).collect::<Vec<_>>()
    };
    (lacking(old, new), lacking(new, old))
}

fn lines(lines: &[&str]) -> Vec<String> {
    lines.iter().map(|&line| line.to_owned()).collect()
}

fn moved(by: Vec3) -> impl FnOnce(&mut SceneDescription) {
    move |scene| {
        let shape = &mut scene.shapes[0];
        shape.to_world = Affine3A::from_translation(by) * shape.to_world;
    }
}

fn set_reflectance(material: &mut Material, color: Vec3) {
    *material = Material::Diffuse {
        reflectance: color.into(),
    };
}

fn coloured(color: Vec3) -> impl FnOnce(&mut SceneDescription) {
    move |scene| set_reflectance(&mut scene.materials[0].material, color)
}

#[test]
fn layers_are_put_around_the_integrator_and_taken_away() {
    let path = "  <integrator type=\"path\">\n    <integer name=\"max_depth\" value=\"7\"/>\n  </integrator>";
    let choose = |scene: &mut SceneDescription| scene.integrator.layers = Layers::of(&[Layer::Depth, Layer::Direct]);
    let (gone, come) = changes(path, choose);
    let aovs = "    <string name=\"aovs\" value=\"Depth:depth,Direct:direct\"/>";
    let depth = "    <integer name=\"max_depth\" value=\"7\"/>";
    assert_eq!(gone, lines(&["  <integrator type=\"path\">", depth]));
    // No setting is written that the file did not have.
    let inside = [
        "    <integrator type=\"path\">",
        "      <integer name=\"max_depth\" value=\"7\"/>",
        "    </integrator>",
    ];
    let around = [&["  <integrator type=\"aov\">", aovs][..], &inside].concat();
    assert_eq!(come, lines(&around));
    let (gone, come) = changes("", choose);
    let plain = [around[0], aovs, "    <integrator type=\"path\"/>", "  </integrator>"];
    assert_eq!((gone, come), (Vec::new(), lines(&plain)));
    // Integrators that are not known stay inside, and where they are as long as nothing is edited.
    let unknown = "  <integrator type=\"photonmapper\"/>";
    let moment = "  <integrator type=\"moment\">\n    <integrator type=\"path\"/>\n  </integrator>";
    let other_layers =
        "  <integrator type=\"aov\"><string name=\"aovs\" value=\"a:dp_du\"/><integrator type=\"path\"/></integrator>";
    for text in [unknown, moment, other_layers] {
        let move_camera =
            |scene: &mut SceneDescription| scene.sensors[0].to_world = Affine3A::from_translation(Vec3::X);
        let (gone, _) = changes(text, move_camera);
        assert!(!gone.iter().any(|line| line.contains("integrator")), "{gone:?}");
    }
    let (_, come) = changes(unknown, choose);
    assert!(
        come.contains(&"    <integrator type=\"photonmapper\"/>".to_owned()),
        "{come:?}"
    );
    let (_, come) = changes(moment, choose);
    assert!(
        come.contains(&"    <integrator type=\"moment\">".to_owned()),
        "{come:?}"
    );
    let aov = "  <integrator type=\"aov\">\n    <string name=\"aovs\" value=\"dd.y:depth\"/> <!-- far -->\n    \
               <integrator type=\"path\">\n      <integer name=\"max_depth\" value=\"7\"/>\n    </integrator>\n  </integrator>";
    // Another parameter leaves the list as it is.
    let (gone, come) = changes(aov, |scene| scene.integrator.max_depth = Some(9));
    assert_eq!(gone, lines(&["      <integer name=\"max_depth\" value=\"7\"/>"]));
    assert_eq!(come, lines(&["      <integer name=\"max_depth\" value=\"9\"/>"]));
    let (gone, come) = changes(aov, |scene| scene.integrator.layers = Layers::of(&[Layer::Uv]));
    assert_eq!(
        gone,
        lines(&["    <string name=\"aovs\" value=\"dd.y:depth\"/> <!-- far -->"])
    );
    assert_eq!(
        come,
        lines(&["    <string name=\"aovs\" value=\"UV:uv\"/> <!-- far -->"])
    );
    let (_, come) = changes(aov, |scene| scene.integrator.layers = Layers::default());
    assert_eq!(come, lines(&["  <integrator type=\"path\">", depth]));
}

#[test]
fn very_many_instances_stay_as_they_stand_in_the_text() {
    let instance = |index: usize| {
        format!(
            "  <shape type='instance'>  <ref id='group'/><transform name='to_world'><translate x='{index}'/></transform></shape> \
             <!-- number {index} -->\n"
        )
    };
    let instances: String = (0..1500).map(instance).collect();
    let body = format!(
        "  <shape type='shapegroup' id='group'><shape type='cube'/></shape>\n{instances}  <shape type='sphere'>\n    \
         <float name='radius' value='1'/>\n  </shape>\n{}",
        instance(7)
    );
    let is_crowd = |shape: &ShapeDescription| shape.placements.is_some();
    let (gone, come) = changes(&body, |scene| {
        assert_eq!(scene.shapes.iter().filter(|shape| is_crowd(shape)).count(), 1);
        for shape in &mut scene.shapes {
            if let ShapeKind::Sphere { radius, .. } = &mut shape.shape.kind {
                *radius = 2.0;
            }
        }
    });
    assert_eq!(gone, lines(&["    <float name='radius' value='1'/>"]));
    assert_eq!(come, lines(&["    <float name='radius' value='2'/>"]));

    // Without the crowd all its elements go, and nothing else does.
    let (gone, come) = changes(&body, |scene| scene.shapes.retain(|shape| !is_crowd(shape)));
    assert_eq!(gone.len(), 1500);
    assert!(
        come.iter().all(|line| line.trim().starts_with("<!-- number ")),
        "{come:?}"
    );
}

/// All scene files at hand: our own, and those beside the repository.
fn scenes_at_hand() -> Vec<PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut folders = vec![root.join("scenes")];
    let mut data = root.ancestors().skip(1).map(|folder| folder.join("shared/data"));
    match data.find(|folder| folder.is_dir()) {
        Some(data) => folders.extend([data.join("mitsuba-scenes"), data.join("peer-scenes")]),
        None => println!("skipped: no folder of shared scenes"),
    }
    let mut files = Vec::new();
    while let Some(folder) = folders.pop() {
        for path in std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()) {
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|extension| extension == "xml") {
                files.push(path);
            }
        }
    }
    files.sort();
    files
}

/// The description, if the scene can be read here: some name meshes that are not there.
fn try_describe(path: &Path) -> Option<SceneDescription> {
    let mut document = document::load(path, &[]).unwrap();
    let scene = read(&mut document);
    if document.diagnostics.has_errors() {
        println!("not saved: {}", document.diagnostics.list[0].message);
        return None;
    }
    Some(scene)
}

#[test]
fn every_scene_saved_unchanged_is_the_same_to_the_byte() {
    let mut count = 0;
    for path in scenes_at_hand() {
        let Some(scene) = try_describe(&path) else { continue };
        let files = files(&scene, &path).unwrap();
        assert_eq!(files.len(), 1, "{}", path.display());
        assert!(
            files[0].1.as_bytes() == std::fs::read(&path).unwrap(),
            "{}",
            path.display()
        );
        count += 1;
    }
    println!("{count} scenes compared");
    assert!(count >= 4);
}

#[test]
fn every_scene_changes_in_few_lines_when_one_thing_is_moved_or_painted() {
    for path in scenes_at_hand() {
        let Some(scene) = try_describe(&path) else { continue };
        let original = std::fs::read_to_string(&path).unwrap();
        let saved = |scene: &SceneDescription| {
            let (_, text) = files(scene, &path).unwrap().pop().unwrap();
            let mut document = document::parse_str(&*text, &path, &[]);
            let again = read(&mut document);
            assert!(!document.diagnostics.has_errors(), "{}", document.diagnostics);
            (text, again)
        };
        let is_included = |identity: &Identity| identity.span.source != Default::default();
        if let Some(index) = scene.shapes.iter().position(|shape| !is_included(&shape.identity)) {
            let mut edited = scene.clone();
            let place = &mut edited.shapes[index].to_world.translation;
            place.x += 0.5 + place.x.abs();
            let wanted = edited.shapes[index].to_world;
            let (text, again) = saved(&edited);
            let (gone, come) = difference(&original, &text);
            // A new transform is three lines; a matrix may be written over several lines, of which up to three hold the
            // place.
            assert!(
                gone.len() <= 3 && come.len() <= 4,
                "{}: {gone:#?} {come:#?}",
                path.display()
            );
            let size = wanted
                .to_cols_array()
                .iter()
                .fold(1.0f32, |most, number| most.max(number.abs()));
            assert!(
                again.shapes[index].to_world.abs_diff_eq(wanted, 1e-4 * size),
                "{}",
                path.display()
            );
            assert_eq!(again.shapes.len(), scene.shapes.len());
        }
        let paint = scene.materials.iter().position(|material| {
            matches!(material.material, Material::Diffuse { .. }) && !is_included(&material.identity)
        });
        if let Some(index) = paint {
            let mut edited = scene.clone();
            let color = Vec3::new(0.125, 0.25, 0.625);
            set_reflectance(&mut edited.materials[index].material, color);
            let (text, again) = saved(&edited);
            let (gone, come) = difference(&original, &text);
            // One line for another; a texture that the colour takes the place of may have several, and goes.
            assert!(come.len() <= 3, "{}: {gone:#?} {come:#?}", path.display());
            assert_eq!(again.materials[index].material, edited.materials[index].material);
        }
    }
}

#[test]
fn a_value_keeps_its_spelling() {
    let diffuse = |value: &str| format!("  <bsdf type='diffuse' id='a'>\n    {value} <!-- why -->\n  </bsdf>");
    let one_line = |body: &str, edit: &dyn Fn(&mut SceneDescription), gone: &str, come: &str| {
        let (was, is) = changes(body, |scene| edit(scene));
        assert_eq!((was, is), (lines(&[gone]), lines(&[come])), "{body}");
    };
    let paint = |color: [f32; 3]| {
        move |scene: &mut SceneDescription| {
            set_reflectance(&mut scene.materials[0].material, color.into());
        }
    };
    for (was, color, is) in [
        (
            "<rgb value = '0.50,0.2  0.10' name='reflectance' />",
            [0.5, 0.3, 0.1],
            "<rgb value = '0.50,0.3  0.10' name='reflectance' />",
        ),
        (
            "<rgb name=\"reflectance\" value=\"0.5\"/>",
            [0.25; 3],
            "<rgb name=\"reflectance\" value=\"0.25\"/>",
        ),
        (
            "<rgb name=\"reflectance\" value=\"0.5\"/>",
            [0.5, 0.5, 1.0],
            "<rgb name=\"reflectance\" value=\"0.5, 0.5, 1\"/>",
        ),
        (
            "<rgb name='diffuseReflectance' value='#ff0000'/>",
            [1.0, 0.5, 0.0],
            "<rgb name='diffuseReflectance' value='1, 0.5, 0'/>",
        ),
        (
            "<srgb name='reflectance' value='0.5'/>",
            [0.5; 3],
            "<rgb name=\"reflectance\" value=\"0.5, 0.5, 0.5\"/>",
        ),
        (
            "<spectrum name='reflectance' value='0.5'/>",
            [0.1; 3],
            "<rgb name=\"reflectance\" value=\"0.1, 0.1, 0.1\"/>",
        ),
    ] {
        let line = |value: &str| format!("    {value} <!-- why -->");
        one_line(&diffuse(was), &paint(color), &line(was), &line(is));
    }

    let shift = |scene: &mut SceneDescription| scene.shapes[0].to_world.translation.x += 1.0;
    for (was, is) in [
        ("<translate x='1' z='2'/>", "<translate x='2' z='2'/>"),
        ("<translate z='2'/>", "<translate z='2' x=\"1\"/>"),
        ("<translate value='1  2  3'/>", "<translate value='2  2  3'/>"),
        (
            "<matrix value='1 0 0 5  0 1 0 0\t0 0 1.0 0 0 0 0 1'/>",
            "<matrix value='1 0 0 6  0 1 0 0\t0 0 1.0 0 0 0 0 1'/>",
        ),
    ] {
        // With a matrix only its own numbers can say it in one line.
        let body = |step: &str| format!("  <shape type='cube'><transform name='toWorld'>{step}</transform></shape>");
        if was.starts_with("<matrix") {
            let (gone, come) = changes(&body(was), shift);
            assert_eq!((gone.len(), come.len()), (1, 1));
            assert!(
                come[0].contains("<translate value=\"1, 0, 0\"/>") && come[0].contains(was),
                "{come:?}"
            );
            continue;
        }
        one_line(&body(was), &shift, &body(was), &body(is));
    }
    let body = "  <shape type='cube'>\n    <transform name='to_world'>\n      <rotate y='1' angle='30'/>\n    </transform>\n  </shape>";
    assert_eq!(
        changes(body, shift),
        (lines(&[]), lines(&["      <translate value=\"1, 0, 0\"/>"]))
    );
    let body = "  <emitter type='point'><point name='position' x='1' y='2.50' z='3'/></emitter>";
    let (_, come) = changes(body, |scene| scene.emitters[0].to_world.translation.z = 9.0);
    assert_eq!(come, lines(&[&body.replace("'3'", "'9'")]));
}

#[test]
fn a_camera_changes_in_its_own_words() {
    let text = "<scene version='3.0.0'><sensor type='perspective'>
  <float name='fov' value='40'/>
  <transform name='to_world'>
    <lookat origin='0, 1, 4' target='0, 1, 0' up='0, 1, 0'/>
  </transform>
  <film type='hdrfilm'><integer name='width' value='$res'/><integer name='height' value='20'/></film>
</sensor></scene>";
    let text = text.replace("<sensor", "<default name='res' value='64'/>\n<sensor");
    let folder = Folder::with(&[("main.xml", &text)]);
    let new = folder.edited(|scene| {
        scene.sensors[0].to_world.translation.x = 0.5;
        scene.sensors[0].film.width = 100;
    });
    let (gone, come) = difference(&text, &new);
    assert_eq!(gone.len(), 2);
    assert!(
        come[0].contains("origin='0.5, 1, 4' target='0.5, 1, 0' up='0, 1, 0'"),
        "{come:?}"
    );
    assert!(come[1].contains("name='width' value='100'/>") && new.contains("<default name='res' value='64'/>"));
}

#[test]
fn what_is_new_looks_like_its_neighbours() {
    let sphere = |id: &str| ShapeDescription {
        identity: Identity {
            id: Some(id.to_owned()),
            order: 100,
            ..Default::default()
        },
        shape: Shape {
            kind: ShapeKind::Sphere {
                center: Vec3::ZERO,
                radius: 2.0,
            },
            ..Shape::default()
        },
        to_world: Affine3A::IDENTITY,
        interior: None,
        exterior: None,
        material: None,
        area_light: None,
        member_of: None,
        instance_of: None,
        placements: None,
    };
    let text = "\u{feff}<?xml version='1.0'?>\r\n<scene version='3.0.0'>\r\n\t<sensor type='perspective'/>\r\n\t<shape type='disk'/> <!-- d -->\r\n\r\n\t<!-- end -->\r\n</scene>\r\n";
    let folder = Folder::with(&[("main.xml", text)]);
    let new = folder.edited(|scene| {
        scene.shapes.push(sphere("ball"));
        scene.shapes[0].to_world.translation.y = 3.0;
    });
    let expected = "\u{feff}<?xml version='1.0'?>\r\n<scene version='3.0.0'>\r\n\t<sensor type='perspective'/>\r\n\t<shape type='disk'>\r\n\t\t<transform name=\"to_world\">\r\n\t\t\t<translate value=\"0, 3, 0\"/>\r\n\t\t</transform>\r\n\t</shape> <!-- d -->\r\n\t<shape type=\"sphere\" id=\"ball\">\r\n\t\t<float name=\"radius\" value=\"2\"/>\r\n\t</shape>\r\n\r\n\t<!-- end -->\r\n</scene>\r\n";
    assert_eq!(new, expected);
    let scene = folder.read("main.xml");
    assert_eq!(scene.shapes[1].identity.id.as_deref(), Some("ball"));

    // And goes again as it came.
    let again = folder.edited(|scene| {
        scene.shapes.pop();
        scene.shapes[0].to_world = Affine3A::IDENTITY;
    });
    let expected = text.replace("<shape type='disk'/>", "<shape type='disk'>\r\n\t</shape>");
    assert_eq!(again, expected);
}

#[test]
fn a_new_material_is_written_once_and_referred_to() {
    let body =
        "  <shape type='sphere'/>\n  <shape type='disk'>\n    <!-- grey -->\n    <bsdf type='diffuse'/>\n  </shape>";
    let (gone, come) = changes(body, |scene| {
        scene.materials.push(MaterialDescription {
            identity: Identity {
                order: 50,
                ..Default::default()
            },
            material: Material::Diffuse {
                reflectance: Vec3::splat(0.25).into(),
            },
            first: None,
            second: None,
            declared_in: DeclarationPlace::TopLevel,
        });
        let new = scene.materials.len() - 1;
        scene.shapes[0].material = Some(new);
        scene.shapes[1].material = Some(new);
    });
    assert_eq!(gone, lines(&["  <shape type='sphere'/>", "    <bsdf type='diffuse'/>"]));
    let expected = [
        "  <shape type='sphere'>",
        "    <ref id=\"material-1\"/>",
        "    <ref id=\"material-1\"/>",
        "  </shape>",
        "  <bsdf type=\"diffuse\" id=\"material-1\">",
        "    <rgb name=\"reflectance\" value=\"0.25, 0.25, 0.25\"/>",
        "  </bsdf>",
    ];
    assert_eq!(come, lines(&expected));
}

#[test]
fn a_material_outlives_the_shape_it_was_written_in() {
    let body = "  <shape type='sphere'>\n    <bsdf type='diffuse' id='paint'>\n      <!-- mixed by hand -->\n      <rgb name='reflectance' value='.1 .2 .3'/>\n    </bsdf>\n  </shape>\n  <shape type='disk'>\n    <ref id='paint'/>\n  </shape>";
    let (_, come) = changes(body, |scene| {
        scene.shapes.remove(0);
        scene.materials[0].declared_in = DeclarationPlace::TopLevel;
    });
    let expected = [
        "  <bsdf type='diffuse' id='paint'>",
        "    <!-- mixed by hand -->",
        "    <rgb name='reflectance' value='.1 .2 .3'/>",
        "  </bsdf>",
    ];
    assert_eq!(come, lines(&expected));
}

#[test]
fn another_type_keeps_what_fits() {
    let body = "  <bsdf type='roughconductor' id='a'>\n    <string name='distribution' value='ggx'/>\n    <float name='alpha' value='0.2'/>\n    <unknown/> <!-- kept -->\n  </bsdf>";
    let (gone, come) = changes(body, coloured(Vec3::splat(0.5)));
    assert_eq!(gone[0], "  <bsdf type='roughconductor' id='a'>");
    assert_eq!(come[0], "  <bsdf type='diffuse' id='a'>");
    assert_eq!(gone.len(), 3, "{gone:?}");
    assert_eq!(come.len(), 2, "{come:?}");
}

const PART: &str = "<scene version='3.0.0'>\n    <!-- shared -->\n    <bsdf type='diffuse' id='paint'>\n        <rgb name='reflectance' value='$tint'/>\n    </bsdf>\n    <shape type='obj'><string name='filename' value='a.obj'/></shape>\n</scene>\n";
const MAIN: &str = "<scene version='3.0.0'>\n  <default name='tint' value='0.5'/>\n  <sensor type='perspective'/>\n  <path value='parts'/>\n  <include filename='part.xml'/> <!-- all of it -->\n  <shape type='disk'><ref id='paint'/></shape>\n</scene>\n";
const TRIANGLE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";

fn with_parts() -> Folder {
    Folder::with(&[
        ("main.xml", MAIN),
        ("parts/part.xml", PART),
        ("parts/a.obj", TRIANGLE),
        ("else/where/readme", ""),
    ])
}

#[test]
fn an_edit_in_an_included_file_is_saved_there() {
    let folder = with_parts();
    let main = folder.edited(coloured(Vec3::new(1.0, 0.5, 0.25)));
    assert_eq!(main, MAIN);
    assert_eq!(folder.text("parts/part.xml"), PART.replace("$tint", "1, 0.5, 0.25"));
}

#[test]
fn an_edit_in_an_included_file_is_written_into_the_scene_when_that_goes_elsewhere() {
    let folder = with_parts();
    let mut scene = folder.read("main.xml");
    let target = folder.path("else/where/new.xml");
    save_description(&scene, &target).unwrap();
    let unchanged = MAIN.replace("'parts'", "'../../parts'");
    assert_eq!(folder.text("else/where/new.xml"), unchanged);

    coloured(Vec3::splat(0.75))(&mut scene);
    save_description(&scene, &target).unwrap();
    assert_eq!(folder.text("parts/part.xml"), PART);
    let part = "<!-- shared -->\n  <bsdf type='diffuse' id='paint'>\n      <rgb name='reflectance' value='0.75'/>\n  </bsdf>\n  <shape type='obj'><string name='filename' value='a.obj'/></shape>";
    let expected = unchanged.replace("<include filename='part.xml'/>", part);
    assert_eq!(folder.text("else/where/new.xml"), expected);
    let again = folder.read("else/where/new.xml");
    assert_eq!(again.shapes.len(), 2);
    assert_eq!(again.materials[0].material, scene.materials[0].material);
}

#[test]
fn one_of_two_uses_of_an_included_file_can_change() {
    let material = "<bsdf version='3.0.0' type='diffuse'>\n\t<rgb name='reflectance' value='0.5'/>\n</bsdf>\n";
    let main = "<scene version='3.0.0'>\n  <sensor type='perspective'/>\n  <shape type='disk'>\n    <include filename='paint.xml'/>\n  </shape>\n  <shape type='cube'>\n    <include filename='paint.xml'/>\n  </shape>\n</scene>\n";
    let folder = Folder::with(&[("main.xml", main), ("paint.xml", material)]);
    let new = folder.edited(|scene| set_reflectance(&mut scene.materials[1].material, Vec3::splat(0.125)));
    assert_eq!(folder.text("paint.xml"), material);
    let (gone, come) = difference(main, &new);
    assert_eq!(gone, lines(&["    <include filename='paint.xml'/>"]));
    let expected = [
        "    <bsdf version='3.0.0' type='diffuse'>",
        "    \t<rgb name='reflectance' value='0.125'/>",
        "    </bsdf>",
    ];
    assert_eq!(come, lines(&expected));
}

#[test]
fn names_of_files_change_only_where_they_must() {
    let main = "<scene version='3.0.0'>\n  <sensor type='perspective'/>\n  <shape type='obj'><string name='filename' value='meshes/a.obj'/></shape>\n  <shape type='obj'><string name='filename' value='both.obj'/></shape>\n  <bsdf type='diffuse' id='b'><texture type='bitmap' name='reflectance'><string name='filename' value='no-such.png'/></texture></bsdf>\n</scene>\n";
    let folder = Folder::with(&[
        ("main.xml", main),
        ("meshes/a.obj", TRIANGLE),
        ("both.obj", TRIANGLE),
        ("else/both.obj", TRIANGLE),
    ]);
    let scene = folder.read("main.xml");
    save_description(&scene, &folder.path("other.xml")).unwrap();
    assert_eq!(folder.text("other.xml"), main);
    save_description(&scene, &folder.path("else/new.xml")).unwrap();
    // The other `both.obj` is another file, and so would be a `no-such.png` there.
    let expected = main
        .replace("meshes/a.obj", "../meshes/a.obj")
        .replace("'both.obj'", "'../both.obj'")
        .replace("no-such.png", "../no-such.png");
    assert_eq!(folder.text("else/new.xml"), expected);
}

#[test]
fn a_missing_picture_is_looked_for_at_the_same_place_from_another_folder() {
    let texture = |name: &str| {
        format!(
            "<bsdf type='diffuse'><texture type='bitmap' name='reflectance'><string name='filename' value='{name}'/></texture></bsdf>"
        )
    };
    let names = [
        ("a.png", "../old/a.png"),
        ("absent/b.png", "../old/absent/b.png"),
        ("../beside/c.png", "../beside/c.png"),
        ("absent/../d.png", "../old/absent/../d.png"),
        ("/absent/e.png", "/absent/e.png"),
    ];
    let body: String = names.iter().map(|(name, _)| texture(name)).collect();
    // What is written has no place to be looked for.
    let film = "<film type='hdrfilm'><string name='filename' value='out.exr'/></film>";
    let folder = Folder::with(&[
        (
            "old/main.xml",
            &format!("<scene version='3.0.0'><sensor type='perspective'>{film}</sensor>{body}</scene>"),
        ),
        ("new/a.png", ""),
    ]);
    let pictures = |scene: &SceneDescription| scene.picture_places.keys().cloned().collect::<BTreeSet<PathBuf>>();
    let scene = folder.read("old/main.xml");
    save_description(&scene, &folder.path("new/saved.xml")).unwrap();
    write_anew(&scene, &folder.path("new/converted.xml"), Extensions::Keep).unwrap();
    for (file, quote) in [("new/saved.xml", '\''), ("new/converted.xml", '"')] {
        let text = folder.text(file);
        assert!(text.contains(&format!("value={quote}out.exr{quote}")), "{text}");
        for (_, expected) in names {
            let value = format!("value={quote}{expected}{quote}");
            assert!(text.contains(&value), "{value} in {text}");
        }
        assert_eq!(pictures(&folder.read(file)), pictures(&scene), "{file}");
    }
}

#[test]
fn what_is_not_understood_stays_where_it_is() {
    let body = "  <!-- before --><medium type='homogeneous' id='fog'><float name='scale' value='1e0'/></medium>
  <?editor fold?>
  <wonder><of a='1'>text</of></wonder>
  <emitter type='envmap'><string name='filename' value='sky.exr'/></emitter>
  <shape type='cube'   id='box'
         extra='yes'>
     <float name='mystery' value='007'/>
     <bsdf type='measured' name='skin'><string name='filename' value='m.bsdf'/></bsdf>
  </shape>
  <emitter type='directional'><vector name='direction' x='1' y='2' z='3'/><rgb name='irradiance' value='1'/></emitter>";
    let (gone, come) = changes(body, |scene| {
        scene.emitters[1].emitter.kind = EmitterKind::Directional {
            irradiance: Vec3::splat(2.0),
        };
    });
    assert_eq!((gone.len(), come.len()), (1, 1));
    assert!(
        come[0].ends_with("<rgb name='irradiance' value='2'/></emitter>"),
        "{come:?}"
    );
    let (gone, come) = changes(body, moved(Vec3::X));
    assert!(gone.is_empty() && come.len() == 3, "{gone:?} {come:?}");
}

/// Moves every shape and light and paints every diffuse material.
fn edit_everything(scene: &mut SceneDescription) {
    for (index, shape) in scene.shapes.iter_mut().enumerate() {
        shape.to_world.translation.x += 1.0 + index as f32;
    }
    for (index, material) in scene.materials.iter_mut().enumerate() {
        if matches!(material.material, Material::Diffuse { .. }) {
            set_reflectance(&mut material.material, Vec3::new(0.5, 0.25, 1.0 / (1.0 + index as f32)));
        }
    }
    for sensor in &mut scene.sensors {
        sensor.to_world.translation.y += 0.5;
        sensor.film.width += 7;
    }
}

#[test]
fn everything_edited_and_saved_elsewhere_is_there_again() {
    let folder = tempfile::tempdir().unwrap();
    let mut count = 0;
    for (index, path) in scenes_at_hand().into_iter().enumerate() {
        let Some(mut scene) = try_describe(&path) else { continue };
        edit_everything(&mut scene);
        let target = folder.path().join(format!("{index}/new.xml"));
        std::fs::create_dir_all(target.parent().unwrap()).unwrap();
        save_description(&scene, &target).unwrap();
        assert_eq!(std::fs::read_dir(target.parent().unwrap()).unwrap().count(), 1);
        let again = describe(&target);
        let what = path.display();
        assert_eq!(again.shapes.len(), scene.shapes.len(), "{what}");
        for (now, wanted) in again.shapes.iter().zip(&scene.shapes) {
            let size = wanted
                .to_world
                .to_cols_array()
                .iter()
                .fold(1.0f32, |most, number| most.max(number.abs()));
            assert!(now.to_world.abs_diff_eq(wanted.to_world, 1e-4 * size), "{what}");
            assert_eq!(now.material, wanted.material, "{what}");
            assert_eq!(
                (&now.shape, &now.area_light),
                (&wanted.shape, &wanted.area_light),
                "{what}"
            );
        }
        let looks = |scene: &SceneDescription| scene.materials.iter().map(|m| m.material.clone()).collect::<Vec<_>>();
        assert_eq!(looks(&again), looks(&scene), "{what}");
        let films = |scene: &SceneDescription| scene.sensors.iter().map(|s| s.film).collect::<Vec<_>>();
        assert_eq!(films(&again), films(&scene), "{what}");
        // Nothing is left to change.
        let text = std::fs::read_to_string(&target).unwrap();
        assert_eq!(
            files(&again, &target).unwrap(),
            [(target.canonicalize().unwrap(), text)],
            "{what}"
        );
        count += 1;
    }
    println!("{count} scenes");
    assert!(count >= 4);
}

#[test]
fn what_was_made_in_the_editor_belongs_to_the_file_once_it_is_saved() {
    let text = "<scene version='3.0.0'>\n  <sensor type='perspective'/>\n  <shape type='disk' id='a'/>\n</scene>\n";
    let folder = Folder::with(&[("main.xml", text)]);
    let path = folder.path("main.xml");
    let mut world = World::new();
    spawn::update(&mut world, &describe(&path).into());
    let shape = world.query_filtered::<Entity, With<Shape>>().single(&world).unwrap();
    let made = world.spawn((Material::default(), DocumentOrder(100))).id();
    world.entity_mut(shape).insert(UsesMaterial(made));

    save(&mut world, &path).unwrap();
    let saved = folder.text("main.xml");
    assert_eq!(world.get::<SceneId>(made), Some(&SceneId("material-1".to_owned())));
    // As the watch over the file does.
    spawn::update(&mut world, &describe(&path).into());
    assert_eq!(world.query::<&Material>().iter(&world).count(), 1);
    assert_eq!(world.get::<UsesMaterial>(shape), Some(&UsesMaterial(made)));
    save(&mut world, &path).unwrap();
    assert_eq!(folder.text("main.xml"), saved);
}

#[test]
fn a_portable_scene_has_no_parameters_of_ours() {
    let folder = tempfile::tempdir().unwrap();
    let text = "<scene version='3.0.0'>
        <sensor type='thinlens'><float name='aperture_radius' value='0.1'/><integer name='blades' value='6'/></sensor>
        <integrator type='vcm'><integer name='photons' value='5000'/></integrator>
        <shape type='sphere'><bsdf type='roughconductor'><boolean name='multiple_scattering' value='true'/></bsdf></shape>
        <emitter type='illuminancegrid'><float name='spacing' value='0.25'/></emitter>
        <emitter type='illuminancemeter'><float name='least' value='500'/></emitter></scene>";
    let mut document = document::parse_str(text, &folder.path().join("old.xml"), &[]);
    let scene = read(&mut document);
    let written = |extensions| {
        let target = folder.path().join("new.xml");
        write_anew(&scene, &target, extensions).unwrap();
        std::fs::read_to_string(target).unwrap()
    };
    let kept = written(Extensions::Keep);
    assert!(
        kept.contains("blades") && kept.contains("multiple_scattering"),
        "{kept}"
    );
    assert!(
        kept.contains("illuminancegrid") && kept.contains("0.25") && kept.contains("500"),
        "{kept}"
    );
    let portable = written(Extensions::Approximate);
    assert!(portable.contains("aperture_radius"), "{portable}");
    assert!(!portable.contains("illuminance"), "{portable}");
    assert!(
        !portable.contains("blade") && !portable.contains("multiple_scattering"),
        "{portable}"
    );
    assert!(kept.contains("\"vcm\"") && kept.contains("photons"), "{kept}");
    let of_mitsuba = portable.contains("<integrator type=\"path\"") && !portable.contains("photons");
    assert!(of_mitsuba && !portable.contains("merge_radius"), "{portable}");
}

#[test]
fn a_portable_scene_has_the_integrator_that_traces_its_media() {
    let folder = tempfile::tempdir().unwrap();
    let medium = "<shape type='sphere'><medium name='interior' type='homogeneous'/></shape>";
    for (inside, expected) in [("", "path"), (medium, "volpath")] {
        let integrator =
            "<integrator type='aov'><string name='aovs' value='dd:depth'/><integrator type='auto'/></integrator>";
        let text = format!("<scene version='3.0.0'>{integrator}{inside}</scene>");
        let mut document = document::parse_str(&*text, &folder.path().join("old.xml"), &[]);
        let target = folder.path().join("new.xml");
        let scene = read(&mut document);
        for (extensions, name) in [(Extensions::Keep, "auto"), (Extensions::Approximate, expected)] {
            write_anew(&scene, &target, extensions).unwrap();
            let written = std::fs::read_to_string(&target).unwrap();
            assert!(written.contains(&format!("<integrator type=\"{name}\"")), "{written}");
        }
    }
}

#[test]
fn spectra_stay_as_they_are_until_their_colour_is_edited() {
    let body = "  <emitter type=\"constant\">\n    <spectrum type=\"blackbody\" name=\"radiance\">\n      <float name=\"temperature\" value=\"3000\"/>\n    </spectrum>\n  </emitter>\n  \
        <bsdf type=\"roughconductor\" id=\"a\">\n    <spectrum type=\"d65\" name=\"specular_reflectance\"><float name=\"scale\" value=\"0.5\"/></spectrum>\n    <float name=\"alpha\" value=\"0.2\"/>\n  </bsdf>";
    assert_eq!(changes(body, |_| ()), (vec![], vec![]));
    let roughen = |scene: &mut SceneDescription| {
        let Material::RoughConductor { alpha, .. } = &mut scene.materials[0].material else {
            panic!("another material")
        };
        *alpha = Roughness::Isotropic(0.5.into());
    };
    let (gone, came) = changes(body, roughen);
    assert_eq!(gone, lines(&["    <float name=\"alpha\" value=\"0.2\"/>"]));
    assert_eq!(came, lines(&["    <float name=\"alpha\" value=\"0.5\"/>"]));
    let brighten = |scene: &mut SceneDescription| {
        scene.emitters[0].emitter.kind = EmitterKind::Constant {
            radiance: Vec3::new(1.0, 2.0, 3.0),
        };
    };
    let (gone, came) = changes(body, brighten);
    assert!(
        gone[0].contains("blackbody") && gone[1].contains("temperature"),
        "{gone:?}"
    );
    assert_eq!(came, lines(&["    <rgb name=\"radiance\" value=\"1, 2, 3\"/>"]));
}

#[test]
fn a_new_file_has_colours_for_spectra_that_need_wavelengths() {
    let folder = tempfile::tempdir().unwrap();
    let text = "<scene version='3.0.0'><sensor type='perspective'/>
        <spectrum type='blackbody' id='hot'><float name='temperature' value='5000'/></spectrum>
        <emitter type='constant'><ref id='hot' name='radiance'/></emitter>
        <emitter type='point'><spectrum type='d65' name='intensity'><float name='scale' value='0.5'/><ref id='hot'/></spectrum></emitter>
        <bsdf type='diffuse' id='a'><spectrum type='irregular' name='reflectance'><string name='wavelengths' value='400, 700'/><string name='values' value='0.1, 0.9'/></spectrum></bsdf>
        <bsdf type='diffuse' id='b'><spectrum type='d65' name='reflectance'><float name='scale' value='0.5'/></spectrum></bsdf>
        <bsdf type='diffuse' id='c'><spectrum type='d65' name='reflectance'><spectrum type='irregular'><string name='wavelengths' value='400, 700'/><string name='values' value='2, 2'/></spectrum></spectrum></bsdf></scene>";
    std::fs::write(folder.path().join("old.xml"), text).unwrap();
    let old = describe(&folder.path().join("old.xml"));
    let target = folder.path().join("new.xml");
    write_anew(&old, &target, Extensions::Keep).unwrap();
    let written = std::fs::read_to_string(&target).unwrap();
    assert!(
        !written.contains("blackbody") && !written.contains("irregular"),
        "{written}"
    );
    assert!(written.contains("d65"), "{written}");
    let new = describe(&target);
    for (new, old) in new.emitters.iter().zip(&old.emitters) {
        assert_eq!(new.emitter, old.emitter, "{written}");
    }
    let materials = |scene: &SceneDescription| scene.materials.iter().map(|it| it.material.clone()).collect::<Vec<_>>();
    assert_eq!(materials(&new), materials(&old));
}

#[test]
fn the_unit_of_length_is_a_default_that_comes_back() {
    let unit = |unit| move |scene: &mut SceneDescription| scene.unit = unit;
    let line = "  <default name=\"length_unit\" value=\"cm\"/>";
    assert_eq!(changes("", unit(LengthUnit::Centimetre)), (vec![], lines(&[line])));
    assert_eq!(
        changes(line, unit(LengthUnit::Foot)),
        (
            lines(&[line]),
            lines(&["  <default name=\"length_unit\" value=\"ft\"/>"])
        )
    );
    assert_eq!(changes(line, unit(LengthUnit::None)), (lines(&[line]), vec![]));
    assert_eq!(changes(line, |_| {}), (vec![], vec![]));

    let text = format!("<scene version='3.0.0'>\n{line}\n<sensor type='perspective'/>\n</scene>\n");
    let folder = Folder::with(&[("main.xml", &text)]);
    let scene = folder.read("main.xml");
    assert_eq!(scene.unit, LengthUnit::Centimetre);
    for extensions in [Extensions::Keep, Extensions::Approximate] {
        write_anew(&scene, &folder.path("anew.xml"), extensions).unwrap();
        assert!(
            folder.text("anew.xml").contains(line.trim()),
            "{}",
            folder.text("anew.xml")
        );
        assert_eq!(folder.read("anew.xml").unit, LengthUnit::Centimetre);
    }
}

#[test]
fn the_units_of_light_are_a_default_beside_that_of_length() {
    let units = |units| move |scene: &mut SceneDescription| scene.light_units = units;
    let length = "  <default name=\"length_unit\" value=\"m\"/>";
    let line = "  <default name=\"light_units\" value=\"photometric\"/>";
    assert_eq!(
        changes(length, units(LightUnits::Photometric)),
        (vec![], lines(&[line]))
    );
    let both = format!("{length}\n{line}");
    assert_eq!(changes(&both, units(LightUnits::Radiometric)), (lines(&[line]), vec![]));
    assert_eq!(changes(&both, |_| {}), (vec![], vec![]));

    // A file that says the usual ones keeps them, and can be given the others in their place.
    let usual = line.replace("photometric", "radiometric");
    assert_eq!(changes(&usual, units(LightUnits::Radiometric)), (vec![], vec![]));
    assert_eq!(
        changes(&usual, units(LightUnits::Photometric)),
        (lines(&[&usual]), lines(&[line]))
    );

    let text = format!("<scene version='3.0.0'>\n{both}\n<sensor type='perspective'/>\n</scene>\n");
    let folder = Folder::with(&[("main.xml", &text)]);
    let scene = folder.read("main.xml");
    let found = (scene.unit, scene.light_units);
    assert_eq!(found, (LengthUnit::Metre, LightUnits::Photometric));
    // Mitsuba takes it for a name that nothing uses.
    write_anew(&scene, &folder.path("anew.xml"), Extensions::Approximate).unwrap();
    assert_eq!(folder.read("anew.xml").light_units, LightUnits::Photometric);

    let other = text.replace("photometric", "warm");
    let folder = Folder::with(&[("main.xml", &other)]);
    assert_eq!(folder.read("main.xml").light_units, LightUnits::Radiometric);
    assert_eq!(folder.edited(units(LightUnits::Photometric)), other);
}

#[test]
fn a_default_of_that_name_may_be_something_else() {
    let text = "<scene version='3.0.0'>
  <default name='length_unit' value='0.01'/>
  <sensor type='perspective'><float name='near_clip' value='$length_unit'/></sensor>
</scene>
";
    let folder = Folder::with(&[("main.xml", text)]);
    let scene = folder.read("main.xml");
    assert_eq!(
        (scene.unit, scene.sensors[0].sensor.near_clip),
        (LengthUnit::None, 0.01)
    );
    assert_eq!(folder.edited(|_| {}), text);
    // The name can stand for one thing only.
    assert_eq!(folder.edited(|scene| scene.unit = LengthUnit::Centimetre), text);

    let used = text.replace("'0.01'", "'cm'").replace(
        "<float name='near_clip' value='$length_unit'/>",
        "<string name='note' value='in $length_unit'/>",
    );
    let folder = Folder::with(&[("main.xml", &used)]);
    assert_eq!(folder.edited(|scene| scene.unit = LengthUnit::None), used);
}

#[test]
fn a_portal_is_kept_and_left_out_of_portable_files() {
    let text = r#"<scene version="3.0.0">
  <shape type="rectangle"><boolean name="portal" value="true"/></shape>
  <shape type="rectangle"/>
</scene>
"#;
    let folder = Folder::with(&[("main.xml", text)]);
    let scene = folder.read("main.xml");
    assert_eq!([0, 1].map(|shape| scene.shapes[shape].shape.portal), [true, false]);
    let written = |extensions| {
        write_anew(&scene, &folder.path("new.xml"), extensions).unwrap();
        folder.text("new.xml").matches("portal").count()
    };
    assert_eq!([Extensions::Keep, Extensions::Approximate].map(written), [1, 0]);
    let saved = folder.edited(|scene| scene.shapes[1].shape.portal = true);
    assert_eq!(
        saved.matches(r#"<boolean name="portal" value="true"/>"#).count(),
        2,
        "{saved}"
    );
    let saved = folder.edited(|scene| (0..2).for_each(|shape| scene.shapes[shape].shape.portal = false));
    assert_eq!(saved.matches("true").count(), 0, "{saved}");
    let disk = text.replace("rectangle", "disk");
    std::fs::write(folder.path("disk.xml"), disk).unwrap();
    let mut document = document::load(&folder.path("disk.xml"), &[]).unwrap();
    read(&mut document);
    assert!(
        document.diagnostics.to_string().contains("portal"),
        "{}",
        document.diagnostics
    );
}
