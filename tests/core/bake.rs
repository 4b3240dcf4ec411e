//! Light on texels against closed forms, the conservation of energy, the path tracer, and what must not leak.

use std::f32::consts::PI;
use std::sync::atomic::AtomicBool;

use glam::{Affine3A, Quat, UVec2, Vec2, Vec3};
use sunroom::accel::Primitive;
use sunroom::bake::finish::finish;
use sunroom::bake::gathering::Gathering;
use sunroom::bake::level::{BakeLevel, unwrap_level};
use sunroom::bake::lightmap::Lightmaps;
use sunroom::bake::sides::lit_sides;
use sunroom::bake::texels::{BakeSurface, Texels, covered_texels};
use sunroom::bake::unwrap::UnwrapSettings;
use sunroom::color::{Rgb, luminance};
use sunroom::geometry::mesh::MeshData;
use sunroom::geometry::primitives::unit_cube;
use sunroom::gltf::write::GltfWriter;
use sunroom::gltf::write::material::{Material as GltfMaterial, Pbr};
use sunroom::gltf::write::model::{Mesh, Node, Pose, Primitive as GltfPrimitive};
use sunroom::light::LightSource;
use sunroom::render::irradiance::ReceivedLight;
use sunroom::render::scene::RenderScene;
use sunroom::render::view::{Strategy, View};
use sunroom::shading::{Bsdf, Diffuse};

use crate::support::{SceneBuilder, assert_close, camera, mean_luminance, render, view};

fn diffuse(reflectance: f32) -> Bsdf {
    Bsdf::Diffuse(Diffuse {
        reflectance: Rgb::splat(reflectance),
    })
}

/// A view for its settings; the camera does not matter.
fn settings(strategy: Strategy) -> View {
    View {
        seed: 3,
        ..view(camera(Vec3::ONE, Vec3::ZERO, 90.0), 1, u32::MAX, strategy)
    }
}

fn gathering<'a>(scene: &'a RenderScene, view: &'a View) -> Gathering<'a> {
    Gathering {
        scene,
        view,
        light: ReceivedLight::All,
    }
}

/// A square around `centre` that faces `normal`, with `texels` on each side; the lower left corner lies `offset` texels from that of the lightmap.
fn patch(centre: Vec3, normal: Vec3, half_size: f32, texels: f32, offset: Vec2) -> BakeSurface {
    let (s, t) = normal.any_orthonormal_pair();
    let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
    BakeSurface {
        positions: corners.map(|(x, y)| centre + half_size * (x * s + y * t)).to_vec(),
        coordinates: corners
            .map(|(x, y)| offset + 0.5 * texels * (Vec2::new(x, y) + 1.0))
            .to_vec(),
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        ..BakeSurface::default()
    }
}

/// A single texel.
fn point(at: Vec3, normal: Vec3) -> Texels {
    let texels = covered_texels(&[patch(at, normal, 1e-3, 0.01, Vec2::splat(2.5))], UVec2::splat(5), 1);
    assert_eq!(texels.texels.len(), 1, "{texels:?}");
    texels
}

fn gather(gathering: &Gathering, texels: &Texels, samples: u32) -> Lightmaps {
    let mut light = Lightmaps::new(texels.texels.len());
    assert!(light.add(gathering, texels, samples, &AtomicBool::new(false)));
    assert_eq!(light.invalid, 0);
    light
}

/// The mean irradiance of all texels and its standard error.
fn mean(light: &Lightmaps) -> (f32, f32) {
    let (samples, texels) = (f64::from(light.samples()), light.texel_count() as f64);
    let of = |texel: usize| f64::from(luminance(light.light(texel)));
    let sum: f64 = (0..light.texel_count()).map(of).sum();
    let sums = (0..light.texel_count()).map(|texel| (texel, light.sum(texel)));
    let variances =
        sums.map(|(texel, sum)| (sum.luminance_squared / samples - of(texel).powi(2)).max(0.0) / (samples - 1.0));
    ((sum / texels) as f32, (variances.sum::<f64>().sqrt() / texels) as f32)
}

fn rectangle(half_size: Vec2, rotation: Quat, at: Vec3) -> Affine3A {
    Affine3A::from_scale_rotation_translation(half_size.extend(1.0), rotation, at)
}

const DOWN: f32 = PI / 2.0;
const UP: f32 = -PI / 2.0;

/// A lamp of 0.6 x 1 at height 0.8, of radiance 2.
fn add_lamp(scene: &mut SceneBuilder) {
    let place = rectangle(Vec2::new(0.3, 0.5), Quat::from_rotation_x(DOWN), Vec3::Y * 0.8);
    scene.add(Primitive::Rectangle, place, diffuse(0.0), Some(Rgb::splat(2.0)));
}

#[test]
fn a_rectangle_lights_a_point_by_its_form_factor() {
    let mut scene = SceneBuilder::default();
    add_lamp(&mut scene);
    let scene = scene.build();
    // Of a rectangle above the corner of which the point lies (Howell, factor B-4), four times.
    let (x, y) = (0.3f32 / 0.8, 0.5f32 / 0.8);
    let along = |x: f32, y: f32| x / (1.0 + x * x).sqrt() * (y / (1.0 + x * x).sqrt()).atan();
    let form_factor = 4.0 * (along(x, y) + along(y, x)) / (2.0 * PI);
    for strategy in [Strategy::Bsdf, Strategy::Light, Strategy::Mis] {
        let light = gather(
            &gathering(&scene, &settings(strategy)),
            &point(Vec3::ZERO, Vec3::Y),
            20_000,
        );
        assert_close(&format!("{strategy:?}"), mean(&light), 2.0 * PI * form_factor);
    }
    let below = gather(
        &gathering(&scene, &settings(Strategy::Mis)),
        &point(Vec3::ZERO, Vec3::NEG_Y),
        100,
    );
    assert_eq!(mean(&below).0, 0.0);
}

#[test]
fn all_light_of_a_lamp_is_found_on_the_walls() {
    let intensity = 0.7;
    let mut scene = SceneBuilder::default();
    scene.light(LightSource::Point {
        position: Vec3::new(0.2, -0.3, 0.1),
        intensity: Rgb::splat(intensity),
    });
    let scene = scene.build();
    let texels = 64.0;
    let walls = [Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::NEG_Y, Vec3::Z, Vec3::NEG_Z];
    let walls: Vec<BakeSurface> = (0..)
        .zip(walls)
        .map(|(number, outwards)| {
            let offset = Vec2::new(4.0 + 70.0 * (number % 3) as f32, 4.0 + 70.0 * (number / 3) as f32);
            patch(outwards, -outwards, 1.0, texels, offset)
        })
        .collect();
    let found = covered_texels(&walls, UVec2::new(214, 144), 1);
    let light = gather(&gathering(&scene, &settings(Strategy::Mis)), &found, 1);
    let is_whole = |place: UVec2| {
        let within = (place.as_vec2() + 0.5 - 4.0) % 70.0;
        within.max_element() < texels
    };
    let whole: Vec<usize> = (0..found.texels.len())
        .filter(|&texel| found.texels[texel].place.min_element() >= 4 && is_whole(found.texels[texel].place))
        .collect();
    assert_eq!(whole.len(), 6 * 64 * 64);
    let area = (2.0 / texels).powi(2);
    let flux: f32 = whole.iter().map(|&texel| area * light.light(texel).x).sum();
    assert!((flux / (4.0 * PI * intensity) - 1.0).abs() < 1e-3, "{flux}");
}

#[test]
fn a_closed_furnace_sends_pi_times_its_radiance() {
    for albedo in [0.0, 0.5, 0.8] {
        let mut scene = SceneBuilder::default();
        scene
            .add(Primitive::Sphere, Affine3A::IDENTITY, diffuse(albedo), Some(Rgb::ONE))
            .flip_normals = true;
        let scene = scene.build();
        let texels = covered_texels(
            &[patch(
                Vec3::new(0.1, 0.2, 0.0),
                Vec3::new(0.6, 0.8, 0.0),
                0.3,
                4.0,
                Vec2::splat(2.0),
            )],
            UVec2::splat(8),
            1,
        );
        let light = gather(&gathering(&scene, &settings(Strategy::Mis)), &texels, 400);
        assert_close(&format!("albedo {albedo}"), mean(&light), PI / (1.0 - albedo));
    }
}

/// A lamp above a floor with a wall beside it.
fn corner() -> RenderScene {
    let mut scene = SceneBuilder::default();
    add_lamp(&mut scene);
    let floor = rectangle(Vec2::splat(2.0), Quat::from_rotation_x(UP), Vec3::ZERO);
    scene.add(Primitive::Rectangle, floor, diffuse(0.6), None);
    let wall = rectangle(Vec2::splat(2.0), Quat::from_rotation_y(PI / 2.0), Vec3::X * -0.7);
    scene.add(Primitive::Rectangle, wall, diffuse(0.8), None);
    scene.light(LightSource::Point {
        position: Vec3::new(0.5, 0.5, 0.5),
        intensity: Rgb::splat(0.3),
    });
    scene.build()
}

#[test]
fn a_lightmap_shows_what_the_path_tracer_sees() {
    let scene = corner();
    let looking = view(
        camera(Vec3::new(2.0, 0.6, 0.4), Vec3::ZERO, 0.05),
        4,
        u32::MAX,
        Strategy::Mis,
    );
    let (seen, seen_error) = mean_luminance(&render(&scene, &looking, 4000));
    let texels = point(Vec3::ZERO, Vec3::Y);
    let (light, error) = mean(&gather(&gathering(&scene, &settings(Strategy::Mis)), &texels, 60_000));
    let factor = 0.6 / PI;
    let both = (factor * light, (factor * error).hypot(seen_error));
    assert_close("the floor", both, seen);

    let view = settings(Strategy::Mis);
    let without = Gathering {
        light: ReceivedLight::WithoutDelta,
        ..gathering(&scene, &view)
    };
    let (rest, rest_error) = mean(&gather(&without, &texels, 60_000));
    let direct = 0.3 * 0.5 / 0.75f32.powf(1.5);
    assert_close("without the lamp", (light - rest, error.hypot(rest_error)), direct);
}

#[test]
fn threads_and_rounds_change_no_bit() {
    let scene = corner();
    let texels = covered_texels(
        &[patch(Vec3::ZERO, Vec3::Y, 1.0, 24.0, Vec2::splat(2.0))],
        UVec2::splat(28),
        1,
    );
    let view = settings(Strategy::Mis);
    let gathering = gathering(&scene, &view);
    let with = |threads: usize, rounds: &[u32]| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .expect("threads");
        let mut light = Lightmaps::new(texels.texels.len());
        pool.install(|| {
            for &samples in rounds {
                assert!(light.add(&gathering, &texels, samples, &AtomicBool::new(false)));
            }
        });
        light
    };
    let one = with(1, &[7]);
    assert!(one == with(4, &[7]));
    assert!(one == with(3, &[1, 1, 2, 3]));
    let mut light = Lightmaps::new(texels.texels.len());
    assert!(!light.add(&gathering, &texels, 1, &AtomicBool::new(true)));
    assert_eq!((light.samples(), light.rays), (0, 0));
}

#[test]
fn no_light_leaks_through_a_wall_into_a_dark_room() {
    let mut scene = SceneBuilder::default();
    let cube = || {
        let blas = sunroom::accel::Blas::build(std::sync::Arc::new(unit_cube()), sunroom::accel::SplitMethod::Sah);
        Primitive::Mesh(std::sync::Arc::new(blas))
    };
    let rooms = Affine3A::from_scale(Vec3::new(2.0, 1.0, 1.0));
    scene.add(cube(), rooms, diffuse(0.5), None).flip_normals = true;
    // Four texels thick.
    let wall = Affine3A::from_scale(Vec3::new(0.1, 1.1, 1.1));
    scene.add(cube(), wall, diffuse(0.5), None);
    let lamp = rectangle(Vec2::splat(0.3), Quat::from_rotation_x(DOWN), Vec3::new(-1.0, 0.9, 0.0));
    scene.add(Primitive::Rectangle, lamp, diffuse(0.0), Some(Rgb::ONE));
    let scene = scene.build();
    let corners = [(-2.0, 1.0), (2.0, 1.0), (2.0, -1.0), (-2.0, -1.0)];
    let floor = BakeSurface {
        positions: corners.map(|(x, z)| Vec3::new(x, -1.0, z)).to_vec(),
        coordinates: corners.map(|(x, z)| Vec2::new(x + 2.2, z + 1.2) * 20.0).to_vec(),
        // Row by row from the far end.
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        ..BakeSurface::default()
    };
    let texels = covered_texels(&[floor], UVec2::new(88, 48), 1);
    let light = gather(&gathering(&scene, &settings(Strategy::Mis)), &texels, 64);
    let picture = finish(&texels, 0, &light, &[], None).expect("nothing is denoised");
    let row: Vec<f32> = (0..88).map(|x| picture.irradiance[24 * 88 + x].x).collect();
    // The wall is at columns 42 to 45.
    assert!(row[4..42].iter().all(|light| *light > 0.02), "{row:?}");
    let inside = row[40..44].windows(2).map(|two| two[1] / two[0]);
    assert!(
        inside.into_iter().all(|ratio| ratio > 0.7),
        "the wall is as bright as the floor beside it: {row:?}"
    );
    let dark = (46..88).flat_map(|x| (0..48).map(move |y| (x, y)));
    for (x, y) in dark {
        assert_eq!(picture.irradiance[y * 88 + x], Rgb::ZERO, "column {x}, row {y}");
    }
}

#[test]
fn sides_are_lit_where_light_comes() {
    let mut scene = SceneBuilder::default();
    add_lamp(&mut scene);
    let scene = scene.build();
    let view = settings(Strategy::Mis);
    let gathering = gathering(&scene, &view);
    let at = |height: f32| {
        [[
            Vec3::new(0.0, height, 0.0),
            Vec3::new(0.0, height, 1.0),
            Vec3::new(1.0, height, 0.0),
        ]]
    };
    let never = AtomicBool::new(false);
    assert_eq!(lit_sides(&gathering, &at(0.0), &never), (true, false));
    let turned = at(0.0).map(|[a, b, c]| [a, c, b]);
    assert_eq!(lit_sides(&gathering, &turned, &never), (false, true));
    assert_eq!(lit_sides(&gathering, &at(2.0), &never), (false, false));
    assert_eq!(lit_sides(&gathering, &[[Vec3::ZERO; 3]], &never), (false, false));
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
            ..Pbr::default()
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
    unwrap_level(writer, &settings, |_| lit).expect("a layout")
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
        let texels = covered_texels(std::slice::from_ref(surface), level.size, level.pages);
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
    let texels = covered_texels(&level.surfaces[4..], level.size, level.pages);
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
            for texel in covered_texels(&[alone], level.size, 1).texels {
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
    let error = unwrap_level(&mut writer, &UnwrapSettings::default(), |_| (true, true)).expect_err("no surface");
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

#[test]
fn shares_and_interruptions_change_no_bit() {
    let scene = corner();
    let texels = covered_texels(
        &[patch(Vec3::ZERO, Vec3::Y, 1.0, 24.0, Vec2::splat(2.0))],
        UVec2::splat(28),
        1,
    );
    let view = settings(Strategy::Mis);
    let gathering = gathering(&scene, &view);
    let never = AtomicBool::new(false);
    let whole = gather(&gathering, &texels, 50);
    // Block by block, as a job does that is cancelled in the middle of a round.
    let mut piecewise = Lightmaps::new(texels.texels.len());
    let mut calls = 0;
    while piecewise.reached() < 50 {
        let end = piecewise.round_end(50);
        piecewise.go_on(&gathering, &texels, end, 1, &never);
        calls += 1;
    }
    assert!(piecewise == whole && calls > 16, "{calls} calls");
    let mut merged = Lightmaps::new(texels.texels.len());
    for range in [0..16, 16..48, 48..50] {
        let mut share = Lightmaps::beginning_at(range.start, texels.texels.len());
        assert!(share.add(&gathering, &texels, range.end - range.start, &never));
        assert!(merged.append(share));
    }
    assert!(merged == whole);
    // Gaps and other texels are refused.
    assert!(!merged.append(Lightmaps::beginning_at(64, texels.texels.len())));
    assert!(!merged.append(Lightmaps::beginning_at(50, 3)));
}
