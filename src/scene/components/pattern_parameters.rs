//! The plugins of procedural textures and their parameters, from the declaration in [`super::pattern`].

use bevy::math::Affine2;

use super::declare::{PluginInfo, declare_plugin_parameters};
use super::parameter_info::ParameterInfo;
use super::parameters::{Declared, ParameterMut, ParameterRef};
use super::pattern::{Choice, HIGH, LOW, default_stops, with_patterns};
use super::texture::{Parameter, Pattern, Texture};
use super::texture_parameters::TO_UV;
use crate::color::Rgb;

with_patterns!(declare_plugin_parameters);

impl Pattern {
    /// The name of a plugin in lists; empty if there is no such plugin.
    pub(crate) fn label(plugin: &str) -> &'static str {
        let declared = Self::DECLARED.iter().find(|declared| declared.name == plugin);
        declared.map_or("", |declared| declared.label)
    }

    /// Calls `meet` with every texture among the parameters.
    pub(crate) fn for_each_nested<'p>(&'p self, meet: &mut dyn FnMut(&'p Texture)) {
        self.visit(&mut |_, value| match value {
            ParameterRef::Nested(Parameter::Texture(texture)) | ParameterRef::OptionalTexture(Some(texture)) => {
                meet(texture);
            }
            _ => {}
        });
    }

    /// Calls `meet` with every texture among the parameters, mutable.
    pub(crate) fn for_each_nested_mut(&mut self, meet: &mut dyn FnMut(&mut Texture)) {
        self.visit_mut(&mut |_, value| match value {
            ParameterMut::Nested(Parameter::Texture(texture)) | ParameterMut::OptionalTexture(Some(texture)) => {
                meet(texture);
            }
            _ => {}
        });
    }

    /// Calls `meet` with the parameter of this number among those that may be textures.
    pub(super) fn for_nested(&mut self, number: u32, meet: &mut dyn FnMut(&mut Parameter<Rgb>)) {
        let mut numbers = 0..;
        self.visit_mut(&mut |_, value| match value {
            ParameterMut::Nested(nested) if numbers.next() == Some(number) => meet(nested),
            ParameterMut::OptionalTexture(texture) if numbers.next() == Some(number) => {
                let mut inside = texture
                    .take()
                    .map_or(Parameter::Constant(Rgb::ZERO), Parameter::Texture);
                meet(&mut inside);
                if let Parameter::Texture(changed) = inside {
                    *texture = Some(changed);
                }
            }
            _ => {}
        });
    }

    /// Calls `meet` with its uv transform; one that belongs to lengths of a shape counts as well.
    pub(crate) fn for_own_placing(&mut self, meet: &mut dyn FnMut(&mut Affine2)) {
        self.visit_mut(&mut |_, value| {
            if let ParameterMut::Placing(to_uv) = value {
                meet(to_uv);
            }
        });
    }

    /// Whether its textures have coordinates of their own, apart from uv.
    pub(crate) fn has_own_coordinates(&self) -> bool {
        matches!(self, Self::BoxProjection { .. })
    }
}
