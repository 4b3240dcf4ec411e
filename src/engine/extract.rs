//! The exact half of change detection: packs the tables that may be out of date, compares them with the current ones,
//! and replaces only those that differ. Entities, handles and names are resolved here.

mod view;

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use bevy::ecs::entity::EntityHashMap;
use bevy::prelude::*;

use super::attributes::missing_attributes;
use super::authored::{Authored, name_of};
use super::auto::{AutoIntegrator, is_auto};
use super::blas_cache::{BlasCache, BuildPolicy};
use super::control::{RenderControl, WakeUp};
use super::deferred_drop::DeferredDrop;
use super::detect::{Dirty, Touched};
use super::instances::packing::Packing;
use super::instances::rebuild::Rebuild;
use super::instances::splice::{ListEdits, ShapeChanges};
use super::light_groups::{Lamps, LightGroup, MOST_FOR_GROUPS, group_lights, most_groups};
use super::pack::environment::Environments;
use super::pack::group::Layout;
use super::pack::light::LightContext;
use super::pack::material::material_table;
use super::pack::medium::PackedMedia;
use super::pack::surface::{SurfacePacker, SurfaceSource};
use super::pack::texture::{TexturePacker, no_picture};
use super::packed_scene::PackedScene;
use super::portals::PortalsInUse;
use super::renderer::Renderer;
use super::sight::{SeenAlone, SeenThrough};
use super::status::BvhStatus;
use super::stop_condition::FilmLimits;
use crate::accel::{SplitMethod, Tlas};
use crate::color::Rgb;
use crate::layer::Layer;
use crate::light::emission::Reach;
use crate::light::{LightSource, LightTable};
use crate::material::{MaterialId, MaterialTable};
use crate::medium::{MediumId, Volume};
use crate::render::guide::Guide;
use crate::render::light_layers::LightGroups;
use crate::render::scene::{RenderScene, SurfaceTable};
use crate::render::view::{Integrator, View};
use crate::scene::{AccelMethod, DocumentOrder, Film, SceneStatus};
use crate::shading::DielectricModel;
use crate::texture::TextureTable;

/// The time for which a change waits, in an uninterrupted series of changes, until the preview of the previous one has
/// been shown.
const PREVIEW_PATIENCE: Duration = Duration::from_millis(100);

/// The tables that were packed last.
#[derive(Resource)]
pub(super) struct Extracted {
    pub scene: RenderScene,
    /// The view; None before the first camera.
    pub view: Option<View>,
    /// The lights of each group of the view.
    pub light_groups: Arc<[LightGroup]>,
    /// The sample count of the sensor's film.
    pub sample_count: u32,
    /// The noise target of the sensor's film, see [`Film::noise_target`].
    pub noise_target: Option<f32>,
    /// The setting of the sensor's film, see [`Film::adaptive`].
    pub is_adaptive: bool,
    /// The size of the picture at full resolution in pixels.
    pub full_size: UVec2,
    /// The time of the first change of the scene or the view; the next job takes it.
    pub since: Option<std::time::Instant>,
    pub meshes_loading: u32,
    pub triangles: u64,
    pub bvh: BvhStatus,
    pub(super) layout: Layout,
    pub(super) entity_of_instance: Arc<[Entity]>,
    material_of_entity: Arc<EntityHashMap<MaterialId>>,
    /// See [`PackedSurfaces::special`](super::pack::surface::PackedSurfaces::special).
    pub(super) special: Vec<u32>,
    pub(super) method: SplitMethod,
    /// The lights of the scene.
    pub lamps: Arc<Lamps>,
    packed_media: PackedMedia,
    /// The groups of lights, and (next) the group of each light.
    owners: Arc<[LightGroup]>,
    layers: LightGroups,
    /// The portals of the scene's lights.
    portals: PortalsInUse,
    /// The most groups that they were made for; 0: they have to be made.
    most_groups: usize,
    environments: Environments,
    /// The unfinished packing of all shapes.
    pub(super) packing: Option<Packing>,
    /// The [`SceneStatus::revision`](crate::scene::SceneStatus::revision) of that packing.
    pub(super) packs_revision: u64,
    /// The revision of the last finished packing of all shapes.
    pub(super) packed_revision: u64,
    pub(super) rebuild: Option<Rebuild>,
    pub(super) errors: Errors,
    /// The name of the view's sensor.
    sensor_name: String,
    /// The view's displacement from its sensor; None if it is the sensor's own view.
    flight: Option<Flight>,
    seen_alone: SeenAlone,
    /// The guide of the scene's paths, which all views share.
    pub guide: Guide,
    /// Whether guiding is requested, whatever the integrator `auto` chooses.
    pub guide_is_asked: bool,
    seen_through: SeenThrough,
}

/// The displacement of a view from its sensor, over which the medium is tracked.
struct Flight {
    /// The position of the sensor in world space.
    from: Vec3,
    /// The medium at the sensor.
    medium: Option<MediumId>,
    /// The position of the view in world space.
    to: Vec3,
}

/// Errors by the step that found them, so that the errors of a step that is skipped stay.
#[derive(Default)]
pub(super) struct Errors {
    /// Errors of shapes, in the order of the file.
    pub instances: BTreeMap<(DocumentOrder, Entity), String>,
    /// Errors of the hierarchies of meshes.
    pub meshes: Vec<String>,
    /// Errors of groups, found when the hierarchy is built.
    pub placements: Vec<String>,
    surfaces: Vec<String>,
    media: Vec<String>,
    emitters: Vec<String>,
    /// Errors of emitters that do not fit into the memory budget.
    shortages: Vec<String>,
    view: Vec<String>,
    /// Messages about clip planes, which depend on the view and on the geometry.
    clipping: Vec<String>,
}

impl Default for Extracted {
    fn default() -> Self {
        let geometry = Tlas::build(Vec::new(), SplitMethod::default());
        Self {
            scene: RenderScene {
                media: Arc::default(),
                lights: Arc::new(LightTable::build(&[], &geometry, &Arc::default())),
                reach: Reach::default(),
                geometry: Arc::new(geometry),
                surfaces: Arc::new(SurfaceTable::default()),
                materials: Arc::new(MaterialTable::default()),
                textures: Arc::new(TextureTable::default()),
            },
            view: None,
            light_groups: Arc::default(),
            sample_count: Film::default().sample_count,
            noise_target: None,
            is_adaptive: false,
            full_size: UVec2::ZERO,
            since: None,
            meshes_loading: 0,
            triangles: 0,
            bvh: BvhStatus::default(),
            layout: Layout::default(),
            entity_of_instance: Arc::from([]),
            material_of_entity: Arc::default(),
            special: Vec::new(),
            method: SplitMethod::default(),
            lamps: Arc::default(),
            packed_media: PackedMedia::default(),
            owners: Arc::default(),
            layers: LightGroups::default(),
            portals: PortalsInUse::default(),
            most_groups: 0,
            environments: Environments::default(),
            packing: None,
            packs_revision: 0,
            packed_revision: 0,
            rebuild: None,
            errors: Errors::default(),
            sensor_name: String::new(),
            flight: None,
            seen_alone: SeenAlone::default(),
            guide: Guide::default(),
            guide_is_asked: false,
            seen_through: SeenThrough::default(),
        }
    }
}

impl Extracted {
    /// Whether the tables are still those of the previous scene: the status says that another one is being opened, or
    /// its shapes are still being packed.
    pub fn is_of_another(&self, status: &SceneStatus) -> bool {
        status.is_opening || status.fresh_load && self.packs_revision != self.packed_revision
    }

    /// The limits set by the film.
    pub fn film_limits(&self) -> FilmLimits {
        FilmLimits {
            samples: self.sample_count,
            noise: self.noise_target,
            is_adaptive: self.is_adaptive,
        }
    }

    pub fn errors(&self) -> impl Iterator<Item = &String> {
        let Errors {
            instances,
            meshes,
            placements,
            surfaces,
            media,
            emitters,
            shortages,
            view,
            clipping,
        } = &self.errors;
        let first = [shortages, view, clipping].into_iter().flatten();
        let others = [meshes, placements, surfaces, media, emitters].into_iter().flatten();
        first.chain(instances.values()).chain(others)
    }

    pub fn shortages(&self) -> &[String] {
        &self.errors.shortages
    }
}

pub(super) fn extract_scene(
    mut dirty: ResMut<Dirty>,
    mut extracted: ResMut<Extracted>,
    mut packed: ResMut<PackedScene>,
    mut cache: ResMut<BlasCache>,
    renderer: Res<Renderer>,
    mut control: ResMut<RenderControl>,
    wake_up: Res<WakeUp>,
    deferred: Res<DeferredDrop>,
    auto: Res<AutoIntegrator>,
    authored: Authored,
) {
    let is_other_scene = authored.status.is_opening || extracted.packs_revision != authored.status.revision;
    if is_other_scene && extracted.packing.take().is_some() {
        dirty.instances = Touched::All;
    }
    if authored.status.is_opening {
        return;
    }
    if cache.poll() {
        dirty.instances = Touched::All;
    }
    let is_packing = extracted.packing.is_some();
    let preview_owed = renderer
        .job()
        .is_some_and(|job| job.preview_pending() && job.begun.elapsed() < PREVIEW_PATIENCE);
    if !(dirty.any() || is_packing) || (preview_owed && control.interactive && !control.paused) {
        return;
    }
    let old = extracted.scene.clone();
    let old_view = extracted.view.clone();
    let guide_was_asked = extracted.guide_is_asked;
    let mut changes = Some(ShapeChanges {
        moved: Vec::new(),
        edits: Some(ListEdits::default()),
    });
    let has_shapes = is_packing || dirty.instances.any();
    if has_shapes {
        let policy = BuildPolicy {
            method: split_method(*authored.method),
            threads: control.threads.get(),
            wait: !control.interactive,
            wake_up: wake_up.clone(),
        };
        changes = extracted.update_shapes(&mut dirty.instances, &authored, &mut cache, &policy);
    }
    // The camera of a scene that was just opened waits for its shapes.
    let is_new_scene = extracted.is_of_another(&authored.status);
    if changes.is_none() && (is_new_scene || !dirty.view) {
        return;
    }
    if let Some(changes) = &mut changes {
        extracted.update_bindings(&dirty.surfaces, &authored, changes);
        if dirty.media {
            extracted.update_media(&authored);
            changes.edits = None;
        }
        if has_shapes || dirty.surfaces.any() || dirty.materials || dirty.lights || dirty.media {
            extracted.update_surfaces_and_lights(&authored, changes);
        }
    }
    // The id of the camera's medium may have changed.
    if dirty.view || dirty.media && changes.is_some() {
        extracted.update_view(&authored, &control);
    }
    let keeps_groups = control.light_layers || authored.integrator.layers.contains(Layer::LightGroups);
    extracted.update_layers(keeps_groups, control.lights_are_free);
    extracted.update_medium_of_view();
    extracted.update_sight(&control.sight);
    let same_scene = old.is_same(&extracted.scene);
    let is_auto = is_auto(&authored.integrator, &control);
    let old_guide = extracted.keep_guide(same_scene);
    extracted.forget_choice(is_auto);
    let has_size_until_change = control.full_until_change || control.framing_until_change.is_some();
    let mut as_chosen = old_view.clone();
    if let Some(view) = as_chosen.as_mut().filter(|_| is_auto) {
        // A choice of integrator does not count as a change of the view.
        view.integrator = Integrator::Path(view.integrator.settings());
        view.guide = guide_was_asked.then(|| extracted.guide.clone());
    }
    if has_size_until_change && !(same_scene && extracted.sees_as(as_chosen.as_ref())) {
        control.forget_size_until_change();
        extracted.update_view(&authored, &control);
        extracted.update_layers(keeps_groups, control.lights_are_free);
        extracted.update_medium_of_view();
        extracted.update_sight(&control.sight);
        extracted.keep_guide(true);
    }
    extracted.forget_choice(is_auto);
    if is_auto {
        extracted.take_choice(&auto);
    }
    extracted.update_clipping();
    if !same_scene || old_view != extracted.view {
        extracted.since = extracted.since.or(dirty.since);
    }
    deferred.drop_later((old, old_guide, std::mem::replace(&mut *packed, extracted.packed())));
    *dirty = dirty.left(changes.is_some());
}

impl Extracted {
    /// The scene for queries of the editor.
    fn packed(&self) -> PackedScene {
        PackedScene {
            scene: Some(self.scene.clone()),
            entity_of_instance: self.entity_of_instance.clone(),
            material_of_entity: self.material_of_entity.clone(),
            medium_of_entity: self.packed_media.ids.clone(),
            lamps: self.lamps.clone(),
            view: self.view.clone(),
        }
    }

    fn update_media(&mut self, authored: &Authored) {
        self.errors.media.clear();
        let packed = authored.pack_media(&mut self.errors.media);
        if self.packed_media.sources != packed.sources {
            self.scene.media = Arc::new(self.scene.media.with(packed.sources.clone()));
        }
        for (place, (name, medium)) in packed.names.iter().zip(self.scene.media.iter()).enumerate() {
            let Some(limited) = medium.limited() else { continue };
            let entity = packed.ids.iter().find(|(_, id)| id.0 as usize == place);
            let message = match entity.and_then(|(entity, _)| authored.place_of_density(*entity)) {
                Some(named) => format!("{name} ({named}): {limited}"),
                None => format!("{name}: {limited}"),
            };
            self.errors.media.push(message);
        }
        self.packed_media = packed;
    }

    fn update_surfaces_and_lights(&mut self, authored: &Authored, changes: &ShapeChanges) {
        self.errors.surfaces.clear();
        let model = if authored.integrator.schlick {
            DielectricModel::Schlick
        } else {
            DielectricModel::Exact
        };
        let picture = |path: &Path| {
            let handle = authored.pictures.get(path)?;
            match authored.texture_maps.get(handle) {
                Some(asset) => Some(asset.image.clone()),
                None => authored.has_failed(handle.id()).then(no_picture),
            }
        };
        let mut textures = TexturePacker::new(&picture);
        let packed = authored.pack_materials(model, &mut textures, &mut self.errors.surfaces);
        let (materials, tables, ids) = (packed.materials, packed.tables, packed.ids);
        let source = |entity: Entity| {
            let found = authored.surface_bindings.get(entity).ok();
            SurfaceSource {
                name: found
                    .as_ref()
                    .map_or_else(String::new, |(order, id, ..)| name_of("shape", **order, *id)),
                light: found.and_then(|(_, _, _, light, _)| light),
            }
        };
        let edits = changes.edits.as_ref().filter(|_| *self.material_of_entity == ids);
        let packed = SurfacePacker {
            layout: &self.layout,
            source,
            ids: &ids,
            media: &self.packed_media.ids,
            model,
            textures: &mut textures,
            errors: &mut self.errors.surfaces,
        }
        .pack(materials, &self.scene.surfaces, &self.special, edits);
        (self.scene.surfaces, self.special) = (packed.table, packed.special);
        if *self.material_of_entity != ids {
            self.material_of_entity = Arc::new(ids);
        }
        let table = material_table(packed.materials, tables, &mut self.errors.surfaces);
        self.errors.surfaces.extend(missing_attributes(authored, &self.layout));
        if *self.scene.materials != table {
            self.scene.materials = Arc::new(table);
        }
        let mut sources = packed.lights;
        self.errors.emitters.clear();
        self.errors.shortages.clear();
        self.environments.begin_use();
        let mut context = LightContext {
            textures: &mut textures,
            environments: &mut self.environments,
            shortages: &mut self.errors.shortages,
        };
        authored.pack_emitters(&mut context, &mut sources, &mut self.errors.emitters);
        self.environments.end_use();
        let textures = TextureTable::new(textures.finish());
        let repainted = *self.scene.textures != textures;
        if repainted {
            self.scene.textures = Arc::new(textures);
        }
        let (owners, sources) = sources.into_iter().unzip();
        let lamps = Lamps { owners, sources };
        self.most_groups = 0;
        self.update_lights(lamps, repainted, &changes.moved);
    }

    /// Updates the lights. `repainted` says that textures have changed.
    fn update_lights(&mut self, lamps: Lamps, repainted: bool, moved: &[bool]) {
        let sources = &lamps.sources;
        let is_same = *self.lamps == lamps;
        let is_textured = sources.iter().any(|weighted| weighted.source.is_textured());
        let has_moved = sources.iter().any(|weighted| match &weighted.source {
            LightSource::Surface { instance, .. } => moved.get(*instance as usize) == Some(&true),
            _ => false,
        });
        let portals = PortalsInUse::new(self.layout.portals(), &self.scene);
        let has_same_portals = self.portals.are(&portals);
        if has_moved || (is_textured && repainted) || !is_same {
            // Lights without textures do not keep old textures alive.
            let textures = if is_textured {
                self.scene.textures.clone()
            } else {
                Arc::default()
            };
            let table = LightTable::build(sources, &self.scene.geometry, &textures);
            self.scene.lights = Arc::new(portals.applied_to(table, &self.scene));
        } else if !has_same_portals {
            let table = LightTable::clone(&self.scene.lights);
            self.scene.lights = Arc::new(portals.applied_to(table, &self.scene));
        }
        self.portals = portals;
        if !is_same {
            self.lamps = Arc::new(lamps);
        }
        // Other shapes may have moved, too.
        self.scene.reach = self.scene.lights.reach(&self.scene.geometry);
    }

    /// Whether a medium emits light, which belongs to no light group.
    pub fn has_glowing_media(&self) -> bool {
        self.packed_media
            .sources
            .iter()
            .any(|medium| medium.emission != Volume::ZERO)
    }

    fn pixels(&self) -> u64 {
        let view = self.view.as_ref();
        view.map_or(0, |view| u64::from(view.width) * u64::from(view.height))
    }

    /// Whether layers for several groups take little memory. A single group needs no layer: it is all light.
    fn has_room_for_groups(&self) -> bool {
        self.layers.count() > 1 && self.pixels() * (self.layers.count() * size_of::<Rgb>()) as u64 <= MOST_FOR_GROUPS
    }

    /// Sets which groups the film keeps in layers: if `wanted`, all of them with their lights, or else if lights are
    /// free and memory allows.
    fn update_layers(&mut self, wanted: bool, lights_are_free: bool) {
        let most = most_groups(self.pixels(), wanted);
        if self.most_groups != most {
            self.most_groups = most;
            (self.owners, self.layers) = group_lights(&self.lamps.owners, most);
        }
        self.light_groups = if wanted { self.owners.clone() } else { Arc::default() };
        let layers = match wanted || lights_are_free && self.has_room_for_groups() {
            true => self.layers.clone(),
            false => LightGroups::default(),
        };
        if let Some(view) = &mut self.view {
            view.light_groups = layers;
        }
    }
}

fn split_method(method: AccelMethod) -> SplitMethod {
    match method {
        AccelMethod::Linear => SplitMethod::Linear,
        AccelMethod::Median => SplitMethod::Median,
        AccelMethod::Sah => SplitMethod::Sah,
    }
}
