//! Pictures of materials, of the scene and of the library. Those of the library are shipped with the program; the
//! user's own are cached between runs. All others are rendered one after the other on a thread of the lowest priority,
//! shown as they improve, and restarted when their material changes.

use std::collections::HashMap;
use std::sync::Arc;

use bevy::prelude::*;
use bevy::tasks::futures::check_ready;
use bevy::tasks::{AsyncComputeTaskPool, Task, TaskPool};
use bevy_egui::{EguiContexts, egui};

use super::preview_work::{Pass, Quality, ROUGH, Work, start, wake};
use super::widgets::Widgets;
use crate::app::editor::command::presets::Preset;
use crate::app::editor::model::panel_textures::Ball;
use crate::app::editor::model::{EditorModel, Model};
use crate::app::editor::picture::ball_picture;
use crate::app::editor::picture::material_ball::BallMaterial;
use crate::app::editor::picture::pacing::Pacing;
use crate::app::editor::session::picture_cache::PictureCache;
use crate::engine::{PackedScene, WakeUp};
use crate::render::tonemap::Display;
use crate::scene::{Declared, Material, Parameter, ParameterRef};

/// The quality for the inspected material, nested ones and those of the library; below for those in the list.
const BEST: Quality = Quality {
    edge: 160,
    samples: 128,
};
const INSIDE: Quality = Quality { edge: 96, samples: 64 };
const LIBRARY: Quality = Quality {
    edge: ball_picture::EDGE,
    samples: 128,
};
const LISTED: Quality = Quality { edge: 40, samples: 32 };
/// The number of pictures that are kept although they are no longer visible, some 100 kB each here and as much in the
/// graphics driver.
const MOST: usize = 128;

/// The rendered picture of a ball.
struct Picture {
    look: BallMaterial,
    texture: egui::TextureHandle,
    quality: Quality,
    /// Whether it is shipped with the program.
    is_shipped: bool,
}

#[derive(Resource, Default)]
pub struct Previews {
    pictures: HashMap<Ball, Picture>,
    presets: Looks,
    work: Option<Work>,
    /// The material whose thread ended early: another attempt would fail as well.
    given_up: Option<BallMaterial>,
    /// The library while it is being read.
    library: Option<Task<Library>>,
    /// Whether every visible picture has its final quality.
    are_done: bool,
}

/// The library's materials, in its order, with the keys of their cached pictures.
type Looks = Vec<(BallMaterial, Arc<str>)>;

/// The materials, and the shipped pictures, by key.
type Library = (Looks, HashMap<&'static str, egui::ColorImage>);

fn read_library(presets: &[Preset]) -> Library {
    let keys = presets.iter().map(|preset| ball_picture::key(preset).into());
    let looks = ball_picture::looks(presets).into_iter().zip(keys);
    (looks.collect(), ball_picture::shipped())
}

/// Takes the rendered passes, and starts the next picture.
pub fn update_previews(
    mut previews: ResMut<Previews>,
    mut model: ResMut<EditorModel>,
    mut contexts: EguiContexts,
    widgets: Res<Widgets>,
    packed: Res<PackedScene>,
    wake_up: Res<WakeUp>,
    pacing: Res<Pacing>,
    cache: Res<PictureCache>,
    materials: Query<&Material>,
) -> Result {
    previews.load_library(&model.0, contexts.ctx_mut()?, &wake_up);
    let wanted = wanted(&model.0, &widgets, &packed, &previews.presets);
    let finished = previews.take_passes(contexts.ctx_mut()?);
    let is_wanted = |work: &Work| {
        wanted
            .iter()
            .any(|wanted| wanted.ball == work.ball && wanted.look == work.look)
    };
    if finished || previews.work.as_ref().is_some_and(|work| !is_wanted(work)) {
        previews.work = None;
    }
    for Wanted { ball, look, .. } in &wanted {
        if let Some(picture) = previews.pictures.get_mut(ball)
            && picture.look == *look
        {
            // The next comparison then compares two pointers.
            picture.look = look.clone();
        }
    }
    if previews.work.is_none()
        && let Some((wanted, quality)) = previews.next(&wanted, pacing.rests())
    {
        let kept = wanted.key.clone().map(|key| (key, cache.clone()));
        previews.work = start(wanted.ball, wanted.look.clone(), quality, kept, wake_up.clone());
    }
    previews.are_done = previews.library.is_none() && previews.work.is_none() && previews.next(&wanted, true).is_none();
    previews.let_go(&packed, &wanted);
    model.0.textures.balls = previews.shown();
    let balls = &model.0.textures.balls;
    let pending = wanted.iter().filter(|wanted| !balls.contains_key(&wanted.ball));
    let colors = pending.filter_map(|Wanted { ball, .. }| match ball {
        Ball::Material(material) => Some((*ball, base_color(materials.get(*material).ok()?)?)),
        Ball::Preset(_) => None,
    });
    model.0.textures.colors = colors.collect();
    Ok(())
}

/// The first colour of a material's surface, if it is no texture.
fn base_color(material: &Material) -> Option<egui::Color32> {
    let mut found = None;
    material.visit(&mut |_, value| {
        if let (ParameterRef::Reflectance(Parameter::Constant(color)), None) = (value, found) {
            found = Some(*color);
        }
    });
    let [red, green, blue] = Display::default().encoder().encode(found?);
    Some(egui::Color32::from_rgb(red, green, blue))
}

/// A visible picture.
struct Wanted {
    ball: Ball,
    look: BallMaterial,
    quality: Quality,
    is_inspected: bool,
    /// The name of its picture in the cache.
    key: Option<Arc<str>>,
}

/// The pictures that panels show, the most important first.
fn wanted(model: &Model, widgets: &Widgets, packed: &PackedScene, presets: &Looks) -> Vec<Wanted> {
    let inspected = model.inspected.iter().flat_map(|inspected| &inspected.materials);
    let inspected = inspected
        .enumerate()
        .map(|(place, material)| (material.entity, if place == 0 { BEST } else { INSIDE }));
    let listed = widgets.outliner.materials_in_sight.iter();
    let of_scene = inspected.chain(listed.map(|&material| (material, LISTED)));
    let of_scene = of_scene.filter_map(|(entity, quality)| {
        let scene = packed.scene.as_ref()?;
        let look = BallMaterial {
            materials: scene.materials.clone(),
            textures: scene.textures.clone(),
            material: *packed.material_of_entity.get(&entity)?,
            inside: None,
        };
        let ball = Ball::Material(entity);
        Some(Wanted {
            ball,
            look,
            quality,
            is_inspected: quality != LISTED,
            key: None,
        })
    });
    let of_library = widgets.shelf.in_sight.iter().filter_map(|&place| {
        let (look, key) = presets.get(place)?.clone();
        let (ball, quality) = (Ball::Preset(place), LIBRARY);
        Some(Wanted {
            ball,
            look,
            quality,
            is_inspected: false,
            key: Some(key),
        })
    });
    of_scene.chain(of_library).collect()
}

impl Quality {
    fn reaches(self, other: Self) -> bool {
        self.edge >= other.edge && self.samples >= other.samples
    }
}

impl Previews {
    /// Whether no picture is being rendered or waits.
    pub fn are_done(&self) -> bool {
        self.are_done
    }

    /// Packs the library's materials, once, and loads the shipped pictures, on another thread: it takes longer than a
    /// frame.
    fn load_library(&mut self, model: &Model, context: &egui::Context, wake_up: &WakeUp) {
        if self.presets.len() == model.presets.len() {
            return;
        }
        let Some(library) = &mut self.library else {
            let (presets, wake_up) = (model.presets.clone(), wake_up.clone());
            let read = async move {
                let library = read_library(&presets);
                wake(&wake_up);
                library
            };
            self.library = Some(AsyncComputeTaskPool::get_or_init(TaskPool::default).spawn(read));
            return;
        };
        let Some((presets, mut shipped)) = check_ready(library) else {
            return;
        };
        (self.presets, self.library) = (presets, None);
        for (place, (look, key)) in self.presets.iter().enumerate() {
            let Some(image) = shipped.remove(&**key) else { continue };
            let ball = Ball::Preset(place);
            let picture = Picture {
                look: look.clone(),
                texture: context.load_texture(format!("{ball:?}"), image, egui::TextureOptions::LINEAR),
                quality: LIBRARY,
                is_shipped: true,
            };
            self.pictures.insert(ball, picture);
        }
    }

    /// Drops pictures of materials that are no longer in the scene: each keeps its tables alive, with their textures.
    fn let_go(&mut self, packed: &PackedScene, wanted: &[Wanted]) {
        self.pictures.retain(|ball, _| match ball {
            Ball::Material(entity) => packed.material_of_entity.contains_key(entity),
            Ball::Preset(_) => true,
        });
        let rendered = self.pictures.values().filter(|picture| !picture.is_shipped);
        if rendered.count() > MOST {
            self.pictures
                .retain(|ball, picture| picture.is_shipped || wanted.iter().any(|wanted| wanted.ball == *ball));
        }
    }

    /// All pictures, so that a panel that comes to the front has them in its first frame.
    fn shown(&self) -> HashMap<Ball, egui::TextureId> {
        let pictures = self.pictures.iter();
        pictures.map(|(&ball, picture)| (ball, picture.texture.id())).collect()
    }

    /// The next picture to render. Rough ones of all come before a fine one of any. While the user works, only pictures
    /// of the inspected material are rendered: the picture of the scene comes first.
    fn next<'w>(&self, wanted: &'w [Wanted], rests: bool) -> Option<(&'w Wanted, Quality)> {
        let rough = |wanted: &Wanted| Quality {
            samples: ROUGH,
            ..wanted.quality
        };
        let wanted = wanted.iter().filter(|wanted| rests || wanted.is_inspected);
        let rough = wanted.clone().map(|wanted| (wanted, rough(wanted)));
        let fine = wanted.map(|wanted| (wanted, wanted.quality));
        rough.chain(fine).find(|&(wanted, quality)| {
            let picture = self.pictures.get(&wanted.ball);
            picture.is_none_or(|picture| picture.look != wanted.look || !picture.quality.reaches(quality))
                && self.given_up.as_ref() != Some(&wanted.look)
        })
    }

    /// Takes finished passes; returns true if no more will come.
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
            let quality = Quality {
                samples,
                ..work.quality
            };
            let options = egui::TextureOptions::LINEAR;
            match self.pictures.get_mut(&work.ball) {
                // A picture that is rendered again for better quality replaces the old one when it is better.
                Some(picture) if picture.look == work.look && picture.quality.reaches(quality) => {}
                Some(picture) => {
                    picture.texture.set(image, options);
                    picture.look = work.look.clone();
                    picture.quality = quality;
                }
                None => {
                    let picture = Picture {
                        look: work.look.clone(),
                        texture: context.load_texture(format!("{:?}", work.ball), image, options),
                        quality,
                        is_shipped: false,
                    };
                    self.pictures.insert(work.ball, picture);
                }
            }
        }
        let picture = self.pictures.get(&work.ball);
        if finished && picture.is_none_or(|picture| !picture.quality.reaches(work.quality)) {
            self.given_up = Some(work.look.clone());
        }
        finished
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::editor::command::presets;
    use crate::app::editor::picture::material_ball::MaterialBall;

    fn with_presets(presets: Vec<Preset>) -> (Previews, Model) {
        let model = Model {
            presets: Arc::new(presets),
            ..Model::default()
        };
        let mut previews = Previews::default();
        let context = egui::Context::default();
        while previews.presets.len() < model.presets.len() {
            previews.load_library(&model, &context, &WakeUp::default());
            std::thread::yield_now();
        }
        (previews, model)
    }

    #[test]
    fn every_material_of_the_library_can_be_rendered() {
        let (previews, model) = with_presets(presets::built_in());
        assert_eq!(previews.presets.len(), model.presets.len());
        for ((look, _), preset) in previews.presets.iter().zip(model.presets.iter()) {
            assert!(MaterialBall::new(look, 8).is_some(), "{}", preset.path());
        }
    }

    #[test]
    fn the_library_is_there_at_once_and_only_what_differs_from_it_is_rendered() {
        let mut changed = presets::built_in();
        changed[3].tree = changed[3].tree.clone().wrapped("twosided").wrapped("mask");
        let (mut previews, model) = with_presets(changed);
        let mut widgets = Widgets::default();
        widgets.shelf.in_sight = (0..model.presets.len()).collect();
        let wanted = wanted(&model, &widgets, &PackedScene::default(), &previews.presets);
        let (next, _) = previews.next(&wanted, true).expect("one is missing");
        assert_eq!(next.ball, Ball::Preset(3));
        assert_eq!(previews.shown().len(), model.presets.len() - 1);
        // Shipped pictures stay when many others are shown, because they would have to be rendered then.
        previews.let_go(&PackedScene::default(), &[]);
        assert_eq!(previews.shown().len(), model.presets.len() - 1);
    }

    #[test]
    fn a_material_of_the_user_is_rendered_once() {
        let (previews, _) = with_presets(presets::built_in());
        let folder = tempfile::tempdir().expect("a temporary folder");
        let cache = PictureCache::in_folder(Some(folder.path().to_owned()));
        const QUALITY: Quality = Quality { edge: 16, samples: 8 };
        let passes = || {
            let kept = Some(("own".into(), cache.clone()));
            let look = previews.presets[0].0.clone();
            let work = start(Ball::Preset(0), look, QUALITY, kept, WakeUp::default()).expect("a thread");
            work.passes.iter().collect::<Vec<Pass>>()
        };
        let (rendered, taken) = (passes(), passes());
        assert!(rendered.len() > 1);
        let [only] = &taken[..] else {
            panic!("{} passes", taken.len())
        };
        assert_eq!(only.samples, QUALITY.samples);
        assert_eq!(Some(&only.image), rendered.last().map(|pass| &pass.image));
    }
}
