//! The commands that a user can give: [`Command`], and the plain values that commands carry. This module imports no
//! other module of the editor.

pub mod addition;
pub mod arrange;
pub mod asset_kind;
pub mod axis_view;
pub mod baking;
pub mod blocking;
pub mod bvh_overlay;
pub mod compare_view;
pub mod conversion;
pub mod display;
pub mod dragged;
pub mod error;
pub mod file;
pub mod file_access;
pub mod file_dialog;
pub mod gizmo_settings;
pub mod grid_settings;
pub mod history;
pub mod inspected_paths;
pub mod kept_picture;
pub mod key_bindings;
pub mod lamps;
pub(crate) mod lenient;
pub mod light_mix;
pub mod light_paint;
pub mod material;
pub mod material_tree;
pub mod media;
pub mod meter_choice;
pub mod navigation_preset;
pub mod outline;
pub mod panel;
pub mod preferences;
pub mod presets;
pub mod properties;
pub mod recovery_offer;
pub mod render;
pub mod resolution;
pub mod ruler;
pub mod samples;
pub mod scene;
pub mod seeing;
pub mod selection;
pub mod settings;
pub mod shell;
pub mod shortcut;
pub mod side_views;
pub mod snapping;
pub mod stored_view;
pub mod texture_placing;
pub mod timeline;
pub mod tool;
pub mod traits;
pub mod uv_projection;
pub mod value;
pub mod view;

pub use self::arrange::ArrangeEdit;
pub use self::baking::BakeCommand;
pub use self::display::DisplayCommand;
pub use self::file::FileCommand;
pub use self::file_dialog::FileDialogKind;
pub use self::history::HistoryCommand;
pub use self::kept_picture::KeptPicture;
pub use self::light_paint::LightPaintCommand;
pub use self::material::MaterialEdit;
pub use self::media::MediumEdit;
pub use self::outline::OutlineEdit;
pub use self::properties::PropertyEdit;
pub use self::render::RenderCommand;
pub use self::scene::SceneEdit;
pub use self::selection::SelectionCommand;
pub use self::settings::SettingsEdit;
pub use self::shell::ShellCommand;
pub use self::texture_placing::TextureEdit;
pub use self::timeline::{TimeCommand, TimeEdit};
pub use self::tool::ToolCommand;
use self::traits::Traits;
pub use self::value::ValueEdit;
pub use self::view::{CameraEdit, ViewCommand};

/// Declares an enum of topics, each an enum of commands in a file of its own.
macro_rules! declare_topics {
    ($(#[$doc:meta])* $tree:ident: $($(#[$topic_doc:meta])* $name:ident($topic:ty),)*) => {
        $(#[$doc])*
        #[derive(Clone, Debug, PartialEq)]
        pub enum $tree {
            $($(#[$topic_doc])* $name($topic),)*
        }

        impl $tree {
            /// The effect of the command, its title in the history, and its flags.
            pub fn traits(&self) -> Traits {
                match self {
                    $(Self::$name(command) => command.traits(),)*
                }
            }
        }

        $(impl From<$topic> for $tree {
            fn from(command: $topic) -> Self {
                Self::$name(command)
            }
        })*
    };
    ($(#[$doc:meta])* $tree:ident in $branch:ident: $($(#[$topic_doc:meta])* $name:ident($topic:ty),)*) => {
        declare_topics! { $(#[$doc])* $tree: $($(#[$topic_doc])* $name($topic),)* }

        $(impl From<$topic> for Command {
            fn from(command: $topic) -> Self {
                Self::$branch(command.into())
            }
        })*
    };
}

declare_topics! {
    /// A command of the user with all its data. Applied to the same state, it always does the same.
    Command:
    /// An edit of the scene: a step of the history.
    Edit(EditCommand),
    /// A command about files.
    File(FileCommand),
    /// A command that walks through the history.
    History(HistoryCommand),
    /// A command about the selection.
    Selection(SelectionCommand),
    /// A command that moves the view.
    View(ViewCommand),
    /// A command that chooses the time that is shown.
    Time(TimeCommand),
    /// A command that controls the rendering of the picture.
    Render(RenderCommand),
    /// A command that chooses how the picture is shown.
    Display(DisplayCommand),
    /// A command about tools.
    Tool(ToolCommand),
    /// A command about the bake of the scene's lightmaps.
    Bake(BakeCommand),
    /// A command about the picture that is kept beside the scene.
    KeptPicture(KeptPicture),
    /// A command for the window itself.
    Shell(ShellCommand),
}

declare_topics! {
    /// An edit of the scene with all its data.
    EditCommand in Edit:
    /// Creates and removes things.
    Scene(SceneEdit),
    /// Moves the selection relative to something else.
    Arrange(ArrangeEdit),
    /// Names, order, groups and marks.
    Outline(OutlineEdit),
    /// The materials of shapes.
    Material(MaterialEdit),
    /// Textures and their coordinates.
    Texture(TextureEdit),
    /// Media of shapes, cameras and lights.
    Medium(MediumEdit),
    /// The value of a component of a thing.
    Value(ValueEdit),
    /// Sets a value of a thing, and makes the same change to all selected things of its kind.
    OnSelection(Box<ValueEdit>),
    /// The properties for the code of a game.
    Property(PropertyEdit),
    /// The settings of the scene.
    Settings(SettingsEdit),
    /// The camera in use.
    Camera(CameraEdit),
    /// Animated values.
    Time(TimeEdit),
}
