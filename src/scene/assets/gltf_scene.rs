//! glTF files opened as scenes: taken apart into files of the cache, and a document that names these.
//!
//! A part lies under the hash of its content. So the meshes and pictures that a change of the file leaves as they are keep their names,
//! and are not loaded again.

use std::ffi::OsStr;
use std::fs;
use std::hash::{DefaultHasher, Hasher};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

use tempfile::NamedTempFile;

use crate::document::source::{MAX_FILE_BYTES, SourceError, check_file};
use crate::document::{Category, Diagnostics, Document, Object, Severity, SourceFile};
use crate::gltf::files::take_apart;
use crate::gltf::scene::Imported;
use crate::gltf::{Gltf, GltfError};

/// Parts that nobody opened for so long are removed.
const KEPT: Duration = Duration::from_secs(30 * 24 * 3600);

/// Of a glTF file, and of each file that it names: the length of the binary container is 32 bits wide.
const MAX_GLTF_BYTES: u64 = 4 << 30;

/// Whether a file is opened by [`import`]: its content or else its name says so.
pub fn is_gltf(bytes: &[u8], path: &Path) -> bool {
    Gltf::is_gltf(bytes) || is_called_gltf(path)
}

/// By its name.
pub fn is_called_gltf(path: &Path) -> bool {
    let extension = path.extension().unwrap_or_default().to_ascii_lowercase();
    extension == "gltf" || extension == "glb"
}

/// Whether a scene file of either kind may be read to its end. Before it is read only its name tells of which kind it is.
pub fn check_scene_file(path: &Path) -> Result<(), SourceError> {
    let limit = if is_called_gltf(path) {
        MAX_GLTF_BYTES
    } else {
        MAX_FILE_BYTES
    };
    check_file(path, limit)
}

/// The scene in a file of these bytes. The files it is read from are the diagnostics' sources, without their text.
pub fn import(bytes: &[u8], path: &Path) -> Document {
    let mut sources = vec![path.to_owned()];
    let folder = path.parent().unwrap_or(Path::new(""));
    let mut read = |name: &str| {
        let file = folder.join(name);
        if !sources.contains(&file) {
            sources.push(file.clone());
        }
        check_file(&file, MAX_GLTF_BYTES).map_err(io::Error::other)?;
        fs::read(file)
    };
    let taken = Gltf::open(bytes, &mut read).and_then(|gltf| {
        let cache = PartsCache::open();
        let mut keep = |name: &str, bytes: &[u8]| cache.keep(name, bytes);
        take_apart(&gltf, &mut keep, &mut read)
    });
    into_document(taken, path, &sources)
}

fn into_document(taken: Result<Imported, GltfError>, path: &Path, sources: &[PathBuf]) -> Document {
    let mut diagnostics = Diagnostics::default();
    diagnostics.sources.extend(sources.iter().map(|path| SourceFile {
        path: path.clone(),
        text: "".into(),
        byte_order_mark: false,
    }));
    let root = match taken {
        Ok(imported) => {
            for warning in imported.warnings {
                diagnostics.push(Severity::Warning, None, warning, None);
            }
            imported.root
        }
        Err(error) => {
            diagnostics.push(Severity::Error, None, error.to_string(), None);
            Object::new(Category::Scene, "")
        }
    };
    Document {
        imported: true,
        diagnostics,
        ..Document::new(path, root)
    }
}

/// A folder of files that can be made again; none where nothing can be written.
struct PartsCache {
    folder: Option<PathBuf>,
}

impl PartsCache {
    fn open() -> Self {
        let folder = cache_folders().find(|folder| fs::create_dir_all(folder).is_ok());
        let cache = Self { folder };
        cache.forget_old();
        cache
    }

    /// The absolute name of a file with these bytes.
    fn keep(&self, name: &str, bytes: &[u8]) -> io::Result<String> {
        let nowhere = || io::Error::other("there is no folder where the parts of the file can be kept");
        let cache = self.folder.as_ref().ok_or_else(nowhere)?;
        let mut hasher = DefaultHasher::new();
        hasher.write(bytes);
        let folder = cache.join(format!("{:016x}", hasher.finish()));
        let path = folder.join(name);
        match fs::metadata(&path) {
            Ok(about) if about.len() == bytes.len() as u64 => {
                // Whoever watches the file takes an opening for writing as a change of it.
                if is_older(&about, KEPT / 2) {
                    let file = fs::File::options().append(true).open(&path)?;
                    file.set_modified(SystemTime::now())?;
                }
            }
            _ => {
                fs::create_dir_all(&folder)?;
                let mut file = NamedTempFile::new_in(&folder)?;
                file.write_all(bytes)?;
                file.persist(&path).map_err(|error| error.error)?;
            }
        }
        Ok(path.to_string_lossy().into_owned())
    }

    /// What cannot be looked at or removed now will be another time.
    fn forget_old(&self) {
        let is_old = |folder: &Path| {
            let files: io::Result<Vec<fs::Metadata>> = fs::read_dir(folder)?.map(|file| file?.metadata()).collect();
            files.map(|files| !files.is_empty() && files.iter().all(|about| is_older(about, KEPT)))
        };
        let entries = self.folder.as_ref().map(fs::read_dir);
        for entry in entries.into_iter().flatten().flatten().flatten() {
            let folder = entry.path();
            if is_hash(&entry.file_name()) && is_old(&folder).is_ok_and(|is_old| is_old) {
                let _ = fs::remove_dir_all(folder);
            }
        }
    }
}

fn is_older(about: &fs::Metadata, age: Duration) -> bool {
    let modified = about.modified().ok();
    modified
        .and_then(|time| time.elapsed().ok())
        .is_some_and(|old| old > age)
}

/// Whether a folder is called as [`PartsCache::keep`] calls them. Others are not ours.
fn is_hash(name: &OsStr) -> bool {
    let is_digit = |byte: &u8| matches!(byte, b'0'..=b'9' | b'a'..=b'f');
    name.len() == 16 && name.as_encoded_bytes().iter().all(is_digit)
}

/// Whether a file was made here, and may be gone another day.
pub fn is_part(path: &Path) -> bool {
    cache_folders().any(|folder| path.starts_with(folder))
}

/// Where parts may be kept, best place first, absolute.
fn cache_folders() -> impl Iterator<Item = PathBuf> {
    let folder = |variable: &str| std::env::var_os(variable).map(PathBuf::from);
    let caches = [
        folder("XDG_CACHE_HOME"),
        folder("LOCALAPPDATA"),
        folder("HOME").map(|home| home.join(".cache")),
        Some(std::env::temp_dir()),
    ];
    let absolute = caches.into_iter().flatten().filter(|folder| folder.is_absolute());
    absolute.map(|folder| folder.canonicalize().unwrap_or(folder).join("sunroom/gltf"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn make_old(path: &Path, days: u64) {
        let file = fs::File::options().append(true).open(path).expect("is there");
        let time = SystemTime::now() - Duration::from_secs(days * 24 * 3600);
        file.set_modified(time).expect("can be set");
    }

    #[test]
    fn only_parts_of_ours_are_forgotten() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let cache = PartsCache {
            folder: Some(folder.path().to_owned()),
        };
        let [old, recent] = ["old", "recent"].map(|name| PathBuf::from(cache.keep(name, name.as_bytes()).expect(name)));
        make_old(&old, 31);
        make_old(&recent, 29);
        let foreign = ["letters", "0123456789abcde", "0123456789ABCDEF", "0123456789abcdef0"].map(|name| {
            let folder = folder.path().join(name);
            fs::create_dir(&folder).expect(name);
            fs::write(folder.join("file"), name).expect(name);
            make_old(&folder.join("file"), 400);
            folder.join("file")
        });
        cache.forget_old();
        assert!(!old.exists() && !old.parent().is_some_and(Path::exists));
        assert!(recent.is_file());
        for file in foreign {
            assert!(file.is_file(), "{}", file.display());
        }
    }

    #[test]
    fn a_part_that_is_there_is_touched_only_before_it_would_be_forgotten() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let cache = PartsCache {
            folder: Some(folder.path().to_owned()),
        };
        let path = PathBuf::from(cache.keep("part", b"bytes").expect("can be kept"));
        let modified = || path.metadata().and_then(|about| about.modified()).expect("is known");
        for (days, is_touched) in [(14, false), (16, true)] {
            make_old(&path, days);
            let before = modified();
            cache.keep("part", b"bytes").expect("can be kept");
            assert_eq!(modified() != before, is_touched, "{days} days");
        }
    }

    #[test]
    fn models_may_be_larger_than_text() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        for (name, limit) in [
            ("a.glb", MAX_GLTF_BYTES),
            ("a.GLTF", MAX_GLTF_BYTES),
            ("a.xml", MAX_FILE_BYTES),
        ] {
            let path = folder.path().join(name);
            let file = fs::File::create(&path).expect(name);
            // Without content, which takes no place on the disk.
            file.set_len(limit).expect(name);
            check_scene_file(&path).expect(name);
            file.set_len(limit + 1).expect(name);
            assert!(
                matches!(check_scene_file(&path), Err(SourceError::TooLarge { .. })),
                "{name}"
            );
        }
    }

    #[test]
    fn without_a_folder_nothing_is_kept_or_removed() {
        let nowhere = PartsCache { folder: None };
        nowhere.forget_old();
        let error = nowhere
            .keep("part", b"bytes")
            .expect_err("there is no place")
            .to_string();
        assert!(error.contains("no folder"), "{error}");
    }
}
