//! Files of an open scene that go or break on the disk.

use std::path::Path;
use std::process::Command;
use std::time::{Duration, Instant};

use bevy::prelude::*;
use sunroom::app::editor::words::files::gone;
use sunroom::app::headless::headless;
use sunroom::engine::{Limits, load_to_completion};
use sunroom::scene::{FileProblem, MeshHandle, OpenScene, SceneState, SceneStatus, Shape, TextureMap, TriangleMesh};

use crate::program::{DEADLINE, Workshop};
use crate::table::{Row, section};

section! { "Files of an open scene"
    file_is_deleted:
        "A file of the scene is deleted: the scene itself, a mesh, a picture.",
        "A warning: `… is gone from the disk`. The picture stays, and the file is read again when it is back.",
        "Nothing new.";
    file_becomes_a_folder:
        "A folder takes the place of a file of the scene.",
        "A warning: `… is gone from the disk`. The picture stays, and the file is read again when it is back.",
        "The folder.";
    file_becomes_a_device:
        "A link to an endless device takes the place of a file of the scene.",
        "A warning: `… is gone from the disk`. The picture stays, nothing is read from the device, and the file is read again when it is back.",
        "The link.";
    file_becomes_a_pipe:
        "A named pipe takes the place of a file of the scene.",
        "A warning: `… is gone from the disk`. The picture stays, nothing waits for the pipe, and the file is read again when it is back.",
        "The pipe.";
    scene_is_truncated:
        "The scene's file ends in the middle.",
        "`scene.xml:…:…` and what was expected there. The last good scene stays, and the file is read again when it is whole.",
        "The truncated file.";
    mesh_is_truncated:
        "A mesh file ends in the middle.",
        "`mesh …mesh.ply: ` and what is wrong. The mesh stays as it was, and the file is read again when it is whole.",
        "The truncated file.";
    picture_is_truncated:
        "A picture file ends in the middle.",
        "`picture …picture.png: ` and what is wrong. The picture stays as it was, and the file is read again when it is whole.",
        "The truncated file.";
}

const SCENE: &str = r#"<scene version="3.0.0">
  <sensor type="perspective">
    <film type="hdrfilm"><integer name="width" value="64"/><integer name="height" value="64"/></film>
  </sensor>
  <shape type="ply"><string name="filename" value="mesh.ply"/>
    <bsdf type="diffuse"><texture type="bitmap" name="reflectance"><string name="filename" value="picture.png"/></texture></bsdf>
  </shape>
  <emitter type="constant"/>
</scene>
"#;

const MESH: &str =
    "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement face 1
property list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";

const FILES: [&str; 3] = ["scene.xml", "mesh.ply", "picture.png"];

/// A scene of three files, open and watched.
pub struct Open {
    pub app: App,
    shop: Workshop,
    /// The files as they were.
    pub content: [Vec<u8>; 3],
}

impl Open {
    pub fn new() -> Self {
        let shop = Workshop::new();
        shop.write("scene.xml", SCENE);
        shop.write("mesh.ply", MESH);
        let picture = image::RgbImage::from_fn(16, 16, |x, y| image::Rgb([x as u8 * 16, y as u8 * 16, 99]));
        picture.save(shop.path("picture.png")).expect("it can be written");
        let content = FILES.map(|name| std::fs::read(shop.path(name)).expect("it was just written"));
        let scene = OpenScene {
            path: shop.path("scene.xml"),
            ..OpenScene::default()
        };
        let mut app = headless(scene, Some(1));
        assert_eq!(load_to_completion(&mut app, &Limits::default()), Ok(true));
        let mut open = Self { app, shop, content };
        // The watch learns of the files in the frames after they are loaded.
        (0..20).for_each(|_| open.app.update());
        open
    }

    pub fn status(&self) -> &SceneStatus {
        self.app.world().resource::<SceneStatus>()
    }

    #[track_caller]
    pub fn until(&mut self, what: &str, is_so: impl Fn(&SceneStatus) -> bool) {
        self.until_app(what, |open| is_so(open.status()));
    }

    #[track_caller]
    pub fn until_app(&mut self, what: &str, is_so: impl Fn(&Self) -> bool) {
        let begin = Instant::now();
        loop {
            self.app.update();
            if is_so(self) {
                return;
            }
            assert!(begin.elapsed() < DEADLINE, "{what}: {:?}", self.status());
            std::thread::sleep(Duration::from_millis(5));
        }
    }

    /// Fails unless the scene is as it was read first.
    #[track_caller]
    pub fn nothing_is_lost(&mut self) {
        let world = self.app.world_mut();
        let mut shapes = world.query::<(&Shape, &MeshHandle)>();
        let (_, mesh) = shapes.single(world).expect("one shape");
        let mesh = world
            .resource::<Assets<TriangleMesh>>()
            .get(&mesh.0)
            .expect("it was read");
        assert_eq!(mesh.shapes[0].data.triangles, [[0, 1, 2]]);
        let maps = world.resource::<Assets<TextureMap>>();
        assert_eq!(maps.iter().count(), 1);
    }

    /// Gives the file other content in one step, so that no half of it is read.
    pub fn replace(&self, index: usize, content: &[u8]) {
        std::fs::write(self.shop.path("new"), content).expect("a temporary folder");
        std::fs::rename(self.shop.path("new"), self.shop.path(FILES[index])).expect("a file or nothing is there");
    }

    /// The file is there again with other content: it is read.
    #[track_caller]
    pub fn is_read_again(&mut self, index: usize) {
        let mut content = self.content[index].clone();
        if FILES[index] != "picture.png" {
            // In the formats of text that changes nothing.
            content.push(b'\n');
        }
        let old = self.status().revision;
        self.replace(index, &content);
        let is_scene = index == 0;
        self.until("the file is back", |status| {
            status.files_gone.is_empty()
                && status.is_complete()
                && !status.has_errors()
                && status.picture_problems.is_empty()
                && status.damaged_pictures.is_empty()
                && (!is_scene || status.revision > old)
        });
        self.nothing_is_lost();
    }
}

/// Puts something in the place of each of the files in turn.
fn replaced_by(row: &Row, replace: impl Fn(&Path)) {
    let mut open = Open::new();
    for (index, name) in FILES.into_iter().enumerate() {
        let path = open.shop.path(name).canonicalize().expect("it is there");
        std::fs::remove_file(&path).expect("it is there");
        replace(&path);
        open.until(name, |status| status.files_gone == [path.clone()]);
        row.is_said_in(&gone(&open.status().files_gone[0]));
        assert_eq!(open.status().state, SceneState::Ready);
        open.nothing_is_lost();
        if path.is_dir() {
            std::fs::remove_dir(&path).expect("it is empty");
        } else if path.symlink_metadata().is_ok() {
            std::fs::remove_file(&path).expect("it is there");
        }
        open.is_read_again(index);
    }
}

fn file_is_deleted(row: &Row) {
    replaced_by(row, |_| ());
}

fn file_becomes_a_folder(row: &Row) {
    replaced_by(row, |path| std::fs::create_dir(path).expect("nothing is there"));
}

fn file_becomes_a_device(row: &Row) {
    replaced_by(row, |path| {
        std::os::unix::fs::symlink("/dev/zero", path).expect("nothing is there")
    });
}

fn file_becomes_a_pipe(row: &Row) {
    replaced_by(row, |path| {
        let made = Command::new("mkfifo").arg(path).status();
        assert!(made.is_ok_and(|status| status.success()));
    });
}

/// Cuts off the second half of a file. `said`: what the window shows.
fn truncated(row: &Row, index: usize, said: impl Fn(&SceneStatus) -> String) {
    let mut open = Open::new();
    let half = &open.content[index][..open.content[index].len() / 2];
    std::fs::write(open.shop.path(FILES[index]), half).expect("it is there");
    open.until("the message", |status| !said(status).is_empty());
    row.is_said_in(&said(open.status()));
    open.nothing_is_lost();
    open.is_read_again(index);
}

fn scene_is_truncated(row: &Row) {
    truncated(row, 0, |status| status.diagnostics.to_string());
}

pub fn said(problems: &[FileProblem]) -> String {
    let messages = problems.iter().map(|problem| problem.message.as_str());
    messages.collect::<Vec<_>>().join("\n")
}

fn mesh_is_truncated(row: &Row) {
    truncated(row, 1, |status| said(&status.mesh_errors));
}

fn picture_is_truncated(row: &Row) {
    truncated(row, 2, |status| said(&status.damaged_pictures));
}
