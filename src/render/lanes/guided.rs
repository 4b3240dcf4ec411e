//! Directions from a guide, at the vertices of sixteen paths.

use crate::math::lanes::{LANES, Lanes, Vec3Lanes, WordLanes, lanes_of};
use crate::render::guide::{BinLanes, Field, SHARE, UNITS};
use crate::shading::lanes::BsdfSampleLanes;

/// The histograms at the vertices.
pub(super) struct Guided<'a> {
    field: &'a Field,
    /// The lanes that have one, a bit each.
    lanes: u32,
    cells: [u32; LANES],
    axes: BinLanes,
}

impl<'a> Guided<'a> {
    /// The histograms for the lanes `asked`; None if none of them has one.
    #[inline(always)]
    pub fn of(field: &'a Field, asked: u32, position: Vec3Lanes, normal: Vec3Lanes) -> Option<Self> {
        let axes = BinLanes::of(normal);
        let places = field.places(position, &axes).to_array();
        // Looked up for all lanes, since those that were not asked for have a place as well: it takes less than to go from bit to bit.
        let cells = places.map(|place| field.cell_at(place));
        let lanes = asked & !WordLanes::new(cells).simd_eq(WordLanes::ZERO).to_bitmask();
        (lanes != 0).then_some(Self {
            field,
            lanes,
            cells,
            axes,
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
        let share = Lanes::splat(SHARE);
        let pdf = Lanes::new(counts) * density * Lanes::splat(1.0 / UNITS as f32);
        lanes_of(self.lanes).select((pdf - bsdf_pdf).mul_add(share, bsdf_pdf), bsdf_pdf)
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

    /// Replaces the samples `sample` of the bsdf, in world space, of the guided lanes by those of the mixture with their histograms. `eval_and_pdf` gives the values and
    /// densities of the bsdf for directions in the world.
    #[inline(always)]
    pub fn sample(
        &self,
        eval_and_pdf: impl Fn(Vec3Lanes) -> (Vec3Lanes, Lanes),
        u_choice: Lanes,
        u: [Lanes; 2],
        mut sample: BsdfSampleLanes,
    ) -> BsdfSampleLanes {
        let here = lanes_of(self.lanes);
        let by_guide = u_choice.simd_lt(Lanes::splat(SHARE)) & here;
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
