//! Converts materials of the scene to the terms of glTF. Properties without counterpart are left out or approximated,
//! and noted.

use super::layers::tinted;
use super::level::{Level, Map};
use super::look::{Appearance, Look};
use super::messages::Messages;
use super::pictures::Pictures;
use crate::color::Rgb;
use crate::scene::assets::pattern_tile::is_projected;
use crate::scene::components::description::MaterialDescription;
use crate::scene::{
    Absorption, ConductorIor, Distribution, Ior, Material, Parameter, Principled, PrincipledIndex, PrincipledThin,
    Roughness,
};
use crate::shading::{eta_from_specular, ior, melanin_absorption};

/// Converts materials to looks.
pub(super) struct Looks<'a, 'p> {
    pub materials: &'a [MaterialDescription],
    pub pictures: &'a mut Pictures<'p>,
    pub messages: &'a mut Messages,
}

impl Looks<'_, '_> {
    /// The look of the material with an index.
    pub fn of(&mut self, index: usize) -> Appearance {
        let Some(about) = self.materials.get(index) else {
            return Appearance::Surface(Look::matt(Level::number(0.5)).into());
        };
        let name = &*about.identity.name;
        let mut lost = |what: &str| self.messages.note("material", name, what);
        let look = match &about.material {
            Material::Null => return Appearance::Nothing,
            Material::TwoSided => {
                if about.second.is_some() && about.second != about.first {
                    lost("the back looks like the front");
                }
                return self.nested(about.first).changed(|look| Look {
                    is_two_sided: true,
                    ..look
                });
            }
            Material::Mask { opacity } => {
                let opacity = Level::of_number(opacity);
                return self
                    .nested(about.first)
                    .changed(|look| self.masked(look, opacity, name));
            }
            Material::Blend { weight } => return self.blend(about, Level::of_number(weight)),
            Material::NormalMap {
                normals, gltf_tangents, ..
            } => {
                let normals = Some(Level::of_color(normals)).filter(|level| level.constant().is_none());
                let gltf_tangents = *gltf_tangents;
                return self.nested(about.first).changed(|look| Look {
                    normals,
                    gltf_tangents,
                    ..look
                });
            }
            Material::BumpMap {
                height: Parameter::Texture(texture),
                scale,
                ..
            } if is_projected(texture) => {
                let bumps = Map::Bumps {
                    scale: *scale,
                    is_mirrored: false,
                };
                let normals = Level::of_number(&Parameter::Texture(texture.clone())).mapped(bumps);
                return self.nested(about.first).changed(|look| Look {
                    normals: Some(normals),
                    gltf_tangents: false,
                    ..look
                });
            }
            Material::BumpMap { height, .. } => {
                if height.constant().is_none() {
                    lost("the bumps are left out");
                }
                return self.nested(about.first);
            }
            Material::Diffuse { reflectance } => Look::matt(Level::of_color(reflectance)),
            Material::Conductor {
                ior,
                specular_reflectance,
            } => self.conductor(ior, specular_reflectance, Level::number(0.0), name),
            Material::RoughConductor {
                distribution,
                alpha,
                ior,
                specular_reflectance,
                multiple_scattering,
            } => {
                if *multiple_scattering {
                    lost("light that bounces between facets more than once is left out");
                }
                let roughness = self.roughness(*distribution, alpha, name);
                self.conductor(ior, specular_reflectance, roughness, name)
            }
            Material::Metal { reflectance, fuzz } => {
                // The nearest roughness, as in `convert --portable`: alpha is a tenth's root of the fuzz.
                let alpha = Level::of_number(fuzz).times(Rgb::splat(1.0 / 10.0f32.sqrt()));
                if !alpha.is(0.0) {
                    lost("the fuzz becomes the nearest roughness");
                }
                let roughness = match alpha {
                    Level::Constant(alpha) => Level::Constant(Map::Root.apply(alpha)),
                    // The factor is below the root.
                    Level::Varying(_) => Level::of_number(fuzz)
                        .mapped(Map::Root)
                        .times(Rgb::splat(10.0f32.powf(-0.25))),
                };
                Look::metal(Level::of_color(reflectance), roughness)
            }
            Material::Dielectric {
                interior,
                exterior,
                specular_reflectance,
                specular_transmittance,
            } => {
                let roughness = Level::number(0.0);
                self.glass(
                    interior,
                    exterior,
                    [specular_reflectance, specular_transmittance],
                    roughness,
                    name,
                )
            }
            Material::RoughDielectric {
                distribution,
                alpha,
                interior,
                exterior,
                specular_reflectance,
                specular_transmittance,
            } => {
                let roughness = self.roughness(*distribution, alpha, name);
                self.glass(
                    interior,
                    exterior,
                    [specular_reflectance, specular_transmittance],
                    roughness,
                    name,
                )
            }
            Material::ThinDielectric {
                interior,
                exterior,
                specular_reflectance,
                specular_transmittance,
            } => Look {
                is_thick: false,
                ..self.glass(
                    interior,
                    exterior,
                    [specular_reflectance, specular_transmittance],
                    Level::number(0.0),
                    name,
                )
            }
            .upright(),
            Material::Plastic {
                interior,
                exterior,
                diffuse_reflectance,
                specular_reflectance,
                nonlinear,
            } => {
                let roughness = Level::number(0.0);
                self.plastic(
                    interior,
                    exterior,
                    [diffuse_reflectance, specular_reflectance],
                    *nonlinear,
                    roughness,
                    name,
                )
            }
            Material::RoughPlastic {
                distribution,
                alpha,
                interior,
                exterior,
                diffuse_reflectance,
                specular_reflectance,
                nonlinear,
            } => {
                let roughness = self.roughness(*distribution, alpha, name);
                self.plastic(
                    interior,
                    exterior,
                    [diffuse_reflectance, specular_reflectance],
                    *nonlinear,
                    roughness,
                    name,
                )
            }
            Material::Principled(principled) => self.principled(principled, name),
            Material::PrincipledThin(thin) => self.principled_thin(thin, name),
            Material::Hair {
                absorption,
                azimuthal_roughness,
                longitudinal_roughness,
                ..
            } => {
                lost("a rough surface of about the same colour takes the place of hair");
                let sigma_a = match absorption {
                    Absorption::Melanin { eumelanin, pheomelanin } => melanin_absorption(*eumelanin, *pheomelanin),
                    Absorption::Given { sigma_a, scale } => *scale * self.mean(&Level::of_color(sigma_a)),
                };
                Look {
                    roughness: Level::number(longitudinal_roughness.clamp(0.0, 1.0)),
                    specular: 1.0,
                    ..Look::matt(Level::Constant(hair_color(sigma_a, *azimuthal_roughness)))
                }
            }
        };
        Appearance::Surface(look.into())
    }

    fn nested(&mut self, index: Option<usize>) -> Appearance {
        match index {
            Some(index) => self.of(index),
            None => Appearance::Surface(Look::matt(Level::number(0.5)).into()),
        }
    }

    fn mean(&mut self, level: &Level) -> Rgb {
        match level {
            Level::Constant(value) => *value,
            Level::Varying(varying) => self.pictures.mean(varying, self.messages),
        }
    }

    pub fn lose(&mut self, name: &str, what: &str) {
        self.messages.note("material", name, what);
    }

    fn masked(&mut self, look: Look, opacity: Level, name: &str) -> Look {
        let opacity = match (look.opacity, opacity) {
            (Level::Constant(inner), outer) => outer.times(inner),
            (inner, Level::Constant(outer)) => inner.times(outer),
            (_, outer) => {
                self.lose(name, "of two masks the outer one is taken");
                outer
            }
        };
        Look { opacity, ..look }
    }

    fn blend(&mut self, about: &MaterialDescription, weight: Level) -> Appearance {
        let name = &*about.identity.name;
        let (first, second) = (self.nested(about.first), self.nested(about.second.or(about.first)));
        let (first, second) = match (first, second) {
            // A blend with an invisible material is a mask.
            (Appearance::Nothing, second @ Appearance::Surface(_)) => {
                return second.changed(|look| self.masked(look, weight, name));
            }
            (first @ Appearance::Surface(_), Appearance::Nothing) if weight.constant().is_some() => {
                let share = Level::Constant(Rgb::ONE - self.mean(&weight));
                return first.changed(|look| self.masked(look, share, name));
            }
            (Appearance::Surface(first), Appearance::Surface(second)) => (*first, *second),
            (surface @ Appearance::Surface(_), _) | (_, surface) => {
                self.lose(name, "what is inside is not blended");
                return surface;
            }
        };
        if first != second {
            self.lose(
                name,
                "the two materials inside become one with the means of their numbers",
            );
        }
        let weight = self.mean(&weight).x.clamp(0.0, 1.0);
        Appearance::Surface(first.mixed(second, weight).into())
    }

    /// The square root of the width alpha of the slope distribution.
    fn roughness(&mut self, distribution: Distribution, alpha: &Roughness, name: &str) -> Level {
        if distribution == Distribution::Beckmann {
            self.lose(name, "the facets are spread by GGX, not Beckmann");
        }
        let rough = |alpha: &Parameter<f32>| Level::of_number(alpha).mapped(Map::Root);
        let level = match alpha {
            Roughness::Isotropic(alpha) => rough(alpha),
            Roughness::Anisotropic { u, v } => {
                self.lose(name, "the roughness is the same in all directions");
                match (rough(u), rough(v)) {
                    (Level::Constant(u), Level::Constant(v)) => Level::Constant((u * v).powf(0.5)),
                    (u, _) => u,
                }
            }
        };
        match level {
            Level::Constant(value) => Level::Constant(value.min(Rgb::ONE)),
            varying => varying,
        }
    }

    fn conductor(&mut self, ior: &ConductorIor, reflectance: &Parameter<Rgb>, roughness: Level, name: &str) -> Look {
        let (eta, k) = match ior {
            ConductorIor::Named(name) => ior::conductor_ior(name).unwrap_or((Rgb::ZERO, Rgb::ONE)),
            ConductorIor::Given { eta, k } => {
                let of = |looks: &mut Self, value: &Parameter<Rgb>| looks.mean(&Level::of_color(value));
                (of(self, eta), of(self, k))
            }
        };
        if eta != Rgb::ZERO {
            self.lose(
                name,
                "the index of refraction becomes the colour that the metal has head on",
            );
        }
        let near = (eta - Rgb::ONE) * (eta - Rgb::ONE) + k * k;
        let far = (eta + Rgb::ONE) * (eta + Rgb::ONE) + k * k;
        Look::metal(Level::of_color(reflectance).times(near / far), roughness)
    }

    fn index(interior: &Ior, exterior: &Ior) -> f32 {
        let number = |ior: &Ior| match ior {
            Ior::Named(name) => ior::dielectric_ior(name).unwrap_or(1.0),
            Ior::Number(number) => *number,
        };
        number(interior) / number(exterior)
    }

    /// The index of a surface that is not glass, at least 1.
    fn possible_index(&mut self, index: f32, name: &str) -> f32 {
        if index >= 1.0 {
            return index;
        }
        self.lose(name, "an index of refraction of 1 takes the place of one below");
        1.0
    }

    fn glass(
        &mut self,
        interior: &Ior,
        exterior: &Ior,
        [reflectance, transmittance]: [&Parameter<Rgb>; 2],
        roughness: Level,
        name: &str,
    ) -> Look {
        if *reflectance != Parameter::Constant(Rgb::ONE) {
            self.lose(name, "the factor on the reflection is left out");
        }
        // Light crosses the surface twice, and glTF's colour is that of both passes.
        let base = Level::of_color(transmittance).mapped(Map::Square);
        Look {
            roughness,
            transmission: Level::number(1.0),
            is_thick: true,
            index: Self::index(interior, exterior),
            specular: 1.0,
            ..Look::matt(base)
        }
    }

    fn plastic(
        &mut self,
        interior: &Ior,
        exterior: &Ior,
        [diffuse, specular]: [&Parameter<Rgb>; 2],
        nonlinear: bool,
        roughness: Level,
        name: &str,
    ) -> Look {
        self.lose(
            name,
            "the clear layer becomes the reflection of metallic-roughness, under which the base is brighter",
        );
        if nonlinear {
            self.lose(
                name,
                "the colour does not grow more saturated between base and clear layer",
            );
        }
        if specular.constant().is_none_or(|color| color != Rgb::splat(color.x)) {
            self.lose(name, "the reflection has no colour");
        }
        Look {
            roughness,
            index: self.possible_index(Self::index(interior, exterior), name),
            specular: self.mean(&Level::of_color(specular)).max_element().clamp(0.0, 1.0),
            ..Look::matt(Level::of_color(diffuse))
        }
    }

    fn principled(&mut self, given: &Principled, name: &str) -> Look {
        let index = match given.index {
            PrincipledIndex::Specular(specular) => eta_from_specular(specular),
            PrincipledIndex::Eta(eta) => eta,
        };
        self.lose_flatness(&given.flatness, name);
        let base = Level::of_color(&given.base_color);
        let sheen = self.sheen(&base, &given.sheen, &given.sheen_tint, name);
        let clearcoat = Level::of_number(&given.clearcoat);
        let gloss = self.uniform(
            &given.clearcoat_gloss,
            "the gloss of the coat is the mean of the texture",
            name,
        );
        Look {
            specular_tint: self.specular_tint(&base, &given.spec_tint, name),
            anisotropic: self.anisotropic(&given.anisotropic, &given.roughness, name),
            base,
            metallic: Level::of_number(&given.metallic),
            roughness: Level::of_number(&given.roughness),
            transmission: Level::of_number(&given.spec_trans),
            is_thick: given.refracts(),
            index: match given.refracts() {
                true => index,
                false => self.possible_index(index, name),
            },
            specular: 1.0,
            sheen,
            clearcoat_roughness: if clearcoat.is(0.0) { 0.0 } else { 1.0 - gloss },
            clearcoat,
            ..Look::matt(Level::number(1.0))
        }
    }

    fn principled_thin(&mut self, given: &PrincipledThin, name: &str) -> Look {
        self.lose_flatness(&given.flatness, name);
        let base = Level::of_color(&given.base_color);
        let sheen = self.sheen(&base, &given.sheen, &given.sheen_tint, name);
        // Clear light goes through in glTF before matt light does.
        let is_matt = given.spec_trans == Parameter::Constant(0.0);
        let passing = match given.diff_trans.constant().filter(|passing| is_matt || *passing == 0.0) {
            Some(passing) => 0.5 * passing.clamp(0.0, 2.0),
            None => {
                self.lose(name, "no matt light leaves on the other side");
                0.0
            }
        };
        let index = self.uniform(&given.eta, "the index of refraction is the mean of the texture", name);
        Look {
            specular_tint: self.specular_tint(&base, &given.spec_tint, name),
            anisotropic: self.anisotropic(&given.anisotropic, &given.roughness, name),
            base,
            roughness: Level::of_number(&given.roughness),
            transmission: Level::of_number(&given.spec_trans),
            index: self.possible_index(index, name),
            // A matt sheet mirrors nothing.
            specular: if passing > 0.0 { 0.0 } else { 1.0 },
            passing,
            sheen,
            is_two_sided: true,
            ..Look::matt(Level::number(1.0))
        }
    }

    fn lose_flatness(&mut self, flatness: &Parameter<f32>, name: &str) {
        if *flatness != Parameter::Constant(0.0) {
            self.lose(name, "the surface is not flatter than matt");
        }
    }

    fn sheen(&mut self, base: &Level, sheen: &Parameter<f32>, tint: &Parameter<f32>, name: &str) -> Rgb {
        if *sheen == Parameter::Constant(0.0) {
            return Rgb::ZERO;
        }
        let color = tinted(base, tint).unwrap_or_else(|| {
            self.lose(name, "the sheen is not tinted");
            Rgb::ONE
        });
        color * self.uniform(sheen, "the sheen is the mean of the texture", name)
    }

    fn specular_tint(&mut self, base: &Level, tint: &Parameter<f32>, name: &str) -> Rgb {
        tinted(base, tint).unwrap_or_else(|| {
            self.lose(name, "the mirror image is not tinted");
            Rgb::ONE
        })
    }

    fn anisotropic(&mut self, anisotropic: &Parameter<f32>, roughness: &Parameter<f32>, name: &str) -> f32 {
        match (anisotropic.constant(), roughness.constant()) {
            (Some(0.0), _) => 0.0,
            (Some(stretch), Some(_)) => stretch.clamp(0.0, 1.0),
            _ => {
                self.lose(name, "the roughness is the same in all directions");
                0.0
            }
        }
    }

    /// The constant, or the mean (reported) of a texture.
    fn uniform(&mut self, parameter: &Parameter<f32>, what: &str, name: &str) -> f32 {
        let level = Level::of_number(parameter);
        if level.constant().is_none() {
            self.lose(name, what);
        }
        self.mean(&level).x.clamp(0.0, 100.0)
    }
}

/// The approximate colour of many hairs with this absorption (Chiang and others 2016, a fit).
fn hair_color(sigma_a: Rgb, azimuthal_roughness: f32) -> Rgb {
    let b = azimuthal_roughness;
    let fit = 5.969 - 0.215 * b + 2.532 * b.powi(2) - 10.73 * b.powi(3) + 5.574 * b.powi(4) + 0.245 * b.powi(5);
    sigma_a
        .max(Rgb::ZERO)
        .map(|absorption| (-fit * absorption.sqrt()).exp())
}
