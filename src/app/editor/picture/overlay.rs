//! The boxes of the acceleration structures, drawn over the picture.

use std::collections::HashSet;
use std::sync::Arc;

use bevy::math::{Affine3A, Vec2, Vec3};

use crate::accel::{BvhBox, BvhStats, Placement, Primitive, Tlas};
use crate::app::editor::camera::screen::segment;
use crate::app::editor::command::bvh_overlay::BvhOverlay;
use crate::app::editor::words::figures::counted;
use crate::math::Aabb;
use crate::render::camera::Camera;

/// The most boxes; more would neither be legible nor drawn in time.
pub(crate) const MAX_BOXES: usize = 4000;

/// The eight corners of a box in the world. Corner k has bit 0 of k for the upper x, bit 1 for y, bit 2 for z.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WorldBox {
    /// The corners in world space.
    pub corners: [Vec3; 8],
    /// Whether it belongs to the hierarchy over the instances, not to one of a mesh.
    pub over_instances: bool,
}

/// The boxes to be drawn, at most 4000, and their full number; with figures of the hierarchies.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BoxList {
    /// The boxes that are drawn.
    pub boxes: Vec<WorldBox>,
    /// The number of boxes at the chosen depth.
    pub total: usize,
    /// The number of leaves in the total.
    pub leaves: usize,
    /// The number of leaves of meshes, and below the triangles in them.
    mesh_leaves: usize,
    triangles: usize,
    /// The expected work, see [`Tlas::expected_work`].
    pub expected_work: f64,
    /// The number of nodes of all hierarchies, each mesh's counted once.
    pub nodes: usize,
    /// Memory of all hierarchies.
    pub bytes: usize,
}

/// Collects the boxes of all hierarchies at the depth that `overlay` asks for.
pub fn boxes(geometry: &Tlas, overlay: &BvhOverlay) -> BoxList {
    let mut list = BoxList {
        expected_work: geometry.expected_work(),
        ..BoxList::default()
    };
    let mut counted = HashSet::new();
    list.add(geometry, overlay, &mut counted);
    let of_group = |group: &Arc<Tlas>| {
        let mut list = BoxList::default();
        list.add(group, overlay, &mut counted);
        list
    };
    let groups: Vec<BoxList> = geometry.groups().iter().map(of_group).collect();
    for group in &groups {
        list.nodes += group.nodes;
        list.bytes += group.bytes;
    }
    for placement in geometry.placements() {
        if let Some(group) = groups.get(placement.group as usize) {
            list.place(group, placement);
        }
    }
    list
}

impl BoxList {
    /// Adds the boxes of a hierarchy over shapes and of their meshes. `counted` has the meshes whose nodes are counted
    /// already.
    fn add(&mut self, geometry: &Tlas, overlay: &BvhOverlay, counted: &mut HashSet<*const ()>) {
        self.count(&geometry.stats());
        geometry
            .bvh()
            .visit_boxes(|found| self.offer(&found, overlay, &Affine3A::IDENTITY, true));
        for instance in geometry.instances().iter() {
            let (own, stats, bvh) = match &instance.primitive {
                Primitive::Mesh(blas) => (Arc::as_ptr(blas).cast(), blas.stats(), blas.bvh()),
                Primitive::Curves(curves) => (Arc::as_ptr(curves).cast(), curves.stats(), curves.bvh()),
                _ => continue,
            };
            if counted.insert(own) {
                self.count(&stats);
            }
            bvh.visit_boxes(|found| self.offer(&found, overlay, &instance.world_from_local, false));
        }
    }

    /// Adds the boxes of a group once more, at a placement.
    fn place(&mut self, group: &Self, placement: &Placement) {
        self.total += group.total;
        self.leaves += group.leaves;
        self.mesh_leaves += group.mesh_leaves;
        self.triangles += group.triangles;
        let room = MAX_BOXES - self.boxes.len();
        if room > 0 {
            let world_from_group = placement.world_from_group();
            let placed = group.boxes.iter().take(room).map(|in_group| WorldBox {
                corners: in_group.corners.map(|corner| world_from_group.transform_point3(corner)),
                ..*in_group
            });
            self.boxes.extend(placed);
        }
    }

    fn count(&mut self, stats: &BvhStats) {
        self.nodes += stats.nodes;
        self.bytes += stats.bytes;
    }

    /// A description of the displayed boxes in a few short lines.
    pub(crate) fn figures(&self, overlay: &BvhOverlay) -> String {
        let shown = match overlay.leaves_only {
            true => format!("to depth {}: {}", overlay.depth, counted(self.leaves as u64, "leaf")),
            false => format!(
                "depth {}: {}, {}",
                overlay.depth,
                counted((self.total - self.leaves) as u64, "node"),
                counted(self.leaves as u64, "leaf")
            ),
        };
        let filling = match self.mesh_leaves {
            0 => String::new(),
            leaves => format!(
                ", {:.1} triangles or segments per leaf",
                self.triangles as f64 / leaves as f64
            ),
        };
        format!(
            "SAH cost {:.1} in all\n{shown}{filling}\n{}, {:.1} MB in all",
            self.expected_work,
            counted(self.nodes as u64, "node"),
            self.bytes as f64 / 1e6
        )
    }

    fn offer(&mut self, found: &BvhBox, overlay: &BvhOverlay, world_from_local: &Affine3A, over_instances: bool) {
        let depth = overlay.depth as usize;
        let wanted = if overlay.leaves_only {
            found.is_leaf && found.depth <= depth
        } else {
            found.depth == depth
        };
        if !wanted {
            return;
        }
        self.total += 1;
        self.leaves += usize::from(found.is_leaf);
        if found.is_leaf && !over_instances {
            self.mesh_leaves += 1;
            self.triangles += found.primitives as usize;
        }
        if self.boxes.len() < MAX_BOXES {
            self.boxes.push(WorldBox {
                corners: corners(&found.bounds).map(|corner| world_from_local.transform_point3(corner)),
                over_instances,
            });
        }
    }
}

fn corners(bounds: &Aabb) -> [Vec3; 8] {
    std::array::from_fn(|k| {
        let pick = |bit: usize, axis: usize| {
            if k >> bit & 1 == 0 {
                bounds.min[axis]
            } else {
                bounds.max[axis]
            }
        };
        Vec3::new(pick(0, 0), pick(1, 1), pick(2, 2))
    })
}

/// The edges of a box as pairs of film coordinates ((0, 0) top left, (1, 1) bottom right), cut off at the camera's
/// plane.
pub(crate) fn edges(camera: &Camera, world_box: &WorldBox) -> Vec<[Vec2; 2]> {
    let mut edges = Vec::with_capacity(12);
    for from in 0..8usize {
        for bit in 0..3 {
            let to = from | 1 << bit;
            if to != from {
                edges.extend(segment(camera, world_box.corners[from], world_box.corners[to]));
            }
        }
    }
    edges
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accel::{Instance, SplitMethod};

    /// A scene of shapes that share no leaves.
    fn scene() -> Tlas {
        let instances = (0..20)
            .filter_map(|i| {
                Instance::new(
                    Primitive::Cylinder,
                    Affine3A::from_translation(Vec3::new(3.0 * i as f32, 0.0, 9.0)),
                )
            })
            .collect();
        Tlas::build(instances, SplitMethod::Sah)
    }

    #[test]
    fn depth_zero_is_one_box_and_leaves_are_all_instances() {
        let overlay = |depth, leaves_only| BvhOverlay {
            shown: true,
            depth,
            leaves_only,
        };
        assert_eq!(boxes(&scene(), &overlay(0, false)).total, 1);
        assert_eq!(boxes(&scene(), &overlay(40, true)).total, 20);
        assert!(boxes(&scene(), &overlay(40, false)).boxes.is_empty());
        let root = boxes(&scene(), &overlay(0, false));
        let text = root.figures(&overlay(0, false));
        assert!(text.contains("depth 0: 1 node, 0 leaves\n"), "{text}");
        let leaves = boxes(&scene(), &overlay(40, true));
        assert!(leaves.figures(&overlay(40, true)).contains("to depth 40: 20 leaves\n"));
    }

    #[test]
    fn groups_show_wherever_they_stand() {
        let at = |x: f32| Placement::new(0, &Affine3A::from_translation(Vec3::X * x)).expect("regular");
        let lone = scene().instances()[0].clone();
        let all = Tlas::with_placements(
            vec![lone],
            vec![Arc::new(scene())],
            vec![at(100.0), at(200.0)],
            SplitMethod::Sah,
        );
        let roots = boxes(
            &all,
            &BvhOverlay {
                shown: true,
                depth: 0,
                leaves_only: false,
            },
        );
        // They are the box around everything and those of the two places.
        assert_eq!((roots.total, roots.boxes.len()), (3, 3));
        let moved = roots.boxes[2].corners[0] - roots.boxes[1].corners[0];
        assert!(moved.abs_diff_eq(Vec3::X * 100.0, 1e-3), "{moved}");
        assert!(roots.nodes > boxes(&scene(), &BvhOverlay::default()).nodes);
        let leaves = boxes(
            &all,
            &BvhOverlay {
                shown: true,
                depth: 40,
                leaves_only: true,
            },
        );
        assert_eq!(leaves.total, 3 + 2 * 20);
    }

    #[test]
    fn edges_are_twelve_in_front_and_cut_at_the_camera() {
        let camera = Camera::new(Affine3A::IDENTITY, 90.0, 1.0, 0.01, 100.0, None);
        let at = |z: f32| WorldBox {
            corners: corners(&Aabb {
                min: Vec3::new(-1.0, -1.0, z - 1.0),
                max: Vec3::new(1.0, 1.0, z + 1.0),
            }),
            over_instances: false,
        };
        assert_eq!(edges(&camera, &at(5.0)).len(), 12);
        assert_eq!(edges(&camera, &at(-5.0)).len(), 0);
        // The box is around the camera, so that the four edges behind are left out.
        let around = edges(&camera, &at(0.5));
        assert_eq!(around.len(), 8);
        assert!(around.iter().flatten().all(|p| p.is_finite()));
    }
}
