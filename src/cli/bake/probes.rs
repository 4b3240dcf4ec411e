//! The probes of a bake: where they are, and their light.

use std::sync::atomic::AtomicBool;

use bevy::math::Affine3A;
use rayon::ThreadPool;
use sunroom::bake::finish::Denoising;
use sunroom::bake::gathering::Gathering;
use sunroom::bake::placement::{around, check, check_sight, is_enclosed, seeing};
use sunroom::bake::prefilter::Prefiltered;
use sunroom::bake::reflection;
use sunroom::bake::texels::Texels;
use sunroom::bake::volume::Grid;
use sunroom::color::Rgb;
use sunroom::render::irradiance::ReceivedLight;
use sunroom::scene::EmitterKind;
use sunroom::scene::description::EmitterDescription;

use super::args::BakeArgs;
use super::gathered::{Until, gathered};
use crate::cli::report::{self, Failure};

/// Nothing removes the noise of a volume: its points have so many samples for each one of a texel.
const SAMPLES_OF_POINTS: u32 = 8;

/// The probes that are to be baked.
#[derive(Default)]
pub struct Plan {
    reflections: Vec<Reflection>,
    volumes: Vec<Volume>,
}

struct Reflection {
    name: String,
    world_from_box: Affine3A,
    parallax: bool,
}

struct Volume {
    name: String,
    grid: Grid,
}

/// A reflection probe with its pictures.
pub struct BakedReflection {
    pub name: String,
    pub world_from_box: Affine3A,
    pub parallax: bool,
    pub pictures: Prefiltered,
}

/// An irradiance volume with its texture, of so many texels along each axis.
pub struct BakedVolume {
    pub name: String,
    pub grid: Grid,
    pub samples: u32,
    pub size: bevy::math::UVec3,
    pub texels: Vec<Rgb>,
}

/// All probes, finished.
#[derive(Default)]
pub struct Probes {
    pub reflections: Vec<BakedReflection>,
    pub volumes: Vec<BakedVolume>,
    /// The number of samples that were not finite.
    pub invalid: u64,
}

impl Plan {
    /// The probes of the scene, and those around the whole level where it has none of a kind.
    pub fn new(
        args: &BakeArgs,
        emitters: &[EmitterDescription],
        gathering: &Gathering,
        pool: &ThreadPool,
    ) -> Result<Self, Failure> {
        let mut plan = Self::default();
        if args.no_probes {
            return Ok(plan);
        }
        let bounds = gathering.scene.geometry.bounds();
        for about in emitters.iter().filter(|about| about.emitter.is_probe()) {
            let name = about.identity.name.to_string();
            // A cube from -1 to 1.
            let world_from_box = about.to_world * Affine3A::from_scale(bevy::math::Vec3::splat(2.0));
            let wrong = |error: &dyn std::fmt::Display| format!("{} `{name}`: {error}", about.emitter.plugin());
            check(&world_from_box, &bounds).map_err(|error| wrong(&error))?;
            match about.emitter.kind {
                EmitterKind::ReflectionProbe { parallax } => {
                    let sight = pool.install(|| check_sight(gathering, &world_from_box));
                    sight.map_err(|error| wrong(&error))?;
                    plan.reflections.push(Reflection {
                        name,
                        world_from_box,
                        parallax,
                    });
                }
                EmitterKind::IrradianceVolume { spacing } => {
                    let grid = Grid::new(world_from_box, Some(spacing)).map_err(|error| wrong(&error))?;
                    plan.volumes.push(Volume { name, grid });
                }
                _ => {}
            }
        }
        let Some(world_from_level) = around(&bounds) else {
            return Ok(plan);
        };
        if plan.reflections.is_empty() {
            match pool.install(|| seeing(gathering, &world_from_level)) {
                Some(world_from_box) => plan.reflections.push(Reflection {
                    name: "level".to_owned(),
                    world_from_box,
                    parallax: is_enclosed(gathering.scene, &world_from_box),
                }),
                None => report::line(format_args!(
                    "warning: there is no reflection probe, because no place for it was found that is not inside of something"
                )),
            }
        }
        if plan.volumes.is_empty() {
            plan.volumes.push(Volume {
                name: "level".to_owned(),
                grid: Grid::new(world_from_level, args.probe_spacing).map_err(|error| error.to_string())?,
            });
        }
        Ok(plan)
    }

    /// Gathers their light, with so many samples for a texel. What has none when `cancel` is set is left out.
    pub fn baked(
        &self,
        args: &BakeArgs,
        samples: u32,
        gathering: &Gathering,
        cancel: &AtomicBool,
        pool: &ThreadPool,
    ) -> Result<Probes, Failure> {
        let mut probes = Probes::default();
        let never = AtomicBool::new(false);
        let denoising = (!args.no_denoise).then_some(Denoising {
            threads: Some(pool.current_num_threads()),
            cancel: &never,
        });
        let until = |target: u32| Until {
            quiet: args.quiet,
            target,
            time: None,
            noise: None,
        };
        let say = |what: &str, name: &str, size: &dyn std::fmt::Display| {
            if !args.quiet {
                report::line(format_args!("{what} `{name}`, {size}"));
            }
        };
        for Reflection {
            name,
            world_from_box,
            parallax,
        } in &self.reflections
        {
            say("reflection probe", name, &format_args!("{0} x {0}", args.probe_size));
            let texels = reflection::outlook(world_from_box, args.probe_size);
            let light = gathered(&until(samples), gathering, &texels, cancel, pool);
            if light.samples == 0 {
                continue;
            }
            probes.invalid += light.invalid;
            let finish = || reflection::finish(world_from_box, &texels, &light, denoising);
            probes.reflections.push(BakedReflection {
                name: name.clone(),
                world_from_box: *world_from_box,
                parallax: *parallax,
                pictures: pool.install(finish)?,
            });
        }
        // Lights without extent, which the level brings along, light what moves themselves, with shadows.
        let gathering = Gathering {
            light: ReceivedLight::WithoutDelta,
            ..gathering.clone()
        };
        for Volume { name, grid } in &self.volumes {
            let [x, y, z] = grid.points.to_array();
            say("irradiance volume", name, &format_args!("{x} x {y} x {z} points"));
            let texels: Texels = grid.texels();
            let target = samples.saturating_mul(SAMPLES_OF_POINTS);
            let light = gathered(&until(target), &gathering, &texels, cancel, pool);
            if light.samples == 0 {
                continue;
            }
            probes.invalid += light.invalid;
            let (size, texels) = grid.texture(&light);
            probes.volumes.push(BakedVolume {
                name: name.clone(),
                grid: *grid,
                samples: light.samples,
                size,
                texels,
            });
        }
        Ok(probes)
    }
}
