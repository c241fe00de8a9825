//! Contracts across the libraries: see the tests of this package, which share
//! what stands here.

pub mod forge;
pub mod fuzz;
pub mod golden;

/// An error with its causes in one line, as the program prints it.
#[must_use]
pub fn whole_message(error: dsm_io::Error) -> String {
    format!("{:#}", anyhow::Error::from(error))
}

/// The examples of all READMEs compile, and run where they can.
#[cfg(doctest)]
mod readmes {
    #[doc = include_str!("../../README.md")]
    pub struct Workspace;
    #[doc = include_str!("../../deep-exr/README.md")]
    pub struct DeepExr;
    #[doc = include_str!("../../deepshadow/README.md")]
    pub struct Deepshadow;
    #[doc = include_str!("../../dsm-core/README.md")]
    pub struct DsmCore;
    #[doc = include_str!("../../dsm-io/README.md")]
    pub struct DsmIo;
    #[doc = include_str!("../../dsm-scene/README.md")]
    pub struct DsmScene;
    #[doc = include_str!("../../dsm-trace/README.md")]
    pub struct DsmTrace;
    #[doc = include_str!("../../mtsm/README.md")]
    pub struct Mtsm;
    #[doc = include_str!("../../shadow-maps/README.md")]
    pub struct ShadowMaps;
    #[doc = include_str!("../testkit/README.md")]
    pub struct Testkit;
}
