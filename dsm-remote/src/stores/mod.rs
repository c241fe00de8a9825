//! Files in object stores, through crate `object_store`.
//!
//! `connect` makes clients, `runtime` runs their requests, `request` brings one range
//! whatever happens, `read_ahead` decides what to ask for, `disk_cache` keeps it, and
//! `file` puts them together.

mod block;
pub(crate) mod connect;
mod disk_cache;
pub(crate) mod file;
mod read_ahead;
mod request;
mod runtime;
pub(crate) mod upload;
mod version;

#[cfg(test)]
mod counting_store;
#[cfg(test)]
mod tests;
