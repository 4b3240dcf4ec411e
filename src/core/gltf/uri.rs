//! The content of the URIs of a glTF file: data in the URI itself, or a file relative to the glTF file.

use std::collections::BTreeSet;
use std::io::ErrorKind;

use super::error::{GltfError, MissingParts, ReadFile};
use super::schema::Root;

/// The content of a URI (RFC 2397 for `data:`). `read` gets a relative path with its escapes resolved.
pub fn content(uri: &str, read: &mut ReadFile) -> Result<Vec<u8>, GltfError> {
    if let Some(data) = uri.strip_prefix("data:") {
        let (kind, data) = data.split_once(',').ok_or_else(|| bad(uri, "has no comma"))?;
        return if kind.ends_with(";base64") {
            base64(data).ok_or_else(|| bad(uri, "is not base64"))
        } else {
            Ok(unescaped(data))
        };
    }
    if uri.contains("://") {
        return Err(bad(uri, "is no file; nothing is fetched from elsewhere"));
    }
    let name = String::from_utf8(unescaped(uri)).map_err(|_| bad(uri, "is not text"))?;
    read(&name).map_err(|source| GltfError::File { name, source })
}

impl GltfError {
    /// Whether the error is a missing file.
    pub(super) fn is_missing(&self) -> bool {
        matches!(self, Self::File { source, .. } if source.kind() == ErrorKind::NotFound)
    }
}

impl Root {
    /// The missing files of buffers and images.
    pub(super) fn missing_parts(&self, read: &mut ReadFile) -> MissingParts {
        let mut missing = |uris: BTreeSet<&str>| {
            let names = uris.into_iter().filter_map(|uri| match content(uri, read) {
                Err(GltfError::File { name, source }) if source.kind() == ErrorKind::NotFound => Some(name),
                _ => None,
            });
            names.collect::<Vec<String>>()
        };
        MissingParts {
            buffers: missing(files(self.buffers.iter().map(|buffer| &buffer.uri))),
            images: missing(files(self.images.iter().map(|image| &image.uri))),
        }
    }
}

/// The URIs that name files.
fn files<'a>(uris: impl Iterator<Item = &'a Option<String>>) -> BTreeSet<&'a str> {
    let uris = uris.filter_map(|uri| uri.as_deref());
    uris.filter(|uri| !uri.starts_with("data:")).collect()
}

fn bad(uri: &str, what: &'static str) -> GltfError {
    let short: String = uri.chars().take(40).collect();
    GltfError::Uri { uri: short, what }
}

/// Resolves percent escapes such as `%20` to bytes; an invalid escape is kept.
fn unescaped(text: &str) -> Vec<u8> {
    let mut rest = text.as_bytes();
    let mut result = Vec::with_capacity(rest.len());
    while let [first, tail @ ..] = rest {
        let digit = |at: usize| tail.get(at).and_then(|&byte| char::from(byte).to_digit(16));
        rest = match (first, digit(0), digit(1)) {
            (b'%', Some(high), Some(low)) => {
                result.push((16 * high + low) as u8);
                &tail[2..]
            }
            _ => {
                result.push(*first);
                tail
            }
        };
    }
    result
}

/// Decodes RFC 4648, with or without padding; None for any other character.
fn base64(text: &str) -> Option<Vec<u8>> {
    let text = text.trim_end_matches('=').as_bytes();
    let mut result = Vec::with_capacity(text.len() / 4 * 3 + 2);
    for group in text.chunks(4) {
        let mut bits = 0u32;
        for &symbol in group {
            let value = match symbol {
                b'A'..=b'Z' => symbol - b'A',
                b'a'..=b'z' => symbol - b'a' + 26,
                b'0'..=b'9' => symbol - b'0' + 52,
                b'+' | b'-' => 62,
                b'/' | b'_' => 63,
                _ => return None,
            };
            bits = bits << 6 | u32::from(value);
        }
        bits <<= 6 * (4 - group.len());
        let bytes = bits.to_be_bytes();
        match group.len() {
            1 => return None,
            symbols => result.extend_from_slice(&bytes[1..symbols]),
        }
    }
    Some(result)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn base64_is_that_of_the_standard() {
        let cases = [
            ("", ""),
            ("Zg==", "f"),
            ("Zm8=", "fo"),
            ("Zm9v", "foo"),
            ("Zm9vYg", "foob"),
            ("Zm9vYmFy", "foobar"),
        ];
        for (text, bytes) in cases {
            assert_eq!(base64(text).as_deref(), Some(bytes.as_bytes()), "{text}");
        }
        assert_eq!((base64("Z"), base64("Zm 9v")), (None, None));
    }

    #[test]
    fn names_are_unescaped() {
        assert_eq!(unescaped("a%20b%c3%a9%4"), "a bé%4".as_bytes());
    }
}
