//! The light of an area of the picture by the things of the scene: which lamp, by way of what, and in which words.

use std::collections::HashMap;
use std::sync::Arc;

use bevy::prelude::*;

use super::layers::name_by;
use super::light_groups::Lamps;
use super::packed_scene::PackedScene;
use crate::light::LightId;
use crate::medium::MediumId;
use crate::render::breakdown::{Breakdown, Kind, Portion, Route, Source, Way};
use crate::render::scene::RenderScene;
use crate::scene::{DocumentOrder, Emitter, SceneId};

/// An emitter of the scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Lamp {
    /// A light, a shape or a medium that shines; of an emitter that is sky and sun, the sky.
    Thing(Entity),
    /// The sun of an emitter that is sky and sun.
    Sun(Entity),
    /// An emitter that is no longer in the scene.
    Unknown,
}

/// The last thing from which light has come to the place that is seen.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Via {
    /// The lamp itself is in view.
    View,
    /// The light has come straight from the lamp.
    Straight,
    /// The light has come straight through this thing, a pane for example.
    Pane(Entity),
    /// This thing has reflected or scattered it.
    Thing(Entity),
    /// It has gone through this thing, and was scattered there.
    Through(Entity),
    /// One of very many things, or one that is no longer in the scene.
    Other,
}

declare_names! {
    /// A grouping of light.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
    pub enum Grouping {
        /// By lamp and last thing.
        #[default]
        Route = "route" => "Lamp and way",
        /// By lamp.
        Lamp = "lamp" => "Lamp",
        /// By the last thing from which it has come.
        Way = "way" => "Last thing",
        /// By the number of bounces.
        Bounces = "bounces" => "Bounces",
        /// By the kind of scattering.
        Kind = "kind" => "Kind",
    }
}

/// A group of light in one of the groupings.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Group {
    /// A group of [`Grouping::Route`].
    Route(Lamp, Via),
    /// A group of [`Grouping::Lamp`].
    Lamp(Lamp),
    /// A group of [`Grouping::Way`].
    Way(Via),
    /// A group of [`Grouping::Bounces`]; the last one of [`MOST_BOUNCES`] has all longer routes.
    Bounces(u32),
    /// A group of [`Grouping::Kind`].
    Kind(Kind),
}

/// The most bounces that are told apart.
pub const MOST_BOUNCES: u32 = 8;

/// The entities behind the ids of a packed scene.
#[derive(Clone, Debug, Default)]
pub struct Things {
    instances: Arc<[Entity]>,
    lamps: Arc<Lamps>,
    media: HashMap<MediumId, Entity>,
}

impl Things {
    /// The things of a packed scene.
    pub fn of(packed: &PackedScene) -> Self {
        let media = packed.medium_of_entity.iter();
        Self {
            instances: packed.entity_of_instance.clone(),
            lamps: packed.lamps.clone(),
            media: media.map(|(&entity, &id)| (id, entity)).collect(),
        }
    }

    /// The entity of an instance, as [`crate::accel::Hit::instance`] counts them.
    pub fn instance(&self, instance: u32) -> Option<Entity> {
        self.instances.get(instance as usize).copied()
    }

    fn lamp(&self, source: Source) -> Lamp {
        let owner = |light: LightId| self.lamps.owners.get(light.0 as usize).copied();
        let found = match source {
            Source::Light(light) => owner(light).map(Lamp::Thing),
            Source::Sun(light) => owner(light).map(Lamp::Sun),
            Source::Medium(medium) => self.media.get(&medium).copied().map(Lamp::Thing),
        };
        found.unwrap_or(Lamp::Unknown)
    }

    fn via(&self, route: &Route) -> Via {
        let found = match route.way {
            Way::Straight { .. } if route.bounces == 0 => Some(Via::View),
            Way::Straight { through: None } => Some(Via::Straight),
            Way::Straight { through: Some(pane) } => self.instance(pane).map(Via::Pane),
            Way::Surface { instance, is_through } => self.instance(instance).map(match is_through {
                true => Via::Through,
                false => Via::Thing,
            }),
            Way::Medium(medium) => self.media.get(&medium).copied().map(Via::Thing),
            Way::Other => None,
        };
        found.unwrap_or(Via::Other)
    }

    /// The group of a route.
    pub fn group(&self, grouping: Grouping, route: &Route) -> Group {
        match grouping {
            Grouping::Route => Group::Route(self.lamp(route.source), self.via(route)),
            Grouping::Lamp => Group::Lamp(self.lamp(route.source)),
            Grouping::Way => Group::Way(self.via(route)),
            Grouping::Bounces => Group::Bounces(route.bounces.min(MOST_BOUNCES)),
            Grouping::Kind => Group::Kind(route.kind),
        }
    }

    /// Whether the light of a route is in this group.
    pub fn has(&self, group: Group, route: &Route) -> bool {
        self.group(group.grouping(), route) == group
    }

    /// The light by groups, the brightest first.
    pub fn portions(&self, breakdown: &Breakdown, grouping: Grouping) -> Vec<Portion<Group>> {
        breakdown.portions(|route| Some(self.group(grouping, route)))
    }

    /// `scene` with the light of the lamps of `owner` alone; None if it has none. Only paths from the lights can be
    /// traced in it.
    pub fn lit_by(&self, scene: &RenderScene, owner: Entity) -> Option<RenderScene> {
        let all = self.lamps.owners.iter().zip(&self.lamps.sources);
        let own: Vec<_> = all
            .filter(|(one, _)| **one == owner)
            .map(|(_, source)| source.clone())
            .collect();
        (!own.is_empty()).then(|| scene.lit_by(&own))
    }

    /// The entities that shine.
    pub fn shining(&self) -> &[Entity] {
        &self.lamps.owners
    }

    /// The entities of media, in no order.
    pub fn media(&self) -> impl Iterator<Item = Entity> {
        self.media.values().copied()
    }
}

impl Group {
    /// The grouping that it is a group of.
    pub fn grouping(self) -> Grouping {
        match self {
            Self::Route(..) => Grouping::Route,
            Self::Lamp(_) => Grouping::Lamp,
            Self::Way(_) => Grouping::Way,
            Self::Bounces(_) => Grouping::Bounces,
            Self::Kind(_) => Grouping::Kind,
        }
    }

    /// The things that its sentence names, in their order there.
    pub fn things(self) -> Vec<Entity> {
        let (lamp, via) = match self {
            Self::Route(lamp, via) => (Some(lamp), Some(via)),
            Self::Lamp(lamp) => (Some(lamp), None),
            Self::Way(via) => (None, Some(via)),
            Self::Bounces(_) | Self::Kind(_) => (None, None),
        };
        let lamp = lamp.and_then(|lamp| match lamp {
            Lamp::Thing(entity) | Lamp::Sun(entity) => Some(entity),
            Lamp::Unknown => None,
        });
        let via = via.and_then(|via| match via {
            Via::Pane(entity) | Via::Thing(entity) | Via::Through(entity) => Some(entity),
            Via::View | Via::Straight | Via::Other => None,
        });
        lamp.into_iter().chain(via).collect()
    }

    /// The group in words, such as `desk lamp by way of the wall`. `name` gives the name of a thing.
    pub fn text(self, name: &impl Fn(Entity) -> String) -> String {
        let words: Vec<String> = self.words(name).into_iter().map(|(word, _)| word).collect();
        words.join(" ")
    }

    /// The words of [`Self::text`] in pieces, with the thing that a piece names.
    pub fn words(self, name: &impl Fn(Entity) -> String) -> Vec<(String, Option<Entity>)> {
        let plain = |text: &str| (text.to_owned(), None);
        let link = |entity| (name(entity), Some(entity));
        let of_lamp = |lamp| match lamp {
            Lamp::Thing(entity) => vec![link(entity)],
            Lamp::Sun(entity) => vec![plain("sun of"), link(entity)],
            Lamp::Unknown => vec![plain("a lamp that is gone")],
        };
        let of_via = |via| match via {
            Via::View => vec![plain("in view")],
            Via::Straight => vec![plain("directly")],
            Via::Pane(entity) | Via::Through(entity) => vec![plain("through"), link(entity)],
            Via::Thing(entity) => vec![plain("by way of"), link(entity)],
            Via::Other => vec![plain("by way of other things")],
        };
        match self {
            Self::Route(lamp, via) => [of_lamp(lamp), of_via(via)].concat(),
            Self::Lamp(lamp) => of_lamp(lamp),
            Self::Way(via) => of_via(via),
            Self::Bounces(0) => vec![plain("in view, without a bounce")],
            Self::Bounces(1) => vec![plain("1 bounce")],
            Self::Bounces(MOST_BOUNCES) => vec![plain(&format!("{MOST_BOUNCES} bounces and more"))],
            Self::Bounces(count) => vec![plain(&format!("{count} bounces"))],
            Self::Kind(kind) => vec![plain(kind.label())],
        }
    }
}

/// The components that name a thing.
pub type NameParts = (
    Option<&'static SceneId>,
    Option<&'static Name>,
    Option<&'static DocumentOrder>,
    Option<&'static Emitter>,
);

/// The name of a thing in reports: its id, or else its name or its kind with its index in the file.
pub fn thing_name(world: &World, entity: Entity) -> String {
    let parts = (
        world.get(entity),
        world.get(entity),
        world.get(entity),
        world.get(entity),
    );
    thing_name_by(parts)
}

/// [`thing_name`] by the [`NameParts`] of the thing.
pub fn thing_name_by(
    (id, name, order, emitter): (
        Option<&SceneId>,
        Option<&Name>,
        Option<&DocumentOrder>,
        Option<&Emitter>,
    ),
) -> String {
    let kind = emitter.map_or("thing", |emitter| emitter.info().label);
    match (id, name, order) {
        // Such a name is that of a kind, which many things may have.
        (None, Some(name), Some(order)) => format!("{name} {}", order.0),
        _ => name_by(id, name, order, kind),
    }
}

/// The sentence about a place at which no path has found light.
pub const NO_LIGHT: &str = "No path found light here: all that it sees is dark, or the light comes on ways that path \
    tracing hardly finds, such as through glass from a small lamp.";
/// The sentence about a lamp none of whose light arrives at a thing.
pub const NOTHING_LIT: &str = "None of its light arrives at a thing: the lamp is black, or nothing is in its way.";

/// Groups with a smaller share are not listed.
const LEAST_SHARE: f32 = 0.002;
/// The most groups that are listed.
const MOST_GROUPS: usize = 12;

/// Splits groups, the brightest first, into the groups that a report lists, and the many or small ones whose sum it
/// gives.
pub fn listed<T>(groups: &[T], share: impl Fn(&T) -> f32) -> (&[T], &[T]) {
    let is_listed = |group: &&T| share(group) >= LEAST_SHARE;
    let count = groups.iter().take(MOST_GROUPS).take_while(is_listed).count();
    groups.split_at(count)
}

/// A share with its standard error in percent: whole where the error is 1 % or more, else with tenths. The error is
/// rounded up; none is written if it is rounding.
pub fn percent(share: f32, error: f32) -> String {
    // Single precision does not make an error of 0.1 % one of 0.2 %.
    const ROUNDING: f64 = 1e-5;
    let [share, error] = [share, error].map(|part| 100.0 * f64::from(part));
    // A share that rounds to zero has no sign.
    let digits = if error >= 1.0 { 1.0 } else { 10.0 };
    let share = if (digits * share).round() == 0.0 { 0.0 } else { share };
    match error {
        ..=ROUNDING => format!("{share:.1} %"),
        1.0.. => format!("{share:.0} ± {:.0} %", (error - ROUNDING).ceil()),
        _ => format!("{share:.1} ± {:.1} %", (10.0 * error - ROUNDING).ceil() / 10.0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_have_the_digits_of_their_errors() {
        for (share, error, text) in [
            (1.0, 0.0, "100.0 %"),
            (0.25, 3e-9, "25.0 %"),
            (0.4123, 0.0161, "41 ± 2 %"),
            (0.4123, 0.0042, "41.2 ± 0.5 %"),
            (0.0601, 0.0001, "6.0 ± 0.1 %"),
            (-0.001, 0.02, "0 ± 2 %"),
            (-0.0001, 0.001, "0.0 ± 0.1 %"),
            (-0.011, 0.02, "-1 ± 2 %"),
        ] {
            assert_eq!(percent(share, error), text);
        }
    }

    #[test]
    fn things_of_one_kind_are_told_apart() {
        let (id, name, order) = (SceneId("desk lamp".into()), Name::new("sphere"), DocumentOrder(3));
        let parts = |id, name| (id, name, Some(&order), None);
        assert_eq!(thing_name_by(parts(Some(&id), Some(&name))), "desk lamp");
        assert_eq!(thing_name_by(parts(None, Some(&name))), "sphere 3");
        assert_eq!(thing_name_by(parts(None, None)), "thing 3");
    }

    #[test]
    fn groups_have_sentences_with_the_things_in_them() {
        let mut world = World::new();
        let [lamp, wall] = [world.spawn_empty().id(), world.spawn_empty().id()];
        let name = |entity| if entity == lamp { "desk lamp" } else { "red wall" }.to_owned();
        for (group, text, things) in [
            (
                Group::Route(Lamp::Thing(lamp), Via::Thing(wall)),
                "desk lamp by way of red wall",
                &[lamp, wall][..],
            ),
            (
                Group::Route(Lamp::Sun(lamp), Via::Straight),
                "sun of desk lamp directly",
                &[lamp],
            ),
            (
                Group::Route(Lamp::Unknown, Via::View),
                "a lamp that is gone in view",
                &[],
            ),
            (Group::Way(Via::Pane(wall)), "through red wall", &[wall]),
            (Group::Bounces(1), "1 bounce", &[]),
            (Group::Bounces(MOST_BOUNCES), "8 bounces and more", &[]),
            (Group::Kind(Kind::Glass), "glass", &[]),
        ] {
            assert_eq!(group.text(&name), text);
            assert_eq!(group.things(), things);
        }
    }
}
