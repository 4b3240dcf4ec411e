//! The rows of media in the inspector.

use bevy::math::Affine3A;
use egui_kittest::kittest::Queryable;
use sunroom::app::editor::command::media::{Filling, MediumSide};
use sunroom::app::editor::command::{Command, EditCommand, MediumEdit, SettingsEdit, ValueEdit};
use sunroom::app::editor::model::Inspected;
use sunroom::color::Rgb;
use sunroom::scene::{Coefficients, GridFile, Medium, PathPlugin, PhaseFunction, Sensor, Shape, VolumeParameter};

use super::inspector::inspect;
use super::subjects::with_medium;
use super::{click, drag, entity, item, slide};

fn fog() -> Medium {
    Medium {
        coefficients: Coefficients::Extinction {
            sigma_t: Rgb::splat(0.5).into(),
            albedo: Rgb::splat(0.9).into(),
        },
        scale: 2.0,
        ..Medium::default()
    }
}

/// The medium that the last command sets.
fn set(commands: &[Command]) -> Medium {
    match commands.last() {
        Some(Command::Edit(EditCommand::Value(ValueEdit::SetMedium(target, medium)))) if *target == entity(9) => {
            (**medium).clone()
        }
        other => panic!("{other:?}"),
    }
}

#[test]
fn a_longer_free_path_is_less_extinction() {
    let mut harness = inspect(with_medium(fog()));
    // One unit: the extinction is 0.5, and there is twice of it.
    drag(&mut harness, "Free path R", 60.0);
    let medium = set(&harness.state().commands);
    let sigma_t = medium.coefficients.uniform_extinction().expect("the same everywhere");
    assert!(sigma_t.x < 0.49 && sigma_t.y == 0.5 && sigma_t.z == 0.5, "{sigma_t}");
    assert_eq!(medium.scale, 2.0);
}

#[test]
fn the_phase_function_is_chosen_and_has_its_parameters() {
    let mut harness = inspect(with_medium(fog()));
    assert!(harness.query_by_label("Anisotropy").is_none());
    click(&mut harness, "Phase");
    harness.get_by_label("Henyey-Greenstein").click();
    harness.run_steps(3);
    assert_eq!(
        set(&harness.state().commands).phase,
        PhaseFunction::HenyeyGreenstein { g: 0.8 }
    );
    let mut harness = inspect(with_medium(Medium {
        phase: PhaseFunction::HenyeyGreenstein { g: 0.8 },
        ..fog()
    }));
    slide(&mut harness, "Anisotropy", 0.1);
    let PhaseFunction::HenyeyGreenstein { g } = set(&harness.state().commands).phase else {
        panic!("another one")
    };
    assert!(g < 0.0, "{g}");
}

#[test]
fn a_medium_is_chosen_made_and_taken_away() {
    let shape = || Inspected {
        shape: Some(Shape::default()),
        ..Inspected::new(entity(5), "box")
    };
    let choose = |side: &str, option: &str| {
        let mut harness = inspect(shape());
        let outline = std::sync::Arc::make_mut(&mut harness.state_mut().given.outline);
        outline.media = vec![item(40, "haze")].into();
        harness.run_steps(2);
        click(&mut harness, side);
        harness.get_by_label(option).click();
        harness.run_steps(3);
        harness.state().commands.clone()
    };
    let side = MediumSide::Exterior;
    assert_eq!(
        choose("Exterior", "haze"),
        [Command::from(MediumEdit::UseMedium {
            things: vec![entity(5)],
            side,
            medium: Some(entity(40)),
        })]
    );
    assert_eq!(
        choose("Exterior", "new medium"),
        [Command::from(MediumEdit::GiveMedium { thing: entity(5), side })]
    );
    let mut harness = inspect(with_medium(fog()));
    click(&mut harness, "Interior");
    harness.get_by_label("none").click();
    harness.run_steps(3);
    assert_eq!(
        harness.state().commands,
        [Command::from(MediumEdit::UseMedium {
            things: vec![entity(5)],
            side: MediumSide::Interior,
            medium: None,
        })]
    );
}

#[test]
fn an_empty_shape_can_be_filled_and_a_camera_is_in_a_medium() {
    let mut harness = inspect(Inspected {
        shape: Some(Shape::default()),
        ..Inspected::new(entity(5), "box")
    });
    click(&mut harness, "Fill with");
    click(&mut harness, "Smoke");
    assert_eq!(
        harness.state().commands,
        [Command::from(MediumEdit::Fill {
            shapes: vec![entity(5)],
            with: Filling::Smoke,
        })]
    );
    let camera = inspect(Inspected {
        sensor: Some(Sensor::default()),
        ..Inspected::new(entity(3), "camera")
    });
    assert_eq!(camera.get_by_label("Is in").value().as_deref(), Some("none"));
    assert!(camera.query_by_label("Interior").is_none());
}

#[test]
fn what_keeps_a_medium_from_being_seen_is_told() {
    let mut harness = inspect(with_medium(fog()));
    harness.get_by_label_contains("Not closed: 12345 edges");
    harness.get_by_label_contains("The integrator `path` renders no media");
    click(&mut harness, "Use volpath");
    let Some(Command::Edit(EditCommand::Settings(SettingsEdit::SetIntegrator(settings)))) =
        harness.state().commands.last()
    else {
        panic!("{:?}", harness.state().commands)
    };
    assert_eq!(settings.plugin, PathPlugin::VolPath);
    harness.state_mut().given.render.integrator.plugin = PathPlugin::VolPath;
    harness.run_steps(2);
    assert!(harness.query_by_label_contains("renders no media").is_none());
}

#[test]
fn a_grid_shows_its_voxels_and_is_moved() {
    let grid = GridFile {
        path: "/volumes/puff.vol".into(),
        to_world: Affine3A::IDENTITY,
        ..GridFile::default()
    };
    let mut harness = inspect(with_medium(Medium {
        coefficients: Coefficients::Extinction {
            sigma_t: VolumeParameter::Grid(grid),
            albedo: Rgb::ONE.into(),
        },
        ..fog()
    }));
    harness.get_by_label("puff.vol");
    harness.get_by_label("1234 × 567 × 8901, coloured");
    assert!(harness.query_by_label("Free path R").is_none());
    drag(&mut harness, "Grid size X", 40.0);
    let mut place = Affine3A::ZERO;
    set(&harness.state().commands).for_each_grid(&mut |grid| place = grid.to_world);
    assert!(
        place.matrix3.x_axis.x > 1.05 && place.matrix3.y_axis.y == 1.0,
        "{place}"
    );
}
