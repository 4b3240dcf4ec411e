//! The figures of a render, for people and for machines.

use std::path::PathBuf;
use std::time::Duration;

use bevy::prelude::World;
use serde::Serialize;
use sunroom::engine::{AutoStatus, BvhStatus, GuideStatus, RenderControl, RenderFilm, RenderStatus};
use sunroom::scene::SamplerSettings;

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
    /// The estimated relative noise; None if all is black or pixels have a single sample.
    pub noise: Option<f32>,
    /// The choice of the integrator `auto`; None for another integrator.
    pub auto: Option<AutoStatus>,
    pub seed: u32,
    pub threads: usize,
    pub denoised: bool,
    pub triangles: u64,
    pub load_ms: f64,
    pub bvh: BvhStatus,
    pub render_ms: f64,
    pub denoise_ms: f64,
    pub rays: u64,
    /// The state of path guiding; None without it.
    pub guide: Option<GuideStatus>,
    pub mrays_per_s: f64,
    pub msamples_per_s: f64,
    /// Samples that were not finite and counted as black.
    pub invalid_samples: u64,
    /// The share of the light that a clamp removes, as estimated; None without a clamp.
    pub clamped_light: Option<f32>,
    /// The peak memory of the process; None if the system does not give it.
    pub peak_memory_bytes: Option<u64>,
    pub outputs: Vec<PathBuf>,
}

impl Stats {
    /// The figures of the rendered picture, without those that the engine does not know.
    pub fn of(world: &World) -> Self {
        let (status, film) = (world.resource::<RenderStatus>(), &world.resource::<RenderFilm>().film);
        Self {
            scene: PathBuf::new(),
            width: film.width(),
            height: film.height(),
            // A share of a picture counts samples of the whole picture.
            spp: status.samples.saturating_sub(status.first),
            noise: status.noise,
            auto: status.auto,
            seed: world.resource::<SamplerSettings>().seed,
            threads: world.resource::<RenderControl>().threads.get(),
            denoised: false,
            triangles: status.triangles,
            load_ms: 0.0,
            bvh: status.bvh,
            render_ms: status.seconds * 1e3,
            denoise_ms: 0.0,
            rays: status.rays,
            guide: status.guide,
            mrays_per_s: status.mrays_per_s,
            msamples_per_s: status.msamples_per_s,
            invalid_samples: status.invalid_samples,
            clamped_light: status.clamped.map(|limit| limit.removed),
            peak_memory_bytes: peak_memory_bytes(),
            outputs: Vec::new(),
        }
    }

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
            self.bvh.sah_cost,
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
