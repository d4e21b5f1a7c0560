//! Numbers that decide bits, and so are the same in every engine.

/// First segment that a path reaches only by Russian roulette.
pub(super) const ROULETTE_FROM: u32 = 5;
/// Largest chance of surviving it.
pub(super) const ROULETTE_MAX: f32 = 0.95;

/// The part of the way to a light that has to be free, as in pbrt (Pharr et al. 2023, 6.8.6).
///
/// In the last 10⁻⁴ lie the light itself, with what rounding does to its distance in this or another
/// program (but for grazing rays and silhouettes), and surfaces that are flush with it.
pub(super) const SHADOW_REACH: f32 = 1.0 - 1e-4;

/// Rectangles are sampled by solid angle above this: below it the sum of the corners' angles has lost
/// too many digits.
pub(super) const MIN_SOLID_ANGLE: f32 = 1e-3;
/// And above this sine of the angle under which the farthest corner is seen above the rectangle's
/// plane: below it the map from angles to places has lost too many digits.
pub(super) const MIN_SINE: f32 = 2.5e-3;
