//! Files to keep of what a page shows: pictures, a report, and the command line of a long render.

use super::command;
use super::shared::{Server, plain};
use crate::compare;
use crate::message::{on_one_line, one_line};
use crate::shot::Shot;
use anyhow::{Result, bail};
use axum::http::{StatusCode, header};
use axum::response::{IntoResponse as _, Response};
use rotund_viewer::{Session, Side, Snapshot};
use std::sync::Arc;

/// Answers a request for `SESSION/FILE`.
pub(super) async fn answer(server: &Arc<Server>, path: &str) -> Response {
    let Some((media, encode)) = path.split_once('/').and_then(|(_, file)| encoder(file)) else {
        return plain(StatusCode::NOT_FOUND, "There is no such file.\n");
    };
    let number = path.split('/').next().and_then(|number| number.parse().ok());
    let Some(session) = number.and_then(|number| server.sessions.find(number)) else {
        return plain(StatusCode::NOT_FOUND, "The page is no longer connected.\n");
    };
    let server = Arc::clone(server);
    match tokio::task::spawn_blocking(move || encode(&server, &session)).await {
        Ok(Ok(bytes)) => {
            let headers =
                [(header::CONTENT_TYPE, media), (header::CONTENT_DISPOSITION, "attachment")];
            (headers, bytes).into_response()
        }
        Ok(Err(error)) => plain(StatusCode::CONFLICT, on_one_line(&one_line(&error))),
        Err(_) => plain(StatusCode::INTERNAL_SERVER_ERROR, "The file could not be made."),
    }
}

type Encode = fn(&Server, &Session) -> Result<Vec<u8>>;

/// Returns the media type of a file, and what makes it.
fn encoder(file: &str) -> Option<(&'static str, Encode)> {
    Some(match file {
        "picture.png" => ("image/png", |_, session| Ok(session.png()?)),
        "denoised.png" => ("image/png", |_, session| Ok(session.denoised_png()?)),
        "picture.exr" => ("image/x-exr", |_, session| Ok(session.exr()?)),
        "report.html" => ("text/html; charset=utf-8", report),
        "command" => ("text/plain; charset=utf-8", command_line),
        _ => return None,
    })
}

/// Returns the page of `compare` about both sides of the wipe.
fn report(server: &Server, session: &Session) -> Result<Vec<u8>> {
    let mut snapshots = session.snapshots()?;
    let wanted = snapshots.first().map_or(0, |snapshot| snapshot.settings.samples);
    let mut take = |side| {
        let index = snapshots.iter().position(|it| it.side == side)?;
        Some(snapshots.swap_remove(index)).filter(|it| it.film.samples() == wanted)
    };
    let (Some(vanilla), Some(chosen)) = (take(Side::Vanilla), take(Side::Chosen)) else {
        bail!(
            "a report is about all samples of both pictures: check Wipe, and wait until it is done"
        )
    };
    let kinds = command::kinds(&chosen.settings);
    let (camera, options) = (chosen.camera.name.clone(), chosen.options.clone());
    let shots = [vanilla, chosen].map(shot);
    let page = compare::page_of(&server.scene, &camera, &options, kinds, shots)?;
    Ok(page.into_bytes())
}

fn shot(snapshot: Snapshot) -> Shot {
    let Snapshot { film, options, seconds, rays, .. } = snapshot;
    let pixels = u64::from(options.width) * u64::from(options.height);
    let samples = pixels * u64::from(film.samples());
    // The viewer builds the trees once for both methods.
    Shot { film, build_seconds: 0.0, render_seconds: seconds, rays, samples, interrupted: false }
}

/// Returns the command line of a render of this picture.
fn command_line(server: &Server, session: &Session) -> Result<Vec<u8>> {
    let snapshots = session.snapshots()?;
    let Some(chosen) = snapshots.iter().find(|it| it.side == Side::Chosen) else {
        bail!("there is no picture yet")
    };
    Ok(format!("{} {}", server.render, command::arguments(chosen, server.is_lone)).into_bytes())
}
