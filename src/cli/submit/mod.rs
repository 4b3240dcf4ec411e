//! `sunroom submit`: a folder with a scene, its files, and a job that renders or bakes it on many machines.
//!
//! Two scripts do the work, one for a task and one for a merge. Each system starts them by a template: Open Job
//! Description, Slurm, GNU parallel.

mod args;
mod bundle;
mod plan;
mod work;

use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};

use sunroom::document::paths::settle;
use sunroom::document::{Document, Value};
use sunroom::engine::Limits;
use sunroom::files::{self, record_reads, recorded_reads};
use sunroom::render::part;
use sunroom::render::passes::chunks_in;
use sunroom::scene::Trust;
use sunroom::scene::assets::parts_cache::is_part;
use sunroom::scene::assets::scene_asset::load_document;

pub use self::args::SubmitArgs;

use self::args::System;
use self::plan::{Plan, Whole};
use self::work::Work;
use super::bake::BAKES_WITHOUT;
use super::check::{load, open};
use super::outputs;
use super::report::{self, Failure, RENDERS_WITHOUT, check_denoiser, counted};

/// The folder of the scene and its files in a job.
const FILES: &str = "files";

impl System {
    /// The template, and the name of its file in the job.
    fn template(self) -> (&'static str, &'static str) {
        match self {
            Self::Openjd => ("template.yaml", include_str!("../../../farm/openjd.yaml")),
            Self::Slurm => ("slurm", include_str!("../../../farm/slurm")),
            Self::Parallel => ("parallel", include_str!("../../../farm/parallel")),
        }
    }

    /// The command that starts the job.
    fn start(self, folder: &Path) -> String {
        let folder = folder.display();
        match self {
            Self::Openjd => format!("openjd run {folder}/template.yaml --step Merge --run-dependencies"),
            Self::Slurm => format!("{folder}/slurm"),
            Self::Parallel => format!("{folder}/parallel HOST,HOST"),
        }
    }
}

const TASK: &str = include_str!("../../../farm/task");
const MERGE: &str = include_str!("../../../farm/merge");

pub fn run(args: &SubmitArgs) -> Result<ExitCode, Failure> {
    args.memory.apply();
    if args.output.read_dir().is_ok_and(|mut entries| entries.next().is_some()) {
        let message = format!(
            "{} is not empty; a job needs a folder of its own",
            args.output.display()
        );
        return Err(Failure::Usage(message));
    }
    check_denoiser(args.bake && !args.no_denoise, BAKES_WITHOUT)?;
    check_denoiser(args.denoise, RENDERS_WITHOUT)?;
    let work = Work::of(args)?;
    let Some(job) = gather(args, &work)? else {
        return Ok(ExitCode::FAILURE);
    };
    let whole = Whole {
        frames: args.frames.clone().unwrap_or(0..=0),
        spp: job.spp,
        size: job.size,
        grid: args.crops,
    };
    let plan = match args.shares {
        Some(shares) => Plan::of_shares(whole, shares),
        None => Plan::of_times(whole, work.seconds(args, job.spp)?, args.task_time.as_secs_f64()),
    };
    let plan = plan.map_err(Failure::Usage)?;
    if let Some(asked) = args.shares
        && plan.ranges() < asked as usize
    {
        report::line(format_args!(
            "note: --shares {asked} makes {}: samples are summed up in fixed groups, {} of them are {}, and ranges begin and end with groups",
            counted(plan.ranges(), "range"),
            job.spp,
            counted(chunks_in(0..job.spp), "group")
        ));
    }
    let scripts = scripts(args, &work, &plan, &job);
    let mut text = String::new();
    for member in &job.members {
        let _ = writeln!(text, "{FILES}/{}  {}", member.place.display(), member.file.display());
    }
    for (name, _) in &scripts {
        let _ = writeln!(text, "{name}");
    }
    let _ = writeln!(text, "{}", summary(args, &plan, &job));
    outputs::print(text.as_bytes())?;
    if args.dry_run {
        return Ok(ExitCode::SUCCESS);
    }
    bundle::copy(&job.members, &args.output.join(FILES))?;
    for (name, content) in &scripts {
        write_script(&args.output.join(name), content)?;
    }
    if !is_complete(args, &job.scene)? {
        return Ok(ExitCode::FAILURE);
    }
    report::line(format_args!("start it with: {}", args.to.start(&args.output)));
    Ok(ExitCode::SUCCESS)
}

/// A line about the number of tasks.
fn summary(args: &SubmitArgs, plan: &Plan, job: &Job) -> String {
    let tasks = counted(plan.tasks(), "task");
    let ranges = format!(
        "{} of its {}",
        counted(plan.ranges(), "range"),
        counted(job.spp, "sample")
    );
    if args.bake {
        return format!("{tasks}: a bake in {ranges} per texel");
    }
    format!(
        "{tasks}: {}, each in {} of its {} x {} pixels and {ranges}, {} a task",
        counted(plan.frames.end() - plan.frames.start() + 1, "frame"),
        counted(plan.crops.len(), "crop"),
        job.size[0],
        job.size[1],
        counted(plan.frames_a_task, "frame"),
    )
}

/// The content of a job.
struct Job {
    members: Vec<bundle::Member>,
    /// The path of the scene in the bundle.
    scene: PathBuf,
    /// Samples per pixel of a frame, or per texel of a bake.
    spp: u32,
    /// The width and the height of a frame in pixels; one pixel stands for a bake.
    size: [u32; 2],
}

/// Loads the scene to find the files it reads. None if it has errors, which have been reported.
fn gather(args: &SubmitArgs, work: &Work) -> Result<Option<Job>, Failure> {
    let path = settle(&args.scene.scene);
    record_reads();
    let mut app = open(&path, &args.scene.defines, Trust::Everything, &args.missing, Some(1));
    if !load(&mut app, &Limits::default(), &args.scene.scene, false)? {
        return Ok(None);
    }
    let document = load_document(&path, &args.scene.defines.defines, Trust::Everything.access(&path))?;
    // The document of a glTF file names its parts in the user's cache. Every machine recreates these.
    let is_own_part = |file: &Path| document.imported && is_part(file);
    if let Some(name) = absolute_name(&document, &is_own_part) {
        let message = format!(
            "{}: `{name}` is an absolute name; the files of a job need names relative to the scene",
            path.display()
        );
        return Err(message.into());
    }
    let (spp, size) = work.extent(args, app.world_mut())?;
    let read = recorded_reads().into_iter().map(|file| settle(&file));
    let files: Vec<PathBuf> = read.filter(|file| !is_own_part(file)).collect();
    let assets = std::env::var_os("SUNROOM_ASSETS").unwrap_or_default();
    let assets = std::env::split_paths(&assets).filter(|folder| !folder.as_os_str().is_empty());
    let assets: Vec<PathBuf> = assets.map(|folder| settle(&folder)).collect();
    let (scene, members) = bundle::arrange(&path, &files, &assets);
    Ok(Some(Job {
        members,
        scene,
        spp,
        size,
    }))
}

/// An absolute file name in the document for which `is_excepted` is false, if there is one.
fn absolute_name(document: &Document, is_excepted: &dyn Fn(&Path) -> bool) -> Option<String> {
    let mut waiting = vec![&*document.root];
    while let Some(object) = waiting.pop() {
        let names = object.properties.iter().filter(|property| property.name == "filename");
        for property in names {
            if let Value::String(name) = &property.value
                && Path::new(name.as_str()).is_absolute()
                && !is_excepted(Path::new(name.as_str()))
            {
                return Some(name.to_string());
            }
        }
        waiting.extend(object.objects());
    }
    None
}

/// The scripts of the job by name.
fn scripts(args: &SubmitArgs, work: &Work, plan: &Plan, job: &Job) -> [(&'static str, String); 3] {
    let stem = job.scene.file_stem().unwrap_or_default().to_string_lossy();
    let is_plain = |letter: char| letter.is_ascii_alphanumeric() || letter == '-' || letter == '_';
    let name: String = stem
        .chars()
        .map(|letter| if is_plain(letter) { letter } else { '_' })
        .collect();
    let is_bake = args.bake;
    let of = |bake: &str, render: &str| if is_bake { bake } else { render }.to_owned();
    let result = match args.frames {
        Some(_) => format!("{name}-\"$frame\".exr"),
        None => format!("{name}{}", of("", ".exr")),
    };
    let options: Vec<String> = work::options(args).iter().map(|option| quoted(option)).collect();
    let cuts: Vec<String> = plan.cuts.iter().map(u32::to_string).collect();
    let crops = plan
        .crops
        .iter()
        .map(|part::Crop { x, y, width, height }| format!("{x},{y},{width},{height}"));
    let crops: Vec<String> = crops.collect();
    let values = [
        ("@NAME@", name),
        ("@SCENE@", quoted(&format!("{FILES}/{}", job.scene.display()))),
        ("@COMMAND@", work.command().to_owned()),
        ("@STEP@", of("Bake", "Render")),
        (
            "@PIECE@",
            of("the samples of the bake", "the samples of a crop of one or more frames"),
        ),
        ("@RESULTS@", of("levels", "pictures")),
        ("@RESULT@", result),
        ("@PART@", of("bake", "exr")),
        ("@OPTIONS@", options.join(" ")),
        (
            "@MERGE_OPTIONS@",
            match [args.denoise, args.no_denoise] {
                [true, _] => "--denoise",
                [_, true] => "--no-denoise",
                _ => "",
            }
            .to_owned(),
        ),
        ("@CROP_OPTION@", of("", "--crop \"${crops[crop]}\"")),
        ("@PROGRESS_OPTION@", of("", "--stats=json-lines")),
        (
            "@FRAME_OPTION@",
            args.frames.as_ref().map_or("", |_| "--frames \"$frame\"").to_owned(),
        ),
        (
            "@FRAME_NUMBER@",
            if args.frames.is_some() { "####" } else { "0000" }.to_owned(),
        ),
        ("@SPP@", job.spp.to_string()),
        ("@CUTS@", cuts.join(" ")),
        ("@CROPS@", crops.join(" ")),
        ("@FIRST_FRAME@", plan.frames.start().to_string()),
        ("@LAST_FRAME@", plan.frames.end().to_string()),
        ("@FRAMES_A_TASK@", plan.frames_a_task.to_string()),
        ("@FIRST_TASK@", "0".to_owned()),
        ("@LAST_TASK@", (plan.tasks() - 1).to_string()),
    ];
    let filled = |template: &str| {
        values
            .iter()
            .fold(template.to_owned(), |text, (name, value)| text.replace(name, value))
    };
    let (start, template) = args.to.template();
    [
        ("task", filled(TASK)),
        ("merge", filled(MERGE)),
        (start, filled(template)),
    ]
}

/// A word quoted for a shell.
fn quoted(word: &str) -> String {
    format!("'{}'", word.replace('\'', r"'\''"))
}

/// Writes an executable file.
fn write_script(path: &Path, content: &str) -> Result<(), Failure> {
    files::write_atomically(path, content).map_err(|error| format!("cannot write {}: {error}", path.display()))?;
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        std::fs::set_permissions(path, std::fs::Permissions::from_mode(0o755))?;
    }
    Ok(())
}

/// Whether the scene in the job finds its files there. The check reports missing files.
fn is_complete(args: &SubmitArgs, scene: &Path) -> Result<bool, Failure> {
    let mut check = Command::new(std::env::current_exe()?);
    check
        .arg("check")
        .arg(args.output.join(FILES).join(scene))
        .env_remove("SUNROOM_ASSETS");
    for (name, value) in &args.scene.defines.defines {
        check.arg("-D").arg(format!("{name}={value}"));
    }
    check.args(args.missing.allow_missing.then_some("--allow-missing"));
    Ok(check.status()?.success())
}
