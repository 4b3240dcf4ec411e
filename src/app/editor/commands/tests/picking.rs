//! Clicks and new things before and behind borders of media.

use std::sync::Arc;

use bevy::math::{Affine3A, Vec2, Vec3};
use bevy::prelude::Entity;

use crate::app::editor::camera::picking::tests::spheres;
use crate::app::editor::camera::picking::{pick, seen_in, surface};
use crate::app::editor::picture::material_ball;
use crate::engine::PackedScene;
use crate::material::{Material, MaterialId, MaterialTable};
use crate::math::Ray;
use crate::medium::{MediumId, MediumInterface, MediumSource, MediumTable, Phase, Volume};
use crate::render::camera::Camera;
use crate::render::scene::{SurfaceSlot, SurfaceTable};
use crate::render::view::View;
use crate::shading::{Bsdf, Diffuse};

/// A ball of a medium without a surface, 1 wide at 5 along z, before another ball at 9.
fn fog_before_a_ball(sigma_t: f32) -> (PackedScene, [Entity; 2]) {
    let (mut packed, entities) = spheres(&[Vec3::Z * 5.0, Vec3::Z * 9.0]);
    let camera = Camera::new(Affine3A::IDENTITY, 40.0, 1.0, 1e-3, 1e3, None);
    packed.view = Some(View {
        camera,
        ..material_ball::view(16)
    });
    let fog = MediumSource {
        sigma_t: Volume::Constant(Vec3::splat(sigma_t)),
        scale: 1.0,
        albedo: Volume::Constant(Vec3::ONE),
        emission: Volume::ZERO,
        phase: Phase::Isotropic,
    };
    let scene = packed.scene.as_mut().expect("a scene");
    scene.media = Arc::new(MediumTable::new(vec![fog]));
    let white = Bsdf::Diffuse(Diffuse { reflectance: Vec3::ONE });
    let materials = vec![Material::Null, Material::Plain(white)];
    scene.materials = Arc::new(MaterialTable::new(materials).expect("two materials"));
    let slot = |material, interior| SurfaceSlot {
        material: MaterialId(material),
        light: None,
        media: MediumInterface {
            interior,
            exterior: None,
        },
    };
    scene.surfaces = Arc::new(SurfaceTable {
        first_slot: vec![0, 1],
        slots: vec![slot(0, Some(MediumId(0))), slot(1, None)],
    });
    (packed, [entities[0], entities[1]])
}

#[test]
fn a_click_goes_through_thin_fog_and_stops_in_thick_one() {
    let picked = |sigma_t: f32, at: Vec2| {
        let (packed, [fog, ball]) = fog_before_a_ball(sigma_t);
        let found = pick(&packed, at);
        (found == Some(fog), found == Some(ball), found.is_none())
    };
    let middle = Vec2::splat(0.5);
    assert_eq!(picked(0.1, middle), (false, true, false));
    assert_eq!(picked(2.0, middle), (true, false, false));
    // Beside the ball there is nothing but fog.
    assert_eq!(picked(0.1, Vec2::new(0.5 + 0.22, 0.5)), (true, false, false));
    assert_eq!(picked(0.1, Vec2::new(0.02, 0.5)), (false, false, true));
}

#[test]
fn things_stand_on_what_is_in_the_fog_and_boxes_select_both() {
    let (packed, [fog, ball]) = fog_before_a_ball(2.0);
    let seen = surface(&packed, &Ray::new(Vec3::ZERO, Vec3::Z), |_| false);
    assert!(seen.is_some_and(|seen| seen.entity == ball && (seen.position.z - 8.0).abs() < 1e-3));
    let found = seen_in(&packed, [Vec2::splat(0.45), Vec2::splat(0.55)], [8.0, 8.0]);
    assert_eq!(found, [fog, ball]);
}
