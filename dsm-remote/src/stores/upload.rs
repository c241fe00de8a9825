//! Finished files, sent to a store.

use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::sync::Arc;

use object_store::path::Path;
use object_store::{ObjectStore, ObjectStoreExt, PutPayload, WriteMultipart};

use super::connect::{Address, Retries};
use super::runtime::wait;
use crate::error::{Error, Refusal, Result};
use crate::options::RemoteOptions;

/// The least bytes of a part, and what is sent at once without parts.
const PART_BYTES: u64 = 8 << 20;
/// The most parts that a file is sent in; stores take 10,000.
const PARTS: u64 = 9000;
/// Parts on their way at a time.
const PARTS_AT_ONCE: usize = 3;
/// The most bytes of a file that is sent in one request, from memory.
const WHOLE_BYTES: u64 = 1 << 30;

/// Sends a file to an address: in one request, or in parts if it is large. In S3, GCS and
/// Azure it is seen when the last part has arrived, and until then whatever had the
/// address stays as it was; what a plain HTTP server does is its own choice.
///
/// # Errors
///
/// [`Error::Address`], [`Error::Client`], [`Error::TooLarge`]; what the store says.
pub fn upload(file: &mut File, address: &str, options: &RemoteOptions) -> Result<()> {
    let address = Address::parse(address)?;
    let length = file.metadata().map_err(Error::io("read the finished file"))?.len();
    let is_whole = address.is_plain_http();
    if is_whole && length > WHOLE_BYTES {
        return Err(Error::TooLarge { length, limit: WHOLE_BYTES });
    }
    let part = length.div_ceil(PARTS).max(PART_BYTES);
    let sent = if is_whole { length } else { part.saturating_mul(PARTS_AT_ONCE as u64) };
    let limit = options.timeout.saturating_mul(sent.div_ceil(1 << 20).clamp(1, 1 << 16) as u32);
    let store = address.connect(limit, Retries::Client(options.retries))?;
    send(file, store, address.path, length, (!is_whole).then_some(part))
}

/// Sends a file of `length` bytes, in parts of so many bytes if it has more.
pub(super) fn send(
    file: &mut File,
    store: Arc<dyn ObjectStore>,
    path: Path,
    length: u64,
    part: Option<u64>,
) -> Result<()> {
    file.seek(SeekFrom::Start(0)).map_err(Error::io("read the finished file"))?;
    match part {
        Some(part) if length > part => send_parts(file, Arc::clone(&store), path.clone(), part)?,
        _ => {
            let bytes = read_part(file, length)?;
            let (store, path) = (Arc::clone(&store), path.clone());
            wait(async move {
                let sent = store.put(&path, PutPayload::from(bytes)).await;
                sent.map(drop).map_err(failure)
            })?;
        }
    }
    wait(async move {
        match store.head(&path).await {
            Ok(there) if there.size != length => Err(Error::Changed),
            // A server may take files and tell nothing of them.
            _ => Ok(()),
        }
    })
}

fn send_parts(file: &mut File, store: Arc<dyn ObjectStore>, path: Path, part: u64) -> Result<()> {
    let started = wait(async move { store.put_multipart(&path).await.map_err(failure) })?;
    let mut upload = WriteMultipart::new_with_chunk_size(started, part as usize);
    loop {
        let bytes = match read_part(file, part) {
            Ok(bytes) => bytes,
            Err(error) => {
                // The first error tells more than what comes of it.
                drop(wait(async move { upload.abort().await.map_err(failure) }));
                return Err(error);
            }
        };
        if bytes.is_empty() {
            break;
        }
        upload = wait(async move {
            match upload.wait_for_capacity(PARTS_AT_ONCE).await {
                Ok(()) => {
                    upload.put(bytes.into());
                    Ok(upload)
                }
                Err(error) => {
                    drop(upload.abort().await);
                    Err(failure(error))
                }
            }
        })?;
    }
    // Gives the parts up by itself if one could not be sent.
    wait(async move { upload.finish().await.map(drop).map_err(failure) })
}

fn read_part(file: &mut File, length: u64) -> Result<Vec<u8>> {
    let mut bytes = Vec::new();
    let read = file.take(length).read_to_end(&mut bytes);
    read.map_err(Error::io("read the finished file"))?;
    Ok(bytes)
}

fn failure(error: object_store::Error) -> Error {
    use object_store::Error as Store;
    let refusal = Refusal::of(&error);
    match error {
        Store::NotFound { .. } => Error::NotFound(refusal),
        Store::PermissionDenied { .. } | Store::Unauthenticated { .. } => Error::Denied(refusal),
        _ => Error::NotTaken(refusal),
    }
}
