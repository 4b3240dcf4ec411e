//! Detects a clip plane that cuts off the whole scene: the picture is then black or all sky without a visible cause.

use crate::accel::Tlas;
use crate::render::camera::Camera;

/// The most items of a scene that is checked: for larger scenes the search takes too long for a warning.
const MOST_ITEMS: u32 = 10_000;

/// The warning if all shapes in front of the camera are beyond the far clip plane, or before the near one.
pub(super) fn clipping_warning(geometry: &Tlas, camera: &Camera) -> Option<String> {
    let (near, far) = camera.clip_distances();
    let (mut first, mut last) = (f32::INFINITY, 0.0f32);
    for item in 0..=MOST_ITEMS {
        let Some(bounds) = geometry.bounds_of(item) else {
            break;
        };
        if bounds.is_empty() {
            continue;
        }
        let (least, most) = camera.depth_range(&bounds);
        let is_behind = most <= 0.0;
        if !is_behind {
            (first, last) = (first.min(least), last.max(most));
        }
        if item == MOST_ITEMS || !is_behind && least < far && most > near {
            return None;
        }
    }
    if last == 0.0 {
        return None;
    }
    Some(if first >= far {
        format!("the far clip plane leaves the whole scene out: it is at {far}, where the scene begins at {first}")
    } else if last <= near {
        format!("the near clip plane leaves the whole scene out: it is at {near}, where the scene ends at {last}")
    } else {
        format!("the clip planes leave the whole scene out: nothing lies between {near} and {far}")
    })
}

#[cfg(test)]
mod tests {
    use bevy::math::{Affine3A, Vec3};

    use super::*;
    use crate::accel::{Instance, Primitive, SplitMethod};

    /// The warning for spheres of radius 1 at these depths in front of a camera at the origin.
    fn warning(depths: &[f32], near: f32, far: f32) -> Option<String> {
        let sphere = |&depth: &f32| {
            let place = Affine3A::from_translation(Vec3::Z * depth);
            Instance::new(Primitive::Sphere, place).expect("an invertible transform")
        };
        let geometry = Tlas::build(depths.iter().map(sphere).collect(), SplitMethod::Sah);
        clipping_warning(&geometry, &Camera::new(Affine3A::IDENTITY, 40.0, 1.0, near, far, None))
    }

    #[test]
    fn what_hides_everything_is_named() {
        let far = warning(&[-9.0, 4.0, 6.0], 0.1, 2.0).expect("nothing is seen");
        assert!(far.starts_with("the far clip plane") && far.contains(" 2,"), "{far}");
        let near = warning(&[4.0, 6.0], 9.0, 20.0).expect("nothing is seen");
        assert!(near.starts_with("the near clip plane"), "{near}");
        assert!(warning(&[1.5, 9.0], 4.0, 5.0).is_some(), "neither alone");
    }

    #[test]
    fn nothing_is_said_where_something_is_seen_or_there_is_nothing_to_see() {
        for (depths, near, far) in [
            (&[4.0, 60.0][..], 0.1, 10.0),
            (&[0.0], 0.1, 0.5),
            (&[], 0.1, 10.0),
            // The camera looks in the opposite direction.
            (&[-4.0, -9.0], 0.1, 1.0),
        ] {
            assert_eq!(warning(depths, near, far), None, "{depths:?} {near} {far}");
        }
    }
}
