//! The figures of a render, for people and for machines.

use std::path::PathBuf;
use std::time::Duration;

use serde::Serialize;
use sunroom::engine::{AutoStatus, GuideStatus, RenderStatus};

#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum StatsFormat {
    Text,
    Json,
    JsonLines,
}

/// Times in milliseconds, memory in bytes.
#[derive(Serialize)]
pub struct Stats {
    pub scene: PathBuf,
    pub width: u32,
    pub height: u32,
    /// Samples per pixel that every pixel has.
    pub spp: u32,
    /// The estimated relative noise; None where all is black or pixels have a single sample.
    pub noise: Option<f32>,
    /// What the integrator `auto` stands for; None where another one is asked for.
    pub auto: Option<Auto>,
    pub seed: u32,
    pub threads: usize,
    pub denoised: bool,
    pub triangles: u64,
    pub load_ms: f64,
    pub bvh: Bvh,
    pub render_ms: f64,
    pub denoise_ms: f64,
    pub rays: u64,
    /// The guide of paths; None without one.
    pub guide: Option<Guide>,
    pub mrays_per_s: f64,
    pub msamples_per_s: f64,
    /// Samples that were not finite and counted as black.
    pub invalid_samples: u64,
    /// The share of the light that a clamp removes, as estimated; None without a clamp.
    pub clamped_light: Option<f32>,
    /// The most memory the process has held; None where the system does not tell.
    pub peak_memory_bytes: Option<u64>,
    pub outputs: Vec<PathBuf>,
}

/// The choice of the integrator `auto`.
#[derive(Serialize)]
pub struct Auto {
    pub integrator: &'static str,
    /// The variance of `path` over that of `bdpt` for the same cost, by the pilot; None without a pilot.
    pub gain: Option<f32>,
    /// The same over that of guided paths; None if they were not tried.
    pub gain_of_guide: Option<f32>,
    /// The share of the light that `path` never finds.
    pub missed: f32,
    /// The rays that the pilot has learnt a guide with, which are not among those of the render.
    pub guide_rays: u64,
}

impl From<AutoStatus> for Auto {
    fn from(status: AutoStatus) -> Self {
        Self {
            integrator: status.integrator,
            gain: status.choice.gain,
            gain_of_guide: status.choice.gain_of_guide,
            missed: status.choice.missed,
            guide_rays: status.guide_rays,
        }
    }
}

/// What paths were guided by.
#[derive(Serialize)]
pub struct Guide {
    /// The rays that it was learnt with, which are among those of the render.
    pub rays: u64,
    pub bytes: u64,
}

impl From<GuideStatus> for Guide {
    fn from(status: GuideStatus) -> Self {
        Self {
            rays: status.rays,
            bytes: status.bytes,
        }
    }
}

#[derive(Serialize)]
pub struct Bvh {
    pub build_ms: f64,
    pub nodes: u64,
    pub leaves: u64,
    pub max_depth: u32,
    pub sah: f64,
    pub bytes: u64,
}

impl Bvh {
    pub fn of(status: &RenderStatus) -> Self {
        Self {
            build_ms: status.bvh.build_ms,
            nodes: status.bvh.nodes,
            leaves: status.bvh.leaves,
            max_depth: status.bvh.max_depth,
            sah: status.bvh.sah_cost,
            bytes: status.bvh.bytes,
        }
    }
}

impl Stats {
    /// The last event of a render.
    pub fn event(&self) -> serde_json::Result<serde_json::Value> {
        let mut event = serde_json::to_value(self)?;
        event["event"] = "end".into();
        Ok(event)
    }

    pub fn text(&self) -> String {
        let memory = match self.peak_memory_bytes {
            Some(bytes) => format!("{:.0} MB", bytes as f64 / 1e6),
            None => "unknown".to_owned(),
        };
        let noise = self
            .noise
            .map_or_else(|| "unknown".to_owned(), |noise| format!("{noise:.5}"));
        format!(
            "{} x {}, {} spp, {} threads, {} triangles\n\
             seed {}, noise {noise}, {} samples that were not finite\n\
             load {:.0} ms, hierarchy {:.0} ms ({} nodes, depth {}, SAH cost {:.1}, {:.1} MB)\n\
             render {:.0} ms: {:.2} Mrays/s, {:.2} Msamples/s; denoise {:.0} ms; peak memory {memory}",
            self.width,
            self.height,
            self.spp,
            self.threads,
            self.triangles,
            self.seed,
            self.invalid_samples,
            self.load_ms,
            self.bvh.build_ms,
            self.bvh.nodes,
            self.bvh.max_depth,
            self.bvh.sah,
            self.bvh.bytes as f64 / 1e6,
            self.render_ms,
            self.mrays_per_s,
            self.msamples_per_s,
            self.denoise_ms,
        )
    }
}

pub fn milliseconds(duration: Duration) -> f64 {
    duration.as_secs_f64() * 1e3
}

/// The high-water mark of resident memory, as Linux counts it.
pub fn peak_memory_bytes() -> Option<u64> {
    memory_line("VmHWM:")
}

/// The resident memory, as Linux counts it.
pub fn memory_bytes() -> Option<u64> {
    memory_line("VmRSS:")
}

fn memory_line(name: &str) -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix(name))?;
    let kibibytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(kibibytes * 1024)
}
