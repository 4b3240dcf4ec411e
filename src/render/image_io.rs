//! Writes pictures to files: EXR (linear float32, lossless), Radiance HDR (linear, shared exponent), PNG (sRGB, 8 bits).
//!
//! A file is complete or not there: it is written beside its place under another name and then renamed. What a picture
//! looks like on a display is decided in [`super::tonemap`]; standard output is the caller's business, see [`encode`]. What reads pictures is [`crate::texture::load_image`].

pub mod exr;
mod exr_compression;

use std::io::{Cursor, Write as _};
use std::path::{Path, PathBuf};

use image::codecs::hdr::HdrEncoder;
use image::codecs::openexr::OpenExrEncoder;
use image::codecs::png::PngEncoder;
use image::{ExtendedColorType, ImageEncoder, ImageError};
use thiserror::Error;

pub use self::exr_compression::ExrCompression;
use super::tonemap::Display;
use crate::color::Rgb;
use crate::files::write_atomically;

/// A picture of linear Rec. 709 radiance, row by row from the top left.
#[derive(Clone, Debug, PartialEq)]
pub struct ImageRgb {
    /// The number of pixels in a row, above zero.
    pub width: u32,
    /// The number of rows, above zero.
    pub height: u32,
    /// The pixels, `width * height` of them.
    pub pixels: Vec<Rgb>,
}

impl ImageRgb {
    fn is_whole(&self) -> bool {
        self.pixels.len() == self.width as usize * self.height as usize && !self.pixels.is_empty()
    }
}

/// The formats in which pictures are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FileFormat {
    /// OpenEXR with linear radiance in 32-bit floats.
    Exr,
    /// Radiance's RGBE: linear, with eight bits for each mantissa and a common exponent.
    Hdr,
    /// The picture as it is shown, with eight bits per channel encoded as sRGB.
    Png,
}

impl FileFormat {
    /// The format by the extension, whatever its case.
    pub fn from_path(path: &Path) -> Result<Self, ImageIoError> {
        let extension = path
            .extension()
            .unwrap_or_default()
            .to_string_lossy()
            .to_ascii_lowercase();
        match extension.as_str() {
            "exr" => Ok(Self::Exr),
            "hdr" => Ok(Self::Hdr),
            "png" => Ok(Self::Png),
            _ => Err(ImageIoError::UnknownFormat(path.to_path_buf())),
        }
    }
}

/// The reason why a picture is not written.
#[derive(Debug, Error)]
#[allow(missing_docs, reason = "the messages say what the variants mean")]
pub enum ImageIoError {
    #[error("{}: the name of a picture ends in .exr, .hdr or .png", .0.display())]
    UnknownFormat(PathBuf),
    #[error("cannot write {}: {source}", .path.display())]
    Write { path: PathBuf, source: std::io::Error },
    #[error("cannot encode the picture: {0}")]
    Encode(#[from] ImageError),
    #[error("cannot encode the picture: {0}")]
    Exr(String),
    #[error("the channel `{name}` {what}")]
    Channel { name: String, what: String },
    #[error("{pixels} pixels are no picture of {width} x {height}")]
    WrongSize { width: u32, height: u32, pixels: usize },
}

/// Writes in the format that the extension names. `display` is used for PNG only: the others hold the radiance itself.
pub fn write_image(path: &Path, image: &ImageRgb, display: &Display) -> Result<(), ImageIoError> {
    let bytes = encode(image, FileFormat::from_path(path)?, display)?;
    write(path, &bytes)
}

/// Writes the picture as EXR to a new file in the system's folder for temporary files and returns the file's name: for a picture whose own
/// place cannot be written.
pub fn write_to_temporary_folder(image: &ImageRgb) -> Result<PathBuf, ImageIoError> {
    let bytes = encode(image, FileFormat::Exr, &Display::default())?;
    let folder = std::env::temp_dir();
    let failed = |source: std::io::Error| ImageIoError::Write {
        path: folder.clone(),
        source,
    };
    let mut builder = tempfile::Builder::new();
    builder.prefix("sunroom-").suffix(".exr");
    // Only the kind of the error is kept: its full message names a temporary file.
    let mut file = builder
        .tempfile_in(&folder)
        .map_err(|error| failed(error.kind().into()))?;
    file.as_file_mut().write_all(&bytes).map_err(failed)?;
    file.as_file().sync_all().map_err(failed)?;
    let (_, path) = file.keep().map_err(|error| failed(error.error))?;
    Ok(path)
}

/// Writes bytes that are for the display already, three a pixel, as PNG.
pub fn write_png(path: &Path, size: [u32; 2], rgb: &[u8]) -> Result<(), ImageIoError> {
    let mut bytes = Cursor::new(Vec::new());
    PngEncoder::new(&mut bytes).write_image(rgb, size[0], size[1], ExtendedColorType::Rgb8)?;
    write(path, &bytes.into_inner())
}

/// The bytes of a file.
pub fn encode(image: &ImageRgb, format: FileFormat, display: &Display) -> Result<Vec<u8>, ImageIoError> {
    let (width, height) = (image.width, image.height);
    if !image.is_whole() {
        let pixels = image.pixels.len();
        return Err(ImageIoError::WrongSize { width, height, pixels });
    }
    let mut bytes = Cursor::new(Vec::new());
    match format {
        FileFormat::Exr => OpenExrEncoder::new(&mut bytes).write_image(
            bytemuck::cast_slice(&image.pixels),
            width,
            height,
            ExtendedColorType::Rgb32F,
        )?,
        FileFormat::Hdr => {
            let storable = image
                .pixels
                .iter()
                .map(|pixel| image::Rgb(pixel.to_array().map(storable_in_rgbe)));
            HdrEncoder::new(&mut bytes).encode(&storable.collect::<Vec<_>>(), width as usize, height as usize)?;
        }
        FileFormat::Png => PngEncoder::new(&mut bytes).write_image(
            &display.encode_rgb(&image.pixels),
            width,
            height,
            ExtendedColorType::Rgb8,
        )?,
    }
    Ok(bytes.into_inner())
}

/// The shared exponent ends at 2^127 and knows neither NaN nor a sign.
fn storable_in_rgbe(component: f32) -> f32 {
    if component > 0.0 { component.min(1e38) } else { 0.0 }
}

fn write(path: &Path, bytes: &[u8]) -> Result<(), ImageIoError> {
    write_atomically(path, bytes).map_err(|source| ImageIoError::Write {
        path: path.to_path_buf(),
        source,
    })
}

#[cfg(test)]
mod tests {
    use std::fs;

    use glam::Vec3;

    use super::*;
    use crate::render::tonemap::ToneMap;
    use crate::texture::load_image;

    fn read_image(path: &Path) -> ImageRgb {
        let image = load_image(&fs::read(path).unwrap()).unwrap();
        let (width, height) = (image.width(), image.height());
        let row = |y| (0..width).map(move |x| (x, y));
        let pixels = (0..height).flat_map(row).map(|(x, y)| image.pixel(x, y)).collect();
        ImageRgb { width, height, pixels }
    }

    /// Values over twelve decades, none of them representable in fewer bits.
    fn picture() -> ImageRgb {
        let (width, height) = (37, 11);
        let pixels = (0..width * height).map(|i| {
            let x = (i as f32 * 0.1 - 20.0).exp2();
            Vec3::new(x * 1.1, x, x * 0.7)
        });
        ImageRgb {
            width,
            height,
            pixels: pixels.collect(),
        }
    }

    fn folder() -> tempfile::TempDir {
        tempfile::tempdir().expect("the test needs a temporary folder")
    }

    #[test]
    fn exr_keeps_every_bit_and_ignores_the_display() {
        let folder = folder();
        let path = folder.path().join("a.exr");
        let display = Display {
            exposure_ev: 3.0,
            tone_map: ToneMap::Aces,
            ..Display::default()
        };
        write_image(&path, &picture(), &display).unwrap();
        assert_eq!(read_image(&path), picture());
        // No other file is left in the folder.
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    #[test]
    fn exr_keeps_what_is_no_number() {
        let path = folder().keep().join("nan.exr");
        let odd = ImageRgb {
            width: 2,
            height: 1,
            pixels: vec![Vec3::new(f32::NAN, f32::INFINITY, -1.0), Vec3::splat(f32::MIN_POSITIVE)],
        };
        write_image(&path, &odd, &Display::default()).unwrap();
        // They are not read as a texture, where these count as black.
        let read = image::open(&path).unwrap().into_rgb32f().into_raw();
        assert!(read[0].is_nan() && read[1] == f32::INFINITY && read[2] == -1.0);
        assert_eq!(read[3..], [f32::MIN_POSITIVE; 3]);
        fs::remove_dir_all(path.parent().unwrap()).unwrap();
    }

    #[test]
    fn hdr_keeps_eight_bits_of_the_largest_component() {
        let folder = folder();
        let path = folder.path().join("a.hdr");
        write_image(&path, &picture(), &Display::default()).unwrap();
        let read = read_image(&path);
        for (got, put) in read.pixels.iter().zip(&picture().pixels) {
            // One unit of eight bits under the exponent of the largest component: at most 1/128 of it.
            let error = (*got - *put).abs().max_element();
            assert!(error <= put.max_element() / 128.0, "{got} {put}");
        }
        let odd = ImageRgb {
            width: 2,
            height: 1,
            pixels: vec![Vec3::NAN, Vec3::new(f32::INFINITY, -1.0, 0.0)],
        };
        write_image(&path, &odd, &Display::default()).unwrap();
        let read = read_image(&path).pixels;
        assert_eq!(read[0], Vec3::ZERO);
        assert!(read[1].x > 1e37 && read[1].y == 0.0, "{}", read[1]);
    }

    #[test]
    fn png_is_what_the_display_shows() {
        let folder = folder();
        let path = folder.path().join("A.PNG");
        for tone_map in ToneMap::ALL {
            let display = Display {
                exposure_ev: -1.0,
                tone_map,
                ..Display::default()
            };
            write_image(&path, &picture(), &display).unwrap();
            let read = read_image(&path);
            assert_eq!((read.width, read.height), (37, 11));
            for (got, put) in read.pixels.iter().zip(&picture().pixels) {
                assert_eq!(Display::default().encode(*got), display.encode(*put));
            }
        }
    }

    #[test]
    fn a_picture_without_a_place_is_kept_whole_in_the_temporary_folder() {
        let [first, second] = [(); 2].map(|()| write_to_temporary_folder(&picture()).expect("there is such a folder"));
        for path in [&first, &second] {
            assert_eq!(path.parent(), Some(&*std::env::temp_dir()));
            assert_eq!(read_image(path), picture());
        }
        assert_ne!(first, second);
        for path in [first, second] {
            fs::remove_file(path).expect("it was just made");
        }
    }

    #[test]
    fn unknown_extensions_name_the_known_ones() {
        for name in ["a.bmp", "a", ".exr", "a.exr.txt"] {
            let error = write_image(Path::new(name), &picture(), &Display::default()).unwrap_err();
            let text = error.to_string();
            assert!(text.contains(name) && text.contains(".exr, .hdr or .png"), "{text}");
            assert!(!Path::new(name).exists());
        }
    }

    #[test]
    fn places_that_cannot_be_written_are_named() {
        let folder = folder();
        let write = |path: &Path| {
            let text = write_image(path, &picture(), &Display::default())
                .unwrap_err()
                .to_string();
            assert!(text.contains(&*path.to_string_lossy()), "{text}");
            text
        };
        let missing = folder.path().join("not-there");
        let text = write(&missing.join("a.png"));
        assert!(text.contains("there is no folder"), "{text}");

        let file = folder.path().join("file");
        fs::write(&file, "x").unwrap();
        write(&file.join("a.png"));

        let taken = folder.path().join("taken.png");
        fs::create_dir(&taken).unwrap();
        let text = write(&taken);
        assert!(text.ends_with("taken.png: it is a folder"), "{text}");
    }

    /// Permissions do not bind an administrator; the folder of processes binds everyone.
    #[cfg(target_os = "linux")]
    #[test]
    fn a_folder_without_permission() {
        let text = write_image(Path::new("/proc/sunroom.png"), &picture(), &Display::default())
            .unwrap_err()
            .to_string();
        assert!(text.starts_with("cannot write /proc/sunroom.png: "), "{text}");
        assert!(!text.contains(".part"), "{text}");
    }

    #[cfg(unix)]
    #[test]
    fn links_stay_and_a_failure_keeps_the_old_file() {
        use std::os::unix::fs::{PermissionsExt, symlink};
        let folder = folder();
        let (real, link) = (folder.path().join("real.png"), folder.path().join("link.png"));
        fs::write(&real, "old").unwrap();
        symlink(&real, &link).unwrap();
        let mut broken = picture();
        broken.pixels.pop();
        assert!(matches!(
            write_image(&link, &broken, &Display::default()),
            Err(ImageIoError::WrongSize {
                width: 37,
                height: 11,
                pixels: 406
            })
        ));
        assert_eq!(fs::read(&real).unwrap(), b"old");
        write_image(&link, &picture(), &Display::default()).unwrap();
        assert!(link.symlink_metadata().unwrap().is_symlink());
        assert_eq!(read_image(&real).width, 37);
        // The file is as readable as any file made here, not only for the owner.
        let other = folder.path().join("other");
        fs::write(&other, "").unwrap();
        let mode = |path: &Path| fs::metadata(path).unwrap().permissions().mode();
        assert_eq!(mode(&real), mode(&other));
    }
}
