//! Panics on other threads than the main one.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use bevy::prelude::*;
use sunroom::app::headless::headless;
use sunroom::engine::{
    Limits, Outcome, RenderControl, RenderFilm, RenderState, RenderStatus, WakeUp, load_to_completion,
    render_to_completion,
};
use sunroom::scene::OpenScene;

use crate::program::{Workshop, wait_for};
use crate::table::{Row, section};

section! { "Panics"
    worker_panics:
        "A thread that traces rays panics.",
        "`a panic for the test` in the messages, and the program stays: the next change begins a picture, which becomes whole.",
        "Nothing new.";
    worker_panics_in_a_render:
        "A thread that traces rays panics after the first samples while nobody watches, as in `sunroom render`.",
        "`rendering broke off: …a panic for the test`, and how many samples the picture has.",
        "The film has the samples so far, which `sunroom render` writes.";
}

/// The panic is injected into what a worker calls when it has finished a preview; no scene is known that makes one
/// panic. Systems of the main thread make the same call.
fn panic_of_a_worker() {
    let thread = std::thread::current();
    assert!(
        !thread.name().is_some_and(|name| name.starts_with("render")),
        "a panic for the test"
    );
}

fn worker_panics(row: &Row) {
    let shop = Workshop::new();
    let scene = OpenScene {
        path: shop.path("scene.xml"),
        ..OpenScene::default()
    };
    let mut app = headless(scene, Some(2));
    assert_eq!(load_to_completion(&mut app, &Limits::default()), Ok(true));
    let world = app.world_mut();
    world.resource_mut::<RenderControl>().interactive = true;
    world.insert_resource(WakeUp(Some(Arc::new(panic_of_a_worker))));
    wait_for("the message", || {
        app.update();
        app.world().resource::<RenderStatus>().state == RenderState::Failed
    });
    row.is_said_in(&app.world().resource::<RenderStatus>().errors.join("\n"));
    let world = app.world_mut();
    world.insert_resource(WakeUp::default());
    world.resource_mut::<RenderControl>().restart_requested = true;
    let rendered = render_to_completion(&mut app, &Limits::default(), |_| ());
    assert_eq!(rendered, Ok(Outcome::Complete));
    assert_eq!(app.world().resource::<RenderFilm>().film.sample_count(), 2);
}

fn worker_panics_in_a_render(row: &Row) {
    let shop = Workshop::new();
    let scene = OpenScene {
        path: shop.path("scene.xml"),
        ..OpenScene::default()
    };
    let mut app = headless(scene, Some(2));
    let has_samples = Arc::new(AtomicBool::new(false));
    let flag = has_samples.clone();
    let hook = WakeUp(Some(Arc::new(move || {
        if flag.load(Ordering::Relaxed) {
            panic_of_a_worker();
        }
    })));
    app.add_systems(First, move |status: Res<RenderStatus>, mut wake_up: ResMut<WakeUp>| {
        *wake_up = hook.clone();
        has_samples.store(status.samples > 0, Ordering::Relaxed);
    });
    let limits = Limits {
        samples: Some(100_000_000),
        ..Limits::default()
    };
    let error = render_to_completion(&mut app, &limits, |_| ()).expect_err("a worker panics");
    row.is_said_in(&error.to_string());
    let film = &app.world().resource::<RenderFilm>().film;
    assert_eq!((film.width(), film.pixels_without_samples()), (64, 0));
}
