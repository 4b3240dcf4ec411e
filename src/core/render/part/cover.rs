//! Checks whether parts make up a whole picture.

use super::{Crop, PartHeader};
use crate::render::tile::{Tile, tiles};

/// A fault in the samples that parts have at one place.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[allow(missing_docs, reason = "the messages say what the fields mean")]
pub enum Fault {
    /// Two parts have samples in common.
    #[error("{first} and {second} both have samples {}..{}", .samples[0], .samples[1])]
    Overlap {
        first: String,
        second: String,
        samples: [u32; 2],
    },
    /// No part has these samples. `part` is the word for parts in the message.
    #[error("no {part} has samples {}..{}", .samples[0], .samples[1])]
    Gap { part: &'static str, samples: [u32; 2] },
}

/// The first fault of parts with these names and sample ranges, which must have each sample from 0 to `end` once.
/// Messages call them by the word `part`.
pub fn fault<'a>(
    part: &'static str,
    parts: impl Iterator<Item = (&'a String, [u32; 2])>,
    end: u32,
) -> Result<(), Fault> {
    let mut parts: Vec<_> = parts.collect();
    parts.sort_by_key(|(_, samples)| *samples);
    let (mut reached, mut last) = (0, None);
    for (name, [start, stop]) in parts {
        if let Some(last) = last.filter(|_| start < reached) {
            return Err(Fault::Overlap {
                first: String::clone(last),
                second: name.clone(),
                samples: [start, stop.min(reached)],
            });
        }
        if start > reached {
            let samples = [reached, start];
            return Err(Fault::Gap { part, samples });
        }
        (reached, last) = (stop, Some(name));
    }
    let samples = [reached, end];
    match reached < end {
        true => Err(Fault::Gap { part, samples }),
        false => Ok(()),
    }
}

/// The reason why parts are not a whole picture. `place` is the rectangle of the affected pixels.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{fault} of the {} x {} pixels at {},{}", .place.width, .place.height, .place.x, .place.y)]
#[allow(missing_docs, reason = "the message says what the fields mean")]
pub struct CoverError {
    pub fault: Fault,
    pub place: Crop,
}

/// Checks that every pixel of the picture has all samples from 0 on exactly once. Each part has the name of its file.
/// All parts are of one picture.
pub fn check_cover(parts: &[(String, PartHeader)]) -> Result<(), CoverError> {
    let Some((_, first)) = parts.first() else {
        return Ok(());
    };
    let end = parts.iter().map(|(_, part)| part.samples[1]).max().unwrap_or(0);
    let mut error: Option<CoverError> = None;
    for tile in tiles(first.width, first.height) {
        let here = parts.iter().filter(|(_, part)| part.crop.has(tile));
        let Err(fault) = fault("part", here.map(|(name, part)| (name, part.samples)), end) else {
            continue;
        };
        let Tile { x, y, width, height } = tile;
        match &mut error {
            None => {
                let place = Crop { x, y, width, height };
                error = Some(CoverError { fault, place });
            }
            Some(known) if known.fault == fault => {
                let place = known.place;
                let [left, top] = [place.x.min(x), place.y.min(y)];
                known.place = Crop {
                    x: left,
                    y: top,
                    width: (place.x + place.width).max(x + width) - left,
                    height: (place.y + place.height).max(y + height) - top,
                };
            }
            Some(_) => {}
        }
    }
    error.map_or(Ok(()), Err)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::part::{About, Origin};

    fn part(name: &str, x: u32, samples: [u32; 2]) -> (String, PartHeader) {
        let crop = Crop {
            x,
            y: 0,
            width: 32,
            height: 64,
        };
        let header = PartHeader {
            origin: Origin::default(),
            width: 64,
            height: 64,
            crop,
            samples,
            samples_of_whole: None,
            is_finished: true,
            layers: Vec::new(),
            splats: false,
            about: About::default(),
        };
        (name.to_owned(), header)
    }

    fn message(parts: &[(String, PartHeader)]) -> String {
        check_cover(parts).map_or_else(|error| error.to_string(), |()| "whole".to_owned())
    }

    #[test]
    fn overlaps_and_gaps_are_named() {
        let parts = [
            part("d", 32, [16, 32]),
            part("a", 0, [0, 16]),
            part("c", 32, [0, 16]),
            part("b", 0, [16, 32]),
        ];
        assert_eq!(message(&parts), "whole");
        assert_eq!(
            message(&parts[1..]),
            "no part has samples 16..32 of the 32 x 64 pixels at 32,0"
        );
        assert_eq!(
            message(&[&parts[..], &[part("e", 0, [16, 48])]].concat()),
            "b and e both have samples 16..32 of the 32 x 64 pixels at 0,0"
        );
        assert_eq!(
            message(&parts[..3]),
            "no part has samples 16..32 of the 32 x 64 pixels at 0,0"
        );
        assert_eq!(
            message(&parts[..1]),
            "no part has samples 0..32 of the 32 x 64 pixels at 0,0"
        );
    }
}
