//! Finds the figures of the inspected light: how much of each photometric unit it gives, and the curve of a lamp with
//! measured intensities.

use std::path::Path;
use std::sync::{Arc, Weak};

use bevy::math::Affine3A;
use bevy::prelude::*;

use super::light_figures::{LightFigures, PLANES};
use super::{EditorModel, Inspected};
use crate::accel::Tlas;
use crate::color::luminance;
use crate::engine::{MeasureOf, PackedScene, measures_of_area_light, measures_of_emitter, own_flux};
use crate::light::PictureLight;
use crate::photometry::{IntensityPicture, LUMENS_PER_WATT, LightUnit, PolarCurve};
use crate::scene::{AreaLight, Emitter, EmitterKind, LengthUnit, LightUnits, Pictures, TextureMap, ToWorld};
use crate::texture::Image;

/// Where the figures are found besides the light itself.
#[derive(Clone, Copy)]
struct Sources<'a> {
    pictures: Option<&'a Pictures>,
    images: Option<&'a Assets<TextureMap>>,
    packed: Option<&'a PackedScene>,
    /// The length of a unit of the world in metres.
    metres: f64,
}

impl<'a> Sources<'a> {
    fn image(&self, path: &Path) -> Option<&'a Arc<Image>> {
        Some(&self.images?.get(self.pictures?.get(path)?)?.image)
    }

    fn geometry(&self) -> Option<&'a Arc<Tlas>> {
        Some(&self.packed?.scene.as_ref()?.geometry)
    }

    /// The area of one side of a shape, once it is packed.
    fn area(&self, entity: Entity) -> Option<f64> {
        let mut entities = self.packed?.entity_of_instance.iter();
        let place = entities.position(|other| *other == entity)?;
        Some(self.geometry()?.instances().get(place)?.area())
    }
}

/// The picture of a light: the file of intensities, or the picture of all directions.
fn picture_of(emitter: &Emitter) -> Option<&Path> {
    match &emitter.kind {
        EmitterKind::Luminaire { profile: path, .. } | EmitterKind::Environment { picture: path, .. } => Some(path),
        _ => None,
    }
}

/// The measures of a light of the scene, in whatever units the scene shows it.
pub fn measures_of(world: &World, entity: Entity) -> Vec<MeasureOf> {
    let sources = Sources {
        pictures: world.get_resource(),
        images: world.get_resource(),
        packed: world.get_resource(),
        metres: world.get_resource::<LengthUnit>().map_or(1.0, |unit| unit.metres()),
    };
    if let Some(emitter) = world.get::<Emitter>(entity) {
        let image = picture_of(emitter).and_then(|path| sources.image(path));
        let pose = world.get::<ToWorld>(entity).copied().unwrap_or_default();
        return measures_of_emitter(
            emitter,
            pose.0,
            image.map(|image| PictureLight::new(image)),
            sources.metres,
        );
    }
    match world.get::<AreaLight>(entity) {
        Some(light) => measures_of_area_light(light, sources.area(entity), sources.metres),
        None => Vec::new(),
    }
}

/// What was computed for the last light, which is read again in every frame.
#[derive(Default)]
pub(crate) struct Known {
    picture: Option<(Weak<Image>, PictureLight, Option<Arc<[PolarCurve]>>)>,
    area: Option<(Entity, Weak<Tlas>, Option<f64>)>,
    measures: Option<(Emitter, Affine3A, Option<PictureLight>, f64, Vec<MeasureOf>)>,
}

impl Known {
    fn picture(&mut self, image: &Arc<Image>, is_lamp: bool) -> (PictureLight, Option<Arc<[PolarCurve]>>) {
        if let Some((known, light, curves)) = &self.picture
            && known.as_ptr() == Arc::as_ptr(image)
            && curves.is_some() == is_lamp
        {
            return (*light, curves.clone());
        }
        let light = PictureLight::new(image);
        let curves = is_lamp.then(|| curves_of(image));
        self.picture = Some((Arc::downgrade(image), light, curves.clone()));
        (light, curves)
    }

    fn measures(
        &mut self,
        emitter: &Emitter,
        pose: Affine3A,
        picture: Option<PictureLight>,
        metres: f64,
    ) -> Vec<MeasureOf> {
        if let Some((of, at, seen, unit, measures)) = &self.measures
            && (of, *at, *seen, *unit) == (emitter, pose, picture, metres)
        {
            return measures.clone();
        }
        let measures = measures_of_emitter(emitter, pose, picture, metres);
        self.measures = Some((emitter.clone(), pose, picture, metres, measures.clone()));
        measures
    }

    fn area(&mut self, entity: Entity, sources: &Sources) -> Option<f64> {
        let geometry = sources.geometry()?;
        if let Some((of, known, area)) = &self.area
            && *of == entity
            && known.as_ptr() == Arc::as_ptr(geometry)
        {
            return *area;
        }
        let area = sources.area(entity);
        self.area = Some((entity, Arc::downgrade(geometry), area));
        area
    }
}

/// The curves of a picture of intensities in W/sr.
fn curves_of(image: &Image) -> Arc<[PolarCurve]> {
    let (width, height) = (image.width(), image.height());
    let pixels = (0..height).flat_map(|row| (0..width).map(move |column| (column, row)));
    let candela = pixels.map(|(column, row)| LUMENS_PER_WATT * luminance(image.pixel(column, row)));
    let picture = IntensityPicture {
        width,
        height,
        candela: candela.collect(),
    };
    PLANES.map(|c| PolarCurve::of_picture(&picture, c)).into()
}

/// Adds the figures to the inspected light.
pub(crate) fn gather_light_figures(
    mut model: ResMut<EditorModel>,
    (units, length): (Option<Res<LightUnits>>, Option<Res<LengthUnit>>),
    pictures: Option<Res<Pictures>>,
    images: Option<Res<Assets<TextureMap>>>,
    packed: Option<Res<PackedScene>>,
    mut known: Local<Known>,
) {
    let sources = Sources {
        pictures: pictures.as_deref(),
        images: images.as_deref(),
        packed: packed.as_deref(),
        metres: length.map_or(1.0, |unit| unit.metres()),
    };
    let is_photometric = units.is_some_and(|units| *units == LightUnits::Photometric);
    if let Some(inspected) = &mut model.0.inspected {
        inspected.light_figures = figures(inspected, &sources, is_photometric, &mut known);
    }
}

/// The lumens and the candela of a lamp with measured intensities; None for other lights.
fn emitted(emitter: &Emitter, measures: &[MeasureOf]) -> Option<[f32; 2]> {
    let EmitterKind::Luminaire { scale, .. } = &emitter.kind else {
        return None;
    };
    let amount = |unit: LightUnit| {
        let (_, measure) = measures.iter().find(|(_, measure)| measure.unit == unit)?;
        Some(measure.per_strength * luminance(*scale))
    };
    Some([amount(LightUnit::Lumen)?, amount(LightUnit::Candela)?])
}

fn figures(inspected: &Inspected, sources: &Sources, is_photometric: bool, known: &mut Known) -> LightFigures {
    let mut figures = LightFigures::default();
    if let Some(emitter) = &inspected.emitter {
        let is_lamp = matches!(emitter.kind, EmitterKind::Luminaire { .. });
        let image = picture_of(emitter).filter(|_| is_lamp || is_photometric);
        let image = image.and_then(|path| sources.image(path));
        let (picture, curves) = image.map(|image| known.picture(image, is_lamp)).unzip();
        figures.curves = curves.flatten();
        figures.own_flux = picture.as_ref().filter(|_| is_lamp).map(own_flux);
        if is_photometric || is_lamp {
            let to_world = inspected.to_world.unwrap_or_default();
            let measures = known.measures(emitter, to_world, picture, sources.metres);
            figures.emitted = emitted(emitter, &measures);
            figures.measures = if is_photometric { measures } else { Vec::new() };
        }
    } else if let Some(light) = inspected.area_light.as_ref().filter(|_| is_photometric) {
        figures.measures = measures_of_area_light(light, known.area(inspected.entity, sources), sources.metres);
    }
    figures
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::color::Rgb;

    #[test]
    fn a_lamp_emits_its_flux_times_its_strength() {
        let picture = PictureLight {
            mean: 0.1,
            peak: 0.5,
            irradiance: 0.2,
        };
        let own = own_flux(&picture);
        for (flux, scale, lumens) in [(0.0, 1.0, own), (0.0, 0.5, 0.5 * own), (1000.0, 0.5, 500.0)] {
            let lamp = Emitter::from(EmitterKind::Luminaire {
                profile: "lamp.ies".into(),
                scale: Rgb::splat(scale),
                flux,
            });
            let measures = measures_of_emitter(&lamp, Affine3A::IDENTITY, Some(picture), 1.0);
            let [found, peak] = emitted(&lamp, &measures).expect("it is a lamp");
            let candela = lumens / own * LUMENS_PER_WATT * picture.peak;
            assert!((found / lumens - 1.0).abs() < 1e-5, "{found} {lumens}");
            assert!((peak / candela - 1.0).abs() < 1e-5, "{peak} {candela}");
        }
        assert_eq!(emitted(&Emitter::default(), &[]), None);
    }
}
