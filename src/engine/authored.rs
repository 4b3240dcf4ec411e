//! The queries by which extraction reads the world, and lists of entities in the order of the file.

use bevy::asset::{AssetServer, UntypedAssetId};
use bevy::ecs::query::QueryData;
use bevy::ecs::system::SystemParam;
use bevy::prelude::*;

use super::pack::Checker;
use super::pack::instance::ShapeSource;
use super::pack::light::{LightContext, pack_emitter};
use super::pack::material::{MaterialSource, PackedMaterials, pack_materials};
use super::pack::medium::{AuthoredMedium, PackedMedia, pack_media};
use super::pack::texture::TexturePacker;
use crate::light::WeightedSource;
use crate::scene::{
    AccelMethod, ActiveSensor, AreaLight, DocumentOrder, Emitter, ExteriorMedium, Film, FirstNested, FreeView,
    GridFile, Hidden, InMedium, InstanceOf, IntegratorSettings, InteriorMedium, InteriorOf, Material, Medium, MemberOf,
    MeshHandle, Pictures, Placements, SamplerSettings, SceneFile, SceneId, SceneStatus, SecondNested, Sensor, Shape,
    ShapeGroup, TextureMap, ToWorld, TriangleMesh, UsesMaterial, VolumeMap, VolumeParameter, Volumes,
};
use crate::shading::DielectricModel;

/// The components of a shape that extraction reads.
#[derive(QueryData)]
pub(super) struct AuthoredShape {
    pub entity: Entity,
    pub order: &'static DocumentOrder,
    pub id: Option<&'static SceneId>,
    pub shape: &'static Shape,
    pub to_world: &'static ToWorld,
    pub mesh: Option<&'static MeshHandle>,
    pub member_of: Option<&'static MemberOf>,
    pub instance_of: Option<(&'static InstanceOf, Option<&'static Placements>)>,
    uses: Option<&'static UsesMaterial>,
    has_light: Has<AreaLight>,
    media: SidesOf,
}

/// The media on the two sides of a shape.
#[derive(QueryData)]
pub(super) struct SidesOf {
    interior: Option<&'static InteriorMedium>,
    exterior: Option<&'static ExteriorMedium>,
}

impl SidesOfItem<'_, '_> {
    /// The inner and the outer medium.
    pub fn entities(&self) -> [Option<Entity>; 2] {
        [
            self.interior.map(|medium| medium.0),
            self.exterior.map(|medium| medium.0),
        ]
    }
}

impl<'w> AuthoredShapeItem<'w, '_> {
    /// The name of the shape in messages.
    pub fn name(&self) -> String {
        name_of("shape", *self.order, self.id)
    }

    /// The components from which the shape is packed.
    pub fn source(&self) -> ShapeSource<'w> {
        ShapeSource {
            order: *self.order,
            entity: self.entity,
            shape: self.shape,
            to_world: self.to_world.0,
            material: self.uses.map(|uses| uses.0),
            has_light: self.has_light,
            media: self.media.entities(),
        }
    }
}

#[derive(SystemParam)]
pub(super) struct Authored<'w, 's> {
    pub shapes: Query<'w, 's, AuthoredShape, Without<Hidden>>,
    pub groups: Query<'w, 's, (Entity, &'static DocumentOrder), With<ShapeGroup>>,
    pub surface_bindings: Query<
        'w,
        's,
        (
            &'static DocumentOrder,
            Option<&'static SceneId>,
            Option<&'static UsesMaterial>,
            Option<&'static AreaLight>,
            SidesOf,
        ),
        With<Shape>,
    >,
    pub materials: Query<
        'w,
        's,
        (
            Entity,
            &'static DocumentOrder,
            Option<&'static SceneId>,
            &'static Material,
            Option<&'static FirstNested>,
            Option<&'static SecondNested>,
        ),
    >,
    pub media: Query<
        'w,
        's,
        (
            Entity,
            &'static DocumentOrder,
            Option<&'static SceneId>,
            &'static Medium,
            Option<&'static InteriorOf>,
        ),
    >,
    pub hidden: Query<'w, 's, (), With<Hidden>>,
    pub emitters: Query<
        'w,
        's,
        (
            Entity,
            &'static DocumentOrder,
            Option<&'static SceneId>,
            &'static Emitter,
            &'static ToWorld,
        ),
        Without<Hidden>,
    >,
    pub sensors: Query<
        'w,
        's,
        (
            &'static DocumentOrder,
            Option<&'static SceneId>,
            &'static Sensor,
            &'static Film,
            &'static ToWorld,
            Option<&'static InMedium>,
        ),
    >,
    pub active: Res<'w, ActiveSensor>,
    pub free_view: Res<'w, FreeView>,
    pub integrator: Res<'w, IntegratorSettings>,
    pub sampler: Res<'w, SamplerSettings>,
    pub method: Res<'w, AccelMethod>,
    pub meshes: Res<'w, Assets<TriangleMesh>>,
    pub pictures: Res<'w, Pictures>,
    pub texture_maps: Res<'w, Assets<TextureMap>>,
    pub volumes: Res<'w, Volumes>,
    pub volume_maps: Res<'w, Assets<VolumeMap>>,
    pub asset_server: Option<Res<'w, AssetServer>>,
    pub status: Res<'w, SceneStatus>,
    file: Option<Res<'w, SceneFile>>,
}

impl Authored<'_, '_> {
    /// Packs all materials in the order of the file. Problems are added to `errors`, and a material that cannot be
    /// packed is replaced by the default.
    pub(crate) fn pack_materials(
        &self,
        model: DielectricModel,
        textures: &mut TexturePacker,
        errors: &mut Vec<String>,
    ) -> PackedMaterials {
        let mut materials: Vec<_> = self.materials.iter().collect();
        materials.sort_by_key(|&(entity, &order, ..)| (order, entity));
        let sources: Vec<MaterialSource> = materials
            .into_iter()
            .map(|(entity, order, id, material, first, second)| MaterialSource {
                entity,
                name: name_of("material", *order, id),
                material,
                first: first.map(|first| first.0),
                second: second.map(|second| second.0),
            })
            .collect();
        pack_materials(&sources, model, textures, errors)
    }

    /// Whether a file was requested and could not be read.
    pub(super) fn has_failed(&self, id: impl Into<UntypedAssetId>) -> bool {
        let server = self.asset_server.as_deref();
        server.is_some_and(|server| server.load_state(id).is_failed())
    }

    /// Whether all shapes with this medium inside are hidden, which removes the medium.
    fn are_hidden(&self, shapes: &InteriorOf) -> bool {
        !shapes.is_empty() && shapes.iter().all(|shape| self.hidden.contains(shape))
    }

    /// Packs all media in the order of the file; none if the integrator ignores media.
    pub(crate) fn pack_media(&self, errors: &mut Vec<String>) -> PackedMedia {
        if !self.integrator.plugin.traces_media() {
            return PackedMedia::default();
        }
        let mut media: Vec<_> = self.media.iter().collect();
        media.sort_by_key(|&(entity, &order, ..)| (order, entity));
        let authored: Vec<AuthoredMedium> = media
            .into_iter()
            .filter(|(.., shapes)| !shapes.is_some_and(|shapes| self.are_hidden(shapes)))
            .map(|(entity, order, id, medium, _)| AuthoredMedium {
                entity,
                name: match id {
                    Some(_) => name_of("medium", *order, id),
                    None => format!("medium of type {}", medium.plugin()),
                },
                medium,
            })
            .collect();
        let volumes = |file: &GridFile| self.volume_maps.get(self.volumes.get(&file.asset_path())?);
        pack_media(&authored, &volumes, errors)
    }

    /// The grid file of a medium's density, as the scene file names it; None without a file.
    pub fn place_of_density(&self, medium: Entity) -> Option<String> {
        let (_, _, _, medium, _) = self.media.get(medium).ok()?;
        match medium.coefficients.sigma_t_and_albedo().0 {
            VolumeParameter::Grid(grid) => self.file.as_ref()?.place_of_volume(&grid.asset_path()),
            VolumeParameter::Constant(_) | VolumeParameter::Box { .. } => None,
        }
    }

    /// Packs the lights that are not surfaces in the order of the file and adds them to `lights`.
    pub(crate) fn pack_emitters(
        &self,
        context: &mut LightContext,
        lights: &mut Vec<(Entity, WeightedSource)>,
        errors: &mut Vec<String>,
    ) {
        let mut emitters: Vec<_> = self.emitters.iter().collect();
        emitters.sort_by_key(|&(entity, &order, ..)| (order, entity));
        for (entity, order, id, emitter, to_world) in emitters {
            let name = name_of("emitter", *order, id);
            let mut check = Checker { name: &name, errors };
            let light = pack_emitter(emitter, to_world.0, context, &mut check);
            lights.extend(light.map(|light| (entity, light)));
        }
    }
}

/// The name of an entity in messages.
pub(super) fn name_of(kind: &str, order: DocumentOrder, id: Option<&SceneId>) -> String {
    match id {
        Some(SceneId(id)) => format!("{kind} \"{id}\""),
        None => format!("{kind} {}", order.0),
    }
}
