//! The paper's figures in small: what they show must hold there too.

use dsm_experiments::figures::{Bakes, Effort, Figure7, Figure8, Figure9, Report, Stage};

#[test]
fn figures_show_what_the_paper_shows() {
    let stage = Stage::new(Effort::small()).unwrap();
    assert!(stage.receivers.len() > 1500, "{}", stage.receivers.len());
    let mut bakes = Bakes::new().unwrap();
    let figure = Figure7::measure(&stage, &mut bakes).unwrap();
    figure_7(&figure, &figure.report().unwrap());
    let figure = Figure8::measure(&stage, &mut bakes).unwrap();
    figure_8(&figure, &figure.report().unwrap());
    let figure = Figure9::measure(&stage, &mut bakes).unwrap();
    figure_9(&figure, &figure.report().unwrap());
}

fn figure_7(figure: &Figure7, report: &Report) {
    let rows = &figure.rows;
    assert_eq!(rows.len(), 4);
    for row in rows {
        // The paper's expected error is that of the worst pixel.
        let noise = 0.5 / f64::from(row.side);
        for error in row.error {
            assert!(error.root_mean_square < noise, "{row:?}");
            assert!(error.max < 4.0 * noise, "{row:?}");
            assert!(error.root_mean_square > 0.05 * noise, "{row:?}");
        }
        assert!(row.deep_bytes[1] > row.deep_bytes[0]);
        assert!(row.exact_bytes > row.deep_bytes[0], "{row:?}");
    }
    for pair in rows.windows(2) {
        for method in 0..2 {
            let [before, after] = [0, 1].map(|i| pair[i].error[method].root_mean_square);
            assert!(after < before, "{pair:?}");
        }
        // Four times the samples; the deep map grows far less.
        assert_eq!(pair[1].paper_bytes, 4.0 * pair[0].paper_bytes);
        assert!(pair[1].packed_depths > 3 * pair[0].packed_depths, "{pair:?}");
        assert!(pair[1].deep_bytes[0] < 3 * pair[0].deep_bytes[0], "{pair:?}");
        assert!(pair[1].size_ratio() > pair[0].size_ratio(), "{pair:?}");
    }
    assert!(report.page.contains("| 16 × 16 | 0.0312 |"), "{}", report.page);
    assert_eq!(report.plot.matches("<circle").count(), 8 * 4);
}

fn figure_8(figure: &Figure8, report: &Report) {
    let vertices: Vec<f64> = figure.rows.iter().map(|row| row.hair_vertices).collect();
    assert!(vertices.windows(2).all(|pair| pair[0] < pair[1]), "{vertices:?}");
    assert!((0.05..0.4).contains(&figure.slopes[1]), "{:?}", figure.slopes);
    assert!(figure.slopes[0] < figure.slopes[1] + 0.05, "{:?}", figure.slopes);
    assert!((0.2..0.8).contains(&figure.hair_share), "{}", figure.hair_share);
    assert_eq!(report.plot.matches("<circle").count(), 3 * 4);
}

/// Times of a busy machine prove little: only what differs by much.
fn figure_9(figure: &Figure9, report: &Report) {
    let widths: Vec<f64> = figure.rows.iter().map(|row| row.width).collect();
    assert_eq!(widths, [2.0, 4.0, 8.0, 16.0]);
    assert!(figure.growth_without_mips() > 3.0, "{figure:?}");
    assert!(figure.variation_with_mips() < figure.growth_without_mips(), "{figure:?}");
    let [with_mips, without, _] = figure.rows[3].nanoseconds;
    assert!(with_mips < without, "{figure:?}");
    assert!(report.plot.contains("<circle"));
}
