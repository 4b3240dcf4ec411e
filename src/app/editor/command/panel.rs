//! The panels, each declared by one row.

use serde::{Deserialize, Serialize};

/// The side of the viewport at which a panel is until the user moves it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Side {
    /// The left.
    Left,
    /// The right.
    Right,
}

/// What a panel is like until the user changes it.
struct Row {
    title: &'static str,
    short_title: &'static str,
    side: Side,
    /// Whether the panel is shown at the first start.
    is_open: bool,
    /// Whether the panel scrolls its own contents.
    scrolls: bool,
}

/// Declares the panels beside the viewport: title, short title, side, whether the panel is open at the first start, and
/// whether it scrolls its own contents.
macro_rules! panels {
    ($($(#[$doc:meta])* $Panel:ident: $title:literal, $short:literal, $side:ident, $open:literal, $scrolls:literal;)*) => {
        /// A part of the window that can be moved to another place, and closed, except the viewport.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
        #[serde(rename_all = "kebab-case")]
        pub enum Panel {
            /// The picture.
            Viewport,
            $($(#[$doc])* $Panel,)*
        }

        impl Panel {
            /// The panels that can be closed and shown again, in the order of the menu.
            pub const CLOSEABLE: &[Self] = &[$(Self::$Panel),*];

            const fn row(self) -> Row {
                let (title, short_title, side, is_open, scrolls) = match self {
                    Self::Viewport => ("Viewport", "View", Side::Left, true, true),
                    $(Self::$Panel => ($title, $short, Side::$side, $open, $scrolls),)*
                };
                Row { title, short_title, side, is_open, scrolls }
            }
        }
    };
}

panels! {
    /// The list of all things of the scene.
    Outliner: "Outliner", "Outl.", Left, true, true;
    /// The library of materials.
    Library: "Library", "Lib.", Left, true, true;
    /// Folders of pictures, meshes and scenes.
    Assets: "Assets", "Assets", Left, true, true;
    /// The parameters of the selection.
    Inspector: "Inspector", "Insp.", Right, true, false;
    /// Samples, limits, integrator, light mixing and comparison.
    Render: "Render", "Rend.", Right, true, false;
    /// The steps that can be undone and redone.
    History: "History", "Hist.", Right, true, true;
    /// The problems with the scene and its files.
    Messages: "Messages", "Mess.", Right, true, false;
    /// The paths of an inspected pixel, vertex by vertex.
    Paths: "Paths", "Paths", Right, false, false;
    /// The measuring points and grids with their values.
    Meter: "Meter", "Meter", Right, false, false;
    /// Counts, memory, and the things that are costly to trace.
    Statistics: "Statistics", "Stat.", Right, false, false;
    /// The bake of lightmaps that is under way.
    Bake: "Bake", "Bake", Right, false, false;
}

impl Panel {
    /// The word on the tab and in the menu.
    pub fn title(self) -> &'static str {
        self.row().title
    }

    /// The shorter word for narrow tabs.
    pub fn short_title(self) -> &'static str {
        self.row().short_title
    }

    /// The side of the panel until the user moves it.
    pub(crate) fn side(self) -> Side {
        self.row().side
    }

    /// Whether the panel is shown at the first start, and not on demand only.
    pub(crate) fn is_open(self) -> bool {
        self.row().is_open
    }

    /// Whether the panel scrolls its own contents.
    pub(crate) fn scrolls(self) -> bool {
        self.row().scrolls
    }

    /// The panels of a side, in the order of their tabs.
    pub(crate) fn on(side: Side) -> impl Iterator<Item = Self> {
        let all = Self::CLOSEABLE.iter().copied();
        all.filter(move |panel| panel.side() == side)
    }
}
