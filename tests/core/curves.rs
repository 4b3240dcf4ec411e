//! Curves in scenes: against brute force, against the cylinder, in groups, and rays that leave them.

use std::sync::Arc;

use glam::{Affine3A, Quat, Vec3, Vec4};
use sunroom::accel::{CurveBlas, Instance, Placement, Primitive, RayLanes, SplitMethod, Tlas};
use sunroom::geometry::curve::Basis;
use sunroom::geometry::curve_file::load_curves;
use sunroom::geometry::mesh::MeshData;
use sunroom::geometry::strands::Strands;
use sunroom::math::{Ray, offset_origin};

use crate::random::Random;

const BASES: [Basis; 2] = [Basis::BSpline, Basis::Linear];

/// Curves of `points` control points that wander through a cube, and get thinner.
fn strands(count: usize, points: usize, radius: f32, random: &mut Random) -> Strands {
    let mut strands = Strands {
        shortest: (points as u32, 1),
        ..Strands::default()
    };
    for _ in 0..count {
        strands.firsts.push(strands.points.len() as u32);
        let mut place = random.in_cube();
        let mut dir = random.direction();
        for point in 0..points {
            let thin = 1.0 - 0.7 * point as f32 / points as f32;
            strands.points.push(place.extend(thin * radius));
            dir = (dir + 0.5 * random.direction()).normalize();
            place += 0.15 * dir;
        }
    }
    strands
}

fn curves(strands: Strands, basis: Basis, method: SplitMethod) -> Arc<CurveBlas> {
    let mesh = MeshData {
        strands,
        ..MeshData::default()
    };
    Arc::new(CurveBlas::build(Arc::new(mesh), basis, method))
}

fn placed(curves: Arc<CurveBlas>, world_from_local: Affine3A) -> Instance {
    Instance::new(Primitive::Curves(curves), world_from_local).unwrap()
}

fn ray(random: &mut Random) -> Ray {
    let from = 3.0 * random.direction();
    Ray::new(from, random.in_cube() - from)
}

#[test]
fn hierarchies_find_what_a_list_finds() {
    let mut random = Random::new(1);
    for basis in BASES {
        for radius in [0.002, 0.03] {
            let strands = strands(60, 9, radius, &mut random);
            let [list, median, sah] = [SplitMethod::Linear, SplitMethod::Median, SplitMethod::Sah]
                .map(|method| curves(strands.clone(), basis, method));
            let mut hits = 0;
            for _ in 0..4000 {
                let ray = ray(&mut random);
                let expected = list.intersect(&ray);
                hits += u32::from(expected.is_some());
                for curves in [&median, &sah] {
                    // Where two segments meet, both may be as near in single precision.
                    let found = curves.intersect(&ray);
                    let nearest = expected.map(|hit| hit.t);
                    assert_eq!(found.map(|hit| hit.t), nearest, "{basis:?} {radius} {ray:?}");
                    assert_eq!(curves.occluded(&ray), expected.is_some());
                    if let Some(hit) = expected {
                        let before = Ray { t_max: hit.t, ..ray };
                        assert!(!curves.occluded(&before) && curves.intersect(&before).is_none());
                        let behind = Ray { t_min: hit.t, ..ray };
                        assert!(curves.intersect(&behind).is_none_or(|next| next.t > hit.t));
                    }
                }
            }
            assert!(
                hits > if radius < 0.01 { 50 } else { 1000 },
                "{basis:?} {radius}: {hits}"
            );
        }
    }
}

/// One at a time, in lanes and in packets, in scenes of few and of many shapes.
#[test]
fn rays_together_find_the_same() {
    let mut random = Random::new(2);
    let curves = curves(strands(200, 8, 0.02, &mut random), Basis::BSpline, SplitMethod::Sah);
    for count in [1, 400] {
        let instances = (0..count).map(|_| placed(curves.clone(), Affine3A::from_translation(0.3 * random.in_cube())));
        let scene = Tlas::build(instances.collect(), SplitMethod::Sah);
        scene.validate().unwrap();
        for _ in 0..60 {
            let mut lanes = RayLanes::NOWHERE;
            let rays: Vec<Ray> = (0..16).map(|_| ray(&mut random)).collect();
            rays.iter().enumerate().for_each(|(lane, ray)| lanes.set(lane, ray));
            let expected: Vec<_> = rays.iter().map(|ray| scene.intersect(ray)).collect();
            assert_eq!(scene.intersect_lanes(&lanes, 0xffff).to_vec(), expected);
            assert_eq!(scene.intersect_packet(&lanes, 0xffff).to_vec(), expected);
            let met = expected.iter().enumerate();
            let met = met.fold(0, |met, (lane, hit)| met | u32::from(hit.is_some()) << lane);
            assert_eq!(scene.occluded_lanes(&lanes, 0xffff), met);
            assert_eq!(scene.occluded_packet(&lanes, 0xffff), met);
        }
    }
}

#[test]
fn a_straight_spline_is_shaded_as_a_cylinder() {
    let mut random = Random::new(3);
    let points = (-1..3).map(|z| Vec4::new(0.0, 0.0, z as f32, 1.0)).collect();
    let straight = Strands {
        points,
        firsts: vec![0],
        shortest: (4, 1),
    };
    let spline = curves(straight, Basis::BSpline, SplitMethod::Sah);
    let place = Affine3A::from_rotation_translation(Quat::from_rotation_x(1.1), Vec3::new(0.3, -0.2, 0.1));
    let ours = Tlas::build(vec![placed(spline, place)], SplitMethod::Sah);
    let cylinder = Instance::new(Primitive::Cylinder, place).unwrap();
    let cylinder = Tlas::build(vec![cylinder], SplitMethod::Sah);
    let (mut hits, mut one_sided) = (0, 0);
    for _ in 0..4000 {
        let ray = ray(&mut random);
        // The cylinder has an inside, too.
        let other = cylinder.intersect(&ray).map(|hit| cylinder.surface(&ray, &hit));
        let other = other.filter(|surface| surface.geometric_normal.dot(ray.dir) < 0.0);
        let hit = ours.intersect(&ray);
        let (Some(hit), Some(expected)) = (hit, other) else {
            one_sided += u32::from(hit.is_some() != other.is_some());
            continue;
        };
        let found = ours.surface(&ray, &hit);
        hits += 1;
        assert!(found.geometric_normal.dot(ray.dir) < 0.0);
        assert!(found.position.abs_diff_eq(expected.position, 1e-5));
        assert!(found.geometric_normal.abs_diff_eq(expected.geometric_normal, 1e-5));
        assert!((found.uv.y - expected.uv.y).abs() < 1e-5);
        // Angles have another zero, and go the same way round.
        assert!(found.dp_du.abs_diff_eq(expected.dp_du, 1e-4));
        assert!(found.dp_dv.abs_diff_eq(expected.dp_dv, 1e-4));
        let (one, other) = (found.shading_frame(), expected.shading_frame());
        assert!(one.t.abs_diff_eq(other.t, 1e-4), "hair runs along t");
    }
    // Those that touch an edge may miss one of the two.
    assert!(hits > 500 && one_sided <= 2, "{hits} {one_sided}");
}

/// What leaves a surface goes on, and what enters it passes to the next curve, because the inside is not met.
#[test]
fn rays_that_leave_a_curve_do_not_meet_it_again() {
    let mut random = Random::new(4);
    for basis in BASES {
        for radius in [0.001, 0.03] {
            for (scale, distance) in [(1.0, 0.0), (1e-3, 1.0), (1e3, 0.0), (1.0, 100.0)] {
                let mut one = strands(1, 12, radius, &mut random);
                // Gentle bends, which no ray from within leaves and enters again.
                let (from, along) = (one.points[0], random.direction());
                for (index, point) in one.points.iter_mut().enumerate() {
                    let place = from.truncate() + 0.15 * index as f32 * along + 0.01 * random.in_cube();
                    *point = place.extend(point.w);
                }
                let curves = curves(one.clone(), basis, SplitMethod::Sah);
                let place = Affine3A::from_scale_rotation_translation(
                    Vec3::splat(scale),
                    Quat::from_rotation_y(0.7),
                    distance * Vec3::new(0.3, -1.0, 0.7),
                );
                let scene = Tlas::build(vec![placed(curves, place)], SplitMethod::Sah);
                let mut hits = 0;
                for _ in 0..3000 {
                    let near = one.points[(random.next_u32() % 10 + 1) as usize];
                    let to = place.transform_point3(near.truncate() + near.w * random.in_cube());
                    let from = place.transform_point3(3.0 * random.direction());
                    let ray = Ray::new(from, to - from);
                    let Some(hit) = scene.intersect(&ray) else {
                        continue;
                    };
                    hits += 1;
                    let surface = scene.surface(&ray, &hit);
                    let normal = surface.geometric_normal;
                    // Not so flat that the bend of the curve is in the way.
                    let dir = (normal + 0.9 * random.direction()).normalize();
                    for dir in [dir, -dir] {
                        let origin = offset_origin(surface.position, surface.error, normal, dir);
                        let next = scene.intersect(&Ray::new(origin, dir));
                        assert!(next.is_none(), "{basis:?} {radius} {scale} {distance} {hit:?} {next:?}");
                    }
                }
                assert!(hits > 100, "{basis:?} {radius}: {hits}");
            }
        }
    }
}

#[test]
fn a_group_of_curves_is_placed_with_its_cross_sections() {
    let mut random = Random::new(5);
    let curves = curves(strands(20, 6, 0.05, &mut random), Basis::BSpline, SplitMethod::Sah);
    let place = Affine3A::from_scale_rotation_translation(
        Vec3::new(1.5, 0.5, -1.0),
        Quat::from_rotation_z(0.4),
        Vec3::new(0.1, 0.2, -0.1),
    );
    let group = Arc::new(Tlas::group(
        vec![placed(curves.clone(), Affine3A::IDENTITY)],
        SplitMethod::Sah,
    ));
    let placement = Placement::new(0, &place).unwrap();
    let grouped = Tlas::with_placements(Vec::new(), vec![group], vec![placement], SplitMethod::Sah);
    let alone = Tlas::build(vec![placed(curves, place)], SplitMethod::Sah);
    let (mut hits, mut one_sided) = (0, 0);
    for _ in 0..8000 {
        let ray = ray(&mut random);
        let (one, other) = (grouped.intersect(&ray), alone.intersect(&ray));
        let (Some(one), Some(other)) = (one, other) else {
            one_sided += u32::from(one.is_some() != other.is_some());
            continue;
        };
        hits += 1;
        assert!((one.t - other.t).abs() < 1e-4 * one.t);
        let (one, other) = (grouped.surface(&ray, &one), alone.surface(&ray, &other));
        assert!(one.position.abs_diff_eq(other.position, 1e-4));
        assert!(one.geometric_normal.abs_diff_eq(other.geometric_normal, 2e-2));
        assert!(one.geometric_normal.dot(ray.dir) < 0.0);
    }
    // Those that touch an edge may miss one of the two.
    assert!(hits > 500 && one_sided <= 4, "{hits} {one_sided}");
}

#[test]
fn a_segment_of_hair_takes_little_memory() {
    let mut random = Random::new(6);
    let strands = strands(5000, 11, 0.001, &mut random);
    let text: String = (strands.points.iter().enumerate())
        .map(|(index, point)| {
            let [x, y, z, w] = point.to_array();
            let blank = if index % 11 == 0 { "\n" } else { "" };
            format!("{blank}{x} {y} {z} {w}\n")
        })
        .collect();
    let read = load_curves(text.as_bytes()).unwrap().mesh;
    assert_eq!(
        (&read.strands.points, &read.strands.firsts),
        (&strands.points, &strands.firsts)
    );
    let promised = read.memory_bytes();
    let curves = CurveBlas::build(Arc::new(read), Basis::BSpline, SplitMethod::Sah);
    assert_eq!(curves.segments(), 5000 * 8);
    let stats = curves.stats();
    let taken = (stats.bytes + strands.heap_bytes()) as u64;
    assert!(taken < promised, "{taken} of {promised}");
    // It is near 550 bytes where segments are cut into eight parts, and near 70 where there are too many for that.
    assert!(stats.leaves > 7 * curves.segments(), "{}", stats.leaves);
    assert!(taken < 600 * curves.segments() as u64, "{taken}");
    let many = self::strands(60_000, 13, 0.001, &mut random);
    let points = many.heap_bytes();
    let curves = self::curves(many, Basis::BSpline, SplitMethod::Sah);
    let stats = curves.stats();
    assert_eq!(stats.leaves, curves.segments());
    assert!(stats.bytes + points < 100 * curves.segments(), "{}", stats.bytes);
}

#[test]
fn curves_of_no_length_and_no_width_are_harmless() {
    let point = Vec4::new(0.1, 0.2, 0.3, 0.0);
    let cases = [
        vec![point; 4],
        vec![point.with_w(0.2); 4],
        vec![point, point, point, point + Vec4::X],
        vec![
            Vec4::new(3e38, 0.0, 0.0, 1.0),
            Vec4::new(-3e38, 0.0, 0.0, 1e38),
            point,
            point,
        ],
        vec![Vec4::new(0.0, 0.0, 0.0, 3e38); 4],
        vec![point, point + Vec4::new(1e-30, 0.0, 0.0, 1e-30), point, point],
    ];
    let mut random = Random::new(7);
    for points in cases {
        for basis in BASES {
            let strands = Strands {
                points: points.clone(),
                firsts: vec![0],
                shortest: (4, 1),
            };
            let curves = curves(strands, basis, SplitMethod::Sah);
            let scene = Tlas::build(vec![placed(curves, Affine3A::IDENTITY)], SplitMethod::Sah);
            for _ in 0..200 {
                let mut ray = ray(&mut random);
                if random.unit() < 0.5 {
                    ray.dir = points[0].truncate() - ray.origin;
                }
                if let Some(hit) = scene.intersect(&ray) {
                    assert!(hit.t > 0.0 && hit.t.is_finite());
                    let surface = scene.surface(&ray, &hit);
                    assert!(!surface.geometric_normal.is_nan() && !surface.dp_du.is_nan() && !surface.dp_dv.is_nan());
                }
            }
        }
    }
}
