//! The cache for the parts of glTF files that cannot be written, or holds something else.

use std::path::{Path, PathBuf};

use crate::killed::gltf;
use crate::program::{Workshop, picture};
use crate::rendering::SHORT_FILES;
use crate::table::{Row, section};

section! { "The cache for parts of glTF files"
    cache_has_no_place:
        "No folder for the cache can be made, neither the user's own nor one for temporary files.",
        "`…a.gltf: mesh-0.ply cannot be kept: there is no folder where the parts of the file can be kept`, exit code 1.",
        "Nothing new.";
    cache_of_the_user_cannot_be_made:
        "The user's folder for caches cannot be made.",
        "Nothing, exit code 0.",
        "The picture, and the parts in the folder for temporary files.";
    there_is_no_home:
        "There is no home folder.",
        "Nothing, exit code 0.",
        "The picture, and the parts in the folder for temporary files.";
    cache_is_a_link:
        "A link to another folder stands in the place of the cache.",
        "Nothing, exit code 0.",
        "The picture, and the parts in the folder for temporary files. Nothing is written behind the link.";
    disk_is_full_for_a_part:
        "The disk becomes full while a part is written to the cache.",
        "`…a.gltf: mesh-0.ply cannot be kept: File too large (os error 27)`, exit code 1.",
        "No part, and no picture.";
    folder_for_temporary_files_is_shared:
        "There is no home folder, and another user has a folder `sunroom` for temporary files.",
        "Nothing, exit code 0.",
        "The picture, and the parts in a folder of the user's own, into which nobody else can look.";
    part_is_damaged:
        "A part in the cache is damaged: shorter, or as long with other bytes.",
        "Nothing, exit code 0.",
        "The picture, and the part as it should be.";
    part_belongs_to_another_file:
        "In the place of a part is what belongs to another file.",
        "Nothing, exit code 0.",
        "The picture, and the part as it should be.";
}

/// A workshop with a glTF file.
fn workshop() -> Workshop {
    let shop = Workshop::new();
    gltf(&shop);
    shop
}

const RENDER: [&str; 8] = ["render", "a.gltf", "-o", "a.png", "--size", "64x48", "--spp", "2"];

/// Renders the file with these places for caches, the user's own first.
fn render(shop: &Workshop, before: &[&str], cache: Option<&Path>, home: Option<&Path>) -> std::process::Output {
    let mut command = shop.command(before, &RENDER);
    for (variable, place) in [("XDG_CACHE_HOME", cache), ("HOME", home)] {
        match place {
            Some(place) => command.env(variable, place),
            None => command.env_remove(variable),
        };
    }
    crate::program::Running::start(&mut command).end()
}

/// The folder of the program in one for caches. In that for temporary files every user has one.
fn own_folder(caches: &Path) -> PathBuf {
    use std::os::unix::fs::MetadataExt;
    let user = std::fs::metadata(caches).map_or(0, |about| about.uid());
    let shared = caches.join(format!("sunroom-{user}"));
    if shared.exists() {
        shared
    } else {
        caches.join("sunroom")
    }
}

/// The parts below a folder for caches.
fn parts(caches: &Path) -> Vec<PathBuf> {
    let folders = std::fs::read_dir(own_folder(caches).join("gltf"))
        .into_iter()
        .flatten()
        .flatten();
    let parts = folders.map(|folder| folder.path().join("mesh-0.ply"));
    parts.filter(|part| part.is_file()).collect()
}

#[track_caller]
fn is_rendered_with_parts_in(shop: &Workshop, caches: &Path) {
    assert_eq!(picture(&shop.path("a.png")).dimensions(), (64, 48));
    assert_eq!(parts(caches).len(), 1);
}

fn cache_has_no_place(row: &Row) {
    let shop = workshop();
    std::fs::remove_dir(shop.path("tmp")).expect("it is empty");
    for name in ["cache", "home", "tmp"] {
        shop.write(name, "no folder");
    }
    let names = shop.names(".");
    row.holds(&render(&shop, &[], Some(&shop.path("cache")), Some(&shop.path("home"))));
    assert_eq!(shop.names("."), names);
}

fn cache_of_the_user_cannot_be_made(row: &Row) {
    let shop = workshop();
    for name in ["cache", "home"] {
        shop.write(name, "no folder");
    }
    row.holds(&render(&shop, &[], Some(&shop.path("cache")), Some(&shop.path("home"))));
    is_rendered_with_parts_in(&shop, &shop.path("tmp"));
}

fn there_is_no_home(row: &Row) {
    let shop = workshop();
    row.holds(&render(&shop, &[], None, None));
    is_rendered_with_parts_in(&shop, &shop.path("tmp"));
}

fn folder_for_temporary_files_is_shared(row: &Row) {
    use std::os::unix::fs::PermissionsExt;
    let shop = workshop();
    // Root could write into a folder of another user: a file stands for it.
    shop.write("tmp/sunroom", "of another");
    let folder = shop.path("tmp");
    row.holds(&render(&shop, &[], None, None));
    is_rendered_with_parts_in(&shop, &folder);
    let mode = std::fs::metadata(own_folder(&folder))
        .expect("it is there")
        .permissions()
        .mode();
    assert_eq!(mode & 0o077, 0);
}

fn cache_is_a_link(row: &Row) {
    let shop = workshop();
    for name in ["elsewhere", "cache/sunroom"] {
        std::fs::create_dir_all(shop.path(name)).expect("a temporary folder");
    }
    std::os::unix::fs::symlink(shop.path("elsewhere"), shop.path("cache/sunroom/gltf")).expect("a link");
    row.holds(&render(&shop, &[], Some(&shop.path("cache")), None));
    is_rendered_with_parts_in(&shop, &shop.path("tmp"));
    assert!(shop.names("elsewhere").is_empty());
}

fn disk_is_full_for_a_part(row: &Row) {
    let shop = workshop();
    let mut limited = SHORT_FILES;
    limited[3] = "--fsize=400";
    let output = render(&shop, &limited, Some(&shop.path("cache")), None);
    row.holds(&output);
    // The user knows nothing of the temporary file.
    assert!(!String::from_utf8_lossy(&output.stderr).contains("at path"));
    assert!(parts(&shop.path("cache")).is_empty());
    assert!(!shop.path("a.png").exists());
}

/// Renders, changes the part in the cache, and renders again.
fn with_changed_part(row: &Row, change: impl Fn(&[u8]) -> Vec<u8>) {
    let shop = workshop();
    let cache = shop.path("cache");
    row.holds(&render(&shop, &[], Some(&cache), None));
    is_rendered_with_parts_in(&shop, &cache);
    let part = parts(&cache).remove(0);
    let whole = std::fs::read(&part).expect("it is there");
    std::fs::write(&part, change(&whole)).expect("it can be written");
    row.holds(&render(&shop, &[], Some(&cache), None));
    is_rendered_with_parts_in(&shop, &cache);
    assert!(std::fs::read(&part).expect("it is there") == whole);
}

fn part_is_damaged(row: &Row) {
    with_changed_part(row, |whole| whole[..whole.len() / 2].to_vec());
    with_changed_part(row, |whole| {
        let mut changed = whole.to_vec();
        *changed.last_mut().expect("it is not empty") ^= 1;
        changed
    });
}

fn part_belongs_to_another_file(row: &Row) {
    let other = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement face 1\n\
                 property list uchar int vertex_indices\nend_header\n0 0 0\n9 0 0\n0 9 0\n3 0 1 2\n";
    with_changed_part(row, |_| other.into());
}
