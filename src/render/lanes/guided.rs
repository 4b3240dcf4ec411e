//! Directions from a guide, at the vertices of sixteen paths.

use std::f32::consts::FRAC_1_PI;

use super::vertices::DiffuseLobeLanes;
use crate::math::lanes::{LANES, Lanes, Vec3Lanes, WordLanes, lanes_of};
use crate::render::guide::{BinLanes, Field, UNITS};
use crate::shading::lanes::BsdfSampleLanes;

/// The histograms at the vertices.
pub(super) struct Guided<'a> {
    field: &'a Field,
    /// The lanes that have one, a bit each.
    lanes: u32,
    cells: [u32; LANES],
    axes: BinLanes,
    lobes: DiffuseLobeLanes,
    /// The parts of the directions of these that are from the histograms.
    parts: Lanes,
}

impl<'a> Guided<'a> {
    /// The histograms for the lanes `asked`; None if none of them has one.
    #[inline(always)]
    pub fn of(field: &'a Field, asked: u32, position: Vec3Lanes, lobes: DiffuseLobeLanes) -> Option<Self> {
        let axes = BinLanes::of(lobes.normal);
        let places = field.places(position, &axes).to_array();
        // Looked up for all lanes, since those that were not asked for have a place as well: it takes less than to go from bit to bit.
        let cells = places.map(|place| field.cell_at(place));
        let lanes = asked & !WordLanes::new(cells).simd_eq(WordLanes::ZERO).to_bitmask();
        (lanes != 0).then_some(Self {
            field,
            lanes,
            cells,
            axes,
            lobes,
            parts: Lanes::new(cells.map(|cell| field.cell(cell).part())),
        })
    }

    /// The lanes that have one, a bit each.
    #[inline(always)]
    pub fn lanes(&self) -> u32 {
        self.lanes
    }

    /// The densities of the directions `wi` in the world, for paths that would take them by the bsdf with density `bsdf_pdf`.
    #[inline(always)]
    pub fn mixed(&self, wi: Vec3Lanes, bsdf_pdf: Lanes) -> Lanes {
        let (bins, density) = self.axes.find(wi);
        let bins = bins.to_array();
        let counts = std::array::from_fn(|lane| self.field.cell(self.cells[lane]).count(bins[lane]) as f32);
        let pdf = Lanes::new(counts) * density * Lanes::splat(1.0 / UNITS as f32);
        let cosine = self.lobes.normal.dot(wi).fast_max(Lanes::ZERO) * Lanes::splat(FRAC_1_PI);
        let part = self.parts * self.lobes.share;
        // The lobe is at most the whole model, which rounding may hide at the horizon.
        let least = part.mul_neg_add(bsdf_pdf, bsdf_pdf);
        let mixed = (pdf - cosine).mul_add(part, bsdf_pdf).fast_max(least);
        (lanes_of(self.lanes) & bsdf_pdf.simd_gt(Lanes::ZERO)).select(mixed, bsdf_pdf)
    }

    /// Directions in the world.
    #[inline(always)]
    fn directions(&self, u: [Lanes; 2]) -> Vec3Lanes {
        let place = u[0] * Lanes::splat(UNITS as f32);
        let units: WordLanes = bytemuck::cast(place.fast_trunc_int());
        let units = units.to_array();
        let (mut bins, mut starts, mut counts) = ([0.0; LANES], [0.0; LANES], [1.0; LANES]);
        for lane in 0..LANES {
            let (bin, start, count) = self.field.cell(self.cells[lane]).unit(units[lane]);
            (bins[lane], starts[lane], counts[lane]) = (bin as f32, start as f32, count as f32);
        }
        let x = (place - Lanes::new(starts)) / Lanes::new(counts);
        self.axes.direction(Lanes::new(bins), x, u[1])
    }

    /// Replaces the samples `sample` of the bsdf, in world space, of the lanes `here` by those of the mixture with their histograms, where `u_lobe` has chosen the lobes of the bsdf. `eval_and_pdf` gives the values and
    /// densities of the bsdf for directions in the world.
    #[inline(always)]
    pub fn sample(
        &self,
        here: u32,
        eval_and_pdf: impl Fn(Vec3Lanes) -> (Vec3Lanes, Lanes),
        u_lobe: Lanes,
        u: [Lanes; 2],
        mut sample: BsdfSampleLanes,
    ) -> BsdfSampleLanes {
        let here = lanes_of(here);
        let in_lobe = u_lobe - self.lobes.start;
        let by_guide = in_lobe.simd_ge(Lanes::ZERO) & in_lobe.simd_lt(self.parts * self.lobes.share) & here;
        // The bsdf may have returned no direction, and none is there then: `sample.wi` is what other lanes have left.
        let is_there = by_guide | sample.returned;
        let wi = Vec3Lanes::select(by_guide, self.directions(u), sample.wi);
        let (value, bsdf_pdf) = eval_and_pdf(wi);
        let pdf = self.mixed(wi, bsdf_pdf);
        let mixed = BsdfSampleLanes {
            wi,
            weight: value / pdf,
            pdf,
            // Roulette sees the throughput that the bsdf alone would give to a direction that the guide prefers. In other directions paths have more than
            // that, and are to be kept for it.
            eta: (pdf / bsdf_pdf).fast_max(Lanes::ONE).sqrt(),
            returned: bsdf_pdf.simd_gt(Lanes::ZERO) & is_there,
        };
        sample.returned &= !here;
        sample.choose(here, mixed);
        sample
    }
}
