//! Which channels carry depth and opacity.

use exr::meta::attribute::{ChannelList, SampleType};

use super::choice::{ChannelChoice, Opacity};
use super::part::RawPart;
use crate::channel::{AlphaChannels, Channel, ChannelType};
use crate::error::Result;
use crate::rows::{Column, DeepRows};

/// A channel that is read, and where it stands among the others.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct ColumnSource {
    /// Words of the channels before it, for one sample.
    pub(super) words_before: usize,
    pub(super) channel_type: ChannelType,
    pub(super) column: Column,
}

/// How the columns of the answer are filled from a chunk.
#[derive(Clone, Debug)]
pub(super) struct ChannelPlan {
    sources: Vec<ColumnSource>,
    alpha: AlphaChannels,
    channel_words: Vec<usize>,
}

impl ChannelPlan {
    /// The plan that reads these of a part's channels.
    pub(super) fn new(channels: &[Channel], choice: &ChannelChoice) -> Self {
        let mut columns = vec![(Column::Z, Some(choice.z)), (Column::ZBack, choice.z_back)];
        let alpha = match choice.opacity {
            Opacity::None => AlphaChannels::None,
            Opacity::Mono(mono) => {
                columns.push((Column::Alpha, Some(mono)));
                AlphaChannels::Mono
            }
            Opacity::Colour(colours) => {
                let targets = [Column::Red, Column::Green, Column::Blue];
                columns.extend(targets.into_iter().zip(colours.map(Some)));
                AlphaChannels::Colour
            }
        };
        let words = |some: &[Channel]| some.iter().map(|c| c.channel_type.words()).sum();
        let source = |(column, index): (Column, Option<usize>)| {
            let index = index?;
            Some(ColumnSource {
                words_before: words(&channels[..index]),
                channel_type: channels[index].channel_type,
                column,
            })
        };
        Self {
            sources: columns.into_iter().filter_map(source).collect(),
            alpha,
            channel_words: channels.iter().map(|c| c.channel_type.words()).collect(),
        }
    }

    pub(super) fn sources(&self) -> &[ColumnSource] {
        &self.sources
    }

    pub(super) fn alpha_channels(&self) -> AlphaChannels {
        self.alpha
    }

    pub(super) fn has_z_back(&self) -> bool {
        self.sources.iter().any(|source| source.column == Column::ZBack)
    }

    /// Room for the answer, without pixels.
    pub(super) fn rows(&self, width: u32) -> DeepRows {
        DeepRows::new(width, self.alpha, self.has_z_back())
    }

    /// 16-bit words of one sample, all channels.
    pub(super) fn words_per_sample(&self) -> usize {
        self.channel_words.iter().sum()
    }

    /// 16-bit words of a value, of each channel in the file's order.
    pub(super) fn channel_words(&self) -> &[usize] {
        &self.channel_words
    }

    /// Bytes of one sample, all channels.
    pub(super) fn bytes_per_sample(&self) -> u64 {
        2 * self.words_per_sample() as u64
    }
}

/// The channels in the order in which chunks store them, checked.
pub(super) fn describe(part: &RawPart, channels: &ChannelList) -> Result<Vec<Channel>> {
    let mut listed = Vec::with_capacity(channels.list.len());
    for (index, channel) in channels.list.iter().enumerate() {
        let name = String::from_utf8_lossy(channel.name.as_slice()).into_owned();
        if (channel.sampling.x(), channel.sampling.y()) != (1, 1) {
            return Err(part.error("channels", format!("channel '{name}' is subsampled")));
        }
        let earlier = index.checked_sub(1).map(|before| channels.list[before].name.as_slice());
        if earlier.is_some_and(|earlier| earlier >= channel.name.as_slice()) {
            return Err(part.error("channels", format!("channel '{name}' is not in order")));
        }
        let channel_type = match channel.sample_type {
            SampleType::F16 => ChannelType::Half,
            SampleType::F32 => ChannelType::Float,
            SampleType::U32 => ChannelType::Uint,
        };
        listed.push(Channel { name, channel_type });
    }
    Ok(listed)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::selection::Selection;

    fn plan(names: &[&str]) -> ChannelPlan {
        let channels: Vec<_> = names
            .iter()
            .map(|&name| Channel {
                name: name.to_owned(),
                channel_type: if name.starts_with('Z') {
                    ChannelType::Float
                } else {
                    ChannelType::Half
                },
            })
            .collect();
        let choice = ChannelChoice::find(names, &Selection::default(), false).unwrap();
        ChannelPlan::new(&channels, &choice)
    }

    fn words_before(plan: &ChannelPlan) -> Vec<(Column, usize)> {
        plan.sources().iter().map(|source| (source.column, source.words_before)).collect()
    }

    #[test]
    fn mono_alpha_and_back_depth() {
        let plan = plan(&["A", "B", "Z", "ZBack"]);
        assert_eq!(plan.alpha_channels(), AlphaChannels::Mono);
        assert_eq!(words_before(&plan), [(Column::Z, 2), (Column::ZBack, 4), (Column::Alpha, 0)]);
        assert_eq!((plan.words_per_sample(), plan.bytes_per_sample()), (6, 12));
    }

    #[test]
    fn coloured_alphas_win_and_a_fills_the_gaps() {
        let own = plan(&["A", "AB", "AG", "AR", "Z"]);
        let colours = [(Column::Z, 4), (Column::Red, 3), (Column::Green, 2), (Column::Blue, 1)];
        assert_eq!(words_before(&own), colours);
        let red_only = plan(&["A", "AR", "Z"]);
        assert_eq!(red_only.alpha_channels(), AlphaChannels::Colour);
        let colours = [(Column::Z, 2), (Column::Red, 1), (Column::Green, 0), (Column::Blue, 0)];
        assert_eq!(words_before(&red_only), colours);
        // Without A, the only opacity is that of all colours.
        let no_mono = plan(&["AG", "Z"]);
        assert_eq!(words_before(&no_mono), [(Column::Z, 1), (Column::Alpha, 0)]);
    }
}
