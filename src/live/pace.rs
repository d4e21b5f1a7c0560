//! The number of pixels that frames trace, so that they come at a wanted rate.

use std::time::Duration;

/// The least share of the output's pixels that a frame traces.
const LEAST: f64 = 0.25;
/// Sides change in steps of this share.
const STEPS: f64 = 16.0;

/// Chooses the size of frames by the time that earlier ones took.
#[derive(Debug)]
pub(crate) struct Pace {
    /// Seconds that a frame may take.
    target: f64,
    /// Seconds that a pixel takes.
    per_pixel: Option<f64>,
}

impl Pace {
    /// For this many frames per second.
    pub(crate) fn new(rate: f64) -> Self {
        Self { target: 1.0 / rate, per_pixel: None }
    }

    /// Notes that a frame of so many pixels took this time.
    pub(crate) fn note(&mut self, pixels: u64, time: Duration) {
        let now = time.as_secs_f64() / pixels.max(1) as f64;
        // The first frames of a run are slow, and single ones are disturbed.
        self.per_pixel = Some(self.per_pixel.map_or(now, |before| 0.75 * before + 0.25 * now));
    }

    /// The size of the next frame of an output of this size.
    pub(crate) fn size(&self, [width, height]: [u32; 2]) -> [u32; 2] {
        let all = f64::from(width) * f64::from(height);
        let share = self.per_pixel.map_or(LEAST, |seconds| self.target / (seconds * all));
        let side = (share.clamp(LEAST, 1.0).sqrt() * STEPS).floor() / STEPS;
        [width, height].map(|whole| (f64::from(whole) * side).ceil() as u32)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_shrink_to_a_quarter_of_the_pixels_at_most() {
        let mut pace = Pace::new(20.0);
        // A tenth of a second for the whole output is twice too long.
        (0..40).for_each(|_| pace.note(1000, Duration::from_micros(100)));
        let [width, height] = pace.size([1280, 720]);
        let pixels = f64::from(width * height);
        assert!(pixels <= 500_000.0 && pixels > 400_000.0, "{width} x {height}");
        (0..40).for_each(|_| pace.note(1000, Duration::from_millis(100)));
        assert_eq!(pace.size([1280, 720]), [640, 360]);
        (0..40).for_each(|_| pace.note(1000, Duration::from_micros(1)));
        assert_eq!(pace.size([1280, 720]), [1280, 720]);
        assert_eq!(pace.size([1, 1]), [1, 1]);
    }
}
