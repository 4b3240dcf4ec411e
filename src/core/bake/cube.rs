//! Cube maps: pictures of all directions on the six faces of a cube.
//!
//! Source: the Vulkan specification, section "Cube Map Face Selection". A renderer that looks up directions of a
//! right-handed space negates z before, as Bevy does, since cube maps are left-handed. Directions here are in the
//! right-handed space.

use glam::{Mat3A, UVec2, Vec2, Vec3};

use super::texels::{Texel, Texels};
use crate::color::Rgb;
use crate::render::probe_radiance::Window;

/// For each face its centre and the directions of growing columns and rows. The faces are +x, -x, +y, -y, -z and +z,
/// since z is negated.
const SIDES: [[Vec3; 3]; 6] = [
    [Vec3::X, Vec3::Z, Vec3::NEG_Y],
    [Vec3::NEG_X, Vec3::NEG_Z, Vec3::NEG_Y],
    [Vec3::Y, Vec3::X, Vec3::NEG_Z],
    [Vec3::NEG_Y, Vec3::X, Vec3::Z],
    [Vec3::NEG_Z, Vec3::X, Vec3::NEG_Y],
    [Vec3::Z, Vec3::NEG_X, Vec3::NEG_Y],
];

/// A cube map.
#[derive(Clone, Debug, PartialEq)]
pub struct CubePicture {
    /// The width and the height of each face, in texels.
    pub size: u32,
    /// Face by face, and row by row from the top within a face; linear Rec. 709.
    pub texels: Vec<Rgb>,
}

impl CubePicture {
    /// The cube map with the value of `light` at the centre of each texel, given as a direction of any length.
    #[cfg(test)]
    pub(super) fn of(size: u32, light: impl Fn(Vec3) -> Rgb) -> Self {
        Self {
            size,
            texels: middles(size).into_iter().map(light).collect(),
        }
    }

    /// The texel that a direction falls into.
    pub fn at(&self, direction: Vec3) -> Rgb {
        let reach = SIDES.map(|[middle, _, _]| middle.dot(direction));
        let side = (1..6).fold(0, |best, side| if reach[side] > reach[best] { side } else { best });
        let [_, across, down] = SIDES[side];
        let at = Vec2::new(across.dot(direction), down.dot(direction)) / reach[side];
        let place = (0.5 * (at + 1.0) * self.size as f32).max(Vec2::ZERO).as_uvec2();
        let place = place.min(UVec2::splat(self.size - 1));
        self.texels[index(self.size, side, place)]
    }

    /// A face with a border of `border` texels, which continue the plane of the face and show the neighbouring faces.
    pub fn bordered(&self, side: usize, border: u32) -> Vec<Rgb> {
        let [middle, across, down] = SIDES[side];
        let width = self.size + 2 * border;
        let places = (0..width).flat_map(|y| (0..width).map(move |x| Vec2::new(x as f32, y as f32)));
        let direction = |place: Vec2| {
            let at = (place + 0.5 - border as f32) * 2.0 / self.size as f32 - 1.0;
            middle + at.x * across + at.y * down
        };
        places.map(|place| self.at(direction(place))).collect()
    }
}

/// The texel centres as directions, in the order of [`CubePicture::texels`].
pub(super) fn middles(size: u32) -> Vec<Vec3> {
    let middle = |(side, place)| window(Vec3::ZERO, &Mat3A::IDENTITY, side, place, size).middle();
    places(size).map(middle).collect()
}

/// The index of a texel in [`CubePicture::texels`].
pub(super) fn index(size: u32, side: usize, place: UVec2) -> usize {
    let size = size as usize;
    (side * size + place.y as usize) * size + place.x as usize
}

/// The windows of all texels of a cube map of this size around the point `from`, in the order of
/// [`CubePicture::texels`]. The cube may be stretched and rotated.
pub fn windows(from: Vec3, world_from_cube: &Mat3A, size: u32) -> Texels<Window> {
    let texel = |(side, place): (usize, UVec2)| Texel {
        place: UVec2::new(place.x, side as u32 * size + place.y),
        receiver: window(from, world_from_cube, side, place, size),
    };
    let texels: Vec<Texel<Window>> = places(size).map(texel).collect();
    Texels {
        size: UVec2::new(size, 6 * size),
        pages: std::iter::once(0..texels.len()).collect(),
        texels,
        spreads: Vec::new(),
    }
}

/// The face and the column and row of each texel, in the order of [`CubePicture::texels`].
pub(super) fn places(size: u32) -> impl Iterator<Item = (usize, UVec2)> {
    (0..6).flat_map(move |side| (0..size).flat_map(move |y| (0..size).map(move |x| (side, UVec2::new(x, y)))))
}

fn window(from: Vec3, world_from_cube: &Mat3A, side: usize, place: UVec2, size: u32) -> Window {
    let [middle, across, down] = SIDES[side];
    let width = 2.0 / size as f32;
    let corner = width * place.as_vec2() - 1.0;
    Window {
        from,
        corner: *world_from_cube * (middle + corner.x * across + corner.y * down),
        across: *world_from_cube * (width * across),
        down: *world_from_cube * (width * down),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_direction_finds_its_texel_and_solid_angles_make_a_sphere() {
        let picture = CubePicture::of(8, |direction| direction.normalize());
        for (texel, direction) in windows(Vec3::ZERO, &Mat3A::IDENTITY, 8)
            .texels
            .iter()
            .zip(&picture.texels)
        {
            assert_eq!(picture.at(texel.receiver.middle()), *direction);
            assert!(direction.angle_between(texel.receiver.middle()) < 1e-3);
        }
        let stretched = Mat3A::from_diagonal(Vec3::new(1.0, 3.0, 0.5));
        for shape in [Mat3A::IDENTITY, stretched] {
            let windows = windows(Vec3::ONE, &shape, 64).texels;
            let whole: f32 = windows.iter().map(|texel| texel.receiver.solid_angle()).sum();
            assert!((whole / (4.0 * std::f32::consts::PI) - 1.0).abs() < 1e-3, "{whole}");
        }
    }

    #[test]
    fn sides_are_those_that_a_graphics_card_selects() {
        // The table of the Vulkan specification: s and t of the left-handed direction.
        let selected = |direction: Vec3| {
            let Vec3 { x, y, z } = direction;
            let (side, s, t, along) = match direction.abs().max_position() {
                0 if x > 0.0 => (0, -z, -y, x),
                0 => (1, z, -y, -x),
                1 if y > 0.0 => (2, x, z, y),
                1 => (3, x, -z, -y),
                _ if z > 0.0 => (4, x, -y, z),
                _ => (5, -x, -y, -z),
            };
            (side, 0.5 * (Vec2::new(s, t) / along + 1.0))
        };
        for (side, place) in places(4) {
            let direction = window(Vec3::ZERO, &Mat3A::IDENTITY, side, place, 4).middle();
            let (found, at) = selected(direction * Vec3::new(1.0, 1.0, -1.0));
            assert_eq!((found, (4.0 * at).as_uvec2()), (side, place), "{direction}");
        }
    }

    #[test]
    fn the_border_of_a_side_is_the_side_beside_it() {
        let picture = CubePicture::of(8, |direction| direction.normalize());
        let bordered = picture.bordered(0, 2);
        assert_eq!(bordered.len(), 144);
        assert_eq!(bordered[2 * 12 + 2], picture.texels[0]);
        // The neighbouring faces continue the row.
        let row = &bordered[6 * 12..7 * 12];
        let angles: Vec<f32> = row.iter().map(|direction| direction.z.atan2(direction.x)).collect();
        assert!(angles.windows(2).all(|two| two[1] >= two[0]), "{angles:?}");
        assert!(angles[0] < -0.25 * std::f32::consts::PI && angles[11] > 0.25 * std::f32::consts::PI);
    }
}
