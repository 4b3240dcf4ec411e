//! Renders scenes, and measures their time and noise.
//!
//! Every round renders two seeds. With a and b their pictures and r the mean of all pictures of the scene, the noise is
//! mean((a - b)^2 / 2 / (r^2 + 0.01)) over pixels and channels: the relative variance, free of a reference's own error.

use std::path::{Path, PathBuf};

use sunroom::app::headless::render_only;
use sunroom::color::Rgb;
use sunroom::engine::{Limits, RenderFilm, RenderStatus, load_to_completion, render_to_completion};
use sunroom::scene::export::ExportError;
use sunroom::scene::{OpenScene, SamplerSettings, SceneStatus};

use super::args::RenderBenchArgs;
use super::compare;
use super::results::{Error, RenderResult, Results, median};
use crate::cli::check::report_scene;
use crate::cli::outputs::check_scene_stays;
use crate::cli::report;

/// Limits the relative noise of nearly black pixels.
const DARK: f64 = 0.01;
const SCENES: &str = "scenes";

/// The scenes that will be measured.
pub struct Plan<'a> {
    args: &'a RenderBenchArgs,
    scenes: Vec<PathBuf>,
}

impl<'a> Plan<'a> {
    /// An error if a scene is missing.
    pub fn new(args: &'a RenderBenchArgs) -> Result<Self, Error> {
        let scenes = match args.scenes.is_empty() {
            true => all_scenes(Path::new(SCENES))?,
            false => args.scenes.clone(),
        };
        match scenes.iter().find(|scene| !scene.is_file()) {
            Some(missing) => Err(format!("{}: there is no such file", missing.display()).into()),
            None => Ok(Self { args, scenes }),
        }
    }

    pub fn scenes(&self) -> &[PathBuf] {
        &self.scenes
    }

    pub fn subjects(&self) -> Vec<compare::Subject> {
        let scenes = self.scenes.iter().cloned();
        scenes
            .map(|scene| compare::Subject::Render {
                scene,
                size: self.args.size,
                spp: self.args.spp,
            })
            .collect()
    }

    pub fn measure(&self) -> Result<Results, Error> {
        let common = &self.args.common;
        let threads = sunroom::app::threads::worker_count(common.threads.threads, false).get();
        let mut results = Results::new(threads, common.rounds);
        for scene in &self.scenes {
            report::line(format_args!("{} ...", scene.display()));
            match measure_scene(scene, self.args) {
                Ok(result) => results.renders.push(result),
                // In a folder, scenes that cannot be rendered are skipped. A scene named by the user must exist, and
                // none is overwritten.
                Err(error) if self.args.scenes.is_empty() && !error.is::<ExportError>() => {
                    report::line(format_args!("  left out: {error}"))
                }
                Err(error) => return Err(error),
            }
        }
        Ok(results)
    }
}

fn all_scenes(folder: &Path) -> Result<Vec<PathBuf>, Error> {
    let entries = std::fs::read_dir(folder)
        .map_err(|error| format!("no scenes are named, and the folder `{}`: {error}", folder.display()))?;
    let mut scenes: Vec<PathBuf> = entries
        .filter_map(|entry| Some(entry.ok()?.path()))
        .filter(|path| path.extension().is_some_and(|extension| extension == "xml"))
        .collect();
    scenes.sort();
    Ok(scenes)
}

/// One picture with its measurements.
struct Render {
    pixels: Vec<Rgb>,
    seconds: f64,
    cpu_seconds: Option<f64>,
    mrays_per_s: f64,
}

fn measure_scene(scene: &Path, args: &RenderBenchArgs) -> Result<RenderResult, Error> {
    let renders = (1..=2 * args.common.rounds)
        .map(|seed| render(scene, seed, args))
        .collect::<Result<Vec<_>, _>>()?;
    let of = |figure: fn(&Render) -> f64| median(renders.iter().map(figure));
    let reference = mean(&renders);
    let noise = renders
        .chunks_exact(2)
        .map(|pair| relative_variance(&pair[0].pixels, &pair[1].pixels, &reference));
    let (seconds, rel_mse) = (of(|render| render.seconds), median(noise));
    let cpu: Vec<f64> = renders.iter().filter_map(|render| render.cpu_seconds).collect();
    Ok(RenderResult {
        scene: scene.to_string_lossy().into_owned(),
        width: args.size.0,
        height: args.size.1,
        spp: args.spp,
        seconds,
        cpu_seconds: (!cpu.is_empty()).then(|| median(cpu)),
        msamples_per_s: f64::from(args.size.0) * f64::from(args.size.1) * f64::from(args.spp) / seconds / 1e6,
        mrays_per_s: of(|render| render.mrays_per_s),
        rel_mse,
        cost: rel_mse * seconds,
    })
}

fn render(scene: &Path, seed: u32, args: &RenderBenchArgs) -> Result<Render, Error> {
    let begin = cpu_seconds();
    let open = OpenScene {
        path: scene.to_owned(),
        defines: Vec::new(),
        ..OpenScene::default()
    };
    let mut app = render_only(open, args.common.threads.threads);
    let limits = Limits {
        samples: Some(args.spp),
        ..Limits::default()
    };
    let loaded = load_to_completion(&mut app, &limits);
    if loaded.is_err() || !app.world().resource::<SceneStatus>().mesh_errors.is_empty() {
        report_scene(app.world().resource::<SceneStatus>(), false);
        return Err(format!("{} could not be loaded", scene.display()).into());
    }
    check_scene_stays(&args.common.json)?;
    app.world_mut().resource_mut::<SamplerSettings>().seed = seed;
    let mut control = app.world_mut().resource_mut::<sunroom::engine::RenderControl>();
    control.film_size_override = Some(args.size.into());
    render_to_completion(&mut app, &limits, |_| {})?;
    let status = app.world().resource::<RenderStatus>();
    Ok(Render {
        pixels: app.world().resource::<RenderFilm>().film.radiance(),
        seconds: status.seconds,
        cpu_seconds: cpu_seconds().zip(begin).map(|(end, begin)| end - begin),
        mrays_per_s: status.mrays_per_s,
    })
}

fn mean(renders: &[Render]) -> Vec<Rgb> {
    let mut sum = vec![Rgb::ZERO; renders[0].pixels.len()];
    for render in renders {
        for (sum, pixel) in sum.iter_mut().zip(&render.pixels) {
            *sum += *pixel / renders.len() as f32;
        }
    }
    sum
}

fn relative_variance(a: &[Rgb], b: &[Rgb], reference: &[Rgb]) -> f64 {
    let channels = |pixels: &[Rgb]| -> Vec<f64> {
        let values = pixels.iter().flat_map(|pixel| pixel.to_array());
        values.map(f64::from).collect()
    };
    let (a, b, reference) = (channels(a), channels(b), channels(reference));
    let count = reference.len().max(1) as f64;
    let terms = a.iter().zip(&b).zip(&reference);
    let sum: f64 = terms
        .map(|((a, b), mean)| (a - b) * (a - b) / 2.0 / (mean * mean + DARK))
        .sum();
    sum / count
}

/// The processor time of this process so far in seconds, which Linux counts in hundredths.
fn cpu_seconds() -> Option<f64> {
    const TICKS_PER_SECOND: f64 = 100.0;
    let status = std::fs::read_to_string("/proc/self/stat").ok()?;
    // The program's name, which may contain blanks, comes before the bracket.
    let fields: Vec<&str> = status.rsplit_once(')')?.1.split_whitespace().collect();
    let ticks = |field: usize| fields.get(field)?.parse::<f64>().ok();
    Some((ticks(11)? + ticks(12)?) / TICKS_PER_SECOND)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_noise_of_a_known_difference() {
        // (0.2)^2 / 2 / (1 + 0.01) in each channel.
        let (a, b) = ([Rgb::splat(1.1)], [Rgb::splat(0.9)]);
        let noise = relative_variance(&a, &b, &[Rgb::ONE]);
        assert!((noise - 0.02 / 1.01).abs() < 1e-7, "{noise}");
        assert_eq!(relative_variance(&a, &a, &a), 0.0);
    }
}
