//! The route of light: from its source to the camera, as far as it matters to people.

use glam::Vec3;

use crate::color::Rgb;
use crate::light::LightId;
use crate::material::Lobe;
use crate::medium::MediumId;
use crate::render::inspect::{RecordedPath, RecordedVertex};
use crate::render::observer::PathVertex;
use crate::render::scene::RenderScene;

/// The emitter at which light begins.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Source {
    /// A light; of a light that is sky and sun, the sky.
    Light(LightId),
    /// The sun of a light that is sky and sun.
    Sun(LightId),
    /// A medium that glows.
    Medium(MediumId),
}

/// The last thing from which light has come to the surface or medium that is seen.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Way {
    /// None: it has come straight from its source, and perhaps through surfaces that let it pass straight on, such as
    /// panes. `through` is the instance of the one that is nearest to the seen surface; invisible borders of media do
    /// not count.
    Straight {
        /// The instance, as [`crate::accel::Hit::instance`] counts them.
        through: Option<u32>,
    },
    /// A surface of this instance.
    Surface {
        /// The instance, as [`crate::accel::Hit::instance`] counts them.
        instance: u32,
        /// Whether the light has gone through the surface, in place of being reflected by it.
        is_through: bool,
    },
    /// A medium.
    Medium(MediumId),
    /// One of very many things that are not told apart.
    Other,
}

declare_names! {
    /// How light was scattered on its route. Of several that hold, the last one of this list.
    #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
    pub enum Kind {
        /// The emitter itself is seen.
        Seen = "seen" => "emitter in view",
        /// The seen surface has scattered light that has come straight from the emitter.
        Direct = "direct" => "direct light",
        /// Several surfaces have scattered the light.
        Diffuse = "diffuse" => "diffuse interreflection",
        /// A mirror or a glossy surface has reflected the light.
        Mirror = "mirror" => "mirrors and gloss",
        /// The light has gone through glass.
        Glass = "glass" => "glass",
        /// A medium has scattered the light, or emitted it.
        Medium = "medium" => "media",
    }
}

/// The route of light from its source to the camera.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Route {
    /// The emitter.
    pub source: Source,
    /// The last thing from which the light has come to the seen surface.
    pub way: Way,
    /// The number of times that the light was scattered. Surfaces that have let it pass straight on do not count.
    pub bounces: u32,
    /// How it was scattered.
    pub kind: Kind,
    /// Whether a mirror or glass, smooth or nearly so, has focused it onto a surface that scatters widely: a caustic.
    pub is_caustic: bool,
}

/// Light that a path has found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contribution {
    /// Its route.
    pub route: Route,
    /// The contribution to the path's radiance.
    pub light: Rgb,
}

/// The density per solid angle from which on a scattering counts as glossy: a diffuse surface scatters nowhere with
/// more than 1 / pi.
const GLOSSY_DENSITY: f32 = 1.0;

/// The density from which on a scattering focuses light: a lamp has to be within a hundredth of a steradian of one
/// direction, where light sampling seldom finds it.
const FOCUSING_DENSITY: f32 = 100.0;

/// What is known of a route while a path is followed from the camera on.
#[derive(Clone, Copy, Debug)]
struct Trail {
    bounces: u32,
    way: Way,
    has_medium: bool,
    has_glass: bool,
    has_gloss: bool,
    /// Whether any of the scatterings was wide.
    is_spread: bool,
    is_caustic: bool,
}

impl Trail {
    const BEGIN: Self = Self {
        bounces: 0,
        way: Way::Straight { through: None },
        has_medium: false,
        has_glass: false,
        has_gloss: false,
        is_spread: false,
        is_caustic: false,
    };

    /// The trail behind a scattering at `vertex`, to which the path came in direction `dir` and which it leaves to
    /// `wi` with this density per solid angle.
    fn scattered(mut self, vertex: &RecordedVertex, dir: Vec3, wi: Vec3, density: f32) -> Self {
        let is_glossy = density > GLOSSY_DENSITY;
        self.bounces += 1;
        let second = match vertex.place {
            PathVertex::Surface(surface) => {
                let is_through = dir.dot(surface.normal) * wi.dot(surface.normal) > 0.0;
                self.has_glass |= is_glossy && is_through;
                self.has_gloss |= is_glossy && !is_through;
                self.is_caustic |= self.is_spread && density > FOCUSING_DENSITY;
                self.is_spread |= !is_glossy;
                Way::Surface {
                    instance: surface.instance,
                    is_through,
                }
            }
            PathVertex::Medium(place) => {
                self.has_medium = true;
                self.is_spread = true;
                Way::Medium(place.medium)
            }
        };
        if self.bounces == 2 {
            self.way = second;
        }
        self
    }

    /// The trail behind a surface that has let the path pass straight on. Invisible borders of media are not told.
    fn passed(mut self, scene: &RenderScene, vertex: &RecordedVertex) -> Self {
        if self.bounces == 1
            && let (Way::Straight { through: None }, PathVertex::Surface(surface)) = (self.way, vertex.place)
            && !scene.materials.is_null(surface.material)
        {
            self.way = Way::Straight {
                through: Some(surface.instance),
            };
        }
        self
    }

    fn route(&self, source: Source) -> Route {
        let is_medium = self.has_medium || matches!(source, Source::Medium(_));
        Route {
            source,
            way: self.way,
            bounces: self.bounces,
            kind: match self.bounces {
                _ if is_medium => Kind::Medium,
                _ if self.has_glass => Kind::Glass,
                _ if self.has_gloss => Kind::Mirror,
                0 => Kind::Seen,
                1 => Kind::Direct,
                _ => Kind::Diffuse,
            },
            is_caustic: self.is_caustic,
        }
    }
}

/// The contributions of a path of path tracing, with their routes. They sum up to its radiance but for rounding. Those
/// that are black are left out.
pub fn contributions(scene: &RenderScene, path: &RecordedPath) -> Vec<Contribution> {
    let mut found = Vec::new();
    let mut add = |trail: &Trail, source: Source, light: Rgb| {
        if light != Rgb::ZERO {
            found.push(Contribution {
                route: trail.route(source),
                light,
            });
        }
    };
    let source = |light: LightId, wi: Vec3| match scene.lights.is_sun(light, wi) {
        true => Source::Sun(light),
        false => Source::Light(light),
    };
    let mut trail = Trail::BEGIN;
    let mut dir = path.camera_ray.dir;
    let mut glows = path.glows.iter().peekable();
    for (number, vertex) in path.vertices.iter().enumerate() {
        while let Some((_, glow)) = glows.next_if(|(after, _)| *after <= number) {
            add(&trail, Source::Medium(glow.medium), glow.contribution);
        }
        if let Some(met) = &vertex.met {
            add(&trail, Source::Light(met.light), met.contribution);
        }
        if let Some(sampled) = vertex.sampled.filter(|sampled| sampled.contribution != Rgb::ZERO) {
            let wi = sampled.sample.wi;
            let mut trail = trail.scattered(vertex, dir, wi, sampled.bsdf_pdf);
            if trail.bounces == 1 {
                trail.way = Way::Straight {
                    through: sampled.through,
                };
            }
            add(&trail, source(sampled.light, wi), sampled.contribution);
        }
        if let Some(joined) = &vertex.joined {
            add(&trail, Source::Light(joined.light), joined.contribution);
        }
        if let Some(bounce) = &vertex.bounce {
            trail = match bounce.lobe {
                Lobe::Null => trail.passed(scene, vertex),
                Lobe::Delta => trail.scattered(vertex, dir, bounce.wi, f32::INFINITY),
                Lobe::Smooth => trail.scattered(vertex, dir, bounce.wi, bounce.pdf),
            };
            dir = bounce.wi;
        }
    }
    for (_, glow) in glows {
        add(&trail, Source::Medium(glow.medium), glow.contribution);
    }
    for met in &path.escaped_to {
        add(&trail, source(met.light, dir), met.contribution);
    }
    found
}
