//! Two runs side by side, pair by pair: ratios above 1 are for the new one.

use std::fmt::Write;
use std::path::Path;

use super::results::{Rate, RayResult, RenderResult, Results};

/// One line for each subject that both have; None if there is none.
pub fn table(new: &Results, old: &Results) -> Option<String> {
    let mut text = format!(
        "\nagainst {} ({} threads): above 1 this run is ahead\n",
        old.program, old.threads
    );
    let heading = text.len();
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
            let together = |rate: fn(&RayResult) -> Option<Rate>| {
                let (now, before) = rate(now).zip(rate(before))?;
                Some(now.one_thread / before.one_thread)
            };
            let ratios = [
                ("closest", Some(now.closest.one_thread / before.closest.one_thread)),
                ("closest together", together(|rays| rays.closest_together)),
                (
                    "closest with all threads",
                    Some(now.closest.all_threads / before.closest.all_threads),
                ),
                ("any", Some(now.any.one_thread / before.any.one_thread)),
                ("any together", together(|rays| rays.any_together)),
                ("build", Some(before.build_seconds / now.build_seconds)),
                ("memory", Some(before.bytes_per_triangle / now.bytes_per_triangle)),
            ];
            let ratios: Vec<_> = ratios
                .iter()
                .filter_map(|&(what, ratio)| Some((what, ratio?)))
                .collect();
            line(now.rays.clone(), &ratios);
        }
    }
    (text.len() > heading).then_some(text)
}

/// What to say where there is no table.
pub fn nothing_in_common(new: &Results, old: &Results, path: &Path) -> String {
    let (path, there, here) = (path.display(), subjects(old), subjects(new));
    format!("nothing to compare with {path}\n  it has {there}\n  this run has {here}")
}

/// All that has to be the same in two runs.
fn subjects(results: &Results) -> String {
    let renders = results.renders.iter().map(|render| {
        let RenderResult {
            scene,
            width,
            height,
            spp,
            ..
        } = render;
        format!("{scene} at {width} x {height} and {spp} spp")
    });
    let rays = results
        .rays
        .iter()
        .map(|rays| format!("{} rays of {} against {}", rays.count, rays.rays, rays.mesh));
    let all: Vec<String> = renders.chain(rays).collect();
    match all.is_empty() {
        true => "nothing".to_owned(),
        false => all.join(", "),
    }
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
        let text = text.expect("there is a line");
        assert!(text.contains("speed 1.50") && text.contains("relMSE 1.00"), "{text}");
        assert_eq!(table(&results(vec![render(32, 2.0)]), &old), None);
        assert_eq!(
            nothing_in_common(&results(vec![render(32, 2.0)]), &old, Path::new("old.json")),
            "nothing to compare with old.json\n  it has box at 8 x 6 and 4 spp, box at 8 x 6 and 16 spp\n  this run has box at 8 x 6 and 32 spp"
        );
    }

    #[test]
    fn rates_that_only_one_has_are_left_out() {
        let rate = |one_thread: f64| Rate {
            one_thread,
            all_threads: 2.0 * one_thread,
        };
        let of = |closest: f64, closest_together: Option<Rate>| Results {
            rays: vec![RayResult {
                mesh: "m.ply".to_owned(),
                rays: "r.rays".to_owned(),
                triangles: 1,
                count: 1,
                build_seconds: 1.0,
                bytes_per_triangle: 50.0,
                closest: rate(closest),
                any: rate(1.0),
                closest_together,
                any_together: None,
                wrong: 0,
                ties: 0,
            }],
            ..Results::new(2)
        };
        let line = |old: &Results| table(&of(3.0, Some(rate(4.0))), old).expect("there is a line");
        let both = line(&of(2.0, Some(rate(2.0))));
        assert!(
            both.contains("closest 1.50, closest together 2.00, closest with"),
            "{both}"
        );
        let one = line(&of(2.0, None));
        assert!(
            one.contains("closest 1.50, closest with all threads 1.50, any 1.00, build"),
            "{one}"
        );
    }
}
