//! A whole scene file as plain data: [`crate::scene::read`] makes it of a document, and [`crate::scene::load::spawn`]
//! turns it into entities.
//!
//! No entities and no handles: two descriptions can be compared, and references are indices into `materials` and the
//! other lists.

use std::borrow::Cow;
use std::collections::HashMap;
use std::path::PathBuf;

use bevy::math::{Affine3A, Vec3};

use crate::color::Rgb;
use crate::document::Span;
use crate::scene::{
    AreaLight, Authored, AuthoredScene, Emitter, EmitterKind, EulerAngles, Film, IntegratorSettings, Keys, LengthUnit,
    LightUnits, Material, Medium, MissingFiles, Placements, Properties, SceneProperties, Sensor, Shape, ShapeKind,
};

/// The place where the scene file first names each picture or volume, by absolute path.
pub type PicturePlaces = HashMap<PathBuf, Span>;

/// A scene as data, before it becomes entities or XML.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SceneDescription {
    /// The scene file.
    pub path: PathBuf,
    /// The integrator in the file; `strategy` and `schlick` are not in files and have their defaults.
    pub integrator: IntegratorSettings,
    /// The tracks of the integrator's settings.
    pub integrator_keys: Keys,
    /// The unit of length.
    pub unit: LengthUnit,
    /// The units in which lights are shown.
    pub light_units: LightUnits,
    /// The properties of the scene itself.
    pub properties: SceneProperties,
    /// The time, in seconds, at which animated values are evaluated.
    pub time: f64,
    /// The cameras; empty if the file has none.
    pub sensors: Vec<SensorDescription>,
    /// The materials, nested ones too.
    pub materials: Vec<MaterialDescription>,
    /// The participating media.
    pub media: Vec<MediumDescription>,
    /// The `shapegroup`s that instances place.
    pub groups: Vec<GroupDescription>,
    /// The shapes, with the members of groups.
    pub shapes: Vec<ShapeDescription>,
    /// The lights other than emissive shapes.
    pub emitters: Vec<EmitterDescription>,
    /// The parts of the file that became none of these.
    pub remains: AuthoredScene,
    /// The files the scene was read from: itself and its includes, absolute. Meshes are not among them.
    pub sources: Vec<PathBuf>,
    /// The files that were not found; the scene can be read again when one appears.
    pub missing: MissingFiles,
    /// The span where each picture is named first.
    pub picture_places: PicturePlaces,
    /// The span where each grid of a volume is named first, by the path of its asset.
    pub volume_places: PicturePlaces,
}

impl SceneDescription {
    /// The spans that messages about meshes, pictures and volumes may point to.
    pub(in crate::scene) fn places_of_files(&self) -> impl Iterator<Item = Span> {
        let meshes = self
            .shapes
            .iter()
            .filter(|shape| matches!(shape.shape.kind, ShapeKind::Mesh(_)));
        let objects = meshes.filter_map(|shape| Some(&shape.identity.authored.as_ref()?.object));
        let of_meshes = objects.flat_map(|object| {
            let properties = object.properties.iter().map(|property| property.span);
            std::iter::once(object.span).chain(properties)
        });
        let others = self.picture_places.values().chain(self.volume_places.values());
        others.copied().chain(of_meshes)
    }

    /// The lights that surround the scene, in the order of the file.
    pub fn skies(&self) -> impl Iterator<Item = &EmitterDescription> {
        self.emitters.iter().filter(|light| light.emitter.is_sky())
    }

    /// The indices of the media in use, once for each use.
    pub(in crate::scene) fn media_in_use(&self) -> impl Iterator<Item = usize> {
        let of_shapes = self
            .shapes
            .iter()
            .flat_map(|shape| shape.interior.into_iter().chain(shape.exterior));
        let of_emitters = self.emitters.iter().filter_map(|emitter| emitter.medium);
        let of_sensors = self.sensors.iter().filter_map(|sensor| sensor.medium);
        of_shapes.chain(of_emitters).chain(of_sensors)
    }

    /// The description of a new scene: a camera that sees a floor as large as that of a house around the origin, and a
    /// grey sky.
    pub fn empty() -> Self {
        let identity = |name: &str, order| Identity {
            id: Some(name.to_owned()),
            name: name.to_owned().into(),
            order,
            ..Identity::default()
        };
        let place = Vec3::new(5.0, 4.0, 10.0);
        let film = Film {
            sample_count: 256,
            ..Film::default()
        };
        Self {
            sensors: vec![SensorDescription {
                identity: identity("camera", 0),
                sensor: Sensor::default(),
                film,
                to_world: Affine3A::look_at_rh(place, Vec3::ZERO, Vec3::Y).inverse()
                    * Affine3A::from_rotation_y(std::f32::consts::PI),
                medium: None,
            }],
            emitters: vec![EmitterDescription {
                identity: identity("sky", 1),
                emitter: EmitterKind::Constant {
                    radiance: Rgb::splat(0.5),
                }
                .into(),
                to_world: Affine3A::IDENTITY,
                medium: None,
            }],
            ..Self::default()
        }
    }
}

/// The properties common to all things of a scene.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Identity {
    /// The `id` in the file, if it has one.
    pub id: Option<String>,
    /// The name that the editor shows: the id, or else the plugin.
    pub name: Cow<'static, str>,
    /// The position in the file among all objects; ascending in every list of the description.
    pub order: u32,
    /// The span of the declaration; empty for things made in the editor.
    pub span: Span,
    /// The source in the file; None for things made in the editor.
    pub authored: Option<Authored>,
    /// The rotation angles, if the transform is written with angles.
    pub angles: Option<EulerAngles>,
    /// The keys of animated values; None if nothing is animated.
    pub keys: Option<Keys>,
    /// The properties that the user has given to it; None if there are none.
    pub properties: Option<Properties>,
}

/// A camera with its film.
#[derive(Clone, Debug, PartialEq)]
pub struct SensorDescription {
    /// The order in the file, the id and the name.
    pub identity: Identity,
    /// The lens and field of view.
    pub sensor: Sensor,
    /// The size, crop, filter and number of samples.
    pub film: Film,
    /// The transform from camera space: +z forward, +x left, +y up.
    pub to_world: Affine3A,
    /// The medium around the camera, as an index into [`SceneDescription::media`].
    pub medium: Option<usize>,
}

/// A bsdf.
#[derive(Clone, Debug, PartialEq)]
pub struct MaterialDescription {
    /// The order in the file, the id and the name.
    pub identity: Identity,
    /// The model with its parameters; its nested materials are `first` and `second`.
    pub material: Material,
    /// The first nested material, as an index into [`SceneDescription::materials`]. Nesting forms no cycle.
    pub first: Option<usize>,
    /// The second nested material. Only materials of two others have it.
    pub second: Option<usize>,
    /// Decides where the material is written when the scene is saved.
    pub declared_in: DeclarationPlace,
}

/// A participating medium.
#[derive(Clone, Debug, PartialEq)]
pub struct MediumDescription {
    /// The order in the file, the id and the name.
    pub identity: Identity,
    /// The parameters.
    pub medium: Medium,
    /// Decides where the medium is written when the scene is saved.
    pub declared_in: DeclarationPlace,
}

/// The place at which a material or a medium is declared.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DeclarationPlace {
    /// In the scene itself, used by references.
    TopLevel,
    /// Inside the shape with this index.
    Shape(usize),
    /// Inside the material with this index; only for materials.
    Material(usize),
    /// Inside the sensor with this index; only for media.
    Sensor(usize),
    /// Inside the emitter with this index; only for media.
    Emitter(usize),
}

/// A shape with its material, media, emission and group.
#[derive(Clone, Debug, PartialEq)]
pub struct ShapeDescription {
    /// The order in the file, the id and the name.
    pub identity: Identity,
    /// The shape.
    pub shape: Shape,
    /// The transform from local space, invertible. For group members it is the identity, since their group is placed.
    pub to_world: Affine3A,
    /// The material. None if the file names none: then the mesh's own materials are used, or else the default.
    pub material: Option<usize>,
    /// The medium on the inner side, as an index into [`SceneDescription::media`].
    pub interior: Option<usize>,
    /// The medium on the outer side.
    pub exterior: Option<usize>,
    /// The emission; None for a shape that is not emissive.
    pub area_light: Option<AreaLight>,
    /// The group that a member belongs to, as an index into [`SceneDescription::groups`].
    pub member_of: Option<usize>,
    /// The group that an instance shows, as an index into [`SceneDescription::groups`].
    pub instance_of: Option<usize>,
    /// The transforms of the instances, if there are very many.
    pub placements: Option<Placements>,
}

/// A group of shapes that are visible only in its instances.
#[derive(Clone, Debug, PartialEq)]
pub struct GroupDescription {
    /// The order in the file, the id and the name.
    pub identity: Identity,
}

/// A light other than an emissive shape.
#[derive(Clone, Debug, PartialEq)]
pub struct EmitterDescription {
    /// The order in the file, the id and the name.
    pub identity: Identity,
    /// The kind and strength.
    pub emitter: Emitter,
    /// The transform from the light's own space, in which it shines along +z or has +y or +z up.
    pub to_world: Affine3A,
    /// The medium around the light, as an index into [`SceneDescription::media`].
    pub medium: Option<usize>,
}
