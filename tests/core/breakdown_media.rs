//! The routes of light in media and through their borders.

use crate::breakdown::{broken_down, diffuse};
use crate::support::{SceneBuilder, camera, view};
use glam::{Affine3A, Quat, UVec2, Vec3};
use sunroom::accel::Primitive;
use sunroom::color::Rgb;
use sunroom::light::LightSource;
use sunroom::material::Material;
use sunroom::medium::{MediumId, MediumInterface, MediumSource, Phase, Volume};
use sunroom::render::breakdown::{Area, Kind, Portion, Way};
use sunroom::render::view::Strategy;
use sunroom::shading::{
    Bsdf, Compensation, ConductorSpecular, DielectricModel, Microfacet, MicrofacetKind, RoughConductor, ThinDielectric,
};

const UNBOUNDED: u32 = u32::MAX;

fn haze(sigma_t: f32) -> MediumSource {
    MediumSource {
        sigma_t: Volume::Constant(Rgb::splat(sigma_t)),
        scale: 1.0,
        albedo: Volume::Constant(Rgb::splat(0.5)),
        emission: Volume::ZERO,
        phase: Phase::Isotropic,
    }
}

pub fn rough_metal(alpha: f32) -> Bsdf {
    Bsdf::RoughConductor(RoughConductor {
        distribution: Microfacet::new(MicrofacetKind::Ggx, alpha, alpha),
        specular: ConductorSpecular {
            eta: Rgb::ZERO,
            k: Rgb::ONE,
            specular_reflectance: Rgb::ONE,
        },
        multiple_scattering: Compensation::NONE,
    })
}

/// A large lamp over a glossy floor in haze of which one seventh of its light arrives. The density of the highlight is
/// some 2 per steradian.
#[test]
fn kinds_of_light_in_haze_depend_on_no_strategy() {
    let mut scene = SceneBuilder::with_media(vec![haze(0.4)]);
    let floor = Affine3A::from_scale(Vec3::splat(5.0));
    scene.add(Primitive::Rectangle, floor, rough_metal(0.2), None);
    let down = Quat::from_rotation_x(std::f32::consts::PI);
    let lamp = Affine3A::from_scale_rotation_translation(Vec3::splat(3.0), down, Vec3::Z * 5.0);
    scene.add(Primitive::Rectangle, lamp, diffuse(0.0), Some(Rgb::ONE));
    let scene = scene.build();
    let kinds = [Strategy::Bsdf, Strategy::Light, Strategy::Mis].map(|strategy| {
        let mut look = view(camera(Vec3::new(0.0, -0.3, 1.0), Vec3::ZERO, 0.02), 1, 3, strategy);
        look.medium = Some(MediumId(0));
        look.integrator.settings_mut().media = true;
        let found = broken_down(&scene, &look, Area::pixel(UVec2::ZERO), 1 << 15);
        let of_kind = |kind| {
            let mut found = found.portions(|route| (route.bounces == 1 && route.kind == kind).then_some(()));
            found.pop().unwrap_or_else(|| panic!("no {kind:?} by {strategy:?}"))
        };
        [Kind::Direct, Kind::Mirror].map(of_kind)
    });
    let [[direct, mirror], others @ ..] = kinds;
    for (one, other) in others
        .iter()
        .flat_map(|other| [(&direct, &other[0]), (&mirror, &other[1])])
    {
        let error = one.error.hypot(other.error);
        assert!(
            (one.luminance - other.luminance).abs() < 4.5 * error,
            "{one:?} {other:?}"
        );
        assert!(one.luminance > 10.0 * error, "{one:?} {other:?}");
    }
}

/// The floor is in a ball of thin haze under a pane, which covers all but a few thousandths of the sky.
#[test]
fn a_pane_is_named_behind_the_border_of_a_medium() {
    for strategy in [Strategy::Bsdf, Strategy::Light, Strategy::Mis] {
        let mut scene = SceneBuilder::with_media(vec![haze(0.001)]);
        let floor = Affine3A::from_scale(Vec3::splat(30.0));
        scene.add(Primitive::Rectangle, floor, diffuse(0.5), None);
        let pane = Bsdf::ThinDielectric(ThinDielectric {
            eta: 1.5,
            model: DielectricModel::Exact,
            specular_reflectance: Rgb::ZERO,
            specular_transmittance: Rgb::ONE,
        });
        let above = Affine3A::from_scale_rotation_translation(Vec3::splat(900.0), Quat::IDENTITY, Vec3::Z * 5.0);
        scene.add(Primitive::Rectangle, above, pane, None);
        let ball = Affine3A::from_scale(Vec3::splat(2.0));
        scene.add(Primitive::Sphere, ball, Material::Null, None);
        scene.between(MediumInterface {
            interior: Some(MediumId(0)),
            exterior: None,
        });
        scene.light(LightSource::Constant { radiance: Rgb::ONE });
        let mut look = view(
            camera(Vec3::new(0.0, -1.0, 2.0), Vec3::ZERO, 5.0),
            1,
            UNBOUNDED,
            strategy,
        );
        look.integrator.settings_mut().media = true;
        let found = broken_down(&scene.build(), &look, Area::pixel(UVec2::ZERO), 1024);
        let ways: Vec<Portion<Way>> = found.portions(|route| Some(route.way));
        let pane = Way::Straight { through: Some(1) };
        let share = ways.iter().find(|portion| portion.key == pane);
        assert!(share.is_some_and(|pane| pane.share > 0.97), "{strategy:?}: {ways:?}");
        let border = Way::Straight { through: Some(2) };
        assert!(!ways.iter().any(|portion| portion.key == border), "{ways:?}");
    }
}

/// Light of a lamp that rough metal reflects onto a floor is found at the metal by light sampling; that which a
/// nearly smooth ball reflects is not.
#[test]
fn only_sharp_gloss_makes_caustics() {
    let caustics = |alpha| {
        let mut scene = SceneBuilder::default();
        let floor = Affine3A::from_scale(Vec3::splat(5.0));
        scene.add(Primitive::Rectangle, floor, diffuse(0.5), None);
        let ball = Affine3A::from_translation(Vec3::new(2.0, 0.0, 1.0));
        scene.add(Primitive::Sphere, ball, rough_metal(alpha), None);
        let down = Quat::from_rotation_x(std::f32::consts::PI);
        let lamp = Affine3A::from_scale_rotation_translation(Vec3::splat(0.5), down, Vec3::Z * 4.0);
        scene.add(Primitive::Rectangle, lamp, diffuse(0.0), Some(Rgb::ONE));
        let look = view(
            camera(Vec3::new(0.0, -1.0, 2.0), Vec3::ZERO, 5.0),
            1,
            UNBOUNDED,
            Strategy::Mis,
        );
        let found = broken_down(&scene.build(), &look, Area::pixel(UVec2::ZERO), 1 << 14);
        let kinds = found.portions(|route| (route.kind == Kind::Mirror).then_some(route.is_caustic));
        let share = |is_caustic| {
            kinds
                .iter()
                .find(|portion| portion.key == is_caustic)
                .map_or(0.0, |part| part.share)
        };
        [share(false), share(true)]
    };
    let [plain, caustic] = caustics(0.3);
    assert!(plain > 0.0 && caustic < 0.01 * plain, "{plain} {caustic}");
    let [plain, caustic] = caustics(0.01);
    assert!(caustic > plain, "{plain} {caustic}");
}
