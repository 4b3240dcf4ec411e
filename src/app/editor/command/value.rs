//! Edits that set one component of a thing. They can be applied to the whole selection.

use bevy::math::Affine3A;
use bevy::prelude::Entity;

use super::lamps::PhotometricValue;
use super::traits::Traits;
use crate::scene::{AreaLight, Emitter, EulerAngles, Film, Material, Medium, Sensor, Shape};

/// An edit that sets one component of a thing.
#[derive(Clone, Debug, PartialEq)]
pub enum ValueEdit {
    /// Sets the poses of several things, each as world from a space whose origin is the thing's position: its own
    /// space, except for shapes such as spheres, whose centre may be elsewhere in it.
    Transform(Vec<(Entity, Affine3A)>),
    /// Sets the pose of a thing as [`Self::Transform`] does, with the Euler angles of its rotation.
    Turn(Entity, Affine3A, EulerAngles),
    /// Sets the geometry of a shape.
    SetShape(Entity, Shape),
    /// Sets the parameters of a material; the materials nested in it stay.
    SetMaterial(Entity, Box<Material>),
    /// Sets the parameters of a medium.
    SetMedium(Entity, Box<Medium>),
    /// Sets the emission of a shape; None for a shape that does not emit.
    SetAreaLight(Entity, Option<AreaLight>),
    /// Sets kind and parameters of a light that is no shape.
    SetEmitter(Entity, Emitter),
    /// Sets the strength of a light, as the edit inside does. Other selected lights get the same amount in its unit,
    /// each by its own size and shape: lumens all that have any, other units those with the parameter of this name.
    Shine(Box<ValueEdit>, &'static str, PhotometricValue),
    /// Sets the lens and field of view of a camera.
    SetSensor(Entity, Sensor),
    /// Sets size, crop, filter and samples of a camera.
    SetFilm(Entity, Film),
}

impl ValueEdit {
    pub(super) fn traits(&self) -> Traits {
        match self {
            Self::Transform(poses) => {
                let things: Vec<Entity> = poses.iter().map(|(thing, _)| *thing).collect();
                Traits::drag("Move").of(&things)
            }
            Self::Turn(thing, ..) => Traits::drag("Move").of(&[*thing]),
            Self::SetShape(shape, _) => Traits::drag("Edit shape").of(&[*shape]),
            Self::SetMaterial(material, _) => Traits::drag("Edit material").of(&[*material]),
            Self::SetMedium(medium, _) => Traits::drag("Edit medium").of(&[*medium]),
            // Carried-over pixels are multiplied by the light's change of strength.
            Self::SetAreaLight(light, _) | Self::SetEmitter(light, _) => {
                Traits::drag("Edit light").of(&[*light]).scaling_picture()
            }
            Self::Shine(edit, ..) => edit.traits(),
            Self::SetSensor(camera, _) => Traits::drag("Edit camera").of(&[*camera]),
            Self::SetFilm(camera, _) => Traits::drag("Edit film").of(&[*camera]),
        }
    }
}
