//! The verbs about the window: keys and the tutorial.

use super::error::ScriptError;
use super::names::count;
use super::verb::verbs;
use crate::app::editor::command::ShellCommand;
use crate::app::editor::command::preferences::Preferences;
use crate::app::editor::command::shortcut::Shortcut;
use crate::app::editor::input::actions::bindings::{bind, bindables, reserved};
use crate::app::editor::session::tutorial::LESSONS;

verbs! {
    VERBS(world):
    "bind" "ACTION KEY|none|usual" [action, key] => choose(world.get_resource::<Preferences>(), action, key)?;
    "tutorial-step" "NUMBER|off (1 to 5)"
        ["off"] => ShellCommand::ShowTutorial(None),
        [number] => tutorial_step(number)?;
}

fn tutorial_step(number: &str) -> Result<ShellCommand, ScriptError> {
    let step = (count(number)? as usize).checked_sub(1);
    let step = step
        .filter(|step| *step < LESSONS.len())
        .ok_or("expected off or 1 to 5")?;
    Ok(ShellCommand::ShowTutorial(Some(step)))
}

/// Binds a key to an action. An action that has that key gets the former key of this one.
fn choose(preferences: Option<&Preferences>, action: &str, key: &str) -> Result<ShellCommand, ScriptError> {
    let own = bindables().find(|own| own.name == action);
    let own = own.ok_or_else(|| format!("no action is called `{action}`"))?;
    let mut preferences = preferences.cloned().unwrap_or_default();
    match key {
        "usual" => preferences.keys.reset(own.name),
        "none" => preferences.keys.set(own.name, Vec::new()),
        _ => {
            let key = Shortcut::parse(key).ok_or_else(|| format!("`{key}` is no key"))?;
            if let Some(what) = reserved(&key) {
                return Err(format!("{} always {what}", key.text()).into());
            }
            if !own.can_have(&key) {
                let key = key.text();
                return Err(
                    format!("{key} cannot fly: a key that flies has no modifiers and is not of the keypad").into(),
                );
            }
            bind(&mut preferences.keys, own.name, key);
        }
    }
    Ok(ShellCommand::SetPreferences(Box::new(preferences)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_that_fly_have_no_modifiers() {
        assert!(choose(None, "fly-up", "G").is_ok() && choose(None, "hide", "Ctrl+G").is_ok());
        let refused = choose(None, "fly-up", "Ctrl+G").expect_err("a modifier");
        assert!(refused.to_string().starts_with("Ctrl+G cannot fly"), "{refused}");
    }
}
