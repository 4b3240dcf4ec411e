//! Compares two runs pair by pair: in ratios above 1 the new one is better.

use std::fmt::{self, Display, Formatter, Write};
use std::path::{Path, PathBuf};

use super::results::{Rate, RayResult, RenderResult, Results};

/// The subject of a measurement: all properties that must be equal in two runs.
#[derive(Clone, Debug, PartialEq)]
pub enum Subject {
    Render { scene: PathBuf, size: (u32, u32), spp: u32 },
    Rays { mesh: String, rays: String, count: usize },
}

impl Subject {
    /// Speeds of other sizes and other numbers of samples are not comparable. The folders of scenes may differ.
    fn is_like(&self, other: &Self) -> bool {
        match (self, other) {
            (
                Self::Render { scene, size, spp },
                Self::Render {
                    scene: other_scene,
                    size: other_size,
                    spp: other_spp,
                },
            ) => scene.file_name() == other_scene.file_name() && (size, spp) == (other_size, other_spp),
            _ => self == other,
        }
    }
}

impl Display for Subject {
    fn fmt(&self, f: &mut Formatter) -> fmt::Result {
        match self {
            Self::Render { scene, size, spp } => {
                write!(f, "{} at {} x {} and {spp} spp", scene.display(), size.0, size.1)
            }
            Self::Rays { mesh, rays, count } => write!(f, "{count} rays of {rays} against {mesh}"),
        }
    }
}

impl From<&RenderResult> for Subject {
    fn from(render: &RenderResult) -> Self {
        Self::Render {
            scene: PathBuf::from(&render.scene),
            size: (render.width, render.height),
            spp: render.spp,
        }
    }
}

impl From<&RayResult> for Subject {
    fn from(rays: &RayResult) -> Self {
        Self::Rays {
            mesh: rays.mesh.clone(),
            rays: rays.rays.clone(),
            count: rays.count,
        }
    }
}

/// The comparable subject of an earlier run: the one with the same path, or else the only one that differs only in it.
fn counterpart<'o, T>(of: &Subject, old: &'o [T]) -> Option<&'o T>
where
    Subject: From<&'o T>,
{
    let like = || old.iter().filter(|old| of.is_like(&Subject::from(*old)));
    let same = like().find(|old| *of == Subject::from(*old));
    same.or_else(|| like().next().filter(|_| like().count() == 1))
}

fn has_counterpart(of: &Subject, old: &Results) -> bool {
    counterpart(of, &old.renders).is_some() || counterpart(of, &old.rays).is_some()
}

/// An error if no `planned` subject is in the file at `path`.
pub fn check(planned: &[Subject], old: &Results, path: &Path) -> Result<(), String> {
    if planned.iter().any(|subject| has_counterpart(subject, old)) {
        return Ok(());
    }
    let (path, there, here) = (path.display(), list(&subjects(old)), list(planned));
    Err(format!(
        "nothing to compare with {path}\n  it has {there}\n  this run has {here}"
    ))
}

fn subjects(results: &Results) -> Vec<Subject> {
    let renders = results.renders.iter().map(Subject::from);
    renders.chain(results.rays.iter().map(Subject::from)).collect()
}

fn list(subjects: &[Subject]) -> String {
    match subjects {
        [] => "nothing".to_owned(),
        subjects => subjects.iter().map(Subject::to_string).collect::<Vec<_>>().join(", "),
    }
}

/// One line for each common subject, and the subjects that are not compared.
pub fn table(new: &Results, old: &Results) -> String {
    let how = |results: &Results| {
        let rounds = results
            .rounds
            .map_or(String::new(), |rounds| format!(", rounds: {rounds}"));
        format!("threads: {}{rounds}", results.threads)
    };
    let this = match (new.threads, new.rounds) == (old.threads, old.rounds) {
        true => String::new(),
        false => format!("; this run has {}", how(new)),
    };
    let mut text = format!(
        "\nagainst {} ({}{this}): above 1 this run is ahead\n",
        old.program,
        how(old)
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
        if let Some(before) = counterpart(&now.into(), &old.renders) {
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
        if let Some(before) = counterpart(&now.into(), &old.rays) {
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
    let alone: Vec<Subject> = subjects(new)
        .into_iter()
        .filter(|subject| !has_counterpart(subject, old))
        .collect();
    if !alone.is_empty() {
        text += &format!("not there before: {}\n", list(&alone));
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_the_same_is_compared() {
        let render = |scene: &str, spp: u32, seconds: f64| RenderResult {
            scene: scene.to_owned(),
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
            ..Results::new(2, 3)
        };
        let old = results(vec![render("box", 4, 9.0), render("scenes/box", 16, 3.0)]);
        let text = table(&results(vec![render("box", 16, 2.0), render("ball", 16, 2.0)]), &old);
        assert!(text.contains("speed 1.50") && text.contains("relMSE 1.00"), "{text}");
        assert!(text.ends_with("not there before: ball at 8 x 6 and 16 spp\n"), "{text}");
        let planned = [Subject::from(&render("box", 32, 2.0))];
        assert_eq!(
            check(&planned, &old, Path::new("old.json")).expect_err("other samples"),
            "nothing to compare with old.json\n  it has box at 8 x 6 and 4 spp, scenes/box at 8 x 6 and 16 spp\n  \
             this run has box at 8 x 6 and 32 spp"
        );
        // Only the whole path identifies one of the two.
        let two = results(vec![render("a/box", 16, 3.0), render("b/box", 16, 4.0)]);
        let text = table(&results(vec![render("b/box", 16, 2.0)]), &two);
        assert!(text.contains("speed 2.00"), "{text}");
        assert!(check(&[Subject::from(&render("box", 16, 2.0))], &two, Path::new("old.json")).is_err());
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
            ..Results::new(2, 3)
        };
        let line = |old: &Results| table(&of(3.0, Some(rate(4.0))), old);
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
