//! Drops of materials from the list or the library, and of files from the browser, onto the picture.

use std::path::Path;

use bevy::ecs::entity::EntityHashSet;
use bevy::math::Vec2;
use bevy::prelude::Entity;
use bevy_egui::egui::{self, Color32, Rect, Response, Ui};

use crate::app::editor::camera::picking;
use crate::app::editor::command::asset_kind::{AssetKind, FileUse};
use crate::app::editor::command::dragged::{Dragged, DraggedFile, DraggedPreset};
use crate::app::editor::command::{Command, MaterialEdit, SceneEdit, ShellCommand};
use crate::app::editor::model::Outline;
use crate::engine::PackedScene;

/// The data for drops on the picture.
#[derive(Clone, Copy, Debug)]
pub struct Takers<'a> {
    /// The packed scene, for picking.
    pub packed: &'a PackedScene,
    /// The outline, which knows the materials.
    pub things: &'a Outline,
    /// The locked entities, which take no material.
    pub locked: &'a EntityHashSet,
}

impl Takers<'_> {
    fn is_material(&self, things: &[Entity]) -> bool {
        let is_one = |thing: Entity| self.things.materials.iter().any(|item| item.entity == thing);
        matches!(things, [thing] if is_one(*thing))
    }

    /// The hint about the effect of a file dropped at a point of the picture.
    fn file_hint(&self, path: &Path, is_scene: bool, at: Vec2) -> String {
        match AssetKind::of(path) {
            _ if is_scene => "Add it to the scene, or open it".to_owned(),
            Some(AssetKind::Picture | AssetKind::Environment) if picking::pick(self.packed, at).is_none() => {
                "All around, as light".to_owned()
            }
            Some(AssetKind::Picture | AssetKind::Environment) => self.hint(at),
            Some(AssetKind::Lamp) => "The lamp will hang here".to_owned(),
            Some(AssetKind::Mesh | AssetKind::Volume) => "It will stand here".to_owned(),
            Some(AssetKind::Scene) | None => match picking::pick(self.packed, at) {
                Some(_) => format!("{}, if it is a material", self.hint(at)),
                None => "Add it to the scene".to_owned(),
            },
        }
    }

    /// The hint about the effect of a material dropped at a point of the picture.
    fn hint(&self, at: Vec2) -> String {
        let Some(shape) = picking::pick(self.packed, at) else {
            return "Drop it on a shape".to_owned();
        };
        let item = self.things.shapes.iter().find(|item| item.entity == shape);
        let name = item.map_or("this shape", |item| item.name.as_str());
        match self.locked.contains(&shape) {
            true => format!("{name} is locked"),
            false => format!("For {name}"),
        }
    }
}

/// Accepts drops. `picture` is the rectangle of the whole picture, and `response` is its response.
pub fn drop_target(ui: &Ui, response: &Response, picture: Rect, takers: Takers, commands: &mut Vec<Command>) {
    let Some(pointer) = ui.ctx().pointer_interact_pos() else {
        return;
    };
    let film = (pointer - picture.min) / picture.size();
    let at = Vec2::new(film.x, film.y);
    let hovers = response.dnd_hover_payload::<DraggedPreset>().is_some()
        || response
            .dnd_hover_payload::<Dragged>()
            .is_some_and(|dragged| takers.is_material(&dragged.0));
    let file = response.dnd_hover_payload::<DraggedFile>();
    let file_hint = file.map(|file| takers.file_hint(&file.file.path, file.is_scene, at));
    if let Some(hint) = file_hint.or_else(|| hovers.then(|| takers.hint(at))) {
        let font = egui::TextStyle::Body.resolve(ui.style());
        let text = ui.painter().layout_no_wrap(hint, font, Color32::WHITE);
        let place = Rect::from_min_size(pointer + egui::vec2(14.0, 10.0), text.size());
        ui.painter()
            .rect_filled(place.expand(4.0), 3.0, Color32::from_black_alpha(190));
        ui.painter().galley(place.min, text, Color32::WHITE);
    }
    // Asking for a payload of another type would remove it.
    let is_preset = egui::DragAndDrop::has_payload_of_type::<DraggedPreset>(ui.ctx());
    if is_preset && let Some(dragged) = response.dnd_release_payload::<DraggedPreset>() {
        let preset = Box::new(dragged.0.clone());
        commands.push(MaterialEdit::DropPreset { preset, at }.into());
        return;
    }
    let is_file = egui::DragAndDrop::has_payload_of_type::<DraggedFile>(ui.ctx());
    if is_file && let Some(dragged) = response.dnd_release_payload::<DraggedFile>() {
        let file = FileUse {
            at: Some(at),
            ..dragged.file.clone()
        };
        let file = Box::new(file);
        commands.push(match dragged.is_scene {
            true => Command::Shell(ShellCommand::AskAboutScene(file)),
            false => Command::from(SceneEdit::UseFile(file)),
        });
        return;
    }
    let dragged = response.dnd_release_payload::<Dragged>();
    if let Some([material]) = dragged.as_ref().map(|dragged| &dragged.0[..]) {
        commands.push(
            MaterialEdit::DropMaterial {
                material: *material,
                at,
            }
            .into(),
        );
    }
}

#[cfg(test)]
mod tests {
    use bevy::math::Vec3;

    use super::*;
    use crate::app::editor::camera::picking::tests::spheres;
    use crate::app::editor::model::Item;
    use crate::app::editor::picture::material_ball;

    #[test]
    fn the_hint_names_what_takes_it() {
        // The point that the camera of the material ball looks at.
        let (mut packed, balls) = spheres(&[Vec3::new(0.0, 0.0, 0.96)]);
        packed.view = Some(material_ball::view(16));
        let named = |entity: Entity, name: &str| Item {
            entity,
            name: name.to_owned(),
            kind: "thing",
            hidden: false,
            locked: false,
            can_hide: true,
            inside_of: None,
            uses: None,
            properties: None,
        };
        let (glass, lamp) = (Entity::from_raw_u32(7), Entity::from_raw_u32(8));
        let [glass, lamp] = [glass, lamp].map(|entity| entity.expect("a small index is valid"));
        let things = Outline {
            shapes: vec![named(balls[0], "ball")].into(),
            materials: vec![named(glass, "glass")].into(),
            lights: vec![named(lamp, "lamp")].into(),
            ..Outline::default()
        };
        let (none, locked) = (EntityHashSet::default(), EntityHashSet::from_iter([balls[0]]));
        let takers = |locked| Takers {
            packed: &packed,
            things: &things,
            locked,
        };
        let middle = Vec2::splat(0.5);
        assert_eq!(takers(&none).hint(middle), "For ball");
        assert_eq!(takers(&none).hint(Vec2::ZERO), "Drop it on a shape");
        assert!(takers(&none).is_material(&[glass]));
        assert!(!takers(&none).is_material(&[lamp]) && !takers(&none).is_material(&[glass, lamp]));
        assert_eq!(takers(&locked).hint(middle), "ball is locked");
        let hint = |file: &str, is_scene| takers(&none).file_hint(Path::new(file), is_scene, Vec2::ZERO);
        let of_file = |file: &str| hint(file, false);
        assert_eq!(of_file("sky.bmp"), "All around, as light");
        assert_eq!(of_file("chair.ply"), "It will stand here");
        assert_eq!(of_file("room.xml"), "Add it to the scene");
        assert_eq!(hint("room.xml", true), "Add it to the scene, or open it");
    }
}
