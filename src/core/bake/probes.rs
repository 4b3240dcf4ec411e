//! The probes of a bake: their placement, and the pictures made of their light.

use glam::{Affine3A, UVec3, Vec3};

use super::error::{BakeError, ProbeError};
use super::finish::add;
use super::lightmap::Lightmaps;
use super::placement::{around, check, check_sight, is_enclosed, seeing};
use super::prefilter::{Prefiltered, SIZES};
use super::progress::Work;
use super::reflection;
use super::texels::Texels;
use super::volume::Grid;
use crate::color::Rgb;
use crate::math::Aabb;
use crate::memory::{self, Reservation};
use crate::render::denoise::DenoiseError;
use crate::render::gathering::Gathering;
use crate::render::probe_radiance::Window;

/// The most bytes per texel while a probe is made: its position, its sums, and the pictures with their mip levels.
const TEXEL_BYTES: u64 = 320;
/// The samples of a volume for each sample of a lightmap texel.
const SAMPLES_OF_POINTS: u32 = 8;

/// The settings of probes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProbeSettings {
    /// The width of each side of a reflection probe, a power of two among [`super::prefilter::SIZES`].
    pub size: u32,
    /// The distance between the points of the volume around the level, if the scene has no volume; None gives about
    /// 4096 points.
    pub spacing: Option<f32>,
}

impl Default for ProbeSettings {
    fn default() -> Self {
        Self {
            size: 128,
            spacing: None,
        }
    }
}

/// A probe that a scene asks for.
#[derive(Clone, Debug, PartialEq)]
pub struct AskedProbe {
    /// Its name in the scene.
    pub name: String,
    /// The box, as the transform of a cube from -0.5 to 0.5.
    pub world_from_box: Affine3A,
    /// The kind of the probe.
    pub kind: AskedKind,
}

/// The kind of a probe in a scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum AskedKind {
    /// A cube map of the view from the centre of the box.
    Reflection {
        /// Whether reflections are corrected for parallax, as if the surroundings stood on the sides of the box.
        parallax: bool,
    },
    /// An irradiance volume: a grid of points in the box.
    Volume {
        /// The distance between points.
        spacing: f32,
    },
}

/// A probe that is to be baked.
#[derive(Clone, Debug, PartialEq)]
pub struct Probe {
    /// Its name.
    pub name: String,
    /// The box, as the transform of a cube from -0.5 to 0.5.
    pub world_from_box: Affine3A,
    /// The kind of the probe.
    pub kind: ProbeKind,
}

/// The kind of a probe that is to be baked.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ProbeKind {
    /// A cube map of the view from the centre of the box.
    Reflection {
        /// The width of each side in texels.
        size: u32,
        /// Whether reflections are corrected for parallax, as if the surroundings stood on the sides of the box.
        parallax: bool,
    },
    /// An irradiance volume: a grid of points in the box.
    Volume {
        /// Their number along each axis.
        points: UVec3,
    },
}

/// The texels at which the light of a probe is gathered.
pub(super) enum ProbeSites {
    Outlook(Texels<Window>),
    Points(Texels),
}

/// The finished textures of a probe.
#[derive(Clone, Debug, PartialEq)]
pub enum ProbePicture {
    /// The cube maps of a reflection probe.
    Reflection(Prefiltered),
    /// The texture of an irradiance volume.
    Volume {
        /// The number of samples of each side of a point.
        samples: u32,
        /// The size of the texture.
        size: UVec3,
        /// Its texels.
        texels: Vec<Rgb>,
    },
}

impl ProbePicture {
    /// Adds another layer of the same probe.
    pub(super) fn add(&mut self, more: &Self) {
        match (self, more) {
            (Self::Reflection(sum), Self::Reflection(more)) => {
                add(&mut sum.diffuse.texels, &more.diffuse.texels);
                for (sum, more) in sum.specular.iter_mut().zip(&more.specular) {
                    add(&mut sum.texels, &more.texels);
                }
            }
            (Self::Volume { texels: sum, .. }, Self::Volume { texels: more, .. }) => add(sum, more),
            (Self::Reflection(_), Self::Volume { .. }) | (Self::Volume { .. }, Self::Reflection(_)) => {}
        }
    }
}

impl AskedProbe {
    /// Checks, without tracing rays, the box and the number of points. `level` is None for a level without bounds.
    pub fn check(&self, level: Option<&Aabb>) -> Result<(), ProbeError> {
        let all = Aabb {
            min: Vec3::NEG_INFINITY,
            max: Vec3::INFINITY,
        };
        self.planned(*SIZES.start(), level.unwrap_or(&all)).map(drop)
    }

    /// The name of the probe in messages.
    pub fn title(&self) -> String {
        let plugin = match self.kind {
            AskedKind::Reflection { .. } => "reflectionprobe",
            AskedKind::Volume { .. } => "irradiancevolume",
        };
        format!("{plugin} `{}`", self.name)
    }

    /// The probe to be baked, if its box is possible. A reflection probe has faces of `size` texels.
    fn planned(&self, size: u32, level: &Aabb) -> Result<Probe, ProbeError> {
        check(&self.world_from_box, level)?;
        let kind = match self.kind {
            AskedKind::Reflection { parallax } => ProbeKind::Reflection { size, parallax },
            AskedKind::Volume { spacing } => ProbeKind::Volume {
                points: Grid::new(self.world_from_box, Some(spacing))?.points,
            },
        };
        Ok(Probe {
            name: self.name.clone(),
            world_from_box: self.world_from_box,
            kind,
        })
    }
}

impl Probe {
    /// The texels at which its light is gathered.
    pub(super) fn sites(&self) -> ProbeSites {
        match self.kind {
            ProbeKind::Reflection { size, .. } => ProbeSites::Outlook(reflection::outlook(&self.world_from_box, size)),
            ProbeKind::Volume { points } => ProbeSites::Points(self.grid(points).texels()),
        }
    }

    /// The number of places.
    pub(super) fn texel_count(&self) -> usize {
        match self.kind {
            ProbeKind::Reflection { size, .. } => 6 * (size * size) as usize,
            ProbeKind::Volume { points } => 6 * points.element_product() as usize,
        }
    }

    /// Its number of samples if lightmaps get `of_texels`. It is higher for volumes, which are not denoised.
    pub(super) fn samples(&self, of_texels: u32) -> u32 {
        match self.kind {
            ProbeKind::Reflection { .. } => of_texels,
            ProbeKind::Volume { .. } => of_texels.saturating_mul(SAMPLES_OF_POINTS),
        }
    }

    /// Bytes of memory while the probe is made: its texels, their sums, and the pictures.
    pub(super) fn memory_bytes(&self) -> u64 {
        self.texel_count() as u64 * TEXEL_BYTES
    }

    /// Makes the pictures of its light; None if the work was cancelled.
    pub(super) fn finished(
        &self,
        light: &Lightmaps,
        denoise: bool,
        work: &mut Work,
    ) -> Result<Option<ProbePicture>, DenoiseError> {
        match self.kind {
            ProbeKind::Reflection { size, .. } => {
                let pictures = reflection::finish(&self.world_from_box, size, light, denoise, work)?;
                Ok(pictures.map(ProbePicture::Reflection))
            }
            ProbeKind::Volume { points } => {
                let (size, texels) = self.grid(points).texture(light);
                let samples = light.samples();
                Ok(Some(ProbePicture::Volume { samples, size, texels }))
            }
        }
    }

    fn grid(&self, points: UVec3) -> Grid {
        Grid {
            world_from_box: self.world_from_box,
            points,
        }
    }
}

/// The probes that have a valid placement.
pub(super) struct Plan {
    /// Reflection probes, then irradiance volumes.
    pub probes: Vec<Probe>,
    /// The memory reserved for them.
    pub memory: Reservation,
    /// Sentences about impossible probes.
    pub warnings: Vec<String>,
}

/// The probes of the scene, and probes around the whole level for each kind that the scene lacks. The memory is
/// reserved before any ray is traced.
pub(super) fn plan(
    asked: &[AskedProbe],
    settings: &ProbeSettings,
    gathering: &Gathering,
    work: &mut Work,
) -> Result<Plan, BakeError> {
    let bounds = gathering.scene.geometry.bounds();
    let (mut reflections, mut volumes, mut warnings) = (Vec::new(), Vec::new(), Vec::new());
    for probe in asked {
        let planned = probe.planned(settings.size, &bounds);
        let planned = planned.map_err(|source| BakeError::Probe {
            name: probe.title(),
            source,
        })?;
        match planned.kind {
            ProbeKind::Reflection { .. } => reflections.push((probe, planned)),
            ProbeKind::Volume { .. } => volumes.push(planned),
        }
    }
    let around_level = around(&bounds);
    let of_level = |world_from_box, kind| Probe {
        name: "level".to_owned(),
        world_from_box,
        kind,
    };
    if let Some(world_from_level) = around_level.filter(|_| volumes.is_empty()) {
        let grid = Grid::new(world_from_level, settings.spacing).map_err(BakeError::Grid)?;
        volumes.push(of_level(world_from_level, ProbeKind::Volume { points: grid.points }));
    }
    let reflection_of = |parallax| ProbeKind::Reflection {
        size: settings.size,
        parallax,
    };
    let one_more = around_level.filter(|_| reflections.is_empty());
    let own = reflections.iter().map(|(_, probe)| probe).chain(&volumes);
    let bytes: u64 = own.map(Probe::memory_bytes).sum();
    let bytes_of_one_more = one_more.map_or(0, |place| of_level(place, reflection_of(true)).memory_bytes());
    let memory = memory::reserve(bytes + bytes_of_one_more)?;

    let mut probes = Vec::new();
    let count = reflections.len();
    for (number, (asked, probe)) in reflections.into_iter().enumerate() {
        (work.watch)(number as f64 / count as f64);
        let sight = work
            .pool
            .install(|| check_sight(gathering, &probe.world_from_box, work.cancel));
        sight.map_err(|error| BakeError::Probe {
            name: asked.title(),
            source: error.into(),
        })?;
        probes.push(probe);
    }
    if let Some(world_from_level) = one_more {
        (work.watch)(0.0);
        match work.pool.install(|| seeing(gathering, &world_from_level, work.cancel)) {
            Some(place) => probes.push(of_level(place, reflection_of(is_enclosed(gathering.scene, &place)))),
            None => warnings.push(
                "there is no reflection probe, because no place for it was found that is not inside of something"
                    .to_owned(),
            ),
        }
    }
    probes.append(&mut volumes);
    Ok(Plan {
        probes,
        memory,
        warnings,
    })
}
