//! Reads integrators: `path`, `volpath`, `volpathmis`, `bdpt`, `vcm`, `ptracer`, `auto`, and `aov` around them; all
//! others are read as `path` or `volpath`.

use super::scene_reader::SceneReader;
use crate::document::{Category, Object, Reader, Severity};
use crate::layer::{Layer, Layers};
use crate::scene::encode::objects;
use crate::scene::{AuthoredScene, IntegratorSettings, PathPlugin};

/// The largest depth; longer paths count as unbounded.
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
        self.description.integrator_keys = self.keys(object).unwrap_or_default();
        let authored = self.authored(object, objects::integrator(&settings));
        remains.integrator = Some((self.order(object), authored));
        true
    }

    /// Warns of media that the integrator ignores.
    pub(super) fn report_media_without_effect(&mut self, remains: &AuthoredScene) {
        if self.description.media.is_empty() || self.description.integrator.plugin.traces_media() {
            return;
        }
        let name = self.description.integrator.plugin.name();
        let (span, message) = match &remains.integrator {
            Some((_, authored)) => (
                authored.object.span,
                format!("`{name}` leaves out the media of the scene; `volpath` traces them"),
            ),
            None => (
                self.root.span,
                format!(
                    "the scene has no integrator: `{name}` is taken, which leaves out its media; `volpath` traces them"
                ),
            ),
        };
        self.diagnostics.warn(span, message);
    }

    fn read_integrator_settings(&mut self, object: &'a Object, depth: usize) -> IntegratorSettings {
        let mut reader = self.reader(object);
        let mut settings = IntegratorSettings::default();
        let plugin = object.plugin.as_str();
        let known = PathPlugin::of_name(plugin);
        settings.plugin = known.unwrap_or_else(|| match plugin.contains("vol") {
            true => PathPlugin::VolPath,
            false => PathPlugin::Path,
        });
        if known.is_none() && plugin != "aov" {
            let stand_in = settings.plugin.name();
            let message = format!("integrator `{plugin}` is not supported: `{stand_in}` takes its place");
            let help = reader.diagnostics().did_you_mean(
                plugin,
                [
                    "path",
                    "direct",
                    "aov",
                    "volpath",
                    "volpathmis",
                    "bdpt",
                    "vcm",
                    "ptracer",
                    "auto",
                ],
            );
            let span = Some(object.span);
            reader.diagnostics().push(Severity::Warning, span, message, help);
        }
        // Direct light has paths of two segments.
        if plugin == "direct" {
            settings.max_depth = Some(2);
        }
        if let Some(depth) = reader.integer_in("max_depth", -1..=LARGEST_DEPTH) {
            settings.max_depth = u32::try_from(depth).ok();
        }
        if let Some(depth) = reader.integer_in("rr_depth", 1..=LARGEST_DEPTH) {
            settings.rr_depth = u32::try_from(depth).unwrap_or(u32::MAX);
        }
        if settings.plugin.has_photons() {
            let photons = reader
                .integer_in("photons", 0..=i64::from(IntegratorSettings::MOST_PHOTONS))
                .unwrap_or(0);
            settings.photons = u32::try_from(photons).ok().filter(|&photons| photons > 0);
            if let Some(radius) = reader.float_in("merge_radius", IntegratorSettings::MERGE_RADII) {
                settings.merge_radius = radius;
            }
        }
        settings.clamp_percentile = reader.float_in("clamp_percentile", IntegratorSettings::CLAMP_PERCENTILES);
        if settings.plugin.is_guidable() {
            settings.guided = reader.boolean_or("guided", false);
        }
        settings.hide_emitters = reader.boolean_or("hide_emitters", false);
        if known.is_some() {
            reader.ignore(&["timeout", "block_size", "samples_per_pass"]);
            if plugin == PathPlugin::VolPathMis.name() {
                // Paths always carry all colour channels together.
                reader.boolean("use_spectral_mis");
            }
            reader.finish();
            return settings;
        }
        // `aov` and similar integrators contain the one that makes the picture.
        let inner = reader.children(Category::Integrator).first().map(|(_, inner)| *inner);
        let layers = match plugin {
            "aov" => {
                let layers = read_layers(&mut reader);
                reader.finish();
                layers
            }
            _ => Layers::default(),
        };
        let settings = match inner {
            Some(inner) if depth < 8 => self.read_integrator_settings(inner, depth + 1),
            _ => settings,
        };
        IntegratorSettings {
            layers: layers.and(settings.layers),
            ..settings
        }
    }
}

/// The layers of an integrator `aov`, whose parameter `aovs` is a list of names and kinds: `dd:depth,nn:sh_normal`.
/// These names are the channels in Mitsuba's files; ours have fixed names.
fn read_layers(reader: &mut Reader) -> Layers {
    let known = Layer::ALL.map(Layer::name_in_file);
    let Some(list) = reader.string("aovs") else {
        let span = reader.object().span;
        reader.diagnostics().warn(
            span,
            "an `aov` without `aovs`, a list of layers such as `dd:depth,nn:sh_normal`, has none",
        );
        return Layers::default();
    };
    let mut layers = Vec::new();
    for entry in list.split(',').map(str::trim).filter(|entry| !entry.is_empty()) {
        let kind = entry.rsplit(':').next().unwrap_or(entry).trim();
        let span = Some(reader.span_of("aovs"));
        if let Some(layer) = Layer::from_name_in_file(kind) {
            layers.push(layer);
        } else if UNSUPPORTED.contains(&kind) {
            let message = format!("the layer `{kind}` is not supported: it is left out");
            reader.diagnostics().push(Severity::Warning, span, message, None);
        } else {
            let message = format!("there is no layer `{kind}`: it is left out");
            let nearest = reader
                .diagnostics()
                .did_you_mean(kind, known.iter().map(String::as_str));
            let help = nearest.or_else(|| Some(format!("the layers are {}", known.join(", "))));
            reader.diagnostics().push(Severity::Warning, span, message, help);
        }
    }
    layers.into_iter().collect()
}

/// Layers that Mitsuba has and this program lacks.
const UNSUPPORTED: [&str; 6] = ["dp_du", "dp_dv", "duv_dx", "duv_dy", "prim_index", "boundary_test"];
