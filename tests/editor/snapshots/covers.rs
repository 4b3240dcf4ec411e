//! Menus, the toolbar, and what covers the window: pages, lists, dialogs, questions, messages.

use std::path::{Path, PathBuf};

use bevy::math::{Affine3A, Quat, UVec2, Vec3};
use bevy_egui::egui::{self, Context, Pos2, Rect, TextureId, Ui, vec2};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use image::{RgbImage, imageops};
use sunroom::app::editor::command::asset_kind::FileUse;
use sunroom::app::editor::command::file_access::Question as AccessQuestion;
use sunroom::app::editor::command::key_bindings::NO_BINDINGS;
use sunroom::app::editor::command::preferences::Preferences;
use sunroom::app::editor::command::recovery_offer::{Note, Offer};
use sunroom::app::editor::command::resolution::FullFilm;
use sunroom::app::editor::command::selection::Selection;
use sunroom::app::editor::command::{Command, FileCommand};
use sunroom::app::editor::input::actions::ActionContext;
use sunroom::app::editor::model::{MissingItem, Model, StatusModel};
use sunroom::app::editor::panels::key_bindings::{KeyList, key_bindings};
use sunroom::app::editor::panels::menu_bar::{MenuState, menu_bar};
use sunroom::app::editor::panels::missing_files::{self as missing, MissingForm};
use sunroom::app::editor::panels::series::{SeriesForm, series};
use sunroom::app::editor::session::full_film_question::FullFilmQuestion;
use sunroom::app::editor::session::layout::Layout;
use sunroom::app::editor::session::toasts::{Toasts, Topic};
use sunroom::app::editor::session::tutorial::Tutorial;
use sunroom::app::editor::viewport::icons::{Icon, IconKind};
use sunroom::app::editor::viewport::model::ViewportModel;
use sunroom::app::editor::viewport::state::ViewportState;
use sunroom::app::editor::viewport::viewport;
use sunroom::app::editor::window::file_dialog::listing::Entry;
use sunroom::app::editor::window::file_dialog::{FileDialog, Place, Purpose};
use sunroom::app::editor::window::palette::Palette;
use sunroom::app::editor::window::shortcuts::shortcuts;
use sunroom::app::editor::window::unsaved_question::{UnsavedQuestion, UnsavedState};
use sunroom::app::editor::window::{full_film, recovery_question, scene_question, start_page, toasts, trust_question};
use sunroom::render::camera::Camera;
use sunroom::scene::FileKind;

use super::scene::{entity, model};
use super::{in_both_themes, panel};
use crate::support::ViewportContent;

/// A cover over a window of this size, which is shown alone.
fn cover<T: Clone + 'static>(
    size: [u32; 2],
    given: T,
    show: impl Fn(&Context, &mut T) + Clone + 'static,
    act: impl Fn(&mut Harness<T>),
) -> RgbImage {
    in_both_themes(size, given, move |ui, given| show(ui.ctx(), given), act)
}

/// Edits that were left behind, at no time that a clock shows.
fn offer() -> Offer {
    Offer {
        folder: "/recovery/1".into(),
        note: Note {
            scene: Some("/rooms/attic.xml".into()),
            time: u64::MAX,
            ..Note::default()
        },
        ..Offer::default()
    }
}

/// Without what is above and below in both halves, as a dialog is in the middle of the window.
fn cropped(picture: &RgbImage, top: u32, height: u32) -> RgbImage {
    let height = height.min(picture.height().saturating_sub(top)).max(1);
    imageops::crop_imm(picture, 0, top, picture.width(), height).to_image()
}

fn page(preferences: Preferences, left: Vec<Offer>) -> RgbImage {
    let show = move |context: &Context, preferences: &mut Preferences| {
        let selection = Selection::default();
        let actions = ActionContext::new(&selection);
        start_page::show(context, preferences, &left, &actions, &[], &mut Vec::new());
    };
    cropped(&cover([1120, 540], preferences, show, |_| ()), 0, 540)
}

pub fn start_page() -> RgbImage {
    let mut preferences = Preferences::default();
    for file in [
        "/rooms/flat.xml",
        "/rooms/old/flat.xml",
        "/levels/castle of sand/keep.xml",
        "/home/cb.xml",
    ] {
        preferences.note_recent(Path::new(file));
    }
    page(preferences, vec![offer()])
}

pub fn start_page_of_a_first_start() -> RgbImage {
    page(Preferences::default(), Vec::new())
}

pub fn preferences() -> RgbImage {
    let show = |ui: &mut Ui, preferences: &mut Preferences| {
        sunroom::app::editor::panels::preferences::preferences(ui, preferences, None, &mut Vec::new());
    };
    panel([492, 640], Preferences::default(), show, |_| ())
}

pub fn key_list() -> RgbImage {
    let show = |ui: &mut Ui, list: &mut KeyList| _ = key_bindings(ui, list, &NO_BINDINGS, &[]);
    panel([492, 420], KeyList::searching("view"), show, |_| ())
}

pub fn key_overview() -> RgbImage {
    let show = |context: &Context, (): &mut ()| _ = shortcuts(context, Default::default(), &NO_BINDINGS);
    cover([1200, 700], (), show, |_| ())
}

pub fn palette() -> RgbImage {
    let show = |context: &Context, palette: &mut Palette| {
        let selection = Selection::default();
        palette.show(context, &model(), &ActionContext::new(&selection), &[], &mut Vec::new());
    };
    cover([600, 420], Palette::default(), show, |harness| {
        let field = harness.get_by_role(egui::accesskit::Role::TextInput);
        field.type_text("wall");
        harness.run_steps(3);
    })
}

fn dialog(title: &str, purpose: Purpose) -> RgbImage {
    let place = |name: &str, is_recent| Place {
        name: name.to_owned(),
        folder: Path::new("/home").join(name),
        is_recent,
    };
    let places = vec![
        place("Home", false),
        place("Sample scenes", false),
        place("rooms", true),
    ];
    let entry = |(name, is_folder, bytes): (&str, bool, u64)| Entry {
        name: name.to_owned(),
        is_folder,
        bytes,
        changed: 0,
    };
    let entries = [
        ("textures", true, 0),
        ("flat.xml", false, 11_880),
        (
            "a room with a view and a name that is far too long for its column of the table.xml",
            false,
            2_913,
        ),
        ("hundred-spheres.xml", false, 27_332),
    ];
    let dialog = FileDialog::new(title, purpose, PathBuf::from("/"), places)
        .with_entries(PathBuf::from("/home/rooms"), entries.map(entry).into());
    let show = |context: &Context, dialog: &mut FileDialog| _ = dialog.show(context);
    cropped(&cover([880, 600], dialog, show, |_| ()), 40, 520)
}

pub fn file_dialog() -> RgbImage {
    dialog("Open a scene", Purpose::Open(&["xml"]))
}

pub fn save_dialog() -> RgbImage {
    const FORMATS: &[(&str, &str)] = &[("PNG", "png"), ("EXR", "exr")];
    dialog("Save the picture", Purpose::Save(FORMATS, "flat.png".to_owned()))
}

fn menu(title: &'static str, size: [u32; 2]) -> RgbImage {
    let model = Model {
        status: StatusModel {
            scene: Some("/rooms/flat.xml".into()),
            unsaved: true,
            ..StatusModel::default()
        },
        ..model()
    };
    let show = |ui: &mut Ui, model: &mut Model| {
        let selection = Selection::of([entity(2)]);
        let state = MenuState {
            context: ActionContext {
                denoising: true,
                ..ActionContext::new(&selection)
            },
            camera: Some(entity(60)),
            layout: &Layout::default(),
            recent: &[PathBuf::from("/rooms/flat.xml")],
        };
        egui::Panel::top("menus").show(ui, |ui| menu_bar(ui, model, state, &mut Vec::new()));
    };
    in_both_themes(size, model, show, |harness| {
        harness.get_by_label(title).click();
        harness.run_steps(4);
    })
}

pub fn file_menu() -> RgbImage {
    menu("File", [640, 540])
}

pub fn edit_menu() -> RgbImage {
    menu("Edit", [640, 620])
}

pub fn add_menu() -> RgbImage {
    menu("Add", [640, 860])
}

pub fn arrange_menu() -> RgbImage {
    menu("Arrange", [640, 560])
}

pub fn time_menu() -> RgbImage {
    menu("Time", [640, 560])
}

pub fn view_menu() -> RgbImage {
    menu("View", [640, 720])
}

pub fn render_menu() -> RgbImage {
    menu("Render", [640, 520])
}

pub fn window_menu() -> RgbImage {
    menu("Window", [640, 440])
}

/// The picture with its bars. Neither handles nor an outline are shown, as there is no scene.
pub fn toolbar() -> RgbImage {
    picture(Vec::new())
}

/// The icons of lights and cameras in the picture, one of them selected.
pub fn icons() -> RgbImage {
    let kinds = [
        IconKind::Bulb,
        IconKind::Sun,
        IconKind::Sheet,
        IconKind::Cone(0.5),
        IconKind::Frustum,
        IconKind::Box,
        IconKind::StandIn,
    ];
    let icon = |(kind, number): (IconKind, u16)| Icon {
        entity: entity(1 + u32::from(number)),
        kind,
        tint: None,
        pose: Affine3A::from_scale_rotation_translation(
            Vec3::splat(0.3),
            Quat::from_rotation_x(1.2),
            Vec3::new(f32::from(number % 4) - 1.5, 1.4 - f32::from(number / 4), 0.0),
        ),
    };
    picture(kinds.into_iter().zip(0..).map(icon).collect())
}

fn picture(icons: Vec<Icon>) -> RgbImage {
    let show = move |ui: &mut Ui, (): &mut ()| {
        let content = ViewportContent {
            selection: Selection::of([entity(1)]),
            ..ViewportContent::default()
        };
        // Along -z and a little down.
        let turn = Quat::from_rotation_y(std::f32::consts::PI) * Quat::from_rotation_x(0.3);
        let pose = Affine3A::from_rotation_translation(turn, Vec3::new(0.0, 1.5, 4.0));
        let camera = Camera::new(pose, 60.0, 4.0 / 3.0, 0.01, 100.0, None);
        let model = ViewportModel {
            picture: Some((TextureId::User(0), [640, 480])),
            icons: &icons,
            ..content.model([640, 480], pose, camera, &[])
        };
        viewport(ui, &model, &mut ViewportState::default(), &mut Vec::new());
    };
    in_both_themes([640, 480], (), show, |_| ())
}

pub fn series_of_copies() -> RgbImage {
    let show = |ui: &mut Ui, form: &mut SeriesForm| _ = series(ui, form, Vec3::X, &mut Vec::new());
    panel([332, 240], SeriesForm::default(), show, |_| ())
}

pub fn missing_files() -> RgbImage {
    let items = ["/models/chairs/chair with a long name.obj", "/models/lamp.obj"].map(|path| MissingItem {
        kind: FileKind::Mesh,
        path: path.into(),
    });
    let show = move |ui: &mut Ui, form: &mut MissingForm| {
        missing::missing_files(ui, form, &items, &mut Vec::new());
    };
    panel([492, 300], MissingForm::default(), show, |_| ())
}

pub fn unsaved_edits() -> RgbImage {
    let show = |context: &Context, (): &mut ()| {
        let mut question = UnsavedQuestion::default();
        let mut commands = vec![Command::from(FileCommand::Quit)];
        question.hold(&mut commands, true);
        let unsaved = UnsavedState {
            name: "flat.xml",
            path: Some(Path::new("/rooms/flat.xml")),
            saved: Some("Last saved at 14:32, 5 minutes ago."),
            edits: true,
            dialog_open: false,
            saves_handled: 0,
        };
        question.show(context, unsaved, &mut commands);
    };
    cropped(&cover([560, 400], (), show, |_| ()), 70, 260)
}

pub fn recovery() -> RgbImage {
    let show = |context: &Context, offer: &mut Option<Offer>| {
        recovery_question::question(context, offer, &mut Vec::new());
    };
    cropped(&cover([560, 400], Some(offer()), show, |_| ()), 60, 280)
}

pub fn render_full_film() -> RgbImage {
    let question = FullFilmQuestion {
        request: FullFilm {
            save_to: Some("a.png".into()),
            is_confirmed: false,
        },
        size: UVec2::new(8000, 8000),
        bytes: 7_424_000_000,
        budget: 18_000_000_000,
    };
    let show = |context: &Context, asked: &mut Option<FullFilmQuestion>| {
        full_film::question(context, asked, &mut Vec::new());
    };
    cropped(&cover([560, 400], Some(question), show, |_| ()), 80, 240)
}

pub fn dropped_scene() -> RgbImage {
    let file = FileUse {
        path: "/rooms/flat.xml".into(),
        at: None,
        bounds: None,
    };
    let show = |context: &Context, asked: &mut Option<FileUse>| {
        scene_question::question(context, asked, &mut Vec::new());
    };
    cropped(&cover([560, 400], Some(file), show, |_| ()), 80, 240)
}

pub fn access_to_files() -> RgbImage {
    let files: Vec<PathBuf> = (0..3).map(|number| format!("/elsewhere/{number}.png").into()).collect();
    let question = AccessQuestion {
        shown: files.clone(),
        files,
        folders: vec!["/elsewhere".into()],
        is_needed: false,
        edit: None,
    };
    let show = |context: &Context, asked: &mut Option<AccessQuestion>| {
        trust_question::question(context, asked, &mut Vec::new());
    };
    cropped(&cover([560, 440], Some(question), show, |_| ()), 50, 340)
}

pub fn messages_over_the_picture() -> RgbImage {
    let mut toasts = Toasts::default();
    let kept = "Saved /rooms/flat.xml";
    // Other notes disappear while a slow machine draws them.
    toasts.report(kept.to_owned());
    let refused =
        "The scene could not be saved: /rooms of other people/levels/flat.xml: Operation not permitted (os error 1)";
    toasts.error(Topic::Saving, refused, None);
    let show = |context: &Context, toasts: &mut Toasts| {
        let around = toasts::Surroundings {
            panel: Rect::from_min_size(Pos2::ZERO, vec2(560.0, 360.0)),
            bars: Vec::new(),
            has_question: false,
        };
        toasts::show(toasts, None, context, around, &mut Vec::new());
    };
    cover([560, 360], toasts, show, |_| ())
}

pub fn tutorial() -> RgbImage {
    let mut begun = Tutorial::default();
    begun.go_to(Some(0));
    let show = |context: &Context, tutorial: &mut Tutorial| {
        let place = Rect::from_min_size(Pos2::ZERO, vec2(560.0, 240.0));
        sunroom::app::editor::window::tutorial::show(context, tutorial, place, &mut Vec::new());
    };
    cover([560, 250], begun, show, |_| ())
}
