//! The scene as the editor sees it: entities with plain components, and the assets they name. No scheduling of
//! rendering here.
//!
//! Every shape, material, emitter and sensor is one entity. References are relationships, settings are resources.

pub mod assets;
pub mod components;
pub mod edits;
pub mod encode;
pub mod export;
pub mod file;
pub mod load;
pub mod read;
pub mod write;

pub use assets::{FileSourcePlugin, MeshHandle, MeshShape, TextureMap, TriangleMesh, VolumeMap};
pub use components::access::{SceneAccess, Trust};
pub use components::authored::{Authored, AuthoredScene};
pub(crate) use components::authored::{DeclaredIn, Declares};
pub(crate) use components::declare::PluginInfo;
pub use components::description::SceneDescription;
pub(crate) use components::emitter::FLUX;
pub use components::emitter::{AreaLight, Emitter, EmitterKind};
pub use components::euler::EulerAngles;
pub(crate) use components::euler::Turned;
pub(crate) use components::file_value::FileValue;
pub use components::film_storage::{ComponentFormat, FilmStorage, PictureFormat, PixelFormat};
pub use components::fov_axis::FovAxis;
pub use components::group::Placements;
pub(crate) use components::group::{InstanceOf, Instances, MemberOf, ShapeGroup};
pub use components::identity::{DocumentOrder, Hidden, Locked, SceneId, ToWorld};
pub use components::keys::{IntegratorKeys, KeyEdit, KeyPath, Keys};
pub use components::light_units::LightUnits;
pub use components::material::{
    FirstNested, FirstNestedIn, Material, MaterialUsers, Principled, PrincipledThin, SecondNested, SecondNestedIn,
    UsesMaterial,
};
pub use components::medium::{
    Coefficients, ExteriorMedium, GridFile, InMedium, InteriorMedium, InteriorOf, Medium, PhaseBlend, PhaseFunction,
    VolumeFilter, VolumeFormat, VolumeParameter, VolumeWrap,
};
pub use components::missing::{FileKind, MissingFile, MissingFiles};
pub use components::moment::shown_time;
pub(crate) use components::named_files::NamesFiles;
pub(crate) use components::object_state::ObjectState;
pub(crate) use components::parameter_info::ParameterInfo;
pub use components::parameters::{
    Absorption, ConductorIor, Cone, Distribution, FieldOfView, Ior, PlaceAndTime, PrincipledIndex, Roughness,
    SunPosition,
};
pub(crate) use components::parameters::{Declared, ParameterMut, ParameterRef};
pub use components::pattern::{Choice, Stop};
pub use components::properties::{ItemType, Properties, PropertyItem, PropertyType, PropertyValue, SceneProperties};
pub use components::sensor::{Crop, Film, Lens, NoSuchCamera, ReconstructionFilter, Sensor, cameras, find_camera};
pub use components::settings::{AccelMethod, IntegratorSettings, PathPlugin, SamplerSettings, Sequence, Strategy};
pub use components::shape::{MeshFile, MeshFormat, Shape, ShapeKind};
pub use components::solid::Solid;
pub use components::status::{
    ActiveSensor, FileProblem, FileReadAgain, FreeView, OpenScene, ReloadSummary, SceneState, SceneStatus,
};
pub use components::sun_sky::SunSky;
pub use components::texture::{
    Bitmap, ChosenPicture, Parameter, Pattern, SquarePath, Texture, TextureFilter, TextureWrap,
};
pub use components::unit::LengthUnit;
pub(crate) use components::unit::decimal;
pub use components::wall_openings::Opening;
pub use components::{aperture, carry_over, description, euler, marker, medium, pattern};
pub(crate) use components::{folders, free_name, listed, names, parameters, texture_parameters, wall_openings};
pub use edits::insert;
pub(crate) use edits::key_edits::{edit_keys, integrator_keys_after, keys_after, place_path};
pub(crate) use edits::object_change::{ObjectChange, Side};
pub(crate) use edits::posing::pose;
pub use edits::posing::{animated_span, show_moment};
pub use edits::turntable::Turntable;
pub(crate) use file::changes;
pub use file::keep_source::KeepSource;
pub(crate) use load::framing::FrameWhenLoaded;
pub use load::framing::world_bounds;
pub(crate) use load::loading::{ask_for, new_scene};
pub use load::opening::OpeningPace;
pub use load::pictures::Pictures;
pub use load::plugin::{ScenePlugin, SceneSystems, asset_plugin};
pub use load::scene_file::SceneFile;
pub use load::stand_in::{KnownBounds, StandIns};
pub use load::volumes::Volumes;
pub use load::watch::SceneWatch;
pub use load::{mesh_check, picture_check, spawn, volume_check};
