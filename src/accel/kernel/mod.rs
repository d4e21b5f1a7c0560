//! Kernels: the ways of finding hits. All give the same bits.

pub(super) mod beam;
mod descent;
mod enter;
pub(super) mod flat;
mod frames;
pub(super) mod job;
mod octants;
pub(super) mod pair_traversal;
pub(super) mod single;

/// A way of finding what rays hit.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum Kernel {
    /// Packets of rays against the boxes of a binary tree, one by one.
    Packet,
    /// Packets of rays, as one, against every box of a wide node at once.
    Beam,
    /// One ray against every box of a wide node at once.
    Single,
    /// Packets of rays against every primitive, without a tree.
    Flat,
    /// The reference: one ray through a binary tree.
    Scalar,
}

impl Kernel {
    /// All kernels.
    pub const ALL: [Self; 5] = [Self::Packet, Self::Beam, Self::Single, Self::Flat, Self::Scalar];

    /// The name on the command line and in records.
    pub fn name(self) -> &'static str {
        match self {
            Self::Packet => "packet",
            Self::Beam => "beam",
            Self::Single => "single",
            Self::Flat => "flat",
            Self::Scalar => "scalar",
        }
    }
}
