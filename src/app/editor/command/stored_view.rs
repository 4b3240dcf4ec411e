//! Views stored under the numbers 1 to 9.

use bevy::math::{Affine3A, Mat3A, Vec3A};
use serde::{Deserialize, Serialize};

/// A stored view.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(from = "Written", into = "Written")]
pub struct StoredView {
    /// World from camera, with the extent of the picture as its scale if it is orthographic.
    pub pose: Affine3A,
    /// Whether the view is orthographic.
    pub orthographic: bool,
    /// Whether walls between the camera and a room are hidden, without which a view from above shows a roof.
    pub hides_walls: bool,
}

/// The views by their number less one.
pub type StoredViews = [Option<StoredView>; 9];

/// The view as in the file.
#[derive(Serialize, Deserialize)]
struct Written {
    /// The axes to the left, up and forward, and the place.
    world_from_camera: [[f32; 3]; 4],
    #[serde(default)]
    orthographic: bool,
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    hides_walls: bool,
}

impl StoredView {
    /// Whether the pose can be used as a view. A file may hold any numbers.
    pub fn is_possible(&self) -> bool {
        self.pose.is_finite() && self.pose.matrix3.determinant() != 0.0
    }
}

impl From<StoredView> for Written {
    fn from(view: StoredView) -> Self {
        let axes = view.pose.matrix3;
        let columns = [axes.x_axis, axes.y_axis, axes.z_axis, view.pose.translation];
        Self {
            world_from_camera: columns.map(|column| column.to_array()),
            orthographic: view.orthographic,
            hides_walls: view.hides_walls,
        }
    }
}

impl From<Written> for StoredView {
    fn from(written: Written) -> Self {
        let [x, y, z, place] = written.world_from_camera.map(Vec3A::from_array);
        Self {
            pose: Affine3A {
                matrix3: Mat3A::from_cols(x, y, z),
                translation: place,
            },
            orthographic: written.orthographic,
            hides_walls: written.hides_walls,
        }
    }
}
