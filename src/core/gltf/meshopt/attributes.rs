//! The codec of elements of any size: differences of bytes between consecutive elements, in blocks of up to 256
//! elements.

use super::stream::{Fault, HEADER, Reader, SHORT, difference};

/// The most elements of a block.
const BLOCK: usize = 256;
/// The elements of a group, whose differences have the same number of bits.
const GROUP: usize = 16;
/// The most bytes of a block.
const BLOCK_BYTES: usize = 8192;

/// The bits of a difference in a group by the two bits of the group's header: those of version 0, and of the two modes
/// of version 1 in which there is a header.
const BITS_BEFORE: [u32; 4] = [0, 2, 4, 8];
const BITS: [[u32; 4]; 2] = [[0, 1, 2, 4], [1, 2, 4, 8]];

/// The modes of bytes in version 1 that have no headers of groups.
const ALL_ZERO: u8 = 2;
const LITERAL: u8 = 3;

/// The bytes of the elements. `stride`: the size of an element, 4 to 256 and divisible by 4.
pub fn decode(stream: &[u8], count: usize, stride: usize) -> Result<Vec<u8>, Fault> {
    let mut reader = Reader(stream);
    let is_first_version = match reader.byte()? {
        0xa0 => true,
        0xa1 => false,
        _ => return Err(HEADER),
    };
    let channels = stride / 4;
    let (tail, least_tail) = match is_first_version {
        true => (stride, 32),
        false => (stride + channels, 24),
    };
    let body = reader.0.len().checked_sub(tail.max(least_tail)).ok_or(SHORT)?;
    let tail = &stream[stream.len() - tail..];
    let (baseline, modes) = tail.split_at(stride);
    let mut reader = Reader(reader.take(body)?);
    let block = ((BLOCK_BYTES / stride) & !(GROUP - 1)).min(BLOCK);
    // Every block has at least a byte for each channel. Thus a short stream cannot ask for much memory.
    if count.div_ceil(block).saturating_mul(channels) > body {
        return Err(SHORT);
    }

    let mut previous = [0; BLOCK];
    previous[..stride].copy_from_slice(baseline);
    let mut bytes = vec![0; count * stride];
    let mut differences = [[0; BLOCK]; 4];
    for elements in bytes.chunks_mut(block * stride) {
        let count = elements.len() / stride;
        let controls = match is_first_version {
            true => None,
            false => Some(reader.take(channels)?),
        };
        for channel in 0..channels {
            for (place, differences) in differences.iter_mut().enumerate() {
                match controls.map(|controls| controls[channel] >> (2 * place) & 3) {
                    None => groups(&mut reader, BITS_BEFORE, count, differences)?,
                    Some(ALL_ZERO) => differences.fill(0),
                    Some(LITERAL) => differences[..count].copy_from_slice(reader.take(count)?),
                    Some(mode) => groups(&mut reader, BITS[usize::from(mode & 1)], count, differences)?,
                }
            }
            let mode = modes.get(channel).copied().unwrap_or(0);
            let previous = &mut previous[4 * channel..4 * channel + 4];
            let mut last = u32::from_le_bytes([previous[0], previous[1], previous[2], previous[3]]);
            let step = step(mode)?;
            for (element, at) in elements.chunks_exact_mut(stride).zip(0..) {
                last = step(last, u32::from_le_bytes(differences.each_ref().map(|bytes| bytes[at])));
                element[4 * channel..4 * channel + 4].copy_from_slice(&last.to_le_bytes());
            }
            previous.copy_from_slice(&last.to_le_bytes());
        }
    }
    reader.finish()?;
    Ok(bytes)
}

/// The differences of one byte of `count` elements.
fn groups(reader: &mut Reader, bits: [u32; 4], count: usize, differences: &mut [u8; BLOCK]) -> Result<(), Fault> {
    let groups = count.div_ceil(GROUP);
    let headers = reader.take(groups.div_ceil(4))?;
    for (group, differences) in differences.chunks_exact_mut(GROUP).take(groups).enumerate() {
        match bits[usize::from(headers[group / 4] >> (2 * (group % 4)) & 3)] {
            0 => differences.fill(0),
            8 => differences.copy_from_slice(reader.take(GROUP)?),
            bits => small_differences(reader, bits, differences)?,
        }
    }
    Ok(())
}

/// A group of differences with 1, 2 or 4 bits. If all of these are set, the difference is a byte that comes after the
/// group.
fn small_differences(reader: &mut Reader, bits: u32, differences: &mut [u8]) -> Result<(), Fault> {
    let per_byte = 8 / bits;
    let large = (1u8 << bits) - 1;
    let packed = reader.take(GROUP / per_byte as usize)?;
    for (difference, at) in differences.iter_mut().zip(0u32..) {
        let place = at % per_byte;
        // Only single bits begin with the lowest one.
        let shift = match bits {
            1 => place,
            _ => 8 - bits * (place + 1),
        };
        *difference = packed[(at / per_byte) as usize] >> shift & large;
    }
    for difference in differences.iter_mut().filter(|difference| **difference == large) {
        *difference = reader.byte()?;
    }
    Ok(())
}

/// The function from the last four bytes and their difference to the next four bytes.
fn step(mode: u8) -> Result<impl Fn(u32, u32) -> u32, Fault> {
    let (kind, turn) = (mode & 15, u32::from(mode >> 4));
    if kind > 2 || kind < 2 && turn > 0 {
        return Err("a channel of its compressed stream has an unknown mode");
    }
    Ok(move |last: u32, given: u32| match kind {
        0 => lanes(last, given, 8),
        1 => lanes(last, given, 16),
        _ => last ^ given.rotate_right(turn),
    })
}

/// Adds the differences of lanes with this number of bits, each on its own.
fn lanes(last: u32, given: u32, bits: u32) -> u32 {
    let mask = u32::MAX >> (32 - bits);
    let lane = |shift: u32| {
        let sum = (last >> shift).wrapping_add(difference(given >> shift & mask));
        (sum & mask) << shift
    };
    (0..32).step_by(bits as usize).map(lane).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_example_of_the_specification_is_decoded() {
        let stream = [0x17, 0x5f, 0xf0, 0xbc, 0x77, 0xa9, 0x21, 0x00, 0x34, 0xb5];
        let mut differences = [0; GROUP];
        let mut reader = Reader(&stream);
        small_differences(&mut reader, 4, &mut differences).expect("is whole");
        reader.finish().expect("is read");
        let signed = differences.map(|byte| difference(byte.into()) as i8);
        assert_eq!(signed, [-1, -4, -3, 26, -91, 0, -6, 6, -4, -4, 5, -5, 1, -1, 0, 0]);
    }

    #[test]
    fn lanes_do_not_carry_into_each_other() {
        // 1 is -1, and 2 is 1.
        assert_eq!(lanes(0x00ff_0000, 0x0102_0000, 8), 0xff00_0000);
        assert_eq!(lanes(0xffff_0000, 0x0002_0001, 16), 0x0000_ffff);
    }
}
