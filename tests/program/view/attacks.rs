//! Hostile clients of `ptfast view`: none gets a picture without the token, and none stalls others or fills memory.

use std::io::{ErrorKind, Read, Write};
use std::net::{Shutdown, TcpStream};
use std::time::Duration;

use tungstenite::handshake::client::generate_key;
use tungstenite::protocol::Role;
use tungstenite::{Message, WebSocket};

use super::server::Server;

fn serve() -> (tempfile::TempDir, Server) {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(folder.path(), &["spheres", "--width", "64", "--spp", "4"]);
    (folder, server)
}

fn connect(server: &Server) -> TcpStream {
    let stream = TcpStream::connect(server.host().replace("localhost", "127.0.0.1")).unwrap();
    stream.set_read_timeout(Some(Duration::from_secs(60))).unwrap();
    stream
}

/// The answer to a request with these header lines.
fn answer(server: &Server, target: &str, lines: &[(&str, &str)]) -> String {
    let mut stream = connect(server);
    let lines: String = lines.iter().map(|(name, value)| format!("{name}: {value}\r\n")).collect();
    // What is too long is refused before its end.
    let _ = write!(stream, "GET {target} HTTP/1.1\r\n{lines}\r\n");
    let mut answer = Vec::new();
    let mut bytes = [0; 1024];
    // Up to the end of the head: a WebSocket stays open.
    while !answer.windows(4).any(|end| end == b"\r\n\r\n") {
        match stream.read(&mut bytes) {
            Ok(read) if read > 0 => answer.extend(&bytes[..read]),
            _ => break,
        }
    }
    String::from_utf8_lossy(&answer).into_owned()
}

/// A WebSocket, as the page has one.
fn live(server: &Server) -> WebSocket<TcpStream> {
    let mut stream = connect(server);
    let (host, token, key) = (server.host(), server.token(), generate_key());
    write!(
        stream,
        "GET /live?token={token} HTTP/1.1\r\nHost: {host}\r\nOrigin: http://{host}\r\nUpgrade: websocket\r\n\
         Connection: Upgrade\r\nSec-WebSocket-Version: 13\r\nSec-WebSocket-Key: {key}\r\n\r\n"
    )
    .unwrap();
    let mut head = Vec::new();
    while !head.ends_with(b"\r\n\r\n") {
        let mut byte = [0];
        stream.read_exact(&mut byte).unwrap();
        head.push(byte[0]);
    }
    assert!(head.starts_with(b"HTTP/1.1 101"), "{}", String::from_utf8_lossy(&head));
    WebSocket::from_raw_socket(stream, Role::Client, None)
}

/// A WebSocket, as soon as other connections have ended.
fn page_again(server: &Server) -> WebSocket<TcpStream> {
    let host = server.host();
    let page = format!("/?token={}", server.token());
    while !answer(server, &page, &[("Host", host)]).starts_with("HTTP/1.1 200") {
        std::thread::sleep(Duration::from_millis(20));
    }
    live(server)
}

/// Shows pictures until one has all samples, and returns their number.
fn pictures(socket: &mut WebSocket<TcpStream>) -> usize {
    for number in 1.. {
        let Message::Binary(message) = socket.read().unwrap() else { continue };
        socket.send(Message::text("\"shown\"")).unwrap();
        let length = u32::from_le_bytes(message[..4].try_into().unwrap()) as usize;
        let about: serde_json::Value = serde_json::from_slice(&message[4..4 + length]).unwrap();
        let (width, height) = (about["width"].as_u64().unwrap(), about["height"].as_u64().unwrap());
        assert_eq!(message.len() as u64, 4 + length as u64 + 4 * width * height);
        if about["hash"].is_string() {
            return number;
        }
    }
    unreachable!()
}

#[test]
fn only_pages_of_the_server_with_its_token_are_answered() {
    let (_folder, server) = serve();
    let (host, token) = (server.host(), server.token());
    let origin = format!("http://{host}");
    let page = format!("/?token={token}");
    let live = format!("/live?token={token}");
    let key = ("Sec-WebSocket-Key", "dGhlIHNhbXBsZSBub25jZQ==");
    let status = |target: &str, lines: &[(&str, &str)]| {
        answer(&server, target, lines).split(' ').nth(1).unwrap_or("none").to_owned()
    };
    assert_eq!(status(&page, &[("Host", host)]), "200");
    assert_eq!(status(&page, &[("Host", "127.0.0.1:1")]), "200", "through a tunnel");
    assert_eq!(status(&live, &[("Host", host), ("Origin", &origin), key]), "101");
    assert_eq!(status("/", &[("Host", host)]), "403");
    assert_eq!(status("/?token=00", &[("Host", host)]), "403");
    assert_eq!(status(&page, &[]), "400");
    assert_eq!(status(&page, &[("Host", "example.org")]), "421");
    assert_eq!(status(&live, &[("Host", host), key]), "403");
    assert_eq!(status(&live, &[("Host", host), ("Origin", "http://example.org"), key]), "403");
    assert_eq!(status("/live", &[("Host", host), ("Origin", &origin), key]), "403");
    assert_eq!(status(&format!("/../Cargo.toml?token={token}"), &[("Host", host)]), "404");
    let long = "a".repeat(10_000);
    assert_eq!(status(&page, &[("Host", host), ("Other", &long)]), "431");
}

#[test]
fn nobody_stalls_a_page_or_fills_memory() {
    let (_folder, server) = serve();
    let mut page = live(&server);
    pictures(&mut page);
    let before = server.memory();

    // Connections that say nothing.
    let mut silent: Vec<TcpStream> = (0..30).map(|_| connect(&server)).collect();
    // Pages that take no picture.
    let deaf: Vec<_> = (0..5).map(|_| live(&server)).collect();
    // A frame of a gigabyte is announced.
    let mut giant = live(&server);
    let header = [0x81, 0xff, 0, 0, 0, 0, 0x40, 0, 0, 0, 1, 2, 3, 4];
    giant.get_mut().write_all(&header).unwrap();
    // Half a frame.
    let mut half = live(&server);
    half.get_mut().write_all(&[0x81]).unwrap();
    // What the page never says.
    for wrong in [
        "",
        "{}",
        "[[[[",
        "{\"move\":{\"pan\":{\"right\":1e999,\"up\":0}}}",
        "{\"size\":[0,0]}",
        "{\"spp\":0}",
    ] {
        let mut wild = live(&server);
        wild.send(Message::text(wrong)).unwrap();
    }
    // More movements than can be shown, and pings.
    let mut flood = live(&server);
    flood.get_mut().set_write_timeout(Some(Duration::from_millis(200))).unwrap();
    for number in 0..20_000 {
        let message = match number % 10 {
            0 => Message::Ping(vec![0; 100].into()),
            _ => Message::text("{\"move\":{\"orbit\":{\"right\":1,\"up\":0}}}"),
        };
        match flood.send(message) {
            Ok(()) => {}
            // The server takes its time, which is what it should do.
            Err(tungstenite::Error::Io(error))
                if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut) =>
            {
                break;
            }
            Err(other) => panic!("{other}"),
        }
    }
    // The page still gets its pictures.
    for right in [10.0, -10.0] {
        let movement = format!("{{\"move\":{{\"orbit\":{{\"right\":{right},\"up\":0}}}}}}");
        page.send(Message::text(movement)).unwrap();
        pictures(&mut page);
    }
    let more = server.memory() - before;
    assert!(more < 64 << 20, "{more} bytes more");
    silent.iter_mut().for_each(|stream| drop(stream.shutdown(Shutdown::Both)));
    drop((deaf, giant, half, flood));
    // More than are served: the rest is closed at once.
    let many: Vec<TcpStream> = (0..200).map(|_| connect(&server)).collect();
    let is_closed = |mut stream: &TcpStream| {
        stream.set_read_timeout(Some(Duration::from_millis(20))).unwrap();
        match stream.read(&mut [0]) {
            Ok(read) => read == 0,
            Err(error) => error.kind() == ErrorKind::ConnectionReset,
        }
    };
    assert!(many.iter().filter(|stream| is_closed(stream)).count() > 100);
    drop(many);
    pictures(&mut page_again(&server));
}
