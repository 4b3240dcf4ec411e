//! The filters by which elements are packed for the codec of attributes.

use super::stream::Fault;

/// Unpacks elements of `stride` bytes in place.
pub fn apply(filter: &str, stride: usize, bytes: &mut [u8]) -> Result<(), Fault> {
    match (filter, stride) {
        ("NONE", _) => {}
        ("OCTAHEDRAL", 4) => each(bytes, |element: [u8; 4]| {
            octahedral(element.map(|byte| i16::from(byte as i8)), 127.0).map(|number| number as u8)
        }),
        ("OCTAHEDRAL", 8) => each_of_four(bytes, |numbers| octahedral(numbers, 32767.0)),
        ("QUATERNION", 8) => each_of_four(bytes, quaternion),
        ("EXPONENTIAL", _) => each(bytes, |word| exponential(i32::from_le_bytes(word)).to_le_bytes()),
        ("COLOR", 4) => each(bytes, |[y, co, cg, alpha]: [u8; 4]| {
            let chroma = |byte: u8| i32::from(byte as i8);
            color([y.into(), chroma(co), chroma(cg), alpha.into()], 255.0).map(|number| number as u8)
        }),
        ("COLOR", 8) => each_of_four(bytes, |[y, co, cg, alpha]| {
            let share = |number: i16| i32::from(number as u16);
            color([share(y), co.into(), cg.into(), share(alpha)], 65535.0).map(|number| number as i16)
        }),
        _ => return Err("its filter is unknown, or its elements do not fit it"),
    }
    Ok(())
}

fn each<const N: usize>(bytes: &mut [u8], unpack: impl Fn([u8; N]) -> [u8; N]) {
    for element in bytes.as_chunks_mut::<N>().0 {
        *element = unpack(*element);
    }
}

/// Elements of four numbers with 16 bits.
fn each_of_four(bytes: &mut [u8], unpack: impl Fn([i16; 4]) -> [i16; 4]) {
    each(bytes, |[a, b, c, d, e, f, g, h]: [u8; 8]| {
        let numbers = [[a, b], [c, d], [e, f], [g, h]].map(i16::from_le_bytes);
        let [[a, b], [c, d], [e, f], [g, h]] = unpack(numbers).map(i16::to_le_bytes);
        [a, b, c, d, e, f, g, h]
    });
}

/// A unit vector from its octahedral projection. The third number is 1 in the number of bits of the others; the fourth
/// is kept.
fn octahedral([x, y, one, last]: [i16; 4], largest: f32) -> [i16; 4] {
    let [x, y] = [x, y].map(|number| f32::from(number) / f32::from(one));
    let z = 1.0 - x.abs() - y.abs();
    let fold = z.min(0.0);
    let vector = [x - fold.copysign(x), y - fold.copysign(y), z];
    let length = vector.iter().map(|number| number * number).sum::<f32>().sqrt();
    let [x, y, z] = vector.map(|number| (number / length * largest).round() as i16);
    [x, y, z, last]
}

/// A unit quaternion from all but its largest component. The fourth number is 1 in the number of bits of the others,
/// but for two bits that say which component is the largest.
fn quaternion([x, y, z, one]: [i16; 4]) -> [i16; 4] {
    let scale = std::f32::consts::FRAC_1_SQRT_2 / f32::from(one | 3);
    let [x, y, z] = [x, y, z].map(|number| f32::from(number) * scale);
    let w = (1.0 - x * x - y * y - z * z).max(0.0).sqrt();
    let mut turn = [w, x, y, z].map(|number| (number * 32767.0).round() as i16);
    turn.rotate_right((one & 3) as usize);
    turn
}

/// A number from its exponent, in the upper eight bits, and its mantissa.
fn exponential(word: i32) -> f32 {
    let (exponent, mantissa) = (word >> 24, word << 8 >> 8);
    mantissa as f32 * 2.0f32.powi(exponent)
}

/// Red, green, blue and alpha from luma, chroma (orange, green) and alpha, whose highest bit says how many bits there
/// are.
fn color([y, co, cg, alpha]: [i32; 4], largest: f32) -> [u16; 4] {
    let bits = 32 - alpha.max(1).leading_zeros();
    let most = (1 << bits) - 1;
    let alpha = alpha & most >> 1;
    let alpha = alpha << 1 | alpha & 1;
    [y + co - cg, y + cg, y - co - cg, alpha].map(|number| (number as f32 * largest / most as f32).round() as u16)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn vectors_and_turns_are_unpacked() {
        assert_eq!(octahedral([0, 0, 127, 5], 127.0), [0, 0, 127, 5]);
        assert_eq!(octahedral([127, 0, 127, 5], 127.0), [127, 0, 0, 5]);
        // The corner of the projection is the lower pole.
        assert_eq!(octahedral([511, -511, 511, 0], 32767.0), [0, 0, -32767, 0]);
        assert_eq!(quaternion([0, 0, 0, 32767]), [0, 0, 0, 32767]);
        // The first component is the largest; a quarter turn about it has as much in the last one.
        assert_eq!(quaternion([0, 0, 2047, 2044]), [23170, 0, 0, 23170]);
    }

    #[test]
    fn numbers_and_colours_are_unpacked() {
        assert_eq!(exponential(-3 << 24 | 5), 0.625);
        assert_eq!(exponential(2 << 24 | 0xff_ffff), -4.0);
        // Eight bits: seven of alpha below the highest one.
        assert_eq!(color([255, 0, 0, 255], 255.0), [255; 4]);
        assert_eq!(color([64, 64, 0, 128], 255.0), [128, 64, 0, 0]);
        let mut bytes = [255, 0, 0, 255];
        assert!(apply("QUATERNION", 4, &mut bytes).is_err());
        apply("COLOR", 4, &mut bytes).expect("fits");
        assert_eq!(bytes, [255; 4]);
    }
}
