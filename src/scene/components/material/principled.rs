//! The declaration of `principled` and `principledthin`.

use bevy::prelude::*;

use crate::color::Rgb;
use crate::scene::components::declare::declare_parameters;
use crate::scene::components::parameter_info::ParameterInfo;
use crate::scene::components::parameters::{Declared, INDICES, ParameterMut, ParameterRef, PrincipledIndex, SPECULAR};
use crate::scene::components::texture::Parameter;

declare_parameters! {
    /// Base, metal and glass under sheen and a clear coat. Numbers are in [0, 1]; rates of sampling are not negative.
    #[derive(Reflect, Clone, Debug, PartialEq)]
    pub struct Principled {
        base_color: Parameter<Rgb> = Rgb::splat(0.5).into() => Reflectance(BASE_COLOR),
        roughness: Parameter<f32> = 0.5.into() => Float(ROUGHNESS),
        anisotropic: Parameter<f32> = 0.0.into() => Float(ANISOTROPIC),
        metallic: Parameter<f32> = 0.0.into() => Float(ParameterInfo::share(
            "metallic",
            "Metallic",
            "From plastic to metal, which mirrors in its own colour and has nothing matt.",
        )),
        spec_trans: Parameter<f32> = 0.0.into() => Float(SPEC_TRANS),
        index: PrincipledIndex = PrincipledIndex::default() => PrincipledIndex(SPECULAR),
        spec_tint: Parameter<f32> = 0.0.into() => Float(SPEC_TINT),
        sheen: Parameter<f32> = 0.0.into() => Float(SHEEN),
        sheen_tint: Parameter<f32> = 0.0.into() => Float(SHEEN_TINT),
        flatness: Parameter<f32> = 0.0.into() => Float(FLATNESS),
        clearcoat: Parameter<f32> = 0.0.into() => Float(ParameterInfo::share(
            "clearcoat",
            "Clear coat",
            "A second, clear layer of lacquer above the rest.",
        )),
        clearcoat_gloss: Parameter<f32> = 0.0.into() => Float(ParameterInfo {
            values: "0 satin to 1 gloss, or a texture",
            ..ParameterInfo::share("clearcoat_gloss", "Coat gloss", "How sharp the clear coat's highlights are.")
        }),
        main_specular_sampling_rate: f32 = 1.0 => Number(ParameterInfo::sampling_rate(
            "main_specular_sampling_rate",
            "Specular rate",
            "How often rays follow the main mirror image, relative to the other parts.",
        )),
        clearcoat_sampling_rate: f32 = 1.0 => Number(ParameterInfo::sampling_rate(
            "clearcoat_sampling_rate",
            "Coat rate",
            "How often rays follow the clear coat, relative to the other parts.",
        )),
        diffuse_reflectance_sampling_rate: f32 = 1.0 => Number(DIFFUSE_REFLECTANCE_SAMPLING_RATE),
    }
}

impl Principled {
    /// Whether there is, or may be somewhere, glass.
    pub fn refracts(&self) -> bool {
        self.spec_trans != Parameter::Constant(0.0)
    }
}

declare_parameters! {
    /// A sheet that scatters to both sides. Numbers are in [0, 1] unless stated.
    #[derive(Reflect, Clone, Debug, PartialEq)]
    pub struct PrincipledThin {
        base_color: Parameter<Rgb> = Rgb::splat(0.5).into() => Reflectance(BASE_COLOR),
        roughness: Parameter<f32> = 0.5.into() => Float(ROUGHNESS),
        anisotropic: Parameter<f32> = 0.0.into() => Float(ANISOTROPIC),
        spec_trans: Parameter<f32> = 0.0.into() => Float(SPEC_TRANS),
        /// Refractive index of the sheet over that around it, above 0.
        eta: Parameter<f32> = 1.5.into() => Float(ParameterInfo::new(
            "eta",
            "Index",
            "Index of refraction of the sheet over that around it.",
            "0.01 to 100, or a texture; glass has 1.5",
        )
        .within(INDICES)),
        spec_tint: Parameter<f32> = 0.0.into() => Float(SPEC_TINT),
        sheen: Parameter<f32> = 0.0.into() => Float(SHEEN),
        sheen_tint: Parameter<f32> = 0.0.into() => Float(SHEEN_TINT),
        flatness: Parameter<f32> = 0.0.into() => Float(FLATNESS),
        /// Twice the share of diffuse light that is transmitted, in [0, 2].
        diff_trans: Parameter<f32> = 0.0.into() => Float(ParameterInfo::new(
            "diff_trans",
            "See-through",
            "How much of the matt light leaves on the other side, as through a leaf or paper.",
            "0 to 2, or a texture; 1 is half of it",
        )
        .within(0.0..=2.0)),
        specular_reflectance_sampling_rate: f32 = 1.0 => Number(ParameterInfo::sampling_rate(
            "specular_reflectance_sampling_rate",
            "Specular rate",
            "How often rays follow the mirror image, relative to the other parts.",
        )),
        specular_transmittance_sampling_rate: f32 = 1.0 => Number(ParameterInfo::sampling_rate(
            "specular_transmittance_sampling_rate",
            "Clear rate",
            "How often rays go clearly through the sheet, relative to the other parts.",
        )),
        diffuse_reflectance_sampling_rate: f32 = 1.0 => Number(DIFFUSE_REFLECTANCE_SAMPLING_RATE),
        diffuse_transmittance_sampling_rate: f32 = 1.0 => Number(ParameterInfo::sampling_rate(
            "diffuse_transmittance_sampling_rate",
            "Through rate",
            "How often rays follow the matt light to the other side, relative to the other parts.",
        )),
    }
}

// These parameters belong to both models.

const BASE_COLOR: ParameterInfo = ParameterInfo::reflectance(
    "base_color",
    "Base colour",
    "Colour of the matt part, and of the mirror image where it is metal.",
);

const ROUGHNESS: ParameterInfo = ParameterInfo::share(
    "roughness",
    "Roughness",
    "How blurred mirror images and what is seen through it are. The facets' spread is its square.",
);

const ANISOTROPIC: ParameterInfo = ParameterInfo {
    values: "0 round to 1 stretched, or a texture",
    ..ParameterInfo::share(
        "anisotropic",
        "Anisotropy",
        "Stretches highlights across the direction in which u grows, as brushing does.",
    )
};

const SPEC_TRANS: ParameterInfo = ParameterInfo::share(
    "spec_trans",
    "Glass",
    "From opaque to clear: the share of light that is refracted instead of scattered.",
);

const SPEC_TINT: ParameterInfo = ParameterInfo::share(
    "spec_tint",
    "Mirror tint",
    "Tints the mirror image of what is no metal with the base colour.",
);

const SHEEN: ParameterInfo = ParameterInfo::share("sheen", "Sheen", "A glow towards the outline, as on cloth.");

const SHEEN_TINT: ParameterInfo =
    ParameterInfo::share("sheen_tint", "Sheen tint", "Tints the sheen with the base colour.");

const FLATNESS: ParameterInfo = ParameterInfo::share(
    "flatness",
    "Flatness",
    "From matt to the flatter look of light that has wandered below the surface, as in skin or wax.",
);

const DIFFUSE_REFLECTANCE_SAMPLING_RATE: ParameterInfo = ParameterInfo::sampling_rate(
    "diffuse_reflectance_sampling_rate",
    "Diffuse rate",
    "How often rays follow the matt part, relative to the others.",
);

#[cfg(test)]
mod tests {
    use super::*;
    use crate::document::{self, Category, Value};
    use crate::scene::encode::objects;
    use crate::scene::read;
    use crate::scene::{Material, SceneDescription};
    use std::path::Path;

    /// Reads a scene with these bsdfs; returns it and its messages.
    fn scene(bsdfs: &str) -> (SceneDescription, Vec<String>) {
        let text = format!("<scene version='3.0.0'>{bsdfs}<sensor type='perspective'/></scene>");
        let mut document = document::parse_str(&*text, Path::new("/scene.xml"), &[]);
        let scene = read::read(&mut document);
        let complaints = document.diagnostics.list.iter().map(|d| d.message.clone());
        (scene, complaints.collect())
    }

    fn material(bsdf: &str) -> Material {
        let (scene, complaints) = scene(bsdf);
        assert_eq!(complaints, [""; 0], "{bsdf}");
        scene.materials[0].material.clone()
    }

    /// The bsdf with every parameter that it writes given another value, 1 / 32, 2 / 32, ...
    fn renumbered(plugin: &str) -> String {
        let written = objects::material(&material(&format!("<bsdf type='{plugin}'/>")), Path::new("/"));
        assert_eq!(written.category, Category::Bsdf);
        let parameters = written.properties.iter().zip(1u8..).map(|(property, number)| {
            let (name, value) = (&property.name, f32::from(number) / 32.0);
            match property.value {
                Value::Rgb(_) => format!("<rgb name='{name}' value='0.5, 0.25, {value}'/>"),
                _ => format!("<float name='{name}' value='{value}'/>"),
            }
        });
        format!("<bsdf type='{plugin}'>{}</bsdf>", parameters.collect::<String>())
    }

    #[test]
    fn every_parameter_is_read_and_written() {
        for (plugin, count) in [("principled", 15), ("principledthin", 14)] {
            let file = renumbered(plugin);
            let written = objects::material(&material(&file), Path::new("/"));
            assert_eq!(written.properties.len(), count);
            for (property, number) in written.properties.iter().zip(1u8..) {
                let value = f32::from(number) / 32.0;
                let expected = match property.value {
                    Value::Rgb(_) => Value::Rgb(Rgb::new(0.5, 0.25, value)),
                    _ => Value::Float(value),
                };
                assert_eq!(property.value, expected, "{plugin} {}", property.name);
            }
        }
        let Material::Principled(principled) = material(&renumbered("principled")) else {
            panic!("not principled")
        };
        assert_eq!(principled.roughness, (2.0 / 32.0).into());
        assert_eq!(principled.clearcoat_gloss, (12.0 / 32.0).into());
        assert_eq!(principled.index, PrincipledIndex::Specular(6.0 / 32.0));
    }

    #[test]
    fn the_index_has_one_of_two_names() {
        let index = |parameters: &str| {
            let (scene, complaints) = scene(&format!("<bsdf type='principled'>{parameters}</bsdf>"));
            match &scene.materials[0].material {
                Material::Principled(principled) => (principled.index, complaints),
                other => panic!("{other:?}"),
            }
        };
        let (specular, eta) = (
            "<float name='specular' value='0.25'/>",
            "<float name='eta' value='1.25'/>",
        );
        assert_eq!(index(""), (PrincipledIndex::Specular(0.5), vec![]));
        assert_eq!(index(specular), (PrincipledIndex::Specular(0.25), vec![]));
        assert_eq!(index(eta), (PrincipledIndex::Eta(1.25), vec![]));
        let (kept, complaints) = index(&format!("{specular}{eta}"));
        assert_eq!(kept, PrincipledIndex::default());
        assert!(
            complaints.len() == 1 && complaints[0].contains("exclude each other"),
            "{complaints:?}"
        );
    }

    #[test]
    fn what_light_passes_is_not_made_two_sided() {
        let two_sided = |bsdf: &str| scene(&format!("<bsdf type='twosided'>{bsdf}</bsdf>")).1;
        assert_eq!(two_sided("<bsdf type='principled'/>"), [""; 0]);
        for bsdf in [
            "<bsdf type='principledthin'/>",
            "<bsdf type='principled'><float name='spec_trans' value='0.1'/></bsdf>",
        ] {
            let complaints = two_sided(bsdf);
            assert!(
                complaints.len() == 1 && complaints[0].contains("two sides already"),
                "{complaints:?}"
            );
        }
    }
}
