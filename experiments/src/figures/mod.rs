//! Figures 7, 8 and 9 of Lokovic & Veach 2000, measured on the built-in ball of
//! hair: what the program `paper-figures` writes into `docs/results`.

mod bakes;
mod figure7;
mod figure8;
mod figure9;
mod machine;
mod plot;
mod reference;
mod report;
mod sizes;
mod stage;
mod timing;

pub(crate) use machine::machine;
pub(crate) use plot::{Panel, svg};
pub(crate) use report::table;
pub(crate) use timing::seconds;

pub use self::{
    bakes::{Bakes, StoredMap},
    figure7::{Figure7, Figure7Row},
    figure8::{Figure8, Figure8Row, log_log_slope},
    figure9::{Figure9, Figure9Row},
    report::Report,
    stage::{Effort, Stage},
};
