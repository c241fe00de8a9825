//! The deep maps of the figures, as files.

use std::ops::ControlFlow;
use std::path::PathBuf;
use std::time::Instant;

use anyhow::Result;
use dsm_core::detail::Quantization;
use dsm_core::{BakeSettings, Baker, DeepMap, PixelSampling, Progress};
use dsm_io::detail::{BakeOptions, bake};
use dsm_io::{Codec, Limits, MapReader, PyramidOptions, mip};
use tempfile::TempDir;

use super::Stage;

/// A deep map in a file.
#[derive(Debug)]
pub struct StoredMap {
    /// Samples along the side of a pixel.
    pub side: u32,
    /// Length of the file in bytes.
    pub bytes: u64,
    /// Length of a file of the same map with depths and values as they are, codec `exact`.
    pub bytes_exact: u64,
    /// Length of the file with all mip levels.
    pub bytes_with_mips: u64,
    /// How long the bake took, on all cores.
    pub seconds: f64,
    path: PathBuf,
    path_with_mips: PathBuf,
}

impl StoredMap {
    /// Samples a pixel.
    #[must_use]
    pub const fn samples(&self) -> u32 {
        self.side * self.side
    }

    /// The map, read from its file.
    ///
    /// # Errors
    ///
    /// What the reader says.
    pub fn read(&self) -> Result<DeepMap<f32>> {
        Ok(MapReader::open(&self.path, &Limits::default())?.read_map(0)?)
    }

    /// All levels of the map with mips.
    ///
    /// # Errors
    ///
    /// What the reader says.
    pub fn read_levels(&self) -> Result<Vec<DeepMap<f32>>> {
        let reader = MapReader::open(&self.path_with_mips, &Limits::default())?;
        let levels = 0..reader.levels().len() as u32;
        levels.map(|level| Ok(reader.read_map(level)?)).collect()
    }
}

/// Bakes the maps of a stage, each once.
pub struct Bakes {
    folder: TempDir,
    maps: Vec<StoredMap>,
}

impl Bakes {
    /// No map yet.
    ///
    /// # Errors
    ///
    /// If there is no place for files.
    pub fn new() -> Result<Self> {
        Ok(Self { folder: tempfile::tempdir()?, maps: Vec::new() })
    }

    /// The map with `side` × `side` samples a pixel, at the paper's tolerance of
    /// 0.25/√N.
    ///
    /// # Errors
    ///
    /// What the baker and the writer say.
    pub fn map(&mut self, stage: &Stage, side: u32) -> Result<&StoredMap> {
        let known = self.maps.iter().position(|map| map.side == side);
        let index = match known {
            Some(index) => index,
            None => {
                self.maps.push(store(stage, side, &self.folder)?);
                self.maps.len() - 1
            }
        };
        Ok(&self.maps[index])
    }
}

fn store(stage: &Stage, side: u32, folder: &TempDir) -> Result<StoredMap> {
    let start = Instant::now();
    let mut settings = BakeSettings::new([stage.effort.map; 2])?;
    settings.sampling = PixelSampling::new(side * side, 0)?;
    settings.camera = Some(stage.raster.shadow_camera());
    settings.quantization = Some(Quantization::default());
    let baker = Baker::new(&stage.source, settings)?;
    let path = folder.path().join(format!("{side}.dsm"));
    let options = BakeOptions::default().with_codec(Codec::Quantized);
    let never = |_| ControlFlow::Continue(());
    let report = bake(&baker, &path, &options, |_| (), never)?;
    let seconds = start.elapsed().as_secs_f64();
    let mut settings = baker.settings().clone();
    settings.quantization = None;
    let exact = folder.path().join(format!("{side}-exact.dsm"));
    let options = BakeOptions::default();
    let bytes_exact =
        bake(&Baker::new(&stage.source, settings)?, &exact, &options, |_| (), never)?.bytes;
    std::fs::remove_file(exact)?;
    let path_with_mips = folder.path().join(format!("{side}-mip.dsm"));
    let reader = MapReader::open(&path, &Limits::default())?;
    mip(&reader, &path_with_mips, &PyramidOptions::default(), Progress::ignore)?;
    let bytes_with_mips = std::fs::metadata(&path_with_mips)?.len();
    let bytes = report.bytes;
    Ok(StoredMap { side, bytes, bytes_exact, bytes_with_mips, seconds, path, path_with_mips })
}
