//! The filters of the view, which show the inside of rooms and single things. None of them is part of the scene, or of
//! a rendered picture.

/// The parts that are hidden from the window's camera, and lines over them.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Seeing {
    /// The walls between the camera and a room.
    pub walls: Walls,
    /// The cut plane, before which everything is hidden; None without one.
    pub cut: Option<CutOpen>,
    /// Whether the selection's mesh is drawn as lines.
    pub wireframe: bool,
}

/// The visibility of surfaces whose front points away from the camera: in a room whose walls face inwards, the walls
/// between it and the camera.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Walls {
    /// They are visible.
    #[default]
    Shown,
    /// They are hidden because the user looks along an axis. This holds until the user looks through a camera: a view
    /// that turns away from the axis still looks into the room.
    HiddenForAxis,
    /// They are hidden.
    Hidden,
}

/// A plane across an axis of the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CutOpen {
    /// The axis along its normal: 0 for x, 1 for y, 2 for z.
    pub axis: usize,
    /// Its position along the axis, in world units.
    pub at: f32,
    /// Whether everything above it along the axis is hidden; otherwise everything below.
    pub above: bool,
}

impl Seeing {
    /// The same with the walls' visibility toggled.
    pub fn with_walls_switched(self) -> Self {
        let walls = match self.walls {
            Walls::Shown => Walls::Hidden,
            Walls::Hidden | Walls::HiddenForAxis => Walls::Shown,
        };
        Self { walls, ..self }
    }

    /// The texts about the filters over the picture, each with the name of the action that ends it.
    pub fn notes(&self) -> impl Iterator<Item = (&'static str, &'static str)> {
        let walls = (self.walls != Walls::Shown).then_some(("Walls hidden", "see-into-rooms"));
        walls.into_iter().chain(self.cut.map(|_| ("Cut open", "cut-open")))
    }
}

/// The names of the axes.
pub const AXES: [&str; 3] = ["X", "Y", "Z"];
