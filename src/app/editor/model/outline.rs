//! Keeps the list of all things up to date: only the rows of changed things are replaced.

use std::sync::Arc;

use bevy::ecs::entity::EntityHashSet;
use bevy::ecs::system::SystemParam;
use bevy::prelude::*;

use super::gather::{Naming, NamingItem, medium_kind, shape_kind};
use super::item_list::ItemList;
use super::{EditorModel, Item, Outline};
use crate::scene::changes::Changes;
use crate::scene::{
    AreaLight, DocumentOrder, Emitter, FirstNestedIn, Hidden, Locked, Material, Medium, Properties, SceneId,
    SceneStatus, SecondNestedIn, Sensor, Shape, UsesMaterial,
};

/// The number of changed things above which the whole list is rebuilt.
const MOST_EDITED: usize = 16_384;

#[derive(SystemParam)]
pub(crate) struct OutlineNews<'w, 's> {
    names: Changes<'w, 's, Name>,
    ids: Changes<'w, 's, SceneId>,
    orders: Changes<'w, 's, DocumentOrder>,
    shapes: Changes<'w, 's, Shape>,
    materials: Changes<'w, 's, Material>,
    media: Changes<'w, 's, Medium>,
    emitters: Changes<'w, 's, Emitter>,
    uses: Changes<'w, 's, UsesMaterial>,
    properties: Changes<'w, 's, Properties>,
    first_outer: Changes<'w, 's, FirstNestedIn>,
    second_outer: Changes<'w, 's, SecondNestedIn>,
    added: Query<'w, 's, Entity, Or<(Added<AreaLight>, Added<Sensor>, Added<Hidden>, Added<Locked>)>>,
    removed_shapes: RemovedComponents<'w, 's, Shape>,
    removed_materials: RemovedComponents<'w, 's, Material>,
    removed_media: RemovedComponents<'w, 's, Medium>,
    removed_emitters: RemovedComponents<'w, 's, Emitter>,
    removed_lights: RemovedComponents<'w, 's, AreaLight>,
    removed_sensors: RemovedComponents<'w, 's, Sensor>,
    shown: RemovedComponents<'w, 's, Hidden>,
    unlocked: RemovedComponents<'w, 's, Locked>,
    bare: RemovedComponents<'w, 's, UsesMaterial>,
    plain: RemovedComponents<'w, 's, Properties>,
    nameless: (RemovedComponents<'w, 's, SceneId>, RemovedComponents<'w, 's, Name>),
    taken_out: RemovedComponents<'w, 's, FirstNestedIn>,
    taken_out_second: RemovedComponents<'w, 's, SecondNestedIn>,
}

impl OutlineNews<'_, '_> {
    fn read(&mut self) -> EntityHashSet {
        let mut changed: EntityHashSet = self.added.iter().collect();
        let mut note = |entity| {
            changed.insert(entity);
        };
        self.names.for_each(&mut note);
        self.ids.for_each(&mut note);
        self.orders.for_each(&mut note);
        self.shapes.for_each(&mut note);
        self.materials.for_each(&mut note);
        self.media.for_each(&mut note);
        self.emitters.for_each(&mut note);
        self.uses.for_each(&mut note);
        self.properties.for_each(&mut note);
        self.first_outer.for_each(&mut note);
        self.second_outer.for_each(&mut note);
        changed.extend(self.removed_shapes.read());
        changed.extend(self.removed_materials.read());
        changed.extend(self.removed_media.read());
        changed.extend(self.removed_emitters.read());
        changed.extend(self.removed_lights.read());
        changed.extend(self.removed_sensors.read());
        changed.extend(self.shown.read());
        changed.extend(self.unlocked.read());
        changed.extend(self.bare.read());
        changed.extend(self.plain.read());
        changed.extend(self.nameless.0.read());
        changed.extend(self.nameless.1.read());
        changed.extend(self.taken_out.read());
        changed.extend(self.taken_out_second.read());
        changed
    }
}

#[derive(SystemParam)]
pub(crate) struct Things<'w, 's> {
    shapes: Query<'w, 's, (Naming, &'static Shape, Has<AreaLight>)>,
    materials: Query<'w, 's, (Naming, &'static Material)>,
    media: Query<'w, 's, (Naming, &'static Medium)>,
    emitters: Query<'w, 's, (Naming, &'static Emitter)>,
    sensors: Query<'w, 's, (Naming, &'static Sensor)>,
    orders: Query<'w, 's, &'static DocumentOrder>,
}

/// An item with its position in the order of the file.
type Placed = (u32, Item);

/// The item of an emissive shape in the list of lights, without its material, so that the row shows its kind.
fn shining(naming: &NamingItem) -> Placed {
    let (order, item) = naming.item("area");
    (order, Item { uses: None, ..item })
}

impl Things<'_, '_> {
    fn all(&self) -> Outline {
        let lights = self
            .shapes
            .iter()
            .filter(|(_, _, emits)| *emits)
            .map(|(naming, ..)| shining(&naming))
            .chain(
                self.emitters
                    .iter()
                    .map(|(naming, emitter)| naming.item(emitter.info().label)),
            );
        Outline {
            lights: sorted(lights),
            shapes: sorted(
                self.shapes
                    .iter()
                    .map(|(naming, shape, _)| naming.item(shape_kind(shape))),
            ),
            materials: sorted(
                self.materials
                    .iter()
                    .map(|(naming, material)| naming.item(material.info().label)),
            ),
            media: sorted(
                self.media
                    .iter()
                    .map(|(naming, medium)| naming.item(medium_kind(medium))),
            ),
            sensors: sorted(self.sensors.iter().map(|(naming, _)| naming.item("camera"))),
        }
    }

    /// Replaces the rows of changed things; the result equals [`Self::all`].
    fn update(&self, outline: &mut Outline, changed: &EntityHashSet) {
        let shape = |entity| self.shapes.get(entity).ok();
        let lit = |entity| shape(entity).filter(|(_, _, emits)| *emits);
        let light = |entity| {
            let emitter = || Some(self.emitters.get(entity).ok()?).map(|(naming, it)| naming.item(it.info().label));
            lit(entity).map(|(naming, ..)| shining(&naming)).or_else(emitter)
        };
        let material = |entity| self.materials.get(entity).ok();
        self.replace(&mut outline.lights, changed, light);
        self.replace(&mut outline.shapes, changed, |entity| {
            shape(entity).map(|(naming, shape, _)| naming.item(shape_kind(shape)))
        });
        self.replace(&mut outline.materials, changed, |entity| {
            material(entity).map(|(naming, material)| naming.item(material.info().label))
        });
        self.replace(&mut outline.media, changed, |entity| {
            let found = self.media.get(entity).ok();
            found.map(|(naming, medium)| naming.item(medium_kind(medium)))
        });
        self.replace(&mut outline.sensors, changed, |entity| {
            self.sensors.get(entity).ok().map(|(naming, _)| naming.item("camera"))
        });
    }

    /// The sort key of a listed thing.
    fn key(&self, entity: Entity) -> (u32, Entity) {
        (self.orders.get(entity).map_or(u32::MAX, |order| order.0), entity)
    }

    fn replace(&self, list: &mut ItemList, changed: &EntityHashSet, now: impl Fn(Entity) -> Option<Placed>) {
        let listed = list.places_of(changed);
        let mut new: Vec<Placed> = changed.iter().filter_map(|&entity| now(entity)).collect();
        // Most edits leave things at their positions.
        let stays = |place: &usize| {
            let here = self.key(list[*place].entity);
            let is_after = |before: &Item| changed.contains(&before.entity) || self.key(before.entity) < here;
            let is_before = |after: &Item| changed.contains(&after.entity) || here < self.key(after.entity);
            (place.checked_sub(1).and_then(|before| list.get(before))).is_none_or(is_after)
                && list.get(place + 1).is_none_or(is_before)
        };
        if let [place] = listed[..]
            && let [(_, item)] = &new[..]
            && item.entity == list[place].entity
            && stays(&place)
        {
            list.replace(place, item.clone());
            return;
        }
        list.remove(&listed);
        new.sort_by_key(|(order, item)| (*order, item.entity));
        let placed = new.into_iter().map(|(order, item)| {
            let key = (order, item.entity);
            (list.partition_point(|other| self.key(other.entity) < key), item)
        });
        let placed: Vec<(usize, Item)> = placed.collect();
        list.insert(placed);
    }
}

/// The items in the order of the file; those created in the editor come last.
fn sorted(items: impl Iterator<Item = Placed>) -> ItemList {
    let mut items: Vec<Placed> = items.collect();
    items.sort_by_key(|(order, item)| (*order, item.entity));
    items.into_iter().map(|(_, item)| item).collect()
}

/// Updates the list. While a scene is being opened it is empty: a part of the scene cannot be edited, and the list
/// would be rebuilt in every frame.
pub(crate) fn gather_outline(
    mut model: ResMut<EditorModel>,
    mut news: OutlineNews,
    things: Things,
    status: Option<Res<SceneStatus>>,
    mut was_opening: Local<bool>,
) {
    let is_opening = status.is_some_and(|status| status.is_opening);
    let is_opened = std::mem::replace(&mut *was_opening, is_opening) && !is_opening;
    if is_opening {
        if *model.0.outline != Outline::default() {
            model.0.outline = Arc::default();
        }
        return;
    }
    let changed = news.read();
    if changed.is_empty() && !is_opened {
        return;
    }
    if is_opened || changed.len() > MOST_EDITED {
        model.0.outline = Arc::new(things.all());
    } else {
        things.update(Arc::make_mut(&mut model.0.outline), &changed);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{ShapeKind, ToWorld};

    fn shape(kind: ShapeKind) -> Shape {
        Shape {
            kind,
            ..Shape::default()
        }
    }

    /// A few things that do not come in any order.
    fn numbers() -> impl FnMut(usize) -> usize {
        let mut state = 1u64;
        move |end| {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (state >> 33) as usize % end
        }
    }

    #[test]
    fn edits_leave_the_list_that_would_be_made_anew() {
        #[derive(Resource)]
        struct Anew(Outline);
        let mut world = World::new();
        world.init_resource::<EditorModel>();
        world.insert_resource(Anew(Outline::default()));
        let gather = world.register_system(gather_outline);
        let anew = world.register_system(|things: Things, mut anew: ResMut<Anew>| anew.0 = things.all());
        let paint = world.spawn((DocumentOrder(0), Material::default())).id();
        let mut number = numbers();
        let mut entities: Vec<Entity> = Vec::new();
        for step in 0..400 {
            for _ in 0..1 + step % 20 {
                let order = DocumentOrder(number(1000) as u32);
                if entities.len() < 50 || number(4) == 0 {
                    let kinds = [ShapeKind::Cube, ShapeKind::Disk];
                    let thing = (order, Name::new(format!("thing {step}")), ToWorld::default());
                    let entity = match number(5) {
                        4 => world.spawn((thing, Medium::default())).id(),
                        0 => world.spawn((thing, Material::default())).id(),
                        1 => world.spawn((thing, Sensor::default())).id(),
                        _ => world.spawn((thing, shape(kinds[number(2)].clone()))).id(),
                    };
                    entities.push(entity);
                    continue;
                }
                let place = number(entities.len());
                let mut it = world.entity_mut(entities[place]);
                match number(11) {
                    0 => {
                        it.despawn();
                        entities.swap_remove(place);
                    }
                    1 => drop(it.insert(order)),
                    2 => drop(it.insert(SceneId(format!("id {step}")))),
                    3 => drop(it.remove::<(SceneId, Name)>()),
                    4 => drop(it.insert(Hidden)),
                    5 => drop(it.remove::<Hidden>()),
                    6 if it.contains::<Shape>() => drop(it.insert(AreaLight::default())),
                    7 => drop(it.remove::<AreaLight>()),
                    8 => drop(it.remove::<Shape>()),
                    9 => drop(it.insert(UsesMaterial(paint))),
                    10 => drop(it.remove::<UsesMaterial>()),
                    _ => drop(it.insert(Name::new(format!("{}name {step}", ["", "folder/"][number(2)])))),
                }
            }
            world.run_system(gather).expect("it runs");
            world.run_system(anew).expect("it runs");
            assert_eq!(
                *world.resource::<EditorModel>().0.outline,
                world.resource::<Anew>().0,
                "step {step}"
            );
        }
    }
}
