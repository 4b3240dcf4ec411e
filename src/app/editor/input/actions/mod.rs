//! The table of actions, each of which is one key, one menu entry or one word. The keyboard, the menus, the palette, the overview of shortcuts and
//! scripts share it.

mod table;

use bevy_egui::egui::Key;

use super::press::Press;
use crate::app::editor::command::Command;
use crate::app::editor::command::bvh_overlay::BvhOverlay;
use crate::app::editor::command::display::DisplaySettings;
use crate::app::editor::command::gizmo_settings::GizmoSettings;
use crate::app::editor::command::grid_settings::GridSettings;
use crate::app::editor::command::selection::Selection;
use crate::app::editor::command::tool::Tool;
pub use table::ACTIONS;

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
    /// Whether the safe frame is shown.
    pub safe_frame: bool,
    /// The grid, which is shown or hidden.
    pub grid: GridSettings,
    /// Whether the dimensions of the selection are shown in the picture.
    pub dimensions: bool,
    /// Whether the user flies. Control means slow then, and is no part of a shortcut.
    pub flying: bool,
}

/// A key with its modifiers; `command` is Control, on a Mac the command key.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shortcut {
    /// The key that goes down last.
    pub key: Key,
    /// Whether Control, or the command key of a Mac, is held.
    pub command: bool,
    /// Whether Shift is held.
    pub shift: bool,
    /// Whether Alt is held.
    pub alt: bool,
    /// A digit of the block at the keyboard's right.
    pub numpad: bool,
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
    /// The keys, any of which will do; the first is shown.
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
    /// The menu of camera and display.
    View,
    /// Samples, denoiser, comparison.
    Render,
    /// Panels, preferences, help.
    Window,
}

impl Group {
    /// The groups with their headings, in the order of the menus.
    pub const ALL: [(Self, &'static str); 6] = [
        (Self::File, "File"),
        (Self::Edit, "Edit"),
        (Self::Add, "Add"),
        (Self::View, "View"),
        (Self::Render, "Render"),
        (Self::Window, "Window"),
    ];
}

impl Shortcut {
    pub(crate) fn is_pressed(&self, press: &Press) -> bool {
        let modifiers = press.modifiers;
        press.key == self.key
            && press.numpad == self.numpad
            && modifiers.command == self.command
            && modifiers.shift == self.shift
            && modifiers.alt == self.alt
    }

    /// The text of a shortcut, such as `Ctrl+Shift+Z`.
    pub fn text(&self) -> String {
        // Users do not think of the question mark as a key with Shift.
        let shift = self.shift && self.key != Key::Questionmark;
        let modifiers = [(self.command, "Ctrl+"), (self.alt, "Alt+"), (shift, "Shift+")];
        let mut text: String = modifiers
            .into_iter()
            .filter(|(held, _)| *held)
            .map(|(_, name)| name)
            .collect();
        text += if self.numpad { "Numpad " } else { "" };
        text += self.key.symbol_or_name();
        text
    }
}

/// The action of this name.
pub fn find(name: &str) -> Option<&'static Action> {
    ACTIONS.iter().find(|action| action.name == name)
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
            Command::ShowSafeFrame(shown) => self.safe_frame = *shown,
            Command::SetGrid(grid) => self.grid = *grid,
            Command::ShowDimensions(shown) => self.dimensions = *shown,
            Command::ShowPanels(shown) => self.panels_shown = *shown,
            _ => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_name_and_no_key_means_two_things() {
        for (place, action) in ACTIONS.iter().enumerate() {
            for other in &ACTIONS[..place] {
                assert_ne!(action.name, other.name);
                assert!(
                    !action.keys.iter().any(|key| other.keys.contains(key)),
                    "{}",
                    action.name
                );
            }
        }
    }

    #[test]
    fn keys_are_named_as_people_do() {
        let all = Shortcut {
            key: Key::Z,
            command: true,
            shift: true,
            alt: true,
            numpad: false,
        };
        assert_eq!(all.text(), "Ctrl+Alt+Shift+Z");
        let slash = Shortcut {
            key: Key::Questionmark,
            command: false,
            alt: false,
            ..all
        };
        assert_eq!(slash.text(), "?");
    }
}
