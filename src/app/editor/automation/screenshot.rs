//! Pictures of the whole window.

use bevy::prelude::*;

use crate::app::editor::picture::pacing::Pacing;
use crate::app::editor::window::preview::Previews;
use crate::files::write_atomically;

/// Whether all that belongs into a picture of the window is in it: previews of materials come last.
pub(crate) fn window_is_complete(pacing: &Pacing, previews: &Previews) -> bool {
    pacing.rests() && previews.are_done()
}

/// A captured window as PNG.
pub(crate) fn save_window(image: &Image, path: &std::path::Path) -> Result<(), Box<dyn std::error::Error>> {
    let picture = image.clone().try_into_dynamic()?;
    let mut png = std::io::Cursor::new(Vec::new());
    picture.to_rgb8().write_to(&mut png, image::ImageFormat::Png)?;
    Ok(write_atomically(path, png.into_inner())?)
}
