//! Reports of bakes.

/// The counts of a bake.
///
/// ```
/// use deepshadow::{Bake, bake};
/// use std::ops::ControlFlow;
///
/// let scene = deepshadow::scene::builtin_scene("spinning-sphere")?;
/// let folder = tempfile::tempdir()?;
/// let (path, settings) = (folder.path().join("map.dsm"), Bake::new([16, 16])?);
/// let report = bake(&scene, &scene.light, &settings.with_samples(4), &path, |_| {
///     ControlFlow::Continue(())
/// })?;
/// assert_eq!(report.samples, 16 * 16 * 4);
/// assert_eq!(report.bytes, std::fs::metadata(&path)?.len());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct BakeReport {
    /// Samples of all pixels.
    pub samples: u64,
    /// Hits of all samples, with those on the borders of tiles that a wide
    /// filter samples again.
    pub hits: u64,
    /// Pixels with more layers than the map keeps.
    pub cut_pixels: u64,
    /// The most light that one of them lets through too much by that, and the mean over all
    /// pixels, in [0, 1]: of kind `fragments`, else 0. It is too much between the layers that
    /// became one, and none behind them.
    pub gained: [f32; 2],
    /// The bound of the error of every visibility function.
    pub tolerance: f32,
    /// Numbers a value: 1 or 3.
    pub channels: usize,
    /// Length of the file in bytes.
    pub bytes: u64,
    /// Width and height that tiles were cut down to, because larger ones would have
    /// been more than readers accept.
    pub smaller_tiles: Option<u32>,
}
