//! Who may see the page: those who know its token, and pages of the same server.

use std::net::{IpAddr, TcpListener};

use super::request::Request;
use crate::error::{Error, Result};

/// Decides which requests are answered.
#[derive(Clone, Debug)]
pub(super) struct Guard {
    token: String,
    /// Whether only this machine can connect. Then the page's name must be one of it, so that pages of others cannot
    /// reach it under theirs.
    is_local: bool,
}

impl Guard {
    /// For a server at `listen`, with a new token.
    pub(super) fn new(listen: IpAddr) -> Result<Self> {
        let mut bytes = [0; 16];
        getrandom::fill(&mut bytes).map_err(|error| {
            Error::Resource(format!("no random numbers for the token: {error}"))
        })?;
        let token = bytes.iter().map(|byte| format!("{byte:02x}")).collect();
        Ok(Self { token, is_local: listen.is_loopback() })
    }

    /// The page's address with its token.
    pub(super) fn address(&self, server: &TcpListener) -> Result<String> {
        let address = server.local_addr().map_err(Error::io("the page".as_ref(), "serve"))?;
        Ok(format!("http://{address}/?token={}", self.token))
    }

    /// The status of the answer to a request that is refused.
    pub(super) fn check(&self, request: &Request) -> Result<(), &'static str> {
        let host = request.host.as_deref().ok_or("400 Bad Request")?;
        let name = host.rsplit_once(':').map_or(host, |(name, port)| match port.parse::<u16>() {
            Ok(_) => name,
            Err(_) => host,
        });
        // Any port, for tunnels.
        if self.is_local && !["localhost", "127.0.0.1", "[::1]"].contains(&name) {
            return Err("421 Misdirected Request");
        }
        let is_own = |origin: &str| origin.strip_prefix("http://").is_some_and(|name| name == host);
        let foreign = request.origin.as_deref().is_some_and(|origin| !is_own(origin));
        if foreign || request.is_upgrade() && request.origin.is_none() {
            return Err("403 Forbidden");
        }
        match request.token.as_deref() {
            Some(token) if self.is_token(token) => Ok(()),
            _ => Err("403 Forbidden"),
        }
    }

    /// Always compares all bytes: the time of the answer must not show how many are right.
    fn is_token(&self, token: &str) -> bool {
        let pairs = token.bytes().zip(self.token.bytes());
        token.len() == self.token.len() && pairs.fold(0, |differ, (a, b)| differ | (a ^ b)) == 0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn request(guard: &Guard) -> Request {
        Request {
            path: "/live".to_owned(),
            token: Some(guard.token.clone()),
            host: Some("localhost:8000".to_owned()),
            origin: Some("http://localhost:8000".to_owned()),
            key: Some("a".to_owned()),
        }
    }

    #[test]
    fn only_own_pages_with_the_token_are_answered() {
        let guard = Guard::new([127, 0, 0, 1].into()).unwrap();
        let check = |change: &dyn Fn(&mut Request)| {
            let mut request = request(&guard);
            change(&mut request);
            guard.check(&request)
        };
        let some = |text: &str| Some(text.to_owned());
        assert_eq!(check(&|_| ()), Ok(()));
        for host in ["localhost", "127.0.0.1:1", "[::1]:9", "[::1]"] {
            let origin = format!("http://{host}");
            assert_eq!(check(&|r| (r.host, r.origin) = (some(host), some(&origin))), Ok(()));
        }
        let forbidden = Err("403 Forbidden");
        assert_eq!(check(&|r| r.token = None), forbidden);
        assert_eq!(check(&|r| r.token = some("0")), forbidden);
        for origin in ["http://localhost:8001", "https://localhost:8000", "null", "http://evil"] {
            assert_eq!(check(&|r| r.origin = some(origin)), forbidden, "{origin}");
        }
        assert_eq!(check(&|r| r.origin = None), forbidden);
        // The page itself comes without an origin.
        assert_eq!(check(&|r| (r.origin, r.key) = (None, None)), Ok(()));
        for host in ["evil", "localhost.evil:80", "127.0.0.1.evil", "localhost:x"] {
            let misdirected = Err("421 Misdirected Request");
            let origin = format!("http://{host}");
            assert_eq!(check(&|r| (r.host, r.origin) = (some(host), some(&origin))), misdirected);
        }
        assert_eq!(check(&|r| r.host = None), Err("400 Bad Request"));
        let open = Guard { is_local: false, ..guard.clone() };
        let mut other = request(&guard);
        (other.host, other.origin) = (some("box:80"), some("http://box:80"));
        assert_eq!(open.check(&other), Ok(()));
        other.token = some("0");
        assert_eq!(open.check(&other), forbidden);
    }
}
