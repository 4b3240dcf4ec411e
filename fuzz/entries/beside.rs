//! Entries for what is read beside other files: material libraries, files of wavelengths, and the noise that a
//! checkpoint keeps.

use std::fs;
use std::io;
use std::path::Path;

use glam::UVec2;
use sunroom_core::document::spectrum::{Role, SampledSpectrum};
use sunroom_core::document::{Document, Value, parse_str};
use sunroom_core::geometry::obj::load_obj;
use sunroom_core::render::bytes::{Reader, Writer};
use sunroom_core::render::noise::adaptive::{FIRST, NoiseMap};
use sunroom_core::render::noise::replicas::Replicas;
use sunroom_core::render::tile::tiles;

/// An OBJ file and, each behind a zero byte, material libraries with the names `0.mtl`, `1.mtl` and so on. Each is read
/// once.
pub fn libraries(bytes: &[u8]) {
    let mut parts = bytes.split(|&byte| byte == 0);
    let mesh = parts.next().unwrap_or_default();
    let libraries: Vec<&[u8]> = parts.collect();
    let mut asked = Vec::new();
    let loaded = load_obj(mesh, &mut |name| {
        asked.push(name.to_owned());
        let number = name
            .strip_suffix(".mtl")
            .and_then(|number| number.parse::<usize>().ok());
        let library = number.and_then(|number| libraries.get(number));
        library
            .map(|library| library.to_vec())
            .ok_or(io::ErrorKind::NotFound.into())
    });
    let count = asked.len();
    asked.sort();
    asked.dedup();
    assert!(asked.len() == count && count <= 64, "{count} libraries: {asked:?}");
    if let Ok(loaded) = loaded {
        let (of_triangles, materials) = (loaded.mesh.material_of_triangle, loaded.mesh.materials.len());
        assert!(of_triangles.is_empty() || of_triangles.len() == loaded.mesh.triangles.len());
        assert!(of_triangles.iter().all(|&material| usize::from(material) < materials));
    }
}

/// A file of wavelengths, named three times by a scene. The colour is that of the spectrum in the file.
pub fn spectrum_file(bytes: &[u8]) {
    let file = tempfile::NamedTempFile::new().expect("a temporary folder");
    fs::write(file.path(), bytes).expect("a temporary folder");
    let spectrum = |name: &str| format!("<spectrum name='{name}' filename='{}'/>", file.path().display());
    let (seen, shining) = (spectrum("reflectance"), spectrum("radiance"));
    let scene = parse_str(
        format!(
            "<scene version='3.0.0'><bsdf type='diffuse'>{seen}</bsdf><bsdf type='diffuse'>{seen}</bsdf>\
             <emitter type='constant'>{shining}</emitter></scene>"
        ),
        Path::new("/nowhere/scene.xml"),
        &[],
    );
    let values = values(&scene);
    if scene.diagnostics.has_errors() {
        assert!(values.is_empty(), "{values:?}");
        return;
    }
    let text = std::str::from_utf8(bytes).expect("it was read as text");
    let spectrum = SampledSpectrum::parse_file(text.trim_start_matches('\u{feff}')).expect("it was read");
    let color = |role| Value::Rgb(spectrum.to_rgb(role).0);
    let expected = [Role::Reflectance, Role::Reflectance, Role::Emission].map(color);
    assert_eq!(values, expected);
}

/// The values of the properties of a scene's objects.
fn values(scene: &Document) -> Vec<Value> {
    let properties = scene.root.objects().flat_map(|object| &object.properties);
    properties.map(|property| property.value.clone()).collect()
}

/// What a checkpoint has of the noise of a picture, and of its replicas. It is the same when it is written again, and
/// samples can be shared out by it.
pub fn noise(bytes: &[u8]) {
    const SIDE: u32 = 40;
    let tiles = tiles(SIDE, SIDE);
    let (mut map, mut from) = (NoiseMap::new(&tiles, SIDE), Reader(bytes));
    if map.read(&mut from).is_err() {
        return;
    }
    let active: Vec<usize> = (0..tiles.len()).collect();
    let counts = vec![[FIRST; _]; tiles.len()];
    if let Some(ends) = map.allocate(&active, &counts, FIRST, 2 * FIRST) {
        assert_eq!(ends.len(), tiles.len());
        assert!(ends.iter().flatten().all(|&end| end >= FIRST));
    }
    let mut again = Writer::default();
    map.write(&mut again);
    if let Ok(replicas) = Replicas::read(&mut from, UVec2::splat(SIDE)) {
        replicas.write(&mut again);
        assert_eq!(again.0, bytes[..bytes.len() - from.0.len()]);
    }
}
