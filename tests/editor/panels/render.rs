//! The render panel, with the mixing desk and comparisons.

use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use sunroom::app::editor::command::bvh_overlay::BvhOverlay;
use sunroom::app::editor::command::compare_view::CompareView;
use sunroom::app::editor::command::display::{DisplayMode, DisplaySettings};
use sunroom::app::editor::command::light_mix::{Channel, LightMix};
use sunroom::app::editor::command::resolution::{Enlarging, FullFilm, Resolution};
use sunroom::app::editor::command::{CameraEdit, Command, DisplayCommand, EditCommand, RenderCommand, SettingsEdit};
use sunroom::app::editor::model::{ComparisonModel, MixingModel, RenderModel};
use sunroom::app::editor::panels::{layers, render};
use sunroom::engine::AutoStatus;
use sunroom::layer::{Layer, Layers};
use sunroom::render::auto::{Choice, Method};
use sunroom::scene::{IntegratorSettings, Strategy};

use super::{Shown, click, entity, show, slide};

fn render_panel(model: RenderModel) -> Harness<'static, Shown<RenderModel>> {
    show(model, |ui, model, commands| {
        render::render(ui, model, DisplaySettings::default(), BvhOverlay::default(), commands);
    })
}

#[test]
fn the_render_panel_sets_what_it_shows() {
    let model = RenderModel {
        target_samples: 100_000,
        resolution_scale: 0.333_333_34,
        integrator: IntegratorSettings {
            max_depth: Some(1000),
            ..IntegratorSettings::default()
        },
        ..RenderModel::default()
    };
    let mut harness = render_panel(model);
    assert_eq!(harness.state().commands, [], "out of range and yet untouched");
    slide(&mut harness, "Samples", 0.3);
    assert!(matches!(
        harness.state().commands.last(),
        Some(Command::Render(RenderCommand::SetTargetSamples(2..=200)))
    ));
    slide(&mut harness, "Resolution", 0.5);
    assert!(
        matches!(harness.state().commands.last(), Some(Command::Render(RenderCommand::SetResolutionScale(s))) if (0.4..0.7).contains(s))
    );
    slide(&mut harness, "Exposure", 0.6);
    assert!(
        matches!(harness.state().commands.last(), Some(Command::Display(DisplayCommand::SetDisplay(d))) if d.exposure > 0.0)
    );
    slide(&mut harness, "Depth limit", 0.1);
    assert!(matches!(
        harness.state().commands.last(),
        Some(Command::Edit(EditCommand::Settings(SettingsEdit::SetIntegrator(
            IntegratorSettings {
                max_depth: Some(1..20),
                ..
            }
        ))))
    ));
    click(&mut harness, "Sampling");
    click(&mut harness, "lights only");
    assert!(matches!(
        harness.state().commands.last(),
        Some(Command::Edit(EditCommand::Settings(SettingsEdit::SetIntegrator(
            IntegratorSettings {
                strategy: Strategy::Light,
                ..
            }
        ))))
    ));
    click(&mut harness, "Clamp fireflies");
    assert!(matches!(
        harness.state().commands.last(),
        Some(Command::Edit(EditCommand::Settings(SettingsEdit::SetIntegrator(
            IntegratorSettings {
                clamp_percentile: Some(_),
                ..
            }
        ))))
    ));
    click(&mut harness, "Guided paths");
    assert!(matches!(
        harness.state().commands.last(),
        Some(Command::Edit(EditCommand::Settings(SettingsEdit::SetIntegrator(
            IntegratorSettings { guided: true, .. }
        ))))
    ));
    click(&mut harness, "Show");
    click(&mut harness, "Normal");
    assert!(
        matches!(harness.state().commands.last(), Some(Command::Display(DisplayCommand::SetDisplay(d))) if d.mode == DisplayMode::Normal)
    );
    click(&mut harness, "Pixels");
    click(&mut harness, "as shown, then full");
    let chosen = Command::from(RenderCommand::SetResolution(Resolution::AfterRest));
    assert_eq!(harness.state().commands.last(), Some(&chosen));
    click(&mut harness, "Upscaling");
    click(&mut harness, "sharp");
    let chosen = Command::from(DisplayCommand::SetEnlarging(Enlarging::Sharp));
    assert_eq!(harness.state().commands.last(), Some(&chosen));
    click(&mut harness, "Denoise");
    assert_eq!(
        harness.state().commands.last(),
        Some(&DisplayCommand::SetDenoising(true).into())
    );
    click(&mut harness, "Render full film");
    let asked = Command::from(RenderCommand::RenderFull(FullFilm::default()));
    assert_eq!(harness.state().commands.last(), Some(&asked));
    click(&mut harness, "Start again");
    assert_eq!(harness.state().commands.last(), Some(&RenderCommand::Restart.into()));
}

#[test]
fn layers_are_chosen_one_by_one() {
    let mut harness = show(RenderModel::default(), |ui, model, commands| {
        layers::layer_rows(ui, model.integrator, commands);
    });
    click(&mut harness, "Texture coordinates");
    let chosen = Command::from(SettingsEdit::SetIntegrator(IntegratorSettings {
        layers: Layers::of(&[Layer::Uv]),
        ..IntegratorSettings::default()
    }));
    assert_eq!(harness.state().commands.last(), Some(&chosen));
}

#[test]
fn limits_have_a_switch_and_a_number() {
    let mut harness = render_panel(RenderModel::default());
    click(&mut harness, "Limit time");
    click(&mut harness, "Limit noise");
    click(&mut harness, "Adaptive");
    let expected = [
        Command::from(RenderCommand::SetTimeLimit(Some(60.0))),
        Command::from(RenderCommand::SetNoiseTarget(Some(0.02))),
        Command::from(RenderCommand::SetAdaptive(true)),
    ];
    assert_eq!(harness.state().commands, expected);
    click(&mut harness, "Save limits in the camera");
    assert_eq!(harness.state().commands.last(), Some(&CameraEdit::KeepLimits.into()));
    let mut harness = render_panel(RenderModel {
        time_limit: Some(5.0),
        noise_target: Some(0.1),
        region: Some(bevy::math::Rect::new(0.0, 0.0, 0.5, 0.5)),
        ..RenderModel::default()
    });
    slide(&mut harness, "Noise", 0.9);
    assert!(
        matches!(harness.state().commands.last(), Some(Command::Render(RenderCommand::SetNoiseTarget(Some(n)))) if *n > 0.1)
    );
    click(&mut harness, "Limit time");
    assert_eq!(
        harness.state().commands.last(),
        Some(&RenderCommand::SetTimeLimit(None).into())
    );
    slide(&mut harness, "Right", 0.9);
    let last = harness.state().commands.last().cloned();
    assert!(
        matches!(last, Some(Command::Render(RenderCommand::SetRegion(Some(part)))) if part.max.x > 0.6 && part.min.x == 0.0),
        "{last:?}"
    );
    click(&mut harness, "Render region");
    assert_eq!(
        harness.state().commands.last(),
        Some(&RenderCommand::SetRegion(None).into())
    );
}

#[test]
fn the_panel_says_what_auto_stands_for() {
    let choice = Choice {
        method: Method::Bidirectional,
        gain: Some(12.3),
        gain_of_guide: None,
        missed: 0.0,
    };
    let auto = AutoStatus {
        integrator: "bdpt",
        is_searching: false,
        guide_rays: 0,
        choice,
    };
    let mut harness = render_panel(RenderModel {
        path_is_auto: true,
        auto: Some(auto),
        ..RenderModel::default()
    });
    harness.get_by_label("bdpt: 12.3 times less variance for its cost");
    let choice = Choice {
        method: Method::GuidedPath,
        gain: Some(0.7),
        gain_of_guide: Some(2.1),
        missed: 0.0,
    };
    harness.state_mut().given.auto = Some(AutoStatus {
        integrator: "guided path",
        is_searching: false,
        guide_rays: 70_000,
        choice,
    });
    harness.run_steps(3);
    harness.get_by_label("guided path: 2.1 times less variance for its cost");
    // Guided because that is asked for; the gain is that against `path` without a guide.
    let choice = Choice {
        method: Method::Path,
        gain: Some(0.3),
        gain_of_guide: None,
        missed: 0.0,
    };
    harness.state_mut().given.auto = Some(AutoStatus {
        integrator: "guided path",
        is_searching: false,
        guide_rays: 0,
        choice,
    });
    harness.run_steps(3);
    harness.get_by_label("guided path: bdpt has 3.3 times the variance of path for the cost");
    click(&mut harness, "Automatic");
    assert_eq!(
        harness.state().commands,
        [Command::from(RenderCommand::SetPathIsAuto(false))]
    );
}

#[test]
fn every_light_has_its_channel() {
    let mut harness = render_panel(RenderModel::default());
    click(&mut harness, "Mix lights");
    assert_eq!(
        harness.state().commands,
        [Command::from(RenderCommand::SetLightLayers(true))]
    );
    let mut mix = LightMix::default();
    let loud = Channel {
        strength: 3.0,
        ..Channel::default()
    };
    mix.set(entity(2), loud);
    let mut harness = render_panel(RenderModel {
        mixing: MixingModel {
            is_on: true,
            mix: mix.clone(),
            lights: vec![(entity(1), "sky".to_owned()), (entity(2), "lamp".to_owned())],
        },
        ..RenderModel::default()
    });
    assert_eq!(harness.state().commands, []);
    click(&mut harness, "sky M");
    let muted = Channel {
        mute: true,
        ..Channel::default()
    };
    let mut expected = mix.clone();
    expected.set(entity(1), muted);
    assert_eq!(
        harness.state().commands.last(),
        Some(&DisplayCommand::SetLightMix(expected).into())
    );
    click(&mut harness, "lamp S");
    let mut expected = mix;
    expected.set(entity(2), Channel { solo: true, ..loud });
    assert_eq!(
        harness.state().commands.last(),
        Some(&DisplayCommand::SetLightMix(expected).into())
    );
    click(&mut harness, "Bake");
    assert_eq!(harness.state().commands.last(), Some(&SettingsEdit::BakeLights.into()));
    click(&mut harness, "Reset");
    assert_eq!(
        harness.state().commands.last(),
        Some(&DisplayCommand::SetLightMix(LightMix::default()).into())
    );
}

#[test]
fn pictures_are_compared_with_a_snapshot() {
    let mut harness = render_panel(RenderModel::default());
    click(&mut harness, "Take snapshot");
    assert_eq!(harness.state().commands, [Command::from(DisplayCommand::TakeSnapshot)]);
    let mut harness = render_panel(RenderModel {
        comparison: ComparisonModel {
            denoising: false,
            snapshot: Some(16),
            view: CompareView::Wipe(0.25),
            ..ComparisonModel::default()
        },
        ..RenderModel::default()
    });
    slide(&mut harness, "Border", 0.75);
    let last = harness.state().commands.last().cloned();
    assert!(matches!(last, Some(Command::Display(DisplayCommand::SetCompareView(CompareView::Wipe(at)))) if at > 0.5));
    click(&mut harness, "difference");
    let difference = Command::from(DisplayCommand::SetCompareView(CompareView::Difference));
    assert_eq!(harness.state().commands.last(), Some(&difference));
    click(&mut harness, "Measure");
    assert_eq!(harness.state().commands.last(), Some(&DisplayCommand::Measure.into()));
}

#[test]
fn a_denoised_picture_is_compared_with_the_noisy_one_without_a_snapshot() {
    let mut harness = render_panel(RenderModel {
        comparison: ComparisonModel {
            denoising: true,
            ..ComparisonModel::default()
        },
        ..RenderModel::default()
    });
    click(&mut harness, "noisy");
    let noisy = Command::from(DisplayCommand::SetCompareView(CompareView::Noisy(0.5)));
    assert_eq!(harness.state().commands.last(), Some(&noisy));
}
