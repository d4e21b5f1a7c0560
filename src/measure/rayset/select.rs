//! Selects which rays of a recording to keep.

/// Number of rays in a run of consecutive rays. Rays are kept in whole runs, so that neighbouring
/// rays stay together.
pub(super) const RUN: u64 = 2048;

/// Selects whole, evenly spread runs from a stream of rays, up to a maximum number of rays.
#[derive(Clone, Debug)]
pub(super) struct Selection {
    /// Number of runs in the stream, and of runs to keep; `None` keeps every ray.
    runs: Option<(u64, u64)>,
    seen: u64,
    /// Runs kept so far.
    kept: u64,
}

impl Selection {
    pub(super) fn new(total: u64, most: u64) -> Self {
        let runs = (total > most).then_some((total / RUN, most / RUN));
        Self { runs, seen: 0, kept: 0 }
    }

    /// Whether the next ray is kept.
    pub(super) fn next(&mut self) -> bool {
        let index = self.seen;
        self.seen += 1;
        let Some((runs, wanted)) = self.runs else { return true };
        if self.kept == wanted || index / RUN != self.kept * runs / wanted {
            return false;
        }
        if index % RUN == RUN - 1 {
            self.kept += 1;
        }
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn kept(total: u64, most: u64) -> Vec<u64> {
        let mut selection = Selection::new(total, most);
        (0..total).filter(|_| selection.next()).collect()
    }

    #[test]
    fn whole_runs_are_kept_evenly() {
        assert_eq!(kept(5000, 5000).len(), 5000, "all rays are kept if they are few");
        let some = kept(100 * RUN + 77, 25 * RUN + 5);
        assert_eq!(some.len() as u64, 25 * RUN);
        for (run, rays) in some.chunks_exact(RUN as usize).enumerate() {
            assert_eq!(rays[0], run as u64 * 4 * RUN);
            assert_eq!(rays[RUN as usize - 1], rays[0] + RUN - 1);
        }
        assert_eq!(kept(3 * RUN, RUN), (0..RUN).collect::<Vec<_>>());
    }
}
