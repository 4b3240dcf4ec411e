//! Small scenes and statistics for tests of the kernel.
#![allow(dead_code, reason = "every test binary uses its own part")]

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use glam::{Affine3A, Vec3};
use sunroom::accel::{Blas, Instance, Primitive, SplitMethod, Tlas};
use sunroom::color::{Rgb, luminance};
use sunroom::geometry::mesh::MeshData;
use sunroom::light::{LightId, LightReference, LightSource, LightTable, Portal, WeightedSource};
use sunroom::material::{Material, MaterialId, MaterialTable};
use sunroom::medium::{MediumInterface, MediumSource, MediumTable};
use sunroom::render::camera::Camera;
use sunroom::render::film::Film;
use sunroom::render::filter::PixelFilter;
use sunroom::render::light_layers::LightGroups;
use sunroom::render::scene::{RenderScene, SurfaceSlot, SurfaceTable};
use sunroom::render::tile::{render_tile, tiles};
use sunroom::render::view::{Integrator, PathSettings, Shown, Strategy, View};
use sunroom::sampling::SequenceKind;
use sunroom::shading::ShadingTables;
use sunroom::texture::{Parameter, TextureTable};

/// A scene under construction: every shape brings its own material and, if it shines, its radiance.
#[derive(Default)]
pub struct SceneBuilder {
    instances: Vec<Instance>,
    materials: Vec<Material>,
    slots: Vec<SurfaceSlot>,
    lights: Vec<WeightedSource>,
    textures: TextureTable,
    media: Vec<MediumSource>,
    /// Openings through which lights at infinity come in.
    pub portals: Vec<Portal>,
    /// The tables that models of the materials have ids of.
    pub tables: ShadingTables,
}

impl SceneBuilder {
    pub fn with_textures(textures: TextureTable) -> Self {
        Self {
            textures,
            ..Self::default()
        }
    }

    /// A scene with these participating media, whose ids are their places in the list.
    pub fn with_media(media: Vec<MediumSource>) -> Self {
        Self {
            media,
            ..Self::default()
        }
    }

    pub fn add(
        &mut self,
        primitive: Primitive,
        to_world: Affine3A,
        material: impl Into<Material>,
        radiance: Option<Rgb>,
    ) -> &mut Instance {
        self.add_shape(primitive, to_world, material.into(), radiance.map(Parameter::Constant))
    }

    /// A shape that shines as a texture of `textures` does.
    pub fn add_textured(
        &mut self,
        primitive: Primitive,
        to_world: Affine3A,
        material: impl Into<Material>,
        radiance: Parameter<Rgb>,
    ) {
        self.add_shape(primitive, to_world, material.into(), Some(radiance));
    }

    fn add_shape(
        &mut self,
        primitive: Primitive,
        to_world: Affine3A,
        material: Material,
        radiance: Option<Parameter<Rgb>>,
    ) -> &mut Instance {
        let instance = self.instances.len() as u32;
        self.instances
            .push(Instance::new(primitive, to_world).expect("an invertible transform"));
        let light = radiance.map(|radiance| {
            let source = LightSource::Surface {
                is_two_sided: false,
                instance,
                slot: 0,
                radiance,
            };
            self.lights.push(source.into());
            LightId(self.lights.len() as u32 - 1)
        });
        self.slots.push(SurfaceSlot {
            material: MaterialId(self.materials.len() as u32),
            light,
            media: Default::default(),
        });
        self.materials.push(material);
        self.instances.last_mut().expect("just pushed")
    }

    /// Lets the shape that was added last shine from both sides.
    pub fn both_ways(&mut self) -> &mut Self {
        match self.lights.last_mut().map(|light| &mut light.source) {
            Some(LightSource::Surface { is_two_sided, .. }) => *is_two_sided = true,
            other => panic!("{other:?}"),
        }
        self
    }

    /// A material of no shape, for others to nest.
    pub fn material(&mut self, material: impl Into<Material>) -> MaterialId {
        self.materials.push(material.into());
        MaterialId(self.materials.len() as u32 - 1)
    }

    /// Says what is on the sides of the shape that was added last.
    pub fn between(&mut self, media: MediumInterface) -> &mut Self {
        self.slots.last_mut().expect("a shape").media = media;
        self
    }

    pub fn light(&mut self, source: LightSource) -> &mut Self {
        self.lights.push(source.into());
        self
    }

    pub fn build(self) -> RenderScene {
        let geometry = Arc::new(Tlas::build(self.instances, SplitMethod::Sah));
        let textures = Arc::new(self.textures);
        let materials = MaterialTable::with_tables(self.materials, self.tables);
        let lights = LightTable::build(&self.lights, &geometry, &textures);
        let scene = RenderScene {
            media: Arc::new(MediumTable::new(self.media)),
            reach: lights.reach(&geometry),
            lights: Arc::new(lights),
            surfaces: Arc::new(SurfaceTable {
                first_slot: (0..self.slots.len() as u32).collect(),
                slots: self.slots,
            }),
            materials: Arc::new(materials.expect("materials that are there")),
            textures,
            geometry,
        };
        if self.portals.is_empty() {
            return scene;
        }
        let lights = LightTable::clone(&scene.lights);
        let portals = self.portals.into();
        let lights = lights.with_portals(&portals, &scene.geometry, |shape| scene.is_clear(shape));
        RenderScene {
            lights: Arc::new(lights),
            ..scene
        }
    }
}

/// A point that takes light from all around.
pub fn all_around(position: Vec3) -> LightReference {
    LightReference { position, normal: None }
}

const SQUARE: [Vec3; 4] = [
    Vec3::new(-1.0, -1.0, 0.0),
    Vec3::new(1.0, -1.0, 0.0),
    Vec3::new(1.0, 1.0, 0.0),
    Vec3::new(-1.0, 1.0, 0.0),
];

/// The square [-1, 1]^2 as two triangles.
pub fn square_mesh() -> Primitive {
    let [a, b, c, d] = SQUARE;
    triangle_mesh([[a, b, c], [a, c, d]])
}

/// The same as three triangles, which nobody takes for a square.
pub fn square_of_three_triangles() -> Primitive {
    let [a, b, c, d] = SQUARE;
    let between = Vec3::new(0.3, 1.0, 0.0);
    triangle_mesh([[a, b, c], [a, c, between], [a, between, d]])
}

/// Triangles that share no corners.
pub fn triangle_mesh(triangles: impl IntoIterator<Item = [Vec3; 3]>) -> Primitive {
    let positions: Vec<Vec3> = triangles.into_iter().flatten().collect();
    let mesh = MeshData {
        triangles: (0..positions.len() as u32 / 3)
            .map(|i| [3 * i, 3 * i + 1, 3 * i + 2])
            .collect(),
        positions,
        ..MeshData::default()
    };
    Primitive::Mesh(Arc::new(Blas::build(Arc::new(mesh), SplitMethod::Sah)))
}

/// A triangle whose vertex normals lean by some 60 degrees, each another way.
pub fn leaning_triangle(corners: [Vec3; 3]) -> Primitive {
    let [a, b, c] = corners;
    let up = (b - a).cross(c - a).normalize();
    let lean = |to: Vec3| (up + 1.7 * to.normalize()).normalize();
    let mesh = MeshData {
        positions: corners.to_vec(),
        normals: vec![lean(b - a), lean(c - a), lean(b - c)],
        triangles: vec![[0, 1, 2]],
        ..MeshData::default()
    };
    Primitive::Mesh(Arc::new(Blas::build(Arc::new(mesh), SplitMethod::Sah)))
}

/// A camera at `eye` looking at `target`, +y up.
pub fn camera(eye: Vec3, target: Vec3, fov: f32) -> Camera {
    let forward = (target - eye).normalize();
    let up = if forward.y.abs() > 0.99 { Vec3::Z } else { Vec3::Y };
    let left = up.cross(forward).normalize();
    let axes = glam::Mat3::from_cols(left, forward.cross(left), forward);
    Camera::new(Affine3A::from_mat3_translation(axes, eye), fov, 1.0, 1e-3, 1e6, None)
}

pub fn view(camera: Camera, size: u32, max_depth: u32, strategy: Strategy) -> View {
    View {
        camera,
        film_camera: None,
        width: size,
        height: size,
        medium: None,
        filter: PixelFilter::Box,
        integrator: Integrator::Path(PathSettings {
            max_depth,
            rr_depth: 5,
            hide_emitters: false,
            media: false,
            strategy,
        }),
        shown: Shown::Radiance,
        sight: Default::default(),
        light_groups: LightGroups::default(),
        layers: Default::default(),
        before: None,
        sequence: SequenceKind::Independent,
        seed: 1,
        photons: Default::default(),
        clamp: None,
        guide: None,
    }
}

pub fn render(scene: &RenderScene, view: &View, samples: u32) -> Film {
    let mut film = Film::with_layers(view.width, view.height, view.film_layers());
    for tile in tiles(view.width, view.height) {
        let result = render_tile(scene, view, tile, 0..samples, &AtomicBool::new(false)).expect("not cancelled");
        assert_eq!(result.invalid, 0, "no sample is infinite or not a number");
        film.add(&result);
    }
    film
}

/// Mean luminance of the picture and its standard error from the spread within pixels.
pub fn mean_luminance(film: &Film) -> (f32, f32) {
    let pixels = (film.width() * film.height()) as f32;
    let mean = film.radiance().iter().map(|&rgb| luminance(rgb)).sum::<f32>() / pixels;
    let variance: f32 = (0..film.height())
        .flat_map(|y| (0..film.width()).map(move |x| (x, y)))
        .filter_map(|(x, y)| film.standard_error(x, y))
        .map(|error| error * error)
        .sum();
    (mean, variance.sqrt() / pixels)
}

/// Fails unless `mean` lies within four standard errors (and the rounding of sums in single precision) of `expected`.
pub fn assert_close(what: &str, (mean, error): (f32, f32), expected: f32) {
    let tolerance = 4.0 * error + 2e-4 * expected.abs();
    assert!(
        (mean - expected).abs() <= tolerance,
        "{what}: {mean} +- {error}, expected {expected}"
    );
}
