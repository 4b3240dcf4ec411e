//! Drags the gizmo's handles without a window: what is under the pointer stays under it, nothing leaps, and objects
//! stand where they should.

use std::f32::consts::{FRAC_PI_2, PI};

use bevy::math::{Affine3A, Quat, Vec2, Vec3};
use bevy::prelude::Entity;
use bevy_egui::egui::{Key, Pos2, Rect, vec2};
use sunroom::app::editor::camera::screen::Screen;
use sunroom::app::editor::camera::solid::Solid;
use sunroom::app::editor::command::gizmo_settings::{Axes, GizmoSettings, Mode, Pivot, Steps};
use sunroom::app::editor::command::snapping::{SnapTo, Snapping};
use sunroom::app::editor::model::freedom::Freedom;
use sunroom::app::editor::viewport::gizmo::constraint::Constraint;
use sunroom::app::editor::viewport::gizmo::drag::{Change, Drag, lowest_point};
use sunroom::app::editor::viewport::gizmo::{Frame, Target, frame};
use sunroom::math::Aabb;
use sunroom::render::camera::Camera;

/// From (3, 2, -8) towards the origin.
fn screens() -> [Screen; 2] {
    let from = Vec3::new(3.0, 2.0, -8.0);
    let forward = -from.normalize();
    let left = Vec3::Y.cross(forward).normalize();
    let pose = Affine3A::from_mat3_translation(bevy::math::Mat3::from_cols(left, forward.cross(left), forward), from);
    let picture = Rect::from_min_size(Pos2::new(200.0, 30.0), vec2(800.0, 600.0));
    let half_extent = Vec2::new(8.0, 6.0);
    [
        Camera::new(pose, 70.0, 4.0 / 3.0, 0.01, 1000.0, None),
        Camera::orthographic(pose, half_extent, 0.01, 1000.0),
    ]
    .map(|camera| Screen { camera, picture })
}

fn at(screen: &Screen, world: Vec3) -> Pos2 {
    screen.project(world).expect("in front of the camera")
}

fn entity(index: u32) -> Entity {
    Entity::from_raw_u32(index).expect("a small index is valid")
}

/// A cube of two units, placed.
fn cube(index: u32, to_world: Affine3A) -> Target {
    let unit = Aabb {
        min: Vec3::NEG_ONE,
        max: Vec3::ONE,
    };
    Target {
        entity: entity(index),
        to_world,
        freedom: Freedom::Affine,
        bounds: Some(unit.transformed(&to_world)),
    }
}

fn settings(mode: Mode) -> GizmoSettings {
    GizmoSettings {
        mode,
        ..GizmoSettings::default()
    }
}

fn begin(targets: &[Target], settings: GizmoSettings, constraint: Constraint, grabbed: Pos2) -> Drag {
    let frame = frame(targets, &settings, Vec3::ZERO).expect("something can be dragged");
    Drag::new(frame, targets.to_vec(), settings, constraint, grabbed)
}

fn moved(change: Change) -> Vec3 {
    match change {
        Change::Moved(by) => by,
        other => panic!("not a move: {other:?}"),
    }
}

fn angle(change: Change) -> f32 {
    match change {
        Change::Turned { angle, .. } => angle,
        other => panic!("not a turn: {other:?}"),
    }
}

fn factors(change: Change) -> Vec3 {
    match change {
        Change::Scaled(factors) => factors,
        other => panic!("not a scaling: {other:?}"),
    }
}

fn turned_cube() -> Target {
    let rotation = Quat::from_euler(bevy::math::EulerRot::XYZ, 0.7, -0.6, 0.4);
    let scale = Vec3::new(1.0, 0.4, 2.0);
    cube(
        1,
        Affine3A::from_scale_rotation_translation(scale, rotation, Vec3::new(0.5, -0.3, 0.7)),
    )
}

/// There nothing is seen of it, and there is no angle and no distance to follow.
#[test]
fn what_is_where_the_camera_is_stays_sound() {
    let screen = screens()[0];
    let eye = Vec3::new(3.0, 2.0, -8.0);
    let target = cube(1, Affine3A::from_translation(eye));
    for mode in [Mode::Move, Mode::Rotate, Mode::Scale] {
        for constraint in [Constraint::Free, Constraint::Axis(0), Constraint::Plane(1)] {
            let mut drag = begin(&[target], settings(mode), constraint, Pos2::new(400.0, 300.0));
            let change = drag.follow(&screen, Pos2::new(430.0, 310.0), false, 1.0);
            // An even scaling asks only how far the pointer has come.
            let is_even = mode == Mode::Scale && constraint != Constraint::Axis(0);
            assert!(change.is_none() || is_even, "{mode:?} {constraint:?}: {change:?}");
            assert!(drag.apply(change).iter().all(|(_, pose)| pose.is_finite()));
            let text = drag.text(change, 1.0);
            assert!(!text.contains("NaN"), "{text}");
        }
    }
    // A number still turns it.
    let mut drag = begin(&[target], settings(Mode::Rotate), Constraint::Free, Pos2::ZERO);
    drag.typed.press(Key::Num9);
    let Change::Turned { axis, angle } = drag.follow(&screen, Pos2::ZERO, false, 1.0) else {
        panic!("no turn");
    };
    assert!(axis.is_normalized() && (angle.to_degrees() - 9.0).abs() < 1e-4);
}

#[test]
fn what_is_taken_hold_of_stays_under_the_pointer() {
    for screen in screens() {
        for axes in [Axes::World, Axes::Local] {
            let settings = GizmoSettings {
                axes,
                ..settings(Mode::Move)
            };
            let target = turned_cube();
            for k in 0..3 {
                let drag = |constraint, grabbed| begin(&[target], settings, constraint, grabbed);
                let Frame { origin, axes } = drag(Constraint::Free, Pos2::ZERO).frame;
                for way in [-1.5, 0.3, 2.0] {
                    let (start, end) = (origin + 0.8 * axes[k], origin + (0.8 + way) * axes[k]);
                    let by =
                        drag(Constraint::Axis(k), at(&screen, start)).follow(&screen, at(&screen, end), false, 1.0);
                    assert!(moved(by).abs_diff_eq(end - start, 1e-3), "axis {k} by {way}: {by:?}");
                    let aside = 0.7 * way * axes[(k + 1) % 3] + way * axes[(k + 2) % 3];
                    let (start, end) = (origin + 0.2 * axes[(k + 1) % 3], origin + aside);
                    let by =
                        drag(Constraint::Plane(k), at(&screen, start)).follow(&screen, at(&screen, end), false, 1.0);
                    assert!(moved(by).abs_diff_eq(end - start, 1e-3), "plane {k} by {way}: {by:?}");
                }
            }
            let mut drag = begin(&[target], settings, Constraint::Free, at(&screen, target.middle()));
            let pointer = at(&screen, target.middle()) + vec2(120.0, -33.0);
            let by = moved(drag.follow(&screen, pointer, false, 1.0));
            assert!(at(&screen, target.middle() + by).distance(pointer) < 0.01);
            assert!(by.dot(screen.forward()).abs() < 1e-4);
        }
    }
}

#[test]
fn nothing_leaps_wherever_the_pointer_goes() {
    // Axes along the view, across it, and level with the eye, so that the window is full of horizons.
    let from = Vec3::new(3.0, 2.0, -8.0);
    let along = -from.normalize();
    let across = along.any_orthonormal_vector();
    for screen in screens() {
        for axes in [[along, across, along.cross(across)], Vec3::AXES] {
            for mode in [Mode::Move, Mode::Rotate, Mode::Scale] {
                for constraint in (0..3).flat_map(|k| [Constraint::Axis(k), Constraint::Plane(k)]) {
                    let target = turned_cube();
                    let frame = Frame {
                        origin: target.middle(),
                        axes,
                    };
                    let grabbed = at(&screen, frame.origin) + vec2(40.0, 25.0);
                    let mut drag = Drag::new(frame, vec![target], settings(mode), constraint, grabbed);
                    let mut last: Option<Affine3A> = None;
                    for step in 0..2000 {
                        let t = step as f32 / 2000.0;
                        let out = vec2((13.0 * t).sin(), (17.0 * t).cos()) * 900.0;
                        let change = drag.follow(&screen, grabbed + out, false, 1.0);
                        let [(_, to_world)] = drag.apply(change)[..] else {
                            panic!("one object")
                        };
                        assert!(to_world.is_finite(), "{mode:?} {constraint:?}: {to_world}");
                        if let (Some(last), Mode::Move) = (last, mode) {
                            // A step is up to 10 points of 0.016 units. At the farthest the picture is 10 times as
                            // coarse across and 100 times in depth, and a plane is seen at
                            // a sine of 0.1 or more.
                            let leap = (to_world.translation - last.translation).length();
                            assert!(leap < 10.0 * 0.016 * 100.0 / 0.1, "{constraint:?}: {leap}");
                        }
                        last = Some(to_world);
                    }
                }
            }
        }
    }
}

#[test]
fn rings_turn_with_the_pointer_and_more_than_once() {
    let [_, screen] = screens();
    let target = turned_cube();
    for k in 0..3 {
        let ring = |angle: f32| {
            let (a, b) = (Vec3::AXES[(k + 1) % 3], Vec3::AXES[(k + 2) % 3]);
            at(&screen, target.middle() + 2.0 * (a * angle.cos() + b * angle.sin()))
        };
        let mut drag = begin(&[target], settings(Mode::Rotate), Constraint::Axis(k), ring(0.4));
        let mut turned = 0.0;
        for step in 1..=50 {
            turned = 0.2 * step as f32;
            let change = drag.follow(&screen, ring(0.4 + turned), false, 1.0);
            assert!(
                (angle(change) - turned).abs() < 1e-3,
                "axis {k}: {change:?} for {turned}"
            );
        }
        assert!(turned > PI * 3.0);
        let back = drag.follow(&screen, ring(0.4 + turned - 0.2), false, 1.0);
        assert!((angle(back) - turned + 0.2).abs() < 1e-3);
    }
}

#[test]
fn a_ring_seen_from_its_edge_follows_its_near_side() {
    for screen in screens() {
        let target = cube(1, Affine3A::IDENTITY);
        let view = screen.direction_to(Vec3::ZERO);
        let up = screen.forward().any_orthonormal_vector();
        let level = Frame {
            origin: Vec3::ZERO,
            axes: [up, view, up.cross(view)],
        };
        let near = -0.5 * view;
        let mut drag = Drag::new(
            level,
            vec![target],
            settings(Mode::Rotate),
            Constraint::Axis(0),
            at(&screen, near),
        );
        let right = at(&screen, near + 0.5 * up.cross(near).normalize());
        assert!(angle(drag.follow(&screen, right, false, 1.0)) > 0.1);
    }
}

#[test]
fn turning_keeps_the_pivot_and_scaling_too() {
    let targets = [
        turned_cube(),
        cube(2, Affine3A::from_translation(Vec3::new(-3.0, 1.0, 0.0))),
    ];
    for pivot in [Pivot::Middle, Pivot::Active, Pivot::Each] {
        let settings = GizmoSettings {
            pivot,
            ..settings(Mode::Rotate)
        };
        let drag = begin(&targets, settings, Constraint::Axis(1), Pos2::ZERO);
        let half = Change::Turned {
            axis: Vec3::Y,
            angle: FRAC_PI_2,
        };
        for (target, (entity, turned)) in targets.iter().zip(drag.apply(half)) {
            assert_eq!(entity, target.entity);
            let pivot = if pivot == Pivot::Each {
                target.origin()
            } else {
                drag.frame.origin
            };
            let local = target.to_world.inverse().transform_point3(pivot);
            assert!(
                turned.transform_point3(local).abs_diff_eq(pivot, 1e-4),
                "the pivot moved"
            );
            let (x, z) = (target.to_world.matrix3.x_axis, turned.matrix3.x_axis);
            assert!((z - Quat::from_rotation_y(FRAC_PI_2) * x).length() < 1e-5);
        }
    }
}

#[test]
fn an_object_grows_about_its_middle_along_its_own_axes() {
    // Its own space's origin is far from what is seen of it.
    let mut target = turned_cube();
    let beside = Affine3A::from_translation(Vec3::new(5.0, 0.0, 0.0));
    target.to_world *= beside.inverse();
    let drag = begin(&[target], settings(Mode::Scale), Constraint::Axis(0), Pos2::ZERO);
    let [(_, scaled)] = drag.apply(Change::Scaled(Vec3::new(3.0, 1.0, 1.0)))[..] else {
        panic!("one object")
    };
    let of = |to_world: Affine3A, x: f32| to_world.transform_point3(Vec3::new(5.0 + x, 0.2, -0.4));
    let middle = target.to_world.transform_point3(Vec3::new(5.0, 0.0, 0.0));
    assert!(
        scaled
            .transform_point3(Vec3::new(5.0, 0.0, 0.0))
            .abs_diff_eq(middle, 1e-4)
    );
    let (before, after) = (
        of(target.to_world, 1.0) - of(target.to_world, -1.0),
        of(scaled, 1.0) - of(scaled, -1.0),
    );
    assert!(after.abs_diff_eq(3.0 * before, 1e-3));
    assert!((scaled.matrix3.y_axis - target.to_world.matrix3.y_axis).length() < 1e-5);
}

#[test]
fn several_objects_go_apart_when_they_are_scaled() {
    let targets = [-3.0, 5.0].map(|x| cube(x as u32, Affine3A::from_translation(Vec3::new(x, 0.0, 0.0))));
    let drag = begin(&targets, settings(Mode::Scale), Constraint::Free, Pos2::ZERO);
    let scaled = drag.apply(Change::Scaled(Vec3::splat(2.0)));
    let places: Vec<f32> = scaled.iter().map(|(_, to_world)| to_world.translation.x).collect();
    assert_eq!(places, [-7.0, 9.0]);
    assert!(scaled.iter().all(|(_, to_world)| to_world.matrix3.x_axis.x == 2.0));
}

#[test]
fn cameras_keep_their_size_and_skies_their_place() {
    let pose = Affine3A::from_translation(Vec3::new(1.0, 2.0, 3.0));
    let camera = Target {
        freedom: Freedom::Rigid,
        bounds: None,
        ..cube(1, pose)
    };
    let sky = Target {
        freedom: Freedom::Turning,
        bounds: None,
        ..cube(2, pose)
    };
    let drag = begin(
        &[sky, camera, cube(3, Affine3A::IDENTITY)],
        settings(Mode::Move),
        Constraint::Free,
        Pos2::ZERO,
    );
    let [(_, sky_scaled), (_, camera_scaled), _] = drag.apply(Change::Scaled(Vec3::splat(2.0)))[..] else {
        panic!("three objects")
    };
    assert_eq!((sky_scaled, camera_scaled.matrix3), (pose, pose.matrix3));
    assert_ne!(camera_scaled.translation, pose.translation);
    let [(_, sky_moved), (_, camera_moved), _] = drag.apply(Change::Moved(Vec3::X))[..] else {
        panic!("three objects")
    };
    assert_eq!((sky_moved, camera_moved.translation.x), (pose, 2.0));
    let turn = Change::Turned {
        axis: Vec3::Y,
        angle: 1.0,
    };
    let (_, sky_turned) = drag.apply(turn)[0];
    assert!(sky_turned.translation == pose.translation && sky_turned.matrix3 != pose.matrix3);
}

#[test]
fn control_rounds_to_the_step() {
    let [screen, _] = screens();
    let target = cube(1, Affine3A::IDENTITY);
    let start = at(&screen, 0.9 * Vec3::X);
    let mut drag = begin(&[target], settings(Mode::Move), Constraint::Axis(0), start);
    let end = at(&screen, 2.03 * Vec3::X);
    assert!(moved(drag.follow(&screen, end, true, 0.25)).abs_diff_eq(Vec3::X * 1.25, 1e-5));
    let mut drag = begin(&[target], settings(Mode::Scale), Constraint::Axis(0), start);
    assert!(factors(drag.follow(&screen, end, true, 0.25)).abs_diff_eq(Vec3::new(2.3, 1.0, 1.0), 1e-5));
    let steps = Steps {
        degrees: 10.0,
        ..Steps::default()
    };
    let settings = GizmoSettings {
        steps,
        ..settings(Mode::Rotate)
    };
    let middle = at(&screen, Vec3::ZERO);
    let mut drag = begin(&[target], settings, Constraint::Free, middle + vec2(90.0, 0.0));
    // The window's y points down: this is counter-clockwise for the viewer, by 24 degrees.
    let by = drag.follow(
        &screen,
        middle + 90.0 * vec2(24f32.to_radians().cos(), -24f32.to_radians().sin()),
        true,
        1.0,
    );
    assert!((angle(by).to_degrees() - 20.0).abs() < 1e-3, "{by:?}");
}

#[test]
fn typed_numbers_go_along_what_is_held_to() {
    let [screen, _] = screens();
    let type_in = |mode, constraint, keys: &[Key]| {
        let mut drag = begin(
            &[cube(1, Affine3A::IDENTITY)],
            settings(mode),
            Constraint::Free,
            Pos2::ZERO,
        );
        drag.constrain(constraint);
        for &key in keys {
            assert!(drag.typed.press(key));
        }
        drag.follow(&screen, Pos2::new(600.0, 100.0), true, 1.0)
    };
    let keys = [Key::Num1, Key::Period, Key::Num5];
    assert_eq!(
        type_in(Mode::Move, Constraint::Axis(1), &keys),
        Change::Moved(Vec3::Y * 1.5)
    );
    let two = [Key::Num1, Key::Comma, Key::Num2];
    let in_plane = Change::Moved(Vec3::new(1.0, 0.0, 2.0));
    assert_eq!(type_in(Mode::Move, Constraint::Plane(1), &two), in_plane);
    let quarter = Change::Turned {
        axis: Vec3::Z,
        angle: FRAC_PI_2,
    };
    assert_eq!(
        type_in(Mode::Rotate, Constraint::Axis(2), &[Key::Num9, Key::Num0]),
        quarter
    );
    let mirrored = Change::Scaled(Vec3::new(-1.5, 1.0, 1.0));
    let keys = [Key::Num1, Key::Period, Key::Num5, Key::Minus];
    assert_eq!(type_in(Mode::Scale, Constraint::Axis(0), &keys), mirrored);
}

#[test]
fn a_factor_of_zero_leaves_objects_as_they_are() {
    let target = cube(1, Affine3A::IDENTITY);
    let drag = begin(&[target], settings(Mode::Scale), Constraint::Free, Pos2::ZERO);
    for factor in [0.0, f32::NAN, f32::INFINITY] {
        assert_eq!(
            drag.apply(Change::Scaled(Vec3::splat(factor))),
            [(target.entity, target.to_world)]
        );
    }
}

#[test]
fn the_lower_end_comes_onto_the_surface() {
    let targets = [cube(1, Affine3A::from_translation(Vec3::new(2.0, 5.0, 0.0)))];
    for (up, lower_end) in [
        (Vec3::Y, Vec3::new(2.0, 4.0, 0.0)),
        (Vec3::NEG_X, Vec3::new(3.0, 5.0, 0.0)),
    ] {
        assert_eq!(lowest_point(&targets, up), Some(lower_end));
        let drag = begin(&targets, settings(Mode::Move), Constraint::Free, Pos2::ZERO);
        let surface = Vec3::new(-1.0, 0.5, 7.0);
        assert_eq!(moved(drag.onto_surface(surface, up)), surface - lower_end);
    }
}

/// With the mouse a thing comes to numbers of few digits, and to what was typed with the number that was typed.
#[test]
fn places_are_short_numbers() {
    let off = Vec3::new(0.1, -9.536_743e-7, 1.0 / 3.0);
    let target = cube(1, Affine3A::from_translation(off));
    for screen in screens() {
        let mut drag = begin(&[target], settings(Mode::Move), Constraint::Axis(0), at(&screen, off));
        let change = drag.follow(&screen, at(&screen, off) + vec2(33.3, 4.0), false, 1.0);
        let place = drag.apply(change)[0].1.translation;
        assert!(place.x != off.x && place.x.to_string().len() <= 6, "{place}");
        // What does not move stays as it was.
        assert_eq!((place.y, place.z), (off.y, off.z));
        let mut typed = begin(&[target], settings(Mode::Move), Constraint::Axis(0), Pos2::ZERO);
        for key in [Key::Period, Key::Num2] {
            typed.typed.press(key);
        }
        let change = typed.follow(&screen, Pos2::ZERO, false, 1.0);
        assert_eq!(typed.apply(change)[0].1.translation.x.to_string(), "0.3");
    }
}

#[test]
fn on_the_grid_things_come_to_multiples_of_the_step() {
    let off = Vec3::new(0.33, 0.1, -0.27);
    let target = cube(1, Affine3A::from_translation(off));
    let on_grid = |constraint| {
        let snap = Snapping {
            to: SnapTo::Grid,
            ..Snapping::default()
        };
        let settings = GizmoSettings {
            snap,
            ..settings(Mode::Move)
        };
        let screen = screens()[0];
        let mut drag = begin(&[target], settings, constraint, at(&screen, off));
        let change = drag.follow(&screen, at(&screen, off + Vec3::new(0.4, 0.0, 0.3)), true, 0.05);
        drag.apply(change)[0].1.translation
    };
    let place = on_grid(Constraint::Plane(1));
    assert_eq!(
        [place.x, place.y, place.z].map(|x| x.to_string()),
        ["0.75", "0.1", "0.05"]
    );
    let place = on_grid(Constraint::Axis(0));
    assert_eq!((place.y, place.z), (0.1, -0.27));
    assert!((place.x / 0.05 - (place.x / 0.05).round()).abs() < 1e-4, "{place}");
}

#[test]
fn things_are_laid_onto_a_slope() {
    let off = Vec3::new(0.0, 1.0, 0.0);
    let target = cube(1, Affine3A::from_translation(off));
    let bounds = target.bounds.expect("it has a surface");
    let screen = screens()[0];
    let mut drag = begin(&[target], settings(Mode::Move), Constraint::Free, at(&screen, off));
    let normal = Vec3::new(0.6, 0.8, 0.0);
    let solids = [Solid::of_bounds(bounds)];
    let place = Vec3::new(1.0, 0.5, 0.0);
    let change = drag.onto_plane(&screen, &solids, place, normal, Some(Vec3::Y));
    let pose = drag.apply(change)[0].1;
    assert!(Vec3::from(pose.matrix3.y_axis).abs_diff_eq(normal, 1e-5), "{pose:?}");
    assert!(
        Vec3::from(pose.translation).abs_diff_eq(place + normal, 1e-3),
        "{pose:?}"
    );
    let change = drag.onto_plane(&screen, &solids, place, normal, None);
    let pose = drag.apply(change)[0].1;
    // Without a turn its lower edge lies on the slope.
    let lowest = (Vec3::from(pose.translation) - place).dot(normal) - 1.4;
    assert!(lowest.abs() < 1e-3, "{lowest}");
    let corners = solids[0].corners();
    let change = drag.onto_place(&screen, at(&screen, off), &corners, Vec3::new(1.2, 2.1, -0.9));
    let moved = Vec3::from(drag.apply(change)[0].1.translation) - off;
    assert!(moved.abs_diff_eq(Vec3::new(0.2, 0.1, 0.1), 1e-4), "{moved}");
}
