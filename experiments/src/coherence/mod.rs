//! The second half of figure 10 of Agrawala, Ramamoorthi, Heirich & Moll 2000, and what
//! their coherent sampling saves over other tracers: what the program `coherence` writes
//! into `docs`.

mod errors;
mod measured;
mod page;
mod strips;

pub use self::{page::Effort, page::page};
