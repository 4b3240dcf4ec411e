//! The command palette: a few letters find an action, a scene file or a thing in the scene. Used with the keyboard.

use std::path::Path;

use bevy_egui::egui::{self, Align2, Button, Id, Key, Modal, Modifiers, RichText, Ui};

use super::dialog;
use crate::app::editor::command::key_bindings::KeyBindings;
use crate::app::editor::command::selection::Extend;
use crate::app::editor::command::{Command, FileCommand, SelectionCommand};
use crate::app::editor::input::actions::{ACTIONS, Action, ActionContext, Group, Shortcut};
use crate::app::editor::model::{Item, Model};

/// The query, and the selected row.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Palette {
    query: String,
    chosen: usize,
}

/// A row of the list.
#[derive(Clone, Copy)]
pub enum Hit<'a> {
    /// An action of the table.
    Action(&'static Action),
    /// A scene file to open.
    Scene(&'a Path),
    /// A thing of the scene to select.
    Thing(&'a Item),
}

impl Hit<'_> {
    fn text(&self) -> String {
        match self {
            Self::Action(action) => title(action),
            Self::Scene(path) => path.file_name().unwrap_or_default().to_string_lossy().into_owned(),
            Self::Thing(item) => item.name.clone(),
        }
    }

    /// The faint text at the right: keys, or the kind of hit.
    fn remark(&self, bound: &KeyBindings) -> String {
        match self {
            Self::Action(action) => action.key_text(bound),
            Self::Scene(path) => match path.parent().and_then(Path::file_name) {
                Some(folder) => format!("open scene in {}", folder.to_string_lossy()),
                None => "open scene".to_owned(),
            },
            Self::Thing(item) => item.kind.to_owned(),
        }
    }

    /// The command of the hit. None if it has nothing to apply to.
    fn command(&self, context: &ActionContext) -> Option<Command> {
        match self {
            Self::Action(action) => (action.command)(context),
            Self::Scene(path) => Some(FileCommand::OpenScene(path.to_path_buf()).into()),
            Self::Thing(item) => Some(SelectionCommand::Select(vec![item.entity], Extend::Replace).into()),
        }
    }

    /// The quality of the match; None if it does not match.
    fn score(&self, query: &str, bound: &KeyBindings) -> Option<i32> {
        match self {
            // Actions before files and things of the same name.
            Self::Action(action) => {
                let keys = action.keys_in(bound).iter().map(Shortcut::text);
                let keys = keys.collect::<Vec<_>>().join(" ");
                let label = score(query, &title(action));
                let name = score(query, action.name).map(|score| score - 5);
                let keys = score(query, &keys).map(|score| score - 10);
                [label, name, keys].into_iter().flatten().max().map(|score| score + 20)
            }
            Self::Scene(_) | Self::Thing(_) => score(query, &self.text()),
        }
    }
}

/// The label of an action; without "Add" in the menu of that title.
fn title(action: &Action) -> String {
    match action.group {
        Group::Add if action.name.starts_with("add-") => {
            let mut letters = action.label.chars();
            let first = letters.next().into_iter().flat_map(char::to_lowercase);
            format!("Add {}{}", first.collect::<String>(), letters.as_str())
        }
        _ => action.label.to_owned(),
    }
}

/// The quality of the match between the words of a query and a text: each has to be in it, as a part or letter by
/// letter. Greater is better.
pub(crate) fn score(query: &str, text: &str) -> Option<i32> {
    let text = text.to_lowercase();
    let mut total = -(text.chars().count().min(60) as i32) / 4;
    for word in query.to_lowercase().split_whitespace() {
        total += score_word(word, &text)?;
    }
    Some(total)
}

fn score_word(word: &str, text: &str) -> Option<i32> {
    let begins_word = |place: usize| !text[..place].chars().next_back().is_some_and(char::is_alphanumeric);
    let mut places = text.match_indices(word).map(|(place, _)| place);
    let best = places
        .by_ref()
        .map(|place| match (place, begins_word(place)) {
            (0, _) => 120,
            (_, true) => 100,
            (_, false) => 60,
        })
        .max();
    if best.is_some() {
        return best;
    }
    // The match is letter by letter, and letters that begin a word come first.
    let mut from = 0;
    let mut score = 0;
    for letter in word.chars() {
        let rest = || text[from..].match_indices(letter).map(|(place, _)| from + place);
        let place = rest().find(|place| begins_word(*place)).or_else(|| rest().next())?;
        score += match () {
            () if begins_word(place) => 10,
            () if place == from => 4,
            () => -2,
        };
        from = place + letter.len_utf8();
    }
    Some(score)
}

/// The hits, best first; without a query all entries of the menus.
pub fn hits<'a>(query: &str, model: &'a Model, recent: &'a [std::path::PathBuf], bound: &KeyBindings) -> Vec<Hit<'a>> {
    let actions = ACTIONS.iter().map(Hit::Action);
    if query.trim().is_empty() {
        return actions.collect();
    }
    let beside = model.scene_files.iter().filter(|file| !recent.contains(file));
    let scenes = recent.iter().chain(beside).map(|file| Hit::Scene(file));
    let outline = &model.outline;
    let lists = [
        &outline.shapes,
        &outline.lights,
        &outline.materials,
        &outline.media,
        &outline.sensors,
    ];
    let things = lists.into_iter().flatten().map(Hit::Thing);
    let all = actions.chain(scenes).chain(things);
    let mut scored: Vec<(i32, Hit)> = all.filter_map(|hit| Some((hit.score(query, bound)?, hit))).collect();
    scored.sort_by_key(|(score, _)| -score);
    scored.into_iter().map(|(_, hit)| hit).collect()
}

const WIDTH: f32 = 520.0;
const LINES: usize = 12;

impl Palette {
    /// Shows the palette; returns false when it is to be closed.
    pub fn show(
        &mut self,
        context: &egui::Context,
        model: &Model,
        actions: &ActionContext,
        recent: &[std::path::PathBuf],
        commands: &mut Vec<Command>,
    ) -> bool {
        let id = Id::new("palette");
        let area = Modal::default_area(id).anchor(Align2::CENTER_TOP, egui::vec2(0.0, 60.0));
        let modal = dialog::form(context, Modal::new(id).area(area), |ui| {
            // The keys of the list are consumed before the text field gets them.
            let pressed = |key| ui.input_mut(|input| input.count_and_consume_key(Modifiers::NONE, key));
            let (up, down, accepted) = (pressed(Key::ArrowUp), pressed(Key::ArrowDown), pressed(Key::Enter) > 0);
            ui.set_width(WIDTH.min(ui.ctx().content_rect().width() - 40.0));
            let field = egui::TextEdit::singleline(&mut self.query)
                .hint_text("An action, a scene file or something in the scene")
                .desired_width(f32::INFINITY);
            let field = ui.add(field);
            // A question over it has the keyboard.
            if ui.memory(|memory| memory.allows_interaction(ui.layer_id())) {
                field.request_focus();
            }
            if field.changed() {
                self.chosen = 0;
            }
            let hits = hits(&self.query, model, recent, actions.bound);
            self.chosen = (self.chosen + down)
                .saturating_sub(up)
                .min(hits.len().saturating_sub(1));
            let clicked = list(ui, &hits, self.chosen, up + down > 0, actions);
            let done = clicked.or_else(|| hits.get(self.chosen).filter(|_| accepted).copied());
            let command = done.and_then(|hit| hit.command(actions));
            let is_done = command.is_some();
            commands.extend(command);
            is_done
        });
        !(modal.inner || modal.should_close())
    }
}

/// Shows the list; returns the clicked row.
fn list<'a>(ui: &mut Ui, hits: &[Hit<'a>], chosen: usize, moved: bool, actions: &ActionContext) -> Option<Hit<'a>> {
    if hits.is_empty() {
        ui.weak("Nothing is called so.");
        return None;
    }
    let height = ui.spacing().interact_size.y;
    let line = height + ui.spacing().item_spacing.y;
    let shown = LINES as f32 * line;
    let mut area = egui::ScrollArea::vertical()
        .max_height(shown)
        .auto_shrink([false, true]);
    if moved {
        let middle = (chosen as f32 + 0.5) * line - 0.5 * shown;
        area = area.vertical_scroll_offset(middle.max(0.0));
    }
    let mut clicked = None;
    area.show_rows(ui, height, hits.len(), |ui, lines| {
        for place in lines {
            let hit = hits[place];
            let text = RichText::new(hit.text());
            let can = hit.command(actions).is_some();
            let text = if can { text } else { text.weak() };
            let remark = RichText::new(hit.remark(actions.bound)).weak().small();
            let button = Button::selectable(place == chosen, text)
                .right_text(remark)
                .truncate()
                .min_size(egui::vec2(ui.available_width(), height));
            if ui.add(button).clicked() {
                clicked = Some(hit);
            }
        }
    });
    clicked
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use bevy::prelude::Entity;

    use super::*;
    use crate::app::editor::command::key_bindings::NO_BINDINGS;
    use crate::app::editor::model::Outline;

    fn found(query: &str) -> Vec<String> {
        let item = |index, name: &str| Item {
            entity: Entity::from_raw_u32(index).expect("a small index"),
            name: name.to_owned(),
            kind: "mesh",
            can_hide: true,
            inside_of: None,
            uses: None,
            properties: None,
            hidden: false,
            locked: false,
        };
        let model = Model {
            outline: Arc::new(Outline {
                shapes: vec![item(1, "left wall"), item(2, "undone sphere")].into(),
                ..Outline::default()
            }),
            scene_files: Arc::new(vec!["/there/undo.xml".into(), "/there/cornell-box.xml".into()]),
            ..Model::default()
        };
        hits(query, &model, &["/else/cornell-box.xml".into()], &NO_BINDINGS)
            .iter()
            .map(|hit| {
                format!("{} {}", hit.text(), hit.remark(&NO_BINDINGS))
                    .trim_end()
                    .to_owned()
            })
            .collect()
    }

    #[test]
    fn the_best_match_comes_first() {
        assert_eq!(
            found("undo")[..3],
            ["Undo Ctrl+Z", "undo.xml open scene in there", "undone sphere mesh"]
        );
        assert_eq!(found("left wall")[0], "left wall mesh");
        assert_eq!(found("ctrl+d")[0], "Duplicate Ctrl+D");
        assert_eq!(found("corn").len(), 2);
        assert!(found("no such thing at all").is_empty());
    }

    #[test]
    fn letters_in_order_and_words_in_any_are_enough() {
        assert_eq!(found("fts")[0], "Frame the selection F");
        assert_eq!(found("selection frame")[0], "Frame the selection F");
        assert_eq!(found("add-spot")[0], "Add spot light");
        assert_eq!(found("add cam")[0], "Add camera at the view");
        assert!(score("ab", "ba").is_none());
        assert!(score("ÄÖ", "äö").is_some());
    }

    #[test]
    fn a_part_is_better_than_letters_and_a_beginning_better_than_a_part() {
        let ranked = ["open", "reopen", "only parts even"].map(|text| score("open", text));
        assert!(
            ranked[0] > ranked[1] && ranked[1] > ranked[2] && ranked[2].is_some(),
            "{ranked:?}"
        );
    }

    #[test]
    fn without_a_query_there_are_all_actions() {
        assert_eq!(found("").len(), ACTIONS.len());
    }
}
