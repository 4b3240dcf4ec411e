//! The folders of the scene: nodes at which nothing stands but that have things below, as Blender's empties. Their
//! names come before the names of what hangs on them, as in `house/room/table`. A folder with a pose of its own becomes
//! a group, unless it moves: then what is in it has keys that say so.

use std::rc::Rc;

use glam::{Affine3A, Mat4};

use super::motion::Placement;
use super::nodes::PlacedNodes;
use super::objects::{object, with_float, with_world};
use super::scene::Builder;
use super::{Gltf, GltfError};
use crate::document::{Category, Object};
use crate::math::is_invertible;

/// The most folders inside of each other, and the most characters of the name of each: names of things repeat them.
const DEEPEST: usize = 16;
const LONGEST_NAME: usize = 64;

/// Where the things of a node lie.
#[derive(Clone, Default)]
pub(super) struct Folder {
    /// The names of the folders, each with a slash behind it.
    pub path: Rc<str>,
    depth: usize,
}

impl Builder<'_> {
    /// The folder of the things of each node.
    pub fn folders(&mut self, placed: &PlacedNodes) -> Result<Vec<Folder>, GltfError> {
        let gltf = self.gltf;
        let is_used = used(gltf, placed)?;
        // For each node, where its own things lie, and where its children are.
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

/// Whether anything stands at or below each node.
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

/// The group of a folder, as the scene format has it: a volume that nothing uses.
fn group(path: &str, world: Mat4) -> Object {
    let volume = with_float(object(Category::Volume, "constvolume"), "value", 1.0);
    Object {
        id: Some(path.to_owned().into()),
        ..with_world(volume, &Placement::still(world), Mat4::IDENTITY)
    }
}
