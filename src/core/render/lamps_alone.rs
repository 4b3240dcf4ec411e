//! The light of some lamps alone at some pixels of the picture: as if all others were switched off.
//!
//! Renderings of the same pixels have the same random numbers, so that two of them differ by what differs in the lamps
//! and hardly by noise (common random numbers; Owen, Monte Carlo theory, methods and examples, 2013, section 8.6).

use std::collections::HashMap;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use glam::{Affine3A, UVec2};
use rayon::prelude::*;

use super::breakdown::followed;
use super::lanes::Job;
use super::scene::{RenderScene, SurfaceSlot, SurfaceTable};
use super::tracer::Tracer;
use super::view::{Shown, View};
use crate::accel::{Instance, ShapeEdits, SplitMethod, Tlas};
use crate::color::Rgb;
use crate::light::{LightId, LightTable, WeightedSource};

/// The most samples that are traced as one task.
const SAMPLES_OF_TASK: usize = 2048;

impl RenderScene {
    /// The scene with some of its own lights alone, as if the others and all glowing media were switched off. `lights`
    /// has the number of each light and its source, which may differ from the present one.
    pub fn lit_by_own(&self, lights: &[(LightId, WeightedSource)]) -> Self {
        let sources: Vec<WeightedSource> = lights.iter().map(|(_, source)| source.clone()).collect();
        let table = LightTable::build(&sources, &self.geometry, &self.textures);
        let new_id: HashMap<LightId, LightId> = lights.iter().map(|(old, _)| *old).zip((0..).map(LightId)).collect();
        let of_slot = |slot: &SurfaceSlot| SurfaceSlot {
            light: slot.light.and_then(|light| new_id.get(&light).copied()),
            ..*slot
        };
        Self {
            surfaces: Arc::new(SurfaceTable {
                first_slot: self.surfaces.first_slot.clone(),
                slots: self.surfaces.slots.iter().map(of_slot).collect(),
            }),
            reach: table.reach(&self.geometry),
            lights: Arc::new(table),
            media: match self.media.glows() {
                true => Arc::new(self.media.without_emission()),
                false => self.media.clone(),
            },
            ..self.clone()
        }
    }

    /// The scene after a rigid motion of the shapes with these numbers, ascending. The table of lights is the old one:
    /// [`Self::lit_by_own`] builds that anew. None if a shape cannot be where it should.
    pub fn with_shapes_moved(&self, shapes: &[u32], by: Affine3A) -> Option<Self> {
        let moved = |number: u32| {
            let old = self.geometry.instances().get(number as usize)?;
            let mut new = Instance::new(old.primitive.clone(), by * old.world_from_local)?;
            (new.face_normals, new.flip_normals) = (old.face_normals, old.flip_normals);
            Some((number, new))
        };
        let edits = ShapeEdits {
            replaced: shapes.iter().map(|&number| moved(number)).collect::<Option<_>>()?,
            ..ShapeEdits::default()
        };
        let geometry = self.geometry.edited(&edits).unwrap_or_else(|| {
            let mut instances: Vec<Instance> = self.geometry.instances().iter().cloned().collect();
            for (number, new) in edits.replaced {
                instances[number as usize] = new;
            }
            let (groups, placements) = (self.geometry.groups().to_vec(), self.geometry.placements().to_vec());
            Tlas::with_placements(instances, groups, placements, SplitMethod::default())
        });
        Some(Self {
            geometry: Arc::new(geometry),
            ..self.clone()
        })
    }
}

/// The quantity that is wanted of pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// The radiance that the camera sees.
    Radiance,
    /// The irradiance on the side of the first surface that faces the camera.
    Irradiance,
}

/// The mean light of some samples of each of these pixels by path tracing, in linear Rec. 709, without the clamp, the
/// guide and the layers of the view; None for the irradiance of a pixel without a surface. Tasks run on the threads of
/// the current `rayon` pool; the result does not depend on their number. None for all if `cancel` was set in the
/// meantime. Samples that are not finite count as black.
pub fn light_of_pixels(
    scene: &RenderScene,
    view: &View,
    quantity: Quantity,
    pixels: &[UVec2],
    samples: u32,
    cancel: &AtomicBool,
) -> Option<Vec<Option<Rgb>>> {
    let samples = samples.max(1);
    let view = View {
        shown: match quantity {
            Quantity::Radiance => Shown::Radiance,
            Quantity::Irradiance => Shown::Illuminance,
        },
        ..followed(view)
    };
    let tracer = Tracer::of(&view);
    let of_task = |pixels: &[UVec2]| {
        let jobs = pixels
            .iter()
            .flat_map(|&pixel| (0..samples).map(move |index| Job { pixel, index }));
        let mut traced = tracer.trace(scene, &view, jobs.clone(), cancel)?;
        let mut sums = vec![(Rgb::ZERO, 0_u32); pixels.len()];
        for (number, job) in jobs.enumerate() {
            let (sample, weight) = traced.next(job);
            let (sum, count) = &mut sums[number / samples as usize];
            let (light, counts) = match quantity {
                Quantity::Radiance => (sample.radiance * weight, true),
                // The mean over the surface in the pixel does not depend on how much of the pixel it covers.
                Quantity::Irradiance => (sample.radiance, sample.first_hit.is_some()),
            };
            if light.is_finite() {
                *sum += light;
            }
            *count += u32::from(counts);
        }
        let mean = |(sum, count): (Rgb, u32)| (count > 0).then(|| sum / count as f32);
        Some(sums.into_iter().map(mean).collect())
    };
    let pixels_of_task = (SAMPLES_OF_TASK / samples as usize).max(1);
    let parts: Option<Vec<Vec<Option<Rgb>>>> = pixels.par_chunks(pixels_of_task).map(of_task).collect();
    Some(parts?.concat())
}
