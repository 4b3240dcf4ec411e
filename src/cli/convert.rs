//! `sunroom convert`: loads a scene of any format and writes it in the native one or as glTF.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::Args;
use sunroom::document::paths::settle;
use sunroom::document::{Diagnostics, Severity};
use sunroom::files::{Access, is_same_file, keep_reads};
use sunroom::scene::assets::scene_asset::load_document;
use sunroom::scene::export::{Hidden, export, is_export};
use sunroom::scene::mesh_check::check_meshes;
use sunroom::scene::picture_check::check_pictures;
use sunroom::scene::read;
use sunroom::scene::volume_check::check_volumes;
use sunroom::scene::write::{self, Extensions};
use sunroom::scene::{FileKind, SceneDescription};

use super::args::{MemoryArgs, MissingArgs, SceneArgs, TrustArgs};
use super::outputs::check_scene_stays;
use super::report::{self, Failure};

#[derive(Args)]
pub struct ConvertArgs {
    #[command(flatten)]
    scene: SceneArgs,
    /// Scene file to write: OUT.xml, or OUT.glb or OUT.gltf to export to glTF 2.0
    #[arg(value_name = "OUT")]
    output: PathBuf,
    #[command(flatten)]
    memory: MemoryArgs,
    #[command(flatten)]
    trust: TrustArgs,
    #[command(flatten)]
    missing: MissingArgs,
    /// Write nothing that Mitsuba does not know: of fuzzy `metal` the nearest `roughconductor`
    #[arg(long)]
    portable: bool,
    /// Treat warnings as errors
    #[arg(long)]
    strict: bool,
}

pub fn run(args: &ConvertArgs) -> Result<ExitCode, Failure> {
    // Relative paths in the scene start from the folder of the file.
    if args.output == Path::new("-") {
        return Err("`-`: a scene is written to a file, not to standard output; give a name such as OUT.xml".into());
    }
    args.memory.apply();
    keep_reads();
    let path = settle(&args.scene.scene);
    let access = args.trust.trust(&args.scene.scene)?.access(&path);
    let mut document = load_document(&path, &args.scene.defines.defines, access)?;
    let scene = read::read(&mut document);
    let mut lacks_meshes = false;
    if !document.diagnostics.has_errors() {
        let missing = args.missing.severity();
        let pictures = check_meshes(&scene, &document.access, missing, &mut document.diagnostics);
        lacks_meshes = missing == Severity::Error && lacks_only_meshes(&scene, &document.diagnostics);
        check_pictures(&scene, &pictures, &document.access, &mut document.diagnostics);
        check_volumes(&scene, &document.access, &mut document.diagnostics);
    }
    report::diagnostics(&document.diagnostics);
    if !report::acceptable(&document.diagnostics, args.strict) {
        if report::acceptable(&document.diagnostics, false) {
            report::refused_for_warnings(&args.scene.scene);
        } else if lacks_meshes {
            report::refused_for_missing(&args.scene.scene);
        }
        return Ok(ExitCode::FAILURE);
    }
    // The comments, includes and `$name`s of the old file would be lost.
    if is_same_file(&args.scene.scene, &args.output) {
        return Err("this would replace the scene it is made from; give another name".into());
    }
    check_scene_stays([&args.output])?;
    if is_export(&args.output) {
        return export_to(&scene, &document.access, args);
    }
    let extensions = match args.portable {
        true => {
            report_one_sky(&scene);
            Extensions::Approximate
        }
        false => Extensions::Keep,
    };
    write::write_anew(&scene, &args.output, extensions)?;
    Ok(ExitCode::SUCCESS)
}

/// Whether all errors are missing meshes.
fn lacks_only_meshes(scene: &SceneDescription, diagnostics: &Diagnostics) -> bool {
    let missing = scene.missing.values().filter(|file| file.kind == FileKind::Mesh);
    diagnostics.error_count() == missing.count()
}

/// Reports the lights around the scene that are left out for Mitsuba, which takes one.
fn report_one_sky(scene: &SceneDescription) {
    let mut skies = scene.skies();
    if let Some(kept) = skies.next() {
        let kept = &kept.identity.name;
        for sky in skies {
            report::line(format_args!(
                "warning: emitter `{}` is left out: Mitsuba takes one light around the scene, and `{kept}` is the first",
                sky.identity.name
            ));
        }
    }
}

/// Writes the scene as glTF. Losses are reported, and refused with `--strict`.
fn export_to(scene: &SceneDescription, access: &Access, args: &ConvertArgs) -> Result<ExitCode, Failure> {
    let export = export(scene, &Hidden::default(), &args.output, access)?;
    for message in &export.messages {
        report::line(format_args!("warning: {message}"));
    }
    if let Some(note) = &export.note {
        report::line(format_args!("note: {note}"));
    }
    if args.strict && !export.messages.is_empty() {
        report::refused_for_warnings(&args.output);
        return Ok(ExitCode::FAILURE);
    }
    export.write()?;
    Ok(ExitCode::SUCCESS)
}
