//! Connections that say nothing, never finish, or take no answer.

use crate::viewer::{Viewer, body, status, wait_for};
use std::io::{Read as _, Write as _};
use std::net::TcpStream;
use std::time::{Duration, Instant};
use tungstenite::Message;

/// Opens a connection that a server might wait for.
fn stranger(viewer: &Viewer, number: usize) -> TcpStream {
    let mut stream = viewer.connect();
    let text = match number % 5 {
        0 => String::new(),
        1 => "GET".to_owned(),
        2 => format!("GET /{}/ HTTP/1.1\r\nHost: localhost\r\n", viewer.token),
        // Without an end.
        3 => format!("GET / HTTP/1.1\r\nHost: localhost\r\nX: {}", "x".repeat(60_000)),
        // Refused, but not closed by the client.
        _ => "GET /nothing HTTP/1.1\r\nHost: localhost\r\n\r\n".to_owned(),
    };
    // It may have been closed already.
    let _ = stream.write_all(text.as_bytes());
    stream
}

fn page_comes(viewer: &Viewer) {
    let start = Instant::now();
    let page = viewer.get(&format!("/{}/", viewer.token));
    assert!(status(&page) == "200" && body(&page).contains("<canvas"), "{page}");
    assert!(start.elapsed() < Duration::from_secs(3), "it takes {:?}", start.elapsed());
}

#[test]
fn a_flood_of_connections_shuts_nobody_out_and_ends_by_itself() {
    let viewer = Viewer::start(&[]);
    let mut socket = viewer.socket();
    wait_for(&mut socket, "greeting");
    #[cfg(target_os = "linux")]
    let before = viewer.memory();
    let mut strangers = Vec::new();
    for number in 0..600 {
        strangers.push(stranger(&viewer, number));
        if number % 100 == 99 {
            page_comes(&viewer);
        }
    }
    #[cfg(target_os = "linux")]
    {
        let files = std::fs::read_dir(format!("/proc/{}/fd", viewer.process.id()));
        let files = files.expect("it runs").count();
        assert!(files < 320, "{files} files are open");
        let after = viewer.memory();
        assert!(after < before + 20, "{before} MB before, {after} MB after");
    }
    // The socket of a page is none of them.
    socket.send(Message::text(r#"{"type":"nonsense"}"#)).expect("an open socket");
    wait_for(&mut socket, r#""type":"problem""#);
    let start = Instant::now();
    for stranger in &mut strangers {
        // Closed, with or without an answer; a read that times out is neither.
        match stranger.read_to_end(&mut Vec::new()) {
            Ok(_) => {}
            Err(error) if error.kind() == std::io::ErrorKind::ConnectionReset => {}
            Err(error) => panic!("{error}"),
        }
    }
    assert!(start.elapsed() < Duration::from_secs(15), "they last {:?}", start.elapsed());
    page_comes(&viewer);
}

#[test]
fn many_idle_connections_with_the_token_leave_room_for_another() {
    let viewer = Viewer::start(&[]);
    let request = format!("GET /{}/style.css HTTP/1.1\r\nHost: localhost\r\n\r\n", viewer.token);
    let mut guests = Vec::new();
    for _ in 0..200 {
        let mut stream = viewer.connect();
        stream.write_all(request.as_bytes()).expect("it reads");
        let mut start = [0; 12];
        stream.read_exact(&mut start).expect("an answer");
        assert_eq!(&start, b"HTTP/1.1 200");
        guests.push(stream);
    }
    page_comes(&viewer);
}

#[cfg(target_os = "linux")]
#[test]
fn answers_that_nobody_reads_do_not_fill_memory() {
    let viewer = Viewer::start(&[]);
    let request = format!("GET /{}/style.css HTTP/1.1\r\nHost: localhost\r\n\r\n", viewer.token);
    let before = viewer.memory();
    let mut stream = viewer.connect();
    stream.set_write_timeout(Some(Duration::from_millis(500))).expect("a limit");
    // Until the server reads no more, since its answers are not taken.
    let many = request.repeat(100);
    for _ in 0..1000 {
        if stream.write_all(many.as_bytes()).is_err() {
            break;
        }
    }
    let after = viewer.memory();
    assert!(after < before + 20, "{before} MB before, {after} MB after");
    page_comes(&viewer);
}

#[test]
fn a_page_that_is_gone_without_a_word_leaves_its_place() {
    let viewer = Viewer::start(&[]);
    let (mut gone, mut there) = (viewer.socket(), viewer.socket());
    wait_for(&mut gone, "greeting");
    wait_for(&mut there, "greeting");
    let start = Instant::now();
    while start.elapsed() < Duration::from_secs(34) {
        // Whoever reads answers the question whether it is there.
        let _ = there.read();
    }
    there.send(Message::text(r#"{"type":"nonsense"}"#)).expect("an open socket");
    wait_for(&mut there, r#""type":"problem""#);
    // The other has not, and finds its connection closed.
    let stream = gone.get_mut();
    stream.set_read_timeout(Some(Duration::from_secs(5))).expect("a limit");
    let end = stream.read_to_end(&mut Vec::new());
    assert!(end.is_ok(), "{end:?}");
}
