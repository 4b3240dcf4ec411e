//! Drives the program over scenes whose files are no ordinary files. Each run must end with a message that names the
//! file.

use std::io::Read;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use crate::workshop::{Workshop, sunroom};

/// Far longer than any of these runs takes on a busy machine; only a run that never ends takes so long.
const PATIENCE: Duration = Duration::from_secs(300);

/// A scene with a camera, a light and `content`.
pub fn write_scene(shop: &Workshop, name: &str, content: &str) -> PathBuf {
    let text = format!(
        "<scene version='3.0.0'>
  <sensor type='perspective'>
    <transform name='to_world'><lookat origin='0,0,5' target='0,0,0' up='0,1,0'/></transform>
    <film type='hdrfilm'><integer name='width' value='8'/><integer name='height' value='8'/></film>
  </sensor>
  <emitter type='point'><point name='position' value='0,3,3'/></emitter>
  <shape type='sphere'/>
  {content}
</scene>"
    );
    shop.write(name, text)
}

pub struct Outcome {
    pub code: Option<i32>,
    pub stderr: String,
}

/// Runs the program in `folder`. A run that does not end fails the test.
#[track_caller]
pub fn run(folder: &Path, arguments: &[&str]) -> Outcome {
    run_with(folder, arguments, &[])
}

/// As [`run`], with these variables of the environment besides.
#[track_caller]
fn run_with(folder: &Path, arguments: &[&str], variables: &[(&str, &Path)]) -> Outcome {
    let mut child = sunroom()
        .args(arguments)
        .current_dir(folder)
        // No test may read or fill the user's own folders.
        .env("XDG_CACHE_HOME", folder)
        .env("SUNROOM_CONFIG", folder)
        .envs(variables.iter().copied())
        .env_remove("SUNROOM_MEMORY")
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the program starts");
    let mut pipe = child.stderr.take().expect("it is piped");
    let reader: JoinHandle<String> = std::thread::spawn(move || {
        let mut bytes = Vec::new();
        let _ = pipe.read_to_end(&mut bytes);
        String::from_utf8_lossy(&bytes).into_owned()
    });
    let begin = Instant::now();
    let status = loop {
        match child.try_wait().expect("the program can be waited for") {
            Some(status) => break Some(status),
            None if begin.elapsed() > PATIENCE => break None,
            None => std::thread::sleep(Duration::from_millis(20)),
        }
    };
    if status.is_none() {
        let _ = child.kill();
        let _ = child.wait();
    }
    let stderr = reader.join().expect("reading does not panic");
    let Some(status) = status else {
        panic!("{arguments:?} did not end\n{stderr}");
    };
    // Reports are broken into lines at a width that names of temporary folders may reach.
    let words = stderr.replace('│', " ");
    let words: Vec<&str> = words.split_whitespace().collect();
    Outcome {
        code: status.code(),
        stderr: words.join(" "),
    }
}

#[cfg(unix)]
mod devices {
    use super::*;

    const OBJ: &str = "mtllib pipe\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl a\nf 1 2 3\n";

    fn make_pipe(path: &Path) {
        let made = Command::new("mkfifo").arg(path).status().expect("mkfifo is there");
        assert!(made.success());
    }

    /// Each kind of reference to a pipe, a device and a link to a device. `name` stands for the file.
    #[test]
    fn references_to_devices_and_pipes_end_with_a_message() {
        let shop = Workshop::new();
        make_pipe(&shop.path("pipe"));
        std::os::unix::fs::symlink("/dev/zero", shop.path("zero.png")).expect("a link");
        let gltf = r#"{"asset":{"version":"2.0"},"buffers":[{"uri":"name","byteLength":36}],
            "bufferViews":[{"buffer":0,"byteLength":36}],"accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"}],
            "meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],"nodes":[{"mesh":0}],"scenes":[{"nodes":[0]}],"scene":0}"#;
        let texture = "<shape type='sphere'><bsdf type='diffuse'>
            <texture name='reflectance' type='bitmap'><string name='filename' value='name'/></texture></bsdf></shape>";
        let sky = "<emitter type='envmap'><string name='filename' value='name'/></emitter>";
        let obj = "<shape type='obj'><string name='filename' value='name'/></shape>";
        let ply = "<shape type='ply'><string name='filename' value='name'/></shape>";
        let include = "<include filename='name'/>";
        let spectrum = "<bsdf type='diffuse' id='b'><spectrum name='reflectance' filename='name'/></bsdf>";
        for (kind, content) in [
            ("texture", texture),
            ("sky", sky),
            ("obj", obj),
            ("ply", ply),
            ("include", include),
            ("spectrum", spectrum),
            ("glTF", gltf),
        ] {
            for (name, found) in [
                ("pipe", "is a pipe"),
                ("/dev/zero", "is a device"),
                ("zero.png", "is a device"),
            ] {
                let content = content.replace("name'/>", &format!("{name}'/>"));
                let content = content.replace("value='name'", &format!("value='{name}'"));
                let content = content.replace("filename='name'", &format!("filename='{name}'"));
                let content = content.replace("\"name\"", &format!("\"{name}\""));
                let scene = match kind {
                    "glTF" => shop.write("scene.gltf", content),
                    _ => write_scene(&shop, "scene.xml", &content),
                };
                let outcome = run(shop.folder(), &["check", "--strict", &scene.to_string_lossy()]);
                assert_eq!(outcome.code, Some(1), "{kind} {name}: {}", outcome.stderr);
                let said = &outcome.stderr;
                assert!(said.contains(found), "{kind} {name}: {said}");
            }
        }
        // A material library that cannot be read is a warning.
        for name in ["pipe", "zero.png"] {
            shop.write("uses-library.obj", OBJ.replace("pipe", name));
            write_scene(&shop, "scene.xml", &obj.replace("name'/>", "uses-library.obj'/>"));
            let outcome = run(shop.folder(), &["check", "scene.xml"]);
            assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
            let expected = format!("the material library `{name}` cannot be read: is a ");
            assert!(outcome.stderr.contains(&expected), "{}", outcome.stderr);
        }
    }

    #[test]
    fn files_of_the_command_line_may_not_be_devices_either() {
        let shop = Workshop::new();
        make_pipe(&shop.path("pipe"));
        shop.write("mesh.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
        let scene = write_scene(&shop, "scene.xml", "");
        let scene = scene.to_string_lossy();
        for name in ["pipe", "/dev/zero"] {
            for arguments in [
                &["check", name][..],
                &["render", name, "-o", "out.png"],
                &["convert", name, "out.xml"],
                &["bench", &scene, "--against", name],
                &["bench", "rays", "--mesh", "mesh.obj", "--rays", name],
            ] {
                let outcome = run(shop.folder(), arguments);
                assert_eq!(outcome.code, Some(1), "{arguments:?}: {}", outcome.stderr);
                let said = &outcome.stderr;
                let found = ["is a pipe", "is a device"].iter().any(|found| said.contains(found));
                assert!(found, "{arguments:?}: {said}");
            }
        }
    }
}

mod memory {
    use super::*;
    use flate2::Compression;
    use flate2::write::ZlibEncoder;
    use std::io::Write;
    use sunroom::color::Rgb;
    use sunroom::files::ExrCompression;
    use sunroom::render::image_io::exr::encode_exr;
    use sunroom::render::layered_image::LayeredImage;

    /// A black picture of `side` x `side` bytes, which packs to a thousandth.
    fn png(side: u32) -> Vec<u8> {
        let mut bytes = std::io::Cursor::new(Vec::new());
        let black = image::GrayImage::new(side, side);
        black
            .write_to(&mut bytes, image::ImageFormat::Png)
            .expect("memory can be written to");
        bytes.into_inner()
    }

    /// A file of Mitsuba's format with so many vertices in the origin, and one triangle.
    fn serialized(vertices: u64) -> Vec<u8> {
        let mut content = 0x1000u32.to_le_bytes().to_vec();
        content.push(0);
        content.extend(vertices.to_le_bytes());
        content.extend(1u64.to_le_bytes());
        content.resize(content.len() + 12 * vertices as usize, 0);
        for corner in [0u32, 1, 2] {
            content.extend(corner.to_le_bytes());
        }
        let mut file = vec![0x1c, 0x04, 0x04, 0x00];
        let mut encoder = ZlibEncoder::new(Vec::new(), Compression::best());
        encoder.write_all(&content).expect("memory can be written to");
        file.extend(encoder.finish().expect("memory can be written to"));
        file.extend(0u64.to_le_bytes());
        file.extend(1u32.to_le_bytes());
        file
    }

    fn texture(name: &str) -> String {
        format!(
            "<shape type='sphere'><bsdf type='diffuse'><texture name='reflectance' type='bitmap'>
             <string name='filename' value='{name}'/></texture></bsdf></shape>"
        )
    }

    /// A black picture of floats, which packs to less than a thousandth.
    fn exr(side: u32) -> Vec<u8> {
        let mut image = LayeredImage::new(side, side);
        image.add_rgb("", &vec![Rgb::ZERO; (side * side) as usize]);
        encode_exr(&image, ExrCompression::Zip).expect("memory can be written to")
    }

    /// A grid of one active tile, a cube of 4096 voxels along an edge.
    fn vdb() -> Vec<u8> {
        let sized = |text: &str| [&(text.len() as u32).to_le_bytes()[..], text.as_bytes()].concat();
        let mut file = 0x5644_4220u64.to_le_bytes().to_vec();
        for number in [224u32, 12, 0] {
            file.extend(number.to_le_bytes());
        }
        file.push(1);
        file.extend([b'0'; 36]);
        // No metadata, one grid.
        file.extend([0u32.to_le_bytes(), 1u32.to_le_bytes()].concat());
        file.extend([sized("density"), sized("Tree_float_5_4_3"), sized("")].concat());
        let mut grid = [0u32.to_le_bytes(), 0u32.to_le_bytes()].concat();
        grid.extend(sized("UniformScaleMap"));
        grid.extend([1.0f64; 15].map(f64::to_le_bytes).concat());
        // One buffer, the background, one tile and no children; the place of the tile, its value, and that it is
        // active.
        grid.extend(1u32.to_le_bytes());
        grid.extend(0.0f32.to_le_bytes());
        for number in [1u32, 0, 0, 0, 0] {
            grid.extend(number.to_le_bytes());
        }
        grid.extend(1.0f32.to_le_bytes());
        grid.push(1);
        let at = file.len() as u64 + 24;
        for place in [at, at, at + grid.len() as u64] {
            file.extend(place.to_le_bytes());
        }
        file.extend(grid);
        file
    }

    #[test]
    fn files_that_unpack_to_more_than_the_budget_are_refused() {
        let shop = Workshop::new();
        let folder = shop.folder();
        shop.write("bomb.png", png(5000));
        shop.write("bomb.serialized", serialized(1_000_000));
        let packed = exr(2000);
        assert!(packed.len() < 200_000, "{}", packed.len());
        shop.write("bomb.exr", packed);
        shop.write("bomb.vdb", vdb());
        let smoke = "<shape type='cube'><bsdf type='null'/><medium type='heterogeneous' name='interior'>
            <volume type='vdbvolume' name='sigma_t'><string name='filename' value='bomb.vdb'/></volume></medium></shape>";
        let mesh = "<shape type='serialized'><string name='filename' value='bomb.serialized'/></shape>";
        for (content, found) in [
            (
                texture("bomb.png"),
                ["bomb.png: 5000 x 5000 pixels need 25.0 MB", "the budget is 20.0 MB"],
            ),
            (
                mesh.to_owned(),
                [
                    "bomb.serialized: 1000000 vertices and 1 triangles need 36.0 MB",
                    "--memory SIZE",
                ],
            ),
            (
                texture("bomb.exr"),
                ["bomb.exr: 2000 x 2000 pixels need", "the budget is 20.0 MB"],
            ),
            (
                smoke.to_owned(),
                [
                    "bomb.vdb: the grid `density` has 4098 x 4098 x 4098 voxels, which need 275",
                    "the budget is 20.0 MB",
                ],
            ),
        ] {
            write_scene(&shop, "scene.xml", &content);
            let outcome = run(folder, &["check", "--strict", "--memory", "20MB", "scene.xml"]);
            assert_eq!(outcome.code, Some(1), "{}", outcome.stderr);
            for found in found {
                assert!(outcome.stderr.contains(found), "{}", outcome.stderr);
            }
        }
        write_scene(&shop, "scene.xml", &texture("bomb.png"));
        let outcome = run(folder, &["check", "--strict", "--memory", "30MB", "scene.xml"]);
        assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    }

    /// Each object of three bytes would take more than a kilobyte.
    #[test]
    fn objects_of_a_model_count_in_the_budget() {
        let shop = Workshop::new();
        let materials = vec!["{}"; 100_000].join(",");
        shop.write(
            "many.gltf",
            format!(r#"{{"asset": {{"version": "2.0"}}, "materials": [{materials}]}}"#),
        );
        let outcome = run(shop.folder(), &["check", "--memory", "20MB", "many.gltf"]);
        assert_eq!(outcome.code, Some(1), "{}", outcome.stderr);
        let expected = "the objects of the file need";
        assert!(outcome.stderr.contains(expected), "{}", outcome.stderr);
    }

    /// Their content is not read, or the process would need all of it in memory.
    #[test]
    fn files_longer_than_the_budget_are_refused() {
        let shop = Workshop::new();
        let folder = shop.folder();
        let mesh = |name: &str| format!("<shape type='ply'><string name='filename' value='{name}'/></shape>");
        for (name, content) in [("hole.png", texture("hole.png")), ("hole.ply", mesh("hole.ply"))] {
            let file = std::fs::File::create(folder.join(name)).expect("a file");
            file.set_len(30 << 30).expect("a file with a hole");
            write_scene(&shop, "scene.xml", &content);
            let outcome = run(folder, &["check", "--memory", "20MB", "scene.xml"]);
            assert_eq!(outcome.code, Some(1), "{}", outcome.stderr);
            let expected = "is larger than the memory budget of 20.0 MB; `--memory SIZE`";
            assert!(outcome.stderr.contains(expected), "{}", outcome.stderr);
        }
    }

    #[test]
    fn pictures_that_fit_one_by_one_must_also_fit_together() {
        let shop = Workshop::new();
        let folder = shop.folder();
        for name in ["a.png", "b.png", "c.png"] {
            shop.write(name, png(3000));
        }
        let all = ["a.png", "b.png", "c.png"].map(texture).concat();
        write_scene(&shop, "scene.xml", &all);
        let outcome = run(folder, &["check", "--strict", "--memory", "20MB", "scene.xml"]);
        assert_eq!(outcome.code, Some(1), "{}", outcome.stderr);
        let refused = outcome.stderr.matches("3000 x 3000 pixels need 9.0 MB").count();
        assert_eq!(refused, 1, "{}", outcome.stderr);
        assert!(outcome.stderr.contains("other data take 18.0 MB"), "{}", outcome.stderr);
        let outcome = run(folder, &["check", "--strict", "--memory", "28MB", "scene.xml"]);
        assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    }

    #[test]
    fn a_film_larger_than_the_budget_is_refused() {
        let shop = Workshop::new();
        let folder = shop.folder();
        write_scene(&shop, "scene.xml", "");
        let arguments = [
            "render",
            "scene.xml",
            "-o",
            "out.png",
            "--spp",
            "1",
            "--size",
            "1000x1000",
        ];
        let outcome = run(folder, &[&arguments[..], &["--memory", "50MB"]].concat());
        assert_eq!(outcome.code, Some(1), "{}", outcome.stderr);
        assert!(
            outcome.stderr.contains("a film of 1000 x 1000 pixels needs"),
            "{}",
            outcome.stderr
        );
        assert!(!shop.path("out.png").exists());
        let outcome = run(
            folder,
            &["render", "scene.xml", "-o", "out.png", "--spp", "1", "--memory", "50MB"],
        );
        assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    }

    /// Pictures of integers are rarely environments, so that the tables for sampling one are counted when it is used as
    /// one.
    #[test]
    fn what_sampling_an_environment_takes_counts() {
        let shop = Workshop::new();
        shop.write("sky.png", png(1000));
        write_scene(
            &shop,
            "scene.xml",
            "<emitter type='envmap'><string name='filename' value='sky.png'/></emitter>",
        );
        let check = |memory| run(shop.folder(), &["check", "--strict", "--memory", memory, "scene.xml"]);
        let refused = check("8MB");
        assert_eq!(refused.code, Some(1), "{}", refused.stderr);
        assert!(
            refused.stderr.trim_end().ends_with("scene.xml: 1 error"),
            "{}",
            refused.stderr
        );
        let render = ["render", "scene.xml", "-o", "out.png", "--memory", "8MB"];
        for outcome in [refused, run(shop.folder(), &render)] {
            assert_eq!(outcome.code, Some(1), "{}", outcome.stderr);
            let said = &outcome.stderr;
            assert!(
                said.contains("error: scene.xml: emitter") && said.contains("--memory SIZE"),
                "{said}"
            );
            assert!(said.contains("sky.png needs 10.0 MB"), "{said}");
        }
        assert!(!shop.path("out.png").exists());
        let enough = check("30MB");
        assert_eq!(enough.code, Some(0), "{}", enough.stderr);
    }

    /// A mesh that is shown with its texture coordinates as in its file and flipped is there twice.
    #[test]
    fn a_copy_of_a_mesh_with_flipped_texture_coordinates_counts() {
        const TRIANGLES: usize = 20_000;
        let shop = Workshop::new();
        let vertices = "0 0 0 0 0\n1 0 0 1 0\n0 1 0 0 1\n";
        let mut mesh = format!(
            "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nproperty float u\n\
             property float v\nelement face {TRIANGLES}\nproperty list uchar int vertex_indices\nend_header\n{vertices}"
        );
        mesh += &"3 0 1 2\n".repeat(TRIANGLES);
        shop.write("mesh.ply", mesh);
        let shape = |flipped| {
            format!(
                "<shape type='ply'><string name='filename' value='mesh.ply'/>
                 <boolean name='flip_tex_coords' value='{flipped}'/></shape>"
            )
        };
        let both = shape(false) + &shape(true);
        let check = |memory| run(shop.folder(), &["check", "--strict", "--memory", memory, "scene.xml"]);
        write_scene(&shop, "scene.xml", &both);
        let refused = check("3MB");
        assert_eq!(refused.code, Some(1), "{}", refused.stderr);
        assert!(
            refused
                .stderr
                .contains("20000 triangles with flipped texture coordinates need"),
            "{}",
            refused.stderr
        );
        assert_eq!(check("30MB").code, Some(0));
        write_scene(&shop, "scene.xml", &shape(false));
        let once = check("3MB");
        assert_eq!(once.code, Some(0), "{}", once.stderr);
    }

    #[test]
    fn pictures_of_gltf_files_count_with_their_conversion() {
        let shop = Workshop::new();
        shop.write("bomb.png", png(1000));
        shop.write(
            "scene.gltf",
            r#"{"asset":{"version":"2.0"},"buffers":[{"uri":"data:;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA","byteLength":36}],
            "bufferViews":[{"buffer":0,"byteLength":36}],"accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"}],
            "images":[{"uri":"bomb.png"}],"textures":[{"source":0}],
            "materials":[{"pbrMetallicRoughness":{"metallicRoughnessTexture":{"index":0}}}],
            "meshes":[{"primitives":[{"attributes":{"POSITION":0},"material":0}]}],"nodes":[{"mesh":0}],"scenes":[{"nodes":[0]}],"scene":0}"#,
        );
        let outcome = run(shop.folder(), &["check", "--strict", "--memory", "20MB", "scene.gltf"]);
        assert_eq!(outcome.code, Some(1), "{}", outcome.stderr);
        assert!(
            outcome.stderr.contains("1000 x 1000 pixels need 29.0 MB"),
            "{}",
            outcome.stderr
        );
    }

    #[test]
    fn a_budget_that_is_no_size_is_wrong_usage() {
        let shop = Workshop::new();
        write_scene(&shop, "scene.xml", "");
        let outcome = run(shop.folder(), &["check", "--memory", "8", "scene.xml"]);
        assert_eq!(outcome.code, Some(2), "{}", outcome.stderr);
        assert!(outcome.stderr.contains("such as 8GB"), "{}", outcome.stderr);
    }
}

mod untrusted {
    use super::*;

    const SECRET: &str = "s3cret";
    const OBJ: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    const INSIDE: &str = "<bsdf type='diffuse' id='inside'/>";

    /// A folder `scene` with a scene, and files beside that folder that the scene must not read.
    fn shop() -> Workshop {
        let shop = Workshop::new();
        for folder in ["scene", "outside"] {
            shop.write(&format!("{folder}/mesh.obj"), OBJ);
            shop.write(
                &format!("{folder}/include.xml"),
                format!("<scene version='3.0.0'>{INSIDE}</scene>"),
            );
            shop.write(
                &format!("{folder}/picture.pfm"),
                b"PF\n1 1\n-1\n\0\0\0\0\0\0\0\0\0\0\0\0",
            );
            shop.write(&format!("{folder}/values.spd"), "400 0.5\n700 0.5\n");
            shop.write(&format!("{folder}/library.mtl"), "newmtl m\nKd 1 0 0\n");
            shop.write(
                &format!("{folder}/positions.bin"),
                TRIANGLE.map(f32::to_le_bytes).concat(),
            );
        }
        shop.write("outside/secret.xml", format!("{SECRET} <scene>"));
        shop.write(
            "outside/broken.xml",
            format!("<scene version='3.0.0'>\n  <nonsense/> <!-- {SECRET} -->\n</scene>"),
        );
        shop
    }

    const TRIANGLE: [f32; 9] = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0];

    fn gltf(uri: &str) -> String {
        format!(
            r#"{{"asset":{{"version":"2.0"}},"buffers":[{{"uri":"{uri}","byteLength":36}}],
            "bufferViews":[{{"buffer":0,"byteLength":36}}],"accessors":[{{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"}}],
            "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}}}}]}}],"nodes":[{{"mesh":0}}],"scenes":[{{"nodes":[0]}}],"scene":0}}"#
        )
    }

    /// For each kind of reference the content of a scene that has it; `NAME` stands for the file.
    const KINDS: [(&str, &str, &str); 7] = [
        ("include", "include.xml", "<include filename='NAME'/>"),
        (
            "mesh",
            "mesh.obj",
            "<shape type='obj'><string name='filename' value='NAME'/></shape>",
        ),
        (
            "texture",
            "picture.pfm",
            "<shape type='sphere'><bsdf type='diffuse'><texture name='reflectance' type='bitmap'>
             <string name='filename' value='NAME'/></texture></bsdf></shape>",
        ),
        (
            "sky",
            "picture.pfm",
            "<emitter type='envmap'><string name='filename' value='NAME'/></emitter>",
        ),
        (
            "spectrum",
            "values.spd",
            "<shape type='sphere'><bsdf type='diffuse'><spectrum name='reflectance' filename='NAME'/></bsdf></shape>",
        ),
        (
            "library",
            "library.mtl",
            "<shape type='obj'><string name='filename' value='uses.obj'/></shape>",
        ),
        ("glTF buffer", "positions.bin", ""),
    ];

    /// Checks a scene in the folder `scene` that refers to `name`.
    fn check(shop: &Workshop, kind: &str, content: &str, name: &str, arguments: &[&str]) -> Outcome {
        shop.write("scene/uses.obj", format!("mtllib {name}\nusemtl m\n{OBJ}"));
        let scene = match kind {
            "glTF buffer" => shop.write("scene/scene.gltf", gltf(name)),
            _ => write_scene(shop, "scene/scene.xml", &content.replace("NAME", name)),
        };
        let scene = scene.to_string_lossy();
        run(shop.folder(), &[&["check", "--strict", &scene], arguments].concat())
    }

    #[test]
    fn nothing_outside_the_scenes_folder_is_read() {
        let shop = shop();
        for (kind, file, content) in KINDS {
            let absolute = shop.path("outside").join(file);
            let link = shop.path("scene/link");
            let _ = std::fs::remove_file(&link);
            #[cfg(unix)]
            std::os::unix::fs::symlink(&absolute, &link).expect("a link");
            #[cfg(not(unix))]
            std::fs::write(&link, "").expect("a writable folder");
            let mut names = vec![
                format!("../outside/{file}"),
                format!("../scene/../outside/{file}"),
                "../outside/nothing".to_owned(),
            ];
            // URIs and the names in OBJ files are relative.
            if !matches!(kind, "glTF buffer" | "library") {
                names.push(absolute.to_string_lossy().into_owned());
            }
            if cfg!(unix) {
                names.push("link".to_owned());
            }
            for name in names {
                let outcome = check(&shop, kind, content, &name, &["--untrusted"]);
                assert_eq!(outcome.code, Some(1), "{kind} {name}: {}", outcome.stderr);
                assert!(
                    outcome.stderr.contains("outside the scene's folder"),
                    "{kind} {name}: {}",
                    outcome.stderr
                );
            }
            let inside = check(&shop, kind, content, file, &["--untrusted"]);
            assert_eq!(inside.code, Some(0), "{kind}: {}", inside.stderr);
            let trusted = check(&shop, kind, content, &format!("../outside/{file}"), &[]);
            assert_eq!(trusted.code, Some(0), "{kind}: {}", trusted.stderr);
        }
    }

    /// Nobody learns from a run whether there is such a file. Grey takes the place of a picture, as of one that is not
    /// there.
    #[test]
    fn what_is_refused_counts_the_same_whether_it_exists_or_not() {
        let shop = shop();
        for (kind, file, content) in KINDS {
            if matches!(kind, "library" | "glTF buffer") {
                continue;
            }
            let codes = [file, "nothing"].map(|name| {
                let scene = write_scene(
                    &shop,
                    "scene/scene.xml",
                    &content.replace("NAME", &format!("../outside/{name}")),
                );
                let outcome = run(shop.folder(), &["check", "--untrusted", &scene.to_string_lossy()]);
                assert!(
                    outcome.stderr.contains("outside the scene's folder"),
                    "{}",
                    outcome.stderr
                );
                outcome.code
            });
            let is_picture = matches!(kind, "texture" | "sky");
            assert_eq!(codes, [Some(i32::from(!is_picture)); 2], "{kind}");
        }
    }

    /// A run of the program with these arguments, with and without the file or folder `there`: what it said, and what
    /// it wrote to `out.xml`.
    #[cfg(unix)]
    fn with_and_without(
        shop: &Workshop,
        there: &str,
        arguments: &[&str],
    ) -> [(Option<i32>, String, Option<String>); 2] {
        let (place, aside) = (shop.path(there), shop.path("aside"));
        [true, false].map(|is_there| {
            if !is_there {
                std::fs::rename(&place, &aside).expect("it is there");
            }
            let _ = std::fs::remove_file(shop.path("out.xml"));
            let outcome = run(shop.folder(), &[arguments, &["--untrusted"]].concat());
            if !is_there {
                std::fs::rename(&aside, &place).expect("it was moved");
            }
            let written = std::fs::read_to_string(shop.path("out.xml")).ok();
            (outcome.code, outcome.stderr, written)
        })
    }

    #[cfg(unix)]
    #[test]
    fn a_link_does_not_tell_whether_it_leads_to_a_file() {
        use std::os::unix::fs::symlink;
        let shop = shop();
        for (kind, file, content) in KINDS {
            let links = ["direct", "chain", "folder"].map(|name| shop.path("scene").join(name));
            let targets = [
                format!("../outside/{file}"),
                "direct".to_owned(),
                "../outside".to_owned(),
            ];
            for (link, target) in links.iter().zip(targets) {
                let _ = std::fs::remove_file(link);
                symlink(target, link).expect("a link");
            }
            for (name, there) in [
                ("direct".to_owned(), format!("outside/{file}")),
                ("chain".to_owned(), format!("outside/{file}")),
                (format!("folder/{file}"), "outside".to_owned()),
            ] {
                // Writes the scene.
                check(&shop, kind, content, &name, &["--untrusted"]);
                let scene = match kind {
                    "glTF buffer" => "scene/scene.gltf",
                    _ => "scene/scene.xml",
                };
                let [with, without] = with_and_without(&shop, &there, &["check", scene]);
                assert_eq!(with, without, "{kind} {name}");
                assert!(
                    with.1.contains("outside the scene's folder"),
                    "{kind} {name}: {}",
                    with.1
                );
            }
        }
    }

    #[cfg(unix)]
    #[test]
    fn a_way_out_and_back_in_does_not_tell_whether_it_exists() {
        let shop = shop();
        std::fs::create_dir(shop.path("empty")).expect("a writable folder");
        std::os::unix::fs::symlink(shop.path("scene"), shop.path("lnk")).expect("a link");
        for (kind, file, content) in KINDS {
            for (name, there) in [
                (format!("../empty/../scene/{file}"), "empty"),
                (format!("../lnk/{file}"), "lnk"),
            ] {
                // Writes the scene.
                check(&shop, kind, content, &name, &["--untrusted"]);
                let scene = match kind {
                    "glTF buffer" => "scene/scene.gltf",
                    _ => "scene/scene.xml",
                };
                let [with, without] = with_and_without(&shop, there, &["check", scene]);
                assert_eq!(with, without, "{kind} {name}");
                let said = with.1;
                assert!(said.contains("outside the scene's folder"), "{kind} {name}: {said}");
            }
        }
    }

    #[cfg(unix)]
    #[test]
    fn a_converted_scene_does_not_tell_whether_there_is_a_file() {
        let shop = shop();
        shop.write("assets/key.pfm", b"PF\n1 1\n-1\n\0\0\0\0\0\0\0\0\0\0\0\0");
        let texture = KINDS[2].2;
        for name in ["key.pfm", "../assets/key.pfm"] {
            write_scene(&shop, "scene/scene.xml", &texture.replace("NAME", name));
            let convert = ["convert", "scene/scene.xml", "out.xml"];
            let [with, without] = with_and_without(&shop, "assets/key.pfm", &convert);
            assert_eq!(with, without, "{name}");
            assert_eq!(with.0, Some(0), "{}", with.1);
            assert!(with.2.is_some(), "{}", with.1);
        }
    }

    /// The folder `lnk` leads to may not be read off a message or a converted scene.
    #[cfg(unix)]
    #[test]
    fn nobody_learns_where_a_link_outside_leads() {
        let shop = shop();
        std::fs::create_dir_all(shop.path("hidden/deep")).expect("a writable folder");
        std::os::unix::fs::symlink(shop.path("hidden/deep"), shop.path("lnk")).expect("a link");
        shop.write(
            "scene/library.mtl",
            "newmtl m\nKd 1 0 0\nmap_Kd ../lnk/../none/key.png\n",
        );
        shop.write("scene/uses.obj", format!("mtllib library.mtl\nusemtl m\n{OBJ}"));
        let library = KINDS[5];
        for (kind, _, content) in [KINDS[1], KINDS[2], KINDS[3], library] {
            // The second has a place besides in which the scene may look.
            for folders in ["", "<path value='.'/>"] {
                let content = content.replace("NAME", "../lnk/../none/key.png");
                write_scene(&shop, "scene/scene.xml", &format!("{folders}{content}"));
                for arguments in [
                    &["check", "scene/scene.xml"][..],
                    &["convert", "scene/scene.xml", "out.xml"],
                ] {
                    let [with, without] = with_and_without(&shop, "lnk", arguments);
                    assert_eq!(with, without, "{kind} {arguments:?}");
                    assert!(
                        with.1.contains("lnk/../none/key.png"),
                        "{kind} {arguments:?}: {}",
                        with.1
                    );
                    let text = with.1 + with.2.as_deref().unwrap_or_default();
                    assert!(!text.contains("hidden"), "{kind} {arguments:?}: {text}");
                }
            }
        }
    }

    /// The cache for parts of glTF files may be read, but not what somebody else has put in a place where it could be.
    #[cfg(unix)]
    #[test]
    fn a_link_in_the_place_of_a_cache_permits_nothing() {
        use std::os::unix::fs::MetadataExt;
        let shop = shop();
        let user = shop.folder().metadata().expect("it is there").uid();
        let own = shop.path(&format!("tmp/sunroom-{user}"));
        std::fs::create_dir_all(&own).expect("a writable folder");
        std::os::unix::fs::symlink("/", own.join("gltf")).expect("a link");
        let scene = shop.write("scene/scene.gltf", gltf("../outside/positions.bin"));
        let outcome = run_with(
            shop.folder(),
            &["check", "--untrusted", &scene.to_string_lossy()],
            &[("TMPDIR", &shop.path("tmp"))],
        );
        assert_eq!(outcome.code, Some(1), "{}", outcome.stderr);
        assert!(
            outcome.stderr.contains("outside the scene's folder"),
            "{}",
            outcome.stderr
        );
    }

    #[test]
    fn search_folders_must_lie_inside() {
        let shop = shop();
        let content = "<path value='../outside'/><shape type='obj'><string name='filename' value='mesh.obj'/></shape>";
        let outcome = check(&shop, "path", content, "", &["--untrusted"]);
        assert_eq!(outcome.code, Some(1), "{}", outcome.stderr);
        assert!(
            outcome.stderr.contains("outside the scene's folder"),
            "{}",
            outcome.stderr
        );
        assert_eq!(check(&shop, "path", content, "", &[]).code, Some(0));
    }

    #[test]
    fn render_and_convert_know_the_option() {
        let shop = shop();
        write_scene(&shop, "scene/scene.xml", "<include filename='../outside/include.xml'/>");
        for arguments in [
            &["render", "scene/scene.xml", "--spp", "1", "-o", "out.png"][..],
            &["convert", "scene/scene.xml", "out.xml"],
        ] {
            let outcome = run(shop.folder(), &[arguments, &["--untrusted"]].concat());
            assert_eq!(outcome.code, Some(1), "{}", outcome.stderr);
            assert!(
                outcome.stderr.contains("outside the scene's folder"),
                "{}",
                outcome.stderr
            );
            let outcome = run(shop.folder(), arguments);
            assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
        }
    }

    /// Messages quote the lines of the scene's own file, which must not be one that lies elsewhere.
    #[cfg(unix)]
    #[test]
    fn a_scene_that_is_a_link_to_a_file_elsewhere_is_not_read() {
        let shop = shop();
        let link = shop.path("scene/link.xml");
        for name in ["secret.xml", "broken.xml"] {
            let _ = std::fs::remove_file(&link);
            std::os::unix::fs::symlink(shop.path("outside").join(name), &link).expect("a link");
            for arguments in [
                &["check", "scene/link.xml"][..],
                &["render", "scene/link.xml", "-o", "out.png"],
                &["convert", "scene/link.xml", "out.xml"],
            ] {
                let outcome = run(shop.folder(), &[arguments, &["--untrusted"]].concat());
                let said = &outcome.stderr;
                assert_eq!(outcome.code, Some(1), "{said}");
                assert!(said.contains("link.xml: lies outside the scene's folder"), "{said}");
                assert!(!said.contains(SECRET), "{said}");
            }
            let trusted = run(shop.folder(), &["check", "scene/link.xml"]);
            assert!(trusted.stderr.contains(SECRET), "{}", trusted.stderr);
        }
        // A link within the folder is no way out.
        let _ = std::fs::remove_file(&link);
        write_scene(&shop, "scene/scene.xml", "");
        std::os::unix::fs::symlink(shop.path("scene/scene.xml"), &link).expect("a link");
        let inside = run(shop.folder(), &["check", "scene/link.xml", "--untrusted"]);
        assert_eq!(inside.code, Some(0), "{}", inside.stderr);
    }

    #[test]
    fn text_of_foreign_files_is_not_shown() {
        let shop = shop();
        shop.write("outside/secret.spd", format!("{SECRET}:x:0:0\n"));
        shop.write("outside/secret.obj", format!("v {SECRET} 0 0\n"));
        shop.write("outside/secret.ply", format!("ply\n{SECRET}\n"));
        shop.write("outside/odd.obj", format!("{OBJ}{SECRET}`{SECRET} 1\n"));
        shop.write("outside/secret.mtl", format!("newmtl m\nKd {SECRET}\n"));
        for (kind, name, found) in [
            ("include", "secret.xml", "is not XML"),
            ("include", "broken.xml", "broken.xml:2:"),
            ("spectrum", "secret.spd", "expected lines of a wavelength and a value"),
            ("mesh", "secret.obj", "line 1: expected three coordinates"),
            ("mesh", "secret.ply", "line 2: expected a statement of a PLY header"),
            ("mesh", "odd.obj", "line 5: the statement … is ignored"),
            ("library", "secret.mtl", "line 2: … is not understood"),
        ] {
            let (_, _, content) = KINDS.into_iter().find(|row| row.0 == kind).expect("it is a kind");
            let name = format!("../outside/{name}");
            let outcome = check(&shop, kind, content, &name, &[]);
            assert_eq!(outcome.code, Some(1), "{}", outcome.stderr);
            assert!(outcome.stderr.contains(found), "{name}: {}", outcome.stderr);
            assert!(!outcome.stderr.contains(SECRET), "{name}: {}", outcome.stderr);
            if kind == "mesh" {
                let scene = shop.path("scene/scene.xml");
                let convert = ["convert", "--strict", &scene.to_string_lossy(), "out.xml"];
                let outcome = run(shop.folder(), &convert);
                assert!(outcome.stderr.contains(found), "{name}: {}", outcome.stderr);
                assert!(!outcome.stderr.contains(SECRET), "{name}: {}", outcome.stderr);
            }
        }
        // Beside the scene it helps.
        shop.write("scene/secret.obj", format!("v {SECRET} 0 0\n"));
        let outcome = check(&shop, "mesh", KINDS[1].2, "secret.obj", &[]);
        assert!(outcome.stderr.contains(SECRET), "{}", outcome.stderr);
    }
}

/// A scene that names its files relative to itself is converted to another folder without the names of the folders
/// around both.
#[test]
fn converted_scenes_have_no_absolute_paths_that_nobody_gave() {
    let shop = Workshop::new();
    shop.write("from/lib/mesh.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    let shape = "<shape type='obj'><string name='filename' value='mesh.obj'/></shape>";
    write_scene(&shop, "from/scene.xml", &format!("<path value='lib'/>{shape}"));
    std::fs::create_dir(shop.path("to")).expect("a writable folder");
    let outcome = run(shop.folder(), &["convert", "from/scene.xml", "to/scene.xml"]);
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    let text = std::fs::read_to_string(shop.path("to/scene.xml")).expect("it was written");
    assert!(text.contains("../from/lib"), "{text}");
    assert!(!text.contains(&*shop.folder().to_string_lossy()), "{text}");
    let outcome = run(shop.folder(), &["check", "--strict", "to/scene.xml"]);
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
}
