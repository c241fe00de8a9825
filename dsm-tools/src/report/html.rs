//! The page of a report.

use anyhow::Result;
use serde_json::Value;

use super::picture::{self, GAIN};
use super::{MapEntry, Picture, Report, plot};
use crate::output::printable;

const STYLE: &str = include_str!("report.css");

/// Text as HTML has it.
pub(super) fn escaped(text: &str) -> String {
    printable(text)
        .replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
        .replace('"', "&quot;")
}

impl Report {
    /// The page: a function of the report, without any time but those that it shows.
    pub(crate) fn html(&self) -> Result<String> {
        let title = escaped(&self.title);
        let mut page = format!(
            "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
             <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
             <meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; \
             style-src 'unsafe-inline'; img-src data:\">\n<link rel=\"icon\" href=\"data:,\">\n\
             <title>{title}</title>\n<style>\n{STYLE}</style>\n</head>\n<body>\n<main>\n\
             <h1>{title}</h1>\n"
        );
        for sentence in &self.about {
            page += &format!("<p>{}</p>\n", escaped(sentence));
        }
        if !self.pictures.is_empty() {
            page += &self.table();
            page += &self.plot();
        }
        if !self.left_out.is_empty() {
            page += "<h2>Left out</h2>\n<ul>\n";
            for (method, reason) in &self.left_out {
                page += &format!("<li>{}: {}</li>\n", escaped(method), escaped(reason));
            }
            page += "</ul>\n";
        }
        page += &self.gallery()?;
        page += "<h2>Maps</h2>\n";
        for map in &self.maps {
            page += &map.section()?;
        }
        Ok(page + "</main>\n</body>\n</html>\n")
    }

    /// Errors of all pictures, and what they took.
    fn table(&self) -> String {
        let mut heads =
            vec!["method", "map", "map's bytes", "RMSE", "mean", "mean absolute", "max"];
        if self.times {
            heads.extend(["bake s", "open s", "render s", "peak memory MiB"]);
        }
        let rows = self.reference.iter().chain(&self.pictures).map(|picture| self.row(picture));
        table("Pictures", &heads, rows)
    }

    fn row(&self, picture: &Picture) -> Vec<String> {
        let map = picture.map.as_ref();
        let bytes = map.and_then(|name| self.maps.iter().find(|map| map.name == *name));
        let mut cells = vec![
            picture.method.clone(),
            map.cloned().unwrap_or_default(),
            bytes.map_or_else(String::new, |map| map.bytes.to_string()),
        ];
        let is_reference =
            self.reference.as_ref().is_some_and(|reference| std::ptr::eq(reference, picture));
        match self.difference(picture).filter(|_| !is_reference) {
            Some(found) => cells.extend(
                [found.rmse, found.mean, found.mean_absolute, found.max]
                    .map(|value| format!("{value:.5}")),
            ),
            None => cells.extend([const { String::new() }; 4]),
        }
        if self.times {
            let cost = picture.cost;
            let seconds = |seconds: f64| format!("{seconds:.2}");
            cells.push(cost.bake_s.map(seconds).unwrap_or_default());
            cells.extend([cost.open_s, cost.render_s].map(seconds));
            let peak = cost.peak.map(|bytes| format!("{:.0}", bytes as f64 / 1_048_576.0));
            cells.push(peak.unwrap_or_default());
        }
        cells
    }

    fn plot(&self) -> String {
        let named = |picture: &Picture| match &picture.map {
            Some(map) => format!("{}, {map}", picture.method),
            None => picture.method.clone(),
        };
        let errors: Vec<_> = self
            .pictures
            .iter()
            .filter_map(|picture| Some((named(picture), self.difference(picture)?.rmse)))
            .collect();
        let mut plots =
            plot::bars("Root mean square error, against rays through the scene", &errors);
        if self.times {
            let seconds: Vec<_> = self
                .pictures
                .iter()
                .map(|picture| (named(picture), picture.cost.render_s))
                .collect();
            plots += &plot::bars("Seconds to render, without the map", &seconds);
        }
        format!("<div class=\"plots\">{plots}</div>\n")
    }

    fn gallery(&self) -> Result<String> {
        let Some(reference) = &self.reference else { return Ok(String::new()) };
        let figure = |address: &str, of: &str, caption: &str| {
            format!(
                "<figure><img src=\"{address}\" alt=\"{}\"><figcaption>{}</figcaption></figure>\n",
                escaped(of),
                escaped(caption)
            )
        };
        let mut gallery = "<h2>Pictures</h2>\n<div class=\"gallery\">\n".to_owned();
        gallery += &figure(&picture::shown(&reference.image)?, "reference", &reference.method);
        gallery += "</div>\n";
        for picture in &self.pictures {
            let map = picture.map.as_ref().map(|map| format!(", {map}")).unwrap_or_default();
            let notes = picture.notes.iter().map(|note| format!("; {note}")).collect::<String>();
            let caption = format!("{}{map}{notes}", picture.method);
            gallery += "<div class=\"gallery\">\n";
            gallery += &figure(&picture::shown(&picture.image)?, &picture.method, &caption);
            let apart = picture::difference(&picture.image, &reference.image)?;
            let rmse = self.difference(picture).map_or(f64::NAN, |found| found.rmse);
            let caption = format!(
                "less the reference, times {GAIN}: darker blue is too dark, lighter orange too \
                 light; RMSE {rmse:.4}"
            );
            gallery += &figure(&apart, &format!("{} less the reference", picture.method), &caption);
            gallery += "</div>\n";
        }
        Ok(gallery)
    }
}

impl MapEntry {
    /// What the map is, and what it states of its error.
    fn section(&self) -> Result<String> {
        let mut rows: Vec<Vec<String>> = Vec::new();
        let mut add = |name: &str, value: &Value| {
            if !value.is_null() {
                let text = value.as_str().map_or_else(|| value.to_string(), str::to_owned);
                rows.push(vec![name.replace('_', " "), text]);
            }
        };
        let of = |key: &str| self.summary.get(key).unwrap_or(&Value::Null);
        for key in [
            "kind",
            "width",
            "height",
            "channels",
            "codec",
            "block",
            "tile",
            "tolerance",
            "samples",
            "filter",
            "compression",
            "depth",
            "light",
            "layering",
            "coverage",
            "filtering",
            "light_samples",
            "contents",
            "software",
        ] {
            add(key, of(key));
        }
        add("bytes", &self.bytes.into());
        for (name, attribute) in of("attributes").as_object().into_iter().flatten() {
            add(name, attribute.get("value").unwrap_or(&Value::Null));
        }
        for note in &self.notes {
            add("note", &note.clone().into());
        }
        let mut section = format!("<h3>{}</h3>\n", escaped(&self.name));
        if let Some(slice) = &self.slice {
            let address = picture::shown(slice)?;
            section += &format!(
                "<figure><img src=\"{address}\" alt=\"light behind everything\"><figcaption>The \
                 light that is left behind everything</figcaption></figure>\n"
            );
        }
        section += &table("Settings", &["what", "value"], rows.into_iter());
        let heads = [
            "level",
            "width",
            "height",
            "tolerance",
            "max_error",
            "mean_error",
            "error_at_depth",
            "vertices",
            "bytes",
        ];
        let levels = of("levels").as_array().map_or(&[][..], Vec::as_slice);
        let rows = levels.iter().enumerate().map(|(index, level)| {
            let cells = heads[1..]
                .iter()
                .map(|key| level.get(*key).map_or_else(String::new, Value::to_string));
            std::iter::once(index.to_string()).chain(cells).collect()
        });
        section += &table("Stated errors of its levels", &heads, rows);
        Ok(section)
    }
}

fn table(caption: &str, heads: &[&str], rows: impl Iterator<Item = Vec<String>>) -> String {
    let mut text = format!(
        "<div class=\"scroll\" tabindex=\"0\" role=\"region\" aria-label=\"{0}\"><table>\n\
         <caption>{0}</caption>\n<thead><tr>",
        escaped(caption)
    );
    for head in heads {
        text += &format!("<th scope=\"col\">{}</th>", escaped(&head.replace('_', " ")));
    }
    text += "</tr></thead>\n<tbody>\n";
    for row in rows {
        text += "<tr>";
        for (column, cell) in row.iter().enumerate() {
            let cell = escaped(cell);
            text += &if column == 0 {
                format!("<th scope=\"row\">{cell}</th>")
            } else {
                format!("<td>{cell}</td>")
            };
        }
        text += "</tr>\n";
    }
    text + "</tbody></table></div>\n"
}
