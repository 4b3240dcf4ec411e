//! The reasons of noise, and the methods of the program that help against each.

use std::collections::BTreeMap;

use super::{Breakdown, Kind, Portion, Route};

declare_names! {
    /// A reason why samples of a pixel differ.
    #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
    pub enum Trouble {
        /// Light that is focused onto a surface by mirrors or glass. Only a path that comes upon the lamp by chance
        /// finds it.
        Caustic = "caustic" => "light that glass or a mirror focuses onto a surface",
        /// Light that was scattered or emitted by media.
        Medium = "medium" => "light in media",
        /// Light of more than [`LONG`] bounces.
        LongPaths = "long-paths" => "light after many bounces",
        /// Light seen in mirrors, in glossy surfaces and through glass.
        Reflection = "reflection" => "light in mirrors, gloss and glass",
        /// Light between surfaces that scatter widely.
        Interreflection = "interreflection" => "light that other surfaces reflect",
        /// Direct light of several lamps, none of which makes more than half of its noise.
        ManyLamps = "many-lamps" => "the choice among several lamps",
        /// Direct light of mainly one lamp.
        Shadow = "shadow" => "the half shadow of a lamp",
        /// Emitters in view.
        Edge = "edge" => "the edge or the texture of an emitter in view",
    }
}

/// Paths with more bounces than this are long.
pub const LONG: u32 = 7;

impl Trouble {
    /// The method that helps, as a sentence for the user.
    pub const fn remedy(self) -> &'static str {
        match self {
            Self::Caustic => {
                "Paths from the lights find it: the integrator `bdpt`, or `vcm` where it is seen in a mirror or through glass."
            }
            Self::Medium => "More samples help, or the denoiser; media have no other method.",
            Self::LongPaths => "A lower `max_depth` leaves it out; guided paths or the denoiser lessen the noise.",
            Self::Reflection => "More samples there help: adaptive sampling; the denoiser keeps edges by its guides.",
            Self::Interreflection => "Guided paths find where it comes from (`guided`); the denoiser removes the rest.",
            Self::ManyLamps => {
                "The light tree chooses among them already: adaptive sampling or the denoiser, or fewer and larger lamps."
            }
            Self::Shadow => "More samples help, or the denoiser; a smaller lamp has a narrower half shadow.",
            Self::Edge => "More samples help.",
        }
    }

    /// The reason of the noise on a route; that of direct light for all lamps is [`Self::Shadow`].
    fn of(route: &Route) -> Self {
        match route.kind {
            _ if route.is_caustic => Self::Caustic,
            Kind::Medium => Self::Medium,
            _ if route.bounces > LONG => Self::LongPaths,
            Kind::Mirror | Kind::Glass => Self::Reflection,
            Kind::Diffuse => Self::Interreflection,
            Kind::Direct => Self::Shadow,
            Kind::Seen => Self::Edge,
        }
    }
}

/// A reason of the noise of an area, with the method that helps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Advice {
    /// The reason.
    pub trouble: Trouble,
    /// Its part of the variance.
    pub noise: f32,
}

/// The least part of the variance of a reason that is told, unless it is the greatest.
const LEAST_TOLD: f32 = 0.2;

impl Breakdown {
    /// The reasons of the noise, the greatest first. Empty where all samples are alike.
    pub fn advice(&self) -> Vec<Advice> {
        let direct = self.portions(|route| (Trouble::of(route) == Trouble::Shadow).then_some(route.source));
        let direct_noise: f32 = direct.iter().map(|lamp| lamp.noise.max(0.0)).sum();
        let is_shared = direct.len() > 2 && direct.iter().all(|lamp| lamp.noise < 0.5 * direct_noise);
        let mut of_troubles: BTreeMap<Trouble, f32> = BTreeMap::new();
        for Portion { key, noise, .. } in self.portions(|route| Some(Trouble::of(route))) {
            let trouble = match key == Trouble::Shadow && is_shared {
                true => Trouble::ManyLamps,
                false => key,
            };
            *of_troubles.entry(trouble).or_default() += noise;
        }
        let mut advice: Vec<Advice> = of_troubles
            .into_iter()
            .filter(|&(_, noise)| noise > 0.0)
            .map(|(trouble, noise)| Advice { trouble, noise })
            .collect();
        advice.sort_by(|one, other| other.noise.total_cmp(&one.noise));
        let told = advice.iter().filter(|advice| advice.noise >= LEAST_TOLD).count();
        advice.truncate(told.max(1));
        advice
    }
}
