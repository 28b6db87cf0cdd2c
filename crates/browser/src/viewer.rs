//! A running `rotund view`, seen from outside.

use anyhow::{Context as _, Result, bail};
use std::ffi::OsStr;
use std::io::{BufRead as _, BufReader, Read as _};
use std::path::Path;
use std::process::{Child, Command, Stdio};

/// A running program, which ends with this value.
#[derive(Debug)]
pub(crate) struct Viewer {
    process: Child,
    /// The address of its page.
    pub(crate) url: String,
}

/// Ticks in a second of the times in `/proc`: the same on all Linux systems.
const TICKS: f64 = 100.0;

impl Viewer {
    /// The name of the program's file.
    pub(crate) const PROGRAM: &str = if cfg!(windows) { "rotund.exe" } else { "rotund" };

    /// Starts the program and waits until it has printed its address.
    pub(crate) fn start(program: &Path, scene: impl AsRef<OsStr>) -> Result<Self> {
        let mut command = Command::new(program);
        command.arg("view").arg(scene).arg("--no-browser").stdout(Stdio::piped());
        command.stderr(Stdio::piped()).stdin(Stdio::null());
        let mut process = command.spawn().context("cannot start the viewer")?;
        let mut url = String::new();
        BufReader::new(process.stdout.take().context("a pipe")?).read_line(&mut url)?;
        let mut errors = process.stderr.take().context("a pipe")?;
        if !url.starts_with("http://") {
            let mut text = String::new();
            errors.read_to_string(&mut text)?;
            bail!("the viewer has not started: {text}");
        }
        // Nobody reads its messages; it must not wait for that.
        std::thread::spawn(move || std::io::copy(&mut errors, &mut std::io::sink()));
        Ok(Self { process, url: url.trim().to_owned() })
    }

    /// Returns the address behind another port.
    pub(crate) fn url_at(&self, port: u16) -> Result<String> {
        Ok(self.url.replacen(&format!(":{}/", self.port()?), &format!(":{port}/"), 1))
    }

    pub(crate) fn port(&self) -> Result<u16> {
        let port = self.url.split(':').nth(2).and_then(|rest| rest.split('/').next());
        Ok(port.context("an address with a port")?.parse()?)
    }

    /// Returns the seconds of processor time that it has used.
    pub(crate) fn processor_seconds(&self) -> Result<f64> {
        let text = std::fs::read_to_string(format!("/proc/{}/stat", self.process.id()))?;
        // The name, in parentheses, may hold spaces.
        let (_, fields) = text.rsplit_once(')').context("a line of /proc")?;
        let fields: Vec<&str> = fields.split_whitespace().collect();
        let ticks = |index: usize| fields.get(index).and_then(|field| field.parse::<f64>().ok());
        let (user, system) = (ticks(11), ticks(12));
        Ok((user.context("a number")? + system.context("a number")?) / TICKS)
    }

    /// Returns the bytes of memory that it holds.
    pub(crate) fn memory(&self) -> Result<f64> {
        self.bytes("VmRSS:")
    }

    /// Returns the most bytes of memory that it has held.
    pub(crate) fn peak(&self) -> Result<f64> {
        self.bytes("VmHWM:")
    }

    fn bytes(&self, entry: &str) -> Result<f64> {
        let text = std::fs::read_to_string(format!("/proc/{}/status", self.process.id()))?;
        let line = text.lines().find_map(|line| line.strip_prefix(entry));
        let kibibytes = line.and_then(|line| line.split_whitespace().next());
        Ok(kibibytes.context("a line of /proc")?.parse::<f64>()? * 1024.0)
    }
}

impl Drop for Viewer {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}
