//! Fewer vertices under a bound (Lokovic & Veach 2000, §3.3).

pub(crate) mod tolerance;
