//! Lamps that are found from the light that is wanted, in rendered scenes: those that made a picture come back, with
//! their strengths, colours, places and hours.

use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;

use bevy::prelude::*;
use sunroom::app::headless::headless;
use sunroom::color::Rgb;
use sunroom::engine::lamp_freedom::{FreeLamp, LampChange, LampFreedom};
use sunroom::engine::placing::{FoundLamps, LampSearch};
use sunroom::engine::{Limits, PackedScene, RenderControl, load_to_completion};
use sunroom::inverse_lighting::{Fit, LampLight, LampLimits, Painting, PixelLight, Seen, Stroke, Target, Wish, solve};
use sunroom::light::{LightId, WeightedSource};
use sunroom::render::film::Film;
use sunroom::render::lamps_alone::{Quantity, light_of_pixels};
use sunroom::render::scene::RenderScene;
use sunroom::render::view::View;
use sunroom::scene::{OpenScene, SceneId, SunPosition};

use crate::support::render;

const SIZE: UVec2 = UVec2::new(96, 64);

fn opened(path: PathBuf) -> App {
    let mut app = headless(OpenScene { path, ..default() }, Some(2));
    let mut control = app.world_mut().resource_mut::<RenderControl>();
    control.film_size_override = Some(SIZE);
    control.light_layers = true;
    let loaded = load_to_completion(&mut app, &Limits::default());
    assert!(loaded.expect("a scene that can be loaded"));
    app.update();
    app
}

fn sample(name: &str) -> App {
    opened(Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes").join(name))
}

/// A scene with these emitters and shapes between a floor of 6 x 6 and two walls, seen from above.
fn room(content: &str) -> App {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("room.xml");
    let text = format!(
        r#"<scene version="3.0.0">
  <integrator type="path"><integer name="max_depth" value="4"/></integrator>
  <sensor type="perspective"><float name="fov" value="53"/>
    <transform name="to_world"><lookat origin="0, 6, 0" target="0, 0, 0" up="0, 0, -1"/></transform>
    <film type="hdrfilm"/><sampler type="independent"/>
  </sensor>
  <bsdf type="diffuse" id="white"><rgb name="reflectance" value="0.6"/></bsdf>
  <shape type="rectangle"><transform name="to_world"><scale value="3"/><rotate x="1" angle="-90"/></transform><ref id="white"/></shape>
  <shape type="rectangle"><transform name="to_world"><scale value="3"/><translate z="-3" y="1"/></transform><ref id="white"/></shape>
  <shape type="rectangle"><transform name="to_world"><scale value="3"/><rotate y="1" angle="90"/><translate x="-3" y="1"/></transform><ref id="white"/></shape>
  {content}
</scene>"#
    );
    std::fs::write(&path, text).expect("a file");
    opened(path)
}

/// A room with a grid of lamps of several kinds close to the floor.
fn lamps(columns: u32, rows: u32) -> App {
    let mut content = String::new();
    for lamp in 0..columns * rows {
        let at = |place: u32, of: u32, width: f32| width * ((place as f32 + 0.5) / of as f32 - 0.5);
        let (x, z) = (at(lamp % columns, columns, 6.0), at(lamp / columns, rows, 4.0));
        let red = 0.5 + 0.5 * (lamp % 3) as f32;
        let kind = match lamp % 3 {
            0 => format!(
                r#"<emitter type="point" id="lamp-{lamp}"><point name="position" x="{x}" y="0.3" z="{z}"/>
                <rgb name="intensity" value="{red}, 0.8, 0.6"/></emitter>"#
            ),
            1 => format!(
                r#"<emitter type="spot" id="lamp-{lamp}"><transform name="to_world">
                <lookat origin="{x}, 0.8, {z}" target="{x}, 0, {z}" up="0, 0, 1"/></transform>
                <float name="cutoff_angle" value="35"/><rgb name="intensity" value="{red}, 1, 0.7"/></emitter>"#
            ),
            _ => format!(
                r#"<shape type="rectangle" id="lamp-{lamp}"><transform name="to_world"><scale value="0.15"/>
                <rotate x="1" angle="90"/><translate x="{x}" y="0.4" z="{z}"/></transform><ref id="white"/>
                <emitter type="area"><rgb name="radiance" value="{red}, 9, 7"/></emitter></shape>"#
            ),
        };
        writeln!(content, "{kind}").expect("a text");
    }
    room(&content)
}

/// A film whose lamps are unknown.
struct FilmLight(Film);

impl FilmLight {
    fn lamps(&self) -> usize {
        self.0.layers().groups
    }

    /// Its picture with the lamps at these gains, as a target.
    fn target(&self, gains: &[Rgb]) -> Target {
        Target::Picture(self.0.mixed(gains).into_iter().map(Some).collect())
    }

    fn fit(&self, targets: Vec<Target>, limits: &[LampLimits]) -> Fit {
        solve(&Painting::observe_all(targets, self, self.lamps()), limits).expect("an answer")
    }
}

impl LampLight for FilmLight {
    fn size(&self) -> [u32; 2] {
        [self.0.width(), self.0.height()]
    }

    fn at(&self, x: u32, y: u32, light: &mut [Rgb]) -> Option<Seen> {
        let rest = self.0.light_of_groups(x, y, light)?;
        Some(Seen {
            rest,
            present: rest + light.iter().sum::<Rgb>(),
        })
    }

    fn irradiance_at(&self, _: u32, _: u32, _: &mut [Rgb]) -> Option<Seen> {
        None
    }
}

fn packed(app: &App) -> (RenderScene, View) {
    let packed = app.world().resource::<PackedScene>();
    (
        packed.scene.clone().expect("packed"),
        packed.view.clone().expect("packed"),
    )
}

fn film(app: &App, seed: u32, samples: u32) -> FilmLight {
    let (scene, mut view) = packed(app);
    view.seed = seed;
    FilmLight(render(&scene, &view, samples))
}

/// The true gain of a lamp.
fn truth(lamp: usize) -> Rgb {
    [0.5, 2.0, 1.2, 0.8, 1.5][lamp % 5] * Rgb::new(1.0, 0.9 - 0.1 * (lamp % 4) as f32, 0.7)
}

fn colored(lamps: usize) -> Vec<LampLimits> {
    let lamp = LampLimits {
        colored: true,
        ..LampLimits::of_strength(10.0)
    };
    vec![lamp; lamps]
}

/// Pictures with known strengths and colours of the lamps give these back, within 1 % and three standard errors of the
/// noise. Each picture and the layers that it is compared with are of different random numbers.
fn check(name: &str, app: &App, lamps: usize) {
    const ROUNDS: usize = 4;
    let films: Vec<FilmLight> = (0..ROUNDS).map(|round| film(app, round as u32, 64)).collect();
    assert_eq!(films[0].lamps(), lamps, "{name}");
    let gains: Vec<Rgb> = (0..lamps).map(truth).collect();
    let fits: Vec<Fit> = (0..ROUNDS)
        .map(|round| films[round].fit(vec![films[(round + 1) % ROUNDS].target(&gains)], &colored(lamps)))
        .collect();
    for (lamp, truth) in gains.iter().enumerate() {
        for channel in 0..3 {
            let found: Vec<f32> = fits.iter().map(|fit| fit.gains[lamp][channel]).collect();
            let mean = found.iter().sum::<f32>() / ROUNDS as f32;
            let squares: f32 = found.iter().map(|found| (found - mean).powi(2)).sum();
            let noise = (squares / (ROUNDS * (ROUNDS - 1)) as f32).sqrt();
            let (error, truth) = ((mean - truth[channel]).abs(), truth[channel]);
            assert!(
                noise < 0.05 * truth,
                "{name}, lamp {lamp}: {found:?} say nothing of {truth}"
            );
            assert!(
                error < 0.01 * truth + 3.0 * noise,
                "{name}, lamp {lamp}: {mean} ± {noise}, not {truth}"
            );
        }
    }
}

#[test]
fn lamps_of_sample_scenes_come_back() {
    for (name, lamps) in [("lamps.xml", 4), ("desk.xml", 3), ("meadow.xml", 2)] {
        check(name, &sample(name), lamps);
    }
}

#[test]
fn twelve_and_twenty_four_lamps_come_back() {
    check("12 lamps", &lamps(4, 3), 12);
    check("24 lamps", &lamps(6, 4), 24);
}

/// The light of each lamp alone sums up to the picture, and is the lamp's layer.
#[test]
fn lamps_alone_have_the_light_of_their_layers() {
    let app = lamps(3, 2);
    let film = film(&app, 1, 256);
    let (scene, view) = packed(&app);
    let packed = app.world().resource::<PackedScene>();
    let pixels: Vec<UVec2> = (0..SIZE.y)
        .flat_map(|y| (0..SIZE.x).map(move |x| UVec2::new(x, y)))
        .collect();
    for (number, source) in packed.lamps.sources.iter().enumerate() {
        let alone: [(LightId, WeightedSource); 1] = [(LightId(number as u32), source.clone())];
        let alone = scene.lit_by_own(&alone);
        let cancel = AtomicBool::new(false);
        let light = light_of_pixels(&alone, &view, Quantity::Radiance, &pixels, 64, &cancel).expect("not cancelled");
        let sum: Rgb = light.iter().flatten().sum();
        let layer: Rgb = film.0.light_group(number).expect("a layer").iter().sum();
        assert!(
            ((sum - layer) / layer).abs().max_element() < 0.03,
            "{number}: {sum} {layer}"
        );
    }
}

/// The targets, the present light and all else of a search, with the lamp of this id free to change.
fn search(app: &App, id: &str, freedom: LampFreedom, targets: Vec<Target>) -> FoundLamps {
    let film = film(app, 1, 64);
    let packed = app.world().resource::<PackedScene>();
    let entity = lamp(app, id);
    let lamps = film.lamps();
    let mut painting = Painting::default();
    painting.set(targets.clone(), film.size(), lamps);
    let owners = &packed.lamps.owners;
    let number = owners.iter().position(|owner| *owner == entity).expect("it shines");
    let free = FreeLamp::new(app.world(), &packed.lamps, entity, freedom).expect("it can change");
    let found = LampSearch {
        scene: packed.scene.clone().expect("packed"),
        view: packed.view.clone().expect("packed"),
        free: vec![(free, number)],
        limits: vec![LampLimits::of_strength(5.0); lamps],
        light: PixelLight::of(&painting, &film, lamps, 4096),
        targets,
        samples: 1 << 15,
    }
    .run(&AtomicBool::new(false), &mut |_, _| ());
    found.expect("an answer")
}

fn lamp(app: &App, id: &str) -> Entity {
    let owners = &app.world().resource::<PackedScene>().lamps.owners;
    let has_id = |owner: &&Entity| app.world().get::<SceneId>(**owner).is_some_and(|found| found.0 == id);
    *owners.iter().find(has_id).expect("a lamp of this id")
}

/// The picture of a scene with only these lights and gains, as a target.
fn picture(app: &App, gains: &[Rgb]) -> Target {
    film(app, 9, 256).target(gains)
}

const SPOT: &str = r#"<emitter type="spot" id="spot"><transform name="to_world">
    <lookat origin="{at}" target="{to}" up="0, 0, 1"/></transform>
    <float name="cutoff_angle" value="30"/><rgb name="intensity" value="9"/></emitter>
    <emitter type="constant" id="sky"><rgb name="radiance" value="0.2"/></emitter>"#;

fn spot(at: &str, to: &str) -> App {
    room(&SPOT.replace("{at}", at).replace("{to}", to))
}

#[test]
fn a_lamp_comes_back_to_its_place_and_aim() {
    let there = Vec3::new(-0.7, 1.9, -0.4);
    let wanted = picture(&spot("-0.7, 1.9, -0.4", "-1.2, 0, -0.6"), &[Rgb::splat(1.3), Rgb::ONE]);
    let app = spot("-0.3, 2.1, -0.6", "-0.3, 0, -0.6");
    let freedom = LampFreedom {
        radius: 0.8,
        turn: 30.0,
        ..LampFreedom::default()
    };
    let found = search(&app, "spot", freedom, vec![wanted]);
    let [LampChange::Motion(motion)] = found.changes[..] else {
        panic!("a motion: {found:?}");
    };
    let place = motion.transform_point3(Vec3::new(-0.3, 2.1, -0.6));
    let aim = motion.transform_vector3(-Vec3::Y);
    let right = (Vec3::new(-1.2, 0.0, -0.6) - there).normalize();
    assert!(place.distance(there) < 0.1, "{place}: {found:?}");
    assert!(aim.angle_between(right).to_degrees() < 3.0, "{aim}: {found:?}");
    assert!(found.errors[1] < 0.2 * found.errors[0], "{:?}", found.errors);
    assert_eq!(found.at_limit, [false]);
}

#[test]
fn a_shape_that_shines_moves_with_its_light() {
    let lamp = |x: f32| {
        room(&format!(
            r#"<shape type="rectangle" id="panel"><transform name="to_world"><scale value="0.3"/>
            <rotate x="1" angle="90"/><translate x="{x}" y="2" z="-1"/></transform><ref id="white"/>
            <emitter type="area"><rgb name="radiance" value="8"/></emitter></shape>"#
        ))
    };
    let freedom = LampFreedom {
        radius: 0.6,
        ..LampFreedom::default()
    };
    let found = search(&lamp(-0.5), "panel", freedom, vec![picture(&lamp(-0.9), &[])]);
    let [LampChange::Motion(motion)] = found.changes[..] else {
        panic!("a motion: {found:?}");
    };
    let moved = Vec3::from(motion.translation);
    assert!(moved.distance(Vec3::new(-0.4, 0.0, 0.0)) < 0.1, "{moved}: {found:?}");
}

fn under_the_sun(hour: f32) -> App {
    room(&format!(
        r#"<emitter type="sunsky" id="sun"><float name="hour" value="{hour}"/>
        <transform name="to_world"><rotate x="1" angle="-90"/></transform></emitter>
        <shape type="cube"><transform name="to_world"><scale x="0.2" y="0.8" z="0.2"/>
        <translate x="-1" y="0.8" z="-1"/></transform><ref id="white"/></shape>"#
    ))
}

#[test]
fn the_hour_of_the_sun_comes_back() {
    let freedom = LampFreedom {
        hours: Some([5.0, 19.0]),
        ..LampFreedom::default()
    };
    let found = search(
        &under_the_sun(10.0),
        "sun",
        freedom,
        vec![picture(&under_the_sun(15.4), &[])],
    );
    let [LampChange::Sun(sky)] = &found.changes[..] else {
        panic!("a sun: {found:?}");
    };
    let SunPosition::PlaceAndTime(at) = sky.sun else {
        panic!("a time: {sky:?}");
    };
    let hour = at.hour + at.minute / 60.0;
    assert!((hour - 15.4).abs() < 0.1, "{at:?}: {found:?}");
    assert!(found.errors[1] < 0.2 * found.errors[0], "{:?}", found.errors);
}

#[test]
fn what_cannot_change_is_said() {
    let app = under_the_sun(10.0);
    let packed = app.world().resource::<PackedScene>();
    let sun = lamp(&app, "sun");
    let say = |freedom| FreeLamp::new(app.world(), &packed.lamps, sun, freedom).map(|_| ());
    let moving = LampFreedom {
        radius: 1.0,
        ..LampFreedom::default()
    };
    assert_eq!(say(moving), Err("cannot change in this way"));
    let app = spot("0, 2, 0", "0, 0, 0");
    let sky = lamp(&app, "sky");
    let packed = app.world().resource::<PackedScene>();
    let say = FreeLamp::new(app.world(), &packed.lamps, sky, moving).map(|_| ());
    assert_eq!(say, Err("shines from all around, and can neither move nor be aimed"));
    let hours = LampFreedom {
        hours: Some([0.0, 24.0]),
        ..LampFreedom::default()
    };
    let say = FreeLamp::new(app.world(), &packed.lamps, lamp(&app, "spot"), hours).map(|_| ());
    assert_eq!(say, Err("is no sun, and has no hour and no day"));
}

/// Of contradictory strokes the sliders one at a time do not find the best strengths, which least squares does.
#[test]
fn a_painted_target_is_met_better_than_by_sliders_one_at_a_time() {
    let film = film(&lamps(4, 3), 3, 64);
    let stroke = |wish, x: f32, y: f32| {
        Target::Stroke(Stroke {
            wish,
            path: vec![Vec2::new(x, y)],
            radius: 0.2,
            hardness: 0.5,
        })
    };
    let targets = vec![
        stroke(Wish::Brighter(3.0), 0.3, 0.5),
        stroke(Wish::Darker(3.0), 0.55, 0.55),
        stroke(Wish::Color(Rgb::new(1.0, 0.6, 0.3)), 0.7, 0.7),
        stroke(Wish::Keep, 0.15, 0.7),
    ];
    let limits = vec![LampLimits::of_strength(10.0); film.lamps()];
    let fit = film.fit(targets.clone(), &limits);
    let observations = Painting::observe_all(targets, &film, film.lamps());
    let error = |gains: &[Rgb]| {
        observations
            .residuals(gains)
            .iter()
            .map(|error| error * error)
            .sum::<f64>()
            .sqrt()
    };
    assert!((error(&fit.gains) - fit.error).abs() < 1e-6);
    // A person who moves each slider once to where it looks best.
    let mut by_hand = vec![Rgb::ONE; film.lamps()];
    for lamp in 0..film.lamps() {
        let tried = |step: usize| {
            let mut gains = by_hand.clone();
            gains[lamp] = Rgb::splat(10.0 * step as f32 / 400.0);
            gains
        };
        let best = (0..=400)
            .map(tried)
            .min_by(|one, other| error(one).total_cmp(&error(other)));
        by_hand = best.expect("some were tried");
    }
    assert!(fit.error < 0.97 * error(&by_hand), "{} {}", fit.error, error(&by_hand));
    assert!(error(&by_hand) < error(&vec![Rgb::ONE; film.lamps()]));
}
