//! Who may talk to the page's server.
//!
//! The server stands on the loopback interface, but every page of every site that a browser of this machine shows can
//! send requests there, and a name of another site can be made to mean this machine. So a request must
//!
//! - name us as its host, by an address or as `localhost`, which a renamed site does not;
//! - come from our own page, if it says where it comes from, which browsers always do where it may change something:
//!   for WebSockets, and for all that is not only to be read;
//! - know the token in the address, which is new each time and too long to be guessed.

use crate::cli::report::{Failure, Terminal, err};
use axum::extract::{ConnectInfo, Request, State};
use axum::http::{HeaderMap, Method, StatusCode, header};
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};
use std::net::SocketAddr;

/// What requests are judged by.
#[derive(Clone, Debug)]
pub struct Guard {
    /// Where the server listens.
    address: SocketAddr,
    terminal: Terminal,
}

/// 128 random bits.
pub fn token() -> Result<String, Failure> {
    let mut bytes = [0; 16];
    getrandom::fill(&mut bytes).map_err(|e| {
        Failure::error(
            format!("the system gives no random numbers ({e})"),
            "pages need them; commands that write files do not",
        )
    })?;
    Ok(bytes.iter().map(|b| format!("{b:02x}")).collect())
}

impl Guard {
    /// The guard of a server.
    pub fn new(address: SocketAddr, terminal: Terminal) -> Guard {
        Guard { address, terminal }
    }

    /// Whether a `Host` is us: any name would do for somebody who can rename sites, so only addresses and `localhost` do.
    fn is_host(&self, host: &str) -> bool {
        let (name, port) = match host.rsplit_once(':') {
            Some((name, port)) if !port.is_empty() && port.bytes().all(|b| b.is_ascii_digit()) => {
                (name, port.parse().ok())
            }
            _ => (host, Some(80)),
        };
        let bare = name.trim_start_matches('[').trim_end_matches(']');
        let named = bare.eq_ignore_ascii_case("localhost") || bare.parse::<std::net::IpAddr>().is_ok();
        named && port == Some(self.address.port())
    }

    /// Why a request with these headers is refused, if it is.
    fn objection(&self, method: &Method, headers: &HeaderMap) -> Option<&'static str> {
        let text = |name| headers.get(name).map(|v| v.to_str().unwrap_or(""));
        let Some(host) = text(header::HOST).filter(|host| self.is_host(host)) else {
            return Some("it is meant for another host");
        };
        let ours = |origin: &str| origin.strip_prefix("http://") == Some(host);
        match text(header::ORIGIN) {
            Some(origin) if !ours(origin) => Some("it comes from another site"),
            None if *method != Method::GET || headers.contains_key(header::UPGRADE) => {
                Some("it does not say from which page it comes")
            }
            _ => None,
        }
    }

    /// The answer where there is none: the token is wrong, or what stands behind it.
    pub fn lost(&self, who: SocketAddr) -> Response {
        self.log(who, "there is nothing at that address, or its token is wrong");
        let text = "there is nothing here; open the address that orogen printed\n";
        (StatusCode::NOT_FOUND, text).into_response()
    }

    /// Says that something was refused.
    pub fn log(&self, who: SocketAddr, what: &str) {
        err(self.terminal.dim(format_args!("refused {who}: {what}")));
    }
}

/// Lets requests through, or not.
pub async fn check(
    State(guard): State<Guard>,
    ConnectInfo(who): ConnectInfo<SocketAddr>,
    request: Request,
    next: Next,
) -> Response {
    match guard.objection(request.method(), request.headers()) {
        Some(why) => {
            guard.log(who, why);
            (StatusCode::FORBIDDEN, "refused\n").into_response()
        }
        None => sealed(next.run(request).await),
    }
}

/// An answer that browsers keep to themselves, and that runs nothing from elsewhere.
fn sealed(mut response: Response) -> Response {
    const POLICY: &str = "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' blob: data:; \
                          connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";
    let headers = response.headers_mut();
    for (name, value) in [
        (header::CONTENT_SECURITY_POLICY, POLICY),
        (header::X_CONTENT_TYPE_OPTIONS, "nosniff"),
        (header::REFERRER_POLICY, "no-referrer"),
        (header::CACHE_CONTROL, "no-store"),
    ] {
        headers.insert(name, header::HeaderValue::from_static(value));
    }
    response
}

#[cfg(test)]
mod tests {
    use super::*;

    fn objection(headers: &[(&'static str, &str)]) -> Option<&'static str> {
        objection_to(Method::GET, headers)
    }

    fn objection_to(method: Method, headers: &[(&'static str, &str)]) -> Option<&'static str> {
        let terminal = Terminal { color: false, live: false };
        let guard = Guard::new(([127, 0, 0, 1], 8080).into(), terminal);
        let pairs = headers.iter().map(|(k, v)| (k.parse().unwrap(), v.parse().unwrap()));
        guard.objection(&method, &pairs.collect())
    }

    #[test]
    fn our_own_page_is_let_in() {
        for host in ["127.0.0.1:8080", "localhost:8080", "[::1]:8080", "192.168.1.7:8080"] {
            assert_eq!(objection(&[("host", host)]), None, "{host}");
            let origin = format!("http://{host}");
            assert_eq!(objection(&[("host", host), ("origin", &origin), ("upgrade", "websocket")]), None);
        }
    }

    #[test]
    fn others_are_not() {
        for host in ["evil.example:8080", "127.0.0.1:80", "127.0.0.1", "localhost:8080.evil.example", ""] {
            assert!(objection(&[("host", host)]).is_some(), "{host}");
        }
        assert!(objection(&[]).is_some());
        let host = ("host", "127.0.0.1:8080");
        for origin in ["http://evil.example", "https://127.0.0.1:8080", "null", "http://localhost:8080", "é"]
        {
            assert!(objection(&[host, ("origin", origin)]).is_some(), "{origin}");
        }
        assert!(objection(&[host, ("upgrade", "websocket")]).is_some());
        assert!(objection_to(Method::POST, &[host]).is_some());
        assert_eq!(objection_to(Method::POST, &[host, ("origin", "http://127.0.0.1:8080")]), None);
    }

    #[test]
    fn tokens_are_long_and_never_the_same() {
        let (a, b) = (token().unwrap(), token().unwrap());
        assert!(a.len() == 32 && a != b);
    }
}
