//! Materials for tests: each is put together twice, as the table wants it and as a function of what its parts give.
//! Functions take directions in the local frame of one slanted surface.

mod textured;

pub use textured::{pictures, tables, texel_uv, textured_models};

use std::rc::Rc;

use glam::{Mat2, UVec2, Vec2, Vec3};
use sunroom::accel::SurfacePoint;
use sunroom::color::Rgb;
use sunroom::material::{BumpOptions, Material, MaterialId, MaterialTable, ScatterSample, Scattering};
use sunroom::math::Frame;
use sunroom::sampling::{Sampler, SequenceKind, warp};
use sunroom::shading::{
    Bsdf, Compensation, Conductor, ConductorSpecular, DielectricModel, Diffuse, Microfacet, MicrofacetKind,
    RoughConductor, RoughDielectric, ShadingTables, ThinDielectric, TransportMode, ior,
};
use sunroom::texture::{Parameter, TextureId, TexturePoint, TextureTable};

/// The last of a list of materials, on the surface of the tests.
pub struct Placed {
    table: MaterialTable,
    root: MaterialId,
    textures: TextureTable,
    pub uv: Vec2,
}

/// The local frame: z is the normal, x as near to dp_du as it can be.
pub fn frame() -> Frame {
    let (n, dp_du) = (Vec3::new(0.48, -0.6, 0.64), Vec3::new(2.0, 0.5, -0.3));
    let s = (dp_du - n * n.dot(dp_du)).normalize();
    Frame { s, t: n.cross(s), n }
}

pub fn world(local: Vec3) -> Vec3 {
    frame().to_world(local)
}

impl Placed {
    pub fn new(materials: Vec<Material>) -> Self {
        Self {
            root: MaterialId(materials.len() as u32 - 1),
            table: MaterialTable::with_tables(materials, tables()).expect("materials that can be"),
            textures: pictures(),
            uv: texel_uv(2, 1),
        }
    }

    pub fn surface(&self) -> SurfacePoint {
        SurfacePoint {
            position: Vec3::new(1.0, 2.0, 3.0),
            error: 0.0,
            geometric_normal: frame().n,
            shading_normal: frame().n,
            uv: self.uv,
            dp_du: Vec3::new(2.0, 0.5, -0.3),
            dp_dv: Vec3::new(0.1, 1.0, 0.7),
        }
    }

    /// `wo` in the local frame.
    pub fn scattering(&self, wo: Vec3) -> Scattering<'_> {
        self.scattering_of(wo, TransportMode::Radiance)
    }

    pub fn scattering_of(&self, wo: Vec3, mode: TransportMode) -> Scattering<'_> {
        let at = TexturePoint::of_uv(self.uv);
        self.table
            .scattering(self.root, &self.surface(), world(wo), mode, &self.textures, &at)
    }

    /// Sample number `index`; also checks what holds of every sample.
    pub fn sample(&self, scattering: &Scattering, index: u32) -> Option<ScatterSample> {
        let sampler = Sampler::new(SequenceKind::Independent, UVec2::new(4, 9), index, 2);
        let sample = scattering.sample(sampler.at_1d(0), sampler.at_2d(1))?;
        let sound = (sample.wi.length() - 1.0).abs() < 1e-5
            && sample.weight.is_finite()
            && sample.weight.min_element() >= 0.0
            && sample.pdf.is_finite()
            && sample.pdf > 0.0;
        assert!(sound, "{sample:?}");
        Some(sample)
    }
}

/// Uniform over the sphere.
pub fn random_direction(index: u32) -> Vec3 {
    let sampler = Sampler::new(SequenceKind::Independent, UVec2::new(8, 1), index, 6);
    warp::uniform_sphere(sampler.at_2d(0).to_array())
}

type Value = Rc<dyn Fn(Vec3, Vec3) -> Rgb>;
type Passing = Rc<dyn Fn(Vec3) -> Rgb>;
type Add = Rc<dyn Fn(&mut Vec<Material>) -> MaterialId>;

/// What light's way back is compared about.
#[derive(Clone, Copy)]
pub struct About {
    pub normal: Vec3,
    /// Index behind the surface over that before it.
    pub eta: f32,
    /// Of the shadowing function.
    alpha_squared: f32,
}

impl About {
    /// Estevez, Lecocq and Stein 2019: G of a GGX surface towards the light.
    pub fn shadowing(&self, wi: Vec3) -> f32 {
        let tan_squared = (1.0 - wi.z * wi.z) / (wi.z * wi.z);
        2.0 / (1.0 + (1.0 + self.alpha_squared * tan_squared).sqrt())
    }
}

/// A material, and what it must be.
#[derive(Clone)]
struct Made {
    /// Adds it to a list.
    add: Add,
    value: Value,
    passing: Passing,
    /// None where two normals are at work.
    about: Option<About>,
}

const FLAT: About = About {
    normal: Vec3::Z,
    eta: 1.0,
    alpha_squared: 0.0,
};

fn push(list: &mut Vec<Material>, material: Material) -> MaterialId {
    list.push(material);
    MaterialId(list.len() as u32 - 1)
}

fn plain(bsdf: Bsdf) -> Made {
    let eta = match bsdf {
        Bsdf::RoughDielectric(rough) => rough.eta,
        _ => 1.0,
    };
    Made {
        add: Rc::new(move |list| push(list, bsdf.into())),
        value: Rc::new(move |wo, wi| bsdf.eval(&ShadingTables::default(), wo, wi, TransportMode::Radiance)),
        passing: Rc::new(move |wo| bsdf.transmittance(wo)),
        about: Some(About { eta, ..FLAT }),
    }
}

fn null() -> Made {
    Made {
        add: Rc::new(|list| push(list, Material::Null)),
        value: Rc::new(|_, _| Rgb::ZERO),
        passing: Rc::new(|_| Rgb::ONE),
        about: Some(FLAT),
    }
}

impl Made {
    fn two_sided(self, behind: Self) -> Self {
        let turned = |v: Vec3| v.with_z(-v.z);
        let sides = [self.add, behind.add];
        Self {
            add: Rc::new(move |list| {
                let [front, back] = [0, 1].map(|side: usize| sides[side](list));
                push(list, Material::TwoSided { front, back })
            }),
            value: Rc::new(move |wo, wi| match wo.z > 0.0 {
                true => (self.value)(wo, wi),
                false => (behind.value)(turned(wo), turned(wi)),
            }),
            passing: Rc::new(move |wo| match wo.z > 0.0 {
                true => (self.passing)(wo),
                false => (behind.passing)(turned(wo)),
            }),
            about: self.about.filter(|about| about.normal == Vec3::Z),
        }
    }

    fn blend(self, other: Self, (weight, share): (Parameter<f32>, f32)) -> Self {
        let parts = [self.add, other.add];
        let about = match (self.about, other.about) {
            (Some(a), Some(b)) if a.normal == b.normal => Some(if a.eta == 1.0 { b } else { a }),
            _ => None,
        };
        Self {
            add: Rc::new(move |list| {
                let [first, second] = [0, 1].map(|part: usize| parts[part](list));
                push(list, Material::Blend { first, second, weight })
            }),
            value: Rc::new(move |wo, wi| (1.0 - share) * (self.value)(wo, wi) + share * (other.value)(wo, wi)),
            passing: Rc::new(move |wo| (1.0 - share) * (self.passing)(wo) + share * (other.passing)(wo)),
            about,
        }
    }

    fn mask(self, (opacity, share): (Parameter<f32>, f32)) -> Self {
        Self {
            add: Rc::new(move |list| {
                let nested = (self.add)(list);
                push(list, Material::Mask { nested, opacity })
            }),
            value: Rc::new(move |wo, wi| share * (self.value)(wo, wi)),
            passing: Rc::new(move |wo| Rgb::splat(1.0 - share) + share * (self.passing)(wo)),
            about: self.about,
        }
    }

    fn normal_map(self, (normals, color): (Parameter<Rgb>, Rgb), flip: bool, shadow: bool) -> Self {
        let upright = (2.0 * color - Vec3::ONE).normalize();
        self.about_normal(upright, flip, shadow, move |nested, options| Material::NormalMap {
            nested,
            normals,
            gltf_tangents: false,
            options,
        })
    }

    /// The surface moved by `scale` times the smooth picture.
    fn bump_map(self, scale: f32, flip: bool, shadow: bool) -> Self {
        let height = Parameter::Texture(TextureId(2));
        // The slope along the surface that gives the heights their derivatives by u and v; the steps stay between the
        // same texels.
        let (uv, step) = (texel_uv(2, 1), 0.25 / 64.0);
        let at = |uv| pictures().float(height, &TexturePoint::of_uv(uv));
        let by_uv = Vec2::new(at(uv + step * Vec2::X) - at(uv), at(uv + step * Vec2::Y) - at(uv)) / step;
        let surface = Placed::new(vec![Material::Null]).surface();
        let [du, dv] = [surface.dp_du, surface.dp_dv].map(|tangent| frame().to_local(tangent).truncate());
        let slope = scale * (Mat2::from_cols(du, dv).transpose().inverse() * by_uv);
        assert!(slope.length() > 0.1, "{slope}: hardly a bump");
        let upright = (Vec3::Z - slope.extend(0.0)).normalize();
        self.about_normal(upright, flip, shadow, move |nested, options| Material::BumpMap {
            nested,
            height,
            scale,
            options,
        })
    }

    /// About a normal of the local frame; `around` is the material that has it.
    fn about_normal(
        self,
        upright: Vec3,
        flip: bool,
        shadow: bool,
        around: impl Fn(MaterialId, BumpOptions) -> Material + 'static,
    ) -> Self {
        let options = BumpOptions {
            flip_invalid_normals: flip,
            use_shadowing_function: shadow,
        };
        let tan_squared = (1.0 - upright.z * upright.z) / (upright.z * upright.z);
        let about = About {
            normal: upright,
            eta: self.about.map_or(1.0, |about| about.eta),
            alpha_squared: if shadow { (0.125 * tan_squared).min(1.0) } else { 0.0 },
        };
        // The normal seen from `wo`, and directions about it.
        let normal = move |wo: Vec3| match flip && wo.z * wo.dot(upright) <= 0.0 {
            true => Vec3::new(-upright.x, -upright.y, upright.z),
            false => upright,
        };
        let bumped = move |n: Vec3, v: Vec3| {
            let s = (Vec3::X - n * n.x).normalize();
            Vec3::new(v.dot(s), v.dot(n.cross(s)), v.dot(n))
        };
        let counted = move |n: Vec3, wi: Vec3| match wi.z * wi.dot(n) > 0.0 {
            true => about.shadowing(wi),
            false => 0.0,
        };
        Self {
            add: Rc::new(move |list| {
                let nested = (self.add)(list);
                push(list, around(nested, options))
            }),
            value: Rc::new(move |wo, wi| {
                let n = normal(wo);
                counted(n, wi) * (self.value)(bumped(n, wo), bumped(n, wi))
            }),
            passing: Rc::new(move |wo| {
                let n = normal(wo);
                counted(n, -wo) * (self.passing)(bumped(n, wo))
            }),
            about: self.about.filter(|nested| nested.normal == Vec3::Z).map(|_| about),
        }
    }
}

/// A material in its table and as functions of local directions.
pub struct Case {
    pub name: String,
    pub placed: Placed,
    /// f |cos wi| for `wo`, `wi`.
    pub value: Value,
    /// What a shadow ray finds of the light straight behind, by `wo`.
    pub passing: Passing,
    /// Whether nothing is absorbed, seen from anywhere.
    pub is_white: bool,
    /// None where two normals are at work.
    pub reciprocal_about: Option<About>,
}

pub fn diffuse(reflectance: Rgb) -> Bsdf {
    Bsdf::Diffuse(Diffuse { reflectance })
}

fn specular(material: &str) -> ConductorSpecular {
    let (eta, k) = ior::conductor_ior(material).expect("a known material");
    ConductorSpecular {
        eta,
        k,
        specular_reflectance: Rgb::ONE,
    }
}

fn metal(material: &str, alpha_x: f32, alpha_y: f32) -> Bsdf {
    Bsdf::RoughConductor(RoughConductor {
        specular: specular(material),
        distribution: Microfacet::new(MicrofacetKind::Ggx, alpha_x, alpha_y),
        multiple_scattering: Compensation::NONE,
    })
}

fn glass(eta: f32, alpha: f32) -> Bsdf {
    Bsdf::RoughDielectric(RoughDielectric {
        eta,
        model: DielectricModel::Exact,
        distribution: Microfacet::new(MicrofacetKind::Ggx, alpha, alpha),
        specular_reflectance: Rgb::ONE,
        specular_transmittance: Rgb::ONE,
    })
}

fn pane(transmittance: Rgb) -> Bsdf {
    Bsdf::ThinDielectric(ThinDielectric {
        eta: 1.5,
        model: DielectricModel::Exact,
        specular_reflectance: Rgb::ONE,
        specular_transmittance: transmittance,
    })
}

fn number(share: f32) -> (Parameter<f32>, f32) {
    (Parameter::Constant(share), share)
}

/// The grey picture's value where the surface of [`Placed::new`] is.
fn picture() -> (Parameter<f32>, f32) {
    let texture = Parameter::Texture(TextureId(1));
    let at = TexturePoint::of_uv(texel_uv(2, 1));
    (texture, pictures().float(texture, &at).clamp(0.0, 1.0))
}

fn normal(x: f32, y: f32, z: f32) -> (Parameter<Rgb>, Rgb) {
    let color = 0.5 * (Vec3::new(x, y, z) + Vec3::ONE);
    (Parameter::Constant(color), color)
}

/// At least five settings of every material that holds others.
pub fn all_cases() -> Vec<Case> {
    let red = plain(diffuse(Rgb::new(0.8, 0.1, 0.05)));
    let blue = plain(diffuse(Rgb::new(0.1, 0.2, 0.9)));
    let white = plain(diffuse(Rgb::ONE)).two_sided(plain(diffuse(Rgb::ONE)));
    let gold = plain(metal("Au", 0.1, 0.4));
    let dull = plain(metal("Cr", 0.5, 0.5));
    let mirror = plain(Bsdf::Conductor(Conductor {
        specular: specular("none"),
    }));
    let frosted = plain(glass(1.5, 0.3));
    let leaf = || plain(diffuse(Rgb::new(0.2, 0.6, 0.1))).two_sided(plain(diffuse(Rgb::new(0.5, 0.6, 0.3))));
    let slanted = || normal(0.3, -0.2, 0.93);

    let mut cases = Vec::new();
    let mut add = |name: &str, made: Made, is_white| {
        cases.push(Case {
            name: name.to_owned(),
            placed: {
                let mut materials = Vec::new();
                (made.add)(&mut materials);
                Placed::new(materials)
            },
            value: made.value,
            passing: made.passing,
            is_white,
            reciprocal_about: made.about,
        });
    };
    add("two sides, white", white.clone(), true);
    add("two sides, red and blue", red.clone().two_sided(blue.clone()), false);
    add("two sides, gold and gold", gold.clone().two_sided(gold.clone()), false);
    add(
        "two sides, mirror and red",
        mirror.clone().two_sided(red.clone()),
        false,
    );
    add(
        "two sides, blend and mask",
        gold.clone()
            .blend(blue.clone(), number(0.4))
            .two_sided(dull.clone().mask(number(0.6))),
        false,
    );

    add("blend, all first", red.clone().blend(gold.clone(), number(0.0)), false);
    add("blend, all second", red.clone().blend(gold.clone(), number(1.0)), false);
    add("blend, textured", red.clone().blend(gold.clone(), picture()), false);
    let mirrors = mirror.clone().two_sided(mirror.clone());
    add(
        "blend, white with mirror",
        white.clone().blend(mirrors, number(0.3)),
        true,
    );
    add(
        "blend, glass with blue",
        frosted.clone().blend(blue.clone(), number(0.25)),
        false,
    );
    let warm = red.clone().blend(gold.clone(), number(0.3));
    let cold = blue.clone().blend(dull.clone(), picture());
    add("blend of blends", warm.clone().blend(cold, number(0.7)), false);

    add("mask, nothing there", red.clone().mask(number(0.0)), false);
    add("mask, all there", red.clone().mask(number(1.0)), false);
    add("mask, white", white.clone().mask(number(0.35)), true);
    add("mask, textured", gold.clone().mask(picture()), false);
    add("mask over glass", frosted.clone().mask(number(0.8)), false);
    add("mask over mask", leaf().mask(number(0.6)).mask(number(0.5)), false);
    add("mask over a pane", plain(pane(Rgb::ONE)).mask(number(0.5)), true);

    add("null", null(), true);
    add("null in a blend", null().blend(white.clone(), number(0.6)), true);
    add("null behind red", red.clone().two_sided(null()), false);
    add("null in a mask", null().mask(picture()), true);
    add(
        "null with a pane",
        null().blend(plain(pane(Rgb::new(0.5, 1.0, 0.2))), number(0.5)),
        false,
    );

    for (name, flip, shadow) in [
        ("", false, false),
        (", flipped", true, false),
        (", shadowed", false, true),
        (", both", true, true),
    ] {
        let steep = || normal(-0.8, 0.3, 0.5);
        add(
            &format!("bumped white{name}"),
            white.clone().normal_map(slanted(), flip, shadow),
            false,
        );
        add(
            &format!("steep red{name}"),
            red.clone().normal_map(steep(), flip, shadow),
            false,
        );
        add(
            &format!("steep gold{name}"),
            gold.clone().normal_map(steep(), flip, shadow),
            false,
        );
        add(
            &format!("bumped glass{name}"),
            frosted.clone().normal_map(slanted(), flip, shadow),
            false,
        );
        add(
            &format!("bumped pane{name}"),
            plain(pane(Rgb::ONE)).normal_map(steep(), flip, shadow),
            false,
        );
    }
    for (name, scale, flip, shadow) in [
        ("", 0.1, false, false),
        (", inwards", -0.1, false, false),
        (", flipped", 0.1, true, false),
        (", shadowed", 0.2, false, true),
        (", both", -0.3, true, true),
    ] {
        add(
            &format!("white of heights{name}"),
            white.clone().bump_map(scale, flip, shadow),
            false,
        );
        add(
            &format!("gold of heights{name}"),
            gold.clone().bump_map(scale, flip, shadow),
            false,
        );
        add(
            &format!("glass of heights{name}"),
            frosted.clone().bump_map(scale, flip, shadow),
            false,
        );
    }
    add(
        "bumped by nothing",
        gold.clone().normal_map(normal(0.0, 0.0, 1.0), false, true),
        false,
    );
    let both = gold
        .clone()
        .normal_map(slanted(), false, true)
        .two_sided(red.clone().normal_map(slanted(), true, false));
    add("two bumped sides", both, false);
    for (name, flip, shadow) in [("", false, true), (", flipped", true, false), (", both", true, true)] {
        let flat = || normal(0.0, 0.0, 1.0);
        let leaning = || normal(0.2, 0.5, 0.7);
        let bumped = |nested: &Made| nested.clone().normal_map(slanted(), flip, shadow);
        add(
            &format!("flat in bumped{name}"),
            bumped(&gold.clone().normal_map(flat(), flip, shadow)),
            false,
        );
        add(
            &format!("leaning in bumped{name}"),
            bumped(&red.clone().normal_map(leaning(), flip, shadow)),
            false,
        );
        add(
            &format!("both sides in bumped{name}"),
            bumped(&leaf().normal_map(leaning(), flip, shadow)),
            false,
        );
        add(
            &format!("thrice bumped{name}"),
            bumped(&bumped(&dull.clone().normal_map(leaning(), flip, shadow))),
            false,
        );
    }
    add("bumped blend", warm.normal_map(slanted(), false, true), false);
    add(
        "blend of bumped and flat",
        dull.normal_map(slanted(), false, false).blend(blue, number(0.5)),
        false,
    );
    add(
        "mask over bumped",
        leaf().normal_map(slanted(), false, true).mask(picture()),
        false,
    );
    cases
}
