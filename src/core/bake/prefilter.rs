//! Filters a cube map for surfaces of every roughness, as Bevy's `EnvironmentMapLight` expects it.
//!
//! The light reflected by a rough mirror is looked up in a mip level for each roughness (Karis, Real Shading in Unreal
//! Engine 4, 2013: the split sum): the mean over the directions of light, weighted by what a GGX microfacet surface
//! reflects from there to a viewer straight above it. Diffuse surfaces look up the mean weighted by the cosine,
//! irradiance divided by pi.
//!
//! The mean is a sum over the texels, without random numbers. Where the weight hardly changes, 4, 16, ... texels are
//! taken together, as Barnes and Hut take far bodies together.

use std::sync::atomic::Ordering;

use glam::{Mat3A, UVec2, Vec3};
use rayon::prelude::*;

use super::cube::{CubePicture, index, middles, places, windows};
use super::progress::{Pace, Work};
use super::texels::Texel;
use crate::color::Rgb;
use crate::render::probe_radiance::Window;

/// The allowed sizes of a cube map; each is a power of two.
pub const SIZES: std::ops::RangeInclusive<u32> = 16..=512;
/// The size of the mip level for the roughest surfaces, and of the cube map for diffuse ones.
const SMALLEST: u32 = 4;
const DIFFUSE: u32 = 16;
/// The largest width of texels taken together, as a share of the width over which the weight changes.
const FINENESS: f32 = 0.07;

/// Texels that are filtered by a thread in one go.
const SLICE: usize = 16;

/// A cube map for specular reflection, with a mip level for each roughness, and one for diffuse surfaces.
#[derive(Clone, Debug, PartialEq)]
pub struct Prefiltered {
    /// Radiance. Level k of n is for the perceptual roughness k / (n - 1), and half as wide as the level before.
    pub specular: Vec<CubePicture>,
    /// Irradiance divided by pi.
    pub diffuse: CubePicture,
}

/// A group of texels, made of four groups or texels of the level below.
#[derive(Clone, Copy, Default)]
struct Node {
    /// The mean direction in the world, of unit length.
    direction: Vec3,
    /// The largest distance of a texel from there, as a distance on the unit sphere.
    reach: f32,
    /// In steradians.
    solid_angle: f32,
    /// The sum of radiance times solid angle.
    light: Rgb,
}

/// Levels of nodes from the texels up to the faces.
struct Pyramid {
    levels: Vec<(u32, Vec<Node>)>,
}

/// Whether a cube map may have this size.
pub fn is_size(size: u32) -> bool {
    size.is_power_of_two() && SIZES.contains(&size)
}

/// Filters a cube map of radiance. `world_from_cube` stretches and rotates the cube: directions are looked up in the
/// space of the cube, but the angles of the filters are measured in the world. The size is one of [`SIZES`], a power of
/// two. None if the work was cancelled.
pub fn prefilter(picture: CubePicture, world_from_cube: &Mat3A, work: &mut Work) -> Option<Prefiltered> {
    let pyramid = Pyramid::new(&picture, world_from_cube);
    let levels = (picture.size / SMALLEST).ilog2();
    let rough = (1..=levels).map(|level| {
        let perceptual = level as f32 / levels as f32;
        (picture.size >> level, Some(perceptual * perceptual))
    });
    let wanted: Vec<(u32, Option<f32>)> = std::iter::once((DIFFUSE, None)).chain(rough).collect();
    let cost = |&(size, alpha): &(u32, Option<f32>)| f64::from(size * size) * nodes_of_mean(width_of(alpha));
    let whole: f64 = wanted.iter().map(cost).sum();
    let (mut before, mut filtered) = (0.0, Vec::new());
    for what in &wanted {
        let (size, alpha) = *what;
        let directions = middles(size);
        let mut texels: Vec<Rgb> = Vec::with_capacity(directions.len());
        let mut pace = Pace::new(work.pool.current_num_threads());
        while texels.len() < directions.len() {
            (work.watch)((before + cost(what) * texels.len() as f64 / directions.len() as f64) / whole);
            if work.cancel.load(Ordering::Relaxed) {
                return None;
            }
            let end = directions.len().min(texels.len() + pace.blocks() * SLICE);
            let slice = directions[texels.len()..end].par_iter();
            let means = slice.map(|direction| {
                let normal = (*world_from_cube * *direction).normalize();
                match alpha {
                    Some(alpha) => pyramid.mean(normal, width_of(Some(alpha)), |cosine| reflected(alpha, cosine)),
                    None => pyramid.mean(normal, width_of(None), |cosine| cosine),
                }
            });
            let more: Vec<Rgb> = pace.measure(|| work.pool.install(|| means.collect()));
            texels.extend(more);
        }
        filtered.push(CubePicture { size, texels });
        before += cost(what);
    }
    let diffuse = filtered.remove(0);
    filtered.insert(0, picture);
    Some(Prefiltered {
        specular: filtered,
        diffuse,
    })
}

/// The angle, in radians, over which the weight of a mirror with this `alpha` changes; None is a diffuse surface.
fn width_of(alpha: Option<f32>) -> f32 {
    alpha.map_or(0.5, |alpha| 2.0 * alpha)
}

/// The number of nodes that a mean visits, up to a constant factor: the integral of 1 / (width + distance)^2 over the
/// hemisphere, flattened.
fn nodes_of_mean(width: f32) -> f64 {
    let (width, farthest) = (f64::from(width), std::f64::consts::SQRT_2);
    ((width + farthest) / width).ln() - farthest / (width + farthest)
}

/// The share that a GGX surface reflects to a viewer straight above it, of light whose direction has this cosine to the
/// normal, times that cosine and up to a constant factor: D G2, with the height-correlated masking of Heitz,
/// Understanding the Masking-Shadowing Function in Microfacet-Based BRDFs (2014), equation 99. The cosine of the half
/// vector follows from that of the light.
fn reflected(alpha: f32, cosine: f32) -> f32 {
    let square = alpha * alpha;
    let half = 0.5 * (1.0 + cosine);
    let narrow = half * (square - 1.0) + 1.0;
    let masking = 2.0 * cosine / (cosine + (square + (1.0 - square) * cosine * cosine).sqrt());
    masking / (narrow * narrow)
}

impl Pyramid {
    fn new(picture: &CubePicture, world_from_cube: &Mat3A) -> Self {
        let texels = windows(Vec3::ZERO, world_from_cube, picture.size).texels;
        let leaf = |(texel, light): (&Texel<Window>, &Rgb)| {
            let window = &texel.receiver;
            let solid_angle = window.solid_angle();
            Node {
                direction: window.middle().normalize(),
                reach: 0.5 * (window.across.length() + window.down.length()) / window.middle().length(),
                solid_angle,
                light: *light * solid_angle,
            }
        };
        let leaves = texels.iter().zip(&picture.texels).map(leaf).collect();
        let mut levels: Vec<(u32, Vec<Node>)> = vec![(picture.size, leaves)];
        while let Some((size, below)) = levels.last().filter(|(size, _)| *size > 1) {
            let parent =
                |(side, at): (usize, UVec2)| Node::together(children(at).map(|place| below[index(*size, side, place)]));
            let above = (size / 2, places(size / 2).map(parent).collect());
            levels.push(above);
        }
        Self { levels }
    }

    /// The mean over all directions above the horizon, weighted by `weight` of their cosine to `normal`. Near the
    /// normal the weight changes over an angle of `width`, elsewhere over the distance from the normal.
    fn mean(&self, normal: Vec3, width: f32, weight: impl Fn(f32) -> f32) -> Rgb {
        let (mut light, mut whole) = (Rgb::ZERO, 0.0);
        let top = self.levels.len() - 1;
        let mut waiting: Vec<(usize, usize, UVec2)> = (0..6).map(|side| (top, side, UVec2::ZERO)).collect();
        while let Some((level, side, at)) = waiting.pop() {
            let (size, nodes) = &self.levels[level];
            let node = &nodes[index(*size, side, at)];
            let distance = node.direction.distance(normal);
            // The node is entirely below the horizon.
            if distance - node.reach > std::f32::consts::SQRT_2 {
                continue;
            }
            if level == 0 || node.reach <= FINENESS * (width + distance) {
                let cosine = node.direction.dot(normal);
                if cosine > 0.0 {
                    let weight = weight(cosine);
                    light += weight * node.light;
                    whole += weight * node.solid_angle;
                }
                continue;
            }
            waiting.extend(children(at).map(|place| (level - 1, side, place)));
        }
        if whole > 0.0 { light / whole } else { Rgb::ZERO }
    }
}

/// The positions of the four nodes of the level below that make up a node.
fn children(at: UVec2) -> [UVec2; 4] {
    [UVec2::ZERO, UVec2::X, UVec2::Y, UVec2::ONE].map(|offset| 2 * at + offset)
}

impl Node {
    fn together(parts: [Self; 4]) -> Self {
        let mut node = Self::default();
        for part in &parts {
            node.direction += part.solid_angle * part.direction;
            node.solid_angle += part.solid_angle;
            node.light += part.light;
        }
        node.direction = node.direction.normalize();
        let farthest = parts.map(|part| part.direction.distance(node.direction) + part.reach);
        node.reach = farthest.into_iter().fold(0.0, f32::max);
        node
    }
}

#[cfg(test)]
mod tests {
    use std::f32::consts::PI;
    use std::sync::atomic::AtomicBool;

    use super::*;

    fn filtered(picture: CubePicture, cube: &Mat3A) -> Prefiltered {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(2).build().expect("threads");
        let mut told = Vec::new();
        let work = &mut Work {
            pool: &pool,
            cancel: &AtomicBool::new(false),
            watch: &mut |done| told.push(done),
        };
        let filtered = prefilter(picture, cube, work).expect("nothing cancels it");
        assert!(
            told.is_sorted() && told.iter().all(|done| (0.0..1.0).contains(done)),
            "{told:?}"
        );
        filtered
    }

    #[test]
    fn a_filter_that_is_cancelled_ends() {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("threads");
        let cancel = AtomicBool::new(false);
        let work = &mut Work {
            pool: &pool,
            cancel: &cancel,
            watch: &mut |done| cancel.store(done > 0.0, Ordering::Relaxed),
        };
        assert_eq!(
            prefilter(CubePicture::of(32, |_| Rgb::ONE), &Mat3A::IDENTITY, work),
            None
        );
    }

    fn assert_near(what: &str, found: Rgb, expected: f32, tolerance: f32) {
        assert!(
            (found - expected).abs().max_element() < tolerance,
            "{what}: {found} for {expected}"
        );
    }

    #[test]
    fn what_is_the_same_everywhere_stays_so() {
        let stretched = Mat3A::from_diagonal(Vec3::new(1.0, 4.0, 0.3));
        let filtered = filtered(CubePicture::of(32, |_| Rgb::splat(3.0)), &stretched);
        let sizes: Vec<u32> = filtered.specular.iter().map(|level| level.size).collect();
        assert_eq!(sizes, [32, 16, 8, 4]);
        for picture in filtered.specular.iter().chain([&filtered.diffuse]) {
            for texel in &picture.texels {
                // Sums of some thousand single-precision numbers.
                assert_near("constant", *texel, 3.0, 3e-5);
            }
        }
    }

    #[test]
    fn half_a_sky_lights_by_the_cosine_to_its_pole_whatever_the_shape_of_the_cube() {
        for stretch in [Vec3::ONE, Vec3::new(2.0, 0.5, 1.0)] {
            let cube = Mat3A::from_diagonal(stretch);
            let sky = CubePicture::of(64, |direction| Rgb::splat(if direction.y > 0.0 { 1.0 } else { 0.0 }));
            let filtered = filtered(sky, &cube);
            let middle = |texel: &Texel<Window>| texel.receiver.middle().normalize();
            let normals = windows(Vec3::ZERO, &cube, filtered.diffuse.size).texels;
            for (normal, light) in normals.iter().map(middle).zip(&filtered.diffuse.texels) {
                assert_near("diffuse", *light, 0.5 * (1.0 + normal.y), 5e-3);
            }
        }
    }

    /// The mean by a fine sum over rings around the normal.
    fn spot(alpha: f32, radius: f32) -> f32 {
        let (mut inside, mut whole) = (0.0, 0.0);
        let steps = 200_000;
        for step in 0..steps {
            let angle = (step as f64 + 0.5) * 0.5 * std::f64::consts::PI / steps as f64;
            let weight = f64::from(reflected(alpha, angle.cos() as f32)) * angle.sin();
            whole += weight;
            inside += if angle < f64::from(radius) { weight } else { 0.0 };
        }
        (inside / whole) as f32
    }

    #[test]
    fn a_round_spot_is_seen_in_rough_mirrors_as_by_a_sum_over_rings() {
        let radius = 0.3f32;
        let towards = Vec3::new(0.3, 0.8, -0.2).normalize();
        let picture = CubePicture::of(128, |direction| {
            Rgb::splat(if direction.normalize().dot(towards) > radius.cos() {
                1.0
            } else {
                0.0
            })
        });
        let pyramid = Pyramid::new(&picture, &Mat3A::IDENTITY);
        for level in 1..=5 {
            let alpha = (level as f32 / 5.0).powi(2);
            let found = pyramid.mean(towards, 2.0 * alpha, |cosine| reflected(alpha, cosine));
            assert_near(&format!("{alpha}"), found, spot(alpha, radius), 4e-3);
        }
        let diffuse = pyramid.mean(towards, 0.5, |cosine| cosine);
        assert_near("diffuse", diffuse, radius.sin().powi(2), 4e-3);
        assert!((pyramid.levels[0].1.iter().map(|node| node.solid_angle).sum::<f32>() - 4.0 * PI).abs() < 1e-2);
    }

    #[test]
    fn a_surface_of_full_roughness_reflects_as_the_formula_says() {
        // D is 1 / pi everywhere, and G2 is 2 c / (1 + c).
        for cosine in [0.1f32, 0.5, 1.0] {
            assert!((reflected(1.0, cosine) - 2.0 * cosine / (1.0 + cosine)).abs() < 1e-6);
        }
    }
}
