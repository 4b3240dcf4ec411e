//! `sunroom bake --layers`: the light of each lamp by itself.

use std::path::Path;

use serde_json::Value;
use sunroom::texture::load_image;

use super::bake_shares::{bake, files, merge, said, same, shop_of};
use crate::workshop::Workshop;

/// A room without a ceiling, with a bulb, a lamp that is a shape, a sky, a sun, and a bulb below the floor that lights
/// nothing.
const SCENE: &str = r#"<scene version="3.0.0">
  <integrator type="path"><integer name="max_depth" value="4"/></integrator>
  <sensor type="perspective">
    <transform name="to_world"><lookat origin="0, 2, 5" target="0, 0.5, 0" up="0, 1, 0"/></transform>
  </sensor>
  <shape type="rectangle" id="room/floor">
    <transform name="to_world"><scale value="4"/><rotate x="1" angle="-90"/></transform>
    <bsdf type="diffuse"><rgb name="reflectance" value="0.8, 0.6, 0.4"/></bsdf>
  </shape>
  <shape type="cube" id="room/block">
    <transform name="to_world"><scale value="0.5"/><translate x="1" y="0.51"/></transform>
    <bsdf type="diffuse"><rgb name="reflectance" value="0.5, 0.5, 0.8"/></bsdf>
  </shape>
  <shape type="sphere" id="room/globe">
    <point name="center" x="-1" y="1.2" z="-1"/><float name="radius" value="0.2"/>
    <bsdf type="diffuse"/>
    <emitter type="area"><rgb name="radiance" value="3, 2, 1"/></emitter>
  </shape>
  <emitter type="point" id="bulb"><point name="position" x="-1" y="2" z="1"/><rgb name="intensity" value="3, 3, 3"/></emitter>
  <emitter type="point" id="cellar"><point name="position" x="0" y="-2" z="0"/><rgb name="intensity" value="3, 3, 3"/></emitter>
  <emitter type="directional" id="sun"><vector name="direction" x="0.3" y="-1" z="0.2"/><rgb name="irradiance" value="1, 1, 0.8"/></emitter>
  <emitter type="constant" id="sky"><rgb name="radiance" value="0.5, 0.6, 0.7"/></emitter>
</scene>
"#;

fn shop() -> Workshop {
    shop_of(SCENE)
}

fn manifest(folder: &Path) -> Value {
    let text = std::fs::read_to_string(folder.join("lightmaps.json")).expect("the manifest");
    serde_json::from_str(&text).expect("JSON")
}

/// The numbers of an EXR file.
fn pixels(file: &Path) -> Vec<f32> {
    let image = load_image(&std::fs::read(file).expect("the lightmap")).expect("a picture");
    let places = (0..image.height()).flat_map(|y| (0..image.width()).map(move |x| (x, y)));
    places.flat_map(|(x, y)| image.pixel(x, y).to_array()).collect()
}

/// The names of the files of a layer's lightmaps, and of its probes and volumes.
fn textures(layer: &Value) -> Vec<String> {
    let lists = ["lightmaps", "reflection_probes", "irradiance_volumes"];
    let files = lists.iter().flat_map(|list| layer[list].as_array().expect("a list"));
    let names = files.flat_map(|files| ["exr", "ktx2", "specular", "diffuse"].map(|kind| files[kind].as_str()));
    names.flatten().map(str::to_owned).collect()
}

/// Checks that the layers of each lightmap sum up to it, bit by bit.
#[track_caller]
fn assert_sums(folder: &Path) {
    let about = manifest(folder);
    for (number, lightmap) in about["lightmaps"].as_array().expect("lightmaps").iter().enumerate() {
        let whole = pixels(&folder.join(lightmap["exr"].as_str().expect("a name")));
        let mut sum = vec![0.0; whole.len()];
        let layers = about["layers"].as_array().expect("layers").iter();
        let own = layers.flat_map(|layer| layer["lightmaps"].as_array().expect("a list"));
        for files in own.filter(|files| files["lightmap"] == number) {
            let layer = pixels(&folder.join(files["exr"].as_str().expect("a name")));
            sum.iter_mut().zip(&layer).for_each(|(sum, more)| *sum += more);
        }
        assert!(whole.iter().any(|value| *value > 0.0));
        let bits = |values: &[f32]| values.iter().map(|value| value.to_bits()).collect::<Vec<_>>();
        assert!(bits(&sum) == bits(&whole), "lightmap {number}");
    }
}

#[test]
fn layers_sum_up_to_the_lightmap_and_name_their_lamps() {
    let shop = shop();
    let denoise: &[&str] = if cfg!(feature = "denoise") {
        &[]
    } else {
        &["--no-denoise"]
    };
    said(
        &bake(&shop, "level", &[&["--spp", "16", "--layers"], denoise].concat()),
        0,
    );
    let folder = shop.path("level");
    assert_sums(&folder);
    let about = manifest(&folder);
    let layers = about["layers"].as_array().expect("layers");
    let of = |layer: &Value, key: &str| layer[key].as_str().expect("a text").to_owned();
    let kinds: Vec<(String, String)> = layers
        .iter()
        .map(|layer| (of(layer, "name"), of(layer, "kind")))
        .collect();
    for (name, kind) in [
        ("bulb", "lamp"),
        ("cellar", "lamp"),
        ("sun", "sun"),
        ("sky", "sky"),
        ("room/globe", "lamp"),
    ] {
        assert!(kinds.contains(&(name.to_owned(), kind.to_owned())), "{kinds:?}");
    }
    assert_eq!(kinds.len(), 5, "there is no rest: {kinds:?}");
    let found = |name: &str| layers.iter().find(|layer| layer["name"] == name).expect("a layer");
    assert!(textures(found("cellar")).is_empty(), "no light arrives");
    let bulb = textures(found("bulb"));
    assert!(bulb.iter().any(|name| name.starts_with("irradiance-0")), "{bulb:?}");
    assert!(bulb.iter().any(|name| name.starts_with("reflection-0")), "{bulb:?}");
    let sums = about["crc32"].as_object().expect("checksums");
    assert!(layers.iter().flat_map(textures).all(|name| sums.contains_key(&name)));
    // The nodes of the level are marked with the numbers of their layers.
    let bytes = std::fs::read(folder.join("level.glb")).expect("the level");
    let length = u32::from_le_bytes(bytes[12..16].try_into().expect("four bytes")) as usize;
    let level: Value = serde_json::from_slice(&bytes[20..20 + length]).expect("JSON");
    for (number, layer) in layers.iter().enumerate() {
        let nodes = layer["nodes"].as_array().expect("nodes");
        let expected = usize::from(layer["kind"] != "sky");
        assert_eq!(nodes.len(), expected, "{layer}");
        for node in nodes {
            let node = &level["nodes"][node.as_u64().expect("a number") as usize];
            assert_eq!(node["extras"]["sunroom_lamp"], number, "{node}");
            assert!(
                layer["name"]
                    .as_str()
                    .expect("a name")
                    .ends_with(node["name"].as_str().expect("a name"))
            );
        }
    }
    // Another bake removes the layers.
    said(&bake(&shop, "level", &["--spp", "17", "--no-denoise"]), 0);
    assert!(files(&folder).keys().all(|name| !name.contains("layer")));
    assert!(manifest(&folder).get("layers").is_none());
}

#[test]
fn weak_lamps_share_the_rest_of_what_memory_has_room_for() {
    let shop = shop();
    let arguments = ["--spp", "8", "--no-denoise", "--layers", "--layer-memory", "200KB"];
    let told = said(&bake(&shop, "level", &arguments), 0);
    assert!(told.contains("cannot be dimmed: more --layer-memory"), "{told}");
    let folder = shop.path("level");
    assert_sums(&folder);
    let about = manifest(&folder);
    let number = |value: &Value| value.as_u64().expect("a number");
    let pages = about["lightmaps"].as_array().expect("lightmaps").iter();
    let of_pages: u64 = pages.map(|page| number(&page["width"]) * number(&page["height"])).sum();
    let points = about["irradiance_volumes"][0]["points"]
        .as_array()
        .expect("points")
        .iter();
    let of_volume = 6 * points.map(number).product::<u64>();
    // A cube of 16 x 16 with its smaller levels, and one for diffuse surfaces.
    let of_probe = 8 * 16 * 16 + 6 * 16 * 16;
    let layers = about["layers"].as_array().expect("layers");
    let most = 200_000 / (8 * (of_pages + of_volume + of_probe));
    assert!((2..5).contains(&most), "{most}");
    let mut are_merged = false;
    for page in 0..about["lightmaps"].as_array().expect("lightmaps").len() {
        let lists = layers
            .iter()
            .flat_map(|layer| layer["lightmaps"].as_array().expect("a list"));
        let found = lists.filter(|files| files["lightmap"] == page).count() as u64;
        assert!(found <= most, "{found} layers");
        are_merged |= found == most;
    }
    assert!(are_merged);
    let rest = layers.last().expect("a layer");
    assert_eq!(rest["kind"], "rest");
    assert!(!textures(rest).is_empty());
}

#[test]
fn shares_and_resumed_bakes_have_the_layers_of_one_bake() {
    let shop = shop();
    said(
        &bake(&shop, "one", &["--spp", "20", "--no-denoise", "--layers", "-t", "1"]),
        0,
    );
    said(
        &bake(&shop, "three", &["--spp", "20", "--no-denoise", "--layers", "-t", "3"]),
        0,
    );
    same(&shop, "one", "three");
    for share in ["0..8", "8..20"] {
        said(
            &bake(&shop, &format!("{share}.bake"), &["--samples", share, "--layers"]),
            0,
        );
    }
    said(
        &merge(&shop, "merged", &["8..20.bake", "0..8.bake"], &["--no-denoise"]),
        0,
    );
    same(&shop, "one", "merged");
    let arguments = ["--no-denoise", "--layers", "--checkpoint", "c.bake"];
    said(&bake(&shop, "resumed", &[&["--spp", "8"], &arguments[..]].concat()), 0);
    let more = ["--spp", "20", "--resume", "c.bake"];
    said(&bake(&shop, "resumed", &[&more, &arguments[..]].concat()), 0);
    same(&shop, "one", "resumed");
    // Layers are part of what a checkpoint is of.
    let told = said(
        &bake(&shop, "other", &["--spp", "24", "--no-denoise", "--resume", "c.bake"]),
        1,
    );
    assert!(told.contains("--layers"), "{told}");
    let told = said(&bake(&shop, "other", &["--spp", "24", "--layer-memory", "1MB"]), 2);
    assert!(told.contains("--layers"), "{told}");
}
