//! Traced shadows.

use mtsm::detail::LeafRule;

/// Use of a far table: sums of optical depth over coarse pixels in place of
/// fragments far from a receiver. Fast for hair and leaves, wrong for closed
/// surfaces.
///
/// ```
/// use deepshadow::{FarTable, TraceMethod};
///
/// let exact = TraceMethod::new(256).with_far_table(FarTable::Off);
/// assert_eq!(exact.far_table, Some(FarTable::Off));
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum FarTable {
    /// If a trial on receivers of the map finds no difference that matters.
    #[default]
    Auto,
    /// Always.
    On,
    /// Never.
    Off,
}

/// Shadow rays through the layers or fragments of a map.
///
/// ```
/// use deepshadow::{Query, TraceMethod};
///
/// let query = Query::new().with_method(TraceMethod::new(64).with_start(1e-3));
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct TraceMethod {
    /// Shadow rays of a point, at least 1.
    pub rays: u32,
    /// The ray offset: the distance from the receiver at which rays begin, in scene
    /// units, at least 0. None: the rule of the map's kind.
    pub start: Option<f64>,
    /// The rule by which layers that count several samples are split; kinds `layers`
    /// and `mtsm` only. None: [`LeafRule::Ratio`].
    pub rule: Option<LeafRule>,
    /// Reach of a sample in depth to either side, in scene units (§6.1);
    /// kinds `layers` and `mtsm` only. None: 0.
    pub depth_threshold: Option<f64>,
    /// Use of a table of optical depths; kind `fragments` only. None:
    /// [`FarTable::Auto`].
    pub far_table: Option<FarTable>,
}

impl TraceMethod {
    /// `rays` shadow rays, at least 1, with the rules of the map's kind.
    #[must_use]
    pub const fn new(rays: u32) -> Self {
        Self { rays, start: None, rule: None, depth_threshold: None, far_table: None }
    }

    /// Sets the ray offset in scene units.
    #[must_use]
    pub const fn with_start(mut self, start: f64) -> Self {
        self.start = Some(start);
        self
    }

    /// Sets the rule by which layers of several samples are split.
    #[must_use]
    pub const fn with_rule(mut self, rule: LeafRule) -> Self {
        self.rule = Some(rule);
        self
    }

    /// Sets the reach of a sample in depth, in scene units.
    #[must_use]
    pub const fn with_depth_threshold(mut self, threshold: f64) -> Self {
        self.depth_threshold = Some(threshold);
        self
    }

    /// Sets the use of a table of optical depths; of kind `fragments` only.
    #[must_use]
    pub const fn with_far_table(mut self, far_table: FarTable) -> Self {
        self.far_table = Some(far_table);
        self
    }

    /// True if a rule was set that only layers without planes have.
    #[must_use]
    pub const fn has_layer_rules(&self) -> bool {
        self.rule.is_some() || self.depth_threshold.is_some()
    }
}

impl Default for TraceMethod {
    /// 256 rays.
    fn default() -> Self {
        Self::new(256)
    }
}
