//! The words of scripts about keys.

use super::error::ScriptError;
use crate::app::editor::command::Command;
use crate::app::editor::command::preferences::Preferences;
use crate::app::editor::command::shell::ShellCommand;
use crate::app::editor::command::shortcut::Shortcut;
use crate::app::editor::input::actions::bindings::{bind, bindables, reserved};

/// Gives an action a key. If another action has that key, the two exchange their keys.
pub fn choose(preferences: Option<&Preferences>, action: &str, key: &str) -> Result<Command, ScriptError> {
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
    Ok(ShellCommand::SetPreferences(Box::new(preferences)).into())
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
