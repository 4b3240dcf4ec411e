//! The illuminance of the surfaces that a camera sees: the irradiance on the side that faces it, whatever the material.
//!
//! At each first hit there is a receiver, as of a lightmap, so that the picture is what a meter at that place measures.

use std::sync::atomic::AtomicBool;

use super::borders::behind_borders;
use super::gathering::{Gathering, Site};
use super::irradiance::{ImmersedReceiver, ReceivedLight, Receiver};
use super::lanes::Job;
use super::light_layers::LightGroups;
use super::path_state::PathSample;
use super::scene::RenderScene;
use super::view::View;
use crate::accel::SurfacePoint;
use crate::math::Ray;

/// A sample of each job with its weight: irradiance in place of radiance, black where nothing is hit. None if `cancel`
/// was set in the meantime.
pub(super) fn trace(
    scene: &RenderScene,
    view: &View,
    jobs: &[Job],
    cancel: &AtomicBool,
) -> Option<Vec<(PathSample, f32)>> {
    let mut samples = Vec::with_capacity(jobs.len());
    let (mut sites, mut places) = (Vec::new(), Vec::new());
    for job in jobs {
        let camera = view.camera_sample(job.pixel, job.index);
        let ray = view.sight.narrow(&scene.geometry, camera.ray);
        let (met, rays) = behind_borders(scene, &ray, None, |_, _| {});
        let mut sample = PathSample {
            rays,
            ..PathSample::default()
        };
        if let Some(met) = met {
            sample.normal = met.point.shading_normal;
            sample.depth = met.hit.t;
            sample.first_hit = Some(met.hit);
            let receiver = receiver(&met.point, &ray);
            let site = ImmersedReceiver::seen_from(receiver, scene, ray.origin, view.medium);
            sites.push((site, camera.sampler));
            places.push(samples.len());
        }
        samples.push((sample, camera.weight));
    }
    let view = &View {
        light_groups: LightGroups::default(),
        ..view.clone()
    };
    let gathering = Gathering {
        scene,
        view,
        light: ReceivedLight::All,
    };
    let arrived = ImmersedReceiver::trace(&gathering, &sites, cancel)?;
    for (place, arrived) in places.into_iter().zip(arrived.samples) {
        let (sample, _) = &mut samples[place];
        sample.radiance = arrived.light;
        sample.rays += arrived.rays;
    }
    Some(samples)
}

/// The side of a surface that a ray has come to.
fn receiver(point: &SurfacePoint, ray: &Ray) -> Receiver {
    let turned = |normal: glam::Vec3, along: glam::Vec3| if normal.dot(along) < 0.0 { -normal } else { normal };
    let geometric_normal = turned(point.geometric_normal, -ray.dir);
    Receiver {
        position: point.position,
        error: point.error,
        normal: turned(point.shading_normal, geometric_normal),
        geometric_normal,
    }
}
