//! Directions from a guide, at the vertices of sixteen paths.

use std::f32::consts::FRAC_1_PI;

use super::vertices::DiffuseLobeLanes;
use crate::math::Vector;
use crate::math::lanes::{LANES, Lanes, Vec3Lanes, WordLanes, lanes_of};
use crate::render::guide::{BinLanes, Field, UNITS};
use crate::shading::BsdfSample;

/// The histograms at the vertices.
pub(super) struct Guided<'a> {
    field: &'a Field,
    /// The lanes with a histogram, a bit each.
    lanes: u32,
    cells: [u32; LANES],
    axes: BinLanes,
    lobes: DiffuseLobeLanes,
    /// The parts of the lobes' directions that are sampled from the histograms, from 0 to 1.
    parts: Lanes,
}

impl<'a> Guided<'a> {
    /// The histograms for the lanes `asked`; None if none of them has one.
    #[inline(always)]
    pub fn of(field: &'a Field, asked: u32, position: Vec3Lanes, lobes: DiffuseLobeLanes) -> Option<Self> {
        let axes = BinLanes::of(lobes.normal);
        let places = field.places(position, &axes).to_array();
        // Looked up for all lanes, since unrequested lanes have valid indices as well: that is faster than visiting
        // single bits.
        let cells = places.map(|place| field.cell_at(place));
        let has_lobe = lobes.share.simd_gt(Lanes::ZERO).to_bitmask();
        let lanes = asked & has_lobe & !WordLanes::new(cells).simd_eq(WordLanes::ZERO).to_bitmask();
        (lanes != 0).then_some(Self {
            field,
            lanes,
            cells,
            axes,
            lobes,
            parts: Lanes::new(cells.map(|cell| field.cell(cell).part())),
        })
    }

    /// The lanes with a histogram, a bit each.
    #[inline(always)]
    pub fn lanes(&self) -> u32 {
        self.lanes
    }

    /// The densities of the directions `wi` in the world, given the densities `bsdf_pdf` with which the BSDF would
    /// sample them.
    #[inline(always)]
    pub fn mixed(&self, wi: Vec3Lanes, bsdf_pdf: Lanes) -> Lanes {
        let (bins, density) = self.axes.find(wi);
        let bins = bins.to_array();
        let counts = std::array::from_fn(|lane| self.field.cell(self.cells[lane]).count(bins[lane]) as f32);
        let pdf = Lanes::new(counts) * density * Lanes::splat(1.0 / UNITS as f32);
        let cosine = self.lobes.normal.dot(wi).fast_max(Lanes::ZERO) * Lanes::splat(FRAC_1_PI);
        // The lobe's density is at most that of the whole model, which rounding may violate at the horizon.
        let least = self.parts.mul_neg_add(bsdf_pdf, bsdf_pdf);
        let mixed = (pdf - cosine)
            .mul_add(self.parts * self.lobes.share, bsdf_pdf)
            .fast_max(least);
        (lanes_of(self.lanes) & bsdf_pdf.simd_gt(Lanes::ZERO)).select(mixed, bsdf_pdf)
    }

    /// Samples directions from the histograms, in world space.
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

    /// Replaces the BSDF samples `sample`, in world space, of the lanes `here` by samples of the mixture with their
    /// histograms, where `u_lobe` has chosen the lobes of the BSDF. `eval_and_pdf` evaluates the BSDF for directions in
    /// the world, in the lanes of its second argument, which have a direction.
    #[inline(always)]
    pub fn sample(
        &self,
        here: u32,
        eval_and_pdf: impl Fn(Vec3Lanes, u32) -> (Vec3Lanes, Lanes),
        u_lobe: Lanes,
        u: [Lanes; 2],
        mut sample: BsdfSample<Lanes>,
    ) -> BsdfSample<Lanes> {
        let here = lanes_of(here);
        let in_lobe = u_lobe - self.lobes.start;
        let by_guide = in_lobe.simd_ge(Lanes::ZERO) & in_lobe.simd_lt(self.parts * self.lobes.share) & here;
        // The BSDF may have returned no direction: `sample.wi` is then left over from other lanes.
        let is_there = by_guide | sample.is_returned;
        let wi = Vec3Lanes::select(by_guide, self.directions(u), sample.wi);
        let (value, bsdf_pdf) = eval_and_pdf(wi, is_there.to_bitmask());
        let pdf = self.mixed(wi, bsdf_pdf);
        let mixed = BsdfSample {
            wi,
            weight: value / pdf,
            pdf,
            is_delta: Lanes::ZERO,
            // Roulette uses the throughput that the BSDF alone would give to a direction that the guide prefers. In
            // other directions paths have more than that, and must survive for it.
            eta: (pdf / bsdf_pdf).fast_max(Lanes::ONE).sqrt(),
            is_returned: bsdf_pdf.simd_gt(Lanes::ZERO) & is_there,
        };
        sample.is_returned &= !here;
        sample.choose(here, mixed);
        sample
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;
    use crate::render::guide::PhotonArrival;

    /// A guide for a floor whose light comes from one side.
    fn field() -> Field {
        let arrival = |number: u32| PhotonArrival {
            position: Vec3::new((number % 97) as f32, 0.0, (number % 89) as f32),
            normal: Vec3::Y,
            wi: Vec3::new(1.0, 0.4 + 1e-3 * (number % 7) as f32, 0.1).normalize(),
            power: 1.0,
        };
        Field::learn(&(0..1 << 14).map(arrival).collect::<Vec<_>>()).expect("a guide")
    }

    #[test]
    fn densities_of_a_lobe_are_its_probability_in_all() {
        const ROWS: usize = 400;
        let field = field();
        for share in [1.0, 0.8, 0.3, 0.01] {
            let lobes = DiffuseLobeLanes {
                normal: Vec3Lanes::splat(Vec3::Y),
                start: Lanes::splat(1.0 - share),
                share: Lanes::splat(share),
            };
            let place = Vec3Lanes::splat(Vec3::new(30.0, 0.0, 40.0));
            let guided = Guided::of(&field, 1, place, lobes).expect("a histogram");
            let mut sum = 0.0;
            for (row, column) in (0..ROWS).flat_map(|row| (0..2 * ROWS).map(move |column| (row, column))) {
                let y = (row as f32 + 0.5) / ROWS as f32;
                let (sin, cos) = (std::f32::consts::PI * (column as f32 + 0.5) / ROWS as f32).sin_cos();
                let across = (1.0 - y * y).sqrt();
                let wi = Vec3Lanes::splat(Vec3::new(across * cos, y, across * sin));
                let density = guided.mixed(wi, Lanes::splat(share * y * FRAC_1_PI)).as_array()[0];
                sum += f64::from(density) * std::f64::consts::TAU / (2 * ROWS * ROWS) as f64;
            }
            assert!((sum / f64::from(share) - 1.0).abs() < 0.01, "{share}: {sum}");
        }
    }
}
