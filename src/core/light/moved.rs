//! Lights after a rigid motion.

use glam::{Affine3A, Mat3, Vec3};

use super::LightSource;

impl LightSource {
    /// The light after a rigid motion of the world. None for a light that has no place and no direction of its own, and
    /// for a surface, which moves with its shape.
    pub fn moved(&self, by: Affine3A) -> Option<Self> {
        let turn = Mat3::from(by.matrix3);
        let place = |place: Vec3| by.transform_point3(place);
        let mut moved = self.clone();
        match &mut moved {
            Self::Point { position, .. } => *position = place(*position),
            Self::Directional { direction, .. } => *direction = (turn * *direction).normalize(),
            Self::Spot(spot) => spot.world_from_local = by * spot.world_from_local,
            Self::Projector(projector) => projector.world_from_local = by * projector.world_from_local,
            Self::Luminaire(lamp) => {
                lamp.position = place(lamp.position);
                lamp.world_from_local = turn * lamp.world_from_local;
            }
            Self::Surface { .. } | Self::Constant { .. } | Self::Environment { .. } | Self::SunSky { .. } => {
                return None;
            }
        }
        Some(moved)
    }
}
