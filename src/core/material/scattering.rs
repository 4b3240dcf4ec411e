//! The scattering of light at one point of a surface: a weighted list of models, and a share of light that passes
//! straight through.
//!
//! Directions are unit vectors in world space; `wo` and the mode of transport are part of the value. Contracts are
//! those of [`crate::shading`].

use std::borrow::Cow;

use arrayvec::ArrayVec;
use glam::{Vec2, Vec3};

use super::bump::{Bump, BumpShadow, Orientation};
use crate::color::Rgb;
use crate::math::{Frame, Vector};
use crate::shading::{Bsdf, BsdfSample, DiffuseLobe, Onward, ShadingTables, TransportMode};

/// The most models that a material may mix at one point.
pub(super) const LARGEST_MIX: usize = 8;

/// A model with its weight and its orientation in the world.
#[derive(Clone, Debug)]
pub(super) struct Part<'a> {
    /// The model's weight for viewers who see this orientation.
    pub share: f32,
    /// The probability of choosing it: the share, or less if other viewers see another orientation.
    pub weight: f32,
    /// The scattering's `wo` in the orientation.
    pub wo: Vec3,
    pub orientation: Orientation,
    pub bump: Option<Bump>,
    /// The model. Models are large, so constant ones are borrowed from the table.
    pub bsdf: Cow<'a, Bsdf>,
}

/// The scattering at one point of a surface, seen from one direction.
#[derive(Clone, Debug)]
pub struct Scattering<'a> {
    wo: Vec3,
    mode: TransportMode,
    tables: &'a ShadingTables,
    parts: ArrayVec<Part<'a>, LARGEST_MIX>,
    /// The same models about the normals that other viewers see, whom a path from a lamp may reach.
    turned: Vec<Part<'a>>,
    /// The share of the light that passes straight through.
    null_share: f32,
}

/// The greatest cosine with `wo` of a delta lobe that passes straight through. Reflection has smaller cosines except at
/// grazing angles that no path reaches.
const STRAIGHT: f32 = -1.0 + 1e-6;

/// The kind of a sampled direction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Lobe {
    /// A direction sampled by a density.
    Smooth,
    /// The only direction of a delta lobe.
    Delta,
    /// Straight through, as if there were no surface.
    Null,
}

/// A sampled continuation of a path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ScatterSample {
    /// Unit vector to the light.
    pub wi: Vec3,
    /// The weight f |cos wi| / pdf.
    pub weight: Rgb,
    /// Solid angle density of `wi`; for delta and null lobes the probability of choosing them.
    pub pdf: f32,
    /// The kind of the sample, which decides on the meaning of `pdf` and on whether light sampling could have found
    /// `wi`.
    pub lobe: Lobe,
    /// The relative index as of [`BsdfSample::eta`].
    pub eta: f32,
}

/// A [`Scattering`] that is a single model.
#[derive(Clone, Debug)]
pub struct Single<'a> {
    wo: Vec3,
    mode: TransportMode,
    tables: &'a ShadingTables,
    part: Part<'a>,
}

impl<'a> Single<'a> {
    /// The scattering of a single part with full weight; None for a model through which light passes straight.
    pub(super) fn of(part: Part<'a>, wo: Vec3, mode: TransportMode, tables: &'a ShadingTables) -> Option<Self> {
        (!part.bsdf.has_null_lobe()).then_some(Self { wo, mode, tables, part })
    }

    /// Whether part of its light is scattered with a density, as [`Scattering::has_smooth_lobe`].
    pub fn has_smooth_lobe(&self) -> bool {
        self.part.bsdf.has_smooth_lobe()
    }

    /// The normal as [`Scattering::one_sided_normal`] gives it.
    pub fn one_sided_normal(&self) -> Option<Vec3> {
        (!self.part.bsdf.transmits()).then(|| self.part.orientation.to_world(Vec3::Z))
    }

    /// The colour as [`Scattering::albedo`] gives it.
    pub fn albedo(&self) -> Rgb {
        self.part.bsdf.albedo()
    }

    /// Whether [`Self::diffuse_lobe`] may be non-empty.
    pub fn may_have_diffuse_lobe(&self) -> bool {
        self.part.bsdf.may_have_diffuse_lobe()
    }

    /// Its diffuse lobe as [`Bsdf::diffuse_lobe`], and that lobe's normal in the world.
    pub fn diffuse_lobe(&self) -> (DiffuseLobe, Vec3) {
        self.part.diffuse_lobe(self.tables)
    }

    /// The model; None where a map is on another one, or where a path from a lamp has reached a map, whose viewers it
    /// does not know yet.
    pub(crate) fn model(&self) -> Option<Model<'_>> {
        let shadow = match (&self.part.bump, self.mode) {
            (None, _) => None,
            (Some(bump), TransportMode::Radiance) => Some(bump.sole_shadow()?),
            (Some(_), TransportMode::Importance) => return None,
        };
        let Orientation { frame, side, .. } = self.part.orientation;
        Some(Model {
            bsdf: &self.part.bsdf,
            frame,
            side,
            shadow,
        })
    }

    /// Evaluates as [`Scattering::eval_and_pdf`].
    pub fn eval_and_pdf(&self, wi: Vec3) -> (Rgb, f32) {
        self.part.eval_and_pdf(self.tables, self.wo, wi, self.mode)
    }

    /// Samples as [`Scattering::sample`].
    pub fn sample(&self, u_lobe: f32, u: Vec2) -> Option<ScatterSample> {
        let sample = self.part.sample(self.tables, self.wo, u_lobe, u, self.mode)?;
        Some(only(self.wo, &self.part, sample, 1.0))
    }
}

/// The model of a [`Single`].
pub(crate) struct Model<'a> {
    pub bsdf: &'a Bsdf,
    /// The frame in the world.
    pub frame: Frame,
    /// The side of the frame seen by the viewer: 1, or -1 from behind.
    pub side: f32,
    /// The shadowing by the surface below a map; None without a map.
    pub shadow: Option<BumpShadow>,
}

/// A sample of a part chosen with probability `chosen`, whose direction no other part could have sampled.
fn only(wo: Vec3, part: &Part, sample: BsdfSample, chosen: f32) -> ScatterSample {
    let straight = || part.bsdf.has_null_lobe() && sample.wi.dot(wo) < STRAIGHT;
    ScatterSample {
        wi: sample.wi,
        weight: sample.weight,
        pdf: chosen * sample.pdf,
        lobe: match sample.is_delta {
            false => Lobe::Smooth,
            true if straight() => Lobe::Null,
            true => Lobe::Delta,
        },
        eta: sample.eta,
    }
}

impl Part<'_> {
    fn diffuse_lobe(&self, tables: &ShadingTables) -> (DiffuseLobe, Vec3) {
        let normal = self.orientation.to_world(Vec3::Z);
        (self.bsdf.diffuse_lobe(tables, self.wo), normal)
    }

    /// The factor of the maps on light between `wo` and `wi`, in world space, for the direction that the light comes
    /// from. Also zero where light from a lamp goes on to viewers who see other normals.
    fn factor(&self, wo: Vec3, wi: Vec3, mode: TransportMode) -> f32 {
        match (&self.bump, mode) {
            (None, _) => 1.0,
            (Some(bump), TransportMode::Radiance) => bump.factor(wi),
            (Some(bump), TransportMode::Importance) => match bump.is_seen_from(wi, self.bsdf.transmits()) {
                true => bump.factor(wo),
                false => 0.0,
            },
        }
    }

    /// The value f |cos wi| times the share, and the density times the weight. Directions are in world space.
    fn eval_and_pdf(&self, tables: &ShadingTables, wo: Vec3, wi: Vec3, mode: TransportMode) -> (Rgb, f32) {
        let factor = self.factor(wo, wi, mode);
        if factor == 0.0 {
            return (Rgb::ZERO, 0.0);
        }
        let wi = self.orientation.to_local(wi);
        let (value, pdf) = self.bsdf.eval_and_pdf(tables, self.wo, wi, mode);
        (self.share * factor * value, self.weight * pdf)
    }

    /// Samples in world space, with the factor of the maps but without the share.
    fn sample(
        &self,
        tables: &ShadingTables,
        wo: Vec3,
        u_lobe: f32,
        u: Vec2,
        mode: TransportMode,
    ) -> Option<BsdfSample> {
        let sample = self.bsdf.sample(tables, self.wo, u_lobe, u, mode)?;
        let wi = self.orientation.to_world(sample.wi);
        let factor = self.factor(wo, wi, mode);
        (factor > 0.0).then_some(BsdfSample {
            wi,
            weight: sample.weight * factor,
            ..sample
        })
    }

    /// The light scattered from `wo`, the direction of a lamp in world space, to `wi`: f |cos wo| of a path that comes
    /// from `wi`, times the share.
    fn eval_reverse(&self, tables: &ShadingTables, wo: Vec3, wi: Vec3) -> Rgb {
        let factor = self.factor(wo, wi, TransportMode::Importance);
        if factor == 0.0 {
            return Rgb::ZERO;
        }
        let wi = self.orientation.to_local(wi);
        self.share * factor * self.bsdf.eval(tables, wi, self.wo, TransportMode::Radiance)
    }

    /// Density per solid angle with which a path that comes from `wi` continues to `wo`, in world space, times the
    /// probability that it chooses this part.
    fn reverse_pdf(&self, tables: &ShadingTables, wo: Vec3, wi: Vec3, mode: TransportMode) -> f32 {
        if self.factor(wo, wi, mode) == 0.0 {
            return 0.0;
        }
        let chance = match (mode, &self.bump) {
            (TransportMode::Radiance, Some(bump)) => bump.chance(wi),
            _ => 1.0,
        };
        self.share * chance * self.bsdf.pdf(tables, self.orientation.to_local(wi), self.wo)
    }

    /// The factor that turns the weight of a delta lobe into its adjoint, without the cosines with the geometric
    /// normal.
    fn delta_correction(&self, wi: Vec3) -> f32 {
        (self.wo.z / self.orientation.to_local(wi).z).abs()
    }
}

impl<'a> Scattering<'a> {
    pub(super) fn new(wo: Vec3, mode: TransportMode, tables: &'a ShadingTables) -> Self {
        Self {
            wo,
            mode,
            tables,
            parts: ArrayVec::new(),
            turned: Vec::new(),
            null_share: 0.0,
        }
    }

    pub(super) fn mode(&self) -> TransportMode {
        self.mode
    }

    /// Adds a part; the table's check guarantees the room.
    pub(super) fn push(&mut self, part: Part<'a>) {
        match part.bump.as_ref().is_some_and(Bump::is_turned) && self.mode == TransportMode::Importance {
            true => self.turned.push(part),
            false => self.parts.push(part),
        }
    }

    fn parts(&self) -> impl Iterator<Item = &Part<'a>> + Clone {
        self.parts.iter().chain(&self.turned)
    }

    pub(super) fn add_null_lobe(&mut self, share: f32) {
        self.null_share += share;
    }

    /// The value f |cos wi| and the solid angle density with which [`Self::sample`] returns `wi`, both without delta
    /// and null lobes.
    pub fn eval_and_pdf(&self, wi: Vec3) -> (Rgb, f32) {
        self.parts().fold((Rgb::ZERO, 0.0), |(value, pdf), part| {
            let (part_value, part_pdf) = part.eval_and_pdf(self.tables, self.wo, wi, self.mode);
            (value + part_value, pdf + part_pdf)
        })
    }

    /// Samples the path's next direction from independent uniform numbers. None if the light is absorbed.
    pub fn sample(&self, u_lobe: f32, u: Vec2) -> Option<ScatterSample> {
        self.sample_part(u_lobe, u).map(|(sample, _)| sample)
    }

    /// [`Self::sample`], with the model that was chosen if there is one.
    #[inline(always)]
    fn sample_part(&self, u_lobe: f32, u: Vec2) -> Option<(ScatterSample, Option<&Part<'a>>)> {
        if let ([part], [], 0.0) = (&self.parts[..], &self.turned[..], self.null_share) {
            let sample = part.sample(self.tables, self.wo, u_lobe, u, self.mode)?;
            return Some((only(self.wo, part, sample, 1.0), Some(part)));
        }
        if u_lobe < self.null_share {
            let straight = ScatterSample {
                wi: -self.wo,
                weight: Rgb::ONE,
                pdf: self.null_share,
                lobe: Lobe::Null,
                eta: 1.0,
            };
            return Some((straight, None));
        }
        // All weights add up to 1; rounding may lead beyond the last.
        let mut left = u_lobe - self.null_share;
        let (mut chosen, mut chosen_part) = (0, None);
        for (index, part) in self.parts().enumerate() {
            if let Some(part) = chosen_part.replace(part) {
                left -= part.weight;
            }
            chosen = index;
            if left < part.weight {
                break;
            }
        }
        let part = chosen_part?;
        let u_part = (left / part.weight).clamp(0.0, 1.0 - f32::EPSILON);
        let sample = part.sample(self.tables, self.wo, u_part, u, self.mode)?;
        if sample.is_delta {
            let weight = sample.weight * (part.share / part.weight);
            let sample = BsdfSample { weight, ..sample };
            return Some((only(self.wo, part, sample, part.weight), Some(part)));
        }
        // Other parts could have sampled this direction, too.
        let pdf = part.weight * sample.pdf;
        let start = (part.share * sample.pdf * sample.weight, pdf);
        let others = self.parts().enumerate().filter(|&(index, _)| index != chosen);
        let (value, pdf) = others.fold(start, |(value, pdf), (_, other)| {
            let (other_value, other_pdf) = other.eval_and_pdf(self.tables, self.wo, sample.wi, self.mode);
            (value + other_value, pdf + other_pdf)
        });
        let sample = ScatterSample {
            wi: sample.wi,
            weight: value / pdf,
            pdf,
            lobe: Lobe::Smooth,
            eta: sample.eta,
        };
        Some((sample, Some(part)))
    }

    /// The value of [`Self::eval_and_pdf`] for light that has come from a lamp along `-wo`: f |cos wo| |wi . n| / |wo .
    /// n| with the geometric normal n, where f is that of a path from the camera. Shading normals are taken into
    /// account (Veach 1997, section 5.3).
    pub fn eval_adjoint(&self, wi: Vec3, normal: Vec3) -> Rgb {
        let parts = self.parts();
        let value: Rgb = parts.map(|part| part.eval_reverse(self.tables, self.wo, wi)).sum();
        value * self.cosine_ratio(wi, normal)
    }

    /// The density with which a path that comes from `wi` continues to `wo`, without delta and null lobes.
    pub fn reverse_pdf(&self, wi: Vec3) -> f32 {
        let parts = self.parts();
        parts
            .map(|part| part.reverse_pdf(self.tables, self.wo, wi, self.mode))
            .sum()
    }

    /// Samples a direction for light that has come from a lamp along `-wo`, as [`Self::sample`] does, with the weight
    /// of [`Self::eval_adjoint`]. The scattering must have [`TransportMode::Importance`]. Light to viewers who see
    /// other normals than the chosen ones counts as absorbed.
    pub fn sample_adjoint(&self, u_lobe: f32, u: Vec2, normal: Vec3) -> Option<ScatterSample> {
        debug_assert_eq!(self.mode, TransportMode::Importance);
        let (sample, part) = self.sample_part(u_lobe, u)?;
        let weight = match (sample.lobe, part) {
            (Lobe::Smooth, _) => self.eval_adjoint(sample.wi, normal) / sample.pdf,
            (Lobe::Delta, Some(part)) => {
                sample.weight * (part.delta_correction(sample.wi) * self.cosine_ratio(sample.wi, normal))
            }
            (Lobe::Delta, None) | (Lobe::Null, _) => sample.weight,
        };
        weight.is_finite().then_some(ScatterSample { weight, ..sample })
    }

    fn cosine_ratio(&self, wi: Vec3, normal: Vec3) -> f32 {
        (wi.dot(normal) / self.wo.dot(normal)).abs()
    }

    /// Moves the only model out; None if there are several, or if light passes straight through.
    pub(crate) fn take_single(&mut self) -> Option<Single<'a>> {
        let is_single = self.null_share == 0.0 && self.parts.len() == 1;
        let part = if is_single { self.parts.pop() } else { None };
        Single::of(part?, self.wo, self.mode, self.tables)
    }

    /// The transmittance for a shadow ray against `wo`.
    pub fn transmittance(&self) -> Rgb {
        let of_part =
            |part: &Part| part.weight * part.factor(self.wo, -self.wo, self.mode) * part.bsdf.transmittance(part.wo);
        Rgb::splat(self.null_share) + self.parts().map(of_part).sum::<Rgb>()
    }

    /// The share of the light that passes straight through masks and null materials.
    pub fn null_share(&self) -> f32 {
        self.null_share
    }

    /// The next direction of a view that ignores roughness and refraction, with the throughput: straight on through
    /// glass and openings, or mirrored, whichever is brighter. None on surfaces without either, as diffuse ones.
    pub fn onward(&self) -> Option<(Vec3, Rgb)> {
        let mut straight = Rgb::splat(self.null_share);
        let (mut mirror, mut strongest) = (Rgb::ZERO, None::<&Part>);
        for part in &self.parts {
            match part.bsdf.onward(part.wo) {
                Some(Onward::Straight(share)) => straight += part.weight * share,
                Some(Onward::Mirrored(share)) => {
                    mirror += part.weight * share;
                    strongest = strongest.filter(|other| other.weight >= part.weight).or(Some(part));
                }
                None => {}
            }
        }
        let (dir, share) = match strongest.filter(|_| mirror.max_element() > straight.max_element()) {
            Some(part) => (part.orientation.to_world(part.wo.mirrored()), mirror),
            None => (-self.wo, straight),
        };
        (share.max_element() > 0.0).then_some((dir, share))
    }

    /// Whether part of its light is scattered with a density, so that light sampling helps.
    pub fn has_smooth_lobe(&self) -> bool {
        self.parts().any(|part| part.bsdf.has_smooth_lobe())
    }

    /// The normal of the half space of all light that [`Self::eval_and_pdf`] counts; None if it is unknown, or the
    /// whole space.
    pub fn one_sided_normal(&self) -> Option<Vec3> {
        match &self.parts[..] {
            [part] if !part.bsdf.transmits() => Some(part.orientation.to_world(Vec3::Z)),
            _ => None,
        }
    }

    /// [`Self::one_sided_normal`] if it holds for light in both directions: None also where other viewers see another
    /// normal.
    pub fn one_sided_normal_both_ways(&self) -> Option<Vec3> {
        let may_turn = |part: &Part| part.bump.as_ref().is_some_and(Bump::may_turn_at_all);
        if self.parts().any(may_turn) {
            return None;
        }
        self.one_sided_normal()
    }

    /// [`Single::diffuse_lobe`] of the only model; None if there are several, or if the lobe is empty.
    pub fn diffuse_lobe(&self) -> Option<(DiffuseLobe, Vec3)> {
        match (&self.parts[..], self.null_share) {
            ([part], 0.0) => Some(part.diffuse_lobe(self.tables)).filter(|(lobe, _)| lobe.share > 0.0),
            _ => None,
        }
    }

    /// The colour of the surface for denoisers and debug views. It is in [0, 1] for physical parameters.
    pub fn albedo(&self) -> Rgb {
        let of_parts = self.parts().map(|part| part.weight * part.bsdf.albedo());
        Rgb::splat(self.null_share) + of_parts.sum::<Rgb>()
    }
}
