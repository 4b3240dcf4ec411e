//! The portals of the scene, and what decides at which places they count.

use std::sync::{Arc, Weak};

use crate::accel::Tlas;
use crate::light::{LightTable, Portal};
use crate::render::scene::RenderScene;

/// Portals with the scene for which they were prepared.
#[derive(Default)]
pub(super) struct PortalsInUse {
    portals: Arc<[Portal]>,
    /// Its shapes.
    geometry: Weak<Tlas>,
    /// Whether light may pass straight through each shape; empty without portals, and if it passes through none.
    clear: Box<[bool]>,
}

impl PortalsInUse {
    /// The portals in this scene.
    pub fn new(portals: Arc<[Portal]>, scene: &RenderScene) -> Self {
        let shapes = match portals.is_empty() || !scene.materials.has_null_lobe() {
            true => 0,
            false => scene.surfaces.first_slot.len(),
        };
        Self {
            portals,
            geometry: Arc::downgrade(&scene.geometry),
            clear: (0..shapes).map(|shape| scene.is_clear(shape)).collect(),
        }
    }

    /// Whether they count at the same places as others. No portals are the same in all scenes.
    pub fn are(&self, other: &Self) -> bool {
        let is_same_scene = self.geometry.ptr_eq(&other.geometry) && self.clear == other.clear;
        self.portals == other.portals && (self.portals.is_empty() || is_same_scene)
    }

    /// The table of the lights of `scene`, which is that of [`Self::new`], with these portals.
    pub fn applied_to(&self, table: LightTable, scene: &RenderScene) -> LightTable {
        let is_clear = |shape: usize| self.clear.get(shape) == Some(&true);
        table.with_portals(&self.portals, &scene.geometry, is_clear)
    }
}
