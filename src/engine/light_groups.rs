//! Groups the lights for the layers of a film: lights of one entity form a group.

use std::collections::HashMap;
use std::sync::Arc;

use bevy::prelude::*;

use crate::color::Rgb;
use crate::light::{LightId, WeightedSource};
use crate::render::light_layers::LightGroups;

/// The lights that share a layer.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct LightGroup {
    /// The entities: one, except for the last group if there are very many lights.
    pub entities: Vec<Entity>,
}

/// The lights of a scene by [`LightId`], and the entity of each.
#[derive(Debug, Default, PartialEq)]
pub struct Lamps {
    /// The entity that each light belongs to.
    pub owners: Vec<Entity>,
    /// The sources of the lights.
    pub sources: Vec<WeightedSource>,
}

/// The lights of one layer, and the entity of each.
#[derive(Default)]
pub(super) struct LayerLamps<'a> {
    pub owners: Vec<Entity>,
    pub sources: Vec<&'a WeightedSource>,
}

impl Lamps {
    /// The lights of an entity.
    pub fn of(&self, owner: Entity) -> Vec<(LightId, WeightedSource)> {
        let lights = (0..).map(LightId).zip(&self.owners).zip(&self.sources);
        lights
            .filter(|((_, one), _)| **one == owner)
            .map(|((id, _), source)| (id, source.clone()))
            .collect()
    }

    /// The lights of each layer of a film. Without groups there is one layer of all lights.
    pub(super) fn by_layer(&self, groups: &LightGroups) -> Vec<LayerLamps<'_>> {
        let mut layers: Vec<LayerLamps> = Vec::new();
        layers.resize_with(groups.count().max(1), LayerLamps::default);
        for (light, (&owner, source)) in (0..).zip(self.owners.iter().zip(&self.sources)) {
            let layer = &mut layers[groups.group(LightId(light)).unwrap_or(0)];
            layer.owners.push(owner);
            layer.sources.push(source);
        }
        layers
    }
}

/// The most memory in bytes for layers of light groups that are kept only for `lights_are_free`.
pub(super) const MOST_FOR_GROUPS: u64 = 64 << 20;
/// The same where the user wants to have them.
const MOST_FOR_WANTED_GROUPS: u64 = 1 << 30;

/// The most groups of a picture with so many pixels, which memory allows: from 16 to [`LightGroups::MOST`].
pub(super) fn most_groups(pixels: u64, are_wanted: bool) -> usize {
    let memory = if are_wanted {
        MOST_FOR_WANTED_GROUPS
    } else {
        MOST_FOR_GROUPS
    };
    let affordable = memory / (pixels.max(1) * size_of::<Rgb>() as u64);
    affordable.clamp(16, LightGroups::MOST as u64) as usize
}

/// Groups the lights by entity, in the order of their first lights; the last of `most` groups has all that are left.
/// `owners` has the entity of each light.
pub(super) fn group_lights(owners: &[Entity], most: usize) -> (Arc<[LightGroup]>, LightGroups) {
    let mut groups: Vec<LightGroup> = Vec::new();
    let mut group_of = HashMap::new();
    let group_of_light: Vec<u32> = owners
        .iter()
        .map(|&owner| {
            *group_of.entry(owner).or_insert_with(|| {
                if groups.len() < most {
                    groups.push(LightGroup::default());
                }
                let last = groups.len() - 1;
                groups[last].entities.push(owner);
                last as u32
            })
        })
        .collect();
    (groups.into(), LightGroups::new(&group_of_light))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_belongs_to_one_entity_is_one_group() {
        let mut world = World::new();
        let [lamp, sky] = [world.spawn_empty().id(), world.spawn_empty().id()];
        let (groups, layers) = group_lights(&[lamp, sky, lamp, lamp], 16);
        let entities: Vec<_> = groups.iter().map(|group| group.entities.clone()).collect();
        assert_eq!(entities, [[lamp], [sky]]);
        assert_eq!(layers, LightGroups::new(&[0, 1, 0, 0]));
    }

    #[test]
    fn the_last_of_many_share_a_group() {
        let mut world = World::new();
        let lamps: Vec<Entity> = (0..20).map(|_| world.spawn_empty().id()).collect();
        let (groups, layers) = group_lights(&lamps, 16);
        assert_eq!((groups.len(), layers.count()), (16, 16));
        assert_eq!(groups[15].entities, lamps[15..]);
        assert_eq!(groups[14].entities, [lamps[14]]);
    }

    #[test]
    fn small_pictures_tell_more_lamps_apart() {
        let most_groups = |pixels| most_groups(pixels, true);
        let full_hd = most_groups(1920 * 1080);
        assert!((24..LightGroups::MOST).contains(&full_hd), "{full_hd}");
        assert_eq!([most_groups(0), most_groups(800 * 500)], [LightGroups::MOST; 2]);
        assert_eq!(most_groups(1 << 40), 16);
    }
}
