//! The light of an area in sentences, and as JSON.

use std::path::PathBuf;

use serde::Serialize;
use sunroom::engine::reasons::{Group, Grouping, NO_LIGHT, listed, percent, thing_name};
use sunroom::photometry::units::Nit;
use sunroom::render::breakdown::{Area, Batches, Breakdown, Portion, break_down};
use sunroom::render::part::Crop;
use sunroom::render::view::View;

use super::question::Question;
use crate::cli::report::{Failure, counted};

/// The light of an area of the picture. Radiances are in W/(m^2 sr) of linear Rec. 709, luminances their Y; shares and
/// noise are parts of the whole.
#[derive(Serialize)]
struct Report {
    scene: PathBuf,
    width: u32,
    height: u32,
    /// Left, top, width and height in pixels.
    area: [u32; 4],
    spp: u64,
    seed: u32,
    radiance: [f32; 3],
    luminance: f32,
    error: f32,
    groupings: Vec<Grouped>,
    noise: Vec<Cause>,
}

/// The light in one grouping, the brightest group first.
#[derive(Serialize)]
struct Grouped {
    grouping: &'static str,
    groups: Vec<Part>,
}

#[derive(Serialize)]
struct Part {
    text: String,
    /// The names of the things in the text.
    things: Vec<String>,
    radiance: [f32; 3],
    luminance: f32,
    error: f32,
    share: f32,
    share_error: f32,
    noise: f32,
}

/// A reason of the noise, with the method that helps.
#[derive(Serialize)]
struct Cause {
    cause: &'static str,
    text: &'static str,
    share: f32,
    remedy: &'static str,
}

/// The samples of all pixels by default, and the least samples of a pixel.
const SAMPLES: u64 = 1 << 16;
const SAMPLES_OF_PIXEL: u64 = 64;

impl Question<'_> {
    /// The report on the light of an area; None if interrupted.
    pub fn area(&self, pool: &rayon::ThreadPool) -> Result<Option<String>, Failure> {
        let area = match (self.args.subject.at, self.args.subject.region) {
            (Some(pixel), _) => Area::pixel(pixel),
            (None, Some(Crop { x, y, width, height })) => Area { x, y, width, height },
            (None, None) => return Err(Failure::Usage("expected --at, --region or --lamp".to_owned())),
        };
        let View { width, height, .. } = self.view;
        if !area.is_within(width, height) {
            return Err(Failure::Usage(format!(
                "the place is outside of the picture, which has {width} x {height} pixels"
            )));
        }
        let usual = (SAMPLES / area.pixels()).clamp(SAMPLES_OF_PIXEL, SAMPLES) as u32;
        let batches = Batches::of(self.args.spp.unwrap_or(usual));
        let found = self.search(pool, |progress| {
            break_down(&self.scene, &self.view, area, batches, progress)
        });
        let Some(breakdown) = found else {
            return Ok(None);
        };
        let report = Report::new(self, &breakdown);
        Ok(Some(match self.args.json {
            true => format!("{}\n", serde_json::to_string_pretty(&report)?),
            false => report.text(),
        }))
    }
}

impl Report {
    fn new(of: &Question, breakdown: &Breakdown) -> Self {
        let name = |entity| thing_name(of.world, entity);
        let part = |portion: Portion<Group>| Part {
            text: portion.key.text(&name),
            things: portion.key.things().into_iter().map(name).collect(),
            radiance: portion.light.to_array(),
            luminance: portion.luminance,
            error: portion.error,
            share: portion.share,
            share_error: portion.share_error,
            noise: portion.noise,
        };
        let grouped = |grouping: Grouping| Grouped {
            grouping: grouping.name(),
            groups: of.things.portions(breakdown, grouping).into_iter().map(part).collect(),
        };
        let value = breakdown.value();
        let area = breakdown.area;
        Self {
            scene: of.args.scene.scene.clone(),
            width: of.view.width,
            height: of.view.height,
            area: [area.x, area.y, area.width, area.height],
            spp: breakdown.batches.total(),
            seed: of.view.seed,
            radiance: value.light.to_array(),
            luminance: value.luminance,
            error: value.error,
            groupings: Grouping::ALL.map(grouped).into(),
            noise: (breakdown.advice().iter())
                .map(|advice| Cause {
                    cause: advice.trouble.name(),
                    text: advice.trouble.label(),
                    share: advice.noise,
                    remedy: advice.trouble.remedy(),
                })
                .collect(),
        }
    }

    fn text(&self) -> String {
        let [x, y, width, height] = self.area;
        let place = match (width, height) {
            (1, 1) => format!("Pixel {x}, {y}"),
            _ => format!("{width} x {height} pixels from {x}, {y} on"),
        };
        let [r, g, b] = self.radiance;
        let watts = |value: f32| Nit::of_watts(f64::from(value));
        let mut lines = vec![format!(
            "{place}: radiance {r:.4} {g:.4} {b:.4}, {}, by {}",
            watts(self.luminance).with_error(watts(self.error).0),
            counted(self.spp, "sample") + if (width, height) != (1, 1) { " per pixel" } else { "" },
        )];
        if self.luminance == 0.0 {
            lines.push(NO_LIGHT.to_owned());
        }
        for grouped in self.groupings.iter().filter(|_| self.luminance != 0.0) {
            let label = Grouping::of_name(grouped.grouping).map_or("", Grouping::label);
            lines.extend([String::new(), format!("{label}:")]);
            lines.extend(grouped.lines());
        }
        if !self.noise.is_empty() {
            lines.extend([String::new(), "The noise is made of:".to_owned()]);
        }
        for cause in &self.noise {
            lines.push(format!(
                "{:>5.0} %  {}. {}",
                100.0 * cause.share,
                cause.text,
                cause.remedy
            ));
        }
        lines.join("\n") + "\n"
    }
}

impl Grouped {
    fn lines(&self) -> Vec<String> {
        let (told, rest) = listed(&self.groups, |part| part.share);
        let mut lines: Vec<String> = told.iter().map(Part::line).collect();
        if !rest.is_empty() {
            let share: f32 = rest.iter().map(|part| part.share).sum();
            let percent = rest_percent(share);
            lines.push(format!("{percent:>16}  in {}", counted(rest.len(), "smaller group")));
        }
        lines
    }
}

impl Part {
    fn line(&self) -> String {
        format!("{:>16}  {}", percent(self.share, self.share_error), self.text)
    }
}

/// The sum of small shares in percent.
pub fn rest_percent(share: f32) -> String {
    format!("{:.1} %", 100.0 * share)
}
