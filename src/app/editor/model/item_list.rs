//! The things of one kind in the order of the file, as a list in which a thing is found quickly among hundreds of
//! thousands.

use std::ops::Deref;

use bevy::ecs::entity::EntityHashSet;
use bevy::prelude::Entity;

use super::Item;

/// Moving all that comes after is quicker than a new list, up to this number of places.
const FEW: usize = 8;

/// Items, which are read as a slice.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ItemList {
    items: Vec<Item>,
    /// The entities of the items. A search through them reads a tenth of the memory.
    entities: Vec<Entity>,
    /// The number of items that are in a folder or inside another item.
    nested: usize,
}

impl ItemList {
    /// Whether no item is in a folder or inside another one.
    pub fn is_flat(&self) -> bool {
        self.nested == 0
    }

    /// The place of the item of an entity.
    pub fn place_of(&self, entity: Entity) -> Option<usize> {
        self.entities.iter().position(|own| *own == entity)
    }

    /// The places of the items of these entities, ascending.
    pub fn places_of(&self, entities: &EntityHashSet) -> Vec<usize> {
        let all = self.entities.iter().enumerate();
        let found = all.filter(|(_, own)| entities.contains(*own));
        found.map(|(place, _)| place).collect()
    }

    /// Puts an item in place of another.
    pub(super) fn replace(&mut self, place: usize, item: Item) {
        self.nested = self.nested - usize::from(is_nested(&self.items[place])) + usize::from(is_nested(&item));
        self.entities[place] = item.entity;
        self.items[place] = item;
    }

    /// Takes out what is at these places, ascending.
    pub(super) fn remove(&mut self, places: &[usize]) {
        let nested = places.iter().filter(|place| is_nested(&self.items[**place]));
        self.nested -= nested.count();
        remove(&mut self.items, places);
        remove(&mut self.entities, places);
    }

    /// Puts items in before those at these places of the list as it is, ascending.
    pub(super) fn insert(&mut self, items: Vec<(usize, Item)>) {
        self.nested += items.iter().filter(|(_, item)| is_nested(item)).count();
        let entities = items.iter().map(|(place, item)| (*place, item.entity)).collect();
        insert(&mut self.entities, entities);
        insert(&mut self.items, items);
    }
}

fn is_nested(item: &Item) -> bool {
    item.inside_of.is_some() || item.name.contains('/')
}

fn remove<T>(list: &mut Vec<T>, places: &[usize]) {
    if places.len() <= FEW {
        places.iter().rev().for_each(|&place| drop(list.remove(place)));
        return;
    }
    let mut gone = places.iter().peekable();
    let mut place = 0..;
    list.retain(|_| {
        let place = place.next();
        gone.next_if(|&&gone| Some(gone) == place).is_none()
    });
}

fn insert<T>(list: &mut Vec<T>, new: Vec<(usize, T)>) {
    if new.len() <= FEW {
        for (place, value) in new.into_iter().rev() {
            list.insert(place, value);
        }
        return;
    }
    let mut merged = Vec::with_capacity(list.len() + new.len());
    let mut old = std::mem::take(list).into_iter();
    let mut taken = 0;
    for (place, value) in new {
        merged.extend(old.by_ref().take(place - taken));
        taken = place;
        merged.push(value);
    }
    merged.extend(old);
    *list = merged;
}

impl Deref for ItemList {
    type Target = [Item];

    fn deref(&self) -> &[Item] {
        &self.items
    }
}

impl From<Vec<Item>> for ItemList {
    fn from(items: Vec<Item>) -> Self {
        Self {
            entities: items.iter().map(|item| item.entity).collect(),
            nested: items.iter().filter(|item| is_nested(item)).count(),
            items,
        }
    }
}

impl FromIterator<Item> for ItemList {
    fn from_iter<I: IntoIterator<Item = Item>>(items: I) -> Self {
        Vec::from_iter(items).into()
    }
}

impl<'a> IntoIterator for &'a ItemList {
    type Item = &'a Item;
    type IntoIter = std::slice::Iter<'a, Item>;

    fn into_iter(self) -> Self::IntoIter {
        self.items.iter()
    }
}
