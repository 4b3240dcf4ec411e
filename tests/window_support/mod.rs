//! A virtual display with a software graphics driver, for tests that start the real window.
#![allow(dead_code, reason = "every test binary uses its own part")]

use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};

/// A process that ends with the test, whether the test passes or not.
pub struct Ended(pub Child);

impl Drop for Ended {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// An X server without a screen and a Vulkan driver without a GPU.
pub struct Display {
    pub server: Ended,
    /// The name of the display.
    pub name: String,
    /// The driver's file.
    pub driver: PathBuf,
}

impl Display {
    /// None, with a word on standard output, where Xvfb or Mesa's software Vulkan driver is not installed; an error if
    /// `SUNROOM_NEEDS_DISPLAY` says that they are.
    pub fn open() -> Option<Self> {
        let display = Self::try_open();
        if display.is_none() {
            assert!(
                std::env::var_os("SUNROOM_NEEDS_DISPLAY").is_none(),
                "there is no Xvfb or no software Vulkan driver"
            );
            println!("skipped: needs Xvfb and Mesa's software Vulkan driver");
        }
        display
    }

    fn try_open() -> Option<Self> {
        let driver = software_vulkan()?;
        let mut server = Command::new("Xvfb")
            .args(["-displayfd", "1", "-screen", "0", "1280x720x24", "-nolisten", "tcp"])
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .ok()?;
        let output = server.stdout.take();
        let server = Ended(server);
        let mut number = String::new();
        BufReader::new(output?).read_line(&mut number).ok()?;
        let number: u32 = number.trim().parse().ok()?;
        let name = format!(":{number}");
        Some(Self { server, name, driver })
    }

    /// Lets `command` open its window here. `runtime`: a folder for sockets, which is made if it is not there.
    pub fn show(&self, command: &mut Command, runtime: &Path) {
        std::fs::create_dir_all(runtime).expect("it can be made");
        command
            .env_remove("WAYLAND_DISPLAY")
            .env_remove("WAYLAND_SOCKET")
            .env("DISPLAY", &self.name)
            .env("XDG_RUNTIME_DIR", runtime)
            .env("WGPU_BACKEND", "vulkan")
            .env("VK_ICD_FILENAMES", &self.driver)
            .env("VK_DRIVER_FILES", &self.driver);
    }
}

fn software_vulkan() -> Option<PathBuf> {
    let folders = ["/usr/share/vulkan/icd.d", "/usr/local/share/vulkan/icd.d"];
    let files = folders
        .iter()
        .filter_map(|folder| std::fs::read_dir(folder).ok())
        .flatten();
    files.filter_map(|entry| Some(entry.ok()?.path())).find(|path| {
        path.file_name()
            .is_some_and(|name| name.to_string_lossy().starts_with("lvp_icd"))
    })
}
