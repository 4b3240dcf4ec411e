//! The files of `<spectrum filename="...">`. However many tags name a file, it is read once for each role that its
//! spectrum has.

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use glam::Vec3;

use crate::document::paths::canonical;
use crate::document::spectrum::{Role, SampledSpectrum};

/// A colour and whether it was clamped, or the reason why there is none.
type Color = Result<(Vec3, bool), String>;

/// The colours of the files that were read.
#[derive(Default)]
pub(super) struct SpectrumFiles {
    colors: HashMap<(PathBuf, Role), Color>,
}

impl SpectrumFiles {
    /// The colour of a file's spectrum, which `read` gives the first time.
    pub fn color(&mut self, path: &Path, role: Role, read: impl FnOnce() -> Result<SampledSpectrum, String>) -> Color {
        let key = (canonical(path), role);
        let color = self.colors.entry(key);
        color.or_insert_with(|| Ok(read()?.to_rgb(role))).clone()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_read_once_for_each_role() {
        let mut files = SpectrumFiles::default();
        let mut readings = 0;
        let mut color = |file: &str, role| {
            files.color(Path::new(file), role, || {
                readings += 1;
                SampledSpectrum::parse_file("400 1\n700 1\n").map_err(|error| error.to_string())
            })
        };
        let first = color("/nowhere/a", Role::Emission);
        assert!(first.is_ok());
        for _ in 0..100 {
            assert_eq!(color("/nowhere/a", Role::Emission), first);
        }
        assert_ne!(color("/nowhere/a", Role::Reflectance), first);
        assert_eq!(color("/nowhere/b", Role::Emission), first);
        assert_eq!(readings, 3);
    }
}
