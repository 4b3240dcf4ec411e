//! Drives the editor's panels without a window: what the user does comes out as commands, and showing a panel changes nothing.
#![cfg(feature = "window")]

mod editor_support;

use std::path::PathBuf;

use bevy::math::{Affine2, Affine3A, Mat3A, Vec2, Vec3};
use bevy::prelude::Entity;
use bevy_egui::egui::{self, Key, Modifiers, PointerButton, Pos2, Ui};
use editor_support::presses;
use egui_kittest::Harness;
use egui_kittest::kittest::{NodeT, Queryable};
use sunroom::app::editor::actions::ActionContext;
use sunroom::app::editor::command::{Command, FileDialogKind};
use sunroom::app::editor::compare::CompareView;
use sunroom::app::editor::display::{DisplayMode, DisplaySettings};
use sunroom::app::editor::gizmo::GizmoSettings;
use sunroom::app::editor::gizmo::interaction::GizmoModel;
use sunroom::app::editor::layout::{self, Layout};
use sunroom::app::editor::light_mix::{Channel, LightMix};
use sunroom::app::editor::material_drop::drop_target;
use sunroom::app::editor::material_tree::MaterialTree;
use sunroom::app::editor::model::{
    ComparisonModel, DenoiserState, HistoryModel, Inspected, InspectedMaterial, Item, MaterialPlace, MixingModel,
    Model, Notice, Outline, RenderModel, StatusModel,
};
use sunroom::app::editor::navigation::Navigation;
use sunroom::app::editor::outline::SelectionOutline;
use sunroom::app::editor::overlay::{BoxList, BvhOverlay};
use sunroom::app::editor::panels::inspector::{InspectorState, inspector};
use sunroom::app::editor::panels::library::LibraryState;
use sunroom::app::editor::panels::menu_bar::{MenuState, menu_bar};
use sunroom::app::editor::panels::outliner::OutlinerState;
use sunroom::app::editor::panels::{diagnostics, history, library, outliner, render, status};
use sunroom::app::editor::presets;
use sunroom::app::editor::selection::{Extend, Selection};
use sunroom::app::editor::shell::ShellCommand;
use sunroom::app::editor::viewport::{ViewportModel, ViewportState, viewport};
use sunroom::color::Rgb;
use sunroom::engine::{CurrentScene, RenderState, RenderStatus};
use sunroom::render::camera::Camera;
use sunroom::scene::{
    AreaLight, ConductorIor, Crop, Distribution, Emitter, EmitterKind, Film, FovAxis, IntegratorSettings, Ior, Lens,
    Material, Parameter, PlaceAndTime, ReconstructionFilter, Roughness, Sensor, Shape, ShapeKind, SquarePath, Strategy,
    SunPosition, SunSky, Texture,
};

fn entity(index: u32) -> Entity {
    Entity::from_raw_u32(index).expect("a small index is valid")
}

/// What a panel is given, and what came of it.
struct Shown<T> {
    given: T,
    commands: Vec<Command>,
}

type Panel<T> = fn(&mut Ui, &T, &mut Vec<Command>);

fn show<T: 'static>(given: T, panel: Panel<T>) -> Harness<'static, Shown<T>> {
    show_at(340.0, given, panel)
}

fn show_at<T: 'static>(width: f32, given: T, panel: Panel<T>) -> Harness<'static, Shown<T>> {
    let shown = Shown {
        given,
        commands: Vec::new(),
    };
    let mut harness = Harness::builder().with_size(egui::vec2(width, 900.0)).build_ui_state(
        move |ui, shown: &mut Shown<T>| panel(ui, &shown.given, &mut shown.commands),
        shown,
    );
    harness.run_steps(3);
    harness
}

/// Drags the slider of this name to a fraction of its length.
fn slide<T>(harness: &mut Harness<Shown<T>>, name: &str, fraction: f32) {
    let rect = harness.get_by_label(name).rect();
    press_at(
        harness,
        Pos2::new(rect.left() + fraction * rect.width(), rect.center().y),
    );
}

fn press_at<T>(harness: &mut Harness<T>, position: Pos2) {
    harness.hover_at(position);
    harness.run_steps(1);
    harness.drag_at(position);
    harness.run_steps(1);
    harness.drop_at(position);
    harness.run_steps(2);
}

fn click<T>(harness: &mut Harness<T>, name: &str) {
    harness.get_by_label(name).click();
    harness.run_steps(4);
}

/// Drags a number by some points to the right.
fn drag<T>(harness: &mut Harness<T>, name: &str, points: f32) {
    let start = harness.get_by_label(name).rect().center();
    harness.hover_at(start);
    harness.run_steps(1);
    harness.drag_at(start);
    harness.run_steps(1);
    for step in 1..=4 {
        harness.hover_at(start + egui::vec2(points * step as f32 / 4.0, 0.0));
        harness.run_steps(1);
    }
    harness.drop_at(start + egui::vec2(points, 0.0));
    harness.run_steps(2);
}

fn inspect(inspected: Inspected) -> Harness<'static, Shown<Model>> {
    inspect_in(INSPECTOR_WIDTH, inspected)
}

/// What the window gives it at first.
const INSPECTOR_WIDTH: f32 = 300.0;

fn inspect_in(width: f32, inspected: Inspected) -> Harness<'static, Shown<Model>> {
    let model = Model {
        inspected: Some(inspected),
        outline: std::sync::Arc::new(Outline {
            materials: vec![item(30, "red wall"), item(31, "glass")],
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

fn item(index: u32, name: &str) -> Item {
    Item {
        entity: entity(index),
        name: name.to_owned(),
        kind: "diffuse",
        hidden: false,
        locked: false,
        can_hide: true,
        inside_of: None,
    }
}

fn with_material(material: Material) -> Inspected {
    Inspected {
        materials: vec![InspectedMaterial {
            entity: entity(7),
            name: "paint".into(),
            material,
            place: MaterialPlace::Whole,
            users: 1,
            inside: Vec::new(),
        }],
        ..Inspected::new(entity(7), "paint")
    }
}

fn only_material(commands: &[Command]) -> &Material {
    match commands.last() {
        Some(Command::SetMaterial(target, material)) if *target == entity(7) => material,
        other => panic!("no material was set: {other:?}"),
    }
}

fn light(radiance: Rgb) -> AreaLight {
    AreaLight {
        radiance: radiance.into(),
        ..AreaLight::default()
    }
}

/// Values that no control can show exactly.
fn awkward() -> Vec<Inspected> {
    let nothing = Inspected::new(entity(7), "it");
    let sheared = Mat3A::from_cols(Vec3::X.into(), Vec3::new(0.3, 2.0, 0.0).into(), Vec3::Z.into());
    let third = Rgb::new(1.0 / 3.0, 0.123_456_79, 1.7);
    let materials = [
        Material::Diffuse {
            reflectance: third.into(),
        },
        Material::Metal {
            reflectance: third.into(),
            fuzz: 1.234_567.into(),
        },
        Material::RoughConductor {
            distribution: Distribution::Ggx,
            ior: ConductorIor::Named("unobtainium".into()),
            specular_reflectance: third.into(),
            alpha: Roughness::Anisotropic {
                u: 3.3.into(),
                v: 1e-5.into(),
            },
            multiple_scattering: true,
        },
        Material::Conductor {
            ior: ConductorIor::Given {
                eta: third.into(),
                k: (-third).into(),
            },
            specular_reflectance: third.into(),
        },
        Material::Dielectric {
            interior: Ior::Number(7.654_321),
            exterior: Ior::Named("mud".into()),
            specular_reflectance: third.into(),
            specular_transmittance: third.into(),
        },
        Material::TwoSided,
    ];
    let mut cases: Vec<Inspected> = materials.into_iter().map(with_material).collect();
    cases.extend([
        Inspected {
            to_world: Some(Affine3A {
                matrix3: sheared,
                translation: Vec3::splat(1e7 / 3.0).into(),
            }),
            shape: Some(Shape {
                kind: ShapeKind::Sphere {
                    center: third,
                    radius: -2.0,
                },
                flip_normals: true,
            }),
            area_light: Some(light(Rgb::new(1e5 / 3.0, 7.0, 0.0))),
            uses_material: Some(entity(99)),
            ..nothing.clone()
        },
        Inspected {
            to_world: Some(
                Affine3A::from_rotation_x(0.123_456_7) * Affine3A::from_scale(Vec3::new(-1e-3, 3e3, 1.0 / 3.0)),
            ),
            emitter: Some(EmitterKind::Point { intensity: Rgb::ZERO }.into()),
            ..nothing.clone()
        },
        Inspected {
            sensor: Some(Sensor {
                fov: 179.876_54,
                near_clip: 0.0,
                lens: Lens::Thin {
                    aperture_radius: 1e4,
                    focus_distance: 0.0,
                    blades: 7,
                    blade_rotation: -1e5,
                },
                ..Sensor::default()
            }),
            film: Some(Film {
                width: 3,
                height: 100_000,
                crop: Some(Crop {
                    x: 5,
                    y: 0,
                    width: 0,
                    height: 7,
                }),
                filter: ReconstructionFilter::Mitchell { b: 3.0, c: -3.0 },
                sample_count: 0,
            }),
            emitter: Some(EmitterKind::Directional { irradiance: third }.into()),
            ..nothing
        },
    ]);
    cases.extend(awkward_lights().into_iter().map(|emitter| Inspected {
        to_world: Some(Affine3A::from_rotation_z(0.3)),
        emitter: Some(emitter),
        ..Inspected::new(entity(8), "lamp")
    }));
    cases
}

/// Out of every range there is.
fn awkward_lights() -> Vec<Emitter> {
    let slide = Texture::of_picture("/pictures/slide.png".into(), None);
    let sky = SunSky {
        turbidity: 1e3,
        albedo: Rgb::splat(7.0 / 3.0),
        sun: SunPosition::Direction(Vec3::new(1e6 / 3.0, 0.0, -1e-6)),
        sun_aperture: 400.0,
        ..SunSky::default()
    };
    let at = PlaceAndTime {
        latitude: 123.456_79,
        month: 77,
        hour: -1e7 / 3.0,
        ..PlaceAndTime::default()
    };
    let kinds = [
        EmitterKind::Environment {
            picture: "/pictures/sky.exr".into(),
            scale: -1.0 / 3.0,
            mis_compensation: false,
        },
        EmitterKind::Spot {
            intensity: Rgb::new(1e5 / 3.0, 0.0, 1e-9),
            cutoff_angle: 179.0,
            beam_width: 1e3 / 3.0,
            texture: Some(slide.clone()),
        },
        EmitterKind::Projector {
            irradiance: Parameter::Texture(slide),
            scale: 1e-7,
            fov: 179.99,
            fov_axis: FovAxis::Larger,
        },
        EmitterKind::SunSky(sky),
        EmitterKind::SunSky(SunSky {
            sun: SunPosition::PlaceAndTime(at),
            ..sky
        }),
    ];
    let light = |kind| Emitter {
        kind,
        sampling_weight: -0.123_456,
    };
    kinds.map(light).to_vec()
}

fn lamp(emitter: Emitter) -> Harness<'static, Shown<Model>> {
    inspect(Inspected {
        emitter: Some(emitter),
        ..Inspected::new(entity(8), "lamp")
    })
}

#[test]
fn a_narrower_cone_takes_its_beam_along() {
    let mut spot = Emitter::of_plugin("spot").unwrap();
    if let EmitterKind::Spot {
        cutoff_angle,
        beam_width,
        ..
    } = &mut spot.kind
    {
        (*cutoff_angle, *beam_width) = (80.0, 75.0);
    }
    let mut harness = lamp(spot);
    slide(&mut harness, "Cutoff", 0.2);
    let Some(Command::SetEmitter(_, spot)) = harness.state().commands.last() else {
        panic!("no light was set")
    };
    assert!(
        matches!(spot.kind, EmitterKind::Spot { cutoff_angle, beam_width, .. } if cutoff_angle < 75.0 && beam_width == cutoff_angle),
        "{spot:?}"
    );
}

#[test]
fn pictures_of_lights_are_chosen() {
    let ways: [(&str, &str, &[&str]); 3] = [
        ("envmap", "filename", &["Picture"]),
        ("spot", "texture", &["Slide source", "picture\u{2026}"]),
        ("projector", "irradiance", &["Picture source", "picture\u{2026}"]),
    ];
    for (plugin, parameter, clicks) in ways {
        let mut harness = lamp(Emitter::of_plugin(plugin).unwrap());
        for name in clicks {
            click(&mut harness, name);
        }
        let dialog = Command::ShowDialog(FileDialogKind::OpenPicture {
            owner: entity(8),
            parameter,
            place: SquarePath::WHOLE,
        });
        assert_eq!(harness.state().commands, [dialog]);
    }
}

#[test]
fn a_light_of_another_kind_keeps_its_colour() {
    let warm = Rgb::new(30.0, 20.0, 10.0);
    let mut harness = lamp(EmitterKind::Point { intensity: warm }.into());
    click(&mut harness, "Type");
    click(&mut harness, "directional");
    let sun = Emitter::from(EmitterKind::Directional { irradiance: warm });
    assert_eq!(harness.state().commands, [Command::SetEmitter(entity(8), sun)]);
}

fn textured(texture: Texture) -> Material {
    Material::Diffuse {
        reflectance: Parameter::Texture(texture),
    }
}

fn checkerboard() -> Texture {
    Texture::Checkerboard {
        color0: Box::new(Rgb::splat(0.4).into()),
        color1: Box::new(Parameter::Texture(Texture::of_picture("/pictures/a.png".into(), None))),
        to_uv: Affine2::IDENTITY,
    }
}

#[test]
fn a_constant_becomes_a_texture_and_back() {
    let red = Rgb::new(0.6, 0.1, 0.1);
    let mut harness = inspect(with_material(Material::Diffuse {
        reflectance: red.into(),
    }));
    click(&mut harness, "Reflectance source");
    click(&mut harness, "checkerboard");
    let Material::Diffuse {
        reflectance: Parameter::Texture(Texture::Checkerboard { color0, .. }),
    } = only_material(&harness.state().commands)
    else {
        panic!("{:?}", harness.state().commands)
    };
    assert_eq!(**color0, red.into());

    let mut harness = inspect(with_material(textured(checkerboard())));
    click(&mut harness, "Reflectance source");
    click(&mut harness, "colour");
    let grey = Material::Diffuse {
        reflectance: Rgb::splat(0.4).into(),
    };
    assert_eq!(only_material(&harness.state().commands), &grey);
}

#[test]
fn a_texture_opens_and_is_edited_in_place() {
    let mut harness = inspect(with_material(textured(checkerboard())));
    assert!(harness.query_by_label("Colour 1 R").is_none());
    click(&mut harness, "Reflectance");
    drag(&mut harness, "Repeats U", 30.0);
    let Material::Diffuse {
        reflectance: Parameter::Texture(Texture::Checkerboard { to_uv, color1, .. }),
    } = only_material(&harness.state().commands)
    else {
        panic!("{:?}", harness.state().commands)
    };
    assert!(
        to_uv.matrix2.x_axis.x > 1.0 && to_uv.matrix2.y_axis.y == 1.0,
        "{to_uv:?}"
    );
    assert!(color1.constant().is_none(), "what is inside stays");
    // A picture within the checkerboard.
    harness.state_mut().commands.clear();
    click(&mut harness, "Colour 1 source");
    click(&mut harness, "picture\u{2026}");
    let dialog = Command::ShowDialog(FileDialogKind::OpenPicture {
        owner: entity(7),
        parameter: "reflectance",
        place: SquarePath::WHOLE.within(0),
    });
    assert_eq!(harness.state().commands, [dialog]);
}

#[test]
fn colours_are_typed_as_srgb_too() {
    let mut harness = inspect(with_material(Material::Diffuse {
        reflectance: Rgb::splat(0.5).into(),
    }));
    click(&mut harness, "lin");
    assert_eq!(harness.state().commands, [], "another notation is the same colour");
    harness.get_by_label("Reflectance hex").focus();
    harness.run_steps(2);
    harness.key_press_modifiers(Modifiers::COMMAND, Key::A);
    harness.event(egui::Event::Text("#ff0080".into()));
    harness.run_steps(3);
    let Material::Diffuse { reflectance } = only_material(&harness.state().commands) else {
        panic!("another kind")
    };
    let color = reflectance.constant().expect("no texture");
    // 0x80 is 21.6 % of the light, see IEC 61966-2-1.
    assert!(color.abs_diff_eq(Rgb::new(1.0, 0.0, 0.2159), 1e-3), "{color}");
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

fn shown_tree(commands: &[Command]) -> (&[Entity], &MaterialTree) {
    match commands {
        [Command::BuildMaterial { targets, tree }] => (targets, tree),
        other => panic!("{other:?}"),
    }
}

#[test]
fn presets_go_to_all_that_is_selected() {
    let mut harness = inspect(with_material(Material::default()));
    harness.state_mut().given.presets = std::sync::Arc::new(presets::load().0);
    harness.state_mut().given.selection = Selection::of([entity(5), entity(7)]);
    harness.run_steps(2);
    click(&mut harness, "Presets");
    harness.get_by_label_contains("Metal").click();
    harness.run_steps(4);
    click(&mut harness, "gold");
    let (targets, tree) = shown_tree(&harness.state().commands);
    assert_eq!(targets, [entity(5), entity(7)]);
    let Material::Conductor { ior, .. } = &tree.material else {
        panic!("{tree:?}")
    };
    assert_eq!(*ior, ConductorIor::Named("Au".into()));
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
    let [Command::OnSelection(edit)] = &harness.state().commands[..] else {
        panic!("{:?}", harness.state().commands)
    };
    assert!(matches!(**edit, Command::SetAreaLight(entity_5, Some(_)) if entity_5 == entity(5)));
}

#[test]
fn a_preset_is_clicked_or_dragged_out_of_the_library() {
    let model = Model {
        presets: std::sync::Arc::new(presets::load().0),
        outline: std::sync::Arc::new(Outline {
            shapes: vec![item(5, "ball"), item(6, "floor")],
            ..Outline::default()
        }),
        selection: Selection::of([entity(5), entity(9)]),
        ..Model::default()
    };
    let state = std::sync::Mutex::new(LibraryState::default());
    let shown = Shown {
        given: model,
        commands: Vec::new(),
    };
    let mut harness = Harness::builder().with_size(egui::vec2(600.0, 400.0)).build_ui_state(
        move |ui, shown: &mut Shown<Model>| {
            let mut state = state.lock().expect("one thread");
            let Shown { given, commands } = shown;
            egui::Panel::left("library").exact_size(220.0).show(ui, |ui| {
                library::library(ui, given, &mut state, commands);
            });
            let picture = ui.available_rect_before_wrap();
            let response = ui.interact(picture, egui::Id::new("picture"), egui::Sense::click_and_drag());
            drop_target(ui, &response, picture, commands);
        },
        shown,
    );
    harness.run_steps(3);
    click(&mut harness, "silver");
    // The light among what is selected has no material.
    assert!(matches!(
        &harness.state().commands[..],
        [Command::UsePreset { preset, shapes }] if preset.path() == "Metal/silver" && *shapes == [entity(5)]
    ));
    let gold = harness.get_by_label("gold").rect().center();
    drag_between(&mut harness, gold, Pos2::new(410.0, 200.0));
    let Some(Command::DropPreset { preset, at }) = harness.state().commands.last() else {
        panic!("{:?}", harness.state().commands)
    };
    assert_eq!(preset.path(), "Metal/gold");
    assert!(at.abs_diff_eq(Vec2::splat(0.5), 0.1), "{at}");
}

#[test]
fn a_shape_without_a_material_takes_a_preset_too() {
    let mut harness = inspect(Inspected {
        shape: Some(Shape::default()),
        ..Inspected::new(entity(5), "wall")
    });
    harness.state_mut().given.presets = std::sync::Arc::new(presets::load().0);
    click(&mut harness, "Presets");
    harness.get_by_label_contains("Glass").click();
    harness.run_steps(4);
    click(&mut harness, "diamond");
    let (targets, tree) = shown_tree(&harness.state().commands);
    assert_eq!((targets, tree.material.plugin()), (&[entity(5)][..], "dielectric"));
}

#[test]
fn a_material_is_put_into_another_and_taken_out() {
    let mut harness = inspect(with_material(Material::default()));
    click(&mut harness, "Layers");
    harness.get_by_label_contains("Put it into").click();
    harness.run_steps(4);
    click(&mut harness, "bump map");
    let (targets, tree) = shown_tree(&harness.state().commands);
    assert_eq!(targets, [entity(7)]);
    assert_eq!(*tree, MaterialTree::from(Material::default()).wrapped("bumpmap"));

    let mut wrapped = with_material(Material::of_plugin("bumpmap").unwrap());
    wrapped.materials[0].inside = vec![entity(9)];
    wrapped.materials.push(InspectedMaterial {
        entity: entity(9),
        name: "clay".into(),
        material: Material::default(),
        place: MaterialPlace::Inside,
        users: 0,
        inside: Vec::new(),
    });
    let mut harness = inspect(wrapped);
    harness
        .get_all_by_label("Layers")
        .next()
        .expect("that of the bump map")
        .click();
    harness.run_steps(4);
    click(&mut harness, "Take the bump map off");
    let (targets, tree) = shown_tree(&harness.state().commands);
    assert_eq!((targets, tree.clone()), (&[entity(7)][..], Material::default().into()));
}

#[test]
fn an_environment_turns_about_its_upward_axis() {
    let mut harness = inspect(Inspected {
        to_world: Some(Affine3A::IDENTITY),
        emitter: Emitter::of_plugin("envmap"),
        ..Inspected::new(entity(8), "sky")
    });
    slide(&mut harness, "Turned", 0.75);
    let Some(Command::Transform(poses)) = harness.state().commands.last() else {
        panic!("{:?}", harness.state().commands)
    };
    let up = poses[0].1.transform_vector3(Vec3::Y);
    assert!(
        up.abs_diff_eq(Vec3::Y, 1e-5) && poses[0].1 != Affine3A::IDENTITY,
        "{up}"
    );
}

/// Every plugin with its parameters constant, and once as textures.
fn every_inspected() -> Vec<Inspected> {
    let long = Texture::of_picture(
        "/pictures/a-picture-whose-name-is-much-too-long-for-the-panel.png".into(),
        None,
    );
    let mut cases: Vec<Inspected> = Vec::new();
    for plugin in Material::PLUGINS {
        let material = Material::of_plugin(plugin).expect("a plugin");
        let mut pictured = material.clone();
        for parameter in [
            "reflectance",
            "base_color",
            "roughness",
            "alpha",
            "height",
            "normalmap",
            "weight",
        ] {
            pictured.set_picture(
                parameter,
                SquarePath::WHOLE,
                "/pictures/a-long-name-of-a-file.exr".as_ref(),
            );
        }
        cases.extend([with_material(material), with_material(pictured)]);
    }
    cases.push(with_material(textured(long.clone())));
    cases.push(with_material(textured(checkerboard())));
    for plugin in Emitter::PLUGINS {
        let mut emitter = Emitter::of_plugin(plugin).expect("a plugin");
        let case = |emitter: &Emitter| Inspected {
            to_world: Some(Affine3A::from_rotation_y(0.5)),
            emitter: Some(emitter.clone()),
            ..Inspected::new(entity(8), "lamp")
        };
        cases.push(case(&emitter));
        emitter.set_picture(SquarePath::WHOLE, "/pictures/a-long-name-of-a-file.exr".into());
        cases.push(case(&emitter));
    }
    cases.push(Inspected {
        shape: Some(Shape::default()),
        area_light: Some(light(Rgb::new(1234.5, 7.0, 0.125))),
        ..Inspected::new(entity(5), "lamp")
    });
    cases
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
        let textured = ["Reflectance", "Base colour", "Height", "Normals", "Slide"];
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
fn what_is_infinitely_far_away_is_only_turned() {
    let sky = Inspected {
        to_world: Some(Affine3A::IDENTITY),
        emitter: Emitter::of_plugin("sunsky"),
        ..Inspected::new(entity(8), "sky")
    };
    let mut harness = inspect(sky);
    assert!(harness.query_by_label("Position X").is_none());
    drag(&mut harness, "Rotation Y", 20.0);
    assert!(matches!(harness.state().commands.last(), Some(Command::Transform(_))));
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
fn a_slider_changes_its_parameter_and_no_other() {
    let reflectance = Rgb::new(0.8, 0.6, 1.0 / 3.0);
    let mut harness = inspect(with_material(Material::Metal {
        reflectance: reflectance.into(),
        fuzz: 0.1.into(),
    }));
    slide(&mut harness, "Fuzz", 0.5);
    let Material::Metal {
        reflectance: kept,
        fuzz,
    } = only_material(&harness.state().commands)
    else {
        panic!("another kind")
    };
    assert_eq!(*kept, reflectance.into());
    assert!(
        fuzz.constant().is_some_and(|fuzz| (0.4..0.6).contains(&fuzz)),
        "{fuzz:?}"
    );
}

#[test]
fn a_colour_channel_can_be_dragged() {
    let mut harness = inspect(with_material(Material::Diffuse {
        reflectance: Rgb::splat(0.5).into(),
    }));
    drag(&mut harness, "Reflectance G", 40.0);
    let Material::Diffuse { reflectance } = only_material(&harness.state().commands) else {
        panic!("another kind")
    };
    let reflectance = reflectance.constant().expect("no texture");
    assert_eq!((reflectance.x, reflectance.z), (0.5, 0.5));
    assert!(reflectance.y > 0.5 && reflectance.y <= 1.0, "{reflectance}");
}

#[test]
fn a_material_turns_into_another_kind() {
    let mut harness = inspect(with_material(Material::Diffuse {
        reflectance: Rgb::splat(0.5).into(),
    }));
    click(&mut harness, "Type");
    click(&mut harness, "dielectric");
    assert!(matches!(
        only_material(&harness.state().commands),
        Material::Dielectric { .. }
    ));
}

#[test]
fn a_shape_takes_another_material_or_a_new_one() {
    let shape = Inspected {
        shape: Some(Shape::default()),
        uses_material: Some(entity(30)),
        ..Inspected::new(entity(5), "wall")
    };
    let mut harness = inspect(shape.clone());
    click(&mut harness, "Uses");
    click(&mut harness, "glass");
    let used = Command::UseMaterial {
        shapes: vec![entity(5)],
        material: Some(entity(31)),
    };
    assert_eq!(harness.state().commands, [used]);
    let mut harness = inspect(shape);
    click(&mut harness, "New material for this shape");
    assert_eq!(harness.state().commands, [Command::GiveMaterial { shape: entity(5) }]);
}

#[test]
fn a_shape_can_be_made_to_emit() {
    let mut harness = inspect(Inspected {
        shape: Some(Shape::default()),
        ..Inspected::new(entity(5), "wall")
    });
    click(&mut harness, "Emits light");
    let light = AreaLight::default();
    assert_eq!(
        harness.state().commands,
        [Command::SetAreaLight(entity(5), Some(light))]
    );
}

#[test]
fn strength_keeps_the_hue() {
    let radiance = Rgb::new(18.4, 9.2, 4.6);
    let mut harness = inspect(Inspected {
        shape: Some(Shape::default()),
        area_light: Some(light(radiance)),
        ..Inspected::new(entity(5), "lamp")
    });
    slide(&mut harness, "Radiance", 0.9);
    let Some(Command::SetAreaLight(_, Some(light))) = harness.state().commands.last() else {
        panic!("no light was set")
    };
    let stronger = light.radiance.constant().unwrap();
    assert!(stronger.x > radiance.x);
    let (hue, before) = (stronger / stronger.x, radiance / radiance.x);
    assert!(hue.abs_diff_eq(before, 1e-4), "{hue} {before}");
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
    let Some(Command::Transform(poses)) = harness.state().commands.last() else {
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
    assert!(matches!(harness.state().commands.last(), Some(Command::Transform(_))));
}

#[test]
fn camera_sliders_set_the_sensor() {
    let mut harness = inspect(Inspected {
        sensor: Some(Sensor::default()),
        ..Inspected::new(entity(3), "camera")
    });
    slide(&mut harness, "Field of view", 0.9);
    let Some(Command::SetSensor(_, sensor)) = harness.state().commands.last() else {
        panic!("not set")
    };
    assert!(sensor.fov > 100.0);
    harness.state_mut().commands.clear();
    click(&mut harness, "Lens");
    harness.get_by_label("thin lens").click();
    harness.run_steps(3);
    assert!(matches!(
        harness.state().commands[..],
        [Command::SetSensor(
            _,
            Sensor {
                lens: Lens::Thin { .. },
                ..
            }
        )]
    ));
    harness.state_mut().commands.clear();
    click(&mut harness, "Look through this camera");
    assert_eq!(harness.state().commands, [Command::LookThrough(entity(3))]);
}

fn render_panel(model: RenderModel) -> Harness<'static, Shown<RenderModel>> {
    show(model, |ui, model, commands| {
        render::render(ui, model, DisplaySettings::default(), BvhOverlay::default(), commands);
    })
}

#[test]
fn the_render_panel_sets_what_it_shows() {
    let model = RenderModel {
        target_samples: 100_000,
        resolution_scale: 0.333_333_34,
        integrator: IntegratorSettings {
            max_depth: Some(1000),
            ..IntegratorSettings::default()
        },
        ..RenderModel::default()
    };
    let mut harness = render_panel(model);
    assert_eq!(harness.state().commands, [], "out of range and yet untouched");
    slide(&mut harness, "Samples", 0.3);
    assert!(matches!(
        harness.state().commands.last(),
        Some(Command::SetTargetSamples(2..=200))
    ));
    slide(&mut harness, "Resolution", 0.5);
    assert!(matches!(harness.state().commands.last(), Some(Command::SetResolutionScale(s)) if (0.4..0.7).contains(s)));
    slide(&mut harness, "Exposure", 0.6);
    assert!(matches!(harness.state().commands.last(), Some(Command::SetDisplay(d)) if d.exposure > 0.0));
    slide(&mut harness, "Depth limit", 0.1);
    assert!(matches!(
        harness.state().commands.last(),
        Some(Command::SetIntegrator(IntegratorSettings {
            max_depth: Some(1..20),
            ..
        }))
    ));
    click(&mut harness, "Sampling");
    click(&mut harness, "lights only");
    assert!(matches!(
        harness.state().commands.last(),
        Some(Command::SetIntegrator(IntegratorSettings {
            strategy: Strategy::Light,
            ..
        }))
    ));
    click(&mut harness, "Show");
    click(&mut harness, "Normal");
    assert!(matches!(harness.state().commands.last(), Some(Command::SetDisplay(d)) if d.mode == DisplayMode::Normal));
    click(&mut harness, "Start again");
    assert_eq!(harness.state().commands.last(), Some(&Command::Restart));
}

#[test]
fn limits_have_a_switch_and_a_number() {
    let mut harness = render_panel(RenderModel::default());
    click(&mut harness, "Limit time");
    click(&mut harness, "Limit noise");
    let expected = [Command::SetTimeLimit(Some(60.0)), Command::SetNoiseTarget(Some(0.02))];
    assert_eq!(harness.state().commands, expected);
    let mut harness = render_panel(RenderModel {
        time_limit: Some(5.0),
        noise_target: Some(0.1),
        region: Some(bevy::math::Rect::new(0.0, 0.0, 0.5, 0.5)),
        ..RenderModel::default()
    });
    slide(&mut harness, "Noise", 0.9);
    assert!(matches!(harness.state().commands.last(), Some(Command::SetNoiseTarget(Some(n))) if *n > 0.1));
    click(&mut harness, "Limit time");
    assert_eq!(harness.state().commands.last(), Some(&Command::SetTimeLimit(None)));
    slide(&mut harness, "Right", 0.9);
    let last = harness.state().commands.last().cloned();
    assert!(
        matches!(last, Some(Command::SetRegion(Some(part))) if part.max.x > 0.6 && part.min.x == 0.0),
        "{last:?}"
    );
    click(&mut harness, "Only a part");
    assert_eq!(harness.state().commands.last(), Some(&Command::SetRegion(None)));
}

#[test]
fn every_light_has_its_channel() {
    let mut harness = render_panel(RenderModel::default());
    click(&mut harness, "Mix lights");
    assert_eq!(harness.state().commands, [Command::SetLightLayers(true)]);
    let mut mix = LightMix::default();
    let loud = Channel {
        strength: 3.0,
        ..Channel::default()
    };
    mix.set(entity(2), loud);
    let mut harness = render_panel(RenderModel {
        mixing: MixingModel {
            is_on: true,
            mix: mix.clone(),
            lights: vec![(entity(1), "sky".to_owned()), (entity(2), "lamp".to_owned())],
        },
        ..RenderModel::default()
    });
    assert_eq!(harness.state().commands, []);
    click(&mut harness, "sky M");
    let muted = Channel {
        mute: true,
        ..Channel::default()
    };
    let mut expected = mix.clone();
    expected.set(entity(1), muted);
    assert_eq!(harness.state().commands.last(), Some(&Command::SetLightMix(expected)));
    click(&mut harness, "lamp S");
    let mut expected = mix;
    expected.set(entity(2), Channel { solo: true, ..loud });
    assert_eq!(harness.state().commands.last(), Some(&Command::SetLightMix(expected)));
    click(&mut harness, "Bake");
    assert_eq!(harness.state().commands.last(), Some(&Command::BakeLights));
    click(&mut harness, "Reset");
    assert_eq!(
        harness.state().commands.last(),
        Some(&Command::SetLightMix(LightMix::default()))
    );
}

#[test]
fn pictures_are_compared_with_a_snapshot() {
    let mut harness = render_panel(RenderModel::default());
    click(&mut harness, "Take snapshot");
    assert_eq!(harness.state().commands, [Command::TakeSnapshot]);
    let mut harness = render_panel(RenderModel {
        comparison: ComparisonModel {
            snapshot: Some(16),
            view: CompareView::Wipe(0.25),
            figures: None,
        },
        ..RenderModel::default()
    });
    slide(&mut harness, "Border", 0.75);
    let last = harness.state().commands.last().cloned();
    assert!(matches!(last, Some(Command::SetCompareView(CompareView::Wipe(at))) if at > 0.5));
    click(&mut harness, "Compare");
    click(&mut harness, "difference");
    let difference = Command::SetCompareView(CompareView::Difference);
    assert_eq!(harness.state().commands.last(), Some(&difference));
    click(&mut harness, "Measure");
    assert_eq!(harness.state().commands.last(), Some(&Command::Measure));
}

fn with_outline(outline: Outline, selection: Selection) -> Model {
    Model {
        outline: outline.into(),
        selection,
        ..Model::default()
    }
}

#[test]
fn the_outliner_selects_and_finds() {
    let outline = Outline {
        shapes: vec![item(1, "floor"), item(2, "bunny")],
        lights: vec![item(3, "lamp")],
        ..Outline::default()
    };
    let state = std::sync::Mutex::new(OutlinerState::default());
    let shown = Shown {
        given: with_outline(outline, Selection::of([entity(1)])),
        commands: Vec::new(),
    };
    let mut harness = Harness::builder().with_size(egui::vec2(240.0, 500.0)).build_ui_state(
        move |ui, shown: &mut Shown<Model>| {
            let mut state = state.lock().expect("one thread");
            outliner::outliner(ui, &shown.given, &mut state, &mut shown.commands);
        },
        shown,
    );
    harness.run_steps(3);
    click(&mut harness, "bunny");
    assert_eq!(
        harness.state().commands,
        [Command::Select(vec![entity(2)], Extend::Replace)]
    );
    harness.get_by_role(egui::accesskit::Role::TextInput).focus();
    harness.run_steps(2);
    harness.get_by_role(egui::accesskit::Role::TextInput).type_text("LAM");
    harness.run_steps(3);
    assert!(harness.query_by_label("bunny").is_none());
    assert!(harness.query_by_label("lamp").is_some());
}

fn menus(denoiser: DenoiserState) -> Harness<'static, Shown<Model>> {
    let model = Model {
        status: StatusModel {
            denoiser,
            ..StatusModel::default()
        },
        scene_files: std::sync::Arc::new(vec!["/there/cornell-box.xml".into()]),
        outline: std::sync::Arc::new(Outline {
            sensors: vec![item(9, "from above")],
            ..Outline::default()
        }),
        ..Model::default()
    };
    show_at(640.0, model, |ui, model, commands| {
        let state = MenuState {
            context: ActionContext {
                display: DisplaySettings::default(),
                overlay: BvhOverlay::default(),
                gizmo: GizmoSettings::default(),
                paused: model.status.paused,
                panels_shown: true,
                selection: &Selection::default(),
                tool: Default::default(),
                safe_frame: false,
                flying: false,
            },
            camera: None,
            layout: &Layout::default(),
            recent: &[PathBuf::from("/lately/room.xml")],
        };
        menu_bar(ui, model, state, commands);
    })
}

#[test]
fn menus_say_commands() {
    let mut harness = menus(DenoiserState::Idle);
    assert_eq!(harness.state().commands, []);
    click(&mut harness, "File");
    harness.get_by_label_contains("Reload").click();
    harness.run_steps(3);
    click(&mut harness, "View");
    harness.get_by_label_contains("BVH boxes").click();
    harness.run_steps(3);
    click(&mut harness, "View");
    harness.get_by_label_contains("Cameras").click();
    harness.run_steps(4);
    click(&mut harness, "from above");
    click(&mut harness, "Window");
    click(&mut harness, "History");
    click(&mut harness, "Pause");
    click(&mut harness, "Denoise");
    let boxes = BvhOverlay {
        shown: true,
        ..BvhOverlay::default()
    };
    let expected = [
        Command::ReloadScene,
        Command::SetOverlay(boxes),
        Command::LookThrough(entity(9)),
        Command::Shell(ShellCommand::ClosePanel(layout::Panel::History)),
        Command::SetPaused(true),
        Command::Denoise,
    ];
    assert_eq!(harness.state().commands, expected);
}

#[test]
fn without_a_denoiser_there_is_nothing_to_press() {
    let mut harness = menus(DenoiserState::Unavailable);
    click(&mut harness, "Denoise");
    assert_eq!(harness.state().commands, []);
}

#[test]
fn messages_show_place_and_help() {
    let notices = vec![Notice {
        is_error: true,
        place: Some("box.xml:12:5".into()),
        text: "unknown plugin `glas`".into(),
        help: Some("did you mean `dielectric`?".into()),
        excerpt: Some("12 | <bsdf type=\"glas\">\n     ^^^^".into()),
    }];
    let harness = show(notices, |ui, notices, _| diagnostics::diagnostics(ui, notices));
    for text in ["error", "box.xml:12:5", "unknown plugin `glas`"] {
        assert!(harness.query_by_label(text).is_some(), "{text}");
    }
    assert!(harness.query_by_label_contains("did you mean").is_some());
    assert!(harness.query_by_label_contains("^^^^").is_some());
}

#[test]
fn a_click_in_the_history_goes_there() {
    let model = HistoryModel {
        done: vec!["Add: ball".into(), "Move: ball".into()],
        undone: vec!["Hide: ball".into()],
    };
    let mut harness = show(model, history::history);
    // Where we are already there is nowhere to go.
    click(&mut harness, "Move: ball");
    click(&mut harness, "Hide: ball");
    click(&mut harness, "As opened");
    assert_eq!(harness.state().commands, [Command::GoTo(3), Command::GoTo(0)]);
}

#[test]
fn the_status_line_has_the_figures() {
    let status = RenderStatus {
        state: RenderState::Rendering,
        samples: 5,
        target: 64,
        mrays_per_s: 2.345,
        triangles: 871_414,
        ..RenderStatus::default()
    };
    let model = StatusModel {
        status,
        ..StatusModel::default()
    };
    let line: Panel<StatusModel> = |ui, model, _| status::status_line(ui, model);
    let harness = show_at(1280.0, model.clone(), line);
    for text in ["Rendering", "2.35 Mrays/s", "871,414 triangles"] {
        assert!(harness.query_by_label(text).is_some(), "{text}");
    }
    // What has no room is left out, not cut off.
    let harness = show_at(340.0, model, line);
    assert!(harness.query_by_label("Rendering").is_some());
    assert!(harness.query_by_label("871,414 triangles").is_none());
}

/// The picture in a panel of 340 x 240 points, with a text field and a number above it.
struct Picture {
    commands: Vec<Command>,
    state: ViewportState,
    text: String,
    number: f32,
    pose: Affine3A,
}

fn picture() -> Harness<'static, Picture> {
    let picture = Picture {
        commands: Vec::new(),
        state: ViewportState::default(),
        text: String::new(),
        number: 1.0,
        pose: Affine3A::IDENTITY,
    };
    let (boxes, outline, current) = (BoxList::default(), SelectionOutline::default(), CurrentScene::default());
    let selection = Selection::of([entity(1)]);
    let mut harness = Harness::builder().with_size(egui::vec2(340.0, 240.0)).build_ui_state(
        move |ui, picture: &mut Picture| {
            ui.horizontal(|ui| {
                ui.add(egui::TextEdit::singleline(&mut picture.text).desired_width(60.0));
                let name = ui.label("number").id;
                ui.add(egui::DragValue::new(&mut picture.number)).labelled_by(name);
            });
            let locked = Default::default();
            let model = ViewportModel {
                picture: Some((egui::TextureId::default(), [200, 100])),
                proportions: [200, 100],
                mouse: egui::Vec2::ZERO,
                placeholder: "",
                pose: Some(picture.pose),
                camera: Some(Camera::new(picture.pose, 60.0, 2.0, 0.01, 100.0, None)),
                boxes: &boxes,
                outline: &outline,
                icons: &[],
                gizmo: GizmoModel {
                    settings: GizmoSettings::default(),
                    targets: &[],
                    length_step: 1.0,
                    up: Vec3::Y,
                    current: &current,
                },
                locked: &locked,
                current: &current,
                paths: &Default::default(),
                legend: None,
                captions: &[],
                region: None,
                navigation: Navigation::default(),
                keys: ActionContext {
                    display: DisplaySettings::default(),
                    overlay: BvhOverlay::default(),
                    gizmo: GizmoSettings::default(),
                    paused: false,
                    panels_shown: true,
                    selection: &selection,
                    tool: Default::default(),
                    safe_frame: false,
                    flying: false,
                },
                presses: &presses(ui),
                enabled: true,
            };
            viewport(ui, &model, &mut picture.state, &mut picture.commands);
        },
        picture,
    );
    harness.run_steps(3);
    harness
}

fn last_pose(harness: &Harness<Picture>) -> Option<Affine3A> {
    harness.state().commands.iter().rev().find_map(|command| match command {
        Command::MoveView(pose) => Some(*pose),
        _ => None,
    })
}

const MIDDLE: Pos2 = Pos2::new(170.0, 130.0);

#[test]
fn a_material_is_dragged_from_the_list_onto_the_picture() {
    let outline = Outline {
        materials: vec![item(31, "glass")],
        ..Outline::default()
    };
    let state = std::sync::Mutex::new(OutlinerState::default());
    let shown = Shown {
        given: with_outline(outline, Selection::default()),
        commands: Vec::new(),
    };
    let mut harness = Harness::builder().with_size(egui::vec2(540.0, 240.0)).build_ui_state(
        move |ui, shown: &mut Shown<Model>| {
            let mut state = state.lock().expect("one thread");
            let Shown { given, commands } = shown;
            egui::Panel::left("list").exact_size(200.0).show(ui, |ui| {
                outliner::outliner(ui, given, &mut state, commands);
            });
            let picture = ui.available_rect_before_wrap();
            let response = ui.interact(picture, egui::Id::new("picture"), egui::Sense::click_and_drag());
            drop_target(ui, &response, picture, commands);
        },
        shown,
    );
    harness.run_steps(3);
    let line = harness.get_by_label("glass").rect().center();
    let target = Pos2::new(380.0, 120.0);
    harness.hover_at(line);
    harness.run_steps(1);
    harness.drag_at(line);
    harness.run_steps(1);
    for step in 1..=6 {
        harness.hover_at(line.lerp(target, step as f32 / 6.0));
        harness.run_steps(1);
    }
    harness.drop_at(target);
    harness.run_steps(2);
    let [Command::DropMaterial { material, at }] = harness.state().commands[..] else {
        panic!("{:?}", harness.state().commands)
    };
    assert_eq!(material, entity(31));
    assert!(at.min_element() > 0.2 && at.max_element() < 0.8, "{at}");
}

#[test]
fn a_click_picks_and_a_drag_looks() {
    let mut harness = picture();
    assert_eq!(harness.state().commands, []);
    press_at(&mut harness, MIDDLE);
    let [Command::Pick(film, Extend::Replace)] = harness.state().commands[..] else {
        panic!("{:?}", harness.state().commands)
    };
    assert!(film.abs_diff_eq(Vec2::splat(0.5), 0.1), "{film}");
    harness.state_mut().commands.clear();
    harness.drag_at(MIDDLE);
    for step in 1..=5 {
        harness.hover_at(MIDDLE + egui::vec2(15.0 * step as f32, 0.0));
        harness.run_steps(1);
    }
    harness.drop_at(MIDDLE + egui::vec2(75.0, 0.0));
    harness.run_steps(1);
    let pose = last_pose(&harness).expect("looked around");
    assert!(
        pose.matrix3.z_axis.x < 0.0,
        "to the right is -x: {}",
        pose.matrix3.z_axis
    );
    assert!(
        !harness
            .state()
            .commands
            .iter()
            .any(|command| matches!(command, Command::Pick(..)))
    );
}

#[test]
fn keys_fly_unless_a_text_is_being_typed() {
    let mut harness = picture();
    harness.key_down(Key::W);
    harness.run_steps(2);
    harness.key_up(Key::W);
    harness.run_steps(1);
    assert!(last_pose(&harness).is_some_and(|pose| pose.translation.z > 0.0));

    harness.get_by_role(egui::accesskit::Role::TextInput).focus();
    harness.run_steps(2);
    harness.state_mut().commands.clear();
    harness.key_down(Key::W);
    harness.key_press(Key::Space);
    harness.run_steps(2);
    harness.key_up(Key::W);
    harness.run_steps(1);
    assert_eq!(harness.state().commands, []);
}

#[test]
fn keys_work_again_right_after_a_number_was_dragged() {
    let mut harness = picture();
    drag(&mut harness, "number", 30.0);
    assert!(harness.state().number > 1.0);
    harness.state_mut().commands.clear();
    harness.key_press(Key::N);
    harness.run_steps(2);
    assert_eq!(harness.state().commands, [Command::Denoise]);
}

#[test]
fn a_number_is_typed_without_side_effects() {
    let mut harness = picture();
    click(&mut harness, "number");
    harness.key_press_modifiers(Modifiers::COMMAND, Key::A);
    harness.event(egui::Event::Text("42".into()));
    harness.key_press(Key::B);
    harness.run_steps(2);
    harness.key_press(Key::Enter);
    harness.run_steps(3);
    assert_eq!(harness.state().number, 42.0);
    assert_eq!(harness.state().commands, []);
}

#[test]
fn keys_are_commands() {
    let display = DisplaySettings::default();
    let table = [
        (Key::Space, Modifiers::NONE, Command::SetPaused(true)),
        (Key::R, Modifiers::SHIFT, Command::Restart),
        (
            Key::Tab,
            Modifiers::NONE,
            Command::SetDisplay(DisplaySettings {
                mode: DisplayMode::Albedo,
                ..display
            }),
        ),
        (
            Key::CloseBracket,
            Modifiers::NONE,
            Command::SetDisplay(DisplaySettings {
                exposure: 0.25,
                ..display
            }),
        ),
        (
            Key::B,
            Modifiers::NONE,
            Command::SetOverlay(BvhOverlay {
                shown: true,
                ..BvhOverlay::default()
            }),
        ),
        (Key::F, Modifiers::NONE, Command::FrameSelection),
        (Key::Home, Modifiers::NONE, Command::FrameAll),
        (Key::N, Modifiers::NONE, Command::Denoise),
        (
            Key::Escape,
            Modifiers::NONE,
            Command::Select(Vec::new(), Extend::Replace),
        ),
        (
            Key::O,
            Modifiers::COMMAND,
            Command::ShowDialog(FileDialogKind::OpenScene),
        ),
        (Key::S, Modifiers::COMMAND, Command::Save),
        (
            Key::S,
            Modifiers::COMMAND | Modifiers::SHIFT,
            Command::ShowDialog(FileDialogKind::SaveScene),
        ),
        (Key::Z, Modifiers::COMMAND, Command::Undo),
        (Key::Z, Modifiers::COMMAND | Modifiers::SHIFT, Command::Redo),
        (Key::H, Modifiers::NONE, Command::Hide(vec![entity(1)], true)),
        (Key::H, Modifiers::ALT, Command::ShowAll),
    ];
    let mut harness = picture();
    for (key, modifiers, expected) in table {
        harness.state_mut().commands.clear();
        harness.key_press_modifiers(modifiers, key);
        harness.run_steps(2);
        assert_eq!(harness.state().commands, [expected], "{key:?}");
    }
}

#[test]
fn the_wheel_dollies_and_with_the_right_button_sets_the_speed() {
    let wheel = || egui::Event::MouseWheel {
        unit: egui::MouseWheelUnit::Line,
        delta: egui::vec2(0.0, 1.0),
        phase: egui::TouchPhase::Move,
        modifiers: Modifiers::NONE,
    };
    let mut harness = picture();
    harness.hover_at(MIDDLE);
    harness.run_steps(1);
    harness.event(wheel());
    harness.run_steps(1);
    assert!(last_pose(&harness).is_some_and(|pose| pose.translation.z > 0.0));
    harness.state_mut().commands.clear();
    harness.event(egui::Event::PointerButton {
        pos: MIDDLE,
        button: PointerButton::Secondary,
        pressed: true,
        modifiers: Modifiers::NONE,
    });
    harness.event(wheel());
    harness.run_steps(1);
    assert!(matches!(harness.state().commands[..], [Command::SetSpeed(speed)] if speed > 1.0));
}

#[test]
fn the_outliner_hides_renames_and_puts_into_folders() {
    let outline = Outline {
        shapes: vec![item(1, "table/leg"), item(2, "bunny"), item(3, "floor")],
        ..Outline::default()
    };
    let state = std::sync::Mutex::new(OutlinerState::default());
    let shown = Shown {
        given: with_outline(outline, Selection::of([entity(3)])),
        commands: Vec::new(),
    };
    let mut harness = Harness::builder().with_size(egui::vec2(260.0, 400.0)).build_ui_state(
        move |ui, shown: &mut Shown<Model>| {
            let mut state = state.lock().expect("one thread");
            outliner::outliner(ui, &shown.given, &mut state, &mut shown.commands);
        },
        shown,
    );
    harness.run_steps(3);
    // Of what is selected all is hidden, of anything else only that.
    let eyes: Vec<Pos2> = harness
        .query_all_by_label("Hide (H)")
        .map(|eye| eye.rect().center())
        .collect();
    assert_eq!(eyes.len(), 3);
    press_at(&mut harness, eyes[0]);
    assert_eq!(
        harness.state().commands.last(),
        Some(&Command::Hide(vec![entity(1)], true))
    );

    let bunny = harness.get_by_label("bunny").rect().center();
    let leg = harness.get_by_label("leg").rect().center();
    drag_between(&mut harness, bunny, leg);
    let moved = vec![entity(2)];
    let before = Some(entity(1));
    assert_eq!(
        harness.state().commands.last(),
        Some(&Command::Reorder { moved, before })
    );
    let folder = harness.get_by_label("table  (1)").rect().center();
    drag_between(&mut harness, bunny, folder);
    let (things, folder) = (vec![entity(2)], Some("table".to_owned()));
    assert_eq!(
        harness.state().commands.last(),
        Some(&Command::PutInto { things, folder })
    );

    harness.key_press(Key::F2);
    harness.run_steps(3);
    let field = || egui::accesskit::Role::TextInput;
    let name = harness
        .get_all_by_role(field())
        .find(|it| it.value().as_deref() == Some("floor"));
    // The old name is marked, so that what is typed takes its place.
    name.expect("a field with the name").type_text("ground");
    harness.run_steps(2);
    harness.key_press(Key::Enter);
    harness.run_steps(3);
    assert_eq!(
        harness.state().commands.last(),
        Some(&Command::Rename(entity(3), "ground".to_owned()))
    );
}

fn drag_between<T>(harness: &mut Harness<T>, from: Pos2, to: Pos2) {
    harness.hover_at(from);
    harness.run_steps(2);
    harness.drag_at(from);
    harness.run_steps(2);
    for part in 1..=4 {
        harness.hover_at(from + (to - from) * (part as f32 / 4.0));
        harness.run_steps(1);
    }
    harness.drop_at(to);
    harness.run_steps(3);
}
