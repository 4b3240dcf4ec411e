//! The dock of the panels: tabs that can be dragged, and the content of each.

use bevy_egui::egui::{self, Color32, Id, Margin, RichText, Ui, WidgetText};
use egui_dock::{DockArea, Style, TabStyle, TabViewer};

use super::widgets::Widgets;
use crate::app::editor::command::Command;
use crate::app::editor::command::panel::Panel;
use crate::app::editor::model::Model;
use crate::app::editor::panels::{
    assets, diagnostics, history, inspector, library, meter, outliner, paths, render, statistics,
};
use crate::app::editor::session::layout::Layout;
use crate::app::editor::session::view_settings::ViewSettings;
use crate::app::editor::viewport::model::ViewportModel;
use crate::app::editor::viewport::state::ViewportState;
use crate::app::editor::viewport::viewport;
use crate::document::Severity;
use crate::memory::budget;

/// The data of the panels, and the commands that they give.
pub struct Panels<'a> {
    model: &'a Model,
    viewport: &'a ViewportModel<'a>,
    settings: &'a ViewSettings,
    state: &'a mut ViewportState,
    widgets: &'a mut Widgets,
    commands: &'a mut Vec<Command>,
    /// The panels in front of their groups: only they have a close button.
    fronts: Vec<Panel>,
    /// The panels whose titles are shortened, because the titles of their group do not fit.
    crowded: Vec<Panel>,
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
            crowded: Vec::new(),
            error_color: Color32::PLACEHOLDER,
        }
    }
}

pub fn docked_panels(ui: &mut Ui, layout: &mut Layout, mut panels: Panels) {
    hide_lonely_bar(layout);
    layout.fit(ui.available_size());
    panels.error_color = ui.visuals().error_fg_color;
    panels.fronts = layout.fronts();
    panels.crowded = crowded(ui, layout, &panels);
    let mut style = Style::from_egui(ui.style());
    style.tab_bar.height = 24.0;
    style.tab_bar.show_scroll_bar_on_overflow = false;
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

/// The points around the title in a tab, and of the close button in the front tab.
const AROUND_TITLE: f32 = 16.0;
const CLOSE_BUTTON: f32 = 24.0;

/// The panels behind others in groups that are narrower than their titles.
fn crowded(ui: &Ui, layout: &Layout, panels: &Panels) -> Vec<Panel> {
    let font = egui::TextStyle::Button.resolve(ui.style());
    let width = |panel: &Panel| {
        let text = panels.text(*panel);
        let galley = ui.painter().layout_no_wrap(text, font.clone(), Color32::PLACEHOLDER);
        galley.size().x + AROUND_TITLE
    };
    let mut crowded = Vec::new();
    for (_, leaf) in layout.0.iter_leaves() {
        let needed: f32 = leaf.tabs.iter().map(width).sum::<f32>() + CLOSE_BUTTON;
        // A group that was never shown has no width yet.
        if leaf.rect.width() > 0.0 && needed > leaf.rect.width() {
            let behind = leaf.tabs.iter().filter(|panel| !panels.fronts.contains(panel));
            crowded.extend(behind.copied());
        }
    }
    crowded
}

/// Hides the viewport's title bar, unless other panels are in its group.
fn hide_lonely_bar(layout: &mut Layout) {
    for (_, leaf) in layout.0.iter_leaves_mut() {
        leaf.tab_bar_hidden = leaf.tabs == [Panel::Viewport];
    }
}

impl Panels<'_> {
    /// The whole title.
    fn text(&self, panel: Panel) -> String {
        match (panel, self.model.notices.len()) {
            (Panel::Messages, count @ 1..) => format!("{} ({count})", panel.title()),
            _ => panel.title().to_owned(),
        }
    }
}

impl TabViewer for Panels<'_> {
    type Tab = Panel;

    fn id(&mut self, panel: &mut Panel) -> Id {
        Id::new(*panel)
    }

    fn title(&mut self, panel: &mut Panel) -> WidgetText {
        let notices = &self.model.notices;
        let title = RichText::new(match self.crowded.contains(panel) {
            true => panel.short_title().to_owned(),
            false => self.text(*panel),
        });
        if *panel == Panel::Messages && notices.iter().any(|notice| notice.severity == Severity::Error) {
            title.color(self.error_color).into()
        } else {
            title.into()
        }
    }

    fn on_tab_button(&mut self, panel: &mut Panel, response: &egui::Response) {
        if self.crowded.contains(panel) {
            response.clone().on_hover_text(self.text(*panel));
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
            Panel::Assets => assets::assets(ui, model, &mut widgets.assets, commands),
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
                let ViewportModel {
                    paths: inspected,
                    reasons,
                    lamp,
                    ..
                } = *self.viewport;
                paths::paths(ui, inspected, reasons, lamp, commands);
            }
            Panel::Meter => meter::meter(ui, &model.meters, &model.selection, commands),
            Panel::Statistics => {
                let (packed, state) = (self.viewport.packed, &mut widgets.statistics);
                let memory = [budget().reserved(), budget().limit()];
                statistics::statistics(ui, packed, &model.outline, &model.selection, memory, state, commands);
            }
            Panel::Bake => widgets.bake.panel(ui, &model.bake, commands),
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
        [false, !panel.scrolls()]
    }

    fn tab_style_override(&self, panel: &Panel, style: &TabStyle) -> Option<TabStyle> {
        (*panel == Panel::Viewport).then(|| {
            let mut style = style.clone();
            style.tab_body.inner_margin = Margin::ZERO;
            style
        })
    }
}
