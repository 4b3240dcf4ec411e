//! Gathers the data of the viewport from the world.

use std::iter;
use std::sync::Arc;

use bevy::ecs::entity::EntityHashSet;
use bevy::ecs::system::SystemParam;
use bevy::math::Affine3A;
use bevy::prelude::*;
use bevy_egui::egui;

use super::blocking::hand::BlockTarget;
use super::captions::{Caption, captions};
use super::gizmo::Target;
use super::icons::{Icon, IconKind, MarkerPath};
use super::lamp_solid::LampSolid;
use super::stand_ins::StandIn;
use super::state::ViewportState;
use super::texturing::TextureTarget;
use crate::accel::Tlas;
use crate::app::editor::camera::picking;
use crate::app::editor::camera::pose::camera_pose;
use crate::app::editor::command::bvh_overlay::BvhOverlay;
use crate::app::editor::command::compare_view::CompareView;
use crate::app::editor::command::key_bindings::KeyBindings;
use crate::app::editor::command::preferences::Preferences;
use crate::app::editor::command::selection::Selection;
use crate::app::editor::command::texture_placing::{texture_groups, upright};
use crate::app::editor::command::tool::Tool;
use crate::app::editor::input::actions::hint;
use crate::app::editor::model::freedom::Freedom;
use crate::app::editor::model::{EditorModel, Inspected, Sizes};
use crate::app::editor::picture::denoiser::DenoiserState;
use crate::app::editor::picture::legend::{Legend, legend};
use crate::app::editor::picture::outline::SelectionOutline;
use crate::app::editor::picture::outline_pass::OutlinePass;
use crate::app::editor::picture::overlay::{self, BoxList};
use crate::app::editor::picture::texture::Picture;
use crate::app::editor::picture::wireframe::Wireframe;
use crate::app::editor::session::view_settings::ViewSettings;
use crate::engine::{PackedScene, RenderFilm};
use crate::math::Aabb;
use crate::scene::marker::{self, MarkerLook};
use crate::scene::{
    ActiveSensor, AreaLight, Emitter, EmitterKind, Film, FreeView, Hidden, Locked, MemberOf, Placements, Properties,
    SceneProperties, SceneState, SceneStatus, Sensor, Shape, StandIns, ToWorld, world_bounds,
};

/// The view of the scene in the viewport, as of this frame. Results that take long to compute are kept from frame to
/// frame.
#[derive(Resource, Default)]
pub(crate) struct ViewportScene {
    /// The picture and its size in pixels.
    pub picture: Option<(egui::TextureId, [u32; 2])>,
    /// The corners of the film in the picture.
    pub film_in_picture: [Vec2; 2],
    /// Whether the view is that of a camera.
    pub is_through_camera: bool,
    /// The size of the film in pixels.
    pub proportions: [u32; 2],
    /// The text in place of the picture while there is none.
    pub placeholder: String,
    /// World from camera; None without a camera.
    pub pose: Option<Affine3A>,
    pub outline: SelectionOutline,
    pub wireframe: Wireframe,
    /// The boxes of the volumes of the selection's media, as world from the unit cube.
    pub volume_boxes: Vec<Affine3A>,
    /// The intensities of the selected lamp.
    pub lamp_solid: Option<LampSolid>,
    pub locked: EntityHashSet,
    /// The selected things that can be moved, with their bounds.
    pub targets: Vec<Target>,
    pub icons: Vec<Icon>,
    /// The lines of markers that are paths.
    pub paths: Vec<MarkerPath>,
    /// The boxes in place of meshes that are missing.
    pub stand_ins: Vec<StandIn>,
    /// The shapes whose boxes `stand_ins` may hold.
    lacking: Vec<Entity>,
    /// The shapes under the pointer and around it, while a tool blocks out.
    pub blocks: Vec<BlockTarget>,
    /// The textures of the selected shape, while a tool places them.
    pub textures: Option<TextureTarget>,
    /// The legend of false colours, if there are any.
    pub legend: Option<Legend>,
    pub captions: Vec<Caption>,
    pub compared: CompareView,
    boxes: CollectedBoxes,
    bounds: SelectionBounds,
    members: UnselectedMembers,
}

impl ViewportScene {
    /// The boxes of the acceleration structures that are drawn over the picture.
    pub fn boxes(&self) -> &BoxList {
        &self.boxes.list
    }
}

/// The boxes as they were last collected.
#[derive(Default)]
struct CollectedBoxes {
    from: Option<(Arc<Tlas>, BvhOverlay)>,
    list: BoxList,
}

impl CollectedBoxes {
    fn update(&mut self, packed: &PackedScene, overlay: &BvhOverlay) {
        let Some(scene) = packed.scene.as_ref().filter(|_| overlay.shown) else {
            *self = Self::default();
            return;
        };
        let is_same = self
            .from
            .as_ref()
            .is_some_and(|(geometry, from)| Arc::ptr_eq(geometry, &scene.geometry) && from == overlay);
        if !is_same {
            self.list = overlay::boxes(&scene.geometry, overlay);
            self.from = Some((scene.geometry.clone(), *overlay));
        }
    }
}

/// World bounds of the selected things as they were last found.
#[derive(Default)]
struct SelectionBounds {
    of: Option<(Selection, Arc<Tlas>)>,
    bounds: Vec<Option<Aabb>>,
}

impl SelectionBounds {
    fn update(&mut self, packed: &PackedScene, selection: &Selection) {
        let Some(scene) = &packed.scene else {
            *self = Self::default();
            return;
        };
        let is_same = |(of, geometry): &(Selection, _)| of == selection && Arc::ptr_eq(geometry, &scene.geometry);
        if !self.of.as_ref().is_some_and(is_same) {
            self.bounds = picking::bounds_of_each(packed, selection.entities());
            self.of = Some((selection.clone(), scene.geometry.clone()));
        }
    }
}

/// The unselected things that move with selected groups, as of the last search.
#[derive(Default)]
struct UnselectedMembers {
    of: Option<Selection>,
    members: Vec<Entity>,
}

impl UnselectedMembers {
    fn update(&mut self, sources: &mut Sources) {
        let is_renamed = sources.unnamed.read().count() > 0 || !sources.newly_named.is_empty();
        if is_renamed || self.of.as_ref() != Some(&*sources.selection) {
            self.members = sources.unselected_members();
            self.of = Some(sources.selection.clone());
        }
    }
}

type Emitters = (Entity, &'static Emitter, &'static ToWorld, Option<&'static Properties>);

/// The parts of the world that the viewport shows.
#[derive(SystemParam)]
pub struct Sources<'w, 's> {
    packed: Res<'w, PackedScene>,
    selection: Res<'w, Selection>,
    status: Res<'w, SceneStatus>,
    preferences: Res<'w, Preferences>,
    active: Res<'w, ActiveSensor>,
    free_view: Res<'w, FreeView>,
    poses: Query<'w, 's, &'static ToWorld>,
    picture: Res<'w, Picture>,
    film: Res<'w, RenderFilm>,
    movable: Query<'w, 's, Movable, (Without<Locked>, Without<Placements>, Without<MemberOf>)>,
    named: Query<'w, 's, (Entity, &'static Name), With<ToWorld>>,
    newly_named: Query<'w, 's, (), Or<(Changed<Name>, Changed<Shape>)>>,
    unnamed: RemovedComponents<'w, 's, Name>,
    emitters: Query<'w, 's, Emitters, Without<Hidden>>,
    scene_properties: Option<Res<'w, SceneProperties>>,
    shining: Query<'w, 's, (&'static Shape, &'static ToWorld), (With<AreaLight>, Without<Hidden>, Without<Placements>)>,
    sensors: Query<'w, 's, (Entity, &'static ToWorld), With<Sensor>>,
    films: Query<'w, 's, &'static Film>,
    shapes: Query<'w, 's, (&'static Shape, &'static ToWorld), (Without<Placements>, Without<MemberOf>)>,
    locked: Query<'w, 's, Entity, With<Locked>>,
    newly_locked: Query<'w, 's, (), Added<Locked>>,
    unlocked: RemovedComponents<'w, 's, Locked>,
    stand_ins: StandIns<'w, 's>,
    lacking: Query<'w, 's, Option<&'static Name>, (Without<Hidden>, Without<Placements>)>,
}

type Movable = (
    &'static ToWorld,
    Option<&'static Shape>,
    Option<&'static Emitter>,
    Has<Sensor>,
);

impl Sources<'_, '_> {
    fn targets(&self, bounds: &[Option<Aabb>], members: &[Entity], stand_ins: &[StandIn]) -> Vec<Target> {
        let selected = self.selection.entities();
        let selected = selected.iter().copied().zip(bounds.iter().chain(iter::repeat(&None)));
        let members = members.iter().map(|member| (*member, &None));
        let targets = members.chain(selected).filter_map(|(entity, &bounds)| {
            let (to_world, shape, emitter, is_sensor) = self.movable.get(entity).ok()?;
            let freedom = match emitter {
                _ if shape.is_some() => Freedom::Affine,
                Some(emitter) if !emitter.shines() => Freedom::Affine,
                Some(emitter) if emitter.is_environment() => Freedom::Turning,
                Some(emitter) if matches!(emitter.kind, EmitterKind::Constant { .. }) => return None,
                Some(_) => Freedom::Rigid,
                None if is_sensor => Freedom::Rigid,
                None => return None,
            };
            Some(Target {
                entity,
                to_world: to_world.0 * Affine3A::from_translation(shape.map_or(Vec3::ZERO, Shape::middle)),
                freedom,
                // Hidden things are not in the picture.
                bounds: bounds
                    .or_else(|| world_bounds(shape?, &to_world.0, None))
                    .or_else(|| Some(stand_ins.iter().find(|it| it.icon.entity == entity)?.bounds)),
            })
        });
        targets.collect()
    }

    /// The unselected things that move with selected groups.
    fn unselected_members(&self) -> Vec<Entity> {
        let frames = self.selection.entities().iter().filter(|entity| {
            let shape = self.movable.get(**entity).ok().and_then(|(_, shape, ..)| shape);
            shape.is_some_and(Shape::is_frame)
        });
        let names: Vec<&str> = frames
            .filter_map(|frame| self.named.get(*frame).ok())
            .map(|(_, name)| name.as_str())
            .collect();
        let mut found: Vec<Entity> = Vec::new();
        if !names.is_empty() {
            let members = self
                .named
                .iter()
                .filter(|(_, name)| names.iter().any(|frame| name.starts_with(frame)));
            found.extend(
                members
                    .map(|(member, _)| member)
                    .filter(|member| !self.selection.contains(*member)),
            );
        }
        found
    }

    /// The boxes of these shapes, as far as they are visible; for members of a group, one for each instance.
    fn boxes_of(&self, lacking: &[Entity]) -> Vec<StandIn> {
        let seen = lacking.iter().filter_map(|&entity| {
            let name = self.lacking.get(entity).ok()?.map_or("mesh", Name::as_str);
            Some((entity, name, self.stand_ins.bounds(entity)?))
        });
        let boxes = seen.flat_map(|(entity, name, local)| {
            let places = self.stand_ins.places(entity).into_iter();
            places.map(move |(shown, to_world)| StandIn::new(shown, name.to_owned(), &local, &to_world))
        });
        boxes.collect()
    }

    fn block(&self, entity: Entity) -> Option<BlockTarget> {
        let (shape, to_world) = self.shapes.get(entity).ok()?;
        Some(BlockTarget {
            entity,
            shape: shape.clone(),
            pose: to_world.0,
        })
    }

    /// The icons of lights with a place, of all cameras except the one in use, and of selected flat shapes that shine.
    fn icons(&self) -> Vec<Icon> {
        let plain = self.emitters.iter().filter(|(_, emitter, ..)| !emitter.is_marker());
        let lights = plain.filter_map(|(entity, emitter, to_world, _)| {
            Some(Icon {
                entity,
                kind: IconKind::of(emitter)?,
                pose: to_world.0,
                tint: None,
            })
        });
        let looked_through = self.active.0.filter(|_| self.free_view.pose.is_none());
        let others = self
            .sensors
            .iter()
            .filter(|(entity, _)| Some(*entity) != looked_through);
        let cameras = others.map(|(entity, to_world)| Icon {
            entity,
            kind: IconKind::Frustum,
            pose: to_world.0,
            tint: None,
        });
        // Others show their size and their direction by what they light.
        let sheets = self.selection.entities().iter().filter_map(|&entity| {
            let (shape, to_world) = self.shining.get(entity).ok()?;
            Some(Icon {
                entity,
                kind: IconKind::of_shape(shape)?,
                pose: to_world.0,
                tint: None,
            })
        });
        lights.chain(cameras).chain(sheets).collect()
    }

    /// Adds the icons of markers, for a path one at each of its points, and returns the lines of paths.
    fn markers(&self, icons: &mut Vec<Icon>) -> Vec<MarkerPath> {
        let none = Properties::default();
        let scene = self.scene_properties.as_ref().map_or(&none, |own| &own.0);
        let mut paths = Vec::new();
        for (entity, emitter, to_world, properties) in self.emitters.iter().filter(|(_, it, ..)| it.is_marker()) {
            let Some(kind) = IconKind::of(emitter) else { continue };
            let look = MarkerLook::of(&marker::type_of(properties), scene);
            let [r, g, b] = look.color.to_array();
            let tint = egui::Color32::from(egui::Rgba::from_rgb(r, g, b));
            let icon = |pose| Icon {
                entity,
                kind: kind.with_symbol(look.symbol),
                pose,
                tint: Some(tint),
            };
            if emitter.kind != EmitterKind::MarkerPath {
                icons.push(icon(to_world.0));
                continue;
            }
            let place = |point: Vec3| to_world.0.transform_point3(point);
            let points = marker::points_of(properties);
            icons.extend(
                points
                    .iter()
                    .map(|&point| icon(Affine3A::from_translation(place(point)))),
            );
            let line = marker::line_of(properties).into_iter().map(place).collect();
            paths.push(MarkerPath {
                entity,
                points,
                pose: to_world.0,
                line,
                tint,
            });
        }
        paths
    }
}

/// Gathers the data of the viewport. It must run after the panels' model has been gathered.
pub(crate) fn gather_viewport(
    mut seen: ResMut<ViewportScene>,
    mut sources: Sources,
    settings: Res<ViewSettings>,
    outlines: Res<OutlinePass>,
    state: Res<ViewportState>,
    mut model: ResMut<EditorModel>,
) {
    let seen = &mut *seen;
    if sources.unlocked.read().count() > 0 || !sources.newly_locked.is_empty() {
        seen.locked = sources.locked.iter().collect();
    }
    seen.members.update(&mut sources);
    let (packed, selection) = (&sources.packed, &sources.selection);
    seen.boxes.update(packed, &settings.overlay);
    seen.bounds.update(packed, selection);
    seen.outline = outlines.outline().clone();
    let wireframe = settings.seeing.wireframe;
    seen.wireframe.update(packed, selection, wireframe);
    if sources.stand_ins.may_differ() || !sources.newly_named.is_empty() {
        seen.lacking = sources.stand_ins.shapes();
    }
    seen.stand_ins = sources.boxes_of(&seen.lacking);
    seen.targets = sources.targets(&seen.bounds.bounds, &seen.members.members, &seen.stand_ins);
    let extents = seen.targets.iter().filter_map(|target| target.bounds);
    model.0.extent = extents.reduce(Aabb::union);
    let selected = seen.targets.iter().filter(|target| selection.contains(target.entity));
    model.0.sizes = Sizes::of(selected.map(|target| target.bounds));
    seen.icons = sources.icons();
    seen.paths = sources.markers(&mut seen.icons);
    seen.icons.extend(seen.stand_ins.iter().map(|stand_in| stand_in.icon));
    let near = state.blocking.near.iter();
    seen.blocks = near.filter_map(|entity| sources.block(*entity)).collect();
    let inspected = model.0.inspected.as_ref();
    seen.textures = inspected
        .filter(|_| settings.tool == Tool::PlaceTexture)
        .and_then(texture_target);
    let media = inspected.map_or(&[][..], |inspected| &inspected.media);
    seen.volume_boxes = media.iter().flat_map(|entry| entry.boxes.iter().copied()).collect();
    seen.lamp_solid = inspected.and_then(|inspected| {
        Some(LampSolid {
            pose: inspected.to_world?,
            curves: inspected.light_figures.curves.clone()?,
        })
    });
    seen.placeholder = placeholder(&sources.status, model.0.status.paused, &sources.preferences.keys);
    seen.legend = legend(settings.display.mode, sources.picture.scales());
    let is_denoised = matches!(model.0.status.denoiser, DenoiserState::Shown { .. });
    seen.compared = match sources.picture.compared() {
        CompareView::Noisy(_) if !is_denoised => CompareView::Off,
        view => view,
    };
    let is_split = model.0.render.strategy_split && settings.display.mode.is_light();
    let is_of_other_scene = model.0.render.comparison.is_of_other_scene;
    seen.captions = captions(is_split, seen.compared, is_of_other_scene);
    // The film is cleared before the texture when another scene is opened.
    seen.picture = sources.picture.texture().filter(|_| !sources.film.is_empty());
    seen.film_in_picture = sources.picture.film_corners();
    seen.is_through_camera = *sources.free_view == FreeView::default();
    // The film stays where it is, whatever resolution is rendered.
    let film = sources.active.0.and_then(|sensor| sources.films.get(sensor).ok());
    let proportions = film.map(Film::window).map(|window| [window.width, window.height]);
    let of_picture = seen.picture.map(|(_, size)| size);
    seen.proportions = proportions.or(of_picture).unwrap_or([1, 1]);
    seen.pose = camera_pose(&sources.active, &sources.free_view, &sources.poses);
}

fn texture_target(inspected: &Inspected) -> Option<TextureTarget> {
    let shape = inspected.shape.as_ref().filter(|shape| !shape.is_frame())?;
    let materials = inspected.materials.iter().map(|entry| &*entry.material);
    Some(TextureTarget {
        entity: inspected.entity,
        groups: texture_groups(materials),
        upright: upright(shape.shows_pictures_upside_down()),
    })
}

fn placeholder(status: &SceneStatus, paused: bool, bound: &KeyBindings) -> String {
    let file = status.subject().map_or(String::new(), |path| {
        path.file_name().unwrap_or_default().to_string_lossy().into_owned()
    });
    match status.state {
        SceneState::Empty => hint("Open a scene with File, Open", "open", bound),
        SceneState::Loading => format!("Loading {file}"),
        // A paused scene would be "prepared" for ever.
        SceneState::Ready if paused => "Paused".to_owned(),
        SceneState::Ready if file.is_empty() => "Preparing the scene".to_owned(),
        SceneState::Ready => format!("Preparing {file}"),
        SceneState::Failed => format!("{file} could not be read; see Messages at the right"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::editor::command::key_bindings::NO_BINDINGS;

    #[test]
    fn nothing_is_prepared_while_paused() {
        let mut status = SceneStatus {
            path: Some("/rooms/flat.xml".into()),
            state: SceneState::Ready,
            ..SceneStatus::default()
        };
        let text = |status: &SceneStatus, paused| placeholder(status, paused, &NO_BINDINGS);
        assert_eq!(text(&status, false), "Preparing flat.xml");
        assert_eq!(text(&status, true), "Paused");
        status.state = SceneState::Loading;
        assert_eq!(text(&status, true), "Loading flat.xml");
    }
}
