//! Files whose content would take far more memory or time than their size promises: products of two counts, and what is named many times.

use crate::mesh_support::assert_sound;
use sunroom::geometry::mesh_file::MeshError;
use sunroom::geometry::ply::load_ply;

#[test]
fn values_of_a_face_count_in_the_budget_for_each_of_its_triangles() {
    // A polygon of four million corners with forty thousand values: 640 GB from 5 MB.
    const CORNERS: usize = 4_000_000;
    const VALUES: usize = 40_000;
    let mut file =
        b"ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty char x\nproperty char y\nproperty char z\n\
        element face 1\nproperty list uint uchar vertex_indices\n"
            .to_vec();
    for i in 0..VALUES {
        file.extend(format!("property char a{i}_x\n").bytes());
    }
    file.extend(b"end_header\n\0\0\0\x01\0\0\0\x01\0");
    file.extend((CORNERS as u32).to_le_bytes());
    file.extend([0, 1, 2].into_iter().cycle().take(CORNERS));
    file.extend([0; VALUES]);
    match load_ply(&file) {
        Err(MeshError::Memory { what, shortage }) => {
            assert_eq!(what, format!("the attributes of {} triangles", CORNERS - 2));
            assert!(shortage.asked >= 4 * (VALUES * (CORNERS - 3)) as u64, "{shortage}");
        }
        other => panic!("{:?}", other.map(|loaded| loaded.warnings)),
    }
}

#[test]
fn strips_beside_faces_leave_the_values_of_faces_out() {
    let file = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nproperty float p_x\n\
        element tristrips 1\nproperty list int int vertex_indices\n\
        element face 1\nproperty list uchar int vertex_indices\nproperty float q_x\nend_header\n\
        0 0 0 1\n1 0 0 2\n0 1 0 3\n3 0 1 2\n3 0 1 2 0.5\n";
    let loaded = load_ply(file.as_bytes()).expect("loads");
    assert_sound(&loaded.mesh);
    assert_eq!(loaded.mesh.triangles.len(), 2);
    let names: Vec<&str> = loaded
        .mesh
        .attributes
        .iter()
        .map(|attribute| attribute.name.as_str())
        .collect();
    assert_eq!(names, ["vertex_p"]);
    assert_eq!(
        loaded.warnings,
        ["attribute `face_q`: is ignored, because triangles of strips have no values"]
    );
    // Strips without triangles take nothing away.
    let file = file.replace("3 0 1 2\n3", "1 0\n3");
    let loaded = load_ply(file.as_bytes()).expect("loads");
    assert_eq!(loaded.mesh.attributes.len(), 2);
    assert_eq!(loaded.warnings, [""; 0]);
}
