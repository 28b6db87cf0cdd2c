//! Pictures of the page: phone, laptop and large screen, light and dark.

use crate::chromium::Chromium;
use crate::viewer::Viewer;
use anyhow::{Context as _, Result};
use std::fs;
use std::path::Path;

/// Width, height and pixels for each unit, as a person has them.
const SIZES: [(u32, u32, f64); 3] = [(390, 844, 2.0), (1366, 768, 1.0), (2560, 1440, 1.0)];

/// Writes a screenshot of each size in each scheme, of the sheet that is open, and of the help.
pub(crate) fn take(program: &Path, chromium: &Chromium, folder: &Path) -> Result<()> {
    fs::create_dir_all(folder).with_context(|| format!("cannot make {}", folder.display()))?;
    let viewer = Viewer::start(program, "shapes4")?;
    let page = chromium.open(&viewer.url)?;
    page.wait("a state", "epoch() > 0")?;
    page.evaluate("set('wipe', true)")?;
    for (width, height, scale) in SIZES {
        // A large picture looks as good with fewer samples of each pixel.
        let samples = if width > 2000 { 4 } else { 16 };
        page.evaluate(&format!("set('samples', {samples})"))?;
        page.wait(
            "the samples",
            &format!("rotundStatistics.state.settings.samples === {samples}"),
        )?;
        page.resize(width, height, scale)?;
        let has_size = format!("innerWidth === {width} && innerHeight === {height}");
        page.wait("the size", &has_size)?;
        let fitted = "rotundStatistics.state.width === Math.min(2560, \
            Math.round(find('stage').clientWidth * devicePixelRatio))";
        page.wait("a picture of that size", fitted)?;
        page.wait_done()?;
        page.mouse("mouseMoved", page.middle("#picture")?, "none")?;
        for scheme in ["light", "dark"] {
            page.prefer(scheme)?;
            let write = |name: &str| -> Result<()> {
                let path = folder.join(format!("{width}-{scheme}{name}.png"));
                fs::write(&path, page.screenshot()?)
                    .with_context(|| format!("cannot write {}", path.display()))
            };
            write("")?;
            if width < 500 {
                page.evaluate("find('sheet').click()")?;
                write("-sheet")?;
                page.evaluate("find('sheet').click()")?;
            } else if width < 2000 {
                page.evaluate("find('help').click()")?;
                write("-help")?;
                page.evaluate("find('help-dialog').close()")?;
                page.evaluate("find('long-render').click()")?;
                page.wait("the command", "find('text-dialog').open")?;
                write("-command")?;
                page.evaluate("find('text-dialog').close()")?;
            }
        }
    }
    Ok(())
}
