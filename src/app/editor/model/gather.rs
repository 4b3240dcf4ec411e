//! Fills the panels' [`Model`] from the world, once per frame. Lists are rebuilt only when an entry has changed.

use std::cmp::Reverse;
use std::collections::{HashMap, HashSet};
use std::path::Path;
use std::sync::{Arc, Weak};

use bevy::ecs::query::QueryData;
use bevy::ecs::system::SystemParam;
use bevy::prelude::*;

use super::leaks::Leaks;
use super::{
    ComparisonModel, EditorModel, HistoryModel, Item, MissingItem, Notice, Outline, PaintingModel, StatusModel,
};
use crate::app::editor::command::light_mix::LightMix;
use crate::app::editor::command::light_paint::LightPainting;
use crate::app::editor::command::preferences::Preferences;
use crate::app::editor::command::presets;
use crate::app::editor::command::tool::Tool;
use crate::app::editor::picture::awaited_image::AwaitedImage;
use crate::app::editor::picture::baking::Baking;
use crate::app::editor::picture::carrying::Carrying;
use crate::app::editor::picture::compare::Comparison;
use crate::app::editor::picture::denoiser::Denoiser;
use crate::app::editor::picture::frame_times::FrameTimes;
use crate::app::editor::picture::light_search::LampPlacing;
use crate::app::editor::picture::noise_trend::NoiseTrend;
use crate::app::editor::picture::texture::Picture;
use crate::app::editor::session::history::History;
use crate::app::editor::session::preferences::PreferencesFile;
use crate::app::editor::session::view_settings::ViewSettings;
use crate::app::editor::words::files::{self, SCENE_FILES};
use crate::document::{Diagnostic, Diagnostics, Severity};
use crate::engine::lamp_freedom::FreedomKind;
use crate::engine::{LightGroup, PackedScene, RenderControl, RenderFilm, RenderStatus};
use crate::scene::{
    AccelMethod, ActiveSensor, DocumentOrder, Emitter, Film, FirstNestedIn, Hidden, IntegratorSettings, LengthUnit,
    LightUnits, Locked, Medium, Properties, SamplerSettings, SceneId, SceneProperties, SceneState, SceneStatus,
    SecondNestedIn, Shape, ShapeKind, UsesMaterial,
};

/// The components that give a thing its name.
#[derive(QueryData)]
pub struct Naming {
    pub entity: Entity,
    order: Option<&'static DocumentOrder>,
    name: Option<&'static Name>,
    id: Option<&'static SceneId>,
    hidden: Has<Hidden>,
    locked: Has<Locked>,
    is_shape: Has<Shape>,
    is_emitter: Has<Emitter>,
    uses: Option<&'static UsesMaterial>,
    properties: Option<&'static Properties>,
    inside_first: Option<&'static FirstNestedIn>,
    inside_second: Option<&'static SecondNestedIn>,
}

impl NamingItem<'_, '_> {
    pub fn name(&self, kind: &str) -> String {
        match (self.name, self.id) {
            (Some(name), _) => name.as_str().to_owned(),
            (None, Some(id)) => id.0.clone(),
            (None, None) => kind.to_owned(),
        }
    }

    /// The first material that this one is nested in.
    fn outer(&self) -> Option<Entity> {
        let first = self.inside_first.and_then(|outer| outer.iter().next());
        first.or_else(|| self.inside_second.and_then(|outer| outer.iter().next()))
    }

    pub(super) fn item(&self, kind: &'static str) -> (u32, Item) {
        let order = self.order.map_or(u32::MAX, |order| order.0);
        let item = Item {
            entity: self.entity,
            name: self.name(kind),
            kind,
            hidden: self.hidden,
            locked: self.locked,
            can_hide: self.is_shape || self.is_emitter,
            inside_of: self.outer(),
            uses: self.uses.filter(|_| self.is_shape).map(|used| used.0),
            properties: self.properties.cloned(),
        };
        (order, item)
    }
}

pub fn shape_kind(shape: &Shape) -> &'static str {
    match shape.kind {
        ShapeKind::Sphere { .. } => "sphere",
        ShapeKind::Rectangle => "rectangle",
        ShapeKind::Cube => "cube",
        ShapeKind::Disk => "disk",
        ShapeKind::Triangle { .. } => "triangle",
        ShapeKind::Cylinder { .. } => "cylinder",
        ShapeKind::Solid(ref solid) => solid.plugin(),
        ShapeKind::Instance => "instance",
        ShapeKind::Frame => "group",
        ShapeKind::Mesh(_) if shape.is_of_curves() => "curves",
        ShapeKind::Mesh(_) => "mesh",
    }
}

/// The word for the kind of a medium in lists.
pub fn medium_kind(medium: &Medium) -> &'static str {
    let mut has_grid = false;
    medium.for_each_grid(&mut |_| has_grid = true);
    if has_grid { "volume" } else { "medium" }
}

/// Loads the library, once.
pub fn load_presets(mut model: ResMut<EditorModel>) {
    let (presets, complaints) = presets::load();
    for complaint in complaints {
        warn!("{complaint}");
    }
    model.0.presets = Arc::new(presets);
}

#[derive(SystemParam)]
pub struct Settings<'w, 's> {
    control: Res<'w, RenderControl>,
    integrator: Res<'w, IntegratorSettings>,
    sampler: Res<'w, SamplerSettings>,
    accel: Res<'w, AccelMethod>,
    unit: Res<'w, LengthUnit>,
    light_units: Res<'w, LightUnits>,
    properties: Res<'w, SceneProperties>,
    active: Res<'w, ActiveSensor>,
    films: Query<'w, 's, &'static Film>,
}

#[derive(SystemParam)]
pub struct PictureState<'w> {
    mix: Res<'w, LightMix>,
    painting: Option<Res<'w, LightPainting>>,
    /// The texture; None without a window.
    texture: Option<Res<'w, Picture>>,
    film: Res<'w, RenderFilm>,
    comparison: Res<'w, Comparison>,
    trend: Res<'w, NoiseTrend>,
    view: Res<'w, ViewSettings>,
    choices: Res<'w, Preferences>,
    awaited_image: Option<Res<'w, AwaitedImage>>,
    carrying: Option<Res<'w, Carrying>>,
    placing: Option<Res<'w, LampPlacing>>,
    packed: Res<'w, PackedScene>,
}

impl PictureState<'_> {
    fn painting(&self) -> PaintingModel {
        let Some(painting) = &self.painting else {
            return PaintingModel::default();
        };
        PaintingModel {
            tool_is_on: self.view.tool == Tool::PaintLight,
            brush: painting.brush,
            strokes: painting.strokes.clone(),
            picture: painting.picture.as_ref().map(|picture| {
                let name = picture.path.file_name().unwrap_or_default();
                name.to_string_lossy().into_owned()
            }),
            is_elsewhere: painting.is_elsewhere(&self.film),
            lamps: painting.lamps().to_vec(),
            answer: painting.answer.clone(),
            freedoms: Arc::default(),
            placing: self.placing.as_ref().and_then(|placing| placing.progress()),
            proposal: painting.proposal.clone(),
        }
    }

    /// What can change of each light with a layer.
    fn freedoms(&self) -> Arc<[(Entity, FreedomKind)]> {
        let lights = self.film.light_groups.iter().filter_map(|group| group.entities.first());
        lights.map(|&light| (light, self.packed.lamps.freedom(light))).collect()
    }

    fn lights(&self, outline: &Outline) -> Vec<(Entity, String)> {
        let names: HashMap<Entity, &str> = outline
            .lights
            .iter()
            .map(|item| (item.entity, item.name.as_str()))
            .collect();
        let named = |group: &LightGroup| {
            let light = *group.entities.first()?;
            let name = names.get(&light).copied().unwrap_or("light").to_owned();
            let name = match group.entities.len() {
                1 => name,
                many => format!("{name} and {} more", many - 1),
            };
            Some((light, name))
        };
        self.film.light_groups.iter().filter_map(named).collect()
    }
}

pub fn gather_status(
    mut model: ResMut<EditorModel>,
    settings: Settings,
    picture: PictureState,
    status: Res<RenderStatus>,
    scene: Res<SceneStatus>,
    denoiser: Res<Denoiser>,
    frames: Res<FrameTimes>,
    history: Res<History>,
    preferences: Res<PreferencesFile>,
    leaks: Res<Leaks>,
    baking: Option<Res<Baking>>,
    mut seen_errors: Local<Vec<String>>,
    mut named: Local<Option<(Arc<[LightGroup]>, Weak<Outline>)>>,
) {
    let model = &mut model.0;
    let film = settings.active.0.and_then(|sensor| settings.films.get(sensor).ok());
    let file_target = film.map_or(1, |film| film.sample_count);
    model.render.target_samples = settings.control.target_samples.unwrap_or(file_target);
    model.render.resolution_scale = settings.control.resolution_scale;
    model.render.resolution = picture.view.resolution;
    model.render.enlarging = picture.view.enlarging;
    model.render.integrator = *settings.integrator;
    model.render.sampler = *settings.sampler;
    model.render.accel = *settings.accel;
    model.unit = *settings.unit;
    model.light_units = *settings.light_units;
    if model.properties != settings.properties.0 {
        model.properties = settings.properties.0.clone();
    }
    model.up = picture.view.navigation.up;
    model.render.time_limit = settings.control.time_limit;
    let noise_target = settings
        .control
        .noise_target
        .or(film.and_then(|film| film.noise_target));
    model.render.noise_target = noise_target.filter(|noise| *noise > 0.0);
    let adaptive = settings.control.adaptive.or(film.map(|film| film.adaptive));
    model.render.adaptive = adaptive.unwrap_or(false);
    model.render.noise = status.noise;
    model.render.clamped = status.clamped;
    model.render.region = settings.control.region;
    model.render.strategy_split = settings.control.strategy_split;
    model.render.path_is_auto = settings.control.path_is_auto;
    model.render.auto = status.auto;
    let mixing = &mut model.render.mixing;
    mixing.is_on = settings.control.light_layers;
    if picture.mix.is_changed() {
        mixing.mix = picture.mix.clone();
    }
    let (groups, outline) = (&picture.film.light_groups, &model.outline);
    if !named
        .as_ref()
        .is_some_and(|(of, by)| Arc::ptr_eq(of, groups) && by.as_ptr() == Arc::as_ptr(outline))
    {
        mixing.lights = picture.lights(outline);
        *named = Some((groups.clone(), Arc::downgrade(outline)));
        model.render.painting.freedoms = picture.freedoms();
    }
    model.render.painting = PaintingModel {
        freedoms: std::mem::take(&mut model.render.painting.freedoms),
        ..picture.painting()
    };
    model.render.comparison = ComparisonModel {
        snapshot: picture.comparison.snapshot.as_ref().map(|snapshot| snapshot.samples),
        is_of_other_scene: picture.comparison.is_of_other_scene,
        view: picture.comparison.view,
        denoising: picture.view.denoising,
        figures: picture
            .comparison
            .figures
            .filter(|measured| measured.job == picture.film.job),
    };
    if scene.is_changed() && model.status.scene != scene.path {
        model.scene_files = Arc::new(scene_files(scene.path.as_deref()));
    }
    let failed_bake = baking.as_ref().and_then(|baking| baking.notice());
    let errors = || status.errors.iter().map(String::as_str).chain(failed_bake);
    if scene.is_changed() || preferences.is_changed() || leaks.is_changed() || !errors().eq(seen_errors.iter()) {
        *seen_errors = errors().map(str::to_owned).collect();
        model.missing = Arc::new(missing(&scene));
        model.notices = Arc::new(notices(&scene, &seen_errors, &preferences, &leaks.messages()));
    }
    if history.is_changed() {
        let (done, undone) = history.labels();
        let owned = |labels: Vec<&str>| labels.into_iter().map(str::to_owned).collect();
        model.history = Arc::new(HistoryModel {
            done: owned(done),
            undone: owned(undone),
        });
    }
    let seen = picture.texture.as_ref().and_then(|texture| texture.denoised());
    model.status = StatusModel {
        status: status.clone(),
        paused: settings.control.paused,
        scene: scene.path.clone(),
        unsaved: !history.is_saved(),
        being_saved: history.is_being_saved(),
        load_failed: scene.state == SceneState::Failed,
        denoiser: denoiser.state(picture.view.denoising, seen),
        is_carried_over: picture.carrying.is_some_and(|carrying| carrying.is_seen()),
        awaited_image: picture.awaited_image.as_deref().cloned(),
        is_full: settings.control.full_until_change,
        noise_trend: picture.trend.clone(),
        developer_figures: picture.choices.developer_figures,
        frame_ms: frames.median_ms(),
    };
}

/// The scenes in `scenes/` and those beside the open one.
fn scene_files(open: Option<&Path>) -> Vec<std::path::PathBuf> {
    let mut folders = vec![Path::new("scenes").to_path_buf()];
    folders.extend(open.and_then(Path::parent).map(Path::to_path_buf));
    let mut files: Vec<_> = folders
        .iter()
        .filter_map(|folder| std::fs::read_dir(folder).ok())
        .flatten()
        .filter_map(|entry| std::path::absolute(entry.ok()?.path()).ok())
        .filter(|path| {
            let extension = path.extension().unwrap_or_default();
            SCENE_FILES.iter().any(|known| extension.eq_ignore_ascii_case(known))
        })
        .collect();
    files.sort();
    files.dedup();
    files
}

fn missing(scene: &SceneStatus) -> Vec<MissingItem> {
    let all = scene.missing_files().filter_map(|problem| {
        Some(MissingItem {
            kind: problem.missing?,
            path: problem.path.clone(),
        })
    });
    let mut known = HashSet::new();
    all.filter(|item| known.insert(item.path.clone())).collect()
}

fn notices(
    scene: &SceneStatus,
    other_errors: &[String],
    preferences: &PreferencesFile,
    leaks: &[String],
) -> Vec<Notice> {
    let plain = |severity: Severity, text: &str| Notice {
        severity,
        place: None,
        text: text.to_owned(),
        help: None,
        excerpt: None,
    };
    let mut notices: Vec<Notice> = other_errors.iter().map(|error| plain(Severity::Error, error)).collect();
    notices.extend(
        preferences
            .problem
            .iter()
            .map(|problem| plain(Severity::Error, problem)),
    );
    notices.extend(
        scene
            .mesh_errors
            .iter()
            .chain(&scene.volume_errors)
            .map(|problem| Notice {
                help: problem.help.clone(),
                ..plain(Severity::Error, &problem.message)
            }),
    );
    let diagnostics = &scene.diagnostics;
    notices.extend(
        diagnostics
            .list
            .iter()
            .map(|diagnostic| notice(diagnostics, diagnostic)),
    );
    let damaged = scene.damaged_pictures.iter();
    notices.extend(damaged.map(|problem| plain(Severity::Error, &problem.message)));
    // A missing picture is a warning, as on the command line: the rest is worth seeing.
    let missing = scene.picture_problems.iter();
    let warnings = missing.chain(&scene.picture_warnings).chain(&scene.mesh_warnings);
    let warnings = warnings.chain(&scene.volume_warnings);
    notices.extend(warnings.map(|warning| plain(Severity::Warning, &warning.message)));
    notices.extend(
        scene
            .files_gone
            .iter()
            .map(|path| plain(Severity::Warning, &files::gone(path))),
    );
    notices.extend(leaks.iter().map(|leak| plain(Severity::Warning, leak)));
    notices.sort_by_key(|notice| Reverse(notice.severity));
    notices
}

fn notice(all: &Diagnostics, diagnostic: &Diagnostic) -> Notice {
    let place = diagnostic
        .span
        .and_then(|span| all.locate(span))
        .map(|(path, line, column)| {
            let file = path.file_name().unwrap_or_default().to_string_lossy();
            format!("{file}:{line}:{column}")
        });
    Notice {
        severity: diagnostic.severity,
        place,
        text: diagnostic.message.clone(),
        help: diagnostic.help.clone(),
        excerpt: all.excerpt(diagnostic),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::FileProblem;

    #[test]
    fn what_is_left_of_a_picture_is_a_warning_and_what_is_not_an_error() {
        let problem = |message: &str| {
            let message = message.to_owned();
            vec![FileProblem {
                message,
                ..FileProblem::default()
            }]
        };
        let scene = SceneStatus {
            damaged_pictures: problem("damaged"),
            picture_problems: problem("missing"),
            picture_warnings: problem("negative"),
            mesh_warnings: problem("duplicates"),
            ..SceneStatus::default()
        };
        let (preferences, _) = PreferencesFile::open(None);
        let notices = notices(&scene, &[], &preferences, &["leak".to_owned()]);
        let of_kind = |severity| {
            let all = notices.iter().filter(move |notice| notice.severity == severity);
            all.map(|notice| notice.text.as_str()).collect::<Vec<_>>()
        };
        assert_eq!(of_kind(Severity::Error), ["damaged"]);
        assert_eq!(
            of_kind(Severity::Warning),
            ["missing", "negative", "duplicates", "leak"]
        );
    }
}
