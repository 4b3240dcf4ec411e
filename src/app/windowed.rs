//! The program with a window: Bevy's window and renderer, the scene, the engine and the editor.

use std::io::IsTerminal;
use std::process::ExitCode;

use bevy::app::TerminalCtrlCHandlerPlugin;
use bevy::log::{BoxedFmtLayer, LogPlugin, tracing_subscriber};
use bevy::prelude::*;
use bevy::render::RenderPlugin;
use bevy::render::renderer::RenderAdapter;
use bevy::render::settings::{Backends, RenderCreation, WgpuSettings};
use bevy::window::{PresentMode, WindowResolution};
use thiserror::Error;

use super::allocator::keep_memory_low;
use super::interrupt::on_interrupt;
use super::terminal::line;
use super::threads::{run_systems_in_turn, worker_count};
use crate::app::editor::EditorPlugin;
pub use crate::app::editor::session::options::WindowOptions;
use crate::app::editor::session::window_place;
use crate::engine::{EnginePlugin, RenderControl};
use crate::scene::{FileSourcePlugin, ScenePlugin, asset_plugin};

/// The reason why the window is not opened.
#[derive(Debug, Error)]
#[allow(missing_docs, reason = "the messages say what the variants mean")]
pub enum WindowError {
    #[error(
        "there is no display to open a window on (neither WAYLAND_DISPLAY nor DISPLAY is set); `sunroom render SCENE -o OUT.png` works without one"
    )]
    NoDisplay,
    #[error("signals cannot be handled: {0}")]
    Signals(#[from] ctrlc::Error),
}

/// Opens the window and returns when it is closed.
pub fn run(options: WindowOptions) -> Result<ExitCode, WindowError> {
    if !has_display() {
        return Err(WindowError::NoDisplay);
    }
    keep_memory_low();
    explain_startup_panics();
    on_interrupt(TerminalCtrlCHandlerPlugin::gracefully_exit)?;
    Ok(match windowed(options).run() {
        AppExit::Success => ExitCode::SUCCESS,
        AppExit::Error(code) => ExitCode::from(code.get()),
    })
}

/// The app with a window, not yet running.
pub fn windowed(options: WindowOptions) -> App {
    let mut app = App::new();
    let remembered = match options.size {
        Some(_) => None,
        None => window_place::remembered(options.is_attended()),
    };
    let [width, height] = match (options.size, remembered) {
        (Some(size), _) => size.to_array(),
        (None, Some(place)) => place.size,
        (None, None) => WindowOptions::FIRST_SIZE,
    };
    let position = remembered.and_then(|place| place.position);
    let window = Window {
        title: "Sunroom".to_owned(),
        name: Some("sunroom".to_owned()),
        resolution: WindowResolution::new(width, height),
        position: position.map_or_else(WindowPosition::default, |at| WindowPosition::At(at.into())),
        present_mode: PresentMode::AutoVsync,
        desired_maximum_frame_latency: std::num::NonZeroU32::new(1),
        ..default()
    };
    let plugins = DefaultPlugins
        .set(WindowPlugin {
            primary_window: Some(window),
            // There may be unsaved edits.
            close_when_requested: false,
            ..default()
        })
        .set(asset_plugin())
        .set(LogPlugin {
            // Only errors of libraries are logged. A software driver and a window manager without sizes are none. The
            // scene reports files that cannot be read, without the backtraces of the asset server.
            filter: "error,sunroom=info,bevy_asset::server=off".to_owned(),
            fmt_layer: |_| Some(log_layer()),
            ..default()
        })
        .set(RenderPlugin {
            render_creation: RenderCreation::Automatic(Box::new(WgpuSettings {
                // Only backends that can show a window wherever they exist are used, which OpenGL is not.
                backends: Some(Backends::from_env().unwrap_or(Backends::PRIMARY)),
                ..default()
            })),
            ..default()
        });
    app.add_plugins(FileSourcePlugin)
        .add_plugins(plugins)
        .add_plugins((ScenePlugin, EnginePlugin))
        .insert_resource(ClearColor(Color::srgb_u8(18, 18, 18)))
        .insert_resource(RenderControl {
            interactive: true,
            path_is_auto: true,
            threads: worker_count(options.threads, true),
            ..default()
        })
        .add_plugins(EditorPlugin(options))
        .add_systems(Startup, keep_driver);
    run_systems_in_turn(&mut app);
    app
}

/// Writes the log to standard error, with colours only on a terminal. A closed standard error is ignored: the default
/// would report it there, which fails again and ends the program.
fn log_layer() -> BoxedFmtLayer {
    let layer = tracing_subscriber::fmt::Layer::default().with_writer(std::io::stderr);
    let layer = match std::io::stderr().is_terminal() {
        true => layer,
        false => layer.with_ansi(false),
    };
    Box::new(layer.log_internal_errors(false))
}

/// Keeps the graphics driver loaded until the process ends, because drivers register functions for that moment. A
/// driver that is unloaded before, with the last of its objects, would be called at addresses that are no longer
/// mapped.
fn keep_driver(adapter: Option<Res<RenderAdapter>>) {
    std::mem::forget(adapter.map(|adapter| adapter.clone()));
}

/// Whether there is a display. Systems whose windows need no display server always have one.
fn has_display() -> bool {
    let is_set = |name: &str| std::env::var_os(name).is_some_and(|value| !value.is_empty());
    !cfg!(all(unix, not(target_os = "macos")))
        || is_set("DISPLAY")
        || is_set("WAYLAND_DISPLAY")
        || is_set("WAYLAND_SOCKET")
}

/// Explains the panics of Bevy, on threads of its own, when it finds no graphics driver or no display, and ends the
/// program.
fn explain_startup_panics() {
    let default_hook = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |panic| {
        let message = panic.payload_as_str().unwrap_or_default();
        let reason = STARTUP_PANICS.iter().find(|(part, _)| message.contains(part));
        let Some((_, reason)) = reason else {
            return default_hook(panic);
        };
        line(format_args!(
            "error: {reason}; `sunroom render SCENE -o OUT.png` works without a window\n  ({message})"
        ));
        std::process::exit(1);
    }));
}

/// A part of the panic's message, and its meaning for the user.
const STARTUP_PANICS: [(&str, &str); 3] = [
    (
        "Unable to find a GPU",
        "no graphics driver was found that can draw a window (Vulkan, Metal or DirectX 12; on Linux the package mesa-vulkan-drivers has one that needs no GPU)",
    ),
    (
        "Failed to create wgpu surface",
        "the graphics driver cannot draw on this display",
    ),
    ("Failed to build event loop", "the display cannot be reached"),
];
