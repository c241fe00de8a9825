//! Whether a map shows what is asked for.

use std::sync::atomic::{AtomicBool, Ordering};

use deepshadow::detail::{MapView, Result};
use deepshadow::glam::DVec3;
use deepshadow::visibility::{AreaLight, LightVisibility, Rgb, ShadedPoint};
use deepshadow::{Error, Kind, Shadow, ShadowMap};

/// True if a map holds nothing, in none of its levels.
pub(crate) fn is_empty(map: &ShadowMap) -> Result<bool> {
    for level in 0..map.container().levels().len() as u32 {
        if !map.container().directory(level)?.iter().all(|(_, tile)| tile.is_empty()) {
            return Ok(false);
        }
    }
    Ok(true)
}

/// What a map of a kind that holds nothing is, as warnings say it: one of occluders casts no
/// shadow, one of lit places has none.
pub(crate) fn empty_is(kind: &str) -> &'static str {
    if kind == Kind::ATTENUATION.name() { "dark everywhere" } else { "lit everywhere" }
}

/// True if a map shows a part of an image plane: parts are often empty.
pub(crate) fn is_part(map: &ShadowMap) -> bool {
    let info = map.info();
    info.data_window.zip(info.display_window).is_some_and(|(data, display)| data != display)
}

/// A watch over the points of a query: ends with the first one that the map shows.
#[derive(Debug)]
pub(crate) struct InMap {
    /// None: whatever is asked for is shown.
    view: Option<MapView>,
    asked: AtomicBool,
    shown: AtomicBool,
}

impl InMap {
    pub(crate) fn new(view: Option<MapView>) -> Self {
        Self { view, asked: false.into(), shown: false.into() }
    }

    fn see<P>(&self, points: impl IntoIterator<Item = P>, shows: impl Fn(&MapView, P) -> bool) {
        if self.shown.load(Ordering::Relaxed) {
            return;
        }
        for point in points {
            self.asked.store(true, Ordering::Relaxed);
            if self.view.as_ref().is_none_or(|view| shows(view, point)) {
                self.shown.store(true, Ordering::Relaxed);
                return;
            }
        }
    }

    /// Sees points of the world.
    pub(crate) fn see_world(&self, points: impl IntoIterator<Item = DVec3>) {
        self.see(points, MapView::shows);
    }

    /// Sees points of the map's raster.
    pub(crate) fn see_raster(&self, points: &[[f64; 3]]) {
        self.see(points.iter().copied(), MapView::shows_raster);
    }

    /// True if any point was asked for.
    pub(crate) fn is_asked(&self) -> bool {
        self.asked.load(Ordering::Relaxed)
    }

    /// The warning, if there were points and the map shows none.
    pub(crate) fn warning(&self) -> Option<&'static str> {
        let nothing = self.is_asked() && !self.shown.load(Ordering::Relaxed);
        nothing.then_some("no point lies in the map: all are lit, whatever it holds")
    }
}

/// Shadows that are watched: whether a map shows any point that is asked for.
pub(crate) struct Watched<'a> {
    pub(crate) shadow: &'a Shadow,
    pub(crate) seen: &'a InMap,
}

impl LightVisibility for Watched<'_> {
    type Value = Rgb;
    type Error = Error;

    fn visibility(&self, receiver: DVec3, light: &AreaLight, seed: u64) -> Result<Rgb> {
        self.seen.see_world([receiver]);
        self.shadow.visibility(receiver, light, seed)
    }

    fn visibilities(
        &self,
        points: &[ShadedPoint],
        light: &AreaLight,
        values: &mut Vec<Rgb>,
    ) -> Result<()> {
        self.seen.see_world(points.iter().map(|point| point.position));
        self.shadow.visibilities(points, light, values)
    }
}
