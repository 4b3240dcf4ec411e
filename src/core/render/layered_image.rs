//! A picture of named channels with attributes, as an OpenEXR file of one part holds it.
//!
//! The channels of the picture itself are named `R`, `G`, `B` and optionally `A`. Others belong to a layer, whose name
//! precedes the last dot (`Albedo.R`, `Normal.X`, `Depth.Z`), as in the technical introduction to OpenEXR, "Channel
//! names". Files are written and read by [`super::image_io::exr`].

use std::collections::HashSet;

use glam::Vec3;

use super::image_io::ImageRgb;
use crate::color::{Rgb, luminance, xyz_from_rgb};
use crate::memory::Held;

/// Named channels of one size, in any order, and attributes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LayeredImage {
    /// The number of pixels in a row, above zero.
    pub width: u32,
    /// The number of rows, above zero.
    pub height: u32,
    /// The channels. No two have the same name.
    pub channels: Vec<Channel>,
    /// Metadata of the picture, by name. No two have the same name.
    pub attributes: Vec<(String, Attribute)>,
    /// The position in a larger picture, if it is a part of one: its first column and row there, and the size of the
    /// larger picture.
    pub place: Option<[u32; 4]>,
    /// The memory that a reader has reserved in the budget.
    pub(super) memory: Held,
}

/// One number for each pixel.
#[derive(Clone, Debug, PartialEq)]
pub struct Channel {
    /// The name with that of its layer: `R`, `Albedo.R`, `CryptoObject00.R`. It has 1 to 255 bytes.
    pub name: String,
    /// `width * height` samples, row by row from the top left.
    pub samples: Samples,
}

/// The samples of a channel, and how they are stored in a file.
#[derive(Clone, Debug, PartialEq)]
pub enum Samples {
    /// Floats that are stored with 16 bits. Values beyond 65504 are clamped to it, and infinite ones stay infinite.
    Half(Vec<f32>),
    /// Floats that are stored unchanged.
    Float(Vec<f32>),
    /// Whole numbers, such as identifiers.
    Uint(Vec<u32>),
}

impl Samples {
    /// The number of samples.
    pub fn len(&self) -> usize {
        match self {
            Self::Half(samples) | Self::Float(samples) => samples.len(),
            Self::Uint(samples) => samples.len(),
        }
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// A sample as a float; whole numbers are rounded to the nearest float.
    pub fn value(&self, index: usize) -> f32 {
        match self {
            Self::Half(samples) | Self::Float(samples) => samples[index],
            Self::Uint(samples) => samples[index] as f32,
        }
    }
}

/// A value for the whole picture.
#[derive(Clone, Debug, PartialEq)]
pub enum Attribute {
    /// Text. Programs expect ASCII; other characters are written as UTF-8.
    Text(String),
    /// A whole number.
    Int(i32),
    /// A number in single precision.
    Float(f32),
    /// A matrix for row vectors, row by row: the translation is in the last row, as OpenEXR's `worldToCamera` is used.
    Matrix([f32; 16]),
}

/// The stored form of a picture's colours.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum StoredColors {
    /// Linear Rec. 709.
    #[default]
    Rgb,
    /// CIE Y alone.
    Luminance,
    /// CIE XYZ.
    Xyz,
}

impl StoredColors {
    /// The stored form of a colour; the luminance is repeated in all components.
    pub(super) fn of(self, rgb: Rgb) -> Vec3 {
        match self {
            Self::Rgb => rgb,
            Self::Luminance => Vec3::splat(luminance(rgb)),
            Self::Xyz => xyz_from_rgb(rgb),
        }
    }
}

/// The last parts of the names of three channels that form a colour or vector.
const TRIPLES: [[&str; 3]; 2] = [["R", "G", "B"], ["X", "Y", "Z"]];

/// The last parts of the names of two channels that form a pair: motion in pixels and texture coordinates.
const PAIRS: [[&str; 2]; 2] = [["X", "Y"], ["U", "V"]];

impl LayeredImage {
    /// A picture without channels.
    pub fn new(width: u32, height: u32) -> Self {
        Self {
            width,
            height,
            ..Self::default()
        }
    }

    /// The number of pixels.
    pub fn pixel_count(&self) -> usize {
        self.width as usize * self.height as usize
    }

    /// The part of this size with its first pixel at (x, y), which must be within the picture.
    pub fn cropped(mut self, x: u32, y: u32, width: u32, height: u32) -> Self {
        fn cut<T: Copy>(samples: &[T], row: usize, x: usize, y: usize, width: usize, height: usize) -> Vec<T> {
            let rows = samples.chunks_exact(row).skip(y).take(height);
            rows.flat_map(|row| &row[x..x + width]).copied().collect()
        }
        let row = self.width as usize;
        let [left, top, columns, rows] = [x, y, width, height].map(|number| number as usize);
        for channel in &mut self.channels {
            match &mut channel.samples {
                Samples::Half(samples) | Samples::Float(samples) => {
                    *samples = cut(samples, row, left, top, columns, rows);
                }
                Samples::Uint(samples) => *samples = cut(samples, row, left, top, columns, rows),
            }
        }
        self.place = Some([x, y, self.width, self.height]);
        (self.width, self.height) = (width, height);
        self
    }

    /// The channel of this full name.
    pub fn channel(&self, name: &str) -> Option<&Channel> {
        self.channels.iter().find(|channel| channel.name == name)
    }

    /// Adds a channel with one sample for each pixel.
    pub fn add_channel(&mut self, name: &str, samples: Samples) {
        self.channels.push(Channel {
            name: name.to_owned(),
            samples,
        });
    }

    /// Adds a channel of floats that are stored unchanged, with one sample for each pixel.
    pub fn add_float(&mut self, name: &str, samples: Vec<f32>) {
        self.add_channel(name, Samples::Float(samples));
    }

    /// Adds the channels `R`, `G` and `B` of a layer, whose name is empty for the picture itself.
    pub fn add_rgb(&mut self, layer: &str, pixels: &[Rgb]) {
        self.add_triple(layer, TRIPLES[0], pixels);
    }

    /// Adds the channels `X`, `Y` and `Z` of a layer.
    pub fn add_xyz(&mut self, layer: &str, vectors: &[Vec3]) {
        self.add_triple(layer, TRIPLES[1], vectors);
    }

    fn add_triple(&mut self, layer: &str, names: [&str; 3], vectors: &[Vec3]) {
        for (axis, name) in names.into_iter().enumerate() {
            self.add_float(
                &full_name(layer, name),
                vectors.iter().map(|vector| vector[axis]).collect(),
            );
        }
    }

    /// The names of the layers in the order of their first channels; the picture itself has an empty name.
    pub fn layers(&self) -> Vec<&str> {
        let mut known = HashSet::new();
        let layers = self.channels.iter().map(|channel| split_name(&channel.name).0);
        layers.filter(|layer| known.insert(*layer)).collect()
    }

    /// The channels that form the value of a layer, whose name is empty for the picture itself: `R`, `G`, `B`, or `X`,
    /// `Y`, `Z`, or `X`, `Y`, or `U`, `V`, or else the only one of the layer that is not `A` (or its `Y`). None if the
    /// layer has no such channels.
    pub fn channels_of(&self, layer: &str) -> Option<Vec<&Channel>> {
        let of_layer: Vec<(&str, &Channel)> = self
            .channels
            .iter()
            .map(|channel| (split_name(&channel.name), channel))
            .filter(|((before, _), _)| *before == layer)
            .map(|((_, last), channel)| (last, channel))
            .collect();
        let named = |name: &str| of_layer.iter().find(|(last, _)| last.eq_ignore_ascii_case(name));
        let all = |names: &[&str]| {
            let found = names.iter().map(|name| Some(named(name)?.1));
            found.collect::<Option<Vec<&Channel>>>()
        };
        let only = || {
            let mut others = of_layer.iter().filter(|(last, _)| !last.eq_ignore_ascii_case("A"));
            let first = others.next()?;
            others.next().is_none().then(|| vec![first.1])
        };
        let triple = TRIPLES.iter().find_map(|names| all(names));
        let pair = || PAIRS.iter().find_map(|names| all(names));
        triple.or_else(pair).or_else(|| all(&["Y"])).or_else(only)
    }

    /// Channels as colours: a single one becomes grey, and two have a blue of 0.
    pub fn as_colors(&self, channels: &[&Channel]) -> ImageRgb {
        let pixel = |i| match *channels {
            [grey] => Rgb::splat(grey.samples.value(i)),
            _ => Rgb::from_array(std::array::from_fn(|axis| {
                channels.get(axis).map_or(0.0, |channel| channel.samples.value(i))
            })),
        };
        ImageRgb {
            width: self.width,
            height: self.height,
            pixels: (0..self.pixel_count()).map(pixel).collect(),
        }
    }

    /// A layer as colours, see [`Self::channels_of`] and [`Self::as_colors`].
    pub fn layer(&self, layer: &str) -> Option<ImageRgb> {
        Some(self.as_colors(&self.channels_of(layer)?))
    }

    /// The opacity of the picture itself, in [0, 1], row by row; None if it has no channel `A`.
    pub fn alpha(&self) -> Option<Vec<f32>> {
        let samples = &self.channel("A")?.samples;
        Some((0..samples.len()).map(|i| samples.value(i)).collect())
    }

    /// The attribute of this name.
    pub fn attribute(&self, name: &str) -> Option<&Attribute> {
        let found = self.attributes.iter().find(|(other, _)| other == name);
        found.map(|(_, attribute)| attribute)
    }

    /// Adds attributes, or replaces those with the same names; the last of several with one name counts.
    pub fn set_attributes(&mut self, attributes: impl DoubleEndedIterator<Item = (String, Attribute)>) {
        let mut names = HashSet::new();
        let mut new: Vec<(String, Attribute)> = attributes
            .rev()
            .filter(|(name, _)| names.insert(name.clone()))
            .collect();
        self.attributes.retain(|(name, _)| !names.contains(name));
        new.reverse();
        self.attributes.append(&mut new);
    }

    /// Adds an attribute, or replaces the one of the same name.
    pub fn set_attribute(&mut self, name: &str, attribute: Attribute) {
        self.attributes.retain(|(other, _)| other != name);
        self.attributes.push((name.to_owned(), attribute));
    }

    /// Replaces the channels `R`, `G` and `B` of the picture itself by their stored form: `Y`, or `X`, `Y` and `Z`. A
    /// picture without these channels is unchanged.
    pub fn convert_colors(&mut self, stored: StoredColors) {
        let is_color = |channel: &Channel| TRIPLES[0].contains(&channel.name.as_str());
        let Some(colors) = self
            .layer("")
            .filter(|_| stored != StoredColors::Rgb && self.channels.iter().any(is_color))
        else {
            return;
        };
        self.channels.retain(|channel| !is_color(channel));
        let values: Vec<Vec3> = colors.pixels.iter().map(|&rgb| stored.of(rgb)).collect();
        match stored {
            StoredColors::Luminance => self.add_float("Y", values.iter().map(|value| value.y).collect()),
            StoredColors::Rgb | StoredColors::Xyz => self.add_xyz("", &values),
        }
    }

    /// Lets colours and opacities (`R`, `G`, `B`, `A`) be stored with 16 bits. Unchanged are cryptomattes (`Crypto*`),
    /// whose floats are identifiers, variances (`Variance*`), which are too small for 16 bits, and vectors and depths.
    pub fn store_colors_as_half(&mut self) {
        for channel in &mut self.channels {
            let (layer, last) = split_name(&channel.name);
            let is_color =
                ["R", "G", "B", "A"].contains(&last) || (layer.is_empty() && ["X", "Y", "Z"].contains(&last));
            let is_exact = is_cryptomatte(layer) || layer.starts_with("Variance");
            if let Samples::Float(samples) = &mut channel.samples
                && is_color
                && !is_exact
            {
                channel.samples = Samples::Half(std::mem::take(samples));
            }
        }
    }
}

impl From<&ImageRgb> for LayeredImage {
    fn from(image: &ImageRgb) -> Self {
        let mut layered = Self::new(image.width, image.height);
        layered.add_rgb("", &image.pixels);
        layered
    }
}

/// The name of a layer and that of the channel in it.
pub fn split_name(name: &str) -> (&str, &str) {
    name.rsplit_once('.').unwrap_or(("", name))
}

/// The name of a channel in a layer, which is empty for the picture itself.
pub(super) fn full_name(layer: &str, channel: &str) -> String {
    match layer {
        "" => channel.to_owned(),
        _ => format!("{layer}.{channel}"),
    }
}

/// Whether the floats of the layer are bits that must not change.
pub fn is_cryptomatte(layer: &str) -> bool {
    layer.starts_with("Crypto")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn layered() -> LayeredImage {
        let mut image = LayeredImage::from(&ImageRgb {
            width: 2,
            height: 1,
            pixels: vec![Rgb::new(1.0, 2.0, 3.0), Rgb::new(4.0, 5.0, 6.0)],
        });
        image.add_float("A", vec![0.5, 1.0]);
        image.add_xyz("Normal", &[Vec3::X, Vec3::NEG_Z]);
        image.add_float("Depth.Z", vec![7.0, 8.0]);
        image.add_rgb("Light.Key", &[Rgb::ONE, Rgb::ZERO]);
        image.add_rgb("CryptoObject00", &[Rgb::ONE, Rgb::ZERO]);
        image
    }

    #[test]
    fn of_attributes_of_one_name_the_last_counts() {
        let text = |name: &str, value: &str| (name.to_owned(), Attribute::Text(value.to_owned()));
        let mut image = layered();
        image.set_attribute("a", Attribute::Int(1));
        image.set_attribute("b", Attribute::Int(2));
        image.set_attributes([text("c", "1"), text("a", "2"), text("c", "3")].into_iter());
        assert_eq!(
            image.attributes,
            [("b".to_owned(), Attribute::Int(2)), text("a", "2"), text("c", "3")]
        );
        // A file may have so many attributes that a linear search for each would take too long.
        let many = (0..200_000).map(|i| (i.to_string(), Attribute::Int(i)));
        image.set_attributes(many);
        assert_eq!(image.attributes.len(), 200_003);
    }

    #[test]
    fn layers_are_found_by_name() {
        let image = layered();
        assert_eq!(image.layers(), ["", "Normal", "Depth", "Light.Key", "CryptoObject00"]);
        assert_eq!(image.layer("").expect("the picture").pixels[1], Rgb::new(4.0, 5.0, 6.0));
        assert_eq!(image.layer("Normal").expect("a vector").pixels, [Vec3::X, Vec3::NEG_Z]);
        assert_eq!(
            image.layer("Depth").expect("one channel").pixels,
            [Rgb::splat(7.0), Rgb::splat(8.0)]
        );
        assert_eq!(
            image.layer("Light.Key").expect("a dotted layer").pixels,
            [Rgb::ONE, Rgb::ZERO]
        );
        assert_eq!(image.layer("Light"), None);
        let mut image = image;
        image.add_float("Motion.X", vec![1.0, 2.0]);
        image.add_float("Motion.Y", vec![3.0, 4.0]);
        let motion = image.layer("Motion").expect("a pair").pixels;
        assert_eq!(motion, [Vec3::new(1.0, 3.0, 0.0), Vec3::new(2.0, 4.0, 0.0)]);
        assert_eq!(image.alpha(), Some(vec![0.5, 1.0]));
    }

    #[test]
    fn only_colours_become_half() {
        let mut image = layered();
        image.add_float("Variance.R", vec![1e-9, 1e-10]);
        image.store_colors_as_half();
        let halves = image.channels.iter().filter(|c| matches!(c.samples, Samples::Half(_)));
        let names: Vec<&str> = halves.map(|channel| channel.name.as_str()).collect();
        assert_eq!(names, ["R", "G", "B", "A", "Light.Key.R", "Light.Key.G", "Light.Key.B"]);
    }

    #[test]
    fn colours_become_luminances_or_xyz() {
        let names = |stored| {
            let mut image = layered();
            image.convert_colors(stored);
            let own = image.channels.iter().filter(|channel| !channel.name.contains('.'));
            (own.map(|channel| channel.name.clone()).collect::<Vec<_>>(), image)
        };
        let (luminances, image) = names(StoredColors::Luminance);
        assert_eq!(luminances, ["A", "Y"]);
        let expected = luminance(Rgb::new(1.0, 2.0, 3.0));
        assert_eq!(image.channel("Y").expect("luminance").samples.value(0), expected);
        let (xyz, image) = names(StoredColors::Xyz);
        assert_eq!(xyz, ["A", "X", "Y", "Z"]);
        // White is the sum of the matrix's columns: D65.
        assert!(xyz_from_rgb(Rgb::ONE).abs_diff_eq(Vec3::new(0.9505, 1.0, 1.0888), 2e-4));
        assert_eq!(image.channel("Y").expect("luminance").samples.value(0), expected);
        assert_eq!(names(StoredColors::Rgb).1, layered());
    }

    #[test]
    fn an_attribute_has_one_value() {
        let mut image = layered();
        image.set_attribute("a", Attribute::Int(1));
        image.set_attribute("a", Attribute::Float(2.0));
        assert_eq!(image.attributes.len(), 1);
        assert_eq!(image.attribute("a"), Some(&Attribute::Float(2.0)));
        assert_eq!(image.attribute("b"), None);
    }
}
