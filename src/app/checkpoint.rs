//! The file of an unfinished picture with its exact sums, from which rendering resumes or parts are merged.

use std::path::Path;

use bevy::prelude::*;

use crate::engine::{PackedScene, PictureNames, RenderFilm, active_film, job_state, reserve_film, resume};
use crate::layer::Layer;
use crate::render::film::Film;
use crate::render::image_io::{ExrCompression, FileFormat, FileOptions, ImageIoError, ImageRgb, encode_layered};
use crate::render::layered_image::{Attribute, LayeredImage};
use crate::render::part::{About, Crop, Origin, PartFile, PartHeader, write_part};

/// A picture to render, or a share of one, without its samples.
pub struct Piece {
    /// The origin of the whole picture.
    pub origin: Origin,
    /// Width and height of the whole picture in pixels.
    pub size: [u32; 2],
    /// The pixels of the piece.
    pub crop: Crop,
    /// The first sample of each pixel, and the end of the requested samples.
    pub samples: [u32; 2],
    /// The samples per pixel of the whole picture; None if they are not known.
    pub samples_of_whole: Option<u32>,
}

impl Piece {
    /// Makes the next picture resume from a file. The scene is packed as it was then. Returns the number of samples
    /// that every pixel of the piece has. The error is a sentence on the difference of the pictures, or on the failure
    /// to read the file, without the file's name.
    pub fn take_up(&self, world: &mut World, file: &PartFile) -> Result<u32, String> {
        let header = file.header();
        let view = world.resource::<PackedScene>().view.as_ref();
        let Some(kept) = view.map(|view| view.film_layers()) else {
            return Ok(0);
        };
        if [header.width, header.height] != self.size || header.film_layers() != kept {
            return Err(
                "the checkpoint is of a picture that has another size or other layers, and this one cannot go on with it"
                    .to_owned(),
            );
        }
        if header.crop != self.crop || header.samples[0] != self.samples[0] {
            let Crop { x, y, width, height } = header.crop;
            let [start, end] = header.samples;
            return Err(format!(
                "the checkpoint is of another part of the picture: --samples {start}..{end} --crop {x},{y},{width},{height}"
            ));
        }
        reserve_film(world)?;
        let mut film = Film::with_layers(self.size[0], self.size[1], kept);
        if self.samples[0] > 0 {
            film.keep_chunks();
        }
        let job = file.read_into(&mut film).map_err(|error| error.to_string())?;
        let samples = self.counts(&film).min().unwrap_or(0);
        resume(world, film, job);
        Ok(samples)
    }

    /// Whether every pixel of the piece has exactly the requested samples.
    fn is_finished(&self, film: &Film) -> bool {
        let samples = self.samples[1] - self.samples[0];
        self.counts(film).all(|count| count == samples)
    }

    /// Whether every pixel of the piece has a sample.
    pub fn is_whole(&self, film: &Film) -> bool {
        self.counts(film).all(|count| count > 0)
    }

    /// The number of samples of each of its pixels.
    pub fn counts<'a>(&self, film: &'a Film) -> impl Iterator<Item = u32> + use<'a> {
        let Crop { x, y, width, height } = self.crop;
        let [all_columns, all_rows] = [film.width(), film.height()];
        // Nothing is rendered yet where the film has no size.
        let (columns, rows) = (x..(x + width).min(all_columns), y..(y + height).min(all_rows));
        rows.flat_map(move |y| columns.clone().map(move |x| film.samples(x, y)))
    }

    /// The crop of the picture to the piece.
    pub fn cut(&self, picture: LayeredImage) -> LayeredImage {
        let Crop { x, y, width, height } = self.crop;
        match self.crop == Crop::whole(self.size[0], self.size[1]) {
            true => picture,
            false => picture.cropped(x, y, width, height),
        }
    }

    /// Writes the picture to a file with its exact sums.
    pub fn write(
        &self,
        world: &World,
        path: &Path,
        picture: &LayeredImage,
        options: &FileOptions,
    ) -> Result<(), ImageIoError> {
        let content = encode_layered(picture, FileFormat::Exr, options)?;
        self.write_state(world, path, &content, picture)
    }

    /// Writes a checkpoint. `described`: a picture with the attributes of the finished one.
    pub fn write_checkpoint(&self, world: &World, path: &Path, described: &LayeredImage) -> Result<(), ImageIoError> {
        let film = &world.resource::<RenderFilm>().film;
        let mut picture = LayeredImage::from(&ImageRgb {
            width: film.width(),
            height: film.height(),
            pixels: film.radiance(),
        });
        picture.attributes.clone_from(&described.attributes);
        let options = FileOptions {
            exr_compression: ExrCompression::None,
            ..FileOptions::default()
        };
        let content = encode_layered(&self.cut(picture), FileFormat::Exr, &options)?;
        self.write_state(world, path, &content, described)
    }

    fn write_state(
        &self,
        world: &World,
        path: &Path,
        content: &[u8],
        described: &LayeredImage,
    ) -> Result<(), ImageIoError> {
        let film = &world.resource::<RenderFilm>().film;
        let tiles: Vec<_> = self.crop.tiles(self.size[0], self.size[1]).collect();
        let begun: Vec<_> = tiles
            .into_iter()
            .filter(|tile| film.samples(tile.x, tile.y) > 0)
            .collect();
        let header = PartHeader {
            origin: self.origin.clone(),
            width: self.size[0],
            height: self.size[1],
            crop: self.crop,
            samples: self.samples,
            samples_of_whole: self.samples_of_whole,
            is_finished: self.is_finished(film),
            layers: film
                .layers()
                .layers
                .iter()
                .map(|layer| Layer::name(layer).to_owned())
                .collect(),
            splats: film.layers().splats,
            about: about(world, described),
        };
        let job = job_state(world).unwrap_or_default();
        write_part(path, content, &header, film, &begun, &job).map_err(|source| ImageIoError::Write {
            path: path.to_owned(),
            source,
        })
    }
}

/// The data for writing the picture later.
fn about(world: &World, described: &LayeredImage) -> About {
    let names = PictureNames::of(world);
    let text = |(name, attribute): &(String, Attribute)| match attribute {
        // Manifests of cryptomattes list the objects in these pixels; the finished picture has others.
        Attribute::Text(value) if !name.starts_with("cryptomatte/") => Some((name.clone(), value.clone())),
        _ => None,
    };
    let view = world.resource::<PackedScene>().view.as_ref();
    let storage = active_film(world).map(|film| film.storage).unwrap_or_default();
    About {
        texts: described.attributes.iter().filter_map(text).collect(),
        seed: view.map_or(0, |view| view.seed),
        objects: names.objects,
        materials: names.materials,
        light_groups: names.light_groups,
        camera_axes: view.map_or([0; 9], |view| view.camera.axes().map(f32::to_bits)),
        matrices: view.map_or([[0; 16]; 2], |view| {
            let camera = &view.camera;
            let matrices = [camera.right_up_forward_from_world(), camera.film_from_world()];
            matrices.map(|matrix| matrix.to_cols_array().map(f32::to_bits))
        }),
        storage: [
            storage.pixels.map(|format| format.name().to_owned()),
            storage.components.map(|format| format.name().to_owned()),
            storage.compression.map(|compression| compression.name().to_owned()),
        ],
    }
}
