//! Pictures of positions, whose shadow factors are a picture: `source` reads bands of rows,
//! `channels` says where positions are, `target` writes the factors.

mod channels;
pub(crate) mod source;
pub(crate) mod target;
