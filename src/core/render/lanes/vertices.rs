//! The current vertices of sixteen paths.

use glam::{Vec2, Vec3};

use crate::accel::{Detail, Hit, SurfaceLanes, SurfacePoint};
use crate::color::Rgb;
use crate::material::{BumpShadow, Lobe, Single};
use crate::math::lanes::{LANES, Lanes, Vec3Lanes, each_lane, lanes_of};
use crate::math::{Frame, Held, Ray, Vector};
use crate::medium::{MediumId, MediumInterface, PlainPhase};
use crate::render::scene::{RenderScene, SurfaceSlot};
use crate::shading::lanes::BsdfLanes;
use crate::shading::{BsdfSample, DiffuseLobe, ShadingTables, TransportMode};

/// The surfaces and their models; only the lanes of `lanes` are valid.
pub(super) struct Vertices<'a, const MEDIA: bool> {
    /// A bit per lane.
    pub lanes: u32,
    pub position: Vec3Lanes,
    /// The errors as in [`SurfacePoint`].
    pub error: Lanes,
    pub geometric_normal: Vec3Lanes,
    pub shading_normal: Vec3Lanes,
    /// The side of the shading normal seen by the path: 1, or -1 from behind.
    pub side: Lanes,
    /// The lanes whose first two axes are given, a bit each. Those of other lanes follow from the shading normal.
    framed: u32,
    axes: [Vec3Lanes; 2],
    /// The surfaces of meshes, before their models are looked up.
    meshes: Option<SurfaceLanes>,
    /// The models.
    pub bsdf: BsdfLanes,
    /// The shadowing by the surfaces below maps.
    bump_shadows: Held<BumpShadow<Lanes>>,
    /// The lanes that are in a medium and not on a surface, a bit each. Their shading normal is the direction in which
    /// the path has arrived.
    in_medium: u32,
    phase: PlainPhase<Lanes>,
    /// The lanes on surfaces with media on their sides, which are in `sides`.
    pub borders: u32,
    sides: [MediumInterface; LANES],
    /// The lanes whose models are evaluated one by one.
    pub other: u32,
    singles: [Option<Single<'a>>; LANES],
    /// The lanes of `other` that have smooth lobes.
    other_smooth: u32,
    /// The lanes of `other` that may have a diffuse lobe.
    other_diffuse: u32,
    /// The lanes of `other` that scatter light from one half space only.
    other_halved: u32,
}

/// The diffuse lobes of the models at the vertices, as [`crate::shading::DiffuseLobe`].
#[derive(Clone, Copy)]
pub(super) struct DiffuseLobeLanes {
    /// The normals in the world.
    pub normal: Vec3Lanes,
    /// The starts of the ranges of numbers that choose the lobes, from 0 to 1.
    pub start: Lanes,
    /// The probabilities of the lobes, from 0 to 1.
    pub share: Lanes,
}

/// The surface at a vertex.
pub(super) struct Met {
    pub point: SurfacePoint,
    /// Whether it has [`crate::material::Scattering::has_smooth_lobe`].
    pub is_smooth: bool,
    /// The albedo as [`crate::material::Scattering::albedo`].
    pub albedo: Rgb,
}

impl<'a, const MEDIA: bool> Vertices<'a, MEDIA> {
    pub fn new() -> Self {
        Self {
            lanes: 0,
            position: Vec3Lanes::ZERO,
            error: Lanes::ZERO,
            geometric_normal: Vec3Lanes::ZERO,
            shading_normal: Vec3Lanes::ZERO,
            side: Lanes::ONE,
            framed: 0,
            axes: [Vec3Lanes::ZERO; 2],
            meshes: None,
            bsdf: BsdfLanes::new(),
            bump_shadows: Held::default(),
            in_medium: 0,
            phase: PlainPhase::ISOTROPIC,
            borders: 0,
            sides: [MediumInterface::default(); LANES],
            other: 0,
            singles: [const { None }; LANES],
            other_smooth: 0,
            other_diffuse: 0,
            other_halved: 0,
        }
    }

    pub fn clear(&mut self) {
        (self.lanes, self.framed) = (0, 0);
        self.meshes = None;
        self.bsdf.clear();
        self.bump_shadows.lanes = 0;
        (self.in_medium, self.borders) = (0, 0);
        (self.other, self.other_smooth, self.other_halved) = (0, 0, 0);
        self.other_diffuse = 0;
    }

    /// The lanes that are in media, a bit each.
    #[inline(always)]
    pub fn in_media(&self) -> u32 {
        if MEDIA { self.in_medium } else { 0 }
    }

    /// The lanes with [`crate::material::Scattering::has_smooth_lobe`], a bit each.
    pub fn smooth(&self) -> u32 {
        self.bsdf.smooth() | self.in_media() | self.other_smooth
    }

    /// The lanes for whose directions path guiding pays off, a bit each.
    pub fn guided(&self) -> u32 {
        self.bsdf.guided() | self.other_diffuse
    }

    /// The models' frames, with the shading normals on the side seen.
    #[inline(always)]
    pub fn frames(&self) -> Frame<Lanes> {
        let upright = Frame::<Lanes>::around(self.shading_normal);
        let (own, [s, t]) = (lanes_of(self.framed), self.axes);
        Frame {
            s: Vec3Lanes::select(own, s, upright.s),
            t: Vec3Lanes::select(own, t, upright.t),
            n: self.shading_normal * self.side,
        }
    }

    /// The diffuse lobes of the lanes `asked`, which are among [`Self::guided`]. `normal` are the normals of the models
    /// in lanes, and `wo` the directions in their frames.
    #[inline(always)]
    pub fn diffuse_lobes(
        &self,
        tables: &ShadingTables,
        asked: u32,
        normal: Vec3Lanes,
        wo: Vec3Lanes,
    ) -> DiffuseLobeLanes {
        let DiffuseLobe { start, share } = self.bsdf.diffuse_lobes(tables, wo);
        let lobes = DiffuseLobeLanes { normal, start, share };
        match asked & self.other {
            0 => lobes,
            others => self.with_lobes_of_others(others, lobes),
        }
    }

    #[inline(never)]
    fn with_lobes_of_others(&self, others: u32, mut lobes: DiffuseLobeLanes) -> DiffuseLobeLanes {
        for lane in each_lane(others) {
            if let Some(single) = &self.singles[lane] {
                let (lobe, normal) = single.diffuse_lobe();
                lobes.normal.set(lane, normal);
                lobes.start.as_mut_array()[lane] = lobe.start;
                lobes.share.as_mut_array()[lane] = lobe.share;
            }
        }
        lobes
    }

    /// The lanes that have a [`crate::material::Scattering::one_sided_normal`], which is the shading normal on the side
    /// seen.
    pub fn halved(&self) -> u32 {
        self.lanes & !(self.bsdf.transmitting() | self.in_media() | self.other & !self.other_halved)
    }

    /// The values and densities of the models in lanes and of phase functions. `wo` is in the frames of the vertices,
    /// which are `frame`, and `wi` in the world.
    #[inline(always)]
    pub fn eval_and_pdf(
        &self,
        tables: &ShadingTables,
        wo: Vec3Lanes,
        frame: Frame<Lanes>,
        wi: Vec3Lanes,
    ) -> (Vec3Lanes, Lanes) {
        let local = frame.to_local(wi);
        let (mut value, mut pdf) = self.bsdf.eval_and_pdf(tables, wo, local);
        if let Some(factor) = self.bump_shadow(wi) {
            value = value * factor;
            pdf &= factor.simd_gt(Lanes::ZERO);
        }
        match self.in_media() {
            0 => (value, pdf),
            _ => self.with_densities(value, pdf, local.z),
        }
    }

    /// The factor of [`BumpShadow::factor`] on light from `wi`, in the world; 1 without a map, None if no lane has one.
    #[inline(always)]
    pub fn bump_shadow(&self, wi: Vec3Lanes) -> Option<Lanes> {
        let (here, shadow) = self.bump_shadows.held()?;
        Some(here.select(shadow.factor(wi), Lanes::ONE))
    }

    /// Replaces the values and densities in the lanes in media.
    #[inline(never)]
    fn with_densities(&self, value: Vec3Lanes, pdf: Lanes, cosine: Lanes) -> (Vec3Lanes, Lanes) {
        let here = lanes_of(self.in_medium);
        let density = self.phase.pdf(cosine);
        (
            Vec3Lanes::select(here, Vec3Lanes::even(density), value),
            here.select(density, pdf),
        )
    }

    /// Samples directions by the models in lanes and by phase functions, in the frames of the vertices.
    #[inline(always)]
    pub fn sample(&self, tables: &ShadingTables, wo: Vec3Lanes, u_lobe: Lanes, u: [Lanes; 2]) -> BsdfSample<Lanes> {
        let sample = self.bsdf.sample(tables, wo, u_lobe, u, TransportMode::Radiance);
        match self.in_media() {
            0 => sample,
            _ => self.with_phases(sample, u),
        }
    }

    /// Replaces the samples in the lanes in media.
    #[inline(never)]
    fn with_phases(&self, mut sample: BsdfSample<Lanes>, u: [Lanes; 2]) -> BsdfSample<Lanes> {
        let here = lanes_of(self.in_medium);
        let (wi, pdf) = self.phase.sample(u);
        let of_phase = BsdfSample {
            wi,
            weight: Vec3Lanes::splat(Vec3::ONE),
            pdf,
            is_delta: Lanes::ZERO,
            eta: Lanes::ONE,
            is_returned: here,
        };
        sample.choose(here, of_phase);
        sample
    }

    /// Sets vertices in media in `lanes`, the only lanes so far, at which the paths have arrived in the directions
    /// `dir`.
    #[inline(always)]
    pub fn set_media(&mut self, lanes: u32, position: Vec3Lanes, dir: Vec3Lanes, phase: PlainPhase<Lanes>) {
        (self.lanes, self.in_medium) = (lanes, lanes);
        self.phase = phase;
        self.position = position;
        self.error = Lanes::ZERO;
        self.geometric_normal = dir;
        self.shading_normal = dir;
        self.side = Lanes::ONE;
    }

    /// Removes a lane from those in media.
    pub fn leave_medium(&mut self, lane: usize) {
        self.lanes &= !(1 << lane);
        self.in_medium &= !(1 << lane);
    }

    /// Sets the media on the sides of the surface of a lane.
    pub fn set_sides(&mut self, lane: usize, sides: MediumInterface) {
        self.borders |= 1 << lane;
        self.sides[lane] = sides;
    }

    /// The medium of a path that leaves the vertex of a lane in direction `dir`, and came there through `before`.
    #[inline(always)]
    pub fn entered(&self, lane: usize, before: Option<MediumId>, dir: Vec3) -> Option<MediumId> {
        match self.borders >> lane & 1 {
            0 => before,
            _ => self.sides[lane].entered(before, dir, self.geometric_normal.get(lane)),
        }
    }

    /// Replaces `value` and `pdf` by those of [`Single::eval_and_pdf`] in the lanes `asked`, which are in `other`. Not
    /// inlined, so that lane values stay in registers.
    #[inline(never)]
    pub fn eval_others(&self, asked: u32, wi: Vec3Lanes, mut value: Vec3Lanes, mut pdf: Lanes) -> (Vec3Lanes, Lanes) {
        for lane in each_lane(asked) {
            if let Some(single) = &self.singles[lane] {
                let (own_value, own_pdf) = single.eval_and_pdf(wi.get(lane));
                value.set(lane, own_value);
                pdf.as_mut_array()[lane] = own_pdf;
            }
        }
        (value, pdf)
    }

    /// Replaces `sample` by that of [`Single::sample`] in the lanes of `other` that are among `lanes`, in world space.
    #[inline(never)]
    pub fn sample_others(
        &self,
        lanes: u32,
        u_lobe: Lanes,
        u: [Lanes; 2],
        mut sample: BsdfSample<Lanes>,
    ) -> BsdfSample<Lanes> {
        let asked = lanes & self.other;
        let mut returned = sample.is_returned.to_bitmask() & !asked;
        let mut delta = sample.is_delta.to_bitmask() & !asked;
        for lane in each_lane(asked) {
            let [u_lobe, x, y] = [u_lobe, u[0], u[1]].map(|numbers| numbers.as_array()[lane]);
            let single = self.singles[lane].as_ref();
            if let Some(own) = single.and_then(|single| single.sample(u_lobe, Vec2::new(x, y))) {
                sample.wi.set(lane, own.wi);
                sample.weight.set(lane, own.weight);
                sample.pdf.as_mut_array()[lane] = own.pdf;
                sample.eta.as_mut_array()[lane] = own.eta;
                returned |= 1 << lane;
                delta |= u32::from(own.lobe != Lobe::Smooth) << lane;
            }
        }
        (sample.is_returned, sample.is_delta) = (lanes_of(returned), lanes_of(delta));
        sample
    }

    /// Finds the surfaces of meshes at the hits `asked`, a bit each, at once, for [`Self::set_plain`] and
    /// [`Self::set_other`].
    #[inline(always)]
    pub fn find_meshes(&mut self, scene: &RenderScene, hits: &[Option<Hit>; LANES], asked: u32) {
        self.meshes = scene.geometry.mesh_surfaces(hits, asked);
    }

    /// The surface of a lane, if [`Self::find_meshes`] has found it.
    #[inline(always)]
    fn found(&self, lane: usize) -> Option<SurfacePoint> {
        let meshes = self.meshes.as_ref()?;
        (meshes.lanes >> lane & 1 == 1).then(|| meshes.get(lane))
    }

    /// Sets the surface of `ray`'s hit at `hit` in `lane`. None, without a change, if its model depends on more than
    /// the side seen, or its light needs a parametrised surface.
    #[inline(always)]
    pub fn set_plain(
        &mut self,
        lane: usize,
        scene: &RenderScene,
        ray: &Ray,
        hit: &Hit,
        slot: &SurfaceSlot,
    ) -> Option<Met> {
        let is_textured = slot.light.is_some_and(|light| scene.lights.is_textured(light));
        if is_textured || !scene.materials.is_for_lanes(slot.material) {
            return None;
        }
        let found = self.found(lane);
        let point = found.unwrap_or_else(|| scene.geometry.surface_in(ray, hit, Detail::Plain));
        let made_of = scene
            .materials
            .plain(slot.material, -point.shading_normal.dot(ray.dir))?;
        self.set_place(lane, &point);
        self.shading_normal.set(lane, point.shading_normal);
        self.side.as_mut_array()[lane] = made_of.side;
        self.bsdf.set(lane, made_of.bsdf);
        Some(Met {
            point,
            is_smooth: made_of.bsdf.has_smooth_lobe(),
            albedo: made_of.albedo,
        })
    }

    /// [`Self::set_plain`] for any other kind. None if it is a mixture of models or lets light pass straight through.
    pub fn set_other(
        &mut self,
        lane: usize,
        scene: &'a RenderScene,
        ray: &Ray,
        hit: &Hit,
        slot: &SurfaceSlot,
    ) -> Option<Met> {
        let point = match (self.found(lane), scene.detail(slot)) {
            (Some(point), Detail::Plain) => point,
            (Some(point), Detail::Parametrised) => scene.geometry.parametrised(hit, point),
            (None, detail) => scene.geometry.surface_in(ray, hit, detail),
        };
        let single = scene.single(slot.material, hit, &point, -ray.dir, TransportMode::Radiance)?;
        let (is_smooth, albedo) = (single.has_smooth_lobe(), single.albedo());
        match single.model().filter(|model| BsdfLanes::knows(model.bsdf)) {
            Some(model) => {
                self.bsdf.set(lane, model.bsdf);
                self.shading_normal.set(lane, model.frame.n);
                self.side.as_mut_array()[lane] = model.side;
                self.framed |= 1 << lane;
                self.axes[0].set(lane, model.frame.s);
                self.axes[1].set(lane, model.frame.t);
                if let Some(shadow) = model.shadow {
                    self.bump_shadows.set(lane, shadow);
                }
            }
            None => self.set_single(lane, single),
        }
        self.set_place(lane, &point);
        Some(Met {
            point,
            is_smooth,
            albedo,
        })
    }

    /// Sets a model that is evaluated one by one.
    #[inline(never)]
    fn set_single(&mut self, lane: usize, single: Single<'a>) {
        let one_sided_normal = single.one_sided_normal();
        self.shading_normal.set(lane, one_sided_normal.unwrap_or(Vec3::Z));
        self.side.as_mut_array()[lane] = 1.0;
        let bit = |condition: bool| u32::from(condition) << lane;
        self.other |= bit(true);
        self.other_smooth |= bit(single.has_smooth_lobe());
        self.other_diffuse |= bit(single.may_have_diffuse_lobe());
        self.other_halved |= bit(one_sided_normal.is_some());
        self.singles[lane] = Some(single);
    }

    #[inline(always)]
    fn set_place(&mut self, lane: usize, point: &SurfacePoint) {
        self.lanes |= 1 << lane;
        self.position.set(lane, point.position);
        self.error.as_mut_array()[lane] = point.error;
        self.geometric_normal.set(lane, point.geometric_normal);
    }
}
