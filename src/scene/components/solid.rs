//! Parametric building parts: walls with openings, stairs, prisms, roofs. Each stands on the plane z = 0 of its own
//! space, and only the eaves of roofs hang below it.
//!
//! These plugins are extensions of the format. A file holds the parameters; meshes are made from them
//! ([`crate::scene::assets::solid_mesh`]), also when `convert` writes a scene for other programs.

use bevy::math::Vec3;
use bevy::reflect::Reflect;

use super::declare::{PluginInfo, declare_plugins};
use super::parameter_info::ParameterInfo;
use super::parameters::{Declared, ParameterMut, ParameterRef};
use super::wall_openings::{MOST_OPENINGS, Opening};
use crate::geometry::solid::{Roof, RoofForm};

declare_plugins! {
    /// A building part.
    #[derive(Reflect, Clone, Debug, PartialEq)]
    pub enum Solid {
        /// A wall along +x from the origin, its thickness half to either side of y = 0.
        [PluginInfo::new("wall", "wall")]
        Wall {
            length: f32 = 4.0 => Length(extent("length", "Length", "The extent from its start to its end.")),
            height: f32 = 2.5 => Length(HEIGHT),
            thickness: f32 = 0.2 => Length(
                extent("thickness", "Thickness", "The extent across, half to either side of its middle.")
            ),
            openings: Vec<Opening> = Vec::new() => Openings(ParameterInfo::new(
                "openings",
                "Openings",
                "Doors and windows.",
                "for each the distance from the start, the height of the lower edge, the width and the height, with ; between them",
            )),
        },

        /// Solid stairs that begin at y = 0, rise along +y and are centred on x = 0.
        [PluginInfo::new("stairs", "stairs")]
        Stairs {
            width: f32 = 1.0 => Length(extent("width", "Width", "The extent across.")),
            depth: f32 = 4.0 => Length(extent("depth", "Depth", "The extent from the first step to the back.")),
            height: f32 = 2.5 => Length(HEIGHT),
            steps: u32 = 14 => Count(
                ParameterInfo::new("steps", "Steps", "The number of steps, all equal.", "1 to 200").within(1.0..=200.0)
            ),
        },

        /// A regular prism, frustum or pyramid around the z axis; one of its sides faces -y.
        [PluginInfo::new("prism", "prism")]
        Prism {
            radius: f32 = 0.5 => Length(extent("radius", "Radius", "The distance of the lower corners from the axis.")),
            top_radius: f32 = 0.5 => Length(ParameterInfo::new(
                "top_radius",
                "Top radius",
                "The distance of the upper corners from the axis.",
                "0 or more; 0 is a point",
            )
            .within(0.0..=f32::MAX)),
            height: f32 = 1.0 => Length(HEIGHT),
            sides: u32 = 6 => Count(
                ParameterInfo::new("sides", "Sides", "The number of sides.", "3 to 256").within(3.0..=256.0)
            ),
        },

        /// A roof of two slopes over a rectangle around the z axis, with its ridge along x.
        [PluginInfo::new("gableroof", "gable roof")]
        GableRoof {
            width: f32 = 6.0 => Length(WIDTH),
            depth: f32 = 5.0 => Length(DEPTH),
            height: f32 = 1.75 => Length(RISE),
            overhang: f32 = 0.4 => Length(OVERHANG),
            thickness: f32 = 0.2 => Length(SLAB),
            gable: f32 = 0.2 => Length(GABLE),
        },

        /// A roof of four slopes of one pitch over a rectangle around the z axis.
        [PluginInfo::new("hiproof", "hip roof")]
        HipRoof {
            width: f32 = 6.0 => Length(WIDTH),
            depth: f32 = 5.0 => Length(DEPTH),
            height: f32 = 1.75 => Length(RISE),
            overhang: f32 = 0.4 => Length(OVERHANG),
            thickness: f32 = 0.2 => Length(SLAB),
        },

        /// A roof of one slope over a rectangle around the z axis, which rises along +y.
        [PluginInfo::new("shedroof", "shed roof")]
        ShedRoof {
            width: f32 = 6.0 => Length(WIDTH),
            depth: f32 = 5.0 => Length(DEPTH),
            height: f32 = 1.2 => Length(RISE),
            overhang: f32 = 0.4 => Length(OVERHANG),
            thickness: f32 = 0.2 => Length(SLAB),
            gable: f32 = 0.2 => Length(GABLE),
        },
    }
}

/// A length with the limits of the panel; files may have smaller ones ([`ParameterInfo::file_range`]).
const fn extent(name: &'static str, label: &'static str, about: &'static str) -> ParameterInfo {
    ParameterInfo::new(name, label, about, "a length above 0").within(1e-4..=f32::MAX)
}

/// A length that may be 0.
const fn distance(name: &'static str, label: &'static str, about: &'static str) -> ParameterInfo {
    ParameterInfo::new(name, label, about, "a length, 0 or more").within(0.0..=f32::MAX)
}

const HEIGHT: ParameterInfo = extent("height", "Height", "The extent upwards.");
const WIDTH: ParameterInfo = extent("width", "Width", "The extent along x of what is under the roof.");
const DEPTH: ParameterInfo = extent("depth", "Depth", "The extent along y of what is under the roof.");
const RISE: ParameterInfo = extent(
    "height",
    "Height",
    "The rise of the slopes over what is under the roof.",
);
const OVERHANG: ParameterInfo = distance(
    "overhang",
    "Overhang",
    "The level distance by which the roof goes beyond the walls.",
);
const SLAB: ParameterInfo = extent("thickness", "Thickness", "The thickness across the slopes.");
const GABLE: ParameterInfo = distance(
    "gable",
    "Gable walls",
    "The thickness of the walls below the slopes; with 0 there are none.",
);

impl Default for Solid {
    fn default() -> Self {
        Self::Wall {
            length: 4.0,
            height: 2.5,
            thickness: 0.2,
            openings: Vec::new(),
        }
    }
}

impl Solid {
    /// The most openings of a wall, so that the mesh of a mistyped file stays small.
    pub const MOST_OPENINGS: usize = MOST_OPENINGS;

    /// Calls a function with every length, including those of openings.
    pub(crate) fn visit_lengths(&mut self, visit: &mut dyn FnMut(&mut f32)) {
        self.visit_mut(&mut |_, value| match value {
            ParameterMut::Length(length) => visit(length),
            ParameterMut::Openings(openings) => {
                for opening in openings {
                    let Opening {
                        from,
                        sill,
                        width,
                        height,
                    } = opening;
                    [from, sill, width, height].into_iter().for_each(&mut *visit);
                }
            }
            _ => {}
        });
    }

    /// Two opposite corners of its bounding box, in its own space.
    pub fn corners(&self) -> [Vec3; 2] {
        match *self {
            Self::Wall {
                length,
                height,
                thickness,
                ..
            } => [
                Vec3::new(0.0, -0.5 * thickness, 0.0),
                Vec3::new(length, 0.5 * thickness, height),
            ],
            Self::Stairs {
                width, depth, height, ..
            } => [Vec3::new(-0.5 * width, 0.0, 0.0), Vec3::new(0.5 * width, depth, height)],
            Self::Prism {
                radius,
                top_radius,
                height,
                ..
            } => {
                let reach = radius.max(top_radius);
                [Vec3::new(-reach, -reach, 0.0), Vec3::new(reach, reach, height)]
            }
            Self::GableRoof { .. } | Self::HipRoof { .. } | Self::ShedRoof { .. } => {
                self.roof().map_or([Vec3::ZERO; 2], |roof| roof.corners())
            }
        }
    }

    /// The numbers of a roof; None for other parts.
    pub fn roof(&self) -> Option<Roof> {
        let (form, [width, depth, height, overhang, thickness, gable]) = match *self {
            Self::GableRoof {
                width,
                depth,
                height,
                overhang,
                thickness,
                gable,
            } => (RoofForm::Gable, [width, depth, height, overhang, thickness, gable]),
            Self::HipRoof {
                width,
                depth,
                height,
                overhang,
                thickness,
            } => (RoofForm::Hip, [width, depth, height, overhang, thickness, 0.0]),
            Self::ShedRoof {
                width,
                depth,
                height,
                overhang,
                thickness,
                gable,
            } => (RoofForm::Shed, [width, depth, height, overhang, thickness, gable]),
            Self::Wall { .. } | Self::Stairs { .. } | Self::Prism { .. } => return None,
        };
        Some(Roof {
            form,
            width,
            depth,
            height,
            overhang,
            thickness,
            gable,
        })
    }

    /// The roof of another form with the same lengths; None unless both are roofs.
    pub fn roof_as(&self, plugin: &str) -> Option<Self> {
        self.roof()?;
        let mut other = Self::of_plugin(plugin).filter(|other| other.roof().is_some())?;
        let mut known = Vec::new();
        self.clone().visit_mut(&mut |info, value| {
            if let ParameterMut::Length(length) = value {
                known.push((info.name, *length));
            }
        });
        other.visit_mut(&mut |info, value| {
            let same = known.iter().find(|(name, _)| *name == info.name);
            if let (ParameterMut::Length(length), Some((_, same))) = (value, same) {
                *length = *same;
            }
        });
        Some(other)
    }

    /// The part with all its lengths times this factor.
    pub fn scaled(mut self, factor: f32) -> Self {
        self.visit_lengths(&mut |length| *length *= factor);
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_roof_of_another_form_keeps_its_lengths() {
        let gable = Solid::GableRoof {
            width: 9.0,
            depth: 4.0,
            height: 3.0,
            overhang: 0.0,
            thickness: 0.1,
            gable: 0.5,
        };
        let hip = gable.roof_as("hiproof").expect("a roof");
        let expected = Solid::HipRoof {
            width: 9.0,
            depth: 4.0,
            height: 3.0,
            overhang: 0.0,
            thickness: 0.1,
        };
        assert_eq!(hip, expected);
        assert_eq!(gable.roof_as("wall"), None);
        assert_eq!(Solid::default().roof_as("hiproof"), None);
    }

    #[test]
    fn lengths_scale_and_counts_do_not() {
        let stairs = Solid::of_plugin("stairs").map(|stairs| stairs.scaled(2.0));
        let expected = Solid::Stairs {
            width: 2.0,
            depth: 8.0,
            height: 5.0,
            steps: 14,
        };
        assert_eq!(stairs, Some(expected));
    }
}
