//! Patterns of the scene for the texture table.

use crate::color::Rgb;
use crate::scene::{Choice, Parameter, Pattern, Texture};
use crate::texture::pattern::{Bond, Bricks, CellValue, Cells, Mix, MixMode, Noise, Ramp, Stop, Wood};
use crate::texture::{self, BoxProjection, TextureId, Up};

/// The pattern with its nested textures, which `pack` adds to the table.
pub(crate) fn packed_pattern(pattern: &Pattern, pack: &mut dyn FnMut(&Texture) -> TextureId) -> texture::Texture {
    let mut nested = |parameter: &Parameter<Rgb>| match parameter {
        Parameter::Constant(color) => texture::Parameter::Constant(*color),
        Parameter::Texture(texture) => texture::Parameter::Texture(pack(texture)),
    };
    match pattern {
        Pattern::Noise {
            color0,
            color1,
            octaves,
            gain,
            distortion,
            ridged,
            to_uv,
        } => texture::Texture::Noise(Noise {
            colors: [nested(color0), nested(color1)],
            octaves: (*octaves).max(1).unsigned_abs(),
            gain: *gain,
            distortion: *distortion,
            ridged: *ridged,
            to_uv: *to_uv,
        }),
        Pattern::Cells {
            color0,
            color1,
            value,
            scatter,
            to_uv,
        } => texture::Texture::Cells(Cells {
            colors: [nested(color0), nested(color1)],
            value: CellValue::of_name(value.name()).unwrap_or_default(),
            scatter: *scatter,
            to_uv: *to_uv,
        }),
        Pattern::Bricks {
            color0,
            color1,
            joint_color,
            width,
            height,
            joint,
            bevel,
            bond,
            offset,
            to_uv,
        } => texture::Texture::Bricks(Bricks {
            colors: [nested(color0), nested(color1)],
            joint_color: nested(joint_color),
            size: [*width, *height],
            joint: *joint,
            bevel: *bevel,
            bond: Bond::of_name(bond.name()).unwrap_or_default(),
            offset: *offset,
            to_uv: *to_uv,
        }),
        Pattern::Wood {
            color0,
            color1,
            ring,
            waviness,
            to_uv,
        } => texture::Texture::Wood(Wood {
            colors: [nested(color0), nested(color1)],
            ring: *ring,
            waviness: *waviness,
            to_uv: *to_uv,
        }),
        Pattern::Ramp { input, stops, to_uv } => {
            let stop = |stop: &crate::scene::Stop| Stop {
                at: stop.at,
                color: stop.color,
            };
            texture::Texture::Ramp(Ramp {
                input: input.as_ref().map(|input| texture::Parameter::Texture(pack(input))),
                stops: stops.iter().map(stop).collect(),
                to_uv: *to_uv,
            })
        }
        Pattern::Mix {
            color0,
            color1,
            weight,
            mode,
        } => texture::Texture::Mix(Mix {
            colors: [nested(color0), nested(color1)],
            weight: nested(weight),
            mode: MixMode::of_name(mode.name()).unwrap_or_default(),
        }),
        Pattern::BoxProjection { input, up, to_uv } => texture::Texture::BoxProjection(BoxProjection {
            input: nested(input),
            up: up_axis(*up),
            to_uv: *to_uv,
        }),
    }
}

/// The axis of a box projection that is up.
pub(crate) fn up_axis(up: Choice) -> Up {
    Up::of_name(up.name()).unwrap_or_default()
}
