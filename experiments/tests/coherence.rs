//! Coherent sampling in small: what it shows must hold there too.

#![cfg(test)]

use dsm_experiments::coherence::{Effort, page};

#[test]
fn rays_are_saved_and_little_is_missed() {
    let page = page(&Effort::small(), &[]).unwrap();
    let rows: Vec<Vec<&str>> = page
        .text
        .lines()
        .filter(|line| line.starts_with("| ") && line.contains(" µ") || line.contains(" % |"))
        .map(|line| line.trim_matches('|').split('|').map(str::trim).collect())
        .collect();
    let traced: Vec<_> = rows.iter().filter(|row| row.len() == 10 && row[2] != "cells").collect();
    // Three scenes, three tracers, two numbers of cells.
    assert_eq!(traced.len(), 18, "{rows:?}");
    for row in traced {
        let number = |column: usize| row[column].trim_end_matches(" %").parse::<f64>().unwrap();
        let (cells, rays) = (number(2), number(3));
        let most = if cells == 16.0 { 0.9 } else { 0.65 };
        assert!(rays < most * cells, "{row:?}");
        assert!(number(6) < 0.01, "{row:?}");
    }
    // Of figure 9: nothing is missed where every cell is traced.
    let missed: Vec<_> = rows.iter().filter(|row| row.len() == 6).collect();
    assert_eq!(missed.len(), 8, "{rows:?}");
    for row in missed {
        let is_whole = row[3] == "100 %";
        assert_eq!(is_whole, row[4] == "0.0000", "{row:?}");
        assert!(row[4].parse::<f64>().unwrap() < 0.05, "{row:?}");
    }
    assert_eq!(page.pictures.len(), 1);
    assert!(page.pictures[0].1.len() > 100);
}
