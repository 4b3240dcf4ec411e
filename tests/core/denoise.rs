//! The denoiser against pictures whose noise-free version is known.
#![cfg(feature = "denoise")]

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use glam::{Vec2, Vec3};
use sunroom::render::denoise::{DenoiseError, DenoiseInput, DenoiseQuality, denoise};

struct Picture {
    width: u32,
    height: u32,
    truth: Vec<Vec3>,
    noisy: Vec<Vec3>,
    albedo: Vec<Vec3>,
    noisy_albedo: Vec<Vec3>,
    normal: Vec<Vec3>,
}

impl Picture {
    /// A lit sphere before a chequered wall, with exponential noise: mean 1, standard deviation 1, as a few samples of
    /// indirect light would have.
    fn new(width: u32, height: u32) -> Self {
        let mut state = 1_u32;
        let mut uniform = move || {
            // Numerical Recipes' generator is quite enough for noise.
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 8) as f32 / (1 << 24) as f32
        };
        let mut picture = Self {
            width,
            height,
            truth: Vec::new(),
            noisy: Vec::new(),
            albedo: Vec::new(),
            noisy_albedo: Vec::new(),
            normal: Vec::new(),
        };
        let light = Vec3::new(0.6, 0.6, 0.53);
        for (x, y) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))) {
            let at = (Vec2::new(x as f32, y as f32) * 2.0 - Vec2::new(width as f32, height as f32)) / height as f32;
            let inside = 0.5 - at.length_squared();
            let (albedo, normal) = if inside > 0.0 {
                (Vec3::new(0.8, 0.3, 0.2), at.extend(inside.sqrt()).normalize())
            } else if (x / 16 + y / 16) % 2 == 0 {
                (Vec3::splat(0.7), Vec3::Z)
            } else {
                (Vec3::new(0.1, 0.2, 0.4), Vec3::Z)
            };
            let radiance = albedo * (0.2 + normal.dot(light).max(0.0));
            picture.truth.push(radiance);
            picture.noisy.push(radiance * -(1.0 - uniform()).ln());
            picture.albedo.push(albedo);
            picture.noisy_albedo.push(albedo * (0.5 + uniform()));
            picture.normal.push(normal);
        }
        picture
    }

    fn input(&self) -> DenoiseInput<'_> {
        DenoiseInput {
            width: self.width,
            height: self.height,
            color: &self.noisy,
            albedo: None,
            normal: None,
            prefilter: false,
            quality: DenoiseQuality::Fast,
            threads: Some(2),
        }
    }

    fn mean_square_error(&self, pixels: &[Vec3]) -> f32 {
        assert_eq!(pixels.len(), self.truth.len());
        let errors = pixels
            .iter()
            .zip(&self.truth)
            .map(|(a, b)| (*a - *b).length_squared() / 3.0);
        errors.sum::<f32>() / pixels.len() as f32
    }
}

fn run(input: &DenoiseInput) -> Vec<Vec3> {
    denoise(input, &AtomicBool::new(false)).expect("the filter works on this machine")
}

#[test]
fn noise_goes_and_guides_help() {
    let picture = Picture::new(256, 192);
    let before = picture.mean_square_error(&picture.noisy);
    let plain = picture.mean_square_error(&run(&picture.input()));
    let guided = picture.mean_square_error(&run(&DenoiseInput {
        albedo: Some(&picture.albedo),
        normal: Some(&picture.normal),
        ..picture.input()
    }));
    println!("mean square error {before} plain {plain} guided {guided}");
    // Far from the edge: the filter is known to win two orders of magnitude on such noise.
    assert!(plain < before / 20.0, "{before} -> {plain}");
    assert!(guided < plain, "{plain} -> {guided}");
}

/// Fails if `cleanAux` does not reach the library, or if the guides are not filtered first.
#[test]
fn prefilter_helps_where_guides_are_noisy() {
    let picture = Picture::new(256, 192);
    let input = DenoiseInput {
        albedo: Some(&picture.noisy_albedo),
        normal: Some(&picture.normal),
        quality: DenoiseQuality::High,
        ..picture.input()
    };
    let raw = picture.mean_square_error(&run(&input));
    let prefiltered = picture.mean_square_error(&run(&DenoiseInput {
        prefilter: true,
        ..input
    }));
    println!("mean square error raw {raw} prefiltered {prefiltered}");
    assert!(prefiltered < raw, "{raw} -> {prefiltered}");
}

#[test]
fn broken_numbers_stay_where_they_are() {
    let mut picture = Picture::new(64, 64);
    let clean = picture.mean_square_error(&run(&picture.input()));
    picture.noisy[64 * 32 + 32] = Vec3::new(f32::NAN, f32::INFINITY, -1.0);
    picture.noisy[64 * 5 + 5] = Vec3::NAN;
    picture.albedo[9] = Vec3::NAN;
    picture.normal[9] = Vec3::INFINITY;
    let pixels = run(&DenoiseInput {
        albedo: Some(&picture.albedo),
        normal: Some(&picture.normal),
        prefilter: true,
        ..picture.input()
    });
    assert!(
        pixels
            .iter()
            .all(|pixel| pixel.is_finite() && pixel.min_element() >= 0.0)
    );
    // The row at the far side of the picture does not notice.
    let far = 64 * 60..64 * 64;
    let errors = pixels[far.clone()].iter().zip(&picture.truth[far]);
    let far = errors.map(|(a, b)| (*a - *b).length_squared() / 3.0).sum::<f32>() / 256.0;
    assert!(far < 10.0 * clean, "{far} {clean}");
}

#[test]
fn input_is_left_alone_and_equal_input_gives_equal_output() {
    let picture = Picture::new(96, 64);
    let before = (picture.noisy.clone(), picture.noisy_albedo.clone());
    let input = DenoiseInput {
        albedo: Some(&picture.noisy_albedo),
        prefilter: true,
        ..picture.input()
    };
    assert_eq!(run(&input), run(&input));
    assert_eq!(before, (picture.noisy.clone(), picture.noisy_albedo.clone()));
}

#[test]
fn cancels_before_and_while_it_runs() {
    let picture = Picture::new(1024, 768);
    let input = DenoiseInput {
        albedo: Some(&picture.albedo),
        normal: Some(&picture.normal),
        prefilter: true,
        quality: DenoiseQuality::High,
        threads: Some(1),
        ..picture.input()
    };
    assert_eq!(denoise(&input, &AtomicBool::new(true)), Err(DenoiseError::Cancelled));

    // All three filters take seconds on one thread of an ordinary machine; where they are done before, they are
    // cancelled sooner.
    let is_cancelled_after = |milliseconds: u64| {
        let cancel = AtomicBool::new(false);
        std::thread::scope(|scope| {
            let worker = scope.spawn(|| denoise(&input, &cancel));
            std::thread::sleep(Duration::from_millis(milliseconds));
            let asked = Instant::now();
            cancel.store(true, Ordering::Relaxed);
            let answer = worker.join().expect("no panic");
            println!("cancelled after {:?}", asked.elapsed());
            answer == Err(DenoiseError::Cancelled)
        })
    };
    assert!([300, 100, 30, 10, 3, 1, 0].into_iter().any(is_cancelled_after));
    // What was cancelled leaves nothing behind for the next one.
    let small = Picture::new(64, 64);
    run(&small.input());
}

#[test]
fn several_at_once() {
    let picture = Picture::new(96, 64);
    let alone = run(&picture.input());
    std::thread::scope(|scope| {
        let workers: Vec<_> = (0..3).map(|_| scope.spawn(|| run(&picture.input()))).collect();
        for worker in workers {
            assert_eq!(worker.join().expect("no panic"), alone);
        }
    });
}

#[test]
fn what_does_not_fit_is_refused() {
    let picture = Picture::new(32, 32);
    let flag = AtomicBool::new(false);
    let short = DenoiseInput {
        albedo: Some(&picture.albedo[1..]),
        ..picture.input()
    };
    assert_eq!(
        denoise(&short, &flag),
        Err(DenoiseError::WrongSize {
            what: "albedo",
            len: 1023,
            width: 32,
            height: 32
        })
    );
    let wide = DenoiseInput {
        width: 33,
        ..picture.input()
    };
    assert!(matches!(
        denoise(&wide, &flag),
        Err(DenoiseError::WrongSize { what: "color", .. })
    ));
    let normal_only = DenoiseInput {
        normal: Some(&picture.normal),
        ..picture.input()
    };
    assert_eq!(denoise(&normal_only, &flag), Err(DenoiseError::NormalWithoutAlbedo));
    let empty = DenoiseInput {
        width: 0,
        color: &[],
        ..picture.input()
    };
    assert_eq!(denoise(&empty, &flag), Ok(Vec::new()));
}
