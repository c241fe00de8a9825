//! Views that are packed as `EXT_meshopt_compression` and `KHR_meshopt_compression`
//! describe: Arseny Kapoulkine's codecs for vertices, triangles and indices.

mod attributes;
mod filters;
mod indices;

/// `packed` as `count` elements of `stride` bytes.
///
/// # Errors
///
/// A reason, if it is not packed in this way.
pub(super) fn decode(
    packed: &[u8],
    count: usize,
    stride: usize,
    mode: &str,
    filter: Option<&str>,
) -> Result<Vec<u8>, String> {
    let size = count.checked_mul(stride);
    // Zeros pack best: 64 of them into a byte.
    let most = packed.len().saturating_mul(128);
    if size.is_none_or(|size| size > most) {
        let bytes = packed.len();
        return Err(format!("{count} elements of {stride} bytes do not fit into {bytes} bytes"));
    }
    let mut bytes = match mode {
        "ATTRIBUTES" => attributes::decode(packed, count, stride),
        "TRIANGLES" => indices::triangles(packed, count).and_then(|all| cut(all, stride)),
        "INDICES" => indices::sequence(packed, count).and_then(|all| cut(all, stride)),
        _ => return Err(format!("meshopt mode {mode:.20} is not known")),
    }
    .ok_or_else(|| format!("damaged meshopt data, mode {mode}"))?;
    match filter {
        None | Some("NONE") => {}
        Some(filter) => {
            if !filters::apply(filter, &mut bytes, stride) {
                return Err(format!("meshopt filter {filter:.20} is not known for {stride} bytes"));
            }
        }
    }
    Ok(bytes)
}

/// Indices of `stride` bytes.
fn cut(indices: Vec<u32>, stride: usize) -> Option<Vec<u8>> {
    let mut bytes = Vec::with_capacity(indices.len() * stride);
    for index in indices {
        match stride {
            2 => bytes.extend(u16::try_from(index).ok()?.to_le_bytes()),
            4 => bytes.extend(index.to_le_bytes()),
            _ => return None,
        }
    }
    Some(bytes)
}
