//! Nobody but the person who sees the printed address gets anything out of `rotund view`, and
//! nobody can make it fail.

use std::io::{BufRead as _, BufReader, Read as _, Write as _};
use std::net::{TcpListener, TcpStream};
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};
use tungstenite::client::IntoClientRequest as _;
use tungstenite::handshake::client::Request;
use tungstenite::http::{HeaderValue, header};
use tungstenite::protocol::CloseFrame;
use tungstenite::{Message, WebSocket};

const BALL: &str = "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\n\
    property float z\nproperty float radius\nend_header\n0 0 0 0.5\n";

/// A running viewer of a ball.
struct Viewer {
    process: Child,
    port: u16,
    token: String,
    _folder: tempfile::TempDir,
}

fn start(folder: &tempfile::TempDir, arguments: &[&str]) -> Child {
    std::fs::write(folder.path().join("ball.ply"), BALL).expect("a shape file");
    Command::new(env!("CARGO_BIN_EXE_rotund"))
        .current_dir(folder.path())
        .args(["view", "ball.ply", "--no-browser"])
        .args(arguments)
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the program starts")
}

impl Viewer {
    fn start(arguments: &[&str]) -> Self {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let mut process = start(&folder, arguments);
        let mut url = String::new();
        let mut out = BufReader::new(process.stdout.take().expect("a pipe"));
        out.read_line(&mut url).expect("an address");
        let rest = url.trim().strip_prefix("http://127.0.0.1:").expect("a loopback address");
        let (port, token) = rest.trim_end_matches('/').split_once('/').expect("a token");
        let (port, token) = (port.parse().expect("a port"), token.to_owned());
        Self { process, port, token, _folder: folder }
    }

    fn connect(&self) -> TcpStream {
        let stream = TcpStream::connect(("127.0.0.1", self.port)).expect("it listens");
        stream.set_read_timeout(Some(Duration::from_secs(20))).expect("a limit");
        stream
    }

    /// Sends a request as it is written, with `Connection: close`, and returns the whole answer.
    fn send(&self, line: &str, headers: &str) -> String {
        let mut stream = self.connect();
        let request = format!("{line} HTTP/1.1\r\n{headers}Connection: close\r\n\r\n");
        stream.write_all(request.as_bytes()).expect("it reads");
        let mut answer = Vec::new();
        stream.read_to_end(&mut answer).expect("it answers");
        String::from_utf8_lossy(&answer).into_owned()
    }

    fn get(&self, path: &str) -> String {
        self.send(&format!("GET {path}"), &format!("Host: localhost:{}\r\n", self.port))
    }

    /// Returns the request of the page for its socket.
    fn socket_request(&self) -> Request {
        let url = format!("ws://127.0.0.1:{}/{}/socket", self.port, self.token);
        let mut request = url.into_client_request().expect("an address");
        let origin = format!("http://127.0.0.1:{}", self.port);
        let origin = HeaderValue::from_str(&origin).expect("a header");
        request.headers_mut().insert(header::ORIGIN, origin);
        request
    }

    fn socket(&self) -> WebSocket<TcpStream> {
        let (socket, _) =
            tungstenite::client(self.socket_request(), self.connect()).expect("a socket");
        socket
    }

    /// Returns the status of the refusal of a socket; panics if it opens.
    fn refused(&self, request: Request) -> u16 {
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

fn status(answer: &str) -> &str {
    answer.split(' ').nth(1).unwrap_or(answer)
}

fn body(answer: &str) -> &str {
    answer.split_once("\r\n\r\n").map_or("", |(_, body)| body)
}

/// Reads until a message has `text`, and answers each picture.
#[track_caller]
fn wait_for(socket: &mut WebSocket<TcpStream>, text: &str) -> String {
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
fn closed(socket: &mut WebSocket<TcpStream>) -> CloseFrame {
    loop {
        match socket.read() {
            Ok(Message::Close(frame)) => return frame.expect("a reason"),
            Ok(_) => {}
            Err(error) => panic!("closed without a reason: {error}"),
        }
    }
}

const SIZE: &str = r#"{"type":"size","width":60,"height":40,"keep_aspect":false}"#;

#[test]
fn nothing_is_answered_without_the_whole_token() {
    let viewer = Viewer::start(&[]);
    let token = &viewer.token;
    assert!(token.len() == 32 && token.bytes().all(|byte| byte.is_ascii_hexdigit()), "{token}");
    let page = viewer.get(&format!("/{token}/"));
    assert!(status(&page) == "200" && page.contains("<canvas"), "{page}");
    let (half, other) = (&token[..16], "0123456789abcdef0123456789abcdef");
    for path in [
        "/",
        "/index.html",
        "/style.css",
        "/socket",
        &format!("/{half}/"),
        &format!("/{other}/"),
        &format!("/{token}0/"),
        &format!("//{token}/"),
        &format!("/?{token}"),
        &format!("/{other}/style.css"),
        &format!("/{other}/save/1/picture.png"),
        &format!("/{other}/../{token}/"),
    ] {
        let answer = viewer.get(path);
        assert_eq!(status(&answer), "403", "{path}");
        assert!(body(&answer).lines().count() <= 1, "{path}: {answer}");
        assert!(!answer.contains(token), "{path}: the answer has the token");
    }
    assert_ne!(Viewer::start(&["--port", &free_port()]).token, *token, "each has its own");
}

#[test]
fn a_name_that_is_not_of_this_machine_is_refused_even_with_the_token() {
    let viewer = Viewer::start(&[]);
    let line = format!("GET /{}/", viewer.token);
    for (host, expected) in [
        ("Host: localhost\r\n", "200"),
        ("Host: localhost:9999\r\n", "200"),
        ("Host: 127.0.0.1:7171\r\n", "200"),
        ("Host: [::1]:7171\r\n", "200"),
        ("Host: rebound.example:7171\r\n", "403"),
        ("Host: localhost.example\r\n", "403"),
        ("Host: 192.168.1.2:7171\r\n", "403"),
        ("Host: 0.0.0.0:7171\r\n", "403"),
        ("Host: localhost\r\nHost: rebound.example\r\n", "403"),
    ] {
        let answer = viewer.send(&line, host);
        // The library refuses some of them itself.
        let found = status(&answer);
        assert!(found == expected || (expected == "403" && found == "400"), "{host}: {answer}");
        assert_eq!(answer.contains("<canvas"), expected == "200", "{host}");
    }
    let without = viewer.send(&line, "");
    assert!(matches!(status(&without), "400" | "403"), "{without}");
}

#[test]
fn only_the_page_itself_may_open_a_socket() {
    let viewer = Viewer::start(&[]);
    let mut socket = viewer.socket();
    wait_for(&mut socket, "greeting");
    let with = |name: header::HeaderName, value: Option<&str>| {
        let mut request = viewer.socket_request();
        match value {
            Some(value) => {
                request.headers_mut().insert(name, HeaderValue::from_str(value).expect("a header"));
            }
            None => drop(request.headers_mut().remove(name)),
        }
        viewer.refused(request)
    };
    let other_port = format!("http://127.0.0.1:{}", viewer.port.wrapping_add(1));
    let other_name = format!("http://localhost:{}", viewer.port);
    for origin in [
        None,
        Some("null"),
        Some("http://example.org"),
        Some("https://127.0.0.1"),
        Some(other_port.as_str()),
        Some(other_name.as_str()),
    ] {
        assert_eq!(with(header::ORIGIN, origin), 403, "{origin:?}");
    }
    assert_eq!(with(header::HOST, Some("rebound.example")), 403);
    let mut request = viewer.socket_request();
    let wrong = format!("ws://127.0.0.1:{}/{}/socket", viewer.port, "0".repeat(32));
    *request.uri_mut() = wrong.parse().expect("an address");
    assert_eq!(viewer.refused(request), 403);
    let plain = viewer.send(
        &format!("GET /{}/socket", viewer.token),
        "Host: localhost\r\nOrigin: http://localhost\r\n",
    );
    assert_eq!(status(&plain), "400", "{plain}");
}

#[test]
fn no_path_leads_to_a_file() {
    let viewer = Viewer::start(&[]);
    let mut socket = viewer.socket();
    let greeting = wait_for(&mut socket, "greeting");
    let greeting: serde_json::Value = serde_json::from_str(&greeting).expect("JSON");
    let session = &greeting["session"];
    for path in [
        "ball.ply",
        "../ball.ply",
        "../../../../../../etc/passwd",
        "..%2f..%2f..%2fetc%2fpasswd",
        "%2e%2e/%2e%2e/etc/passwd",
        "/etc/passwd",
        "//etc/passwd",
        "style.css/../../ball.ply",
        "page/index.html",
        "index.html%00.css",
        "save/",
        &format!("save/{session}/ball.ply"),
        &format!("save/{session}/../../ball.ply"),
        &format!("save/{session}/picture.png/../x"),
        "save/99999/picture.png",
        "save/-1/picture.png",
        "save/18446744073709551616/picture.png",
    ] {
        let answer = viewer.get(&format!("/{}/{path}", viewer.token));
        assert_eq!(status(&answer), "404", "{path}: {answer}");
        assert!(!answer.contains("root:") && !answer.contains("element vertex"), "{path}");
    }
    for method in ["POST", "PUT", "DELETE", "OPTIONS", "HEAD", "TRACE"] {
        let line = format!("{method} /{}/", viewer.token);
        assert_eq!(status(&viewer.send(&line, "Host: localhost\r\n")), "405", "{method}");
    }
}

#[test]
fn every_answer_forbids_what_the_page_does_not_need() {
    let viewer = Viewer::start(&[]);
    let own = format!("/{}/", viewer.token);
    for path in [&own, &format!("{own}main.js"), &format!("{own}nothing"), "/nothing"] {
        let answer = viewer.get(path).to_lowercase();
        for expected in [
            "content-security-policy: default-src 'none'; script-src 'self'; style-src 'self'; \
             img-src 'self' blob: data:; connect-src 'self'; base-uri 'none'; \
             form-action 'none'; frame-ancestors 'none'\r\n",
            "x-content-type-options: nosniff\r\n",
            "referrer-policy: no-referrer\r\n",
            "cache-control: no-store\r\n",
            "cross-origin-opener-policy: same-origin\r\n",
            "cross-origin-resource-policy: same-origin\r\n",
        ] {
            assert!(answer.contains(expected), "{path}: {expected} is not in {answer}");
        }
        assert!(!answer.contains("access-control-allow"), "{path}: other sites may read it");
    }
    // The policy holds: the page has no script, style or handler in itself.
    let page = viewer.get(&own);
    for inline in ["<style", "style=\"", "onclick", "javascript:", "http://", "https://"] {
        let page = page.replace("http://www.w3.org/2000/svg", "").replace("xmlns='", "");
        assert!(!page.contains(inline), "the page has {inline}");
    }
}

#[cfg(target_os = "linux")]
#[test]
fn it_listens_on_the_loopback_interface_alone_unless_told_otherwise() {
    let listens = |port: u16| {
        let table = std::fs::read_to_string("/proc/net/tcp").expect("the sockets of the system");
        let end = format!(":{port:04X}");
        let local = |line: &str| line.split_whitespace().nth(1).map(str::to_owned);
        let found: Vec<_> = table
            .lines()
            .filter(|line| line.split_whitespace().nth(3) == Some("0A"))
            .filter_map(local)
            .filter(|address| address.ends_with(&end))
            .collect();
        found
    };
    let viewer = Viewer::start(&[]);
    assert_eq!(listens(viewer.port), [format!("0100007F:{:04X}", viewer.port)]);
    drop(viewer);
    let mut viewer = Viewer::start(&["--listen", "0.0.0.0"]);
    assert_eq!(listens(viewer.port), [format!("00000000:{:04X}", viewer.port)]);
    let by_number = viewer.send(&format!("GET /{}/", viewer.token), "Host: 192.168.1.2:7171\r\n");
    assert_eq!(status(&by_number), "200");
    let by_name = viewer.send(&format!("GET /{}/", viewer.token), "Host: site.example:7171\r\n");
    assert_eq!(status(&by_name), "403");
    let mut warning = String::new();
    let errors = viewer.process.stderr.take().expect("a pipe");
    BufReader::new(errors).read_line(&mut warning).expect("a warning");
    assert!(warning.starts_with("warning: ") && warning.contains("unencrypted"), "{warning}");
}

#[test]
fn what_is_no_request_is_answered_by_a_sentence_and_the_socket_stays_open() {
    let viewer = Viewer::start(&[]);
    let mut socket = viewer.socket();
    let deep = "[".repeat(20_000);
    let table = [
        ("no JSON", "hello"),
        ("nothing", ""),
        ("another type", r#"{"type":"format-disk"}"#),
        ("no type", r#"{"width":3}"#),
        ("a field too much", r#"{"type":"grab","at":[0,0],"now":true}"#),
        ("a text for a number", r#"{"type":"size","width":"a","height":1,"keep_aspect":true}"#),
        ("no size", r#"{"type":"size","width":0,"height":0,"keep_aspect":true}"#),
        ("a camera that is NaN", r#"{"type":"camera","camera":{"lens":NaN}}"#),
        ("deep brackets", deep.as_str()),
    ];
    for (why, message) in table {
        socket.send(Message::text(message)).expect(why);
        let problem = wait_for(&mut socket, r#""type":"problem""#);
        assert!(problem.len() < 400, "{why}: {problem}");
    }
    socket.send(Message::text(SIZE)).expect("an open socket");
    wait_for(&mut socket, r#""type":"state""#);
    for (why, message) in [
        ("no lens", r#"{"type":"camera","camera":{"lens":0}}"#),
        (
            "a frame without an inverse",
            r#"{"type":"camera","camera":{"frame":[0,0,0,0,0,0,0,0,0,0,0,0]}}"#,
        ),
        ("no samples", r#"{"type":"settings","settings":{"samples":0}}"#),
        ("no such view", r#"{"type":"settings","settings":{"view":"x-ray"}}"#),
        ("no such camera", r#"{"type":"scene-camera","index":77}"#),
    ] {
        socket.send(Message::text(message)).expect(why);
        let problem = wait_for(&mut socket, r#""type":"problem""#);
        assert!(problem.len() < 400, "{why}: {problem}");
    }
    socket.send(Message::text(r#"{"type":"frame-all"}"#)).expect("an open socket");
    wait_for(&mut socket, r#""activity":"refining""#);
}

#[test]
fn messages_that_are_too_long_too_many_or_binary_end_the_socket_with_a_reason() {
    let viewer = Viewer::start(&[]);
    type Attack = fn(&mut WebSocket<TcpStream>);
    let table: [(&str, u16, &str, Attack); 3] = [
        ("too long", 1009, "65536", |socket| {
            socket.send(Message::text(" ".repeat(70_000))).expect("an open socket");
        }),
        ("binary", 1003, "JSON", |socket| {
            socket.send(Message::binary(vec![0; 16])).expect("an open socket");
        }),
        ("too many", 1008, "500", |socket| {
            for _ in 0..600 {
                // It may end while more are on their way.
                let _ = socket.send(Message::text(r#"{"type":"release"}"#));
            }
        }),
    ];
    for (why, code, word, attack) in table {
        let mut socket = viewer.socket();
        attack(&mut socket);
        let CloseFrame { code: found, reason } = closed(&mut socket);
        assert_eq!(u16::from(found), code, "{why}: {reason}");
        assert!(reason.contains(word), "{why}: {reason}");
    }
    // Far beyond, the connection is cut; the server goes on.
    let mut socket = viewer.socket();
    let _ = socket.send(Message::text(" ".repeat(4 << 20)));
    while socket.read().is_ok() {}
    wait_for(&mut viewer.socket(), "greeting");
}

#[test]
fn there_are_sixteen_pages_and_room_again_when_one_closes() {
    let viewer = Viewer::start(&[]);
    let mut sockets: Vec<_> = (0..16).map(|_| viewer.socket()).collect();
    for socket in &mut sockets {
        wait_for(socket, "greeting");
    }
    let CloseFrame { reason, .. } = closed(&mut viewer.socket());
    assert!(reason.contains("16"), "{reason}");
    drop(sockets.pop());
    let start = Instant::now();
    loop {
        let mut socket = viewer.socket();
        if matches!(socket.read(), Ok(Message::Text(text)) if text.contains("greeting")) {
            return;
        }
        assert!(start.elapsed() < Duration::from_secs(20), "there is no room again");
        std::thread::sleep(Duration::from_millis(50));
    }
}

#[cfg(target_os = "linux")]
#[test]
fn a_client_that_does_not_read_does_not_fill_memory() {
    let viewer = Viewer::start(&[]);
    let memory = || {
        let path = format!("/proc/{}/status", viewer.process.id());
        let text = std::fs::read_to_string(path).expect("it runs");
        let line = text.lines().find_map(|line| line.strip_prefix("VmRSS:")).expect("a line");
        line.split_whitespace().next().expect("a number").parse::<u64>().expect("a number") / 1024
    };
    let mut socket = viewer.socket();
    socket.send(Message::text(SIZE.replace("60", "1200").replace("40", "800"))).expect("open");
    wait_for(&mut socket, r#""activity":"refining""#);
    let before = memory();
    let start = Instant::now();
    let mut turn = 0.0;
    while start.elapsed() < Duration::from_secs(6) {
        turn += 0.01;
        for message in [
            format!(r#"{{"type":"move","orbit":[{turn},0]}}"#),
            r#"{"type":"inspect","at":[0.5,0.5]}"#.to_owned(),
            r#"{"type":"nonsense"}"#.to_owned(),
        ] {
            // A server that waits for the client to read does not read from it either, in the end.
            socket.get_ref().set_write_timeout(Some(Duration::from_millis(50))).expect("a limit");
            let _ = socket.send(Message::text(message));
        }
        std::thread::sleep(Duration::from_millis(15));
    }
    let after = memory();
    assert!(after < before + 60, "{before} MB before, {after} MB after");
    wait_for(&mut viewer.socket(), "greeting");
}

fn free_port() -> String {
    let listener = TcpListener::bind(("127.0.0.1", 0)).expect("a free port");
    listener.local_addr().expect("its address").port().to_string()
}

fn output(folder: &tempfile::TempDir, arguments: &[&str]) -> Output {
    start(folder, arguments).wait_with_output().expect("it ends")
}

#[test]
fn a_port_in_use_and_an_address_of_another_machine_are_refused_in_a_sentence() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let taken = TcpListener::bind(("127.0.0.1", 0)).expect("a free port");
    let port = taken.local_addr().expect("its address").port().to_string();
    for (arguments, words) in [
        (&["--port", port.as_str()][..], &["in use", "--port"][..]),
        (&["--listen", "203.0.113.7"], &["203.0.113.7"]),
    ] {
        let output = output(&folder, arguments);
        let message = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(1), "{arguments:?}: {message}");
        assert!(output.stdout.is_empty(), "{arguments:?}: no address");
        assert!(message.starts_with("error: ") && message.lines().count() == 1, "{message}");
        assert!(words.iter().all(|word| message.contains(word)), "{message}");
    }
}

#[test]
fn the_usual_port_is_the_default_and_any_other_serves_if_it_is_taken() {
    let first = Viewer::start(&[]);
    let second = Viewer::start(&[]);
    assert_ne!(first.port, second.port);
    // Other tests may hold the usual one.
    assert_eq!(status(&second.get(&format!("/{}/", second.token))), "200");
    assert_eq!(status(&second.get(&format!("/{}/", first.token))), "403");
}

#[cfg(unix)]
#[test]
fn a_signal_ends_it_at_once() {
    for signal in ["INT", "TERM"] {
        let mut viewer = Viewer::start(&[]);
        let mut socket = viewer.socket();
        wait_for(&mut socket, "greeting");
        let id = viewer.process.id().to_string();
        let sent = Command::new("kill").args([&format!("-{signal}"), &id]).status();
        assert!(sent.expect("kill runs").success(), "{signal}");
        let start = Instant::now();
        let status = loop {
            if let Some(status) = viewer.process.try_wait().expect("it is ours") {
                break status;
            }
            assert!(start.elapsed() < Duration::from_secs(5), "{signal}: it does not end");
            std::thread::sleep(Duration::from_millis(10));
        };
        assert_eq!(status.code(), Some(0), "{signal}");
    }
}
