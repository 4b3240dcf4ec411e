//! Round trips of pictures through files.

use std::fs;

use glam::Vec3;

use super::*;
use crate::files;
use crate::render::tonemap::ToneMap;
use crate::texture::load_image;

fn read(path: &Path) -> Vec<u8> {
    files::read(path, 1 << 20).expect("the file is there")
}

fn read_image(path: &Path) -> ImageRgb {
    let image = load_image(&read(path)).unwrap();
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
    // The file is not read as a texture, where such numbers count as black.
    let numbers = image::load_from_memory(&read(&path)).unwrap().into_rgb32f().into_raw();
    assert!(numbers[0].is_nan() && numbers[1] == f32::INFINITY && numbers[2] == -1.0);
    assert_eq!(numbers[3..], [f32::MIN_POSITIVE; 3]);
    fs::remove_dir_all(path.parent().unwrap()).unwrap();
}

#[test]
fn hdr_keeps_eight_bits_of_the_largest_component() {
    let folder = folder();
    let path = folder.path().join("a.hdr");
    write_image(&path, &picture(), &Display::default()).unwrap();
    let read = read_image(&path);
    for (got, put) in read.pixels.iter().zip(&picture().pixels) {
        // Half a unit of eight bits under the exponent of the largest component: at most 1/256 of it.
        let error = (*got - *put).abs().max_element();
        assert!(error <= put.max_element() / 256.0, "{got} {put}");
    }
    // The picture is not darker or brighter as a whole.
    let put = picture().pixels;
    let ratio = |(got, put): (&Vec3, &Vec3)| f64::from(got.max_element() / put.max_element());
    let mean = read.pixels.iter().zip(&put).map(ratio).sum::<f64>() / put.len() as f64;
    assert!((mean - 1.0).abs() < 5e-4, "{mean}");
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
fn hdr_carries_what_is_rounded_up_into_the_exponent() {
    let folder = folder();
    let path = folder.path().join("a.hdr");
    let pairs = [
        // 255.6 units become 256, and the units of the other components are twice as large: 101 of the old units
        // become 50.5, which is 51.
        (Vec3::new(255.6, 101.0, 0.4), Vec3::new(256.0, 102.0, 0.0)),
        (Vec3::new(255.4, 101.0, 0.6), Vec3::new(255.0, 101.0, 1.0)),
        (Vec3::splat(1.0), Vec3::splat(1.0)),
        (Vec3::splat(0.999_999_9), Vec3::splat(1.0)),
        // Too small for the exponent, and smaller than normal numbers.
        (Vec3::splat(1e-35), Vec3::ZERO),
        (Vec3::splat(1e-42), Vec3::ZERO),
    ];
    let image = ImageRgb {
        width: pairs.len() as u32,
        height: 1,
        pixels: pairs.map(|pair| pair.0).to_vec(),
    };
    write_image(&path, &image, &Display::default()).unwrap();
    assert_eq!(read_image(&path).pixels, pairs.map(|pair| pair.1));
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
fn pfm_keeps_every_bit() {
    let folder = folder();
    let path = folder.path().join("a.pfm");
    write_image(&path, &picture(), &Display::default()).unwrap();
    assert_eq!(read_image(&path), picture());
}

#[test]
fn sixteen_bits_and_jpeg_show_the_same_as_eight() {
    let mut options = FileOptions {
        png_16_bits: true,
        jpeg_quality: 100,
        ..FileOptions::default()
    };
    let smooth = |i: u32| Rgb::new(i as f32 / 400.0, 0.5, 0.2 + i as f32 / 800.0);
    let picture = ImageRgb {
        pixels: (0..37 * 11).map(smooth).collect(),
        ..picture()
    };
    for tone_map in ToneMap::ALL {
        options.display.tone_map = tone_map;
        let shown: Vec<[u8; 3]> = picture
            .pixels
            .iter()
            .map(|&pixel| options.display.encode(pixel))
            .collect();
        let png = encode_layered(&(&picture).into(), FileFormat::Png, &options).unwrap();
        let png = image::load_from_memory(&png).unwrap();
        assert_eq!(png.color(), image::ColorType::Rgb16);
        for (deep, shown) in png.to_rgb16().pixels().zip(&shown) {
            // There are 257 steps per byte.
            let rounded = deep.0.map(|deep| ((u32::from(deep) + 128) / 257) as u8);
            assert_eq!(rounded, *shown, "{tone_map:?} {deep:?}");
        }
        let jpeg = encode_layered(&(&picture).into(), FileFormat::Jpeg, &options).unwrap();
        let jpeg = image::load_from_memory(&jpeg).unwrap().to_rgb8();
        for (near, shown) in jpeg.pixels().zip(&shown) {
            assert!(
                (0..3).all(|i| near.0[i].abs_diff(shown[i]) <= 8),
                "{tone_map:?} {near:?} {shown:?}"
            );
        }
    }
    let rough = FileOptions {
        jpeg_quality: 10,
        ..options
    };
    let [fine, rough] = [options, rough].map(|options| {
        let jpeg = encode_layered(&(&picture).into(), FileFormat::Jpeg, &options);
        jpeg.expect("a picture").len()
    });
    assert!(rough < fine, "{rough} {fine}");
}

#[test]
fn opacity_goes_into_png() {
    let mut layered = LayeredImage::new(2, 1);
    // Premultiplied colours, which are lower where the background shows through.
    layered.add_rgb("", &[Rgb::splat(0.25), Rgb::ZERO]);
    layered.add_float("A", vec![0.5, 0.0]);
    for png_16_bits in [false, true] {
        let options = FileOptions {
            png_16_bits,
            ..FileOptions::default()
        };
        let png = encode_layered(&layered, FileFormat::Png, &options).unwrap();
        let png = image::load_from_memory(&png).unwrap();
        assert!(png.color().has_alpha());
        // Half of white's light in a pixel of opacity one half: the sRGB value of 0.5 is 188.
        assert_eq!(png.to_rgba8().into_raw(), [188, 188, 188, 128, 0, 0, 0, 0]);
    }
    let depths = LayeredImage {
        channels: vec![],
        ..layered
    };
    let error = encode_layered(&depths, FileFormat::Png, &FileOptions::default()).unwrap_err();
    assert!(matches!(error, ImageIoError::NoColors), "{error}");
}

#[test]
fn a_picture_without_a_place_is_kept_whole_in_the_temporary_folder() {
    let [first, second] =
        [(); 2].map(|()| write_to_temporary_folder(&(&picture()).into()).expect("there is such a folder"));
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
        assert!(
            text.contains(name) && text.contains(".exr, .hdr, .pfm, .png, .jpg or .jpeg"),
            "{text}"
        );
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

/// Permissions do not bind an administrator; the folder of processes does.
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
    assert_eq!(read(&real), b"old");
    write_image(&link, &picture(), &Display::default()).unwrap();
    assert!(link.symlink_metadata().unwrap().is_symlink());
    assert_eq!(read_image(&real).width, 37);
    // The file has the permissions of any new file here, not those of a temporary one.
    let other = folder.path().join("other");
    fs::write(&other, "").unwrap();
    let mode = |path: &Path| fs::metadata(path).unwrap().permissions().mode();
    assert_eq!(mode(&real), mode(&other));
}
