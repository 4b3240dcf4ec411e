//! Entries for what lies together in a folder: files that are replaced together, levels of a bake, and scenes with the
//! files that they include.

use std::fs::{self, File};
use std::path::Path;
use std::time::{Duration, UNIX_EPOCH};

use sunroom_core::bake::files::{Content, replaceable};
use sunroom_core::document::parse_within;
use sunroom_core::document::source::decode;
use sunroom_core::files::{Access, checksum, finish_set, finish_set_within};
use tempfile::{TempDir, tempdir, tempdir_in};

use super::documents::assert_survives_writing;

/// A new folder with this one in it, which has these files.
fn folder_with(name: &str, files: &[(&str, &[u8])]) -> TempDir {
    // Files in memory, where the system has them: a disk would take nearly all of the time.
    let home = tempdir_in("/dev/shm")
        .or_else(|_| tempdir())
        .expect("a temporary folder");
    for (file, content) in files {
        let path = home.path().join(name).join(file);
        fs::create_dir_all(path.parent().expect("a folder")).expect("a temporary folder");
        fs::write(path, content).expect("a temporary folder");
    }
    home
}

/// The note beside a file of a set that is to be replaced. All files are of the second 1000000000. Whatever the note
/// says, nothing outside of its folder changes, and where the set is finished, the note is gone. Returns whether it is
/// finished.
pub fn set(bytes: &[u8]) -> bool {
    let note = format!(".sunroom-{}.set", checksum(b"scene.gltf"));
    let files: [(&str, &[u8]); 6] = [
        ("scene.gltf", b"old"),
        ("scene.bin", b"old"),
        (".sunroom-new.part", b"newer"),
        ("below/.sunroom-mesh.part", b"newest"),
        ("below/outdated.ply", b"mesh"),
        ("../outside.bin", b"outside"),
    ];
    let home = folder_with("level", &files);
    let folder = home.path().join("level");
    for (name, _) in files {
        let file = File::options().write(true).open(folder.join(name));
        let set = file.and_then(|file| file.set_modified(UNIX_EPOCH + Duration::from_secs(1_000_000_000)));
        set.expect("a temporary folder");
    }
    fs::write(folder.join(&note), bytes).expect("a temporary folder");
    let main = folder.join("scene.gltf");
    let outcome = finish_set_within(&main, &Access::within([folder.clone()]));
    match &outcome {
        Ok(()) => {
            assert!(!folder.join(&note).exists());
            finish_set(&main).expect("nothing is left to do");
        }
        Err(error) => _ = error.to_string(),
    }
    assert_eq!(fs::read(home.path().join("outside.bin")).expect("it stays"), b"outside");
    let left = fs::read_dir(home.path()).expect("it stays").count();
    assert_eq!(left, 2, "something came to the folder around");
    outcome.is_ok()
}

/// The manifest of a level that a bake has left. Only its files are looked at, and none is changed. Returns whether
/// there is a level.
pub fn manifest(bytes: &[u8]) -> bool {
    let files: [(&str, &[u8]); 3] = [
        ("lightmaps.json", bytes),
        ("level.glb", b"level"),
        ("lightmap-0.exr", b"light"),
    ];
    let home = folder_with("level", &files);
    let folder = home.path().join("level");
    let content = Content::of_folder(&folder);
    if let Some(content) = &content {
        assert!(!content.may_replace(content));
        let _ = content.to_string();
    }
    assert_eq!(replaceable(&folder).len(), files.len());
    for (name, content) in files {
        assert_eq!(fs::read(folder.join(name)).expect("it stays"), content, "{name}");
    }
    content.is_some()
}

/// A scene and, each behind a zero byte, files with the names `0.xml`, `1.xml` and so on that it may include. Only
/// files of its folder are read, and what is read without an error is the same after it was written as one file.
/// Returns whether files were included without an error.
pub fn includes(bytes: &[u8]) -> bool {
    let mut parts = bytes.split(|&byte| byte == 0);
    let text = parts.next().unwrap_or_default().to_vec();
    let names: Vec<String> = (0..10).map(|number| format!("{number}.xml")).collect();
    let mut files: Vec<(&str, &[u8])> = names.iter().map(String::as_str).zip(parts).collect();
    let outside = b"<scene version='3.0.0'><bsdf type='outside'/></scene>";
    files.extend([("scene.xml", &*text), ("../outside.xml", outside)]);
    let home = folder_with("scene", &files);
    let folder = home.path().join("scene");
    let path = folder.join("scene.xml");
    let Ok(text) = decode(text, &path) else {
        return false;
    };
    let document = parse_within(text, &path, &[], Access::within([folder.clone()]));
    let sources = &document.diagnostics.sources;
    let real = |path: &Path| path.canonicalize().expect("it was read");
    assert!(
        sources
            .iter()
            .all(|source| real(&source.path).starts_with(real(&folder)))
    );
    if document.diagnostics.has_errors() {
        return false;
    }
    assert_survives_writing(&document);
    sources.len() > 1
}
