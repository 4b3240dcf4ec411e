//! The error of denoised pictures: with and without the features, beside the picture as sampled and beside one of four
//! times the samples.
//!
//! `cargo bench --bench denoising -- SCENE [REFERENCE.exr] ...` prints a row of docs/measurements.md for each scene:
//! the mean squared error, each error relative to the reference (Rousselle, Knaus and Zwicker, "Adaptive Sampling and
//! Reconstruction using Greedy Error Minimization", 2011). Without the EXR file of a reference the scene is rendered
//! with many samples of another seed. `SUNROOM_SCALE` scales the pictures' sides.

use std::error::Error;
use std::path::PathBuf;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

use sunroom::app::headless::render_only;
use sunroom::color::Rgb;
use sunroom::engine::{Limits, RenderControl, RenderFilm, load_to_completion, render_to_completion};
use sunroom::render::denoise::{DenoiseInput, DenoiseQuality, denoise};
use sunroom::render::film::Film;
use sunroom::scene::{OpenScene, SamplerSettings};

const SAMPLES: u32 = 16;
const REFERENCE_SAMPLES: u32 = 1024;

fn main() -> Result<(), Box<dyn Error>> {
    let words: Vec<String> = std::env::args()
        .skip(1)
        .filter(|word| !word.starts_with("--"))
        .collect();
    println!(
        "| scene | pixels | {SAMPLES} spp | {SAMPLES} spp, by colour alone | {SAMPLES} spp, by features | the same, quickly | 64 spp | seconds | seconds, quickly |"
    );
    println!("|---|---|---|---|---|---|---|---|---|");
    let mut words = words.into_iter().peekable();
    while let Some(scene) = words.next() {
        let reference = words.next_if(|next| next.ends_with(".exr"));
        row(&scene, reference.as_deref())?;
    }
    Ok(())
}

fn row(scene: &str, reference: Option<&str>) -> Result<(), Box<dyn Error>> {
    let film = rendered(scene, SAMPLES, 0)?;
    let raw = film.radiance();
    let exact = match reference {
        Some(path) => image::open(path)?
            .to_rgb32f()
            .pixels()
            .map(|pixel| Rgb::from_array(pixel.0))
            .collect(),
        None => rendered(scene, REFERENCE_SAMPLES, 1)?.radiance(),
    };
    if exact.len() != raw.len() {
        return Err(format!("{scene}: the reference has another size").into());
    }
    let (by_color, _) = denoised(&film, false, DenoiseQuality::High)?;
    let (by_features, seconds) = denoised(&film, true, DenoiseQuality::High)?;
    let (quick, quick_seconds) = denoised(&film, true, DenoiseQuality::Fast)?;
    let more = rendered(scene, 4 * SAMPLES, 0)?.radiance();
    let errors = [raw, by_color, by_features, quick, more].map(|picture| format!("{:.5}", error(&picture, &exact)));
    let name = PathBuf::from(scene)
        .file_stem()
        .unwrap_or_default()
        .display()
        .to_string();
    let size = format!("{} × {}", film.width(), film.height());
    println!(
        "| {name} | {size} | {} | {seconds:.2} | {quick_seconds:.2} |",
        errors.join(" | ")
    );
    Ok(())
}

fn rendered(scene: &str, samples: u32, seed: u32) -> Result<Film, Box<dyn Error>> {
    let request = OpenScene {
        path: PathBuf::from(scene),
        ..OpenScene::default()
    };
    let mut app = render_only(request, None);
    let limits = Limits {
        samples: Some(samples),
        ..Limits::default()
    };
    load_to_completion(&mut app, &limits)?;
    let scale = std::env::var("SUNROOM_SCALE").map_or(Ok(1.0), |text| text.parse())?;
    app.world_mut().resource_mut::<RenderControl>().resolution_scale = scale;
    app.world_mut().resource_mut::<SamplerSettings>().seed = seed;
    render_to_completion(&mut app, &limits, |_| {})?;
    Ok(app.world().resource::<RenderFilm>().film.clone())
}

/// The picture without noise, and the seconds that it took. In `Fast` quality the features are taken as they are, as
/// the window does.
fn denoised(film: &Film, by_features: bool, quality: DenoiseQuality) -> Result<(Vec<Rgb>, f32), Box<dyn Error>> {
    let (color, albedo, normal) = (film.radiance(), film.albedo(), film.normal());
    let input = DenoiseInput {
        width: film.width(),
        height: film.height(),
        color: &color,
        albedo: by_features.then_some(&albedo[..]),
        normal: by_features.then_some(&normal[..]),
        prefilter: by_features && quality != DenoiseQuality::Fast,
        quality,
        threads: None,
    };
    let started = Instant::now();
    let picture = denoise(&input, &AtomicBool::new(false))?;
    Ok((picture, started.elapsed().as_secs_f32()))
}

fn error(picture: &[Rgb], exact: &[Rgb]) -> f64 {
    let of_pixel = |(a, b): (&Rgb, &Rgb)| f64::from(((*a - *b) * (*a - *b) / (*b * *b + 0.01)).element_sum() / 3.0);
    picture.iter().zip(exact).map(of_pixel).sum::<f64>() / picture.len() as f64
}
