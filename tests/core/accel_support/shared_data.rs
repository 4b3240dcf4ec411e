//! The models and ray sets that may lie beside the repository.

use std::path::{Path, PathBuf};

use glam::Vec3;
use sunroom::geometry::mesh::MeshData;
use sunroom::geometry::obj::load_obj;
use sunroom::geometry::ply::load_ply;
use sunroom::math::Ray;

/// A file below the shared data folder, if it is there.
fn shared(path: &str) -> Option<PathBuf> {
    let path = Path::new(crate::ROOT).join("../shared/data").join(path);
    path.exists().then_some(path)
}

/// A shared ray set with another program's answers, if it is there: t (infinite for a miss) and triangle (`u32::MAX`
/// for a miss).
///
/// Little endian: a header of four u32, then records of origin, direction, t, triangle.
pub fn answered_rays(name: &str) -> Option<Vec<(Ray, f32, u32)>> {
    let bytes = std::fs::read(shared(&format!("rays/{name}"))?).unwrap();
    assert_eq!(&bytes[..4], b"RAYS");
    let float = |record: &[u8], k: usize| f32::from_le_bytes(record[4 * k..4 * k + 4].try_into().unwrap());
    let vector = |record: &[u8], k: usize| Vec3::new(float(record, k), float(record, k + 1), float(record, k + 2));
    let rays = bytes[16..]
        .chunks_exact(32)
        .map(|record| {
            let ray = Ray::new(vector(record, 0), vector(record, 3));
            (ray, float(record, 6), float(record, 7).to_bits())
        })
        .collect();
    Some(rays)
}

/// A shared model, if it is there.
pub fn model(name: &str) -> Option<MeshData> {
    let path = shared(&format!("models/{name}"))?;
    let bytes = std::fs::read(&path).unwrap();
    let loaded = if name.ends_with(".obj") {
        load_obj(&bytes, &mut |_| Err(std::io::ErrorKind::NotFound.into()))
    } else {
        load_ply(&bytes)
    };
    Some(loaded.unwrap().mesh)
}
