//! The walls that a camera outside of a room sees through, told by the shapes of a scene alone.

use std::sync::Arc;

use glam::{Affine3A, Quat, Vec3};
use sunroom::accel::{Blas, Instance, Primitive, SplitMethod, Tlas};
use sunroom::geometry::mesh::MeshData;
use sunroom::geometry::primitives::unit_cube;
use sunroom::geometry::solid::{Roof, RoofForm};
use sunroom::math::Ray;
use sunroom::render::visibility::outer_walls::OuterWalls;
use sunroom::render::visibility::sight::Sight;

/// A cube of the half extents `half` around `center`.
struct Solid {
    name: &'static str,
    center: Vec3,
    half: Vec3,
}

fn solid(name: &'static str, center: [f32; 3], half: [f32; 3]) -> Solid {
    let [center, half] = [center, half].map(Vec3::from);
    Solid { name, center, half }
}

/// Two rooms, each 4 x 3 x 4, side by side on a lawn; with a table, a shelf below the ceiling, and a hedge around.
fn house() -> Vec<Solid> {
    vec![
        solid("lawn", [0.0, -0.3, 0.0], [30.0, 0.1, 30.0]),
        solid("hedge", [0.0, 0.5, -25.0], [25.0, 0.8, 0.1]),
        solid("floor", [0.0, -0.1, 0.0], [4.2, 0.1, 2.2]),
        solid("ceiling", [0.0, 3.1, 0.0], [4.2, 0.1, 2.2]),
        solid("south", [0.0, 1.5, 2.1], [4.2, 1.5, 0.1]),
        solid("north", [0.0, 1.5, -2.1], [4.2, 1.5, 0.1]),
        solid("west", [-4.1, 1.5, 0.0], [0.1, 1.5, 2.0]),
        solid("east", [4.1, 1.5, 0.0], [0.1, 1.5, 2.0]),
        solid("between", [0.0, 1.5, 0.0], [0.1, 1.5, 2.0]),
        solid("table top", [-2.0, 0.75, 0.0], [0.8, 0.02, 0.5]),
        solid("leg", [-2.7, 0.36, 0.4], [0.03, 0.36, 0.03]),
        solid("leg", [-1.3, 0.36, 0.4], [0.03, 0.36, 0.03]),
        solid("leg", [-2.7, 0.36, -0.4], [0.03, 0.36, 0.03]),
        solid("leg", [-1.3, 0.36, -0.4], [0.03, 0.36, 0.03]),
        solid("shelf side", [1.5, 0.8, -1.0], [0.02, 0.8, 0.2]),
        solid("shelf side", [2.5, 0.8, -1.0], [0.02, 0.8, 0.2]),
        solid("board", [2.0, 1.6, -1.0], [0.52, 0.02, 0.2]),
        solid("board", [2.0, 0.8, -1.0], [0.48, 0.02, 0.2]),
        solid("board", [2.0, 0.1, -1.0], [0.48, 0.02, 0.2]),
        solid("stool", [2.0, 0.2, 1.0], [0.2, 0.2, 0.2]),
    ]
}

fn mesh(mesh: MeshData) -> Primitive {
    Primitive::Mesh(Arc::new(Blas::build(Arc::new(mesh), SplitMethod::Sah)))
}

/// What a camera ray from `from` to `to` meets, in a scene that is turned by `turned` as a whole.
fn met(solids: &[Solid], turned: Quat, from: [f32; 3], to: [f32; 3]) -> Option<&'static str> {
    met_under(None, solids, turned, from, to)
}

/// The same below a roof, whose lower side is at this height.
fn met_under(
    roof: Option<(Roof, f32)>,
    solids: &[Solid],
    turned: Quat,
    from: [f32; 3],
    to: [f32; 3],
) -> Option<&'static str> {
    let cube = mesh(unit_cube());
    let place = |solid: &Solid| {
        let at = Affine3A::from_scale_rotation_translation(solid.half, turned, turned * solid.center);
        Instance::new(cube.clone(), at).expect("it can be inverted")
    };
    let mut instances: Vec<Instance> = solids.iter().map(place).collect();
    if let Some((roof, height)) = roof {
        let upright = Quat::from_rotation_x(-std::f32::consts::FRAC_PI_2);
        let at = Affine3A::from_rotation_translation(turned * upright, turned * (height * Vec3::Y));
        let shape = mesh(sunroom::geometry::solid::roof(&roof));
        instances.push(Instance::new(shape, at).expect("it can be inverted"));
    }
    let scene = Tlas::build(instances, SplitMethod::Sah);
    let sight = Sight {
        passes_backs: true,
        outer_walls: OuterWalls::find(&scene),
        ..Sight::default()
    };
    let [from, to] = [from, to].map(|point| turned * Vec3::from(point));
    let hit = scene.intersect(&sight.narrow(&scene, Ray::new(from, to - from)))?;
    let of_roof = if hit.t < 1.0 { "near slope" } else { "far slope" };
    Some(solids.get(hit.instance as usize).map_or(of_roof, |solid| solid.name))
}

#[test]
fn one_sees_into_a_solid_house_from_outside() {
    let house = house();
    for turned in [Quat::IDENTITY, Quat::from_rotation_y(0.6)] {
        let met = |from, to| met(&house, turned, from, to);
        assert_eq!(met([-2.0, 9.0, 0.0], [-2.0, 0.0, 0.0]), Some("table top"), "{turned}");
        assert_eq!(met([2.0, 9.0, -1.0], [2.0, 0.0, -1.0]), Some("board"), "{turned}");
        assert_eq!(met([-3.5, 9.0, 1.5], [-3.5, 0.0, 1.5]), Some("floor"), "{turned}");
        assert_eq!(met([2.0, 0.2, 9.0], [2.0, 0.2, 0.0]), Some("stool"), "{turned}");
        assert_eq!(met([-9.0, 2.0, 0.0], [0.0, 2.0, 0.0]), Some("between"), "{turned}");
        assert_eq!(met([9.0, 2.0, 0.0], [0.0, 2.0, 0.0]), Some("between"), "{turned}");
        // Tops and ends of walls that touch hidden ones are seen: they lie in one plane with them.
        for along in [-1.5, -0.7, 0.1, 0.9, 1.7] {
            assert_eq!(met([-4.1, 9.0, along], [-4.1, 0.0, along]), Some("west"), "{turned}");
            assert_eq!(met([0.0, 9.0, along], [0.03, 0.0, along]), Some("between"), "{turned}");
            // At its other end this wall touches the one to the north.
            let end = met([-4.1, 1.5 + 0.6 * along, 9.0], [-4.1, 1.5 + 0.6 * along, 0.0]);
            assert!([Some("west"), Some("north")].contains(&end), "{end:?} {turned}");
        }
        // The far walls stay, seen from within or from outside.
        assert_eq!(met([-2.0, 1.5, 9.0], [-2.0, 1.5, -1.0]), Some("north"), "{turned}");
        assert_eq!(met([-2.0, 1.5, 0.0], [-2.0, 3.0, 0.0]), Some("ceiling"), "{turned}");
        assert_eq!(met([9.0, 9.0, 9.0], [9.0, 0.0, 9.0]), Some("lawn"), "{turned}");
    }
}

#[test]
fn furniture_without_a_house_is_seen() {
    let furniture: Vec<Solid> = house()
        .into_iter()
        .filter(|solid| ["lawn", "table top", "leg", "stool"].contains(&solid.name))
        .collect();
    let met = |from, to| met(&furniture, Quat::IDENTITY, from, to);
    assert_eq!(met([-2.0, 9.0, 0.0], [-2.0, 0.0, 0.0]), Some("table top"));
    assert_eq!(met([2.0, 9.0, 1.0], [2.0, 0.0, 1.0]), Some("stool"));
}

#[test]
fn an_upper_storey_hides_the_lower_one() {
    let mut storeys = house();
    let is_shell =
        |solid: &Solid| ["floor", "ceiling", "south", "north", "west", "east", "between"].contains(&solid.name);
    storeys.extend(house().into_iter().filter(is_shell).map(|solid| Solid {
        center: solid.center + 3.3 * Vec3::Y,
        ..solid
    }));
    let met = |from, to| met(&storeys, Quat::IDENTITY, from, to);
    assert_eq!(met([2.0, 15.0, 1.0], [2.0, 0.0, 1.0]), Some("floor"));
}

#[test]
fn one_sees_the_plan_below_a_roof() {
    let without_ceiling: Vec<Solid> = house().into_iter().filter(|solid| solid.name != "ceiling").collect();
    let turned = Quat::from_rotation_y(0.6);
    for form in [RoofForm::Gable, RoofForm::Hip, RoofForm::Shed] {
        let roof = |height| Roof {
            form,
            width: 8.4,
            depth: 4.4,
            height,
            overhang: 0.3,
            thickness: 0.2,
            gable: 0.2,
        };
        for (solids, base) in [(&house(), 3.2), (&without_ceiling, 3.0)] {
            for height in [0.8, 2.0] {
                let met = |from, to| met_under(Some((roof(height), base)), solids, turned, from, to);
                assert_eq!(
                    met([-2.0, 12.0, 0.2], [-2.0, 0.0, 0.2]),
                    Some("table top"),
                    "{form:?} {height} {base}"
                );
                assert_eq!(
                    met([2.0, 12.0, 1.0], [2.0, 0.0, 1.0]),
                    Some("stool"),
                    "{form:?} {height} {base}"
                );
                // From the side the roof is seen; the ridge is above z = 0.
                assert_eq!(
                    met([2.0, base + 0.3, 30.0], [2.0, base + 0.3, 0.0]),
                    Some("near slope"),
                    "{form:?} {height} {base}"
                );
                assert_eq!(
                    met([9.0, 12.0, 9.0], [9.0, 0.0, 9.0]),
                    Some("lawn"),
                    "{form:?} {height} {base}"
                );
            }
        }
    }
}

#[test]
fn a_thick_top_on_a_chest_is_seen() {
    let mut furniture = house();
    furniture.retain(|solid| ["lawn", "floor", "south", "west"].contains(&solid.name));
    // A chest in a corner of an open room, and a block on the lawn.
    furniture.push(solid("chest", [-3.3, 0.5, 1.5], [0.6, 0.5, 0.4]));
    furniture.push(solid("block", [20.0, 0.8, 0.0], [2.0, 1.0, 2.0]));
    let met = |from, to| met(&furniture, Quat::IDENTITY, from, to);
    assert_eq!(met([-3.3, 9.0, 1.5], [-3.3, 0.0, 1.5]), Some("chest"));
    assert_eq!(met([20.0, 9.0, 0.0], [20.0, 0.0, 0.0]), Some("block"));
}
