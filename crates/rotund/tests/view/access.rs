//! Who may connect, to what, and where the server listens.

use crate::viewer::{Viewer, body, free_port, start, status, wait_for};
#[cfg(target_os = "linux")]
use std::io::{BufRead as _, BufReader};
use std::net::TcpListener;
use std::process::{Command, Output};
use std::time::{Duration, Instant};
use tungstenite::http::{HeaderValue, header};

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
