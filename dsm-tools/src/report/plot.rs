//! The plot of a report: the error of each picture, as bars.

use super::html::escaped;

/// Bars of values with their names, the largest of which is as long as the drawing; as SVG.
pub(super) fn bars(title: &str, values: &[(String, f64)]) -> String {
    const ROW: usize = 26;
    let largest = values.iter().map(|(_, value)| *value).fold(0.0, f64::max);
    let height = values.len() * ROW + 30;
    let mut svg = format!(
        "<svg viewBox=\"0 0 720 {height}\" role=\"img\" aria-label=\"{0}\"><title>{0}</title>\n\
         <text x=\"0\" y=\"16\" class=\"head\">{0}</text>\n",
        escaped(title)
    );
    for (row, (name, value)) in values.iter().enumerate() {
        let y = 30 + row * ROW;
        let width = if largest > 0.0 { 390.0 * value / largest } else { 0.0 };
        svg += &format!(
            "<text x=\"240\" y=\"{}\" text-anchor=\"end\">{}</text>\
             <rect x=\"250\" y=\"{y}\" width=\"{width:.1}\" height=\"18\"/>\
             <text x=\"{:.1}\" y=\"{}\">{value:.4}</text>\n",
            y + 14,
            escaped(name),
            256.0 + width,
            y + 14,
        );
    }
    svg + "</svg>"
}
