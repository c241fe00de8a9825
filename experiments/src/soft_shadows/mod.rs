//! The experiments of Xie, Tabellion & Pearce 2007, §7, on scenes like theirs:
//! what the program `soft-shadows` writes into `docs`.

mod cost;
mod difference;
mod effort;
mod figure2;
mod figure4;
mod maps;
mod page;
mod stage;
mod study;
mod table1;
mod table2;
mod table3;

pub(crate) use maps::views;
pub(crate) use stage::Shadow;

pub use self::{
    cost::{Cost, RadiusCost, SizeCost},
    difference::Difference,
    effort::Effort,
    figure2::figure_2,
    figure4::{Figure4, Figure4Row},
    maps::{Map, Method},
    page::Page,
    stage::{Factors, Stage},
    study::{Lit, Shadowed, Study},
    table1::{Table1, Table1Row},
    table2::{Table2, Table2Row},
    table3::{MapCost, Table3, Table3Row},
};
