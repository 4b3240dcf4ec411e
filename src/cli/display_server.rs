//! Sends the picture to a viewer while it is rendered. A missing or lost viewer is reported once and never delays the
//! render.
//!
//! Messages to the viewer tev create a picture, and fill rectangles of it (T. Müller, tev, "Over the Network" and
//! `Ipc.h`; pbrt and Mitsuba use the same protocol).
//!
//! A message is its length in bytes including these four, an operation, and the operation's arguments. Integers are
//! little-endian, texts end in a zero.

use std::io::{self, Write};
use std::net::{TcpStream, ToSocketAddrs};
use std::path::Path;
use std::time::{Duration, Instant};

use bevy::prelude::*;
use crossbeam_channel::{Receiver, RecvTimeoutError, Sender, TrySendError, bounded};
use sunroom::engine::{EngineSystems, RenderFilm};
use sunroom::render::film::Film;
use sunroom::render::tile::Tile;

use super::report;

/// The time between two searches for changed tiles.
const INTERVAL: Duration = Duration::from_millis(250);
/// The time in which a viewer must answer, or accept a part of a message.
const PATIENCE: Duration = Duration::from_secs(2);
/// The total time in which a viewer must accept the finished picture, and the messages before it.
const LAST_PATIENCE: Duration = Duration::from_secs(10);

/// Connects the app to the viewer at `HOST:PORT`. If there is none, it prints a warning.
pub fn show(app: &mut App, address: &str, scene: &Path) {
    let stream = match connect(address) {
        Ok(stream) => stream,
        Err(error) => {
            report::line(format_args!(
                "warning: the display server {address} cannot be reached: {error}; the picture is rendered without it"
            ));
            return;
        }
    };
    let (sender, receiver) = bounded(1);
    let (running, ended) = bounded(0);
    let of_thread = address.to_owned();
    std::thread::spawn(move || {
        send_all(stream, receiver, &of_thread);
        drop(running);
    });
    app.insert_resource(DisplayServer {
        address: address.to_owned(),
        name: format!("sunroom {}", scene.display()),
        sender: Some(sender),
        ended,
        shown_job: None,
        next: Instant::now(),
    });
    app.add_systems(PostUpdate, send_changes.after(EngineSystems::Collect));
}

/// Sends the finished picture, row by row as in the film, and waits for a limited time until the viewer has it.
pub fn finish(world: &mut World, pixels: &[Vec3]) {
    let Some(mut server) = world.remove_resource::<DisplayServer>() else {
        return;
    };
    let film = &world.resource::<RenderFilm>().film;
    let size = [film.width(), film.height()];
    let numbers: Vec<f32> = pixels.iter().flat_map(|pixel| pixel.to_array()).collect();
    let mut messages = Vec::new();
    if server.shown_job.is_none() {
        messages.push(create_image(&server.name, size[0], size[1]));
    }
    messages.push(update_image(&server.name, [0, 0], size, &numbers));
    let deadline = Instant::now() + LAST_PATIENCE;
    if let Some(sender) = server.sender.take() {
        // An error means that the viewer is lost, which was reported, or hangs.
        let _ = sender.send_deadline(messages, deadline);
    }
    if !has_ended(&server.ended, deadline) {
        let address = &server.address;
        report::line(format_args!(
            "warning: the display server {address} takes too long: it may not have the finished picture"
        ));
    }
}

/// Waits for the sending thread; false if it does not end in time.
fn has_ended(ended: &Receiver<()>, deadline: Instant) -> bool {
    ended.recv_deadline(deadline) != Err(RecvTimeoutError::Timeout)
}

fn connect(address: &str) -> io::Result<TcpStream> {
    let mut last = io::Error::new(io::ErrorKind::NotFound, "the name has no address");
    for place in address.to_socket_addrs()? {
        match TcpStream::connect_timeout(&place, PATIENCE) {
            Ok(stream) => {
                stream.set_write_timeout(Some(PATIENCE))?;
                stream.set_nodelay(true)?;
                return Ok(stream);
            }
            Err(error) => last = error,
        }
    }
    Err(last)
}

/// Sends messages until the channel is closed, or sending fails.
fn send_all(mut stream: TcpStream, receiver: Receiver<Vec<Vec<u8>>>, address: &str) {
    for messages in receiver {
        for message in messages {
            if let Err(error) = stream.write_all(&message) {
                let why = match error.kind() {
                    // Systems report the time limit of a socket by one of these errors.
                    io::ErrorKind::WouldBlock | io::ErrorKind::TimedOut => {
                        format!("it took nothing for {} seconds", PATIENCE.as_secs())
                    }
                    _ => error.to_string(),
                };
                report::line(format_args!(
                    "warning: the display server {address} gets nothing more: {why}"
                ));
                return;
            }
        }
    }
}

#[derive(Resource)]
struct DisplayServer {
    address: String,
    /// The name of the picture in the viewer.
    name: String,
    /// None once the viewer is lost.
    sender: Option<Sender<Vec<Vec<u8>>>>,
    /// Closed at the end of the sending thread.
    ended: Receiver<()>,
    /// The job of the picture that the viewer shows.
    shown_job: Option<u64>,
    next: Instant,
}

fn send_changes(mut server: ResMut<DisplayServer>, mut film: ResMut<RenderFilm>) {
    let now = Instant::now();
    if now < server.next || film.film.width() == 0 {
        return;
    }
    let Some(sender) = server.sender.clone() else {
        return;
    };
    // Other systems must not see the film as changed.
    let film = film.bypass_change_detection();
    let mut tiles = film.take_dirty();
    if tiles.is_empty() {
        return;
    }
    tiles.sort_by_key(|tile| (tile.y, tile.x));
    let mut messages = Vec::new();
    if server.shown_job != Some(film.job) {
        messages.push(create_image(&server.name, film.film.width(), film.film.height()));
    }
    messages.extend(tiles.iter().map(|tile| tile_message(&server.name, &film.film, *tile)));
    match sender.try_send(messages) {
        Ok(()) => server.shown_job = Some(film.job),
        // A message that is dropped now is replaced by the next one about its tile.
        Err(TrySendError::Full(_)) => tiles.into_iter().for_each(|tile| film.mark(tile)),
        Err(TrySendError::Disconnected(_)) => server.sender = None,
    }
    server.next = now + INTERVAL;
}

fn tile_message(name: &str, film: &Film, tile: Tile) -> Vec<u8> {
    let rows = tile.y..tile.y + tile.height;
    let pixels = rows.flat_map(|y| (tile.x..tile.x + tile.width).map(move |x| (x, y)));
    let color = |(x, y)| film.pixel(x, y).unwrap_or_default().radiance.to_array();
    let numbers: Vec<f32> = pixels.flat_map(color).collect();
    update_image(name, [tile.x, tile.y], [tile.width, tile.height], &numbers)
}

const CREATE_IMAGE: u8 = 4;
/// The third form of the operation, with several channels, offsets and strides.
const UPDATE_IMAGE: u8 = 6;

const CHANNELS: [&str; 3] = ["R", "G", "B"];

/// Creates a black picture of this size in pixels, in place of one with the same name, and selects it.
pub fn create_image(name: &str, width: u32, height: u32) -> Vec<u8> {
    let mut message = Message::new(CREATE_IMAGE, true, name);
    message.integers(&[width, height]);
    message.channels();
    message.finish()
}

/// Fills a rectangle of a picture with rows of R, G, B. `x` and `y` are its top left.
pub fn update_image(name: &str, [x, y]: [u32; 2], [width, height]: [u32; 2], rgb: &[f32]) -> Vec<u8> {
    let mut message = Message::new(UPDATE_IMAGE, false, name);
    message.channels();
    message.integers(&[x, y, width, height]);
    let stride = CHANNELS.len() as i64;
    for offset in 0..stride {
        message.bytes.extend(offset.to_le_bytes());
    }
    for _ in CHANNELS {
        message.bytes.extend(stride.to_le_bytes());
    }
    message.bytes.extend(rgb.iter().flat_map(|number| number.to_le_bytes()));
    message.finish()
}

struct Message {
    bytes: Vec<u8>,
}

impl Message {
    fn new(operation: u8, takes_focus: bool, name: &str) -> Self {
        let mut message = Self {
            bytes: vec![0, 0, 0, 0, operation, u8::from(takes_focus)],
        };
        message.text(name);
        message
    }

    fn text(&mut self, text: &str) {
        self.bytes.extend(text.bytes().filter(|&byte| byte != 0));
        self.bytes.push(0);
    }

    fn integers(&mut self, numbers: &[u32]) {
        self.bytes
            .extend(numbers.iter().flat_map(|number| number.to_le_bytes()));
    }

    fn channels(&mut self) {
        self.integers(&[CHANNELS.len() as u32]);
        CHANNELS.into_iter().for_each(|channel| self.text(channel));
    }

    fn finish(mut self) -> Vec<u8> {
        let length = self.bytes.len() as u32;
        self.bytes[..4].copy_from_slice(&length.to_le_bytes());
        self.bytes
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_viewer_that_hangs_is_not_waited_for() {
        let (running, ended) = bounded::<()>(0);
        assert!(!has_ended(&ended, Instant::now()));
        drop(running);
        // The end counts, however late it is.
        assert!(has_ended(&ended, Instant::now()));
    }

    /// The bytes follow from the description by hand.
    #[test]
    fn messages_have_the_bytes_of_the_protocol() {
        let mut expected = vec![27, 0, 0, 0, 4, 1, b'a', 0, 2, 0, 0, 0, 1, 0, 0, 0, 3, 0, 0, 0];
        expected.extend(*b"R\0G\0B\0");
        expected[0] = expected.len() as u8;
        assert_eq!(create_image("a", 2, 1), expected);
        let message = update_image("a", [1, 2], [1, 1], &[0.5, 1.0, -2.0]);
        assert_eq!(message[..4], (message.len() as u32).to_le_bytes());
        assert_eq!(message[4..8], [6, 0, b'a', 0]);
        assert_eq!(message[8..18], *b"\x03\0\0\0R\0G\0B\0");
        assert_eq!(message[18..34], [1, 0, 0, 0, 2, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0]);
        let longs: Vec<i64> = message[34..82]
            .chunks(8)
            .map(|bytes| i64::from_le_bytes(bytes.try_into().unwrap()))
            .collect();
        assert_eq!(longs, [0, 1, 2, 3, 3, 3]);
        assert_eq!(message[82..], [0.5f32, 1.0, -2.0].map(f32::to_le_bytes).concat());
    }
}
