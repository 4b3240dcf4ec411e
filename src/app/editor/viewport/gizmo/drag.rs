//! Computes the poses of all selected objects after a drag, from the place of the press on a handle and the pointer's
//! present place.
//!
//! The pointer's movement along an axis, in a plane and around a ring is unprojected, so that the handle stays under
//! it. It is limited near horizons and vanishing points, where a pixel would be a mile.

use std::f32::consts::{PI, TAU};

use bevy::math::{Affine3A, Mat3A, Quat, Vec2, Vec3, Vec3A};
use bevy::prelude::Entity;
use bevy_egui::egui::Pos2;

use super::constraint::Constraint;
use super::typed::Typed;
use super::{Frame, Target, bounds, handles};
use crate::app::editor::camera::rounding;
use crate::app::editor::camera::screen::Screen;
use crate::app::editor::command::gizmo_settings::{GizmoSettings, Mode, Pivot};
use crate::app::editor::command::snapping::SnapTo;
use crate::app::editor::input::press::Press;
use crate::app::editor::model::freedom::Freedom;
use crate::scene::LengthUnit;
use crate::scene::euler::tidied;

/// The transform of the selection since the drag began.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Change {
    /// A move in world units.
    Moved(Vec3),
    /// A turn around an axis.
    Turned {
        /// A unit vector.
        axis: Vec3,
        /// Radians, counter-clockwise as seen from the tip of the axis.
        angle: f32,
    },
    /// Scale factors along the axes.
    Scaled(Vec3),
    /// A turn about the origin of the frame, then a move in world units, for snapping to a tilted surface.
    Laid {
        /// The turn.
        turn: Quat,
        /// The move.
        by: Vec3,
    },
}

impl Change {
    /// Whether the change is the identity.
    pub fn is_none(&self) -> bool {
        match self {
            Self::Moved(by) => *by == Vec3::ZERO,
            Self::Turned { angle, .. } => *angle == 0.0,
            Self::Scaled(factors) => *factors == Vec3::ONE,
            Self::Laid { turn, by } => *by == Vec3::ZERO && *turn == Quat::IDENTITY,
        }
    }
}

/// A drag, from the press on.
#[derive(Clone, Debug, PartialEq)]
pub struct Drag {
    /// The frame of the gizmo at the press; it stays there until the drag is over.
    pub frame: Frame,
    /// The targets, with their poses at the press.
    pub targets: Vec<Target>,
    /// The axis or plane that the drag is constrained to.
    pub constraint: Constraint,
    /// Numbers that were typed during the drag; they replace the pointer.
    pub typed: Typed,
    /// The unit of the scene, for lengths that are typed.
    pub(super) lengths: LengthUnit,
    pub(super) settings: GizmoSettings,
    /// The point of the window at which the drag began.
    grabbed: Pos2,
    /// The pointer's last place, and below the angle accumulated up to there: a ring may be turned more than once.
    last: Pos2,
    angle: f32,
    /// The unit to which places are rounded, in world units; 0 for none.
    pub(super) unit: f64,
}

/// The sine of the angle to the view below which axes and planes are too foreshortened to be dragged directly.
const EDGE_ON: f32 = 0.1;
/// The limit of the pointer's distance towards the horizon of a plane or the vanishing point of an axis, as a multiple
/// of the distance of the origin.
const FARTHEST: f32 = 10.0;
/// The points of pointer movement that double the size in an even scaling.
const POINTS_PER_DOUBLING: f32 = 100.0;
/// The smallest factor of a drag, so that things can be enlarged again.
const SMALLEST_FACTOR: f32 = 0.01;
/// Rotations by the pointer are rounded to this many degrees, which is less than a pixel of the ring stands for.
const FINEST_TURN: f64 = 0.1;
/// The significant digits of a scale factor that the pointer chooses, and of the lengths of scaled axes.
const FACTOR_DIGITS: i32 = 4;
const LENGTH_DIGITS: i32 = 6;
/// Places after a typed rotation or factor are rounded to this share of the unit used for the pointer.
pub(super) const TYPED_SHARE: f64 = 1e-3;
/// Places snapped to steps are rounded to this share of a step.
const STEP_SHARE: f32 = 1e-3;

impl Drag {
    /// Begins a drag whose handle was pressed at the point `grabbed` of the window.
    pub fn new(
        frame: Frame,
        targets: Vec<Target>,
        settings: GizmoSettings,
        constraint: Constraint,
        grabbed: Pos2,
    ) -> Self {
        Self {
            frame,
            targets,
            constraint,
            typed: Typed::default(),
            lengths: LengthUnit::None,
            settings,
            grabbed,
            last: grabbed,
            angle: 0.0,
            unit: 0.0,
        }
    }

    /// The drag, with lengths that are typed in a scene of this unit.
    pub(crate) fn with_unit(self, unit: LengthUnit) -> Self {
        Self { lengths: unit, ..self }
    }

    /// The mode of the drag.
    pub fn mode(&self) -> Mode {
        self.settings.mode
    }

    /// Adds the key to the typed text if it belongs to it; returns whether it did.
    pub(crate) fn press(&mut self, press: &Press) -> bool {
        let is_unit = |typed: &mut Typed| typed.press_unit(press.key, press.modifiers.shift);
        self.typed.press(press.key) || (self.settings.mode == Mode::Move && is_unit(&mut self.typed))
    }

    /// Sets another constraint from now on. The same constraint again removes it.
    pub fn constrain(&mut self, constraint: Constraint) {
        self.constraint = if self.constraint == constraint {
            Constraint::Free
        } else {
            constraint
        };
        self.last = self.grabbed;
        self.angle = 0.0;
    }

    /// Begins to follow a pointer at this place.
    pub(crate) fn take_hold(&mut self, pointer: Pos2) {
        self.grabbed = pointer;
        self.last = pointer;
        self.angle = 0.0;
    }

    /// The change with the pointer here. `snap` rounds it to steps, for lengths to `length_step` world units.
    pub fn follow(&mut self, screen: &Screen, pointer: Pos2, snap: bool, length_step: f32) -> Change {
        let pixel = screen.units_per_point(screen.depth(self.frame.origin));
        self.unit = rounding::unit_of_pixel(pixel);
        let numbers = match self.settings.mode {
            Mode::Move => self.typed.lengths(self.lengths),
            _ => self.typed.numbers(),
        };
        if let Some(numbers) = numbers {
            // A typed move is exact.
            self.unit *= if self.settings.mode == Mode::Move {
                0.0
            } else {
                TYPED_SHARE
            };
            return self.by_numbers(screen, &numbers);
        }
        let steps = self.settings.steps;
        let rounded = |x: f32, step: f32| {
            if snap && step > 0.0 {
                (x / step).round() * step
            } else {
                x
            }
        };
        match self.settings.mode {
            Mode::Move => {
                let moved = self.moved(screen, pointer);
                if !snap {
                    return Change::Moved(moved);
                }
                self.unit = rounding::unit_below(STEP_SHARE * length_step);
                if self.settings.snap.to == SnapTo::Grid && self.is_along_world() {
                    return Change::Moved(self.onto_grid(moved, length_step));
                }
                let along = self.frame.axes.map(|axis| axis * rounded(moved.dot(axis), length_step));
                Change::Moved(rounding::without_residue(along.into_iter().sum()))
            }
            Mode::Rotate => {
                let axis = self.turning_axis(screen);
                let turned = wrapped(self.angle_at(screen, axis, pointer) - self.angle_at(screen, axis, self.last));
                // If the camera is on the axis, no angle can be measured.
                self.angle += if turned.is_finite() { turned } else { 0.0 };
                self.last = pointer;
                let degrees = rounded(self.angle.to_degrees(), steps.degrees);
                Change::Turned {
                    axis,
                    angle: rounding::rounded(degrees, FINEST_TURN).to_radians(),
                }
            }
            Mode::Scale => {
                let factor = self.factor(screen, pointer);
                let factor = if factor.is_finite() { factor } else { 1.0 };
                let factor = rounded(factor, steps.factor).max(SMALLEST_FACTOR);
                Change::Scaled(self.spread(rounding::with_digits(factor, FACTOR_DIGITS)))
            }
        }
    }

    pub(super) fn is_along_world(&self) -> bool {
        self.frame.axes.iter().all(|axis| axis.abs().max_element() == 1.0)
    }

    /// The move that puts the lowest point of the selection, along `up`, onto the surface.
    pub fn onto_surface(&self, surface: Vec3, up: Vec3) -> Change {
        Change::Moved(surface - lowest_point(&self.targets, up).unwrap_or(self.frame.origin))
    }

    fn by_numbers(&self, screen: &Screen, numbers: &[f32]) -> Change {
        let first = numbers.first().copied().unwrap_or(0.0);
        match self.settings.mode {
            Mode::Move => {
                let along = match self.constraint {
                    Constraint::Axis(k) => vec![k],
                    Constraint::Plane(normal) => (0..3).filter(|&k| k != normal).collect(),
                    Constraint::Free => vec![0, 1, 2],
                };
                let steps = along.into_iter().zip(numbers).map(|(k, &by)| self.frame.axes[k] * by);
                let by = steps.sum();
                Change::Moved(if self.is_along_world() {
                    by
                } else {
                    rounding::without_residue(by)
                })
            }
            Mode::Rotate => Change::Turned {
                axis: self.turning_axis(screen),
                angle: first.to_radians(),
            },
            Mode::Scale if self.constraint == Constraint::Free && numbers.len() == 3 => {
                Change::Scaled(Vec3::from_slice(numbers))
            }
            Mode::Scale => Change::Scaled(self.spread(first)),
        }
    }

    /// The factor along the axes that the constraint leaves.
    fn spread(&self, factor: f32) -> Vec3 {
        Vec3::from_array(std::array::from_fn(|k| match self.constraint {
            Constraint::Axis(axis) if k != axis => 1.0,
            Constraint::Plane(normal) if k == normal => 1.0,
            _ => factor,
        }))
    }

    fn turning_axis(&self, screen: &Screen) -> Vec3 {
        match self.constraint {
            Constraint::Axis(k) | Constraint::Plane(k) => self.frame.axes[k],
            Constraint::Free => match screen.direction_to(self.frame.origin) {
                // The camera is at the origin.
                Vec3::ZERO => -screen.forward(),
                direction => -direction,
            },
        }
    }

    pub(super) fn moved(&self, screen: &Screen, pointer: Pos2) -> Vec3 {
        match self.constraint {
            Constraint::Axis(k) => {
                let axis = self.frame.axes[k];
                axis * (self.along(screen, axis, pointer) - self.along(screen, axis, self.grabbed))
            }
            Constraint::Plane(k) => self.in_plane(screen, self.frame.axes[k], pointer),
            Constraint::Free => self.in_view(screen, pointer),
        }
    }

    /// The point of the pointer in the plane of the view through the origin.
    fn in_view(&self, screen: &Screen, pointer: Pos2) -> Vec3 {
        let depth = screen.depth(self.frame.origin);
        screen.unproject(pointer, depth) - screen.unproject(self.grabbed, depth)
    }

    /// The distance along the axis from the origin to the point of the axis nearest to the pointer.
    fn along(&self, screen: &Screen, axis: Vec3, pointer: Pos2) -> f32 {
        let origin = self.frame.origin;
        let depth = screen.depth(origin);
        let unit = screen.units_per_point(depth);
        let (Some(at_origin), true) = (screen.project(origin), unit > 0.0) else {
            return 0.0;
        };
        let from_origin = to_vec2(pointer - at_origin);
        let deepening = screen.forward().dot(axis);
        // The points per world unit at the origin: the axis without its part towards the viewer, seen at the origin.
        let across =
            axis - screen.direction_to(origin) * (deepening / screen.forward().dot(screen.direction_to(origin)));
        let step = handles::SIZE * unit;
        let tangent = screen
            .project(origin + across * step)
            .map_or(Vec2::ZERO, |tip| to_vec2(tip - at_origin) / step);
        let length = tangent.length();
        if length * unit < EDGE_ON {
            // Towards or away from the viewer: up is away.
            return -from_origin.y * unit * deepening.signum();
        }
        let t = from_origin.dot(tangent) / (length * length);
        if screen.camera.is_orthographic() {
            return t;
        }
        // The window shows s units along the axis as t = s depth / (depth + s deepening).
        let horizon = 1.0 - t * deepening / depth;
        t / horizon.max(1.0 / FARTHEST)
    }

    fn in_plane(&self, screen: &Screen, normal: Vec3, pointer: Pos2) -> Vec3 {
        let origin = self.frame.origin;
        if normal.dot(screen.direction_to(origin)).abs() < EDGE_ON {
            return self.in_view(screen, pointer).reject_from(normal);
        }
        let depth = screen.depth(origin);
        let hit = |at: Pos2| {
            let ray = screen.ray(at);
            ray.at(normal.dot(origin - ray.origin) / normal.dot(ray.dir))
        };
        if screen.camera.is_orthographic() {
            return hit(pointer) - hit(self.grabbed);
        }
        // One over the distance to the plane, in the origin's; across the window it falls evenly, to 0 at the horizon.
        let nearness = |at: Pos2| {
            let ray = screen.ray(at);
            depth * normal.dot(ray.dir) / normal.dot(origin - ray.origin)
        };
        let (from, to) = (nearness(self.grabbed), nearness(pointer));
        let least = 1.0 / FARTHEST;
        if from < least {
            return Vec3::ZERO;
        }
        let share = if to < least { (from - least) / (from - to) } else { 1.0 };
        hit(self.grabbed + (pointer - self.grabbed) * share) - hit(self.grabbed)
    }

    /// The angle around the axis at the pointer, from an arbitrary zero.
    fn angle_at(&self, screen: &Screen, axis: Vec3, pointer: Pos2) -> f32 {
        let origin = self.frame.origin;
        let view = screen.direction_to(origin);
        let depth = screen.depth(origin);
        let out = screen.unproject(pointer, depth) - origin;
        let facing = axis.dot(view);
        if facing.abs() < 2.0 * EDGE_ON {
            // The ring is a line: its near side follows the pointer.
            let near_side_moves = axis.cross(-view).normalize_or_zero();
            let radius = handles::RING * screen.units_per_point(depth);
            return out.dot(near_side_moves) / radius;
        }
        let in_plane = out - view * (axis.dot(out) / facing);
        let (x, y) = axis.any_orthonormal_pair();
        in_plane.dot(y).atan2(in_plane.dot(x))
    }

    fn factor(&self, screen: &Screen, pointer: Pos2) -> f32 {
        let way = pointer - self.grabbed;
        let Constraint::Axis(k) = self.constraint else {
            return ((way.x - way.y) / POINTS_PER_DOUBLING).exp2();
        };
        let [start, now] = [self.grabbed, pointer].map(|at| self.along(screen, self.frame.axes[k], at));
        let point = screen.units_per_point(screen.depth(self.frame.origin));
        if start > 0.2 * handles::SIZE * point {
            now / start
        } else {
            // The drag began near the middle, or behind it, so that there is no distance to compare with.
            ((now - start) / (point * POINTS_PER_DOUBLING)).exp2()
        }
    }

    /// The poses of all objects after the change. An object keeps its pose if the change would make it singular.
    pub fn apply(&self, change: Change) -> Vec<(Entity, Affine3A)> {
        let changed = |target: &Target| {
            let to_world = self.applied(target, change);
            let is_sound = to_world.is_finite() && (to_world.matrix3.determinant() != 0.0 || target.is_degenerate());
            (target.entity, if is_sound { to_world } else { target.to_world })
        };
        self.targets.iter().map(changed).collect()
    }

    fn applied(&self, target: &Target, change: Change) -> Affine3A {
        let Affine3A { matrix3, translation } = target.to_world;
        let has_place = target.freedom != Freedom::Turning;
        let pivot = match self.settings.pivot {
            Pivot::Each => target.origin(),
            Pivot::Middle | Pivot::Median | Pivot::Active | Pivot::World => self.frame.origin,
        };
        let from_pivot = target.origin() - pivot;
        match change {
            Change::Moved(by) if has_place => Affine3A {
                matrix3,
                translation: rounding::moved(translation.into(), by, self.unit).into(),
            },
            Change::Turned { axis, angle } => {
                let turn = Quat::from_axis_angle(axis.normalize_or(Vec3::Y), angle);
                let turned = rounding::rounded_place(pivot + turn * from_pivot, self.unit);
                let stays = !has_place || from_pivot == Vec3::ZERO;
                Affine3A {
                    matrix3: tidied(&(Mat3A::from_quat(turn) * matrix3)),
                    translation: if stays { translation } else { turned.into() },
                }
            }
            Change::Scaled(factors) if has_place => {
                // The object moves away from the pivot along the frame's axes, and grows along its own.
                let middle = if self.settings.pivot == Pivot::Each {
                    target.origin()
                } else {
                    target.middle()
                };
                let out = middle - pivot;
                let axes = self.frame.axes.iter().zip(factors.to_array());
                let moved: Vec3 = axes.map(|(axis, factor)| *axis * (out.dot(*axis) * factor)).sum();
                let place = |place: Vec3| match place.abs_diff_eq(target.origin(), 0.5 * self.unit as f32) {
                    true => translation,
                    false => rounding::rounded_place(place, self.unit).into(),
                };
                if target.freedom != Freedom::Affine {
                    let translation = place(pivot + moved);
                    return Affine3A { matrix3, translation };
                }
                let scaled = matrix3 * Mat3A::from_diagonal(short_factors(&matrix3, factors));
                let origin_from_middle = Vec3A::from(target.origin() - middle);
                let translation = Vec3A::from(pivot + moved) + scaled * (matrix3.inverse() * origin_from_middle);
                Affine3A {
                    matrix3: scaled,
                    translation: place(translation.into()),
                }
            }
            Change::Laid { turn, by } if has_place => {
                let origin = self.frame.origin;
                let place = origin + turn * (target.origin() - origin) + by;
                Affine3A {
                    matrix3: Mat3A::from_quat(turn) * matrix3,
                    translation: rounding::rounded_place(place, self.unit).into(),
                }
            }
            Change::Moved(_) | Change::Scaled(_) | Change::Laid { .. } => target.to_world,
        }
    }
}

impl Target {
    fn is_degenerate(&self) -> bool {
        self.to_world.matrix3.determinant() == 0.0
    }
}

/// The centre of the lower face of the targets' common bounds; None if the bounds are empty. `up` is an axis of the
/// world or its opposite.
pub fn lowest_point(targets: &[Target], up: Vec3) -> Option<Vec3> {
    let all = bounds(targets);
    (!all.is_empty()).then(|| all.center() - up * (0.5 * all.extent().dot(up.abs())))
}

/// The scale factors, changed slightly so that the axes get lengths of few digits.
fn short_factors(axes: &Mat3A, factors: Vec3) -> Vec3 {
    let factor = |axis: Vec3A, factor: f32| {
        let length = axis.length();
        let short = rounding::with_digits((length * factor).abs(), LENGTH_DIGITS).copysign(factor) / length;
        if factor != 1.0 && short.is_finite() {
            short
        } else {
            factor
        }
    };
    let Mat3A { x_axis, y_axis, z_axis } = *axes;
    Vec3::new(
        factor(x_axis, factors.x),
        factor(y_axis, factors.y),
        factor(z_axis, factors.z),
    )
}

fn to_vec2(v: bevy_egui::egui::Vec2) -> Vec2 {
    Vec2::new(v.x, v.y)
}

/// The same angle in [-pi, pi).
fn wrapped(angle: f32) -> f32 {
    (angle + PI).rem_euclid(TAU) - PI
}
