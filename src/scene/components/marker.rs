//! Markers: places of a level that are not seen, for the code of a game. A marker is an [`Emitter`] that gives no
//! light, with the form as its kind; its type, and the points of a path, are properties.
//!
//! In the file a marker is a volume that nothing refers to, which Mitsuba reads and ignores, with
//! `<default name="marker: form" value="box"/>` inside.

use bevy::math::Vec3;

use super::emitter::EmitterKind;
use super::properties::{Properties, PropertyItem, PropertyValue};
use crate::color::{Rgb, linear_from_srgb8};
use crate::scene::{Emitter, ItemType};

/// The `default` with the form of a marker.
pub(crate) const FORM: &str = "marker: form";
/// The prefix of the plugins of markers; what follows is the form in the file.
const PREFIX: &str = "marker";

/// The property with the type of a marker.
pub const TYPE: &str = "type";
/// The properties of a path: its points in the marker's own space, and whether it is a curve and comes back to its
/// beginning.
pub const POINTS: &str = "points";
/// Whether a path is a smooth curve.
pub const SMOOTH: &str = "smooth";
/// Whether a path comes back to its beginning.
pub const CLOSED: &str = "closed";

/// The pieces of a smooth curve between two of its points.
const PIECES: usize = 12;

declare_names! {
    /// The symbol at the place of a marker.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
    pub enum MarkerSymbol {
        /// A disk.
        #[default]
        Dot = "dot",
        /// A flag, of a place where things begin.
        Flag = "flag",
        /// A flash, of a place that triggers something.
        Bolt = "bolt",
        /// A square on its corner, of a place on a way.
        Diamond = "diamond",
        /// A note, of a sound.
        Note = "note",
        /// A star, of something to be found.
        Star = "star",
        /// A cross, of an end or a danger.
        Cross = "cross",
    }
}

/// The look of a type of markers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MarkerLook {
    /// Linear Rec. 709.
    pub color: Rgb,
    /// The symbol.
    pub symbol: MarkerSymbol,
}

/// The usual types with their colours (sRGB) and symbols.
const USUAL: [(&str, [u8; 3], MarkerSymbol); 6] = [
    ("spawn", [90, 200, 90], MarkerSymbol::Flag),
    ("trigger", [240, 150, 40], MarkerSymbol::Bolt),
    ("waypoint", [80, 160, 250], MarkerSymbol::Diamond),
    ("sound", [190, 120, 240], MarkerSymbol::Note),
    ("pickup", [250, 210, 60], MarkerSymbol::Star),
    ("hazard", [240, 80, 70], MarkerSymbol::Cross),
];

/// The colours (sRGB) of types that are not usual ones.
const OTHERS: [[u8; 3]; 6] = [
    [120, 210, 200],
    [230, 130, 180],
    [170, 200, 90],
    [150, 160, 230],
    [220, 180, 130],
    [190, 190, 190],
];

impl MarkerLook {
    /// The look of a type: as the properties `TYPE color` and `TYPE symbol` of the scene say, or the usual one.
    pub fn of(kind: &str, scene: &Properties) -> Self {
        let usual = USUAL.iter().find(|(name, ..)| *name == kind);
        let (bytes, symbol) = match usual {
            Some((_, bytes, symbol)) => (*bytes, *symbol),
            None => {
                let sum = kind
                    .bytes()
                    .fold(0_usize, |sum, byte| 31 * (sum % 1000) + usize::from(byte));
                let index = if kind.is_empty() {
                    OTHERS.len() - 1
                } else {
                    sum % (OTHERS.len() - 1)
                };
                (OTHERS[index], MarkerSymbol::default())
            }
        };
        let color = match scene.get(&format!("{kind} color")) {
            Some(PropertyValue::One(PropertyItem::Color(color))) => *color,
            _ => Rgb::from_array(bytes.map(linear_from_srgb8)),
        };
        let own = scene.get(&format!("{kind} symbol")).map(PropertyValue::text);
        let symbol = own.and_then(|name| MarkerSymbol::of_name(&name)).unwrap_or(symbol);
        Self { color, symbol }
    }

    /// The usual types.
    pub fn usual_types() -> impl Iterator<Item = &'static str> {
        USUAL.iter().map(|(name, ..)| *name)
    }
}

/// The type of a marker with these properties; empty without one.
pub fn type_of(properties: Option<&Properties>) -> String {
    let value = properties.and_then(|own| own.get(TYPE));
    value.map_or_else(String::new, PropertyValue::text)
}

/// The points of a path in its own space.
pub fn points_of(properties: Option<&Properties>) -> Vec<Vec3> {
    let items = properties
        .and_then(|own| own.get(POINTS))
        .map_or(&[][..], PropertyValue::items);
    let point = |item: &PropertyItem| match item {
        PropertyItem::Vector(point) => Some(*point),
        _ => None,
    };
    items.iter().filter_map(point).collect()
}

/// The points of a path as the value of its property.
pub fn points_value(points: &[Vec3]) -> PropertyValue {
    PropertyValue::List(
        ItemType::Vector,
        points.iter().map(|point| PropertyItem::Vector(*point)).collect(),
    )
}

fn is_set(properties: Option<&Properties>, name: &str) -> bool {
    let value = properties.and_then(|own| own.get(name));
    value == Some(&PropertyValue::One(PropertyItem::Boolean(true)))
}

/// The line of a path through its points in its own space. A smooth one is a Catmull-Rom spline (Catmull and Rom,
/// 1974), with the end points doubled unless it is closed.
pub fn line_of(properties: Option<&Properties>) -> Vec<Vec3> {
    let points = points_of(properties);
    let is_closed = is_set(properties, CLOSED) && points.len() > 2;
    if points.len() < 2 {
        return points;
    }
    let count = points.len() as isize;
    let at = |index: isize| match is_closed {
        true => points[index.rem_euclid(count) as usize],
        false => points[index.clamp(0, count - 1) as usize],
    };
    let legs = if is_closed { count } else { count - 1 };
    let pieces = if is_set(properties, SMOOTH) { PIECES } else { 1 };
    let mut line = vec![at(0)];
    for leg in 0..legs {
        let [a, b, c, d] = [leg - 1, leg, leg + 1, leg + 2].map(at);
        for piece in 1..pieces {
            let t = piece as f32 / pieces as f32;
            let rest = (2.0 * a - 5.0 * b + 4.0 * c - d) + (3.0 * b - a - 3.0 * c + d) * t;
            line.push(b + 0.5 * t * ((c - a) + t * rest));
        }
        line.push(c);
    }
    line
}

impl Emitter {
    /// Whether it is a marker, which gives no light.
    pub fn is_marker(&self) -> bool {
        self.form().is_some()
    }

    /// The form of a marker in the file; None for anything else.
    pub(crate) fn form(&self) -> Option<&'static str> {
        match self.kind {
            EmitterKind::MarkerPoint | EmitterKind::MarkerBox | EmitterKind::MarkerSphere | EmitterKind::MarkerPath => {
                self.plugin().strip_prefix(PREFIX)
            }
            _ => None,
        }
    }

    /// The marker of this form.
    pub(in crate::scene) fn of_form(form: &str) -> Option<Self> {
        Self::of_plugin(&format!("{PREFIX}{form}"))
    }

    /// The forms of markers in the file.
    pub(in crate::scene) fn forms() -> impl Iterator<Item = &'static str> {
        Self::PLUGINS
            .into_iter()
            .filter_map(|plugin| plugin.strip_prefix(PREFIX))
    }

    /// The properties of a new marker: its type, and the points of a path.
    pub(crate) fn new_properties(&self) -> Option<Properties> {
        let text = |text: &str| PropertyValue::One(PropertyItem::Text(text.to_owned()));
        let kind = match self.kind {
            EmitterKind::MarkerPoint => "spawn",
            EmitterKind::MarkerBox | EmitterKind::MarkerSphere => "trigger",
            EmitterKind::MarkerPath => "waypoint",
            _ => return None,
        };
        let own = Properties::default().with(TYPE, Some(text(kind)));
        let is_path = self.kind == EmitterKind::MarkerPath;
        Some(match is_path {
            true => own.with(POINTS, Some(points_value(&[Vec3::NEG_X, Vec3::ZERO, Vec3::X]))),
            false => own,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_path_goes_through_its_points() {
        let points = [Vec3::ZERO, Vec3::X, Vec3::new(2.0, 1.0, 0.0)];
        let truth = Some(PropertyValue::One(PropertyItem::Boolean(true)));
        let straight = Properties::default().with(POINTS, Some(points_value(&points)));
        assert_eq!(line_of(Some(&straight)), points);
        let smooth = straight.with(SMOOTH, truth.clone());
        let line = line_of(Some(&smooth));
        assert_eq!(line.len(), 2 * PIECES + 1);
        assert_eq!([line[0], line[PIECES], line[2 * PIECES]], points);
        // Its direction at an inner point is that from one neighbour to the other.
        let step = line[PIECES + 1] - line[PIECES - 1];
        assert!(step.normalize().abs_diff_eq((points[2] - points[0]).normalize(), 0.02));
        let closed = line_of(Some(&straight.with(CLOSED, truth)));
        assert_eq!(closed, [points[0], points[1], points[2], points[0]]);
        assert!(line_of(None).is_empty());
    }

    #[test]
    fn types_have_looks_that_the_scene_may_change() {
        let scene = Properties::default();
        let spawn = MarkerLook::of("spawn", &scene);
        assert_eq!(spawn.symbol, MarkerSymbol::Flag);
        assert_ne!(MarkerLook::of("boss", &scene).color, spawn.color);
        let scene = scene
            .with("boss color", Some(PropertyValue::One(PropertyItem::Color(Rgb::X))))
            .with(
                "boss symbol",
                Some(PropertyValue::One(PropertyItem::Text("star".into()))),
            );
        let boss = MarkerLook::of("boss", &scene);
        assert_eq!((boss.color, boss.symbol), (Rgb::X, MarkerSymbol::Star));
    }

    #[test]
    fn every_form_is_that_of_a_marker() {
        assert_eq!(Emitter::forms().collect::<Vec<_>>(), ["point", "box", "sphere", "path"]);
        for form in Emitter::forms() {
            let marker = Emitter::of_form(form).expect(form);
            assert!(marker.is_marker() && !marker.shines() && marker.new_properties().is_some());
        }
        assert!(!Emitter::default().is_marker());
    }
}
