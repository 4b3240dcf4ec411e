//! Sixteen rays at once against the same rays one by one, in scenes with few shapes and with many.

use glam::{Affine3A, Quat, Vec3};
use sunroom::accel::{Hit, Instance, Primitive, RayLanes, SplitMethod, Tlas};
use sunroom::math::lanes::LANES;
use sunroom::math::{Ray, offset_origin};

use crate::support::triangle_mesh;

/// A low-discrepancy sequence in the unit cube (Roberts).
fn numbers(k: usize) -> Vec3 {
    let part = |factor: f64| (k as f64 * factor).fract() as f32;
    Vec3::new(part(0.819_172_513), part(0.671_043_607), part(0.549_700_478))
}

fn direction(k: usize) -> Vec3 {
    (numbers(k) - Vec3::splat(0.5)).try_normalize().unwrap_or(Vec3::X)
}

fn cube() -> Primitive {
    triangle_mesh(cube_triangles())
}

fn cube_triangles() -> impl Iterator<Item = [Vec3; 3]> {
    let square = |axis: usize, side: f32| {
        let mut axes = [Vec3::X, Vec3::Y, Vec3::Z];
        axes.rotate_left(axis);
        let [normal, u, v] = axes;
        let at = |a: f32, b: f32| side * normal + a * u + b * v;
        [
            [at(-1.0, -1.0), at(1.0, -1.0), at(1.0, 1.0)],
            [at(-1.0, -1.0), at(1.0, 1.0), at(-1.0, 1.0)],
        ]
    };
    (0..3)
        .flat_map(move |axis| [square(axis, -1.0), square(axis, 1.0)])
        .flatten()
}

/// A sheet of two triangles, a leaning box, one without a lid and one with a corner pulled out.
fn folded() -> [Primitive; 4] {
    let lean = |p: Vec3| Vec3::new(0.8 * p.x + 0.3 * p.y, p.y - 0.2 * p.z, 0.1 * p.x - 0.7 * p.z) + Vec3::splat(0.2);
    let pull = |p: Vec3| if p == Vec3::ONE { 1.2 * p } else { p };
    [
        triangle_mesh(cube_triangles().map(|corners| corners.map(lean)).take(2)),
        triangle_mesh(cube_triangles().map(|corners| corners.map(lean))),
        triangle_mesh(cube_triangles().skip(2)),
        triangle_mesh(cube_triangles().map(|corners| corners.map(pull))),
    ]
}

/// A mesh that is too large to be tested as a whole.
fn soup() -> Primitive {
    triangle_mesh((0..60).map(|k| {
        let middle = 2.0 * numbers(k) - Vec3::ONE;
        [1, 2, 3].map(|corner| middle + 0.4 * direction(100 + 3 * k + corner))
    }))
}

fn scene(copies: usize, method: SplitMethod) -> Tlas {
    let [sheet, leaning, open, pulled] = folded();
    let kinds = [
        Primitive::Rectangle,
        Primitive::Sphere,
        Primitive::Disk,
        Primitive::Cylinder,
        cube(),
        soup(),
        sheet,
        leaning,
        open,
        pulled,
    ];
    let instances = (0..copies * kinds.len()).map(|k| {
        let turned = Quat::from_axis_angle(direction(k + 17), k as f32);
        let size = Vec3::splat(0.3) + 0.5 * numbers(k + 31);
        let placed = Affine3A::from_scale_rotation_translation(size, turned, 4.0 * numbers(k + 1) - Vec3::splat(2.0));
        Instance::new(kinds[k % kinds.len()].clone(), placed).expect("an invertible transform")
    });
    Tlas::build(instances.collect(), method)
}

/// Many round and flat shapes, which are taken together, and two meshes. The same as a list, in which each shape is
/// tested alone.
fn crowd(is_round: bool) -> [Tlas; 2] {
    let kinds = [Primitive::Sphere, Primitive::Rectangle, Primitive::Disk];
    let mut instances: Vec<Instance> = (0..120)
        .map(|k| {
            let turned = Quat::from_axis_angle(direction(k + 17), k as f32);
            let size = match is_round {
                true => Vec3::splat(0.1 + 0.2 * numbers(k).x),
                false => Vec3::splat(0.1) + 0.2 * numbers(k + 31),
            };
            let at = 4.0 * numbers(k + 1) - Vec3::splat(2.0);
            let kind = if is_round {
                Primitive::Sphere
            } else {
                kinds[k % 3].clone()
            };
            Instance::new(kind, Affine3A::from_scale_rotation_translation(size, turned, at)).expect("invertible")
        })
        .collect();
    let ground = Affine3A::from_scale_rotation_translation(Vec3::splat(30.0), Quat::IDENTITY, 2.5 * Vec3::NEG_Z);
    let shapes = [
        (Primitive::Rectangle, ground),
        (cube(), Affine3A::from_scale(Vec3::splat(0.3))),
    ];
    instances.extend(shapes.map(|(primitive, placed)| Instance::new(primitive, placed).expect("invertible")));
    [SplitMethod::Sah, SplitMethod::Linear].map(|method| Tlas::build(instances.clone(), method))
}

/// Rays from within and without, some of them along axes, some short, some that begin later.
fn ray(k: usize) -> Ray {
    let mut dir = direction(2 * k + 5);
    if k.is_multiple_of(7) {
        dir = [Vec3::X, Vec3::NEG_Y, Vec3::Z][k % 3];
    }
    Ray {
        origin: 6.0 * numbers(k) - Vec3::splat(3.0),
        dir: dir * [1.0, 0.2, 3.0][k % 3],
        t_min: if k.is_multiple_of(3) { 0.8 } else { 0.0 },
        t_max: if k.is_multiple_of(5) { 1.0 } else { f32::INFINITY },
    }
}

fn agree(a: Option<Hit>, b: Option<Hit>) -> bool {
    match (a, b) {
        (None, None) => true,
        (Some(a), Some(b)) => {
            let near = |a: f32, b: f32| (a - b).abs() < 1e-4;
            (a.instance, a.member, a.primitive) == (b.instance, b.member, b.primitive)
                && (a.t - b.t).abs() < 1e-5 * (1.0 + b.t)
                && near(a.u, b.u)
                && near(a.v, b.v)
        }
        _ => false,
    }
}

#[test]
fn hits_are_those_of_one_ray() {
    // Two thousand are too many for a small scene.
    for copies in [2, 6, 40, 210] {
        compare(&scene(copies, SplitMethod::Sah), &scene(copies, SplitMethod::Linear));
    }
}

#[test]
fn crowds_are_met_as_their_members_alone() {
    for is_round in [true, false] {
        let [together, alone] = crowd(is_round);
        compare(&together, &alone);
        // And one ray at a time.
        let strays = (0..20_000)
            .map(ray)
            .filter(|ray| {
                let hit = together.intersect(ray);
                !agree(hit, alone.intersect(ray)) || together.occluded(ray) != hit.is_some()
            })
            .count();
        assert!(strays < 8, "{strays} differ");
    }
}

/// Rays in lanes in the one, one by one in the other.
fn compare(scene: &Tlas, expected: &Tlas) {
    let (mut met, mut strays) = (0, 0);
    for start in (0..40_000).step_by(LANES) {
        let rays: [Ray; LANES] = std::array::from_fn(|lane| ray(start + lane));
        let active = if start.is_multiple_of(64) { 0x5a3c } else { 0xffff };
        let rays_in_lanes = &RayLanes::of(&rays);
        // Packets are for rays that are alike, but right for all.
        let (hits, occluded) = match start / LANES % 2 {
            0 => (
                scene.intersect_lanes(rays_in_lanes, active),
                scene.occluded_lanes(rays_in_lanes, active),
            ),
            _ => (
                scene.intersect_packet(rays_in_lanes, active),
                scene.occluded_packet(rays_in_lanes, active),
            ),
        };
        assert_eq!(occluded & !active, 0);
        for (lane, ray) in rays.iter().enumerate() {
            if active >> lane & 1 == 0 {
                assert_eq!(hits[lane], None);
                continue;
            }
            met += usize::from(hits[lane].is_some());
            // Rounding decides at rims and where two shapes pass through each other.
            let is_alike =
                agree(hits[lane], expected.intersect(ray)) && (occluded >> lane & 1 == 1) == expected.occluded(ray);
            strays += usize::from(!is_alike);
        }
    }
    assert!(met > 3000, "{met}");
    assert!(strays < 8, "{strays} of {met} differ");
}

/// From inside of a cube no ray gets out, though it is aimed at an edge or a diagonal.
#[test]
fn no_ray_slips_through_an_edge() {
    let turned = Quat::from_axis_angle(Vec3::new(1.0, 2.0, 3.0).normalize(), 0.7);
    let placed = Affine3A::from_scale_rotation_translation(Vec3::new(1.0, 0.3, 2.0), turned, Vec3::new(5.0, -3.0, 1.0));
    let scene = Tlas::build(
        vec![Instance::new(cube(), placed).expect("an invertible transform")],
        SplitMethod::Sah,
    );
    for start in (0..100_000).step_by(LANES) {
        let rays: [Ray; LANES] = std::array::from_fn(|lane| {
            let k = start + lane;
            let from = 1.8 * numbers(k) - Vec3::splat(0.9);
            let mut to = (2.0 * numbers(k + 7) - Vec3::ONE).signum();
            let along = 2.0 * numbers(k + 3).x - 1.0;
            match k % 2 {
                0 => to[k / 2 % 3] = along,
                _ => (to.x, to.y) = (along, along),
            }
            let [from, to] = [from, to].map(|p| placed.transform_point3(p));
            Ray::new(from, to - from)
        });
        let hits = scene.intersect_lanes(&RayLanes::of(&rays), 0xffff);
        assert!(hits.iter().all(Option::is_some), "{hits:?}");
        assert_eq!(scene.occluded_lanes(&RayLanes::of(&rays), 0xffff), 0xffff);
    }
}

/// Distances stay sharp for boards, sheets and crumbs, and for what is far away.
#[test]
fn small_and_thin_shapes_are_met_where_they_are() {
    for (size, distance) in [
        (Vec3::splat(1.0), 5.0),
        (Vec3::new(1.0, 0.02, 1.0), 5.0),
        (Vec3::new(1.0, 1e-3, 1.0), 5.0),
        (Vec3::splat(5e-3), 5.0),
        (Vec3::new(1.0, 1.0, 1.0), 1000.0),
    ] {
        let turned = Quat::from_axis_angle(Vec3::new(1.0, 2.0, 3.0).normalize(), 0.7);
        let placed = Affine3A::from_scale_rotation_translation(0.5 * size, turned, Vec3::new(0.5, -0.3, 0.1));
        // The scale once in the transform, once in the mesh.
        let whole =
            triangle_mesh(cube_triangles().map(|corners| corners.map(|corner| placed.transform_point3(corner))));
        for (primitive, transform) in [(cube(), placed), (whole, Affine3A::IDENTITY)] {
            let scene = Tlas::build(
                vec![Instance::new(primitive, transform).expect("an invertible transform")],
                SplitMethod::Sah,
            );
            let (mut met, mut strays) = (0, 0);
            for start in (0..4096).step_by(LANES) {
                let rays: [Ray; LANES] = std::array::from_fn(|lane| {
                    let k = start + lane;
                    let to = placed.transform_point3(1.8 * numbers(k) - Vec3::splat(0.9));
                    let from = distance * direction(3 * k + 1).normalize();
                    Ray::new(from, (to - from).normalize())
                });
                let hits = scene.intersect_lanes(&RayLanes::of(&rays), 0xffff);
                for (ray, hit) in rays.iter().zip(hits) {
                    let expected = scene.intersect(ray);
                    met += usize::from(expected.is_some());
                    let is_near = match (hit, expected) {
                        (Some(hit), Some(expected)) => {
                            // A few roundings of the distance, more where a face is met at a grazing angle.
                            (hit.t - expected.t).abs() <= 1e-5 * distance
                        }
                        (None, None) => true,
                        _ => false,
                    };
                    strays += usize::from(!is_near);
                }
            }
            assert!(met > 3500, "{met} of {size} at {distance}");
            assert!(strays * 200 < met, "{strays} of {met} differ, {size} at {distance}");
        }
    }
}

/// A box with a corner at the origin, where positions are known better than the box's other faces let it be tested.
#[test]
fn the_corner_at_the_origin_does_not_shadow_itself() {
    for size in [1.0, 41.0, 82.0, 1000.1] {
        let corner_box = triangle_mesh(cube_triangles().map(|corners| corners.map(|p| 0.5 * size * (p + Vec3::ONE))));
        let instance = Instance::new(corner_box, Affine3A::IDENTITY).expect("an invertible transform");
        let scene = Tlas::build(vec![instance], SplitMethod::Sah);
        for start in (0..4096).step_by(LANES) {
            let rays: [Ray; LANES] = std::array::from_fn(|lane| {
                let k = start + lane;
                let to = size * 0.02 * numbers(k);
                Ray::new(to - size * (0.05 * numbers(k + 9) + Vec3::splat(0.03)), Vec3::ONE)
            });
            let mut leaving = RayLanes::NOWHERE;
            let mut active = 0;
            for (lane, hit) in scene.intersect_lanes(&RayLanes::of(&rays), 0xffff).iter().enumerate() {
                let Some(hit) = hit else { continue };
                let point = scene.surface(&rays[lane], hit);
                let dir = direction(7 * start + 5 * lane + 2).normalize();
                let normal = -point.geometric_normal * point.geometric_normal.dot(rays[lane].dir).signum();
                let dir = if dir.dot(normal) < 0.0 { -dir } else { dir };
                leaving.set(
                    lane,
                    &Ray::new(offset_origin(point.position, point.error, normal, dir), dir),
                );
                active |= 1 << lane;
            }
            assert_ne!(active, 0);
            let next = scene.intersect_lanes(&leaving, active);
            assert!(next.iter().all(Option::is_none), "{size}: {next:?}");
            assert_eq!(scene.occluded_lanes(&leaving, active), 0, "{size}");
        }
    }
}

/// What is no ray meets nothing, wherever it begins.
#[test]
fn what_is_no_ray_meets_nothing() {
    let kinds = [Primitive::Sphere, Primitive::Rectangle, cube(), soup()];
    for kind in kinds {
        for copies in [1, 100] {
            let shape = Instance::new(kind.clone(), Affine3A::IDENTITY).expect("an invertible transform");
            let scene = Tlas::build(vec![shape; copies], SplitMethod::Sah);
            let within = Vec3::new(-0.5, 0.0, 0.1);
            let ray = |origin, dir, t_max| Ray {
                t_max,
                ..Ray::new(origin, dir)
            };
            let endless = f32::INFINITY;
            let none = [
                ray(within, Vec3::NAN, endless),
                ray(within, Vec3::new(1.0, f32::NAN, 0.0), endless),
                ray(within, Vec3::ZERO, endless),
                ray(within, f32::INFINITY * Vec3::X, endless),
                ray(Vec3::NAN, Vec3::X, endless),
                ray(Vec3::new(0.0, f32::INFINITY, 0.0), Vec3::X, endless),
                ray(within, Vec3::X, 0.0),
                ray(within, Vec3::X, -1.0),
                ray(within, Vec3::X, f32::NAN),
            ];
            let mut rays = RayLanes::of(&std::array::from_fn::<Ray, LANES, _>(|lane| none[lane % none.len()]));
            // And a true one among them.
            rays.set(3, &ray(Vec3::new(0.1, 0.2, 3.0), -Vec3::Z, endless));
            let expected = scene.intersect(&rays.get(3)).is_some();
            for hits in [
                scene.intersect_lanes(&rays, 0xffff),
                scene.intersect_packet(&rays, 0xffff),
            ] {
                let met: Vec<usize> = (0..LANES).filter(|&lane| hits[lane].is_some()).collect();
                assert_eq!(met, if expected { vec![3] } else { vec![] }, "{copies}");
            }
            for occluded in [
                scene.occluded_lanes(&rays, 0xffff),
                scene.occluded_packet(&rays, 0xffff),
            ] {
                assert_eq!(occluded, u32::from(expected) << 3, "{copies}");
            }
        }
    }
}

/// What leaves a box or a sheet does not meet it there, on either side.
#[test]
fn surfaces_do_not_meet_the_rays_that_leave_them() {
    let [sheet, leaning, ..] = folded();
    for (primitive, is_closed) in [(cube(), true), (leaning, true), (sheet, false)] {
        for (size, at) in [
            (Vec3::ONE, Vec3::ZERO),
            (Vec3::new(1.0, 1e-3, 1.0), Vec3::new(3.0, -1.0, 2.0)),
            (Vec3::splat(0.01), Vec3::new(-200.0, 0.0, 100.0)),
        ] {
            let turned = Quat::from_axis_angle(Vec3::new(1.0, 2.0, 3.0).normalize(), 0.7);
            let placed = Affine3A::from_scale_rotation_translation(size, turned, at);
            let instance = Instance::new(primitive.clone(), placed).expect("an invertible transform");
            let scene = Tlas::build(vec![instance], SplitMethod::Sah);
            let (mut met, mut lost) = (0, 0);
            for start in (0..16_384).step_by(LANES) {
                let rays: [Ray; LANES] = std::array::from_fn(|lane| {
                    let k = start + lane;
                    let to = placed.transform_point3(2.0 * numbers(k) - Vec3::ONE);
                    let from = at + 3.0 * direction(3 * k + 1).normalize();
                    Ray::new(from, to - from)
                });
                let hits = scene.intersect_lanes(&RayLanes::of(&rays), 0xffff);
                let mut leaving = RayLanes::NOWHERE;
                let (mut active, mut outward, mut faces) = (0u32, 0, [0; LANES]);
                for (lane, hit) in hits.iter().enumerate() {
                    let Some(hit) = hit else { continue };
                    let point = scene.surface(&rays[lane], hit);
                    let normal = point.geometric_normal * -point.geometric_normal.dot(rays[lane].dir).signum();
                    let dir = direction(7 * start + 5 * lane + 2).normalize();
                    let origin = offset_origin(point.position, point.error, point.geometric_normal, dir);
                    leaving.set(lane, &Ray::new(origin, dir));
                    faces[lane] = hit.primitive / 2;
                    active |= 1 << lane;
                    outward |= u32::from(dir.dot(normal) > 0.0) << lane;
                }
                met += active.count_ones();
                let next = scene.intersect_lanes(&leaving, active);
                let occluded = scene.occluded_lanes(&leaving, active);
                for (lane, hit) in next.iter().enumerate().filter(|&(lane, _)| active >> lane & 1 == 1) {
                    assert_eq!(hit.is_some(), occluded >> lane & 1 == 1, "{size} {at}");
                    if !is_closed || outward >> lane & 1 == 1 {
                        assert!(hit.is_none(), "{size} {at} {hit:?}");
                    } else {
                        lost += usize::from(hit.is_none());
                    }
                    // A face is two triangles.
                    let is_another = hit.is_none_or(|hit| hit.primitive / 2 != faces[lane]);
                    assert!(is_another, "{size} {at} the same face");
                }
            }
            assert!(met > 3000, "{met} of {size} at {at}");
            // Next to an edge a ray may begin on the far side of the other face.
            assert!(lost < 100, "{lost} of {met}, {size} at {at}");
        }
    }
}
