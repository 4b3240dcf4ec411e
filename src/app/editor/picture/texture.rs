//! The texture that shows the picture. There is only one, which is resized in place, and written only where tiles
//! arrived or when its display changes.

use bevy::asset::RenderAssetUsages;
use bevy::image::{ImageFilterMode, ImageSampler, ImageSamplerDescriptor};
use bevy::prelude::*;
use bevy::render::render_resource::{Extent3d, TextureDimension, TextureFormat};
use bevy_egui::{EguiTextureHandle, EguiUserTextures, egui};

use super::carrying::Carrying;
use super::compare::{Comparison, PixelComparison};
use super::denoised::Denoised;
use super::denoiser::Denoiser;
use super::painter::{Painter, Scales};
use super::reframing::reframed_rgba;
use crate::app::editor::command::compare_view::CompareView;
use crate::app::editor::command::display::{DisplayMode, DisplaySettings};
use crate::app::editor::command::light_mix::{FilmLights, LightMix};
use crate::app::editor::command::resolution::Enlarging;
use crate::app::editor::session::view_settings::ViewSettings;
use crate::color::Rgb;
use crate::engine::{PackedScene, RenderFilm, fit};
use crate::render::tile::tiles;
use crate::render::view::View;

/// The largest side of a texture that every driver of WebGPU supports, in pixels.
const LARGEST_TEXTURE: u32 = 8192;

#[derive(Resource)]
pub struct Picture {
    handle: Handle<Image>,
    texture: egui::TextureId,
    /// The size of the picture in pixels; (0, 0) before the first.
    size: UVec2,
    /// The corners of the film in the picture's coordinates.
    film_corners: [Vec2; 2],
    /// The colours of a picture that is too large for a texture, which shows a smaller copy; else empty.
    too_large: Vec<u8>,
    shown: Option<Shown>,
    /// The comparison that the pixels show.
    compared: CompareView,
    scales: Scales,
    /// The film's job when the texture was last written.
    job: u64,
    /// Counts changes of pixels.
    pub revision: u64,
}

/// The inputs of the texture's pixels.
#[derive(Clone, PartialEq)]
struct Shown {
    display: DisplaySettings,
    enlarging: Enlarging,
    denoised: Option<u64>,
    /// The factors on the layers of the film.
    mix: Vec<Rgb>,
    /// The comparison, with the number of the snapshot.
    comparison: Option<(CompareView, u64)>,
}

impl Picture {
    /// The texture and its size, once there is a picture.
    pub fn texture(&self) -> Option<(egui::TextureId, [u32; 2])> {
        (self.size != UVec2::ZERO).then_some((self.texture, self.size.to_array()))
    }

    /// The corners of the film in the picture.
    pub fn film_corners(&self) -> [Vec2; 2] {
        self.film_corners
    }

    /// The displayed pixels, four sRGB-encoded bytes each, and their number along both sides. None if there is no
    /// picture, or if it is too large for a texture.
    pub(crate) fn pixels<'a>(&self, images: &'a Assets<Image>) -> Option<(UVec2, &'a [u8])> {
        let is_whole = self.size != UVec2::ZERO && texture_size(self.size) == self.size;
        let image = images.get(&self.handle).filter(|_| is_whole)?;
        Some((self.size, image.data.as_deref()?))
    }

    /// Drops the picture.
    fn clear(&mut self) {
        if self.size != UVec2::ZERO {
            (self.size, self.shown, self.compared) = (UVec2::ZERO, None, CompareView::Off);
            (self.too_large, self.scales) = (Vec::new(), Scales::default());
            self.revision += 1;
        }
    }

    /// The number of the displayed denoised picture; None if pixels are as sampled.
    pub(crate) fn denoised(&self) -> Option<u64> {
        self.shown.as_ref()?.denoised
    }

    /// The displayed comparison, which may be none though one is requested.
    pub(crate) fn compared(&self) -> CompareView {
        self.compared
    }

    /// The scales of the texture's colours.
    pub fn scales(&self) -> &Scales {
        &self.scales
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
    image.sampler = sampler(Enlarging::default());
    let handle = images.add(image);
    commands.insert_resource(Picture {
        texture: textures.add_image(EguiTextureHandle::Strong(handle.clone())),
        handle,
        size: UVec2::ZERO,
        film_corners: View::WHOLE_FILM,
        too_large: Vec::new(),
        shown: None,
        compared: CompareView::Off,
        scales: Scales::default(),
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
    view: Res<ViewSettings>,
    denoiser: Res<Denoiser>,
    mix: Res<LightMix>,
    lights: Res<FilmLights>,
    comparison: Res<Comparison>,
    packed: Res<PackedScene>,
    mut carrying: ResMut<Carrying>,
) {
    let size = UVec2::new(film.film.width(), film.film.height());
    if size.x == 0 || size.y == 0 {
        picture.clear();
        return;
    }
    let mut settings = view.display;
    if let Some(shown) = picture.shown.as_ref().filter(|_| picture.job == film.job) {
        settings.mode = readable_mode(shown.display.mode, settings.mode);
    }
    let mix = mix.factors(&film.light_groups, &lights);
    let is_shaded = settings.mode == DisplayMode::Shaded;
    let is_of_film =
        |picture: &&Denoised| picture.mix == mix && picture.radiance.len() == size.element_product() as usize;
    let denoised = denoiser.picture().filter(|_| is_shaded).filter(is_of_film);
    let camera = packed.view.as_ref().map(View::of_film);
    let snapshot = comparison.other(camera.as_ref()).filter(|_| is_shaded);
    let noisy_left = match comparison.view {
        CompareView::Noisy(share) => denoised.map(|denoised| (share, denoised)),
        _ => None,
    };
    let shown = Shown {
        display: settings,
        enlarging: view.enlarging,
        denoised: denoised.map(|picture| picture.number),
        mix,
        comparison: (snapshot.is_some() || noisy_left.is_some()).then_some((comparison.view, comparison.revision)),
    };
    let carrying = carrying.bypass_change_detection();
    let has_ended = carrying.take_end();
    let shows_other = picture.denoised() != shown.denoised;
    if carrying.take_unchanged() && denoised.is_none() {
        // Parts of the denoised picture are carried over, so that it counts as not shown.
        picture.shown.iter_mut().for_each(|shown| shown.denoised = None);
    }
    let film_corners = film.view.as_ref().map_or(View::WHOLE_FILM, View::film_corners);
    let is_reframed = (picture.size, picture.film_corners) != (size, film_corners);
    let asked_anew = has_ended || picture.shown.as_ref() != Some(&shown) || is_reframed;
    if !film.has_dirty() && !asked_anew {
        return;
    }
    let scales = Scales::of(&film.film, settings.mode, shown.mix.clone(), &picture.scales);
    let anew = asked_anew || scales != picture.scales;
    let changed = film.bypass_change_detection().take_dirty();
    carrying.learn(&film, &changed);
    let dirty = if anew { tiles(size.x, size.y) } else { changed };
    if denoised.is_some() && noisy_left.is_none() && !anew {
        return;
    }
    let old_size = picture.size;
    // Bevy has collected this frame's changes already. The texture's is sent by hand, so that the screen does not show
    // it a frame late.
    let Some(image) = images.get_mut_untracked(&picture.handle) else {
        return;
    };
    let mut pixels = match texture_size(old_size) == old_size {
        // The new texture still has the content of an earlier picture.
        _ if old_size == UVec2::ZERO => Vec::new(),
        true => image.data.take().unwrap_or_default(),
        false => std::mem::take(&mut picture.too_large),
    };
    if is_reframed {
        let (old, new) = ((old_size, picture.film_corners), (size, film_corners));
        pixels = reframed_rgba(&pixels, old, new);
    }
    let compared =
        snapshot.and_then(|snapshot| PixelComparison::new(comparison.view, snapshot, size.to_array(), film_corners));
    let beside_noisy =
        noisy_left.map(|(share, denoised)| PixelComparison::with_clean(share, &denoised.radiance, size.to_array()));
    let compared = compared.or(beside_noisy);
    picture.compared = compared.as_ref().map_or(CompareView::Off, PixelComparison::view);
    if let Some(clean) = denoised.map(Denoised::clean).filter(|_| shows_other) {
        carrying.learn_clean(&film, clean);
    }
    let painter = Painter::new(&film.film, &settings, &scales)
        .denoised(denoised.filter(|_| noisy_left.is_none()).map(Denoised::clean))
        .compared(compared);
    let carried = carrying.picture_mut(&film).filter(|_| is_shaded);
    let is_carried = carried.is_some();
    let still_carried = painter.paint_carried(&dirty, &mut pixels, carried);
    if is_carried {
        carrying.note_painted(&dirty, still_carried);
    }
    image.sampler = sampler(view.enlarging);
    let shown_size = texture_size(size);
    image.texture_descriptor.size = extent(shown_size);
    image.data = Some(if shown_size == size {
        pixels
    } else {
        let whole = View::WHOLE_FILM;
        let smaller = reframed_rgba(&pixels, (size, whole), (shown_size, whole));
        picture.too_large = pixels;
        smaller
    });
    changes.write(AssetEvent::Modified {
        id: picture.handle.id(),
    });
    (picture.size, picture.film_corners) = (size, film_corners);
    picture.shown = Some(shown);
    picture.scales = scales;
    picture.job = film.job;
    picture.revision += 1;
}

/// The mode in which to show a film that was last shown as `shown`. Some modes have films of their own: until one is
/// begun, the old film must not be shown in such a mode.
fn readable_mode(shown: DisplayMode, wanted: DisplayMode) -> DisplayMode {
    if shown.with_own_film() == wanted.with_own_film() {
        wanted
    } else {
        shown
    }
}

/// The size of the texture that shows a picture.
fn texture_size(size: UVec2) -> UVec2 {
    if size.max_element() <= LARGEST_TEXTURE {
        size
    } else {
        fit(size, UVec2::splat(LARGEST_TEXTURE))
    }
}

/// The sampler; a picture larger than its panel is always filtered.
fn sampler(enlarging: Enlarging) -> ImageSampler {
    let mag_filter = match enlarging {
        Enlarging::Smooth => ImageFilterMode::Linear,
        Enlarging::Sharp => ImageFilterMode::Nearest,
    };
    ImageSampler::Descriptor(ImageSamplerDescriptor {
        mag_filter,
        ..ImageSamplerDescriptor::linear()
    })
}

fn extent(size: UVec2) -> Extent3d {
    Extent3d {
        width: size.x,
        height: size.y,
        depth_or_array_layers: 1,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_texture_is_no_larger_than_drivers_take() {
        for (size, expected) in [
            ((1, 1), (1, 1)),
            ((8192, 8192), (8192, 8192)),
            ((20_000, 3000), (8192, 1228)),
            ((3, 65_536), (1, 8192)),
        ] {
            assert_eq!(texture_size(size.into()), expected.into(), "{size:?}");
        }
    }
}
