//! Integrators: `path`; every other one is taken for it.

use super::scene_reader::SceneReader;
use crate::document::suggest::did_you_mean;
use crate::document::{Category, Object, Severity};
use crate::scene::encode::objects;
use crate::scene::{AuthoredScene, IntegratorSettings};

/// The largest depth; longer paths are as good as unbounded.
const LARGEST_DEPTH: i64 = 1 << 30;

impl<'a> SceneReader<'a> {
    /// Whether the integrator became part of the description.
    pub(super) fn read_integrator(&mut self, object: &'a Object, remains: &mut AuthoredScene) -> bool {
        if remains.integrator.is_some() {
            let message = "a second integrator has no effect";
            self.diagnostics.warn(object.span, message);
            return false;
        }
        let settings = self.read_integrator_settings(object, 0);
        self.description.integrator = settings;
        let authored = self.authored(object, objects::integrator(&settings));
        remains.integrator = Some((self.order(object), authored));
        true
    }

    fn read_integrator_settings(&mut self, object: &'a Object, depth: usize) -> IntegratorSettings {
        let mut reader = self.reader(object);
        let mut settings = IntegratorSettings::default();
        let plugin = object.plugin.as_str();
        if plugin != "path" {
            let message = format!("integrator `{plugin}` is not supported: `path` takes its place");
            let help = did_you_mean(plugin, ["path", "direct"]);
            let span = Some(object.span);
            reader.diagnostics().push(Severity::Warning, span, message, help);
        }
        // Direct light is that of paths of two segments.
        if plugin == "direct" {
            settings.max_depth = Some(2);
        }
        if let Some(depth) = reader.integer_in("max_depth", -1..=LARGEST_DEPTH) {
            settings.max_depth = u32::try_from(depth).ok();
        }
        if let Some(depth) = reader.integer_in("rr_depth", 1..=LARGEST_DEPTH) {
            settings.rr_depth = u32::try_from(depth).unwrap_or(u32::MAX);
        }
        settings.hide_emitters = reader.boolean_or("hide_emitters", false);
        if plugin == "path" {
            reader.ignore(&["timeout", "block_size", "samples_per_pass"]);
            reader.finish();
            return settings;
        }
        // `aov` and the like hold the integrator that makes the picture.
        let inner = reader.children(Category::Integrator).first().map(|(_, inner)| *inner);
        match inner {
            Some(inner) if depth < 8 => self.read_integrator_settings(inner, depth + 1),
            _ => settings,
        }
    }
}
