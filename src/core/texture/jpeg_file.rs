//! Checks whether a JPEG file is complete. The decoder accepts the first part of a file, too, and leaves the rest of
//! the picture grey.

const START_OF_IMAGE: u8 = 0xd8;
const END_OF_IMAGE: u8 = 0xd9;
const RESTARTS: std::ops::RangeInclusive<u8> = 0xd0..=0xd7;
/// The marker "for temporary private use", which has no length.
const TEMPORARY: u8 = 0x01;

/// Whether the markers of a file lead to the one that ends the picture (ITU-T T.81, section B.1.1). Bytes after it are
/// ignored.
pub(super) fn is_whole(bytes: &[u8]) -> bool {
    let mut rest = bytes;
    // Between segments lies entropy-coded data, in which 0xff is followed by 0 unless it begins a marker.
    while let Some(at) = rest.windows(2).position(|two| two[0] == 0xff && has_meaning(two[1])) {
        let after = &rest[at + 2..];
        rest = match rest[at + 1] {
            END_OF_IMAGE => return true,
            START_OF_IMAGE => after,
            _ => {
                let Some(length) = after.first_chunk() else {
                    return false;
                };
                // The length counts its own two bytes.
                after.get(u16::from_be_bytes(*length).into()..).unwrap_or_default()
            }
        };
    }
    false
}

/// Whether the byte after a 0xff is a marker that ends entropy-coded data. Another 0xff is a fill byte.
fn has_meaning(code: u8) -> bool {
    !matches!(code, 0 | TEMPORARY | 0xff) && !RESTARTS.contains(&code)
}
