//! The placement of probes: boxes around the parts of a level that they serve.

use std::sync::atomic::AtomicBool;

use glam::{Affine3A, Mat3A, Vec3};

use super::cube::windows;
use super::lightmap::Lightmaps;
use super::volume::Grid;
use crate::math::{Aabb, Ray};
use crate::render::gathering::Gathering;
use crate::render::scene::RenderScene;

/// The smallest side of a box around a level, as a share of its longest side.
const THINNEST: f32 = 1.0 / 64.0;
/// The positions tried along each axis for the centre of a reflection probe, with this number of samples.
const TRIALS: u32 = 9;
const SAMPLES: u32 = 16;
/// A point is in a room if more than this share of the directions around it meet surfaces, tested with a picture of
/// this size. Above a floor under the sky the share is one half.
const ENCLOSED: f32 = 2.0 / 3.0;
const OUTLOOK: u32 = 16;
/// The largest cosine between two axes of a box that still count as perpendicular.
const CROOKED: f32 = 1e-3;

/// The reason why a probe cannot be where it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[allow(missing_docs, reason = "the messages say what the variants mean")]
pub enum PlacementError {
    #[error("its box has no volume")]
    Flat,
    #[error("its box is skewed: game engines have boxes with right angles")]
    Skewed,
    #[error("it lies outside of the level")]
    Outside,
    #[error(
        "its middle lies inside of something: most of what it sees are the backs of surfaces, and no light comes there"
    )]
    Buried,
}

/// The box around a whole level, as the transform of a cube from -0.5 to 0.5; None if the level is empty or infinite.
pub fn around(bounds: &Aabb) -> Option<Affine3A> {
    let extent = bounds.extent();
    let is_there = !bounds.is_empty() && extent.is_finite() && extent != Vec3::ZERO;
    is_there.then(|| {
        let size = extent.max(Vec3::splat(THINNEST * extent.max_element()));
        Affine3A::from_mat3_translation(Mat3A::from_diagonal(size).into(), bounds.center())
    })
}

/// The box for a reflection probe of a whole level. Its centre is the point nearest to the middle of the level that is
/// not inside a solid; the box is enlarged if that is not the middle itself. None if there is no such point, or if
/// `cancel` was set.
pub fn seeing(gathering: &Gathering, world_from_level: &Affine3A, cancel: &AtomicBool) -> Option<Affine3A> {
    let grid = Grid {
        world_from_box: *world_from_level,
        points: glam::UVec3::splat(TRIALS),
    };
    let buried = buried(gathering, &grid, cancel)?;
    let size = Vec3::new(
        world_from_level.x_axis.length(),
        world_from_level.y_axis.length(),
        world_from_level.z_axis.length(),
    );
    let middle = Vec3::from(world_from_level.translation);
    let open = grid.places().zip(buried).filter(|(_, is_buried)| !is_buried);
    let distance = |place: &Vec3| (*place - middle).length_squared();
    let (place, _) = open.min_by(|(a, _), (b, _)| distance(a).total_cmp(&distance(b)))?;
    let scale = Mat3A::from_diagonal(size + 2.0 * (place - middle).abs());
    Some(Affine3A::from_mat3_translation(scale.into(), place))
}

/// Whether most directions from the centre of a box meet surfaces, as in a room. Otherwise they meet the sky, which
/// does not lie on the sides of a box.
pub fn is_enclosed(scene: &RenderScene, world_from_box: &Affine3A) -> bool {
    let windows = windows(world_from_box.translation.into(), &world_from_box.matrix3, OUTLOOK).texels;
    let (mut met, mut whole) = (0.0, 0.0);
    for window in windows.iter().map(|texel| texel.receiver) {
        let ray = Ray::new(window.from, window.middle().normalize());
        whole += window.solid_angle();
        met += if scene.geometry.occluded(&ray) {
            window.solid_angle()
        } else {
            0.0
        };
    }
    met > ENCLOSED * whole
}

/// A side of a box that is shorter, absolutely or as a share of the longest one, counts as zero.
const SHORTEST: f32 = 1e-6;

/// Whether a probe may have this box, given as the transform of a cube from -0.5 to 0.5.
pub fn check(world_from_box: &Affine3A, level: &Aabb) -> Result<(), PlacementError> {
    let axes = [world_from_box.x_axis, world_from_box.y_axis, world_from_box.z_axis];
    let lengths = axes.map(|axis| axis.length());
    let longest = lengths.into_iter().fold(f32::MIN_POSITIVE, f32::max);
    if !world_from_box.is_finite() || lengths.iter().any(|length| *length < SHORTEST * longest.max(SHORTEST)) {
        return Err(PlacementError::Flat);
    }
    let [x, y, z] = axes.map(|axis| axis.normalize());
    let cosines = [x.dot(y), y.dot(z), z.dot(x)].map(f32::abs);
    if cosines.into_iter().any(|cosine| cosine > CROOKED) {
        return Err(PlacementError::Skewed);
    }
    let middle = Vec3::from(world_from_box.translation);
    let reach: Vec3 = axes.iter().map(|axis| Vec3::from(0.5 * axis.abs())).sum();
    let meets_level = (middle + reach).cmpge(level.min).all() && (middle - reach).cmple(level.max).all();
    match meets_level {
        true => Ok(()),
        false => Err(PlacementError::Outside),
    }
}

/// Whether a reflection probe sees anything from the centre of its box. If `cancel` was set, it may wrongly say yes.
pub fn check_sight(
    gathering: &Gathering,
    world_from_box: &Affine3A,
    cancel: &AtomicBool,
) -> Result<(), PlacementError> {
    let grid = Grid {
        world_from_box: *world_from_box,
        points: glam::UVec3::ONE,
    };
    match buried(gathering, &grid, cancel).is_some_and(|buried| buried.contains(&true)) {
        true => Err(PlacementError::Buried),
        false => Ok(()),
    }
}

/// For each point of the grid whether it is inside a solid; None if `cancel` was set.
fn buried(gathering: &Gathering, grid: &Grid, cancel: &AtomicBool) -> Option<Vec<bool>> {
    let texels = grid.texels();
    let mut light = Lightmaps::new(texels.texels.len());
    light
        .add(gathering, &texels, SAMPLES, cancel)
        .then(|| grid.buried(&light))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_box_around_a_floor_has_a_height() {
        let floor = Aabb::from_points([Vec3::ZERO, Vec3::new(8.0, 0.0, 4.0)]);
        let place = around(&floor).expect("a box");
        assert_eq!(place.transform_point3(Vec3::splat(0.5)), Vec3::new(8.0, 0.0625, 4.0));
        assert_eq!(around(&Aabb::EMPTY), None);
        assert_eq!(around(&Aabb::from_points([Vec3::ONE])), None);
        assert_eq!(around(&Aabb::from_points([Vec3::ZERO, Vec3::INFINITY])), None);
    }

    #[test]
    fn boxes_that_no_engine_has_are_refused() {
        let level = Aabb::from_points([Vec3::ZERO, Vec3::splat(4.0)]);
        let at = |scale: Vec3, place: Vec3| {
            Affine3A::from_scale_rotation_translation(scale, glam::Quat::from_rotation_y(0.3), place)
        };
        assert_eq!(check(&at(Vec3::new(1.0, 2.0, 3.0), Vec3::ONE), &level), Ok(()));
        let flat = at(Vec3::new(1.0, 0.0, 3.0), Vec3::ONE);
        assert_eq!(check(&flat, &level), Err(PlacementError::Flat));
        assert_eq!(
            check(&at(Vec3::ONE, Vec3::splat(5.0)), &level),
            Err(PlacementError::Outside)
        );
        let skewed = Affine3A::from_scale(Vec3::new(2.0, 1.0, 1.0)) * at(Vec3::ONE, Vec3::ZERO);
        assert_eq!(check(&skewed, &level), Err(PlacementError::Skewed));
        assert_eq!(check(&at(Vec3::NAN, Vec3::ONE), &level), Err(PlacementError::Flat));
    }
}
