//! The server: the page, its sockets, and files to keep.

use super::connections::{self, Ticket};
use super::guard::{Guard, HEADERS, Refusal};
use super::shared::{Server, plain};
use super::{assets, save, socket};
use anyhow::{Context as _, Result};
use axum::extract::{FromRequestParts as _, Request, WebSocketUpgrade};
use axum::http::{Method, StatusCode, header};
use axum::response::{IntoResponse as _, Response};
use rotund_trace::View;
use serde_json::json;
use std::net::TcpListener;
use std::sync::Arc;

/// Threads that encode files to keep; more requests wait.
const SAVING_THREADS: usize = 2;

/// Answers requests until the program ends.
pub(super) fn run(listener: TcpListener, server: Server) -> Result<()> {
    let runtime = tokio::runtime::Builder::new_current_thread()
        .enable_io()
        .enable_time()
        .max_blocking_threads(SAVING_THREADS)
        .build()
        .context("cannot start the server")?;
    runtime.block_on(async {
        listener.set_nonblocking(true)?;
        let listener = tokio::net::TcpListener::from_std(listener)?;
        let server = Arc::new(server);
        let answer = move |request, ticket| answer(Arc::clone(&server), request, ticket);
        connections::accept(listener, answer).await;
        Ok(())
    })
}

async fn answer(server: Arc<Server>, request: Request, ticket: Arc<Ticket>) -> Response {
    let mut response = match server.guard.pass(request.uri().path(), request.headers()) {
        Err(refusal) => refuse(refusal),
        Ok(_) if request.method() != Method::GET => {
            plain(StatusCode::METHOD_NOT_ALLOWED, "Only GET is answered.\n")
        }
        Ok(rest) => {
            ticket.admit();
            let rest = rest.to_owned();
            route(server, &rest, request).await
        }
    };
    response.headers_mut().extend(HEADERS);
    response
}

async fn route(server: Arc<Server>, path: &str, request: Request) -> Response {
    if path == "socket" {
        return match Guard::pass_socket(request.headers()) {
            Ok(()) => upgrade(server, request).await,
            Err(refusal) => refuse(refusal),
        };
    }
    if let Some(file) = path.strip_prefix("save/") {
        return save::answer(&server, file).await;
    }
    match assets::find(path) {
        // Without the slash, relative addresses would lead past the token.
        Some(_) if path.is_empty() && !request.uri().path().ends_with('/') => {
            let there = format!("/{}/", server.guard.token());
            (StatusCode::PERMANENT_REDIRECT, [(header::LOCATION, there)]).into_response()
        }
        Some(asset) => ([(header::CONTENT_TYPE, asset.media)], asset.text).into_response(),
        None => plain(StatusCode::NOT_FOUND, "There is no such page.\n"),
    }
}

async fn upgrade(server: Arc<Server>, request: Request) -> Response {
    let (mut parts, _) = request.into_parts();
    let upgrade = match WebSocketUpgrade::from_request_parts(&mut parts, &()).await {
        Ok(upgrade) => upgrade,
        Err(_) => return plain(StatusCode::BAD_REQUEST, "Only a WebSocket connects here.\n"),
    };
    let upgrade = upgrade.max_message_size(socket::CUT_OFF).max_frame_size(socket::CUT_OFF);
    upgrade.on_upgrade(|opened| async move {
        let Some((number, session)) = server.sessions.add(&server.viewer) else {
            let reason = "16 pages of this viewer are open: close one of them";
            return socket::refuse(opened, reason).await;
        };
        let greeting = greeting(number, server.without_denoiser.as_deref());
        socket::serve(opened, session, greeting).await;
        server.sessions.remove(number);
    })
}

/// Returns the first message of a socket: the number of the session, for files to keep, the views,
/// and why noise cannot be removed, if it cannot.
fn greeting(session: u64, without_denoiser: Option<&str>) -> String {
    let views = View::ALL.map(|view| [view.name(), view.description()]);
    let program = concat!("rotund ", env!("CARGO_PKG_VERSION"));
    json!({
        "type": "greeting",
        "program": program,
        "session": session,
        "views": views,
        "without_denoiser": without_denoiser,
    })
    .to_string()
}

fn refuse(refusal: Refusal) -> Response {
    plain(Refusal::STATUS, refusal.sentence())
}
