//! Irradiance volumes: the light from six sides at the points of a grid, for objects that move among them.
//!
//! The six numbers of a point are an ambient cube (Mitchell, McTaggart, Green: Shading in Valve's Source Engine, 2006):
//! irradiance divided by pi on surfaces that face along the axes of the world; other directions are interpolated.

use glam::{Affine3A, UVec2, UVec3, Vec3};

use super::lightmap::Lightmaps;
use super::texels::{Texel, Texels};
use crate::color::Rgb;
use crate::render::irradiance::Receiver;

/// The normals of the six sides.
const SIDES: [Vec3; 6] = [Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::NEG_Y, Vec3::Z, Vec3::NEG_Z];
/// The most points along an axis. GPUs allow 2048 texels along each side of a texture, which has each point three
/// times.
pub(super) const MOST_ALONG: u32 = 512;
/// The most points of a volume.
pub const MOST_POINTS: u32 = 1 << 18;
/// The approximate number of points of a volume without a spacing.
const USUAL_POINTS: f32 = 4096.0;

/// A grid of points in a box: the centres of the equal cells that the box is divided into.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grid {
    /// The transform of the box, a cube from -0.5 to 0.5 in its own space.
    pub world_from_box: Affine3A,
    /// The points along each axis.
    pub points: UVec3,
}

/// The reason why a grid is impossible.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error(
    "a volume may have {MOST_POINTS} points, and {MOST_ALONG} along an axis: at a distance of {spacing} it would have {:.0} x {:.0} x {:.0}",
    points.x, points.y, points.z
)]
pub struct GridError {
    /// The distance between points.
    pub spacing: f32,
    /// The points along each axis.
    pub points: Vec3,
}

impl Grid {
    /// A grid of points about `spacing` apart; None gives about 4096 points.
    pub fn new(world_from_box: Affine3A, spacing: Option<f32>) -> Result<Self, GridError> {
        let axes = world_from_box.matrix3;
        let size = Vec3::new(axes.x_axis.length(), axes.y_axis.length(), axes.z_axis.length());
        let usual = || {
            // Otherwise a flat box would have far more points along its other sides.
            let size = size.max(Vec3::splat(size.max_element() / 64.0));
            (size / USUAL_POINTS.cbrt()).element_product().cbrt()
        };
        let spacing = spacing.unwrap_or_else(usual);
        // Rounding errors just above a whole number do not add a point.
        let points = (size / spacing - 1e-3).ceil().max(Vec3::ONE);
        let is_possible = points.max_element() <= MOST_ALONG as f32 && points.element_product() <= MOST_POINTS as f32;
        match is_possible {
            true => Ok(Self {
                world_from_box,
                points: points.as_uvec3(),
            }),
            false => Err(GridError { spacing, points }),
        }
    }

    /// The positions of the points in the world, first along x, then along y, then along z.
    pub fn places(&self) -> impl Iterator<Item = Vec3> {
        let Self { world_from_box, points } = *self;
        let cells = cells(points).map(move |cell| (cell.as_vec3() + 0.5) / points.as_vec3() - 0.5);
        cells.map(move |place| world_from_box.transform_point3(place))
    }

    /// The texels: the six sides of each point in turn.
    pub fn texels(&self) -> Texels {
        let cells = cells(self.points).zip(self.places());
        let texels: Vec<Texel> = cells
            .flat_map(|(cell, position)| {
                (0..).zip(SIDES).map(move |(side, normal)| Texel {
                    place: UVec2::new(6 * cell.x + side, cell.z * self.points.y + cell.y),
                    receiver: Receiver {
                        position,
                        error: 0.0,
                        normal,
                        geometric_normal: normal,
                    },
                })
            })
            .collect();
        Texels {
            size: UVec2::new(6 * self.points.x, self.points.y * self.points.z),
            pages: std::iter::once(0..texels.len()).collect(),
            texels,
            spreads: Vec::new(),
        }
    }

    /// Whether each point lies inside a solid, see [`Lightmaps::is_buried`].
    pub fn buried(&self, light: &Lightmaps) -> Vec<bool> {
        let count = self.points.element_product() as usize;
        (0..count)
            .map(|point| light.are_buried(6 * point..6 * point + 6))
            .collect()
    }

    /// The texture for Bevy's `IrradianceVolume`, irradiance divided by pi, with its number of texels along each axis.
    /// Points inside a solid have the light of their neighbours.
    ///
    /// `irradiance_volume.wgsl` of Bevy 0.19 reads it in this order: along x the points; along y those for normals with
    /// a positive component, then those for negative ones (the opposite of its documentation); along z those for x, y
    /// and z.
    pub fn texture(&self, light: &Lightmaps) -> (UVec3, Vec<Rgb>) {
        let buried = self.buried(light);
        let own = |point: usize| [0, 1, 2, 3, 4, 5].map(|side| light.light(6 * point + side) / std::f32::consts::PI);
        let mut known: Vec<Option<[Rgb; 6]>> = (0..buried.len())
            .map(|point| (!buried[point]).then(|| own(point)))
            .collect();
        while known.contains(&None) && self.spread(&mut known) {}
        let size = self.points * UVec3::new(1, 2, 3);
        let texels = cells(size).map(|texel| {
            let side = 2 * (texel.z / self.points.z) + texel.y / self.points.y;
            let point = self.index(texel % self.points);
            known[point].map_or(Rgb::ZERO, |sides| sides[side as usize])
        });
        (size, texels.collect())
    }

    fn index(&self, cell: UVec3) -> usize {
        ((cell.z * self.points.y + cell.y) * self.points.x + cell.x) as usize
    }

    /// Gives unknown points the mean of their known neighbours. Returns whether there were any.
    fn spread(&self, known: &mut [Option<[Rgb; 6]>]) -> bool {
        let before = known.to_vec();
        let mut has_changed = false;
        for cell in cells(self.points).filter(|cell| before[self.index(*cell)].is_none()) {
            let (low, high) = (cell.saturating_sub(UVec3::ONE), (cell + 2).min(self.points));
            let around = cells(high - low).filter_map(|offset| before[self.index(low + offset)]);
            let (mut sum, mut count) = ([Rgb::ZERO; 6], 0.0);
            for sides in around {
                sum = std::array::from_fn(|side| sum[side] + sides[side]);
                count += 1.0;
            }
            if count > 0.0 {
                known[self.index(cell)] = Some(sum.map(|light| light / count));
                has_changed = true;
            }
        }
        has_changed
    }
}

/// The cells of a grid, first along x, then along y, then along z.
fn cells(size: UVec3) -> impl Iterator<Item = UVec3> {
    (0..size.z).flat_map(move |z| (0..size.y).flat_map(move |y| (0..size.x).map(move |x| UVec3::new(x, y, z))))
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::bake::lightmap::TexelSum;

    fn boxed(size: Vec3) -> Affine3A {
        Affine3A::from_scale_rotation_translation(size, glam::Quat::IDENTITY, Vec3::new(1.0, 2.0, 3.0))
    }

    #[test]
    fn points_are_the_middles_of_cells() {
        let grid = Grid::new(boxed(Vec3::new(4.0, 1.0, 2.1)), Some(1.0)).expect("a grid");
        assert_eq!(grid.points, UVec3::new(4, 1, 3));
        let places: Vec<Vec3> = grid.places().collect();
        assert!(places[0].abs_diff_eq(Vec3::new(-0.5, 2.0, 2.3), 1e-5));
        assert!(places[1].abs_diff_eq(Vec3::new(0.5, 2.0, 2.3), 1e-5));
        let usual = Grid::new(boxed(Vec3::new(30.0, 3.0, 3.0)), None).expect("a grid");
        assert!(
            (3000..6000).contains(&usual.points.element_product()),
            "{}",
            usual.points
        );
        let flat = Grid::new(boxed(Vec3::new(10.0, 0.0, 10.0)), None).expect("a grid");
        assert!(
            flat.points.y == 1 && flat.points.element_product() < 6000,
            "{}",
            flat.points
        );
        let error = Grid::new(boxed(Vec3::splat(100.0)), Some(0.1)).expect_err("too many");
        assert_eq!(error.points, Vec3::splat(1000.0));
        assert!(Grid::new(boxed(Vec3::splat(100.0)), Some(1e-30)).is_err());
    }

    #[test]
    fn texels_lie_where_the_shader_looks_and_buried_points_have_the_light_around() {
        let grid = Grid::new(boxed(Vec3::new(3.0, 1.0, 1.0)), Some(1.0)).expect("a grid");
        let mut light = Lightmaps::new(18);
        light.ends = vec![2];
        for (index, sum) in light.groups[0].iter_mut().enumerate() {
            // The point in the middle sees only backs.
            *sum = match index / 6 {
                1 => TexelSum {
                    backs: 2,
                    ..TexelSum::default()
                },
                _ => TexelSum {
                    light: DVec3::splat(2.0 * std::f64::consts::PI * (1 + index) as f64),
                    ..TexelSum::default()
                },
            };
        }
        let (size, texels) = grid.texture(&light);
        assert_eq!(size, UVec3::new(3, 2, 3));
        let red: Vec<f32> = texels.iter().map(|texel| texel.x.round()).collect();
        let rows: Vec<&[f32]> = red.chunks(3).collect();
        assert_eq!(rows[0], [1.0, 7.0, 13.0], "+x");
        assert_eq!(rows[1], [2.0, 8.0, 14.0], "-x");
        assert_eq!(rows[2], [3.0, 9.0, 15.0], "+y");
        assert_eq!(rows[5], [6.0, 12.0, 18.0], "-z");
    }
}
