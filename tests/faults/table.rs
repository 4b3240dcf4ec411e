//! The table itself: what a row is, how its texts are held against what the program does, and the page that shows it.

use std::process::Output;

/// One fault and its effects. The texts are Markdown for the page.
pub struct Row {
    /// The function that tests it.
    pub test: &'static str,
    /// What happens to the program.
    pub fault: &'static str,
    /// What the user sees. Every text in backticks is a part of the program's output, `…` in it stands for anything,
    /// and "exit code N" is the exit code: [`Row::holds`] checks both.
    pub seen: &'static str,
    /// What is on the disk afterwards, checked by the test itself.
    pub left: &'static str,
}

/// Rows about one part of the program.
pub struct Section {
    pub title: &'static str,
    pub rows: &'static [Row],
}

impl Section {
    pub fn row(&self, test: &str) -> &Row {
        let row = self.rows.iter().find(|row| row.test == test);
        row.expect("the macro names rows after tests")
    }
}

impl Row {
    /// Fails unless the program said what the row promises, and ended as it promises.
    #[track_caller]
    pub fn holds(&self, output: &Output) {
        // Reports are broken into lines.
        let said = String::from_utf8_lossy(&output.stderr).replace("\n  │ ", " ");
        self.is_said_in(&said);
        let promised = self.seen.split("xit code ").nth(1);
        let digits = |text: &str| text.chars().take_while(char::is_ascii_digit).collect::<String>();
        let promised = promised.map(|rest| digits(rest).parse::<i32>().expect("a number after `exit code`"));
        assert_eq!(output.status.code(), promised, "{}: {said}", self.test);
    }

    /// Fails unless every text in backticks occurs.
    #[track_caller]
    pub fn is_said_in(&self, said: &str) {
        let quoted = self.seen.split('`').skip(1).step_by(2);
        for text in quoted {
            assert!(occurs(text, said), "{}: expected `{text}` in: {said}", self.test);
        }
    }
}

/// Whether the parts of `pattern` around each `…` follow each other in a line of `text`.
fn occurs(pattern: &str, text: &str) -> bool {
    text.lines().any(|line| {
        let mut rest = Some(line);
        for part in pattern.split('…') {
            rest = rest.and_then(|rest| rest.split_once(part)).map(|(_, rest)| rest);
        }
        rest.is_some()
    })
}

/// Declares the rows of a section and the tests that hold them, one function for each row.
macro_rules! section {
    ($title:literal $($test:ident: $fault:literal, $seen:literal, $left:literal;)*) => {
        pub const SECTION: crate::table::Section = crate::table::Section {
            title: $title,
            rows: &[$(crate::table::Row { test: stringify!($test), fault: $fault, seen: $seen, left: $left }),*],
        };

        mod rows {
            $(#[test]
            fn $test() {
                super::$test(super::SECTION.row(stringify!($test)));
            })*
        }
    };
}
pub(crate) use section;

const HEAD: &str = "\
# Faults

What happens to the user's work when something around the program fails. Each row is a test of `tests/faults`; this page is written by them:
`SUNROOM_WRITE_FAULTS=1 cargo test --release --test faults page`. Texts in `this type` are parts of the program's messages, `…` stands for
names and numbers.
";

/// The page with the tables of these sections.
pub fn page(sections: &[&Section], not_injected: &[(&str, &str)]) -> String {
    let mut page = HEAD.to_owned();
    for section in sections {
        page += &format!(
            "\n## {}\n\n| fault | what the user sees | what is left on the disk |\n|---|---|---|\n",
            section.title
        );
        for row in section.rows {
            let cells = [row.fault, row.seen, row.left].map(|text| text.replace('|', "\\|"));
            page += &format!("| {} |\n", cells.join(" | "));
        }
    }
    page += "\n## Not injected\n\n| fault | why no test has it |\n|---|---|\n";
    for (fault, reason) in not_injected {
        page += &format!("| {fault} | {reason} |\n");
    }
    page
}

#[test]
fn patterns_are_parts_of_one_line_in_their_order() {
    let text = "error: cannot write /a/b.png: it is a folder\nnext line";
    assert!(occurs("error: cannot write …: it is a folder", text));
    assert!(occurs("cannot write", text) && occurs("…folder", text));
    for other in ["folder…error", "folder…next", "it is a file"] {
        assert!(!occurs(other, text), "{other}");
    }
}
