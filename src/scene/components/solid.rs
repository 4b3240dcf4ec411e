//! Parametric building parts: walls with openings, stairs, prisms. Each stands on the plane z = 0 of its own space.
//!
//! These plugins are extensions of the format. A file holds the parameters; meshes are made from them
//! ([`crate::scene::assets::solid_mesh`]), also when `convert` writes a scene for other programs.

use bevy::math::Vec3;
use bevy::reflect::Reflect;

use super::declare::{PluginInfo, declare_plugins};
use super::parameter_info::ParameterInfo;
use super::parameters::{Declared, ParameterMut, ParameterRef};
use super::wall_openings::{MOST_OPENINGS, Opening};

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
    }
}

/// A length with the limits of the panel; files may have smaller ones ([`ParameterInfo::file_range`]).
const fn extent(name: &'static str, label: &'static str, about: &'static str) -> ParameterInfo {
    ParameterInfo::new(name, label, about, "a length above 0").within(1e-4..=f32::MAX)
}

const HEIGHT: ParameterInfo = extent("height", "Height", "The extent upwards.");

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
        }
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
