//! Where the light of a lamp goes, in sentences and as JSON.

use std::collections::HashSet;
use std::path::PathBuf;

use bevy::prelude::*;
use serde::Serialize;
use sunroom::document::suggest::did_you_mean;
use sunroom::engine::reasons::{NOTHING_LIT, percent, thing_name};
use sunroom::photometry::units::Lumen;
use sunroom::render::breakdown::{Destination, destinations};

use super::question::Question;
use super::report::rest_percent;
use crate::cli::report::{Failure, counted};

/// The light of a lamp by the things that it arrives at. Powers are luminances in W, shares are parts of the emitted
/// power.
#[derive(Serialize)]
struct Report {
    scene: PathBuf,
    lamp: String,
    paths: u64,
    seed: u32,
    emitted: f32,
    emitted_error: f32,
    /// The share that leaves the scene.
    escaped: f32,
    escaped_error: f32,
    things: Vec<Thing>,
}

#[derive(Serialize)]
struct Thing {
    name: String,
    /// The share that stays there.
    absorbed: f32,
    absorbed_error: f32,
    /// The power that arrives there, repeated arrivals included.
    received: f32,
    received_error: f32,
}

/// The paths by default.
const PATHS: u32 = 1 << 18;
/// The most things of the text.
const MOST_THINGS: usize = 24;

impl Question<'_> {
    /// The report on the light of the lamp of this name; None if interrupted.
    pub fn lamp(&self, name: &str, pool: &rayon::ThreadPool) -> Result<Option<String>, Failure> {
        let owner = self.lamp_of_name(name)?;
        let Some(scene) = self.things.lit_by(&self.scene, owner) else {
            return Err(Failure::Usage(format!("`{name}` does not shine")));
        };
        let paths = self.args.spp.unwrap_or(PATHS);
        let found = self.search(pool, |progress| destinations(&scene, &self.view, paths, progress));
        let Some(found) = found else {
            return Ok(None);
        };
        let things = found.by(|instance| self.things.instance(instance));
        let thing = |thing: Destination<Option<Entity>>| Thing {
            name: thing
                .key
                .map_or_else(|| "?".to_owned(), |entity| thing_name(self.world, entity)),
            absorbed: thing.share,
            absorbed_error: thing.share_error,
            received: thing.received,
            received_error: thing.received_error,
        };
        let ([emitted, emitted_error], [escaped, escaped_error]) = (found.emitted(), found.escaped());
        let report = Report {
            scene: self.args.scene.scene.clone(),
            lamp: name.to_owned(),
            paths: found.paths(),
            seed: self.view.seed,
            emitted,
            emitted_error,
            escaped,
            escaped_error,
            things: things.into_iter().map(thing).collect(),
        };
        Ok(Some(match self.args.json {
            true => format!("{}\n", serde_json::to_string_pretty(&report)?),
            false => report.text(),
        }))
    }

    /// The entity of a lamp by its id or its name.
    fn lamp_of_name(&self, wanted: &str) -> Result<Entity, Failure> {
        let mut known = HashSet::new();
        let shining = self.things.shining().iter().copied();
        let lamps: Vec<Entity> = shining.filter(|entity| known.insert(*entity)).collect();
        let found: Vec<Entity> = lamps
            .iter()
            .copied()
            .filter(|lamp| self.has_name(*lamp, wanted))
            .collect();
        match found[..] {
            [lamp] => return Ok(lamp),
            [] => {}
            _ => {
                let names = found.iter().take(MOST_THINGS).map(|lamp| thing_name(self.world, *lamp));
                let names: Vec<String> = names.collect();
                let text = format!("{} lamps have the name `{wanted}`: {}", found.len(), names.join(", "));
                return Err(Failure::Usage(text));
            }
        }
        if self.things.media().any(|medium| self.has_name(medium, wanted)) {
            let text = format!("`{wanted}` is a medium: only the light of shapes and lights is followed");
            return Err(Failure::Usage(text));
        }
        let names: Vec<String> = lamps.iter().map(|lamp| thing_name(self.world, *lamp)).collect();
        let help = did_you_mean(wanted, names.iter().map(String::as_str));
        let all = || match names.is_empty() {
            true => "nothing shines in this scene".to_owned(),
            false => format!("the lamps are {}", names[..names.len().min(MOST_THINGS)].join(", ")),
        };
        let help = help.unwrap_or_else(all);
        Err(Failure::Usage(format!("there is no lamp `{wanted}` ({help})")))
    }

    /// Whether a thing has this id or name, or is called so in reports.
    fn has_name(&self, entity: Entity, wanted: &str) -> bool {
        let name = self.world.get::<Name>(entity);
        name.is_some_and(|name| name.as_str() == wanted) || thing_name(self.world, entity) == wanted
    }
}

impl Report {
    fn text(&self) -> String {
        let lumens = |value: f32, error: f32| {
            let [value, error] = [value, error].map(|watts| Lumen::of_watts(f64::from(watts)));
            value.with_error(error.0)
        };
        let mut lines = vec![
            format!(
                "{} emits {}; by {}:",
                self.lamp,
                lumens(self.emitted, self.emitted_error),
                counted(self.paths, "path")
            ),
            String::new(),
        ];
        if self.things.is_empty() {
            lines.push(NOTHING_LIT.to_owned());
        } else {
            lines.push(format!("{:>18}  {:>24}", "stays", "arrives"));
        }
        for thing in self.things.iter().take(MOST_THINGS) {
            let [stays, arrives] = [
                percent(thing.absorbed, thing.absorbed_error),
                lumens(thing.received, thing.received_error),
            ];
            lines.push(format!("{stays:>18}  {arrives:>24}  {}", thing.name));
        }
        let rest = self.things.len().saturating_sub(MOST_THINGS);
        if rest > 0 {
            let absorbed: f32 = self.things[MOST_THINGS..].iter().map(|thing| thing.absorbed).sum();
            lines.push(format!(
                "{:>18}  {:>24}  {}",
                rest_percent(absorbed),
                "",
                counted(rest, "other thing")
            ));
        }
        if self.escaped > 0.0 {
            let escaped = percent(self.escaped, self.escaped_error);
            lines.push(format!("{escaped:>18}  {:>24}  leaves the scene", ""));
        }
        lines.join("\n") + "\n"
    }
}
