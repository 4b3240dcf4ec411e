//! The probes of a level as entities.

use bevy::light::{EnvironmentMapLight, IrradianceVolume, LightProbe, ParallaxCorrection};
use bevy::math::{Mat4, Vec3};
use bevy::prelude::*;

use crate::manifest::{ReflectionFiles, VolumeFiles};

/// A reflection probe reaches so much farther than its box, so that what stands on the sides of it is inside.
const REACH: f32 = 1.02;

/// A box of half the size 0.5 in the space of the level, enlarged.
fn place(columns: &[f32; 16], by: f32) -> Transform {
    Transform::from_matrix(Mat4::from_cols_array(columns) * Mat4::from_scale(Vec3::splat(by)))
}

/// What reflecting surfaces in the box see. Meshes with lightmaps have its diffuse light already.
pub(crate) fn reflection(files: &ReflectionFiles, diffuse: Handle<Image>, specular: Handle<Image>) -> impl Bundle {
    let parallax = match files.parallax {
        true => ParallaxCorrection::Custom(Vec3::splat(0.5 / REACH)),
        false => ParallaxCorrection::None,
    };
    let light = EnvironmentMapLight {
        diffuse_map: diffuse,
        specular_map: specular,
        intensity: 1.0,
        affects_lightmapped_mesh_diffuse: false,
        ..default()
    };
    let name = Name::new(files.name.clone());
    (name, LightProbe::new(), light, parallax, place(&files.place, REACH))
}

/// The light in the box for meshes without lightmaps.
pub(crate) fn volume(files: &VolumeFiles, voxels: Handle<Image>) -> impl Bundle {
    let light = IrradianceVolume {
        voxels,
        intensity: 1.0,
        affects_lightmapped_meshes: false,
    };
    let name = Name::new(files.name.clone());
    (name, LightProbe::new(), light, place(&files.place, 1.0))
}
