//! The command-line options that override the file.

use bevy::prelude::*;
use sunroom::engine::{RenderControl, active_film};
use sunroom::scene::{
    ActiveSensor, Crop, Film as SensorFilm, IntegratorSettings, Medium, SamplerSettings, Strategy, find_camera,
};

use super::args::RenderArgs;
use crate::cli::picture_args::SizeArgs;
use crate::cli::report::{self, Failure};

/// Applies the command-line options that override the file.
pub fn apply_overrides(world: &mut World, args: &RenderArgs) -> Result<(), Failure> {
    let has_media = world.query::<&Medium>().iter(world).next().is_some();
    let mut integrator = world.resource_mut::<IntegratorSettings>();
    if let Some(depth) = args.max_depth {
        integrator.max_depth = u32::try_from(depth).ok();
    }
    if let Some(plugin) = args.integrator {
        integrator.plugin = plugin;
        if has_media && !plugin.traces_media() {
            let name = plugin.name();
            report::line(format_args!(
                "warning: `{name}` leaves out the media of the scene; `volpath` traces them"
            ));
        }
    }
    integrator.schlick |= args.schlick;
    integrator.clamp_percentile = args.clamp.or(integrator.clamp_percentile);
    integrator.guided |= args.guided;
    integrator.layers = args.aov.iter().fold(integrator.layers, |all, layers| all.and(*layers));
    integrator.strategy = args.strategy.unwrap_or(integrator.strategy);
    if args.guided
        && let Some(reason) = why_unguided(&integrator, has_media)
    {
        report::line(format_args!("warning: --guided has no effect {reason}"));
    }
    let mut sampler = world.resource_mut::<SamplerSettings>();
    sampler.seed = args.seed.unwrap_or(sampler.seed);
    sampler.sequence = args.sampler.unwrap_or(sampler.sequence);
    if args.adaptive {
        world.resource_mut::<RenderControl>().adaptive = Some(true);
    }
    if args.noise.is_some() {
        world.resource_mut::<RenderControl>().noise_target = args.noise;
    } else if args.spp.is_some() || args.time.is_some() || args.shares.is_given() {
        // The given limit replaces both limits of the file.
        world.resource_mut::<RenderControl>().noise_target = Some(0.0);
    }
    choose_camera(world, args.camera.as_deref())?;
    set_size(world, &args.size)
}

/// Chooses the camera of this name or index; None keeps the first.
pub fn choose_camera(world: &mut World, camera: Option<&str>) -> Result<(), Failure> {
    if let Some(camera) = camera {
        let camera = find_camera(world, camera).map_err(|error| Failure::Usage(error.to_string()))?;
        world.insert_resource(ActiveSensor(Some(camera)));
    }
    Ok(())
}

/// Sets the size of the picture: both sides, or one of which the other follows; without any it stays.
pub fn set_size(world: &mut World, size: &SizeArgs) -> Result<(), Failure> {
    let window = active_film(world).map(SensorFilm::window);
    let both = size.size.map(|(width, height)| [Some(width), Some(height)]);
    let sides = both.unwrap_or([size.width, size.height]);
    if let Some(Crop { width, height, .. }) = window
        && sides != [None; 2]
    {
        let scaled = |side: u32, to: u32, from: u32| (f64::from(side) * f64::from(to) / f64::from(from)).round() as u32;
        let size = UVec2::new(
            sides[0]
                .or_else(|| Some(scaled(width, sides[1]?, height)))
                .unwrap_or(width)
                .max(1),
            sides[1]
                .or_else(|| Some(scaled(height, sides[0]?, width)))
                .unwrap_or(height)
                .max(1),
        );
        if !SensorFilm::is_possible(size.x, size.y) {
            let most = SensorFilm::MOST_PIXELS;
            return Err(Failure::Usage(format!(
                "a film of {} x {} pixels is too large: at most {most} are possible",
                size.x, size.y
            )));
        }
        world.resource_mut::<RenderControl>().film_size_override = Some(size);
    }
    Ok(())
}

/// The reason why paths with these settings are not guided, as the end of a sentence; None if they are, or if `auto` is
/// still to decide.
fn why_unguided(integrator: &IntegratorSettings, has_media: bool) -> Option<String> {
    let name = integrator.plugin.name();
    match (integrator.max_depth, integrator.strategy) {
        _ if !integrator.plugin.is_guidable() => Some(format!("on `{name}`")),
        _ if has_media && integrator.plugin.traces_media() => Some(format!("on `{name}` where there are media")),
        (_, strategy @ (Strategy::Bsdf | Strategy::Light)) => {
            Some(format!("with the strategy `{}`, only with `mis`", strategy.name()))
        }
        (Some(..=2), _) => Some("on paths of at most 2 segments, which have direct light alone".to_owned()),
        _ => None,
    }
}
