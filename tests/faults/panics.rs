//! Panics on other threads than the main one.

use std::sync::Arc;

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
        "`sunroom render` writes the samples that are there and ends with exit code 1.";
}

/// The panic is injected into what a worker calls when it has finished a preview; no scene is known that makes one panic.
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
    world.insert_resource(WakeUp(Some(Arc::new(|| panic!("a panic for the test")))));
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
