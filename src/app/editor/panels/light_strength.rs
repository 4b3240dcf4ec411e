//! The strength of a light: in the radiometric unit of the file, or in a photometric unit that the user chooses in the
//! row.

use bevy_egui::egui::{self, Id, Ui};

use super::caption::Caption;
use super::fields::{VALUE_WIDTH, fit_slider, row, write_back};
use super::{menu_marks, typed};
use crate::engine::MeasureOf;
use crate::photometry::{LightUnit, Measure};

/// The width of the button with the unit, in points.
const BUTTON: f32 = 34.0;

/// The largest radiometric strength on a slider.
const RADIOMETRIC_END: f32 = 1000.0;
/// The decimals that strengths are rounded to, below the precision of the dimmest lamps.
const DECIMALS: usize = 9;

/// The units of a row.
#[derive(Clone, Copy)]
pub struct StrengthUnits<'a> {
    /// The radiometric unit with a blank before it; empty for a factor.
    pub radiometric: &'a str,
    /// The name of the parameter in the file.
    pub parameter: &'a str,
    /// The measures of all parameters of the light; none if the scene shows it in radiometric units.
    pub measures: &'a [MeasureOf],
}

impl<'a> StrengthUnits<'a> {
    /// A row that has its radiometric unit alone.
    pub fn radiometric(radiometric: &'a str) -> Self {
        Self {
            radiometric,
            parameter: "",
            measures: &[],
        }
    }

    fn measures(&self) -> impl Iterator<Item = Measure> {
        let own = self
            .measures
            .iter()
            .filter(|(parameter, _)| *parameter == self.parameter);
        own.map(|(_, measure)| *measure)
    }

    /// The measure of the unit that the user has chosen, or of the usual one; None for the radiometric unit.
    pub fn chosen(&self, ui: &Ui) -> Option<Measure> {
        let usual = self.measures().next()?;
        match ui.data(|data| data.get_temp::<Option<LightUnit>>(self.id()?)) {
            Some(unit) => self.measures().find(|measure| Some(measure.unit) == unit),
            None => Some(usual),
        }
    }

    /// Whether the quantity of the unit may name the row. The rows of sun and sky keep their own names.
    fn is_only_one(&self) -> bool {
        self.measures.iter().all(|(parameter, _)| *parameter == self.parameter)
    }

    /// The place of the choice, which all lights with the same parameter and the same usual unit share.
    fn id(&self) -> Option<Id> {
        let usual = self.measures().next()?;
        Some(Id::new(("unit of light", self.parameter, usual.unit)))
    }

    /// Shows the button that chooses the unit.
    fn choose(&self, ui: &mut Ui) {
        let (Some(id), chosen) = (self.id(), self.chosen(ui)) else {
            return;
        };
        let shown = chosen.map_or(self.radiometric.trim(), |measure| measure.unit.name());
        let shown = if shown.is_empty() { "×" } else { shown };
        ui.spacing_mut().button_padding.x = 2.0;
        let mut wanted = None;
        let button = egui::Button::new(egui::RichText::new(shown).small())
            .truncate()
            .min_size(egui::vec2(BUTTON, 0.0));
        let menu = egui::containers::menu::MenuButton::from_button(button);
        let (response, _) = menu.ui(ui, |ui| {
            for measure in self.measures() {
                let is_chosen = chosen.is_some_and(|chosen| chosen.unit == measure.unit);
                let text = format!("{} ({})", measure.unit.label(), measure.unit.name());
                if menu_marks::choice(ui, is_chosen, &text).clicked() {
                    wanted = Some(Some(measure.unit));
                }
            }
            let text = match self.radiometric.trim() {
                "" => "factor".to_owned(),
                unit => unit.to_owned(),
            };
            if menu_marks::choice(ui, chosen.is_none(), &format!("{text}, as in the file")).clicked() {
                wanted = Some(None);
            }
        });
        response.on_hover_text("The unit of this row");
        if let Some(unit) = wanted {
            ui.data_mut(|data| data.insert_temp::<Option<LightUnit>>(id, unit));
        }
    }
}

/// Shows the strength of a light whose colour has this luminance at a strength of 1; returns true if edited.
pub(crate) fn light_strength<'a>(
    ui: &mut Ui,
    caption: impl Into<Caption<'a>>,
    units: StrengthUnits,
    luminance: f32,
    strength: &mut f32,
) -> bool {
    let caption = caption.into();
    let has_choice = units.id().is_some();
    let beside = if has_choice {
        BUTTON + ui.spacing().item_spacing.x
    } else {
        0.0
    };
    let Some(measure) = units.chosen(ui) else {
        let scale = StrengthScale {
            unit: if has_choice { "" } else { units.radiometric },
            beside,
            ..StrengthScale::default()
        };
        return strength_beside(ui, caption, strength, scale, |ui| units.choose(ui));
    };
    let caption = match units.is_only_one() {
        true => caption.titled(measure.unit.quantity()),
        false => caption,
    };
    let factor = measure.per_strength * luminance;
    let mut shown = *strength * factor;
    let usual_end = match measure.unit {
        LightUnit::Lumen | LightUnit::Lux => 1e6,
        LightUnit::Candela | LightUnit::Nit => 1e7,
    };
    // The lights of scenes in millimetres have more.
    let end = match shown > usual_end {
        true => shown.max(RADIOMETRIC_END * factor),
        false => usual_end,
    };
    let scale = StrengthScale {
        ends: [0.1, end],
        beside,
        decimals: match shown {
            1000.0.. => 0,
            100.0.. => 1,
            10.0.. => 2,
            _ => 3,
        },
        ..StrengthScale::default()
    };
    let changed = strength_beside(ui, caption, &mut shown, scale, |ui| units.choose(ui)) && factor > 0.0;
    if changed {
        *strength = shown / factor;
    }
    changed
}

/// The scale of a slider for strengths, from 0 on.
#[derive(Clone, Copy)]
struct StrengthScale<'a> {
    /// The unit, behind the number.
    unit: &'a str,
    /// The smallest and the largest strength above 0.
    ends: [f32; 2],
    /// The width of the control beside it in points.
    beside: f32,
    /// The most decimals that are shown.
    decimals: usize,
}

impl Default for StrengthScale<'_> {
    fn default() -> Self {
        Self {
            unit: "",
            ends: [0.01, RADIOMETRIC_END],
            beside: 0.0,
            decimals: 3,
        }
    }
}

/// Shows a strength on a slider over many decades, with its number and a control at the end of the row.
fn strength_beside<'a>(
    ui: &mut Ui,
    caption: impl Into<Caption<'a>>,
    value: &mut f32,
    StrengthScale {
        unit,
        ends,
        beside,
        decimals,
    }: StrengthScale,
    control: impl FnOnce(&mut Ui),
) -> bool {
    let (caption, mut copy) = (caption.into(), *value);
    let range = 0.0..=ends[1];
    let slider = egui::Slider::new(&mut copy, range.clone())
        .clamping(egui::SliderClamping::Edits)
        .max_decimals(DECIMALS)
        .logarithmic(true)
        .smallest_positive(ends[0].into())
        .suffix(unit);
    let slider = typed::slider_shown_to(ui, slider, caption.text, unit, range, decimals);
    let changed = row(ui, caption, |ui| {
        fit_slider(ui, VALUE_WIDTH + 6.0 * unit.chars().count() as f32 + beside);
        ui.spacing_mut().interact_size.x -= beside;
        let response = ui.add(slider);
        control(ui);
        response
    })
    .changed();
    write_back(changed, value, copy)
}
