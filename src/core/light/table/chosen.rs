//! The lights that sixteen surfaces choose. Lights that many lanes are likely to choose are sampled for these lanes at
//! once. The choices of other lanes must not decide on the form of the formula, because its rounding would then depend
//! on which paths share a batch.

use glam::Vec2;

use super::{LightTable, refined};
use crate::light::choice::Chosen;
use crate::light::finite::FiniteLight;
use crate::light::plain::{PlainLanes, PlainSurface};
use crate::light::{LightId, LightReference, LightSample, ReferenceLanes};
use crate::math::lanes::{LANES, Lanes, each_lane, lanes_of};
use crate::math::{PerLane, Real};

/// With more parts of lights than this, few lanes choose the same one, and sampling lane by lane is as fast, unless
/// other lanes have chosen surfaces of the same kind.
const FEW_PARTS: usize = 4;

/// The lights that lanes have chosen.
pub(crate) struct ChosenLanes {
    /// The lanes that are not sampled yet, a bit each.
    left: u32,
    chosen: [Chosen; LANES],
    /// The probabilities of the choices.
    pmf: Lanes,
    /// Whether the scene has few parts of lights.
    are_few: bool,
    /// The chosen lights that are plain surfaces, if there are many parts.
    plain: PlainLanes,
}

impl ChosenLanes {
    /// Returns lanes that can be sampled at once, and marks them as sampled. None if no lane is left.
    pub fn take_alike(&mut self) -> Option<Alike> {
        match self.plain.take() {
            0 => {}
            plain => return Some(Alike::Plain(plain)),
        }
        let first = each_lane(self.left).next()?;
        if !self.are_few && matches!(self.chosen[first], Chosen::Part(_)) {
            self.left &= !(1 << first);
            return Some(Alike::Lane(first));
        }
        let alike = each_lane(self.left)
            .filter(|&lane| self.chosen[lane] == self.chosen[first])
            .fold(0, |lanes, lane| lanes | 1 << lane);
        self.left &= !alike;
        Some(Alike::Lanes(alike))
    }
}

/// Lanes to be sampled at once, from [`ChosenLanes::take_alike`].
pub(crate) enum Alike {
    /// One lane alone.
    Lane(usize),
    /// Lanes that have chosen the same light, a bit each.
    Lanes(u32),
    /// Lanes that have chosen plain surfaces, a bit each.
    Plain(u32),
}

impl LightTable {
    /// Chooses a light for each of the lanes `asked`, as [`Self::sample`] does.
    pub(crate) fn choose_lanes(&self, asked: u32, from: &ReferenceLanes, u: [Lanes; 3]) -> ChosenLanes {
        let mut choices = ChosenLanes {
            left: 0,
            chosen: [Chosen::Part(0); LANES],
            pmf: Lanes::ZERO,
            are_few: self.light_of_part.len() <= FEW_PARTS,
            plain: PlainLanes::default(),
        };
        let shares = self.choice.shares(&from.of_lanes(asked));
        for lane in each_lane(asked) {
            let [u_choice, x, y] = u.map(|numbers| numbers.as_array()[lane]);
            let u = Vec2::new(x, y);
            let choice = match &shares {
                Some(shares) => self.choice.sample_lane(lane, shares, || refined(u_choice, u)),
                None => self.choose(&LightReference::gather_lane(from, lane), u_choice, u),
            };
            if let Some((chosen, pmf)) = choice {
                choices.chosen[lane] = chosen;
                choices.pmf.as_mut_array()[lane] = pmf;
                match self.plain(chosen).filter(|_| !choices.are_few) {
                    Some(surface) => choices.plain.set(lane, surface),
                    None => choices.left |= 1 << lane,
                }
            }
        }
        choices
    }

    fn plain(&self, chosen: Chosen) -> Option<PlainSurface> {
        let Chosen::Part(part) = chosen else {
            return None;
        };
        match &self.finite_of(part).light {
            FiniteLight::Surface(light) => light.plain(),
            _ => None,
        }
    }

    /// Directions to the plain surfaces that `lanes` have chosen, with each lane's light. None if no lane has chosen
    /// one.
    #[inline(never)]
    pub(crate) fn sample_plain(
        &self,
        lanes: u32,
        choices: &ChosenLanes,
        from: &ReferenceLanes,
        u: [Lanes; 2],
    ) -> Option<([LightId; LANES], LightSample<Lanes>)> {
        let sample = choices.plain.sample(from.position, u)?;
        let mut ids = [LightId(0); LANES];
        for lane in each_lane(lanes) {
            if let Chosen::Part(part) = choices.chosen[lane] {
                ids[lane] = self.finite_of(part).id;
            }
        }
        let pdf = (choices.pmf * sample.pdf).only(lanes_of(lanes));
        Some((ids, LightSample { pdf, ..sample }))
    }

    /// A direction to the light that a lane has chosen.
    pub(crate) fn sample_lane(
        &self,
        lane: usize,
        choices: &ChosenLanes,
        from: &ReferenceLanes,
        u: [Lanes; 2],
    ) -> Option<(LightId, LightSample)> {
        let choice = (choices.chosen[lane], choices.pmf.as_array()[lane]);
        let reference = LightReference::gather_lane(from, lane);
        let u = u.map(|numbers| numbers.as_array()[lane]);
        let (id, sample) = self.sample_chosen::<f32>(choice, &(&reference).into(), u);
        Some((id, sample.if_lit()?))
    }

    /// Directions to the single light that all of `lanes` have chosen.
    #[inline(never)]
    pub(crate) fn sample_lanes(
        &self,
        lanes: u32,
        choices: &ChosenLanes,
        from: &ReferenceLanes,
        u: [Lanes; 2],
    ) -> ([LightId; LANES], LightSample<Lanes>) {
        let chosen = choices.chosen[lanes.trailing_zeros() as usize];
        let (id, sample) = self.sample_chosen((chosen, choices.pmf), &from.of_lanes(lanes), u);
        debug_assert!(
            each_lane(sample.pdf.simd_gt(Lanes::ZERO).to_bitmask())
                .all(|lane| sample.wi.get(lane).is_normalized() && sample.radiance.get(lane).is_finite()),
            "{id:?} is sampled as {sample:?}"
        );
        ([id; LANES], sample)
    }
}

#[cfg(test)]
mod tests {
    use glam::{Affine3A, Quat, Vec3};

    use super::*;
    use crate::color::Rgb;
    use crate::light::constant::ConstantLight;
    use crate::light::cylinder::CylinderLight;
    use crate::light::directional::DirectionalLight;
    use crate::light::point::PointLight;
    use crate::light::rectangle::RectangleLight;
    use crate::light::reference::Reference;
    use crate::light::sphere::{EllipsoidLight, SphereLight};

    use crate::light::spot::{Spot, SpotLight};
    use crate::math::Same;
    use crate::math::lanes::Vec3Lanes;
    use crate::sampling::hash::pcg3d;
    use crate::sampling::unit_float;
    use crate::texture::{Parameter, TextureTable};

    fn number(seed: usize) -> f32 {
        unit_float(pcg3d([seed as u32, 3, 8])[0])
    }

    /// A direction that is not in the plane of the first two axes.
    fn direction(seed: usize) -> Vec3 {
        let [x, y, z] = [3, 5, 7].map(|factor| 2.0 * number(factor * seed + factor) - 1.0);
        Vec3::new(x, y, z + 0.02f32.copysign(z)).normalize()
    }

    /// Compares both forms of a light of size one near the origin: from very near to very far, with and without a
    /// normal.
    fn check(
        name: &str,
        of_one: impl Fn(&Reference, [f32; 2]) -> LightSample,
        of_lanes: impl Fn(&Reference<Lanes>, [Lanes; 2]) -> LightSample<Lanes>,
    ) {
        let (mut lit, mut on_borders) = (0, 0);
        for start in (0..20_000).step_by(LANES) {
            let nowhere = LightReference {
                position: Vec3::ZERO,
                normal: None,
            };
            let mut from = nowhere.splat();
            let mut u = [Lanes::ZERO; 2];
            for lane in 0..LANES {
                let seed = start + lane;
                let reference = LightReference {
                    position: direction(seed) * 0.05 * 1e5f32.powf(number(11 * seed)),
                    normal: (seed % 3 != 0).then(|| direction(seed + 1)),
                };
                reference.scatter_lane(&mut from, lane);
                (0..2).for_each(|axis| u[axis].as_mut_array()[lane] = number([13, 17][axis] * seed));
            }
            let lanes = of_lanes(&from.of_lanes(0xffff), u);
            for lane in 0..LANES {
                let reference = LightReference::gather_lane(&from, lane);
                let one = of_one(&(&reference).into(), u.map(|numbers| numbers.as_array()[lane]));
                let pdf = lanes.pdf.as_array()[lane];
                if (pdf > 0.0) != (one.pdf > 0.0) {
                    on_borders += 1;
                    continue;
                }
                if pdf <= 0.0 {
                    continue;
                }
                lit += 1;
                let (wi, radiance) = (lanes.wi.get(lane), lanes.radiance.get(lane));
                assert!(
                    wi.is_normalized() && wi.abs_diff_eq(one.wi, 1e-3),
                    "{name}: {wi} {one:?} {reference:?}"
                );
                let most = 1e-3 * one.radiance.max_element() + 1e-6;
                assert!(
                    radiance.abs_diff_eq(one.radiance, most),
                    "{name}: {radiance} {one:?} {reference:?}"
                );
                // Edge-on, and on the horizon, rounding dominates the density: a cosine is the root of the difference
                // between one and a number near it.
                on_borders += usize::from((pdf - one.pdf).abs() > 3e-3 * one.pdf + 3e-4);
            }
        }
        assert!(
            lit > 1000 && on_borders < 20,
            "{name}: {lit} are lit, and {on_borders} on borders"
        );
    }

    /// Checks a light whose function `sample` takes a reference and two numbers.
    macro_rules! check {
        ($name:literal, |$from:ident, $u:ident| $sample:expr) => {
            check($name, |$from, $u| $sample, |$from, $u| $sample)
        };
    }

    #[test]
    fn directions_in_lanes_are_those_of_one() {
        let gray = Rgb::new(0.5, 1.0, 2.0);
        let textures = TextureTable::default();
        let turn = Quat::from_rotation_y(0.7);
        let stretched = Affine3A::from_scale_rotation_translation(Vec3::new(0.3, 1.0, 0.6), turn, Vec3::ZERO);
        let round = Affine3A::from_scale_rotation_translation(Vec3::splat(0.7), turn, Vec3::splat(0.1));

        let constant = ConstantLight { radiance: gray };
        check!("constant", |from, u| constant.sample(from, u));
        let directional = DirectionalLight {
            direction: Vec3::Y,
            irradiance: gray,
        };
        check!("directional", |_from, _u| directional.sample());
        let point = PointLight {
            position: Vec3::splat(0.1),
            intensity: gray,
        };
        check!("point", |from, _u| point.sample(from.position));
        let spot = SpotLight::new(
            Spot {
                world_from_local: round,
                intensity: gray,
                cutoff_angle: 1.0,
                beam_angle: 0.5,
                texture: Parameter::Constant(gray),
            },
            &textures,
        );
        check!("spot", |from, _u| spot.sample(from, &textures));

        let seen =
            |sample: crate::light::hit::SurfaceSample, from: &Reference| sample.towards(from.position, 1e-6, gray);
        let all_seen = |sample: crate::light::hit::SurfaceSample<Lanes>, from: &Reference<Lanes>| {
            sample.towards(from.position, Lanes::splat(1e-6), Vec3Lanes::splat(gray))
        };
        for (edge, name) in [
            (Vec3::Y * 0.4, "rectangle"),
            (Vec3::new(0.3, 0.4, 0.0), "parallelogram"),
        ] {
            let light = RectangleLight::new(Vec3::new(-0.5, -0.2, 0.0), Vec3::X, edge, Vec3::Z);
            check(
                name,
                |from, u| seen(light.sample(from.position, u), from),
                |from, u| all_seen(light.sample(from.position, u), from),
            );
        }
        for side in [1.0, -1.0] {
            let light = SphereLight::new(&round, side).expect("a sphere");
            check(
                "sphere",
                |from, u| seen(light.sample(from.position, u), from),
                |from, u| all_seen(Same::<Lanes>::same(light).sample(from.position, u), from),
            );
            let light = EllipsoidLight::new(stretched, stretched.inverse(), side);
            check(
                "ellipsoid",
                |from, u| seen(light.sample_area(u).seen_from(from.position), from),
                |from, u| all_seen(light.sample_area(u).seen_from(from.position), from),
            );
            let light = CylinderLight::new(stretched, stretched.inverse(), side);
            check(
                "cylinder",
                |from, u| seen(light.sample_area(u).seen_from(from.position), from),
                |from, u| all_seen(light.sample_area(u).seen_from(from.position), from),
            );
        }
    }
}
