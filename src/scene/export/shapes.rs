//! Exports shapes as nodes with meshes. Shapes of one form and material share a mesh, and all of one form share its
//! vertices.

use std::collections::{BTreeSet, HashMap};
use std::path::PathBuf;
use std::rc::Rc;

use super::error::ExportError;
use super::extras::set_extras;
use super::form::{Colors, Form, Forms, is_of_triangles, shown, vertex_colors};
use super::materials::{Materials, Surface, Written, shows_its_back};
use super::messages::Messages;
use super::motion::{Motion, placed};
use super::placing::{Placing, Side, is_mirrored, key_of, pose_or_baked};
use super::poses::Folders;
use super::tangents;
use crate::files::Access;
use crate::gltf::write::model::{Attributes, Mesh, Node, Primitive};
use crate::gltf::write::{GltfWriteError, GltfWriter};
use crate::math::is_invertible;
use crate::scene::components::description::{SceneDescription, ShapeDescription};
use crate::scene::{AreaLight, ShapeKind};

/// Writes shapes.
pub(super) struct Shapes<'a> {
    pub scene: &'a SceneDescription,
    pub materials: Materials<'a>,
    pub(super) forms: Forms<'a>,
    /// The attributes by the key of their vertices.
    vertices: HashMap<String, Attributes>,
    /// The indices by their key; None for no triangles.
    triangles: HashMap<String, Option<usize>>,
    /// The accessors of tangents by their key; None for no tangents.
    tangents: HashMap<String, Option<usize>>,
    /// For each triangle whether pictures are mirrored on it, by key.
    mirrored: HashMap<String, Rc<[bool]>>,
    meshes: HashMap<String, usize>,
    /// The meshes of groups, by the group, whether its instances mirror them, and the coordinates that its members have
    /// by box projection; None for groups without visible shapes.
    pub(super) groups: HashMap<(usize, bool, Vec<Option<String>>), Option<usize>>,
    /// The members of each group.
    pub(super) members: Vec<Vec<usize>>,
}

impl<'a> Shapes<'a> {
    pub fn new(scene: &'a SceneDescription, is_baked: bool, access: &'a Access) -> Self {
        let mut members = vec![Vec::new(); scene.groups.len()];
        for (index, shape) in scene.shapes.iter().enumerate() {
            if let Some(group) = shape.member_of {
                members[group].push(index);
            }
        }
        Self {
            scene,
            materials: Materials::new(scene, is_baked, access),
            forms: Forms::new(access),
            vertices: HashMap::new(),
            triangles: HashMap::new(),
            tangents: HashMap::new(),
            mirrored: HashMap::new(),
            meshes: HashMap::new(),
            groups: HashMap::new(),
            members,
        }
    }

    /// The pictures named by the materials of mesh files, including those of shapes that were not written.
    pub fn pictures_of_libraries(&mut self) -> BTreeSet<PathBuf> {
        let shapes = self.scene.shapes.iter();
        shapes.flat_map(|shape| self.forms.pictures_of_file(shape)).collect()
    }

    /// Adds a shape of the world.
    pub fn write(
        &mut self,
        shape: &ShapeDescription,
        writer: &mut GltfWriter,
        folders: &mut Folders,
        messages: &mut Messages,
    ) -> Result<(), ExportError> {
        if let Some(group) = shape.instance_of {
            return self.write_instances(shape, group, writer, folders, messages);
        }
        let name = &*shape.identity.name;
        let Some(form) = self.forms.laid(self.scene, shape, None, messages) else {
            return Ok(());
        };
        let world = shape.to_world * form.shape_from_mesh;
        if !is_invertible(&world) {
            messages.left_out("shape", name, "the transform cannot be inverted");
            return Ok(());
        }
        let branch = folders.branch(name, writer);
        let parent_from_world = branch.world_from_parent.inverse();
        let local = parent_from_world * world;
        let (pose, baked) = pose_or_baked(&local);
        let is_turned = shape.shape.flip_normals ^ (is_mirrored(&world) && form.turns_with_mirrors());
        let placing = Placing {
            baked,
            is_turned,
            is_mirrored: is_mirrored(if baked.is_some() {
                &branch.world_from_parent
            } else {
                &world
            }),
        };
        let primitives = self.primitives(shape, &form, placing, true, writer, messages)?;
        if primitives.is_empty() {
            messages.left_out("shape", name, "light passes it as if there was nothing");
            return Ok(());
        }
        let mesh = self.mesh(primitives, &branch.leaf, writer);
        let node = Node {
            name: branch.leaf,
            pose,
            mesh: Some(mesh),
            order: Some(shape.identity.order),
            lightmap_scale: Some(shape.shape.scale_of_lightmap()),
            ..Node::default()
        };
        let node = writer.add_node(node, branch.parent);
        set_extras(writer, node, shape.identity.properties.as_ref());
        if let Some(keys) = &shape.identity.keys {
            if baked.is_some() {
                messages.note("shape", name, "nothing moves, because the pose shears");
                return Ok(());
            }
            let shape_from_mesh = form.shape_from_mesh;
            let local = |value: &crate::document::Value| Some(parent_from_world * placed(value)? * shape_from_mesh);
            let motion = Motion { keys, local: &local };
            motion.write(node, "shape", name, writer, messages);
        }
        Ok(())
    }

    /// The mesh of these primitives.
    fn mesh(&mut self, primitives: Vec<Primitive>, name: &str, writer: &mut GltfWriter) -> usize {
        let key = format!("{primitives:?}");
        if let Some(known) = self.meshes.get(&key) {
            return *known;
        }
        let name = name.to_owned();
        let mesh = writer.add_mesh(Mesh { name, primitives });
        self.meshes.insert(key, mesh);
        mesh
    }

    /// The primitives of a shape, one for each visible material, or two if pictures are mirrored on a part of a shape
    /// with a normal map.
    pub(super) fn primitives(
        &mut self,
        shape: &ShapeDescription,
        form: &Form,
        placing: Placing,
        may_shine: bool,
        writer: &mut GltfWriter,
        messages: &mut Messages,
    ) -> Result<Vec<Primitive>, ExportError> {
        let name = &*shape.identity.name;
        let path = match &shape.shape.kind {
            ShapeKind::Mesh(file) => Some(file.path.as_path()),
            _ => None,
        };
        let slots = form.mesh.materials.len().max(1);
        let slots = if shape.material.is_none() { slots } else { 1 };
        let mut light: Option<&AreaLight> = shape.area_light.as_ref();
        if !may_shine && light.take().is_some() {
            messages.note("shape", name, "a shape of a group cannot be a light");
        }
        let fails = |source: GltfWriteError| ExportError::Shape {
            name: name.to_owned(),
            source,
        };
        let interior = shape.interior.filter(|_| self.scene.integrator.plugin.traces_media());
        let exterior = shape.exterior.filter(|_| self.scene.integrator.plugin.traces_media());
        if let Some(medium) = exterior.and_then(|medium| self.scene.media.get(medium)) {
            messages.left_out("medium", &medium.identity.name, "glTF has no medium around shapes");
        }
        let mut primitives = Vec::new();
        for slot in 0..slots {
            let mtl = form.mesh.materials.get(slot).filter(|_| shape.material.is_none());
            let mut surface = Surface {
                shape: name,
                material: shape.material,
                of_file: path.zip(mtl).map(|(path, mtl)| (path, slot, mtl)),
                light,
                interior,
                is_mirrored: false,
            };
            let normal_map = self.materials.normal_map(&surface, messages);
            let parts = match normal_map {
                Some(gltf_tangents) => self.sides(form, &placing, gltf_tangents),
                None => vec![Side::All],
            };
            for part in parts {
                // A mirroring pose flips shading frames as well as the handedness of texture coordinates.
                surface.is_mirrored = part.is_mirrored() != placing.is_mirrored;
                let (index, colors, turns) = match self.materials.write(&surface, writer, messages) {
                    Written::Nothing => {
                        if let Some(medium) = interior.and_then(|medium| self.scene.media.get(medium)) {
                            messages.left_out("medium", &medium.identity.name, "only glass is filled in glTF");
                        }
                        continue;
                    }
                    Written::Material {
                        index,
                        colors,
                        is_one_sided,
                        is_inside_out,
                    } => {
                        if is_inside_out && let Some(medium) = interior.and_then(|medium| self.scene.media.get(medium))
                        {
                            let why = "the inner side of a surface in glTF is the denser one";
                            messages.left_out("medium", &medium.identity.name, why);
                        }
                        if is_one_sided && shows_its_back(&shape.shape.kind) {
                            let what = "the back, which is black here, looks like the front when the file is imported";
                            messages.note("shape", name, what);
                        }
                        (index, colors, is_inside_out)
                    }
                };
                // Triangles with a zero area in uv are on the same side before and after the flip.
                let chosen = (placing, part);
                let placing = Placing {
                    is_turned: placing.is_turned ^ turns,
                    ..placing
                };
                // Seen from the other side, pictures are mirrored.
                let part = if turns { part.turned() } else { part };
                let colors = self.known_colors(form, colors, name, messages);
                let is_unwelded = is_of_triangles(&form.mesh, &colors);
                let indices = self.indices(form, (slot, slots), &placing, is_unwelded, chosen, writer);
                let Some(indices) = indices.map_err(fails)? else {
                    continue;
                };
                let attributes = self.attributes(form, &placing, &colors, is_unwelded, writer);
                let mut attributes = attributes.map_err(fails)?;
                if normal_map.is_some() {
                    self.add_tangents(form, &placing, is_unwelded, part, &mut attributes, writer);
                }
                primitives.push(Primitive {
                    attributes,
                    indices,
                    material: Some(index),
                });
            }
        }
        Ok(primitives)
    }

    /// The vertices of a form, which are written once for all shapes that use them in the same way.
    fn attributes(
        &mut self,
        form: &Form,
        placing: &Placing,
        colors: &Colors,
        is_unwelded: bool,
        writer: &mut GltfWriter,
    ) -> Result<Attributes, GltfWriteError> {
        let key = format!("{} {colors:?}", key_of(form, placing, is_unwelded));
        if let Some(known) = self.vertices.get(&key) {
            return Ok(known.clone());
        }
        let mesh = shown(form, placing.baked, placing.is_turned, is_unwelded);
        let values = colors.as_ref();
        let values = values.map(|colors| vertex_colors(&form.mesh, colors, is_unwelded));
        let attributes = writer.add_vertices(&mesh, values.as_deref())?;
        self.vertices.insert(key, attributes.clone());
        Ok(attributes)
    }

    /// The sides of a form with a normal map that need tangents of their own.
    fn sides(&mut self, form: &Form, placing: &Placing, gltf_tangents: bool) -> Vec<Side> {
        if gltf_tangents && tangents::of_mesh(form, None, false, false).is_some() {
            return vec![Side::All];
        }
        let mirrored = self.mirrored(form, placing, false);
        let has = |side: bool| mirrored.contains(&side);
        let sides = [(false, Side::Upright), (true, Side::Mirrored)].into_iter();
        sides.filter(|(side, _)| has(*side)).map(|(_, part)| part).collect()
    }

    /// For each triangle whether its picture is mirrored, as the triangle is written.
    fn mirrored(&mut self, form: &Form, placing: &Placing, is_unwelded: bool) -> Rc<[bool]> {
        let key = key_of(form, placing, is_unwelded);
        let known = self.mirrored.entry(key).or_insert_with(|| {
            let mesh = shown(form, placing.baked, placing.is_turned, is_unwelded);
            let corners = tangents::written_corners(form, is_unwelded, placing.runs_backwards());
            tangents::mirrored(&mesh, corners).into()
        });
        known.clone()
    }

    fn add_tangents(
        &mut self,
        form: &Form,
        placing: &Placing,
        is_unwelded: bool,
        part: Side,
        attributes: &mut Attributes,
        writer: &mut GltfWriter,
    ) {
        let key = format!("{} {part:?}", key_of(form, placing, is_unwelded));
        if let Some(known) = self.tangents.get(&key) {
            attributes.extend(known.map(|accessor| ("TANGENT".to_owned(), accessor)));
            return;
        }
        let values = match part {
            Side::All => tangents::of_mesh(form, placing.baked, placing.is_turned, is_unwelded),
            Side::Upright | Side::Mirrored => {
                let mirrored = self.mirrored(form, placing, is_unwelded);
                let mesh = shown(form, placing.baked, placing.is_turned, is_unwelded);
                let corners = tangents::written_corners(form, is_unwelded, placing.runs_backwards());
                tangents::of_coordinates(&mesh, corners, &mirrored, part.is_mirrored())
            }
        };
        let values: Option<Vec<[f32; 4]>> = values.map(|values| values.iter().map(|value| value.to_array()).collect());
        if let Some(values) = values {
            writer.add_tangents(attributes, &values);
        }
        self.tangents.insert(key, attributes.get("TANGENT").copied());
    }

    /// The triangles of one of `slots` material slots that belong to a side under the placing `chosen`; None if there
    /// are none.
    fn indices(
        &mut self,
        form: &Form,
        (slot, slots): (usize, usize),
        placing: &Placing,
        is_unwelded: bool,
        (chosen, part): (Placing, Side),
        writer: &mut GltfWriter,
    ) -> Result<Option<usize>, GltfWriteError> {
        let runs_backwards = placing.runs_backwards();
        let sides = match part {
            Side::All => None,
            Side::Upright | Side::Mirrored => Some(self.mirrored(form, &chosen, is_unwelded)),
        };
        // Whether a triangle is mirrored depends only on the form and on the side of the normals.
        let of_part = sides.as_ref().map(|_| (part, chosen.is_turned));
        let key = format!("{} {is_unwelded} {runs_backwards} {slot} {slots} {of_part:?}", form.key);
        if let Some(known) = self.triangles.get(&key) {
            return Ok(*known);
        }
        let mesh = &form.mesh;
        let slot_of = |triangle: usize| mesh.material_of_triangle.get(triangle).copied().map_or(0, usize::from);
        let is_here = |triangle: usize| {
            (slots == 1 || slot_of(triangle) == slot)
                && sides.as_ref().is_none_or(|sides| sides[triangle] == part.is_mirrored())
        };
        let corners = tangents::written_corners(form, is_unwelded, runs_backwards).enumerate();
        let here = corners.filter(|(triangle, _)| is_here(*triangle));
        let triangles: Vec<[u32; 3]> = here.map(|(_, corners)| corners).collect();
        let vertices = match is_unwelded {
            true => 3 * mesh.triangles.len(),
            false => mesh.positions.len(),
        };
        let indices = match triangles.is_empty() {
            true => None,
            false => Some(writer.add_triangles(&triangles, vertices)?),
        };
        self.triangles.insert(key, indices);
        Ok(indices)
    }

    /// The colours, if the mesh has them.
    fn known_colors(&self, form: &Form, colors: Colors, name: &str, messages: &mut Messages) -> Colors {
        let (attribute, scale) = colors?;
        if form.mesh.attribute(&attribute).is_none() {
            messages.note(
                "shape",
                name,
                format!("the mesh has no values `{attribute}`, which the material asks for"),
            );
            return None;
        }
        Some((attribute, scale))
    }
}
