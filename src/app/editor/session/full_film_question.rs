//! The question to the user before the full film is traced, if that takes much memory.

use bevy::math::UVec2;

use crate::app::editor::command::resolution::FullFilm;
use crate::memory::Bytes;

/// The question. It is shown until it is answered.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FullFilmQuestion {
    /// The request that the question is about.
    pub request: FullFilm,
    /// The pixels of the film.
    pub size: UVec2,
    /// The memory that the film takes.
    pub bytes: u64,
    /// The memory that the program may take.
    pub budget: u64,
}

impl FullFilmQuestion {
    /// The facts of the question, in one sentence.
    pub fn text(&self) -> String {
        format!(
            "The full film has {} × {} pixels and takes {} of memory; the program may take {} in all.",
            self.size.x,
            self.size.y,
            Bytes(self.bytes),
            Bytes(self.budget)
        )
    }

    /// The request to render, as confirmed by the user.
    pub fn confirmed(self) -> FullFilm {
        FullFilm {
            is_confirmed: true,
            ..self.request
        }
    }
}
