//! Shows the lines of a file that messages quote.

use bevy_egui::egui::{self, Color32, FontId, RichText, Ui};

/// The size of the letters, in points.
const SIZE: f32 = 11.5;
/// The least number of columns before a line is broken: a narrower panel scrolls.
const FEWEST: usize = 16;

/// Shows a line of a file with the marks under it. A line that is too long for the panel is broken, with each mark
/// under its place.
pub fn excerpt(ui: &mut Ui, lines: &str) {
    let font = FontId::monospace(SIZE);
    let ten = ui
        .painter()
        .layout_no_wrap("0".repeat(10), font.clone(), Color32::PLACEHOLDER)
        .size()
        .x;
    let columns = (10.0 * ui.available_width() / ten.max(1.0)) as usize;
    let text = broken(lines, columns.max(FEWEST));
    egui::ScrollArea::horizontal().show(ui, |ui| {
        ui.add(egui::Label::new(RichText::new(text).font(font)).extend());
    });
}

/// Breaks the line and the line of marks below it at the same columns. The first part has the line's number and a bar
/// before it, the others a bar.
fn broken(lines: &str, columns: usize) -> String {
    let Some((line, marks)) = lines.split_once('\n') else {
        return lines.to_owned();
    };
    let Some((number, text)) = line.split_once(" | ") else {
        return lines.to_owned();
    };
    let margin = number.chars().count() + 3;
    let room = columns.saturating_sub(margin).max(1);
    let marked: Vec<bool> = marks.chars().skip(margin).map(|mark| mark == '^').collect();
    let letters: Vec<char> = text.trim_end().chars().collect();
    let length = letters.len().max(marked.len());
    let mut all = Vec::new();
    for start in (0..length.max(1)).step_by(room) {
        let end = start + room;
        let head = match start {
            0 => format!("{number} | "),
            _ => format!("{:>margin$}", "| "),
        };
        let row: String = letters.iter().skip(start).take(room).collect();
        all.push((head + &row).trim_end().to_owned());
        let marks = marked.iter().take(end).skip(start);
        let below: String = marks.map(|is_marked| if *is_marked { '^' } else { ' ' }).collect();
        if below.contains('^') {
            all.push(format!("{}{}", " ".repeat(margin), below.trim_end()));
        }
    }
    all.join("\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_short_line_stays_as_it_is() {
        let lines = "12 | <bsdf type=\"glas\">\n                ^^^^";
        assert_eq!(broken(lines, 80), lines);
        assert_eq!(broken("no marks", 3), "no marks");
    }

    #[test]
    fn a_long_line_goes_on_below_with_its_marks() {
        let lines = "7 | abcdefghijklmnop\n           ^^^";
        let expected = "7 | abcdefgh\n           ^\n  | ijklmnop\n    ^^";
        assert_eq!(broken(lines, 12), expected);
    }

    #[test]
    fn marks_behind_the_end_of_the_line_are_kept() {
        let lines = "7 | abcd\n        ^";
        assert_eq!(broken(lines, 8), "7 | abcd\n  |\n    ^");
    }
}
