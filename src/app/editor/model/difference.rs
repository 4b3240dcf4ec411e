//! Finds the values that differ among several selected things.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use bevy::math::{Affine3A, Vec3, Vec3A};
use bevy::reflect::{PartialReflect, ReflectRef};

use super::Inspected;
use super::mixed::Mixed;
use crate::app::editor::command::media::MediumSide;
use crate::scene::{Declared, FileValue, Material, Medium, Properties};

impl Inspected {
    /// Marks values that differ in the other selected things. `materials`: the materials of each of the others, by
    /// their paths.
    pub(crate) fn compared(mut self, others: &[Self], materials: &[Vec<(Vec<usize>, &Material)>]) -> Self {
        self.mixed = Mixed::of(&self, others);
        for entry in &mut self.materials {
            let path = &entry.path;
            let alike = materials
                .iter()
                .filter_map(|other| other.iter().find(|(its, _)| its == path));
            entry.mixed = Mixed::of_materials(&entry.material, alike.map(|(_, material)| *material));
        }
        self
    }
}

impl Mixed {
    /// The values that differ among these things, the first of which is shown.
    pub fn of(shown: &Inspected, others: &[Inspected]) -> Self {
        let mut found = BTreeSet::new();
        for other in others {
            poses(shown, other, &mut found);
            if shown.shape.is_some() && other.shape.is_some() {
                if shown.uses_material != other.uses_material {
                    found.insert("uses_material".to_owned());
                }
                if shown.area_light.is_some() != other.area_light.is_some() {
                    found.insert("area_light".to_owned());
                }
            }
            for side in MediumSide::ALL {
                let place = side as usize;
                if shown.has_side(side) && other.has_side(side) && shown.media_at[place] != other.media_at[place] {
                    found.insert(side.name().to_owned());
                }
            }
            if let (Some(own), Some(its)) = (&shown.properties, &other.properties) {
                properties(own, its, &mut found);
            }
            both(&shown.shape, &other.shape, &mut found);
            if let (Some(own), Some(its)) = (&shown.area_light, &other.area_light) {
                Values::of("area", own).compare(&Values::of("area", its), &mut found);
            }
            if let (Some(own), Some(its)) = (&shown.emitter, &other.emitter) {
                Values::of(own.plugin(), own).compare(&Values::of(its.plugin(), its), &mut found);
            }
            both(&shown.sensor, &other.sensor, &mut found);
            both(&shown.film, &other.film, &mut found);
        }
        Self(Arc::new(found))
    }

    /// The values that differ among media; the panel shows the first of them.
    pub(crate) fn of_media<'m>(shown: &Medium, others: impl Iterator<Item = &'m Medium>) -> Self {
        let mut found = BTreeSet::new();
        let own = Values::of_medium(shown);
        for other in others {
            own.compare(&Values::of_medium(other), &mut found);
            if shown.phase.plugin() != other.phase.plugin() {
                found.insert("phase".to_owned());
            }
        }
        Self(Arc::new(found))
    }

    /// The values that differ among materials; the panel shows the first of them.
    pub(crate) fn of_materials<'m>(shown: &Material, others: impl Iterator<Item = &'m Material>) -> Self {
        let mut found = BTreeSet::new();
        let own = Values::of(shown.plugin(), shown);
        for other in others {
            own.compare(&Values::of(other.plugin(), other), &mut found);
        }
        Self(Arc::new(found))
    }
}

/// A plugin's parameters by name, as a file would have them.
struct Values<'v> {
    plugin: &'static str,
    by_name: BTreeMap<&'static str, FileValue<'v>>,
}

impl<'v> Values<'v> {
    fn of(plugin: &'static str, declared: &'v impl Declared) -> Self {
        let by_name = BTreeMap::new();
        Self { plugin, by_name }.and(declared)
    }

    fn of_medium(medium: &'v Medium) -> Self {
        // Homogeneous and heterogeneous media are of one kind here.
        Self::of("medium", medium).and(&medium.phase)
    }

    fn and(mut self, declared: &'v impl Declared) -> Self {
        declared.visit(&mut |info, value| {
            value.in_file(info, &mut |info, value| {
                self.by_name.insert(info.name, value);
            });
        });
        self
    }

    /// Adds names of differing values to `found`. Plugins of different kinds are compared in their common parameters.
    fn compare(&self, other: &Self, found: &mut BTreeSet<String>) {
        let (own, its) = (&self.by_name, &other.by_name);
        let is_same_plugin = self.plugin == other.plugin;
        if !is_same_plugin {
            found.insert("type".to_owned());
        }
        let names = own.keys().chain(its.keys());
        let compared = names.filter(|name| is_same_plugin || own.contains_key(*name) && its.contains_key(*name));
        found.extend(
            compared
                .filter(|name| own.get(*name) != its.get(*name))
                .map(|name| (*name).to_owned()),
        );
    }
}

/// Adds the names of properties that only one of two things has, or that differ, as [`property_caption`] makes them.
fn properties(own: &Properties, its: &Properties, found: &mut BTreeSet<String>) {
    let names = own.iter().chain(its.iter()).map(|(name, _)| name);
    let differing = names.filter(|name| own.get(name) != its.get(name));
    found.extend(differing.map(property_caption));
}

/// The name by which a property is known among the values that differ. Parameters have no such names.
pub fn property_caption(name: &str) -> String {
    format!("property: {name}")
}

fn poses(shown: &Inspected, other: &Inspected, found: &mut BTreeSet<String>) {
    let (Some(one), Some(two)) = (&shown.pose(), &other.pose()) else {
        return;
    };
    // The tolerance for the rounding of a turn and back.
    const SAME: f32 = 1e-5;
    let axes = |pose: &Affine3A| [pose.matrix3.x_axis, pose.matrix3.y_axis, pose.matrix3.z_axis].map(Vec3::from);
    let lengths = |pose: &Affine3A| Vec3::from_array(axes(pose).map(Vec3::length));
    let [turn, other_turn] = [one, two].map(|pose| axes(pose).map(Vec3::normalize_or_zero));
    let off = rounding(one, shown.middle()) + rounding(two, other.middle());
    if (one.translation - two.translation).abs().cmpgt(off).any() {
        found.insert("to_world.position".to_owned());
    }
    if !lengths(one).abs_diff_eq(lengths(two), SAME * lengths(one).max_element()) {
        found.insert("to_world.scale".to_owned());
    }
    if turn
        .iter()
        .zip(other_turn)
        .any(|(one, two)| !one.abs_diff_eq(two, SAME))
    {
        found.insert("to_world.rotation".to_owned());
    }
}

fn both<T: PartialReflect>(one: &Option<T>, two: &Option<T>, found: &mut BTreeSet<String>) {
    if let (Some(one), Some(two)) = (one, two) {
        differ("", one, two, found);
    }
}

/// Adds the names of fields that differ to `found`, those within a field as `field.part`, those of a variant by their
/// own names. A field that only one of the two values has does not count.
fn differ(name: &str, one: &dyn PartialReflect, two: &dyn PartialReflect, found: &mut BTreeSet<String>) {
    if one.reflect_partial_eq(two) == Some(true) {
        return;
    }
    match (one.reflect_ref(), two.reflect_ref()) {
        (ReflectRef::Struct(own), ReflectRef::Struct(its)) if !one.represents::<Vec3>() => {
            for place in 0..own.field_len() {
                if let (Some(field), Some(own), Some(its)) =
                    (own.name_at(place), own.field_at(place), its.field_at(place))
                {
                    let name = if name.is_empty() {
                        field.to_owned()
                    } else {
                        format!("{name}.{field}")
                    };
                    differ(&name, own, its, found);
                }
            }
        }
        (ReflectRef::Enum(own), ReflectRef::Enum(its)) => {
            let is_same = own.variant_name() == its.variant_name();
            if !is_same || own.field_len() == 0 {
                found.insert(name.to_owned());
            }
            for place in 0..own.field_len() {
                match (own.name_at(place), own.field_at(place)) {
                    (Some(inner), Some(own)) => {
                        if let Some(its) = its.field(inner) {
                            differ(inner, own, its, found);
                        }
                    }
                    (None, Some(own)) if is_same => {
                        if let Some(its) = its.field_at(place) {
                            differ(name, own, its, found);
                        }
                    }
                    _ => {}
                }
            }
        }
        _ => {
            found.insert(name.to_owned());
        }
    }
}

/// The rounding error of a shape's position after a transform to its middle and back, per coordinate. `pose`: world
/// from a space whose origin is the middle.
pub(crate) fn rounding(pose: &Affine3A, middle: Vec3) -> Vec3A {
    // A few units in the last place of numbers that are added.
    const ROUNDING: f32 = 4.0 * f32::EPSILON;
    ROUNDING * (pose.translation.abs() + (pose.matrix3 * Vec3A::from(middle)).abs())
}

#[cfg(test)]
mod tests {
    use bevy::math::Vec2;
    use bevy::prelude::Entity;

    use super::super::{InspectedMaterial, MaterialPlace};
    use super::*;
    use crate::color::Rgb;
    use crate::scene::{ConductorIor, Crop, Distribution, Film, Roughness, Sensor, Shape, ShapeKind};

    fn thing(radius: f32, place: Vec3) -> Inspected {
        let center = Vec3::ZERO;
        Inspected {
            shape: Some(Shape {
                kind: ShapeKind::Sphere { center, radius },
                ..Shape::default()
            }),
            to_world: Some(Affine3A::from_translation(place)),
            ..Inspected::new(Entity::PLACEHOLDER, "ball")
        }
    }

    #[test]
    fn only_what_differs_is_mixed() {
        let shown = thing(1.0, Vec3::ZERO);
        let same = Mixed::of(&shown, &[thing(1.0, Vec3::ZERO)]);
        assert!(same.is_empty(), "{same:?}");
        let mixed = Mixed::of(&shown, &[thing(1.0, Vec3::ZERO), thing(2.0, Vec3::X)]);
        let has = [
            "radius",
            "to_world.position",
            "to_world.rotation",
            "to_world.scale",
            "flip_normals",
            "uses_material",
        ]
        .map(|name| mixed.has(name));
        assert_eq!(has, [true, true, false, false, false, false], "{mixed:?}");
    }

    #[test]
    fn a_spheres_centre_is_its_position() {
        let mut other = thing(1.0, Vec3::ZERO);
        other.shape = Some(Shape {
            kind: ShapeKind::Sphere {
                center: Vec3::X,
                radius: 1.0,
            },
            ..Shape::default()
        });
        assert!(Mixed::of(&thing(1.0, Vec3::ZERO), &[other.clone()]).has("to_world.position"));
        assert!(!Mixed::of(&thing(1.0, Vec3::X), &[other]).has("to_world.position"));
    }

    #[test]
    fn places_that_were_made_the_same_are_the_same() {
        let turn = Affine3A::from_rotation_y(0.7) * Affine3A::from_scale(Vec3::splat(1.3));
        let at = |center: Vec3, place: Vec3| {
            let mut ball = thing(1.0, Vec3::ZERO);
            ball.shape = Some(Shape {
                kind: ShapeKind::Sphere { center, radius: 1.0 },
                ..Shape::default()
            });
            let pose = Affine3A::from_translation(place) * turn;
            ball.to_world = Some(pose * Affine3A::from_translation(-center));
            ball
        };
        let place = Vec3::new(0.1, 0.7, -3.3);
        for center in [Vec3::new(12.3, 0.4, 7.7), Vec3::new(-0.3, 55.5, 0.9)] {
            let shown = at(Vec3::ZERO, place);
            assert!(
                !Mixed::of(&shown, &[at(center, place)]).has("to_world.position"),
                "{center}"
            );
            assert!(Mixed::of(&shown, &[at(center, place + Vec3::X * 1e-3)]).has("to_world.position"));
        }
    }

    #[test]
    fn materials_are_compared_along_the_same_path() {
        let entry = |path: &[usize], material: Material| InspectedMaterial {
            entity: Entity::PLACEHOLDER,
            name: "material".into(),
            material: material.into(),
            place: MaterialPlace::Inside,
            path: path.to_vec(),
            mixed: Mixed::default(),
            users: 0,
            inside: Vec::new(),
        };
        let plugin = |name| Material::of_plugin(name).expect("a plugin");
        let made_of = |materials| Inspected {
            materials,
            ..thing(1.0, Vec3::ZERO)
        };
        let shown = made_of(vec![
            entry(&[], Material::TwoSided),
            entry(&[0], plugin("diffuse")),
            entry(&[1], plugin("plastic")),
        ]);
        // The front of the other has one more material inside.
        let [bumps, paint, plastic] = ["bumpmap", "diffuse", "plastic"].map(plugin);
        let other = vec![
            (vec![], &Material::TwoSided),
            (vec![0], &bumps),
            (vec![0, 0], &paint),
            (vec![1], &plastic),
        ];
        let differ = shown
            .compared(&[], &[other])
            .materials
            .into_iter()
            .map(|entry| entry.mixed.has("type"));
        assert_eq!(differ.collect::<Vec<bool>>(), [false, true, false]);
    }

    #[test]
    fn parts_are_named_after_what_they_are_in() {
        let camera = |offset: Vec2, crop: Crop| Inspected {
            sensor: Some(Sensor {
                principal_point_offset: offset,
                ..Sensor::default()
            }),
            film: Some(Film {
                crop: Some(crop),
                ..Film::default()
            }),
            ..Inspected::new(Entity::PLACEHOLDER, "camera")
        };
        let crop = Crop {
            width: 10,
            height: 10,
            ..Crop::default()
        };
        let mixed = Mixed::of(
            &camera(Vec2::ZERO, crop),
            &[camera(
                Vec2::Y,
                Crop {
                    x: 3,
                    width: 20,
                    ..crop
                },
            )],
        );
        let names = [
            "principal_point_offset.x",
            "principal_point_offset.y",
            "crop.x",
            "crop.y",
            "crop.width",
            "crop.height",
            "width",
        ];
        let marked = names.map(|name| mixed.has(name));
        assert_eq!(marked, [false, true, true, false, true, false, false], "{mixed:?}");
    }

    #[test]
    fn parameters_are_called_as_in_the_file() {
        let metal = |alpha: f32| Material::RoughConductor {
            distribution: Distribution::Ggx,
            ior: ConductorIor::Named("Au".into()),
            specular_reflectance: Rgb::ONE.into(),
            alpha: Roughness::Isotropic(alpha.into()),
            multiple_scattering: false,
        };
        let mixed = Mixed::of_materials(&metal(0.1), [metal(0.2)].iter());
        assert!(
            mixed.has("alpha") && !mixed.has("distribution") && !mixed.has("type"),
            "{mixed:?}"
        );
        let paint = Material::default();
        assert!(Mixed::of_materials(&metal(0.1), [paint].iter()).has("type"));
    }
}
