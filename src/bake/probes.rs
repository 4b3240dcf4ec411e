//! The probes of a bake: where they are, and what becomes of their light.

use glam::{Affine3A, UVec3};

use super::error::{BakeError, ProbeError};
use super::finish::Denoising;
use super::gathering::Gathering;
use super::lightmap::Lightmaps;
use super::placement::{around, check, check_sight, is_enclosed, seeing};
use super::prefilter::Prefiltered;
use super::reflection;
use super::texels::Texels;
use super::volume::Grid;
use crate::color::Rgb;
use crate::math::Aabb;
use crate::render::denoise::DenoiseError;
use crate::render::outlook::Window;

/// A volume has so many samples for each one of a texel.
const SAMPLES_OF_POINTS: u32 = 8;

/// How probes are made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProbeSettings {
    /// The width of each side of a reflection probe, a power of two among [`super::prefilter::SIZES`].
    pub size: u32,
    /// The distance of the points of the volume around the level, where the scene has none; None is one that gives about 4096 points.
    pub spacing: Option<f32>,
}

/// A probe that a scene asks for.
#[derive(Clone, Debug, PartialEq)]
pub struct AskedProbe {
    /// Its name in the scene.
    pub name: String,
    /// The place of the box, a cube from -0.5 to 0.5.
    pub world_from_box: Affine3A,
    /// What it is.
    pub kind: AskedKind,
}

/// What a scene asks for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum AskedKind {
    /// A picture of what is seen from the middle of the box.
    Reflection {
        /// Whether what is seen stands on the sides of the box.
        parallax: bool,
    },
    /// Points in the box.
    Volume {
        /// Their distance.
        spacing: f32,
    },
}

/// A probe that is to be baked.
#[derive(Clone, Debug, PartialEq)]
pub struct Probe {
    /// Its name.
    pub name: String,
    /// The place of the box, a cube from -0.5 to 0.5.
    pub world_from_box: Affine3A,
    /// What it is.
    pub kind: ProbeKind,
}

/// The kinds of probes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ProbeKind {
    /// A picture of what is seen from the middle of the box.
    Reflection {
        /// The width of each side in texels.
        size: u32,
        /// Whether what is seen stands on the sides of the box.
        parallax: bool,
    },
    /// Points in the box.
    Volume {
        /// Their number along each axis.
        points: UVec3,
    },
}

/// The places that the light of a probe is gathered at.
pub(super) enum ProbeSites {
    Outlook(Texels<Window>),
    Points(Texels),
}

/// What has been made of a probe.
#[derive(Clone, Debug, PartialEq)]
pub enum ProbePicture {
    /// The pictures of a reflection probe.
    Reflection(Prefiltered),
    /// The texture of a volume.
    Volume {
        /// The samples of each side of a point.
        samples: u32,
        /// The size of the texture.
        size: UVec3,
        /// Its texels.
        texels: Vec<Rgb>,
    },
}

impl AskedProbe {
    /// The probe, if its box can be.
    fn planned(&self, settings: &ProbeSettings, level: &Aabb) -> Result<Probe, ProbeError> {
        check(&self.world_from_box, level)?;
        let kind = match self.kind {
            AskedKind::Reflection { parallax } => ProbeKind::Reflection {
                size: settings.size,
                parallax,
            },
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
    /// The places that its light is gathered at.
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

    /// Its samples where a lightmap has so many. Nothing removes the noise of a volume.
    pub(super) fn samples(&self, of_texels: u32) -> u32 {
        match self.kind {
            ProbeKind::Reflection { .. } => of_texels,
            ProbeKind::Volume { .. } => of_texels.saturating_mul(SAMPLES_OF_POINTS),
        }
    }

    /// Makes its pictures of the light.
    pub(super) fn finished(
        &self,
        light: &Lightmaps,
        denoising: Option<Denoising>,
    ) -> Result<ProbePicture, DenoiseError> {
        match self.kind {
            ProbeKind::Reflection { size, .. } => {
                let pictures = reflection::finish(&self.world_from_box, size, light, denoising)?;
                Ok(ProbePicture::Reflection(pictures))
            }
            ProbeKind::Volume { points } => {
                let (size, texels) = self.grid(points).texture(light);
                let samples = light.samples();
                Ok(ProbePicture::Volume { samples, size, texels })
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

/// The probes of the scene, and those around the whole level where it has none of a kind. `warnings` gets a sentence where there can be none.
pub(super) fn plan(
    asked: &[AskedProbe],
    settings: &ProbeSettings,
    gathering: &Gathering,
    warnings: &mut Vec<String>,
) -> Result<Vec<Probe>, BakeError> {
    let bounds = gathering.scene.geometry.bounds();
    let (mut reflections, mut volumes) = (Vec::new(), Vec::new());
    for probe in asked {
        let (plugin, list) = match probe.kind {
            AskedKind::Reflection { .. } => ("reflectionprobe", &mut reflections),
            AskedKind::Volume { .. } => ("irradiancevolume", &mut volumes),
        };
        let failed = |source: ProbeError| BakeError::Probe {
            name: format!("{plugin} `{}`", probe.name),
            source,
        };
        let planned = probe.planned(settings, &bounds).map_err(failed)?;
        if let ProbeKind::Reflection { .. } = planned.kind {
            check_sight(gathering, &planned.world_from_box).map_err(|error| failed(error.into()))?;
        }
        list.push(planned);
    }
    if let Some(world_from_level) = around(&bounds) {
        let name = || "level".to_owned();
        if reflections.is_empty() {
            match seeing(gathering, &world_from_level) {
                Some(world_from_box) => reflections.push(Probe {
                    name: name(),
                    world_from_box,
                    kind: ProbeKind::Reflection {
                        size: settings.size,
                        parallax: is_enclosed(gathering.scene, &world_from_box),
                    },
                }),
                None => warnings.push(
                    "there is no reflection probe, because no place for it was found that is not inside of something"
                        .to_owned(),
                ),
            }
        }
        if volumes.is_empty() {
            let grid = Grid::new(world_from_level, settings.spacing).map_err(BakeError::Grid)?;
            volumes.push(Probe {
                name: name(),
                world_from_box: world_from_level,
                kind: ProbeKind::Volume { points: grid.points },
            });
        }
    }
    reflections.append(&mut volumes);
    Ok(reflections)
}
