//! Light from infinity through portals: the density of its directions, where portals count, and that pictures do not
//! depend on them but for their noise.

use std::f32::consts::{FRAC_PI_2, PI};
use std::sync::Arc;

use glam::{Affine3A, Mat3, Quat, UVec2, Vec2, Vec3};
use sunroom::accel::{Blas, Primitive, SplitMethod};
use sunroom::color::Rgb;
use sunroom::geometry::solid::{Hole, openings, wall};
use sunroom::light::{Atmosphere, EnvironmentMap, LightId, LightReference, LightSource, Portal};
use sunroom::render::scene::RenderScene;
use sunroom::render::view::{Integrator, Strategy};
use sunroom::sampling::{Sampler, SequenceKind};
use sunroom::shading::{Bsdf, Dielectric, DielectricModel, Diffuse, ThinDielectric};
use sunroom::texture::{Image, Samples, Transfer};

use crate::statistics;
use crate::support::{SceneBuilder, all_around, assert_close, camera, mean_luminance, render, view};

const WINDOW: Hole = Hole {
    from: 1.0,
    sill: 0.9,
    width: 1.4,
    height: 1.2,
};

/// A room 4 wide, 2.5 high and 5 long, z upwards, from the origin; its floor is a meadow outside.
#[derive(Clone)]
struct Room {
    sky: LightSource,
    /// The openings of the walls along y = 0, x = 4, y = 5 and x = 0.
    holes: [Vec<Hole>; 4],
    has_portals: bool,
    /// Portals of no wall.
    more: Vec<Portal>,
    /// What the pane before the first wall is made of.
    pane: Option<Bsdf>,
    place: Affine3A,
}

fn gray(albedo: f32) -> Bsdf {
    Bsdf::Diffuse(Diffuse {
        reflectance: Rgb::splat(albedo),
    })
}

fn constant() -> LightSource {
    LightSource::Constant {
        radiance: Rgb::new(1.0, 1.2, 1.5),
    }
}

fn sun_and_sky(sun_scale: f32) -> LightSource {
    LightSource::SunSky {
        atmosphere: Atmosphere {
            turbidity: 3.0,
            albedo: Rgb::splat(0.2),
            sun_direction: Vec3::new(0.2, -0.7, 0.6).normalize(),
            sky_scale: 1.0,
            sun_scale,
            // So large that the integral of the density does not miss it.
            sun_aperture: 40f32.to_radians(),
            limb_darkening: false,
        },
        world_from_local: Mat3::IDENTITY,
    }
}

/// A bright and a dark half, with a brighter pixel that the window shows.
fn picture() -> LightSource {
    let pixels = (0..16 * 8).flat_map(|pixel| match (pixel % 16, pixel / 16) {
        (2, 2) => [20.0; 3],
        (0..8, _) => [1.0, 0.8, 0.5],
        _ => [0.05; 3],
    });
    let image = Image::new(16, 8, 3, Samples::F32(pixels.collect()), Transfer::Linear).expect("a whole picture");
    LightSource::Environment {
        map: Arc::new(EnvironmentMap::new(Arc::new(image), false)),
        world_from_local: Mat3::from_rotation_x(FRAC_PI_2),
        scale: 1.0,
    }
}

impl Room {
    /// A window in the first wall.
    fn new(sky: LightSource) -> Self {
        Self {
            sky,
            holes: [vec![WINDOW], vec![], vec![], vec![]],
            has_portals: true,
            more: Vec::new(),
            pane: None,
            place: Affine3A::IDENTITY,
        }
    }

    fn without_portals(&self) -> Self {
        Self {
            has_portals: false,
            ..self.clone()
        }
    }

    fn build(&self) -> RenderScene {
        let mut scene = SceneBuilder::default();
        let sides = [
            (4.0, Vec3::ZERO, 0.0),
            (5.0, Vec3::X * 4.0, FRAC_PI_2),
            (4.0, Vec3::new(4.0, 5.0, 0.0), PI),
            (5.0, Vec3::Y * 5.0, -FRAC_PI_2),
        ];
        for (holes, (length, corner, angle)) in self.holes.iter().zip(sides) {
            let to_world = self.place * Affine3A::from_rotation_translation(Quat::from_rotation_z(angle), corner);
            let mesh = wall(length, 2.5, 0.2, holes);
            let mesh = Primitive::Mesh(Arc::new(Blas::build(Arc::new(mesh), SplitMethod::Sah)));
            scene.add(mesh, to_world, gray(0.6), None);
            if self.has_portals {
                scene
                    .portals
                    .extend(openings(length, 2.5, holes).into_iter().map(|(corner, edges)| Portal {
                        corner: to_world.transform_point3(corner),
                        edges: edges.map(|edge| to_world.transform_vector3(edge)),
                    }));
            }
        }
        scene.portals.extend(self.more.iter().filter(|_| self.has_portals));
        let level =
            |size: Vec3, at: Vec3| self.place * Affine3A::from_scale_rotation_translation(size, Quat::IDENTITY, at);
        let ground = level(Vec3::new(40.0, 40.0, 1.0), Vec3::ZERO);
        scene.add(Primitive::Rectangle, ground, gray(0.3), None);
        let ceiling = level(Vec3::new(2.2, 2.7, 1.0), Vec3::new(2.0, 2.5, 2.5));
        scene.add(Primitive::Rectangle, ceiling, gray(0.7), None);
        if let Some(glass) = self.pane {
            let upright = Affine3A::from_scale_rotation_translation(
                Vec3::new(2.0, 1.25, 1.0),
                Quat::from_rotation_x(FRAC_PI_2),
                Vec3::new(2.0, 0.2, 1.25),
            );
            scene.add(Primitive::Rectangle, self.place * upright, glass, None);
        }
        scene.light(self.sky.clone());
        scene.build()
    }

    /// A place in the room, on a surface if it has a normal.
    fn reference(&self, at: [f32; 3], normal: Option<Vec3>) -> LightReference {
        LightReference {
            position: self.place.transform_point3(at.into()),
            normal: normal.map(|normal| self.place.transform_vector3(normal).normalize()),
        }
    }
}

fn pdf(scene: &RenderScene, from: &LightReference, wi: Vec3) -> f32 {
    scene.lights.radiance_and_pdf_from(LightId(0), from, wi).1
}

/// The share of the samples from a place that go through its portals, seen towards `to`: how much the density differs
/// from that without them.
fn helps(room: &Room, from: &LightReference, to: Vec3) -> bool {
    let wi = (to - from.position).normalize();
    let [with, without] = [room, &room.without_portals()].map(|room| pdf(&room.build(), from, wi));
    assert!(with >= 0.0 && without > 0.0);
    with > 2.0 * without
}

fn middle_of_window(room: &Room) -> Vec3 {
    room.place.transform_point3(Vec3::new(1.7, 0.0, 1.5))
}

fn rooms() -> Vec<(&'static str, Room)> {
    let door = Hole {
        from: 0.5,
        sill: 0.0,
        width: 0.9,
        height: 2.1,
    };
    let across = Hole {
        from: 1.8,
        sill: 0.5,
        width: 1.5,
        height: 1.0,
    };
    let corner = Hole {
        from: 0.0,
        width: 1.0,
        ..WINDOW
    };
    let flat = |edges: [Vec3; 2]| Portal {
        corner: Vec3::new(1.0, 0.0, 0.9),
        edges,
    };
    let degenerate = [
        [Vec3::ZERO, Vec3::Z],
        [Vec3::X, Vec3::X],
        [Vec3::X, Vec3::new(0.5, 0.0, 1.0)],
        [Vec3::X * f32::INFINITY, Vec3::Z],
        [Vec3::X, Vec3::Z * f32::NAN],
        [Vec3::X * 1e-20, Vec3::Z * 1e-20],
    ];
    let open = |sky: LightSource, holes: [Vec<Hole>; 4]| Room {
        holes,
        ..Room::new(sky)
    };
    let three = [vec![WINDOW, across], vec![door], vec![], vec![corner]];
    let turned = Affine3A::from_scale_rotation_translation(
        Vec3::splat(30.0),
        Quat::from_axis_angle(Vec3::new(1.0, 2.0, 0.5).normalize(), 0.8),
        Vec3::new(100.0, -40.0, 7.0),
    );
    vec![
        ("a window", Room::new(constant())),
        ("sun and sky", Room::new(sun_and_sky(1.0))),
        ("sky alone", Room::new(sun_and_sky(0.0))),
        ("a picture", Room::new(picture())),
        ("windows that overlap, a door", open(sun_and_sky(1.0), three.clone())),
        ("walls of one picture", open(picture(), three)),
        (
            "without an area",
            Room {
                more: degenerate.map(flat).to_vec(),
                ..Room::new(constant())
            },
        ),
        (
            "twice the same",
            Room {
                more: vec![flat([Vec3::Z * 1.2, Vec3::X * 1.4])],
                ..Room::new(picture())
            },
        ),
        (
            "moved and larger",
            Room {
                place: turned,
                ..Room::new(constant())
            },
        ),
    ]
}

#[test]
fn directions_follow_their_density() {
    let mut results = Vec::new();
    for (name, room) in rooms() {
        let scene = room.build();
        // In the middle, on the floor, in a corner, beside the window, in its plane, outside.
        for (place, normal) in [
            ([2.0, 2.5, 1.0], None),
            ([1.0, 1.5, 0.0], Some(Vec3::Z)),
            ([3.85, 4.85, 0.05], Some(Vec3::NEG_X)),
            ([0.3, 0.11, 1.2], Some(Vec3::Y)),
            ([1.7, 0.0, 1.5], None),
            ([1.7, -2.0, 0.0], Some(Vec3::Z)),
        ] {
            let from = room.reference(place, normal);
            let sample = |index| {
                let sampler = Sampler::new(SequenceKind::Independent, UVec2::ZERO, index, 5);
                let sample = scene.lights.sample(&from, sampler.at_1d(0), sampler.at_2d(1))?.1;
                let again = pdf(&scene, &from, sample.wi);
                // At the rims of portals and of the sun rounding decides; few directions come so near.
                assert!(
                    index > 1000 || (again / sample.pdf - 1.0).abs() < 5e-3,
                    "{name} at {place:?}: {again} for {sample:?}"
                );
                Some(sample.wi)
            };
            let axis = (middle_of_window(&room) - from.position)
                .try_normalize()
                .unwrap_or(Vec3::Z);
            let p = statistics::sphere_p(20_000, axis, sample, |wi| pdf(&scene, &from, wi));
            results.push((format!("{name} at {place:?}"), p));
        }
    }
    statistics::assert_all_plausible(&results);
}

#[test]
fn portals_count_where_they_light_a_room() {
    for sky in [constant(), sun_and_sky(0.0), sun_and_sky(1.0)] {
        let room = Room::new(sky);
        let window = middle_of_window(&room);
        for (place, normal) in [
            ([2.0, 2.5, 1.0], None),
            ([1.0, 4.5, 0.0], Some(Vec3::Z)),
            ([3.9, 3.0, 1.0], Some(Vec3::NEG_X)),
        ] {
            assert!(helps(&room, &room.reference(place, normal), window), "{place:?}");
        }
        // Outdoors, before the window and behind the house, it is the density of the sky alone.
        let [with, without] = [&room, &room.without_portals()].map(Room::build);
        for place in [[1.7, -1.0, 0.0], [2.0, 9.0, 0.0], [-3.0, 2.0, 0.0], [2.0, 2.5, 3.0]] {
            let from = room.reference(place, Some(Vec3::Z));
            for wi in [Vec3::Z, Vec3::new(0.6, 0.0, 0.8), (window - from.position).normalize()] {
                assert_eq!(pdf(&with, &from, wi), pdf(&without, &from, wi), "{place:?} {wi}");
            }
        }
    }
}

#[test]
fn portals_that_show_no_sky_do_not_count() {
    let inside = |room: &Room| room.reference([2.0, 2.5, 1.0], None);
    let is_used = |room: &Room| {
        let [with, without] = [room, &room.without_portals()].map(Room::build);
        let from = inside(room);
        let wi = (middle_of_window(room) - from.position).normalize();
        pdf(&with, &from, wi) != pdf(&without, &from, wi)
    };
    let open = Room::new(constant());
    assert!(is_used(&open));
    // Light passes straight through thin glass, and through a solid pane it is refracted.
    let thin = Bsdf::ThinDielectric(ThinDielectric {
        eta: 1.5,
        model: DielectricModel::Exact,
        specular_reflectance: Rgb::ONE,
        specular_transmittance: Rgb::ONE,
    });
    let solid = Bsdf::Dielectric(Dielectric {
        eta: 1.5,
        model: DielectricModel::Exact,
        specular_reflectance: Rgb::ONE,
        specular_transmittance: Rgb::ONE,
    });
    for (pane, expected) in [(thin, true), (solid, false), (gray(0.5), false)] {
        let pane = Some(pane);
        assert_eq!(is_used(&Room { pane, ..open.clone() }), expected, "{pane:?}");
    }
    // A portal in the wall's middle where there is no opening, and one whose room is open to the sky.
    let portal = |corner: Vec3| Portal {
        corner,
        edges: [Vec3::X, Vec3::Z],
    };
    let closed = Room {
        holes: [vec![], vec![], vec![], vec![]],
        more: vec![portal(Vec3::new(1.0, 0.0, 1.0))],
        ..open.clone()
    };
    assert!(!is_used(&closed));
    let outdoors = Room {
        more: vec![portal(Vec3::new(1.0, -5.0, 1.0))],
        holes: closed.holes.clone(),
        ..open
    };
    let from = outdoors.reference([1.5, -4.0, 0.0], Some(Vec3::Z));
    let [with, without] = [&outdoors, &outdoors.without_portals()].map(Room::build);
    let wi = Vec3::new(0.0, -0.8, 0.6);
    assert_eq!(pdf(&with, &from, wi), pdf(&without, &from, wi));
}

/// The squared noise of a picture of the room without its window, and its mean.
fn noise(room: &Room, integrator: fn(&mut Integrator), samples: u32) -> (f64, (f32, f32)) {
    let eye = room.place.transform_point3(Vec3::new(0.4, 0.6, 1.7));
    let target = room.place.transform_point3(Vec3::new(3.0, 4.5, 0.8));
    let mut view = view(camera(eye, target, 80.0), 32, 4, Strategy::Mis);
    integrator(&mut view.integrator);
    let film = render(&room.build(), &view, samples);
    let pixels = (0..32).flat_map(|y| (0..32).map(move |x| (x, y)));
    let variance = pixels
        .filter_map(|(x, y)| film.standard_error(x, y))
        .map(|error| f64::from(error * error));
    (variance.sum(), mean_luminance(&film))
}

fn same(_: &mut Integrator) {}

#[test]
fn portals_change_nothing_but_the_noise() {
    for (name, room) in rooms() {
        let (with, without) = (noise(&room, same, 64), noise(&room.without_portals(), same, 256));
        let ((mean, error), (expected, its)) = (with.1, without.1);
        assert_close(name, (mean, error.hypot(its)), expected);
    }
}

#[test]
fn rooms_have_less_noise() {
    for sky in [constant(), sun_and_sky(0.0), picture()] {
        let room = Room::new(sky);
        let [with, without] = [&room, &room.without_portals()].map(|room| noise(room, same, 32).0);
        assert!(without > 2.0 * with, "{without} {with} {:?}", room.sky);
    }
}

#[test]
fn bidirectional_paths_find_the_same_light() {
    let bidirectional = |integrator: &mut Integrator| *integrator = Integrator::Bidirectional(integrator.settings());
    for sky in [constant(), sun_and_sky(1.0)] {
        let room = Room::new(sky);
        let (_, (mean, error)) = noise(&room, bidirectional, 64);
        let (_, (expected, its)) = noise(&room.without_portals(), same, 256);
        assert_close("bdpt", (mean, error.hypot(its)), expected);
    }
}

#[test]
fn directions_are_finite_and_within_their_portal_from_everywhere() {
    let room = Room {
        more: vec![Portal {
            corner: Vec3::new(0.1, 0.1, 2.45),
            edges: [Vec3::X * 3.8, Vec3::Y * 4.8],
        }],
        ..Room::new(constant())
    };
    let scene = room.build();
    for index in 0..20_000 {
        let sampler = Sampler::new(SequenceKind::Independent, UVec2::new(4, 1), index, 5);
        let [u, v] = [0, 1].map(|dimension| sampler.at_2d(dimension));
        // Many in the planes of openings, at their rims and corners.
        let snapped = |x: f32| if index % 3 == 0 { (x * 8.0).round() / 8.0 } else { x };
        let place = Vec3::new(
            4.0 * snapped(u.x),
            5.0 * snapped(u.y) * snapped(v.y),
            2.5 * snapped(v.x),
        );
        let from = all_around(place);
        if let Some((_, sample)) = scene.lights.sample(&from, 0.5, Vec2::new(v.y, u.x)) {
            assert!(
                sample.wi.is_normalized() && sample.pdf.is_finite(),
                "{place} {sample:?}"
            );
            assert!(sample.pdf > 0.0 && pdf(&scene, &from, sample.wi).is_finite());
        }
    }
}
