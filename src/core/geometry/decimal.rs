//! Reads the numbers of text files. Plain and short ones are read faster than by the standard library, with the same
//! bits.
//!
//! A decimal of up to 15 digits and its power of ten are exact in an `f64`, so that one product or quotient of them is
//! rounded once (Clinger, "How to read floating point numbers accurately", 1990). Rounding that once more to `f32` goes
//! wrong only where the `f64` lies half-way between two `f32`.

/// Powers of ten that are exact in `f64`.
const POWERS_OF_TEN: [f64; 23] = [
    1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18, 1e19, 1e20,
    1e21, 1e22,
];

/// The number at the beginning of `text`, as `str::parse` reads it, and its length. `None` if it is no number, or one
/// that this fast path cannot round correctly.
#[inline]
pub(super) fn leading_f32(text: &[u8]) -> Option<(f32, usize)> {
    let sign = usize::from(text.first() == Some(&b'-'));
    let (mut mantissa, mut end) = digits(text, sign, 0);
    let mut count = end - sign;
    let mut exponent = 0;
    if text.get(end) == Some(&b'.') {
        let begin = end + 1;
        (mantissa, end) = digits(text, begin, mantissa);
        count += end - begin;
        exponent = -((end - begin) as i32);
    }
    if count == 0 || count > 15 {
        return None;
    }
    if let Some(b'e' | b'E') = text.get(end) {
        let is_negative = text.get(end + 1) == Some(&b'-');
        let begin = end + 1 + usize::from(is_negative || text.get(end + 1) == Some(&b'+'));
        let (power, after) = digits(text, begin, 0);
        if !(1..4).contains(&(after - begin)) {
            return None;
        }
        exponent += if is_negative { -(power as i32) } else { power as i32 };
        end = after;
    }
    let power = POWERS_OF_TEN.get(exponent.unsigned_abs() as usize)?;
    let mantissa = mantissa as f64;
    let value = if exponent < 0 {
        mantissa / power
    } else {
        mantissa * power
    };
    let is_halfway = value.to_bits() << 35 == 1 << 63;
    if is_halfway || (value < f64::from(f32::MIN_POSITIVE) && value != 0.0) {
        return None;
    }
    let value = value as f32;
    Some((if sign == 1 { -value } else { value }, end))
}

/// The longest number at the beginning of `text`, with any text after it: 3.1 of `3.1+e2`, 0.5 of `0.5f`. None if there
/// is no digit, and before a comma: `1,5` has a decimal comma, so that 1 would be a wrong reading.
pub(super) fn longest_number(text: &[u8]) -> Option<f32> {
    let is_sign = |place: usize| matches!(text.get(place), Some(b'+' | b'-'));
    let digits_from = |place: usize| {
        let rest = text.get(place..).unwrap_or_default();
        place + rest.iter().take_while(|byte| byte.is_ascii_digit()).count()
    };
    let sign = usize::from(is_sign(0));
    let mut end = digits_from(sign);
    let mut digits = end - sign;
    if text.get(end) == Some(&b'.') {
        let begin = end + 1;
        end = digits_from(begin);
        digits += end - begin;
    }
    if digits == 0 {
        return None;
    }
    if let Some(b'e' | b'E') = text.get(end) {
        let begin = end + 1 + usize::from(is_sign(end + 1));
        let after = digits_from(begin);
        if after > begin {
            end = after;
        }
    }
    if text.get(end) == Some(&b',') {
        return None;
    }
    std::str::from_utf8(text.get(..end)?).ok()?.parse().ok()
}

/// The unsigned integer at the beginning of `text`, and its length: at most nine digits.
#[inline]
pub(super) fn leading_u32(text: &[u8]) -> Option<(u32, usize)> {
    let (number, end) = digits(text, 0, 0);
    (1..10).contains(&end).then_some((number as u32, end))
}

/// Appends the digits from `begin` on to `number`, and returns the position of their end. Wraps around after many.
#[inline(always)]
fn digits(text: &[u8], begin: usize, mut number: u64) -> (u64, usize) {
    let mut end = begin;
    while let Some(digit) = text.get(end).map(|byte| byte.wrapping_sub(b'0'))
        && digit < 10
    {
        number = number.wrapping_mul(10).wrapping_add(digit.into());
        end += 1;
    }
    (number, end)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::hash::pcg4d;

    /// Whether the text is read; if so, the result must be right.
    fn is_read(text: &str) -> bool {
        for following in ["", " ", "/", "x"] {
            let Some((value, length)) = leading_f32(format!("{text}{following}").as_bytes()) else {
                return false;
            };
            assert_eq!(length, text.len(), "{text}");
            let expected: f32 = text.parse().expect(text);
            assert_eq!(value.to_bits(), expected.to_bits(), "{text}: {value}, not {expected}");
        }
        true
    }

    #[test]
    fn what_is_read_is_what_the_standard_library_reads() {
        for text in [
            "0",
            "-0",
            "1",
            "-1.",
            ".5",
            "-.25",
            "0.0",
            "1e5",
            "1E-5",
            "-12.345678",
            "3e+22",
            "100000000000000",
            "1e22",
            "0.1e-21",
            "16777217.5",
        ] {
            assert!(is_read(text), "{text}");
        }
        let mut read = 0;
        for i in 0..200_000 {
            let [bits, digits, exponent, style] = pcg4d([i, 1, 2, 3]);
            // These are all sizes of f32 in few and in many digits, the most common texts, and decimals of all kinds.
            let text = match style % 4 {
                0 => format!("{:.*}", digits as usize % 9, f32::from_bits(bits % 0x4b00_0000)),
                1 => format!("{:e}", f32::from_bits(bits)),
                2 => format!("{}e{}", i64::from(bits as i32), exponent as i32 % 40),
                _ => format!("{}.{:06}", bits as i32 % 10_000, digits % 1_000_000),
            };
            read += u32::from(is_read(&text));
        }
        assert!(read > 120_000, "{read}");
    }

    #[test]
    fn ties_are_left_to_the_standard_library() {
        // 2^24 + 1 is half-way between two f32; the others round to such an f64.
        for text in [
            "16777217",
            "16777217.0000000",
            "1.677721700000000e7",
            "33554434e0",
            "8388608.5",
        ] {
            let value: f64 = text.parse().expect(text);
            let is_tie = value as f32 as f64 != value && leading_f32(text.as_bytes()).is_none();
            assert!(is_tie || is_read(text), "{text}");
        }
        assert_eq!(leading_f32(b"16777217"), None);
        for i in 0..10_000u32 {
            let [bits, ..] = pcg4d([i, 4, 5, 6]);
            // Half-way between two f32 from 2^23 to 2^24, exactly and a little off.
            let even = (1 << 23) + bits % (1 << 23);
            for text in [
                format!("{even}.5"),
                format!("{even}.5000001"),
                format!("{even}.4999999"),
            ] {
                is_read(&text);
            }
        }
    }

    #[test]
    fn what_is_no_plain_number_is_left_to_others() {
        for text in [
            "",
            "-",
            ".",
            "-.",
            "+1",
            "inf",
            "nan",
            "-inf",
            "e5",
            ".e5",
            "1e",
            "1e+",
            "1e1000",
            "1e-40",
            "1e39",
            "0x10",
            "1234567890123456",
            "--1",
        ] {
            let read = leading_f32(text.as_bytes());
            assert!(
                read.is_none() || (text == "0x10" && read == Some((0.0, 1))),
                "{text}: {read:?}"
            );
        }
        assert_eq!(leading_u32(b"123456789/4"), Some((123_456_789, 9)));
        assert_eq!([&b"1234567890"[..], b"", b"-1", b"+1"].map(leading_u32), [None; 4]);
    }
}
