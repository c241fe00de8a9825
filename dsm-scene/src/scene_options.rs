//! Choices of what is read of a scene's file.

use crate::load::vdb::choice::GridChoice;
#[cfg(doc)]
use crate::scene::Scene;

/// Choices of what is read of a scene's file.
///
/// ```
/// use dsm_scene::detail::SceneOptions;
///
/// let options = SceneOptions::default().grid("density:1".parse()?);
/// assert_eq!(options.grid.map(|grid| grid.to_string()).as_deref(), Some("density:1"));
/// # Ok::<(), dsm_scene::Error>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct SceneOptions {
    /// The grid of a volume's file that is the scene. Scene files name theirs
    /// themselves.
    pub grid: Option<GridChoice>,
    /// The number that stands for each run of `#` in the scene's name, and in the paths of a
    /// scene file.
    pub frame: Option<u32>,
    /// The most bytes that the scene may take ([`Scene::memory`]); any number without.
    pub memory: Option<u64>,
}

impl SceneOptions {
    /// The same with this grid of a volume's file.
    #[must_use]
    pub fn grid(self, grid: GridChoice) -> Self {
        Self { grid: Some(grid), ..self }
    }

    /// The same for a frame of a sequence.
    #[must_use]
    pub fn frame(self, frame: u32) -> Self {
        Self { frame: Some(frame), ..self }
    }

    /// The same for a scene that takes at most so many bytes.
    #[must_use]
    pub fn memory(self, bytes: u64) -> Self {
        Self { memory: Some(bytes), ..self }
    }
}
