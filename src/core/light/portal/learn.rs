//! Finds the places that portals light, and the share of samples that should go through the portals there.
//!
//! Rays from a portal find the surfaces that see it. From some of these, samples of the sky and through the portals
//! tell the second moment of either and of their mixtures, and with it the best share of each. It is 0 where there is
//! no room behind a portal, where other portals or the sky itself are better, and where glass that refracts lets no
//! shadow ray through. All of it is a function of the scene alone.

use glam::Vec3;

use super::{MOST_SIDES, Portal, PortalSide, Portals, Seen};
use crate::accel::{Detail, Obstacle, Tlas};
use crate::color::luminance;
use crate::light::LightReference;
use crate::light::infinite::InfiniteLight;
use crate::light::reference::Reference;
use crate::math::{Aabb, Frame, Ray, offset_origin};
use crate::sampling::hash::pcg4d;
use crate::sampling::{Rectangle, unit_float, warp};

/// The most portals that are considered, the largest first.
const MOST_PORTALS: usize = 256;

/// The rays from a portal to each of its sides.
const RAYS: u32 = 128;

/// The least number of surfaces that they must meet for a room.
const LEAST_HITS: usize = RAYS as usize / 8;

/// The share of the surfaces at each end of a room that do not count for its size: they are in another one, behind a
/// door.
const BEYOND: f32 = 0.04;

/// The margin around a room, as a share of its size.
const MARGIN: f32 = 0.02;

/// The surfaces at which samples are taken, and the samples at each.
const PLACES: usize = 32;
const SAMPLES: u32 = 4;

/// The most clear shapes that a ray passes.
const MOST_CLEAR: usize = 8;

/// A portal that gives less than this share of the light of the best, on the same solid angle, is left out.
const LEAST_WEIGHT: f32 = 0.01;

/// The shares among which the best is chosen.
const SHARES: [f32; 7] = [0.0, 0.25, 0.5, 0.65, 0.75, 0.85, 0.93];

/// A portal is used where the second moment falls below this share of that without it.
const WORTH: f32 = 0.85;

/// The light at a place, up to a common factor.
#[derive(Default)]
struct Moments {
    /// Its mean.
    mean: f32,
    /// The second moments of samples with each of the [`SHARES`].
    squares: [f32; SHARES.len()],
}

/// The scene as rays see it.
struct World<'a> {
    geometry: &'a Tlas,
    is_clear: &'a dyn Fn(usize) -> bool,
}

impl World<'_> {
    /// The surface that a ray from a portal meets behind clear ones, from the side of the ray.
    fn first_surface(&self, mut ray: Ray) -> Option<LightReference> {
        for _ in 0..MOST_CLEAR {
            let hit = self.geometry.intersect(&ray)?;
            if (self.is_clear)(self.geometry.shape_index(&hit)) {
                ray.t_min = hit.t * 1.0001;
                continue;
            }
            let point = self.geometry.surface_in(&ray, &hit, Detail::Plain);
            let towards = -point.geometric_normal.dot(ray.dir).signum() * point.geometric_normal;
            return Some(LightReference {
                position: offset_origin(point.position, point.error, point.geometric_normal, towards),
                normal: Some(towards),
            });
        }
        None
    }

    /// Whether light may come straight from infinity.
    fn is_open(&self, from: Vec3, wi: Vec3) -> bool {
        let ray = Ray::new(from, wi);
        self.geometry.obstacle(&ray, |shape| (self.is_clear)(shape)) != Obstacle::Opaque
    }
}

/// Two pairs of numbers in [0, 1).
fn numbers(place: [u32; 4]) -> [[f32; 2]; 2] {
    let [a, b, c, d] = pcg4d(place).map(unit_float);
    [[a, b], [c, d]]
}

/// The places that see a portal from one of its sides.
struct Room {
    rectangle: Rectangle,
    side: f32,
    bounds: Aabb,
    places: Vec<LightReference>,
}

/// The rooms at portals, with the scene around them.
pub(in crate::light) struct Rooms<'a> {
    world: World<'a>,
    list: Vec<Room>,
}

impl<'a> Rooms<'a> {
    /// Finds the rooms at the sides of portals. See [`Self::portals_of`].
    pub fn new(portals: &[Portal], geometry: &'a Tlas, is_clear: &'a dyn Fn(usize) -> bool) -> Self {
        let world = World { geometry, is_clear };
        let mut rectangles: Vec<(f32, Rectangle)> = portals
            .iter()
            .filter_map(|portal| {
                let [u, v] = portal.edges;
                let area = u.as_dvec3().cross(v.as_dvec3()).length() as f32;
                let is_sound = portal.corner.is_finite() && area.is_finite() && area > 0.0;
                Some((area, Rectangle::new(portal.corner, u, v).filter(|_| is_sound)?))
            })
            .collect();
        rectangles.sort_by(|one, other| other.0.total_cmp(&one.0));
        rectangles.truncate(MOST_PORTALS);
        let mut list = Vec::new();
        for (number, (_, rectangle)) in rectangles.into_iter().enumerate() {
            let [front, back] = [1.0, -1.0].map(|side| world.look(number as u32, rectangle, side));
            // No light comes from a side that sees none of the sky.
            let (is_open_before, is_open_behind) = (front.1 > 0, back.1 > 0);
            list.extend(front.0.filter(|_| is_open_behind));
            list.extend(back.0.filter(|_| is_open_before));
        }
        Self { world, list }
    }

    /// The portals of a light, at the places where they are worth it. None if they are nowhere.
    pub fn portals_of(&self, light: &InfiniteLight) -> Option<Portals> {
        if !light.is_seen() {
            return None;
        }
        let mut found: Vec<(&Room, f32)> = (0..)
            .zip(&self.list)
            .map(|(number, room)| (room, self.light_through(number, room, light)))
            .collect();
        let best = found.iter().map(|found| found.1).fold(0.0, f32::max);
        found.retain(|found| found.1 > LEAST_WEIGHT * best);
        // The list is in the order of areas.
        found.truncate(MOST_SIDES);
        let sides = found.iter().map(|&(room, light)| PortalSide {
            rectangle: room.rectangle,
            side: room.side,
            room: room.bounds,
            weight: light / best,
            share: 1.0,
        });
        let all = Portals { sides: sides.collect() };
        let kept = (0..).zip(&found).filter_map(|(number, (room, _))| {
            let share = self.best_share(number, room, light, &all);
            let side = &all.sides[number as usize];
            (share > 0.0).then(|| PortalSide { share, ..side.clone() })
        });
        let portals = Portals { sides: kept.collect() };
        (!portals.sides.is_empty()).then_some(portals)
    }

    /// The average light of the sky that arrives at the places of a room through its portal.
    fn light_through(&self, number: u32, room: &Room, light: &InfiniteLight) -> f32 {
        let (mut sum, mut count) = (0.0, 0);
        for (index, place) in (0..).zip(&room.places) {
            for sample in 0..SAMPLES / 2 {
                let [u, _] = numbers([number, index, sample, 1]);
                let wi = (room.rectangle.at(u) - place.position).normalize();
                if place.normal.is_some_and(|normal| normal.dot(wi) > 0.0) {
                    count += 1;
                    let radiance = luminance(light.sky_radiance(wi));
                    if radiance > 0.0 && self.world.is_open(place.position, wi) {
                        sum += radiance;
                    }
                }
            }
        }
        if count > 0 { sum / count as f32 } else { 0.0 }
    }

    /// The share of the samples through portals that makes the least noise in a room, with all portals together.
    fn best_share(&self, number: u32, room: &Room, light: &InfiniteLight, all: &Portals) -> f32 {
        let mut sums = [0.0; SHARES.len()];
        for (index, place) in (0..).zip(&room.places) {
            let from = Reference::from(place);
            let seen = all.seen_from(&from);
            if seen.share() <= 0.0 {
                continue;
            }
            let mut found = Moments::default();
            for sample in 0..SAMPLES {
                let [u, other] = numbers([number, index, sample, 2]);
                let of_sky = [u[0] * light.sky_share(), u[1]];
                for wi in [light.direction(&from, of_sky), seen.sample(other).wi] {
                    self.add_moments(&mut found, place, light, &seen, wi);
                }
            }
            // Bright places count for more, and one whose light was found by luck alone does not outweigh the others.
            if found.mean > 0.0 {
                (0..sums.len()).for_each(|choice| sums[choice] += found.squares[choice] / found.mean);
            }
        }
        let best = (1..sums.len()).fold(0, |best, next| if sums[next] < sums[best] { next } else { best });
        if sums[best] < WORTH * sums[0] {
            SHARES[best]
        } else {
            0.0
        }
    }

    /// Adds what a direction tells. Half of the directions are the sky's own, half are through portals.
    fn add_moments(
        &self,
        found: &mut Moments,
        place: &LightReference,
        light: &InfiniteLight,
        seen: &Seen<f32>,
        wi: Vec3,
    ) {
        let cosine = place.normal.map_or(1.0, |normal| normal.dot(wi));
        if !(wi.is_finite() && cosine > 0.0) {
            return;
        }
        let value = cosine * luminance(light.sky_radiance(wi));
        if value <= 0.0 || !self.world.is_open(place.position, wi) {
            return;
        }
        let own = light.radiance_and_pdfs::<f32>(&place.into(), wi).1[0] / light.sky_share();
        let through = seen.pdf(wi);
        // The samples of both kinds together have half the sum of both densities.
        let sample = value / (own + through);
        if !sample.is_finite() {
            return;
        }
        found.mean += sample;
        for (square, share) in found.squares.iter_mut().zip(SHARES) {
            let density = (1.0 - share) * own + share * through;
            *square += sample * (value / density.max(f32::MIN_POSITIVE)).min(f32::MAX);
        }
    }
}

impl World<'_> {
    /// The room at one side of a rectangle, if there is one, and the number of rays to that side that meet nothing.
    fn look(&self, number: u32, rectangle: Rectangle, side: f32) -> (Option<Room>, u32) {
        let frame = Frame::from_normal(side * rectangle.normal());
        let (mut places, mut open) = (Vec::new(), 0);
        for index in 0..RAYS {
            let [place, u] = numbers([number, index, side.to_bits(), 0]);
            let dir = frame.to_world(warp::cosine_hemisphere(u)).normalize();
            match self.first_surface(Ray::new(rectangle.at(place), dir)) {
                Some(surface) => places.push(surface),
                None => open += 1,
            }
        }
        let room = (places.len() >= LEAST_HITS).then(|| {
            let bounds = room_around(&places);
            places.truncate(PLACES);
            Room {
                rectangle,
                side,
                bounds,
                places,
            }
        });
        (room, open)
    }
}

/// The box around nearly all of the places.
fn room_around(places: &[LightReference]) -> Aabb {
    let left_out = (BEYOND * places.len() as f32) as usize;
    let [x, y, z] = [0, 1, 2].map(|axis| {
        let mut along: Vec<f32> = places.iter().map(|place| place.position[axis]).collect();
        along.sort_by(f32::total_cmp);
        let (first, last) = (along[left_out], along[along.len() - 1 - left_out]);
        let margin = MARGIN * (last - first);
        [first - margin, last + margin]
    });
    Aabb {
        min: Vec3::new(x[0], y[0], z[0]),
        max: Vec3::new(x[1], y[1], z[1]),
    }
}
