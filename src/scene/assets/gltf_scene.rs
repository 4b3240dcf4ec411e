//! glTF files opened as scenes: taken apart into files of the cache, and a document that names these.
//!
//! A part lies under the hash of its content. So the meshes and pictures that a change of the file leaves as they are keep their names,
//! and are not loaded again.

use std::fs;
use std::hash::{DefaultHasher, Hasher};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

use tempfile::NamedTempFile;

use crate::document::source::check_file;
use crate::document::{Category, Diagnostics, Document, Object, Severity, SourceFile};
use crate::gltf::files::take_apart;
use crate::gltf::scene::Imported;
use crate::gltf::{Gltf, GltfError};

/// Parts that nobody opened for so long are removed.
const KEPT: Duration = Duration::from_secs(30 * 24 * 3600);

/// Whether a file is opened by [`import`]: its content or else its name says so.
pub fn is_gltf(bytes: &[u8], path: &Path) -> bool {
    let extension = path.extension().unwrap_or_default().to_ascii_lowercase();
    Gltf::is_gltf(bytes) || extension == "gltf" || extension == "glb"
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
        check_file(&file).map_err(io::Error::other)?;
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

/// A folder of files that can be made again.
struct PartsCache {
    folder: PathBuf,
}

impl PartsCache {
    fn open() -> Self {
        let writable = cache_folders().find(|folder| fs::create_dir_all(folder).is_ok());
        let cache = Self {
            folder: writable.unwrap_or_else(std::env::temp_dir),
        };
        cache.forget_old();
        cache
    }

    /// The absolute name of a file with these bytes.
    fn keep(&self, name: &str, bytes: &[u8]) -> io::Result<String> {
        let mut hasher = DefaultHasher::new();
        hasher.write(bytes);
        let folder = self.folder.join(format!("{:016x}", hasher.finish()));
        let path = folder.join(name);
        match fs::File::options().append(true).open(&path) {
            Ok(file) if file.metadata()?.len() == bytes.len() as u64 => file.set_modified(SystemTime::now())?,
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
            let modified = |file: fs::DirEntry| file.metadata().and_then(|about| about.modified()).ok();
            let newest = fs::read_dir(folder).ok()?.flatten().filter_map(modified).max()?;
            Some(newest.elapsed().ok()? > KEPT)
        };
        let folders = fs::read_dir(&self.folder).into_iter().flatten().flatten();
        for folder in folders.map(|entry| entry.path()) {
            if is_old(&folder) == Some(true) {
                let _ = fs::remove_dir_all(folder);
            }
        }
    }
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
