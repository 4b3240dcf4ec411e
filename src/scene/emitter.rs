//! Lights as the user knows them. Radiometric units; no photometry.

use std::path::PathBuf;

use bevy::math::Affine3A;
use bevy::prelude::*;

use super::emitter_parameters::{EmitterVisitor, POSITIVE};
use super::sun_sky::SunSky;
use super::{DocumentOrder, FovAxis, Parameter, SquarePath, Texture, ToWorld};
use crate::color::Rgb;

/// Makes a shape emit from its front, evenly in all directions.
#[derive(Component, Reflect, Clone, Debug, PartialEq)]
#[reflect(Component, PartialEq)]
pub struct AreaLight {
    /// W/(m^2 sr).
    pub radiance: Parameter<Rgb>,
    /// As that of [`Emitter`].
    pub sampling_weight: f32,
}

/// A light that is no surface; where and whereto is [`ToWorld`]. [`Emitter::visit`] lists the parameters with their names.
#[derive(Component, Reflect, Clone, Debug, PartialEq)]
#[reflect(Component, PartialEq)]
#[require(ToWorld, DocumentOrder)]
pub struct Emitter {
    /// The plugin with its parameters.
    pub kind: EmitterKind,
    /// Factor on how often it is chosen when light is looked for; 0 leaves it to be found by chance. The picture does not depend on it.
    pub sampling_weight: f32,
}

/// The kinds of lights that are no surfaces.
#[derive(Reflect, Clone, Debug, PartialEq)]
pub enum EmitterKind {
    /// Radiant intensity, W/sr.
    Point {
        /// Linear Rec. 709.
        intensity: Rgb,
    },
    /// Irradiance on a surface that faces the light, W/m^2.
    Directional {
        /// Linear Rec. 709.
        irradiance: Rgb,
    },
    /// The same radiance from every direction, W/(m^2 sr).
    Constant {
        /// Linear Rec. 709.
        radiance: Rgb,
    },
    /// `envmap`: a picture of all directions, `scale` times its radiance.
    Environment {
        /// Absolute path.
        picture: PathBuf,
        /// Not negative.
        scale: f32,
        /// Whether directions that surfaces find by themselves are sampled less.
        mis_compensation: bool,
    },
    /// Shines along +z.
    Spot {
        /// Along the axis, W/sr.
        intensity: Rgb,
        /// Angles from the axis in degrees: no light beyond the cutoff, all of it within the beam.
        cutoff_angle: f32,
        /// Half the angle of the full beam in degrees, at most `cutoff_angle`.
        beam_width: f32,
        /// Factor on the intensity, across the cone.
        texture: Option<Texture>,
    },
    /// Throws a picture along +z, as a camera would see it.
    Projector {
        /// Pi times that on the plane z = 1.
        irradiance: Parameter<Rgb>,
        /// Factor on the irradiance, not negative.
        scale: f32,
        /// As those of a [`super::Sensor`] whose film is the picture.
        fov: f32,
        /// Along which side of the picture `fov` is measured.
        fov_axis: FovAxis,
    },
    /// A clear sky with its sun.
    SunSky(SunSky),
}

impl Default for AreaLight {
    fn default() -> Self {
        Self {
            radiance: Rgb::ONE.into(),
            sampling_weight: 1.0,
        }
    }
}

impl Default for Emitter {
    fn default() -> Self {
        EmitterKind::Constant { radiance: Rgb::ONE }.into()
    }
}

impl From<EmitterKind> for Emitter {
    fn from(kind: EmitterKind) -> Self {
        Self {
            kind,
            sampling_weight: 1.0,
        }
    }
}

impl AreaLight {
    /// Shows `visitor` every parameter.
    pub(crate) fn visit(&mut self, visitor: &mut impl EmitterVisitor) {
        visitor.textured_emission("radiance", &mut self.radiance);
        visitor.sampling_weight(&mut self.sampling_weight);
    }
}

impl Emitter {
    /// The names of all plugins.
    pub const PLUGINS: [&'static str; 7] = [
        "point",
        "directional",
        "constant",
        "envmap",
        "spot",
        "projector",
        "sunsky",
    ];

    /// The light that a plugin of this name is when its file gives no parameter; None if there is no such plugin.
    pub fn of_plugin(plugin: &str) -> Option<Self> {
        let kind = match plugin {
            "point" => EmitterKind::Point { intensity: Rgb::ONE },
            "directional" => EmitterKind::Directional { irradiance: Rgb::ONE },
            "constant" => EmitterKind::Constant { radiance: Rgb::ONE },
            "envmap" => EmitterKind::Environment {
                picture: PathBuf::new(),
                scale: 1.0,
                mis_compensation: true,
            },
            "spot" => EmitterKind::Spot {
                intensity: Rgb::ONE,
                cutoff_angle: 20.0,
                beam_width: 15.0,
                texture: None,
            },
            "projector" => EmitterKind::Projector {
                irradiance: Rgb::ONE.into(),
                scale: 1.0,
                fov: 45.0,
                fov_axis: FovAxis::X,
            },
            "sunsky" => EmitterKind::SunSky(SunSky::default()),
            _ => return None,
        };
        Some(kind.into())
    }

    /// The plugin's name in the file.
    pub fn plugin(&self) -> &'static str {
        match self.kind {
            EmitterKind::Point { .. } => "point",
            EmitterKind::Directional { .. } => "directional",
            EmitterKind::Constant { .. } => "constant",
            EmitterKind::Environment { .. } => "envmap",
            EmitterKind::Spot { .. } => "spot",
            EmitterKind::Projector { .. } => "projector",
            EmitterKind::SunSky(_) => "sunsky",
        }
    }

    /// Shows `visitor` every parameter.
    pub(crate) fn visit(&mut self, visitor: &mut impl EmitterVisitor) {
        match &mut self.kind {
            EmitterKind::Point { intensity } => visitor.emission("intensity", intensity),
            EmitterKind::Directional { irradiance } => visitor.emission("irradiance", irradiance),
            EmitterKind::Constant { radiance } => visitor.emission("radiance", radiance),
            EmitterKind::Environment {
                picture,
                scale,
                mis_compensation,
            } => {
                visitor.picture("filename", picture);
                visitor.number("scale", scale, POSITIVE);
                visitor.flag("mis_compensation", mis_compensation);
            }
            EmitterKind::Spot {
                intensity,
                cutoff_angle,
                beam_width,
                texture,
            } => {
                visitor.emission("intensity", intensity);
                visitor.cone(cutoff_angle, beam_width);
                visitor.optional_texture("texture", texture);
            }
            EmitterKind::Projector {
                irradiance,
                scale,
                fov,
                fov_axis,
            } => {
                visitor.textured_emission("irradiance", irradiance);
                visitor.number("scale", scale, POSITIVE);
                visitor.field_of_view(fov, fov_axis);
            }
            EmitterKind::SunSky(sky) => sky.visit(visitor),
        }
        visitor.sampling_weight(&mut self.sampling_weight);
    }

    /// Shows `meet` every picture it needs, by absolute path.
    pub(crate) fn for_each_picture(&self, meet: &mut impl FnMut(&PathBuf)) {
        let texture = match &self.kind {
            EmitterKind::Environment { picture, .. } => return meet(picture),
            EmitterKind::Spot { texture, .. } => texture.as_ref(),
            EmitterKind::Projector {
                irradiance: Parameter::Texture(texture),
                ..
            } => Some(texture),
            _ => None,
        };
        if let Some(texture) = texture {
            texture.for_each_bitmap(&mut |bitmap| meet(&bitmap.path));
        }
    }

    /// The picture at `path` as whatever it has a picture for, or at a place within that; other lights stay.
    pub fn set_picture(&mut self, place: SquarePath, path: PathBuf) {
        match &mut self.kind {
            EmitterKind::Environment { picture, .. } => *picture = path,
            EmitterKind::Spot { texture, .. } => {
                let mut slide = match texture.take() {
                    Some(texture) => Parameter::Texture(texture),
                    None => Parameter::Constant(Rgb::ONE),
                };
                slide.set_picture_at(place, path);
                if let Parameter::Texture(slide) = slide {
                    *texture = Some(slide);
                }
            }
            EmitterKind::Projector { irradiance, .. } => irradiance.set_picture_at(place, path),
            _ => {}
        }
    }

    /// Whether it is infinitely far away in many directions: then only how it is turned matters of where it is.
    pub(crate) fn is_environment(&self) -> bool {
        matches!(self.kind, EmitterKind::Environment { .. } | EmitterKind::SunSky(_))
    }

    /// Whether it is somewhere, and not infinitely far away.
    pub(crate) fn has_place(&self) -> bool {
        !self.is_environment()
            && !matches!(
                self.kind,
                EmitterKind::Constant { .. } | EmitterKind::Directional { .. }
            )
    }
}

/// A frame whose +z is `direction` (not zero); which way its other axes turn does not matter, but is always the same.
pub(crate) fn frame_along(direction: Vec3) -> Affine3A {
    let forward = direction.normalize();
    let (left, up) = forward.any_orthonormal_pair();
    Affine3A::from_mat3(glam::Mat3::from_cols(left, up, forward))
}
