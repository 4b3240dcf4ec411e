//! The parameters of bsdfs.

use super::parameter::{SHARE, SWITCH, UNIT, WHEEL, Words, words};

pub static TABLE: &[Words] = &[
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
];
