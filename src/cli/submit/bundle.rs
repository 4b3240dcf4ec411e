//! Collects the files of a scene in one folder, under paths at which the scene finds them.

use std::path::{Path, PathBuf};

use sunroom::files::{self, LARGEST_DATA};

/// A file of a scene, and its path in the bundle.
#[derive(Debug, PartialEq, Eq)]
pub struct Member {
    pub file: PathBuf,
    pub place: PathBuf,
}

/// Gives every file a path in the bundle that keeps relative positions of files. `scene` and `files` are absolute and
/// without links; files in a folder of `assets`, where scenes search for meshes, go to the folder `assets` beside the
/// scene's, which is searched as well. Also returns the path of the scene.
pub fn arrange(scene: &Path, files: &[PathBuf], assets: &[PathBuf]) -> (PathBuf, Vec<Member>) {
    let scene_folder = scene.parent().unwrap_or(Path::new("/"));
    let in_assets = |file: &Path| -> Option<PathBuf> {
        let found = assets.iter().find_map(|folder| file.strip_prefix(folder).ok());
        (!file.starts_with(scene_folder)).then_some(found)?.map(Path::to_owned)
    };
    // The deepest folder that contains the scene and all files named relative to it.
    let mut common = scene_folder;
    for file in files.iter().filter(|file| in_assets(file).is_none()) {
        while !file.starts_with(common) {
            common = common.parent().unwrap_or(Path::new("/"));
        }
    }
    let place = |file: &Path| file.strip_prefix(common).unwrap_or(file).to_owned();
    let beside = place(scene_folder).parent().map_or_else(PathBuf::new, Path::to_owned);
    // A scene at the top of the bundle has no place beside its folder: it gets a folder of its own.
    let (top, beside) = match scene_folder == common {
        true => (PathBuf::from("scene"), PathBuf::new()),
        false => (PathBuf::new(), beside),
    };
    let members = files
        .iter()
        .map(|file| Member {
            file: file.clone(),
            place: match in_assets(file) {
                Some(name) => beside.join("assets").join(name),
                None => top.join(place(file)),
            },
        })
        .collect();
    (top.join(place(scene)), members)
}

/// Copies the files to a folder.
pub fn copy(members: &[Member], folder: &Path) -> Result<(), String> {
    for member in members {
        let target = folder.join(&member.place);
        let fail = |error: &dyn std::fmt::Display| {
            format!("cannot copy {} to {}: {error}", member.file.display(), target.display())
        };
        let bytes = files::read(&member.file, LARGEST_DATA).map_err(|error| fail(&error))?;
        if let Some(parent) = target.parent() {
            std::fs::create_dir_all(parent).map_err(|error| fail(&error))?;
        }
        files::write_atomically(&target, &bytes).map_err(|error| fail(&error))?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn places(scene: &str, files: &[&str], assets: &[&str]) -> (String, Vec<String>) {
        let paths = |names: &[&str]| names.iter().map(PathBuf::from).collect::<Vec<_>>();
        let (scene, members) = arrange(Path::new(scene), &paths(files), &paths(assets));
        let text = |path: &Path| path.display().to_string();
        (text(&scene), members.iter().map(|member| text(&member.place)).collect())
    }

    #[test]
    fn files_keep_their_way_from_the_scene() {
        let (scene, files) = places("/a/b/s.xml", &["/a/b/s.xml", "/a/b/m/x.ply", "/a/t/wood.png"], &[]);
        assert_eq!(scene, "b/s.xml");
        assert_eq!(files, ["b/s.xml", "b/m/x.ply", "t/wood.png"]);
        let (scene, files) = places("/a/b/s.xml", &["/a/b/s.xml", "/a/b/m/x.ply"], &[]);
        assert_eq!(scene, "scene/s.xml");
        assert_eq!(files, ["scene/s.xml", "scene/m/x.ply"]);
    }

    #[test]
    fn files_of_asset_folders_go_beside_the_scene() {
        let (scene, files) = places(
            "/a/b/s.xml",
            &["/a/b/s.xml", "/lib/models/dragon.ply"],
            &["/lib/models"],
        );
        assert_eq!(
            (scene.as_str(), files[1].as_str()),
            ("scene/s.xml", "assets/dragon.ply")
        );
        let (scene, files) = places("/a/b/s.xml", &["/a/b/s.xml", "/a/t.png", "/lib/dragon.ply"], &["/lib"]);
        assert_eq!(scene, "b/s.xml");
        assert_eq!(files[1..], ["t.png", "assets/dragon.ply"]);
    }
}
