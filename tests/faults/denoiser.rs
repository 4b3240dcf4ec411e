//! The denoiser without its library, or without the part of it that knows the processor.

use std::path::{Path, PathBuf};
use std::process::Command;

use crate::program::{Running, Workshop, picture, with_mounts};
use crate::table::{Row, section};

section! { "The denoiser"
    library_is_missing:
        "The denoiser's library is missing.",
        "From the system, before the program starts: `error while loading shared libraries: libOpenImageDenoise…`, exit code 127.",
        "Nothing new.";
    device_library_is_missing:
        "The denoiser's library for processors is missing.",
        "`error: the denoiser finds no processor that it can run on: …; the picture is not denoised`, exit code 1.",
        "The picture, not denoised.";
}

/// The folder of the library that the program loads; None (with a word) where the program has none.
fn library_folder() -> Option<PathBuf> {
    let listed = Command::new("ldd").arg(env!("CARGO_BIN_EXE_sunroom")).output().ok()?;
    let text = String::from_utf8_lossy(&listed.stdout).into_owned();
    let line = text.lines().find(|line| line.contains("libOpenImageDenoise.so"));
    let path = line.and_then(|line| line.split_whitespace().nth(2));
    let folder = path.and_then(|path| Some(Path::new(path).canonicalize().ok()?.parent()?.to_owned()));
    if folder.is_none() {
        println!("skipped: this program was built without the denoiser");
    }
    folder
}

const RENDER: [&str; 5] = ["render", "scene.xml", "-o", "a.png", "--denoise"];

fn library_is_missing(row: &Row) {
    let Some(folder) = library_folder() else { return };
    if folder.join("libc.so.6").exists() {
        println!("skipped: the folder of the library holds others that every program needs");
        return;
    }
    let shop = Workshop::new();
    let Some(before) = with_mounts(&format!("mount -t tmpfs none '{}'", folder.display())) else {
        return;
    };
    let before: Vec<&str> = before.iter().map(String::as_str).collect();
    row.holds(&shop.run(&before, &RENDER));
    assert!(!shop.path("a.png").exists());
}

fn device_library_is_missing(row: &Row) {
    let Some(folder) = library_folder() else { return };
    let shop = Workshop::new();
    std::fs::create_dir(shop.path("lib")).expect("a temporary folder");
    for entry in std::fs::read_dir(folder)
        .expect("the program loads a library from it")
        .flatten()
    {
        let name = entry.file_name().to_string_lossy().into_owned();
        let is_needed = name.contains("OpenImageDenoise") || name.contains("tbb");
        if is_needed && !name.contains("device") {
            std::fs::copy(entry.path(), shop.path("lib").join(&name)).expect("a temporary folder");
        }
    }
    let mut command = shop.command(&[], &RENDER);
    command.env("LD_LIBRARY_PATH", shop.path("lib"));
    row.holds(&Running::start(&mut command).end());
    assert_eq!(picture(&shop.path("a.png")).dimensions(), (64, 48));
}
