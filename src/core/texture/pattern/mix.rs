//! Two textures by a third.

use super::*;

/// A mixture of two textures by the number of a third.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mix {
    /// The two colours, each of which may be a texture before this one in the table.
    pub colors: [Parameter<Rgb>; 2],
    /// The share of the second; it may be a texture before this one in the table, and counts as its number.
    pub weight: Parameter<Rgb>,
    /// The operation.
    pub mode: MixMode,
}

declare_names! {
    /// What a mixture does with its two colours `a` and `b` and the weight `w`.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
    pub enum MixMode {
        /// (1 - w) a + w b, with w limited to [0, 1].
        #[default]
        Mix = "mix",
        /// a (1 - w + w b), with w limited to [0, 1].
        Multiply = "multiply",
        /// a + w b.
        Add = "add",
    }
}

impl Mix {
    /// The value at a point of a surface.
    pub(in crate::texture) fn value<V: TextureValue>(&self, table: &TextureTable, at: &TexturePoint) -> V {
        let weight = f32::nested(table, self.weight, at);
        let share = weight.saturated();
        let nested = |color: Parameter<Rgb>| V::nested(table, color, at);
        let [a, b] = self.colors;
        match self.mode {
            MixMode::Mix => mixed(table, self.colors, share, at),
            MixMode::Multiply if share == 0.0 => nested(a),
            MixMode::Multiply => nested(a) * (V::of_color(Rgb::splat(1.0 - share)) + nested(b) * share),
            MixMode::Add if weight == 0.0 => nested(a),
            MixMode::Add => nested(a) + nested(b) * weight,
        }
    }
}
