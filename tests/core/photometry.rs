//! Files of luminous intensities: the formats' variants, their messages, and lights that shine by them.

use std::f64::consts::PI;
use std::fs;
use std::sync::Arc;

use crate::ROOT;
use crate::support::{SceneBuilder, all_around};
use glam::{DVec3, Mat3, Vec2, Vec3};
use sunroom::color::{Rgb, luminance};
use sunroom::light::{EnvironmentMap, LightSource, Luminaire};
use sunroom::photometry::{Distribution, IntensityPicture, LUMENS_PER_WATT, is_profile, read_profile};
use sunroom::texture::load_image;

fn bytes_of(name: &str) -> Vec<u8> {
    fs::read(format!("{ROOT}/tests/corpus/photometry/{name}")).unwrap()
}

fn distribution(name: &str) -> Distribution {
    let bytes = bytes_of(name);
    assert!(is_profile(&bytes), "{name}");
    read_profile(&bytes).unwrap_or_else(|error| panic!("{name}: {error}"))
}

/// The unit direction at these angles of type C in degrees.
fn type_c(gamma: f64, c: f64) -> DVec3 {
    let (sin_gamma, cos_gamma) = gamma.to_radians().sin_cos();
    let (sin_c, cos_c) = c.to_radians().sin_cos();
    DVec3::new(sin_gamma * cos_c, -sin_gamma * sin_c, cos_gamma)
}

fn assert_near(found: f64, expected: f64, tolerance: f64, what: &str) {
    assert!(
        (found - expected).abs() <= tolerance * expected.abs().max(1.0),
        "{what}: {found}, expected {expected}"
    );
}

#[test]
fn intensities_of_type_c_follow_the_symmetry_of_the_file() {
    let fading = |gamma: f64| 1.0 - gamma / 90.0;
    // The intensity at half of 90 degrees, where the lamps fade linearly, for planes in all four quadrants.
    for (name, planes) in [
        (
            "quadrant.ies",
            [(20.0, 140.0), (160.0, 140.0), (200.0, 140.0), (340.0, 140.0)],
        ),
        (
            "half.ies",
            [(20.0, 120.0), (160.0, 260.0), (200.0, 260.0), (340.0, 120.0)],
        ),
        (
            "half_from_90.ies",
            [(100.0, 200.0), (80.0, 200.0), (260.0, 360.0), (280.0, 360.0)],
        ),
        (
            "whole.ies",
            [(20.0, 120.0), (160.0, 260.0), (200.0, 300.0), (340.0, 440.0)],
        ),
        (
            "open_circle.ies",
            [(30.0, 130.0), (150.0, 250.0), (345.0, 445.0), (352.5, 272.5)],
        ),
        (
            "both_planes.ldt",
            [(15.0, 130.0), (165.0, 130.0), (195.0, 130.0), (345.0, 130.0)],
        ),
        (
            "plane_c0.ldt",
            [(30.0, 260.0), (150.0, 500.0), (210.0, 500.0), (330.0, 260.0)],
        ),
        (
            "plane_c90.ldt",
            [(0.0, 190.0), (180.0, 190.0), (285.0, 115.0), (255.0, 115.0)],
        ),
        (
            "without_symmetry.ldt",
            [(30.0, 65.0), (150.0, 125.0), (210.0, 155.0), (330.0, 215.0)],
        ),
    ] {
        let lamp = distribution(name);
        for (c, at_nadir) in planes {
            for gamma in [0.5, 45.0, 77.5] {
                let found = lamp.intensity(type_c(gamma, c));
                assert_near(
                    found,
                    at_nadir * fading(gamma),
                    1e-4,
                    &format!("{name} at {gamma}, {c}"),
                );
            }
            assert_eq!(lamp.intensity(type_c(91.0, c)), 0.0, "{name}");
        }
    }
}

#[test]
fn the_flux_is_the_integral_of_the_intensities() {
    let cosine = PI * 1000.0;
    // The halves of lamps of types A and B meet over ten degrees.
    let width = 10f64.to_radians();
    let between = 1000.0 * (0.25 * width + (1.0 - (2.0 * width).cos()) / (8.0 * width));
    // Numbers are off by the distance of chords from the curves of the angles in the file.
    for (name, lumens, tolerance) in [
        ("round.ies", cosine, 1e-4),
        ("round.ldt", cosine, 1e-4),
        ("even.ies", 4.0 * PI * 100.0, 1e-6),
        ("ballast.ies", 4.0 * PI * 200.0, 1e-6),
        ("tilt_file.ies", 4.0 * PI * 100.0, 1e-6),
        ("tilt_included.ies", 4.0 * PI * 90.0, 1e-6),
        ("one_number_a_line.ies", 4.0 * PI * 100.0, 1e-6),
        ("commas.ies", 4.0 * PI * 100.0, 1e-6),
        ("of_1986.ies", 4.0 * PI * 100.0, 1e-6),
        ("upward.ies", cosine, 3e-3),
        // The integral of the squared cosine over half of the sphere, three quarters of it on either side.
        ("type_b.ies", 0.75 * cosine + between, 6e-3),
        ("type_b_half.ies", cosine, 6e-3),
        ("type_a.ies", 0.75 * cosine + between, 6e-3),
    ] {
        let picture = distribution(name).picture();
        assert_near(picture.lumens(), lumens, tolerance, name);
        // The light's own average is the same.
        let image = Arc::new(load_image(&bytes_of(name)).unwrap());
        let mean = EnvironmentMap::new(image, false).mean_luminance() * LUMENS_PER_WATT;
        assert_near(4.0 * PI * f64::from(mean), picture.lumens(), 1e-5, name);
    }
}

#[test]
fn types_a_and_b_turn_around_their_axes() {
    // Type B: the lamp is twice as bright to the left, which is +x for a beam along +z with +y up.
    let b = distribution("type_b.ies");
    let (sin, cos) = 30f64.to_radians().sin_cos();
    assert_near(b.intensity(DVec3::new(sin, 0.0, cos)), 1000.0 * cos, 1e-4, "left");
    assert_near(b.intensity(DVec3::new(-sin, 0.0, cos)), 500.0 * cos, 1e-4, "right");
    // To the side, the vertical angle of type B turns around the horizontal axis.
    let tilted = DVec3::new(sin, cos * 0.5, cos * (PI / 3.0).sin());
    assert_near(b.intensity(tilted), 1000.0 * cos * (PI / 6.0).cos(), 1e-4, "tilted");
    // Type A: the upper half is twice as bright; its horizontal angle turns around the vertical axis.
    let a = distribution("type_a.ies");
    assert_near(a.intensity(DVec3::new(0.0, sin, cos)), 1000.0 * cos, 1e-4, "up");
    assert_near(a.intensity(DVec3::new(0.0, -sin, cos)), 500.0 * cos, 1e-4, "down");
    let turned = DVec3::new(cos * 0.5, sin, cos * (PI / 3.0).sin());
    assert_near(a.intensity(turned), 1000.0 * cos * (PI / 6.0).cos(), 1e-4, "turned");
}

/// The bilinear value of a picture at these angles of type C in degrees.
fn looked_up(picture: &IntensityPicture, gamma: f64, c: f64) -> f64 {
    let row = (1.0 - gamma / 180.0) * f64::from(picture.height - 1);
    let column = (-c / 360.0).rem_euclid(1.0) * f64::from(picture.width);
    let pixel = |column: f64, row: f64| {
        let (column, row) = (column as u32 % picture.width, (row as u32).min(picture.height - 1));
        f64::from(picture.candela[(row * picture.width + column) as usize])
    };
    let (left, above) = (column.floor(), row.floor());
    let (s, t) = (column - left, row - above);
    let upper = pixel(left, above) * (1.0 - s) + pixel(left + 1.0, above) * s;
    let lower = pixel(left, above + 1.0) * (1.0 - s) + pixel(left + 1.0, above + 1.0) * s;
    upper * (1.0 - t) + lower * t
}

/// A lamp that is round, with these vertical angles and intensities.
fn round_lamp(angles: &[f64], candela: &[f64]) -> Distribution {
    let list = |numbers: &[f64]| numbers.iter().map(|number| format!("{number} ")).collect::<String>();
    let count = angles.len();
    let text = format!(
        "IES:LM-63-2019\nTILT=NONE\n1 -1 1 {count} 1 1 2 0 0 0\n1 1.1 10\n{}\n0\n{}\n",
        list(angles),
        list(candela)
    );
    read_profile(text.as_bytes()).unwrap()
}

#[test]
fn pictures_keep_the_intensities_between_the_angles_of_the_file() {
    // The steps of the files in degrees.
    for (name, vertical, horizontal) in [
        ("whole.ies", 5.0, 10.0),
        ("half_from_90.ies", 5.0, 10.0),
        ("without_symmetry.ldt", 5.0, 15.0),
        ("round.ies", 1.0, 360.0),
    ] {
        let lamp = distribution(name);
        let picture = lamp.picture();
        // At the poles the planes of a file may differ.
        for row in 1..(180.0 / vertical) as u32 * 2 {
            for column in 0..(360.0 / horizontal) as u32 * 2 {
                let (gamma, c) = (f64::from(row) * 0.5 * vertical, f64::from(column) * 0.5 * horizontal);
                let expected = lamp.intensity(type_c(gamma, c));
                assert_near(
                    looked_up(&picture, gamma, c),
                    expected,
                    1e-4,
                    &format!("{name} at {gamma}, {c}"),
                );
            }
        }
    }
    // The picture is as fine as the file, and no finer.
    let whole = distribution("whole.ies").picture();
    assert_eq!((whole.width, whole.height), (36, 37));
    assert_eq!(distribution("round.ies").picture().width, 1);
    // A narrow lamp with steps of a tenth of a degree, and one with two angles.
    let narrow = round_lamp(&[0.0, 0.1, 0.2, 0.3, 90.0], &[1000.0, 900.0, 500.0, 0.0, 0.0]);
    let picture = narrow.picture();
    assert_eq!(picture.height, 1801);
    assert_near(looked_up(&picture, 0.15, 0.0), 700.0, 1e-3, "narrow");
    let even = round_lamp(&[0.0, 180.0], &[100.0, 0.0]);
    let picture = even.picture();
    assert_eq!(picture.height, 3);
    assert_near(picture.lumens(), 2.0 * PI * 100.0, 1e-6, "two angles");
    // A lamp that goes out at 90 degrees fades over half a degree.
    assert_eq!(round_lamp(&[0.0, 90.0], &[100.0, 100.0]).picture().height, 361);
    // Finer pictures than this would take too much memory.
    let steps: Vec<f64> = (0..=4000).map(|step| f64::from(step) * 0.01).collect();
    let picture = round_lamp(&steps, &vec![1.0; steps.len()]).picture();
    assert_eq!((picture.width, picture.height), (1, 18_001));
}

#[test]
fn faults_are_told_with_their_lines() {
    let whole = String::from_utf8(bytes_of("quadrant.ies")).unwrap();
    for (from, to, expected) in [
        (
            "1 1000 1 19 10 1 2",
            "1 1000 1 19 10 4 2",
            "line 6: expected the photometric type from 1 to 3, found 4",
        ),
        (
            "1 1000 1 19 10 1 2",
            "1 1000 1 1e9 10 1 2",
            "line 6: expected the number of vertical angles from 1 to 4096, found 1000000000",
        ),
        (
            "1 1000 1 19 10 1 2",
            "1 1000 1 19 12 1 2",
            "line 43: the file ends where an intensity in candela is expected",
        ),
        (
            "1 1000 1 19",
            "1 1000 -1 19",
            "line 7: the factor on intensities is -1, where 0 or more is expected",
        ),
        (
            "40 45 50",
            "40 35 50",
            "line 10: the vertical angle 35 follows 40; they must ascend",
        ),
        (
            "80 85 90\n",
            "80 85 190\n",
            "line 10: the vertical angle 190 is not between 0 and 180 degrees",
        ),
        (
            "80 90\n",
            "80 95\n",
            "line 10: the horizontal angles go from 0 to 95 degrees",
        ),
        (
            "80 85 90\n",
            "80 eighty 90\n",
            "line 10: expected a vertical angle, found `eighty`",
        ),
        (
            "80 85 90\n",
            "80 inf 90\n",
            "line 10: expected a vertical angle, found `inf`",
        ),
    ] {
        assert!(whole.contains(from), "{from}");
        let text = whole.replacen(from, to, 1);
        let error = read_profile(text.as_bytes()).unwrap_err().to_string();
        assert!(error.starts_with(expected), "{error}\nexpected {expected}");
    }
    let whole = String::from_utf8(bytes_of("plane_c0.ldt")).unwrap();
    for (from, to, expected) in [
        (
            "Sunroom\r\n3\r\n2\r\n24",
            "Sunroom\r\n3\r\n2\r\n2.5",
            "line 4: expected the number of C-planes from 1 to 721, found 2.5",
        ),
        ("\r\n2000\r\n", "\r\n0\r\n", "line 29: the lamps have no lumens"),
        (
            "\r\n2000\r\n",
            "\r\nmany\r\n",
            "line 29: expected the lumens of the lamps, found `many`",
        ),
    ] {
        assert!(whole.contains(from), "{from}");
        let text = whole.replacen(from, to, 1);
        let error = read_profile(text.as_bytes()).unwrap_err().to_string();
        assert!(error.starts_with(expected), "{error}\nexpected {expected}");
    }
    let short: String = whole.lines().take(100).map(|line| format!("{line}\n")).collect();
    let error = read_profile(short.as_bytes()).unwrap_err();
    assert!(error.message.starts_with("the file ends"), "{error}");
    assert!(
        load_image(short.as_bytes())
            .unwrap_err()
            .to_string()
            .contains("fault in line")
    );
}

#[test]
fn lamps_are_told_from_pictures_by_their_content() {
    let lamp = String::from_utf8(bytes_of("plane_c0.ldt")).unwrap();
    for maker in ["Pfeifer Licht", "PF Lighting", "BMB", "DDS Leuchten", "II*"] {
        let text = lamp.replacen("Sunroom", maker, 1);
        let image = load_image(text.as_bytes()).unwrap_or_else(|error| panic!("{maker}: {error}"));
        assert_eq!(image.width(), 24, "{maker}");
    }
    let picture = "P3\n3\n2\n255\n".to_owned() + &"1\n".repeat(18);
    assert_eq!(load_image(picture.as_bytes()).unwrap().width(), 3);
    assert!(!is_profile(b"PF\n2\n2\n1.0\n\0\0\0\0"));
    // Blank fields of the head count as 0, but no blank line as an intensity.
    let lines: Vec<&str> = lamp.lines().collect();
    let mut blank = lines.clone();
    (blank[4], blank[6]) = ("", "");
    assert_eq!(
        read_profile(blank.join("\n").as_bytes()).unwrap(),
        distribution("plane_c0.ldt")
    );
    let mut cut = lines[..lines.len() - 1].join("\n");
    cut.push('\n');
    let error = read_profile(cut.as_bytes()).unwrap_err();
    assert!(error.message.starts_with("the file ends"), "{error}");
    // The plane at 360 degrees may be there as well; others may not be there twice.
    for (angle, is_read) in [("360", true), ("15", false)] {
        let mut lines = lines.clone();
        lines[3] = "25";
        lines[2] = "0";
        let (head, rest) = lines.split_at(42 + 24);
        let (gamma, values) = rest.split_at(19);
        let first = &values[..19];
        let values: Vec<&str> = first.repeat(25);
        let text = [head, &[angle], gamma, &values].concat().join("\n");
        assert_eq!(read_profile(text.as_bytes()).is_ok(), is_read, "{angle}");
    }
}

/// A lamp at the origin that shines down, with its horizontal angle 0 along the world's x.
fn luminaire(name: &str, scale: Rgb) -> Luminaire {
    let image = Arc::new(load_image(&bytes_of(name)).unwrap());
    Luminaire {
        position: Vec3::ZERO,
        world_from_local: Mat3::from_cols(Vec3::X, Vec3::Z, Vec3::NEG_Y),
        map: Arc::new(EnvironmentMap::new(image, false)),
        scale,
    }
}

#[test]
fn a_lamp_lights_its_surroundings_by_its_intensities() {
    let scale = Rgb::new(2.0, 1.0, 0.5);
    for name in [
        "whole.ies",
        "type_b.ies",
        "half_from_90.ies",
        "round.ies",
        "plane_c90.ldt",
    ] {
        let lamp = distribution(name);
        let mut scene = SceneBuilder::default();
        scene.light(LightSource::Luminaire(luminaire(name, scale)));
        let scene = scene.build();
        for (gamma, c) in [
            (0.5, 0.0),
            (20.0, 35.0),
            (45.0, 200.0),
            (62.0, 300.0),
            (89.0, 100.0),
            (95.0, 0.0),
        ] {
            let local = type_c(gamma, c).as_vec3();
            let at = 2.0 * Vec3::new(local.x, -local.z, local.y);
            let sample = scene.lights.sample(&all_around(at), 0.5, Vec2::splat(0.5));
            let found = sample.map_or(Rgb::ZERO, |(_, sample)| sample.radiance / sample.pdf);
            let candela = lamp.intensity(type_c(gamma, c));
            let expected = scale * (candela / f64::from(LUMENS_PER_WATT) / 4.0) as f32;
            // Curves of types A and B lie between the points of the picture.
            let error = (found - expected).abs().max_element();
            assert!(
                error < 2e-3 * expected.max_element().max(0.1),
                "{name} at {gamma}, {c}: {found}, {expected}"
            );
        }
    }
}

#[test]
fn seen_from_above_the_horizontal_angle_is_counterclockwise() {
    // Light falls to the north, the world's -z, at a horizontal angle of 90 degrees.
    let mut scene = SceneBuilder::default();
    scene.light(LightSource::Luminaire(luminaire("whole.ies", Rgb::ONE)));
    let scene = scene.build();
    let towards = |at: Vec3| {
        let sample = scene.lights.sample(&all_around(at), 0.5, Vec2::splat(0.5));
        sample.map_or(0.0, |(_, sample)| luminance(sample.radiance / sample.pdf))
            * at.length_squared()
            * LUMENS_PER_WATT
    };
    for (at, c) in [
        (Vec3::X, 0.0),
        (Vec3::NEG_Z, 90.0),
        (Vec3::NEG_X, 180.0),
        (Vec3::Z, 270.0),
    ] {
        let found = towards(at + Vec3::NEG_Y);
        assert!((found - (100.0 + c) * 0.5).abs() < 0.5, "{at}: {found}");
    }
}
