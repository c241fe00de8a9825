//! Plans of bakes that a farm's own scheduler runs: what is baked, in which parts, and where it
//! goes. `job` is the plan as a file, `files` the places of what its steps make, `found` what is
//! there of that, `parts` the files that a merge is given, `trial` the cost, `slurm` and
//! `openjd` the plan in the words of schedulers.

pub(crate) mod cost;
pub(crate) mod files;
pub(crate) mod found;
pub(crate) mod frames;
pub(crate) mod job;
pub(crate) mod openjd;
pub(crate) mod parts;
pub(crate) mod slurm;
pub(crate) mod sum;
pub(crate) mod trial;
