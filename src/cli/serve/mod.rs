//! Pages for browsers: a server on a thread of its own, whose address holds a secret.

mod guard;

pub use guard::Guard;

use super::report::{Failure, Terminal, err};
use axum::Router;
use axum::extract::{ConnectInfo, Path};
use axum::http::{StatusCode, header};
use axum::response::{IntoResponse, Response};
use std::net::{IpAddr, Ipv4Addr, Ipv6Addr, SocketAddr};
use std::thread::JoinHandle;
use tokio::net::TcpListener;
use tokio::sync::watch;

/// Where a page is served.
#[derive(clap::Args, Clone, Copy, Debug)]
pub struct Listen {
    /// Port of the page; 0 takes one that is free
    #[arg(long, value_name = "N", default_value_t = 0)]
    port: u16,

    /// Interface to serve the page on; anything but the loopback lets others in your network in, who know the address
    #[arg(long, value_name = "IP", default_value_t = IpAddr::V4(Ipv4Addr::LOCALHOST))]
    address: IpAddr,

    /// Opens the page in your browser
    #[arg(long)]
    open: bool,
}

/// A file of a page: its name, which is empty for the page itself, its type, and its text.
pub type File = (&'static str, &'static str, &'static str);

/// A server that ends when it is dropped.
pub struct Server {
    /// The page.
    pub address: String,
    end: watch::Sender<bool>,
    thread: Option<JoinHandle<()>>,
}

impl Server {
    /// Serves what `routes` makes, below the token, on a thread of its own.
    ///
    /// # Errors
    /// If nothing can be served there.
    pub fn start(
        listen: Listen,
        terminal: Terminal,
        routes: impl FnOnce(Guard) -> Router,
    ) -> Result<Server, Failure> {
        let wanted = SocketAddr::new(listen.address, listen.port);
        let listener = std::net::TcpListener::bind(wanted)
            .map_err(|e| cannot(&format!("cannot serve a page at {wanted}"), e))?;
        let ready = listener.set_nonblocking(true).and_then(|()| listener.local_addr());
        let bound = ready.map_err(|e| cannot("cannot serve a page", e))?;
        let token = guard::token()?;
        let address = format!("http://{}/{token}/", shown(bound));
        let runtime = tokio::runtime::Builder::new_current_thread().enable_io().enable_time().build();
        let runtime = runtime.map_err(|e| cannot("cannot start the server", e))?;
        let guard = Guard::new(bound, terminal);
        let router = guarded(routes(guard.clone()), &token, guard);
        let (end, ended) = watch::channel(false);
        let thread = std::thread::spawn(move || {
            if let Err(error) = runtime.block_on(serve(listener, router, ended)) {
                err(format_args!("the server ended ({error})"));
            }
            // What somebody asked for last is of no interest any more.
            runtime.shutdown_background();
        });
        if listen.open
            && let Err(error) = open::that_detached(&address)
        {
            err(format_args!("no browser could be opened ({error}); open the address yourself"));
        }
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

fn cannot(what: &str, e: std::io::Error) -> Failure {
    Failure::error(format!("{what} ({e})"), "try another --port")
}

/// What is behind the token, and refusals for all else.
fn guarded(inside: Router, token: &str, guard: Guard) -> Router {
    let lost = guard.clone();
    Router::new()
        .nest(&format!("/{token}/"), inside)
        .fallback(async move |ConnectInfo(who): ConnectInfo<SocketAddr>| lost.lost(who))
        .layer(axum::middleware::from_fn_with_state(guard, guard::check))
}

/// Serves until `end` is true. Pages that are open do not keep it.
async fn serve(
    listener: std::net::TcpListener,
    router: Router,
    mut end: watch::Receiver<bool>,
) -> std::io::Result<()> {
    let listener = TcpListener::from_std(listener)?;
    let service = router.into_make_service_with_connect_info::<SocketAddr>();
    tokio::select! {
        served = async { axum::serve(listener, service).await } => served,
        _ = end.wait_for(|end| *end) => Ok(()),
    }
}

/// The answer to who asks for a file of a page.
pub fn file(files: &[File], Path(name): Path<String>, guard: &Guard, who: SocketAddr) -> Response {
    match files.iter().find(|(known, ..)| *known == name) {
        Some((_, kind, text)) => ([(header::CONTENT_TYPE, *kind)], *text).into_response(),
        None => guard.lost(who),
    }
}

/// What cannot be answered for a reason that passes.
pub fn later(why: &'static str) -> Response {
    (StatusCode::CONFLICT, why).into_response()
}

/// An address that can be opened: that of all interfaces is none.
fn shown(bound: SocketAddr) -> SocketAddr {
    let loopback: IpAddr = match bound.ip() {
        IpAddr::V4(ip) if ip.is_unspecified() => Ipv4Addr::LOCALHOST.into(),
        IpAddr::V6(ip) if ip.is_unspecified() => Ipv6Addr::LOCALHOST.into(),
        _ => return bound,
    };
    SocketAddr::new(loopback, bound.port())
}
