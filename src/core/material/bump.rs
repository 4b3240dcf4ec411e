//! Shading with normals that differ from the surface's own: bump and normal maps.

use glam::{Vec2, Vec3};

use crate::accel::SurfacePoint;
use crate::math::{Frame, Real, Vector, real_struct};

/// The treatment of mapped normals that differ from the surface's own.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BumpOptions {
    /// Whether normals that face away from the viewer are rotated by half a turn about the surface's own.
    pub flip_invalid_normals: bool,
    /// Whether the border between light and shadow is softened: Estevez, Lecocq and Stein, A Microfacet-Based Shadowing
    /// Function to Solve the Bump Terminator Problem, Ray Tracing Gems 2019.
    pub use_shadowing_function: bool,
}

/// The least sine in [`Bump::chance`]: chances with a larger ratio would overflow.
const LEAST_SINE: f32 = 1e-3;

/// A shading frame and the side of it that is shaded. The z axis points to that side; the frame itself stays upright.
#[derive(Clone, Copy, Debug)]
pub(super) struct Orientation {
    pub frame: Frame,
    /// The side: 1, or -1 from behind.
    pub side: f32,
    /// Whether the other side has another material.
    pub is_of_one_side: bool,
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

/// The normal, in `frame`, of the surface at `point` displaced along `frame.n` by a height whose derivatives by u and v
/// are `gradient`. It is on the side of the geometric normal and not of unit length.
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

real_struct! {
    /// The shadowing of bumped normals by the surface below them.
    pub(crate) struct BumpShadow<R> {
        /// The unit normals of the surface and of the bumped surface.
        surface: R::Vec3,
        bumped: R::Vec3,
        /// The squared roughness of the shadowing function; 0 without it.
        alpha_squared: R,
    }
}

impl<R: Real> BumpShadow<R> {
    /// The factor on light towards `wi`: zero where surface and bumped surface disagree about the side of `wi`.
    #[inline(always)]
    pub fn factor(&self, wi: R::Vec3) -> R {
        let cos = wi.dot(self.surface);
        let is_lit = (cos * wi.dot(self.bumped)).is_more(R::ZERO);
        let tan_squared = (R::ONE - cos.squared()).max(R::ZERO) / cos.squared().max(R::splat(f32::MIN_POSITIVE));
        let root = self.alpha_squared.mul_add(tan_squared, R::ONE).sqrt();
        (R::splat(2.0) / (R::ONE + root)).only(is_lit)
    }
}

/// A bump or normal map on a surface, in world space.
#[derive(Clone, Debug)]
pub(super) struct Bump {
    shadow: BumpShadow,
    /// Whether only viewers in front of the surface see it.
    is_of_one_side: bool,
    turning: Option<Turning>,
    /// The map below this one. Maps on maps are rare.
    outer: Option<Box<Bump>>,
}

/// The two normals of a map whose normal depends on the viewer, see [`BumpOptions::flip_invalid_normals`].
#[derive(Clone, Copy, Debug)]
struct Turning {
    /// Whether this map's own normal is the turned one.
    is_turned: bool,
    /// The normal for viewers who do not see this map's own.
    other: Vec3,
}

impl Bump {
    /// The frame about `normal` (in `below`, not of unit length), with the corrections that shading in it needs.
    /// `below` is already bumped by `outer`. None if the normal has no direction.
    pub fn new(
        normal: Vec3,
        is_turned: bool,
        below: Orientation,
        outer: Option<&Self>,
        options: BumpOptions,
    ) -> Option<(Orientation, Self)> {
        let (mut n, mut other) = (normal.try_normalize()?, turned(normal.try_normalize()?));
        if is_turned {
            (n, other) = (other, n);
        }
        let s = (Vec3::X - n * n.x).try_normalize()?;
        let [s, t, n_world] = [s, n.cross(s), n].map(|axis| below.to_world(axis));
        let tan_squared = (1.0 - n.z * n.z).max(0.0) / (n.z * n.z).max(f32::MIN_POSITIVE);
        let orientation = Orientation {
            frame: Frame { s, t, n: n_world },
            side: 1.0,
            is_of_one_side: false,
        };
        let is_flat = n.x == 0.0 && n.y == 0.0;
        let bump = Self {
            shadow: BumpShadow {
                surface: below.side * below.frame.n,
                bumped: n_world,
                alpha_squared: match options.use_shadowing_function {
                    true => (0.125 * tan_squared).min(1.0),
                    false => 0.0,
                },
            },
            is_of_one_side: below.is_of_one_side,
            turning: (options.flip_invalid_normals && !is_flat).then(|| Turning {
                is_turned,
                other: below.to_world(other),
            }),
            outer: outer.cloned().map(Box::new),
        };
        Some((orientation, bump))
    }

    /// This map and all maps below it.
    fn chain(&self) -> impl Iterator<Item = &Self> {
        std::iter::successors(Some(self), |bump| bump.outer.as_deref())
    }

    /// Whether other viewers see this map with another normal.
    pub fn may_turn(&self) -> bool {
        self.turning.is_some()
    }

    /// Whether other viewers see this map, or one below it, with another normal.
    pub fn may_turn_at_all(&self) -> bool {
        self.chain().any(Self::may_turn)
    }

    /// Whether the normal of this map, or of one below it, is the turned one.
    pub fn is_turned(&self) -> bool {
        self.chain()
            .any(|bump| bump.turning.is_some_and(|turning| turning.is_turned))
    }

    /// Whether a viewer in this direction sees the turned normal.
    pub fn turns_for(&self, viewer: Vec3) -> bool {
        self.turning.is_some_and(|Turning { is_turned, other }| {
            let normal = if is_turned { other } else { self.shadow.bumped };
            viewer.dot(self.shadow.surface) * viewer.dot(normal) <= 0.0
        })
    }

    /// Whether a viewer in this direction sees all maps with exactly these normals. `transmits` means that viewers on
    /// the other side see light as well.
    pub fn is_seen_from(&self, viewer: Vec3, transmits: bool) -> bool {
        self.chain().all(|bump| {
            let is_turned = bump.turning.is_some_and(|turning| turning.is_turned);
            let is_before = transmits || !bump.is_of_one_side || viewer.dot(bump.shadow.surface) > 0.0;
            is_before && bump.turns_for(viewer) == is_turned
        })
    }

    /// The probability with which a path that comes from a lamp in this direction is scattered by these normals. The
    /// viewers that it will reach, and with them the normal, are not yet known.
    ///
    /// A normal that cannot be lit from there has probability zero. If both can, the ratio is the least noisy one for a
    /// diffuse surface: viewers see the turned normal for a share sin^2 of the light, with the angle between normal and
    /// surface, and noise is least when samples follow the root of the share.
    pub fn chance(&self, lamp: Vec3) -> f32 {
        self.chain().map(|bump| bump.own_chance(lamp)).product()
    }

    fn own_chance(&self, lamp: Vec3) -> f32 {
        let Some(Turning { is_turned, other }) = self.turning else {
            return 1.0;
        };
        let cos = lamp.dot(self.shadow.surface);
        let is_lit = |normal: Vec3| cos * lamp.dot(normal) > 0.0;
        match (is_lit(self.shadow.bumped), is_lit(other)) {
            (true, true) => {
                let of_turned = self.shadow.bumped.cross(self.shadow.surface).length().max(LEAST_SINE);
                let own = if is_turned { of_turned } else { 1.0 };
                own / (1.0 + of_turned)
            }
            (true, false) => 1.0,
            (false, true) => 0.0,
            (false, false) => f32::from(!is_turned),
        }
    }

    /// The product of [`BumpShadow::factor`] over all maps.
    pub fn factor(&self, wi: Vec3) -> f32 {
        self.chain().map(|bump| bump.shadow.factor(wi)).product()
    }

    /// The shadow of this map; None if there is another map below it.
    pub fn sole_shadow(&self) -> Option<BumpShadow> {
        self.outer.is_none().then_some(self.shadow)
    }
}

/// The normal rotated by half a turn about z, the normal of the frame that it is bumped from.
fn turned(normal: Vec3) -> Vec3 {
    Vec3::new(-normal.x, -normal.y, normal.z)
}
