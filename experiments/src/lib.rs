//! The papers' experiments, measured again: figures, tables and pictures, which
//! the programs in `src/bin` write into `docs/results`.

pub mod arguments;
pub mod attenuation;
pub mod coherence;
pub mod compression;
pub mod figures;
pub mod pictures;
pub mod prefilter;
pub mod soft_shadows;
