//! The page's text.

use anyhow::{Result, ensure};
use deepshadow::ShadowMap;
use serde::Serialize;

use super::Page;
use super::embedded::{Embedded, EmbeddedLevel};
use crate::output::summary::Summary;

const FRAME: &str = include_str!("web/page.html");
const STYLE: &str = include_str!("web/page.css");
/// In the order in which they stand in the page's one script.
const SCRIPTS: [&str; 12] = [
    include_str!("web/unpack.js"),
    include_str!("web/field.js"),
    include_str!("web/fragments.js"),
    include_str!("web/palette.js"),
    include_str!("web/panel.js"),
    include_str!("web/curve.js"),
    include_str!("web/histogram.js"),
    include_str!("web/camera.js"),
    include_str!("web/metadata.js"),
    include_str!("web/picture.js"),
    include_str!("web/viewer.js"),
    include_str!("web/start.js"),
];

/// What the page is told in JSON.
#[derive(Serialize)]
struct Data<'a> {
    maps: Vec<MapData<'a>>,
    notes: &'a [String],
    difference: Option<PageDifference>,
}

#[derive(Serialize)]
struct MapData<'a> {
    name: &'a str,
    summary: Summary<'a>,
    levels: Vec<EmbeddedLevel>,
}

/// How far two maps are apart.
#[derive(Clone, Copy, Debug, Serialize)]
pub(crate) struct PageDifference {
    pub(crate) max: f64,
    pub(crate) mean: f64,
    pub(crate) worst: Option<WorstPlace>,
}

/// Where they are farthest apart.
#[derive(Clone, Copy, Debug, Serialize)]
pub(crate) struct WorstPlace {
    pub(crate) level: u32,
    pub(crate) x: u32,
    pub(crate) y: u32,
    pub(crate) z: f32,
}

impl Page<'_> {
    /// The page, and what it leaves out.
    pub(super) fn html(&self) -> Result<(String, Vec<String>)> {
        let maps: Vec<&ShadowMap> = self.maps.iter().map(|(_, map)| *map).collect();
        ensure!(
            maps.windows(2).all(|pair| pair[0].size() == pair[1].size()),
            "maps of different sizes have no difference to show"
        );
        let summaries = maps.iter().map(|map| Summary::new(map)).collect::<Result<Vec<_>, _>>()?;
        let about = serde_json::to_string(&summaries)?.len() as u64;
        let code = (FRAME.len() + STYLE.len() + SCRIPTS.concat().len()) as u64;
        let embedded = Embedded::new(&maps, self.limit.0.saturating_sub(about + code + 2000))?;
        let notes: Vec<String> = embedded
            .note
            .iter()
            .map(|note| format!("{note} (--max-size {})", self.limit))
            .collect();
        let columns: Vec<String> =
            embedded.levels.iter().flatten().map(EmbeddedLevel::element).collect();
        let of_maps = self.maps.iter().zip(summaries).zip(embedded.levels);
        let maps = of_maps
            .map(|(((name, _), summary), levels)| MapData { name, summary, levels })
            .collect();
        let data = Data { maps, notes: &notes, difference: self.difference };
        // No text of a file ends the element that it stands in.
        let data = serde_json::to_string(&data)?.replace('<', "\\u003c");
        let names: Vec<&str> = self.maps.iter().map(|(name, _)| name.as_str()).collect();
        let document = fill(&[
            ("title", &escaped(&names.join(" and "))),
            ("style", STYLE.trim_end()),
            ("data", &data),
            ("columns", &columns.join("\n")),
            ("script", SCRIPTS.concat().trim_end()),
        ]);
        Ok((document, notes))
    }
}

impl EmbeddedLevel {
    fn element(&self) -> String {
        let id = self.columns_id();
        format!("<script type=\"application/octet-stream\" id=\"{id}\">{}</script>", self.text)
    }
}

/// The frame with its places filled, each once through: what is filled in is not looked at.
fn fill(places: &[(&str, &str)]) -> String {
    let mut document = String::new();
    let mut rest = FRAME;
    while let Some((before, after)) = rest.split_once("{{") {
        document += before;
        let (name, after) = after.split_once("}}").unwrap_or((after, ""));
        document += places.iter().find(|(place, _)| *place == name).map_or("", |(_, text)| text);
        rest = after;
    }
    document + rest
}

/// Text as HTML has it.
fn escaped(text: &str) -> String {
    crate::output::printable(text)
        .replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
        .replace('"', "&quot;")
}
