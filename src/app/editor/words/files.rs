//! Texts about files: the extensions of their names, and messages about missing files.

use std::ffi::OsStr;
use std::path::{Path, PathBuf};

use bevy::prelude::*;

/// The extensions of scenes.
pub(crate) const SCENE_FILES: [&str; 3] = ["xml", "glb", "gltf"];

/// The extensions of pictures. Each of them can be a texture or an environment.
pub(crate) const PICTURES: [&str; 10] = ["hdr", "exr", "png", "jpg", "jpeg", "pfm", "bmp", "tga", "ppm", "pgm"];

/// The extensions of grids of voxels.
pub(crate) const VOLUMES: [&str; 2] = ["vol", "vdb"];

/// The extensions of files with the intensities of lamps.
pub(crate) const LAMPS: [&str; 2] = ["ies", "ldt"];

/// The extensions of files that lights have.
pub(crate) const PICTURES_AND_LAMPS: [&str; 12] = [
    "hdr", "exr", "png", "jpg", "jpeg", "pfm", "bmp", "tga", "ppm", "pgm", "ies", "ldt",
];

/// Whether the file has the intensities of a lamp, by its name.
pub(crate) fn is_lamp(path: &Path) -> bool {
    LAMPS.contains(&extension(path).as_str())
}

/// The extension in lower case; empty without one.
pub fn extension(path: &Path) -> String {
    path.extension().unwrap_or_default().to_string_lossy().to_lowercase()
}

/// A typed path: `~` at its beginning, alone or before a `/`, is replaced by the user's home folder.
pub fn home_for_tilde(path: &str) -> PathBuf {
    match (path.strip_prefix('~'), std::env::home_dir()) {
        (Some(rest), Some(home)) if rest.is_empty() || rest.starts_with(['/', '\\']) => {
            home.join(rest.trim_start_matches(['/', '\\']))
        }
        _ => PathBuf::from(path),
    }
}

/// Plain words for the errors of the system that users meet most.
const PLAIN: [(&str, &str); 6] = [
    ("Operation not permitted", "the system does not allow it"),
    ("Permission denied", "you may not do that there"),
    ("Read-only file system", "the disk is read-only"),
    ("No space left on device", "the disk is full"),
    ("No such file or directory", "it is not there"),
    ("Is a directory", "it is a folder"),
];

/// A message with plain words for the system's errors, and without their numbers.
pub fn in_plain_words(message: &str) -> String {
    let mut text = without_numbers(message);
    for (system, plain) in PLAIN {
        text = text.replace(system, plain);
    }
    text
}

/// A message that names files without their folders: `/rooms/flat.xml was changed` becomes `flat.xml was changed`. A
/// name without an extension is that of a folder mostly, and keeps the one around it.
pub(crate) fn without_folders(message: &str) -> String {
    /// The ends of paths in sentences. Names of folders may have spaces.
    const ENDS: [&str; 12] = [
        ": ", "; ", ", ", ". ", " could ", " was ", " is ", " as ", " and ", " to ", " in ", " from ",
    ];
    let mut short = String::new();
    let mut rest = message;
    while let Some(start) = rest.find('/') {
        let (before, path) = rest.split_at(start);
        let begins = before.is_empty() || before.ends_with([' ', '(']);
        let end = ENDS.iter().filter_map(|end| path.find(end)).min().unwrap_or(path.len());
        let (whole, after) = path.split_at(end);
        short.push_str(before);
        short.push_str(match whole.rsplit_once('/') {
            Some((folder, name)) if begins && !name.is_empty() && !whole.starts_with("/ ") => {
                let kept = match folder.rsplit_once('/') {
                    Some((_, around)) if !name.contains('.') => around.len() + 1 + name.len(),
                    _ => name.len(),
                };
                &whole[whole.len() - kept..]
            }
            _ => whole,
        });
        rest = after;
    }
    short + rest
}

/// A message without the system's error numbers.
fn without_numbers(message: &str) -> String {
    let mut parts = message.split(" (os error ");
    let mut text = parts.next().unwrap_or_default().to_owned();
    for part in parts {
        text.push_str(
            part.trim_start_matches(|letter: char| letter.is_ascii_digit())
                .strip_prefix(')')
                .unwrap_or(part),
        );
    }
    text
}

/// The message about a file that was deleted or moved away.
pub fn gone(path: &Path) -> String {
    format!("{} is gone from the disk", path.display())
}

/// The path of the noisy picture that is saved with a denoised one: `room-noisy.exr` beside `room.exr`.
pub fn noisy_beside(path: &Path) -> PathBuf {
    let mut name = path.file_stem().unwrap_or_default().to_owned();
    name.push("-noisy");
    if let Some(extension) = path.extension() {
        name.push(".");
        name.push(extension);
    }
    path.with_file_name(name)
}

/// For each file, as much of its folder as tells files of one name apart: usually the last part, and more if these are
/// equal.
pub(crate) fn folders_apart<P: AsRef<Path>>(paths: &[P]) -> Vec<String> {
    let parents = |path: &Path| -> Vec<String> {
        let parts = path.parent().into_iter().flat_map(Path::components);
        parts
            .map(|part| part.as_os_str().to_string_lossy().into_owned())
            .collect()
    };
    let all: Vec<(Option<&OsStr>, Vec<String>)> = paths
        .iter()
        .map(|path| (path.as_ref().file_name(), parents(path.as_ref())))
        .collect();
    let last = |parts: &[String], count: usize| parts[parts.len().saturating_sub(count)..].to_vec();
    let apart = |(name, parts): &(Option<&OsStr>, Vec<String>)| {
        let others = || all.iter().filter(|(other, its)| other == name && its != parts);
        let is_enough = |count: &usize| others().all(|(_, its)| last(its, *count) != last(parts, *count));
        let count = (1..parts.len()).find(is_enough).unwrap_or(parts.len());
        let folder: PathBuf = last(parts, count).iter().collect();
        folder.display().to_string()
    };
    all.iter().map(apart).collect()
}

/// The length of a file, such as `980 B`, `12 kB`, `3.4 MB`.
pub fn size_text(bytes: u64) -> String {
    const UNITS: [&str; 4] = ["kB", "MB", "GB", "TB"];
    if bytes < 1000 {
        return format!("{bytes} B");
    }
    let mut size = bytes as f64 / 1000.0;
    let mut unit = 0;
    while size >= 999.5 && unit + 1 < UNITS.len() {
        size /= 1000.0;
        unit += 1;
    }
    let decimals = usize::from(size < 9.95);
    format!("{size:.decimals$} {}", UNITS[unit])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_have_no_numbers_of_the_system() {
        let error = std::io::Error::from_raw_os_error(2).to_string();
        assert!(error.contains("(os error 2)"), "{error}");
        let text = without_numbers(&format!("a.xml: {error}, and b.xml: {error}."));
        assert_eq!(text.matches("os error").count(), 0, "{text}");
        assert!(text.ends_with('.') && text.contains(", and b.xml: "), "{text}");
    }

    #[test]
    fn the_noisy_picture_is_beside_the_other_whatever_dots_its_name_has() {
        let noisy = |path: &str| noisy_beside(Path::new(path)).display().to_string();
        assert_eq!(noisy("/a/room.exr"), "/a/room-noisy.exr");
        assert_eq!(noisy("/a.b/room.v2.hdr"), "/a.b/room.v2-noisy.hdr");
    }

    #[test]
    fn files_of_one_name_are_told_apart_by_their_folders() {
        let folders = folders_apart(&[
            "/a/b/cb.xml",
            "/c/b/cb.xml",
            "/c/b/room.xml",
            "/a/b/cb.xml",
            "/cb.xml",
            "cb.xml",
            "",
        ]);
        assert_eq!(folders, ["a/b", "c/b", "b", "a/b", "/", "", ""]);
    }

    #[test]
    fn sizes_have_two_digits_or_more() {
        let sizes = [0, 999, 1000, 9_940, 9_960, 123_456, 999_600, 7_400_000_000];
        let texts = [
            "0 B", "999 B", "1.0 kB", "9.9 kB", "10 kB", "123 kB", "1.0 MB", "7.4 GB",
        ];
        assert_eq!(sizes.map(size_text), texts);
    }

    #[test]
    fn messages_name_files_without_folders_and_errors_in_plain_words() {
        let refused = "The scene could not be saved: /rooms of others/a/flat.xml: Operation not permitted (os error 1)";
        let plain = "The scene could not be saved: flat.xml: the system does not allow it";
        assert_eq!(without_folders(&in_plain_words(refused)), plain);
        for (whole, short) in [
            ("Saved /rooms/flat.xml", "Saved flat.xml"),
            ("there is no folder /levels/rooms/new", "there is no folder rooms/new"),
            ("there is no folder /new", "there is no folder new"),
            ("Moved /a/b.png to /c/d.png", "Moved b.png to d.png"),
            ("2 files of /a/b/c in /d/e.xml", "2 files of b/c in e.xml"),
            (
                "/a/b.xml was changed, and /c/d.png is gone",
                "b.xml was changed, and d.png is gone",
            ),
            ("1/4 of W/sr, and a / b", "1/4 of W/sr, and a / b"),
            ("/", "/"),
        ] {
            assert_eq!(without_folders(whole), short);
        }
    }
}
