//! Files that functions can be had from, told apart by their first bytes.

use std::ops::Range;
use std::path::Path;

use deep_exr::{AlphaChannels, DeepExrReader, Header, Selection, Window};
use dsm_core::detail::{DepthKind, PixelWindow};
use dsm_core::{MapInfo, ShadowCamera, Tolerance, Transmittance};
use glam::DMat4;

use super::camera_reading::CameraConventions;
use super::report::ImportReport;
use super::rows::SourceRows;
use crate::achieved_error::AchievedError;
use crate::attribute::Attribute;
use crate::blocks::stated_depth_error;
use crate::error::{Error, Result, check_limit};
use crate::limits::Limits;
use crate::metadata::Metadata;
use crate::reader::MapReader;
use crate::region::Region;
use crate::source::Source;
use crate::source::remote::RemoteSource;
use crate::tile_id::TileRect;

/// A file whose pixels are, or can be made, visibility functions: what
/// [`convert`](crate::convert()) and [`compare`](super::compare::compare()) read.
///
/// ```no_run
/// use dsm_io::{Limits, MapSource};
///
/// let source = MapSource::open("hair.exr".as_ref(), None, &Limits::default())?;
/// println!("{:?} pixels, {} channels", source.size(), source.channels());
/// # Ok::<(), dsm_io::Error>(())
/// ```
#[derive(Debug)]
pub enum MapSource {
    /// A `.dsm` map: its level 0 as stored.
    Map(Box<MapReader>),
    /// A deep OpenEXR, or a flat one with a Z channel.
    Image(Box<DeepExrReader>),
}

impl MapSource {
    /// Opens `path`, of an OpenEXR what `selection` chooses (a [`Selection`], the name
    /// of a part, or `None`: the first deep part).
    ///
    /// # Errors
    ///
    /// What is wrong with the file, or not clear; [`Error::Setting`] for a selection
    /// from a `.dsm`.
    pub fn open(path: &Path, selection: impl Into<Selection>, limits: &Limits) -> Result<Self> {
        let selection = selection.into();
        if dsm_remote::is_url(path) {
            return Self::open_remote(path, selection, limits);
        }
        // A pipe has no length to hold its contents to, and may never answer.
        let file =
            std::fs::metadata(path).map_err(|error| Error::io("open")(error).in_file(path))?;
        if !file.is_file() {
            return Err(Error::Path("not a regular file").in_file(path));
        }
        if is_openexr(path)? {
            let reader = DeepExrReader::open(path, selection, &limits.images)
                .map_err(|error| Error::from(error).in_file(path))?;
            Ok(Self::Image(Box::new(reader)))
        } else {
            Self::of_map(MapReader::open(path, limits)?, &selection, limits)
        }
    }

    /// Opens the file at an address of an object store: a map by ranges, an image whole.
    fn open_remote(address: &Path, selection: Selection, limits: &Limits) -> Result<Self> {
        let in_file = |error: Error| error.in_file(address);
        let source = RemoteSource::open(address).map_err(in_file)?;
        let length = source.length();
        let start = source.read(0..length.min(OPENEXR.len() as u64)).map_err(in_file)?;
        if *start != OPENEXR {
            return Self::of_map(MapReader::open(address, limits)?, &selection, limits);
        }
        check_limit("bytes of a file in memory", length, limits.max_in_memory_bytes)
            .map_err(in_file)?;
        // Nothing but this is wanted of it.
        source.opened();
        let bytes = source.read(0..length).map_err(in_file)?.into_owned();
        let reader = DeepExrReader::from_bytes(bytes, selection, &limits.images);
        Ok(Self::Image(Box::new(reader.map_err(|error| in_file(error.into()))?)))
    }

    fn of_map(map: MapReader, selection: &Selection, limits: &Limits) -> Result<Self> {
        let pixels = map.levels()[0].pixel_count();
        map.container.in_file(check_limit("pixels", pixels, limits.max_pixels))?;
        if *selection != Selection::default() {
            let reason = "a .dsm file has no parts, layers or channels to choose from";
            return Err(Error::setting(reason));
        }
        Ok(Self::Map(Box::new(map)))
    }

    /// 1, or 3 for coloured files.
    #[must_use]
    pub fn channels(&self) -> u8 {
        match self {
            Self::Map(map) => map.metadata().channels,
            Self::Image(image) if image.header().alpha == AlphaChannels::Colour => 3,
            Self::Image(_) => 1,
        }
    }

    /// Width and height in pixels.
    #[must_use]
    pub fn size(&self) -> [u32; 2] {
        match self {
            Self::Map(map) => [map.metadata().width, map.metadata().height],
            Self::Image(image) => [image.header().width, image.header().height],
        }
    }

    /// How many rows it hands out at the cost of one: a row of tiles.
    pub(super) fn rows_at_once(&self) -> u32 {
        match self {
            Self::Map(map) => map.levels()[0].tile_height,
            Self::Image(_) => 1,
        }
    }

    /// The error that the source's functions have already, as it states.
    pub(super) fn stated_error(&self) -> AchievedError {
        match self {
            Self::Map(map) => map.levels()[0].error,
            Self::Image(_) => AchievedError::NONE,
        }
    }

    /// How far the depths of these rows were moved away from the light at most,
    /// as the source states.
    pub(super) fn stated_depth_error(&self, rows: Range<u32>) -> Result<f32> {
        match self {
            Self::Map(map) => {
                let (width, height) = (map.levels()[0].width, rows.len() as u32);
                let rect = TileRect { x: 0, y: rows.start, width, height };
                stated_depth_error(map, 0, rect)
            }
            Self::Image(_) => Ok(0.0),
        }
    }

    /// Reads whole rows, which lie inside the image. `T` has the source's
    /// number of channels.
    pub(super) fn read_rows<T: Transmittance>(
        &mut self,
        rows: Range<u32>,
    ) -> Result<SourceRows<'_, T>> {
        match self {
            Self::Map(map) => Region::read_rows(map, rows).map(SourceRows::Stored),
            Self::Image(image) => Ok(SourceRows::Samples(image.read_rows(rows)?)),
        }
    }

    /// The metadata of a map made from this file with an error of `added`, and how
    /// its camera is read.
    pub(super) fn target_metadata(
        &self,
        added: Tolerance,
        cameras: CameraConventions,
    ) -> Result<(Metadata, ImportReport)> {
        match self {
            Self::Map(map) => {
                let mut metadata = map.metadata().clone();
                let sum = metadata.info.tolerance.epsilon() + added.epsilon();
                metadata.info.tolerance = Tolerance::new(sum)?;
                Ok((metadata, ImportReport::default()))
            }
            Self::Image(image) => {
                let header = image.header();
                let mut report = ImportReport::default();
                report.source_notes.extend(header.read.line());
                if header.found_chunks > 0 {
                    report.source_notes.push(format!(
                        "{} chunks that the table of their places lacks were found by looking \
                         through the file",
                        header.found_chunks
                    ));
                }
                let mut info = MapInfo::new()
                    .with_tolerance(added)
                    .with_data_window(pixels(header.data_window));
                // Images may have one that holds nothing, which maps do not.
                info.display_window = Some(pixels(header.display_window))
                    .filter(|window| !window.size().contains(&0));
                info.camera = camera(header, cameras, &mut report);
                info.depth_kind = DepthKind::Planar;
                let mut metadata =
                    Metadata::new(header.width, header.height, self.channels(), info);
                for attribute in &header.attributes {
                    let name = attribute.name_text().into_owned();
                    let type_name = String::from_utf8_lossy(&attribute.type_name);
                    let kept = Attribute::new(type_name, attribute.value.clone());
                    metadata.attributes.insert(name, kept);
                }
                metadata.attributes.extend(picture_attributes(header));
                Ok((metadata, report))
            }
        }
    }
}

const fn pixels(Window { min, max }: Window) -> PixelWindow {
    PixelWindow { min, max }
}

/// Row-vector matrices become column-vector ones: OpenEXR's rows are glam's
/// columns, so the transposition moves no number.
fn camera(
    header: &Header,
    conventions: CameraConventions,
    report: &mut ImportReport,
) -> Option<ShadowCamera> {
    let mut matrix = |numbers: Option<[f32; 16]>| {
        let matrix = DMat4::from_cols_array(&numbers?.map(f64::from));
        report.dropped_matrices += u64::from(!matrix.is_finite());
        matrix.is_finite().then_some(matrix)
    };
    let world_to_camera = matrix(header.world_to_camera);
    let world_to_ndc = matrix(header.world_to_ndc);
    world_to_camera.or(world_to_ndc)?;
    let (camera, reading) = conventions.read(world_to_camera, world_to_ndc);
    report.camera = Some(reading);
    Some(camera)
}

/// What every image states and maps have no field for, where it says
/// something: an image made from the map gets it back.
fn picture_attributes(header: &Header) -> impl Iterator<Item = (String, Attribute)> {
    let floats = |name: &str, type_name: &str, values: &[f32], default: &[f32]| {
        let bytes = values.iter().flat_map(|value| value.to_le_bytes()).collect::<Vec<_>>();
        (values != default).then(|| (name.to_owned(), Attribute::new(type_name, bytes)))
    };
    let name = header.part_name.as_deref().filter(|name| !name.is_empty());
    [
        name.map(|name| ("name".to_owned(), Attribute::string(name))),
        floats("pixelAspectRatio", "float", &[header.pixel_aspect], &[1.0]),
        floats("screenWindowCenter", "v2f", &header.screen_window_center, &[0.0; 2]),
        floats("screenWindowWidth", "float", &[header.screen_window_width], &[1.0]),
    ]
    .into_iter()
    .flatten()
}

/// What an OpenEXR file begins with.
const OPENEXR: [u8; 4] = [0x76, 0x2f, 0x31, 0x01];

fn is_openexr(path: &Path) -> Result<bool> {
    use std::io::Read;

    let mut start = Vec::new();
    std::fs::File::open(path)
        .and_then(|file| file.take(OPENEXR.len() as u64).read_to_end(&mut start))
        .map_err(|error| Error::io("open")(error).in_file(path))?;
    Ok(start == OPENEXR)
}
