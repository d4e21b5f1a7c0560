//! The stages of the wavefront engine and their names.

/// The stages of a wave.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// Generates camera rays.
    Generate,
    /// Finds the closest hits of rays.
    Extend,
    /// Finds collisions in media. Scenes without media skip this stage.
    Collide,
    /// Sorts paths into queues by the kind of surface or medium that they hit.
    Sort,
    /// Adds emitted light, samples lights, and scatters paths.
    Shade,
    /// Traces shadow rays and adds the light that reaches surfaces.
    Connect,
    /// Builds the rays of the next segment, sorted if the plan asks for it.
    Order,
    /// Adds samples to their pixels.
    Accumulate,
}

names! {
    pub Stage:
    Generate = "generate",
    Extend = "extend",
    Collide = "collide",
    Sort = "sort",
    Shade = "shade",
    Connect = "connect",
    Order = "order",
    Accumulate = "accumulate",
}
