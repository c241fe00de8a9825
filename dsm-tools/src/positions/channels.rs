//! The channels of positions in a picture.

use anyhow::{Result, bail};
use exr::meta::header::Header;

/// Names of the three coordinates, the most telling first.
const NAMES: [[&str; 3]; 9] = [
    ["P.x", "P.y", "P.z"],
    ["P.X", "P.Y", "P.Z"],
    ["P.r", "P.g", "P.b"],
    ["P.R", "P.G", "P.B"],
    ["P.red", "P.green", "P.blue"],
    ["x", "y", "z"],
    ["X", "Y", "Z"],
    ["r", "g", "b"],
    ["R", "G", "B"],
];

/// The part of a picture that has positions, and where.
pub(super) fn position_part(headers: &[Header]) -> Result<(usize, [usize; 3])> {
    if headers.iter().all(|header| header.deep) && !headers.is_empty() {
        bail!("a deep image has no position a pixel: flatten it");
    }
    // The first names are the most telling in whichever part they are.
    let flat = || headers.iter().enumerate().filter(|(_, header)| !header.deep);
    let named = |names: &[&str; 3]| {
        flat().find_map(|(part, header)| {
            let channels = &header.channels.list;
            let index = |name: &str| channels.iter().position(|channel| channel.name.eq(name));
            Some((part, [index(names[0])?, index(names[1])?, index(names[2])?]))
        })
    };
    if let Some(found) = NAMES.iter().find_map(named) {
        return Ok(found);
    }
    let all = flat().flat_map(|(_, header)| &header.channels.list);
    let all: Vec<String> = all.take(16).map(|channel| channel.name.to_string()).collect();
    bail!("it has no channels P.x, P.y and P.z, or P.R, P.G and P.B, but {}", all.join(", "))
}
