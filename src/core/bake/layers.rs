//! The layers of a bake: the light of each lamp by itself, so that a game can dim it.
//!
//! The path tracer tells the light of the lamps apart, so that all layers come from the same paths as the whole. A
//! picture (a lightmap or a probe) has no layer of a lamp whose light does not reach it. If the layers that are left
//! exceed the bound on memory, the weakest become a single one, the rest.

use glam::UVec2;
use serde::{Deserialize, Serialize};

use super::lightmap::Lightmaps;
use super::probes::{Probe, ProbeKind};
use crate::gltf::write::GltfWriter;
use crate::render::light_layers::LightGroups;

/// The most layers of lamps; the lights of all further lamps belong to the rest.
pub const MOST_LAYERS: usize = 63;
/// The bound on the memory of layers in bytes, if none is given.
pub const USUAL_MEMORY: u64 = 256 << 20;

/// A lamp that gets a layer.
#[derive(Clone, Debug, PartialEq)]
pub struct Lamp {
    /// Its name, different from those of all other lamps.
    pub name: String,
    /// The kind of its lights.
    pub kind: LayerKind,
    /// Its position in the scene's file, as nodes of the level have it
    /// ([`crate::gltf::write::model::Node::order`]).
    pub order: u32,
}

/// A layer of light.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Layer {
    /// The name of the lamp.
    pub name: String,
    /// The kind of its lights.
    pub kind: LayerKind,
    /// The nodes of the level that are the lamp: shapes that shine, and punctual lights.
    pub nodes: Vec<usize>,
}

/// The kind of the lights of a layer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum LayerKind {
    /// A lamp.
    Lamp,
    /// The light of all directions: a constant one, a picture, or a sky together with its sun.
    Sky,
    /// Parallel light.
    Sun,
    /// Light that cannot be dimmed by itself: of media that glow, of lamps beyond [`MOST_LAYERS`], and of lamps that
    /// light a picture too little for a layer there.
    Rest,
}

/// The lamps of a scene that get layers.
#[derive(Clone, Debug, PartialEq)]
pub struct LampLayers {
    lamps: Vec<Lamp>,
    /// The layer of each light. The last one is the rest.
    pub(super) groups: LightGroups,
    /// The bound on the memory of the layers' textures in a game, in bytes.
    memory: u64,
}

/// The division of a bake into layers.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Division {
    /// The layers, of which the last is the rest; none for a bake without layers.
    pub layers: Vec<Layer>,
    /// The most layers of a picture, at least 1 if there are any.
    pub most: u32,
}

/// The key of the number of a layer in the extras of the nodes that are its lamp.
const EXTRA: &str = "sunroom_lamp";

impl LampLayers {
    /// Layers for lamps. `lamp_of_light`: the number of the lamp of each light. `memory`: the most bytes that the
    /// textures of the layers may take in a game.
    pub fn new(mut lamps: Vec<Lamp>, lamp_of_light: &[u32], memory: u64) -> Self {
        lamps.truncate(MOST_LAYERS);
        Self {
            groups: LightGroups::of(lamp_of_light, lamps.len() + 1),
            lamps,
            memory,
        }
    }

    /// The division of a bake with pictures of so many texels in all. The nodes of the lamps get the numbers of their
    /// layers.
    pub(super) fn division(&self, texels: u64, level: &mut GltfWriter) -> Division {
        let layer = |(number, lamp): (usize, &Lamp)| Layer {
            name: lamp.name.clone(),
            kind: lamp.kind,
            nodes: level.mark(lamp.order, EXTRA, number),
        };
        let mut layers: Vec<Layer> = self.lamps.iter().enumerate().map(layer).collect();
        layers.push(Layer {
            name: "rest".to_owned(),
            kind: LayerKind::Rest,
            nodes: Vec::new(),
        });
        let most = self.memory / (BYTES_IN_GAMES * texels.max(1));
        let most = u32::try_from(most).unwrap_or(u32::MAX).max(1);
        Division { layers, most }
    }
}

/// Bytes of a layer's sum at a texel, and of a pixel of its finished picture.
const SUM_BYTES: u64 = 24;
const PIXEL_BYTES: u64 = 12;
/// Bytes of a texel in a game: four half floats.
const BYTES_IN_GAMES: u64 = 8;

/// The number of texels of the textures of lightmaps and probes.
pub(super) fn texture_texels(size: UVec2, pages: usize, probes: &[Probe]) -> u64 {
    let of_probe = |probe: &Probe| match probe.kind {
        // The smaller levels of a cube take a third of the largest, and that for diffuse surfaces has 16 x 16 texels.
        ProbeKind::Reflection { size, .. } => 8 * u64::from(size * size) + 6 * 256,
        ProbeKind::Volume { points } => 6 * u64::from(points.element_product()),
    };
    let of_pages = u64::from(size.x) * u64::from(size.y) * pages as u64;
    of_pages + probes.iter().map(of_probe).sum::<u64>()
}

/// The parts of a picture's light that become pictures of their own, in ascending order: the number of a layer, and the
/// layers whose light it has.
pub(super) type Parts = Vec<(usize, Vec<usize>)>;

impl Division {
    /// Whether the bake has layers.
    pub fn is_some(&self) -> bool {
        !self.layers.is_empty()
    }

    /// Whether the bake has no layers.
    pub fn is_none(&self) -> bool {
        !self.is_some()
    }

    /// Whether a file may have it.
    pub(super) fn is_possible(&self) -> bool {
        let is_rest = |layer: &Layer| layer.kind == LayerKind::Rest;
        self.layers.len() <= MOST_LAYERS + 1 && self.layers.last().is_none_or(is_rest)
    }

    /// Bytes of memory for the layers of a bake: sums at `texels`, and pictures with `pixels`.
    pub(super) fn memory_bytes(&self, texels: u64, pixels: u64) -> u64 {
        let pictures = self.layers.len().min(self.most as usize) as u64;
        let sums = SUM_BYTES
            .saturating_mul(texels)
            .saturating_mul(self.layers.len() as u64);
        sums.saturating_add(PIXEL_BYTES.saturating_mul(pixels).saturating_mul(pictures))
    }

    /// The parts of a picture's light at these texels. Those of weak lamps belong to the rest if there are more than
    /// the most.
    pub(super) fn parts(&self, light: &Lightmaps, texels: std::ops::Range<usize>) -> Parts {
        let strengths = light.strengths(texels);
        let Some(rest) = self.layers.len().checked_sub(1) else {
            return Parts::new();
        };
        let mut lamps: Vec<usize> = (0..rest).filter(|lamp| strengths[*lamp] != 0.0).collect();
        let (has_rest, most) = (strengths[rest] != 0.0, self.most as usize);
        let mut others = Vec::new();
        if lamps.len() + usize::from(has_rest) > most {
            lamps.sort_by(|one, other| strengths[*other].total_cmp(&strengths[*one]).then(one.cmp(other)));
            others = lamps.split_off(most.saturating_sub(1));
            lamps.sort_unstable();
            others.sort_unstable();
        }
        if has_rest {
            others.push(rest);
        }
        let mut parts: Parts = lamps.into_iter().map(|lamp| (lamp, vec![lamp])).collect();
        if !others.is_empty() {
            parts.push((rest, others));
        }
        parts
    }
}

/// The number of lamps that cannot be dimmed in a picture of these parts.
pub(super) fn merged_in(parts: &Parts) -> usize {
    let others = |(number, layers): &(usize, Vec<usize>)| layers.iter().filter(|layer| *layer != number).count();
    parts.iter().map(others).sum()
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;

    /// The parts of a picture of one texel with the light of these layers.
    fn parts(light: &[f64], most: u32) -> Parts {
        let layer = |number: usize| Layer {
            name: number.to_string(),
            kind: LayerKind::Lamp,
            nodes: Vec::new(),
        };
        let division = Division {
            layers: (0..light.len()).map(layer).collect(),
            most,
        };
        let mut sums = Lightmaps::new(1).with_layers(light.len());
        sums.ends = vec![1];
        sums.layer_sums[0] = light.iter().map(|light| DVec3::splat(*light)).collect();
        division.parts(&sums, 0..1)
    }

    #[test]
    fn the_weakest_lamps_of_a_picture_become_the_rest() {
        let light = [1.0, 0.0, 5.0, 0.5, 5.0, 0.0];
        let alone = |layers: &[usize]| -> Parts { layers.iter().map(|layer| (*layer, vec![*layer])).collect() };
        assert_eq!(parts(&light, 4), alone(&[0, 2, 3, 4]));
        assert_eq!(parts(&light, 3), [alone(&[2, 4]), vec![(5, vec![0, 3])]].concat());
        assert_eq!(parts(&light, 2), [alone(&[2]), vec![(5, vec![0, 3, 4])]].concat());
        assert_eq!(parts(&light, 1), [(5, vec![0, 2, 3, 4])]);
        let glowing = [1.0, 2.0, 0.1];
        assert_eq!(parts(&glowing, 3), alone(&[0, 1, 2]));
        assert_eq!(parts(&glowing, 2), [alone(&[1]), vec![(2, vec![0, 2])]].concat());
        assert_eq!(parts(&[0.0, 0.0], 2), []);
    }
}
