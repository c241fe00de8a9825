//! Maps of scenes, baked with every compressor and codec.

use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

use anyhow::Result;
use dsm_core::detail::Quantization;
use dsm_core::{BakeSettings, Baker, Compression, Progress};
use dsm_io::detail::{BakeOptions, bake};
use dsm_io::{Codec, Limits, MapReader, PyramidOptions, mip};
use dsm_scene::{Scene, SceneRasterizer, builtin_scene, open_scene};

use super::functions::METHODS;

/// Width and height of a map in pixels.
const SIZE: u32 = 256;

/// A scene to bake.
pub(super) struct Subject {
    pub(super) name: String,
    scene: Scene,
}

impl Subject {
    /// A scene that the program brings along.
    pub(super) fn builtin(name: &str) -> Result<Self> {
        Ok(Self { name: name.to_owned(), scene: builtin_scene(name)? })
    }

    /// A scene or a model from a file; none if the file is not there.
    pub(super) fn open(path: &Path) -> Result<Option<Self>> {
        if !path.exists() {
            return Ok(None);
        }
        let name = path.file_name().map_or_else(PathBuf::new, PathBuf::from);
        let scene = open_scene(path)?;
        Ok(Some(Self { name: name.display().to_string(), scene }))
    }
}

/// A file.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Size {
    /// Vertices of all pixels of level 0.
    pub(super) vertices: u64,
    pub(super) bytes: u64,
}

/// Files of one scene: for each codec, exact and quantized, by each method.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Sizes {
    pub(super) files: [[Size; 2]; 2],
    /// Bytes with all mip levels, over bytes of the map, of codec `exact`.
    pub(super) pyramids: [f64; 2],
}

/// Bakes all maps of a scene, 16 samples a pixel at the usual tolerance; the baker
/// measures every pixel, and a reader checks every tile.
pub(super) fn measure(subject: &Subject) -> Result<Sizes> {
    let folder = tempfile::tempdir()?;
    let raster = subject.scene.light.raster([SIZE; 2])?;
    let source = SceneRasterizer::<f32>::new(&subject.scene, raster)?;
    let mut sizes = Sizes::default();
    for (codec, by_method) in [Codec::Exact, Codec::Quantized].into_iter().zip(&mut sizes.files) {
        for ((method, file), pyramid) in METHODS.into_iter().zip(by_method).zip(&mut sizes.pyramids)
        {
            let is_rounded = codec == Codec::Quantized;
            let settings = BakeSettings::new([SIZE; 2])?
                .with_camera(raster.shadow_camera())
                .with_quantization(is_rounded.then(Quantization::default))
                .with_compression(Compression::new(method));
            let baker = Baker::new(&source, settings)?;
            let path = folder.path().join("map.dsm");
            let options = BakeOptions::default().with_codec(codec);
            let never = |_| ControlFlow::Continue(());
            file.bytes = bake(&baker, &path, &options, |_| (), never)?.bytes;
            let reader = MapReader::open(&path, &Limits::default())?;
            reader.read_map::<f32>(0)?;
            let entries = reader.directory(0)?.iter();
            file.vertices = entries.map(|(_, tile)| tile.vertex_count).sum();
            if !is_rounded {
                let levels = folder.path().join("levels.dsm");
                mip(&reader, &levels, &PyramidOptions::default(), Progress::ignore)?;
                *pyramid = std::fs::metadata(&levels)?.len() as f64 / file.bytes as f64;
            }
        }
    }
    Ok(sizes)
}
