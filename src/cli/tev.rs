//! Messages to the viewer tev: how a picture is made, and how rectangles of it are filled (T. Müller, tev, "Over the
//! Network" and `Ipc.h`; pbrt and Mitsuba's users know it).
//!
//! A message is its length in bytes with these four, an operation, and the operation's arguments. Integers are
//! little-endian, texts end in a zero.

const CREATE_IMAGE: u8 = 4;
/// The third form of the operation, with several channels, offsets and strides.
const UPDATE_IMAGE: u8 = 6;

const CHANNELS: [&str; 3] = ["R", "G", "B"];

/// Makes a black picture of this size in pixels, in place of one of the same name, and selects it.
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
