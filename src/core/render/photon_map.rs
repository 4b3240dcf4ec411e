//! Photons in a balanced kd-tree (Jensen, "Realistic Image Synthesis Using Photon Mapping", 2001, chapter 6): vertices
//! of light paths, searchable by position.

use glam::Vec3;

use crate::color::Rgb;
use crate::light::LightId;

/// Light that has reached a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Photon {
    /// The light at which its path begins.
    pub light: LightId,
    /// The position in world space.
    pub position: Vec3,
    /// Unit vector to the photon's origin.
    pub wi: Vec3,
    /// Its power in W, as if it were the only photon.
    pub power: Rgb,
    /// The densities of the techniques that find its path with fewer vertices from the light.
    pub fewer: FewerOfLight,
    /// The segments of its path.
    pub segments: u32,
}

/// The sum of the squared ratios of the techniques with fewer vertices from the light than the current one. All grow
/// with the density that the last vertex of the light path has from the camera, and some with the density of the
/// direction in which the camera path continues there.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct FewerOfLight {
    /// The part that does not depend on the direction.
    pub fixed: f32,
    /// The factor of the squared density of the direction.
    pub of_next: f32,
}

impl FewerOfLight {
    /// The sum, for a density `next` per solid angle of the direction.
    pub fn sum(&self, next: f32) -> f32 {
        self.fixed + self.of_next * next * next
    }
}

/// The area around a point in which photons count as being at the point: a disk whose radius is a number of pixels as
/// the camera would see them there unoccluded.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct MergeArea {
    /// The squared radius at distance 1 from `eye`, or everywhere if there is no eye.
    pub radius_squared: f32,
    /// The camera's position; None for parallel rays.
    pub eye: Option<Vec3>,
    /// An upper bound of the squared radius.
    pub largest: f32,
}

impl MergeArea {
    pub fn radius_squared(&self, place: Vec3) -> f32 {
        let distance_squared = self.eye.map_or(1.0, |eye| eye.distance_squared(place));
        (self.radius_squared * distance_squared).min(self.largest)
    }
}

/// The photons of one round.
#[derive(Debug, Default)]
pub(super) struct PhotonMap {
    /// The tree: the centre of a range splits it, and the halves on both sides are its children.
    photons: Vec<Photon>,
    /// The axis by which each photon splits its range.
    axes: Vec<u8>,
}

/// Ranges up to this length are not split.
const LEAF: usize = 8;

impl PhotonMap {
    pub fn new(mut photons: Vec<Photon>) -> Self {
        let mut axes = vec![0; photons.len()];
        split(&mut photons, &mut axes);
        Self { photons, axes }
    }

    /// Calls `visit` with each photon closer to `place` than the root of `radius_squared`, always in the same order.
    pub fn near(&self, place: Vec3, radius_squared: f32, mut visit: impl FnMut(&Photon)) {
        let mut look = |photon: &Photon| {
            if photon.position.distance_squared(place) < radius_squared {
                visit(photon);
            }
        };
        // Each step halves the range, and leaves at most one half waiting.
        let mut waiting = arrayvec::ArrayVec::<(usize, usize), 64>::new();
        let mut range = Some((0, self.photons.len()));
        while let Some((start, end)) = range {
            range = None;
            if end - start <= LEAF {
                self.photons[start..end].iter().for_each(&mut look);
            } else {
                let middle = start.midpoint(end);
                let axis = usize::from(self.axes[middle]);
                let photon = &self.photons[middle];
                let beyond = place[axis] - photon.position[axis];
                let (near, far) = match beyond < 0.0 {
                    true => ((start, middle), (middle + 1, end)),
                    false => ((middle + 1, end), (start, middle)),
                };
                if beyond * beyond < radius_squared {
                    look(photon);
                    waiting.push(far);
                }
                range = Some(near);
            }
            range = range.or_else(|| waiting.pop());
        }
    }
}

fn split(photons: &mut [Photon], axes: &mut [u8]) {
    if photons.len() <= LEAF {
        return;
    }
    let positions = || photons.iter().map(|photon| photon.position);
    let min = positions().fold(Vec3::INFINITY, Vec3::min);
    let max = positions().fold(Vec3::NEG_INFINITY, Vec3::max);
    let axis = (max - min).max_position();
    let middle = photons.len() / 2;
    photons.select_nth_unstable_by(middle, |a, b| a.position[axis].total_cmp(&b.position[axis]));
    axes[middle] = axis as u8;
    let (before, after) = photons.split_at_mut(middle);
    let (axes_before, axes_after) = axes.split_at_mut(middle);
    split(before, axes_before);
    split(&mut after[1..], &mut axes_after[1..]);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::hash::pcg3d;

    fn photons(count: u32) -> Vec<Photon> {
        let photon = |number| {
            let place = pcg3d([number, 1, 2]).map(|word| (word >> 20) as f32 / 4096.0);
            Photon {
                light: LightId(0),
                position: Vec3::from(place),
                wi: Vec3::Z,
                power: Rgb::splat(number as f32),
                fewer: FewerOfLight::default(),
                segments: 2,
            }
        };
        (0..count).map(photon).collect()
    }

    #[test]
    fn all_photons_near_a_place_are_found_once() {
        for count in [0, 1, 8, 9, 10, 1000, 5001] {
            let all = photons(count);
            let map = PhotonMap::new(all.clone());
            for number in 0..50 {
                let place = Vec3::from(pcg3d([number, 7, 3]).map(|word| word as f32 / 2_f32.powi(32)));
                let radius_squared = (0.003 * number as f32).powi(2);
                let mut found = Vec::new();
                map.near(place, radius_squared, |photon| found.push(photon.power.x));
                let near = |photon: &&Photon| photon.position.distance_squared(place) < radius_squared;
                let mut expected: Vec<f32> = all.iter().filter(near).map(|photon| photon.power.x).collect();
                found.sort_by(f32::total_cmp);
                expected.sort_by(f32::total_cmp);
                assert_eq!(found, expected, "{count} {number}");
            }
        }
    }

    #[test]
    fn photons_at_one_place_are_a_tree_as_well() {
        let all = vec![photons(1)[0]; 3000];
        let map = PhotonMap::new(all.clone());
        let mut found = 0;
        map.near(all[0].position, 1e-6, |_| found += 1);
        assert_eq!(found, 3000);
    }
}
