//! The server: answers requests for the page, and makes WebSockets of others.

use std::io::{Read, Write};
use std::net::{IpAddr, Shutdown, TcpListener, TcpStream};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;
use std::time::{Duration, Instant};

use tungstenite::handshake::derive_accept_key;

use super::guard::Guard;
use super::hub::Hub;
use super::request::Request;
use super::socket;
use crate::engine::Layer;
use crate::error::{Error, Result};
use crate::image::ToneMap;

/// Most connections at a time. More are closed at once.
const MOST: usize = 64;
/// Time after which a client that takes no bytes is given up.
const PATIENCE: Duration = Duration::from_secs(10);
/// How long a request that is answered may go on.
const LINGER: Duration = Duration::from_millis(200);

/// The layers that the page offers.
const SHOWN: [Layer; 12] = [
    Layer::Albedo,
    Layer::Normal,
    Layer::Depth,
    Layer::Position,
    Layer::Uv,
    Layer::Direct,
    Layer::Indirect,
    Layer::Emission,
    Layer::Background,
    Layer::Instance,
    Layer::Material,
    Layer::Alpha,
];

const PAGE: &str = include_str!("page/page.html");
const STYLE: &str = include_str!("page/page.css");
const SCRIPTS: [&str; 3] = [
    include_str!("page/connection.js"),
    include_str!("page/controls.js"),
    include_str!("page/page.js"),
];

/// Takes the port.
///
/// # Errors
/// If it is taken.
pub(super) fn bind(listen: IpAddr, port: u16) -> Result<TcpListener> {
    TcpListener::bind((listen, port)).map_err(|error| {
        Error::Resource(format!(
            "--port {port}: cannot serve the page ({error}): use another port, or 0 for any that is free"
        ))
    })
}

/// Answers requests in threads of their own until the process ends.
pub(super) fn serve(server: TcpListener, guard: Guard, hub: Arc<Hub>) -> std::io::Result<()> {
    let open = Arc::new(AtomicUsize::new(0));
    let answer = move || {
        for stream in server.incoming() {
            // Without file descriptors, wait until some are free again.
            let Ok(stream) = stream else {
                thread::sleep(Duration::from_millis(50));
                continue;
            };
            if open.fetch_add(1, Ordering::Relaxed) >= MOST {
                open.fetch_sub(1, Ordering::Relaxed);
                continue;
            }
            let (guard, hub, counted) = (guard.clone(), Arc::clone(&hub), Arc::clone(&open));
            let counted = Counted(counted);
            let work = move || {
                let _counted = counted;
                connection(stream, &guard, &hub)
            };
            // Without a thread, the stream is closed.
            let _ = thread::Builder::new().name("connection".to_owned()).spawn(work);
        }
    };
    thread::Builder::new().name("server".to_owned()).spawn(answer).map(drop)
}

/// A connection that counts until it is dropped.
struct Counted(Arc<AtomicUsize>);

impl Drop for Counted {
    fn drop(&mut self) {
        self.0.fetch_sub(1, Ordering::Relaxed);
    }
}

fn connection(mut stream: TcpStream, guard: &Guard, hub: &Hub) -> std::io::Result<()> {
    stream.set_write_timeout(Some(PATIENCE))?;
    stream.set_nodelay(true)?;
    let accepted = Request::read(&mut stream).and_then(|(request, rest)| {
        guard.check(&request)?;
        Ok((request, rest))
    });
    let (request, rest) = match accepted {
        Ok(accepted) => accepted,
        Err(status) => return refuse(&mut stream, status),
    };
    match (request.path.as_str(), &request.key) {
        ("/live", Some(key)) => {
            let accept = derive_accept_key(key.as_bytes());
            write!(
                stream,
                "HTTP/1.1 101 Switching Protocols\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n\
                 Sec-WebSocket-Accept: {accept}\r\n\r\n"
            )?;
            stream.set_read_timeout(None)?;
            socket::attend(stream, rest, hub)
        }
        ("/", None) => respond(&mut stream, "200 OK", "text/html; charset=utf-8", &page()),
        _ => refuse(&mut stream, "404 Not Found"),
    }
}

fn page() -> String {
    let option = |name: &str| format!("<option>{name}</option>");
    let maps = ToneMap::ALL.map(|map| option(map.name()));
    let layers: String = SHOWN.map(|layer| option(layer.name())).concat();
    PAGE.replace("/*style*/", STYLE)
        .replace("/*tonemaps*/", &maps.concat())
        .replace("/*layers*/", &layers)
        .replace("/*scripts*/", &SCRIPTS.concat())
}

fn refuse(stream: &mut TcpStream, status: &str) -> std::io::Result<()> {
    let advice = match status.split(' ').next() {
        Some("403") => ": use the address that ptfast view printed, with its token",
        _ => "",
    };
    respond(stream, status, "text/plain; charset=utf-8", &format!("{status}{advice}\n"))
}

fn respond(stream: &mut TcpStream, status: &str, kind: &str, body: &str) -> std::io::Result<()> {
    // The page loads nothing, connects only to its own server, and tells nobody its token.
    let head = format!(
        "HTTP/1.1 {status}\r\nContent-Type: {kind}\r\nContent-Length: {}\r\nConnection: close\r\n\
         Cache-Control: no-store\r\nReferrer-Policy: no-referrer\r\nX-Content-Type-Options: nosniff\r\n\
         Content-Security-Policy: default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; \
         img-src blob: data:; connect-src 'self'; frame-ancestors 'none'; base-uri 'none'; form-action 'none'\r\n\r\n",
        body.len()
    );
    stream.write_all(head.as_bytes())?;
    stream.write_all(body.as_bytes())?;
    stream.shutdown(Shutdown::Write)?;
    // Bytes that nobody reads would reset the connection before the answer has arrived.
    stream.set_read_timeout(Some(LINGER))?;
    let (end, mut unread) = (Instant::now() + LINGER, [0; 1 << 12]);
    while Instant::now() < end && stream.read(&mut unread)? > 0 {}
    Ok(())
}
