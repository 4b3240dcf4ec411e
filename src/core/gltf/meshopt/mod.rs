//! Decodes buffer views of EXT_meshopt_compression, and of KHR_meshopt_compression, whose streams may have a later
//! version.
//!
//! The streams and filters are those of the specification of KHR_meshopt_compression, appendices A and B. Decoders in
//! C++ exist; this one is in safe code, and takes time and memory in proportion to the numbers that it returns.

mod attributes;
mod filters;
mod indices;
mod stream;

use self::stream::Fault;
use super::schema::CompressedView;

/// The elements of a view, tightly packed: `count` of them with `byte_stride` bytes each. The memory that they take has
/// to be reserved before.
pub(super) fn decode(stream: &[u8], view: &CompressedView) -> Result<Vec<u8>, Fault> {
    let (count, stride) = (view.count, view.byte_stride);
    let filter = view.filter.as_deref().unwrap_or("NONE");
    match view.mode.as_str() {
        "ATTRIBUTES" => {
            if !stride.is_multiple_of(4) || !(4..=256).contains(&stride) {
                return Err("its compressed elements have an impossible size");
            }
            let mut bytes = attributes::decode(stream, count, stride)?;
            filters::apply(filter, stride, &mut bytes)?;
            Ok(bytes)
        }
        _ if filter != "NONE" => Err("its compressed indices have a filter"),
        "TRIANGLES" => packed(&indices::triangles(stream, count)?, stride),
        "INDICES" => packed(&indices::sequence(stream, count)?, stride),
        _ => Err("its mode of compression is unknown"),
    }
}

/// Indices with `stride` bytes each.
fn packed(indices: &[u32], stride: usize) -> Result<Vec<u8>, Fault> {
    match stride {
        2 => Ok(indices.iter().flat_map(|index| (*index as u16).to_le_bytes()).collect()),
        4 => Ok(indices.iter().flat_map(|index| index.to_le_bytes()).collect()),
        _ => Err("its compressed indices have an impossible size"),
    }
}

#[cfg(test)]
mod tests {
    use super::stream::SHORT;
    use super::*;

    fn bytes(hex: &str) -> Vec<u8> {
        let digit = |digit: u8| char::from(digit).to_digit(16).expect("a digit") as u8;
        let pairs = hex.as_bytes().as_chunks::<2>().0;
        pairs
            .iter()
            .map(|[high, low]| digit(*high) << 4 | digit(*low))
            .collect()
    }

    fn view(mode: &str, filter: Option<&str>, count: usize, byte_stride: usize) -> CompressedView {
        CompressedView {
            buffer: 0,
            byte_offset: 0,
            byte_length: 0,
            byte_stride,
            count,
            mode: mode.to_owned(),
            filter: filter.map(str::to_owned),
        }
    }

    fn decoded(hex: &str, mode: &str, filter: Option<&str>, count: usize, stride: usize) -> Vec<u8> {
        let view = view(mode, filter, count, stride);
        let stream = bytes(hex);
        // Every part of a stream is needed, and nothing may come after it.
        for length in 0..stream.len() {
            assert!(decode(&stream[..length], &view).is_err(), "{mode} {length}");
        }
        assert!(decode(&[&stream[..], &[0]].concat(), &view).is_err(), "{mode}");
        decode(&stream, &view).expect(mode)
    }

    fn floats(bytes: &[u8]) -> Vec<f32> {
        bytes
            .as_chunks::<4>()
            .0
            .iter()
            .map(|word| f32::from_le_bytes(*word))
            .collect()
    }

    // The streams are those of the reference encoder, meshoptimizer 1.0, for the values of the tests.

    #[test]
    fn attributes_of_both_versions_are_decoded() {
        let expected: Vec<u8> = (0..20u16)
            .flat_map(|i| {
                let [a, b] = (1000 + 7 * i).to_le_bytes();
                let [c, d] = (i * i).wrapping_mul(257).to_le_bytes();
                let [e, f, g, h] = ((0.5 + 0.01 * f64::from(i)) as f32).to_le_bytes();
                [a, b, c, d, e, f, g, h]
            })
            .collect();
        for stream in [
            // Version 0, and version 1 with differences of bytes and of words.
            "a00a0eeeeeeeeeeeeeeeeeee0000000000000100800000070002060a0e12161a1e22262a2e32363aff0000003e42464a07\
             0002060a0e12161a1e22262a2e32363aff0000004042464a0700b8b8b8bab8b8b8b8b8bab8b8b8b8b8ff000000bab8b8b8\
             0700e1e1dfe1e1dfe1e1dfe1e1dfe1dfe1ff000000e1dfe1e10a0464646466464646466400000000000000000000000000\
             000000000000000000000000000000000000e80300000000003f",
            "a1f19f020eeeeeeeeeeeeeee0f000e0e0e0e011000020002060a0e12161a1e22262a2e32363a3e42464a0002060a0e1216\
             1a1e22262a2e32363a4042464a00b8b8b8bab8b8b8b8b8bab8b8b8b8b8bab8b8b800e1e1dfe1e1dfe1e1dfe1e1dfe1dfe1\
             e1dfe1e10204646464664646460f00040606040000000000000000000000000000e80300000000003f0000",
            "a1f99f020eeeeeeeeeeeeeee0f000e0e0e0e0002060a0e12161a1e22262a2e32363a3e42464a0002060a0e12161a1e2226\
             2a2e32363a3e42464a00b8b8b8bab8b8b8b8b8bab8b8b8b8b8bab8b8b800e1e1dfe1e1dfe1e1dfe1e1dfe1dfe1e1dfe1e1\
             0204646464664646460f00040606040000000000000000000000000000e80300000000003f0100",
        ] {
            let values = decoded(&stream.replace(' ', ""), "ATTRIBUTES", None, 20, 8);
            assert_eq!(values, expected);
        }
    }

    #[test]
    fn bits_of_numbers_are_turned() {
        let stream = "a1690002000701000f020ff8f4c4f262e262c010381c0f00fe01030100000000000000000000000000000000000000\
                      0000000052";
        let values = decoded(&stream.replace(' ', ""), "ATTRIBUTES", None, 20, 4);
        let expected: Vec<f32> = (0..20u8).map(|i| f32::from(i) * 0.125).collect();
        assert_eq!(floats(&values), expected);
        let stream = "a1990515555555550000000204c4f4c4f4c4f4c41c3c1c0f007c040c0400000000000000000000000000000000000000000080bf12";
        let values = decoded(stream, "ATTRIBUTES", None, 20, 4);
        let sign = |i: u8| if i.is_multiple_of(2) { -1.0 } else { 1.0 };
        let expected: Vec<f32> = (0..20u8).map(|i| sign(i) * (1.0 + f32::from(i) / 64.0)).collect();
        assert_eq!(floats(&values), expected);
    }

    #[test]
    fn indices_are_decoded() {
        let grid = (0..3u16).flat_map(|y| (0..3).map(move |x| 4 * y + x));
        let mut expected: Vec<[u16; 3]> = grid.flat_map(|a| [[a, a + 1, a + 4], [a + 4, a + 1, a + 5]]).collect();
        expected.push([100, 3, 0]);
        let stream = "e1fe1e100e100e8e1e140e130e8e1e130e130eff0f08afaa01c701007687566778a9866589689801690000";
        let values = decoded(stream, "TRIANGLES", None, 57, 2);
        // The encoder may turn a triangle.
        let least_first = |corners: [u16; 3]| {
            let least = (0..3).min_by_key(|&corner| corners[corner]).expect("there are three");
            [corners[least], corners[(least + 1) % 3], corners[(least + 2) % 3]]
        };
        let values: Vec<u16> = values
            .as_chunks()
            .0
            .iter()
            .map(|index| u16::from_le_bytes(*index))
            .collect();
        let values: Vec<_> = values.as_chunks().0.iter().copied().map(least_first).collect();
        assert_eq!(values, expected.into_iter().map(least_first).collect::<Vec<_>>());
        let values = decoded("d1000404c19a0c04030400000000", "INDICES", None, 7, 4);
        let values: Vec<u32> = values
            .as_chunks()
            .0
            .iter()
            .map(|index| u32::from_le_bytes(*index))
            .collect();
        assert_eq!(values, [0, 1, 2, 50000, 3, 49999, 4]);
    }

    #[test]
    fn filters_give_the_values_of_the_reference() {
        let stream = "a0013f000000b1b241013f0000000a0903013f000000b1b484013f0000000a1914013f000000b1b2c8013f0000000a09\
                      060133000000050600000000000000000000000000000000000000000000000000000000000000ff07";
        let values = decoded(&stream.replace(' ', ""), "ATTRIBUTES", Some("QUATERNION"), 4, 8);
        let values: Vec<i16> = values
            .as_chunks()
            .0
            .iter()
            .map(|number| i16::from_le_bytes(*number))
            .collect();
        let turns = [
            [0, 0, 0, 32767],
            [16399, 16378, 16378, 16378],
            [23170, 0, -23170, 0],
            [-3271, 6554, 9825, 30389],
        ];
        assert_eq!(values, turns.concat());
        let stream = "a0013f0000006ceaaa013f00000091c35400013f000000fe04fe00000000000000000000000000000000000000000000\
                      00000000000000007f00";
        let values = decoded(&stream.replace(' ', ""), "ATTRIBUTES", Some("OCTAHEDRAL"), 4, 4);
        let normals: [i8; 16] = [0, 0, 127, 0, 76, -102, 0, 127, -73, 73, -74, -127, 0, 127, 0, 0];
        assert_eq!(values, normals.map(|number| number as u8));
        let stream = "a000000001300000001401300000003f01300000003c0001300000001400013000000050012000000001300000001400\
                      00000000000000000000000000000000000000000000f4001000f400d8fff4";
        let values = decoded(&stream.replace(' ', ""), "ATTRIBUTES", Some("EXPONENTIAL"), 2, 12);
        assert_eq!(floats(&values), [0.0, 1.0, -2.5, 0.0, 3000.0, 0.0]);
        let stream = "a1ff004c009c007e003100000000000000000000000000000000000000407fc1ff00";
        let values = decoded(stream, "ATTRIBUTES", Some("COLOR"), 2, 4);
        assert_eq!(values, [254, 1, 0, 255, 51, 102, 153, 204]);
    }

    #[test]
    fn a_short_stream_cannot_promise_much() {
        for (mode, start, stride) in [("ATTRIBUTES", 0xa1, 256), ("TRIANGLES", 0xe1, 4), ("INDICES", 0xd1, 4)] {
            let mut stream = vec![0; 1000];
            stream[0] = start;
            assert_eq!(
                decode(&stream, &view(mode, None, 3 << 50, stride)),
                Err(SHORT),
                "{mode}"
            );
        }
        for (mode, stride) in [("ATTRIBUTES", 6), ("ATTRIBUTES", 260), ("INDICES", 3), ("OTHER", 4)] {
            assert!(
                decode(&[0xa0; 400], &view(mode, None, 3, stride)).is_err(),
                "{mode} {stride}"
            );
        }
    }
}
