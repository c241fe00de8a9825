//! Clients of stores, from an address and the environment.

use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use object_store::aws::{AmazonS3Builder, AmazonS3ConfigKey};
use object_store::azure::{AzureConfigKey, MicrosoftAzureBuilder};
use object_store::gcp::{GoogleCloudStorageBuilder, GoogleConfigKey};
use object_store::http::HttpBuilder;
use object_store::path::Path;
use object_store::{
    BackoffConfig, ClientConfigKey, ClientOptions, ObjectStore, ObjectStoreScheme, RetryConfig,
};
use url::{Position, Url};

use crate::address::Parts;
use crate::error::{Error, Refusal, Result};
use crate::options::RemoteOptions;

/// Who tries requests again.
#[derive(Clone, Copy, Debug)]
pub(super) enum Retries {
    /// The caller, who knows what it has already.
    Caller,
    /// The client, so often.
    Client(u32),
}

/// An address that was accepted.
#[derive(Clone, Debug)]
pub(super) struct Address {
    url: Url,
    scheme: ObjectStoreScheme,
    pub(super) path: Path,
}

impl Address {
    /// Takes an address apart, and refuses what clients would pass over in silence.
    pub(super) fn parse(text: &str) -> Result<Self> {
        let parts = Parts::of(text).ok_or(Error::Address("not the address of an object store"))?;
        if parts.has_user() {
            return Err(Error::Address(
                "the address has a user or key in it: credentials are taken from the environment",
            ));
        }
        if !parts.rest.is_empty() {
            return Err(Error::Address(
                "the address goes on behind a ? or #, which no store is asked for: write them as %3F and %23 in a name; signed addresses are not taken",
            ));
        }
        if parts.path.is_empty() || parts.path.ends_with('/') {
            return Err(Error::Address("the address names no file"));
        }
        if parts.authority.is_empty() {
            // Taken for a host otherwise: what follows the third slash.
            return Err(Error::Address("the address names no host or bucket"));
        }
        let no_address = |_| Error::Address("not an address that can be read");
        let url = Url::parse(text).map_err(no_address)?;
        let (scheme, path) = ObjectStoreScheme::parse(&url)
            .map_err(|_| Error::Address("not an address of a file"))?;
        Ok(Self { url, scheme, path })
    }

    /// The address as caches know it.
    pub(super) fn key(&self) -> &str {
        self.url.as_str()
    }

    /// Whether files are sent in one request, for want of uploads in parts.
    pub(super) fn is_plain_http(&self) -> bool {
        self.scheme == ObjectStoreScheme::Http
    }

    /// A client. Connections are made when it is used.
    pub(super) fn connect(
        &self,
        timeout: Duration,
        retries: Retries,
    ) -> Result<Arc<dyn ObjectStore>> {
        // An error says that there is one already, which serves as well.
        drop(rustls::crypto::ring::default_provider().install_default());
        let built = self.build(&Settings { timeout, retries });
        built.map_err(|error| Error::Client(Refusal::of(&error)))
    }

    fn build(&self, settings: &Settings) -> object_store::Result<Arc<dyn ObjectStore>> {
        let url = self.url.as_str();
        // Endpoints may be plain HTTP where somebody wrote so.
        let allow = |names: &[&str]| {
            let plain = names.iter().filter_map(|name| std::env::var(name).ok());
            plain.into_iter().any(|endpoint| endpoint.starts_with("http://"))
        };
        Ok(match self.scheme {
            ObjectStoreScheme::AmazonS3 => {
                let mut store = AmazonS3Builder::from_env().with_url(url);
                for (key, value) in settings.client() {
                    store = store.with_config(AmazonS3ConfigKey::Client(key), value);
                }
                if allow(&["AWS_ENDPOINT", "AWS_ENDPOINT_URL", "AWS_ENDPOINT_URL_S3"]) {
                    store = store.with_allow_http(true);
                }
                Arc::new(store.with_retry(settings.retry()).build()?)
            }
            ObjectStoreScheme::GoogleCloudStorage => {
                let mut store = GoogleCloudStorageBuilder::from_env().with_url(url);
                for (key, value) in settings.client() {
                    store = store.with_config(GoogleConfigKey::Client(key), value);
                }
                Arc::new(store.with_retry(settings.retry()).build()?)
            }
            ObjectStoreScheme::MicrosoftAzure => {
                let mut store = MicrosoftAzureBuilder::from_env().with_url(url);
                for (key, value) in settings.client() {
                    store = store.with_config(AzureConfigKey::Client(key), value);
                }
                if allow(&["AZURE_STORAGE_ENDPOINT", "AZURE_ENDPOINT"]) {
                    store = store.with_allow_http(true);
                }
                Arc::new(store.with_retry(settings.retry()).build()?)
            }
            // The rest has no scheme that an address may have.
            _ => {
                let mut client = ClientOptions::new().with_allow_http(self.url.scheme() == "http");
                for (key, value) in settings.client() {
                    client = client.with_config(key, value);
                }
                let store = HttpBuilder::new().with_url(&self.url[..Position::BeforePath]);
                Arc::new(store.with_client_options(client).with_retry(settings.retry()).build()?)
            }
        })
    }
}

struct Settings {
    timeout: Duration,
    retries: Retries,
}

impl Settings {
    fn client(&self) -> [(ClientConfigKey, String); 2] {
        let limit = format!("{}ms", self.timeout.as_millis().max(1));
        let connect = format!("{}ms", self.timeout.as_millis().clamp(1, 5000));
        [(ClientConfigKey::Timeout, limit), (ClientConfigKey::ConnectTimeout, connect)]
    }

    fn retry(&self) -> RetryConfig {
        let max_retries = match self.retries {
            Retries::Caller => 0,
            Retries::Client(retries) => retries as usize,
        };
        let backoff = BackoffConfig { max_backoff: Duration::from_secs(5), ..Default::default() };
        RetryConfig { backoff, max_retries, ..Default::default() }
    }
}

/// Makes clients of one object's store.
type MakeClient = dyn Fn() -> Result<Arc<dyn ObjectStore>> + Send + Sync;

/// A client that is this process's own: a child of a fork must not use the
/// connections of its parent.
pub(super) struct Connection {
    make: Box<MakeClient>,
    current: Mutex<(u32, Arc<dyn ObjectStore>)>,
}

impl Connection {
    pub(super) fn new(
        make: impl Fn() -> Result<Arc<dyn ObjectStore>> + Send + Sync + 'static,
    ) -> Result<Self> {
        let current = Mutex::new((std::process::id(), make()?));
        Ok(Self { make: Box::new(make), current })
    }

    pub(super) fn client(&self) -> Result<Arc<dyn ObjectStore>> {
        let mut current = self.current.lock().unwrap_or_else(PoisonError::into_inner);
        let process = std::process::id();
        if current.0 != process {
            *current = (process, (self.make)()?);
        }
        Ok(Arc::clone(&current.1))
    }
}

impl std::fmt::Debug for Connection {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        // Clients show endpoints and more.
        f.write_str("Connection")
    }
}

/// Checks that a file can be sent to an address, as far as that shows without a request.
///
/// # Errors
///
/// [`Error::Address`] or [`Error::Client`].
pub fn check_address(address: &str, options: &RemoteOptions) -> Result<()> {
    Address::parse(address)?.connect(options.timeout, Retries::Caller).map(drop)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn addresses_with_more_than_a_file_are_refused() {
        for (address, reason) in [
            ("https://me:secret@host/f.dsm", "user or key"),
            ("https://host/f.dsm?sig=secret", "behind a ? or #"),
            ("s3://bucket/a#b", "behind a ? or #"),
            ("s3://bucket", "names no file"),
            ("https://host/folder/", "names no file"),
            ("ftp://host/f", "not the address"),
            ("https:///f", "no host or bucket"),
            ("s3://bucket/a//b", "not an address"),
        ] {
            let error = Address::parse(address).expect_err(address).to_string();
            assert!(error.contains(reason), "{address}: {error}");
            assert!(!error.contains("secret"), "{error}");
        }
        for address in ["s3://bucket/a%20b.dsm", "http://127.0.0.1:1/f", "abfss://c@a.host.net/f"] {
            assert!(Address::parse(address).is_ok(), "{address}");
        }
    }

    #[test]
    fn plain_http_is_for_addresses_that_say_so() {
        let address = Address::parse("http://127.0.0.1:1/f").unwrap();
        assert!(address.connect(Duration::from_secs(1), Retries::Caller).is_ok());
        assert!(address.is_plain_http());
    }
}
