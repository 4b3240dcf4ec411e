//! Brush strokes over a picture, and how much they cover of each pixel.

use std::ops::Range;

use glam::Vec2;

use super::wish::Wish;

/// A brush stroke: a disk that was moved along a path.
#[derive(Clone, Debug, PartialEq)]
pub struct Stroke {
    /// The light that it wants.
    pub wish: Wish,
    /// The corners of the path of its centre, from (0, 0) in the upper left of the picture to (1, 1) in the lower
    /// right.
    pub path: Vec<Vec2>,
    /// The radius in heights of the picture.
    pub radius: f32,
    /// The share of the radius that is covered fully, from 0 to 1. The rest fades out.
    pub hardness: f32,
}

/// How much a stroke covers of the pixels in a rectangle of the picture, from 0 to 1.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Coverage {
    /// The columns of the rectangle.
    pub columns: Range<u32>,
    /// The rows.
    pub rows: Range<u32>,
    /// The shares, row by row.
    pub shares: Vec<f32>,
}

impl Stroke {
    /// Whether all its numbers are in range.
    pub fn is_valid(&self) -> bool {
        let is_path = !self.path.is_empty() && self.path.iter().all(|place| place.is_finite());
        let is_brush = self.radius.is_finite() && self.radius > 0.0 && (0.0..=1.0).contains(&self.hardness);
        self.wish.is_valid() && is_path && is_brush
    }

    /// What it covers of a picture of this size in pixels. A stroke that is not [valid](Self::is_valid) covers nothing.
    pub fn coverage(&self, width: u32, height: u32) -> Coverage {
        if !self.is_valid() || width == 0 || height == 0 {
            return Coverage::default();
        }
        let size = Vec2::new(width as f32, height as f32);
        let radius = self.radius * size.y;
        let corners: Vec<Vec2> = self.path.iter().map(|&place| place * size).collect();
        let (least, most) = corners.iter().fold((corners[0], corners[0]), |(least, most), &corner| {
            (least.min(corner), most.max(corner))
        });
        let [columns, rows] = pixels_within(least - radius, most + radius, size);
        let mut distances = vec![f32::INFINITY; columns.len() * rows.len()];
        let last = *corners.last().unwrap_or(&corners[0]);
        let ends = corners.iter().skip(1).copied().chain([last]);
        for (&from, to) in corners.iter().zip(ends) {
            let [near_columns, near_rows] = pixels_within(from.min(to) - radius, from.max(to) + radius, size);
            for y in near_rows {
                let start = (y - rows.start) as usize * columns.len();
                for x in near_columns.clone() {
                    let distance = &mut distances[start + (x - columns.start) as usize];
                    *distance = distance.min(squared_distance(Vec2::new(x as f32, y as f32) + 0.5, from, to));
                }
            }
        }
        let share = |squared: f32| {
            let edge = (1.0 - squared.sqrt() / radius) / (1.0 - self.hardness).max(1e-3);
            let edge = edge.clamp(0.0, 1.0);
            edge * edge * (3.0 - 2.0 * edge)
        };
        Coverage {
            shares: distances.into_iter().map(share).collect(),
            columns,
            rows,
        }
    }
}

impl Coverage {
    /// The share of a pixel, 0 outside of the rectangle.
    pub fn share(&self, x: u32, y: u32) -> f32 {
        if !self.columns.contains(&x) || !self.rows.contains(&y) {
            return 0.0;
        }
        let row = (y - self.rows.start) as usize * self.columns.len();
        self.shares[row + (x - self.columns.start) as usize]
    }
}

/// The columns and rows of the pixels whose centres may be between two corners, within a picture of this size.
fn pixels_within(least: Vec2, most: Vec2, size: Vec2) -> [Range<u32>; 2] {
    let first = least.floor().clamp(Vec2::ZERO, size);
    let end = most.ceil().clamp(first, size);
    [first.x as u32..end.x as u32, first.y as u32..end.y as u32]
}

/// The squared distance of a place from a segment.
fn squared_distance(place: Vec2, from: Vec2, to: Vec2) -> f32 {
    let along = to - from;
    let length_squared = along.length_squared();
    let share = match length_squared > 0.0 {
        true => ((place - from).dot(along) / length_squared).clamp(0.0, 1.0),
        false => 0.0,
    };
    place.distance_squared(from + share * along)
}
