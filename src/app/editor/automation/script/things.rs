//! The verbs that select things, and the verbs about names, groups and marks.

use super::names::{all_named, named, parse_place};
use super::rendering::switch;
use super::verb::verbs;
use crate::app::editor::command::selection::Extend;
use crate::app::editor::command::{OutlineEdit, SelectionCommand};

verbs! {
    SELECTING(world):
    "select" "NAME..." names => SelectionCommand::Select(all_named(world, names)?, Extend::Replace);
    "select-also" "NAME..." names => SelectionCommand::Select(all_named(world, names)?, Extend::Add);
    "pick" "X,Y (0 to 1 from the upper left)" [place] => SelectionCommand::Pick(parse_place(place)?, Extend::Replace);
}

verbs! {
    VERBS(world):
    "rename" "NAME NAME" [name, new] => OutlineEdit::Rename(named(world, name)?, (*new).to_owned());
    "hide-thing" "NAME..." names if !names.is_empty() => OutlineEdit::Hide(all_named(world, names)?, true);
    "lock" "on|off NAME..."
        [switch_word, names @ ..] if !names.is_empty() => {
            let is_on = switch(switch_word)?;
            OutlineEdit::Lock(all_named(world, names)?, is_on)
        };
    "put-before" "NAME OTHER"
        [name, other] => OutlineEdit::Reorder {
            moved: vec![named(world, name)?],
            before: Some(named(world, other)?),
        };
    "put-into" "FOLDER|none NAME..."
        [folder, names @ ..] if !names.is_empty() => OutlineEdit::PutInto {
            things: all_named(world, names)?,
            folder: (*folder != "none").then(|| (*folder).to_owned()),
        };
}
