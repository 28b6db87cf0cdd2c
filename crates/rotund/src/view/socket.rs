//! The socket of one page: requests go up, events and pictures come down.
//!
//! A message up is a [`Request`] as JSON. A message down is an event as JSON, or binary: the length
//! of a header as 32 bits, little endian, the [`rotund_viewer::FrameHeader`] as JSON, and the
//! encoded picture.
//!
//! Nothing piles up. The session keeps the latest picture and status only, and hands out a picture
//! when the page has shown one before. Between its thread and the socket is room for one message.

use axum::extract::ws::{CloseFrame, Message, WebSocket, close_code};
use futures_util::stream::{SplitSink, SplitStream};
use futures_util::{SinkExt as _, StreamExt as _};
use rotund_viewer::{Event, Frame, Output, Request, Session};
use std::sync::Arc;
use std::thread;
use std::time::{Duration, Instant};
use tokio::sync::mpsc::{self, Receiver, Sender};
use tokio::time::timeout;

/// Bytes of the largest message of a page.
const LONGEST_MESSAGE: usize = 64 << 10;
/// Bytes after which the connection is cut without a word.
pub(super) const CUT_OFF: usize = 1 << 20;
/// Messages of a page in one second; it sends one for each frame of the screen and a few more.
const MESSAGES_PER_SECOND: u32 = 500;
/// A page that does not take a message for this long has gone.
const PATIENCE: Duration = Duration::from_secs(20);
/// Time after which a page is asked whether it is still there, if there is nothing to send.
const QUIET: Duration = Duration::from_secs(10);
/// A page of which nothing has come for this long has gone: a browser answers by itself.
const SILENCE: Duration = Duration::from_secs(30);
/// How soon the thread of a session notices that its page has gone.
const ATTENTION: Duration = Duration::from_millis(200);

/// Passes messages on until the page closes the socket or breaks a rule. The first message is
/// `greeting`.
pub(super) async fn serve(socket: WebSocket, session: Arc<Session>, greeting: String) {
    let (sender, outputs) = mpsc::channel(1);
    let (mut down, up) = socket.split();
    let replies = sender.clone();
    let pump = {
        let session = Arc::clone(&session);
        thread::Builder::new().name("session".to_owned()).spawn(move || pump(&session, &sender))
    };
    let end = if pump.is_err() {
        Some(close(close_code::AGAIN, "the server has no thread for another page"))
    } else {
        tokio::select! {
            end = read(up, &session, &replies) => end,
            () = write(&mut down, outputs, greeting) => None,
        }
    };
    let _ = timeout(Duration::from_secs(1), down.send(Message::Close(end))).await;
}

/// Refuses a socket with a reason, which a page sees only once it is open.
pub(super) async fn refuse(mut socket: WebSocket, reason: &'static str) {
    let _ = socket.send(Message::Close(Some(close(close_code::AGAIN, reason)))).await;
}

fn close(code: u16, reason: &'static str) -> CloseFrame {
    CloseFrame { code, reason: reason.into() }
}

/// Hands outputs of a session to the socket, one at a time.
fn pump(session: &Session, sender: &Sender<Message>) {
    while !sender.is_closed() {
        let Some(output) = session.next(ATTENTION) else { continue };
        let message = match output {
            Output::Event(event) => text(&event),
            Output::Frame(frame) => binary(&frame),
        };
        if sender.blocking_send(message).is_err() {
            return;
        }
    }
}

async fn write(
    down: &mut SplitSink<WebSocket, Message>,
    mut outputs: Receiver<Message>,
    greeting: String,
) {
    let mut message = Message::text(greeting);
    while let Ok(Ok(())) = timeout(PATIENCE, down.send(message)).await {
        message = match timeout(QUIET, outputs.recv()).await {
            Ok(Some(next)) => next,
            Ok(None) => return,
            Err(_) => Message::Ping(Default::default()),
        };
    }
}

/// Passes requests on; returns the reason to close the socket, if it is not closed by the page.
async fn read(
    mut up: SplitStream<WebSocket>,
    session: &Session,
    replies: &Sender<Message>,
) -> Option<CloseFrame> {
    let (mut second, mut count) = (Instant::now(), 0);
    while let Ok(Some(Ok(message))) = timeout(SILENCE, up.next()).await {
        if second.elapsed() >= Duration::from_secs(1) {
            (second, count) = (Instant::now(), 0);
        }
        count += 1;
        if count > MESSAGES_PER_SECOND {
            return Some(close(close_code::POLICY, "more than 500 messages in a second"));
        }
        let message = match message {
            Message::Text(text) => text,
            Message::Binary(_) => {
                return Some(close(close_code::UNSUPPORTED, "a request is JSON in a text message"));
            }
            Message::Close(_) => return None,
            Message::Ping(_) | Message::Pong(_) => continue,
        };
        if message.len() > LONGEST_MESSAGE {
            return Some(close(close_code::SIZE, "a message has at most 65536 bytes"));
        }
        match serde_json::from_str::<Request>(&message) {
            Ok(request) => session.request(request),
            Err(error) => {
                let problem = format!("The viewer does not understand the request: {error}.");
                replies.send(text(&Event::Problem { text: problem })).await.ok()?;
            }
        }
    }
    None
}

fn text(event: &Event) -> Message {
    Message::text(serde_json::to_string(event).expect("an event has a JSON form"))
}

fn binary(frame: &Frame) -> Message {
    let header = serde_json::to_vec(&frame.header).expect("a header has a JSON form");
    let length = u32::try_from(header.len()).expect("a header is short").to_le_bytes();
    Message::binary([&length[..], &header, &frame.bytes].concat())
}
