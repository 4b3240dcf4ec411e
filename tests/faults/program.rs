//! The program under faults: started in a folder of its own, with limits, signals and broken places around it.

use std::io::{BufRead, BufReader, Read};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStderr, Command, Output, Stdio};
use std::time::{Duration, Instant};

use tempfile::TempDir;

/// Longer than anything here takes on a slow machine; only a hang is stopped by it.
pub const DEADLINE: Duration = Duration::from_secs(240);

/// A floor under a lamp, 64 x 48 pixels, each of which has another colour, so that no format makes a file of a few
/// bytes of them.
pub const SCENE: &str = r#"<scene version="3.0.0">
  <integrator type="path"><integer name="max_depth" value="3"/></integrator>
  <sensor type="perspective">
    <transform name="to_world"><lookat origin="0, 4, 4" target="0, 0, 0" up="0, 1, 0"/></transform>
    <film type="hdrfilm"><integer name="width" value="64"/><integer name="height" value="48"/></film>
    <sampler type="independent"><integer name="sample_count" value="2"/></sampler>
  </sensor>
  <shape type="rectangle"><transform name="to_world"><scale value="20"/><rotate x="1" angle="-90"/></transform></shape>
  <emitter type="point"><point name="position" value="1, 2, 1"/><rgb name="intensity" value="9, 7, 5"/></emitter>
</scene>
"#;

/// What an old output holds before the program is to replace it.
pub const OLD: &[u8] = b"an older picture";

/// A folder with a scene, and a folder of its own for temporary files.
pub struct Workshop {
    folder: TempDir,
}

impl Workshop {
    pub fn new() -> Self {
        let shop = Self {
            folder: tempfile::tempdir().expect("a temporary folder"),
        };
        std::fs::create_dir(shop.path("tmp")).expect("a temporary folder");
        shop.write("scene.xml", SCENE);
        shop
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    pub fn write(&self, name: &str, content: impl AsRef<[u8]>) -> PathBuf {
        let path = self.path(name);
        std::fs::write(&path, content).expect("the folder can be written to");
        path
    }

    /// The sorted names of the files in one of its folders.
    pub fn names(&self, folder: &str) -> Vec<String> {
        let entries = std::fs::read_dir(self.path(folder)).expect("the folder is there");
        let name = |entry: std::io::Result<std::fs::DirEntry>| {
            let name = entry.expect("an entry").file_name();
            name.to_string_lossy().into_owned()
        };
        let mut names: Vec<String> = entries.map(name).collect();
        names.sort();
        names
    }

    /// `sunroom` with these arguments, started by `before`, such as a program that sets limits.
    pub fn command(&self, before: &[&str], arguments: &[&str]) -> Command {
        let program = env!("CARGO_BIN_EXE_sunroom");
        let words: Vec<&str> = before.iter().copied().chain([program]).collect();
        let mut command = Command::new(words[0]);
        command
            .args(&words[1..])
            .args(arguments)
            .current_dir(self.folder.path())
            .env("TMPDIR", self.path("tmp"))
            .env("XDG_CACHE_HOME", self.path("cache"))
            .env_remove("DISPLAY")
            .env_remove("WAYLAND_DISPLAY")
            .env_remove("WAYLAND_SOCKET")
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped());
        command
    }

    pub fn run(&self, before: &[&str], arguments: &[&str]) -> Output {
        let mut command = self.command(before, arguments);
        Running::start(&mut command).end()
    }

    /// The picture that was saved in the folder for temporary files; nothing else is there.
    #[track_caller]
    pub fn kept_picture(&self) -> image::Rgb32FImage {
        let names = self.names("tmp");
        assert!(names.len() == 1 && names[0].ends_with(".exr"), "{names:?}");
        picture(&self.path("tmp").join(&names[0]))
    }
}

/// Fails unless there is a whole picture of the size that [`SCENE`] has.
#[track_caller]
pub fn picture(path: &Path) -> image::Rgb32FImage {
    let bytes = std::fs::read(path).expect("the picture is there");
    let picture = image::load_from_memory(&bytes).expect("it is whole").to_rgb32f();
    assert!(picture.pixels().any(|pixel| pixel.0 != [0.0; 3]), "it is black");
    picture
}

/// A started program; it is killed when the test fails before its end.
pub struct Running {
    child: Child,
    lines: BufReader<ChildStderr>,
    said: String,
}

impl Running {
    pub fn start(command: &mut Command) -> Self {
        let mut child = command.spawn().expect("the program starts");
        let stderr = child.stderr.take().expect("it is a pipe");
        Self {
            child,
            lines: BufReader::new(stderr),
            said: String::new(),
        }
    }

    pub fn id(&self) -> u32 {
        self.child.id()
    }

    /// Waits for the first line about samples: every pixel has one, or a tenth of the time is over.
    #[track_caller]
    pub fn until_progress(&mut self) {
        loop {
            let mut line = String::new();
            let length = self.lines.read_line(&mut line).expect("text");
            self.said += &line;
            assert!(length > 0, "it ended before: {}", self.said);
            if line.contains("spp") {
                return;
            }
        }
    }

    /// Waits until its threads trace rays.
    pub fn until_rendering(&self) {
        let tasks = format!("/proc/{}/task", self.id());
        wait_for("a thread that renders", || {
            let entries = std::fs::read_dir(&tasks).into_iter().flatten().flatten();
            entries
                .filter_map(|task| std::fs::read_to_string(task.path().join("comm")).ok())
                .any(|name| name.starts_with("render"))
        });
    }

    /// `signal` by its name, such as `INT`.
    pub fn send(&self, signal: &str) {
        let id = self.id().to_string();
        let sent = Command::new("kill").args(["-s", signal, &id]).status();
        assert!(sent.is_ok_and(|status| status.success()), "{signal} could not be sent");
    }

    /// Waits for the end, with all that it said.
    #[track_caller]
    pub fn end(mut self) -> Output {
        let stdout = self.child.stdout.take();
        let reader = std::thread::spawn(move || {
            let mut bytes = Vec::new();
            if let Some(mut stdout) = stdout {
                let _ = stdout.read_to_end(&mut bytes);
            }
            bytes
        });
        let id = self.id().to_string();
        let (done, watch) = std::sync::mpsc::channel::<()>();
        let guard = std::thread::spawn(move || {
            let is_late = watch
                .recv_timeout(DEADLINE)
                .is_err_and(|end| end == std::sync::mpsc::RecvTimeoutError::Timeout);
            if is_late {
                let _ = Command::new("kill").args(["-s", "KILL", &id]).status();
            }
            is_late
        });
        let _ = self.lines.read_to_string(&mut self.said);
        let status = self.child.wait().expect("a child can be waited for");
        drop(done);
        assert!(
            !guard.join().expect("the guard does not panic"),
            "it hangs: {}",
            self.said
        );
        Output {
            status,
            stdout: reader.join().expect("the reader does not panic"),
            stderr: std::mem::take(&mut self.said).into_bytes(),
        }
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

#[track_caller]
pub fn wait_for(what: &str, mut is_there: impl FnMut() -> bool) {
    let begin = Instant::now();
    while !is_there() {
        assert!(begin.elapsed() < DEADLINE, "not in time: {what}");
        std::thread::sleep(Duration::from_millis(5));
    }
}

/// Words that run a program in a mount namespace of its own, where `script` has made its mounts. None where that is not
/// allowed.
pub fn with_mounts(script: &str) -> Option<Vec<String>> {
    let allowed = Command::new("unshare").args(["-rm", "true"]).output();
    if !allowed.is_ok_and(|output| output.status.success()) {
        println!("skipped: needs mount namespaces, which this machine does not allow");
        return None;
    }
    let script = format!("{script} && exec \"$0\" \"$@\"");
    Some(
        ["unshare", "-rm", "sh", "-ec"]
            .map(str::to_owned)
            .into_iter()
            .chain([script])
            .collect(),
    )
}
