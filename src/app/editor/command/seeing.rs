//! What the view leaves out, so that one can look into rooms and at single things. None of it is part of the scene, or
//! of a rendered picture.

/// The parts that the camera of the window does not see, and lines over them.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Seeing {
    /// The walls between the camera and a room.
    pub walls: Walls,
    /// The plane before which nothing is seen; None without one.
    pub cut: Option<CutOpen>,
    /// Whether the selection's mesh is drawn as lines.
    pub wireframe: bool,
}

/// Whether surfaces are seen whose front points away from the camera: for a room whose walls show their fronts inwards,
/// the walls between it and the camera.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Walls {
    /// They are seen.
    #[default]
    Shown,
    /// They are not seen because the user looks along an axis. This holds until the user looks through a camera: a view
    /// that turns away from the axis still looks into the room.
    HiddenForAxis,
    /// They are not seen.
    Hidden,
}

/// A plane across an axis of the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CutOpen {
    /// The axis that it is across: 0 for x, 1 for y, 2 for z.
    pub axis: usize,
    /// Its place along the axis, in world units.
    pub at: f32,
    /// Whether everything above it along the axis is left out; otherwise everything below.
    pub above: bool,
}

impl Seeing {
    /// The same with walls shown if they are hidden, or the other way round.
    pub fn with_walls_switched(self) -> Self {
        let walls = match self.walls {
            Walls::Shown => Walls::Hidden,
            Walls::Hidden | Walls::HiddenForAxis => Walls::Shown,
        };
        Self { walls, ..self }
    }

    /// The texts about it over the picture, each with the name of the action that ends it.
    pub fn notes(&self) -> impl Iterator<Item = (&'static str, &'static str)> {
        let walls = (self.walls != Walls::Shown).then_some(("Walls hidden", "see-into-rooms"));
        walls.into_iter().chain(self.cut.map(|_| ("Cut open", "cut-open")))
    }
}

/// The names of the axes.
pub const AXES: [&str; 3] = ["X", "Y", "Z"];
