//! Resampling of pictures to another size and frame.

use bevy::math::{UVec2, Vec2};

/// The size of a picture in pixels, and the two opposite corners of the film in it: (0, 0) is the top left of the
/// picture, (1, 1) the bottom right.
pub(crate) type Frame = (UVec2, [Vec2; 2]);

/// The pixels of a picture of the frame `from`, row by row, in the frame `to`. A pixel has the colour of the nearest
/// one at its place of the film, and `outside` where there was none.
pub(crate) fn reframed<T: Copy>(pixels: &[T], from: Frame, to: Frame, outside: T) -> Vec<T> {
    let ((old, [old_min, old_max]), (new, [new_min, new_max])) = (from, to);
    let scale = (old_max - old_min) / (new_max - new_min);
    // The old column of each new one, and the old row.
    let sources = |axis: usize| -> Vec<Option<usize>> {
        let source = |pixel: u32| {
            let place = (pixel as f32 + 0.5) / new[axis] as f32;
            let old_place = old_min[axis] + (place - new_min[axis]) * scale[axis];
            let source = (old_place * old[axis] as f32).floor();
            (source >= 0.0 && source < old[axis] as f32).then_some(source as usize)
        };
        (0..new[axis]).map(source).collect()
    };
    let (columns, rows) = (sources(0), sources(1));
    let places = rows.iter().flat_map(|y| columns.iter().map(move |x| (*x).zip(*y)));
    let color = |place: Option<(usize, usize)>| {
        let known = place.and_then(|(x, y)| pixels.get(y * old.x as usize + x));
        known.copied().unwrap_or(outside)
    };
    places.map(color).collect()
}

/// The pixels of the film in a picture of the frame `from`, with their number along both sides: the surroundings of the
/// film have fewer samples.
pub(crate) fn of_film<T: Copy>(pixels: &[T], from: Frame) -> (UVec2, Vec<T>) {
    let (size, corners) = from;
    let [min, max] = corners.map(|corner| (corner * size.as_vec2()).round().as_uvec2().min(size));
    let rows = pixels.chunks_exact(size.x.max(1) as usize);
    let rows = rows.take(max.y as usize).skip(min.y as usize);
    let pixels = rows.flat_map(|row| &row[min.x as usize..max.x.max(min.x) as usize]);
    (max - min.min(max), pixels.copied().collect())
}

/// [`reframed`] for pixels of four bytes, which are opaque black where there was none.
pub(crate) fn reframed_rgba(rgba: &[u8], from: Frame, to: Frame) -> Vec<u8> {
    let (pixels, _) = rgba.as_chunks::<4>();
    reframed(pixels, from, to, [0, 0, 0, u8::MAX]).into_flattened()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::view::View;

    #[test]
    fn resizing_keeps_corners_and_is_opaque() {
        let quarters = [[1, 0, 0, 255], [2, 0, 0, 255], [3, 0, 0, 255], [4, 0, 0, 255]].concat();
        let whole = View::WHOLE_FILM;
        let (two, four) = (UVec2::splat(2), UVec2::splat(4));
        let large = reframed_rgba(&quarters, (two, whole), (four, whole));
        assert_eq!((large[0], large[4 * 3], large[4 * 12], large[4 * 15]), (1, 2, 3, 4));
        assert!(
            reframed_rgba(&[], (UVec2::ZERO, whole), (UVec2::new(2, 1), whole))
                .chunks(4)
                .all(|pixel| pixel == [0, 0, 0, 255])
        );
        // The new picture is twice as wide as the film, whose pixels stay.
        let middle = [Vec2::new(0.25, 0.0), Vec2::new(0.75, 1.0)];
        let wide = reframed_rgba(&quarters, (two, whole), (UVec2::new(4, 2), middle));
        let reds: Vec<u8> = wide.chunks(4).map(|pixel| pixel[0]).collect();
        assert_eq!(reds, [0, 1, 2, 0, 0, 3, 4, 0]);
        assert_eq!(reframed_rgba(&wide, (UVec2::new(4, 2), middle), (two, whole)), quarters);
    }
}
