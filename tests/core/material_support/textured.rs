//! Pictures with values in and out of range, and every model with all that may be a texture taken from them.

use std::sync::Arc;

use glam::{Affine2, Vec2};
use sunroom::color::{Rgb, luminance};
use sunroom::material::{
    TexturedBase, TexturedBsdf, TexturedFacets, TexturedPrincipled, TexturedPrincipledThin, TexturedSpecular,
};
use sunroom::sampling::{hash::pcg3d, unit_float};
use sunroom::shading::{
    Bsdf, CoatId, CoatedBase, Compensation, Conductor, ConductorSpecular, Dielectric, DielectricModel, Diffuse, Fiber,
    Hair, Metal, MicroalbedoId, Microfacet, MicrofacetKind, Plastic, Principled, PrincipledThin, RoughConductor,
    RoughDielectric, RoughPlastic, SamplingRates, ShadingTables, SmoothCoat, ThinDielectric, ThinSamplingRates,
};
use sunroom::texture::{Bitmap, Filter, Image, Parameter, Samples, Texture, TextureId, TextureTable, Transfer, Wrap};

const SIZE: u32 = 4;

/// In [-0.3, 1.4].
fn noise(x: u32, y: u32, channel: u32) -> f32 {
    1.7 * unit_float(pcg3d([x, y, 77 + channel])[0]) - 0.3
}

fn color_at(x: u32, y: u32) -> Rgb {
    Rgb::new(noise(x, y, 0), noise(x, y, 1), noise(x, y, 2))
}

/// A grey picture as a number.
fn number_at(x: u32, y: u32) -> f32 {
    luminance(Rgb::splat(noise(x, y, 3)))
}

fn bitmap(channels: u32, filter: Filter, value: impl Fn(u32, u32, u32) -> f32) -> Texture {
    let samples = (0..SIZE * SIZE * channels).map(|i| {
        let pixel = i / channels;
        value(pixel % SIZE, pixel / SIZE, i % channels)
    });
    let samples = Samples::F32(samples.collect());
    Texture::Bitmap(Bitmap {
        image: Arc::new(Image::new(SIZE, SIZE, channels as usize, samples, Transfer::Linear).expect("a picture")),
        filter,
        wrap: [Wrap::Repeat; 2],
        raw: false,
        to_uv: Affine2::IDENTITY,
    })
}

/// Texture 0 is coloured, texture 1 grey, texture 2 grey and smooth between texels.
pub fn pictures() -> TextureTable {
    let grey = |filter| bitmap(1, filter, |x, y, _| noise(x, y, 3));
    TextureTable::new(vec![
        bitmap(3, Filter::Nearest, noise),
        grey(Filter::Nearest),
        grey(Filter::Bilinear),
    ])
}

/// The tables that the models below have ids of: one coat and one micro-albedo.
pub fn tables() -> ShadingTables {
    let mut tables = ShadingTables::default();
    tables.varying_coat(MicrofacetKind::Ggx, 1.49);
    tables.microalbedo_of(MicrofacetKind::Ggx);
    tables
}

/// The middle of a texel.
pub fn texel_uv(x: u32, y: u32) -> Vec2 {
    (Vec2::new(x as f32, y as f32) + 0.5) / SIZE as f32
}

/// Every model with the pictures for parameters, and what it is where the texel (x, y) lies.
pub fn textured_models(x: u32, y: u32) -> Vec<(TexturedBsdf, Bsdf)> {
    let color = Parameter::Texture(TextureId(0));
    let float = Parameter::Texture(TextureId(1));
    let (plain, number) = (color_at(x, y), number_at(x, y));
    let (tint, share) = (plain.clamp(Rgb::ZERO, Rgb::ONE), number.clamp(0.0, 1.0));
    let model = DielectricModel::Exact;

    let textured_specular = TexturedSpecular {
        eta: color,
        k: color,
        specular_reflectance: color,
    };
    let specular = ConductorSpecular {
        eta: plain.max(Rgb::ZERO),
        k: plain.max(Rgb::ZERO),
        specular_reflectance: tint,
    };
    let textured_facets = TexturedFacets {
        kind: MicrofacetKind::Ggx,
        alpha_u: float,
        alpha_v: Parameter::Constant(0.3),
    };
    let facets = Microfacet::new(MicrofacetKind::Ggx, number, 0.3);
    let textured_base = TexturedBase {
        diffuse_reflectance: color,
        specular_reflectance: color,
        nonlinear: true,
    };
    let base = CoatedBase {
        diffuse_reflectance: tint,
        specular_reflectance: tint,
        nonlinear: true,
    };
    let fiber = Fiber::new(1.55, 0.3, 0.3, 0.03);
    let (coat, microalbedo) = (CoatId(0), MicroalbedoId(0));
    let mut models = vec![
        (
            TexturedBsdf::Diffuse { reflectance: color },
            Bsdf::Diffuse(Diffuse { reflectance: tint }),
        ),
        (
            TexturedBsdf::Conductor {
                specular: textured_specular,
            },
            Bsdf::Conductor(Conductor { specular }),
        ),
        (
            TexturedBsdf::RoughConductor {
                specular: textured_specular,
                facets: textured_facets,
                multiple_scattering: None,
            },
            Bsdf::RoughConductor(RoughConductor {
                specular,
                distribution: facets,
                multiple_scattering: Compensation::NONE,
            }),
        ),
        (
            TexturedBsdf::RoughConductor {
                specular: textured_specular,
                facets: textured_facets,
                multiple_scattering: Some(microalbedo),
            },
            Bsdf::RoughConductor(RoughConductor {
                specular,
                distribution: facets,
                multiple_scattering: Compensation::new(microalbedo, &facets, &specular),
            }),
        ),
        (
            TexturedBsdf::Dielectric {
                eta: 1.4,
                model,
                specular_reflectance: color,
                specular_transmittance: color,
            },
            Bsdf::Dielectric(Dielectric {
                eta: 1.4,
                model,
                specular_reflectance: tint,
                specular_transmittance: tint,
            }),
        ),
        (
            TexturedBsdf::RoughDielectric {
                eta: 1.4,
                model,
                facets: textured_facets,
                specular_reflectance: color,
                specular_transmittance: color,
            },
            Bsdf::RoughDielectric(RoughDielectric {
                eta: 1.4,
                model,
                distribution: facets,
                specular_reflectance: tint,
                specular_transmittance: tint,
            }),
        ),
        (
            TexturedBsdf::ThinDielectric {
                eta: 1.4,
                model,
                specular_reflectance: color,
                specular_transmittance: color,
            },
            Bsdf::ThinDielectric(ThinDielectric {
                eta: 1.4,
                model,
                specular_reflectance: tint,
                specular_transmittance: tint,
            }),
        ),
        (
            TexturedBsdf::Plastic {
                coat: SmoothCoat::new(1.49),
                base: textured_base,
            },
            Bsdf::Plastic(Plastic {
                coat: SmoothCoat::new(1.49),
                base,
            }),
        ),
        (
            TexturedBsdf::RoughPlastic {
                coat,
                alpha: float,
                base: textured_base,
            },
            Bsdf::RoughPlastic(RoughPlastic {
                coat,
                alpha: number,
                base,
            }),
        ),
        (
            TexturedBsdf::Metal {
                reflectance: color,
                fuzz: float,
            },
            Bsdf::Metal(Metal {
                color: tint,
                fuzz: share,
            }),
        ),
        (
            TexturedBsdf::Hair {
                fiber,
                sigma_a: color,
                scale: 2.0,
            },
            Bsdf::Hair(Hair {
                fiber,
                sigma_a: (2.0 * plain).max(Rgb::ZERO),
            }),
        ),
    ];
    models.extend(principled(tint, number));
    models
}

/// The principled models, which have a number for nearly all that they are.
fn principled(tint: Rgb, number: f32) -> [(TexturedBsdf, Bsdf); 2] {
    let color = Parameter::Texture(TextureId(0));
    let float = Parameter::Texture(TextureId(1));
    let share = number.clamp(0.0, 1.0);
    let rates = SamplingRates {
        main_specular: 1.0,
        clearcoat: 1.0,
        diffuse_reflectance: 1.0,
    };
    let thin_rates = ThinSamplingRates {
        specular_reflectance: 1.0,
        specular_transmittance: 1.0,
        diffuse_reflectance: 1.0,
        diffuse_transmittance: 1.0,
    };
    let solid = TexturedPrincipled {
        base_color: color,
        roughness: float,
        anisotropic: float,
        metallic: float,
        spec_trans: float,
        eta: 1.5,
        spec_tint: float,
        sheen: float,
        sheen_tint: float,
        flatness: float,
        clearcoat: float,
        clearcoat_gloss: float,
        rates,
    };
    let thin = TexturedPrincipledThin {
        base_color: color,
        roughness: float,
        anisotropic: float,
        spec_trans: float,
        diff_trans: float,
        eta: Parameter::Constant(1.5),
        spec_tint: float,
        sheen: float,
        sheen_tint: float,
        flatness: float,
        rates: thin_rates,
    };
    [
        (
            TexturedBsdf::Principled(solid),
            Bsdf::Principled(Principled {
                base_color: tint,
                roughness: share,
                anisotropic: share,
                metallic: share,
                spec_trans: share,
                eta: 1.5,
                spec_tint: share,
                sheen: share,
                sheen_tint: share,
                flatness: share,
                clearcoat: share,
                clearcoat_gloss: share,
                rates,
            }),
        ),
        (
            TexturedBsdf::PrincipledThin(thin),
            Bsdf::PrincipledThin(PrincipledThin {
                base_color: tint,
                roughness: share,
                anisotropic: share,
                spec_trans: share,
                diff_trans: number.clamp(0.0, 2.0),
                eta: 1.5,
                spec_tint: share,
                sheen: share,
                sheen_tint: share,
                flatness: share,
                rates: thin_rates,
            }),
        ),
    ]
}
