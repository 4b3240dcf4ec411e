//! Two runs side by side, pair by pair: ratios above 1 are for the new one.

use std::fmt::Write;

use super::results::{RayResult, RenderResult, Results};

/// One line for each subject that both have.
pub fn table(new: &Results, old: &Results) -> String {
    let mut text = format!(
        "\nagainst {} ({} threads): above 1 this run is ahead\n",
        old.program, old.threads
    );
    let mut line = |name: String, ratios: &[(&str, f64)]| {
        let ratios: Vec<String> = ratios
            .iter()
            .map(|(what, ratio)| format!("{what} {ratio:.2}"))
            .collect();
        // Writing to a string does not fail.
        let _ = writeln!(text, "{name:36} {}", ratios.join(", "));
    };
    for now in &new.renders {
        if let Some(before) = old.renders.iter().find(|before| is_same_render(before, now)) {
            let cpu = before.cpu_seconds.zip(now.cpu_seconds);
            line(
                now.scene.clone(),
                &[
                    ("speed", before.seconds / now.seconds),
                    ("CPU", cpu.map_or(f64::NAN, |(before, now)| before / now)),
                    ("relMSE", before.rel_mse / now.rel_mse),
                    ("relMSE x s", before.cost / now.cost),
                ],
            );
        }
    }
    for now in &new.rays {
        if let Some(before) = old.rays.iter().find(|before| is_same_rays(before, now)) {
            line(
                now.rays.clone(),
                &[
                    ("closest", now.closest.one_thread / before.closest.one_thread),
                    (
                        "closest, all threads",
                        now.closest.all_threads / before.closest.all_threads,
                    ),
                    ("any", now.any.one_thread / before.any.one_thread),
                    ("build", before.build_seconds / now.build_seconds),
                    ("memory", before.bytes_per_triangle / now.bytes_per_triangle),
                ],
            );
        }
    }
    text
}

/// Speeds of other sizes and other numbers of samples say nothing about each other.
fn is_same_render(a: &RenderResult, b: &RenderResult) -> bool {
    (&a.scene, a.width, a.height, a.spp) == (&b.scene, b.width, b.height, b.spp)
}

fn is_same_rays(a: &RayResult, b: &RayResult) -> bool {
    (&a.mesh, &a.rays, a.count) == (&b.mesh, &b.rays, b.count)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_the_same_is_compared() {
        let render = |spp: u32, seconds: f64| RenderResult {
            scene: "box".to_owned(),
            width: 8,
            height: 6,
            spp,
            seconds,
            cpu_seconds: None,
            msamples_per_s: 1.0,
            mrays_per_s: 1.0,
            rel_mse: 0.5,
            cost: 0.5 * seconds,
        };
        let results = |renders: Vec<RenderResult>| Results {
            renders,
            ..Results::new(2)
        };
        let old = results(vec![render(4, 9.0), render(16, 3.0)]);
        let text = table(&results(vec![render(16, 2.0)]), &old);
        assert!(text.contains("speed 1.50") && text.contains("relMSE 1.00"), "{text}");
        let text = table(&results(vec![render(32, 2.0)]), &old);
        assert!(!text.contains("speed"), "{text}");
    }
}
