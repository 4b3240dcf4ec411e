//! The texture the picture is shown with: one for ever, resized in place, written only where tiles arrived or when it is to be shown
//! differently.

use bevy::asset::RenderAssetUsages;
use bevy::image::ImageSampler;
use bevy::prelude::*;
use bevy::render::render_resource::{Extent3d, TextureDimension, TextureFormat};
use bevy_egui::{EguiTextureHandle, EguiUserTextures, egui};

use super::denoiser::Denoiser;
use super::display::{self, DisplayMode, DisplaySettings};
use super::state::EditorState;
use crate::engine::RenderFilm;
use crate::render::tile::tiles;

#[derive(Resource)]
pub struct Picture {
    handle: Handle<Image>,
    texture: egui::TextureId,
    /// Pixels; (0, 0) before the first.
    size: UVec2,
    shown: Option<Shown>,
    /// The film's job when the texture was last written.
    job: u64,
    /// Counts changes of pixels.
    pub revision: u64,
}

/// What the texture's pixels were made with.
#[derive(Clone, Copy, PartialEq)]
struct Shown {
    display: DisplaySettings,
    denoised: Option<u64>,
    scene_size: f32,
}

impl Picture {
    /// The texture and its size, once there is a picture.
    pub fn texture(&self) -> Option<(egui::TextureId, [u32; 2])> {
        (self.size != UVec2::ZERO).then_some((self.texture, self.size.to_array()))
    }
}

pub fn create_picture(
    mut commands: Commands,
    mut images: ResMut<Assets<Image>>,
    mut textures: ResMut<EguiUserTextures>,
) {
    let mut image = Image::new_fill(
        extent(UVec2::ONE),
        TextureDimension::D2,
        &[0, 0, 0, 255],
        TextureFormat::Rgba8UnormSrgb,
        RenderAssetUsages::all(),
    );
    image.sampler = ImageSampler::linear();
    let handle = images.add(image);
    commands.insert_resource(Picture {
        texture: textures.add_image(EguiTextureHandle::Strong(handle.clone())),
        handle,
        size: UVec2::ZERO,
        shown: None,
        job: 0,
        revision: 0,
    });
}

/// Brings the texture up to date with the film.
pub fn update_picture(
    mut film: ResMut<RenderFilm>,
    mut picture: ResMut<Picture>,
    mut images: ResMut<Assets<Image>>,
    mut changes: MessageWriter<AssetEvent<Image>>,
    state: Res<EditorState>,
    denoiser: Res<Denoiser>,
) {
    let size = UVec2::new(film.film.width(), film.film.height());
    if size.x == 0 || size.y == 0 {
        return;
    }
    let mut settings = state.display;
    if let Some(shown) = picture.shown.filter(|_| picture.job == film.job) {
        settings.mode = readable_mode(shown.display.mode, settings.mode);
    }
    let denoised = (settings.mode == DisplayMode::Shaded)
        .then(|| denoiser.picture())
        .flatten();
    let shown = Shown {
        display: settings,
        denoised: denoised.map(|picture| picture.number),
        scene_size: state.navigation.scene_size,
    };
    let anew = picture.shown != Some(shown) || picture.size != size;
    if !film.has_dirty() && !anew {
        return;
    }
    let changed = film.bypass_change_detection().take_dirty();
    let dirty = if anew { tiles(size.x, size.y) } else { changed };
    if denoised.is_some() && !anew {
        return;
    }
    let old_size = picture.size;
    // Bevy has told of this frame's changes already; ours is told by hand so that the screen does not see it a frame late.
    let Some(image) = images.get_mut_untracked(&picture.handle) else {
        return;
    };
    let mut pixels = image.data.take().unwrap_or_default();
    if old_size != size {
        pixels = display::resized(&pixels, old_size.to_array(), size.to_array());
        image.texture_descriptor.size = extent(size);
    }
    match denoised {
        Some(picture) => display::paint_radiance(&picture.radiance, &settings, &mut pixels),
        None => display::paint(&film.film, &dirty, &settings, shown.scene_size, &mut pixels),
    }
    image.data = Some(pixels);
    changes.write(AssetEvent::Modified {
        id: picture.handle.id(),
    });
    picture.size = size;
    picture.shown = Some(shown);
    picture.job = film.job;
    picture.revision += 1;
}

/// The mode that a film can be shown in that has been shown as `shown`: steps are counted into a film of their own, and until that is
/// begun the old one must not be taken for it.
fn readable_mode(shown: DisplayMode, wanted: DisplayMode) -> DisplayMode {
    let counts_steps = |mode| mode == DisplayMode::BvhSteps;
    if counts_steps(shown) == counts_steps(wanted) {
        wanted
    } else {
        shown
    }
}

fn extent(size: UVec2) -> Extent3d {
    Extent3d {
        width: size.x,
        height: size.y,
        depth_or_array_layers: 1,
    }
}
