//! The panel with the sizes of the scene: counts, memory, and the things that cost rays most.

use std::collections::HashSet;
use std::sync::{Arc, Weak};

use bevy::prelude::Entity;
use bevy_egui::egui::{self, Button, RichText, Ui};

use super::fields;
use crate::accel::{Instance, Primitive, Tlas};
use crate::app::editor::command::selection::{Extend, Selection};
use crate::app::editor::command::{Command, SelectionCommand};
use crate::app::editor::model::Outline;
use crate::app::editor::words::figures::grouped;
use crate::app::editor::words::files::size_text;
use crate::engine::PackedScene;
use crate::render::scene::RenderScene;

/// The number of costly things that are listed.
const LISTED: usize = 12;
/// The least share of the work that is listed.
const LEAST_SHARE: f64 = 0.005;

/// The figures of a geometry, which are computed once for it.
#[derive(Debug, Default)]
pub struct StatisticsState {
    geometry: Weak<Tlas>,
    figures: Figures,
}

#[derive(Debug, Default)]
struct Figures {
    shapes: usize,
    meshes: usize,
    /// The triangles of the meshes, each mesh once.
    kept_triangles: u64,
    /// The things with the largest shares of the expected work, the largest first.
    costly: Vec<(Entity, f64)>,
}

impl Figures {
    fn of(geometry: &Tlas, entities: &[Entity]) -> Self {
        let groups = geometry.groups().iter();
        let shapes = || {
            geometry
                .instances()
                .iter()
                .chain(groups.clone().flat_map(|group| group.instances().iter()))
        };
        let (mut meshes, mut kept_triangles) = (HashSet::new(), 0);
        for Instance { primitive, .. } in shapes() {
            if let Primitive::Mesh(blas) = primitive
                && meshes.insert(Arc::as_ptr(blas))
            {
                kept_triangles += blas.mesh().triangles.len() as u64;
            }
        }
        let work = geometry.work_of_items();
        let all: f64 = work.iter().sum();
        let mut costly: Vec<(Entity, f64)> = entities
            .iter()
            .zip(&work)
            .map(|(entity, work)| (*entity, work / all))
            .filter(|(_, share)| *share >= LEAST_SHARE)
            .collect();
        costly.sort_by(|one, other| other.1.total_cmp(&one.1));
        costly.truncate(LISTED);
        Self {
            shapes: geometry.instances().len() + geometry.placements().len(),
            meshes: meshes.len(),
            kept_triangles,
            costly,
        }
    }
}

impl StatisticsState {
    fn figures(&mut self, scene: &RenderScene, entities: &[Entity]) -> &Figures {
        let geometry = Arc::downgrade(&scene.geometry);
        if !self.geometry.ptr_eq(&geometry) {
            self.figures = Figures::of(&scene.geometry, entities);
            self.geometry = geometry;
        }
        &self.figures
    }
}

/// Shows the figures; a click on a costly thing selects it. `memory` is the reserved part of the budget and the budget,
/// in bytes.
pub fn statistics(
    ui: &mut Ui,
    packed: &PackedScene,
    things: &Outline,
    selection: &Selection,
    memory: [u64; 2],
    state: &mut StatisticsState,
    commands: &mut Vec<Command>,
) {
    let Some(scene) = &packed.scene else {
        ui.weak("No scene is loaded.");
        return;
    };
    let figures = state.figures(scene, &packed.entity_of_instance);
    fields::note(ui, "Shapes", grouped(figures.shapes as u64));
    fields::note(ui, "Triangles", grouped(scene.geometry.triangles()));
    let noun = if figures.meshes == 1 { "mesh" } else { "meshes" };
    let [kept, meshes] = [figures.kept_triangles, figures.meshes as u64].map(grouped);
    let kept = format!("{kept} in {meshes} {noun}");
    fields::note(ui, "In memory", kept);
    fields::note(ui, "Hierarchies", size_text(scene.geometry.bytes() as u64));
    fields::note(ui, "Materials", grouped(things.materials.len() as u64));
    let (pictures, bytes) = scene.textures.pictures();
    fields::note(
        ui,
        "Pictures",
        format!("{}, {}", grouped(pictures as u64), size_text(bytes)),
    );
    fields::note(ui, "Lights", grouped(scene.lights.len() as u64));
    fields::note(ui, "Media", grouped(things.media.len() as u64));
    let [reserved, limit] = memory.map(size_text);
    fields::note(ui, "Memory", format!("{reserved} of {limit}"));
    ui.add_space(6.0);
    ui.label(RichText::new("Costly to trace").strong()).on_hover_text(
        "Shares of the work that a ray through the scene is expected to have within each thing, by the surface area heuristic",
    );
    if figures.costly.is_empty() {
        ui.weak("Nothing stands out.");
    }
    for (entity, share) in &figures.costly {
        let Some(place) = things.shapes.place_of(*entity) else {
            continue;
        };
        let text = format!("{:>4.0} %  {}", 100.0 * share, things.shapes[place].name);
        let size = egui::vec2(ui.available_width(), ui.spacing().interact_size.y);
        let line = Button::selectable(selection.contains(*entity), text)
            .truncate()
            .min_size(size);
        if ui.add(line).on_hover_text("Selects it").clicked() {
            commands.push(SelectionCommand::Select(vec![*entity], Extend::Replace).into());
        }
    }
}
