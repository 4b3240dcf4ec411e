//! Cameras and their film.

use bevy::prelude::*;
use thiserror::Error;

use super::declare::{PluginInfo, declare_plugins};
use super::parameter_info::ParameterInfo;
use super::parameters::{Declared, ParameterMut, ParameterRef};
use crate::scene::{DocumentOrder, FilmStorage, FovAxis, ToWorld};

/// A camera; its pose is [`ToWorld`] (+z forward, +x left, +y up). Its scale is the extent of an orthographic picture,
/// and otherwise ignored.
#[derive(Component, Reflect, Clone, Copy, Debug, PartialEq)]
#[reflect(Component, PartialEq)]
#[require(ToWorld, Film, DocumentOrder)]
pub struct Sensor {
    /// The lens model.
    pub lens: Lens,
    /// The field of view in degrees, 0 to 180 exclusive, along `fov_axis`.
    pub fov: f32,
    /// The side of the picture along which `fov` is measured.
    pub fov_axis: FovAxis,
    /// The near clip distance along the view axis.
    pub near_clip: f32,
    /// The far clip distance along the view axis.
    pub far_clip: f32,
    /// The offset of the picture in the image plane, in parts of its width and height; right and down are positive.
    pub principal_point_offset: Vec2,
    /// The time at which the shutter opens, in seconds after the picture's time; motion while it is open is blurred.
    pub shutter_open: f32,
    /// The time at which the shutter closes in seconds, not before it opens.
    pub shutter_close: f32,
}

impl Default for Sensor {
    fn default() -> Self {
        Self {
            lens: Lens::Pinhole,
            fov: 39.3077,
            fov_axis: FovAxis::X,
            near_clip: 1e-2,
            far_clip: 1e4,
            principal_point_offset: Vec2::ZERO,
            shutter_open: 0.0,
            shutter_close: 0.0,
        }
    }
}

/// The kinds of cameras, by their plugins.
#[derive(Reflect, Clone, Copy, Debug, Default, PartialEq)]
pub enum Lens {
    /// `perspective`: the picture is sharp everywhere.
    #[default]
    Pinhole,
    /// `thinlens`: the picture is sharp in the plane at `focus_distance` along the view axis.
    Thin {
        /// World units; for a polygonal aperture, the radius of the circle through its corners.
        aperture_radius: f32,
        /// World units.
        focus_distance: f32,
        /// The number of edges of the aperture; below 3 it is round.
        blades: u32,
        /// Degrees, from +x to +y.
        blade_rotation: f32,
    },
    /// `orthographic`: the picture is two units of the sensor's space wide.
    Orthographic,
}

impl Lens {
    /// The lens that makes a view orthographic or not; None if this lens does already.
    pub fn for_projection(self, orthographic: bool) -> Option<Self> {
        let other = if orthographic {
            Self::Orthographic
        } else {
            Self::Pinhole
        };
        ((self == Self::Orthographic) != orthographic).then_some(other)
    }
}

/// The film of a sensor, and the number of samples that the file asks for.
#[derive(Component, Reflect, Clone, Copy, Debug, PartialEq)]
#[reflect(Component, PartialEq)]
pub struct Film {
    /// Pixels.
    pub width: u32,
    /// Pixels.
    pub height: u32,
    /// The part that is rendered; None for all of it.
    pub crop: Option<Crop>,
    /// The reconstruction filter.
    pub filter: ReconstructionFilter,
    /// The number of samples per pixel at which rendering stops.
    pub sample_count: u32,
    /// The format of picture files.
    pub storage: FilmStorage,
    /// The [relative noise](crate::render::noise) at which rendering stops, above 0; None is no limit. The limit that
    /// is reached first counts.
    pub noise_target: Option<f32>,
    /// Whether more samples go where the noise is, see [`crate::render::noise::adaptive`].
    pub adaptive: bool,
}

/// A rectangle of pixels of a film, (x, y) its top left.
#[derive(Reflect, Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Crop {
    /// The first column.
    pub x: u32,
    /// The first row.
    pub y: u32,
    /// The number of columns. Columns beyond the film are left out.
    pub width: u32,
    /// The number of rows. Rows beyond the film are left out.
    pub height: u32,
}

impl Film {
    /// The film of a file without film settings and sampler.
    pub fn of_format() -> Self {
        Self {
            sample_count: 4,
            ..Self::default()
        }
    }

    /// The pixels of the picture: the crop within the film, at least one pixel if there is a crop.
    pub fn window(&self) -> Crop {
        let Some(crop) = self.crop else {
            return Crop {
                x: 0,
                y: 0,
                width: self.width,
                height: self.height,
            };
        };
        let (x, y) = (
            crop.x.min(self.width.saturating_sub(1)),
            crop.y.min(self.height.saturating_sub(1)),
        );
        Crop {
            x,
            y,
            width: crop.width.max(1).min(self.width - x),
            height: crop.height.max(1).min(self.height - y),
        }
    }

    /// The most samples per pixel.
    pub(crate) const LARGEST_SAMPLE_COUNT: u32 = 1 << 30;
    /// The most pixels along one side.
    pub(crate) const LARGEST_SIDE: u32 = 65_536;
    /// The most pixels in all: sums and finished pictures of that size take 5 GB.
    pub const MOST_PIXELS: u64 = 1 << 26;

    /// Whether a film of this size in pixels is allowed.
    pub fn is_possible(width: u32, height: u32) -> bool {
        let sides = 1..=Self::LARGEST_SIDE;
        sides.contains(&width) && sides.contains(&height) && u64::from(width) * u64::from(height) <= Self::MOST_PIXELS
    }
}

impl Default for Film {
    fn default() -> Self {
        Self {
            width: 768,
            height: 576,
            crop: None,
            filter: ReconstructionFilter::default(),
            sample_count: 16,
            storage: FilmStorage::default(),
            noise_target: None,
            adaptive: false,
        }
    }
}

declare_plugins! {
    /// The weights of samples around a pixel's centre.
    #[derive(Reflect, Clone, Copy, Debug, PartialEq)]
    pub enum ReconstructionFilter {
        /// A constant weight over the pixel.
        [PluginInfo::new("box", "box")]
        Box,

        [PluginInfo::new("tent", "tent")]
        Tent { radius: f32 = 1.0 => Number(pixels("radius", "Radius", "The radius of the tent, in pixels.")) },

        /// A Gaussian, truncated at four standard deviations.
        [PluginInfo::new("gaussian", "gaussian")]
        Gaussian { stddev: f32 = 0.5 => Number(pixels("stddev", "Std. deviation", "The standard deviation of the Gaussian, in pixels.")) },

        /// Mitchell and Netravali's filter.
        [PluginInfo::new("mitchell", "mitchell")]
        Mitchell {
            b: f32 = 1.0 / 3.0 => Number(ParameterInfo::new("B", "B", "The blurring.", "-4 to 4").within(-4.0..=4.0)),
            c: f32 = 1.0 / 3.0 => Number(ParameterInfo::new("C", "C", "The ringing.", "-4 to 4").within(-4.0..=4.0)),
        },

        /// Mitchell and Netravali's filter with B = 0 and C = 1/2, which interpolates.
        [PluginInfo::new("catmullrom", "catmull-rom")]
        CatmullRom,

        /// A sinc in a sinc window.
        [PluginInfo::new("lanczos", "lanczos")]
        Lanczos {
            lobes: u32 = 3 => Count(
                ParameterInfo::new("lobes", "Lobes", "Half the width of the window in pixels.", "1 to 16").within(1.0..=16.0)
            ),
        },
    }
}

const fn pixels(name: &'static str, label: &'static str, about: &'static str) -> ParameterInfo {
    ParameterInfo::new(name, label, about, "pixels, above 0 and up to 16").within(f32::MIN_POSITIVE..=16.0)
}

impl Default for ReconstructionFilter {
    fn default() -> Self {
        Self::Gaussian { stddev: 0.5 }
    }
}

/// The cameras of the scene with their names, in the order of the file.
pub fn cameras(world: &mut World) -> Vec<(Entity, String)> {
    let mut query = world.query_filtered::<(Entity, &DocumentOrder, Option<&Name>), With<Sensor>>();
    let mut found: Vec<_> = query.iter(world).collect();
    found.sort_by_key(|&(entity, order, _)| (*order, entity));
    let named = |name: Option<&Name>| name.map_or("camera", |name| name.as_str()).to_owned();
    found
        .into_iter()
        .map(|(entity, _, name)| (entity, named(name)))
        .collect()
}

/// The camera with this name, or else with this index, from 0 in the order of the file.
pub fn find_camera(world: &mut World, wanted: &str) -> Result<Entity, NoSuchCamera> {
    let cameras = cameras(world);
    let by_name = cameras.iter().find(|(_, name)| name == wanted);
    let by_index = || wanted.parse().ok().and_then(|index: usize| cameras.get(index));
    match by_name.or_else(by_index) {
        Some(&(entity, _)) => Ok(entity),
        None => Err(NoSuchCamera {
            wanted: wanted.to_owned(),
            names: cameras.into_iter().map(|(_, name)| name).collect(),
        }),
    }
}

/// The reason why no camera was found; the message lists the known ones.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("there is no camera `{wanted}`; {}", known(names))]
pub struct NoSuchCamera {
    /// The requested name or index.
    pub wanted: String,
    /// The names of all cameras of the scene.
    pub names: Vec<String>,
}

fn known(names: &[String]) -> String {
    let numbered = names.iter().zip(0..).map(|(name, index)| format!("{index}: {name}"));
    match names {
        [] => "the scene has none".to_owned(),
        [only] => format!("the only one is `{only}`"),
        _ => format!("there are {}", numbered.collect::<Vec<String>>().join(", ")),
    }
}
