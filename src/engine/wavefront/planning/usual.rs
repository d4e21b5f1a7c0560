//! The plan that is best for most scenes of a size.

use crate::accel::Kernel;
use crate::engine::{Plan, SegmentPlan};

/// Usual number of paths of a wave. With fewer, later segments have too few rays to sort them well.
const USUAL_WAVE: u32 = 1 << 14;
/// The same for streams whose rays are not sorted. Then a wave can be as small as the caches like: twice as many
/// paths rendered scenes 0.94 to 1.02 times as fast (`profiling/measured.md`).
const USUAL_WAVE_UNSORTED: u32 = 1 << 13;
/// Number of primitives from which bounce and shadow rays are traced as streams. Meshes of 968 to 20 088 triangles
/// were rendered 1.08 to 1.86 times as fast as with packets, and clouds of 1000 to 10 000 spheres 1.05 to 1.41
/// times; the 488 spheres of the report's scene 0.67 to 0.81 times (`profiling/measured.md`).
const SMALL: usize = 1 << 9;
/// Number of primitives from which it pays to order rays that are not traced in packets, because the
/// tree is much larger than the caches: such scenes were rendered 0.99 to 1.12 times as fast. Of smaller
/// scenes, rooms with the camera in them were rendered 1.01 to 1.09 times as fast, and objects 0.96 to 1.01
/// times (`profiling/measured.md`). Scenes with instances count as large.
const ORDERED: usize = 1 << 18;
/// Number of lights from which shadow rays are usually sorted. With four lamps in a room, whole
/// renders were 1.09 times as fast, with ten lamps spread over a plain 1.87 times; with one lamp or a
/// map, 0.86 to 1.07 times. Each primitive that emits is a light.
const SEVERAL: usize = 4;
/// Minimum number of waves per thread in small renders, so that all threads finish at about the
/// same time.
const LEAST_WAVES: u64 = 4;

/// The best plan for most scenes with `primitives` primitives and `lights` lights that are sampled, in a
/// render of `paths` paths. `inside` is true if the camera is in the box around all primitives. A
/// `wave_size` of 0 stands for the usual size.
pub(super) fn usual_plan(
    primitives: usize,
    inside: bool,
    lights: usize,
    paths: u64,
    threads: usize,
    wave_size: u32,
) -> Plan {
    let share = (paths / (LEAST_WAVES * threads as u64)).max(1);
    let [first, later] = match primitives {
        0..20 => [Kernel::Flat, Kernel::Flat],
        20..SMALL => [Kernel::Beam, Kernel::Packet],
        _ => [Kernel::Beam, Kernel::Stream],
    };
    let ordered = match later {
        Kernel::Flat => false,
        Kernel::Packet => true,
        _ => inside || primitives >= ORDERED,
    };
    let usual_wave = match later {
        Kernel::Stream if !ordered => USUAL_WAVE_UNSORTED,
        _ => USUAL_WAVE,
    };
    let of = |ordered, closest| SegmentPlan {
        ordered,
        closest,
        occluded: later,
        shadows_ordered: lights >= SEVERAL,
    };
    Plan {
        wave_size: match wave_size {
            0 => share.min(usual_wave.into()) as u32,
            size => size,
        },
        segments: vec![of(false, first), of(ordered, later)],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn usual_plans_order_bounce_rays_in_packets_large_scenes_and_rooms() {
        for (primitives, inside, ordered) in [
            (10, true, false),
            (511, false, true),
            (512, false, false),
            (100_000, false, false),
            (100_000, true, true),
            (1_000_000, false, true),
            (usize::MAX, false, true),
        ] {
            let plan = usual_plan(primitives, inside, 0, 1 << 20, 1, 0);
            let found = [1, 2, 9].map(|segment| plan.segment(segment).ordered);
            assert_eq!(found, [false, ordered, ordered], "{primitives} {inside}");
        }
    }

    #[test]
    fn usual_waves_are_smaller_for_unsorted_streams_and_small_renders() {
        for (primitives, inside, paths, wave_size, expected) in [
            (10, false, 1 << 20, 0, 1 << 14),
            (511, false, 1 << 20, 0, 1 << 14),
            (512, false, 1 << 20, 0, 1 << 13),
            (512, true, 1 << 20, 0, 1 << 14),
            (ORDERED - 1, false, 1 << 20, 0, 1 << 13),
            (ORDERED, false, 1 << 20, 0, 1 << 14),
            (usize::MAX, false, 1 << 20, 0, 1 << 14),
            // Four waves per thread.
            (10, false, 1 << 12, 0, 1 << 9),
            (10, false, 1 << 12, 77, 77),
        ] {
            let plan = usual_plan(primitives, inside, 0, paths, 2, wave_size);
            assert_eq!(plan.wave_size, expected, "{primitives} {inside} {paths} {wave_size}");
        }
    }

    #[test]
    fn usual_plans_sort_shadow_rays_to_several_lights() {
        for (lights, ordered) in [(0, false), (3, false), (4, true)] {
            let plan = usual_plan(100, false, lights, 1 << 20, 1, 0);
            assert!(plan.segments.iter().all(|segment| segment.shadows_ordered == ordered));
        }
    }
}
