//! The inspector as a whole, poses and cameras.

use bevy::math::{Affine3A, Vec3};
use bevy_egui::egui::{self, Pos2};
use egui_kittest::Harness;
use egui_kittest::kittest::{NodeT, Queryable};
use sunroom::app::editor::command::selection::Selection;
use sunroom::app::editor::command::shell::{ShellCommand, SoughtFile};
use sunroom::app::editor::command::{Command, EditCommand, ValueEdit, ViewCommand};
use sunroom::app::editor::model::mixed::Mixed;
use sunroom::app::editor::model::{Inspected, InspectedMesh, MissingItem, Model, Outline};
use sunroom::app::editor::panels::inspector::{InspectorState, inspector};
use sunroom::scene::{FileKind, Lens, Material, MeshFile, Sensor, Shape, ShapeKind};

use super::subjects::{awkward, every_inspected, with_material};
use super::{Shown, click, drag, entity, item, light, slide};

pub fn inspect(inspected: Inspected) -> Harness<'static, Shown<Model>> {
    inspect_in(INSPECTOR_WIDTH, inspected)
}

/// What the window gives it at first.
const INSPECTOR_WIDTH: f32 = 300.0;

fn inspect_in(width: f32, inspected: Inspected) -> Harness<'static, Shown<Model>> {
    let model = Model {
        inspected: Some(inspected),
        outline: std::sync::Arc::new(Outline {
            materials: vec![item(30, "red wall"), item(31, "glass")].into(),
            ..Outline::default()
        }),
        ..Model::default()
    };
    let state = std::sync::Mutex::new(InspectorState::default());
    let shown = Shown {
        given: model,
        commands: Vec::new(),
    };
    let mut harness = Harness::builder().with_size(egui::vec2(width, 1200.0)).build_ui_state(
        move |ui, shown: &mut Shown<Model>| {
            let mut state = state.lock().expect("one thread");
            inspector(ui, &shown.given, 10.0, &mut state, &mut shown.commands);
        },
        shown,
    );
    harness.run_steps(3);
    harness
}

#[test]
fn a_mesh_that_is_missing_is_said_to_be_and_can_be_found() {
    let path = std::path::PathBuf::from("/models/chair.obj");
    let shape = Shape {
        kind: ShapeKind::Mesh(MeshFile {
            path: path.clone(),
            ..MeshFile::default()
        }),
        ..Shape::default()
    };
    let mut harness = inspect(Inspected {
        shape: Some(shape),
        ..Inspected::new(entity(5), "chair")
    });
    const WORDS: &str = "The file is missing";
    assert!(harness.query_by_label_contains(WORDS).is_none());
    let kind = FileKind::Mesh;
    harness.state_mut().given.missing = vec![MissingItem {
        kind,
        path: path.clone(),
    }]
    .into();
    harness.run_steps(3);
    assert!(harness.query_by_label_contains(WORDS).is_some());
    click(&mut harness, "Find…");
    let sought = SoughtFile {
        kind,
        path,
        others: true,
    };
    assert_eq!(
        harness.state().commands,
        [Command::Shell(ShellCommand::FindFile(sought))]
    );
}

#[test]
fn names_are_explained_where_the_pointer_rests() {
    let mut harness = inspect(with_material(Material::of_plugin("roughconductor").unwrap()));
    let name = harness.get_all_by_label("Roughness").next().expect("a row").rect();
    // The control has the name; what is explained is the text at the left of it.
    harness.hover_at(Pos2::new(20.0, name.center().y));
    harness.run_steps(30);
    assert!(harness.query_by_label("In the file: alpha").is_some());
}

#[test]
fn what_has_no_material_is_grey_and_a_light_black_unless_its_file_has_some() {
    let plain = Inspected {
        shape: Some(Shape::default()),
        ..Inspected::new(entity(5), "wall")
    };
    let lamp = Inspected {
        area_light: Some(light(Vec3::ONE)),
        ..plain.clone()
    };
    let mesh = |has_materials| Inspected {
        mesh: Some(InspectedMesh {
            triangles: 12,
            curves: [0; 2],
            has_materials,
        }),
        ..lamp.clone()
    };
    let cases = [
        (plain, "none (grey)"),
        (mesh(true), "from the mesh file"),
        (mesh(false), "none (black)"),
        (lamp, "none (black)"),
    ];
    for (inspected, looks) in cases {
        let harness = inspect(inspected);
        assert_eq!(harness.get_by_label("Made of").value().as_deref(), Some(looks));
    }
}

#[test]
fn an_edit_goes_to_all_that_is_selected() {
    let mut harness = inspect(Inspected {
        shape: Some(Shape::default()),
        ..Inspected::new(entity(5), "wall")
    });
    harness.state_mut().given.selection = Selection::of([entity(7), entity(5)]);
    harness.run_steps(2);
    harness.get_by_label_contains("and 1 more");
    click(&mut harness, "Emits light");
    let [Command::Edit(EditCommand::OnSelection(edit))] = &harness.state().commands[..] else {
        panic!("{:?}", harness.state().commands)
    };
    assert!(matches!(**edit, ValueEdit::SetAreaLight(entity_5, Some(_)) if entity_5 == entity(5)));
}

/// Controls and texts with the places they are drawn at.
fn widgets<T>(harness: &Harness<T>) -> Vec<(String, egui::Rect)> {
    use egui::accesskit::Role;
    let roles = [
        Role::Button,
        Role::CheckBox,
        Role::ComboBox,
        Role::ColorWell,
        Role::Label,
        Role::Slider,
        Role::SpinButton,
        Role::TextInput,
    ];
    let nodes = roles.into_iter().flat_map(|role| harness.query_all_by_role(role));
    nodes
        .map(|node| {
            (
                format!("{:?} {:?}", node.accesskit_node().role(), node.accesskit_node().label()),
                node.rect(),
            )
        })
        .collect()
}

#[test]
fn nothing_of_the_inspector_is_cut_off_or_lies_over_something_else() {
    for inspected in every_inspected() {
        let mut harness = inspect(inspected.clone());
        let textured = ["Reflectance", "Base colour", "Height", "Normals", "Picture"];
        for name in textured {
            let role = egui::accesskit::Role::Button;
            let row = harness.query_all_by_role_and_label(role, name).next();
            if let Some(row) = row {
                row.click();
            }
            harness.run_steps(4);
        }
        let widgets = widgets(&harness);
        assert!(widgets.len() > 2);
        for (index, (name, rect)) in widgets.iter().enumerate() {
            let right = INSPECTOR_WIDTH + 0.5;
            assert!(
                rect.left() >= -0.5 && rect.right() <= right,
                "{name} at {rect} of {inspected:?}"
            );
            for (other, place) in &widgets[index + 1..] {
                let shared = rect.intersect(*place);
                // Neighbours may touch.
                let overlap = shared.width().min(shared.height());
                assert!(overlap <= 1.0, "{name} {rect} over {other} {place} of {inspected:?}");
            }
        }
    }
}

#[test]
fn showing_the_inspector_changes_nothing() {
    for inspected in awkward() {
        let mut harness = inspect(inspected.clone());
        harness.hover_at(Pos2::new(150.0, 200.0));
        harness.run_steps(5);
        assert_eq!(harness.state().commands, [], "{inspected:?}");
    }
}

#[test]
fn position_is_dragged_and_the_rest_of_the_matrix_stays() {
    let to_world = Affine3A::from_rotation_y(0.7) * Affine3A::from_scale(Vec3::new(1.0, 2.0, -3.0));
    let mut harness = inspect(Inspected {
        to_world: Some(to_world),
        shape: Some(Shape::default()),
        ..Inspected::new(entity(5), "box")
    });
    drag(&mut harness, "Position Y", 30.0);
    let Some(Command::Edit(EditCommand::Value(ValueEdit::Transform(poses)))) = harness.state().commands.last() else {
        panic!("not moved")
    };
    let [(target, moved)] = poses[..] else {
        panic!("one thing is moved")
    };
    assert_eq!(target, entity(5));
    assert_eq!(moved.matrix3, to_world.matrix3);
    assert!(moved.translation.y > 0.0 && moved.translation.x == 0.0);
}

#[test]
fn a_sheared_shape_has_no_rotation_to_edit() {
    let mut harness = inspect(
        awkward()
            .into_iter()
            .find(|case| case.shape.is_some())
            .expect("there is one"),
    );
    assert!(harness.query_by_label("Rotation X").is_none());
    drag(&mut harness, "Position X", 20.0);
    assert!(matches!(
        harness.state().commands.last(),
        Some(Command::Edit(EditCommand::Value(ValueEdit::Transform(_))))
    ));
}

#[test]
fn camera_sliders_set_the_sensor() {
    let mut harness = inspect(Inspected {
        sensor: Some(Sensor::default()),
        ..Inspected::new(entity(3), "camera")
    });
    slide(&mut harness, "Field of view", 0.9);
    let Some(Command::Edit(EditCommand::Value(ValueEdit::SetSensor(_, sensor)))) = harness.state().commands.last()
    else {
        panic!("not set")
    };
    assert!(sensor.fov > 100.0);
    harness.state_mut().commands.clear();
    click(&mut harness, "Lens");
    harness.get_by_label("thin lens").click();
    harness.run_steps(3);
    assert!(matches!(
        harness.state().commands[..],
        [Command::Edit(EditCommand::Value(ValueEdit::SetSensor(
            _,
            Sensor {
                lens: Lens::Thin { .. },
                ..
            }
        )))]
    ));
    harness.state_mut().commands.clear();
    click(&mut harness, "Look through this camera");
    assert_eq!(
        harness.state().commands,
        [Command::from(ViewCommand::LookThrough(entity(3)))]
    );
}

#[test]
fn a_sphere_has_one_place() {
    let ball = |at: Vec3| Inspected {
        to_world: Some(Affine3A::from_scale_rotation_translation(
            Vec3::splat(2.0),
            bevy::math::Quat::from_rotation_y(1.0),
            at,
        )),
        shape: Some(Shape {
            kind: ShapeKind::Sphere {
                center: Vec3::X,
                radius: 1.0,
            },
            ..Shape::default()
        }),
        ..Inspected::new(entity(7), "ball")
    };
    let mut harness = inspect(ball(Vec3::Y * 3.0));
    assert!(harness.query_by_label("Centre").is_none());
    drag(&mut harness, "Position X", 20.0);
    let before = ball(Vec3::Y * 3.0).to_world.expect("a place").transform_point3(Vec3::X);
    // Poses are about the place of a thing.
    let middle = |pose: &Affine3A| Vec3::from(pose.translation);
    let Some(Command::Edit(EditCommand::Value(ValueEdit::Transform(poses)))) = harness.state().commands.last() else {
        panic!("{:?}", harness.state().commands)
    };
    let moved = middle(&poses[0].1) - before;
    assert!(moved.x > 0.0 && moved.y.abs() < 1e-5 && moved.z.abs() < 1e-5, "{moved}");
    // Turned and scaled it stays where it is.
    let mut harness = inspect(ball(Vec3::Y * 3.0));
    drag(&mut harness, "Scale X", 20.0);
    let Some(Command::Edit(EditCommand::Value(ValueEdit::Transform(poses)))) = harness.state().commands.last() else {
        panic!("{:?}", harness.state().commands)
    };
    assert!(middle(&poses[0].1).abs_diff_eq(before, 1e-5));
    assert!(poses[0].1 != ball(Vec3::Y * 3.0).to_world.expect("a place"));
}

#[test]
fn where_the_selected_differ_it_is_said() {
    let ball = |radius: f32| Inspected {
        to_world: Some(Affine3A::IDENTITY),
        shape: Some(Shape {
            kind: ShapeKind::Sphere {
                center: Vec3::ZERO,
                radius,
            },
            ..Shape::default()
        }),
        ..Inspected::new(entity(7), "ball")
    };
    let marks = |others: &[Inspected]| {
        let shown = ball(1.0);
        let mixed = Mixed::of(&shown, others);
        let harness = inspect(Inspected { mixed, ..shown });
        harness
            .query_all_by_label("mixed")
            .map(|mark| mark.rect())
            .collect::<Vec<_>>()
    };
    assert_eq!(marks(&[ball(1.0)]), []);
    let marked = marks(&[ball(1.0), ball(2.0)]);
    let harness = inspect(ball(1.0));
    let row = harness.get_by_label("Radius").rect();
    assert!(
        matches!(marked[..], [mark] if mark.center().y > row.top() && mark.center().y < row.bottom()),
        "{marked:?}"
    );
}

/// The place of a text, if it is shown.
fn place_of<'s>(shapes: impl IntoIterator<Item = &'s egui::Shape>, text: &str) -> Option<egui::Rect> {
    shapes.into_iter().find_map(|shape| match shape {
        egui::Shape::Text(shown) if shown.galley.text() == text => Some(shown.visual_bounding_rect()),
        egui::Shape::Vec(shapes) => place_of(shapes, text),
        _ => None,
    })
}

#[test]
fn the_sign_of_a_difference_leaves_the_name_legible() {
    let lamp = Inspected {
        shape: Some(Shape::default()),
        area_light: Some(light(sunroom::color::Rgb::ONE)),
        ..Inspected::new(entity(7), "lamp")
    };
    let dark = Inspected {
        area_light: None,
        ..lamp.clone()
    };
    let mixed = Mixed::of(&lamp, &[dark]);
    let harness = inspect(Inspected { mixed, ..lamp });
    let [sign, name] = ["≠", "Emits light"].map(|text| {
        let shapes = harness.output().shapes.iter().map(|shown| &shown.shape);
        place_of(shapes, text).expect(text)
    });
    assert!(sign.right() <= name.left(), "{sign:?} {name:?}");
}
