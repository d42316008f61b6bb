//! `orogen watch` with a page: a server on a thread of its own, and a loop that answers saves and Ctrl-C.

use super::super::interrupt::Interrupt;
use super::super::report::{Failure, Outcome, Terminal, err};
use super::super::work::{self, Work};
use super::guard::{self, Guard};
use super::server::{self, Hall};
use super::{Args, POLL};
use crate::diag::Diagnostic;
use crate::session::live::{Event, Live};
use crate::world::watch::Watch;
use std::net::{IpAddr, SocketAddr};
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::thread::JoinHandle;
use tokio::sync::watch;

/// Something to answer.
enum Call {
    /// A file was perhaps saved.
    Saved,
    /// Something happened in the studio.
    Live(Event),
    /// Ctrl-C.
    Interrupted,
}

/// Runs the command.
pub fn run(args: &Args, work: Work, terminal: &Terminal) -> Outcome {
    let (sender, calls) = channel();
    let pressed = sender.clone();
    let _interrupt = Interrupt::listen(move || pressed.send(Call::Interrupted).unwrap_or_default());
    let Work { session, order, .. } = work;
    let (news, heard) = watch::channel(0);
    let told = sender.clone();
    let live = Arc::new(Live::new(session, order, move |event| {
        news.send_modify(|count| *count += 1);
        if event != Event::Changed {
            // Nobody listens any more only when the program ends.
            told.send(Call::Live(event)).unwrap_or_default();
        }
    }));
    let server = Server::start(args, live.clone(), heard, *terminal)?;
    err(format_args!("{} is at {}", args.script.display(), terminal.bold(&server.address)));
    err(terminal.dim("Ctrl-C ends the watch"));
    let watched = follow(&live, sender, &calls, terminal);
    drop(server);
    watched
}

/// Answers calls until Ctrl-C.
fn follow(live: &Live, sender: Sender<Call>, calls: &Receiver<Call>, terminal: &Terminal) -> Outcome {
    let mut watch = Watch::new(move || sender.send(Call::Saved).unwrap_or_default()).ok();
    loop {
        match calls.recv_timeout(POLL) {
            Ok(Call::Saved) => live.saved(),
            // Where the system cannot tell of changes, looking every second has to do.
            Err(RecvTimeoutError::Timeout) if watch.is_none() => live.saved(),
            Err(RecvTimeoutError::Timeout) => {}
            Ok(Call::Live(Event::Read)) => {
                let files = live.files();
                if watch.as_mut().is_some_and(|w| w.set_files(files.iter().map(PathBuf::as_path)).is_err()) {
                    watch = None;
                }
                if let Some(loaded) = live.loaded() {
                    work::report(&loaded, terminal);
                }
            }
            Ok(Call::Live(_)) => {}
            Ok(Call::Interrupted) | Err(RecvTimeoutError::Disconnected) => return Ok(()),
        }
    }
}

/// A server that ends when it is dropped.
struct Server {
    /// The page.
    address: String,
    end: watch::Sender<bool>,
    thread: Option<JoinHandle<()>>,
}

impl Server {
    fn start(
        args: &Args,
        live: Arc<Live>,
        news: watch::Receiver<u64>,
        terminal: Terminal,
    ) -> Result<Server, Failure> {
        let cannot = |what: &str, e: std::io::Error| {
            let error = Diagnostic::error(format!("{what} ({e})"));
            Failure::Error(Box::new(error.hint("try another --port, or --headless to write files only")))
        };
        let wanted = SocketAddr::new(args.address, args.port);
        let listener = std::net::TcpListener::bind(wanted)
            .map_err(|e| cannot(&format!("cannot serve a page at {wanted}"), e))?;
        let ready = listener.set_nonblocking(true).and_then(|()| listener.local_addr());
        let bound = ready.map_err(|e| cannot("cannot serve a page", e))?;
        let token = guard::token()?;
        let address = format!("http://{}/{token}/", shown(bound));
        let runtime = tokio::runtime::Builder::new_current_thread().enable_io().enable_time().build();
        let runtime = runtime.map_err(|e| cannot("cannot start the server", e))?;
        let (end, ended) = watch::channel(false);
        let hall = Hall { live, news, guard: Guard::new(bound, terminal) };
        let thread = std::thread::spawn(move || {
            let served = runtime.block_on(async {
                let listener = tokio::net::TcpListener::from_std(listener)?;
                // Pages that look on do not keep us.
                let mut gone = ended.clone();
                tokio::select! {
                    served = server::serve(listener, &token, hall, ended) => served,
                    _ = gone.wait_for(|end| *end) => Ok(()),
                }
            });
            if let Err(error) = served {
                err(format_args!("the server ended ({error})"));
            }
        });
        Ok(Server { address, end, thread: Some(thread) })
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        self.end.send_replace(true);
        if let Some(thread) = self.thread.take() {
            // A panic there was reported, and ended the program.
            let _ = thread.join();
        }
    }
}

/// An address that can be opened: that of all interfaces is none.
fn shown(bound: SocketAddr) -> SocketAddr {
    match bound.ip() {
        IpAddr::V4(ip) if ip.is_unspecified() => SocketAddr::new([127, 0, 0, 1].into(), bound.port()),
        IpAddr::V6(ip) if ip.is_unspecified() => {
            SocketAddr::new(std::net::Ipv6Addr::LOCALHOST.into(), bound.port())
        }
        _ => bound,
    }
}
