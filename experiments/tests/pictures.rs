//! Pictures and their comparison, small.

#![cfg(test)]

use dsm_experiments::pictures::{Comparison, strip};

#[test]
fn rendered_shadows_are_close_to_traced_ones() {
    let small = Comparison {
        map_side: 192,
        map_samples: 16,
        resolution: [48, 27],
        camera_rays: 16,
        moving_rays: 4,
    };
    for (scene, most) in [("spinning-sphere", 0.04), ("stained-glass", 0.05)] {
        let row = small.measure(scene).unwrap();
        for difference in row.differences {
            assert!(difference.rmse > 0.0 && difference.rmse < most, "{scene}: {difference:?}");
            assert!(difference.mean.abs() < 0.01, "{scene}: {difference:?}");
        }
        let [off, traced] = row.pictures;
        assert_eq!(off.size(), traced.size());
        assert!(traced.pixels().iter().any(|pixel| pixel[0] < 0.5), "{scene} has a shadow");
    }
}

#[test]
fn a_strip_stands_side_by_side() {
    let image = strip(12, 2).unwrap();
    assert_eq!(image.size(), [160, 40]);
    // The ball that stands still has the same shadow; the other one has not.
    let pixel = |x: usize, y: usize| image.pixels()[y * 160 + x][0];
    let difference = |columns: std::ops::Range<usize>| -> f32 {
        let pixels = columns.flat_map(|x| (0..40).map(move |y| (x, y)));
        pixels.map(|(x, y)| (pixel(x, y) - pixel(x + 80, y)).abs()).sum()
    };
    let [still, moving] = [difference(0..35), difference(35..80)];
    assert!(moving > 5.0 * still, "{still} {moving}");
    assert!(strip(13, 2).is_err());
}
