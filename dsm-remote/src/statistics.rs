//! What reading a remote file took.

/// Counts of a [`RemoteFile`](crate::RemoteFile)'s requests since it was opened.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct RemoteStatistics {
    /// Requests sent, repeated ones too.
    pub requests: u64,
    /// Bytes of the file that came in answers.
    pub bytes: u64,
    /// Reads that the cache on the local disk answered.
    pub disk_hits: u64,
}
