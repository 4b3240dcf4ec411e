//! Parses one line of a script into commands. Things are called by their names, and parameters by those of the file.

use bevy::prelude::*;

use super::error::ScriptError;
use super::names::{count, unknown};
pub use super::verb::{Step, Wait};
use super::verb::{Verb, verbs};
use super::{
    baking, blocking, files, keys, light, materials, media, placing, properties, rendering, set, texturing, things,
    timeline, view,
};
use crate::app::editor::command::selection::Selection;
use crate::app::editor::input::actions::{self, ActionContext};
use crate::app::editor::model::EditorModel;
use crate::app::editor::session::view_settings::ViewSettings;
use crate::app::editor::viewport::model::action_context;
use crate::engine::RenderControl;

/// The verbs besides the actions by topic, in the order of `docs/scripts.md`.
pub const VERBS: [&[Verb]; 18] = [
    files::SCENES,
    baking::VERBS,
    files::VERBS,
    things::SELECTING,
    blocking::VERBS,
    placing::VERBS,
    set::VERBS,
    texturing::VERBS,
    materials::VERBS,
    media::VERBS,
    things::VERBS,
    properties::VERBS,
    view::VERBS,
    rendering::VERBS,
    light::VERBS,
    keys::VERBS,
    timeline::VERBS,
    WAITING,
];

verbs! {
    WAITING(world):
    "wait" "SAMPLES|done"
        ["done"] => Step::Wait(Wait::Done),
        [samples] => Step::Wait(Wait::Samples(count(samples)?));
    "screenshot" "FILE" [path] => Step::Screenshot(path.into());
}

/// Reads one line of a script; None for a comment or an empty line. Names are looked up in the present scene of
/// `world`.
pub fn line(world: &mut World, text: &str) -> Result<Option<Step>, ScriptError> {
    let text = text.trim();
    if text.is_empty() || text.starts_with('#') {
        return Ok(None);
    }
    let words = match text.strip_prefix("paste ") {
        // XML is not split into words.
        Some(xml) => vec!["paste".to_owned(), xml.to_owned()],
        None => match text.split_once(" component ").filter(|_| is_property(text)) {
            // JSON keeps its quotation marks.
            Some((before, json)) => [words(before)?, vec!["component".to_owned(), json.trim().to_owned()]].concat(),
            None => words(text)?,
        },
    };
    let (name, arguments) = words.split_first().ok_or("expected a command")?;
    let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
    // The wanted state of a toggle.
    let wanted = match arguments[..] {
        ["on"] => Some(true),
        ["off"] => Some(false),
        _ => None,
    };
    if let Some(action) = actions::find(name)
        && (arguments.is_empty() || wanted.is_some())
    {
        let selection = world.resource::<Selection>().clone();
        let context = context(world, &selection);
        if wanted.is_some() {
            match action.switch(&context) {
                None => return Err(no_words_behind(name)),
                is_on if is_on == wanted => return Ok(None),
                _ => {}
            }
        }
        let command = (action.command)(&context);
        let nothing = || ScriptError::from(format!("`{name}`: nothing is selected")).of_scene();
        let command = command.ok_or_else(nothing)?;
        return Ok(Some(Step::Do(command)));
    }
    let verb = find(name).ok_or_else(|| unknown_verb(name))?;
    let step = (verb.parse)(world, &arguments)
        .and_then(|step| step.ok_or_else(|| format!("`{name}` takes other words").into()));
    step.map(Some).map_err(|error| ScriptError::Usage {
        error: Box::new(error),
        verb: verb.name,
        usage: verb.usage,
    })
}

/// Whether a line sets a property.
fn is_property(text: &str) -> bool {
    text.starts_with("property ") || text.starts_with("scene-property ")
}

fn no_words_behind(name: &str) -> ScriptError {
    format!("`{name}` takes no words behind it").into()
}

fn context<'a>(world: &World, selection: &'a Selection) -> ActionContext<'a> {
    ActionContext {
        paused: world.resource::<RenderControl>().paused,
        has_textures: true,
        has_kept_picture: true,
        has_missing: true,
        can_revert: true,
        ..action_context(
            world.resource::<ViewSettings>(),
            &world.resource::<EditorModel>().0,
            selection,
        )
    }
}

/// The verb of this name.
fn find(name: &str) -> Option<&'static Verb> {
    VERBS.into_iter().flatten().find(|verb| verb.name == name)
}

fn unknown_verb(name: &str) -> ScriptError {
    if actions::find(name).is_some() {
        return no_words_behind(name);
    }
    let verbs = VERBS.into_iter().flatten().map(|verb| verb.name);
    let actions = actions::ACTIONS.iter().map(|action| action.name);
    unknown("command", name, verbs.chain(actions))
}

/// Splits a line at blanks; quotes keep words together, `key=value` needs none around the whole.
fn words(text: &str) -> Result<Vec<String>, ScriptError> {
    let mut words = Vec::new();
    let mut word: Option<String> = None;
    let mut quoted = false;
    for c in text.chars() {
        match c {
            '"' => {
                quoted = !quoted;
                word.get_or_insert_default();
            }
            c if c.is_whitespace() && !quoted => words.extend(word.take()),
            c => word.get_or_insert_default().push(c),
        }
    }
    if quoted {
        return Err("a quotation mark is not closed".into());
    }
    words.extend(word);
    Ok(words)
}
