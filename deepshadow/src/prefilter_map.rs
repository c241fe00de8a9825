//! Prefiltered maps of maps.

use std::path::Path;

use dsm_core::{MapInfo, ShadowCamera, Transmittance};
use dsm_io::{Metadata, WriteOptions};
use glam::{DMat4, DVec4};
use shadow_maps::detail::{CollectedHits, ListBuilder, write_prefiltered};

use crate::bake::report::BakeReport;
use crate::bake::settings::Bake;
use crate::error::{Error, Result};
use crate::file::texel_hits::TexelHits;
use crate::shadow_map::ShadowMap;

impl ShadowMap {
    /// Makes a prefiltered map of what this map shows through the middle of every pixel,
    /// and writes it into a file that replaces `output`, if there is one: of the kinds
    /// `fragments` and `layers` what they hold, of `deep` the steps of visibility
    /// functions. Size, camera, light and channels are this map's. Of `settings` the
    /// filtering, layers, tiles and packing count. O(fragments); holds them.
    ///
    /// ```
    /// use deepshadow::{Bake, Kind, ShadowMap, bake};
    ///
    /// let scene = deepshadow::scene::builtin_scene("spinning-sphere")?;
    /// let folder = tempfile::tempdir()?;
    /// let [layers, levels] = ["layers.dsm", "levels.dsm"].map(|name| folder.path().join(name));
    /// let go_on = |_| std::ops::ControlFlow::Continue(());
    /// let settings = Bake::new([32, 32])?.with_kind(Kind::LAYERS);
    /// bake(&scene, &scene.light, &settings, &layers, go_on)?;
    ///
    /// let settings = settings.with_kind(Kind::PREFILTERED);
    /// ShadowMap::open(&layers)?.prefilter(&settings, &levels)?;
    /// assert_eq!(ShadowMap::open(&levels)?.levels().len(), 6);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`Error::Query`] for maps of other kinds, [`Error::Core`] for a map without a
    /// perspective camera, [`Error::File`] for damaged tiles or if the file cannot be
    /// written.
    pub fn prefilter(&self, settings: &Bake, output: &Path) -> Result<BakeReport> {
        settings.check()?;
        match self.texel_hits() {
            None => {
                let path = self.container().path().unwrap_or(Path::new("")).to_owned();
                let reason = format!(
                    "a map of kind {} does not tell what a pixel's middle shows: maps of kind \
                     fragments, layers or deep do",
                    self.kind()
                );
                Err(Error::Query { path, reason })
            }
            Some(hits) => match hits? {
                TexelHits::Mono(hits) => self.write(settings, hits, output),
                TexelHits::Rgb(hits) => self.write(settings, hits, output),
            },
        }
    }

    fn write<T: Transmittance>(
        &self,
        settings: &Bake,
        hits: CollectedHits<T>,
        output: &Path,
    ) -> Result<BakeReport> {
        let info = *self.info();
        let camera = own_camera(&info, self.size());
        let mut builder = ListBuilder::new(camera, self.size(), self.light_depth()?)?;
        if let Some(layers) = settings.max_layers {
            builder = builder.with_layers(layers)?;
        }
        let lists = builder.sort(hits)?;
        let options = WriteOptions::default()
            .with_tile_size(settings.tile_size)
            .with_packing(settings.packing);
        let describe = |metadata: &mut Metadata| {
            metadata.software.clone_from(&settings.software);
            metadata.attributes.clone_from(&self.metadata().attributes);
            metadata.info.light = info.light;
            let added = settings.attributes.iter();
            metadata.attributes.extend(added.map(|(name, value)| (name.clone(), value.clone())));
        };
        let filtering = settings.filtering.unwrap_or_default();
        let baked = write_prefiltered(&builder, &filtering, lists, output, options, describe)?;
        let dsm_io::detail::BakeReport { hits, cut_pixels, gained, bytes, .. } = baked;
        let [width, height] = self.size();
        Ok(BakeReport {
            samples: u64::from(width) * u64::from(height),
            hits,
            cut_pixels,
            gained,
            tolerance: 0.0,
            channels: T::CHANNELS,
            bytes,
            smaller_tiles: None,
        })
    }
}

/// The camera whose NDC cover the map's pixels, of a map that may be a part of an image.
fn own_camera(info: &MapInfo, size: [u32; 2]) -> ShadowCamera {
    let camera = info.camera.unwrap_or_default();
    let Some(display) = info.display_window else { return camera };
    let data = info.data_window.unwrap_or(display);
    let part = |axis: usize| {
        let side = f64::from(size[axis]);
        let first = f64::from(data.min[axis]) - f64::from(display.min[axis]);
        let of = f64::from(display.max[axis]) - f64::from(display.min[axis]) + 1.0;
        [of / side, -first / side]
    };
    let [[wide, left], [high, top]] = [0, 1].map(part);
    let cut = DMat4::from_cols(
        DVec4::X * wide,
        DVec4::Y * high,
        DVec4::Z,
        DVec4::new(left, top, 0.0, 1.0),
    );
    let world_to_ndc = camera.world_to_ndc.map(|to_ndc| cut * to_ndc);
    ShadowCamera { world_to_ndc, ..camera }
}
