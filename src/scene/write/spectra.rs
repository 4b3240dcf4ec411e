//! Replaces spectra that the RGB modes of Mitsuba refuse by their colours.

use std::collections::HashMap;
use std::sync::Arc;

use smol_str::SmolStr;

use crate::document::spectrum::Role;
use crate::document::{Category, Child, Diagnostics, Index, Object, Reader, Value};
use crate::scene::read::spectra::{D65, inside_d65, integrated, is_spectral_only};

/// Replaces each such spectrum of a scene, and each reference to one, by an `<rgb>`.
pub fn as_colors(root: &mut Object) {
    let mut named = HashMap::new();
    collect(root, &mut named);
    replace(root, &named, Role::Emission);
    // All references to them are replaced by now.
    root.children.retain(|child| spectrum(child, &HashMap::new()).is_none());
}

fn is_refused(object: &Object) -> bool {
    object.category == Category::Texture && is_spectral_only(&object.plugin)
}

/// Collects the spectra with ids.
fn collect(object: &Object, named: &mut HashMap<SmolStr, Object>) {
    for child in object.objects() {
        if let Some(id) = child.id.as_ref().filter(|_| is_refused(child)) {
            named.insert(id.clone(), child.clone());
        }
        collect(child, named);
    }
}

fn spectrum<'s>(child: &'s Child, named: &'s HashMap<SmolStr, Object>) -> Option<&'s Object> {
    match child {
        Child::Object(object) => Some(&**object).filter(|object| is_refused(object)),
        Child::Reference { id, .. } => named.get(id),
    }
}

/// Replaces spectra by colours. `own_role` is the role of the object, if it is a spectrum.
fn replace(object: &mut Object, named: &HashMap<SmolStr, Object>, own_role: Role) {
    let owner = object.category;
    // The parameter of a `d65` is its colour, whatever its name.
    let is_d65 = owner == Category::Texture && object.plugin == D65;
    let inside = is_d65.then(|| ("color", inside_d65(own_role)));
    let mut colors = Vec::new();
    object.children.retain(|child| {
        let given = child.name().map(|name| (name, Role::of(owner, name)));
        let Some((spectrum, (name, role))) = spectrum(child, named).zip(inside.or(given)) else {
            return true;
        };
        // Errors were reported when the scene was read.
        let (index, mut diagnostics) = (Index::new(spectrum), Diagnostics::default());
        let mut reader = Reader::new(&index, spectrum, &mut diagnostics);
        let color = integrated(&mut reader, role);
        colors.extend(color.map(|color| (name.to_owned(), color)));
        color.is_none()
    });
    for (name, color) in colors {
        *object = std::mem::replace(object, Object::new(owner, "")).with(&name, Value::Rgb(color));
    }
    for child in &mut object.children {
        let role = Role::of(owner, child.name().unwrap_or_default());
        if let Child::Object(inner) = child {
            replace(Arc::make_mut(inner), named, role);
        }
    }
}
