//! Messages that are wrong, too long, too many, or not read.

use crate::viewer::{Viewer, closed, wait_for};
use std::net::TcpStream;
use std::time::{Duration, Instant};
use tungstenite::protocol::CloseFrame;
use tungstenite::{Message, WebSocket};

const SIZE: &str = r#"{"type":"size","width":60,"height":40,"keep_aspect":false}"#;

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
        ("a field where there is none", r#"{"type":"release","now":1}"#),
        ("another where there is none", r#"{"type":"frame-all","at":[0,0]}"#),
        ("one of a movement", r#"{"type":"move","orbit":[0,0],"roll":1}"#),
        ("one of a camera", r#"{"type":"camera","camera":{"fov":1}}"#),
        ("one of settings", r#"{"type":"settings","settings":{"sample":1}}"#),
        ("a field twice", r#"{"type":"scene-camera","index":0,"index":0}"#),
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
fn a_viewer_without_a_denoiser_says_why_and_takes_the_other_settings() {
    let viewer = Viewer::start(&[]);
    let mut socket = viewer.socket();
    let greeting = wait_for(&mut socket, "greeting");
    assert!(
        greeting.contains("Open Image Denoise") && greeting.contains("ROTUND_OIDN"),
        "{greeting}"
    );
    socket.send(Message::text(SIZE)).expect("an open socket");
    let settings = r#"{"type":"settings","settings":{"denoise":true,"seed":5}}"#;
    socket.send(Message::text(settings)).expect("an open socket");
    wait_for(&mut socket, r#""type":"problem""#);
    let state = wait_for(&mut socket, r#""seed":5"#);
    assert!(state.contains(r#""denoise":false"#), "{state}");
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
    let mut socket = viewer.socket();
    socket.send(Message::text(SIZE.replace("60", "1200").replace("40", "800"))).expect("open");
    wait_for(&mut socket, r#""activity":"refining""#);
    let before = viewer.memory();
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
    let after = viewer.memory();
    assert!(after < before + 60, "{before} MB before, {after} MB after");
    wait_for(&mut viewer.socket(), "greeting");
}
