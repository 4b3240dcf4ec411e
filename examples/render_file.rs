//! Renders a scene file to a picture: `cargo run --release --example render_file -- scenes/materials.xml out.png 64`
//!
//! The file may be anything that the program opens: Mitsuba's XML, the course project's XML, glTF. The picture is EXR,
//! HDR or PNG, by its name. Without arguments it renders the Cornell box.

use std::error::Error;
use std::path::PathBuf;

use sunroom::app::headless::render_only;
use sunroom::engine::{Limits, RenderFilm, RenderStatus, load_to_completion, render_to_completion};
use sunroom::render::image_io::{ImageRgb, write_image};
use sunroom::render::tonemap::Display;
use sunroom::scene::{OpenScene, SceneStatus};

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let scene = arguments.next().unwrap_or("scenes/cornell-box.xml".to_owned());
    let output = arguments.next().unwrap_or("render_file.png".to_owned());
    let samples = arguments.next().map_or(Ok(32), |number| number.parse())?;

    // A Bevy app with the scene and the engine, and without a window. `None`: as many threads as there are cores.
    let request = OpenScene {
        path: PathBuf::from(scene),
        ..OpenScene::default()
    };
    let mut app = render_only(request, None);
    let limits = Limits {
        samples: Some(samples),
        ..Limits::default()
    };

    // Loading tells everything that is wrong with the file, with line and column.
    let loaded = load_to_completion(&mut app, &limits);
    let status = app.world().resource::<SceneStatus>();
    eprint!("{}", status.diagnostics.render(false));
    loaded?;
    if app.world().resource::<SceneStatus>().has_errors() {
        return Err("the scene has errors".into());
    }

    // The closure is called after every update of the app.
    let show = |status: &RenderStatus| eprint!("\r{} of {} samples", status.samples, status.target);
    render_to_completion(&mut app, &limits, show)?;
    eprintln!();

    // The film holds linear radiance; `Display` is what becomes of it in a PNG file.
    let film = &app.world().resource::<RenderFilm>().film;
    let image = ImageRgb {
        width: film.width(),
        height: film.height(),
        pixels: film.radiance(),
    };
    write_image(output.as_ref(), &image, &Display::default())?;
    Ok(())
}
