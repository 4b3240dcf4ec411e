//! When measuring ends, what it depends on, and how it is judged.

use super::*;

#[test]
fn values_depend_on_the_seed_and_not_on_threads() {
    let scene = corner();
    let meters = || {
        vec![
            grid(Vec2::ONE, Vec3::Y * 0.7, 0.3),
            facing(Vec3::Y, Vec3::new(0.4, 0.0, 0.2)),
        ]
    };
    let readings = |threads, seed| {
        let mut job = MeterJob::new(scene.clone(), &settings(seed), meters()).expect("meters");
        let end = MeterEnd {
            noise: 0.02,
            ..MeterEnd::default()
        };
        job.run(&end, &pool(threads), &AtomicBool::new(false), &mut |_, _| {});
        job.readings().expect("values")
    };
    let one = readings(1, 5);
    assert_eq!(one, readings(3, 5));
    assert_ne!(one, readings(3, 6));
    // Neighbouring seeds have no set of samples in common.
    let values = |readings: &[MeterReading]| readings[1].points[0].value;
    assert!((values(&one) - values(&readings(1, 6))).abs() > 1e-3 * one[1].points[0].error);
}

#[test]
fn measuring_ends_at_the_error_asked_for_or_at_the_most_samples() {
    let scene = corner();
    let meters = || {
        vec![
            grid(Vec2::ONE, Vec3::Y * 0.7, 0.5),
            facing(Vec3::Y, Vec3::new(0.4, 0.0, 0.2)),
        ]
    };
    for noise in [0.05, 0.01, 0.003] {
        let end = MeterEnd {
            noise,
            samples: 1 << 20,
            time: None,
        };
        for reading in measure(&scene, meters(), &end, 11) {
            let error = reading.grid.map_or(reading.points[0].relative_error(), |grid| {
                grid.least.relative_error().max(grid.mean.relative_error())
            });
            assert!(error <= noise, "{error} for {noise}");
            assert!(
                reading.samples >= 512 && reading.samples < 1 << 20,
                "{}",
                reading.samples
            );
        }
    }
    let samples: Vec<u32> = measure(&scene, meters(), &exactly(1000), 11)
        .iter()
        .map(|it| it.samples)
        .collect();
    assert_eq!(samples, [1024; 2]);
}

#[test]
fn meters_in_one_place_have_errors_of_their_own() {
    let meters = vec![facing(Vec3::Y, Vec3::new(0.3, 0.5, 0.2)); 8];
    let readings = measure(&corner(), meters, &exactly(1 << 10), 6);
    let values: Vec<f64> = readings.iter().map(|reading| reading.points[0].value).collect();
    assert!((1..8).all(|number| values[number] != values[0]), "{values:?}");
    // They scatter by their errors.
    let told = readings.iter().map(|reading| reading.points[0].error).sum::<f64>() / 8.0;
    let spread = Estimate::of(&values).error * 8f64.sqrt();
    assert!((0.4..2.2).contains(&(spread / told)), "{spread} for {told}");
}

#[test]
fn progress_never_goes_back() {
    let meters = vec![grid(Vec2::ONE, Vec3::Y * 0.7, 0.5), facing(Vec3::Y, Vec3::Y * 0.5)];
    let mut job = MeterJob::new(corner(), &settings(2), meters).expect("meters");
    let (mut shares, end) = (Vec::new(), MeterEnd::default());
    job.run(&end, &pool(2), &AtomicBool::new(false), &mut |_, done| {
        shares.push(done)
    });
    assert!(shares.is_sorted(), "{shares:?}");
    assert!(
        shares.len() > 3 && *shares.last().expect("a share") == 1.0,
        "{shares:?}"
    );
}

#[test]
fn a_cancelled_job_keeps_its_values() {
    let mut job = MeterJob::new(corner(), &settings(1), vec![grid(Vec2::ONE, Vec3::Y, 0.2)]).expect("a meter");
    assert_eq!(job.readings(), None);
    let cancel = AtomicBool::new(false);
    let mut looks = 0;
    let ending = job.run(&exactly(1 << 30), &pool(2), &cancel, &mut |job, done| {
        looks += 1;
        assert!((0.0..=1.0).contains(&done));
        if job.readings().is_some() {
            cancel.store(true, std::sync::atomic::Ordering::Relaxed);
        }
    });
    assert_eq!(ending, MeterEnding::Cancelled);
    assert!(looks > 1);
    let reading = &job.readings().expect("values")[0];
    assert!(reading.grid.expect("a grid").mean.value > 0.0);
}

#[test]
fn limits_are_judged_and_buried_meters_found() {
    let limits = |least, mean, uniformity| MeterLimits {
        least: Some(least),
        mean: Some(mean),
        uniformity: Some(uniformity),
    };
    let mut meters = vec![grid(Vec2::ONE, Vec3::Y * 0.7, 0.5); 2];
    meters[0].limits = limits(1.0, 2.0, 0.01);
    meters[1].limits = limits(1.0, 2.0, 0.99);
    meters.push(facing(Vec3::Y, Vec3::NEG_Y));
    let readings = measure(&corner(), meters, &MeterEnd::default(), 3);
    assert!(readings[0].passes());
    let judged: Vec<bool> = readings[1].judgements().iter().map(|it| it.passes()).collect();
    assert_eq!(judged, [true, true, false]);
    assert!(!readings[1].passes() && !readings[1].judgements()[2].is_close());
    assert!(readings[2].judgements().is_empty() && readings[2].passes());
    // Below the floor it meets the back of the floor.
    assert!(readings[2].is_buried && !readings[0].is_buried);
    let huge = vec![grid(Vec2::splat(1e4), Vec3::ZERO, 0.1)];
    assert!(matches!(
        MeterJob::new(corner(), &settings(1), huge),
        Err(MeterError::Sites { .. })
    ));
    let many = vec![grid(Vec2::ONE, Vec3::ZERO, 0.016); 5];
    let error = MeterJob::new(corner(), &settings(1), many)
        .err()
        .expect("too many points");
    assert!(matches!(error, MeterError::TooManyPoints(_)), "{error}");
}

/// The display mode shows in every pixel what a meter at the surface there measures.
#[test]
fn a_picture_of_illuminance_has_what_a_meter_measures() {
    let scene = corner();
    let view = View {
        shown: Shown::Illuminance,
        ..view(
            camera(Vec3::new(1.0, 1.5, 2.0), Vec3::new(0.5, 0.0, 0.3), 0.05),
            8,
            u32::MAX,
            Strategy::Mis,
        )
    };
    let (mean, error) = mean_luminance(&render(&scene, &view, 256));
    let place = facing(Vec3::Y, Vec3::new(0.5, 0.0, 0.3));
    let measured = measure(&scene, vec![place], &exactly(1 << 14), 12)[0].points[0];
    let both = (K * f64::from(error)).hypot(measured.error);
    let off = (K * f64::from(mean) - measured.value) / both;
    assert!(
        off.abs() < 3.0 && measured.value > 100.0,
        "{mean} {error} {measured:?}: {off}"
    );
}
