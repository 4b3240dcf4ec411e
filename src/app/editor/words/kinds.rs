//! How kinds of materials and lights are called.

use crate::scene::{Emitter, Material};

/// What plugins are called in lists, where not by their own name.
const MATERIAL_KINDS: [(&str, &str); 10] = [
    ("roughconductor", "rough conductor"),
    ("roughdielectric", "rough dielectric"),
    ("thindielectric", "thin dielectric"),
    ("roughplastic", "rough plastic"),
    ("twosided", "two-sided"),
    ("blendbsdf", "blend"),
    ("normalmap", "normal map"),
    ("bumpmap", "bump map"),
    ("null", "nothing"),
    ("metal", "metal with fuzz"),
];

/// The name of the kind, for lists.
pub fn material_kind(material: &Material) -> &'static str {
    plugin_name(material.plugin())
}

/// The name of a kind of material by its plugin.
pub fn plugin_name(plugin: &'static str) -> &'static str {
    in_words(&MATERIAL_KINDS, plugin)
}

/// The words for a name, or the name.
pub fn in_words<'n>(names: &[(&str, &'static str)], name: &'n str) -> &'n str
where
    'static: 'n,
{
    names
        .iter()
        .find(|(known, _)| *known == name)
        .map_or(name, |(_, words)| words)
}

/// What plugins are called in lists, where not by their own name.
pub const EMITTER_KINDS: [(&str, &str); 2] = [("envmap", "environment map"), ("sunsky", "sun and sky")];

/// The name of the kind, for lists.
pub fn emitter_kind(emitter: &Emitter) -> &'static str {
    in_words(&EMITTER_KINDS, emitter.plugin())
}
