//! Two pictures to be compared.

use std::path::{Path, PathBuf};

use super::chosen::{Chosen, choose};
use sunroom::color::{Rgb, linear_from_srgb};
use sunroom::files::Access;
use sunroom::memory::read_data;
use sunroom::metrics::flip::{Exposures, PIXELS_PER_DEGREE, hdr_flip, ldr_flip};
use sunroom::metrics::magma;
use sunroom::render::image_io::{ImageRgb, LoadedPicture, load_picture};
use sunroom::render::layered_image::LayeredImage;

pub struct Pair {
    pub paths: [PathBuf; 2],
    /// The compared layer; empty for the picture itself.
    pub layer: String,
    /// The picture and the reference, of one size. NaN and infinite values are black.
    pub picture: ImageRgb,
    pub reference: ImageRgb,
    /// The number of pixels in each with such values.
    pub not_finite: [usize; 2],
    /// The variances of picture and reference.
    pub variances: [Option<Variance>; 2],
    /// The number of components of a pixel, 1 to 3.
    pub components: usize,
    /// Sentences about values that are compared in another form than they are stored.
    pub notes: Vec<String>,
    /// The perceived difference; None for data.
    pub seen: Option<Seen>,
}

/// The perceived difference of two pictures of light.
pub struct Seen {
    /// The exposures of FLIP; None for display-referred pictures.
    pub exposures: Option<Exposures>,
    /// The errors of FLIP, row by row.
    pub flip: Vec<f32>,
}

/// The variance of each pixel's value.
pub struct Variance {
    pub pixels: Vec<Rgb>,
    /// Whether it is the variance of the luminance, with all three components equal.
    pub is_of_luminance: bool,
}

impl Pair {
    /// An error if a file cannot be read, the layer is missing or of another kind in one of them, or the sizes differ.
    pub fn read(paths: [&Path; 2], layer: &str) -> Result<Self, String> {
        let [picture, reference] = paths.map(load);
        let (loaded, against) = (picture?, reference?);
        let size = |picture: &LoadedPicture| [picture.image.width, picture.image.height];
        if size(&loaded) != size(&against) {
            let [[w, h], [other_w, other_h]] = [size(&loaded), size(&against)];
            return Err(format!(
                "{} has {w} x {h} pixels and {} has {other_w} x {other_h}: only pictures of one size are compared",
                paths[0].display(),
                paths[1].display()
            ));
        }
        let chosen = choose(&loaded.image, layer, paths[0])?;
        let other = choose(&against.image, layer, paths[1])?;
        // One picture may be grey and the other coloured.
        if !layer.is_empty() && (chosen.components, chosen.is_light) != (other.components, other.is_light) {
            return Err(format!(
                "{} has {} of the name `{layer}`, and {} has {}: they are not the same",
                paths[0].display(),
                chosen.what(),
                paths[1].display(),
                other.what()
            ));
        }
        let is_light = chosen.is_light;
        let components = chosen.components.max(other.components);
        let is_displayed = [loaded.is_displayed, against.is_displayed];
        let notes = notes(paths, [&chosen, &other], is_displayed);
        let (mut picture, mut reference) = (chosen.image, other.image);
        let not_finite = [&mut picture, &mut reference].map(blacken);
        let variances = match layer {
            "" => [&loaded, &against].map(|loaded| variance(&loaded.image)),
            _ => [None, None],
        };
        let seen = is_light.then(|| seen(&picture, &reference, is_displayed == [true; 2]));
        Ok(Self {
            paths: paths.map(Path::to_owned),
            layer: layer.to_owned(),
            picture,
            reference,
            not_finite,
            variances,
            components,
            notes,
            seen,
        })
    }

    /// The errors of FLIP as display colours; None for data.
    pub fn flip_picture(&self) -> Option<ImageRgb> {
        let color = |error: &f32| magma(*error).map(linear_from_srgb);
        let seen = self.seen.as_ref()?;
        Some(ImageRgb {
            pixels: seen.flip.iter().map(color).collect(),
            ..self.picture
        })
    }

    /// The absolute difference.
    pub fn absolute(&self) -> ImageRgb {
        let pixels = self.picture.pixels.iter().zip(&self.reference.pixels);
        ImageRgb {
            pixels: pixels.map(|(&a, &b)| (a - b).abs()).collect(),
            ..self.picture
        }
    }
}

/// The sentences for [`Pair::notes`].
fn notes(paths: [&Path; 2], [chosen, other]: [&Chosen; 2], is_displayed: [bool; 2]) -> Vec<String> {
    let mut notes = Vec::new();
    let names = paths.map(Path::display);
    for (name, chosen) in names.iter().zip([chosen, other]) {
        if chosen.is_xyz {
            notes.push(format!(
                "{name} has the channels X, Y and Z: they count as CIE XYZ, and are converted to red, green and blue"
            ));
        }
    }
    let grey = match (chosen.components, other.components) {
        (1, 2..) => Some(0),
        (2.., 1) => Some(1),
        _ => None,
    };
    if let Some(grey) = grey {
        let [grey, coloured] = [&names[grey], &names[1 - grey]];
        notes.push(format!(
            "{grey} is grey and {coloured} has colours: the grey counts as red, green and blue"
        ));
    }
    let displayed = match is_displayed {
        [true, false] => Some(0),
        [false, true] => Some(1),
        _ => None,
    };
    if let Some(displayed) = displayed {
        let [displayed, radiance] = [&names[displayed], &names[1 - displayed]];
        notes.push(format!(
            "{displayed} has what a display shows, at most 1, and {radiance} has radiance: what is brighter there counts as a difference"
        ));
    }
    notes
}

fn seen(picture: &ImageRgb, reference: &ImageRgb, are_displayed: bool) -> Seen {
    let exposures = match are_displayed {
        true => None,
        false => Exposures::of(&reference.pixels),
    };
    let width = picture.width as usize;
    let flip = match exposures {
        Some(exposures) => hdr_flip(&picture.pixels, &reference.pixels, width, exposures, PIXELS_PER_DEGREE),
        None => ldr_flip(&picture.pixels, &reference.pixels, width, PIXELS_PER_DEGREE),
    };
    Seen { exposures, flip }
}

fn load(path: &Path) -> Result<LoadedPicture, String> {
    let named = |error: &dyn std::fmt::Display| format!("{}: {error}", path.display());
    let bytes = read_data(path, &Access::everywhere()).map_err(|error| named(&error))?;
    load_picture(&bytes).map_err(|error| named(&error))
}

/// Makes pixels with NaN or infinite values black; returns their number.
fn blacken(image: &mut ImageRgb) -> usize {
    let broken = image.pixels.iter_mut().filter(|pixel| !pixel.is_finite());
    broken.map(|pixel| *pixel = Rgb::ZERO).count()
}

fn variance(image: &LayeredImage) -> Option<Variance> {
    const LAYER: &str = "Variance";
    Some(Variance {
        pixels: image.layer(LAYER)?.pixels,
        is_of_luminance: image.channel("Variance.R").is_none(),
    })
}
