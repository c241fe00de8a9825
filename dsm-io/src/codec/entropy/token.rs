//! Numbers as tokens and open bits.

/// Number of tokens.
pub(super) const TOKENS: usize = 64;

/// A number's token, what it leaves open, and how many bits that has.
///
/// Numbers below 4 are tokens; of a larger one the token says which bit is its highest
/// and what the next one is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Token {
    pub(super) token: u8,
    pub(super) open: u32,
    pub(super) width: u32,
}

impl Token {
    pub(super) const fn of(number: u32) -> Self {
        if number < 4 {
            return Self { token: number as u8, open: 0, width: 0 };
        }
        let width = number.ilog2() - 1;
        let token = (2 * width + (number >> width)) as u8;
        Self { token, open: number & ((1 << width) - 1), width }
    }
}

/// How many bits a token leaves open.
#[inline(always)]
pub(super) const fn open_width(token: u32) -> u32 {
    (token >> 1).saturating_sub(1)
}

/// The least number of each token: what it leaves open is added.
pub(super) const LEAST: [u32; TOKENS] = {
    let mut least = [0; TOKENS];
    let mut token = 0;
    while token < TOKENS as u32 {
        least[token as usize] =
            if token < 4 { token } else { (2 + (token & 1)) << open_width(token) };
        token += 1;
    }
    least
};

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_come_back() {
        let powers = (0..32).flat_map(|bit| [1_u32 << bit, (1 << bit) - 1, 3 << bit >> 1]);
        for expected in (0..5000).chain(powers).chain([u32::MAX]) {
            let Token { token, open, width } = Token::of(expected);
            assert!(usize::from(token) < TOKENS);
            assert_eq!(open_width(token.into()), width);
            assert_eq!(LEAST[usize::from(token)] + open, expected);
        }
    }
}
