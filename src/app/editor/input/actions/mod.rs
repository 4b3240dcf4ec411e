//! The table of actions, each of which is one key, one menu entry or one word. The keyboard, the menus, the palette, the overview of shortcuts and
//! scripts share it.

mod arrange;
pub mod bindings;
mod table;

use crate::app::editor::command::Command;
use crate::app::editor::command::bvh_overlay::BvhOverlay;
use crate::app::editor::command::display::DisplaySettings;
use crate::app::editor::command::gizmo_settings::GizmoSettings;
use crate::app::editor::command::grid_settings::GridSettings;
use crate::app::editor::command::key_bindings::KeyBindings;
use crate::app::editor::command::seeing::Seeing;
use crate::app::editor::command::selection::Selection;
pub use crate::app::editor::command::shortcut::Shortcut;
use crate::app::editor::command::tool::Tool;

/// All actions, in the order of the menus.
pub const ACTIONS: &[Action] =
    &joined::<{ table::ACTIONS.len() + arrange::ACTIONS.len() }>(table::ACTIONS, arrange::ACTIONS);

const fn joined<const ALL: usize>(some: &[Action], others: &[Action]) -> [Action; ALL] {
    let mut all = [some[0]; ALL];
    let mut place = 0;
    while place < ALL {
        all[place] = if place < some.len() {
            some[place]
        } else {
            others[place - some.len()]
        };
        place += 1;
    }
    all
}

/// The state that actions toggle, step or refer to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ActionContext<'a> {
    /// The display settings, from which modes and exposure are stepped.
    pub display: DisplaySettings,
    /// The overlay, from which the depth is stepped.
    pub overlay: BvhOverlay,
    /// The gizmo's settings, from which modes and axes are switched.
    pub gizmo: GizmoSettings,
    /// Whether rendering is held.
    pub paused: bool,
    /// Whether there are panels beside the viewport.
    pub panels_shown: bool,
    /// The selection, which many actions need.
    pub selection: &'a Selection,
    /// A tool that is in use is given up by its own key.
    pub tool: Tool,
    /// The keys that the user has chosen.
    pub bound: &'a KeyBindings,
    /// Whether the safe frame is shown.
    pub safe_frame: bool,
    /// The grid, which is shown or hidden.
    pub grid: GridSettings,
    /// Whether the dimensions of the selection are shown in the picture.
    pub dimensions: bool,
    /// What the view leaves out, of which parts are switched.
    pub seeing: Seeing,
    /// Whether some shapes are shown alone.
    pub isolated: bool,
    /// Whether the user flies. Control means slow then, and is no part of a shortcut.
    pub flying: bool,
}

/// An action, which keys, menus, palette and scripts call by one name.
#[derive(Clone, Copy)]
pub struct Action {
    /// The name in scripts and the palette.
    pub name: &'static str,
    /// The label in menus and the palette.
    pub label: &'static str,
    /// Its menu, and its heading in the overview.
    pub group: Group,
    /// The keys of the program, any of which will do; `keys_in` gives those that the user has chosen instead.
    pub keys: &'static [Shortcut],
    /// The command. None: there is nothing to apply it to.
    pub command: fn(&ActionContext) -> Option<Command>,
}

/// The headings of the overview, and the menus.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Group {
    /// The menu of opening, saving and importing.
    File,
    /// The menu of history, selection and clipboard.
    Edit,
    /// The menu of new things.
    Add,
    /// The menu of places: steps, alignment, series.
    Arrange,
    /// The menu of camera and display.
    View,
    /// Samples, denoiser, comparison.
    Render,
    /// Panels, preferences, help.
    Window,
}

impl Group {
    /// The groups with their headings, in the order of the menus.
    pub const ALL: [(Self, &'static str); 7] = [
        (Self::File, "File"),
        (Self::Edit, "Edit"),
        (Self::Add, "Add"),
        (Self::Arrange, "Arrange"),
        (Self::View, "View"),
        (Self::Render, "Render"),
        (Self::Window, "Window"),
    ];

    /// The heading.
    pub fn title(self) -> &'static str {
        Self::ALL
            .iter()
            .find(|(group, _)| *group == self)
            .map_or("", |(_, title)| title)
    }
}

/// The action of this name.
pub fn find(name: &str) -> Option<&'static Action> {
    ACTIONS.iter().find(|action| action.name == name)
}

/// The text of the first key of the action with this name; empty without one.
pub fn key_text(name: &str, bound: &KeyBindings) -> String {
    find(name).map(|action| action.key_text(bound)).unwrap_or_default()
}

/// A tool tip with the key of the action behind it, such as `Samples are kept (Space)`.
pub fn hint(text: &str, name: &str, bound: &KeyBindings) -> String {
    match key_text(name, bound) {
        key if key.is_empty() => text.to_owned(),
        key => format!("{text} ({key})"),
    }
}

impl ActionContext<'_> {
    fn with_selection(&self, command: Command) -> Option<Command> {
        (!self.selection.is_empty()).then_some(command)
    }

    fn exposed(&self, stops: f32) -> Command {
        Command::SetDisplay(DisplaySettings {
            exposure: self.display.exposure + stops,
            ..self.display
        })
    }

    /// Updates the state after a command, for the next one.
    pub fn follow(&mut self, command: &Command) {
        match command {
            Command::SetDisplay(display) => self.display = *display,
            Command::SetOverlay(overlay) => self.overlay = *overlay,
            Command::SetGizmo(settings) => self.gizmo = *settings,
            Command::SetPaused(paused) => self.paused = *paused,
            Command::SetTool(tool) => self.tool = *tool,
            Command::SetSeeing(seeing) => self.seeing = *seeing,
            Command::Isolate(entities) => self.isolated = !entities.is_empty(),
            Command::ShowSafeFrame(shown) => self.safe_frame = *shown,
            Command::SetGrid(grid) => self.grid = *grid,
            Command::ShowDimensions(shown) => self.dimensions = *shown,
            Command::ShowPanels(shown) => self.panels_shown = *shown,
            _ => {}
        }
    }
}
