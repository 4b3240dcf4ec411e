//! The parts of a scene that are invisible to camera rays, so that one can look into closed rooms.
//!
//! Only the first ray of a path passes them. Light transport is unchanged: a wall that is invisible to the camera still
//! blocks light, reflects it and shows in mirrors.

use std::sync::Arc;

use glam::Vec3;

use super::outer_walls::OuterWalls;
use crate::accel::{Detail, Hit, Primitive, RayLanes, Tlas};
use crate::math::Ray;
use crate::math::lanes::{LANES, each_lane};

/// The parts of a scene that stop camera rays; by default all of them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Sight {
    /// Whether rays pass surfaces that they meet from behind, whose geometric normal points away from the camera.
    pub passes_backs: bool,
    /// The walls that rays also pass from outside, if `passes_backs` is set.
    pub outer_walls: OuterWalls,
    /// A plane; rays pass all surfaces on its outer side.
    pub cut: Option<CutPlane>,
    /// The only shapes that stop rays, which pass all others. None: all shapes stop them.
    pub only: Option<Isolated>,
}

/// A cut: camera rays pass all surfaces on the side of the plane to which its normal points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CutPlane {
    /// Unit length, world space.
    pub normal: Vec3,
    /// The distance of the plane from the origin along its normal.
    pub offset: f32,
}

/// Some shapes of a scene as a separate geometry, with the same transforms.
#[derive(Clone, Debug)]
pub struct Isolated(pub Arc<Tlas>);

impl PartialEq for Isolated {
    /// Whether both share their memory.
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }
}

/// The most surfaces that a ray passes.
const MOST_PASSED: usize = 256;
/// The offset behind a surface at which a ray continues, relative to the distance so far and to the origin's
/// coordinates: well above rounding, and well below visibility. It is also half the length of the ray that hits an
/// isolated shape.
const BEHIND: f32 = 1e-5;

impl Sight {
    /// Whether camera rays see the whole scene.
    #[inline(always)]
    pub fn is_whole(&self) -> bool {
        !self.passes_backs && self.cut.is_none() && self.only.is_none()
    }

    /// The part of a camera ray behind all surfaces that it passes. `scene` is the whole geometry.
    #[inline(always)]
    pub fn narrow(&self, scene: &Tlas, ray: Ray) -> Ray {
        if self.is_whole() {
            ray
        } else {
            self.narrow_one(scene, ray)
        }
    }

    #[inline(never)]
    fn narrow_one(&self, scene: &Tlas, mut ray: Ray) -> Ray {
        if let Some(cut) = &self.cut {
            ray = cut.clip(ray);
        }
        let geometry = self.only.as_ref().map_or(scene, |only| &only.0);
        if !self.passes_backs && self.only.is_none() {
            return ray;
        }
        let mut entered = 0;
        for _ in 0..MOST_PASSED {
            let Some(hit) = geometry.intersect(&ray) else { break };
            if self.passes(geometry, &ray, &hit, &mut entered) {
                ray.t_min = hit.t + slack(&ray, hit.t);
            } else {
                return self.around(ray, &hit);
            }
        }
        self.nothing_met(ray)
    }

    /// [`Self::narrow`] for the rays of the lanes in `active`.
    #[inline(always)]
    pub(in crate::render) fn narrow_lanes(&self, scene: &Tlas, rays: &mut RayLanes, active: u32) {
        if !self.is_whole() {
            self.narrow_each(scene, rays, active);
        }
    }

    #[inline(never)]
    fn narrow_each(&self, scene: &Tlas, rays: &mut RayLanes, active: u32) {
        if let Some(cut) = &self.cut {
            for lane in each_lane(active) {
                rays.set(lane, &cut.clip(rays.get(lane)));
            }
        }
        let geometry = self.only.as_ref().map_or(scene, |only| &only.0);
        if !self.passes_backs && self.only.is_none() {
            return;
        }
        let (mut asked, mut entered) = (active, [0; LANES]);
        for _ in 0..MOST_PASSED {
            if asked == 0 {
                return;
            }
            let hits = geometry.intersect_packet(rays, asked);
            for lane in each_lane(asked) {
                let mut ray = rays.get(lane);
                match &hits[lane] {
                    Some(hit) if self.passes(geometry, &ray, hit, &mut entered[lane]) => {
                        ray.t_min = hit.t + slack(&ray, hit.t);
                    }
                    met => {
                        asked &= !(1 << lane);
                        ray = match met {
                            Some(hit) => self.around(ray, hit),
                            None => self.nothing_met(ray),
                        };
                    }
                }
                rays.set(lane, &ray);
            }
        }
        for lane in each_lane(asked) {
            rays.set(lane, &self.nothing_met(rays.get(lane)));
        }
    }

    /// Whether a ray passes the surface that it has hit. `entered` has a bit for each outer wall that the ray has
    /// entered.
    fn passes(&self, geometry: &Tlas, ray: &Ray, hit: &Hit, entered: &mut u64) -> bool {
        if !self.passes_backs {
            return false;
        }
        // Isolated shapes have other numbers, and are visible from all sides.
        let place = match self.only {
            Some(_) => None,
            None => self.outer_walls.place_of(hit.instance),
        };
        let normal = geometry.surface_in(ray, hit, Detail::Plain).geometric_normal;
        if normal.dot(ray.dir) > 0.0 {
            // A solid that was not entered may share a plane with a wall that was left, such as the top of a wall under
            // a ceiling. Its front is visible: what lies behind depends on rounding.
            let is_left = place.is_some_and(|place| {
                *entered >> place & 1 == 1 || self.outer_walls.is_seen_from_outside(place, ray.dir)
            });
            let is_solid = matches!(geometry.shape_at(hit).primitive, Primitive::Mesh(_));
            return *entered == 0 || is_left || !is_solid;
        }
        match place.filter(|place| self.outer_walls.is_entered(*place, normal, ray.dir)) {
            Some(place) => {
                *entered |= 1 << place;
                true
            }
            None => false,
        }
    }

    /// A short ray around `hit`, which can hit nothing else in the scene.
    fn around(&self, ray: Ray, hit: &Hit) -> Ray {
        if self.only.is_none() {
            return ray;
        }
        let slack = slack(&ray, hit.t);
        Ray {
            t_min: ray.t_min.max(hit.t - slack),
            t_max: ray.t_max.min(hit.t + slack),
            ..ray
        }
    }

    /// The empty ray, for a camera ray that passes all surfaces.
    fn nothing_met(&self, ray: Ray) -> Ray {
        match self.only {
            Some(_) => nowhere(ray),
            None => ray,
        }
    }
}

impl CutPlane {
    /// The part of a ray that is behind the plane.
    pub fn clip(&self, ray: Ray) -> Ray {
        let height = self.normal.dot(ray.origin) - self.offset;
        let slope = self.normal.dot(ray.dir);
        let crossing = -height / slope;
        match (height > 0.0, slope) {
            (true, slope) if slope < 0.0 => Ray {
                t_min: ray.t_min.max(crossing),
                ..ray
            },
            (true, _) => nowhere(ray),
            (false, slope) if slope > 0.0 => Ray {
                t_max: ray.t_max.min(crossing),
                ..ray
            },
            (false, _) => ray,
        }
    }
}

fn nowhere(ray: Ray) -> Ray {
    Ray {
        t_min: 0.0,
        t_max: 0.0,
        ..ray
    }
}

fn slack(ray: &Ray, t: f32) -> f32 {
    BEHIND * (t + ray.origin.abs().max_element() / ray.dir.length().max(f32::MIN_POSITIVE))
}
