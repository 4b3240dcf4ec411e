//! What the program is built from: the licences of the crates that it ships, and the check of the denoiser's binaries.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::process::Command;

const ROOT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../..");

/// The heading that begins the generated part of the list.
const HEADING: &str = "## Crates\n";

#[test]
fn licences_of_shipped_crates_are_listed() {
    let path = Path::new(ROOT).join("LICENSE-THIRD-PARTY.md");
    let page = fs::read_to_string(&path).expect("the list is in the repository");
    let (before, _) = page
        .split_once(HEADING)
        .expect("the list has the heading of the crates");
    let list = shipped_crates()
        .into_iter()
        .map(|(name, licence)| format!("- {name}: {licence}\n"))
        .collect::<String>();
    let wanted = format!(
        "{before}{HEADING}\n\
         The program for Linux on x86-64 with all features is built from these crates. The test\n\
         `licences_of_shipped_crates_are_listed` compares the list with `Cargo.lock`; with `SUNROOM_REWRITE=1` it writes the list.\n\
         `deny.toml` says which licences are allowed.\n\n{list}"
    );
    if std::env::var_os("SUNROOM_REWRITE").is_some() {
        fs::write(&path, wanted).expect("the list can be written");
    } else {
        assert!(
            page == wanted,
            "LICENSE-THIRD-PARTY.md is out of date: run this test with SUNROOM_REWRITE=1"
        );
    }
}

/// Name and version of every crate that the program depends on other than for its tests, with its licence.
fn shipped_crates() -> BTreeMap<String, String> {
    let output = Command::new(env!("CARGO"))
        .args(["tree", "--package=sunroom", "--locked", "--offline", "--all-features"])
        .args(["--target=x86_64-unknown-linux-gnu", "--edges=normal"])
        .args(["--prefix=none", "--format={p}|{l}|"])
        .current_dir(ROOT)
        .output()
        .expect("cargo runs");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let crates = String::from_utf8(output.stdout).expect("cargo writes UTF-8");
    crates
        .lines()
        .filter_map(|line| {
            let mut parts = line.split('|');
            let package = parts
                .next()
                .expect("a line has a first part")
                .replace(" (proc-macro)", "");
            let licence = parts.next().expect("the format has two parts");
            // A package of this repository is followed by its folder.
            if package.contains('(') {
                return None;
            }
            assert!(!licence.is_empty(), "{package} names no licence");
            Some((package.replacen(" v", " ", 1), licence.to_owned()))
        })
        .collect()
}

/// Compiles build.rs as a program of its own and runs it with a `python3` whose `pip download` brings a wheel of wrong
/// content. The rest of Python is real, so that the check itself is the one of an ordinary build.
#[cfg(unix)]
#[test]
fn a_denoiser_with_the_wrong_hash_is_refused() {
    use std::os::unix::fs::PermissionsExt;

    let Some(python) = find_program("python3") else {
        println!("skipped: there is no python3 on this machine");
        return;
    };
    let folder = tempfile::tempdir().expect("a temporary folder");
    let place = |name: &str| folder.path().join(name);
    let script = place("build-script");
    let compiled = Command::new(std::env::var_os("RUSTC").unwrap_or_else(|| "rustc".into()))
        .args(["--edition=2024", "-o"])
        .arg(&script)
        .arg(Path::new(ROOT).join("build.rs"))
        .status()
        .expect("rustc runs");
    assert!(compiled.success());

    for made in ["bin", "out", "package"] {
        fs::create_dir(place(made)).expect("a folder");
    }
    let fake = format!(
        r#"#!/bin/sh
case "$*" in
    "-m pip --version") exit 0 ;;
    "-m pip download "*)
        while [ "$1" != --dest ]; do shift; done
        printf 'not what Intel published' > "$2/pyoidn-2.5.1.0-py3-none-any.whl"
        exit 0 ;;
    *) exec '{}' "$@" ;;
esac
"#,
        python.display()
    );
    let python = place("bin/python3");
    fs::write(&python, fake).expect("a script");
    fs::set_permissions(&python, fs::Permissions::from_mode(0o755)).expect("permissions");

    let output = Command::new(&script)
        .env_clear()
        .env("PATH", format!("{}:/usr/bin:/bin", place("bin").display()))
        .env("CARGO_FEATURE_DENOISE", "1")
        .env("CARGO_MANIFEST_DIR", place("package"))
        .env("OUT_DIR", place("out"))
        // A build for another machine does not take the library of this system.
        .envs([("HOST", "here"), ("TARGET", "elsewhere")])
        .envs([
            ("CARGO_CFG_TARGET_OS", "linux"),
            ("CARGO_CFG_TARGET_ARCH", "x86_64"),
            ("CARGO_CFG_TARGET_ENV", "gnu"),
        ])
        .output()
        .expect("the build script runs");
    let printed = String::from_utf8_lossy(&output.stdout);
    let error = printed.lines().find(|line| line.starts_with("cargo::error="));
    assert!(
        error.is_some_and(|line| line.contains("its SHA-256 is") && line.contains("expected 32ad1336")),
        "{printed}"
    );
    assert!(!printed.contains("rustc-link-search"), "{printed}");
    assert!(
        !place("package/target/oidn/lib").exists(),
        "nothing of the wheel may stay"
    );
}

#[cfg(unix)]
fn find_program(name: &str) -> Option<std::path::PathBuf> {
    let path = std::env::var_os("PATH")?;
    std::env::split_paths(&path)
        .map(|folder| folder.join(name))
        .find(|program| program.is_file())
}
