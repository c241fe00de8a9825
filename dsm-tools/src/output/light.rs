//! What a lookup answers, as CSV.

use std::io::Write;

/// The header of the columns of values with this number of channels.
pub(crate) const fn header(channels: usize) -> &'static [u8] {
    if channels == 1 { b"v\n" } else { b"r,g,b\n" }
}

/// Appends the channels of a value as a line of CSV.
pub(crate) fn append_line(channels: &[f32], lines: &mut Vec<u8>) {
    for (index, &value) in channels.iter().enumerate() {
        if index > 0 {
            lines.push(b',');
        }
        append_number(value, lines);
    }
    lines.push(b'\n');
}

/// Appends a number of [0, 1] with 9 significant digits, so that it reads
/// back as the same `f32`; zeros at the end are left out.
fn append_number(value: f32, text: &mut Vec<u8>) {
    if value == 0.0 || value == 1.0 {
        text.push(if value == 0.0 { b'0' } else { b'1' });
        return;
    }
    let mut digits = [0_u8; 24];
    let mut rest = &mut digits[..];
    // Nothing in [0, 1] takes more than 14 bytes: d.dddddddde-dd.
    if write!(rest, "{:.8e}", f64::from(value)).is_err() {
        return;
    }
    let free = rest.len();
    let written = &digits[..digits.len() - free];
    let exponent_at = written.iter().position(|&byte| byte == b'e').unwrap_or(written.len());
    let (mantissa, exponent) = written.split_at(exponent_at);
    let end = mantissa.iter().rposition(|&byte| byte != b'0').map_or(0, |last| last + 1);
    let mantissa = &mantissa[..end];
    match exponent {
        b"e-1" | b"e-2" | b"e-3" | b"e-4" => {
            text.extend_from_slice(&b"0.000"[..usize::from(exponent[2] - b'0') + 1]);
            text.extend(mantissa.iter().filter(|&&byte| byte != b'.'));
        }
        _ => {
            text.extend_from_slice(mantissa.strip_suffix(b".").unwrap_or(mantissa));
            text.extend_from_slice(exponent.strip_prefix(b"e0").unwrap_or(exponent));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn line(channels: &[f32]) -> String {
        let mut lines = Vec::new();
        append_line(channels, &mut lines);
        String::from_utf8(lines).unwrap()
    }

    #[test]
    fn numbers_have_nine_digits_at_most() {
        for (value, text) in [
            (0.0, "0"),
            (1.0, "1"),
            (0.5, "0.5"),
            (0.1, "0.100000001"),
            (1.0 / 3.0, "0.333333343"),
            (0.012_5, "0.0125000002"),
            (1e-4, "9.99999975e-5"),
            (1.5e-4, "0.000150000007"),
            (2.0_f32.powi(-20), "9.53674316e-7"),
            (1.0_f32.next_down(), "0.99999994"),
            (f32::from_bits(1), "1.40129846e-45"),
        ] {
            assert_eq!(line(&[value]), format!("{text}\n"));
        }
        assert_eq!(line(&[0.25, 1.0, 0.0]), "0.25,1,0\n");
        assert_eq!((header(1), header(3)), (&b"v\n"[..], &b"r,g,b\n"[..]));
    }

    proptest! {
        #![proptest_config(dsm_testkit::config(0x1167))]

        #[test]
        fn numbers_read_back_the_same(bits in 0..=1.0_f32.to_bits()) {
            let value = f32::from_bits(bits);
            prop_assert_eq!(line(&[value]).trim().parse(), Ok(value));
        }
    }
}
