//! Lights given in photometric units and by the temperature of their colour: real lamps of the table, and values such
//! as `800lm 2700K`.

use crate::color::temperature::{DUVS, TEMPERATURES, Temperature};
use crate::color::{BRIGHTEST, Rgb, luminance};
use crate::engine::MeasureOf;
use crate::photometry::LightUnit;
use crate::photometry::lamps::{Lamp, LampForm};
use crate::scene::{Declared, Parameter, ParameterMut};

/// A light in photometric units: its amount, its colour or both.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PhotometricValue {
    /// The amount in a unit; None keeps the luminance.
    pub amount: Option<(f32, LightUnit)>,
    /// The colour; None keeps it.
    pub color: Option<Temperature>,
}

impl From<&Lamp> for PhotometricValue {
    fn from(lamp: &Lamp) -> Self {
        Self {
            amount: Some((lamp.amount, lamp.unit)),
            color: Some(Temperature {
                kelvin: lamp.kelvin,
                duv: lamp.duv,
            }),
        }
    }
}

impl PhotometricValue {
    /// Parses an amount such as `800lm`, `1200cd`, `500lx` or `80nit`, a temperature such as `2700K` with an optional
    /// Duv behind it, or both. None for any other text, and for numbers out of their ranges.
    pub fn parse(text: &str) -> Option<Self> {
        let mut words = text.split_whitespace().peekable();
        let number = |text: &str| text.parse().ok().filter(|number: &f32| number.is_finite());
        let amount = words.peek().and_then(|word| {
            let end = word.find(|letter: char| letter.is_ascii_alphabetic() && letter != 'e')?;
            let amount = number(&word[..end]).filter(|amount| *amount >= 0.0)?;
            Some((amount, LightUnit::of_name(&word[end..])?))
        });
        if amount.is_some() {
            words.next();
        }
        let color = match words.next() {
            Some(word) => {
                let kelvin = number(word.strip_suffix('K')?).filter(|kelvin| TEMPERATURES.contains(kelvin))?;
                let duv = words
                    .next()
                    .map_or(Some(0.0), number)
                    .filter(|duv| DUVS.contains(duv))?;
                Some(Temperature { kelvin, duv })
            }
            None => None,
        };
        (words.next().is_none() && (amount.is_some() || color.is_some())).then_some(Self { amount, color })
    }

    /// Gives a light the value, by its measures. With a name only that parameter is set, else the one that has a
    /// measure in the unit. The error is a sentence without a full stop.
    pub(crate) fn apply(
        &self,
        light: &mut impl Declared,
        measures: &[MeasureOf],
        parameter: Option<&str>,
    ) -> Result<(), String> {
        let fits = |(name, measure): &&MeasureOf| {
            parameter.is_none_or(|wanted| wanted == *name) && self.amount.is_none_or(|(_, unit)| unit == measure.unit)
        };
        let Some((name, measure)) = measures.iter().find(fits) else {
            let own = measures
                .iter()
                .filter(|(name, _)| parameter.is_none_or(|wanted| wanted == *name));
            let known: Vec<&str> = own.map(|(_, measure)| measure.unit.label()).collect();
            return Err(match (self.amount, &known[..]) {
                (_, []) => "the light has no strength in photometric units".to_owned(),
                (Some((_, unit)), known) => {
                    format!("{} do not fit the light, only {}", unit.label(), known.join(" and "))
                }
                (None, _) => "the parameter has no colour".to_owned(),
            });
        };
        let strength = self.amount.map(|(amount, _)| amount / measure.per_strength);
        let mut result = Ok(());
        light.visit_mut(&mut |info, value| {
            if info.name != *name {
                return;
            }
            match value {
                ParameterMut::Emission(value) | ParameterMut::TexturedEmission(Parameter::Constant(value)) => {
                    match self.shone(*value, strength) {
                        shone if shone.max_element() <= BRIGHTEST => *value = shone,
                        _ => result = Err(TOO_BRIGHT.to_owned()),
                    }
                }
                ParameterMut::Factor(_) if self.color.is_some() => {
                    result = Err(format!("{name} is a factor and has no colour"));
                }
                ParameterMut::Factor(value) => match strength.filter(|strength| *strength <= BRIGHTEST) {
                    Some(strength) => *value = strength,
                    None => result = Err(TOO_BRIGHT.to_owned()),
                },
                _ => result = Err(format!("{name} is no strength")),
            }
        });
        result
    }

    /// Gives a light the strength and the colour of a lamp, by its measures. Lights with the colours of a picture keep
    /// them. The error is a sentence without a full stop.
    pub(crate) fn apply_lamp(lamp: &Lamp, light: &mut impl Declared, measures: &[MeasureOf]) -> Result<(), String> {
        let parameter = strength_of(lamp, measures).ok_or("the lamp is of another kind than the light")?;
        let value = Self::from(lamp);
        let alone = Self { color: None, ..value };
        let applied = value.apply(light, measures, Some(parameter));
        applied.or_else(|_| alone.apply(light, measures, Some(parameter)))
    }

    /// The radiometric value of this luminance; None for that which it has.
    fn shone(&self, before: Rgb, wanted: Option<f32>) -> Rgb {
        let color = match self.color {
            Some(temperature) => temperature.color(),
            None if luminance(before) > 0.0 => before,
            None => Rgb::ONE,
        };
        color * (wanted.unwrap_or_else(|| luminance(before)) / luminance(color))
    }
}

/// The parameter of a light with the strength that a lamp gives; None if the lamp is of another kind. Skies and
/// parallel light, which both have lux, are told apart.
pub(crate) fn strength_of(lamp: &Lamp, measures: &[MeasureOf]) -> Option<&'static str> {
    let fits = |(name, measure): &&MeasureOf| {
        let is_of_kind = match lamp.form {
            LampForm::Sky => ["radiance", "scale", "sky_scale"].contains(name),
            LampForm::Parallel => ["irradiance", "sun_scale"].contains(name),
            LampForm::Point | LampForm::Spot { .. } | LampForm::Rectangle { .. } | LampForm::Tube { .. } => true,
        };
        is_of_kind && measure.unit == lamp.unit
    };
    measures.iter().find(fits).map(|(name, _)| *name)
}

/// The message about a strength beyond the brightest one.
const TOO_BRIGHT: &str = "the light would be brighter than lights can be";

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::measures_of_emitter;
    use crate::photometry::LUMENS_PER_WATT;
    use crate::scene::{Emitter, EmitterKind};

    #[test]
    fn values_have_an_amount_or_a_temperature_or_both() {
        let parsed = |text| PhotometricValue::parse(text);
        let warm = Temperature {
            kelvin: 2700.0,
            duv: 0.0,
        };
        assert_eq!(
            parsed("800lm 2700K"),
            Some(PhotometricValue {
                amount: Some((800.0, LightUnit::Lumen)),
                color: Some(warm)
            })
        );
        let only = parsed("1e3cd").expect("an amount");
        assert_eq!((only.amount, only.color), (Some((1000.0, LightUnit::Candela)), None));
        let colored = parsed("4000K -0.003").expect("a colour");
        assert_eq!(colored.color.map(|color| color.duv), Some(-0.003));
        for wrong in [
            "",
            "800",
            "lm",
            "-1lm",
            "800lm warm",
            "800lm 2700K 0.001 1",
            "2700",
            "1 2 3",
            "20K",
            "#ffffff",
            "3K lm",
        ] {
            assert_eq!(parsed(wrong), None, "{wrong}");
        }
    }

    #[test]
    fn a_light_takes_the_amount_in_its_units() {
        let mut light = Emitter::of_plugin("point").expect("a plugin");
        let measures = measures_of_emitter(&light, Default::default(), None, 1.0);
        let value = PhotometricValue::parse("800lm 2700K").expect("a value");
        value.apply(&mut light, &measures, None).expect("it fits");
        let EmitterKind::Point { intensity } = light.kind else {
            panic!("{light:?}")
        };
        let lumens = luminance(intensity) * LUMENS_PER_WATT * 4.0 * std::f32::consts::PI;
        assert!(
            (lumens / 800.0 - 1.0).abs() < 1e-5 && intensity.x > 2.0 * intensity.z,
            "{intensity}"
        );
        let error = PhotometricValue::parse("80nit")
            .expect("a value")
            .apply(&mut light, &measures, None);
        assert_eq!(
            error,
            Err("nits do not fit the light, only lumens and candela".to_owned())
        );
    }
    #[test]
    fn skies_and_parallel_light_take_the_lamps_of_their_kind() {
        let [sun, sky] = ["noon-sun", "overcast-sky"].map(|name| Lamp::of_name(name).expect("a lamp"));
        let measures = |plugin| {
            let light = Emitter::of_plugin(plugin).expect("a plugin");
            (
                light.clone(),
                measures_of_emitter(&light, Default::default(), None, 1.0),
            )
        };
        let (mut both, of_both) = measures("sunsky");
        assert_eq!(strength_of(sun, &of_both), Some("sun_scale"));
        assert_eq!(strength_of(sky, &of_both), Some("sky_scale"));
        let before = both.clone();
        PhotometricValue::apply_lamp(sky, &mut both, &of_both).expect("a sky");
        let (EmitterKind::SunSky(before), EmitterKind::SunSky(after)) = (before.kind, &both.kind) else {
            panic!("{both:?}")
        };
        assert!(after.sun_scale == before.sun_scale && after.sky_scale != before.sky_scale);
        let colored = PhotometricValue::parse("4000K").expect("a colour");
        let error = colored.apply(&mut both, &of_both, Some("sky_scale"));
        assert_eq!(error, Err("sky_scale is a factor and has no colour".to_owned()));
        let (mut constant, of_constant) = measures("constant");
        assert_eq!(strength_of(sun, &of_constant), None);
        assert!(PhotometricValue::apply_lamp(sun, &mut constant, &of_constant).is_err());
        let far = PhotometricValue::parse("1e30nit").expect("an amount");
        assert_eq!(far.apply(&mut constant, &of_constant, None), Err(TOO_BRIGHT.to_owned()));
    }
}
