//! Reads shapes: primitives, mesh files and instances, with their bsdf, their emission and the media on their two
//! sides.

use std::path::{Path, PathBuf};

use glam::Vec3;

use super::from_file::FromFile;
use super::media::media_of_shape;
use super::mesh_search::{Found, advice};
use super::parameters::{Parameters, report_left_out};
use super::picture_search::PictureSearch;
use super::scene_reader::{SceneReader, angles_of};
use crate::document::{Category, Object, Reader};
use crate::scene::components::description::{DeclarationPlace, SceneDescription, ShapeDescription};
use crate::scene::components::medium::{EXTERIOR, INTERIOR};
use crate::scene::encode::{FRAME, objects};
use crate::scene::{FileKind, MeshFile, MeshFormat, Shape, ShapeKind, Solid};

/// The shapes of Mitsuba, also of old versions, that this program lacks.
const FOREIGN_SHAPES: [&str; 7] = [
    "sdfgrid",
    "ellipsoids",
    "ellipsoidsmesh",
    "merge",
    "hair",
    "heightfield",
    "deformable",
];

impl<'a> SceneReader<'a> {
    /// Whether the shape became part of the description; `group`: the group that contains it.
    pub(super) fn read_shape(&mut self, object: &'a Object, group: Option<usize>) -> bool {
        if object.is_group() {
            return self.read_group(object);
        }
        let mut reader = Reader::new(&self.index, object, &mut self.diagnostics);
        let Some((kind, file_name)) = read_kind(&mut reader, &mut self.pictures) else {
            return false;
        };
        let is_instance = kind == ShapeKind::Instance;
        let has_surface = !is_instance && kind != ShapeKind::Frame;
        let flip_normals = has_surface && reader.boolean_or("flip_normals", false);
        let mut lightmap_scale = None;
        if has_surface || is_instance {
            lightmap_scale = reader.float_in("lightmap_scale", Shape::LIGHTMAP_SCALES);
        }
        let portal = kind == ShapeKind::Rectangle && reader.boolean_or("portal", false);
        reader.ignore(&["silhouette_sampling_weight"]);
        let to_world = reader.to_world();
        let (mut bsdfs, mut emitters, mut shapes) = (Vec::new(), Vec::new(), Vec::new());
        let mut media = [None; 2];
        if is_instance {
            shapes = reader.children(Category::Shape);
        } else if has_surface {
            bsdfs = reader.children(Category::Bsdf);
            emitters = reader.children(Category::Emitter);
            media = media_of_shape(&mut reader);
        }
        reader.finish();
        let mut instance_of = None;
        if is_instance {
            instance_of = self.group_of_instance(object, &shapes);
            if instance_of.is_none() {
                return false;
            }
        }

        let mut shape = Shape {
            kind,
            flip_normals,
            lightmap_scale: lightmap_scale.unwrap_or(1.0),
            portal,
        };
        if let (ShapeKind::Mesh(mesh), Some(name)) = (&mut shape.kind, file_name) {
            mesh.path = self.find_mesh(object, name);
        }

        let place = DeclarationPlace::Shape(self.description.shapes.len());
        let before = self.declared();
        let material = bsdfs.first().map(|(_, bsdf)| self.read_bsdf(bsdf, place, 0));
        if let Some((_, second)) = bsdfs.get(1) {
            let message = format!("{} has a bsdf already", object.title());
            self.diagnostics.error(second.span, message);
        }
        let [interior, exterior] = media.map(|medium| self.read_medium(medium?, place));
        let mut area_light = None;
        for (_, emitter) in emitters {
            if group.is_some() {
                let message = "a shape of a shapegroup cannot be an emitter";
                self.diagnostics.error(emitter.span, message);
            } else if shape.is_of_curves() {
                let message = format!(
                    "{} cannot be an emitter: light is not sampled on curves",
                    object.title()
                );
                self.diagnostics.error(emitter.span, message);
            } else if area_light.is_some() {
                let message = format!("{} has an emitter already", object.title());
                self.diagnostics.error(emitter.span, message);
            } else {
                area_light = self.read_area_light(emitter);
            }
        }

        let Some(to_world) = to_world else {
            // Materials and media declared inside this shape move, since the shape does not exist.
            self.forget_place(place, before);
            return false;
        };
        let angles = angles_of(object);
        let as_read = |folder: &Path| objects::shape(&shape, &to_world, angles, area_light.as_ref(), folder);
        let mut identity = self.identity(object, as_read);
        if let Some(authored) = &mut identity.authored {
            let sides = [(INTERIOR, interior), (EXTERIOR, exterior)];
            authored.leave_out_media(|name, _| {
                sides
                    .iter()
                    .any(|(side, medium)| name == Some(*side) && medium.is_some())
            });
        }
        if identity.id.is_none()
            && let ShapeKind::Mesh(mesh) = &shape.kind
            && let Some(stem) = mesh.path.file_stem()
        {
            identity.name = stem.to_string_lossy().into_owned().into();
        }
        self.description.shapes.push(ShapeDescription {
            identity,
            shape,
            to_world,
            material,
            interior,
            exterior,
            area_light,
            member_of: group,
            instance_of,
            placements: None,
        });
        true
    }

    /// The mesh file; if it is missing, the first path that was tried.
    fn find_mesh(&mut self, object: &Object, name: &str) -> PathBuf {
        let property = object.properties.iter().find(|property| property.name == "filename");
        let span = property.map_or(object.span, |property| property.span);
        match self.meshes.find(name, &self.folder_of(span)) {
            Found::At(path) => path,
            Found::Nowhere(places) => self.pictures.note_missing(FileKind::Mesh, places, span, advice(name)),
        }
    }

    /// The numbers of materials and media read so far.
    pub(super) fn declared(&self) -> [usize; 2] {
        [self.description.materials.len(), self.description.media.len()]
    }

    /// Moves the declarations of a place that does not exist after all to the top level. `before`: the result of
    /// [`Self::declared`] before the place.
    pub(super) fn forget_place(&mut self, place: DeclarationPlace, before: [usize; 2]) {
        let SceneDescription { materials, media, .. } = &mut self.description;
        let materials = materials[before[0]..].iter_mut().map(|it| &mut it.declared_in);
        let media = media[before[1]..].iter_mut().map(|it| &mut it.declared_in);
        for declared_in in materials.chain(media).filter(|declared_in| **declared_in == place) {
            *declared_in = DeclarationPlace::TopLevel;
        }
    }
}

/// The kind of a shape, with the name of its mesh file. None if there is no such plugin, which has been reported.
fn read_kind<'a>(reader: &mut Reader<'a, '_>, pictures: &mut PictureSearch) -> Option<(ShapeKind, Option<&'a str>)> {
    let object = reader.object();
    let kind = match object.plugin.as_str() {
        "sphere" => ShapeKind::Sphere {
            center: reader.point("center").unwrap_or_default(),
            radius: reader.float_in("radius", f32::MIN_POSITIVE..).unwrap_or(1.0),
        },
        "rectangle" => ShapeKind::Rectangle,
        "cube" => ShapeKind::Cube,
        "disk" => ShapeKind::Disk,
        "triangle" => {
            let corners = ["v0", "v1", "v2"].map(|name| reader.point(name).unwrap_or_default());
            let [a, b, c] = corners;
            if (b - a).cross(c - a).try_normalize().is_none() {
                let message = "a triangle needs three corners `v0`, `v1` and `v2` that are not in one line";
                reader.diagnostics().error(object.span, message);
            }
            ShapeKind::Triangle { corners }
        }
        "cylinder" => ShapeKind::Cylinder {
            p0: reader.point("p0").unwrap_or(Vec3::ZERO),
            p1: reader.point("p1").unwrap_or(Vec3::Z),
            radius: reader.float_in("radius", f32::MIN_POSITIVE..).unwrap_or(1.0),
        },
        "instance" => ShapeKind::Instance,
        FRAME if object.category == Category::Volume => {
            reader.ignore(&["value"]);
            ShapeKind::Frame
        }
        plugin => {
            if let Some(format) = MeshFormat::of_name(plugin) {
                return Some(read_mesh(reader, format));
            }
            let Some(mut solid) = Solid::of_plugin(plugin) else {
                let help = reader.diagnostics().did_you_mean(plugin, ShapeKind::PLUGINS);
                report_left_out(reader, FOREIGN_SHAPES.contains(&plugin), help);
                return None;
            };
            FromFile { reader, pictures }.read_all(&mut solid);
            ShapeKind::Solid(solid)
        }
    };
    Some((kind, None))
}

/// A mesh or curves, with the name of the file, which is not searched yet.
fn read_mesh<'a>(reader: &mut Reader<'a, '_>, format: MeshFormat) -> (ShapeKind, Option<&'a str>) {
    let file_name = reader.string("filename");
    if file_name.is_none() && !reader.has("filename") {
        let object = reader.object();
        let message = format!("{} needs a `filename`", object.title());
        reader.diagnostics().error(object.span, message);
    }
    let mut mesh = MeshFile {
        format,
        ..MeshFile::default()
    };
    if format.is_of_curves() {
        return (ShapeKind::Mesh(mesh), file_name);
    }
    mesh.face_normals = reader.boolean_or("face_normals", false);
    if format == MeshFormat::Serialized {
        let index = reader.integer_in("shape_index", 0..=i64::from(u32::MAX));
        mesh.shape_index = index.unwrap_or(0) as u32;
    } else {
        mesh.flip_tex_coords = reader.boolean_or("flip_tex_coords", format.flips_tex_coords());
    }
    (ShapeKind::Mesh(mesh), file_name)
}
