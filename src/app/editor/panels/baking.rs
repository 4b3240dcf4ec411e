//! The form for a bake of lightmaps, and the panel of a running bake.

use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};

use bevy_egui::egui::{
    self, Color32, Label, ProgressBar, Rect, Response, RichText, Sense, TextEdit, TextureHandle, Ui, pos2, vec2,
};

use super::caption::Caption;
use super::status::{percent, roughly};
use super::{fields, look, typed};
use crate::app::editor::command::baking::{BakeChoices, BakeCommand};
use crate::app::editor::command::compare_view::CompareView;
use crate::app::editor::command::shell::{Sheet, ShellCommand};
use crate::app::editor::command::{Command, DisplayCommand, FileCommand, FileDialogKind};
use crate::app::editor::model::baking::{BakeModel, ShownBake};
use crate::app::editor::words::figures::legible;
use crate::app::editor::words::files::home_for_tilde;
use crate::bake::limits::USUAL_SAMPLES;
use crate::bake::progress::{Gathered, Stage};
use crate::bake::unwrap::ATLAS_SIZES;

const OTHER_SCENE: &str = "The bake is of the scene that was open when it began";
/// The largest width of the picture of a lightmap, in points.
const PICTURE: f32 = 440.0;

/// The form. It is kept while the window is open.
#[derive(Clone, Debug, Default)]
pub struct BakeForm {
    /// The typed folder.
    folder: String,
    /// The folder that the text was last set from.
    known: Option<PathBuf>,
}

/// Shows the form. Returns true when it is finished.
pub fn form(ui: &mut Ui, form: &mut BakeForm, model: &BakeModel, commands: &mut Vec<Command>) -> bool {
    if form.known != model.folder {
        form.folder = model
            .folder
            .as_deref()
            .map_or(String::new(), |path| path.display().to_string());
        form.known.clone_from(&model.folder);
    }
    let field = folder_row(ui, &mut form.folder, commands);
    let folder = meant(&form.folder, model.scene_folder.as_deref());
    whole_path(ui, &form.folder, folder.as_deref());
    let mut choices = model.choices;
    choice_rows(ui, &mut choices);
    if choices != model.choices {
        commands.push(BakeCommand::Choose(choices).into());
    }
    let text = "The bake uses the scene as it is now, without hidden things. You can go on editing while it runs.";
    ui.add(Label::new(RichText::new(text).weak()).wrap());
    ui.add_space(6.0);
    let is_ready = folder.is_some() && !model.is_busy();
    let (mut bakes, mut cancels) = (false, false);
    let enters = field.lost_focus() && ui.input_mut(|input| input.consume_key(egui::Modifiers::NONE, egui::Key::Enter));
    let size = vec2(ui.available_width(), ui.spacing().interact_size.y);
    ui.allocate_ui_with_layout(size, egui::Layout::right_to_left(egui::Align::Center), |ui| {
        let button = look::primary_if(ui, is_ready, "Bake");
        let button = ui
            .add_enabled(is_ready, button)
            .on_hover_text("Bakes the level, its lightmaps and its probes into the folder")
            .on_disabled_hover_text(match model.is_busy() {
                true => "A bake is under way",
                false => "A bake needs a folder",
            });
        bakes = button.clicked();
        cancels = ui.button("Cancel").on_hover_text("Esc").clicked();
    });
    bakes |= enters && is_ready;
    if let Some(folder) = folder.filter(|_| bakes) {
        commands.push(BakeCommand::Begin(folder).into());
    }
    bakes || cancels
}

/// The folder that a typed text names; None if it names none. `beside` is the folder that the text is relative to.
fn meant(text: &str, beside: Option<&Path>) -> Option<PathBuf> {
    let text = text.trim();
    let typed = home_for_tilde(text);
    let path = beside.map_or(typed.clone(), |beside| beside.join(typed));
    (!text.is_empty()).then(|| std::path::absolute(&path).unwrap_or(path))
}

/// Shows the absolute path of a relative text.
fn whole_path(ui: &mut Ui, text: &str, folder: Option<&Path>) {
    let Some(folder) = folder.filter(|folder| *folder != Path::new(text.trim())) else {
        return;
    };
    ui.horizontal(|ui| {
        fields::name_cell(ui, "");
        let path = RichText::new(folder.display().to_string()).weak();
        ui.add(Label::new(path).wrap());
    });
}

fn folder_row(ui: &mut Ui, folder: &mut String, commands: &mut Vec<Command>) -> Response {
    const BUTTON: f32 = 74.0;
    fields::row(ui, "Folder", |ui| {
        let width = ui.available_width() - BUTTON;
        let hint = "for the level and its lightmaps";
        let field = ui.add(TextEdit::singleline(folder).desired_width(width).hint_text(hint));
        if ui.button("Choose…").clicked() {
            commands.push(FileCommand::ShowDialog(FileDialogKind::BakeFolder).into());
        }
        field
    })
}

fn choice_rows(ui: &mut Ui, choices: &mut BakeChoices) {
    let about = |name: &'static str, about: &'static str| Caption::from(name).explained(about);
    let texels = about(
        "Texels per unit",
        "How fine lightmaps are. Without a number they are as fine as one lightmap of the page size allows.",
    );
    optional(
        ui,
        texels,
        &mut choices.texels_per_unit,
        16.0,
        1e-3..=1e6,
        ("", "automatic"),
    );
    let page = about(
        "Page size",
        "The width of a lightmap in texels, and its largest height.",
    );
    fields::integer(ui, page, &mut choices.atlas_size, ATLAS_SIZES);
    let usual = match choices.time.or(choices.noise) {
        Some(_) => "as many as the limits allow".to_owned(),
        None => format!("{USUAL_SAMPLES}, the default"),
    };
    let samples = about("Samples", "The samples of each texel.");
    optional(
        ui,
        samples,
        &mut choices.samples,
        USUAL_SAMPLES,
        1..=1 << 24,
        ("", &usual),
    );
    let noise = about(
        "Stop at noise",
        "The root mean square error of texels relative to their luminance, as estimated.",
    );
    let mut in_percent = choices.noise.map(|noise| 100.0 * noise);
    if optional(ui, noise, &mut in_percent, 2.0, 1e-3..=100.0, (" %", "no limit")) {
        choices.noise = in_percent.map(|noise| noise / 100.0);
    }
    let time = about(
        "Stop after",
        "The time for the lightmaps, which end at the end of a round of samples.",
    );
    optional(ui, time, &mut choices.time, 60.0, 0.1..=1e7, (" s", "no limit"));
    let light = about(
        "Light",
        "`indirect only` leaves the direct light of points, spots and directional lights to the game, which has these lights in the level.",
    );
    fields::switch(
        ui,
        light,
        &mut choices.indirect_only,
        &[(false, "all"), (true, "indirect only")],
    );
    fields::checkbox(
        ui,
        about("Probes", "Reflection probes and irradiance volumes."),
        &mut choices.probes,
    );
    ui.add_enabled_ui(cfg!(feature = "denoise"), |ui| {
        fields::checkbox(
            ui,
            about("Denoise", "Noise is removed with Open Image Denoise."),
            &mut choices.denoise,
        )
    });
}

/// A switch with a number beside it if it is on, and with a word if it is off. `words` are the unit and that word.
/// Returns true if edited.
fn optional<N: egui::emath::Numeric>(
    ui: &mut Ui,
    caption: Caption,
    value: &mut Option<N>,
    first: N,
    range: RangeInclusive<N>,
    words: (&str, &str),
) -> bool {
    let mut copy = *value;
    let mut is_on = copy.is_some();
    let mut changed = false;
    ui.horizontal(|ui| {
        let name = fields::name_cell(ui, caption);
        let switch = ui.add(egui::Checkbox::without_text(&mut is_on));
        switch.widget_info(|| egui::WidgetInfo::selected(egui::WidgetType::Checkbox, true, is_on, caption.text));
        if switch.labelled_by(name.id).changed() {
            copy = is_on.then_some(first);
            changed = true;
        }
        match &mut copy {
            Some(number) => {
                let drag = egui::DragValue::new(number)
                    .clamp_existing_to_range(false)
                    .suffix(words.0);
                let drag = typed::number(ui, drag, caption.text, range, legible);
                changed |= fields::wide_number(ui, drag).changed();
            }
            None => {
                ui.weak(words.1);
            }
        }
    });
    fields::write_back(changed, value, copy)
}

/// Shows that there is no bake.
pub fn no_bake(ui: &mut Ui, commands: &mut Vec<Command>) {
    ui.add_space(8.0);
    ui.weak("No bake is under way.");
    ui.add_space(4.0);
    if ui.button("Bake lightmaps…").clicked() {
        commands.push(ShellCommand::ShowSheet(Sheet::Bake).into());
    }
}

/// Shows the running bake, or the ended one.
pub fn progress(ui: &mut Ui, shown: &ShownBake, picture: Option<&TextureHandle>, commands: &mut Vec<Command>) {
    let news = &shown.news;
    if shown.is_busy {
        let stage = match shown.is_stopped {
            true => "Writing what there is",
            false => &news.stage,
        };
        ui.add(Label::new(stage).truncate());
        let done = news.progress.map_or(0.0, |progress| progress.done as f32);
        ui.add(ProgressBar::new(done).text(RichText::new(bar_text(shown)).small()));
    } else {
        ui.add(Label::new(format!("The level is in {}", shown.folder.display())).wrap());
    }
    ui.add_space(2.0);
    page(ui, shown, picture, commands);
    ui.add_space(4.0);
    let mut is_compared = matches!(shown.view, CompareView::Baked(_));
    let can_compare = shown.is_of_open_scene || is_compared;
    let checkbox = egui::Checkbox::new(&mut is_compared, "Beside the picture");
    let compares = ui.add_enabled(can_compare, checkbox);
    let hint = "Shows the level as its lightmaps light it, left of a border in the picture: diffuse surfaces alone, as a game would";
    let compares = compares.on_hover_text(hint).on_disabled_hover_text(OTHER_SCENE);
    if compares.changed() {
        let view = match is_compared {
            true => CompareView::Baked(0.5),
            false => CompareView::Off,
        };
        commands.push(DisplayCommand::SetCompareView(view).into());
    }
    if let Some(reason) = &news.blind {
        ui.add(Label::new(RichText::new(reason).weak()).wrap());
    }
    ui.add_space(4.0);
    ui.horizontal(|ui| {
        let mut say = |ui: &mut Ui, is_enabled: bool, text: &str, hint: &str, command: BakeCommand| {
            let button = ui.add_enabled(is_enabled, egui::Button::new(text));
            if button.on_hover_text(hint).on_disabled_hover_text(hint).clicked() {
                commands.push(Command::Bake(command));
            }
        };
        if shown.is_busy {
            let stop = match (news.samples, news.stays) {
                (0, _) => "Before the first sample of all texels there is nothing to write".to_owned(),
                (_, Some(there)) => {
                    format!("The folder keeps its level until this bake has more: that one has {there}")
                }
                _ => "Ends the gathering of light, and writes what there is".to_owned(),
            };
            let can_stop = !shown.is_stopped && shown.can_stop();
            say(ui, can_stop, "Stop", &stop, BakeCommand::Stop);
            say(
                ui,
                true,
                "Discard",
                "Gives the bake up: nothing is written",
                BakeCommand::Discard,
            );
        } else {
            say(
                ui,
                true,
                "Close",
                "Frees the memory of the lightmaps",
                BakeCommand::Close,
            );
        }
    });
}

/// Samples, noise and the time left.
fn bar_text(shown: &ShownBake) -> String {
    let Some(progress) = &shown.news.progress else {
        return String::new();
    };
    let mut parts: Vec<String> = progress.gathered.iter().flat_map(of_gathered).collect();
    if parts.is_empty() {
        parts.push(format!("{:.0} %", 100.0 * progress.done));
    }
    if matches!(progress.stage, Stage::Lightmaps | Stage::Probe(_))
        && let Some(left) = progress.left()
    {
        parts.push(format!("{} left", roughly(left.as_secs_f64())));
    }
    parts.join("  ")
}

fn of_gathered(gathered: &Gathered) -> Vec<String> {
    let samples = match gathered.target {
        u32::MAX => format!("{} spp", gathered.samples),
        target => format!("{}/{target} spp", gathered.samples),
    };
    let noise = gathered.noise.map(|noise| format!("noise {}", percent(noise)));
    std::iter::once(samples).chain(noise).collect()
}

/// The chooser of the lightmap, and its picture.
fn page(ui: &mut Ui, shown: &ShownBake, picture: Option<&TextureHandle>, commands: &mut Vec<Command>) {
    let news = &shown.news;
    ui.horizontal(|ui| {
        if news.pages > 1 {
            let mut chosen = shown.page.min(news.pages - 1);
            egui::ComboBox::from_id_salt("lightmap")
                .selected_text(format!("Lightmap {chosen}"))
                .show_ui(ui, |ui| {
                    for page in 0..news.pages {
                        ui.selectable_value(&mut chosen, page, format!("Lightmap {page}"));
                    }
                });
            if chosen != shown.page {
                commands.push(BakeCommand::ShowPage(chosen).into());
            }
        }
        if news.pages > 0 {
            let [width, height] = news.page_size;
            let hint = "Each as a white surface would look there, with the exposure and the tone map of the picture";
            ui.weak(format!("{width} × {height} texels")).on_hover_text(hint);
        }
    });
    let width = ui.available_width().min(PICTURE);
    let [across, down] = news.page_size.map(|side| side as f32);
    let height = if news.pages > 0 { width * down / across } else { width };
    let (place, _) = ui.allocate_exact_size(vec2(width, height), Sense::hover());
    let painter = ui.painter_at(place);
    painter.rect_filled(place, 2.0, Color32::from_gray(24));
    match picture {
        Some(picture) => {
            let size = picture.size_vec2();
            let scale = (place.size() / size).min_elem();
            let shown = Rect::from_center_size(place.center(), size * scale);
            let whole = Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0));
            painter.image(picture.id(), shown, whole, Color32::WHITE);
        }
        None => {
            let font = egui::TextStyle::Body.resolve(ui.style());
            let text = "no light yet";
            painter.text(
                place.center(),
                egui::Align2::CENTER_CENTER,
                text,
                font,
                Color32::from_gray(150),
            );
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_typed_folder_counts_from_that_of_the_scene() {
        let here = std::env::current_dir().expect("a working directory");
        let home = std::env::home_dir().expect("a home folder");
        let scene = Path::new("/levels");
        for (text, beside, expected) in [
            ("game/level", Some(scene), Some("/levels/game/level".into())),
            (" /game/level ", Some(scene), Some("/game/level".into())),
            ("~/level", Some(scene), Some(home.join("level"))),
            ("~", None, Some(home.clone())),
            ("~other", Some(scene), Some("/levels/~other".into())),
            ("level", None, Some(here.join("level"))),
            ("level", Some(Path::new("scenes")), Some(here.join("scenes/level"))),
            // The parent of a plain name.
            ("level", Some(Path::new("")), Some(here.join("level"))),
            ("  ", Some(scene), None),
        ] {
            assert_eq!(meant(text, beside), expected, "{text}");
        }
    }

    /// Runs a frame of the form with these events.
    fn frame(context: &egui::Context, form_state: &mut BakeForm, events: Vec<egui::Event>) -> (Vec<Command>, bool) {
        let (mut commands, mut is_done) = (Vec::new(), false);
        let input = egui::RawInput {
            screen_rect: Some(Rect::from_min_size(egui::Pos2::ZERO, vec2(800.0, 600.0))),
            events,
            ..Default::default()
        };
        let model = BakeModel {
            scene_folder: Some("/levels".into()),
            ..BakeModel::default()
        };
        let _ = context.run_ui(input, |ui| {
            is_done = form(ui, form_state, &model, &mut commands);
        });
        (commands, is_done)
    }

    #[test]
    fn enter_in_the_field_of_the_folder_begins_the_bake() {
        let key = |key| egui::Event::Key {
            key,
            physical_key: None,
            pressed: true,
            repeat: false,
            modifiers: egui::Modifiers::NONE,
        };
        let begun = Command::Bake(BakeCommand::Begin("/levels/game".into()));
        for (text, expected) in [("", (Vec::new(), false)), ("game", (vec![begun], true))] {
            let (context, mut state) = (egui::Context::default(), BakeForm::default());
            frame(&context, &mut state, Vec::new());
            // The field is the first control.
            frame(&context, &mut state, vec![key(egui::Key::Tab)]);
            frame(&context, &mut state, vec![egui::Event::Text(text.to_owned())]);
            let entered = frame(&context, &mut state, vec![key(egui::Key::Enter)]);
            assert_eq!(entered, expected, "{text}");
        }
    }
}
