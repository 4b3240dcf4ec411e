//! Fills the data about the meters, once per frame.

use bevy::prelude::*;

use super::EditorModel;
use crate::app::editor::picture::metering::Metering;

pub(crate) fn gather_meters(metering: Option<Res<Metering>>, mut model: ResMut<EditorModel>) {
    if let Some(metering) = metering {
        model.0.meters = metering.shown().clone();
    }
}
