//! Holds what a change costs: the numbers of source files in the recipes of CONTRIBUTING.md, and no catch-all that
//! could forget a command.

use std::fs;

use super::{ROOT, code_of, is_word, named_sources};

const EDITOR: &str = "app/editor/";

/// The lines of a match that catch all commands that no other arm names.
fn catch_alls(code: &str) -> Vec<usize> {
    let lines: Vec<&str> = code.lines().collect();
    let depth = |line: &str| line.len() - line.trim_start().len();
    let names_command = |line: &str| {
        let pattern = line.split("=>").next().unwrap_or_default();
        ["Command::", "Edit::"].iter().any(|name| pattern.contains(name))
    };
    let is_catch_all = |at: usize| {
        let own = depth(lines[at]);
        let arms = lines[..at]
            .iter()
            .rev()
            .take_while(|line| line.is_empty() || depth(line) >= own);
        lines[at].trim_start().starts_with("_ =>")
            && arms.into_iter().any(|line| depth(line) == own && names_command(line))
    };
    (0..lines.len())
        .filter(|at| is_catch_all(*at))
        .map(|at| at + 1)
        .collect()
}

#[test]
fn no_match_over_commands_has_a_catch_all() {
    let all = named_sources().into_iter().filter(|(file, _)| file.starts_with(EDITOR));
    let found: Vec<String> = all
        .flat_map(|(file, text)| {
            catch_alls(&code_of(&text))
                .into_iter()
                .map(move |line| format!("{file}:{line}"))
        })
        .collect();
    assert!(found.is_empty(), "\n{}", found.join("\n"));
    let bad = "match command {\n    Command::File(FileCommand::Quit) => quit(),\n    _ => {}\n}";
    let good = "match key {\n    Key::C => commands.push(FileCommand::Save.into()),\n    _ => {}\n}";
    assert_eq!((catch_alls(bad), catch_alls(good)), (vec![3], vec![]));
}

/// A command is declared in one file, done in another and called by a verb in a third.
#[test]
fn a_command_costs_three_files() {
    let names_sample = |(file, text): &(String, String)| file.starts_with(EDITOR) && code_of(text).contains("::GoTo");
    let files: Vec<String> = named_sources()
        .into_iter()
        .filter(names_sample)
        .map(|(file, _)| file)
        .collect();
    // Who gives the command is no part of it.
    let givers = ["panels/", "automation/monkey/", "commands/tests/"];
    let inside = files.iter().filter_map(|file| file.strip_prefix(EDITOR));
    let own: Vec<&str> = inside
        .filter(|file| !givers.iter().any(|giver| file.starts_with(giver)))
        .collect();
    assert_eq!(
        own,
        ["automation/script/view.rs", "command/history.rs", "commands/history.rs"]
    );
}

/// Sample and number of the headings `### A SORT (`SAMPLE`): NUMBER source files`.
fn recipes(page: &str) -> Vec<(&str, usize)> {
    let headings = page.lines().filter_map(|line| line.strip_prefix("### "));
    headings
        .filter_map(|heading| {
            let (_, rest) = heading.split_once("(`")?;
            let (sample, rest) = rest.split_once("`): ")?;
            let number = rest.strip_suffix(" source files")?;
            Some((sample, number.parse().ok()?))
        })
        .collect()
}

/// A sample of each kind is named by as many source files as its recipe says.
#[test]
fn recipes_say_how_many_files_they_take() {
    let page = fs::read_to_string(format!("{ROOT}/CONTRIBUTING.md")).expect("the page is text");
    let sources = named_sources().into_iter();
    let sources: Vec<_> = sources
        .filter(|(file, _)| !file.ends_with("tests.rs") && !file.contains("/tests/"))
        .map(|(file, text)| (file, code_of(&text)))
        .collect();
    let recipes = recipes(&page);
    for (sample, number) in &recipes {
        let names_sample = |code: &str| code.split(|c| !is_word(c)).any(|word| word == *sample);
        let files: Vec<&String> = sources
            .iter()
            .filter(|(_, code)| names_sample(code))
            .map(|(file, _)| file)
            .collect();
        assert_eq!(files.len(), *number, "{sample}: {files:#?}");
    }
    assert!(recipes.len() >= 5, "{recipes:?}");
}
