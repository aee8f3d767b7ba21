//! Accepts requests, each on its own thread.

use super::answer::{Answer, Body, Request, Served, refused};
use std::io::{self, Read, Write};
use std::net::{Shutdown, TcpListener, TcpStream};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Duration;

/// Maximum number of simultaneous requests; a browser requests six files at a time.
const MOST_AT_ONCE: usize = 32;
/// Maximum size of the headers; those of a browser are a tenth of it.
const MOST_BYTES: usize = 1 << 14;
const MOST_HEADERS: usize = 64;
const IO_TIMEOUT: Duration = Duration::from_secs(20);

/// Serves requests until the program is ended.
pub(super) fn serve(listener: &TcpListener, served: Served) -> ! {
    let served = Arc::new(served);
    let busy = Arc::new(AtomicUsize::new(0));
    loop {
        let Ok((stream, _)) = listener.accept() else {
            // For example out of file handles: the next attempt may succeed.
            std::thread::sleep(Duration::from_millis(50));
            continue;
        };
        if busy.load(Ordering::SeqCst) >= MOST_AT_ONCE {
            continue;
        }
        busy.fetch_add(1, Ordering::SeqCst);
        let (served, busy) = (Arc::clone(&served), Arc::clone(&busy));
        std::thread::spawn(move || {
            // A client that has disconnected needs no answer.
            let _ = handle_request(stream, &served);
            busy.fetch_sub(1, Ordering::SeqCst);
        });
    }
}

/// Reads one request and answers it.
fn handle_request(mut stream: TcpStream, served: &Served) -> io::Result<()> {
    stream.set_read_timeout(Some(IO_TIMEOUT))?;
    stream.set_write_timeout(Some(IO_TIMEOUT))?;
    let mut bytes = Vec::new();
    let (answer, headers_only) = loop {
        let mut headers = [httparse::EMPTY_HEADER; MOST_HEADERS];
        let mut parsed = httparse::Request::new(&mut headers);
        match parsed.parse(&bytes) {
            Ok(httparse::Status::Complete(_)) => {
                let (method, target) = (parsed.method.unwrap_or_default(), parsed.path.unwrap_or_default());
                let request = Request { method, target, headers: parsed.headers };
                break (served.answer(&request), method == "HEAD");
            }
            Ok(httparse::Status::Partial) if bytes.len() < MOST_BYTES => {}
            _ => break (refused("400 Bad Request", "the request cannot be read"), false),
        }
        let mut more = [0; 4096];
        match stream.read(&mut more)? {
            0 => return Ok(()),
            n => bytes.extend_from_slice(&more[..n]),
        }
    };
    write(&mut stream, answer, headers_only)?;
    stream.shutdown(Shutdown::Write)
}

fn write(out: &mut impl Write, answer: Answer, headers_only: bool) -> io::Result<()> {
    let length = match &answer.body {
        Body::Static(bytes) => bytes.len() as u64,
        Body::Text(text) => text.len() as u64,
        Body::File(_, length) => *length,
    };
    let packed = if answer.packed { "Content-Encoding: gzip\r\n" } else { "" };
    // The browser stores nothing, other pages cannot frame the page, and no referrer is sent.
    write!(
        out,
        "HTTP/1.1 {}\r\nContent-Type: {}\r\nContent-Length: {length}\r\n{packed}Connection: close\r\n\
         Cache-Control: no-store\r\nX-Content-Type-Options: nosniff\r\nReferrer-Policy: no-referrer\r\n\
         Cross-Origin-Resource-Policy: same-origin\r\nCross-Origin-Opener-Policy: same-origin\r\n\
         Content-Security-Policy: frame-ancestors 'none'\r\n\r\n",
        answer.status, answer.kind,
    )?;
    if headers_only {
        return Ok(());
    }
    match answer.body {
        Body::Static(bytes) => out.write_all(bytes),
        Body::Text(text) => out.write_all(text.as_bytes()),
        Body::File(file, length) => io::copy(&mut file.take(length), out).map(|_| ()),
    }
}

#[cfg(test)]
mod tests {
    use super::super::given_file::GivenFile;
    use super::super::site::Asset;
    use super::*;
    use std::net::{Ipv4Addr, SocketAddr};
    use std::path::Path;

    const ASSETS: &[Asset] =
        &[Asset { path: "index.html", packed: b"page" }, Asset { path: "a/b.js", packed: b"code" }];
    const TOKEN: &str = "0123456789abcdef";
    const FILE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/Cargo.toml");

    fn start() -> SocketAddr {
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, 0)).unwrap();
        let address = listener.local_addr().unwrap();
        let files = vec![GivenFile::new(Path::new(FILE)).unwrap()];
        let served = Served::new(address.port(), TOKEN.to_owned(), ASSETS, files);
        std::thread::spawn(move || serve(&listener, served));
        address
    }

    fn sent(address: SocketAddr, text: &str) -> String {
        let mut stream = TcpStream::connect(address).unwrap();
        stream.write_all(text.as_bytes()).unwrap();
        let mut said = String::new();
        stream.read_to_string(&mut said).unwrap();
        said
    }

    /// `GET` of a path with some headers in addition to `Host`.
    fn got(address: SocketAddr, path: &str, headers: &str) -> String {
        sent(address, &format!("GET {path} HTTP/1.1\r\nHost: {address}\r\n{headers}\r\n"))
    }

    fn status(answer: &str) -> u16 {
        answer.split(' ').nth(1).and_then(|code| code.parse().ok()).unwrap_or_default()
    }

    #[test]
    fn the_page_and_its_files_are_answered_below_the_token() {
        let address = start();
        let page = got(address, &format!("/{TOKEN}/"), "");
        assert!(page.starts_with("HTTP/1.1 200 OK\r\nContent-Type: text/html"), "{page}");
        assert!(page.contains("Content-Encoding: gzip\r\n") && page.ends_with("\r\n\r\npage"), "{page}");
        assert!(got(address, &format!("/{TOKEN}/a/b.js?x=1"), "").ends_with("\r\n\r\ncode"));
        let origin = format!("Origin: http://{address}\r\n");
        assert_eq!(status(&got(address, &format!("/{TOKEN}/"), &origin)), 200);
    }

    #[test]
    fn a_wrong_token_is_refused_whatever_its_length() {
        let address = start();
        for path in ["/", "/a/b.js", "/0123456789abcdee/", "/0123456789abcdef0/", "//", "/0123/"] {
            assert_eq!(status(&got(address, path, "")), 403, "{path}");
        }
    }

    #[test]
    fn another_host_is_refused() {
        let address = start();
        let port = address.port();
        let localhost = format!("localhost:{port}");
        for host in ["evil.example", "127.0.0.1", "127.0.0.1:1", &localhost, "", &format!("{address}.evil")] {
            let answer = sent(address, &format!("GET /{TOKEN}/ HTTP/1.1\r\nHost: {host}\r\n\r\n"));
            assert_eq!(status(&answer), 403, "{host}: {answer}");
        }
        let none = sent(address, &format!("GET /{TOKEN}/ HTTP/1.1\r\n\r\n"));
        let two = got(address, &format!("/{TOKEN}/"), "Host: evil.example\r\n");
        assert_eq!((status(&none), status(&two)), (403, 403));
    }

    #[test]
    fn a_foreign_origin_is_refused() {
        let address = start();
        for origin in ["null", "https://evil.example", "http://127.0.0.1:1", &format!("https://{address}")] {
            let answer = got(address, &format!("/{TOKEN}/"), &format!("Origin: {origin}\r\n"));
            assert_eq!(status(&answer), 403, "{origin}");
        }
    }

    #[test]
    fn no_path_leads_out_of_the_page() {
        let address = start();
        for path in [
            "../Cargo.toml",
            "..%2fCargo.toml",
            "a/../index.html",
            "a//b.js",
            "/etc/passwd",
            "handed/../../Cargo.toml",
            "handed/1",
            "handed/00",
            "handed/+0",
            "handed/",
            "INDEX.HTML",
            "index.html%00",
        ] {
            assert_eq!(status(&got(address, &format!("/{TOKEN}/{path}"), "")), 404, "{path}");
        }
    }

    #[test]
    fn a_file_is_handed_over_as_it_is() {
        let address = start();
        let list = got(address, &format!("/{TOKEN}/handed.json"), "");
        assert!(list.ends_with(&format!("[{{\"name\":{}}}]", serde_json::json!(FILE))), "{list}");
        let file = got(address, &format!("/{TOKEN}/handed/0"), "");
        let (_, body) = file.split_once("\r\n\r\n").unwrap();
        assert_eq!(body, std::fs::read_to_string(FILE).unwrap());
        let head = sent(address, &format!("HEAD /{TOKEN}/handed/0 HTTP/1.1\r\nHost: {address}\r\n\r\n"));
        assert!(head.contains(&format!("Content-Length: {}\r\n", body.len())) && head.ends_with("\r\n\r\n"));
    }

    #[test]
    fn nothing_can_be_sent_and_garbage_is_no_request() {
        let address = start();
        for method in ["POST", "PUT", "DELETE", "OPTIONS"] {
            let request = format!("{method} /{TOKEN}/ HTTP/1.1\r\nHost: {address}\r\n\r\n");
            assert_eq!(status(&sent(address, &request)), 405, "{method}");
        }
        assert_eq!(status(&sent(address, "\u{1}\u{2} nonsense\r\n\r\n")), 400);
        let endless = format!("GET /{TOKEN}/ HTTP/1.1\r\nX: {}", "x".repeat(MOST_BYTES));
        assert_eq!(status(&sent(address, &endless)), 400);
        assert_eq!(status(&got(address, &format!("/{TOKEN}/"), "")), 200);
    }
}
