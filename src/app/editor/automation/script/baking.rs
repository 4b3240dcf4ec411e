//! The verbs about the bake of lightmaps.

use bevy::prelude::World;

use super::assign::within;
use super::error::ScriptError;
use super::names::{count, sample_count};

use super::rendering::{noise, positive, switch};
pub use super::verb::BakeWait;
use super::verb::{Step, verbs};
use crate::app::editor::command::baking::{BakeChoices, BakeCommand, BakePlan};
use crate::app::editor::command::compare_view::CompareView;
use crate::app::editor::picture::baking::Baking;
use crate::app::editor::picture::compare::Comparison;
use crate::bake::unwrap::ATLAS_SIZES;
use crate::document::value::parse_float;

verbs! {
    VERBS(world):
    "bake-with" "SETTING=VALUE... (texels-per-unit, page-size, samples, time, noise, light, probes, denoise)"
        words if !words.is_empty() => choices(world, words)?;
    "bake-to" "FOLDER" [folder] => Step::Bake(folder.into());
    "begin-bake" "FOLDER" [folder] => BakeCommand::Begin(folder.into());
    "wait-for-bake" "SAMPLES|done" [event] => Step::AwaitBake(wait(event)?);
    "show-lightmap" "NUMBER (from 0)" [number] => page(number)?;
}

/// Parses the event to wait for: a number of samples, or `done`.
fn wait(text: &str) -> Result<BakeWait, ScriptError> {
    match text {
        "done" => Ok(BakeWait::End),
        number => Ok(BakeWait::Samples(count(number)?)),
    }
}

/// Whether the awaited event has come. An error if the bake has failed.
pub fn has_come(world: &World, wait: BakeWait) -> Result<bool, ScriptError> {
    let Some(baking) = world.get_resource::<Baking>() else {
        return Ok(true);
    };
    if let Some(reason) = &baking.failure {
        return Err(reason.clone().into());
    }
    Ok(match wait {
        _ if !baking.is_busy() => true,
        BakeWait::Samples(wanted) => baking.thread().is_some_and(|thread| thread.news().samples >= wanted),
        BakeWait::End => false,
    })
}

/// Whether the view of the lit level, if it is shown, is up to date: from the present camera, and with the finished
/// lightmaps once the bake has ended.
pub fn is_lit_level_seen(world: &World) -> bool {
    let resources = (world.get_resource::<Baking>(), world.get_resource::<Comparison>());
    let (Some(baking), Some(comparison)) = resources else {
        return true;
    };
    if !matches!(comparison.view, CompareView::Baked(_)) {
        return true;
    }
    let Some(thread) = baking.thread() else {
        return !baking.is_busy();
    };
    let news = thread.news();
    let Some(look) = thread.wanted().look.filter(|_| news.blind.is_none()) else {
        return true;
    };
    let lit = comparison.baked.as_ref().filter(|lit| lit.look == look);
    lit.is_some_and(|lit| lit.is_finished || news.ended.is_none())
}

/// The command that sets the settings of bakes: unnamed ones stay.
fn choices(world: &World, words: &[&str]) -> Result<BakeCommand, ScriptError> {
    let mut choices = world
        .get_resource::<BakePlan>()
        .map_or_else(BakeChoices::default, |plan| plan.choices);
    for word in words {
        match word.split_once('=') {
            Some(("texels-per-unit", text)) => choices.texels_per_unit = positive(text)?,
            Some(("page-size", text)) => {
                let size = count(text)?;
                if !ATLAS_SIZES.contains(&size) {
                    let (least, most) = (ATLAS_SIZES.start(), ATLAS_SIZES.end());
                    return Err(format!("expected a size from {least} to {most}, found {size}").into());
                }
                choices.atlas_size = size;
            }
            Some(("samples", "none")) => choices.samples = None,
            Some(("samples", text)) => choices.samples = Some(sample_count(text)?),
            Some(("time", text)) => choices.time = positive(text)?,
            Some(("noise", text)) => choices.noise = noise(text)?,
            Some(("light", "all")) => choices.indirect_only = false,
            Some(("light", "indirect")) => choices.indirect_only = true,
            Some(("probes", text)) => choices.probes = switch(text)?,
            Some(("denoise", text)) => choices.denoise = switch(text)?,
            _ => return Err(format!("`{word}` is no setting of a bake").into()),
        }
    }
    Ok(BakeCommand::Choose(choices))
}

/// The command that shows another lightmap, counted from 0.
fn page(text: &str) -> Result<BakeCommand, ScriptError> {
    let page = within(parse_float(text)?, &(0.0..=1e6))?;
    Ok(BakeCommand::ShowPage(page as usize))
}
