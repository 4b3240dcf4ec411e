//! The active sensor, its film and the settings as the renderer's view.

use bevy::math::{Affine3A, UVec2, Vec2, Vec3};

use super::super::control::{Filling, RenderControl, ViewMode};
use super::super::resolution;
use super::Checker;
use crate::layer::{Layer, Layers};
use crate::medium::MediumId;
use crate::render::camera::{Camera, ThinLens};
use crate::render::clamp::Clamp;
use crate::render::filter::{FilterKernel, PixelFilter};
use crate::render::guide::Guide;
use crate::render::light_layers::LightGroups;
use crate::render::photon_rounds::PhotonRounds;
use crate::render::view::{Integrator, PathSettings, PhotonSettings, Shown, Strategy, View};
use crate::render::visibility::sight::Sight;
use crate::sampling::SequenceKind;
use crate::scene::parameters::FOV;
use crate::scene::{
    self, Film, IntegratorSettings, Lens, PathPlugin, PixelFormat, ReconstructionFilter, SamplerSettings, Sensor,
    Sequence,
};

/// The most bounces before Russian roulette begins. Only roulette ends the paths of a closed white room, which would
/// otherwise take minutes each.
const LATEST_ROULETTE: u32 = 1024;
/// The same limit where every vertex of a camera path is connected to every vertex of a light path.
const LATEST_ROULETTE_OF_JOINED: u32 = 128;
/// The largest angle of view across the surroundings of a film, in degrees.
const WIDEST: f32 = 100.0;

/// Packs the view of a sensor, which is in `medium`. None, with a report, if the sensor has no direction.
pub(in crate::engine) fn pack_view(
    sensor: &Sensor,
    film: &Film,
    to_world: Affine3A,
    integrator: &IntegratorSettings,
    sampler: &SamplerSettings,
    medium: Option<MediumId>,
    control: &RenderControl,
    check: &mut Checker,
) -> Option<View> {
    let Some(world_from_camera) = rigid(to_world) else {
        check.report("the camera's pose is degenerate, the last one is kept");
        return None;
    };
    let window = film.window();
    let asked = resolution::asked(film, control);
    let size = resolution::possible(asked);
    if size != asked {
        check.report(format_args!(
            "a film of {} x {} pixels is not possible",
            asked.x, asked.y
        ));
    }
    let film_size = UVec2::new(film.width, film.height).max(UVec2::ONE).as_vec2();
    let crop_min = UVec2::new(window.x, window.y).as_vec2() / film_size;
    let crop_size = UVec2::new(window.width, window.height).max(UVec2::ONE).as_vec2() / film_size;
    // The aspect of the whole film: the framing is equal at every resolution, whatever the rounding of its size.
    let whole = size.as_vec2() / crop_size;
    let aspect = whole.x / whole.y;
    let mut framing = resolution::framing(film, control);
    let near = check.number("near_clip", sensor.near_clip, 0.0, 1e30, 1e-2);
    let far = check.number(
        "far_clip",
        sensor.far_clip,
        near.next_up(),
        f32::MAX,
        1e4_f32.max(near.next_up()),
    );
    let fov = check.within(&FOV, sensor.fov, Sensor::default().fov);
    let pose = world_from_camera;
    let camera = match sensor.lens {
        Lens::Orthographic => {
            let [left, up, forward] = columns(to_world).map(Vec3::length);
            // In the file the near plane is in the sensor's space, and depths are in world space.
            let near = near * forward;
            let far = near + far - sensor.near_clip.max(0.0);
            Camera::orthographic(pose, Vec2::new(left, up / aspect), near, far)
        }
        Lens::Pinhole | Lens::Thin { .. } => {
            let fov_x = sensor.fov_axis.horizontal(fov, aspect);
            Camera::new(pose, fov_x, aspect, near, far, thin_lens(sensor.lens, check))
        }
    };
    let offset = sensor.principal_point_offset;
    let offset = Vec2::new(
        check.number("principal_point_offset_x", offset.x, -1e3, 1e3, 0.0),
        check.number("principal_point_offset_y", offset.y, -1e3, 1e3, 0.0),
    );
    let crop_min = crop_min + offset;
    let film_camera = camera.cropped(crop_min, crop_min + crop_size);
    let camera = match surrounded(film_camera, framing.extent, control.filling) {
        Some(camera) => camera,
        None => {
            framing = resolution::framing_of_film(film, control);
            film_camera
        }
    };
    let max_depth = integrator.max_depth.unwrap_or(u32::MAX);
    let latest = match integrator.plugin {
        PathPlugin::Bdpt | PathPlugin::Vcm => LATEST_ROULETTE_OF_JOINED,
        _ => LATEST_ROULETTE,
    };
    if integrator.rr_depth.min(max_depth) > latest {
        let given = integrator.rr_depth;
        check.report(format_args!(
            "rr_depth is {given}: Russian roulette begins after {latest} bounces, for paths have to end"
        ));
    }
    let path_settings = PathSettings {
        max_depth,
        rr_depth: integrator.rr_depth.min(latest),
        hide_emitters: integrator.hide_emitters,
        media: integrator.plugin.traces_media(),
        strategy: match integrator.strategy {
            scene::Strategy::Bsdf => Strategy::Bsdf,
            scene::Strategy::Light => Strategy::Light,
            scene::Strategy::Mis => Strategy::Mis,
        },
    };
    Some(View {
        camera,
        film_camera: (camera != film_camera).then_some(film_camera),
        width: framing.size.x,
        height: framing.size.y,
        medium,
        filter: pixel_filter(film.filter, check),
        integrator: match integrator.plugin {
            // Before a choice, `auto` is path tracing.
            PathPlugin::Path | PathPlugin::VolPath | PathPlugin::VolPathMis | PathPlugin::Auto => {
                Integrator::Path(path_settings)
            }
            PathPlugin::Bdpt => Integrator::Bidirectional(path_settings),
            PathPlugin::Vcm => Integrator::Merging(
                path_settings,
                PhotonSettings {
                    paths: integrator.photons,
                    radius: merge_radius(integrator, check),
                },
            ),
            PathPlugin::Ptracer => Integrator::LightTracing(path_settings),
        },
        shown: match control.view_mode {
            ViewMode::BvhSteps => Shown::BvhSteps,
            ViewMode::OpticalDepth => Shown::OpticalDepth,
            ViewMode::Illuminance => Shown::Illuminance,
            ViewMode::Headlight => Shown::Headlight,
            ViewMode::Clay => Shown::Clay,
            ViewMode::Path if control.strategy_split => Shown::StrategyThirds,
            ViewMode::Path => Shown::Radiance,
        },
        // The sight is set later, because it depends on the geometry as well.
        sight: Sight::default(),
        light_groups: LightGroups::default(),
        layers: match film.storage.pixels.is_some_and(PixelFormat::has_alpha) {
            true => integrator.layers.and(Layers::of(&[Layer::Alpha])),
            false => integrator.layers,
        },
        before: None,
        sequence: match sampler.sequence {
            Sequence::Sobol => SequenceKind::Sobol,
            Sequence::Independent => SequenceKind::Independent,
        },
        seed: sampler.seed,
        photons: PhotonRounds::default(),
        guide: (integrator.guided && integrator.plugin.is_guidable()).then(Guide::default),
        clamp: integrator
            .clamp_percentile
            .map(|percentile| Clamp::new(clamp_percentile(percentile, check))),
    })
}

/// The camera of a picture that is `extent` times as wide and high as the film. None if its angles of view would exceed
/// [`WIDEST`] though those of the film do not, and all of the film has to be seen.
fn surrounded(film: Camera, extent: Vec2, filling: Filling) -> Option<Camera> {
    if extent == Vec2::ONE {
        return Some(film);
    }
    let own = film.half_extent();
    let widest = match film.is_orthographic() {
        true => f32::INFINITY,
        false => own.max_element().max((0.5 * WIDEST.to_radians()).tan()),
    };
    let excess = (extent * own).max_element() / widest;
    if excess > 1.0 && filling == Filling::AroundFilm {
        return None;
    }
    let extent = extent / excess.max(1.0);
    Some(film.cropped(0.5 - 0.5 * extent, 0.5 + 0.5 * extent))
}

fn clamp_percentile(percentile: f32, check: &mut Checker) -> f32 {
    let range = IntegratorSettings::CLAMP_PERCENTILES;
    check.number(
        "clamp_percentile",
        percentile,
        *range.start(),
        *range.end(),
        *range.end(),
    )
}

fn merge_radius(integrator: &IntegratorSettings, check: &mut Checker) -> f32 {
    let (radii, usual) = (
        IntegratorSettings::MERGE_RADII,
        IntegratorSettings::default().merge_radius,
    );
    check.number(
        "merge_radius",
        integrator.merge_radius,
        *radii.start(),
        *radii.end(),
        usual,
    )
}

/// The pose without scale and shear: forward stays, up is made perpendicular to it, and a mirrored pose stays mirrored.
pub(super) fn rigid(pose: Affine3A) -> Option<Affine3A> {
    let [left, up, forward] = columns(pose);
    let position = Vec3::from(pose.translation);
    let forward = forward.try_normalize()?;
    let up = up.try_normalize()?;
    let up = (up - up.dot(forward) * forward).try_normalize()?;
    let side = up.cross(forward);
    let mirror = if side.dot(left) < 0.0 { -1.0 } else { 1.0 };
    let rigid = Affine3A::from_mat3_translation(bevy::math::Mat3::from_cols(mirror * side, up, forward), position);
    rigid.is_finite().then_some(rigid)
}

fn columns(pose: Affine3A) -> [Vec3; 3] {
    [pose.matrix3.x_axis, pose.matrix3.y_axis, pose.matrix3.z_axis].map(Vec3::from)
}

fn pixel_filter(filter: ReconstructionFilter, check: &mut Checker) -> PixelFilter {
    match filter {
        ReconstructionFilter::Box => PixelFilter::Box,
        ReconstructionFilter::Tent { radius } => PixelFilter::Tent {
            radius: check.number("radius", radius, 1e-3, 100.0, 1.0),
        },
        ReconstructionFilter::Gaussian { stddev } => {
            let stddev = check.number("stddev", stddev, 1e-3, 100.0, 0.5);
            PixelFilter::tabulated(FilterKernel::Gaussian { stddev })
        }
        ReconstructionFilter::Mitchell { b, c } => PixelFilter::tabulated(FilterKernel::Cubic {
            b: check.number("B", b, -4.0, 4.0, 1.0 / 3.0),
            c: check.number("C", c, -4.0, 4.0, 1.0 / 3.0),
        }),
        ReconstructionFilter::CatmullRom => PixelFilter::tabulated(FilterKernel::CATMULL_ROM),
        ReconstructionFilter::Lanczos { lobes } => PixelFilter::tabulated(FilterKernel::Lanczos {
            lobes: lobes.clamp(1, 16),
        }),
    }
}

/// The lens; None for a pinhole.
fn thin_lens(lens: Lens, check: &mut Checker) -> Option<ThinLens> {
    let Lens::Thin {
        aperture_radius,
        focus_distance,
        blades,
        blade_rotation,
    } = lens
    else {
        return None;
    };
    let aperture_radius = check.number("aperture_radius", aperture_radius, 0.0, 1e30, 0.0);
    let focus_distance = check.number("focus_distance", focus_distance, 1e-6, 1e30, 1.0);
    let blade_rotation = check.number("blade_rotation", blade_rotation, f32::MIN, f32::MAX, 0.0);
    (aperture_radius > 0.0).then_some(ThinLens {
        aperture_radius,
        focus_distance,
        blades,
        blade_rotation: blade_rotation.to_radians(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Crop;

    fn pack(sensor: &Sensor, to_world: Affine3A, control: &RenderControl) -> (Option<View>, Vec<String>) {
        pack_film(sensor, &Film::default(), to_world, control)
    }

    fn pack_film(
        sensor: &Sensor,
        film: &Film,
        to_world: Affine3A,
        control: &RenderControl,
    ) -> (Option<View>, Vec<String>) {
        let mut errors = Vec::new();
        let mut check = Checker {
            name: "camera",
            errors: &mut errors,
        };
        let view = pack_view(
            sensor,
            film,
            to_world,
            &IntegratorSettings::default(),
            &SamplerSettings::default(),
            None,
            control,
            &mut check,
        );
        (view, errors)
    }

    #[test]
    fn scale_and_shear_leave_the_pose() {
        let rotation = Affine3A::from_rotation_x(0.3) * Affine3A::from_rotation_y(1.1);
        let plain = rigid(rotation).expect("a rotation");
        let scaled = rigid(rotation * Affine3A::from_scale(Vec3::new(2.0, 3.0, 0.5))).expect("still a pose");
        assert!(scaled.abs_diff_eq(plain, 1e-6) && plain.abs_diff_eq(rotation, 1e-6));
        let mirrored = rigid(rotation * Affine3A::from_scale(Vec3::new(-1.0, 1.0, 1.0))).expect("mirrored");
        assert!(mirrored.matrix3.determinant() < 0.0);
    }

    #[test]
    fn a_degenerate_pose_is_no_view() {
        let control = RenderControl::default();
        for pose in [Affine3A::ZERO, Affine3A::from_translation(Vec3::NAN)] {
            let (view, errors) = pack(&Sensor::default(), pose, &control);
            assert!(view.is_none() && errors.len() == 1);
        }
    }

    #[test]
    fn a_crop_shows_its_part_of_the_film() {
        let crop = Crop {
            x: 30,
            y: 10,
            width: 20,
            height: 40,
        };
        let film = Film {
            width: 100,
            height: 50,
            ..Film::default()
        };
        let cropped = Film {
            crop: Some(crop),
            ..film
        };
        for lens in [Lens::Pinhole, Lens::Orthographic] {
            let sensor = Sensor {
                lens,
                principal_point_offset: Vec2::new(0.1, -0.3),
                ..Sensor::default()
            };
            let pose = Affine3A::from_scale(Vec3::new(3.0, 2.0, 1.0));
            for size in [None, Some(UVec2::new(40, 80))] {
                let control = RenderControl {
                    film_size_override: size,
                    ..RenderControl::default()
                };
                let whole = pack_film(&sensor, &film, pose, &RenderControl::default())
                    .0
                    .expect("a view");
                let part = pack_film(&sensor, &cropped, pose, &control).0.expect("a view");
                let expected = size.unwrap_or(UVec2::new(20, 40));
                assert_eq!((part.width, part.height), (expected.x, expected.y));
                let (a, b) = (
                    whole.camera.ray(Vec2::new(0.4, 0.6), Vec2::ZERO),
                    part.camera.ray(Vec2::new(0.5, 0.5), Vec2::ZERO),
                );
                assert!(
                    a.origin.abs_diff_eq(b.origin, 1e-5) && a.dir.abs_diff_eq(b.dir, 1e-6),
                    "{a:?} {b:?}"
                );
            }
        }
    }

    #[test]
    fn fewer_pixels_show_the_same_part_of_the_world() {
        let film = Film {
            width: 3840,
            height: 2161,
            crop: Some(Crop {
                x: 100,
                y: 7,
                width: 3001,
                height: 1999,
            }),
            ..Film::default()
        };
        let control = RenderControl {
            view_size: Some(UVec2::new(640, 480)),
            ..RenderControl::default()
        };
        for lens in [Lens::Pinhole, Lens::Orthographic] {
            let sensor = Sensor {
                lens,
                ..Sensor::default()
            };
            let [full, small] = [&RenderControl::default(), &control].map(|control| {
                pack_film(&sensor, &film, Affine3A::IDENTITY, control)
                    .0
                    .expect("a view")
            });
            assert_eq!((small.width, small.height), (640, 426));
            assert_eq!((full.width, full.height), (3001, 1999));
            assert_eq!(small.camera, full.camera);
        }
    }

    #[test]
    fn the_surroundings_of_a_film_leave_it_in_place() {
        let film = Film {
            width: 400,
            height: 300,
            ..Film::default()
        };
        let filled = |sensor: &Sensor, room, filling| {
            let control = RenderControl {
                view_size: Some(room),
                filling,
                ..RenderControl::default()
            };
            pack_film(sensor, &film, Affine3A::IDENTITY, &control)
                .0
                .expect("a view")
        };
        let room = UVec2::new(1600, 600);
        for lens in [Lens::Pinhole, Lens::Orthographic] {
            let sensor = Sensor {
                lens,
                ..Sensor::default()
            };
            let whole = filled(&sensor, room, Filling::None);
            assert_eq!(
                (whole.width, whole.height),
                (400, 300),
                "no more pixels than the film has"
            );
            assert_eq!(whole.film_corners(), View::WHOLE_FILM);
            for filling in [Filling::AroundFilm, Filling::Free] {
                let view = filled(&sensor, room, filling);
                assert_eq!((view.width, view.height), (1600, 600));
                assert_eq!(view.film_camera, Some(whole.camera));
                let [min, max] = view.film_corners();
                assert!(min.abs_diff_eq(Vec2::new(0.25, 0.0), 1e-6) && max.abs_diff_eq(Vec2::new(0.75, 1.0), 1e-6));
                let ray = |view: &View, place| view.camera.ray(place, Vec2::ZERO).dir;
                let at = Vec2::new(0.1, 0.7);
                let other = ray(&view, view.picture_of_film(at));
                assert!(other.abs_diff_eq(ray(&whole, at), 1e-6), "{other}");
            }
        }
        // At 90 degrees across, a strip beside the film would be seen at more than 100 degrees.
        let wide = Sensor {
            fov: 90.0,
            ..Sensor::default()
        };
        assert_eq!(filled(&wide, room, Filling::AroundFilm).film_camera, None);
        let free = filled(&wide, room, Filling::Free);
        let angle = 2.0 * free.camera.half_extent().x.atan().to_degrees();
        assert!((angle - WIDEST).abs() < 1e-3 && free.width == 1600, "{angle}");
    }

    #[test]
    fn odd_numbers_are_mended_and_reported() {
        let sensor = Sensor {
            lens: Lens::Thin {
                aperture_radius: f32::NAN,
                focus_distance: 0.0,
                blades: 0,
                blade_rotation: 0.0,
            },
            fov: f32::NAN,
            near_clip: -1.0,
            far_clip: -2.0,
            ..Sensor::default()
        };
        let control = RenderControl {
            resolution_scale: 0.25,
            film_size_override: Some(UVec2::new(100, 0)),
            ..RenderControl::default()
        };
        let (view, errors) = pack(&sensor, Affine3A::IDENTITY, &control);
        let view = view.expect("mended");
        assert_eq!((view.width, view.height), (25, 1));
        assert_eq!(view, view, "no NaN inside");
        assert_eq!(errors.len(), 6, "{errors:?}");
    }
}
