//! A caller's function as a hit source.

#![expect(unreachable_pub, reason = "C reaches them by their names")]

use deepshadow::visibility::{
    Error as CoreError, HitSource, Rgb, TileHits, TileSamples, Transmittance, ViewRaster,
};
use deepshadow::{AnyHitSource, Error, Occluders};

use crate::failure::{Failure, Result};

/// The hits of a tile, which a caller fills.
#[expect(non_camel_case_types, reason = "a name of C")]
pub struct ds_hits(Filled);

/// What is filled, and what was wrong with it first.
struct Filled {
    hits: AnyTileHits,
    wrong: Option<CoreError>,
}

enum AnyTileHits {
    Mono(TileHits<f32>),
    Rgb(TileHits<Rgb>),
}

/// What a map is baked through, which tells its rays.
#[expect(non_camel_case_types, reason = "a name of C")]
#[derive(Clone, Copy, Debug)]
pub struct ds_view(pub(crate) ViewRaster);

impl ds_hits {
    /// Adds surfaces: a sample, a depth and an opacity each, or as many opacities as the map
    /// has channels.
    pub(crate) fn add(&mut self, samples: &[u32], depths: &[f32], opacities: &[f32]) -> Result<()> {
        let Filled { hits, wrong } = &mut self.0;
        let added = match hits {
            AnyTileHits::Mono(hits) => hits.push_surface_columns(samples, depths, opacities),
            AnyTileHits::Rgb(hits) => {
                let opacities: Vec<_> = opacities
                    .as_chunks::<3>()
                    .0
                    .iter()
                    .map(|&[r, g, b]| Rgb::new(r, g, b))
                    .collect();
                hits.push_surface_columns(samples, depths, &opacities)
            }
        };
        keep(added, wrong)
    }

    /// Adds a slab of even density between two depths.
    pub(crate) fn add_slab(
        &mut self,
        sample: u32,
        [near, far]: [f32; 2],
        opacities: &[f32],
    ) -> Result<()> {
        let Filled { hits, wrong } = &mut self.0;
        let added = match (hits, opacities) {
            (AnyTileHits::Mono(hits), &[opacity]) => hits.push_slab(sample, near, far, opacity),
            (AnyTileHits::Rgb(hits), &[r, g, b]) => {
                hits.push_slab(sample, near, far, Rgb::new(r, g, b))
            }
            _ => {
                return Err(Failure::internal(
                    "opacities of another number of channels".to_owned(),
                ));
            }
        };
        keep(added, wrong)
    }

    /// Numbers an opacity: 1 or 3.
    pub(crate) const fn channels(&self) -> usize {
        match &self.0.hits {
            AnyTileHits::Mono(_) => 1,
            AnyTileHits::Rgb(_) => 3,
        }
    }
}

/// Keeps an error for the bake, and tells the caller of it.
fn keep(added: std::result::Result<(), CoreError>, wrong: &mut Option<CoreError>) -> Result<()> {
    added.map_err(|error| {
        let told = Failure::setting(error.to_string());
        wrong.get_or_insert(error);
        told
    })
}

/// Why a source gave no hits.
#[derive(Debug, thiserror::Error)]
pub(crate) enum SourceError {
    /// The caller's function did not return 0.
    #[error("the hit source returned {0}")]
    Returned(i32),
    /// What it added is no hit.
    #[error(transparent)]
    Core(#[from] CoreError),
}

/// What a caller's function sees: it answers the samples of a tile through a view.
pub(crate) struct CallerOccluders<F> {
    pub(crate) answer: F,
    pub(crate) is_coloured: bool,
    pub(crate) has_media: bool,
}

/// The same through one view.
struct CallerHits<'a, F> {
    occluders: &'a CallerOccluders<F>,
    view: ds_view,
}

/// The hits of a number of channels within [`ds_hits`] and back.
trait Channels: Transmittance {
    fn wrap(hits: TileHits<Self>) -> AnyTileHits;
    fn unwrap(hits: AnyTileHits) -> Option<TileHits<Self>>;
}

impl Channels for f32 {
    fn wrap(hits: TileHits<Self>) -> AnyTileHits {
        AnyTileHits::Mono(hits)
    }

    fn unwrap(hits: AnyTileHits) -> Option<TileHits<Self>> {
        if let AnyTileHits::Mono(hits) = hits { Some(hits) } else { None }
    }
}

impl Channels for Rgb {
    fn wrap(hits: TileHits<Self>) -> AnyTileHits {
        AnyTileHits::Rgb(hits)
    }

    fn unwrap(hits: AnyTileHits) -> Option<TileHits<Self>> {
        if let AnyTileHits::Rgb(hits) = hits { Some(hits) } else { None }
    }
}

impl<F> Occluders for CallerOccluders<F>
where
    F: Fn(&TileSamples, &ds_view, &mut ds_hits) -> i32 + Sync,
{
    fn is_coloured(&self) -> bool {
        self.is_coloured
    }

    fn mono(&self, view: &ViewRaster) -> std::result::Result<AnyHitSource<'_, f32>, Error> {
        Ok(AnyHitSource::new(CallerHits { occluders: self, view: ds_view(*view) }))
    }

    fn rgb(&self, view: &ViewRaster) -> std::result::Result<AnyHitSource<'_, Rgb>, Error> {
        Ok(AnyHitSource::new(CallerHits { occluders: self, view: ds_view(*view) }))
    }
}

impl<T: Channels, F> HitSource<T> for CallerHits<'_, F>
where
    F: Fn(&TileSamples, &ds_view, &mut ds_hits) -> i32 + Sync,
{
    type Error = SourceError;

    fn hits(&self, samples: &TileSamples, hits: &mut TileHits<T>) -> Result<(), SourceError> {
        // The columns keep their memory.
        let lent = std::mem::replace(hits, TileHits::new(0));
        let mut filled = ds_hits(Filled { hits: T::wrap(lent), wrong: None });
        let returned = (self.occluders.answer)(samples, &self.view, &mut filled);
        let Filled { hits: back, wrong } = filled.0;
        if let Some(back) = T::unwrap(back) {
            *hits = back;
        }
        match (wrong, returned) {
            (Some(wrong), _) => Err(wrong.into()),
            (None, 0) => Ok(()),
            (None, returned) => Err(SourceError::Returned(returned)),
        }
    }

    fn has_media(&self) -> bool {
        self.occluders.has_media
    }
}
