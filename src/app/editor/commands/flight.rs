//! Short flights of the view to the pose that a command has set, so that the user sees where the view goes. A flight is
//! no part of a command: later commands find the view at its end. There are no flights without a user, or if the
//! preferences turn them off.

use std::time::{Duration, Instant};

use bevy::math::{Affine3A, Mat3A, Quat, Vec3, Vec3A};
use bevy::prelude::*;

use crate::app::editor::camera::navigation::scale_of;
use crate::app::editor::camera::pose::view_pose;
use crate::app::editor::command::preferences::Preferences;
use crate::app::editor::command::{Command, ViewCommand};
use crate::app::editor::picture::motion::Motion;
use crate::app::editor::picture::pacing::Pacing;
use crate::scene::{ActiveSensor, FreeView, SceneStatus, ToWorld};

const DURATION: Duration = Duration::from_millis(180);
/// The first step is seen in the frame of the command.
const FIRST_STEP: Duration = Duration::from_millis(16);

#[derive(Resource, Debug, Default)]
pub struct Flights {
    /// Whether there is a user.
    attended: bool,
    course: Option<Course>,
}

impl Flights {
    pub fn new(attended: bool) -> Self {
        Self { attended, course: None }
    }
}

#[derive(Clone, Copy, Debug)]
struct Course {
    from: Affine3A,
    to: Affine3A,
    /// The point that is looked at, if it is known: the view turns around it.
    center: Option<Vec3>,
    /// The view at the end of the flight.
    end: FreeView,
    began: Instant,
    /// The revision of the scene in which the flight began.
    revision: u64,
}

/// Moves the view from the pose `from` to `end` and the camera in use, by a flight if preferences allow it.
pub fn go(world: &mut World, from: Option<Affine3A>, end: FreeView, center: Option<Vec3>) {
    let is_calm = world
        .get_resource::<Preferences>()
        .is_some_and(|known| known.reduced_motion);
    let sensor = world.resource::<ActiveSensor>().0;
    let own = sensor.and_then(|sensor| world.get::<ToWorld>(sensor));
    let to = end.pose.or(own.map(|own| own.0));
    let revision = world.get_resource::<SceneStatus>().map_or(0, |status| status.revision);
    let mut first = end;
    if let (Some(from), Some(to)) = (from, to)
        && from != to
        && let Some(mut flights) = world.get_resource_mut::<Flights>()
        && flights.attended
        && !is_calm
    {
        let began = Instant::now();
        let began = began.checked_sub(FIRST_STEP).unwrap_or(began);
        flights.course = Some(Course {
            from,
            to,
            center,
            end,
            began,
            revision,
        });
        first.pose = Some(from);
    }
    world.resource_mut::<FreeView>().set_if_neq(first);
}

/// Ends the flight before a command, which finds the view at the end of the flight. Only steering by the user starts
/// from the pose in flight.
pub fn make_way(world: &mut World, command: &Command) {
    let Some(mut flights) = world.get_resource_mut::<Flights>() else {
        return;
    };
    if let Some(course) = flights.course.take()
        && !matches!(
            command,
            Command::View(ViewCommand::MoveView(_) | ViewCommand::TurnAbout(_))
        )
    {
        world.resource_mut::<FreeView>().set_if_neq(course.end);
    }
}

/// Advances the flight by a frame.
pub fn fly_on(world: &mut World) {
    let Some(course) = world.resource::<Flights>().course else {
        return;
    };
    if world.resource::<SceneStatus>().revision != course.revision {
        // Another scene was opened, or another camera chosen.
        world.resource_mut::<Flights>().course = None;
        return;
    }
    let share = course.began.elapsed().as_secs_f32() / DURATION.as_secs_f32();
    let is_over = share >= 1.0 || view_pose(world).is_none();
    let next = if is_over {
        world.resource_mut::<Flights>().course = None;
        course.end
    } else {
        FreeView {
            pose: Some(between(&course, eased(share))),
            ..course.end
        }
    };
    world.resource_mut::<FreeView>().set_if_neq(next);
    world.resource_mut::<Motion>().note_change();
    world.resource_mut::<Pacing>().note_commands(true);
}

/// The share of the flight eased at both ends, so that it begins and ends at rest.
fn eased(share: f32) -> f32 {
    let share = share.clamp(0.0, 1.0);
    share * share * (3.0 - 2.0 * share)
}

/// The pose in between. Directions are interpolated, and so is the distance of the centre; the extent is that of the
/// end, since an orthographic extent means nothing in a perspective.
fn between(course: &Course, share: f32) -> Affine3A {
    let (from, to) = (&course.from, &course.to);
    let rotation = direction(from).slerp(direction(to), share);
    let ahead = |pose: &Affine3A| Vec3::from(pose.matrix3.z_axis).normalize_or(Vec3::Z);
    let place = |pose: &Affine3A| Vec3::from(pose.translation);
    let distance = |pose: &Affine3A| {
        let center = course.center.unwrap_or(place(pose));
        (center - place(pose)).dot(ahead(pose)).max(0.0)
    };
    // The point at the distance of the centre moves straight, and the camera orbits it.
    let looked_at = |pose: &Affine3A| place(pose) + ahead(pose) * distance(pose);
    let middle = looked_at(from).lerp(looked_at(to), share);
    let back = rotation * Vec3::Z * distance(from).lerp(distance(to), share);
    let mirror = if to.matrix3.determinant() < 0.0 { -1.0 } else { 1.0 };
    Affine3A {
        matrix3: Mat3A::from_quat(rotation) * Mat3A::from_diagonal(scale_of(to) * Vec3::new(mirror, 1.0, 1.0)),
        translation: Vec3A::from(middle - back),
    }
}

/// The rotation of a pose without its scale; of a mirrored pose, the rotation of its other two axes.
fn direction(pose: &Affine3A) -> Quat {
    let forward = Vec3::from(pose.matrix3.z_axis).normalize_or(Vec3::Z);
    Quat::from_mat3a(&crate::app::editor::camera::navigation::facing(
        forward,
        pose.matrix3.y_axis.into(),
    ))
    .normalize()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::editor::camera::navigation::facing;
    use crate::app::editor::command::CameraEdit;
    use crate::scene::Sensor;

    fn looking(from: Vec3, at: Vec3) -> Affine3A {
        Affine3A {
            matrix3: facing((at - from).normalize(), Vec3::Y),
            translation: from.into(),
        }
    }

    fn course(center: Option<Vec3>) -> Course {
        let to = looking(Vec3::new(6.0, 0.0, 0.0), Vec3::ZERO);
        Course {
            from: looking(Vec3::new(0.0, 0.0, 4.0), Vec3::ZERO),
            to,
            center,
            end: FreeView::at(to),
            revision: 0,
            began: Instant::now(),
        }
    }

    #[test]
    fn a_flight_begins_and_ends_where_it_should() {
        for center in [None, Some(Vec3::ZERO)] {
            let course = course(center);
            assert!(between(&course, eased(0.0)).abs_diff_eq(course.from, 1e-5));
            assert!(between(&course, eased(1.0)).abs_diff_eq(course.to, 1e-5));
        }
    }

    #[test]
    fn it_goes_around_what_is_looked_at() {
        let pose = between(&course(Some(Vec3::ZERO)), 0.5);
        let place = Vec3::from(pose.translation);
        assert!((place.length() - 5.0).abs() < 1e-4, "{place}");
        assert!(Vec3::from(pose.matrix3.z_axis).dot(-place.normalize()) > 0.9999);
    }

    fn world(attended: bool) -> (World, Affine3A, Affine3A) {
        let mut world = World::new();
        world.init_resource::<SceneStatus>();
        let Course { from, to, .. } = course(None);
        let sensor = world.spawn((Sensor::default(), ToWorld(from))).id();
        world.insert_resource(ActiveSensor(Some(sensor)));
        world.insert_resource(Flights::new(attended));
        world.init_resource::<FreeView>();
        world.init_resource::<Motion>();
        world.init_resource::<Pacing>();
        (world, from, to)
    }

    #[test]
    fn without_eyes_on_it_the_view_jumps() {
        let (mut world, from, to) = world(false);
        go(&mut world, Some(from), FreeView::at(to), None);
        assert_eq!(*world.resource::<FreeView>(), FreeView::at(to));
        let (mut world, from, to) = self::world(true);
        world.insert_resource(Preferences {
            reduced_motion: true,
            ..Preferences::default()
        });
        go(&mut world, Some(from), FreeView::at(to), None);
        assert_eq!(*world.resource::<FreeView>(), FreeView::at(to));
    }

    #[test]
    fn what_comes_meanwhile_finds_the_view_at_its_end() {
        let (mut world, from, to) = world(true);
        go(&mut world, Some(from), FreeView::at(to), None);
        assert_eq!(view_pose(&world), Some(from));
        make_way(&mut world, &Command::from(CameraEdit::MoveCameraToView));
        assert_eq!(view_pose(&world), Some(to));
        fly_on(&mut world);
        assert_eq!(view_pose(&world), Some(to));
    }

    #[test]
    fn the_last_frame_is_the_end_itself() {
        let (mut world, from, _) = world(true);
        let there = looking(Vec3::new(0.1, 0.2, 0.3), Vec3::new(1.0, 0.0, 0.7));
        // The view goes back to the camera's own pose.
        world.insert_resource(FreeView::at(there));
        go(&mut world, Some(there), FreeView::default(), None);
        fly_on(&mut world);
        assert!(view_pose(&world).is_some_and(|pose| pose != from));
        if let Some(course) = &mut world.resource_mut::<Flights>().course {
            course.began -= DURATION;
        }
        fly_on(&mut world);
        assert_eq!(*world.resource::<FreeView>(), FreeView::default());
        assert!(world.resource::<Flights>().course.is_none());
    }
}
