//! Distances along a ray at which a lamp is seen under evenly distributed angles, so that places near the lamp are found (Kulla and Fajardo, Importance
//! Sampling Techniques for Path Tracing in Participating Media, 2012).

use glam::Vec3;

use super::Way;

/// The least distance of a lamp from the ray, relative to the mean free path. It keeps the density finite.
const NEAREST: f32 = 1e-3;

/// A distribution of distances.
pub(super) struct Equiangular {
    /// The distance along the way of the point that is nearest to the lamp.
    nearest: f32,
    /// The distance of the lamp from there.
    height: f32,
    /// The angles at the lamp of the start and of the end of the way.
    from: f32,
    to: f32,
}

impl Equiangular {
    /// The distribution for a lamp in a medium with the extinction `sigma_t`. None if the lamp is farther than a mean free path from the way, where
    /// the extinction matters more than the lamp.
    pub fn new(way: &Way, lamp: Vec3, sigma_t: f32) -> Option<Self> {
        let to_lamp = lamp - way.origin;
        let nearest = to_lamp.dot(way.dir);
        let height = (to_lamp - way.dir * nearest).length().max(NEAREST / sigma_t);
        let within = nearest.clamp(0.0, way.length);
        if height.hypot(nearest - within) * sigma_t > 1.0 {
            return None;
        }
        let angle = |distance: f32| ((distance - nearest) / height).atan();
        let (from, to) = (angle(0.0), angle(way.length));
        (to > from).then_some(Self {
            nearest,
            height,
            from,
            to,
        })
    }

    /// The distance for `u` in [0, 1).
    pub fn sample(&self, u: f32) -> f32 {
        let angle = self.from + u * (self.to - self.from);
        (self.nearest + self.height * angle.tan()).max(0.0)
    }

    /// The density at a distance.
    pub fn pdf(&self, distance: f32) -> f32 {
        let along = distance - self.nearest;
        self.height / ((self.to - self.from) * (self.height * self.height + along * along))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances_follow_their_density() {
        for length in [0.7, 3.0, f32::INFINITY] {
            let way = Way {
                origin: Vec3::new(0.3, 0.0, 0.0),
                dir: Vec3::Y,
                length,
            };
            let lamp = Equiangular::new(&way, Vec3::new(0.5, 0.6, 0.1), 0.5).unwrap();
            const STEPS: usize = 20_000;
            // The integral of the density up to each sampled distance is the number it was sampled by.
            let mut integral = 0.0f64;
            let mut before = lamp.sample(0.0);
            for step in 1..STEPS {
                let u = step as f32 / STEPS as f32;
                let distance = lamp.sample(u);
                assert!(distance >= before && distance <= length * 1.0001);
                integral += f64::from(0.5 * (lamp.pdf(before) + lamp.pdf(distance)) * (distance - before));
                before = distance;
                if u < 0.99 {
                    assert!((integral - f64::from(u)).abs() < 2e-3, "{length} {u}: {integral}");
                }
            }
        }
    }

    #[test]
    fn lamps_far_off_are_left_out() {
        let way = Way {
            origin: Vec3::ZERO,
            dir: Vec3::Y,
            length: 1.0,
        };
        assert!(Equiangular::new(&way, Vec3::new(2.0, 0.5, 0.0), 1.0).is_none());
        assert!(Equiangular::new(&way, Vec3::new(0.0, 2.5, 0.0), 1.0).is_none());
        assert!(Equiangular::new(&way, Vec3::new(0.0, 1.5, 0.0), 1.0).is_some());
    }
}
