use std::time::Duration;

use bevy::math::{Vec3, Vec4};

use super::*;
use crate::geometry::strands::Strands;

/// A curve of so many control points along x.
fn curve(points: usize) -> Arc<MeshData> {
    let strands = Strands {
        points: (0..points).map(|x| Vec4::new(x as f32, 0.0, 0.0, 0.1)).collect(),
        firsts: vec![0],
        shortest: (points as u32, 1),
    };
    Arc::new(MeshData {
        strands,
        ..MeshData::default()
    })
}

fn scaled(basis: Basis, scale: f32) -> MeshKey {
    MeshKey::Curves {
        id: AssetId::invalid(),
        basis,
        stretch: Mat3::from_diagonal(Vec3::splat(scale))
            .to_cols_array()
            .map(f32::to_bits),
    }
}

fn policy(wait: bool) -> BuildPolicy {
    BuildPolicy {
        method: SplitMethod::Sah,
        threads: 1,
        wait,
        wake_up: WakeUp::default(),
    }
}

impl BlasCache {
    /// The scale of the curves that are shown in a round in which these alone are requested.
    fn shown(&mut self, key: MeshKey, data: &Arc<MeshData>, wait: bool) -> Option<f32> {
        self.begin_use();
        let shown = self.get(key, data, &policy(wait)).map(|built| built.stretch.x_axis.x);
        self.end_use();
        shown
    }

    #[track_caller]
    fn wait_for_any(&mut self) {
        for _ in 0..2000 {
            if self.poll() {
                return;
            }
            std::thread::sleep(Duration::from_millis(5));
        }
        panic!("no build has ended within ten seconds");
    }
}

#[test]
fn curves_are_shown_while_they_are_scaled_and_built_one_at_a_time() {
    let mut cache = BlasCache::default();
    let data = curve(5000);
    let key = |scale| scaled(Basis::BSpline, scale);
    assert_eq!(cache.shown(key(1.0), &data, true), Some(1.0));
    // Builds end only when they are taken in.
    for scale in [2.0, 3.0, 4.0] {
        assert_eq!(cache.shown(key(scale), &data, false), Some(1.0));
        assert_eq!(cache.builds_running(), 1);
    }
    cache.wait_for_any();
    assert_eq!(cache.builds_running(), 0);
    assert_eq!(cache.shown(key(4.0), &data, false), Some(2.0), "the newest");
    assert_eq!(cache.builds_running(), 1);
    cache.wait_for_any();
    assert_eq!(cache.shown(key(4.0), &data, false), Some(4.0));
    assert_eq!((cache.builds_running(), cache.entries.len()), (0, 1));
    // Pictures of files wait, also beside a build that is running.
    assert_eq!(cache.shown(key(5.0), &data, false), Some(4.0));
    assert_eq!(cache.shown(key(6.0), &data, true), Some(6.0));
    // Other curves of the file do not wait for these.
    assert_eq!(cache.shown(key(7.0), &data, false), Some(6.0));
    assert_eq!(cache.shown(scaled(Basis::Linear, 7.0), &data, false), None);
    assert_eq!(cache.builds_running(), 1, "the other one is no longer used");
}

#[test]
fn each_hierarchy_of_a_file_has_memory_of_its_own() {
    let mut cache = BlasCache::default();
    let data = curve(100);
    let mut has_a_copy = |key| {
        let built = cache.get(key, &data, &policy(true)).expect("it is built");
        let Primitive::Curves(curves) = &built.primitive else {
            panic!("these are curves");
        };
        !Arc::ptr_eq(curves.mesh(), &data)
    };
    assert!(!has_a_copy(scaled(Basis::BSpline, 1.0)));
    assert!(has_a_copy(scaled(Basis::Linear, 1.0)));
    assert!(has_a_copy(scaled(Basis::BSpline, 2.0)));
    assert!(!has_a_copy(scaled(Basis::BSpline, 1.0)), "it is there already");
}
