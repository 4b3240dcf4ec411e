//! The placing of textures on a surface: the transform of uv decomposed for the user, and the textures of a material
//! with equal transforms.

use super::traits::Traits;
use super::uv_projection::Projection;
use crate::scene::SquarePath;
use bevy::prelude::Entity;
use std::path::PathBuf;

use bevy::math::{Affine2, Mat2, Vec2};

use crate::scene::{Material, Texture};

/// A decomposed transform of uv. A picture is repeated first, then sheared, turned and shifted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placing {
    /// The pictures in one unit of u, above 0, and in one of v, below 0 where the picture is mirrored.
    pub repeats: Vec2,
    /// The growth of the picture's u as v grows by one picture.
    pub shear: f32,
    /// The rotation of uv in degrees, from -180 to 180. On the surface the picture turns the other way.
    pub degrees: f32,
    /// The coordinates in the picture, in pictures, at the origin of uv.
    pub offset: Vec2,
}

impl Placing {
    /// The parts of a transform; None if it has no inverse.
    pub fn of(to_uv: &Affine2) -> Option<Self> {
        let [x, y] = [to_uv.matrix2.x_axis, to_uv.matrix2.y_axis];
        let along = x.try_normalize()?;
        let repeats = Vec2::new(x.length(), along.perp_dot(y));
        // Rounds the error of single precision from an angle that was given in short numbers.
        let degrees = (along.to_angle().to_degrees() * 1e4).round() * 1e-4;
        let shear = along.dot(y) / repeats.y;
        let shear = if shear.abs() < 1e-5 { 0.0 } else { shear };
        let placing = Self {
            repeats,
            shear,
            degrees,
            offset: to_uv.translation,
        };
        let is_finite = repeats.is_finite() && shear.is_finite() && placing.offset.is_finite();
        (is_finite && repeats.y != 0.0).then_some(placing)
    }

    /// The transform.
    pub fn to_uv(&self) -> Affine2 {
        let spread = Mat2::from_cols(
            Vec2::new(self.repeats.x, 0.0),
            Vec2::new(self.shear * self.repeats.y, self.repeats.y),
        );
        Affine2::from_mat2_translation(turn(self.degrees) * spread, self.offset)
    }
}

/// A rotation, exact for multiples of 90 degrees.
fn turn(degrees: f32) -> Mat2 {
    let clean = |number: f32| if number.abs() < 1e-6 { 0.0 } else { number };
    let (sine, cosine) = degrees.to_radians().sin_cos();
    let (sine, cosine) = (clean(sine), clean(cosine));
    Mat2::from_cols(Vec2::new(cosine, sine), Vec2::new(-sine, cosine))
}

/// The transform that makes a picture upright, given whether uv have it upside down.
pub fn upright(is_turned: bool) -> Affine2 {
    match is_turned {
        true => Affine2::from_scale_angle_translation(Vec2::new(1.0, -1.0), 0.0, Vec2::Y),
        false => Affine2::IDENTITY,
    }
}

/// Textures of a material, and of its nested ones, with the same transform of uv.
#[derive(Clone, Debug, PartialEq)]
pub struct TextureGroup {
    /// The transform.
    pub to_uv: Affine2,
    /// The parameters of these textures, each once: their names in the file, and their labels.
    pub parameters: Vec<(&'static str, &'static str)>,
}

impl TextureGroup {
    /// The labels of its parameters.
    pub(crate) fn name(&self) -> String {
        let labels: Vec<&str> = self.parameters.iter().map(|(_, label)| *label).collect();
        labels.join(", ")
    }
}

/// Whether one of the materials has a texture that can be placed.
pub(crate) fn has_textures<'m>(materials: impl IntoIterator<Item = &'m Material>) -> bool {
    let mut found = false;
    for material in materials {
        material
            .for_each_texture(&mut |texture| found |= !matches!(texture, Texture::MeshAttribute { times: None, .. }));
    }
    found
}

/// The groups of the textures of materials, in the order of their first textures.
pub fn texture_groups<'m>(materials: impl IntoIterator<Item = &'m Material>) -> Vec<TextureGroup> {
    let mut groups: Vec<TextureGroup> = Vec::new();
    for material in materials {
        material.clone().for_each_placing(&mut |info, to_uv| {
            let parameter = (info.name, info.label);
            match groups.iter_mut().find(|group| group.to_uv == *to_uv) {
                Some(group) if group.parameters.contains(&parameter) => {}
                Some(group) => group.parameters.push(parameter),
                None => groups.push(TextureGroup {
                    to_uv: *to_uv,
                    parameters: vec![parameter],
                }),
            }
        });
    }
    groups
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::color::Rgb;
    use crate::scene::{Parameter, Principled, Texture};

    #[test]
    fn parts_give_the_transform_back() {
        let turns = [-170.0, -90.0, -12.5, 0.0, 30.0, 90.0, 180.0];
        for degrees in turns {
            for (repeats, shear) in [
                ((4.0, 2.0), 0.0),
                ((1.0, -1.0), 0.0),
                ((0.25, 8.0), 0.5),
                ((3.0, -0.2), -2.0),
            ] {
                let placing = Placing {
                    repeats: repeats.into(),
                    shear,
                    degrees,
                    offset: Vec2::new(0.1, -7.0),
                };
                let found = Placing::of(&placing.to_uv()).expect("it has an inverse");
                assert!(
                    found.repeats.abs_diff_eq(placing.repeats, 1e-4),
                    "{found:?}, not {placing:?}"
                );
                assert!((found.shear - shear).abs() < 1e-4, "{found:?}, not {placing:?}");
                assert!((found.degrees - degrees).abs() < 2e-4, "{found:?}, not {placing:?}");
                assert_eq!(found.offset, placing.offset);
            }
        }
        let flat = Affine2::from_scale(Vec2::new(1.0, 0.0));
        assert_eq!(Placing::of(&flat), None);
        assert_eq!(Placing::of(&Affine2::from_scale(Vec2::ZERO)), None);
    }

    #[test]
    fn what_is_upright_is_a_mirror_image_without_a_turn() {
        for is_turned in [false, true] {
            let to_uv = upright(is_turned);
            let placing = Placing::of(&to_uv).expect("it has an inverse");
            assert_eq!((placing.degrees, placing.shear), (0.0, 0.0));
            assert_eq!(placing.to_uv(), to_uv);
        }
        let quarter = Placing {
            repeats: Vec2::ONE,
            shear: 0.0,
            degrees: 90.0,
            offset: Vec2::ZERO,
        };
        assert_eq!(quarter.to_uv().matrix2, Mat2::from_cols(Vec2::Y, -Vec2::X));
    }

    #[test]
    fn textures_that_lie_alike_are_one_group() {
        let board = |scale: f32| Texture::Checkerboard {
            color0: Box::new(Rgb::ONE.into()),
            color1: Box::new(Rgb::ZERO.into()),
            to_uv: Box::new(Affine2::from_scale(Vec2::splat(scale))),
        };
        let material = Material::Principled(
            Principled {
                base_color: Parameter::Texture(board(2.0)),
                roughness: Parameter::Texture(board(3.0)),
                metallic: Parameter::Texture(board(2.0)),
                ..Principled::default()
            }
            .into(),
        );
        assert!(has_textures([&Material::default(), &material]) && !has_textures([&Material::default()]));
        let groups = texture_groups([&material, &Material::default()]);
        let names: Vec<String> = groups.iter().map(TextureGroup::name).collect();
        assert_eq!(names.len(), 2, "{names:?}");
        assert_eq!(
            groups.iter().map(|group| group.parameters.len()).collect::<Vec<_>>(),
            [2, 1]
        );
        assert_eq!(groups[0].to_uv, Affine2::from_scale(Vec2::splat(2.0)));
    }
}

/// An edit of the textures of materials and lights, and of the coordinates that place them.
#[derive(Clone, Debug, PartialEq)]
pub enum TextureEdit {
    /// Replaces the picture of a texture of a material or a light, or adds a texture with it.
    SetPicture {
        /// A material or a light.
        owner: Entity,
        /// The name of the parameter in the file.
        parameter: &'static str,
        /// The place of the texture within the parameter, if it is inside a checkerboard.
        place: SquarePath,
        /// The absolute path of the picture.
        path: PathBuf,
    },
    /// Places textures: replaces the transform of all textures of a material, or of a shape's material, that have the
    /// transform `before`.
    PlaceTextures {
        /// A shape or a material, including nested ones.
        owner: Entity,
        /// The present transform of the textures.
        before: Affine2,
        /// The new transform.
        after: Affine2,
    },
    /// Gives shapes new texture coordinates.
    ProjectTextures {
        /// The shapes.
        shapes: Vec<Entity>,
        /// The source of the coordinates.
        projection: Projection,
    },
}

impl TextureEdit {
    pub(super) fn traits(&self) -> Traits {
        match self {
            Self::SetPicture { owner, .. } => Traits::edit("Choose picture").of(&[*owner]),
            Self::PlaceTextures { owner, .. } => Traits::drag("Place texture").of(&[*owner]),
            Self::ProjectTextures { shapes, .. } => Traits::edit("Project texture").of(shapes),
        }
    }
}
