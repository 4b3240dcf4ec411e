//! Finds the thing that every pixel shows, and from that the outline of the selection: it is exact at once, however noisy the picture still is.
//!
//! Outlines are rows of rectangles over the picture, not part of it: saved images do not have them.

use std::collections::{HashMap, HashSet};
use std::sync::Arc;

use bevy::math::Vec2;
use bevy::prelude::Entity;
use bevy_egui::egui::{Color32, Mesh, Rect, pos2};

use crate::app::editor::command::selection::Selection;
use crate::engine::{PackedScene, RenderFilm};
use crate::render::film::Film;
use crate::render::tile::{Tile, tiles};

/// The emphasis of a thing's outline. Where two meet, the later one is shown.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum Level {
    /// It has no outline.
    #[default]
    None,
    /// It is under the pointer.
    Hovered,
    /// It is selected, but not the active one.
    Selected,
    /// The one that was selected last.
    Active,
}

impl Level {
    /// The strongest level that holds for `entity`.
    pub fn of(entity: Entity, selection: &Selection, hovered: Option<Entity>) -> Self {
        if selection.active() == Some(entity) {
            Self::Active
        } else if selection.contains(entity) {
            Self::Selected
        } else if hovered == Some(entity) {
            Self::Hovered
        } else {
            Self::None
        }
    }

    /// The colour of outlines and icons.
    pub fn color(self) -> Color32 {
        match self {
            Self::None => Color32::from_rgb(235, 225, 170),
            Self::Hovered => Color32::from_white_alpha(130),
            Self::Selected => Color32::from_rgb(226, 112, 24),
            Self::Active => Color32::from_rgb(255, 190, 70),
        }
    }
}

/// A piece of an outline: pixels of one row, from the first to before the last.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Run {
    /// The row, from the top.
    pub y: u32,
    /// The first column.
    pub from: u32,
    /// The column after the last.
    pub to: u32,
    /// Decides the colour.
    pub level: Level,
}

/// The instance that each pixel shows first, row-major. Pixels that the film has nothing for yet stay as they were.
#[derive(Clone, Debug, Default)]
pub struct SeenInstances {
    width: u32,
    height: u32,
    instances: Vec<u32>,
}

const NOTHING: u32 = u32::MAX;
/// A picture full of fur has no outline worth waiting for.
const MOST_RUNS: usize = 60_000;

impl SeenInstances {
    /// Reads these tiles of the film; true if something else is seen.
    pub fn update(&mut self, film: &Film, tiles: &[Tile]) -> bool {
        let mut changed = false;
        for tile in tiles {
            for y in tile.y..tile.y + tile.height {
                let start = (y * self.width + tile.x) as usize;
                let row = &mut self.instances[start..start + tile.width as usize];
                for (x, seen) in (tile.x..).zip(row) {
                    let now = match film.first_hit(x, y) {
                        Some(hit) => hit.instance,
                        None if film.samples(x, y) > 0 => NOTHING,
                        None => *seen,
                    };
                    changed |= now != *seen;
                    *seen = now;
                }
            }
        }
        changed
    }

    /// Becomes as large as the film; true if it was not.
    fn fit(&mut self, film: &Film) -> bool {
        let differs = (self.width, self.height) != (film.width(), film.height());
        if differs {
            *self = self.resized(film.width(), film.height());
        }
        differs
    }

    /// The same at another resolution.
    fn resized(&self, width: u32, height: u32) -> Self {
        let nearest = |place: u32, to: u32, from: u32| (u64::from(place) * u64::from(from) / u64::from(to)) as usize;
        let row = |y: u32| nearest(y, height, self.height) * self.width as usize;
        let pixels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
        let seen = |(x, y)| self.instances.get(row(y) + nearest(x, width, self.width)).copied();
        Self {
            width,
            height,
            instances: pixels.map(|pixel| seen(pixel).unwrap_or(NOTHING)).collect(),
        }
    }

    /// The instances that are visible in a rectangle of the picture, by its film coordinates, each once.
    pub(crate) fn instances_in(&self, min: Vec2, max: Vec2) -> HashSet<u32> {
        let size = Vec2::new(self.width as f32, self.height as f32);
        let (min, max) = ((min * size).max(Vec2::ZERO).floor(), (max * size).min(size).ceil());
        let (columns, rows) = (min.x as usize..max.x as usize, min.y as usize..max.y as usize);
        let row = |y: usize| {
            self.instances
                .get(y * self.width as usize + columns.start..y * self.width as usize + columns.end)
        };
        let mut found: HashSet<u32> = rows.filter_map(row).flatten().copied().collect();
        found.remove(&NOTHING);
        found
    }

    /// The pixels whose neighbours belong to other things of `marks`, on both sides, so that an outline is two pixels wide. `mark_of_instance` is
    /// an index into `marks`, of which the first stands for all that has no outline.
    pub fn outline(&self, mark_of_instance: &[u32], marks: &[Level]) -> Vec<Run> {
        let width = self.width as usize;
        let mark = |instance: &u32| mark_of_instance.get(*instance as usize).copied().unwrap_or(0);
        let found: Vec<u32> = self.instances.iter().map(mark).collect();
        let rows: Vec<&[u32]> = found.chunks_exact(width.max(1)).collect();
        let is_plain: Vec<bool> = rows.iter().map(|row| row.iter().all(|mark| *mark == 0)).collect();
        let mut runs: Vec<Run> = Vec::new();
        for (y, row) in rows.iter().enumerate() {
            let (above, below) = (y.saturating_sub(1), (y + 1).min(rows.len() - 1));
            if runs.len() >= MOST_RUNS {
                break;
            }
            if is_plain[above] && is_plain[y] && is_plain[below] {
                continue;
            }
            for x in 0..width {
                let own = row[x];
                let around = [
                    rows[above][x],
                    rows[below][x],
                    row[x.saturating_sub(1)],
                    row[(x + 1).min(width - 1)],
                ];
                if around.iter().all(|other| *other == own) {
                    continue;
                }
                let level = |mark: u32| marks.get(mark as usize).copied().unwrap_or_default();
                let strongest = around.into_iter().map(level).fold(level(own), Level::max);
                let (y, from) = (y as u32, x as u32);
                match runs.last_mut() {
                    Some(run) if (run.y, run.to, run.level) == (y, from, strongest) => run.to += 1,
                    _ => runs.push(Run {
                        y,
                        from,
                        to: from + 1,
                        level: strongest,
                    }),
                }
            }
        }
        runs
    }
}

/// The outline as it was last found.
#[derive(Debug, Default)]
pub struct SelectionOutline {
    /// The instance that each pixel shows.
    pub seen: SeenInstances,
    runs: Vec<Run>,
    /// The entities of the scene that the film shows.
    entity_of_instance: Arc<[Entity]>,
    film_job: Option<u64>,
    /// The selection, the hovered thing and the revision of the picture that it was made from.
    made_from: Option<(Selection, Option<Entity>, u64)>,
    /// The job of which all pixels are there.
    complete_job: Option<u64>,
}

impl SelectionOutline {
    /// Updates the outline. `revision` counts the changes of the picture, `changed` says where the film had something new in the last of them.
    pub fn update(
        &mut self,
        film: &RenderFilm,
        packed: &PackedScene,
        selection: &Selection,
        hovered: Option<Entity>,
        (revision, changed): (u64, &[Tile]),
    ) {
        // The scene may be ahead of the picture.
        let is_known = self.film_job == Some(film.job);
        if !is_known {
            self.film_job = Some(film.job);
            self.entity_of_instance = packed.entity_of_instance.clone();
        }
        let is_complete = self.complete_job == Some(film.job);
        let before = self.made_from.as_ref().map(|(.., revision)| *revision);
        let mut is_same = is_known
            && (self.made_from.as_ref())
                .is_some_and(|(was, was_hovered, _)| was == selection && *was_hovered == hovered);
        if is_same && (is_complete || before == Some(revision)) {
            return;
        }
        if !is_complete {
            let has_all = film.film.sample_count() > 0;
            let is_new_size = self.seen.fit(&film.film);
            // Tiles may have come since that revision: in the end all are looked at.
            let is_next = is_known && !is_new_size && !has_all && before.is_some_and(|before| before + 1 == revision);
            let sees_else = if is_next {
                self.seen.update(&film.film, changed)
            } else {
                self.seen
                    .update(&film.film, &tiles(film.film.width(), film.film.height()))
            };
            is_same &= !sees_else && !is_new_size;
            self.complete_job = has_all.then_some(film.job);
        }
        self.made_from = Some((selection.clone(), hovered, revision));
        if is_same {
            return;
        }
        self.runs.clear();
        if !selection.is_empty() || hovered.is_some() {
            let others = hovered.filter(|entity| !selection.contains(*entity));
            let marked: Vec<Entity> = selection.entities().iter().copied().chain(others).collect();
            let mark_of: HashMap<Entity, u32> = marked.iter().copied().zip(1..).collect();
            let mark = |entity: &Entity| mark_of.get(entity).copied().unwrap_or(0);
            let marks: Vec<u32> = self.entity_of_instance.iter().map(mark).collect();
            let level = |entity: &Entity| Level::of(*entity, selection, hovered);
            let levels: Vec<Level> = std::iter::once(Level::None).chain(marked.iter().map(level)).collect();
            self.runs = self.seen.outline(&marks, &levels);
        }
    }

    /// The entities that show in a rectangle of the picture, in the order of the scene.
    pub(crate) fn entities_in(&self, min: Vec2, max: Vec2) -> Vec<Entity> {
        let mut instances: Vec<u32> = self.seen.instances_in(min, max).into_iter().collect();
        instances.sort_unstable();
        let entities = instances
            .iter()
            .filter_map(|instance| self.entity_of_instance.get(*instance as usize));
        let mut known = HashSet::new();
        entities.copied().filter(|entity| known.insert(*entity)).collect()
    }

    /// The mesh that is painted over the picture.
    pub fn mesh(&self, picture: Rect) -> Mesh {
        let mut mesh = Mesh::default();
        let (width, height) = (self.seen.width.max(1) as f32, self.seen.height.max(1) as f32);
        let at = |x: u32, y: u32| {
            let film = pos2(x as f32 / width, y as f32 / height);
            picture.min + film.to_vec2() * picture.size()
        };
        for run in &self.runs {
            let rect = Rect::from_min_max(at(run.from, run.y), at(run.to, run.y + 1));
            mesh.add_colored_rect(rect, run.level.color());
        }
        mesh
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::material::MaterialId;
    use crate::render::scene::FirstHit;
    use crate::render::tile::{PixelSum, TileSamples};

    /// A picture of eight by six pixels: instance 1 is a block of three by two from (2, 2), instance 0 touches it on the right, and the rest shows
    /// nothing.
    fn seen() -> SeenInstances {
        let mut instances = vec![NOTHING; 48];
        for (x, y, instance) in [
            (2, 2, 1),
            (3, 2, 1),
            (4, 2, 1),
            (2, 3, 1),
            (3, 3, 1),
            (4, 3, 1),
            (5, 2, 0),
            (5, 3, 0),
        ] {
            instances[y * 8 + x] = instance;
        }
        SeenInstances {
            width: 8,
            height: 6,
            instances,
        }
    }

    fn pixels(runs: &[Run], level: Level) -> usize {
        runs.iter()
            .filter(|run| run.level == level)
            .map(|run| (run.to - run.from) as usize)
            .sum()
    }

    #[test]
    fn an_outline_goes_around_both_ways() {
        let runs = seen().outline(&[0, 1], &[Level::None, Level::Selected]);
        // The outline is all six pixels of the block, and ten around it.
        assert_eq!(pixels(&runs, Level::Selected), 16);
        assert!(runs.iter().all(|run| (1..=4).contains(&run.y)));
        assert!(seen().outline(&[0, 0], &[Level::None]).is_empty());
    }

    #[test]
    fn selected_things_are_told_apart_and_the_active_wins() {
        let levels = [Level::None, Level::Hovered, Level::Active];
        let runs = seen().outline(&[2, 1], &levels);
        // The two of the active one, and two beside on either side and one above and below.
        assert_eq!(pixels(&runs, Level::Active), 8);
        // These are the four of the other's six pixels that do not touch it, and eight around: it touches on its right.
        assert_eq!(pixels(&runs, Level::Hovered), 4 + 8);
    }

    #[test]
    fn the_instances_of_one_thing_have_one_outline() {
        let runs = seen().outline(&[1, 1], &[Level::None, Level::Selected]);
        // A block of four by two: all eight, and twelve around them.
        assert_eq!(pixels(&runs, Level::Selected), 20);
        assert!(
            runs.iter()
                .filter(|run| run.y == 2)
                .all(|run| (run.from, run.to) == (1, 7))
        );
    }

    #[test]
    fn tiles_that_changed_are_enough() {
        let mut film = Film::new(40, 8);
        let all = tiles(40, 8);
        let mut seen = SeenInstances::default();
        assert!(seen.fit(&film) && !seen.fit(&film));
        let hit = FirstHit {
            instance: 3,
            material: MaterialId(0),
            uv: Vec2::ZERO,
        };
        for (tile, hits) in [(all[0], vec![Some(hit); 256]), (all[1], vec![None; 64])] {
            film.add(&TileSamples {
                tile,
                samples: 0..1,
                pixels: vec![PixelSum::default(); hits.len()],
                layers: Vec::new(),
                first_hits: hits,
                splats: Vec::new(),
                rays: 0,
                invalid: 0,
            });
        }
        let everything = |seen: &SeenInstances| seen.instances_in(Vec2::ZERO, Vec2::ONE);
        // Nothing was known there, and nothing is there.
        assert!(!seen.update(&film, &all[1..]) && everything(&seen).is_empty());
        assert!(seen.update(&film, &all[..1]) && everything(&seen) == HashSet::from([3]));
        assert!(!seen.update(&film, &all), "all of it is known");
        assert!(seen.instances_in(Vec2::new(0.8, 0.0), Vec2::ONE).is_empty());
    }

    #[test]
    fn another_resolution_shows_the_same() {
        let large = seen().resized(16, 12);
        let all = large.instances_in(Vec2::ZERO, Vec2::ONE);
        assert_eq!(all, seen().instances_in(Vec2::ZERO, Vec2::ONE));
        let back = large.resized(8, 6);
        assert_eq!(back.instances, seen().instances);
        assert!(SeenInstances::default().resized(2, 1).instances == [NOTHING; 2]);
    }

    #[test]
    fn a_box_holds_what_shows_in_it() {
        let found = |min: (f32, f32), max: (f32, f32)| {
            let mut found: Vec<u32> = seen().instances_in(min.into(), max.into()).into_iter().collect();
            found.sort_unstable();
            found
        };
        assert_eq!(found((0.0, 0.0), (1.0, 1.0)), [0, 1]);
        assert_eq!(found((0.0, 0.0), (0.26, 0.4)), [1]);
        assert_eq!(found((0.65, 0.4), (2.0, 0.6)), [0]);
        assert!(found((0.0, 0.7), (0.9, 1.0)).is_empty() && found((0.5, 0.5), (0.2, 0.2)).is_empty());
    }
}
