//! Errors of arguments.

/// An argument that was refused, with the reason.
///
/// ```
/// use dsm_core::{Error, Tolerance};
///
/// let error = Tolerance::new(1.5).unwrap_err();
/// assert_eq!(error, Error::Tolerance(1.5));
/// assert_eq!(error.to_string(), "a tolerance must lie in [0, 1), not 1.5");
/// ```
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A tolerance outside [0, 1).
    #[error("a tolerance must lie in [0, 1), not {0}")]
    Tolerance(f32),
    /// A filter width that is not finite or narrower than its shape allows.
    #[error("a {shape} filter must be at least {minimum} pixels wide, not {width}")]
    FilterWidth {
        /// The filter's shape.
        shape: &'static str,
        /// The width that was given, in pixels.
        width: f32,
        /// The narrowest width of that shape.
        minimum: f32,
    },
    /// A surface hit or volume sample that no ray can have.
    #[error("hit at depth {depth}: {reason}")]
    Hit {
        /// Depth of the hit or sample.
        depth: f32,
        /// The rule that it breaks.
        reason: &'static str,
    },
    /// A visibility function that breaks its invariant.
    #[error("visibility function, vertex {vertex}: {reason}")]
    Visibility {
        /// Index of the first vertex that breaks it.
        vertex: usize,
        /// The rule that is broken.
        reason: &'static str,
    },
    /// Per-pixel columns that do not fit together.
    #[error("pixel {pixel}: {reason}")]
    Pixel {
        /// Row-major index of the pixel.
        pixel: usize,
        /// The rule that they break.
        reason: &'static str,
    },
    /// A map larger than its index type.
    #[error("{what}: {count} is more than {limit}")]
    TooLarge {
        /// The quantity that is too large.
        what: &'static str,
        /// The number that was given.
        count: u64,
        /// The largest number that is supported.
        limit: u64,
    },
    /// A setting of a bake that is not supported.
    #[error("{setting}: {reason}")]
    Setting {
        /// The setting.
        setting: &'static str,
        /// The rule that it breaks.
        reason: &'static str,
    },
    /// A hit of a sample that was not requested, or columns of hits that do not fit
    /// together.
    #[error("hits of sample {sample} of {samples}: {reason}")]
    Sample {
        /// Index of the sample.
        sample: u32,
        /// The number of samples that was requested.
        samples: u32,
        /// The rule that it breaks.
        reason: &'static str,
    },
    /// A level that does not fit into its pyramid.
    #[error("level {level} of a pyramid: {reason}")]
    Level {
        /// The level's number; 0 is the finest.
        level: usize,
        /// The rule that they break.
        reason: &'static str,
    },
    /// A camera without the matrices or the projection that a call needs.
    #[error("camera: {0}")]
    Camera(&'static str),
}

/// The result of a fallible call of this crate.
pub type Result<T, E = Error> = std::result::Result<T, E>;
