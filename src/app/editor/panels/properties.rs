//! The section of the inspector with the properties of things and of the scene: a row for each, and one for a new one.

use bevy_egui::egui::{self, Ui};

use super::caption::Caption;
use super::section::section;
use super::{color_field, component, fields};
use crate::app::editor::command::Command;
use crate::app::editor::command::properties::{PropertyChange, PropertyEdit, PropertyOwner};
use crate::app::editor::model::Model;
use crate::app::editor::model::difference::property_caption;
use crate::app::editor::model::game_types::GameTypes;
use crate::scene::{ItemType, Properties, PropertyItem, PropertyType, PropertyValue};

/// The width of the menu at the end of a row, in points.
const MENU: f32 = 22.0;

/// The property that is about to be added.
#[derive(Debug)]
pub(super) struct PropertiesState {
    name: String,
    kind: PropertyType,
}

impl Default for PropertiesState {
    fn default() -> Self {
        Self {
            name: String::new(),
            kind: PropertyType {
                item: ItemType::Integer,
                is_list: false,
            },
        }
    }
}

/// Shows the properties of the inspected thing, or of the scene. Edits are for all things of `owner`.
pub(super) fn properties_section(
    ui: &mut Ui,
    owner: PropertyOwner,
    model: &Model,
    state: &mut PropertiesState,
    commands: &mut Vec<Command>,
) {
    let inspected = model.inspected.as_ref().and_then(|shown| shown.properties.as_ref());
    let (title, properties) = match owner {
        PropertyOwner::Scene => ("Properties of the scene", &model.properties),
        PropertyOwner::Things(_) => ("Properties", inspected.unwrap_or(&model.properties)),
    };
    let mut edit = |name: &str, change| {
        commands.push(
            PropertyEdit {
                owner: owner.clone(),
                name: name.to_owned(),
                change,
            }
            .into(),
        );
    };
    section(ui, title, |ui| {
        for (name, value) in properties.iter() {
            ui.push_id(name, |ui| {
                if let Some(change) = property_row(ui, name, value, model) {
                    edit(name, change);
                }
            });
        }
        if let (PropertyOwner::Scene, Some(problem)) = (&owner, &model.game_types_problem) {
            let text = format!("The component types cannot be read: {problem}");
            ui.colored_label(ui.visuals().warn_fg_color, text);
        }
        if let Some(value) = new_row(ui, properties, model, state) {
            edit(state.name.trim(), PropertyChange::Set(value));
            state.name.clear();
        }
    });
}

/// One property: its value, and a menu with its name, its type and its end.
fn property_row(ui: &mut Ui, name: &str, value: &PropertyValue, model: &Model) -> Option<PropertyChange> {
    let mut change = None;
    ui.horizontal(|ui| {
        let room = egui::vec2(ui.available_width() - MENU, ui.spacing().interact_size.y);
        ui.allocate_ui_with_layout(room, egui::Layout::top_down(egui::Align::Min), |ui| {
            ui.set_width(room.x);
            change = edited(ui, name, value, model).map(PropertyChange::Set);
        });
        let menu = ui.menu_button("\u{2026}", |ui| {
            let mut new = name.to_owned();
            if fields::text(ui, "Name", &mut new) {
                change = Some(PropertyChange::Rename(new));
            }
            let mut kind = value.kind();
            if kind_choice(ui, "Type", &mut kind) {
                change = Some(PropertyChange::Set(converted(value, kind)));
            }
            if ui.button("Delete").clicked() {
                change = Some(PropertyChange::Remove);
                ui.close();
            }
        });
        menu.response
            .on_hover_text(format!("Name and type of the property {name}, or delete it"));
    });
    change
}

/// The value in another type: as the text says, or else that of a new property.
fn converted(value: &PropertyValue, kind: PropertyType) -> PropertyValue {
    let text = value.text();
    kind.parse(&text).unwrap_or_else(|_| kind.new_value())
}

fn kind_choice(ui: &mut Ui, caption: &str, kind: &mut PropertyType) -> bool {
    let kinds: Vec<(PropertyType, String)> = PropertyType::all().map(|kind| (kind, kind.label())).collect();
    let options: Vec<(PropertyType, &str)> = kinds.iter().map(|(kind, label)| (*kind, label.as_str())).collect();
    fields::choice(ui, caption, kind, &options)
}

/// The row with the value of a property; Some if edited.
fn edited(ui: &mut Ui, name: &str, value: &PropertyValue, model: &Model) -> Option<PropertyValue> {
    let mark = property_caption(name);
    let kind = value.kind();
    let about = format!("{name}: {}", kind.label());
    let caption = Caption::from((name, mark.as_str())).explained(&about);
    let PropertyValue::One(item) = value else {
        return edited_text(ui, caption.explained("The values, with ; between them"), value);
    };
    let mut item = item.clone();
    let changed = match &mut item {
        PropertyItem::Boolean(truth) => fields::checkbox(ui, caption, truth),
        PropertyItem::Integer(number) => fields::integer(ui, caption, number, i64::MIN..=i64::MAX),
        PropertyItem::Number(number) => {
            let speed = 0.01 * number.abs().max(1.0);
            fields::number(ui, caption, number, speed, f32::MIN..=f32::MAX)
        }
        PropertyItem::Vector(vector) => {
            let speed = 0.01 * vector.abs().max_element().max(1.0);
            fields::vector(ui, caption, vector, speed, "") && vector.is_finite()
        }
        PropertyItem::Color(color) => color_field::color(ui, caption, color),
        PropertyItem::Text(_) | PropertyItem::File(_) => return edited_text(ui, caption, value),
        PropertyItem::Component(json) => {
            let types = &*model.game_types;
            let known = serde_json::from_str(json).ok().filter(|_| types.knows(name));
            let Some(mut parts) = known else {
                return edited_text(ui, caption, value);
            };
            let short = name.rsplit("::").next().unwrap_or(name);
            let caption = caption.titled(short).explained(types.about(name).unwrap_or(name));
            let changed = component::rows(ui, types, name, caption, &mut parts);
            *json = parts.to_string();
            changed
        }
        PropertyItem::Reference(thing) => {
            let edited = edited_text(ui, caption, value);
            if !thing.is_empty() && !is_there(model, thing) {
                let text = format!("There is nothing called {thing}.");
                ui.colored_label(ui.visuals().warn_fg_color, text);
            }
            return edited;
        }
    };
    changed.then_some(PropertyValue::One(item))
}

/// A value as a text. One that cannot be read is not taken.
fn edited_text(ui: &mut Ui, caption: Caption, value: &PropertyValue) -> Option<PropertyValue> {
    let mut text = value.text();
    let changed = fields::text(ui, caption, &mut text);
    changed.then(|| value.kind().parse(&text).ok()).flatten()
}

fn is_there(model: &Model, name: &str) -> bool {
    let outline = &model.outline;
    let lists = [&outline.shapes, &outline.lights, &outline.sensors, &outline.materials];
    lists.into_iter().any(|list| list.iter().any(|item| item.name == name))
}

/// The row in which a new property gets its name and its type; Some once it is to be added.
fn new_row(ui: &mut Ui, known: &Properties, model: &Model, state: &mut PropertiesState) -> Option<PropertyValue> {
    fields::row(ui, "New property", |ui| {
        let width = ui.available_width() - 8.0;
        let field = egui::TextEdit::singleline(&mut state.name).hint_text("name");
        ui.add(field.desired_width(width))
    });
    let types = &*model.game_types;
    let mut components = types.components().peekable();
    if components.peek().is_some() {
        let mut chosen = "";
        let options: Vec<(&str, &str)> = components.map(|path| (path, path)).collect();
        if fields::choice(ui, "Component", &mut chosen, &options) && known.get(chosen).is_none() {
            state.name = chosen.to_owned();
            return Some(component_value(types, chosen));
        }
    }
    let name = Properties::checked_name(&state.name);
    if state.name.is_empty() {
        return None;
    }
    kind_choice(ui, "of type", &mut state.kind);
    let is_taken = name.as_ref().is_ok_and(|name| known.get(name).is_some());
    let can_add = name.is_ok() && !is_taken;
    let add = fields::buttons(ui, |ui| ui.add_enabled(can_add, egui::Button::new("Add property")));
    let why = match is_taken {
        true => "There is a property of this name already.",
        false => "This cannot be the name of a property.",
    };
    let is_asked = add.on_disabled_hover_text(why).clicked();
    is_asked.then(|| state.kind.new_value())
}

/// A new component of this type.
fn component_value(types: &GameTypes, path: &str) -> PropertyValue {
    let json = types.new_value(path).map(|value| value.to_string());
    PropertyValue::One(match json {
        Some(json) => PropertyItem::Component(json),
        None => ItemType::Component.new_item(),
    })
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use bevy::prelude::World;
    use egui_kittest::Harness;
    use egui_kittest::kittest::Queryable;

    use super::*;
    use crate::app::editor::model::Inspected;

    const SCHEMA: &str = r##"{"game::Door": {"typePath": "game::Door", "kind": "Struct", "reflectTypes": ["Component"],
        "properties": {"locked": {"type": {"$ref": "#/$defs/bool"}}}}}"##;

    #[test]
    fn fields_of_a_component_are_edited_as_rows() {
        let entity = World::new().spawn_empty().id();
        let types = GameTypes::read(SCHEMA).expect("a schema");
        let door = component_value(&types, "game::Door");
        let properties = Properties::default().with("game::Door", Some(door));
        let properties = properties.with("health", Some(PropertyValue::One(PropertyItem::Integer(3))));
        let model = Model {
            inspected: Some(Inspected {
                properties: Some(properties),
                ..Inspected::new(entity, "door")
            }),
            game_types: Arc::new(types),
            ..Model::default()
        };
        let mut harness = Harness::new_ui_state(
            move |ui, commands: &mut Vec<Command>| {
                let mut state = PropertiesState::default();
                properties_section(ui, PropertyOwner::Things(vec![entity]), &model, &mut state, commands);
            },
            Vec::new(),
        );
        harness.run_steps(4);
        assert_eq!(harness.state(), &Vec::<Command>::new());
        harness.get_by_label("health");
        harness
            .get_by_role_and_label(egui::accesskit::Role::CheckBox, "locked")
            .click();
        harness.run_steps(4);
        let json = PropertyItem::Component("{\"locked\":true}".to_owned());
        let expected = PropertyEdit {
            owner: PropertyOwner::Things(vec![entity]),
            name: "game::Door".to_owned(),
            change: PropertyChange::Set(PropertyValue::One(json)),
        };
        assert_eq!(harness.state().first(), Some(&Command::from(expected)));
    }
}
