//! The stages of the wavefront engine, by name.

/// The stages of a wave.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// Camera rays.
    Generate,
    /// Closest hits.
    Extend,
    /// Collisions in media, where there are any.
    Collide,
    /// Paths to the queues of what they hit.
    Sort,
    /// Emission, scattering, light samples.
    Shade,
    /// Shadow rays.
    Connect,
    /// Rays of the next segment, put in order.
    Order,
    /// Samples to pixels.
    Accumulate,
}

impl Stage {
    /// All stages, in order.
    pub const ALL: [Self; 8] = [
        Self::Generate,
        Self::Extend,
        Self::Collide,
        Self::Sort,
        Self::Shade,
        Self::Connect,
        Self::Order,
        Self::Accumulate,
    ];

    /// The name in tables and records.
    pub fn name(self) -> &'static str {
        match self {
            Self::Generate => "generate",
            Self::Extend => "extend",
            Self::Collide => "collide",
            Self::Sort => "sort",
            Self::Shade => "shade",
            Self::Connect => "connect",
            Self::Order => "order",
            Self::Accumulate => "accumulate",
        }
    }
}
