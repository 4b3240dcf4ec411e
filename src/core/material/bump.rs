//! Shading about normals that are not the surface's own.

use glam::{Vec2, Vec3};

use crate::accel::SurfacePoint;
use crate::math::{Frame, Real, Vector, real_struct};

/// The treatment of shading normals that are not the surface's.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BumpOptions {
    /// Whether normals that face away from the viewer are turned about the surface's own.
    pub flip_invalid_normals: bool,
    /// Whether the border of light and shadow is softened: Estevez, Lecocq and Stein, A Microfacet-Based Shadowing
    /// Function to Solve the Bump Terminator Problem, Ray Tracing Gems 2019.
    pub use_shadowing_function: bool,
}

/// The least sine that [`Bump::chance`] counts with: chances that differ by more would overflow.
const LEAST_SINE: f32 = 1e-3;

/// A shading frame whose z may be turned to the back of the surface; the frame itself stays upright.
#[derive(Clone, Copy, Debug)]
pub(super) struct Orientation {
    pub frame: Frame,
    /// The side: 1, or -1 behind.
    pub side: f32,
    /// Whether what is behind is another material.
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

/// The normal, in `frame`, of the surface at `point` once it is moved along `frame.n` by a height whose derivatives by
/// u and v are `gradient`. On the side of the geometric normal, not of unit length.
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
    /// The shadow that a surface casts on the one that is bumped from it.
    pub(crate) struct BumpShadow<R> {
        /// The normals of the surface and of the bumped one.
        surface: R::Vec3,
        bumped: R::Vec3,
        /// The squared roughness of the shadowing function; 0 without it.
        alpha_squared: R,
    }
}

impl<R: Real> BumpShadow<R> {
    /// The factor of the light towards `wi`: zero where a surface and the one bumped from it disagree about the side.
    #[inline(always)]
    pub fn factor(&self, wi: R::Vec3) -> R {
        let cos = wi.dot(self.surface);
        let is_lit = (cos * wi.dot(self.bumped)).is_more(R::ZERO);
        let tan_squared = (R::ONE - cos.squared()).max(R::ZERO) / cos.squared().max(R::splat(f32::MIN_POSITIVE));
        let root = self.alpha_squared.mul_add(tan_squared, R::ONE).sqrt();
        (R::splat(2.0) / (R::ONE + root)).only(is_lit)
    }
}

/// The difference between a bumped surface and the one it lies on.
#[derive(Clone, Debug)]
pub(super) struct Bump {
    shadow: BumpShadow,
    /// Whether only viewers before the surface see it.
    is_of_one_side: bool,
    turning: Option<Turning>,
    /// The map that this one lies in. Maps in maps are rare.
    outer: Option<Box<Bump>>,
}

/// How the normal depends on the viewer: see [`BumpOptions::flip_invalid_normals`].
#[derive(Clone, Copy, Debug)]
struct Turning {
    /// Whether this is the normal after turning.
    is_turned: bool,
    /// The normal of viewers who do not see this one.
    other: Vec3,
}

impl Bump {
    /// The frame about `normal` (in `below`, not of unit length), with what has to be corrected in it. `below` is
    /// bumped by `outer` already. None if the normal is no direction.
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

    /// The map and those that it lies in.
    fn chain(&self) -> impl Iterator<Item = &Self> {
        std::iter::successors(Some(self), |bump| bump.outer.as_deref())
    }

    /// Whether viewers elsewhere see this map with another normal.
    pub fn may_turn(&self) -> bool {
        self.turning.is_some()
    }

    /// Whether viewers elsewhere see this map, or one that it lies in, with another normal.
    pub fn may_turn_at_all(&self) -> bool {
        self.chain().any(Self::may_turn)
    }

    /// Whether this normal, or that of a map that this one lies in, is one after turning.
    pub fn is_turned(&self) -> bool {
        self.chain()
            .any(|bump| bump.turning.is_some_and(|turning| turning.is_turned))
    }

    /// Whether a viewer in this direction sees the normal turned.
    pub fn turns_for(&self, viewer: Vec3) -> bool {
        self.turning.is_some_and(|Turning { is_turned, other }| {
            let normal = if is_turned { other } else { self.shadow.bumped };
            viewer.dot(self.shadow.surface) * viewer.dot(normal) <= 0.0
        })
    }

    /// Whether a viewer in this direction sees all maps, and with these normals. `transmits`: whether viewers on the
    /// other side see light as well.
    pub fn is_seen_from(&self, viewer: Vec3, transmits: bool) -> bool {
        self.chain().all(|bump| {
            let is_turned = bump.turning.is_some_and(|turning| turning.is_turned);
            let is_before = transmits || !bump.is_of_one_side || viewer.dot(bump.shadow.surface) > 0.0;
            is_before && bump.turns_for(viewer) == is_turned
        })
    }

    /// The share of the light from a lamp in this direction that is sent on as from these normals, while one does not
    /// know yet which viewers it will come to.
    ///
    /// A normal that cannot be lit from there has none. Of the others, those after turning have as much as makes a
    /// diffuse surface least noisy: they send the share sin^2 of the light, where the angle is that between normal
    /// and surface, and the noise of a share is least if it has its root of the samples.
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

    /// The only shadow; None where the map lies in another one.
    pub fn sole_shadow(&self) -> Option<BumpShadow> {
        self.outer.is_none().then_some(self.shadow)
    }
}

/// The normal, in the frame that it is bumped from, on the other side of that frame's.
fn turned(normal: Vec3) -> Vec3 {
    Vec3::new(-normal.x, -normal.y, normal.z)
}
