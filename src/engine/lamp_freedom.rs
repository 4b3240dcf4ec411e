//! Lamps in other places and suns at other times, without a change of the scene: the search for the light that is
//! wanted tries them.

use bevy::math::{Affine3A, Quat, Vec3};
use bevy::prelude::{Entity, World};

use super::light_groups::Lamps;
use crate::inverse_lighting::Range;
use crate::light::{LightId, LightSource, WeightedSource};
use crate::render::scene::RenderScene;
use crate::scene::{Emitter, EmitterKind, PlaceAndTime, Shape, SunPosition, SunSky, ToWorld};

/// The share of what is allowed that still makes a difference to a place or an aim.
const FINE: f64 = 1.0 / 512.0;
/// Hours that make a difference: a minute.
const MINUTE: f64 = 1.0 / 60.0;
/// The days over which the sun's path changes enough to measure.
const DAYS: f64 = 4.0;

/// The quantities of a lamp that may change besides its strength and colour.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LampFreedom {
    /// How far it may move from its place, in units of the world; at least 0.
    pub radius: f32,
    /// The degrees by which its axis may turn, from 0 to 90.
    pub turn: f32,
    /// The hours between which a sun by date, time and place may stand; None: its hour stays.
    pub hours: Option<[f32; 2]>,
    /// Whether the day of the year of such a sun may change.
    pub day: bool,
}

/// What can change of a lamp, by its kind.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FreedomKind {
    /// Nothing: it shines from all around.
    Nothing,
    /// Its place: it shines in all directions.
    Place,
    /// Its direction: it shines from far away.
    Aim,
    /// Its place and its direction.
    Pose,
    /// The hour and the day.
    Sun,
}

impl Lamps {
    /// What can change of the lamp of an entity.
    pub fn freedom(&self, owner: Entity) -> FreedomKind {
        let lights = self.of(owner);
        let kind = |light: &LightSource| match light {
            LightSource::Point { .. } => FreedomKind::Place,
            LightSource::Directional { .. } => FreedomKind::Aim,
            LightSource::Surface { .. }
            | LightSource::Spot(_)
            | LightSource::Luminaire(_)
            | LightSource::Projector(_) => FreedomKind::Pose,
            LightSource::SunSky { .. } => FreedomKind::Sun,
            LightSource::Constant { .. } | LightSource::Environment { .. } => FreedomKind::Nothing,
        };
        lights
            .first()
            .map_or(FreedomKind::Nothing, |(_, light)| kind(&light.source))
    }
}

/// A lamp after a change.
#[derive(Clone, Debug, PartialEq)]
pub enum LampChange {
    /// A rigid motion of the world.
    Motion(Affine3A),
    /// Sun and sky at another time.
    Sun(Box<SunSky>),
}

/// A lamp that may change.
#[derive(Clone, Debug)]
pub struct FreeLamp {
    /// The lamp.
    pub entity: Entity,
    lights: Vec<(LightId, WeightedSource)>,
    kind: Kind,
}

#[derive(Clone, Debug)]
enum Kind {
    Posed {
        place: Vec3,
        /// Unit vectors across the axis.
        across: [Vec3; 2],
        radius: f32,
        turn: f32,
    },
    Sun {
        sky: Box<SunSky>,
        at: PlaceAndTime,
        hours: Option<[f32; 2]>,
        day: bool,
    },
}

impl LampFreedom {
    /// Whether nothing may change.
    pub fn is_none(&self) -> bool {
        *self == Self::default()
    }

    /// Whether its numbers are in range.
    pub fn is_valid(&self) -> bool {
        let are_hours = |[from, to]: [f32; 2]| 0.0 <= from && from < to && to <= 24.0;
        self.radius.is_finite()
            && self.radius >= 0.0
            && (0.0..=90.0).contains(&self.turn)
            && self.hours.is_none_or(are_hours)
    }
}

impl FreeLamp {
    /// A lamp of the packed scene. The error is the end of a sentence that begins with the lamp.
    pub fn new(world: &World, lamps: &Lamps, entity: Entity, freedom: LampFreedom) -> Result<Self, &'static str> {
        let lights = lamps.of(entity);
        if lights.is_empty() {
            return Err("does not shine");
        }
        let LampFreedom {
            radius,
            turn,
            hours,
            day,
        } = freedom;
        let kind = match lamps.freedom(entity) {
            FreedomKind::Sun => sun(world, entity, hours, day)?,
            _ if hours.is_some() || day => return Err("is no sun, and has no hour and no day"),
            FreedomKind::Place => posed(world, entity, radius, 0.0)?,
            FreedomKind::Aim => posed(world, entity, 0.0, turn)?,
            FreedomKind::Pose => posed(world, entity, radius, turn)?,
            FreedomKind::Nothing => return Err("shines from all around, and can neither move nor be aimed"),
        };
        let lamp = Self { entity, lights, kind };
        match lamp.ranges().is_empty() {
            true => Err("cannot change in this way"),
            false => Ok(lamp),
        }
    }

    /// The numbers that may change, for [`Self::change`].
    pub fn ranges(&self) -> Vec<Range> {
        let around_zero = |most: f32| {
            let most = f64::from(most);
            Range {
                present: 0.0,
                least: -most,
                most,
                step: 2.0 * most * FINE,
            }
        };
        let mut ranges = Vec::new();
        match &self.kind {
            Kind::Posed { radius, turn, .. } => {
                ranges.extend([*radius; 3].into_iter().filter(|radius| *radius > 0.0).map(around_zero));
                ranges.extend([*turn; 2].into_iter().filter(|turn| *turn > 0.0).map(around_zero));
            }
            Kind::Sun { at, hours, day, .. } => {
                if let Some([least, most]) = hours.map(|hours| hours.map(f64::from)) {
                    ranges.push(Range {
                        present: hour_of(at).rem_euclid(24.0).clamp(least, most),
                        least,
                        most,
                        step: MINUTE,
                    });
                }
                if *day {
                    ranges.push(Range {
                        present: day_of_year(at),
                        least: 1.0,
                        most: 365.0,
                        step: DAYS,
                    });
                }
            }
        }
        ranges
    }

    /// The lamp with other numbers, in the order of [`Self::ranges`].
    pub fn change(&self, values: &[f64]) -> LampChange {
        let mut values = values.iter().copied();
        match &self.kind {
            Kind::Posed {
                place,
                across,
                radius,
                turn,
            } => {
                let mut number = |is_free: bool| {
                    if is_free {
                        values.next().unwrap_or(0.0) as f32
                    } else {
                        0.0
                    }
                };
                let mut of_radius = || number(*radius > 0.0);
                let offset = Vec3::new(of_radius(), of_radius(), of_radius()).clamp_length_max(*radius);
                let mut of_turn = || number(*turn > 0.0);
                let turned = (of_turn() * across[0] + of_turn() * across[1]).clamp_length_max(*turn);
                let turned = Quat::from_scaled_axis(turned * 1.0_f32.to_radians());
                let there = Affine3A::from_translation(*place + offset);
                LampChange::Motion(there * Affine3A::from_quat(turned) * Affine3A::from_translation(-*place))
            }
            Kind::Sun { sky, at, hours, day } => {
                let mut at = *at;
                if hours.is_some()
                    && let Some(hour) = values.next()
                {
                    let minutes = (hour * 60.0).round();
                    at.hour = (minutes / 60.0).floor() as f32;
                    at.minute = (minutes - 60.0 * f64::from(at.hour)) as f32;
                    at.second = 0.0;
                }
                if *day && let Some(day) = values.next() {
                    (at.month, at.day) = date_of(at.year, day.round() as i32);
                }
                LampChange::Sun(Box::new(SunSky {
                    sun: SunPosition::PlaceAndTime(at),
                    ..**sky
                }))
            }
        }
    }

    /// The scene with the light of this lamp alone after a change; None if it does not shine then.
    pub fn alone(&self, scene: &RenderScene, change: &LampChange) -> Option<RenderScene> {
        let mut lights = self.lights.clone();
        let mut scene = scene.clone();
        match change {
            LampChange::Motion(motion) => {
                let mut shapes = Vec::new();
                for (_, light) in &mut lights {
                    match &light.source {
                        LightSource::Surface { instance, .. } => shapes.push(*instance),
                        other => light.source = other.moved(*motion)?,
                    }
                }
                shapes.sort_unstable();
                shapes.dedup();
                if !shapes.is_empty() {
                    scene = scene.with_shapes_moved(&shapes, *motion)?;
                }
            }
            LampChange::Sun(sky) => {
                for (_, light) in &mut lights {
                    if let LightSource::SunSky {
                        atmosphere,
                        world_from_local,
                    } = &mut light.source
                    {
                        *atmosphere = sky.atmosphere(*world_from_local)?;
                    }
                }
            }
        }
        Some(scene.lit_by_own(&lights))
    }
}

fn posed(world: &World, entity: Entity, radius: f32, turn: f32) -> Result<Kind, &'static str> {
    let Some(ToWorld(to_world)) = world.get::<ToWorld>(entity) else {
        return Err("has no place");
    };
    let middle = world.get::<Shape>(entity).map_or(Vec3::ZERO, Shape::middle);
    let place = to_world.transform_point3(middle);
    let axis = Vec3::from(to_world.matrix3.z_axis).normalize_or(Vec3::Z);
    let across = axis.any_orthonormal_pair();
    Ok(Kind::Posed {
        place,
        across: [across.0, across.1],
        radius,
        turn,
    })
}

fn sun(world: &World, entity: Entity, hours: Option<[f32; 2]>, day: bool) -> Result<Kind, &'static str> {
    let Some(EmitterKind::SunSky(sky)) = world.get::<Emitter>(entity).map(|emitter| &emitter.kind) else {
        return Err("is no sun any more");
    };
    match sky.sun {
        SunPosition::PlaceAndTime(at) => Ok(Kind::Sun {
            sky: Box::new(*sky),
            at,
            hours,
            day,
        }),
        SunPosition::Direction(_) => Err("has its sun in a direction: give it a place and a time first"),
    }
}

/// The hour of local time with its minutes and seconds.
fn hour_of(at: &PlaceAndTime) -> f64 {
    f64::from(at.hour) + f64::from(at.minute) / 60.0 + f64::from(at.second) / 3600.0
}

fn days_of_months(year: i32) -> [i32; 12] {
    let is_leap = year % 4 == 0 && (year % 100 != 0 || year % 400 == 0);
    let february = if is_leap { 29 } else { 28 };
    [31, february, 31, 30, 31, 30, 31, 31, 30, 31, 30, 31]
}

/// The day of the year, from 1 to 365.
fn day_of_year(at: &PlaceAndTime) -> f64 {
    let before = (at.month - 1).clamp(0, 11) as usize;
    let days: i32 = days_of_months(at.year)[..before].iter().sum();
    f64::from((days + at.day).clamp(1, 365))
}

/// The month and the day of the month, both from 1.
fn date_of(year: i32, day_of_year: i32) -> (i32, i32) {
    let mut left = day_of_year.max(1);
    for (month, days) in (1..).zip(days_of_months(year)) {
        if left <= days {
            return (month, left);
        }
        left -= days;
    }
    (12, 31)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dates_and_days_of_the_year_belong_together() {
        for year in [2000, 2010, 2100] {
            for day in 1..=365 {
                let (month, day_of_month) = date_of(year, day);
                let at = PlaceAndTime {
                    year,
                    month,
                    day: day_of_month,
                    ..PlaceAndTime::default()
                };
                assert_eq!(day_of_year(&at), f64::from(day), "{year}-{month}-{day_of_month}");
            }
        }
        assert_eq!(date_of(2010, 59), (2, 28));
        assert_eq!(date_of(2012, 60), (2, 29));
        assert_eq!(date_of(2010, 365), (12, 31));
    }
}
