//! Finds out what a file looks like and holds. Files are read as the scene's own are, within the memory budget, and nothing outside of their folder is read.

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::UNIX_EPOCH;

use bevy::math::{Affine3A, Mat3, Vec3};
use bevy_egui::egui::ColorImage;
use rayon::ThreadPoolBuilder;

use crate::accel::{Blas, Instance, Primitive, SplitMethod, Tlas};
use crate::app::editor::command::asset_kind::AssetKind;
use crate::app::editor::command::presets;
use crate::app::editor::model::assets::AssetEntry;
use crate::app::editor::model::thumbnails::shrunk;
use crate::app::editor::picture::ball_picture::{self, without_noise};
use crate::app::editor::picture::material_ball::{self, MaterialBall};
use crate::app::editor::session::picture_cache::{Kept, PictureCache};
use crate::color::Rgb;
use crate::engine::yield_to_all;
use crate::files::Access;
use crate::geometry::mesh::MeshData;
use crate::light::LightTable;
use crate::material::{Material, MaterialId, MaterialTable};
use crate::math::Aabb;
use crate::medium::MediumInterface;
use crate::render::camera::Camera;
use crate::render::film::Film;
use crate::render::scene::{RenderScene, SurfaceSlot, SurfaceTable};
use crate::render::tile::{render_tile, tiles};
use crate::render::tonemap::{Display, ToneMap};
use crate::render::view::{Shown, View};
use crate::scene::assets::texture_map::load_picture;
use crate::scene::assets::triangle_mesh::load_mesh;
use crate::shading::{Bsdf, Diffuse};

/// The longer side of a picture in pixels: sharp at twice its size in points.
const EDGE: u32 = 128;
/// The longest files of which a picture is made, in bytes: longer ones would take the memory that the scene needs.
const LONGEST: u64 = 256 << 20;
/// The samples of a pixel. Meshes are lit from the camera, so that only their edges need more than one.
const MESH_SAMPLES: u32 = 16;
const BALL_SAMPLES: u32 = 64;

/// What a file looks like, and what is known of it.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Content {
    /// None for kinds of files that have no picture.
    pub image: Option<ColorImage>,
    pub note: String,
    pub bounds: Option<[Vec3; 2]>,
    pub is_material: bool,
}

/// Reads a file, or takes what is known of it from an earlier run. The error says why the file cannot be used.
pub(super) fn content_of(entry: &AssetEntry, cache: &PictureCache) -> Result<Content, String> {
    let changed = entry.modified.and_then(|time| time.duration_since(UNIX_EPOCH).ok());
    let key = format!("file {} {} {changed:?}", entry.path.display(), entry.bytes);
    if let Some(known) = cache.get(&key).and_then(from_kept) {
        return Ok(known);
    }
    if entry.bytes > LONGEST {
        let note = "too large for a picture".to_owned();
        return Ok(Content {
            note,
            ..Content::default()
        });
    }
    // A folder of strangers may hold links to anywhere.
    let folder = entry.path.parent().unwrap_or(Path::new(""));
    let access = Access::within([folder.to_owned()]).of_scene_in(folder);
    if !access.covers(&entry.path) {
        return Err("it is a link that leads out of the folder".to_owned());
    }
    let content = beside_everything(|| match entry.kind {
        Some(AssetKind::Picture | AssetKind::Environment) => picture(&entry.path, &access),
        Some(AssetKind::Mesh) => mesh(&entry.path, &access),
        Some(AssetKind::Scene) => material(&entry.path, access),
        None => Ok(Content::default()),
    })?;
    if let Some(image) = &content.image {
        let text = to_text(&content);
        let image = image.clone();
        cache.keep(&key, &Kept { image, text });
    }
    Ok(content)
}

/// Does work on one thread that gives way to all others. Readers and hierarchies would share it with the threads of the whole program otherwise.
fn beside_everything(work: impl FnOnce() -> Result<Content, String> + Send) -> Result<Content, String> {
    let pool = ThreadPoolBuilder::new()
        .num_threads(1)
        .start_handler(|_| yield_to_all())
        .build();
    pool.map_err(|error| error.to_string())?.install(work)
}

/// The note, whether it is a material, and the bounds, in one line.
fn to_text(content: &Content) -> String {
    let bounds = content.bounds.map(|corners| corners.map(|corner| corner.to_array()));
    serde_json::to_string(&(&content.note, content.is_material, bounds)).unwrap_or_default()
}

fn from_kept(kept: Kept) -> Option<Content> {
    let (note, is_material, bounds): (String, bool, Option<[[f32; 3]; 2]>) = serde_json::from_str(&kept.text).ok()?;
    Some(Content {
        image: Some(kept.image),
        note,
        is_material,
        bounds: bounds.map(|corners| corners.map(Vec3::from_array)),
    })
}

fn picture(path: &Path, access: &Access) -> Result<Content, String> {
    let picture = load_picture(path, access).map_err(|error| error.to_string())?;
    let size = [picture.image.width(), picture.image.height()];
    // Radiance goes far beyond white.
    let display = Display {
        tone_map: match AssetKind::of(path) {
            Some(AssetKind::Environment) => ToneMap::AgX,
            _ => ToneMap::Clip,
        },
        ..Display::default()
    };
    Ok(Content {
        image: Some(shrunk(&picture.image, EDGE, &display.encoder())),
        note: format!("{} × {}", size[0], size[1]),
        ..Content::default()
    })
}

/// A glTF file has materials, lights and many meshes; it is not taken apart for a picture.
fn mesh(path: &Path, access: &Access) -> Result<Content, String> {
    let extension = path.extension().unwrap_or_default().to_ascii_lowercase();
    if extension == "gltf" || extension == "glb" {
        return Ok(Content::default());
    }
    let loaded = load_mesh(path, access).map_err(|error| error.to_string())?;
    let meshes: Vec<Arc<MeshData>> = loaded.shapes.iter().map(|shape| shape.data.clone()).collect();
    let triangles: usize = meshes.iter().map(|mesh| mesh.triangles.len()).sum();
    let points = meshes.iter().flat_map(|mesh| mesh.positions.iter().copied());
    let bounds = points.fold(Aabb::EMPTY, |bounds, point| {
        bounds.union(Aabb { min: point, max: point })
    });
    Ok(Content {
        image: clay(meshes, &bounds),
        note: match triangles {
            1 => "1 triangle".to_owned(),
            count @ ..10_000 => format!("{count} triangles"),
            // The line is as short as the picture is wide.
            count @ ..10_000_000 => format!("{} k tris", count / 1000),
            count => format!("{} M tris", count / 1_000_000),
        },
        bounds: (!bounds.is_empty()).then_some([bounds.min, bounds.max]),
        is_material: false,
    })
}

/// Meshes in grey, seen from the front, a little from the right and above. None for meshes without a size.
fn clay(meshes: Vec<Arc<MeshData>>, bounds: &Aabb) -> Option<ColorImage> {
    /// Degrees, and the share of the picture that the sphere around the mesh fills.
    const FIELD: f32 = 30.0;
    const FILLED: f32 = 0.85;
    let radius = 0.5 * bounds.extent().length();
    if !(radius.is_finite() && radius > 0.0) {
        return None;
    }
    let slots: Vec<usize> = meshes.iter().map(|mesh| mesh.materials.len().max(1)).collect();
    let blas = |mesh| Primitive::Mesh(Arc::new(Blas::build(mesh, SplitMethod::default())));
    let instances = meshes
        .into_iter()
        .filter_map(|mesh| Instance::new(blas(mesh), Affine3A::IDENTITY));
    let geometry = Tlas::build(instances.collect(), SplitMethod::default());
    let slot = SurfaceSlot {
        material: MaterialId(0),
        light: None,
        media: MediumInterface::default(),
    };
    let first_slot = slots.iter().scan(0, |next, count| {
        let first = *next;
        *next += *count as u32;
        Some(first)
    });
    let surfaces = SurfaceTable {
        first_slot: first_slot.collect(),
        slots: vec![slot; slots.iter().sum()],
    };
    let grey = Bsdf::Diffuse(Diffuse {
        reflectance: Rgb::splat(0.5),
    });
    let textures = Arc::default();
    let scene = RenderScene {
        lights: Arc::new(LightTable::build(&[], &geometry, &textures)),
        geometry: Arc::new(geometry),
        surfaces: Arc::new(surfaces),
        materials: Arc::new(MaterialTable::new(vec![Material::Plain(grey)]).ok()?),
        textures,
    };
    let distance = radius / (FILLED * (0.5 * FIELD).to_radians().sin());
    let back = Vec3::new(0.45, 0.4, 1.0).normalize();
    let forward = -back;
    let left = Vec3::Y.cross(forward).normalize();
    let axes = Mat3::from_cols(left, forward.cross(left), forward);
    let pose = Affine3A::from_mat3_translation(axes, bounds.center() + distance * back);
    let view = View {
        camera: Camera::new(pose, FIELD, 1.0, 1e-3 * distance, 10.0 * distance, None),
        shown: Shown::Clay,
        ..material_ball::view(EDGE)
    };
    let mut film = Film::new(EDGE, EDGE);
    for tile in tiles(EDGE, EDGE) {
        film.add(&render_tile(
            &scene,
            &view,
            tile,
            0..MESH_SAMPLES,
            &AtomicBool::new(false),
        )?);
    }
    Some(encoded(&film.radiance()))
}

fn encoded(radiance: &[Rgb]) -> ColorImage {
    let mut rgba = vec![0; 4 * radiance.len()];
    Display::default().encode_rgba(radiance, &mut rgba);
    ColorImage::from_rgba_unmultiplied([EDGE as usize; 2], &rgba)
}

/// A file that holds nothing but materials looks like a ball of the first; other scenes have no picture.
fn material(path: &Path, access: Access) -> Result<Content, String> {
    let Some(preset) = presets::material_of(path, access).map_err(|error| error.to_string())? else {
        let note = "scene".to_owned();
        return Ok(Content {
            note,
            ..Content::default()
        });
    };
    let look = ball_picture::looks(std::slice::from_ref(&preset)).pop();
    let image = look.and_then(|look| MaterialBall::new(&look, EDGE)).and_then(|ball| {
        let (mut film, go_on) = (ball.film(), AtomicBool::new(false));
        ball.refine(&mut film, BALL_SAMPLES, &go_on)?;
        Some(encoded(&without_noise(&film, Some(1), &go_on)))
    });
    Ok(Content {
        image,
        note: "material".to_owned(),
        is_material: true,
        bounds: None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    fn entry(folder: &Path, name: &str, content: &[u8]) -> AssetEntry {
        let path = folder.join(name);
        fs::write(&path, content).expect("it can be written");
        AssetEntry {
            name: name.to_owned(),
            kind: AssetKind::of(&path),
            bytes: content.len() as u64,
            modified: None,
            path,
        }
    }

    #[test]
    fn work_does_not_reach_the_threads_of_the_program() {
        let mut threads = 0;
        let content = beside_everything(|| {
            threads = rayon::current_num_threads();
            Ok(Content::default())
        });
        assert_eq!((content, threads), (Ok(Content::default()), 1));
    }

    const TRIANGLE: &[u8] = b"v -1 0 0\nv 1 0 0\nv 0 2 0\nf 1 2 3\n";

    #[test]
    fn files_say_what_they_are() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let cache = PictureCache::default();
        let content = |name: &str, bytes: &[u8]| content_of(&entry(folder.path(), name, bytes), &cache);

        let mesh = content("a.obj", TRIANGLE).expect("it is a mesh");
        assert_eq!(mesh.note, "1 triangle");
        assert_eq!(mesh.bounds, Some([Vec3::new(-1.0, 0.0, 0.0), Vec3::new(1.0, 2.0, 0.0)]));
        let image = mesh.image.expect("it has a picture");
        let middle = image[(64, 64)];
        assert!(middle.r() > 2 * image[(2, 2)].r(), "{middle:?}");

        let picture = content("a.ppm", b"P6 2 1 255\n\xff\x00\x00\x00\xff\x00").expect("it is a picture");
        assert_eq!(
            (picture.note.as_str(), picture.image.map(|image| image.size)),
            ("2 × 1", Some([2, 1]))
        );

        let material = b"<scene version='3.0.0'><bsdf type='diffuse' id='a'/></scene>";
        let material = content("a.xml", material).expect("it is a material");
        assert!(material.is_material && material.image.is_some());
        let scene = b"<scene version='3.0.0'><shape type='sphere'/></scene>";
        let scene = content("b.xml", scene).expect("it is a scene");
        assert_eq!(
            (scene.note.as_str(), scene.image, scene.is_material),
            ("scene", None, false)
        );
    }

    #[test]
    fn broken_files_say_why() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let cache = PictureCache::default();
        for (name, bytes) in [
            ("a.png", &b"no picture"[..]),
            ("a.exr", b"\x76\x2f\x31\x01"),
            ("a.ply", b"ply\nformat ascii 1.0\nelement vertex 4000000000\n"),
            ("a.serialized", b"\x1c\x04\x04\x00"),
        ] {
            let error = content_of(&entry(folder.path(), name, bytes), &cache).expect_err(name);
            assert!(!error.is_empty(), "{name}");
        }
        let absent = AssetEntry {
            path: folder.path().join("gone.png"),
            ..entry(folder.path(), "a.png", b"")
        };
        assert!(content_of(&absent, &cache).is_err());
    }

    #[cfg(unix)]
    #[test]
    fn links_out_of_the_folder_are_not_followed() {
        let (folder, outside) = (tempfile::tempdir(), tempfile::tempdir());
        let (folder, outside) = (
            folder.expect("a temporary folder"),
            outside.expect("a temporary folder"),
        );
        let target = entry(outside.path(), "a.obj", TRIANGLE);
        let link = folder.path().join("link.obj");
        std::os::unix::fs::symlink(&target.path, &link).expect("it can be linked");
        let link = AssetEntry {
            path: link,
            ..target.clone()
        };
        assert!(content_of(&link, &PictureCache::default()).is_err());
        assert!(content_of(&target, &PictureCache::default()).is_ok());
    }

    #[test]
    fn what_is_known_comes_from_the_cache_until_the_file_changes() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let cache = PictureCache::in_folder(Some(folder.path().to_owned()));
        let mut file = entry(folder.path(), "a.obj", TRIANGLE);
        let made = content_of(&file, &cache).expect("it is a mesh");
        fs::write(&file.path, "broken").expect("it can be written");
        assert_eq!(content_of(&file, &cache), Ok(made));
        file.bytes = 6;
        assert!(content_of(&file, &cache).is_err());
    }
}
