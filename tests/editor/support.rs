//! What tests of the editor share.

use bevy::ecs::entity::EntityHashSet;
use bevy::math::{Affine3A, Vec3};
use bevy_egui::egui;
use sunroom::app::editor::camera::navigation::Navigation;
use sunroom::app::editor::command::compare_view::CompareView;
use sunroom::app::editor::command::gizmo_settings::GizmoSettings;
use sunroom::app::editor::command::key_bindings::NO_BINDINGS;
use sunroom::app::editor::command::selection::Selection;
use sunroom::app::editor::input::actions::ActionContext;
use sunroom::app::editor::input::press::Press;
use sunroom::app::editor::model::Outline;
use sunroom::app::editor::picture::denoiser::DenoiserState;
use sunroom::app::editor::picture::lamp_light::LampFollower;
use sunroom::app::editor::picture::outline::SelectionOutline;
use sunroom::app::editor::picture::overlay::BoxList;
use sunroom::app::editor::picture::paths::PathInspector;
use sunroom::app::editor::picture::reasons::Reasons;
use sunroom::app::editor::picture::wireframe::Wireframe;
use sunroom::app::editor::viewport::gizmo::interaction::GizmoModel;
use sunroom::app::editor::viewport::model::ViewportModel;
use sunroom::engine::PackedScene;
use sunroom::render::camera::Camera;
use sunroom::render::view::View;

/// The keys that went down this frame, as the window hands them to the editor.
pub fn presses(ui: &egui::Ui) -> Vec<Press> {
    let press = |event: &egui::Event| match *event {
        egui::Event::Key {
            key,
            pressed: true,
            repeat: false,
            modifiers,
            ..
        } => Some(Press {
            key,
            modifiers,
            numpad: false,
        }),
        _ => None,
    };
    ui.input(|input| input.events.iter().filter_map(press).collect())
}

/// What the viewport refers to, empty as long as a test adds nothing.
#[derive(Default)]
pub struct ViewportContent {
    pub selection: Selection,
    pub packed: PackedScene,
    pub boxes: BoxList,
    pub outline: SelectionOutline,
    pub wireframe: Wireframe,
    pub lamp: LampFollower,
    pub paths: PathInspector,
    pub reasons: Reasons,
    pub things: Outline,
    pub locked: EntityHashSet,
}

impl ViewportContent {
    /// The viewport with a picture of this size in pixels, and with handles that act on nothing.
    pub fn model<'a>(
        &'a self,
        size: [u32; 2],
        pose: Affine3A,
        camera: Camera,
        presses: &'a [Press],
    ) -> ViewportModel<'a> {
        ViewportModel {
            picture: Some((egui::TextureId::default(), size)),
            film_in_picture: View::WHOLE_FILM,
            is_through_camera: true,
            proportions: size,
            mouse: egui::Vec2::ZERO,
            placeholder: "",
            outdated: None,
            pose: Some(pose),
            camera: Some(camera),
            boxes: &self.boxes,
            marker_paths: &[],
            outline: &self.outline,
            wireframe: &self.wireframe,
            volume_boxes: &[],
            lamp_solid: None,
            icons: &[],
            stand_ins: &[],
            gizmo: GizmoModel {
                settings: GizmoSettings::default(),
                targets: &[],
                length_step: 0.5,
                grid: Default::default(),
                up: Vec3::Y,
                unit: Default::default(),
                packed: &self.packed,
                bound: &NO_BINDINGS,
            },
            denoiser: DenoiserState::Off,
            is_carried_over: false,
            preset: Default::default(),
            blocks: &[],
            textures: None,
            locked: &self.locked,
            painting: None,
            things: &self.things,
            packed: &self.packed,
            reasons: &self.reasons,
            lamp: &self.lamp,
            paths: &self.paths,
            legend: None,
            captions: &[],
            compared: CompareView::Off,
            region: None,
            navigation: Navigation {
                scene_size: 10.0,
                ..Navigation::default()
            },
            keys: ActionContext::new(&self.selection),
            extent: None,
            series: None,
            wall: None,
            rulers: &[],
            is_empty: false,
            depths: Default::default(),
            sides: &[],
            side: None,
            presses,
            enabled: true,
        }
    }
}
