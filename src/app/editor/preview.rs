//! Pictures of the materials in the inspector: rendered one after the other on a thread of the lowest priority, shown as they become
//! better, and begun anew when what they show changes.

use std::collections::HashMap;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use bevy::prelude::*;
use bevy_egui::{EguiContexts, egui};
use crossbeam_channel::{Receiver, Sender, unbounded};

use super::gather::EditorModel;
use super::studio::{Look, Studio};
use crate::engine::{CurrentScene, WakeUp, yield_to_all};
use crate::render::tonemap::Display;

/// Edge of a picture in pixels: sharp at twice the size it has in points.
const EDGE: u32 = 160;
/// Samples of a pixel: of the inspected material, and of those inside it, which are shown smaller.
const BEST: u32 = 128;
const ENOUGH: u32 = 32;
/// Of all of them, before any gets more.
const ROUGH: u32 = 4;
/// Pictures that are kept of what is not inspected any more, some 100 kB each.
const MOST: usize = 64;

struct Ball {
    look: Look,
    texture: egui::TextureHandle,
    samples: u32,
}

/// A picture under way.
struct Work {
    entity: Entity,
    look: Look,
    /// That it will have in the end.
    samples: u32,
    cancel: Arc<AtomicBool>,
    passes: Receiver<Pass>,
}

/// A picture that is better than the one before.
struct Pass {
    samples: u32,
    image: egui::ColorImage,
}

impl Drop for Work {
    fn drop(&mut self) {
        self.cancel.store(true, Ordering::Relaxed);
    }
}

#[derive(Resource, Default)]
pub struct Previews {
    balls: HashMap<Entity, Ball>,
    work: Option<Work>,
    /// Its thread ended before its time: trying again would do no good.
    given_up: Option<Look>,
}

/// Takes what has been rendered, and sees to it that the next picture that is wanted is.
pub fn update_previews(
    mut previews: ResMut<Previews>,
    mut model: ResMut<EditorModel>,
    mut contexts: EguiContexts,
    current: Res<CurrentScene>,
    wake_up: Res<WakeUp>,
) -> Result {
    let wanted = wanted(&model, &current);
    let finished = previews.take_passes(contexts.ctx_mut()?);
    let is_wanted = |work: &Work| {
        wanted
            .iter()
            .any(|(entity, look, _)| *entity == work.entity && *look == work.look)
    };
    if finished || previews.work.as_ref().is_some_and(|work| !is_wanted(work)) {
        previews.work = None;
    }
    for (entity, look, _) in &wanted {
        if let Some(ball) = previews.balls.get_mut(entity)
            && ball.look == *look
        {
            // So that the next comparison is that of two pointers.
            ball.look = look.clone();
        }
    }
    if previews.work.is_none() {
        let rough = wanted.iter().map(|(entity, look, _)| (entity, look, ROUGH));
        let fine = wanted.iter().map(|(entity, look, samples)| (entity, look, *samples));
        let next = rough.chain(fine).find(|&(entity, look, samples)| {
            let ball = previews.balls.get(entity);
            ball.is_none_or(|ball| ball.look != *look || ball.samples < samples)
                && previews.given_up.as_ref() != Some(look)
        });
        if let Some((entity, look, samples)) = next {
            previews.work = start(*entity, look.clone(), samples, wake_up.clone());
        }
    }
    if previews.balls.len() > MOST {
        previews
            .balls
            .retain(|entity, _| wanted.iter().any(|(known, ..)| known == entity));
    }
    let shown = wanted.iter().filter_map(|(entity, ..)| {
        let ball = previews.balls.get(entity)?;
        Some((*entity, ball.texture.id()))
    });
    model.0.looks.balls = shown.collect();
    Ok(())
}

/// The inspected materials with their samples, the most important first.
fn wanted(model: &EditorModel, current: &CurrentScene) -> Vec<(Entity, Look, u32)> {
    let Some(scene) = &current.scene else {
        return Vec::new();
    };
    let materials = model.0.inspected.iter().flat_map(|inspected| &inspected.materials);
    let looks = materials.enumerate().filter_map(|(place, material)| {
        let look = Look {
            materials: scene.materials.clone(),
            textures: scene.textures.clone(),
            material: *current.material_of_entity.get(&material.entity)?,
        };
        Some((material.entity, look, if place == 0 { BEST } else { ENOUGH }))
    });
    looks.collect()
}

impl Previews {
    /// True if there is nothing more to come.
    fn take_passes(&mut self, context: &egui::Context) -> bool {
        let Some(work) = &self.work else {
            return false;
        };
        let mut latest = None;
        let finished = loop {
            match work.passes.try_recv() {
                Ok(pass) => latest = Some(pass),
                Err(error) => break error.is_disconnected(),
            }
        };
        if let Some(Pass { samples, image }) = latest {
            let options = egui::TextureOptions::LINEAR;
            match self.balls.get_mut(&work.entity) {
                // A picture that is begun anew to become better takes over when it is.
                Some(ball) if ball.look == work.look && ball.samples >= samples => {}
                Some(ball) => {
                    ball.texture.set(image, options);
                    ball.look = work.look.clone();
                    ball.samples = samples;
                }
                None => {
                    let ball = Ball {
                        look: work.look.clone(),
                        texture: context.load_texture(format!("material {}", work.entity), image, options),
                        samples,
                    };
                    self.balls.insert(work.entity, ball);
                }
            }
        }
        let ball = self.balls.get(&work.entity);
        if finished && ball.is_none_or(|ball| ball.samples < work.samples) {
            self.given_up = Some(work.look.clone());
        }
        finished
    }
}

fn start(entity: Entity, look: Look, samples: u32, wake_up: WakeUp) -> Option<Work> {
    let cancel = Arc::new(AtomicBool::new(false));
    let (sender, passes) = unbounded();
    let (flag, shown) = (cancel.clone(), look.clone());
    let work = move || {
        yield_to_all();
        render(&shown, samples, &flag, &sender, &wake_up);
        // The channel is closed before the window looks again.
        drop(sender);
        wake(&wake_up);
    };
    match std::thread::Builder::new().name("preview".to_owned()).spawn(work) {
        Ok(_) => Some(Work {
            entity,
            look,
            samples,
            cancel,
            passes,
        }),
        Err(error) => {
            error!("A thread for the preview of a material could not be started: {error}");
            None
        }
    }
}

/// Twice as many samples in every pass as there are, until there are enough or nobody wants them any more.
fn render(look: &Look, samples: u32, cancel: &AtomicBool, passes: &Sender<Pass>, wake_up: &WakeUp) {
    let Some(studio) = Studio::new(look, EDGE) else {
        return;
    };
    let mut film = studio.film();
    let mut rgba = vec![0; (4 * EDGE * EDGE) as usize];
    while film.sample_count() < samples {
        let more = film.sample_count().max(1);
        if studio.refine(&mut film, more, cancel).is_none() {
            return;
        }
        Display::default().encode_rgba(&film.radiance(), &mut rgba);
        let size = [EDGE as usize; 2];
        let pass = Pass {
            samples: film.sample_count(),
            image: egui::ColorImage::from_rgba_unmultiplied(size, &rgba),
        };
        if passes.send(pass).is_err() {
            return;
        }
        wake(wake_up);
    }
}

fn wake(wake_up: &WakeUp) {
    if let Some(wake) = &wake_up.0 {
        wake();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::color::Rgb;
    use crate::material::{Material, MaterialId, MaterialTable};
    use crate::shading::{Bsdf, Diffuse};

    #[test]
    fn passes_double_and_end() {
        let paint = Material::Plain(Bsdf::Diffuse(Diffuse {
            reflectance: Rgb::splat(0.5),
        }));
        let look = Look {
            materials: Arc::new(MaterialTable::new(vec![paint]).expect("no circles")),
            textures: Arc::default(),
            material: MaterialId(0),
        };
        let entity = Entity::from_raw_u32(1).expect("a small index is valid");
        let work = start(entity, look, 4, WakeUp::default()).expect("a thread");
        let samples: Vec<u32> = work.passes.iter().map(|pass| pass.samples).collect();
        assert_eq!(samples, [1, 2, 4]);
    }
}
