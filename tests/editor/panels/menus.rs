//! Menus, messages, the history and the status line.

use std::path::PathBuf;

use bevy_egui::egui::Key;
use egui_kittest::Harness;
use egui_kittest::kittest::{NodeT, Queryable};
use sunroom::app::editor::command::ShellCommand;
use sunroom::app::editor::command::bvh_overlay::BvhOverlay;
use sunroom::app::editor::command::selection::Selection;
use sunroom::app::editor::command::{
    Command, DisplayCommand, FileCommand, HistoryCommand, RenderCommand, ViewCommand, panel,
};
use sunroom::app::editor::input::actions::{ActionContext, find};
use sunroom::app::editor::model::{HistoryModel, Model, Notice, Outline, StatusModel};
use sunroom::app::editor::panels::menu_bar::{MenuState, menu_bar};
use sunroom::app::editor::panels::{diagnostics, history, status};
use sunroom::app::editor::picture::denoiser::DenoiserState;
use sunroom::app::editor::session::layout::Layout;
use sunroom::document::Severity;
use sunroom::engine::{RenderState, RenderStatus};

use super::{Panel, Shown, click, entity, item, show, show_at};

fn menus(denoiser: DenoiserState) -> Harness<'static, Shown<Model>> {
    let model = Model {
        status: StatusModel {
            denoiser,
            ..StatusModel::default()
        },
        scene_files: std::sync::Arc::new(vec!["/there/cornell-box.xml".into()]),
        outline: std::sync::Arc::new(Outline {
            sensors: vec![item(9, "from above")].into(),
            ..Outline::default()
        }),
        ..Model::default()
    };
    show_at(640.0, model, |ui, model, commands| {
        let selection = Selection::default();
        let state = MenuState {
            context: ActionContext {
                paused: model.status.paused,
                ..ActionContext::new(&selection)
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
    let mut harness = menus(DenoiserState::Off);
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
        Command::from(FileCommand::ReloadScene),
        Command::from(DisplayCommand::SetOverlay(boxes)),
        Command::from(ViewCommand::LookThrough(entity(9))),
        Command::Shell(ShellCommand::ClosePanel(panel::Panel::History)),
        Command::from(RenderCommand::SetPaused(true)),
        Command::from(DisplayCommand::SetDenoising(true)),
    ];
    assert_eq!(harness.state().commands, expected);
}

#[test]
fn what_has_nothing_to_do_is_grey() {
    let mut harness = menus(DenoiserState::Off);
    click(&mut harness, "File");
    for entry in ["Missing files…", "Revert to the file"] {
        assert!(
            harness.get_by_label_contains(entry).accesskit_node().is_disabled(),
            "{entry}"
        );
    }
    let selection = Selection::default();
    let context = ActionContext {
        has_missing: true,
        can_revert: true,
        ..ActionContext::new(&selection)
    };
    for name in ["missing-files", "revert"] {
        let action = find(name).expect("an action");
        assert!((action.command)(&context).is_some(), "{name}");
    }
}

#[test]
fn without_a_kept_picture_there_is_none_to_resume() {
    let mut harness = menus(DenoiserState::Off);
    for entry in ["Resume the kept picture", "Remove the kept picture"] {
        click(&mut harness, "File");
        assert!(harness.get_by_label_contains(entry).accesskit_node().is_disabled());
        harness.get_by_label_contains(entry).hover();
        // The tool tip waits for a moment.
        harness.run_steps(40);
        assert!(
            harness.query_by_label_contains("No picture is kept").is_some(),
            "{entry}"
        );
        click(&mut harness, "File");
    }
    let selection = Selection::default();
    let kept = ActionContext {
        has_kept_picture: true,
        ..ActionContext::new(&selection)
    };
    let resume = find("continue-picture").expect("an action");
    assert!((resume.command)(&kept).is_some() && (resume.command)(&ActionContext::new(&selection)).is_none());
}

#[test]
fn an_open_menu_gives_way_to_the_one_that_is_pointed_at() {
    let mut harness = menus(DenoiserState::Off);
    let shows = |harness: &Harness<Shown<Model>>, entry: &str| harness.query_by_label_contains(entry).is_some();
    harness.get_by_label("Edit").hover();
    harness.run_steps(3);
    assert!(!shows(&harness, "Undo"), "a menu opens by a click");
    click(&mut harness, "File");
    assert!(shows(&harness, "Reload"));
    harness.get_by_label("Edit").hover();
    harness.run_steps(3);
    assert!(shows(&harness, "Undo") && !shows(&harness, "Reload"));
    // The same place shuts it.
    click(&mut harness, "Edit");
    assert!(!shows(&harness, "Undo"));
    harness.get_by_label("File").hover();
    harness.run_steps(3);
    assert!(!shows(&harness, "Reload"));
    // Escape shuts it as well, under the pointer.
    click(&mut harness, "File");
    harness.key_press(Key::Escape);
    harness.run_steps(3);
    assert!(!shows(&harness, "Reload"));
}

#[test]
fn without_a_denoiser_there_is_nothing_to_press() {
    let mut harness = menus(DenoiserState::Unavailable);
    click(&mut harness, "Denoise");
    assert_eq!(harness.state().commands, []);
}

#[test]
fn messages_show_place_and_help() {
    let error = Notice {
        severity: Severity::Error,
        place: Some("box.xml:12:5".into()),
        text: "unknown plugin `glas`".into(),
        help: Some("did you mean `dielectric`?".into()),
        excerpt: Some("12 | <bsdf type=\"glas\">\n     ^^^^".into()),
    };
    let note = Notice {
        severity: Severity::Note,
        place: None,
        text: "rotations are read as degrees".into(),
        help: None,
        excerpt: None,
    };
    let notices = vec![error, note];
    let harness = show(notices, |ui, notices, _| diagnostics::diagnostics(ui, notices));
    for text in ["error", "box.xml:12:5", "unknown plugin `glas`", "note"] {
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
    assert_eq!(
        harness.state().commands,
        [
            Command::from(HistoryCommand::GoTo(3)),
            Command::from(HistoryCommand::GoTo(0))
        ]
    );
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
        frame_ms: Some(12.0),
        ..StatusModel::default()
    };
    let line: Panel<StatusModel> = |ui, model, _| status::status_line(ui, model, None);
    let harness = show_at(1280.0, model.clone(), line);
    for text in ["Rendering", "2.35 Mrays/s", "871,414 triangles"] {
        assert!(harness.query_by_label(text).is_some(), "{text}");
    }
    assert!(harness.query_by_label("frame 12 ms").is_none());
    let developers = StatusModel {
        developer_figures: true,
        ..model.clone()
    };
    let harness = show_at(1280.0, developers, line);
    assert!(harness.query_by_label("frame 12 ms").is_some());
    // What has no room is left out, not cut off.
    let harness = show_at(340.0, model, line);
    assert!(harness.query_by_label("Rendering").is_some());
    assert!(harness.query_by_label("871,414 triangles").is_none());
}
