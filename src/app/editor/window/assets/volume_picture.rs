//! The picture of a file with a grid of voxels: white smoke before a dark wall, seen along z with y upwards.

use std::path::Path;

use bevy::math::{UVec3, Vec3};
use bevy_egui::egui::{Color32, ColorImage};

use super::file_picture::Content;
use crate::color::{luminance, srgb_from_linear};
use crate::files::Access;
use crate::medium::VolumeGrid;
use crate::scene::VolumeFormat;
use crate::scene::assets::volume_map::load_volume;

/// The longer side of the picture in pixels.
const EDGE: f32 = 128.0;
/// The most voxels that are read along a line of sight.
const MOST_BEHIND: u32 = 96;
/// The mean optical depth of the pixels with any density.
const MEAN_DEPTH: f32 = 1.2;
/// The brightness of the wall.
const WALL: f32 = 0.02;

/// Reads a volume file.
pub(super) fn volume(path: &Path, access: &Access) -> Result<Content, String> {
    let map = load_volume(&VolumeFormat::of_file(path).asset_path(path), access).map_err(|error| error.to_string())?;
    let [x, y, z] = map.grid.resolution().to_array();
    Ok(Content {
        image: Some(smoke(&map.grid)),
        note: format!("{x} \u{d7} {y} \u{d7} {z} voxels"),
        ..Content::default()
    })
}

fn smoke(grid: &VolumeGrid) -> ColorImage {
    let size = grid.resolution();
    let across = size.as_vec3().truncate();
    let pixels = (across * (EDGE / across.max_element()))
        .round()
        .as_uvec2()
        .max(bevy::math::UVec2::ONE);
    let behind = size.z.min(MOST_BEHIND);
    let place = |of: u32, count: u32, voxels: u32| {
        let at = (f64::from(of) + 0.5) / f64::from(count) * f64::from(voxels);
        (at as u32).min(voxels - 1)
    };
    let sum = |column: u32, row: u32| {
        let (x, y) = (
            place(column, pixels.x, size.x),
            place(pixels.y - 1 - row, pixels.y, size.y),
        );
        let along = (0..behind).map(|step| grid.voxel(UVec3::new(x, y, place(step, behind, size.z))));
        luminance(along.sum::<Vec3>())
    };
    let sums: Vec<f32> = (0..pixels.y)
        .flat_map(|row| (0..pixels.x).map(move |column| (column, row)))
        .map(|(column, row)| sum(column, row))
        .collect();
    let (total, filled) = sums
        .iter()
        .filter(|sum| **sum > 0.0)
        .fold((0.0, 0.0), |(total, filled), sum| {
            (total + f64::from(*sum), filled + 1.0)
        });
    let mean = if filled > 0.0 { (total / filled) as f32 } else { 1.0 };
    let color = |sum: f32| {
        let passing = (-MEAN_DEPTH * sum / mean).exp();
        let grey = srgb_from_linear(WALL * passing + 0.9 * (1.0 - passing));
        Color32::from_gray((255.0 * grey).round() as u8)
    };
    let colors = sums.into_iter().map(color).collect();
    ColorImage::new([pixels.x as usize, pixels.y as usize], colors)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::medium::Voxels;

    #[test]
    fn dense_places_are_bright_and_y_points_upwards() {
        // Two columns of two voxels, of which only the right upper one has density.
        let voxels = Voxels::F32(vec![0.0, 0.0, 0.0, 1.0]);
        let grid = VolumeGrid::new(UVec3::new(2, 2, 1), 1, voxels).expect("four voxels");
        let image = smoke(&grid);
        assert_eq!(image.size, [128, 128]);
        let at = |x: usize, y: usize| image.pixels[x + 128 * y].r();
        assert!(at(100, 20) > 150 && at(100, 100) < 60 && at(20, 20) < 60);
    }

    #[test]
    fn an_empty_grid_is_dark() {
        let grid = VolumeGrid::new(UVec3::new(1, 3, 2), 1, Voxels::F32(vec![0.0; 6])).expect("six voxels");
        let image = smoke(&grid);
        assert_eq!(image.size, [43, 128]);
        assert!(image.pixels.iter().all(|pixel| pixel.r() < 60));
    }
}
