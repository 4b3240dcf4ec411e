//! Drives what belongs to the window more than to the scene, without a window: the palette, the overview of keys, the
//! preferences and the questions before something is lost.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use bevy::prelude::Entity;
use bevy_egui::egui::{self, Context, Key};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use sunroom::app::editor::automation::script::parse::VERBS;
use sunroom::app::editor::automation::script::verb::Verb;
use sunroom::app::editor::command::addition::AdditionKind;
use sunroom::app::editor::command::display::DisplayMode;
use sunroom::app::editor::command::file_access::Question;
use sunroom::app::editor::command::panel::Panel;
use sunroom::app::editor::command::preferences::{Preferences, ThemeChoice};
use sunroom::app::editor::command::recovery_offer::Offer;
use sunroom::app::editor::command::resolution::FullFilm;
use sunroom::app::editor::command::selection::{Extend, Selection};
use sunroom::app::editor::command::{
    Command, FileCommand, FileDialogKind, HistoryCommand, RenderCommand, SelectionCommand,
};
use sunroom::app::editor::command::{KeptPicture, SceneEdit, ShellCommand};
use sunroom::app::editor::input::actions::{ACTIONS, ActionContext, Group};
use sunroom::app::editor::model::{Item, Model, Outline, StatusModel};
use sunroom::app::editor::panels::preferences::preferences;
use sunroom::app::editor::picture::awaited_image::{AwaitedImage, Before};
use sunroom::app::editor::session::full_film_question::FullFilmQuestion;
use sunroom::app::editor::session::requests::Requests;
use sunroom::app::editor::session::save_question::SaveQuestion;
use sunroom::app::editor::session::toasts::{Toasts, Tone, Topic};
use sunroom::app::editor::window::palette::Palette;
use sunroom::app::editor::window::picture_question::PictureQuestion;
use sunroom::app::editor::window::shortcuts::shortcuts;
use sunroom::app::editor::window::unsaved_question::{UnsavedQuestion, UnsavedState};
use sunroom::app::editor::window::{full_film, recovery_question, save_question, toasts, trust_question};
use sunroom::engine::{RenderState, RenderStatus};
use sunroom::render::tonemap::ToneMap;
use sunroom::scene::write::{OnChange, SaveError};

/// What is shown, what came of it, and whether it is still there.
struct Shown<T> {
    it: T,
    commands: Vec<Command>,
    is_open: bool,
}

type Show<T> = fn(&Context, &mut Shown<T>);

fn show<T: 'static>(it: T, show: Show<T>) -> Harness<'static, Shown<T>> {
    let shown = Shown {
        it,
        commands: Vec::new(),
        is_open: true,
    };
    let mut harness = Harness::builder()
        .with_size(egui::vec2(1280.0, 720.0))
        .build_ui_state(move |ui, shown: &mut Shown<T>| show(&ui.ctx().clone(), shown), shown);
    harness.run_steps(3);
    harness
}

fn press<T>(harness: &mut Harness<T>, key: Key) {
    harness.key_press(key);
    harness.run_steps(3);
}

fn click<T>(harness: &mut Harness<T>, name: &str) {
    harness.get_by_label(name).click();
    harness.run_steps(3);
}

fn bunny() -> Entity {
    Entity::from_raw_u32(7).expect("a small index is valid")
}

fn palette() -> Harness<'static, Shown<(Palette, Model)>> {
    let model = Model {
        outline: Arc::new(Outline {
            shapes: vec![Item {
                entity: bunny(),
                name: "bunny".to_owned(),
                kind: "mesh",
                can_hide: true,
                inside_of: None,
                uses: None,
                properties: None,
                hidden: false,
                locked: false,
            }]
            .into(),
            ..Outline::default()
        }),
        scene_files: Arc::new(vec!["/there/cornell-box.xml".into()]),
        ..Model::default()
    };
    show((Palette::default(), model), |egui, shown| {
        if shown.is_open {
            let (palette, model) = &mut shown.it;
            let selection = Selection::default();
            shown.is_open = palette.show(egui, model, &ActionContext::new(&selection), &[], &mut shown.commands);
        }
    })
}

fn type_text<T>(harness: &mut Harness<T>, text: &str) {
    harness.get_by_role(egui::accesskit::Role::TextInput).type_text(text);
    harness.run_steps(3);
}

#[test]
fn the_palette_runs_what_a_few_letters_find() {
    for (text, expected) in [
        ("undo", Command::from(HistoryCommand::Undo)),
        (
            "cornell",
            Command::from(FileCommand::OpenScene("/there/cornell-box.xml".into())),
        ),
        (
            "bunny",
            Command::from(SelectionCommand::Select(vec![bunny()], Extend::Replace)),
        ),
    ] {
        let mut harness = palette();
        type_text(&mut harness, text);
        press(&mut harness, Key::Enter);
        assert_eq!(
            (harness.state().commands.as_slice(), harness.state().is_open),
            (&[expected][..], false)
        );
    }
}

#[test]
fn the_palette_is_walked_with_the_arrows_and_left_with_escape() {
    let mut harness = palette();
    press(&mut harness, Key::ArrowDown);
    press(&mut harness, Key::ArrowDown);
    press(&mut harness, Key::ArrowUp);
    press(&mut harness, Key::Enter);
    let selection = Selection::default();
    let second = (ACTIONS[1].command)(&ActionContext::new(&selection)).expect("it needs no selection");
    assert_eq!(harness.state().commands, [second]);
    let mut harness = palette();
    type_text(&mut harness, "quit");
    press(&mut harness, Key::Escape);
    assert_eq!((harness.state().commands.len(), harness.state().is_open), (0, false));
}

#[test]
fn what_there_is_nothing_to_do_to_stays_in_the_palette() {
    let mut harness = palette();
    // Nothing is selected.
    type_text(&mut harness, "duplicate");
    press(&mut harness, Key::Enter);
    assert_eq!((harness.state().commands.len(), harness.state().is_open), (0, true));
}

#[test]
fn the_overview_has_every_key_and_closes_by_its_own() {
    for key in [Key::Escape, Key::F1, Key::Questionmark] {
        let mut harness = show((), |egui, shown| {
            if shown.is_open {
                shown.is_open = shortcuts(egui, Default::default(), &Default::default());
            }
        });
        for text in [
            "Ctrl+Shift+Z, Ctrl+Y",
            "Frame the selection",
            "Alt+H",
            "W A S D",
            "F1, ?",
        ] {
            assert!(harness.query_by_label(text).is_some(), "{text}");
        }
        assert!(harness.state().is_open);
        press(&mut harness, key);
        assert!(!harness.state().is_open, "{key:?}");
    }
}

/// A window whose scene has edits until it is saved.
struct Window {
    question: UnsavedQuestion,
    edits: bool,
    dialog_open: bool,
    saves_handled: u64,
    said: Vec<Command>,
}

fn window(said: impl Into<Command>) -> Harness<'static, Shown<Window>> {
    let window = Window {
        question: UnsavedQuestion::default(),
        edits: true,
        dialog_open: false,
        saves_handled: 0,
        said: vec![said.into()],
    };
    show(window, |egui, shown| {
        let window = &mut shown.it;
        let mut commands = std::mem::take(&mut window.said);
        let unsaved = UnsavedState {
            name: "box.xml",
            path: Some(Path::new("/there/box.xml")),
            saved: Some("Last saved at 14:32, 5 minutes ago."),
            edits: window.edits,
            dialog_open: window.dialog_open,
            saves_handled: window.saves_handled,
        };
        window.question.hold(&mut commands, window.edits);
        window.question.show(egui, unsaved, &mut commands);
        shown.commands.append(&mut commands);
    })
}

#[test]
fn unsaved_edits_are_asked_about() {
    let losing = [
        Command::from(FileCommand::Quit),
        Command::from(FileCommand::NewScene),
        Command::from(FileCommand::OpenScene(PathBuf::from("/a.xml"))),
    ];
    for command in losing {
        let mut harness = window(command.clone());
        assert_eq!(harness.state().commands, []);
        for text in ["box.xml", "14:32", "is lost"] {
            assert!(harness.query_by_label_contains(text).is_some(), "{text}");
        }
        click(&mut harness, "Don't save");
        assert_eq!(harness.state().commands.as_slice(), std::slice::from_ref(&command));

        let mut harness = window(command.clone());
        click(&mut harness, "Cancel");
        assert!(harness.query_by_label("Save").is_none());
        harness.state_mut().it.edits = false;
        harness.run_steps(10);
        assert_eq!(harness.state().commands, []);

        let mut harness = window(command.clone());
        click(&mut harness, "Save");
        assert_eq!(harness.state().commands, [Command::from(FileCommand::Save)]);
        harness.state_mut().it.edits = false;
        harness.run_steps(2);
        assert_eq!(harness.state().commands, [Command::from(FileCommand::Save), command]);
    }
    assert_eq!(
        window(HistoryCommand::Undo).state().commands,
        [Command::from(HistoryCommand::Undo)]
    );
}

/// The window may be closed while the palette is open, whose field takes the keyboard.
#[test]
fn a_question_over_the_palette_has_the_keys() {
    let question = UnsavedQuestion::default();
    let it = (Palette::default(), question, vec![Command::from(FileCommand::Quit)]);
    let mut harness = show(it, |egui, shown| {
        let (palette, question, said) = &mut shown.it;
        let (selection, model) = (Selection::default(), Model::default());
        if shown.is_open {
            shown.is_open = palette.show(egui, &model, &ActionContext::new(&selection), &[], &mut shown.commands);
        }
        let unsaved = UnsavedState {
            name: "box.xml",
            path: None,
            saved: None,
            edits: true,
            dialog_open: false,
            saves_handled: 0,
        };
        question.hold(said, true);
        question.show(egui, unsaved, said);
        shown.commands.append(said);
    });
    // Until it can be seen.
    harness.run_steps(20);
    press(&mut harness, Key::Enter);
    assert_eq!(harness.state().commands, [Command::from(FileCommand::Save)]);
    assert!(harness.state().is_open);
}

#[test]
fn a_save_that_needs_a_name_is_waited_for_and_one_that_fails_loses_nothing() {
    let mut harness = window(FileCommand::Quit);
    press(&mut harness, Key::Enter);
    harness.state_mut().it.dialog_open = true;
    harness.run_steps(30);
    harness.state_mut().it.dialog_open = false;
    harness.state_mut().it.edits = false;
    harness.run_steps(1);
    assert_eq!(
        harness.state().commands,
        [Command::from(FileCommand::Save), Command::from(FileCommand::Quit)]
    );

    // The dialog is closed without a name.
    let mut harness = window(FileCommand::Quit);
    press(&mut harness, Key::Enter);
    harness.state_mut().it.saves_handled = 1;
    harness.state_mut().it.dialog_open = true;
    harness.run_steps(2);
    harness.state_mut().it.dialog_open = false;
    harness.run_steps(2);
    harness.state_mut().it.edits = false;
    harness.run_steps(2);
    assert_eq!(harness.state().commands, [Command::from(FileCommand::Save)]);

    let mut harness = window(FileCommand::Quit);
    click(&mut harness, "Save");
    harness.run_steps(30);
    // The save has failed.
    harness.state_mut().it.saves_handled = 1;
    harness.run_steps(2);
    // Saved at another time, for another reason.
    harness.state_mut().it.edits = false;
    harness.run_steps(5);
    assert_eq!(harness.state().commands, [Command::from(FileCommand::Save)]);
}

fn offer() -> Offer {
    let note = r#"{"scene": "/there/box.xml", "time": 0, "process": 1}"#;
    Offer {
        folder: "/recovery/box".into(),
        note: serde_json::from_str(note).expect("a note"),
        ..Offer::default()
    }
}

#[test]
fn a_save_before_a_copy_of_the_scene_is_recovered_asks_nothing_about_that_copy() {
    let recover = |copy| Command::Shell(ShellCommand::Recover(copy));
    let mut other = offer();
    other.note.scene = Some("/there/hut.xml".into());
    let anyway = Command::from(FileCommand::SaveChanged("/there/box.xml".into(), OnChange::Refuse));
    for (copy, save) in [(offer(), anyway), (other, Command::from(FileCommand::Save))] {
        let mut harness = window(recover(copy.clone()));
        assert!(harness.query_by_label_contains("then the copy opens").is_some());
        click(&mut harness, "Save");
        assert_eq!(harness.state().commands, std::slice::from_ref(&save));
        harness.state_mut().it.edits = false;
        harness.run_steps(2);
        assert_eq!(harness.state().commands, [save, recover(copy)]);
    }
}

#[test]
fn recovery_is_offered_once() {
    let ask = || {
        show(Some(offer()), |egui, shown| {
            recovery_question::question(egui, &mut shown.it, &mut shown.commands);
        })
    };
    let mut harness = ask();
    assert!(harness.query_by_label_contains("/there/box.xml").is_some());
    harness.get_by_label_contains("Recover the copy").click();
    harness.run_steps(4);
    assert_eq!(
        harness.state().commands,
        [Command::Shell(ShellCommand::Recover(offer()))]
    );
    assert_eq!(harness.state().it, None);
    let mut harness = ask();
    click(&mut harness, "Discard");
    assert_eq!(
        harness.state().commands,
        [Command::Shell(ShellCommand::DiscardRecovery(offer()))]
    );
    let recover = Command::Shell(ShellCommand::Recover(offer()));
    for (key, expected) in [(Key::Escape, vec![]), (Key::Enter, vec![recover])] {
        let mut harness = ask();
        press(&mut harness, key);
        assert_eq!(harness.state().it, None, "{key:?}");
        assert_eq!(harness.state().commands, expected, "{key:?}");
    }
}

#[test]
fn several_copies_are_listed_with_their_scenes_and_times() {
    let mut other = offer();
    other.note.scene = None;
    other.note.things = Some(3);
    let mut harness = show(vec![offer(), other.clone()], |egui, shown| {
        if shown.is_open {
            shown.is_open = recovery_question::list(egui, &shown.it, &mut shown.commands);
        }
    });
    assert!(harness.query_by_label("/there/box.xml").is_some());
    assert!(
        harness
            .query_by_label("a scene of 3 things that was never saved")
            .is_some()
    );
    let button = harness.get_all_by_label("Recover…").nth(1);
    button.expect("one for each").click();
    harness.run_steps(3);
    let asked = Command::Shell(ShellCommand::AskAboutRecovery(other));
    assert_eq!(
        (&harness.state().commands, harness.state().is_open),
        (&vec![asked], false)
    );
}

#[test]
fn a_key_that_is_held_since_before_the_list_was_open_does_not_close_it() {
    let mut harness = show(vec![offer()], |egui, shown| {
        if shown.is_open {
            shown.is_open = recovery_question::list(egui, &shown.it, &mut shown.commands);
        }
    });
    harness.state_mut().is_open = false;
    harness.run_steps(2);
    harness.state_mut().is_open = true;
    let escape = |pressed| egui::Event::Key {
        key: Key::Escape,
        physical_key: None,
        pressed,
        repeat: false,
        modifiers: egui::Modifiers::NONE,
    };
    for _ in 0..4 {
        harness.input_mut().events.push(escape(true));
        harness.run_steps(1);
        assert!(harness.state().is_open);
    }
    for pressed in [false, true] {
        harness.input_mut().events.push(escape(pressed));
        harness.run_steps(1);
    }
    assert!(!harness.state().is_open);
}

#[test]
fn newer_edits_are_asked_about_before_a_save() {
    let path = PathBuf::from("/there/box.xml");
    let save = Command::from(FileCommand::SaveChanged(path.clone(), OnChange::Refuse));
    let recover = Command::Shell(ShellCommand::Recover(offer()));
    let ask = || {
        let requests = Requests {
            save_question: Some(SaveQuestion::about_copy(offer(), &path)),
            ..Requests::default()
        };
        show(requests, |egui, shown| {
            save_question::show(egui, &mut shown.it, &mut shown.commands);
        })
    };
    for (button, expected) in [
        ("Recover", vec![recover.clone()]),
        ("Save anyway", vec![save]),
        ("Cancel", Vec::new()),
    ] {
        let mut harness = ask();
        assert!(harness.query_by_label_contains("/there/box.xml").is_some());
        click(&mut harness, button);
        assert_eq!(harness.state().commands, expected, "{button}");
        assert_eq!(harness.state().it.save_question, None, "{button}");
    }
    let mut harness = ask();
    press(&mut harness, Key::Enter);
    assert_eq!(harness.state().commands, [recover]);
    assert_eq!(harness.state().it.save_question, None);
}

#[test]
fn files_outside_the_scenes_folder_are_asked_about() {
    let asked = Question {
        files: (0..8)
            .map(|number| format!("/elsewhere/a/../{number}.png").into())
            .collect(),
        shown: (0..8).map(|number| format!("/elsewhere/{number}.png").into()).collect(),
        folders: vec!["/elsewhere".into()],
        is_needed: false,
        edit: None,
    };
    let needed = "the scene cannot be shown without them, and the last one stays.";
    let ask = || {
        show(Some(asked.clone()), |egui, shown| {
            trust_question::question(egui, &mut shown.it, &mut shown.commands);
        })
    };
    let mut harness = ask();
    assert!(harness.query_by_label("/elsewhere/0.png").is_some());
    assert!(harness.query_by_label("... and 2 more").is_some());
    assert!(harness.query_by_label("/elsewhere").is_some());
    assert!(harness.query_by_label(needed).is_none());
    click(&mut harness, "Read them");
    let allowed = Command::Shell(ShellCommand::AllowFiles(asked.clone()));
    assert_eq!(harness.state().commands, [allowed]);
    assert_eq!(harness.state().it, None);
    let mut harness = ask();
    click(&mut harness, "Leave them out");
    assert_eq!((harness.state().it.as_ref(), harness.state().commands.len()), (None, 0));
    let without_them = Question {
        is_needed: true,
        ..asked.clone()
    };
    let harness = show(Some(without_them), |egui, shown| {
        trust_question::question(egui, &mut shown.it, &mut shown.commands);
    });
    assert!(harness.query_by_label(needed).is_some());
    let imported = Question {
        edit: Some(SceneEdit::Import("/downloads/chair.xml".into())),
        ..asked
    };
    let harness = show(Some(imported), |egui, shown| {
        trust_question::question(egui, &mut shown.it, &mut shown.commands);
    });
    assert!(
        harness
            .query_by_label("chair.xml names files that it may not read:")
            .is_some()
    );
}

#[test]
fn a_large_film_is_rendered_when_the_user_says_so() {
    let question = FullFilmQuestion {
        request: FullFilm {
            save_to: Some("a.png".into()),
            is_confirmed: false,
        },
        size: bevy::math::UVec2::new(8000, 8000),
        bytes: 7_424_000_000,
        budget: 18_000_000_000,
    };
    let text = "The full film has 8000 × 8000 pixels and takes 7.4 GB of memory; the program may take 18.0 GB in all.";
    assert_eq!(question.text(), text);
    for (button, expected) in [("Render the full film", true), ("Cancel", false)] {
        let mut harness = show(Some(question.clone()), |egui, shown| {
            full_film::question(egui, &mut shown.it, &mut shown.commands);
        });
        assert!(harness.query_by_label(text).is_some());
        click(&mut harness, button);
        assert_eq!(harness.state().it, None);
        let confirmed = Command::from(RenderCommand::RenderFull(question.clone().confirmed()));
        let commands = if expected { vec![confirmed] } else { Vec::new() };
        assert_eq!(harness.state().commands, commands);
    }
    let confirmed = Command::from(RenderCommand::RenderFull(question.clone().confirmed()));
    for (key, expected) in [(Key::Escape, vec![]), (Key::Enter, vec![confirmed])] {
        let mut harness = show(Some(question.clone()), |egui, shown| {
            full_film::question(egui, &mut shown.it, &mut shown.commands);
        });
        press(&mut harness, key);
        assert_eq!((&harness.state().it, &harness.state().commands), (&None, &expected));
    }
}

#[test]
fn the_full_film_of_an_image_can_be_given_up() {
    let status = StatusModel {
        status: RenderStatus {
            state: RenderState::Rendering,
            size: bevy::math::UVec2::new(1000, 1000),
            full_size: bevy::math::UVec2::new(1000, 1000),
            seconds: 4.0,
            msamples_per_s: 0.5,
            ..RenderStatus::default()
        },
        awaited_image: Some(AwaitedImage {
            path: "/shots/a.png".into(),
            samples: 8,
            is_denoised: false,
            before: Before::Smaller { exact_samples: None },
        }),
        ..StatusModel::default()
    };
    let mut harness = show(status, |egui, shown| {
        let viewport = egui::Rect::from_min_size(egui::Pos2::ZERO, egui::vec2(800.0, 600.0));
        full_film::progress(egui, &shown.it, viewport, &mut shown.commands);
    });
    assert!(
        harness
            .query_by_label("Rendering all 1000 × 1000 pixels for a.png")
            .is_some()
    );
    click(&mut harness, "Cancel");
    assert_eq!(harness.state().commands, [Command::from(RenderCommand::StopFull)]);
    // All samples are there, and the filter is at work.
    let status = &mut harness.state_mut().it;
    status.status.state = RenderState::Done;
    status
        .awaited_image
        .iter_mut()
        .for_each(|image| image.is_denoised = true);
    harness.run_steps(3);
    assert!(
        harness
            .query_by_label("Denoising 1000 × 1000 pixels for a.png")
            .is_some()
    );
}

#[test]
fn an_unfinished_picture_is_asked_about() {
    let close = |is_worth_it: bool| {
        let said = vec![Command::from(HistoryCommand::Undo), Command::from(FileCommand::Quit)];
        show((PictureQuestion::default(), said, is_worth_it), |egui, shown| {
            let (question, said, is_worth_it) = &mut shown.it;
            let mut commands = std::mem::take(said);
            question.hold(&mut commands, *is_worth_it);
            question.show(egui, 3723.0, &mut commands);
            shown.commands.append(&mut commands);
        })
    };
    assert_eq!(
        close(false).state().commands,
        [Command::from(HistoryCommand::Undo), Command::from(FileCommand::Quit)]
    );
    let keep = Command::KeptPicture(KeptPicture::KeepAndQuit);
    for (answer, expected) in [
        ("Keep", Some(keep.clone())),
        ("Don't keep", Some(FileCommand::Quit.into())),
        ("Cancel", None),
    ] {
        let mut harness = close(true);
        assert_eq!(harness.state().commands, [Command::from(HistoryCommand::Undo)]);
        assert!(harness.state().it.0.is_asking());
        assert!(harness.query_by_label_contains("1:02:03").is_some());
        click(&mut harness, answer);
        let said: Vec<Command> = std::iter::once(Command::from(HistoryCommand::Undo))
            .chain(expected)
            .collect();
        assert_eq!(harness.state().commands, said, "{answer}");
        assert!(!harness.state().it.0.is_asking(), "{answer}");
    }
    let mut harness = close(true);
    press(&mut harness, Key::Enter);
    assert_eq!(harness.state().commands, [Command::from(HistoryCommand::Undo), keep]);
}

/// `docs/scripts.md` has the tables of the program.
#[test]
fn the_page_about_scripts_lists_what_the_program_accepts() {
    let page = include_str!("../../docs/scripts.md");
    let rows: Vec<Vec<String>> = page
        .lines()
        .filter(|line| line.starts_with("| `"))
        .map(|line| {
            let cells = line.trim_matches('|').replace("\\|", "\u{0}");
            cells.split('|').map(|cell| cell.trim().replace('\u{0}', "|")).collect()
        })
        .collect();
    let known: Vec<&Verb> = VERBS.into_iter().flatten().collect();
    let (verbs, actions) = rows.split_at(known.len());
    for (row, verb) in verbs.iter().zip(known) {
        assert_eq!(row[..2], [format!("`{}`", verb.name), verb.usage.to_owned()]);
        assert!(row[2].ends_with('.'), "{row:?}");
    }
    let listed = actions.iter().map(|row| (row[0].clone(), row[1].clone()));
    let known = ACTIONS.iter().map(|action| {
        let group = Group::ALL.iter().find(|(group, _)| *group == action.group);
        let (_, group) = group.expect("every group has a name");
        (format!("`{}`", action.name), format!("{group}: {}", action.label))
    });
    assert_eq!(listed.collect::<Vec<_>>(), known.collect::<Vec<_>>());
    let list = |names: Vec<String>| {
        names
            .iter()
            .map(|name| format!("`{name}`"))
            .collect::<Vec<_>>()
            .join(", ")
    };
    let kinds = AdditionKind::all().map(|kind| kind.name().to_owned());
    let modes = DisplayMode::ALL.map(|(_, name)| name.to_lowercase().replace(' ', "-"));
    let maps = ToneMap::ALL.map(|map| map.name().to_owned());
    for (verb, names) in [
        ("`add` knows the kinds", list(kinds.collect())),
        ("`show` knows the modes", list(modes.to_vec())),
        ("`tone-map` knows", list(maps.to_vec())),
    ] {
        assert!(page.contains(&format!("{verb} {names}.")), "{verb} {names}");
    }
}

#[test]
fn preferences_are_said_when_they_change_and_only_then() {
    let mut harness = show(Preferences::default(), |egui, shown| {
        egui::Window::new("preferences").show(egui, |ui| {
            preferences(ui, &shown.it, Some("it is broken"), &mut shown.commands);
        });
    });
    assert_eq!(harness.state().commands, []);
    assert!(harness.query_by_label("it is broken").is_some());
    click(&mut harness, "Light");
    match harness.state().commands.first() {
        Some(Command::Shell(ShellCommand::SetPreferences(changed))) => {
            let expected = Preferences {
                theme: ThemeChoice::Light,
                ..Preferences::default()
            };
            assert_eq!(**changed, expected);
        }
        other => panic!("{other:?}"),
    }
    harness.state_mut().commands.clear();
    let memory = harness.get_by_role_and_label(egui::accesskit::Role::SpinButton, "Memory");
    let start = memory.rect().center();
    harness.hover_at(start);
    harness.run_steps(1);
    harness.drag_at(start);
    harness.run_steps(1);
    harness.hover_at(start + egui::vec2(40.0, 0.0));
    harness.run_steps(1);
    match harness.state().commands.last() {
        Some(Command::Shell(ShellCommand::SetPreferences(changed))) => {
            let gib = changed.memory_gib;
            assert!(gib > 0 && changed.memory_limit() == u64::from(gib) << 30, "{gib}");
        }
        other => panic!("{other:?}"),
    }
    harness.drop_at(start + egui::vec2(40.0, 0.0));
    harness.run_steps(2);
    click(&mut harness, "Reset layout");
    assert_eq!(harness.state().commands.last(), Some(&ShellCommand::ResetLayout.into()));
}

/// A window with nothing but a picture.
fn around(egui: &Context) -> toasts::Surroundings {
    toasts::Surroundings {
        panel: egui.content_rect(),
        bars: Vec::new(),
        has_question: false,
    }
}

#[test]
fn messages_leave_the_bar_and_questions_free() {
    let mut said = Toasts::default();
    said.add(Tone::Note, Topic::Other, "Saved".into(), None);
    let bar = egui::Rect::from_min_size(egui::pos2(800.0, 120.0), egui::vec2(380.0, 30.0));
    let harness = show(said.clone(), |egui, shown| {
        let bar = egui::Rect::from_min_size(egui::pos2(800.0, 120.0), egui::vec2(380.0, 30.0));
        let around = toasts::Surroundings {
            bars: vec![bar],
            ..around(egui)
        };
        toasts::show(&mut shown.it, None, egui, around, &mut shown.commands);
    });
    assert!(harness.get_by_label("Saved").rect().top() > bar.bottom());
    // Bars at the foot of the picture, one of them far to the left.
    let harness = show(said.clone(), |egui, shown| {
        let window = egui.content_rect();
        let bar = |left: f32, height: f32| {
            let corner = egui::pos2(left, window.bottom() - height);
            egui::Rect::from_min_size(corner, egui::vec2(300.0, height))
        };
        let right = window.right() - 320.0;
        let around = toasts::Surroundings {
            bars: vec![bar(right, 30.0), bar(right, 70.0), bar(window.left(), 130.0)],
            ..around(egui)
        };
        toasts::show(&mut shown.it, None, egui, around, &mut shown.commands);
    });
    let above = harness.ctx.content_rect().bottom() - harness.get_by_label("Saved").rect().bottom();
    assert!((70.0..120.0).contains(&above), "{above}");
    // The message is below the veil of a question.
    let harness = show(said, |egui, shown| {
        recovery_question::question(egui, &mut Some(offer()), &mut shown.commands);
        let around = toasts::Surroundings {
            has_question: true,
            ..around(egui)
        };
        toasts::show(&mut shown.it, None, egui, around, &mut shown.commands);
    });
    let at = harness.get_by_label("Saved").rect().center();
    let top = harness.ctx.layer_id_at(at).expect("a layer");
    assert_ne!(top.id, egui::Id::new("toasts"));
}

#[test]
fn an_error_stays_shows_its_line_and_leads_to_the_messages() {
    let mut toasts = Toasts::default();
    let line = "12 | <bsdf type=\"glas\">\n     ^^^^";
    toasts.add(
        Tone::Error,
        Topic::SceneFile,
        "box.xml is broken".into(),
        Some(line.into()),
    );
    toasts.add(Tone::Note, Topic::Other, "Saved".into(), None);
    let harness = show(toasts.clone(), |egui, shown| {
        toasts::show(
            &mut shown.it,
            Some(Tone::Error),
            egui,
            around(egui),
            &mut shown.commands,
        );
    });
    // While a question is open.
    assert!(harness.query_by_label(line).is_none() && harness.query_by_label("Saved").is_some());
    let mut harness = show(toasts, |egui, shown| {
        toasts::show(&mut shown.it, None, egui, around(egui), &mut shown.commands);
    });
    assert!(harness.query_by_label(line).is_some());
    click(&mut harness, "Messages");
    assert_eq!(
        harness.state().commands,
        [Command::Shell(ShellCommand::ShowPanel(Panel::Messages))]
    );
    // The newest message is the lowest.
    harness.get_all_by_label("×").last().expect("a button").click();
    harness.run_steps(3);
    assert_eq!(harness.state().it.texts().collect::<Vec<_>>(), ["box.xml is broken"]);
}

/// A window that asks how to save a file that others changed.
fn changed_file(edited_twice: Option<&[&str]>) -> Harness<'static, Shown<Requests>> {
    let path = PathBuf::from("/there/box.xml");
    let error = SaveError::Changed {
        path: path.clone(),
        edited_twice: edited_twice.map(|names| names.iter().map(|name| (*name).to_owned()).collect()),
    };
    let requests = Requests {
        save_question: SaveQuestion::about(&error, &path),
        ..Requests::default()
    };
    show(requests, |egui, shown| {
        save_question::show(egui, &mut shown.it, &mut shown.commands);
    })
}

#[test]
fn a_file_that_others_changed_is_asked_about_once() {
    let save = |on_change| Command::from(FileCommand::SaveChanged("/there/box.xml".into(), on_change));
    for (button, expected) in [
        ("Merge and save", vec![save(OnChange::TakeIn)]),
        ("Overwrite", vec![save(OnChange::Overwrite)]),
        ("Cancel", Vec::new()),
    ] {
        let mut harness = changed_file(Some(&["lamp", "table"]));
        assert!(
            harness
                .query_by_label_contains("lamp and table were edited both there and here")
                .is_some()
        );
        click(&mut harness, button);
        assert_eq!(harness.state().commands, expected, "{button}");
        assert_eq!(harness.state().it.save_question, None, "{button}");
    }
    let mut harness = changed_file(Some(&["lamp"]));
    press(&mut harness, Key::Enter);
    assert!(
        harness.state().it.save_question.is_some(),
        "only a button says what is meant"
    );
    press(&mut harness, Key::Escape);
    assert_eq!(
        (harness.state().commands.len(), &harness.state().it.save_question),
        (0, &None)
    );
    // Without knowing what was read nothing can be merged.
    assert!(changed_file(None).query_by_label("Merge and save").is_none());
}

#[test]
fn while_another_name_is_chosen_the_question_is_not_over() {
    let mut harness = changed_file(Some(&["lamp"]));
    click(&mut harness, "Save as...");
    let state = &harness.state().it;
    assert_eq!(state.dialog, Some(FileDialogKind::SaveScene));
    assert!(state.save_question.is_some() && harness.query_by_label("Overwrite").is_none());
    harness.state_mut().it.dialog = None;
    harness.run_steps(2);
    assert_eq!(harness.state().it.save_question, None);
}
