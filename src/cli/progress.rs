//! Progress on standard error: a bar on a terminal, else a plain line every few seconds.

use std::io::{IsTerminal, stderr};
use std::sync::{Mutex, Once};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};

use super::notice;
use crate::engine::{Observer, Pinned, Progress, Render, RenderSettings, Renderer};
use crate::error::Result;

/// Time between plain lines.
const INTERVAL: Duration = Duration::from_secs(3);

/// Renders and shows how far it is, unless `quiet`.
pub(super) fn render(
    renderer: &Renderer<'_>,
    title: &str,
    settings: &RenderSettings,
    quiet: bool,
) -> Result<Render> {
    static SAID: Once = Once::new();
    if renderer.pinned() == Pinned::Failed && !quiet {
        SAID.call_once(|| {
            notice(format_args!("threads cannot be pinned to cores here, speeds may vary more"));
        });
    }
    let progress = ProgressReport::new(title, settings, quiet);
    let render = renderer.render_observed(&progress);
    progress.finish();
    render
}

/// Shows how far one render is.
struct ProgressReport {
    start: Instant,
    samples: u64,
    display: Display,
}

enum Display {
    None,
    Bar(ProgressBar),
    Lines { title: String, last: Mutex<Instant> },
}

impl ProgressReport {
    fn new(title: &str, settings: &RenderSettings, quiet: bool) -> Self {
        let samples = settings.paths();
        let start = Instant::now();
        let display = if quiet {
            Display::None
        } else if stderr().is_terminal() {
            let bar = ProgressBar::new(samples);
            let style = "{prefix} {wide_bar} {percent:>3}%  {msg}";
            bar.set_style(ProgressStyle::with_template(style).expect("the template is valid"));
            bar.set_prefix(title.to_owned());
            Display::Bar(bar)
        } else {
            Display::Lines { title: title.to_owned(), last: Mutex::new(start) }
        };
        Self { start, samples, display }
    }

    /// Removes the bar.
    fn finish(&self) {
        if let Display::Bar(bar) = &self.display {
            bar.finish_and_clear();
        }
    }

    fn rates(&self, progress: Progress) -> String {
        let seconds = self.start.elapsed().as_secs_f64();
        let done = progress.samples as f64;
        format!(
            "{:.2} Msamples/s  {:.2} Mrays/s  ETA {:.0} s",
            done / seconds * 1e-6,
            progress.rays as f64 / seconds * 1e-6,
            seconds * (self.samples as f64 / done - 1.0),
        )
    }
}

impl Observer for ProgressReport {
    fn progressed(&self, progress: Progress) {
        match &self.display {
            Display::None => {}
            Display::Bar(bar) => {
                // Several threads report: an earlier report may come later.
                bar.set_position(bar.position().max(progress.samples));
                bar.set_message(self.rates(progress));
            }
            Display::Lines { title, last } => {
                let Ok(mut last) = last.lock() else { return };
                if last.elapsed() >= INTERVAL {
                    *last = Instant::now();
                    let percent = progress.samples * 100 / self.samples;
                    notice(format_args!("{title} {percent}%  {}", self.rates(progress)));
                }
            }
        }
    }
}
