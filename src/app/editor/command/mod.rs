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
pub mod effect;
pub mod error;
pub mod file_access;
pub mod file_dialog;
pub mod gizmo_settings;
pub mod grid_settings;
pub mod inspected_paths;
pub mod kept_picture;
pub mod key_bindings;
mod label;
pub(crate) mod lenient;
pub mod light_mix;
pub mod material_tree;
pub mod media;
pub mod navigation_preset;
pub mod panel;
pub mod preferences;
pub mod presets;
pub mod recovery_offer;
pub mod resolution;
pub mod ruler;
pub mod samples;
pub mod seeing;
pub mod selection;
pub mod shell;
pub mod shortcut;
pub mod snapping;
pub mod stored_view;
pub mod texture_placing;
pub mod timeline;
pub mod tool;
pub mod uv_projection;

use std::path::PathBuf;

use bevy::math::{Affine2, Affine3A};
use bevy::prelude::{Entity, Rect, Vec2, Vec3};

use self::uv_projection::Projection;
use crate::scene::write::OnChange;
use crate::scene::{
    AccelMethod, AreaLight, Emitter, EulerAngles, Film, IntegratorSettings, KeyEdit, KeyPath, LengthUnit, Material,
    Medium, SamplerSettings, Sensor, Shape, SquarePath,
};
use addition::Addition;
use arrange::{Reference, Series, Side, Spacing};
use asset_kind::FileUse;
use axis_view::AxisView;
use baking::BakeCommand;
use blocking::Reshaping;
use blocking::block::Block;
use bvh_overlay::BvhOverlay;
use compare_view::CompareView;
use display::DisplaySettings;
pub use effect::Effect;
pub use file_dialog::FileDialogKind;
use gizmo_settings::GizmoSettings;
use grid_settings::GridSettings;
use inspected_paths::InspectedPaths;
use kept_picture::KeptPicture;
use light_mix::LightMix;
use material_tree::MaterialTree;
use media::{Filling, MediumSide};
use presets::Preset;
use resolution::{Enlarging, FullFilm, Resolution};
use ruler::Ruler;
use seeing::Seeing;
use selection::Extend;
use shell::ShellCommand;
use timeline::{TimeStep, Timeline};
use tool::Tool;

/// A command of the user with all its data. Applied to the same state, it always does the same.
#[derive(Clone, Debug, PartialEq)]
pub enum Command {
    // The file.
    /// Begins a new scene: a camera and a grey sky, without a file.
    NewScene,
    /// Replaces the scene by that of a file: XML or glTF.
    OpenScene(PathBuf),
    /// Reads the file of the scene again; edits stay.
    ReloadScene,
    /// Restores what the file says.
    RevertScene,
    /// Saves to the file of the open scene; asks for one if there is none.
    Save,
    /// Saves to this file, which is the scene's file from then on.
    SaveScene(PathBuf),
    /// Saves to this file even if others changed it since it was read.
    SaveChanged(PathBuf, OnChange),
    /// Writes the scene to this file as glTF, for other programs. The scene's own file stays what it is.
    ExportScene(PathBuf),
    /// Bakes the scene's lightmaps, or does something to the bake that is under way.
    Bake(BakeCommand),
    /// Saves the picture: as shown for PNG, the linear radiance for EXR and HDR.
    SaveImage(PathBuf),
    /// Keeps the picture beside the scene, to render it later, or resumes one that was kept.
    KeptPicture(KeptPicture),
    /// Gives the things that name a missing file another path, and where `others` is true those of all other missing
    /// files that lie beside it.
    FindFile {
        /// The path that the scene has.
        missing: PathBuf,
        /// Where the file is.
        found: PathBuf,
        /// Whether the other missing files are looked for in the same folder.
        others: bool,
    },
    /// Adds what a file holds: a mesh, a scene, a glTF, or a picture as environment.
    Import(PathBuf),
    /// Puts a file into the scene: where it was dropped, or onto the selection.
    UseFile(Box<FileUse>),
    /// Opens a dialog that asks for a file.
    ShowDialog(FileDialogKind),
    /// Closes the window; asks first if edits would be lost.
    Quit,

    // The history.
    /// Goes one step of the history back.
    Undo,
    /// Goes one step of the history forward.
    Redo,
    /// Goes back or forward to where this number of steps is done.
    GoTo(usize),

    // Commands that select.
    /// Selects things of the scene, which need not be visible.
    Select(Vec<Entity>, Extend),
    /// Selects everything that the outliner shows.
    SelectAll,
    /// Selects what is seen at a place of the picture. (0, 0) is its top left corner, (1, 1) its bottom right one.
    Pick(Vec2, Extend),

    /// Selects everything in the group around the active thing. Given again, it selects everything in the next group
    /// outwards.
    SelectGroup,

    // Commands that move the view. None of them edits the scene, except `MoveCameraToView`.
    /// Moves back or forth until the selection fills the view.
    FrameSelection,
    /// Moves back or forth until the scene fills the view.
    FrameAll,
    /// Flies to a pose of the camera, given as world from camera.
    MoveView(Affine3A),
    /// Renders from this sensor, at its place.
    LookThrough(Entity),
    /// Puts the sensor in use to where the view is.
    MoveCameraToView,
    /// Remembers the point that the view is turned about; views along an axis keep it in the middle.
    TurnAbout(Vec3),
    /// Looks along an axis of the world, at the selection, the point that the view was turned about, or what is ahead.
    LookAlong(AxisView),
    /// Switches between perspective and orthographic, so that what is in the middle keeps its size.
    SwitchProjection,
    /// Keeps the view under a number from 1 to 9.
    StoreView(usize),
    /// Goes back to a view that was kept.
    RecallView(usize),
    /// Sets the flying speed as a multiple of the one that suits the scene's size.
    SetSpeed(f32),

    // The scene.
    /// Adds one thing, which becomes the selection.
    Add(Addition),
    /// Adds a box, floor or wall that was drawn, which becomes the selection.
    Build(Box<Block>),
    /// Sets the geometry of a shape together with its pose, world from local.
    Reshape(Entity, Shape, Affine3A, Reshaping),
    /// Removes the selection.
    Delete,
    /// Copies the selection. The copies stand beside the originals, or continue the series if these are copies too, and
    /// become the selection.
    Duplicate,
    /// Makes a series of copies or instances of the selection.
    MakeSeries(Series),
    /// Brings one side of each selected thing in line, along an axis of the world from 0 to 2.
    Align(usize, Side, Reference),
    /// Spaces the selected things evenly along an axis of the world from 0 to 2; the outermost stay.
    Distribute(usize, Spacing),
    /// Scales things so that they are seen well, and puts them onto what is in the middle of the picture.
    FitToView(Vec<Entity>),
    /// Copies the selection to the clipboard, as XML text.
    Copy,
    /// Does `Copy`, then `Delete`.
    Cut,
    /// Adds the plugins of an XML text.
    Paste(String),
    /// Renames a thing. An empty name removes its name.
    Rename(Entity, String),
    /// Puts things, in this order, before another of their kind, or last.
    Reorder {
        /// The things, all of one kind.
        moved: Vec<Entity>,
        /// The thing before which they go; None for the end of the list.
        before: Option<Entity>,
    },
    /// Puts the selection into a folder of its own, with a transform of its own.
    Group,
    /// Takes what is in the selected groups out of them; the groups are gone then.
    Ungroup,
    /// Puts things into the folder of this path, or out of all.
    PutInto {
        /// The things that are put there.
        things: Vec<Entity>,
        /// The names of folders, from the outermost on, with `/` between.
        folder: Option<String>,
    },
    /// Hides these things, or shows them again.
    Hide(Vec<Entity>, bool),
    /// Hides all shapes and lights but the selected.
    HideOthers,
    /// Shows everything that is hidden.
    ShowAll,
    /// Protects these things from edits and clicks in the picture, or lifts that.
    Lock(Vec<Entity>, bool),
    /// Moves the selection by a step along an axis of the world: the one that looks most like this direction in the
    /// picture.
    Nudge(Direction),
    /// Drops each selected thing onto what is below it.
    Drop,
    /// Puts the origin of each selected thing onto the grid of the gizmo's step.
    SnapToGrid,
    /// Places several things at once, each by world from a space whose origin is the thing's place: that is its own
    /// space, but for shapes such as spheres, whose centre may be elsewhere there.
    Transform(Vec<(Entity, Affine3A)>),
    /// Places a thing as [`Command::Transform`] does, with the angles by which its rotation was given.
    Turn(Entity, Affine3A, EulerAngles),
    /// Sets the geometry of a shape.
    SetShape(Entity, Shape),
    /// Sets the parameters of a material; the materials nested in it stay.
    SetMaterial(Entity, Box<Material>),
    /// Sets another picture for a texture of a material or a light, or a picture where there is none.
    SetPicture {
        /// A material or a light.
        owner: Entity,
        /// The name of the parameter in the file.
        parameter: &'static str,
        /// The place of the texture within the parameter, if it is inside a checkerboard.
        place: SquarePath,
        /// The absolute path of the picture.
        path: PathBuf,
    },
    /// Places textures: gives all of a material, or of a shape's, that have one transform of uv another one.
    PlaceTextures {
        /// A shape or a material. What is nested in it belongs to it.
        owner: Entity,
        /// The transform that the textures have now.
        before: Affine2,
        /// The transform that they get.
        after: Affine2,
    },
    /// Gives shapes new texture coordinates.
    ProjectTextures {
        /// The shapes.
        shapes: Vec<Entity>,
        /// Where the coordinates come from.
        projection: Projection,
    },
    /// Gives the shapes this material, or takes theirs away.
    UseMaterial {
        /// The shapes that get it.
        shapes: Vec<Entity>,
        /// The material. None removes that of the shapes.
        material: Option<Entity>,
    },
    /// Gives the material to the shape that is seen at a place of the picture, see [`Command::Pick`].
    DropMaterial {
        /// A material of the scene.
        material: Entity,
        /// The place in the picture: (0, 0) top left, (1, 1) bottom right.
        at: Vec2,
    },
    /// Gives this shape a material of its own: a copy of the one that it has, or a grey one.
    GiveMaterial {
        /// The shape that gets it.
        shape: Entity,
    },
    /// Makes materials, or those of shapes, become the tree.
    BuildMaterial {
        /// Materials, or shapes whose materials are meant.
        targets: Vec<Entity>,
        /// The tree that each becomes.
        tree: Box<MaterialTree>,
    },
    /// Gives the shapes a material of the library. If the scene already has one like it with the same name, they get
    /// that one.
    UsePreset {
        /// The entry of the library.
        preset: Box<Preset>,
        /// The shapes that get it.
        shapes: Vec<Entity>,
    },
    /// Drops a preset onto the shape that is seen at a place of the picture, see [`Command::Pick`].
    DropPreset {
        /// The entry of the library.
        preset: Box<Preset>,
        /// The place in the picture: (0, 0) top left, (1, 1) bottom right.
        at: Vec2,
    },
    /// Sets the parameters of a medium.
    SetMedium(Entity, Box<Medium>),
    /// Puts a medium inside or outside of shapes, or cameras and lights into it; or takes it away.
    UseMedium {
        /// The shapes, cameras or lights.
        things: Vec<Entity>,
        /// The place of the medium.
        side: MediumSide,
        /// The medium. None is empty space.
        medium: Option<Entity>,
    },
    /// Gives a thing a new medium of its own.
    GiveMedium {
        /// The shape, camera or light.
        thing: Entity,
        /// The place of the medium.
        side: MediumSide,
    },
    /// Fills closed shapes; a surface that lets no light in becomes that of no material.
    Fill {
        /// The shapes.
        shapes: Vec<Entity>,
        /// The medium.
        with: Filling,
    },
    /// Sets the emission of a shape; None for a shape that does not shine.
    SetAreaLight(Entity, Option<AreaLight>),
    /// Sets kind and parameters of a light that is no surface.
    SetEmitter(Entity, Emitter),
    /// Sets the lens and field of view of a camera.
    SetSensor(Entity, Sensor),
    /// Focuses the camera in use on what is seen at a place of the picture, see [`Command::Pick`]. A pinhole camera
    /// becomes a thin lens.
    FocusAt(Vec2),
    /// Sets size, crop, filter and samples of a camera.
    SetFilm(Entity, Film),
    /// Makes an edit, which names one thing, and makes the same change to everything selected that is of the same sort.
    OnSelection(Box<Command>),
    /// Sets the lengths of paths and the strategy.
    SetIntegrator(IntegratorSettings),
    /// Sets the kind and seed of random numbers.
    SetSampler(SamplerSettings),
    /// Sets the unit of length of the scene. No length changes.
    SetUnit(LengthUnit),
    /// Sets how acceleration structures are built.
    SetAccel(AccelMethod),
    /// Multiplies the lights by their strengths and colours in the mix, which is neutral then.
    BakeLights,
    /// Writes the samples, the limit of noise and the adaptive sampling of the window into the film of the camera.
    KeepLimits,

    // Time. All times are in seconds.
    /// Changes the tracks of values of things at the time that is shown. Without any, a key is set of the place of each
    /// selected thing, and other edits are of all tracks of the selection.
    Key(Vec<(Entity, KeyPath)>, KeyEdit),
    /// Lets the camera in use, from where the view is, go once around the selection, or the scene, in the course of the
    /// frames of the timeline.
    AddTurntable,
    /// Shows the scene at a time. Playing ends.
    SetTime(f64),
    /// Shows the scene at the time of another frame or key.
    StepTime(TimeStep),
    /// Plays the frames of the timeline, or holds.
    SetPlaying(bool),
    /// Sets the frames of the timeline.
    SetTimeline(Timeline),
    /// Shows the timeline below the picture, or not.
    ShowTimeline(bool),

    // Rendering and display.
    /// Pauses rendering, or continues it.
    SetPaused(bool),
    /// Drops the samples of the picture.
    Restart,
    /// Sets the samples per pixel to stop at, above 0.
    SetTargetSamples(u32),
    /// Sets the seconds of rendering to stop at; None is no limit.
    SetTimeLimit(Option<f32>),
    /// Sets the noise to stop at, relative to the picture's brightness; None is no limit.
    SetNoiseTarget(Option<f32>),
    /// Sends more samples where the noise is, or as many to every pixel.
    SetAdaptive(bool),
    /// Limits the samples to a part of the picture, see [`Command::Pick`] for its coordinates. None stands for the
    /// whole picture.
    SetRegion(Option<Rect>),
    /// Sets the rendered pixels per pixel of the film along each side, above 0.
    SetResolutionScale(f32),
    /// Sets which pixels of the film are traced while the user works.
    SetResolution(Resolution),
    /// Sets how a picture is shown that has fewer pixels than its place in the window.
    SetEnlarging(Enlarging),
    /// Traces all pixels of the film until the next change, and may save the picture then.
    RenderFull(FullFilm),
    /// Goes back from the full film to the pixels that the window shows.
    StopFull,
    /// Splits the picture into thirds by bsdf sampling, by light sampling, and by both.
    SetStrategySplit(bool),
    /// Lets the integrator `path` stand for `auto`, or for itself.
    SetPathIsAuto(bool),
    /// Sets how the film becomes a picture.
    SetDisplay(DisplaySettings),
    /// Sets the exposure so that the picture is middle grey on average.
    ExposeAutomatically,
    /// Keeps the light of every light by itself, for mixing.
    SetLightLayers(bool),
    /// Sets strength, colour, solo and mute of each light.
    SetLightMix(LightMix),
    /// Keeps the picture for comparison.
    TakeSnapshot,
    /// Sets how picture and snapshot share the viewport.
    SetCompareView(CompareView),
    /// Measures the picture against the snapshot.
    Measure,
    /// Sets the boxes of the acceleration structures that are drawn over the picture.
    SetOverlay(BvhOverlay),
    /// Sets what the view leaves out.
    SetSeeing(Seeing),
    /// Puts a cut plane through the middle of the selection, or of the scene, facing the camera.
    CutOpen,
    /// Shows these shapes alone; without any, everything again.
    Isolate(Vec<Entity>),
    /// Sets what the next click in the picture does.
    SetTool(Tool),
    /// Dims what lies outside of the film, or no longer.
    ShowSafeFrame(bool),
    /// Shows the dimensions of the selection in the picture, or no longer.
    ShowDimensions(bool),
    /// Keeps a measured distance in the picture.
    AddRuler(Ruler),
    /// Removes all measured distances.
    ClearRulers,
    /// Sets the grid on the ground and the axes of the world.
    SetGrid(GridSettings),
    /// Shows the paths of a pixel, or none.
    InspectPaths(Option<InspectedPaths>),
    /// Sets what a drag of the gizmo does.
    SetGizmo(GizmoSettings),
    /// Shows the picture without noise from now on, or as sampled.
    SetDenoising(bool),
    /// Shows all panels, or the viewport alone.
    ShowPanels(bool),
    /// Does something to the window itself.
    Shell(ShellCommand),
}

/// The directions on the ground, as the camera sees it, and up and down.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Direction {
    /// To the left in the picture.
    Left,
    /// To the right in the picture.
    Right,
    /// Away from the camera.
    Ahead,
    /// Towards the camera.
    Back,
    /// Along +y of the world.
    Up,
    /// Along -y of the world.
    Down,
}
