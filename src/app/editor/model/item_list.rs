//! The things of one kind in the order of the file, as a list that finds a thing quickly among hundreds of thousands.

use std::ops::Deref;

use bevy::ecs::entity::EntityHashSet;
use bevy::prelude::Entity;

use super::Item;

/// The number of edits up to which moving the rest of the list is quicker than a new list.
const FEW: usize = 8;

/// Items, which are read as a slice.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ItemList {
    items: Vec<Item>,
    /// The entities of the items, for searches that read a tenth of the memory.
    entities: Vec<Entity>,
    /// The number of items that are in a folder or inside another item.
    nested: usize,
}

impl ItemList {
    /// Whether no item is in a folder or inside another one.
    pub fn is_flat(&self) -> bool {
        self.nested == 0
    }

    /// The index of an entity's item.
    pub fn place_of(&self, entity: Entity) -> Option<usize> {
        self.entities.iter().position(|own| *own == entity)
    }

    /// The indices of these entities' items, ascending.
    pub fn places_of(&self, entities: &EntityHashSet) -> Vec<usize> {
        let all = self.entities.iter().enumerate();
        let found = all.filter(|(_, own)| entities.contains(*own));
        found.map(|(place, _)| place).collect()
    }

    /// Replaces an item.
    pub(super) fn replace(&mut self, place: usize, item: Item) {
        self.nested = self.nested - usize::from(is_nested(&self.items[place])) + usize::from(is_nested(&item));
        self.entities[place] = item.entity;
        self.items[place] = item;
    }

    /// Removes the items at these indices, ascending.
    pub(super) fn remove(&mut self, places: &[usize]) {
        let nested = places.iter().filter(|place| is_nested(&self.items[**place]));
        self.nested -= nested.count();
        remove(&mut self.items, places);
        remove(&mut self.entities, places);
    }

    /// Inserts items before these indices of the present list, ascending.
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
