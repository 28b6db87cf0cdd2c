//! A client of the Chrome DevTools protocol: commands and their answers as JSON over a WebSocket.

use anyhow::{Context as _, Result, bail};
use serde_json::{Value, json};
use std::net::TcpStream;
use std::time::Duration;
use tungstenite::{Message, WebSocket};

/// The longest answer: a picture of a large screen.
const PATIENCE: Duration = Duration::from_secs(60);

/// A connection to a browser.
#[derive(Debug)]
pub(crate) struct DevTools {
    socket: WebSocket<TcpStream>,
    last: u64,
}

impl DevTools {
    /// Connects to `ws://HOST:PORT/PATH`.
    pub(crate) fn connect(address: &str) -> Result<Self> {
        let host = address.strip_prefix("ws://").and_then(|rest| rest.split('/').next());
        let stream = TcpStream::connect(host.context("the address of a browser")?)?;
        stream.set_read_timeout(Some(PATIENCE))?;
        stream.set_nodelay(true)?;
        let (socket, _) = tungstenite::client(address, stream)
            .map_err(|error| anyhow::anyhow!("the browser refuses to be driven: {error}"))?;
        Ok(Self { socket, last: 0 })
    }

    /// Sends a command, to a page if there is a session, and waits for its answer. Events that
    /// come before it are dropped.
    pub(crate) fn call(
        &mut self,
        session: Option<&str>,
        method: &str,
        parameters: Value,
    ) -> Result<Value> {
        self.last += 1;
        let mut command = json!({ "id": self.last, "method": method, "params": parameters });
        if let Some(session) = session {
            command["sessionId"] = session.into();
        }
        self.socket.send(Message::text(command.to_string()))?;
        loop {
            let message = self.socket.read().with_context(|| format!("no answer to {method}"))?;
            let Message::Text(text) = message else { continue };
            let mut answer: Value = serde_json::from_str(&text)?;
            if answer["id"] != self.last {
                continue;
            }
            if let Some(error) = answer.get("error") {
                bail!("{method}: {}", error["message"]);
            }
            return Ok(answer["result"].take());
        }
    }
}
