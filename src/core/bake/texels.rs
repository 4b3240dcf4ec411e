//! The texels that surfaces cover, and the position of each in the world.
//!
//! A texel belongs to the triangle nearest to its centre, and its position is the point of the triangle nearest to
//! that. Every texel that a triangle touches is covered, so that filtering between texels never meets one without
//! light. Where vertex normals bend a surface, the position moves out to the curved surface that they stand for, as in
//! Hanika, Hacking the Shadow Terminator (Ray Tracing Gems II, chapter 4): rays from the flat triangle would start
//! inside.
//!
//! The samples of a texel are spread over the part of it that the surface covers, see [`super::spread`].

mod plane;

use std::ops::Range;
use std::sync::atomic::{AtomicBool, Ordering};

use glam::{UVec2, Vec2, Vec3};
use rayon::prelude::*;

use self::plane::{area, clamped, nearest_point, touched, weights};
use super::spread::{Corners, Spread};
use crate::render::irradiance::Receiver;

/// A surface on which light is gathered, in world space.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BakeSurface {
    /// The index of its lightmap.
    pub page: u32,
    /// The vertices.
    pub positions: Vec<Vec3>,
    /// Unit normals of the vertices, on the side on which light is gathered; zero at flat triangles, and empty if all
    /// are flat.
    pub normals: Vec<Vec3>,
    /// The positions of the vertices in the lightmap, in texels from its upper left corner. Charts are two or more
    /// texels apart.
    pub coordinates: Vec<Vec2>,
    /// The corners of the triangles, counter-clockwise as seen from the side on which light is gathered.
    pub triangles: Vec<[u32; 3]>,
}

/// A texel covered by a surface, or a texel of a probe.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Texel<S = Receiver> {
    /// The column and the row.
    pub place: UVec2,
    /// The point where light is gathered.
    pub receiver: S,
}

/// The texels of all lightmaps, or of a probe.
#[derive(Clone, Debug, PartialEq)]
pub struct Texels<S = Receiver> {
    /// Width and height of each lightmap.
    pub size: UVec2,
    /// The covered texels, page by page, and row by row within a page.
    pub texels: Vec<Texel<S>>,
    /// The range of each page in `texels`.
    pub pages: Vec<Range<usize>>,
    /// The area of the samples of each texel; empty if all are gathered at the receivers.
    pub spreads: Vec<Spread>,
}

/// Half the diagonal of a texel, and a little more.
const REACH: f32 = 0.7072;
/// How far, as a share of a texel, a point on the border of a triangle moves inwards, so that it is not inside a wall
/// that may stand there.
const INSET: f32 = 0.05;
/// How far below 0 a barycentric coordinate may be at a point that counts as on the triangle.
const ON_EDGE: f32 = 1e-4;
/// The largest distance of samples from their part of the surface, in sides of the texel.
const MOST_WAY: f32 = 0.1;
/// The rounding error of positions relative to the coordinates, which have gone through the transform of a node.
const ROUNDING: f32 = 32.0 * f32::EPSILON;

/// The triangle nearest to the centre of a texel so far.
#[derive(Clone, Copy)]
struct Nearest {
    distance: f32,
    /// The indices of the surface and of the triangle.
    number: [u32; 2],
    weights: Vec3,
}

/// Rows of a lightmap that a thread processes at once.
const BAND: u32 = 64;

/// Finds the texels that surfaces cover on `pages` pages of `size`. Parts outside of the pages, and triangles without
/// area in the lightmap or in the world, cover none. It ends soon after `cancel` is set, with some texels missing.
pub fn covered_texels(surfaces: &[BakeSurface], size: UVec2, pages: u32, cancel: &AtomicBool) -> Texels {
    let mut of_page: Vec<Vec<&BakeSurface>> = vec![Vec::new(); pages as usize];
    for surface in surfaces {
        if let Some(of_page) = of_page.get_mut(surface.page as usize) {
            of_page.push(surface);
        }
    }
    let bands = size.y.div_ceil(BAND);
    let in_bands: Vec<Vec<Vec<[u32; 2]>>> = of_page
        .par_iter()
        .map(|surfaces| triangles_in_bands(surfaces, size, cancel))
        .collect();
    let found: Vec<Vec<(Texel, Spread)>> = (0..pages * bands)
        .into_par_iter()
        .map(|number| {
            let (page, band) = ((number / bands) as usize, number % bands);
            let rows = band * BAND;
            Band {
                surfaces: &of_page[page],
                triangles: &in_bands[page][band as usize],
                first: UVec2::new(0, rows),
                end: UVec2::new(size.x, size.y.min(rows + BAND)),
                cancel,
            }
            .texels()
        })
        .collect();
    let mut all = Texels {
        size,
        texels: Vec::new(),
        pages: Vec::new(),
        spreads: Vec::new(),
    };
    let mut found = found.into_iter();
    for _ in 0..pages {
        let first = all.texels.len();
        for (texel, spread) in found.by_ref().take(bands as usize).flatten() {
            all.texels.push(texel);
            all.spreads.push(spread);
        }
        all.pages.push(first..all.texels.len());
    }
    all
}

/// For each band of rows, the indices of surface and triangle of the triangles with area in the lightmap that may touch
/// it, in order: of triangles equally near to a texel, the first gets it.
fn triangles_in_bands(surfaces: &[&BakeSurface], size: UVec2, cancel: &AtomicBool) -> Vec<Vec<[u32; 2]>> {
    let mut bands = vec![Vec::new(); size.y.div_ceil(BAND) as usize];
    for (index, surface) in (0..).zip(surfaces) {
        if cancel.load(Ordering::Relaxed) {
            break;
        }
        for (number, corners) in (0..).zip(&surface.triangles) {
            let at = corners.map(|corner| surface.coordinates[corner as usize]);
            let [first, end] = touched(at, [UVec2::ZERO, size]);
            if area(at).abs() > 0.0 && first.cmplt(end).all() {
                let rows = (first.y / BAND) as usize..=((end.y - 1) / BAND) as usize;
                bands[rows].iter_mut().for_each(|band| band.push([index, number]));
            }
        }
    }
    bands
}

/// A band of rows of a lightmap. Its texels do not depend on the other rows.
struct Band<'a> {
    /// The surfaces of the lightmap.
    surfaces: &'a [&'a BakeSurface],
    /// The indices of surface and triangle of the triangles that may touch the rows.
    triangles: &'a [[u32; 2]],
    /// The first texel, and the end of the texels.
    first: UVec2,
    end: UVec2,
    cancel: &'a AtomicBool,
}

/// A triangle that may cover texels.
struct Triangle<'a> {
    surface: &'a BakeSurface,
    /// The indices of the surface and of the triangle.
    number: [u32; 2],
    /// The corners in the lightmap.
    at: [Vec2; 3],
    /// The geometric unit normal in the world.
    up: Vec3,
    /// The first texel that it may touch, and the end of these texels.
    touched: [UVec2; 2],
}

impl Triangle<'_> {
    /// The texels that it may touch.
    fn places(&self) -> impl Iterator<Item = UVec2> + use<> {
        let [first, end] = self.touched;
        (first.y..end.y).flat_map(move |y| (first.x..end.x).map(move |x| UVec2::new(x, y)))
    }
}

impl<'a> Band<'a> {
    /// The triangles with area in the world; some are missing if the work is cancelled.
    fn triangles(&self) -> impl Iterator<Item = Triangle<'a>> {
        let (surfaces, rows, cancel) = (self.surfaces, [self.first, self.end], self.cancel);
        let numbers = self.triangles.iter().take_while(|_| !cancel.load(Ordering::Relaxed));
        numbers.filter_map(move |&number| {
            let surface = surfaces[number[0] as usize];
            let corners = surface.triangles[number[1] as usize];
            let at = corners.map(|corner| surface.coordinates[corner as usize]);
            let up = normal(corners.map(|corner| surface.positions[corner as usize]));
            (up != Vec3::ZERO).then_some(Triangle {
                surface,
                number,
                at,
                up,
                touched: touched(at, rows),
            })
        })
    }

    fn index_of(&self, place: UVec2) -> usize {
        (place.y - self.first.y) as usize * self.end.x as usize + place.x as usize
    }

    /// The covered texels, row by row, with the areas of their samples.
    fn texels(&self) -> Vec<(Texel, Spread)> {
        let extent = self.end - self.first;
        let mut nearest: Vec<Option<Nearest>> = vec![None; extent.x as usize * extent.y as usize];
        for triangle in self.triangles() {
            cover(&triangle, |place, distance, weights| {
                let old = &mut nearest[self.index_of(place)];
                if old.is_none_or(|old| distance < old.distance) {
                    *old = Some(Nearest {
                        distance,
                        number: triangle.number,
                        weights,
                    });
                }
            });
        }
        let mut found = Vec::new();
        // For each texel of the band its index in `found`.
        let mut number_of = vec![u32::MAX; nearest.len()];
        for (index, nearest) in nearest.iter().enumerate() {
            let Some(Nearest { number, weights, .. }) = *nearest else {
                continue;
            };
            let [surface, triangle] = number.map(|number| number as usize);
            let surface = self.surfaces[surface];
            let texel = Texel {
                place: self.first + UVec2::new(index as u32 % extent.x, index as u32 / extent.x),
                receiver: receiver(surface, triangle, weights),
            };
            number_of[index] = found.len() as u32;
            found.push((texel, spread(surface, triangle, weights, &texel)));
        }
        self.spread_out(&mut found, &number_of, &nearest);
        found
    }

    /// Finds the cells of the texels that lie on the surfaces.
    fn spread_out(&self, found: &mut [(Texel, Spread)], number_of: &[u32], nearest: &[Option<Nearest>]) {
        let mut corners = vec![Corners::default(); found.len()];
        for triangle in self.triangles() {
            let Triangle { surface, at, up, .. } = triangle;
            for place in triangle.places() {
                let index = self.index_of(place);
                let number = number_of[index] as usize;
                let Some(of_texel) = corners.get_mut(number).filter(|corners| !corners.are_all()) else {
                    continue;
                };
                let (texel, spread) = &found[number];
                let is_own = nearest[index].is_some_and(|own| own.number == triangle.number);
                let is_exact = is_own && surface.normals.is_empty();
                let square = place.as_vec2();
                let is_inside = |part: Vec2| weights(at, square + part).min_element() >= -ON_EDGE;
                if is_exact && [Vec2::ZERO, Vec2::X, Vec2::Y, Vec2::ONE].into_iter().all(is_inside) {
                    *of_texel = Corners::ALL;
                    continue;
                }
                for (corner, part) in Corners::all() {
                    let weights = weights(at, square + part);
                    if weights.min_element() < -ON_EDGE {
                        continue;
                    }
                    let place = spread.at(part);
                    let is_near = || {
                        // Rays from below the surface would start inside.
                        let bent = receiver(surface, triangle.number[1] as usize, weights).position;
                        let is_above = (place - bent).dot(up) >= -0.5 * texel.receiver.error;
                        is_above && place.distance(bent) <= MOST_WAY * spread.side()
                    };
                    if is_exact || is_near() {
                        of_texel.add(corner);
                    }
                }
            }
        }
        for ((_, spread), corners) in found.iter_mut().zip(corners) {
            spread.take(corners);
        }
    }
}

/// The area of the samples of a texel, still without cells: on the tangent plane at the texel's position, which is that
/// of its nearest triangle or of a curved surface.
fn spread(surface: &BakeSurface, triangle: usize, weights: Vec3, texel: &Texel) -> Spread {
    let weights = clamped(weights);
    let corners = surface.triangles[triangle].map(|corner| corner as usize);
    let [a, b, c] = corners.map(|corner| surface.coordinates[corner]);
    let in_world = corners.map(|corner| surface.positions[corner]);
    let (edges, whole) = ([b - a, c - a], area([a, b, c]));
    let edges_in_world = [in_world[1] - in_world[0], in_world[2] - in_world[0]];
    let mut along = [
        (edges_in_world[0] * edges[1].y - edges_in_world[1] * edges[0].y) / whole,
        (edges_in_world[1] * edges[0].x - edges_in_world[0] * edges[1].x) / whole,
    ];
    if !surface.normals.is_empty() {
        // The plane is tangent to the curved surface: one through the triangle would be inside.
        let (up, normal) = (texel.receiver.geometric_normal, texel.receiver.normal);
        along = along.map(|way| way - up * (way.dot(normal) / up.dot(normal).max(0.5)));
    }
    let way = texel.place.as_vec2() - (a * weights.x + b * weights.y + c * weights.z);
    Spread::new(texel.receiver.position + along[0] * way.x + along[1] * way.y, along)
}

/// The unit normal of a triangle; zero if it has no area.
fn normal([a, b, c]: [Vec3; 3]) -> Vec3 {
    (b - a)
        .as_dvec3()
        .cross((c - a).as_dvec3())
        .normalize_or_zero()
        .as_vec3()
}

/// Calls `found` for each texel that the triangle touches, with the distance of its centre from the triangle and the
/// barycentric coordinates of the nearest point.
fn cover(triangle: &Triangle, mut found: impl FnMut(UVec2, f32, Vec3)) {
    let corners = triangle.at;
    let middle = (corners[0] + corners[1] + corners[2]) / 3.0;
    for place in triangle.places() {
        let centre = place.as_vec2() + 0.5;
        let nearest = nearest_point(corners, centre);
        let distance = nearest.distance(centre);
        if distance > REACH {
            continue;
        }
        let inside = match distance > 0.0 {
            true => nearest + (middle - nearest).clamp_length_max(INSET),
            false => nearest,
        };
        found(place, distance, weights(corners, inside));
    }
}

/// The point of a texel where light is gathered, in the world.
fn receiver(surface: &BakeSurface, triangle: usize, weights: Vec3) -> Receiver {
    let weights = clamped(weights);
    let corners = surface.triangles[triangle].map(|corner| corner as usize);
    let in_world = corners.map(|corner| surface.positions[corner]);
    let mix = |of: [Vec3; 3]| of[0] * weights.x + of[1] * weights.y + of[2] * weights.z;
    let flat = mix(in_world);
    let geometric_normal = normal(in_world);
    let extent = in_world
        .into_iter()
        .fold(Vec3::ZERO, |extent, place| extent.max(place.abs()));
    let mut receiver = Receiver {
        position: flat,
        error: ROUNDING * extent.max_element(),
        normal: geometric_normal,
        geometric_normal,
    };
    if !surface.normals.is_empty() {
        let normals = corners.map(|corner| surface.normals[corner]);
        // Zero normals have no mean, and do not move the point.
        receiver.normal = mix(normals).try_normalize().unwrap_or(geometric_normal);
        let [a, b, c] =
            [0, 1, 2].map(|corner| (in_world[corner] - flat).dot(normals[corner]).max(0.0) * normals[corner]);
        receiver.position += mix([a, b, c]);
    }
    receiver
}

#[cfg(test)]
mod tests {
    use super::*;

    fn covered_texels(surfaces: &[BakeSurface], size: UVec2, pages: u32) -> Texels {
        super::covered_texels(surfaces, size, pages, &AtomicBool::new(false))
    }

    fn square(low: f32, high: f32) -> BakeSurface {
        let corners = [(low, low), (high, low), (high, high), (low, high)];
        BakeSurface {
            positions: corners.map(|(x, y)| Vec3::new(x, y, 0.0)).to_vec(),
            coordinates: corners.map(|(x, y)| Vec2::new(x, y)).to_vec(),
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            ..BakeSurface::default()
        }
    }

    #[test]
    fn whole_texels_have_their_centres_and_touched_ones_are_covered() {
        let texels = covered_texels(&[square(2.0, 5.5)], UVec2::splat(8), 1);
        for texel in &texels.texels {
            let centre = texel.place.as_vec2() + 0.5;
            let place = texel.receiver.position;
            let expected = centre.clamp(Vec2::splat(2.0), Vec2::splat(5.5));
            assert!(place.truncate().distance(expected) <= INSET + 1e-5, "{texel:?}");
            assert_eq!(texel.receiver.normal, Vec3::Z);
            assert!(
                place.truncate().cmpgt(Vec2::splat(2.0)).all() || centre.min_element() < 2.0,
                "{texel:?}"
            );
        }
        for y in 2..6 {
            for x in 2..6 {
                let place = UVec2::new(x, y);
                assert!(texels.texels.iter().any(|texel| texel.place == place), "{place}");
            }
        }
        assert!(
            texels
                .texels
                .iter()
                .all(|texel| texel.place.min_element() >= 1 && texel.place.max_element() <= 6)
        );
    }

    #[test]
    fn a_triangle_smaller_than_a_texel_covers_one() {
        let texels = covered_texels(&[square(3.1, 3.2)], UVec2::splat(8), 1);
        assert!(texels.texels.iter().any(|texel| texel.place == UVec2::splat(3)));
        assert!(
            texels
                .texels
                .iter()
                .all(|texel| (texel.receiver.position.x - 3.15).abs() < 0.06)
        );
    }

    #[test]
    fn what_has_no_area_covers_nothing() {
        let mut flat = square(1.0, 5.0);
        flat.positions = vec![Vec3::ONE; 4];
        let mut thin = square(1.0, 5.0);
        thin.coordinates = vec![Vec2::splat(2.0); 4];
        let mut outside = square(20.0, 25.0);
        outside.coordinates[0] = Vec2::new(-1e30, -1e30);
        let mut broken = square(1.0, 5.0);
        broken.coordinates[1] = Vec2::NAN;
        broken.coordinates[3] = Vec2::INFINITY;
        let texels = covered_texels(&[flat, thin, broken], UVec2::splat(8), 2);
        assert_eq!((texels.texels.len(), texels.pages.len()), (0, 2));
        // It terminates for any coordinates.
        covered_texels(&[outside], UVec2::splat(8), 1);
    }

    #[test]
    fn bent_surfaces_move_out() {
        let mut ball = square(1.0, 5.0);
        let centre = Vec3::new(3.0, 3.0, -3.0);
        ball.normals = ball
            .positions
            .iter()
            .map(|place| (*place - centre).normalize())
            .collect();
        let radius = ball.positions[0].distance(centre);
        for texel in covered_texels(&[ball], UVec2::splat(8), 1).texels {
            let distance = texel.receiver.position.distance(centre);
            assert!(distance > 0.999 * radius && distance < 1.35 * radius, "{texel:?}");
            assert!(texel.receiver.normal.angle_between(texel.receiver.position - centre) < 0.1);
        }
    }

    #[test]
    fn a_search_that_is_cancelled_ends() {
        let found = super::covered_texels(&[square(0.0, 16384.0)], UVec2::splat(16384), 1, &AtomicBool::new(true));
        assert!(found.texels.is_empty() && found.pages.len() == 1);
    }

    #[test]
    fn texels_do_not_depend_on_the_rows_that_are_searched_together() {
        let mut ball = square(1.0, 9.0);
        let centre = Vec3::new(5.0, 5.0, -9.0);
        ball.normals = ball
            .positions
            .iter()
            .map(|place| (*place - centre).normalize())
            .collect();
        let below = |rows: u32| {
            let mut moved = ball.clone();
            moved.coordinates.iter_mut().for_each(|place| place.y += rows as f32);
            covered_texels(&[moved], UVec2::splat(2 * BAND), 1)
        };
        let first = below(0);
        // The border between the rows is in the middle of the square.
        let second = below(BAND - 5);
        assert_eq!(first.texels.len(), second.texels.len());
        assert!(first.texels.len() >= 64);
        for (one, other) in first.texels.iter().zip(&second.texels) {
            assert_eq!(one.place + UVec2::new(0, BAND - 5), other.place);
            assert!(one.receiver.position.distance(other.receiver.position) < 1e-5);
        }
        for (one, other) in first.spreads.iter().zip(&second.spreads) {
            for u in [Vec2::ZERO, Vec2::splat(0.4), Vec2::splat(0.9)] {
                let places = [one, other].map(|spread| spread.place(u));
                let are_alike = match places {
                    [Some(one), Some(other)] => one.distance(other) < 1e-4,
                    [one, other] => one == other,
                };
                assert!(are_alike, "{places:?}");
            }
        }
    }
}
