//! Images that are written come back as they were.

#![expect(clippy::unwrap_used, reason = "a test that fails says where")]

use std::error::Error as _;
use std::io::{self, Cursor, Seek, SeekFrom, Write};

use deep_exr::detail::ChunkEncoder;
use deep_exr::{
    AlphaChannels, Attribute, Compression, DeepExrReader, DeepExrWriter, DeepRows, DeepSample,
    Error, Layout, Limits, SampleType, Window, WriteOptions,
};

const SIZE: [u32; 2] = [7, 5];

/// Samples that 16-bit floats hold, none in every third pixel.
fn rows(options: &WriteOptions, lines: std::ops::Range<u32>) -> DeepRows {
    let mut rows = options.rows(SIZE[0]);
    for pixel in lines.start * SIZE[0]..lines.end * SIZE[0] {
        for sample in 0..pixel % 3 {
            let z = (pixel + sample) as f32 / 3.0;
            let alpha = [0, 1, 2].map(|colour| (pixel + colour) as f32 / 64.0);
            rows.push(DeepSample { z, z_back: z + 0.125, alpha });
        }
        rows.finish_pixel().unwrap();
    }
    rows
}

fn writer(options: &WriteOptions) -> DeepExrWriter<Cursor<Vec<u8>>> {
    DeepExrWriter::new(Cursor::new(Vec::new()), options).unwrap()
}

/// Writes the image in bands of so many rows.
fn written(options: &WriteOptions, band: u32) -> Vec<u8> {
    let mut writer = writer(options);
    for first in (0..SIZE[1]).step_by(band as usize) {
        writer.write_rows(&rows(options, first..SIZE[1].min(first + band))).unwrap();
    }
    assert_eq!(writer.max_samples(), 2);
    writer.finish().unwrap().into_inner()
}

fn reader(bytes: Vec<u8>) -> DeepExrReader {
    DeepExrReader::from_bytes(bytes, None, &Limits::default()).unwrap()
}

fn options() -> WriteOptions {
    WriteOptions::new(SIZE[0], SIZE[1])
}

fn layouts() -> [Layout; 4] {
    let tiles = |width, height| Layout::Tiles { width, height };
    [Layout::ScanLines, tiles(3, 2), tiles(64, 64), tiles(1, 1)]
}

#[test]
fn every_kind_of_image_comes_back() {
    let alphas = [AlphaChannels::None, AlphaChannels::Mono, AlphaChannels::Colour];
    for layout in layouts() {
        for compression in
            [Compression::None, Compression::Rle, Compression::Zips, Compression::Zstd]
        {
            for alpha in alphas {
                for (sample_type, z_back) in [(SampleType::Half, true), (SampleType::Float, false)]
                {
                    let options = options()
                        .layout(layout)
                        .compression(compression)
                        .alpha(alpha, sample_type)
                        .z_back(z_back);
                    let mut reader = reader(written(&options, 2));
                    assert_eq!(reader.read_rows(0..SIZE[1]).unwrap(), rows(&options, 0..SIZE[1]));
                    let header = reader.header();
                    assert_eq!((header.layout, header.deep), (layout, true));
                    assert_eq!(header.stated_max_samples, Some(2));
                    assert_eq!(header.channels, options.channels());
                    // What a header tells makes the same file again.
                    let again = WriteOptions::like(header);
                    let kept = if alpha == AlphaChannels::None {
                        again.alpha(alpha, sample_type)
                    } else {
                        again
                    };
                    assert_eq!(written(&kept, 2), written(&options, 2));
                }
            }
        }
    }
}

#[test]
fn the_bytes_do_not_depend_on_how_rows_are_handed_over() {
    for layout in layouts() {
        let options = options().layout(layout);
        let whole = written(&options, SIZE[1]);
        for band in 1..SIZE[1] {
            assert_eq!(written(&options, band), whole, "{layout:?}, {band} rows");
        }
        // Chunk by chunk, and in the grid's order, they are the same too.
        let mut writer = writer(&options);
        let (grid, all) = (writer.grid(), rows(&options, 0..SIZE[1]));
        let mut encoder = ChunkEncoder::new(&options);
        for (band, column) in
            (0..grid.bands()).flat_map(|band| (0..grid.columns()).map(move |column| (band, column)))
        {
            let block = grid.block(column, band);
            let mut part = options.rows(block.width);
            for y in block.y..block.y + block.height {
                for x in block.x..block.x + block.width {
                    let samples = all.pixel((y * SIZE[0] + x) as usize);
                    samples.for_each(|index| part.push(all.sample(index)));
                    part.finish_pixel().unwrap();
                }
            }
            writer.write_chunk(&block, &encoder.encode(&part).unwrap()).unwrap();
        }
        assert_eq!(writer.finish().unwrap().into_inner(), whole, "{layout:?}");
    }
}

#[test]
fn the_header_says_what_it_was_told() {
    let display = Window { min: [0, 0], max: [99, 49] };
    let mut options = options().corner([-3, 12]).display_window(display);
    let matrix: [f32; 16] = std::array::from_fn(|index| index as f32);
    for attribute in [
        Attribute::string("name", "smoke"),
        Attribute::floats("pixelAspectRatio", "float", &[2.0]),
        Attribute::floats("worldToCamera", "m44f", &matrix),
        Attribute::string("a name of more than thirty-one letters", "kept"),
        Attribute::new("frame", "int", 7_i32.to_le_bytes()),
        Attribute::new("frame", "int", 8_i32.to_le_bytes()),
    ] {
        options.set(attribute).unwrap();
    }
    let reader = reader(written(&options, 1));
    let header = reader.header();
    assert_eq!(header.data_window, Window { min: [-3, 12], max: [3, 16] });
    assert_eq!((header.display_window, header.pixel_aspect), (display, 2.0));
    assert_eq!(
        (header.part_name.as_deref(), header.world_to_camera),
        (Some("smoke"), Some(matrix))
    );
    let free: Vec<_> = header.attributes.iter().map(|a| (a.name_text(), &a.value[..])).collect();
    let long = "a name of more than thirty-one letters".into();
    assert_eq!(free, [(long, &b"kept"[..]), ("frame".into(), &[8, 0, 0, 0])]);
}

#[test]
fn attributes_that_no_header_may_have_are_refused() {
    for (attribute, why) in [
        (Attribute::string("", "nameless"), "1 to 255"),
        (Attribute::string([b'n'; 256], "long"), "1 to 255"),
        (Attribute::string("no\0name", ""), "none of them 0"),
        (Attribute::new("typeless", "", []), "1 to 255"),
        (Attribute::string("channels", "nonsense"), "how the file is built"),
        (Attribute::string("screenWindowWidth", "wide"), "type"),
        (Attribute::new("frame", "int", [1]), "as long as"),
    ] {
        let mut options = options();
        let error = options.set(attribute).unwrap_err();
        assert!(matches!(error, Error::Attribute { .. }), "{error:?}");
        assert!(error.to_string().contains(why), "{error}");
        assert_eq!(options, self::options());
    }
}

#[test]
fn images_that_no_file_can_be_are_refused() {
    let tiles = |width, height| options().layout(Layout::Tiles { width, height });
    for (options, why) in [
        (WriteOptions::new(0, 4), "no pixels"),
        (WriteOptions::new(u32::MAX, 4), "2^30"),
        (options().corner([i32::MAX - 2, 0]), "2^30"),
        (options().corner([0, i32::MIN]), "2^30"),
        (tiles(0, 4), "1 to 4096"),
        (tiles(4, 4097), "1 to 4096"),
        (
            WriteOptions::new(1 << 29, 1 << 29).layout(Layout::Tiles { width: 1, height: 1 }),
            "2^31 chunks",
        ),
    ] {
        let error = DeepExrWriter::new(Cursor::new(Vec::new()), &options).unwrap_err();
        assert!(matches!(error, Error::Options(_)), "{error:?}");
        assert!(error.to_string().contains(why), "{error}");
    }
}

#[test]
fn rows_of_another_image_are_refused() {
    let options = options();
    let mut writer = writer(&options);
    let mut refused = |rows: &DeepRows, why: &str| {
        let error = writer.write_rows(rows).unwrap_err();
        assert!(matches!(error, Error::Rows { .. }), "{error:?}");
        assert!(error.to_string().contains(why), "{error}");
    };
    let mut narrow = options.rows(1);
    narrow.finish_pixel().unwrap();
    refused(&narrow, "width");
    refused(&rows(&options, 0..SIZE[1] + 1), "fewer rows");
    refused(&rows(&options.clone().z_back(false), 0..1), "columns");
    let coloured = options.clone().alpha(AlphaChannels::Colour, SampleType::Float);
    refused(&rows(&coloured, 0..1), "columns");
    let mut open = rows(&options, 0..1);
    open.push(DeepSample { z: 1.0, z_back: 1.0, alpha: [1.0; 3] });
    refused(&open, "no end");
    open.finish_pixel().unwrap();
    refused(&open, "no end");
    // It goes on where it was.
    writer.write_rows(&rows(&options, 0..SIZE[1])).unwrap();
    writer.finish().unwrap();
}

#[test]
fn chunks_are_written_once_each() {
    let options = options().layout(Layout::Tiles { width: 4, height: 5 });
    let mut writer = writer(&options);
    let block = writer.grid().block(1, 0);
    let mut pixels = options.rows(3);
    (0..15).for_each(|_| pixels.finish_pixel().unwrap());
    let chunk = ChunkEncoder::new(&options).encode(&pixels).unwrap();
    let refused = |result: Result<(), Error>, why: &str| {
        let error = result.unwrap_err();
        assert!(error.to_string().contains(why), "{error}");
    };
    let other = writer.grid().block(0, 0);
    refused(writer.write_chunk(&other, &chunk), "another size");
    let beyond = writer.grid().block(2, 0);
    refused(writer.write_chunk(&beyond, &chunk), "another size");
    writer.write_chunk(&block, &chunk).unwrap();
    refused(writer.write_chunk(&block, &chunk), "written before");
    refused(writer.finish().map(drop), "1 chunks were not written, the first of them tile (0, 0)");
}

#[test]
fn an_unfinished_file_is_read_as_far_as_it_was_written() {
    let options = options();
    let mut buffer = Cursor::new(Vec::new());
    let mut writer = DeepExrWriter::new(&mut buffer, &options).unwrap();
    writer.write_rows(&rows(&options, 0..SIZE[1] / 2)).unwrap();
    drop(writer);
    let mut reader = reader(buffer.into_inner());
    assert_eq!(reader.read_rows(0..1).unwrap(), rows(&options, 0..1));
    let error = reader.read_rows(0..SIZE[1]).unwrap_err();
    assert!(error.to_string().contains("not written to its end"), "{error}");
}

#[test]
fn only_opaque_samples_are_stored_as_opaque() {
    let options = WriteOptions::new(1, 1).alpha(AlphaChannels::Mono, SampleType::Half);
    let mut pixel = options.rows(1);
    for alpha in [0.999_99, 1.0, f32::NAN, 1.5] {
        pixel.push(DeepSample { z: 1.0, z_back: 1.0, alpha: [alpha; 3] });
    }
    pixel.finish_pixel().unwrap();
    let mut writer = writer(&options);
    writer.write_rows(&pixel).unwrap();
    let rows = reader(writer.finish().unwrap().into_inner()).read_rows(0..1).unwrap();
    let alphas: Vec<f32> = (0..4).map(|index| rows.sample(index).alpha[0]).collect();
    assert_eq!(alphas[..2], [1.0 - 1.0 / 2048.0, 1.0]);
    assert!(alphas[2].is_nan() && alphas[3] == 1.5);
}

/// A disk with room for so many bytes.
struct Full(usize);

impl Write for Full {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let room = self.0.min(bytes.len());
        self.0 -= room;
        if room == 0 { Err(io::ErrorKind::StorageFull.into()) } else { Ok(room) }
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl Seek for Full {
    fn seek(&mut self, _: SeekFrom) -> io::Result<u64> {
        Ok(0)
    }
}

#[test]
fn the_cause_of_a_failed_write_can_be_reached() {
    let options = options();
    let length = written(&options, 1).len();
    for room in [0, length / 2, length] {
        let write = || {
            let mut writer = DeepExrWriter::new(Full(room), &options)?;
            writer.write_rows(&rows(&options, 0..SIZE[1]))?;
            writer.finish().map(drop)
        };
        let error = write().unwrap_err();
        let cause = error.source().and_then(|cause| cause.downcast_ref::<io::Error>());
        assert_eq!(cause.map(io::Error::kind), Some(io::ErrorKind::StorageFull), "{room}");
        assert_eq!(error.to_string(), "cannot write");
    }
}
