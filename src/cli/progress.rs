//! Progress on standard error: a bar on a terminal, else a plain line every few seconds, or lines of JSON.

use std::io::{IsTerminal, Write, stderr};
use std::path::Path;
use std::sync::{Mutex, Once};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};
use serde_json::{Value, json};

use super::notice;
use crate::engine::{Observer, Pinned, Progress, Render, Renderer, Rendering};
use crate::error::Error;
use crate::error::Result;

/// Time between plain lines.
const INTERVAL: Duration = Duration::from_secs(3);
/// And between lines of JSON.
const JSON_INTERVAL: Duration = Duration::from_secs(1);

/// How progress is told.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Telling {
    /// A bar on a terminal, else lines.
    Auto,
    /// A JSON object a line: `schema`, `event`, `done` and `total` samples, `eta_s`, `rays`.
    Json,
    /// Not at all.
    None,
}

impl Telling {
    pub(super) const ALL: [Self; 3] = [Self::Auto, Self::Json, Self::None];

    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Auto => "auto",
            Self::Json => "json",
            Self::None => "none",
        }
    }
}

/// Renders the image and shows how far it is.
pub(super) fn render(renderer: &Renderer, title: &str, telling: Telling) -> Result<Render> {
    let mut rendering = renderer.begin()?;
    let progress = ProgressReport::new(renderer, title, &rendering, telling);
    let advanced = renderer.advance(&mut rendering, &progress);
    progress.finish();
    advanced.and_then(|()| renderer.finish(&mut rendering))
}

/// Shows how far one render is.
pub(super) struct ProgressReport {
    start: Instant,
    /// What was done before.
    begun: Progress,
    samples: u64,
    display: Display,
}

enum Display {
    None,
    Bar(ProgressBar),
    Lines { title: String, last: Mutex<Told> },
    Json { last: Mutex<Told> },
}

/// What was told last, and when.
struct Told {
    samples: u64,
    when: Instant,
}

impl ProgressReport {
    pub(super) fn new(
        renderer: &Renderer,
        title: &str,
        rendering: &Rendering,
        telling: Telling,
    ) -> Self {
        static SAID: Once = Once::new();
        if renderer.pinned() == Pinned::Failed && telling == Telling::Auto {
            SAID.call_once(|| {
                notice(format_args!(
                    "threads cannot be pinned to cores here, speeds may vary more"
                ));
            });
        }
        let (begun, samples) = (rendering.progress(), rendering.film.samples_to_do());
        let start = Instant::now();
        let last = Mutex::new(Told { samples: begun.samples, when: start });
        let display = match telling {
            Telling::None => Display::None,
            Telling::Json => Display::Json { last },
            Telling::Auto if stderr().is_terminal() => {
                let bar = ProgressBar::new(samples);
                let style = "{prefix} {wide_bar} {percent:>3}%  {msg}";
                bar.set_style(ProgressStyle::with_template(style).expect("the template is valid"));
                bar.set_prefix(title.to_owned());
                Display::Bar(bar)
            }
            Telling::Auto => Display::Lines { title: title.to_owned(), last },
        };
        let report = Self { start, begun, samples, display };
        report.event("start", begun, None);
        report
    }

    /// Removes the bar.
    pub(super) fn finish(&self) {
        if let Display::Bar(bar) = &self.display {
            bar.finish_and_clear();
        }
    }

    /// All is done, and written.
    pub(super) fn done(&self, progress: Progress) {
        self.event("done", progress, None);
    }

    /// The render is kept in `file`; `event` says why.
    pub(super) fn kept(&self, event: &str, progress: Progress, file: &Path) {
        self.event(event, progress, Some(("file", file.display().to_string())));
    }

    /// The render is stopped, and not kept.
    pub(super) fn lost(&self, progress: Progress) {
        self.event("stopped", progress, None);
    }

    /// Tells what went wrong, though the render goes on.
    pub(super) fn warn(&self, progress: Progress, error: &Error) {
        match &self.display {
            Display::Json { .. } => {
                self.event("warning", progress, Some(("message", error.to_string())));
            }
            Display::Bar(bar) => {
                bar.suspend(|| notice(format_args!("{error}, the render goes on")))
            }
            _ => notice(format_args!("{error}, the render goes on")),
        }
    }

    /// Samples a second, since the report began.
    fn rate(&self, count: u64, begun: u64) -> f64 {
        (count - begun) as f64 / self.start.elapsed().as_secs_f64()
    }

    fn eta(&self, progress: Progress) -> f64 {
        (self.samples - progress.samples) as f64 / self.rate(progress.samples, self.begun.samples)
    }

    fn rates(&self, progress: Progress) -> String {
        format!(
            "{:.2} Msamples/s  {:.2} Mrays/s  ETA {:.0} s",
            self.rate(progress.samples, self.begun.samples) * 1e-6,
            self.rate(progress.rays, self.begun.rays) * 1e-6,
            self.eta(progress),
        )
    }

    /// A line for programs.
    fn event(&self, event: &str, progress: Progress, more: Option<(&str, String)>) {
        if !matches!(self.display, Display::Json { .. }) {
            return;
        }
        let Progress { samples, rays } = progress;
        let eta = match self.samples - samples {
            0 => Some(0.0),
            _ => Some(self.eta(progress)).filter(|eta| eta.is_finite()),
        };
        let mut line = json!({
            "schema": 1,
            "event": event,
            "done": samples,
            "total": self.samples,
            "eta_s": eta,
            "rays": rays,
        });
        if let Some((name, value)) = more {
            line[name] = Value::from(value);
        }
        tell_programs(&line);
    }
}

/// Tells programs that a render of so many samples was done before: nobody knows by how many rays.
pub(super) fn tell_complete(samples: u64) {
    tell_programs(&json!({
        "schema": 1,
        "event": "done",
        "done": samples,
        "total": samples,
        "eta_s": 0.0,
        "rays": null,
    }));
}

fn tell_programs(line: &Value) {
    // There is nowhere to say that standard error is closed.
    let _ = writeln!(stderr(), "{line}");
}

impl Observer for ProgressReport {
    fn progressed(&self, progress: Progress) {
        // Several threads report: an earlier report may come later.
        let due = |last: &Mutex<Told>, interval, tell: &dyn Fn()| {
            let Ok(mut last) = last.lock() else { return };
            if last.when.elapsed() >= interval && progress.samples >= last.samples {
                *last = Told { samples: progress.samples, when: Instant::now() };
                tell();
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
                    let percent = progress.samples * 100 / self.samples;
                    notice(format_args!("{title} {percent}%  {}", self.rates(progress)));
                });
            }
            Display::Json { last } => {
                due(last, JSON_INTERVAL, &|| self.event("progress", progress, None));
            }
        }
    }
}
