//! Verbs of scripts: each is one row with its name, its words and their meaning.

use bevy::prelude::World;

use super::error::ScriptError;
use super::parse::Step;

/// A verb beside the actions.
pub struct Verb {
    /// The first word of its lines.
    pub name: &'static str,
    /// The words that follow, for messages and `docs/scripts.md`.
    pub usage: &'static str,
    /// Reads the words; None for other words than these.
    pub parse: fn(&mut World, &[&str]) -> Result<Option<Step>, ScriptError>,
}

/// Declares rows of verbs: `"name" "usage" PATTERN => COMMAND, PATTERN => COMMAND, ..;`.
macro_rules! verbs {
    ($table:ident($world:ident): $($name:literal $usage:literal $($words:pat $(if $guard:expr)? => $step:expr),+;)*) => {
        /// The verbs of this topic.
        // Not every verb looks into the scene, and some take all words.
        #[allow(unused_variables, unreachable_patterns)]
        pub const $table: &[$crate::app::editor::automation::script::verb::Verb] =
            &[$($crate::app::editor::automation::script::verb::Verb {
                name: $name,
                usage: $usage,
                parse: |$world, words| {
                    Ok(Some(match words {
                        $($words $(if $guard)? => $step.into(),)+
                        _ => return Ok(None),
                    }))
                },
            }),*];
    };
}
pub(super) use verbs;
