//! The data that the panels show: gathered from the world once per frame, so that panels never touch the ECS. May
//! import `picture` and the modules below it.

pub mod assets;
pub mod baking;
pub mod difference;
pub mod freedom;
pub mod game_types;
pub(crate) mod gather;
pub(crate) mod gather_bake;
pub(crate) mod gather_game_types;
pub(crate) mod gather_light;
pub(crate) mod gather_meters;
pub(crate) mod inspected_media;
pub(crate) mod inspection;
pub mod item_list;
pub(crate) mod leaks;
pub mod light_figures;
pub mod mixed;
pub(crate) mod outline;
pub mod painting;
pub mod panel_textures;
pub(crate) mod plugin;
mod render;
pub mod sizes;
pub mod thumbnails;
pub mod timeline;

use std::path::PathBuf;
use std::sync::Arc;

use bevy::math::{Affine3A, UVec3, Vec3};
use bevy::prelude::{Entity, *};

use self::assets::AssetsModel;
use self::baking::BakeModel;
use self::game_types::GameTypes;
use crate::app::editor::command::material_tree::can_wrap;
use crate::app::editor::command::media::MediumSide;
use crate::app::editor::command::presets::Preset;
use crate::app::editor::command::selection::Selection;
use crate::app::editor::command::texture_placing::has_textures;
use crate::app::editor::picture::awaited_image::AwaitedImage;
use crate::app::editor::picture::denoiser::DenoiserState;
use crate::app::editor::picture::metering::ShownMeters;
use crate::app::editor::picture::noise_trend::NoiseTrend;
use crate::document::Severity;
use crate::engine::RenderStatus;
use crate::math::Aabb;
use crate::scene::{
    AreaLight, Emitter, EulerAngles, FileKind, Film, LengthUnit, LightUnits, Material, Medium, Properties, Sensor,
    Shape,
};
use item_list::ItemList;
use light_figures::LightFigures;
use mixed::Mixed;
pub use painting::PaintingModel;
use panel_textures::PanelTextures;
pub use render::{ComparisonModel, MixingModel, RenderModel};
pub use sizes::Sizes;
use timeline::TimelineModel;

/// One line of the outliner.
#[derive(Clone, Debug, PartialEq)]
pub struct Item {
    /// The entity that a click selects.
    pub entity: Entity,
    /// The text of the row.
    pub name: String,
    /// The word for its kind.
    pub kind: &'static str,
    /// Whether it is hidden in the picture.
    pub hidden: bool,
    /// Whether it is protected from edits.
    pub locked: bool,
    /// Whether it can be hidden in the picture: shapes and lights can.
    pub can_hide: bool,
    /// The material that this one is nested in.
    pub inside_of: Option<Entity>,
    /// The material that a shape uses.
    pub uses: Option<Entity>,
    /// The properties for the code of a game.
    pub properties: Option<Properties>,
}

/// The things in the scene, by kind, in the order of the file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Outline {
    /// The shapes, with instances and without groups.
    pub shapes: ItemList,
    /// The materials, with nested ones.
    pub materials: ItemList,
    /// The participating media.
    pub media: ItemList,
    /// The lights that are no surfaces.
    pub lights: ItemList,
    /// The cameras.
    pub sensors: ItemList,
}

impl Outline {
    /// The name of the material of a shape.
    pub(crate) fn material_of(&self, item: &Item) -> Option<&str> {
        let used = item.uses?;
        let place = self.materials.place_of(used)?;
        Some(self.materials[place].name.as_str())
    }

    /// The heading of the materials.
    pub(crate) const MATERIALS: &str = "Materials";
    /// The heading of the lights.
    pub(crate) const LIGHTS: &str = "Lights";
    /// The heading of the cameras.
    pub(crate) const CAMERAS: &str = "Cameras";

    /// The groups with their headings.
    pub fn groups(&self) -> [(&'static str, &ItemList); 5] {
        [
            ("Shapes", &self.shapes),
            (Self::MATERIALS, &self.materials),
            ("Media", &self.media),
            (Self::LIGHTS, &self.lights),
            (Self::CAMERAS, &self.sensors),
        ]
    }

    /// The first group that lists a thing, as an index into [`Self::groups`], and the thing's index in it.
    pub fn place_of(&self, entity: Entity) -> Option<(usize, usize)> {
        let mut groups = self.groups().into_iter().enumerate();
        groups.find_map(|(group, (_, items))| Some((group, items.place_of(entity)?)))
    }
}

/// A material of the selection.
#[derive(Clone, Debug, PartialEq)]
pub struct InspectedMaterial {
    /// The entity of the material.
    pub entity: Entity,
    /// The heading.
    pub name: String,
    /// The present parameters, which are shared from frame to frame until they change.
    pub material: Arc<Material>,
    /// The role that it has within another material.
    pub place: MaterialPlace,
    /// The index of the nested material to take at each level, from the outermost material to this one.
    pub path: Vec<usize>,
    /// The parameters that differ from those of the materials at the same path in the other selected things.
    pub mixed: Mixed,
    /// The number of shapes that use it.
    pub users: usize,
    /// Its nested materials.
    pub inside: Vec<Entity>,
}

/// The role of a material within another.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MaterialPlace {
    /// It is not nested.
    Whole,
    /// The front of a two-sided material.
    Front,
    /// The back of a two-sided material.
    Back,
    /// The first material of a blend.
    First,
    /// The second material of a blend.
    Second,
    /// The only nested material of a material.
    Inside,
}

impl MaterialPlace {
    /// Whether a scene file may have this material in the role: a two-sided one takes no refractive material.
    pub(crate) fn takes(self, material: &Material) -> bool {
        match self {
            Self::Front | Self::Back => can_wrap("twosided", material),
            Self::Whole | Self::First | Self::Second | Self::Inside => true,
        }
    }
}

/// A medium of the selection.
#[derive(Clone, Debug, PartialEq)]
pub struct InspectedMedium {
    /// The entity of the medium.
    pub entity: Entity,
    /// The heading.
    pub name: String,
    /// The present parameters.
    pub medium: Arc<Medium>,
    /// The side on which the inspected thing refers to it; None if it is the inspected thing itself.
    pub side: Option<MediumSide>,
    /// The parameters that differ from those of the other selected things' media on the same side.
    pub mixed: Mixed,
    /// The number of things that refer to it.
    pub users: usize,
    /// World from the unit cube for the box of each volume, outside of which there is nothing, or the border of the
    /// grid.
    pub boxes: Vec<Affine3A>,
    /// The content of each grid file: by path, the voxels along each axis, or None while it is not loaded.
    pub grids: Vec<(PathBuf, Option<InspectedGrid>)>,
}

/// The content of a file with a grid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InspectedGrid {
    /// The voxels along each axis.
    pub resolution: UVec3,
    /// The number of values per voxel, 1 or 3.
    pub channels: usize,
    /// The box that the file gives.
    pub bounds: Option<Aabb>,
    /// The transform from the unit cube of the grid to the space of the file.
    pub world_from_local: Affine3A,
}

/// The content of a mesh file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct InspectedMesh {
    /// The number of triangles of the file's mesh.
    pub triangles: usize,
    /// The numbers of curves and of control points of a file of curves.
    pub curves: [usize; 2],
    /// Whether the file names materials of its own.
    pub has_materials: bool,
}

/// The active entity with everything that can be edited on it.
#[derive(Clone, Debug, PartialEq)]
pub struct Inspected {
    /// The entity.
    pub entity: Entity,
    /// The heading.
    pub name: String,
    /// The pose; None for things without a place, such as a material.
    pub to_world: Option<Affine3A>,
    /// The Euler angles of its rotation, if they are known.
    pub angles: Option<EulerAngles>,
    /// The rotation that counts as zero in the panel, as angles in degrees.
    pub rest: Vec3,
    /// The shape, if it is one.
    pub shape: Option<Shape>,
    /// The mesh, once it is loaded.
    pub mesh: Option<InspectedMesh>,
    /// The emission, if it is a shape that shines.
    pub area_light: Option<AreaLight>,
    /// The light, if it is one that is no shape.
    pub emitter: Option<Emitter>,
    /// The figures of its light.
    pub light_figures: LightFigures,
    /// The camera, if it is one.
    pub sensor: Option<Sensor>,
    /// The film, if it is a camera.
    pub film: Option<Film>,
    /// The material that a shape uses; None without one.
    pub uses_material: Option<Entity>,
    /// The media that it refers to, by [`MediumSide`] as a number.
    pub media_at: [Option<Entity>; 3],
    /// The number of selected members, if it is a group and nothing else is selected. Its transform is that of all.
    pub members: Option<usize>,
    /// The properties for the code of a game; None for a thing that can have none.
    pub properties: Option<Properties>,
    /// The values that differ among all selected things, without those of materials.
    pub mixed: Mixed,
    /// The material itself, or the shape's, with nested ones.
    pub materials: Vec<InspectedMaterial>,
    /// The medium itself, or the media that the thing refers to.
    pub media: Vec<InspectedMedium>,
    /// The reason why its medium cannot be inside of it: the leak of the shape.
    pub leak: Option<String>,
}

impl Inspected {
    /// Whether it is a shape with textures that can be placed.
    pub(crate) fn has_textures(&self) -> bool {
        let is_surface = self.shape.as_ref().is_some_and(|shape| !shape.is_frame());
        is_surface && has_textures(self.materials.iter().map(|entry| &*entry.material))
    }

    /// Whether it may refer to a medium on this side.
    pub(crate) fn has_side(&self, side: MediumSide) -> bool {
        match side {
            MediumSide::Interior | MediumSide::Exterior => self.shape.as_ref().is_some_and(|shape| !shape.is_frame()),
            MediumSide::Around => {
                let is_in_space = |emitter: &Emitter| !emitter.is_marker();
                self.sensor.is_some() || self.emitter.as_ref().is_some_and(is_in_space)
            }
        }
    }

    /// An entity with nothing to edit yet.
    pub fn new(entity: Entity, name: impl Into<String>) -> Self {
        Self {
            entity,
            name: name.into(),
            to_world: None,
            angles: None,
            rest: Vec3::ZERO,
            shape: None,
            mesh: None,
            area_light: None,
            emitter: None,
            light_figures: LightFigures::default(),
            sensor: None,
            film: None,
            uses_material: None,
            media_at: [None; 3],
            members: None,
            properties: None,
            mixed: Mixed::default(),
            materials: Vec::new(),
            media: Vec::new(),
            leak: None,
        }
    }

    /// The pose: world from a space whose origin is the thing's position.
    pub fn pose(&self) -> Option<Affine3A> {
        Some(self.to_world? * Affine3A::from_translation(self.middle()))
    }

    /// The middle in the shape's own space, see [`Shape::middle`].
    pub fn middle(&self) -> Vec3 {
        self.shape.as_ref().map_or(Vec3::ZERO, Shape::middle)
    }
}

/// The steps that were done, oldest first, and those that can be redone, next first.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct HistoryModel {
    /// The labels of the steps that were done.
    pub done: Vec<String>,
    /// The labels of the steps that were undone.
    pub undone: Vec<String>,
}

/// One message of the diagnostics panel.
#[derive(Clone, Debug, PartialEq)]
pub struct Notice {
    /// The severity, for the colour and the word before the text.
    pub severity: Severity,
    /// The place, as `file:line:column`, if the problem has one.
    pub place: Option<String>,
    /// The message.
    pub text: String,
    /// Advice for the user.
    pub help: Option<String>,
    /// The line of the file, with marks under the place.
    pub excerpt: Option<String>,
}

/// A file of the scene that is missing.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MissingItem {
    /// Its kind.
    pub kind: FileKind,
    /// The absolute path in the scene.
    pub path: PathBuf,
}

/// The data of the status line and the menus.
#[derive(Clone, Debug, Default)]
pub struct StatusModel {
    /// The state of the engine.
    pub status: RenderStatus,
    /// Whether the user has paused rendering.
    pub paused: bool,
    /// The open scene.
    pub scene: Option<PathBuf>,
    /// Whether there are edits that no file has.
    pub unsaved: bool,
    /// Whether a save with all of these edits is running.
    pub being_saved: bool,
    /// Whether the scene file could not be read; its last valid state is shown.
    pub load_failed: bool,
    /// The state of the denoiser.
    pub denoiser: DenoiserState,
    /// Whether parts of the picture are carried over from an earlier one.
    pub is_carried_over: bool,
    /// The image that is saved when the full film is rendered.
    pub awaited_image: Option<AwaitedImage>,
    /// Whether the full film is traced until the next change.
    pub is_full: bool,
    /// The noise of the present picture over its samples per pixel.
    pub noise_trend: NoiseTrend,
    /// Whether the figures for developers are shown.
    pub developer_figures: bool,
    /// Median time between frames, milliseconds.
    pub frame_ms: Option<f32>,
}

/// The data of all panels.
#[derive(Clone, Debug, Default)]
pub struct Model {
    /// The things of the outliner.
    pub outline: Arc<Outline>,
    /// The selection, in the order of selecting.
    pub selection: Selection,
    /// The active thing of the selection.
    pub inspected: Option<Inspected>,
    /// The box around the selection in the world; None without one.
    pub extent: Option<Aabb>,
    /// The sizes of several selected things; None unless several are selected.
    pub sizes: Option<Sizes>,
    /// The steps.
    pub history: Arc<HistoryModel>,
    /// The thumbnails and rendered balls that are shown beside names.
    pub textures: PanelTextures,
    /// The library of materials, the program's own before the user's.
    pub presets: Arc<Vec<Preset>>,
    /// The browser of assets.
    pub assets: AssetsModel,
    /// The render panel.
    pub render: RenderModel,
    /// The bake of lightmaps.
    pub bake: BakeModel,
    /// The measuring points and grids with their values.
    pub meters: Arc<ShownMeters>,
    /// The messages panel.
    pub notices: Arc<Vec<Notice>>,
    /// The files of the scene that are missing, each once.
    pub missing: Arc<Vec<MissingItem>>,
    /// The unit of length of the scene.
    pub unit: LengthUnit,
    /// The units in which lights are shown.
    pub light_units: LightUnits,
    /// The properties of the scene itself.
    pub properties: Properties,
    /// The types of the game's components, as far as they are known.
    pub game_types: Arc<GameTypes>,
    /// Why the file with these types cannot be read, if it cannot.
    pub game_types_problem: Option<String>,
    /// The upward direction of the scene.
    pub up: Vec3,
    /// The timeline.
    pub timeline: TimelineModel,
    /// The status line.
    pub status: StatusModel,
    /// Scene files beside the open one.
    pub scene_files: Arc<Vec<PathBuf>>,
}

impl Model {
    /// The selected shapes.
    pub(crate) fn selected_shapes(&self) -> Vec<Entity> {
        let shapes = &self.outline.shapes;
        let selected = shapes.iter().map(|item| item.entity);
        selected.filter(|entity| self.selection.contains(*entity)).collect()
    }
}

#[derive(Resource, Default)]
pub(crate) struct EditorModel(pub Model);
