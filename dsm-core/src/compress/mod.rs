//! Compression: fewer vertices under an error bound (Lokovic & Veach 2000, §3.3 and
//! §5.2).

pub(crate) mod compressor;
mod extent;
pub(crate) mod greedy;
pub(crate) mod min_link;
pub(crate) mod paper_greedy;
pub(crate) mod quantization;
pub(crate) mod rounded;
mod short_path;
pub(crate) mod side;
mod slope_window;
mod tube;
