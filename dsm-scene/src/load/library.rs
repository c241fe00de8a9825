//! What was read for a scene so far: images, each once, and the memory of all.

use std::cell::RefCell;
use std::collections::HashMap;
use std::path::{Path, PathBuf};

use super::image::{Channel, decode};
use crate::alpha::AlphaTexture;
use crate::error::Result;
use crate::scene_memory::SceneMemory;

/// The place of an image: a file, or a numbered part of one.
pub(super) type ImagePlace = (PathBuf, Option<usize>);

/// The images that a scene's models share, and the memory of all that was read.
#[derive(Debug)]
pub(crate) struct Library {
    limit: u64,
    memory: RefCell<SceneMemory>,
    images: RefCell<HashMap<(ImagePlace, Channel), Option<AlphaTexture>>>,
}

impl Library {
    /// A library of what takes at most so many bytes.
    pub(crate) fn new(limit: u64) -> Self {
        Self { limit, memory: RefCell::default(), images: RefCell::default() }
    }

    /// The opacity of an image, read once: `read` gives its bytes, `extension` tells
    /// formats without a mark.
    pub(super) fn image(
        &self,
        place: ImagePlace,
        channel: Channel,
        read: impl FnOnce() -> Result<Vec<u8>>,
    ) -> Result<Option<AlphaTexture>> {
        // Two ways to say one file.
        let (path, part) = place;
        let path = path.canonicalize().unwrap_or(path);
        let extension = super::extension(&path).filter(|_| part.is_none());
        let name = name_of(&path);
        let key = ((path, part), channel);
        if let Some(known) = self.images.borrow().get(&key) {
            return Ok(known.clone());
        }
        let bytes = read()?;
        let image =
            decode(&bytes, extension.as_deref(), channel, |bytes| self.check(&name, bytes))?;
        self.add(&name, image.as_ref().map_or(0, AlphaTexture::bytes));
        self.images.borrow_mut().insert(key, image.clone());
        Ok(image)
    }

    /// Refuses a file that is longer than the memory that is left: it takes no less.
    pub(crate) fn check_file(&self, path: &Path) -> Result<()> {
        // What cannot be opened says so when it is read.
        let length = path.metadata().map_or(0, |metadata| metadata.len());
        self.check(&name_of(path), length)
    }

    /// Refuses `bytes` of a file's contents that do not fit.
    pub(super) fn check_bytes(&self, path: &Path, bytes: u64) -> Result<()> {
        self.check(&name_of(path), bytes)
    }

    /// Refuses `bytes` for `name` that do not fit.
    fn check(&self, name: &str, bytes: u64) -> Result<()> {
        self.memory.borrow().check(name, bytes, self.limit)
    }

    /// Counts `bytes` that a file's contents take.
    pub(crate) fn add_file(&self, path: &Path, bytes: u64) -> Result<()> {
        self.check_bytes(path, bytes)?;
        self.add(&name_of(path), bytes);
        Ok(())
    }

    fn add(&self, name: &str, bytes: u64) {
        self.memory.borrow_mut().add(name, bytes);
    }

    /// The memory that all takes, and the most that it may.
    pub(crate) fn into_memory(self) -> (SceneMemory, u64) {
        (self.memory.into_inner(), self.limit)
    }
}

impl Default for Library {
    /// A library of what takes any amount.
    fn default() -> Self {
        Self::new(u64::MAX)
    }
}

fn name_of(path: &Path) -> String {
    path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned()
}

#[cfg(test)]
mod tests {
    use std::cell::Cell;
    use std::io::Cursor;

    use image::{ExtendedColorType, ImageFormat};

    use super::*;
    use crate::error::Error;

    fn image_of(pixels: &[u8], width: u32) -> Vec<u8> {
        let mut bytes = Cursor::new(Vec::new());
        let (height, grey) = (pixels.len() as u32 / width, ExtendedColorType::L8);
        let png = ImageFormat::Png;
        image::write_buffer_with_format(&mut bytes, pixels, width, height, grey, png).unwrap();
        bytes.into_inner()
    }

    #[test]
    fn an_image_is_read_once_however_it_is_named() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("leaf.png");
        std::fs::write(&path, image_of(&[0, 255], 2)).unwrap();
        let library = Library::default();
        let reads = Cell::new(0);
        let image = |path: PathBuf, channel| {
            let read = || {
                reads.set(reads.get() + 1);
                crate::load::read_file(&path)
            };
            library.image((path.clone(), None), channel, read).unwrap().unwrap()
        };
        let first = image(path.clone(), Channel::Red);
        let again = folder.path().join(".").join("leaf.png");
        assert_eq!(image(again, Channel::Red), first);
        assert_eq!(reads.get(), 1);
        assert_eq!(image(path, Channel::Brightness), first);
        assert_eq!(reads.get(), 2);
        assert_eq!(library.into_memory().0.total(), 4);
    }

    #[test]
    fn an_image_that_does_not_fit_is_not_unpacked() {
        let library = Library::new(1 << 20);
        let read = || Ok(image_of(&vec![7; 1 << 22], 1 << 11));
        let refused = library.image((PathBuf::from("big.png"), None), Channel::Red, read);
        let refused = refused.unwrap_err();
        assert!(matches!(&refused, Error::Memory { .. }), "{refused}");
        assert!(refused.to_string().contains("big.png 4 MiB"), "{refused}");
    }
}
