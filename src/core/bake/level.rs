//! Gives the meshes of an unfinished glTF file a place in lightmaps.
//!
//! Meshes that move, are clear as glass, have no diffuse reflection, or have no area get none. A two-sided surface is
//! baked on the side that light reaches; if light reaches both, each side becomes a surface of its own. Nodes whose
//! meshes have the same size in the world share a mesh and get rectangles of their own.

use std::collections::HashMap;
use std::sync::atomic::AtomicBool;

use glam::{Affine3A, Mat3A, UVec2, Vec2, Vec3};
use rayon::prelude::*;
use serde::Serialize;

use super::texels::BakeSurface;
use super::unwrap::{Layout, LayoutMesh, LayoutRectangle, Told, UnwrapError, UnwrapMesh, UnwrapSettings, unwrap};
use crate::gltf::write::material::Material;
use crate::gltf::write::model::{Mesh, Primitive};
use crate::gltf::write::{GltfWriteError, GltfWriter, PlacedMesh};

/// A level that is laid out in lightmaps.
#[derive(Debug)]
pub struct BakeLevel {
    /// Width and height of each lightmap.
    pub size: UVec2,
    /// The number of lightmaps.
    pub pages: u32,
    /// Texels per unit of length.
    pub texels_per_unit: f32,
    /// The nodes with a place in a lightmap.
    pub nodes: Vec<BakedNode>,
    /// Their surfaces, one for each node.
    pub surfaces: Vec<BakeSurface>,
    /// The layout, which holds its memory reservation as long as the level lives.
    pub layout: Layout,
}

/// A node of the file with its place in a lightmap.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct BakedNode {
    /// The index of the node.
    pub node: usize,
    /// The names of its ancestors and of the node itself, joined by `/`.
    pub path: String,
    /// The index of the lightmap.
    pub lightmap: u32,
    /// The rectangle of the lightmap that the second texture coordinates of the mesh span: left, top, right and
    /// bottom, in [0, 1].
    pub rect: [f32; 4],
}

/// The reason why a level cannot be baked.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs, reason = "the messages say what the variants mean")]
pub enum LevelError {
    #[error(transparent)]
    Unwrap(#[from] UnwrapError),
    #[error("`{name}`: {source}")]
    Mesh { name: String, source: GltfWriteError },
}

/// The sides of a mesh that are baked.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Sides {
    /// The side from which the corners of triangles are counter-clockwise.
    Front,
    /// The back.
    Back,
    /// Both sides, each as a surface of its own.
    Both,
}

/// The mesh parts that may share a layout: they have the same sides and the same size in the world.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
struct Key {
    mesh: usize,
    /// The rounded lengths and angles of the axes with which it is laid out.
    shape: [i64; 6],
    sides: Sides,
}

/// A mesh to be unwrapped, with its instances in the world.
struct Group {
    mesh: usize,
    sides: Sides,
    places: Vec<PlacedMesh>,
    sheets: Vec<Sheet>,
    input: UnwrapMesh,
}

/// One side of a primitive within a group.
#[derive(Clone, Copy)]
struct Sheet {
    primitive: usize,
    is_back: bool,
    /// The first of its vertices and the first of its triangles in the group.
    first_vertex: u32,
    first_triangle: usize,
    triangles: usize,
}

/// Gives the meshes of `writer` second texture coordinates, and returns their layout. `lit` gets the corners of the
/// triangles of a surface in the world, and returns whether light reaches the front and the back. It fails after
/// `cancel` is set, and reports its progress as [`unwrap`] does.
pub fn unwrap_level(
    writer: &mut GltfWriter,
    settings: &UnwrapSettings,
    lit: impl Fn(&[[Vec3; 3]]) -> (bool, bool) + Sync,
    cancel: &AtomicBool,
    told: Told,
) -> Result<BakeLevel, LevelError> {
    let mut groups: Vec<Group> = Vec::new();
    let mut known: HashMap<Key, usize> = HashMap::new();
    let is_baked = |placed: &PlacedMesh| {
        let parts = &writer.mesh(placed.mesh).primitives;
        !placed.moves && placed.lightmap_scale > 0.0 && parts.iter().any(|part| takes_light(writer, part))
    };
    let placed: Vec<PlacedMesh> = writer.placed_meshes().into_iter().filter(is_baked).collect();
    let sides: Vec<Sides> = placed.par_iter().map(|placed| sides(writer, placed, &lit)).collect();
    for (placed, sides) in placed.into_iter().zip(sides) {
        let key = Key {
            mesh: placed.mesh,
            shape: shape(&layout_axes(&placed)),
            sides,
        };
        let group = *known.entry(key).or_insert_with(|| {
            groups.push(Group::new(writer, &placed, key.sides));
            groups.len() - 1
        });
        groups[group].places.push(placed);
        groups[group].input.places += 1;
    }
    groups.retain(|group| group.input.has_surface());
    let mut inputs: Vec<UnwrapMesh> = groups
        .iter_mut()
        .map(|group| std::mem::take(&mut group.input))
        .collect();
    let mut layout = unwrap(&inputs, settings, cancel, told)?;
    let meshes = std::mem::take(&mut layout.meshes);
    let (mut nodes, mut surfaces) = (Vec::new(), Vec::new());
    for ((group, input), mut mesh) in groups.iter().zip(inputs.drain(..)).zip(meshes) {
        settle(&mut mesh);
        group.write(writer, &mesh).map_err(|source| LevelError::Mesh {
            name: input.name.clone(),
            source,
        })?;
        let new_mesh = writer.mesh_count() - 1;
        for (placed, rectangle) in group.places.iter().zip(&mesh.rectangles) {
            let node = BakedNode {
                node: placed.node,
                path: placed.path.clone(),
                lightmap: rectangle.page,
                rect: [rectangle.min.x, rectangle.min.y, rectangle.max.x, rectangle.max.y],
            };
            let extras = serde_json::json!({ "sunroom_lightmap": { "lightmap": node.lightmap, "rect": node.rect } });
            writer.replace_mesh(placed.node, new_mesh, extras);
            surfaces.push(group.surface(writer, placed, &mesh, rectangle, layout.size));
            nodes.push(node);
        }
    }
    writer.drop_unused_meshes();
    Ok(BakeLevel {
        size: layout.size,
        pages: layout.pages,
        texels_per_unit: layout.texels_per_unit,
        nodes,
        surfaces,
        layout,
    })
}

/// Whether a part of a mesh reflects light diffusely.
fn takes_light(writer: &GltfWriter, part: &Primitive) -> bool {
    let Some(material) = part.material.map(|material| writer.material(material)) else {
        return true;
    };
    let pbr = &material.pbr_metallic_roughness;
    let is_metal = pbr.metallic_factor >= 1.0 && pbr.metallic_roughness_texture.is_none();
    let is_black = pbr.base_color_factor[..3] == [0.0; 3];
    let is_glass = material
        .extensions
        .transmission
        .as_ref()
        .is_some_and(|glass| glass.transmission_factor >= 1.0 && glass.transmission_texture.is_none());
    !(is_metal || is_black || is_glass)
}

/// The axes in the size in which a mesh is laid out: its size in the world, times its lightmap scale.
fn layout_axes(placed: &PlacedMesh) -> Mat3A {
    placed.world_from_mesh.matrix3 * placed.lightmap_scale
}

/// The lengths and angles of axes, rounded so that equal numbers mean equal sizes to four digits.
fn shape(axes: &Mat3A) -> [i64; 6] {
    let [x, y, z] = [axes.x_axis, axes.y_axis, axes.z_axis].map(|axis| axis.as_dvec3());
    let lengths = [x, y, z].map(|axis| axis.length());
    let angle =
        |a: glam::DVec3, b: glam::DVec3| (a.normalize_or_zero().dot(b.normalize_or_zero()) * 1e4).round() as i64;
    let [of_x, of_y, of_z] = lengths.map(|length| (length.max(1e-300).ln() * 1e4).round() as i64);
    [of_x, of_y, of_z, angle(x, y), angle(y, z), angle(z, x)]
}

/// The sides of a mesh that are to be baked at its place.
fn sides(writer: &GltfWriter, placed: &PlacedMesh, lit: &impl Fn(&[[Vec3; 3]]) -> (bool, bool)) -> Sides {
    let mut triangles = Vec::new();
    for part in &writer.mesh(placed.mesh).primitives {
        let is_two_sided = part
            .material
            .is_some_and(|material| writer.material(material).double_sided);
        if is_two_sided && takes_light(writer, part) {
            let places = writer.vectors::<3>(part.attributes["POSITION"]);
            let is_mirrored = placed.world_from_mesh.matrix3.determinant() < 0.0;
            triangles.extend(writer.triangles(part).iter().map(|corners| {
                let corner = |corner: u32| placed.world_from_mesh.transform_point3(places[corner as usize].into());
                let [a, b, c] = corners.map(corner);
                if is_mirrored { [a, c, b] } else { [a, b, c] }
            }));
        }
    }
    if triangles.is_empty() {
        return Sides::Front;
    }
    match lit(&triangles) {
        (true, true) => Sides::Both,
        (false, true) => Sides::Back,
        _ => Sides::Front,
    }
}

/// Gives a mesh with a single instance its final coordinates, for programs that do not read rectangles.
fn settle(mesh: &mut LayoutMesh) {
    let [rectangle] = &mut mesh.rectangles[..] else {
        return;
    };
    let (min, extent) = (rectangle.min, rectangle.max - rectangle.min);
    for at in &mut mesh.coordinates {
        *at = min + *at * extent;
    }
    (rectangle.min, rectangle.max) = (Vec2::ZERO, Vec2::ONE);
}

impl Group {
    fn new(writer: &GltfWriter, placed: &PlacedMesh, sides: Sides) -> Self {
        let mesh = writer.mesh(placed.mesh);
        let mut group = Self {
            mesh: placed.mesh,
            sides,
            places: Vec::new(),
            sheets: Vec::new(),
            input: UnwrapMesh {
                name: placed.path.clone(),
                ..UnwrapMesh::default()
            },
        };
        let in_size = Affine3A {
            matrix3: layout_axes(placed),
            ..Affine3A::IDENTITY
        };
        for (index, part) in mesh.primitives.iter().enumerate() {
            if !takes_light(writer, part) {
                continue;
            }
            let is_two_sided = part
                .material
                .is_some_and(|material| writer.material(material).double_sided);
            let places = writer.vectors::<3>(part.attributes["POSITION"]);
            let triangles = writer.triangles(part);
            let sheets: &[bool] = match sides {
                Sides::Both if is_two_sided => &[false, true],
                Sides::Back if is_two_sided => &[true],
                _ => &[false],
            };
            for &is_back in sheets {
                let input = &mut group.input;
                let sheet = Sheet {
                    primitive: index,
                    is_back,
                    first_vertex: input.positions.len() as u32,
                    first_triangle: input.triangles.len(),
                    triangles: triangles.len(),
                };
                let sized = || places.iter().map(|place| in_size.transform_point3((*place).into()));
                let extent = sized().fold(0.0f32, |extent, place| extent.max(place.abs().max_element()));
                // Front and back lie apart, so that no edge has four triangles. Only the layout uses these positions.
                let aside = match is_back && sheets.len() == 2 {
                    true => Vec3::X * 4.0 * extent,
                    false => Vec3::ZERO,
                };
                input.positions.extend(sized().map(|place| place + aside));
                let numbered = triangles.iter().map(|corners| {
                    let [a, b, c] = corners.map(|corner| sheet.first_vertex + corner);
                    if is_back { [a, c, b] } else { [a, b, c] }
                });
                input.triangles.extend(numbered);
                let part = group.sheets.len() as u32;
                input.part_of_triangle.resize(input.triangles.len(), part);
                group.sheets.push(sheet);
            }
        }
        group
    }

    /// Whether both sides exist, so that each is visible from its own side only.
    fn is_parted(&self, sheet: &Sheet) -> bool {
        let same = self.sheets.iter().filter(|other| other.primitive == sheet.primitive);
        self.sides == Sides::Both && same.count() == 2
    }

    /// Adds the mesh with its second texture coordinates.
    fn write(&self, writer: &mut GltfWriter, layout: &LayoutMesh) -> Result<(), GltfWriteError> {
        let Mesh { name, primitives } = writer.mesh(self.mesh).clone();
        let is_baked = |index: usize| self.sheets.iter().any(|sheet| sheet.primitive == index);
        let mut new: Vec<Primitive> = Vec::new();
        for sheet in &self.sheets {
            let old = &primitives[sheet.primitive];
            let mut vertices: Vec<u32> = Vec::new();
            let mut number_of: HashMap<u32, u32> = HashMap::new();
            let range = sheet.first_triangle..sheet.first_triangle + sheet.triangles;
            let triangles: Vec<[u32; 3]> = layout.triangles[range]
                .iter()
                .map(|corners| {
                    let corners = corners.map(|vertex| {
                        *number_of.entry(vertex).or_insert_with(|| {
                            vertices.push(vertex);
                            vertices.len() as u32 - 1
                        })
                    });
                    // A back that is the only side keeps the winding of the front: its material is two-sided.
                    let [a, b, c] = corners;
                    let is_turned = sheet.is_back && !self.is_parted(sheet);
                    if is_turned { [a, c, b] } else { corners }
                })
                .collect();
            let chosen: Vec<u32> = vertices
                .iter()
                .map(|vertex| layout.vertices[*vertex as usize] - sheet.first_vertex)
                .collect();
            let is_turned = sheet.is_back && self.is_parted(sheet);
            let mut attributes = writer.add_chosen_vertices(&old.attributes, &chosen, is_turned);
            let coordinates: Vec<[f32; 2]> = vertices
                .iter()
                .map(|vertex| layout.coordinates[*vertex as usize].to_array())
                .collect();
            writer.add_coordinates(&mut attributes, "TEXCOORD_1", &coordinates);
            // The sets of texture coordinates are numbered without gaps (glTF 2.0, section 3.7.2.1).
            if !attributes.contains_key("TEXCOORD_0") {
                let lightmap = attributes["TEXCOORD_1"];
                attributes.insert("TEXCOORD_0".to_owned(), lightmap);
            }
            let indices = writer.add_triangles(&triangles, vertices.len())?;
            let material = match self.is_parted(sheet) {
                true => old.material.map(|material| one_sided(writer, material, sheet.is_back)),
                false => old.material,
            };
            new.push(Primitive {
                attributes,
                indices,
                material,
            });
        }
        let others = primitives.iter().enumerate().filter(|(index, _)| !is_baked(*index));
        new.extend(others.map(|(_, primitive)| primitive.clone()));
        writer.add_mesh(Mesh { name, primitives: new });
        Ok(())
    }

    /// The surface of one instance in the world.
    fn surface(
        &self,
        writer: &GltfWriter,
        placed: &PlacedMesh,
        layout: &LayoutMesh,
        rectangle: &LayoutRectangle,
        size: UVec2,
    ) -> BakeSurface {
        let world = placed.world_from_mesh;
        let is_mirrored = world.matrix3.determinant() < 0.0;
        let for_normals = world.matrix3.inverse().transpose();
        let old = &writer.mesh(self.mesh).primitives;
        let sheets = self.sheets.iter();
        let mut places: Vec<Vec3> = Vec::new();
        let mut normals: Vec<Option<Vec3>> = Vec::new();
        for sheet in sheets {
            let attributes = &old[sheet.primitive].attributes;
            let own = writer.vectors::<3>(attributes["POSITION"]);
            let side = if sheet.is_back { -1.0 } else { 1.0 };
            match attributes.get("NORMAL") {
                Some(accessor) => normals.extend(
                    writer
                        .vectors::<3>(*accessor)
                        .into_iter()
                        .map(|normal| Some(side * (for_normals * Vec3::from(normal)).normalize_or_zero())),
                ),
                None => normals.resize(places.len() + own.len(), None),
            }
            places.extend(own.into_iter().map(|place| world.transform_point3(place.into())));
        }
        let extent = rectangle.max - rectangle.min;
        let mut surface = BakeSurface {
            page: rectangle.page,
            positions: layout.vertices.iter().map(|vertex| places[*vertex as usize]).collect(),
            normals: Vec::new(),
            coordinates: layout
                .coordinates
                .iter()
                .map(|at| (rectangle.min + *at * extent) * size.as_vec2())
                .collect(),
            triangles: layout
                .triangles
                .iter()
                .map(|&[a, b, c]| if is_mirrored { [a, c, b] } else { [a, b, c] })
                .collect(),
        };
        surface.normals = layout
            .vertices
            .iter()
            .map(|vertex| normals[*vertex as usize].unwrap_or_default())
            .collect();
        surface
    }
}

/// The one-sided variant of a material.
fn one_sided(writer: &mut GltfWriter, material: usize, is_back: bool) -> usize {
    let mut material = Material {
        double_sided: false,
        ..writer.material(material).clone()
    };
    if is_back && material.shines_from_front {
        material.emissive_factor = Default::default();
        material.emissive_texture = None;
        material.extensions.emissive_strength = None;
    }
    writer.add_material(material)
}
