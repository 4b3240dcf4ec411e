//! What a checkpoint has of a job, beside the film: enough to go on as if it had not been interrupted.

use std::time::Duration;

use super::{Job, JudgedNoise};
use crate::engine::film::RenderFilm;
use crate::render::bytes::{Damaged, Reader, Writer};
use crate::render::film::Film;

impl Job {
    /// Writes the state. Passes under way are not saved; they are rendered again.
    pub fn write(&self) -> Vec<u8> {
        let mut to = Writer::default();
        self.done.iter().for_each(|&samples| to.u32(samples));
        to.u32(self.cuts.len() as u32);
        self.cuts.iter().for_each(|&cut| to.u32(cut));
        [self.rays, self.samples, self.invalid]
            .into_iter()
            .for_each(|count| to.u64(count));
        to.f64(self.seconds());
        let ((noise, is_adaptive), end) = self.round;
        write_optional(noise, &mut to);
        to.u32(u32::from(is_adaptive));
        to.u32(end);
        to.u32(u32::from(self.judged.is_some()));
        if let Some(JudgedNoise { samples, noise }) = self.judged {
            to.u32(samples);
            write_optional(noise, &mut to);
        }
        self.adaptation.write(&mut to);
        to.0
    }

    /// Takes up what [`Self::write`] has written of the same picture, and the film of that time. The job has not run yet.
    pub fn resume(&mut self, state: &[u8], saved: Film, film: &mut RenderFilm) -> Result<(), Damaged> {
        let mut from = Reader(state);
        for done in &mut self.done {
            *done = from.u32()?;
        }
        for _ in 0..from.u32()? {
            self.cuts.insert(from.u32()?);
        }
        (self.rays, self.samples, self.invalid) = (from.u64()?, from.u64()?, from.u64()?);
        self.ran = Duration::try_from_secs_f64(from.f64()?).map_err(|_| Damaged)?;
        let (noise, is_adaptive) = (read_optional(&mut from)?, from.flag()?);
        self.round = ((noise, is_adaptive), from.u32()?);
        self.judged = match from.flag()? {
            true => Some(JudgedNoise {
                samples: from.u32()?,
                noise: read_optional(&mut from)?,
            }),
            false => None,
        };
        self.adaptation.read(&mut from)?;
        self.is_resumed = true;
        film.begin_with(self.begun, &self.light_groups, self.is_coarse, saved);
        film.samples = self.least_samples();
        for (index, &tile) in self.tiles.iter().enumerate().filter(|(index, _)| self.done[*index] > 0) {
            self.noise_of_tiles.update(index, &film.film, tile);
            film.mark(tile);
        }
        self.noise = self.noise_of_tiles.relative(self.active.iter().copied());
        Ok(())
    }
}

fn write_optional(number: Option<f32>, to: &mut Writer) {
    to.u32(u32::from(number.is_some()));
    to.f32(number.unwrap_or(0.0));
}

fn read_optional(from: &mut Reader) -> Result<Option<f32>, Damaged> {
    let (is_there, number) = (from.flag()?, from.f32()?);
    Ok(is_there.then_some(number))
}
