//! Makes the picture and the summary of a file. Files are read as the scene's own are, within the memory budget, and no
//! files outside of their folder are read.

use std::collections::HashMap;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::UNIX_EPOCH;

use bevy::math::{Affine3A, Mat3, Vec3};
use bevy_egui::egui::ColorImage;
use rayon::ThreadPoolBuilder;

use super::lamp_picture::lamp;
use super::volume_picture::volume;
use crate::accel::{Blas, Instance, Primitive, SplitMethod, Tlas};
use crate::app::editor::command::asset_kind::AssetKind;
use crate::app::editor::command::presets::{self, FileContent};
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
use crate::light::emission::Reach;
use crate::material::{Material, MaterialId, MaterialTable};
use crate::math::Aabb;
use crate::medium::MediumInterface;
use crate::render::camera::Camera;
use crate::render::film::Film;
use crate::render::scene::{RenderScene, SurfaceSlot, SurfaceTable};
use crate::render::tile::{render_tile, tiles};
use crate::render::tonemap::{Display, ToneMap};
use crate::render::view::{Shown, View};
use crate::scene::assets::gltf_scene::{is_called_gltf, placed_meshes};
use crate::scene::assets::texture_map::load_picture;
use crate::scene::assets::triangle_mesh::load_mesh;
use crate::shading::{Bsdf, Diffuse};

/// The longer side of a picture in pixels: sharp at twice its size in points.
pub(super) const EDGE: u32 = 128;
/// The longest files of which a picture is made, in bytes: longer ones would take the memory that the scene needs.
const LONGEST: u64 = 256 << 20;
/// The samples of a pixel. Meshes are lit from the camera, so that only their edges need more than one.
const MESH_SAMPLES: u32 = 16;
const BALL_SAMPLES: u32 = 64;

/// The picture of a file, and facts about its content.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Content {
    /// None for kinds of files that have no picture.
    pub image: Option<ColorImage>,
    pub note: String,
    pub bounds: Option<[Vec3; 2]>,
    pub is_material: bool,
}

/// Reads a file, or takes its content from the cache. Links may lead to folders that `trusted` permits. The error says
/// why the file cannot be used.
pub(super) fn content_of(entry: &AssetEntry, cache: &PictureCache, trusted: &Access) -> Result<Content, String> {
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
    let mut access = trusted.apart().of_scene_in(folder);
    access.allow(folder);
    if !access.covers(&entry.path) {
        let target = std::fs::canonicalize(&entry.path).unwrap_or_default();
        let target = target.parent().unwrap_or(Path::new(""));
        return Err(format!(
            "it is a link to {}, which is none of your folders here",
            target.display()
        ));
    }
    let content = beside_everything(|| match entry.kind {
        Some(AssetKind::Picture | AssetKind::Environment) => picture(&entry.path, &access),
        Some(AssetKind::Mesh) => mesh(&entry.path, &access),
        Some(AssetKind::Volume) => volume(&entry.path, &access),
        Some(AssetKind::Lamp) => lamp(&entry.path, &access),
        Some(AssetKind::Scene) => xml(&entry.path, access),
        None => Ok(Content::default()),
    })?;
    if let Some(image) = &content.image {
        let text = to_text(&content);
        let image = image.clone();
        cache.keep(&key, &Kept { image, text });
    }
    Ok(content)
}

/// Runs work on one thread of low priority. Otherwise file readers and hierarchies would use the threads of the whole
/// program.
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

/// A mesh with its pose, world from local.
type Placed = (Arc<MeshData>, Affine3A);

fn mesh(path: &Path, access: &Access) -> Result<Content, String> {
    if is_called_gltf(path) {
        return gltf(path, access);
    }
    let loaded = load_mesh(path, access).map_err(|error| error.to_string())?;
    let meshes = loaded.shapes.iter();
    let meshes: Vec<Placed> = meshes.map(|shape| (shape.data.clone(), Affine3A::IDENTITY)).collect();
    let triangles: usize = meshes.iter().map(|(mesh, _)| mesh.triangles.len()).sum();
    let bounds = bounds_of(&meshes);
    Ok(Content {
        image: clay(meshes, &bounds),
        note: triangles_text(triangles),
        bounds: corners(&bounds),
        is_material: false,
    })
}

/// The meshes of a glTF file in grey, and their number; its materials are not read.
fn gltf(path: &Path, access: &Access) -> Result<Content, String> {
    let meshes = placed_meshes(path, access, LONGEST)?;
    let bounds = bounds_of(&meshes);
    Ok(Content {
        note: shapes_text(meshes.len()),
        image: clay(meshes, &bounds),
        bounds: corners(&bounds),
        is_material: false,
    })
}

/// The least and the greatest coordinates; None for an empty box.
fn corners(bounds: &Aabb) -> Option<[Vec3; 2]> {
    (!bounds.is_empty()).then_some([bounds.min, bounds.max])
}

fn bounds_of(meshes: &[Placed]) -> Aabb {
    let points = |(mesh, pose): &Placed| {
        let pose = *pose;
        let points = mesh.positions.iter().map(move |point| pose.transform_point3(*point));
        points.fold(Aabb::EMPTY, |bounds, point| {
            bounds.union(Aabb { min: point, max: point })
        })
    };
    meshes.iter().map(points).fold(Aabb::EMPTY, Aabb::union)
}

/// A number of triangles. The line is as short as a picture is wide.
fn triangles_text(count: usize) -> String {
    match count {
        1 => "1 triangle".to_owned(),
        ..10_000 => format!("{count} triangles"),
        10_000..10_000_000 => format!("{} k tris", count / 1000),
        _ => format!("{} M tris", count / 1_000_000),
    }
}

fn shapes_text(count: usize) -> String {
    match count {
        1 => "1 shape".to_owned(),
        count => format!("{count} shapes"),
    }
}

/// Meshes in grey, seen from the front, a little from the right and above. None for meshes without a size.
fn clay(meshes: Vec<Placed>, bounds: &Aabb) -> Option<ColorImage> {
    /// The field of view in degrees, and the share of the picture that the mesh's bounding sphere fills.
    const FIELD: f32 = 30.0;
    const FILLED: f32 = 0.85;
    let radius = 0.5 * bounds.extent().length();
    if !(radius.is_finite() && radius > 0.0) {
        return None;
    }
    // A mesh that is placed several times has one hierarchy.
    let mut known: HashMap<*const MeshData, Arc<Blas>> = HashMap::new();
    let mut slots = Vec::new();
    let mut instances = Vec::new();
    for (mesh, pose) in meshes {
        let slot_count = mesh.materials.len().max(1);
        let build = |mesh| Arc::new(Blas::build(mesh, SplitMethod::default()));
        let blas = known.entry(Arc::as_ptr(&mesh)).or_insert_with(|| build(mesh));
        if let Some(instance) = Instance::new(Primitive::Mesh(blas.clone()), pose) {
            instances.push(instance);
            slots.push(slot_count);
        }
    }
    let geometry = Tlas::build(instances, SplitMethod::default());
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
        media: Arc::default(),
        lights: Arc::new(LightTable::build(&[], &geometry, &textures)),
        reach: Reach::default(),
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

/// The picture of an XML file: a ball of the first material if it holds only materials; a scene has no picture, but a
/// number of shapes.
fn xml(path: &Path, access: Access) -> Result<Content, String> {
    let preset = match presets::content_of(path, access).map_err(|error| error.to_string())? {
        FileContent::Materials(preset) => *preset,
        FileContent::Scene(shapes) => {
            return Ok(Content {
                note: shapes.map_or("scene".to_owned(), shapes_text),
                ..Content::default()
            });
        }
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

    fn nowhere() -> Access {
        Access::within([])
    }

    const TRIANGLE: &[u8] = b"v -1 0 0\nv 1 0 0\nv 0 2 0\nf 1 2 3\n";

    #[test]
    fn files_say_what_they_are() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let cache = PictureCache::default();
        let content = |name: &str, bytes: &[u8]| content_of(&entry(folder.path(), name, bytes), &cache, &nowhere());

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
            ("1 shape", None, false)
        );
    }

    #[test]
    fn a_gltf_file_has_a_picture_of_all_that_it_places() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let corners: [f32; 9] = [-1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 2.0, 0.0];
        let bytes: Vec<u8> = corners.iter().flat_map(|number| number.to_le_bytes()).collect();
        fs::write(folder.path().join("corners.bin"), bytes).expect("it can be written");
        let text = r#"{"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0, 1, 2]}],
            "nodes": [{"mesh": 0}, {"mesh": 0, "translation": [3, 0, 0]}, {"name": "empty"}],
            "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
            "accessors": [{"bufferView": 0, "componentType": 5126, "type": "VEC3", "count": 3}],
            "bufferViews": [{"buffer": 0, "byteLength": 36}],
            "buffers": [{"byteLength": 36, "uri": "corners.bin"}]}"#;
        let file = entry(folder.path(), "two.gltf", text.as_bytes());
        let content = content_of(&file, &PictureCache::default(), &nowhere()).expect("it can be read");
        let bounds = Some([Vec3::new(-1.0, 0.0, 0.0), Vec3::new(4.0, 2.0, 0.0)]);
        assert_eq!((content.note.as_str(), content.bounds), ("2 shapes", bounds));
        let image = content.image.expect("it has a picture");
        let is_lit = |x: usize, y: usize| image[(x, y)].r() > 2 * image[(2, 2)].r();
        // The two triangles stand beside each other, with a gap between their upper ends.
        let lit: Vec<usize> = (0..128).filter(|x| is_lit(*x, 64)).collect();
        let gaps = lit.windows(2).filter(|pair| pair[1] - pair[0] > 4).count();
        assert_eq!(gaps, 1, "{lit:?}");
        let broken = entry(folder.path(), "broken.glb", b"glTF");
        assert!(content_of(&broken, &PictureCache::default(), &nowhere()).is_err());
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
            let error = content_of(&entry(folder.path(), name, bytes), &cache, &nowhere()).expect_err(name);
            assert!(!error.is_empty(), "{name}");
        }
        let absent = AssetEntry {
            path: folder.path().join("gone.png"),
            ..entry(folder.path(), "a.png", b"")
        };
        assert!(content_of(&absent, &cache, &nowhere()).is_err());
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
        let content = |entry: &AssetEntry, trusted: &Access| content_of(entry, &PictureCache::default(), trusted);
        assert!(content(&link, &nowhere()).is_err_and(|error| error.contains("it is a link to")));
        assert!(content(&target, &nowhere()).is_ok());
        // Links to the user's own folders are allowed.
        let own = Access::within([outside.path().to_owned()]);
        assert_eq!(content(&link, &own), content(&target, &nowhere()));
    }

    #[test]
    fn what_is_known_comes_from_the_cache_until_the_file_changes() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let cache = PictureCache::in_folder(Some(folder.path().to_owned()));
        let mut file = entry(folder.path(), "a.obj", TRIANGLE);
        let made = content_of(&file, &cache, &nowhere()).expect("it is a mesh");
        fs::write(&file.path, "broken").expect("it can be written");
        assert_eq!(content_of(&file, &cache, &nowhere()), Ok(made));
        file.bytes = 6;
        assert!(content_of(&file, &cache, &nowhere()).is_err());
    }
}
