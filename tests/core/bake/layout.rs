//! Tests of the layout of lightmaps: the surfaces that get a place, and the places that they get.

use std::sync::atomic::AtomicBool;

use glam::{Vec2, Vec3};
use sunroom::bake::level::{BakeLevel, unwrap_level};
use sunroom::bake::unwrap::UnwrapSettings;
use sunroom::geometry::mesh::MeshData;
use sunroom::geometry::primitives::unit_cube;
use sunroom::gltf::write::GltfWriter;
use sunroom::gltf::write::material::{Material as GltfMaterial, Pbr};
use sunroom::gltf::write::model::{Mesh, Node, Pose, Primitive as GltfPrimitive};

use super::{covered, patch};

/// White, and unlike the usual material no metal.
fn paper() -> Pbr {
    Pbr {
        metallic_factor: 0.0,
        ..Pbr::default()
    }
}

/// Cubes of one mesh: two of one size, one of another, one mirrored, one that is clear, and one that moves.
fn cubes() -> GltfWriter {
    let mut writer = GltfWriter::default();
    let cube = unit_cube();
    let attributes = writer.add_vertices(&cube, None).expect("few vertices");
    let indices = writer
        .add_triangles(&cube.triangles, cube.positions.len())
        .expect("few triangles");
    let material = |color: f32, double_sided| GltfMaterial {
        pbr_metallic_roughness: Pbr {
            base_color_factor: [color, color, color, 1.0],
            ..paper()
        },
        double_sided,
        ..GltfMaterial::default()
    };
    let [white, black, paper] =
        [material(0.8, false), material(0.0, false), material(0.5, true)].map(|material| writer.add_material(material));
    let mut mesh = |material| {
        let (attributes, material) = (attributes.clone(), Some(material));
        writer.add_mesh(Mesh {
            name: "cube".to_owned(),
            primitives: vec![GltfPrimitive {
                attributes,
                indices,
                material,
            }],
        })
    };
    let [white, black, paper] = [white, black, paper].map(&mut mesh);
    let nodes = [
        (white, [0.0, 0.0, 0.0], [1.0, 2.0, 1.0]),
        (white, [5.0, 0.0, 0.0], [1.0, 2.0, 1.0]),
        (white, [10.0, 0.0, 0.0], [1.0; 3]),
        (white, [15.0, 0.0, 0.0], [-1.0, 1.0, 3.0]),
        (black, [20.0, 0.0, 0.0], [1.0; 3]),
        (white, [25.0, 0.0, 0.0], [1.0; 3]),
        (paper, [30.0, 0.0, 0.0], [1.0; 3]),
    ];
    for (mesh, translation, scale) in nodes {
        let node = Node {
            pose: Pose {
                translation,
                scale,
                ..Pose::default()
            },
            mesh: Some(mesh),
            ..Node::default()
        };
        let node = writer.add_node(node, None);
        if translation[0] == 25.0 {
            let times = writer.add_times(&[0.0, 1.0]);
            let linear = sunroom::gltf::write::Interpolation::Linear;
            writer.animate(node, "translation", times, &[[0.0; 3], [1.0; 3]], linear);
        }
    }
    writer
}

fn laid_out(writer: &mut GltfWriter, lit: (bool, bool)) -> BakeLevel {
    let settings = UnwrapSettings {
        atlas_size: 512,
        texels_per_unit: Some(8.0),
        ..UnwrapSettings::default()
    };
    unwrap_level(writer, &settings, |_| lit, &AtomicBool::new(false), &|_, _| {}).expect("a layout")
}

#[test]
fn nodes_get_places_by_what_they_are() {
    let mut writer = cubes();
    let level = laid_out(&mut writer, (true, true));
    let nodes: Vec<usize> = level.nodes.iter().map(|node| node.node).collect();
    assert_eq!(nodes, [0, 1, 2, 3, 6], "neither what is black nor what moves");
    let whole = [0.0, 0.0, 1.0, 1.0];
    let is_shared: Vec<bool> = level.nodes.iter().map(|node| node.rect != whole).collect();
    assert_eq!(is_shared, [true, true, false, false, false]);
    let placed = writer.placed_meshes();
    assert_eq!(placed[0].mesh, placed[1].mesh);
    assert_ne!(placed[0].mesh, placed[2].mesh);
    for placed in &placed {
        let is_baked = nodes.contains(&placed.node);
        for part in &writer.mesh(placed.mesh).primitives {
            assert_eq!(part.attributes.contains_key("TEXCOORD_1"), is_baked);
            if is_baked {
                let count = writer.vectors::<3>(part.attributes["POSITION"]).len();
                let coordinates = writer.vectors::<2>(part.attributes["TEXCOORD_1"]);
                assert_eq!(coordinates.len(), count);
                assert!(coordinates.as_flattened().iter().all(|at| (0.0..=1.0).contains(at)));
            }
        }
    }
    // Both sides of the last one are there, each for itself.
    let paper = &writer.mesh(placed[6].mesh).primitives;
    assert_eq!(paper.len(), 2);
    assert!(
        paper
            .iter()
            .all(|part| !writer.material(part.material.expect("one")).double_sided)
    );
    let json = writer.binary().expect("a file");
    let text = String::from_utf8_lossy(&json);
    assert_eq!(text.matches("sunroom_lightmap").count(), 5);
}

#[test]
fn surfaces_face_away_from_what_they_enclose() {
    let mut writer = cubes();
    let level = laid_out(&mut writer, (true, false));
    assert_eq!(writer.mesh(writer.placed_meshes()[6].mesh).primitives.len(), 1);
    for (surface, centre) in level.surfaces.iter().zip([0.0, 5.0, 10.0, 15.0, 30.0]) {
        let texels = covered(std::slice::from_ref(surface), level.size, level.pages);
        assert!(texels.texels.len() > 6 * 14 * 14, "{}", texels.texels.len());
        for texel in texels.texels {
            let receiver = texel.receiver;
            let from_centre = receiver.position - Vec3::X * centre;
            assert!(receiver.normal.dot(from_centre) > 0.9, "{receiver:?}");
            assert!(receiver.geometric_normal.dot(receiver.normal) > 0.99, "{receiver:?}");
        }
    }
    // Of what is lit from behind alone the back is gathered on.
    let level = laid_out(&mut cubes(), (false, true));
    let texels = covered(&level.surfaces[4..], level.size, level.pages);
    for texel in texels.texels {
        assert!(texel.receiver.normal.dot(texel.receiver.position - Vec3::X * 30.0) < -0.9);
    }
}

#[test]
fn no_two_places_share_a_texel() {
    let mut writer = cubes();
    let level = laid_out(&mut writer, (true, true));
    for page in 0..level.pages {
        let mut owner = vec![None; (level.size.x * level.size.y) as usize];
        let own = level
            .surfaces
            .iter()
            .enumerate()
            .filter(|(_, surface)| surface.page == page);
        for (index, surface) in own {
            let mut alone = surface.clone();
            alone.page = 0;
            for texel in covered(&[alone], level.size, 1).texels {
                let place = (texel.place.y * level.size.x + texel.place.x) as usize;
                assert_eq!(owner[place].replace(index), None, "{}", texel.place);
            }
        }
    }
}

/// Adds a mesh whose triangle is a line, and gives its node.
fn add_line(writer: &mut GltfWriter) -> usize {
    let line = MeshData {
        positions: vec![Vec3::ZERO, Vec3::X, 2.0 * Vec3::X],
        triangles: vec![[0, 1, 2]],
        ..MeshData::default()
    };
    let attributes = writer.add_vertices(&line, None).expect("few vertices");
    let indices = writer.add_triangles(&line.triangles, 3).expect("a triangle");
    let primitives = vec![GltfPrimitive {
        attributes,
        indices,
        material: None,
    }];
    let mesh = writer.add_mesh(Mesh {
        name: "line".to_owned(),
        primitives,
    });
    let node = Node {
        mesh: Some(mesh),
        ..Node::default()
    };
    writer.add_node(node, None)
}

#[test]
fn a_mesh_without_an_area_has_no_place() {
    let mut writer = GltfWriter::default();
    add_line(&mut writer);
    let cancel = AtomicBool::new(false);
    let layout = unwrap_level(
        &mut writer,
        &UnwrapSettings::default(),
        |_| (true, true),
        &cancel,
        &|_, _| {},
    );
    let error = layout.expect_err("no surface");
    assert!(
        error.to_string().contains("nothing in the level has a surface"),
        "{error}"
    );
    // It does not keep others from theirs.
    let mut writer = cubes();
    let line = add_line(&mut writer);
    let level = laid_out(&mut writer, (true, true));
    let nodes: Vec<usize> = level.nodes.iter().map(|node| node.node).collect();
    assert_eq!(nodes, [0, 1, 2, 3, 6]);
    assert!(writer.placed_meshes().iter().any(|placed| placed.node == line));
}

#[test]
fn each_side_of_a_square_is_one_chart() {
    let mut writer = GltfWriter::default();
    let square = patch(Vec3::ZERO, Vec3::Y, 1.0, 1.0, Vec2::ZERO);
    let square = MeshData {
        positions: square.positions,
        triangles: square.triangles,
        ..MeshData::default()
    };
    let attributes = writer.add_vertices(&square, None).expect("few vertices");
    let indices = writer.add_triangles(&square.triangles, 4).expect("few triangles");
    let material = writer.add_material(GltfMaterial {
        pbr_metallic_roughness: paper(),
        double_sided: true,
        ..GltfMaterial::default()
    });
    let primitives = vec![GltfPrimitive {
        attributes,
        indices,
        material: Some(material),
    }];
    let mesh = writer.add_mesh(Mesh {
        name: "square".to_owned(),
        primitives,
    });
    let node = Node {
        mesh: Some(mesh),
        ..Node::default()
    };
    writer.add_node(node, None);
    laid_out(&mut writer, (true, true));
    let sheets = &writer.mesh(0).primitives;
    // A chart more would have vertices of its own on the diagonal.
    let vertices: Vec<usize> = sheets
        .iter()
        .map(|sheet| writer.vectors::<3>(sheet.attributes["POSITION"]).len())
        .collect();
    assert_eq!(vertices, [4, 4]);
}

/// Sets of coordinates are numbered without gaps (glTF 2.0, section 3.7.2.1).
#[test]
fn lightmaps_have_their_coordinates_after_others() {
    let mut writer = GltfWriter::default();
    let bare = MeshData {
        uvs: Vec::new(),
        ..unit_cube()
    };
    for mesh in [bare, unit_cube()] {
        let attributes = writer.add_vertices(&mesh, None).expect("few vertices");
        let indices = writer
            .add_triangles(&mesh.triangles, mesh.positions.len())
            .expect("few triangles");
        let material = Some(writer.add_material(GltfMaterial {
            pbr_metallic_roughness: paper(),
            ..GltfMaterial::default()
        }));
        let mesh = writer.add_mesh(Mesh {
            name: "cube".to_owned(),
            primitives: vec![GltfPrimitive {
                attributes,
                indices,
                material,
            }],
        });
        let node = Node {
            mesh: Some(mesh),
            ..Node::default()
        };
        writer.add_node(node, None);
    }
    laid_out(&mut writer, (true, false));
    let placed = writer.placed_meshes();
    assert_eq!(placed.len(), 2);
    for placed in placed {
        let attributes = &writer.mesh(placed.mesh).primitives[0].attributes;
        let names: Vec<&str> = attributes.keys().map(String::as_str).collect();
        assert_eq!(names, ["NORMAL", "POSITION", "TEXCOORD_0", "TEXCOORD_1"]);
    }
}
