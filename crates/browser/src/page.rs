//! A page in a tab: what a person sees of it, and what a person does.

use crate::devtools::DevTools;
use anyhow::{Context as _, Result, bail};
use base64::Engine as _;
use serde_json::{Value, json};
use std::cell::RefCell;
use std::rc::Rc;
use std::thread::sleep;
use std::time::{Duration, Instant};

/// Functions that the checks call, in a page that does not know them.
const HELPERS: &str = include_str!("helpers.js");
/// Time between two looks at a condition.
const LOOK: Duration = Duration::from_millis(15);

/// A page, which closes with this value.
#[derive(Debug)]
pub(crate) struct Page {
    devtools: Rc<RefCell<DevTools>>,
    target: String,
    session: String,
}

impl Page {
    pub(crate) fn open(devtools: Rc<RefCell<DevTools>>, url: &str) -> Result<Self> {
        let (target, session) = {
            let mut devtools = devtools.borrow_mut();
            let blank = json!({ "url": "about:blank" });
            let target = text(&devtools.call(None, "Target.createTarget", blank)?["targetId"])?;
            let attach = json!({ "targetId": target, "flatten": true });
            let attached = devtools.call(None, "Target.attachToTarget", attach)?;
            (target, text(&attached["sessionId"])?)
        };
        let page = Self { devtools, target, session };
        page.call("Page.enable", json!({}))?;
        // Without it, a page that is not in front gets no frames of the screen.
        page.call("Emulation.setFocusEmulationEnabled", json!({ "enabled": true }))?;
        let source = json!({ "source": HELPERS });
        page.call("Page.addScriptToEvaluateOnNewDocument", source)?;
        page.resize(860, 480, 1.0)?;
        page.call("Page.navigate", json!({ "url": url }))?;
        Ok(page)
    }

    pub(crate) fn call(&self, method: &str, parameters: Value) -> Result<Value> {
        self.devtools.borrow_mut().call(Some(&self.session), method, parameters)
    }

    /// Evaluates an expression, and waits for it if it is a promise.
    pub(crate) fn evaluate(&self, expression: &str) -> Result<Value> {
        let parameters =
            json!({ "expression": expression, "awaitPromise": true, "returnByValue": true });
        let mut answer = self.call("Runtime.evaluate", parameters)?;
        if let Some(thrown) = answer.get("exceptionDetails") {
            bail!("{expression} throws {}", thrown["exception"]["description"]);
        }
        Ok(answer["result"]["value"].take())
    }

    pub(crate) fn number(&self, expression: &str) -> Result<f64> {
        self.evaluate(expression)?.as_f64().with_context(|| format!("{expression} is no number"))
    }

    pub(crate) fn string(&self, expression: &str) -> Result<String> {
        text(&self.evaluate(expression)?).with_context(|| format!("{expression} is no text"))
    }

    /// Waits until an expression is true; the error has `what` and the value of `seen`.
    pub(crate) fn wait(&self, what: &str, condition: &str) -> Result<()> {
        self.wait_for(what, condition, Duration::from_secs(20))
    }

    pub(crate) fn wait_for(&self, what: &str, condition: &str, patience: Duration) -> Result<()> {
        let start = Instant::now();
        loop {
            // While a page loads, nothing can be asked of it.
            let value = self.evaluate(condition).unwrap_or_default();
            if value == Value::Bool(true) {
                return Ok(());
            }
            if start.elapsed() > patience {
                let seen = self.evaluate("summary()").unwrap_or_default();
                bail!("{what}: not within {} s; the page says {seen}", patience.as_secs());
            }
            sleep(LOOK);
        }
    }

    /// Waits until all samples are there and drawn; a busy machine takes its time.
    pub(crate) fn wait_done(&self) -> Result<()> {
        self.wait_for("all samples", "isDone()", Duration::from_secs(300))
    }

    /// Sets the size of the window in units of CSS.
    pub(crate) fn resize(&self, width: u32, height: u32, scale: f64) -> Result<()> {
        let size = json!({
            "width": width, "height": height, "deviceScaleFactor": scale, "mobile": width < 500,
        });
        self.call("Emulation.setDeviceMetricsOverride", size)?;
        let touch = json!({ "enabled": width < 500 });
        self.call("Emulation.setTouchEmulationEnabled", touch)?;
        Ok(())
    }

    pub(crate) fn prefer(&self, scheme: &str) -> Result<()> {
        let features = json!([{ "name": "prefers-color-scheme", "value": scheme }]);
        self.call("Emulation.setEmulatedMedia", json!({ "features": features }))?;
        Ok(())
    }

    pub(crate) fn mouse(&self, kind: &str, [x, y]: [f64; 2], button: &str) -> Result<()> {
        let buttons = match (kind, button) {
            ("mouseReleased", _) | (_, "none") => 0,
            (_, "right") => 2,
            _ => 1,
        };
        let event = json!({
            "type": kind, "x": x, "y": y, "button": button, "buttons": buttons, "clickCount": 1,
        });
        self.call("Input.dispatchMouseEvent", event)?;
        Ok(())
    }

    pub(crate) fn click(&self, at: [f64; 2]) -> Result<()> {
        self.mouse("mouseMoved", at, "none")?;
        self.mouse("mousePressed", at, "left")?;
        self.mouse("mouseReleased", at, "left")
    }

    /// Drags along a path of steps, one for each frame of the screen.
    pub(crate) fn drag(&self, from: [f64; 2], step: [f64; 2], count: u32) -> Result<()> {
        self.mouse("mousePressed", from, "left")?;
        let mut at = from;
        for _ in 0..count {
            at = [at[0] + step[0], at[1] + step[1]];
            self.mouse("mouseMoved", at, "left")?;
            sleep(Duration::from_millis(16));
        }
        self.mouse("mouseReleased", at, "left")
    }

    pub(crate) fn wheel(&self, [x, y]: [f64; 2], down: f64) -> Result<()> {
        let event = json!({ "type": "mouseWheel", "x": x, "y": y, "deltaX": 0, "deltaY": down });
        self.call("Input.dispatchMouseEvent", event)?;
        Ok(())
    }

    pub(crate) fn touch(&self, kind: &str, points: &[[f64; 2]]) -> Result<()> {
        let points: Vec<_> = points
            .iter()
            .enumerate()
            .map(|(id, [x, y])| json!({ "x": x, "y": y, "id": id }))
            .collect();
        self.call("Input.dispatchTouchEvent", json!({ "type": kind, "touchPoints": points }))?;
        Ok(())
    }

    /// Presses a key for this long.
    pub(crate) fn key(&self, key: &str, code: &str, held: Duration) -> Result<()> {
        let number = match key {
            "Tab" => 9,
            "Enter" => 13,
            "Escape" => 27,
            " " => 32,
            "ArrowLeft" => 37,
            "ArrowUp" => 38,
            "ArrowRight" => 39,
            "ArrowDown" => 40,
            _ => 0,
        };
        let event = |kind: &str| {
            let mut event = json!({
                "type": kind, "key": key, "code": code, "windowsVirtualKeyCode": number,
            });
            if kind == "keyDown" && key.chars().count() == 1 {
                event["text"] = key.into();
            }
            event
        };
        self.call("Input.dispatchKeyEvent", event("keyDown"))?;
        sleep(held);
        self.call("Input.dispatchKeyEvent", event("keyUp"))?;
        Ok(())
    }

    pub(crate) fn press(&self, key: &str, code: &str) -> Result<()> {
        self.key(key, code, Duration::ZERO)
    }

    /// Returns the picture of the window as a PNG.
    pub(crate) fn screenshot(&self) -> Result<Vec<u8>> {
        let answer = self.call("Page.captureScreenshot", json!({ "format": "png" }))?;
        let bytes = base64::engine::general_purpose::STANDARD.decode(text(&answer["data"])?)?;
        Ok(bytes)
    }

    /// Returns the middle of an element in the window.
    pub(crate) fn middle(&self, selector: &str) -> Result<[f64; 2]> {
        let found = self.evaluate(&format!("middle({})", json!(selector)))?;
        match (found[0].as_f64(), found[1].as_f64()) {
            (Some(x), Some(y)) => Ok([x, y]),
            _ => bail!("there is no {selector}"),
        }
    }

    pub(crate) fn reload(&self) -> Result<()> {
        self.evaluate("window.isOld = true")?;
        self.call("Page.reload", json!({}))?;
        self.wait("a page that loads again", "window.isOld === undefined")
    }
}

impl Drop for Page {
    fn drop(&mut self) {
        let close = json!({ "targetId": self.target });
        // A browser that has ended has closed its pages.
        let _ = self.devtools.borrow_mut().call(None, "Target.closeTarget", close);
    }
}

fn text(value: &Value) -> Result<String> {
    value.as_str().map(str::to_owned).context("a text was expected")
}
