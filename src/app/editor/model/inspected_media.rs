//! Fills the inspector's part about media from the selection.

use std::path::PathBuf;
use std::sync::Arc;

use bevy::ecs::system::SystemParam;
use bevy::math::Affine3A;
use bevy::prelude::*;

use super::gather::Naming;
use super::leaks::Leaks;
use super::mixed::Mixed;
use super::{Inspected, InspectedGrid, InspectedMedium};
use crate::app::editor::command::media::MediumSide;
use crate::scene::medium::{ExteriorOf, InteriorOf, Surrounds};
use crate::scene::{GridFile, Medium, VolumeMap, Volumes};

type Parts = (
    Naming,
    &'static Medium,
    Option<&'static InteriorOf>,
    Option<&'static ExteriorOf>,
    Option<&'static Surrounds>,
);

#[derive(SystemParam)]
pub(crate) struct Media<'w, 's> {
    media: Query<'w, 's, Parts>,
    volumes: Option<Res<'w, Volumes>>,
    maps: Option<Res<'w, Assets<VolumeMap>>>,
    leaks: Res<'w, Leaks>,
}

impl Media<'_, '_> {
    pub fn contains(&self, entity: Entity) -> bool {
        self.media.contains(entity)
    }

    /// The leak of a shape: the reason why it is not closed.
    pub fn leak(&self, shape: Entity) -> Option<String> {
        self.leaks.of(shape).map(str::to_owned)
    }

    /// The inspected medium, or the media that the inspected thing refers to, each once. Unchanged ones are shared with
    /// the last frame's list.
    pub fn inspected(&self, thing: &Inspected, before: &[InspectedMedium]) -> Vec<InspectedMedium> {
        let mut found: Vec<InspectedMedium> = Vec::new();
        for (side, entity) in places(thing, self.contains(thing.entity)) {
            let Ok((naming, medium, inside, outside, around)) = self.media.get(entity) else {
                continue;
            };
            if found.iter().any(|known| known.entity == entity) {
                continue;
            }
            let known = before.iter().find(|known| known.entity == entity);
            let unchanged = known.filter(|known| *known.medium == *medium);
            let users = inside.map_or(0, |of| of.iter().count())
                + outside.map_or(0, |of| of.iter().count())
                + around.map_or(0, |of| of.iter().count());
            found.push(InspectedMedium {
                entity,
                name: naming.name("medium"),
                medium: unchanged.map_or_else(|| Arc::new(medium.clone()), |known| known.medium.clone()),
                side,
                mixed: Mixed::default(),
                users,
                boxes: boxes(medium, |grid| self.content(grid)),
                grids: self.grids(medium),
            });
        }
        found
    }

    fn grids(&self, medium: &Medium) -> Vec<(PathBuf, Option<InspectedGrid>)> {
        let mut grids = Vec::new();
        medium.for_each_grid(&mut |grid| grids.push((grid.path.clone(), self.content(grid))));
        grids
    }

    /// The content of a grid file; None while it is not loaded.
    fn content(&self, grid: &GridFile) -> Option<InspectedGrid> {
        let handle = self.volumes.as_ref()?.get(&grid.asset_path())?;
        let map = self.maps.as_ref()?.get(handle)?;
        Some(InspectedGrid {
            resolution: map.grid.resolution(),
            channels: map.grid.channels() as usize,
            bounds: map.bounds,
            world_from_local: map.world_from_local,
        })
    }

    /// Marks values that differ in the media on the same sides of the other selected things.
    pub fn compare(&self, mut shown: Inspected, others: &[Inspected]) -> Inspected {
        for entry in &mut shown.media {
            let alike = others.iter().filter_map(|other| {
                let mut places = places(other, self.contains(other.entity));
                let (_, medium) = places.find(|(side, _)| *side == entry.side)?;
                self.media.get(medium).ok().map(|(_, medium, ..)| medium)
            });
            entry.mixed = Mixed::of_media(&entry.medium, alike);
        }
        shown
    }
}

/// World from the unit cube for the box of each volume of a medium. `content` returns the content of a grid file.
fn boxes(medium: &Medium, content: impl Fn(&GridFile) -> Option<InspectedGrid>) -> Vec<Affine3A> {
    let mut boxes: Vec<Affine3A> = Vec::new();
    medium.for_each_placed(&mut |place, file| {
        let mut whole = *place;
        if let Some((file, content)) = file.and_then(|file| Some((file, content(file)?))) {
            whole *= content.world_from_local;
            if let Some(bounds) = content.bounds.filter(|_| file.use_grid_bbox) {
                whole = whole * Affine3A::from_translation(bounds.min) * Affine3A::from_scale(bounds.extent());
            }
        }
        if !boxes.contains(&whole) {
            boxes.push(whole);
        }
    });
    boxes
}

/// The media of a thing with the sides on which it refers to them.
fn places(thing: &Inspected, is_medium: bool) -> impl Iterator<Item = (Option<MediumSide>, Entity)> {
    let own = is_medium.then_some((None, thing.entity));
    let sides = MediumSide::ALL.map(|side| Some((Some(side), thing.media_at[side as usize]?)));
    own.into_iter().chain(sides.into_iter().flatten())
}
