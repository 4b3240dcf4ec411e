//! `sunroom submit`: a folder with a scene, its files, and a job that renders it on many machines.
//!
//! Two scripts do the work, one for a task and one for a merge. What starts them is a template for each system: Open Job Description, Slurm, GNU parallel.

mod bundle;
mod plan;

use std::fmt::Write;
use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};
use std::time::Duration;

use clap::{Args, Parser, ValueEnum};
use sunroom::app::headless::render_only;
use sunroom::document::paths::settle;
use sunroom::document::{Document, Value};
use sunroom::engine::{Limits, RenderControl, full_size, load_to_completion};
use sunroom::files::{self, record_reads, recorded_reads};
use sunroom::render::part;
use sunroom::scene::assets::parts_cache::is_part;
use sunroom::scene::assets::scene_asset::load_document;
use sunroom::scene::{ActiveSensor, Film, OpenScene, SceneStatus, Trust};

use self::plan::{Plan, Whole};
use super::args::{MemoryArgs, SceneArgs};
use super::check::report_scene;
use super::render::{RenderArgs, apply_overrides};
use super::report::{self, Failure, counted};
use super::sequence::frames;
use super::{outputs, parse};

/// The folder of the scene and its files in a job.
const FILES: &str = "files";

#[derive(Args)]
pub struct SubmitArgs {
    #[command(flatten)]
    scene: SceneArgs,
    /// The system that runs the job
    #[arg(long, value_name = "SYSTEM")]
    to: System,
    /// The folder of the job, which is made; parts and pictures go there too
    #[arg(short, long, value_name = "FOLDER")]
    output: PathBuf,
    /// Samples per pixel [default: those of the scene]
    #[arg(long, value_parser = clap::value_parser!(u32).range(1..))]
    spp: Option<u32>,
    /// The frames of an animation, such as 1..120
    #[arg(long, value_name = "FIRST..LAST", value_parser = frames)]
    frames: Option<RangeInclusive<u32>>,
    /// The time that a task should take on a machine like this one, on which a few seconds are rendered to measure it
    #[arg(long, value_name = "TIME", default_value = "10m", value_parser = parse::duration)]
    task_time: Duration,
    /// Divide the samples of each frame into this number of ranges, and measure nothing
    #[arg(long, value_name = "COUNT", conflicts_with = "task_time", value_parser = clap::value_parser!(u32).range(1..))]
    shares: Option<u32>,
    /// Cut each frame into columns and rows of crops as well, such as 4x2 [default: where ranges of samples alone would be longer than --task-time]
    #[arg(long, value_name = "COLUMNSxROWS", value_parser = parse::grid)]
    crops: Option<[u32; 2]>,
    /// Remove the noise of the merged pictures
    #[arg(long)]
    denoise: bool,
    /// Show what would be written, and write nothing
    #[arg(long)]
    dry_run: bool,
    #[command(flatten)]
    memory: MemoryArgs,
    /// Further options of `sunroom render` for each task, such as -- --width 1920 --aov all
    #[arg(last = true, value_name = "OPTIONS")]
    options: Vec<String>,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum System {
    /// Open Job Description, which AWS Deadline Cloud takes as well
    Openjd,
    /// Slurm
    Slurm,
    /// GNU parallel over ssh
    Parallel,
}

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

pub fn run(args: &SubmitArgs) -> ExitCode {
    args.memory.apply();
    match submit(args) {
        Ok(code) => code,
        Err(failure) => failure.report(),
    }
}

fn submit(args: &SubmitArgs) -> Result<ExitCode, Failure> {
    if args.output.read_dir().is_ok_and(|mut entries| entries.next().is_some()) {
        let message = format!(
            "{} is not empty; a job needs a folder of its own",
            args.output.display()
        );
        return Err(Failure::Usage(message));
    }
    let options = task_options(args)?.render;
    let Some(job) = gather(args, &options)? else {
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
        None => Plan::of_times(
            whole,
            frame_seconds(args, &options, job.spp)?,
            args.task_time.as_secs_f64(),
        ),
    };
    let plan = plan.map_err(Failure::Usage)?;
    let scripts = scripts(args, &plan, &job);
    let mut text = String::new();
    for member in &job.members {
        let _ = writeln!(text, "{FILES}/{}  {}", member.place.display(), member.file.display());
    }
    for (name, _) in &scripts {
        let _ = writeln!(text, "{name}");
    }
    let _ = writeln!(
        text,
        "{}: {}, each in {} of its {} x {} pixels and {} of its {}, {} a task",
        counted(plan.tasks(), "task"),
        counted(plan.frames.end() - plan.frames.start() + 1, "frame"),
        counted(plan.crops.len(), "crop"),
        job.size[0],
        job.size[1],
        counted(plan.ranges(), "range"),
        counted(job.spp, "sample"),
        counted(plan.frames_a_task, "frame"),
    );
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

/// What a job consists of.
struct Job {
    members: Vec<bundle::Member>,
    /// The place of the scene among the members.
    scene: PathBuf,
    /// Samples per pixel of a frame.
    spp: u32,
    /// The width and the height of a frame in pixels.
    size: [u32; 2],
}

/// The options of `sunroom render` for each task.
#[derive(Parser)]
#[command(no_binary_name = true)]
struct TaskOptions {
    #[command(flatten)]
    render: RenderArgs,
}

/// Loads the scene to see which files it reads. None if it has errors, which have been reported.
fn gather(args: &SubmitArgs, options: &RenderArgs) -> Result<Option<Job>, Failure> {
    let path = settle(&args.scene.scene);
    record_reads();
    let mut app = render_only(
        OpenScene {
            path: path.clone(),
            defines: args.scene.defines.defines.clone(),
            ..OpenScene::default()
        },
        Some(1),
    );
    app.insert_resource(Trust::Everything);
    let loaded = load_to_completion(&mut app, &Limits::default());
    if !report_scene(app.world().resource::<SceneStatus>(), false) {
        return Ok(None);
    }
    loaded?;
    let document = load_document(&path, &args.scene.defines.defines, Trust::Everything.access(&path))?;
    // The document of a glTF file names its parts in the user's cache. Every machine makes these for itself.
    let is_own_part = |file: &Path| document.imported && is_part(file);
    if let Some(name) = absolute_name(&document, &is_own_part) {
        let message = format!(
            "{}: `{name}` is an absolute name; the files of a job need names relative to the scene",
            path.display()
        );
        return Err(message.into());
    }
    apply_overrides(app.world_mut(), options)?;
    let sensor = app.world().resource::<ActiveSensor>().0;
    let film = sensor.and_then(|sensor| app.world().get::<Film>(sensor));
    let film = film.ok_or_else(|| format!("{} has no camera", path.display()))?;
    let spp = args.spp.unwrap_or(film.sample_count);
    let size = full_size(film, app.world().resource::<RenderControl>()).to_array();
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

/// What `sunroom render` understands by the options of a task.
fn task_options(args: &SubmitArgs) -> Result<TaskOptions, Failure> {
    let mut words = vec![args.scene.scene.clone().into_os_string()];
    if let Some(frames) = &args.frames {
        words.extend(["--frames".into(), frames.start().to_string().into()]);
    }
    words.extend(render_options(args).into_iter().map(Into::into));
    // Each task adds these options. None may be given twice, and some options do not go with them.
    let added = [
        "--spp",
        "1",
        "--samples",
        "0..1",
        "--crop",
        "0,0,1,1",
        "--checkpoint",
        "c.exr",
        "--resume",
        "c.exr",
    ];
    words.extend(added.map(Into::into));
    if matches!(args.to, System::Openjd) {
        words.push("--stats=json-lines".into());
    }
    let options = TaskOptions::try_parse_from(words).map_err(|error| {
        // The rest of the message is the usage of another command.
        let text = error.to_string();
        let text = text.split("\n\n").next().unwrap_or_default();
        Failure::Usage(format!(
            "the options after `--`: {}",
            text.trim_start_matches("error: ")
        ))
    })?;
    if !options.render.output.is_empty() || args.frames.is_none() && options.render.sequence.frames.is_some() {
        let message = "the options after `--`: tasks have their own --output, and --frames comes before `--`";
        return Err(Failure::Usage(message.to_owned()));
    }
    // A task renders a single frame, which is no whole turn.
    options.render.sequence.first_outputs(&[])?;
    Ok(options)
}

/// A name of a file in the document that is absolute and not excepted, if there is one.
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

/// The seconds that a frame takes on this machine, by rendering a little of the first one.
fn frame_seconds(args: &SubmitArgs, options: &RenderArgs, spp: u32) -> Result<f64, Failure> {
    let folder = tempfile::tempdir()?;
    let mut render = Command::new(std::env::current_exe()?);
    render
        .arg("render")
        .arg(&args.scene.scene)
        .arg("-o")
        .arg(folder.path().join("a.pfm"));
    render.args(["--time", "5s", "--stats=json"]);
    // What the tasks print does not matter here, and no option may be given twice.
    render.args(
        render_options(args)
            .iter()
            .filter(|option| !option.starts_with("--stats")),
    );
    if !options.quiet {
        render.arg("--quiet");
    }
    if let Some(frames) = &args.frames {
        render.args(["--frames", &frames.start().to_string()]);
    }
    let output = render.output()?;
    // If the time ends before each pixel has a sample, the render fails, but it prints its figures all the same.
    let Ok(stats) = serde_json::from_slice::<serde_json::Value>(&output.stdout) else {
        report::line(String::from_utf8_lossy(&output.stderr).trim_end());
        return Err("the scene cannot be rendered as the tasks would render it".into());
    };
    let number = |name: &str| stats[name].as_f64().unwrap_or(0.0);
    let samples = number("width") * number("height") * f64::from(spp);
    Ok(number("load_ms") / 1e3 + samples / (number("msamples_per_s") * 1e6).max(1.0))
}

/// The options of each call of `sunroom render`.
fn render_options(args: &SubmitArgs) -> Vec<String> {
    let defines = args.scene.defines.defines.iter();
    let defines = defines.flat_map(|(name, value)| ["-D".to_owned(), format!("{name}={value}")]);
    defines.chain(args.options.iter().cloned()).collect()
}

/// The scripts of the job by name.
fn scripts(args: &SubmitArgs, plan: &Plan, job: &Job) -> [(&'static str, String); 3] {
    let stem = job.scene.file_stem().unwrap_or_default().to_string_lossy();
    let is_plain = |letter: char| letter.is_ascii_alphanumeric() || letter == '-' || letter == '_';
    let name: String = stem
        .chars()
        .map(|letter| if is_plain(letter) { letter } else { '_' })
        .collect();
    let picture = match args.frames {
        Some(_) => format!("{name}-\"$frame\".exr"),
        None => format!("{name}.exr"),
    };
    let options: Vec<String> = render_options(args).iter().map(|option| quoted(option)).collect();
    let cuts: Vec<String> = plan.cuts.iter().map(u32::to_string).collect();
    let crops = plan
        .crops
        .iter()
        .map(|part::Crop { x, y, width, height }| format!("{x},{y},{width},{height}"));
    let crops: Vec<String> = crops.collect();
    let values = [
        ("@NAME@", name),
        ("@SCENE@", quoted(&format!("{FILES}/{}", job.scene.display()))),
        ("@PICTURE@", picture),
        ("@OPTIONS@", options.join(" ")),
        (
            "@MERGE_OPTIONS@",
            if args.denoise { "--denoise" } else { "" }.to_owned(),
        ),
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

/// A word for a shell.
fn quoted(word: &str) -> String {
    format!("'{}'", word.replace('\'', r"'\''"))
}

/// Writes a file that can be run.
fn write_script(path: &Path, content: &str) -> Result<(), Failure> {
    files::write_atomically(path, content).map_err(|error| format!("cannot write {}: {error}", path.display()))?;
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        std::fs::set_permissions(path, std::fs::Permissions::from_mode(0o755))?;
    }
    Ok(())
}

/// Whether the scene in the job finds its files there. What is missing is reported by the check.
fn is_complete(args: &SubmitArgs, scene: &Path) -> Result<bool, Failure> {
    let mut check = Command::new(std::env::current_exe()?);
    check
        .arg("check")
        .arg(args.output.join(FILES).join(scene))
        .env_remove("SUNROOM_ASSETS");
    for (name, value) in &args.scene.defines.defines {
        check.arg("-D").arg(format!("{name}={value}"));
    }
    Ok(check.status()?.success())
}
