//! Random edits of the scene, as lines of a script. The property tests of undo and redo use them as well.

use std::path::Path;

use bevy::ecs::query::QueryFilter;
use bevy::prelude::*;

use super::random::Random;
use crate::app::editor::command::uv_projection::ProjectedFrom;
use crate::scene::{Emitter, Material, Medium, Shape};

/// A scene with every kind of thing that [`random_edit`] may import.
pub const PART: &str = "<scene version='3.0.0'><bsdf type='plastic' id='part-plastic'/>
    <shape type='cube' id='part-cube'><ref id='part-plastic'/></shape>
    <emitter type='point' id='part-light'/></scene>";

/// The number of things above which edits delete some. It is small enough to be quick, and large enough for several of
/// each kind.
const MOST_THINGS: usize = 60;

/// Verbs that set the units in which the scene is shown.
const UNITS: [&str; 6] = [
    "unit-none",
    "unit-m",
    "unit-cm",
    "unit-ft",
    "light-units-radiometric",
    "light-units-photometric",
];

/// The sorted names of all things that pass the filter.
pub fn names<F: QueryFilter>(world: &mut World) -> Vec<String> {
    let mut names: Vec<String> = world
        .query_filtered::<&Name, F>()
        .iter(world)
        .map(|name| name.to_string())
        .collect();
    names.sort();
    names
}

/// A random edit as lines of a script, the last of which is the edit itself. None if the scene has nothing that it
/// applies to. `part` is a scene file to import.
pub fn random_edit(world: &mut World, random: &mut Random, part: &Path) -> Option<Vec<String>> {
    let shapes = names::<With<Shape>>(world);
    let materials = names::<With<Material>>(world);
    let lights = names::<With<Emitter>>(world);
    let media = names::<With<Medium>>(world);
    let all: Vec<String> = [&shapes[..], &materials, &lights, &media].concat();
    if all.len() > MOST_THINGS {
        let victims: Vec<String> = (0..3).filter_map(|_| random.one_of(&all).cloned()).collect();
        return Some(vec![format!("select {}", victims.join(" ")), "delete".to_owned()]);
    }
    let shape = random.one_of(&shapes).cloned();
    let material = random.one_of(&materials).cloned();
    let anything = random.one_of(&all).cloned();
    let random_light = random.one_of(&lights).cloned();
    let kinds = [
        "sphere",
        "rectangle",
        "cube",
        "disk",
        "cylinder",
        "wall",
        "stairs",
        "prism",
        "gableroof",
        "hiproof",
        "shedroof",
        "area",
        "point",
        "spot",
        "constant",
        "directional",
        "markerpoint",
        "markerbox",
        "markersphere",
        "markerpath",
    ];
    let one = |line: String| Some(vec![line]);
    match random.below(48) {
        0..3 => one(format!(
            "add {} at={} size=0.5",
            kinds[random.below(kinds.len())],
            random.vector()
        )),
        3 => one(format!("move {} {}", shape?, random.vector())),
        4 => one(format!("rotate {} 0,1,0.5 {}", shape?, random.number())),
        5 => one(format!("set {} position {}", random.one_of(&lights)?, random.vector())),
        6 => one(format!("material-of {}", shape?)),
        7 => one(format!("make {} {}", material?, Material::PLUGINS[random.below(6)])),
        8 => one(format!("set {} alpha 0.{}", material?, 1 + random.below(9))),
        9 => one(format!("assign {} {}", material?, shape?)),
        10 => one(format!("emit {} {}", shape?, 1 + random.below(20))),
        11 => one(format!("emit {} none", shape?)),
        12 => one(format!("rename {} thing-{}", anything?, random.below(200))),
        13 => Some(vec![
            format!("select {} {}", shape?, random.one_of(&shapes)?),
            "duplicate".to_owned(),
        ]),
        14 => Some(vec![format!("select {}", anything?), "delete".to_owned()]),
        15 => match random.below(4) {
            0 => Some(vec![format!("select {}", shape?), "hide-others".to_owned()]),
            1 => one("show-all".to_owned()),
            2 => one(format!("hide-thing {}", shape?)),
            _ => Some(vec![
                format!("select {} {}", shape?, random.one_of(&shapes)?),
                "group".to_owned(),
            ]),
        },
        16 => one(format!("put-before {} {}", anything?, random.one_of(&all)?)),
        17 => one(format!("lock {} {}", ["on", "off"][random.below(2)], anything?)),
        18 => one(format!(
            "put-into {} {} {}",
            ["shelf", "shelf/upper", "none"][random.below(3)],
            anything?,
            random.one_of(&all)?
        )),
        19 => Some(vec![
            "mix none".to_owned(),
            format!("mix {} 0.{}", random.one_of(&lights)?, 1 + random.below(9)),
            "bake-lights".to_owned(),
        ]),
        20 => one(UNITS[random.below(UNITS.len())].to_owned()),
        21 => one(format!("use-file {} {},0.5", part.display(), random.fraction())),
        22 => Some(vec![
            format!("select {} {}", shape?, random.one_of(&shapes)?),
            format!(
                "align {} {}",
                ["x", "y", "z"][random.below(3)],
                ["low", "middle", "high"][random.below(3)]
            ),
        ]),
        23 => Some(vec![
            format!("select {} {} {}", shape?, random.one_of(&shapes)?, random.one_of(&all)?),
            format!(
                "distribute {} {}",
                ["x", "y", "z"][random.below(3)],
                ["gaps", "middles"][random.below(2)]
            ),
        ]),
        24 => Some(vec![
            format!("select {}", shape?),
            match random.below(3) {
                0 => format!("series 3 along {}", random.vector()),
                1 => "series 4 around y 360 0,0,0".to_owned(),
                _ => format!("series 2 along {} instances", random.vector()),
            },
        ]),
        25 => one(format!(
            "draw {} {} {} height=1.5",
            ["box", "floor", "wall"][random.below(3)],
            random.vector(),
            random.vector()
        )),
        26 => one(format!(
            "push {} {} 0.{}",
            shape?,
            ["+x", "-y", "+z"][random.below(3)],
            1 + random.below(9)
        )),
        27 => one(format!(
            "cut {} {} 0.5",
            ["door", "window", "french-window", "hole"][random.below(4)],
            shape?
        )),
        30 => one(format!(
            "wrap {} {}",
            material?,
            ["twosided", "blendbsdf", "mask", "bumpmap", "normalmap"][random.below(5)]
        )),
        31 => one(format!("unwrap {}", material?)),
        32 => one(format!("key {}", anything?)),
        33 => one(format!(
            "{} {}",
            ["key", "unkey", "stand-still"][random.below(3)],
            [format!("{} radius", shape?), format!("{} alpha", material?)][random.below(2)]
        )),
        34 => one(format!(
            "interpolate {} to_world {}",
            shape?,
            ["linear", "ease", "step"][random.below(3)]
        )),
        44..48 => property_edit(random, anything?, random_light, shape),
        36..=40 => media_edit(random, &media, shape, random_light),
        35 => one(format!("move-key {} to_world 0 {}", shape?, random.below(3))),
        29 => one(format!(
            "project-texture {} 0.{} {}",
            ProjectedFrom::ALL[random.below(ProjectedFrom::ALL.len())].name(),
            1 + random.below(9),
            shape?
        )),
        28 => one(format!(
            "place-texture {} offset=0.{},0 rotation={} repeats={},2",
            shape?,
            random.below(10),
            random.below(90),
            1 + random.below(5)
        )),
        42 => Some(vec![
            format!("select {} {}", shape?, random.one_of(&shapes)?),
            format!("resize {} 0.{}", ["x", "y", "z"][random.below(3)], 1 + random.below(9)),
        ]),
        43 => Some(vec![
            format!("select {} {}", shape?, random.one_of(&shapes)?),
            match random.below(2) {
                0 => format!("replace {}", random.one_of(&shapes)?),
                _ => format!("cover {}", ["gableroof", "hiproof", "shedroof"][random.below(3)]),
            },
        ]),
        _ => one(format!(
            "paste <shape type=\"sphere\" id=\"pasted\"><float name=\"radius\" value=\"{}\"/><bsdf type=\"twosided\"><bsdf type=\"diffuse\"/></bsdf></shape>",
            1 + random.below(5)
        )),
    }
}

/// One edit of properties.
fn property_edit(
    random: &mut Random,
    thing: String,
    light: Option<String>,
    shape: Option<String>,
) -> Option<Vec<String>> {
    let name = ["health", "spawn point", "game::Door", "next"][random.below(4)];
    let value = match random.below(8) {
        0 => "boolean true".to_owned(),
        1 => format!("integer {}", random.below(100)),
        2 => format!("number 0.{}", random.below(100)),
        3 => format!("text list a\\; b; {}", random.below(9)),
        4 => format!("vector {}", random.vector()),
        5 => format!("reference {}", shape?),
        6 => "component {\"locked\": true}".to_owned(),
        _ => format!("color list {}", random.vector()),
    };
    Some(vec![match random.below(6) {
        0 => format!("property {thing} \"{name}\" none"),
        1 => format!("scene-property \"{name}\" {value}"),
        2 => format!("property {} \"{name}\" {value}", light?),
        _ => format!("property {thing} \"{name}\" {value}"),
    }])
}

/// One edit about media.
fn media_edit(
    random: &mut Random,
    media: &[String],
    shape: Option<String>,
    light: Option<String>,
) -> Option<Vec<String>> {
    let medium = random.one_of(media).cloned();
    let one = |line: String| Some(vec![line]);
    match random.below(14) {
        0 => one("add fog".to_owned()),
        1 => one(format!("add fog-box at={} size=0.5", random.vector())),
        2 | 3 => one(format!("fill {} {}", ["fog", "smoke"][random.below(2)], shape?)),
        4 => one(format!("fill {} {}", medium?, shape?)),
        5 => one(format!(
            "medium {} {} {}",
            medium?,
            ["interior", "exterior"][random.below(2)],
            shape?
        )),
        6 => one(format!(
            "medium none {} {}",
            ["interior", "exterior"][random.below(2)],
            shape?
        )),
        7 => one(format!("medium {} around {}", medium?, light?)),
        8 => one(format!("medium-of {}", shape?)),
        9 => one(format!("set {} albedo 0.{},0.5,0.9", medium?, random.below(10))),
        10 => one(format!("set {} mean_free_path {}cm", medium?, 1 + random.below(500))),
        11 => one(format!(
            "set {} {}",
            medium?,
            [
                "phase hg",
                "phase rayleigh",
                "phase tabphase",
                "g 0.6",
                "emission 1,0.4,0.1",
                "scale 3"
            ][random.below(6)]
        )),
        12 => Some(vec![format!("select {}", medium?), "duplicate".to_owned()]),
        // Smoke with a place of its own.
        _ => one(format!(
            "paste <shape type=\"cube\" id=\"smoke\"><bsdf type=\"null\"/><medium type=\"heterogeneous\" name=\"interior\">\
             <volume type=\"constvolume\" name=\"sigma_t\"><float name=\"value\" value=\"{}\"/>\
             <transform name=\"to_world\"><scale value=\"2\"/><translate value=\"-1, -1, -1\"/></transform></volume></medium></shape>",
            1 + random.below(5)
        )),
    }
}
