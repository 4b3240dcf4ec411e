//! A folder in which the program works on files of a test.

use std::path::PathBuf;
use std::process::{Command, Output};

use tempfile::TempDir;

pub struct Workshop(TempDir);

impl Workshop {
    pub fn new() -> Self {
        Self(tempfile::tempdir().expect("a temporary folder"))
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// Writes a file.
    pub fn put(&self, name: &str, content: impl AsRef<[u8]>) -> PathBuf {
        std::fs::write(self.path(name), content).expect("the folder can be written to");
        self.path(name)
    }

    pub fn read(&self, name: &str) -> Vec<u8> {
        std::fs::read(self.path(name)).expect("the file is there")
    }

    pub fn sunroom(&self, args: &[&str]) -> Output {
        let mut command = Command::new(env!("CARGO_BIN_EXE_sunroom"));
        command.current_dir(self.0.path()).args(args);
        // Where the parts of opened files are kept.
        command.env("XDG_CACHE_HOME", self.path("cache"));
        command.output().expect("the program starts")
    }

    #[track_caller]
    pub fn done(&self, args: &[&str]) {
        let output = self.sunroom(args);
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    }
}
