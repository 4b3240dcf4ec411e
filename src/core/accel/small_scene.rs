//! Scenes of up to some two thousand shapes: sixteen rays at once are tested against one shape after the other, in a
//! fixed order.
//!
//! Rays of different paths are incoherent, but among few shapes most have to be tested anyway. For more shapes,
//! [`super::skip_list`] has boxes around shapes that few batches meet. Rectangles, spheres, boxes and meshes of a few
//! triangles are tested in vectors, a ray per lane. Of other meshes only the bounds are tested in vectors; the rays
//! that meet them traverse the mesh one by one, or together if they are many and the mesh is large. Many shapes close
//! together are tested in blocks. Where surfaces coincide, a ray may hit another of them than if traced by itself.

use glam::{Vec2, Vec3};

use super::affine_mesh::{AffineMesh, Face};
use super::blas::Blas;
use super::hit::Hit;
use super::instance::{Instance, Primitive};
use super::obstacle::Obstacles;
use super::ray_lanes::RayLanes;
use super::shape_block::{Members, ShapeBlock};
use super::shape_lanes::{ShapeHitLanes, SlabLanes, cube, local_to, rectangle, sphere};
use super::skip_list::{Item, Step, Walk, append_steps, place_of_rays};
use super::tiny_mesh::TinyMesh;
use super::traverse::TraversalStats;
use crate::geometry::local::LocalHit;
use crate::math::lanes::{LANES, Lanes, each_lane, lanes_of};
use crate::math::{Aabb, Ray};

/// The most shapes tested one by one that could be in blocks. Above this, blocks are faster.
pub(super) const MOST_ALONE: usize = 24;
/// The most blocks of a small scene.
const MOST_BLOCKS: usize = 64;
/// The largest estimated cost of a batch of rays, in the units of [`Item::cost`]. Most rays stop at the first of many
/// shapes one behind the other, which the hierarchy tests from front to back.
const MOST_COST: f32 = 300.0;

/// Rays traverse a mesh one by one if a core's cache holds its `CACHED` bytes beside other meshes, or if they are at
/// most `FEW_RAYS`. Interleaving, which hides the waits for memory, pays off for many rays in large meshes alone.
const CACHED: usize = 512 << 10;
const FEW_RAYS: u32 = 8;

/// The shapes that a [`SmallScene`] was made of.
#[derive(Clone, Copy)]
pub(super) struct Shapes<'a> {
    pub instances: &'a [Instance],
    pub blocks: (&'a [ShapeBlock], &'a [Members]),
}

/// The shapes of a scene that is not edited in place and whose tests are cheap enough.
#[derive(Clone, Debug)]
pub(super) struct SmallScene {
    shapes: Vec<SceneShape>,
    /// The order of the tests, the cheap shapes first.
    steps: Vec<Step>,
    /// Whether there are boxes among the steps.
    has_boxes: bool,
}

#[derive(Clone, Debug)]
struct SceneShape {
    /// Index into the instances.
    instance: u32,
    kind: Kind,
    /// The rows of the world-to-local matrix, and the local origin in the world. Squares and cubes have their own
    /// matrix, not their mesh's.
    rows: [Vec3; 3],
    place: Vec3,
}

#[derive(Clone, Debug)]
enum Kind {
    Rectangle,
    Sphere,
    /// A mesh that is the transformed unit square, with the face that the square stands for.
    Square(Face),
    /// A mesh that is the transformed unit cube, with the faces that the cube's sides stand for.
    Cube(Vec<Face>),
    TinyMesh(TinyMesh),
    /// Any other mesh, with its local bounds, and whether a core's cache holds it beside other meshes.
    Boxed(Aabb, bool),
    /// Any other shape, which is tested against one ray after the other.
    Other,
    /// All blocks of the scene.
    Blocks,
}

/// The highest of [`Kind::turn`].
const LAST_TURN: u32 = 3;

impl Kind {
    /// The rank of the kind in the order of tests: cheap shapes first, since they may hide expensive ones.
    fn turn(&self) -> u32 {
        match self {
            Self::Rectangle | Self::Square(_) | Self::Sphere | Self::Cube(_) => 0,
            Self::Blocks | Self::Other => 1,
            Self::TinyMesh(_) => 2,
            Self::Boxed(..) => LAST_TURN,
        }
    }

    /// The cost of a test of all lanes, as [`Item::cost`]. A mesh's cost was measured with the rays that traverse it.
    fn cost(&self) -> f32 {
        match self {
            Self::Rectangle | Self::Sphere | Self::Square(_) | Self::Cube(_) => 1.0,
            Self::Boxed(..) => 6.0,
            Self::TinyMesh(_) | Self::Other => 10.0,
            // Each block has bounds of its own, which are tested first.
            Self::Blocks => 0.0,
        }
    }
}

/// The nearest hits so far.
struct Nearest {
    t: Lanes,
    u: Lanes,
    v: Lanes,
    /// The index into the shapes, as a float; negative where nothing is hit.
    shape: Lanes,
    /// The index of the triangle or of the cube's face, as a float.
    part: Lanes,
    /// The complete hits with shapes that are tested against one ray after the other.
    whole: [Option<Hit>; LANES],
}

impl SmallScene {
    /// None if there are too many blocks, or if the tests cost too much.
    pub fn new(scene: Shapes) -> Option<Self> {
        let Shapes { instances, blocks } = scene;
        let members = || blocks.1.iter().flat_map(Members::indices);
        // Disks are tested against one ray after the other, unless they are in blocks.
        let has_disks = || members().any(|&member| matches!(instances[member as usize].primitive, Primitive::Disk));
        let wants_blocks = members().count() > MOST_ALONE || instances.len() > MOST_ALONE && has_disks();
        let shapes = match wants_blocks {
            true if blocks.0.len() > MOST_BLOCKS => return None,
            true => Self::beside(instances, blocks.1),
            false => Self::beside(instances, &[]),
        };
        let (steps, cost) = Self::steps(&shapes, scene);
        (cost <= MOST_COST).then(|| Self {
            has_boxes: steps.iter().any(|step| matches!(step, Step::Box { .. })),
            shapes,
            steps,
        })
    }

    /// The order of the tests, and their expected cost per batch.
    fn steps(shapes: &[SceneShape], scene: Shapes) -> (Vec<Step>, f32) {
        let bounds = |shape: &SceneShape| match &shape.kind {
            Kind::Blocks => (scene.blocks.0.iter()).fold(Aabb::EMPTY, |all, block| all.union(block.bounds)),
            _ => shape.instance(scene).world_bounds(),
        };
        let items: Vec<(u32, Item)> = (0..)
            .zip(shapes)
            .map(|(number, shape)| {
                let bounds = bounds(shape);
                let (turn, cost) = (shape.kind.turn(), shape.kind.cost());
                (turn, Item { number, bounds, cost })
            })
            .collect();
        let all: Vec<Item> = items.iter().map(|(_, item)| *item).collect();
        let whole = place_of_rays(&all);
        let (mut steps, mut cost) = (Vec::new(), 0.0);
        for turn in 0..=LAST_TURN {
            let here = items.iter().filter(|item| item.0 == turn);
            let mut here: Vec<Item> = here.map(|(_, item)| *item).collect();
            cost += append_steps(&mut steps, &mut here, &whole);
        }
        (steps, cost)
    }

    /// The shapes outside these blocks, and all blocks as one shape if there are any.
    fn beside(instances: &[Instance], blocks: &[Members]) -> Vec<SceneShape> {
        // A mesh without triangles has empty bounds, and no ray meets it.
        let mut alone: Vec<bool> = (instances.iter())
            .map(|shape| !shape.world_bounds().is_empty())
            .collect();
        let members = blocks.iter().flat_map(Members::indices);
        members.for_each(|&member| alone[member as usize] = false);
        let in_line = (0..).zip(instances).filter(|&(index, _)| alone[index as usize]);
        let mut shapes: Vec<SceneShape> = in_line.map(|(index, shape)| SceneShape::new(index, shape)).collect();
        if !blocks.is_empty() {
            shapes.push(SceneShape::BLOCKS);
        }
        shapes
    }

    /// The nearest hits of the lanes in `active`. With `COHERENT` the rays traverse meshes as a packet.
    pub fn closest<const COHERENT: bool>(&self, scene: Shapes, rays: &RayLanes, active: u32) -> [Option<Hit>; LANES] {
        let mut nearest = Nearest {
            t: rays.t_max,
            u: Lanes::ZERO,
            v: Lanes::ZERO,
            shape: Lanes::splat(-1.0),
            part: Lanes::ZERO,
            whole: [None; LANES],
        };
        let slabs = self.has_boxes.then(|| SlabLanes::new(rays));
        let meet = |bounds: &Aabb, t_max: Lanes| {
            let met = slabs.as_ref().map(|slabs| slabs.meets(bounds, t_max).to_bitmask());
            met.unwrap_or(u32::MAX)
        };
        let mut walk = Walk::new(&self.steps);
        while let Some((number, asked)) = walk.next(active, |bounds| meet(bounds, nearest.t)) {
            let shape = &self.shapes[number];
            let number = Lanes::splat(number as f32);
            match &shape.kind {
                Kind::Rectangle | Kind::Square(_) => {
                    nearest.take(asked, number, &rectangle(&shape.local(rays), nearest.t));
                }
                Kind::Sphere => {
                    nearest.take(asked, number, &sphere(&shape.local(rays), nearest.t));
                }
                Kind::Cube(_) => {
                    nearest.take(asked, number, &cube(&shape.local(rays), nearest.t));
                }
                Kind::TinyMesh(mesh) => {
                    let local = shape.local(rays);
                    let near = SlabLanes::new(&local).meets(mesh.bounds(), nearest.t) & lanes_of(asked);
                    if near.none() {
                        continue;
                    }
                    // Only the weights of the nearest triangle are divided by their sum.
                    let mut sum = Lanes::ONE;
                    mesh.each_hit(&local, |t, weights, triangle| {
                        let met = near & t.simd_lt(nearest.t) & t.simd_gt(rays.t_min) & weights.inside;
                        sum = met.select(weights.sum, sum);
                        let hit = ShapeHitLanes {
                            t,
                            u: weights.u,
                            v: weights.v,
                            part: Lanes::splat(triangle as f32),
                            met,
                        };
                        nearest.take(asked, number, &hit);
                        false
                    });
                    nearest.u /= sum;
                    nearest.v /= sum;
                }
                Kind::Boxed(bounds, is_cached) => {
                    let mut local = shape.local(rays);
                    local.t_max = nearest.t;
                    let met = SlabLanes::new(&local).meets(bounds, nearest.t).to_bitmask() & asked;
                    match shape.mesh(scene) {
                        Some(mesh) if COHERENT => mesh.intersect_packet(&local, met, |lane, hit| {
                            nearest.set(lane, number, Hit::of_mesh(shape.instance, hit));
                        }),
                        Some(mesh) if *is_cached || met.count_ones() <= FEW_RAYS => {
                            for lane in each_lane(met) {
                                if let Some(hit) = mesh.intersect(&local.get(lane)) {
                                    nearest.set(lane, number, Hit::of_mesh(shape.instance, hit));
                                }
                            }
                        }
                        Some(mesh) => mesh.intersect_lanes(&local, met, |lane, hit| {
                            nearest.set(lane, number, Hit::of_mesh(shape.instance, hit));
                        }),
                        None => {}
                    }
                }
                Kind::Blocks => nearest.test_blocks(asked, number, scene.blocks, rays),
                Kind::Other => nearest.test_each(asked, number, shape, scene, rays),
            }
        }
        let met = nearest.shape.simd_ge(Lanes::ZERO).to_bitmask() & active;
        let mut hits = nearest.whole;
        for lane in each_lane(met) {
            let shape = &self.shapes[nearest.shape.as_array()[lane] as usize];
            let part = nearest.part.as_array()[lane] as usize;
            let (u, v) = (nearest.u.as_array()[lane], nearest.v.as_array()[lane]);
            let place = Vec2::new(u, v);
            let (primitive, u, v) = match &shape.kind {
                Kind::Rectangle | Kind::Sphere => (0, u, v),
                Kind::Square(face) => face.at(place),
                Kind::Cube(faces) => faces[part].at(place),
                Kind::TinyMesh(mesh) => (mesh.triangle(part), u, v),
                Kind::Boxed(..) | Kind::Other | Kind::Blocks => continue,
            };
            let t = nearest.t.as_array()[lane];
            hits[lane] = Some(Hit {
                primitive,
                ..Hit::of_shape(shape.instance, LocalHit { t, u, v })
            });
        }
        hits
    }

    /// The obstacles on the rays of the lanes in `active`, where `is_clear` is true for instances that light may pass
    /// straight through.
    pub fn any<const COHERENT: bool>(
        &self,
        scene: Shapes,
        rays: &RayLanes,
        active: u32,
        is_clear: impl Fn(usize) -> bool,
    ) -> Obstacles {
        let mut obstacles = Obstacles::default();
        let slabs = self.has_boxes.then(|| SlabLanes::new(rays));
        let meet = |bounds: &Aabb| {
            let met = slabs.as_ref().map(|slabs| slabs.meets(bounds, rays.t_max).to_bitmask());
            met.unwrap_or(u32::MAX)
        };
        let mut walk = Walk::new(&self.steps);
        while let Some((number, asked)) = walk.next(active & !obstacles.opaque, meet) {
            let shape = &self.shapes[number];
            let met = match &shape.kind {
                Kind::Rectangle | Kind::Square(_) => rectangle(&shape.local(rays), rays.t_max).met.to_bitmask(),
                Kind::Sphere => sphere(&shape.local(rays), rays.t_max).met.to_bitmask(),
                Kind::Cube(_) => cube(&shape.local(rays), rays.t_max).met.to_bitmask(),
                Kind::TinyMesh(mesh) => {
                    let local = shape.local(rays);
                    let near = SlabLanes::new(&local).meets(mesh.bounds(), rays.t_max) & lanes_of(asked);
                    if near.none() {
                        continue;
                    }
                    let mut met = Lanes::ZERO;
                    mesh.each_hit(&local, |t, weights, _| {
                        met |= near & t.simd_lt(rays.t_max) & t.simd_gt(rays.t_min) & weights.inside;
                        asked & !met.to_bitmask() == 0
                    });
                    met.to_bitmask()
                }
                Kind::Boxed(bounds, is_cached) => {
                    let local = shape.local(rays);
                    let met = SlabLanes::new(&local).meets(bounds, rays.t_max).to_bitmask() & asked;
                    match shape.mesh(scene) {
                        Some(mesh) if COHERENT => mesh.occluded_packet(&local, met),
                        Some(mesh) if *is_cached || met.count_ones() <= FEW_RAYS => {
                            local.lanes_where(met, |ray| mesh.occluded(ray))
                        }
                        Some(mesh) => mesh.occluded_lanes(&local, met),
                        None => 0,
                    }
                }
                Kind::Blocks => {
                    any_of_blocks(asked, scene.blocks, rays, &is_clear, &mut obstacles);
                    continue;
                }
                Kind::Other => rays.lanes_where(asked, |ray| shape.instance(scene).occluded(ray)),
            } & asked;
            if met != 0 {
                obstacles.add(met, is_clear(shape.instance as usize));
            }
        }
        obstacles
    }
}

impl SceneShape {
    const BLOCKS: Self = Self {
        instance: 0,
        kind: Kind::Blocks,
        rows: [Vec3::ZERO; 3],
        place: Vec3::ZERO,
    };

    fn new(index: u32, instance: &Instance) -> Self {
        let mut placed = instance.exact_world_from_local();
        let kind = match &instance.primitive {
            Primitive::Rectangle => Kind::Rectangle,
            Primitive::Sphere => Kind::Sphere,
            Primitive::Disk | Primitive::Cylinder | Primitive::Curves(_) => Kind::Other,
            Primitive::Mesh(blas) => {
                let is_invertible = |mesh: &AffineMesh| (placed * mesh.placed).inverse().as_affine3a().is_finite();
                if let Some(mesh) = blas.affine.as_ref().filter(|mesh| is_invertible(mesh)) {
                    placed *= mesh.placed;
                    match mesh.faces[..] {
                        [face] => Kind::Square(face),
                        _ => Kind::Cube(mesh.faces.clone()),
                    }
                } else if let Some(mesh) = TinyMesh::new(blas.mesh()) {
                    Kind::TinyMesh(mesh)
                } else {
                    Kind::Boxed(blas.bounds(), blas.bytes() <= CACHED)
                }
            }
        };
        let linear = placed.matrix3.inverse();
        Self {
            instance: index,
            kind,
            rows: [0, 1, 2].map(|row| linear.row(row).as_vec3()),
            place: placed.translation.as_vec3(),
        }
    }

    #[inline(always)]
    fn local(&self, rays: &RayLanes) -> RayLanes {
        local_to(rays, &self.rows, self.place)
    }

    fn instance<'a>(&self, scene: Shapes<'a>) -> &'a Instance {
        &scene.instances[self.instance as usize]
    }

    fn mesh<'a>(&self, scene: Shapes<'a>) -> Option<&'a Blas> {
        match &self.instance(scene).primitive {
            Primitive::Mesh(blas) => Some(blas),
            _ => None,
        }
    }
}

impl Nearest {
    /// Records a hit of the `number`-th shape in the lanes of `asked` that meet it.
    #[inline(always)]
    fn take(&mut self, asked: u32, number: Lanes, hit: &ShapeHitLanes) {
        let met = hit.met & lanes_of(asked);
        self.t = met.select(hit.t, self.t);
        self.u = met.select(hit.u, self.u);
        self.v = met.select(hit.v, self.v);
        self.shape = met.select(number, self.shape);
        self.part = met.select(hit.part, self.part);
    }

    /// The ray of a lane, ended at its nearest hit so far.
    #[inline(always)]
    fn shortened(&self, lane: usize, rays: &RayLanes) -> Ray {
        Ray {
            t_max: self.t.as_array()[lane],
            ..rays.get(lane)
        }
    }

    /// Tests the rays of the lanes `mask` against the shape one by one.
    #[inline(always)]
    fn test_each(&mut self, mask: u32, number: Lanes, shape: &SceneShape, scene: Shapes, rays: &RayLanes) {
        let instance = shape.instance(scene);
        for lane in each_lane(mask) {
            let ray = self.shortened(lane, rays);
            if let Some(hit) = instance.closest::<false>(shape.instance, &ray, &mut TraversalStats::default()) {
                self.set(lane, number, hit);
            }
        }
    }

    /// Tests the rays of the lanes `mask` against the blocks whose boxes they meet.
    #[inline(never)]
    fn test_blocks(
        &mut self,
        mask: u32,
        number: Lanes,
        (blocks, members): (&[ShapeBlock], &[Members]),
        rays: &RayLanes,
    ) {
        let slabs = SlabLanes::new(rays);
        for (block, members) in blocks.iter().zip(members) {
            let met = slabs.meets(&block.bounds, self.t).to_bitmask() & mask;
            for lane in each_lane(met) {
                if let Some(hit) = block.closest(members, &self.shortened(lane, rays)) {
                    self.set(lane, number, hit);
                }
            }
        }
    }

    #[inline(always)]
    fn set(&mut self, lane: usize, number: Lanes, hit: Hit) {
        self.t.as_mut_array()[lane] = hit.t;
        self.shape.as_mut_array()[lane] = number.as_array()[lane];
        self.whole[lane] = Some(hit);
    }
}

/// Adds the obstacles in the blocks on the rays of the lanes in `mask`.
#[inline(never)]
fn any_of_blocks(
    mask: u32,
    (blocks, members): (&[ShapeBlock], &[Members]),
    rays: &RayLanes,
    is_clear: &impl Fn(usize) -> bool,
    obstacles: &mut Obstacles,
) {
    let slabs = SlabLanes::new(rays);
    for (block, members) in blocks.iter().zip(members) {
        let met = slabs.meets(&block.bounds, rays.t_max).to_bitmask() & mask & !obstacles.opaque;
        for lane in each_lane(met) {
            obstacles.add_lane(lane, block.obstacle(members, &rays.get(lane), is_clear));
        }
    }
}
