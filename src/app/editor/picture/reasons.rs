//! Why a place of the picture is as it is: its light by lamps and ways, found on threads of its own whenever the place,
//! the scene or the view has changed.

use std::sync::Arc;

use bevy::prelude::*;

use super::paths::{Names, PathInspector};
use super::search::{Search, SearchState};
use crate::engine::reasons::{Group, Grouping, Things};
use crate::engine::{PackedScene, RenderControl, WakeUp};
use crate::render::breakdown::{Advice, Area, Batches, Breakdown, Portion, Progress, break_down, followed};
use crate::render::scene::RenderScene;
use crate::render::view::View;

/// The samples of all pixels together for the first answer, and for the final one.
const SAMPLES: [u64; 2] = [1 << 11, 1 << 16];

/// The scene, the view and the pixels that are asked about.
#[derive(Clone, Debug)]
pub(super) struct Question {
    scene: RenderScene,
    view: View,
    area: Area,
}

impl Question {
    fn is_same(&self, other: &Self) -> bool {
        self.area == other.area && self.scene.is_same(&other.scene) && self.view == other.view
    }
}

/// A group of light with its sentence.
#[derive(Clone, Debug, PartialEq)]
pub struct NamedPortion {
    /// The group and its light.
    pub portion: Portion<Group>,
    /// Its sentence in pieces, with the thing that a piece names.
    pub words: Vec<(String, Option<Entity>)>,
}

/// The light of the inspected pixels, in the words of the panel.
#[derive(Clone, Debug, PartialEq)]
pub struct Explanation {
    /// All light.
    pub value: Portion<()>,
    /// The light in each grouping, in the order of [`Grouping::ALL`], the brightest group first.
    pub groupings: Vec<Vec<NamedPortion>>,
    /// The reasons of the noise, the greatest first.
    pub advice: Vec<Advice>,
    /// The samples of all pixels together.
    pub samples: u64,
    /// Whether no more samples are being traced.
    pub is_final: bool,
}

/// The answer to a question.
#[derive(Debug)]
pub(super) struct Answer {
    question: Question,
    pub breakdown: Breakdown,
    is_final: bool,
}

/// The search for reasons, and its last result.
#[derive(Resource, Debug, Default)]
pub struct Reasons {
    search: Search<Question, Answer>,
    pub(super) answer: Option<Arc<Answer>>,
    /// The answer for the panel; None while nothing is known of the present scene and view.
    pub explanation: Option<Arc<Explanation>>,
    /// The state of the search for it, or for a better one.
    pub state: SearchState,
}

impl Reasons {
    /// The answer, if it is one about this scene, view and area.
    pub(super) fn answer_about(&self, scene: &RenderScene, view: &View, area: Area) -> Option<&Arc<Answer>> {
        let question = Question {
            scene: scene.clone(),
            view: followed(view),
            area,
        };
        self.answer.as_ref().filter(|answer| answer.question.is_same(&question))
    }

    fn ask(&mut self, question: Question, threads: usize, wake_up: &WakeUp) {
        if self.search.is_about(|known| known.is_same(&question)) {
            return;
        }
        let known = self.answer.as_ref().filter(|answer| answer.question.is_same(&question));
        let step = match known {
            Some(answer) if answer.is_final => return,
            Some(_) => 1,
            None => {
                self.explanation = None;
                0
            }
        };
        let find = move |question, progress: &_| find(question, step, progress);
        self.search.start(question, threads, wake_up, find);
    }
}

/// Traces the samples of the first answer, or of the final one.
fn find(question: Question, step: usize, progress: &Progress) -> Result<Answer, String> {
    let Question { scene, view, area } = &question;
    let [samples, last] = [SAMPLES[step], SAMPLES[1]].map(|all| Batches::of((all / area.pixels()) as u32));
    let breakdown = break_down(scene, view, *area, samples, progress);
    let breakdown = breakdown.ok_or("the place is not in the picture")?;
    Ok(Answer {
        breakdown,
        question,
        is_final: samples == last,
    })
}

/// Asks anew when the place, the scene or the view has changed, which stops what was asked before.
pub(crate) fn follow_reasons(
    mut reasons: ResMut<Reasons>,
    inspector: Res<PathInspector>,
    packed: Res<PackedScene>,
    control: Res<RenderControl>,
    wake_up: Res<WakeUp>,
    names: Names,
) {
    let (Some(wanted), Some(scene), Some(view)) = (inspector.wanted, &packed.scene, &packed.view) else {
        if reasons.search.is_running() || reasons.answer.is_some() {
            reasons.search.cancel();
            (reasons.answer, reasons.explanation) = (None, None);
        }
        if reasons.state != SearchState::Idle {
            reasons.state = SearchState::Idle;
        }
        return;
    };
    let found = reasons.search.collect().map(|(_, answer)| Arc::new(answer));
    let is_renamed = names.have_changed() && reasons.explanation.is_some();
    let told = found.or_else(|| reasons.answer.clone().filter(|_| is_renamed));
    if let Some(answer) = told {
        reasons.explanation = Some(Arc::new(explain(&answer, &Things::of(&packed), &names)));
        reasons.answer = Some(answer);
    }
    let question = Question {
        scene: scene.clone(),
        view: followed(view),
        area: wanted.area(view),
    };
    reasons.ask(question, control.threads.get(), &wake_up);
    reasons.state = reasons.search.state();
}

fn explain(answer: &Answer, things: &Things, names: &Names) -> Explanation {
    let breakdown = &answer.breakdown;
    let named = |portion: Portion<Group>| NamedPortion {
        words: portion.key.words(&|entity| names.thing(entity)),
        portion,
    };
    let grouping = |grouping| things.portions(breakdown, grouping).into_iter().map(named).collect();
    Explanation {
        value: breakdown.value(),
        groupings: Grouping::ALL.map(grouping).into(),
        advice: breakdown.advice(),
        samples: breakdown.batches.total() * breakdown.area.pixels(),
        is_final: answer.is_final,
    }
}
