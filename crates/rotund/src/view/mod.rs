//! `view SCENE`: a page in the browser that shows a scene, answers the hand, and gets better at
//! rest.
//!
//! The page comes from a server in this program. It listens on the loopback interface unless told
//! otherwise, and answers only requests with a random token in their address.

use crate::cancel::Cancel;
use crate::message::{note, one_line, warn};
use crate::scene_source::{LoadArgs, exists, is_lone, load_silently};
use anyhow::{Result, bail};
use guard::Guard;
use rotund_report::console::say;
use rotund_viewer::{Content, Viewer};
use shared::{Server, Sessions};
use std::env;
use std::ffi::{OsStr, OsString};
use std::io::ErrorKind;
use std::net::{IpAddr, Ipv4Addr, SocketAddr, TcpListener};
use std::path::{Path, PathBuf};
use std::thread;
use std::time::{Duration, Instant};

mod assets;
mod command;
mod connections;
mod guard;
mod remover;
mod save;
mod server;
mod shared;
mod socket;

const EXAMPLES: &str = "\
Examples:
  rotund view shapes4
  rotund view cloud.ply --radius 0.01
  rotund view scene.json --port 8000 --no-browser

On another machine, with the port that it prints:
  ssh -L 7171:localhost:7171 machine rotund view scene.json --no-browser";

/// The port unless it is taken: always the same, so that a tunnel can be set up beforehand.
const PORT: u16 = 7171;

/// Options of `view`.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub struct Args {
    /// The name of a built-in scene, or the path of a JSON, PLY, OBJ, SWC, TCK, TRK, XYZ,
    /// TXT, CSV, PTS or ASC file.
    scene: OsString,
    /// Port of the server. Default: 7171, or any free one if that is taken.
    #[arg(long, value_parser = clap::value_parser!(u16).range(1..))]
    port: Option<u16>,
    /// Address to listen on instead of the loopback interface, so that other machines can connect.
    /// The connection is not encrypted, and whoever knows the printed URL can use it.
    #[arg(long, value_name = "ADDRESS")]
    listen: Option<IpAddr>,
    /// Print the URL, but open no browser.
    #[arg(long)]
    no_browser: bool,
    #[command(flatten)]
    loading: LoadArgs,
}

pub(crate) fn run(args: Args) -> Result<()> {
    if !exists(&args.scene) {
        // Its error is that of any other command.
        load_silently(&args.scene, &args.loading)?;
    }
    let listener = listen(args.listen, args.port)?;
    let address = listener.local_addr()?;
    let guard = Guard::new(args.listen)?;
    let cancel = Cancel::listen();
    let name =
        Path::new(&args.scene).file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let render = render_command(&args, &name);
    let is_lone = is_lone(&args.scene);
    let (scene, loading) = (args.scene, args.loading);
    let (denoiser, without_denoiser) = match remover::load() {
        Ok(denoiser) => (Some(denoiser), None),
        Err(reason) => (None, Some(reason)),
    };
    // A file that is broken at first is read again when it is mended.
    let path = PathBuf::from(&scene);
    let files = if path.is_file() { vec![path] } else { Vec::new() };
    let viewer = Viewer::open_with(files, denoiser, move || content(&scene, &loading));
    let url = url(address, guard.token());
    say(&url)?;
    if let Some(address) = args.listen.filter(|address| !address.is_loopback()) {
        let place = if address.is_unspecified() { "every address" } else { "an address" };
        warn(format!(
            "the viewer listens on {place} of this machine: anybody who sees its unencrypted \
             traffic learns the URL and can use it"
        ));
    }
    let (scene, sessions) = (name.clone(), Sessions::default());
    let server = Server { guard, viewer, scene, render, is_lone, without_denoiser, sessions };
    let thread = thread::Builder::new().name("server".to_owned());
    let running = thread.spawn(move || server::run(listener, server))?;
    if args.no_browser || !open_browser(&url) {
        note("open this address in a browser; Ctrl-C ends the viewer");
    } else {
        note(format!("{name} opens in the browser; Ctrl-C ends the viewer"));
    }
    while !cancel.requested() {
        if running.is_finished() {
            running.join().unwrap_or_else(|_| bail!("the server has failed"))?;
            break;
        }
        thread::sleep(Duration::from_millis(100));
    }
    Ok(())
}

/// Takes the port that was asked for, or else the usual one or any.
fn listen(address: Option<IpAddr>, port: Option<u16>) -> Result<TcpListener> {
    let address = address.unwrap_or(Ipv4Addr::LOCALHOST.into());
    let bind = |port| TcpListener::bind(SocketAddr::new(address, port));
    let bound = match (port, bind(port.unwrap_or(PORT))) {
        (None, Err(error)) if error.kind() == ErrorKind::AddrInUse => bind(0),
        (_, bound) => bound,
    };
    bound.map_err(|error| {
        let place = SocketAddr::new(address, port.unwrap_or(PORT));
        match error.kind() {
            ErrorKind::AddrInUse => {
                anyhow::anyhow!("cannot listen on {place}: the port is in use; give another --port")
            }
            _ => anyhow::Error::from(error).context(format!("cannot listen on {place}")),
        }
    })
}

fn url(mut address: SocketAddr, token: &str) -> String {
    if address.ip().is_unspecified() {
        address.set_ip(Ipv4Addr::LOCALHOST.into());
    }
    format!("http://{address}/{token}/")
}

/// Loads the scene, also again, and says in the terminal what came of it.
fn content(scene: &OsStr, loading: &LoadArgs) -> Result<Content, String> {
    let start = Instant::now();
    let loaded = load_silently(scene, loading).and_then(|(name, loaded)| {
        if loaded.scene.cameras.is_empty() {
            bail!("{name}: the scene has neither a camera nor anything to see");
        }
        crate::memory::check_scene(&loaded.scene)?;
        Ok((name, loaded))
    });
    match loaded {
        Ok((name, loaded)) => {
            loaded.warnings.iter().for_each(warn);
            note(format!("{name}: loaded in {:.1} s", start.elapsed().as_secs_f64()));
            let (scene, warnings, files) = (loaded.scene, loaded.warnings, loaded.files);
            Ok(Content { name, scene, warnings, files })
        }
        Err(error) => {
            let text = one_line(&error);
            note(format!("error: {text}"));
            Err(text)
        }
    }
}

/// Returns the command that renders the scene of these arguments into a file, for a shell.
fn render_command(args: &Args, name: &str) -> String {
    let mut words = vec![command::quote(&args.scene.to_string_lossy())];
    words.extend(args.loading.words());
    format!("rotund render {} --out {}", words.join(" "), command::quote(&format!("{name}.png")))
}

/// Opens a browser, if there is a desktop to open it on; returns whether it did.
fn open_browser(url: &str) -> bool {
    let is_set = |name: &str| env::var_os(name).is_some_and(|value| !value.is_empty());
    // Elsewhere on Unix a browser of the terminal would open in the middle of our messages.
    let has_desktop =
        cfg!(any(windows, target_os = "macos")) || is_set("DISPLAY") || is_set("WAYLAND_DISPLAY");
    has_desktop && open::that_detached(url).is_ok()
}
