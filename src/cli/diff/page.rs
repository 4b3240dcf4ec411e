//! Makes an HTML page of a comparison: one file with its pictures inside.

use sunroom::render::image_io::{FileFormat, FileOptions, ImageIoError, ImageRgb, encode_layered};
use sunroom::render::layered_image::LayeredImage;

use super::figures::Figures;
use super::pair::Pair;
use crate::cli::html::{escaped, filled};

/// The page as HTML. `options` say how the pictures are displayed.
pub fn page(pair: &Pair, figures: &Figures, options: &FileOptions) -> Result<String, ImageIoError> {
    let shown = FileOptions {
        png_16_bits: false,
        ..*options
    };
    let [picture, reference] = [&pair.picture, &pair.reference].map(|picture| data_uri(picture, &shown));
    let difference = data_uri(&pair.absolute(), &shown)?;
    let flip = match pair.flip_picture() {
        Some(errors) => {
            let errors = data_uri(&errors, &FileOptions::default())?;
            filled(include_str!("flip.html"), &[("flip", errors)])
        }
        None => String::new(),
    };
    let [name, against] = pair.paths.each_ref().map(|path| escaped(&path.display().to_string()));
    let row =
        |(name, value): (&str, String)| format!("<tr><th>{}</th><td>{}</td></tr>\n", escaped(name), escaped(&value));
    let table: String = figures.rows().into_iter().map(row).collect();
    let layer = match pair.layer.as_str() {
        "" => String::new(),
        layer => format!(", layer {}", escaped(layer)),
    };
    // All values are inserted in one pass: a value that looks like a placeholder is not replaced.
    let values = [
        ("name", name),
        ("against", against),
        ("layer", layer),
        ("width", figures.width.to_string()),
        ("height", figures.height.to_string()),
        ("table", table),
        ("picture", picture?),
        ("reference", reference?),
        ("difference", difference),
        ("flip", flip),
        ("version", env!("CARGO_PKG_VERSION").to_owned()),
    ];
    Ok(filled(include_str!("page.html"), &values))
}

fn data_uri(picture: &ImageRgb, options: &FileOptions) -> Result<String, ImageIoError> {
    let png = encode_layered(&LayeredImage::from(picture), FileFormat::Png, options)?;
    Ok(format!("data:image/png;base64,{}", base64(&png)))
}

/// Base 64 of RFC 4648, section 4.
fn base64(bytes: &[u8]) -> String {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = String::with_capacity(bytes.len().div_ceil(3) * 4);
    for group in bytes.chunks(3) {
        let byte = |i: usize| u32::from(group.get(i).copied().unwrap_or(0));
        let bits = byte(0) << 16 | byte(1) << 8 | byte(2);
        for digit in 0..4 {
            let index = bits >> (18 - 6 * digit) & 63;
            // A group of n bytes has n + 1 digits.
            text.push(if digit <= group.len() {
                char::from(DIGITS[index as usize])
            } else {
                '='
            });
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The values are the test vectors of RFC 4648, section 10.
    #[test]
    fn base64_is_that_of_the_standard() {
        let vectors = [
            ("", ""),
            ("f", "Zg=="),
            ("fo", "Zm8="),
            ("foo", "Zm9v"),
            ("foobar", "Zm9vYmFy"),
        ];
        for (plain, coded) in vectors {
            assert_eq!(base64(plain.as_bytes()), coded);
        }
    }

    #[test]
    fn values_are_put_in_once() {
        let values = [("a", "{{b}}".to_owned()), ("b", escaped("<x & \"y\">"))];
        assert_eq!(
            filled("1 {{a}} 2 {{b}} {{c}}3", &values),
            "1 {{b}} 2 &lt;x &amp; &quot;y&quot;&gt; 3"
        );
    }
}
