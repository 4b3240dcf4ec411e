//! Models for sixteen surfaces at once: each lane has its own model with its own parameters.
//!
//! Each model that some lane has is evaluated in all lanes, and each lane keeps the result of its own. Contracts are
//! those of [`super`].

use super::{Bsdf, BsdfSample, DiffuseLobe, Model, ModelLanes, ShadingTables, TransportMode, Visit};
use crate::math::Vector;
use crate::math::lanes::{Lanes, Vec3Lanes};

/// A model per lane.
#[derive(Clone, Debug, Default)]
pub(crate) struct BsdfLanes {
    models: ModelLanes,
    smooth: u32,
    guided: u32,
    transmitting: u32,
    choosing: u32,
}

impl BsdfLanes {
    /// Lanes without a model.
    pub fn new() -> Self {
        Self::default()
    }

    /// Removes the models of all lanes.
    pub fn clear(&mut self) {
        self.models.clear();
        (self.smooth, self.guided, self.transmitting, self.choosing) = (0, 0, 0, 0);
    }

    /// Whether lanes can have the model.
    pub fn knows(bsdf: &Bsdf) -> bool {
        ModelLanes::knows(bsdf)
    }

    /// Sets the model of a lane that has none. It must be [known](Self::knows).
    #[inline(always)]
    pub fn set(&mut self, lane: usize, bsdf: &Bsdf) {
        self.models.set(lane, bsdf);
        let bit = |condition: bool| u32::from(condition) << lane;
        self.smooth |= bit(bsdf.has_smooth_lobe());
        self.guided |= bit(bsdf.may_have_diffuse_lobe());
        self.transmitting |= bit(bsdf.transmits());
        self.choosing |= bit(bsdf.chooses_lobes());
    }

    /// The lanes with [`Bsdf::has_smooth_lobe`], a bit each.
    pub fn smooth(&self) -> u32 {
        self.smooth
    }

    /// The lanes with [`Bsdf::may_have_diffuse_lobe`], for which path guiding pays off, a bit each.
    pub fn guided(&self) -> u32 {
        self.guided
    }

    /// The lanes with [`Bsdf::transmits`], a bit each.
    pub fn transmitting(&self) -> u32 {
        self.transmitting
    }

    /// The lanes with [`Bsdf::chooses_lobes`], a bit each.
    pub fn choosing(&self) -> u32 {
        self.choosing
    }

    /// Evaluates as [`Bsdf::eval_and_pdf`], for paths that carry radiance.
    #[inline(always)]
    pub fn eval_and_pdf(&self, tables: &ShadingTables, wo: Vec3Lanes, wi: Vec3Lanes) -> (Vec3Lanes, Lanes) {
        let mut evaluating = Evaluating {
            tables,
            wo,
            wi,
            value: Vec3Lanes::ZERO,
            pdf: Lanes::ZERO,
        };
        self.models.each(&mut evaluating);
        (evaluating.value, evaluating.pdf)
    }

    /// Samples as [`Bsdf::sample`].
    #[inline(always)]
    pub fn sample(
        &self,
        tables: &ShadingTables,
        wo: Vec3Lanes,
        u_lobe: Lanes,
        u: [Lanes; 2],
        mode: TransportMode,
    ) -> BsdfSample<Lanes> {
        let mut sampling = Sampling {
            tables,
            wo,
            u_lobe,
            u,
            mode,
            sample: BsdfSample::NONE,
        };
        self.models.each(&mut sampling);
        sampling.sample
    }

    /// The lobes of [`Bsdf::diffuse_lobe`].
    #[inline(never)]
    pub fn diffuse_lobes(&self, tables: &ShadingTables, wo: Vec3Lanes) -> DiffuseLobe<Lanes> {
        let mut seeking = SeekingLobes {
            tables,
            wo,
            lobe: DiffuseLobe::NONE,
        };
        self.models.each(&mut seeking);
        seeking.lobe
    }
}

struct Evaluating<'a> {
    tables: &'a ShadingTables,
    wo: Vec3Lanes,
    wi: Vec3Lanes,
    value: Vec3Lanes,
    pdf: Lanes,
}

impl Evaluating<'_> {
    #[inline(always)]
    fn evaluate<M: Model<Lanes>>(&mut self, lanes: Lanes, model: &M) {
        let (value, pdf) = model.eval_and_pdf(self.tables, self.wo, self.wi, TransportMode::Radiance);
        self.value = Vec3Lanes::select(lanes, value, self.value);
        self.pdf = lanes.select(pdf, self.pdf);
    }

    #[inline(never)]
    fn evaluate_apart<M: Model<Lanes>>(&mut self, lanes: Lanes, model: &M) {
        self.evaluate(lanes, model);
    }
}

impl Visit for Evaluating<'_> {
    #[inline(always)]
    fn model<M: Model<Lanes>>(&mut self, lanes: Lanes, model: &M) {
        match M::IS_SHORT {
            true => self.evaluate(lanes, model),
            false => self.evaluate_apart(lanes, model),
        }
    }
}

struct Sampling<'a> {
    tables: &'a ShadingTables,
    wo: Vec3Lanes,
    u_lobe: Lanes,
    u: [Lanes; 2],
    mode: TransportMode,
    sample: BsdfSample<Lanes>,
}

impl Sampling<'_> {
    #[inline(always)]
    fn draw<M: Model<Lanes>>(&mut self, lanes: Lanes, model: &M) {
        let sample = model.sample(self.tables, self.wo, self.u_lobe, self.u, self.mode);
        self.sample.choose(lanes, sample);
    }

    #[inline(never)]
    fn draw_apart<M: Model<Lanes>>(&mut self, lanes: Lanes, model: &M) {
        self.draw(lanes, model);
    }
}

impl Visit for Sampling<'_> {
    #[inline(always)]
    fn model<M: Model<Lanes>>(&mut self, lanes: Lanes, model: &M) {
        match M::IS_SHORT {
            true => self.draw(lanes, model),
            false => self.draw_apart(lanes, model),
        }
    }
}

struct SeekingLobes<'a> {
    tables: &'a ShadingTables,
    wo: Vec3Lanes,
    lobe: DiffuseLobe<Lanes>,
}

impl Visit for SeekingLobes<'_> {
    #[inline(never)]
    fn model<M: Model<Lanes>>(&mut self, lanes: Lanes, model: &M) {
        self.lobe = model.diffuse_lobe(self.tables, self.wo).or(lanes, self.lobe);
    }
}

impl BsdfSample<Lanes> {
    /// Absorbed light.
    const NONE: Self = Self {
        wi: Vec3Lanes::ZERO,
        weight: Vec3Lanes::ZERO,
        pdf: Lanes::ONE,
        is_delta: Lanes::ZERO,
        eta: Lanes::ONE,
        is_returned: Lanes::ZERO,
    };

    /// The sample of `other` where `condition` holds.
    #[inline(always)]
    pub(crate) fn choose(&mut self, condition: Lanes, other: Self) {
        self.wi = Vec3Lanes::select(condition, other.wi, self.wi);
        self.weight = Vec3Lanes::select(condition, other.weight, self.weight);
        self.pdf = condition.select(other.pdf, self.pdf);
        self.is_delta = condition.select(other.is_delta, self.is_delta);
        self.eta = condition.select(other.eta, self.eta);
        self.is_returned = condition.select(other.is_returned, self.is_returned);
    }
}

#[cfg(test)]
mod tests;
