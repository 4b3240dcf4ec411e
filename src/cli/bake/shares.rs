//! Shares of a bake are put together.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use sunroom::app::origin::digest;
use sunroom::bake::files;
use sunroom::bake::merging::merge;
use sunroom::render::part::FileDigest;
use sunroom::scene::export::ExportError;

use super::{BAKES_WITHOUT, is_file_of_level, report_invalid, within_folder};
use crate::cli::outputs::{PART, check_inputs_stay};
use crate::cli::report::{self, Failure, check_denoiser};
use crate::cli::share::warn_of_missing;

/// What `sunroom merge` is asked for.
pub struct Shares<'a> {
    pub paths: &'a [PathBuf],
    /// The folder of the bake, and no other.
    pub outputs: &'a [PathBuf],
    pub denoise: bool,
    /// Shares of other scenes, settings or versions are merged as well.
    pub force: bool,
    pub threads: usize,
    pub quiet: bool,
}

impl Shares<'_> {
    pub fn merge(&self) -> Result<ExitCode, Failure> {
        check_denoiser(self.denoise, BAKES_WITHOUT)?;
        let [folder] = self.outputs else {
            return Err(Failure::Usage(
                "the shares of a bake make one folder: give one `-o`".to_owned(),
            ));
        };
        let replaced = self.paths.iter().find(|path| is_file_of_level(folder, path));
        let outputs = [folder.clone()].into_iter().chain(replaced.cloned());
        check_inputs_stay(&outputs.collect::<Vec<_>>(), self.paths, PART).map_err(Failure::Usage)?;
        within_folder(folder, || {
            let mut merged = merge(self.paths, self.force)?;
            if let Some(path) = in_use(folder, &merged.files) {
                return Err(ExportError::InUse { path }.into());
            }
            warn_of_missing("texel", merged.samples, merged.samples_of_whole);
            merged.blueprint.denoise = self.denoise;
            let pool = rayon::ThreadPoolBuilder::new().num_threads(self.threads).build()?;
            let baked = merged.blueprint.finished(&merged.lights, &pool)?;
            files::write(folder, &merged.blueprint, &baked)?;
            report_invalid(merged.lights.iter().map(|light| light.invalid).sum());
            if !self.quiet {
                report::line(format_args!("the level is in {}", folder.display()));
            }
            Ok(ExitCode::SUCCESS)
        })
    }
}

/// A file that would be replaced in the folder, and that has the content of a file of the scene.
fn in_use(folder: &Path, of_scene: &[FileDigest]) -> Option<PathBuf> {
    let is_of_scene = |path: &PathBuf| digest(path).is_ok_and(|found| of_scene.iter().any(|file| file.digest == found));
    files::replaceable(folder).into_iter().find(is_of_scene)
}
