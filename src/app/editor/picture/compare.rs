//! Comparison of two pictures: the one being rendered and a snapshot, side by side, as a difference, and in numbers.

use std::borrow::Cow;
use std::sync::Arc;

use bevy::math::{UVec2, Vec2};
use bevy::prelude::Resource;

use super::reframing::reframed;
use crate::app::editor::command::compare_view::CompareView;
use crate::color::Rgb;
use crate::metrics::Errors;
use crate::render::camera::Camera;
use crate::render::visibility::sight::Sight;

/// A stored picture.
#[derive(Clone, Debug, PartialEq)]
pub struct Snapshot {
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// The corners of the film in the picture, see [`View::film_corners`](crate::render::view::View::film_corners).
    pub film_corners: [Vec2; 2],
    /// Linear colours, row by row.
    pub radiance: Vec<Rgb>,
    /// The samples per pixel.
    pub samples: u32,
}

impl Snapshot {
    /// The picture resampled to a size and frame, black where it has no pixels; None if its film has another aspect
    /// ratio.
    fn framed(&self, size: [u32; 2], film_corners: [Vec2; 2]) -> Option<Cow<'_, [Rgb]>> {
        if (size, film_corners) == (self.size, self.film_corners) {
            return Some(Cow::Borrowed(&self.radiance));
        }
        let film = |size: [u32; 2], [min, max]: [Vec2; 2]| (max - min) * UVec2::from(size).as_vec2();
        let (own, other) = (film(self.size, self.film_corners), film(size, film_corners));
        // The sides are equal but for rounding by half a pixel.
        let is_alike = (own.x * other.y - own.y * other.x).abs() <= own.x + own.y;
        if !is_alike || size.contains(&0) {
            return None;
        }
        let frame = |size: [u32; 2], corners| (UVec2::from(size), corners);
        let (own, other) = (frame(self.size, self.film_corners), frame(size, film_corners));
        Some(reframed(&self.radiance, own, other, Rgb::ZERO).into())
    }
}

/// A view of the baked level.
#[derive(Clone, Debug, PartialEq)]
pub struct Look {
    /// The camera.
    pub camera: Camera,
    /// The camera of the film, which may be a part of the picture.
    pub film_camera: Camera,
    /// The corners of the film in the picture.
    pub film_corners: [Vec2; 2],
    /// Width and height of the picture.
    pub size: [u32; 2],
    /// The visibility filters of the camera.
    pub sight: Sight,
    /// Whether lights are invisible to the camera.
    pub hides_emitters: bool,
}

/// The level lit by its lightmaps.
#[derive(Clone, Debug)]
pub struct LitPicture {
    /// The view of the level.
    pub look: Look,
    /// The picture. Its samples are those per texel.
    pub picture: Snapshot,
    /// Whether its lightmaps are finished.
    pub is_finished: bool,
}

/// The snapshot and its display.
#[derive(Resource, Clone, Debug, Default)]
pub struct Comparison {
    /// The snapshot; None until one is taken.
    pub snapshot: Option<Snapshot>,
    /// Whether the snapshot is of a scene that was open before.
    pub is_of_other_scene: bool,
    /// The comparison of picture and snapshot in the viewport.
    pub view: CompareView,
    /// The last measured differences.
    pub figures: Option<Measured>,
    /// The level lit by the lightmaps of the bake.
    pub baked: Option<Arc<LitPicture>>,
    /// Counts snapshots, and pictures of the lit level.
    pub revision: u64,
}

impl Comparison {
    /// Ends the comparison, because another scene was opened. The snapshot stays, marked as of the previous scene.
    pub fn leave_scene(&mut self) {
        (self.view, self.figures, self.is_of_other_scene) = (CompareView::Off, None, true);
        self.revision += 1;
    }

    /// The picture to compare with that of this camera of the film. None without a comparison, or while the lit level
    /// has not been rendered from there.
    pub fn other(&self, camera: Option<&Camera>) -> Option<&Snapshot> {
        match self.view {
            CompareView::Off | CompareView::Noisy(_) => None,
            CompareView::Wipe(_) | CompareView::Difference => self.snapshot.as_ref(),
            CompareView::Baked(_) => {
                let lit = self.baked.as_ref()?;
                (camera == Some(&lit.look.film_camera)).then_some(&lit.picture)
            }
        }
    }
}

/// The measured differences, with the job of the film.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measured {
    /// The differences.
    pub figures: Errors,
    /// The job of the film; figures of another job do not apply.
    pub job: u64,
    /// The samples per pixel at the measurement.
    pub samples: u32,
}

/// A comparison of pictures of equal size, pixel by pixel.
#[derive(Clone, Debug)]
pub(crate) struct PixelComparison<'a> {
    view: CompareView,
    /// The snapshot at the picture's size.
    kept: Cow<'a, [Rgb]>,
    width: u32,
    /// The first column of the picture, right of the snapshot; for a comparison with the denoised picture, the first
    /// column of the latter.
    border: u32,
}

fn border(share: f32, size: [u32; 2]) -> u32 {
    (share.clamp(0.0, 1.0) * size[0] as f32).round() as u32
}

impl<'a> PixelComparison<'a> {
    /// A comparison; None if nothing is compared, such as pictures of different aspect ratios. Each pixel of a picture
    /// of lower resolution is compared with the nearest one of the snapshot; the film is in the same place in both.
    pub fn new(view: CompareView, snapshot: &'a Snapshot, size: [u32; 2], film_corners: [Vec2; 2]) -> Option<Self> {
        let border = match view {
            CompareView::Off | CompareView::Noisy(_) => return None,
            CompareView::Wipe(share) | CompareView::Baked(share) => border(share, size),
            CompareView::Difference => 0,
        };
        Some(Self {
            view,
            kept: snapshot.framed(size, film_corners)?,
            width: size[0],
            border,
        })
    }

    /// Shows a noisy picture left of `share` of the width, and the denoised one of the same size right of it.
    pub fn with_clean(share: f32, clean: &'a [Rgb], size: [u32; 2]) -> Self {
        Self {
            view: CompareView::Noisy(share),
            kept: Cow::Borrowed(clean),
            width: size[0],
            border: border(share, size),
        }
    }

    /// The view of the comparison, with its border.
    pub fn view(&self) -> CompareView {
        self.view
    }

    /// The displayed colour at a column and row where the picture has the colour `now`.
    pub fn pixel(&self, x: u32, y: u32, now: Rgb) -> Rgb {
        let place = y as usize * self.width as usize + x as usize;
        let then = self.kept.get(place).copied().unwrap_or_default();
        match self.view {
            CompareView::Difference => (now - then).abs(),
            CompareView::Noisy(_) if x >= self.border => then,
            CompareView::Wipe(_) | CompareView::Baked(_) if x < self.border => then,
            _ => now,
        }
    }

    /// The displayed colours of a whole picture, row by row.
    pub fn picture(&self, now: &[Rgb]) -> Vec<Rgb> {
        let width = self.width.max(1);
        let places = (0..).map(|place| (place % width, place / width));
        now.iter()
            .zip(places)
            .map(|(&now, (x, y))| self.pixel(x, y, now))
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::view::View;

    fn snapshot() -> Snapshot {
        Snapshot {
            size: [4, 2],
            film_corners: View::WHOLE_FILM,
            radiance: vec![Rgb::ONE; 8],
            samples: 1,
        }
    }

    #[test]
    fn a_wipe_shows_the_snapshot_on_the_left() {
        let (now, snapshot) = ([Rgb::ZERO; 8], snapshot());
        let red = |share| {
            let comparison = PixelComparison::new(CompareView::Wipe(share), &snapshot, [4, 2], View::WHOLE_FILM)
                .expect("of one size");
            let seen = comparison.picture(&now);
            seen.iter().map(|rgb| rgb.x as u32).collect::<Vec<_>>()
        };
        assert_eq!(red(0.5), [1, 1, 0, 0, 1, 1, 0, 0]);
        assert_eq!((red(0.0), red(7.0)), (vec![0; 8], vec![1; 8]));
        // The picture has half the resolution.
        let coarse =
            PixelComparison::new(CompareView::Wipe(0.5), &snapshot, [2, 1], View::WHOLE_FILM).expect("of one shape");
        assert_eq!(coarse.picture(&now[..2]), [Rgb::ONE, Rgb::ZERO]);
        // A snapshot of another aspect ratio cannot be compared.
        assert!(PixelComparison::new(CompareView::Wipe(1.0), &snapshot, [2, 4], View::WHOLE_FILM).is_none());
        assert!(PixelComparison::new(CompareView::Off, &snapshot, [4, 2], View::WHOLE_FILM).is_none());
    }

    #[test]
    fn the_noisy_picture_is_left_of_the_clean_one() {
        let (noisy, clean) = ([Rgb::ZERO; 8], [Rgb::ONE; 8]);
        let red = |share| {
            let seen = PixelComparison::with_clean(share, &clean, [4, 2]).picture(&noisy);
            seen.iter().map(|rgb| rgb.x as u32).collect::<Vec<_>>()
        };
        assert_eq!(red(0.25), [0, 1, 1, 1, 0, 1, 1, 1]);
        assert_eq!((red(0.0), red(1.0)), (vec![1; 8], vec![0; 8]));
        // Without a denoised picture nothing is compared, whatever was kept.
        assert!(PixelComparison::new(CompareView::Noisy(0.5), &snapshot(), [4, 2], View::WHOLE_FILM).is_none());
    }

    #[test]
    fn a_difference_has_no_sign() {
        let snapshot = snapshot();
        let comparison =
            PixelComparison::new(CompareView::Difference, &snapshot, [4, 2], View::WHOLE_FILM).expect("of one size");
        let seen = comparison.picture(&[Rgb::new(0.25, 1.0, 3.0); 8]);
        assert_eq!(seen, [Rgb::new(0.75, 0.0, 2.0); 8]);
    }

    #[test]
    fn pictures_of_other_frames_are_compared_by_the_film() {
        let columns = [0.0, 1.0, 2.0, 3.0].map(Rgb::splat);
        // The film is the middle half of the snapshot.
        let wide = Snapshot {
            size: [4, 1],
            film_corners: [Vec2::new(0.25, 0.0), Vec2::new(0.75, 1.0)],
            radiance: columns.to_vec(),
            samples: 1,
        };
        let comparison = PixelComparison::new(CompareView::Wipe(1.0), &wide, [2, 1], View::WHOLE_FILM);
        let seen = comparison.expect("of one film").picture(&[Rgb::ZERO; 2]);
        assert_eq!(seen, [Rgb::ONE, Rgb::splat(2.0)]);
        let film = Snapshot {
            size: [2, 1],
            film_corners: View::WHOLE_FILM,
            radiance: vec![Rgb::ONE, Rgb::splat(2.0)],
            samples: 1,
        };
        let comparison = PixelComparison::new(CompareView::Wipe(1.0), &film, [4, 1], wide.film_corners);
        let seen = comparison.expect("of one film").picture(&[Rgb::splat(9.0); 4]);
        assert_eq!(seen, [Rgb::ZERO, Rgb::ONE, Rgb::splat(2.0), Rgb::ZERO]);
    }
}
