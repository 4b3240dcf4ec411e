//! Why a place is as it is: shares that show their paths, and names that select things.

use std::sync::Arc;

use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use sunroom::app::editor::command::inspected_paths::InspectedPaths;
use sunroom::app::editor::command::selection::Extend;
use sunroom::app::editor::command::{Command, SelectionCommand, ToolCommand};
use sunroom::app::editor::panels::paths::paths;
use sunroom::app::editor::picture::lamp_light::LampFollower;
use sunroom::app::editor::picture::paths::PathInspector;
use sunroom::app::editor::picture::reasons::{Explanation, NamedPortion, Reasons};
use sunroom::app::editor::picture::search::SearchState;
use sunroom::color::Rgb;
use sunroom::engine::reasons::{Group, Grouping, Lamp, Via};
use sunroom::render::breakdown::{Advice, Portion, Trouble};

use super::{Shown, click, entity, show};

#[derive(Default)]
struct Given {
    follower: LampFollower,
    inspector: PathInspector,
    reasons: Reasons,
}

fn portion<K>(key: K, share: f32) -> Portion<K> {
    Portion {
        key,
        light: Rgb::splat(share),
        luminance: share,
        error: 0.01 * share,
        share,
        share_error: 0.02,
        noise: share,
    }
}

fn explanation() -> Explanation {
    let by_wall = Group::Route(Lamp::Thing(entity(1)), Via::Thing(entity(2)));
    let name = |thing| if thing == entity(1) { "desk lamp" } else { "red wall" }.to_owned();
    let named = |key: Group, share| NamedPortion {
        portion: portion(key, share),
        words: key.words(&name),
    };
    Explanation {
        value: portion((), 1.0),
        groupings: vec![
            vec![named(by_wall, 0.6)],
            vec![named(Group::Lamp(Lamp::Thing(entity(1))), 1.0)],
        ],
        advice: vec![Advice {
            trouble: Trouble::Caustic,
            noise: 0.9,
        }],
        samples: 64,
        is_final: false,
    }
}

fn shown(known: Option<Explanation>) -> Harness<'static, Shown<Given>> {
    let mut inspector = PathInspector::default();
    inspector.wanted = Some(InspectedPaths::at(Default::default()));
    let mut given = Given {
        inspector,
        ..Given::default()
    };
    given.reasons.explanation = known.map(Arc::new);
    panel(given)
}

fn panel(given: Given) -> Harness<'static, Shown<Given>> {
    show(given, |ui, given, commands| {
        paths(ui, &given.inspector, &given.reasons, &given.follower, commands);
    })
}

#[test]
fn the_light_of_the_selected_lamp_is_followed_and_forgotten() {
    let mut follower = LampFollower::default();
    follower.selected = Some((entity(1), "desk lamp".to_owned()));
    let mut harness = panel(Given {
        follower,
        ..Given::default()
    });
    click(&mut harness, "Where does the light of desk lamp go?");
    let follow = Command::from(ToolCommand::FollowLamp(Some(entity(1))));
    assert_eq!(harness.state().commands, [follow]);
    let state = harness.state_mut();
    state.commands.clear();
    state.given.follower.lamp = Some(entity(1));
    harness.run_steps(2);
    assert!(
        harness
            .query_by_label("Where does the light of desk lamp go?")
            .is_none()
    );
    click(&mut harness, "Forget the lamp");
    assert_eq!(harness.state().commands, [Command::from(ToolCommand::FollowLamp(None))]);
}

#[track_caller]
fn inspected(harness: &Harness<Shown<Given>>) -> InspectedPaths {
    match &harness.state().commands[..] {
        [Command::Tool(ToolCommand::InspectPaths(Some(paths)))] => *paths,
        other => panic!("{other:?}"),
    }
}

#[test]
fn a_click_on_a_share_shows_its_paths() {
    let mut harness = shown(Some(explanation()));
    click(&mut harness, "60 ± 2 % desk lamp by way of red wall");
    let wanted = inspected(&harness);
    let by_wall = Group::Route(Lamp::Thing(entity(1)), Via::Thing(entity(2)));
    assert_eq!(wanted.of, Some(by_wall));
    // The second click shows all of them.
    let state = harness.state_mut();
    state.commands.clear();
    state.given.inspector.wanted = Some(wanted);
    harness.run_steps(2);
    click(&mut harness, "60 ± 2 % desk lamp by way of red wall");
    assert_eq!(inspected(&harness).of, None);
}

#[test]
fn names_select_their_things() {
    let mut harness = shown(Some(explanation()));
    click(&mut harness, "red wall");
    let select = SelectionCommand::Select(vec![entity(2)], Extend::Replace);
    assert_eq!(harness.state().commands, [Command::from(select)]);
}

#[test]
fn another_grouping_is_chosen() {
    let mut harness = shown(Some(explanation()));
    click(&mut harness, Grouping::Lamp.label());
    assert_eq!(inspected(&harness).grouping, Grouping::Lamp);
}

#[test]
fn nothing_is_told_before_it_is_known() {
    let harness = shown(None);
    assert!(harness.query_by_label("Tracing…").is_some());
    assert!(harness.state().commands.is_empty());
    let harness = shown(Some(explanation()));
    assert!(harness.query_by_label_contains("more are being traced").is_some());
    assert!(harness.query_by_label_contains("`bdpt`").is_some());
    assert!(harness.state().commands.is_empty());
}

#[test]
fn the_progress_of_a_search_is_told() {
    let mut harness = shown(None);
    harness.state_mut().given.reasons.state = SearchState::Running(0.437);
    harness.step();
    assert!(harness.query_by_label("Tracing… 43 %").is_some());
    let mut harness = shown(Some(explanation()));
    harness.state_mut().given.reasons.state = SearchState::Running(0.437);
    harness.step();
    assert!(harness.query_by_label_contains("more are being traced 43 %").is_some());
}

#[test]
fn a_search_that_has_failed_says_why() {
    let failed = || SearchState::Failed("the lamp is gone".to_owned());
    let mut harness = shown(None);
    harness.state_mut().given.reasons.state = failed();
    harness.run_steps(2);
    assert!(harness.query_by_label_contains("Tracing").is_none());
    assert!(
        harness
            .query_by_label_contains("could be traced: the lamp is gone.")
            .is_some()
    );
    // So does one that has found something before.
    let mut harness = shown(Some(explanation()));
    harness.state_mut().given.reasons.state = failed();
    harness.run_steps(2);
    assert!(
        harness
            .query_by_label_contains("could not be traced: the lamp is gone")
            .is_some()
    );
    let mut follower = LampFollower::default();
    follower.lamp = Some(entity(1));
    follower.state = failed();
    let harness = panel(Given {
        follower,
        ..Given::default()
    });
    assert!(
        harness
            .query_by_label_contains("could be traced: the lamp is gone.")
            .is_some()
    );
}

#[test]
fn a_dark_place_says_that_no_light_was_found() {
    let mut dark = explanation();
    dark.value = portion((), 0.0);
    dark.groupings = Vec::new();
    let harness = shown(Some(dark));
    assert!(harness.query_by_label_contains("No path found light here").is_some());
}
