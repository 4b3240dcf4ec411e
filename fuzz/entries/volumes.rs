//! Grids of volumes, and light in them.

use std::sync::Arc;

use glam::{Affine3A, UVec3, Vec3};
use sunroom_core::medium::vdb::VdbFile;
use sunroom_core::medium::{
    GridVolume, Medium, MediumSource, Mended, Phase, Volume, VolumeFilter, VolumeWrap, Way, read_vol, write_vol,
};
use sunroom_core::sampling::{Sampler, SequenceKind};

/// A file of volumes: its table and its first grids.
pub fn vdb(bytes: &[u8]) {
    let Ok(file) = VdbFile::open(bytes) else {
        return;
    };
    for name in file.names().iter().take(4) {
        if let Ok(volume) = file.read(Some(name), 1 << 22) {
            assert!(volume.grid.size() <= 1 << 22);
            assert!(volume.world_from_local.inverse().is_finite());
        }
    }
}

/// A grid of a volume. What is read has no negative value, and is the same after it was written and read again.
pub fn vol(bytes: &[u8]) {
    let Ok(file) = read_vol(bytes) else {
        return;
    };
    let last = file.grid.resolution() - 1;
    for place in [UVec3::ZERO, last / 2, last] {
        let value = file.grid.voxel(place);
        assert!(value.is_finite() && value.min_element() >= 0.0, "{value}");
    }
    if let Some(bounds) = &file.bounds {
        let again = read_vol(&write_vol(&file.grid, bounds)).expect("it was written");
        assert_eq!((again.grid.mended(), again.bounds), (Mended::default(), file.bounds));
        assert_eq!(again.grid.voxels(), file.grid.voxels());
    }
}

/// A medium of a grid: the first bytes choose how dense it is, where it lies and by which ways light goes through it,
/// and the rest is a `.vol` file. Light comes to an end, and what is left of it is no more than there was. Returns
/// whether it is a medium.
pub fn media(bytes: &[u8]) -> bool {
    let Some((chosen, file)) = bytes.split_first_chunk::<8>() else {
        return false;
    };
    let Ok(file) = read_vol(file) else { return false };
    let power = |byte: u8| 10.0f32.powi(i32::from(byte % 19) - 6);
    let places = [chosen[1], chosen[2], chosen[3]].map(|byte| 2.0f32.powi(i32::from(byte % 13) - 6));
    let [filter, wrap, shines] = [chosen[4] % 2, chosen[5] % 3, chosen[6] % 4];
    let grid = |grid| {
        Volume::Grid(GridVolume::new(
            grid,
            Affine3A::from_scale(places.into()),
            if filter == 0 {
                VolumeFilter::Nearest
            } else {
                VolumeFilter::Trilinear
            },
            [VolumeWrap::Clamp, VolumeWrap::Repeat, VolumeWrap::Mirror][usize::from(wrap)],
        ))
    };
    let values = Arc::new(file.grid);
    let uneven = Vec3::new(1.0, 0.25, 0.0);
    let (sigma_t, emission) = match shines {
        0 => (grid(values.clone()), grid(values)),
        1 => (Volume::Constant(uneven), grid(values)),
        _ => (grid(values), Volume::ZERO),
    };
    let medium = Medium::new(MediumSource {
        sigma_t,
        scale: power(chosen[0]),
        albedo: Volume::Constant(if shines == 3 { Vec3::ZERO } else { Vec3::splat(0.5) }),
        emission,
        phase: Phase::Isotropic,
    });
    for index in 0..4 {
        let sampler = Sampler::new(
            SequenceKind::Independent,
            glam::UVec2::new(chosen[7].into(), index),
            index,
            0,
        );
        let mut stream = sampler.stream(0);
        let mut number = || stream.draw();
        let (from, to) = (
            Vec3::new(number(), number(), number()) * 2.0 - 0.5,
            Vec3::new(number(), number(), number()),
        );
        let [from, to] = [from, to].map(|place| place * Vec3::from(places));
        let Some(dir) = (to - from).try_normalize() else {
            continue;
        };
        let length = if index % 2 == 0 {
            f32::INFINITY
        } else {
            from.distance(to)
        };
        let way = Way {
            origin: from,
            dir,
            length,
        };
        let mut throughput = Vec3::ONE;
        let travel = medium.travel(&way, None, &mut throughput, glam::Vec2::new(0.3, 0.6), &mut stream);
        assert!(
            throughput.is_finite() && throughput.min_element() >= 0.0,
            "{throughput}"
        );
        assert!(
            travel.emitted.is_finite() && travel.emitted.min_element() >= 0.0,
            "{travel:?}"
        );
        // They are products of shares of sums, which rounding makes no larger than the sums.
        assert!((0.0..=1.0).contains(&travel.passed), "{travel:?}");
        assert!(
            travel.scattered_at.is_none_or(|at| (0.0..=length).contains(&at)),
            "{travel:?}"
        );
        let mut carried = Vec3::ONE;
        let (share, passed) = medium.transmit(&way, &mut carried, &mut stream);
        assert!(share.is_finite() && share.min_element() >= 0.0, "{share}");
        assert!((0.0..=1.0).contains(&passed), "{passed}");
        let depth = medium.optical_depth(&way);
        assert!(depth.min_element() >= 0.0 && !depth.is_nan(), "{depth}");
    }
    true
}
