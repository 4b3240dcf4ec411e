//! The panels in their places: tabs that can be dragged, and what each of them shows.

use bevy_egui::egui::{self, Color32, Id, Margin, RichText, Ui, WidgetText};
use egui_dock::{DockArea, Style, TabStyle, TabViewer};

use super::widgets::Widgets;
use crate::app::editor::command::Command;
use crate::app::editor::command::panel::Panel;
use crate::app::editor::model::Model;
use crate::app::editor::panels::{diagnostics, history, inspector, library, outliner, paths, render};
use crate::app::editor::session::layout::Layout;
use crate::app::editor::session::view_settings::ViewSettings;
use crate::app::editor::viewport::model::ViewportModel;
use crate::app::editor::viewport::state::ViewportState;
use crate::app::editor::viewport::viewport;
use crate::document::Severity;

/// The data that the panels show, and the commands that they give.
pub struct Panels<'a> {
    model: &'a Model,
    viewport: &'a ViewportModel<'a>,
    settings: &'a ViewSettings,
    state: &'a mut ViewportState,
    widgets: &'a mut Widgets,
    commands: &'a mut Vec<Command>,
    /// The panels in front of their groups: only they have a button to close them.
    fronts: Vec<Panel>,
    /// The colour of the title of the messages while there are errors.
    error_color: Color32,
}

impl<'a> Panels<'a> {
    pub fn new(
        model: &'a Model,
        viewport: &'a ViewportModel<'a>,
        settings: &'a ViewSettings,
        state: &'a mut ViewportState,
        widgets: &'a mut Widgets,
        commands: &'a mut Vec<Command>,
    ) -> Self {
        Self {
            model,
            viewport,
            settings,
            state,
            widgets,
            commands,
            fronts: Vec::new(),
            error_color: Color32::PLACEHOLDER,
        }
    }
}

pub fn docked_panels(ui: &mut Ui, layout: &mut Layout, mut panels: Panels) {
    hide_lonely_bar(layout);
    layout.fit(ui.available_size());
    let leaves = layout.0.iter_leaves();
    panels.error_color = ui.visuals().error_fg_color;
    panels.fronts = leaves
        .filter_map(|(_, leaf)| leaf.tabs.get(leaf.active.0).copied())
        .collect();
    let mut style = Style::from_egui(ui.style());
    style.tab_bar.height = 24.0;
    style.tab.tab_body.inner_margin = Margin::symmetric(6, 5);
    style.tab.tab_body.stroke = egui::Stroke::NONE;
    style.tab.tab_body.hidden_tab_bar_drag_height = Some(0.0);
    style.tab.tab_body.bg_fill = ui.visuals().panel_fill;
    style.tab.active.bg_fill = ui.visuals().panel_fill;
    style.tab.focused.bg_fill = ui.visuals().panel_fill;
    style.buttons.show_tab_bar_size = 0.0;
    style.buttons.show_tab_bar_hover_expand = 0.0;
    DockArea::new(&mut layout.0)
        .id(Id::new("panels"))
        .style(style)
        .show_leaf_close_all_buttons(false)
        .show_leaf_collapse_buttons(false)
        .tab_context_menus(false)
        .hidable_tab_bars(true)
        .show_inside(ui, &mut panels);
}

/// The viewport has no title, unless other panels stand behind it.
fn hide_lonely_bar(layout: &mut Layout) {
    for (_, leaf) in layout.0.iter_leaves_mut() {
        leaf.tab_bar_hidden = leaf.tabs == [Panel::Viewport];
    }
}

impl TabViewer for Panels<'_> {
    type Tab = Panel;

    fn id(&mut self, panel: &mut Panel) -> Id {
        Id::new(*panel)
    }

    fn title(&mut self, panel: &mut Panel) -> WidgetText {
        let notices = &self.model.notices;
        if *panel != Panel::Messages || notices.is_empty() {
            return panel.title().into();
        }
        let title = RichText::new(format!("{} ({})", panel.title(), notices.len()));
        if notices.iter().any(|notice| notice.severity == Severity::Error) {
            title.color(self.error_color).into()
        } else {
            title.into()
        }
    }

    fn ui(&mut self, ui: &mut Ui, panel: &mut Panel) {
        let Self {
            model,
            settings,
            widgets,
            ..
        } = self;
        let commands = &mut *self.commands;
        match panel {
            Panel::Viewport => {
                widgets.viewport_place = ui.max_rect();
                viewport(ui, self.viewport, self.state, commands);
            }
            Panel::Outliner => {
                outliner::outliner(ui, model, &mut widgets.outliner, commands);
            }
            Panel::Library => library::library(ui, model, &mut widgets.shelf, commands),
            Panel::Inspector => {
                inspector::inspector(
                    ui,
                    model,
                    settings.navigation.scene_size,
                    &mut widgets.inspector,
                    commands,
                );
            }
            Panel::Render => render::render(ui, &model.render, settings.display, settings.overlay, commands),
            Panel::History => history::history(ui, &model.history, commands),
            Panel::Messages => diagnostics::diagnostics(ui, &model.notices),
            Panel::Paths => {
                let known = self.viewport.paths;
                paths::paths(ui, known.wanted, known.pixel, &known.paths, commands);
            }
        }
    }

    fn is_closeable(&self, panel: &Panel) -> bool {
        *panel != Panel::Viewport && self.fronts.contains(panel)
    }

    fn allowed_in_windows(&self, panel: &mut Panel) -> bool {
        *panel != Panel::Viewport
    }

    fn clear_background(&self, panel: &Panel) -> bool {
        *panel != Panel::Viewport
    }

    fn scroll_bars(&self, panel: &Panel) -> [bool; 2] {
        let has_own = matches!(
            panel,
            Panel::Viewport | Panel::Outliner | Panel::Library | Panel::History
        );
        [false, !has_own]
    }

    fn tab_style_override(&self, panel: &Panel, style: &TabStyle) -> Option<TabStyle> {
        (*panel == Panel::Viewport).then(|| {
            let mut style = style.clone();
            style.tab_body.inner_margin = Margin::ZERO;
            style
        })
    }
}
