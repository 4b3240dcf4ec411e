//! The scene as a value, to be compared before and after undo, redo, saving and loading.

use bevy::prelude::*;

use crate::scene::description::{Identity, SceneDescription};
use crate::scene::write::gather;
use crate::scene::{DocumentOrder, Hidden, Locked};

/// The part of a scene that edits can change, without entities: two snapshots are equal if and only if their scenes
/// are.
#[derive(Clone, Debug, PartialEq)]
pub struct Snapshot {
    scene: SceneDescription,
    /// The name, and whether the thing is hidden and locked.
    marks: Vec<(String, bool, bool)>,
}

impl Snapshot {
    /// Describes the scene of a world as saving would.
    pub fn of(world: &mut World) -> Self {
        let mut marks: Vec<(String, bool, bool)> = world
            .query_filtered::<(&Name, Has<Hidden>, Has<Locked>), With<DocumentOrder>>()
            .iter(world)
            .map(|(name, hidden, locked)| (name.to_string(), hidden, locked))
            .collect();
        marks.sort();
        Self {
            scene: gather::describe(world),
            marks,
        }
    }

    /// The shapes with their materials, the lights, sensors and all other materials, each as a text, sorted. It leaves
    /// out data that saving and reloading renew: names and ids that files give to things, the numbers of their order,
    /// and the text that the file has for each.
    pub fn contents(&self) -> Vec<String> {
        let scene = &self.scene;
        let material = |index: &Option<usize>| index.map(|index| self.material(index));
        let medium = |index: &Option<usize>| index.map(|index| &scene.media[index].medium);
        let shapes = scene.shapes.iter().map(|it| {
            format!(
                "shape {:?} {:?} {:?} {:?} {:?}, material {:?}, media {:?} {:?}",
                it.identity.keys,
                it.shape,
                it.to_world,
                it.area_light,
                it.placements,
                material(&it.material),
                medium(&it.interior),
                medium(&it.exterior)
            )
        });
        let materials = (0..scene.materials.len()).map(|index| self.material(index));
        let emitters = scene
            .emitters
            .iter()
            .map(|it| format!("emitter {:?} {:?} {:?}", it.emitter, it.to_world, medium(&it.medium)));
        let sensors = scene.sensors.iter().map(|it| {
            format!(
                "sensor {:?} {:?} {:?} {:?}",
                it.sensor,
                it.film,
                it.to_world,
                medium(&it.medium)
            )
        });
        let rest = [format!("{} groups, {:?}", scene.groups.len(), scene.integrator)];
        let mut all: Vec<String> = shapes
            .chain(materials)
            .chain(emitters)
            .chain(sensors)
            .chain(rest)
            .collect();
        all.sort();
        all
    }

    /// A material with nested ones, which form no cycle.
    fn material(&self, index: usize) -> String {
        let material = &self.scene.materials[index];
        let inside = [material.first, material.second].map(|inside| inside.map(|inside| self.material(inside)));
        format!("{:?} {inside:?}", material.material)
    }

    /// The number of things.
    pub fn things(&self) -> usize {
        self.marks.len()
    }

    /// The numbers of shapes, emitters, sensors and groups. Materials that nothing uses are not saved.
    pub fn counts(&self) -> [usize; 4] {
        let scene = &self.scene;
        [
            scene.shapes.len(),
            scene.emitters.len(),
            scene.sensors.len(),
            scene.groups.len(),
        ]
    }

    /// The first difference of the [contents](Self::contents) to those of another, in words.
    pub(crate) fn difference_of_contents(&self, other: &Self) -> Option<String> {
        let (one, two) = (self.contents(), other.contents());
        let differs = one.iter().zip(&two).find(|(one, two)| one != two);
        let differs = differs.map(|(one, two)| format!("{one} | {two}"));
        differs.or_else(|| (one.len() != two.len()).then(|| format!("{} things | {}", one.len(), two.len())))
    }

    /// The first difference to another, in words; None if they are equal.
    pub fn difference(&self, other: &Self) -> Option<String> {
        fn first<T: PartialEq + std::fmt::Debug>(
            what: &str,
            one: &[T],
            other: &[T],
            identity: impl Fn(&T) -> &Identity,
        ) -> Option<String> {
            if let Some((one, other)) = one.iter().zip(other).find(|(one, other)| one != other) {
                let name = &identity(one).name;
                return Some(format!("{what} `{name}` differs: {one:?} | {other:?}"));
            }
            let names = |list: &[T]| list.iter().map(|it| identity(it).name.clone()).collect::<Vec<_>>();
            (one.len() != other.len()).then(|| format!("{what}: {:?} | {:?}", names(one), names(other)))
        }
        let (one, two) = (&self.scene, &other.scene);
        first("shape", &one.shapes, &two.shapes, |it| &it.identity)
            .or_else(|| first("material", &one.materials, &two.materials, |it| &it.identity))
            .or_else(|| first("emitter", &one.emitters, &two.emitters, |it| &it.identity))
            .or_else(|| first("sensor", &one.sensors, &two.sensors, |it| &it.identity))
            .or_else(|| first("group", &one.groups, &two.groups, |it| &it.identity))
            .or_else(|| {
                let marks = self.marks.iter().zip(&other.marks).find(|(one, other)| one != other);
                marks.map(|(one, other)| format!("name, hidden, locked: {one:?} | {other:?}"))
            })
            .or_else(|| {
                (one.integrator != two.integrator)
                    .then(|| format!("integrator: {:?} | {:?}", one.integrator, two.integrator))
            })
            .or_else(|| (self != other).then(|| "something else of the scene differs".to_owned()))
    }
}
