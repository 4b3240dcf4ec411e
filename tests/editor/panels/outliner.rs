//! The list of everything in the scene.

use bevy_egui::egui::{self, Key, Pos2};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use sunroom::app::editor::command::selection::{Extend, Selection};
use sunroom::app::editor::command::{Command, OutlineEdit, SelectionCommand};
use sunroom::app::editor::model::{Model, Outline};
use sunroom::app::editor::panels::outliner;
use sunroom::app::editor::panels::outliner::state::OutlinerState;

use super::{Shown, click, drag_between, entity, item, press_at, with_outline};

#[test]
fn the_outliner_selects_and_finds() {
    let outline = Outline {
        shapes: vec![item(1, "floor"), item(2, "bunny")].into(),
        lights: vec![item(3, "lamp")].into(),
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
        [Command::from(SelectionCommand::Select(
            vec![entity(2)],
            Extend::Replace
        ))]
    );
    harness.get_by_role(egui::accesskit::Role::TextInput).focus();
    harness.run_steps(2);
    harness.get_by_role(egui::accesskit::Role::TextInput).type_text("LAM");
    harness.run_steps(3);
    assert!(harness.query_by_label("bunny").is_none());
    assert!(harness.query_by_label("lamp").is_some());
}

#[test]
fn the_outliner_hides_renames_and_puts_into_folders() {
    let outline = Outline {
        shapes: vec![item(1, "table/leg"), item(2, "bunny"), item(3, "floor")].into(),
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
        .query_all_by_label("Hide")
        .map(|eye| eye.rect().center())
        .collect();
    assert_eq!(eyes.len(), 3);
    press_at(&mut harness, eyes[0]);
    assert_eq!(
        harness.state().commands.last(),
        Some(&OutlineEdit::Hide(vec![entity(1)], true).into())
    );

    let bunny = harness.get_by_label("bunny").rect().center();
    let leg = harness.get_by_label("leg").rect().center();
    drag_between(&mut harness, bunny, leg);
    let moved = vec![entity(2)];
    let before = Some(entity(1));
    assert_eq!(
        harness.state().commands.last(),
        Some(&OutlineEdit::Reorder { moved, before }.into())
    );
    let folder = harness.get_by_label("table  (1)").rect().center();
    drag_between(&mut harness, bunny, folder);
    let (things, folder) = (vec![entity(2)], Some("table".to_owned()));
    assert_eq!(
        harness.state().commands.last(),
        Some(&OutlineEdit::PutInto { things, folder }.into())
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
        Some(&OutlineEdit::Rename(entity(3), "ground".to_owned()).into())
    );
}

#[test]
fn what_is_selected_elsewhere_is_seen_in_the_list() {
    let things = |first: u32, count: u32| {
        (first..first + count)
            .map(|index| item(index, &format!("thing {index}")))
            .collect()
    };
    let outline = Outline {
        shapes: things(1, 100),
        lights: things(200, 100),
        ..Outline::default()
    };
    let state = std::sync::Mutex::new(OutlinerState::default());
    let shown = Shown {
        given: with_outline(outline, Selection::default()),
        commands: Vec::new(),
    };
    let mut harness = Harness::builder().with_size(egui::vec2(240.0, 300.0)).build_ui_state(
        move |ui, shown: &mut Shown<Model>| {
            let mut state = state.lock().expect("one thread");
            outliner::outliner(ui, &shown.given, &mut state, &mut shown.commands);
        },
        shown,
    );
    harness.run_steps(3);
    // Closes the shapes: the triangle is left of their heading.
    let heading = harness.get_by_label("Shapes").rect();
    press_at(&mut harness, heading.left_center() - egui::vec2(8.0, 0.0));
    assert!(harness.query_by_label("thing 1").is_none());
    for wanted in [60, 250] {
        harness.state_mut().given.selection = Selection::of([entity(wanted)]);
        harness.run_steps(4);
        assert!(harness.query_by_label(&format!("thing {wanted}")).is_some(), "{wanted}");
    }
}

#[test]
fn a_folder_has_an_eye_and_a_shape_names_its_material() {
    let mut hidden = item(1, "table/leg");
    hidden.hidden = true;
    let mut top = item(2, "table/top");
    top.uses = Some(entity(5));
    let outline = Outline {
        shapes: vec![hidden, top].into(),
        materials: vec![item(5, "oak")].into(),
        ..Outline::default()
    };
    let state = std::sync::Mutex::new(OutlinerState::default());
    let shown = Shown {
        given: with_outline(outline, Selection::default()),
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
    // Some of it is visible.
    let eye = harness.get_by_label("Hide everything in the folder").rect().center();
    press_at(&mut harness, eye);
    let members = vec![entity(1), entity(2)];
    assert_eq!(
        harness.state().commands,
        [Command::from(OutlineEdit::Hide(members, true))]
    );
}
