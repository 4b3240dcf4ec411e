//! Sees to it that Intel Open Image Denoise (OIDN) is there when the feature `denoise` is on.
//!
//! The crate `oidn` only names the library; it neither brings it nor tells a program where to find it at run time. The
//! first of these wins:
//!
//! 1. `OIDN_DIR` of the user (any other folder than the default of `.cargo/config.toml`, which is `target/oidn`);
//! 2. `target/oidn`, brought by an earlier build;
//! 3. a system install of major version 2 (pkg-config, or the usual library folders);
//! 4. Intel's own release binaries out of the Python wheel `pyoidn`, put into `target/oidn` once: only the parts for
//!    the CPU, after a check of the wheel's SHA-256.
//!
//! Nothing but the standard library is used here: pip needs a Python, and that Python can hash and unzip as well, so
//! crates for either would only make every build longer.
//!
//! Open Image Denoise is under the Apache License 2.0, copyright Intel Corporation. Its binaries are never part of this
//! repository; who passes them on with a build has to pass on Intel's licence and third-party notices too.

use std::env;
use std::fs::{self, File, TryLockError};
use std::path::{Path, PathBuf};
use std::process::{self, Command, Stdio};
use std::thread;
use std::time::{Duration, Instant, SystemTime};

const WHEEL: &str = "pyoidn==2.5.1.0";
/// The whole download, 88 MB: a slow line gets through, a dead one does not hold the build up for ever.
const DOWNLOAD_LIMIT: Duration = Duration::from_secs(600);
const UNPACK_LIMIT: Duration = Duration::from_secs(120);
const PROBE_LIMIT: Duration = Duration::from_secs(20);
const PART_PREFIX: &str = "oidn.part-";
/// Longer than one download: another cargo process may be at it.
const LOCK_LIMIT: Duration = Duration::from_secs(800);

/// What differs between the platforms.
struct Platform {
    os: String,
    /// As GNU names it in library folders, and as wheels do: `x86_64`, `aarch64`.
    arch: String,
    /// Platform tag for pip, `None`: pip's own; and the wheel's SHA-256. `None`: there are no official binaries.
    wheel: Option<(Option<&'static str>, &'static str)>,
    /// The file that the linker reads and the one that the program loads, both relative to the folder of an install.
    link_file: &'static str,
    load_file: &'static str,
}

impl Platform {
    fn of_target() -> Self {
        let var = |name| env::var(name).unwrap_or_default();
        let (os, arch) = (var("CARGO_CFG_TARGET_OS"), var("CARGO_CFG_TARGET_ARCH"));
        let wheel = match (os.as_str(), arch.as_str(), var("CARGO_CFG_TARGET_ENV").as_str()) {
            ("linux", "x86_64", "gnu") => Some((
                Some("manylinux2014_x86_64"),
                "32ad13368f8de1ef63001942ad05b02a00cd732d1206d97f352d3a3f606d823e",
            )),
            ("windows", "x86_64", _) => Some((
                Some("win_amd64"),
                "b2581998442134b04a20c0c914a8538c40bda4989055b487c25602b627f6616e",
            )),
            ("macos", "aarch64", _) => Some((None, "ed803c20333d37873678d69abf1e3546e89dbaf4639408b7c92173e11b6355cb")),
            ("macos", "x86_64", _) => Some((
                Some("macosx_10_15_x86_64"),
                "c9d366e448c7a99ef54b936806ef2e6ae1e1383b0a3ba08f5509a39553fa03c2",
            )),
            _ => None,
        };
        let (link_file, load_file) = match os.as_str() {
            "windows" => ("OpenImageDenoise.lib", "OpenImageDenoise.dll"),
            "macos" => ("libOpenImageDenoise.dylib", "libOpenImageDenoise.2.dylib"),
            _ => ("libOpenImageDenoise.so", "libOpenImageDenoise.so.2"),
        };
        Self {
            os,
            arch,
            wheel,
            link_file,
            load_file,
        }
    }

    /// Whether `folder` holds version 2, both for the linker and for the running program.
    fn is_lib_folder(&self, folder: &Path) -> bool {
        let loaded_from = if self.os == "windows" {
            folder.with_file_name("bin")
        } else {
            folder.to_path_buf()
        };
        folder.join(self.link_file).is_file() && loaded_from.join(self.load_file).is_file()
    }

    /// The library folder of an install such as Intel's release archive.
    fn lib_folder(&self, install: &Path) -> Option<PathBuf> {
        ["lib", "lib64"]
            .map(|name| install.join(name))
            .into_iter()
            .find(|folder| self.is_lib_folder(folder))
    }
}

fn main() {
    let root = workspace_root();
    println!("cargo::rerun-if-changed={}", root.join("build.rs").display());
    if env::var_os("CARGO_FEATURE_DENOISE").is_none() {
        return;
    }
    println!("cargo::rerun-if-env-changed=OIDN_DIR");
    let platform = Platform::of_target();
    match provide(&platform, &root).and_then(|folder| announce(&platform, &folder)) {
        Ok(()) => {}
        Err(why) => println!(
            "cargo::error=Open Image Denoise, version 2, is not there: {why}. Three ways out: set OIDN_DIR to the folder \
             of an unpacked official release (the one that holds `lib`); or install it from the packages of the system, \
             development files included; or build without the denoiser: \
             cargo run --release --no-default-features --features window"
        ),
    }
}

/// The folder with the lock file, which is the common root of the two packages that this script builds.
fn workspace_root() -> PathBuf {
    let package = PathBuf::from(env::var_os("CARGO_MANIFEST_DIR").unwrap_or_default());
    let root = package.ancestors().find(|folder| folder.join("Cargo.lock").is_file());
    root.unwrap_or(&package).to_path_buf()
}

/// The library folder to link with and to load from.
fn provide(platform: &Platform, root: &Path) -> Result<PathBuf, String> {
    let own = root.join("target").join("oidn");

    let chosen = env::var_os("OIDN_DIR").filter(|value| !value.is_empty());
    if let Some(install) = chosen.map(|value| root.join(value)).filter(|install| *install != own) {
        return platform.lib_folder(&install).ok_or_else(|| {
            format!(
                "OIDN_DIR is {}, but its `lib` does not hold {} and {}",
                install.display(),
                platform.link_file,
                platform.load_file
            )
        });
    }
    if let Some(folder) = platform.lib_folder(&own) {
        return Ok(folder);
    }
    if let Some(folder) = system_folder(platform) {
        stand_in(&own.join("lib"));
        return Ok(folder);
    }
    fetch(platform, &own)?;
    platform
        .lib_folder(&own)
        .ok_or_else(|| format!("{WHEEL} did not hold {}", platform.link_file))
}

/// Tells cargo what to link, what to watch, and where the programs find the library when they run.
fn announce(platform: &Platform, folder: &Path) -> Result<(), String> {
    println!("cargo::rustc-link-search=native={}", folder.display());
    // Of the whole install only this file is watched: if it vanishes it is brought again.
    println!("cargo::rerun-if-changed={}", folder.join(platform.link_file).display());
    // `rustc-link-arg` reaches all of binaries, tests, unit tests and benches. The places beside the program come
    // first, so that a program can be carried away together with a folder `lib`.
    let rpath = |place: &str| println!("cargo::rustc-link-arg=-Wl,-rpath,{place}");
    match platform.os.as_str() {
        "windows" => return copy_beside_programs(&folder.with_file_name("bin")),
        "macos" => ["@loader_path", "@loader_path/lib", "@loader_path/../lib"].map(rpath),
        _ => ["$ORIGIN", "$ORIGIN/lib", "$ORIGIN/../lib"].map(rpath),
    };
    rpath(&folder.display().to_string());
    Ok(())
}

/// Windows has no rpath: the libraries have to lie in the folder of each program.
fn copy_beside_programs(libraries: &Path) -> Result<(), String> {
    let out = PathBuf::from(env::var_os("OUT_DIR").ok_or("cargo did not name the output folder")?);
    let profile = out
        .ancestors()
        .find(|folder| folder.file_name().is_some_and(|name| name == "build"))
        .and_then(Path::parent)
        .ok_or("the output folder is not inside a build folder")?;
    let failed = |what: &Path, error| format!("{}: {error}", what.display());
    for entry in fs::read_dir(libraries).map_err(|error| failed(libraries, error))? {
        let library = entry.map_err(|error| failed(libraries, error))?.path();
        if library.extension().is_none_or(|extension| extension != "dll") {
            continue;
        }
        for folder in [profile.to_path_buf(), profile.join("deps"), profile.join("examples")] {
            fs::create_dir_all(&folder).map_err(|error| failed(&folder, error))?;
            let copy = folder.join(library.file_name().unwrap_or_default());
            fs::copy(&library, &copy).map_err(|error| failed(&copy, error))?;
        }
    }
    Ok(())
}

/// The library folder of a system install of major version 2, development files included.
fn system_folder(platform: &Platform) -> Option<PathBuf> {
    if platform.os == "windows" || env::var_os("HOST") != env::var_os("TARGET") {
        return None;
    }
    println!("cargo::rerun-if-env-changed=PKG_CONFIG_PATH");
    let pkg_config = |question: &str| {
        let answer = run(
            Command::new("pkg-config").args([question, "OpenImageDenoise"]),
            PROBE_LIMIT,
        );
        answer.ok().map(|text| text.trim().to_owned())
    };
    if pkg_config("--modversion").is_some_and(|version| version.starts_with("2."))
        && let Some(folder) = pkg_config("--variable=libdir").map(PathBuf::from)
        && platform.is_lib_folder(&folder)
    {
        return Some(folder);
    }
    let usual = match platform.os.as_str() {
        "macos" => vec!["/opt/homebrew/lib".to_owned(), "/usr/local/lib".to_owned()],
        _ => vec![
            "/usr/local/lib".to_owned(),
            "/usr/local/lib64".to_owned(),
            format!("/usr/lib/{}-linux-gnu", platform.arch),
            "/usr/lib64".to_owned(),
            "/usr/lib".to_owned(),
        ],
    };
    usual
        .into_iter()
        .map(PathBuf::from)
        .find(|folder| platform.is_lib_folder(folder))
}

/// An empty, old folder where the crate `oidn` looks: were it missing, cargo would take that crate, and with it this
/// one, for changed at each build.
fn stand_in(folder: &Path) {
    // A failure only costs build time.
    if fs::create_dir_all(folder).is_ok() {
        for made in [Some(folder), folder.parent()].into_iter().flatten() {
            if let Ok(handle) = File::open(made) {
                let _ = handle.set_modified(SystemTime::UNIX_EPOCH + Duration::from_secs(1_000_000_000));
            }
        }
    }
}

/// Brings Intel's binaries to `install`: all of them or nothing, also with several cargo processes at once.
fn fetch(platform: &Platform, install: &Path) -> Result<(), String> {
    let (tag, sha256) = platform.wheel.ok_or_else(|| {
        format!(
            "there are no official binaries for {} on {}",
            platform.arch, platform.os
        )
    })?;
    let around = install.parent().ok_or("no folder to put it in")?;
    let failed = |what: &Path, error: std::io::Error| format!("{}: {error}", what.display());
    fs::create_dir_all(around).map_err(|error| failed(around, error))?;

    let lock = lock(&around.join("oidn.lock"))?;
    if platform.lib_folder(install).is_some() {
        return Ok(()); // Another process was faster.
    }
    if lock.is_some() {
        remove_rests(around);
    }
    // The process id keeps two apart even where the file system knows no locks.
    let work = around.join(format!("{PART_PREFIX}{}", process::id()));
    let brought = download_and_unpack(tag, sha256, &work).and_then(|unpacked| {
        // What is in the way is a stand-in or the rest of something; a complete install was ruled out above.
        let _ = fs::remove_dir_all(install);
        match fs::rename(&unpacked, install) {
            Err(_) if platform.lib_folder(install).is_some() => Ok(()),
            renamed => renamed.map_err(|error| failed(install, error)),
        }
    });
    let _ = fs::remove_dir_all(&work);
    brought
}

/// Removes what killed builds left behind. Only for the holder of the lock: nobody else is at work then.
fn remove_rests(around: &Path) {
    for entry in fs::read_dir(around).into_iter().flatten().flatten() {
        if entry.file_name().to_string_lossy().starts_with(PART_PREFIX) {
            let _ = fs::remove_dir_all(entry.path());
        }
    }
}

/// Held until the file is dropped, or the process dies. `None` where the file system knows no locks.
fn lock(path: &Path) -> Result<Option<File>, String> {
    let file = File::create(path).map_err(|error| format!("{}: {error}", path.display()))?;
    let start = Instant::now();
    loop {
        match file.try_lock() {
            Ok(()) => return Ok(Some(file)),
            Err(TryLockError::Error(_)) => return Ok(None),
            Err(TryLockError::WouldBlock) if start.elapsed() > LOCK_LIMIT => {
                return Err(format!("another process has held {} for too long", path.display()));
            }
            Err(TryLockError::WouldBlock) => thread::sleep(Duration::from_millis(200)),
        }
    }
}

/// Returns the unpacked install, a folder inside `work`.
fn download_and_unpack(tag: Option<&str>, sha256: &str, work: &Path) -> Result<PathBuf, String> {
    let _ = fs::remove_dir_all(work);
    let unpacked = work.join("oidn");
    fs::create_dir_all(&unpacked).map_err(|error| format!("{}: {error}", unpacked.display()))?;

    let mut pip = working_command(&[
        &["python3", "-m", "pip", "--version"],
        &["python", "-m", "pip", "--version"],
        &["py", "-m", "pip", "--version"],
        &["pip", "--version"],
        &["pip3", "--version"],
    ])
    .ok_or("it is not installed, and there is no pip to fetch it with")?;
    let mut python = working_command(&[
        &["python3", "-c", "import zipfile"],
        &["python", "-c", "import zipfile"],
        &["py", "-c", "import zipfile"],
    ])
    .ok_or("it is not installed, and there is no Python to unpack it with")?;

    pip.args(["download", "--no-deps", "--only-binary=:all:", "--no-input"])
        .args(["--disable-pip-version-check", "--progress-bar=off"])
        .args(["--timeout=20", "--retries=2"])
        .arg("--dest")
        .arg(work);
    if let Some(tag) = tag {
        pip.arg("--platform").arg(tag);
    }
    pip.arg(WHEEL).env("PIP_REQUIRE_VIRTUALENV", "0");
    run(&mut pip, DOWNLOAD_LIMIT).map_err(|why| format!("pip could not fetch {WHEEL} (no network?): {why}"))?;

    python.args(["-c", UNPACK]).arg(work).arg(sha256).arg(&unpacked);
    run(&mut python, UNPACK_LIMIT).map_err(|why| format!("unpacking {WHEEL} failed: {why}"))?;
    Ok(unpacked)
}

/// Arguments: folder of the wheel, its SHA-256, folder to fill. Wheels hold no symbolic links: of files with the same
/// content the longest name, which carries the version, becomes the file and the others links to it. All get an old
/// date, or cargo would think that they changed after the build began, and build again.
const UNPACK: &str = r#"
import glob, hashlib, os, posixpath, shutil, sys, zipfile

source, expected, target = sys.argv[1:]
wheels = glob.glob(os.path.join(glob.escape(source), "*.whl"))
if len(wheels) != 1:
    sys.exit("expected one wheel, found %d" % len(wheels))
digest = hashlib.sha256()
with open(wheels[0], "rb") as wheel:
    for block in iter(lambda: wheel.read(1 << 20), b""):
        digest.update(block)
if digest.hexdigest() != expected:
    sys.exit("its SHA-256 is %s, expected %s" % (digest.hexdigest(), expected))

def wanted(path):
    folder, name = posixpath.split(path)
    if folder not in ("pyoidn/oidn/lib", "pyoidn/oidn/bin"):
        return False
    stem = name[3:] if name.startswith("lib") else name
    parts = ("OpenImageDenoise.", "OpenImageDenoise_core.", "OpenImageDenoise_device_cpu.", "tbb.", "tbb12.")
    return stem.startswith(parts)

made = {}
with zipfile.ZipFile(wheels[0]) as archive:
    entries = [entry for entry in archive.infolist() if wanted(entry.filename)]
    for entry in sorted(entries, key=lambda entry: -len(entry.filename)):
        folder, name = posixpath.split(entry.filename)
        path = os.path.join(target, posixpath.basename(folder), name)
        os.makedirs(os.path.dirname(path), exist_ok=True)
        twin = made.setdefault((folder, entry.file_size, entry.CRC), name)
        if twin != name:
            os.symlink(twin, path)
            continue
        with archive.open(entry) as packed, open(path, "wb") as unpacked:
            shutil.copyfileobj(packed, unpacked)
        os.chmod(path, 0o755)

with open(os.path.join(target, "NOTICE.txt"), "w") as notice:
    notice.write("Intel Open Image Denoise 2.5.1, binaries of the official release, parts for the CPU.\n"
                 "Copyright Intel Corporation. Apache License 2.0. oneTBB: likewise.\n")
old = (1000000000, 1000000000)
for folder, _, names in os.walk(target, topdown=False):
    for name in names:
        path = os.path.join(folder, name)
        if os.utime in os.supports_follow_symlinks:
            os.utime(path, old, follow_symlinks=False)
        else:
            os.utime(path, old)
    os.utime(folder, old)
"#;

/// The first command line that runs without error, ready for other arguments in place of its last ones: a trailing
/// `--version`, or `-c` and a script.
fn working_command(candidates: &[&[&str]]) -> Option<Command> {
    candidates.iter().find_map(|words| {
        let (program, arguments) = words.split_first()?;
        run(Command::new(program).args(arguments), PROBE_LIMIT).ok()?;
        let kept = arguments
            .iter()
            .take_while(|word| !matches!(**word, "--version" | "-c"));
        let mut command = Command::new(program);
        command.args(kept);
        Some(command)
    })
}

/// Runs a program to its end, or for `limit`. Returns what it printed; on failure the reason in one line.
fn run(command: &mut Command, limit: Duration) -> Result<String, String> {
    let out = PathBuf::from(env::var_os("OUT_DIR").ok_or("cargo did not name the output folder")?);
    // Files, not pipes: nobody has to empty them while the program runs.
    let (printed, complaints) = (out.join("command.out"), out.join("command.err"));
    let open = |path: &Path| File::create(path).map_err(|error| format!("{}: {error}", path.display()));
    let mut child = command
        .stdin(Stdio::null())
        .stdout(open(&printed)?)
        .stderr(open(&complaints)?)
        .spawn()
        .map_err(|error| error.to_string())?;
    let start = Instant::now();
    let status = loop {
        match child.try_wait() {
            Ok(Some(status)) => break status,
            Ok(None) if start.elapsed() < limit => thread::sleep(Duration::from_millis(20)),
            Ok(None) => {
                let _ = child.kill();
                let _ = child.wait();
                return Err(format!("no end after {} s", limit.as_secs()));
            }
            Err(error) => return Err(error.to_string()),
        }
    };
    let text = |path| fs::read(path).map(|bytes| String::from_utf8_lossy(&bytes).into_owned());
    if status.success() {
        return text(&printed).map_err(|error| error.to_string());
    }
    let complaints = text(&complaints).unwrap_or_default();
    let last = complaints.lines().rev().find(|line| !line.trim().is_empty());
    Err(last.map_or_else(|| status.to_string(), |line| line.trim().to_owned()))
}
