//! Verdicts on compared runs: improved, same, regressed or unclear.

use serde::{Deserialize, Serialize};

use super::run::{Ratio, Run, Workload};
use crate::measure::statistics::Estimate;

/// Result of comparing the runs of a record with a reference.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Gate {
    /// Smallest change that counts: 0.01 for 1%.
    pub(crate) threshold: f64,
    /// Commit of the baseline or of the other program.
    pub(crate) commit: String,
    pub(crate) verdicts: Vec<Verdict>,
    /// Further measurements, measured because a run seemed to have changed or was disturbed.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(crate) again: Vec<Again>,
}

/// A further measurement of some contests.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Again {
    pub(crate) runs: Vec<Run>,
    pub(crate) ratios: Vec<Ratio>,
    /// Runs of the other program.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(crate) against: Vec<Run>,
}

/// Verdict on one run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Verdict {
    pub(crate) scene: String,
    pub(crate) engine: String,
    pub(crate) threads: usize,
    /// One finding for each measurement, in the order of measurement.
    pub(crate) findings: Vec<Finding>,
    pub(crate) outcome: Outcome,
    /// Why the outcome is unclear, or why it is `Same` although a measurement showed a change.
    #[serde(default)]
    pub(crate) reason: String,
}

/// Result of one measurement of a run.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Finding {
    /// Speed ratio of the run to its reference.
    pub(crate) change: Estimate,
    /// The reason why the measurement does not count; `None` if there is no doubt about it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) doubt: Option<Doubt>,
}

/// Reason why a measurement does not count.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(crate) enum Doubt {
    /// The images differ, so the work differs, too.
    Image,
    /// The baseline was disturbed or has no control.
    Baseline,
    /// Other processes kept more or fewer cores busy than during the baseline.
    Load,
    /// There is no control, so the noise is unknown.
    Uncontrolled,
    /// Other processes or a hypervisor disturbed most blocks.
    Contaminated,
    /// The control, the speed ratio of a side to itself, differs too much from 1.
    Control,
}

/// Whether the speed of a run changed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(crate) enum Outcome {
    /// Faster by more than the threshold in two measurements.
    Improved,
    /// Neither an improvement nor a regression was shown.
    Same,
    /// Slower by more than the threshold in two measurements.
    Regressed,
    /// Undecided, for the reason in [`Verdict::reason`].
    Unclear,
}

impl Doubt {
    pub(crate) fn reason(self) -> &'static str {
        match self {
            Self::Image => "the images differ",
            Self::Baseline => "the baseline was disturbed or has no control",
            Self::Load => {
                "the load by other processes differs from the baseline by over 10% of all cores"
            }
            Self::Uncontrolled => "there is no control",
            Self::Contaminated => "most blocks are contaminated",
            Self::Control => "the control differs from 1 by more than the threshold",
        }
    }

    /// Whether another measurement may be free of this doubt.
    fn passes(self) -> bool {
        matches!(self, Self::Contaminated | Self::Control | Self::Load)
    }
}

impl Outcome {
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Improved => "improved",
            Self::Same => "same",
            Self::Regressed => "REGRESSED",
            Self::Unclear => "unclear",
        }
    }
}

/// Whether an estimate for which [`decide`] returns `Same` is precise enough to show that nothing
/// changed: its median is within the threshold, and the ends of its interval are within three times
/// the threshold.
fn is_same(change: &Estimate, threshold: f64) -> bool {
    let off = |change: f64| change.max(1.0 / change) - 1.0;
    let ends = off(change.lo).max(off(change.hi));
    off(change.median) <= threshold && ends <= 3.0 * threshold
}

/// Returns `Improved` or `Regressed` if the whole interval is beyond the threshold, else `Same`.
pub(crate) fn decide(change: &Estimate, threshold: f64) -> Outcome {
    if change.lo > 1.0 + threshold {
        Outcome::Improved
    } else if change.hi < 1.0 / (1.0 + threshold) {
        Outcome::Regressed
    } else {
        Outcome::Same
    }
}

impl Verdict {
    /// A verdict on a run without findings.
    pub(super) fn new(Workload { scene, engine, threads, .. }: &Workload) -> Self {
        Self {
            scene: scene.clone(),
            engine: engine.clone(),
            threads: *threads,
            findings: Vec::new(),
            outcome: Outcome::Unclear,
            reason: String::new(),
        }
    }

    pub(crate) fn is_of(&self, work: &Workload) -> bool {
        (&self.scene, &self.engine, self.threads) == (&work.scene, &work.engine, work.threads)
    }

    /// Adds the finding of one more measurement and updates the outcome.
    pub(super) fn add(&mut self, finding: Finding, threshold: f64) {
        self.findings.push(finding);
        let (outcome, reason) = self.conclude(threshold);
        (self.outcome, self.reason) = (outcome, reason.to_owned());
    }

    /// Decides the outcome. Only two measurements that agree can show a change; one measurement can show that
    /// nothing changed.
    fn conclude(&self, threshold: f64) -> (Outcome, &'static str) {
        let measurements: Vec<Outcome> =
            self.counted(threshold).map(|change| decide(change, threshold)).take(2).collect();
        match measurements[..] {
            [Outcome::Same, ..] => return (Outcome::Same, ""),
            [_, Outcome::Same] => return (Outcome::Same, "not confirmed"),
            [first, second] if first == second => return (first, ""),
            [_, _] => return (Outcome::Unclear, "measurements contradict each other"),
            _ => {}
        }
        let doubt = self.findings.last().and_then(|finding| finding.doubt);
        let limit = match measurements[..] {
            [] => "the interval is not wholly within or beyond the threshold",
            _ => "one measurement is beyond the threshold, two are needed",
        };
        (Outcome::Unclear, doubt.map_or(limit, Doubt::reason))
    }

    /// Whether another measurement could settle the outcome.
    pub(super) fn is_open(&self, threshold: f64) -> bool {
        let lasting = |finding: &Finding| finding.doubt.is_some_and(|doubt| !doubt.passes());
        self.outcome == Outcome::Unclear
            && self.counted(threshold).count() < 2
            && !self.findings.iter().any(lasting)
    }

    /// Changes of the measurements that count: measurements that have no [`Doubt`], and that clearly show
    /// either a change or no change.
    pub(crate) fn counted(&self, threshold: f64) -> impl Iterator<Item = &Estimate> {
        let clean = self.findings.iter().filter(|finding| finding.doubt.is_none());
        let changes = clean.map(|finding| &finding.change);
        changes.filter(move |change| {
            decide(change, threshold) != Outcome::Same || is_same(change, threshold)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::ImageSettings;
    use crate::scene::Scene;

    fn verdict(findings: &[(f64, Option<Doubt>)]) -> Verdict {
        let settings = ImageSettings::of(&Scene::load("cornell").unwrap());
        let [scene, scene_hash, engine] = [const { String::new() }; 3];
        let mut verdict =
            Verdict::new(&Workload { scene, scene_hash, engine, threads: 1, settings });
        for &(median, doubt) in findings {
            let change = Estimate { median, lo: 0.995 * median, hi: 1.005 * median };
            verdict.add(Finding { change, doubt }, 0.01);
        }
        verdict
    }

    /// A finding whose interval is too wide to show a change or no change.
    fn wide(median: f64) -> Finding {
        let change = Estimate { median, lo: 0.97 * median, hi: 1.03 * median };
        Finding { change, doubt: None }
    }

    fn told(findings: &[(f64, Option<Doubt>)]) -> (Outcome, String, bool) {
        let verdict = verdict(findings);
        let open = verdict.is_open(0.01);
        (verdict.outcome, verdict.reason, open)
    }

    #[test]
    fn a_change_needs_two_measurements_that_agree() {
        let (slow, same, fast) = ((0.97, None), (1.0, None), (1.03, None));
        assert_eq!(told(&[same]), (Outcome::Same, String::new(), false));
        assert_eq!(
            told(&[slow]),
            (
                Outcome::Unclear,
                "one measurement is beyond the threshold, two are needed".to_owned(),
                true
            )
        );
        assert_eq!(told(&[slow, slow]), (Outcome::Regressed, String::new(), false));
        assert_eq!(told(&[fast, fast]), (Outcome::Improved, String::new(), false));
        assert_eq!(told(&[slow, same]), (Outcome::Same, "not confirmed".to_owned(), false));
        let contradict = "measurements contradict each other".to_owned();
        assert_eq!(told(&[slow, fast]), (Outcome::Unclear, contradict, false));
    }

    #[test]
    fn measurements_that_are_not_sure_do_not_count() {
        let of = |findings: &[Finding]| {
            let mut verdict = verdict(&[]);
            findings.iter().for_each(|&finding| verdict.add(finding, 0.01));
            (verdict.outcome, verdict.is_open(0.01))
        };
        let change = |median| Estimate { median, lo: 0.995 * median, hi: 1.005 * median };
        let [slow, same] = [0.97, 1.0].map(|m| Finding { change: change(m), doubt: None });
        for perhaps in [wide(0.98), wide(1.005), wide(1.02)] {
            assert_eq!(of(&[perhaps]), (Outcome::Unclear, true));
            assert_eq!(of(&[perhaps, perhaps, perhaps]), (Outcome::Unclear, true));
            assert_eq!(of(&[perhaps, same]), (Outcome::Same, false));
            assert_eq!(of(&[perhaps, slow]), (Outcome::Unclear, true));
            assert_eq!(of(&[slow, perhaps, slow]), (Outcome::Regressed, false));
        }
    }

    #[test]
    fn disturbed_measurements_do_not_count() {
        let (slow, same) = ((0.97, None), (1.0, None));
        for passing in [Doubt::Contaminated, Doubt::Control, Doubt::Load] {
            let disturbed = (0.97, Some(passing));
            let unclear = (Outcome::Unclear, passing.reason().to_owned(), true);
            assert_eq!(told(&[disturbed]), unclear);
            assert_eq!(told(&[slow, disturbed]), unclear);
            assert_eq!(told(&[disturbed, same]).0, Outcome::Same);
            assert_eq!(told(&[disturbed, slow]).0, Outcome::Unclear);
            assert_eq!(told(&[disturbed, slow, disturbed, slow]).0, Outcome::Regressed);
            assert_eq!(verdict(&[disturbed, slow]).counted(0.01).count(), 1);
        }
        for lasting in [Doubt::Image, Doubt::Baseline, Doubt::Uncontrolled] {
            let unclear = (Outcome::Unclear, lasting.reason().to_owned(), false);
            assert_eq!(told(&[(0.97, Some(lasting))]), unclear);
        }
    }
}
