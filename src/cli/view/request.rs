//! HTTP requests: their heads, of bounded length and time.

use std::io::{ErrorKind, Read};
use std::net::TcpStream;
use std::time::{Duration, Instant};

/// Most bytes of a head.
const MOST: usize = 8 << 10;
/// Most header lines of a head.
const LINES: usize = 64;
/// Time in which a head must arrive.
const TIME: Duration = Duration::from_secs(5);

/// What the head of a request says, as far as it matters.
#[derive(Debug, Default, PartialEq)]
pub(super) struct Request {
    pub(super) path: String,
    /// The query's `token`.
    pub(super) token: Option<String>,
    pub(super) host: Option<String>,
    pub(super) origin: Option<String>,
    /// The key of a request to become a WebSocket.
    pub(super) key: Option<String>,
}

impl Request {
    /// Whether it asks for a WebSocket.
    pub(super) fn is_upgrade(&self) -> bool {
        self.key.is_some()
    }

    /// Reads a head. Returns also the bytes after it that have arrived. The error is the status of the answer.
    pub(super) fn read(stream: &mut TcpStream) -> Result<(Self, Vec<u8>), &'static str> {
        let (begin, mut head) = (Instant::now(), Vec::new());
        loop {
            let left = TIME.saturating_sub(begin.elapsed());
            if left.is_zero() || stream.set_read_timeout(Some(left)).is_err() {
                return Err("408 Request Timeout");
            }
            let mut bytes = [0; 1 << 10];
            match stream.read(&mut bytes) {
                Ok(0) => return Err("400 Bad Request"),
                Ok(read) => head.extend(&bytes[..read]),
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                Err(_) => return Err("408 Request Timeout"),
            }
            if let Some((request, length)) = Self::parse(&head)? {
                return Ok((request, head.split_off(length)));
            }
            if head.len() > MOST {
                return Err("431 Request Header Fields Too Large");
            }
        }
    }

    /// The request and the length of its head; `None` if more must arrive.
    fn parse(head: &[u8]) -> Result<Option<(Self, usize)>, &'static str> {
        let mut lines = [httparse::EMPTY_HEADER; LINES];
        let mut parsed = httparse::Request::new(&mut lines);
        let length = match parsed.parse(head) {
            Ok(httparse::Status::Complete(length)) => length,
            Ok(httparse::Status::Partial) => return Ok(None),
            Err(httparse::Error::TooManyHeaders) => {
                return Err("431 Request Header Fields Too Large");
            }
            Err(_) => return Err("400 Bad Request"),
        };
        if parsed.method != Some("GET") {
            return Err("405 Method Not Allowed");
        }
        let target = parsed.path.unwrap_or_default();
        let (path, query) = target.split_once('?').unwrap_or((target, ""));
        let token = query.split('&').find_map(|pair| pair.strip_prefix("token="));
        let mut request =
            Self { path: path.to_owned(), token: token.map(str::to_owned), ..Self::default() };
        for line in parsed.headers {
            let value = std::str::from_utf8(line.value).map_err(|_| "400 Bad Request")?;
            let place = match line.name.to_ascii_lowercase().as_str() {
                "host" => &mut request.host,
                "origin" => &mut request.origin,
                "sec-websocket-key" => &mut request.key,
                _ => continue,
            };
            // Which of two would count, others may see differently.
            if place.replace(value.trim().to_owned()).is_some() {
                return Err("400 Bad Request");
            }
        }
        Ok(Some((request, length)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn heads_are_read_as_far_as_they_matter() {
        let head = "GET /live?a=1&token=ab HTTP/1.1\r\nHOST: localhost:1\r\nOrigin: http://x\r\nOther: y\r\n\r\nrest";
        let (request, length) = Request::parse(head.as_bytes()).unwrap().unwrap();
        assert_eq!(&head[length..], "rest");
        let some = |text: &str| Some(text.to_owned());
        let path = "/live".to_owned();
        let (token, host, origin) = (some("ab"), some("localhost:1"), some("http://x"));
        assert_eq!(request, Request { path, token, host, origin, key: None });
        assert_eq!(Request::parse(&head.as_bytes()[..30]), Ok(None));
        for (head, status) in [
            ("POST / HTTP/1.1\r\n\r\n", "405"),
            ("GET / HTTP/1.1\r\nHost: a\r\nHost: b\r\n\r\n", "400"),
            ("\0\r\n\r\n", "400"),
        ] {
            let refused = Request::parse(head.as_bytes()).unwrap_err();
            assert!(refused.starts_with(status), "{refused}");
        }
        let many = format!("GET / HTTP/1.1\r\n{}\r\n", "A: b\r\n".repeat(65));
        assert!(Request::parse(many.as_bytes()).unwrap_err().starts_with("431"));
    }
}
