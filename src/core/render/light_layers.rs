//! Light mixing: the light of each group of lights is also summed up separately, since the picture is linear in all of
//! them.
//!
//! The layers hold the same samples as the picture: they are as noisy, and sum up to it.

use std::sync::Arc;

use crate::light::LightId;

/// The assignment of lights to layers of the film.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct LightGroups {
    /// The layer by [`LightId`].
    layer_of_light: Arc<[u8]>,
    count: usize,
}

impl LightGroups {
    /// Groups beyond this many share the last layer.
    pub const MOST: usize = 64;

    /// Groups the lights. `group_of_light` is by [`LightId`], counted from 0.
    pub fn new(group_of_light: &[u32]) -> Self {
        let last = group_of_light.iter().max();
        let count = last.map_or(0, |&last| Self::MOST.min(last as usize + 1));
        Self::of(group_of_light, count)
    }

    /// The same in `count` groups, at most 256. Groups beyond them share the last one.
    pub fn of(group_of_light: &[u32], count: usize) -> Self {
        let last = count.saturating_sub(1) as u32;
        Self {
            layer_of_light: group_of_light.iter().map(|&group| group.min(last) as u8).collect(),
            count,
        }
    }

    /// The number of layers of the film.
    pub fn count(&self) -> usize {
        self.count
    }

    /// The group of a light.
    pub fn group(&self, light: LightId) -> Option<usize> {
        self.layer_of_light.get(light.0 as usize).map(|&layer| layer.into())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn groups_beyond_the_most_share_the_last_layer() {
        let groups = LightGroups::new(&[0, 63, 64, 90]);
        let layers: Vec<_> = (0..5).map(|light| groups.group(LightId(light))).collect();
        assert_eq!(layers, [Some(0), Some(63), Some(63), Some(63), None]);
        assert_eq!(groups.count(), LightGroups::MOST);
        assert_eq!(LightGroups::new(&[]), LightGroups::default());
    }
}
