//! The light you want: strokes over the picture, the lamps that may change for them, and what was found.

use std::path::PathBuf;
use std::sync::Arc;

use bevy::math::Affine3A;
use bevy::prelude::{Entity, Resource, Vec2};

use super::light_mix::LightMix;
use super::traits::Traits;
use super::{Command, DisplayCommand};
use crate::color::Rgb;
use crate::engine::RenderFilm;
use crate::engine::lamp_freedom::LampFreedom;
use crate::inverse_lighting::{Stroke, Wish};
use crate::render::camera::Camera;
use crate::render::view::View;
use crate::scene::SunSky;

/// The most strokes of a painting.
pub const MOST_STROKES: usize = 64;

/// The most corners of the path of a stroke.
pub const MOST_CORNERS: usize = 4096;

/// The largest strength that lamps may get unless the user says so.
pub const USUAL_MOST: f32 = 10.0;

/// What is painted, and the answer. Places are those of the film: (0, 0) top left, (1, 1) bottom right.
#[derive(Resource, Clone, Debug, Default)]
pub struct LightPainting {
    /// The brush for the next stroke.
    pub brush: Brush,
    /// The strokes; later ones cover earlier ones.
    pub strokes: Arc<[Stroke]>,
    /// The wanted picture below all strokes.
    pub picture: Option<Arc<TargetPicture>>,
    /// What may be changed of lamps, where it is not what [`LampChoice::default`] says.
    lamps: Vec<(Entity, LampChoice)>,
    /// The mix that strokes refer to, and that returns when they are cleared.
    pub(crate) base: LightMix,
    /// The camera that the strokes belong to; None until the picture has light.
    pub(crate) camera: Option<Camera>,
    /// Counts what was changed of the painting since the start.
    pub(crate) revision: u64,
    /// The state of the picture and the painting that the answer is for.
    pub(crate) answered: Option<Answered>,
    /// What was found.
    pub answer: Option<Arc<Answer>>,
    /// Places, aims and times of lamps that were found, until they are accepted or discarded.
    pub proposal: Option<Arc<Proposal>>,
}

/// Places, aims and times of lamps, and the strengths that belong to them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Proposal {
    /// The lamps that change.
    pub placements: Vec<(Entity, Placement)>,
    /// The mix with the strengths.
    pub mix: LightMix,
    /// Sentences about what would change, what is not met, and what limits it.
    pub notes: Vec<String>,
    /// The state of the painting that it is for.
    pub revision: u64,
}

/// Where a lamp would be.
#[derive(Clone, Debug, PartialEq)]
pub enum Placement {
    /// The transform to the world, of shapes from their middle.
    Pose(Affine3A),
    /// Sun and sky at another time.
    Sun(Box<SunSky>),
}

/// What an answer is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Answered {
    /// The job as in the film.
    pub job: u64,
    pub samples: u32,
    pub revision: u64,
}

/// What was found.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Answer {
    /// Sentences about what is not met, and about the lamps that limit it.
    pub notes: Vec<String>,
    /// The time that it took, in milliseconds.
    pub milliseconds: f32,
}

/// The brush.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Brush {
    /// The light that its strokes want.
    pub wish: Wish,
    /// The radius in heights of the film.
    pub radius: f32,
    /// The share of the radius that is covered fully, from 0 to 1.
    pub hardness: f32,
}

impl Default for Brush {
    fn default() -> Self {
        Self {
            wish: Wish::Brighter(2.0),
            radius: 0.08,
            hardness: 0.5,
        }
    }
}

impl Brush {
    /// A stroke along a path.
    pub fn stroke(self, path: Vec<Vec2>) -> Stroke {
        Stroke {
            wish: self.wish,
            path,
            radius: self.radius,
            hardness: self.hardness,
        }
    }
}

/// What may be changed of a lamp.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LampChoice {
    /// Whether its strength may change.
    pub chosen: bool,
    /// Whether its colour may change as well.
    pub colored: bool,
    /// The least strength, at least 0.
    pub least: f32,
    /// The largest strength.
    pub most: f32,
    /// What else may change of it, in the slower search.
    pub freedom: LampFreedom,
}

impl Default for LampChoice {
    fn default() -> Self {
        Self {
            chosen: true,
            colored: false,
            least: 0.0,
            most: USUAL_MOST,
            freedom: LampFreedom::default(),
        }
    }
}

/// A wanted picture of the same view.
#[derive(Clone, Debug, PartialEq)]
pub struct TargetPicture {
    /// Its file.
    pub path: PathBuf,
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// The radiance, row by row.
    pub pixels: Vec<Rgb>,
}

impl LightPainting {
    /// Whether nothing is wanted.
    pub fn is_empty(&self) -> bool {
        self.strokes.is_empty() && self.picture.is_none()
    }

    /// What may be changed of a lamp.
    pub fn lamp(&self, lamp: Entity) -> LampChoice {
        let found = self.lamps.iter().find(|(entity, _)| *entity == lamp);
        found.map_or_else(LampChoice::default, |(_, choice)| *choice)
    }

    /// What may be changed of lamps, where it is not the usual.
    pub(crate) fn lamps(&self) -> &[(Entity, LampChoice)] {
        &self.lamps
    }

    /// Whether the picture is of another view than what is wanted.
    pub(crate) fn is_elsewhere(&self, film: &RenderFilm) -> bool {
        let camera = film.view.as_ref().map(View::of_film);
        !self.is_empty() && self.camera.is_some() && self.camera != camera
    }

    pub(crate) fn set_lamp(&mut self, lamp: Entity, choice: LampChoice) {
        self.lamps.retain(|(entity, _)| *entity != lamp);
        if choice != LampChoice::default() {
            self.lamps.push((lamp, choice));
        }
        self.revision += 1;
    }

    /// Removes all that is wanted. Brush and lamps stay.
    pub(crate) fn clear(&mut self) {
        *self = Self {
            brush: self.brush,
            lamps: std::mem::take(&mut self.lamps),
            revision: self.revision + 1,
            ..Self::default()
        };
    }
}

/// A command about the light you want. The scene stays as it is: the answer is a mix of lights.
#[derive(Clone, Debug, PartialEq)]
pub enum LightPaintCommand {
    /// Sets the brush for the next stroke.
    SetBrush(Brush),
    /// Sets all strokes. The first ones keep the layers of light from then on; without any, the mix of before returns.
    SetStrokes(Vec<Stroke>),
    /// Wants the picture of a file, or none.
    SetTarget(Option<PathBuf>),
    /// Sets what may be changed of a lamp.
    SetLamp(Entity, LampChoice),
    /// Finds the strengths with all samples of the picture. They are found again by themselves when strokes change and
    /// when the picture has twice as many samples.
    Solve,
    /// Searches for places, aims and times of the lamps that may change them, in the background. The scene stays as it
    /// is until what was found is accepted.
    Place,
    /// Ends the search without an answer, and discards what was found.
    Discard,
}

impl From<LightPaintCommand> for Command {
    fn from(command: LightPaintCommand) -> Self {
        DisplayCommand::PaintLight(command).into()
    }
}

impl LightPaintCommand {
    pub(super) fn traits(&self) -> Traits {
        match self {
            Self::Solve | Self::Place => Traits::NONE.of_pixels(),
            Self::SetBrush(_) | Self::SetStrokes(_) | Self::SetTarget(_) | Self::SetLamp(..) | Self::Discard => {
                Traits::NONE
            }
        }
    }
}
