//! Fields of view along the sides of a picture.

use bevy::prelude::*;

declare_names! {
    /// The extent of the picture along which a field of view is measured.
    #[derive(Reflect, Clone, Copy, Debug, Default, PartialEq, Eq)]
    pub enum FovAxis {
        /// Its width.
        #[default]
        X = "x" => "horizontal",
        /// Its height.
        Y = "y" => "vertical",
        /// From corner to corner.
        Diagonal = "diagonal" => "diagonal",
        /// The smaller one of width and height.
        Smaller = "smaller" => "smaller edge",
        /// The larger one of width and height.
        Larger = "larger" => "larger edge",
    }
}

impl FovAxis {
    /// The field of view along x in degrees, from one along this axis; `aspect` is width over height.
    pub fn horizontal(self, fov: f32, aspect: f32) -> f32 {
        let half = (0.5 * fov).to_radians().tan();
        let half_width = match self {
            Self::X => return fov,
            Self::Smaller if aspect <= 1.0 => return fov,
            Self::Larger if aspect >= 1.0 => return fov,
            Self::Y | Self::Smaller | Self::Larger => half * aspect,
            Self::Diagonal => half / (1.0 + 1.0 / (aspect * aspect)).sqrt(),
        };
        2.0 * half_width.atan().to_degrees()
    }

    /// The inverse of [`Self::horizontal`]: the field of view along this axis in degrees, from that along x.
    pub(crate) fn of_horizontal(self, fov: f32, aspect: f32) -> f32 {
        let half_width = (0.5 * fov).to_radians().tan();
        let half = match self {
            Self::X => return fov,
            Self::Smaller if aspect <= 1.0 => return fov,
            Self::Larger if aspect >= 1.0 => return fov,
            Self::Y | Self::Smaller | Self::Larger => half_width / aspect,
            Self::Diagonal => half_width * (1.0 + 1.0 / (aspect * aspect)).sqrt(),
        };
        2.0 * half.atan().to_degrees()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn field_of_view_along_every_axis() {
        // The tangents of the half angles are 1 along x on a 2:1 film, 1/2 along y, and sqrt(5)/2 along the diagonal.
        let degrees = |half_tangent: f32| 2.0 * half_tangent.atan().to_degrees();
        let table = [
            (FovAxis::X, 2.0, degrees(1.0)),
            (FovAxis::Y, 2.0, degrees(0.5)),
            (FovAxis::Smaller, 2.0, degrees(0.5)),
            (FovAxis::Larger, 2.0, degrees(1.0)),
            (FovAxis::Diagonal, 2.0, degrees(1.25f32.sqrt())),
            (FovAxis::Smaller, 0.5, degrees(1.0)),
            (FovAxis::Larger, 0.5, degrees(2.0)),
        ];
        for (axis, aspect, fov) in table {
            let horizontal = axis.horizontal(fov, aspect);
            assert!((horizontal - 90.0).abs() < 1e-4, "{axis:?} {aspect}: {horizontal}");
            assert!((axis.of_horizontal(horizontal, aspect) - fov).abs() < 1e-3);
        }
    }
}
