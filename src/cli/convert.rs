//! `sunroom convert`: loads a scene and writes it back, as the program understands it; of glTF files it makes scenes.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::Args;
use sunroom::document::source::check_file;
use sunroom::document::{self, Document};
use sunroom::gltf::Gltf;
use sunroom::gltf::files::take_apart;
use sunroom::scene::read;
use sunroom::scene::write::{self, Extensions};

use super::{SceneArgs, report};

#[derive(Args)]
pub struct ConvertArgs {
    #[command(flatten)]
    scene: SceneArgs,
    /// Scene file to write
    #[arg(value_name = "OUT.xml")]
    output: PathBuf,
    /// Write nothing that Mitsuba does not know: of fuzzy `metal` the nearest `roughconductor`
    #[arg(long)]
    portable: bool,
    /// Treat warnings as errors
    #[arg(long)]
    strict: bool,
}

pub fn run(args: ConvertArgs) -> ExitCode {
    if is_gltf(&args.scene.scene) {
        return match convert_gltf(&args) {
            Ok(code) => code,
            Err(error) => report::error(format_args!("{}: {error}", args.scene.scene.display())),
        };
    }
    let mut document = match document::load(&args.scene.scene, &args.scene.defines.defines) {
        Ok(document) => document,
        Err(error) => return report::error(error),
    };
    let scene = read::read(&mut document);
    report::diagnostics(&document.diagnostics);
    if !report::acceptable(&document.diagnostics, args.strict) {
        return ExitCode::FAILURE;
    }
    let extensions = match args.portable {
        true => Extensions::Approximate,
        false => Extensions::Keep,
    };
    match write::write_anew(&scene, &args.output, extensions) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => report::error(error),
    }
}

fn is_gltf(path: &Path) -> bool {
    let extension = path.extension().unwrap_or_default().to_ascii_lowercase();
    extension == "gltf" || extension == "glb"
}

/// Writes the scene, and its meshes and pictures into a folder beside it.
fn convert_gltf(args: &ConvertArgs) -> Result<ExitCode, Box<dyn std::error::Error>> {
    let source = &args.scene.scene;
    check_file(source)?;
    let beside = source.parent().unwrap_or(Path::new(""));
    let mut read = |name: &str| std::fs::read(beside.join(name));
    let file = Gltf::open(&std::fs::read(source)?, &mut read)?;
    let folder = format!(
        "{}-files",
        args.output.file_stem().unwrap_or_default().to_string_lossy()
    );
    let (imported, files) = take_apart(&file, &folder, &mut read)?;
    for warning in &imported.warnings {
        report::line(format_args!("warning: {warning}"));
    }
    if args.strict && !imported.warnings.is_empty() {
        return Ok(ExitCode::FAILURE);
    }
    let target = args.output.parent().unwrap_or(Path::new(""));
    if !files.is_empty() {
        std::fs::create_dir_all(target.join(&folder))?;
    }
    for file in files {
        std::fs::write(target.join(file.name), file.bytes)?;
    }
    let document = Document::new(&args.output, imported.root);
    document::write_atomically(&args.output, &document::to_xml(&document)?)?;
    Ok(ExitCode::SUCCESS)
}
