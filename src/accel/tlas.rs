//! The hierarchy over all instances: what the integrator asks.

use super::build::{LeafShape, SplitMethod};
use super::bvh::{Bvh, BvhStats};
use super::instance::Instance;
use super::traverse::Steps;
use crate::math::{Aabb, Ray};

/// All instances of a scene, in the order given, with a hierarchy over their world bounds.
#[derive(Clone, Debug)]
pub struct Tlas {
    instances: Vec<Instance>,
    bvh: Bvh,
}

/// A hit in the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Parameter of the world ray.
    pub t: f32,
    /// Index into [`Tlas::instances`].
    pub instance: u32,
    /// The mesh's triangle; zero for other shapes.
    pub primitive: u32,
    /// As in [`crate::geometry::local::LocalHit`].
    pub u: f32,
    pub v: f32,
}

impl Tlas {
    pub fn build(instances: Vec<Instance>, method: SplitMethod) -> Self {
        let bounds: Vec<Aabb> = instances.iter().map(Instance::world_bounds).collect();
        let bvh = Bvh::build(&bounds, method, LEAF);
        Self { instances, bvh }
    }

    pub fn instances(&self) -> &[Instance] {
        &self.instances
    }

    pub fn bvh(&self) -> &Bvh {
        &self.bvh
    }

    /// World bounds of everything; empty if there is nothing.
    pub fn bounds(&self) -> Aabb {
        self.bvh.bounds()
    }

    /// Figures of the hierarchy over instances alone; those of the meshes are theirs ([`super::Blas::stats`]).
    pub fn stats(&self) -> BvhStats {
        self.bvh.stats()
    }

    /// [`Bvh::validate`] against the instances' bounds.
    pub fn validate(&self) -> Result<(), String> {
        let bounds: Vec<Aabb> = self.instances.iter().map(Instance::world_bounds).collect();
        self.bvh.validate(&bounds)
    }

    /// The nearest hit with 0 < t < t_max.
    pub fn intersect(&self, ray: &Ray) -> Option<Hit> {
        let mut nearest = None;
        self.bvh.closest(ray, |range, t_max| {
            for &index in &self.bvh.order()[range] {
                let instance = &self.instances[index as usize];
                let local = Ray {
                    t_max: *t_max,
                    ..instance.local_ray(ray)
                };
                if let Some((hit, primitive)) = instance.intersect_local(&local) {
                    *t_max = hit.t;
                    nearest = Some(Hit {
                        t: hit.t,
                        instance: index,
                        primitive,
                        u: hit.u,
                        v: hit.v,
                    });
                }
            }
        });
        nearest
    }

    /// Whether anything is hit with 0 < t < t_max.
    pub fn occluded(&self, ray: &Ray) -> bool {
        self.bvh.any(ray, |range| {
            self.bvh.order()[range].iter().any(|&index| {
                let instance = &self.instances[index as usize];
                instance.occluded_local(&instance.local_ray(ray))
            })
        })
    }

    /// [`Tlas::intersect`] with the number of boxes and primitives it tested, for the heat map.
    pub fn intersect_counting(&self, ray: &Ray) -> (Option<Hit>, u32) {
        let mut nearest = None;
        let mut steps = Steps::default();
        let mut inner = Steps::default();
        self.bvh.closest_counting(ray, &mut steps, |range, t_max| {
            for &index in &self.bvh.order()[range] {
                let instance = &self.instances[index as usize];
                let local = Ray {
                    t_max: *t_max,
                    ..instance.local_ray(ray)
                };
                if let Some((hit, primitive)) = instance.intersect_local_counting(&local, &mut inner) {
                    *t_max = hit.t;
                    nearest = Some(Hit {
                        t: hit.t,
                        instance: index,
                        primitive,
                        u: hit.u,
                        v: hit.v,
                    });
                }
            }
        });
        (nearest, steps.total() + inner.total())
    }
}

/// Instances are dear to test, boxes are cheap.
const LEAF: LeafShape = LeafShape {
    max_primitives: 1,
    align: 1,
};
