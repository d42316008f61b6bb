//! What the page is made of: its files, pictures to save, and a WebSocket for each who looks on.

use super::client;
use crate::cli::serve::{self, Guard};
use crate::render::{self, Metadata, Precision};
use crate::session::live::{Finished, Live};
use axum::Router;
use axum::extract::{ConnectInfo, Path, State, WebSocketUpgrade};
use axum::http::{StatusCode, header};
use axum::response::{IntoResponse, Response};
use axum::routing::get;
use std::net::SocketAddr;
use std::sync::Arc;
use tokio::sync::watch;

/// Files of the page: name, type, and text.
const FILES: [serve::File; 7] = [
    ("", "text/html; charset=utf-8", include_str!("page/index.html")),
    ("style.css", "text/css; charset=utf-8", include_str!("page/style.css")),
    ("main.js", "text/javascript; charset=utf-8", include_str!("page/main.js")),
    ("link.js", "text/javascript; charset=utf-8", include_str!("page/link.js")),
    ("steer.js", "text/javascript; charset=utf-8", include_str!("page/steer.js")),
    ("panel.js", "text/javascript; charset=utf-8", include_str!("page/panel.js")),
    ("probe.js", "text/javascript; charset=utf-8", include_str!("page/probe.js")),
];

/// Longest message that a page has to send.
const LONGEST: usize = 16 << 10;

/// What the handlers share.
#[derive(Clone)]
pub struct Hall {
    /// The picture.
    pub live: Arc<Live>,
    /// Changes when something is new.
    pub news: watch::Receiver<u64>,
    /// Who may come in.
    pub guard: Guard,
}

/// The page, behind its token.
pub fn routes(hall: Hall) -> Router {
    Router::new()
        .route("/", get(|hall, who| file(hall, who, Path(String::new()))))
        .route("/live", get(connect))
        .route("/picture/{name}", get(picture))
        .route("/{name}", get(file))
        .with_state(hall)
}

/// A file of the page.
async fn file(
    State(hall): State<Hall>,
    ConnectInfo(who): ConnectInfo<SocketAddr>,
    name: Path<String>,
) -> Response {
    serve::file(&FILES, name, &hall.guard, who)
}

/// Somebody looks on.
async fn connect(
    State(hall): State<Hall>,
    ConnectInfo(who): ConnectInfo<SocketAddr>,
    socket: WebSocketUpgrade,
) -> Response {
    socket
        .max_message_size(LONGEST)
        .max_frame_size(LONGEST)
        .on_upgrade(move |socket| client::talk(socket, hall, who))
}

/// The full picture, to save.
async fn picture(State(hall): State<Hall>, Path(name): Path<String>) -> Response {
    let kind = match name.rsplit_once('.') {
        Some((_, "png")) => "image/png",
        Some((_, "exr")) => "image/x-exr",
        _ => return (StatusCode::NOT_FOUND, "pictures end in .png or .exr\n").into_response(),
    };
    let Some(finished) = hall.live.finished() else {
        return serve::later("the picture is not finished yet\n");
    };
    let encoded = tokio::task::spawn_blocking(move || encode(&finished, &name)).await;
    match encoded.map_err(|e| e.to_string()).flatten() {
        Ok(bytes) => ([(header::CONTENT_TYPE, kind)], bytes).into_response(),
        Err(message) => (StatusCode::INTERNAL_SERVER_ERROR, message).into_response(),
    }
}

/// The bytes of a picture's file.
fn encode(finished: &Finished, name: &str) -> Result<Vec<u8>, String> {
    let failed = |e: std::io::Error| format!("the picture cannot be saved ({e})");
    let folder = tempfile::tempdir().map_err(failed)?;
    let path = folder.path().join(if name.ends_with(".exr") { "picture.exr" } else { "picture.png" });
    let metadata = Metadata {
        params: finished.scene.params.iter().map(|p| (p.name.clone(), p.value.clone())).collect(),
        ..Metadata::default()
    };
    render::save_as(&path, &finished.picture, &metadata, Precision::Float).map_err(|e| e.to_string())?;
    std::fs::read(&path).map_err(failed)
}
