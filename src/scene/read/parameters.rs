//! Parameters that many plugins have, with the checks and stand-ins they share.

use bevy::math::Affine3A;
use glam::Vec3;

use crate::color::Rgb;
use crate::document::{Category, Reader, TransformOp};

/// Reads one kind of parameter; on a plugin where a value is expected (a texture), says so and uses a stand-in.
pub trait Parameters {
    /// A colour between 0 and 1; above is possible but odd, below is an error.
    fn reflectance(&mut self, name: &str, default: f32) -> Rgb;
    /// A colour without upper bound.
    fn unbounded_color(&mut self, name: &str, default: f32) -> Rgb;
    /// What a light sends out; not negative.
    fn radiometric(&mut self, name: &str) -> Rgb;
    /// Says that a texture is not supported, if there is one for this parameter.
    fn texture_in_place_of(&mut self, name: &str, stand_in: &str) -> bool;
    /// `to_world`; the identity if it is absent, None (with an error) if it cannot be undone.
    fn to_world(&mut self) -> Option<Affine3A>;
}

impl Parameters for Reader<'_, '_> {
    fn reflectance(&mut self, name: &str, default: f32) -> Rgb {
        if self.texture_in_place_of(name, "grey (0.5)") {
            return Rgb::splat(0.5);
        }
        let Some(color) = self.rgb_in(name, 0.0..) else {
            return Rgb::splat(default);
        };
        if color.max_element() > 1.0 {
            self.warn_at(name, format!("`{name}` is above 1: more light leaves than arrives"));
        }
        color
    }

    fn unbounded_color(&mut self, name: &str, default: f32) -> Rgb {
        if self.texture_in_place_of(name, &default.to_string()) {
            return Rgb::splat(default);
        }
        self.rgb_in(name, 0.0..).unwrap_or(Rgb::splat(default))
    }

    fn radiometric(&mut self, name: &str) -> Rgb {
        if self.texture_in_place_of(name, "1") {
            return Rgb::ONE;
        }
        let color = self.emission(name).unwrap_or(Rgb::ONE);
        if color.min_element() < 0.0 {
            self.error_at(name, format!("`{name}` is negative: light cannot be taken away"));
            return Rgb::ONE;
        }
        color
    }

    fn texture_in_place_of(&mut self, name: &str, stand_in: &str) -> bool {
        let Some(object) = self.child(name) else {
            return false;
        };
        if object.category != Category::Texture {
            let message = format!("`{name}` should be a colour or a texture, found {}", object.title());
            self.diagnostics().error(object.span, message);
            return true;
        }
        let message = format!(
            "{} for `{name}` is not supported yet: {stand_in} takes its place",
            object.title()
        );
        self.diagnostics().warn(object.span, message);
        true
    }

    fn to_world(&mut self) -> Option<Affine3A> {
        let Some(steps) = self.transform("to_world") else {
            return Some(Affine3A::IDENTITY);
        };
        let map = TransformOp::compose(&steps);
        if is_invertible(&map) {
            return Some(map);
        }
        let owner = self.object().title();
        self.error_at(
            "to_world",
            format!("`to_world` cannot be undone: it flattens the space of {owner}, or is not finite"),
        );
        None
    }
}

/// Whether the three axes still span a space, whatever their lengths. They do if the volume of the box along their directions is well
/// above the rounding of single precision.
fn is_invertible(map: &Affine3A) -> bool {
    const LEAST_VOLUME: f32 = 1e-6;
    let axes =
        [map.matrix3.x_axis, map.matrix3.y_axis, map.matrix3.z_axis].map(|axis| Vec3::from(axis).try_normalize());
    let [Some(x), Some(y), Some(z)] = axes else {
        return false;
    };
    map.is_finite() && map.inverse().is_finite() && x.cross(y).dot(z).abs() > LEAST_VOLUME
}

/// A frame whose +z is `direction` (not zero); which way its other axes turn does not matter, but is always the same.
pub fn frame_along(direction: Vec3) -> Affine3A {
    let forward = direction.normalize();
    let (left, up) = forward.any_orthonormal_pair();
    Affine3A::from_mat3(glam::Mat3::from_cols(left, up, forward))
}
