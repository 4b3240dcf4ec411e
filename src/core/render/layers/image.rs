//! The picture and its layers as named channels.

use std::collections::HashSet;

use glam::Mat4;

use super::Layer;
use super::cryptomatte::add_cryptomatte;
use super::read::LayerPixels;
use crate::color::Rgb;
use crate::render::camera::Camera;
use crate::render::film::Film;
use crate::render::image_io::ImageRgb;
use crate::render::layered_image::{Attribute, Channel, LayeredImage, Samples, full_name};

/// The names that layers refer to.
pub struct LayerNames<'a> {
    /// The name of an instance, as [`crate::accel::Hit::instance`] counts them.
    pub object: &'a dyn Fn(u32) -> String,
    /// The name of a material, by [`crate::material::MaterialId`].
    pub material: &'a dyn Fn(u32) -> String,
    /// The names of the light groups.
    pub light_groups: &'a [String],
}

/// The longest part of a name that names a light group, in bytes.
const LONGEST_NAME: usize = 200;

/// The picture without layers. The attributes `worldToCamera` and `worldToNDC` give the pose of the view's camera.
pub fn picture_of_camera(picture: &ImageRgb, camera: &Camera) -> LayeredImage {
    let mut image = LayeredImage::from(picture);
    // OpenEXR has row vectors: the rows are the columns here.
    let matrix = |matrix: Mat4| Attribute::Matrix(matrix.to_cols_array());
    image.set_attribute("worldToCamera", matrix(camera.right_up_forward_from_world()));
    image.set_attribute("worldToNDC", matrix(camera.film_from_world()));
    image
}

/// The picture of [`picture_of_camera`] with the layers of its film: the channels `R`, `G`, `B`, `A` of the picture
/// itself, and those of layers, such as `Albedo.R`, `Normal.X` or `LightGroup.lamp.R`. `camera` is the view's;
/// `denoised` is the layer of that name.
pub fn layered_image(
    picture: &ImageRgb,
    film: &Film,
    camera: &Camera,
    names: &LayerNames,
    denoised: Option<&[Rgb]>,
) -> LayeredImage {
    let mut image = picture_of_camera(picture, camera);
    for layer in film.layers().layers.iter() {
        let name = layer.name_in_pictures();
        match layer {
            Layer::LightGroups => add_light_groups(&mut image, film, names.light_groups),
            Layer::Denoised => denoised.into_iter().for_each(|pixels| image.add_rgb(name, pixels)),
            Layer::CryptoObject | Layer::CryptoMaterial => {
                let name_of = if layer == Layer::CryptoObject {
                    names.object
                } else {
                    names.material
                };
                let mattes = film.mattes(layer).unwrap_or_default();
                add_cryptomatte(&mut image, name, &mattes, name_of);
            }
            _ => match film.layer(layer, camera) {
                Some(LayerPixels::Colors(pixels)) => image.add_rgb(name, &pixels),
                Some(LayerPixels::Vectors(vectors)) => image.add_xyz(name, &vectors),
                Some(LayerPixels::Pairs(pairs)) => {
                    for (axis, channel) in layer.channels_in_pictures().iter().enumerate() {
                        let numbers = pairs.iter().map(|pair| pair[axis]).collect();
                        image.add_float(&full_name(name, channel), numbers);
                    }
                }
                Some(LayerPixels::Numbers(numbers)) => image.add_float(&number_name(layer), numbers),
                Some(LayerPixels::Ids(ids)) => image.channels.push(Channel {
                    name: number_name(layer),
                    samples: Samples::Uint(ids),
                }),
                None => {}
            },
        }
    }
    image
}

/// The name of the only channel of a layer.
fn number_name(layer: Layer) -> String {
    let name = layer.name_in_pictures();
    match layer.channels_in_pictures() {
        // Alpha is a channel of the picture itself.
        [channel, ..] if layer != Layer::Alpha => full_name(name, channel),
        _ => name.to_owned(),
    }
}

/// The name, followed by a number if it is already in `taken`, to which it is then added.
fn distinct(name: String, taken: &mut HashSet<String>) -> String {
    let numbered = (2..).map(|number| format!("{name}-{number}"));
    let mut names = std::iter::once(name.clone()).chain(numbered);
    names
        .find(|name| taken.insert(name.clone()))
        .expect("there are names without end")
}

/// Adds a layer for each light group. Dots in names are replaced, because they would begin another layer.
fn add_light_groups(image: &mut LayeredImage, film: &Film, names: &[String]) {
    let mut taken = HashSet::new();
    for group in 0..film.layers().groups {
        let Some(light) = film.light_group(group) else {
            return;
        };
        let name = names.get(group).map_or("", String::as_str);
        let end = name.floor_char_boundary(LONGEST_NAME);
        let mut name = name[..end].replace('.', "_");
        if name.is_empty() {
            name = (group + 1).to_string();
        }
        let name = distinct(name, &mut taken);
        image.add_rgb(&format!("{}.{name}", Layer::LightGroups.name_in_pictures()), &light);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_that_are_cleaned_to_the_same_stay_distinct() {
        let mut taken = HashSet::new();
        let given = ["lamp_2", "lamp", "lamp_2", "lamp", "lamp-2", "lamp"];
        let names = given.map(|name| distinct(name.to_owned(), &mut taken));
        assert_eq!(names, ["lamp_2", "lamp", "lamp_2-2", "lamp-2", "lamp-2-2", "lamp-3"]);
    }
}
