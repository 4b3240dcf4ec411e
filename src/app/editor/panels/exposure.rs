//! The exposure of the picture: in stops, as an exposure value, or by the settings of a camera.

use bevy_egui::egui::{Id, Ui};

use super::caption::Caption;
use super::fields;
use crate::app::editor::command::display::DisplaySettings;
use crate::photometry::exposure::{CameraExposure, ev100_of_stops, stops_of_ev100};

/// How the exposure is said.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Form {
    #[default]
    Stops,
    Ev100,
    Camera,
}

const FORMS: [(Form, &str); 3] = [(Form::Stops, "Stops"), (Form::Ev100, "EV100"), (Form::Camera, "Camera")];

/// The difference of exposure values below which a camera counts as set to the exposure.
const SAME: f32 = 1e-3;

/// Shows the rows of an exposure in stops; returns true if edited.
pub(super) fn exposure_rows(ui: &mut Ui, stops: &mut f32) -> bool {
    let (form_id, camera_id) = (Id::new("form of the exposure"), Id::new("exposure of the camera"));
    let mut form: Form = ui.data(|data| data.get_temp(form_id)).unwrap_or_default();
    let caption = Caption::from("Exposure by").explained(
        "Stops double the brightness. EV100 and cameras take radiance times 683 for nits, so that lamps and skies of real strengths look right.",
    );
    if fields::switch(ui, caption, &mut form, &FORMS) {
        ui.data_mut(|data| data.insert_temp(form_id, form));
    }
    let mut ev100 = ev100_of_stops(*stops);
    let changed = match form {
        Form::Stops => {
            return fields::slider_with(ui, "Exposure", stops, -10.0..=10.0, |slider| slider.suffix(" EV"));
        }
        Form::Ev100 => {
            let caption = Caption::from("EV100").explained(
                "The exposure value at ISO 100: 1.2 times two to its power are the nits that look white. Bright sun 15, an office 8, a room in the evening 5, the moon -3.",
            );
            fields::slider(ui, caption, &mut ev100, -6.0..=20.0)
        }
        Form::Camera => {
            let known: Option<CameraExposure> = ui.data(|data| data.get_temp(camera_id));
            let known = known.unwrap_or(CameraExposure {
                f_number: 4.0,
                ..CameraExposure::default()
            });
            let mut camera = match (known.ev100() - ev100).abs() < SAME {
                true => known,
                // The exposure was set elsewhere: the shutter follows.
                false => known.with_ev100(ev100),
            };
            let changed = camera_rows(ui, &mut camera);
            ui.data_mut(|data| data.insert_temp(camera_id, camera));
            ev100 = camera.ev100();
            changed
        }
    };
    if changed {
        let range = DisplaySettings::EXPOSURES;
        *stops = stops_of_ev100(ev100).clamp(*range.start(), *range.end());
    }
    changed
}

fn camera_rows(ui: &mut Ui, camera: &mut CameraExposure) -> bool {
    let aperture = Caption::from("Aperture").explained("The f-number: the focal length over the width of the opening.");
    let mut changed = fields::log_slider(ui, aperture, &mut camera.f_number, 0.7..=64.0);
    let shutter = Caption::from("Shutter").explained("The time that the shutter is open in seconds.");
    changed |= fields::log_slider(ui, shutter, &mut camera.shutter, 1e-4..=60.0);
    let iso = Caption::from("ISO").explained("The sensitivity of the sensor.");
    changed | fields::log_slider(ui, iso, &mut camera.iso, 25.0..=102_400.0)
}
