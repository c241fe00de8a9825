//! Attenuation maps and traced views in small: what they show must hold there too.

#![cfg(test)]

use dsm_experiments::attenuation::{Effort, page};

/// The numbers of a table's rows below a heading, by column.
fn rows<'a>(text: &'a str, heading: &str) -> Vec<Vec<&'a str>> {
    let (_, after) = text.split_once(heading).unwrap();
    let lines = after.lines().skip_while(|line| !line.starts_with('|'));
    let lines = lines.take_while(|line| line.starts_with('|')).skip(2);
    lines.map(|line| line.trim_matches('|').split('|').map(str::trim).collect()).collect()
}

#[test]
fn the_page_shows_what_was_measured() {
    let page = page(&Effort::small(), &[]).unwrap();
    for scene in ["foliage", "flower", "knot"] {
        let made = rows(&page.text, &format!("### {scene}:"));
        let number = |row: usize, column: usize| made[row][column].parse::<f64>().unwrap();
        assert_eq!(made.len(), 2, "1 and 4 points of the light");
        // Deeper with more, though not by much, and closer to traced shadows.
        assert!(number(1, 3) > number(0, 3) && number(1, 3) < 6.0, "{made:?}");
        assert!(number(1, 5) > 0.0 && number(1, 5) < 0.3, "{made:?}");
        assert!(number(1, 5) < number(0, 5), "{made:?}");
        let traced = rows(&page.text, &format!("### {scene}\n"));
        let column = |column: usize| -> Vec<f64> {
            traced.iter().map(|row| row[column].parse().unwrap()).collect()
        };
        let (steps, errors) = (column(3), column(5));
        let by = |name: &str| traced.iter().position(|row| row[0] == name).unwrap();
        let [naive, plain, all] =
            ["from pixel to pixel", "hierarchy alone: the paper's base", "all"].map(by);
        // Times of a busy machine prove nothing; what is looked at does.
        assert!(steps[all] < steps[plain], "{traced:?}");
        assert_eq!(errors[naive], errors[plain], "a hierarchy changes no answer");
        assert!(errors.iter().all(|&error| error < 0.3), "{traced:?}");
    }
    let pictures: Vec<_> = page.pictures.iter().map(|(path, _)| path.as_str()).collect();
    let expected =
        ["results/attenuation.svg", "images/attenuation.png", "images/attenuation-artefacts.png"];
    assert_eq!(pictures, expected);
    assert!(page.pictures.iter().all(|(_, bytes)| bytes.len() > 300));
}
