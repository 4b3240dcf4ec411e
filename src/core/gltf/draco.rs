//! Unpacks primitives of KHR_draco_mesh_compression, with the decoder of the crate `draco-core`.
//!
//! The values of each attribute and the indices become buffer views, to which the accessors of the primitive are
//! directed.

use std::collections::{BTreeMap, HashMap};

use draco_core::{DataType, DecodeLimits, DecoderBuffer, Mesh, MeshDecoder, PointIndex};

use super::guard::guarded;
use super::schema::{Accessor, DracoPrimitive, Primitive, Root};
use super::store::Store;

/// Bytes of memory that the decoder takes for each corner of a triangle, beside the values.
const CORNER_BYTES: u64 = 64;

/// The component types of accessors that a decoded attribute may have.
fn component_type(data: DataType) -> Option<u32> {
    Some(match data {
        DataType::Int8 => 5120,
        DataType::Uint8 => 5121,
        DataType::Int16 => 5122,
        DataType::Uint16 => 5123,
        DataType::Uint32 => 5125,
        DataType::Float32 => 5126,
        _ => return None,
    })
}

/// Unpacks all compressed primitives. Those that cannot be unpacked keep the reason.
pub(super) fn unpack(root: &mut Root, store: &mut Store) {
    let mut known: HashMap<usize, Result<Mesh, String>> = HashMap::new();
    let mut meshes = std::mem::take(&mut root.meshes);
    for primitive in meshes.iter_mut().flat_map(|mesh| &mut mesh.primitives) {
        let Some(draco) = primitive.extensions.draco.take() else {
            continue;
        };
        let mesh = known
            .entry(draco.buffer_view)
            .or_insert_with(|| decode(root, primitive, &draco, store));
        let result = mesh.as_ref().map_err(String::clone);
        if let Err(fault) = result.and_then(|mesh| direct(root, primitive, &draco, mesh, store))
            && !has_plain_values(root, primitive)
        {
            primitive.fault = Some(format!("cannot be unpacked: its Draco stream {fault}"));
        }
    }
    root.meshes = meshes;
}

/// Whether a primitive has its values uncompressed as well.
fn has_plain_values(root: &Root, primitive: &Primitive) -> bool {
    let accessors = primitive.attributes.values().chain(&primitive.indices);
    let mut accessors = accessors.map(|&index| root.accessors.get(index));
    accessors.all(|accessor| accessor.is_some_and(|accessor| accessor.buffer_view.is_some()))
}

fn decode(root: &Root, primitive: &Primitive, draco: &DracoPrimitive, store: &mut Store) -> Result<Mesh, String> {
    let view = root.buffer_views.get(draco.buffer_view).ok_or("is not there")?;
    let count = |index: Option<usize>| Some(root.accessors.get(index?)?.count as u64);
    let vertices = count(primitive.attributes.get("POSITION").copied()).ok_or("has no positions")?;
    let corners = count(primitive.indices).ok_or("has no indices")?;
    // A short stream may stand for very many equal values: the accessors say how many there are.
    let bytes = vertices.saturating_mul(16 * draco.attributes.len() as u64);
    store.reserve(bytes.saturating_add(corners.saturating_mul(CORNER_BYTES)))?;
    let stream = store.read(view.buffer, view.byte_offset, view.byte_length)?;
    let limits = DecodeLimits::default()
        .with_max_points(vertices)
        .with_max_faces(corners / 3)
        .with_max_decoded_bytes(bytes);
    let decode = || {
        let mut mesh = Mesh::new();
        let mut buffer = DecoderBuffer::new(stream).with_limits(limits);
        MeshDecoder::new().decode(&mut buffer, &mut mesh).map(|()| mesh)
    };
    let mesh = guarded(decode).ok_or("is damaged")?;
    mesh.map_err(|error| format!("is damaged: {error}"))
}

/// Directs the accessors of a primitive to the decoded values.
fn direct(
    root: &mut Root,
    primitive: &mut Primitive,
    draco: &DracoPrimitive,
    mesh: &Mesh,
    store: &mut Store,
) -> Result<(), String> {
    // Any number of primitives may share a stream, and each has values of its own.
    store.reserve(value_bytes(draco, mesh))?;
    let mut views = BTreeMap::new();
    for (name, &id) in &draco.attributes {
        let Some(&index) = primitive.attributes.get(name) else {
            continue;
        };
        let accessor = root.accessors.get(index).ok_or("has an attribute without accessor")?;
        views.insert(index, values(name, id, accessor, mesh)?);
    }
    let corners: Vec<u8> = mesh
        .faces()
        .iter()
        .flat_map(|face| face.iter().flat_map(|corner| corner.0.to_le_bytes()))
        .collect();
    if let Some(index) = primitive.indices {
        let accessor = root.accessors.get_mut(index).ok_or("has indices without accessor")?;
        if corners.len() != 4usize.saturating_mul(accessor.count) {
            let (held, count) = (mesh.num_faces(), accessor.count);
            return Err(format!("has {held} triangles where {count} indices are promised"));
        }
        accessor.component_type = 5125;
        views.insert(index, corners);
    }
    for (index, bytes) in views {
        let view = store.add(bytes);
        root.buffer_views.push(view);
        if let Some(accessor) = root.accessors.get_mut(index) {
            (accessor.buffer_view, accessor.byte_offset) = (Some(root.buffer_views.len() - 1), 0);
        }
    }
    Ok(())
}

/// The bytes of all values and indices that [`direct`] makes for a primitive.
fn value_bytes(draco: &DracoPrimitive, mesh: &Mesh) -> u64 {
    let attributes = draco.attributes.values();
    let vertex: u64 = attributes
        .filter_map(|&id| mesh.attribute_by_unique_id(id))
        .map(|attribute| u64::from(attribute.num_components()) * attribute.data_type().byte_length() as u64)
        .sum();
    let vertices = (mesh.num_points() as u64).saturating_mul(vertex);
    vertices.saturating_add(12 * mesh.num_faces() as u64)
}

/// The values of an attribute, one for each vertex.
fn values(name: &str, id: u32, accessor: &Accessor, mesh: &Mesh) -> Result<Vec<u8>, String> {
    let attribute = mesh
        .attribute_by_unique_id(id)
        .ok_or_else(|| format!("has no attribute {id} for {name}"))?;
    let count = mesh.num_points();
    if count != accessor.count {
        return Err(format!("has {count} vertices where {} are promised", accessor.count));
    }
    let components = usize::from(attribute.num_components());
    let fits = component_type(attribute.data_type()) == Some(accessor.component_type)
        && accessor.components() == Some(components);
    if !fits {
        return Err(format!("has values of another type than the accessor of {name}"));
    }
    let size = components * attribute.data_type().byte_length();
    let stride = usize::try_from(attribute.byte_stride()).unwrap_or(0);
    let data = attribute.buffer().data();
    let mut bytes = Vec::with_capacity(count * size);
    for point in (0..).take(count) {
        let place = (attribute.mapped_index(PointIndex(point)).0 as usize).checked_mul(stride);
        let value = place.and_then(|place| data.get(place..place.checked_add(size)?));
        bytes.extend_from_slice(value.ok_or_else(|| format!("has too few values of {name}"))?);
    }
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gltf::store::COPIES;
    use crate::memory;

    /// A square with coordinates of 16 bits, of the encoder of Draco 1.5.7.
    const SQUARE: &str = "445241434f02020100000002040100010200020301020009030000030402000102010001010003030130011003\
        003482880400000000ff0000000001010003030130011003003482a40000000000ffff00000000000000000000\
        000000000000803f08";

    /// The bytes that are reserved, and those of the unpacked buffers, for primitives that share a stream.
    fn unpacked(primitives: usize) -> (u64, u64) {
        let pair = |at: usize| u8::from_str_radix(&SQUARE[at..at + 2], 16).expect("digits");
        let stream: Vec<u8> = (0..SQUARE.len()).step_by(2).map(pair).collect();
        let primitive = r#"{"attributes": {"POSITION": 0}, "indices": 1,
            "extensions": {"KHR_draco_mesh_compression": {"bufferView": 0, "attributes": {"POSITION": 0}}}}"#;
        let text = format!(
            r#"{{"asset": {{"version": "2.0"}}, "buffers": [{{"byteLength": {length}}}],
                "bufferViews": [{{"buffer": 0, "byteLength": {length}}}],
                "accessors": [{{"componentType": 5126, "type": "VEC3", "count": 4}},
                              {{"componentType": 5123, "type": "SCALAR", "count": 6}}],
                "meshes": [{{"primitives": [{}]}}]}}"#,
            vec![primitive; primitives].join(","),
            length = stream.len(),
        );
        let mut root: Root = serde_json::from_str(&text).expect("a file");
        let mut store = Store::new(vec![stream], 0, memory::reserve(0).expect("nothing"));
        unpack(&mut root, &mut store);
        let faults = root.meshes[0]
            .primitives
            .iter()
            .filter_map(|primitive| primitive.fault.as_ref());
        assert_eq!(faults.count(), 0);
        let made = store.buffers[1..].iter().map(|buffer| buffer.len() as u64).sum();
        (store.needed, made)
    }

    #[test]
    fn memory_is_reserved_for_each_primitive_of_a_shared_stream() {
        let ((one, bytes), (many, all)) = (unpacked(1), unpacked(100));
        assert_eq!((bytes, all), (4 * 12 + 6 * 4, 100 * bytes));
        assert_eq!(many - one, 99 * COPIES * bytes);
    }
}
