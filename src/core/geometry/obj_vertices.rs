//! Gives each distinct corner of an OBJ file one vertex.

use std::collections::HashMap;

use super::obj_part::{Corner, NONE};

/// The vertices so far, numbered by first use.
pub struct SharedVertices {
    /// The corner of each vertex.
    corners: Vec<Corner>,
    /// For each vertex the previous vertex at the same position, or [`NONE`].
    older: Vec<u32>,
    /// For each position its latest vertex.
    newest: Vec<u32>,
    /// The vertices of positions that have more than [`CROWD`] vertices.
    others: HashMap<Corner, u32>,
}

/// The most vertices in the list of a position, which is rarely reached; further ones go into a hash table.
const CROWD: usize = 8;

impl SharedVertices {
    /// Prepares for corners at `positions` positions.
    pub fn new(positions: usize) -> Self {
        Self {
            corners: Vec::with_capacity(positions),
            older: Vec::with_capacity(positions),
            newest: vec![NONE; positions],
            others: HashMap::new(),
        }
    }

    pub fn ids_of(&mut self, corners: &[Corner]) -> Vec<u32> {
        corners.iter().map(|&corner| self.id_of(corner)).collect()
    }

    #[inline]
    fn id_of(&mut self, corner: Corner) -> u32 {
        let newest = self.newest[corner.position as usize];
        let mut candidate = newest;
        for _ in 0..CROWD {
            match self.corners.get(candidate as usize) {
                Some(known) if *known == corner => return candidate,
                Some(_) => candidate = self.older[candidate as usize],
                None => {
                    self.newest[corner.position as usize] = self.corners.len() as u32;
                    return self.add(corner, newest);
                }
            }
        }
        if let Some(&known) = self.others.get(&corner) {
            return known;
        }
        let id = self.add(corner, NONE);
        self.others.insert(corner, id);
        id
    }

    fn add(&mut self, corner: Corner, older: u32) -> u32 {
        let id = self.corners.len() as u32;
        self.corners.push(corner);
        self.older.push(older);
        id
    }

    pub fn into_corners(self) -> Vec<Corner> {
        self.corners
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::hash::pcg4d;

    #[test]
    fn equal_corners_share_a_vertex_in_order_of_first_use() {
        let mut vertices = SharedVertices::new(5);
        let mut expected: Vec<Corner> = Vec::new();
        for i in 0..20_000 {
            let [position, uv, normal, _] = pcg4d([i, 7, 8, 9]);
            // Some positions stay below a crowd, some are far beyond, some lack a normal.
            let corner = Corner {
                position: position % 5,
                uv: uv % (1 + 9 * (position % 5)),
                normal: [NONE, 0][normal as usize % 2],
            };
            let known = expected.iter().position(|&known| known == corner).unwrap_or_else(|| {
                expected.push(corner);
                expected.len() - 1
            });
            assert_eq!(vertices.id_of(corner) as usize, known);
        }
        assert!(vertices.into_corners() == expected);
    }
}
