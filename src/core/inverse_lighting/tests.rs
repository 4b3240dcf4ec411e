//! Tests of private parts: coverage and wishes.

use glam::Vec2;

use super::*;
use crate::color::{Rgb, luminance};

fn dot(hardness: f32) -> Stroke {
    Stroke {
        wish: Wish::Keep,
        path: vec![Vec2::splat(0.5)],
        radius: 0.25,
        hardness,
    }
}

#[test]
fn a_stroke_covers_its_disk_along_the_path() {
    let hard = dot(1.0).coverage(200, 100);
    let area: f32 = hard.shares.iter().sum();
    let expected = std::f32::consts::PI * 25.0 * 25.0;
    assert!((area / expected - 1.0).abs() < 0.01, "{area} pixels, not {expected}");
    assert_eq!((hard.share(100, 50), hard.share(126, 50)), (1.0, 0.0));
    let soft = dot(0.0).coverage(200, 100);
    assert!((soft.share(112, 50) - 0.5).abs() < 0.05, "half way out half is covered");
    let line = Stroke {
        path: vec![Vec2::new(0.25, 0.5), Vec2::new(0.75, 0.5)],
        ..dot(1.0)
    };
    let area: f32 = line.coverage(200, 100).shares.iter().sum();
    let expected = expected + 100.0 * 50.0;
    assert!((area / expected - 1.0).abs() < 0.01, "{area} pixels, not {expected}");
}

#[test]
fn strokes_beyond_the_picture_and_bad_ones_cover_nothing() {
    let outside = Stroke {
        path: vec![Vec2::splat(-9.0), Vec2::new(-9.0, 9.0)],
        ..dot(0.5)
    };
    assert!(outside.coverage(64, 64).shares.iter().all(|share| *share == 0.0));
    for bad in [
        Stroke {
            path: vec![],
            ..dot(0.5)
        },
        Stroke {
            radius: f32::NAN,
            ..dot(0.5)
        },
        Stroke {
            path: vec![Vec2::NAN],
            ..dot(0.5)
        },
        Stroke {
            wish: Wish::Color(Rgb::ZERO),
            ..dot(0.5)
        },
    ] {
        assert_eq!(bad.coverage(64, 64), Coverage::default(), "{bad:?}");
    }
    let huge = Stroke {
        radius: 1e30,
        ..dot(0.5)
    };
    assert_eq!(huge.coverage(8, 8).shares, [1.0; 64]);
}

#[test]
fn wishes_in_photometric_units_follow_from_the_luminance() {
    let present = Rgb::new(1.0, 2.0, 3.0);
    let two = Some(Wanted::Luminance(2.0));
    assert_eq!(Wish::Luminance(1366.0).wanted(present), two);
    assert_eq!(Wish::Illuminance(1366.0).wanted(present), two);
    let Some(Wanted::Color(red)) = Wish::Color(Rgb::X).wanted(present) else {
        panic!("a colour");
    };
    assert!((luminance(red) - luminance(present)).abs() < 1e-5 && red.y == 0.0);
}
