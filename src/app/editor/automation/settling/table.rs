//! The report: the figures of each edit at each time, and their means.

use serde::Serialize;

use super::figures::Figures;

/// The pictures that are compared with the converged one, in the order in which they are shown: the one from before the
/// edit, as if it had stayed, some soon after it, and the one with all samples.
pub(super) const PICTURES: [&str; 6] = ["kept", "0.1s", "0.3s", "1s", "3s", "end"];

/// The seconds after the command of the inner [`PICTURES`].
pub(super) const TIMES: [f32; PICTURES.len() - 2] = [0.1, 0.3, 1.0, 3.0];

/// The figures of a picture, with and without carrying over.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(super) struct Row {
    pub picture: &'static str,
    pub carried: Option<Figures>,
    /// Without carrying over; None for the last picture, which is the converged one itself.
    pub anew: Option<Figures>,
}

/// The rows of an edit, one for each of [`PICTURES`].
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(super) struct EditRows {
    pub edit: &'static str,
    pub rows: Vec<Row>,
}

/// The whole measurement.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub(super) struct Report {
    pub scene: String,
    /// The samples per pixel of a converged picture.
    pub samples: u32,
    /// Whether the converged pictures are denoised.
    pub denoised: bool,
    pub width: u32,
    pub height: u32,
    pub edits: Vec<EditRows>,
    /// The means over all edits.
    pub means: Vec<Row>,
    /// The edits that do not apply to the scene, or that changed nothing.
    pub skipped: Vec<&'static str>,
}

impl Report {
    pub fn take_means(&mut self) {
        let mean = |place: usize, of: fn(&Row) -> Option<Figures>| {
            let rows = self.edits.iter().filter_map(|edit| edit.rows.get(place));
            Figures::mean(&rows.filter_map(of).collect::<Vec<Figures>>())
        };
        let row = |(place, picture)| Row {
            picture,
            carried: mean(place, |row| row.carried),
            anew: mean(place, |row| row.anew),
        };
        self.means = (0..).zip(PICTURES).map(row).collect();
    }
}

/// The two lines above the table.
pub(super) fn header() -> String {
    let columns = format!("{:>8} {:>9} {:>6}", "FLIP", "error", "dB");
    format!(
        "{:24}  {:<25}  without\n{:<18} {:>5}  {columns}  {columns}",
        "", "with what is carried over", "edit", "after"
    )
}

/// The lines of the table for an edit.
pub(super) fn lines(name: &str, rows: &[Row]) -> String {
    let cells = |figures: Option<Figures>| match figures {
        Some(found) => format!("{:8.4} {:9.5} {:6.1}", found.flip, found.relative_error, found.psnr),
        None => format!("{:>8} {:>9} {:>6}", "-", "-", "-"),
    };
    let line = |row: &Row| {
        let [carried, anew] = [row.carried, row.anew].map(cells);
        format!("{name:<18} {:>5}  {carried}  {anew}", row.picture)
    };
    rows.iter().map(line).collect::<Vec<String>>().join("\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn figures(flip: f32) -> Option<Figures> {
        Some(Figures {
            seconds: None,
            flip,
            relative_error: 0.5,
            psnr: 20.0,
        })
    }

    fn report() -> Report {
        let rows = |flip: f32| -> Vec<Row> {
            let row = |picture| Row {
                picture,
                carried: figures(flip),
                anew: figures(3.0 * flip).filter(|_| picture != "end"),
            };
            PICTURES.map(row).into()
        };
        let edit = |edit, flip| EditRows { edit, rows: rows(flip) };
        let mut report = Report {
            edits: vec![edit("camera step", 0.1), edit("delete a thing", 0.3)],
            ..Report::default()
        };
        report.take_means();
        report
    }

    #[test]
    fn means_are_over_the_edits() {
        let report = report();
        assert_eq!(report.means.len(), PICTURES.len());
        for row in &report.means {
            let flip = |figures: Option<Figures>| figures.map_or(0.0, |figures| figures.flip);
            assert!((flip(row.carried) - 0.2).abs() < 1e-6, "{row:?}");
            let expected = if row.picture == "end" { 0.0 } else { 0.6 };
            assert!((flip(row.anew) - expected).abs() < 1e-6, "{row:?}");
        }
        let mut empty = Report::default();
        empty.take_means();
        assert!(
            empty
                .means
                .iter()
                .all(|row| row.carried.is_none() && row.anew.is_none())
        );
    }

    #[test]
    fn columns_stand_below_each_other() {
        let text = format!("{}\n{}", header(), lines("camera step", &report().edits[0].rows));
        let ends: Vec<usize> = text.lines().skip(1).map(str::len).collect();
        assert_eq!(ends.len(), 1 + PICTURES.len());
        assert!(ends.iter().all(|end| *end == ends[0]), "{text}");
        assert!(
            text.contains("camera step         0.3s    0.1000   0.50000   20.0    0.3000"),
            "{text}"
        );
    }

    #[test]
    fn the_object_for_programs_has_the_same() {
        let found = serde_json::to_value(report()).expect("it can be written");
        assert_eq!(found["edits"][1]["edit"], "delete a thing");
        assert_eq!(found["edits"][1]["rows"][2]["picture"], "0.3s");
        assert_eq!(found["edits"][1]["rows"][2]["carried"]["psnr"], 20.0);
        assert!(found["means"][5]["anew"].is_null());
    }
}
