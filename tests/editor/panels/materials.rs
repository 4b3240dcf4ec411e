//! Materials in the inspector, and the library.

use bevy::math::Vec2;
use bevy::prelude::Entity;
use bevy_egui::egui::{self, Key, Modifiers, Pos2};
use egui_kittest::kittest::Queryable;
use sunroom::app::editor::command::material_tree::MaterialTree;
use sunroom::app::editor::command::selection::Selection;
use sunroom::app::editor::command::{
    Command, EditCommand, FileCommand, FileDialogKind, MaterialEdit, ValueEdit, presets,
};
use sunroom::app::editor::model::{Inspected, InspectedMaterial, MaterialPlace, Model, Outline};
use sunroom::app::editor::panels::library::{self, LibraryState};
use sunroom::color::Rgb;
use sunroom::scene::{ConductorIor, Material, Parameter, Shape, SquarePath, Texture};

use super::inspector::inspect;
use super::subjects::{checkerboard, textured, with_material};
use super::{click, drag, drag_between, entity, item, press_and_move_in_one_frame, show_beside_picture, slide};

fn only_material(commands: &[Command]) -> &Material {
    match commands.last() {
        Some(Command::Edit(EditCommand::Value(ValueEdit::SetMaterial(target, material)))) if *target == entity(7) => {
            material
        }
        other => panic!("no material was set: {other:?}"),
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
    let dialog = Command::from(FileCommand::ShowDialog(FileDialogKind::OpenPicture {
        owner: entity(7),
        parameter: "reflectance",
        place: SquarePath::WHOLE.within(0),
    }));
    assert_eq!(harness.state().commands, [dialog]);
}

#[test]
fn colours_are_typed_as_srgb_too() {
    let mut harness = inspect(with_material(Material::Diffuse {
        reflectance: Rgb::splat(0.5).into(),
    }));
    click(&mut harness, "RGB");
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

fn shown_tree(commands: &[Command]) -> (&[Entity], &MaterialTree) {
    match commands {
        [Command::Edit(EditCommand::Material(MaterialEdit::BuildMaterial { targets, tree }))] => (targets, tree),
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
    harness.get_by_label("Metal ⏵").click();
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
fn a_preset_is_clicked_or_dragged_out_of_the_library() {
    // The metals alone, which fit into the panel.
    let presets = presets::load().0.into_iter();
    let metals = presets.filter(|preset| preset.path().starts_with("Metal/"));
    let model = Model {
        presets: std::sync::Arc::new(metals.collect()),
        outline: std::sync::Arc::new(Outline {
            shapes: vec![item(5, "ball"), item(6, "floor")].into(),
            ..Outline::default()
        }),
        selection: Selection::of([entity(5), entity(9)]),
        ..Model::default()
    };
    let mut state = LibraryState::default();
    let mut harness = show_beside_picture(egui::vec2(600.0, 400.0), 220.0, model, move |ui, model, commands| {
        library::library(ui, model, &mut state, commands);
    });
    click(&mut harness, "silver");
    // The light among what is selected has no material.
    assert!(matches!(
        &harness.state().commands[..],
        [Command::Edit(EditCommand::Material(MaterialEdit::UsePreset { preset, shapes }))] if preset.path() == "Metal/silver" && *shapes == [entity(5)]
    ));
    let gold = harness.get_by_label("gold").rect().center();
    drag_between(&mut harness, gold, Pos2::new(410.0, 200.0));
    let Some(Command::Edit(EditCommand::Material(MaterialEdit::DropPreset { preset, at }))) =
        harness.state().commands.last()
    else {
        panic!("{:?}", harness.state().commands)
    };
    assert_eq!(preset.path(), "Metal/gold");
    assert!(at.abs_diff_eq(Vec2::splat(0.5), 0.1), "{at}");
    // In a slow frame the press and the way onto the next material come together.
    let neighbor = harness.get_by_label("silver").rect().center();
    press_and_move_in_one_frame(&mut harness, gold, neighbor);
    harness.hover_at(Pos2::new(410.0, 200.0));
    harness.run_steps(2);
    harness.drop_at(Pos2::new(410.0, 200.0));
    harness.run_steps(2);
    let commands = &harness.state().commands;
    assert_eq!(commands.len(), 3, "{commands:?}");
    assert!(
        matches!(&commands[2], Command::Edit(EditCommand::Material(MaterialEdit::DropPreset { preset, .. })) if preset.path() == "Metal/gold")
    );
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

/// A bump map with a diffuse material inside.
fn bumpy_clay() -> Inspected {
    let mut wrapped = with_material(Material::of_plugin("bumpmap").unwrap());
    wrapped.materials[0].inside = vec![entity(9)];
    wrapped.materials.push(InspectedMaterial {
        entity: entity(9),
        name: "clay".into(),
        material: Material::default().into(),
        place: MaterialPlace::Inside,
        path: vec![0],
        mixed: Default::default(),
        users: 0,
        inside: Vec::new(),
    });
    wrapped
}

#[test]
fn the_parts_of_a_nested_material_are_chosen_in_a_tree() {
    let mut harness = inspect(bumpy_clay());
    assert!(harness.query_by_label("Reflectance source").is_none());
    click(&mut harness, "diffuse");
    click(&mut harness, "Reflectance source");
    click(&mut harness, "checkerboard");
    let [Command::Edit(EditCommand::Value(ValueEdit::SetMaterial(target, _)))] = &harness.state().commands[..] else {
        panic!("{:?}", harness.state().commands)
    };
    assert_eq!(*target, entity(9));
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

    let mut harness = inspect(bumpy_clay());
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
fn what_refracts_is_not_offered_for_one_of_two_sides() {
    for place in [MaterialPlace::Front, MaterialPlace::Back, MaterialPlace::Inside] {
        let mut inspected = with_material(Material::default());
        inspected.materials[0].place = place;
        let mut harness = inspect(inspected);
        harness.state_mut().given.presets = std::sync::Arc::new(presets::load().0);
        harness.run_steps(2);
        let is_offered = place == MaterialPlace::Inside;
        click(&mut harness, "Presets");
        assert_eq!(
            harness.query_by_label_contains("Glass").is_some(),
            is_offered,
            "{place:?}"
        );
        assert!(harness.query_by_label("Metal ⏵").is_some(), "{place:?}");
        click(&mut harness, "Presets");
        click(&mut harness, "Type");
        for plugin in ["dielectric", "rough dielectric", "thin dielectric"] {
            assert_eq!(
                harness.query_by_label(plugin).is_some(),
                is_offered,
                "{place:?} {plugin}"
            );
        }
        assert!(harness.query_by_label("plastic").is_some(), "{place:?}");
    }
}

#[test]
fn a_shape_takes_another_material_or_a_new_one() {
    let shape = Inspected {
        shape: Some(Shape::default()),
        uses_material: Some(entity(30)),
        ..Inspected::new(entity(5), "wall")
    };
    let mut harness = inspect(shape.clone());
    click(&mut harness, "Made of");
    click(&mut harness, "glass");
    let used = Command::from(MaterialEdit::UseMaterial {
        shapes: vec![entity(5)],
        material: Some(entity(31)),
    });
    assert_eq!(harness.state().commands, [used]);
    let mut harness = inspect(shape);
    click(&mut harness, "New material");
    assert_eq!(
        harness.state().commands,
        [Command::from(MaterialEdit::GiveMaterial { shape: entity(5) })]
    );
}
