//! `ptfast view`: a page in the browser that shows a scene in real time.

mod client;
mod director;
mod guard;
mod hub;
mod message;
mod request;
mod server;
mod socket;
mod trace;
mod watch;

use std::net::{IpAddr, Ipv4Addr};
use std::process::{Command, Stdio};
use std::sync::Arc;
use std::time::SystemTime;

use clap::Args;

use self::director::Director;
use self::guard::Guard;
use self::hub::Hub;
use self::watch::Watch;
use super::arguments::display::DisplayArgs;
use super::arguments::{SampleArgs, SceneLimitArgs};
use super::console::{advise_on_build, say};
use super::progress::{self, ProgressMode};
use crate::accel::TreeQuality;
use crate::engine::{ComputeSettings, Engine, ImageSettings, Pin, PlanChoice, Session};
use crate::error::{Error, Result};
use crate::interrupt;
use crate::isa::Isa;
use crate::limits::{MAX_SPP, MAX_THREADS};
use crate::live::{View, keep_what_is_freed};
use crate::scene::Scene;

const PAGE: &str = "Page";

#[derive(Clone, Debug, Args)]
pub(crate) struct ViewArgs {
    #[command(flatten)]
    pub(crate) sample: SampleArgs,
    /// Samples per pixel at which the page gives the hash [default: the scene's]
    #[arg(long, value_name = "N", help_heading = super::arguments::IMAGE, value_parser = clap::value_parser!(u32).range(1..=i64::from(MAX_SPP)))]
    pub(crate) spp: Option<u32>,
    #[command(flatten)]
    pub(crate) display: DisplayArgs,
    /// Port of the page, 0 for any that is free
    #[arg(long, value_name = "N", help_heading = PAGE, default_value_t = 7860)]
    port: u16,
    /// Address on which the page is served: 0.0.0.0 for all of this machine, which lets everybody in who knows the
    /// page's address with its token
    #[arg(long, value_name = "ADDRESS", help_heading = PAGE, default_value_t = IpAddr::V4(Ipv4Addr::LOCALHOST))]
    listen: IpAddr,
    /// Open the page in a browser
    #[arg(long, help_heading = PAGE)]
    open: bool,
    /// Worker threads [default: one per available core]
    #[arg(short = 'j', long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=i64::from(MAX_THREADS)))]
    threads: Option<u32>,
    #[command(flatten)]
    pub(crate) limits: SceneLimitArgs,
}

impl ViewArgs {
    fn load(&self) -> Result<Scene> {
        let reading = format!("reading {}", self.sample.scene.name());
        progress::waiting(&reading, ProgressMode::Auto, || {
            self.limits.read_for(&self.sample.scene, self.sample.size())?.resolve()
        })
    }

    fn settings(&self, scene: &Scene) -> Result<ImageSettings> {
        let of_samples = self.sample.settings(scene)?;
        let settings = ImageSettings { spp: self.spp.unwrap_or(of_samples.spp), ..of_samples };
        settings.check(scene.limits())?;
        Ok(settings)
    }

    fn compute(&self) -> ComputeSettings {
        ComputeSettings {
            engine: Engine::Wavefront,
            threads: self.threads.unwrap_or(0),
            pin: Pin::Off,
            // A viewer waits for the first picture.
            trees: TreeQuality::Fast,
            plan: PlanChoice::Usual,
            ..ComputeSettings::default()
        }
    }
}

pub(crate) fn run(args: &ViewArgs) -> Result<()> {
    interrupt::leave_at_once(true);
    interrupt::watch()?;
    keep_what_is_freed();
    // A port that is taken is reported before a large scene is loaded.
    let guard = Guard::new(args.listen)?;
    let server = server::bind(args.listen, args.port)?;
    let address = guard.address(&server)?;
    let began = SystemTime::now();
    let scene = args.load()?;
    let settings = args.settings(&scene)?;
    let watch = Watch::new(args.sample.scene.name(), &scene, began);
    advise_on_build(Isa::Avx2);
    let hub = Arc::new(Hub::default());
    server::serve(server, guard, Arc::clone(&hub))
        .map_err(|error| Error::Resource(format!("cannot serve the page: {error}")))?;
    say(format_args!("{address}"))?;
    if args.open {
        open(&address)?;
    }
    let session = Session::new(scene, View::first(&settings), args.compute())?;
    interrupt::leave_at_once(false);
    Director::new(args, session, settings, hub, watch).run();
    Ok(())
}

/// Opens the page in the browser that the system prefers.
fn open(address: &str) -> Result<()> {
    let program = if cfg!(target_os = "macos") { "open" } else { "xdg-open" };
    let opened = Command::new(program)
        .arg(address)
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn();
    opened.map(drop).map_err(|error| {
        Error::Resource(format!(
            "--open: cannot run {program} ({error}): open the page yourself, {address}"
        ))
    })
}
