//! The work that the surface area heuristic expects of a ray, in all hierarchies and by shape.

use std::collections::HashMap;
use std::sync::Arc;

use super::instance::Primitive;
use super::tlas::{Item, Tlas};

impl Tlas {
    /// [`Bvh::expected_work`](super::bvh::Bvh::expected_work) of all hierarchies together: a leaf with a mesh or a
    /// group counts the expected work of its hierarchy, and each shape of a block counts one.
    pub fn expected_work(&self) -> f64 {
        let (of_shape, of_group) = (self.work_within_shapes(), self.work_within_groups());
        self.bvh.expected_work(|number| match self.item(number) {
            Item::Shape(_) => of_shape[number as usize],
            Item::Placement(placement) => of_group.get(placement.group as usize).copied().unwrap_or(0.0),
            Item::Block(_, members) => members.indices().len() as f64,
        })
    }

    /// The expected work of a random ray through the scene within each instance and placement, in the order of
    /// [`Hit::instance`](super::hit::Hit::instance): the work within, times the chance of meeting its box. The work on
    /// the way to the boxes is left out.
    pub fn work_of_items(&self) -> Vec<f64> {
        let area = f64::from(self.bounds().half_area()).max(f64::MIN_POSITIVE);
        let of_group = self.work_within_groups();
        let placed = self.placements().iter();
        let placed = placed.map(|placement| of_group.get(placement.group as usize).copied().unwrap_or(0.0));
        let within = self.work_within_shapes().into_iter().chain(placed);
        let share = |number| {
            let bounds = self.bounds_of(number).map_or(0.0, |bounds| bounds.half_area());
            (f64::from(bounds) / area).min(1.0)
        };
        (0..).zip(within).map(|(number, work)| share(number) * work).collect()
    }

    /// The work of a ray that meets the box of each shape. The work of a mesh is computed once, however many instances
    /// it has.
    fn work_within_shapes(&self) -> Vec<f64> {
        let mut of_mesh: HashMap<*const (), f64> = HashMap::new();
        let within = |primitive: &Primitive| match primitive {
            Primitive::Mesh(blas) => *of_mesh
                .entry(Arc::as_ptr(blas).cast())
                .or_insert_with(|| blas.bvh().expected_work(|_| 1.0)),
            Primitive::Curves(curves) => *of_mesh
                .entry(Arc::as_ptr(curves).cast())
                .or_insert_with(|| curves.bvh().expected_work(|_| 1.0)),
            _ => 1.0,
        };
        self.instances()
            .iter()
            .map(|instance| &instance.primitive)
            .map(within)
            .collect()
    }

    fn work_within_groups(&self) -> Vec<f64> {
        self.groups().iter().map(|group| group.expected_work()).collect()
    }
}
