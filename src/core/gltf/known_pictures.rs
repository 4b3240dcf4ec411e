//! The pictures that materials of a file have asked for. Each is made once.

use glam::Vec3;

use super::GltfError;
use super::picture::{KnownPicture, Picture};
use super::scene::Builder;

impl Builder<'_> {
    /// The name of the picture's file; None (reported) if the picture cannot be read.
    pub fn reference_picture(&mut self, picture: Picture) -> Option<String> {
        let key = format!("{picture:?}");
        if let Some(known) = self.pictures.get(&key) {
            return known.name.clone();
        }
        let name = match self.references.picture(self.pictures.len(), &picture) {
            Ok(name) => Some(name),
            Err(error @ GltfError::Keep { .. }) => {
                self.failure.get_or_insert(error);
                None
            }
            Err(error) => {
                let image = self.gltf.root.images.get(picture.image);
                let title = match image.and_then(|image| image.name.as_deref()) {
                    Some(name) => format!("picture {} ({name})", picture.image),
                    None => format!("picture {}", picture.image),
                };
                self.warn(format!("{title} is left out: {error}"));
                None
            }
        };
        let known = KnownPicture {
            name: name.clone(),
            mean: None,
        };
        self.pictures.insert(key, known);
        name
    }

    /// The mean colour of a picture that has a file, linear.
    pub fn mean_of_picture(&mut self, picture: Picture) -> Vec3 {
        let known = self.pictures.get_mut(&format!("{picture:?}"));
        let mut mean = || self.references.mean(&picture).unwrap_or(Vec3::ONE);
        match known {
            Some(known) => *known.mean.get_or_insert_with(mean),
            None => mean(),
        }
    }
}
