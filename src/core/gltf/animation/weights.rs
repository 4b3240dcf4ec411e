//! The morph weights that animations give nodes at 0 s.

use std::rc::Rc;

use super::super::schema::{Animation, Channel};
use super::super::{Gltf, GltfError};
use super::{Known, fault_of_times};

impl Gltf {
    /// The morph weights of a node at 0 s. They are linear between keys, whatever the interpolation is.
    pub(super) fn first_weights(
        &self,
        node: usize,
        animation: &Animation,
        channel: &Channel,
        known: &mut Known,
    ) -> Result<Rc<[f32]>, GltfError> {
        let sampler = self.get("sampler", &animation.samplers, channel.sampler)?;
        let node = self.get("node", &self.root.nodes, node)?;
        let mesh = self.get("mesh", &self.root.meshes, node.mesh.unwrap_or(usize::MAX))?;
        let targets = mesh.primitives.first().map_or(0, |primitive| primitive.targets.len());
        let times = self.shared::<1>(sampler.input, "SCALAR", known, fault_of_times)?.list;
        let most = times.len().saturating_sub(1);
        let after = times.partition_point(|time| time[0] <= 0.0).min(most);
        let before = after.saturating_sub(1);
        // Cubic curves have two tangents beside each value.
        let (stride, first) = match sampler.interpolation.as_deref() {
            Some("CUBICSPLINE") => (3 * targets, targets),
            _ => (targets, 0),
        };
        // Sparse values are read as a whole.
        let output = self.accessor(sampler.output)?;
        let sparse = output.sparse.as_ref().map_or(0, |sparse| sparse.count);
        let cost = 16 * (targets as u64).saturating_add(sparse as u64);
        known.left = known.left.checked_sub(cost).ok_or_else(|| GltfError::Accessor {
            index: sampler.output,
            what: "is one of too many for the size of the buffers".to_owned(),
        })?;
        let count = output.count;
        let values = |key: usize| {
            let start = key.saturating_mul(stride).saturating_add(first);
            if start.saturating_add(targets) > count {
                let what = format!("has {count} weights, too few for its times");
                return Err(GltfError::Accessor {
                    index: sampler.output,
                    what,
                });
            }
            let used: Vec<u32> = (start..start + targets).map(|value| value as u32).collect();
            self.vectors::<1>(sampler.output, "SCALAR", Some(&used))
        };
        let time = |key: usize| times.get(key).map_or(0.0, |time| time[0]);
        let length = time(after) - time(before);
        let share = match length > 0.0 {
            true => (-time(before) / length).clamp(0.0, 1.0),
            false => 0.0,
        };
        let pairs = values(before)?.into_iter().zip(values(after)?);
        Ok(pairs.map(|([from], [to])| from + share * (to - from)).collect())
    }
}
