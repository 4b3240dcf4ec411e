//! The declarations of the parameters of textures.

use super::parameter_info::ParameterInfo;

pub(crate) const FILENAME: ParameterInfo = ParameterInfo::new(
    "filename",
    "Picture",
    "A file with a picture: PNG, JPEG, EXR, HDR, PFM, BMP, TGA or PPM.",
    "a file, found from the scene's folder",
);

pub(crate) const FILTER_TYPE: ParameterInfo = ParameterInfo::new(
    "filter_type",
    "Filter",
    "What lies between two pixels: a blend of the four around it, or the nearest as it is.",
    "bilinear or nearest",
);

pub(crate) const WRAP_MODE: ParameterInfo = ParameterInfo::new(
    "wrap_mode",
    "Outside",
    "What lies outside of the picture: it again, its mirror image, or its edge for ever.",
    "repeat, mirror or clamp",
);

pub(crate) const WRAP_MODE_V: ParameterInfo = ParameterInfo::new(
    "wrap_mode_v",
    "Outside (v)",
    "The same along v alone, where it differs from that along u.",
    "repeat, mirror or clamp",
);

pub(crate) const RAW: ParameterInfo = ParameterInfo::switch(
    "raw",
    "Raw numbers",
    "Takes the numbers as they stand in the file: for normals, roughness and the like. Off, they are colours and pictures of 8 or 16 bits are decoded from sRGB.",
);

pub(crate) const TO_UV: ParameterInfo = ParameterInfo::new(
    "to_uv",
    "Placing",
    "Where on the surface the texture lies: uv is multiplied, turned and moved before the picture is looked up.",
    "factors (2 shows it twice), degrees, and shares of the picture",
);

pub(crate) const COLOR0: ParameterInfo = ParameterInfo::new(
    "color0",
    "Colour 1",
    "Colour of the square at the origin of uv.",
    "linear colour, or another texture",
);

pub(crate) const COLOR1: ParameterInfo = ParameterInfo::new(
    "color1",
    "Colour 2",
    "Colour of the other squares.",
    "linear colour, or another texture",
);

/// The name of a mesh attribute.
pub(crate) const NAME: ParameterInfo = ParameterInfo::new(
    "name",
    "Attribute",
    "What the mesh file calls the values: vertex_color, or another that begins with vertex_ or face_.",
    "a name",
);

/// The factor on a mesh attribute.
pub(crate) const SCALE: ParameterInfo =
    ParameterInfo::new("scale", "Factor", "Multiplies the values of the mesh.", "any number");

/// The texture that multiplies a mesh attribute.
pub(crate) const TIMES: ParameterInfo = ParameterInfo::new(
    "times",
    "Times",
    "A texture that multiplies the values of the mesh, as a picture with vertex colours over it.",
    "a texture",
);

/// The plugin of a constant texture.
pub(crate) const UNIFORM: &str = "uniform";
