//! Coherently traced shadows.

/// Shadow rays that are traced only where what a point sees of the light can have
/// changed since the point before (Agrawala et al. 2000, §5.2): the light's border, the
/// edges of shadows on it, and around whatever was predicted wrongly.
///
/// Points are taken in an order that keeps neighbours together; many at once save most.
/// Through maps of kinds `layers`, `mtsm` and `views`, or a scene
/// ([`Shadow::coherent`](crate::Shadow::coherent)).
///
/// ```
/// use deepshadow::{CoherenceMethod, Query};
///
/// let method = CoherenceMethod::with_rays(256).unwrap();
/// assert_eq!(method.side, 16);
/// assert!(CoherenceMethod::with_rays(255).is_none());
/// let query = Query::new().with_method(method);
/// # assert_eq!(query.method.unwrap().name(), "coherence");
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct CoherenceMethod {
    /// Cells along a side of the light, 1 to 256: a ray for each of their square where
    /// nothing is predicted.
    pub side: u32,
    /// The ray offset: the distance from the receiver at which rays begin, in scene
    /// units, at least 0. None: the rule of the map's kind.
    pub start: Option<f64>,
    /// How far apart two points may lie for one to tell of the other, as a share of
    /// their distance from the light. None: 0.05. Less misses fewer small occluders
    /// and traces more.
    pub reach: Option<f64>,
}

impl CoherenceMethod {
    /// `side` × `side` cells of the light, 1 to 256 a side.
    #[must_use]
    pub const fn new(side: u32) -> Self {
        Self { side, start: None, reach: None }
    }

    /// As many cells as rays; none unless they are a square, of 1 to 256.
    #[must_use]
    pub const fn with_rays(rays: u32) -> Option<Self> {
        let side = rays.isqrt();
        if side * side == rays && 1 <= side && side <= Self::MOST {
            Some(Self::new(side))
        } else {
            None
        }
    }

    const MOST: u32 = 256;

    /// Sets the ray offset in scene units.
    #[must_use]
    pub const fn with_start(mut self, start: f64) -> Self {
        self.start = Some(start);
        self
    }

    /// Sets how far apart points may lie that tell of each other.
    #[must_use]
    pub const fn with_reach(mut self, reach: f64) -> Self {
        self.reach = Some(reach);
        self
    }

    /// As the tracer takes it; nothing is predicted where something moves.
    pub(crate) fn settings(&self, is_moving: bool) -> dsm_trace::detail::CoherenceSettings {
        let settings = dsm_trace::detail::CoherenceSettings::new(self.side);
        let settings = settings.with_prediction(!is_moving);
        self.reach.map_or(settings, |reach| settings.with_reach(reach))
    }
}

impl Default for CoherenceMethod {
    /// 256 cells.
    fn default() -> Self {
        Self::new(16)
    }
}
