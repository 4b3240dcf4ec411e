//! The hierarchy against brute force on ordinary and on nasty input, its structure, and its answers against another
//! program's.

use std::sync::Arc;

use crate::random::Random;
use crate::shared_data::{answered_rays, model};
use crate::wavy_sphere::wavy_sphere;
use glam::{Affine3A, EulerRot, Mat3A, Quat, Vec3, Vec3A};
use sunroom::accel::{Blas, Bvh, Instance, Placement, Primitive, SplitMethod, Tlas, TraversalStats};
use sunroom::geometry::mesh::MeshData;
use sunroom::geometry::triangle::{self, Faces};
use sunroom::math::{Aabb, Ray};

const METHODS: [SplitMethod; 3] = [SplitMethod::Linear, SplitMethod::Median, SplitMethod::Sah];

fn mesh(triangles: impl IntoIterator<Item = [Vec3; 3]>) -> MeshData {
    let positions: Vec<Vec3> = triangles.into_iter().flatten().collect();
    let triangles = (0..positions.len() as u32 / 3)
        .map(|i| [3 * i, 3 * i + 1, 3 * i + 2])
        .collect();
    MeshData {
        positions,
        triangles,
        ..MeshData::default()
    }
}

fn soup(count: usize, scale: f32, random: &mut Random) -> MeshData {
    mesh((0..count).map(|_| {
        let center = random.in_cube();
        [(); 3].map(|()| scale * (center + 0.2 * random.in_cube()))
    }))
}

/// Slender triangles from anywhere to anywhere in a cube, whose boxes hold little but each other.
fn beams(count: usize, scale: f32, random: &mut Random) -> MeshData {
    mesh((0..count).map(|_| {
        let [from, to] = [random.in_cube(), random.in_cube()];
        [from, from + 0.02 * random.in_cube(), to].map(|corner| scale * corner)
    }))
}

/// Balls in rows, and planks over all of them, the whole turned so that the planks' boxes are far larger than they are.
fn balls_under_planks(rings: u32, scale: f32, place: Vec3) -> MeshData {
    let turn = Quat::from_rotation_y(0.5);
    let ball = wavy_sphere(rings);
    let balls = (0..64).flat_map(|i| {
        let center = Vec3::new((i % 8) as f32, 0.0, (i / 8) as f32);
        let corners = |triangle| ball.corners(triangle).map(|corner| center + 0.4 * corner);
        (0..ball.triangles.len()).map(corners).collect::<Vec<_>>()
    });
    let planks = (0..64).flat_map(|i| {
        let corner = |x: f32, z: f32| Vec3::new(8.0 * x, 1.0, 0.12 * (i as f32 + 0.8 * z));
        let [a, b, c, d] = [(0.0, 0.0), (0.0, 1.0), (1.0, 1.0), (1.0, 0.0)].map(|(x, z)| corner(x, z));
        [[a, b, c], [a, c, d]]
    });
    mesh(
        balls
            .chain(planks)
            .map(|corners| corners.map(|corner| scale * (turn * corner) + place)),
    )
}

/// Squares of the plane z = 0.5, cut in two.
fn grid(side: usize) -> MeshData {
    mesh((0..2 * side * side).map(|i| {
        let corner = |x: usize, y: usize| {
            let (column, row) = (i / 2 % side + x, i / 2 / side + y);
            Vec3::new(column as f32, row as f32, 0.5 * side as f32) / (0.5 * side as f32) - Vec3::new(1.0, 1.0, 0.5)
        };
        match i % 2 {
            0 => [corner(0, 0), corner(1, 0), corner(1, 1)],
            _ => [corner(0, 0), corner(1, 1), corner(0, 1)],
        }
    }))
}

/// Ordinary rays, rays along axes (zero components of either sign), rays that start on a vertex's coordinates, short
/// rays.
fn rays(count: usize, mesh: &MeshData, random: &mut Random) -> Vec<Ray> {
    let points: Vec<Vec3> = mesh.positions.iter().copied().filter(|p| p.is_finite()).collect();
    let bounds = Aabb::from_points(points.iter().copied());
    let (center, radius) = if bounds.is_empty() {
        (Vec3::ZERO, 1.0)
    } else {
        (bounds.center(), bounds.extent().length().max(f32::MIN_POSITIVE))
    };
    let mut rays = Vec::with_capacity(count);
    for i in 0..count {
        let origin = center + radius * random.in_cube();
        let target = center + 0.5 * radius * random.in_cube();
        let mut ray = Ray::new(origin, target - origin);
        match i % 6 {
            0 => {
                let sign = if random.unit() < 0.5 { 1.0 } else { -1.0 };
                let mut dir = Vec3::splat(0.0f32.copysign(random.unit() - 0.5));
                dir[random.next_u32() as usize % 3] = sign;
                ray = Ray::new(center - radius * dir + 0.5 * radius * random.in_cube(), dir);
            }
            1 if !points.is_empty() => {
                let point = points[random.next_u32() as usize % points.len()];
                let axis = random.next_u32() as usize % 3;
                let mut dir = Vec3::ZERO;
                dir[axis] = 1.0;
                ray = Ray::new(point - radius * dir, dir);
            }
            2 => ray.t_max = random.unit(),
            3 => ray.dir *= 1e-3,
            4 => ray.t_min = random.unit(),
            _ => {}
        }
        rays.push(ray);
    }
    rays
}

fn brute_force(mesh: &MeshData, ray: &Ray) -> Option<f32> {
    let valid = |t: &&[u32; 3]| t.iter().all(|&i| (i as usize) < mesh.positions.len());
    mesh.triangles
        .iter()
        .filter(valid)
        .filter_map(|t| triangle::intersect(ray, t.map(|i| mesh.positions[i as usize]), Faces::Both))
        .map(|hit| hit.t)
        .min_by(f32::total_cmp)
}

/// The arithmetic is that of the brute force, so distances are equal but where two triangles meet within rounding and
/// the farther one lets the other's box be skipped: a few ulp.
const SAME_T: f32 = 1e-6;

#[track_caller]
fn assert_agrees(name: &str, mesh: MeshData, ray_count: usize) {
    let mut random = Random::new(7);
    let rays = rays(ray_count, &mesh, &mut random);
    let answers: Vec<Option<f32>> = rays.iter().map(|ray| brute_force(&mesh, ray)).collect();
    let mesh = Arc::new(mesh);
    for method in METHODS {
        let blas = Blas::build(mesh.clone(), method);
        blas.validate()
            .unwrap_or_else(|error| panic!("{name}, {method:?}: {error}"));
        for (ray, answer) in rays.iter().zip(&answers) {
            let hit = blas.intersect(ray);
            match (hit.map(|hit| hit.t), answer) {
                (None, None) => {}
                (Some(t), &Some(answer)) if (t - answer).abs() <= SAME_T * answer => {}
                (t, answer) => panic!("{name}, {method:?}: {t:?} instead of {answer:?} for {ray:?}"),
            }
            assert_eq!(blas.occluded(ray), answer.is_some(), "{name}, {method:?}, {ray:?}");
            let mut stats = TraversalStats::default();
            assert_eq!(blas.intersect_counting(ray, &mut stats), hit);
            if let Some(hit) = hit {
                assert!(hit.u >= 0.0 && hit.v >= 0.0 && hit.u + hit.v <= 1.0 + f32::EPSILON);
                let own = triangle::intersect(ray, mesh.corners(hit.triangle as usize), Faces::Both);
                assert_eq!(own.map(|own| own.t), Some(hit.t), "{name}, {method:?}, {ray:?}");
                assert!(stats.primitives > 0 && stats.boxes > 0);
            }
        }
    }
}

#[test]
fn meshes_agree_with_brute_force() {
    let mut random = Random::new(1);
    assert_agrees("soup", soup(3000, 1.0, &mut random), 3000);
    assert_agrees("huge", soup(500, 1e6, &mut random), 3000);
    assert_agrees("tiny", soup(500, 1e-4, &mut random), 3000);
    assert_agrees("beams", beams(1000, 1.0, &mut random), 3000);
    assert_agrees("planks", balls_under_planks(12, 1.0, Vec3::ZERO), 1000);
    assert_agrees("huge planks", balls_under_planks(12, 1e6, Vec3::ZERO), 300);
    assert_agrees("tiny planks", balls_under_planks(12, 1e-4, Vec3::ZERO), 300);
    assert_agrees("far planks", balls_under_planks(12, 1.0, Vec3::splat(1e4)), 300);
    assert_agrees("coplanar", grid(24), 3000);
    assert_agrees("closed", wavy_sphere(24), 3000);
    assert_agrees("single", soup(1, 1.0, &mut random), 2000);
    assert_agrees("empty", MeshData::default(), 100);
    let one = soup(1, 1.0, &mut random);
    assert_agrees("duplicates", mesh((0..1000).map(|_| one.corners(0))), 500);
    let far = soup(300, 1.0, &mut random);
    assert_agrees("far", mesh((0..300).map(|i| far.corners(i).map(|p| p + 1e4))), 2000);
    let far = beams(300, 1.0, &mut random);
    assert_agrees(
        "far beams",
        mesh((0..300).map(|i| far.corners(i).map(|p| p + 1e4))),
        2000,
    );
}

/// Where boxes overlap much a leaf holds a part of a triangle; at most as many more as there are triangles, and none of
/// a surface of small ones.
#[test]
fn long_triangles_are_held_in_parts() {
    let parts = |mesh: MeshData, method| {
        let count = mesh.triangles.len();
        let blas = Blas::build(Arc::new(mesh), method);
        let listed = blas.bvh().order().iter().filter(|&&triangle| triangle != u32::MAX);
        (listed.count() as f32 / count as f32, blas.stats().sah_cost)
    };
    let planks = balls_under_planks(12, 1.0, Vec3::ZERO);
    assert_eq!(parts(planks.clone(), SplitMethod::Median).0, 1.0);
    assert_eq!(parts(wavy_sphere(64), SplitMethod::Sah).0, 1.0);

    let whole: Vec<Aabb> = (0..planks.triangles.len())
        .map(|i| Aabb::from_points(planks.corners(i)))
        .collect();
    let whole = Bvh::build(&whole, SplitMethod::Sah, 8).stats().sah_cost;
    let (number, cost) = parts(planks, SplitMethod::Sah);
    assert!(number > 1.05 && number <= 2.0, "{number}");
    assert!(cost < 0.8 * whole, "{cost} instead of {whole}");
}

#[test]
fn degenerate_triangles_are_left_out_and_lose_no_others() {
    let mut random = Random::new(2);
    let good = soup(400, 1.0, &mut random);
    let mut mixed = mesh((0..800).map(|i| {
        let corners @ [a, b, _] = good.corners(i / 2);
        match i % 10 {
            1 => [a, a, a],
            3 => [a, b, a],
            5 => [a, Vec3::splat(f32::NAN), b],
            7 => [a, Vec3::new(0.0, f32::INFINITY, 0.0), b],
            9 => [a, 0.5 * (a + b), b],
            _ => corners,
        }
    }));
    mixed.triangles.push([0, 1, u32::MAX]);
    assert_agrees("mixed", mixed, 2000);
    assert_agrees("points", mesh((0..100).map(|_| [random.in_cube(); 3])), 100);
}

/// Which boxes a ray certainly meets: its point at a parameter in the middle of its way through the box is well inside.
fn surely_meets(bounds: &Aabb, ray: &Ray) -> bool {
    let [o, d] = [ray.origin, ray.dir].map(|v| v.as_dvec3());
    let a = (bounds.min.as_dvec3() - o) / d;
    let b = (bounds.max.as_dvec3() - o) / d;
    let (enter, leave) = (a.min(b).max_element().max(0.0), a.max(b).min_element());
    enter <= leave
}

#[test]
fn hostile_boxes_are_all_found() {
    let mut random = Random::new(3);
    let box_at = |center: Vec3, half: Vec3| Aabb {
        min: center - half,
        max: center + half,
    };
    let exponential = |random: &mut Random| 10f32.powf(60.0 * random.unit() - 30.0);
    let nan = Vec3::splat(f32::NAN);
    let cases: Vec<(&str, Vec<Aabb>)> = vec![
        ("none", vec![]),
        ("one", vec![box_at(Vec3::ONE, Vec3::ONE)]),
        ("coincident", vec![box_at(Vec3::ONE, Vec3::ONE); 5000]),
        ("points", vec![box_at(Vec3::ONE, Vec3::ZERO); 100]),
        (
            "nested",
            (0..3000)
                .map(|i| box_at(Vec3::ZERO, Vec3::splat(1.01f32.powi(i % 8000))))
                .collect(),
        ),
        (
            "exponential",
            (0..5000)
                .map(|_| {
                    let scale = exponential(&mut random);
                    box_at(scale * random.in_cube(), 0.1 * scale * Vec3::ONE)
                })
                .collect(),
        ),
        (
            "chain",
            (0..2000)
                .map(|i| box_at(Vec3::X * 0.96f32.powi(i), Vec3::splat(0.01 * 0.96f32.powi(i))))
                .collect(),
        ),
        (
            "mixed",
            (0..2000)
                .map(|i| match i % 8 {
                    0 => Aabb::EMPTY,
                    1 => Aabb { min: nan, max: nan },
                    2 => Aabb {
                        min: Vec3::ZERO,
                        max: Vec3::new(1.0, f32::NAN, 1.0),
                    },
                    3 => Aabb {
                        min: Vec3::NEG_INFINITY,
                        max: Vec3::INFINITY,
                    },
                    4 => Aabb {
                        min: Vec3::MIN,
                        max: Vec3::MAX,
                    },
                    5 => Aabb {
                        min: Vec3::ZERO,
                        max: Vec3::new(f32::INFINITY, 1.0, 1.0),
                    },
                    _ => box_at(random.in_cube(), Vec3::splat(0.1)),
                })
                .collect(),
        ),
    ];
    for (name, boxes) in &cases {
        for method in METHODS {
            for leaf_size in [1, 3, 8] {
                let bvh = Bvh::build(boxes, method, leaf_size);
                bvh.validate(boxes)
                    .unwrap_or_else(|error| panic!("{name}, {method:?}: {error}"));
                for _ in 0..20 {
                    let ray = Ray::new(1.5 * random.in_cube(), random.direction());
                    let mut visited = vec![false; boxes.len()];
                    bvh.closest::<false>(&ray, &mut TraversalStats::default(), |range, _| {
                        bvh.order()[range].iter().for_each(|&i| visited[i as usize] = true);
                    });
                    for (bounds, visited) in boxes.iter().zip(visited) {
                        let valid = bounds.min.cmple(bounds.max).all();
                        assert!(
                            visited || !valid || !surely_meets(bounds, &ray),
                            "{name}, {method:?}: {bounds:?}, {ray:?}"
                        );
                    }
                }
            }
        }
    }
}

/// Their triangles are not looked at at once, but when they have come.
#[test]
fn rays_that_begin_within_a_mesh_beyond_the_caches() {
    let mesh = Arc::new(wavy_sphere(300));
    let blas = Blas::build(mesh.clone(), SplitMethod::Sah);
    assert!(blas.stats().bytes > 8 << 20);
    let random = &mut Random::new(3);
    let mut count = [0, 0];
    for i in 0..200 {
        let mut ray = Ray::new(random.in_cube(), random.direction());
        if i % 2 == 0 {
            ray.t_max = random.unit();
        }
        let answer = brute_force(&mesh, &ray);
        let hit = blas.intersect(&ray);
        let is_same = |t: f32| answer.is_some_and(|answer| (t - answer).abs() <= SAME_T * answer);
        assert!(
            hit.map_or(answer.is_none(), |hit| is_same(hit.t)),
            "{hit:?}, not {answer:?}"
        );
        assert_eq!(blas.occluded(&ray), answer.is_some());
        assert_eq!(blas.intersect_counting(&ray, &mut TraversalStats::default()), hit);
        count[usize::from(answer.is_some())] += 1;
    }
    assert!(count.iter().all(|&count| count > 30), "hits and misses");
}

#[test]
fn rays_that_are_no_rays_hit_nothing() {
    let blas = Blas::build(Arc::new(wavy_sphere(8)), SplitMethod::Sah);
    let [zero, one, nan, infinite] = [0.0, 1.0, f32::NAN, f32::INFINITY].map(Vec3::splat);
    for (origin, dir, t_max) in [
        (zero, zero, 1.0),
        (zero, nan, 1.0),
        (nan, one, 1.0),
        (infinite, one, 1.0),
        (zero, infinite, 1.0),
        (zero, one, 0.0),
        (zero, one, f32::NAN),
        (zero, one, -1.0),
    ] {
        let ray = Ray {
            t_max,
            ..Ray::new(origin, dir)
        };
        assert_eq!(blas.intersect(&ray), None, "{ray:?}");
        assert!(!blas.occluded(&ray), "{ray:?}");
    }
}

fn random_transform(random: &mut Random, spread: f32) -> Affine3A {
    let angles = std::f32::consts::PI * random.in_cube();
    let rotation = Quat::from_euler(EulerRot::XYZ, angles.x, angles.y, angles.z);
    let mut scale = 0.05 + 0.2 * random.in_cube().abs();
    if random.unit() < 0.3 {
        scale.x = -scale.x;
    }
    let shear = Mat3A::from_cols(Vec3A::X, Vec3A::new(0.3 * random.unit(), 1.0, 0.0), Vec3A::Z);
    let place = Affine3A::from_scale_rotation_translation(scale, rotation, spread * random.in_cube());
    place * Affine3A::from_mat3(shear.into())
}

fn random_instances(count: usize, random: &mut Random) -> Vec<Instance> {
    let blas = Arc::new(Blas::build(Arc::new(wavy_sphere(8)), SplitMethod::Sah));
    let shapes = [
        Primitive::Mesh(blas),
        Primitive::Sphere,
        Primitive::Rectangle,
        Primitive::Disk,
        Primitive::Cylinder,
    ];
    (0..count)
        .map(|i| Instance::new(shapes[i % shapes.len()].clone(), random_transform(random, 2.0)).unwrap())
        .collect()
}

#[test]
fn placed_groups_are_their_members_placed_one_by_one() {
    let mut random = Random::new(14);
    let groups: Vec<Arc<Tlas>> = [1, 5]
        .map(|count| Arc::new(Tlas::build(random_instances(count, &mut random), SplitMethod::Sah)))
        .into();
    let instances = random_instances(3, &mut random);
    let grown = Affine3A::from_scale(Vec3::splat(8.0));
    let places: Vec<Affine3A> = (0..20).map(|_| random_transform(&mut random, 4.0) * grown).collect();
    let placements = (0..).zip(&places);
    let placements = placements.map(|(i, place)| Placement::new(i % 2, place).unwrap());
    let tlas = Tlas::with_placements(
        instances.clone(),
        groups.clone(),
        placements.collect(),
        SplitMethod::Sah,
    );
    tlas.validate().unwrap();

    // The same shapes without groups, and for each what a hit of it should say: instance, member, shape.
    let mut flat = instances;
    let mut names: Vec<(u32, u32, usize)> = (0..flat.len()).map(|i| (i as u32, 0, i)).collect();
    for (i, place) in places.iter().enumerate() {
        for (m, member) in groups[i % 2].instances().iter().enumerate() {
            let placed = *place * member.world_from_local;
            flat.push(Instance::new(member.primitive.clone(), placed).unwrap());
            names.push((3 + i as u32, m as u32, 3 + i % 2 + m));
        }
    }
    let flat = Tlas::build(flat, SplitMethod::Sah);
    let (mut compared, mut differing) = (0, 0);
    for _ in 0..20_000 {
        let origin = 4.0 * random.in_cube();
        let ray = Ray::new(origin, (4.0 * random.in_cube() - origin).normalize());
        let (hit, expected) = (tlas.intersect(&ray), flat.intersect(&ray));
        assert_eq!(tlas.occluded(&ray), hit.is_some());
        let (Some(hit), Some(expected)) = (hit, expected) else {
            // Rounding decides at silhouettes only.
            differing += usize::from(hit.is_some() != expected.is_some());
            continue;
        };
        // Transforms differ in rounding: 1e-6 of coordinates up to 10, more where a ray grazes or shapes are thin
        // (scale 0.05).
        if (hit.t - expected.t).abs() > 1e-4
            || names[expected.instance as usize] != (hit.instance, hit.member, tlas.shape_index(&hit))
        {
            differing += 1;
            continue;
        }
        let (here, there) = (tlas.surface(&ray, &hit), flat.surface(&ray, &expected));
        assert!((here.position - there.position).length() < 1e-4);
        assert!((ray.at(hit.t) - here.position).length() < 1e-4);
        let mesh = tlas.mesh_at(&hit).is_some();
        assert_eq!(mesh, flat.mesh_at(&expected).is_some());
        // A mesh that is stored mirrored turns around; placed mirrored it does not.
        let side = here.geometric_normal.dot(there.geometric_normal);
        assert!(if mesh { side.abs() } else { side } > 0.999, "{side}");
        let grow = there.dp_du.length() + there.dp_dv.length();
        assert!((here.dp_du - there.dp_du).length() + (here.dp_dv - there.dp_dv).length() < 1e-2 * grow);
        compared += 1;
    }
    assert!(compared > 1000 && differing * 100 < compared, "{compared} {differing}");
}

#[test]
fn placements_that_hold_nothing() {
    let shape = Tlas::build(random_instances(1, &mut Random::new(3)), SplitMethod::Sah);
    let here = |group| Placement::new(group, &Affine3A::IDENTITY).unwrap();
    let nested = Tlas::with_placements(vec![], vec![Arc::new(shape.clone())], vec![here(0)], SplitMethod::Sah);
    assert!(!nested.bounds().is_empty());
    let groups = vec![Arc::new(nested), Arc::new(Tlas::build(vec![], SplitMethod::Sah))];
    let tlas = Tlas::with_placements(vec![], groups, vec![here(0), here(1), here(2)], SplitMethod::Sah);
    tlas.validate().unwrap();
    assert!(tlas.bounds().is_empty());
    for singular in [
        Vec3::new(1.0, 0.0, 1.0),
        Vec3::NAN,
        Vec3::new(1.0, f32::INFINITY, 1.0),
        Vec3::splat(1e-39),
    ] {
        assert_eq!(Placement::new(0, &Affine3A::from_scale(singular)), None);
    }
    assert!(Placement::new(0, &Affine3A::from_scale(Vec3::splat(1e-15))).is_some());
}

#[test]
fn instances_agree_with_brute_force() {
    let mut random = Random::new(4);
    let mut strays = 0;
    for count in [0, 1, 7, 400] {
        let instances = random_instances(count, &mut random);
        let alone: Vec<Tlas> = instances
            .iter()
            .map(|one| Tlas::build(vec![one.clone()], SplitMethod::Linear))
            .collect();
        for method in METHODS {
            let tlas = Tlas::build(instances.clone(), method);
            tlas.validate().unwrap();
            for _ in 0..1000 {
                let origin = 3.0 * random.in_cube();
                let mut ray = Ray::new(origin, 2.0 * random.in_cube() - origin);
                if random.unit() < 0.2 {
                    ray.t_max = random.unit();
                }
                let answer = alone
                    .iter()
                    .zip(0..)
                    .filter_map(|(one, index)| one.intersect(&ray).map(|hit| (hit.t, index)))
                    .min_by(|a, b| a.0.total_cmp(&b.0));
                let hit = tlas.intersect(&ray);
                let agrees = match (hit, answer) {
                    (None, None) => true,
                    // Shapes in blocks are tested in single precision.
                    (Some(hit), Some((t, index))) => hit.instance == index && (hit.t - t).abs() < 1e-5 * (1.0 + t),
                    _ => false,
                };
                // At a rim, or where two shapes pass through each other, rounding decides.
                strays += usize::from(!agrees);
                assert_eq!(tlas.occluded(&ray), hit.is_some());
                let mut stats = TraversalStats::default();
                assert_eq!(tlas.intersect_counting(&ray, &mut stats), hit);
                assert!(hit.is_none() || stats.total() >= 2);
            }
        }
    }
    assert!(strays <= 5, "{strays} of 12000 rays differ");
}

#[test]
fn world_bounds_hold_every_hit_and_are_tight() {
    let mut random = Random::new(5);
    for instance in random_instances(40, &mut random) {
        let bounds = instance.world_bounds();
        let tlas = Tlas::build(vec![instance], SplitMethod::Linear);
        let mut hits = Aabb::EMPTY;
        for _ in 0..4000 {
            let origin = bounds.center() + 2.0 * bounds.extent().length() * random.direction();
            let target = bounds.center() + 0.6 * bounds.extent() * random.in_cube();
            let ray = Ray::new(origin, target - origin);
            if let Some(hit) = tlas.intersect(&ray) {
                hits = hits.grown(tlas.surface(&ray, &hit).position);
            }
        }
        assert!(bounds.contains(&hits), "{bounds:?} {hits:?}");
        // Thousands of hits come near every side. A mesh's bounds are those of its rotated box, up to sqrt(3) too wide.
        assert!(hits.extent().cmpge(0.5 * bounds.extent()).all(), "{bounds:?} {hits:?}");
    }
}

#[test]
fn the_same_tree_on_any_number_of_threads() {
    let meshes = [wavy_sphere(200), balls_under_planks(24, 1.0, Vec3::ZERO)].map(Arc::new);
    let build = |threads: usize, mesh: &Arc<MeshData>, method| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let blas = pool.install(|| Blas::build(mesh.clone(), method));
        let mut boxes = vec![];
        blas.bvh().visit_boxes(|bvh_box| boxes.push(bvh_box));
        (blas.bvh().order().to_vec(), boxes, blas.stats())
    };
    for mesh in &meshes {
        for method in METHODS {
            assert!(build(1, mesh, method) == build(3, mesh, method), "{method:?}");
        }
    }
}

#[test]
fn statistics_and_boxes_describe_the_tree() {
    let mesh = Arc::new(wavy_sphere(64));
    let [linear, median, sah] = METHODS.map(|method| Blas::build(mesh.clone(), method));
    assert_eq!(
        (linear.stats().nodes, linear.stats().leaves, linear.stats().max_depth),
        (1, 1, 1)
    );
    assert_eq!(linear.stats().sah_cost, mesh.triangles.len() as f32);
    assert!(sah.stats().sah_cost < median.stats().sah_cost && median.stats().sah_cost < 100.0);
    for blas in [&linear, &median, &sah] {
        let stats = blas.stats();
        let (mut leaves, mut inner, mut deepest) = (0, 0, 0);
        blas.bvh().visit_boxes(|b| {
            assert!(blas.bounds().contains(&b.bounds));
            leaves += usize::from(b.is_leaf);
            inner += usize::from(!b.is_leaf);
            deepest = deepest.max(b.depth);
        });
        // Each node has one box, in its parent; the root's is the one around everything.
        assert_eq!((leaves, inner, deepest), (stats.leaves, stats.nodes, stats.max_depth));
        assert!(stats.bytes >= 256 * stats.nodes + 9 * 4 * mesh.triangles.len());
        assert_eq!(blas.bounds(), mesh.bounds());
    }
    assert_eq!(Blas::build(Arc::default(), SplitMethod::Sah).stats().leaves, 0);
}

#[test]
fn answers_of_another_program_on_shared_rays() {
    let Some(mesh) = model("bunny.obj") else {
        println!("skipped: no shared data beside the repository");
        return;
    };
    let blas = Blas::build(Arc::new(mesh), SplitMethod::Sah);
    for name in ["primary", "bounce"] {
        let Some(rays) = answered_rays(&format!("rays_bunny_{name}_262144.bin")) else {
            println!("skipped: no ray set {name}");
            continue;
        };
        let (mut other_triangle, mut other_distance, mut count) = (0, 0, 0);
        for (ray, answer, answer_triangle) in rays {
            let hit = blas.intersect(&ray);
            let (t, triangle) = hit.map_or((f32::INFINITY, u32::MAX), |hit| (hit.t, hit.triangle));
            other_triangle += usize::from(triangle != answer_triangle);
            other_distance += usize::from(t != answer && (t - answer).abs() > 1e-4 * answer);
            assert_eq!(blas.occluded(&ray), hit.is_some());
            count += 1;
        }
        println!("{name}: of {count} rays {other_triangle} hit another triangle, {other_distance} at another distance");
        // The set itself is uncertain by about nine in a million, on shared edges.
        assert!(other_triangle <= 5 && other_distance <= 2);
    }
}

/// Two boxes of edge 2, four apart: of half their hull's surface, 36, each has a third.
#[test]
fn the_expected_work_of_small_trees_is_known() {
    let at = |x: f32| Affine3A::from_translation(Vec3::new(x, 0.0, 0.0));
    let flat = mesh([
        [Vec3::NEG_ONE, Vec3::ONE, Vec3::new(1.0, -1.0, -1.0)],
        [Vec3::ONE, Vec3::NEG_ONE, Vec3::new(-1.0, 1.0, 1.0)],
    ]);
    let blas = Arc::new(Blas::build(Arc::new(flat), SplitMethod::Sah));
    assert_eq!(
        blas.stats().sah_cost,
        2.0,
        "two triangles in a leaf as large as everything"
    );
    let two = |left: Primitive, right: Primitive| {
        let instances = [(left, -3.0), (right, 3.0)].map(|(primitive, x)| Instance::new(primitive, at(x)));
        Tlas::build(instances.into_iter().flatten().collect(), SplitMethod::Sah).expected_work()
    };
    let mesh = || Primitive::Mesh(blas.clone());
    // The boxes of placed things are larger than the things by a few roundings of coordinates up to 4.
    let near = |work: f64, expected: f64| assert!((work - expected).abs() < 1e-5, "{work}, not {expected}");
    near(two(Primitive::Sphere, Primitive::Sphere), 2.0 / 3.0);
    near(two(mesh(), Primitive::Sphere), 1.0);
    near(two(mesh(), mesh()), 4.0 / 3.0);
    let group = Tlas::build(
        Instance::new(mesh(), Affine3A::IDENTITY).into_iter().collect(),
        SplitMethod::Sah,
    );
    let placements = [-3.0, 3.0].map(|x| Placement::new(0, &at(x)));
    let placements = placements.into_iter().flatten().collect();
    let placed = Tlas::with_placements(Vec::new(), vec![Arc::new(group)], placements, SplitMethod::Sah);
    near(placed.expected_work(), 4.0 / 3.0);
    assert_eq!(Tlas::build(Vec::new(), SplitMethod::Sah).expected_work(), 0.0);
    // Eight leaves of one are a node of their own below the root's; every inner box counts 1.
    let row: Vec<Aabb> = (0..9)
        .map(|i| Aabb::from_points([Vec3::new(i as f32, 0.0, 0.0), Vec3::new(i as f32 + 1.0, 1.0, 1.0)]))
        .collect();
    let bvh = Bvh::build(&row, SplitMethod::Median, 1);
    let mut by_hand = 0.0;
    bvh.visit_boxes(|found| {
        if found.depth > 0 {
            by_hand += f64::from(found.bounds.half_area()) / f64::from(bvh.bounds().half_area());
        }
    });
    near(bvh.expected_work(|_| 1.0), by_hand);
    near(
        bvh.expected_work(|primitive| f64::from(primitive == 4)),
        by_hand - 8.0 * 3.0 / 19.0,
    );
}

#[test]
fn a_refitted_hierarchy_is_that_of_the_moved_mesh() {
    let random = &mut Random::new(11);
    let flat = grid(40);
    let mut bent = flat.clone();
    for position in &mut bent.positions {
        position.z += 0.02 * (3.0 * position.x).sin();
    }
    for method in METHODS {
        let built = Blas::build(Arc::new(flat.clone()), method);
        let refitted = built.refit(Arc::new(bent.clone())).expect("a similar mesh");
        refitted.validate().expect("a sound hierarchy");
        assert_eq!(refitted.bvh().order(), built.bvh().order());
        for ray in rays(500, &bent, random) {
            let (t, answer) = (refitted.intersect(&ray).map(|hit| hit.t), brute_force(&bent, &ray));
            let is_same = |t: f32| answer.is_some_and(|answer| (t - answer).abs() <= SAME_T * answer);
            assert!(t.map_or(answer.is_none(), is_same), "{t:?} instead of {answer:?}");
            assert_eq!(refitted.occluded(&ray), answer.is_some());
        }
    }
}

#[test]
fn what_is_not_the_same_mesh_moved_is_built_anew() {
    let random = &mut Random::new(12);
    let flat = grid(40);
    let built = Blas::build(Arc::new(flat.clone()), SplitMethod::Sah);
    let refit = |change: &mut dyn FnMut(&mut MeshData)| {
        let mut changed = flat.clone();
        change(&mut changed);
        built.refit(Arc::new(changed))
    };
    assert!(refit(&mut |_| {}).is_some());
    assert!(
        refit(&mut |mesh| mesh.triangles[7].reverse()).is_none(),
        "other triangles"
    );
    assert!(
        refit(&mut |mesh| mesh.positions[100] = Vec3::NAN).is_none(),
        "triangles that cannot be hit"
    );
    let mut scatter = |mesh: &mut MeshData| {
        for position in &mut mesh.positions {
            *position += random.in_cube();
        }
    };
    assert!(refit(&mut scatter).is_none(), "nothing is where it was");

    let planks = Arc::new(balls_under_planks(12, 1.0, Vec3::ZERO));
    let in_parts = Blas::build(planks.clone(), SplitMethod::Sah);
    assert!(in_parts.refit(planks).is_none(), "boxes around parts");
}
