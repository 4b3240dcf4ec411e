//! The plugin with all parts of the scene that an app needs: types, assets, and the systems between files and entities.

use bevy::asset::{AssetApp, AssetTrackingSystems};
use bevy::prelude::*;

use super::loading::{apply_scenes, open_scenes};
use super::meshes::{follow_mesh_files, report_meshes};
use super::pictures::{Pictures, follow_pictures, report_pictures};
use super::scene_file::SceneFile;
use super::stand_in::note_bounds;
use super::volumes::{Volumes, follow_volumes, report_volumes};
use super::watch::{SceneWatch, list_files, reload_changed_files, report_gone_files};
use crate::scene::assets::{
    MeshHandle, MeshLoader, SceneAsset, SceneDefines, SceneLoader, TextureMap, TextureMapLoader, TriangleMesh,
    VolumeMap, VolumeMapLoader,
};
// Bevy's renderer has a trait `Material`, which is in the prelude when the lints build `sunroom-game` as well.
use crate::scene::{Material, *};

/// Adds scenes to an app that has [`AssetPlugin`] with absolute paths allowed:
///
/// ```text
/// app.add_plugins((MinimalPlugins, FileSourcePlugin, scene::asset_plugin(), ScenePlugin));
/// app.world_mut().write_message(OpenScene { path, ..default() });
/// ```
pub struct ScenePlugin;

/// Bevy's asset plugin with the settings for scenes: it reads files anywhere on the disk, without `.meta` files.
pub fn asset_plugin() -> AssetPlugin {
    AssetPlugin {
        unapproved_path_mode: bevy::asset::UnapprovedPathMode::Allow,
        meta_check: bevy::asset::AssetMetaCheck::Never,
        watch_for_changes_override: Some(false),
        ..default()
    }
}

/// The systems in `PreUpdate`, in this order, after the asset server has stored what it read.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum SceneSystems {
    /// Requested and changed files are handed to the asset server.
    Request,
    /// The scene that was read becomes entities.
    Apply,
    /// Handles of meshes and pictures follow the components that name them; the status is updated.
    Follow,
}

impl Plugin for ScenePlugin {
    fn build(&self, app: &mut App) {
        let defines = SceneDefines::default();
        let access = app.world_mut().get_resource_or_init::<SceneAccess>().clone();
        let keep_source = app.world_mut().get_resource_or_init::<KeepSource>().clone();
        app.init_asset::<TriangleMesh>()
            .init_asset::<TextureMap>()
            .init_asset::<VolumeMap>()
            .init_asset::<SceneAsset>()
            .register_asset_loader(MeshLoader { access: access.clone() })
            .register_asset_loader(TextureMapLoader { access: access.clone() })
            .register_asset_loader(VolumeMapLoader { access: access.clone() })
            .register_asset_loader(SceneLoader {
                defines: defines.clone(),
                access,
                keep_source,
            })
            .add_message::<OpenScene>()
            .add_message::<FileReadAgain>()
            .insert_resource(defines)
            .init_resource::<Trust>()
            .init_resource::<SceneFile>()
            .init_resource::<SceneWatch>()
            .init_resource::<Pictures>()
            .init_resource::<Volumes>()
            .init_resource::<SceneStatus>()
            .init_resource::<KnownBounds>()
            .init_resource::<crate::scene::file::known::KnownTexts>()
            .init_resource::<ActiveSensor>()
            .init_resource::<FreeView>()
            .init_resource::<AuthoredScene>()
            .init_resource::<IntegratorSettings>()
            .init_resource::<IntegratorKeys>()
            .init_resource::<LengthUnit>()
            .init_resource::<LightUnits>()
            .init_resource::<SceneProperties>()
            .init_resource::<SamplerSettings>()
            .init_resource::<AccelMethod>();
        app.register_type::<Shape>()
            .register_type::<Material>()
            .register_type::<UsesMaterial>()
            .register_type::<FirstNested>()
            .register_type::<SecondNested>()
            .register_type::<Medium>()
            .register_type::<InteriorMedium>()
            .register_type::<ExteriorMedium>()
            .register_type::<InMedium>()
            .register_type::<DeclaredIn>()
            .register_type::<Emitter>()
            .register_type::<AreaLight>()
            .register_type::<Sensor>()
            .register_type::<Film>()
            .register_type::<LengthUnit>()
            .register_type::<LightUnits>()
            .register_type::<ToWorld>()
            .register_type::<EulerAngles>()
            .register_type::<SceneId>()
            .register_type::<DocumentOrder>()
            .register_type::<MeshHandle>();
        app.configure_sets(
            PreUpdate,
            (SceneSystems::Request, SceneSystems::Apply, SceneSystems::Follow)
                .chain()
                .after(AssetTrackingSystems),
        );
        app.add_systems(
            PreUpdate,
            (
                (reload_changed_files, open_scenes)
                    .chain()
                    .in_set(SceneSystems::Request),
                apply_scenes.in_set(SceneSystems::Apply),
                (
                    follow_mesh_files,
                    report_meshes,
                    note_bounds,
                    follow_pictures,
                    report_pictures,
                    follow_volumes,
                    report_volumes,
                    list_files,
                    report_gone_files,
                    super::framing::frame_scene,
                )
                    .chain()
                    .in_set(SceneSystems::Follow),
            ),
        );
    }
}
