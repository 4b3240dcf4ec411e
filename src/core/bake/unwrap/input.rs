//! A mesh in the form that the crate `uvunwrap` takes.
//!
//! The crate cuts a mesh into charts in one go, and flattens each with a solver whose time per triangle grows with the
//! size of the chart, so that a large mesh takes minutes without progress or cancellation. Therefore large meshes are
//! cut into pieces of neighbouring triangles, and each piece into charts on its own. The crate then gets the mesh with
//! the coordinates of these charts, which it tests and packs.

use std::collections::HashMap;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use glam::Vec3;
use rayon::prelude::*;
use uvunwrap::{Density, MeshInput, Options, Packing};

use super::error::UnwrapError;
use super::mesh::{Told, UnwrapMesh};

/// The most triangles of a piece. Smaller pieces take less time per triangle, and make more seams.
const PIECE: usize = 2000;
/// The extent of a piece in the texels in which its charts are laid out. All that matters of this layout is that charts
/// do not overlap.
const PIECE_TEXELS: f32 = 256.0;

/// The share of the time spent on cutting large meshes into charts, if all meshes are large.
const CUTTING: f64 = 0.85;

/// A mesh as a whole, or cut into pieces.
pub(super) struct Input {
    positions: Vec<[f32; 3]>,
    indices: Vec<u32>,
    /// The part of each triangle. No chart has triangles of two parts.
    parts: Vec<u32>,
    scales: Vec<f32>,
    /// The coordinates of each vertex within its piece; None if the mesh is not cut.
    coordinates: Option<Vec<[f32; 2]>>,
    /// The original vertex of each vertex, if the mesh is cut: vertices at seams are duplicated.
    vertices: Option<Vec<u32>>,
}

impl Input {
    /// All meshes, the large ones cut into charts, and the share that this was of all work.
    pub fn all(meshes: &[UnwrapMesh], cancel: &AtomicBool, told: Told) -> Result<(Vec<Self>, f64), UnwrapError> {
        let all = meshes.iter().map(|mesh| mesh.triangles.len()).sum::<usize>().max(1) as f64;
        let mut before = 0;
        let mut inputs = Vec::new();
        for mesh in meshes {
            if !mesh.is_large() {
                inputs.push(Self::whole(mesh));
                continue;
            }
            let words = format!("unwrapping `{}`", mesh.name);
            let tell = |done: usize| told(CUTTING * (before + done) as f64 / all, &words);
            tell(0);
            inputs.push(match Self::cut(mesh, cancel, tell) {
                Ok(cut) => cut,
                Err(uvunwrap::Error::Cancelled) => return Err(UnwrapError::Cancelled),
                // The mesh may still be unwrapped as a whole.
                Err(_) => Self::whole(mesh),
            });
            before += mesh.triangles.len();
        }
        Ok((inputs, CUTTING * before as f64 / all))
    }

    /// A mesh that is not cut.
    fn whole(mesh: &UnwrapMesh) -> Self {
        Self {
            positions: mesh.positions.iter().map(|place| place.to_array()).collect(),
            indices: mesh.triangles.as_flattened().to_vec(),
            parts: mesh.part_of_triangle.clone(),
            scales: vec![1.0; mesh.places],
            coordinates: None,
            vertices: None,
        }
    }

    /// Cuts a mesh into charts, piece by piece. `told` gets the number of finished triangles. An error soon after
    /// `cancel` is set, or if the crate refuses a piece.
    fn cut(mesh: &UnwrapMesh, cancel: &AtomicBool, told: impl Fn(usize) + Sync) -> Result<Self, uvunwrap::Error> {
        let pieces = pieces(mesh, PIECE);
        let done = AtomicUsize::new(0);
        let charts = |triangles: &Vec<u32>| {
            let charts = Charts::of(mesh, triangles, cancel)?;
            told(done.fetch_add(triangles.len(), Ordering::Relaxed) + triangles.len());
            Ok(charts)
        };
        let charts: Vec<Charts> = pieces.par_iter().map(charts).collect::<Result<_, uvunwrap::Error>>()?;
        let mut input = Self {
            positions: Vec::new(),
            indices: vec![0; 3 * mesh.triangles.len()],
            parts: vec![0; mesh.triangles.len()],
            scales: vec![1.0; mesh.places],
            coordinates: None,
            vertices: None,
        };
        let (mut coordinates, mut vertices) = (Vec::new(), Vec::new());
        for (number, (piece, charts)) in (0..).zip(pieces.iter().zip(charts)) {
            let first = vertices.len() as u32;
            vertices.extend(charts.vertices);
            coordinates.extend(charts.coordinates);
            for (&triangle, corners) in piece.iter().zip(charts.indices.as_chunks::<3>().0) {
                let triangle = triangle as usize;
                // Charts of two pieces may have the same coordinates at an edge by chance, so each piece is a part.
                input.parts[triangle] = number;
                input.indices[3 * triangle..3 * triangle + 3].copy_from_slice(&corners.map(|corner| first + corner));
            }
        }
        let place = |vertex: &u32| mesh.positions[*vertex as usize].to_array();
        input.positions = vertices.iter().map(place).collect();
        (input.coordinates, input.vertices) = (Some(coordinates), Some(vertices));
        Ok(input)
    }

    /// The mesh as the input of the crate.
    pub fn borrow(&self) -> MeshInput<'_> {
        MeshInput {
            face_materials: (!self.parts.is_empty()).then_some(&*self.parts),
            instance_scales: &self.scales,
            existing_uvs: self.coordinates.as_deref(),
            ..MeshInput::new(&self.positions, &self.indices)
        }
    }

    /// The original vertex of a vertex.
    pub fn vertex_of_mesh(&self, vertex: u32) -> u32 {
        let vertices = self.vertices.as_ref();
        vertices.map_or(vertex, |vertices| vertices[vertex as usize])
    }
}

/// The charts of a piece.
struct Charts {
    /// The original vertex of each vertex.
    vertices: Vec<u32>,
    /// The coordinates of each vertex, in texels.
    coordinates: Vec<[f32; 2]>,
    /// The corners of the triangles, in the order of the piece.
    indices: Vec<u32>,
}

impl Charts {
    fn of(mesh: &UnwrapMesh, triangles: &[u32], cancel: &AtomicBool) -> Result<Self, uvunwrap::Error> {
        let mut number_of: HashMap<u32, u32> = HashMap::new();
        let mut vertices: Vec<u32> = Vec::new();
        let corners = triangles.iter().flat_map(|&triangle| mesh.triangles[triangle as usize]);
        let indices: Vec<u32> = corners
            .map(|vertex| {
                *number_of.entry(vertex).or_insert_with(|| {
                    vertices.push(vertex);
                    vertices.len() as u32 - 1
                })
            })
            .collect();
        let places: Vec<Vec3> = vertices.iter().map(|&vertex| mesh.positions[vertex as usize]).collect();
        let positions: Vec<[f32; 3]> = places.iter().map(Vec3::to_array).collect();
        let part = |&triangle: &u32| mesh.part_of_triangle.get(triangle as usize).copied();
        let parts: Option<Vec<u32>> = triangles.iter().map(part).collect();
        let [min, max] = bounds(places.iter().copied());
        let options = Options {
            density: Density::Fixed {
                texels_per_unit: (PIECE_TEXELS / (max - min).length()).clamp(f32::MIN_POSITIVE, f32::MAX),
                page_size: None,
            },
            padding: 1,
            packing: Packing::Fast,
            ..Options::default()
        };
        let input = MeshInput {
            face_materials: parts.as_deref(),
            ..MeshInput::new(&positions, &indices)
        };
        let mut atlas = uvunwrap::generate_with_progress(&[input], &options, |_| !cancel.load(Ordering::Relaxed))?;
        let charts = std::mem::take(&mut atlas.meshes[0]);
        let [width, height] = [atlas.width, atlas.height].map(|texels| texels as f32);
        let corners = charts.vertices.iter();
        Ok(Self {
            // The atlas may be any rectangle here.
            coordinates: corners
                .map(|vertex| [vertex.uv[0] * width, vertex.uv[1] * height])
                .collect(),
            vertices: charts
                .vertices
                .iter()
                .map(|vertex| vertices[vertex.xref as usize])
                .collect(),
            indices: charts.indices,
        })
    }
}

/// Partitions the triangles of a mesh into pieces of at most `most`, by halving along the longest side of the box
/// around their centres. Each piece has its triangles in the order of the mesh.
fn pieces(mesh: &UnwrapMesh, most: usize) -> Vec<Vec<u32>> {
    let centre = |triangle: u32| {
        let corners = mesh.triangles[triangle as usize];
        corners
            .map(|corner| mesh.positions[corner as usize] / 3.0)
            .iter()
            .sum::<Vec3>()
    };
    let mut left: Vec<Vec<u32>> = vec![(0..mesh.triangles.len() as u32).collect()];
    let mut pieces = Vec::new();
    while let Some(mut triangles) = left.pop() {
        if triangles.len() <= most {
            triangles.sort_unstable();
            pieces.push(triangles);
            continue;
        }
        let [min, max] = bounds(triangles.iter().map(|&triangle| centre(triangle)));
        let axis = (max - min).max_position();
        let middle = triangles.len() / 2;
        triangles.select_nth_unstable_by(middle, |&one, &other| {
            let [a, b] = [one, other].map(|triangle| centre(triangle)[axis]);
            a.total_cmp(&b).then(one.cmp(&other))
        });
        left.push(triangles.split_off(middle));
        left.push(triangles);
    }
    pieces
}

fn bounds(places: impl Iterator<Item = Vec3>) -> [Vec3; 2] {
    places.fold([Vec3::INFINITY, Vec3::NEG_INFINITY], |[min, max], place| {
        [min.min(place), max.max(place)]
    })
}

#[cfg(test)]
mod tests {
    use std::collections::HashSet;
    use std::sync::Mutex;

    use glam::Vec2;

    use super::super::{Layout, LayoutMesh, UnwrapSettings, unwrap};
    use super::*;

    const DENSITY: f32 = 40.0;

    /// A wavy torus of two parts, with two instances: no plane and no single chart fits it.
    fn waves(around: u32, along: u32) -> UnwrapMesh {
        let place = |u: u32, v: u32| {
            let [u, v] = [(u, around), (v, along)].map(|(at, of)| at as f32 / of as f32 * std::f32::consts::TAU);
            let radius = 0.8 + 0.1 * (5.0 * u).sin() * (3.0 * v).cos();
            let out = 2.0 + radius * v.cos();
            Vec3::new(out * u.cos(), out * u.sin(), radius * v.sin())
        };
        let number = |u: u32, v: u32| (u % around) * along + v % along;
        let squares = (0..around).flat_map(|u| (0..along).map(move |v| (u, v)));
        UnwrapMesh {
            name: "waves".to_owned(),
            positions: squares.clone().map(|(u, v)| place(u, v)).collect(),
            triangles: squares
                .clone()
                .flat_map(|(u, v)| {
                    let [a, b, c, d] = [number(u, v), number(u + 1, v), number(u + 1, v + 1), number(u, v + 1)];
                    [[a, b, c], [a, c, d]]
                })
                .collect(),
            part_of_triangle: squares.flat_map(|(u, _)| [u32::from(u < around / 3); 2]).collect(),
            places: 2,
        }
    }

    fn laid_out(mesh: &UnwrapMesh, cancel: &AtomicBool, told: Told) -> Result<Layout, UnwrapError> {
        let settings = UnwrapSettings {
            atlas_size: 2048,
            texels_per_unit: Some(DENSITY),
            ..UnwrapSettings::default()
        };
        unwrap(std::slice::from_ref(mesh), &settings, cancel, told)
    }

    /// The corners of all triangles in the texels of an instance.
    fn in_texels(layout: &Layout, mesh: &LayoutMesh, place: usize) -> Vec<[Vec2; 3]> {
        let place = mesh.rectangles[place];
        let at = |corner: u32| {
            let within = mesh.coordinates[corner as usize] * (place.max - place.min);
            (place.min + within) * layout.size.as_vec2()
        };
        mesh.triangles.iter().map(|corners| corners.map(at)).collect()
    }

    fn area([a, b, c]: [Vec2; 3]) -> f32 {
        0.5 * (b - a).perp_dot(c - a)
    }

    #[test]
    fn a_large_mesh_keeps_its_triangles_and_its_density_and_no_two_overlap() {
        let mesh = waves(120, 50);
        assert!(mesh.is_large());
        let layout = laid_out(&mesh, &AtomicBool::new(false), &|_, _| {}).expect("a layout");
        let [laid] = &layout.meshes[..] else { panic!("one mesh") };
        assert_eq!((layout.pages, laid.triangles.len()), (1, mesh.triangles.len()));
        let places = [0, 1].map(|place| in_texels(&layout, laid, place));
        for (number, (corners, &expected)) in laid.triangles.iter().zip(&mesh.triangles).enumerate() {
            assert_eq!(corners.map(|corner| laid.vertices[corner as usize]), expected);
            let [a, b, c] = expected.map(|corner| mesh.positions[corner as usize]);
            let asked = 0.5 * (b - a).cross(c - a).length() * DENSITY * DENSITY;
            let ratio = area(places[0][number]) / asked;
            assert!((0.25..4.0).contains(&ratio), "triangle {number}: {ratio}");
        }
        let [all, asked] = [
            places[0].iter().map(|at| area(*at)).sum::<f32>(),
            mesh.area() as f32 / 2.0 * DENSITY * DENSITY,
        ];
        assert!((all / asked - 1.0).abs() < 0.02, "{all} texels, {asked} asked for");
        // The centre of each triangle is in no other one.
        let triangles = places.concat();
        for (number, at) in triangles.iter().enumerate() {
            let middle = (at[0] + at[1] + at[2]) / 3.0;
            let is_in =
                |at: &[Vec2; 3]| (0..3).all(|side| (at[(side + 1) % 3] - at[side]).perp_dot(middle - at[side]) > 0.0);
            let owners = triangles.iter().filter(|at| is_in(at)).count();
            assert_eq!(owners, 1, "triangle {number}");
        }
        // No vertex belongs to both parts.
        let of_part = |part: u32| -> HashSet<u32> {
            let own = laid.triangles.iter().zip(&mesh.part_of_triangle);
            own.filter(|(_, of)| **of == part)
                .flat_map(|(corners, _)| *corners)
                .collect()
        };
        assert!(of_part(0).is_disjoint(&of_part(1)));
    }

    #[test]
    fn the_layout_of_a_large_mesh_is_told_by_name_and_ended() {
        let mesh = waves(120, 50);
        let told: Mutex<Vec<(f64, String)>> = Mutex::default();
        let keep = |done: f64, words: &str| told.lock().expect("no panic").push((done, words.to_owned()));
        laid_out(&mesh, &AtomicBool::new(false), &keep).expect("a layout");
        let told = told.into_inner().expect("no panic");
        assert!(
            told.iter().filter(|(_, words)| words == "unwrapping `waves`").count() > 4,
            "{told:?}"
        );
        assert!(told.iter().all(|(done, _)| (0.0..=1.0).contains(done)), "{told:?}");
        assert_eq!(
            told.last().map(|(done, words)| (*done, &**words)),
            Some((1.0, "placing the charts"))
        );
        // It can be cancelled at any progress.
        for end in [0.3, 0.9] {
            let cancel = AtomicBool::new(false);
            let farthest = Mutex::new(0.0);
            let tell = |done: f64, _: &str| {
                *farthest.lock().expect("no panic") = done;
                cancel.fetch_or(done >= end, Ordering::Relaxed);
            };
            let error = laid_out(&mesh, &cancel, &tell).map(drop);
            assert_eq!(error, Err(UnwrapError::Cancelled));
            let farthest = farthest.into_inner().expect("no panic");
            assert!((end..1.0).contains(&farthest), "{farthest}");
        }
    }

    #[test]
    fn threads_change_no_coordinate_of_a_large_mesh() {
        let mesh = waves(120, 50);
        let of = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new()
                .num_threads(threads)
                .build()
                .expect("threads");
            let layout = pool.install(|| laid_out(&mesh, &AtomicBool::new(false), &|_, _| {}));
            layout.expect("a layout").meshes
        };
        assert_eq!(of(1), of(3));
    }

    #[test]
    fn pieces_are_all_of_a_mesh_that_lies_in_one_point() {
        let mut mesh = waves(20, 10);
        mesh.positions.fill(Vec3::ONE);
        let mut pieces = pieces(&mesh, 64);
        assert!(pieces.iter().all(|piece| piece.len() <= 64 && piece.is_sorted()));
        let mut all: Vec<u32> = pieces.drain(..).flatten().collect();
        all.sort_unstable();
        assert_eq!(all, (0..400).collect::<Vec<u32>>());
        let input = Input::cut(&mesh, &AtomicBool::new(false), |_| {}).map(|input| input.vertices);
        assert!(input.is_ok_and(|vertices| vertices.is_some_and(|vertices| vertices.len() >= 3)));
    }
}
