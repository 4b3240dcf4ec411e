//! The things that can be added to the scene, and their places.

use bevy::math::Vec3;

use crate::photometry::lamps::{LAMPS, Lamp};
use crate::scene::{Emitter, Solid};

/// A new thing in the scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Addition {
    /// The kind, which decides the plugin.
    pub kind: AdditionKind,
    /// The name. None: it is named after its kind.
    pub name: Option<String>,
    /// Its place in world space. None: on the surface in the middle of the picture, and the first thing at the origin.
    pub at: Option<Vec3>,
    /// Half its extent in world units; None for one that suits the view.
    pub size: Option<f32>,
}

/// The kinds of things that the menu *Add* and scripts offer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum AdditionKind {
    /// A sphere.
    Sphere,
    /// A flat square, lying.
    Rectangle,
    /// A cube.
    Cube,
    /// A flat disk, lying.
    Disk,
    /// An open cylinder, upright.
    Cylinder,
    /// A building part: one of [`Solid::PLUGINS`].
    Solid(&'static str),
    /// Fog in the whole scene: a box around everything.
    Fog,
    /// A cube of fog.
    FogBox,
    /// A rectangle that shines downwards.
    AreaLight,
    /// One of [`Emitter::PLUGINS`].
    Emitter(&'static str),
    /// One of [`LAMPS`] with its light.
    Lamp(&'static Lamp),
    /// A camera with the pose of the view.
    Camera,
}

impl From<AdditionKind> for Addition {
    fn from(kind: AdditionKind) -> Self {
        Self {
            kind,
            name: None,
            at: None,
            size: None,
        }
    }
}

impl AdditionKind {
    pub(crate) const SHAPES: [Self; 11] = [
        Self::Sphere,
        Self::Rectangle,
        Self::Cube,
        Self::Disk,
        Self::Cylinder,
        Self::Solid("wall"),
        Self::Solid("stairs"),
        Self::Solid("prism"),
        Self::Solid("gableroof"),
        Self::Solid("hiproof"),
        Self::Solid("shedroof"),
    ];

    /// The word for it in names and scripts.
    pub fn name(self) -> &'static str {
        match self {
            Self::Sphere => "sphere",
            Self::Rectangle => "rectangle",
            Self::Cube => "cube",
            Self::Disk => "disk",
            Self::Cylinder => "cylinder",
            Self::Fog => "fog",
            Self::FogBox => "fog-box",
            Self::AreaLight => "area",
            Self::Emitter(plugin) | Self::Solid(plugin) => plugin,
            Self::Lamp(lamp) => lamp.name,
            Self::Camera => "camera",
        }
    }

    /// Half the height of a thing that is added without a size.
    pub(crate) fn usual_size(self) -> f32 {
        match self {
            Self::Solid(plugin) => Solid::of_plugin(plugin).map_or(1.0, |part| 0.5 * part.corners()[1].z),
            _ => 1.0,
        }
    }

    /// Shapes, fog, the area light, the camera, all kinds of emitters, then real lamps.
    pub fn all() -> impl Iterator<Item = Self> {
        let plain = [Self::Fog, Self::FogBox, Self::AreaLight, Self::Camera];
        let emitters = Emitter::PLUGINS.map(Self::Emitter);
        let lamps = LAMPS.iter().map(Self::Lamp);
        Self::SHAPES.into_iter().chain(plain).chain(emitters).chain(lamps)
    }

    pub(crate) fn of_name(name: &str) -> Option<Self> {
        Self::all().find(|kind| kind.name() == name)
    }
}
