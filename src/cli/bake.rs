//! `sunroom bake`: from a scene file to a level with lightmaps.

mod args;
mod files;
mod gathered;
mod probes;

use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use bevy::math::Vec3;
use bevy::prelude::App;
use rayon::ThreadPool;
use sunroom::app::headless::render_only;
use sunroom::app::threads::worker_count;
use sunroom::bake::finish::{Denoising, LightmapPicture, finish};
use sunroom::bake::gathering::Gathering;
use sunroom::bake::level::{BakeLevel, unwrap_level};
use sunroom::bake::lightmap::Lightmaps;
use sunroom::bake::manifest::BakedLight;
use sunroom::bake::seams::{Seam, smooth_seams};
use sunroom::bake::sides::lit_sides;
use sunroom::bake::texels::{Texels, covered_texels};
use sunroom::bake::unwrap::UnwrapSettings;
use sunroom::document::paths::settle;
use sunroom::engine::{Limits, PackedScene, RenderState, RenderStatus, load_to_completion};
use sunroom::gltf::write::GltfWriter;
use sunroom::render::denoise::DenoiseError;
use sunroom::render::irradiance::ReceivedLight;
use sunroom::render::scene::RenderScene;
use sunroom::render::view::View;
use sunroom::scene::assets::scene_asset::load_document;
use sunroom::scene::description::EmitterDescription;
use sunroom::scene::export::{Baked, Collected, ExportError, Hidden, collect, first_in_use};
use sunroom::scene::{OpenScene, SceneStatus, read};

pub use self::args::BakeArgs;

use self::gathered::{Until, gathered};
use self::probes::Plan;

use super::check::{has_only_warnings, report_left_out, report_scene};
use super::ending::INTERRUPTED;
use super::render::cancel_on_interrupt;
use super::report::{self, Failure, counted};

/// The samples of each texel where no limit is given.
const SAMPLES: u32 = 64;

pub fn run(args: BakeArgs) -> ExitCode {
    args.memory.apply();
    args.threads.report_limit();
    match bake(&args) {
        Ok(code) => code,
        Err(failure) => failure.report(),
    }
}

fn bake(args: &BakeArgs) -> Result<ExitCode, Failure> {
    if !args.no_denoise && !cfg!(feature = "denoise") {
        return Err(Failure::Usage(format!(
            "{}; --no-denoise bakes without it",
            DenoiseError::NotBuilt
        )));
    }
    let is_new = !args.output.exists();
    files::prepare(&args.output)?;
    let result = bake_into(args);
    // Nothing is left of a bake that has failed.
    if is_new && !matches!(result, Ok(ExitCode::SUCCESS)) {
        let _ = std::fs::remove_dir(&args.output);
    }
    result
}

/// Bakes into a folder that is there.
fn bake_into(args: &BakeArgs) -> Result<ExitCode, Failure> {
    let cancel = cancel_on_interrupt()?;
    let Some((scene, mut view)) = packed(args, &cancel)? else {
        return Ok(ExitCode::FAILURE);
    };
    let Some(Authored { mut writer, emitters }) = collected(args)? else {
        return Ok(ExitCode::FAILURE);
    };
    if let Some(seed) = args.seed {
        view.seed = seed;
    }
    let gathering = Gathering {
        scene: &scene,
        view: &view,
        light: match args.indirect_only {
            true => ReceivedLight::WithoutDelta,
            false => ReceivedLight::All,
        },
    };
    let threads = worker_count(args.threads.threads, false).get();
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build()?;
    let plan = Plan::new(args, &emitters, &gathering, &pool)?;
    let settings = UnwrapSettings {
        atlas_size: args.atlas_size,
        texels_per_unit: args.texels_per_unit,
        ..UnwrapSettings::default()
    };
    let lit = |triangles: &[[Vec3; 3]]| lit_sides(&gathering, triangles);
    let level = pool.install(|| unwrap_level(&mut writer, &settings, lit))?;
    let texels = covered_texels(&level.surfaces, level.size, level.pages);
    if texels.texels.is_empty() {
        return Err("no surface is large enough for a texel: take more texels per unit".into());
    }
    if !args.quiet {
        report::line(format_args!(
            "{} in {} of {} x {}, {:.4} texels per unit, {}",
            counted(level.nodes.len(), "shape"),
            counted(level.pages, "lightmap"),
            level.size.x,
            level.size.y,
            level.texels_per_unit,
            counted(texels.texels.len(), "texel"),
        ));
    }
    let light = lightmaps(args, &gathering, &texels, &cancel, &pool)?;
    let pictures = finished(args, &level, &texels, &light, threads)?;
    // The limits of time and noise are those of lightmaps.
    let samples = args.spp.unwrap_or(SAMPLES);
    let probes = plan.baked(args, samples, &gathering, &cancel, &pool)?;
    let about = files::About {
        light: match args.indirect_only {
            true => BakedLight::WithoutDirectPunctual,
            false => BakedLight::All,
        },
        samples: light.samples,
        seed: view.seed,
        denoised: !args.no_denoise,
    };
    files::write(&args.output, writer, &level, &pictures, &probes, &about)?;
    let invalid = light.invalid + probes.invalid;
    if invalid > 0 {
        let samples = counted(invalid, "sample");
        report::line(format_args!("warning: {samples} not finite, which count as black"));
    }
    let place = args.output.display();
    if cancel.load(Ordering::Relaxed) {
        let samples = counted(light.samples, "sample");
        report::error(format_args!(
            "interrupted; the lightmaps in {place} have {samples} per texel, and probes without any are left out"
        ));
        return Ok(ExitCode::from(INTERRUPTED));
    }
    if !args.quiet {
        report::line(format_args!("the level is in {place}"));
    }
    Ok(ExitCode::SUCCESS)
}

/// The scene as it is rendered; None if it is refused, which has been reported.
fn packed(args: &BakeArgs, cancel: &Arc<AtomicBool>) -> Result<Option<(RenderScene, View)>, Failure> {
    let trust = args.trust.trust(&args.scene.scene)?;
    let open = OpenScene {
        path: args.scene.scene.clone(),
        defines: args.scene.defines.defines.clone(),
        ..OpenScene::default()
    };
    let mut app: App = render_only(open, args.threads.threads);
    app.insert_resource(trust);
    let limits = Limits {
        cancel: cancel.clone(),
        ..Limits::default()
    };
    let loaded = load_to_completion(&mut app, &limits);
    let status = app.world().resource::<SceneStatus>();
    if !report_scene(status, args.strict) {
        if has_only_warnings(status) {
            report::refused_for_warnings(&args.scene.scene);
        }
        return Ok(None);
    }
    if !loaded? {
        return Err("interrupted while the scene was being loaded: nothing is written".into());
    }
    let engine = app.world().resource::<RenderStatus>();
    if engine.state != RenderState::Failed && !report_left_out(engine, &args.scene.scene, args.strict) {
        if engine.shortages.is_empty() {
            report::refused_for_warnings(&args.scene.scene);
        }
        return Ok(None);
    }
    let packed = app.world().resource::<PackedScene>();
    match (packed.scene.clone(), packed.view.clone()) {
        (Some(scene), Some(view)) => Ok(Some((scene, view))),
        _ => Err(format!("{}: there is nothing to bake", args.scene.scene.display()).into()),
    }
}

/// The scene as it is in its file.
struct Authored {
    /// The scene as a glTF file that is being made.
    writer: GltfWriter,
    /// The lights that are no surfaces, and the probes.
    emitters: Vec<EmitterDescription>,
}

/// The scene as it is in its file; None if it is refused, which has been reported. Messages about the scene itself have been printed when it was loaded.
fn collected(args: &BakeArgs) -> Result<Option<Authored>, Failure> {
    let path = settle(&args.scene.scene);
    let access = args.trust.trust(&args.scene.scene)?.access(&path);
    let mut document = load_document(&path, &args.scene.defines.defines, access)?;
    let scene = read::read(&mut document);
    let baked = match args.indirect_only {
        true => Baked::Skies,
        false => Baked::All,
    };
    let Collected {
        writer,
        messages,
        pictures_of_libraries,
    } = collect(&scene, &Hidden::default(), baked, &document.access)?;
    let replaced = files::replaceable(&args.output);
    if let Some(path) = first_in_use(&scene, &pictures_of_libraries, replaced.iter().map(PathBuf::as_path)) {
        let path = path.to_owned();
        return Err(ExportError::InUse { path }.into());
    }
    for message in &messages {
        report::line(format_args!("warning: {message}"));
    }
    if args.strict && !messages.is_empty() {
        report::refused_for_warnings(&args.scene.scene);
        return Ok(None);
    }
    Ok(Some(Authored {
        writer,
        emitters: scene.emitters,
    }))
}

/// Gathers the light of the lightmaps.
fn lightmaps(
    args: &BakeArgs,
    gathering: &Gathering,
    texels: &Texels,
    cancel: &AtomicBool,
    pool: &ThreadPool,
) -> Result<Lightmaps, Failure> {
    let is_open = args.time.is_some() || args.noise.is_some();
    let until = Until {
        quiet: args.quiet,
        target: args.spp.unwrap_or(if is_open { u32::MAX } else { SAMPLES }),
        time: args.time,
        noise: args.noise,
    };
    let light = gathered(&until, gathering, texels, cancel, pool);
    if light.samples == 0 {
        return Err("interrupted before the first samples: nothing is written".into());
    }
    Ok(light)
}

/// The pictures of all lightmaps.
fn finished(
    args: &BakeArgs,
    level: &BakeLevel,
    texels: &Texels,
    light: &Lightmaps,
    threads: usize,
) -> Result<Vec<LightmapPicture>, DenoiseError> {
    let mut seams: Vec<Vec<Seam>> = vec![Vec::new(); level.pages as usize];
    for surface in &level.surfaces {
        seams[surface.page as usize].extend(smooth_seams(surface));
    }
    // An interrupt has ended the gathering of light; what there is shall be written.
    let never = AtomicBool::new(false);
    let denoising = (!args.no_denoise).then_some(Denoising {
        threads: Some(threads),
        cancel: &never,
    });
    let pages = seams.iter().enumerate();
    pages
        .map(|(page, seams)| finish(texels, page, light, seams, denoising))
        .collect()
}
