//! Participating media: what fills the space between surfaces.
//!
//! There are none yet: all space is empty. This module names what surfaces and paths will say of media, so that it has its place in
//! their types. ARCHITECTURE.md says where the rest of them goes.

/// An index into the scene's table of media. That table is empty, so the type has no value.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum MediumId {}

/// The media on the two sides of a surface (PBR 4th ed., section 11.4); None is empty space.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct MediumInterface {
    /// On the side that the geometric normal points away from.
    pub interior: Option<MediumId>,
    /// On the side that the geometric normal points to.
    pub exterior: Option<MediumId>,
}
