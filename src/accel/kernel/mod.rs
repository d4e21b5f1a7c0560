//! Kernels, the algorithms that find hits. All of them return the same bits.

pub(super) mod beam;
pub(super) mod flat;
pub(super) mod job;
mod meshes;
mod octants;
pub(super) mod packet;
mod scalar;
mod search;
pub(super) mod stream;
mod visits;

/// An algorithm that finds the hits of rays.
///
/// In scenes with instances, [`Kernel::Packet`] and [`Kernel::Flat`] do the same as
/// [`Kernel::Stream`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum Kernel {
    /// Tests packets of rays against the boxes of a binary tree, one box at a time.
    Packet,
    /// Tests each packet of rays as a unit, against every box of a wide node at once.
    Beam,
    /// Moves the rays of a packet through a wide tree together. At each node, tests each ray against
    /// all boxes at once, and only the rays that enter a child continue to it.
    Stream,
    /// Tests packets of rays against every primitive, without a tree.
    Flat,
    /// The reference, which takes one ray at a time through a binary tree.
    Scalar,
}

names! {
    pub Kernel:
    Packet = "packet",
    Beam = "beam",
    Stream = "stream",
    Flat = "flat",
    Scalar = "scalar",
}
