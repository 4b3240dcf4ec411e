//! Layers of light: they come from the paths of the whole, and are what each lamp gives by itself.

use std::sync::atomic::AtomicBool;

use glam::{UVec2, Vec2, Vec3};
use sunroom::bake::cube::windows;
use sunroom::bake::lightmap::Lightmaps;
use sunroom::bake::texels::Texels;
use sunroom::color::{Rgb, luminance};
use sunroom::render::gathering::{Gathering, Site};
use sunroom::render::irradiance::ReceivedLight;
use sunroom::render::light_layers::LightGroups;
use sunroom::render::scene::RenderScene;
use sunroom::render::view::{Strategy, View};

use super::{corner, corner_lit_by, covered, gathering, patch, settings};

/// The floor of the corner.
fn floor() -> Texels {
    let floor = patch(Vec3::ZERO, Vec3::Y, 1.0, 24.0, Vec2::splat(2.0));
    covered(&[floor], UVec2::splat(28), 1)
}

/// Settings with a group for the lamp and one for the bulb.
fn grouped(strategy: Strategy) -> View {
    View {
        light_groups: LightGroups::new(&[0, 1]),
        ..settings(strategy)
    }
}

fn gather<S: Site>(gathering: &Gathering, texels: &Texels<S>, layers: usize, samples: u32) -> Lightmaps {
    let mut light = Lightmaps::new(texels.texels.len()).with_layers(layers);
    assert!(light.add(gathering, texels, samples, &AtomicBool::new(false)));
    light
}

/// Checks that layers do not change the whole, and sum up to it but for roundings.
#[track_caller]
fn assert_sums<S: Site>(gathering: &Gathering, alone: &Gathering, texels: &Texels<S>) {
    let (light, whole) = (gather(gathering, texels, 2, 16), gather(alone, texels, 0, 16));
    let mut lit = [false; 2];
    for texel in 0..light.texel_count() {
        assert_eq!(light.sum(texel), whole.sum(texel));
        let layers = [0, 1].map(|layer| light.layer(texel, layer));
        let error = (layers[0] + layers[1] - light.light(texel)).abs().max_element();
        assert!(error <= 1e-5 * light.light(texel).max_element(), "{texel}: {layers:?}");
        lit = [0, 1].map(|layer| lit[layer] || layers[layer] != Rgb::ZERO);
    }
    assert_eq!(lit, [true, true]);
}

#[test]
fn layers_sum_up_to_a_whole_with_the_bits_of_a_bake_without_them() {
    let scene = corner();
    for strategy in [Strategy::Mis, Strategy::Light, Strategy::Bsdf] {
        let (view, alone) = (grouped(strategy), settings(strategy));
        assert_sums(&gathering(&scene, &view), &gathering(&scene, &alone), &floor());
        let outlook = windows(Vec3::new(0.1, 0.4, 0.2), &glam::Mat3A::IDENTITY, 16);
        assert_sums(&gathering(&scene, &view), &gathering(&scene, &alone), &outlook);
    }
}

#[test]
fn the_direct_light_of_a_bulb_is_in_no_layer_of_indirect_light() {
    let (scene, view) = (corner(), grouped(Strategy::Mis));
    let without = Gathering {
        light: ReceivedLight::WithoutPunctual,
        ..gathering(&scene, &view)
    };
    let mean = |light: &Lightmaps| -> f32 {
        let texels = 0..light.texel_count();
        texels.map(|texel| luminance(light.layer(texel, 1))).sum::<f32>() / light.texel_count() as f32
    };
    let [all, indirect] = [&gathering(&scene, &view), &without].map(|light| mean(&gather(light, &floor(), 2, 16)));
    assert!(indirect > 0.0 && indirect < 0.5 * all, "{indirect} of {all}");
}

#[test]
fn threads_shares_and_interruptions_change_no_bit_of_layers() {
    let (scene, texels, view) = (corner(), floor(), grouped(Strategy::Mis));
    let gathering = gathering(&scene, &view);
    let never = AtomicBool::new(false);
    let whole = gather(&gathering, &texels, 2, 50);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("threads");
    assert!(pool.install(|| gather(&gathering, &texels, 2, 50)) == whole);
    let empty = || Lightmaps::new(texels.texels.len()).with_layers(2);
    let mut piecewise = empty();
    while piecewise.reached() < 50 {
        let end = piecewise.round_end(50);
        piecewise.go_on(&gathering, &texels, end, 1, &never);
    }
    assert!(piecewise == whole);
    let mut merged = empty();
    for range in [0..16, 16..48, 48..50] {
        let mut share = Lightmaps::beginning_at(range.start, texels.texels.len()).with_layers(2);
        assert!(share.add(&gathering, &texels, range.end - range.start, &never));
        assert!(merged.append(share));
    }
    assert!(merged == whole);
    assert!(!merged.append(Lightmaps::beginning_at(50, texels.texels.len())));
}

/// The mean over the floor of what `light` gives, and its standard error, by twelve seeds from `first` on.
fn estimate(scene: &RenderScene, view: &View, first: u32, light: impl Fn(&Lightmaps, usize) -> Rgb) -> [f64; 2] {
    let texels = floor();
    let mean = |seed: u32| {
        let view = View { seed, ..view.clone() };
        let found = gather(&gathering(scene, &view), &texels, view.light_groups.count(), 8);
        let sum: f64 = (0..found.texel_count())
            .map(|texel| f64::from(luminance(light(&found, texel))))
            .sum();
        sum / found.texel_count() as f64
    };
    let means: Vec<f64> = (first..first + 12).map(mean).collect();
    let count = means.len() as f64;
    let mean = means.iter().sum::<f64>() / count;
    let variance = means.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / (count - 1.0);
    [mean, (variance / count).sqrt()]
}

#[test]
fn a_layer_is_what_a_lamp_gives_while_all_others_are_off() {
    let z = |[one, error]: [f64; 2], [other, other_error]: [f64; 2]| (one - other) / error.hypot(other_error);
    let (full, view) = (corner(), grouped(Strategy::Mis));
    let alone = |lit| estimate(&corner_lit_by(lit), &settings(Strategy::Mis), 1000, Lightmaps::light);
    let layer = |layer| {
        estimate(&full, &view, 1, move |light: &Lightmaps, texel| {
            light.layer(texel, layer)
        })
    };
    let without = |layer| {
        estimate(&full, &view, 2000, move |light: &Lightmaps, texel| {
            light.light(texel) - light.layer(texel, layer)
        })
    };
    let [lamp, bulb] = [alone([true, false]), alone([false, true])];
    for (found, expected) in [
        (layer(0), lamp),
        (layer(1), bulb),
        (without(0), bulb),
        (without(1), lamp),
    ] {
        let z = z(found, expected);
        assert!(z.abs() < 4.0, "{found:?} for {expected:?}: z = {z}");
    }
    let z = z(lamp, bulb);
    assert!(
        z.abs() > 20.0,
        "the test tells lamps apart: {lamp:?} and {bulb:?}, z = {z}"
    );
}
