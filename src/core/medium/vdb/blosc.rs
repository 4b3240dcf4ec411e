//! Unpacks chunks of Blosc, version 1, as OpenVDB writes them: blocks whose bytes are sorted by significance and packed
//! by LZ4.
//!
//! A chunk has a header of 16 bytes, the offsets of its blocks, and the blocks. A block is one stream, or one stream
//! for each byte of a value.

/// The length of the header, in bytes.
const HEADER: usize = 16;

/// The flag that bytes are sorted by significance.
const SHUFFLED: u8 = 0x1;
/// The flag that the content is not packed.
const STORED: u8 = 0x2;
/// The flag that bits are sorted by significance; together with the first flag it means a header of version 2.
const BITS_SHUFFLED: u8 = 0x4;
/// The flag that blocks are single streams.
const UNSPLIT: u8 = 0x10;
/// The packer, in the upper three bits of the flags.
const LZ4: u8 = 1;

/// Values of more bytes than this are never split into streams.
const WIDEST_SPLIT: usize = 16;
/// Blocks of fewer values than this are not split either.
const FEWEST_SPLIT: usize = 128;

/// Unpacks a chunk that fills `into` exactly; None if its size differs, or its format is not supported.
pub(super) fn unpack(chunk: &[u8], into: &mut [u8], scratch: &mut Vec<u8>) -> Option<()> {
    let (flags, width) = (*chunk.get(2)?, usize::from(*chunk.get(3)?).max(1));
    let [count, block] = [4, 8].map(|at| number(chunk, at));
    let (count, block) = (count?, block?);
    if count != into.len() {
        return None;
    }
    if flags & STORED != 0 {
        into.copy_from_slice(chunk.get(HEADER..)?.get(..count)?);
        return Some(());
    }
    if flags >> 5 != LZ4 || flags & BITS_SHUFFLED != 0 || block == 0 {
        return None;
    }
    for (index, block_out) in into.chunks_mut(block).enumerate() {
        let mut at = number(chunk, HEADER + 4 * index)?;
        let is_split =
            flags & UNSPLIT == 0 && width <= WIDEST_SPLIT && block / width >= FEWEST_SPLIT && block_out.len() == block;
        let streams = if is_split { width } else { 1 };
        let length = block_out.len() / streams;
        scratch.resize(length * streams, 0);
        if scratch.len() != block_out.len() {
            return None;
        }
        for stream in scratch.chunks_mut(length) {
            let packed = number(chunk, at)?;
            let content = chunk.get(at.checked_add(4)?..)?.get(..packed)?;
            at += 4 + packed;
            // A stream that packing would have enlarged is stored unpacked.
            match packed == stream.len() {
                true => stream.copy_from_slice(content),
                false => {
                    let found = lz4_flex::block::decompress_into(content, stream).ok()?;
                    (found == stream.len()).then_some(())?;
                }
            }
        }
        match flags & SHUFFLED != 0 && width > 1 {
            true => unshuffle(scratch, block_out, width),
            false => block_out.copy_from_slice(scratch),
        }
    }
    Some(())
}

/// Restores values of `width` bytes from a block that has the first bytes of all values, then all second bytes, and so
/// on.
fn unshuffle(sorted: &[u8], values: &mut [u8], width: usize) {
    let count = values.len() / width;
    for (byte, plane) in sorted[..count * width].chunks_exact(count.max(1)).enumerate() {
        for (value, from) in plane.iter().enumerate() {
            values[value * width + byte] = *from;
        }
    }
    // The rest is shorter than a value.
    values[count * width..].copy_from_slice(&sorted[count * width..]);
}

/// Reads a 32-bit integer that is not negative.
fn number(chunk: &[u8], at: usize) -> Option<usize> {
    let bytes = chunk.get(at..at.checked_add(4)?)?.try_into().ok()?;
    usize::try_from(i32::from_le_bytes(bytes)).ok()
}
