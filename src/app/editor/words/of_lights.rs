//! The parameters of textures and of lights.

use super::parameter::{DEGREES, FACTOR, SWITCH, WHEEL, Words, words};

pub static TABLE: &[Words] = &[
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
