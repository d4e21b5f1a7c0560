//! Estimates the memory of a scene while it is read, to reject it before anything is allocated.

use std::sync::atomic::{AtomicU64, Ordering};

use super::{Limit, Limits};

/// Bytes of memory for each byte of a scene file, for its text and its parsed form together. Up to
/// 14 were computed, for lists of materials while they grow.
const TEXT: u64 = 15;
/// Bytes of memory for each primitive of a scene while the lists of primitives grow. A quad has 80,
/// a triangle 16 besides its vertices.
const PRIMITIVE: u64 = 160;

/// Bytes of memory for each vertex of triangles while the lists grow: a position and a normal of 16
/// bytes each, in up to three copies.
const VERTEX: u64 = 96;

/// Bytes of memory for each vertex and each triangle of a list in the description of a scene.
const LISTED: [u64; 2] = [140, 24];

/// Bytes of memory for each instance while the list grows. An instance has 96.
const INSTANCE: u64 = 200;

/// The estimated memory held so far, and its limit. Threads may share it.
#[derive(Debug)]
pub(crate) struct Budget {
    pub(crate) limits: Limits,
    text: u64,
    held: AtomicU64,
}

impl Clone for Budget {
    fn clone(&self) -> Self {
        Self { limits: self.limits.clone(), text: self.text, held: AtomicU64::new(self.held()) }
    }
}

impl Budget {
    /// The budget of a scene file of `bytes` bytes.
    pub(crate) fn new(limits: &Limits, bytes: u64) -> Self {
        Self { limits: limits.clone(), text: TEXT.saturating_mul(bytes), held: AtomicU64::new(0) }
    }

    /// The estimated memory so far, without that of the text.
    pub(crate) fn held(&self) -> u64 {
        self.held.load(Ordering::Relaxed)
    }

    /// Returns an error if `more` bytes on top of those already held exceed the limit.
    pub(crate) fn check(&self, more: u64) -> Result<(), String> {
        self.fits(self.held(), more)
    }

    /// Returns an error if a file of `length` bytes exceeds `limit`, or does not fit into memory.
    pub(crate) fn check_file(&self, limit: Limit, length: u64) -> Result<(), String> {
        self.limits.check(limit, length).and_then(|()| self.check(length))
    }

    /// Returns an error if `more` bytes on top of `held` ones exceed the limit.
    fn fits(&self, held: u64, more: u64) -> Result<(), String> {
        self.limits.check(Limit::Memory, self.text.saturating_add(held).saturating_add(more))
    }

    /// Bytes of memory that are left before the limit.
    pub(crate) fn room(&self) -> u64 {
        let held = self.text.saturating_add(self.held());
        self.limits.get(Limit::Memory).saturating_sub(held)
    }

    /// A copy that holds `bytes` more, for memory that is only needed temporarily.
    pub(crate) fn with(&self, bytes: u64) -> Self {
        let other = self.clone();
        other.held.fetch_add(bytes, Ordering::Relaxed);
        other
    }

    /// Holds `bytes` more from now on, unless they exceed the limit.
    pub(crate) fn hold(&self, bytes: u64) -> Result<(), String> {
        let more = |held| self.fits(held, bytes).ok().map(|()| held + bytes);
        match self.held.fetch_update(Ordering::Relaxed, Ordering::Relaxed, more) {
            Ok(_) => Ok(()),
            Err(held) => self.fits(held, bytes),
        }
    }

    /// Releases memory that was held.
    pub(crate) fn release(&self, bytes: u64) {
        self.held.fetch_sub(bytes, Ordering::Relaxed);
    }

    /// As [`hold`](Self::hold), for another text of `bytes` bytes and its parsed form.
    pub(crate) fn hold_text(&self, bytes: u64) -> Result<(), String> {
        self.hold(TEXT.saturating_mul(bytes))
    }

    /// As [`hold`](Self::hold), for this many vertices of triangles.
    pub(crate) fn hold_vertices(&self, more: usize) -> Result<(), String> {
        self.hold(VERTEX * more as u64)
    }

    /// As [`hold`](Self::hold), for a list of triangles in the description of a scene.
    pub(crate) fn hold_list(&self, vertices: usize, triangles: usize) -> Result<(), String> {
        let [vertex, triangle] = LISTED;
        self.hold(vertex * vertices as u64 + triangle * triangles as u64)
    }

    /// As [`hold`](Self::hold), for instances and triangles with this many vertices, in addition to
    /// the `before` primitives and instances already in the scene.
    pub(crate) fn hold_placement(
        &self,
        before: u64,
        instances: u64,
        triangles: u64,
        vertices: u64,
    ) -> Result<(), String> {
        let all = before.saturating_add(instances).saturating_add(triangles);
        self.limits.check(Limit::Primitives, all)?;
        let bytes = [(INSTANCE, instances), (PRIMITIVE, triangles), (VERTEX, vertices)];
        let bytes = bytes.map(|(each, count)| each.saturating_mul(count));
        self.hold(bytes.into_iter().fold(0, u64::saturating_add))
    }

    /// As [`hold`](Self::hold), for `more` primitives in addition to the `before` already in the
    /// scene. The limit on their number is checked as well.
    pub(crate) fn hold_primitives(&self, before: usize, more: usize) -> Result<(), String> {
        self.limits.check(Limit::Primitives, before as u64 + more as u64)?;
        self.hold(PRIMITIVE * more as u64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn held_memory_counts_against_the_limit() {
        let limits = Limits::default().with(Limit::Memory, 2000).with(Limit::Primitives, 9);
        let budget = Budget::new(&limits, 80);
        assert!(budget.check(800).is_ok() && budget.check(801).is_err());
        budget.hold(300).unwrap();
        assert!(budget.check(500).is_ok() && budget.check(501).is_err());
        assert!(budget.hold_primitives(6, 4).unwrap_err().contains("limit of primitives is 9"));
        budget.hold_primitives(6, 3).unwrap();
        assert!(budget.hold_primitives(0, 1).unwrap_err().contains("limit of memory"));
        assert!(budget.check(u64::MAX).is_err());
    }
}
