//! glTF files written by hand.
#![allow(dead_code, reason = "every test binary uses its own part")]

use sunroom::gltf::{Gltf, GltfError};

fn base64(bytes: &[u8]) -> String {
    const SYMBOLS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let group = |three: &[u8]| -> String {
        let byte = |i: usize| u32::from(three.get(i).copied().unwrap_or(0));
        let bits = byte(0) << 16 | byte(1) << 8 | byte(2);
        let symbol = |i: usize| match i <= three.len() {
            true => char::from(SYMBOLS[(bits >> (18 - 6 * i) & 63) as usize]),
            false => '=',
        };
        (0..4).map(symbol).collect()
    };
    bytes.chunks(3).map(group).collect()
}

/// The parts of a file with one buffer: bytes are added with a view for each piece.
#[derive(Default)]
pub struct Parts {
    pub bytes: Vec<u8>,
    views: Vec<String>,
    pub accessors: Vec<String>,
}

impl Parts {
    pub fn view(&mut self, bytes: &[u8], more: &str) -> usize {
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        let (offset, length) = (self.bytes.len(), bytes.len());
        self.bytes.extend_from_slice(bytes);
        self.views.push(format!(
            r#"{{"buffer": 0, "byteOffset": {offset}, "byteLength": {length}{more}}}"#
        ));
        self.views.len() - 1
    }

    pub fn accessor(&mut self, view: usize, component: u32, kind: &str, count: usize, more: &str) -> usize {
        self.accessors.push(format!(
            r#"{{"bufferView": {view}, "componentType": {component}, "type": "{kind}", "count": {count}{more}}}"#
        ));
        self.accessors.len() - 1
    }

    pub fn floats(&mut self, kind: &str, numbers: &[f32]) -> usize {
        let width = match kind {
            "VEC4" => 4,
            "VEC3" => 3,
            "VEC2" => 2,
            _ => 1,
        };
        let bytes: Vec<u8> = numbers.iter().flat_map(|number| number.to_le_bytes()).collect();
        let view = self.view(&bytes, "");
        self.accessor(view, 5126, kind, numbers.len() / width, "")
    }

    pub fn json(&self, buffer: &str, rest: &str) -> String {
        let (views, accessors, length) = (self.views.join(","), self.accessors.join(","), self.bytes.len());
        format!(
            r#"{{"asset": {{"version": "2.0"}}, "bufferViews": [{views}], "accessors": [{accessors}],
                "buffers": [{{"byteLength": {length}{buffer}}}], {rest}}}"#
        )
    }

    pub fn text(&self, rest: &str) -> String {
        let uri = format!(
            r#", "uri": "data:application/octet-stream;base64,{}""#,
            base64(&self.bytes)
        );
        self.json(&uri, rest)
    }

    pub fn binary(&self, rest: &str) -> Vec<u8> {
        let mut json = self.json("", rest).into_bytes();
        json.resize(json.len().next_multiple_of(4), b' ');
        let mut data = self.bytes.clone();
        data.resize(data.len().next_multiple_of(4), 0);
        let word = |number: usize| (number as u32).to_le_bytes();
        let total = 12 + 8 + json.len() + 8 + data.len();
        [
            b"glTF".as_slice(),
            &word(2),
            &word(total),
            &word(json.len()),
            b"JSON",
            &json,
            &word(data.len()),
            b"BIN\0",
            &data,
        ]
        .concat()
    }
}

/// A file that names no others.
pub fn open(text: &str) -> Result<Gltf, GltfError> {
    Gltf::open(text.as_bytes(), &mut nothing_beside)
}

pub fn nothing_beside(name: &str) -> std::io::Result<Vec<u8>> {
    Err(std::io::Error::new(std::io::ErrorKind::NotFound, format!("no {name}")))
}

/// Corners.
pub const SQUARE: [f32; 12] = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 1.0, 0.0];
