//! What `sunroom measure` prints and writes.

use std::fmt::Write;

use serde_json::{Value, json};
use sunroom::app::metering::Upward;
use sunroom::meter::daylight::{OPEN_GROUND, daylight_factor};
use sunroom::meter::estimate::Estimate;
use sunroom::meter::glare::Glare;
use sunroom::meter::job::{Judgement, MeterEnding, MeterReading};
use sunroom::photometry::units::{Lux, Nit, short};

/// The values of all meters.
pub struct Results {
    pub readings: Vec<MeterReading>,
    /// The glare of the view, if it was asked for.
    pub glare: Option<Glare>,
    /// The upward direction of the overcast sky under which daylight factors were measured; None under the lights of
    /// the scene.
    pub up: Option<Upward>,
    /// The relative error asked for.
    pub noise: f64,
    pub seconds: f64,
    pub ending: MeterEnding,
}

impl Results {
    /// Whether all limits are met.
    pub fn passes(&self) -> bool {
        self.readings.iter().all(MeterReading::passes)
    }

    /// Whether any limit is asked for.
    pub fn has_limits(&self) -> bool {
        self.readings.iter().any(|reading| !reading.judgements().is_empty())
    }

    /// An illuminance in the unit of the report.
    fn lit(&self, measured: &Estimate) -> String {
        match self.up {
            Some(_) => measured.in_daylight_factor(),
            None => measured.in_unit(Lux::SYMBOL),
        }
    }

    /// The sentence about the overcast sky.
    pub fn about_sky(&self) -> Option<String> {
        let Upward { direction, source } = self.up?;
        let ground = short(f64::from(OPEN_GROUND));
        let axes = [("x", direction.x), ("y", direction.y), ("z", direction.z)];
        let named = |(name, part): &(&str, f32)| match *part {
            1.0 => Some((*name).to_owned()),
            -1.0 => Some(format!("-{name}")),
            _ => None,
        };
        let up = axes.iter().find_map(named).unwrap_or_else(|| direction.to_string());
        Some(format!(
            "daylight factors, under a CIE overcast sky that gives the open ground {ground} lx; up is {up}, by {source}"
        ))
    }

    /// A line for each meter, and one below it for each of its limits.
    pub fn text(&self) -> String {
        let mut text = String::new();
        if let Some(about) = self.about_sky() {
            let _ = writeln!(text, "{about}");
        }
        let widest = self.readings.iter().map(|reading| reading.name.chars().count()).max();
        let width = widest.unwrap_or_default();
        for reading in &self.readings {
            let name = &reading.name;
            let _ = writeln!(text, "{name:width$}  {}", self.values(reading));
            for judgement in reading.judgements() {
                let _ = writeln!(text, "{:width$}  {}", "", sentence(&judgement));
            }
        }
        if let Some(glare) = &self.glare {
            let _ = writeln!(text, "{}", glare_sentence(glare));
        }
        if self.missed_noise() {
            let percent = short(100.0 * self.noise);
            let _ = writeln!(
                text,
                "some errors are above {percent} %: more --spp or --time lowers them"
            );
        }
        text
    }

    /// The values of a meter in one line.
    pub fn values(&self, reading: &MeterReading) -> String {
        match (&reading.grid, reading.points.first()) {
            (Some(grid), _) => format!(
                "{} x {} points  least {}  mean {}  uniformity {}",
                reading.size.x,
                reading.size.y,
                self.lit(&grid.least),
                self.lit(&grid.mean),
                grid.uniformity
                    .map_or("none in the dark".to_owned(), |found| found.in_unit(""))
                    .trim_end(),
            ),
            (None, Some(point)) => self.lit(point),
            (None, None) => String::new(),
        }
    }

    /// Whether an error is above the one asked for.
    fn missed_noise(&self) -> bool {
        let noise = |reading: &MeterReading| match &reading.grid {
            Some(grid) => grid.least.relative_error().max(grid.mean.relative_error()),
            None => reading.points.first().map_or(0.0, Estimate::relative_error),
        };
        self.readings.iter().any(|reading| noise(reading) > self.noise)
    }

    /// The values with the points of all grids, as one object.
    pub fn json(&self) -> Value {
        let ending = match self.ending {
            MeterEnding::Done => "done",
            MeterEnding::TimeUp => "time",
            MeterEnding::Cancelled => "interrupted",
        };
        json!({
            "meters": self.readings.iter().map(|reading| self.meter(reading)).collect::<Vec<_>>(),
            "glare": self.glare.as_ref().map(glare_values),
            "passes": self.passes(),
            "ending": ending,
            "seconds": self.seconds,
            "open_ground_lux": self.up.map(|_| OPEN_GROUND),
            "up": self.up.map(|up| up.direction.to_array()),
        })
    }

    fn meter(&self, reading: &MeterReading) -> Value {
        let places = reading.positions.iter().zip(&reading.points);
        let points: Vec<Value> = places
            .map(|(place, measured)| json!({"position": place.to_array(), "illuminance": self.value(measured)}))
            .collect();
        let limits: Vec<Value> = reading
            .judgements()
            .iter()
            .map(|judgement| {
                json!({
                    "of": judgement.of,
                    "limit": judgement.limit,
                    "passes": judgement.passes(),
                    "within_error": judgement.is_close(),
                })
            })
            .collect();
        let grid = reading.grid.as_ref().map(|grid| {
            json!({
                "columns": reading.size.x,
                "rows": reading.size.y,
                "least": self.value(&grid.least),
                "mean": self.value(&grid.mean),
                "uniformity": grid.uniformity.as_ref().map(plain),
                "darkest": grid.darkest,
            })
        });
        json!({
            "name": reading.name,
            "normal": reading.normal.to_array(),
            "points": points,
            "grid": grid,
            "samples": reading.samples,
            "limits": limits,
            "passes": reading.passes(),
        })
    }

    /// An illuminance, with its daylight factor in per cent.
    fn value(&self, measured: &Estimate) -> Value {
        let mut value = json!({"lux": measured.value, "error": measured.error});
        if self.up.is_some() {
            value["daylight_factor"] = plain(&measured.daylight_factor());
        }
        value
    }

    /// A row for each point.
    pub fn csv(&self) -> String {
        let mut text = "meter,column,row,x,y,z,lux,error".to_owned();
        text.push_str(if self.up.is_some() { ",daylight_factor\n" } else { "\n" });
        for reading in &self.readings {
            let name = quoted(&reading.name);
            let columns = reading.size.x.max(1) as usize;
            for (number, (place, measured)) in reading.positions.iter().zip(&reading.points).enumerate() {
                let (column, row) = (number % columns, number / columns);
                let Estimate { value, error } = measured;
                let _ = write!(
                    text,
                    "{name},{column},{row},{},{},{},{value},{error}",
                    place.x, place.y, place.z
                );
                if self.up.is_some() {
                    let _ = write!(text, ",{}", daylight_factor(*value));
                }
                text.push('\n');
            }
        }
        text
    }
}

fn plain(measured: &Estimate) -> Value {
    json!({"value": measured.value, "error": measured.error})
}

pub fn glare_sentence(glare: &Glare) -> String {
    let background = glare.background.in_unit(Nit::SYMBOL);
    match &glare.rating {
        Some(rating) => format!(
            "UGR {}  background {background}  sources above {}, {} sr",
            rating.in_unit("").trim_end(),
            Nit(glare.threshold),
            short(glare.solid_angle),
        ),
        None => format!(
            "no UGR: nothing is brighter than {}, or nothing else is lit",
            Nit(glare.threshold)
        ),
    }
}

fn glare_values(glare: &Glare) -> Value {
    json!({
        "ugr": glare.rating.as_ref().map(plain),
        "background": plain(&glare.background),
        "threshold": glare.threshold,
        "solid_angle": glare.solid_angle,
    })
}

/// A limit with what has become of it.
pub fn sentence(judgement: &Judgement) -> String {
    let Judgement { of, limit, .. } = judgement;
    let limit = match *of {
        "uniformity" => short(*limit),
        _ => Lux(*limit).to_string(),
    };
    let verdict = if judgement.passes() { "pass" } else { "FAIL" };
    let close = match judgement.is_close() {
        true => ", but the limit is within two errors",
        false => "",
    };
    format!("{of} {limit} asked for: {verdict}{close}")
}

/// A field of a CSV file (RFC 4180).
fn quoted(field: &str) -> String {
    match field.contains(['"', ',', '\n', '\r']) {
        true => format!("\"{}\"", field.replace('"', "\"\"")),
        false => field.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_with_commas_are_quoted() {
        assert_eq!(quoted("desk"), "desk");
        assert_eq!(quoted("desk, \"left\""), "\"desk, \"\"left\"\"\"");
    }
}
