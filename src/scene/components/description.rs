//! A whole scene file as plain data: what [`crate::scene::read`] makes of a document and [`crate::scene::load::spawn`]
//! turns into entities.
//!
//! No entities and no handles: two descriptions can be compared, and references are indices into `materials` and the
//! like.

use std::borrow::Cow;
use std::collections::HashMap;
use std::path::PathBuf;

use bevy::math::{Affine3A, Vec3};

use crate::color::Rgb;
use crate::document::Span;
use crate::scene::{
    AreaLight, Authored, AuthoredScene, Emitter, EmitterKind, EulerAngles, Film, IntegratorSettings, Keys, LengthUnit,
    Material, Medium, MissingFiles, Placements, Sensor, Shape, ShapeKind,
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
    /// The moment, in seconds, of which all values are.
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
    /// The lights that are no surfaces.
    pub emitters: Vec<EmitterDescription>,
    /// The parts of the file that became none of these.
    pub remains: AuthoredScene,
    /// The files the scene was read from: itself and its includes, absolute. Meshes are not among them.
    pub sources: Vec<PathBuf>,
    /// The files that were not found; the scene can be read again when one appears.
    pub missing: MissingFiles,
    /// The place where each picture is named first.
    pub picture_places: PicturePlaces,
    /// The place where each grid of a volume is named first, by the paths of their assets.
    pub volume_places: PicturePlaces,
}

impl SceneDescription {
    /// The places in the scene file that messages about meshes, pictures and volumes may name.
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

    /// The indices of the media that something is in, once for each use.
    pub(in crate::scene) fn media_in_use(&self) -> impl Iterator<Item = usize> {
        let of_shapes = self
            .shapes
            .iter()
            .flat_map(|shape| shape.interior.into_iter().chain(shape.exterior));
        let of_emitters = self.emitters.iter().filter_map(|emitter| emitter.medium);
        let of_sensors = self.sensors.iter().filter_map(|sensor| sensor.medium);
        of_shapes.chain(of_emitters).chain(of_sensors)
    }

    /// The description of a new scene: a camera that looks at the origin from some units away, and a grey sky.
    pub fn empty() -> Self {
        let identity = |name: &str, order| Identity {
            id: Some(name.to_owned()),
            name: name.to_owned().into(),
            order,
            ..Identity::default()
        };
        let place = Vec3::new(3.0, 2.0, 6.0);
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

/// The properties that all things of a scene have in common.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Identity {
    /// The `id` of the file, where it gives one.
    pub id: Option<String>,
    /// The name that the editor shows: the id, or else the plugin.
    pub name: Cow<'static, str>,
    /// The place in the file among all objects; ascending in every list of the description.
    pub order: u32,
    /// The place where the object is declared; empty for what was made in the editor.
    pub span: Span,
    /// The source in the file; None for what was made in the editor.
    pub authored: Option<Authored>,
    /// The angles of its rotation, if the transform gives such.
    pub angles: Option<EulerAngles>,
    /// The values at other times; None for what stands still.
    pub keys: Option<Keys>,
}

/// A camera with its film.
#[derive(Clone, Debug, PartialEq)]
pub struct SensorDescription {
    /// The place in the file and the names.
    pub identity: Identity,
    /// The lens and field of view.
    pub sensor: Sensor,
    /// The size, crop, filter and number of samples.
    pub film: Film,
    /// The map from camera space: +z forward, +x left, +y up.
    pub to_world: Affine3A,
    /// The medium that it is in, as an index into [`SceneDescription::media`].
    pub medium: Option<usize>,
}

/// A bsdf.
#[derive(Clone, Debug, PartialEq)]
pub struct MaterialDescription {
    /// The place in the file and the names.
    pub identity: Identity,
    /// The model with its parameters; nested materials are named by `first` and `second`.
    pub material: Material,
    /// The nested materials, as indices into [`SceneDescription::materials`]. They form no circle.
    pub first: Option<usize>,
    /// The second nested material. Only materials of two others have it.
    pub second: Option<usize>,
    /// Decides where the material is written when the scene is saved.
    pub declared_in: DeclarationPlace,
}

/// A participating medium.
#[derive(Clone, Debug, PartialEq)]
pub struct MediumDescription {
    /// The place in the file and the names.
    pub identity: Identity,
    /// The parameters.
    pub medium: Medium,
    /// Decides where the medium is written when the scene is saved.
    pub declared_in: DeclarationPlace,
}

/// The place at which a material or a medium is declared.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DeclarationPlace {
    /// It is in the scene itself, and found by references.
    TopLevel,
    /// It is inside the shape of this index.
    Shape(usize),
    /// It is inside the material of this index. Media are not.
    Material(usize),
    /// It is inside the sensor of this index. Materials are not.
    Sensor(usize),
    /// It is inside the emitter of this index. Materials are not.
    Emitter(usize),
}

/// A shape with everything that hangs on it.
#[derive(Clone, Debug, PartialEq)]
pub struct ShapeDescription {
    /// The place in the file and the names.
    pub identity: Identity,
    /// The shape.
    pub shape: Shape,
    /// The map from local space, invertible. It is the identity for members, since their group is placed.
    pub to_world: Affine3A,
    /// The material. None if the file names none: the mesh's own materials apply then, or else the default.
    pub material: Option<usize>,
    /// The medium on the inner side, as an index into [`SceneDescription::media`].
    pub interior: Option<usize>,
    /// The medium on the outer side.
    pub exterior: Option<usize>,
    /// The emission; None for a shape that does not shine.
    pub area_light: Option<AreaLight>,
    /// The group of a member, or below of an instance: indices into [`SceneDescription::groups`].
    pub member_of: Option<usize>,
    /// The group of an instance.
    pub instance_of: Option<usize>,
    /// The places of the instances, if there are very many.
    pub placements: Option<Placements>,
}

/// A group of shapes that are visible only in its instances.
#[derive(Clone, Debug, PartialEq)]
pub struct GroupDescription {
    /// The place in the file and the names.
    pub identity: Identity,
}

/// A light that is no surface.
#[derive(Clone, Debug, PartialEq)]
pub struct EmitterDescription {
    /// The place in the file and the names.
    pub identity: Identity,
    /// The kind and strength.
    pub emitter: Emitter,
    /// The map from the light's own space, in which it shines along +z or has +y or +z up.
    pub to_world: Affine3A,
    /// The medium that it is in, as an index into [`SceneDescription::media`].
    pub medium: Option<usize>,
}
