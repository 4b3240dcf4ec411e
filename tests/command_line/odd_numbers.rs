//! Numbers of files that are none, or far too large: none is used, none is passed over in silence, and none keeps the
//! program from ending.

use crate::foreign_files::{run, write_scene};
use crate::workshop::Workshop;

/// A file of volumes in the unit cube.
fn vol(size: [i32; 3], channels: i32, values: &[f32]) -> Vec<u8> {
    let mut bytes = b"VOL\x03".to_vec();
    for number in [1, size[0], size[1], size[2], channels] {
        bytes.extend(number.to_le_bytes());
    }
    for number in [0.0, 0.0, 0.0, 1.0, 1.0, 1.0f32].iter().chain(values) {
        bytes.extend(number.to_le_bytes());
    }
    bytes
}

/// Smoke of a file around the ball, and fire of another where one is named.
fn smoke(file: &str, emission: &str) -> String {
    let emission = match emission {
        "" => String::new(),
        name => format!(
            "<volume type='gridvolume' name='emission'><string name='filename' value='{name}'/>
             <transform name='to_world'><scale value='6'/><translate x='-3' y='-3' z='-3'/></transform></volume>"
        ),
    };
    let sigma_t = match file {
        "" => "<rgb name='sigma_t' value='1, 0.01, 0'/>".to_owned(),
        name => format!(
            "<volume type='gridvolume' name='sigma_t'><string name='filename' value='{name}'/>
             <transform name='to_world'><scale value='6'/><translate x='-3' y='-3' z='-3'/></transform></volume>"
        ),
    };
    let medium = format!(
        "<medium type='heterogeneous' id='smoke'>{sigma_t}<float name='albedo' value='0.5'/>{emission}</medium>"
    );
    format!(
        "<integrator type='volpath'/>{medium}
         <shape type='cube'><transform name='to_world'><scale value='20'/></transform><bsdf type='null'/><ref name='interior' id='smoke'/></shape>"
    )
}

/// One voxel among 64 that is far denser than the others held a ray up for as many null collisions as it is dense.
#[test]
fn a_dense_voxel_ends_and_is_told_of() {
    let shop = Workshop::new();
    let limited = "): it is too dense next to thin places";
    for (dense, told) in [
        (50.0, None),
        (1e6, Some(limited)),
        (1e12, Some(limited)),
        (3e38, Some("voxel.vol: 1 value is above 1e12: it counts as that")),
        (
            f32::INFINITY,
            Some("voxel.vol: 1 value is negative or no number: it counts as zero"),
        ),
        (
            f32::NAN,
            Some("voxel.vol: 1 value is negative or no number: it counts as zero"),
        ),
    ] {
        for channels in [1, 3] {
            let mut values = vec![0.0; 64 * channels as usize];
            values[21 * channels as usize] = dense;
            shop.write("voxel.vol", vol([4, 4, 4], channels, &values));
            write_scene(&shop, "scene.xml", &smoke("voxel.vol", ""));
            let render = ["render", "scene.xml", "-o", "a.exr", "--spp", "16", "-q", "--untrusted"];
            for arguments in [&render[..], &["check", "scene.xml"]] {
                let outcome = run(shop.folder(), arguments);
                assert_eq!(outcome.code, Some(0), "{dense}: {}", outcome.stderr);
                if told == Some(limited) {
                    let line = outcome
                        .stderr
                        .lines()
                        .find(|line| line.contains(limited))
                        .expect("told");
                    assert!(
                        line.contains("medium \"smoke\" (") && line.contains("scene.xml:"),
                        "{line}"
                    );
                }
                match told {
                    Some(told) => assert!(outcome.stderr.contains(told), "{dense}: {}", outcome.stderr),
                    None => assert!(!outcome.stderr.contains("warning"), "{}", outcome.stderr),
                }
                let strict = run(shop.folder(), &[arguments, &["--strict"]].concat());
                assert_eq!(
                    strict.code,
                    Some(i32::from(told.is_some())),
                    "{dense}: {}",
                    strict.stderr
                );
            }
        }
    }
}

/// A medium without an id is known by its type and its place.
#[test]
fn a_dense_medium_without_a_name_is_found_in_the_file() {
    let shop = Workshop::new();
    let mut values = vec![0.0; 64];
    values[21] = 1e6;
    shop.write("voxel.vol", vol([4, 4, 4], 1, &values));
    let text = smoke("voxel.vol", "").replace(" id='smoke'>", ">");
    let (medium, shape) = text.split_once("<shape").expect("a shape");
    let medium = medium
        .replace("<integrator type='volpath'/>", "")
        .replace("<medium ", "<medium name='interior' ");
    let shape = shape.replace("<ref name='interior' id='smoke'/>", &medium);
    let scene = write_scene(
        &shop,
        "scene.xml",
        &format!("<integrator type='volpath'/><shape{shape}"),
    );
    let text = std::fs::read_to_string(scene).expect("it was written");
    let before = &text[..text.find("voxel.vol").expect("it is named")];
    let line = before.lines().count();
    let outcome = run(shop.folder(), &["check", "scene.xml"]);
    let place = format!("scene.xml:{line}:");
    let told = outcome
        .stderr
        .lines()
        .find(|line| line.contains("medium of type heterogeneous ("));
    assert!(told.is_some_and(|told| told.contains(&place)), "{}", outcome.stderr);
}

/// A colour that nothing absorbs, in fog with a fire in it: light that leaves the fire and meets nothing more has no
/// end of its way.
#[test]
fn coloured_fog_with_fire_in_it_ends() {
    let shop = Workshop::new();
    shop.write("fire.vol", vol([2, 2, 2], 1, &[1.0; 8]));
    let text = smoke("", "fire.vol").replace("<shape type='cube'>", "<shape type='rectangle'>");
    let scene = write_scene(&shop, "scene.xml", &text);
    let text = std::fs::read_to_string(&scene).expect("it was written");
    // The camera is in the fog.
    let text = text.replacen("<film", "<ref name='medium' id='smoke'/><film", 1);
    std::fs::write(&scene, text).expect("a writable folder");
    let outcome = run(
        shop.folder(),
        &["render", "scene.xml", "-o", "a.exr", "--spp", "16", "-q", "--strict"],
    );
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
}

/// In a closed white room only Russian roulette ends paths.
#[test]
fn paths_end_whatever_depth_roulette_begins_at() {
    let shop = Workshop::new();
    for (integrator, begins) in [
        ("path", 1024),
        ("bdpt", 128),
        ("vcm", 128),
        ("ptracer", 1024),
        ("volpath", 1024),
    ] {
        let room = format!(
            "<integrator type='{integrator}'><integer name='max_depth' value='-1'/><integer name='rr_depth' value='1000000000'/></integrator>
             <shape type='sphere'><float name='radius' value='9'/><boolean name='flip_normals' value='true'/>
             <bsdf type='diffuse'><rgb name='reflectance' value='1'/></bsdf></shape>"
        );
        write_scene(&shop, "scene.xml", &room);
        let outcome = run(
            shop.folder(),
            &["render", "scene.xml", "-o", "a.exr", "--spp", "1", "-q"],
        );
        assert_eq!(outcome.code, Some(0), "{integrator}: {}", outcome.stderr);
        let told = format!("rr_depth is 1000000000: Russian roulette begins after {begins} bounces");
        assert!(outcome.stderr.contains(&told), "{integrator}: {}", outcome.stderr);
    }
}

fn pfm(samples: &[f32]) -> Vec<u8> {
    let mut bytes = format!("PF\n{} 1\n-1.0\n", samples.len() / 3).into_bytes();
    bytes.extend(samples.iter().flat_map(|sample| sample.to_le_bytes()));
    bytes
}

/// A triangle in glTF with these corners, normals and texture coordinates.
fn gltf(shop: &Workshop, positions: [[f32; 3]; 3], normals: [[f32; 3]; 3], uvs: [[f32; 2]; 3]) {
    let numbers = positions
        .as_flattened()
        .iter()
        .chain(normals.as_flattened())
        .chain(uvs.as_flattened());
    let bytes: Vec<u8> = numbers.flat_map(|number| number.to_le_bytes()).collect();
    shop.write("a.bin", bytes);
    shop.write(
        "a.gltf",
        r#"{"asset":{"version":"2.0"},"buffers":[{"uri":"a.bin","byteLength":96}],
        "bufferViews":[{"buffer":0,"byteLength":36},{"buffer":0,"byteOffset":36,"byteLength":36},{"buffer":0,"byteOffset":72,"byteLength":24}],
        "accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]},
          {"bufferView":1,"componentType":5126,"count":3,"type":"VEC3"},{"bufferView":2,"componentType":5126,"count":3,"type":"VEC2"}],
        "meshes":[{"primitives":[{"attributes":{"POSITION":0,"NORMAL":1,"TEXCOORD_0":2}}]}],"nodes":[{"mesh":0}],"scenes":[{"nodes":[0]}],"scene":0}"#,
    );
}

#[test]
fn numbers_that_are_none_are_told_of() {
    let shop = Workshop::new();
    let picture = |name: &str| {
        format!(
            "<shape type='sphere'><bsdf type='diffuse'><texture name='reflectance' type='bitmap'><string name='filename' value='{name}'/></texture></bsdf></shape>"
        )
    };
    let sky = |name: &str| format!("<emitter type='envmap'><string name='filename' value='{name}'/></emitter>");
    let mesh =
        |kind: &str, name: &str| format!("<shape type='{kind}'><string name='filename' value='{name}'/></shape>");
    let triangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
    let ply = |more: &str, values: &str| {
        format!(
            "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n{more}element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0 {values}\n1 0 0 {values}\n0 1 0 {values}\n3 0 1 2\n"
        )
    };
    let uvs = "property float u\nproperty float v\n";
    let colors = "property float r\nproperty float g\nproperty float b\n";
    for (name, bytes) in [
        ("nan.pfm", pfm(&[f32::NAN, 1.0, 1.0, 1.0, 1.0, 1.0])),
        (
            "infinite.pfm",
            pfm(&[1.0, f32::INFINITY, 1.0, f32::NEG_INFINITY, 1.0, 1.0]),
        ),
        ("bright.pfm", pfm(&[1.0, 1e30, 1.0, 1.0, 1.0, 1.0])),
        (
            "uv.obj",
            format!("{triangle}vt nan 0\nvt inf 1\nvt 0 0\nf 1/1 2/2 3/3\n").into(),
        ),
        (
            "normal.obj",
            format!("{triangle}vn nan 0 1\nvn 0 0 1\nf 1//1 2//2 3//2\n").into(),
        ),
        (
            "normals.obj",
            format!("{triangle}vn nan 0 1\nf 1//1 2//1 3//1\n").into(),
        ),
        ("uv.ply", ply(uvs, "nan 1").into()),
        ("colour.ply", ply(colors, "1 nan 1").into()),
        ("bright.ply", ply(colors, "1 1e30 1").into()),
        ("place.obj", "v 0 0 nan\nv 1 0 0\nv 0 1 0\nf 1 2 3\n".into()),
        ("place.ply", ply(uvs, "0 1").replace("\n1 0 0", "\ninf 0 0").into()),
    ] {
        shop.write(name, bytes);
    }
    let warnings = [
        (
            picture("nan.pfm"),
            "nan.pfm: 1 pixel has a value that is infinite or no number: zero takes its place",
        ),
        (
            sky("infinite.pfm"),
            "infinite.pfm: 2 pixels have a value that is infinite or no number: zero takes its place",
        ),
        (
            sky("bright.pfm"),
            "bright.pfm: 1 pixel has a value above 1e12, which takes its place",
        ),
        (
            mesh("obj", "uv.obj"),
            "uv.obj: line 4: texture coordinates that are not finite count as 0 0 (and 1 times more)",
        ),
        (
            mesh("obj", "normal.obj"),
            "normal.obj: 1 of 3 vertices: without a usable normal",
        ),
        (
            mesh("obj", "normals.obj"),
            "normals.obj: normals: none is usable, and all are computed from the triangles",
        ),
        (
            mesh("ply", "uv.ply"),
            "uv.ply: texture coordinates: a pair that is not finite counts as 0 0 (and 2 times more)",
        ),
        (
            mesh("ply", "colour.ply"),
            "colour.ply: attributes: a number of `vertex_color` that is not finite counts as 0 (and 2 times more)",
        ),
    ];
    let bright =
        "bright.ply: attributes: a number of `vertex_color` is beyond 1e12, and counts as that (and 2 times more)";
    for (content, told) in warnings.into_iter().chain([(mesh("ply", "bright.ply"), bright)]) {
        write_scene(&shop, "scene.xml", &content);
        for (strict, code) in [(&[][..], 0), (&["--strict"][..], 1)] {
            let outcome = run(shop.folder(), &[&["check", "scene.xml"], strict].concat());
            assert_eq!(outcome.code, Some(code), "{told}: {}", outcome.stderr);
            assert!(outcome.stderr.contains(told), "{told}: {}", outcome.stderr);
        }
    }
    let errors = [
        (
            mesh("obj", "place.obj"),
            "place.obj: line 1: a vertex position is not finite",
        ),
        (
            mesh("ply", "place.ply"),
            "place.ply: line 13: a vertex position is not finite",
        ),
    ];
    for (content, told) in errors {
        write_scene(&shop, "scene.xml", &content);
        let outcome = run(shop.folder(), &["check", "scene.xml"]);
        assert_eq!(outcome.code, Some(1), "{told}: {}", outcome.stderr);
        assert!(outcome.stderr.contains(told), "{told}: {}", outcome.stderr);
    }
}

#[test]
fn numbers_of_gltf_that_are_none_are_told_of() {
    let shop = Workshop::new();
    let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let (up, flat) = ([[0.0, 0.0, 1.0]; 3], [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]);
    let with = |place: f32, normal: f32, uv: f32| {
        let (mut corners, mut normals, mut uvs) = (corners, up, flat);
        (corners[1][2], normals[0][0], uvs[0][0]) = (place, normal, uv);
        gltf(&shop, corners, normals, uvs);
    };
    with(0.0, 0.0, 0.0);
    let good = run(shop.folder(), &["check", "--strict", "a.gltf"]);
    assert_eq!(good.code, Some(0), "{}", good.stderr);
    for number in [f32::NAN, f32::INFINITY] {
        for (place, normal, uv, code, told) in [
            (
                0.0,
                0.0,
                number,
                0,
                "primitive 0: texture coordinates: a pair that is not finite counts as 0 0",
            ),
            (
                0.0,
                number,
                0.0,
                0,
                "primitive 0: normals: a normal that is zero or not finite is computed from the triangles instead",
            ),
            (
                number,
                0.0,
                0.0,
                1,
                "primitive 0: the position of vertex 1 is not finite",
            ),
        ] {
            with(place, normal, uv);
            for (strict, code) in [(&[][..], code), (&["--strict"][..], 1)] {
                let outcome = run(shop.folder(), &[&["check", "a.gltf"], strict].concat());
                assert_eq!(outcome.code, Some(code), "{told}: {}", outcome.stderr);
                assert!(outcome.stderr.contains(told), "{told}: {}", outcome.stderr);
            }
        }
    }
}
