//! Changes the file of the open scene while it is edited, as another program would: a text editor, with small changes
//! and broken ones.

use bevy::prelude::*;

use super::act::{Act, OwnFile};
use super::folder::Writing;
use super::random::Random;
use crate::files::{LARGEST_NOTE, read_text};
use crate::scene::SceneStatus;

/// Acts that leave the file readable in the end. The list is empty if the scene has no file.
pub fn acts(world: &World, random: &mut Random, own: OwnFile) -> Vec<Act> {
    let Some(path) = world.resource::<SceneStatus>().path.clone() else {
        return Vec::new();
    };
    let Ok(text) = read_text(&path, LARGEST_NOTE) else {
        return Vec::new();
    };
    let how = Writing::ALL[random.below(3)];
    let write = |content: &str, awaited: bool| Act::Write {
        path: path.clone(),
        content: content.into(),
        how,
        awaited,
    };
    let undo = || Act::Say(vec!["undo".to_owned()]);
    match (own, random.below(5)) {
        // The same text once more: there is nothing to wait for.
        (_, 0) => vec![write(&text, false)],
        (_, 1) => {
            let broken = cut(&text, random);
            vec![write(&broken, true), undo(), undo(), write(&text, true)]
        }
        (_, 2) => vec![Act::Remove(path.clone()), undo(), Act::Rest(3), write(&text, false)],
        (OwnFile::Untouched | OwnFile::Harmless, _) => vec![write(&with_other_ending(&text, random), true)],
        (OwnFile::Changes, 3) => vec![write(&with_or_without_ball(&text, random), true)],
        (OwnFile::Changes, _) => match with_other_number(&text, random) {
            // Some numbers are not allowed in some places, so the file is repaired in the end.
            Some(changed) => vec![write(&changed, true), undo(), write(&text, true)],
            None => Vec::new(),
        },
    }
}

/// The first part of the text, as of a program that has not finished writing.
fn cut(text: &str, random: &mut Random) -> String {
    let mut end = text.len() / 10 + random.below(text.len() * 8 / 10 + 1);
    while !text.is_char_boundary(end) {
        end -= 1;
    }
    text[..end].to_owned()
}

const MARK: &str = "<!-- line ";

/// The text with another comment after the scene, which shifts no position in the file.
fn with_other_ending(text: &str, random: &mut Random) -> String {
    let kept = text.find(MARK).map_or(text, |place| &text[..place]);
    format!("{}\n{MARK}{} -->\n", kept.trim_end(), random.below(1000))
}

/// The text with a new ball at the end of the scene, or without the last such ball.
fn with_or_without_ball(text: &str, random: &mut Random) -> String {
    const BALL: &str = "\n<shape type=\"sphere\" id=\"typed-";
    const END: &str = "</shape>";
    let Some(place) = text.rfind(BALL).filter(|_| random.below(2) == 0) else {
        let ball = format!(
            "{BALL}{}\"><float name=\"radius\" value=\"0.{}\"/>{END}",
            random.below(10_000),
            1 + random.below(9)
        );
        let end = text.rfind("</scene>").unwrap_or(text.len());
        return format!("{}{ball}{}", &text[..end], &text[end..]);
    };
    let end = text[place..]
        .find(END)
        .map_or(text.len(), |end| place + end + END.len());
    format!("{}{}", &text[..place], &text[end..])
}

/// The text with one number multiplied by 0.8 to 1.2; None without a number.
fn with_other_number(text: &str, random: &mut Random) -> Option<String> {
    const BEGIN: &str = "value=\"";
    let values = text.match_indices(BEGIN).filter_map(|(place, _)| {
        let begin = place + BEGIN.len();
        let end = begin + text[begin..].find('"')?;
        let number: f32 = text[begin..end].parse().ok()?;
        Some((begin, end, number))
    });
    let values: Vec<(usize, usize, f32)> = values.collect();
    let &(begin, end, number) = random.one_of(&values)?;
    let changed = number * (0.8 + 0.4 * random.fraction());
    Some(format!("{}{changed}{}", &text[..begin], &text[end..]))
}

#[cfg(test)]
mod tests {
    use super::*;

    const SCENE: &str =
        "<scene version=\"3.0.0\"><shape type=\"sphere\"><float name=\"radius\" value=\"2\"/></shape>\n</scene>\n";

    #[test]
    fn changes_are_small_and_can_be_read() {
        let mut random = Random::new(1);
        let mut text = SCENE.to_owned();
        for _ in 0..100 {
            text = with_or_without_ball(&text, &mut random);
            text = with_other_ending(&text, &mut random);
            assert!(
                crate::document::parse_str(&*text, "a.xml".as_ref(), &[])
                    .diagnostics
                    .list
                    .is_empty(),
                "{text}"
            );
            assert_eq!(text.matches(MARK).count(), 1);
        }
        let changed = with_other_number(SCENE, &mut random).expect("it has a number");
        assert!(changed != SCENE && changed.len() < SCENE.len() + 20);
        assert!(!cut(SCENE, &mut random).contains("</scene>"));
    }
}
