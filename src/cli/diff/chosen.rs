//! The compared part of a picture: the picture itself, a layer, or a channel.

use std::path::Path;

use crate::cli::report::counted;
use sunroom::color::rgb_from_xyz;
use sunroom::layer::{Layer, Layers};
use sunroom::render::image_io::ImageRgb;
use sunroom::render::layered_image::{Channel, LayeredImage, is_cryptomatte, split_name};

pub struct Chosen {
    /// The numbers as colours: a single one is grey, and with two the blue is 0.
    pub image: ImageRgb,
    /// The number of components of a pixel, 1 to 3.
    pub components: usize,
    /// Whether the numbers are colours or luminances, which can be shown, and not data such as depths and normals.
    pub is_light: bool,
    /// Whether the file has CIE XYZ, from which the colours are converted.
    pub is_xyz: bool,
}

impl Chosen {
    /// The kind of the numbers, in words.
    pub fn what(&self) -> String {
        let kind = match self.is_light {
            true => "a layer of light",
            false => "data",
        };
        format!("{kind} with {}", counted(self.components, "component"))
    }
}

/// The part of a picture with this name: a layer as in the file (`Depth`) or as for `--aov` (`depth`), a channel
/// (`Depth.Z`), or with an empty name the picture itself. The error lists the layers.
pub fn choose(image: &LayeredImage, name: &str, path: &Path) -> Result<Chosen, String> {
    let in_file = match Layer::of_name(name) {
        Some(layer) => layer.name_in_pictures(),
        None => name,
    };
    let is_matte = |name: &str| is_cryptomatte(name) || is_cryptomatte(split_name(name).0);
    if name == "all" {
        return Err("`--layer` compares one layer, and `all` means several".to_owned());
    }
    if is_matte(in_file) || Layers::from_name(name).is_ok_and(|layers| layers.contains(Layer::CryptoObject)) {
        return Err(format!(
            "`{name}` is a cryptomatte, whose numbers stand for names and have no differences: compare the layer `object-id` or `material-id`"
        ));
    }
    let channels = image.channels_of(name).or_else(|| image.channels_of(in_file));
    let channels = channels.or_else(|| Some(vec![image.channel(in_file)?]));
    let channels = channels.ok_or_else(|| no_layer(image, name, path))?;
    let mut colors = image.as_colors(&channels);
    // The order of the film's `pixel_format`.
    let is_xyz = name.is_empty() && channels.len() == 3 && channels[0].name.eq_ignore_ascii_case("X");
    if is_xyz {
        colors.pixels.iter_mut().for_each(|pixel| *pixel = rgb_from_xyz(*pixel));
    }
    Ok(Chosen {
        image: colors,
        is_xyz,
        components: channels.len(),
        is_light: are_light(&channels, name.is_empty()),
    })
}

/// Whether the channels are light. `are_picture`: they are the picture itself.
fn are_light(channels: &[&Channel], are_picture: bool) -> bool {
    are_picture
        || channels.iter().all(|channel| {
            let (layer, last) = split_name(&channel.name);
            ["R", "G", "B"].contains(&last) && !layer.starts_with("Variance")
        })
}

fn no_layer(image: &LayeredImage, layer: &str, path: &Path) -> String {
    let path = path.display();
    let names: Vec<String> = image
        .layers()
        .iter()
        .filter(|name| !name.is_empty())
        .map(|name| format!("`{name}`"))
        .collect();
    let known = match names.is_empty() {
        true => "it has none".to_owned(),
        false => format!("it has {}", names.join(", ")),
    };
    match layer {
        "" => format!("{path} has no colours of its own; `--layer` names a layer, and {known}"),
        _ => format!("{path} has no layer or channel `{layer}`; {known}"),
    }
}
