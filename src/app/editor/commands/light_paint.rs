//! Commands about the light you want, and the lamps that are found for it.

use std::path::Path;
use std::sync::Arc;

use bevy::prelude::*;

use super::world::{control, set_resource, tell};
use crate::app::editor::command::error::CommandError;
use crate::app::editor::command::light_mix::{Channel, FilmLights, LightMix, bake_area, bake_emitter};
use crate::app::editor::command::light_paint::{
    Answer, Answered, LampChoice, LightPaintCommand, LightPainting, MOST_CORNERS, MOST_STROKES, TargetPicture,
};
use crate::color::Rgb;
use crate::engine::{LightGroup, RenderControl, RenderFilm};
use crate::files;
use crate::inverse_lighting::{
    Fit, LampLight, LampLimits, Limit, Painting, Stroke, Target, Unsolvable, Wish, solve as solve_observations,
};
use crate::render::camera::Camera;
use crate::render::film::Film;
use crate::render::image_io::load_picture;
use crate::render::view::View;
use crate::scene::{AreaLight, Emitter};

/// Strokes with a larger error than this are reported as not met.
const MET: f64 = 0.05;

/// The proportions of a wanted picture may differ from the film's by this factor.
const ALIKE: f32 = 1.02;

/// Applies the command.
pub fn apply(world: &mut World, command: LightPaintCommand) -> Result<(), CommandError> {
    world.init_resource::<LightPainting>();
    match command {
        LightPaintCommand::SetBrush(brush) => {
            if !brush.stroke(vec![Vec2::ZERO]).is_valid() {
                return Err("The brush has numbers out of range.".into());
            }
            world.resource_mut::<LightPainting>().brush = brush;
        }
        LightPaintCommand::SetStrokes(strokes) => set_strokes(world, strokes)?,
        LightPaintCommand::SetTarget(path) => {
            let picture = path.map(|path| read(&path)).transpose()?;
            if picture.is_some() {
                begin(world);
            }
            let mut painting = world.resource_mut::<LightPainting>();
            painting.picture = picture.map(Arc::new);
            painting.revision += 1;
            end_if_empty(world);
        }
        LightPaintCommand::SetLamp(lamp, choice) => set_lamp(world, lamp, choice)?,
        LightPaintCommand::Solve => solve(world)?,
    }
    Ok(())
}

fn set_strokes(world: &mut World, strokes: Vec<Stroke>) -> Result<(), CommandError> {
    if strokes.len() > MOST_STROKES {
        return Err(format!("A painting has at most {MOST_STROKES} strokes.").into());
    }
    if strokes.iter().any(|stroke| stroke.path.len() > MOST_CORNERS) {
        return Err(format!("The path of a stroke has at most {MOST_CORNERS} corners.").into());
    }
    if !strokes.iter().all(Stroke::is_valid) {
        return Err("A stroke has numbers out of range.".into());
    }
    // Strokes of another view end with the first stroke of this one.
    let is_elsewhere = is_elsewhere(world);
    let known = world.resource::<LightPainting>().strokes.clone();
    let old = match is_elsewhere {
        true => strokes
            .iter()
            .zip(known.iter())
            .take_while(|(new, old)| new == old)
            .count(),
        false => 0,
    };
    let strokes = strokes[old..].to_vec();
    if !strokes.is_empty() {
        begin(world);
    }
    let mut painting = world.resource_mut::<LightPainting>();
    painting.strokes = strokes.into();
    painting.revision += 1;
    end_if_empty(world);
    Ok(())
}

/// Prepares for what is wanted of this view: the light of each lamp is kept apart from now on, and the present mix is
/// what strokes refer to. What was wanted of another view is dropped.
fn begin(world: &mut World) {
    if !world.resource::<RenderControl>().light_layers {
        control(world, |control| control.light_layers = true);
    }
    let camera = camera(world);
    let is_elsewhere = is_elsewhere(world);
    if is_elsewhere {
        let base = world.resource::<LightPainting>().base.clone();
        world.resource_mut::<LightPainting>().clear();
        show(world, base);
    }
    let mix = world.get_resource_or_init::<LightMix>().clone();
    let mut painting = world.resource_mut::<LightPainting>();
    if painting.is_empty() {
        painting.base = mix;
        painting.camera = camera;
    }
    if is_elsewhere {
        tell(world, "The strokes of the other view are gone.");
    }
}

/// Shows the mix of before once nothing is wanted any more.
fn end_if_empty(world: &mut World) {
    let painting = world.resource::<LightPainting>();
    if !painting.is_empty() || painting.answer.is_none() {
        return;
    }
    let base = painting.base.clone();
    world.resource_mut::<LightPainting>().clear();
    show(world, base);
}

/// Takes channels that were changed at the mixing desk over into the mix that the painting refers to.
pub(super) fn follow_desk(world: &mut World, before: &LightMix, after: &LightMix) {
    let Some(mut painting) = world
        .get_resource_mut::<LightPainting>()
        .filter(|painting| !painting.is_empty())
    else {
        return;
    };
    let mut base = painting.base.clone();
    for lamp in before.lamps().chain(after.lamps()) {
        let channel = after.channel(lamp);
        if before.channel(lamp) != channel {
            base.set(lamp, channel);
        }
    }
    if base != painting.base {
        painting.base = base;
        painting.revision += 1;
    }
}

/// Shows a mix; factors that are baked stay.
fn show(world: &mut World, mix: LightMix) {
    let mix = world.resource::<LightMix>().with_channels(mix);
    set_resource(world, mix);
}

fn set_lamp(world: &mut World, lamp: Entity, choice: LampChoice) -> Result<(), CommandError> {
    let are_in_order = choice.most.is_finite() && 0.0 <= choice.least && choice.least <= choice.most;
    if !are_in_order {
        return Err("The limits of a lamp are not 0 <= least <= most.".into());
    }
    if choice.colored
        && let Err(reason) = takes_color(world, lamp)
    {
        let name = world.get::<Name>(lamp).map_or("The lamp", |name| name.as_str());
        return Err(format!("{name} {reason}.").into());
    }
    world.resource_mut::<LightPainting>().set_lamp(lamp, choice);
    Ok(())
}

/// Whether baking can give a lamp another colour. The error is the end of a sentence that begins with the lamp.
fn takes_color(world: &World, lamp: Entity) -> Result<(), &'static str> {
    let gain = Rgb::new(1.0, 0.5, 0.25);
    if let Some(light) = world.get::<AreaLight>(lamp) {
        bake_area(light, gain).map(|_| ())
    } else if let Some(emitter) = world.get::<Emitter>(lamp) {
        bake_emitter(emitter, gain).map(|_| ())
    } else {
        Err("is no lamp whose colour can change")
    }
}

fn read(path: &Path) -> Result<TargetPicture, CommandError> {
    let in_file = |error: &dyn std::fmt::Display| format!("{}: {error}", path.display());
    let bytes = files::read(path, files::LARGEST_DATA).map_err(|error| error.to_string())?;
    let loaded = load_picture(&bytes).map_err(|error| in_file(&error))?;
    let image = loaded.image.layer("").or_else(|| {
        let grey = loaded.image.channel("Y")?;
        Some(loaded.image.as_colors(&[grey]))
    });
    let image = image.ok_or_else(|| in_file(&"the picture has no colours"))?;
    if !image.pixels.iter().all(|pixel| pixel.is_finite()) {
        return Err(in_file(&"the picture has values that are not finite").into());
    }
    Ok(TargetPicture {
        path: path.to_path_buf(),
        size: [image.width, image.height],
        pixels: image.pixels,
    })
}

/// The camera of the film of the present picture.
fn camera(world: &World) -> Option<Camera> {
    let view = world.get_resource::<RenderFilm>()?.view.as_ref();
    view.map(View::of_film)
}

/// Whether the picture is of another view than what is wanted.
fn is_elsewhere(world: &World) -> bool {
    world
        .resource::<LightPainting>()
        .is_elsewhere(world.resource::<RenderFilm>())
}

/// Finds the lamps again when the painting has changed, and when the picture has twice as many samples.
pub fn follow(world: &mut World) {
    let Some(painting) = world.get_resource::<LightPainting>() else {
        return;
    };
    if painting.is_empty() || is_elsewhere(world) {
        return;
    }
    let film = world.resource::<RenderFilm>();
    let is_lit = film.samples > 0 && film.film.layers().groups > 0 && !film.light_groups.is_empty();
    let is_due = painting.answered.is_none_or(|answered| {
        answered.revision != painting.revision
            || answered.job != film.job
            || film.samples >= answered.samples.saturating_mul(2)
    });
    if is_lit
        && !film.is_coarse
        && is_due
        && let Err(error) = solve(world)
    {
        let answer = Answer {
            notes: vec![error.to_string()],
            ..Answer::default()
        };
        world.resource_mut::<LightPainting>().answer = Some(Arc::new(answer));
    }
}

/// Finds the lamps and shows their mix.
fn solve(world: &mut World) -> Result<(), CommandError> {
    let start = std::time::Instant::now();
    let film = world.resource::<RenderFilm>();
    if film.samples == 0 || film.film.layers().groups == 0 {
        return Err("The picture does not have the light of each lamp yet.".into());
    }
    if is_elsewhere(world) {
        return Err("The strokes belong to another view.".into());
    }
    let answered = Answered {
        job: film.job,
        samples: film.samples,
        revision: world.resource::<LightPainting>().revision,
    };
    let camera = camera(world);
    let mut painting = world.resource_mut::<LightPainting>();
    painting.camera = camera;
    painting.answered = Some(answered);
    let painting = world.resource::<LightPainting>();
    let film = world.resource::<RenderFilm>();
    let lamps = FilmLamps::new(
        film,
        painting,
        world.resource::<LightMix>(),
        world.resource::<FilmLights>(),
    );
    let fit = lamps.fit(painting, film)?;
    let mut mix = painting.base.clone();
    for (lamp, gain) in lamps.lamps.iter().zip(&fit.gains) {
        mix.set(lamp.entity, channel_of(lamp, *gain));
    }
    let names: Vec<String> = lamps
        .lamps
        .iter()
        .map(|lamp| name(world, &film.light_groups[lamp.layer]))
        .collect();
    let notes = notes(painting, &fit, &lamps.lamps, &names);
    show(world, mix);
    let milliseconds = 1e3 * start.elapsed().as_secs_f32();
    world.resource_mut::<LightPainting>().answer = Some(Arc::new(Answer { notes, milliseconds }));
    Ok(())
}

/// A lamp whose strength is unknown.
struct Lamp {
    entity: Entity,
    layer: usize,
    channel: Channel,
    limits: LampLimits,
}

/// The lamps in question in a film, and what the others shine.
struct FilmLamps<'a> {
    film: &'a Film,
    /// What layers are multiplied by to have the light of the scene as it is.
    scales: Vec<Rgb>,
    lamps: Vec<Lamp>,
    /// The factors of layers that are known.
    rest: Vec<(usize, Rgb)>,
}

impl<'a> FilmLamps<'a> {
    fn new(film: &'a RenderFilm, painting: &LightPainting, mix: &LightMix, lights: &FilmLights) -> Self {
        let scales = mix.scales(&film.light_groups, lights);
        let any_solo = film
            .light_groups
            .iter()
            .any(|group| painting.base.group_channel(group).solo);
        let (mut lamps, mut rest) = (Vec::new(), Vec::new());
        for (layer, group) in film.light_groups.iter().enumerate() {
            let channel = painting.base.group_channel(group);
            let is_heard = !channel.mute && (channel.solo || !any_solo);
            let Some(&entity) = group.entities.first().filter(|_| is_heard) else {
                continue;
            };
            let choice = painting.lamp(entity);
            match choice.chosen && channel.color.max_element() > 0.0 {
                true => lamps.push(Lamp {
                    entity,
                    layer,
                    channel,
                    limits: LampLimits {
                        present: channel.gain(),
                        colored: choice.colored,
                        least: choice.least,
                        most: choice.most,
                    },
                }),
                false => rest.push((layer, channel.gain() * scales[layer])),
            }
        }
        Self {
            film: &film.film,
            scales,
            lamps,
            rest,
        }
    }

    fn fit(&self, painting: &LightPainting, film: &RenderFilm) -> Result<Fit, CommandError> {
        let corners = film.view.as_ref().map_or(View::WHOLE_FILM, View::film_corners);
        let strokes: Vec<Stroke> = painting
            .strokes
            .iter()
            .map(|stroke| in_picture(stroke, corners))
            .collect();
        let size = [self.film.width(), self.film.height()];
        let picture = match &painting.picture {
            Some(picture) => Some(resample(picture, size, corners)?),
            None => None,
        };
        // Strokes have the same numbers with and without a picture, which comes first.
        let mut targets = vec![Target::Picture(picture.as_deref().unwrap_or_default())];
        targets.extend(strokes.iter().map(Target::Stroke));
        let limits: Vec<LampLimits> = self.lamps.iter().map(|lamp| lamp.limits).collect();
        let observations = Painting { targets: &targets }.observations(self, &limits);
        solve_observations(&observations, &limits).map_err(|error| match error {
            Unsolvable::NoLamps => "No lamp may change: choose some.".into(),
            other => format!("No light was found: {other}.").into(),
        })
    }
}

impl LampLight for FilmLamps<'_> {
    fn size(&self) -> [u32; 2] {
        [self.film.width(), self.film.height()]
    }

    fn at(&self, x: u32, y: u32, light: &mut [Rgb]) -> Option<(Rgb, Rgb)> {
        let mut layers = [Rgb::ZERO; crate::render::light_layers::LightGroups::MOST];
        let (other, albedo) = self.film.light_of_groups(x, y, &mut layers)?;
        for (light, lamp) in light.iter_mut().zip(&self.lamps) {
            *light = layers[lamp.layer] * self.scales[lamp.layer];
        }
        let rest = self.rest.iter().map(|&(layer, factor)| layers[layer] * factor);
        Some((other + rest.sum::<Rgb>(), albedo))
    }
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
fn resample(picture: &TargetPicture, size: [u32; 2], corners: [Vec2; 2]) -> Result<Vec<Option<Rgb>>, CommandError> {
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
fn channel_of(lamp: &Lamp, gain: Rgb) -> Channel {
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

fn name(world: &World, group: &LightGroup) -> String {
    let first = group.entities.first();
    let name = first.and_then(|&light| world.get::<Name>(light));
    let name = name.map_or("A lamp", |name| name.as_str());
    match group.entities.len() {
        0 | 1 => name.to_owned(),
        many => format!("{name} and {} more", many - 1),
    }
}

/// Sentences about what is not met, and about the lamps that limit it.
fn notes(painting: &LightPainting, fit: &Fit, lamps: &[Lamp], names: &[String]) -> Vec<String> {
    let mut notes = Vec::new();
    for (target, &error) in fit.errors.iter().enumerate().filter(|(_, error)| **error > MET) {
        let percent = (100.0 * error).round();
        notes.push(
            match target
                .checked_sub(1)
                .and_then(|place| Some((place, painting.strokes.get(place)?)))
            {
                None => format!("The picture is missed by {percent} %."),
                Some((place, stroke)) => format!(
                    "Stroke {} ({}) is missed by {percent} %.",
                    place + 1,
                    wish_words(stroke.wish)
                ),
            },
        );
    }
    for ((name, limit), lamp) in names.iter().zip(&fit.limits).zip(lamps) {
        match limit {
            Some(Limit::Most) => notes.push(format!("{name} is at its upper limit, {}.", lamp.limits.most)),
            Some(Limit::Least) => notes.push(format!("{name} is at its lower limit, {}.", lamp.limits.least)),
            None => {}
        }
    }
    if notes.is_empty() {
        notes.push(format!("All is met within {:.0} %.", (100.0 * MET)));
    }
    notes
}

/// A wish with its number.
fn wish_words(wish: Wish) -> String {
    let name = wish.name();
    match wish {
        Wish::Brighter(factor) | Wish::Darker(factor) => format!("{name} {factor}"),
        Wish::Luminance(nit) => format!("{nit} nit"),
        Wish::Illuminance(lux) => format!("{lux} lx"),
        Wish::Color(_) | Wish::Keep => name.to_owned(),
    }
}
