//! Lamps with measured intensities, from the extension EXT_lights_ies: files of IES LM-63 that nodes refer to.
//!
//! The beam goes along -z of the node. Vertical angles turn it towards +x; horizontal ones turn it to +y for type C,
//! where they are counterclockwise, and to -y for types A and B, where they are clockwise.

use std::borrow::Cow;

use glam::{Mat4, Vec4};

use super::error::{GltfError, ReadFile};
use super::{Gltf, uri};
use crate::photometry::{Geometry, read_profile};

/// The most bytes of all profiles of a file together: many of them may be made of the same bytes.
pub(super) const MOST_PROFILE_BYTES: usize = 64 << 20;

/// A profile that was stored.
#[derive(Clone, Debug)]
pub struct KnownProfile {
    /// The name of its file.
    pub name: String,
    /// The meaning of its angles.
    pub geometry: Geometry,
}

/// The rotation from the space of a lamp of the scene format, whose beam goes along +z, to that of its node.
pub fn node_from_lamp(geometry: Geometry) -> Mat4 {
    let [x, y] = match geometry {
        Geometry::TypeC => [Vec4::X, Vec4::NEG_Y],
        Geometry::TypeA | Geometry::TypeB => [Vec4::Y, Vec4::X],
    };
    Mat4::from_cols(x, y, Vec4::NEG_Z, Vec4::W)
}

impl Gltf {
    /// The file of a light profile, and the meaning of its angles. `read` as for [`Self::open`].
    pub fn profile(&self, index: usize, read: &mut ReadFile) -> Result<(Cow<'_, [u8]>, Geometry), GltfError> {
        let bad = |what: String| GltfError::Profile { index, what };
        let profile = self.get("light profile", &self.root.extensions.profiles.lights, index)?;
        let bytes: Cow<[u8]> = match (&profile.uri, profile.buffer_view) {
            (Some(uri), _) => uri::content(uri, read)?.into(),
            (None, Some(view)) => self.view(view)?.into(),
            (None, None) => return Err(bad("neither a file nor bytes are given".to_owned())),
        };
        let distribution = read_profile(&bytes).map_err(|error| bad(error.to_string()))?;
        Ok((bytes, distribution.geometry()))
    }
}
