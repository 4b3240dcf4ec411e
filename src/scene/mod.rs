//! The scene as the editor sees it: entities with plain components, and the assets they name. No scheduling of
//! rendering here.
//!
//! Every shape, material, emitter and sensor is one entity. What they refer to are relationships, settings are
//! resources.

pub mod access;
pub mod aperture;
pub mod assets;
mod atmosphere;
pub mod authored;
pub mod carry_over;
pub(crate) mod changes;
mod declare;
pub mod description;
pub mod emitter;
pub mod encode;
pub mod euler;
pub mod export;
mod file_base;
mod file_moment;
mod file_value;
mod files_in_use;
pub mod film_storage;
pub(crate) mod folders;
mod fov_axis;
mod framing;
pub(crate) mod free_name;
pub mod group;
pub mod identity;
pub mod insert;
pub mod keep_source;
mod key_edits;
mod keys;
mod loading;
pub mod material;
pub mod medium;
pub mod mesh_check;
mod meshes;
mod missing;
mod moment;
mod named_files;
pub(crate) mod names;
pub mod object_change;
mod object_state;
mod opening;
mod parameter_info;
pub(crate) mod parameters;
pub mod picture_check;
mod pictures;
pub mod plugin;
mod posing;
mod presence;
pub mod read;
mod rebase;
mod recognition;
mod scene_file;
pub mod sensor;
pub mod settings;
pub mod shape;
pub mod solid;
pub mod spawn;
mod stand_in;
pub mod status;
pub mod sun_sky;
pub mod texture;
pub(crate) mod texture_parameters;
mod textures_of_parameters;
mod turntable;
mod unit;
pub mod volume_check;
mod volumes;
pub(crate) mod wall_openings;
pub mod watch;
pub mod write;

pub use access::{SceneAccess, Trust};
pub use assets::{FileSourcePlugin, MeshHandle, MeshShape, TextureMap, TriangleMesh, VolumeMap};
pub use authored::{Authored, AuthoredScene};
pub(crate) use authored::{DeclaredIn, Declares};
pub(crate) use declare::PluginInfo;
pub use description::SceneDescription;
pub use emitter::{AreaLight, Emitter, EmitterKind};
pub use euler::EulerAngles;
pub(crate) use euler::Turned;
pub(crate) use file_value::FileValue;
pub use film_storage::{ComponentFormat, FilmStorage, PictureFormat, PixelFormat};
pub use fov_axis::FovAxis;
pub(crate) use framing::FrameWhenLoaded;
pub use framing::world_bounds;
pub use group::Placements;
pub(crate) use group::{InstanceOf, Instances, MemberOf, ShapeGroup};
pub use identity::{DocumentOrder, Hidden, Locked, SceneId, ToWorld};
pub use keep_source::KeepSource;
pub(crate) use key_edits::{edit_keys, integrator_keys_after, keys_after, place_path};
pub use keys::{IntegratorKeys, KeyEdit, KeyPath, Keys};
pub(crate) use loading::{ask_for, new_scene};
pub use material::{
    FirstNested, FirstNestedIn, Material, MaterialUsers, Principled, PrincipledThin, SecondNested, SecondNestedIn,
    UsesMaterial,
};
pub use medium::{
    Coefficients, ExteriorMedium, GridFile, InMedium, InteriorMedium, InteriorOf, Medium, PhaseBlend, PhaseFunction,
    VolumeFilter, VolumeFormat, VolumeParameter, VolumeWrap,
};
pub use missing::{FileKind, MissingFile, MissingFiles};
pub use moment::shown_time;
pub(crate) use named_files::NamesFiles;
pub(crate) use object_change::{ObjectChange, Side};
pub(crate) use object_state::ObjectState;
pub use opening::OpeningPace;
pub(crate) use parameter_info::ParameterInfo;
pub use parameters::{
    Absorption, ConductorIor, Cone, Distribution, FieldOfView, Ior, PlaceAndTime, PrincipledIndex, Roughness,
    SunPosition,
};
pub(crate) use parameters::{Declared, ParameterMut, ParameterRef};
pub use pictures::Pictures;
pub use plugin::{ScenePlugin, SceneSystems, asset_plugin};
pub(crate) use posing::pose;
pub use posing::{animated_span, show_moment};
pub use scene_file::SceneFile;
pub use sensor::{Crop, Film, Lens, NoSuchCamera, ReconstructionFilter, Sensor, cameras, find_camera};
pub use settings::{AccelMethod, IntegratorSettings, PathPlugin, SamplerSettings, Sequence, Strategy};
pub use shape::{MeshFile, MeshFormat, Shape, ShapeKind};
pub use solid::Solid;
pub use stand_in::{KnownBounds, StandIns};
pub use status::{
    ActiveSensor, FileProblem, FileReadAgain, FreeView, OpenScene, ReloadSummary, SceneState, SceneStatus,
};
pub use sun_sky::SunSky;
pub use texture::{Bitmap, ChosenPicture, Parameter, SquarePath, Texture, TextureFilter, TextureWrap};
pub use turntable::Turntable;
pub use unit::LengthUnit;
pub(crate) use unit::decimal;
pub use volumes::Volumes;
pub use wall_openings::Opening;
pub use watch::SceneWatch;
