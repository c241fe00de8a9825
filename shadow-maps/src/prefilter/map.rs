//! Prefiltered maps in memory.

use std::convert::Infallible;

use dsm_core::Transmittance;
use dsm_core::detail::Result;
use dsm_trace::detail::LightFrame;

use super::level_plan::LevelGeometry;
use super::lists::FragmentLists;
use super::lookup::{LevelLists, Levels, nearest_of};
use super::pyramid::filtered;
use super::settings::PrefilterSettings;
use super::source::PrefilteredSource;
use super::sums::ListView;
use super::tile::PrefilteredTile;

/// A prefiltered multilayer map (Selgrad et al. 2014): the fragments of every texel, and
/// levels of them that wider and wider filters have merged.
///
/// ```
/// use dsm_core::{AreaLight, LightVisibility, ShadowCamera};
/// use dsm_trace::detail::LightFrame;
/// use glam::{DMat4, DVec3, DVec4};
/// use shadow_maps::detail::{
///     FragmentLists, PrefilterSettings, PrefilteredMap, PrefilteredShadow,
/// };
///
/// # let to_ndc = DMat4::from_cols(
/// #     DVec4::new(0.5, 0.0, 0.0, 0.0),
/// #     DVec4::new(0.0, -0.5, 0.0, 0.0),
/// #     DVec4::new(-0.5, -0.5, -1.0, -1.0),
/// #     DVec4::ZERO,
/// # );
/// # let camera =
/// #     ShadowCamera { world_to_camera: Some(DMat4::IDENTITY), world_to_ndc: Some(to_ndc) };
/// let frame = LightFrame::new(&camera, [64, 64], 0.0)?;
/// // A half plane at depth 2: the right half of the map.
/// let mut lists = FragmentLists::new([64, 64]);
/// for texel in 0..64 * 64 {
///     if texel % 64 >= 32 {
///         lists.push(0.5, 1.0_f32);
///     }
///     lists.finish_texel()?;
/// }
/// let map = PrefilteredMap::new(frame, lists, &PrefilterSettings::default(), 0.5)?;
/// let shadow = PrefilteredShadow::new(map);
/// let light = AreaLight::rectangle(DVec3::ZERO, DVec3::X / 4.0, DVec3::Y / 4.0);
/// // Behind its edge half of the light is seen.
/// let Ok(left) = shadow.visibility(DVec3::new(0.0, 0.0, -4.0), &light, 0);
/// assert!((left - 0.5).abs() < 0.02, "{left}");
/// # Ok::<(), dsm_core::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct PrefilteredMap<T> {
    frame: LightFrame,
    levels: Vec<PrefilteredTile<T>>,
    known: Levels,
}

impl<T: Transmittance> PrefilteredMap<T> {
    /// Filters the lists of a map with this frame, for lights of this width in scene
    /// units. O(fragments of all levels).
    ///
    /// # Errors
    ///
    /// [`Error::Level`](dsm_core::Error::Level) for a level that the map cannot have,
    /// [`Error::Setting`](dsm_core::Error::Setting) for an ε that is none, or lists of
    /// another size than the map.
    pub fn new(
        frame: LightFrame,
        base: FragmentLists<T>,
        settings: &PrefilterSettings,
        light: f64,
    ) -> Result<Self> {
        if base.size() != frame.size() {
            let reason = "there must be a list a texel of the map";
            return Err(dsm_core::Error::Setting { setting: "lists", reason });
        }
        let (levels, geometry) = filtered(base, settings, frame.footprint(1.0), light)?;
        Ok(Self::of_levels(frame, levels, geometry))
    }

    /// A map of levels that are filtered already.
    pub(super) fn of_levels(
        frame: LightFrame,
        levels: Vec<FragmentLists<T>>,
        geometry: Vec<LevelGeometry>,
    ) -> Self {
        let nearest = |level: &FragmentLists<T>| {
            level.depth_range().map_or(0.0, |[depth, _]| nearest_of(depth))
        };
        let known = Levels::new(geometry, levels.iter().map(nearest).collect());
        Self { frame, levels: levels.into_iter().map(PrefilteredTile::new).collect(), known }
    }

    /// The frame of the map.
    #[must_use]
    pub const fn frame(&self) -> &LightFrame {
        &self.frame
    }

    /// The lists of all levels, the finest first, and where their texels stand.
    pub fn levels(
        &self,
    ) -> impl ExactSizeIterator<Item = (&FragmentLists<T>, &LevelGeometry)> + '_ {
        self.levels.iter().map(PrefilteredTile::lists).zip(&self.known.geometry)
    }
}

impl<T: Transmittance> LevelLists<T> for PrefilteredMap<T> {
    type Error = Infallible;

    #[inline]
    fn with_list<R>(
        &self,
        level: usize,
        [x, y]: [u32; 2],
        look: impl FnOnce(ListView<'_, T>) -> R,
    ) -> Result<R, Infallible> {
        let width = self.known.geometry[level].size[0] as usize;
        Ok(look(self.levels[level].view(y as usize * width + x as usize)))
    }
}

impl<T: Transmittance> PrefilteredSource for PrefilteredMap<T> {
    type Value = T;
    type Error = Infallible;
    type Lists = Self;

    fn frame(&self) -> &LightFrame {
        &self.frame
    }

    fn known(&self) -> &Levels {
        &self.known
    }

    fn with_lists<R>(&self, ask: impl FnOnce(&Self) -> R) -> R {
        ask(self)
    }
}
