//! Decides which requests are answered, and how.

use super::given_file::{GivenFile, list};
use super::site::Asset;
use std::fs::File;

/// What is served, and to whom.
#[derive(Debug)]
pub(super) struct Served {
    port: u16,
    token: String,
    assets: &'static [Asset],
    files: Vec<GivenFile>,
}

/// The relevant part of a request.
#[derive(Debug, Clone, Copy)]
pub(super) struct Request<'a> {
    pub(super) method: &'a str,
    /// As requested, without decoding.
    pub(super) target: &'a str,
    pub(super) headers: &'a [httparse::Header<'a>],
}

/// An answer to a request.
#[derive(Debug)]
pub(super) struct Answer {
    pub(super) status: &'static str,
    pub(super) kind: &'static str,
    pub(super) packed: bool,
    pub(super) body: Body,
}

/// What follows the headers.
#[derive(Debug)]
pub(super) enum Body {
    Static(&'static [u8]),
    Text(String),
    File(File, u64),
}

impl Served {
    pub(super) fn new(port: u16, token: String, assets: &'static [Asset], files: Vec<GivenFile>) -> Self {
        Self { port, token, assets, files }
    }

    /// The address of the page.
    pub(super) fn address(&self) -> String {
        format!("http://127.0.0.1:{}/{}/", self.port, self.token)
    }

    pub(super) fn answer(&self, request: &Request<'_>) -> Answer {
        if !self.is_ours(request) {
            return refused("403 Forbidden", "asked for by another host or page");
        }
        if !matches!(request.method, "GET" | "HEAD") {
            return refused("405 Method Not Allowed", "there is nothing to send here");
        }
        let path = request.target.split(['?', '#']).next().unwrap_or_default();
        let Some(path) = self.below_token(path) else {
            return refused("403 Forbidden", "the address needs the token that slipfit printed");
        };
        self.page(path).unwrap_or_else(|| refused("404 Not Found", "there is no such file"))
    }

    /// Whether the request came to this address and from no other page: a foreign host name that resolves to this
    /// address shows in `Host`, a foreign page in `Origin`.
    fn is_ours(&self, request: &Request<'_>) -> bool {
        let all = |name: &str| {
            let named = request.headers.iter().filter(|h| h.name.eq_ignore_ascii_case(name));
            named.map(|h| h.value).collect::<Vec<&[u8]>>()
        };
        let here = format!("127.0.0.1:{}", self.port);
        // Browsers omit the default port.
        let hosts: &[&str] = if self.port == 80 { &[&here, "127.0.0.1"] } else { &[&here] };
        let one_of_ours = |value: &[u8]| hosts.iter().any(|host| host.as_bytes() == value);
        let of_ours = |origin: &[u8]| origin.strip_prefix(b"http://").is_some_and(one_of_ours);
        let host = matches!(all("host").as_slice(), [host] if one_of_ours(host));
        host && all("origin").into_iter().all(of_ours)
    }

    /// The part of the path after the token.
    fn below_token<'a>(&self, path: &'a str) -> Option<&'a str> {
        let (given, below) = path.strip_prefix('/')?.split_once('/')?;
        // Constant-time comparison, so that the time does not reveal how many characters match.
        let differ = given.bytes().zip(self.token.bytes()).fold(0, |differ, (a, b)| differ | (a ^ b));
        (given.len() == self.token.len() && differ == 0).then_some(below)
    }

    /// Paths are compared with the existing ones, never joined or opened.
    fn page(&self, path: &str) -> Option<Answer> {
        if path == "handed.json" {
            let body = Body::Text(list(&self.files).to_string());
            return Some(Answer { status: "200 OK", kind: "application/json", packed: false, body });
        }
        if let Some(number) = path.strip_prefix("handed/") {
            let file = self.files.iter().zip(0..).find(|(_, i): &(_, usize)| i.to_string() == number)?.0;
            return Some(match file.open() {
                Ok((file, length)) => Answer {
                    status: "200 OK",
                    kind: "application/octet-stream",
                    packed: false,
                    body: Body::File(file, length),
                },
                Err(e) => refused("410 Gone", &format!("it cannot be read any more: {e}")),
            });
        }
        let path = if path.is_empty() { "index.html" } else { path };
        let asset = self.assets.iter().find(|asset| asset.path == path)?;
        let body = Body::Static(asset.packed);
        Some(Answer { status: "200 OK", kind: kind(path), packed: true, body })
    }
}

pub(super) fn refused(status: &'static str, why: &str) -> Answer {
    Answer { status, kind: "text/plain; charset=utf-8", packed: false, body: Body::Text(format!("{why}\n")) }
}

fn kind(path: &str) -> &'static str {
    match path.rsplit_once('.').map(|(_, ending)| ending) {
        Some("css") => "text/css; charset=utf-8",
        Some("csv") => "text/csv; charset=utf-8",
        Some("html") => "text/html; charset=utf-8",
        Some("js") => "text/javascript; charset=utf-8",
        Some("svg") => "image/svg+xml",
        Some("wasm") => "application/wasm",
        _ => "text/plain; charset=utf-8",
    }
}
