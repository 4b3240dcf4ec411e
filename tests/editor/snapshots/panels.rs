//! The panels beside and below the picture.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};

use bevy::math::{Affine3A, Quat, UVec2, Vec2, Vec3};
use bevy_egui::egui::Ui;
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use image::RgbImage;
use sunroom::accel::{Blas, Instance, Primitive, SplitMethod, Tlas};
use sunroom::app::editor::command::asset_kind::AssetKind;
use sunroom::app::editor::command::baking::BakeChoices;
use sunroom::app::editor::command::bvh_overlay::BvhOverlay;
use sunroom::app::editor::command::compare_view::CompareView;
use sunroom::app::editor::command::display::DisplaySettings;
use sunroom::app::editor::command::inspected_paths::InspectedPaths;
use sunroom::app::editor::command::key_bindings::NO_BINDINGS;
use sunroom::app::editor::command::light_mix::LightMix;
use sunroom::app::editor::command::light_paint::{Answer, Brush, LampChoice, Placement, Proposal};
use sunroom::app::editor::command::meter_choice::MeterChoice;
use sunroom::app::editor::command::presets;
use sunroom::app::editor::command::resolution::Resolution;
use sunroom::app::editor::command::selection::Selection;
use sunroom::app::editor::command::timeline::Timeline;
use sunroom::app::editor::model::assets::{AssetEntry, AssetPicture, AssetPlace, AssetsModel, Listing};
use sunroom::app::editor::model::baking::{BakeModel, ShownBake};
use sunroom::app::editor::model::timeline::{Tick, TickTime, Ticks, TimelineModel, values_of};
use sunroom::app::editor::model::{
    ComparisonModel, HistoryModel, MixingModel, Model, Notice, PaintingModel, RenderModel, StatusModel,
};
use sunroom::app::editor::panels;
use sunroom::app::editor::panels::assets::AssetsState;
use sunroom::app::editor::panels::library::LibraryState;
use sunroom::app::editor::panels::outliner::state::OutlinerState;
use sunroom::app::editor::panels::statistics::StatisticsState;
use sunroom::app::editor::panels::timeline::TimelineState;
use sunroom::app::editor::picture::baking::thread::BakeNews;
use sunroom::app::editor::picture::denoiser::DenoiserState;
use sunroom::app::editor::picture::lamp_light::{LampFollower, LampLight, Receiver};
use sunroom::app::editor::picture::metering::{ShownMeter, ShownMeters};
use sunroom::app::editor::picture::paths::PathInspector;
use sunroom::app::editor::picture::reasons::{Explanation, NamedPortion, Reasons};
use sunroom::bake::progress::{Progress, Stage};
use sunroom::color::Rgb;
use sunroom::document::{Interpolation, Key, Severity, Track, Value};
use sunroom::engine::lamp_freedom::{FreedomKind, LampFreedom};
use sunroom::engine::reasons::{Group, Lamp, Via};
use sunroom::engine::{PackedScene, RenderState, RenderStatus};
use sunroom::geometry::primitives::unit_cube;
use sunroom::meter::estimate::{Estimate, GridEstimate};
use sunroom::meter::glare::Glare;
use sunroom::meter::job::MeterReading;
use sunroom::meter::sites::MeterLimits;
use sunroom::render::breakdown::{Advice, Area, Destination, Portion, Trouble};
use sunroom::render::scene::RenderScene;
use sunroom::scene::KeyPath;

use super::panel;
use super::scene::{entity, model};

/// What the window gives the panels at the left, and those at the right, at first.
const LEFT: u32 = 218;
const RIGHT: u32 = 330;

fn in_a_state<T: Clone + Default + Send + 'static, S: Default + Send + 'static>(
    size: [u32; 2],
    given: T,
    show: impl Fn(&mut Ui, &T, &mut S) + Clone + 'static,
) -> RgbImage {
    let state = Arc::new(Mutex::new(S::default()));
    let show = move |ui: &mut Ui, given: &mut T| show(ui, given, &mut state.lock().expect("one thread"));
    panel(size, given, show, |_| ())
}

/// A point that fails, and a grid that passes.
pub fn meter() -> RgbImage {
    let estimate = |value: f64, error: f64| Estimate { value, error };
    let reading = |name: &str, size: UVec2, limits: MeterLimits| MeterReading {
        name: name.to_owned(),
        size,
        positions: vec![bevy::math::Vec3::ZERO; (size.x * size.y) as usize],
        normal: bevy::math::Vec3::Y,
        points: (0..size.x * size.y)
            .map(|number| estimate(430.0 + 9.0 * f64::from(number % 13), 2.0))
            .collect(),
        grid: None,
        limits,
        samples: 2048,
        is_buried: false,
    };
    let of_shelf = MeterLimits {
        least: Some(500.0),
        ..MeterLimits::default()
    };
    let of_desk = MeterLimits {
        mean: Some(450.0),
        uniformity: Some(0.6),
        ..MeterLimits::default()
    };
    let desk = MeterReading {
        grid: Some(GridEstimate {
            least: estimate(430.0, 2.4),
            mean: estimate(484.1, 0.4),
            uniformity: Some(estimate(0.888, 0.005)),
            darkest: 0,
        }),
        ..reading("desk", UVec2::new(8, 4), of_desk)
    };
    let shown = [Some(reading("shelf", UVec2::ONE, of_shelf)), Some(desk), None];
    let meters = shown.into_iter().enumerate().map(|(number, reading)| ShownMeter {
        entity: entity(number as u32),
        name: ["shelf", "desk", "window sill"][number].to_owned(),
        reading,
    });
    let shown = ShownMeters {
        meters: meters.collect(),
        is_measuring: true,
        error: None,
        choice: MeterChoice {
            daylight: false,
            glare: true,
        },
        up: None,
        glare: Some(Glare {
            rating: Some(estimate(16.3, 0.2)),
            background: estimate(31.0, 0.2),
            threshold: 240.0,
            solid_angle: 0.08,
        }),
    };
    in_a_state([RIGHT, 470], shown, |ui, shown: &ShownMeters, _: &mut ()| {
        panels::meter::meter(ui, shown, &Selection::default(), &mut Vec::new());
    })
}

/// A floor and a wall without meshes, and a bunny of one mesh twice, once near and once far away.
pub fn statistics() -> RgbImage {
    let blas = Arc::new(Blas::build(Arc::new(unit_cube()), SplitMethod::Sah));
    let square = |size: f32| (Primitive::Rectangle, Affine3A::from_scale(Vec3::splat(size)));
    let cube = |size: f32, x: f32| {
        let pose = Affine3A::from_scale_rotation_translation(Vec3::splat(size), Quat::IDENTITY, Vec3::X * x);
        (Primitive::Mesh(blas.clone()), pose)
    };
    let shapes = [square(6.0), square(5.0), cube(2.0, 0.0), cube(0.5, 4.0)];
    let instances = shapes.map(|(primitive, pose)| Instance::new(primitive, pose).expect("a good pose"));
    let packed = Arc::new(PackedScene {
        scene: Some(RenderScene {
            media: Arc::default(),
            geometry: Arc::new(Tlas::build(instances.into(), SplitMethod::Sah)),
            surfaces: Arc::default(),
            materials: Arc::default(),
            textures: Arc::default(),
            lights: Arc::default(),
            reach: Default::default(),
        }),
        entity_of_instance: [1, 2, 8, 7].map(entity).into(),
        ..PackedScene::default()
    });
    let show = move |ui: &mut Ui, model: &Model, state: &mut StatisticsState| {
        let memory = [210 << 20, 18 << 30];
        panels::statistics::statistics(
            ui,
            &packed,
            &model.outline,
            &model.selection,
            memory,
            state,
            &mut Vec::new(),
        );
    };
    in_a_state([RIGHT, 330], model(), show)
}

pub fn outliner() -> RgbImage {
    in_a_state([LEFT, 620], model(), |ui, model: &Model, state: &mut OutlinerState| {
        panels::outliner::outliner(ui, model, state, &mut Vec::new());
    })
}

fn render_model() -> RenderModel {
    RenderModel {
        target_samples: 256,
        resolution_scale: 1.0,
        resolution: Resolution::default(),
        noise: Some(0.083),
        time_limit: Some(600.0),
        ..RenderModel::default()
    }
}

fn render_panel(width: u32, model: RenderModel, act: impl Fn(&mut Harness<RenderModel>)) -> RgbImage {
    let show = |ui: &mut Ui, model: &mut RenderModel| {
        let (display, overlay) = (DisplaySettings::default(), BvhOverlay::default());
        panels::render::render(ui, model, display, overlay, &mut Vec::new());
    };
    panel([width, 2000], model, show, act)
}

fn open<T>(harness: &mut Harness<T>, name: &str) {
    harness.get_by_label(name).click();
    harness.run_steps(3);
}

pub fn render() -> RgbImage {
    render_panel(RIGHT, render_model(), |_| ())
}

pub fn render_of_layers() -> RgbImage {
    render_panel(RIGHT, render_model(), |harness| open(harness, "Layers"))
}

/// Words of switches that have no room are cut off.
pub fn render_in_a_narrow_panel() -> RgbImage {
    render_panel(180, render_model(), |_| ())
}

pub fn mixing_and_comparison() -> RgbImage {
    let lights = [(51, "reading lamp"), (52, "bulb")];
    let model = RenderModel {
        mixing: MixingModel {
            is_on: true,
            mix: LightMix::default(),
            lights: lights.map(|(light, name)| (entity(light), name.to_owned())).into(),
        },
        comparison: ComparisonModel {
            snapshot: Some(64),
            is_of_other_scene: false,
            view: CompareView::Off,
            denoising: true,
            figures: None,
        },
        ..render_model()
    };
    render_panel(RIGHT, model, |_| ())
}

pub fn light_painting() -> RgbImage {
    let colored = LampChoice {
        colored: true,
        most: 4.0,
        freedom: LampFreedom {
            radius: 0.5,
            turn: 30.0,
            ..LampFreedom::default()
        },
        ..LampChoice::default()
    };
    let fixed = LampChoice {
        chosen: false,
        freedom: LampFreedom {
            hours: Some([9.0, 17.0]),
            ..LampFreedom::default()
        },
        ..LampChoice::default()
    };
    let proposal = Proposal {
        placements: vec![(entity(51), Placement::Pose(Affine3A::IDENTITY))],
        notes: vec![
            "The error becomes 3.1 % in place of 11.9 %.".to_owned(),
            "reading lamp moves by 0.412 and turns by 21.5°.".to_owned(),
            "sky stands as at 14:35 on 2010-07-10.".to_owned(),
        ],
        ..Proposal::default()
    };
    let freedoms = [FreedomKind::Pose, FreedomKind::Place, FreedomKind::Sun];
    let model = PaintingModel {
        picture: Some("wanted.exr".to_owned()),
        freedoms: (51..).map(entity).zip(freedoms).collect(),
        proposal: Some(Arc::new(proposal)),
        strokes: [Brush::default().stroke(vec![Vec2::splat(0.5)])].into(),
        lamps: vec![(entity(51), colored), (entity(53), fixed)],
        answer: Some(Arc::new(Answer {
            notes: vec![
                "Stroke 1 (brighter 2) is missed by 12 %.".to_owned(),
                "reading lamp is at its upper limit, 4.".to_owned(),
            ],
            milliseconds: 5.0,
        })),
        ..PaintingModel::default()
    };
    let show = |ui: &mut Ui, model: &mut PaintingModel| {
        let lights = [(51, "reading lamp"), (52, "bulb"), (53, "sky")];
        let lights = lights.map(|(light, name)| (entity(light), name.to_owned()));
        panels::light_painting::light_painting(ui, model, &lights, &mut Vec::new());
    };
    panel([RIGHT, 860], model, show, |_| ())
}

pub fn library() -> RgbImage {
    let model = Model {
        presets: Arc::new(presets::built_in()),
        ..model()
    };
    in_a_state([LEFT, 1000], model, |ui, model: &Model, state: &mut LibraryState| {
        panels::library::library(ui, model, state, &mut Vec::new());
    })
}

pub fn assets() -> RgbImage {
    let entry = |(name, bytes): (&str, u64)| {
        let path = Path::new("/assets").join(name);
        AssetEntry {
            name: name.to_owned(),
            kind: AssetKind::of(&path),
            path,
            bytes,
            modified: None,
        }
    };
    let entries = [
        ("inner", 0),
        ("bunny.ply", 3_033_195),
        ("broken.png", 12),
        ("room.xml", 4_096),
        ("sky over the harbour.hdr", 6_400_000),
        ("smoke.vol", 1_048_624),
        ("wood.png", 812_000),
    ];
    let picture = |name: &str, note: &str, problem: Option<&str>| {
        let picture = AssetPicture {
            note: note.to_owned(),
            problem: problem.map(str::to_owned),
            ..AssetPicture::default()
        };
        (Path::new("/assets").join(name), picture)
    };
    let pictures = [
        picture("bunny.ply", "69,451 triangles", None),
        picture("broken.png", "", Some("not a picture in a known format")),
        picture("wood.png", "1024 × 1024", None),
    ];
    let model = Model {
        assets: AssetsModel {
            places: Arc::new(vec![AssetPlace {
                name: "Mine".to_owned(),
                folder: "/assets".into(),
                is_own: true,
            }]),
            listing: Some(Arc::new(Listing {
                folder: "/assets".into(),
                entries: entries.map(entry).into(),
                problem: None,
            })),
            pictures: Arc::new(HashMap::from(pictures)),
            environments: Arc::default(),
        },
        ..model()
    };
    in_a_state([RIGHT, 460], model, |ui, model: &Model, state: &mut AssetsState| {
        state.folder = Some("/assets".into());
        panels::assets::assets(ui, model, state, &mut Vec::new());
    })
}

pub fn history() -> RgbImage {
    let model = HistoryModel {
        done: vec!["Add: floor".into(), "Move: floor".into(), "Material: oak".into()],
        undone: vec!["Hide: ceiling".into()],
    };
    let show = |ui: &mut Ui, model: &mut HistoryModel| panels::history::history(ui, model, &mut Vec::new());
    panel([RIGHT, 200], model, show, |_| ())
}

pub fn messages() -> RgbImage {
    let notices = vec![
        Notice {
            severity: Severity::Error,
            place: Some("flat.xml:12:5".into()),
            text: "unknown plugin `glas`".into(),
            help: Some("did you mean `dielectric`?".into()),
            excerpt: Some("12 | <bsdf type=\"glas\">\n     ^^^^".into()),
        },
        Notice {
            severity: Severity::Warning,
            place: Some("flat.xml:40:9".into()),
            text: "the picture `textures/worn.png` is not there".into(),
            help: None,
            excerpt: None,
        },
        Notice {
            severity: Severity::Note,
            place: None,
            text: "rotations are read as degrees".into(),
            help: None,
            excerpt: None,
        },
    ];
    let show = |ui: &mut Ui, notices: &mut Vec<Notice>| panels::diagnostics::diagnostics(ui, notices);
    panel([RIGHT, 320], notices, show, |_| ())
}

pub fn paths() -> RgbImage {
    let show = |ui: &mut Ui, (): &mut ()| {
        panels::paths::paths(
            ui,
            &PathInspector::default(),
            &Reasons::default(),
            &LampFollower::default(),
            &mut Vec::new(),
        )
    };
    panel([RIGHT, 120], (), show, |_| ())
}

/// The light of a rectangle, of which the part that came by way of a wall is chosen.
pub fn reasons() -> RgbImage {
    let portion = |key, share: f32, noise| Portion {
        key,
        light: Rgb::splat(0.2 * share),
        luminance: 0.2 * share,
        error: 0.002 * share,
        share,
        share_error: 0.03 * share,
        noise,
    };
    let [lamp, wall, sky, window] = [1, 2, 3, 4].map(entity);
    let by_wall = Group::Route(Lamp::Thing(lamp), Via::Thing(wall));
    let names = [
        (lamp, "desk lamp"),
        (wall, "red wall"),
        (sky, "sky"),
        (window, "window-2"),
    ];
    let name = |entity| {
        let known = names.iter().find(|(one, _)| *one == entity);
        known.map_or("?", |(_, name)| name).to_owned()
    };
    let routes = [
        (by_wall, 0.41, 0.62),
        (Group::Route(Lamp::Thing(sky), Via::Pane(window)), 0.22, 0.3),
        (Group::Route(Lamp::Thing(lamp), Via::Straight), 0.21, 0.02),
        (Group::Route(Lamp::Thing(sky), Via::Thing(wall)), 0.159, 0.06),
        (Group::Route(Lamp::Sun(sky), Via::Other), 0.001, 0.0),
    ];
    let routes = routes.map(|(key, share, noise)| NamedPortion {
        portion: portion(key, share, noise),
        words: key.words(&name),
    });
    let known = Explanation {
        value: portion_of_all(),
        groupings: vec![routes.to_vec()],
        advice: vec![Advice {
            trouble: Trouble::Interreflection,
            noise: 0.68,
        }],
        samples: 65_536,
        is_final: true,
    };
    let mut inspector = PathInspector::default();
    inspector.wanted = Some(InspectedPaths {
        of: Some(by_wall),
        ..InspectedPaths::between([Vec2::splat(0.4), Vec2::splat(0.5)])
    });
    inspector.area = Some(Area {
        x: 300,
        y: 200,
        width: 64,
        height: 48,
    });
    let mut reasons = Reasons::default();
    reasons.explanation = Some(Arc::new(known));
    let given = (Arc::new(inspector), Arc::new(reasons));
    let show = |ui: &mut Ui, (inspector, reasons): &mut (Arc<PathInspector>, Arc<Reasons>)| {
        panels::paths::paths(ui, inspector, reasons, &LampFollower::default(), &mut Vec::new());
    };
    panel([RIGHT, 400], given, show, |_| ())
}

/// The things at which the light of a lamp stays, while another lamp is selected.
pub fn lamp_light() -> RgbImage {
    let receivers = [
        ("floor", 0.42, 600.0),
        ("red wall", 0.23, 300.0),
        ("desk", 0.0015, 12.0),
    ];
    let mut follower = LampFollower::default();
    follower.name = "desk lamp".to_owned();
    follower.lamp = Some(entity(1));
    follower.selected = Some((entity(2), "ceiling lamp".to_owned()));
    follower.light = Some(Arc::new(LampLight {
        emitted: [1.2, 0.003],
        escaped: [0.3485, 0.004],
        receivers: receivers
            .map(|(name, share, lumens)| Receiver {
                destination: Destination {
                    key: Some(entity(3)),
                    received: lumens / 683.0,
                    received_error: 0.01 * lumens / 683.0,
                    share,
                    share_error: 0.012,
                },
                name: name.to_owned(),
            })
            .to_vec(),
    }));
    let show = |ui: &mut Ui, follower: &mut Arc<LampFollower>| {
        let reasons = Reasons::default();
        panels::paths::paths(ui, &PathInspector::default(), &reasons, follower, &mut Vec::new());
    };
    panel([RIGHT, 260], Arc::new(follower), show, |_| ())
}

fn portion_of_all() -> Portion<()> {
    Portion {
        key: (),
        light: Rgb::splat(0.2),
        luminance: 0.2,
        error: 0.002,
        share: 1.0,
        share_error: 0.0,
        noise: 1.0,
    }
}

pub fn timeline() -> RgbImage {
    let names = ["to_world", "emitter.radiance", "radius"];
    let values: Vec<_> = names.into_iter().map(|name| (entity(1), KeyPath::new(name))).collect();
    let tick = |(time, values): (f64, &[_])| {
        let values = values.to_vec();
        (TickTime(time), Tick { values })
    };
    let selected = [(0.0, &values[..]), (1.0, &values[..1]), (1.8, &values[1..])];
    let selected: Ticks = selected.into_iter().map(tick).collect();
    let track = |times: &[f64]| {
        let key = |time: &f64| Key {
            time: *time,
            value: Value::Float(1.0),
        };
        Arc::new(Track {
            keys: times.iter().map(key).collect(),
            interpolation: Interpolation::Linear,
        })
    };
    let tracks = [&[0.0, 1.0][..], &[0.0, 1.8], &[0.0, 1.8]];
    let tracks = values
        .iter()
        .zip(tracks)
        .map(|((_, path), times)| (path.clone(), track(times)));
    let model = TimelineModel {
        frames: Timeline {
            fps: 24.0,
            first: 0,
            last: 48,
        },
        time: 0.75,
        all: Arc::new(vec![0.0, 0.5, 1.0, 1.8]),
        values: Arc::new(values_of(&selected)),
        selected: Arc::new(selected),
        tracks: Arc::new(HashMap::from([(entity(1), tracks.collect())])),
        ..TimelineModel::default()
    };
    in_a_state(
        [1000, 160],
        model,
        |ui, model: &TimelineModel, state: &mut TimelineState| {
            panels::timeline::timeline(ui, model, &NO_BINDINGS, state, &mut Vec::new());
        },
    )
}

fn status(model: StatusModel) -> RgbImage {
    let show = |ui: &mut Ui, model: &mut StatusModel| panels::status::status_line(ui, model, None);
    panel([1000, 40], model, show, |_| ())
}

fn rendering() -> RenderStatus {
    RenderStatus {
        state: RenderState::Rendering,
        samples: 2,
        target: 256,
        size: UVec2::new(1042, 782),
        full_size: UVec2::new(1042, 782),
        seconds: 83.0,
        noise: Some(75.21),
        mrays_per_s: 2.345,
        triangles: 871_414,
        ..RenderStatus::default()
    }
}

pub fn status_line() -> RgbImage {
    status(StatusModel {
        status: rendering(),
        ..StatusModel::default()
    })
}

pub fn status_line_while_denoised() -> RgbImage {
    let mut model = StatusModel {
        status: RenderStatus {
            samples: 64,
            noise: Some(0.042),
            ..rendering()
        },
        denoiser: DenoiserState::Shown {
            seconds: 0.35,
            samples: 64,
        },
        ..StatusModel::default()
    };
    for samples in [2, 4, 8, 16, 32, 64] {
        let noise = 0.336 / (samples as f32).sqrt();
        model.noise_trend.note(1, samples, Some(noise));
    }
    status(model)
}

fn bake_model() -> BakeModel {
    BakeModel {
        choices: BakeChoices {
            denoise: true,
            ..BakeChoices::default()
        },
        folder: Some(PathBuf::from("/levels/flat")),
        scene_folder: Some(PathBuf::from("/levels")),
        shown: None,
    }
}

pub fn bake_form() -> RgbImage {
    in_a_state([412, 420], bake_model(), |ui, model: &BakeModel, form| {
        panels::baking::form(ui, form, model, &mut Vec::new());
    })
}

pub fn bake_progress() -> RgbImage {
    let news = BakeNews {
        stage: "Light of the lightmaps".to_owned(),
        progress: Some(Progress {
            stage: Stage::Lightmaps,
            done: 0.4,
            ..Progress::default()
        }),
        samples: 24,
        pages: 2,
        page_size: [1024, 768],
        ..BakeNews::default()
    };
    let shown = ShownBake {
        folder: PathBuf::from("/levels/flat"),
        news,
        is_stopped: false,
        is_busy: true,
        page: 0,
        view: CompareView::Off,
        is_of_open_scene: true,
    };
    let show = |ui: &mut Ui, shown: &mut ShownBake| panels::baking::progress(ui, shown, None, &mut Vec::new());
    panel([RIGHT, 300], shown, show, |_| ())
}

/// The picker of a colour, below its field.
pub fn color_picker() -> RgbImage {
    let show = |ui: &mut Ui, color: &mut Rgb| _ = panels::color_field::color(ui, "Reflectance", color);
    panel([RIGHT, 320], Rgb::new(0.6, 0.25, 0.1), show, |harness| {
        let button = harness.get_by_role(bevy_egui::egui::accesskit::Role::ColorWell);
        let place = button.rect().center();
        harness.hover_at(place);
        harness.run_steps(1);
        harness.drag_at(place);
        harness.run_steps(1);
        harness.drop_at(place);
        harness.run_steps(3);
    })
}
