//! The lamps of a film whose strengths are unknown, with the light of each.

use std::sync::Arc;

use bevy::prelude::*;

use crate::app::editor::command::error::CommandError;
use crate::app::editor::command::light_mix::{Channel, FilmLights, LightMix};
use crate::app::editor::command::light_paint::{LampChoice, LightPainting, TargetPicture};
use crate::app::editor::picture::light_search::LuxLight;
use crate::color::Rgb;
use crate::engine::RenderFilm;
use crate::inverse_lighting::{LampLight, LampLimits, Seen, Stroke, Target, Wish};
use crate::render::film::Film;
use crate::render::light_layers::LightGroups;
use crate::render::view::View;

/// The proportions of a wanted picture may differ from the film's by this factor.
const ALIKE: f32 = 1.02;

/// A lamp whose strength is unknown, or which may change otherwise.
#[derive(Clone, Debug, PartialEq)]
pub struct Lamp {
    pub entity: Entity,
    pub layer: usize,
    pub choice: LampChoice,
    channel: Channel,
    pub limits: LampLimits,
}

/// The lamps in question and the factors of all others.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LampList {
    pub lamps: Vec<Lamp>,
    /// The factor of each layer that is known.
    rest: Vec<(usize, Rgb)>,
    /// What layers are multiplied by to have the light of the scene as it is.
    scales: Vec<Rgb>,
}

impl LampList {
    pub fn new(film: &RenderFilm, painting: &LightPainting, mix: &LightMix, lights: &FilmLights) -> Self {
        let any_solo = film
            .light_groups
            .iter()
            .any(|group| painting.base.group_channel(group).solo);
        let mut list = Self {
            scales: mix.scales(&film.light_groups, lights),
            ..Self::default()
        };
        for (layer, group) in film.light_groups.iter().enumerate() {
            let channel = painting.base.group_channel(group);
            let is_heard = !channel.mute && (channel.solo || !any_solo);
            let Some(&entity) = group.entities.first().filter(|_| is_heard) else {
                continue;
            };
            let choice = painting.lamp(entity);
            let largest = channel.color.max_element();
            if (choice.chosen || !choice.freedom.is_none()) && largest > 0.0 {
                list.lamps.push(Lamp {
                    entity,
                    layer,
                    choice,
                    channel,
                    limits: limits(&choice, channel.strength * largest, channel.color / largest),
                });
            } else {
                list.rest.push((layer, channel.gain()));
            }
        }
        list
    }

    /// The limits of all lamps.
    pub fn limits(&self) -> Vec<LampLimits> {
        self.lamps.iter().map(|lamp| lamp.limits).collect()
    }

    /// Whether the light of another list is the same, whatever may be changed of it.
    pub fn shines_as(&self, other: &Self) -> bool {
        let light = |list: &Self| -> Vec<_> {
            let lamps = list.lamps.iter();
            lamps.map(|lamp| (lamp.entity, lamp.layer, lamp.channel)).collect()
        };
        light(self) == light(other) && (&self.rest, &self.scales) == (&other.rest, &other.scales)
    }
}

/// The limits of a lamp with this strength and colour. The strength of one that is not chosen stays.
fn limits(choice: &LampChoice, strength: f32, color: Rgb) -> LampLimits {
    let [least, most] = match choice.chosen {
        true => [choice.least, choice.most],
        false => [strength; 2],
    };
    LampLimits {
        strength,
        color,
        colored: choice.colored && choice.chosen,
        least,
        most,
    }
}

/// The light of these lamps in a film, and their illuminance as far as it is measured.
pub struct FilmLamps<'a> {
    pub film: &'a Film,
    pub list: &'a LampList,
    pub lux: Option<&'a LuxLight>,
}

impl FilmLamps<'_> {
    /// What is seen with this light of each layer, and `other` light; `scale` says what a layer has to be multiplied
    /// by.
    fn seen(&self, layers: &[Rgb], other: Rgb, scale: impl Fn(usize) -> Rgb, light: &mut [Rgb]) -> Seen {
        let LampList { lamps, rest, .. } = self.list;
        for (light, lamp) in light.iter_mut().zip(lamps) {
            *light = layers[lamp.layer] * scale(lamp.layer);
        }
        let known = rest
            .iter()
            .map(|&(layer, factor)| layers[layer] * scale(layer) * factor);
        let rest = other + known.sum::<Rgb>();
        let own = light.iter().zip(lamps).map(|(&light, lamp)| light * lamp.limits.gain());
        Seen {
            rest,
            present: rest + own.sum::<Rgb>(),
        }
    }
}

impl LampLight for FilmLamps<'_> {
    fn size(&self) -> [u32; 2] {
        [self.film.width(), self.film.height()]
    }

    fn at(&self, x: u32, y: u32, light: &mut [Rgb]) -> Option<Seen> {
        let mut layers = [Rgb::ZERO; LightGroups::MOST];
        let other = self.film.light_of_groups(x, y, &mut layers)?;
        Some(self.seen(&layers, other, |layer| self.list.scales[layer], light))
    }

    fn irradiance_at(&self, x: u32, y: u32, light: &mut [Rgb]) -> Option<Seen> {
        let mut layers = [Rgb::ZERO; LightGroups::MOST];
        let measured = self.lux?.at(x, y)?;
        layers
            .iter_mut()
            .zip(measured)
            .for_each(|(layer, light)| *layer = light);
        Some(self.seen(&layers, Rgb::ZERO, |_| Rgb::ONE, light))
    }
}

/// All that is wanted of the film's picture. Strokes have the same numbers with and without a picture, which comes
/// first; `picture` is as [`resample`] gives it.
pub fn targets(painting: &LightPainting, film: &RenderFilm, picture: Option<Arc<[Option<Rgb>]>>) -> Vec<Target> {
    let corners = corners(film);
    let strokes = painting
        .strokes
        .iter()
        .map(|stroke| Target::Stroke(in_picture(stroke, corners)));
    let picture = Target::Picture(picture.unwrap_or_default());
    std::iter::once(picture).chain(strokes).collect()
}

/// Whether a stroke wants illuminance.
pub fn wants_lux(painting: &LightPainting) -> bool {
    let mut strokes = painting.strokes.iter();
    strokes.any(|stroke| matches!(stroke.wish, Wish::Illuminance(_)))
}

/// The corners of the film in the picture.
pub fn corners(film: &RenderFilm) -> [Vec2; 2] {
    film.view.as_ref().map_or(View::WHOLE_FILM, View::film_corners)
}

/// A stroke of the film in a picture with the film at these corners.
fn in_picture(stroke: &Stroke, corners: [Vec2; 2]) -> Stroke {
    let size = corners[1] - corners[0];
    Stroke {
        path: stroke.path.iter().map(|&place| corners[0] + place * size).collect(),
        radius: stroke.radius * size.y,
        ..stroke.clone()
    }
}

/// The mean of the wanted picture over each pixel of a picture with the film at these corners; None outside of it.
pub fn resample(
    picture: &TargetPicture,
    size: [u32; 2],
    corners: [Vec2; 2],
) -> Result<Arc<[Option<Rgb>]>, CommandError> {
    let from = Vec2::from(picture.size.map(|side| side as f32));
    let to = Vec2::from(size.map(|side| side as f32));
    let film = (corners[1] - corners[0]) * to;
    let proportions = (from.x / from.y) / (film.x / film.y);
    if !(1.0 / ALIKE..ALIKE).contains(&proportions) {
        let path = picture.path.display();
        return Err(format!("{path} has other proportions than the film.").into());
    }
    let place = |pixel: Vec2| (pixel / to - corners[0]) / (corners[1] - corners[0]) * from;
    let pixel = |index: u32| {
        let corner = Vec2::new((index % size[0]) as f32, (index / size[0]) as f32);
        let [least, most] = [place(corner), place(corner + 1.0)];
        let middle = 0.5 * (least + most);
        let is_inside = middle.cmpge(Vec2::ZERO).all() && middle.cmplt(from).all();
        is_inside.then(|| mean(picture, least.max(Vec2::ZERO), most.min(from)))
    };
    Ok((0..size[0] * size[1]).map(pixel).collect())
}

/// The mean of a picture over a rectangle in pixels.
fn mean(picture: &TargetPicture, least: Vec2, most: Vec2) -> Rgb {
    let end = [most.x, most.y].map(|end| end.ceil() as u32);
    let (mut sum, mut area) = (Rgb::ZERO, 0.0);
    for y in least.y as u32..end[1].min(picture.size[1]) {
        for x in least.x as u32..end[0].min(picture.size[0]) {
            let pixel = Vec2::new(x as f32, y as f32);
            let overlap = (most.min(pixel + 1.0) - least.max(pixel))
                .max(Vec2::ZERO)
                .element_product();
            sum += overlap * picture.pixels[y as usize * picture.size[0] as usize + x as usize];
            area += overlap;
        }
    }
    if area > 0.0 { sum / area } else { Rgb::ZERO }
}

/// The channel of a lamp with this gain.
pub fn channel_of(lamp: &Lamp, gain: Rgb) -> Channel {
    let strength = gain.max_element();
    match lamp.limits.colored {
        true if strength > 0.0 => Channel {
            strength,
            color: gain / strength,
            ..lamp.channel
        },
        _ => Channel {
            strength: strength / lamp.channel.color.max_element(),
            ..lamp.channel
        },
    }
}
