//! The choice of one grid of a volume file.

use std::fmt;
use std::str::FromStr;

use super::header::GridHeader;
use crate::error::{Error, Place, Result};

/// The grid that is the density, among those of one file.
///
/// ```
/// use dsm_scene::detail::GridChoice;
///
/// let choice: GridChoice = "density:1".parse()?;
/// assert_eq!((choice.name(), choice.number()), ("density", Some(1)));
/// # Ok::<(), dsm_scene::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct GridChoice {
    name: String,
    number: Option<usize>,
}

impl GridChoice {
    /// The grid of this name, which only one has.
    #[must_use]
    pub fn named(name: impl Into<String>) -> Self {
        Self { name: name.into(), number: None }
    }

    /// The name.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The number among the grids of this name, from 0 in the file's order.
    #[must_use]
    pub fn number(&self) -> Option<usize> {
        self.number
    }
}

impl FromStr for GridChoice {
    type Err = Error;

    /// Reads `NAME` or `NAME:N`.
    fn from_str(text: &str) -> Result<Self> {
        let (name, number) = match text.rsplit_once(':') {
            Some((name, number)) if number.bytes().all(|byte| byte.is_ascii_digit()) => {
                (name, number.parse().ok())
            }
            _ => (text, None),
        };
        if name.is_empty() {
            let reason = "it is NAME or NAME:N, with N from 0";
            return Err(Error::malformed(Place::Named("grid".into()), reason));
        }
        Ok(Self { name: name.to_owned(), number })
    }
}

impl fmt::Display for GridChoice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.name)?;
        self.number.map_or(Ok(()), |number| write!(f, ":{number}"))
    }
}

/// The grid that was asked for; without a wish `density`, in whatever case, or the
/// only one there is.
pub(super) fn choose<'a>(
    grids: &'a [GridHeader],
    choice: Option<&GridChoice>,
) -> Result<&'a GridHeader> {
    let refuse = |reason: String| Err(Error::malformed(Place::Header, reason));
    let there = || list(grids);
    let Some(choice) = choice else {
        let named: Vec<_> =
            grids.iter().filter(|grid| grid.name().eq_ignore_ascii_case("density")).collect();
        return match (named.as_slice(), grids) {
            (&[only], _) | ([], [only]) => Ok(only),
            ([], []) => refuse("it has no grids".into()),
            ([], _) => refuse(format!("no grid is named density; the grids are: {}", there())),
            _ => refuse(format!("several grids are named density; choose one of: {}", there())),
        };
    };
    let mut named = grids.iter().filter(|grid| grid.name() == choice.name);
    let found = match choice.number {
        Some(number) => named.nth(number),
        None => match (named.next(), named.next()) {
            (Some(_), Some(_)) => {
                let reason =
                    format!("several grids are named {choice}; choose one of: {}", there());
                return refuse(reason);
            }
            (first, _) => first,
        },
    };
    match found {
        Some(grid) => Ok(grid),
        None => refuse(format!("no grid is {choice}; the grids are: {}", there())),
    }
}

/// The names by which each grid can be chosen.
fn list(grids: &[GridHeader]) -> String {
    let same =
        |name: &str, grids: &[GridHeader]| grids.iter().filter(|grid| grid.name() == name).count();
    let names = grids.iter().enumerate().map(|(index, grid)| match same(grid.name(), grids) {
        1 => grid.name().to_owned(),
        _ => format!("{}:{}", grid.name(), same(grid.name(), &grids[..index])),
    });
    names.collect::<Vec<_>>().join(", ")
}
