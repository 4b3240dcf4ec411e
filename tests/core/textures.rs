//! Textures from file to value: every shared picture, broken files, and what they look like.

use std::fs;
use std::path::{Path, PathBuf};

use glam::Vec3;
use sunroom::texture::{ImageFileError, load_image};

const SHARED: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/data");

/// `None`, said aloud, where the shared data are not there.
fn shared(file: &str) -> Option<Vec<u8>> {
    let path = Path::new(SHARED).join(file);
    let bytes = fs::read(&path).ok();
    if bytes.is_none() {
        eprintln!("skipped: {} is not there", path.display());
    }
    bytes
}

fn pictures_in(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        let path = entry.path();
        let extension = path.extension().unwrap_or_default().to_string_lossy().to_lowercase();
        if path.is_dir() {
            pictures_in(&path, found);
        } else if ["png", "jpg", "jpeg", "bmp", "tga", "ppm", "exr", "hdr", "pfm"].contains(&&*extension) {
            found.push(path);
        }
    }
}

#[test]
fn every_shared_picture_loads() {
    let mut pictures = Vec::new();
    pictures_in(Path::new(SHARED), &mut pictures);
    if pictures.is_empty() {
        eprintln!("skipped: no pictures in {SHARED}");
    }
    for path in pictures {
        let image = load_image(&fs::read(&path).unwrap()).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
        let mean = image.mean(false);
        assert!(
            mean.is_finite() && mean.max_element() >= 0.0,
            "{} {mean}",
            path.display()
        );
    }
}

/// The same sky in four formats. Its maker wrote floats; halves keep 11 bits, RGBE 8 bits of the largest component.
#[test]
fn one_sky_in_four_formats() {
    let Some(bytes) = shared("env/synthetic_sky_128x64.pfm") else {
        return;
    };
    let pfm = load_image(&bytes).unwrap();
    for (file, precision) in [("_f32.exr", 0.0), ("_f16.exr", 1.0 / 2048.0), (".hdr", 1.0 / 128.0)] {
        let other = load_image(&shared(&format!("env/synthetic_sky_128x64{file}")).unwrap()).unwrap();
        assert_eq!((other.width(), other.height(), other.channels()), (128, 64, 3));
        for y in 0..64 {
            for x in 0..128 {
                let (a, b) = (pfm.pixel(x, y), other.pixel(x, y));
                let error = (a - b).abs().max_element();
                assert!(error <= precision * a.max_element(), "{file} {x} {y}: {a} {b}");
            }
        }
    }
}

/// DWAB loses what eyes do not miss; the same picture in PIZ keeps all.
#[test]
fn dwab_is_near_piz() {
    let (Some(lossy), Some(lossless)) = (shared("env/studio.exr"), shared("env/studio_piz.exr")) else {
        return;
    };
    let (lossy, lossless) = (load_image(&lossy).unwrap(), load_image(&lossless).unwrap());
    let error = (lossy.mean(false) - lossless.mean(false)).abs();
    assert!(
        error.max_element() < 0.01 * lossless.mean(false).max_element(),
        "{error}"
    );
}

/// Pixels as another reader of these files gives them.
#[test]
fn known_pixels() {
    for (file, x, y, expected, precision) in [
        ("noise_8x8.png", 5, 3, Vec3::splat(26_984.0 / 65_535.0), 1e-5),
        ("carrot.png", 0, 0, Vec3::splat(247.0 / 255.0), 1e-5),
        ("flower.bmp", 5, 3, Vec3::new(121.0, 136.0, 65.0) / 255.0, 1e-5),
        // Decoders of JPEG may round differently.
        ("gradient.jpg", 5, 3, Vec3::splat(156.0 / 255.0), 2.0 / 255.0),
    ] {
        let Some(bytes) = shared(&format!("env/{file}")) else {
            return;
        };
        let encoded = load_image(&bytes)
            .unwrap()
            .pixel(x, y)
            .map(sunroom::color::srgb_from_linear);
        let error = (encoded - expected).abs().max_element();
        assert!(error <= precision, "{file}: {encoded} {expected}");
    }
}

/// Whatever is cut off or changed, there is an error or a picture, and no panic.
#[test]
fn damaged_files_do_no_harm() {
    for file in [
        "noise_8x8.png",
        "gradient.jpg",
        "flower.bmp",
        "synthetic_sky_128x64.hdr",
        "synthetic_sky_128x64.pfm",
        "synthetic_sky_128x64_f16.exr",
        "park.exr",
    ] {
        let Some(bytes) = shared(&format!("env/{file}")) else {
            return;
        };
        for i in 0..60 {
            let length = bytes.len() * i / 60;
            let _ = load_image(&bytes[..length]);
            let mut changed = bytes.clone();
            // Headers first, where it hurts most.
            let at = if i < 40 { 7 * i } else { length };
            changed[at % bytes.len()] ^= 1 << (i % 8) | 0x80;
            let _ = load_image(&changed);
        }
    }
}

#[test]
fn promises_that_the_file_cannot_keep_take_no_memory() {
    let promise = |size: u32| [b"P6 ", format!("{size} {size} 255\n").as_bytes()].concat();
    assert!(matches!(
        load_image(&promise(60_000)),
        Err(ImageFileError::TooLarge { .. })
    ));
    let error = load_image(&promise(100)).unwrap_err();
    assert!(matches!(error, ImageFileError::Damaged(_)), "{error}");

    if let Some(mut exr) = shared("env/synthetic_sky_128x64_f16.exr") {
        let at = exr.windows(11).position(|name| name == b"dataWindow\0").unwrap();
        // Name, type `box2i`, size, then xMin, yMin, xMax, yMax.
        let x_max = at + 11 + 6 + 4 + 8;
        for corner in [x_max, x_max + 4] {
            exr[corner..corner + 4].copy_from_slice(&1_000_000i32.to_le_bytes());
        }
        let error = load_image(&exr).unwrap_err();
        assert!(matches!(error, ImageFileError::TooLarge { .. }), "{error}");
    }
}

/// Of every kind a picture of 24 x 16 pixels, which is known by red and green that grow to the right and downwards.
const JPEGS: [(&str, &[u8]); 5] = [
    ("baseline", include_bytes!("jpegs/baseline.jpg")),
    ("progressive", include_bytes!("jpegs/progressive.jpg")),
    ("restarts", include_bytes!("jpegs/restarts.jpg")),
    ("grey", include_bytes!("jpegs/grey.jpg")),
    ("cmyk", include_bytes!("jpegs/cmyk.jpg")),
];

#[test]
fn a_jpeg_file_is_read_whatever_follows_its_end_and_refused_if_it_has_none() {
    for (kind, bytes) in JPEGS {
        for rest in [&b""[..], b"\0", b"\xff", b"\r\n", b"a thumbnail \xff\xd8\xff"] {
            let image = load_image(&[bytes, rest].concat()).unwrap_or_else(|error| panic!("{kind}: {error}"));
            assert_eq!((image.width(), image.height()), (24, 16), "{kind}");
            let (first, last) = (image.pixel(1, 1), image.pixel(22, 14));
            assert!(
                first.x + 0.2 < last.x && first.y + 0.2 < last.y,
                "{kind}: {first} {last}"
            );
        }
        for length in 3..bytes.len() {
            let error = load_image(&bytes[..length]).map(|_| ()).expect_err(kind);
            assert!(matches!(error, ImageFileError::Damaged(_)), "{kind} {length}: {error}");
        }
        let half = load_image(&bytes[..bytes.len() * 9 / 10]).unwrap_err().to_string();
        assert!(
            half.contains("the JPEG file ends before its picture does"),
            "{kind}: {half}"
        );
    }
}

/// The end of a picture inside of another segment, such as that of a thumbnail, is not the end of the file's picture.
#[test]
fn the_end_of_a_thumbnail_is_not_the_end_of_a_jpeg_file() {
    let (_, bytes) = JPEGS[0];
    let segment = b"\xff\xe1\0\x08\xff\xd8\xff\xd9\0\0";
    let with_thumbnail = [&bytes[..2], segment, &bytes[2..]].concat();
    load_image(&with_thumbnail).expect("is whole");
    assert!(load_image(&with_thumbnail[..bytes.len() - 60]).is_err());
}

#[test]
fn errors_say_what_to_do() {
    for (bytes, words) in [
        (&b"no picture at all, but some text"[..], "known format"),
        (b"", "known format"),
        (b"GIF89a\x01\0\x01\0\0\0\0", "GIF"),
        (b"P6 0 0 255\n", "pixels"),
        (b"#?RGBE\n\n-Y 1 +X 1\n", "damaged"),
    ] {
        let text = load_image(bytes).unwrap_err().to_string();
        assert!(text.contains(words), "{text}");
    }
}
