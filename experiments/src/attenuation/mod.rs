//! The first half of figure 10 of Agrawala, Ramamoorthi, Heirich & Moll 2000, layered
//! attenuation maps beside rays, and rays through several depth images: what the program
//! `attenuation` writes into `docs`.

mod accelerations;
mod cause;
mod lookups;
mod page;
pub(crate) mod peers;
mod precompute;
pub(crate) mod scenes;
pub(crate) mod strips;
pub(crate) mod trial;

pub use self::{page::Effort, page::page};
