//! What the page is made of: its files, the gallery, pictures, and scripts to save.
//!
//! | request | answer |
//! |---|---|
//! | `GET gallery` | the gallery as JSON |
//! | `POST do` | the gallery after a command, which is JSON too |
//! | `GET thumb/ID.png`, `GET large/ID.png` | a picture, as soon as it is drawn; whoever hangs up before does not want it |
//! | `GET rough/ID.png` | what there is of the small one after a moment; `Picture: rough` or `finished` says what that is |
//! | `GET script/ID.rhai` | the script with the values and expressions of a picture |

use super::Args;
use super::told::Told;
use crate::cli::serve::{self, Guard};
use crate::diag::Diagnostic;
use crate::session::explore::{
    Atelier, Command, Drawn, Gallery, Genome, Grade, Image, Nurse, Nursery, Refused,
};
use axum::Router;
use axum::body::Bytes;
use axum::extract::rejection::BytesRejection;
use axum::extract::{ConnectInfo, DefaultBodyLimit, Path, State};
use axum::http::{HeaderName, StatusCode, header};
use axum::response::{IntoResponse, Response};
use axum::routing::{get, post};
use serde::Serialize;
use std::net::SocketAddr;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use tokio::sync::oneshot;

/// Files of the page: name, type, and text.
const FILES: [serve::File; 7] = [
    ("", "text/html; charset=utf-8", include_str!("page/index.html")),
    ("style.css", "text/css; charset=utf-8", include_str!("page/style.css")),
    ("main.js", "text/javascript; charset=utf-8", include_str!("page/main.js")),
    ("grid.js", "text/javascript; charset=utf-8", include_str!("page/grid.js")),
    ("large.js", "text/javascript; charset=utf-8", include_str!("page/large.js")),
    ("values.js", "text/javascript; charset=utf-8", include_str!("page/values.js")),
    ("pictures.js", "text/javascript; charset=utf-8", include_str!("page/pictures.js")),
];

/// Longest command in bytes.
const LONGEST: usize = 16 << 10;

/// Sides of large pictures over those of small ones.
const ENLARGED: u32 = 4;

/// The same for small ones that are large already.
const WIDEST: u32 = 1600;

/// What the handlers share.
pub struct Hall {
    atelier: Atelier,
    nursery: Nursery,
    gallery: Mutex<Gallery>,
    /// Held by the command that is obeyed, which may take a while.
    turn: Mutex<()>,
    /// What the command was started with.
    args: Args,
    /// Width and height of small pictures.
    size: (u32, u32),
}

impl Hall {
    /// For pictures of a gallery.
    pub fn new(args: &Args, size: (u32, u32), atelier: Atelier, gallery: Gallery) -> Hall {
        Hall {
            atelier,
            nursery: Nursery::default(),
            gallery: Mutex::new(gallery),
            turn: Mutex::default(),
            args: args.clone(),
            size,
        }
    }

    fn gallery(&self) -> MutexGuard<'_, Gallery> {
        self.gallery.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The gallery as it is told.
    fn told(&self) -> Response {
        json(StatusCode::OK, &Told::new(&self.args, self.atelier.subject(), &self.gallery(), self.size))
    }

    /// Does something. Meanwhile the gallery is what it was before.
    fn obey(&self, command: Command, cancel: &Arc<AtomicBool>) -> Result<(), Refused> {
        let _turn = self.turn.lock().unwrap_or_else(PoisonError::into_inner);
        let nurse = Nurse { subject: self.atelier.subject(), nursery: &self.nursery, cancel };
        let mut gallery = self.gallery().clone();
        gallery.obey(command, &nurse)?;
        *self.gallery() = gallery;
        Ok(())
    }

    /// What a specimen is made of, by the name of a file that is about it.
    fn genome(&self, name: &str, ending: &str) -> Option<(usize, Genome)> {
        let id = name.strip_suffix(ending)?.parse().ok()?;
        Some((id, self.gallery().genome(id)?))
    }

    /// Width and height of the pictures in a folder, and how good they have to be.
    fn kind(&self, folder: &str) -> Option<((u32, u32), Grade)> {
        let (width, height) = self.size;
        let times = ENLARGED.min(WIDEST / width.max(height)).max(1);
        match folder {
            "rough" => Some((self.size, Grade::Rough)),
            "thumb" => Some((self.size, Grade::Finished)),
            "large" => Some(((times * width, times * height), Grade::Finished)),
            _ => None,
        }
    }
}

/// What a handler is given.
#[derive(Clone)]
struct Door {
    hall: Arc<Hall>,
    guard: Guard,
}

/// The page, behind its token.
pub fn routes(hall: Hall, guard: Guard) -> Router {
    Router::new()
        .route("/", get(|door, who| file(door, who, Path(String::new()))))
        .route("/gallery", get(async |State(door): State<Door>| door.hall.told()))
        .route("/do", post(command).layer(DefaultBodyLimit::max(LONGEST)))
        .route("/script/{name}", get(script))
        .route("/{folder}/{name}", get(picture))
        .route("/{name}", get(file))
        .with_state(Door { hall: Arc::new(hall), guard })
}

type Who = ConnectInfo<SocketAddr>;

/// A file of the page.
async fn file(State(door): State<Door>, ConnectInfo(who): Who, name: Path<String>) -> Response {
    serve::file(&FILES, name, &door.guard, who)
}

/// Does something.
async fn command(
    State(door): State<Door>,
    ConnectInfo(who): Who,
    body: Result<Bytes, BytesRejection>,
) -> Response {
    let refuse = |code: StatusCode, why: String| {
        door.guard.log(who, &why);
        (code, format!("{why}\n")).into_response()
    };
    let body = match body {
        Ok(body) => body,
        Err(error) => {
            return refuse(error.status(), format!("a command that is none ({})", error.body_text()));
        }
    };
    let command: Command = match serde_json::from_slice(&body) {
        Ok(command) => command,
        Err(error) => {
            return refuse(StatusCode::BAD_REQUEST, format!("a command that makes no sense ({error})"));
        }
    };
    let waits = Patience(Arc::default());
    let (hall, cancel) = (door.hall.clone(), waits.0.clone());
    match tokio::task::spawn_blocking(move || hall.obey(command, &cancel)).await {
        Ok(Ok(())) => door.hall.told(),
        Ok(Err(refused)) => cannot(refused.to_string(), ""),
        Err(_) => serve::later("the program ends\n"),
    }
}

/// Somebody waits for what a command makes, until this is dropped.
struct Patience(Arc<AtomicBool>);

impl Drop for Patience {
    fn drop(&mut self) {
        self.0.store(true, Ordering::SeqCst);
    }
}

/// A picture.
async fn picture(
    State(door): State<Door>,
    ConnectInfo(who): Who,
    Path((folder, name)): Path<(String, String)>,
) -> Response {
    let hall = &door.hall;
    let (Some((size, grade)), Some((id, genome))) = (hall.kind(&folder), hall.genome(&name, ".png")) else {
        return door.guard.lost(who);
    };
    let (sender, drawn) = oneshot::channel::<Drawn>();
    // Whoever hangs up has this dropped, and the ticket with it.
    let tell = move |drawn| sender.send(drawn).unwrap_or_default();
    let _ticket = hall.atelier.ask(((id, size), grade), genome, tell);
    match drawn.await {
        Ok(Ok(Image { png, grade })) => {
            let grade = if grade == Grade::Finished { "finished" } else { "rough" };
            let headers = [(header::CONTENT_TYPE, "image/png"), (HeaderName::from_static("picture"), grade)];
            (headers, Bytes::from_owner(png)).into_response()
        }
        Ok(Err(error)) => wrong(&error),
        Err(_) => serve::later("the program ends\n"),
    }
}

/// A script to save.
async fn script(State(door): State<Door>, ConnectInfo(who): Who, Path(name): Path<String>) -> Response {
    let Some((_, genome)) = door.hall.genome(&name, ".rhai") else { return door.guard.lost(who) };
    match door.hall.atelier.subject().export(&genome) {
        Some(text) => ([(header::CONTENT_TYPE, "text/plain; charset=utf-8")], text).into_response(),
        None => cannot("the script has no text to change".into(), "save it in a file, and explore that"),
    }
}

/// What a page shows that asked for what cannot be.
#[derive(Serialize)]
struct Notice<'a> {
    message: String,
    hint: &'a str,
}

fn cannot(message: String, hint: &str) -> Response {
    json(StatusCode::CONFLICT, &Notice { message, hint })
}

/// What is wrong with the script, if it has these values.
fn wrong(error: &Diagnostic) -> Response {
    cannot(error.message.clone(), error.hints.first().map_or("", String::as_str))
}

/// An answer for programs.
fn json(code: StatusCode, what: &impl Serialize) -> Response {
    match serde_json::to_vec(what) {
        Ok(text) => (code, [(header::CONTENT_TYPE, "application/json")], text).into_response(),
        Err(error) => (StatusCode::INTERNAL_SERVER_ERROR, error.to_string()).into_response(),
    }
}
