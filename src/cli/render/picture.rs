//! A picture to be rendered: its settings and its outputs.

use std::path::{Path, PathBuf};

use bevy::prelude::*;
use sunroom::engine::{Limits, RenderStatus, active_film, describe_picture};
use sunroom::render::image_io::FileOptions;
use sunroom::render::layered_image::LayeredImage;

use super::args::RenderArgs;
use crate::cli::outputs;
use crate::cli::share::{Settings, Share};
use crate::cli::stats::StatsFormat;

/// A picture of the scene at its present time.
pub struct Picture<'a> {
    pub args: &'a RenderArgs,
    pub outputs: &'a [PathBuf],
    pub limits: &'a Limits,
    pub load_ms: f64,
    /// The settings on which samples depend, apart from the scene and the view.
    pub settings: Settings,
}

impl Picture<'_> {
    /// Writes the picture, or its rendered part, to files. Returns those that were written.
    pub fn write<'o>(
        &self,
        share: Option<&Share>,
        world: &World,
        picture: &LayeredImage,
        files: &'o [PathBuf],
    ) -> Vec<&'o Path> {
        let options = file_options(world, self.args);
        match share.filter(|share| share.is_part) {
            Some(share) => {
                let part = share.piece.cut(picture.clone());
                outputs::write_each(files, |path| share.piece.write(world, path, &part, &options))
            }
            None => outputs::write_each(files, |path| outputs::write_picture(path, picture, &options)),
        }
    }

    /// Whether events are printed.
    pub fn has_events(&self) -> bool {
        self.args.stats == Some(StatsFormat::JsonLines)
    }

    /// Sets the attributes about the origin of the picture.
    pub fn describe(&self, picture: &mut LayeredImage, world: &World) {
        let seconds = self.args.time.map(|_| world.resource::<RenderStatus>().seconds);
        describe_picture(picture, world, Some(&self.args.scene.scene), seconds);
    }
}

/// The file options of the outputs.
pub fn file_options(world: &World, args: &RenderArgs) -> FileOptions {
    let storage = active_film(world).map(|film| film.storage).unwrap_or_default();
    args.file.options(args.display.display(), storage)
}
