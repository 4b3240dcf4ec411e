//! Materials: the bsdfs of the format with their own parameters, and the components that refer to them.

mod models;
mod principled;

use std::collections::HashMap;
use std::sync::LazyLock;

use bevy::math::Affine2;
use bevy::prelude::*;

use super::parameter_info::ParameterInfo;
use super::parameters::Declared;
use super::texture::{ChosenPicture, SquarePath, Texture};

pub use models::Material;
pub use principled::{Principled, PrincipledThin};

/// The material of every plugin with default parameters.
static USUAL: LazyLock<HashMap<&str, Material>> = LazyLock::new(|| {
    let made = |plugin| Some((plugin, Material::of_plugin(plugin)?));
    Material::PLUGINS.into_iter().filter_map(made).collect()
});

impl Material {
    /// The shared material of a plugin with default parameters; [`Material::of_plugin`] makes a new one.
    pub(crate) fn usual(plugin: &str) -> Option<&'static Self> {
        USUAL.get(plugin)
    }

    /// Whether it refracts, and so needs no `twosided`.
    pub fn refracts(&self) -> bool {
        match self {
            Self::Principled(principled) => principled.refracts(),
            other => other.info().refracts,
        }
    }

    /// Calls `meet` with every texture among the parameters.
    pub fn for_each_texture(&self, meet: &mut impl FnMut(&Texture)) {
        self.visit(&mut |info, value| {
            value.in_file(info, &mut |_, value| {
                if let Some(texture) = value.texture() {
                    meet(texture);
                }
            });
        });
    }

    /// Calls `meet` with the uv transform of every picture and checkerboard among the parameters, and with the
    /// declaration of the parameter.
    pub(crate) fn for_each_placing(&mut self, meet: &mut impl FnMut(&'static ParameterInfo, &mut Affine2)) {
        self.visit_mut(&mut |info, value| {
            value.for_each_texture(info, &mut |info, texture| {
                texture.for_each_placing(&mut |to_uv| meet(info, to_uv));
            });
        });
    }

    /// Sets the picture at a place of the parameter with this name. If it had no texture before, the picture is raw
    /// unless the parameter is a colour.
    pub fn set_picture(&mut self, parameter: &str, place: SquarePath, picture: &ChosenPicture) {
        self.visit_mut(&mut |info, value| value.set_picture(info, parameter, place, picture));
    }
}

/// A shape's material.
#[derive(Component, Reflect, Clone, Copy, Debug, PartialEq, Eq)]
#[reflect(Component, PartialEq)]
#[relationship(relationship_target = MaterialUsers)]
pub struct UsesMaterial(pub Entity);

/// The shapes that use a material.
#[derive(Component, Reflect, Clone, Debug, Default, PartialEq, Eq)]
#[relationship_target(relationship = UsesMaterial)]
pub struct MaterialUsers(Vec<Entity>);

/// The first nested material, such as the front of a two-sided one.
#[derive(Component, Reflect, Clone, Copy, Debug, PartialEq, Eq)]
#[reflect(Component, PartialEq)]
#[relationship(relationship_target = FirstNestedIn)]
pub struct FirstNested(pub Entity);

/// The materials that have this one as their first.
#[derive(Component, Reflect, Clone, Debug, Default, PartialEq, Eq)]
#[relationship_target(relationship = FirstNested)]
pub struct FirstNestedIn(Vec<Entity>);

/// The second nested material, such as the back of a two-sided one.
#[derive(Component, Reflect, Clone, Copy, Debug, PartialEq, Eq)]
#[reflect(Component, PartialEq)]
#[relationship(relationship_target = SecondNestedIn)]
pub struct SecondNested(pub Entity);

/// The materials that have this one as their second.
#[derive(Component, Reflect, Clone, Debug, Default, PartialEq, Eq)]
#[relationship_target(relationship = SecondNested)]
pub struct SecondNestedIn(Vec<Entity>);
