//! `sunroom diff`: figures, limits, exit codes, pictures and the page.

use std::path::{Path, PathBuf};
use std::process::Output;

use glam::Vec3;
use sunroom::render::image_io::exr::{decode_exr, write_exr};
use sunroom::render::image_io::{ExrCompression, ImageRgb, write_image};
use sunroom::render::layered_image::{LayeredImage, StoredColors};
use sunroom::render::tonemap::Display;

use crate::workshop::{Workshop, sunroom};

fn diff(picture: &Path, reference: &Path, more: &[&str]) -> Output {
    let mut command = sunroom();
    let command = command.arg("diff").arg(picture).arg(reference).args(more);
    command.output().expect("the program starts")
}

fn stdout(output: &Output) -> String {
    String::from_utf8_lossy(&output.stdout).into_owned()
}

fn stderr(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// A gradient of 32 x 24 pixels, times a factor, as an EXR file with a layer of normals and one of variances.
fn gradient(shop: &Workshop, name: &str, factor: f32) -> PathBuf {
    let (width, height) = (32, 24);
    let pixel = |i: u32| Vec3::new((i % width) as f32 / 16.0, (i / width) as f32 / 24.0, 0.5);
    let pixels: Vec<Vec3> = (0..width * height).map(|i| factor * pixel(i)).collect();
    let mut image = LayeredImage::new(width, height);
    image.add_rgb("", &pixels);
    image.add_xyz("Normal", &vec![Vec3::Z; pixels.len()]);
    image.add_float("Variance.Y", vec![0.005; pixels.len()]);
    let path = shop.path(name);
    write_exr(&path, &image, ExrCompression::Zip).expect("a writable folder");
    path
}

#[test]
fn figures_limits_and_exit_codes() {
    let shop = Workshop::new();
    let (a, b) = (gradient(&shop, "a.exr", 1.1), gradient(&shop, "b.exr", 1.0));
    let output = diff(&a, &b, &["--json"]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let figures: serde_json::Value = serde_json::from_str(&stdout(&output)).expect("JSON alone");
    let near = |name: &str, value: f64| {
        let found = figures[name].as_f64().expect(name);
        assert!((found - value).abs() < 1e-4 * value, "{name}: {found} {value}");
    };
    assert_eq!((&figures["width"], &figures["height"]), (&32.into(), &24.into()));
    near("mean_ratio", 1.1);
    // The mean of (0.1 x / 16)^2, (0.1 y / 24)^2 and 0.05^2.
    let squares = |count: i32| (0..count).map(|i| f64::from(i * i)).sum::<f64>() / f64::from(count);
    let mse = (0.01 * squares(32) / 256.0 + 0.01 * squares(24) / 576.0 + 0.0025) / 3.0;
    near("mse", mse);
    assert!(figures["flip"].as_f64().expect("a number") > 0.01);
    // The luminance differs by a tenth of itself; the noise of the difference has a deviation of 0.1.
    assert_eq!(figures["z"]["count"], 32 * 24);
    let mean_luminance = figures["means"][1].as_f64().expect("a number");
    let z = figures["z"]["mean"].as_f64().expect("a number");
    assert!((z - mean_luminance).abs() < 1e-3, "{z} {mean_luminance}");

    let text = stdout(&diff(&a, &b, &[]));
    for words in [
        "32 x 24",
        "mean ratio",
        "1.1000",
        "relMSE",
        "PSNR",
        "SSIM",
        "FLIP",
        "z-scores",
    ] {
        assert!(text.contains(words), "{words}: {text}");
    }
    let code = |args: &[&str]| diff(&a, &b, args).status.code();
    assert_eq!(
        code(&[
            "--fail-above",
            "mean=0.11",
            "--fail-above",
            "0.9",
            "--fail-below",
            "psnr=1"
        ]),
        Some(0)
    );
    assert_eq!(code(&["--fail-above", "mean=0.09"]), Some(1));
    assert_eq!(code(&["--fail-above", "0.000001"]), Some(1));
    assert_eq!(code(&["--fail-below", "ssim=0.99999"]), Some(1));
    assert_eq!(code(&["--fail-above", "psnr=3"]), Some(2));
    assert_eq!(code(&["--layer", "Normal", "--fail-above", "mse=0"]), Some(0));
    let equal = diff(
        &a,
        &a,
        &["--fail-above", "0", "--fail-above", "mse=0", "--fail-above", "z=0"],
    );
    assert_eq!(equal.status.code(), Some(0), "{}", stderr(&equal));
}

#[test]
fn layers_of_data_have_figures_of_data() {
    let shop = Workshop::new();
    let write = |name: &str, offset: f32| {
        let mut image = LayeredImage::new(16, 16);
        image.add_rgb("", &[Vec3::ONE; 256]);
        image.add_xyz("Normal", &[Vec3::new(-0.5, 0.25 + offset, 0.75); 256]);
        image.add_float("Depth.Z", vec![5.0 + offset; 256]);
        image.add_float("Motion.X", vec![1.0; 256]);
        image.add_float("Motion.Y", vec![offset; 256]);
        image.add_rgb("CryptoObject00", &[Vec3::ONE; 256]);
        let path = shop.path(name);
        write_exr(&path, &image, ExrCompression::Zip).expect("a writable folder");
        path
    };
    let (a, b) = (write("a.exr", 0.5), write("b.exr", 0.0));
    // The names in the file, on the command line of `render`, and of a channel.
    for (name, means, mse) in [
        (
            "Normal",
            "-0.500000 0.750000 0.750000 against -0.500000 0.250000 0.750000",
            "8.333334e-2",
        ),
        (
            "normal",
            "-0.500000 0.750000 0.750000 against -0.500000 0.250000 0.750000",
            "8.333334e-2",
        ),
        ("Normal.Y", "0.750000 against 0.250000", "2.500000e-1"),
        ("depth", "5.500000 against 5.000000", "2.500000e-1"),
        ("Depth.Z", "5.500000 against 5.000000", "2.500000e-1"),
        ("motion", "1.000000 0.500000 against 1.000000 0.000000", "1.250000e-1"),
    ] {
        let output = diff(&a, &b, &["--layer", name]);
        let text = stdout(&output);
        assert_eq!(output.status.code(), Some(0), "{name}: {}", stderr(&output));
        let has = |words: &str| text.contains(words);
        assert!(has(means) && has(mse) && has("5.000000e-1"), "{name}: {text}");
        assert!(!has("FLIP") && !has("luminance") && !has("PSNR"), "{name}: {text}");
    }
    let [signed, page] = ["d.exr", "page.html"].map(|name| shop.path(name).display().to_string());
    let output = diff(
        &a,
        &b,
        &[
            "--layer",
            "depth",
            "-o",
            &signed,
            "--html",
            &page,
            "--fail-above",
            "mse=0.3",
        ],
    );
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let difference = decode_exr(&std::fs::read(&signed).expect("written")).expect("an EXR file");
    assert_eq!(difference.layers(), [""]);
    let page = std::fs::read_to_string(&page).expect("written");
    assert!(!page.contains("{{") && !page.contains("FLIP"), "{page}");
    assert_eq!(page.matches("data:image/png;base64,iVBOR").count(), 3);

    let fails = |more: &[&str], code: i32, words: &str| {
        let output = diff(&a, &b, more);
        let said = stderr(&output);
        assert_eq!(output.status.code(), Some(code), "{said}");
        assert!(said.contains(words), "{said}");
    };
    fails(
        &["--layer", "depth", "--fail-above", "0.1"],
        1,
        "flip is not known of layers of data",
    );
    fails(&["--layer", "depth", "--flip-map", "f.png"], 2, "--flip-map");
    for matte in ["CryptoObject00", "CryptoObject00.R", "crypto-object", "cryptomatte"] {
        fails(&["--layer", matte], 2, "is a cryptomatte");
    }
    fails(&["--layer", "light-groups"], 2, "no layer or channel `light-groups`");
    fails(&["--layer", "all"], 2, "`all` means several");
    let output = diff(&a, &b, &["--layer", "motion", "--json"]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let figures: serde_json::Value = serde_json::from_str(&stdout(&output)).expect("JSON alone");
    assert_eq!(figures["component_means"], serde_json::json!([[1.0, 0.5], [1.0, 0.0]]));
    assert_eq!(
        (&figures["mse"], &figures["greatest_difference"]),
        (&0.125.into(), &0.5.into())
    );
    assert!(
        figures.get("flip").is_none() && figures.get("means").is_none(),
        "{figures}"
    );
}

#[test]
fn layers_of_two_kinds_are_not_compared() {
    let shop = Workshop::new();
    let write = |name: &str, add: fn(&mut LayeredImage)| {
        let mut image = LayeredImage::new(16, 16);
        image.add_rgb("", &[Vec3::ONE; 256]);
        add(&mut image);
        let path = shop.path(name);
        write_exr(&path, &image, ExrCompression::Zip).expect("a writable folder");
        path
    };
    let light = write("light.exr", |image| image.add_rgb("Thing", &[Vec3::ONE; 256]));
    let vector = write("vector.exr", |image| image.add_xyz("Thing", &[Vec3::ONE; 256]));
    let number = write("number.exr", |image| image.add_float("Thing.Y", vec![1.0; 256]));
    for (one, other, words) in [
        (&light, &vector, "has a layer of light with 3 components"),
        (&vector, &number, "has data with 1 component"),
        (&number, &light, "has data with 1 component"),
    ] {
        let output = diff(one, other, &["--layer", "Thing"]);
        let said = stderr(&output);
        assert_eq!(output.status.code(), Some(2), "{said}");
        for path in [one, other] {
            assert!(said.contains(&path.display().to_string()), "{said}");
        }
        assert!(said.contains(words), "{said}");
        assert_eq!(diff(one, one, &["--layer", "Thing"]).status.code(), Some(0));
    }
}

#[test]
fn a_grey_picture_is_compared_with_a_coloured_one_and_named() {
    let shop = Workshop::new();
    let write = |name: &str, add: fn(&mut LayeredImage)| {
        let mut image = LayeredImage::new(16, 16);
        add(&mut image);
        let path = shop.path(name);
        write_exr(&path, &image, ExrCompression::Zip).expect("a writable folder");
        path
    };
    let grey = write("grey.exr", |image| image.add_float("Y", vec![1.0; 256]));
    let coloured = write("coloured.exr", |image| image.add_rgb("", &[Vec3::ONE; 256]));
    for (one, other) in [(&grey, &coloured), (&coloured, &grey)] {
        let output = diff(one, other, &["--json"]);
        assert_eq!(output.status.code(), Some(0));
        let said = stderr(&output);
        let words = format!(
            "note: {} is grey and {} has colours",
            grey.display(),
            coloured.display()
        );
        assert!(said.contains(&words), "{said}");
        assert!(stdout(&output).contains("\"mse\": 0.0"), "{}", stdout(&output));
        assert_eq!(stderr(&diff(one, one, &[])), "");
    }
}

#[test]
fn grey_files_of_other_formats_are_named() {
    let shop = Workshop::new();
    let image = |pixel: Vec3| ImageRgb {
        width: 16,
        height: 16,
        pixels: vec![pixel; 256],
    };
    let path = |name: &str| shop.path(name);
    image::GrayImage::from_pixel(16, 16, image::Luma([255]))
        .save(path("grey.png"))
        .expect("a writable folder");
    let grey_pfm = [&b"Pf\n16 16\n-1.0\n"[..], &1.0f32.to_le_bytes().repeat(256)].concat();
    shop.write("grey.pfm", grey_pfm);
    for name in ["white.png", "white.pfm", "white.hdr", "white.exr"] {
        write_image(&path(name), &image(Vec3::ONE), &Display::default()).expect("a writable folder");
    }
    let said = |one: &str, other: &str| {
        let output = diff(&path(one), &path(other), &["--json"]);
        let said = stderr(&output);
        assert_eq!(output.status.code(), Some(0), "{said}");
        let figures: serde_json::Value = serde_json::from_str(&stdout(&output)).expect("JSON alone");
        assert_eq!(figures["mse"], 0.0, "{one} {other}");
        said
    };
    for ending in ["png", "pfm"] {
        let (grey, white) = (format!("grey.{ending}"), format!("white.{ending}"));
        for (one, other) in [(&grey, &white), (&white, &grey)] {
            let words = format!(
                "note: {} is grey and {} has colours",
                path(&grey).display(),
                path(&white).display()
            );
            let said = said(one, other);
            assert!(said.contains(&words) && said.lines().count() == 1, "{said}");
        }
        assert_eq!(said(&grey, &grey), "");
    }
    // What a display shows, and radiance.
    for radiance in ["white.pfm", "white.hdr", "white.exr"] {
        for (one, other) in [("white.png", radiance), (radiance, "white.png")] {
            let words = format!(
                "note: {} has what a display shows, at most 1, and {} has radiance",
                path("white.png").display(),
                path(radiance).display()
            );
            let said = said(one, other);
            assert!(said.contains(&words) && said.lines().count() == 1, "{said}");
        }
        assert_eq!(said(radiance, "white.exr"), "");
    }
}

#[test]
fn pictures_in_xyz_are_compared_as_colours() {
    let shop = Workshop::new();
    let colours = gradient(&shop, "rgb.exr", 1.0);
    let mut image = decode_exr(&std::fs::read(&colours).expect("written")).expect("an EXR file");
    image.convert_colors(StoredColors::Xyz);
    let xyz = shop.path("xyz.exr");
    write_exr(&xyz, &image, ExrCompression::Zip).expect("a writable folder");
    let output = diff(&xyz, &colours, &["--fail-above", "mse=1e-12"]);
    let said = stderr(&output);
    assert_eq!(output.status.code(), Some(0), "{said}");
    let words = format!("note: {} has the channels X, Y and Z", xyz.display());
    assert!(said.contains(&words) && said.lines().count() == 1, "{said}");
    // A layer of vectors stays what it is.
    let normals = diff(&xyz, &colours, &["--layer", "Normal"]);
    assert_eq!(stderr(&normals), "");
}

#[test]
fn what_cannot_be_compared_is_said() {
    let shop = Workshop::new();
    let a = gradient(&shop, "a.exr", 1.0);
    let small = shop.path("small.png");
    let one = ImageRgb {
        width: 1,
        height: 1,
        pixels: vec![Vec3::ONE],
    };
    write_image(&small, &one, &Display::default()).expect("a writable folder");
    let broken = shop.write("broken.exr", b"v/1\x01\x02\0\0\0 and no more");
    let says = |picture: &Path, more: &[&str], words: &[&str]| {
        let output = diff(picture, &a, more);
        let said = stderr(&output);
        assert_eq!(output.status.code(), Some(2), "{said}");
        assert!(words.iter().all(|word| said.contains(word)), "{said}");
    };
    says(&small, &[], &["1 x 1", "32 x 24", "small.png", "a.exr"]);
    says(&broken, &[], &["broken.exr: the picture is damaged"]);
    says(&shop.path("missing.exr"), &[], &["missing.exr"]);
    says(
        &a,
        &["--layer", "Albedo"],
        &["no layer or channel `Albedo`", "`Normal`", "`Variance`"],
    );
    says(&a, &["-o", "a.xyz"], &["a.xyz", ".exr"]);
    for nothing in ["", " "] {
        says(&a, &["--layer", nothing], &["expected the name of a layer or channel"]);
    }
    let nowhere = shop.path("no-folder/page.html");
    says(&a, &["--html", &nowhere.to_string_lossy()], &["page.html"]);
    // A pixel that is no number fails every limit.
    let mut image = decode_exr(&std::fs::read(&a).expect("written")).expect("an EXR file");
    let values = image
        .layer("")
        .expect("colours")
        .pixels
        .iter()
        .map(|pixel| pixel.x)
        .collect::<Vec<_>>();
    image.channels.retain(|channel| channel.name != "R");
    image.add_float(
        "R",
        values
            .iter()
            .enumerate()
            .map(|(i, &x)| if i == 7 { f32::NAN } else { x })
            .collect(),
    );
    let nan = shop.path("nan.exr");
    write_exr(&nan, &image, ExrCompression::Zip).expect("a writable folder");
    let output = diff(&nan, &a, &["--fail-above", "1"]);
    assert_eq!(output.status.code(), Some(1));
    assert!(stdout(&output).contains("1 against 0"), "{}", stdout(&output));
}

#[test]
fn results_never_replace_the_pictures_or_each_other() {
    let shop = Workshop::new();
    let (a, b) = (gradient(&shop, "a.exr", 1.1), gradient(&shop, "b.exr", 1.0));
    let before = [&a, &b].map(|path| std::fs::read(path).expect("written"));
    std::fs::create_dir(shop.path("folder")).expect("a writable folder");
    let path = |name: &str| shop.path(name).display().to_string();
    let mut same = vec![path("a.exr"), path("b.exr"), path("folder/../a.exr")];
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink(&a, shop.path("link.exr")).expect("a link");
        same.push(path("link.exr"));
    }
    let refuses = |more: &[&str], words: &str| {
        let output = diff(&a, &b, more);
        let said = stderr(&output);
        assert_eq!(output.status.code(), Some(2), "{more:?}: {said}");
        assert!(said.contains(words), "{more:?}: {said}");
        assert_eq!(stdout(&output), "");
    };
    for name in &same {
        for option in ["-o", "--flip-map", "--html"] {
            let words = format!("{name}: this output is one of the pictures that are compared");
            refuses(&[option, name], &words);
        }
    }
    // A page replaces no scene that was meant for something else.
    let scene = path("scene.xml");
    std::fs::write(&scene, "<scene/>").expect("a file");
    refuses(&["--html", &scene], "the name of a page ends in .html or .htm");
    assert_eq!(std::fs::read_to_string(&scene).expect("a file"), "<scene/>");
    let (one, other) = (path("x.png"), path("folder/../x.png"));
    for options in [["-o", "--flip-map"], ["-o", "--html"], ["--flip-map", "--html"]] {
        let twice = format!("{}: this output is named twice", other);
        refuses(&[options[0], &one, options[1], &other], &twice);
    }
    refuses(&["-o", "-", "--flip-map", "-"], "-: this output is named twice");
    assert!(!shop.path("x.png").exists());
    for (path, before) in [&a, &b].into_iter().zip(before) {
        assert!(std::fs::read(path).expect("still there") == before);
    }
}

#[test]
fn differences_and_pages_are_written() {
    let shop = Workshop::new();
    let (a, b) = (gradient(&shop, "a<b>.exr", 0.5), gradient(&shop, "b.exr", 1.0));
    let [signed, map, page] = ["d.exr", "flip.png", "page.html"].map(|name| shop.path(name).display().to_string());
    let output = diff(&a, &b, &["-o", &signed, "--flip-map", &map, "--html", &page]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let difference = decode_exr(&std::fs::read(&signed).expect("written")).expect("an EXR file");
    let pixels = difference.layer("").expect("colours").pixels;
    assert!(pixels.iter().all(|pixel| pixel.z == -0.25));
    let flip = difference.layer("FLIP").expect("errors").pixels;
    let map = image::open(&map).expect("a PNG").to_rgb8();
    assert_eq!(map.dimensions(), (32, 24));
    // Of magma's colours the red is greater where the error is.
    let order = |i: usize| map.get_pixel(i as u32 % 32, i as u32 / 32).0[0];
    let greatest = (0..flip.len())
        .max_by(|&i, &j| flip[i].x.total_cmp(&flip[j].x))
        .expect("pixels");
    let least = (0..flip.len())
        .min_by(|&i, &j| flip[i].x.total_cmp(&flip[j].x))
        .expect("pixels");
    assert!(order(greatest) > order(least));
    let page = std::fs::read_to_string(&page).expect("written");
    assert!(page.starts_with("<!DOCTYPE html>") && !page.contains("{{"));
    assert!(page.contains("a&lt;b&gt;.exr") && !page.contains("a<b>.exr"));
    assert_eq!(page.matches("data:image/png;base64,iVBOR").count(), 4);
    // The file needs nothing from elsewhere.
    assert!(!page.contains("http:") && !page.contains("https:"));
}

#[test]
fn pictures_of_a_display_are_compared_as_displayed() {
    let shop = Workshop::new();
    let write = |name: &str, value: f32| {
        let path = shop.path(name);
        let image = ImageRgb {
            width: 16,
            height: 16,
            pixels: vec![Vec3::splat(value); 256],
        };
        write_image(&path, &image, &Display::default()).expect("a writable folder");
        path
    };
    let text = stdout(&diff(&write("a.png", 0.2), &write("b.png", 0.21), &[]));
    assert!(text.contains("as displayed"), "{text}");
    let text = stdout(&diff(&write("a.pfm", 0.2), &write("b.pfm", 0.21), &[]));
    assert!(text.contains("stops"), "{text}");
}

#[test]
fn a_picture_on_standard_output_is_alone_there() {
    let shop = Workshop::new();
    let (a, b) = (gradient(&shop, "a.exr", 1.1), gradient(&shop, "b.exr", 1.0));
    for option in ["--output", "--flip-map"] {
        let output = diff(&a, &b, &[option, "-"]);
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
        let image = sunroom::texture::load_image(&output.stdout).expect("a picture and nothing else");
        assert_eq!((image.width(), image.height()), (32, 24));
        assert!(output.stdout.starts_with(b"\x89PNG"));
        assert!(stderr(&output).contains("FLIP"), "{}", stderr(&output));
    }
}
