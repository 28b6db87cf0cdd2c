//! A headless Chromium of its own: without windows, with an empty profile that it leaves behind.

use crate::devtools::DevTools;
use crate::page::Page;
use anyhow::{Context as _, Result, bail};
use serde_json::json;
use std::cell::RefCell;
use std::env;
use std::io::{BufRead as _, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::rc::Rc;
use tempfile::TempDir;

/// Names of the program on different systems.
const NAMES: [&str; 4] = ["chromium", "chromium-browser", "google-chrome", "chrome"];
/// The variable that names the program.
const VARIABLE: &str = "ROTUND_CHROMIUM";

/// A running browser, which ends with this value.
#[derive(Debug)]
pub(crate) struct Chromium {
    process: Child,
    devtools: Rc<RefCell<DevTools>>,
    /// The folder that files are saved into.
    pub(crate) downloads: TempDir,
    _profile: TempDir,
}

/// Returns the path of the browser, if there is one.
pub(crate) fn find() -> Option<PathBuf> {
    if let Some(named) = env::var_os(VARIABLE).filter(|name| !name.is_empty()) {
        return Some(named.into());
    }
    let folders: Vec<PathBuf> = env::split_paths(&env::var_os("PATH")?).collect();
    NAMES.iter().find_map(|name| folders.iter().map(|it| it.join(name)).find(|it| it.is_file()))
}

impl Chromium {
    pub(crate) fn start(program: &Path) -> Result<Self> {
        let profile = tempfile::tempdir()?;
        let downloads = tempfile::tempdir()?;
        let mut command = Command::new(program);
        command.args([
            "--headless=new",
            "--remote-debugging-port=0",
            "--no-first-run",
            "--disable-gpu",
            "--disable-dev-shm-usage",
            "--disable-background-networking",
            "--force-color-profile=srgb",
            "--hide-scrollbars",
        ]);
        if is_root() {
            // Chromium refuses to make its sandbox as root, as in a container.
            command.arg("--no-sandbox");
        }
        command.arg(format!("--user-data-dir={}", profile.path().display()));
        command.arg("about:blank").stdin(Stdio::null()).stdout(Stdio::null());
        let process = command.stderr(Stdio::piped()).spawn();
        let mut process = process.with_context(|| format!("cannot run {}", program.display()))?;
        let address = devtools_address(&mut process)?;
        let mut devtools = DevTools::connect(&address)?;
        let path = downloads.path().to_string_lossy();
        let behavior = json!({ "behavior": "allow", "downloadPath": path });
        devtools.call(None, "Browser.setDownloadBehavior", behavior)?;
        let devtools = Rc::new(RefCell::new(devtools));
        Ok(Self { process, devtools, downloads, _profile: profile })
    }

    /// Opens a page in a tab of its own.
    pub(crate) fn open(&self, url: &str) -> Result<Page> {
        Page::open(Rc::clone(&self.devtools), url)
    }
}

impl Drop for Chromium {
    fn drop(&mut self) {
        // The debugging interface closes all its processes; only if it is gone is one killed.
        let closed = self.devtools.borrow_mut().call(None, "Browser.close", json!({}));
        if closed.is_err() {
            let _ = self.process.kill();
        }
        let _ = self.process.wait();
    }
}

/// Reads what the browser prints until it says where it can be driven, and the rest in a thread,
/// so that it never waits for a reader.
fn devtools_address(process: &mut Child) -> Result<String> {
    let mut lines = BufReader::new(process.stderr.take().context("a pipe")?).lines();
    let mut said = String::new();
    while let Some(Ok(line)) = lines.next() {
        if let Some(address) = line.strip_prefix("DevTools listening on ") {
            let address = address.to_owned();
            std::thread::spawn(move || lines.for_each(drop));
            return Ok(address);
        }
        said += &line;
    }
    bail!("the browser has not started: {said}")
}

#[cfg(unix)]
fn is_root() -> bool {
    use std::os::unix::fs::MetadataExt as _;
    Path::new("/proc/self").metadata().is_ok_and(|own| own.uid() == 0)
}

#[cfg(not(unix))]
fn is_root() -> bool {
    false
}
