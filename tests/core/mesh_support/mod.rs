//! What tests of mesh readers have in common.
#![allow(dead_code, reason = "every test binary uses its own part")]

use sunroom::geometry::mesh::MeshData;

/// What every reader promises of every mesh it gives.
pub fn assert_sound(mesh: &MeshData) {
    let count = mesh.positions.len();
    assert!(!mesh.triangles.is_empty());
    assert!(
        mesh.triangles.iter().flatten().all(|&i| (i as usize) < count),
        "an index is out of range"
    );
    assert!(mesh.positions.iter().all(|p| p.is_finite()));
    assert_eq!(mesh.normals.len(), count);
    assert!(
        mesh.normals.iter().all(|n| (n.length() - 1.0).abs() < 1e-5),
        "a normal is not of unit length"
    );
    assert!(mesh.uvs.is_empty() || mesh.uvs.len() == count);
    assert!(mesh.uvs.iter().all(|uv| uv.is_finite()));
    let materials = &mesh.material_of_triangle;
    assert!(materials.is_empty() || materials.len() == mesh.triangles.len());
    assert!(materials.iter().all(|&m| (m as usize) < mesh.materials.len()));
}

/// Numbers that look random and are the same in every run (SplitMix64: Steele, Lea and Flood 2014).
pub struct Random(pub u64);

impl Random {
    pub fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    pub fn below(&mut self, end: usize) -> usize {
        (self.next() % end as u64) as usize
    }

    pub fn float(&mut self) -> f32 {
        (self.next() >> 40) as f32 / 1e6 - 8.0
    }
}
