//! New texture coordinates for shapes by projection.

/// The map from world positions to texture coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Projection {
    /// The direction of the projection.
    pub from: ProjectedFrom,
    /// The edge of a tile of the texture in units of the world, above 0.
    pub tile: f32,
}

declare_names! {
    /// The directions from which textures are projected.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    pub enum ProjectedFrom {
        /// The six sides of a box along the axes of the world: each face from the one that it faces most.
        Box = "box" => "Sides of a box",
        /// The side that most of the shape's surface faces.
        Face = "face" => "Main face",
        /// The camera's direction of view.
        View = "view" => "View",
        /// The upward direction.
        Above = "above" => "Above",
        /// A sphere around the middle of each shape.
        Sphere = "sphere" => "Sphere",
        /// A cylinder around the upright line through the middle of each shape.
        Cylinder = "cylinder" => "Cylinder",
    }
}
