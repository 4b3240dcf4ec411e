//! Shading about normals that are not the surface's own.

use glam::{Vec2, Vec3};

use crate::accel::SurfacePoint;
use crate::math::Frame;

/// The treatment of shading normals that are not the surface's.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BumpOptions {
    /// Whether normals that face away from the viewer are turned about the surface's own.
    pub flip_invalid_normals: bool,
    /// Whether the border of light and shadow is softened: Estevez, Lecocq and Stein, A Microfacet-Based Shadowing Function to Solve the Bump
    /// Terminator Problem, Ray Tracing Gems 2019.
    pub use_shadowing_function: bool,
}

/// A shading frame whose z may be turned to the back of the surface; the frame itself stays upright.
#[derive(Clone, Copy, Debug)]
pub(super) struct Orientation {
    pub frame: Frame,
    /// The side: 1, or -1 behind.
    pub side: f32,
}

impl Orientation {
    pub fn to_local(self, v: Vec3) -> Vec3 {
        let local = self.frame.to_local(v);
        Vec3::new(local.x, local.y, local.z * self.side)
    }

    pub fn to_world(self, v: Vec3) -> Vec3 {
        self.frame.to_world(Vec3::new(v.x, v.y, v.z * self.side))
    }
}

/// The normal, in `frame`, of the surface at `point` once it is moved along `frame.n` by a height whose derivatives by u and v are `gradient`. On
/// the side of the geometric normal, not of unit length.
pub(super) fn displaced_normal(point: &SurfacePoint, frame: Frame, gradient: Vec2) -> Vec3 {
    let tilted = |derivative: Vec3, slope: f32| derivative + (slope - frame.n.dot(derivative)) * frame.n;
    let normal = tilted(point.dp_du, gradient.x).cross(tilted(point.dp_dv, gradient.y));
    let side = if normal.dot(point.geometric_normal) < 0.0 {
        -1.0
    } else {
        1.0
    };
    frame.to_local(side * normal)
}

/// The difference between a bumped surface and the one it lies on.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bump {
    surface: Vec3,
    bumped: Vec3,
    /// The squared roughness of the shadowing function; 0 without it.
    alpha_squared: f32,
}

impl Bump {
    /// The frame about `normal` (in `below`, not of unit length), with what has to be corrected in it. None if the normal is no direction.
    pub fn new(mut normal: Vec3, below: Orientation, wo: Vec3, options: BumpOptions) -> Option<(Orientation, Self)> {
        let wo = below.to_local(wo);
        if options.flip_invalid_normals && wo.z * wo.dot(normal) <= 0.0 {
            normal = Vec3::new(-normal.x, -normal.y, normal.z);
        }
        let n = normal.try_normalize()?;
        let s = (Vec3::X - n * n.x).try_normalize()?;
        let [s, t, n_world] = [s, n.cross(s), n].map(|axis| below.to_world(axis));
        let tan_squared = (1.0 - n.z * n.z).max(0.0) / (n.z * n.z).max(f32::MIN_POSITIVE);
        let orientation = Orientation {
            frame: Frame { s, t, n: n_world },
            side: 1.0,
        };
        let bump = Self {
            surface: below.side * below.frame.n,
            bumped: n_world,
            alpha_squared: if options.use_shadowing_function {
                (0.125 * tan_squared).min(1.0)
            } else {
                0.0
            },
        };
        Some((orientation, bump))
    }

    /// The factor of the light towards `wi`: zero where the surface and the bumped one disagree about the side.
    pub fn factor(&self, wi: Vec3) -> f32 {
        let cos = wi.dot(self.surface);
        if cos * wi.dot(self.bumped) <= 0.0 {
            return 0.0;
        }
        let tan_squared = (1.0 - cos * cos).max(0.0) / (cos * cos);
        2.0 / (1.0 + (1.0 + self.alpha_squared * tan_squared).sqrt())
    }
}
