//! Applies an edit of one value to another value of the same type: only the edited parts change there, too.

use bevy::math::Vec3;
use bevy::reflect::{PartialReflect, ReflectMut, ReflectRef};

/// How vectors that differ in some components are carried over.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Vectors {
    /// As colours: all components are copied.
    Whole,
    /// As positions: only the changed components are copied.
    ByComponent,
}

/// Applies to `other` the change from `before` to `after`. Fields of the same name correspond, even of different
/// variants; where the variant was changed, `other` gets all of the new one. Does nothing unless the three are of one
/// type.
pub(crate) fn carry_over(
    before: &dyn PartialReflect,
    after: &dyn PartialReflect,
    other: &mut dyn PartialReflect,
    vectors: Vectors,
) {
    if before.reflect_partial_eq(after) == Some(true) {
        return;
    }
    let is_one = vectors == Vectors::Whole && after.represents::<Vec3>();
    let next = |before: Option<&dyn PartialReflect>,
                after: Option<&dyn PartialReflect>,
                other: Option<&mut dyn PartialReflect>| {
        if let (Some(before), Some(after), Some(other)) = (before, after, other) {
            carry_over(before, after, other, vectors);
        }
    };
    match (before.reflect_ref(), after.reflect_ref(), other.reflect_mut()) {
        (ReflectRef::Struct(before), ReflectRef::Struct(after), ReflectMut::Struct(other)) if !is_one => {
            for place in 0..after.field_len() {
                next(before.field_at(place), after.field_at(place), other.field_at_mut(place));
            }
        }
        (ReflectRef::TupleStruct(before), ReflectRef::TupleStruct(after), ReflectMut::TupleStruct(other)) => {
            for place in 0..after.field_len() {
                next(before.field(place), after.field(place), other.field_mut(place));
            }
        }
        (ReflectRef::Enum(before), ReflectRef::Enum(after), ReflectMut::Enum(other))
            if before.variant_name() == after.variant_name() && after.field_len() > 0 =>
        {
            let same_variant = other.variant_name() == after.variant_name();
            for place in 0..after.field_len() {
                match after.name_at(place) {
                    Some(name) => next(before.field(name), after.field(name), other.field_mut(name)),
                    None if same_variant => {
                        next(before.field_at(place), after.field_at(place), other.field_at_mut(place))
                    }
                    // `other` has a texture here and the edited value a constant, or the reverse: the edited value
                    // replaces it.
                    None => replace(other.as_partial_reflect_mut(), after.as_partial_reflect()),
                }
            }
        }
        _ => replace(other, after),
    }
}

fn replace(other: &mut dyn PartialReflect, after: &dyn PartialReflect) {
    // This fails for values of other types, which do not change.
    let _ = other.try_apply(after);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::color::Rgb;
    use crate::scene::{Material, Shape, ShapeKind};

    fn sphere(center: Vec3, radius: f32) -> Shape {
        Shape {
            kind: ShapeKind::Sphere { center, radius },
            ..Shape::default()
        }
    }

    fn carried(before: &Material, after: &Material, other: &Material) -> Material {
        let mut other = other.clone();
        carry_over(before, after, &mut other, Vectors::Whole);
        other
    }

    #[test]
    fn only_what_was_changed_is_changed() {
        let mut other = sphere(Vec3::new(7.0, 8.0, 9.0), 3.0);
        let before = sphere(Vec3::ZERO, 1.0);
        carry_over(&before, &sphere(Vec3::Y * 5.0, 1.0), &mut other, Vectors::ByComponent);
        assert_eq!(other, sphere(Vec3::new(7.0, 5.0, 9.0), 3.0));
        carry_over(&before, &sphere(Vec3::ZERO, 2.0), &mut other, Vectors::ByComponent);
        assert_eq!(other, sphere(Vec3::new(7.0, 5.0, 9.0), 2.0));
        // Values without such a field stay.
        let mut cube = Shape {
            kind: ShapeKind::Cube,
            ..Shape::default()
        };
        let untouched = cube.clone();
        carry_over(&before, &sphere(Vec3::ONE, 2.0), &mut cube, Vectors::ByComponent);
        assert_eq!(cube, untouched);
    }

    #[test]
    fn materials_of_other_plugins_take_what_they_have_too() {
        let metal = |reflectance: Rgb, fuzz: f32| Material::Metal {
            reflectance: reflectance.into(),
            fuzz: fuzz.into(),
        };
        let paint = |reflectance: Rgb| Material::Diffuse {
            reflectance: reflectance.into(),
        };
        let before = metal(Rgb::splat(0.5), 0.1);
        let red = Rgb::new(0.5, 0.1, 0.1);
        let after = metal(red, 0.1);
        // A colour is carried over as a whole: its red did not change, but is copied.
        assert_eq!(carried(&before, &after, &metal(Rgb::splat(0.9), 0.7)), metal(red, 0.7));
        assert_eq!(carried(&before, &after, &paint(Rgb::splat(0.9))), paint(red));
        assert_eq!(carried(&before, &metal(Rgb::splat(0.5), 0.9), &paint(red)), paint(red));
    }

    #[test]
    fn a_texture_takes_the_place_of_a_colour() {
        let checkers = Material::Diffuse {
            reflectance: crate::scene::Parameter::Texture(crate::scene::Texture::Checkerboard {
                color0: Box::new(Rgb::ZERO.into()),
                color1: Box::new(Rgb::ONE.into()),
                to_uv: Box::new(bevy::math::Affine2::IDENTITY),
            }),
        };
        let paint = Material::Diffuse {
            reflectance: Rgb::X.into(),
        };
        let other = Material::Diffuse {
            reflectance: Rgb::Y.into(),
        };
        assert_eq!(carried(&paint, &checkers, &other), checkers);
        assert_eq!(carried(&checkers, &paint, &other), paint);
    }
}
