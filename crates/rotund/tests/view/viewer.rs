//! A running viewer, and clients that need not behave.

use std::io::{BufRead as _, BufReader, Read as _, Write as _};
use std::net::{TcpListener, TcpStream};
#[cfg(unix)]
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};
use tungstenite::client::IntoClientRequest as _;
use tungstenite::handshake::client::Request;
use tungstenite::http::{HeaderValue, header};
use tungstenite::protocol::CloseFrame;
use tungstenite::{Message, WebSocket};

const BALL: &str = "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\n\
    property float z\nproperty float radius\nend_header\n0 0 0 0.5\n";

/// A running viewer of a ball.
pub(crate) struct Viewer {
    pub(crate) process: Child,
    pub(crate) port: u16,
    pub(crate) token: String,
    /// The folder that it was started in.
    pub(crate) folder: tempfile::TempDir,
}

pub(crate) fn start(folder: &tempfile::TempDir, arguments: &[&str]) -> Child {
    start_with(folder, "ball.ply", arguments)
}

fn start_with(folder: &tempfile::TempDir, scene: &str, arguments: &[&str]) -> Child {
    std::fs::write(folder.path().join("ball.ply"), BALL).expect("a shape file");
    Command::new(env!("CARGO_BIN_EXE_rotund"))
        .current_dir(folder.path())
        .args(["view", scene, "--no-browser"])
        // Whether there is a denoiser must not depend on the machine.
        .env("ROTUND_OIDN", "/nowhere/libOpenImageDenoise.so")
        .args(arguments)
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the program starts")
}

impl Viewer {
    pub(crate) fn start(arguments: &[&str]) -> Self {
        Self::of("ball.ply", arguments)
    }

    pub(crate) fn of(scene: &str, arguments: &[&str]) -> Self {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let mut process = start_with(&folder, scene, arguments);
        let mut url = String::new();
        let mut out = BufReader::new(process.stdout.take().expect("a pipe"));
        out.read_line(&mut url).expect("an address");
        let rest = url.trim().strip_prefix("http://127.0.0.1:").expect("a loopback address");
        let (port, token) = rest.trim_end_matches('/').split_once('/').expect("a token");
        let (port, token) = (port.parse().expect("a port"), token.to_owned());
        Self { process, port, token, folder }
    }

    /// Returns the memory that it holds in MB.
    #[cfg(target_os = "linux")]
    pub(crate) fn memory(&self) -> u64 {
        let path = format!("/proc/{}/status", self.process.id());
        let text = std::fs::read_to_string(path).expect("it runs");
        let line = text.lines().find_map(|line| line.strip_prefix("VmRSS:")).expect("a line");
        line.split_whitespace().next().expect("a number").parse::<u64>().expect("a number") / 1024
    }

    pub(crate) fn connect(&self) -> TcpStream {
        let stream = TcpStream::connect(("127.0.0.1", self.port)).expect("it listens");
        stream.set_read_timeout(Some(Duration::from_secs(20))).expect("a limit");
        stream
    }

    /// Sends a request as it is written, with `Connection: close`, and returns the whole answer.
    pub(crate) fn send(&self, line: &str, headers: &str) -> String {
        String::from_utf8_lossy(&self.send_for_bytes(line, headers)).into_owned()
    }

    fn send_for_bytes(&self, line: &str, headers: &str) -> Vec<u8> {
        let mut stream = self.connect();
        let request = format!("{line} HTTP/1.1\r\n{headers}Connection: close\r\n\r\n");
        stream.write_all(request.as_bytes()).expect("it reads");
        let mut answer = Vec::new();
        stream.read_to_end(&mut answer).expect("it answers");
        answer
    }

    pub(crate) fn get(&self, path: &str) -> String {
        self.send(&format!("GET {path}"), &format!("Host: localhost:{}\r\n", self.port))
    }

    pub(crate) fn get_bytes(&self, path: &str) -> Vec<u8> {
        self.send_for_bytes(&format!("GET {path}"), &format!("Host: localhost:{}\r\n", self.port))
    }

    /// Returns the request of the page for its socket.
    pub(crate) fn socket_request(&self) -> Request {
        let url = format!("ws://127.0.0.1:{}/{}/socket", self.port, self.token);
        let mut request = url.into_client_request().expect("an address");
        let origin = format!("http://127.0.0.1:{}", self.port);
        let origin = HeaderValue::from_str(&origin).expect("a header");
        request.headers_mut().insert(header::ORIGIN, origin);
        request
    }

    pub(crate) fn socket(&self) -> WebSocket<TcpStream> {
        let (socket, _) =
            tungstenite::client(self.socket_request(), self.connect()).expect("a socket");
        socket
    }

    /// Returns the status of the refusal of a socket; panics if it opens.
    pub(crate) fn refused(&self, request: Request) -> u16 {
        match tungstenite::client(request, self.connect()) {
            Ok(_) => panic!("the socket opens"),
            Err(tungstenite::HandshakeError::Failure(tungstenite::Error::Http(answer))) => {
                answer.status().as_u16()
            }
            Err(error) => panic!("{error}"),
        }
    }
}

impl Drop for Viewer {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

pub(crate) fn status(answer: &str) -> &str {
    answer.split(' ').nth(1).unwrap_or(answer)
}

pub(crate) fn body(answer: &str) -> &str {
    answer.split_once("\r\n\r\n").map_or("", |(_, body)| body)
}

/// Reads until a message has `text`, and answers each picture.
#[track_caller]
pub(crate) fn wait_for(socket: &mut WebSocket<TcpStream>, text: &str) -> String {
    let start = Instant::now();
    while start.elapsed() < Duration::from_secs(60) {
        let message = socket.read();
        match message.unwrap_or_else(|error| panic!("no message has {text:?}: {error}")) {
            Message::Text(message) if message.contains(text) => return message.to_string(),
            Message::Binary(frame) => {
                let length = u32::from_le_bytes(frame[..4].try_into().expect("a length")) as usize;
                let header: serde_json::Value =
                    serde_json::from_slice(&frame[4..4 + length]).expect("a header");
                let shown = serde_json::json!({ "type": "shown", "frame": header["id"] });
                socket.send(Message::text(shown.to_string())).expect("an open socket");
            }
            _ => {}
        }
    }
    panic!("no message has {text:?}");
}

/// Reads until the server closes the socket; returns its reason.
#[track_caller]
pub(crate) fn closed(socket: &mut WebSocket<TcpStream>) -> CloseFrame {
    loop {
        match socket.read() {
            Ok(Message::Close(frame)) => return frame.expect("a reason"),
            Ok(_) => {}
            Err(error) => panic!("closed without a reason: {error}"),
        }
    }
}

#[cfg(unix)]
/// Runs a command line of the program in a folder, as a person does who pastes it.
#[track_caller]
pub(crate) fn shell(folder: &Path, line: &str) {
    let rest = line.strip_prefix("rotund ").expect("a command of the program");
    let line = format!("'{}' {rest}", env!("CARGO_BIN_EXE_rotund"));
    let output = Command::new("sh").current_dir(folder).arg("-c").arg(&line).output();
    let output = output.expect("a shell");
    let message = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{line}: {message}");
}

pub(crate) fn free_port() -> String {
    let listener = TcpListener::bind(("127.0.0.1", 0)).expect("a free port");
    listener.local_addr().expect("its address").port().to_string()
}
