//! The tool that places textures: a tile of the texture over the surface, which is moved, scaled and turned by its
//! handles.

mod bar;
mod drag;
mod paint;
mod sheet;

use bevy::ecs::entity::EntityHashSet;
use bevy::math::{Affine2, Vec2, Vec3};
use bevy::prelude::Entity;
use bevy_egui::egui::{Align2, Key, Painter, PointerButton, Pos2, Response, Ui, vec2};

use super::gizmo::interaction::Rest;
use super::gizmo::typed::Typed;
use super::marks::{tag, tag_beside};
use super::over_picture::is_over;
use crate::app::editor::camera::picking::{self, MappedSurface};
use crate::app::editor::camera::screen::Screen;
use crate::app::editor::command::selection::Extend;
use crate::app::editor::command::texture_placing::TextureGroup;
use crate::app::editor::command::{Command, SelectionCommand, TextureEdit};
use crate::app::editor::input::press::Press;
use crate::engine::PackedScene;
use crate::math::Ray;
use crate::scene::LengthUnit;
pub(crate) use bar::bar;
use drag::{Drag, Part};
use sheet::{Sheet, Tile};

/// The textures of the selected shape.
#[derive(Clone, Debug, PartialEq)]
pub struct TextureTarget {
    /// The shape.
    pub entity: Entity,
    /// Its textures, grouped by equal placement.
    pub groups: Vec<TextureGroup>,
    /// The transform with which pictures stand upright on it.
    pub upright: Affine2,
}

/// The data that the tool acts on.
#[derive(Clone, Copy, Debug)]
pub struct TexturingModel<'a> {
    /// The textures of the selected shape; None without a shape.
    pub target: Option<&'a TextureTarget>,
    /// The packed scene, to find surfaces.
    pub packed: &'a PackedScene,
    /// The locked entities, whose textures cannot be placed.
    pub locked: &'a EntityHashSet,
    /// The unit of the scene, in which sizes are shown.
    pub unit: LengthUnit,
}

impl<'a> TexturingModel<'a> {
    /// The textures that can be placed: those of the selected shape, unless it is locked.
    fn placeable(&self) -> Option<&'a TextureTarget> {
        self.target.filter(|target| !self.locked.contains(&target.entity))
    }
}

/// The state that the tool keeps between frames.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TexturingState {
    /// The place of the tile, on the selected shape or on the one that is being selected.
    anchor: Option<Anchor>,
    /// The texture coordinates in the middle of the tile; None for the tile at the anchor.
    focus: Option<Vec2>,
    /// The index of the group that is placed.
    chosen: usize,
    tile: Option<Tile>,
    lit: Option<Part>,
    held: Option<Held>,
    /// The hint that is shown in place of a tile.
    note: &'static str,
}

/// A place on a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Anchor {
    entity: Entity,
    place: Vec3,
    normal: Vec3,
}

impl Anchor {
    fn of(surface: &MappedSurface) -> Self {
        Self {
            entity: surface.entity,
            place: surface.position,
            normal: surface.normal,
        }
    }
}

#[derive(Clone, Debug, PartialEq)]
struct Held {
    drag: Drag,
    entity: Entity,
    /// The present transform of the textures.
    now: Affine2,
}

/// The distance in points within which the pointer hits a handle.
const REACH: f32 = 9.0;

impl TexturingState {
    /// Whether something is being dragged.
    pub(crate) fn is_busy(&self) -> bool {
        self.held.is_some()
    }

    /// Drops the tile's place, as when the tool is left.
    pub(crate) fn leave(&mut self) {
        *self = Self::default();
    }

    /// Follows the mouse and the keys of one frame.
    pub fn follow_tile(
        &mut self,
        ui: &Ui,
        response: &Response,
        screen: &Screen,
        model: &TexturingModel,
        presses: &[Press],
        commands: &mut Vec<Command>,
    ) -> Rest {
        let clicked = response.clicked_by(PointerButton::Primary);
        let is_over = is_over(ui, response);
        let (pointer, pressed, down, modifiers) = ui.input(|input| {
            let latest = input.pointer.latest_pos().unwrap_or(screen.picture.center());
            let pressed = input.pointer.button_pressed(PointerButton::Primary);
            // The pointer may have moved on since the press.
            let origin = input.pointer.press_origin().filter(|_| pressed);
            let down = input.pointer.button_down(PointerButton::Primary);
            (origin.unwrap_or(latest), pressed, down, input.modifiers)
        });
        let target = model.placeable();
        self.find_tile(screen, model, target);
        if self.held.as_ref().map(|held| held.entity) != target.map(|target| target.entity) {
            self.held = None;
        }
        let was_held = self.held.is_some();
        if self.held.is_none() {
            let is_free = is_over && !modifiers.alt;
            self.lit = self.part_under(screen, pointer).filter(|_| is_free);
            if let (Some(part), Some(tile), Some(target), true) = (self.lit, self.tile, target, pressed) {
                self.held = tile.sheet.uv_under(screen, pointer).map(|grabbed| Held {
                    drag: Drag {
                        part,
                        start: tile,
                        grabbed,
                        typed: Typed::default(),
                    },
                    entity: target.entity,
                    now: tile.to_uv,
                });
            }
        }
        let keys = presses.iter().filter(|press| !self.take_key(press, commands));
        let keys = keys.copied().collect();
        let rest = Rest {
            pointer: self.held.is_none() && !was_held,
            presses: keys,
        };
        if let (Some(held), Some(target)) = (&mut self.held, target) {
            held.follow(screen, pointer, modifiers.command, down, target, commands);
            self.tile = Some(held.tile());
            if !down {
                self.let_go(screen, model.packed);
            }
        } else if clicked && rest.pointer && is_over && !modifiers.alt {
            self.go_to(screen, pointer, model, target, commands);
        }
        rest
    }

    /// Finds the tile of this frame.
    fn find_tile(&mut self, screen: &Screen, model: &TexturingModel, target: Option<&TextureTarget>) {
        (self.tile, self.note) = (None, "");
        let Some(target) = target else {
            self.note = match model.target {
                Some(_) => "The shape is locked: its textures stay as they are",
                None => "Click a shape that has a picture or a checkerboard",
            };
            return;
        };
        if target.groups.is_empty() {
            self.note = "The material has no picture or checkerboard";
            return;
        }
        self.chosen = self.chosen.min(target.groups.len() - 1);
        let known = self.anchor.filter(|anchor| anchor.entity == target.entity);
        let surface = known
            .and_then(|anchor| again(model.packed, screen, &anchor))
            .or_else(|| {
                self.focus = None;
                central(model.packed, screen, target.entity)
            });
        let Some(surface) = surface else {
            self.note = "The surface is not in the picture. Click it to place its texture there";
            return;
        };
        self.anchor = Some(Anchor::of(&surface));
        let Some(sheet) = Sheet::at(&surface) else {
            self.note = "There are no texture coordinates here: see Arrange > Project texture";
            return;
        };
        self.tile = match &self.held {
            Some(held) => Some(held.tile()),
            None => {
                let to_uv = target.groups[self.chosen].to_uv;
                let focus = *self.focus.get_or_insert(to_uv.transform_point2(sheet.uv()));
                Tile::around(sheet, to_uv, focus, screen)
            }
        };
    }

    /// The part of the tile under the pointer.
    fn part_under(&self, screen: &Screen, pointer: Pos2) -> Option<Part> {
        let tile = self.tile.as_ref()?;
        let arm = paint::arm(screen, tile).map(|[_, end]| (Part::Arm, end));
        let points = Part::POINTS
            .iter()
            .filter_map(|(part, share)| Some((*part, tile.point(screen, *share)?)));
        let near = arm
            .into_iter()
            .chain(points)
            .map(|(part, at)| (part, at.distance(pointer)));
        let nearest = near
            .filter(|(_, distance)| *distance <= REACH)
            .min_by(|a, b| a.1.total_cmp(&b.1));
        nearest.map(|(part, _)| part).or_else(|| {
            let place = tile.to_uv.transform_point2(tile.sheet.uv_under(screen, pointer)?);
            let share = (place - tile.base) / tile.span;
            let is_inside = share.cmpge(Vec2::ZERO).all() && share.cmple(Vec2::ONE).all();
            is_inside.then_some(Part::Inside)
        })
    }

    /// Moves the tile to the surface under the pointer, and selects that shape.
    fn go_to(
        &mut self,
        screen: &Screen,
        pointer: Pos2,
        model: &TexturingModel,
        target: Option<&TextureTarget>,
        commands: &mut Vec<Command>,
    ) {
        let ray = picking::narrowed(model.packed, &screen.ray(pointer));
        let seen = ray.and_then(|ray| picking::mapped_surface(model.packed, &ray, |_| false));
        let Some(seen) = seen.filter(|seen| !model.locked.contains(&seen.entity)) else {
            return;
        };
        (self.anchor, self.focus) = (Some(Anchor::of(&seen)), None);
        if Some(seen.entity) != target.map(|target| target.entity) {
            self.chosen = 0;
            commands.push(SelectionCommand::Select(vec![seen.entity], Extend::Replace).into());
        }
    }

    /// Ends the drag. The tile stays on the surface that is now at its place.
    fn let_go(&mut self, screen: &Screen, packed: &PackedScene) {
        let Some(held) = self.held.take() else { return };
        let tile = held.tile();
        let middle = Vec2::splat(0.5);
        self.focus = Some(tile.texture(middle));
        let ray = tile
            .point(screen, middle)
            .and_then(|at| picking::narrowed(packed, &screen.ray(at)));
        let is_other = |entity: Entity| entity != held.entity;
        if let Some(surface) = ray.and_then(|ray| picking::mapped_surface(packed, &ray, is_other)) {
            self.anchor = Some(Anchor::of(&surface));
        }
    }

    /// Handles a key; returns whether the drag used it.
    fn take_key(&mut self, press: &Press, commands: &mut Vec<Command>) -> bool {
        let Some(held) = &mut self.held else { return false };
        if press.modifiers.command || press.modifiers.alt {
            return false;
        }
        match press.key {
            Key::Escape => {
                let before = held.drag.start.to_uv;
                commands.extend(
                    (held.now != before).then_some(Command::from(TextureEdit::PlaceTextures {
                        owner: held.entity,
                        before: held.now,
                        after: before,
                    })),
                );
                self.held = None;
                true
            }
            Key::Enter => true,
            key => held.drag.typed.press(key),
        }
    }

    /// Paints the tile, the text about a drag, or a hint about the lack of a texture.
    pub fn paint_tile(&self, painter: &Painter, screen: &Screen, model: &TexturingModel, pointer: Option<Pos2>) {
        if let Some(tile) = &self.tile {
            let lit = self.held.as_ref().map(|held| held.drag.part).or(self.lit);
            paint::paint(painter, screen, tile, lit);
        }
        if let (Some(held), Some(pointer)) = (&self.held, pointer) {
            let text = held.drag.text(&held.now, model.unit);
            tag_beside(painter, pointer + vec2(18.0, 14.0), &text);
        }
        if !self.note.is_empty() {
            let foot = screen.picture.center_bottom() - vec2(0.0, 8.0);
            tag(painter, foot, Align2::CENTER_BOTTOM, self.note);
        }
    }
}

impl Held {
    /// The tile in its present transform.
    fn tile(&self) -> Tile {
        Tile {
            to_uv: self.now,
            ..self.drag.start
        }
    }

    /// Places the textures by the pointer or the typed numbers.
    fn follow(
        &mut self,
        screen: &Screen,
        pointer: Pos2,
        snaps: bool,
        down: bool,
        target: &TextureTarget,
        commands: &mut Vec<Command>,
    ) {
        let under = self.drag.start.sheet.uv_under(screen, pointer);
        // A press alone moves nothing.
        let is_begun =
            self.now != self.drag.start.to_uv || !self.drag.typed.is_empty() || under != Some(self.drag.grabbed);
        let placed = under
            .filter(|_| is_begun)
            .and_then(|under| self.drag.placed(under, snaps));
        let Some(after) = placed.filter(|after| *after != self.now) else {
            return;
        };
        // A drag past the placement of other textures must not merge with their group.
        if down && target.groups.iter().any(|group| group.to_uv == after) {
            return;
        }
        commands.push(
            TextureEdit::PlaceTextures {
                owner: self.entity,
                before: self.now,
                after,
            }
            .into(),
        );
        self.now = after;
    }
}

/// The present surface at an anchor; None if the shape has gone from there.
fn again(packed: &PackedScene, screen: &Screen, anchor: &Anchor) -> Option<MappedSurface> {
    let step = 1e-3
        * screen
            .depth(anchor.place)
            .abs()
            .max(1e-2 * anchor.place.abs().max_element());
    let ray = Ray {
        t_max: 2.0,
        ..Ray::new(anchor.place + step * anchor.normal, -step * anchor.normal)
    };
    picking::mapped_surface(packed, &ray, |entity| entity != anchor.entity)
}

/// The visible point of a shape nearest to its middle. If the shape is covered, the nearest that would be visible.
fn central(packed: &PackedScene, screen: &Screen, entity: Entity) -> Option<MappedSurface> {
    /// The number of probed points along either side.
    const ACROSS: i32 = 9;
    let bounds = picking::bounds_of(packed, entity)?;
    let corners = (0..8).filter_map(|corner| {
        let pick = |axis: usize| {
            if corner >> axis & 1 == 0 {
                bounds.min[axis]
            } else {
                bounds.max[axis]
            }
        };
        screen.project(Vec3::new(pick(0), pick(1), pick(2)))
    });
    let mut seen = bevy_egui::egui::Rect::NOTHING;
    corners.for_each(|corner| seen.extend_with(corner));
    let seen = seen.intersect(screen.picture);
    if !seen.is_positive() {
        return None;
    }
    let middle = screen.project(bounds.center()).unwrap_or(seen.center());
    let share = |place: i32| (place as f32 + 0.5) / ACROSS as f32;
    let cells = (0..ACROSS * ACROSS).map(|cell| vec2(share(cell % ACROSS), share(cell / ACROSS)));
    let mut places: Vec<Pos2> = cells.map(|share| seen.min + share * seen.size()).collect();
    places.push(middle);
    places.sort_by(|a, b| a.distance(middle).total_cmp(&b.distance(middle)));
    let rays: Vec<Ray> = places
        .iter()
        .filter_map(|at| picking::narrowed(packed, &screen.ray(*at)))
        .collect();
    let visible = rays.iter().find_map(|ray| {
        let surface = picking::mapped_surface(packed, ray, |_| false);
        surface.filter(|surface| surface.entity == entity)
    });
    visible.or_else(|| {
        rays.iter()
            .find_map(|ray| picking::mapped_surface(packed, ray, |other| other != entity))
    })
}
