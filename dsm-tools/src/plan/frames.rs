//! Frames of a sequence, as they are told on the command line.

/// Frames of all ranges, in order and each once.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Frames(pub(crate) Vec<u32>);

/// The most frames of a plan.
const MOST: usize = 1 << 20;

/// Reads `1-8`, `1-100:10` or `1,5,9-12`.
pub(crate) fn frames(text: &str) -> Result<Frames, String> {
    let mut all = Vec::new();
    for range in text.split(',') {
        let (range, step) = range.split_once(':').unwrap_or((range, "1"));
        let (first, last) = range.split_once('-').unwrap_or((range, range));
        let (first, last, step) = (number(first)?, number(last)?, number(step)?);
        if last < first || step == 0 {
            return Err(format!("\"{text}\": ranges are FIRST-LAST or FIRST-LAST:STEP"));
        }
        let steps = (first..=last).step_by(step as usize);
        let count = (last - first) as usize / step as usize + 1;
        if all.len() + count > MOST {
            return Err(format!("a plan has at most {MOST} frames"));
        }
        all.extend(steps);
    }
    all.sort_unstable();
    all.dedup();
    Ok(Frames(all))
}

fn number(text: &str) -> Result<u32, String> {
    text.trim().parse().map_err(|_| format!("\"{text}\" is not the number of a frame"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_have_steps_and_come_in_order() {
        for (text, expected) in [
            ("7", vec![7]),
            ("1-4", vec![1, 2, 3, 4]),
            ("1-10:4,3,2-3", vec![1, 2, 3, 5, 9]),
            ("0-0", vec![0]),
        ] {
            assert_eq!(frames(text), Ok(Frames(expected)), "{text}");
        }
        for text in ["", "a", "4-1", "1-4:0", "1-", "-1", "1-4294967295"] {
            assert!(frames(text).is_err(), "{text}");
        }
    }
}
