//! The view of a scene: its camera, its visible surfaces, its integrator, and the guide of its paths.

use super::{Extracted, Flight};
use crate::engine::authored::{Authored, name_of};
use crate::engine::auto::{AutoIntegrator, before_choice};
use crate::engine::clipping::clipping_warning;
use crate::engine::control::{RenderControl, SightControl};
use crate::engine::pack::Checker;
use crate::engine::pack::view::pack_view;
use crate::engine::resolution::{self, is_same_at_other_size};
use crate::render::auto::{Choice, Method};
use crate::render::borders::medium_at;
use crate::render::guide::Guide;
use crate::render::view::View;
use crate::render::visibility::sight::Sight;
use crate::scene::Sensor;

impl Extracted {
    /// Whether the view differs from `old` in nothing but the number of pixels.
    pub(super) fn sees_as(&self, old: Option<&View>) -> bool {
        match (&self.view, old) {
            (Some(view), Some(old)) => is_same_at_other_size(old, view),
            (view, old) => view.is_none() && old.is_none(),
        }
    }

    /// Sets the medium of the view: a view moved across borders of media is in another medium than its sensor.
    pub(super) fn update_medium_of_view(&mut self) {
        if let (Some(view), Some(flight)) = (&mut self.view, &self.flight) {
            view.medium = medium_at(&self.scene, flight.from, flight.medium, flight.to);
        }
    }

    pub(super) fn update_sight(&mut self, control: &SightControl) {
        let only = (self.seen_alone).update(&control.only, &self.scene.geometry, &self.entity_of_instance);
        if let Some(view) = &mut self.view {
            view.sight = Sight {
                passes_backs: control.passes_backs,
                outer_walls: self.seen_through.update(control.passes_backs, &self.scene.geometry),
                cut: control.cut,
                only,
            };
        }
    }

    /// Sets the scene's guide in the view. If the scene has changed, that is a new guide, because the old one would
    /// have to be learnt again and would keep the old scene alive. Returns the old guide.
    pub(super) fn keep_guide(&mut self, same_scene: bool) -> Option<Guide> {
        let old = (!same_scene).then(|| std::mem::take(&mut self.guide));
        if let Some(view) = &mut self.view {
            view.guide = self.guide_is_asked.then(|| self.guide.clone());
        }
        old
    }

    /// Sets the chosen integrator in the view, or the integrator before a choice if there is none.
    pub(in crate::engine) fn take_choice(&mut self, auto: &AutoIntegrator) {
        let Some(view) = &mut self.view else { return };
        let choice = auto.choice(&self.scene, view).unwrap_or(Choice::UNTRIED);
        view.integrator = choice.integrator(view.integrator.settings());
        let is_guided = self.guide_is_asked || choice.method == Method::GuidedPath;
        view.guide = is_guided.then(|| self.guide.clone());
    }

    /// Resets the view to the integrator before a choice if `auto` is selected.
    pub(super) fn forget_choice(&mut self, is_auto: bool) {
        if let Some(view) = self.view.as_mut().filter(|_| is_auto) {
            view.integrator = before_choice(&self.scene, view);
        }
    }

    pub(super) fn update_clipping(&mut self) {
        self.errors.clipping.clear();
        let view = self.view.as_ref();
        if let Some(warning) = view.and_then(|view| clipping_warning(&self.scene.geometry, &view.camera)) {
            let mut check = Checker {
                name: &self.sensor_name,
                errors: &mut self.errors.clipping,
            };
            check.report(warning);
        }
    }

    pub(super) fn update_view(&mut self, authored: &Authored, control: &RenderControl) {
        self.errors.view.clear();
        // Without a sensor the last view stays, so that replacing one sensor by another shows no blank picture in
        // between.
        let Some((order, id, sensor, film, to_world, in_medium)) =
            authored.active.0.and_then(|sensor| authored.sensors.get(sensor).ok())
        else {
            return;
        };
        let name = name_of("sensor", *order, id);
        let mut check = Checker {
            name: &name,
            errors: &mut self.errors.view,
        };
        let (integrator, sampler) = (&authored.integrator, &authored.sampler);
        let pose = authored.free_view.pose.unwrap_or(to_world.0);
        let lens = authored.free_view.lens.unwrap_or(sensor.lens);
        let sensor = &Sensor { lens, ..*sensor };
        let medium = in_medium.and_then(|medium| self.packed_media.ids.get(&medium.0).copied());
        let view = pack_view(sensor, film, pose, integrator, sampler, medium, control, &mut check);
        if view.is_some() {
            self.guide_is_asked = view.as_ref().is_some_and(|view| view.guide.is_some());
            self.view = view;
            self.sensor_name = name;
            self.flight = authored.free_view.pose.map(|pose| Flight {
                from: to_world.0.translation.into(),
                medium,
                to: pose.translation.into(),
            });
        }
        (self.sample_count, self.noise_target) = (film.sample_count, film.noise_target);
        self.is_adaptive = film.adaptive;
        self.full_size = resolution::full_size(film, control);
    }
}
