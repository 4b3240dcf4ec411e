//! The grid, the axes in the corner, and measuring: what they draw and what clicks on them do.

use bevy::math::{Affine3A, Vec2, Vec3};
use bevy_egui::egui::{self, Key, Modifiers, PointerButton, Pos2, Rect};
use sunroom::app::editor::camera::navigation::Navigation;
use sunroom::app::editor::camera::screen::Screen;
use sunroom::app::editor::command::axis_view::AxisView;
use sunroom::app::editor::command::grid_settings::GridSettings;
use sunroom::app::editor::command::{Command, SelectionCommand, ToolCommand, ViewCommand};
use sunroom::app::editor::picture::depths::Depths;
use sunroom::app::editor::viewport::axes_widget;
use sunroom::app::editor::viewport::grid;
use sunroom::render::camera::Camera;
use sunroom::render::film::Film;
use sunroom::render::tile::{PixelSum, TileSamples, tiles};

use crate::viewport::{SIZE, drag, keys, pose, screen, window};

/// A picture of 800 x 600 points from 2 units above the ground, looking 30 degrees down.
fn above() -> Screen {
    let pose = Affine3A::from_translation(Vec3::Y * 2.0) * Affine3A::from_rotation_x(30f32.to_radians());
    Screen {
        camera: Camera::new(pose, 60.0, 4.0 / 3.0, 0.01, 1000.0, None),
        picture: Rect::from_min_size(Pos2::ZERO, SIZE),
    }
}

/// A film on which everything is as far away as this.
fn film(depth: f32) -> Film {
    let mut film = Film::new(32, 24);
    for tile in tiles(32, 24) {
        let pixel = PixelSum {
            depth,
            ..PixelSum::default()
        };
        film.add(&TileSamples {
            tile,
            samples: 0..1,
            pixels: vec![pixel; (tile.width * tile.height) as usize],
            blocks: None,
            layers: Default::default(),
            first_hits: Vec::new(),
            splats: Default::default(),
            rays: 0,
            invalid: 0,
        });
    }
    film
}

fn lines(screen: &Screen, depths: Depths) -> egui::Mesh {
    grid::mesh(screen, Vec3::Y, &GridSettings::default(), depths)
}

#[test]
fn the_grid_is_in_the_picture_and_has_few_triangles() {
    let mesh = lines(&above(), Depths::default());
    assert!(mesh.is_valid());
    let count = mesh.indices.len() / 3;
    assert!((200..40_000).contains(&count), "{count}");
    let picture = Rect::from_min_size(Pos2::ZERO, SIZE).expand(2.5);
    assert!(mesh.vertices.iter().all(|vertex| picture.contains(vertex.pos)));
    let sky = Screen {
        camera: Camera::new(
            Affine3A::from_translation(Vec3::Y * 2.0) * Affine3A::from_rotation_x(-60f32.to_radians()),
            40.0,
            4.0 / 3.0,
            0.01,
            1000.0,
            None,
        ),
        ..above()
    };
    assert!(
        lines(&sky, Depths::default()).indices.len() / 3 < 200,
        "there is no ground in the sky"
    );
}

#[test]
fn what_is_nearer_hides_the_grid_and_what_is_farther_does_not() {
    let free = lines(&above(), Depths::default());
    let (near, far) = (film(0.1), film(1e6));
    assert_eq!(lines(&above(), Depths::of(&near)).indices.len(), 0);
    assert_eq!(lines(&above(), Depths::of(&far)).indices.len(), free.indices.len());
    // Nothing is hit in the sky.
    let empty = film(0.0);
    assert_eq!(lines(&above(), Depths::of(&empty)).indices.len(), free.indices.len());
    // Up to a distance of 4 units the ground is seen, and not behind that.
    let some = film(4.0);
    let cut = lines(&above(), Depths::of(&some));
    assert!(!cut.indices.is_empty() && cut.indices.len() < free.indices.len());
    let at = |vertex: &egui::epaint::Vertex| {
        let ray = above().ray(vertex.pos);
        let t = -ray.origin.y / ray.dir.y;
        ray.dir.length() * t
    };
    let farthest = cut.vertices.iter().map(at).fold(0.0, f32::max);
    assert!(farthest < 5.0, "{farthest}");
}

#[test]
fn a_parallel_view_from_the_front_has_a_grid_of_squares() {
    let front = Screen {
        camera: Camera::orthographic(pose(), Vec2::new(8.0, 6.0), 0.01, 1000.0),
        ..above()
    };
    let mesh = lines(&front, Depths::default());
    // A unit is 50 points wide. Lines run over the whole picture both ways.
    let reach = |of: fn(&egui::epaint::Vertex) -> f32| {
        let places = mesh.vertices.iter().map(of);
        places.clone().fold(f32::MAX, f32::min)..places.fold(f32::MIN, f32::max)
    };
    let (x, y) = (reach(|vertex| vertex.pos.x), reach(|vertex| vertex.pos.y));
    assert!(
        x.start < 10.0 && x.end > 790.0 && y.start < 10.0 && y.end > 590.0,
        "{x:?} {y:?}"
    );
}

fn corner() -> Rect {
    Rect::from_min_size(Pos2::ZERO, SIZE)
}

fn end_of(direction: Vec3) -> Pos2 {
    let ends = axes_widget::ends(corner(), &pose());
    ends.iter()
        .find(|end| end.direction == direction)
        .expect("one of six")
        .at
}

#[test]
fn a_click_on_an_axis_looks_along_it() {
    // The camera looks along +z with +x to the left.
    let middle = axes_widget::place(corner()).center();
    assert!(end_of(Vec3::X).x < middle.x && end_of(Vec3::Y).y < middle.y);
    for (axis, view) in [
        (Vec3::X, AxisView::Right),
        (Vec3::NEG_X, AxisView::Left),
        (Vec3::Y, AxisView::Top),
        (Vec3::NEG_Y, AxisView::Bottom),
        // The view is from there: the other side is meant.
        (Vec3::NEG_Z, AxisView::Front),
    ] {
        let mut harness = window();
        let at = end_of(axis);
        drag(&mut harness, PointerButton::Primary, at, at, Modifiers::NONE, true);
        harness.run_steps(1);
        assert_eq!(
            harness.state().commands,
            [Command::from(ViewCommand::LookAlong(view))],
            "{axis}"
        );
    }
}

#[test]
fn a_drag_of_the_axes_orbits() {
    let mut harness = window();
    let from = axes_widget::place(corner()).center() + egui::vec2(4.0, 22.0);
    let to = from + egui::vec2(60.0, 0.0);
    drag(&mut harness, PointerButton::Primary, from, to, Modifiers::NONE, true);
    let views: Vec<Affine3A> = (harness.state().commands.iter())
        .filter_map(|command| match command {
            Command::View(ViewCommand::MoveView(pose)) => Some(*pose),
            _ => None,
        })
        .collect();
    assert!(!views.is_empty() && views.len() + 1 == harness.state().commands.len());
    // About the selected cube, which is at the origin.
    assert_eq!(
        harness.state().commands[0],
        Command::from(ViewCommand::TurnAbout(Vec3::ZERO))
    );
    assert!(views.iter().all(|view| (view.translation.length() - 10.0).abs() < 1e-3));
}

#[test]
fn the_axes_of_a_world_with_z_up_have_views_too() {
    let navigation = Navigation {
        up: Vec3::Z,
        ..Navigation::default()
    };
    assert_eq!(navigation.view_from(Vec3::Z), AxisView::Top);
    assert_eq!(navigation.view_from(Vec3::NEG_Y), AxisView::Front);
    assert_eq!(navigation.view_from(Vec3::X), AxisView::Right);
    assert_eq!(Navigation::default().view_from(Vec3::Z), AxisView::Front);
}

#[test]
fn two_clicks_measure_a_distance_on_the_ground() {
    let mut harness = window();
    keys(&mut harness, &[Key::M]);
    harness.state_mut().camera = above().camera;
    for end in [Vec3::new(1.0, 0.0, 3.0), Vec3::new(-2.0, 0.0, 7.0)] {
        let at = screen(harness.state()).project(end).expect("in front");
        drag(&mut harness, PointerButton::Primary, at, at, Modifiers::NONE, true);
    }
    harness.run_steps(1);
    let measured = harness.state().commands.iter().find_map(|command| match command {
        Command::Tool(ToolCommand::AddRuler(ruler)) => Some(*ruler),
        _ => None,
    });
    let ruler = measured.expect("a distance");
    assert!((ruler.length() - 5.0).abs() < 1e-2, "{ruler:?}");
    let selects = |command: &Command| {
        matches!(
            command,
            Command::Selection(SelectionCommand::Pick(..) | SelectionCommand::Select(..))
        )
    };
    assert!(!harness.state().commands.iter().any(selects));
}
