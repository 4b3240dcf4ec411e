//! Builds the light tree top down, splitting where the surface area orientation heuristic is least among binned planes.
//!
//! The heuristic is Conty Estevez and Kulla's with two simplifications: the measure of space is the square of the
//! ball's radius, which also separates points on a line, and the spread of a bin's normals is estimated from their
//! mean, which needs no trigonometry per emitter. The cones of the finished nodes are true bounds, merged bottom up.

use glam::Vec3;

use super::node::{Content, Node};
use super::{LightTree, Place};
use crate::light::bounds::LightBounds;
use crate::math::Aabb;

/// An emitter on its way into the tree.
#[derive(Clone, Copy)]
struct Item {
    light: LightBounds,
    emitter: u32,
}

/// The number of slices of the box of centroids between which planes are tried.
const BINS: usize = 16;

/// Below this depth sets are halved by number, which bounds the depth by this plus the logarithm of the set's size.
const DEEPEST_SPLIT: u32 = 64;

/// Smaller sets are not split on another thread.
const SMALLEST_TASK: usize = 8192;

impl LightTree {
    /// The tree over the emitters that have bounds; None if there are none.
    pub(in crate::light) fn build(emitters: &[Option<LightBounds>]) -> Option<Self> {
        let shining = emitters.iter().zip(0..);
        let mut items: Vec<Item> = shining
            .filter_map(|(light, emitter)| {
                let light = (*light)?;
                Some(Item { light, emitter })
            })
            .collect();
        // Intensities are divided by their total, so that their sums stay in range and none of them vanishes.
        let total: f64 = items.iter().map(|item| f64::from(item.light.intensity)).sum();
        for item in &mut items {
            let share = f64::from(item.light.intensity) / total;
            item.light.intensity = (share as f32).max(f32::MIN_POSITIVE);
        }
        let mut pairs = vec![[Node::EMPTY; 2]; items.len().checked_sub(1)?];
        let mut parents = vec![Place::default(); pairs.len()];
        let mut leaves = vec![None; emitters.len()];
        let only = match items[..] {
            [item] => Some(item.emitter),
            _ => None,
        };
        match only {
            Some(emitter) => leaves[emitter as usize] = Some(Place::default()),
            None => {
                split(&mut items, &mut pairs, 0, 0);
            }
        }
        for (nodes, pair) in pairs.iter().zip(0..) {
            for (side, node) in nodes.iter().enumerate() {
                match node.content() {
                    Content::Emitter(emitter) => leaves[emitter as usize] = Some(Place::new(pair, side)),
                    Content::Pair(child) => parents[child as usize] = Place::new(pair, side),
                }
            }
        }
        Some(Self {
            pairs,
            parents,
            leaves,
            only,
        })
    }
}

/// Fills `pairs`, one fewer than `items` and the first of them numbered `first_pair`, with the tree over two items or
/// more.
fn split(items: &mut [Item], pairs: &mut [[Node; 2]], first_pair: u32, depth: u32) -> LightBounds {
    let middle = partition(items, depth);
    let parallel = items.len() >= SMALLEST_TASK;
    let (left, right) = items.split_at_mut(middle);
    let (own, below) = pairs.split_at_mut(1);
    let (left_pairs, right_pairs) = below.split_at_mut(left.len() - 1);
    let left_first = first_pair + 1;
    let right_first = left_first + left_pairs.len() as u32;
    let mut on_left = || subtree(left, left_pairs, left_first, depth + 1);
    let mut on_right = || subtree(right, right_pairs, right_first, depth + 1);
    let (first, second) = if parallel {
        rayon::join(on_left, on_right)
    } else {
        (on_left(), on_right())
    };
    own[0] = [first, second].map(|(light, content)| Node::new(&light, content));
    first.0.union(second.0)
}

fn subtree(items: &mut [Item], pairs: &mut [[Node; 2]], first_pair: u32, depth: u32) -> (LightBounds, Content) {
    match items {
        [item] => (item.light, Content::Emitter(item.emitter)),
        _ => (split(items, pairs, first_pair, depth), Content::Pair(first_pair)),
    }
}

/// Orders two items or more into two non-empty sets, and returns the size of the first.
fn partition(items: &mut [Item], depth: u32) -> usize {
    let half = items.len() / 2;
    let centroids = Aabb::from_points(items.iter().map(centroid));
    let widest = centroids.extent().max_position();
    if items.len() == 2 || centroids.extent()[widest] <= 0.0 {
        return half;
    }
    if depth < DEEPEST_SPLIT
        && let Some(plane) = best_plane(items, &centroids)
    {
        let mut first = 0;
        for index in 0..items.len() {
            if plane.bin_of(&items[index]) < plane.bin {
                items.swap(first, index);
                first += 1;
            }
        }
        return first;
    }
    items.select_nth_unstable_by(half, |a, b| centroid(a)[widest].total_cmp(&centroid(b)[widest]));
    half
}

fn centroid(item: &Item) -> Vec3 {
    item.light.bounds.center()
}

/// A boundary across one axis, before which the bins up to `bin` are.
#[derive(Clone, Copy)]
struct Plane {
    axis: usize,
    start: f32,
    bins_per_length: f32,
    bins: usize,
    bin: usize,
}

impl Plane {
    fn bin_of(&self, item: &Item) -> usize {
        let bin = (centroid(item)[self.axis] - self.start) * self.bins_per_length;
        (bin as usize).min(self.bins - 1)
    }
}

/// The sums over some emitters that the heuristic needs.
#[derive(Clone, Copy)]
struct Bin {
    bounds: Aabb,
    intensity: f32,
    /// The sum of mean normals, weighted by intensity.
    normals: Vec3,
}

impl Bin {
    const EMPTY: Self = Self {
        bounds: Aabb::EMPTY,
        intensity: 0.0,
        normals: Vec3::ZERO,
    };

    fn with(self, other: &Self) -> Self {
        Self {
            bounds: self.bounds.union(other.bounds),
            intensity: self.intensity + other.intensity,
            normals: self.normals + other.normals,
        }
    }

    /// The cost: intensity times the measures of the normals and of the volume; zero if empty.
    fn cost(&self) -> f32 {
        if self.intensity <= 0.0 {
            return 0.0;
        }
        // Directions spread evenly over a cone have a mean of length (1 + cos) / 2.
        let cos = (2.0 * self.normals.length() / self.intensity - 1.0).clamp(-1.0, 1.0);
        self.intensity * shone_upon(cos) * self.bounds.extent().length_squared()
    }
}

/// The solid angle lit by surfaces with normals in a cone, weighted by the cosine to the nearest normal: pi for one
/// normal, 4 pi for all. Exact up to a right angle, a smooth continuation above.
fn shone_upon(cos: f32) -> f32 {
    use std::f32::consts::PI;
    let sin = (1.0 - cos * cos).max(0.0).sqrt();
    if cos > 0.0 {
        2.0 * PI - PI * cos + 0.5 * PI * PI * sin
    } else {
        2.0 * PI * (1.0 - cos) + 0.5 * PI * PI * sin * (1.0 + cos)
    }
}

/// The best plane; None if no plane has emitters on both sides.
fn best_plane(items: &[Item], centroids: &Aabb) -> Option<Plane> {
    let bins = items.len().min(BINS);
    let extent = centroids.extent();
    let mut best = None;
    let mut least = f32::INFINITY;
    for axis in (0..3).filter(|&axis| extent[axis] > 0.0) {
        let mut plane = Plane {
            axis,
            start: centroids.min[axis],
            bins_per_length: bins as f32 / extent[axis],
            bins,
            bin: 0,
        };
        let mut filled = [Bin::EMPTY; BINS];
        for item in items {
            let bin = &mut filled[plane.bin_of(item)];
            *bin = bin.with(&Bin {
                bounds: item.light.bounds,
                intensity: item.light.intensity,
                normals: item.light.intensity * item.light.cone.mean(),
            });
        }
        let mut above = [Bin::EMPTY; BINS];
        let mut sum = Bin::EMPTY;
        for bin in (1..bins).rev() {
            sum = sum.with(&filled[bin]);
            above[bin] = sum;
        }
        // Splits across the short sides of a flat box are made expensive.
        let slenderness = extent.max_element() / extent[axis];
        let mut below = Bin::EMPTY;
        for bin in 1..bins {
            below = below.with(&filled[bin - 1]);
            let cost = slenderness * (below.cost() + above[bin].cost());
            if !below.bounds.is_empty() && !above[bin].bounds.is_empty() && cost < least {
                least = cost;
                plane.bin = bin;
                best = Some(plane);
            }
        }
    }
    best
}
