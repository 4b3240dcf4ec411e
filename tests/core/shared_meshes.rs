//! Mesh files of other people: what each of them holds is known from other readers, or counted by a simple one here.

use std::path::{Path, PathBuf};

use crate::mesh_support::assert_sound;
use glam::Vec3;
use sunroom::geometry::mesh::MeshData;
use sunroom::geometry::mesh_file::{LoadedMesh, MeshError};
use sunroom::geometry::obj::load_obj;
use sunroom::geometry::ply::load_ply;

/// A folder of shared data next to the repository, or `None` with a word about it.
fn shared(folder: &str) -> Option<PathBuf> {
    let path = Path::new(crate::ROOT).join("../shared/data").join(folder);
    if path.is_dir() {
        Some(path)
    } else {
        eprintln!("skipped: there is no {}", path.display());
        None
    }
}

fn load_file(path: &Path) -> Result<LoadedMesh, MeshError> {
    let bytes = std::fs::read(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    let folder = path.parent().unwrap();
    let loaded = match path.extension().and_then(|extension| extension.to_str()) {
        Some("ply") => load_ply(&bytes),
        _ => load_obj(&bytes, &mut |name| std::fs::read(folder.join(name))),
    };
    if let Ok(loaded) = &loaded {
        assert_sound(&loaded.mesh);
    }
    loaded
}

#[test]
fn the_models_have_their_triangles() {
    let Some(folder) = shared("models") else { return };
    // 1,113 of the bunny's 35,947 vertices belong to no triangle.
    for (name, vertices, triangles, has_uvs) in [
        ("bunny.obj", 34_834, 69_451, false),
        ("dragon.ply", 437_645, 871_414, false),
        ("dragon_res3.ply", 22_998, 47_794, false),
        ("dragon_res4.ply", 5_205, 11_102, false),
        ("teapot.obj", 3_644, 6_320, false),
        ("suzanne.obj", 507, 968, false),
        ("spot.obj", 3_225, 5_856, true),
    ] {
        let loaded = load_file(&folder.join(name)).unwrap_or_else(|error| panic!("{name}: {error}"));
        let mesh = loaded.mesh;
        assert_eq!(
            (mesh.positions.len(), mesh.triangles.len()),
            (vertices, triangles),
            "{name}"
        );
        assert_eq!(!mesh.uvs.is_empty(), has_uvs, "{name}");
        assert_eq!(loaded.warnings, [""; 0], "{name}");
        let least = vertices * 24 + triangles * 12;
        assert!(
            (least..2 * least).contains(&mesh.heap_bytes()),
            "{name}: {} bytes held",
            mesh.heap_bytes()
        );
    }
}

/// Vertices, triangles, materials and warnings; or the error.
type Outcome = Result<(usize, usize, usize, usize), &'static str>;

const NO_TRIANGLES: Outcome = Err("the file holds no triangles");

#[test]
fn every_file_of_other_loaders_loads_or_says_why_not() {
    let Some(folder) = shared("obj") else { return };
    let expected: &[(&str, Outcome)] = &[
        ("assimp/WusonOBJ.obj", Ok((2117, 3732, 0, 0))),
        ("assimp/box.obj", Ok((8, 12, 0, 1))),
        // One face is a polygon of 936 corners, round and round the same four.
        ("assimp/box_longline.obj", Ok((8, 944, 0, 1))),
        ("assimp/box_mat_with_spaces.obj", Ok((8, 12, 12, 0))),
        ("assimp/concave_polygon.obj", Ok((64, 64, 1, 0))),
        ("assimp/cube_usemtl.obj", Ok((24, 12, 3, 1))),
        ("assimp/cube_with_vertexcolors.obj", Ok((24, 12, 0, 0))),
        ("assimp/empty.obj", NO_TRIANGLES),
        (
            "assimp/malformed.obj",
            Err("line 28: vertex index 0 is out of range: the file has 8"),
        ),
        ("assimp/mtl_different_folder.obj", Ok((8, 12, 1, 0))),
        ("assimp/multiple_spaces.obj", Ok((3, 1, 0, 0))),
        ("assimp/regr_3429812.obj", Ok((4, 4, 1, 1))),
        // Lines only.
        ("assimp/testline.obj", NO_TRIANGLES),
        ("tinyobjloader/colorspace-issue-184.obj", Ok((3, 1, 1, 1))),
        ("tinyobjloader/cornell_box.obj", Ok((72, 36, 5, 0))),
        ("tinyobjloader/cube-vertexcol.obj", Ok((8, 12, 5, 0))),
        ("tinyobjloader/cube.obj", Ok((8, 12, 5, 0))),
        // Faces of one and two corners only.
        ("tinyobjloader/invalid-face-definition.obj", NO_TRIANGLES),
        (
            "tinyobjloader/invalid-relative-vertex-index.obj",
            Err("line 1: vertex index -4 is out of range: the file has 0"),
        ),
        ("tinyobjloader/issue-138.obj", Ok((24, 12, 2, 0))),
        ("tinyobjloader/issue-161-inconsistent-f.obj", Ok((22, 12, 6, 1))),
        ("tinyobjloader/issue-235-usemtl-then-o.obj", Ok((6, 2, 2, 0))),
        ("tinyobjloader/issue-246-usemtl-whitespace.obj", Ok((3, 1, 1, 0))),
        ("tinyobjloader/issue-295-trianguation-failure.obj", Ok((44, 28, 0, 0))),
        ("tinyobjloader/issue-319-003.obj", Ok((10, 8, 0, 0))),
        ("tinyobjloader/issue-92.obj", Ok((3, 1, 1, 0))),
        ("tinyobjloader/issue-95.obj", Ok((3, 1, 1, 0))),
        ("tinyobjloader/leading-decimal-dot-issue-201.obj", Ok((3, 1, 1, 0))),
        ("tinyobjloader/line-prim.obj", NO_TRIANGLES),
        ("tinyobjloader/map-bump.obj", Ok((676, 400, 2, 0))),
        ("tinyobjloader/missing_material_file.obj", Ok((72, 36, 0, 1))),
        ("tinyobjloader/norm-texopt.obj", Ok((3, 1, 1, 0))),
        ("tinyobjloader/refl.obj", Ok((8, 12, 5, 1))),
        ("tinyobjloader/smoothing-normal.obj", Ok((8, 6, 5, 0))),
        ("tinyobjloader/texture-filename-with-whitespace.obj", Ok((8, 12, 5, 0))),
        // The faces come before any usemtl: they are of a sixth, grey material.
        ("tinyobjloader/usemtl-issue-104.obj", Ok((12, 6, 6, 0))),
        // Four textures of no use here; a second library that is not there, and three materials that were in it.
        ("tobj/cornell_box.obj", Ok((72, 36, 5, 7))),
        ("tobj/empty_name_triangle.obj", Ok((3, 1, 0, 0))),
        // Some faces with normals, some without.
        ("tobj/quad.obj", Ok((11, 5, 0, 1))),
        ("tobj/triangle.obj", Ok((3, 1, 0, 0))),
    ];
    let mut wrong = Vec::new();
    for (name, outcome) in expected {
        let found = load_file(&folder.join(name));
        let found = found.as_ref().map(|LoadedMesh { mesh, warnings }| {
            (
                mesh.positions.len(),
                mesh.triangles.len(),
                mesh.materials.len(),
                warnings.len(),
            )
        });
        let found = found.map_err(ToString::to_string);
        if found != outcome.map_err(ToString::to_string) {
            wrong.push(format!("{name}: {found:?}, expected {outcome:?}"));
        }
    }
    for entry in ["assimp", "tinyobjloader", "tobj"]
        .iter()
        .flat_map(|sub| std::fs::read_dir(folder.join(sub)).unwrap())
    {
        let path = entry.unwrap().path();
        let name = path.strip_prefix(&folder).unwrap().to_str().unwrap();
        if name.ends_with(".obj") && !expected.iter().any(|(known, _)| *known == name) {
            wrong.push(format!("{name}: nothing is expected of it"));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// Every file below `folder` whose name ends so.
fn files(folder: &Path, extension: &str, found: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
        let path = entry.path();
        if path.is_dir() {
            files(&path, extension, found);
        } else if path.extension().is_some_and(|of_file| of_file == extension) {
            found.push(path);
        }
    }
    found.sort();
}

/// Triangles and bounds of an OBJ file by a reading that knows only vertices and the first numbers of faces; None if an
/// index leads nowhere.
fn plain_obj(text: &str) -> Option<(usize, Vec3, Vec3)> {
    let (mut vertices, mut triangles) = (Vec::new(), 0);
    let (mut low, mut high) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
    for line in text.replace("\\\r\n", " ").replace("\\\n", " ").lines() {
        let line = line.split('#').next().unwrap_or_default();
        let mut words = line.split_whitespace();
        match words.next() {
            Some("v") => {
                let xyz: Vec<f32> = words.take(3).map(|word| word.parse().expect("a number")).collect();
                vertices.push(Vec3::from_slice(&xyz));
            }
            Some("f") => {
                let corners: Vec<&str> = words.collect();
                if corners.len() < 3 {
                    continue;
                }
                triangles += corners.len() - 2;
                for corner in corners {
                    let index: isize = corner.split('/').next()?.parse().ok()?;
                    let count = vertices.len() as isize;
                    let place = if index < 0 { count + index } else { index - 1 };
                    let corner = *vertices.get(usize::try_from(place).ok()?)?;
                    (low, high) = (low.min(corner), high.max(corner));
                }
            }
            _ => {}
        }
    }
    Some((triangles, low, high))
}

/// Faces that the header of a PLY file promises.
fn promised_faces(bytes: &[u8]) -> usize {
    let header = String::from_utf8_lossy(&bytes[..bytes.len().min(4096)]).into_owned();
    let line = header
        .lines()
        .find_map(|line| line.trim().strip_prefix("element face "));
    line.and_then(|count| count.trim().parse().ok())
        .expect("a count of faces")
}

fn bounds(mesh: &MeshData) -> (Vec3, Vec3) {
    let corners = (0..mesh.triangles.len()).flat_map(|triangle| mesh.corners(triangle));
    corners.fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), corner| {
        (low.min(corner), high.max(corner))
    })
}

#[test]
fn every_mesh_there_is_loads_whole_or_says_why_not() {
    let Some(folder) = shared("") else { return };
    let mut paths = Vec::new();
    files(&folder, "obj", &mut paths);
    files(&folder, "ply", &mut paths);
    assert!(!paths.is_empty(), "no meshes in {}", folder.display());
    for path in paths {
        let bytes = std::fs::read(&path).unwrap();
        let loaded = load_file(&path);
        let name = path.display();
        if path.extension().is_some_and(|extension| extension == "ply") {
            let mesh = loaded.unwrap_or_else(|error| panic!("{name}: {error}")).mesh;
            assert!(mesh.triangles.len() >= promised_faces(&bytes), "{name}");
            continue;
        }
        match (loaded, plain_obj(&String::from_utf8_lossy(&bytes))) {
            (Ok(loaded), Some((triangles, low, high))) => {
                assert_eq!(loaded.mesh.triangles.len(), triangles, "{name}");
                assert_eq!(bounds(&loaded.mesh), (low, high), "{name}");
            }
            (Err(error), plain) => {
                assert!(plain.is_none_or(|(triangles, ..)| triangles == 0), "{name}: {error}");
                let text = error.to_string();
                let is_clear = text == "the file holds no triangles" || text.starts_with("line ");
                assert!(is_clear && !text.contains('\n'), "{name}: {text}");
            }
            (Ok(_), None) => panic!("{name}: an index leads nowhere"),
        }
    }
}

#[test]
fn every_material_library_gives_its_materials() {
    let Some(folder) = shared("") else { return };
    let mut paths = Vec::new();
    files(&folder, "mtl", &mut paths);
    for path in paths {
        let library = std::fs::read(&path).unwrap();
        // Old programs write Latin-1.
        let latin = || library.iter().map(|&byte| char::from(byte)).collect();
        let text = String::from_utf8(library.clone()).unwrap_or_else(|_| latin());
        let names: Vec<&str> = text
            .lines()
            .filter_map(|line| line.trim().strip_prefix("newmtl"))
            .map(str::trim)
            .collect();
        let asking = "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
        let mesh = load_obj(asking.as_bytes(), &mut |_| Ok(library.clone())).unwrap().mesh;
        let known: Vec<&str> = mesh.materials.iter().map(|material| material.name.as_str()).collect();
        for name in names {
            assert!(known.contains(&name), "{}: {name} of {known:?}", path.display());
        }
    }
}

#[test]
fn the_concave_polygon_is_not_covered_twice() {
    let Some(folder) = shared("obj/assimp") else { return };
    let mesh = load_file(&folder.join("concave_polygon.obj")).unwrap().mesh;
    let signed = |i| {
        let [a, b, c]: [Vec3; 3] = mesh.corners(i);
        0.5 * (b - a).cross(c - a).x
    };
    let sum: f32 = (0..mesh.triangles.len()).map(signed).sum();
    let absolute: f32 = (0..mesh.triangles.len()).map(|i| mesh.area_of_triangle(i)).sum();
    // A ring of outer radius 0.7425, planar: its triangles all turn the same way.
    assert!(
        absolute > 0.1 && (sum.abs() - absolute).abs() < 1e-4 * absolute,
        "{sum} of {absolute}"
    );
}

#[test]
fn small_ply_files_of_other_people() {
    let Some(folder) = shared("ply") else { return };
    for (name, vertices, triangles, uvs) in [
        ("cbox_smallbox.ply", 24, 12, 0),
        ("rectangle_uv.ply", 4, 2, 4),
        ("triangle.ply", 3, 1, 0),
    ] {
        let mesh = load_file(&folder.join(name))
            .unwrap_or_else(|error| panic!("{name}: {error}"))
            .mesh;
        assert_eq!(
            (mesh.positions.len(), mesh.triangles.len(), mesh.uvs.len()),
            (vertices, triangles, uvs),
            "{name}"
        );
    }
}

#[test]
fn a_material_library_of_another_program() {
    let Some(folder) = shared("obj/misc") else { return };
    let library = std::fs::read(folder.join("threejs_male02.mtl")).unwrap();
    let text = "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl _01_-_Default1noCulli__01_-_Default1noCulli\nf 1 2 3\n";
    let mesh = load_obj(text.as_bytes(), &mut |_| Ok(library.clone())).unwrap().mesh;
    assert_eq!(mesh.materials.len(), 2);
    let used = &mesh.materials[mesh.material_of_triangle[0] as usize];
    assert_eq!((used.kd, used.ks), (Vec3::splat(0.64), Vec3::splat(0.05)));
    assert_eq!((used.ns, used.ni, used.d, used.illum), (30.0, 1.0, 1.0, Some(2)));
}
