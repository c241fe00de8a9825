//! The switches that choose what is read of an image.

use clap::Args;
use deepshadow::files::deep_exr::Selection;
use deepshadow::files::deep_exr::detail::ChannelNames;

/// Part, layer and channels of an OpenEXR image.
#[derive(Debug, Args)]
pub(super) struct SelectionFlags {
    /// The part of an .exr to read [default: the first deep one]
    #[arg(long, value_name = "NAME")]
    part: Option<String>,
    /// The layer of an .exr whose depth and opacity are read: what stands before
    /// the last dot of its channels' names [default: none, else the only one that
    /// has a depth]
    #[arg(long, value_name = "NAME")]
    layer: Option<String>,
    /// The channels of an .exr to read, as KEY=NAME with the keys Z, ZBack, A, AR,
    /// AG and AB, separated by commas; without a NAME none
    #[arg(long, value_name = "Z=NAME,A=NAME", value_parser = channels)]
    channels: Option<ChannelNames>,
}

impl SelectionFlags {
    /// Whether something is chosen.
    pub(super) fn is_given(&self) -> bool {
        self.part.is_some() || self.layer.is_some() || self.channels.is_some()
    }
}

impl From<SelectionFlags> for Selection {
    fn from(flags: SelectionFlags) -> Self {
        let mut selection = Self::from(flags.part.as_deref());
        selection.layer = flags.layer;
        selection.channels = flags.channels.unwrap_or_default();
        selection
    }
}

fn channels(text: &str) -> Result<ChannelNames, String> {
    text.parse().map_err(|error: deepshadow::files::deep_exr::Error| error.to_string())
}
