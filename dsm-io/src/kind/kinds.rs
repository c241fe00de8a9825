//! The kinds of maps that a program knows.

use std::path::Path;

use super::deep::Deep;
use super::erased_map::ErasedMap;
use super::map_kind::MapKind;
use super::reader::KindReader;
use crate::error::{Error, Result};
use crate::format::container::Container;
use crate::limits::Limits;

/// The kinds of maps that a program knows, by name.
///
/// ```no_run
/// use dsm_io::detail::Kinds;
/// use dsm_io::Limits;
///
/// // Deep maps alone; other crates have more to register.
/// let kinds = Kinds::default();
/// let map = kinds.open("shadow.dsm", &Limits::default())?;
/// println!("{}: {:?}", map.kind(), map.summary()?);
/// # Ok::<(), dsm_io::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct Kinds {
    kinds: Vec<Kind>,
}

#[derive(Clone, Copy, Debug)]
struct Kind {
    name: &'static str,
    open: fn(Container, &Limits) -> Result<Box<dyn ErasedMap>>,
}

impl Default for Kinds {
    /// Deep maps.
    fn default() -> Self {
        Self { kinds: Vec::new() }.with::<Deep>()
    }
}

impl Kinds {
    /// Registers `K`, in place of a kind of the same name.
    #[must_use]
    pub fn with<K: MapKind>(mut self) -> Self {
        self.kinds.retain(|kind| kind.name != K::NAME);
        self.kinds.push(Kind {
            name: K::NAME,
            open: |container, limits| Ok(Box::new(KindReader::<K>::new(container, limits)?)),
        });
        self
    }

    /// The names of the kinds, in the order in which they were registered.
    pub fn names(&self) -> impl ExactSizeIterator<Item = &'static str> {
        self.kinds.iter().map(|kind| kind.name)
    }

    /// Opens a map, whose tiles are read as they are asked for.
    ///
    /// # Errors
    ///
    /// [`Error::File`], naming the file, with what is wrong with it:
    /// [`Error::Kind`] if its kind is none of these.
    pub fn open(&self, path: impl AsRef<Path>, limits: &Limits) -> Result<Box<dyn ErasedMap>> {
        self.read(Container::open(path, limits)?, limits)
    }

    /// Opens the map that a container holds.
    ///
    /// # Errors
    ///
    /// As [`Self::open`].
    pub fn read(&self, container: Container, limits: &Limits) -> Result<Box<dyn ErasedMap>> {
        let found = container.kind().map_err(|error| error.in_file(container.path()))?;
        match self.kinds.iter().find(|kind| kind.name == found) {
            Some(kind) => (kind.open)(container, limits),
            None => {
                let wanted = "one that this program reads";
                Err(Error::Kind { found, wanted }.in_file(container.path()))
            }
        }
    }
}
