//! A material with nested ones as one value, which replaces a material in one step. Wrapping, unwrapping and presets
//! are such trees.

use bevy::prelude::{Entity, World};

use crate::scene::{FirstNested, Material, PluginInfo, SecondNested};

/// A material with nested ones.
#[derive(Clone, Debug, PartialEq)]
pub struct MaterialTree {
    /// The outermost one.
    pub material: Material,
    /// The nested materials, at most two, in the order of the file.
    pub inside: Vec<Inside>,
}

/// A nested material.
#[derive(Clone, Debug, PartialEq)]
pub enum Inside {
    /// An existing one.
    Kept(Entity),
    /// A new one.
    New(Box<MaterialTree>),
}

impl From<MaterialTree> for Inside {
    fn from(tree: MaterialTree) -> Self {
        Self::New(Box::new(tree))
    }
}

impl From<Material> for MaterialTree {
    fn from(material: Material) -> Self {
        Self {
            material,
            inside: Vec::new(),
        }
    }
}

/// The plugins that can wrap a material.
pub(crate) fn wrappers() -> impl Iterator<Item = &'static PluginInfo> {
    Material::DECLARED.iter().filter(|plugin| *plugin.nested.end() > 0)
}

impl MaterialTree {
    /// The material and all new ones nested in it.
    #[cfg(test)]
    pub fn materials(&self) -> Vec<&Material> {
        let inside = self.inside.iter().flat_map(|inside| match inside {
            Inside::Kept(_) => Vec::new(),
            Inside::New(tree) => tree.materials(),
        });
        std::iter::once(&self.material).chain(inside).collect()
    }

    /// The present material around the materials nested in it.
    pub fn of(material: &Material, inside: &[Entity]) -> Self {
        Self {
            material: material.clone(),
            inside: inside.iter().copied().map(Inside::Kept).collect(),
        }
    }

    /// This tree wrapped in a new material of a plugin that takes nested ones, the second of them new as well.
    /// Unchanged for any other plugin.
    pub fn wrapped(self, plugin: &str) -> Self {
        let Some(wrapper) = Material::of_plugin(plugin).filter(|wrapper| *wrapper.info().nested.end() > 0) else {
            return self;
        };
        let missing = wrapper.info().nested.start().saturating_sub(1);
        let mut inside = vec![Inside::from(self)];
        inside.extend((0..missing).map(|_| MaterialTree::from(Material::default()).into()));
        Self {
            material: wrapper,
            inside,
        }
    }
}

/// The nested materials of a material.
pub(crate) fn materials_inside(world: &World, material: Entity) -> Vec<Entity> {
    let first = world.get::<FirstNested>(material).map(|nested| nested.0);
    let second = world.get::<SecondNested>(material).map(|nested| nested.0);
    first.into_iter().chain(second).collect()
}

/// Flattens trees into one list. Each material has the indices of its nested ones; the second list has the index of
/// each tree's outermost material. Materials of the scene are left out.
pub(crate) fn flattened<'t>(
    trees: impl IntoIterator<Item = &'t MaterialTree>,
) -> (Vec<(Material, Vec<usize>)>, Vec<usize>) {
    fn add(tree: &MaterialTree, list: &mut Vec<(Material, Vec<usize>)>) -> usize {
        let place = list.len();
        list.push((tree.material.clone(), Vec::new()));
        for inner in &tree.inside {
            if let Inside::New(inner) = inner {
                let inner = add(inner, list);
                list[place].1.push(inner);
            }
        }
        place
    }
    let mut list = Vec::new();
    let places = trees.into_iter().map(|tree| add(tree, &mut list)).collect();
    (list, places)
}

/// Whether a plugin may wrap this material: refractive ones have two sides already.
pub(crate) fn can_wrap(plugin: &str, material: &Material) -> bool {
    plugin != "twosided" || !(material.refracts() || matches!(material, Material::TwoSided | Material::Null))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wrappers_keep_what_is_inside() {
        let tree = MaterialTree::from(Material::of_plugin("plastic").expect("a plugin"));
        for plugin in wrappers().map(|plugin| plugin.name) {
            let wrapped = tree.clone().wrapped(plugin);
            assert_eq!(wrapped.material.plugin(), plugin);
            assert_eq!(wrapped.inside[0], tree.clone().into());
            assert!(wrapped.material.info().nested.contains(&wrapped.inside.len()));
        }
        assert_eq!(tree.clone().wrapped("diffuse"), tree);
        assert!(!can_wrap(
            "twosided",
            &Material::of_plugin("dielectric").expect("a plugin")
        ));
    }
}
