//! A picture of linear values.

/// A picture: red, green and blue of every pixel, linear, row by row from the
/// top.
///
/// ```
/// use dsm_scene::detail::Image;
///
/// let image = Image::new([2, 1], vec![[0.0; 3], [0.5; 3]]).expect("two pixels");
/// assert!(image.is_grey());
/// assert_eq!(Image::new([2, 2], vec![[0.0; 3]]), None);
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    size: [u32; 2],
    pixels: Vec<[f32; 3]>,
}

/// The difference between the pixels of two images: the values of one less those of
/// the other, over all pixels and channels.
///
/// ```
/// use dsm_scene::detail::Image;
///
/// let dark = Image::new([1, 1], vec![[0.25; 3]]).expect("one pixel");
/// let light = Image::new([1, 1], vec![[0.75; 3]]).expect("one pixel");
/// let difference = dark.difference(&light).expect("one size");
/// assert_eq!((difference.mean, difference.rmse), (-0.5, 0.5));
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ImageDifference {
    /// The mean.
    pub mean: f64,
    /// The standard deviation around the mean.
    pub standard_deviation: f64,
    /// The mean of the absolute values.
    pub mean_absolute: f64,
    /// The root of the mean square.
    pub rmse: f64,
    /// The largest absolute value.
    pub max: f64,
}

impl Image {
    /// An image of these pixels; `None` if they are not as many as `size`
    /// says.
    #[must_use]
    pub fn new(size: [u32; 2], pixels: Vec<[f32; 3]>) -> Option<Self> {
        let count = size.map(u64::from).iter().product::<u64>();
        (pixels.len() as u64 == count).then_some(Self { size, pixels })
    }

    /// Width and height.
    #[must_use]
    pub const fn size(&self) -> [u32; 2] {
        self.size
    }

    /// All pixels, row by row from the top.
    #[must_use]
    pub fn pixels(&self) -> &[[f32; 3]] {
        &self.pixels
    }

    /// True if red, green and blue are equal in every pixel.
    #[must_use]
    pub fn is_grey(&self) -> bool {
        self.pixels.iter().all(|&[red, green, blue]| red == green && green == blue)
    }

    /// This image beside others of its height, from left to right; `None` for
    /// another height.
    #[must_use]
    pub fn beside(images: &[Self]) -> Option<Self> {
        let height = images.first()?.size[1];
        if images.iter().any(|image| image.size[1] != height) {
            return None;
        }
        let width = images.iter().map(|image| image.size[0]).sum();
        let row = |image: &Self, row: usize| {
            let width = image.size[0] as usize;
            image.pixels[row * width..(row + 1) * width].to_vec()
        };
        let rows = (0..height as usize).flat_map(|y| images.iter().map(move |image| (image, y)));
        Self::new([width, height], rows.flat_map(|(image, y)| row(image, y)).collect())
    }

    /// The difference of this image from `other`; `None` if they differ in size or
    /// hold no pixels. A pixel that is not a number makes the numbers none.
    #[must_use]
    pub fn difference(&self, other: &Self) -> Option<ImageDifference> {
        if self.size != other.size || self.pixels.is_empty() {
            return None;
        }
        let values = |image: &Self| image.pixels.clone().into_iter().flatten();
        let pairs = values(self).zip(values(other));
        let [mut sum, mut absolute, mut squares, mut max] = [0.0_f64; 4];
        for difference in pairs.map(|(a, b)| f64::from(a) - f64::from(b)) {
            sum += difference;
            absolute += difference.abs();
            squares += difference * difference;
            max = max.max(difference.abs());
        }
        if sum.is_nan() {
            max = f64::NAN;
        }
        let count = (3 * self.pixels.len()) as f64;
        let (mean, square) = (sum / count, squares / count);
        Some(ImageDifference {
            mean,
            standard_deviation: (square - mean * mean).max(0.0).sqrt(),
            mean_absolute: absolute / count,
            rmse: square.sqrt(),
            max,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn image(width: u32, values: &[f32]) -> Image {
        let pixels: Vec<_> = values.iter().map(|&value| [value; 3]).collect();
        Image::new([width, values.len() as u32 / width], pixels).unwrap()
    }

    #[test]
    fn differences_are_those_of_a_sum_by_hand() {
        let a = image(2, &[0.5, 0.25, 1.0, 0.0]);
        let b = image(2, &[0.25, 0.5, 0.5, 0.0]);
        let found = a.difference(&b).unwrap();
        // +0.25, −0.25, +0.5, 0.
        assert_eq!((found.mean, found.mean_absolute, found.max), (0.125, 0.25, 0.5));
        assert!((found.rmse - (0.375_f64 / 4.0).sqrt()).abs() < 1e-12);
        let variance = 0.375 / 4.0 - 0.125 * 0.125;
        assert!((found.standard_deviation - f64::sqrt(variance)).abs() < 1e-12);
        assert_eq!(a.difference(&image(1, &[0.0; 4])), None);
        let nan = image(2, &[f32::NAN, 0.0, 0.0, 0.0]).difference(&b).unwrap();
        assert!(nan.rmse.is_nan() && nan.max.is_nan());
    }

    #[test]
    fn images_stand_side_by_side() {
        let both = Image::beside(&[image(1, &[1.0, 2.0]), image(2, &[3.0, 4.0, 5.0, 6.0])]);
        assert_eq!(both.unwrap(), image(3, &[1.0, 3.0, 4.0, 2.0, 5.0, 6.0]));
        assert_eq!(Image::beside(&[image(1, &[1.0]), image(1, &[1.0, 2.0])]), None);
        assert_eq!(Image::new([2, 2], vec![[0.0; 3]; 3]), None);
    }
}
