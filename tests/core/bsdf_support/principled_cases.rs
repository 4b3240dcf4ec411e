//! Settings of the principled models: every lobe and combination of lobes five times.

use sunroom::color::Rgb;
use sunroom::shading::{Principled, PrincipledThin, SamplingRates, ThinSamplingRates, eta_from_specular};

pub const GOLD: Rgb = Rgb::new(0.9, 0.6, 0.2);

/// The defaults of the scene format.
pub const PRINCIPLED: Principled = Principled {
    base_color: Rgb::splat(0.5),
    roughness: 0.5,
    anisotropic: 0.0,
    metallic: 0.0,
    spec_trans: 0.0,
    eta: 1.5,
    spec_tint: 0.0,
    sheen: 0.0,
    sheen_tint: 0.0,
    flatness: 0.0,
    clearcoat: 0.0,
    clearcoat_gloss: 0.0,
    rates: SamplingRates {
        main_specular: 1.0,
        clearcoat: 1.0,
        diffuse_reflectance: 1.0,
    },
};

/// The defaults of the scene format.
pub const THIN: PrincipledThin = PrincipledThin {
    base_color: Rgb::splat(0.5),
    roughness: 0.5,
    anisotropic: 0.0,
    spec_trans: 0.0,
    diff_trans: 0.0,
    eta: 1.5,
    spec_tint: 0.0,
    sheen: 0.0,
    sheen_tint: 0.0,
    flatness: 0.0,
    rates: ThinSamplingRates {
        specular_reflectance: 1.0,
        specular_transmittance: 1.0,
        diffuse_reflectance: 1.0,
        diffuse_transmittance: 1.0,
    },
};

/// Colour, roughness, relative index, and how much of the lobe's own parameter.
const SETTINGS: [(Rgb, f32, f32, f32); 5] = [
    (Rgb::new(0.8, 0.1, 0.05), 0.5, 1.5, 0.3),
    (Rgb::new(0.2, 0.8, 0.1), 1.0, 1.33, 0.0),
    (GOLD, 0.3, 0.7, 0.8),
    (Rgb::ONE, 0.7, 2.4, 1.0),
    (Rgb::new(0.1, 0.3, 0.9), 0.4, 1.1, 0.5),
];

type Lobe<T> = (&'static str, fn(&mut T, f32));

fn all(p: &mut Principled, x: f32) {
    (p.metallic, p.anisotropic, p.spec_trans, p.eta) = (0.3, 0.5, 0.4, eta_from_specular(0.6));
    (p.spec_tint, p.sheen, p.sheen_tint, p.flatness) = (0.4, 0.3, x, x);
    (p.clearcoat, p.clearcoat_gloss) = (0.6, 0.3);
}

const LOBES: [Lobe<Principled>; 14] = [
    ("base", |p, _| p.eta = 1.5),
    ("flat", |p, x| (p.eta, p.flatness) = (1.5, x)),
    ("metal", |p, x| (p.metallic, p.anisotropic) = (1.0, x)),
    ("some metal", |p, _| {
        (p.eta, p.metallic, p.anisotropic) = (1.5, 0.6, 0.8)
    }),
    ("tint", |p, x| {
        (p.spec_tint, p.eta) = (x, eta_from_specular(0.2 + 0.8 * x))
    }),
    ("sheen", |p, x| (p.eta, p.sheen, p.sheen_tint) = (1.5, 1.0, x)),
    ("coat", |p, x| {
        (p.eta, p.clearcoat, p.clearcoat_gloss) = (1.5, 1.0, 0.5 * x)
    }),
    ("coat on metal", |p, _| {
        (p.metallic, p.clearcoat, p.clearcoat_gloss) = (1.0, 0.5, 0.2)
    }),
    ("glass", |p, _| p.spec_trans = 1.0),
    ("some glass", |p, x| (p.spec_trans, p.anisotropic) = (0.6, x)),
    ("glass and sheen", |p, _| {
        (p.spec_trans, p.sheen, p.sheen_tint) = (1.0, 0.8, 1.0)
    }),
    ("glass and coat", |p, _| {
        (p.spec_trans, p.clearcoat, p.clearcoat_gloss) = (1.0, 1.0, 0.3)
    }),
    ("all", all),
    ("all, other rates", |p, x| {
        all(p, x);
        p.rates = SamplingRates {
            main_specular: 0.5,
            clearcoat: 2.0,
            diffuse_reflectance: 0.3,
        };
    }),
];

fn thin_all(p: &mut PrincipledThin, x: f32) {
    (p.spec_trans, p.diff_trans, p.spec_tint, p.anisotropic) = (0.5, 0.7, 0.6, 0.5 * x);
    (p.sheen, p.sheen_tint, p.flatness) = (0.4, 0.5, x);
}

const THIN_LOBES: [Lobe<PrincipledThin>; 6] = [
    ("thin base", |p, x| (p.flatness, p.sheen) = (x, x)),
    ("thin leaf", |p, x| p.diff_trans = 2.0 * x),
    ("thin glass", |p, x| (p.spec_trans, p.anisotropic) = (1.0, 0.5 * x)),
    ("thin tint", |p, x| (p.spec_trans, p.spec_tint) = (1.0, x)),
    ("thin all", thin_all),
    ("thin all, other rates", |p, x| {
        thin_all(p, x);
        p.rates = ThinSamplingRates {
            specular_reflectance: 0.5,
            specular_transmittance: 2.0,
            diffuse_reflectance: 0.3,
            diffuse_transmittance: 1.5,
        };
    }),
];

/// Each lobe in each setting, by name.
fn combine<T: Copy>(lobes: &[Lobe<T>], plain: impl Fn(Rgb, f32, f32) -> T) -> Vec<(String, T)> {
    let mut cases = Vec::new();
    for (number, &(base_color, roughness, eta, x)) in SETTINGS.iter().enumerate() {
        for (name, set) in lobes {
            let mut case = plain(base_color, roughness, eta);
            set(&mut case, x);
            cases.push((format!("{name} {number}"), case));
        }
    }
    cases
}

pub fn principled_cases() -> Vec<(String, Principled)> {
    let mut cases = combine(&LOBES, |base_color, roughness, eta| Principled {
        base_color,
        roughness,
        eta,
        ..PRINCIPLED
    });
    // Lobes about as narrow as they get.
    let sharp: [Lobe<Principled>; 3] = [
        ("sharp metal", |p, _| (p.metallic, p.anisotropic) = (1.0, 0.5)),
        ("sharp glass", |p, _| p.spec_trans = 1.0),
        ("sharp coat", |p, _| (p.clearcoat, p.clearcoat_gloss) = (1.0, 1.0)),
    ];
    for (name, set) in sharp {
        let mut case = Principled {
            roughness: 0.15,
            ..PRINCIPLED
        };
        set(&mut case, 1.0);
        cases.push((name.to_owned(), case));
    }
    cases
}

pub fn thin_cases() -> Vec<(String, PrincipledThin)> {
    combine(&THIN_LOBES, |base_color, roughness, eta| PrincipledThin {
        base_color,
        roughness,
        eta,
        ..THIN
    })
}
