//! Hair against the contract of `shading`, the laws of its parts, and figures of another renderer.

use crate::bsdf_support::{
    Single, assert_figure, assert_finite, assert_mean_weight, assert_weights, density_p_values, direction, furnace,
    mirror,
};
use crate::statistics::{assert_all_plausible, sphere_integral};
use glam::Vec3;
use sunroom::color::Rgb;
use sunroom::shading::{Bsdf, Fiber, Hair, ior, melanin_absorption};

fn hair(eta: f32, [along, around]: [f32; 2], tilt_degrees: f32, sigma_a: Rgb) -> Bsdf {
    Bsdf::Hair(Hair {
        fiber: Fiber::new(eta, along, around, tilt_degrees.to_radians()),
        sigma_a,
    })
}

fn keratin() -> f32 {
    let [inside, outside] = ["amber", "air"].map(|name| ior::dielectric_ior(name).expect("a known material"));
    inside / outside
}

fn cases() -> Vec<Single> {
    let dye = Rgb::new(0.4, 0.5, 1.4);
    [
        ("brown", hair(keratin(), [0.3, 0.3], 2.0, melanin_absorption(1.3, 0.2))),
        ("blond", hair(keratin(), [0.2, 0.15], 3.5, melanin_absorption(0.2, 0.4))),
        ("dyed", hair(1.33, [0.6, 0.9], -5.0, dye)),
        ("rough", hair(keratin(), [1.0, 1.0], 2.0, melanin_absorption(0.1, 0.0))),
        ("bubble", hair(1.0 / 1.4, [0.3, 0.3], 2.0, melanin_absorption(0.3, 0.1))),
        ("silky", hair(keratin(), [0.05, 0.1], 2.0, dye)),
        ("white", hair(1.55, [0.3, 0.3], 0.0, Rgb::ZERO)),
        ("white bubble", hair(0.7, [0.2, 0.5], 3.0, Rgb::ZERO)),
        ("black", hair(1.55, [0.25, 0.4], 2.0, Rgb::splat(1e4))),
        ("unrefracted", hair(1.0, [0.4, 0.2], 2.0, dye)),
    ]
    .map(|(name, bsdf)| Single::new(name, bsdf))
    .into()
}

/// Off the axis of the fibre and along it, overhead and grazing.
fn viewers() -> Vec<Vec3> {
    [(0.0, 0.0), (30.0, 1.0), (60.0, 4.0), (85.0, 2.5), (80.0, 1.5)]
        .map(|(theta, phi)| direction(theta, phi))
        .to_vec()
}

#[test]
fn samples_follow_the_density() {
    let results: Vec<_> = cases()
        .iter()
        .flat_map(|case| density_p_values(case, &viewers()))
        .collect();
    assert_all_plausible(&results);
}

#[test]
fn weights_are_value_over_density() {
    for case in cases() {
        // Rounding, relative to the width of a lobe.
        let tolerance = if case.name == "silky" { 5e-4 } else { 1e-4 };
        assert_weights(&case, &viewers(), tolerance);
    }
}

#[test]
fn mean_weight_is_the_integral_of_the_value() {
    for case in cases() {
        assert_mean_weight(&case, &viewers());
    }
}

#[test]
fn no_energy_is_made_and_white_hair_loses_none() {
    for case in cases() {
        for wo in viewers() {
            if case.name.contains("white") {
                let total = sphere_integral(mirror(wo), |wi| case.eval(wo, wi).x);
                assert!((total - 1.0).abs() < 1e-3, "{} {wo}: {total}", case.name);
                for sample in (0..500).filter_map(|i| case.sample(wo, i)) {
                    assert!(
                        (sample.weight - Rgb::ONE).abs().max_element() < 1e-5,
                        "{} {wo}",
                        case.name
                    );
                }
            } else {
                // Colours are not the luminance that lobes are chosen by: three standard errors of at most 0.6 /
                // sqrt(count) each.
                let total = furnace(&case, wo, 20_000);
                assert!(total.max_element() < 1.0 + 0.013, "{} {wo}: {total}", case.name);
            }
        }
    }
}

/// Without scales, in the cross-section: light is mirrored off the side that the viewer sees, or comes from behind,
/// through the fibre.
#[test]
fn lobes_lie_where_rays_leave_the_fiber() {
    let (eta, degrees) = (1.55f32, 40.0f32);
    let wo = direction(degrees, 0.0);
    let inside = (degrees.to_radians().sin() / eta).asin().to_degrees();
    let around = |degrees: f32| direction(degrees, 0.0);
    // The fibre turns a ray by its two refractions, and each reflection inside turns it by 180 - 2 inside.
    let crossed = 180.0 + degrees - 2.0 * (degrees - inside);
    for (peak, absorbed) in [(-degrees, 1e4), (crossed, 0.0)] {
        let narrow = Single::new("", hair(eta, [0.1, 0.05], 0.0, Rgb::splat(absorbed)));
        let [before, at, after] = [-3.0, 0.0, 3.0].map(|off| narrow.eval(wo, around(peak + off)).x);
        assert!(at > 1.2 * before && at > 1.2 * after, "{peak}: {before} {at} {after}");
    }
}

#[test]
fn scales_tilt_the_highlight_and_pigments_color_only_what_crosses() {
    let wo = direction(0.0, 0.0);
    let black = Single::new("", hair(1.55, [0.1, 0.3], 3.0, Rgb::splat(1e4)));
    let inclined = |degrees: f32| black.eval(wo, direction(degrees, std::f32::consts::FRAC_PI_2)).x;
    // The mirror on scales that rise by 3 degrees turns light by 6.
    assert!(
        inclined(6.0) > inclined(4.0) && inclined(6.0) > inclined(8.0),
        "highlight"
    );
    let brown = &cases()[0];
    let (mirrored, through) = (brown.eval(wo, wo), brown.eval(wo, -wo));
    assert!(
        mirrored.z > 0.95 * mirrored.x && through.z < 0.2 * through.x,
        "{mirrored} {through}"
    );
}

/// From within the fibre: all that it does to light is done where the light enters.
#[test]
fn light_leaves_the_fiber_unhindered() {
    let (above, below) = (direction(40.0, 1.0), direction(130.0, 2.0));
    for case in cases() {
        let sample = case.sample(below, 0).expect("nothing is absorbed");
        assert_eq!((sample.wi, sample.weight, sample.is_delta), (-below, Rgb::ONE, true));
        assert_eq!((case.eval(below, above), case.pdf(below, above)), (Rgb::ZERO, 0.0));
        assert_eq!(case.bsdf.transmittance(below), Rgb::ONE);
        assert_eq!(case.bsdf.transmittance(above), Rgb::ZERO);
        assert!(case.bsdf.has_null_lobe() && case.bsdf.has_smooth_lobe() && !case.bsdf.is_isotropic());
    }
}

/// The attenuation is that of the viewer's side alone, so light does not take the way back alike.
#[test]
fn value_is_not_reciprocal() {
    let brown = &cases()[0];
    let (a, b) = (direction(20.0, 0.3), direction(60.0, 2.8));
    let (forth, back) = (brown.eval(a, b) / b.z, brown.eval(b, a) / a.z);
    assert!(
        (forth - back).abs().max_element() > 0.05 * forth.max_element(),
        "{forth} {back}"
    );
}

#[test]
fn grazing_and_extreme_input_gives_numbers() {
    let odd = [
        hair(1.55, [0.0, 0.0], 2.0, Rgb::ZERO),
        hair(1.55, [7.0, 1.0], 90.0, Rgb::splat(f32::MAX)),
        hair(1.0, [0.3, 0.3], 0.0, Rgb::splat(f32::MAX)),
        hair(1e-3, [0.3, 0.0], -45.0, Rgb::ONE),
        hair(1e3, [0.0, 1.0], 2.0, Rgb::new(0.0, f32::MIN_POSITIVE, 1.0)),
    ];
    let odd = odd.map(|bsdf| Single::new(&format!("{bsdf:?}"), bsdf));
    cases().iter().chain(&odd).for_each(assert_finite);
    for case in cases().iter().chain(&odd) {
        let along = [Vec3::Y, Vec3::NEG_Y, Vec3::X, Vec3::NEG_X];
        let samples = along
            .iter()
            .flat_map(|&wo| (0..50).filter_map(move |i| case.sample(wo, i)));
        assert!(samples.count() > 0, "{} absorbs everything", case.name);
    }
}

#[test]
fn albedo_is_that_of_many_fibers() {
    // The paper's fit, section 4.2, the other way round.
    let colors: Vec<Rgb> = cases().iter().map(|case| case.bsdf.albedo()).collect();
    assert!(
        colors
            .iter()
            .all(|color| color.min_element() >= 0.0 && color.max_element() <= 1.0)
    );
    let sigma_a = (Rgb::new(0.8, 0.5, 0.2).map(f32::ln) / 5.88841).powf(2.0);
    let color = hair(1.55, [0.3, 0.3], 2.0, sigma_a).albedo();
    assert!((color - Rgb::new(0.8, 0.5, 0.2)).abs().max_element() < 1e-3, "{color}");
}

/// Of Mitsuba 3.9.1, variant `scalar_rgb`: the name of a case, viewer and light (as x y z), value (as r g b), density.
const FIGURES: &str = "\
brown: 0.42041171 -0.80189615 0.42451918 0.11023749 0.64942116 -0.75239611 0.767787 0.313535 0.0337955 1.64628
brown: 0.73701912 -0.25125754 0.62743324 0.29966486 0.42109075 -0.85608619 0.0425626 0.0207625 0.0034851 0.0982596
brown: -0.88662577 -0.27425319 0.37239754 0.45154211 0.17747055 -0.87442207 0.168978 0.086598 0.0164418 0.305978
brown: -0.41442439 -0.88647246 0.20595871 0.49712616 0.8109628 0.30855292 1.41325 1.41303 1.41301 3.55327
brown: 0.60225403 -0.60121435 0.52519649 -0.20979007 0.86336988 0.45889059 0.0236942 0.023662 0.0236587 0.100838
blond: -0.98600727 0.068486348 0.15198453 -0.19080636 -0.33804309 -0.9215855 0.0318841 0.0235993 0.0116449 0.0338152
blond: -0.57787418 -0.28546944 0.76457089 0.16152672 0.14820106 -0.97567701 10.4938 8.05017 3.82969 13.9065
blond: 0.78864163 -0.23937833 0.56634122 -0.92020386 -0.08985249 0.38098732 0.00100902 0.000853255 0.00073048 0.00141039
blond: -0.35176846 -0.70344734 0.61759275 0.037277706 0.66830063 -0.7429567 15.0553 11.0907 4.70956 20.6293
blond: -0.74065262 0.54541039 0.3923789 -0.40498552 -0.45525309 -0.79292583 0.00166912 0.000812228 0.000146136 0.00152661
dyed: 0.91002864 0.4098452 0.06224782 0.42556947 0.69254249 -0.58247364 0.016485 0.0154759 0.0131118 0.020631
dyed: 0.88955957 0.30503651 0.34005365 -0.57232678 0.53838098 0.61853701 0.0170253 0.0157755 0.0108427 0.0309301
dyed: -0.36592087 -0.31881785 0.87433237 -0.010089947 0.71121806 -0.70289904 0.0921755 0.0757545 0.0134203 0.198806
dyed: -0.61642021 0.70664465 0.34738955 -0.087300703 -0.95869613 -0.27070338 0.0814732 0.0693538 0.0245077 0.162666
dyed: 0.79790246 0.59663677 0.08588466 -0.087882362 0.94510466 -0.31472832 0.0106628 0.00996402 0.00859682 0.0145814
rough: 0.29549325 0.47506052 0.8288554 0.28628114 -0.091062322 -0.95380855 0.0759302 0.0717413 0.0626116 0.0827227
rough: 0.51362807 0.67611414 0.52825737 0.085736312 -0.54901773 -0.83140177 0.0789658 0.0746407 0.0652774 0.0860319
rough: -0.050093137 0.71610105 0.69619679 0.47993362 0.83581573 -0.26660043 0.068187 0.064108 0.0553283 0.0748992
rough: -0.62241495 -0.12927283 0.77193791 -0.58157009 0.80309719 0.12965788 0.0739448 0.0702962 0.0622651 0.079826
rough: 0.18032399 -0.49041551 0.85262883 -0.049034283 -0.76957923 0.63666588 0.0649674 0.0613433 0.0534722 0.0708992
bubble: -0.27579483 0.094953209 0.95651507 0.48447803 -0.036481652 0.87404239 0.0370477 0.03703 0.0370128 0.0574713
bubble: -0.19563808 0.22293393 0.95500064 0.1706682 -0.42484692 -0.88903183 1.12379 0.909958 0.531324 1.49268
bubble: -0.30437791 0.53349727 0.78913546 0.78612971 -0.14149489 0.60164714 0.0040009 0.0039177 0.00385218 0.00666026
bubble: 0.14798324 -0.39917871 0.90485209 0.33264178 0.29072973 -0.89712089 0.0367868 0.028795 0.0154318 0.0509853
bubble: -0.39720407 -0.0041154209 0.91772109 -0.9871071 -0.14686145 0.063649923 0.00241436 0.0016992 0.000695495 0.00263878";

#[test]
fn figures_of_another_renderer() {
    let cases = cases();
    for line in FIGURES.lines() {
        let (name, figures) = line.split_once(": ").expect("a name before the figures");
        let case = cases
            .iter()
            .find(|case| case.name == name)
            .expect("a case of this name");
        let numbers: Vec<f32> = figures.split(' ').map(|n| n.parse().expect("a number")).collect();
        let [wo, wi, value] = [0, 3, 6].map(|at| Vec3::from_slice(&numbers[at..]));
        // In narrow lobes that renderer approximates I0: ten terms of its series below 12, and 1 / (16 x) for 1 / (8 x)
        // above.
        let is_wide = ["dyed", "rough"].contains(&name);
        let tolerance = if is_wide { 2e-5 } else { 6e-3 };
        assert_figure(case, (wo, wi, value, numbers[9]), tolerance, tolerance);
    }
}
