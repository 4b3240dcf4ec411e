//! Walking: the view at the eyes of a body that stands on floors, climbs steps, is held by walls, and falls.
//!
//! The body is a vertical cylinder that is tested by rays: a ring of them finds the walls within its radius, and it is
//! moved out of these along their normals, so that it slides along them. Rays downwards find the floor. This is the
//! collide-and-slide scheme of character controllers, on the surfaces that are traced.

use std::f32::consts::TAU;

use bevy::math::{Affine3A, Quat, Vec3, Vec3A};

use super::navigation::{FlyInput, Navigation};
use super::picking;
use crate::engine::PackedScene;
use crate::math::Ray;
use crate::scene::LengthUnit;

/// The measures of a body in world units. Distances are per second or second squared where said.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Body {
    /// The radius of the cylinder.
    pub radius: f32,
    /// The height of the cylinder.
    pub height: f32,
    /// The height of the eyes above the feet.
    pub eyes: f32,
    /// The height of the highest step that it climbs.
    pub step: f32,
    /// The speed on level ground, per second.
    speed: f32,
    /// The least speed at which it follows steps upwards and downwards, per second.
    climb: f32,
    /// The speed at which a jump begins, per second.
    jump: f32,
    /// The acceleration of falling, per second squared.
    gravity: f32,
}

impl Body {
    /// A grown person, who jumps 0.4 m high, in a scene of this unit of length.
    pub fn person(unit: LengthUnit) -> Self {
        const GRAVITY: f32 = 9.81;
        let metre = (1.0 / unit.metres()) as f32;
        Self {
            radius: 0.25 * metre,
            height: 1.75 * metre,
            eyes: 1.65 * metre,
            step: 0.35 * metre,
            speed: 1.5 * metre,
            climb: 2.5 * metre,
            jump: (2.0 * GRAVITY * 0.4f32).sqrt() * metre,
            gravity: GRAVITY * metre,
        }
    }
}

/// A surface that a ray has met.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Touch {
    /// The distance from the origin of the ray.
    pub distance: f32,
    /// The unit normal on the side of the ray's origin.
    pub normal: Vec3,
}

/// Finds the first surface from a point in a unit direction, up to a distance.
pub type Probe<'a> = &'a dyn Fn(Vec3, Vec3, f32) -> Option<Touch>;

/// The motion of a walking body from frame to frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Gait {
    /// The upward speed in world units per second; negative while it falls.
    rise: f32,
    /// Whether it stood on a floor after the last frame.
    stands: bool,
    /// Whether it rose or fell in the last frame.
    is_lifted: bool,
}

/// The least cosine between the normal of a floor and the upward direction: about 50 degrees. Steeper slopes are walls.
const WALKABLE: f32 = 0.64;
/// The directions of the rays that look for walls.
const DIRECTIONS: u32 = 16;
/// The heights at which they begin, between the highest step and the top.
const HEIGHTS: u32 = 5;
/// The points around the axis from which rays go down, and their distance in radii.
const FEET: u32 = 6;
const FOOT: f32 = 0.6;
/// The times that a body is moved out of the walls around it.
const PUSHES: u32 = 6;
/// The parts of the radius by which a body may stay within a wall: in a narrow corner, and by rounding.
const SQUEEZE: f32 = 0.2;
const TOUCHING: f32 = 1e-3;
/// A way is walked in parts of at most this share of the radius, so that no wall is jumped over.
const PART: f32 = 0.5;
/// The most parts of the way of a frame.
const MOST_PARTS: f32 = 64.0;
/// The highest speed of a fall, as a multiple of the acceleration: that after three seconds.
const LONGEST_FALL: f32 = 3.0;

/// The surroundings of a body.
#[derive(Clone, Copy)]
struct Around<'a> {
    body: &'a Body,
    up: Vec3,
    probe: Probe<'a>,
}

impl Gait {
    /// The pose after one frame of walking. Keys upwards jump; the pose keeps its scale.
    pub(crate) fn follow(
        &mut self,
        body: &Body,
        navigation: &Navigation,
        pose: Affine3A,
        input: &FlyInput,
        packed: &PackedScene,
    ) -> Affine3A {
        let turned = FlyInput {
            direction: Vec3::ZERO,
            ..*input
        };
        let pose = navigation.fly(pose, &turned).unwrap_or(pose);
        let up = navigation.up;
        let ahead = navigation.heading(&pose);
        let way = up.cross(ahead) * input.direction.x + ahead * input.direction.z;
        let way = way.clamp_length_max(1.0) * (input.seconds() * input.pace() * navigation.speed * body.speed);
        let around = Around {
            body,
            up,
            probe: &|origin, direction, reach| touch(packed, origin, direction, reach),
        };
        let eyes = up * body.eyes;
        let feet = Vec3::from(pose.translation) - eyes;
        let feet = self.step(&around, feet, way, input.direction.y > 0.0, input.seconds());
        let translation = Vec3A::from(feet + eyes);
        match translation.is_finite() {
            true => Affine3A { translation, ..pose },
            false => pose,
        }
    }

    /// Whether the body goes on moving without input.
    pub(crate) fn is_on_the_move(&self) -> bool {
        self.is_lifted
    }

    /// The place of the feet after `seconds` in which the body walks along the level vector `way`.
    fn step(&mut self, around: &Around, feet: Vec3, way: Vec3, jumps: bool, seconds: f32) -> Vec3 {
        let Around { body, up, .. } = *around;
        let feet = around.walked(feet, way);
        if jumps && self.stands {
            (self.rise, self.stands) = (body.jump, false);
        }
        let floor = around.floor(feet);
        let stays = floor.is_some_and(|floor| floor >= if self.stands { -body.step } else { 0.0 });
        let lift = if self.rise <= 0.0 && stays {
            (self.rise, self.stands) = (0.0, true);
            let most = (body.climb * seconds).max(1.5 * way.length());
            floor.unwrap_or(0.0).clamp(-most, most)
        } else {
            self.fall(around, feet, floor, seconds)
        };
        self.is_lifted = lift.abs() > TOUCHING * body.radius;
        feet + up * lift
    }

    /// The change of height in the air. `floor` is the height of the floor above the feet; without one nothing falls.
    fn fall(&mut self, around: &Around, feet: Vec3, floor: Option<f32>, seconds: f32) -> f32 {
        let Around { body, up, probe } = *around;
        self.stands = false;
        let before = self.rise;
        self.rise = (self.rise - body.gravity * seconds).max(-LONGEST_FALL * body.gravity);
        let mut lift = 0.5 * (before + self.rise) * seconds;
        if lift > 0.0 {
            let head = body.height - body.step;
            if let Some(ceiling) = probe(feet + up * body.step, up, head + lift) {
                (lift, self.rise) = ((ceiling.distance - head).clamp(0.0, lift), 0.0);
            }
        }
        match floor {
            Some(floor) if lift <= floor && self.rise <= 0.0 => {
                (self.rise, self.stands) = (0.0, true);
                floor
            }
            None if self.rise <= 0.0 => {
                self.rise = 0.0;
                0.0
            }
            _ => lift,
        }
    }
}

impl Around<'_> {
    /// The feet after a level way, without what walls take of it.
    fn walked(&self, feet: Vec3, way: Vec3) -> Vec3 {
        if way == Vec3::ZERO {
            return feet;
        }
        let parts = (way.length() / (PART * self.body.radius)).ceil().clamp(1.0, MOST_PARTS);
        let mut feet = feet;
        for _ in 0..parts as u32 {
            match self.pushed_out(feet + way / parts) {
                Some(next) if !self.is_parted(feet, next) => feet = next,
                _ => break,
            }
        }
        feet
    }

    /// The heights above the feet at which walls are looked for.
    fn heights(&self) -> impl Iterator<Item = f32> + use<> {
        let (low, high) = (self.body.step, self.body.height);
        (0..HEIGHTS).map(move |index| low + (high - low) * (index as f32 + 0.1) / (HEIGHTS as f32 - 0.8))
    }

    /// The unit vectors of a ring around the upward axis.
    fn ring(&self, count: u32) -> impl Iterator<Item = Vec3> + use<> {
        let (up, first) = (self.up, self.up.any_orthonormal_vector());
        (0..count).map(move |index| Quat::from_axis_angle(up, TAU * index as f32 / count as f32) * first)
    }

    /// The feet moved out of the walls around them; None where there is no room for the body.
    fn pushed_out(&self, feet: Vec3) -> Option<Vec3> {
        let mut feet = feet;
        for _ in 0..PUSHES {
            let push = self.deepest(feet);
            if push.length() <= TOUCHING * self.body.radius {
                return Some(feet);
            }
            feet += push;
        }
        (self.deepest(feet).length() <= SQUEEZE * self.body.radius).then_some(feet)
    }

    /// The level vector that leads out of the wall into which the body reaches deepest.
    fn deepest(&self, feet: Vec3) -> Vec3 {
        let radius = self.body.radius;
        let mut deepest = Vec3::ZERO;
        for height in self.heights() {
            for direction in self.ring(DIRECTIONS) {
                let Some(Touch { distance, normal }) = (self.probe)(feet + self.up * height, direction, radius) else {
                    continue;
                };
                if normal.dot(self.up) >= WALKABLE {
                    continue;
                }
                let level = (normal - self.up * normal.dot(self.up)).normalize_or(-direction);
                // The distance from a plane, of which the ray meets a point.
                let push = level * (radius - distance * -direction.dot(level));
                if push.length() > deepest.length() {
                    deepest = push;
                }
            }
        }
        deepest
    }

    /// Whether a surface is between the axes of the body at two places.
    fn is_parted(&self, from: Vec3, to: Vec3) -> bool {
        let way = to - from;
        let length = way.length();
        length > 0.0
            && self
                .heights()
                .any(|height| (self.probe)(from + self.up * height, way / length, length).is_some())
    }

    /// The height above the feet of the highest floor below the reach of a step; None without any.
    fn floor(&self, feet: Vec3) -> Option<f32> {
        let Self { body, up, probe } = *self;
        let ring = self.ring(FEET).map(|direction| direction * (FOOT * body.radius));
        let below = |aside: Vec3| {
            let touch = probe(feet + aside + up * body.step, -up, f32::INFINITY)?;
            (touch.normal.dot(up) >= WALKABLE).then_some(body.step - touch.distance)
        };
        ring.chain([Vec3::ZERO]).filter_map(below).max_by(f32::total_cmp)
    }
}

/// The height of a floor straight below a point, along `up` from the point; None without one.
pub fn floor_below(packed: &PackedScene, point: Vec3, up: Vec3) -> Option<f32> {
    touch(packed, point, -up, f32::INFINITY).map(|touch| -touch.distance)
}

/// The first surface along a ray; borders of media are passed.
fn touch(packed: &PackedScene, origin: Vec3, direction: Vec3, reach: f32) -> Option<Touch> {
    let ray = Ray {
        t_max: reach,
        ..Ray::new(origin, direction)
    };
    let seen = picking::surface(packed, &ray, |_| false)?;
    Some(Touch {
        distance: seen.position.distance(origin),
        normal: seen.normal,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Aabb;

    const BODY: fn() -> Body = || Body::person(LengthUnit::Metre);
    const FRAME: f32 = 1.0 / 60.0;

    fn block(min: [f32; 3], max: [f32; 3]) -> Aabb {
        Aabb {
            min: min.into(),
            max: max.into(),
        }
    }

    fn ground() -> Aabb {
        block([-50.0, -1.0, -50.0], [50.0, 0.0, 50.0])
    }

    /// The nearest side of boxes that a ray from outside meets.
    fn meet(boxes: &[Aabb], origin: Vec3, direction: Vec3, reach: f32) -> Option<Touch> {
        let sides = boxes.iter().filter_map(|Aabb { min, max }| {
            let ways = [(*min - origin) / direction, (*max - origin) / direction];
            let (near, far) = (ways[0].min(ways[1]), ways[0].max(ways[1]));
            let (distance, end) = (near.max_element(), far.min_element());
            let axis = near.max_position();
            let normal = Vec3::AXES[axis] * -direction[axis].signum();
            (distance >= 0.0 && distance <= end.min(reach)).then_some(Touch { distance, normal })
        });
        sides.min_by(|one, other| one.distance.total_cmp(&other.distance))
    }

    /// Walks for a time at a velocity, and returns the places of the feet after each frame.
    fn walk(boxes: &[Aabb], from: Vec3, velocity: Vec3, seconds: f32, frame: f32) -> Vec<Vec3> {
        let body = BODY();
        let around = Around {
            body: &body,
            up: Vec3::Y,
            probe: &|origin, direction, reach| meet(boxes, origin, direction, reach),
        };
        let mut gait = Gait::default();
        let mut feet = from;
        let mut places = Vec::new();
        for _ in 0..(seconds / frame) as u32 {
            feet = gait.step(&around, feet, velocity * frame, false, frame);
            places.push(feet);
        }
        places
    }

    fn last(places: &[Vec3]) -> Vec3 {
        *places.last().expect("a frame")
    }

    #[test]
    fn a_wall_holds_the_body_and_lets_it_slide() {
        let wall = block([2.0, 0.0, -50.0], [2.2, 3.0, 50.0]);
        for frame in [1.0 / 240.0, FRAME, 0.1] {
            let end = last(&walk(
                &[ground(), wall],
                Vec3::ZERO,
                Vec3::new(1.5, 0.0, 1.5),
                3.0,
                frame,
            ));
            assert!((end.x - 1.75).abs() < 0.01, "{end}");
            assert!(end.z > 3.9 && end.y.abs() < 1e-3, "{end}");
        }
    }

    #[test]
    fn nobody_runs_through_a_thin_wall() {
        let wall = block([2.0, 0.0, -50.0], [2.0, 3.0, 50.0]);
        let end = last(&walk(&[ground(), wall], Vec3::ZERO, Vec3::X * 60.0, 2.0, 0.1));
        assert!(end.x < 1.76, "{end}");
    }

    #[test]
    fn stairs_are_climbed_and_a_table_is_not() {
        let stair = |index: u32| {
            let (near, top) = (1.0 + 0.28 * index as f32, 0.18 * (index + 1) as f32);
            block([near, 0.0, -1.0], [near + 0.28, top, 1.0])
        };
        let mut boxes: Vec<Aabb> = (0..10).map(stair).collect();
        boxes.push(block([3.8, 0.0, -1.0], [9.0, 1.8, 1.0]));
        boxes.push(ground());
        let up = walk(&boxes, Vec3::ZERO, Vec3::X * 1.5, 4.0, FRAME);
        assert!((last(&up).y - 1.8).abs() < 1e-3, "{}", last(&up));
        let highest = up.windows(2).map(|pair| pair[1].y - pair[0].y).fold(0.0, f32::max);
        assert!(highest < 0.1, "a leap of {highest}");
        let down = walk(&boxes, last(&up), -Vec3::X * 1.5, 6.0, FRAME);
        assert!(last(&down).y.abs() < 1e-3 && last(&down).x < 0.0, "{}", last(&down));
        let table = block([1.0, 0.0, -5.0], [2.0, 0.75, 5.0]);
        let end = last(&walk(&[ground(), table], Vec3::ZERO, Vec3::X, 4.0, FRAME));
        assert!(end.x < 0.76 && end.y.abs() < 1e-3, "{end}");
    }

    #[test]
    fn a_door_is_passed_and_a_slit_is_not() {
        for (half_width, passes) in [(0.4, true), (0.2, false)] {
            let walls = [-1.0, 1.0].map(|side: f32| {
                let [a, b] = [side * half_width, side * 9.0];
                block([1.0, 0.0, a.min(b)], [1.2, 3.0, a.max(b)])
            });
            let lintel = block([1.0, 2.0, -9.0], [1.2, 3.0, 9.0]);
            let boxes = [ground(), walls[0], walls[1], lintel];
            let end = last(&walk(&boxes, Vec3::new(0.0, 0.0, 0.05), Vec3::X * 1.5, 3.0, FRAME));
            assert_eq!(end.x > 2.0, passes, "{half_width}: {end}");
        }
    }

    #[test]
    fn it_falls_from_an_edge_and_lands() {
        let slab = block([-5.0, 0.0, -5.0], [1.0, 5.0, 5.0]);
        for frame in [1.0 / 240.0, FRAME, 0.1] {
            let places = walk(&[ground(), slab], Vec3::new(0.0, 5.0, 0.0), Vec3::X * 1.5, 3.0, frame);
            assert!(last(&places).y.abs() < 1e-3, "{}", last(&places));
            assert!(places.iter().all(|feet| feet.y > -1e-3));
            // It falls 5 m in 1.01 s.
            let left = places.iter().position(|feet| feet.y < 4.999).expect("an edge") as f32 * frame;
            let landed = places.iter().position(|feet| feet.y < 1e-3).expect("a landing") as f32 * frame;
            assert!((landed - left - 1.01).abs() < 0.05 + frame, "{}", landed - left);
        }
    }

    #[test]
    fn without_a_floor_nothing_falls() {
        let end = last(&walk(&[], Vec3::ZERO, Vec3::X * 1.5, 2.0, FRAME));
        assert!(end.y == 0.0 && (end.x - 3.0).abs() < 0.05, "{end}");
    }

    #[test]
    fn a_jump_is_as_high_as_it_should_be_and_ends_below_a_ceiling() {
        let body = BODY();
        let highest = |boxes: &[Aabb], frame: f32| {
            let around = Around {
                body: &body,
                up: Vec3::Y,
                probe: &|origin, direction, reach| meet(boxes, origin, direction, reach),
            };
            let (mut gait, mut feet, mut top) = (Gait::default(), Vec3::ZERO, 0.0f32);
            for number in 0..(2.0 / frame) as u32 {
                feet = gait.step(&around, feet, Vec3::ZERO, number == 3, frame);
                top = top.max(feet.y);
            }
            assert!(feet.y.abs() < 1e-3 && gait.stands, "{feet}");
            top
        };
        for frame in [1.0 / 240.0, FRAME, 0.05] {
            let free = highest(&[ground()], frame);
            assert!((free - 0.4).abs() < 0.03, "{free}");
        }
        let ceiling = block([-5.0, 2.0, -5.0], [5.0, 2.2, 5.0]);
        let below = highest(&[ground(), ceiling], FRAME);
        assert!((below - 0.25).abs() < 0.02, "{below}");
    }
}
