//! The connections of the server: how many there are, and how long a client may take.
//!
//! Whoever reaches the port can open connections, with or without the token. So those that have not
//! shown it are counted by themselves, and the oldest of them gives way to a new one: a flood of
//! them takes little memory, and shuts nobody out. A socket is no longer counted here.

use axum::body::Body;
use axum::extract::Request;
use axum::response::Response;
use hyper::server::conn::http1;
use hyper::service::service_fn;
use hyper_util::rt::{TokioIo, TokioTimer};
use std::collections::BTreeMap;
use std::convert::Infallible;
use std::future::Future;
use std::io::ErrorKind;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::oneshot::{self, Receiver, Sender};
use tokio_io_timeout::TimeoutStream;

/// Connections that have not shown the token.
const MOST_STRANGERS: usize = 256;
/// Connections that have: a browser keeps up to six for each page.
const MOST_GUESTS: usize = 128;
/// Time for the head of a request, from the connection or the last answer on.
const HEAD: Duration = Duration::from_secs(5);
/// Bytes of the longest head.
const LONGEST_HEAD: usize = 16 << 10;
/// A client that takes no part of an answer for this long has gone.
const PATIENCE: Duration = Duration::from_secs(20);
/// Pause after a failure of the system, such as one for lack of files.
const PAUSE: Duration = Duration::from_millis(100);

/// The open connections. Whatever is taken out of a map is closed.
#[derive(Debug, Default)]
struct Connections(Mutex<Open>);

#[derive(Debug, Default)]
struct Open {
    last: u64,
    strangers: BTreeMap<u64, Sender<()>>,
    guests: BTreeMap<u64, Sender<()>>,
}

/// The place of one connection, which is free again once this is dropped.
#[derive(Debug)]
pub(super) struct Ticket {
    connections: Arc<Connections>,
    number: u64,
}

impl Connections {
    fn lock(&self) -> MutexGuard<'_, Open> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Takes in a connection; it must end when the receiver does.
    fn enter(self: &Arc<Self>) -> (Ticket, Receiver<()>) {
        let (close, closed) = oneshot::channel();
        let mut open = self.lock();
        open.last += 1;
        let number = open.last;
        insert(&mut open.strangers, MOST_STRANGERS, number, close);
        (Ticket { connections: Arc::clone(self), number }, closed)
    }
}

/// Inserts a connection; if there are too many, the oldest gives way.
fn insert(of: &mut BTreeMap<u64, Sender<()>>, most: usize, number: u64, close: Sender<()>) {
    if of.len() >= most {
        of.pop_first();
    }
    of.insert(number, close);
}

impl Ticket {
    /// Takes note that the connection has shown the token.
    pub(super) fn admit(&self) {
        let mut open = self.connections.lock();
        if let Some(close) = open.strangers.remove(&self.number) {
            insert(&mut open.guests, MOST_GUESTS, self.number, close);
        }
    }
}

impl Drop for Ticket {
    fn drop(&mut self) {
        let mut open = self.connections.lock();
        open.strangers.remove(&self.number);
        open.guests.remove(&self.number);
    }
}

/// Lets requests be answered until the program ends.
pub(super) async fn accept<F>(
    listener: TcpListener,
    answer: impl Fn(Request, Arc<Ticket>) -> F + Clone + Send + 'static,
) where
    F: Future<Output = Response> + Send + 'static,
{
    let connections = Arc::<Connections>::default();
    loop {
        match listener.accept().await {
            Ok((stream, _)) => {
                tokio::spawn(serve(stream, connections.enter(), answer.clone()));
                // A request that has come with its connection is read before the next connection
                // is taken in, however many wait.
                tokio::task::yield_now().await;
            }
            Err(error) => match error.kind() {
                ErrorKind::ConnectionAborted | ErrorKind::ConnectionReset => {}
                _ => tokio::time::sleep(PAUSE).await,
            },
        }
    }
}

async fn serve<F>(
    stream: TcpStream,
    (ticket, closed): (Ticket, Receiver<()>),
    answer: impl Fn(Request, Arc<Ticket>) -> F + Send + 'static,
) where
    F: Future<Output = Response> + Send + 'static,
{
    // Small messages must not wait for more.
    let _ = stream.set_nodelay(true);
    let mut stream = TimeoutStream::new(stream);
    stream.set_write_timeout(Some(PATIENCE));
    let ticket = Arc::new(ticket);
    let service = service_fn(move |request: hyper::Request<hyper::body::Incoming>| {
        let answer = answer(request.map(Body::new), Arc::clone(&ticket));
        async { Ok::<_, Infallible>(answer.await) }
    });
    let mut builder = http1::Builder::new();
    builder.timer(TokioTimer::new()).header_read_timeout(HEAD).max_buf_size(LONGEST_HEAD);
    let connection = builder.serve_connection(TokioIo::new(Box::pin(stream)), service);
    tokio::select! {
        // A client that breaks the rules of the protocol is nobody's concern.
        _ = connection.with_upgrades() => {}
        _ = closed => {}
    }
}
