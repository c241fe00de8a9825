//! What accelerates the tracing of depth images, each of which may be left out.

/// Which accelerations are used (Agrawala et al. 2000, §5.1.1 and §5.1.2). Of one view the
/// first three change no answer; clear misses and occlusion intervals leave out what later
/// views would hit by mistake.
///
/// ```
/// use shadow_maps::detail::TraceOptions;
///
/// assert!(TraceOptions::ALL.hierarchy && !TraceOptions::NONE.hierarchy);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TraceOptions {
    /// Parts of a view whose depths the ray does not reach are passed over at once.
    pub hierarchy: bool,
    /// The ray is cut to the depths of each part before it goes on into that.
    pub clipping: bool,
    /// A ray that comes from behind a connected part to before it is blocked at once.
    pub connectedness: bool,
    /// A ray that one view sees whole is not traced in others.
    pub clear_miss: bool,
    /// Later views are asked for what earlier ones do not see alone.
    pub intervals: bool,
    /// Views in which the ray is shortest, in pixels, come first.
    pub ranking: bool,
}

impl TraceOptions {
    /// All of them.
    pub const ALL: Self = Self {
        hierarchy: true,
        clipping: true,
        connectedness: true,
        clear_miss: true,
        intervals: true,
        ranking: true,
    };

    /// From pixel to pixel, through one view after another.
    pub const NONE: Self = Self {
        hierarchy: false,
        clipping: false,
        connectedness: false,
        clear_miss: false,
        intervals: false,
        ranking: false,
    };
}

impl Default for TraceOptions {
    fn default() -> Self {
        Self::ALL
    }
}
