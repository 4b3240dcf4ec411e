//! What parameters are called in the panels, and what is told of them: one table for bsdfs, textures and lights.
//!
//! Meanings are those of the format (its documentation describes the same plugins); what is said of units and ranges holds for this
//! program too. Names are those of the file.

/// All about one parameter.
#[derive(Debug, PartialEq)]
pub struct Words {
    /// The plugins it is about; empty for all that have no entry of their own.
    plugins: &'static [&'static str],
    /// In the file.
    pub name: &'static str,
    /// In the panel: short enough for its column.
    pub label: &'static str,
    /// What it does.
    pub about: &'static str,
    /// What values it takes, with their unit.
    pub range: &'static str,
    /// Behind the number in the panel.
    pub suffix: &'static str,
}

impl Words {
    const fn of(mut self, plugins: &'static [&'static str]) -> Self {
        self.plugins = plugins;
        self
    }

    const fn in_units(mut self, suffix: &'static str) -> Self {
        self.suffix = suffix;
        self
    }
}

const fn words(name: &'static str, label: &'static str, about: &'static str, range: &'static str) -> Words {
    Words {
        plugins: &[],
        name,
        label,
        about,
        range,
        suffix: "",
    }
}

/// The words for a parameter of a plugin; None for what no plugin has.
pub fn find(plugin: &str, name: &str) -> Option<&'static Words> {
    let own = |words: &&Words| words.name == name && words.plugins.contains(&plugin);
    let common = |words: &&Words| words.name == name && words.plugins.is_empty();
    TABLE.iter().find(own).or_else(|| TABLE.iter().find(common))
}

const SHARE: &str = "0 to 1 per channel, or a texture";
const UNIT: &str = "0 to 1, or a texture";
const FACTOR: &str = "0 or more; 1 leaves it as it is";
const SWITCH: &str = "on or off";
const DEGREES: &str = "degrees";
const WHEEL: &str = "0 or more; 0 never, 1 as usual. The picture does not depend on it, only its noise";

static TABLE: &[Words] = &[
    // Surfaces.
    words(
        "reflectance",
        "Reflectance",
        "The share of the light that is scattered back, by colour.",
        SHARE,
    ),
    words(
        "diffuse_reflectance",
        "Base",
        "Colour of the matt base below the clear layer: the share of the light that it scatters back.",
        SHARE,
    ),
    words(
        "specular_reflectance",
        "Reflection",
        "Factor on what is mirrored. Real materials have 1: anything else is there for looks.",
        SHARE,
    ),
    words(
        "specular_transmittance",
        "Transmission",
        "Factor on what is let through. Tints glass at its surface, however thick it is.",
        SHARE,
    ),
    words(
        "material",
        "Metal",
        "A metal by its chemical name, with indices as they were measured; or eta and k as numbers.",
        "a name of the list",
    ),
    words(
        "eta",
        "Eta",
        "Real part of the metal's index of refraction, by colour.",
        "0 to 100 per channel, or a texture",
    ),
    words(
        "eta",
        "Index",
        "Index of refraction of the sheet over that around it.",
        "0.01 to 100, or a texture; glass has 1.5",
    )
    .of(&["principledthin"]),
    words(
        "eta",
        "Index",
        "Index of refraction inside over outside: how strongly the surface mirrors and, where it is glass, how far it bends light.",
        "0.01 to 100; plastic and glass have 1.5, water 1.33",
    )
    .of(&["principled"]),
    words(
        "k",
        "K",
        "Extinction: imaginary part of the metal's index of refraction, by colour. It is what makes a metal opaque.",
        "0 to 100 per channel, or a texture",
    ),
    words(
        "int_ior",
        "Inside",
        "Index of refraction on the side that the normal turns away from: the glass, the water, the clear layer.",
        "a medium of the list, or a number from 0.01 to 100",
    ),
    words(
        "ext_ior",
        "Outside",
        "Index of refraction on the side of the normal, air as a rule.",
        "a medium of the list, or a number from 0.01 to 100",
    ),
    words(
        "distribution",
        "Facets",
        "How the slopes of the surface's tiny facets are spread. GGX has longer tails: highlights with a wide glow, as measured surfaces have them.",
        "Beckmann or GGX",
    ),
    words(
        "alpha",
        "Roughness",
        "Spread of the slopes of tiny facets: the root of their mean square. Small is shiny.",
        "0.0001 to 1 and beyond, or a texture; 0.001 to 0.01 polished, 0.1 to 0.3 satin, 0.5 matt",
    ),
    words(
        "alpha_u",
        "Roughness u",
        "Spread of the facets' slopes along the first tangent, in which u grows: apart from the other it looks brushed.",
        "0.0001 to 1 and beyond, or a texture",
    ),
    words(
        "alpha_v",
        "Roughness v",
        "Spread of the facets' slopes along the second tangent, in which v grows.",
        "0.0001 to 1 and beyond, or a texture",
    ),
    words(
        "multiple_scattering",
        "All bounces",
        "Counts light that bounces between facets more than once, which the model leaves out: rough metals keep their brightness. Known to this program only.",
        SWITCH,
    ),
    words(
        "nonlinear",
        "Nonlinear",
        "Lets the colour grow more saturated as light bounces about between base and clear layer.",
        SWITCH,
    ),
    words(
        "fuzz",
        "Fuzz",
        "How far the mirrored direction is moved by chance: a simple blur.",
        UNIT,
    ),
    // Principled.
    words(
        "base_color",
        "Base colour",
        "Colour of the matt part, and of the mirror image where it is metal.",
        SHARE,
    ),
    words(
        "roughness",
        "Roughness",
        "How blurred mirror images and what is seen through it are. The facets' spread is its square.",
        UNIT,
    ),
    words(
        "anisotropic",
        "Anisotropy",
        "Stretches highlights across the direction in which u grows, as brushing does.",
        "0 round to 1 stretched, or a texture",
    ),
    words(
        "metallic",
        "Metallic",
        "From plastic to metal, which mirrors in its own colour and has nothing matt.",
        UNIT,
    ),
    words(
        "spec_trans",
        "Glass",
        "From opaque to clear: the share of light that is refracted instead of scattered.",
        UNIT,
    ),
    words(
        "specular",
        "Specular",
        "How strongly a surface that is no metal mirrors head on: the reflectance there over 0.08.",
        "0 to 1; 0.5 is an index of refraction of 1.5",
    ),
    words(
        "spec_tint",
        "Mirror tint",
        "Tints the mirror image of what is no metal with the base colour.",
        UNIT,
    ),
    words(
        "sheen",
        "Sheen",
        "A glow towards the outline, as on cloth.",
        UNIT,
    ),
    words(
        "sheen_tint",
        "Sheen tint",
        "Tints the sheen with the base colour.",
        UNIT,
    ),
    words(
        "flatness",
        "Flatness",
        "From matt to the flatter look of light that has wandered below the surface, as in skin or wax.",
        UNIT,
    ),
    words(
        "clearcoat",
        "Clear coat",
        "A second, clear layer of lacquer above the rest.",
        UNIT,
    ),
    words(
        "clearcoat_gloss",
        "Coat gloss",
        "How sharp the clear coat's highlights are.",
        "0 satin to 1 gloss, or a texture",
    ),
    words(
        "diff_trans",
        "See-through",
        "How much of the matt light leaves on the other side, as through a leaf or paper.",
        "0 to 2, or a texture; 1 is half of it",
    ),
    words(
        "main_specular_sampling_rate",
        "Mirror rays",
        "How often rays follow the main mirror image, relative to the other parts.",
        WHEEL,
    ),
    words(
        "clearcoat_sampling_rate",
        "Coat rays",
        "How often rays follow the clear coat, relative to the other parts.",
        WHEEL,
    ),
    words(
        "diffuse_reflectance_sampling_rate",
        "Matt rays",
        "How often rays follow the matt part, relative to the others.",
        WHEEL,
    ),
    words(
        "specular_reflectance_sampling_rate",
        "Mirror rays",
        "How often rays follow the mirror image, relative to the other parts.",
        WHEEL,
    ),
    words(
        "specular_transmittance_sampling_rate",
        "Clear rays",
        "How often rays go clearly through the sheet, relative to the other parts.",
        WHEEL,
    ),
    words(
        "diffuse_transmittance_sampling_rate",
        "Through rays",
        "How often rays follow the matt light to the other side, relative to the other parts.",
        WHEEL,
    ),
    // Materials with others inside.
    words(
        "weight",
        "Weight",
        "The share of the second material; the first has the rest.",
        UNIT,
    ),
    words(
        "opacity",
        "Opacity",
        "The share of the material inside; the rest of the light goes straight through, as through a leaf's cut-out.",
        UNIT,
    ),
    words(
        "normalmap",
        "Normals",
        "A picture of normals: red along u, green along v, blue outwards, each 0 to 1 for -1 to 1. It is to be read raw.",
        "a texture",
    ),
    words(
        "height",
        "Height",
        "How far the surface is moved outwards, for its normals only: the outline stays. Bitmaps give bumps; what has no slope gives none.",
        "units of the scene, from a texture",
    ),
    words(
        "scale",
        "Scale",
        "Factor on the height; below 0 bumps turn into dents.",
        "any number",
    )
    .of(&["bumpmap"]),
    words(
        "flip_invalid_normals",
        "Flip invalid",
        "Turns normals that face away from the viewer about the true one, so that they stay lit.",
        SWITCH,
    ),
    words(
        "use_shadowing_function",
        "Soft shadows",
        "Softens the hard border of light and shadow that bent normals make.",
        SWITCH,
    ),
    // Textures.
    words(
        "filename",
        "Picture",
        "A file with a picture: PNG, JPEG, EXR, HDR, PFM, BMP, TGA or PPM.",
        "a file, found from the scene's folder",
    ),
    words(
        "filter_type",
        "Filter",
        "What lies between two pixels: a blend of the four around it, or the nearest as it is.",
        "bilinear or nearest",
    ),
    words(
        "wrap_mode",
        "Outside",
        "What lies outside of the picture: it again, its mirror image, or its edge for ever.",
        "repeat, mirror or clamp",
    ),
    words(
        "raw",
        "Raw numbers",
        "Takes the numbers as they stand in the file: for normals, roughness and the like. Off, they are colours and pictures of 8 or 16 bits are decoded from sRGB.",
        SWITCH,
    ),
    words(
        "to_uv",
        "Placing",
        "Where on the surface the texture lies: uv is multiplied, turned and moved before the picture is looked up.",
        "factors (2 shows it twice), degrees, and shares of the picture",
    ),
    words(
        "color0",
        "Colour 1",
        "Colour of the square at the origin of uv.",
        "linear colour, or another texture",
    ),
    words(
        "color1",
        "Colour 2",
        "Colour of the other squares.",
        "linear colour, or another texture",
    ),
    words(
        "name",
        "Attribute",
        "What the mesh file calls the values: vertex_color, or another that begins with vertex_ or face_.",
        "a name",
    )
    .of(&["mesh_attribute"]),
    words(
        "scale",
        "Factor",
        "Multiplies the values of the mesh.",
        "any number",
    )
    .of(&["mesh_attribute"]),
    // Lights.
    words(
        "radiance",
        "Radiance",
        "How bright the surface looks, or what comes from each direction: power per area and solid angle.",
        "W/m²sr, 0 or more",
    )
    .in_units(" W/m²sr"),
    words(
        "intensity",
        "Intensity",
        "Power per solid angle; of a spot along its axis. On a surface it falls with the square of the distance.",
        "W/sr, 0 or more",
    )
    .in_units(" W/sr"),
    words(
        "irradiance",
        "Irradiance",
        "Power that arrives per area on a surface that faces the light.",
        "W/m², 0 or more",
    )
    .in_units(" W/m²"),
    words(
        "irradiance",
        "Picture",
        "The picture that is thrown; its brightness times pi is the power per area at distance 1 in front of the light.",
        "W/m², or a texture",
    )
    .of(&["projector"])
    .in_units(" W/m²"),
    words(
        "sampling_weight",
        "Sampled",
        "How often the light is looked for, relative to the others; 0 leaves it to be met by chance.",
        WHEEL,
    ),
    words(
        "scale",
        "Strength",
        "Factor on the radiance of the picture.",
        FACTOR,
    )
    .of(&["envmap"]),
    words(
        "scale",
        "Strength",
        "Factor on the light.",
        FACTOR,
    )
    .of(&["projector"]),
    words(
        "filename",
        "Picture",
        "A picture of all directions: width is the way around, height from straight up to straight down. HDR and EXR keep the sun's strength.",
        "a file, found from the scene's folder",
    )
    .of(&["envmap"]),
    words(
        "mis_compensation",
        "Seek bright",
        "Looks less for those directions of the picture that surfaces find by themselves: less noise, the same picture.",
        SWITCH,
    ),
    words(
        "cutoff_angle",
        "Cutoff",
        "Angle from the axis beyond which there is no light.",
        "degrees, above 0 and up to 90",
    )
    .in_units("°"),
    words(
        "beam_width",
        "Beam",
        "Angle from the axis within which the light has all of its strength; from there to the cutoff it fades.",
        "degrees, 0 up to the cutoff",
    )
    .in_units("°"),
    words(
        "texture",
        "Slide",
        "A picture across the cone, as a slide in front of the lamp: factor on the intensity.",
        "a texture, or none",
    ),
    words(
        "fov",
        "Field of view",
        "Angle across the picture.",
        "degrees, above 0 and below 180",
    )
    .in_units("°"),
    words(
        "fov_axis",
        "Measured",
        "Along which edge of the picture the field of view is measured.",
        "horizontal, vertical, diagonal, smaller or larger edge",
    ),
    words(
        "turbidity",
        "Turbidity",
        "Haze: how much light dust and vapour scatter, relative to clear air.",
        "1 to 10; 2 is a clear day, 3 usual, 10 hazy",
    ),
    words(
        "albedo",
        "Ground",
        "Reflectance of the ground, which lights the sky from below.",
        "0 to 1 per channel",
    ),
    words("sun_scale", "Sun", "Factor on the light of the sun.", FACTOR),
    words("sky_scale", "Sky", "Factor on the light of the sky.", FACTOR),
    words(
        "sun_aperture",
        "Sun size",
        "Angle under which the sun is seen. A larger one has softer shadows and the same light.",
        "degrees, 0.01 to 179; the true one is 0.5338",
    )
    .in_units("°"),
    words(
        "complex_sun",
        "Dark rim",
        "Lets the sun be darker and redder towards its rim, as it is.",
        SWITCH,
    ),
    words(
        "sun_direction",
        "Towards sun",
        "Direction in which the sun stands, in the space of the light: z is up.",
        "a vector of any length",
    ),
    words("latitude", "Latitude", "Of the place, north positive.", DEGREES).in_units("°"),
    words("longitude", "Longitude", "Of the place, east positive.", DEGREES).in_units("°"),
    words(
        "timezone",
        "Time zone",
        "How far local time is ahead of universal time.",
        "hours, -24 to 24",
    )
    .in_units(" h"),
    words("year", "Year", "Of the date.", "-4000 to 9999"),
    words("month", "Month", "Of the date.", "1 to 12"),
    words("day", "Day", "Of the date.", "1 to 31"),
    words("hour", "Hour", "Local time.", "hours").in_units(" h"),
    words("minute", "Minute", "Local time.", "minutes").in_units(" min"),
    words("second", "Second", "Local time.", "seconds").in_units(" s"),
];

#[cfg(test)]
mod tests {
    use std::path::{Path, PathBuf};

    use bevy_egui::egui;

    use super::super::fields::NAME_WIDTH;
    use super::*;
    use crate::color::Rgb;
    use crate::document::Object;
    use crate::scene::{
        AreaLight, ConductorIor, Emitter, Material, Parameter, PrincipledIndex, Roughness, SquarePath, SunPosition,
        SunSky, Texture, write,
    };
    use bevy::math::{Affine2, Affine3A, Vec2, Vec3};

    /// Every name that plugins are written with, and the plugin: what the writer knows is what the format has.
    fn written() -> Vec<(String, String)> {
        let folder = Path::new("/");
        let mut materials: Vec<Material> = Material::PLUGINS.into_iter().filter_map(Material::of_plugin).collect();
        let mut brushed = Material::of_plugin("roughconductor").expect("a plugin");
        if let Material::RoughConductor {
            alpha,
            ior,
            multiple_scattering,
            ..
        } = &mut brushed
        {
            *alpha = Roughness::Anisotropic {
                u: 0.1.into(),
                v: 0.2.into(),
            };
            *ior = ConductorIor::Given {
                eta: Rgb::ONE.into(),
                k: Rgb::ONE.into(),
            };
            *multiple_scattering = true;
        }
        let mut by_index = Material::of_plugin("principled").expect("a plugin");
        if let Material::Principled(principled) = &mut by_index {
            std::sync::Arc::make_mut(principled).index = PrincipledIndex::Eta(1.5);
        }
        let to_uv = Affine2::from_scale(Vec2::splat(2.0));
        let bitmap = Texture::of_picture(PathBuf::from("/a.png"), None);
        let textures = [
            Texture::MeshAttribute {
                name: "vertex_color".into(),
                scale: 1.0,
            },
            Texture::Checkerboard {
                color0: Box::new(Parameter::Texture(bitmap.clone())),
                color1: Box::new(Rgb::ONE.into()),
                to_uv: Box::new(to_uv),
            },
            bitmap.clone(),
        ];
        let heights = textures.into_iter().map(|texture| Material::BumpMap {
            height: Parameter::Texture(texture),
            scale: 1.0,
            flip_invalid_normals: true,
            use_shadowing_function: true,
        });
        materials.extend([brushed, by_index]);
        materials.extend(heights);
        let mut found = Vec::new();
        for material in &materials {
            collect(&write::objects::material(material, folder), &mut found);
        }
        let by_direction = SunSky {
            sun: SunPosition::Direction(Vec3::X),
            ..SunSky::default()
        };
        let mut emitters: Vec<Emitter> = Emitter::PLUGINS.into_iter().filter_map(Emitter::of_plugin).collect();
        emitters.push(crate::scene::EmitterKind::SunSky(by_direction).into());
        for emitter in &mut emitters {
            emitter.set_picture(SquarePath::WHOLE, "/a.png".into());
            // The usual one is left out.
            emitter.sampling_weight = 0.5;
            collect(
                &write::lights::emitter(emitter, &Affine3A::IDENTITY, folder),
                &mut found,
            );
        }
        collect(&write::lights::area_light(&AreaLight::default(), folder), &mut found);
        found
    }

    fn collect(object: &Object, found: &mut Vec<(String, String)>) {
        for property in &object.properties {
            // Where a light is: a matter of the transform.
            if !["to_world", "position", "direction"].contains(&property.name.as_str()) {
                found.push((object.plugin.to_string(), property.name.to_string()));
            }
        }
        for child in object.objects() {
            if let Some(name) = &child.name {
                found.push((object.plugin.to_string(), name.to_string()));
            }
            collect(child, found);
        }
    }

    #[test]
    fn every_parameter_of_every_plugin_is_explained() {
        let written = written();
        let missing: Vec<_> = written
            .iter()
            .filter(|(plugin, name)| {
                find(plugin, name).is_none_or(|words| words.about.is_empty() || words.range.is_empty())
            })
            .collect();
        assert!(missing.is_empty(), "{missing:?}");
        // As many as there are in the format, so that the collection cannot be empty.
        assert!(written.len() > 120, "{}", written.len());
    }

    #[test]
    fn labels_fit_their_column() {
        let mut widths = Vec::new();
        egui_kittest::Harness::new_ui(|ui| {
            let font = egui::TextStyle::Body.resolve(ui.style());
            let width = |text: &str| {
                let layout = ui
                    .painter()
                    .layout_no_wrap(text.to_owned(), font.clone(), egui::Color32::WHITE);
                layout.size().x
            };
            widths = TABLE.iter().map(|words| (words.label, width(words.label))).collect();
        })
        .run();
        assert_eq!(widths.len(), TABLE.len());
        for (label, width) in widths {
            assert!(width <= NAME_WIDTH, "{label}: {width}");
        }
    }

    #[test]
    fn nothing_is_explained_that_no_plugin_has() {
        let written = written();
        for words in TABLE {
            let is_met = written
                .iter()
                .any(|(plugin, name)| find(plugin, name).is_some_and(|found| std::ptr::eq(found, words)));
            assert!(is_met, "{words:?}");
        }
    }
}
