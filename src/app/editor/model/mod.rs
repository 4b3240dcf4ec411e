//! What the panels show, as plain data: gathered from the world once per frame, so that panels never touch the ECS. May import
//! `picture` and the modules below it.

pub mod difference;
pub mod freedom;
pub(crate) mod gather;
pub(crate) mod inspection;
pub mod mixed;
pub mod panel_textures;
pub mod thumbnails;

use std::path::PathBuf;
use std::sync::Arc;

use bevy::math::{Affine3A, Vec3};
use bevy::prelude::{Entity, Rect, *};

use crate::app::editor::command::compare_view::CompareView;
use crate::app::editor::command::light_mix::LightMix;
use crate::app::editor::command::material_tree::can_wrap;
use crate::app::editor::command::presets::Preset;
use crate::app::editor::command::selection::Selection;
use crate::app::editor::picture::compare::Measured;
use crate::app::editor::picture::denoiser::DenoiserState;
use crate::document::Severity;
use crate::engine::RenderStatus;
use crate::scene::{
    AccelMethod, AreaLight, Emitter, Film, IntegratorSettings, Material, SamplerSettings, Sensor, Shape,
};
use mixed::Mixed;
use panel_textures::PanelTextures;

/// One line of the outliner.
#[derive(Clone, Debug, PartialEq)]
pub struct Item {
    pub entity: Entity,
    pub name: String,
    /// The word for the kind of thing that it is.
    pub kind: &'static str,
    pub hidden: bool,
    pub locked: bool,
    /// Whether it may be left out of the picture: shapes and lights may.
    pub can_hide: bool,
    /// The material that this one is inside of.
    pub inside_of: Option<Entity>,
}

/// Everything in the scene, by kind, in the order of the file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Outline {
    pub shapes: Vec<Item>,
    pub materials: Vec<Item>,
    pub lights: Vec<Item>,
    pub sensors: Vec<Item>,
}

impl Outline {
    /// The heading of the materials.
    pub(crate) const MATERIALS: &str = "Materials";

    /// The four groups with their headings.
    pub fn groups(&self) -> [(&'static str, &[Item]); 4] {
        [
            ("Shapes", &self.shapes),
            (Self::MATERIALS, &self.materials),
            ("Lights", &self.lights),
            ("Cameras", &self.sensors),
        ]
    }
}

/// A material of the selection.
#[derive(Clone, Debug, PartialEq)]
pub struct InspectedMaterial {
    pub entity: Entity,
    pub name: String,
    pub material: Material,
    /// The part that it has within another material.
    pub place: MaterialPlace,
    /// The index of the nested material to take at each level, from the outermost material to this one.
    pub path: Vec<usize>,
    /// The parameters that differ from those of the materials at the same path in the other selected things.
    pub mixed: Mixed,
    /// Shapes that use it.
    pub users: usize,
    /// The materials that are nested in it.
    pub inside: Vec<Entity>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MaterialPlace {
    Whole,
    /// The front of a two-sided material.
    Front,
    Back,
    /// The first material of a blend.
    First,
    Second,
    /// The nested material of one that takes a single one.
    Inside,
}

impl MaterialPlace {
    /// Whether a scene file may have this material there: a two-sided one takes nothing that refracts.
    pub(crate) fn takes(self, material: &Material) -> bool {
        match self {
            Self::Front | Self::Back => can_wrap("twosided", material),
            Self::Whole | Self::First | Self::Second | Self::Inside => true,
        }
    }
}

/// What a mesh file brings along.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct InspectedMesh {
    pub triangles: usize,
    pub has_materials: bool,
}

/// The selected entity with everything that can be edited on it.
#[derive(Clone, Debug, PartialEq)]
pub struct Inspected {
    pub entity: Entity,
    pub name: String,
    pub to_world: Option<Affine3A>,
    pub shape: Option<Shape>,
    /// Once its mesh is loaded.
    pub mesh: Option<InspectedMesh>,
    pub area_light: Option<AreaLight>,
    pub emitter: Option<Emitter>,
    pub sensor: Option<Sensor>,
    pub film: Option<Film>,
    pub uses_material: Option<Entity>,
    /// What differs among all that is selected, but for materials.
    pub mixed: Mixed,
    /// The material itself, or the shape's, and those nested in it.
    pub materials: Vec<InspectedMaterial>,
}

impl Inspected {
    /// An entity with nothing to edit yet.
    pub fn new(entity: Entity, name: impl Into<String>) -> Self {
        Self {
            entity,
            name: name.into(),
            to_world: None,
            shape: None,
            mesh: None,
            area_light: None,
            emitter: None,
            sensor: None,
            film: None,
            uses_material: None,
            mixed: Mixed::default(),
            materials: Vec::new(),
        }
    }

    /// World from a space whose origin is where the thing is.
    pub fn pose(&self) -> Option<Affine3A> {
        Some(self.to_world? * Affine3A::from_translation(self.middle()))
    }

    /// In its own space, see [`Shape::middle`].
    pub fn middle(&self) -> Vec3 {
        self.shape.as_ref().map_or(Vec3::ZERO, Shape::middle)
    }
}

/// What was done, oldest first, and what can be done again, next first.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct HistoryModel {
    pub done: Vec<String>,
    pub undone: Vec<String>,
}

/// The render panel's content.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RenderModel {
    pub target_samples: u32,
    pub resolution_scale: f32,
    pub integrator: IntegratorSettings,
    pub sampler: SamplerSettings,
    pub accel: AccelMethod,
    /// The longest time to render for, in seconds.
    pub time_limit: Option<f32>,
    pub noise_target: Option<f32>,
    /// The last estimate of the noise.
    pub noise: Option<f32>,
    pub region: Option<Rect>,
    pub strategy_split: bool,
    pub mixing: MixingModel,
    pub comparison: ComparisonModel,
}

/// The mixing desk.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MixingModel {
    /// Whether the film keeps the lights apart.
    pub is_on: bool,
    pub mix: LightMix,
    /// The lights that the film keeps apart, as the mix and the panel call them.
    pub lights: Vec<(Entity, String)>,
}

#[derive(Clone, Debug, Default, PartialEq)]
pub struct ComparisonModel {
    /// Samples per pixel of the snapshot; None without one.
    pub snapshot: Option<u32>,
    pub view: CompareView,
    pub figures: Option<Measured>,
}

/// One message of the diagnostics panel.
#[derive(Clone, Debug, PartialEq)]
pub struct Notice {
    pub severity: Severity,
    /// `file:line:column`, where it is about a place.
    pub place: Option<String>,
    pub text: String,
    pub help: Option<String>,
    /// The line it is about, with marks under the place.
    pub excerpt: Option<String>,
}

/// What the status line and the menus show.
#[derive(Clone, Debug, Default)]
pub struct StatusModel {
    pub status: RenderStatus,
    /// Whether the user has paused rendering.
    pub paused: bool,
    /// The open scene.
    pub scene: Option<PathBuf>,
    /// There are edits that no file has.
    pub unsaved: bool,
    /// The scene file could not be read; the last good one is shown.
    pub load_failed: bool,
    pub denoiser: DenoiserState,
    /// Median time between frames, milliseconds.
    pub frame_ms: Option<f32>,
}

/// All of it.
#[derive(Clone, Debug, Default)]
pub struct Model {
    pub outline: Arc<Outline>,
    pub selection: Selection,
    /// The active one of the selection.
    pub inspected: Option<Inspected>,
    pub history: Arc<HistoryModel>,
    pub textures: PanelTextures,
    pub presets: Arc<Vec<Preset>>,
    pub render: RenderModel,
    pub notices: Arc<Vec<Notice>>,
    pub status: StatusModel,
    /// Scene files beside the open one.
    pub scene_files: Arc<Vec<PathBuf>>,
}

impl Model {
    /// The shapes among what is selected.
    pub(crate) fn selected_shapes(&self) -> Vec<Entity> {
        let shapes = &self.outline.shapes;
        let selected = shapes.iter().map(|item| item.entity);
        selected.filter(|entity| self.selection.contains(*entity)).collect()
    }
}

#[derive(Resource, Default)]
pub(crate) struct EditorModel(pub Model);
