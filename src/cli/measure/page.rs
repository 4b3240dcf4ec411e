//! Makes an HTML page of measured values: one file, with plans of the grids in false colour.

use std::fmt::Write;

use sunroom::app::editor::command::display::heat;
use sunroom::meter::estimate::Estimate;
use sunroom::meter::job::MeterReading;
use sunroom::photometry::units::{Lux, short};

use super::results::{Results, glare_sentence, sentence};
use crate::cli::html::{escaped, filled};

/// The longer side of a plan, in CSS pixels.
const SIDE: f64 = 480.0;
/// The smallest cell that has its value written into it, in CSS pixels.
const ROOM_FOR_TEXT: f64 = 34.0;

/// The page of the values of a scene.
pub fn page(scene: &str, results: &Results) -> String {
    let meters: String = results.readings.iter().map(|reading| meter(results, reading)).collect();
    let notes = results
        .about_sky()
        .into_iter()
        .chain(results.glare.as_ref().map(glare_sentence));
    let notes: String = notes.map(|note| format!("<p>{}</p>\n", escaped(&note))).collect();
    let verdict = match (results.has_limits(), results.passes()) {
        (false, _) => "no limits are asked for",
        (true, true) => "all limits are met",
        (true, false) => "not all limits are met",
    };
    filled(
        include_str!("page.html"),
        &[
            ("scene", escaped(scene)),
            ("verdict", verdict.to_owned()),
            ("notes", notes),
            ("meters", meters),
            ("version", env!("CARGO_PKG_VERSION").to_owned()),
        ],
    )
}

/// The section of a meter: its values, its limits, and the plan of a grid.
fn meter(results: &Results, reading: &MeterReading) -> String {
    let mut section = format!(
        "<section>\n<h2>{}</h2>\n<p>{}</p>\n",
        escaped(&reading.name),
        escaped(&results.values(reading))
    );
    for judgement in reading.judgements() {
        let class = if judgement.passes() { "pass" } else { "fail" };
        let _ = writeln!(section, "<p class=\"{class}\">{}</p>", escaped(&sentence(&judgement)));
    }
    if let Some(grid) = &reading.grid {
        section.push_str(&plan(reading, grid.darkest));
    }
    section.push_str("</section>\n");
    section
}

/// The plan of a grid, as seen from its lit side: x to the right, y upwards. The darkest point has a frame.
fn plan(reading: &MeterReading, darkest: usize) -> String {
    let [columns, rows] = reading.size.to_array();
    let cell = SIDE / f64::from(columns.max(rows));
    let values = || reading.points.iter().map(|point| point.value);
    let (least, most) = (values().fold(f64::INFINITY, f64::min), values().fold(0.0, f64::max));
    let (width, height) = (cell * f64::from(columns), cell * f64::from(rows));
    let mut svg =
        format!("<figure><svg viewBox=\"0 0 {width:.0} {height:.0}\" width=\"{width:.0}\" height=\"{height:.0}\">\n");
    for (number, Estimate { value, error }) in reading.points.iter().enumerate() {
        let (column, row) = (number as u32 % columns, number as u32 / columns);
        let (x, y) = (cell * f64::from(column), cell * f64::from(rows - 1 - row));
        let share = ((value - least) / (most - least).max(f64::MIN_POSITIVE)) as f32;
        let [r, g, b] = heat(share).map(|channel| (255.0 * channel) as u8);
        let frame = match number == darkest {
            true => " stroke=\"#fff\" stroke-width=\"2\"",
            false => "",
        };
        let _ = write!(
            svg,
            "<rect x=\"{x:.1}\" y=\"{y:.1}\" width=\"{cell:.2}\" height=\"{cell:.2}\" fill=\"#{r:02x}{g:02x}{b:02x}\"{frame}><title>{value:.1} &#177; {error:.1} lx</title></rect>"
        );
        if cell >= ROOM_FOR_TEXT {
            let ink = if u32::from(r) + u32::from(g) + u32::from(b) > 380 {
                "#000"
            } else {
                "#fff"
            };
            let _ = write!(
                svg,
                "<text x=\"{:.1}\" y=\"{:.1}\" fill=\"{ink}\">{}</text>",
                x + 0.5 * cell,
                y + 0.5 * cell,
                short(*value)
            );
        }
        svg.push('\n');
    }
    let ends = format!("<span>{}</span><span>{}</span>", Lux(least), Lux(most));
    svg + "</svg>\n<div class=\"scale\"></div><figcaption class=\"ends\">" + &ends + "</figcaption></figure>\n"
}
