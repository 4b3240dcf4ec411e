//! A second set of texture coordinates for meshes, in which no two points of their surfaces share a texel.
//!
//! The crate `uvunwrap` cuts meshes into charts, flattens these and packs them, with the same bits on any number of
//! threads. This module sets the limits of an atlas, and handles meshes that have no surface, are broken, or are large.

mod error;
mod input;
mod mesh;

use std::sync::atomic::{AtomicBool, Ordering};

use glam::{UVec2, Vec2};
use uvunwrap::{Density, MeshInput, Options, Packing, Stage};

pub use self::error::UnwrapError;
pub use self::mesh::{Told, UnwrapMesh};

use self::error::MOST_TEXELS;
use self::input::Input;
use super::lightmap::TexelSum;
use super::spread::Spread;
use super::texels::Texel;
use crate::memory::{self, Reservation};

/// The allowed sizes of lightmaps, in texels.
pub const ATLAS_SIZES: std::ops::RangeInclusive<u32> = 16..=16384;

/// The size of lightmaps and of their texels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UnwrapSettings {
    /// The width of a lightmap, and its largest height, in texels; in [`ATLAS_SIZES`].
    pub atlas_size: u32,
    /// Texels per unit of length, above 0; None fills one lightmap. If not all pieces of the level fit in one, however
    /// small they are, there are several.
    pub texels_per_unit: Option<f32>,
    /// The least distance between two charts, in texels.
    pub padding: u32,
}

impl Default for UnwrapSettings {
    fn default() -> Self {
        Self {
            atlas_size: 1024,
            texels_per_unit: None,
            padding: 2,
        }
    }
}

/// The layout of all meshes.
#[derive(Debug)]
pub struct Layout {
    /// Width and height of each lightmap. A single lightmap is only as high as needed.
    pub size: UVec2,
    /// The number of lightmaps.
    pub pages: u32,
    /// Texels per unit of length.
    pub texels_per_unit: f32,
    /// The meshes in the order in which they were given.
    pub meshes: Vec<LayoutMesh>,
    /// The memory reserved for the light of all texels.
    pub memory: Reservation,
}

/// A mesh with its lightmap coordinates.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LayoutMesh {
    /// The original vertex of each vertex. Vertices at seams are duplicated.
    pub vertices: Vec<u32>,
    /// The coordinates of each vertex within the mesh's rectangle, in [0, 1].
    pub coordinates: Vec<Vec2>,
    /// The triangles in the order in which they were given.
    pub triangles: Vec<[u32; 3]>,
    /// The rectangles, one for each instance of the mesh.
    pub rectangles: Vec<LayoutRectangle>,
}

/// The rectangle of a lightmap that an instance of a mesh covers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LayoutRectangle {
    /// The index of the lightmap.
    pub page: u32,
    /// The upper left corner, in [0, 1].
    pub min: Vec2,
    /// The lower right corner, in [0, 1].
    pub max: Vec2,
}

/// Bytes per texel of a lightmap while it is made: the texel with its receiver and without, the area of its samples,
/// its sums, and the pictures.
pub(super) const TEXEL_BYTES: u64 = {
    let gathered = size_of::<Texel>() + size_of::<Texel<()>>() + size_of::<Spread>() + size_of::<TexelSum>();
    gathered as u64 + PICTURE_BYTES
};
/// Bytes per texel of the pictures made of a lightmap, with those that are denoised. The search for texels, which comes
/// before, takes less.
const PICTURE_BYTES: u64 = 128;
const _: () = assert!(TEXEL_BYTES == 264, "docs/baking.md says what a texel takes");
/// Lays meshes out in lightmaps. Each has a surface ([`UnwrapMesh::has_surface`]). It ends soon after `cancel` is set:
/// at the end of a piece of a few thousand triangles, of the search for the neighbours of all triangles of a mesh, or
/// of an attempt to pack all charts.
pub fn unwrap(
    meshes: &[UnwrapMesh],
    settings: &UnwrapSettings,
    cancel: &AtomicBool,
    told: Told,
) -> Result<Layout, UnwrapError> {
    let UnwrapSettings {
        atlas_size,
        texels_per_unit,
        padding,
    } = *settings;
    if !ATLAS_SIZES.contains(&atlas_size) {
        return Err(UnwrapError::AtlasSize(atlas_size));
    }
    if let Some(density) = texels_per_unit.filter(|density| !(*density > 0.0 && density.is_finite())) {
        return Err(UnwrapError::TexelsPerUnit(density));
    }
    for mesh in meshes {
        if !mesh.positions.iter().all(|place| place.is_finite()) {
            return Err(UnwrapError::Broken(mesh.name.clone()));
        }
    }
    let area: f64 = meshes.iter().map(UnwrapMesh::area).sum();
    if area.is_nan() || area <= 0.0 {
        return Err(UnwrapError::Nothing);
    }
    if let Some(flat) = meshes.iter().find(|mesh| !mesh.has_surface()) {
        return Err(UnwrapError::Flat(flat.name.clone()));
    }
    let page = f64::from(atlas_size).powi(2);
    let needed = texels_per_unit.map_or(page, |density| area * f64::from(density).powi(2));
    if needed > MOST_TEXELS {
        return Err(too_many(needed, meshes));
    }
    // The lower bound of the memory, reserved before the work begins.
    let mut reserved = memory::reserve(TEXEL_BYTES * needed as u64)?;
    let (inputs, cut) = Input::all(meshes, cancel, told)?;
    let borrowed: Vec<MeshInput> = inputs.iter().map(Input::borrow).collect();
    let options = Options {
        density: match texels_per_unit {
            Some(texels_per_unit) => Density::Fixed {
                texels_per_unit,
                page_size: Some(atlas_size),
            },
            None => Density::Auto { page_size: atlas_size },
        },
        padding,
        packing: match meshes.iter().any(UnwrapMesh::is_large) {
            // The time of the other packer grows faster than the number of charts.
            true => Packing::Fast,
            false => Packing::Shape,
        },
        ..Options::default()
    };
    let generate = |inputs: &[MeshInput]| {
        uvunwrap::generate_with_progress(inputs, &options, |now| {
            let (done, words) = step(&now);
            told(cut + (1.0 - cut) * done, words);
            !cancel.load(Ordering::Relaxed)
        })
    };
    let atlas = generate(&borrowed).map_err(|error| match error {
        uvunwrap::Error::Cancelled => UnwrapError::Cancelled,
        uvunwrap::Error::ChartTooLarge { .. } => {
            let alone = |mesh: usize| generate(&borrowed[mesh..=mesh]).err();
            too_large(meshes, settings, alone)
        }
        uvunwrap::Error::AtlasTooLarge { texels } => too_many(texels as f64, meshes),
        other => UnwrapError::Other(other.to_string()),
    })?;
    let mut meshes: Vec<LayoutMesh> = atlas
        .meshes
        .into_iter()
        .zip(&inputs)
        .map(|(mesh, input)| LayoutMesh::of(mesh, input))
        .collect();
    let mut size = UVec2::new(atlas.width, atlas.height);
    if atlas.page_count == 1 {
        size.y = crop(&mut meshes, size.y);
    }
    let texels = u64::from(size.x) * u64::from(size.y) * u64::from(atlas.page_count);
    reserved.resize(TEXEL_BYTES * texels)?;
    Ok(Layout {
        size,
        pages: atlas.page_count,
        texels_per_unit: atlas.texels_per_unit,
        meshes,
        memory: reserved,
    })
}

/// The finished share of the crate's work, and the name of the present step.
fn step(now: &uvunwrap::Progress) -> (f64, &'static str) {
    let part = now.total.map_or(0.0, |total| now.done as f64 / total.max(1) as f64);
    match now.stage {
        Stage::Segmenting => (0.1 * part, "unwrapping the level"),
        Stage::Parameterizing => (0.1 + 0.6 * part, "unwrapping the level"),
        // Packing takes one attempt or a dozen.
        Stage::Packing => (1.0 - 0.3 * 0.85f64.powi(now.done as i32), "placing the charts"),
        _ => (1.0, "placing the charts"),
    }
}

/// The error that the level needs `texels` texels.
fn too_many(texels: f64, meshes: &[UnwrapMesh]) -> UnwrapError {
    let largest = meshes.iter().max_by(|a, b| a.area().total_cmp(&b.area()));
    UnwrapError::TooMany {
        texels,
        largest: largest.map_or(String::new(), |mesh| mesh.name.clone()),
    }
}

/// The error about a mesh that does not fit in a lightmap. The crate does not say which it is, so each is tried alone,
/// the one with the largest extent first: `alone` gives the error of a mesh.
fn too_large(
    meshes: &[UnwrapMesh],
    settings: &UnwrapSettings,
    alone: impl Fn(usize) -> Option<uvunwrap::Error>,
) -> UnwrapError {
    let mut order: Vec<(f64, usize)> = meshes.iter().map(UnwrapMesh::extent).zip(0..).collect();
    order.sort_by(|(a, _), (b, _)| b.total_cmp(a));
    let error = order.into_iter().find_map(|(_, index)| Some((index, alone(index)?)));
    let (index, width, height) = match error {
        Some((index, uvunwrap::Error::ChartTooLarge { width, height, .. })) => (index, width, height),
        Some((_, uvunwrap::Error::Cancelled)) => return UnwrapError::Cancelled,
        Some((index, error)) => return UnwrapError::Other(format!("`{}`: {error}", meshes[index].name)),
        None => return UnwrapError::Other("one of them has no room in a lightmap; take larger lightmaps".to_owned()),
    };
    let (name, size) = (meshes[index].name.clone(), settings.atlas_size);
    let Some(texels_per_unit) = settings.texels_per_unit else {
        return UnwrapError::TooManyPieces { name, size };
    };
    let [room, needed] = [size, width.max(height)].map(|texels| texels.saturating_sub(2 * settings.padding) as f32);
    UnwrapError::TooLarge {
        name,
        width,
        height,
        size,
        texels_per_unit: two_digits(texels_per_unit * room / needed.max(1.0)),
    }
}

/// `number` rounded down to two digits.
fn two_digits(number: f32) -> f32 {
    let step = 10f64.powf((f64::from(number).log10() - 1.0).floor());
    ((f64::from(number) / step).floor() * step) as f32
}

/// Crops the rows of a page below all rectangles, and returns its new height.
fn crop(meshes: &mut [LayoutMesh], height: u32) -> u32 {
    let rectangles = || meshes.iter().flat_map(|mesh| &mesh.rectangles);
    let lowest = rectangles().map(|rectangle| rectangle.max.y).fold(0.0, f32::max);
    let kept = ((lowest * height as f32).ceil() as u32).clamp(1, height);
    let factor = height as f32 / kept as f32;
    for rectangle in meshes.iter_mut().flat_map(|mesh| &mut mesh.rectangles) {
        rectangle.min.y *= factor;
        rectangle.max.y = (rectangle.max.y * factor).min(1.0);
    }
    kept
}

impl LayoutMesh {
    fn of(mesh: uvunwrap::OutputMesh, input: &Input) -> Self {
        let (triangles, _) = mesh.indices.as_chunks::<3>();
        let vertices = mesh.vertices.iter();
        Self {
            vertices: vertices.map(|vertex| input.vertex_of_mesh(vertex.xref)).collect(),
            coordinates: mesh.vertices.iter().map(|vertex| Vec2::from(vertex.uv)).collect(),
            triangles: triangles.to_vec(),
            rectangles: mesh
                .instances
                .iter()
                .map(|place| LayoutRectangle {
                    page: place.page,
                    min: place.min.into(),
                    max: place.max.into(),
                })
                .collect(),
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;

    fn unwrap(meshes: &[UnwrapMesh], settings: &UnwrapSettings) -> Result<Layout, UnwrapError> {
        super::unwrap(meshes, settings, &AtomicBool::new(false), &|_, _| {})
    }

    fn square(size: f32) -> UnwrapMesh {
        let corners = [(0.0, 0.0), (size, 0.0), (size, size), (0.0, size)];
        UnwrapMesh {
            name: "square".to_owned(),
            positions: corners.map(|(x, y)| Vec3::new(x, y, 0.0)).to_vec(),
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            part_of_triangle: vec![0, 0],
            places: 1,
        }
    }

    fn with_density(texels_per_unit: f32) -> UnwrapSettings {
        UnwrapSettings {
            texels_per_unit: Some(texels_per_unit),
            atlas_size: 256,
            ..UnwrapSettings::default()
        }
    }

    #[test]
    fn texels_have_the_size_that_was_asked_for() {
        let mesh = UnwrapMesh {
            places: 3,
            ..square(5.0)
        };
        let layout = unwrap(&[mesh], &with_density(20.0)).expect("it fits");
        let [mesh] = &layout.meshes[..] else { panic!("one mesh") };
        assert_eq!(mesh.rectangles.len(), 3);
        for place in &mesh.rectangles {
            let extent = (place.max - place.min) * layout.size.as_vec2();
            let at = |corner: u32| mesh.coordinates[corner as usize] * extent;
            let [a, b, _] = mesh.triangles[0];
            assert!((at(a).distance(at(b)) / 5.0 - 20.0).abs() < 0.5, "{extent}");
        }
    }

    #[test]
    fn what_cannot_be_laid_out_is_said() {
        let error = |meshes: &[UnwrapMesh], settings: UnwrapSettings| {
            unwrap(meshes, &settings).map(drop).expect_err("no layout")
        };
        assert_eq!(error(&[], with_density(1.0)), UnwrapError::Nothing);
        assert_eq!(error(&[square(0.0)], with_density(1.0)), UnwrapError::Nothing);
        assert_eq!(
            error(&[square(1.0)], with_density(0.0)),
            UnwrapError::TexelsPerUnit(0.0)
        );
        assert_eq!(
            error(&[square(1.0)], with_density(f32::INFINITY)),
            UnwrapError::TexelsPerUnit(f32::INFINITY)
        );
        let size = |atlas_size| UnwrapSettings {
            atlas_size,
            ..UnwrapSettings::default()
        };
        assert_eq!(error(&[square(1.0)], size(4)), UnwrapError::AtlasSize(4));
        let named = |name: &str, size: f32| UnwrapMesh {
            name: name.to_owned(),
            ..square(size)
        };
        let meshes = [named("small", 1.0), named("large", 100.0), named("middle", 2.0)];
        let too_large = error(&meshes, with_density(20.0));
        let UnwrapError::TooLarge {
            name,
            size: 256,
            texels_per_unit,
            ..
        } = too_large
        else {
            panic!("{too_large}")
        };
        assert_eq!(name, "large");
        unwrap(&meshes, &with_density(texels_per_unit)).expect("the error says with what it has room");
        assert_eq!(texels_per_unit, 2.5);
        let too_many = error(&[named("small", 1.0), named("large", 1e6)], with_density(1.0));
        let UnwrapError::TooMany { largest, .. } = &too_many else {
            panic!("{too_many}")
        };
        assert_eq!(largest, "large");
        let sides = 1e6_f64.powi(2) + 1.0;
        assert!(
            too_many
                .to_string()
                .starts_with(&format!("the level needs {sides} texels, ")),
            "{too_many}"
        );
        let beyond = error(&[named("large", 1e6)], with_density(1e9)).to_string();
        assert!(beyond.starts_with("the level needs about 1.0e30 texels, "), "{beyond}");
        let mut broken = square(1.0);
        broken.positions[2].x = f32::NAN;
        assert_eq!(
            error(&[broken], with_density(1.0)),
            UnwrapError::Broken("square".to_owned())
        );
    }

    #[test]
    fn degenerate_and_overlapping_triangles_are_laid_out_with_the_rest() {
        let mut mesh = square(2.0);
        mesh.triangles.extend([[0, 1, 2], [0, 0, 1], [2, 1, 0], [1, 1, 1]]);
        mesh.part_of_triangle = vec![0; 6];
        let layout = unwrap(&[mesh], &with_density(8.0)).expect("a layout");
        assert_eq!(layout.meshes[0].triangles.len(), 6);
        let inside = |at: &Vec2| at.cmpge(Vec2::ZERO).all() && at.cmple(Vec2::ONE).all();
        assert!(layout.meshes[0].coordinates.iter().all(inside));
    }

    #[test]
    fn a_mesh_of_needles_has_no_surface() {
        let mut needle = square(1.0);
        needle.triangles = vec![[0, 1, 2], [0, 1, 1]];
        needle.part_of_triangle = vec![0, 0];
        for (height, has_surface) in [(1e-3, true), (1e-5, true), (1e-8, false), (0.0, false)] {
            needle.positions[2] = Vec3::new(0.5, height, 0.0);
            // The crate agrees with `has_surface`.
            assert_eq!(needle.has_surface(), has_surface, "{height}");
            let layout = unwrap(&[square(1.0), needle.clone()], &with_density(8.0));
            assert_eq!(layout.is_ok(), has_surface, "{height}");
        }
    }

    #[test]
    fn more_pieces_than_a_lightmap_has_room_for_are_refused() {
        let mut mesh = UnwrapMesh {
            places: 1,
            ..square(1.0)
        };
        for number in 1..200 {
            let first = mesh.positions.len() as u32;
            let corners = [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0)];
            let corners = corners.map(|(x, y)| Vec3::new(x, y, number as f32));
            mesh.positions.extend(corners);
            mesh.triangles.push([first, first + 1, first + 2]);
            mesh.part_of_triangle.push(0);
        }
        let small = UnwrapSettings {
            atlas_size: 32,
            ..UnwrapSettings::default()
        };
        mesh.name = "splinters".to_owned();
        let error = unwrap(&[square(10.0), mesh], &small).map(drop).expect_err("no room");
        let name = "splinters".to_owned();
        assert_eq!(error, UnwrapError::TooManyPieces { name, size: 32 });
    }

    #[test]
    fn a_layout_that_is_cancelled_ends() {
        let cancelled = AtomicBool::new(true);
        let error = super::unwrap(&[square(1.0)], &with_density(8.0), &cancelled, &|_, _| {}).map(drop);
        assert_eq!(error, Err(UnwrapError::Cancelled));
    }

    #[test]
    fn texels_smaller_than_any_shape_are_handled() {
        let layout = unwrap(&[square(1e-3)], &with_density(1.0)).expect("a layout");
        assert_eq!(layout.pages, 1);
        // The page is cropped to the shapes.
        assert!(layout.size.y < 16, "{}", layout.size);
    }
}
