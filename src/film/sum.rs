//! The sum of a pixel's samples, in an order that a split into chunks can repeat.

use glam::Vec3;

/// Samples that are added one after the other; a split by samples goes by whole chunks.
pub const CHUNK: u32 = 16;

/// Sums a pixel's samples: in sample order within a chunk, chunks by a binary tree over
/// the chunk's index, in which a missing right child adds nothing.
///
/// Kept as a binary counter: `partial` holds the sums of complete subtrees, largest first.
#[derive(Clone, Debug, Default)]
pub struct PixelSum {
    chunk: Vec3,
    samples: u32,
    partial: Vec<Vec3>,
}

impl PixelSum {
    /// Adds the next sample.
    #[inline]
    pub fn add(&mut self, radiance: Vec3) {
        self.add_all(std::iter::once(radiance));
    }

    /// Adds the next samples.
    pub fn add_all(&mut self, radiances: impl Iterator<Item = Vec3>) {
        // Not in `self` meanwhile, where each sum would wait for memory.
        let (mut chunk, mut samples) = (self.chunk, self.samples);
        for radiance in radiances {
            chunk += radiance;
            samples += 1;
            if samples.is_multiple_of(CHUNK) {
                (self.chunk, self.samples) = (chunk, samples);
                self.close_chunk();
                chunk = Vec3::ZERO;
            }
        }
        (self.chunk, self.samples) = (chunk, samples);
    }

    fn close_chunk(&mut self) {
        let mut sum = std::mem::take(&mut self.chunk);
        // Each trailing 1 of the number of chunks before this one is a left sibling.
        let before = (self.samples / CHUNK) - 1;
        for _ in 0..before.trailing_ones() {
            let left = self.partial.pop().expect("a subtree for each 1 of the counter");
            sum = left + sum;
        }
        self.partial.push(sum);
    }

    /// Mean of the samples so far; black without samples. Starts over.
    pub fn take_mean(&mut self) -> Vec3 {
        let samples = self.samples;
        let mut sum = if samples.is_multiple_of(CHUNK) { None } else { Some(self.chunk) };
        while let Some(left) = self.partial.pop() {
            sum = Some(sum.map_or(left, |right| left + right));
        }
        (self.chunk, self.samples) = (Vec3::ZERO, 0);
        sum.map_or(Vec3::ZERO, |sum| sum / samples as f32)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::random::Stream;

    /// The definition: node (level, index) is the sum of its children, if they exist.
    fn tree(chunks: &[Vec3], level: u32, index: usize) -> Option<Vec3> {
        if level == 0 {
            return chunks.get(index).copied();
        }
        let left = tree(chunks, level - 1, 2 * index)?;
        Some(tree(chunks, level - 1, 2 * index + 1).map_or(left, |right| left + right))
    }

    #[test]
    fn sums_follow_the_tree_for_every_number_of_samples() {
        let mut random = Stream::new(4);
        let samples: Vec<Vec3> = (0..700)
            .map(|_| Vec3::new(random.uniform(), random.between(0.0, 1e4), random.uniform()))
            .collect();
        let mut sum = PixelSum::default();
        for n in 1..=samples.len() {
            let chunks: Vec<Vec3> = samples[..n]
                .chunks(CHUNK as usize)
                .map(|chunk| chunk.iter().fold(Vec3::ZERO, |sum, s| sum + s))
                .collect();
            for s in &samples[..n] {
                sum.add(*s);
            }
            let want = tree(&chunks, 10, 0).unwrap() / n as f32;
            assert_eq!(sum.take_mean(), want, "{n} samples");
            let (first, others) = samples[..n].split_at(n * 3 / 5);
            sum.add_all(first.iter().copied());
            sum.add_all(others.iter().copied());
            assert_eq!(sum.take_mean(), want, "{n} samples at once");
        }
        assert_eq!(sum.take_mean(), Vec3::ZERO);
    }
}
