//! Exports groups: nodes that share a mesh, or several if box projections lay textures differently on the instances.

use bevy::math::Affine3A;

use super::error::ExportError;
use super::extras::set_extras;
use super::messages::Messages;
use super::motion::{Motion, placed};
use super::placing::{Placing, is_mirrored, pose_or_baked};
use super::poses::Folders;
use super::shapes::Shapes;
use crate::gltf::write::GltfWriter;
use crate::gltf::write::model::{Mesh, Node};
use crate::math::is_invertible;
use crate::scene::assets::box_lying::has_projection;
use crate::scene::components::description::ShapeDescription;

/// The most meshes of a group whose instances differ in the coordinates that box projections give them.
const MOST_VARIANTS: usize = 64;

impl Shapes<'_> {
    /// Adds the instances of a group: nodes with one mesh.
    pub(super) fn write_instances(
        &mut self,
        shape: &ShapeDescription,
        group: usize,
        writer: &mut GltfWriter,
        folders: &mut Folders,
        messages: &mut Messages,
    ) -> Result<(), ExportError> {
        let name = &*shape.identity.name;
        let branch = folders.branch(name, writer);
        let parent_from_world = branch.world_from_parent.inverse();
        let places: Vec<Affine3A> = match &shape.placements {
            Some(placements) => placements.places.iter().map(|place| Affine3A::from(*place)).collect(),
            None => vec![shape.to_world],
        };
        let is_of_curves = |&member: &usize| self.scene.shapes[member].shape.is_of_curves();
        let lightmap_scale = match self.members[group].iter().any(is_of_curves) {
            true => 0.0,
            false => shape.shape.lightmap_scale,
        };
        let is_crowd = shape.placements.is_some();
        let keys = shape.identity.keys.as_ref().filter(|_| !is_crowd);
        if is_crowd && shape.identity.keys.is_some() {
            messages.note("shape", name, "nothing moves, because these are many instances in one");
        }
        let mut parent = branch.parent;
        if is_crowd {
            let node = Node {
                name: branch.leaf.clone(),
                ..Node::default()
            };
            parent = Some(writer.add_node(node, parent));
        }
        for (number, world) in places.into_iter().enumerate() {
            if !is_invertible(&world) {
                messages.left_out("shape", name, "the transform cannot be inverted");
                continue;
            }
            let (pose, baked) = pose_or_baked(&(parent_from_world * world));
            let Some(mesh) = self.group_mesh(group, &world, baked, writer, messages)? else {
                messages.left_out("shape", name, "light passes it as if there was nothing");
                return Ok(());
            };
            let leaf = &branch.leaf;
            let node = Node {
                name: if is_crowd {
                    format!("{leaf}-{}", number + 1)
                } else {
                    leaf.clone()
                },
                pose,
                mesh: Some(mesh),
                lightmap_scale: Some(lightmap_scale),
                ..Node::default()
            };
            let node = writer.add_node(node, parent);
            set_extras(writer, node, shape.identity.properties.as_ref());
            match keys {
                Some(keys) if baked.is_none() => {
                    let local = |value: &crate::document::Value| Some(parent_from_world * placed(value)?);
                    let motion = Motion { keys, local: &local };
                    motion.write(node, "shape", name, writer, messages);
                }
                Some(_) => messages.note("shape", name, "nothing moves, because the pose shears"),
                None => {}
            }
        }
        Ok(())
    }

    /// The mesh of a group in an instance; None if it has no visible shapes.
    fn group_mesh(
        &mut self,
        group: usize,
        placement: &Affine3A,
        baked: Option<Affine3A>,
        writer: &mut GltfWriter,
        messages: &mut Messages,
    ) -> Result<Option<usize>, ExportError> {
        let scene = self.scene;
        let members: Vec<_> = self.members[group]
            .iter()
            .map(|&member| &scene.shapes[member])
            .collect();
        let is_mirrored_place = is_mirrored(placement);
        let key = (group, is_mirrored_place, self.boxes_of(&members, placement, messages));
        if let Some(known) = self.groups.get(&key).filter(|_| baked.is_none()) {
            return Ok(*known);
        }
        let mut like = self.groups.iter();
        let mut like = like
            .by_ref()
            .filter(|((other, side, _), _)| (*other, *side) == (group, is_mirrored_place));
        if let Some((_, known)) = like.nth(MOST_VARIANTS - 1).filter(|_| baked.is_none()) {
            let name = &*scene.groups[group].identity.name;
            let what = "of many sizes, some instances have textures of box projections in that of another";
            messages.note("group", name, what);
            return Ok(*known);
        }
        let is_shared = baked.is_none();
        let mut primitives = Vec::new();
        for member in members {
            let Some(form) = self.forms.laid(scene, member, Some(placement), messages) else {
                continue;
            };
            let in_group = member.to_world * form.shape_from_mesh;
            if !is_invertible(&in_group) {
                messages.left_out("shape", &member.identity.name, "the transform cannot be inverted");
                continue;
            }
            let is_mirrored = is_mirrored(&in_group) ^ is_mirrored_place;
            let is_turned = member.shape.flip_normals ^ (is_mirrored && form.turns_with_mirrors());
            let placed = baked.unwrap_or(Affine3A::IDENTITY) * in_group;
            let placing = Placing {
                baked: (placed != Affine3A::IDENTITY).then_some(placed),
                is_turned,
                is_mirrored: baked.is_none() && is_mirrored_place,
            };
            primitives.extend(self.primitives(member, &form, placing, false, writer, messages)?);
        }
        let name = scene.groups[group].identity.name.to_string();
        let mesh = (!primitives.is_empty()).then(|| writer.add_mesh(Mesh { name, primitives }));
        if is_shared {
            self.groups.insert(key, mesh);
        }
        Ok(mesh)
    }

    /// The keys of the boxes by which textures lie on the members of a group in an instance; none if there are no
    /// boxes.
    fn boxes_of(
        &mut self,
        members: &[&ShapeDescription],
        placement: &Affine3A,
        messages: &mut Messages,
    ) -> Vec<Option<String>> {
        if !members.iter().any(|member| has_projection(self.scene, member)) {
            return Vec::new();
        }
        let keys = members.iter();
        keys.map(|member| self.forms.key_of_box(self.scene, member, placement, messages))
            .collect()
    }
}
