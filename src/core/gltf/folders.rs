//! The folders of the scene: nodes with things below them but none of their own, such as Blender's empties. Their names
//! are prefixes of the names of the things below, as in `house/room/table`. A folder with a pose of its own becomes a
//! group, unless it is animated: then the things in it have the keys.

use std::rc::Rc;

use glam::{Affine3A, Mat4};

use super::motion::Placement;
use super::nodes::PlacedNodes;
use super::objects::{object, with_float, with_world};
use super::scene::Builder;
use super::{Gltf, GltfError};
use crate::document::{Category, Object};
use crate::math::is_invertible;

/// The most nested folders, and the most characters of the name of each: names of things repeat them.
const DEEPEST: usize = 16;
const LONGEST_NAME: usize = 64;

/// The folder of the things of a node.
#[derive(Clone, Default)]
pub(super) struct Folder {
    /// The names of the folders, each followed by a slash.
    pub path: Rc<str>,
    depth: usize,
}

impl Builder<'_> {
    /// The folder of the things of each node.
    pub fn folders(&mut self, placed: &PlacedNodes) -> Result<Vec<Folder>, GltfError> {
        let gltf = self.gltf;
        let is_used = used(gltf, placed)?;
        // For each node, the folder of its own things, and that of its children.
        let (mut own, mut below): (Vec<Folder>, Vec<Folder>) = (Vec::new(), Vec::new());
        for (place, node) in placed.nodes.iter().enumerate() {
            let about = gltf.get("node", &gltf.root.nodes, node.index)?;
            let above = node.parent.map_or_else(Folder::default, |parent| below[parent].clone());
            let name = about.name.as_deref().filter(|name| !name.trim().is_empty());
            let name = name.filter(|_| is_used[place] && !about.places_something() && above.depth < DEEPEST);
            let inside = name.map(|name| {
                let name: String = name.chars().take(LONGEST_NAME).collect();
                let path = self.unique_in(&above.path, &name, "/");
                if about.local() != Mat4::IDENTITY && !node.moves && is_invertible(&Affine3A::from_mat4(node.world)) {
                    self.groups.push(group(&path, node.world));
                }
                Folder {
                    path: path.into(),
                    depth: above.depth + 1,
                }
            });
            below.push(inside.unwrap_or_else(|| above.clone()));
            own.push(above);
        }
        Ok(own)
    }
}

/// For each node, whether there is a thing at or below it.
fn used(gltf: &Gltf, placed: &PlacedNodes) -> Result<Vec<bool>, GltfError> {
    let mut used = vec![false; placed.nodes.len()];
    // Parents come first.
    for (place, node) in placed.nodes.iter().enumerate().rev() {
        used[place] |= gltf.get("node", &gltf.root.nodes, node.index)?.places_something();
        if let Some(parent) = node.parent {
            used[parent] |= used[place];
        }
    }
    Ok(used)
}

/// The group of a folder in the scene format: an unused volume.
fn group(path: &str, world: Mat4) -> Object {
    let volume = with_float(object(Category::Volume, "constvolume"), "value", 1.0);
    Object {
        id: Some(path.to_owned().into()),
        ..with_world(volume, &Placement::still(world), Mat4::IDENTITY)
    }
}
