//! Turns a document into a [`SceneDescription`]: it knows which plugins and parameters exist, their defaults and their
//! ranges.
//!
//! No ECS and no rendering; of the disk only whether files exist. Defaults are those of Mitsuba 3.6 to 3.9. An
//! unsupported feature gets a stand-in and a warning with its place; invalid content is an error, and the description
//! is then only good for finding more errors. Reading never stops early.

mod bsdfs;
mod emitters;
mod field_of_view;
mod from_file;
mod groups;
mod integrator;
pub mod ior_names;
mod media;
pub mod mesh_search;
mod parameters;
mod picture_search;
mod reader_parameters;
pub(super) mod recognition;
mod scene_reader;
mod sensors;
mod shapes;
pub mod spectra;
mod textures;

use std::collections::HashSet;
use std::sync::Arc;

use smol_str::SmolStr;

pub(super) use self::field_of_view::millimetres;
use self::scene_reader::{Place, SceneReader};
pub use crate::document::paths::settle;
use crate::document::{Category, Child, Diagnostics, Document, LIGHT_UNITS, Object, Reader, Severity, UNIT};
use crate::scene::components::description::{DeclarationPlace, SceneDescription};
use crate::scene::components::keys::{MOST_TRACKS, is_part, track_count};
use crate::scene::components::marker::FORM;
use crate::scene::components::missing;
use crate::scene::encode::FRAME;
use crate::scene::{AuthoredScene, LengthUnit, LightUnits, Properties, SceneProperties};

/// Reads the whole document; problems are added to its diagnostics.
pub fn read(document: &mut Document) -> SceneDescription {
    let mut origin = document.clone();
    origin.diagnostics = Diagnostics::default();
    origin.diagnostics.sources.clone_from(&document.diagnostics.sources);
    let mut description = read_as(document, true);
    description.remains.foreign_ids = Arc::new(foreign_ids(&description, &origin.root));
    description.remains.origin = Some(Arc::new(origin));
    description
}

/// The ids below `root` that belong to no thing of the scene.
fn foreign_ids(scene: &SceneDescription, root: &Object) -> HashSet<SmolStr> {
    fn collect(object: &Object, ids: &mut HashSet<SmolStr>) {
        ids.extend(object.id.clone());
        object.objects().for_each(|inner| collect(inner, ids));
    }
    let mut ids = HashSet::new();
    collect(root, &mut ids);
    let things = (scene.sensors.iter().map(|it| &it.identity))
        .chain(scene.media.iter().map(|it| &it.identity))
        .chain(scene.materials.iter().map(|it| &it.identity))
        .chain(scene.groups.iter().map(|it| &it.identity))
        .chain(scene.shapes.iter().map(|it| &it.identity))
        .chain(scene.emitters.iter().map(|it| &it.identity));
    for authored in things.filter_map(|identity| identity.authored.as_ref()) {
        if let Some(id) = &authored.object.id {
            ids.remove(id);
        }
    }
    ids
}

/// [`read`] for a scene that is not saved again: of the source it keeps only the spans of file names.
pub(crate) fn read_meaning(document: &mut Document) -> SceneDescription {
    read_as(document, false)
}

fn read_as(document: &mut Document, keeps_source: bool) -> SceneDescription {
    let diagnostics = std::mem::take(&mut document.diagnostics);
    let mut scene = SceneReader::new(document, diagnostics, keeps_source);
    scene.read_root();
    let SceneReader {
        mut description,
        mut diagnostics,
        pictures,
        ..
    } = scene;
    description.picture_places = pictures.places;
    description.volume_places = pictures.volume_places;
    description.missing = pictures.missing;
    if diagnostics.has_errors() {
        missing::report(&description.missing, &mut diagnostics);
    }
    sort_materials(&mut description);
    sort_media(&mut description);
    document.diagnostics = diagnostics;
    description
}

impl SceneReader<'_> {
    fn read_root(&mut self) {
        let root = self.root;
        let mut remains = AuthoredScene {
            search_folders: self.search_folders.to_vec(),
            properties: root.properties.clone(),
            ..Default::default()
        };
        self.list_groups();
        let mut last_order = 0;
        for (position, child) in root.children.iter().enumerate() {
            last_order = self.read_crowds(position).unwrap_or(last_order);
            let Child::Object(object) = child else {
                remains.rest.push((last_order, child.clone()));
                continue;
            };
            last_order = self.order(object);
            let taken = match object.category {
                Category::Integrator => self.read_integrator(object, &mut remains),
                Category::Sensor => self.read_sensor(object),
                Category::Bsdf => {
                    self.read_bsdf(object, DeclarationPlace::TopLevel, 0);
                    true
                }
                Category::Medium => self.read_medium(object, DeclarationPlace::TopLevel).is_some(),
                Category::Shape => self.read_shape(object, None),
                Category::Emitter => self.read_emitter(object),
                Category::Volume if is_marker(object) => self.read_emitter(object),
                Category::Volume if is_frame(object) => self.read_shape(object, None),
                // Others are read with the references to them, and reported there.
                _ => false,
            };
            if !taken {
                remains.rest.push((last_order, child.clone()));
            }
        }
        self.read_crowds(usize::MAX);
        self.report_media_without_effect(&remains);
        self.report_skies();
        self.report_tracks();
        self.description.remains = remains;

        let properties = Properties::of(root, &mut self.diagnostics);
        self.description.properties = SceneProperties(properties.unwrap_or_default());
        let mut reader = Reader::new(&self.index, root, &mut self.diagnostics);
        for category in Category::ALL {
            reader.children(category);
        }
        self.description.unit = reader.string(UNIT).and_then(LengthUnit::of_name).unwrap_or_default();
        let light_units = reader.string(LIGHT_UNITS).and_then(LightUnits::of_name);
        self.description.light_units = light_units.unwrap_or_default();
        reader.finish();
        // After an error the scene is not shown, and the unreadable part may be its sensor.
        if self.description.sensors.is_empty() && !self.diagnostics.has_errors() {
            let message = "the scene has no sensor: one that sees everything takes its place".to_owned();
            self.diagnostics.push(Severity::Warning, Some(root.span), message, None);
        }
    }
}

impl SceneReader<'_> {
    /// Warns of every light around the scene but the first.
    fn report_skies(&mut self) {
        let further = self.description.skies().skip(1);
        let further: Vec<_> = further.map(|sky| (sky.identity.span, sky.emitter.plugin())).collect();
        for (span, plugin) in further {
            let message = format!(
                "emitter `{plugin}` is another light around the scene: here they add up, but Mitsuba refuses more than one"
            );
            self.diagnostics.warn(span, message);
        }
    }
}

impl SceneReader<'_> {
    /// Reports things with too many animated values.
    fn report_tracks(&mut self) {
        if self.animated.is_empty() {
            return;
        }
        let things = self
            .places
            .values()
            .filter(|place| place.top_level || !is_part(place.object));
        let mut many: Vec<&Place> = things.filter(|place| track_count(place.object) > MOST_TRACKS).collect();
        many.sort_unstable_by_key(|place| place.order);
        for place in many {
            let title = place.object.title();
            let message = format!("more than {MOST_TRACKS} values of {title} have keys: the others do not move");
            self.diagnostics.error(place.object.span, message);
        }
    }
}

/// Whether it is the transform of a folder. Mitsuba reads such a volume and ignores it, because nothing refers to it.
pub(crate) fn is_frame(object: &Object) -> bool {
    let id = object.id.as_deref().unwrap_or_default();
    let is_folder = object.category == Category::Volume && object.plugin == FRAME && !is_marker(object);
    is_folder && id.len() > 1 && id.ends_with('/')
}

/// Whether it is a marker, which Mitsuba reads and ignores as it does the transform of a folder.
fn is_marker(object: &Object) -> bool {
    object.category == Category::Volume && object.properties.iter().any(|property| property.name == FORM)
}

/// The sorted order of a list: the old index for each new one, and the new index for each old one.
fn by_order<T, Order: Ord>(list: &[T], order: impl Fn(&T) -> Order) -> (Vec<usize>, Vec<usize>) {
    let mut old_place: Vec<usize> = (0..list.len()).collect();
    old_place.sort_by_key(|&old| order(&list[old]));
    let mut new_place = vec![0; list.len()];
    for (new, &old) in old_place.iter().enumerate() {
        new_place[old] = new;
    }
    (old_place, new_place)
}

/// Sorts the media, which are found in the order of references, into the order of the file.
fn sort_media(description: &mut SceneDescription) {
    let media = &mut description.media;
    let (_, new_place) = by_order(media, |medium| medium.identity.order);
    media.sort_by_key(|medium| medium.identity.order);
    let moved = |medium: &mut Option<usize>| *medium = medium.map(|old| new_place[old]);
    for shape in &mut description.shapes {
        moved(&mut shape.interior);
        moved(&mut shape.exterior);
    }
    let of_sensors = description.sensors.iter_mut().map(|sensor| &mut sensor.medium);
    let of_emitters = description.emitters.iter_mut().map(|emitter| &mut emitter.medium);
    of_sensors.chain(of_emitters).for_each(moved);
}

/// Sorts the materials, which are found in the order of references, into the order of the file.
fn sort_materials(description: &mut SceneDescription) {
    let materials = std::mem::take(&mut description.materials);
    let (old_place, new_place) = by_order(&materials, |material| material.identity.order);
    let mut slots: Vec<_> = materials.into_iter().map(Some).collect();
    for old in old_place {
        if let Some(mut material) = slots[old].take() {
            material.first = material.first.map(|old| new_place[old]);
            material.second = material.second.map(|old| new_place[old]);
            if let DeclarationPlace::Material(old) = material.declared_in {
                material.declared_in = DeclarationPlace::Material(new_place[old]);
            }
            description.materials.push(material);
        }
    }
    for shape in &mut description.shapes {
        shape.material = shape.material.map(|old| new_place[old]);
    }
}
