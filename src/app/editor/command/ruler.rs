//! A measured distance between two points of the world.

use bevy::math::Vec3;

use crate::scene::LengthUnit;

/// A measured distance. It is no part of the scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ruler {
    /// The point that was clicked first.
    pub from: Vec3,
    /// The other point.
    pub to: Vec3,
}

/// The most kept distances; the oldest is dropped for a new one.
pub(crate) const MOST_RULERS: usize = 64;

impl Ruler {
    /// The distance in world units.
    pub fn length(&self) -> f32 {
        self.from.distance(self.to)
    }

    /// The distance, followed by its parts along the axes.
    pub fn text(&self, unit: LengthUnit) -> String {
        let parts = (self.to - self.from).abs().to_array().map(|part| unit.number(part));
        let [x, y, z] = parts;
        format!("{}   X {x}  Y {y}  Z {z}", unit.text(self.length()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ruler_tells_its_length_and_its_parts() {
        let ruler = Ruler {
            from: Vec3::new(1.0, 0.0, 2.0),
            to: Vec3::new(-2.0, 4.0, 2.0),
        };
        assert_eq!(ruler.length(), 5.0);
        assert_eq!(ruler.text(LengthUnit::Centimetre), "5 cm   X 3  Y 4  Z 0");
        assert_eq!(ruler.text(LengthUnit::None), "5   X 3  Y 4  Z 0");
    }
}
