//! The mixing desk of the finished picture: a channel for every light, with strength, colour, solo and mute. Changes
//! need no new samples; the film keeps each light in a layer. Baking writes strengths and colours to the lights
//! themselves.

use bevy::prelude::{Entity, Res, ResMut, Resource};

use crate::color::Rgb;
use crate::engine::{LightGroup, RenderFilm};
use crate::scene::{AreaLight, Emitter, EmitterKind, Parameter, Texture};

/// The channels that are not neutral; a light without one is unchanged.
#[derive(Resource, Clone, Debug, Default, PartialEq)]
pub struct LightMix {
    channels: Vec<(Entity, Channel)>,
    baked: Gains,
}

/// The factors that have been baked into lights so far, in total.
type Gains = Vec<(Entity, Rgb)>;

/// The factors that had been baked into the lights when the film was begun. Until a film has the present lights, the
/// display multiplies by the difference.
#[derive(Resource, Clone, Debug, Default, PartialEq)]
pub struct FilmLights {
    /// The job as [`RenderFilm::job`].
    job: u64,
    baked: Gains,
}

pub(crate) fn note_film_lights(mut lights: ResMut<FilmLights>, film: Res<RenderFilm>, mix: Res<LightMix>) {
    if lights.job != film.job {
        lights.job = film.job;
        lights.baked.clone_from(&mix.baked);
    }
}

/// The mix of one light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Channel {
    /// The brightness factor, beside that of the colour.
    pub strength: f32,
    /// Linear Rec. 709.
    pub color: Rgb,
    /// Whether this light is solo. If any is, only solo lights are shown.
    pub solo: bool,
    /// Whether the light is muted.
    pub mute: bool,
}

impl Default for Channel {
    fn default() -> Self {
        Self {
            strength: 1.0,
            color: Rgb::ONE,
            solo: false,
            mute: false,
        }
    }
}

impl Channel {
    pub(crate) fn gain(&self) -> Rgb {
        self.strength * self.color
    }

    /// The channel after baking: strength and colour are part of the light now; solo and mute stay.
    pub(crate) fn baked(self) -> Self {
        Self {
            solo: self.solo,
            mute: self.mute,
            ..Self::default()
        }
    }
}

impl LightMix {
    /// The channel of a light, neutral unless it was set.
    pub fn channel(&self, light: Entity) -> Channel {
        let found = self.channels.iter().find(|(entity, _)| *entity == light);
        found.map_or_else(Channel::default, |(_, channel)| *channel)
    }

    /// The lights whose channels are not neutral.
    pub(crate) fn lamps(&self) -> impl Iterator<Item = Entity> {
        self.channels.iter().map(|(lamp, _)| *lamp)
    }

    /// Replaces the channel of a light.
    pub fn set(&mut self, light: Entity, channel: Channel) {
        self.channels.retain(|(entity, _)| *entity != light);
        if channel != Channel::default() {
            self.channels.push((light, channel));
            self.channels.sort_by_key(|(entity, _)| *entity);
        }
    }

    /// The mix with other channels; baked factors stay.
    pub(crate) fn with_channels(&self, of: Self) -> Self {
        Self {
            channels: of.channels,
            baked: self.baked.clone(),
        }
    }

    /// Notes that the light was multiplied by `gain` in the scene; solo and mute of its channel stay.
    pub(crate) fn note_baked(&mut self, light: Entity, gain: Rgb) {
        self.set(light, self.channel(light).baked());
        match self.baked.iter_mut().find(|(entity, _)| *entity == light) {
            Some((_, baked)) => *baked *= gain,
            None => self.baked.push((light, gain)),
        }
    }

    pub(crate) fn is_neutral(&self) -> bool {
        self.channels.is_empty()
    }

    /// The factors on the layers of a film of these groups, begun with `lights`; an empty list if all of them are one.
    /// Lights that share a layer have the channel of the first.
    pub(crate) fn factors(&self, groups: &[LightGroup], lights: &FilmLights) -> Vec<Rgb> {
        let any_solo = groups.iter().any(|group| self.group_channel(group).solo);
        let factor = |group: &LightGroup| match self.group_channel(group) {
            Channel { mute: true, .. } => Rgb::ZERO,
            Channel { solo: false, .. } if any_solo => Rgb::ZERO,
            channel => channel.gain() * self.baked_since(group, lights),
        };
        let factors: Vec<Rgb> = groups.iter().map(factor).collect();
        if factors.iter().all(|factor| *factor == Rgb::ONE) {
            return Vec::new();
        }
        factors
    }

    /// What layers of a film of these groups, begun with `lights`, are multiplied by to have the light of the scene as
    /// it is.
    pub(crate) fn scales(&self, groups: &[LightGroup], lights: &FilmLights) -> Vec<Rgb> {
        groups.iter().map(|group| self.baked_since(group, lights)).collect()
    }

    fn baked_since(&self, group: &LightGroup, lights: &FilmLights) -> Rgb {
        let of = |gains: &Gains| {
            let found = gains.iter().find(|(light, _)| group.entities.first() == Some(light));
            found.map_or(Rgb::ONE, |(_, gain)| *gain)
        };
        let (now, then) = (of(&self.baked), of(&lights.baked));
        // The film has no light of a dark lamp that could be multiplied.
        let ratio = |now: f32, then: f32| if now == then || then == 0.0 { 1.0 } else { now / then };
        Rgb::new(ratio(now.x, then.x), ratio(now.y, then.y), ratio(now.z, then.z))
    }

    pub(crate) fn group_channel(&self, group: &LightGroup) -> Channel {
        let first = group.entities.first();
        first.map_or_else(Channel::default, |&light| self.channel(light))
    }

    /// The factors of lights that baking multiplies by, without factors of one.
    pub(crate) fn gains(&self, groups: &[LightGroup]) -> Vec<(Entity, Rgb)> {
        let of_group = |group: &LightGroup| {
            let gain = self.group_channel(group).gain();
            let lights = group.entities.clone().into_iter();
            lights.map(move |light| (light, gain))
        };
        let gains = groups.iter().flat_map(of_group);
        gains.filter(|(_, gain)| *gain != Rgb::ONE).collect()
    }
}

/// The reason why a light cannot be multiplied, as the end of a sentence.
const FROM_PICTURE: &str = "takes its colour from a picture";
const ONLY_GREY: &str = "can be made brighter or darker, but not of another colour";

/// Returns the light with its radiance times `gain`.
pub(crate) fn bake_area(light: &AreaLight, gain: Rgb) -> Result<AreaLight, &'static str> {
    Ok(AreaLight {
        radiance: bake_parameter(&light.radiance, gain)?,
        ..light.clone()
    })
}

/// Returns the emitter with its strength times `gain`.
pub(crate) fn bake_emitter(emitter: &Emitter, gain: Rgb) -> Result<Emitter, &'static str> {
    let mut baked = emitter.clone();
    match &mut baked.kind {
        EmitterKind::Point { intensity } | EmitterKind::Spot { intensity, .. } => *intensity *= gain,
        EmitterKind::Directional { irradiance } => *irradiance *= gain,
        EmitterKind::Constant { radiance } => *radiance *= gain,
        EmitterKind::Luminaire { scale, .. } => *scale *= gain,
        EmitterKind::Environment { scale, .. } => *scale *= grey(gain)?,
        EmitterKind::Projector { irradiance, scale, .. } => match irradiance {
            Parameter::Constant(irradiance) => *irradiance *= gain,
            Parameter::Texture(_) => *scale *= grey(gain)?,
        },
        EmitterKind::SunSky(sky) => {
            let gain = grey(gain)?;
            sky.sky_scale *= gain;
            sky.sun_scale *= gain;
        }
        EmitterKind::ReflectionProbe { .. }
        | EmitterKind::IrradianceVolume { .. }
        | EmitterKind::IlluminanceMeter { .. }
        | EmitterKind::IlluminanceGrid { .. }
        | EmitterKind::MarkerPoint
        | EmitterKind::MarkerBox
        | EmitterKind::MarkerSphere
        | EmitterKind::MarkerPath => {}
    }
    Ok(baked)
}

fn grey(gain: Rgb) -> Result<f32, &'static str> {
    if gain == Rgb::splat(gain.x) {
        Ok(gain.x)
    } else {
        Err(ONLY_GREY)
    }
}

fn bake_parameter(value: &Parameter<Rgb>, gain: Rgb) -> Result<Parameter<Rgb>, &'static str> {
    let mut baked = value.clone();
    match &mut baked {
        Parameter::Constant(color) => *color *= gain,
        Parameter::Texture(texture) => match texture {
            Texture::Bitmap(_) => return Err(FROM_PICTURE),
            Texture::Checkerboard { color0, color1, .. } => {
                for color in [color0, color1] {
                    **color = bake_parameter(color, gain)?;
                }
            }
            Texture::MeshAttribute { scale, .. } => *scale *= grey(gain)?,
            Texture::Pattern(_) => return Err(FROM_PICTURE),
        },
    }
    Ok(baked)
}

#[cfg(test)]
mod tests {
    use bevy::prelude::World;

    use super::*;

    fn lights() -> [Entity; 3] {
        let mut world = World::new();
        std::array::from_fn(|_| world.spawn_empty().id())
    }

    fn groups(lights: &[Entity]) -> Vec<LightGroup> {
        let alone = |&light: &Entity| LightGroup { entities: vec![light] };
        lights.iter().map(alone).collect()
    }

    const RED: Channel = Channel {
        strength: 2.0,
        color: Rgb::X,
        solo: false,
        mute: false,
    };

    #[test]
    fn factors_follow_the_channels() {
        let lights = lights();
        let groups = groups(&lights);
        let (mut mix, film) = (LightMix::default(), FilmLights::default());
        assert!(mix.factors(&groups, &film).is_empty() && mix.is_neutral());
        mix.set(lights[1], RED);
        assert_eq!(mix.factors(&groups, &film), [Rgb::ONE, 2.0 * Rgb::X, Rgb::ONE]);
        // The film of another scene is left as it is.
        assert!(mix.factors(&groups[..1], &film).is_empty());
        let soloist = Channel {
            solo: true,
            ..Channel::default()
        };
        mix.set(lights[2], soloist);
        assert_eq!(mix.factors(&groups, &film), [Rgb::ZERO, Rgb::ZERO, Rgb::ONE]);
        mix.set(lights[2], Channel { mute: true, ..soloist });
        assert_eq!(mix.factors(&groups, &film), [Rgb::ZERO; 3]);
        mix.set(lights[2], Channel::default());
        mix.set(lights[1], Channel::default());
        assert!(mix.is_neutral());
    }

    /// While rendering is paused, or before the first tile, the film still has the lights as they were.
    #[test]
    fn a_film_from_before_the_bake_is_shown_with_the_mix() {
        let lights = lights();
        let groups = groups(&lights);
        let mut mix = LightMix::default();
        mix.set(lights[0], RED);
        let shown = mix.factors(&groups, &FilmLights::default());
        let before = mix.clone();
        mix.note_baked(lights[0], RED.gain());
        assert!(mix.is_neutral());
        assert_eq!(mix.factors(&groups, &FilmLights::default()), shown);
        // The light gets stronger before there is another film.
        mix.set(
            lights[0],
            Channel {
                strength: 3.0,
                ..Channel::default()
            },
        );
        assert_eq!(
            mix.factors(&groups, &FilmLights::default()),
            [6.0 * Rgb::X, Rgb::ONE, Rgb::ONE]
        );
        mix = mix.with_channels(LightMix::default());
        assert_eq!(mix.factors(&groups, &FilmLights::default()), shown);
        // A film with the lights as they are now.
        let film = FilmLights {
            job: 2,
            baked: mix.baked.clone(),
        };
        assert_eq!(mix.factors(&groups, &film), []);
        // The light is dark again after undo: the film has more of it than the scene, and the mix compensates.
        assert_eq!(before.factors(&groups, &film)[0].x, 2.0 / 2.0);
        assert_eq!(
            before.with_channels(LightMix::default()).factors(&groups, &film)[0].x,
            0.5
        );
    }

    #[test]
    fn baking_takes_strengths_and_colours_and_leaves_solo_and_mute() {
        let lights = lights();
        let shared = [LightGroup {
            entities: lights[..2].to_vec(),
        }];
        let mut mix = LightMix::default();
        mix.set(lights[0], Channel { mute: true, ..RED });
        assert_eq!(
            mix.gains(&shared),
            [(lights[0], 2.0 * Rgb::X), (lights[1], 2.0 * Rgb::X)]
        );
        let mut left = mix.clone();
        left.note_baked(lights[0], 2.0 * Rgb::X);
        assert_eq!(left.gains(&shared), []);
        assert!(left.channel(lights[0]).mute);
    }

    #[test]
    fn lights_are_multiplied_or_say_why_not() {
        let gain = Rgb::new(2.0, 1.0, 0.5);
        let lamp = AreaLight {
            radiance: Rgb::splat(3.0).into(),
            ..AreaLight::default()
        };
        let baked = bake_area(&lamp, gain).map(|lamp| lamp.radiance);
        assert_eq!(baked, Ok(Parameter::Constant(Rgb::new(6.0, 3.0, 1.5))));
        let mut pictured = lamp.clone();
        pictured.radiance.set_picture("/sky.exr".into());
        assert_eq!(bake_area(&pictured, gain), Err(FROM_PICTURE));
        for plugin in Emitter::PLUGINS {
            let emitter = Emitter::of_plugin(plugin).expect("a plugin");
            if !emitter.shines() {
                continue;
            }
            let brighter = bake_emitter(&emitter, Rgb::splat(2.0)).expect("every kind of light can be brighter");
            assert_ne!(brighter, emitter, "{plugin}");
            assert_eq!(bake_emitter(&brighter, Rgb::splat(0.5)), Ok(emitter), "{plugin}");
        }
        let sky = Emitter::of_plugin("sunsky")
            .or(Emitter::of_plugin("envmap"))
            .expect("a plugin");
        assert_eq!(bake_emitter(&sky, gain), Err(ONLY_GREY));
    }
}
