//! Progress on standard error: a bar on a terminal, a line every few seconds
//! elsewhere, or JSON on request.

use std::io::{IsTerminal, Write, stderr};
use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, Once};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};
use serde_json::{Value, json};

use super::console::{notice, one_line};
use crate::engine::{Observer, Pinned, Progress, Render, Session, Until};
use crate::error::Error;
use crate::error::Result;

/// Time between plain lines.
const INTERVAL: Duration = Duration::from_secs(3);
/// Time between lines of JSON.
const JSON_INTERVAL: Duration = Duration::from_secs(1);

/// How progress is shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum ProgressMode {
    /// A bar on a terminal, otherwise lines.
    Auto,
    /// One JSON object per line: `schema`, `event`, `done` and `total` samples, `eta_s`, `rays`.
    Json,
    None,
}

names! { pub(crate) ProgressMode: Auto = "auto", Json = "json", None = "none" }

/// Does `work`, and shows on a terminal what it is and since when.
pub(crate) fn waiting<T>(what: &str, mode: ProgressMode, work: impl FnOnce() -> T) -> T {
    if mode != ProgressMode::Auto || !stderr().is_terminal() {
        return work();
    }
    let bar = ProgressBar::new_spinner().with_prefix(one_line(what));
    bar.set_style(ProgressStyle::with_template("{prefix} {elapsed}").expect("it is valid"));
    bar.enable_steady_tick(Duration::from_secs(1));
    let done = work();
    bar.finish_and_clear();
    done
}

/// Renders the image and shows the progress.
pub(crate) fn render(session: &Session, title: &str, mode: ProgressMode) -> Result<Render> {
    let progress = ProgressReport::new(session, title, mode);
    let rendered = session.render(Until::Complete, &progress);
    progress.finish();
    rendered.and_then(|_| session.finish())
}

/// Shows the progress of one render.
pub(crate) struct ProgressReport {
    start: Instant,
    /// The progress when the report began: that of earlier runs if the render is continued.
    begun: Progress,
    /// Number of samples of the complete render, as far as it is known.
    samples: AtomicU64,
    display: Display,
}

enum Display {
    None,
    Bar(ProgressBar),
    Lines { title: String, last: Mutex<Shown> },
    Json { last: Mutex<Shown> },
}

/// The last report.
struct Shown {
    samples: u64,
    when: Instant,
}

impl ProgressReport {
    pub(crate) fn new(session: &Session, title: &str, mode: ProgressMode) -> Self {
        static REPORTED: Once = Once::new();
        if session.renderer().pinned() == Pinned::Failed && mode == ProgressMode::Auto {
            REPORTED.call_once(|| {
                notice(format_args!("cannot pin threads to cores: speeds may vary more"));
            });
        }
        let (begun, samples) = (session.progress(), session.state().film.samples_to_do());
        let start = Instant::now();
        let last = Mutex::new(Shown { samples: begun.samples, when: start });
        let title = one_line(title);
        let display = match mode {
            ProgressMode::None => Display::None,
            ProgressMode::Json => Display::Json { last },
            ProgressMode::Auto if stderr().is_terminal() => {
                let bar = ProgressBar::new(samples);
                let style = "{prefix} {wide_bar} {percent:>3}%  {msg}";
                bar.set_style(ProgressStyle::with_template(style).expect("the template is valid"));
                bar.set_prefix(title);
                Display::Bar(bar)
            }
            ProgressMode::Auto => Display::Lines { title, last },
        };
        let report = Self { start, begun, samples: samples.into(), display };
        report.event("start", begun, None);
        report
    }

    /// Says how many samples the complete render is expected to have.
    pub(crate) fn expect(&self, samples: u64) {
        self.samples.store(samples, Ordering::Relaxed);
        if let Display::Bar(bar) = &self.display {
            bar.set_length(samples);
        }
    }

    /// Number of samples of the complete render, of which `progress` has some.
    fn total(&self, progress: Progress) -> u64 {
        self.samples.load(Ordering::Relaxed).max(progress.samples)
    }

    /// Removes the bar.
    pub(crate) fn finish(&self) {
        if let Display::Bar(bar) = &self.display {
            bar.finish_and_clear();
        }
    }

    /// Reports that the render is complete and its output is written.
    pub(crate) fn done(&self, progress: Progress) {
        self.event("done", progress, None);
    }

    /// Says to the person who interrupts the render what happens now, and what another Ctrl-C would do.
    pub(crate) fn say_that_it_stops(&self) {
        let say = || {
            notice(format_args!(
                "stopping, and saving what is done; another Ctrl-C ends at once, without saving"
            ));
        };
        match &self.display {
            Display::Json { .. } => {}
            Display::Bar(bar) => bar.suspend(say),
            _ => say(),
        }
    }

    /// Reports that the render was saved in `file`; `event` is the reason.
    pub(crate) fn saved(&self, event: &str, progress: Progress, file: &Path) {
        self.event(event, progress, Some(("file", file.display().to_string())));
    }

    /// Reports that the render was stopped and could not be saved.
    pub(crate) fn lost(&self, progress: Progress) {
        self.event("stopped", progress, None);
    }

    /// Reports an error after which the render continues.
    pub(crate) fn warn(&self, progress: Progress, error: &Error) {
        match &self.display {
            Display::Json { .. } => {
                self.event("warning", progress, Some(("message", error.to_string())));
            }
            Display::Bar(bar) => {
                bar.suspend(|| notice(format_args!("{error}; the render continues")))
            }
            _ => notice(format_args!("{error}; the render continues")),
        }
    }

    /// Samples or rays per second since the report began, where `begun` is their number at that
    /// time.
    fn rate(&self, count: u64, begun: u64) -> f64 {
        (count - begun) as f64 / self.start.elapsed().as_secs_f64()
    }

    fn eta(&self, progress: Progress) -> f64 {
        let left = self.total(progress) - progress.samples;
        left as f64 / self.rate(progress.samples, self.begun.samples)
    }

    fn rates(&self, progress: Progress) -> String {
        format!(
            "{:.2} Msamples/s  {:.2} Mrays/s  ETA {}",
            self.rate(progress.samples, self.begun.samples) * 1e-6,
            self.rate(progress.rays, self.begun.rays) * 1e-6,
            duration(self.eta(progress)),
        )
    }

    /// Writes a JSON line if the progress is shown as JSON.
    fn event(&self, event: &str, progress: Progress, more: Option<(&str, String)>) {
        if !matches!(self.display, Display::Json { .. }) {
            return;
        }
        let Progress { samples, rays } = progress;
        let total = self.total(progress);
        let eta = match total - samples {
            0 => Some(0.0),
            _ => Some(self.eta(progress)).filter(|eta| eta.is_finite()),
        };
        let mut line = json!({
            "schema": 1,
            "event": event,
            "done": samples,
            "total": total,
            "eta_s": eta,
            "rays": rays,
        });
        if let Some((name, value)) = more {
            line[name] = Value::from(value);
        }
        write_line(&line);
    }
}

/// Writes the JSON line for a render that an earlier run completed. The number of its rays is
/// unknown.
pub(crate) fn write_complete(samples: u64) {
    write_line(&json!({
        "schema": 1,
        "event": "done",
        "done": samples,
        "total": samples,
        "eta_s": 0.0,
        "rays": null,
    }));
}

/// Seconds as `7 s`, `3 min 20 s` or `2 h 05 min`.
pub(crate) fn duration(seconds: f64) -> String {
    if !seconds.is_finite() {
        return "unknown".to_owned();
    }
    let seconds = seconds.round() as u64;
    let (hours, minutes) = (seconds / 3600, seconds / 60 % 60);
    match (hours, minutes) {
        (0, 0) => format!("{seconds} s"),
        (0, _) => format!("{minutes} min {:02} s", seconds % 60),
        _ => format!("{hours} h {minutes:02} min"),
    }
}

fn write_line(line: &Value) {
    // Errors are ignored: standard error is where they would be reported.
    let _ = writeln!(stderr(), "{line}");
}

impl Observer for ProgressReport {
    fn progressed(&self, progress: Progress) {
        // Several threads report, and an earlier state can arrive after a later one.
        let due = |last: &Mutex<Shown>, interval, show: &dyn Fn()| {
            let Ok(mut last) = last.lock() else { return };
            if last.when.elapsed() >= interval && progress.samples >= last.samples {
                *last = Shown { samples: progress.samples, when: Instant::now() };
                show();
            }
        };
        match &self.display {
            Display::None => {}
            Display::Bar(bar) => {
                bar.set_position(bar.position().max(progress.samples));
                bar.set_message(self.rates(progress));
            }
            Display::Lines { title, last } => {
                due(last, INTERVAL, &|| {
                    let percent = progress.samples * 100 / self.total(progress).max(1);
                    notice(format_args!("{title} {percent}%  {}", self.rates(progress)));
                });
            }
            Display::Json { last } => {
                due(last, JSON_INTERVAL, &|| self.event("progress", progress, None));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn durations_have_hours_and_minutes() {
        let cases = [(6.6, "7 s"), (200.0, "3 min 20 s"), (7500.0, "2 h 05 min")];
        for (seconds, text) in cases {
            assert_eq!(duration(seconds), text);
        }
        assert_eq!(duration(f64::INFINITY), "unknown");
    }
}
