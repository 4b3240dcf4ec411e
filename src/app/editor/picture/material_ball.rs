//! The preview of a material: a ball of it on a checkerboard under two soft boxes, rendered by the kernel from the same
//! tables as the picture. It uses neither windows nor entities.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use glam::{Affine2, Affine3A, Mat3, Vec2, Vec3};

use crate::accel::{Instance, Primitive, SplitMethod, Tlas};
use crate::color::Rgb;
use crate::light::{LightId, LightSource, LightTable, WeightedSource};
use crate::material::{Material, MaterialId, MaterialTable, TexturedBsdf};
use crate::medium::{MediumId, MediumInterface, MediumSource, MediumTable};
use crate::render::camera::Camera;
use crate::render::film::Film;
use crate::render::filter::PixelFilter;
use crate::render::light_layers::LightGroups;
use crate::render::scene::{RenderScene, SurfaceSlot, SurfaceTable};
use crate::render::tile::{render_tile, tiles};
use crate::render::view::{Integrator, PathSettings, Shown, Strategy, View};
use crate::sampling::SequenceKind;
use crate::shading::{Bsdf, Diffuse};
use crate::texture::{Checkerboard, Parameter, Texture, TextureTable};

/// A material in the tables of a scene.
#[derive(Clone, Debug)]
pub struct BallMaterial {
    pub materials: Arc<MaterialTable>,
    pub textures: Arc<TextureTable>,
    pub material: MaterialId,
    /// The medium in the ball, whose radius is a unit of length.
    pub inside: Option<MediumSource>,
}

impl PartialEq for BallMaterial {
    /// Whether the two look the same, whatever their tables hold besides.
    fn eq(&self, other: &Self) -> bool {
        if self.inside != other.inside {
            return false;
        }
        let same_tables =
            Arc::ptr_eq(&self.materials, &other.materials) && Arc::ptr_eq(&self.textures, &other.textures);
        if same_tables && self.material == other.material {
            return true;
        }
        // Ids of textures are valid only in their own table.
        let same_textures = Arc::ptr_eq(&self.textures, &other.textures) || self.textures == other.textures;
        same_textures && self.looks_like(self.material, other, other.material)
    }
}

impl BallMaterial {
    /// Tables have no cycles.
    fn looks_like(&self, own: MaterialId, other: &Self, its: MaterialId) -> bool {
        let (Some(own), Some(its)) = (self.materials.get(own), other.materials.get(its)) else {
            return false;
        };
        let (inside, plain) = without_nested(own);
        let (its_inside, its_plain) = without_nested(its);
        plain == its_plain
            && inside.len() == its_inside.len()
            && inside
                .iter()
                .zip(its_inside)
                .all(|(&own, its)| self.looks_like(own, other, its))
    }
}

/// The nested materials, and the material with zeros as their ids.
fn without_nested(material: &Material) -> (Vec<MaterialId>, Material) {
    let mut plain = material.clone();
    let inside = match &mut plain {
        Material::TwoSided { front, back } => vec![front, back],
        Material::Blend { first, second, .. } => vec![first, second],
        Material::Mask { nested, .. } | Material::NormalMap { nested, .. } | Material::BumpMap { nested, .. } => {
            vec![nested]
        }
        Material::Plain(_) | Material::Textured(_) | Material::Null => Vec::new(),
    };
    let ids = inside
        .into_iter()
        .map(|id| std::mem::replace(id, MaterialId(0)))
        .collect();
    (ids, plain)
}

/// The scene with the ball, and its view.
pub struct MaterialBall {
    scene: RenderScene,
    view: View,
}

/// Half the edge of a square of the checkerboard.
const SQUARE: f32 = 0.5;
/// Half the edge of floor and wall.
const ROOM: f32 = 12.0;

impl MaterialBall {
    /// Makes the scene of a picture of `edge` pixels squared. None if the material is not in its own table.
    pub fn new(look: &BallMaterial, edge: u32) -> Option<Self> {
        look.materials.get(look.material)?;
        let (textures, squares) = look.textures.with(Texture::Checkerboard(Checkerboard {
            colors: [0.55, 0.22].map(|grey| Parameter::Constant(Rgb::splat(grey))),
            to_uv: Affine2::from_scale(Vec2::splat(ROOM / (2.0 * SQUARE))),
        }));
        let room = Material::Textured(TexturedBsdf::Diffuse {
            reflectance: Parameter::Texture(squares),
        });
        let lamp = Material::Plain(Bsdf::Diffuse(Diffuse { reflectance: Rgb::ZERO }));
        let first = look.materials.len() as u32;
        let materials = look.materials.with([room, lamp]).ok()?;
        let (room, lamp) = (MaterialId(first), MaterialId(first + 1));

        // The poles of the ball, where textures shrink to a point, lie above and below.
        let ball = Affine3A::from_translation(Vec3::Z);
        let floor = Affine3A::from_scale(Vec3::splat(ROOM));
        let wall = Affine3A::from_translation(Vec3::new(0.0, 5.0, 0.0))
            * Affine3A::from_rotation_x(90f32.to_radians())
            * floor;
        let key = facing(Vec3::new(-3.4, -3.2, 5.0), Vec3::Z, Vec2::new(1.3, 1.3));
        let rim = facing(Vec3::new(4.2, -0.6, 2.8), Vec3::Z, Vec2::new(0.5, 1.6));
        let parts = [
            (Primitive::Sphere, ball),
            (Primitive::Rectangle, floor),
            (Primitive::Rectangle, wall),
            (Primitive::Rectangle, key),
            (Primitive::Rectangle, rim),
        ];
        let instances: Vec<Instance> = parts
            .into_iter()
            .map(|(primitive, place)| Instance::new(primitive, place))
            .collect::<Option<_>>()?;
        let geometry = Tlas::build(instances, SplitMethod::default());
        let media = MediumTable::new(look.inside.iter().cloned().collect());
        let filled = MediumInterface {
            interior: look.inside.as_ref().map(|_| MediumId(0)),
            exterior: None,
        };
        let slot = |material, light: Option<u32>| SurfaceSlot {
            material,
            light: light.map(LightId),
            media: MediumInterface::default(),
        };
        let surfaces = SurfaceTable {
            first_slot: (0..5).collect(),
            slots: vec![
                SurfaceSlot {
                    media: filled,
                    ..slot(look.material, None)
                },
                slot(room, None),
                slot(room, None),
                slot(lamp, Some(0)),
                slot(lamp, Some(1)),
            ],
        };
        let soft_box = |instance, radiance| LightSource::Surface {
            is_two_sided: false,
            instance,
            slot: 0,
            radiance: Parameter::Constant(Rgb::splat(radiance)),
        };
        // The light makes white paint that faces the key light a little darker than white.
        let dim = LightSource::Constant {
            radiance: Rgb::splat(0.22),
        };
        let lights: Vec<WeightedSource> = [soft_box(3, 17.0), soft_box(4, 7.0), dim]
            .map(WeightedSource::from)
            .into();
        let textures = Arc::new(textures);
        let lights = LightTable::build(&lights, &geometry, &textures);
        Some(Self {
            scene: RenderScene {
                media: Arc::new(media),
                reach: lights.reach(&geometry),
                lights: Arc::new(lights),
                geometry: Arc::new(geometry),
                surfaces: Arc::new(surfaces),
                materials: Arc::new(materials),
                textures,
            },
            view: view_with(edge, look.inside.is_some()),
        })
    }

    /// An empty film for the picture.
    pub fn film(&self) -> Film {
        Film::new(self.view.width, self.view.height)
    }

    /// Adds samples to every pixel; None if `cancel` was set in the meantime.
    pub fn refine(&self, film: &mut Film, samples: u32, cancel: &AtomicBool) -> Option<()> {
        let done = film.sample_count();
        for tile in tiles(self.view.width, self.view.height) {
            film.add(&render_tile(
                &self.scene,
                &self.view,
                tile,
                done..done + samples,
                cancel,
            )?);
        }
        Some(())
    }
}

/// A rectangle of this half size at `place` whose front faces `target`.
fn facing(place: Vec3, target: Vec3, half_size: Vec2) -> Affine3A {
    let front = (target - place).normalize();
    let across = Vec3::Z.cross(front).normalize();
    let turn = Mat3::from_cols(across, front.cross(across), front);
    Affine3A::from_mat3_translation(turn, place) * Affine3A::from_scale(half_size.extend(1.0))
}

/// The view for a picture of `edge` pixels squared: a little from above, at the ball and the ground before it.
pub fn view(edge: u32) -> View {
    view_with(edge, false)
}

/// The depth of paths below a surface, where light is scattered very often.
const DEPTH_IN_MEDIA: u32 = 512;

/// The same view with or without media.
fn view_with(edge: u32, media: bool) -> View {
    let (eye, target) = (Vec3::new(0.0, -6.4, 2.7), Vec3::new(0.0, 0.0, 0.96));
    let forward = (target - eye).normalize();
    let left = Vec3::Z.cross(forward).normalize();
    let axes = Mat3::from_cols(left, forward.cross(left), forward);
    View {
        camera: Camera::new(Affine3A::from_mat3_translation(axes, eye), 21.0, 1.0, 0.1, 100.0, None),
        film_camera: None,
        width: edge,
        height: edge,
        medium: None,
        filter: PixelFilter::Box,
        integrator: Integrator::Path(PathSettings {
            max_depth: if media { DEPTH_IN_MEDIA } else { 12 },
            rr_depth: 5,
            hide_emitters: false,
            media,
            strategy: Strategy::Mis,
        }),
        shown: Shown::Radiance,
        sight: Default::default(),
        light_groups: LightGroups::default(),
        layers: Default::default(),
        before: None,
        sequence: SequenceKind::Sobol,
        seed: 0,
        photons: Default::default(),
        clamp: None,
        guide: None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::medium::{Phase, Volume};

    fn look(materials: Vec<Material>, material: u32) -> BallMaterial {
        BallMaterial {
            materials: Arc::new(MaterialTable::new(materials).expect("no circles")),
            textures: Arc::default(),
            material: MaterialId(material),
            inside: None,
        }
    }

    fn paint(reflectance: Rgb) -> Material {
        Material::Plain(Bsdf::Diffuse(Diffuse { reflectance }))
    }

    const EDGE: u32 = 24;

    /// Mean over the middle of the ball.
    fn middle(look: &BallMaterial, samples: u32) -> Rgb {
        let ball = MaterialBall::new(look, EDGE).expect("the material is there");
        let mut film = ball.film();
        let go_on = AtomicBool::new(false);
        ball.refine(&mut film, samples, &go_on).expect("not cancelled");
        let places = (10..14).flat_map(|y| (10..14).map(move |x| (x, y)));
        let sum: Rgb = places
            .filter_map(|(x, y)| film.pixel(x, y))
            .map(|pixel| pixel.radiance)
            .sum();
        sum / 16.0
    }

    #[test]
    fn the_ball_is_of_the_material() {
        let black = middle(&look(vec![paint(Rgb::ZERO)], 0), 16);
        assert_eq!(black, Rgb::ZERO);
        let red = middle(&look(vec![paint(Rgb::ZERO), paint(Rgb::new(0.8, 0.1, 0.1))], 1), 64);
        // Direct light alone makes the channels differ by the factor 8; the light back from the grey room makes them
        // differ by less than the square.
        assert!(red.x > 6.0 * red.y && red.y > 0.0, "{red}");
        let white = middle(&look(vec![paint(Rgb::ONE)], 0), 64);
        // The exposure burns out nothing white, and leaves nothing dark.
        assert!(white.x > 0.5 && white.x < 1.1, "{white}");
    }

    #[test]
    fn a_ball_of_nothing_shows_the_room() {
        let through = middle(&look(vec![Material::Null], 0), 64);
        assert!(through.x > 0.02, "{through}");
    }

    #[test]
    fn a_medium_fills_the_ball() {
        let of = |sigma_t: f32| {
            let inside = MediumSource {
                sigma_t: Volume::Constant(Rgb::splat(sigma_t)),
                scale: 1.0,
                albedo: Volume::ZERO,
                emission: Volume::ZERO,
                phase: Phase::Isotropic,
            };
            BallMaterial {
                inside: Some(inside),
                ..look(vec![Material::Null], 0)
            }
        };
        let (clear, dark) = (middle(&of(0.0), 64), middle(&of(1.0), 64));
        // The path through the middle of the ball is nearly two units long.
        let share = dark.x / clear.x;
        assert!((0.13..0.16).contains(&share), "{share}");
        assert_ne!(of(0.0), of(1.0));
    }

    #[test]
    fn passes_add_up_to_the_picture_of_one() {
        let look = look(vec![paint(Rgb::splat(0.5))], 0);
        let ball = MaterialBall::new(&look, EDGE).expect("the material is there");
        let go_on = AtomicBool::new(false);
        let (mut at_once, mut in_passes) = (ball.film(), ball.film());
        ball.refine(&mut at_once, 8, &go_on).expect("not cancelled");
        for samples in [1, 1, 2, 4] {
            ball.refine(&mut in_passes, samples, &go_on).expect("not cancelled");
        }
        assert_eq!(in_passes.sample_count(), 8);
        let pairs = at_once.radiance().into_iter().zip(in_passes.radiance());
        // The same samples, summed in another order.
        assert!(pairs.into_iter().all(|(a, b)| a.abs_diff_eq(b, 1e-4)));
        assert!(ball.refine(&mut in_passes, 1, &AtomicBool::new(true)).is_none());
    }

    #[test]
    fn looks_are_compared_and_not_tables() {
        let two_sided = |front, back| Material::TwoSided {
            front: MaterialId(front),
            back: MaterialId(back),
        };
        let (red, blue) = (paint(Rgb::X), paint(Rgb::Z));
        let one = look(vec![red.clone(), blue.clone(), two_sided(0, 1)], 2);
        let moved = look(vec![two_sided(3, 1), blue.clone(), paint(Rgb::Y), red.clone()], 0);
        assert_eq!(one, moved);
        let swapped = look(vec![red.clone(), blue.clone(), two_sided(1, 0)], 2);
        assert_ne!(one, swapped);
        let repainted = look(vec![red, paint(Rgb::ONE), two_sided(0, 1)], 2);
        assert_ne!(one, repainted);
        assert!(MaterialBall::new(&look(vec![blue], 5), EDGE).is_none());
    }
}
