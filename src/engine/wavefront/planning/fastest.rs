//! Chooses the fastest plan from the times of trials.

use crate::engine::{Plan, SegmentPlan, SegmentWork, Stage, WaveStats};

/// Number of segments that have a plan of their own. The plan of the last one also applies to all
/// later segments.
pub(super) const PLANNED: u32 = 4;
/// A plan is dropped if it takes more than this many times the least time of all plans, on every
/// segment and for both kinds of rays. The first bound applies after the first round, which may
/// have been interrupted. The second bound applies after each later round.
const BEHIND: [f64; 2] = [4.0, 1.25];
/// A wave that takes more than this many times the median time per ray was probably interrupted. It
/// is counted with this multiple of the median.
const INTERRUPTED: f64 = 3.0;
/// The stages whose times decide the kernel for closest hits, and whether rays are ordered.
const CLOSEST: &[Stage] = &[Stage::Order, Stage::Extend, Stage::Collide, Stage::Sort, Stage::Shade];
/// The stages whose times decide the kernel for shadow rays, and whether these are ordered.
const OCCLUDED: &[Stage] = &[Stage::Connect];

/// A plan, and the times of the waves that it traced.
pub(super) struct Tried<'a> {
    pub(super) plan: &'a Plan,
    pub(super) waves: Vec<WaveStats>,
}

impl<'a> Tried<'a> {
    pub(super) fn new(plan: &'a Plan) -> Self {
        Self { plan, waves: Vec::new() }
    }

    /// The way in which the plan traces rays. The plan must treat all segments alike.
    fn way(&self) -> SegmentPlan {
        self.plan.segments[0]
    }

    /// Seconds per path.
    fn all(&self) -> f64 {
        self.seconds(|wave| (wave.stage(Stage::Generate).active, wave.seconds())).unwrap_or(0.0)
    }

    /// Seconds per ray that `stages` took on segment `number`; `None` if no ray was traced. Segment
    /// [`PLANNED`] includes all later segments.
    fn segment(&self, number: u32, stages: &[Stage]) -> Option<f64> {
        self.seconds(|wave| {
            let segments = wave.segments.iter().zip(1..);
            let these = segments.filter(|&(_, n)| n == number || number == PLANNED && n > number);
            these.fold((0, 0.0), |(rays, seconds), (work, _): (&SegmentWork, u32)| {
                let each = stages.iter().map(|&stage| work.stage(stage));
                (
                    rays + each.clone().map(|work| work.active).max().unwrap_or(0),
                    seconds + each.map(|work| work.seconds).sum::<f64>(),
                )
            })
        })
    }

    /// Seconds per ray over all waves. `cost` returns the rays and seconds of a wave. The seconds
    /// of interrupted waves are limited by [`INTERRUPTED`].
    fn seconds(&self, cost: impl Fn(&WaveStats) -> (u64, f64)) -> Option<f64> {
        let costs: Vec<(u64, f64)> =
            self.waves.iter().map(cost).filter(|&(rays, _)| rays > 0).collect();
        let mut each: Vec<f64> =
            costs.iter().map(|&(rays, seconds)| seconds / rays as f64).collect();
        each.sort_by(f64::total_cmp);
        let middle = each.get(each.len().saturating_sub(1) / 2)?;
        let most = |rays: u64| INTERRUPTED * middle * rays as f64;
        let seconds: f64 = costs.iter().map(|&(rays, seconds)| seconds.min(most(rays))).sum();
        Some(seconds / costs.iter().map(|&(rays, _)| rays as f64).sum::<f64>())
    }
}

/// Returns the plan that took the least time; `None` if no plan was tried.
pub(super) fn fastest<'b, 'a>(tried: &'b [Tried<'a>]) -> Option<&'b Tried<'a>> {
    tried.iter().min_by(|a, b| a.all().total_cmp(&b.all()))
}

/// Returns the fastest way to trace the rays of segment `number`, or `usual` if no ray was traced.
pub(super) fn fastest_segment(
    tried: &[Tried<'_>],
    number: u32,
    usual: &SegmentPlan,
) -> SegmentPlan {
    // Shadow rays that are not sorted inherit the order of the other rays, so the order of those is
    // judged by the time of both.
    let with_order = |ordered: bool| {
        let least = |stages: &[Stage], fits: &dyn Fn(&SegmentPlan) -> bool| {
            let ways = tried.iter().map(|tried| (tried.way(), tried)).filter(|(way, _)| fits(way));
            let costs = ways.filter_map(|(way, tried)| Some((way, tried.segment(number, stages)?)));
            costs.min_by(|(_, a), (_, b)| a.total_cmp(b))
        };
        let (SegmentPlan { closest, .. }, seconds) = least(CLOSEST, &|way| way.ordered == ordered)?;
        let of_shadows = |way: &SegmentPlan| way.shadows_ordered || way.ordered == ordered;
        let (shadows, more) = least(OCCLUDED, &of_shadows).unwrap_or((*usual, 0.0));
        let SegmentPlan { occluded, shadows_ordered, .. } = shadows;
        // Camera rays are never sorted.
        let ordered = ordered && number > 1;
        Some((SegmentPlan { ordered, closest, occluded, shadows_ordered }, seconds + more))
    };
    let orders = [false, true].into_iter().filter_map(with_order);
    orders.min_by(|(_, a), (_, b)| a.total_cmp(b)).map_or(*usual, |(segment, _)| segment)
}

/// Drops plans that are too slow on every segment, by the bounds [`BEHIND`]. `round` is the number
/// of the last round, counted from 0.
pub(super) fn without_those_behind(tried: Vec<Tried<'_>>, round: u64) -> Vec<Tried<'_>> {
    let behind = BEHIND[usize::from(round > 0)];
    let mut keep = vec![false; tried.len()];
    for number in 1..=PLANNED {
        for stages in [CLOSEST, OCCLUDED] {
            let costs: Vec<_> = tried.iter().map(|tried| tried.segment(number, stages)).collect();
            let least = costs.iter().copied().flatten().fold(f64::INFINITY, f64::min);
            let near = costs.iter().map(|cost| cost.is_some_and(|cost| cost <= behind * least));
            keep.iter_mut().zip(near).for_each(|(keep, near)| *keep |= near);
        }
    }
    let kept = tried.into_iter().zip(keep).filter(|(_, keep)| *keep);
    kept.map(|(tried, _)| tried).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accel::Kernel;
    use crate::engine::StageWork;

    fn plan(ordered: bool, kernel: Kernel) -> Plan {
        let (closest, occluded) = (kernel, kernel);
        let way = SegmentPlan { ordered, closest, occluded, shadows_ordered: false };
        Plan { wave_size: 100, segments: vec![way] }
    }

    const USUAL: SegmentPlan = SegmentPlan {
        ordered: true,
        closest: Kernel::Beam,
        occluded: Kernel::Flat,
        shadows_ordered: false,
    };

    /// A wave of 100 rays per stage, with the given seconds of stages and segments.
    fn wave(seconds: &[(Stage, u32, f64)]) -> WaveStats {
        let mut wave = WaveStats::default();
        for &(stage, segment, seconds) in seconds {
            wave.note(stage, segment, &StageWork { seconds, ..StageWork::of(100) });
        }
        wave
    }

    #[test]
    fn interruptions_do_not_count() {
        let (a, b) = (plan(false, Kernel::Flat), plan(false, Kernel::Stream));
        let tried = |plan, seconds: &[f64]| Tried {
            plan,
            waves: seconds.iter().map(|&s| wave(&[(Stage::Generate, 1, s)])).collect(),
        };
        let near = |a: f64, b: f64| (a - b).abs() < 1e-9;
        let slow = tried(&a, &[1.5; 5]);
        let fast = tried(&b, &[99.0, 1.0, 1.0, 1.0, 1.0]);
        assert!(near(fast.all(), 0.014) && near(slow.all(), 0.015));
        // Of two waves, the faster one is the median.
        assert!(near(tried(&b, &[99.0, 1.0]).all(), 0.02));
        assert_eq!(fastest(&[slow, fast]).unwrap().plan, &b);
        assert!(fastest(&[]).is_none());
    }

    #[test]
    fn orders_are_judged_by_all_affected_stages() {
        use Stage::{Connect, Extend, Order, Shade, Sort};
        let plans = [
            plan(false, Kernel::Packet),
            plan(true, Kernel::Packet),
            plan(false, Kernel::Stream),
            plan(true, Kernel::Stream),
        ];
        // `seconds` are the times of `stage` with each plan. Kernel packet is faster, and ordering
        // takes time.
        let chosen = |stage: Stage, seconds: [f64; 4]| {
            let each = plans.iter().zip([1.0, 1.0, 9.0, 9.0]).zip(seconds);
            let tried = each.map(|((plan, extend), more)| {
                let order = if plan.segments[0].ordered { 0.1 } else { 0.0 };
                let works = [(Order, 2, order), (Extend, 2, extend), (stage, 2, more)];
                Tried { plan, waves: vec![wave(&works); 3] }
            });
            fastest_segment(&tried.collect::<Vec<_>>(), 2, &USUAL)
        };
        for stage in [Extend, Sort, Shade, Connect] {
            let (off, on) = (chosen(stage, [0.1; 4]), chosen(stage, [0.9, 0.7, 0.9, 0.7]));
            assert!(!off.ordered && on.ordered, "{stage:?}");
            assert_eq!((off.closest, on.closest), (Kernel::Packet, Kernel::Packet), "{stage:?}");
        }
        // The kernel for shadow rays is the fastest with the chosen order, or the usual one if no
        // shadow ray was traced.
        assert_eq!(chosen(Connect, [5.0, 2.0, 5.0, 1.0]).occluded, Kernel::Stream);
        assert_eq!(chosen(Connect, [0.1, 2.0, 0.2, 1.0]).occluded, Kernel::Packet);
        assert_eq!(chosen(Sort, [0.0; 4]).occluded, Kernel::Flat);
    }

    #[test]
    fn shadow_rays_are_sorted_if_that_is_fastest() {
        let kernel = Kernel::Packet;
        let (unsorted, mut sorted) = (plan(false, kernel), plan(true, kernel));
        let ordered = plan(true, kernel);
        sorted.segments[0].shadows_ordered = true;
        let chosen = |connect: [f64; 3], extend: [f64; 2]| {
            let each = [&unsorted, &ordered, &sorted].into_iter().zip(connect);
            let tried = each.map(|(plan, connect)| {
                let extend = extend[usize::from(plan.segments[0].ordered)];
                let works = [(Stage::Extend, 2, extend), (Stage::Connect, 2, connect)];
                Tried { plan, waves: vec![wave(&works); 3] }
            });
            let way = fastest_segment(&tried.collect::<Vec<_>>(), 2, &USUAL);
            (way.ordered, way.shadows_ordered)
        };
        assert_eq!(chosen([5.0, 4.0, 1.0], [2.0, 1.0]), (true, true));
        assert_eq!(chosen([5.0, 4.0, 1.0], [1.0, 2.0]), (false, true));
        assert_eq!(chosen([3.0, 1.0, 1.5], [1.0, 1.2]), (true, false));
        assert_eq!(chosen([1.0, 1.0, 1.5], [1.0, 1.2]), (false, false));
    }

    #[test]
    fn each_segment_up_to_the_last_has_its_own_plan() {
        let [a, b] = [plan(true, Kernel::Packet), plan(true, Kernel::Stream)];
        let tried = |plan, seconds: [f64; 3]| {
            let [first, fourth, ninth] = seconds;
            let work = [(1, first), (4, fourth), (9, ninth)].map(|(n, s)| (Stage::Extend, n, s));
            Tried { plan, waves: vec![wave(&work)] }
        };
        let both = [tried(&a, [1.0, 1.0, 5.0]), tried(&b, [2.0, 2.0, 1.0])];
        let segment = |number| fastest_segment(&both, number, &USUAL);
        assert_eq!((segment(1).closest, segment(1).ordered), (Kernel::Packet, false));
        assert_eq!((segment(2), segment(3)), (USUAL, USUAL));
        assert_eq!((segment(4).closest, segment(4).ordered), (Kernel::Stream, true));
    }

    #[test]
    fn plans_behind_on_every_segment_are_dropped() {
        let plans = [plan(false, Kernel::Packet), plan(false, Kernel::Stream)];
        let left = |round: u64, slow: [f64; 2]| {
            let both = plans.iter().zip([[1.0, 1.0], slow]).map(|(plan, [extend, connect])| {
                let works = [(Stage::Extend, 2, extend), (Stage::Connect, 2, connect)];
                Tried { plan, waves: vec![wave(&works)] }
            });
            without_those_behind(both.collect(), round).len()
        };
        assert_eq!((left(0, [9.0; 2]), left(0, [3.9; 2])), (1, 2));
        assert_eq!((left(1, [1.3; 2]), left(1, [1.2; 2])), (1, 2));
        // A plan is kept if it is competitive for one kind of rays.
        assert_eq!((left(5, [9.0, 1.1]), left(5, [1.1, 9.0])), (2, 2));
        // If the clock does not advance, all plans are kept.
        let works = [(Stage::Extend, 1, 0.0)];
        let still = plans.iter().map(|plan| Tried { plan, waves: vec![wave(&works)] });
        assert_eq!(without_those_behind(still.collect(), 3).len(), 2);
    }
}
