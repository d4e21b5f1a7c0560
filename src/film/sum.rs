//! Sums of a pixel's samples, in an order that does not depend on how films split the samples.
//!
//! Within a chunk of [`CHUNK`] samples, samples are added one after the other. Chunks are added by
//! a binary tree over their index, in which a missing right child adds nothing. For a range of
//! chunks, a film keeps the sums of the *nodes*: the largest complete subtrees that make up the
//! range, from left to right, at most two per level. The nodes of two neighbouring ranges are
//! enough to compute those of their union.

use std::ops::Range;

/// Number of samples that are added one after the other. Renders can be split by samples only
/// between chunks.
pub(crate) const CHUNK: u32 = 16;

/// The complete chunks of a range of samples, which must start with a chunk.
fn complete(samples: &Range<u32>) -> Range<u32> {
    debug_assert!(samples.start.is_multiple_of(CHUNK), "{samples:?}");
    samples.start / CHUNK..samples.end / CHUNK
}

/// The nodes of a range of chunks, each as its level and its first chunk.
pub(super) fn nodes(chunks: Range<u32>) -> impl Iterator<Item = (u32, u32)> {
    let mut first = chunks.start;
    std::iter::from_fn(move || {
        let length = chunks.end.saturating_sub(first).checked_ilog2()?;
        let (level, here) = (length.min(first.trailing_zeros()), first);
        first += 1 << level;
        Some((level, here))
    })
}

/// Number of sums kept for a range of samples: one per node, and one for the samples after the last
/// complete chunk.
pub(super) fn sums(samples: &Range<u32>) -> usize {
    nodes(complete(samples)).count() + usize::from(!samples.end.is_multiple_of(CHUNK))
}

/// Number of nodes that merge with a node appended to a range of chunks that starts at `begin`. The
/// appended node is given by its level and its first chunk. Its left sibling is added to it, then
/// the left sibling of their parent, and so on while the range contains that sibling.
pub(super) fn left_siblings(begin: u32, (mut level, mut first): (u32, u32)) -> usize {
    let mut siblings = 0;
    while (first >> level) & 1 == 1 && first - begin >= 1 << level {
        first -= 1 << level;
        level += 1;
        siblings += 1;
    }
    siblings
}

/// Writes the sum of all samples of each channel to `totals`. `sums` are those kept for a pixel, one row of channels each.
pub(super) fn total<'a>(sums: impl DoubleEndedIterator<Item = &'a [f32]>, totals: &mut [f32]) {
    let mut sums = sums.rev();
    match sums.next() {
        None => totals.fill(0.0),
        Some(last) => totals.copy_from_slice(last),
    }
    for left in sums {
        for (total, left) in totals.iter_mut().zip(left) {
            *total += left;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// In every range of chunks, nodes are aligned, as large as possible, and without gaps.
    #[test]
    fn nodes_are_the_largest_subtrees() {
        for begin in 0..40u32 {
            for end in begin..90 {
                let mut at = begin;
                for (level, first) in nodes(begin..end) {
                    assert_eq!(first, at);
                    let (length, parent) = (1 << level, first >> (level + 1) << (level + 1));
                    assert!(first.is_multiple_of(length) && first + length <= end);
                    assert!(parent < begin || parent + 2 * length > end, "{begin}..{end}: {first}");
                    at += length;
                }
                assert_eq!(at, end);
            }
        }
    }

    /// Adding siblings turns the nodes of two neighbouring ranges into those of their union.
    #[test]
    fn neighbouring_ranges_join() {
        for begin in 0..20u32 {
            for end in begin + 1..60 {
                for split in begin..=end {
                    let mut joined: Vec<(u32, u32)> = nodes(begin..split).collect();
                    for node in nodes(split..end) {
                        let siblings = left_siblings(begin, node);
                        let rest = joined.len() - siblings;
                        let first = joined.get(rest).map_or(node.1, |left| left.1.min(node.1));
                        for (k, left) in joined[rest..].iter().rev().enumerate() {
                            assert_eq!(left.0, node.0 + k as u32, "a sibling has the same level");
                        }
                        joined.truncate(rest);
                        joined.push((node.0 + siblings as u32, first));
                    }
                    let whole: Vec<_> = nodes(begin..end).collect();
                    assert_eq!(joined, whole, "{begin}..{split}..{end}");
                }
            }
        }
    }
}
