//! The scene of a file in the scene format: the things placed by its nodes, with materials, lights and cameras.
//!
//! If the file has no camera, an overview camera is added, in front and a little above; if it has no light, studio
//! light is added.

use std::collections::{BTreeMap, HashMap, HashSet};
use std::rc::Rc;

use glam::{Affine3A, Mat4, Vec3};

use super::allowances::{MOST_INSTANCES, MOST_REPEATS, MeshAllowance, RepeatAllowance};
use super::lighting::{Glow, Lighting};
use super::mesh::{MeshValues, VERTEX_ALPHA, VERTEX_COLOR, too_many_moves};
use super::motion::{Allowance, Placement, affine, is_sound};
use super::objects::*;
use super::picture::{KnownPicture, Picture};
use super::pose::Pose;
use super::profiles::KnownProfile;
use super::schema::{Node, Primitive};
use super::{Gltf, GltfError, id_character, studio};
use crate::document::write::check_finite;
use crate::document::{Category, Child, Object, Span, Value};
use crate::geometry::mesh::MeshData;
use crate::math::{Aabb, is_invertible};

/// The most characters of a name in an id. A file may contain the name of a mesh once, and place the mesh thousands of
/// times.
const LONGEST_NAME: usize = 256;

/// Names the parts of the scene that are stored in files of their own. Each method is called once for each part.
pub trait References {
    /// The shape for a mesh of the file. Meshes that have a shape of their own at a node get further numbers.
    fn shape(&mut self, number: u32, mesh: &MeshData) -> Result<Object, GltfError>;
    /// The name of a picture's file; `index` counts the pictures.
    fn picture(&mut self, index: usize, picture: &Picture) -> Result<String, GltfError>;
    /// The mean colour of a picture, linear.
    fn mean(&mut self, picture: &Picture) -> Result<Vec3, GltfError>;
    /// Stores the file of a light profile. Called once for each that is used.
    fn profile(&mut self, index: usize) -> Result<KnownProfile, GltfError>;
    /// The name of a file with these bytes, which is no picture of the glTF file; `name` is a plain one.
    fn file(&mut self, name: &str, bytes: &[u8]) -> Result<String, GltfError>;
}

/// A scene as read from a file of the format.
#[derive(Debug)]
pub struct Imported {
    /// The `<scene>`.
    pub root: Object,
    /// One sentence for each part of the file that is left out.
    pub warnings: Vec<String>,
    /// The id of the stand-in light of a scene without lights. It is no part of the file's content.
    pub stand_in: Option<String>,
}

pub(super) struct Builder<'a> {
    pub gltf: &'a Gltf,
    pub(super) references: &'a mut dyn References,
    warnings: Vec<String>,
    warned: HashSet<String>,
    /// For each mesh the number of its first primitive.
    first_primitives: Vec<u32>,
    /// The meshes by the number of the primitive, and the node if they have a shape of their own there; None for
    /// unreadable ones.
    meshes: BTreeMap<(u32, Option<usize>), Option<KnownMesh>>,
    pub mesh_allowance: MeshAllowance,
    repeats: RepeatAllowance,
    /// The pictures, by a text that describes them.
    pub(super) pictures: HashMap<String, KnownPicture>,
    /// The reason why the first picture could not be stored.
    pub(super) failure: Option<GltfError>,
    /// The reason why the first missing primitive could not be read.
    unreadable: Option<GltfError>,
    ids: HashSet<String>,
    /// The next number to try for each name.
    next_numbers: HashMap<String, u32>,
    pub(super) sensors: Vec<Object>,
    /// The ids of bsdfs by material and vertex attributes.
    materials: BTreeMap<(Option<usize>, MeshValues), String>,
    bsdfs: Vec<Object>,
    /// The ids of the media inside materials; None for materials without one.
    interiors: BTreeMap<usize, Option<String>>,
    media: Vec<Object>,
    /// The emission by material and vertex attributes.
    glows: BTreeMap<(Option<usize>, MeshValues), Option<Glow>>,
    pub(super) emitters: Vec<Object>,
    /// The stored light profiles; None for unreadable ones.
    pub(super) profiles: BTreeMap<usize, Option<KnownProfile>>,
    /// The groups of folders.
    pub(super) groups: Vec<Object>,
    /// The folder of the current node.
    folder: Rc<str>,
    /// The shape of the current node's mesh.
    pose: Pose,
    /// The number of the next mesh with a shape of its own.
    next_posed: u32,
    pub(super) shapes: Vec<Object>,
    pub(super) lighting: Lighting,
    pub(super) bounds: Aabb,
    /// The number of instances that may still be placed.
    pub(super) instances_left: usize,
    /// The key frames that are left of the limit.
    allowance: Allowance,
}

/// The properties of a mesh that do not depend on its placement.
#[derive(Clone)]
struct KnownMesh {
    shape: Object,
    bounds: Aabb,
    values: MeshValues,
    area: f32,
}

impl Gltf {
    /// The file's default scene.
    pub fn scene(&self, references: &mut dyn References) -> Result<Imported, GltfError> {
        let mut builder = Builder {
            gltf: self,
            references,
            warnings: Vec::new(),
            warned: HashSet::new(),
            first_primitives: self.first_primitives(),
            meshes: BTreeMap::new(),
            mesh_allowance: MeshAllowance::of(self),
            repeats: RepeatAllowance::default(),
            pictures: HashMap::new(),
            failure: None,
            unreadable: None,
            ids: HashSet::new(),
            next_numbers: HashMap::new(),
            sensors: Vec::new(),
            materials: BTreeMap::new(),
            bsdfs: Vec::new(),
            interiors: BTreeMap::new(),
            media: Vec::new(),
            glows: BTreeMap::new(),
            emitters: Vec::new(),
            profiles: BTreeMap::new(),
            groups: Vec::new(),
            folder: "".into(),
            pose: Pose::default(),
            next_posed: self.mesh_count(),
            shapes: Vec::new(),
            lighting: Lighting::default(),
            bounds: Aabb::EMPTY,
            instances_left: MOST_INSTANCES,
            allowance: Allowance::default(),
        };
        builder.report_extensions();
        let animations = self.animations();
        let placed = self.placed_nodes(&animations)?;
        let passed_over = animations.passed_over.clone().sentences();
        let warnings = passed_over.chain(placed.warnings.iter().cloned());
        warnings.for_each(|warning| builder.warn(warning));
        let skins = self.skins(&placed);
        builder.warn_of_bones(&placed, &skins);
        let folders = builder.folders(&placed)?;
        for (place, node) in placed.nodes.iter().enumerate() {
            let about = self.get("node", &self.root.nodes, node.index)?;
            if about.places_something() {
                let placement = self.placement(&placed, &animations, place, &mut builder.allowance)?;
                builder.folder = folders[place].path.clone();
                let of_mesh = skins.place(about).map(|pose| Placement::still(affine(pose)));
                builder.pose = self.pose(node.index, about, &skins, &animations);
                builder.node(node.index, about, placement, of_mesh)?;
            }
        }
        builder.finish()
    }
}

impl Builder<'_> {
    pub fn warn(&mut self, sentence: String) {
        if self.warned.insert(sentence.clone()) {
            self.warnings.push(sentence);
        }
    }

    /// The emitted light, in which zero (reported) replaces numbers that are negative or too large for single
    /// precision.
    pub fn possible_light(&mut self, light: Vec3, title: &str) -> Vec3 {
        let possible = light.map(|number| if number.is_finite() { number.max(0.0) } else { 0.0 });
        if possible != light {
            self.warn(format!(
                "{title}: its light {light} is negative or infinite, {possible} takes its place"
            ));
        }
        possible
    }

    /// The name of the file with the studio environment.
    pub fn studio_file(&mut self) -> Result<String, GltfError> {
        let name = "studio.exr";
        let bytes = studio::picture().map_err(|source| GltfError::Keep {
            name: name.to_owned(),
            source: std::io::Error::other(source),
        })?;
        self.references.file(name, &bytes)
    }

    /// `of_mesh`: the placement of the mesh, if its skin determines it and not the node.
    fn node(
        &mut self,
        index: usize,
        node: &Node,
        placement: Placement,
        of_mesh: Option<Placement>,
    ) -> Result<(), GltfError> {
        let gltf = self.gltf;
        if let (Some(mesh), Some(place)) = (node.mesh, of_mesh.and_then(|place| self.possible(index, place))) {
            self.mesh((index, node), mesh, &place)?;
        }
        let mesh = node.mesh.filter(|_| node.skin.is_none());
        if mesh.is_none() && node.camera.is_none() && !node.extensions.has_light() {
            return Ok(());
        }
        let Some(placement) = self.possible(index, placement) else {
            return Ok(());
        };
        if let Some(mesh) = mesh {
            let instances = self.instances(index, node);
            // Each shape has key frames of its own.
            let shapes = gltf.pieces(mesh) * instances.as_ref().map_or(1, Vec::len);
            self.allowance.spend(shapes.saturating_mul(placement.keys.len()))?;
            match instances {
                None => self.mesh((index, node), mesh, &placement)?,
                Some(poses) => {
                    for pose in poses {
                        if let Some(place) = self.possible(index, placement.of_inner(pose)) {
                            self.mesh((index, node), mesh, &place)?;
                        }
                    }
                }
            }
        }
        if let Some(camera) = node.camera {
            let camera = gltf.get("camera", &gltf.root.cameras, camera)?;
            let name = node.name.as_deref().or(camera.name.as_deref()).unwrap_or("camera");
            let id = self.unique_in_folder(name);
            self.camera(camera, id, &placement);
        }
        self.lights_of(node, &placement)
    }

    /// The placement if it is invertible; None (reported) otherwise.
    fn possible(&mut self, node: usize, placement: Placement) -> Option<Placement> {
        let gltf = self.gltf;
        if !is_invertible(&Affine3A::from_mat4(placement.world)) {
            // A scale of zero is how files hide a node for a while (section 3.5.3).
            let title = gltf.node_title(node);
            self.warn(format!("{title} is flattened by its transform: it is left out"));
            return None;
        }
        if !is_sound(&placement) {
            let title = gltf.node_title(node);
            self.warn(format!(
                "{title} is flattened by its animation, or goes to infinity: it stands still"
            ));
            return Some(Placement::still(placement.world));
        }
        Some(placement)
    }

    fn mesh(&mut self, (index, node): (usize, &Node), mesh: usize, placement: &Placement) -> Result<(), GltfError> {
        let gltf = self.gltf;
        let about = gltf.get("mesh", &gltf.root.meshes, mesh)?;
        let name = node.name.as_deref().or(about.name.as_deref()).unwrap_or("mesh");
        let first = self.first_primitives[mesh];
        for (number, primitive) in (first..).zip(&about.primitives) {
            if !primitive.has_triangles() {
                self.warn(format!("points and lines are left out ({name})"));
                continue;
            }
            if self.repeats.spend(number, 1) == 0 {
                // Further repetitions are left out.
                self.warn(format!(
                    "the file places the same primitives again more than {MOST_REPEATS} times: the last places are left out"
                ));
                return Ok(());
            }
            let Some(mesh) = self.known_mesh((number, index), primitive, &about.weights, name)? else {
                continue;
            };
            let map = Affine3A::from_mat4(placement.world);
            self.bounds = self.bounds.union(mesh.bounds.transformed(&map));
            for (_, world) in &placement.keys {
                let bounds = mesh.bounds.transformed(&Affine3A::from_mat4(*world));
                self.bounds = self.bounds.union(bounds);
            }
            let given = primitive.material;
            let material = given.filter(|&material| material < gltf.root.materials.len());
            if let Some(missing) = given.filter(|_| material.is_none()) {
                self.warn(format!("material {missing} is not there: `{name}` has the default one"));
            }
            let mut shape = mesh.shape;
            shape.id = Some(self.unique_in_folder(name).into());
            if primitive.is_flat() {
                shape = with(shape, "face_normals", Value::Boolean(true));
                // If a transform mirrors, the front is the side from which the corners are clockwise (glTF 2.0, section
                // 3.7.4), and face normals are flipped; vertex normals stay outside.
                if map.as_daffine3().matrix3.determinant() < 0.0 {
                    shape = with(shape, "flip_normals", Value::Boolean(true));
                }
            }
            shape = with_world(shape, placement, Mat4::IDENTITY);
            shape.children.push(Child::Reference {
                name: None,
                id: self.material(material, mesh.values).into(),
                span: Span::default(),
            });
            if let Some(medium) = material.and_then(|material| self.interior(material)) {
                shape.children.push(Child::Reference {
                    name: Some("interior".into()),
                    id: medium.into(),
                    span: Span::default(),
                });
            }
            let glow = self.known_glow(material, mesh.values);
            // The mean over all directions of the factor by which a map changes areas.
            let scale = map.matrix3.determinant().abs().powf(2.0 / 3.0);
            self.lighting.note_surface(scale * mesh.area, glow.as_ref());
            if let Some(glow) = glow {
                shape = with_child(shape, glow.emitter);
            }
            self.shapes.push(shape);
        }
        Ok(())
    }

    /// The mesh of a primitive; None (reported, with the name) if it cannot be read.
    fn known_mesh(
        &mut self,
        (number, node): (u32, usize),
        primitive: &Primitive,
        weights: &[f32],
        name: &str,
    ) -> Result<Option<KnownMesh>, GltfError> {
        let pose = self.pose.clone();
        let key = (number, pose.is_own().then_some(node));
        if let Some(known) = self.meshes.get(&key) {
            return Ok(known.clone());
        }
        if self.mesh_allowance.is_spent() {
            let what = "the meshes of the file would be far larger than its buffers, whose vertices they share: the last ones are left out";
            self.warn(what.to_owned());
            return Ok(None);
        }
        let given = pose.weights.as_deref().unwrap_or(weights);
        let weights = self.gltf.allowed_weights(primitive, given, &mut self.mesh_allowance);
        if weights.len() < given.len() {
            self.warn(too_many_moves());
        }
        let known = match self
            .gltf
            .read_primitive(number, primitive, weights, pose.bones.as_deref())
        {
            Ok(loaded) => {
                let file = match key {
                    (number, None) => number,
                    _ => self.next_posed,
                };
                self.next_posed += u32::from(file == self.next_posed);
                self.mesh_allowance.spend(&loaded.mesh);
                loaded.warnings.into_iter().for_each(|warning| self.warn(warning));
                Some(KnownMesh {
                    shape: self.references.shape(file, &loaded.mesh)?,
                    bounds: loaded.mesh.bounds(),
                    values: MeshValues {
                        colors: loaded.mesh.attribute(VERTEX_COLOR).is_some(),
                        alpha: loaded.mesh.attribute(VERTEX_ALPHA).is_some(),
                    },
                    area: area(&loaded.mesh),
                })
            }
            Err(error) => {
                self.warn(format!("primitive {number} of `{name}` is left out: {error}"));
                self.unreadable.get_or_insert(error);
                None
            }
        };
        self.meshes.insert(key, known.clone());
        Ok(known)
    }

    /// The id of a bsdf, which is added at its first use.
    fn material(&mut self, index: Option<usize>, mesh: MeshValues) -> String {
        if let Some(id) = self.materials.get(&(index, mesh)) {
            return id.clone();
        }
        let name = index.and_then(|index| self.gltf.root.materials[index].name.as_deref());
        let id = self.unique(name.unwrap_or("material"));
        let mut bsdf = self.bsdf(index, mesh);
        bsdf.id = Some(id.as_str().into());
        self.bsdfs.push(bsdf);
        self.materials.insert((index, mesh), id.clone());
        id
    }

    fn known_glow(&mut self, index: Option<usize>, mesh: MeshValues) -> Option<Glow> {
        if let Some(known) = self.glows.get(&(index, mesh)) {
            return known.clone();
        }
        let glow = self.glow(index, mesh);
        self.glows.insert((index, mesh), glow.clone());
        glow
    }

    /// The id of the medium inside a material's surfaces, if there is one.
    fn interior(&mut self, material: usize) -> Option<String> {
        if let Some(known) = self.interiors.get(&material) {
            return known.clone();
        }
        let about = &self.gltf.root.materials[material];
        let id = about.absorption().map(|sigma_a| {
            let id = self.unique(&format!("inside {}", about.name.as_deref().unwrap_or("material")));
            let medium = with_color(object(Category::Medium, "homogeneous"), "sigma_t", sigma_a);
            let medium = with_float(medium, "albedo", 0.0);
            self.media.push(Object {
                id: Some(id.as_str().into()),
                ..medium
            });
            id
        });
        self.interiors.insert(material, id.clone());
        id
    }

    pub(super) fn unique(&mut self, name: &str) -> String {
        self.unique_in("", name, "")
    }

    pub(super) fn unique_in_folder(&mut self, name: &str) -> String {
        let folder = self.folder.clone();
        self.unique_in(&folder, name, "")
    }

    /// A unique id made of the name, with valid characters only, between a folder and a suffix.
    pub(super) fn unique_in(&mut self, folder: &str, name: &str, end: &str) -> String {
        let name: String = name.chars().take(LONGEST_NAME).map(id_character).collect();
        let name = if name.trim().is_empty() { "unnamed" } else { &name };
        let base = format!("{folder}{name}");
        let next = self.next_numbers.entry(format!("{base}{end}")).or_insert(1);
        loop {
            let id = match *next {
                1 => format!("{base}{end}"),
                number => format!("{base}-{number}{end}"),
            };
            *next += 1;
            if self.ids.insert(id.clone()) {
                return id;
            }
        }
    }

    fn finish(mut self) -> Result<Imported, GltfError> {
        if let Some(failure) = self.failure {
            return Err(failure);
        }
        if let Some(unreadable) = self.unreadable.take_if(|_| self.shapes.is_empty()) {
            return Err(unreadable);
        }
        if self.sensors.is_empty() {
            let sensor = self.overview()?;
            self.sensors.push(sensor);
        }
        let stand_in = self.stand_in_light()?;
        let mut root = object(Category::Scene, "");
        let integrator = if self.media.is_empty() { "path" } else { "volpath" };
        root.children = std::iter::once(object(Category::Integrator, integrator))
            .chain(self.sensors)
            .chain(self.emitters)
            .chain(self.media)
            .chain(self.bsdfs)
            .chain(self.groups)
            .chain(self.shapes)
            .map(Child::from)
            .collect();
        check_numbers(&root)?;
        Ok(Imported {
            root,
            warnings: self.warnings,
            stand_in,
        })
    }
}

/// The area of all triangles of a mesh.
fn area(mesh: &MeshData) -> f32 {
    (0..mesh.triangles.len())
        .map(|triangle| mesh.area_of_triangle(triangle))
        .sum()
}

/// An error if a number of the scene is too large for single precision.
fn check_numbers(object: &Object) -> Result<(), GltfError> {
    for property in &object.properties {
        check_finite(&property.value, &property.name, object).map_err(|_| GltfError::Number {
            name: property.name.to_string(),
            owner: object.title(),
        })?;
    }
    object.objects().try_for_each(check_numbers)
}
