//! The names of layers: our own, those of Mitsuba 3's integrator `aov`, and those of the channels in a file.

use super::{Layer, Layers};

/// A name without a layer; empty where a list has two commas in a row.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{}; the layers are {}", complaint(name), layer_names().join(", "))]
pub struct UnknownLayer {
    /// The name.
    pub name: String,
}

fn complaint(name: &str) -> String {
    match name {
        "" => "the name of a layer is empty".to_owned(),
        name => format!("there is no layer `{name}`"),
    }
}

/// Names of several layers at once.
const SEVERAL: [(&str, &[Layer]); 2] = [
    ("all", &Layer::ALL),
    ("cryptomatte", &[Layer::CryptoObject, Layer::CryptoMaterial]),
];

/// All names that [`Layers::from_name`] knows.
pub fn layer_names() -> Vec<&'static str> {
    let several = SEVERAL.iter().map(|(name, _)| *name);
    Layer::ALL.into_iter().map(Layer::name).chain(several).collect()
}

impl Layers {
    /// The layers with this name, which may be `all` or `cryptomatte`.
    pub fn from_name(name: &str) -> Result<Self, UnknownLayer> {
        let one = Layer::of_name(name).map(|layer| Self::of(&[layer]));
        let several = || SEVERAL.iter().find(|(known, _)| *known == name);
        let found = one.or_else(|| several().map(|(_, layers)| Self::of(layers)));
        found.ok_or_else(|| UnknownLayer { name: name.to_owned() })
    }

    /// The layers named in a list that is separated by commas; spaces around names are ignored.
    pub fn parse(names: &str) -> Result<Self, UnknownLayer> {
        names
            .split(',')
            .map(str::trim)
            .map(Self::from_name)
            .try_fold(Self::default(), |all, one| Ok(all.and(one?)))
    }
}

impl Layer {
    /// The name that the integrator `aov` of Mitsuba 3 has for it; None if it has none.
    pub const fn name_in_mitsuba(self) -> Option<&'static str> {
        match self {
            Self::Albedo => Some("albedo"),
            Self::Normal => Some("sh_normal"),
            Self::GeometricNormal => Some("geo_normal"),
            Self::Depth => Some("depth"),
            Self::Position => Some("position"),
            Self::Uv => Some("uv"),
            Self::ObjectId => Some("shape_index"),
            _ => None,
        }
    }

    /// The layer by its name in a scene file: Mitsuba's if there is one, else our own, with `_` for `-`.
    pub fn from_name_in_file(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|layer| layer.name_in_file() == name)
    }

    /// The name in a scene file, see [`Self::from_name_in_file`].
    pub fn name_in_file(self) -> String {
        match self.name_in_mitsuba() {
            Some(name) => name.to_owned(),
            None => self.name().replace('-', "_"),
        }
    }

    /// The name in picture files, before the dot.
    pub const fn name_in_pictures(self) -> &'static str {
        match self {
            Self::Alpha => "A",
            Self::Albedo => "Albedo",
            Self::Normal => "Normal",
            Self::GeometricNormal => "GeometricNormal",
            Self::CameraNormal => "CameraNormal",
            Self::CameraGeometricNormal => "CameraGeometricNormal",
            Self::Depth => "Depth",
            Self::Position => "Position",
            Self::Uv => "UV",
            Self::Motion => "Motion",
            Self::ObjectId => "ObjectId",
            Self::MaterialId => "MaterialId",
            Self::Samples => "Samples",
            Self::Variance => "Variance",
            Self::Direct => "Direct",
            Self::Indirect => "Indirect",
            Self::Emitted => "Emitted",
            Self::LightGroups => "LightGroup",
            Self::Denoised => "Denoised",
            Self::DenoiserAlbedo => "DenoiserAlbedo",
            Self::DenoiserNormal => "DenoiserNormal",
            Self::CryptoObject => "CryptoObject",
            Self::CryptoMaterial => "CryptoMaterial",
        }
    }

    /// The last parts of the names of its channels in picture files; empty for cryptomattes, which are several layers
    /// there.
    pub const fn channels_in_pictures(self) -> &'static [&'static str] {
        match self {
            Self::Alpha => &["A"],
            Self::Normal
            | Self::GeometricNormal
            | Self::CameraNormal
            | Self::CameraGeometricNormal
            | Self::Position
            | Self::DenoiserNormal => &["X", "Y", "Z"],
            Self::Depth => &["Z"],
            Self::Uv => &["U", "V"],
            Self::Motion => &["X", "Y"],
            Self::ObjectId | Self::MaterialId | Self::Samples | Self::Variance => &["Y"],
            Self::Albedo
            | Self::Direct
            | Self::Indirect
            | Self::Emitted
            | Self::LightGroups
            | Self::Denoised
            | Self::DenoiserAlbedo => &["R", "G", "B"],
            Self::CryptoObject | Self::CryptoMaterial => &[],
        }
    }
}

#[cfg(test)]
mod tests {
    use std::collections::HashSet;

    use super::*;

    #[test]
    fn every_name_is_that_of_one_layer() {
        for layer in Layer::ALL {
            assert_eq!(Layer::of_name(layer.name()), Some(layer));
            assert_eq!(Layer::from_name_in_file(&layer.name_in_file()), Some(layer));
        }
        let in_pictures: HashSet<_> = Layer::ALL.into_iter().map(Layer::name_in_pictures).collect();
        assert_eq!(in_pictures.len(), Layer::ALL.len());
        assert_eq!(Layer::from_name_in_file("sh_normal"), Some(Layer::Normal));
        assert_eq!(Layer::from_name_in_file("normal"), None);
    }

    #[test]
    fn lists_of_names() {
        let some = Layers::of(&[Layer::Depth, Layer::CryptoObject, Layer::CryptoMaterial]);
        assert_eq!(Layers::parse("depth, cryptomatte"), Ok(some));
        assert_eq!(Layers::parse("all").map(|all| all.iter().count()), Ok(Layer::ALL.len()));
        for list in ["", "depth,", ",depth", "normal,,depth"] {
            let error = Layers::parse(list).expect_err(list).to_string();
            assert!(
                error.starts_with("the name of a layer is empty; the layers are alpha"),
                "{error}"
            );
        }
        let error = Layers::parse("depth,z").expect_err("no such layer").to_string();
        assert!(error.contains("`z`") && error.contains("crypto-object"), "{error}");
    }
}
