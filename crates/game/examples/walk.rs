//! Walks through a level: `cargo run --release --example walk -- FOLDER`, with the folder that `sunroom bake -o` wrote.
//!
//! W, A, S, D and the arrow keys move, Q and E go down and up, the right mouse button turns. The camera begins where
//! the level's first one is.
//!
//! | option | meaning |
//! |---|---|
//! | `--camera NAME` | begins with this camera of the level |
//! | `--size WxH` | the size of the window, or of the picture, in pixels |
//! | `--exposure STOPS` | the exposure (0) |
//! | `--bicubic` | filters lightmaps bicubically |
//! | `--ball X,Y,Z,RADIUS,METALLIC,ROUGHNESS` | adds a grey ball of the game's own, which has no lightmap; may be given again |
//! | `--screenshot OUT` | opens no window, saves a picture once everything is loaded, and ends: linear if it is an EXR file, else sRGB |

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Duration;

use bevy::app::ScheduleRunnerPlugin;
use bevy::asset::AssetPlugin;
use bevy::camera::{Hdr, RenderTarget};
use bevy::core_pipeline::tonemapping::Tonemapping;
use bevy::input::mouse::AccumulatedMouseMotion;
use bevy::prelude::*;
use bevy::render::RenderPlugin;
use bevy::render::render_resource::TextureFormat;
use bevy::render::view::screenshot::{Screenshot, ScreenshotCaptured};
use bevy::window::ExitCondition;
use bevy::winit::WinitPlugin;
use bevy::world_serialization::WorldInstanceReady;
use image::{DynamicImage, Rgb, Rgb32FImage};
use sunroom_game::{LevelReady, SunroomLevel, SunroomLevelPlugin, exposure};

/// Units of length per second, and radians per pixel.
const SPEED: f32 = 2.0;
const TURN: f32 = 0.003;
/// Frames after which all that is loaded has come to the graphics card.
const FRAMES: u32 = 10;

#[derive(Resource, Clone)]
struct Arguments {
    folder: PathBuf,
    camera: Option<String>,
    size: UVec2,
    exposure: f32,
    bicubic: bool,
    balls: Vec<Ball>,
    screenshot: Option<PathBuf>,
}

/// A ball that is no part of the level.
#[derive(Clone, Copy)]
struct Ball {
    center: Vec3,
    radius: f32,
    metallic: f32,
    /// Perceptual.
    roughness: f32,
}

/// The picture that cameras draw where there is no window.
#[derive(Resource)]
struct Target(Handle<Image>);

fn main() -> ExitCode {
    let arguments = match Arguments::read(std::env::args().skip(1)) {
        Ok(arguments) => arguments,
        Err(message) => {
            eprintln!("{message}");
            return ExitCode::from(2);
        }
    };
    let folder = std::path::absolute(&arguments.folder).unwrap_or(arguments.folder.clone());
    let parent = folder.parent().unwrap_or(Path::new("/"));
    let assets = AssetPlugin {
        file_path: parent.to_string_lossy().into_owned(),
        ..default()
    };
    let mut app = App::new();
    if arguments.screenshot.is_some() {
        let window = WindowPlugin {
            primary_window: None,
            exit_condition: ExitCondition::DontExit,
            ..default()
        };
        let render = RenderPlugin {
            synchronous_pipeline_compilation: true,
            ..default()
        };
        let plugins = DefaultPlugins.set(assets).set(window).set(render);
        app.add_plugins((
            plugins.disable::<WinitPlugin>(),
            ScheduleRunnerPlugin::run_loop(Duration::ZERO),
        ))
        .add_systems(Startup, make_target)
        .add_systems(Update, take_picture);
    } else {
        let window = WindowPlugin {
            primary_window: Some(Window {
                title: "Sunroom level".into(),
                resolution: (arguments.size.x, arguments.size.y).into(),
                ..default()
            }),
            ..default()
        };
        app.add_plugins(DefaultPlugins.set(assets).set(window))
            .add_systems(Update, walk);
    }
    app.add_plugins(SunroomLevelPlugin)
        .insert_resource(ClearColor(Color::BLACK))
        .insert_resource(arguments)
        .add_systems(Startup, setup)
        .add_observer(equip_cameras)
        .add_systems(Update, choose_camera);
    match app.run() {
        AppExit::Success => ExitCode::SUCCESS,
        AppExit::Error(_) => ExitCode::FAILURE,
    }
}

impl Arguments {
    fn read(mut words: impl Iterator<Item = String>) -> Result<Self, String> {
        let mut arguments = Self {
            folder: PathBuf::new(),
            camera: None,
            size: UVec2::new(1280, 720),
            exposure: 0.0,
            bicubic: false,
            balls: Vec::new(),
            screenshot: None,
        };
        while let Some(word) = words.next() {
            let mut value = || words.next().ok_or(format!("{word} needs a value"));
            let wrong = |value: &str| format!("{word} cannot be `{value}`");
            match &*word {
                "--camera" => arguments.camera = Some(value()?),
                "--size" => {
                    let value = value()?;
                    let sides = value
                        .split_once('x')
                        .and_then(|(x, y)| Some((x.parse().ok()?, y.parse().ok()?)));
                    arguments.size = sides.ok_or(wrong(&value))?.into();
                }
                "--exposure" => {
                    let value = value()?;
                    arguments.exposure = value.parse().map_err(|_| wrong(&value))?;
                }
                "--ball" => {
                    let value = value()?;
                    let numbers: Result<Vec<f32>, _> = value.split(',').map(str::parse).collect();
                    let Ok(&[x, y, z, radius, metallic, roughness]) = numbers.as_deref() else {
                        return Err(wrong(&value));
                    };
                    arguments.balls.push(Ball {
                        center: Vec3::new(x, y, z),
                        radius,
                        metallic,
                        roughness,
                    });
                }
                "--bicubic" => arguments.bicubic = true,
                "--screenshot" => arguments.screenshot = Some(value()?.into()),
                _ if word.starts_with('-') => return Err(format!("there is no option {word}")),
                _ => arguments.folder = word.clone().into(),
            }
        }
        match arguments.folder.file_name() {
            Some(_) => Ok(arguments),
            None => Err(
                "usage: walk FOLDER [--camera NAME] [--size WxH] [--exposure STOPS] [--bicubic] \
                 [--ball X,Y,Z,RADIUS,METALLIC,ROUGHNESS]... [--screenshot OUT]"
                    .into(),
            ),
        }
    }
}

fn setup(
    mut commands: Commands,
    arguments: Res<Arguments>,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
) {
    for ball in &arguments.balls {
        let material = StandardMaterial {
            base_color: Color::linear_rgb(0.7, 0.7, 0.7),
            metallic: ball.metallic,
            perceptual_roughness: ball.roughness,
            // What is no metal is matt.
            reflectance: 0.0,
            ..default()
        };
        commands.spawn((
            Mesh3d(meshes.add(Sphere::new(ball.radius).mesh().uv(128, 64))),
            MeshMaterial3d(materials.add(material)),
            Transform::from_translation(ball.center),
        ));
    }
    let name = arguments.folder.file_name().unwrap_or_default();
    commands.spawn(SunroomLevel {
        bicubic: arguments.bicubic,
        cameras: true,
        ..SunroomLevel::new(name.to_string_lossy())
    });
}

/// Makes the cameras of the level draw as Sunroom does, where they should, before their first frame.
fn equip_cameras(
    _: On<WorldInstanceReady>,
    mut commands: Commands,
    target: Option<Res<Target>>,
    cameras: Query<Entity, With<Camera3d>>,
) {
    for camera in &cameras {
        let mut camera = commands.entity(camera);
        camera.insert(Tonemapping::None);
        if let Some(target) = &target {
            camera.insert((RenderTarget::Image(target.0.clone().into()), Hdr));
        }
    }
}

fn choose_camera(
    mut commands: Commands,
    arguments: Res<Arguments>,
    levels: Query<(), Added<LevelReady>>,
    mut cameras: Query<(Entity, &mut Camera, &Name)>,
) {
    if levels.is_empty() {
        return;
    }
    for (entity, mut camera, name) in &mut cameras {
        commands.entity(entity).insert(exposure(arguments.exposure));
        if let Some(wanted) = &arguments.camera {
            camera.is_active = name.as_str() == wanted;
        }
    }
    if !cameras.iter().any(|(_, camera, _)| camera.is_active) {
        error!("the level has no such camera");
        commands.write_message(AppExit::error());
    }
}

fn walk(
    keys: Res<ButtonInput<KeyCode>>,
    buttons: Res<ButtonInput<MouseButton>>,
    motion: Res<AccumulatedMouseMotion>,
    time: Res<Time>,
    mut cameras: Query<&mut Transform, With<Camera3d>>,
) {
    use KeyCode::*;
    let pressed = |wanted: [KeyCode; 2]| if keys.any_pressed(wanted) { 1.0 } else { 0.0 };
    let step = Vec3::new(
        pressed([KeyD, ArrowRight]) - pressed([KeyA, ArrowLeft]),
        pressed([KeyE, PageUp]) - pressed([KeyQ, PageDown]),
        pressed([KeyS, ArrowDown]) - pressed([KeyW, ArrowUp]),
    );
    for mut camera in &mut cameras {
        if buttons.pressed(MouseButton::Right) {
            let turn = -TURN * motion.delta;
            camera.rotate_axis(Dir3::Y, turn.x);
            camera.rotate_local_x(turn.y);
        }
        let rotation = camera.rotation;
        camera.translation += rotation * step * SPEED * time.delta_secs();
    }
}

fn make_target(mut commands: Commands, arguments: Res<Arguments>, mut images: ResMut<Assets<Image>>) {
    let UVec2 { x, y } = arguments.size;
    let image = Image::new_target_texture(x, y, TextureFormat::Rgba16Float, None);
    commands.insert_resource(Target(images.add(image)));
}

fn take_picture(
    mut commands: Commands,
    target: Res<Target>,
    levels: Query<(), With<LevelReady>>,
    mut frames: Local<u32>,
) {
    *frames += u32::from(!levels.is_empty());
    if *frames == FRAMES {
        commands.spawn(Screenshot::image(target.0.clone())).observe(save);
    }
}

fn save(captured: On<ScreenshotCaptured>, mut commands: Commands, arguments: Res<Arguments>) {
    let Some(path) = &arguments.screenshot else {
        return;
    };
    let picture = linear_picture(&captured.image);
    let is_linear = path.extension().is_some_and(|extension| extension == "exr");
    let saved = match is_linear {
        true => DynamicImage::from(picture).save(path),
        false => {
            let coded = |linear: f32| 255.0 * Color::linear_rgb(linear, 0.0, 0.0).to_srgba().red.clamp(0.0, 1.0);
            let pixel = |x, y| Rgb(picture.get_pixel(x, y).0.map(|linear| coded(linear).round() as u8));
            image::RgbImage::from_fn(picture.width(), picture.height(), pixel).save(path)
        }
    };
    let exit = match saved {
        Ok(()) => AppExit::Success,
        Err(error) => {
            error!("{}: {error}", path.display());
            AppExit::error()
        }
    };
    commands.write_message(exit);
}

/// A picture of half floats.
fn linear_picture(image: &Image) -> Rgb32FImage {
    let data = image.data.as_deref().unwrap_or_default();
    let values: Vec<f32> = data
        .chunks_exact(8)
        .flat_map(|pixel| {
            let channel = |at: usize| half::f16::from_le_bytes([pixel[2 * at], pixel[2 * at + 1]]).to_f32();
            [channel(0), channel(1), channel(2)]
        })
        .collect();
    Rgb32FImage::from_raw(image.width(), image.height(), values).unwrap_or_default()
}
