//! Every parser that reads foreign bytes, as a plain function of these bytes.
//!
//! The fuzz target and the test that replays the corpus share this file, so that both do the same. An entry panics where the program
//! breaks a promise: a panic of the parser itself, a mesh that contradicts its documentation, a document that changes when it is written.

use std::io::{self, Write as _};
use std::path::Path;
use std::sync::{Arc, LazyLock};

use glam::{Affine3A, Mat4, UVec3, Vec3};
use rayon::{ThreadPool, ThreadPoolBuilder};
use sunroom_core::bake::part::{decode as decode_part, encode as encode_part};
use sunroom_core::document::revision::{Destination, revise};
use sunroom_core::document::source::decode;
use sunroom_core::document::spectrum::{Role, SampledSpectrum, SpectrumError};
use sunroom_core::document::value::{
    format_float, parse_boolean, parse_float, parse_floats, parse_integer, parse_rgb, parse_srgb, parse_vec3,
    parse_vec3_or_splat,
};
use sunroom_core::document::{
    Category, Child, Document, Object, Property, Span, TransformOp, Value, WriteError, parse_str, to_xml,
};
use sunroom_core::geometry::attribute::{AttributeDomain, AttributeValues};
use sunroom_core::geometry::mesh::MeshData;
use sunroom_core::geometry::obj::load_obj;
use sunroom_core::geometry::ply::load_ply;
use sunroom_core::geometry::ply_write::binary_ply;
use sunroom_core::geometry::serialized::SerializedFile;
use sunroom_core::gltf::Gltf;
use sunroom_core::gltf::files::take_apart;
use sunroom_core::medium::vdb::VdbFile;
use sunroom_core::medium::{
    GridVolume, Medium, MediumSource, Mended, Phase, Volume, VolumeFilter, VolumeWrap, Way, read_vol, write_vol,
};
use sunroom_core::render::bytes::Writer;
use sunroom_core::render::film::Film;
use sunroom_core::render::part::{PartFile, PartHeader, write_part};
use sunroom_core::render::tile::Tile;
use sunroom_core::sampling::{Sampler, SequenceKind};
use sunroom_core::texture::load_image;

/// Reads bytes as one kind of file.
pub type Entry = fn(&[u8]);

/// All entries by the names of their fuzz targets and of their folders in the corpus.
pub const ENTRIES: [(&str, Entry); 25] = [
    ("xml", xml),
    ("dialect", xml),
    ("animation", animation),
    ("numbers", numbers),
    ("spectra", spectra),
    ("transforms", transforms),
    ("obj", obj),
    ("mtl", mtl),
    ("ply", ply),
    ("serialized", serialized),
    ("serialized_shape", serialized_shape),
    ("gltf", gltf),
    ("png", png),
    ("jpeg", jpeg),
    ("bmp", bmp),
    ("tga", tga),
    ("pnm", pnm),
    ("hdr", hdr),
    ("exr", exr),
    ("pfm", pfm),
    ("vdb", vdb),
    ("vol", vol),
    ("media", media),
    ("bake", bake),
    ("part", part),
];

/// No file has this name, and none has a name relative to its folder.
const NOWHERE: &str = "/nowhere/scene.xml";

/// A scene file, native or of the imported dialect. What is read without an error is the same after it was written and read again,
/// and writing it over its own text changes nothing.
pub fn xml(bytes: &[u8]) {
    let path = Path::new(NOWHERE);
    let text = match decode(bytes.to_vec(), path) {
        Ok(text) => text,
        Err(error) => {
            let _ = error.to_string();
            return;
        }
    };
    let document = parse_str(text.as_str(), path, &[("size".to_owned(), "3".to_owned())]);
    let diagnostics = &document.diagnostics;
    // Layouting many messages would take most of the time.
    if diagnostics.list.len() <= 3 {
        diagnostics.render(false);
        let _ = diagnostics.to_string();
    }
    if diagnostics.has_errors() {
        return;
    }
    assert_survives_writing(&document);
    if !document.imported {
        let destination = Destination {
            path,
            find_before: &|_, _| None,
            find_after: &|_, _| None,
            has_changed: &|_| false,
        };
        let files = revise(&document, &document, &destination).expect("nothing is written anew");
        assert_eq!(files, [(path.to_owned(), text)], "written over itself");
    }
}

/// Writes and reads again. A file may hold control characters, which are refused when they are to be written.
fn assert_survives_writing(document: &Document) {
    let text = match to_xml(document) {
        Ok(text) => text,
        Err(WriteError::NotXml { .. }) => return,
        Err(error) => panic!("{error}"),
    };
    let again = parse_str(text.as_str(), &document.path, &[]);
    assert!(!again.diagnostics.has_errors(), "{}\n{text}", again.diagnostics);
    assert_eq!(without_spans(&again.root), without_spans(&document.root), "{text}");
    assert_eq!(again.search_folders, document.search_folders, "{text}");
}

/// The tree without the places in the file.
pub fn without_spans(object: &Object) -> Object {
    let properties = object.properties.iter().map(|property| Property {
        span: Span::default(),
        ..property.clone()
    });
    let children = object.children.iter().map(|child| match child {
        Child::Object(object) => without_spans(object).into(),
        Child::Reference { name, id, .. } => Child::Reference {
            name: name.clone(),
            id: id.clone(),
            span: Span::default(),
        },
    });
    Object {
        properties: properties.collect(),
        children: children.collect(),
        span: Span::default(),
        ..object.clone()
    }
}

/// A native scene with key frames: it survives being written at any moment, and then has the values of that moment.
pub fn animation(bytes: &[u8]) {
    let path = Path::new(NOWHERE);
    let Ok(text) = decode(bytes.to_vec(), path) else { return };
    let document = parse_str(text.as_str(), path, &[]);
    if document.imported || document.diagnostics.has_errors() {
        return;
    }
    let Some((first, last)) = document.animated_span() else {
        return;
    };
    assert!(first <= last && first.is_finite() && last.is_finite());
    for share in [-1.0, 0.0, 0.3, 0.5, 1.0, 2.0] {
        let time = first + (last - first) * share;
        let moment = document.at(time);
        assert_eq!(moment.animated_span(), Some((first, last)));
        let text = match to_xml(&moment) {
            Ok(text) => text,
            Err(WriteError::NotXml { .. }) => return,
            Err(error) => panic!("at {time}: {error}"),
        };
        let again = parse_str(text.as_str(), path, &[]);
        assert!(!again.diagnostics.has_errors(), "{}\n{text}", again.diagnostics);
        // As text, in which a number that is none is the same as another: huge keys have such numbers between them, which the reader of scenes refuses.
        let [found, expected] = [&again.at(time), &moment].map(|moment| format!("{:?}", without_spans(&moment.root)));
        assert_eq!(found, expected, "at {time}: {text}");
    }
}

/// A list of wavelengths with values, and a file of them. What is read is what a plain reading of the text finds, and its colours are those of the same
/// spectrum given in another way.
pub fn spectra(bytes: &[u8]) {
    let text = String::from_utf8_lossy(bytes);
    let is_blank = |c: char| matches!(c, ' ' | ',' | '\t' | '\n' | '\r');
    let pairs = text.split(is_blank).filter(|pair| !pair.is_empty());
    let pairs = pairs.map(|pair| {
        let colon = pair.find(':')?;
        plain_pair(&pair[..colon], &pair[colon + 1..])
    });
    assert_is_spectrum(&SampledSpectrum::parse_list(&text), pairs.collect(), &text);
    let lines = text.lines().map(|line| line.split('#').next().unwrap_or_default());
    let columns = lines.map(|line| line.split(is_blank).filter(|word| !word.is_empty()).collect::<Vec<_>>());
    let pairs = columns.filter(|words| !words.is_empty()).map(|words| match words[..] {
        [wavelength, value] => plain_pair(wavelength, value),
        _ => None,
    });
    assert_is_spectrum(&SampledSpectrum::parse_file(&text), pairs.collect(), &text);
}

fn plain_pair(wavelength: &str, value: &str) -> Option<[f32; 2]> {
    let number = |text: &str| text.trim().parse().ok().filter(|number: &f32| number.is_finite());
    Some([number(wavelength)?, number(value)?])
}

/// `pairs` is what a plain reading has found, None if it is no spectrum.
fn assert_is_spectrum(spectrum: &Result<SampledSpectrum, SpectrumError>, pairs: Option<Vec<[f32; 2]>>, text: &str) {
    let increases = |pairs: &Vec<[f32; 2]>| pairs.len() >= 2 && pairs.windows(2).all(|two| two[0][0] < two[1][0]);
    let pairs = pairs.filter(increases);
    assert_eq!(spectrum.is_ok(), pairs.is_some(), "{text:?}");
    let (Ok(spectrum), Some(pairs)) = (spectrum, pairs) else {
        return;
    };
    let column = |place: usize| {
        let numbers: Vec<String> = pairs.iter().map(|pair| format_float(pair[place])).collect();
        numbers.join(" ")
    };
    let apart = SampledSpectrum::parse_irregular(&column(0), &column(1));
    assert_eq!(apart.as_ref(), Ok(spectrum), "{text:?}");
    for role in [Role::Emission, Role::Daylight, Role::Reflectance, Role::Unbounded] {
        let (color, _) = spectrum.to_rgb(role);
        assert!(color.is_finite() && color.min_element() >= 0.0, "{color} from {text:?}");
    }
}

/// The text of an attribute as each type of value, and the bytes as numbers to be printed. What is read is finite, and a number that
/// is printed reads back exactly.
pub fn numbers(bytes: &[u8]) {
    let text = String::from_utf8_lossy(bytes);
    if let Ok(number) = parse_float(&text) {
        assert_reads_back(number);
    }
    let _ = (parse_integer(&text), parse_boolean(&text));
    let triples = [parse_vec3, parse_vec3_or_splat, parse_rgb, parse_srgb].map(|parse| parse(&text));
    for triple in triples.into_iter().flatten() {
        assert!(triple.is_finite(), "{triple} from {text:?}");
    }
    if let Ok(numbers) = parse_floats(&text) {
        numbers.into_iter().for_each(assert_reads_back);
    }
    let printed = bytes.as_chunks::<4>().0.iter().map(|four| f32::from_le_bytes(*four));
    printed.filter(|number| number.is_finite()).for_each(assert_reads_back);
}

fn assert_reads_back(number: f32) {
    let text = format_float(number);
    assert_eq!(parse_float(&text).map(f32::to_bits), Ok(number.to_bits()), "{text}");
}

/// Steps of a transform made of the bytes: they survive writing, and the map is finite where the steps are of moderate size.
pub fn transforms(bytes: &[u8]) {
    let mut numbers = bytes[bytes.len().min(8)..]
        .as_chunks::<4>()
        .0
        .iter()
        .map(|four| f32::from_le_bytes(*four))
        .map(|number| if number.is_finite() { number } else { 0.0 })
        .fuse();
    let mut number = || numbers.next().unwrap_or(1.0);
    let mut steps = Vec::new();
    for kind in &bytes[..bytes.len().min(8)] {
        let mut triple = || Vec3::new(number(), number(), number());
        steps.push(match kind % 5 {
            0 => TransformOp::Translate(triple()),
            1 => TransformOp::Scale(triple()),
            2 => TransformOp::Rotate {
                axis: triple(),
                degrees: number(),
            },
            3 => {
                let mut matrix = Mat4::from_cols_array(&std::array::from_fn(|_| number()));
                for column in 0..4 {
                    matrix.col_mut(column).w = if column == 3 { 1.0 } else { 0.0 };
                }
                TransformOp::Matrix(matrix)
            }
            _ => TransformOp::LookAt {
                origin: triple(),
                target: triple(),
                // Zero counts as not given.
                up: Some(triple()).filter(|&up| up != Vec3::ZERO).unwrap_or(Vec3::Y),
            },
        });
    }
    let is_moderate = |step: &TransformOp| {
        // A rotation scales by the square of the length of its axis.
        let has_long_axis = matches!(step, TransformOp::Rotate { axis, .. } if axis.abs().max_element() > 30.0);
        let numbers = step.numbers();
        !has_long_axis && numbers.iter().all(|number| number.abs() < 1e3)
    };
    let map = TransformOp::compose(&steps);
    if steps.iter().all(is_moderate) {
        assert!(map.is_finite(), "{map} of {steps:?}");
    }
    let shape = Object::new(Category::Shape, "cube").with("to_world", Value::Transform(steps.clone()));
    let root = Object::new(Category::Scene, "").with_child(shape);
    let text = to_xml(&Document::new(NOWHERE, root)).expect("all numbers are finite");
    let again = parse_str(text.as_str(), Path::new(NOWHERE), &[]);
    // A look along its own up direction and the like are errors.
    if !again.diagnostics.has_errors() {
        let read = again.root.objects().next().map(|shape| &shape.properties[0].value);
        assert_eq!(read, Some(&Value::Transform(steps)), "{text}");
    }
}

/// An OBJ file; what follows the first zero byte is the material library, whatever its name.
pub fn obj(bytes: &[u8]) {
    let (mesh, library) = halves(bytes);
    if let Ok(loaded) = load_obj(mesh, &mut |_| Ok(library.to_vec())) {
        assert_sound(&loaded.mesh);
    }
}

/// A material library, used by a mesh of two triangles.
pub fn mtl(bytes: &[u8]) {
    let mesh = b"mtllib a/b.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl a\nf 1 2 3\nusemtl b\nf 3 2 1\n";
    let loaded = load_obj(mesh, &mut |_| Ok(bytes.to_vec())).expect("a library is never an error");
    assert_sound(&loaded.mesh);
}

pub fn ply(bytes: &[u8]) {
    if let Ok(loaded) = load_ply(bytes) {
        assert_sound(&loaded.mesh);
    }
}

/// A file of the format `serialized`: its table and its first shapes.
pub fn serialized(bytes: &[u8]) {
    let Ok(file) = SerializedFile::open(bytes) else {
        return;
    };
    for shape in 0..file.count().min(4) {
        if let Ok(loaded) = file.load(shape) {
            assert_sound(&loaded.mesh);
        }
    }
}

/// The content of one shape of such a file, which is packed here. The first byte chooses the version.
pub fn serialized_shape(bytes: &[u8]) {
    let Some((version, content)) = bytes.split_first() else {
        return;
    };
    let version = 3 + u16::from(version % 2);
    let mut file = [0x1c, 0x04, version as u8, 0].to_vec();
    let mut packer = flate2::write::ZlibEncoder::new(&mut file, flate2::Compression::none());
    packer.write_all(content).expect("memory can be written to");
    packer.finish().expect("memory can be written to");
    file.resize(file.len() + if version == 3 { 4 } else { 8 }, 0);
    file.extend(1u32.to_le_bytes());
    serialized(&file);
}

/// A file of volumes: its table and its first grids.
pub fn vdb(bytes: &[u8]) {
    let Ok(file) = VdbFile::open(bytes) else {
        return;
    };
    for name in file.names().iter().take(4) {
        if let Ok(volume) = file.read(Some(name), 1 << 22) {
            assert!(volume.grid.size() <= 1 << 22);
            assert!(volume.world_from_local.inverse().is_finite());
        }
    }
}

/// A grid of a volume. What is read has no negative value, and is the same after it was written and read again.
pub fn vol(bytes: &[u8]) {
    let Ok(file) = read_vol(bytes) else {
        return;
    };
    let last = file.grid.resolution() - 1;
    for place in [UVec3::ZERO, last / 2, last] {
        let value = file.grid.voxel(place);
        assert!(value.is_finite() && value.min_element() >= 0.0, "{value}");
    }
    if let Some(bounds) = &file.bounds {
        let again = read_vol(&write_vol(&file.grid, bounds)).expect("it was written");
        assert_eq!((again.grid.mended(), again.bounds), (Mended::default(), file.bounds));
        assert_eq!(again.grid.voxels(), file.grid.voxels());
    }
}

/// A medium of a grid: the first bytes choose how dense it is, where it lies and by which ways light goes through it, and the rest is a `.vol` file. Light
/// comes to an end, and what is left of it is no more than there was.
pub fn media(bytes: &[u8]) {
    let Some((chosen, file)) = bytes.split_first_chunk::<8>() else {
        return;
    };
    let Ok(file) = read_vol(file) else { return };
    let power = |byte: u8| 10.0f32.powi(i32::from(byte % 19) - 6);
    let places = [chosen[1], chosen[2], chosen[3]].map(|byte| 2.0f32.powi(i32::from(byte % 13) - 6));
    let [filter, wrap, shines] = [chosen[4] % 2, chosen[5] % 3, chosen[6] % 4];
    let grid = |grid| {
        Volume::Grid(GridVolume::new(
            grid,
            Affine3A::from_scale(places.into()),
            if filter == 0 {
                VolumeFilter::Nearest
            } else {
                VolumeFilter::Trilinear
            },
            [VolumeWrap::Clamp, VolumeWrap::Repeat, VolumeWrap::Mirror][usize::from(wrap)],
        ))
    };
    let values = Arc::new(file.grid);
    let uneven = Vec3::new(1.0, 0.25, 0.0);
    let (sigma_t, emission) = match shines {
        0 => (grid(values.clone()), grid(values)),
        1 => (Volume::Constant(uneven), grid(values)),
        _ => (grid(values), Volume::ZERO),
    };
    let medium = Medium::new(MediumSource {
        sigma_t,
        scale: power(chosen[0]),
        albedo: Volume::Constant(if shines == 3 { Vec3::ZERO } else { Vec3::splat(0.5) }),
        emission,
        phase: Phase::Isotropic,
    });
    for index in 0..4 {
        let sampler = Sampler::new(
            SequenceKind::Independent,
            glam::UVec2::new(chosen[7].into(), index),
            index,
            0,
        );
        let mut stream = sampler.stream(0);
        let mut number = || stream.draw();
        let (from, to) = (
            Vec3::new(number(), number(), number()) * 2.0 - 0.5,
            Vec3::new(number(), number(), number()),
        );
        let [from, to] = [from, to].map(|place| place * Vec3::from(places));
        let Some(dir) = (to - from).try_normalize() else {
            continue;
        };
        let length = if index % 2 == 0 {
            f32::INFINITY
        } else {
            from.distance(to)
        };
        let way = Way {
            origin: from,
            dir,
            length,
        };
        let mut throughput = Vec3::ONE;
        let travel = medium.travel(&way, None, &mut throughput, glam::Vec2::new(0.3, 0.6), &mut stream);
        assert!(
            throughput.is_finite() && throughput.min_element() >= 0.0,
            "{throughput}"
        );
        assert!(
            travel.emitted.is_finite() && travel.emitted.min_element() >= 0.0,
            "{travel:?}"
        );
        assert!((0.0..=1.001).contains(&travel.passed), "{travel:?}");
        assert!(
            travel.scattered_at.is_none_or(|at| (0.0..=length).contains(&at)),
            "{travel:?}"
        );
        let mut carried = Vec3::ONE;
        let (share, passed) = medium.transmit(&way, &mut carried, &mut stream);
        assert!(share.is_finite() && share.min_element() >= 0.0, "{share}");
        assert!((0.0..=1.001).contains(&passed), "{passed}");
        let depth = medium.optical_depth(&way);
        assert!(depth.min_element() >= 0.0 && !depth.is_nan(), "{depth}");
    }
}

/// What the documentation of meshes promises of every mesh that was loaded.
pub fn assert_sound(mesh: &MeshData) {
    let vertices = mesh.positions.len();
    assert!(mesh.positions.iter().all(|position| position.is_finite()));
    assert!(!mesh.triangles.is_empty());
    let mut corners = mesh.triangles.as_flattened().iter();
    assert!(corners.all(|&corner| (corner as usize) < vertices));
    assert_eq!(mesh.normals.len(), vertices);
    let is_unit = |normal: &Vec3| (normal.length() - 1.0).abs() < 1e-5;
    assert!(mesh.normals.iter().all(is_unit), "{:?}", mesh.normals);
    assert!(mesh.uvs.is_empty() || mesh.uvs.len() == vertices);
    assert!(mesh.uvs.iter().all(|uv| uv.is_finite()), "{:?}", mesh.uvs);
    assert!(mesh.material_of_triangle.is_empty() || mesh.material_of_triangle.len() == mesh.triangles.len());
    let mut materials = mesh.material_of_triangle.iter();
    assert!(materials.all(|&material| usize::from(material) < mesh.materials.len()));
    for (place, attribute) in mesh.attributes.iter().enumerate() {
        let name = &attribute.name;
        assert!(mesh.attributes[..place].iter().all(|other| other.name != *name));
        let elements = match attribute.domain {
            AttributeDomain::Vertex => vertices,
            AttributeDomain::Triangle => mesh.triangles.len(),
        };
        let values = match &attribute.values {
            AttributeValues::Srgb8(values) => values.len(),
            AttributeValues::F32(values) => {
                assert!(values.iter().all(|value| value.is_finite()), "{name}: {values:?}");
                values.len()
            }
        };
        assert!(matches!(attribute.channels, 1 | 3));
        assert_eq!(values, elements * attribute.channels, "{name}");
    }
    for triangle in 0..mesh.triangles.len().min(64) {
        mesh.regular_corners(triangle);
    }
    if vertices <= 1000 && mesh.triangles.len() <= 1000 {
        assert_comes_back(mesh);
    }
}

/// Writes the geometry as PLY and reads it again.
fn assert_comes_back(mesh: &MeshData) {
    let geometry = MeshData {
        attributes: Vec::new(),
        ..mesh.clone()
    };
    let again = load_ply(&binary_ply(&geometry)).expect("it was written").mesh;
    assert_eq!(again.positions, mesh.positions);
    assert_eq!(again.triangles, mesh.triangles);
    assert_eq!(again.uvs, mesh.uvs);
    let mut normals = again.normals.iter().zip(&mesh.normals);
    assert!(normals.all(|(one, other)| one.distance(*other) < 1e-5));
}

/// A glTF file of either kind; what follows the first zero byte of a JSON one is every file that it names. Its meshes are sound, the
/// meshes and pictures that are written for other programs can be read, and its scene survives writing.
pub fn gltf(bytes: &[u8]) {
    let (file, other) = match bytes.starts_with(b"glTF") {
        true => (bytes, &b""[..]),
        false => halves(bytes),
    };
    let mut read = |name: &str| match name.is_empty() {
        true => Err(io::ErrorKind::NotFound.into()),
        false => Ok(other.to_vec()),
    };
    let gltf = match Gltf::open(file, &mut read) {
        Ok(gltf) => gltf,
        Err(error) => {
            let _ = error.to_string();
            return;
        }
    };
    for number in 0..gltf.mesh_count().min(16) {
        if let Ok(loaded) = gltf.mesh(number) {
            assert_sound(&loaded.mesh);
        }
    }
    let mut keep = |name: &str, bytes: &[u8]| {
        if name.ends_with(".ply") {
            let loaded = load_ply(bytes).expect("a mesh that was written here");
            assert_sound(&loaded.mesh);
        }
        Ok(name.to_owned())
    };
    let Ok(imported) = take_apart(&gltf, &mut keep, &mut read) else {
        return;
    };
    assert_survives_writing(&Document::new(NOWHERE, imported.root));
}

/// The bytes before and after the first zero byte.
fn halves(bytes: &[u8]) -> (&[u8], &[u8]) {
    match bytes.iter().position(|&byte| byte == 0) {
        Some(zero) => (&bytes[..zero], &bytes[zero + 1..]),
        None => (bytes, b""),
    }
}

/// The beginning of a PNG file.
const PNG: &[u8] = b"\x89PNG\r\n\x1a\n";

/// A PNG picture, with the checksums that its chunks should have: hardly any mutation would get past them.
pub fn png(bytes: &[u8]) {
    let mut file = beginning_with(PNG, bytes);
    let mut at = PNG.len();
    while let Some(length) = file.get(at..).and_then(|rest| rest.first_chunk::<4>()) {
        let end = (at + 8).saturating_add(u32::from_be_bytes(*length) as usize);
        let Some(covered) = file.get(at + 4..end) else { break };
        let mut sum = flate2::Crc::new();
        sum.update(covered);
        let Some(place) = file.get_mut(end..end + 4) else { break };
        place.copy_from_slice(&sum.sum().to_be_bytes());
        at = end + 4;
    }
    picture(&file);
}

pub fn jpeg(bytes: &[u8]) {
    picture(&beginning_with(b"\xff\xd8\xff", bytes));
}

pub fn bmp(bytes: &[u8]) {
    picture(&beginning_with(b"BM", bytes));
}

/// A TGA picture: the format has no beginning of its own.
pub fn tga(bytes: &[u8]) {
    picture(bytes);
}

pub fn pnm(bytes: &[u8]) {
    picture(&beginning_with(b"P", bytes));
}

pub fn hdr(bytes: &[u8]) {
    picture(&beginning_with(b"#?", bytes));
}

pub fn exr(bytes: &[u8]) {
    picture(&beginning_with(&[0x76, 0x2f, 0x31, 0x01], bytes));
}

pub fn pfm(bytes: &[u8]) {
    let kind = if bytes.get(1) == Some(&b'f') { b"Pf" } else { b"PF" };
    picture(&beginning_with(kind, bytes));
}

/// A checkpoint or share of a bake, with the checksum that it should have: hardly any mutation would get past it. What is read is the same after it was written and
/// read again, and pictures without a number that is not finite are made of it.
pub fn bake(bytes: &[u8]) {
    static POOL: LazyLock<ThreadPool> =
        LazyLock::new(|| ThreadPoolBuilder::new().num_threads(1).build().expect("a thread"));
    let mut file = beginning_with(b"SUNBAKE\n\x02\0\0\0", bytes);
    if let Some((content, place)) = file.split_last_chunk_mut::<4>() {
        let mut sum = flate2::Crc::new();
        sum.update(content);
        *place = sum.sum().to_le_bytes();
    }
    let part = match decode_part(&file) {
        Ok(part) => part,
        Err(error) => {
            let _ = error.to_string();
            return;
        }
    };
    let mut written = Vec::new();
    let (header, blueprint, light) = &part;
    let result = encode_part(&mut written, header, blueprint.as_ref(), &light.lights, &light.spent);
    assert!(result.is_ok() && decode_part(&written).is_ok_and(|again| again == part));
    let (_, Some(mut blueprint), light) = part else { return };
    let size = blueprint.places.size;
    let texels: usize = light.lights.iter().map(|light| light.texel_count()).sum();
    if u64::from(size.x) * u64::from(size.y) * blueprint.page_count() as u64 > 1 << 14 || texels > 1 << 12 {
        return;
    }
    blueprint.denoise = false;
    let baked = blueprint.finished(&light.lights, &POOL).expect("nothing is denoised");
    assert_eq!(baked.lightmaps.len(), blueprint.page_count());
    let mut pixels = baked.lightmaps.iter().flat_map(|lightmap| &lightmap.irradiance);
    assert!(pixels.all(|pixel| pixel.is_finite()));
}

/// A checkpoint or share of a picture, without the picture in front, and with the checksum and the length that it should have. What is read is the same after it
/// was written and read again.
pub fn part(bytes: &[u8]) {
    const EXR: [u8; 4] = [0x76, 0x2f, 0x31, 0x01];
    let mut state = Writer(EXR.to_vec());
    state.0.extend_from_slice(bytes);
    let mut sum = flate2::Crc::new();
    sum.update(bytes);
    state.u32(sum.sum());
    state.u64(bytes.len() as u64);
    state.0.extend_from_slice(b"SUNROOM+");
    let file = tempfile::NamedTempFile::new().expect("a temporary folder");
    file.as_file().write_all(&state.0).expect("a temporary folder");
    let Some((header, film, job)) = read_part(file.path()) else {
        return;
    };
    // Sums of finite sums may be beyond all numbers, and such a file is refused.
    let vectors = [film.radiance(), film.albedo(), film.normal()].concat();
    if !vectors.iter().all(|vector| vector.is_finite()) || !film.depth().iter().all(|depth| depth.is_finite()) {
        return;
    }
    let tiles: Vec<Tile> = header.crop.tiles(header.width, header.height).collect();
    write_part(file.path(), &EXR, &header, &film, &tiles, &job).expect("a temporary folder");
    let (header_again, film_again, job_again) = read_part(file.path()).expect("it was written");
    assert_eq!((header_again, job_again), (header, job));
    let content = |film: &Film| {
        let mut content = Writer::default();
        tiles.iter().for_each(|&tile| film.write_tile(tile, &mut content));
        film.write_splats(&mut content);
        content
    };
    assert!(content(&film) == content(&film_again), "the film is another one");
}

/// The header, the film and the job of a part that is small.
fn read_part(path: &Path) -> Option<(PartHeader, Film, Vec<u8>)> {
    let file = match PartFile::open(path) {
        Ok(file) => file,
        Err(error) => {
            let _ = error.to_string();
            return None;
        }
    };
    let (header, kept) = (file.header().clone(), file.header().film_layers());
    if Film::memory_bytes(header.width, header.height, kept) > 4 << 20 {
        return None;
    }
    let mut film = Film::with_layers(header.width, header.height, kept);
    if header.samples[0] > 0 {
        film.keep_chunks();
    }
    let job = file.read_into(&mut film).ok()?;
    Some((header, film, job))
}

/// The bytes with the first ones replaced, so that they are read as the format that begins so.
fn beginning_with(magic: &[u8], bytes: &[u8]) -> Vec<u8> {
    let mut file = bytes.to_vec();
    file.resize(file.len().max(magic.len()), 0);
    file[..magic.len()].copy_from_slice(magic);
    file
}

fn picture(bytes: &[u8]) {
    let image = match load_image(bytes) {
        Ok(image) => image,
        Err(error) => {
            let _ = error.to_string();
            return;
        }
    };
    let (width, height) = (image.width(), image.height());
    assert!(width > 0 && height > 0);
    assert!(matches!(image.channels(), 1 | 3));
    for (x, y) in [(0, 0), (width - 1, 0), (0, height - 1), (width - 1, height - 1)] {
        assert!(image.pixel(x, y).is_finite());
    }
    if u64::from(width) * u64::from(height) <= 1 << 14 {
        assert!(image.mean(false).is_finite() && image.mean(true).is_finite());
    }
}
