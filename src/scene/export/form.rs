//! The geometry of shapes in their own space: shapes that differ only in their transforms share a form.

use std::collections::HashMap;
use std::path::PathBuf;
use std::sync::Arc;

use bevy::math::{Affine3A, Mat3, Vec3};

use super::messages::Messages;
use crate::files::Access;
use crate::geometry::attribute::AttributeDomain;
use crate::geometry::mesh::MeshData;
use crate::geometry::strands::stretch_of;
use crate::geometry::tube::{TubeError, tubes};
use crate::scene::assets::box_lying::{LyingBox, has_projection};
use crate::scene::assets::shape_mesh::{shape_mesh, unit_form};
use crate::scene::assets::triangle_mesh::{TriangleMesh, basis_of, load_mesh};
use crate::scene::components::description::{SceneDescription, ShapeDescription};
use crate::scene::{MeshFormat, ShapeKind};

/// The most triangles in place of all curves.
const MOST_TRIANGLES: usize = 4_000_000;

/// The vertex colours of a mesh: the name of its attribute, and a factor.
pub(super) type Colors = Option<(String, f32)>;

/// The geometry of a shape in its own space.
#[derive(Clone)]
pub(super) struct Form {
    /// Equal forms have equal keys.
    pub key: String,
    pub mesh: Arc<MeshData>,
    /// Whether it is shaded with geometric normals.
    pub is_flat: bool,
    /// The transform from the space of the mesh to that of the shape.
    pub shape_from_mesh: Affine3A,
}

impl Form {
    /// Whether a mirroring transform flips its normals: geometric normals, and normals computed from triangles.
    pub fn turns_with_mirrors(&self) -> bool {
        self.is_flat || self.mesh.has_computed_normals || self.mesh.normals.is_empty()
    }
}

/// The forms of the shapes of a scene, each made once.
pub(super) struct Forms<'a> {
    access: &'a Access,
    files: HashMap<PathBuf, Option<TriangleMesh>>,
    forms: HashMap<String, Option<Form>>,
    /// The triangles that may still take the place of curves.
    left_for_curves: usize,
}

impl<'a> Forms<'a> {
    pub fn new(access: &'a Access) -> Self {
        Self {
            access,
            files: HashMap::new(),
            forms: HashMap::new(),
            left_for_curves: MOST_TRIANGLES,
        }
    }

    /// The form of a shape; None if it has no triangles (reported if that is unexpected).
    pub fn of(&mut self, shape: &ShapeDescription, messages: &mut Messages) -> Option<Form> {
        let kind = &shape.shape.kind;
        let name = &*shape.identity.name;
        if matches!(kind, ShapeKind::Instance | ShapeKind::Frame) {
            return None;
        }
        let (plain, shape_from_mesh) = unit_form(kind);
        // A transform leaves the radii of curves alone.
        let stretch = shape.shape.is_of_curves().then(|| stretch_of(&shape.to_world));
        let shape_from_mesh = stretch.map_or(shape_from_mesh, |stretch| Affine3A::from_mat3(stretch.inverse()));
        let key = format!("{plain:?}{stretch:?}");
        if let Some(known) = self.forms.get(&key) {
            let form = known.clone()?;
            return Some(Form {
                shape_from_mesh,
                ..form
            });
        }
        let mesh = match &plain {
            ShapeKind::Mesh(file) if stretch.is_some() => self.tubes_of_file(file, stretch, name, messages),
            ShapeKind::Mesh(file) => self.mesh_of_file(file, name, messages),
            other => shape_mesh(other).map(Arc::new),
        };
        let mesh = mesh.filter(|mesh| !mesh.triangles.is_empty());
        if mesh.is_none() && !matches!(plain, ShapeKind::Mesh(_)) {
            messages.left_out("shape", name, "there is no surface");
        }
        let form = mesh.map(|mesh| Form {
            key: key.clone(),
            mesh,
            is_flat: match &plain {
                ShapeKind::Mesh(file) => file.face_normals,
                ShapeKind::Triangle { .. } => true,
                _ => false,
            },
            shape_from_mesh,
        });
        self.forms.insert(key, form.clone());
        form
    }

    /// The form of a shape with coordinates of the box, if all its textures are box projections. `placement`: the
    /// transform of the instance, for a member of a group.
    pub fn laid(
        &mut self,
        scene: &SceneDescription,
        shape: &ShapeDescription,
        placement: Option<&Affine3A>,
        messages: &mut Messages,
    ) -> Option<Form> {
        let form = self.of(shape, messages)?;
        let name = &*shape.identity.name;
        let Some(lying) = LyingBox::of(scene, shape, &form.shape_from_mesh, placement) else {
            if has_projection(scene, shape) {
                let what = "beside other textures, those of box projections lie by uv";
                messages.note("shape", name, what);
            }
            return Some(form);
        };
        if lying.is_sheared() {
            let what = "it is sheared, so that bumps of box projections lean";
            messages.note("shape", name, what);
        }
        let key = format!("{} {}", form.key, lying.key());
        let known = self.forms.entry(key.clone()).or_insert_with(|| {
            let mesh = lying.laid(&form.mesh);
            let laid = |mesh| Form {
                key,
                mesh: Arc::new(mesh),
                ..form.clone()
            };
            mesh.map(laid)
                .map_err(|_| {
                    let what = "textures of box projections lie by uv, because the memory budget has no room";
                    messages.note("shape", name, what);
                })
                .ok()
        });
        let laid = known.clone().map(|laid| Form {
            shape_from_mesh: form.shape_from_mesh,
            ..laid
        });
        Some(laid.unwrap_or(form))
    }

    /// The key of the coordinates of the box that a member of a group has in an instance; None without a box.
    pub fn key_of_box(
        &mut self,
        scene: &SceneDescription,
        member: &ShapeDescription,
        placement: &Affine3A,
        messages: &mut Messages,
    ) -> Option<String> {
        let form = self.of(member, messages)?;
        Some(LyingBox::of(scene, member, &form.shape_from_mesh, Some(placement))?.key())
    }

    /// The pictures named by the materials of a shape's mesh file.
    pub fn pictures_of_file(&mut self, shape: &ShapeDescription) -> Vec<PathBuf> {
        let ShapeKind::Mesh(file) = &shape.shape.kind else {
            return Vec::new();
        };
        if file.format != MeshFormat::Obj {
            return Vec::new();
        }
        let known = self.files.entry(file.path.clone());
        let mesh = known.or_insert_with(|| load_mesh(&file.path, self.access).ok());
        let data = mesh.iter().flat_map(|mesh| &mesh.shapes).map(|shape| &shape.data);
        let maps = data
            .flat_map(|data| &data.materials)
            .flat_map(|material| material.maps.iter());
        maps.map(|map| map.file.clone()).collect()
    }

    /// Tubes in place of the curves of a file, after this transform of their control points.
    fn tubes_of_file(
        &mut self,
        file: &crate::scene::MeshFile,
        stretch: Option<Mat3>,
        name: &str,
        messages: &mut Messages,
    ) -> Option<Arc<MeshData>> {
        let curves = self.mesh_of_file(file, name, messages)?;
        let stretched = curves.with_stretched_strands(&stretch?).ok()?;
        let tubes = tubes(&stretched.strands, basis_of(file.format)?, self.left_for_curves);
        match &tubes {
            Ok(tubes) => {
                self.left_for_curves -= tubes.triangles.len();
                messages.note("shape", name, "the curves become tubes of triangles");
            }
            Err(TubeError::TooMany) => messages.left_out(
                "shape",
                name,
                format!("with its curves, more than {MOST_TRIANGLES} triangles would take the place of curves"),
            ),
            Err(TubeError::Memory(shortage)) => {
                messages.left_out("shape", name, format!("tubes in place of its curves need {shortage}"));
            }
        }
        tubes.ok().map(Arc::new)
    }

    fn mesh_of_file(
        &mut self,
        file: &crate::scene::MeshFile,
        name: &str,
        messages: &mut Messages,
    ) -> Option<Arc<MeshData>> {
        if !self.files.contains_key(&file.path) {
            let loaded = load_mesh(&file.path, self.access);
            if let Err(error) = &loaded {
                messages.left_out("shape", name, format!("{}: {error}", file.path.display()));
            }
            self.files.insert(file.path.clone(), loaded.ok());
        }
        let mesh = self.files[&file.path].as_ref()?.data(file.shape_index)?;
        // Meshes of files are flipped already if that is the default of their format.
        match file.flip_tex_coords == file.format.flips_tex_coords() {
            true => Some(mesh.clone()),
            false => mesh.with_flipped_tex_coords().ok().map(Arc::new),
        }
    }
}

/// The vertices of a form as they are written; the winding of triangles does not change.
pub(super) fn shown(form: &Form, baked: Option<Affine3A>, is_turned: bool, is_unwelded: bool) -> MeshData {
    let source = &form.mesh;
    let all: Vec<usize> = match is_unwelded {
        true => source
            .triangles
            .as_flattened()
            .iter()
            .map(|vertex| *vertex as usize)
            .collect(),
        false => (0..source.positions.len()).collect(),
    };
    let map = baked.unwrap_or(Affine3A::IDENTITY);
    let for_normals = map.matrix3.inverse().transpose();
    let side = if is_turned { -1.0 } else { 1.0 };
    let place = |vertex: &usize| match baked {
        Some(map) => map.transform_point3(source.positions[*vertex]),
        None => source.positions[*vertex],
    };
    let normal = |vertex: &usize| match baked {
        Some(_) => side * (for_normals * source.normals[*vertex]).normalize_or(Vec3::Z),
        None => side * source.normals[*vertex],
    };
    let has_normals = !form.is_flat && !source.normals.is_empty();
    MeshData {
        positions: all.iter().map(place).collect(),
        normals: if has_normals {
            all.iter().map(normal).collect()
        } else {
            Vec::new()
        },
        uvs: match source.uvs.is_empty() {
            true => Vec::new(),
            false => all.iter().map(|vertex| source.uvs[*vertex]).collect(),
        },
        ..MeshData::default()
    }
}

/// Whether the colours belong to triangles, so that triangles may not share vertices.
pub(super) fn is_of_triangles(mesh: &MeshData, colors: &Colors) -> bool {
    let attribute = colors.as_ref().and_then(|(name, _)| mesh.attribute(name));
    attribute.is_some_and(|attribute| attribute.domain == AttributeDomain::Triangle)
}

/// The colours of the vertices given by [`shown`].
pub(super) fn vertex_colors(mesh: &MeshData, (name, scale): &(String, f32), is_unwelded: bool) -> Vec<[f32; 3]> {
    let Some(attribute) = mesh.attribute(name) else {
        return Vec::new();
    };
    let mut colors = vec![
        [0.0; 3];
        if is_unwelded {
            3 * mesh.triangles.len()
        } else {
            mesh.positions.len()
        }
    ];
    let corners = [Vec3::X, Vec3::Y, Vec3::Z];
    for (number, triangle) in mesh.triangles.iter().enumerate() {
        for (corner, at) in corners.into_iter().enumerate() {
            let value = *scale * attribute.value(&mesh.triangles, number as u32, at);
            let place = if is_unwelded {
                3 * number + corner
            } else {
                triangle[corner] as usize
            };
            colors[place] = value.clamp(Vec3::ZERO, Vec3::ONE).to_array();
        }
    }
    colors
}
