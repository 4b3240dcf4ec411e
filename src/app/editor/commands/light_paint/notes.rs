//! Sentences about the lamps that were found.

use super::film_lamps::Lamp;
use crate::app::editor::command::light_paint::LightPainting;
use crate::inverse_lighting::{Fit, Limit, Wish};

/// Strokes with a larger error than this are reported as not met.
const MET: f64 = 0.05;

/// Sentences about what is not met, and about the lamps that limit it.
pub fn notes(painting: &LightPainting, fit: &Fit, lamps: &[Lamp], names: &[String]) -> Vec<String> {
    let mut notes = Vec::new();
    for (target, &error) in fit.errors.iter().enumerate().filter(|(_, error)| **error > MET) {
        let percent = (100.0 * error).round();
        notes.push(
            match target
                .checked_sub(1)
                .and_then(|place| Some((place, painting.strokes.get(place)?)))
            {
                None => format!("The picture is missed by {percent} %."),
                Some((place, stroke)) => format!(
                    "Stroke {} ({}) is missed by {percent} %.",
                    place + 1,
                    wish_words(stroke.wish)
                ),
            },
        );
    }
    let found = names.iter().zip(&fit.limits).zip(lamps);
    for ((name, limit), lamp) in found.filter(|(_, lamp)| lamp.choice.chosen) {
        match limit {
            Some(Limit::Most) => notes.push(format!("{name} is at its upper limit, {}.", lamp.limits.most)),
            Some(Limit::Least) => notes.push(format!("{name} is at its lower limit, {}.", lamp.limits.least)),
            None => {}
        }
    }
    if notes.is_empty() {
        notes.push(format!("All is met within {:.0} %.", (100.0 * MET)));
    }
    notes
}

/// A wish with its number.
fn wish_words(wish: Wish) -> String {
    let name = wish.name();
    match wish {
        Wish::Brighter(factor) | Wish::Darker(factor) => format!("{name} {factor}"),
        Wish::Luminance(nit) => format!("{nit} nit"),
        Wish::Illuminance(lux) => format!("{lux} lx"),
        Wish::Color(_) | Wish::Keep => name.to_owned(),
    }
}
