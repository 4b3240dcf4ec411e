//! The type of actions, the state that they refer to, and the parts of the rows of the tables.

use bevy_egui::egui::Key;

use crate::app::editor::command::bvh_overlay::BvhOverlay;
use crate::app::editor::command::display::DisplaySettings;
use crate::app::editor::command::gizmo_settings::GizmoSettings;
use crate::app::editor::command::grid_settings::GridSettings;
use crate::app::editor::command::key_bindings::{KeyBindings, NO_BINDINGS};
use crate::app::editor::command::meter_choice::MeterChoice;
use crate::app::editor::command::navigation_preset::NavigationPreset;
use crate::app::editor::command::seeing::{Seeing, Walls};
use crate::app::editor::command::selection::Selection;
use crate::app::editor::command::shortcut::Shortcut;
use crate::app::editor::command::side_views::SideViews;
use crate::app::editor::command::tool::Tool;
use crate::app::editor::command::{
    Command, DisplayCommand, KeptPicture, RenderCommand, ShellCommand, TimeCommand, ToolCommand, ViewCommand,
};

/// The state that actions toggle, step or read.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ActionContext<'a> {
    /// The display settings, from which modes and exposure are stepped.
    pub display: DisplaySettings,
    /// The overlay, from which the depth is stepped.
    pub overlay: BvhOverlay,
    /// The gizmo's settings, from which modes and axes are switched.
    pub gizmo: GizmoSettings,
    /// Whether rendering is paused.
    pub paused: bool,
    /// Whether the picture is denoised.
    pub denoising: bool,
    /// Whether panels beside the viewport are shown.
    pub panels_shown: bool,
    /// The selection, which many actions need.
    pub selection: &'a Selection,
    /// The tool in use. Its own key puts it away.
    pub tool: Tool,
    /// The keys that the user has chosen.
    pub bound: &'a KeyBindings,
    /// The quantities that meters measure.
    pub meters: MeterChoice,
    /// Whether the safe frame is shown.
    pub safe_frame: bool,
    /// The grid, which is shown or hidden.
    pub grid: GridSettings,
    /// Whether the dimensions of the selection are shown in the picture.
    pub dimensions: bool,
    /// The filters of the view, parts of which actions toggle.
    pub seeing: Seeing,
    /// Whether some shapes are isolated.
    pub isolated: bool,
    /// Whether flying keys walk.
    pub walks: bool,
    /// The views beside the main one, which are shown or hidden.
    pub side_views: SideViews,
    /// Whether the selected shape has textures that can be placed.
    pub has_textures: bool,
    /// Whether a picture of the scene is kept beside it.
    pub has_kept_picture: bool,
    /// Whether files of the scene are missing.
    pub has_missing: bool,
    /// Whether the scene has a file, and unsaved edits.
    pub can_revert: bool,
    /// Whether the timeline is shown.
    pub timeline_shown: bool,
    /// Whether the timeline plays.
    pub playing: bool,
    /// The mapping of the mouse to navigation.
    pub navigation: NavigationPreset,
    /// Whether the user flies. Control means slow then, and belongs to no shortcut.
    pub flying: bool,
}

/// An action, which keys, menus, palette and scripts name alike.
#[derive(Clone, Copy)]
pub struct Action {
    /// The name in scripts and the palette.
    pub name: &'static str,
    /// The label in menus and the palette.
    pub label: &'static str,
    /// Its menu, and its heading in the overview.
    pub group: Group,
    /// The default keys, any of which triggers it; `keys_in` returns the keys that the user has chosen instead.
    pub keys: &'static [Shortcut],
    /// The command. None if it has nothing to apply to.
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
    /// The menu of placing: steps, alignment, series.
    Arrange,
    /// The menu of camera and display.
    View,
    /// The menu of the timeline and of keys.
    Time,
    /// Samples, denoiser, comparison.
    Render,
    /// Panels, preferences, help.
    Window,
}

impl Group {
    /// The groups with their headings, in the order of the menus.
    pub const ALL: [(Self, &'static str); 8] = [
        (Self::File, "File"),
        (Self::Edit, "Edit"),
        (Self::Add, "Add"),
        (Self::Arrange, "Arrange"),
        (Self::View, "View"),
        (Self::Time, "Time"),
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

impl Action {
    /// The reason why there is no command, as a tool tip.
    pub fn missing(&self) -> &'static str {
        match self.name {
            "continue-picture" | "discard-picture" => "No picture is kept beside this scene",
            "missing-files" => "All files of the scene are there",
            "revert" => "There are no edits that the file of the scene has not",
            "place-texture" => "For a selected shape with a picture or a checkerboard in its material",
            "replace-by-active" => "Select shapes, and last the one whose geometry they get",
            _ => "For what is selected",
        }
    }

    /// The command of its key if the action does not apply: it is refused with a reason. None for actions with an
    /// obvious reason.
    pub(in crate::app::editor::input) fn refused(&self) -> Option<Command> {
        match self.name {
            "continue-picture" => Some(KeptPicture::Continue.into()),
            "discard-picture" => Some(KeptPicture::Discard.into()),
            "place-texture" => Some(ToolCommand::SetTool(Tool::PlaceTexture).into()),
            _ => None,
        }
    }

    /// Whether the state that it toggles is on; None for actions that toggle nothing.
    pub fn switch(&self, context: &ActionContext) -> Option<bool> {
        Some(match self.name {
            "grid" => context.grid.shown,
            "boxes" => context.overlay.shown,
            "safe-frame" => context.safe_frame,
            "dimensions" => context.dimensions,
            "daylight-factors" => context.meters.daylight,
            "rate-glare" => context.meters.glare,
            "wireframe" => context.seeing.wireframe,
            "see-into-rooms" => context.seeing.walls != Walls::Shown,
            "cut-open" => context.seeing.cut.is_some(),
            "isolate" => context.isolated,
            "walk" => context.walks,
            "four-views" => context.side_views.shown,
            "side-views-clay" => context.side_views.clay,
            "panels" => context.panels_shown,
            "pause" => context.paused,
            "timeline-shown" => context.timeline_shown,
            "play" => context.playing,
            "denoise" => context.denoising,
            "snap-always" => context.gizmo.snap.always,
            "snap-align" => context.gizmo.snap.aligns,
            _ => return None,
        })
    }

    /// Whether the state that it toggles is on, or the value that it chooses is chosen.
    pub fn is_on(&self, context: &ActionContext) -> bool {
        if let Some(is_on) = self.switch(context) {
            return is_on;
        }
        match self.name {
            // These have no state.
            "gizmo-axes" | "select-none" => false,
            _ => (self.command)(context).is_some_and(|command| match command {
                Command::Tool(ToolCommand::SetGizmo(settings)) => settings == context.gizmo,
                Command::Shell(ShellCommand::SetNavigation(preset)) => preset == context.navigation,
                // An action of the tool in use puts the tool away.
                Command::Tool(ToolCommand::SetTool(Tool::Select)) => context.tool != Tool::Select,
                command => command == ToolCommand::SetTool(context.tool).into(),
            }),
        }
    }
}

impl<'a> ActionContext<'a> {
    /// The state of an editor that was just opened, with this selection.
    pub fn new(selection: &'a Selection) -> Self {
        Self {
            display: DisplaySettings::default(),
            overlay: BvhOverlay::default(),
            gizmo: GizmoSettings::default(),
            paused: false,
            denoising: false,
            panels_shown: true,
            selection,
            tool: Tool::default(),
            bound: &NO_BINDINGS,
            meters: MeterChoice::default(),
            safe_frame: false,
            grid: GridSettings::default(),
            dimensions: false,
            seeing: Seeing::default(),
            isolated: false,
            walks: false,
            side_views: SideViews::default(),
            has_textures: false,
            has_kept_picture: false,
            has_missing: false,
            can_revert: false,
            timeline_shown: false,
            playing: false,
            navigation: NavigationPreset::default(),
            flying: false,
        }
    }
}

impl ActionContext<'_> {
    pub(super) fn with_selection(&self, command: impl Into<Command>) -> Option<Command> {
        (!self.selection.is_empty()).then_some(command.into())
    }

    pub(super) fn with_kept_picture(&self, what: KeptPicture) -> Option<Command> {
        self.has_kept_picture.then_some(Command::KeptPicture(what))
    }

    pub(super) fn exposed(&self, stops: f32) -> Command {
        Command::from(DisplayCommand::SetDisplay(DisplaySettings {
            exposure: self.display.exposure + stops,
            ..self.display
        }))
    }

    /// Updates the state after a command, for the next one.
    pub fn follow(&mut self, command: &Command) {
        match command {
            Command::Display(DisplayCommand::SetDisplay(display)) => self.display = *display,
            Command::Display(DisplayCommand::SetOverlay(overlay)) => self.overlay = *overlay,
            Command::Tool(ToolCommand::SetGizmo(settings)) => self.gizmo = *settings,
            Command::Render(RenderCommand::SetPaused(paused)) => self.paused = *paused,
            Command::Display(DisplayCommand::SetDenoising(denoising)) => self.denoising = *denoising,
            Command::Tool(ToolCommand::SetTool(tool)) => self.tool = *tool,
            Command::View(ViewCommand::SetSeeing(seeing)) => self.seeing = *seeing,
            Command::View(ViewCommand::Isolate(entities)) => self.isolated = !entities.is_empty(),
            Command::View(ViewCommand::Walk(walks)) => self.walks = *walks,
            Command::View(ViewCommand::ShowSideViews(shown)) => self.side_views.shown = *shown,
            Command::View(ViewCommand::ShowSidesInClay(clay)) => self.side_views.clay = *clay,
            Command::Display(DisplayCommand::SetMeters(choice)) => self.meters = *choice,
            Command::Display(DisplayCommand::ShowSafeFrame(shown)) => self.safe_frame = *shown,
            Command::Display(DisplayCommand::SetGrid(grid)) => self.grid = *grid,
            Command::Display(DisplayCommand::ShowDimensions(shown)) => self.dimensions = *shown,
            Command::Shell(ShellCommand::ShowPanels(shown)) => self.panels_shown = *shown,
            Command::Shell(ShellCommand::SetNavigation(preset)) => self.navigation = *preset,
            Command::Time(TimeCommand::ShowTimeline(shown)) => self.timeline_shown = *shown,
            Command::Time(TimeCommand::SetPlaying(plays)) => self.playing = *plays,
            // Actions depend on no other state.
            Command::Edit(_) | Command::File(_) | Command::History(_) | Command::Selection(_) | Command::View(_) => {}
            Command::Time(_) | Command::Render(_) | Command::Display(_) | Command::Tool(_) => {}
            Command::Bake(_) | Command::KeptPicture(_) | Command::Shell(_) => {}
        }
    }
}

pub(super) const fn plain(key: Key) -> Shortcut {
    Shortcut::plain(key)
}

pub(super) const fn numpad(key: Key) -> Shortcut {
    Shortcut {
        numpad: true,
        ..plain(key)
    }
}

pub(super) const fn command_numpad(key: Key) -> Shortcut {
    Shortcut {
        command: true,
        ..numpad(key)
    }
}

pub(super) const fn command_alt(key: Key) -> Shortcut {
    Shortcut {
        alt: true,
        ..command(key)
    }
}

pub(super) const fn command(key: Key) -> Shortcut {
    Shortcut {
        command: true,
        ..plain(key)
    }
}

pub(super) const fn shift(key: Key) -> Shortcut {
    Shortcut {
        shift: true,
        ..plain(key)
    }
}

pub(super) const fn alt(key: Key) -> Shortcut {
    Shortcut {
        alt: true,
        ..plain(key)
    }
}

pub(super) const fn command_shift(key: Key) -> Shortcut {
    Shortcut {
        command: true,
        ..shift(key)
    }
}

pub(super) const fn action(
    group: Group,
    name: &'static str,
    label: &'static str,
    keys: &'static [Shortcut],
    command: fn(&ActionContext) -> Option<Command>,
) -> Action {
    Action {
        name,
        label,
        group,
        keys,
        command,
    }
}
