//! The title of the window: the scene's name, and a mark if it has edits that no file has.

use bevy::prelude::*;
use bevy::window::PrimaryWindow;

use crate::app::editor::model::EditorModel;

const PROGRAM: &str = "Sunroom";

/// The title, such as `room.xml* - Sunroom`. A scene without a file is named so once it has edits.
pub fn title(file: Option<&str>, unsaved: bool) -> String {
    let mark = if unsaved { "*" } else { "" };
    match (file, unsaved) {
        (None, false) => PROGRAM.to_owned(),
        (file, _) => format!("{}{mark} - {PROGRAM}", file.unwrap_or("New scene")),
    }
}

/// Keeps the title up to date.
pub(crate) fn follow_title(model: Res<EditorModel>, mut windows: Query<&mut Window, With<PrimaryWindow>>) {
    let status = &model.0.status;
    let file = status.scene.as_deref().and_then(std::path::Path::file_name);
    let wanted = title(file.map(|file| file.to_string_lossy()).as_deref(), status.unsaved);
    if let Ok(mut window) = windows.single_mut()
        && window.title != wanted
    {
        window.title = wanted;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_title_names_the_scene_and_marks_edits() {
        assert_eq!(title(Some("room.xml"), false), "room.xml - Sunroom");
        assert_eq!(title(Some("room.xml"), true), "room.xml* - Sunroom");
        assert_eq!(title(None, true), "New scene* - Sunroom");
        assert_eq!(title(None, false), "Sunroom");
    }
}
