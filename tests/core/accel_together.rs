//! Rays that are walked together get the answers that they get alone.

use std::sync::Arc;

use crate::random::Random;
use crate::wavy_sphere::wavy_sphere;
use glam::{Affine3A, Quat, Vec3};
use sunroom::accel::{Blas, Hit, Instance, Obstacle, Placement, Primitive, RayLanes, SplitMethod, Tlas};
use sunroom::math::Ray;
use sunroom::math::lanes::LANES;

fn transform(random: &mut Random, size: f32) -> Affine3A {
    let scale = size * (0.5 + Vec3::new(random.unit(), random.unit(), random.unit()));
    let rotation = Quat::from_axis_angle(random.direction(), 6.0 * random.unit());
    Affine3A::from_scale_rotation_translation(scale, rotation, 2.0 * random.in_cube())
}

/// Every kind of shape, the mesh of 1800 triangles among them.
fn shapes(count: usize, size: f32, random: &mut Random) -> Vec<Instance> {
    let mesh = Primitive::Mesh(Arc::new(Blas::build(Arc::new(wavy_sphere(30)), SplitMethod::Sah)));
    let kinds = [
        mesh,
        Primitive::Sphere,
        Primitive::Rectangle,
        Primitive::Disk,
        Primitive::Cylinder,
    ];
    let kinds = kinds.iter().cycle().take(count);
    kinds
        .map(|kind| Instance::new(kind.clone(), transform(random, size)).unwrap())
        .collect()
}

/// Through the middle and past it, some short, some that begin later, along axes, or no rays at all.
fn ray(random: &mut Random) -> Ray {
    let origin = 3.0 * random.in_cube();
    let mut ray = Ray::new(origin, random.in_cube() - origin);
    match random.next_u32() % 8 {
        0 => ray.t_max = random.unit(),
        1 => ray.dir = Vec3::new(0.0, -0.0, -1.0),
        2 => ray.dir = random.direction(),
        3 if random.unit() < 0.2 => ray.dir = Vec3::ZERO,
        4 if random.unit() < 0.2 => ray.origin.x = f32::NAN,
        5 if random.unit() < 0.2 => ray.t_max = 0.0,
        6 => ray.t_min = 0.9,
        _ => {}
    }
    ray
}

fn check<const N: usize>(name: &str, scene: &Tlas, random: &mut Random) {
    let (mut met, mut missed) = (0, 0);
    for round in 0..400 {
        let rays: [Ray; N] = std::array::from_fn(|_| ray(random));
        let active = if round % 3 == 0 { random.next_u32() } else { u32::MAX };
        let is_active = |index: usize| active >> index & 1 == 1;
        let hits = scene.intersect_interleaved(&rays, active);
        let occluded = scene.occluded_interleaved(&rays, active);
        for (index, ray) in rays.iter().enumerate() {
            let alone = scene.intersect(ray).filter(|_| is_active(index));
            assert_eq!(hits[index], alone, "{name}: {ray:?}");
            let alone = is_active(index) && scene.occluded(ray);
            assert_eq!(occluded >> index & 1 == 1, alone, "{name}: {ray:?}");
            met += usize::from(alone);
            missed += usize::from(!alone);
        }
        assert_eq!(u64::from(occluded) >> N, 0);
    }
    assert!(met > 40 && missed > 40, "{name}: {met} of {}", met + missed);
}

/// But for rounding: spheres and rectangles are met in single precision.
fn agree(a: Option<Hit>, b: Option<Hit>) -> bool {
    match (a, b) {
        (None, None) => true,
        (Some(a), Some(b)) => {
            let near = |a: f32, b: f32| (a - b).abs() <= 1e-4 * (1.0 + b.abs());
            (a.instance, a.member, a.primitive) == (b.instance, b.member, b.primitive)
                && near(a.t, b.t)
                && near(a.u, b.u)
                && near(a.v, b.v)
        }
        _ => false,
    }
}

/// Walked as a packet, and in lanes.
fn check_packets(name: &str, scene: &Tlas, random: &mut Random) {
    let (mut met, mut missed, mut strays) = (0, 0, 0);
    for round in 0..600 {
        let one = ray(random);
        let rays: [Ray; LANES] = std::array::from_fn(|_| match round % 3 {
            0 => ray(random),
            1 => Ray {
                dir: one.dir + 0.01 * random.in_cube(),
                ..one
            },
            _ => Ray {
                origin: one.origin + 0.01 * random.in_cube(),
                ..one
            },
        });
        let active = if round % 5 == 0 {
            random.next_u32() & 0xffff
        } else {
            0xffff
        };
        let lanes = RayLanes::of(&rays);
        let as_packet = (
            scene.intersect_packet(&lanes, active),
            scene.occluded_packet(&lanes, active),
        );
        let in_lanes = (
            scene.intersect_lanes(&lanes, active),
            scene.occluded_lanes(&lanes, active),
        );
        for (hits, occluded) in [as_packet, in_lanes] {
            assert_eq!(occluded & !active, 0);
            for (lane, ray) in rays.iter().enumerate() {
                if active >> lane & 1 == 0 {
                    assert_eq!(hits[lane], None);
                    continue;
                }
                let is_occluded = scene.occluded(ray);
                met += usize::from(is_occluded);
                missed += usize::from(!is_occluded);
                let is_alike = agree(hits[lane], scene.intersect(ray)) && (occluded >> lane & 1 == 1) == is_occluded;
                strays += usize::from(!is_alike);
            }
        }
    }
    assert!(met > 100 && missed > 100, "{name}: {met} of {}", met + missed);
    // At rims, and where shapes pass through each other, rounding decides.
    assert!(strays <= met / 500, "{name}: {strays} of {met} differ");
}

#[test]
fn packets_and_lanes_meet_what_their_rays_meet() {
    let random = &mut Random::new(11);
    for method in [SplitMethod::Sah, SplitMethod::Linear] {
        for (count, size) in [(1, 0.4), (5, 0.4), (60, 0.4), (400, 0.1)] {
            let scene = Tlas::build(shapes(count, size, random), method);
            check_packets(&format!("{count} shapes, {method:?}"), &scene, random);
        }
    }
    let large = Primitive::Mesh(Arc::new(Blas::build(Arc::new(wavy_sphere(150)), SplitMethod::Sah)));
    let large = Instance::new(large, transform(random, 0.8)).unwrap();
    check_packets("45,000 triangles", &Tlas::build(vec![large], SplitMethod::Sah), random);
    let groups = vec![Arc::new(Tlas::build(shapes(12, 0.3, random), SplitMethod::Sah))];
    let placed = (0..30)
        .map(|_| Placement::new(0, &transform(random, 0.2)).unwrap())
        .collect();
    let scene = Tlas::with_placements(shapes(7, 0.2, random), groups, placed, SplitMethod::Sah);
    check_packets("groups", &scene, random);
    let nothing = Tlas::build(Vec::new(), SplitMethod::Sah);
    let lanes = RayLanes::of(&[(); LANES].map(|()| Ray::new(Vec3::ZERO, random.direction())));
    assert_eq!(nothing.intersect_packet(&lanes, 0xffff), [None; LANES]);
}

#[test]
fn rays_together_get_the_answers_they_get_alone() {
    let random = &mut Random::new(5);
    for method in [SplitMethod::Sah, SplitMethod::Median, SplitMethod::Linear] {
        for count in [1, 5, 60] {
            let scene = Tlas::build(shapes(count, 0.4, random), method);
            check::<16>(&format!("{count} shapes, {method:?}"), &scene, random);
        }
        let groups = vec![
            Arc::new(Tlas::build(shapes(12, 0.3, random), method)),
            Arc::new(Tlas::build(shapes(1, 0.5, random), SplitMethod::Sah)),
        ];
        let placed = (0..30)
            .map(|i| Placement::new(i % 2, &transform(random, 0.2)).unwrap())
            .collect();
        let scene = Tlas::with_placements(shapes(7, 0.2, random), groups, placed, SplitMethod::Sah);
        check::<5>(&format!("groups, {method:?}"), &scene, random);
        check::<32>(&format!("groups, {method:?}"), &scene, random);
    }
    assert_eq!(
        Tlas::build(Vec::new(), SplitMethod::Sah).intersect_interleaved(&[Ray::new(Vec3::ZERO, Vec3::X); 3], 7),
        [None; 3]
    );
}

/// Every third shape is clear. The scene of all shapes is asked, and beside it the scene of those that are not.
#[test]
fn opaque_shapes_are_found_behind_clear_ones() {
    let is_clear = |shape: usize| shape % 3 == 1;
    let opaque = |shapes: &[Instance], first: usize| -> Vec<Instance> {
        let numbered = (first..).zip(shapes).filter(|(number, _)| !is_clear(*number));
        numbered.map(|(_, shape)| shape.clone()).collect()
    };
    let random = &mut Random::new(17);
    let mut scenes = Vec::new();
    for (count, size) in [(5, 0.8), (20, 0.4), (60, 0.2), (400, 0.1)] {
        let all = shapes(count, size, random);
        let [all, left] = [all.clone(), opaque(&all, 0)].map(|shapes| Tlas::build(shapes, SplitMethod::Sah));
        scenes.push((format!("{count} shapes"), all, left));
    }
    // Spheres next to each other, which are taken together.
    let row: Vec<Instance> = (0..60)
        .map(|k| {
            let place = Affine3A::from_scale_rotation_translation(
                Vec3::splat(0.15),
                Quat::IDENTITY,
                Vec3::new(0.3 * (k % 10) as f32 - 1.5, 0.3 * (k / 10) as f32 - 0.9, 0.0),
            );
            Instance::new(Primitive::Sphere, place).unwrap()
        })
        .collect();
    let left = opaque(&row, 0);
    let [all, left] = [row, left].map(|shapes| Tlas::build(shapes, SplitMethod::Sah));
    scenes.push(("a row".to_string(), all, left));
    let (alone, members) = (shapes(7, 0.2, random), shapes(12, 0.3, random));
    let placed: Vec<_> = (0..9)
        .map(|_| Placement::new(0, &transform(random, 0.2)).unwrap())
        .collect();
    let with = |alone: Vec<Instance>, members: Vec<Instance>| {
        let groups = vec![Arc::new(Tlas::build(members, SplitMethod::Sah))];
        Tlas::with_placements(alone, groups, placed.clone(), SplitMethod::Sah)
    };
    let left = with(opaque(&alone, 0), opaque(&members, alone.len()));
    scenes.push(("groups".to_string(), with(alone, members), left));

    for (name, all, left) in &scenes {
        let (mut counts, mut given_up) = ([0; 3], 0);
        for _ in 0..600 {
            let rays: [Ray; LANES] = std::array::from_fn(|_| ray(random));
            let active = random.next_u32() & 0xffff;
            let lanes = RayLanes::of(&rays);
            let together = [
                all.obstacles(&lanes, active, is_clear),
                all.obstacles_packet(&lanes, active, is_clear),
            ];
            for (lane, ray) in rays.iter().enumerate() {
                let expected = match (left.occluded(ray), all.occluded(ray)) {
                    (true, _) => Obstacle::Opaque,
                    (false, true) => Obstacle::Clear,
                    (false, false) => Obstacle::Nothing,
                };
                counts[expected as usize] += 1;
                let alone = all.obstacle(ray, is_clear);
                // Behind many clear shapes, and where rounding decides.
                given_up += usize::from(alone != expected);
                for obstacles in together {
                    if active >> lane & 1 == 0 {
                        assert_eq!((obstacles.opaque | obstacles.clear) >> lane & 1, 0, "{name}");
                        continue;
                    }
                    let found = match (obstacles.opaque >> lane & 1, obstacles.only_clear() >> lane & 1) {
                        (1, 0) => Obstacle::Opaque,
                        (0, 1) => Obstacle::Clear,
                        (0, 0) => Obstacle::Nothing,
                        both => panic!("{name}: {both:?}"),
                    };
                    given_up += usize::from(found != expected);
                }
            }
        }
        assert!(counts.iter().all(|&count| count > 200), "{name}: {counts:?}");
        assert!(given_up < counts[2] / 100, "{name}: {given_up} of {counts:?}");
    }
}
