//! Ray queries on one thread, and builds: a generated mesh, and the shared models with their ray sets where those are present.

#[path = "../tests/accel_support/random.rs"]
mod random;
#[path = "../tests/accel_support/shared_data.rs"]
mod shared_data;
#[path = "../tests/accel_support/wavy_sphere.rs"]
mod wavy_sphere;

use std::hint::black_box;
use std::sync::Arc;
use std::time::Duration;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use random::Random;
use shared_data::{answered_rays, model};
use sunroom::accel::{Blas, SplitMethod};
use sunroom::geometry::mesh::MeshData;
use sunroom::math::Ray;
use wavy_sphere::wavy_sphere;

fn queries(criterion: &mut Criterion, name: &str, blas: &Blas, rays: &[Ray]) {
    let mut group = criterion.benchmark_group("rays");
    group
        .sample_size(10)
        .measurement_time(Duration::from_secs(2))
        .throughput(Throughput::Elements(rays.len() as u64));
    group.bench_with_input(BenchmarkId::new("closest", name), rays, |bencher, rays| {
        bencher.iter(|| {
            rays.iter()
                .filter(|ray| blas.intersect(black_box(ray)).is_some())
                .count()
        });
    });
    group.bench_with_input(BenchmarkId::new("any", name), rays, |bencher, rays| {
        bencher.iter(|| rays.iter().filter(|ray| blas.occluded(black_box(ray))).count());
    });
}

fn build(criterion: &mut Criterion, name: &str, mesh: &Arc<MeshData>) {
    let mut group = criterion.benchmark_group("build");
    group
        .sample_size(10)
        .measurement_time(Duration::from_secs(2))
        .throughput(Throughput::Elements(mesh.triangles.len() as u64));
    for (method, label) in [(SplitMethod::Sah, "sah"), (SplitMethod::Median, "median")] {
        group.bench_with_input(BenchmarkId::new(label, name), mesh, |bencher, mesh| {
            bencher.iter(|| Blas::build(mesh.clone(), method));
        });
    }
}

fn generated(criterion: &mut Criterion) {
    let mesh = Arc::new(wavy_sphere(200));
    let blas = Blas::build(mesh.clone(), SplitMethod::Sah);
    let mut random = Random::new(1);
    let incoherent: Vec<Ray> = (0..1 << 16)
        .map(|_| Ray::new(1.5 * random.in_cube(), random.direction()))
        .collect();
    queries(criterion, "wavy_sphere_random", &blas, &incoherent);
    build(criterion, "wavy_sphere", &mesh);
}

fn shared_models(criterion: &mut Criterion) {
    if let Some(mesh) = model("bunny.obj") {
        let blas = Blas::build(Arc::new(mesh), SplitMethod::Sah);
        for name in ["primary", "bounce"] {
            if let Some(answered) = answered_rays(&format!("rays_bunny_{name}_262144.bin")) {
                let rays: Vec<Ray> = answered.into_iter().map(|(ray, ..)| ray).collect();
                queries(criterion, &format!("bunny_{name}"), &blas, &rays);
            }
        }
    }
    if let Some(mesh) = model("dragon.ply") {
        build(criterion, "dragon", &Arc::new(mesh));
    }
}

criterion_group!(benches, generated, shared_models);
criterion_main!(benches);
