//! Reads PLY meshes: ASCII and binary of both byte orders.
//!
//! The reader takes of the vertices `x y z`, `nx ny nz` and one pair of `u v`, `s t`, `texture_u texture_v`; of the
//! faces the list `vertex_indices` (or `vertex_index`), polygons cut as in `polygon.rs`; `tristrips` as the Stanford
//! archive has them, with -1 between strips. Colours and other grouped values become attributes of the mesh, see
//! `ply_attributes.rs`; everything else is skipped. Without normals in the file, smooth ones are computed over shared
//! vertices, as Mitsuba does; single normals that are zero or not finite are computed likewise. The texture coordinates
//! stay as they are.
//!
//! Counts of the header are checked against the number of bytes in the file before anything is allocated or looped
//! over.

use glam::{Vec2, Vec3};
use rayon::prelude::*;

use super::attribute::AttributeDomain;
use super::mesh::{HIERARCHY_BYTES, MeshData};
use super::mesh_file::{LoadedMesh, MeshError, MeshMemory, Place, Warnings, complete_normals, replace_not_finite};
use super::ply_attributes::{Attributes, drop_attributes_beside_strips};
use super::ply_header::{Element, Format, Header, Kind, Scalar, parse_header};
use super::ply_records::Records;
use super::ply_source::{Ascii, Binary, Source};
use super::polygon::triangulate;

/// Reads a whole PLY file. Errors name the line, or the byte in a binary body.
pub fn load_ply(bytes: &[u8]) -> Result<LoadedMesh, MeshError> {
    let header = parse_header(bytes)?;
    let body = &bytes[header.length..];
    match header.format {
        Format::Ascii => read_body(&header, Ascii::new(body, header.lines + 1)),
        Format::LittleEndian => read_body(&header, Binary::<false>::new(body, header.length)),
        Format::BigEndian => read_body(&header, Binary::<true>::new(body, header.length)),
    }
}

fn read_body(header: &Header, mut source: impl Source) -> Result<LoadedMesh, MeshError> {
    let mut warnings = Warnings::default();
    let mut mesh = MeshData::default();
    let vertex_count = check_elements(header)?;
    let mut memory = MeshMemory::reserve(0, String::new)?;
    let mut fans = Vec::new();
    for element in &header.elements {
        let smallest = element.smallest_record(header.format);
        // The last number of a text needs no separator after it.
        if smallest.saturating_mul(element.count) > source.bytes_left() + 1 {
            return Err(MeshError::Truncated {
                place: Place::Line(element.line),
                promised: format!(
                    "{} elements `{}` are promised, and only {} bytes follow",
                    element.count,
                    element.name,
                    source.bytes_left()
                ),
            });
        }
        let needed = bytes_per_element(&element.name).saturating_mul(element.count);
        memory.add(needed, || format!("{} elements `{}`", element.count, element.name))?;
        match element.name.as_str() {
            "vertex" => read_vertices(element, &mut source, &mut mesh)?,
            "face" => {
                let warnings = &mut warnings;
                fans = read_faces(element, &mut source, vertex_count, &mut mesh, &mut memory, warnings)?;
            }
            "tristrips" => read_strips(element, &mut source, vertex_count, &mut mesh)?,
            _ if smallest == 0 => {}
            _ => {
                for _ in 0..element.count {
                    for property in &element.properties {
                        skip_property(property.kind, &mut source)?;
                    }
                }
            }
        }
    }
    if !source.rest().trim_ascii().is_empty() {
        warnings.add(source.next_place(), "what follows the promised elements is ignored");
    }
    if mesh.triangles.is_empty() {
        return Err(MeshError::NoTriangles);
    }
    cut_polygons(&fans, &mut mesh);
    drop_attributes_beside_strips(&mut mesh, &mut warnings);
    replace_not_finite(&mut mesh, &mut warnings);
    complete_normals(&mut mesh, &mut warnings);
    Ok(LoadedMesh {
        mesh: memory.hold(mesh)?,
        warnings: warnings.finish(),
    })
}

/// Memory of one element in bytes: of a vertex its position, normal and texture coordinates, of a face one triangle or
/// the first one of a fan.
fn bytes_per_element(name: &str) -> u64 {
    match name {
        "vertex" => 32,
        "face" => 12 + size_of::<Fan>() as u64 + HIERARCHY_BYTES,
        _ => 0,
    }
}

/// Checks that the needed elements exist once and have the needed properties; returns the number of vertices.
fn check_elements(header: &Header) -> Result<u64, MeshError> {
    let find = |name: &str| {
        let mut named = header.elements.iter().filter(|element| element.name == name);
        let first = named.next();
        match named.next() {
            Some(second) => Err(MeshError::syntax(
                Place::Line(second.line),
                format!("one element `{name}`"),
                "another",
            )),
            None => Ok(first),
        }
    };
    let vertices = find("vertex")?.ok_or(MeshError::NoTriangles)?;
    for name in ["x", "y", "z"] {
        let is_scalar = |p: &&super::ply_header::Property| p.name == name && matches!(p.kind, Kind::Scalar(_));
        if vertices.properties.iter().filter(is_scalar).count() != 1 {
            let expected = format!("one scalar property `{name}` of the vertices");
            return Err(MeshError::syntax(
                Place::Line(vertices.line),
                expected,
                "none or several",
            ));
        }
    }
    if vertices.count > u64::from(u32::MAX) {
        return Err(MeshError::TooLarge {
            what: "the number of vertices",
            limit: u32::MAX.into(),
        });
    }
    for name in ["face", "tristrips"] {
        if let Some(element) = find(name)?
            && element.count > 0
            && element
                .properties
                .iter()
                .filter(|p| is_index_list(&p.name, p.kind))
                .count()
                != 1
        {
            let expected = format!("one property list `vertex_indices` of `{name}`");
            return Err(MeshError::syntax(
                Place::Line(element.line),
                expected,
                "none or several",
            ));
        }
    }
    Ok(vertices.count)
}

fn is_index_list(name: &str, kind: Kind) -> bool {
    matches!(kind, Kind::List { .. }) && matches!(name, "vertex_indices" | "vertex_index")
}

fn skip_property(kind: Kind, source: &mut impl Source) -> Result<(), MeshError> {
    match kind {
        Kind::Scalar(scalar) => source.skip(1, scalar),
        Kind::List { count, item } => {
            let length = list_length(count, source)?;
            source.skip(length, item)
        }
    }
}

fn list_length(count: Scalar, source: &mut impl Source) -> Result<u64, MeshError> {
    let length = source.number(count)?;
    if length as u64 as f64 == length {
        Ok(length as u64)
    } else {
        Err(MeshError::syntax(
            source.place(),
            "the length of a list",
            format!("`{length}`"),
        ))
    }
}

/// The properties of a vertex that are geometry, in this order. One more slot takes the properties that are skipped,
/// and attributes follow.
const SLOTS: [&[&str]; 8] = [
    &["x"],
    &["y"],
    &["z"],
    &["nx"],
    &["ny"],
    &["nz"],
    &["u", "s", "texture_u"],
    &["v", "t", "texture_v"],
];
const UNUSED: usize = SLOTS.len();
const FIRST_ATTRIBUTE: usize = UNUSED + 1;

fn read_vertices(element: &Element, source: &mut impl Source, mesh: &mut MeshData) -> Result<(), MeshError> {
    let uv_names = [["u", "v"], ["s", "t"], ["texture_u", "texture_v"]]
        .into_iter()
        .find(|pair| pair.iter().all(|name| element.has(name)));
    let has_normals = ["nx", "ny", "nz"].iter().all(|name| element.has(name));
    let slot_of = |name: &str| {
        let slot = SLOTS.iter().position(|names| names.contains(&name)).unwrap_or(UNUSED);
        let is_wanted = slot < 6 || uv_names.is_some_and(|pair| pair.contains(&name));
        if is_wanted { slot } else { UNUSED }
    };
    let count = element.count as usize;
    let is_geometry = |name: &str| slot_of(name) != UNUSED;
    let mut attributes = Attributes::new(element, AttributeDomain::Vertex, is_geometry, count);
    let plan: Vec<(Kind, usize)> = element
        .properties
        .iter()
        .enumerate()
        .map(|(i, property)| {
            let slot = attributes.place_of(i).map(|place| FIRST_ATTRIBUTE + place);
            (property.kind, slot.unwrap_or_else(|| slot_of(&property.name)))
        })
        .collect();
    if vertices_abreast(element, source, &plan, mesh, &mut attributes) {
        mesh.attributes.extend(attributes.finish());
        return Ok(());
    }
    mesh.positions.reserve_exact(count);
    mesh.normals.reserve_exact(if has_normals { count } else { 0 });
    mesh.uvs.reserve_exact(if uv_names.is_some() { count } else { 0 });
    for _ in 0..count {
        let mut record = [0.0f32; UNUSED + 1];
        for &(kind, slot) in &plan {
            match kind {
                Kind::Scalar(scalar) if slot >= FIRST_ATTRIBUTE => {
                    attributes.set(slot - FIRST_ATTRIBUTE, source.number(scalar)?);
                }
                Kind::Scalar(scalar) => {
                    record[slot] = source.number(scalar)? as f32;
                    if slot < 3 && !record[slot].is_finite() {
                        return Err(MeshError::NotFinite { place: source.place() });
                    }
                }
                Kind::List { .. } => skip_property(kind, source)?,
            }
        }
        let [x, y, z, nx, ny, nz, u, v, _] = record;
        mesh.positions.push(Vec3::new(x, y, z));
        if has_normals {
            mesh.normals.push(Vec3::new(nx, ny, nz));
        }
        if uv_names.is_some() {
            mesh.uvs.push(Vec2::new(u, v));
        }
        attributes.push(1);
    }
    mesh.attributes.extend(attributes.finish());
    Ok(())
}

/// Reads the vertices on all threads, unless there is a list or an irregular value among them; then it reads nothing.
fn vertices_abreast(
    element: &Element,
    source: &mut impl Source,
    plan: &[(Kind, usize)],
    mesh: &mut MeshData,
    attributes: &mut Attributes,
) -> bool {
    let Some(records) = source.binary().and_then(|body| Records::new(element, None, body)) else {
        return false;
    };
    let column = |wanted: usize| {
        let column = |(property, &(kind, slot)): (usize, &(Kind, usize))| match kind {
            Kind::Scalar(scalar) if slot == wanted => Some((property, scalar)),
            _ => None,
        };
        plan.iter().enumerate().rev().find_map(column)
    };
    let columns = |first: usize| [0, 1, 2].map(|i| column(first + i));
    let [Some(x), Some(y), Some(z)] = columns(0) else {
        return false;
    };
    let positions: Vec<Vec3> = records.vectors([x, y, z]);
    if !positions.par_iter().all(|position| position.is_finite()) {
        return false;
    }
    mesh.positions = positions;
    if let [Some(x), Some(y), Some(z)] = columns(3) {
        mesh.normals = records.vectors([x, y, z]);
    }
    if let [Some(u), Some(v)] = [6, 7].map(column) {
        mesh.uvs = records.vectors([u, v]);
    }
    attributes.read(&records);
    let bytes = records.bytes().len();
    source.skip(bytes as u64, Scalar::U8).is_ok()
}

fn vertex_index(item: Scalar, source: &mut impl Source, vertex_count: u64) -> Result<u32, MeshError> {
    let index = source.number(item)?;
    checked_index(index, source, vertex_count)
}

fn checked_index(index: f64, source: &impl Source, vertex_count: u64) -> Result<u32, MeshError> {
    // Negative or broken numbers fail this test.
    if index as u32 as f64 == index && index < vertex_count as f64 {
        Ok(index as u32)
    } else {
        Err(MeshError::IndexOutOfRange {
            place: source.place(),
            what: "vertex",
            index: index as i64,
            count: vertex_count,
        })
    }
}

/// The fan of a polygon of more than three corners: the triangles of the mesh from `first` on.
struct Fan {
    first: usize,
    triangles: usize,
}

/// Reads the faces, polygons as fans around their first corner. Returns the fans.
fn read_faces(
    element: &Element,
    source: &mut impl Source,
    vertex_count: u64,
    mesh: &mut MeshData,
    memory: &mut MeshMemory,
    warnings: &mut Warnings,
) -> Result<Vec<Fan>, MeshError> {
    let faces = element.count as usize;
    let mut attributes = Attributes::new(element, AttributeDomain::Triangle, |_| false, faces);
    if let Some(mut triangles) = triangles_abreast(element, source, vertex_count, &mut attributes) {
        if mesh.triangles.is_empty() {
            mesh.triangles = triangles;
        } else {
            mesh.triangles.append(&mut triangles);
        }
        mesh.attributes.extend(attributes.finish());
        return Ok(Vec::new());
    }
    mesh.triangles.reserve(faces);
    let mut fans = Vec::new();
    for _ in 0..faces {
        let before = mesh.triangles.len();
        for (i, property) in element.properties.iter().enumerate() {
            let Kind::List { count, item } = property.kind else {
                match (attributes.place_of(i), property.kind) {
                    (Some(place), Kind::Scalar(scalar)) => attributes.set(place, source.number(scalar)?),
                    _ => skip_property(property.kind, source)?,
                }
                continue;
            };
            if !is_index_list(&property.name, property.kind) {
                skip_property(property.kind, source)?;
                continue;
            }
            let corners = list_length(count, source)?;
            if corners < 3 {
                warnings.add(source.place(), "a face with fewer than three corners is skipped");
                source.skip(corners, item)?;
                continue;
            }
            if corners > 3 {
                fans.push(Fan {
                    first: mesh.triangles.len(),
                    triangles: corners as usize - 2,
                });
            }
            if add_fan(source, item, corners, vertex_count, &mut mesh.triangles) {
                source.skip(corners, item)?;
                continue;
            }
            let first = vertex_index(item, source, vertex_count)?;
            let mut last = vertex_index(item, source, vertex_count)?;
            for _ in 2..corners {
                let next = vertex_index(item, source, vertex_count)?;
                mesh.triangles.push([first, last, next]);
                last = next;
            }
        }
        let triangles = mesh.triangles.len() - before;
        // The values of a polygon are repeated, so that they may take far more memory than in the file.
        let repeated = attributes.bytes_per_record() * (triangles as u64).saturating_sub(1);
        if repeated > 0 {
            memory.add(repeated, || format!("the attributes of {triangles} triangles"))?;
        }
        attributes.push(triangles);
    }
    mesh.attributes.extend(attributes.finish());
    Ok(fans)
}

/// Triangulates polygons again where a fan is wrong. The vertices may come after the faces in the file, so this is done
/// last.
fn cut_polygons(fans: &[Fan], mesh: &mut MeshData) {
    let cut = |fan: &Fan| {
        let triangles = &mesh.triangles[fan.first..][..fan.triangles];
        let [first, second, _] = triangles[0];
        let corners: Vec<u32> = [first, second]
            .into_iter()
            .chain(triangles.iter().map(|t| t[2]))
            .collect();
        let outline: Vec<Vec3> = corners.iter().map(|&corner| mesh.positions[corner as usize]).collect();
        let mut cut = Vec::with_capacity(fan.triangles);
        triangulate(&outline, |triangle| cut.push(triangle.map(|i| corners[i])));
        (cut != triangles).then_some((fan.first, cut))
    };
    let cut: Vec<(usize, Vec<[u32; 3]>)> = fans.par_iter().filter_map(cut).collect();
    for (first, triangles) in cut {
        mesh.triangles[first..][..triangles.len()].copy_from_slice(&triangles);
    }
}

/// Adds the fan of the next list of indices, of at least three, if the body is binary and the list is valid; the source
/// is not advanced.
#[inline]
fn add_fan(source: &impl Source, item: Scalar, corners: u64, vertex_count: u64, triangles: &mut Vec<[u32; 3]>) -> bool {
    let Some(numbers) = source.binary().filter(|_| matches!(item, Scalar::I32 | Scalar::U32)) else {
        return false;
    };
    let words = usize::try_from(corners)
        .ok()
        .and_then(|corners| numbers.bytes.as_chunks::<4>().0.get(..corners));
    let Some([first, second, others @ ..]) = words else {
        return false;
    };
    let before = triangles.len();
    let (first, mut last) = (numbers.word(*first), numbers.word(*second));
    let mut largest = first.max(last);
    for next in others {
        let next = numbers.word(*next);
        triangles.push([first, last, next]);
        largest = largest.max(next);
        last = next;
    }
    // Negative indices wrap to large ones here, which the limit below 2^31 vertices rejects.
    let is_good = u64::from(largest) < vertex_count.min(1 << 31);
    if !is_good {
        triangles.truncate(before);
    }
    is_good
}

/// Reads the faces on all threads if all are valid triangles; otherwise it reads nothing.
fn triangles_abreast(
    element: &Element,
    source: &mut impl Source,
    vertex_count: u64,
    attributes: &mut Attributes,
) -> Option<Vec<[u32; 3]>> {
    let mut lists = element
        .properties
        .iter()
        .enumerate()
        .filter(|(_, p)| matches!(p.kind, Kind::List { .. }));
    let (Some((list, property)), None) = (lists.next(), lists.next()) else {
        return None;
    };
    let Kind::List { count, item } = property.kind else {
        return None;
    };
    let body = source
        .binary()
        .filter(|_| is_index_list(&property.name, property.kind))?;
    let records = Records::new(element, Some(3), body)?;
    let triangles = records.triangles(list, count, item, vertex_count)?;
    attributes.read(&records);
    let bytes = records.bytes().len();
    source.skip(bytes as u64, Scalar::U8).ok()?;
    Some(triangles)
}

fn read_strips(
    element: &Element,
    source: &mut impl Source,
    vertex_count: u64,
    mesh: &mut MeshData,
) -> Result<(), MeshError> {
    for _ in 0..element.count {
        for property in &element.properties {
            let Kind::List { count, item } = property.kind else {
                skip_property(property.kind, source)?;
                continue;
            };
            if !is_index_list(&property.name, property.kind) {
                skip_property(property.kind, source)?;
                continue;
            }
            // The last two corners of the strip, and whether the next triangle has the opposite winding.
            let (mut before, mut last, mut turned) = (None, None, false);
            for _ in 0..list_length(count, source)? {
                let index = source.number(item)?;
                if index == -1.0 {
                    (before, last, turned) = (None, None, false);
                    continue;
                }
                let next = checked_index(index, source, vertex_count)?;
                if let (Some(a), Some(b)) = (before, last) {
                    // Strips repeat a vertex to change direction; these degenerate triangles are dropped.
                    if a != b && b != next && a != next {
                        mesh.triangles.push(if turned { [b, a, next] } else { [a, b, next] });
                    }
                    turned = !turned;
                }
                (before, last) = (last, Some(next));
            }
        }
    }
    Ok(())
}
