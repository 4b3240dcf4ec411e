//! The lights of the scene. Units are radiometric but for the flux of lamps, which is in lumens.

use std::collections::HashMap;
use std::convert::identity;
use std::path::PathBuf;
use std::sync::LazyLock;

use bevy::math::Affine3A;
use bevy::prelude::*;

use super::declare::{PluginInfo, declare_parameters, declare_plugins};
use super::parameter_info::ParameterInfo;
use super::parameters::{CUTOFF_ANGLE, Cone, Declared, FOV, FieldOfView, ParameterMut, ParameterRef};
use super::sun_sky::SunSky;
use crate::color::{BRIGHTEST, Rgb};
use crate::scene::{DocumentOrder, FovAxis, Parameter, SquarePath, Texture, ToWorld};

declare_parameters! {
    /// Makes a shape emit from its front or from both sides, evenly in all directions.
    #[derive(Component, Reflect, Clone, Debug, PartialEq)]
    #[reflect(Component, PartialEq)]
    pub struct AreaLight {
        /// The radiance in W/(m^2 sr).
        radiance: Parameter<Rgb> = Rgb::ONE.into() => TexturedEmission(RADIANCE),
        /// Whether the back shines as the front does.
        two_sided: bool = false => Flag(ParameterInfo::switch(
            "two_sided",
            "Both sides",
            "The back shines as well, as in glTF files whose materials have two sides. Mitsuba's lights shine from the front alone.",
        )),
        /// The sampling weight, as that of [`Emitter`].
        sampling_weight: f32 = 1.0 => SamplingWeight(SAMPLING_WEIGHT),
    }
}

/// A light other than an emissive shape. Its position and direction are in [`ToWorld`].
#[derive(Component, Reflect, Clone, Debug, PartialEq)]
#[reflect(Component, PartialEq)]
#[require(ToWorld, DocumentOrder)]
pub struct Emitter {
    /// The plugin with its parameters.
    pub kind: EmitterKind,
    /// The factor on the probability with which it is sampled; with 0 it is found only by chance. It does not change
    /// the expected picture.
    pub sampling_weight: f32,
}

declare_plugins! {
    /// The kinds of lights other than emissive shapes.
    #[derive(Reflect, Clone, Debug, PartialEq)]
    pub enum EmitterKind {
        /// A point light of radiant intensity in W/sr.
        [PluginInfo::new("point", "point")]
        Point {
            /// Linear Rec. 709.
            intensity: Rgb = Rgb::ONE => Emission(INTENSITY),
        },

        /// Parallel light, by its irradiance on a surface that faces it, in W/m^2.
        [PluginInfo::new("directional", "directional")]
        Directional {
            /// Linear Rec. 709.
            irradiance: Rgb = Rgb::ONE => Emission(ParameterInfo::new(
                "irradiance",
                "Irradiance",
                "Power that arrives per area on a surface that faces the light.",
                "W/m², 0 or more",
            )
            .in_units(" W/m²")),
        },

        /// The same radiance from every direction, W/(m^2 sr).
        [PluginInfo::new("constant", "constant")]
        Constant {
            /// Linear Rec. 709.
            radiance: Rgb = Rgb::ONE => Emission(RADIANCE),
        },

        /// A picture of all directions, `scale` times its radiance.
        [PluginInfo::new("envmap", "environment map")]
        Environment {
            /// The absolute path of the picture.
            picture: PathBuf = PathBuf::new() => Picture(ParameterInfo::new(
                "filename",
                "Picture",
                "A picture of all directions: width is the way around, height from straight up to straight down. HDR and EXR keep the sun's strength.",
                "a file, found from the scene's folder",
            )),
            /// The factor on the picture, not negative.
            scale: f32 = 1.0 => Factor(ParameterInfo::factor(
                "scale",
                "Strength",
                "Factor on the radiance of the picture.",
            )),
            /// Whether directions that BSDF sampling covers are sampled less.
            mis_compensation: bool = true => Flag(ParameterInfo::switch(
                "mis_compensation",
                "Compensation",
                "MIS compensation (Karlik and others, 2019): light sampling leaves the dim directions of the picture to BSDF sampling. Less noise, the same picture.",
            )),
        },

        /// A cone of light along +z.
        [PluginInfo::new("spot", "spot")]
        Spot {
            /// The intensity along the axis, in W/sr.
            intensity: Rgb = Rgb::ONE => Emission(INTENSITY),
            /// The width of the cone.
            cone: Cone = Cone { cutoff_angle: 20.0, beam_width: 15.0 } => Cone(CUTOFF_ANGLE),
            /// The factor on the intensity, across the cone.
            texture: Option<Texture> = None => OptionalTexture(ParameterInfo::new(
                "texture",
                "Picture",
                "A picture across the cone, as a slide in front of the lamp: factor on the intensity.",
                "a texture, or none",
            )),
        },

        /// A point with the measured intensities of a lamp, whose beam goes along +z.
        [PluginInfo::new("ies", "IES lamp")]
        Luminaire {
            /// The absolute path of the file, IES LM-63 or EULUMDAT.
            profile: PathBuf = PathBuf::new() => Picture(ParameterInfo::new(
                "filename",
                "Lamp",
                "A file of measured intensities as lamp makers publish them: IES (LM-63) or EULUMDAT (.ldt).",
                "a file, found from the scene's folder",
            )),
            /// The factor on the intensities, by colour.
            scale: Rgb = Rgb::ONE => Emission(ParameterInfo::new(
                "scale",
                "Strength",
                "Factor on the intensities of the file, by colour.",
                "0 or more",
            )),
            /// The luminous flux in lumens that replaces the file's; 0 for the file's.
            flux: f32 = 0.0 => Number(FLUX),
        },

        /// Projects a picture along +z, as a camera would see it.
        [PluginInfo::new("projector", "projector")]
        Projector {
            /// Pi times the irradiance on the plane z = 1.
            irradiance: Parameter<Rgb> = Rgb::ONE.into() => TexturedEmission(ParameterInfo::new(
                "irradiance",
                "Picture",
                "The picture that is thrown; its brightness times pi is the power per area at distance 1 in front of the light.",
                "W/m², or a texture",
            )
            .in_units(" W/m²")),
            /// The factor on the irradiance, not negative.
            scale: f32 = 1.0 => Factor(ParameterInfo::factor("scale", "Strength", "Factor on the light.")),
            /// The field of view, as that of a sensor whose film is the picture.
            field_of_view: FieldOfView = FieldOfView { fov: 45.0, axis: FovAxis::X } => FieldOfView(FOV),
        },

        /// A clear sky with its sun.
        [PluginInfo::new("sunsky", "sun and sky")]
        SunSky(sky: SunSky => identity),

        /// No light: a box, the cube from -1 to 1, for whose surfaces `sunroom bake` makes a cube map from its centre.
        [PluginInfo::new("reflectionprobe", "reflection probe")]
        ReflectionProbe {
            /// Whether the surroundings stand on the sides of the box, rather than far away.
            parallax: bool = true => Flag(ParameterInfo::switch(
                "parallax",
                "Parallax",
                "On: what is mirrored stands on the sides of the box, as the walls of a room. Off: it is far away, as a sky.",
            )),
        },

        /// No light: a box, the cube from -1 to 1, in which `sunroom bake` finds the light for moving objects.
        [PluginInfo::new("irradiancevolume", "irradiance volume")]
        IrradianceVolume {
            /// The distance between the points of its grid, above 0.
            spacing: f32 = 0.5 => Number(ParameterInfo::new(
                "spacing",
                "Spacing",
                "The distance between the points where light is baked, in units of length.",
                "a length above 0",
            )
            .within(SPACING)),
        },

        /// No light: a point at which `sunroom measure` measures the illuminance on the side of +z.
        [PluginInfo::new("illuminancemeter", "measuring point")]
        IlluminanceMeter {
            /// The least illuminance that passes, in lux; 0 for no limit.
            least: f32 = 0.0 => Number(LEAST),
        },

        /// No light: a square from -1 to 1 along x and y, over which illuminance is measured on the side of +z.
        [PluginInfo::new("illuminancegrid", "measuring grid")]
        IlluminanceGrid {
            /// The largest distance between the points of its grid, above 0.
            spacing: f32 = 0.5 => Number(ParameterInfo::new(
                "spacing",
                "Spacing",
                "The largest distance between the points where light is measured, in units of length.",
                "a length above 0",
            )
            .within(SPACING)),
            /// The least illuminance of a point that passes, in lux; 0 for no limit.
            least: f32 = 0.0 => Number(LEAST),
            /// The mean illuminance that passes, in lux; 0 for no limit.
            mean: f32 = 0.0 => Number(ParameterInfo::new(
                "mean",
                "Mean",
                "The mean illuminance that is asked for. 0 asks for none.",
                "lx, 0 or more",
            )
            .within(0.0..=BRIGHTEST)
            .in_units(" lx")),
            /// The ratio of the least to the mean illuminance that passes; 0 for no limit.
            uniformity: f32 = 0.0 => Number(ParameterInfo::new(
                "uniformity",
                "Uniformity",
                "The least over the mean illuminance that is asked for. 0 asks for none.",
                "0 to 1",
            )
            .within(0.0..=1.0)),
        },

        /// No light: a place with a direction, +z, for the code of a game.
        [PluginInfo::new("markerpoint", "marker")]
        MarkerPoint,

        /// No light: a box, the cube from -1 to 1, for the code of a game.
        [PluginInfo::new("markerbox", "box marker")]
        MarkerBox,

        /// No light: a sphere of radius 1 for the code of a game.
        [PluginInfo::new("markersphere", "sphere marker")]
        MarkerSphere,

        /// No light: a line through points for the code of a game. The points are a property.
        [PluginInfo::new("markerpath", "path")]
        MarkerPath,
    }
}

const LEAST: ParameterInfo = ParameterInfo::new(
    "least",
    "Least",
    "The illuminance that is asked for at every point. 0 asks for none.",
    "lx, 0 or more",
)
.within(0.0..=BRIGHTEST)
.in_units(" lx");

/// The allowed distances between the points of a volume or a grid.
const SPACING: std::ops::RangeInclusive<f32> = 1e-4..=f32::MAX;

/// The luminous flux of a lamp with measured intensities.
pub(crate) const FLUX: ParameterInfo = ParameterInfo::new(
    "flux",
    "Lumens",
    "The light of the lamp in all directions, in lumens, at a strength of 1. With 0 it is the file's.",
    "lm, 0 or more",
)
.within(0.0..=BRIGHTEST);

const RADIANCE: ParameterInfo = ParameterInfo::new(
    "radiance",
    "Radiance",
    "How bright the surface looks, or what comes from each direction: power per area and solid angle.",
    "W/m²sr, 0 or more",
)
.in_units(" W/m²sr");

const INTENSITY: ParameterInfo = ParameterInfo::new(
    "intensity",
    "Intensity",
    "Power per solid angle; of a spot along its axis. On a surface it falls with the square of the distance.",
    "W/sr, 0 or more",
)
.in_units(" W/sr");

const SAMPLING_WEIGHT: ParameterInfo = ParameterInfo::sampling_rate(
    "sampling_weight",
    "Sampling",
    "Sampling weight: how often light sampling chooses this light, relative to the others. 0 leaves it to paths that hit it by chance. Only the noise changes.",
);

impl Default for Emitter {
    fn default() -> Self {
        EmitterKind::Constant { radiance: Rgb::ONE }.into()
    }
}

impl From<EmitterKind> for Emitter {
    fn from(kind: EmitterKind) -> Self {
        Self {
            kind,
            sampling_weight: 1.0,
        }
    }
}

/// The light of every plugin with default parameters.
static USUAL: LazyLock<HashMap<&str, Emitter>> = LazyLock::new(|| {
    let made = |plugin| Some((plugin, Emitter::of_plugin(plugin)?));
    Emitter::PLUGINS.into_iter().filter_map(made).collect()
});

impl Declared for Emitter {
    fn visit<'p>(&'p self, meet: &mut impl FnMut(&'static ParameterInfo, ParameterRef<'p>)) {
        self.kind.visit(meet);
        if self.shines() {
            meet(&SAMPLING_WEIGHT, ParameterRef::SamplingWeight(&self.sampling_weight));
        }
    }

    fn visit_mut(&mut self, meet: &mut impl FnMut(&'static ParameterInfo, ParameterMut)) {
        self.kind.visit_mut(meet);
        if self.shines() {
            meet(
                &SAMPLING_WEIGHT,
                ParameterMut::SamplingWeight(&mut self.sampling_weight),
            );
        }
    }
}

impl Emitter {
    /// The names of all plugins.
    pub const PLUGINS: [&'static str; EmitterKind::DECLARED.len()] = EmitterKind::PLUGINS;

    /// The light of a plugin with default parameters; None if there is no such plugin.
    pub fn of_plugin(plugin: &str) -> Option<Self> {
        EmitterKind::of_plugin(plugin).map(Self::from)
    }

    /// The shared light of a plugin with default parameters.
    pub(crate) fn usual(plugin: &str) -> Option<&'static Self> {
        USUAL.get(plugin)
    }

    /// The declaration of its plugin.
    pub(crate) fn info(&self) -> &'static PluginInfo {
        self.kind.info()
    }

    /// The plugin's name in the file.
    pub fn plugin(&self) -> &'static str {
        self.kind.plugin()
    }

    /// Calls `meet` with the absolute path of every picture.
    pub(crate) fn for_each_picture(&self, meet: &mut impl FnMut(&PathBuf)) {
        let texture = match &self.kind {
            EmitterKind::Environment { picture, .. } | EmitterKind::Luminaire { profile: picture, .. } => {
                return meet(picture);
            }
            EmitterKind::Spot { texture, .. } => texture.as_ref(),
            EmitterKind::Projector {
                irradiance: Parameter::Texture(texture),
                ..
            } => Some(texture),
            _ => None,
        };
        if let Some(texture) = texture {
            texture.for_each_bitmap(&mut |bitmap| meet(&bitmap.path));
        }
    }

    /// Sets the picture of the light, or of the texture at a place in its parameter; lights without pictures stay
    /// unchanged.
    pub fn set_picture(&mut self, place: SquarePath, path: PathBuf) {
        match &mut self.kind {
            EmitterKind::Environment { picture, .. } | EmitterKind::Luminaire { profile: picture, .. } => {
                *picture = path;
            }
            EmitterKind::Spot { texture, .. } => {
                let mut slide = match texture.take() {
                    Some(texture) => Parameter::Texture(texture),
                    None => Parameter::Constant(Rgb::ONE),
                };
                slide.set_picture_at(place, path.into());
                if let Parameter::Texture(slide) = slide {
                    *texture = Some(slide);
                }
            }
            EmitterKind::Projector { irradiance, .. } => irradiance.set_picture_at(place, path.into()),
            _ => {}
        }
    }

    /// Whether it is infinitely far away in many directions: then only the rotation of its transform matters.
    pub(crate) fn is_environment(&self) -> bool {
        matches!(self.kind, EmitterKind::Environment { .. } | EmitterKind::SunSky(_))
    }

    /// Whether it surrounds the scene. Mitsuba takes one such light.
    pub fn is_sky(&self) -> bool {
        self.is_environment() || matches!(self.kind, EmitterKind::Constant { .. })
    }

    /// Whether it is a box that is baked for games, and gives no light itself.
    pub fn is_probe(&self) -> bool {
        matches!(
            self.kind,
            EmitterKind::ReflectionProbe { .. } | EmitterKind::IrradianceVolume { .. }
        )
    }

    /// Whether it measures light, and gives none itself.
    pub fn is_meter(&self) -> bool {
        matches!(
            self.kind,
            EmitterKind::IlluminanceMeter { .. } | EmitterKind::IlluminanceGrid { .. }
        )
    }

    /// Whether it gives light: probes, meters and markers do not.
    pub fn shines(&self) -> bool {
        !self.is_probe() && !self.is_meter() && !self.is_marker()
    }

    /// Whether it has a position, unlike lights that are infinitely far away.
    pub(crate) fn has_place(&self) -> bool {
        !self.is_sky() && !matches!(self.kind, EmitterKind::Directional { .. })
    }
}

/// A frame with +z along `direction` (not zero); its other axes are arbitrary but deterministic.
pub(crate) fn frame_along(direction: Vec3) -> Affine3A {
    let forward = direction.normalize();
    let (left, up) = forward.any_orthonormal_pair();
    Affine3A::from_mat3(glam::Mat3::from_cols(left, up, forward))
}
