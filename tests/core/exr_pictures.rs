//! OpenEXR pictures as other programs write them: several parts, other primaries, windows that differ.

use std::io::Cursor;

use exr::meta::attribute::Chromaticities;
use exr::prelude::*;
use glam::Vec3;
use sunroom::texture::{self, ImageFileError, load_image};

/// A part of 2 x 1 pixels.
struct Part {
    name: &'static str,
    /// The names and both values of the channels.
    channels: Vec<(&'static str, [f32; 2])>,
    is_half: bool,
}

fn part(name: &'static str, channels: &[(&'static str, [f32; 2])]) -> Part {
    Part {
        name,
        channels: channels.to_vec(),
        is_half: false,
    }
}

fn rgb(left: [f32; 3], right: [f32; 3]) -> Vec<(&'static str, [f32; 2])> {
    let names = ["R", "G", "B"].into_iter().zip(0..);
    names.map(|(name, i)| (name, [left[i], right[i]])).collect()
}

/// A file of these parts, whose data windows begin at `first`.
fn file(parts: &[Part], first: Vec2<i32>, attributes: ImageAttributes) -> Vec<u8> {
    let layers = parts.iter().map(|part| {
        let channels = part.channels.iter().map(|(name, values)| {
            let samples = match part.is_half {
                true => FlatSamples::F16(values.iter().map(|value| f16::from_f32(*value)).collect()),
                false => FlatSamples::F32(values.to_vec()),
            };
            AnyChannel::new(*name, samples)
        });
        let mut own = LayerAttributes::named(part.name);
        own.layer_position = first;
        let channels = AnyChannels::sort(channels.collect());
        Layer::new(Vec2(2, 1), own, Encoding::UNCOMPRESSED, channels)
    });
    let mut bytes = Cursor::new(Vec::new());
    let image = Image::from_layers(attributes, layers.collect::<Vec<_>>());
    image.write().to_buffered(&mut bytes).expect("a file in memory");
    bytes.into_inner()
}

fn plain() -> ImageAttributes {
    ImageAttributes::with_size(Vec2(2, 1))
}

fn loaded(parts: &[Part], attributes: ImageAttributes) -> texture::Image {
    load_image(&file(parts, Vec2(0, 0), attributes)).expect("a picture")
}

const LEFT: [f32; 3] = [1.0, 0.5, 0.25];
const RIGHT: [f32; 3] = [0.25, 0.5, 1.0];

fn assert_picture(what: &str, image: &texture::Image, left: [f32; 3], right: [f32; 3]) {
    for (x, expected) in [(0, left), (1, right)] {
        let found = image.pixel(x, 0);
        let error = (found - Vec3::from(expected)).abs().max_element();
        assert!(error < 2e-3, "{what}, pixel {x}: {found} {expected:?}");
    }
}

#[test]
fn colours_come_from_whichever_parts_have_them() {
    let depth = || part("depth", &[("Z", [7.0, 8.0])]);
    let color = || part("colour", &rgb(LEFT, RIGHT));
    let channels = rgb(LEFT, RIGHT);
    let single = |name: &'static str, channel: usize| part(name, &channels[channel..=channel]);
    let prefixed: Vec<_> = ["Beauty.R", "Beauty.G", "Beauty.B"]
        .into_iter()
        .zip(&channels)
        .map(|(name, channel)| (name, channel.1))
        .collect();
    for (what, parts) in [
        ("the colours alone", vec![color()]),
        ("a depth behind", vec![color(), depth()]),
        ("a depth before", vec![depth(), color()]),
        ("a luminance before", vec![part("grey", &[("Y", [9.0, 9.0])]), color()]),
        ("with a prefix", vec![depth(), part("all", &prefixed)]),
        (
            "a part for each channel",
            vec![single("b", 2), depth(), single("g", 1), single("r", 0)],
        ),
        (
            "parts of two layers",
            vec![
                part("diffuse.R", &[("R", [5.0, 5.0])]),
                single("beauty.B", 2),
                single("beauty.G", 1),
                single("beauty.R", 0),
            ],
        ),
    ] {
        let image = loaded(&parts, plain());
        assert_eq!(image.channels(), 3, "{what}");
        assert_picture(what, &image, LEFT, RIGHT);
    }
    let greys = [depth(), part("grey", &[("A", [1.0; 2]), ("Y", [0.5, 0.75])])];
    let image = loaded(&greys, plain());
    assert_eq!(image.channels(), 1);
    assert_picture("a luminance behind a depth", &image, [0.5; 3], [0.75; 3]);
    assert_picture("a depth alone", &loaded(&[depth()], plain()), [7.0; 3], [8.0; 3]);
    let two = file(&[part("a", &[("A", [1.0; 2]), ("Z", [1.0; 2])])], Vec2(0, 0), plain());
    assert!(matches!(load_image(&two), Err(ImageFileError::Channels(names)) if names == "`A`, `Z`"));
}

#[test]
fn other_primaries_become_those_of_rec_709() {
    let with = |points: [[f32; 2]; 4]| {
        let [red, green, blue, white] = points.map(|[x, y]| Vec2(x, y));
        ImageAttributes {
            chromaticities: Some(Chromaticities {
                red,
                green,
                blue,
                white,
            }),
            ..plain()
        }
    };
    // Linear Rec. 709 to XYZ (IEC 61966-2-1), and to Rec. 2020 (ITU-R BT.2087).
    let xyz = |[r, g, b]: [f32; 3]| {
        [
            0.4124 * r + 0.3576 * g + 0.1805 * b,
            0.2126 * r + 0.7152 * g + 0.0722 * b,
            0.0193 * r + 0.1192 * g + 0.9505 * b,
        ]
    };
    let rec_2020 = |[r, g, b]: [f32; 3]| {
        [
            0.6274 * r + 0.3293 * g + 0.0433 * b,
            0.0691 * r + 0.9195 * g + 0.0114 * b,
            0.0164 * r + 0.0880 * g + 0.8956 * b,
        ]
    };
    let third = 1.0 / 3.0;
    let of_xyz = [[1.0, 0.0], [0.0, 1.0], [0.0, 0.0], [third, third]];
    let of_2020 = [[0.708, 0.292], [0.170, 0.797], [0.131, 0.046], [0.3127, 0.3290]];
    for is_half in [false, true] {
        for (what, points, convert) in [
            ("XYZ", of_xyz, &xyz as &dyn Fn([f32; 3]) -> [f32; 3]),
            ("Rec. 2020", of_2020, &rec_2020),
            (
                "Rec. 709",
                [[0.64, 0.33], [0.30, 0.60], [0.15, 0.06], [0.3127, 0.3290]],
                &|color| color,
            ),
            ("no sense", [[0.0; 2]; 4], &|color| color),
        ] {
            let part = Part {
                is_half,
                ..part("all", &rgb(convert(LEFT), convert(RIGHT)))
            };
            assert_picture(what, &loaded(&[part], with(points)), LEFT, RIGHT);
        }
    }
    // A luminance has no primaries.
    let grey = loaded(&[part("grey", &[("Y", [0.5, 0.75])])], with(of_xyz));
    assert_picture("grey", &grey, [0.5; 3], [0.75; 3]);
}

#[test]
fn the_display_window_is_the_picture() {
    let read = |first: Vec2<i32>, position: Vec2<i32>, size: Vec2<usize>, is_half: bool| {
        let part = Part {
            is_half,
            ..part("all", &rgb(LEFT, RIGHT))
        };
        let window = IntegerBounds::new(position, size);
        load_image(&file(&[part], first, ImageAttributes::new(window)))
    };
    let at = |image: &texture::Image, x: u32, y: u32| image.pixel(x, y).to_array();
    for is_half in [false, true] {
        // A frame around it, which need not begin at zero.
        let image = read(Vec2(11, 22), Vec2(10, 20), Vec2(4, 3), is_half).expect("a picture");
        assert_eq!((image.width(), image.height()), (4, 3));
        for (x, y) in (0..3).flat_map(|y| (0..4).map(move |x| (x, y))) {
            let expected = match (x, y) {
                (1, 2) => LEFT,
                (2, 2) => RIGHT,
                _ => [0.0; 3],
            };
            assert_eq!(at(&image, x, y), expected, "{x} {y}");
        }
        // What reaches out of the frame is left out.
        let image = read(Vec2(-1, 0), Vec2(0, 0), Vec2(1, 1), is_half).expect("a picture");
        assert_eq!((image.width(), image.height(), at(&image, 0, 0)), (1, 1, RIGHT));
        // Windows that do not meet: there is a picture all the same.
        let image = read(Vec2(-20, 0), Vec2(0, 0), Vec2(1, 1), is_half).expect("a picture");
        assert_eq!((image.width(), image.height()), (2, 1));
        assert_picture("apart", &image, LEFT, RIGHT);
    }
    // A frame that is mostly without data is a message: it would cost the file nothing, and the reader much.
    let wide = read(Vec2(0, 0), Vec2(0, 0), Vec2(1 << 12, 1 << 12), false).expect("a picture");
    assert_eq!((wide.width(), wide.height()), (1 << 12, 1 << 12));
    for size in [(1 << 12) + 1, 1 << 28] {
        let huge = read(Vec2(0, 0), Vec2(0, 0), Vec2(size, size), false);
        assert!(matches!(huge, Err(ImageFileError::Damaged(_))), "{huge:?}");
    }
}
