//! A tool that replaces selection for one click or drag in the picture.

/// A tool. It ends with Escape and after its use, except for those of paths and distances, which are used many times.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Tool {
    /// Selects, as without any tool.
    #[default]
    Select,
    /// Focuses a thin lens on the thing that is clicked.
    Focus,
    /// Draws the part of the picture that is rendered.
    Region,
    /// Shows the paths of the pixel that is clicked.
    Paths,
    /// Measures the distance between two points that are clicked.
    Ruler,
}

impl Tool {
    /// Whether the tool measures distances.
    pub fn measures(self) -> bool {
        self == Self::Ruler
    }

    /// The instruction that is shown over the picture.
    pub fn hint(self) -> Option<&'static str> {
        match self {
            Self::Select => None,
            Self::Focus => Some("Click what is to be sharp (Esc: never mind)"),
            Self::Region => Some("Drag a box around what is to be rendered (Esc: never mind)"),
            Self::Ruler => Some("Click two points to measure between them (Esc: done)"),
            Self::Paths => Some("Click a pixel to see its paths (Esc: done)"),
        }
    }
}
