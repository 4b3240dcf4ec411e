//! Whether parts make up a whole picture.

use super::{Crop, PartHeader};
use crate::render::tile::{Tile, tiles};

/// The reason why parts are not a whole picture. `place` is the rectangle around the pixels that it is about.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum CoverError {
    /// Two parts have the same samples.
    #[error("{first} and {second} both have samples {}..{} of {}", .samples[0], .samples[1], place_in_words(place))]
    #[allow(missing_docs, reason = "the message says what the fields mean")]
    Overlap {
        first: String,
        second: String,
        samples: [u32; 2],
        place: Crop,
    },
    /// No part has these samples.
    #[error("no part has samples {}..{} of {}", .samples[0], .samples[1], place_in_words(place))]
    #[allow(missing_docs, reason = "the message says what the fields mean")]
    Gap { samples: [u32; 2], place: Crop },
}

fn place_in_words(place: &Crop) -> String {
    let Crop { x, y, width, height } = place;
    format!("the {width} x {height} pixels at {x},{y}")
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
        let Some(found) = fault_of_tile(parts, tile, end) else {
            continue;
        };
        match &mut error {
            None => error = Some(found),
            Some(known) => known.extend(&found),
        }
    }
    error.map_or(Ok(()), Err)
}

fn fault_of_tile(parts: &[(String, PartHeader)], tile: Tile, end: u32) -> Option<CoverError> {
    let Tile { x, y, width, height } = tile;
    let place = Crop { x, y, width, height };
    let mut here: Vec<&(String, PartHeader)> = parts.iter().filter(|(_, part)| part.crop.has(tile)).collect();
    here.sort_by_key(|(_, part)| part.samples);
    let (mut reached, mut last) = (0, None);
    for (name, part) in here {
        let [start, stop] = part.samples;
        match last {
            Some(last) if start < reached => {
                return Some(CoverError::Overlap {
                    first: String::clone(last),
                    second: name.clone(),
                    samples: [start, stop.min(reached)],
                    place,
                });
            }
            _ if start > reached => {
                let samples = [reached, start];
                return Some(CoverError::Gap { samples, place });
            }
            _ => (reached, last) = (stop, Some(name)),
        }
    }
    let samples = [reached, end];
    (reached < end).then_some(CoverError::Gap { samples, place })
}

impl CoverError {
    /// Extends the place if the other error is the same elsewhere.
    fn extend(&mut self, other: &Self) {
        let mut same = other.clone();
        let place = *self.place();
        *same.place_mut() = place;
        if same == *self {
            let other = other.place();
            let [left, top] = [place.x.min(other.x), place.y.min(other.y)];
            *self.place_mut() = Crop {
                x: left,
                y: top,
                width: (place.x + place.width).max(other.x + other.width) - left,
                height: (place.y + place.height).max(other.y + other.height) - top,
            };
        }
    }

    fn place(&self) -> &Crop {
        match self {
            Self::Overlap { place, .. } | Self::Gap { place, .. } => place,
        }
    }

    fn place_mut(&mut self) -> &mut Crop {
        match self {
            Self::Overlap { place, .. } | Self::Gap { place, .. } => place,
        }
    }
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
