//! Makes the document of a scene from its description.

use std::collections::HashSet;
use std::path::Path;

use glam::Affine3;
use smol_str::SmolStr;

use super::defaults::Defaults;
use super::patch::Draft;
use crate::document::animation::is_animated;
use crate::document::{Category, Child, Crowd, LIGHT_UNITS, Object, Property, Span, UNIT, Value};
use crate::scene::components::description::{DeclarationPlace, Identity, SceneDescription, ShapeDescription};
use crate::scene::components::medium::{EXTERIOR, INTERIOR};
use crate::scene::encode::{lights, objects, with_properties};
use crate::scene::{Authored, IntegratorSettings, Keys, LightUnits, Properties, SceneProperties};

/// The deepest nesting of materials, more than reading allows; deeper ones are written at the top level instead.
const DEEPEST: usize = 40;

pub(in crate::scene) struct Writer<'s> {
    scene: &'s SceneDescription,
    folder: &'s Path,
    /// The id of each material in the file, if it has one or is referred to.
    ids: Vec<Option<String>>,
    /// The place of each material's declaration; None for unused ones.
    places: Vec<Option<DeclarationPlace>>,
    /// The id of each medium, and below the place of its declaration, as for materials.
    medium_ids: Vec<Option<String>>,
    medium_places: Vec<Option<DeclarationPlace>>,
    defaults: Defaults,
    /// Whether animated values are written with their keys.
    keys: bool,
}

impl<'s> Writer<'s> {
    pub(in crate::scene) fn new(scene: &'s SceneDescription, folder: &'s Path) -> Self {
        let count = scene.materials.len();
        let mut writer = Self {
            scene,
            folder,
            ids: scene
                .materials
                .iter()
                .map(|material| material.identity.id.clone())
                .collect(),
            places: vec![None; count],
            medium_ids: scene.media.iter().map(|medium| medium.identity.id.clone()).collect(),
            medium_places: vec![None; scene.media.len()],
            defaults: Defaults::default(),
            keys: true,
        };
        // The uses of materials in the order in which they are written.
        let mut uses: Vec<(DeclarationPlace, usize)> = Vec::new();
        for (owner, shape) in scene.shapes.iter().enumerate() {
            uses.extend(
                shape
                    .material
                    .map(|material| (DeclarationPlace::Shape(owner), material)),
            );
        }
        let is_written = written_materials(scene);
        for (owner, material) in scene.materials.iter().enumerate() {
            let nested = material.first.into_iter().chain(material.second);
            let nested = nested.filter(|_| is_written[owner]);
            uses.extend(nested.map(|inner| (DeclarationPlace::Material(owner), inner)));
        }
        let mut is_used = vec![false; count];
        for &(owner, material) in &uses {
            is_used[material] = true;
            if scene.materials[material].declared_in == owner && writer.depth(material) < DEEPEST {
                writer.places[material] = Some(owner);
            }
        }
        for (index, material) in scene.materials.iter().enumerate() {
            let was_top_level = material.declared_in == DeclarationPlace::TopLevel;
            if writer.places[index].is_none() && (was_top_level || is_used[index] || material.identity.id.is_some()) {
                writer.places[index] = Some(DeclarationPlace::TopLevel);
            }
        }
        let media = writer.place_media();
        let mut taken = writer.taken_ids();
        name_what_is_referred_to(&uses, &writer.places, &mut writer.ids, "material", &mut taken);
        name_what_is_referred_to(
            &media,
            &writer.medium_places,
            &mut writer.medium_ids,
            "medium",
            &mut taken,
        );
        writer
    }

    /// Decides on the declaration of each medium. Returns the uses in the order in which they are written.
    fn place_media(&mut self) -> Vec<(DeclarationPlace, usize)> {
        let scene = self.scene;
        let mut uses: Vec<(DeclarationPlace, usize)> = Vec::new();
        for (owner, sensor) in scene.sensors.iter().enumerate() {
            uses.extend(sensor.medium.map(|medium| (DeclarationPlace::Sensor(owner), medium)));
        }
        for (owner, shape) in scene.shapes.iter().enumerate() {
            let media = shape.interior.into_iter().chain(shape.exterior);
            uses.extend(media.map(|medium| (DeclarationPlace::Shape(owner), medium)));
        }
        for (owner, emitter) in scene.emitters.iter().enumerate() {
            uses.extend(emitter.medium.map(|medium| (DeclarationPlace::Emitter(owner), medium)));
        }
        for &(owner, medium) in &uses {
            if scene.media[medium].declared_in == owner {
                self.medium_places[medium] = Some(owner);
            } else {
                self.medium_places[medium].get_or_insert(DeclarationPlace::TopLevel);
            }
        }
        for (place, medium) in self.medium_places.iter_mut().zip(&scene.media) {
            if medium.declared_in == DeclarationPlace::TopLevel || medium.identity.id.is_some() {
                place.get_or_insert(DeclarationPlace::TopLevel);
            }
        }
        uses
    }

    /// Writes the present values of the components, and no keys.
    pub(in crate::scene) fn without_keys(self) -> Self {
        Self { keys: false, ..self }
    }

    /// The number of materials around this one.
    fn depth(&self, mut material: usize) -> usize {
        let mut depth = 0;
        while let DeclarationPlace::Material(owner) = self.scene.materials[material].declared_in
            && depth < DEEPEST
        {
            material = owner;
            depth += 1;
        }
        depth
    }

    /// All ids of the file.
    fn taken_ids(&self) -> HashSet<String> {
        let mut taken: HashSet<String> = HashSet::new();
        for identity in identities(self.scene) {
            taken.extend(identity.id.clone());
        }
        for (_, child) in &self.scene.remains.rest {
            collect_ids(child, &mut taken);
        }
        taken
    }

    pub(in crate::scene) fn root(&self) -> Object {
        let scene = self.scene;
        let mut parts: Vec<(u32, Child)> = Vec::new();
        if let Some((order, child)) = self.integrator() {
            parts.push((order, child.into()));
        }
        for (index, medium) in scene.media.iter().enumerate() {
            if self.medium_places[index] == Some(DeclarationPlace::TopLevel) {
                let mut object = self.medium(index);
                if medium.declared_in != DeclarationPlace::TopLevel {
                    object.name = None;
                }
                parts.push((medium.identity.order, object.into()));
            }
        }
        for (index, sensor) in scene.sensors.iter().enumerate() {
            let current = objects::sensor(&sensor.sensor, &sensor.film, &sensor.to_world);
            let mut draft = self.with_keys(plain_draft(&sensor.identity, current), sensor.identity.keys.as_ref());
            draft.set_medium(
                None,
                self.medium_in(DeclarationPlace::Sensor(index), sensor.medium, &mut None),
            );
            parts.push(finish(&sensor.identity, draft));
        }
        for (index, material) in scene.materials.iter().enumerate() {
            if self.places[index] == Some(DeclarationPlace::TopLevel) {
                parts.push((material.identity.order, self.material(index).into()));
            }
        }
        for (index, group) in scene.groups.iter().enumerate() {
            parts.push((group.identity.order, self.group(index).into()));
        }
        let origin = scene.remains.origin.as_ref();
        let mut unwritten: Vec<&Crowd> = origin.map_or(Vec::new(), |origin| origin.crowds.iter().collect());
        for (index, shape) in scene.shapes.iter().enumerate() {
            if let Some(placements) = &shape.placements {
                let instances = self.crowd(shape, &placements.places, &mut unwritten);
                parts.extend(instances.into_iter().map(|instance| (shape.identity.order, instance)));
            } else if shape.member_of.is_none() {
                parts.push((shape.identity.order, self.shape(index).into()));
            }
        }
        for (index, emitter) in scene.emitters.iter().enumerate() {
            let current = lights::emitter(
                &emitter.emitter,
                &emitter.to_world,
                emitter.identity.angles,
                self.folder,
            );
            let mut draft = self.draft(&emitter.identity, current);
            draft.set_medium(
                None,
                self.medium_in(DeclarationPlace::Emitter(index), emitter.medium, &mut None),
            );
            parts.push(finish(&emitter.identity, draft));
        }
        parts.extend(scene.remains.rest.iter().cloned());
        // The sort is stable: things without an order stay after their predecessors.
        parts.sort_by_key(|(order, _)| *order);
        let mut root = Object::new(Category::Scene, "");
        root.properties.clone_from(&scene.remains.properties);
        let origin = scene.remains.origin.as_ref();
        let usual_light_units = LightUnits::default().name();
        for (name, value, usual) in [
            (UNIT, scene.unit.name(), ""),
            (LIGHT_UNITS, scene.light_units.name(), usual_light_units),
        ] {
            let is_taken = origin.is_some_and(|origin| origin.taken_unit_names.contains(&name));
            write_unit(name, [value, usual], is_taken, &mut root.properties);
        }
        write_properties(&scene.properties, &mut root.properties);
        root.children = parts.into_iter().map(|(_, child)| child).collect();
        root
    }

    /// The instances of a crowd as in the file, or new elements if it is no `unwritten` crowd of the file.
    fn crowd(&self, shape: &ShapeDescription, places: &[Affine3], unwritten: &mut Vec<&Crowd>) -> Vec<Child> {
        let Some(group) = shape.instance_of else {
            return Vec::new();
        };
        let id = self.scene.groups[group].identity.id.as_deref();
        let is_this = |crowd: &&Crowd| id == Some(crowd.group.as_str()) && places == crowd.places.as_slice();
        if let Some(index) = unwritten.iter().position(is_this)
            && let Some(origin) = &self.scene.remains.origin
        {
            return unwritten.remove(index).children(&origin.diagnostics);
        }
        let instance = |&place: &Affine3| {
            let current = objects::shape(&shape.shape, &place.into(), None, None, self.folder);
            let group = id.map(reference).into_iter().collect();
            Draft::new(None, current).set_nested(Category::Shape, group).into()
        };
        places.iter().map(instance).collect()
    }

    fn shape(&self, index: usize) -> Object {
        let shape = &self.scene.shapes[index];
        let current = objects::shape(
            &shape.shape,
            &shape.to_world,
            shape.identity.angles,
            shape.area_light.as_ref(),
            self.folder,
        );
        let mut draft = self.draft(&shape.identity, current);
        let (place, mut declared) = (DeclarationPlace::Shape(index), None);
        draft.set_medium(Some(INTERIOR), self.medium_in(place, shape.interior, &mut declared));
        draft.set_medium(Some(EXTERIOR), self.medium_in(place, shape.exterior, &mut declared));
        let mut object = match shape.instance_of {
            None if shape.shape.is_frame() => draft.object,
            Some(group) => {
                let id = self.scene.groups[group].identity.id.as_deref();
                draft.set_nested(Category::Shape, id.map(reference).into_iter().collect())
            }
            None => {
                let bsdf = self.nested(DeclarationPlace::Shape(index), &[shape.material]);
                draft.set_nested(Category::Bsdf, bsdf)
            }
        };
        object.id = id_of(&shape.identity);
        object
    }

    fn group(&self, index: usize) -> Object {
        let group = &self.scene.groups[index].identity;
        let current = Object::new(Category::Shape, "shapegroup");
        let draft = plain_draft(group, current);
        let members = (0..)
            .zip(&self.scene.shapes)
            .filter(|(_, shape)| shape.member_of == Some(index));
        let members: Vec<Child> = members.map(|(member, _)| self.shape(member).into()).collect();
        let mut object = draft.set_nested(Category::Shape, members);
        object.id = id_of(group);
        object
    }

    fn integrator(&self) -> Option<(u32, Object)> {
        let settings = &self.scene.integrator;
        let current = objects::integrator(settings);
        let keys = Some(&self.scene.integrator_keys).filter(|keys| !keys.is_empty());
        let (order, draft) = match &self.scene.remains.integrator {
            Some((order, authored)) => (*order, Draft::of_integrator(authored, current)),
            None if keys.is_none() && current == objects::integrator(&IntegratorSettings::default()) => return None,
            None => (0, Draft::new(None, self.defaults.left_out_inside(current))),
        };
        Some((order, self.with_keys(draft, keys).object))
    }

    /// The object to write. For new things, parameters that equal the default are left out.
    fn draft(&self, identity: &Identity, current: Object) -> Draft {
        let current = match identity.authored {
            Some(_) => current,
            None => self.defaults.left_out(current),
        };
        let draft = plain_draft(identity, current);
        self.with_keys(draft, identity.keys.as_ref())
    }

    fn with_keys(&self, mut draft: Draft, keys: Option<&Keys>) -> Draft {
        let keys = keys.filter(|_| self.keys);
        if keys.is_some() || is_animated(&draft.object) {
            Keys::attach(keys, &mut draft.object, self.scene.time);
        }
        draft
    }

    fn material(&self, index: usize) -> Object {
        let material = &self.scene.materials[index];
        let authored: Option<&Authored> = material.identity.authored.as_ref();
        let draft = self.draft(&material.identity, objects::material(&material.material, self.folder));
        // The plugin behind a stand-in may have nested bsdfs that were never read; they stay.
        let is_stand_in = authored.is_some_and(|authored| authored.is_stand_in());
        let nested = self.nested(DeclarationPlace::Material(index), &[material.first, material.second]);
        let mut object = if is_stand_in && nested.is_empty() {
            draft.object
        } else {
            draft.set_nested(Category::Bsdf, nested)
        };
        object.id = self.ids[index].as_deref().map(SmolStr::from);
        object
    }

    fn medium(&self, index: usize) -> Object {
        let medium = &self.scene.media[index];
        let draft = self.draft(&medium.identity, objects::medium(&medium.medium, self.folder));
        Object {
            id: self.medium_ids[index].as_deref().map(SmolStr::from),
            ..draft.object
        }
    }

    /// The medium of `owner`: in place if it is declared there, otherwise as a reference. `declared` is the one already
    /// declared there.
    fn medium_in(&self, owner: DeclarationPlace, medium: Option<usize>, declared: &mut Option<usize>) -> Option<Child> {
        let medium = medium?;
        if self.medium_places[medium] == Some(owner) && *declared != Some(medium) {
            *declared = Some(medium);
            return Some(self.medium(medium).into());
        }
        self.medium_ids[medium].as_deref().map(reference)
    }

    /// The materials of `owner`: in place if they are declared there, otherwise as references.
    fn nested(&self, owner: DeclarationPlace, materials: &[Option<usize>]) -> Vec<Child> {
        let mut declared = Vec::new();
        let mut children = Vec::new();
        for &material in materials.iter().flatten() {
            if self.places[material] == Some(owner) && !declared.contains(&material) {
                declared.push(material);
                children.push(self.material(material).into());
            } else if let Some(id) = &self.ids[material] {
                children.push(reference(id));
            }
        }
        children
    }
}

/// For each material whether it is written: used by a shape, declared at the top level, with an id, or inside such a
/// one. A material that others use is written even if the one around it is not.
fn written_materials(scene: &SceneDescription) -> Vec<bool> {
    let is_kept = |index: &usize| {
        let material = &scene.materials[*index];
        material.declared_in == DeclarationPlace::TopLevel || material.identity.id.is_some()
    };
    let mut waiting: Vec<usize> = (0..scene.materials.len()).filter(is_kept).collect();
    waiting.extend(scene.shapes.iter().filter_map(|shape| shape.material));
    let mut is_written = vec![false; scene.materials.len()];
    while let Some(index) = waiting.pop() {
        if !std::mem::replace(&mut is_written[index], true) {
            let material = &scene.materials[index];
            waiting.extend(material.first.into_iter().chain(material.second));
        }
    }
    is_written
}

/// Gives ids to referenced objects. The first use becomes the declaration, and every other use refers to it and needs
/// its id. `kind` is the prefix of new ids.
fn name_what_is_referred_to(
    uses: &[(DeclarationPlace, usize)],
    places: &[Option<DeclarationPlace>],
    ids: &mut [Option<String>],
    kind: &str,
    taken: &mut HashSet<String>,
) {
    let mut is_declared = vec![false; ids.len()];
    let mut number = 0;
    for &(owner, thing) in uses {
        if places[thing] == Some(owner) && !std::mem::replace(&mut is_declared[thing], true) {
            continue;
        }
        while ids[thing].is_none() {
            number += 1;
            let id = format!("{kind}-{number}");
            if taken.insert(id.clone()) {
                ids[thing] = Some(id);
            }
        }
    }
}

/// Writes a unit of the scene to its properties, where the `usual` one need not stand. An existing one keeps its place
/// in the file. If the file uses the name for something else (`is_taken`), the unit cannot be added or removed.
fn write_unit(name: &str, [unit, usual]: [&str; 2], is_taken: bool, properties: &mut Vec<Property>) {
    let known = properties.iter().position(|property| property.name == name);
    let value = Value::String(unit.to_owned());
    match known {
        Some(known) if unit != usual || properties[known].value == value => properties[known].value = value,
        Some(known) if !is_taken => drop(properties.remove(known)),
        None if unit != usual && !is_taken => properties.push(Property::new(name, value, Span::default())),
        Some(_) | None => {}
    }
}

/// Writes the properties of the scene to those of the file. An existing one keeps its place, and so do those of unknown
/// types.
fn write_properties(own: &SceneProperties, properties: &mut Vec<Property>) {
    let mut new: Vec<Property> = own.0.for_file().collect();
    properties.retain_mut(|known| {
        if let Some(place) = new.iter().position(|property| property.name == known.name) {
            known.value = new.swap_remove(place).value;
            return true;
        }
        !Properties::is_one(known)
    });
    new.sort_by(|a, b| a.name.cmp(&b.name));
    properties.extend(new);
}

/// The object to write, with the properties of the thing.
fn plain_draft(identity: &Identity, current: Object) -> Draft {
    let current = with_properties(current, identity.properties.as_ref());
    Draft::new(identity.authored.as_ref(), current)
}

fn reference(id: &str) -> Child {
    Child::Reference {
        name: None,
        id: id.into(),
        span: Span::default(),
    }
}

fn finish(identity: &Identity, draft: Draft) -> (u32, Child) {
    let mut object = draft.object;
    object.id = id_of(identity);
    (identity.order, object.into())
}

fn id_of(identity: &Identity) -> Option<SmolStr> {
    identity.id.as_deref().map(SmolStr::from)
}

/// The identities of all described things.
pub(in crate::scene) fn identities(scene: &SceneDescription) -> impl Iterator<Item = &Identity> {
    let sensors = scene.sensors.iter().map(|sensor| &sensor.identity);
    let media = scene.media.iter().map(|medium| &medium.identity);
    let materials = scene.materials.iter().map(|material| &material.identity);
    let groups = scene.groups.iter().map(|group| &group.identity);
    let shapes = scene.shapes.iter().map(|shape| &shape.identity);
    let emitters = scene.emitters.iter().map(|emitter| &emitter.identity);
    let first = media.chain(materials).chain(groups).chain(shapes);
    sensors.chain(first).chain(emitters)
}

fn collect_ids(child: &Child, ids: &mut HashSet<String>) {
    let Child::Object(object) = child else {
        return;
    };
    ids.extend(object.id.as_ref().map(SmolStr::to_string));
    for inner in &object.children {
        collect_ids(inner, ids);
    }
}
