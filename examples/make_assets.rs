//! Makes the pictures in the folder `assets` that the program renders itself. Run it at the root of the repository:
//!
//! * `cargo run --release --example make_assets -- balls` makes the balls of the library of materials.
//! * `cargo run --release --example make_assets -- environments` makes the environment pictures.
//!
//! Each takes minutes. The environments are so bright that a white surface which lies flat under them reflects a
//! radiance of 1.

use std::error::Error;
use std::f32::consts::{PI, TAU};
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use bevy::math::{Affine3A, Mat3, Vec2, Vec3};
use rayon::prelude::*;
use sunroom::accel::{SplitMethod, Tlas};
use sunroom::app::editor::picture::ball_picture::make_shipped;
use sunroom::app::headless::headless;
use sunroom::color::{Rgb, luminance};
use sunroom::engine::{Limits, RenderFilm, load_to_completion, render_to_completion};
use sunroom::light::{Atmosphere, LightId, LightSource, LightTable};
use sunroom::render::denoise::{DenoiseInput, DenoiseQuality, denoise};
use sunroom::render::image_io::{ImageRgb, write_image};
use sunroom::render::tonemap::Display;
use sunroom::scene::{ActiveSensor, Film, OpenScene, Sensor, ToWorld};

fn main() -> Result<(), Box<dyn Error>> {
    match std::env::args().nth(1).as_deref() {
        Some("balls") => balls(),
        Some("environments") => environments(),
        _ => Err("say what to make: balls or environments".into()),
    }
}

fn balls() -> Result<(), Box<dyn Error>> {
    let (pictures, list) = make_shipped(|name| eprintln!("{name}"))?;
    fs::write("assets/library/balls.jpg", pictures)?;
    Ok(fs::write("assets/library/balls.txt", list)?)
}

fn environments() -> Result<(), Box<dyn Error>> {
    let folder = Path::new("assets/environments");
    let save = |name: &str, radiance: &(dyn Fn(Vec3) -> Rgb + Sync)| {
        eprintln!("{name}");
        write_image(&folder.join(name), &picture(radiance), &Display::default())
    };
    save("overcast.hdr", &above_ground(overcast, Rgb::new(0.19, 0.18, 0.16)))?;
    save("noon.hdr", &clear_sky(50.0, 3.0))?;
    save("evening.hdr", &clear_sky(6.0, 4.0))?;
    save("studio.hdr", &studio)?;
    let room = Panorama::render("scenes/flat.xml", Vec3::new(-1.0, 1.35, 0.4))?;
    save("living-room.hdr", &|direction| room.radiance(direction))?;
    Ok(())
}

/// Width and height of the pictures.
const SIZE: [u32; 2] = [768, 384];
/// The directions along each side of a pixel that are averaged, also for the sun, which is as large as a pixel.
const FINE: u32 = 16;

/// All directions as the program reads them: +y is up, the middle of the picture lies towards +z, and columns go on
/// towards -x.
fn picture(radiance: &(dyn Fn(Vec3) -> Rgb + Sync)) -> ImageRgb {
    let [width, height] = SIZE;
    let at = |x: f32, y: f32| {
        let (turn, theta) = (TAU * x / width as f32, PI * (y / height as f32).clamp(0.0, 1.0));
        Vec3::new(turn.sin() * theta.sin(), theta.cos(), -turn.cos() * theta.sin()).normalize()
    };
    let pixel = |place: u32| {
        // The first and the last row lie on the poles.
        let (left, middle) = (
            (place % width) as f32,
            (place / width) as f32 * height as f32 / (height - 1) as f32,
        );
        let offset = |part: u32| (part as f32 + 0.5) / FINE as f32;
        let parts = (0..FINE * FINE).map(|part| at(left + offset(part % FINE), middle - 0.5 + offset(part / FINE)));
        parts.map(radiance).sum::<Rgb>() / (FINE * FINE) as f32
    };
    let mut pixels: Vec<Rgb> = (0..width * height).into_par_iter().map(pixel).collect();
    // The irradiance of a surface that faces up, divided by pi.
    let share = |row: u32| {
        let theta = PI * row as f32 / (height - 1) as f32;
        theta.cos().max(0.0) * theta.sin() * (TAU / width as f32) * (PI / height as f32) / PI
    };
    let lit: f32 = (0..width * height)
        .map(|place| luminance(pixels[place as usize]) * share(place / width))
        .sum();
    pixels.iter_mut().for_each(|pixel| *pixel /= lit);
    ImageRgb { width, height, pixels }
}

/// A sky over ground of this albedo, which a flat surface's light from the sky lights.
fn above_ground(sky: impl Fn(Vec3) -> Rgb, albedo: Rgb) -> impl Fn(Vec3) -> Rgb {
    // Points of equal share of the irradiance: a spiral on the disk below the half sphere.
    const POINTS: u32 = 100_000;
    let point = |index: u32| {
        let radius = ((index as f32 + 0.5) / POINTS as f32).sqrt();
        let (sin, cos) = (2.399_963 * index as f32).sin_cos();
        Vec3::new(radius * cos, (1.0 - radius * radius).max(0.0).sqrt(), radius * sin)
    };
    let ground = albedo * ((0..POINTS).map(|index| sky(point(index))).sum::<Rgb>() / POINTS as f32);
    move |direction| match direction.y > 0.0 {
        true => sky(direction),
        false => ground,
    }
}

/// The overcast sky of the CIE: three times as bright at the zenith as at the horizon. Moon and Spencer, "Illumination
/// from a Non-Uniform Sky", 1942.
fn overcast(direction: Vec3) -> Rgb {
    Rgb::new(0.95, 1.0, 1.07) * ((1.0 + 2.0 * direction.y) / 3.0)
}

/// The sky of Hosek and Wilkie with its sun at this height in degrees, as the plugin `sunsky` has it.
fn clear_sky(height: f32, turbidity: f32) -> impl Fn(Vec3) -> Rgb {
    let (sin, cos) = height.to_radians().sin_cos();
    let atmosphere = Atmosphere {
        turbidity,
        albedo: Rgb::splat(0.2),
        // In the frame in which z points up; the middle of the picture is towards -y there.
        sun_direction: Vec3::new(0.5 * cos, -0.75_f32.sqrt() * cos, sin),
        sky_scale: 1.0,
        sun_scale: 1.0,
        sun_aperture: 0.5338_f32.to_radians(),
        limb_darkening: true,
    };
    let light = LightSource::SunSky {
        atmosphere,
        world_from_local: Mat3::from_rotation_x(-0.5 * PI),
    };
    let lights = LightTable::build(
        &[light.into()],
        &Tlas::build(Vec::new(), SplitMethod::Sah),
        &Arc::default(),
    );
    above_ground(
        move |direction| lights.radiance_from(LightId(0), direction),
        Rgb::new(0.22, 0.19, 0.15),
    )
}

/// Three soft boxes and a strip in a dark grey room: a large one at the left, a weaker one at the right, a narrow one
/// behind, and one overhead.
fn studio(direction: Vec3) -> Rgb {
    let walls = Rgb::splat(0.12 + 0.06 * direction.y);
    let boxes = [
        (
            Vec3::new(0.9, 0.55, 0.75),
            Vec2::new(0.55, 0.75),
            Rgb::new(1.0, 0.98, 0.95) * 9.0,
        ),
        (
            Vec3::new(-1.0, 0.25, 0.45),
            Vec2::new(0.35, 0.6),
            Rgb::new(0.92, 0.96, 1.0) * 3.5,
        ),
        (
            Vec3::new(-0.35, 0.5, -1.0),
            Vec2::new(0.12, 0.7),
            Rgb::new(1.0, 1.0, 1.0) * 12.0,
        ),
        (
            Vec3::new(0.05, 1.0, 0.02),
            Vec2::new(0.6, 0.25),
            Rgb::new(1.0, 1.0, 1.0) * 6.0,
        ),
    ];
    boxes.into_iter().fold(walls, |light, (towards, half, radiance)| {
        let front = towards.normalize();
        let across = Vec3::Y.cross(front).normalize();
        let ahead = direction.dot(front);
        if ahead <= 0.0 {
            return light;
        }
        // The place on the plane of the box, at distance 1.
        let at = Vec2::new(direction.dot(across), direction.dot(front.cross(across))) / ahead;
        // The cloth is brightest where the lamp is behind it.
        let glow = 1.0 - 0.35 * (at / half).length_squared().min(2.0) / 2.0;
        let edge = |distance: f32| (0.5 + distance / 0.02).clamp(0.0, 1.0);
        let inside = edge(half.x - at.x.abs()) * edge(half.y - at.y.abs());
        light.lerp(radiance * glow, inside)
    })
}

/// What is seen from one place in all directions, as the six sides of a cube.
struct Panorama {
    /// The pose of the camera, and the picture that it took.
    sides: Vec<(Affine3A, Vec<Rgb>)>,
}

/// The pixels along each side of a picture of one side of the cube.
const SIDE: u32 = 320;
/// The field of view in degrees. It is somewhat more than a right angle: the denoiser does not know what is beyond the
/// border.
const FIELD: f32 = 94.0;
const SAMPLES: u32 = 64;

impl Panorama {
    fn render(scene: &str, place: Vec3) -> Result<Self, Box<dyn Error>> {
        let request = OpenScene {
            path: PathBuf::from(scene),
            ..OpenScene::default()
        };
        let mut app = headless(request, None);
        let limits = Limits {
            samples: Some(SAMPLES),
            ..Limits::default()
        };
        load_to_completion(&mut app, &limits)?;
        let camera = app
            .world()
            .resource::<ActiveSensor>()
            .0
            .ok_or("the scene has no camera")?;
        let film = Film {
            width: SIDE,
            height: SIDE,
            ..Film::default()
        };
        let sensor = Sensor {
            fov: FIELD,
            ..Sensor::default()
        };
        app.world_mut().entity_mut(camera).insert((film, sensor));
        let mut sides = Vec::new();
        for (number, front) in Vec3::AXES.into_iter().flat_map(|axis| [axis, -axis]).enumerate() {
            eprintln!("side {} of 6", number + 1);
            let up = if front.y == 0.0 { Vec3::Y } else { Vec3::Z };
            let left = up.cross(front);
            let pose = Affine3A::from_mat3_translation(Mat3::from_cols(left, up, front), place);
            app.world_mut().entity_mut(camera).insert(ToWorld(pose));
            render_to_completion(&mut app, &limits, |_| {})?;
            let film = &app.world().resource::<RenderFilm>().film;
            let (color, albedo, normal) = (film.radiance(), film.albedo(), film.normal());
            let input = DenoiseInput {
                width: SIDE,
                height: SIDE,
                color: &color,
                albedo: Some(&albedo),
                normal: Some(&normal),
                prefilter: true,
                quality: DenoiseQuality::High,
                threads: None,
            };
            sides.push((pose, denoise(&input, &AtomicBool::new(false))?));
        }
        Ok(Self { sides })
    }

    fn radiance(&self, direction: Vec3) -> Rgb {
        let ahead = |pose: &Affine3A| direction.dot(pose.matrix3.z_axis.into());
        let side = self.sides.iter().max_by(|(a, _), (b, _)| ahead(a).total_cmp(&ahead(b)));
        let Some((pose, pixels)) = side else { return Rgb::ZERO };
        let local = Vec3::from(pose.matrix3.transpose() * bevy::math::Vec3A::from(direction));
        let half = (0.5 * FIELD.to_radians()).tan();
        // +x is to the left in the picture, and +y is up.
        let at =
            |along: f32| ((0.5 - 0.5 * along / (local.z * half)) * SIDE as f32 - 0.5).clamp(0.0, (SIDE - 1) as f32);
        let (x, y) = (at(local.x), at(local.y));
        let (column, row) = (x as u32, y as u32);
        let pixel = |column: u32, row: u32| pixels[(row.min(SIDE - 1) * SIDE + column.min(SIDE - 1)) as usize];
        let upper = pixel(column, row).lerp(pixel(column + 1, row), x.fract());
        let lower = pixel(column, row + 1).lerp(pixel(column + 1, row + 1), x.fract());
        upper.lerp(lower, y.fract())
    }
}
