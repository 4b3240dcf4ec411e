//! The stages of a bake in words, for the command line and the window.

use super::blueprint::Blueprint;
use super::probes::ProbeKind;
use super::progress::Stage;

impl Stage {
    /// What is being done, in words. The names of probes are those of `blueprint`.
    pub fn words(self, blueprint: Option<&Blueprint>) -> String {
        let probe = |number: usize| blueprint.and_then(|blueprint| blueprint.probes.get(number));
        let name = |number: usize| probe(number).map_or("", |probe| probe.name.as_str());
        match self {
            Self::PlacingProbes => "placing the probes".to_owned(),
            Self::Unwrapping => "unwrapping the level".to_owned(),
            Self::Lightmaps => "gathering the light of the lightmaps".to_owned(),
            Self::FinishingLightmaps => "finishing the lightmaps".to_owned(),
            Self::Probe(number) => match probe(number).map(|probe| probe.kind) {
                Some(ProbeKind::Volume { .. }) => format!("irradiance volume `{}`", name(number)),
                _ => format!("reflection probe `{}`", name(number)),
            },
            Self::FinishingProbe(number) => format!("filtering `{}`", name(number)),
        }
    }
}
