//! The defaults of parameters, which are not written for things made here. They are found by reading a plugin without
//! parameters.

use std::cell::RefCell;
use std::path::Path;

use smol_str::SmolStr;

use crate::document::{Category, Child, Object, Property, parse_str};
use crate::scene::encode::{lights, objects};
use crate::scene::read;

/// Parameters whose defaults depend on others: they are always written.
const DEPENDENT: [&str; 3] = ["beam_width", "fov", "fov_axis"];

/// Caches plugins read without parameters; None for plugins that need some.
#[derive(Default)]
pub(super) struct Defaults(RefCell<Vec<(Category, SmolStr, Option<Object>)>>);

impl Defaults {
    /// The object without the properties that equal their default.
    pub fn left_out(&self, mut object: Object) -> Object {
        let mut known = self.0.borrow_mut();
        let is_it = |(category, plugin, _): &(Category, SmolStr, _)| {
            (*category, plugin.as_str()) == (object.category, object.plugin.as_str())
        };
        let place = known.iter().position(is_it).unwrap_or_else(|| {
            let plain = read_plain(object.category, &object.plugin);
            known.push((object.category, object.plugin.clone(), plain));
            known.len() - 1
        });
        if let Some(plain) = &known[place].2 {
            let is_default = |property: &Property| {
                let mut known = plain.properties.iter();
                known.any(|plain| plain.name == property.name && plain.value == property.value)
            };
            object
                .properties
                .retain(|property| DEPENDENT.contains(&property.name.as_str()) || !is_default(property));
        }
        object
    }

    /// The object and its nested ones without the properties that equal their default.
    pub fn left_out_inside(&self, mut object: Object) -> Object {
        for child in &mut object.children {
            if let Child::Object(inner) = child {
                *inner = self.left_out(Object::clone(inner)).into();
            }
        }
        self.left_out(object)
    }
}

fn read_plain(category: Category, plugin: &str) -> Option<Object> {
    let folder = Path::new("/");
    let text = format!(
        "<scene version=\"3.0.0\"><{0} type=\"{plugin}\"/></scene>",
        category.name()
    );
    let mut document = parse_str(&*text, Path::new("/plain.xml"), &[]);
    let scene = read::read(&mut document);
    if document.diagnostics.has_errors() {
        return None;
    }
    let plain = match category {
        Category::Shape => {
            let shape = scene.shapes.first()?;
            objects::shape(&shape.shape, &shape.to_world, None, None, folder)
        }
        Category::Integrator => objects::integrator(&scene.integrator),
        Category::Bsdf => objects::material(&scene.materials.first()?.material, folder),
        Category::Medium => objects::medium(&scene.media.first()?.medium, folder),
        Category::Emitter => {
            let emitter = scene.emitters.first()?;
            lights::emitter(&emitter.emitter, &emitter.to_world, None, folder)
        }
        _ => return None,
    };
    (plain.plugin == plugin).then_some(plain)
}

#[cfg(test)]
mod tests {
    use bevy::math::{Affine3A, Vec3};

    use super::*;
    use crate::scene::{Emitter, EmitterKind, FovAxis, Material, Shape, ShapeKind};

    fn names(object: &Object) -> Vec<&str> {
        object
            .properties
            .iter()
            .map(|property| property.name.as_str())
            .collect()
    }

    #[test]
    fn only_what_differs_is_written() {
        let defaults = Defaults::default();
        let ball = |center, radius| Shape {
            kind: ShapeKind::Sphere { center, radius },
            ..Shape::default()
        };
        let written = |shape: &Shape, pose| defaults.left_out(objects::shape(shape, &pose, None, None, Path::new("/")));
        let plain = written(&ball(Vec3::ZERO, 1.0), Affine3A::IDENTITY);
        assert_eq!(names(&plain), [""; 0]);
        let moved = Affine3A::from_translation(Vec3::X);
        let placed = written(&ball(Vec3::ZERO, 0.5), moved);
        assert_eq!(names(&placed), ["radius", "to_world"]);
    }

    /// Checks that parameters that are left out are read with the same values.
    #[test]
    fn what_is_left_out_is_supposed() {
        let defaults = Defaults::default();
        let folder = Path::new("/");
        let reread = |object: Object| {
            let mut root = Object::new(Category::Scene, "");
            root.children.push(object.into());
            let document = crate::document::Document::new(Path::new("/a.xml"), root);
            let text = crate::document::to_xml(&document).expect("it can be written");
            read::read(&mut parse_str(&*text, Path::new("/a.xml"), &[]))
        };
        let mut left_out = 0;
        for plugin in Material::PLUGINS {
            let material = Material::of_plugin(plugin).expect("a plugin");
            let whole = objects::material(&material, folder);
            let short = defaults.left_out(whole.clone());
            left_out += whole.properties.len() - short.properties.len();
            if *material.info().nested.start() == 0 {
                assert_eq!(reread(short).materials[0].material, material, "{plugin}");
            }
        }
        // An environment needs a picture, and a lamp the file of its intensities.
        let is_whole = |plugin: &&str| !matches!(*plugin, "envmap" | "ies");
        for plugin in Emitter::PLUGINS.into_iter().filter(is_whole) {
            let emitter = Emitter::of_plugin(plugin).expect("a plugin");
            let whole = lights::emitter(&emitter, &Affine3A::IDENTITY, None, folder);
            assert_eq!(
                reread(defaults.left_out(whole)).emitters[0].emitter,
                emitter,
                "{plugin}"
            );
        }
        assert!(left_out > 20, "{left_out}");
        // The default of one may depend on another that was edited.
        let changed = |plugin: &str, change: fn(&mut EmitterKind)| {
            let mut emitter = Emitter::of_plugin(plugin).expect("a plugin");
            change(&mut emitter.kind);
            emitter
        };
        let spot = |kind: &mut EmitterKind| {
            if let EmitterKind::Spot { cone, .. } = kind {
                cone.cutoff_angle = 40.0;
            }
        };
        let narrow = |kind: &mut EmitterKind| {
            if let EmitterKind::Projector { field_of_view, .. } = kind {
                (field_of_view.fov, field_of_view.axis) = (30.0, FovAxis::Diagonal);
            }
        };
        let turned = |kind: &mut EmitterKind| {
            if let EmitterKind::Projector { field_of_view, .. } = kind {
                field_of_view.axis = FovAxis::Y;
            }
        };
        for emitter in [
            changed("spot", spot),
            changed("projector", narrow),
            changed("projector", turned),
        ] {
            let whole = lights::emitter(&emitter, &Affine3A::IDENTITY, None, folder);
            assert_eq!(reread(defaults.left_out(whole)).emitters[0].emitter, emitter);
        }
    }
}
