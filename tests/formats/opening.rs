//! Large scenes are opened over several frames.

use std::fmt::Write;
use std::path::Path;
use std::time::{Duration, Instant};

use bevy::prelude::*;
use sunroom::scene::{
    FileSourcePlugin, OpenScene, OpeningPace, SceneId, ScenePlugin, SceneState, SceneStatus, Shape, UsesMaterial,
    asset_plugin,
};

fn write_balls(path: &Path, name: &str, count: usize) {
    let mut text = String::from("<scene version='3.0.0'><bsdf type='diffuse' id='paint'/>");
    for number in 0..count {
        write!(
            text,
            "<shape type='sphere' id='{name}-{number}'><ref id='paint'/></shape>"
        )
        .expect("memory");
    }
    text.push_str("</scene>");
    std::fs::write(path, text).expect("a temporary folder");
}

/// Opens a file, and gives the number of shapes that were there in each frame in which it was being opened.
fn open(app: &mut App, path: &Path) -> Vec<usize> {
    let revision = app.world().resource::<SceneStatus>().revision;
    app.world_mut().write_message(OpenScene {
        path: path.to_owned(),
        ..OpenScene::default()
    });
    let begun = Instant::now();
    let mut counts = Vec::new();
    loop {
        app.update();
        let world = app.world_mut();
        let count = world.query::<&Shape>().iter(world).count();
        let status = world.resource::<SceneStatus>();
        if status.is_opening {
            assert_eq!((status.state, status.revision), (SceneState::Loading, revision));
            counts.push(count);
        } else if status.revision > revision {
            assert_eq!(status.state, SceneState::Ready);
            return counts;
        }
        assert!(begun.elapsed() < Duration::from_secs(600), "{status:?}");
        std::thread::sleep(Duration::from_millis(1));
    }
}

#[test]
fn large_scenes_are_opened_over_several_frames() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let paths = ["first", "second"].map(|name| folder.path().join(format!("{name}.xml")));
    write_balls(&paths[0], "first", 1500);
    write_balls(&paths[1], "second", 1000);
    for pace in [None, Some(Duration::ZERO)] {
        let mut app = App::new();
        app.add_plugins((MinimalPlugins, FileSourcePlugin, asset_plugin(), ScenePlugin));
        app.insert_resource(OpeningPace(pace));
        app.finish();
        app.cleanup();
        let first = open(&mut app, &paths[0]);
        let second = open(&mut app, &paths[1]);
        match pace {
            None => assert!(first.is_empty() && second.is_empty()),
            Some(_) => {
                assert!(first.len() > 3 && first.is_sorted(), "{first:?}");
                // The old scene goes before the new one comes.
                assert!(second.len() > 6 && second.contains(&0), "{second:?}");
            }
        }
        let world = app.world_mut();
        let mut balls = world.query_filtered::<&SceneId, (With<Shape>, With<UsesMaterial>)>();
        let mut ids: Vec<String> = balls.iter(world).map(|id| id.0.clone()).collect();
        let mut expected: Vec<String> = (0..1000).map(|number| format!("second-{number}")).collect();
        ids.sort();
        expected.sort();
        assert_eq!(ids, expected);
    }
}
