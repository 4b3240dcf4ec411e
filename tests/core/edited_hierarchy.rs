//! A hierarchy that follows edits is that of the edited list: in its structure, and in what rays meet.

use std::sync::Arc;

use crate::random::Random;
use glam::{Affine3A, Quat, Vec3};
use sunroom::accel::{Blas, Instance, Primitive, ShapeEdits, SplitMethod, Tlas};
use sunroom::geometry::primitives::unit_cube;
use sunroom::math::{Aabb, Ray};

/// The edge of the cube that shapes are in.
const EDGE: f32 = 40.0;

fn shape(cube: &Arc<Blas>, random: &mut Random) -> Instance {
    let primitive = match random.next_u32() % 8 {
        0 => Primitive::Mesh(cube.clone()),
        1 => Primitive::Cylinder,
        2 => Primitive::Rectangle,
        3 => Primitive::Disk,
        _ => Primitive::Sphere,
    };
    let turn = Quat::from_axis_angle(random.in_cube().normalize_or(Vec3::X), random.unit());
    let size = Vec3::splat(0.2 + random.unit());
    let place = 0.5 * EDGE * random.in_cube();
    Instance::new(primitive, Affine3A::from_scale_rotation_translation(size, turn, place)).expect("it can be inverted")
}

/// Up to three of each kind of edit, and the list after them.
fn edit(shapes: &[Instance], cube: &Arc<Blas>, random: &mut Random) -> (ShapeEdits, Vec<Instance>) {
    let mut edits = ShapeEdits::default();
    let kinds = random.next_u32();
    let some = |wanted: bool, count: usize, random: &mut Random| {
        let number = if wanted { random.next_u32() as usize % 4 } else { 0 };
        let mut numbers: Vec<u32> = (0..number).map(|_| random.next_u32() % count as u32).collect();
        numbers.sort_unstable();
        numbers.dedup();
        numbers
    };
    edits.removed = some(kinds & 1 != 0, shapes.len(), random);
    let replaced = some(kinds & 2 != 0, shapes.len(), random);
    let replaced = replaced.into_iter().filter(|number| !edits.removed.contains(number));
    edits.replaced = replaced.map(|number| (number, shape(cube, random))).collect();
    let mut after: Vec<Instance> = Vec::new();
    for (number, shape) in (0..).zip(shapes) {
        let replaced = edits.replaced.iter().find(|(replaced, _)| *replaced == number);
        if !edits.removed.contains(&number) {
            after.push(replaced.map_or(shape, |(_, new)| new).clone());
        }
    }
    let new = some(kinds & 4 != 0, after.len() + 1, random);
    for number in new {
        let shape = shape(cube, random);
        after.insert(number as usize, shape.clone());
        edits.inserted.push((number, shape));
    }
    if kinds & 8 != 0 {
        let shape = shape(cube, random);
        edits.inserted.push((after.len() as u32, shape.clone()));
        after.push(shape);
    }
    (edits, after)
}

fn rays(random: &mut Random) -> Vec<Ray> {
    let ray = |_| {
        let (origin, target) = (EDGE * random.in_cube(), 0.5 * EDGE * random.in_cube());
        Ray::new(origin, target - origin)
    };
    (0..200).map(ray).collect()
}

#[test]
fn edited_hierarchies_are_those_of_the_edited_lists() {
    let mut random = Random::new(5);
    let cube = Arc::new(Blas::build(Arc::new(unit_cube()), SplitMethod::Sah));
    let mut shapes: Vec<Instance> = (0..3000).map(|_| shape(&cube, &mut random)).collect();
    let mut tlas = Tlas::build(shapes.clone(), SplitMethod::Sah);
    let (mut built_anew, mut rebuilt, mut compared, mut strays) = (0, 0, 0, 0);
    // The step in which a hierarchy was built anew beside the edited one, and both.
    let mut beside: Option<(i32, Tlas, Tlas)> = None;
    for step in 0..2400 {
        let (edits, after) = edit(&shapes, &cube, &mut random);
        tlas = tlas.edited(&edits).unwrap_or_else(|| {
            built_anew += 1;
            Tlas::build(after.clone(), SplitMethod::Sah)
        });
        if tlas.is_worn() && beside.is_none() && rebuilt < built_anew {
            beside = Some((step, tlas.clone(), tlas.rebuilt(SplitMethod::Sah)));
        }
        let caught_up = beside.take_if(|(since, ..)| step > *since + 30);
        let is_new = caught_up.is_some();
        if let Some((_, old, anew)) = caught_up {
            tlas = anew.after_edits(&old, &tlas).expect("thirty edits are few");
            assert!(!tlas.is_worn());
            rebuilt += 1;
        }
        shapes = after;
        assert_eq!(tlas.instances().len(), shapes.len());
        let placed = |shape: &Instance| shape.world_from_local;
        assert!(
            tlas.instances().iter().map(placed).eq(shapes.iter().map(placed)),
            "step {step}"
        );
        if step % 40 > 2 && !is_new {
            continue;
        }
        assert_eq!(tlas.validate(), Ok(()), "step {step}");
        let whole = Tlas::build(shapes.clone(), SplitMethod::Sah);
        assert_eq!(tlas.bounds(), whole.bounds(), "step {step}");
        assert_eq!(tlas.triangles(), whole.triangles());
        let sought = Aabb::EMPTY
            .grown(0.5 * EDGE * random.in_cube())
            .grown(0.5 * EDGE * random.in_cube());
        let mut found = Vec::new();
        assert!(!tlas.any_touching(&sought, |number, bounds| {
            assert_eq!(*bounds, shapes[number as usize].world_bounds());
            found.push(number);
            false
        }));
        found.sort_unstable();
        let touches = |bounds: Aabb| bounds.min.cmple(sought.max).all() && bounds.max.cmpge(sought.min).all();
        let all = (0..).zip(&shapes).filter(|(_, shape)| touches(shape.world_bounds()));
        assert!(all.map(|(number, _)| number).eq(found.iter().copied()), "step {step}");
        let others = (0..).zip(&shapes).filter(|(number, _)| !found.contains(number));
        let others = others.fold(Aabb::EMPTY, |all, (_, shape)| all.union(shape.world_bounds()));
        assert_eq!(tlas.bounds_without(&found), others, "step {step}");
        for ray in rays(&mut random) {
            let (here, there) = (tlas.intersect(&ray), whole.intersect(&ray));
            assert_eq!(tlas.occluded(&ray), here.is_some());
            let is_same = match (here, there) {
                // A shape that is tested in a block is met at a distance that is rounded otherwise.
                (Some(here), Some(there)) => {
                    here.instance == there.instance && (here.t - there.t).abs() <= 1e-5 * (1.0 + there.t)
                }
                (None, None) => true,
                _ => false,
            };
            compared += 1;
            strays += usize::from(!is_same);
        }
    }
    // At a rim rounding decides.
    assert!(compared > 10_000 && strays * 5000 < compared, "{strays} of {compared}");
    // Thousands of shapes have been edited in the course of this.
    assert!((1..5).contains(&built_anew), "{built_anew}");
    assert!((1..5).contains(&rebuilt), "{rebuilt}");
}

#[test]
fn one_shape_dragged_about_stays_one_edit() {
    let mut random = Random::new(6);
    let cube = Arc::new(Blas::build(Arc::new(unit_cube()), SplitMethod::Sah));
    let shapes: Vec<Instance> = (0..3000).map(|_| shape(&cube, &mut random)).collect();
    let mut tlas = Tlas::build(shapes, SplitMethod::Sah);
    for _ in 0..3000 {
        let edits = ShapeEdits {
            replaced: vec![(700, shape(&cube, &mut random))],
            ..ShapeEdits::default()
        };
        tlas = tlas.edited(&edits).expect("one shape is no reason to build anew");
    }
    assert_eq!(tlas.validate(), Ok(()));
}

#[test]
fn small_scenes_and_lists_are_built_anew() {
    let mut random = Random::new(7);
    let cube = Arc::new(Blas::build(Arc::new(unit_cube()), SplitMethod::Sah));
    let mut shapes = |count: usize| (0..count).map(|_| shape(&cube, &mut random)).collect::<Vec<_>>();
    let none = ShapeEdits::default();
    for (count, method) in [(100, SplitMethod::Sah), (3000, SplitMethod::Linear)] {
        assert!(
            Tlas::build(shapes(count), method).edited(&none).is_none(),
            "{count} {method:?}"
        );
    }
}
