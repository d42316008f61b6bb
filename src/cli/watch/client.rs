//! One who looks on: what is new goes out, what they say comes in.
//!
//! Pictures go out as binary messages: the tick of the canvas in 8 bytes, width and height in 2 each, lowest byte first;
//! then [packed blocks](crate::session::live::Canvas::pack). Only one is under way at a time: the next waits until the
//! page says that it has shown this one, so that a slow page gets fewer pictures, not later ones.

use super::routes::Hall;
use crate::diag::Diagnostic;
use crate::session::live::{Command, Report};
use crate::session::picking::Picked;
use axum::extract::ws::{CloseFrame, Message, Utf8Bytes, WebSocket, close_code};
use serde::{Deserialize, Serialize};
use std::net::SocketAddr;
use std::sync::Arc;
use std::time::Duration;
use tokio::sync::mpsc::{Receiver, Sender, channel};

/// What a page says.
#[derive(Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
enum Said {
    /// It wants something.
    Do(Command),
    /// Parameters are to be written into the script.
    Write,
    /// Somebody points at a place of the picture, given as shares of its width and height.
    Pick([f64; 2]),
    /// It has shown everything up to a tick.
    Shown(u64),
}

/// What a page is told, besides pictures.
#[derive(Serialize)]
#[serde(rename_all = "snake_case")]
enum Told<'a> {
    Report(&'a Report),
    Picked(Option<Picked>),
    Notice { error: bool, message: String, hints: Vec<String> },
}

/// Shortest time between two pictures.
const PAUSE: Duration = Duration::from_millis(15);

/// What one page knows.
struct Page {
    socket: WebSocket,
    hall: Hall,
    /// The tick up to which it has everything.
    tick: u64,
    /// Whether a picture is on its way.
    busy: bool,
    report: Option<Arc<Report>>,
    /// Answers about places, which take their time.
    picks: (Sender<Option<Picked>>, Receiver<Option<Picked>>),
}

/// Talks to a page until either is gone.
pub async fn talk(socket: WebSocket, mut hall: Hall, who: SocketAddr) {
    hall.news.mark_changed();
    let mut page = Page { socket, hall, tick: 0, busy: false, report: None, picks: channel(1) };
    if let Err(why) = page.serve().await {
        page.hall.guard.log(who, &why);
        let frame = CloseFrame { code: close_code::POLICY, reason: Utf8Bytes::from_static("refused") };
        // They may be gone already.
        let _ = page.socket.send(Message::Close(Some(frame))).await;
    }
}

impl Page {
    /// Serves a page until it is gone, which is no error.
    ///
    /// # Errors
    /// What it said that no page of ours says.
    async fn serve(&mut self) -> Result<(), String> {
        loop {
            tokio::select! {
                message = self.socket.recv() => match message {
                    Some(Ok(message)) => if !self.hear(message).await? { return Ok(()) },
                    Some(Err(error)) => return Err(format!("a message that is none ({error})")),
                    None => return Ok(()),
                },
                Some(picked) = self.picks.1.recv() => if self.tell(&Told::Picked(picked)).await.is_err() {
                    return Ok(());
                },
                changed = self.hall.news.changed() => if changed.is_err() || self.show().await.is_err() {
                    return Ok(());
                },
            }
        }
    }

    /// Does what a page says; whether to go on.
    async fn hear(&mut self, message: Message) -> Result<bool, String> {
        let text = match message {
            Message::Text(text) => text,
            Message::Binary(_) => return Err("a message that is not text".into()),
            Message::Close(_) => return Ok(false),
            Message::Ping(_) | Message::Pong(_) => return Ok(true),
        };
        let said: Said =
            serde_json::from_str(&text).map_err(|e| format!("a message that makes no sense ({e})"))?;
        let sent = match said {
            Said::Do(command) => match self.hall.live.command(&command) {
                Ok(()) => Ok(()),
                Err(refused) => self.notify(true, refused.to_string(), Vec::new()).await,
            },
            Said::Write => self.write().await,
            Said::Pick(place) => {
                self.pick(place);
                Ok(())
            }
            Said::Shown(tick) => {
                self.busy = tick < self.tick;
                self.show().await
            }
        };
        Ok(sent.is_ok())
    }

    /// Finds out what is at a place, for later; nothing if there is no picture.
    fn pick(&self, place: [f64; 2]) {
        let (live, answer) = (self.hall.live.clone(), self.picks.0.clone());
        tokio::task::spawn_blocking(move || {
            // One answer at a time is asked for, and nobody misses those of a page that is gone.
            let _ = answer.try_send(live.pick(place).ok());
        });
    }

    /// Writes parameters into the script.
    async fn write(&mut self) -> Result<(), axum::Error> {
        match self.hall.live.write_defaults() {
            Ok(files) if files.is_empty() => {
                self.notify(
                    false,
                    "nothing to write: all parameters are as the script says".into(),
                    Vec::new(),
                )
                .await
            }
            Ok(files) => {
                let names: Vec<_> = files.iter().map(|f| f.display().to_string()).collect();
                self.notify(false, format!("written to {}", names.join(", ")), Vec::new()).await
            }
            Err(error) => {
                let Diagnostic { message, hints, .. } = *error;
                self.notify(true, message, hints).await
            }
        }
    }

    /// Sends what is new.
    async fn show(&mut self) -> Result<(), axum::Error> {
        let report = self.hall.live.report();
        if !self.report.as_ref().is_some_and(|known| Arc::ptr_eq(known, &report)) {
            self.tell(&Told::Report(&report)).await?;
            self.report = Some(report);
        }
        if self.busy {
            return Ok(());
        }
        let Some(message) = self.picture() else { return Ok(()) };
        self.busy = true;
        self.socket.send(Message::Binary(message.into())).await?;
        tokio::time::sleep(PAUSE).await;
        Ok(())
    }

    /// The picture as far as it is new to the page.
    fn picture(&mut self) -> Option<Vec<u8>> {
        let canvas = self.hall.live.canvas();
        let news = canvas.since(self.tick);
        if news.blocks.is_empty() {
            return None;
        }
        let mut message = news.tick.to_le_bytes().to_vec();
        message.extend(canvas.size.into_iter().flat_map(|side| (side as u16).to_le_bytes()));
        for block in &news.blocks {
            canvas.pack(block, &mut message);
        }
        self.tick = news.tick;
        Some(message)
    }

    async fn notify(&mut self, error: bool, message: String, hints: Vec<String>) -> Result<(), axum::Error> {
        self.tell(&Told::Notice { error, message, hints }).await
    }

    async fn tell(&mut self, told: &Told<'_>) -> Result<(), axum::Error> {
        let text = serde_json::to_string(told).map_err(axum::Error::new)?;
        self.socket.send(Message::Text(text.into())).await
    }
}
