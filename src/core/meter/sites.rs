//! The places at which a meter measures.

use glam::{Affine3A, UVec2, Vec2, Vec3};

use crate::accel::Detail;
use crate::bake::texels::{Texel, Texels};
use crate::math::Ray;
use crate::render::irradiance::{ImmersedReceiver, Receiver};
use crate::render::scene::RenderScene;
use crate::render::view::View;

/// The most points of a grid.
pub const MOST_POINTS: u32 = 1 << 14;
/// The most points of all meters of a scene.
pub const MOST_POINTS_OF_SCENE: usize = 1 << 16;

/// The pixels between the points in the sequence of random numbers: points nearer than this would share numbers.
const APART: u32 = 16;
/// The rounding error of positions relative to their coordinates, as that of texels.
const ROUNDING: f32 = 32.0 * f32::EPSILON;

/// What a meter measures, and the values that it asks for.
#[derive(Clone, Debug, PartialEq)]
pub struct AskedMeter {
    /// The name in reports.
    pub name: String,
    /// The transform. The light that arrives on the side of +z counts.
    pub world_from_meter: Affine3A,
    /// A point or a grid.
    pub kind: MeterKind,
    /// The values that pass.
    pub limits: MeterLimits,
}

/// The shape of a meter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum MeterKind {
    /// The origin.
    Point,
    /// The square from -1 to 1 along x and y, with points at most `spacing` apart in the world; above 0.
    Grid {
        /// The largest distance between neighbouring points, in units of the world.
        spacing: f32,
    },
}

/// The values that a meter has to have; None asks for nothing.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MeterLimits {
    /// The least illuminance in lux.
    pub least: Option<f64>,
    /// The mean illuminance of a grid in lux.
    pub mean: Option<f64>,
    /// The ratio of the least to the mean illuminance of a grid.
    pub uniformity: Option<f64>,
}

/// The reason why a meter cannot measure.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[allow(missing_docs, reason = "the messages say what the variants mean")]
pub enum SitesError {
    #[error("its place is not finite")]
    NotFinite,
    #[error("it faces no direction: its size is 0")]
    Flat,
    #[error("a grid may have {MOST_POINTS} points: at a spacing of {spacing} it would have {:.0} x {:.0}", points[0], points[1])]
    TooManyPoints { spacing: f32, points: [f32; 2] },
}

/// The points of a meter.
#[derive(Clone, Debug, PartialEq)]
pub struct Sites {
    /// Columns along x and rows along y; 1 of each for a point.
    pub size: UVec2,
    /// The points, row by row.
    pub texels: Texels<ImmersedReceiver>,
}

impl AskedMeter {
    /// The points.
    pub fn sites(&self) -> Result<Sites, SitesError> {
        let place = &self.world_from_meter;
        if !place.is_finite() {
            return Err(SitesError::NotFinite);
        }
        let [x, y, z]: [Vec3; 3] = [place.matrix3.x_axis, place.matrix3.y_axis, place.matrix3.z_axis].map(Vec3::from);
        let normal = match self.kind {
            MeterKind::Point => z,
            // As of a rectangle, whose normal is on the side of +z under mirroring as well.
            MeterKind::Grid { .. } if x.cross(y).dot(z) < 0.0 => y.cross(x),
            MeterKind::Grid { .. } => x.cross(y),
        };
        let normal = normal.try_normalize().ok_or(SitesError::Flat)?;
        let size = match self.kind {
            MeterKind::Point => UVec2::ONE,
            MeterKind::Grid { spacing } => grid_size([2.0 * x.length(), 2.0 * y.length()], spacing)?,
        };
        let cells = (0..size.y).flat_map(|row| (0..size.x).map(move |column| UVec2::new(column, row)));
        let texels: Vec<Texel<ImmersedReceiver>> = cells
            .map(|cell| {
                let middle = 2.0 * (cell.as_vec2() + 0.5) / size.as_vec2() - 1.0;
                let position = place.transform_point3(middle.extend(0.0));
                let receiver = Receiver {
                    position,
                    error: ROUNDING * position.abs().max_element(),
                    normal,
                    geometric_normal: normal,
                };
                Texel {
                    place: APART * cell,
                    receiver: ImmersedReceiver { receiver, medium: None },
                }
            })
            .collect();
        let texels = Texels {
            size: APART * size,
            pages: std::iter::once(0..texels.len()).collect(),
            texels,
            spreads: Vec::new(),
        };
        Ok(Sites { size, texels })
    }
}

impl Sites {
    /// Lets rays of points that lie in a surface of the scene, up to rounding, begin above it: the rounding of a
    /// surface goes with its own size and place, and a point may be just below it. Then finds the medium that each
    /// point is in, from the camera of `view` on, whose medium is known.
    pub fn settle(&mut self, scene: &RenderScene, view: &View) {
        let geometry = &scene.geometry;
        let middle = || view.camera.ray(Vec2::splat(0.5), Vec2::splat(0.5)).origin;
        let eye = view.camera.eye().unwrap_or_else(middle);
        let bounds = geometry.bounds();
        let extent = bounds.min.abs().max(bounds.max.abs()).max_element();
        for texel in &mut self.texels.texels {
            let receiver = &mut texel.receiver.receiver;
            let slack = 2.0 * ROUNDING * receiver.position.abs().max_element().max(extent);
            if !(slack > 0.0 && slack.is_finite()) {
                continue;
            }
            let ray = Ray {
                t_max: 2.0 * slack,
                ..Ray::new(receiver.position + slack * receiver.normal, -receiver.normal)
            };
            if let Some(hit) = geometry.intersect(&ray) {
                let surface = geometry.surface_in(&ray, &hit, Detail::Plain);
                let off = surface.position.distance(receiver.position);
                receiver.error = receiver.error.max(surface.error + off);
            }
            texel.receiver = ImmersedReceiver::seen_from(*receiver, scene, eye, view.medium);
        }
    }

    /// The positions in the world, row by row.
    pub fn positions(&self) -> impl Iterator<Item = Vec3> {
        self.texels.texels.iter().map(|texel| texel.receiver.receiver.position)
    }
}

/// The columns and rows of a grid of this size.
fn grid_size(size: [f32; 2], spacing: f32) -> Result<UVec2, SitesError> {
    // Rounding errors just above a whole number do not add a point.
    let points = match spacing > 0.0 {
        true => size.map(|side| (side / spacing - 1e-3).ceil().max(1.0)),
        false => [f32::INFINITY; 2],
    };
    let is_possible = points[0] * points[1] <= MOST_POINTS as f32;
    match is_possible {
        true => Ok(UVec2::new(points[0] as u32, points[1] as u32)),
        false => Err(SitesError::TooManyPoints { spacing, points }),
    }
}

#[cfg(test)]
mod tests {
    use glam::Quat;

    use super::*;

    fn meter(kind: MeterKind, world_from_meter: Affine3A) -> AskedMeter {
        AskedMeter {
            name: "it".to_owned(),
            world_from_meter,
            kind,
            limits: MeterLimits::default(),
        }
    }

    #[test]
    fn points_are_the_middles_of_cells_and_face_along_z() {
        let flat = Quat::from_rotation_x(-std::f32::consts::FRAC_PI_2);
        let desk = Affine3A::from_scale_rotation_translation(Vec3::new(1.0, 0.5, 1.0), flat, Vec3::Y);
        let sites = meter(MeterKind::Grid { spacing: 0.5 }, desk).sites().expect("points");
        assert_eq!(sites.size, UVec2::new(4, 2));
        let positions: Vec<Vec3> = sites.positions().collect();
        assert!(
            positions[0].abs_diff_eq(Vec3::new(-0.75, 1.0, 0.25), 1e-6),
            "{positions:?}"
        );
        assert!(
            positions[7].abs_diff_eq(Vec3::new(0.75, 1.0, -0.25), 1e-6),
            "{positions:?}"
        );
        let mirrored = desk * Affine3A::from_scale(Vec3::new(-1.0, 1.0, 1.0));
        let unmirrored = meter(MeterKind::Point, desk).sites().expect("a point");
        for sites in [
            sites,
            meter(MeterKind::Grid { spacing: 0.5 }, mirrored)
                .sites()
                .expect("points"),
            unmirrored,
        ] {
            let receivers = sites.texels.texels.iter().map(|texel| texel.receiver.receiver.normal);
            receivers.for_each(|normal| assert!(normal.abs_diff_eq(Vec3::Y, 1e-6), "{normal}"));
        }
    }

    #[test]
    fn impossible_meters_are_refused() {
        let fault = |kind, place| meter(kind, place).sites().expect_err("impossible");
        let huge = Affine3A::from_scale(Vec3::splat(1000.0));
        let grid = MeterKind::Grid { spacing: 0.1 };
        assert_eq!(
            fault(grid, huge).to_string(),
            "a grid may have 16384 points: at a spacing of 0.1 it would have 20000 x 20000"
        );
        assert!(matches!(
            fault(MeterKind::Grid { spacing: 0.0 }, huge),
            SitesError::TooManyPoints { .. }
        ));
        assert!(matches!(
            fault(MeterKind::Grid { spacing: f32::NAN }, huge),
            SitesError::TooManyPoints { .. }
        ));
        assert_eq!(fault(grid, Affine3A::from_scale(Vec3::ZERO)), SitesError::Flat);
        assert_eq!(
            fault(MeterKind::Point, Affine3A::from_scale(Vec3::ZERO)),
            SitesError::Flat
        );
        let lost = Affine3A::from_translation(Vec3::NAN);
        assert_eq!(fault(MeterKind::Point, lost), SitesError::NotFinite);
    }
}
