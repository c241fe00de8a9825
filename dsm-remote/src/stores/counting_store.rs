//! A store in memory that counts, and fails as it is told.

use std::collections::VecDeque;
use std::fmt;
use std::ops::Range;
use std::sync::Mutex;
use std::time::Duration;

use async_trait::async_trait;
use futures_util::StreamExt;
use futures_util::stream::{self, BoxStream};
use object_store::memory::InMemory;
use object_store::path::Path;
use object_store::{
    CopyOptions, GetOptions, GetRange, GetResult, GetResultPayload, ListResult, MultipartUpload,
    ObjectMeta, ObjectStore, ObjectStoreExt, PutMultipartOptions, PutOptions, PutPayload,
    PutResult, Result,
};

/// What goes wrong with a request.
#[derive(Clone, Debug)]
pub(super) enum Fault {
    /// Nothing.
    None,
    /// The answer ends after so many bytes, as if that were all.
    Cut(usize),
    /// The connection breaks after so many bytes.
    Break(usize),
    /// More bytes come than were asked for.
    Long,
    /// The server is busy.
    Busy,
    /// The server refuses, with this status.
    Status(u16),
    /// Nothing comes.
    Hang,
    /// The object is replaced before the request arrives.
    Replaced(Vec<u8>),
    /// The same, and the server does not look at conditions.
    ReplacedUnseen(Vec<u8>),
}

#[derive(Debug, Default)]
pub(super) struct CountingStore {
    objects: InMemory,
    faults: Mutex<VecDeque<Fault>>,
    asked: Mutex<Vec<Range<u64>>>,
    /// What the store tells of a version: an ETag, a time.
    tells: Tells,
}

/// What a server tells of an object's version.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) enum Tells {
    #[default]
    Etag,
    WeakEtag,
    Time,
    Nothing,
}

impl CountingStore {
    pub(super) fn telling(tells: Tells) -> Self {
        Self { tells, ..Self::default() }
    }

    pub(super) async fn set(&self, path: &str, bytes: Vec<u8>) {
        self.objects.put(&path.into(), PutPayload::from(bytes)).await.unwrap();
    }

    pub(super) fn fail(&self, faults: impl IntoIterator<Item = Fault>) {
        self.faults.lock().unwrap().extend(faults);
    }

    /// The ranges asked for since the last call.
    pub(super) fn asked(&self) -> Vec<Range<u64>> {
        std::mem::take(&mut self.asked.lock().unwrap())
    }

    fn told(&self, meta: &mut ObjectMeta) {
        match self.tells {
            Tells::Etag => {}
            Tells::WeakEtag => meta.e_tag = meta.e_tag.as_ref().map(|etag| format!("W/{etag}")),
            Tells::Time => meta.e_tag = None,
            Tells::Nothing => {
                meta.e_tag = None;
                meta.last_modified = std::time::SystemTime::UNIX_EPOCH.into();
            }
        }
    }
}

impl fmt::Display for CountingStore {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("CountingStore")
    }
}

fn broken(text: &str) -> object_store::Error {
    object_store::Error::Generic { store: "counting", source: text.into() }
}

#[async_trait]
impl ObjectStore for CountingStore {
    async fn get_opts(&self, location: &Path, mut options: GetOptions) -> Result<GetResult> {
        if let Some(GetRange::Bounded(range)) = &options.range {
            self.asked.lock().unwrap().push(range.clone());
        }
        let fault = self.faults.lock().unwrap().pop_front().unwrap_or(Fault::None);
        match &fault {
            Fault::Busy => return Err(broken("status code: 503 Service Unavailable: later")),
            Fault::Status(code) => return Err(broken(&format!("status code: {code}: no"))),
            Fault::Hang => tokio::time::sleep(Duration::from_secs(3600)).await,
            Fault::Replaced(bytes) => self.set(location.as_ref(), bytes.clone()).await,
            Fault::ReplacedUnseen(bytes) => {
                self.set(location.as_ref(), bytes.clone()).await;
                options.if_match = None;
                options.if_unmodified_since = None;
            }
            _ => {}
        }
        if self.tells == Tells::WeakEtag {
            assert_eq!(options.if_match, None, "a weak tag never matches");
        }
        let mut answer = self.objects.get_opts(location, options).await?;
        let (mut meta, range) = (answer.meta.clone(), answer.range.clone());
        self.told(&mut meta);
        answer.meta = meta;
        let meta = answer.meta.clone();
        let attributes = answer.attributes.clone();
        let bytes = answer.bytes().await?;
        let parts = match fault {
            Fault::Cut(length) => vec![Ok(bytes.slice(..length.min(bytes.len())))],
            Fault::Break(length) => {
                vec![Ok(bytes.slice(..length.min(bytes.len()))), Err(broken("reset"))]
            }
            Fault::Long => vec![Ok(bytes.clone()), Ok(bytes)],
            // In pieces, as bytes come from a network.
            _ => bytes.chunks(5000).map(|part| Ok(bytes.slice_ref(part))).collect(),
        };
        let payload = GetResultPayload::Stream(stream::iter(parts).boxed());
        Ok(GetResult { payload, meta, range, attributes, extensions: Default::default() })
    }

    async fn put_opts(
        &self,
        to: &Path,
        bytes: PutPayload,
        options: PutOptions,
    ) -> Result<PutResult> {
        self.objects.put_opts(to, bytes, options).await
    }

    async fn put_multipart_opts(
        &self,
        to: &Path,
        options: PutMultipartOptions,
    ) -> Result<Box<dyn MultipartUpload>> {
        self.objects.put_multipart_opts(to, options).await
    }

    fn delete_stream(
        &self,
        paths: BoxStream<'static, Result<Path>>,
    ) -> BoxStream<'static, Result<Path>> {
        self.objects.delete_stream(paths)
    }

    fn list(&self, prefix: Option<&Path>) -> BoxStream<'static, Result<ObjectMeta>> {
        self.objects.list(prefix)
    }

    async fn list_with_delimiter(&self, prefix: Option<&Path>) -> Result<ListResult> {
        self.objects.list_with_delimiter(prefix).await
    }

    async fn copy_opts(&self, from: &Path, to: &Path, options: CopyOptions) -> Result<()> {
        self.objects.copy_opts(from, to, options).await
    }
}
