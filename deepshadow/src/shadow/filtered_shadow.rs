//! Filtered lookups in a map's file.

use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use dsm_core::detail::{BiasSummary, Pyramid, ShadowLookup};
use dsm_core::{
    AreaLight, Bias, Footprint, LevelChoice, Receiver, ShadedPoint, Transmittance, VisibilityField,
};
use dsm_io::detail::{CachedMap, CursorPool, FieldKind};
use glam::DVec3;

use super::any_visibility::AnyVisibility;
use super::handle::Shadow;
use super::statistics::ShadowStatistics;
use crate::error::{Error, Result};
use crate::query::filter_method::FilterMethod;
use crate::query::settings::Query;
use crate::values::Values;

/// Pixels that the filter of one point may reach: about a second's work.
const MOST_PIXELS: u64 = 1 << 26;

/// The visibility functions of a map, read through a cache and filtered.
struct FilteredMap<T: Transmittance, K: FieldKind> {
    cursors: CursorPool<T, K>,
    /// None where the map has no camera: it answers in its raster alone.
    lookup: Option<ShadowLookup>,
    method: FilterMethod,
    biases: Mutex<BiasSummary>,
    /// The map's file, for errors.
    path: PathBuf,
}

/// The shadows of a map by filtered lookups, once it is known that it has the level
/// and that the filter reaches no more pixels than a lookup may visit.
pub(crate) fn filtered_shadow<T: Transmittance, K: FieldKind>(
    map: &CachedMap<T, K>,
    method: FilterMethod,
    query: &Query,
) -> Result<Shadow> {
    let FilterMethod { footprint, level, bias } = method;
    let metadata = map.reader().metadata();
    let (info, size) = (metadata.info, [metadata.width, metadata.height]);
    let cursors = CursorPool::new(map.clone(), level)?;
    cursors.with_pyramid(|pyramid| {
        check(pyramid, &method).map_err(|reason| Error::query(map.reader(), reason))
    })?;
    let set =
        |lookup: ShadowLookup| lookup.with_footprint(footprint).with_level(level).with_bias(bias);
    let lookup = match info.camera {
        Some(_) => Some(set(ShadowLookup::new(&info, size)?)),
        None => None,
    };
    // What one point of the light sees: no more of it is asked for.
    let light = query.light.unwrap_or(AreaLight::point(DVec3::ZERO));
    let path = map.reader().container().path().map(Path::to_owned).unwrap_or_default();
    let filtered = FilteredMap { cursors, lookup, method, biases: Mutex::default(), path };
    Ok(Shadow::new(Box::new(filtered), light, query.seed))
}

impl<T: Transmittance, K: FieldKind> AnyVisibility for FilteredMap<T, K> {
    fn channels(&self) -> usize {
        T::CHANNELS
    }

    fn world(&self, points: &[ShadedPoint], _: &AreaLight, values: &mut Values) -> Result<()> {
        let Some(lookup) = &self.lookup else {
            let reason = "the map has no camera to project points of the world with".to_owned();
            return Err(Error::Query { path: self.path.clone(), reason });
        };
        let mut own = Vec::with_capacity(points.len());
        let biases = self.cursors.with_pyramid(|pyramid| lookup.lights(pyramid, points, &mut own));
        values.extend(&own);
        self.biases.lock().unwrap_or_else(PoisonError::into_inner).merge(biases?);
        Ok(())
    }

    fn raster(
        &self,
        points: &[[f64; 3]],
        _: u64,
        _: &AreaLight,
        values: &mut Values,
    ) -> Result<()> {
        let FilterMethod { footprint, level, bias } = self.method;
        let Bias::Depth(bias) = bias else {
            let reason = "points of a raster lie on nothing: a bias is a depth there";
            return Err(Error::Unsupported(reason.to_owned()));
        };
        let mut own = Vec::with_capacity(points.len());
        self.cursors.with_pyramid(|pyramid| {
            for point in points {
                let [x, y, depth] = point.map(|coordinate| coordinate as f32);
                let receiver = Receiver { bias, ..Receiver::new([x, y], depth) };
                own.push(pyramid.lookup(&receiver, &footprint, level)?);
            }
            Ok::<_, Error>(())
        })?;
        values.extend(&own);
        Ok(())
    }

    fn statistics(&self) -> ShadowStatistics {
        let biases = *self.biases.lock().unwrap_or_else(PoisonError::into_inner);
        ShadowStatistics { biases: Some(biases), ..ShadowStatistics::default() }
    }
}

/// Whether the pyramid has the level, and the filter reaches no more pixels of it
/// than a lookup may visit.
fn check<F: VisibilityField>(pyramid: &Pyramid<F>, method: &FilterMethod) -> Result<(), String> {
    if let LevelChoice::Fixed(level) = method.level {
        match pyramid.levels().len() {
            count if level <= (count - 1) as f64 => {}
            1 => return Err(format!("there is no level {level}: the map has one level, 0")),
            count => {
                let last = count - 1;
                return Err(format!(
                    "there is no level {level}: the map has {count} levels, 0 to {last}"
                ));
            }
        }
    }
    let reached = pixels_of_a_filter(pyramid, &method.footprint, method.level);
    if reached > MOST_PIXELS {
        return Err(format!(
            "the filter reaches {reached} pixels, more than the {MOST_PIXELS} of a lookup: \
             look up a coarser level (--level)"
        ));
    }
    Ok(())
}

/// About how many pixels a filter visits in the finer of its levels.
fn pixels_of_a_filter<F: VisibilityField>(
    pyramid: &Pyramid<F>,
    footprint: &Footprint,
    level: LevelChoice,
) -> u64 {
    let Footprint::Isotropic(filter) = footprint else { return 1 };
    let width = f64::from(filter.width());
    let finest = match level {
        LevelChoice::Fixed(level) => level,
        LevelChoice::Auto => (width / 2.0).log2(),
    };
    let levels = pyramid.levels();
    let level = (finest.max(0.0) as usize).min(levels.len() - 1);
    let reach = width / 2.0_f64.powi(level as i32) + 1.0;
    levels[level].size().map(|size| (reach as u64).min(size.into())).iter().product()
}
