//! Imports files with grids of voxels: each becomes a box with the material `null`, filled with a medium of the grid's
//! density.

use std::path::Path;

use bevy::math::{Affine3A, Vec3};
use bevy::prelude::*;

use super::things::select_new;
use super::world::tell;
use super::{media_boxes, media_upkeep, spot};
use crate::app::editor::camera::rounding;
use crate::app::editor::command::error::CommandError;
use crate::app::editor::session::history::Edit;
use crate::app::editor::session::view_settings::ViewSettings;
use crate::color::Rgb;
use crate::files::{self, Access, FileError};
use crate::medium::vdb::VdbError;
use crate::scene::assets::volume_map::{VolumeMapError, load_volume};
use crate::scene::{Coefficients, GridFile, Medium, PhaseFunction, VolumeFormat, VolumeParameter};

/// The largest `.vol` file that the window waits for, in bytes. The box of a larger one is a cube.
const LARGEST: u64 = 64 << 20;
/// The optical depth through a box whose voxels are all 1: a cloud is visible, and lamps in it are, too.
const DEPTH: f32 = 8.0;

/// Adds a volume file that stands on `foot`; None: in the place of new things. The error names the problem with the
/// file.
pub fn import(edit: &mut Edit, path: &Path, foot: Option<Vec3>) -> Result<(), CommandError> {
    let mut format = VolumeFormat::of_file(path);
    let content = match content_of(&format.asset_path(path)) {
        Err(VolumeMapError::Vdb(VdbError::ManyGrids(names))) => {
            format = first_of(edit, path, &names);
            content_of(&format.asset_path(path))
        }
        content => content,
    };
    let of_file = |reason: &str| CommandError::file(format!("{}: {reason}", path.display()));
    let (sides, world_from_local) = content.map_err(|error| of_file(&error.to_string()))?;
    if !sides.cmpgt(Vec3::ZERO).all() || !world_from_local.inverse().is_finite() {
        return Err(of_file("its grid is flat"));
    }
    let up = edit.world.resource::<ViewSettings>().navigation.up;
    let found = spot::find(edit.world, None, 1.0, false);
    let foot = foot.unwrap_or(found.foot);
    let half = (sides * found.size).map(|half| rounding::with_digits(half, 3));
    let middle = spot::rounded_place(foot + up * ((1.0 - media_boxes::SUNK) * half.dot(up.abs())), found.size);
    let pose = Affine3A::from_translation(middle) * Affine3A::from_scale(half);
    // The sum is short in a file, as its parts are.
    let filling = Affine3A {
        translation: rounding::sum_of_places(middle, -half).into(),
        ..pose * media_upkeep::cube_from_unit()
    };
    let grid = GridFile {
        path: path.to_owned(),
        format,
        to_world: match world_from_local == Affine3A::IDENTITY {
            true => filling,
            false => filling * world_from_local.inverse(),
        },
        ..GridFile::default()
    };
    let medium = Medium {
        coefficients: Coefficients::Extinction {
            sigma_t: VolumeParameter::Grid(grid),
            albedo: Rgb::splat(0.9).into(),
        },
        scale: spot::rounded(0.5 * DEPTH / half.max_element()),
        phase: PhaseFunction::HenyeyGreenstein { g: 0.3 },
        ..Medium::default()
    };
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let name = stem.replace(['.', '$'], "-");
    let name = if name.is_empty() { "volume" } else { &name };
    let cube = media_boxes::bounded(edit, name, pose, medium);
    select_new(edit, vec![cube]);
    Ok(())
}

/// The sides of a grid relative to the longest, and the transform from the unit cube of the grid to the space of its
/// file. Voxels are cubes unless the file says otherwise.
fn content_of(asset: &Path) -> Result<(Vec3, Affine3A), VolumeMapError> {
    let (file, format) = VolumeFormat::of_asset(asset);
    let is_large = matches!(files::check(file, LARGEST), Err(FileError::TooLarge { .. }));
    // The place of a `.vdb` grid is given only by its file.
    if is_large && format == VolumeFormat::Vol {
        return Ok((Vec3::ONE, Affine3A::IDENTITY));
    }
    // The user has chosen the file.
    let map = load_volume(asset, &Access::everywhere())?;
    let voxels = map.grid.resolution().as_vec3();
    let axes = map
        .world_from_local
        .matrix3
        .to_cols_array_2d()
        .map(|axis| Vec3::from_array(axis).length());
    let sides = match map.bounds {
        // Mitsuba's own files give the unit cube, whatever the numbers of their voxels.
        Some(bounds) if bounds.extent() != Vec3::ONE => bounds.extent(),
        _ if map.world_from_local != Affine3A::IDENTITY => Vec3::from_array(axes),
        _ => voxels,
    };
    Ok((sides / sides.max_element(), map.world_from_local))
}

/// The first grid of a `.vdb` file with several, with a message about the others.
fn first_of(edit: &mut Edit, path: &Path, names: &[String]) -> VolumeFormat {
    let grid = names.first().cloned();
    let others: Vec<String> = names.iter().skip(1).map(|name| format!("`{name}`")).collect();
    let file = path.file_name().unwrap_or_default().to_string_lossy();
    let text = format!(
        "{file} has no grid `density`: `{}` is taken. The inspector of the medium can name another: {}.",
        grid.as_deref().unwrap_or_default(),
        others.join(", ")
    );
    tell(edit.world, text);
    VolumeFormat::Vdb { grid }
}
