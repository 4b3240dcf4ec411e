//! The root folders of the browser of assets.

use std::path::{Path, PathBuf};

use crate::app::editor::command::preferences::Preferences;
use crate::app::editor::command::samples::{program_folder, program_folders};
use crate::app::editor::model::assets::AssetPlace;
use crate::app::editor::session::trust::asset_folders;

/// The most folders of recent scenes.
const MOST_RECENT: usize = 5;

/// The user's own folders, that of the scene, those that come with the program, those of `$SUNROOM_ASSETS`, those of
/// recent scenes, and the user's home.
pub(super) fn places(scene: Option<&Path>, preferences: &Preferences) -> Vec<AssetPlace> {
    let mut places: Vec<AssetPlace> = Vec::new();
    let mut add = |name: String, folder: PathBuf, is_own: bool| {
        let folder = std::path::absolute(&folder).unwrap_or(folder);
        if !places.iter().any(|known| known.folder == folder) {
            places.push(AssetPlace { name, folder, is_own });
        }
    };
    for folder in &preferences.asset_folders {
        add(name_of(folder), folder.clone(), true);
    }
    if let Some(folder) = scene.and_then(Path::parent) {
        add("Beside the scene".to_owned(), folder.to_owned(), false);
    }
    for (name, folder) in program_folders() {
        add(name.to_owned(), folder, false);
    }
    for folder in asset_folders() {
        add(name_of(&folder), folder, false);
    }
    let recent = preferences.recent_files.iter().filter_map(|file| file.parent());
    for folder in recent.take(MOST_RECENT) {
        add(name_of(folder), folder.to_owned(), false);
    }
    if let Some(home) = std::env::home_dir() {
        add("Home".to_owned(), home, false);
    }
    places
}

/// The environments that come with the program, in alphabetical order.
pub(super) fn environments() -> Vec<PathBuf> {
    let folder = program_folder("assets/environments");
    let listing = folder.map(|folder| super::listing::list(&folder)).unwrap_or_default();
    let files = listing.entries.into_iter().filter(|entry| entry.kind.is_some());
    files.map(|entry| entry.path).collect()
}

fn name_of(folder: &Path) -> String {
    let name = folder.file_name().map(|name| name.to_string_lossy().into_owned());
    name.unwrap_or_else(|| folder.display().to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_folder_is_there_once_and_the_users_own_come_first() {
        let own = std::env::temp_dir().join("my assets");
        let preferences = Preferences {
            asset_folders: vec![own.clone()],
            recent_files: vec![own.join("room.xml"), std::env::temp_dir().join("other/room.xml")],
            ..Preferences::default()
        };
        let places = places(Some(&own.join("scene.xml")), &preferences);
        assert_eq!((places[0].name.as_str(), places[0].is_own), ("my assets", true));
        let of = |folder: &Path| places.iter().filter(|place| place.folder == folder).count();
        assert_eq!((of(&own), of(&std::env::temp_dir().join("other"))), (1, 1));
        // The tests run in a checkout.
        assert!(places.iter().any(|place| place.name == "Environments"));
        assert_eq!(environments().len(), 5);
    }
}
