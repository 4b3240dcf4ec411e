//! A cache of small pictures in a folder, kept between runs. Each picture can be made again, so that the folder may be
//! removed at any time.
//!
//! A file begins with a line of text about the picture; a PNG file of it follows. Its name is the hash of the key.

use std::fs;
use std::io::Cursor;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::SystemTime;

use bevy::prelude::Resource;
use bevy_egui::egui::ColorImage;
use image::codecs::png::{PngDecoder, PngEncoder};
use image::{DynamicImage, ExtendedColorType, ImageDecoder, ImageEncoder, Limits};

use super::stable_hash::stable_hash;
use crate::files::{self, write_atomically};
use crate::scene::assets::cache_folder::cache_folder;

/// The name of the cache's folder within the program's.
const NAME: &str = "pictures";
const EXTENSION: &str = "picture";
/// The longest side of a picture in pixels, and the longest file in bytes.
const LONGEST_SIDE: u32 = 512;
const LARGEST: u64 = 2 << 20;
/// The size of all files together, in bytes, above which the oldest are removed.
const MOST_BYTES: u64 = 64 << 20;
/// The number of written bytes between two checks of that size.
const BYTES_UNTIL_TIDIED: u64 = 8 << 20;
/// A part of the key for programs that make pictures differently.
const VERSION: &str = concat!(env!("CARGO_PKG_VERSION"), " 1");

/// A picture with a line of text about it.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Kept {
    pub image: ColorImage,
    pub text: String,
}

/// The pictures of earlier runs. Clones share the folder.
#[derive(Resource, Clone, Debug, Default)]
pub(crate) struct PictureCache {
    /// The folder; None if nothing is cached.
    folder: Option<PathBuf>,
    /// The bytes written since the folder was tidied.
    untidied: Arc<AtomicU64>,
}

impl PictureCache {
    /// The cache in the user's folder for caches. Without a user nothing is cached.
    pub fn of_user(attended: bool) -> Self {
        Self::in_folder(attended.then(|| cache_folder(NAME)).flatten())
    }

    pub(crate) fn in_folder(folder: Option<PathBuf>) -> Self {
        Self {
            folder,
            // The first picture triggers a check of the files of earlier runs.
            untidied: Arc::new(AtomicU64::new(BYTES_UNTIL_TIDIED)),
        }
    }

    /// The cached picture of the key; None if there is none, or a damaged one.
    pub fn get(&self, key: &str) -> Option<Kept> {
        let bytes = files::read(&self.path(key)?, LARGEST).ok()?;
        let end = bytes.iter().position(|byte| *byte == b'\n')?;
        let text = std::str::from_utf8(&bytes[..end]).ok()?;
        let image = decoded(&bytes[end + 1..])?;
        Some(Kept {
            image,
            text: text.to_owned(),
        })
    }

    /// Caches a picture, and ignores errors. `text` is one line. The first call, and each after [`BYTES_UNTIL_TIDIED`],
    /// removes the oldest pictures if there are too many.
    pub fn keep(&self, key: &str, kept: &Kept) {
        let Some(path) = self.path(key) else { return };
        let [width, height] = kept.image.size.map(|side| side as u32);
        if width.max(height) > LONGEST_SIDE {
            return;
        }
        let mut bytes = Cursor::new(kept.text.replace('\n', " ").into_bytes());
        bytes.set_position(bytes.get_ref().len() as u64);
        std::io::Write::write_all(&mut bytes, b"\n").expect("memory takes all bytes");
        let encoder = PngEncoder::new(&mut bytes);
        let is_encoded = encoder.write_image(kept.image.as_raw(), width, height, ExtendedColorType::Rgba8);
        let bytes = bytes.into_inner();
        let written = bytes.len() as u64;
        if is_encoded.is_ok() && write_atomically(&path, bytes).is_ok() {
            self.tidy_after(written, MOST_BYTES);
        }
    }

    fn path(&self, key: &str) -> Option<PathBuf> {
        let hash = stable_hash(format!("{VERSION} {key}").as_bytes());
        Some(self.folder.as_ref()?.join(format!("{hash:016x}.{EXTENSION}")))
    }

    /// Counts written bytes, and tidies the folder once there are many.
    fn tidy_after(&self, written: u64, most_bytes: u64) {
        let Some(folder) = &self.folder else { return };
        let untidied = written + self.untidied.fetch_add(written, Ordering::Relaxed);
        // Of several threads one tidies.
        if untidied >= BYTES_UNTIL_TIDIED && self.untidied.swap(0, Ordering::Relaxed) >= BYTES_UNTIL_TIDIED {
            tidy(folder, most_bytes);
        }
    }
}

/// Removes the oldest pictures until all together are not larger than `most_bytes`. Other files stay.
fn tidy(folder: &Path, most_bytes: u64) {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    let pictures = entries.filter(|entry| entry.path().extension().is_some_and(|extension| extension == EXTENSION));
    let mut pictures: Vec<(SystemTime, u64, PathBuf)> = pictures
        .filter_map(|entry| {
            let about = entry.metadata().ok().filter(|about| about.is_file())?;
            Some((about.modified().ok()?, about.len(), entry.path()))
        })
        .collect();
    pictures.sort();
    let mut total: u64 = pictures.iter().map(|(_, bytes, _)| bytes).sum();
    for (_, bytes, path) in pictures {
        if total <= most_bytes {
            break;
        }
        if fs::remove_file(path).is_ok() {
            total -= bytes;
        }
    }
}

fn decoded(png: &[u8]) -> Option<ColorImage> {
    let mut limits = Limits::default();
    limits.max_image_width = Some(LONGEST_SIDE);
    limits.max_image_height = Some(LONGEST_SIDE);
    limits.max_alloc = Some(16 << 20);
    let mut decoder = PngDecoder::with_limits(Cursor::new(png), limits.clone()).ok()?;
    decoder.set_limits(limits).ok()?;
    let rgba = DynamicImage::from_decoder(decoder).ok()?.to_rgba8();
    let size = [rgba.width() as usize, rgba.height() as usize];
    Some(ColorImage::from_rgba_premultiplied(size, &rgba))
}

#[cfg(test)]
mod tests {
    use super::*;
    use bevy_egui::egui::Color32;
    use std::time::Duration;

    fn picture(side: usize, shade: u8) -> Kept {
        Kept {
            image: ColorImage::filled([side, side / 2], Color32::from_gray(shade)),
            text: format!("shade {shade}"),
        }
    }

    #[test]
    fn pictures_come_back_and_damage_is_noticed() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let cache = PictureCache::in_folder(Some(folder.path().to_owned()));
        assert_eq!(cache.get("a"), None);
        cache.keep("a", &picture(32, 7));
        cache.keep("b", &picture(16, 9));
        assert_eq!(cache.get("a"), Some(picture(32, 7)));
        assert_eq!(cache.get("b"), Some(picture(16, 9)));
        let path = cache.path("a").expect("there is a folder");
        let whole = fs::read(&path).expect("just written");
        for damaged in [&whole[..whole.len() / 2], b"no line", b"\n", b"\xff\n", b""] {
            fs::write(&path, damaged).expect("it can be written");
            assert_eq!(cache.get("a"), None);
        }
        cache.keep("large", &picture(1 + LONGEST_SIDE as usize, 0));
        assert_eq!(cache.get("large"), None);
        let nowhere = PictureCache::default();
        nowhere.keep("a", &picture(8, 1));
        assert_eq!(nowhere.get("a"), None);
    }

    #[test]
    fn the_oldest_make_room_and_other_files_stay() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let cache = PictureCache::in_folder(Some(folder.path().to_owned()));
        for (age, key) in ["new", "older", "oldest"].into_iter().enumerate() {
            cache.keep(key, &picture(64, 1));
            let path = cache.path(key).expect("there is a folder");
            let time = SystemTime::now() - Duration::from_secs(3600 * age as u64);
            let file = fs::File::options().append(true).open(path).expect("just written");
            file.set_modified(time).expect("it can be set");
        }
        fs::write(folder.path().join("letter.txt"), [0; 5000]).expect("it can be written");
        let bytes = fs::metadata(cache.path("new").expect("a folder"))
            .expect("is there")
            .len();
        tidy(folder.path(), 2 * bytes);
        let left = ["new", "older", "oldest"].map(|key| cache.get(key).is_some());
        assert_eq!(left, [true, true, false]);
        tidy(folder.path(), 0);
        assert!(cache.get("new").is_none() && folder.path().join("letter.txt").exists());
    }

    #[test]
    fn the_folder_is_tidied_again_when_much_was_written() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let cache = PictureCache::in_folder(Some(folder.path().to_owned()));
        for _ in 0..2 {
            cache.keep("a", &picture(16, 1));
            cache.clone().tidy_after(BYTES_UNTIL_TIDIED / 2, 0);
            assert!(cache.get("a").is_some(), "little was written");
            cache.tidy_after(BYTES_UNTIL_TIDIED / 2, 0);
            assert!(cache.get("a").is_none(), "much was written");
        }
    }
}
