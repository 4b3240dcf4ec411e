//! Lamps that a game dims: the layers of a level that was baked with `--layers`, mixed anew when a factor has changed.

use std::sync::Arc;

use bevy::asset::RenderAssetUsages;
use bevy::image::{ImageLoaderSettings, ImageSampler};
use bevy::log::warn;
use bevy::prelude::*;
use bevy::render::render_resource::TextureUsages;
use bevy::tasks::futures::check_ready;
use bevy::tasks::{AsyncComputeTaskPool, Task};

use crate::manifest::LevelManifest;
use crate::mixing::{LARGEST, mix};

pub use crate::manifest::LayerKind;

/// The most bytes of the layers of a texture that are mixed within a frame; those of larger textures are mixed on
/// another thread, and shown some frames later.
const AT_ONCE: usize = 1 << 20;

/// The lamps of a level, on its entity together with [`LevelReady`](crate::LevelReady). Lightmaps, probes, surfaces
/// that shine and lights follow their factors. A level that was baked without `--layers` has none.
#[derive(Component, Clone, Debug, Default, PartialEq)]
pub struct Lamps {
    lamps: Vec<Lamp>,
}

/// A lamp of a level.
#[derive(Clone, Debug, PartialEq)]
pub struct Lamp {
    /// Its name in the scene.
    pub name: String,
    /// The kind of its lights.
    pub kind: LayerKind,
    /// The factor on its light, red, green and blue: 1 as baked, and 0 while it is off.
    pub factor: Vec3,
}

impl Lamps {
    /// All lamps.
    pub fn iter(&self) -> impl Iterator<Item = &Lamp> {
        self.lamps.iter()
    }

    /// The factor on the light of a lamp; None if there is no lamp of this name.
    pub fn factor(&self, name: &str) -> Option<Vec3> {
        self.iter().find(|lamp| lamp.name == name).map(|lamp| lamp.factor)
    }

    /// Dims a lamp, from 0 to 65504; other numbers count as the nearest one. False if there is no lamp of this name.
    pub fn set(&mut self, name: &str, strength: f32) -> bool {
        self.set_color(name, Vec3::splat(strength))
    }

    /// Sets the factor on each of the colours of a lamp, as [`Self::set`]. False if there is no lamp of this name.
    pub fn set_color(&mut self, name: &str, factor: Vec3) -> bool {
        let lamp = self.lamps.iter_mut().find(|lamp| lamp.name == name);
        // A NaN counts as 0.
        let factor = factor.max(Vec3::ZERO).min(Vec3::splat(LARGEST));
        lamp.map(|lamp| lamp.factor = factor).is_some()
    }
}

/// A texture that is the sum of layers.
struct Texture {
    shown: Handle<Image>,
    layers: Vec<Part>,
    /// The factors that it is mixed with.
    factors: Vec<Vec3>,
    /// The mixing of other factors.
    mixing: Option<(Vec<Vec3>, Task<Vec<u8>>)>,
}

/// A layer of a texture.
struct Part {
    layer: usize,
    /// The file, until it is loaded.
    file: Handle<Image>,
    texels: Arc<Vec<u8>>,
}

/// Something that shines as a lamp does, with its colour as it was baked.
enum Shining {
    Surface(Handle<StandardMaterial>, LinearRgba),
    Light(Entity, LinearRgba),
}

/// What follows the lamps of a level.
#[derive(Component, Default)]
pub(crate) struct Mixer {
    lamps: Vec<Lamp>,
    textures: Vec<Texture>,
    shining: Vec<(usize, Shining)>,
    /// The factors that surfaces and lights have.
    factors: Vec<Vec3>,
}

impl Mixer {
    /// The lamps of a manifest, without textures.
    pub fn new(manifest: &LevelManifest) -> Self {
        let lamp = |layer: &crate::manifest::LayerFiles| Lamp {
            name: layer.name.clone(),
            kind: layer.kind,
            factor: Vec3::ONE,
        };
        let lamps: Vec<Lamp> = manifest.layers.iter().map(lamp).collect();
        Self {
            factors: vec![Vec3::ONE; lamps.len()],
            lamps,
            ..default()
        }
    }

    /// The lamps that can be dimmed.
    pub fn lamps(&self) -> Lamps {
        let lamps = self.lamps.iter().filter(|lamp| lamp.kind != LayerKind::Rest);
        Lamps {
            lamps: lamps.cloned().collect(),
        }
    }

    /// Mixes a texture of the layers in these files. Returns what has to be loaded.
    pub fn add(
        &mut self,
        shown: &Handle<Image>,
        files: impl Iterator<Item = (usize, Handle<Image>)>,
    ) -> Vec<Handle<Image>> {
        let part = |(layer, file)| Part {
            layer,
            file,
            texels: Arc::default(),
        };
        let layers: Vec<Part> = files.map(part).collect();
        let waiting = layers.iter().map(|part| part.file.clone()).collect();
        if !layers.is_empty() {
            self.textures.push(Texture {
                shown: shown.clone(),
                factors: vec![Vec3::ONE; layers.len()],
                layers,
                mixing: None,
            });
        }
        waiting
    }

    /// Makes a surface follow a lamp.
    pub fn add_surface(&mut self, layer: usize, material: Handle<StandardMaterial>, emissive: LinearRgba) {
        self.shining.push((layer, Shining::Surface(material, emissive)));
    }

    /// Makes a light follow a lamp.
    pub fn add_light(&mut self, layer: usize, light: Entity, color: LinearRgba) {
        self.shining.push((layer, Shining::Light(light, color)));
    }

    /// Takes the texels of the layers, which graphics cards do not need.
    pub fn take_texels(&mut self, images: &mut Assets<Image>) {
        for texture in &mut self.textures {
            let length = images
                .get(&texture.shown)
                .and_then(|image| image.data.as_ref())
                .map_or(0, Vec::len);
            for part in &mut texture.layers {
                let image = images.remove(&part.file);
                part.texels = Arc::new(image.and_then(|image| image.data).unwrap_or_default());
                part.file = Handle::default();
            }
            if texture.layers.iter().any(|part| part.texels.len() != length) {
                warn!(
                    "a layer does not fit its texture: bake the level again; of two copies of a level, the first one's lamps dim both"
                );
                texture.layers.clear();
                texture.factors.clear();
            }
        }
    }
}

/// Layers are for this program alone, and textures are kept here as well, so that they can be changed.
pub(crate) fn of_layers(settings: &mut ImageLoaderSettings) {
    settings.sampler = ImageSampler::linear();
    settings.asset_usage = RenderAssetUsages::MAIN_WORLD;
}

impl Texture {
    /// Brings it closer to the factors of its layers: begins to mix it, or shows what has been mixed.
    fn follow(&mut self, factors: &[Vec3], images: &mut Assets<Image>) {
        if let Some((with, task)) = &mut self.mixing {
            let Some(texels) = check_ready(task) else {
                return;
            };
            self.factors = std::mem::take(with);
            self.mixing = None;
            show(&self.shown, texels, images);
        }
        let wanted: Vec<Vec3> = self.layers.iter().map(|part| factors[part.layer]).collect();
        if wanted == self.factors {
            return;
        }
        let layers: Vec<(Arc<Vec<u8>>, [f32; 3])> = self
            .layers
            .iter()
            .zip(&wanted)
            .filter(|(_, factor)| **factor != Vec3::ZERO)
            .map(|(part, factor)| (part.texels.clone(), factor.to_array()))
            .collect();
        let length = self.layers[0].texels.len();
        let mixed = move || mix(layers.iter().map(|(texels, factor)| (&texels[..], *factor)), length);
        if length * self.layers.len() <= AT_ONCE {
            self.factors = wanted;
            show(&self.shown, mixed(), images);
        } else {
            let task = AsyncComputeTaskPool::get().spawn(async move { mixed() });
            self.mixing = Some((wanted, task));
        }
    }
}

fn show(texture: &Handle<Image>, texels: Vec<u8>, images: &mut Assets<Image>) {
    if let Some(mut image) = images.get_mut(texture) {
        if image.texture_descriptor.mip_level_count > 1 {
            // Bevy copies only the first level into a texture that it may write to, and otherwise makes a new one.
            image.texture_descriptor.usage.remove(TextureUsages::COPY_DST);
        }
        image.data = Some(texels);
    }
}

/// Makes everything follow the lamps whose factors have changed.
pub(crate) fn follow(
    mut levels: Query<(&Lamps, &mut Mixer)>,
    mut images: ResMut<Assets<Image>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
    mut points: Query<&mut PointLight>,
    mut spots: Query<&mut SpotLight>,
    mut suns: Query<&mut DirectionalLight>,
) {
    for (lamps, mut mixer) in &mut levels {
        let mixer = &mut *mixer;
        let wanted = |lamp: &Lamp| lamps.factor(&lamp.name).filter(|_| lamp.kind != LayerKind::Rest);
        let factors: Vec<Vec3> = mixer
            .lamps
            .iter()
            .map(|lamp| wanted(lamp).unwrap_or(Vec3::ONE))
            .collect();
        for texture in &mut mixer.textures {
            texture.follow(&factors, &mut images);
        }
        if factors == mixer.factors {
            continue;
        }
        let before = std::mem::replace(&mut mixer.factors, factors);
        let changed = mixer
            .shining
            .iter()
            .filter(|(layer, _)| before[*layer] != mixer.factors[*layer]);
        for (layer, shining) in changed {
            let factor = mixer.factors[*layer];
            let dimmed = |color: &LinearRgba| {
                let [red, green, blue] = (Vec3::new(color.red, color.green, color.blue) * factor).to_array();
                LinearRgba::rgb(red, green, blue)
            };
            match shining {
                Shining::Surface(material, color) => {
                    if let Some(mut material) = materials.get_mut(material) {
                        material.emissive = dimmed(color);
                    }
                }
                Shining::Light(light, color) => {
                    let color = Color::from(dimmed(color));
                    if let Ok(mut light) = points.get_mut(*light) {
                        light.color = color;
                    } else if let Ok(mut light) = spots.get_mut(*light) {
                        light.color = color;
                    } else if let Ok(mut light) = suns.get_mut(*light) {
                        light.color = color;
                    }
                }
            }
        }
    }
}
