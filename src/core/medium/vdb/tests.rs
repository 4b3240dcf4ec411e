//! The files of the corpus are from OpenVDB 12, which also reads the repacked ones. The values of voxels follow from
//! their positions, see [`written`].

use glam::{DVec3, IVec3, UVec3, Vec3};

use super::*;
use crate::medium::Voxels;

const SMOKE: &[u8] = include_bytes!("../../../../tests/corpus/vdb/smoke-blosc.vdb");
const FIRE: &[u8] = include_bytes!("../../../../tests/corpus/vdb/fire-zip-half.vdb");
const TURNED: &[u8] = include_bytes!("../../../../tests/corpus/vdb/turned-mask.vdb");

const PLENTY: u64 = 1 << 20;

fn read(file: &[u8], name: Option<&str>) -> Result<VdbVolume, VdbError> {
    VdbFile::open(file)?.read(name, PLENTY)
}

/// The value that was written for a voxel.
fn written(at: IVec3) -> f32 {
    ((at.x * 7 + at.y * 13 + at.z * 29).rem_euclid(64) + 1) as f32 / 64.0
}

/// Whether a voxel is in the ellipsoid of active voxels.
fn is_in_ball(at: IVec3, middle: IVec3, radius: i32) -> bool {
    let way = at - middle;
    way.x * way.x + 2 * way.y * way.y + way.z * way.z <= radius * radius
}

/// Compares all voxels with the expected ones. `first` is the first voxel of the grid in index space.
fn assert_voxels(grid: &VolumeGrid, first: IVec3, expected: impl Fn(IVec3) -> Vec3) {
    let size = grid.resolution();
    for z in 0..size.z {
        for y in 0..size.y {
            for x in 0..size.x {
                let place = UVec3::new(x, y, z);
                let at = first + place.as_ivec3();
                assert_eq!(grid.voxel(place), expected(at), "{at}");
            }
        }
    }
}

#[test]
fn smoke_packed_by_blosc_is_read() {
    assert_eq!(VdbFile::open(SMOKE).unwrap().names(), ["density"]);
    let volume = read(SMOKE, None).unwrap();
    let (middle, radius) = (IVec3::new(-20, -30, -25), 9);
    let first = middle - IVec3::new(10, 7, 10);
    assert_eq!(volume.grid.resolution(), UVec3::new(21, 15, 21));
    assert!(matches!(volume.grid.voxels(), Voxels::F32(_)));
    assert_voxels(&volume.grid, first, |at| match is_in_ball(at, middle, radius) {
        true => Vec3::splat(written(at)),
        false => Vec3::ZERO,
    });
    // Voxels of a quarter with their centres at integers, moved by (1, 2, 3).
    let corner = |at: Vec3| volume.world_from_local.transform_point3(at);
    let low = (first.as_vec3() - 0.5) * 0.25 + Vec3::new(1.0, 2.0, 3.0);
    assert_eq!(corner(Vec3::ZERO), low);
    assert_eq!(corner(Vec3::ONE), low + Vec3::new(21.0, 15.0, 21.0) * 0.25);
}

#[test]
fn half_precision_several_grids_tiles_and_colors_are_read() {
    let middle = IVec3::new(20, 30, 25);
    let volume = read(FIRE, Some("color")).unwrap();
    assert!(matches!(volume.grid.voxels(), Voxels::F16(_)));
    assert_eq!(volume.grid.channels(), 3);
    let first = middle - IVec3::new(5, 3, 5);
    assert_eq!(volume.grid.resolution(), UVec3::new(11, 7, 11));
    assert_voxels(&volume.grid, first, |at| {
        let value = written(at);
        match is_in_ball(at, middle, 4) {
            true => Vec3::new(value, 1.0 - value / 2.0, value / 4.0),
            false => Vec3::new(0.25, 0.0, 0.5),
        }
    });
    let size = volume.world_from_local.transform_vector3(Vec3::ONE);
    assert_eq!(size, Vec3::new(11.0, 14.0, 33.0));
    let volume = read(FIRE, Some("temperature")).unwrap();
    // A tile reaches beyond the ball.
    let first = IVec3::new(14, 23, 19);
    let tile = IVec3::new(32, 24, 24);
    assert_eq!(volume.grid.resolution(), UVec3::new(27, 12, 14));
    assert_voxels(&volume.grid, first, |at| {
        let inactive = (1..=2).find(|k| at == middle + IVec3::new(k * 3 % 5, 0, k * 2 % 5));
        Vec3::splat(match inactive {
            Some(k) => 0.25 * k as f32,
            None if is_in_ball(at, middle, 5) => written(at),
            None if at.cmpge(tile).all() && at.cmplt(tile + 8).all() => 0.75,
            None => 0.0,
        })
    });
}

#[test]
fn affine_maps_and_inactive_values_are_read() {
    let volume = read(TURNED, Some("density")).unwrap();
    let middle = IVec3::new(20, 30, 25);
    let first = middle - IVec3::new(5, 3, 5);
    assert_voxels(&volume.grid, first, |at| {
        // Three leaves: with one value beside the background, with two others, and with another one.
        let inactive = match (at.x < 24, at.y < 32, at.z < 24) {
            _ if at == IVec3::new(23, 30, 27) => return Vec3::splat(0.25),
            (false, true, false) => [0.5, 0.75][at.z as usize % 2],
            // The first leaf of the row is missing.
            (true, false, false) if at.x >= 16 => 0.5,
            _ => 0.0,
        };
        Vec3::splat(match is_in_ball(at, middle, 4) {
            true => written(at),
            false => inactive,
        })
    });
    let low = first.as_dvec3() - 0.5;
    let (x, y, z) = (
        DVec3::new(1.0, 0.2, 0.0),
        DVec3::new(-0.3, 1.5, 0.1),
        DVec3::new(0.0, 0.25, -2.0),
    );
    let expected = DVec3::new(4.0, -5.0, 6.0) + low.x * x + low.y * y + low.z * z;
    let found = volume.world_from_local.transform_point3(Vec3::ZERO);
    assert!((found.as_dvec3() - expected).length() < 1e-5, "{found} {expected}");
}

#[test]
fn the_grid_that_is_meant_is_named_or_usual_or_the_only_one() {
    let names = ["temperature", "color"].map(str::to_owned).to_vec();
    assert_eq!(read(FIRE, None), Err(VdbError::ManyGrids(names.clone())));
    let name = "density".to_owned();
    let error = read(FIRE, Some("density")).unwrap_err();
    assert_eq!(error, VdbError::UnknownGrid { name, names });
    assert_eq!(
        error.to_string(),
        "the .vdb file has no grid `density`, only `temperature`, `color`"
    );
}

#[test]
fn grids_that_are_too_large_are_refused_before_memory_is_taken() {
    let bytes = 21 * 15 * 21 * 4;
    let file = VdbFile::open(SMOKE).unwrap();
    assert!(file.read(None, bytes).is_ok());
    let error = file.read(None, bytes - 1).unwrap_err();
    assert!(
        matches!(error, VdbError::TooLarge { limit, .. } if limit == bytes - 1),
        "{error}"
    );
}

#[test]
fn files_that_end_too_early_say_so() {
    for file in [SMOKE, FIRE, TURNED] {
        for end in (0..8).chain((8..file.len()).step_by(37)) {
            let expected = match end {
                0..8 => VdbError::NotVdb,
                _ => VdbError::Truncated(end as u64),
            };
            let name = VdbFile::open(file).unwrap().names().pop();
            assert_eq!(read(&file[..end], name.as_deref()), Err(expected));
        }
    }
}

/// The file with other bytes at the position `at`.
fn changed(file: &[u8], at: usize, bytes: &[u8]) -> Vec<u8> {
    let mut changed = file.to_vec();
    changed[at..at + bytes.len()].copy_from_slice(bytes);
    changed
}

/// The position after these bytes, which occur once in the file.
fn behind(file: &[u8], text: &[u8]) -> usize {
    let mut places = file
        .windows(text.len())
        .enumerate()
        .filter(|(_, window)| *window == text);
    let (at, _) = places.next().unwrap();
    at + text.len()
}

#[test]
fn other_files_and_versions_are_refused() {
    assert_eq!(read(b"VOL\x03 and more", None), Err(VdbError::NotVdb));
    for version in [OLDEST - 1, NEWEST + 1] {
        let file = changed(SMOKE, 8, &version.to_le_bytes());
        assert_eq!(read(&file, None), Err(VdbError::Version(version)));
    }
    assert_eq!(read(&changed(SMOKE, 20, &[0]), None), Err(VdbError::Stream));
}

#[test]
fn other_types_maps_and_classes_are_refused() {
    let tree = behind(SMOKE, b"Tree_");
    let file = changed(SMOKE, tree, b"int32");
    assert!(matches!(read(&file, None), Err(VdbError::Type { tree, .. }) if tree == "Tree_int32_5_4_3"));
    let map = behind(TURNED, b"AffineMap") - 9;
    let file = changed(TURNED, map, b"CurvedMap");
    assert!(matches!(read(&file, None), Err(VdbError::Map { map, .. }) if map == "CurvedMap"));
    let flat = changed(TURNED, map + 9, &[0; 96]);
    assert!(matches!(read(&flat, None), Err(VdbError::Map { .. })));
    let class = behind(SMOKE, b"fog volume") - 10;
    let mut file = changed(SMOKE, class, b"level set ");
    assert_eq!(file[class - 4], 10);
    file[class - 4] = 9;
    file.remove(class + 9);
    // All later positions have moved, and so has the end of the grid.
    let end = file.len() as u64;
    let table = behind(&file, b"Tree_float_5_4_3") + 4;
    file[table + 16..table + 24].copy_from_slice(&end.to_le_bytes());
    assert_eq!(read(&file, None), Err(VdbError::LevelSet("density".to_owned())));
}
