//! The tree of a grid: a root with tiles and children, two levels of internal nodes of 32^3 and 16^3 children, and
//! leaves of 8^3 voxels. A child that is not a node is a tile of constant value.
//!
//! The file has all nodes first, depth first, with the values of their tiles and the masks of active voxels, and then
//! the values of all leaves in the same order. Nodes are read twice, first to find the box of active voxels and then to
//! fill it, so that only the positions of leaves have to be stored.

use std::collections::HashSet;

use glam::{I64Vec3, IVec3, UVec3};

use super::VdbError;
use super::values::{Component, Mask, ValueReader};

/// Voxels along an edge of a leaf.
const LEAF: i32 = 8;
/// Voxels of a leaf.
const LEAF_VOXELS: usize = 512;

/// A level of internal nodes.
#[derive(Clone, Copy)]
struct Level {
    /// The logarithm, to base 2, of the number of children along an edge.
    children: u32,
    /// The logarithm of the number of voxels along an edge of a child.
    child: u32,
}

const UPPER: Level = Level { children: 5, child: 7 };
const LOWER: Level = Level { children: 4, child: 3 };

impl Level {
    /// The number of children.
    fn count(self) -> usize {
        1 << (3 * self.children)
    }

    /// The offset of a child from its node in voxels. The last coordinate varies fastest.
    fn offset(self, index: usize) -> IVec3 {
        let along = |place: usize| ((place & ((1 << self.children) - 1)) << self.child) as i32;
        IVec3::new(
            along(index >> (2 * self.children)),
            along(index >> self.children),
            along(index),
        )
    }
}

/// Receives the tiles and leaves of a tree. Positions are those of the first voxel, in index space.
pub(super) trait Visit<T, const C: usize> {
    /// A cube of `edge` voxels along an edge, of constant value.
    fn tile(&mut self, first: IVec3, edge: i32, value: [T; C], is_active: bool);
    /// A leaf, whose values come later.
    fn leaf(&mut self, first: IVec3, active: Mask);
}

/// Visits all nodes. Afterwards the reader is at the values of the leaves.
pub(super) fn visit_nodes<T: Component, const C: usize>(
    reader: &mut ValueReader<T, C>,
    visitor: &mut impl Visit<T, C>,
) -> Result<(), VdbError> {
    let edge = 1 << (UPPER.children + UPPER.child);
    let (tiles, children) = (reader.bytes.u32()?, reader.bytes.u32()?);
    let mut taken = HashSet::new();
    let mut place = |reader: &mut ValueReader<T, C>| {
        let place = IVec3::new(reader.bytes.i32()?, reader.bytes.i32()?, reader.bytes.i32()?);
        match place % edge == IVec3::ZERO && taken.insert(place) {
            true => Ok(place),
            false => Err(reader
                .bytes
                .damaged("a place of its own, a multiple of 4096, for each part of the root")),
        }
    };
    for _ in 0..tiles {
        let first = place(reader)?;
        let value = reader.single()?;
        let is_active = reader.bytes.u8()? != 0;
        visitor.tile(first, edge, value, is_active);
    }
    let mut values = Vec::new();
    for _ in 0..children {
        let first = place(reader)?;
        for upper in visit_internal(reader, visitor, UPPER, first, &mut values)?.ones() {
            let first = first + UPPER.offset(upper);
            for lower in visit_internal(reader, visitor, LOWER, first, &mut values)?.ones() {
                let active = Mask::read(&mut reader.bytes, LEAF_VOXELS)?;
                visitor.leaf(first + LOWER.offset(lower), active);
            }
        }
    }
    Ok(())
}

/// Reads an internal node and visits its tiles; returns which of its children are nodes.
fn visit_internal<'a, T: Component, const C: usize>(
    reader: &mut ValueReader<'a, T, C>,
    visitor: &mut impl Visit<T, C>,
    level: Level,
    first: IVec3,
    values: &mut Vec<[T; C]>,
) -> Result<Mask<'a>, VdbError> {
    let children = Mask::read(&mut reader.bytes, level.count())?;
    let active = Mask::read(&mut reader.bytes, level.count())?;
    reader.array(active, values)?;
    for (index, value) in values.iter().enumerate().filter(|(index, _)| !children.has(*index)) {
        visitor.tile(first + level.offset(index), 1 << level.child, *value, active.has(index));
    }
    Ok(children)
}

/// The box of active voxels, and the positions of all leaves.
#[derive(Default)]
pub(super) struct Extent {
    /// The first and the last active voxel along each axis; None if there is none.
    bounds: Option<[IVec3; 2]>,
    leaves: Vec<IVec3>,
}

impl Extent {
    fn grow(&mut self, first: IVec3, last: IVec3) {
        let [lowest, highest] = self.bounds.unwrap_or([first, last]);
        self.bounds = Some([lowest.min(first), highest.max(last)]);
    }

    /// The box with one layer of voxels around it: its first voxel, and the numbers of voxels along its edges.
    pub(super) fn bordered_box(&self) -> Option<(IVec3, I64Vec3)> {
        let [first, last] = self.bounds?;
        // Index space has no voxel before its first one.
        let first = first.saturating_sub(IVec3::ONE);
        Some((first, last.as_i64vec3() - first.as_i64vec3() + 2))
    }
}

impl<T, const C: usize> Visit<T, C> for Extent {
    fn tile(&mut self, first: IVec3, edge: i32, _value: [T; C], is_active: bool) {
        if is_active {
            self.grow(first, first + (edge - 1));
        }
    }

    fn leaf(&mut self, first: IVec3, active: Mask) {
        self.leaves.push(first);
        for voxel in active.ones() {
            let voxel = first + in_leaf(voxel);
            self.grow(voxel, voxel);
        }
    }
}

/// The position of a leaf's value within the leaf.
fn in_leaf(index: usize) -> IVec3 {
    let along = |place: usize| place as i32 & (LEAF - 1);
    IVec3::new(along(index >> 6), along(index >> 3), along(index))
}

/// A dense box of voxels to be filled; x varies fastest.
pub(super) struct Dense<T, const C: usize> {
    first: IVec3,
    size: UVec3,
    background: [T; C],
    pub(super) voxels: Vec<[T; C]>,
}

impl<T: Component, const C: usize> Dense<T, C> {
    /// A box that starts at a voxel of index space, filled with the background.
    pub(super) fn new(first: IVec3, size: UVec3, background: [T; C]) -> Self {
        let [x, y, z] = size.to_array().map(|along| along as usize);
        Self {
            first,
            size,
            background,
            voxels: vec![background; x * y * z],
        }
    }

    /// The part of a cube within the box, from its first voxel to one past its last, in coordinates of the box.
    fn part_of(&self, first: IVec3, edge: i32) -> [UVec3; 2] {
        let first = first.as_i64vec3() - self.first.as_i64vec3();
        [first, first + i64::from(edge)].map(|corner| corner.clamp(I64Vec3::ZERO, self.size.as_i64vec3()).as_uvec3())
    }

    /// Fills in the values of leaves, which are next in the file.
    pub(super) fn fill_leaves(&mut self, extent: &Extent, reader: &mut ValueReader<T, C>) -> Result<(), VdbError> {
        let mut values = Vec::new();
        for &leaf in &extent.leaves {
            let active = Mask::read(&mut reader.bytes, LEAF_VOXELS)?;
            reader.array(active, &mut values)?;
            for (index, value) in values.iter().enumerate() {
                let place = (leaf + in_leaf(index)).as_i64vec3() - self.first.as_i64vec3();
                if place.cmpge(I64Vec3::ZERO).all() && place.cmplt(self.size.as_i64vec3()).all() {
                    let index_in_box = self.index(place.as_uvec3());
                    self.voxels[index_in_box] = *value;
                }
            }
        }
        Ok(())
    }

    fn index(&self, place: UVec3) -> usize {
        let [x, y, z] = place.to_array().map(|at| at as usize);
        let [width, height] = [self.size.x, self.size.y].map(|along| along as usize);
        (z * height + y) * width + x
    }
}

impl<T: Component, const C: usize> Visit<T, C> for Dense<T, C> {
    fn tile(&mut self, first: IVec3, edge: i32, value: [T; C], _is_active: bool) {
        if value == self.background {
            return;
        }
        let [first, end] = self.part_of(first, edge);
        if first.cmpge(end).any() {
            return;
        }
        for z in first.z..end.z {
            for y in first.y..end.y {
                let row = self.index(UVec3::new(first.x, y, z));
                self.voxels[row..row + (end.x - first.x) as usize].fill(value);
            }
        }
    }

    fn leaf(&mut self, _first: IVec3, _active: Mask) {}
}
