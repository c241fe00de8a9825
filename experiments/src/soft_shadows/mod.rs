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

pub use cost::{Cost, RadiusCost, SizeCost};
pub use difference::Difference;
pub use effort::Effort;
pub use figure2::figure_2;
pub use figure4::{Figure4, Figure4Row};
pub use maps::{Map, Method};
pub use page::Page;
pub use stage::{Factors, Stage};
pub use study::{Lit, Shadowed, Study};
pub use table1::{Table1, Table1Row};
pub use table2::{Table2, Table2Row};
pub use table3::{MapCost, Table3, Table3Row};
