//! Which of the plans that were tried is fastest.

use super::plan::{Plan, SegmentPlan};
use crate::engine::stats::{SegmentWork, Stage, WaveStats};

/// Segments that a plan tells apart.
pub(super) const SEGMENTS: u32 = 4;
/// Plans that take so many times as long as the fastest on every segment are tried no more: after one
/// wave, which may have been interrupted, and after more.
const BEHIND: [f64; 2] = [4.0, 1.25];
/// Waves that took so many times as long a ray as most were interrupted.
const INTERRUPTED: f64 = 3.0;

/// A plan, and what the same waves took by it.
pub(super) struct Tried<'a> {
    pub(super) plan: &'a Plan,
    pub(super) waves: Vec<WaveStats>,
}

/// What counts for a choice: rays and seconds.
type Cost = (u64, f64);

impl<'a> Tried<'a> {
    pub(super) fn new(plan: &'a Plan) -> Self {
        Self { plan, waves: Vec::new() }
    }

    /// How it traces rays, if it does so in one way.
    fn way(&self) -> SegmentPlan {
        self.plan.segments[0]
    }

    /// Seconds that all took.
    fn all(&self) -> f64 {
        self.seconds(|wave| (wave.stage(Stage::Generate).active, wave.seconds()))
    }

    /// Seconds that `stages` took for paths on their segment `number`; the last stands for all that
    /// follow.
    fn segment(&self, number: u32, stages: &[Stage]) -> f64 {
        self.seconds(|wave| {
            let segments = wave.segments.iter().zip(1..);
            let these = segments.filter(|&(_, n)| n == number || number == SEGMENTS && n > number);
            these.fold((0, 0.0), |(rays, seconds), (work, _): (&SegmentWork, u32)| {
                let each = stages.iter().map(|&stage| work.stage(stage));
                (
                    rays + each.clone().map(|work| work.active).max().unwrap_or(0),
                    seconds + each.map(|work| work.seconds).sum::<f64>(),
                )
            })
        })
    }

    /// The sum of the seconds that `cost` tells. Waves that were interrupted count like others.
    fn seconds(&self, cost: impl Fn(&WaveStats) -> Cost) -> f64 {
        let costs: Vec<Cost> = self.waves.iter().map(cost).filter(|&(rays, _)| rays > 0).collect();
        let mut each: Vec<f64> =
            costs.iter().map(|&(rays, seconds)| seconds / rays as f64).collect();
        each.sort_by(f64::total_cmp);
        let Some(middle) = each.get(each.len().saturating_sub(1) / 2) else { return 0.0 };
        let most = |rays: u64| INTERRUPTED * middle * rays as f64;
        costs.iter().map(|&(rays, seconds)| seconds.min(most(rays))).sum()
    }
}

/// The plan that took the least time; `None` if none was tried.
pub(super) fn fastest<'b, 'a>(tried: &'b [Tried<'a>]) -> Option<&'b Tried<'a>> {
    tried.iter().min_by(|a, b| a.all().total_cmp(&b.all()))
}

/// What an order is judged by: all that follows it.
const BY_ORDER: &[Stage] = &[Stage::Order, Stage::Extend, Stage::Sort, Stage::Shade];
const BY_SHADOWS: &[Stage] = &[Stage::Connect];

/// How the rays of segment `number` are traced in the least time.
pub(super) fn fastest_segment(tried: &[Tried<'_>], number: u32) -> SegmentPlan {
    let least = |ways: &mut dyn Iterator<Item = &Tried<'_>>, stages: &[Stage]| {
        let costs = ways.map(|tried| (tried.way(), tried.segment(number, stages)));
        costs.min_by(|(_, a), (_, b)| a.total_cmp(b)).expect("there are ways").0
    };
    let SegmentPlan { ordered, closest, .. } = least(&mut tried.iter(), BY_ORDER);
    let same_order = &mut tried.iter().filter(|tried| tried.way().ordered == ordered);
    let occluded = least(same_order, BY_SHADOWS).occluded;
    // Camera rays need none.
    SegmentPlan { ordered: ordered && number > 1, closest, occluded }
}

/// Leaves out plans that are behind on every segment.
pub(super) fn without_those_behind(tried: Vec<Tried<'_>>) -> Vec<Tried<'_>> {
    let behind = BEHIND[usize::from(tried.iter().all(|tried| tried.waves.len() > 1))];
    let mut keep = vec![false; tried.len()];
    for number in 1..=SEGMENTS {
        for stages in [BY_ORDER, BY_SHADOWS] {
            let costs: Vec<f64> = tried.iter().map(|tried| tried.segment(number, stages)).collect();
            let least = costs.iter().copied().fold(f64::INFINITY, f64::min);
            let near = costs.iter().map(|&cost| cost > 0.0 && cost <= behind * least);
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
    use crate::engine::stats::StageWork;

    fn plan(ordered: bool, kernel: Kernel) -> Plan {
        let way = SegmentPlan { ordered, closest: kernel, occluded: kernel };
        Plan { wave_size: 100, tile_size: 10, segments: vec![way] }
    }

    /// A wave of 100 rays a stage on two segments, and their seconds: generate, then order, extend and
    /// connect of the second segment.
    fn wave([generate, order, extend, connect]: [f64; 4]) -> WaveStats {
        let mut wave = WaveStats::default();
        let stages = [
            (Stage::Generate, 1, generate),
            (Stage::Order, 2, order),
            (Stage::Extend, 2, extend),
            (Stage::Connect, 2, connect),
        ];
        for (stage, segment, seconds) in stages {
            wave.note(stage, segment, &StageWork { seconds, ..StageWork::of(100) });
        }
        wave
    }

    fn tried(plan: &Plan, waves: impl IntoIterator<Item = [f64; 4]>) -> Tried<'_> {
        Tried { plan, waves: waves.into_iter().map(wave).collect() }
    }

    #[test]
    fn interruptions_do_not_count() {
        let (a, b) = (plan(false, Kernel::Flat), plan(false, Kernel::Single));
        let slow = tried(&a, [[1.25, 0.0, 0.0, 0.0]; 5]);
        let mut waves = [[1.0, 0.0, 0.0, 0.0]; 5];
        waves[0] = [3.2, 0.0, 0.0, 0.0];
        let fast = tried(&b, waves);
        assert_eq!(fast.all(), 7.0);
        waves[0] = [99.0, 0.0, 0.0, 0.0];
        assert_eq!(tried(&b, waves).all(), 7.0);
        // Of two waves the faster one tells what is usual.
        assert_eq!(tried(&b, waves[..2].iter().copied()).all(), 4.0);
        assert_eq!(fastest(&[slow, fast]).unwrap().plan, &a);
    }

    #[test]
    fn what_follows_an_order_pays_for_it() {
        let plans = [
            plan(false, Kernel::Packet),
            plan(true, Kernel::Packet),
            plan(false, Kernel::Single),
            plan(true, Kernel::Single),
        ];
        let with = |unordered: f64, ordered: f64, connect: [f64; 4]| {
            let extend = [unordered, ordered, 9.0, 8.0];
            let each = plans.iter().zip(extend).zip(connect);
            let order = |plan: &Plan| if plan.segments[0].ordered { 1.0 } else { 0.1 };
            let tried: Vec<Tried<'_>> = each
                .map(|((plan, extend), connect)| {
                    tried(plan, [[0.0, order(plan), extend, connect]; 3])
                })
                .collect();
            fastest_segment(&tried, 2)
        };
        let chosen = with(5.0, 4.0, [3.0, 3.0, 1.0, 2.0]);
        assert_eq!((chosen.ordered, chosen.closest), (true, Kernel::Packet));
        // Shadow rays as they are with that order.
        assert_eq!(with(5.0, 4.0, [3.0, 1.5, 1.0, 2.0]).occluded, Kernel::Packet);
        assert_eq!(chosen.occluded, Kernel::Single);
        let chosen = with(5.0, 4.2, [3.0, 3.0, 1.0, 2.0]);
        assert_eq!((chosen.ordered, chosen.closest), (false, Kernel::Packet));
        // On the first segment nothing is ordered.
        let first = tried(&plans[1], [[1.0; 4]; 3]);
        assert!(!fastest_segment(&[first], 1).ordered);
    }

    #[test]
    fn those_behind_on_every_segment_are_left_out() {
        let plans = [plan(false, Kernel::Packet), plan(false, Kernel::Single)];
        let trial = |waves: usize, slow: [f64; 2]| {
            let [a, b] = [[0.0, 0.0, 1.0, 1.0], [0.0, 0.0, slow[0], slow[1]]];
            let both = vec![tried(&plans[0], vec![a; waves]), tried(&plans[1], vec![b; waves])];
            without_those_behind(both).len()
        };
        assert_eq!((trial(1, [9.0; 2]), trial(1, [3.9; 2])), (1, 2));
        assert_eq!((trial(2, [1.3; 2]), trial(2, [1.2; 2])), (1, 2));
        // Good for one thing.
        assert_eq!((trial(5, [9.0, 1.1]), trial(5, [1.1, 9.0])), (2, 2));
    }
}
