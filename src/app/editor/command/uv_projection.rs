//! New texture coordinates for shapes: what they are projected from.

/// The way in which texture coordinates follow from places in the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Projection {
    /// From where.
    pub from: ProjectedFrom,
    /// The edge of a tile of the texture in units of the world, above 0.
    pub tile: f32,
}

/// The directions from which textures are projected.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ProjectedFrom {
    /// The six sides of a box along the axes of the world: each face from the one that it faces most.
    Box,
    /// The side that most of the shape's surface faces.
    Face,
    /// The camera's direction of view.
    View,
    /// The upward direction.
    Above,
    /// A sphere around the middle of each shape.
    Sphere,
    /// A cylinder around the upright line through the middle of each shape.
    Cylinder,
}

impl ProjectedFrom {
    /// All of them, with their names in scripts and in the form.
    pub const ALL: [(Self, &'static str, &'static str); 6] = [
        (Self::Box, "box", "Sides of a box"),
        (Self::Face, "face", "Main face"),
        (Self::View, "view", "View"),
        (Self::Above, "above", "Above"),
        (Self::Sphere, "sphere", "Sphere"),
        (Self::Cylinder, "cylinder", "Cylinder"),
    ];
}
