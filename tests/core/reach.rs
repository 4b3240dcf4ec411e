//! What the lights of a scene can meet, and lamps that aim at it.

use std::f32::consts::PI;
use std::sync::Arc;

use glam::{Affine3A, Quat, UVec2, Vec2, Vec3};
use sunroom::accel::{Blas, Instance, Placement, Primitive, SplitMethod, Tlas};
use sunroom::color::Rgb;
use sunroom::geometry::mesh::MeshData;
use sunroom::light::emission::{EmittedRay, Reach, SceneSphere, Start};
use sunroom::light::{LightSource, LightTable};
use sunroom::math::{Aabb, Frame};
use sunroom::render::scene::RenderScene;
use sunroom::sampling::{Sampler, SequenceKind};
use sunroom::shading::{Bsdf, Diffuse};
use sunroom::texture::Parameter;

use crate::random::Random;
use crate::statistics::{assert_all_plausible, chi_squared_p};
use crate::support::{SceneBuilder, leaning_triangle, square_mesh, square_of_three_triangles};

fn black() -> Bsdf {
    Bsdf::Diffuse(Diffuse { reflectance: Rgb::ZERO })
}

fn at(place: Vec3) -> Affine3A {
    Affine3A::from_translation(place)
}

/// Spheres of radius 1 at these places, and lamps of radius 1.
fn spheres(plain: &[Vec3], lamps: &[Vec3]) -> RenderScene {
    let mut scene = SceneBuilder::default();
    for &place in plain {
        scene.add(Primitive::Sphere, at(place), black(), None);
    }
    for &place in lamps {
        scene.add(Primitive::Sphere, at(place), black(), Some(Rgb::ONE));
    }
    scene.build()
}

/// The sphere around spheres of radius 1 at these places.
fn around(places: &[Vec3]) -> SceneSphere {
    let boxes = places.iter().map(|&place| Aabb {
        min: place - 1.0,
        max: place + 1.0,
    });
    SceneSphere::around(&boxes.fold(Aabb::EMPTY, |all, bounds| all.union(bounds)))
}

#[track_caller]
fn assert_alike(found: SceneSphere, expected: SceneSphere) {
    let are_alike = (found.radius / expected.radius - 1.0).abs() < 1e-5
        && found.center.distance(expected.center) < 1e-5 * expected.radius;
    assert!(are_alike, "{found:?}, not {expected:?}");
}

#[test]
fn far_lamps_are_not_among_what_is_lit() {
    let plain = [Vec3::ZERO, Vec3::new(3.0, 1.0, 0.0)];
    let [left, right] = [Vec3::new(-40.0, 0.0, 0.0), Vec3::new(5.0, 60.0, 9.0)];
    for lamps in [&[left][..], &[right], &[left, right]] {
        let reach = spheres(&plain, lamps).reach;
        assert_alike(reach.lit, around(&plain));
        assert_alike(reach.everything, around(&[&plain[..], lamps].concat()));
    }
}

#[test]
fn near_lamps_are_lit_as_all_else_is() {
    let plain = [Vec3::ZERO, Vec3::new(3.0, 1.0, 0.0)];
    let [near, far] = [Vec3::new(0.0, 6.0, 0.0), Vec3::new(-40.0, 0.0, 0.0)];
    let reach = spheres(&plain, &[near]).reach;
    assert_eq!(reach.lit, reach.everything);
    // Also beside one that is far.
    let reach = spheres(&plain, &[near, far]).reach;
    assert_alike(reach.lit, around(&[plain[0], plain[1], near]));
    // Lamps alone light each other.
    let reach = spheres(&[], &[near, far]).reach;
    assert_eq!(reach.lit, reach.everything);
    assert_alike(reach.everything, around(&[near, far]));
    // Of nothing there is some sphere.
    let nothing = spheres(&[], &[]).reach;
    assert_eq!(nothing, Reach::default());
}

#[test]
fn a_shape_of_several_slots_is_a_lamp_if_all_of_them_shine() {
    // Two triangles, each of a slot of its own.
    let mesh = MeshData {
        positions: [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
            .map(|(x, y)| Vec3::new(x, y, 0.0))
            .to_vec(),
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        material_of_triangle: vec![0, 1],
        ..MeshData::default()
    };
    let square = Primitive::Mesh(Arc::new(Blas::build(Arc::new(mesh), SplitMethod::Sah)));
    let shapes = [(Primitive::Sphere, Vec3::ZERO), (square, Vec3::new(0.0, 0.0, 30.0))];
    let shapes = shapes.map(|(primitive, place)| Instance::new(primitive, at(place)).expect("it can be inverted"));
    let geometry = Tlas::build(shapes.into(), SplitMethod::Sah);
    let reach = |slots: &[u32]| {
        let shining = slots.iter().map(|&slot| LightSource::Surface {
            is_two_sided: false,
            instance: 1,
            slot,
            radiance: Parameter::Constant(Rgb::ONE),
        });
        let sources: Vec<_> = shining.map(Into::into).collect();
        LightTable::build(&sources, &geometry, &Arc::default()).reach(&geometry)
    };
    for slots in [&[][..], &[0], &[1]] {
        let reach = reach(slots);
        assert_eq!(reach.lit, reach.everything, "{slots:?}");
    }
    assert_alike(reach(&[0, 1]).lit, around(&[Vec3::ZERO]));
    assert_eq!(reach(&[1, 0]), reach(&[0, 1]));
}

#[test]
fn far_lamps_are_found_beside_any_number_of_shapes() {
    let mut random = Random::new(3);
    let plain: Vec<Vec3> = (0..20_000).map(|_| 20.0 * random.in_cube()).collect();
    let lamp = Vec3::new(300.0, 0.0, 0.0);
    assert_alike(spheres(&plain, &[lamp]).reach.lit, around(&plain));
}

/// The bounds of the shapes that are not left out are, bit by bit, those of a list of these shapes alone.
#[test]
fn bounds_without_shapes_are_those_of_the_others() {
    let mut random = Random::new(8);
    for count in [0, 1, 3, 40, 5000] {
        let shape = |random: &mut Random| {
            let primitive = match random.next_u32() % 4 {
                0 => square_mesh(),
                1 => Primitive::Rectangle,
                _ => Primitive::Sphere,
            };
            let turn = Quat::from_axis_angle(random.direction(), random.unit());
            let place = Affine3A::from_scale_rotation_translation(
                Vec3::splat(0.2 + random.unit()),
                turn,
                20.0 * random.in_cube(),
            );
            Instance::new(primitive, place).expect("it can be inverted")
        };
        let shapes: Vec<Instance> = (0..count).map(|_| shape(&mut random)).collect();
        let group = Arc::new(Tlas::build(
            (0..5).map(|_| shape(&mut random)).collect(),
            SplitMethod::Sah,
        ));
        let placements = (0..count.min(7)).map(|_| Placement::new(0, &at(5.0 * random.in_cube())).expect("a place"));
        let geometry = Tlas::with_placements(shapes, vec![group], placements.collect(), SplitMethod::Sah);
        let numbers = 0..(geometry.instances().len() + geometry.placements().len()) as u32;
        // What is left out from outside to inside.
        let mut left_out: Vec<u32> = Vec::new();
        for _ in 0..30 {
            let others = numbers.clone().filter(|number| left_out.binary_search(number).is_err());
            let boxes: Vec<(u32, Aabb)> = others
                .filter_map(|number| Some((number, geometry.bounds_of(number)?)))
                .collect();
            let expected = boxes.iter().fold(Aabb::EMPTY, |all, (_, bounds)| all.union(*bounds));
            assert_eq!(geometry.bounds_without(&left_out), expected, "{count} {left_out:?}");
            let outermost = boxes.iter().find(|(_, bounds)| bounds.max.cmpge(expected.max).any());
            left_out.extend(outermost.map(|(number, _)| *number));
            left_out.sort_unstable();
        }
    }
}

/// Lamps that are far from a sphere of radius 1.
fn far_lamps() -> Vec<(&'static str, RenderScene)> {
    let lamp = |primitive: Primitive, to_world: Affine3A| {
        let mut scene = SceneBuilder::default();
        scene.add(Primitive::Sphere, Affine3A::IDENTITY, black(), None);
        scene.add(primitive, to_world, black(), Some(Rgb::ONE));
        scene.build()
    };
    // Their normal is +z, and turned about x by so much.
    let facing = |angle: f32| {
        let turn = Quat::from_rotation_x(angle);
        Affine3A::from_scale_rotation_translation(Vec3::splat(0.4), turn, Vec3::new(0.0, 0.0, -6.0))
    };
    let bent = leaning_triangle([Vec3::ZERO, Vec3::X, Vec3::Y]);
    vec![
        ("towards it", lamp(Primitive::Rectangle, facing(0.3))),
        ("along it", lamp(Primitive::Rectangle, facing(0.5 * PI))),
        ("partly away", lamp(Primitive::Disk, facing(0.5 * PI + 0.1))),
        ("away", lamp(Primitive::Rectangle, facing(PI))),
        ("two-sided, towards it", lamp(bent.clone(), facing(0.2))),
        ("two-sided, away", lamp(bent, facing(PI - 0.4))),
        ("mesh", lamp(square_of_three_triangles(), facing(-0.6))),
        ("sphere", lamp(Primitive::Sphere, facing(0.0))),
    ]
}

/// Cells of directions on either side of where a density jumps: at an angle with an axis.
struct Cells {
    frame: Frame,
    /// The cosine of the angle.
    edge: f32,
}

/// The cells of each side along the cosine and around the axis.
const CELLS: usize = 12;

impl Cells {
    fn of(&self, dir: Vec3) -> usize {
        let dir = self.frame.to_local(dir);
        let (side, part) = match dir.z >= self.edge {
            true => (0, (dir.z - self.edge) / (1.0 - self.edge)),
            false => (1, (dir.z + 1.0) / (self.edge + 1.0)),
        };
        let around = (dir.y.atan2(dir.x) / (2.0 * PI)).rem_euclid(1.0);
        let [row, column] = [part, around].map(|part| ((part * CELLS as f32) as usize).min(CELLS - 1));
        (side * CELLS + row) * CELLS + column
    }

    /// The integral of a density over each cell.
    fn integrals(&self, density: impl Fn(Vec3) -> f32) -> Vec<f64> {
        const STEPS: u32 = 32;
        let integral = |cell: usize| {
            let [low, high] = [[self.edge, 1.0], [-1.0, self.edge]][cell / (CELLS * CELLS)];
            let corner = Vec2::new((cell / CELLS % CELLS) as f32, (cell % CELLS) as f32);
            let values = (0..STEPS * STEPS).map(|step| {
                let step = Vec2::new((step % STEPS) as f32, (step / STEPS) as f32) + 0.5;
                let part = (corner + step / STEPS as f32) / CELLS as f32;
                let z = low + (high - low) * part.x;
                let (sin, cos) = (2.0 * PI * part.y).sin_cos();
                let local = ((1.0 - z * z).sqrt() * Vec2::new(cos, sin)).extend(z);
                f64::from(density(self.frame.to_world(local).normalize()))
            });
            let solid_angle = f64::from(2.0 * PI * (high - low)) / (CELLS * CELLS) as f64;
            solid_angle * values.sum::<f64>() / f64::from(STEPS * STEPS)
        };
        (0..2 * CELLS * CELLS).map(integral).collect()
    }
}

/// Directions from a point of a lamp follow the density that other techniques are told.
#[test]
fn aimed_rays_follow_their_density() {
    const COUNT: u32 = 1 << 16;
    let (mut results, mut aimed) = (Vec::new(), 0);
    for (name, scene) in far_lamps() {
        let lights = &scene.lights;
        for place in [Vec2::new(0.3, 0.6), Vec2::new(0.9, 0.2), Vec2::new(0.5, 0.5)] {
            let ray = |index: u32| {
                let sampler = Sampler::new(SequenceKind::Independent, UVec2::new(4, 2), index, 6);
                lights.sample_emission(&scene.reach, 0.5, place, sampler.at_2d(0))
            };
            let Some(EmittedRay {
                light,
                start: Start::Surface(hit),
                ..
            }) = (0..1000).find_map(ray)
            else {
                panic!("{name}: no ray")
            };
            let is_two_sided = name.starts_with("two-sided");
            let density = |dir: Vec3| match is_two_sided || dir.dot(hit.normal) > 0.0 {
                true => lights.emission_pdf_of_hit(light, &scene.reach, &hit, dir).next,
                false => 0.0,
            };
            let axis = -hit.position.normalize();
            let sine = scene.reach.lit.radius / hit.position.length();
            let cells = Cells {
                frame: Frame::from_normal(axis),
                edge: (1.0 - sine * sine).max(0.0).sqrt(),
            };
            let mut expected = cells.integrals(density);
            let integral: f64 = expected.iter().sum();
            // What is aimed at directions in which the lamp does not shine is lost.
            let is_whole = !["along it", "partly away", "sphere"].contains(&name);
            assert!(
                integral < 1.0 + 1e-3 && (!is_whole || integral > 1.0 - 1e-3),
                "{name}: {integral}"
            );
            let of_axis = lights.emission_pdf_of_hit(light, &scene.reach, &hit, axis).next;
            aimed += u32::from(of_axis > 1.0);
            expected.push((1.0 - integral).max(0.0));
            let mut counted = vec![0.0; expected.len()];
            for index in 0..COUNT {
                counted[ray(index).map_or(expected.len() - 1, |ray| cells.of(ray.dir))] += 1.0;
            }
            expected.iter_mut().for_each(|share| *share *= f64::from(COUNT));
            let p = chi_squared_p(&counted, &expected);
            results.push((format!("{name} from {}", hit.position), p));
        }
    }
    assert!(aimed >= 18, "{aimed} places aim");
    assert_all_plausible(&results);
}
