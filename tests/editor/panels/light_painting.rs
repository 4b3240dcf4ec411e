//! The rows of the light you want, and its brush over the picture.

use std::sync::Arc;

use bevy::math::{Affine3A, Vec2, Vec3};
use bevy_egui::egui::{self, Pos2};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use sunroom::app::editor::command::light_paint::{Answer, Brush, LampChoice, LightPaintCommand};
use sunroom::app::editor::command::tool::Tool;
use sunroom::app::editor::command::{Command, DisplayCommand, ToolCommand};
use sunroom::app::editor::input::actions::ActionContext;
use sunroom::app::editor::model::PaintingModel;
use sunroom::app::editor::panels::light_painting::light_painting;
use sunroom::app::editor::viewport::model::ViewportModel;
use sunroom::app::editor::viewport::state::ViewportState;
use sunroom::app::editor::viewport::viewport;
use sunroom::inverse_lighting::{Stroke, Wish};
use sunroom::render::camera::Camera;

use super::{Shown, click, entity, show};
use crate::support::ViewportContent;

fn strokes() -> Arc<[Stroke]> {
    [Wish::Keep, Wish::Darker(3.0)]
        .map(|wish| {
            Brush {
                wish,
                ..Brush::default()
            }
            .stroke(vec![Vec2::splat(0.5)])
        })
        .into()
}

fn rows(model: PaintingModel) -> Harness<'static, Shown<PaintingModel>> {
    show(model, |ui, model, commands| {
        let lights = [(entity(1), "sky".to_owned()), (entity(2), "lamp".to_owned())];
        light_painting(ui, model, &lights, commands);
    })
}

#[test]
fn rows_of_the_light_you_want_say_what_was_found() {
    let mut harness = rows(PaintingModel {
        strokes: strokes(),
        answer: Some(Arc::new(Answer {
            notes: vec!["lamp is at its upper limit, 10.".to_owned()],
            milliseconds: 1.0,
        })),
        ..PaintingModel::default()
    });
    assert_eq!(harness.state().commands, []);
    harness.get_by_label("lamp is at its upper limit, 10.");
    click(&mut harness, "Paint light");
    let last = |harness: &Harness<Shown<PaintingModel>>| harness.state().commands.last().cloned();
    assert_eq!(last(&harness), Some(ToolCommand::SetTool(Tool::PaintLight).into()));
    click(&mut harness, "lamp");
    let fixed = LampChoice {
        chosen: false,
        ..LampChoice::default()
    };
    assert_eq!(
        last(&harness),
        Some(LightPaintCommand::SetLamp(entity(2), fixed).into())
    );
    click(&mut harness, "Remove stroke");
    let first = strokes()[..1].to_vec();
    assert_eq!(last(&harness), Some(LightPaintCommand::SetStrokes(first).into()));
    click(&mut harness, "Clear");
    assert_eq!(last(&harness), Some(LightPaintCommand::SetStrokes(Vec::new()).into()));
}

#[test]
fn strokes_of_another_view_are_told_about() {
    let harness = rows(PaintingModel {
        strokes: strokes(),
        is_elsewhere: true,
        ..PaintingModel::default()
    });
    harness.get_by_label("The strokes belong to another view: go back to it, or clear them.");
}

#[derive(Default)]
struct Painted {
    state: ViewportState,
    painting: PaintingModel,
    commands: Vec<Command>,
}

#[test]
fn a_drag_with_the_brush_is_one_stroke() {
    let pose = Affine3A::from_translation(Vec3::new(0.0, 0.0, -8.0));
    let camera = Camera::new(pose, 90.0, 4.0 / 3.0, 0.01, 1000.0, None);
    let show = move |ui: &mut egui::Ui, painted: &mut Painted| {
        let content = ViewportContent::default();
        let empty = content.model([400, 300], pose, camera, &[]);
        let model = ViewportModel {
            painting: Some(&painted.painting),
            keys: ActionContext {
                tool: Tool::PaintLight,
                ..empty.keys
            },
            ..empty
        };
        viewport(ui, &model, &mut painted.state, &mut painted.commands);
    };
    let mut harness = Harness::builder()
        .with_size(egui::vec2(400.0, 300.0))
        .build_ui_state(show, Painted::default());
    harness.run_steps(2);
    let button = |pressed, pos| egui::Event::PointerButton {
        pos,
        button: egui::PointerButton::Primary,
        pressed,
        modifiers: egui::Modifiers::NONE,
    };
    let places = [160.0, 200.0, 240.0].map(|x| Pos2::new(x, 150.0));
    harness.event(egui::Event::PointerMoved(places[0]));
    harness.run_steps(1);
    harness.event(button(true, places[0]));
    harness.run_steps(1);
    for place in &places[1..] {
        harness.event(egui::Event::PointerMoved(*place));
        harness.run_steps(1);
    }
    harness.event(button(false, places[2]));
    harness.run_steps(2);
    let painted = harness.state().commands.iter().filter_map(|command| match command {
        Command::Display(DisplayCommand::PaintLight(LightPaintCommand::SetStrokes(strokes))) => Some(strokes),
        _ => None,
    });
    let painted: Vec<_> = painted.collect();
    assert_eq!(painted.len(), 3, "the stroke grows");
    let [stroke] = &painted[2][..] else {
        panic!("one stroke: {painted:?}");
    };
    assert_eq!(stroke.path.len(), 3);
    assert!(stroke.path[0].x < stroke.path[1].x && stroke.path[1].x < stroke.path[2].x);
    assert!((stroke.path[1] - 0.5).abs().max_element() < 0.02, "{:?}", stroke.path);
}
