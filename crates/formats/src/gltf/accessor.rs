//! Numbers out of a glTF buffer, every offset checked before it is used.

use super::buffer::Buffers;
use super::error::GltfError;
use gltf::accessor::{DataType, Dimensions};
use nalgebra::Vector3;

/// Three finite floats an element.
pub(super) fn vectors(
    buffers: &Buffers,
    name: &str,
    accessor: &gltf::Accessor,
) -> Result<Vec<Vector3<f64>>, GltfError> {
    let error = |found: String, expected| GltfError::mesh(name, found, expected);
    if accessor.data_type() != DataType::F32 || accessor.dimensions() != Dimensions::Vec3 {
        let found = format!("{:?} {:?}", accessor.dimensions(), accessor.data_type());
        return Err(error(found, "Vec3 F32"));
    }
    elements(buffers, name, accessor)?
        .map(|bytes| {
            let component = |k: usize| {
                let four = [bytes[4 * k], bytes[4 * k + 1], bytes[4 * k + 2], bytes[4 * k + 3]];
                f64::from(f32::from_le_bytes(four))
            };
            let vector = Vector3::new(component(0), component(1), component(2));
            if vector.iter().all(|v| v.is_finite()) {
                Ok(vector)
            } else {
                let found = format!("({}, {}, {})", vector.x, vector.y, vector.z);
                Err(error(found, "finite numbers"))
            }
        })
        .collect()
}

/// Indices three by three, each of an existing vertex.
pub(super) fn triangles(
    buffers: &Buffers,
    name: &str,
    accessor: &gltf::Accessor,
    vertices: usize,
) -> Result<Vec<[u32; 3]>, GltfError> {
    let error = |found: String, expected| GltfError::mesh(name, found, expected);
    let data_type = accessor.data_type();
    let is_index = matches!(data_type, DataType::U8 | DataType::U16 | DataType::U32);
    if !is_index || accessor.dimensions() != Dimensions::Scalar {
        let found = format!("{data_type:?} indices");
        return Err(error(found, "unsigned integers"));
    }
    if !accessor.count().is_multiple_of(3) {
        let found = format!("{} indices", accessor.count());
        return Err(error(found, "a multiple of three"));
    }
    let indices = elements(buffers, name, accessor)?
        .map(|bytes| {
            // Little-endian of one, two or four bytes.
            let index = bytes.iter().rev().fold(0, |n, &b| n << 8 | u32::from(b));
            if (index as usize) < vertices {
                Ok(index)
            } else {
                let found = format!("index {index} of {vertices} positions");
                Err(error(found, "one of them"))
            }
        })
        .collect::<Result<Vec<u32>, _>>()?;
    Ok(indices.chunks_exact(3).map(|t| [t[0], t[1], t[2]]).collect())
}

/// The bytes of each element of an accessor, all of them in the file.
fn elements<'a>(
    buffers: &'a Buffers,
    name: &str,
    accessor: &gltf::Accessor,
) -> Result<impl Iterator<Item = &'a [u8]> + use<'a>, GltfError> {
    let error = |found: &str, expected| GltfError::mesh(name, found, expected);
    let view = accessor
        .view()
        .filter(|_| accessor.sparse().is_none())
        .ok_or_else(|| error("sparse data", "plain buffer views"))?;
    let buffer = buffers.bytes(view.buffer().index())?;
    let size = accessor.size();
    let stride = view.stride().unwrap_or(size);
    let count = accessor.count();
    let cut_short = || error("data beyond the end of its buffer", "all of it in the file");
    let data = view
        .offset()
        .checked_add(view.length())
        .and_then(|end| buffer.get(view.offset()..end))
        .and_then(|data| data.get(accessor.offset()..))
        .ok_or_else(cut_short)?;
    if stride < size || size == 0 {
        return Err(error("elements that overlap", "a stride of at least their size"));
    }
    let needed = match count.checked_sub(1) {
        None => Some(0),
        Some(last) => last.checked_mul(stride).and_then(|n| n.checked_add(size)),
    };
    if needed.is_none_or(|needed| needed > data.len()) {
        return Err(cut_short());
    }
    Ok((0..count).map(move |i| &data[i * stride..i * stride + size]))
}
