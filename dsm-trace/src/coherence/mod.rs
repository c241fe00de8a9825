//! Shadow rays that are traced only where the light's visibility can have changed
//! (Agrawala et al. 2000, §5.2).

pub(crate) mod blockers;
pub(crate) mod coherent_shadow;
pub(crate) mod light_cells;
mod order;
pub(crate) mod prediction;
#[cfg(test)]
mod properties;
pub(crate) mod settings;
pub(crate) mod statistics;
